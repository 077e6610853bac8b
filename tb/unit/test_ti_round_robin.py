# SPDX-License-Identifier: Apache-2.0
"""`ti_round_robin` picks the next request at or above `from_i`, for every input of 1 to 6."""

import cocotb
from agents.bench import run, start
from cocotb.triggers import Timer

MOST = 6


def choice(num, request, start_at):
    """The first request that a walk from `start_at` upwards, wrapping, meets; None without one."""
    walk = ((start_at + i) % num for i in range(num))
    return next((i for i in walk if request >> i & 1), None)


@cocotb.test()
@cocotb.parametrize(num=range(1, MOST + 1))
async def picks_the_next_request_for_every_input(dut, num):
    await start(dut)
    for start_at in range(num):
        for request in range(1 << num):
            dut.from_i.value, dut.request_i.value = start_at, request
            await Timer(1, "ns")
            want = choice(num, request, start_at)
            case = f"num={num} from={start_at} request={request:#b}"
            assert dut.any_o[num - 1].value == (want is not None), case
            if want is not None:
                assert dut.index_o[num - 1].value == want, case


def test_ti_round_robin():
    run("ti_common_top", "test_ti_round_robin")
