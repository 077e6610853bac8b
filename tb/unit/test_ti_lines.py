# SPDX-License-Identifier: Apache-2.0
"""`ti_lines` passes every line request on once and brings each answer to the unit that asked."""

import cocotb
import pytest
from agents.bench import run, start
from agents.line_ports import LinePorts
from agents.memory import LineMemory
from cocotb.triggers import ClockCycles, ReadOnly, RisingEdge
from models.payload import configuration, parameter, payloads

MEMORY_PORTS = {
    "ask": ("req_{}_o", "req_{}_i", "port_req_t"),
    "answer": ("rsp_{}_i", "rsp_{}_o", "port_rsp_t"),
}
UNITS = parameter("NumUnits", 1)


async def begin(dut):
    rng = await start(dut)
    memory = LineMemory(dut, configuration()["line_bytes"], rng, MEMORY_PORTS)
    cocotb.start_soon(memory.run())
    return rng, memory, LinePorts(dut, rng)


@cocotb.test()
@cocotb.parametrize(p_gap=[0.0, 0.6], p_ready=[0.3, 1.0], p_stall=[0.0, 0.6], most=[1, 30])
async def answers_every_request_at_the_right_unit_and_id(dut, p_gap, p_ready, p_stall, most):
    rng, memory, units = await begin(dut)
    memory.ready = lambda: rng.random() < p_ready
    memory.latency = lambda line: rng.randint(1, most)
    memory.error = units.bad = lambda line: line % 5 == 0
    units.gap = lambda: rng.random() < p_gap
    units.ready = lambda unit: rng.random() >= p_stall
    units.left = [200] * units.num

    await units.play()

    assert units.answered == [200] * units.num and units.errors > 10
    assert memory.asked == [line for _, line in units.taken], "requests overtook each other"
    assert max(units.passed) < units.num, "a unit was passed by more than one of each other"


@cocotb.test()
async def requests_carry_the_number_of_their_client(dut):
    _, _, units = await begin(dut)
    first, seen = int(dut.FirstClient.value), set()
    units.left = [20] * units.num
    playing = cocotb.start_soon(units.play())
    while not playing.done():
        await ReadOnly()
        if dut.req_valid_o.value == 1:
            asked = payloads().unpack("port_req_t", int(dut.req_data_o.value))
            seen.add(asked["client"] - first)
            assert asked["client"] == first + units.unit_of[asked["req"]["line"]]
        await RisingEdge(dut.clk_i)

    assert seen == set(range(units.num))


@cocotb.test()
async def serves_the_units_in_turn_under_full_load(dut):
    _, memory, units = await begin(dut)
    memory.latency = lambda line: 1
    units.left = [100] * units.num

    await units.play()

    turns = [unit for unit, _ in units.taken]
    for at in range(len(turns) - 2 * units.num):
        assert sorted(turns[at : at + units.num]) == list(range(units.num)), f"from {at}"


# With fewer the units wait for their answers.
@cocotb.test(skip=UNITS < 2)
async def passes_one_request_a_cycle_after_one_cycle(dut):
    _, memory, units = await begin(dut)
    memory.latency = lambda line: 1
    units.left = [100] * units.num

    await units.play()

    first = units.taken_at[0]
    assert units.taken_at == list(range(first, first + 100 * units.num))
    # Asked for in the next cycle, answered by the memory in the one after, seen at once.
    assert units.answered_at == list(range(first + 2, first + 2 + 100 * units.num))


@cocotb.test()
async def an_answer_waits_for_its_unit_alone(dut):
    """A unit that is not ready stops the answers behind its own, and no ready of others does."""
    _, _, units = await begin(dut)
    sleeps = units.num - 1
    units.ready = lambda unit: unit == sleeps
    units.left = [0] * units.num
    units.left[sleeps] = 5
    await units.play()
    assert units.answered[sleeps] == 5

    units.ready = lambda unit: unit != sleeps
    units.left[sleeps] = 1
    playing = cocotb.start_soon(units.play())
    await ClockCycles(dut.clk_i, 30)
    await ReadOnly()
    assert int(dut.line_rsp_valid_o.value) == 1 << sleeps and dut.rsp_ready_o.value == 0
    await RisingEdge(dut.clk_i)
    units.ready = lambda unit: True
    await playing
    assert units.answered[sleeps] == 6


@cocotb.test()
async def takes_two_requests_while_the_memory_sleeps(dut):
    _, memory, units = await begin(dut)
    memory.ready = lambda: False
    units.left = [2] * units.num
    cocotb.start_soon(units.play())
    await ClockCycles(dut.clk_i, 10)

    assert len(units.taken) == 2 and not memory.asked


@pytest.mark.parametrize(("units", "first"), [(1, 0), (3, 1), (4, 3)])
def test_ti_lines(units, first):
    config = "tiny num_trv=4 num_list=2 trv_rows=4"
    run("ti_lines", "test_ti_lines", config=config, NumUnits=units, FirstClient=first)
