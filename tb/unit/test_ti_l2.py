# SPDX-License-Identifier: Apache-2.0
"""`ti_l2` answers every unit, a line a cycle from each bank, and asks memory once for a line."""

import cocotb
import pytest
from agents.bench import only_if, run
from agents.l2_bench import BANKS, IDS, LATENCY, NAMES, ROWS, UNITS, begin
from agents.line_ports import LinePorts
from cocotb.triggers import ClockCycles, ReadOnly, RisingEdge

SHAPES = {
    "least": (1, 2, 1, 512, 2, 2, 4, ""),
    "odd": (3, 5, 2, 2048, 4, 3, 4, "trv_rows=5"),
    "paper": (24, 8, 4, 16384, 8, 16, 20, "trv_rows=16 trv_slots=16"),
}
PATTERNS = ["one line", "near", "far", "one bank"]


def lines(name, bench, rng):
    """The next line of a unit."""
    return {
        "one line": lambda unit: 5,
        "near": lambda unit: rng.randrange(2 * bench.places),
        "far": lambda unit: rng.choice([0, bench.units.lines - 1, rng.randrange(1 << 15)]),
        "one bank": lambda unit: BANKS * rng.randrange(bench.places) + BANKS - 1,
    }[name]


@cocotb.test()
@cocotb.parametrize(name=PATTERNS)
@cocotb.parametrize(stalls=["none", "everywhere", "slow memory"])
async def answers_every_request_once_at_its_unit_and_id(dut, name, stalls):
    rng, bench = await begin(dut)
    bench.latency = lambda line: rng.randrange(1, 4)
    if stalls == "everywhere":
        bench.error, bench.units.bad = lambda line: rng.random() < 0.2, lambda line: None
        bench.latency = lambda line: rng.randrange(1, 12)
        for memory in bench.banks:
            memory.ready = lambda: rng.random() < 0.4
        bench.units.gap = lambda: rng.random() < 0.5
        bench.units.ready = lambda unit: rng.random() < 0.4
    if stalls == "slow memory":
        bench.latency = lambda line: rng.choice([3, 60])
    count = max(20, 150 // UNITS)

    await bench.ask(count, line=lines(name, bench, rng))

    assert bench.units.answered == [count] * UNITS
    bench.finish()


@cocotb.test()
@cocotb.parametrize(all_units=[False, True])
async def a_line_that_many_want_is_asked_for_once_and_serves_all(dut, all_units):
    """Several units, and one unit under several ids."""
    _, bench = await begin(dut)
    bench.hold()
    units = range(UNITS) if all_units else [UNITS - 1]
    playing = bench.start(IDS, units, lambda unit: 9)
    await ClockCycles(dut.clk_i, UNITS * IDS + LATENCY + 10)
    assert bench.asked() == [9] and bench.units.in_flight() == len(units) * IDS
    bench.release(9)
    await playing

    assert bench.asked() == [9]
    assert bench.counts()[9 % BANKS]["merged"] == len(units) * IDS - 1
    bench.finish()


@cocotb.test()
async def hits_pass_misses(dut):
    _, bench = await begin(dut)
    await bench.bring([BANKS])
    bench.hold()
    late = bench.start(1, [0], lambda unit: 0)
    await ClockCycles(dut.clk_i, LATENCY + 20)
    late.cancel()
    assert bench.held() == [0]
    before = len(bench.units.requests)
    bench.units.left = [5 * (u == UNITS - 1) for u in range(UNITS)]
    bench.units.line = lambda unit: BANKS
    playing = cocotb.start_soon(bench.units.play())
    await ClockCycles(dut.clk_i, 5 * (LATENCY + 3))
    hits = bench.units.requests[before:]
    assert len(hits) == 5 and all(hit.answered for hit in hits)
    assert {hit.answered - hit.taken for hit in hits} <= set(range(LATENCY, LATENCY + 2))
    bench.release(0)
    await playing
    bench.finish()


@cocotb.test()
async def errors_reach_those_who_waited_and_are_not_kept(dut):
    _, bench = await begin(dut)
    bad = set(range(0, 2 * BANKS, 2))
    bench.error = bench.units.bad = lambda line: line in bad
    bench.latency = lambda line: 40
    requests = await bench.ask(2 * IDS, line=lambda unit: (unit + len(bench.units.requests)) % 8)
    assert bench.units.errors == sum(request.line in bad for request in requests) > 0

    asked = len(bench.asked())
    bench.error = bench.units.bad = lambda line: False
    await bench.bring(sorted(bad))
    assert len(bench.asked()) == asked + len(bad), "an error was kept"
    await bench.bring(sorted(bad))
    assert len(bench.asked()) == asked + len(bad), "a good line was not"
    bench.finish()


@cocotb.test()
async def a_hit_takes_exactly_its_latency(dut):
    rng, bench = await begin(dut)
    await bench.bring(range(2 * BANKS))
    for unit in range(UNITS):
        (request,) = await bench.ask(1, [unit], lambda unit: rng.randrange(2 * BANKS))
        assert request.answered - request.taken == LATENCY


def in_the_middle(requests, cycles):
    """Those answered in the `cycles` cycles from the time on when all banks are at work."""
    first = min(request.answered for request in requests) + 2 * LATENCY
    return [request for request in requests if first <= request.answered < first + cycles]


@only_if(UNITS * IDS >= 2 * LATENCY)
async def one_bank_answers_one_hit_a_cycle(dut):
    _, bench = await begin(dut)
    mine = [BANKS * number for number in range(4)]
    await bench.bring(mine)
    requests = await bench.ask(20 + 200 // UNITS, line=lambda unit: mine[unit % 4])

    assert len(in_the_middle(requests, 100)) == 100


@only_if(UNITS * IDS >= 2 * BANKS * LATENCY)
async def every_bank_answers_one_hit_a_cycle(dut):
    _, bench = await begin(dut)
    await bench.bring(range(BANKS))
    requests = await bench.ask(60, line=lambda unit: unit % BANKS)

    assert len(in_the_middle(requests, 200)) == 200 * BANKS


@cocotb.test()
async def holds_as_many_consecutive_lines_as_it_has_places(dut):
    rng, bench = await begin(dut)
    first = rng.randrange(10_000)
    every = range(first, first + bench.places)
    await bench.bring(every)
    await bench.bring(every)
    assert sorted(bench.asked()) == list(every)

    await bench.bring(range(first + bench.places, first + bench.places + BANKS))
    asked = len(bench.asked())
    await bench.bring(every)
    assert len(bench.asked()) > asked, "a line more than there are places"
    bench.finish()


@only_if(UNITS * IDS > ROWS)
async def waits_while_all_rows_are_taken_and_recovers(dut):
    """And the other banks go on."""
    _, bench = await begin(dut)
    await bench.bring(range(1, BANKS))
    bench.hold()
    wanted = iter(range(0, 1000 * BANKS, BANKS))
    playing = bench.start(1 if UNITS > ROWS else IDS, None, lambda unit: next(wanted))
    await ClockCycles(dut.clk_i, LATENCY + 100)
    assert len(bench.held()) == ROWS

    playing.cancel()
    if BANKS > 1:
        before = len(bench.units.requests)
        free = [unit for unit in range(UNITS) if bench.units.may_ask(unit)]
        task = bench.start(1, free[:1], lambda unit: 1)
        await ClockCycles(dut.clk_i, LATENCY + 10)
        task.cancel()
        hits = [request for request in bench.units.requests[before:] if request.line == 1]
        assert [hit.answered is not None for hit in hits] == [True] * min(len(free), 1)
    playing = cocotb.start_soon(bench.units.play())
    while not playing.done():
        for line in bench.held():
            bench.release(line)
        await RisingEdge(dut.clk_i)
    bench.finish()


@cocotb.test()
async def a_unit_that_sleeps_holds_up_no_bank_that_it_does_not_wait_for(dut):
    rng, bench = await begin(dut)
    await bench.bring(range(2 * BANKS))
    bench.units.ready = lambda unit: unit != 0
    playing = bench.start(1, [0], lambda unit: 0)
    await ClockCycles(dut.clk_i, LATENCY + 20)
    await ReadOnly()
    assert int(dut.line_rsp_valid_o.value) == 1, "its answer waits"
    await RisingEdge(dut.clk_i)
    if BANKS > 1 and UNITS > 1:
        playing.cancel()
        before = len(bench.units.requests)
        playing = bench.start(10, range(1, UNITS), lambda unit: rng.randrange(1, BANKS))
        await ClockCycles(dut.clk_i, 10 * (UNITS + LATENCY + 3))
        others = bench.units.requests[before:]
        assert len(others) == 10 * (UNITS - 1) and all(one.answered for one in others)
    bench.units.ready = lambda unit: True
    await playing
    bench.finish()


@only_if(BANKS > 1 and IDS >= BANKS)
async def a_unit_takes_the_banks_in_turn(dut):
    """An answer waits at most once for each other bank."""
    _, bench = await begin(dut)
    await bench.bring(range(BANKS))
    wanted = [0]

    def line(unit):
        wanted[0] += 1
        return wanted[0] % BANKS

    requests = await bench.ask(100, [0], line)
    assert max(request.answered - request.shown for request in requests) == 0
    assert max(request.shown - request.taken for request in requests) <= LATENCY + BANKS

    # All banks have answers for one unit that did not take any.
    for sleeps in (5, 6, 7):
        bench.units.ready = lambda unit: False
        before = len(bench.units.requests)
        playing = bench.start(BANKS, [UNITS - 1], line)
        await ClockCycles(dut.clk_i, LATENCY + BANKS + sleeps)
        bench.units.ready = lambda unit: True
        await playing
        times = sorted(request.answered for request in bench.units.requests[before:])
        assert times == list(range(times[0], times[0] + BANKS))
    bench.finish()


@cocotb.test()
@cocotb.parametrize(p_stall=[0.0, 0.5])
async def starves_no_unit(dut, p_stall):
    """All want hits of one bank: each is served once in as many turns as there are units."""
    rng, bench = await begin(dut)
    await bench.bring([0])
    bench.units.ready = lambda unit: rng.random() >= p_stall
    bench.units.passed.clear()
    await bench.ask(40, line=lambda unit: 0)

    assert max(bench.units.passed) < UNITS
    bench.finish()


@only_if(BANKS > 1 and IDS >= 2 * BANKS)
async def no_bank_is_starved_by_another(dut):
    """A unit that sleeps while each bank has two answers for it takes one of each first."""
    rng, bench = await begin(dut)
    await bench.bring(range(BANKS))
    for _ in range(5):
        wanted = iter(rng.sample([*range(BANKS)] * 2, 2 * BANKS))
        bench.units.ready = lambda unit: False
        before = len(bench.units.requests)
        playing = bench.start(2 * BANKS, [0], lambda unit, wanted=wanted: next(wanted))
        await ClockCycles(dut.clk_i, LATENCY + 4 * BANKS)
        bench.units.ready = lambda unit: True
        await playing
        requests = sorted(bench.units.requests[before:], key=lambda one: one.answered)
        for half in (requests[:BANKS], requests[BANKS:]):
            assert sorted(one.line for one in half) == list(range(BANKS))
    bench.finish()


@cocotb.test()
async def forgets_every_line_on_flush(dut):
    rng, bench = await begin(dut)
    bench.latency = lambda line: rng.randrange(1, 12)
    every = list(range(bench.places))
    for again in range(1, 4):
        await bench.bring(every)
        await bench.bring(every[-1:])
        assert sorted(bench.asked()) == sorted(every * again)
        dut.flush_i.value = 1
        await RisingEdge(dut.clk_i)
        dut.flush_i.value = 0
    bench.finish()


@cocotb.test()
async def drops_what_was_on_its_way_at_a_reset(dut):
    rng, bench = await begin(dut)
    bench.hold()
    playing = bench.start(IDS, None, lambda unit: rng.randrange(bench.places))
    await ClockCycles(dut.clk_i, LATENCY + 20)
    playing.cancel()
    held = bench.held()
    assert held
    dut.line_req_valid_i.value = 0
    dut.rst_ni.value = 0
    await ClockCycles(dut.clk_i, 2)
    dut.rst_ni.value = 1
    dut.line_rsp_ready_i.value = (1 << UNITS) - 1
    for line in held:
        bench.release(line)
    for _ in range(ROWS + LATENCY + 10):
        await ReadOnly()
        assert dut.idle_o.value == 1 and dut.line_rsp_valid_o.value == 0
        await RisingEdge(dut.clk_i)
    assert not any(memory.on_their_way() for memory in bench.banks)

    units = LinePorts(dut, rng, ids=IDS)
    units.line = lambda unit: rng.randrange(bench.places)
    units.left = [30] * UNITS
    bench.latency = lambda line: 3
    await units.play()
    assert units.answered == [30] * UNITS


@pytest.mark.parametrize("shape", SHAPES)
def test_ti_l2(shape):
    *values, overrides = SHAPES[shape]
    params = dict(zip(NAMES, values, strict=True))
    run("ti_l2", "test_ti_l2", config=f"tiny {overrides}".strip(), params=params)
