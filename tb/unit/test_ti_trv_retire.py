# SPDX-License-Identifier: Apache-2.0
"""`ti_trv_retire` hands each slot that ends to the taker of hits once, its two kinds in turn."""

from itertools import pairwise

import cocotb
import pytest
from agents.bench import cycle, run, start
from agents.stream import Sink
from agents.way_home import MEMORY_ERROR, NO_PRIM, OK, WATCHDOG, done
from cocotb.triggers import ClockCycles, ReadOnly, RisingEdge
from models.numbers import numbers
from models.payload import parameter, payloads

KINDS = ("ended", "done")


def best_of(slot, age):
    """The best hit of a slot's ray; every third has none."""
    key = 7 * age + slot
    return {"hit": int(key % 3 > 0), "t": key & 63, "u": slot, "v": 1, "prim": key}


class Rays:
    """The rays of the slots, and the memory of best hits: it answers one cycle later."""

    def __init__(self, dut):
        self._dut = dut
        self.slots = int(dut.NumSlots.value)
        self._age = [0] * self.slots
        self._any_hit = [0] * self.slots
        self.freed = []
        cocotb.start_soon(self._answer())

    async def _answer(self):
        dut = self._dut
        while True:
            await ReadOnly()
            slot = int(dut.final_slot_o.value) if dut.final_read_o.value == 1 else None
            if dut.free_o.value == 1:
                self.freed.append(int(dut.free_slot_o.value))
            await RisingEdge(dut.clk_i)
            if slot is not None:
                best = best_of(slot, self._age[slot])
                dut.final_i.value = payloads().pack("best_t", best)

    async def start(self, slot, any_hit=0):
        """A new ray."""
        dut = self._dut
        self._age[slot] += 1
        self._any_hit[slot] = any_hit
        dut.start_slot_i.value, dut.start_any_hit_i.value = slot, any_hit
        dut.start_ray_id_i.value, dut.start_i.value = self._id(slot), 1
        await RisingEdge(dut.clk_i)
        dut.start_i.value = 0

    def _id(self, slot):
        return self._age[slot] << 8 | slot

    async def park(self, slot, steps):
        dut = self._dut
        dut.stop_slot_i.value, dut.stop_steps_i.value, dut.park_i.value = slot, steps, 1
        await RisingEdge(dut.clk_i)
        dut.park_i.value = 0

    def end(self, kind, slot, *, status=OK, steps=0):
        """Put the end of a slot on the port of its kind; the hit that it must become."""
        dut = self._dut
        if kind == "done":
            done(dut, slot, status, steps)
        else:
            dut.ended_slot_i.value, dut.ended_i.value = slot, 1
            dut.ended_error_i.value = int(status == MEMORY_ERROR)
        best = best_of(slot, self._age[slot])
        want = {"ray_id": self._id(slot), "status": status, "steps": steps, "hit": best["hit"]}
        if status != OK or not best["hit"]:
            return {**want, "hit": 0, "prim": NO_PRIM, "t": numbers().inf, "u": 0, "v": 0}
        if self._any_hit[slot]:
            return {**want, "prim": 0, "t": 0, "u": 0, "v": 0}
        return {**best, **want}

    def clear(self):
        self._dut.done_i.value = self._dut.ended_i.value = 0


@cocotb.test()
@cocotb.parametrize(p_ready=[1.0, 0.3, 0.05], p_end=[1.0, 0.1])
async def every_slot_that_ends_comes_out_once_in_the_order_of_its_kind(dut, p_ready, p_end):
    """Both kinds at once, all statuses, hits and none; the slot is free when its hit is taken."""
    rng = await start(dut)
    rays, sink = Rays(dut), Sink(dut, "hit")
    waiting, free = {kind: [] for kind in KINDS}, list(range(rays.slots))
    hits = 0

    async def take():
        nonlocal hits
        while True:
            [beat] = await sink.receive(1, lambda: rng.random() < p_ready)
            got = payloads().unpack("hit_t", beat)
            kind = next((k for k in KINDS if waiting[k] and waiting[k][0] == got), None)
            assert kind is not None, f"{got} is not next in {waiting}"
            waiting[kind].pop(0)
            slot = rays.freed.pop(0)
            assert slot == got["ray_id"] & 255 and not rays.freed
            free.append(slot)
            hits += 1

    cocotb.start_soon(take())
    walking, parked = [], []
    while hits < 400:
        if free and rng.random() < 0.7:
            slot = free.pop(rng.randrange(len(free)))
            await rays.start(slot, rng.getrandbits(1) & parameter("AnyHit", 1))
            steps = rng.getrandbits(16)
            if rng.random() < 0.5:
                await rays.park(slot, steps)
                parked.append((slot, steps))
            else:
                walking.append(slot)
            continue
        new = []
        if parked and rng.random() < p_end:
            slot, steps = parked.pop()
            status = rng.choice((OK, OK, MEMORY_ERROR))
            new.append(("ended", rays.end("ended", slot, status=status, steps=steps)))
        if walking and rng.random() < p_end:
            status, steps = rng.choice((OK, OK, MEMORY_ERROR, WATCHDOG)), rng.getrandbits(16)
            new.append(("done", rays.end("done", walking.pop(), status=status, steps=steps)))
        await RisingEdge(dut.clk_i)
        rays.clear()
        for kind, want in new:
            waiting[kind].append(want)


@cocotb.test()
@cocotb.parametrize(kind=KINDS)
async def a_hit_comes_after_its_latency_and_one_each_cycle(dut, kind):
    await start(dut)
    rays, latency = Rays(dut), int(dut.Latency.value)
    for slot in range(rays.slots):
        await rays.start(slot)
    dut.hit_ready_i.value = 1
    asked, came = [], []
    for at in range(rays.slots + 10):
        rays.clear()
        if at < rays.slots:
            rays.end(kind, at)
            asked.append(cycle())
        await ReadOnly()
        if dut.hit_valid_o.value == 1:
            came.append(cycle())
            assert int(dut.free_slot_o.value) == len(came) - 1
        await RisingEdge(dut.clk_i)
    assert came == [at + latency for at in asked]


@cocotb.test()
async def neither_kind_waits_for_more_than_one_of_the_other(dut):
    """Half of the slots wait in each queue behind a hit that is not taken."""
    await start(dut)
    rays, half = Rays(dut), int(dut.NumSlots.value) // 2
    for slot in range(rays.slots):
        await rays.start(slot)
    kind_of = {}
    for slot in range(half):
        rays.end("ended", slot)
        rays.end("done", half + slot)
        kind_of.update({slot: "ended", half + slot: "done"})
        await RisingEdge(dut.clk_i)
    rays.clear()
    await ClockCycles(dut.clk_i, 5)
    hits = [payloads().unpack("hit_t", bits) for bits in await Sink(dut, "hit").receive(rays.slots)]
    order = [kind_of[h["ray_id"] & 255] for h in hits]
    assert all(a != b for a, b in pairwise(order)), order


@cocotb.test()
@cocotb.parametrize(kind=KINDS)
async def all_slots_of_a_kind_find_room_behind_a_hit_that_waits(dut, kind):
    await start(dut)
    rays = Rays(dut)
    for slot in range(rays.slots):
        await rays.start(slot)
    wants = []
    for slot in range(rays.slots):
        wants.append(rays.end(kind, slot))
        await RisingEdge(dut.clk_i)
        rays.clear()
    await ClockCycles(dut.clk_i, 20)
    assert rays.freed == []
    sink = Sink(dut, "hit")
    assert [payloads().unpack("hit_t", b) for b in await sink.receive(rays.slots)] == wants
    assert rays.freed == list(range(rays.slots))


@pytest.mark.parametrize(("slots", "any_hit"), [(8, 0), (2, 1), (8, 1)])
def test_ti_trv_retire(slots, any_hit):
    params = {"NumSlots": slots, "AnyHit": any_hit}
    run("ti_trv_retire", "test_ti_trv_retire", config=f"tiny trv_slots={slots}", params=params)
