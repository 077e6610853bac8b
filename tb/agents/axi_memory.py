# SPDX-License-Identifier: Apache-2.0
"""An AXI4 slave that holds images and answers reads of whole lines."""

import cocotb
from cocotb.triggers import ReadOnly, RisingEdge

OKAY, EXOKAY, SLVERR, DECERR = range(4)
INCR = 1


class AxiMemory:
    """Answers `m_axi_ar*` on `m_axi_r*`, in random order among the answers that are due.

    `latency()` is the number of cycles from a request to its answer, `ready()` the ready bit of
    each cycle, `resp()` the response of each answer; bytes of a bad answer are random.  Lines that
    touch no image are answered with DECERR.  Checks that a request is one aligned beat of a line,
    stays until it is taken, and carries an identity that is not in flight; and that answers are
    always taken.
    """

    def __init__(self, dut, rng, *, latency=lambda: 10, ready=lambda: 1, resp=lambda: OKAY):
        self._dut, self._rng = dut, rng
        self.latency, self.ready, self.resp = latency, ready, resp
        self._line_bytes = len(dut.m_axi_rdata) // 8
        self._images = []  # (base, bytes)
        self._waiting = []  # (cycle when due, identity, address)
        self._stalled = None  # the request that was not taken
        self.addresses = []  # of all requests, in order
        for name in ("arready", "rvalid", "rid", "rdata", "rresp", "rlast"):
            self._port(name).value = 0
        cocotb.start_soon(self._run())

    def put(self, base, data):
        """Hold an image at an address."""
        self._images.append((base, data))

    def forget(self):
        """Drop what is in flight, as a slave does on reset."""
        self._waiting.clear()
        self._stalled = None

    def in_flight(self):
        return len(self._waiting)

    def _port(self, name):
        return getattr(self._dut, f"m_axi_{name}")

    async def _run(self):
        cycle = 0
        while True:
            self._answer(cycle)
            self._port("arready").value = int(self.ready())
            await ReadOnly()
            if self._dut.rst_ni.value == 1:
                assert self._port("rready").value == 1, "answers are always taken"
                self._ask(cycle)
            await RisingEdge(self._dut.clk_i)
            cycle += 1

    def _ask(self, cycle):
        if self._port("arvalid").value == 0:
            assert self._stalled is None, "a request went away before it was taken"
            return
        identity, address = int(self._port("arid").value), int(self._port("araddr").value)
        assert self._stalled in (None, (identity, address)), "a request changed while it waited"
        self._stalled = None if self._port("arready").value == 1 else (identity, address)
        if self._stalled:
            return
        assert address % self._line_bytes == 0
        assert self._port("arlen").value == 0 and self._port("arburst").value == INCR
        assert 1 << int(self._port("arsize").value) == self._line_bytes
        assert all(identity != other for _, other, _ in self._waiting), f"{identity} is in flight"
        self._waiting.append((cycle + max(self.latency(), 1), identity, address))
        self.addresses.append(address)

    def _answer(self, cycle):
        due = [entry for entry in self._waiting if entry[0] <= cycle]
        self._port("rvalid").value = bool(due)
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
            self._port(name).value = value

    def _line(self, address):
        """A line as an integer, or None outside of all images."""
        for base, data in self._images:
            start = address - base
            if -self._line_bytes < start < len(data):
                piece = data[max(start, 0) : start + self._line_bytes]
                piece = piece.rjust(self._line_bytes, b"\0") if start < 0 else piece
                return int.from_bytes(piece, "little")
        return None
