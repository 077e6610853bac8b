# SPDX-License-Identifier: Apache-2.0
"""`ti_regfile` reads in the same cycle what was written last, from the cycle after its write on."""

import cocotb
from agents.bench import run, start
from cocotb.triggers import ReadOnly, RisingEdge

DEPTH = 6


@cocotb.test()
@cocotb.parametrize(p_write=[0.3, 1.0])
async def reads_at_once_what_was_written_last(dut, p_write):
    rng = await start(dut)
    words = [None] * DEPTH
    for step in range(1000):
        read_at, write_at, write = (
            rng.randrange(DEPTH),
            rng.randrange(DEPTH),
            rng.random() < p_write,
        )
        dut.read_addr_i.value = read_at
        dut.write_en_i.value, dut.write_addr_i.value = write, write_at
        dut.write_data_i.value = data = rng.getrandbits(16)
        await ReadOnly()
        for kind, out in enumerate(dut.file_data_o):
            assert words[read_at] in (None, out.value), f"step {step}, kind {kind}"
        await RisingEdge(dut.clk_i)
        if write:
            words[write_at] = data


@cocotb.test()
async def keeps_every_word_until_it_is_written_again(dut):
    rng = await start(dut)
    words = [rng.getrandbits(16) for _ in range(DEPTH)]
    dut.write_en_i.value = 1
    for at, word in enumerate(words):
        dut.write_addr_i.value, dut.write_data_i.value = at, word
        await RisingEdge(dut.clk_i)
    dut.write_en_i.value = 0
    for at in [rng.randrange(DEPTH) for _ in range(50)]:
        dut.read_addr_i.value = at
        dut.write_addr_i.value, dut.write_data_i.value = rng.randrange(DEPTH), rng.getrandbits(16)
        await ReadOnly()
        assert [out.value for out in dut.file_data_o] == [words[at]] * 2
        await RisingEdge(dut.clk_i)


def test_ti_regfile():
    run("ti_common_top", "test_ti_regfile")
