# SPDX-License-Identifier: Apache-2.0
"""An AXI4 slave that holds images and answers reads of whole lines."""

import cocotb
from agents.handles import Handles
from cocotb.triggers import ReadOnly, RisingEdge

OKAY, EXOKAY, SLVERR, DECERR = range(4)
INCR = 1
VECTORS = ("arvalid", "arready", "arlock", "rvalid", "rready", "rlast")  # one bit a core
INPUTS = {}  # what all ports together drive onto those
AR = ("id", "addr", "len", "size", "burst", "lock", "cache", "prot", "qos")
SIGNALS = ("arvalid", "arready", *(f"ar{name}" for name in AR))
SIGNALS += ("rvalid", "rready", "rid", "rdata", "rresp", "rlast")
BUFFERABLE = 0b0011  # normal, non-cacheable


class AxiMemory:
    """Answers `m_axi_ar*` on `m_axi_r*`, in random order among the answers that are due.

    `port` picks one of the read ports of an engine, whose signals are arrays over the cores.

    `latency()` is the number of cycles from a request to its answer, `ready()` the ready bit of
    each cycle, `resp()` and `last()` the response and RLAST of each answer; bytes of a bad answer
    are random.  Lines that touch no image are answered with DECERR.  `repeat()` says of each answer
    whether another of random bytes follows it in the next cycle, under its identity; `stray()`
    gives one under any.  Checks that a request is one aligned beat of a line, stays with all that
    belongs to it until it is taken, and carries an identity that is not in flight; and, unless
    `stalls`, that answers are always taken.
    """

    def __init__(
        self,
        dut,
        rng,
        port=None,
        *,
        latency=lambda: 10,
        ready=lambda: 1,
        resp=lambda: OKAY,
        stalls=False,
    ):
        self._dut, self._rng, self._stalls, self._index = Handles(dut), rng, stalls, port
        self.latency, self.ready, self.resp, self.last = latency, ready, resp, lambda: 1
        self.repeat = lambda: False
        self._ports = {name: self._port(name) for name in SIGNALS}
        self._line_bytes = len(self._ports["rdata"]) // 8
        self._images = []  # (base, bytes)
        self._waiting = []  # (cycle when due, identity, address)
        self._strays = []  # identities
        self._again = None  # the identity of the answer to repeat
        self._shown = None  # the identity of the answer at the port; `_real`: somebody asked
        self._real = False
        self._stalled = None  # the request that was not taken
        self.addresses = []  # of all requests, in order
        self.identities = set()  # of all requests
        self.answers = []  # (address, response, RLAST) of all answers, in order
        self.strays = 0  # beats that were taken and answered nothing
        for name in ("arready", "rvalid", "rid", "rdata", "rresp", "rlast"):
            self._drive(name, 0)
        cocotb.start_soon(self._run())

    def put(self, base, data):
        """Hold an image at an address."""
        self._images.append((base, data))

    def clear(self):
        """Hold no image any more."""
        self._images.clear()

    def withdraw(self):
        """The master was reset: a request that was not taken is gone; those taken are answered."""
        self._stalled = None

    def forget(self):
        """Drop what is in flight, as a slave does on reset."""
        self._waiting.clear()
        self._stalled = self._shown = self._again = None

    def in_flight(self):
        return len(self._waiting) + (self._shown is not None and self._real)

    def stray(self, identity):
        """In the next cycle without an answer, give one of random bytes under `identity`."""
        self._strays.append(identity)

    def line(self, address):
        """A line as an integer, or None outside of all images."""
        for base, data in self._images:
            start = address - base
            if -self._line_bytes < start < len(data):
                piece = data[max(start, 0) : start + self._line_bytes]
                piece = piece.rjust(self._line_bytes, b"\0") if start < 0 else piece
                return int.from_bytes(piece, "little")
        return None

    def _port(self, name):
        """A signal of this port, or the vector in which it has a bit."""
        handle = getattr(self._dut, f"m_axi_{name}")
        return handle if self._index is None or name in VECTORS else handle[self._index]

    def _value(self, name):
        value = int(self._ports[name].value)
        return value >> (self._index or 0) & 1 if name in VECTORS else value

    def _drive(self, name, value):
        if name in VECTORS:
            at = self._index or 0
            before = INPUTS.get(name)
            INPUTS[name] = (before or 0) & ~(1 << at) | int(value) << at
            if INPUTS[name] == before:
                return
            value = INPUTS[name]
        self._ports[name].value = value

    async def _run(self):
        cycle = 0
        while True:
            self._answer(cycle)
            self._drive("arready", int(self.ready()))
            await ReadOnly()
            if self._dut.rst_ni.value:
                self._ask(cycle)
                taken = bool(self._value("rready"))
                assert taken or self._stalls, "answers are always taken"
                if taken and self._shown is not None:
                    self.strays += not self._real
                    self._shown = None
            await RisingEdge(self._dut.clk_i)
            cycle += 1

    def _ask(self, cycle):
        if self._value("arvalid") == 0:
            assert self._stalled is None, "a request went away before it was taken"
            return
        request = {name: self._value(f"ar{name}") for name in AR}
        assert self._stalled in (None, request), "a request changed while it waited"
        self._stalled = None if self._value("arready") == 1 else request
        if self._stalled:
            return
        identity, address = request["id"], request["addr"]
        assert address % self._line_bytes == 0
        assert request["len"] == 0 and request["burst"] == INCR
        assert 1 << request["size"] == self._line_bytes
        assert request["cache"] == BUFFERABLE
        assert request["lock"] == request["prot"] == request["qos"] == 0
        taken = {other for _, other, _ in self._waiting}
        if self._shown is not None and self._real:
            taken.add(self._shown)
        assert identity not in taken, f"{identity} is in flight"
        self._waiting.append((cycle + max(self.latency(), 1), identity, address))
        self.addresses.append(address)
        self.identities.add(identity)

    def _answer(self, cycle):
        if self._shown is not None:
            return
        due = [entry for entry in self._waiting if entry[0] <= cycle]
        self._drive("rvalid", self._again is not None or bool(due or self._strays))
        if self._again is not None:
            self._show(self._again, None, self._rng.randrange(4), self._rng.getrandbits(1))
            self._again = None
        elif due:
            entry = self._rng.choice(due)
            self._waiting.remove(entry)
            _, identity, address = entry
            line = self.line(address)
            resp, last = DECERR if line is None else self.resp(), int(self.last())
            self._show(identity, None if resp in (SLVERR, DECERR) else line, resp, last)
            self._real = True
            self.answers.append((address, resp, last))
            self._again = identity if self.repeat() else None
        elif self._strays:
            self._show(self._strays.pop(0), None, self._rng.randrange(4), self._rng.getrandbits(1))

    def _show(self, identity, data, resp, last):
        self._shown, self._real = identity, False
        data = self._rng.getrandbits(8 * self._line_bytes) if data is None else data
        for name, value in [("rid", identity), ("rdata", data), ("rresp", resp), ("rlast", last)]:
            self._drive(name, value)
