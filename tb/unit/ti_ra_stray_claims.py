# SPDX-License-Identifier: Apache-2.0
"""`ti_ra` drops line answers that it has not asked for, and second ones, and goes on.

Run by `test_ti_ra.py`.
"""

import cocotb
from agents.bench import only_if
from agents.ra_bench import GATHER, MODE, PATTERNS, ROW_IDS, ROWS, begin, pattern
from cocotb.triggers import ClockCycles
from models.payload import payloads


@only_if(ROWS < ROW_IDS)
async def drops_answers_under_ids_that_no_row_has(dut):
    rng, memory, slots = await begin(dut)
    memory.latency = lambda line: rng.randrange(1, 12)
    unknown = range(slots.rows, 1 << payloads().width("row_id_t"))
    for name in PATTERNS:
        for _ in range(40):
            memory.stray(rng.choice(unknown))
        await slots.done(slots.ask(pattern(name, slots, rng, 80)))
    await slots.until(lambda: not memory.strays_left(), patience=5000 * slots.words)
    slots.finish()


@only_if(MODE == GATHER)
async def drops_answers_to_rows_that_are_free(dut):
    rng, memory, slots = await begin(dut)
    await slots.bring(1, 2)
    for row in range(slots.rows):  # to an idle unit
        memory.stray(row)
    await ClockCycles(dut.clk_i, slots.rows * slots.words + 4)
    again = slots.ask([slots.any_addr(line) for line in (1, 2)])
    await slots.done(again)

    memory.hold()  # and while other rows wait
    lines = list(range(10, 10 + min(slots.rows, slots.sets * slots.ways, slots.num_slots)))
    tickets = slots.ask([slots.any_addr(line) for line in lines])
    await slots.until(lambda: len(memory.held()) == len(lines))
    for line, ticket in zip(rng.sample(lines, len(lines)), range(len(lines)), strict=True):
        taken = {memory.identity_of(held) for held in memory.held()}
        for row in set(range(slots.rows)) - taken:
            memory.stray(row)
        await ClockCycles(dut.clk_i, slots.rows * slots.words + 4)
        assert not memory.strays_left()
        assert sum(t.done is not None for t in tickets) == ticket
        memory.release(line)
        await slots.done([tickets[lines.index(line)]])
    slots.finish()


@only_if(MODE == GATHER)
async def drops_a_second_answer_to_a_row_that_hands_out(dut):
    _, memory, slots = await begin(dut)
    memory.hold()
    tickets = slots.ask([slots.any_addr(7) for _ in range(slots.num_slots)])
    await slots.decided(tickets)
    await slots.until(lambda: memory.held() == [7])
    row = memory.identity_of(7)
    slots.ready = lambda: False
    memory.release(7)
    await ClockCycles(dut.clk_i, slots.words + 4)  # a ray stands at the port, the others in the row
    for _ in range(3):
        memory.stray(row)
    await ClockCycles(dut.clk_i, 3 * slots.words + 7)
    assert not memory.strays_left()
    slots.ready = lambda: True
    await slots.done(tickets)
    memory.latency = lambda line: 3
    more = slots.ask([slots.any_addr(line) for line in (7, 8)])
    await slots.done(more)

    assert more[0].kind == "hit"
    slots.finish()


@cocotb.test()
@cocotb.parametrize(name=PATTERNS)
async def drops_second_answers_in_traffic(dut, name):
    rng, memory, slots = await begin(dut)
    memory.latency = lambda line: rng.randrange(1, 6)
    memory.error = lambda line: rng.random() < 0.2
    memory.repeat = lambda: rng.random() < 0.5
    slots.ready = lambda: rng.random() < 0.7

    await slots.done(slots.ask(pattern(name, slots, rng, 120)))

    slots.finish()
