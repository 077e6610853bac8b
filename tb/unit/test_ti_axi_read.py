# SPDX-License-Identifier: Apache-2.0
"""`ti_axi_read` makes one AXI4 burst of one beat of each request and brings every answer back."""

from collections import Counter

import cocotb
import pytest
from agents.axi_memory import DECERR, EXOKAY, OKAY, SLVERR
from agents.axi_reads import FOR_EVER, ROUND_TRIP, begin
from agents.bench import cycle, run
from agents.stream import stalls
from cocotb.triggers import ClockCycles, ReadOnly, RisingEdge
from models.payload import parameter


@cocotb.test()
@cocotb.parametrize(p_gap=[0.0, 0.6], p_arready=[0.2, 1.0], p_stall=[0.0, 0.7], most=[1, 60])
async def answers_every_request_once_with_its_line(dut, p_gap, p_arready, p_stall, most):
    reads = await begin(dut)
    rng, memory = reads.rng, reads.memory
    memory.ready = lambda: rng.random() < p_arready
    memory.latency = lambda: rng.randint(1, most)
    requests = reads.requests(300)

    cocotb.start_soon(reads.source.send(reads.packed(requests), stalls(rng, p_gap)))
    got = await reads.sink.receive(300, lambda: rng.random() >= p_stall, 5000)
    await reads.sink.expect_none(100)

    assert sorted(map(reads.unpacked, got)) == sorted(reads.good(requests))
    assert memory.addresses == [line * reads.line_bytes for _, line in requests]
    assert reads.events == {"lines": 300}


@cocotb.test()
async def answers_come_in_the_order_of_the_memory(dut):
    reads = await begin(dut)
    reads.memory.latency = lambda: reads.rng.randint(1, 40)
    requests = reads.requests(200)
    cocotb.start_soon(reads.source.send(reads.packed(requests)))
    got = [reads.unpacked(beat) for beat in await reads.sink.receive(200)]

    assert [data for _, _, data in got] == [
        reads.data(address // reads.line_bytes) for address, _, _ in reads.memory.answers
    ]
    assert [identity for identity, _, _ in got] != [identity for identity, _ in requests]


@cocotb.test()
async def a_request_and_an_answer_take_one_cycle_each(dut):
    reads = await begin(dut)
    reads.memory.latency = lambda: 1
    (request, *_) = reads.packed(reads.requests(2))
    dut.rsp_ready_i.value = 1
    cocotb.start_soon(reads.source.send([request]))
    came, since = {}, cycle()
    for now in range(10):
        await ReadOnly()
        for name in ("req_valid_i", "m_axi_arvalid", "m_axi_rvalid", "rsp_valid_o"):
            if getattr(dut, name).value == 1:
                came.setdefault(name, now)
        await RisingEdge(dut.clk_i)

    assert cycle() - since == 10
    first = came["req_valid_i"]
    assert came["m_axi_arvalid"] - first == 1
    assert came["rsp_valid_o"] - came["m_axi_rvalid"] == 1


@cocotb.test(skip=parameter("MaxReads") <= ROUND_TRIP)
@cocotb.parametrize(latency=[1, "all the table can bridge"])
async def moves_one_line_a_cycle_each_way(dut, latency):
    reads = await begin(dut, stalls=False)
    cycles = 1 if latency == 1 else reads.max_reads - ROUND_TRIP + 1
    reads.memory.latency = lambda: cycles
    cocotb.start_soon(reads.source.send(reads.packed(reads.requests(1000))))
    await reads.sink.receive(50)
    before, lines, since = cycle(), reads.events["lines"], len(reads.memory.addresses)
    await reads.sink.receive(500)

    assert cycle() - before == 500
    assert reads.events["lines"] - lines == len(reads.memory.addresses) - since == 500


@cocotb.test()
async def keeps_as_many_reads_in_flight_as_it_may_and_no_more(dut):
    reads = await begin(dut)
    memory = reads.memory
    memory.latency = lambda: FOR_EVER
    requests = reads.requests(reads.max_reads + 5)
    cocotb.start_soon(reads.source.send(reads.packed(requests)))
    await ClockCycles(dut.clk_i, reads.max_reads + 50)

    assert memory.in_flight() == reads.max_reads and reads.events["lines"] == reads.max_reads
    assert dut.req_valid_i.value == 1 and dut.req_ready_o.value == 0
    assert reads.activities["room"] >= 45

    # One answer makes room for one request, under the identity that is free now.
    identities = {identity for _, identity, _ in memory._waiting}
    assert identities == set(range(reads.max_reads))
    memory.latency = lambda: FOR_EVER
    for number in range(1, 4):
        at = reads.rng.randrange(reads.max_reads)
        memory._waiting[at] = (0, *memory._waiting[at][1:])
        await reads.sink.receive(1)
        await ClockCycles(dut.clk_i, 10)
        assert memory.in_flight() == reads.max_reads
        assert reads.events["lines"] == reads.max_reads + number


@cocotb.test()
@cocotb.parametrize(p_arready=[0.3, 1.0])
async def holds_the_cap_under_load_and_reuses_ids_after_their_answers(dut, p_arready):
    """The memory checks the ids of requests, the watcher their number."""
    reads = await begin(dut)
    rng, memory = reads.rng, reads.memory
    memory.latency = lambda: rng.randint(1, 8 * reads.max_reads)
    memory.ready = lambda: rng.random() < p_arready
    requests = reads.requests(1000)
    cocotb.start_soon(reads.source.send(reads.packed(requests)))
    got = await reads.sink.receive(1000, lambda: rng.random() < 0.8, 5000)

    assert sorted(map(reads.unpacked, got)) == sorted(reads.good(requests))
    assert reads.activities["room"] > 100, "the table was never full"


@cocotb.test()
async def two_requests_wait_for_a_memory_that_takes_none(dut):
    reads = await begin(dut)
    reads.memory.ready = lambda: 0
    cocotb.start_soon(reads.source.send(reads.packed(reads.requests(8))))
    await ClockCycles(dut.clk_i, 20)

    assert reads.events["lines"] == min(2, reads.max_reads)
    assert dut.m_axi_arvalid.value == 1 and dut.req_ready_o.value == 0


@cocotb.test()
@cocotb.parametrize(resp=[OKAY, EXOKAY, SLVERR, DECERR], last=[1, 0])
async def slverr_decerr_and_a_missing_rlast_are_errors(dut, resp, last):
    reads = await begin(dut)
    reads.memory.resp, reads.memory.last = lambda: resp, lambda: last
    requests = reads.requests(5)
    cocotb.start_soon(reads.source.send(reads.packed(requests)))
    got = await reads.sink.receive(5)
    await reads.sink.expect_none(10)

    bad = resp in (SLVERR, DECERR) or not last
    want = [(identity, 1, None) for identity, _ in requests] if bad else reads.good(requests)
    assert sorted(map(reads.unpacked, got)) == sorted(want)
    assert reads.events["errors"] == (5 if bad else 0)


@cocotb.test()
async def errors_reach_only_their_requests(dut):
    reads = await begin(dut)
    rng, memory = reads.rng, reads.memory
    memory.latency = lambda: rng.randint(1, 30)
    memory.resp = lambda: rng.choice([OKAY, OKAY, EXOKAY, SLVERR, DECERR])
    memory.last = lambda: rng.random() < 0.9
    requests = reads.requests(300)
    cocotb.start_soon(reads.source.send(reads.packed(requests)))
    got = sorted(map(reads.unpacked, await reads.sink.receive(300, lambda: rng.random() < 0.7)))

    bad = Counter(a // reads.line_bytes for a, r, last in memory.answers if r >= SLVERR or not last)
    failed = {identity for identity, error, _ in got if error}
    assert Counter(line for identity, line in requests if identity in failed) == bad
    want = [(i, 1, None) if i in failed else (i, 0, reads.data(line)) for i, line in requests]
    assert got == sorted(want)
    assert reads.events["errors"] == len(failed) > 50


@cocotb.test()
async def drops_and_counts_beats_that_nobody_asked_for(dut):
    reads = await begin(dut)
    for identity in range(reads.max_reads):
        reads.memory.stray(identity)
    await reads.sink.expect_none(reads.max_reads + 5)
    assert reads.events == {"strays": reads.max_reads}

    requests = reads.requests(3)  # all is as it was
    cocotb.start_soon(reads.source.send(reads.packed(requests)))
    got = await reads.sink.receive(3)
    assert sorted(map(reads.unpacked, got)) == sorted(reads.good(requests))


@cocotb.test()
async def drops_a_beat_that_nobody_asked_for_behind_answers_that_wait(dut):
    reads = await begin(dut)
    requests = reads.requests(2)  # as many answers as there are places
    await reads.source.send(reads.packed(requests))
    await ClockCycles(dut.clk_i, 20)
    for identity in range(reads.max_reads):
        reads.memory.stray(identity)
    await ClockCycles(dut.clk_i, 5)
    assert dut.rsp_valid_o.value == 1 and dut.m_axi_rready.value == 0
    got = await reads.sink.receive(2)
    await reads.sink.expect_none(reads.max_reads + 5)

    assert sorted(map(reads.unpacked, got)) == sorted(reads.good(requests))
    assert reads.events == {"lines": 2, "strays": reads.max_reads}


@cocotb.test()
async def drops_second_answers_in_traffic(dut):
    """They come before their id is used again, as they must."""
    reads = await begin(dut)
    rng, memory = reads.rng, reads.memory
    memory.latency = lambda: rng.randint(1, 30)
    memory.repeat = lambda: rng.random() < 0.5
    requests = reads.requests(500)
    cocotb.start_soon(reads.source.send(reads.packed(requests)))
    got = await reads.sink.receive(500)
    await reads.sink.expect_none(20)

    assert sorted(map(reads.unpacked, got)) == sorted(reads.good(requests))
    assert reads.events["lines"] == 500 and reads.events["errors"] == 0
    assert reads.events["strays"] == memory.strays > 150


@cocotb.test()
async def forgets_everything_on_reset(dut):
    reads = await begin(dut)
    memory = reads.memory
    memory.latency = lambda: 20
    requests = reads.requests(reads.max_reads + 2)  # two answers wait inside
    await reads.source.send(reads.packed(requests))
    await ClockCycles(dut.clk_i, 40)
    assert dut.rsp_valid_o.value == 1
    dut.rst_ni.value = 0
    await ClockCycles(dut.clk_i, 2)
    dut.rst_ni.value = 1
    left = memory.in_flight()  # the memory was not reset: its answers come still
    await reads.sink.expect_none(left + 40)
    assert reads.events["strays"] == left > 0

    cocotb.start_soon(reads.source.send(reads.packed(requests)))
    got = await reads.sink.receive(len(requests))
    assert sorted(map(reads.unpacked, got)) == sorted(reads.good(requests))


SHAPES = [(64, 16), (32, 2), (128, 64)]  # LineBytes, MaxReads


@pytest.mark.parametrize(("line_bytes", "max_reads"), SHAPES)
def test_ti_axi_read(line_bytes, max_reads):
    config = f"tiny line_bytes={line_bytes} addr_bits={40 if line_bytes == 128 else 32}"
    run("ti_axi_read_top", "test_ti_axi_read", config=config, MaxReads=max_reads)
