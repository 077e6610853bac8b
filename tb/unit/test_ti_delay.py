# SPDX-License-Identifier: Apache-2.0
"""`ti_delay` gives a payload back exactly `Cycles` cycles later, 0 to 7, as ring and as chain."""

import cocotb
import pytest
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


@pytest.mark.parametrize("ring_delays", [1, 0])
def test_ti_delay(ring_delays):
    run("ti_common_top", "test_ti_delay", config=f"tiny ring_delays={ring_delays}")
