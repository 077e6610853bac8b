# SPDX-License-Identifier: Apache-2.0
"""`ti_trv_visits` lets each slot visit its node once, one a cycle, and serves its kinds in turn."""

from collections import deque
from itertools import pairwise

import cocotb
import pytest
from agents.bench import cycle, run, start
from agents.stream import Sink
from cocotb.triggers import ReadOnly, RisingEdge

ROOT = 77
KINDS = ("step", "resume", "start")


class Visits(Sink):
    """The port of visits: slot and node stand side by side."""

    def __init__(self, dut):
        self._clk, self._name, self._waiting = dut.clk_i, "visit", None
        self.valid, self.ready = dut.visit_valid_o, dut.visit_ready_i
        self.data = self
        self._dut = dut

    @property
    def value(self):
        return int(self._dut.visit_slot_o.value) << 29 | int(self._dut.visit_node_o.value)


def request(dut, rng, kind, slot):
    """Put a request on its port; the visit that it must become."""
    node = ROOT if kind == "start" else rng.getrandbits(29)
    getattr(dut, f"{kind}_i").value = 1
    getattr(dut, f"{kind}_slot_i").value = slot
    if kind != "start":
        getattr(dut, f"{kind}_node_i").value = node
    return slot << 29 | node


def clear(dut):
    for kind in KINDS:
        getattr(dut, f"{kind}_i").value = 0


async def setup(dut):
    rng = await start(dut)
    dut.root_i.value = ROOT
    return rng, int(dut.NumSlots.value)


@cocotb.test()
@cocotb.parametrize(p_request=[1.0, 0.2], p_ready=[1.0, 0.3])
async def every_request_becomes_one_visit_in_the_order_of_its_kind(dut, p_request, p_ready):
    rng, slots = await setup(dut)
    free, waiting = set(range(slots)), {kind: deque() for kind in KINDS}
    visits, count = 0, 1000
    sink = Visits(dut)

    async def requests():
        for _ in range(100_000):
            clear(dut)
            new = []
            for kind in KINDS:
                if free and rng.random() < p_request:
                    slot = rng.choice(sorted(free))
                    free.remove(slot)
                    new.append((kind, request(dut, rng, kind, slot)))
            await RisingEdge(dut.clk_i)
            for kind, visit in new:
                waiting[kind].append(visit)

    cocotb.start_soon(requests())
    while visits < count:
        [visit] = await sink.receive(1, lambda: rng.random() < p_ready, patience=1000)
        kind = next((k for k in KINDS if waiting[k] and waiting[k][0] == visit), None)
        assert kind is not None, f"{visit:#x} is not next in {waiting}"
        waiting[kind].popleft()
        free.add(visit >> 29)
        visits += 1


@cocotb.test()
@cocotb.parametrize(kind=KINDS)
async def a_visit_comes_the_cycle_after_its_request_or_one_later_for_a_start(dut, kind):
    """One each cycle."""
    rng, slots = await setup(dut)
    dut.visit_ready_i.value = 1
    asked, came = [], []
    for at in range(100):
        clear(dut)
        if at < 60:
            request(dut, rng, kind, at % slots)
            asked.append(cycle())
        await ReadOnly()
        if dut.visit_valid_o.value == 1:
            came.append(cycle())
        await RisingEdge(dut.clk_i)

    latency = int(dut.VisitLatency.value) + (kind == "start")  # through the queue of starts
    assert came == [at + latency for at in asked]


@cocotb.test()
async def the_kinds_are_served_in_turn(dut):
    """All wait behind an output that is closed; none sees more than two of others go first."""
    rng, slots = await setup(dut)
    kind_of, order = {}, []
    for slot in range(slots):
        clear(dut)
        kind = ("step", "step", "resume", "start")[slot % 4]
        kind_of[request(dut, rng, kind, slot)] = kind
        await RisingEdge(dut.clk_i)
    clear(dut)

    order = [kind_of[visit] for visit in await Visits(dut).receive(slots)]

    for kind in KINDS:  # two were at the output before the others came
        places = [-1, *(i for i, k in enumerate(order[2:]) if k == kind)]
        assert all(b - a <= 3 for a, b in pairwise(places)), order
    assert [order.count(kind) for kind in KINDS] == [slots // 2, slots // 4, slots // 4]


@cocotb.test()
@cocotb.parametrize(flows=["step", "resume"], lone=KINDS)
async def a_kind_that_comes_in_every_cycle_leaves_the_others_their_turn(dut, flows, lone):
    """One that goes past empty queues goes past nobody who waits."""
    if flows == lone:
        return
    rng, slots = await setup(dut)
    dut.visit_ready_i.value = 1
    free, asked, waits = list(range(slots - 1)), None, []
    for at in range(200):
        clear(dut)
        if free:
            request(dut, rng, flows, free.pop(0))
        if at % 9 == 8 and at < 190:
            request(dut, rng, lone, slots - 1)
            asked = cycle()
        await ReadOnly()
        if dut.visit_valid_o.value == 1:
            slot = int(dut.visit_slot_o.value)
            if slot == slots - 1:
                waits.append(cycle() - asked)
            else:
                free.append(slot)
        else:
            assert at < 2
        await RisingEdge(dut.clk_i)

    soonest = int(dut.VisitLatency.value) + (lone == "start")
    assert len(waits) == 21 and set(waits) <= {soonest, soonest + 1, soonest + 2}


@pytest.mark.parametrize("slots", [4, 16])
def test_ti_trv_visits(slots):
    config = f"tiny trv_slots={slots}"
    run("ti_trv_visits", "test_ti_trv_visits", config=config, NumSlots=slots)
