# SPDX-License-Identifier: Apache-2.0
"""A `ti_trv` with its rays, its tree and the takers of its hits, under watch."""

import struct

import cocotb
from agents.bench import start
from agents.events import Events
from agents.handles import Handles
from agents.idle import Idle, one
from agents.image_memory import ImageMemory
from agents.stream import Sink, Source
from cocotb.triggers import ReadOnly, RisingEdge
from models.numbers import numbers
from models.payload import payloads
from models.rays import clip, dispatched, ray, unit_box
from models.scene import BASE
from models.traced import tracer

PATIENCE = 30_000  # cycles without a hit after which a ray is lost

TRAIL_LEVELS = 64  # of a padded walk


class Steps:
    """The nodes that each ray visits, seen where a step is compared; who lived in which slot."""

    def __init__(self, dut):
        self.nodes, self.rays_of_slot = {}, {}
        cocotb.start_soon(self._run(Handles(dut), Handles(dut.u_walk)))

    async def _run(self, dut, walk):
        while True:
            await ReadOnly()
            if walk.end_valid.value:
                ray_id = self.rays_of_slot[int(walk.end_slot.value)][-1]
                self.nodes[ray_id].append(int(walk.end_index.value))
            if dut.start.value:
                beat = payloads().unpack("dispatch_t", int(dut.dispatch_data_i.value))
                ray_id = beat["ray_id"]
                self.rays_of_slot.setdefault(int(dut.new_slot.value), []).append(ray_id)
                self.nodes[ray_id] = []
            await RisingEdge(dut.clk_i)


class Room:
    """Sees that a ray is taken in every cycle in which a slot is free, and in no other."""

    def __init__(self, dut):
        cocotb.start_soon(self._run(Handles(dut)))

    async def _run(self, dut):
        free = int(dut.NumSlots.value)
        while True:
            await ReadOnly()
            ready = bool(dut.dispatch_ready_o.value)
            assert ready == (free > 0), f"{free} slots free"
            free -= ready and bool(dut.dispatch_valid_i.value)
            free += bool(dut.hit_valid_o.value) and bool(dut.hit_ready_i.value)
            await RisingEdge(dut.clk_i)


async def setup(dut):
    """The test's random source, and the events of a reset unit under watch."""
    rng = await start(dut)
    Room(dut)
    Idle(dut, {"dispatch": one}, {"hit": one})
    return rng, Events(dut, "trv")


def dispatch(scene, given, ray_id=0, any_hit=0):
    """The beat of a ray, or None when it misses the scene box."""
    miss, _, inv, tmin, tmax = clip(*scene.box, given)
    if miss:
        return None
    return dispatched(scene.box, given, inv, tmin, tmax, ray_id, any_hit)


def tracer_of(dut, scene):
    """The model of the unit."""
    depth, watchdog = int(dut.StackDepth.value), int(dut.WatchdogSteps.value)
    return tracer(scene, depth, watchdog)


def put_scene(dut, scene):
    """Where the tree of a scene is."""
    dut.node_base_i.value, dut.root_i.value = scene.node_base, scene.root


def check_counts(events, total, rays, memory):
    """The events are those of `total`, and one visit is one look into the L1."""
    have = events.counts()
    assert {k: have[k] for k in total} == dict(total)
    assert have["rays"] == rays
    assert have["l1_accesses"] == total["steps"]
    assert have["l1_accesses"] == sum(have[f"l1_{k}"] for k in ("hits", "merged", "misses"))
    assert have["l1_misses"] == len(memory.asked)


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


def inner(link, reorder=0, axis=0, split=0.0):
    """The words of an inner node."""
    return numbers().of(split), link << 3 | reorder << 2 | axis


def lone_ray(ray_id=0):
    """A dispatch along x that every `inner(7, split=9.0)` sends on to the node after it."""
    n = numbers()
    given = ray(n.vec((-1, 0, 0)), n.vec((1, 0.5, 0.5)))
    return dispatched(unit_box(), given, n.vec((1, 2, 2)), 0, n.of(2.0), ray_id)


def put_nodes(dut, nodes, **memory):
    """A memory with these nodes, the root first."""
    dut.node_base_i.value = BASE
    data = b"".join(struct.pack("<2I", *node) for node in nodes)
    return ImageMemory(dut, data, BASE, **memory)
