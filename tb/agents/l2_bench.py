# SPDX-License-Identifier: Apache-2.0
"""A `ti_l2` with units in front of it, a memory behind each bank, and the sums of what it did."""

import cocotb
from agents.bench import start
from agents.events import Events
from agents.lanes import Lanes
from agents.line_ports import LinePorts
from agents.memory import LineMemory
from models.payload import configuration, parameter

NAMES = ("NumUnits", "UnitIds", "NumBanks", "CacheBytes", "Ways", "Rows", "Latency")
UNITS, IDS, BANKS, CACHE_BYTES, _, ROWS, LATENCY = (parameter(name, 1) for name in NAMES)
BANK_PORTS = {
    "ask": ("bank_req_{}_o", "bank_req_{}_i", "line_req_t"),
    "answer": ("bank_rsp_{}_i", "bank_rsp_{}_o", "line_rsp_t"),
}


class Bench:
    """An L2 after reset with units before it and a memory behind each bank."""

    def __init__(self, dut, rng):
        self._dut = dut
        self.line_bytes = configuration()["line_bytes"]
        self.places = CACHE_BYTES // self.line_bytes
        lanes = Lanes(dut)
        self.banks = [LineMemory(lanes[b], self.line_bytes, rng, BANK_PORTS) for b in range(BANKS)]
        self.events = [Events(dut, "l2", dut.events_o[b]) for b in range(BANKS)]
        self._watched = [events.counts() for events in self.events]
        self.units = LinePorts(dut, rng, ids=IDS)
        self.units.see = self._see
        self.units.line = lambda unit: rng.randrange(self.places)
        self.latency = lambda line: 3
        self.error = lambda line: False
        for b, memory in enumerate(self.banks):
            memory.latency = lambda line, b=b: self._asked(b, line)
            memory.error = lambda line: self.error(line)
            cocotb.start_soon(memory.run())

    def _asked(self, bank, line):
        assert line % BANKS == bank, f"bank {bank} asked for line {line:#x}"
        on_their_way = self.banks[bank].on_their_way()
        assert line not in on_their_way, f"line {line:#x} was on its way"
        assert len(on_their_way) < ROWS, "more lines on their way than rows"
        return self.latency(line)

    def _see(self):
        inside = self.units.in_flight()
        assert (self._dut.idle_o.value == 1) == (inside == 0), f"idle_o with {inside} in flight"

    def hold(self):
        """From now on lines stay on their way until they are released."""
        self.latency = lambda line: None

    def release(self, line):
        self.banks[line % BANKS].release(line)

    def held(self):
        return [line for memory in self.banks for line in memory.held()]

    def asked(self):
        return [line for memory in self.banks for line in memory.asked]

    def start(self, count, units=None, line=None):
        """Have each unit, or those named, ask `count` times; the task that plays them."""
        self.units.line = line or self.units.line
        chosen = range(UNITS) if units is None else units
        self.units.left = [count if u in chosen else 0 for u in range(UNITS)]
        return cocotb.start_soon(self.units.play())

    async def ask(self, count, units=None, line=None):
        """The same; the requests, when all have been answered."""
        before = len(self.units.requests)
        await self.start(count, units, line)
        return self.units.requests[before:]

    async def bring(self, lines):
        """Have `lines` in the cache."""
        todo = iter(lines)
        await self.ask(len(lines), [0], lambda unit: next(todo))

    def counts(self):
        """Events of each bank since the start."""
        return [
            events.since(before) for events, before in zip(self.events, self._watched, strict=True)
        ]

    def finish(self):
        """Check the sums when everything is over."""
        assert sum(self.units.answered) == len(self.units.requests) and not self.units.in_flight()
        for bank, (events, memory) in enumerate(zip(self.counts(), self.banks, strict=True)):
            taken = sum(request.line % BANKS == bank for request in self.units.requests)
            kinds = [events[kind] for kind in ("hits", "merged", "misses")]
            assert events["accesses"] == sum(kinds) == taken, f"bank {bank}"
            assert events["misses"] == len(memory.asked), f"bank {bank}"


async def begin(dut):
    rng = await start(dut)
    return rng, Bench(dut, rng)
