# SPDX-License-Identifier: Apache-2.0
"""A memory that holds an image, behind the line port of one unit."""

import random

import cocotb
from agents.memory import LineMemory
from models.payload import configuration


class ImageMemory(LineMemory):
    """Runs at once; `data` stands at address `base`, on a line boundary.

    Lines that do not touch it, and those (by number) for which `fails` is true, are answered with
    an error.  `latency()` is the number of cycles from a request to its answer.
    """

    def __init__(self, dut, data, base, *, latency=lambda: 10, ready=lambda: 1, fails=None):
        size = configuration()["line_bytes"]
        super().__init__(dut, size, random.Random(cocotb.RANDOM_SEED))
        first, count = base // size, -(-len(data) // size)
        self.latency = lambda line: latency()
        self.ready = ready
        self.error = lambda line: not first <= line < first + count or bool(fails and fails(line))
        self.data = lambda line: int.from_bytes(data[(line - first) * size :][:size], "little")
        cocotb.start_soon(self.run())

    def line_of(self, address):
        return address // self._line_bytes
