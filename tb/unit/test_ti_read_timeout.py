# SPDX-License-Identifier: Apache-2.0
"""`ti_read_timeout`, in `ti_axi_read`: reads without an answer, and no others, end in time."""

import cocotb
import pytest
from agents.axi_reads import FOR_EVER, ROUND_TRIP, TIMEOUT, begin
from agents.bench import cycle, run
from cocotb.triggers import ClockCycles


@cocotb.test()
async def a_read_without_an_answer_is_an_error_in_time(dut):
    reads = await begin(dut)
    reads.memory.latency = lambda: FOR_EVER
    dut.rsp_ready_i.value = 1
    for request in reads.requests(reads.max_reads)[1:]:
        await reads.source.send(reads.packed([request]))
        since = cycle()
        (beat,) = await reads.sink.receive(1, patience=3 * TIMEOUT)
        assert reads.unpacked(beat) == (request[0], 1, None)
        assert TIMEOUT < cycle() - since <= 2 * TIMEOUT + reads.max_reads + ROUND_TRIP
    await reads.sink.expect_none(3 * TIMEOUT)
    assert reads.events == {"lines": reads.max_reads - 1, "errors": reads.max_reads - 1}


@cocotb.test()
async def an_answer_that_comes_after_all_is_dropped_and_its_id_used_again(dut):
    reads = await begin(dut)
    memory = reads.memory
    memory.latency = lambda: FOR_EVER
    lost = reads.requests(reads.max_reads)[: reads.max_reads // 2]
    cocotb.start_soon(reads.source.send(reads.packed(lost)))
    got = await reads.sink.receive(len(lost), patience=3 * TIMEOUT)
    assert sorted(map(reads.unpacked, got)) == sorted((i, 1, None) for i, _ in lost)

    memory.latency = lambda: 5
    cocotb.start_soon(reads.source.send(reads.packed(requests := reads.requests(100))))
    got = await reads.sink.receive(100)
    assert sorted(map(reads.unpacked, got)) == sorted(reads.good(requests))

    memory._waiting = [(0, identity, address) for _, identity, address in memory._waiting]
    await reads.sink.expect_none(len(lost) + 20)
    assert reads.events["strays"] == len(lost)
    memory.latency = lambda: TIMEOUT // 2
    cocotb.start_soon(reads.source.send(reads.packed(requests := reads.requests(100))))
    got = await reads.sink.receive(100)
    assert sorted(map(reads.unpacked, got)) == sorted(reads.good(requests))
    assert {*range(reads.max_reads)} == memory.identities, "an id was not used again"


@cocotb.test()
@cocotb.parametrize(taken=[0, 1])
async def a_memory_that_answers_nothing_any_more_answers_errors(dut, taken):
    """Whether it takes addresses or not."""
    reads = await begin(dut)
    rng, memory = reads.rng, reads.memory
    memory.latency, memory.ready = lambda: FOR_EVER, lambda: taken
    requests = reads.requests(5 * reads.max_reads)
    cocotb.start_soon(reads.source.send(reads.packed(requests)))
    got = await reads.sink.receive(len(requests), lambda: rng.random() < 0.5, 9 * TIMEOUT)
    await reads.sink.expect_none(3 * TIMEOUT)
    assert sorted(map(reads.unpacked, got)) == sorted((i, 1, None) for i, _ in requests)
    assert reads.events["errors"] == len(requests)
    assert reads.events["lines"] == (reads.max_reads if taken else 2)

    dut.rst_ni.value = 0  # and the memory with it
    memory.forget()
    await ClockCycles(dut.clk_i, 2)
    dut.rst_ni.value = 1
    memory.latency, memory.ready = lambda: 5, lambda: 1
    requests = reads.requests(50)
    cocotb.start_soon(reads.source.send(reads.packed(requests)))
    assert sorted(map(reads.unpacked, await reads.sink.receive(50))) == sorted(reads.good(requests))


@cocotb.test()
@cocotb.parametrize(p_lost=[0.0, 0.05])
async def only_reads_that_are_lost_are_errors(dut, p_lost):
    """Some answers come too late, but never of all ids at once: that port would count as dead."""
    reads = await begin(dut)
    rng, memory = reads.rng, reads.memory
    late = {}  # when it comes, by number of the request

    def latency():
        on_their_way = sum(cycle() <= end for end in late.values())
        if rng.random() >= p_lost or on_their_way == reads.max_reads - 1:
            return rng.randint(1, TIMEOUT // 2)
        cycles = rng.randint(2 * TIMEOUT + 2 * reads.max_reads, 3 * TIMEOUT)
        late[len(memory.addresses)] = cycle() + cycles
        return cycles

    memory.latency = latency
    requests = reads.requests(600)
    cocotb.start_soon(reads.source.send(reads.packed(requests)))
    got = await reads.sink.receive(600)
    await reads.sink.expect_none(4 * TIMEOUT)
    want = [
        (identity, 1, None) if n in late else (identity, 0, reads.data(line))
        for n, (identity, line) in enumerate(requests)
    ]
    assert sorted(map(reads.unpacked, got)) == sorted(want)
    assert reads.events["errors"] == reads.events["strays"] == len(late)
    assert (len(late) > 10) == (p_lost > 0)


@pytest.mark.parametrize("max_reads", [2, 8])
def test_ti_read_timeout(max_reads):
    """What is promised without it holds with it too."""
    modules = ["test_ti_axi_read", "test_ti_read_timeout"]
    run("ti_axi_read_top", modules, MaxReads=max_reads, Timeout=150)
