# SPDX-License-Identifier: Apache-2.0
"""`ti_trv` visits the nodes that the model visits, one every cycle when fed, and ends every ray."""

import struct
from collections import Counter

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
    hits = [payloads().unpack("hit_t", bits) for bits in await sink.receive(len(beats), ready)]
    await sink.expect_none(50)
    by_id = {hit["ray_id"]: hit for hit in hits}
    assert len(by_id) == len(beats), "a ray came out twice"
    return by_id


@cocotb.test()
@cocotb.parametrize(p=[1.0, 0.3], latency=[1, 60])
async def every_ray_takes_the_steps_of_the_model(dut, p, latency):
    """Hits, node sequences, counters; closest and any-hit rays; stalls on all sides."""
    rng = await start(dut)
    scene = Scene(soup(rng, 150))
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
    rays = [r for r in random_rays(rng, 150) if dispatch(scene, r) is not None]
    beats = [dispatch(scene, r, i, i % 3 == 0) for i, r in enumerate(rays)]

    hits = await all_hits(dut, beats, stalls(rng, 1 - p), lambda: rng.random() < p)

    total = Counter()
    for i, given in enumerate(rays):
        want = trace(tracer, given, i % 3 == 0)
        log = [int(line.split()[1]) for line in want.log]
        extra = steps.nodes[i][len(log) :]  # the step that the watchdog stops has no line
        assert steps.nodes[i][: len(log)] == log and len(extra) == (want.status == WATCHDOG), given
        assert hits[i] == hit_of(want, i, i % 3 == 0), given
        total.update({k: getattr(want, k) for k in ("steps", "leaves", "full_leaves", "restarts")})
    have = counters(dut)
    assert {k: have[k] for k in total} == dict(total)
    assert have["rays"] == len(rays)
    assert sum(hit["hit"] for hit in hits.values()) > 20
    assert all(len(r) > 1 for r in steps.rays_of_slot.values())
    assert len(steps.rays_of_slot) == int(dut.NumSlots.value)


@cocotb.test()
async def restarts_when_the_stack_has_overflowed(dut):
    """All tests miss, so that every ray crosses the whole scene."""
    rng = await start(dut)
    scene = Scene(soup(rng, 600, size=0.1))
    put_scene(dut, scene)
    ImageMemory(dut, scene.bytes, BASE)
    LeafTests(dut, scene, rng, misses=True)
    blind = Scene([])  # no triangle: its tracer would end at once
    del blind
    steps = Steps(dut)
    rays = [ray(o, d) for o, d in rays_through(rng, 80)]
    rays = [given for given in rays if dispatch(scene, given) is not None]

    hits = await all_hits(dut, [dispatch(scene, given, i) for i, given in enumerate(rays)])

    restarts = 0
    for i, given in enumerate(rays):
        nodes, again, status = walk(dut, scene, given)
        assert steps.nodes[i] == nodes, given
        assert (hits[i]["status"], hits[i]["hit"]) == (status, 0), given
        restarts += again
    assert counters(dut)["restarts"] == restarts
    assert restarts > 5 or int(dut.StackDepth.value) > 4
