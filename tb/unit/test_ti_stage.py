# SPDX-License-Identifier: Apache-2.0
"""`ti_stage` delivers every beat once, in order, a cycle later, under any stall pattern."""

import cocotb
from agents.bench import cycle, run, start
from agents.stream import Sink, Source, stalls
from cocotb.triggers import ReadOnly, RisingEdge

STAGE = 0  # the stream of the top that is a `ti_stage`


@cocotb.test()
@cocotb.parametrize(p_gap=[0.0, 0.6], p_stall=[0.0, 0.6])
async def keeps_order_under_backpressure(dut, p_gap, p_stall):
    rng = await start(dut)
    source, sink = Source(dut, "in", STAGE), Sink(dut, "out", STAGE)
    sent = [rng.getrandbits(16) for _ in range(500)]

    cocotb.start_soon(source.send(sent, gap=stalls(rng, p_gap)))
    got = await sink.receive(len(sent), ready=lambda: rng.random() >= p_stall)

    assert got == sent
    await sink.expect_none(4)


@cocotb.test()
async def moves_one_beat_a_cycle_with_a_latency_of_one(dut):
    rng = await start(dut)
    source, sink = Source(dut, "in", STAGE), Sink(dut, "out", STAGE)
    sent = [rng.getrandbits(16) for _ in range(64)]
    before = cycle()

    cocotb.start_soon(source.send(sent))
    got = await sink.receive(len(sent))

    assert got == sent
    assert cycle() - before == 1 + len(sent)


@cocotb.test()
async def holds_exactly_one_beat(dut):
    await start(dut)
    source, sink = Source(dut, "in", STAGE), Sink(dut, "out", STAGE)
    sending = cocotb.start_soon(source.send([1, 2]))
    for _ in range(8):
        await RisingEdge(dut.clk_i)
    await ReadOnly()
    assert source.ready.value == 0 and sink.valid.value == 1 and not sending.done()
    await RisingEdge(dut.clk_i)

    assert await sink.receive(2) == [1, 2]
    await sink.expect_none(4)


@cocotb.test()
async def forgets_its_beat_on_reset(dut):
    await start(dut)
    await Source(dut, "in", STAGE).send([1])
    dut.rst_ni.value = 0
    await RisingEdge(dut.clk_i)
    dut.rst_ni.value = 1

    await Sink(dut, "out", STAGE).expect_none(4)


def test_ti_stage():
    run("ti_common_top", "test_ti_stage")
