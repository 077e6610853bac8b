# SPDX-License-Identifier: Apache-2.0
"""`ti_trv_return` keeps the best hit of each slot and ends each ray once, when it must."""

from dataclasses import dataclass, field
from itertools import pairwise

import cocotb
import pytest
from agents.bench import cycle, run, start
from agents.stream import Sink, Source
from cocotb.queue import Queue
from cocotb.triggers import ClockCycles, Lock, ReadOnly, RisingEdge
from models.numbers import numbers
from models.payload import payloads

OK, MEMORY_ERROR, WATCHDOG = 0, 2, 3
NO_PRIM = (1 << 32) - 1


@dataclass
class Leaf:
    """Tokens are dicts of return_t without the home; their counts add up to that of the leaf."""

    tokens: list
    bound: int
    go: int = 1
    next: int = 1
    restart: int = 0
    steps: int = 1


@dataclass
class Story:
    """A ray: its leaves, then perhaps `done` = (status, steps)."""

    leaves: list
    done: tuple = (OK, 9)
    tmin: int = 0
    tmax: int = field(default_factory=lambda: numbers().inf)
    any_hit: int = 0
    ray_id: int = 0


def hit(t, prim):
    """The same triangle has the same u and v each time."""
    return {"count": 1, "hit": 1, "t": t, "prim": prim, "u": prim & 255, "v": prim + 1 & 255}


def miss(count=1, error=0):
    return {"count": count, "error": error}


class Expected:
    """The rules: what a story comes to."""

    def __init__(self, story):
        self.resumes = []  # (node, restart)
        self._best = (story.tmax, 0, 0, NO_PRIM)
        steps, status = story.done[1], story.done[0]
        for leaf in story.leaves:
            error = any(token.get("error") for token in leaf.tokens)
            for token in leaf.tokens:
                if token.get("hit"):
                    self._accept(token, story)
            if error or not leaf.go or self._ends(story, leaf):
                steps, status = leaf.steps, MEMORY_ERROR if error else OK
                break
            self.resumes.append((leaf.next, leaf.restart))
        self.hit = self._report(story, status, steps)

    def _accept(self, token, story):
        n, best = numbers(), self._best
        t, key = token["t"], (token["t"], token["u"], token["v"], token["prim"])
        closer = n.less(t, best[0]) or (n.model("fp_eq", t, best[0]) and token["prim"] < best[3])
        if n.model("fp_le", story.tmin, t) and closer:
            self._best = key

    def _ends(self, story, leaf):
        found = self._best[3] != NO_PRIM
        return numbers().model("fp_le", self._best[0], leaf.bound) or (story.any_hit and found)

    def _report(self, story, status, steps):
        base = {"ray_id": story.ray_id, "status": status, "steps": steps}
        t, u, v, prim = self._best
        if prim == NO_PRIM or status != OK:
            return {**base, "hit": 0, "prim": NO_PRIM, "t": numbers().inf, "u": 0, "v": 0}
        values = {"prim": 0, "t": 0} if story.any_hit else {"prim": prim, "t": t, "u": u, "v": v}
        return {"u": 0, "v": 0, **base, "hit": 1, **values}


class Home:
    """The rest of a TRV around the unit: slots start, park, resume and retire."""

    def __init__(self, dut, rng, p_ready=1.0, p_gap=0.0):
        self._dut, self._rng, self._p_ready, self._p_gap = dut, rng, p_ready, p_gap
        self._tokens, self._done = [], []
        self._port = Lock()
        self._ends = [Queue() for _ in range(int(dut.NumSlots.value))]  # is the slot free?
        self.resumes = {}  # slot: [(node, restart)]
        self.hits = []
        for part in (self._give_tokens(), self._give_done(), self._take_hits(), self._watch()):
            cocotb.start_soon(part)

    async def play(self, slot, story):
        """One ray in one slot, from start to retirement."""
        dut = self._dut
        self.resumes[slot] = []
        async with self._port:
            dut.start_slot_i.value, dut.start_i.value = slot, 1
            for k in ("ray_id", "any_hit", "tmin", "tmax"):
                getattr(dut, f"start_{k}_i").value = getattr(story, k)
            await RisingEdge(dut.clk_i)
            dut.start_i.value = 0
        for leaf in story.leaves:
            await self._park(slot, leaf)
            if await self._ends[slot].get():
                return
        self._done.append((slot, story.done))
        assert await self._ends[slot].get(), "resumed a slot that was done"

    async def _park(self, slot, leaf):
        dut = self._dut
        async with self._port:
            dut.park_slot_i.value = slot
            dut.park_count_i.value = sum(token["count"] for token in leaf.tokens)
            dut.park_go_i.value, dut.park_next_i.value = leaf.go, leaf.next
            dut.park_restart_i.value, dut.park_bound_i.value = leaf.restart, leaf.bound
            dut.park_steps_i.value, dut.park_i.value = leaf.steps, 1
            await RisingEdge(dut.clk_i)
            dut.park_i.value = 0
        home = {"trv": 0, "slot": slot}
        self._tokens += [payloads().pack("return_t", token, home=home) for token in leaf.tokens]

    async def _give_tokens(self):
        source = Source(self._dut, "return")
        while True:
            if self._tokens and self._rng.random() >= self._p_gap:
                which = self._rng.randrange(len(self._tokens))
                await source.send([self._tokens.pop(which)])
            else:
                await RisingEdge(self._dut.clk_i)

    async def _give_done(self):
        dut = self._dut
        while True:
            if not self._done:
                await RisingEdge(dut.clk_i)
                continue
            slot, (status, steps) = self._done.pop(0)
            dut.done_slot_i.value, dut.done_status_i.value = slot, status
            dut.done_steps_i.value, dut.done_valid_i.value = steps, 1
            taken = False
            while not taken:
                await ReadOnly()
                taken = dut.done_ready_o.value == 1
                await RisingEdge(dut.clk_i)
            dut.done_valid_i.value = 0

    async def _take_hits(self):
        sink = Sink(self._dut, "hit")
        while True:
            [beat] = await sink.receive(1, lambda: self._rng.random() < self._p_ready)
            self.hits.append(payloads().unpack("hit_t", beat))

    async def _watch(self):
        dut = self._dut
        while True:
            await ReadOnly()
            resumed, freed = dut.resume_o.value == 1, dut.free_o.value == 1
            slot = int((dut.resume_slot_o if resumed else dut.free_slot_o).value)
            node = int(dut.resume_node_o.value), int(dut.resume_restart_o.value)
            await RisingEdge(dut.clk_i)
            if resumed:
                self.resumes[slot].append(node)
            if resumed or freed:
                self._ends[slot].put_nowait(freed)


async def tell(dut, stories, p_ready=1.0, p_gap=0.0):
    """All stories on all slots, each slot one after the other; check every resume and every hit."""
    rng = await start(dut)
    home = Home(dut, rng, p_ready, p_gap)
    stories = stories(rng) if callable(stories) else stories
    for ray_id, story in enumerate(stories):
        story.ray_id = ray_id
    waiting = list(reversed(stories))

    async def one(slot):
        while waiting:
            story = waiting.pop()
            await home.play(slot, story)
            want = Expected(story).resumes
            assert home.resumes[slot] == want, f"{story}: want {want}, got {home.resumes[slot]}"

    for task in [cocotb.start_soon(one(slot)) for slot in range(int(dut.NumSlots.value))]:
        await task
    await ClockCycles(dut.clk_i, 10)
    got = {h["ray_id"]: h for h in home.hits}
    assert len(home.hits) == len(got) == len(stories)
    for story in stories:
        want = Expected(story).hit
        assert got[story.ray_id] == want, f"{story}: want {want}, got {got[story.ray_id]}"


def random_story(rng):
    n = numbers()
    times = [*n.vec((0.5, 1.0, 2.0, 3.0)), n.one + 1, n.one - 1, 0, n.inf - 1]
    times.append(rng.getrandbits(n.width - 1) % n.inf)

    def token():
        if rng.random() < 0.5:
            error = int(rng.random() < 0.02)
            return miss(rng.choice((1, 1, 1, 5)), error)
        prim = rng.randrange(6)
        t = rng.choice(times)
        return hit(t | n.sign if prim == 3 else t, prim)

    leaves = [
        Leaf(
            [token() for _ in range(rng.randint(1, 6))],
            bound=rng.choice((*times, n.inf)),
            go=int(rng.random() < 0.9),
            next=rng.getrandbits(29),
            restart=rng.getrandbits(1),
            steps=rng.getrandbits(16),
        )
        for _ in range(rng.randint(0, 4))
    ]
    return Story(
        leaves,
        done=(rng.choice((OK, OK, MEMORY_ERROR, WATCHDOG)), rng.getrandbits(16)),
        tmin=rng.choice((0, 0, n.one, n.sign | n.one)),
        tmax=rng.choice((n.inf, n.of(2.0), n.one)),
        any_hit=int(rng.random() < 0.3),
    )


@cocotb.test()
@cocotb.parametrize(p_ready=[1.0, 0.2], p_gap=[0.0, 0.5])
async def every_ray_ends_once_by_the_rules(dut, p_ready, p_gap):
    await tell(dut, lambda rng: [random_story(rng) for _ in range(400)], p_ready, p_gap)


@cocotb.test()
async def the_least_prim_wins_a_tie_in_any_order(dut):
    def stories(rng):
        n = numbers()
        for t in (n.one, 0, n.inf - 1):
            for _ in range(20):
                prims = rng.sample(range(1 << 31), 5) + [0, NO_PRIM - 1][: rng.randint(0, 2)]
                rng.shuffle(prims)
                signs = (0, n.sign) if t == 0 else (0,)  # -0 equals 0
                yield Story([Leaf([hit(t | rng.choice(signs), p) for p in prims], n.inf)])

    await tell(dut, lambda rng: list(stories(rng)))


@cocotb.test()
async def both_ends_of_the_interval_belong_to_it(dut):
    n = numbers()
    one, two = n.one, n.of(2.0)
    places = [one - 1, one, one + 1, two - 1, two, two + 1]
    stories = [Story([Leaf([hit(t, 5)], n.inf)], tmin=one, tmax=two) for t in places]
    assert [Expected(story).hit["hit"] for story in stories] == [0, 1, 1, 1, 1, 0]

    await tell(dut, stories)


@cocotb.test()
async def a_leaf_ends_the_ray_only_when_the_best_hit_is_not_beyond_it(dut):
    n = numbers()
    one = n.one
    stories = [
        Story([Leaf([hit(t, 5), miss(3)], one, next=44, restart=r), Leaf([miss()], n.inf)])
        for t in (one - 1, one, one + 1)
        for r in (0, 1)
    ]
    assert [len(Expected(story).resumes) for story in stories] == [0, 0, 0, 0, 1, 1]

    await tell(dut, stories)


@cocotb.test()
async def an_any_hit_ray_ends_at_the_leaf_of_its_first_hit_and_reports_only_that(dut):
    n = numbers()
    far = n.of(100.0)
    leaves = [Leaf([miss(), miss()], n.one), Leaf([hit(far, 9), miss()], n.one), Leaf([miss()], 0)]
    story = Story(leaves, any_hit=1)
    expected = Expected(story)
    assert len(expected.resumes) == 1
    assert expected.hit["hit"] == 1 and expected.hit["t"] == expected.hit["prim"] == 0

    await tell(dut, [story])


@cocotb.test()
async def a_memory_error_ends_the_ray_after_all_tests_without_a_hit(dut):
    n = numbers()
    leaf = Leaf([hit(n.one, 3), miss(7, error=1), miss(2)], n.inf, steps=77)
    after = Leaf([hit(n.one, 3)], n.inf)  # the slot forgets the error
    stories = [Story([each]) for _ in range(20) for each in (leaf, after)]
    assert Expected(stories[0]).hit["status"] == MEMORY_ERROR

    await tell(dut, stories)


async def parked(dut, count):
    """Slot 0 with a ray in a leaf of that many tests, and the source of its tokens."""
    await start(dut)
    n = numbers()
    dut.hit_ready_i.value = 1
    dut.start_tmax_i.value = n.inf
    dut.start_i.value = 1
    await RisingEdge(dut.clk_i)
    dut.start_i.value = 0
    dut.park_count_i.value, dut.park_bound_i.value, dut.park_i.value = count, n.inf, 1
    await RisingEdge(dut.clk_i)
    dut.park_i.value = 0
    await ClockCycles(dut.clk_i, 2)
    return Source(dut, "return")


@cocotb.test()
@cocotb.parametrize(what=["miss", "far", "hit"])
async def a_miss_takes_one_cycle_a_hit_that_is_worse_two_and_one_that_is_better_three(dut, what):
    cycles = {"miss": 1, "far": 2, "hit": 3}[what]
    n = numbers()
    source = await parked(dut, 1000)
    times = {"miss": [0] * 50, "hit": [n.inf - 1 - i for i in range(50)]}
    times["far"] = [n.one] + [n.of(2.0)] * 50
    kind = miss() if what == "miss" else hit(0, 5)
    tokens = [payloads().pack("return_t", {**kind, "t": t}) for t in times[what]]
    await source.send(tokens[:1])
    await ClockCycles(dut.clk_i, 8)

    since = cycle()
    await source.send(tokens[1:41])
    assert cycle() - since == 1 + 39 * cycles


@cocotb.test()
async def waits_for_the_taker_of_hits_and_for_nothing_else(dut):
    source = await parked(dut, 1)
    dut.hit_ready_i.value = 0
    await source.send([payloads().pack("return_t", miss())])
    await ClockCycles(dut.clk_i, 20)
    await ReadOnly()
    assert dut.hit_valid_o.value == 1 and dut.free_o.value == 0
    assert dut.return_ready_o.value == dut.done_ready_o.value == 0
    await RisingEdge(dut.clk_i)

    [beat] = await Sink(dut, "hit").receive(1)
    assert payloads().unpack("hit_t", beat) == Expected(Story([Leaf([miss()], 0, 0, steps=0)])).hit


@cocotb.test()
async def offers_the_best_t_to_the_step_pipeline(dut):
    source = await parked(dut, 100)
    n = numbers()

    async def best():
        dut.tbest_slot_i.value, dut.tbest_read_i.value = 0, 1
        await RisingEdge(dut.clk_i)
        dut.tbest_read_i.value = 0
        await ReadOnly()
        value = int(dut.tbest_o.value)
        await RisingEdge(dut.clk_i)
        return value

    assert await best() == n.inf
    for t, want in [(5.0, 5.0), (7.0, 5.0), (3.0, 3.0), (3.0, 3.0)]:
        await source.send([payloads().pack("return_t", hit(n.of(t), 1))])
        await ClockCycles(dut.clk_i, 5)
        assert await best() == n.of(want)


@cocotb.test()
@cocotb.parametrize(what=["miss", "hit"])
async def neither_tokens_nor_done_slots_wait_for_more_than_one_of_the_other(dut, what):
    """Both always there, the tokens with a better hit each or none: they are taken in turn."""
    source = await parked(dut, 1000)
    n = numbers()
    times = (n.inf - 1 - i for i in range(200))
    tokens = [
        payloads().pack("return_t", {**(hit(t, 5) if what == "hit" else miss())}) for t in times
    ]
    cocotb.start_soon(source.send(tokens))
    dut.done_slot_i.value, dut.done_valid_i.value = 1, 1
    order = []
    for _ in range(300):
        await ReadOnly()
        taken = [
            dut.return_valid_i.value == dut.return_ready_o.value == 1,
            dut.done_ready_o.value == 1,
        ]
        assert sum(taken) < 2
        if any(taken):
            order.append(taken[0])
        await RisingEdge(dut.clk_i)

    assert len(order) > 50
    assert all(a != b for a, b in pairwise(order)), "two of a kind while the other waited"


@cocotb.test()
async def a_done_slot_or_a_token_alone_does_not_wait(dut):
    """Whichever kind was served last, and a token in every cycle where no slot is done."""
    source = await parked(dut, 1000)
    for _ in range(3):
        since = cycle()
        await source.send([payloads().pack("return_t", miss())] * 20)
        assert cycle() - since == 20
    for slot in (1, 1, 0):
        dut.done_slot_i.value, dut.done_valid_i.value = slot, 1
        await ReadOnly()
        assert dut.done_ready_o.value == 1
        await RisingEdge(dut.clk_i)
        dut.done_valid_i.value = 0
        await ClockCycles(dut.clk_i, 2)


@pytest.mark.parametrize("slots", [2, 8])
def test_ti_trv_return(slots):
    run("ti_trv_return", "test_ti_trv_return", config=f"tiny trv_slots={slots}", NumSlots=slots)
