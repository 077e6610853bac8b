# SPDX-License-Identifier: Apache-2.0
"""The units in front of the line ports of a `ti_lines`, a `ti_l2` or a `ti_memory`."""

from dataclasses import dataclass

from agents.bench import cycle
from agents.handles import Handles, Inputs
from agents.memory import line_data
from cocotb.triggers import ReadOnly, RisingEdge
from models.payload import configuration, payloads


@dataclass(eq=False)
class Asked:
    """A request, with the cycles of its life."""

    unit: int
    line: int
    taken: int
    shown: int = None  # the answer stands at the port
    answered: int = None  # and has been taken
    error: bool = None


class LinePorts:
    """Unit u asks `left[u]` times, under each of its ids at most once at a time.

    It asks for `line(u)`, by default a random line that nobody has asked for yet.  `gap()` says
    whether a unit stays idle instead of offering its next request, `ready(u)` is the ready bit of
    its answers in each cycle, `bad(line)` whether the answer must be an error; None: it may be.
    `see()` looks at each settled cycle, before what happens in it counts.
    """

    def __init__(self, dut, rng, ids=None):
        self._dut, self._inputs, self._rng = Handles(dut), Inputs(dut), rng
        self._data = [dut.line_req_data_i[unit] for unit in range(len(dut.line_req_valid_i))]
        self._line_bytes = configuration()["line_bytes"]
        self.num = len(dut.line_req_valid_i)
        self.lines = 1 << payloads().width("line_addr_t")
        every_id = range(ids or 1 << payloads().width("row_id_t"))
        self._free = [set(every_id) for _ in range(self.num)]
        self._offer = [None] * self.num  # (id, line)
        self._asking = {}  # (unit, id) -> Asked, from taken to answered
        self._shown = [None] * self.num  # the answer that was not taken
        self._waited = [0] * self.num
        self.left = [0] * self.num
        self.gap = lambda: False
        self.ready = lambda unit: True
        self.bad = lambda line: False
        self.line = self._new_line
        self.see = lambda: None
        self.requests = []  # Asked, in the order taken
        self.unit_of = {}  # line -> unit that asked for it last
        self.taken = []  # (unit, line) in the order taken
        self.passed = []  # of each request: how many others were taken while it waited
        self.taken_at, self.answered_at = [], []  # cycles
        self.answered = [0] * self.num
        self.errors = 0

    def set_ids(self, unit, ids):
        """The unit asks under the ids from 0 to `ids` - 1."""
        self._free[unit] = set(range(ids))

    def in_flight(self):
        """How many requests have been taken and not answered."""
        return len(self._asking)

    def asking(self):
        """The unit of each of these requests."""
        return [unit for unit, _ in self._asking]

    def may_ask(self, unit):
        """Whether the unit has an id and no request that waits."""
        return bool(self._free[unit]) and self._offer[unit] is None

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
            self.see()
            valid = int(self._dut.line_rsp_valid_o.value)
            for unit in range(self.num):
                self._see_answer(unit, valid >> unit & 1, ready[unit])
            self._see_requests()
            await RisingEdge(self._dut.clk_i)

    def _drive(self, ready):
        valid = 0
        for unit in range(self.num):
            if self._offer[unit] is None and self.left[unit] and self._free[unit]:
                if self.gap():
                    continue
                self.left[unit] -= 1
                identity, line = self._offer[unit] = self._request(unit)
                self._data[unit].value = payloads().pack("line_req_t", id=identity, line=line)
            valid |= (self._offer[unit] is not None) << unit
        self._inputs.drive("line_req_valid_i", valid)
        levels = sum(bit << unit for unit, bit in enumerate(ready))
        self._inputs.drive("line_rsp_ready_i", levels)

    def _request(self, unit):
        line = self.line(unit)
        self.unit_of[line] = unit
        return self._rng.choice(sorted(self._free[unit])), line

    def _new_line(self, unit):
        line = self._rng.choice([0, self.lines - 1, self._rng.randrange(self.lines)])
        while line in self.unit_of:
            line = self._rng.randrange(self.lines)
        return line

    def _see_requests(self):
        ready = int(self._dut.line_req_ready_o.value)
        taken = [u for u in range(self.num) if self._offer[u] is not None and ready >> u & 1]
        for unit in range(self.num):
            if unit in taken:
                identity, line = self._offer[unit]
                self._offer[unit] = None
                self._free[unit].remove(identity)
                self._asking[unit, identity] = Asked(unit, line, cycle())
                self.requests.append(self._asking[unit, identity])
                self.taken.append((unit, line))
                self.taken_at.append(cycle())
                self.passed.append(self._waited[unit])
                self._waited[unit] = 0
            elif self._offer[unit] is not None:
                self._waited[unit] += len(taken)

    def _see_answer(self, unit, valid, ready):
        if not valid:
            assert self._shown[unit] is None, f"unit {unit}: an answer went away"
            return
        bits = int(self._dut.line_rsp_data_o[unit].value)
        assert self._shown[unit] in (None, bits), f"unit {unit}: an answer changed"
        self._shown[unit] = None if ready else bits
        answer = payloads().unpack("line_rsp_t", bits)
        identity = answer["id"]
        assert (unit, identity) in self._asking, f"unit {unit} has asked nothing under {identity}"
        asked = self._asking[unit, identity]
        asked.shown = asked.shown or cycle()
        if not ready:
            return
        del self._asking[unit, identity]
        asked.answered, asked.error, line = cycle(), answer["error"] == 1, asked.line
        assert self.bad(line) in (None, asked.error), f"line {line:#x}"
        if not answer["error"]:
            assert answer["data"] == line_data(line, self._line_bytes), f"line {line:#x}"
        self.errors += answer["error"]
        self._free[unit].add(identity)
        self.answered[unit] += 1
        self.answered_at.append(cycle())
