# SPDX-License-Identifier: Apache-2.0
"""`ti_cdc_fifo` gives each beat once, in order, at any two clocks, as fast as the slower one.

`TI_SYNC_JITTER` has each synchroniser see the last change of a bit early or late, at random.
"""

import random

import cocotb
import pytest
from agents.bench import run
from agents.stream import Sink, Source, stalls
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, RisingEdge, Timer
from cocotb.utils import get_sim_time
from models.payload import parameter

# Periods in ps of the writer's and the reader's clock.
PERIODS = [
    (10000, 10000),
    (10000, 3700),
    (3700, 10000),
    (10000, 9990),
    (1000, 17300),
    (17300, 1000),
]


class Crossing:
    """Two clocks with a phase between them, both sides out of reset."""

    def __init__(self, dut, rng, periods):
        self.dut, self.rng, self.periods = dut, rng, periods
        self.depth, self.stages = int(dut.Depth.value), int(dut.SyncStages.value)
        self.source = Source(dut, "in", clk=dut.in_clk_i)
        self.sink = Sink(dut, "out", clk=dut.out_clk_i)

    async def reset(self, last="out"):
        """Both sides at once; `last` comes out some cycles behind the other."""
        dut = self.dut
        dut.in_rst_ni.value = dut.out_rst_ni.value = 0
        await ClockCycles(dut.in_clk_i, 3)
        await ClockCycles(dut.out_clk_i, 3)
        for side in ("out", "in") if last == "in" else ("in", "out"):
            await ClockCycles(getattr(dut, f"{side}_clk_i"), self.rng.randint(1, 20))
            getattr(dut, f"{side}_rst_ni").value = 1
        await RisingEdge(dut.out_clk_i)

    async def slower(self, cycles):
        slow = self.periods[0] >= self.periods[1]
        await ClockCycles(self.dut.in_clk_i if slow else self.dut.out_clk_i, cycles)


async def begin(dut, periods, last="out"):
    rng = random.Random(cocotb.RANDOM_SEED)
    crossing = Crossing(dut, rng, periods)
    for name, period in zip(("in", "out"), periods, strict=True):
        clock = Clock(getattr(dut, f"{name}_clk_i"), period, unit="ps", period_high=period // 2)
        clock.start()
        await Timer(rng.randint(1, period), "ps")
    await crossing.reset(last)
    return crossing


@cocotb.test()
@cocotb.parametrize(periods=PERIODS, p_gap=[0.0, 0.6], p_stall=[0.0, 0.6])
async def every_beat_comes_once_and_in_order(dut, periods, p_gap, p_stall):
    crossing = await begin(dut, periods)
    rng = crossing.rng
    sent = [rng.getrandbits(16) for _ in range(300)]
    cocotb.start_soon(crossing.source.send(sent, stalls(rng, p_gap)))
    assert await crossing.sink.receive(len(sent), lambda: rng.random() >= p_stall) == sent
    await crossing.sink.expect_none(40)


@cocotb.test()
async def at_random_ratios_too(dut):
    rng = random.Random(cocotb.RANDOM_SEED)
    crossing = None
    for _ in range(8):
        periods = tuple(rng.randrange(1000, 20000, 2) for _ in range(2))
        clocks = [
            Clock(signal, period, unit="ps", period_high=period // 2)
            for signal, period in zip((dut.in_clk_i, dut.out_clk_i), periods, strict=True)
        ]
        for clock in clocks:
            clock.start()
            await Timer(rng.randint(1, 20000), "ps")
        crossing = Crossing(dut, rng, periods)
        await crossing.reset()
        sent = [rng.getrandbits(16) for _ in range(100)]
        cocotb.start_soon(crossing.source.send(sent, stalls(rng, 0.3)))
        assert await crossing.sink.receive(100, lambda: rng.random() < 0.7) == sent
        for clock in clocks:
            clock.stop()


@cocotb.test()
@cocotb.parametrize(periods=PERIODS[:4])
async def holds_depth_beats_and_the_one_at_the_output(dut, periods):
    crossing = await begin(dut, periods)
    cocotb.start_soon(crossing.source.send(range(100)))
    await crossing.slower(crossing.depth + 4 * crossing.stages + 20)
    assert dut.in_ready_o.value == 0
    assert int(dut.in_data_i.value) == crossing.depth + 1, "number of the beat that waits"
    assert await crossing.sink.receive(100) == list(range(100))


@cocotb.test(skip=parameter("Depth") < 2 * parameter("SyncStages") + 4)
@cocotb.parametrize(periods=PERIODS)
async def moves_a_beat_a_cycle_of_the_slower_clock(dut, periods):
    crossing = await begin(dut, periods)
    cocotb.start_soon(crossing.source.send(range(300)))
    await crossing.sink.receive(50)
    before = get_sim_time("ps")
    await crossing.sink.receive(200)
    cycles = (get_sim_time("ps") - before) / max(periods)
    assert cycles <= 202, cycles


@cocotb.test()
@cocotb.parametrize(periods=PERIODS[:3], late=["in", "out"])
async def either_side_may_come_out_of_reset_first(dut, periods, late):
    crossing = await begin(dut, periods, last=late)
    sent = list(range(60))
    cocotb.start_soon(crossing.source.send(sent))
    assert await crossing.sink.receive(60) == sent


@cocotb.test()
@cocotb.parametrize(periods=PERIODS[:4])
async def a_reset_of_both_sides_forgets_all_beats(dut, periods):
    crossing = await begin(dut, periods)
    for count in (3, crossing.depth + 1):
        task = cocotb.start_soon(crossing.source.send(range(count)))
        await crossing.slower(crossing.depth + 20)
        assert task.done()
        crossing.sink = Sink(dut, "out", clk=dut.out_clk_i)
        await crossing.reset()
        await crossing.sink.expect_none(20)
        sent = [100 + i for i in range(30)]
        cocotb.start_soon(crossing.source.send(sent))
        assert await crossing.sink.receive(30) == sent


@pytest.mark.parametrize(("depth", "stages"), [(8, 2), (2, 3)])
def test_ti_cdc_fifo(depth, stages):
    run(
        "ti_cdc_top",
        "test_ti_cdc_fifo",
        defines={"TI_SYNC_JITTER": 1},
        Depth=depth,
        SyncStages=stages,
    )
