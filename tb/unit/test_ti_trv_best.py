# SPDX-License-Identifier: Apache-2.0
"""`ti_trv_best` keeps the least (t, primitive) of each slot, at a token a cycle."""

from itertools import permutations

import cocotb
import pytest
from agents.bench import run, start
from agents.way_home import NO_PRIM, Best, hit, miss, packed
from cocotb.triggers import ReadOnly, RisingEdge
from models.numbers import numbers
from models.payload import payloads


class Slots:
    """The ports of the unit for one cycle at a time, beside the rule of each slot."""

    def __init__(self, dut):
        self._dut = dut
        self._best = {}  # slot: its rule
        self._after = [None] * (int(dut.Latency.value) + 1)  # what tokens left, newest first
        # Slots of the tokens on their way, newest first.
        self._busy = [None] * (1 + 2 * int(dut.CmpStages.value))
        self._wants = None  # what the last read must show
        self.in_a_row = 0  # better hits behind a better hit of their slot
        self._last = None

    async def cycle(self, token=None, starts=None, read=None):
        """One clock cycle: (slot, token), (slot, tmin, tmax), slots to read (step, retirement)."""
        dut, after = self._dut, None
        dut.token_i.value, dut.start_i.value = int(token is not None), int(starts is not None)
        better = None
        if token is not None:
            slot, values = token
            dut.token_data_i.value = packed(slot, values)
            if self._best[slot].take(values):
                better = slot
                self.in_a_row += self._last == slot
            after = (self._best[slot].found, self._best[slot].t)
        self._last = better
        if starts is not None:
            slot, tmin, tmax = starts
            dut.start_slot_i.value = slot
            dut.start_tmin_i.value, dut.start_tmax_i.value = tmin, tmax
            self._best[slot] = Best(tmin, tmax)
        dut.tbest_read_i.value = dut.final_read_i.value = int(read is not None)
        if read:
            dut.tbest_slot_i.value, dut.final_slot_i.value = read
        await ReadOnly()
        self._after = [after, *self._after[:-1]]
        if self._after[-1] is not None:
            got = (dut.after_hit_o.value == 1, int(dut.after_t_o.value))
            assert got == self._after[-1], f"want {self._after[-1]}, got {got}"
        if self._wants is not None:
            self._check_reads(*self._wants)
        self._wants = [vars(self._best[slot]).copy() for slot in read] if read else None
        await RisingEdge(dut.clk_i)
        self._busy = [token[0] if token else None, *self._busy[:-1]]

    def _check_reads(self, step, final):
        """What was asked for one cycle before is there."""
        assert int(self._dut.tbest_o.value) == step["t"]
        got = payloads().unpack("best_t", int(self._dut.final_o.value))
        assert got["hit"] == (final["prim"] != NO_PRIM)
        if got["hit"]:
            assert {name: got[name] for name in ("t", "u", "v", "prim")} == {
                name: final[name] for name in ("t", "u", "v", "prim")
            }

    async def drain(self):
        """Until no token is on its way."""
        for _ in self._busy:
            await self.cycle()

    def quiet(self):
        """Slots with a ray and no token on its way."""
        return [slot for slot in self._best if slot not in self._busy]


def keys():
    """Equal, next to each other, of both signs at zero; the first is the least."""
    n = numbers()
    return [(0, 5), (n.sign, 9), (n.one, 0), (n.one, 7), (n.one + 1, 3)]


@cocotb.test()
async def hits_to_one_slot_in_a_row_leave_the_least_in_any_order(dut):
    """All orders of five, a token a cycle: what each leaves, and what is read at the end."""
    await start(dut)
    slots, n = Slots(dut), numbers()
    for order in permutations(keys()):
        await slots.cycle(starts=(0, 0, n.inf))
        for t, prim in order:
            await slots.cycle(token=(0, hit(t, prim)))
        await slots.drain()
        await slots.cycle(read=(0, 0))
        await slots.cycle()
        assert int(dut.tbest_o.value) & ~n.sign == 0
    assert slots.in_a_row > 90


@cocotb.test()
@cocotb.parametrize(between=["miss", "other", "worse", "nothing"])
async def a_better_hit_counts_for_the_token_after_the_next(dut, between):
    """Two tokens of a slot with a cycle between them: a miss, another slot's hit, a worse hit."""
    await start(dut)
    slots, n = Slots(dut), numbers()
    for first, last in permutations(keys(), 2):
        for slot in (0, 1):
            await slots.cycle(starts=(slot, 0, n.inf))
        middle = {
            "miss": (0, miss()),
            "other": (1, hit(n.one - 1, 4)),
            "worse": (0, hit(n.of(2.0), 4)),
            "nothing": None,
        }[between]
        for token in ((0, hit(*first)), middle, (0, hit(*last))):
            await slots.cycle(token=token)
        await slots.drain()
        await slots.cycle()


@cocotb.test()
@cocotb.parametrize(p_token=[1.0, 0.7], spread=[2, 8])
async def tokens_starts_and_reads_go_on_at_once(dut, p_token, spread):
    """Any mixture against the rule, tokens often for the slot of the last one."""
    rng = await start(dut)
    slots, n = Slots(dut), numbers()
    count = int(dut.NumSlots.value)
    times = [0, n.sign, n.one - 1, n.one, n.one + 1, n.of(2.0), n.inf - 1, n.inf, n.sign | n.one]
    intervals = [(0, n.inf), (n.one, n.of(2.0)), (n.sign, n.one), (n.one, n.one), (0, 0)]
    for slot in range(count):
        await slots.cycle(starts=(slot, *rng.choice(intervals)))
    last = 0
    for _ in range(4000):
        token = starts = read = None
        quiet = slots.quiet()
        if rng.random() < p_token:
            last = last if rng.randrange(spread) else rng.randrange(count)
            values = hit(rng.choice(times), rng.choice((0, 1, 2, NO_PRIM - 1)))
            token = last, values if rng.random() < 0.8 else miss()
        others = [slot for slot in quiet if token is None or slot != token[0]]
        if others and rng.random() < 0.3:
            starts = (rng.choice(others), *rng.choice(intervals))
            others.remove(starts[0])
        if others and rng.random() < 0.2:
            read = rng.choice(others), rng.choice(others)
        await slots.cycle(token, starts, read)
    assert slots.in_a_row > 0


@cocotb.test()
async def a_read_for_retirement_stays_until_the_next(dut):
    """Whatever hits come meanwhile."""
    await start(dut)
    slots, n = Slots(dut), numbers()
    for slot in (0, 1):
        await slots.cycle(starts=(slot, 0, n.inf))
    await slots.cycle(token=(0, hit(n.one, 5)))
    await slots.drain()
    await slots.cycle(read=(0, 0))
    await slots.cycle()
    before = int(dut.final_o.value)
    assert payloads().unpack("best_t", before)["prim"] == 5
    for prim in range(9, 3, -1):
        await slots.cycle(token=(1, hit(n.one, prim)))
        assert int(dut.final_o.value) == before


@pytest.mark.parametrize(("slots", "cmp"), [(2, 0), (8, 0), (2, 1), (8, 1)])
def test_ti_trv_best(slots, cmp):
    params = {"NumSlots": slots, "CmpStages": cmp}
    run("ti_trv_best", "test_ti_trv_best", config=f"tiny trv_slots={slots}", params=params)
