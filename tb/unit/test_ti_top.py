# SPDX-License-Identifier: Apache-2.0
"""`ti_top` traces packets of rays with the model's hits, whatever the host and the buses do."""

from itertools import pairwise

import cocotb
import configure
import counters
import pytest
from agents.bench import run
from agents.top import PERIOD_NS, Top, begin, sources
from cocotb.triggers import ClockCycles
from cocotb.utils import get_sim_time
from cocotbext.axi import AxiResp
from models.payload import configuration
from models.rays import bad_rays
from models.scene import BASE, soup
from ti_regs import REGISTERS

STATUS_OK, INVALID_RAY, MEMORY_ERROR, WATCHDOG = range(4)
WATCHDOG_STEPS = 40  # few, so that some rays reach it


async def running(dut, triangles=60, stall=0.0):
    """A top that takes rays through a scene."""
    top = await begin(dut, stall)
    scene = await top.put_scene(soup(top.rng, triangles))
    await top.write("CONTROL", run=1, count=1)
    return top, scene


@cocotb.test()
async def says_what_it_is(dut):
    top = await begin(dut)
    config = configuration()
    assert (await top.read("ID")).to_bytes(4, "little") == b"T&I1"
    assert await top.read("VERSION") == 1 << 16
    assert await top.read("CONFIG_HASH") == int(parameter_of_machine(), 16)
    for name, keys in {
        "FORMAT": ("exp_bits", "frac_bits"),
        "MACHINE": ("cores", "streams", "any_hit", "counters"),
        "UNITS": ("num_trv", "num_list", "num_ist1"),
        "MEMORY": ("line_bytes", "addr_bits"),
    }.items():
        for key in keys:
            assert await top.read(name, key) == config[key], key
    assert await top.read("MACHINE", "snapshot") == config["counter_snapshot"]
    for name, key, words in (
        ("FORMAT", "rounding", ("nearest", "zero")),
        ("FORMAT", "subnormals", ("keep", "flush")),
        ("MACHINE", "triangle_test", ("local", "np", "woop")),
        ("MACHINE", "traversal", ("plain", "padded")),
        ("MACHINE", "stream_clock", ("core", "own")),
    ):
        assert words[await top.read(name, key)] == config[key], key


def parameter_of_machine():
    """The digest that programs have of this configuration."""
    config = configuration()
    schema = configure.config_schema.load()
    return configure.Configuration(schema, configure.CONFIGS / "tiny.yaml", config, {}).machine


@cocotb.test()
async def registers_start_at_their_reset_values_and_hold_what_is_written(dut):
    top = await begin(dut, stall=0.3)
    for name, register in REGISTERS.items():
        for field, place in register.fields.items():
            if place.reset is not None and name != "SNAPSHOT":
                assert await top.read(name, field) == place.reset, (name, field)
    words = [n for n in REGISTERS if n.startswith(("ROOT", "NUM", "BOX")) or "_BASE_" in n]
    written = {name: top.rng.getrandbits(27) << 5 for name in words}  # parts are aligned
    for name, value in written.items():
        await top.write(name, value)
    assert {name: await top.read(name) for name in words} == written


@cocotb.test()
async def an_address_without_a_register_is_an_error_and_changes_nothing(dut):
    top = await begin(dut)
    mapped = {register.offset for register in REGISTERS.values()}
    before = {name: await top.read(name) for name in REGISTERS if name != "SNAPSHOT"}
    for address in range(0, 256, 4):
        if address not in mapped:
            assert (await top.axil.read(address, 4)).resp == AxiResp.SLVERR
            assert (await top.axil.write(address, b"\xff" * 4)).resp == AxiResp.SLVERR
    for name in ("ID", "VERSION", "MACHINE", "STATUS", "RAYS_LO", "COUNTER_LO"):
        await top.write(name, 0xFFFFFFFF)
    assert {name: await top.read(name) for name in before} == before


@cocotb.test()
@cocotb.parametrize(stall=[0.0, 0.4])
async def the_hits_of_a_packet_are_the_models_and_its_last_one_has_tlast(dut, stall):
    top, _ = await running(dut, 60, stall)
    rays = [*top.rays(80), *top.rng.sample(list(bad_rays()), 10)]
    top.rng.shuffle(rays)
    packets = {stream: rays[stream:] for stream in range(top.config["streams"])}
    for stream, own in packets.items():
        top.send(own, stream)
    for stream, own in packets.items():
        top.check(own, await top.packet(stream))
    await top.until("STATUS", "idle", 1)
    await top.nothing_more()
    number = sum(map(len, packets.values()))
    assert (await top.wide("RAYS"), await top.wide("HITS")) == (number, number)


@cocotb.test()
async def packets_follow_each_other_and_do_not_mix(dut):
    top, _ = await running(dut, 30, 0.2)
    packets = [top.rays(count) for count in (20, 1, 1, 7, 30)]
    for rays in packets:
        top.send(rays)
    for rays in packets:
        top.check(rays, await top.packet())
    await top.nothing_more()


@cocotb.test()
async def a_new_scene_at_the_same_place_is_seen_after_a_flush(dut):
    top, _ = await running(dut)
    for _ in range(2):
        rays = top.rays(20)
        top.check(rays, await top.trace(rays))
        await top.write("CONTROL", run=0, count=1)
        await top.until("STATUS", "idle", 1)
        await top.put_scene(soup(top.rng, 40))
        await top.write("CONTROL", run=1, flush=1, count=1)
        await top.until("CONTROL", "flush", 0)
        assert await top.read("STATUS", "flushing") == 0
    rays = top.rays(20)
    top.check(rays, await top.trace(rays))


@cocotb.test()
async def a_flush_in_flight_waits_for_the_rays_and_loses_none(dut):
    top, _ = await running(dut, 40, 0.2)
    rays = top.rays(100)
    top.send(rays)
    for _ in range(3):
        await ClockCycles(dut.aclk, top.rng.randint(50, 400))
        await top.write("CONTROL", run=1, flush=1, count=1)
    await top.until("CONTROL", "flush", 0)
    top.check(rays, await top.packet())


@cocotb.test()
async def a_flush_in_flight_forgets_all_lines(dut):
    top, _ = await running(dut, 2)  # the caches hold this scene
    rays, reads = top.rays(60), [0]
    for flush in (False, False, True, False):
        top.send(rays)
        if flush:
            await ClockCycles(dut.aclk, 100)
            assert await top.read("STATUS", "idle") == 0 and top.sinks[0].empty()
            await top.write("CONTROL", run=1, flush=1, count=1)
            await top.until("CONTROL", "flush", 0)
        top.check(rays, await top.packet())
        reads.append(sum(memory.reads for memory in top.memories))
    cold, warm, during, behind = (after - before for before, after in pairwise(reads))
    assert warm < cold / 2 and during + behind > 2 * warm


@cocotb.test()
async def without_run_no_ray_is_taken_and_those_inside_come_out(dut):
    top = await begin(dut)
    await top.put_scene(soup(top.rng, 40))
    await top.write("IRQ_ENABLE", drained=1)
    rays = top.rays(60)
    top.send(rays)
    await ClockCycles(dut.aclk, 200)
    assert await top.wide("RAYS") == 0 and await top.read("STATUS", "idle") == 1
    assert dut.irq.value == 0
    await top.write("CONTROL", run=1, count=1)
    await ClockCycles(dut.aclk, 60)
    await top.write("CONTROL", run=0, count=1)
    await top.until("STATUS", "idle", 1)
    taken = await top.wide("RAYS")
    assert 0 < taken < len(rays) and await top.wide("HITS") == taken
    assert dut.irq.value == 1 and await top.read("IRQ_STATUS", "drained") == 1
    await top.write("IRQ_STATUS", drained=1)
    await ClockCycles(dut.aclk, 3)
    assert dut.irq.value == 0 and await top.read("IRQ_STATUS") == 0
    await top.write("CONTROL", run=1, count=1)
    top.check(rays, await top.packet())


@cocotb.test()
async def any_hit_is_taken_over_while_idle(dut):
    top, _ = await running(dut)
    rays = top.rays(40)
    top.send(rays)
    await ClockCycles(dut.aclk, 60)
    await top.write("CONTROL", run=1, any_hit=1, count=1)
    assert await top.read("STATUS", "idle") == 0
    top.check(rays, await top.packet())
    top.check(rays, await top.trace(rays), any_hit=1)


@cocotb.test()
@cocotb.parametrize(kind=["slverr", "decerr"])
async def an_error_of_the_memory_ends_the_rays_that_need_it_and_no_other(dut, kind):
    top, scene = await running(dut, 60, 0.2)
    await top.write("IRQ_ENABLE", memory_error=1)
    size = top.config["line_bytes"]
    middle = (scene.plane_base + 16 * scene.count) // size * size
    for memory in top.memories:
        setattr(memory, kind, range(middle, middle + 4 * size))
    rays = top.rays(80)
    hits = await top.trace(rays)
    wanted = top.expected(rays)
    assert sorted(hit["ray_id"] for hit in hits) == list(range(len(rays)))
    spoilt = [hit for hit in hits if hit["status"] == MEMORY_ERROR]
    assert 0 < len(spoilt) < len(rays)
    assert all(hit == wanted[hit["ray_id"]] for hit in hits if hit["status"] != MEMORY_ERROR)
    assert all(hit["prim"] == 0xFFFFFFFF for hit in spoilt)

    assert await top.read("MEMORY_ERRORS") == len(spoilt)
    assert dut.irq.value == 1 and await top.read("IRQ_STATUS", "memory_error") == 1
    await top.write("IRQ_STATUS", memory_error=1)
    await ClockCycles(dut.aclk, 3)
    assert dut.irq.value == 0
    for memory in top.memories:  # nothing of a bad answer stays
        setattr(memory, kind, range(0))
    top.check(rays, await top.trace(rays))


@cocotb.test()
async def rays_that_end_with_an_error_are_counted_and_raise_the_interrupt(dut):
    top, _ = await running(dut, 100)
    rays = [*top.rays(60), *top.rng.sample(list(bad_rays()), 10)]
    hits = await top.trace(rays)
    top.check(rays, hits)
    await top.until("STATUS", "idle", 1)
    for status, name, bit in (
        (INVALID_RAY, "INVALID_RAYS", "invalid_ray"),
        (WATCHDOG, "WATCHDOGS", "watchdog"),
    ):
        number = sum(hit["status"] == status for hit in hits)
        assert number > 0 and await top.read(name) == number
        assert await top.read("IRQ_STATUS", bit) == 1 and dut.irq.value == 0
        await top.write("IRQ_ENABLE", **{bit: 1})
        await ClockCycles(dut.aclk, 3)
        assert dut.irq.value == 1
        await top.write("IRQ_STATUS", **{bit: 1})
        await ClockCycles(dut.aclk, 3)
        assert dut.irq.value == 0
    assert (
        await top.read("MEMORY_ERRORS") == 0 and await top.read("IRQ_STATUS", "memory_error") == 0
    )


@cocotb.test()
@cocotb.parametrize(after=[40, 700])
async def after_a_reset_in_flight_the_next_packet_is_clean(dut, after):
    top, _ = await running(dut, 60, 0.2)
    top.send(top.rays(200))
    await ClockCycles(dut.aclk, after)
    await top.reset()
    for source in top.sources:
        source.clear()
    assert await top.read("CONTROL") == REGISTERS["CONTROL"].fields["count"].mask
    assert await top.wide("RAYS") == 0 and await top.read("STATUS", "idle") == 1

    await top.put_scene(soup(top.rng, 40), BASE + 0x100000)
    await top.write("CONTROL", run=1, count=1)
    rays = top.rays(40)
    top.check(rays, await top.trace(rays))
    await top.nothing_more()


@cocotb.test()
async def registers_are_read_and_written_while_rays_are_traced(dut):
    top, _ = await running(dut, 40, 0.2)
    rays = top.rays(100)
    top.send(rays)
    mine, moved = top.rng.getrandbits(27) << 5, 0
    old = await top.read("NODE_BASE_LO")
    while top.sinks[0].empty():
        await top.write("NODE_BASE_LO", mine)  # rays inside keep their scene
        assert await top.read("NODE_BASE_LO") == mine
        await top.write("NODE_BASE_LO", old)
        now = await top.wide("RAYS")
        assert moved <= now <= len(rays)
        assert await top.wide("HITS") <= now or await top.wide("RAYS") == len(rays)
        moved = now
    top.check(rays, await top.packet())


@cocotb.test()
async def a_snapshot_is_of_one_cycle_while_rays_are_traced(dut):
    top, _ = await running(dut, 40)
    top.send(top.rays(200))
    await ClockCycles(dut.aclk, 100)
    sums = []
    for _ in range(2):
        await top.write("SNAPSHOT", take=1)
        taken = round(get_sim_time("ns")) // PERIOD_NS
        accounts = await activity(top)
        assert await top.read("STATUS", "idle") == 0
        assert len(set(accounts.values())) == 1, accounts
        sums.append((taken, *set(accounts.values())))
        assert await activity(top) == accounts, "the copy stays"
    (first, before), (second, after) = sums
    assert after - before == second - first > 0


async def activity(top: Top):
    """{(core, unit): sum of its activities}."""
    per_core = sum(counters.counts_of(top.config).values())
    activities = len(counters.description()["activity"])
    return {
        (core, unit): sum([await top.count(core, unit, event) for event in range(activities)])
        for core in range(top.config["cores"])
        for unit in range(per_core)
    }


@cocotb.test()
async def counters_are_the_work_of_the_model_and_stop_with_count(dut):
    top, _ = await running(dut, 40)
    rays = top.rays(20)
    hits = await top.trace(rays)
    await top.until("STATUS", "idle", 1)
    await top.write("CONTROL", run=1, count=0)
    await top.write("SNAPSHOT", take=1)
    accounts = await activity(top)
    assert len(set(accounts.values())) == 1 and min(accounts.values()) > 0
    names = list(counters.events(counters.description(), "trv"))
    first = list(counters.counts_of(top.config)).index("trv")
    steps = [
        await top.count(core, first + unit, names.index("steps"))
        for core in range(top.config["cores"])
        for unit in range(top.config["num_trv"])
    ]
    assert sum(steps) >= sum(hit["steps"] for hit in hits) > 0
    for core, unit, event in ((0, 0, 200), (0, 5000, 0), (77, 0, 0)):
        assert await top.count(core, unit, event) == 0, "beyond the last"
    await ClockCycles(dut.aclk, 100)
    assert await activity(top) == accounts


SHAPES = {
    "tiny": ("counter_snapshot=1", None),
    "own_clocks": (
        "cores=2 streams=2 stream_clock=own exp_bits=7 frac_bits=16 addr_bits=40 sync_reset=0",
        "says_what|hits_of_a_packet|packets_follow|after=700|flush_in_flight|slverr|counters_are",
    ),
}


@pytest.mark.parametrize("shape", SHAPES)
def test_ti_top(shape):
    keys, only = SHAPES[shape]
    config = f"tiny watchdog_steps={WATCHDOG_STEPS} {keys}"
    run(
        "ti_top_wrapper",
        "test_ti_top",
        sources(config),
        config=config,
        defines={"TI_SYNC_JITTER": 1},
        only=only,
    )
