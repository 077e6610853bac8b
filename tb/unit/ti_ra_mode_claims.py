# SPDX-License-Identifier: Apache-2.0
"""A `ti_ra` that blocks stops at a miss; one whose rays look again has them do so in turn.

Run by `test_ti_ra.py`.
"""

from agents.bench import only_if
from agents.ra_bench import BLOCKING, MODE, PLACES, RETRY, ROWS, SLOTS, STAGES, begin
from cocotb.triggers import ClockCycles


@only_if(MODE == BLOCKING)
async def a_miss_stops_the_unit_until_its_ray_has_the_line(dut):
    _, memory, slots = await begin(dut)
    await slots.bring(3)
    asked = len(memory.asked)
    memory.hold()
    tickets = slots.ask([slots.any_addr(line) for line in ((4, 3, 5) if PLACES > 1 else (4, 4, 5))])
    await slots.until(lambda: memory.held() == [4])
    await ClockCycles(dut.clk_i, 50)
    assert [t.kind for t in tickets] == ["miss", None, None]
    slots.ready = lambda: False
    memory.release(4)
    await ClockCycles(dut.clk_i, 20)
    assert memory.asked[asked:] == [4], "a second line on its way"

    slots.ready = lambda: True
    await slots.until(lambda: memory.held() == [5])
    memory.release(5)
    await slots.done(tickets)
    assert [t.kind for t in tickets] == ["miss", "hit", "miss"]
    slots.finish()


@only_if(MODE == RETRY)
async def rays_look_again_in_every_cycle_until_their_line_is_there(dut):
    _, memory, slots = await begin(dut)
    memory.hold()
    tickets = slots.ask([slots.any_addr(7) for _ in range(slots.num_slots)])
    await slots.until(lambda: all(t.taken is not None for t in tickets))
    before = slots.counts.copy()
    await ClockCycles(dut.clk_i, 100)
    assert slots.counts - before == {"access": 100, "merged": 100}
    assert memory.held() == memory.asked == [7]

    memory.release(7)
    await slots.done(tickets)
    filled = memory.answered[-1][0]
    # One in each cycle, in turn: all within two rounds of the queue.
    assert max(t.done for t in tickets) - filled <= slots.num_slots + 3 + STAGES
    assert memory.asked == [7]
    slots.finish()


@only_if(MODE == RETRY and PLACES > 1)
async def a_new_ray_takes_turns_with_those_that_look_again(dut):
    _, memory, slots = await begin(dut)
    await slots.bring(3)
    memory.hold()
    late = slots.ask([slots.any_addr(4) for _ in range(slots.num_slots // 2)])
    await slots.until(lambda: all(t.taken is not None for t in late))
    early = slots.ask([slots.any_addr(3) for _ in range(60)])
    began = slots.counts["access"]
    await slots.done(early)
    looks = slots.counts["access"] - began - 60

    assert all(t.done is None for t in late)
    assert slots.num_slots < 8 or 50 <= looks <= 70, "half of the look-ups"
    memory.release(4)
    await slots.done(late)
    slots.finish()


@only_if(MODE == RETRY and min(PLACES, SLOTS - 1) > ROWS)
async def a_ray_without_a_row_keeps_new_rays_out_until_it_has_one(dut):
    _, memory, slots = await begin(dut)
    await slots.bring(3)
    memory.hold()
    waiting = slots.ask([slots.any_addr(10 + line) for line in range(slots.rows + 1)])
    await slots.until(lambda: len(memory.held()) == slots.rows and slots.refused > 2)
    new = slots.ask([slots.any_addr(3)])
    await ClockCycles(dut.clk_i, 100)
    assert new[0].taken is None and slots.refused > 2

    memory.release(memory.held()[0])
    await slots.until(lambda: len(memory.asked) == slots.rows + 2)
    await slots.until(lambda: new[0].taken is not None)
    memory.latency = lambda line: 3
    for line in memory.held():
        memory.release(line)
    await slots.done([*waiting, *new])
    slots.finish()
