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


@cocotb.test()
async def a_read_of_the_word_being_written_gives_the_inverse_of_the_old_one(dut):
    """So that a caller who uses such a read, which hardware may answer with anything, is found."""
    rng = await start(dut)
    mask = (1 << len(dut.read_data_o)) - 1
    for at in list(range(DEPTH)) * 8:
        old, new = rng.getrandbits(16), rng.getrandbits(16)
        dut.write_en_i.value, dut.write_addr_i.value, dut.write_data_i.value = 1, at, old
        await RisingEdge(dut.clk_i)
        dut.write_data_i.value = new
        dut.read_en_i.value, dut.read_addr_i.value = 1, at
        await RisingEdge(dut.clk_i)
        dut.write_en_i.value = 0
        await ReadOnly()
        assert dut.read_data_o.value == old ^ mask
        await RisingEdge(dut.clk_i)
        await ReadOnly()
        assert dut.read_data_o.value == new, "the write itself is as any other"
        await RisingEdge(dut.clk_i)


def test_ti_ram_1r1w():
    run("ti_common_top", "test_ti_ram_1r1w")
