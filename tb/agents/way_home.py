# SPDX-License-Identifier: Apache-2.0
"""Rays around `ti_trv_return`: stories of leaves and tokens, what they come to, the TRV's rest."""

from dataclasses import dataclass, field

import cocotb
from agents.bench import start
from agents.stream import Sink, Source
from cocotb.queue import Queue
from cocotb.triggers import ClockCycles, Lock, ReadOnly, RisingEdge
from models.numbers import numbers
from models.payload import parameter, payloads

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


class Best:
    """The rule of the best hit: the least (t, prim) from tmin on, from (tmax, none) down."""

    def __init__(self, tmin, tmax):
        self._tmin = tmin
        self.t, self.u, self.v, self.prim = tmax, 0, 0, NO_PRIM

    @property
    def found(self):
        return self.prim != NO_PRIM

    def take(self, token):
        """See a token; is it the best?"""
        n = numbers()
        if not token.get("hit"):
            return False
        t, prim = token["t"], token["prim"]
        closer = n.less(t, self.t) or (n.model("fp_eq", t, self.t) and prim < self.prim)
        if not (n.model("fp_le", self._tmin, t) and closer):
            return False
        self.t, self.u, self.v, self.prim = t, token["u"], token["v"], prim
        return True


class Expected:
    """The rules: what a story comes to."""

    def __init__(self, story):
        self.resumes = []  # (node, restart)
        self._best = Best(story.tmin, story.tmax)
        steps, status = story.done[1], story.done[0]
        for leaf in story.leaves:
            error = any(token.get("error") for token in leaf.tokens)
            for token in leaf.tokens:
                self._best.take(token)
            if error or not leaf.go or self._ends(story, leaf):
                steps, status = leaf.steps, MEMORY_ERROR if error else OK
                break
            self.resumes.append((leaf.next, leaf.restart))
        self.hit = self._report(story, status, steps)

    def _ends(self, story, leaf):
        beyond = not numbers().model("fp_le", self._best.t, leaf.bound)
        return not beyond or (story.any_hit and self._best.found)

    def _report(self, story, status, steps):
        base = {"ray_id": story.ray_id, "status": status, "steps": steps}
        best = self._best
        if not best.found or status != OK:
            return {**base, "hit": 0, "prim": NO_PRIM, "t": numbers().inf, "u": 0, "v": 0}
        values = {"prim": 0, "t": 0, "u": 0, "v": 0}
        if not story.any_hit:
            values = {"prim": best.prim, "t": best.t, "u": best.u, "v": best.v}
        return {**base, "hit": 1, **values}


class Home:
    """The rest of a TRV around the unit: slots start, park, resume and retire."""

    def __init__(self, dut, rng, p_ready=1.0, p_gap=0.0):
        self._dut, self._rng, self._p_ready, self._p_gap = dut, rng, p_ready, p_gap
        self._tokens = []
        self._port = Lock()
        self._ends = [Queue() for _ in range(int(dut.NumSlots.value))]  # is the slot free?
        self.resumes = {}  # slot: [(node, restart)]
        self.hits = []
        for part in (self._give_tokens(), self._take_hits(), self._watch()):
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
        async with self._port:
            done(dut, slot, *story.done)
            await RisingEdge(dut.clk_i)
            dut.done_i.value = 0
        assert await self._ends[slot].get(), "resumed a slot that was done"

    async def _park(self, slot, leaf):
        async with self._port:
            park(self._dut, slot, leaf)
            await RisingEdge(self._dut.clk_i)
            self._dut.park_i.value = 0
        self._tokens += [packed(slot, token) for token in leaf.tokens]

    async def _give_tokens(self):
        """In any order, often that of a leaf, so that tokens of a slot come in a row."""
        source, rng = Source(self._dut, "return"), self._rng
        while True:
            if self._tokens and rng.random() >= self._p_gap:
                which = 0 if rng.random() < 0.5 else rng.randrange(len(self._tokens))
                await source.send([self._tokens.pop(which)], patience=1)
            else:
                await RisingEdge(self._dut.clk_i)

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
            slot, free_slot = int(dut.resume_slot_o.value), int(dut.free_slot_o.value)
            node = int(dut.resume_node_o.value), int(dut.resume_restart_o.value)
            await RisingEdge(dut.clk_i)
            if resumed:
                self.resumes[slot].append(node)
                self._ends[slot].put_nowait(False)
            if freed:
                self._ends[free_slot].put_nowait(True)


def packed(slot, token):
    return payloads().pack("return_t", token, home={"trv": 0, "slot": slot})


def park(dut, slot, leaf):
    """Put a slot that enters a leaf on its port."""
    dut.stop_slot_i.value, dut.stop_steps_i.value = slot, leaf.steps
    dut.park_count_i.value = sum(token["count"] for token in leaf.tokens)
    dut.park_go_i.value, dut.park_next_i.value = leaf.go, leaf.next
    dut.park_restart_i.value, dut.park_bound_i.value = leaf.restart, leaf.bound
    dut.park_i.value = 1


def done(dut, slot, status=OK, steps=0):
    """Put a slot that is done on its port."""
    dut.stop_slot_i.value, dut.stop_steps_i.value = slot, steps
    dut.done_status_i.value, dut.done_i.value = status, 1


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
        any_hit=int(rng.random() < 0.3) & parameter("AnyHit", 1),
    )
