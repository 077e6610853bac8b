# SPDX-License-Identifier: Apache-2.0
"""`ti_ra` answers every request once with the right bytes, and empties a row at one ray a cycle."""

import cocotb
import pytest
from agents.bench import consecutive, run, start
from agents.memory import LineMemory
from agents.requesters import Requesters, Retriers
from cocotb.triggers import ClockCycles, RisingEdge
from models.payload import configuration, parameter, payloads

GATHER, RETRY, BLOCKING = range(3)  # of ti_config_pkg::ray_accumulation_e
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
}
MODE = parameter("Mode", GATHER)
SLOTS, ROWS, WAYS = (parameter(name, 1) for name in ("NumSlots", "Rows", "Ways"))
ROW_IDS = 1 << payloads().width("row_id_t") if hasattr(cocotb, "top") else 1
PLACES = parameter("CacheBytes", 1) // parameter("LineBytes", 1)


def only(condition):
    """A test of the shapes for which `condition` holds; the others report it as skipped."""
    return cocotb.test(skip=not condition)


async def begin(dut):
    """Start the unit with a memory behind it and slots in front of it."""
    rng = await start(dut)
    memory, slots, _ = play(dut, rng)
    return rng, memory, slots


def play(dut, rng):
    """Memory and slots of a unit that has been reset, and the tasks that play them."""
    memory = LineMemory(dut, configuration()["line_bytes"], rng)
    slots = (Retriers if MODE == RETRY else Requesters)(dut, memory, rng)
    return memory, slots, [cocotb.start_soon(memory.run()), cocotb.start_soon(slots.run())]


PATTERNS = ["one line", "walk", "every line", "one set", "near", "far"]


def pattern(name, slots, rng, count):
    """Addresses of an access pattern."""
    kept = slots.sets * slots.ways
    top = (1 << configuration()["addr_bits"]) // slots.line_bytes - 1
    lines = {
        "one line": lambda i: 5,
        "walk": lambda i: i * slots.elem_bytes // slots.line_bytes,
        "every line": lambda i: i,
        "one set": lambda i: slots.line_of(slots.sets - 1, rng.randrange(slots.ways + 2)),
        "near": lambda i: rng.randrange(2 * kept),
        "far": lambda i: rng.choice([0, 1, top - 1, top, rng.randrange(top)]),
    }[name]
    return [slots.any_addr(lines(i)) for i in range(count)]


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

    await slots.done(slots.ask(pattern(name, slots, rng, 300)))

    slots.finish()


@cocotb.test()
async def survives_a_long_mix_of_patterns_and_stalls(dut):
    rng, memory, slots = await begin(dut)
    for _ in range(20):
        most, p_error, p_line = rng.choice([1, 6, 60]), rng.choice([0.0, 0.1]), rng.random()
        p_gap, p_ready = rng.choice([0.0, 0.5]), rng.choice([0.1, 0.8, 1.0])
        memory.latency = lambda line, most=most: rng.randint(1, most)
        memory.error = lambda line, p=p_error: rng.random() < p
        memory.ready = lambda p=p_line: rng.random() < max(p, 0.1)
        slots.gap = lambda p=p_gap: rng.random() < p
        slots.ready = lambda p=p_ready: rng.random() < p
        tickets = slots.ask(pattern(rng.choice(PATTERNS), slots, rng, 150))
        await slots.decided(tickets)  # the next phase meets what is still in flight
    await slots.done(tickets)

    slots.finish()


@only(MODE == GATHER)
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
    assert sorted(t.done for t in tickets) == [filled + 2 + i for i in range(slots.num_slots)]


@only(MODE == GATHER and ROWS >= 2 and PLACES >= 2 and SLOTS >= 4)
async def hands_out_two_rows_without_a_gap(dut):
    _, memory, slots = await begin(dut)
    memory.hold()
    tickets = slots.ask([slots.any_addr(6 + i % 2) for i in range(slots.num_slots)])
    await slots.decided(tickets)
    await ClockCycles(dut.clk_i, 3)
    memory.release(7, after=1)
    memory.release(6, after=2)
    await slots.done(tickets)

    assert consecutive([t.done for t in tickets])


@cocotb.test()
async def answers_a_hit_after_two_cycles(dut):
    _, _, slots = await begin(dut)
    await slots.bring(3)
    for elem in range(slots.line_bytes // slots.elem_bytes):
        (ticket,) = slots.ask([slots.addr(3, elem)])
        await slots.done([ticket])
        assert ticket.kind == "hit" and ticket.done - ticket.taken == 2


@cocotb.test()
async def answers_hits_one_a_cycle(dut):
    _, _, slots = await begin(dut)
    await slots.bring(3)
    # A slot asks again three cycles after it asked, so three slots fill the unit.
    count = 100 if slots.num_slots >= 3 else slots.num_slots
    tickets = slots.ask([slots.any_addr(3) for _ in range(count)])
    await slots.done(tickets)

    assert {t.kind for t in tickets} == {"hit"}
    assert consecutive([t.taken for t in tickets])
    assert consecutive([t.done for t in tickets])


@only(MODE == GATHER and PLACES > 1)
async def answers_hits_while_a_line_is_on_its_way(dut):
    _, memory, slots = await begin(dut)
    await slots.bring(3)
    memory.hold()
    (late,) = slots.ask([slots.any_addr(4)])
    count = 60 if slots.num_slots >= 4 else 1
    early = slots.ask([slots.any_addr(3) for _ in range(count)])
    await slots.done(early)

    assert late.kind == "miss" and late.done is None
    assert {t.kind for t in early} == {"hit"} and consecutive([t.done for t in early])
    memory.release(4)
    await slots.done([late])


@only(MODE != BLOCKING)
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


@only(MODE == GATHER)
async def a_ray_may_join_a_row_up_to_the_cycle_in_which_it_fills(dut):
    _, memory, slots = await begin(dut)
    memory.hold()
    met = {}
    for wait in range(8):
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


@only(MODE == GATHER and min(PLACES, SLOTS) > ROWS)
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


@only(MODE == GATHER and WAYS < ROWS and WAYS + 1 < SLOTS)
async def stalls_while_all_ways_are_pinned_and_recovers(dut):
    _, memory, slots = await begin(dut)
    lines = [slots.line_of(0, number) for number in range(slots.ways + 1)]
    memory.hold()
    tickets = slots.ask([slots.any_addr(line) for line in [lines[0], *lines]])
    await slots.until(lambda: len(memory.held()) == slots.ways)
    await ClockCycles(dut.clk_i, 20)
    assert slots.waits() and tickets[-1].kind is None, "a line without a place"

    slots.ready = lambda: False
    memory.release(lines[0])
    await ClockCycles(dut.clk_i, 20)  # one of its two rays stands at the port, one in the row
    assert slots.waits() and tickets[-1].kind is None, "the place went before it was handed out"

    slots.ready = lambda: True
    for line in lines[1:]:
        await slots.until(lambda line=line: line in memory.held())
        memory.release(line)
    await slots.done(tickets)
    slots.finish()


@only(MODE == GATHER)
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


@only(WAYS > 1)
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


@only(MODE == GATHER)
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
    stream = slots.ask([slots.any_addr(rows + i // rays_a_line) for i in range(400)])
    await slots.done(first + stream)

    for ticket in first + stream:
        if ticket.row:
            waited = ticket.shown - ticket.row.answered
            assert waited <= 2 + 2 * slots.num_slots, f"{ticket.addr:#x}: {waited} cycles"


@only(MODE != RETRY)
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
    await ClockCycles(dut.clk_i, 2)
    dut.rst_ni.value = 1
    await RisingEdge(dut.clk_i)
    assert dut.rsp_valid_o.value == 0 and dut.line_req_valid_o.value == 0

    memory, slots, _ = play(dut, rng)
    again = slots.ask([slots.any_addr(line) for line in (1, 2, 3)])
    await slots.done(again)
    assert {t.kind for t in again} == {"miss"}
    slots.finish()


@only(MODE != RETRY)
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
    for _ in range(20):
        await slots.done(slots.ask(pattern(rng.choice(PATTERNS), slots, rng, 40)))
        await slots.flush()
    slots.finish()


@only(ROWS < ROW_IDS)
async def drops_answers_under_ids_that_no_row_has(dut):
    rng, memory, slots = await begin(dut)
    memory.latency = lambda line: rng.randrange(1, 12)
    unknown = range(slots.rows, 1 << payloads().width("row_id_t"))
    for name in PATTERNS:
        for _ in range(100):
            memory.stray(rng.choice(unknown))
        await slots.done(slots.ask(pattern(name, slots, rng, 200)))
    await slots.until(lambda: not memory.strays_left())
    slots.finish()


@only(MODE == GATHER)
async def drops_answers_to_rows_that_are_free(dut):
    rng, memory, slots = await begin(dut)
    await slots.bring(1, 2)
    for row in range(slots.rows):  # to an idle unit
        memory.stray(row)
    await ClockCycles(dut.clk_i, slots.rows + 4)
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
        await ClockCycles(dut.clk_i, slots.rows + 4)
        assert not memory.strays_left()
        assert sum(t.done is not None for t in tickets) == ticket
        memory.release(line)
        await slots.done([tickets[lines.index(line)]])
    slots.finish()


@only(MODE == GATHER)
async def drops_a_second_answer_to_a_row_that_hands_out(dut):
    _, memory, slots = await begin(dut)
    memory.hold()
    tickets = slots.ask([slots.any_addr(7) for _ in range(slots.num_slots)])
    await slots.decided(tickets)
    await slots.until(lambda: memory.held() == [7])
    row = memory.identity_of(7)
    slots.ready = lambda: False
    memory.release(7)
    await ClockCycles(dut.clk_i, 5)  # a ray stands at the port, the others in the row
    for _ in range(3):
        memory.stray(row)
    await ClockCycles(dut.clk_i, 10)
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

    await slots.done(slots.ask(pattern(name, slots, rng, 300)))

    slots.finish()


@only(MODE == BLOCKING)
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


@only(MODE == RETRY)
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
    assert max(t.done for t in tickets) - filled <= slots.num_slots + 4
    assert memory.asked == [7]
    slots.finish()


@only(MODE == RETRY and PLACES > 1)
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


@only(MODE == RETRY and min(PLACES, SLOTS - 1) > ROWS)
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


@pytest.mark.parametrize("shape", SHAPES)
def test_ti_ra(shape):
    names = ("NumSlots", "Rows", "Ways", "ElemBytes", "CacheBytes", "Mode")
    *values, overrides = SHAPES[shape]
    params = dict(zip(names, values, strict=True))
    run("ti_ra", "test_ti_ra", config=f"tiny {overrides}".strip(), params=params)
