# SPDX-License-Identifier: Apache-2.0
"""`ti_trv` ends every ray, whatever stands in memory and it answers; test_ti_trv.py runs these."""

from collections import Counter

import cocotb
from agents.bench import only_if
from agents.image_memory import ImageMemory
from agents.leaf_tests import LeafTests
from agents.stream import Sink, Source
from agents.trv_bench import (
    TRAIL_LEVELS,
    Steps,
    all_hits,
    check_counts,
    dispatch,
    inner,
    lone_ray,
    put_nodes,
    put_scene,
    setup,
    tracer_of,
)
from models.numbers import numbers
from models.payload import parameter, payloads
from models.scene import BASE, Scene, soup
from models.traced import (
    MEMORY_ERROR,
    NO_PRIM,
    OK,
    WATCHDOG,
    hit_of,
    leaf_at_end,
    nodes_of,
    random_rays,
    trace,
    work_of,
)

PADDED = bool(parameter("Padded", 0))


@cocotb.test()
@cocotb.parametrize(every=[13, 40])
async def a_memory_error_ends_the_rays_that_need_the_line(dut, every):
    rng, events = await setup(dut)
    scene = Scene(soup(rng, 300))
    put_scene(dut, scene)
    model, steps = tracer_of(dut, scene), Steps(dut)
    memory = ImageMemory(dut, scene.bytes, BASE, fails=lambda line: bad(line))
    first = memory.line_of(scene.node_base)

    def bad(line):
        return line > first and line % every == 0

    LeafTests(dut, scene, rng)
    rays = [r for r in random_rays(rng, 80) if dispatch(scene, r) is not None]

    hits = await all_hits(dut, [dispatch(scene, r, i) for i, r in enumerate(rays)])

    errors, total = 0, Counter()
    for i, given in enumerate(rays):
        traced = trace(model, given)
        nodes, want = nodes_of(traced), hit_of(traced, i, 0)
        fatal = [bad(memory.line_of(scene.node_base + 8 * node)) for node in nodes]
        if any(fatal):
            errors += 1
            nodes = nodes[: fatal.index(True) + 1]
            miss = {"hit": 0, "prim": NO_PRIM, "t": numbers().inf, "u": 0, "v": 0}
            want = {**want, **miss, "status": MEMORY_ERROR, "steps": len(nodes)}
        assert hits[i] == want and steps.nodes[i][: len(nodes)] == nodes, given
        work = work_of(traced, steps.nodes[i])
        if any(fatal):  # the node that did not come may be a leaf
            assert steps.nodes[i] == nodes
            work = work_of(traced, nodes) - leaf_at_end(traced, len(nodes))
        total.update(work)
    check_counts(events, total, len(rays), memory)
    assert 5 < errors < len(rays) - 5


@cocotb.test()
@cocotb.parametrize(nodes=["self", "pair", "beyond"])
async def a_corrupt_tree_ends_every_ray(dut, nodes):
    """A node that is its own child, a pair that are each other's, a child outside memory.

    A padded walk in a circle comes to the end of its trail, or to the watchdog before.
    """
    _, events = await setup(dut)
    empty = (0, 3)
    tree, status = {
        "self": ([inner(0, reorder=1), empty], WATCHDOG),
        "pair": ([inner(3, split=9.0), inner(0, reorder=1, split=9.0), empty, empty], WATCHDOG),
        "beyond": ([inner(1 << 20, reorder=1), empty], MEMORY_ERROR),
    }[nodes]
    memory = put_nodes(dut, tree)
    count = int(dut.NumSlots.value) + 1
    beats = [lone_ray(i) for i in range(count)]

    hits = await all_hits(dut, beats)

    steps = int(dut.WatchdogSteps.value) if status == WATCHDOG else 2
    if PADDED and status == WATCHDOG and steps > TRAIL_LEVELS:
        status, steps = MEMORY_ERROR, TRAIL_LEVELS + 1
    for hit in hits.values():
        assert (hit["status"], hit["hit"], hit["steps"]) == (status, 0, steps)
    visits = steps + (status == WATCHDOG)  # the one that is too many is counted
    check_counts(events, Counter(steps=visits * count, leaves=0, full_leaves=0), count, memory)


@cocotb.test()
@cocotb.parametrize(beyond=[0, 1])
async def the_watchdog_stops_before_the_node_that_is_too_many(dut, beyond):
    """A leaf is the last node that is allowed, or the first that is not."""
    _, events = await setup(dut)
    limit = int(dut.WatchdogSteps.value)
    memory = put_nodes(dut, [inner(7, split=9.0)] * (limit - 1 + beyond) + [(0, 3)])

    [hit] = (await all_hits(dut, [lone_ray()])).values()

    assert (hit["status"], hit["steps"]) == (WATCHDOG if beyond else OK, limit)
    check_counts(events, Counter(steps=limit + beyond, leaves=1 - beyond), 1, memory)


@cocotb.test()
@cocotb.parametrize(count=[65535, 65536, 1 << 20, 1 << 28])
async def a_leaf_of_more_triangles_than_a_leaf_has_is_a_memory_error(dut, count):
    await setup(dut)
    put_nodes(dut, [(0, count << 3 | 3)])
    source, leaf, hit = Source(dut, "dispatch"), Sink(dut, "leaf"), Sink(dut, "hit")
    await source.send([lone_ray()])
    if count <= 65535:
        [bits] = await leaf.receive(1)
        assert payloads().unpack("leaf_t", bits)["count"] == count
        return
    [bits] = await hit.receive(1)
    answer = payloads().unpack("hit_t", bits)
    assert (answer["status"], answer["hit"], answer["steps"]) == (MEMORY_ERROR, 0, 1)


@only_if(PADDED and parameter("WatchdogSteps", 65535) > TRAIL_LEVELS)
@cocotb.parametrize(below=[-1, 0, 1])
async def an_inner_node_below_the_last_level_of_the_trail_ends_its_ray(dut, below):
    await setup(dut)
    levels = TRAIL_LEVELS + below
    put_nodes(dut, [inner(7, split=9.0)] * levels + [(0, 3)])

    [hit] = (await all_hits(dut, [lone_ray()])).values()

    status = MEMORY_ERROR if below > 0 else OK
    assert (hit["status"], hit["steps"]) == (status, TRAIL_LEVELS + 1 + min(below, 0))
