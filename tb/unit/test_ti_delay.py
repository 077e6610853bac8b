# SPDX-License-Identifier: Apache-2.0
"""`ti_delay` gives each payload back exactly `Cycles` cycles later, for 0 to 7 cycles."""

import cocotb
from agents.bench import run, start
from cocotb.triggers import ReadOnly, RisingEdge

NUM_DELAYS = 8


@cocotb.test()
@cocotb.parametrize(cycles=range(NUM_DELAYS))
async def delays_by_exactly_its_cycles(dut, cycles):
    rng = await start(dut)
    put_in = []
    for now in range(200):
        put_in.append(rng.getrandbits(16))
        dut.data_i.value = put_in[-1]
        await ReadOnly()
        if now >= cycles:
            assert dut.delayed_data_o[cycles].value == put_in[now - cycles], f"cycle {now}"
        await RisingEdge(dut.clk_i)


def test_ti_delay():
    run("ti_common_top", "test_ti_delay")
