# SPDX-License-Identifier: Apache-2.0
"""Serve the line requests of one unit from the bytes of an image."""

import cocotb
from cocotb.triggers import ReadOnly, RisingEdge


class ImageMemory:
    """Answers `line_req_*` on `line_rsp_*`, at most one line a cycle.

    `bytes` stand at address `base`; lines that do not touch them, and those (by number) for which
    `fails` is true, are answered with an error.  `latency()` is the number of cycles from a request
    to its answer, so that answers overtake one another; `ready()` the ready bit of each cycle.
    """

    def __init__(self, dut, data, base, *, latency=lambda: 10, ready=lambda: 1, fails=None):
        self._dut, self._data, self._base = dut, data, base
        self._latency, self._ready = latency, ready
        self._fails = fails or (lambda line: False)
        self._line_bytes = len(dut.line_rsp_data_i) // 8
        self._due = []  # (cycle, row, line)
        self.requested = []  # lines in order
        cocotb.start_soon(self._run())

    def line_of(self, address):
        return address // self._line_bytes

    async def _run(self):
        dut, cycle = self._dut, 0
        while True:
            dut.line_req_ready_i.value = int(self._ready())
            self._answer(cycle)
            await ReadOnly()
            if dut.line_req_valid_o.value == 1 and dut.line_req_ready_i.value == 1:
                line = int(dut.line_req_line_o.value)
                self.requested.append(line)
                due = cycle + max(self._latency(), 1)
                self._due.append((due, int(dut.line_req_row_o.value), line))
            await RisingEdge(dut.clk_i)
            cycle += 1

    def _answer(self, cycle):
        due = min(self._due, default=None)
        self._dut.line_rsp_valid_i.value = int(due is not None and due[0] <= cycle)
        if due is None or due[0] > cycle:
            return
        self._due.remove(due)
        _, row, line = due
        start = line * self._line_bytes - self._base
        inside = -self._line_bytes < start < len(self._data)
        piece = self._data[max(start, 0) : max(start + self._line_bytes, 0)]
        piece = piece.rjust(self._line_bytes, b"\0") if start < 0 else piece
        self._dut.line_rsp_row_i.value = row
        self._dut.line_rsp_data_i.value = int.from_bytes(piece, "little")
        self._dut.line_rsp_error_i.value = int(not inside or self._fails(line))
