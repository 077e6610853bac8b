# SPDX-License-Identifier: Apache-2.0
"""`ti_counters` counts each event alone while it runs and gives a count a cycle after its index."""

import cocotb
import pytest
from agents.bench import run, start
from cocotb.triggers import ReadOnly, RisingEdge
from models.payload import configuration, payloads


class Counters:
    def __init__(self, dut):
        self._dut = dut
        self.num = int(dut.Num.value)
        self.built = configuration()["counters"]

    async def cycle(self, events=0, run=1):
        """One cycle with these events."""
        self._dut.events_i.value, self._dut.run_i.value = events, run
        await RisingEdge(self._dut.clk_i)
        self._dut.events_i.value = 0

    async def read(self, index):
        self._dut.index_i.value = index
        await RisingEdge(self._dut.clk_i)
        await ReadOnly()
        count = int(self._dut.count_o.value)
        await RisingEdge(self._dut.clk_i)
        return count

    async def all(self):
        return [await self.read(index) for index in range(self.num)]

    def of(self, counts):
        """What must be read of these counts."""
        return counts if self.built else [0] * self.num


@cocotb.test()
async def each_event_counts_alone(dut):
    await start(dut)
    counters = Counters(dut)
    want = [0] * counters.num
    for event in range(counters.num):
        for _ in range(event + 3):
            await counters.cycle(1 << event)
        want[event] += event + 3
        assert await counters.all() == counters.of(want)


@cocotb.test()
@cocotb.parametrize(p_run=[0.5, 1.0])
async def counts_every_event_of_every_cycle_while_it_runs(dut, p_run):
    rng = await start(dut)
    counters = Counters(dut)
    want = [0] * counters.num
    for _ in range(1000):
        events, runs = rng.getrandbits(counters.num), rng.random() < p_run
        await counters.cycle(events, runs)
        if runs:
            want = [count + (events >> i & 1) for i, count in enumerate(want)]
    assert await counters.all() == counters.of(want)


@cocotb.test()
async def run_holds_the_counts(dut):
    await start(dut)
    counters = Counters(dut)
    full = (1 << counters.num) - 1
    for run_ in (1, 0, 1, 0):
        for _ in range(10):
            await counters.cycle(full, run_)
    assert await counters.all() == counters.of([20] * counters.num)


@cocotb.test()
async def an_index_beyond_the_last_reads_zero(dut):
    await start(dut)
    counters = Counters(dut)
    for _ in range(10):
        await counters.cycle((1 << counters.num) - 1)
    beyond = range(counters.num, 1 << payloads().width("event_index_t"))
    assert len(beyond) > 0
    assert [await counters.read(index) for index in beyond] == [0] * len(beyond)


@cocotb.test()
async def a_count_comes_one_cycle_after_its_index_every_cycle(dut):
    rng = await start(dut)
    counters = Counters(dut)
    for event in range(counters.num):
        for _ in range(event + 1):
            await counters.cycle(1 << event)
    before = None
    for _ in range(100):
        index = rng.randrange(counters.num)
        dut.index_i.value = index
        await ReadOnly()
        if before is not None:
            assert int(dut.count_o.value) == counters.of(range(1, counters.num + 1))[before]
        await RisingEdge(dut.clk_i)
        before = index


@cocotb.test()
async def starts_at_zero_after_reset(dut):
    await start(dut)
    counters = Counters(dut)
    await counters.cycle((1 << counters.num) - 1)
    dut.rst_ni.value = 0
    await counters.cycle()
    dut.rst_ni.value = 1
    assert await counters.all() == [0] * counters.num


@pytest.mark.parametrize(
    ("num", "built"), [(1, 1), (11, 1), (5, 0)], ids=["one", "eleven", "not built"]
)
def test_ti_counters(num, built):
    run("ti_counters", "test_ti_counters", config=f"tiny counters={built}", Num=num)
