# SPDX-License-Identifier: Apache-2.0
"""`ti_engine` gives each ray back once with the model's hit, in any shape, memory and stalls."""

import json
import struct
from pathlib import Path

import cocotb
import pytest
from agents.axi_memory import DECERR, EXOKAY, OKAY, SLVERR
from agents.bench import run, start
from agents.engine import Bench
from cocotb.triggers import ClockCycles
from models.numbers import numbers
from models.payload import configuration
from models.rays import bad_rays, parallel_rays, ray
from models.scene import BASE, soup
from models.traced import NO_PRIM

STATUS_OK, INVALID_RAY, MEMORY_ERROR, WATCHDOG = range(4)
WATCHDOG_STEPS = 40  # few, so that some rays reach it
HARD_CASES = Path(__file__).resolve().parents[2] / "scenes/hardcases.jsonl"


@cocotb.test()
@cocotb.parametrize(
    (("p_valid", "p_ready", "latency"), [(1.0, 1.0, 1), (1.0, 1.0, 100), (0.2, 0.3, 30)])
)
async def every_ray_comes_back_once_with_the_hit_of_the_model(dut, p_valid, p_ready, latency):
    rng = await start(dut)
    bench = Bench(
        dut,
        rng,
        latency=lambda: rng.randint(1, latency),
        ready=lambda: rng.random() < p_ready,
        resp=lambda: rng.choice((OKAY, EXOKAY)),
    )
    bench.put_scene(soup(rng, 120))
    odd = [bench.ray(given, rng.getrandbits(1)) for given in (*bad_rays(), *parallel_rays())]
    rays = [*bench.rays(90), *rng.sample(odd, 30)]
    rng.shuffle(rays)

    hits = await bench.trace(rays, p_valid, lambda: rng.random() < p_ready)

    assert bench.check(rays, hits) == {STATUS_OK, INVALID_RAY, WATCHDOG}
    await bench.check_counters(rays)


@cocotb.test()
async def a_hit_port_that_waits_for_long_loses_nothing(dut):
    rng = await start(dut)
    bench = Bench(dut, rng)
    bench.put_scene(soup(rng, 60))
    rays = list(bench.rays(200))
    tasks = bench.send(rays)
    await ClockCycles(dut.clk_i, 5000)
    asked = bench.asked()
    await ClockCycles(dut.clk_i, 2000)
    assert not any(task.done() for task in tasks), "it cannot hold all these rays"
    assert bench.asked() == asked, "everything inside waits for the hit port"

    bench.check(rays, await bench.collect(rays))
    await bench.check_counters(rays)


@cocotb.test()
async def a_memory_that_takes_no_request_for_long_only_delays(dut):
    rng = await start(dut)
    awake = [False]
    bench = Bench(dut, rng, ready=lambda: awake[0])
    bench.put_scene(soup(rng, 60))
    rays = list(bench.rays(40))

    async def wake():
        await ClockCycles(dut.clk_i, 3000)
        assert bench.asked() == 0
        awake[0] = True

    cocotb.start_soon(wake())
    bench.check(rays, await bench.trace(rays))


@cocotb.test()
@cocotb.parametrize(share=[0.02, 0.3, 1.0])
async def an_error_response_ends_the_rays_that_need_the_line_and_no_other(dut, share):
    rng = await start(dut)
    share_now = [share]
    bench = Bench(
        dut,
        rng,
        latency=lambda: rng.randint(1, 40),
        resp=lambda: rng.choice((SLVERR, DECERR)) if rng.random() < share_now[0] else OKAY,
    )
    bench.put_scene(soup(rng, 120))
    rays = list(bench.rays(120))

    hits = await bench.trace(rays, 0.8, lambda: rng.random() < 0.6)

    spoilt = 0
    for given in rays:
        hit = hits[given["ray_id"]]
        if hit["status"] == MEMORY_ERROR:
            spoilt += 1
            nothing = {"hit": 0, "prim": NO_PRIM, "t": numbers().inf, "u": 0, "v": 0}
            assert {k: hit[k] for k in nothing} == nothing
        else:
            assert hit == bench.expected(given)[0]
    assert spoilt > 0
    if share == 1.0:
        assert all(
            (hits[r["ray_id"]]["status"] == MEMORY_ERROR) == (bench.expected(r)[1].steps > 0)
            for r in rays
        )

    share_now[0] = 0.0  # nothing of a bad answer may stay
    again = [bench.ray({k: given[k] for k in ("o", "d", "tmin", "tmax")}) for given in rays[:40]]
    bench.check(again, await bench.trace(again))


@cocotb.test()
async def a_tree_that_leads_in_a_circle_ends_by_the_watchdog(dut):
    """Each inner node has itself as its other child, at a plane that every ray finds beyond."""
    rng = await start(dut)
    bench = Bench(dut, rng)

    def circle(scene):
        data = bytearray(scene.bytes)
        for i, (value, link) in enumerate(scene.nodes):
            if link & 3 != 3:
                node = struct.pack("<II", value, i << 3 | link & 7)
                place = scene.image.node_offset + 8 * i
                data[place : place + 8] = node
        return bytes(data)

    bench.put_scene(soup(rng, 60), circle)
    rays = list(bench.rays(60))
    hits = await bench.trace(rays)

    ended = [hit for hit in hits.values() if hit["status"] == WATCHDOG]
    assert len(ended) > 10
    assert all((h["steps"], h["hit"], h["prim"]) == (WATCHDOG_STEPS, 0, NO_PRIM) for h in ended)


@cocotb.test()
@cocotb.parametrize(after=[1, 7, 50, 333, 1000])
async def a_reset_in_the_middle_of_traffic_forgets_all_of_it(dut, after):
    """Answers to reads from before the reset still come, before rays do, and do no harm."""
    rng = await start(dut)
    bench = Bench(dut, rng, latency=lambda: rng.randint(1, 60))
    bench.put_scene(soup(rng, 120))
    rays = list(bench.rays(400))
    tasks = [*bench.send(rays), cocotb.start_soon(bench.collect(rays))]
    await ClockCycles(dut.clk_i, after)
    for task in tasks:
        task.cancel()

    dut.rst_ni.value, dut.ray_valid_i.value, dut.hit_ready_i.value = 0, 0, 0
    await ClockCycles(dut.clk_i, 2)
    for memory in bench.memories:
        memory.withdraw()
    assert dut.hit_valid_o.value == 0 and int(dut.m_axi_arvalid.value) == 0
    dut.rst_ni.value = 1
    await ClockCycles(dut.clk_i, 1)
    bench = bench.after_reset()
    await bench.expect_no_hit(200)
    assert bench.in_flight() == 0 and dut.idle_o.value == 1

    bench.put_scene(soup(rng, 120))
    rays = list(bench.rays(50))
    bench.check(rays, await bench.trace(rays))


@cocotb.test()
async def counters_are_zero_after_a_reset_and_hold_while_they_are_stopped(dut):
    rng = await start(dut)
    bench = Bench(dut, rng)
    bench.put_scene(soup(rng, 30))
    rays = list(bench.rays(50))
    await bench.trace(rays)
    await bench.check_counters(rays)
    dut.rst_ni.value = 0
    await ClockCycles(dut.clk_i, 2)
    dut.count_run_i.value, dut.rst_ni.value = 0, 1
    await ClockCycles(dut.clk_i, 100)
    sums, accounts = await bench.counters()
    assert accounts == {0} and not any(any(unit.values()) for unit in sums.values())


@cocotb.test()
async def answers_to_nothing_that_was_asked_for_are_dropped(dut):
    rng = await start(dut)
    bench = Bench(dut, rng, latency=lambda: rng.randint(1, 30))
    bench.put_scene(soup(rng, 60))

    few = (
        configuration()["max_reads"] // 2
    )  # the identity of an answer is used again later than that
    for memory in bench.memories:
        memory.repeat = lambda memory=memory: memory.in_flight() < few and rng.random() < 0.2

    rays = list(bench.rays(400))
    bench.check(rays, await bench.trace(rays))
    sums, _ = await bench.counters()
    assert sums["axi"]["strays"] == sum(memory.strays for memory in bench.memories) > 20


@cocotb.test()
async def a_flush_waits_for_rays_and_makes_another_scene_at_the_same_place_seen(dut):
    rng = await start(dut)
    bench = Bench(dut, rng, latency=lambda: rng.randint(1, 40))
    for _ in range(4):
        bench.put_scene(soup(rng, 40))
        rays = list(bench.rays(40))
        sending = bench.send(rays)
        hits = cocotb.start_soon(bench.collect(rays, lambda: rng.random() < 0.5))
        for task in sending:
            await task
        dut.flush_i.value = 1
        await ClockCycles(dut.clk_i, 1)
        dut.ray_valid_i.value = (1 << len(bench.streams)) - 1  # nobody takes them
        for _ in range(rng.randint(1, 30)):
            await ClockCycles(dut.clk_i, 1)
            assert dut.ray_ready_o.value == 0, "no ray is accepted during a flush"
        dut.ray_valid_i.value = 0
        bench.check(rays, await hits)
        await ClockCycles(dut.clk_i, 3)
        assert dut.idle_o.value == 1
        dut.flush_i.value = 0
        bench.forget_scenes()  # the next one comes to the same place


@cocotb.test()
async def a_new_scene_waits_for_the_rays_of_the_old_one(dut):
    """It comes while they are inside, to another place, so that nothing needs a flush."""
    rng = await start(dut)
    bench = Bench(dut, rng, latency=lambda: rng.randint(1, 40))
    bench.put_scene(soup(rng, 60))
    for _ in range(4):
        rays = list(bench.rays(30))  # nobody takes hits, so they must all have room inside
        for task in bench.send(rays):
            await task
        want = {given["ray_id"]: bench.expected(given)[0] for given in rays}
        bench.put_scene(soup(rng, 60))
        assert dut.idle_o.value == 0
        assert await bench.collect(rays) == want


@cocotb.test()
async def each_unit_counts_for_itself(dut):
    """The first ray goes to the first TRV of the first core, and from there to the first LIST."""
    rng = await start(dut)
    bench = Bench(dut, rng)
    bench.put_scene(soup(rng, 60))
    given = next(given for given in bench.rays(1000) if bench.expected(given)[1].full_leaves > 0)
    traced = bench.expected(given)[1]
    await bench.trace([given])
    for unit, event, count in (
        ("rd", "rays", 1),
        ("trv", "rays", 1),
        ("trv", "steps", traced.steps),
        ("list", "ids", traced.a_tests),
        ("axi", "lines", bench.asked()),
    ):
        counts = await bench.each(unit, event)
        assert counts == [count, *[0] * (len(counts) - 1)], f"{event} of {unit}"


@cocotb.test()
async def without_a_flush_lines_stay(dut):
    rng = await start(dut)
    bench = Bench(dut, rng)
    bench.put_scene(soup(rng, 2))  # fits into the caches
    rays = list(bench.rays(30))
    await bench.trace(rays)
    before = bench.asked()
    again = [bench.ray({k: given[k] for k in ("o", "d", "tmin", "tmax")}) for given in rays]
    bench.check(again, await bench.trace(again))
    assert bench.asked() - before < before / 2


@cocotb.test()
async def a_corrupt_list_ends_its_rays_with_an_error(dut):
    """Triangle numbers beyond the scene, also those that would wrap around the address space."""
    rng = await start(dut)
    bench = Bench(dut, rng)

    def corrupt(scene):
        data = bytearray(scene.bytes)
        for i in range(len(scene.ids)):
            wrong = rng.choice((scene.count, 1 << 27, (1 << 27) + 1, (1 << 29) - 1, 1 << 31))
            place = scene.list_base - BASE + 4 * i
            data[place : place + 4] = struct.pack("<I", wrong)
        return bytes(data)

    bench.put_scene(soup(rng, 60), corrupt)
    rays = list(bench.rays(100))
    hits = await bench.trace(rays)
    for given in rays:
        needs = bench.expected(given)[1].full_leaves > 0
        assert (hits[given["ray_id"]]["status"] == MEMORY_ERROR) == needs
    assert any(hit["status"] == MEMORY_ERROR for hit in hits.values())


@cocotb.test()
async def hard_cases_have_the_bits_of_the_model(dut):
    """Each in a scene of its own, one after the other without a reset."""
    rng = await start(dut)
    bench = Bench(dut, rng)
    n = numbers()

    def values(words):
        return [struct.unpack(">f", bytes.fromhex(word))[0] for word in words]

    for line in HARD_CASES.read_text().splitlines():
        case = json.loads(line)
        bench.put_scene([[tuple(values(corner)) for corner in tri] for tri in case["tris"]])
        o, d = n.vec(values(case["o"])), n.vec(values(case["d"]))
        tmin, tmax = n.vec(values((case["tmin"], case["tmax"])))
        rays = [bench.ray(ray(o, d, tmin, tmax), any_hit) for any_hit in (0, 1, 0)]

        try:
            bench.check(rays, await bench.trace(rays))
        except AssertionError as error:
            raise AssertionError(f"case {case['n']}, {case['name']}: {error}") from None


# The machine in shapes that differ, and which of the tests above each runs.
SOME = "every_ray|hit_port|share=0.3|after=333|stay|dropped|flush|corrupt|new_scene|for_itself"
SHAPES = {
    "tiny": ("", None),
    "cores": (
        "cores=2 streams=1 core_tile=4 num_trv=3 num_list=2 num_ist1=3 deal_tile=4 stack_depth=0 "
        "rd_cycles=1 trv_l2_bytes=2048 trv_l2_banks=2 trv_l2_ways=2 ist1_l2_bytes=1024 "
        "lookup_stages=2 l2_latency=9 ist1_l2_ways=1 ist1_spill=3",
        SOME,
    ),
    "short_lines": (
        "cores=2 num_trv=3 num_list=3 num_ist1=2 line_bytes=32 max_reads=4 rd_cycles=2 "
        "interval_cull=false early_exit=false ray_accumulation=retry "
        "ist1_choice=slot list_l2_bytes=256 list_l2_ways=2 list_l2_rows=2",
        SOME,
    ),
    "for_a_picture": (
        "num_trv=2 any_hit=false stack_depth=32 restart=false",
        "every_ray|after=333",
    ),
    "format": (
        "exp_bits=7 frac_bits=16 line_bytes=128 num_trv=3 num_list=2 addr_bits=40 "
        "ray_accumulation=blocking "
        "fp_add_stages=10 fp_mul_stages=8 fp_rcp_bits_per_stage=1 fp_rcp_end_stages=5 "
        "fp_cmp_stages=1 lookup_stages=5 fill_bytes=8 ring_delays=0 sync_reset=0",
        f"{SOME}|hard_cases",
    ),
}


@pytest.mark.parametrize("shape", SHAPES)
def test_ti_engine(shape):
    keys, only = SHAPES[shape]
    config = f"tiny watchdog_steps={WATCHDOG_STEPS} {keys}".strip()
    run("ti_engine", "test_ti_engine", config=config, only=only)
