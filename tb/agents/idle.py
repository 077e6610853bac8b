# SPDX-License-Identifier: Apache-2.0
"""See that a unit says it is idle exactly while nothing is inside."""

import cocotb
from cocotb.triggers import ReadOnly, RisingEdge


def one(bits):
    """A beat counts once."""
    return 1


class Idle:
    """Watches `idle_o` from now on: 0 from the first beat in to the last one out.

    `ins` and `outs` name streams of the unit, with what a beat adds to what is inside, or takes
    from it.
    """

    def __init__(self, dut, ins, outs):
        self._dut, self._idle, self._clk = dut, dut.idle_o, dut.clk_i
        self._ends = [
            *((self._ports(name, "i", "o"), weight, 1) for name, weight in ins.items()),
            *((self._ports(name, "o", "i"), weight, -1) for name, weight in outs.items()),
        ]
        self.inside = 0
        cocotb.start_soon(self._run())

    def _ports(self, name, drives, takes):
        ports = (f"{name}_valid_{drives}", f"{name}_ready_{takes}", f"{name}_data_{drives}")
        return [getattr(self._dut, port) for port in ports]

    async def _run(self):
        while True:
            await ReadOnly()
            idle = bool(self._idle.value)
            assert idle == (self.inside == 0), f"idle_o is {idle:d} with {self.inside} inside"
            for (valid, ready, data), weight, sign in self._ends:
                if valid.value and ready.value:
                    self.inside += sign * weight(int(data.value))
            assert self.inside >= 0, "more came out than went in"
            await RisingEdge(self._clk)
