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
        self.snapshots = configuration()["counter_snapshot"]

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

    async def snapshot(self, events=0):
        """One cycle with these events, in which the second rank is filled."""
        self._dut.snapshot_i.value = 1
        await self.cycle(events)
        self._dut.snapshot_i.value = 0

    async def all(self):
        """All counts as they are, or of a snapshot taken now."""
        if self.snapshots:
            await self.snapshot()
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
    await counters.all()
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
    await counters.all()
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
async def what_is_read_is_of_the_last_snapshot_or_of_now(dut):
    rng = await start(dut)
    counters = Counters(dut)
    count, shown = [0] * counters.num, [0] * counters.num
    for _ in range(300):
        events = rng.getrandbits(counters.num)
        if rng.random() < 0.1:
            shown = list(count)  # without the events of its own cycle
            await counters.snapshot(events)
        else:
            await counters.cycle(events)
        count = [number + (events >> i & 1) for i, number in enumerate(count)]
        index = rng.randrange(counters.num)
        want = shown if counters.snapshots else count
        assert await counters.read(index) == counters.of(want)[index]


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
    ("num", "keys"),
    [(1, ""), (11, ""), (5, "counters=0"), (11, "counter_snapshot=1")],
    ids=["one", "eleven", "not built", "snapshot"],
)
def test_ti_counters(num, keys):
    run("ti_counters", "test_ti_counters", config=f"tiny {keys}".strip(), Num=num)
