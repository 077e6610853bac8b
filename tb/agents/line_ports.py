# SPDX-License-Identifier: Apache-2.0
"""The units in front of the line ports of a `ti_lines` or a `ti_memory`."""

from agents.bench import cycle
from agents.memory import line_data
from cocotb.triggers import ReadOnly, RisingEdge
from models.payload import configuration, payloads


class LinePorts:
    """Unit u asks `left[u]` times for random lines, under each id at most once at a time.

    `gap()` says whether a unit stays idle instead of offering its next request, `ready(u)` is the
    ready bit of its answers in each cycle, `bad(line)` whether the answer must be an error.
    """

    def __init__(self, dut, rng):
        self._dut, self._rng = dut, rng
        self._ids = 1 << payloads().width("row_id_t")
        self._line_bytes = configuration()["line_bytes"]
        self.num = len(dut.line_req_valid_i)
        self.lines = 1 << payloads().width("line_addr_t")
        self._free = [set(range(self._ids)) for _ in range(self.num)]
        self._offer = [None] * self.num  # (id, line)
        self._asking = {}  # (unit, id) -> line, from taken to answered
        self._shown = [None] * self.num  # the answer that was not taken
        self._waited = [0] * self.num
        self.left = [0] * self.num
        self.gap = lambda: False
        self.ready = lambda unit: True
        self.bad = lambda line: False
        self.unit_of = {}  # line -> unit; no line is asked for twice
        self.taken = []  # (unit, line) in the order taken
        self.passed = []  # of each request: how many others were taken while it waited
        self.taken_at, self.answered_at = [], []  # cycles
        self.answered = [0] * self.num
        self.errors = 0

    def busy(self):
        return any(self.left) or any(self._offer) or bool(self._asking)

    async def play(self, patience=5000):
        """Until every request has been answered, and some cycles longer.

        Fails when no answer comes for `patience` cycles.
        """
        idle, last = 0, cycle()
        while idle < 20:
            idle = 0 if self.busy() else idle + 1
            last = max([last, *self.answered_at[-1:]])
            assert cycle() - last < patience, f"no answer; {len(self._asking)} in flight"
            ready = [bool(self.ready(unit)) for unit in range(self.num)]
            self._drive(ready)
            await ReadOnly()
            for unit in range(self.num):
                self._see_answer(unit, ready[unit])
            self._see_requests()
            await RisingEdge(self._dut.clk_i)

    def _drive(self, ready):
        valid = 0
        for unit in range(self.num):
            if self._offer[unit] is None and self.left[unit] and self._free[unit]:
                if self.gap():
                    continue
                self.left[unit] -= 1
                self._offer[unit] = self._request(unit)
            if self._offer[unit] is not None:
                identity, line = self._offer[unit]
                valid |= 1 << unit
                self._dut.line_req_data_i[unit].value = payloads().pack(
                    "line_req_t", id=identity, line=line
                )
        self._dut.line_req_valid_i.value = valid
        self._dut.line_rsp_ready_i.value = sum(bit << unit for unit, bit in enumerate(ready))

    def _request(self, unit):
        line = self._rng.choice([0, self.lines - 1, self._rng.randrange(self.lines)])
        while line in self.unit_of:
            line = self._rng.randrange(self.lines)
        self.unit_of[line] = unit
        return self._rng.choice(sorted(self._free[unit])), line

    def _see_requests(self):
        ready = int(self._dut.line_req_ready_o.value)
        taken = [u for u in range(self.num) if self._offer[u] is not None and ready >> u & 1]
        for unit in range(self.num):
            if unit in taken:
                identity, line = self._offer[unit]
                self._offer[unit] = None
                self._free[unit].remove(identity)
                self._asking[unit, identity] = line
                self.taken.append((unit, line))
                self.taken_at.append(cycle())
                self.passed.append(self._waited[unit])
                self._waited[unit] = 0
            elif self._offer[unit] is not None:
                self._waited[unit] += len(taken)

    def _see_answer(self, unit, ready):
        if int(self._dut.line_rsp_valid_o.value) >> unit & 1 == 0:
            assert self._shown[unit] is None, f"unit {unit}: an answer went away"
            return
        bits = int(self._dut.line_rsp_data_o[unit].value)
        assert self._shown[unit] in (None, bits), f"unit {unit}: an answer changed"
        self._shown[unit] = None if ready else bits
        if not ready:
            return
        answer = payloads().unpack("line_rsp_t", bits)
        identity = answer["id"]
        assert (unit, identity) in self._asking, f"unit {unit} has asked nothing under {identity}"
        line = self._asking.pop((unit, identity))
        assert answer["error"] == self.bad(line), f"line {line:#x}"
        if not answer["error"]:
            assert answer["data"] == line_data(line, self._line_bytes), f"line {line:#x}"
        self.errors += answer["error"]
        self._free[unit].add(identity)
        self.answered[unit] += 1
        self.answered_at.append(cycle())
