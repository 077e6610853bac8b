# SPDX-License-Identifier: Apache-2.0
"""`ti_l2_bank` answers each unit once with its line, and asks memory once for a line."""

import cocotb
import pytest
from agents.bank_requesters import BankRequesters
from agents.bench import consecutive, only_if, run, start
from agents.events import Events
from agents.memory import LineMemory
from cocotb.triggers import ClockCycles, RisingEdge
from models.payload import configuration, parameter

NAMES = ("NumUnits", "UnitIds", "NumBanks", "CacheBytes", "Ways", "Rows", "Latency")
SHAPES = {
    "least": (1, 1, 1, 64, 1, 1, 3, ""),
    "tiny": (2, 2, 2, 1024, 2, 2, 4, ""),
    "odd": (3, 3, 4, 1024, 4, 3, 5, "trv_rows=5 addr_bits=40"),
    "paper": (24, 8, 4, 4096, 8, 16, 19, "trv_rows=16 trv_slots=16"),
    "compare": (3, 4, 2, 1024, 2, 4, 4, "trv_rows=4 lookup_stages=2"),
    "highest bank": (6, 8, 32, 512, 1, 8, 10, "list_rows=8 list_slots=8 line_bytes=32"),
}
UNITS, IDS, BANKS, _, WAYS, ROWS, LATENCY = (parameter(name, 1) for name in NAMES)
PLACES = parameter("CacheBytes", 64) // 64
SLOTS = UNITS * IDS


async def begin(dut):
    """Start the bank with a memory behind it and units in front of it."""
    rng = await start(dut)
    memory, slots, _ = play(dut, rng)
    slots.events = Events(dut, "l2")
    return rng, memory, slots


def play(dut, rng):
    memory = LineMemory(dut, configuration()["line_bytes"], rng)
    slots = BankRequesters(dut, memory, rng)
    return memory, slots, [cocotb.start_soon(memory.run()), cocotb.start_soon(slots.run())]


def ask(slots, lines):
    return slots.ask([slots.addr(line) for line in lines])


PATTERNS = ["one line", "every line", "one set", "near", "of all banks", "far"]


def pattern(name, slots, rng, count):
    """Lines of an access pattern."""
    kept = slots.sets * slots.ways
    top = (1 << configuration()["addr_bits"]) // slots.line_bytes // slots.banks - 1
    line = {
        "one line": lambda i: slots.of_bank(5),
        "every line": lambda i: slots.of_bank(i),
        "one set": lambda i: slots.line_of(slots.sets - 1, rng.randrange(slots.ways + 2)),
        "near": lambda i: slots.of_bank(rng.randrange(2 * kept)),
        "of all banks": lambda i: rng.randrange(2 * kept),
        "far": lambda i: slots.of_bank(rng.choice([0, 1, top - 1, top, rng.randrange(top)])),
    }[name]
    return [line(i) for i in range(count)]


@cocotb.test()
@cocotb.parametrize(name=PATTERNS)
@cocotb.parametrize(stalls=["none", "everywhere", "slow memory"])
async def gives_the_right_line_to_the_unit_and_id_that_asked(dut, name, stalls):
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
    before = slots.events.counts()

    count = min(250, 80 + SLOTS)
    await slots.done(ask(slots, pattern(name, slots, rng, count)))

    slots.finish()
    events = slots.events.since(before)
    assert events["accesses"] == events["hits"] + events["merged"] + events["misses"] == count
    assert events["misses"] == len(memory.asked)


@cocotb.test()
async def asks_once_for_a_line_that_all_units_want(dut):
    _, memory, slots = await begin(dut)
    memory.hold()
    line = slots.of_bank(7)
    tickets = ask(slots, [line] * slots.num_slots)
    await slots.decided(tickets)
    await ClockCycles(dut.clk_i, 5)
    assert memory.asked == [line]
    memory.release(line)
    await slots.done(tickets)

    assert [t.kind for t in tickets] == ["miss"] + ["merged"] * (slots.num_slots - 1)
    assert memory.asked == [line] and consecutive([t.done for t in tickets])


@cocotb.test()
async def answers_a_hit_after_exactly_its_latency(dut):
    _, _, slots = await begin(dut)
    line = slots.of_bank(3)
    await slots.bring(line)
    for wait in range(4):
        (ticket,) = ask(slots, [line])
        await slots.done([ticket])
        assert ticket.kind == "hit" and ticket.done - ticket.taken == LATENCY
        await ClockCycles(dut.clk_i, wait)


# With fewer the units wait for their answers.
@only_if(SLOTS > LATENCY)
async def answers_hits_one_a_cycle(dut):
    _, _, slots = await begin(dut)
    lines = [slots.of_bank(3), slots.of_bank(4)]
    await slots.bring(*lines)
    tickets = ask(slots, [lines[i % 2] for i in range(200)])
    await slots.done(tickets)

    assert {t.kind for t in tickets} == {"hit"}
    assert consecutive([t.taken for t in tickets]) and consecutive([t.done for t in tickets])
    assert {t.done - t.taken for t in tickets} == {LATENCY}


@only_if(SLOTS > LATENCY + 2)
async def keeps_its_pace_after_answers_have_waited(dut):
    """What is in the delay has room behind it, and no room is lost."""
    rng, _, slots = await begin(dut)
    line = slots.of_bank(3)
    await slots.bring(line)
    for _ in range(5):
        slots.ready = lambda: False
        waiting = ask(slots, [line] * (SLOTS + 5))
        await ClockCycles(dut.clk_i, 2 * LATENCY + 10)
        assert dut.req_ready_o.value == 0 and slots.in_flight() == LATENCY + 1
        slots.ready = lambda: rng.random() < 0.3
        await slots.done(waiting)
    slots.ready = lambda: True
    tickets = ask(slots, [line] * 100)
    await slots.done(tickets)

    assert consecutive([t.done for t in tickets])
    slots.finish()


@only_if(PLACES > 1 and SLOTS > LATENCY + 1)
async def answers_hits_while_a_line_is_on_its_way(dut):
    _, memory, slots = await begin(dut)
    await slots.bring(slots.of_bank(3))
    memory.hold()
    (late,) = ask(slots, [slots.of_bank(4)])
    early = ask(slots, [slots.of_bank(3)] * 60)
    await slots.done(early)

    # A bank with one row and one place has hits, but none beside a miss.
    assert late.kind == "miss" and late.done is None
    assert {t.kind for t in early} == {"hit"} and consecutive([t.done for t in early])
    memory.release(slots.of_bank(4))
    await slots.done([late])


@only_if(min(PLACES, SLOTS) > ROWS)
async def stalls_while_all_rows_are_taken_and_recovers(dut):
    _, memory, slots = await begin(dut)
    memory.hold()
    lines = [slots.of_bank(number) for number in range(slots.rows + 1)]
    tickets = ask(slots, lines)
    await slots.until(lambda: len(memory.held()) == slots.rows)
    await ClockCycles(dut.clk_i, 20)
    assert slots.waits() and tickets[-1].kind is None, "a row more than there are"
    assert len(memory.held()) == slots.rows

    memory.release(lines[0])
    await slots.decided(tickets)
    for line in lines[1:]:
        await slots.until(lambda line=line: line in memory.held())
        memory.release(line)
    await slots.done(tickets)
    slots.finish()


@cocotb.test()
async def an_error_reaches_those_who_waited_and_is_not_kept(dut):
    _, memory, slots = await begin(dut)
    bad, good = slots.of_bank(8), slots.of_bank(9)
    memory.error = lambda line: line == bad
    memory.hold()
    others = slots.sets * slots.ways > 1 and slots.rows > 1
    lines = [bad if i % 2 or not others else good for i in range(slots.num_slots)]
    first = ask(slots, lines)
    await slots.decided(first)
    await slots.until(lambda: len(memory.held()) == len(set(lines)))
    for line in set(lines):
        memory.release(line)
    await slots.done(first)
    assert [t.error for t in first] == [line == bad for line in lines]

    memory.error = lambda line: False
    memory.latency = lambda line: 3
    asked = len(memory.asked)
    again = ask(slots, [bad])
    await slots.done(again)
    assert again[0].kind == "miss" and not again[0].error and memory.asked[asked:] == [bad]
    then = ask(slots, [bad])
    await slots.done(then)
    assert then[0].kind == "hit"
    slots.finish()


@cocotb.test()
async def keeps_as_many_lines_of_its_number_as_it_has_places(dut):
    """The lines of one bank spread over all its sets."""
    rng, _, slots = await begin(dut)
    first = rng.randrange(1000)
    lines = [slots.of_bank(first + number) for number in range(slots.sets * slots.ways)]
    brought = ask(slots, lines)
    await slots.done(brought)
    again = ask(slots, lines)
    await slots.done(again)

    assert {t.kind for t in brought} == {"miss"} and {t.kind for t in again} == {"hit"}


@only_if(WAYS > 1)
async def a_line_used_lately_stays(dut):
    _, _, slots = await begin(dut)
    await slots.bring(*(slots.line_of(0, number) for number in range(slots.ways)))
    for extra in range(3 * slots.ways):
        used = ask(slots, [slots.line_of(0, 0)])
        await slots.done(used)
        assert used[0].kind == "hit", f"gone after {extra} other lines"
        await slots.bring(slots.line_of(0, slots.ways + extra))


@cocotb.test()
async def says_what_it_waits_for(dut):
    _, memory, slots = await begin(dut)
    memory.hold()
    line = slots.of_bank(1)
    before = slots.events.counts()
    await ClockCycles(dut.clk_i, 10)
    # Other cycles than ten: the watch began before.
    assert set(slots.events.activities(before)) == {"empty"}

    tickets = ask(slots, [line])
    await slots.until(lambda: memory.held() == [line])
    before = slots.events.counts()
    await ClockCycles(dut.clk_i, 10)
    assert slots.events.activities(before) == {"memory": 10}

    slots.ready = lambda: False
    memory.release(line)
    await slots.until(lambda: tickets[0].shown)
    before = slots.events.counts()
    await ClockCycles(dut.clk_i, 10)
    assert slots.events.activities(before) == {"room": 10}

    slots.ready = lambda: True
    await slots.done(tickets)
    await ClockCycles(dut.clk_i, 2)
    before = slots.events.counts()
    hit = ask(slots, [line])
    await slots.done(hit)
    await ClockCycles(dut.clk_i, 1)
    activities = slots.events.activities(before)
    # From the cycle after it is taken until it has been answered.
    assert activities["works"] == 1 and activities["latency"] == LATENCY - 1


@cocotb.test()
async def forgets_everything_on_reset(dut):
    rng = await start(dut)
    memory, slots, tasks = play(dut, rng)
    lines = [slots.of_bank(number) for number in (1, 2, 3)]
    await slots.bring(*lines[:2])
    memory.hold()
    slots.ready = lambda: False
    ask(slots, lines)
    await ClockCycles(dut.clk_i, 2 * LATENCY)  # lines on their way, requests in the delay
    for task in tasks:
        task.cancel()
    dut.rst_ni.value = 0
    dut.req_valid_i.value = dut.line_rsp_valid_i.value = 0
    await ClockCycles(dut.clk_i, 2)
    dut.rst_ni.value = 1
    await RisingEdge(dut.clk_i)
    assert dut.rsp_valid_o.value == 0 and dut.line_req_valid_o.value == 0

    memory, slots, _ = play(dut, rng)
    for row in range(slots.rows):  # what was on its way comes
        memory.stray(row)
    await ClockCycles(dut.clk_i, slots.rows + LATENCY)
    assert not memory.strays_left()
    again = ask(slots, lines)
    await slots.done(again)
    assert {t.kind for t in again} == {"miss"}
    slots.finish()


@cocotb.test()
async def drops_second_answers_in_traffic(dut):
    rng, memory, slots = await begin(dut)
    memory.latency = lambda line: rng.randrange(1, 6)
    memory.error = lambda line: rng.random() < 0.2
    memory.repeat = lambda: rng.random() < 0.5
    slots.ready = lambda: rng.random() < 0.7
    for name in PATTERNS:
        await slots.done(ask(slots, pattern(name, slots, rng, 150)))

    slots.finish()


@cocotb.test()
async def forgets_every_line_on_flush(dut):
    rng, memory, slots = await begin(dut)
    memory.latency = lambda line: rng.randrange(1, 12)
    slots.ready = lambda: rng.random() < 0.7
    lines = [slots.of_bank(number) for number in range(slots.sets * slots.ways)]
    for _ in range(3):
        tickets = ask(slots, lines)
        await slots.done(tickets)
        assert {t.kind for t in tickets} == {"miss"}
        again = ask(slots, lines[-1:])
        await slots.done(again)
        assert {t.kind for t in again} == {"hit"}
        await slots.flush()
    slots.finish()


@pytest.mark.parametrize("shape", SHAPES)
def test_ti_l2_bank(shape):
    *values, overrides = SHAPES[shape]
    params = dict(zip(NAMES, values, strict=True))
    run("ti_l2_bank", "test_ti_l2_bank", config=f"tiny {overrides}".strip(), params=params)
