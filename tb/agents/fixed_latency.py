# SPDX-License-Identifier: Apache-2.0
"""Drive a pipeline that has a `valid` and a fixed latency but never stalls."""

from agents.handles import Handles, Inputs
from cocotb.triggers import ReadOnly, RisingEdge


async def replay(dut, beats, *, gap=lambda: False, drain=64, read=None):
    """Put in one beat (a dict of port values) a cycle, save where `gap()` says no.

    Returns the cycles in which beats went in, and (cycle, what `read()` gives) of all that came
    out; by default `result_o`.  Runs `drain` cycles on after the last beat, so that a result too
    many shows up as well.
    """
    read = read or (lambda: int(dut.result_o.value))
    ports, inputs = Handles(dut), Inputs(dut)
    sent, got = [], []
    waiting = list(reversed(beats))
    cycle, last = 0, 0
    while waiting or cycle < last + drain:
        valid = bool(waiting) and not gap()
        inputs.drive("valid_i", int(valid))
        if valid:
            for port, value in waiting.pop().items():
                inputs.drive(port, value)
            sent.append(cycle)
            last = cycle
        await ReadOnly()
        if ports.valid_o.value:
            got.append((cycle, read()))
        await RisingEdge(ports.clk_i)
        cycle += 1
    return sent, got
