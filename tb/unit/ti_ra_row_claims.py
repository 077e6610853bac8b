# SPDX-License-Identifier: Apache-2.0
"""`ti_ra` gathers the rays of a line in a row and hands a row out at one ray a cycle.

Run by `test_ti_ra.py`.
"""

import cocotb
from agents.bench import consecutive, only_if
from agents.ra_bench import (
    BLOCKING,
    GATHER,
    MODE,
    PLACES,
    QUEUED,
    ROWS,
    SLOTS,
    STAGES,
    WAYS,
    WORDS,
    begin,
)
from cocotb.triggers import ClockCycles


@only_if(MODE == GATHER)
async def hands_out_a_row_one_ray_a_cycle(dut):
    _, memory, slots = await begin(dut)
    memory.hold()
    tickets = slots.ask([slots.any_addr(7) for _ in range(slots.num_slots)])
    await slots.decided(tickets)
    await ClockCycles(dut.clk_i, 3)
    memory.release(7)
    await slots.done(tickets)

    assert [t.kind for t in tickets] == ["miss"] + ["merged"] * (slots.num_slots - 1)
    filled = memory.answered[-1][0]
    first = filled + 2 + max(STAGES - 2, 0)
    assert sorted(t.done for t in tickets) == [first + i for i in range(slots.num_slots)]


@only_if(MODE == GATHER and ROWS >= 2 and PLACES >= 2 and max(4, 2 * WORDS) <= SLOTS)
async def hands_out_two_rows_without_a_gap(dut):
    _, memory, slots = await begin(dut)
    memory.hold()
    tickets = slots.ask([slots.any_addr(6 + i % 2) for i in range(slots.num_slots)])
    await slots.decided(tickets)
    await ClockCycles(dut.clk_i, 3)
    memory.release(7, after=1)
    memory.release(6, after=1 + WORDS)
    await slots.done(tickets)

    assert consecutive([t.done for t in tickets])


@only_if(MODE != BLOCKING)
async def a_line_that_comes_first_is_handed_out_first(dut):
    _, memory, slots = await begin(dut)
    lines = list(range(10, 10 + min(slots.rows, slots.sets * slots.ways, slots.num_slots)))
    memory.hold()
    tickets = slots.ask([slots.any_addr(line) for line in lines])
    await slots.decided(tickets)
    await slots.until(lambda: len(memory.held()) == len(lines))
    for line, ticket in reversed(list(zip(lines, tickets, strict=True))):
        memory.release(line)
        await slots.done([ticket])

    assert [line for _, line, _ in memory.answered] == lines[::-1]


@only_if(MODE == GATHER)
async def a_ray_may_join_a_row_up_to_the_cycle_in_which_it_fills(dut):
    _, memory, slots = await begin(dut)
    memory.hold()
    met = {}
    for wait in range(7 + WORDS):
        line = 20 + wait
        first = slots.ask([slots.any_addr(line)])
        await slots.until(lambda line=line: memory.held() == [line])
        memory.release(line, after=5)
        await ClockCycles(dut.clk_i, wait)
        second = slots.ask([slots.any_addr(line)])
        await slots.done(first + second)
        met[second[0].decided - memory.answered[-1][0]] = second[0].kind

    assert met[-1] == met[0] == "merged"
    assert met[max(met)] == "hit"
    assert all(kind == ("merged" if late <= 0 else "hit") for late, kind in met.items())


@only_if(MODE == GATHER and min(PLACES, SLOTS) > ROWS)
async def stalls_while_all_rows_are_taken_and_recovers(dut):
    _, memory, slots = await begin(dut)
    memory.hold()
    tickets = slots.ask([slots.any_addr(line) for line in range(slots.rows + 1)])
    await slots.until(lambda: len(memory.held()) == slots.rows)
    await ClockCycles(dut.clk_i, 20)
    assert slots.waits() and tickets[-1].kind is None, "a row more than there are"
    assert len(memory.held()) == slots.rows

    memory.release(0)
    await slots.decided(tickets)
    for line in range(1, slots.rows + 1):
        await slots.until(lambda line=line: line in memory.held())
        memory.release(line)
    await slots.done(tickets)
    slots.finish()


@only_if(MODE == GATHER and WAYS < ROWS and WAYS + QUEUED + 1 < SLOTS)
async def stalls_while_all_ways_are_pinned_and_recovers(dut):
    _, memory, slots = await begin(dut)
    lines = [slots.line_of(0, number) for number in range(slots.ways + 1)]
    memory.hold()
    tickets = slots.ask([slots.any_addr(line) for line in [lines[0]] * (1 + QUEUED) + lines])
    await slots.until(lambda: len(memory.held()) == slots.ways)
    await ClockCycles(dut.clk_i, 20)
    assert slots.waits() and tickets[-1].kind is None, "a line without a place"

    slots.ready = lambda: False
    memory.release(lines[0])
    await ClockCycles(dut.clk_i, 20)  # a ray of it stands at the port, one in the row
    assert slots.waits() and tickets[-1].kind is None, "the place went before it was handed out"

    slots.ready = lambda: True
    for line in lines[1:]:
        await slots.until(lambda line=line: line in memory.held())
        memory.release(line)
    await slots.done(tickets)
    slots.finish()


@only_if(MODE == GATHER)
@cocotb.parametrize(rays_a_line=[1, 2, 3], latency=[1, 3])
async def a_filled_row_waits_for_others_only_once(dut, rays_a_line, latency):
    """All rows fill at once; then misses that need only some of them stream on."""
    _, memory, slots = await begin(dut)
    memory.hold()
    rows = min(slots.rows, slots.sets * slots.ways, slots.num_slots)
    first = slots.ask([slots.any_addr(line) for line in range(rows)])
    await slots.until(lambda: len(memory.held()) == rows)
    for line in memory.held():
        memory.release(line)
    memory.latency = lambda line: latency
    stream = slots.ask([slots.any_addr(rows + i // rays_a_line) for i in range(200)])
    await slots.done(first + stream)

    for ticket in first + stream:
        if ticket.row:
            waited = ticket.read - ticket.row.answered
            assert waited <= 2 + 2 * slots.num_slots, f"{ticket.addr:#x}: {waited} cycles"
