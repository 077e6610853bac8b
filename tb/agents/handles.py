# SPDX-License-Identifier: Apache-2.0
"""Ports of a design for agents that look at them in every cycle."""


class Handles:
    """A design whose signals and parameters are looked up once each."""

    def __init__(self, dut):
        self._dut = dut

    def __getattr__(self, name):
        handle = getattr(self._dut, name)
        setattr(self, name, handle)
        return handle


class Inputs:
    """Inputs of a design that nobody else drives: written where they change."""

    def __init__(self, dut):
        self._dut, self._values = dut, {}

    def drive(self, name, value):
        if self._values.get(name) != value:
            self._values[name] = value
            getattr(self._dut, name).value = value
