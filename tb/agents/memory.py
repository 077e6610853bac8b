# SPDX-License-Identifier: Apache-2.0
"""A memory of lines behind a port that asks for a line under an identity."""

import random
from functools import cache

from agents.bench import cycle
from agents.handles import Inputs
from cocotb.triggers import ReadOnly, RisingEdge
from models.payload import payloads

RA_PORTS = {  # the streams of a line port and their types, as at a `ti_ra`
    "ask": ("line_req_{}_o", "line_req_{}_i", "line_req_t"),
    "answer": ("line_rsp_{}_i", "line_rsp_{}_o", "line_rsp_t"),
}


@cache
def line_data(line, line_bytes):
    """The bytes of a line as an integer, byte 0 lowest; no two lines are alike."""
    return random.Random(line).getrandbits(8 * line_bytes)


class LineMemory:
    """Answers at most one request a cycle, at random among those that are due.

    `latency(line)` is the number of cycles from a request to its answer, 1 or more, or None: the
    answer waits for `release(line)`.  `error(line)` says whether an answer is an error,
    `data(line)` gives the bytes of a good one as an integer.  `ready()` is the ready bit of each
    cycle.  `asked` has every line in the order of the requests, `answered` (cycle, line, error) of
    every answer, when it is taken; until then it stays at the port.  `stray(identity)` answers
    what nobody may have asked for; `repeat()` says of each answer whether one of random bytes
    follows it in the next cycle, under its identity.  A request that waits must stay as it is.
    """

    def __init__(self, dut, line_bytes, rng, ports=RA_PORTS):
        self._clk, self._rst, self._inputs = dut.clk_i, dut.rst_ni, Inputs(dut)
        self._line_bytes = line_bytes
        self._rng = rng
        valid, ready, self._ask_type = ports["ask"]
        self._ask_valid, self._ask_data = (
            getattr(dut, valid.format(part)) for part in ("valid", "data")
        )
        self._ask_ready = ready.format("ready")
        self._takes = False  # the level of it
        valid, ready, self._answer_type = ports["answer"]
        self._answer_valid, self._answer_data = (valid.format(part) for part in ("valid", "data"))
        self._answer_ready = getattr(dut, ready.format("ready"))
        self.data = lambda line: line_data(line, line_bytes)
        self._waiting = []  # [cycle when due or None, identity, line]
        self._strays = []  # identities
        self._shown = None  # the identity of the answer at the port
        self._answers = None  # (line, error), where it was asked for
        self._stalled = None  # the request that was not taken
        self.latency = lambda line: 3
        self.error = lambda line: False
        self.ready = lambda: True
        self.repeat = lambda: False
        self._again = None  # the identity of the answer to repeat
        self.asked = []
        self.answered = []

    def hold(self):
        """From now on lines stay on their way until they are released."""
        self.latency = lambda line: None

    def release(self, line, after=1):
        """Answer the held request for `line` `after` cycles from now."""
        held = [entry for entry in self._waiting if entry[0] is None and entry[2] == line]
        assert held, f"line {line:#x} has not been asked for"
        held[0][0] = cycle() + after

    def held(self):
        """Lines that wait for `release`, in the order of their requests."""
        return [line for when, _, line in self._waiting if when is None]

    def on_their_way(self):
        """Lines that have been asked for and not answered."""
        return [line for _, _, line in self._waiting]

    def identity_of(self, line):
        """The identity under which `line` is on its way."""
        return next(identity for _, identity, held in self._waiting if held == line)

    def stray(self, identity):
        """In the next cycle without an answer, give one of random bytes under `identity`."""
        self._strays.append(identity)

    def strays_left(self):
        return len(self._strays)

    async def run(self):
        """Play the memory for ever."""
        while True:
            self._answer()
            self._takes = bool(self.ready())
            self._inputs.drive(self._ask_ready, int(self._takes))
            await ReadOnly()
            if self._answer_ready.value:
                if self._shown is not None and self._answers is not None:
                    self.answered.append((cycle(), *self._answers))
                self._shown = self._answers = None
            self._ask()
            await RisingEdge(self._clk)

    def _answer(self):
        if self._shown is not None:
            return
        now = cycle()
        due = [entry for entry in self._waiting if entry[0] is not None and entry[0] <= now]
        valid = self._again is not None or bool(due or self._strays)
        self._inputs.drive(self._answer_valid, int(valid))
        if self._again is not None:
            self._show(self._again, self._rng.random() < 0.5, self._noise())
            self._again = None
        elif due:
            entry = self._rng.choice(due)
            self._waiting.remove(entry)
            _, identity, line = entry
            error = bool(self.error(line))
            self._show(identity, error, self._noise() if error else self.data(line))
            self._answers = line, error
            self._again = identity if self.repeat() else None
        elif self._strays:
            self._show(self._strays.pop(0), self._rng.random() < 0.5, self._noise())

    def _noise(self):
        return self._rng.getrandbits(8 * self._line_bytes)

    def _show(self, identity, error, data):
        """An identity is all of a request but its line: an id, or (number of a client, id)."""
        self._shown = identity
        if isinstance(identity, tuple):
            port, row = identity
            fields = {"client": port, "rsp": {"id": row, "error": int(error), "data": data}}
        else:
            fields = {"id": identity, "error": int(error), "data": data}
        self._inputs.drive(self._answer_data, payloads().pack(self._answer_type, fields))

    def _ask(self):
        if not self._rst.value:
            self._stalled = None
            return
        if not self._ask_valid.value:
            assert self._stalled is None, "a request went away before it was taken"
            return
        bits = int(self._ask_data.value)
        assert self._stalled in (None, bits), "a request changed before it was taken"
        self._stalled = bits
        if not self._takes:
            return
        self._stalled = None
        request = payloads().unpack(self._ask_type, bits)
        port, request = request.get("client"), request.get("req", request)
        identity, line = request["id"], request["line"]
        identity = identity if port is None else (port, identity)
        assert all(identity != other for _, other, _ in self._waiting), (
            f"line {line:#x} asked for under identity {identity}, which is in flight"
        )
        latency = self.latency(line)
        self._waiting.append([None if latency is None else cycle() + latency, identity, line])
        self.asked.append(line)
