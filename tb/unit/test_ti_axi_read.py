# SPDX-License-Identifier: Apache-2.0
"""`ti_axi_read` makes one AXI4 burst of one beat of each request and brings every answer back."""

import cocotb
import pytest
from agents.bench import run, start
from cocotb.triggers import ReadOnly, RisingEdge

OKAY, EXOKAY, SLVERR, DECERR = range(4)


async def begin(dut):
    """Reset with the AXI inputs at rest; returns the random source and the bytes of a line."""
    for name in ("arready", "rvalid", "rid", "rdata", "rresp", "rlast"):
        getattr(dut, f"m_axi_{name}").value = 0
    return await start(dut), int(dut.LineBytes.value)


def read_answer(dut):
    """(id, data, error) of the answer at the port, or None."""
    if dut.rsp_valid_o.value == 0:
        return None
    return int(dut.rsp_id_o.value), int(dut.rsp_data_o.value), int(dut.rsp_error_o.value)


async def drive_beat(dut, beat=None):
    """One cycle of the R channel with (id, data, resp, last) or None; returns the answer seen."""
    dut.m_axi_rvalid.value = beat is not None
    if beat is not None:
        dut.m_axi_rid.value, dut.m_axi_rdata.value = beat[:2]
        dut.m_axi_rresp.value, dut.m_axi_rlast.value = beat[2:]
    await ReadOnly()
    assert dut.m_axi_rready.value == 1, "answers are always taken"
    seen = read_answer(dut)
    await RisingEdge(dut.clk_i)
    return seen


@cocotb.test()
@cocotb.parametrize(p_valid=[0.4, 1.0], p_ready=[0.2, 1.0])
async def asks_for_the_bytes_of_each_line_once(dut, p_valid, p_ready):
    rng, line_bytes = await begin(dut)
    top = (1 << int(dut.AddrWidth.value)) // line_bytes - 1
    lines = [0, top] + [rng.randrange(top + 1) for _ in range(300)]
    want = [(i % (1 << int(dut.IdWidth.value)), line * line_bytes) for i, line in enumerate(lines)]
    got, at, offered = [], 0, False
    while at < len(want):
        offered = offered or rng.random() < p_valid
        dut.req_valid_i.value = offered
        dut.req_id_i.value, dut.req_line_i.value = want[at][0], lines[at]
        dut.m_axi_arready.value = rng.random() < p_ready
        await ReadOnly()
        assert dut.m_axi_arvalid.value == offered, "valid waits for no ready"
        assert dut.req_ready_o.value == dut.m_axi_arready.value
        if offered:  # held while it is stalled, so looked at in every cycle
            assert (int(dut.m_axi_arid.value), int(dut.m_axi_araddr.value)) == want[at]
            assert dut.m_axi_arlen.value == 0 and dut.m_axi_arburst.value == 1  # one beat, INCR
            assert 1 << int(dut.m_axi_arsize.value) == line_bytes
            if dut.m_axi_arready.value == 1:
                got.append(want[at])
                at, offered = at + 1, False
        await RisingEdge(dut.clk_i)

    assert got == want


@cocotb.test()
@cocotb.parametrize(p_beat=[0.4, 1.0])
async def brings_answers_back_in_any_order_a_cycle_later(dut, p_beat):
    rng, line_bytes = await begin(dut)
    before = None
    for _ in range(500):
        beat = None
        if rng.random() < p_beat:
            identity = rng.getrandbits(int(dut.IdWidth.value))
            data = rng.getrandbits(8 * line_bytes)
            beat = (identity, data, rng.randrange(4), int(rng.random() < 0.9))
        seen = await drive_beat(dut, beat)
        assert seen == before
        before = beat and (*beat[:2], int(beat[2] in (SLVERR, DECERR) or not beat[3]))


@cocotb.test()
@cocotb.parametrize(resp=[OKAY, EXOKAY, SLVERR, DECERR], last=[1, 0])
async def slverr_decerr_and_a_missing_rlast_are_errors(dut, resp, last):
    await begin(dut)
    await drive_beat(dut, (5, 77, resp, last))
    seen = await drive_beat(dut)

    assert seen == (5, 77, int(resp in (SLVERR, DECERR) or not last))
    assert await drive_beat(dut) is None


@cocotb.test()
async def forgets_an_answer_on_reset(dut):
    await begin(dut)
    await drive_beat(dut, (1, 2, OKAY, 1))
    dut.rst_ni.value = 0
    await drive_beat(dut)
    dut.rst_ni.value = 1
    assert await drive_beat(dut) is None


@pytest.mark.parametrize("line_bytes", [64, 16])
def test_ti_axi_read(line_bytes):
    run("ti_axi_read", "test_ti_axi_read", LineBytes=line_bytes)
