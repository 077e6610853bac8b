# SPDX-License-Identifier: Apache-2.0
"""Sum the events of a unit, and see that it tells one activity in every cycle."""

from collections import Counter

import cocotb
import counters
from cocotb.triggers import ReadOnly, RisingEdge


class Events:
    """Watches `port` (by default `events_o`) of a unit of counters.yaml from now on.

    Fails in a cycle with no activity or with two.
    """

    def __init__(self, dut, unit, port=None):
        table = counters.description()
        self._names = list(counters.events(table, unit))
        self._activities = (1 << len(table["activity"])) - 1
        self._unit, self._port = unit, dut.events_o if port is None else port
        self._seen = Counter()  # patterns of events
        cocotb.start_soon(self._run(dut.clk_i))

    async def _run(self, clk):
        while True:
            await ReadOnly()
            events = int(self._port.value)
            activity = events & self._activities
            assert activity.bit_count() == 1, f"{self._unit}: activities {activity:#b} in one cycle"
            self._seen[events] += 1
            await RisingEdge(clk)

    def counts(self):
        """Cycles of each event so far, by the names of counters.yaml."""
        return {
            name: sum(n for events, n in self._seen.items() if events >> i & 1)
            for i, name in enumerate(self._names)
        }

    def since(self, before):
        """Cycles of each event since `before`, an earlier `counts()`; events that came not at all
        are left out."""
        return Counter({k: n - before[k] for k, n in self.counts().items() if n > before[k]})

    def activities(self, before):
        """The activities since `before`, with their cycles."""
        names = self._names[: self._activities.bit_length()]
        return {k: n for k, n in self.since(before).items() if k in names}
