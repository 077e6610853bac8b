# SPDX-License-Identifier: Apache-2.0
"""`ti_ra` answers every request once with the right bytes, in every pattern and after all stalls.

Its rows: `ti_ra_row_claims.py`; answers that nothing waits for: `ti_ra_stray_claims.py`; rays that
look again, and a unit that blocks: `ti_ra_mode_claims.py`.
"""

import cocotb
import pytest
from agents.bench import consecutive, only_if, run, start
from agents.ra_bench import (
    BLOCKING,
    GATHER,
    MODE,
    PATTERNS,
    PLACES,
    RETRY,
    STAGES,
    WAYS,
    begin,
    pattern,
    play,
)
from cocotb.triggers import ClockCycles, RisingEdge

CLAIMS = ["test_ti_ra", "ti_ra_row_claims", "ti_ra_stray_claims", "ti_ra_mode_claims"]
# NumSlots, Rows, Ways, ElemBytes, CacheBytes, Mode, and what is not that of the configuration tiny.
SHAPES = {
    "small": (32, 8, 4, 8, 2048, GATHER, "trv_rows=8"),
    "tiny": (8, 2, 2, 8, 1024, GATHER, ""),
    "one line": (32, 8, 1, 4, 64, GATHER, "trv_rows=8"),
    "one set": (16, 8, 4, 32, 256, GATHER, "trv_rows=8"),
    "one row": (16, 1, 4, 8, 256, GATHER, "line_bytes=32"),
    "two slots": (2, 2, 1, 32, 128, GATHER, "line_bytes=32"),
    "odd": (5, 3, 2, 4, 1024, GATHER, "line_bytes=128 trv_rows=5 addr_bits=40"),
    "retry": (32, 8, 4, 8, 2048, RETRY, "trv_rows=8"),
    "retry, one set": (16, 8, 4, 32, 256, RETRY, "trv_rows=8"),
    "retry, one row": (5, 1, 1, 4, 128, RETRY, ""),
    "blocking": (16, 2, 2, 8, 1024, BLOCKING, ""),
    "blocking, one line": (4, 1, 1, 4, 64, BLOCKING, ""),
    "compare": (32, 8, 4, 8, 2048, GATHER, "trv_rows=8 lookup_stages=2"),
    "compare, one set": (16, 8, 4, 32, 256, GATHER, "trv_rows=8 lookup_stages=2 fill_bytes=8"),
    "compare, blocking": (16, 2, 2, 8, 1024, BLOCKING, "lookup_stages=2 fill_bytes=8"),
    "queue": (8, 2, 2, 8, 1024, GATHER, "lookup_stages=3"),
    "line": (16, 4, 4, 8, 2048, GATHER, "trv_rows=4 lookup_stages=4 fill_bytes=8"),
    "wait": (16, 4, 4, 8, 2048, GATHER, "trv_rows=4 lookup_stages=5"),
    "queue, one line": (32, 8, 1, 4, 64, GATHER, "trv_rows=8 lookup_stages=3 fill_bytes=16"),
    "queue, odd": (
        5,
        3,
        2,
        4,
        1024,
        GATHER,
        "line_bytes=128 trv_rows=5 lookup_stages=3 fill_bytes=8",
    ),
    "queue, retry": (32, 8, 4, 8, 2048, RETRY, "trv_rows=8 lookup_stages=3 fill_bytes=32"),
    "wait, retry, one row": (5, 1, 1, 4, 128, RETRY, "lookup_stages=5"),
}


@cocotb.test()
@cocotb.parametrize(name=PATTERNS)
@cocotb.parametrize(stalls=["none", "everywhere", "slow memory"])
async def gives_the_right_bytes_for_every_pattern(dut, name, stalls):
    rng, memory, slots = await begin(dut)
    if stalls == "none":
        memory.latency = lambda line: 1
    if stalls == "everywhere":
        memory.error = lambda line: rng.random() < 0.2
        memory.latency = lambda line: rng.randrange(1, 12)
        memory.ready = lambda: rng.random() < 0.4
        slots.gap = lambda: rng.random() < 0.3
        slots.ready = lambda: rng.random() < 0.5
    if stalls == "slow memory":
        memory.latency = lambda line: rng.choice([3, 40])

    await slots.done(slots.ask(pattern(name, slots, rng, 120)))

    slots.finish()


@cocotb.test()
async def survives_a_long_mix_of_patterns_and_stalls(dut):
    rng, memory, slots = await begin(dut)
    for _ in range(12):
        most, p_error, p_line = rng.choice([1, 6, 60]), rng.choice([0.0, 0.1]), rng.random()
        p_gap, p_ready = rng.choice([0.0, 0.5]), rng.choice([0.1, 0.8, 1.0])
        memory.latency = lambda line, most=most: rng.randint(1, most)
        memory.error = lambda line, p=p_error: rng.random() < p
        memory.ready = lambda p=p_line: rng.random() < max(p, 0.1)
        slots.gap = lambda p=p_gap: rng.random() < p
        slots.ready = lambda p=p_ready: rng.random() < p
        tickets = slots.ask(pattern(rng.choice(PATTERNS), slots, rng, 60))
        await slots.decided(tickets)  # the next phase meets what is still in flight
    await slots.done(tickets)

    slots.finish()


@cocotb.test()
async def answers_a_hit_a_cycle_after_its_look_up(dut):
    _, _, slots = await begin(dut)
    await slots.bring(3)
    for elem in range(slots.line_bytes // slots.elem_bytes):
        (ticket,) = slots.ask([slots.addr(3, elem)])
        await slots.done([ticket])
        assert ticket.kind == "hit" and ticket.done - ticket.taken == STAGES + 1


@cocotb.test()
async def answers_hits_one_a_cycle(dut):
    _, _, slots = await begin(dut)
    await slots.bring(3)
    # A slot asks again a cycle after its answer: so many slots fill the unit.
    count = 100 if slots.num_slots >= STAGES + 2 else slots.num_slots
    tickets = slots.ask([slots.any_addr(3) for _ in range(count)])
    await slots.done(tickets)

    assert {t.kind for t in tickets} == {"hit"}
    assert consecutive([t.taken for t in tickets])
    assert consecutive([t.done for t in tickets])


@only_if(MODE == GATHER and PLACES > 1)
async def answers_hits_while_a_line_is_on_its_way(dut):
    _, memory, slots = await begin(dut)
    await slots.bring(3)
    memory.hold()
    (late,) = slots.ask([slots.any_addr(4)])
    count = 60 if slots.num_slots >= STAGES + 3 else 1
    early = slots.ask([slots.any_addr(3) for _ in range(count)])
    await slots.done(early)

    assert late.kind == "miss" and late.done is None
    assert {t.kind for t in early} == {"hit"} and consecutive([t.done for t in early])
    memory.release(4)
    await slots.done([late])


@only_if(MODE == GATHER)
async def an_error_flags_the_rays_of_its_line_and_the_next_access_asks_again(dut):
    _, memory, slots = await begin(dut)
    bad, good = 8, 9
    memory.error = lambda line: line == bad
    memory.hold()
    others = slots.sets * slots.ways > 1 and slots.rows > 1
    addrs = [bad if i % 2 or not others else good for i in range(slots.num_slots)]
    first = slots.ask([slots.any_addr(line) for line in addrs])
    await slots.decided(first)
    await slots.until(lambda: len(memory.held()) == len(set(addrs)))
    for line in set(addrs):
        memory.release(line)
    await slots.done(first)
    assert [t.error for t in first] == [line == bad for line in addrs]

    memory.error = lambda line: False
    memory.latency = lambda line: 3
    asked = len(memory.asked)
    again = slots.ask([slots.any_addr(bad)])
    await slots.done(again)
    assert again[0].kind == "miss" and not again[0].error and memory.asked[asked:] == [bad]
    then = slots.ask([slots.any_addr(bad)])
    await slots.done(then)
    assert then[0].kind == "hit"
    slots.finish()


@only_if(WAYS > 1)
async def a_line_used_lately_stays(dut):
    _, _, slots = await begin(dut)
    await slots.bring(*(slots.line_of(0, number) for number in range(slots.ways)))
    for extra in range(3 * slots.ways):
        used = slots.ask([slots.any_addr(slots.line_of(0, 0))])
        await slots.done(used)
        assert used[0].kind == "hit", f"gone after {extra} other lines"
        await slots.bring(slots.line_of(0, slots.ways + extra))


@cocotb.test()
@cocotb.parametrize(latency=[1, 4, 20])
async def a_storm_of_conflicts_starves_no_ray(dut, latency):
    """Each ray wants a line of its own in one set; a line may go as soon as its ray has it."""
    _, memory, slots = await begin(dut)
    memory.latency = lambda line: latency
    tickets = slots.ask(
        [slots.any_addr(slots.line_of(0, number)) for number in range(4 * slots.num_slots)]
    )
    await slots.done(tickets)

    assert MODE == RETRY or all(t.kind == "miss" for t in tickets)
    assert len(memory.asked) == len(tickets), "a line was asked for twice for one ray"
    slots.finish()


@only_if(MODE != RETRY)
async def forgets_everything_on_reset(dut):
    rng = await start(dut)
    memory, slots, tasks = play(dut, rng)
    await slots.bring(1, 2)
    memory.hold()
    slots.ready = lambda: False
    lost = slots.ask([slots.any_addr(line) for line in (2, 3)])
    await slots.decided(lost)  # a line on its way and, if there is room, an answer at the port
    for task in tasks:
        task.cancel()
    dut.rst_ni.value = 0
    dut.req_valid_i.value = 0
    dut.line_rsp_valid_i.value = 0
    await ClockCycles(dut.clk_i, 2)
    dut.rst_ni.value = 1
    await RisingEdge(dut.clk_i)
    assert dut.rsp_valid_o.value == 0 and dut.line_req_valid_o.value == 0

    memory, slots, _ = play(dut, rng)
    again = slots.ask([slots.any_addr(line) for line in (1, 2, 3)])
    await slots.done(again)
    assert {t.kind for t in again} == {"miss"}
    slots.finish()


@only_if(MODE != RETRY)
async def forgets_every_line_on_flush(dut):
    rng, _, slots = await begin(dut)
    kept = slots.sets * slots.ways
    for round_ in range(4):
        first = round_ % 2  # the same lines again, and others
        tickets = slots.ask([slots.any_addr(first + line) for line in range(kept)])
        await slots.done(tickets)
        assert {t.kind for t in tickets} == {"miss"}
        again = slots.ask([slots.any_addr(first + kept - 1) for _ in range(rng.randrange(1, 4))])
        await slots.done(again)
        assert {t.kind for t in again} == {"hit"}
        await slots.flush()
    slots.finish()


@cocotb.test()
async def survives_flushes_between_mixes_of_patterns(dut):
    rng, memory, slots = await begin(dut)
    memory.latency = lambda line: rng.randrange(1, 12)
    memory.error = lambda line: rng.random() < 0.1
    slots.ready = lambda: rng.random() < 0.7
    for _ in range(10):
        await slots.done(slots.ask(pattern(rng.choice(PATTERNS), slots, rng, 40)))
        await slots.flush()
    slots.finish()


@pytest.mark.parametrize("shape", SHAPES)
def test_ti_ra(shape):
    names = ("NumSlots", "Rows", "Ways", "ElemBytes", "CacheBytes", "Mode")
    *values, overrides = SHAPES[shape]
    params = dict(zip(names, values, strict=True))
    run("ti_ra", CLAIMS, config=f"tiny {overrides}".strip(), params=params)
