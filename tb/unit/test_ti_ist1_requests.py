# SPDX-License-Identifier: Apache-2.0
"""`ti_ist1_requests` asks once for each part, at its address, in order and in turn."""

from collections import deque

import cocotb
import pytest
from agents.bench import consecutive, cycle, run, start
from cocotb.triggers import ReadOnly, RisingEdge
from models.payload import configuration

PLANE, BARY = 0x1000, 0x8000
KINDS = ("plane", "bary")


class Around:
    """The unit around: each test asks for its plane part, goes on, asks for the other, and is over.

    `takes()` and `goes()` say whether a test comes and one goes on in a cycle, `ready()` is the
    ready bit.  `seen` lists (kind, cycle) of all requests, `waited` the most requests of the other
    kind that went in front of one while it stood first.
    """

    def __init__(self, dut, rng, takes, goes, ready):
        self._dut, self._rng = dut, rng
        self._takes, self._goes, self._ready = takes, goes, ready
        self._free = list(range(int(dut.NumSlots.value)))
        self._mask = (1 << configuration()["addr_bits"]) - 1
        self._records = {}
        self._asked = {kind: deque() for kind in KINDS}
        self._passed = dict.fromkeys(KINDS, 0)
        self._fetched = []  # slots whose plane part was asked for
        self.waited = dict.fromkeys(KINDS, 0)
        self.seen, self.taken = [], []
        dut.plane_base_i.value, dut.bary_base_i.value = PLANE, BARY

    async def play(self, tests):
        """Until `tests` tests have asked for both parts."""
        dut, left = self._dut, tests
        while left or len(self._free) < int(dut.NumSlots.value):
            take = bool(left and self._free and self._takes())
            go = bool(self._fetched and self._goes())
            if take:
                slot = self._free.pop(self._rng.randrange(len(self._free)))
                record = self._records[slot] = self._rng.getrandbits(10)
                dut.take_slot_i.value, dut.record_i.value = slot, record
                left -= 1
            if go:
                on = self._fetched.pop(self._rng.randrange(len(self._fetched)))
                dut.go_on_slot_i.value = on
            dut.take_i.value, dut.go_on_i.value = int(take), int(go)
            dut.req_ready_i.value = int(self._ready())
            await ReadOnly()
            self._see()
            await RisingEdge(dut.clk_i)
            if take:
                self._asked["plane"].append(slot)
                self.taken.append(cycle() - 1)
            if go:
                self._asked["bary"].append(on)

    def _see(self):
        dut = self._dut
        if not (dut.req_valid_o.value and dut.req_ready_i.value):
            return
        slot, addr = int(dut.req_slot_o.value), int(dut.req_addr_o.value)
        kind = next((k for k in KINDS if self._asked[k] and self._asked[k][0] == slot), None)
        assert kind, f"slot {slot} stands first in no queue: {self._asked}"
        other = KINDS[1 - KINDS.index(kind)]
        self._asked[kind].popleft()
        self._passed[kind] = 0
        if self._asked[other]:
            self._passed[other] += 1
            self.waited[other] = max(self.waited[other], self._passed[other])
        self.seen.append((kind, cycle()))
        record = self._records[slot]
        want = PLANE + 32 * record if kind == "plane" else BARY + 16 * record
        assert addr == want & self._mask, f"{kind} part of {record}: {addr:#x}, must be {want:#x}"
        if kind == "plane":
            self._fetched.append(slot)
        else:
            self._free.append(slot)


@cocotb.test()
@cocotb.parametrize(p_take=[0.3, 1.0], p_ready=[0.3, 1.0])
async def asks_once_for_each_part(dut, p_take, p_ready):
    rng = await start(dut)
    tests = Around(
        dut,
        rng,
        takes=lambda: rng.random() < p_take,
        goes=lambda: rng.random() < 0.5,
        ready=lambda: rng.random() < p_ready,
    )
    await tests.play(200)

    assert sorted(kind for kind, _ in tests.seen) == ["bary"] * 200 + ["plane"] * 200


@cocotb.test()
async def asks_two_cycles_after_a_test_and_one_a_cycle(dut):
    rng = await start(dut)
    many = int(dut.NumSlots.value)
    tests = Around(
        dut, rng, takes=lambda: True, goes=lambda: len(tests.seen) >= many, ready=lambda: True
    )
    await tests.play(many)

    first = [at for _, at in tests.seen[:many]]
    assert first[0] - tests.taken[0] == 2 and consecutive(first)


@cocotb.test()
async def neither_kind_waits_for_more_than_the_requests_on_their_way_out(dut):
    """Two stand in the output queue of the arbiter; behind them the kinds take turns."""
    rng = await start(dut)
    tests = Around(
        dut,
        rng,
        takes=lambda: True,
        goes=lambda: True,
        ready=lambda: rng.random() < 0.5,
    )
    await tests.play(300)

    assert max(tests.waited.values()) <= 3


@cocotb.test()
async def knows_which_part_a_slot_has_asked_for(dut):
    await start(dut)
    for slot, record in ((0, 6), (1, 7)):
        dut.take_i.value, dut.take_slot_i.value, dut.record_i.value = 1, slot, record
        await RisingEdge(dut.clk_i)
    dut.take_i.value, dut.go_on_i.value, dut.go_on_slot_i.value = 0, 1, 1
    await RisingEdge(dut.clk_i)
    dut.go_on_i.value = 0
    for slot, (pass_b, odd) in enumerate(((0, 0), (1, 1))):
        dut.slot_i.value = slot
        await ReadOnly()
        assert (int(dut.pass_b_o.value), int(dut.odd_o.value)) == (pass_b, odd)
        await RisingEdge(dut.clk_i)


@pytest.mark.parametrize("slots", [2, 8])
def test_ti_ist1_requests(slots):
    run("ti_ist1_requests", "test_ti_ist1_requests", NumSlots=slots)
