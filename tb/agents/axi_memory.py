# SPDX-License-Identifier: Apache-2.0
"""AXI4 slaves that hold images and answer reads of whole lines, one at each port of an engine."""

import cocotb
from cocotb.triggers import ReadOnly, RisingEdge

OKAY, EXOKAY, SLVERR, DECERR = range(4)
INCR = 1
VECTORS = ("arvalid", "arready", "arlock", "rvalid", "rready", "rlast")  # a bit a core
INPUTS = {}  # what all ports together drive onto those


class AxiMemory:
    """Answers `m_axi_ar*` on `m_axi_r*`, in random order among the answers that are due.

    `latency()` is the number of cycles from a request to its answer, `ready()` the ready bit of
    each cycle, `resp()` the response of each answer; bytes of a bad answer are random.  Lines that
    touch no image are answered with DECERR.  Checks that a request is one aligned beat of a line,
    stays until it is taken, and carries an identity that is not in flight; and that answers are
    always taken.
    """

    def __init__(self, dut, rng, port=0, *, latency=lambda: 10, ready=lambda: 1, resp=lambda: OKAY):
        self._dut, self._rng, self._index = dut, rng, port
        self.latency, self.ready, self.resp = latency, ready, resp
        self._line_bytes = len(dut.m_axi_rdata[port]) // 8
        self._images = []  # (base, bytes)
        self._waiting = []  # (cycle when due, identity, address)
        self._stalled = None  # the request that was not taken
        self.addresses = []  # of all requests, in order
        self.strays = 0  # answers still to give to nothing that was asked for
        for name in ("arready", "rvalid", "rid", "rdata", "rresp", "rlast"):
            self._drive(name, 0)
        cocotb.start_soon(self._run())

    def put(self, base, data):
        """Hold an image at an address."""
        self._images.append((base, data))

    def clear(self):
        """Hold nothing any more."""
        self._images.clear()

    def withdraw(self):
        """The master was reset: a request that was not taken is gone, those taken are still answered."""
        self._stalled = None

    def in_flight(self):
        return len(self._waiting)

    def _port(self, name):
        """A port of its own, or the vector in which this port has a bit."""
        handle = getattr(self._dut, f"m_axi_{name}")
        return handle if name in VECTORS else handle[self._index]

    def _value(self, name):
        value = int(self._port(name).value)
        return value >> self._index & 1 if name in VECTORS else value

    def _drive(self, name, value):
        if name in VECTORS:
            INPUTS[name] = INPUTS.get(name, 0) & ~(1 << self._index) | int(value) << self._index
            value = INPUTS[name]
        self._port(name).value = value

    async def _run(self):
        cycle = 0
        while True:
            self._answer(cycle)
            self._drive("arready", self.ready())
            await ReadOnly()
            if self._dut.rst_ni.value == 1:
                assert self._value("rready") == 1, "answers are always taken"
                self._ask(cycle)
            await RisingEdge(self._dut.clk_i)
            cycle += 1

    def _ask(self, cycle):
        if self._value("arvalid") == 0:
            assert self._stalled is None, "a request went away before it was taken"
            return
        identity, address = self._value("arid"), self._value("araddr")
        assert self._stalled in (None, (identity, address)), "a request changed while it waited"
        self._stalled = None if self._value("arready") == 1 else (identity, address)
        if self._stalled:
            return
        assert address % self._line_bytes == 0
        assert self._value("arlen") == 0 and self._port("arburst").value == INCR
        assert 1 << self._value("arsize") == self._line_bytes
        assert (self._value("arlock"), self._value("arcache")) == (0, 0b0011)
        assert (self._value("arprot"), self._value("arqos")) == (0, 0)
        assert all(identity != other for _, other, _ in self._waiting), f"{identity} is in flight"
        self._waiting.append((cycle + max(self.latency(), 1), identity, address))
        self.addresses.append(address)

    def _answer(self, cycle):
        due = [entry for entry in self._waiting if entry[0] <= cycle]
        if self.strays:
            self.strays -= 1
            due = [self._stray()]
            self._waiting += due
        self._drive("rvalid", bool(due))
        if not due:
            return
        entry = self._rng.choice(due)
        self._waiting.remove(entry)
        _, identity, address = entry
        line = self._line(address)
        resp = DECERR if line is None else self.resp()
        bad = resp in (SLVERR, DECERR)
        data = self._rng.getrandbits(8 * self._line_bytes) if bad else line
        for name, value in [("rid", identity), ("rdata", data), ("rresp", resp), ("rlast", 1)]:
            self._drive(name, value)

    def _stray(self):
        """An answer under an identity that is not in flight, as a reset leaves behind."""
        busy = {identity for _, identity, _ in self._waiting}
        free = [i for i in range(1 << len(self._port("rid"))) if i not in busy]
        return (0, self._rng.choice(free), self._images[0][0] if self._images else 0)

    def _line(self, address):
        """A line as an integer, or None outside of all images."""
        for base, data in self._images:
            start = address - base
            if -self._line_bytes < start < len(data):
                piece = data[max(start, 0) : start + self._line_bytes]
                piece = piece.rjust(self._line_bytes, b"\0") if start < 0 else piece
                return int.from_bytes(piece, "little")
        return None
