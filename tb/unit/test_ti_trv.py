# SPDX-License-Identifier: Apache-2.0
"""`ti_trv` visits the nodes that the model visits, one every cycle when fed, and ends every ray."""

import struct
from collections import Counter
from itertools import pairwise

import cocotb
import pytest
import ti_model
from agents.bench import cycle, run, start
from agents.image_memory import ImageMemory
from agents.leaf_tests import LeafTests
from agents.stream import Sink, Source, stalls
from cocotb.triggers import ClockCycles, ReadOnly, RisingEdge
from models.numbers import numbers
from models.payload import parameter, payloads
from models.rays import clip, ray
from models.scene import BASE, Scene, rays_through, soup

OK, MEMORY_ERROR, WATCHDOG = 0, 2, 3
NO_PRIM = (1 << 32) - 1
SLOTS_TO_FILL = 32  # fewer cannot keep the step pipeline busy
PATIENCE = 30_000  # cycles without a hit after which a ray is lost


class Steps:
    """The nodes that each ray visits, seen where a step ends; and who lived in which slot."""

    def __init__(self, dut):
        self.nodes, self.rays_of_slot = {}, {}
        self._dut = dut
        cocotb.start_soon(self._run())

    async def _run(self):
        dut = self._dut
        while True:
            await ReadOnly()
            if dut.end_valid.value == 1:
                ray_id = self.rays_of_slot[int(dut.end_slot.value)][-1]
                self.nodes[ray_id].append(int(dut.end_index.value))
            if dut.start.value == 1:
                beat = payloads().unpack("dispatch_t", int(dut.dispatch_data_i.value))
                ray_id = beat["ray"]["ray_id"]
                self.rays_of_slot.setdefault(int(dut.new_slot.value), []).append(ray_id)
                self.nodes[ray_id] = []
            await RisingEdge(dut.clk_i)


def dispatch(scene, given, ray_id=0, any_hit=0):
    """The beat of a ray, or None when it misses the scene box."""
    miss, _, inv, tmin, tmax = clip(*scene.box, given)
    if miss:
        return None
    whole = {"ray_id": ray_id, "any_hit": any_hit, **given}
    return payloads().pack("dispatch_t", ray=whole, inv=inv, tmin=tmin, tmax=tmax)


def random_rays(rng, count):
    n = numbers()
    for o, d in rays_through(rng, count):
        tmin = n.of(rng.choice((0.0, 0.0, 0.5)))
        yield ray(o, d, tmin, rng.choice((n.inf, n.inf, n.of(rng.uniform(1, 3)))))


def trace(tracer, given, any_hit=0):
    """What the model makes of a ray."""
    n = numbers()
    o, d = ([n.float(x) for x in given[k]] for k in "od")
    return tracer.trace(o, d, n.float(given["tmin"]), n.float(given["tmax"]), bool(any_hit))


def nodes_of(traced):
    return [int(line.split()[1]) for line in traced.log]


def hit_of(traced, ray_id, any_hit):
    values = {k: getattr(traced, k) for k in ("t", "u", "v", "status")}
    found = traced.prim >= 0
    prim = traced.prim if found else NO_PRIM
    return {**values, "ray_id": ray_id, "hit": int(found), "prim": prim, "steps": traced.hit_steps}


def tracer_of(dut, scene):
    depth, watchdog = int(dut.StackDepth.value), int(dut.WatchdogSteps.value)
    return ti_model.Tracer.create(scene.image, depth, watchdog)


def put_scene(dut, scene):
    dut.node_base_i.value, dut.root_i.value = scene.node_base, scene.root


def counters(dut):
    return payloads().unpack("trv_counters_t", int(dut.counters_o.value))


async def all_hits(dut, beats, gap=lambda: 0, ready=lambda: 1):
    """Send the dispatches and take as many hits, by ray id."""
    sink = Sink(dut, "hit")
    cocotb.start_soon(Source(dut, "dispatch").send(beats, gap))
    hits = [
        payloads().unpack("hit_t", bits) for bits in await sink.receive(len(beats), ready, PATIENCE)
    ]
    await sink.expect_none(50)
    by_id = {hit["ray_id"]: hit for hit in hits}
    assert len(by_id) == len(beats), "a ray came out twice"
    return by_id


@cocotb.test()
@cocotb.parametrize((("p", "latency"), [(1.0, 1), (0.3, 60)]), size=[0.3, 0.02])
async def every_ray_takes_the_steps_of_the_model(dut, p, latency, size):
    """Hits, node sequences, counters; closest and any-hit rays; stalls on all sides.

    Small triangles let the rays through to the far side of a deep tree, past full stacks.
    """
    rng = await start(dut)
    scene = Scene(soup(rng, 300, size))
    put_scene(dut, scene)
    tracer, steps = tracer_of(dut, scene), Steps(dut)
    ImageMemory(
        dut,
        scene.bytes,
        BASE,
        latency=lambda: rng.randint(1, latency),
        ready=lambda: rng.random() < p,
    )
    LeafTests(dut, scene, rng, ready=lambda: rng.random() < p, gap=stalls(rng, 1 - p))
    count = min(15 * int(dut.NumSlots.value), 150)
    rays = [r for r in random_rays(rng, count) if dispatch(scene, r) is not None]
    beats = [dispatch(scene, r, i, i % 3 == 0) for i, r in enumerate(rays)]

    hits = await all_hits(dut, beats, stalls(rng, 1 - p), lambda: rng.random() < p)

    total = Counter()
    for i, given in enumerate(rays):
        want = trace(tracer, given, i % 3 == 0)
        log = nodes_of(want)
        extra = steps.nodes[i][len(log) :]  # the step that the watchdog stops has no line
        assert steps.nodes[i][: len(log)] == log and len(extra) == (want.status == WATCHDOG), given
        assert hits[i] == hit_of(want, i, i % 3 == 0), given
        total.update({k: getattr(want, k) for k in ("steps", "leaves", "full_leaves", "restarts")})
    have = counters(dut)
    assert {k: have[k] for k in total} == dict(total)
    assert have["rays"] == len(rays)
    assert sum(hit["hit"] for hit in hits.values()) > 5 or size < 0.3
    assert total["restarts"] > 0 or size == 0.3 or int(dut.StackDepth.value) > 4
    assert all(len(r) > 1 for r in steps.rays_of_slot.values())
    assert len(steps.rays_of_slot) == int(dut.NumSlots.value)


@cocotb.test()
@cocotb.parametrize(every=[13, 40])
async def a_memory_error_ends_the_rays_that_need_the_line(dut, every):
    rng = await start(dut)
    scene = Scene(soup(rng, 300))
    put_scene(dut, scene)
    tracer, steps = tracer_of(dut, scene), Steps(dut)
    memory = ImageMemory(dut, scene.bytes, BASE, fails=lambda line: bad(line))
    first = memory.line_of(scene.node_base)

    def bad(line):
        return line > first and line % every == 0

    LeafTests(dut, scene, rng)
    rays = [r for r in random_rays(rng, 80) if dispatch(scene, r) is not None]

    hits = await all_hits(dut, [dispatch(scene, r, i) for i, r in enumerate(rays)])

    errors = 0
    for i, given in enumerate(rays):
        traced = trace(tracer, given)
        nodes, want = nodes_of(traced), hit_of(traced, i, 0)
        fatal = [bad(memory.line_of(scene.node_base + 8 * node)) for node in nodes]
        if any(fatal):
            errors += 1
            nodes = nodes[: fatal.index(True) + 1]
            miss = {"hit": 0, "prim": NO_PRIM, "t": numbers().inf, "u": 0, "v": 0}
            want = {**want, **miss, "status": MEMORY_ERROR, "steps": len(nodes)}
        assert hits[i] == want and steps.nodes[i][: len(nodes)] == nodes, given
    assert 5 < errors < len(rays) - 5


def inner(link, reorder=0, axis=0, split=0.0):
    return numbers().of(split), link << 3 | reorder << 2 | axis


def lone_ray():
    """A dispatch along x that every `inner(7, split=9.0)` sends on to the node after it."""
    n = numbers()
    given = ray(n.vec((-1, 0, 0)), n.vec((1, 0.5, 0.5)))
    return payloads().pack("dispatch_t", ray=given, inv=n.vec((1, 2, 2)), tmax=n.of(2.0))


def put_nodes(dut, nodes):
    dut.node_base_i.value = BASE
    ImageMemory(dut, b"".join(struct.pack("<2I", *node) for node in nodes), BASE)


@cocotb.test()
@cocotb.parametrize(nodes=["self", "pair", "beyond"])
async def a_corrupt_tree_ends_every_ray(dut, nodes):
    """A node that is its own child, a pair that are each other's, a child outside memory."""
    await start(dut)
    empty = (0, 3)
    tree, status = {
        "self": ([inner(0, reorder=1), empty], WATCHDOG),
        "pair": ([inner(3, split=9.0), inner(0, reorder=1, split=9.0), empty, empty], WATCHDOG),
        "beyond": ([inner(1 << 20, reorder=1), empty], MEMORY_ERROR),
    }[nodes]
    put_nodes(dut, tree)
    n = numbers()
    given = ray(n.vec((-1, 0, 0)), n.vec((1, 0.5, 0.5)))
    inv = n.vec((1, 2, 2))
    count = int(dut.NumSlots.value) + 1
    beats = [
        payloads().pack("dispatch_t", ray={"ray_id": i, **given}, inv=inv, tmax=n.of(2.0))
        for i in range(count)
    ]

    hits = await all_hits(dut, beats)

    steps = int(dut.WatchdogSteps.value) if status == WATCHDOG else 2
    for hit in hits.values():
        assert (hit["status"], hit["hit"], hit["steps"]) == (status, 0, steps)
    assert counters(dut)["rays"] == count


@cocotb.test()
@cocotb.parametrize(beyond=[0, 1])
async def the_watchdog_stops_before_the_node_that_is_too_many(dut, beyond):
    """A leaf is the last node that is allowed, or the first that is not."""
    await start(dut)
    limit = int(dut.WatchdogSteps.value)
    put_nodes(dut, [inner(7, split=9.0)] * (limit - 1 + beyond) + [(0, 3)])

    [hit] = (await all_hits(dut, [lone_ray()])).values()

    assert (hit["status"], hit["steps"]) == (WATCHDOG if beyond else OK, limit)
    assert counters(dut)["leaves"] == 1 - beyond
    assert counters(dut)["steps"] == limit + beyond


@cocotb.test()
async def a_step_takes_its_latency_and_the_two_cycles_of_the_ra(dut):
    """One ray, all nodes in the L1."""
    await start(dut)
    put_nodes(dut, [inner(7, split=9.0)] * 6 + [(0, 3)])
    beat = lone_ray()
    await all_hits(dut, [beat])

    dut.hit_ready_i.value = 1
    cocotb.start_soon(Source(dut, "dispatch").send([beat]))
    answers = []
    while dut.hit_valid_o.value == 0:
        await ReadOnly()
        if dut.rsp_valid.value == 1:
            answers.append(cycle())
        await RisingEdge(dut.clk_i)

    ra_hit = 2
    between = {later - sooner for sooner, later in pairwise(answers)}
    assert between == {int(dut.StepLatency.value) + ra_hit} and len(answers) == 7


@cocotb.test(skip=parameter("NumSlots") < SLOTS_TO_FILL)
@cocotb.parametrize(misses=[True, False])
async def takes_one_step_every_cycle(dut, misses):
    """With all nodes in the L1 and a ray always waiting, over 1000 cycles."""
    rng = await start(dut)
    scene = Scene(soup(rng, 200, 0.05))
    put_scene(dut, scene)
    assert 8 * len(scene.nodes) <= int(dut.CacheBytes.value), "the tree does not fit in the L1"
    ImageMemory(dut, scene.bytes, BASE)
    LeafTests(dut, scene, rng, misses=misses)
    rays = [dispatch(scene, ray(o, d), i) for i, (o, d) in enumerate(rays_through(rng, 120))]
    beats = [beat for beat in rays if beat is not None]
    await all_hits(dut, beats)  # all that they read is in the L1 now

    dut.hit_ready_i.value = 1
    cocotb.start_soon(Source(dut, "dispatch").send(rng.choice(beats) for _ in range(10_000)))
    await ClockCycles(dut.clk_i, 300)
    before, since = counters(dut), cycle()
    await ClockCycles(dut.clk_i, 1000)
    after, until = counters(dut), cycle()

    assert after["cache"]["misses"] == before["cache"]["misses"]
    assert after["rays"] > before["rays"]
    assert after["steps"] - before["steps"] == until - since == 1000


BUILDS = {
    "tiny": ("trv_slots=8", {"NumSlots": 8, "StackDepth": 4, "WatchdogSteps": 400}),
    "least": ("trv_slots=2", {"NumSlots": 2, "StackDepth": 1, "WatchdogSteps": 60, "Rows": 1}),
    "half": ("trv_slots=4 exp_bits=7 frac_bits=16", {"NumSlots": 4, "StackDepth": 2}),
    "large": ("trv_slots=32", {"NumSlots": 32, "StackDepth": 8, "CacheBytes": 32768, "Ways": 4}),
}


@pytest.mark.parametrize("build", BUILDS)
def test_ti_trv(build):
    overrides, params = BUILDS[build]
    params = {"WatchdogSteps": 400, **params}
    run("ti_trv", "test_ti_trv", config=f"tiny {overrides}", params=params)
