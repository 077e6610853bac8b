# SPDX-License-Identifier: Apache-2.0
"""`ti_traverse` answers each ray once as the model does, and deals rays to its homes in tiles."""

from collections import Counter

import cocotb
import pytest
from agents.bench import run, start
from agents.events import Events
from agents.image_memory import ImageMemory
from agents.lanes import Lanes
from agents.leaf_tests import LeafTests
from agents.stream import Sink, Source, stalls
from cocotb.triggers import ClockCycles, ReadOnly, RisingEdge
from models.numbers import numbers
from models.payload import configuration, payloads
from models.rays import clip, random_ray, ray
from models.scene import BASE, Scene, soup
from models.traced import (
    MEMORY_ERROR,
    OK,
    hit_of,
    leaf_at_end,
    nodes_of,
    random_rays,
    trace,
    tracer,
    work_of,
)

PATIENCE = 30_000  # cycles without a hit after which a ray is lost
RAYS_INSIDE_RD = 16
HITS_IN_ARBITER = 2


class Dealing:
    """Sees that rays go to homes in tiles: the next home with room after a tile or a full home."""

    def __init__(self, dut):
        self._dut, self._tile = dut, configuration()["deal_tile"]
        self._count = configuration()["num_trv"]
        self.homes = []
        cocotb.start_soon(self._run())

    async def _run(self):
        dut, home, dealt = self._dut, 0, 0
        while True:
            await ReadOnly()
            ready, valid = int(dut.dispatch_ready.value), int(dut.dispatch_valid.value)
            if dut.u_rd.enters.value == 1:  # a ray waits to be dealt
                room = ready >> home & 1
                assert valid == room << home, f"{valid:#b}, must go to {home}, ready {ready:#b}"
                if room:
                    self.homes.append(home)
                    dealt += 1
                if not room or dealt == self._tile:
                    others = ((home + 1 + i) % self._count for i in range(self._count))
                    home, dealt = next((h for h in others if ready >> h & 1), home), 0
            else:
                assert valid == 0
            await RisingEdge(dut.clk_i)


class Bench:
    """A scene in memory behind each home, its tests, everything that is watched."""

    def __init__(self, dut, rng, p=1.0, latency=1, size=0.3, triangles=200, fails=None, tests=True):
        self.dut, self.rng, self.p = dut, rng, p
        config = configuration()
        self.homes = range(config["num_trv"])
        self.scene = Scene(soup(rng, triangles, size))
        self.model = tracer(self.scene, config["stack_depth"], config["watchdog_steps"])
        dut.node_base_i.value, dut.root_i.value = self.scene.node_base, self.scene.root
        for port, corner in zip((dut.box_lo_i, dut.box_hi_i), self.scene.box, strict=True):
            port.value = payloads().pack_vec(corner)
        lanes = Lanes(dut)
        self.memories = [
            ImageMemory(
                lanes[home],
                self.scene.bytes,
                BASE,
                latency=lambda: rng.randint(1, latency),
                ready=lambda: rng.random() < p,
                fails=fails,
            )
            for home in self.homes
        ]
        gap, ready = stalls(rng, 1 - p), (lambda: rng.random() < p)
        self.tests = [
            LeafTests(lanes[home], self.scene, rng, ready=ready, gap=gap)
            for home in (self.homes if tests else ())
        ]
        self.rd = Events(dut, "rd", dut.rd_events_o)
        self.trv = [Events(dut, "trv", dut.trv_events_o[home]) for home in self.homes]
        self.dealing = Dealing(dut)

    async def all_hits(self, rays):
        """Send the rays, every third for any hit; the hits by ray id."""
        dut, rng, p = self.dut, self.rng, self.p
        beats = [
            payloads().pack("ray_t", given, ray_id=i, any_hit=i % 3 == 0)
            for i, given in enumerate(rays)
        ]
        sink = Sink(dut, "hit")
        cocotb.start_soon(Source(dut, "ray").send(beats, stalls(rng, 1 - p)))
        beats = await sink.receive(len(rays), lambda: rng.random() < p, PATIENCE)
        got = [payloads().unpack("hit_t", bits) for bits in beats]
        await sink.expect_none(50)
        hits = {hit["ray_id"]: hit for hit in got}
        assert len(hits) == len(rays), "a ray came out twice"
        return hits

    def counts(self):
        """The events of all homes."""
        return sum((Counter(events.counts()) for events in self.trv), Counter())

    def misses_box(self, given):
        return clip(*self.scene.box, given)[0]


def check_leaves(bench):
    for home, tests in zip(bench.homes, bench.tests, strict=True):
        assert all(leaf["home"]["trv"] == home for leaf in tests.leaves)


@cocotb.test()
@cocotb.parametrize((("p", "latency"), [(1.0, 1), (0.3, 40)]), size=[0.3, 0.02])
async def answers_each_ray_once_as_the_model_does(dut, p, latency, size):
    """Rays that meet the box and others, some that cannot be traced; hits and events."""
    rng = await start(dut)
    bench = Bench(dut, rng, p, latency, size)
    rays = [*random_rays(rng, 70), *(random_ray(rng) for _ in range(50))]
    rng.shuffle(rays)

    hits = await bench.all_hits(rays)

    total, misses = Counter(), 0
    for i, given in enumerate(rays):
        traced = trace(bench.model, given, i % 3 == 0)
        assert hits[i] == hit_of(traced, i, i % 3 == 0), given
        if bench.misses_box(given):
            misses += 1
        else:
            total += work_of(traced, nodes_of(traced))
    counts, rd = bench.counts(), bench.rd.counts()
    assert 20 < misses < len(rays) - 20
    assert (rd["rays"], rd["misses"], counts["rays"]) == (len(rays), misses, len(rays) - misses)
    assert {k: counts[k] for k in total} == dict(total)
    assert counts["l1_accesses"] == total["steps"]
    assert counts["l1_misses"] == sum(len(memory.asked) for memory in bench.memories)
    assert len(bench.dealing.homes) == len(rays) - misses
    assert all(events.counts()["rays"] for events in bench.trv), "a home without a ray"
    check_leaves(bench)


@cocotb.test()
async def a_memory_error_ends_only_the_rays_that_need_the_line(dut):
    rng = await start(dut)
    lines = set()
    bench = Bench(dut, rng, 0.7, 10, fails=lambda line: line in lines)
    first = bench.memories[0].line_of(bench.scene.node_base)
    last = bench.memories[0].line_of(bench.scene.list_base)
    lines |= set(range(first + 2, last, 9))
    rays = list(random_rays(rng, 150))

    hits = await bench.all_hits(rays)

    errors, total = 0, Counter()
    for i, given in enumerate(rays):
        traced = trace(bench.model, given, i % 3 == 0)
        nodes = nodes_of(traced)
        fatal = [bench.memories[0].line_of(bench.scene.node_base + 8 * n) in lines for n in nodes]
        if any(fatal):
            errors += 1
            steps = fatal.index(True) + 1
            assert (hits[i]["status"], hits[i]["hit"], hits[i]["steps"]) == (MEMORY_ERROR, 0, steps)
            # The node that did not come may be a leaf.
            total += work_of(traced, nodes[:steps]) - leaf_at_end(traced, steps)
        else:
            assert hits[i] == hit_of(traced, i, i % 3 == 0), given
            if nodes:
                total += work_of(traced, nodes)
    counts, misses = bench.counts(), sum(bench.misses_box(given) for given in rays)
    assert {k: counts[k] for k in total} == dict(total)
    assert (bench.rd.counts()["misses"], counts["rays"]) == (misses, len(rays) - misses)
    assert counts["l1_misses"] == sum(len(memory.asked) for memory in bench.memories)
    assert 5 < errors < len(rays) - 5


def through_middle():
    """A ray that enters the box of a scene around the origin."""
    n = numbers()
    return ray(n.vec((-9, 0.01, 0.02)), n.vec((1, 0, 0)))


@cocotb.test()
async def deals_whole_tiles_while_rays_wait_in_rd(dut):
    """Misses at the head hold rays up until they are dealt in consecutive cycles."""
    rng = await start(dut)
    bench = Bench(dut, rng)
    tile, homes = configuration()["deal_tile"], configuration()["num_trv"]
    n = numbers()
    away = ray(n.vec((9, 9, 9)), n.vec((1, 0, 0)))
    queued = 2 if configuration()["lookup_stages"] > 4 else 0  # in front of the arbiter
    held = queued + HITS_IN_ARBITER + 1
    rays = [away] * held + [through_middle()] * (RAYS_INSIDE_RD - held)
    assert [bench.misses_box(given) for given in rays] == [1] * held + [0] * (len(rays) - held)
    beats = [payloads().pack("ray_t", given, ray_id=i) for i, given in enumerate(rays)]
    await Source(dut, "ray").send(beats)
    await ClockCycles(dut.clk_i, 100)
    assert bench.dealing.homes == []

    hits = await Sink(dut, "hit").receive(len(rays), patience=PATIENCE)

    assert {payloads().unpack("hit_t", bits)["status"] for bits in hits} == {OK}
    assert bench.dealing.homes == [i // tile % homes for i in range(len(rays) - held)]


@cocotb.test()
async def a_leaf_that_waits_says_whether_another_was_served(dut):
    """`room` while nobody takes leaves, `arbitration` while another home's is taken."""
    rng = await start(dut)
    bench = Bench(dut, rng, size=0.8, tests=False)
    rays = [through_middle()] * len(bench.homes) * configuration()["deal_tile"]
    beats = [payloads().pack("ray_t", given, ray_id=i) for i, given in enumerate(rays)]
    cocotb.start_soon(Source(dut, "ray").send(beats))
    await ClockCycles(dut.clk_i, 4000)
    everyone = (1 << len(bench.homes)) - 1
    assert dut.leaf_valid_o.value == everyone

    for lost in (0, everyone, 1):
        dut.leaf_lost_i.value = lost
        before = [events.counts() for events in bench.trv]
        await ClockCycles(dut.clk_i, 30)
        for home, (events, since) in enumerate(zip(bench.trv, before, strict=True)):
            activity = "arbitration" if lost >> home & 1 else "room"
            assert events.activities(since) == {activity: 30}, home


@cocotb.test()
async def is_idle_except_while_a_home_has_a_ray(dut):
    rng = await start(dut)
    bench = Bench(dut, rng, latency=20)
    inside = [0]

    async def watch():
        away = int(dut.NumTrv.value)
        while True:
            await ReadOnly()
            assert dut.idle_o.value == (inside[0] == 0), f"{inside[0]} at home"
            inside[0] += int(dut.dispatch_valid.value) != 0
            out = int(dut.hit_valid.value) & int(dut.hit_ready.value)
            inside[0] -= (out & ((1 << away) - 1)).bit_count()
            await RisingEdge(dut.clk_i)

    cocotb.start_soon(watch())
    await ClockCycles(dut.clk_i, 5)
    await bench.all_hits(list(random_rays(rng, 30)))
    assert inside[0] == 0


@cocotb.test()
async def a_flush_makes_every_home_ask_for_its_lines_again(dut):
    rng = await start(dut)
    bench = Bench(dut, rng, triangles=12, size=0.8)
    assert 8 * len(bench.scene.nodes) <= configuration()["trv_l1_bytes"], "the tree does not fit"
    assert not bench.misses_box(through_middle())
    rays = [through_middle()] * (configuration()["deal_tile"] * len(bench.homes))

    async def lines_asked_for():
        before = [len(memory.asked) for memory in bench.memories]
        await bench.all_hits(rays)
        pairs = zip(bench.memories, before, strict=True)
        return [sorted(memory.asked[b:]) for memory, b in pairs]

    first = await lines_asked_for()
    assert all(first)
    assert not any(await lines_asked_for())
    dut.flush_i.value = 1
    await RisingEdge(dut.clk_i)
    dut.flush_i.value = 0
    assert await lines_asked_for() == first


BUILDS = {
    "tiny": "",
    "lines": "num_trv=3 deal_tile=4 line_bytes=32 rd_cycles=1",
    "wide": "num_trv=2 deal_tile=4 line_bytes=128 exp_bits=7 frac_bits=16 stack_depth=1 "
    "rd_cycles=2 lookup_stages=5",
    "watertight": "traversal=padded triangle_test=woop",
}


@pytest.mark.parametrize("build", BUILDS)
def test_ti_traverse(build):
    run("ti_traverse", "test_ti_traverse", config=f"tiny {BUILDS[build]}")
