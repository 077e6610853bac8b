# SPDX-License-Identifier: Apache-2.0
"""A memory of lines behind a port that asks for a line under an identity."""

import random

from agents.bench import cycle
from cocotb.triggers import ReadOnly, RisingEdge

RA_PORTS = {  # the roles of a port here, and their names at a `ti_ra`
    "ask_valid": "line_req_valid_o",
    "ask_ready": "line_req_ready_i",
    "ask_id": "line_req_row_o",
    "ask_line": "line_req_line_o",
    "answer_valid": "line_rsp_valid_i",
    "answer_id": "line_rsp_row_i",
    "answer_data": "line_rsp_data_i",
    "answer_error": "line_rsp_error_i",
}


def line_data(line, line_bytes):
    """The bytes of a line as an integer, byte 0 lowest; no two lines are alike."""
    return random.Random(line).getrandbits(8 * line_bytes)


class LineMemory:
    """Answers at most one request a cycle, at random among those that are due.

    `latency(line)` is the number of cycles from a request to its answer, 1 or more, or None: the
    answer waits for `release(line)`.  `error(line)` says whether an answer is an error,
    `data(line)` gives the bytes of a good one as an integer.  `ready()` is the ready bit of each
    cycle.  `asked` has every line in the order of the requests, `answered` (cycle, line, error) of
    every answer.  A role that `ports` leaves out is not driven.
    """

    def __init__(self, dut, line_bytes, rng, ports=RA_PORTS):
        self._clk = dut.clk_i
        self._line_bytes = line_bytes
        self._rng = rng
        self._port = {role: getattr(dut, name) for role, name in ports.items()}
        self.data = lambda line: line_data(line, line_bytes)
        self._waiting = []  # [cycle when due or None, identity, line]
        self.latency = lambda line: 3
        self.error = lambda line: False
        self.ready = lambda: True
        self.asked = []
        self.answered = []

    def release(self, line, after=1):
        """Answer the held request for `line` `after` cycles from now."""
        held = [entry for entry in self._waiting if entry[0] is None and entry[2] == line]
        assert held, f"line {line:#x} has not been asked for"
        held[0][0] = cycle() + after

    def held(self):
        """Lines that wait for `release`, in the order of their requests."""
        return [line for when, _, line in self._waiting if when is None]

    async def run(self):
        """Play the memory for ever."""
        while True:
            self._answer()
            self._port["ask_ready"].value = int(self.ready())
            await ReadOnly()
            self._ask()
            await RisingEdge(self._clk)

    def _answer(self):
        due = [entry for entry in self._waiting if entry[0] is not None and entry[0] <= cycle()]
        self._port["answer_valid"].value = bool(due)
        if due:
            entry = self._rng.choice(due)
            self._waiting.remove(entry)
            _, identity, line = entry
            error = bool(self.error(line))
            data = self._rng.getrandbits(8 * self._line_bytes)  # of an error: anything
            self._drive("answer_id", identity)
            self._drive("answer_data", data if error else self.data(line))
            self._drive("answer_error", error)
            self.answered.append((cycle(), line, error))

    def _drive(self, role, value):
        if role in self._port:
            self._port[role].value = value

    def _ask(self):
        if self._port["ask_valid"].value == 1 and self._port["ask_ready"].value == 1:
            identity = int(self._port["ask_id"].value)
            line = int(self._port["ask_line"].value)
            assert all(identity != other for _, other, _ in self._waiting), (
                f"line {line:#x} asked for under identity {identity}, which is in flight"
            )
            latency = self.latency(line)
            self._waiting.append([None if latency is None else cycle() + latency, identity, line])
            self.asked.append(line)
