# SPDX-License-Identifier: Apache-2.0
"""`ti_trv` visits the nodes that the model visits, one every cycle when fed, and ends every ray."""

from collections import Counter
from itertools import pairwise

import cocotb
import pytest
from agents.bench import cycle, only_if, run
from agents.image_memory import ImageMemory
from agents.leaf_tests import LeafTests
from agents.stream import Sink, Source, stalls
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
from cocotb.triggers import ClockCycles, ReadOnly, RisingEdge
from models.payload import configuration, parameter, payloads
from models.rays import ray
from models.scene import BASE, Scene, rays_through, soup
from models.traced import (
    WATCHDOG,
    hit_of,
    nodes_of,
    random_rays,
    trace,
    work_of,
)

PADDED = bool(parameter("Padded", 0))
SLOTS_TO_FILL = 32  # fewer cannot keep the step pipeline busy


def ra_hit():
    """Cycles of a `ti_ra` on a hit."""
    return 1 + configuration()["lookup_stages"]


@cocotb.test()
@cocotb.parametrize((("p", "latency"), [(1.0, 1), (0.3, 60)]), size=[0.3, 0.02])
async def every_ray_takes_the_steps_of_the_model(dut, p, latency, size):
    """Hits, node sequences, events; closest and any-hit rays; stalls on all sides.

    Small triangles let the rays through to the far side of a deep tree, past full stacks.
    """
    rng, events = await setup(dut)
    scene = Scene(soup(rng, 300, size))
    put_scene(dut, scene)
    model, steps = tracer_of(dut, scene), Steps(dut)
    memory = ImageMemory(
        dut,
        scene.bytes,
        BASE,
        latency=lambda: rng.randint(1, latency),
        ready=lambda: rng.random() < p,
    )
    LeafTests(dut, scene, rng, ready=lambda: rng.random() < p, gap=stalls(rng, 1 - p))
    slots = int(dut.NumSlots.value)
    count = min(15 * slots, 60 + 2 * slots)
    rays = [r for r in random_rays(rng, count) if dispatch(scene, r) is not None]
    beats = [dispatch(scene, r, i, i % 3 == 0) for i, r in enumerate(rays)]

    hits = await all_hits(dut, beats, stalls(rng, 1 - p), lambda: rng.random() < p)

    total = Counter()
    for i, given in enumerate(rays):
        want = trace(model, given, i % 3 == 0)
        log = nodes_of(want)
        extra = steps.nodes[i][len(log) :]  # the step that the watchdog stops has no line
        assert steps.nodes[i][: len(log)] == log and len(extra) == (want.status == WATCHDOG), given
        assert hits[i] == hit_of(want, i, i % 3 == 0), given
        work = work_of(want, steps.nodes[i])
        assert [work[k] for k in ("leaves", "full_leaves")] == [want.leaves, want.full_leaves]
        assert work["restarts"] + work["restarts_after_tests"] == want.restarts
        total.update({**work, "steps": want.steps})
    check_counts(events, total, len(rays), memory)
    assert sum(hit["hit"] for hit in hits.values()) > 5 or size < 0.3
    assert (
        total["restarts"] + total["restarts_after_tests"] > 0
        or size == 0.3
        or int(dut.StackDepth.value) > 4
    )
    assert all(len(r) > 1 for r in steps.rays_of_slot.values())
    assert len(steps.rays_of_slot) == slots


def scene_of_stack(rng, depth, size):
    """A scene whose rays may have just so many entries on their stack, and no more."""
    triangles = soup(rng, 400, size)
    scenes = (Scene(triangles[:count]) for count in range(1, 400))
    return next(scene for scene in scenes if scene.image.stack_bound == depth)


@only_if(not parameter("Restart", 1))
@cocotb.parametrize(size=[0.5, 0.1, 0.02])
async def a_stack_as_deep_as_the_tree_asks_never_overflows(dut, size):
    """The unit asserts that it has room for each entry."""
    rng, _ = await setup(dut)
    scene = scene_of_stack(rng, int(dut.StackDepth.value), size)
    put_scene(dut, scene)
    model, steps = tracer_of(dut, scene), Steps(dut)
    ImageMemory(dut, scene.bytes, BASE)
    LeafTests(dut, scene, rng)
    rays = [r for r in random_rays(rng, 300) if dispatch(scene, r) is not None]

    hits = await all_hits(dut, [dispatch(scene, r, i) for i, r in enumerate(rays)])

    for i, given in enumerate(rays):
        traced = trace(model, given)
        assert steps.nodes[i] == nodes_of(traced) and hits[i] == hit_of(traced, i, 0), given
        assert traced.restarts == 0


@cocotb.test()
async def a_step_takes_its_latency_and_that_of_a_hit(dut):
    """One ray, all nodes in the L1."""
    await setup(dut)
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

    between = {later - sooner for sooner, later in pairwise(answers)}
    assert between == {int(dut.StepLatency.value) + ra_hit()} and len(answers) == 7


@cocotb.test(skip=parameter("NumSlots") < SLOTS_TO_FILL)
@cocotb.parametrize(misses=[True, False])
async def takes_one_step_every_cycle(dut, misses):
    """With all nodes in the L1 and a ray always waiting, over 1000 cycles."""
    rng, events = await setup(dut)
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
    before, since = events.counts(), cycle()
    await ClockCycles(dut.clk_i, 1000)
    done, until = events.since(before), cycle()

    assert done["l1_misses"] == 0 and done["rays"] > 0
    assert done["steps"] == done["works"] == until - since == 1000


@cocotb.test()
async def takes_a_ray_in_every_cycle_while_slots_are_free(dut):
    """As many in a row as there are slots, whether they are new or come back."""
    await setup(dut)
    slots = int(dut.NumSlots.value)
    put_nodes(dut, [(0, 3)])
    source, sink = Source(dut, "dispatch"), Sink(dut, "hit")

    for _ in range(3):
        since = cycle()
        await source.send(lone_ray(i) for i in range(slots))
        assert cycle() - since == slots
        await ClockCycles(dut.clk_i, 20)
        hits = [payloads().unpack("hit_t", bits) for bits in await sink.receive(slots)]
        assert {hit["ray_id"] for hit in hits} == set(range(slots))


@cocotb.test()
async def a_flush_makes_it_ask_for_its_lines_again(dut):
    await setup(dut)
    memory = put_nodes(dut, [inner(7, split=9.0)] * 12 + [(0, 3)])

    async def lines_asked_for():
        before = len(memory.asked)
        await all_hits(dut, [lone_ray()])
        return memory.asked[before:]

    first = await lines_asked_for()
    assert first and await lines_asked_for() == []
    dut.flush_i.value = 1
    await RisingEdge(dut.clk_i)
    dut.flush_i.value = 0
    assert await lines_asked_for() == first


@cocotb.test()
async def tells_what_it_does_in_each_cycle(dut):
    """Nothing to do, a line held back, a ray alone, takers that wait, a ray with its tests."""
    _, events = await setup(dut)
    held = [False]
    memory = put_nodes(
        dut, [inner(7, split=9.0), (0, 4 << 3 | 3)], latency=lambda: None if held[0] else 5
    )
    source, leaf, hit = Source(dut, "dispatch"), Sink(dut, "leaf"), Sink(dut, "hit")
    results = Source(dut, "return")

    async def during(cycles):
        before = events.counts()
        await ClockCycles(dut.clk_i, cycles)
        return events.activities(before)

    assert await during(20) == {"empty": 20}

    held[0] = True
    await source.send([lone_ray()])
    await ClockCycles(dut.clk_i, 10)
    assert await during(30) == {"memory": 30}
    memory.release(memory.held()[0])
    await ClockCycles(dut.clk_i, 60)

    for _ in range(2):  # the second time the line is in the L1
        assert await during(30) == {"room": 30}  # its leaf is not taken
        [bits] = await leaf.receive(1)
        assert await during(30) == {"results": 30}
        home = payloads().unpack("leaf_t", bits)["home"]
        await results.send([payloads().pack("return_t", home=home, count=4)])
        await ClockCycles(dut.clk_i, 10)
        assert await during(30) == {"room": 30}  # its hit is not taken
        await hit.receive(1)
        assert await during(30) == {"empty": 30}
        before = events.counts()
        await source.send([lone_ray()])
        await ClockCycles(dut.clk_i, 60)
        moves = events.activities(before)
        first = 2 + ra_hit()  # queue and arbiter
        between = int(dut.StepLatency.value) + ra_hit() - 1
        assert [moves[k] for k in ("empty", "works", "latency", "results")] == [
            1,
            2,
            first + between + int(dut.ArithmeticLatency.value),
            1,  # the leaf on its way out
        ]


# The machine in shapes that differ, and which of the tests above and of trv_damage.py each runs.
BUILDS = {
    "tiny": ("trv_slots=8", {"NumSlots": 8, "StackDepth": 4, "WatchdogSteps": 400}, None),
    "least": (
        "trv_slots=2",
        {"NumSlots": 2, "StackDepth": 1, "WatchdogSteps": 60, "Rows": 1},
        None,
    ),
    "no stack": ("trv_slots=4", {"NumSlots": 4, "StackDepth": 0}, None),
    "half": ("trv_slots=4 exp_bits=7 frac_bits=16", {"NumSlots": 4, "StackDepth": 2}, None),
    "large": (
        "trv_slots=32",
        {"NumSlots": 32, "StackDepth": 8, "CacheBytes": 32768, "Ways": 4},
        None,
    ),
    "no restarts": (
        "trv_slots=8 restart=false",
        {"NumSlots": 8, "StackDepth": 24, "Restart": 0},
        "every_ray|memory_error|the_watchdog|a_step",
    ),
    "compared first": (
        "trv_slots=8 fp_cmp_stages=1 lookup_stages=5",
        {"NumSlots": 8},
        "every_ray|memory_error|the_watchdog|a_step|activity",
    ),
    "padded": (
        "trv_slots=8 traversal=padded",
        {"NumSlots": 8, "Padded": 1, "WatchdogSteps": TRAIL_LEVELS},
        None,
    ),
    "padded, no stack": (
        "trv_slots=4 traversal=padded exp_bits=5 frac_bits=10 fp_cmp_stages=1",
        {"NumSlots": 4, "StackDepth": 0, "Padded": 1},
        "every_ray|last_level",
    ),
    "just deep enough": (
        "trv_slots=8 restart=false",
        {"NumSlots": 8, "StackDepth": 6, "Restart": 0},
        "a_stack_as_deep",
    ),
}


@pytest.mark.parametrize("build", BUILDS)
def test_ti_trv(build):
    overrides, params, only = BUILDS[build]
    params = {"WatchdogSteps": 400, **params}
    modules = ["test_ti_trv", "trv_damage"]
    run("ti_trv", modules, config=f"tiny {overrides}", params=params, only=only)
