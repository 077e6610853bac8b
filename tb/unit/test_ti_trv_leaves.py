# SPDX-License-Identifier: Apache-2.0
"""`ti_trv_leaves` sends each leaf once, in order, with the operands of the ray in its slot."""

import cocotb
import pytest
from agents.bench import cycle, run, start
from agents.stream import Sink
from cocotb.triggers import ReadOnly, RisingEdge
from models.numbers import numbers
from models.payload import payloads

INDEX = 1


def put_ray(dut, rng, slot):
    """A ray takes the slot in this cycle; its operands."""
    operands = {"o": numbers().any_vec(rng), "d": numbers().any_vec(rng)}
    dut.start_i.value, dut.start_slot_i.value = 1, slot
    dut.start_operands_i.value = payloads().pack("ray_operands_t", operands)
    return operands


def push(dut, rng, slot, operands):
    """The slot reaches a leaf in this cycle; the beat that must come."""
    values = {
        "first": rng.getrandbits(32),
        "count": rng.randrange(1, 1 << 16),
        "tnear": numbers().any(rng),
        "tfar": numbers().any(rng),
    }
    dut.push_i.value, dut.push_slot_i.value = 1, slot
    for name, value in values.items():
        getattr(dut, f"push_{name}_i").value = value
    home = {"trv": INDEX, "slot": slot}
    return payloads().pack("leaf_t", values, home=home, operands=operands)


async def setup(dut):
    """All slots hold a ray; the random source and their operands."""
    rng = await start(dut)
    dut.index_i.value = INDEX
    operands = []
    for slot in range(int(dut.NumSlots.value)):
        operands.append(put_ray(dut, rng, slot))
        await RisingEdge(dut.clk_i)
    dut.start_i.value = 0
    return rng, operands


@cocotb.test()
@cocotb.parametrize(p_push=[1.0, 0.2], p_ready=[1.0, 0.3], p_start=[0.0, 0.5])
async def sends_every_leaf_once_and_in_order(dut, p_push, p_ready, p_start):
    """While others reach a leaf, slots whose leaf has gone get a new ray."""
    rng, operands = await setup(dut)
    free, want = set(range(len(operands))), []

    async def home():
        while True:
            dut.push_i.value = dut.start_i.value = 0
            pushed = None
            if free and rng.random() < p_push:
                pushed = rng.choice(sorted(free))
                free.remove(pushed)
                want.append(push(dut, rng, pushed, operands[pushed]))
            if free and rng.random() < p_start:
                slot = rng.choice(sorted(free))
                operands[slot] = put_ray(dut, rng, slot)
            await RisingEdge(dut.clk_i)

    cocotb.start_soon(home())
    sink = Sink(dut, "leaf")
    for i in range(600):
        [bits] = await sink.receive(1, lambda: rng.random() < p_ready, patience=1000)
        assert bits == want[i], payloads().unpack("leaf_t", bits)
        free.add(payloads().unpack("leaf_t", bits)["home"]["slot"])


@cocotb.test()
async def a_leaf_takes_two_cycles_and_one_goes_each_cycle(dut):
    rng, operands = await setup(dut)
    dut.leaf_ready_i.value = 1
    pushed, came = [], []
    for at in range(100):
        dut.push_i.value = 0
        if at < 60:
            push(dut, rng, at % len(operands), operands[at % len(operands)])
            pushed.append(cycle())
        await ReadOnly()
        if dut.leaf_valid_o.value == 1:
            came.append(cycle())
        await RisingEdge(dut.clk_i)

    assert came == [at + 2 for at in pushed]


@pytest.mark.parametrize("slots", [4, 16])
def test_ti_trv_leaves(slots):
    config = f"tiny num_trv=2 trv_slots={slots}"
    run("ti_trv_leaves", "test_ti_trv_leaves", config=config, NumSlots=slots)
