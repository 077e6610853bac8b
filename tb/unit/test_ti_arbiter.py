# SPDX-License-Identifier: Apache-2.0
"""`ti_arbiter` merges its inputs without loss, in order of each, one a cycle, and starves none."""

import cocotb
from agents.bench import cycle, run, start
from agents.stream import Sink, Source, stalls
from cocotb.triggers import ClockCycles, ReadOnly, RisingEdge, Timer

# The arbiters of the top: first input, and number of inputs.
ARBITERS = {0: (0, 1), 1: (1, 2), 2: (3, 5)}


def beats_of(source, count):
    """Beats that name their input and their number."""
    return [source << 12 | i for i in range(count)]


def ends(dut, arbiter):
    first, num = ARBITERS[arbiter]
    return [Source(dut, "in", first + i) for i in range(num)], Sink(dut, "out", arbiter)


async def watch_passes(dut, arbiter, passes):
    """Note how many others each beat of an input saw served before it, from when it was offered.

    An input has lost where it is valid and another is served.
    """
    first, num = ARBITERS[arbiter]
    waited = [0] * num
    while True:
        await ReadOnly()
        valid = [dut.in_valid_i[first + i].value == 1 for i in range(num)]
        served = [valid[i] and dut.in_ready_o[first + i].value == 1 for i in range(num)]
        assert sum(served) <= 1
        lost = [dut.in_lost_o[first + i].value == 1 for i in range(num)]
        assert lost == [valid[i] and any(served) and not served[i] for i in range(num)]
        for i in range(num):
            if served[i]:
                passes.append(waited[i])
                waited[i] = 0
            elif valid[i]:
                waited[i] += any(served)
        await RisingEdge(dut.clk_i)


@cocotb.test()
@cocotb.parametrize(arbiter=list(ARBITERS), p_gap=[0.0, 0.5, 0.9], p_stall=[0.0, 0.6])
async def keeps_the_order_of_each_input_and_starves_none(dut, arbiter, p_gap, p_stall):
    rng = await start(dut)
    sources, sink = ends(dut, arbiter)
    sent = [beats_of(i, 100) for i in range(len(sources))]
    passes = []

    cocotb.start_soon(watch_passes(dut, arbiter, passes))
    for source, beats in zip(sources, sent, strict=True):
        cocotb.start_soon(source.send(beats, gap=stalls(rng, p_gap)))
    count = sum(map(len, sent))
    got = await sink.receive(count, ready=lambda: rng.random() >= p_stall, patience=500)

    for i, beats in enumerate(sent):
        assert [beat for beat in got if beat >> 12 == i] == beats
    await sink.expect_none(4)
    assert max(passes) < len(sources), "an input was passed by more than one of each other"


@cocotb.test()
@cocotb.parametrize(arbiter=list(ARBITERS), p_stall=[0.0, 0.6])
async def serves_every_input_once_a_round_under_full_load(dut, arbiter, p_stall):
    rng = await start(dut)
    sources, sink = ends(dut, arbiter)
    rounds, num = 40, len(sources)

    for i, source in enumerate(sources):
        cocotb.start_soon(source.send(beats_of(i, rounds)))
    got = await sink.receive(rounds * num, ready=lambda: rng.random() >= p_stall)

    for at in range((rounds - 1) * num):
        assert sorted(beat >> 12 for beat in got[at : at + num]) == list(range(num)), f"from {at}"


@cocotb.test()
@cocotb.parametrize(arbiter=list(ARBITERS), busy=["all", "last"])
async def moves_one_beat_a_cycle(dut, arbiter, busy):
    await start(dut)
    sources, sink = ends(dut, arbiter)
    before = cycle()

    for i, source in enumerate(sources):
        if busy == "all" or i == len(sources) - 1:
            cocotb.start_soon(source.send(beats_of(i, 64)))
    await sink.receive(64)

    assert cycle() - before == 1 + 64


@cocotb.test()
@cocotb.parametrize(arbiter=list(ARBITERS))
async def takes_two_beats_while_the_output_sleeps(dut, arbiter):
    await start(dut)
    sources, sink = ends(dut, arbiter)
    for i, source in enumerate(sources):
        cocotb.start_soon(source.send(beats_of(i, 4)))
    first, num = ARBITERS[arbiter]
    taken = 0
    for _ in range(10):
        await ReadOnly()
        taken += sum(dut.in_ready_o[first + i].value == 1 for i in range(num))
        await RisingEdge(dut.clk_i)
    await ReadOnly()

    assert taken == 2
    assert all(dut.in_lost_o[first + i].value == 0 for i in range(num)), "none is served"
    await RisingEdge(dut.clk_i)
    assert len(await sink.receive(4 * num)) == 4 * num


@cocotb.test()
@cocotb.parametrize(arbiter=list(ARBITERS), held=[0, 1, 2])
async def the_grant_does_not_see_the_ready_of_its_cycle(dut, arbiter, held):
    """With 0, 1 and 2 beats inside."""
    await start(dut)
    first, num = ARBITERS[arbiter]
    last = first + num - 1
    dut.in_valid_i[last].value = 1
    await ClockCycles(dut.clk_i, held)
    grants = []
    for ready in (0, 1, 0, 1):
        dut.out_ready_i[arbiter].value = ready
        await Timer(1, "ns")
        grants.append(int(dut.in_ready_o[last].value))

    assert grants == [int(held < 2)] * 4


def test_ti_arbiter():
    run("ti_switch_top", "test_ti_arbiter")
