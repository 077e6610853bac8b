# SPDX-License-Identifier: Apache-2.0
"""`ti_ram_1r1w` reads what was written last, a cycle later, and keeps its output between reads."""

import cocotb
from agents.bench import run, start
from cocotb.triggers import ReadOnly, RisingEdge

DEPTH = 6


@cocotb.test()
@cocotb.parametrize(p_read=[0.3, 1.0], p_write=[0.3, 1.0])
async def reads_what_was_written_last(dut, p_read, p_write):
    rng = await start(dut)
    words = [None] * DEPTH
    out = None
    for step in range(1000):
        await ReadOnly()
        if out is not None:
            assert dut.read_data_o.value == out, f"step {step}"
        await RisingEdge(dut.clk_i)
        read, write = rng.random() < p_read, rng.random() < p_write
        read_at, write_at = rng.sample(range(DEPTH), 2)  # never the same word in one cycle
        dut.read_en_i.value, dut.read_addr_i.value = read, read_at
        dut.write_en_i.value, dut.write_addr_i.value = write, write_at
        dut.write_data_i.value = data = rng.getrandbits(16)
        await ReadOnly()
        if out is not None:
            assert dut.read_data_o.value == out, "the output moved before the clock edge"
        await RisingEdge(dut.clk_i)
        if read:
            out = words[read_at]
        if write:
            words[write_at] = data
        dut.read_en_i.value = dut.write_en_i.value = 0


def test_ti_ram_1r1w():
    run("ti_common_top", "test_ti_ram_1r1w")
