# SPDX-License-Identifier: Apache-2.0
"""`ti_axi_read` makes one AXI4 burst of one beat of each request and brings every answer back."""

from collections import Counter

import cocotb
import pytest
from agents.axi_memory import DECERR, EXOKAY, OKAY, SLVERR, AxiMemory
from agents.bench import cycle, only_if, run, start
from agents.memory import line_data
from agents.stream import Sink, Source, stalls
from cocotb.triggers import ClockCycles, ReadOnly, RisingEdge
from models.payload import configuration, parameter, payloads

ID_WIDTH = 16
ROUND_TRIP = 3  # cycles from a request to the cycle after its answer, with a memory of latency 1
FOR_EVER = 1_000_000
TIMEOUT = parameter("Timeout", 0)


class Reads:
    """A unit after reset, a memory behind it, and the requests that are sent to it."""

    def __init__(self, dut, rng, **memory):
        self.dut, self.rng = dut, rng
        self.line_bytes = configuration()["line_bytes"]
        self.max_reads = int(dut.MaxReads.value)
        self.lines = (1 << configuration()["addr_bits"]) // self.line_bytes
        self.memory = AxiMemory(dut, rng, **{"stalls": True, **memory})
        self.memory.line = lambda address: self.data(address // self.line_bytes)
        self.source, self.sink = Source(dut, "req"), Sink(dut, "rsp")
        self.events, self.activities = Counter(), Counter()
        self._outstanding = 0
        cocotb.start_soon(self._watch())

    def data(self, line):
        return line_data(line, self.line_bytes)

    def requests(self, count):
        """(id, line) of different ids; the lowest and the highest line are among the lines."""
        lines = [0, self.lines - 1] + [self.rng.randrange(self.lines) for _ in range(count - 2)]
        return list(zip(self.rng.sample(range(1 << ID_WIDTH), count), lines, strict=True))

    def packed(self, requests):
        width = (self.lines - 1).bit_length()
        return [identity << width | line for identity, line in requests]

    def unpacked(self, beat):
        """(id, error, data), data None of an error."""
        bits = 8 * self.line_bytes
        error = beat >> bits & 1
        return beat >> bits + 1, error, None if error else beat & ((1 << bits) - 1)

    def good(self, requests):
        return [(identity, 0, self.data(line)) for identity, line in requests]

    async def _watch(self):
        """Count the events; of the activities there is one a cycle, the right one."""
        dut = self.dut
        while True:
            await ReadOnly()
            if dut.rst_ni.value == 1:
                events = payloads().unpack("axi_events_t", int(dut.events_o.value))
                activity = {k for k, v in events.pop("activity").items() if v}
                valid, ready = dut.req_valid_i.value == 1, dut.req_ready_o.value == 1
                self.events.update({k for k, v in events.items() if v})
                waits = "memory" if self._outstanding else "empty"
                if not TIMEOUT:  # what is given up is not seen here
                    assert activity == {("works" if ready else "room") if valid else waits}
                self.activities.update(activity)
                assert self._outstanding <= self.max_reads, "more reads in flight than allowed"
                self._outstanding += valid and ready and not TIMEOUT
                known = dut.m_axi_rvalid.value == 1 and dut.m_axi_rready.value == 1
                self._outstanding -= known and not events["strays"]
            else:
                self._outstanding = 0
            await RisingEdge(dut.clk_i)


async def begin(dut, **memory):
    for name in ("arready", "rvalid", "rid", "rdata", "rresp", "rlast"):
        getattr(dut, f"m_axi_{name}").value = 0
    return Reads(dut, await start(dut), **memory)


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


@only_if(TIMEOUT)
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


@only_if(TIMEOUT)
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


@only_if(TIMEOUT)
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


@only_if(TIMEOUT)
@cocotb.parametrize(p_lost=[0.0, 0.05])
async def only_reads_that_are_lost_are_errors(dut, p_lost):
    """Some answers come too late, one in some as late as may be, or while it is given up."""
    reads = await begin(dut)
    rng, memory = reads.rng, reads.memory
    late = {}

    def latency():
        if rng.random() >= p_lost:
            return rng.randint(1, TIMEOUT // 2)
        late[len(memory.addresses)] = True
        return rng.randint(2 * TIMEOUT + 2 * reads.max_reads, 3 * TIMEOUT)

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


SHAPES = [(64, 16), (32, 2), (128, 64)]  # LineBytes, MaxReads


@pytest.mark.parametrize(("line_bytes", "max_reads"), SHAPES)
def test_ti_axi_read(line_bytes, max_reads):
    config = f"tiny line_bytes={line_bytes} addr_bits={40 if line_bytes == 128 else 32}"
    run("ti_axi_read_top", "test_ti_axi_read", config=config, MaxReads=max_reads)


@pytest.mark.parametrize("max_reads", [2, 8])
def test_ti_read_timeout(max_reads):
    run("ti_axi_read_top", "test_ti_axi_read", MaxReads=max_reads, Timeout=150)
