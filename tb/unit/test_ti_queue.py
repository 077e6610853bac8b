# SPDX-License-Identifier: Apache-2.0
"""`ti_queue` takes every push at once and gives the beats back in order."""

from collections import deque

import cocotb
from agents.bench import run, start
from cocotb.triggers import ReadOnly, RisingEdge

DEPTH = 4


async def play(dut, pushes, ready):
    """Give each push (a beat or None) a cycle, against a deque; returns the most that was held."""
    held = deque()
    most = 0
    for push in pushes:
        push = push if len(held) < DEPTH else None  # the caller knows that there is room
        dut.push_i.value = push is not None
        dut.push_data_i.value = push or 0
        dut.queue_ready_i.value = ready()
        await ReadOnly()
        assert dut.queue_valid_o.value == bool(held)
        if held:
            assert dut.queue_data_o.value == held[0]
        if held and dut.queue_ready_i.value == 1:
            held.popleft()
        if push is not None:
            held.append(push)
        most = max(most, len(held))
        await RisingEdge(dut.clk_i)
    return most


@cocotb.test()
@cocotb.parametrize(p_push=[0.3, 1.0], p_ready=[0.3, 1.0])
async def keeps_order_under_stalls(dut, p_push, p_ready):
    rng = await start(dut)
    pushes = [rng.getrandbits(16) if rng.random() < p_push else None for _ in range(800)]

    most = await play(dut, pushes, lambda: rng.random() < p_ready)

    assert most == DEPTH or p_push <= p_ready, "the queue was never full"


@cocotb.test()
async def takes_depth_beats_while_the_reader_sleeps(dut):
    await start(dut)

    assert await play(dut, [11, 12, 13, 14], lambda: 0) == DEPTH

    dut.push_i.value = 0
    dut.queue_ready_i.value = 1
    for want in [11, 12, 13, 14]:
        await ReadOnly()
        assert dut.queue_valid_o.value == 1 and dut.queue_data_o.value == want
        await RisingEdge(dut.clk_i)
    await ReadOnly()
    assert dut.queue_valid_o.value == 0


def test_ti_queue():
    run("ti_common_top", "test_ti_queue")
