# SPDX-License-Identifier: Apache-2.0
"""A `ti_axi_read` with a memory behind it: requests, answers, and a watch on its events."""

from collections import Counter

import cocotb
from agents.axi_memory import AxiMemory
from agents.bench import start
from agents.memory import line_data
from agents.stream import Sink, Source
from cocotb.triggers import ReadOnly, RisingEdge
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
