# SPDX-License-Identifier: Apache-2.0
"""`ti_fifo` keeps up to `Depth` beats in order, takes and gives one a cycle, under any stalls."""

import cocotb
from agents.bench import cycle, run, start
from agents.stream import Sink, Source, stalls
from cocotb.triggers import ClockCycles, ReadOnly, RisingEdge

# The streams of the top that are FIFOs, and their depths.
DEPTH = {1: 1, 2: 2, 3: 3, 4: 8, 5: 16}


@cocotb.test()
@cocotb.parametrize(stream=list(DEPTH), p_gap=[0.0, 0.6], p_stall=[0.0, 0.6])
async def keeps_order_under_backpressure(dut, stream, p_gap, p_stall):
    rng = await start(dut)
    source, sink = Source(dut, "in", stream), Sink(dut, "out", stream)
    sent = [rng.getrandbits(16) for _ in range(300)]

    cocotb.start_soon(source.send(sent, gap=stalls(rng, p_gap)))
    got = await sink.receive(len(sent), ready=lambda: rng.random() >= p_stall)

    assert got == sent
    await sink.expect_none(4)


@cocotb.test()
@cocotb.parametrize(stream=list(DEPTH))
async def holds_exactly_depth_beats(dut, stream):
    await start(dut)
    source, sink = Source(dut, "in", stream), Sink(dut, "out", stream)
    cocotb.start_soon(source.send(range(64)))

    for taken in range(20):  # each beat that leaves makes room for one
        await ClockCycles(dut.clk_i, DEPTH[stream] + 2)
        await ReadOnly()
        assert source.ready.value == 0
        assert int(source.data.value) == taken + DEPTH[stream], "number of the beat that waits"
        await RisingEdge(dut.clk_i)
        assert await sink.receive(1) == [taken]


@cocotb.test()
@cocotb.parametrize(stream=list(DEPTH), full=[False, True])
async def moves_one_beat_a_cycle_empty_and_full(dut, stream, full):
    """A FIFO of one entry moves a beat every second cycle: its `ready` is a register."""
    rng = await start(dut)
    source, sink = Source(dut, "in", stream), Sink(dut, "out", stream)
    sent = [rng.getrandbits(16) for _ in range(96)]
    cocotb.start_soon(source.send(sent))
    if full:
        await ClockCycles(dut.clk_i, DEPTH[stream] + 2)
    before = cycle()
    first = await sink.receive(1)
    assert cycle() - before == (1 if full else 2), "latency of 1 cycle, then the beat moves"

    before = cycle()
    rest = await sink.receive(64)

    assert first + rest == sent[:65]
    assert cycle() - before == (128 if DEPTH[stream] == 1 else 64)


@cocotb.test()
@cocotb.parametrize(stream=list(DEPTH))
async def forgets_its_beats_on_reset(dut, stream):
    await start(dut)
    source, sink = Source(dut, "in", stream), Sink(dut, "out", stream)
    await source.send(range(DEPTH[stream]), patience=50)
    dut.rst_ni.value = 0
    await RisingEdge(dut.clk_i)
    dut.rst_ni.value = 1

    await sink.expect_none(4)
    again = list(range(100, 100 + DEPTH[stream]))
    await source.send(again, patience=50)  # the whole room is there
    assert await sink.receive(len(again)) == again


def test_ti_fifo():
    run("ti_common_top", "test_ti_fifo")
