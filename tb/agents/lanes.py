# SPDX-License-Identifier: Apache-2.0
"""Streams that stand side by side at a cluster, one at a time."""

from cocotb.handle import ArrayObject


class Lanes:
    """`lanes[i]` is the cluster as agents of one unit see it: lane i of each port.

    `valid` and `ready` of all lanes are one port each, so whoever drives a lane of a cluster must
    do so through the same `Lanes`, made anew after each reset.
    """

    def __init__(self, dut):
        self._dut = dut
        self.levels = {}  # what this has put on each port of bits

    def __getitem__(self, index):
        return Lane(self._dut, self.levels, index)


class Lane:
    def __init__(self, dut, levels, index):
        self._dut, self._levels, self._index = dut, levels, index
        self.clk_i, self.rst_ni = dut.clk_i, dut.rst_ni

    def __getattr__(self, name):
        port = getattr(self._dut, name)
        if isinstance(port, ArrayObject):
            return port[self._index]
        return Bit(port, name, self._levels, self._index)


class Bit:
    """One bit of a port, with the `value` of a port."""

    def __init__(self, port, name, levels, index):
        self._port, self._name, self._levels, self._index = port, name, levels, index

    @property
    def value(self):
        return int(self._port.value) >> self._index & 1

    @value.setter
    def value(self, level):
        mask = 1 << self._index
        others = self._levels.get(self._name, 0) & ~mask
        self._levels[self._name] = others | (mask if level else 0)
        self._port.value = self._levels[self._name]
