# SPDX-License-Identifier: Apache-2.0
"""Drive a pipeline that has a `valid` and a fixed latency but never stalls."""

from cocotb.triggers import ReadOnly, RisingEdge


async def replay(dut, beats, *, gap=lambda: False, drain=64, read=None):
    """Put in one beat (a dict of port values) a cycle, save where `gap()` says no.

    Returns the cycles in which beats went in, and (cycle, what `read()` gives) of all that came
    out; by default `result_o`.  Runs `drain` cycles on after the last beat, so that a result too
    many shows up as well.
    """
    read = read or (lambda: int(dut.result_o.value))
    sent, got = [], []
    waiting = list(reversed(beats))
    cycle, last = 0, 0
    while waiting or cycle < last + drain:
        valid = bool(waiting) and not gap()
        dut.valid_i.value = int(valid)
        if valid:
            for port, value in waiting.pop().items():
                getattr(dut, port).value = value
            sent.append(cycle)
            last = cycle
        await ReadOnly()
        if dut.valid_o.value == 1:
            got.append((cycle, read()))
        await RisingEdge(dut.clk_i)
        cycle += 1
    return sent, got
