# SPDX-License-Identifier: Apache-2.0
"""`ti_kd_state` gives each slot its state just in time, and the newest entries of its stack."""

from dataclasses import dataclass, field

import cocotb
import pytest
from agents.bench import run, start
from cocotb.triggers import ReadOnly, RisingEdge
from models.numbers import numbers

STEPS_MAX = (1 << 16) - 1
TRAIL_BITS = 71  # ti_kd_pkg::trail_t
TOP, THICK = ("top_node", "top_tmax"), ("trail", "dropped_from", "top_tmin", "oldest_tmin")


@dataclass
class Slot:
    """What must be remembered of a ray; the stack has no end, `level` of its entries count.

    Of a thick ray also its trail, the t of what was dropped, and a tmin of each entry.
    """

    tmin: int
    tmax: int
    ray_tmax: int
    index: int = 0
    steps: int = 0
    level: int = 0
    dropped: int = 0
    stack: list = field(default_factory=list)  # (node, tmax, tmin)
    trail: int = 0
    dropped_from: int = field(default_factory=lambda: numbers().inf)

    def outputs(self, depth):
        """By port; the top means nothing while the stack is empty, the oldest until it is full."""
        names = ("index", "tmin", "tmax", "ray_tmax", "steps", "level", "dropped")
        node, tmax, tmin = self.stack[-1] if self.level else (None, None, None)
        oldest = self.stack[-depth][2] if self.level == depth > 0 else None
        thick = (self.trail, self.dropped_from, tmin, oldest)
        return {k: getattr(self, k) for k in names} | dict(
            zip((*TOP, *THICK), (node, tmax, *thick), strict=True)
        )


class State:
    """Slots that start, visit, step and end at random around the unit, and a model of each.

    A cycle may have a start, a visit, a step and an end; `busy` is the probability of the first
    three.  `checked` counts ends, `deepest` is the longest stack, `full` the pushes onto a
    full one, which only a unit whose rays restart is given.
    """

    def __init__(self, dut, rng, busy, p_push, p_new=0.05):
        self._dut, self._rng, self._busy, self._p_push, self._p_new = dut, rng, busy, p_push, p_new
        self._restart, self._thick = int(dut.Restart.value), int(dut.Padded.value)
        self._depth, self._lead = int(dut.StackDepth.value), int(dut.Lead.value)
        self._end = self._lead + int(dut.Lag.value)
        self._slots = {}
        self._fresh = list(range(int(dut.NumSlots.value)))
        self._visits, self._steps = [], []  # slots whose next that is
        self._pipe = [None] * (self._end + 1)  # slots in the arithmetic, the last to end
        self.checked = self.deepest = self.full = self.popped_after_full = 0

    async def run(self, cycles):
        for _ in range(cycles):
            started, visited = self._start(), self._visit()
            stepped = self._step()
            self._pipe = [stepped, *self._pipe[:-1]]
            late, shown = self._pipe[self._lead - 1], self._pipe[self._lead]
            was = self._slots[shown].outputs(self._depth) if shown is not None else None
            ends = self._pipe[self._end]
            self._dut.end_valid_i.value = int(ends is not None)
            if ends is not None:
                self._dut.end_slot_i.value = ends
                self._decide(ends)
            await ReadOnly()
            assert self._dut.late_valid_o.value == (late is not None)
            assert late is None or self._dut.late_slot_o.value == late
            if shown is not None:
                self._check(shown, was)
            await RisingEdge(self._dut.clk_i)
            if ends is not None:
                (self._fresh if ends not in self._slots else self._visits).append(ends)
            if started is not None:
                self._visits.append(started)
            if visited is not None:
                self._steps.append(visited)

    def _pick(self, waiting):
        if not waiting or self._rng.random() >= self._busy:
            return None
        return waiting.pop(self._rng.randrange(len(waiting)))

    def _start(self):
        slot, n, rng = self._pick(self._fresh), numbers(), self._rng
        self._dut.start_i.value = int(slot is not None)
        if slot is not None:
            tmin, tmax = (rng.getrandbits(n.width) for _ in range(2))
            self._slots[slot] = Slot(tmin, tmax, tmax)
            self._dut.start_slot_i.value = slot
            self._dut.start_tmin_i.value, self._dut.start_tmax_i.value = tmin, tmax
        return slot

    def _visit(self):
        slot = self._pick(self._visits)
        self._dut.visit_i.value = int(slot is not None)
        if slot is not None:
            self._slots[slot].index = self._rng.getrandbits(29)
            self._dut.visit_slot_i.value = slot
            self._dut.visit_node_i.value = self._slots[slot].index
        return slot

    def _step(self):
        slot = self._pick(self._steps)
        self._dut.step_valid_i.value = int(slot is not None)
        if slot is not None:
            self._dut.step_slot_i.value = slot
        return slot

    def _decide(self, slot):
        """The next state of the slot that ends in this cycle."""
        dut, rng, n = self._dut, self._rng, numbers()
        ray = self._slots[slot]
        room = ray.level < self._depth or self._restart
        push = rng.random() < self._p_push and room
        pop = not push and ray.level > 0 and rng.random() < 0.8
        far, tmin, tmax = rng.getrandbits(29), rng.getrandbits(n.width), rng.getrandbits(n.width)
        far_tmin = rng.getrandbits(n.width)
        if push:
            ray.stack.append((far, ray.tmax, far_tmin))
            self.full += ray.level == self._depth
            ray.level = min(ray.level + 1, self._depth)
        elif pop:
            self.popped_after_full += len(ray.stack) > self._depth
            ray.stack.pop()
            ray.level -= 1
        elif rng.random() < 0.1:  # a restart: nothing is left
            ray.stack, ray.level = [], 0
        self.deepest = max(self.deepest, ray.level)
        ray.tmin, ray.tmax, ray.steps = tmin, tmax, rng.randint(0, STEPS_MAX)
        ray.dropped = rng.getrandbits(1) & self._restart
        ray.trail, ray.dropped_from = rng.getrandbits(TRAIL_BITS), rng.getrandbits(n.width)
        for name in ("tmin", "tmax", "steps", "level", "dropped", "trail", "dropped_from"):
            getattr(dut, f"{name}_i").value = getattr(ray, name)
        dut.push_i.value, dut.pop_i.value, dut.far_i.value = int(push), int(pop), far
        dut.far_tmin_i.value = far_tmin
        if rng.random() < self._p_new:
            del self._slots[slot]

    def _check(self, slot, was):
        got = {name: int(getattr(self._dut, f"{name}_o").value) for name in was}
        want = {k: got[k] if v is None else v for k, v in was.items()}
        if not self._thick:
            want |= dict.fromkeys(THICK, 0)
        elif not self._restart:
            want["oldest_tmin"] = 0  # nothing is dropped
        assert got == want, f"slot {slot}: want {want}, got {got}"
        self.checked += 1


@cocotb.test()
@cocotb.parametrize(busy=[1.0, 0.4], p_push=[0.3, 0.5, 0.7])
async def remembers_each_slot_and_the_newest_entries_of_its_stack(dut, busy, p_push):
    rng = await start(dut)
    state = State(dut, rng, busy, p_push)

    await state.run(3000)

    depth, restart = int(dut.StackDepth.value), bool(dut.Restart.value)
    assert state.deepest == depth and (state.full > 0) == restart
    if restart and p_push >= 0.5:  # the stack is full much of the time
        assert state.full > 10 and (depth <= 1 or state.popped_after_full > 10)
    assert state.checked > 100


@cocotb.test()
async def gives_a_state_in_every_cycle(dut):
    """As many slots as fill the steps around it, none of them ever retires."""
    rng = await start(dut)
    state = State(dut, rng, busy=1.0, p_push=0.5, p_new=0.0)
    slots, lead = int(dut.NumSlots.value), int(dut.Lead.value) + int(dut.Lag.value)
    await state.run(slots + 2 * lead)
    before = state.checked

    await state.run(500)

    # A slot is back after its visit, its step, `Lead` and `Lag` cycles and its end.
    assert state.checked - before >= min(500, 500 * slots // (lead + 3)) - 1


@cocotb.test()
async def forgets_what_is_inside_on_reset(dut):
    """No slot that was in the arithmetic comes out of a short reset."""
    await start(dut)
    lead = int(dut.Lead.value)
    dut.step_valid_i.value = 1
    for _ in range(lead + 2):
        await RisingEdge(dut.clk_i)
    dut.step_valid_i.value = 0
    dut.rst_ni.value = 0
    await RisingEdge(dut.clk_i)
    dut.rst_ni.value = 1

    for _ in range(lead + 2):
        await ReadOnly()
        assert dut.late_valid_o.value == 0
        await RisingEdge(dut.clk_i)


@pytest.mark.parametrize(
    "params",
    [
        {"NumSlots": 8, "StackDepth": 1, "Restart": 0, "Lead": 7},
        {"NumSlots": 8, "StackDepth": 3, "Restart": 0, "Lead": 7},
        {"NumSlots": 16, "StackDepth": 4, "Restart": 0, "Lead": 3},
        {"NumSlots": 8, "StackDepth": 0, "Lead": 5},
        {"NumSlots": 4, "StackDepth": 1, "Lead": 3},
        {"NumSlots": 8, "StackDepth": 3, "Lead": 7},
        {"NumSlots": 16, "StackDepth": 4, "Lead": 7},
        {"NumSlots": 8, "StackDepth": 3, "Lead": 7, "Lag": 1},
        {"NumSlots": 8, "StackDepth": 3, "Restart": 0, "Lead": 3, "Lag": 1},
        {"NumSlots": 8, "StackDepth": 3, "Lead": 7, "Padded": 1},
        {"NumSlots": 8, "StackDepth": 3, "Restart": 0, "Lead": 3, "Lag": 1, "Padded": 1},
        {"NumSlots": 4, "StackDepth": 0, "Lead": 5, "Padded": 1},
    ],
    ids=[
        *("1-full", "3-full", "4-full", "0", "1", "3", "4", "3-later", "3-full-later"),
        *("3-thick", "3-full-thick", "0-thick"),
    ],
)
def test_ti_kd_state(params):
    config = f"tiny trv_slots={params['NumSlots']}"
    run("ti_kd_state", "test_ti_kd_state", config=config, params=params)
