# SPDX-License-Identifier: Apache-2.0
"""`ti_xbar` brings each beat once to the output it names, in order, one a cycle; none starves."""

import cocotb
from agents.bench import cycle, run, start
from agents.stream import Sink, Source, stalls
from cocotb.triggers import ClockCycles, Combine, ReadOnly, RisingEdge

# The crossbars of the top: first input, inputs, first output, outputs.
XBARS = {0: (0, 4, 0, 4), 1: (4, 3, 4, 5), 2: (7, 5, 9, 2), 3: (12, 1, 11, 1)}


def beat_of(dest, source, number):
    return dest << 13 | source << 10 | number


def source_of(beat):
    return beat >> 10 & 7


def ends(dut, xbar):
    first_in, num_in, first_out, num_out = XBARS[xbar]
    return (
        [Source(dut, "xbar_in", first_in + i) for i in range(num_in)],
        [Sink(dut, "xbar_out", first_out + o) for o in range(num_out)],
    )


async def receive_all(sinks, counts, ready=lambda: 1):
    """Take `counts[o]` beats from output o, all at the same time."""
    tasks = [
        cocotb.start_soon(sink.receive(count, ready, patience=500))
        for sink, count in zip(sinks, counts, strict=True)
    ]
    await Combine(*tasks)
    return [task.result() for task in tasks]


async def watch_passes(dut, xbar, passes):
    """Note how many others each beat saw served at its output, from when it was offered.

    An input has lost where it is valid and another is served at its output.
    """
    first, num, _, _ = XBARS[xbar]
    waited = [0] * num
    while True:
        await ReadOnly()
        dest = [
            int(dut.xbar_in_data_i[first + i].value) >> 13
            if dut.xbar_in_valid_i[first + i].value == 1
            else None
            for i in range(num)
        ]
        served = [dut.xbar_in_ready_o[first + i].value == 1 for i in range(num)]
        for i in range(num):
            assert dest[i] is not None or not served[i], "a grant without a request"
            others = sum(served[j] and dest[j] == dest[i] for j in range(num) if j != i)
            assert others + served[i] <= 1 or dest[i] is None, "two served at one output"
            lost = dest[i] is not None and others > 0
            assert dut.xbar_in_lost_o[first + i].value == lost
            if served[i]:
                passes.append(waited[i])
                waited[i] = 0
            elif dest[i] is not None:
                waited[i] += others
        await RisingEdge(dut.clk_i)


@cocotb.test()
@cocotb.parametrize(xbar=list(XBARS), p_gap=[0.0, 0.7], p_stall=[0.0, 0.7])
async def brings_every_beat_once_where_it_should_go_and_starves_none(dut, xbar, p_gap, p_stall):
    rng = await start(dut)
    sources, sinks = ends(dut, xbar)
    sent = [
        [beat_of(rng.randrange(len(sinks)), i, number) for number in range(200)]
        for i in range(len(sources))
    ]
    want = [
        [[beat for beat in beats if beat >> 13 == o] for beats in sent] for o in range(len(sinks))
    ]

    passes = []
    cocotb.start_soon(watch_passes(dut, xbar, passes))
    for source, beats in zip(sources, sent, strict=True):
        cocotb.start_soon(source.send(beats, gap=stalls(rng, p_gap)))
    counts = [sum(map(len, parts)) for parts in want]
    got = await receive_all(sinks, counts, lambda: rng.random() >= p_stall)

    for o, beats in enumerate(got):
        for i in range(len(sources)):
            assert [beat for beat in beats if source_of(beat) == i] == want[o][i]
    await Combine(*(cocotb.start_soon(sink.expect_none(4)) for sink in sinks))
    assert max(passes) < len(sources), "an input was passed by more than one of each other"


@cocotb.test()
@cocotb.parametrize(xbar=list(XBARS), shift=range(3))
async def moves_a_beat_a_cycle_an_output_for_a_permutation(dut, xbar, shift):
    await start(dut)
    sources, sinks = ends(dut, xbar)
    counts = [0] * len(sinks)
    for i, source in enumerate(sources[: len(sinks)]):
        dest = (i + shift) % len(sinks)
        counts[dest] = 64
        cocotb.start_soon(source.send([beat_of(dest, i, number) for number in range(64)]))
    before = cycle()

    got = await receive_all(sinks, counts)

    assert cycle() - before == 1 + 64
    assert [len(beats) for beats in got] == counts


@cocotb.test()
@cocotb.parametrize(xbar=list(XBARS), p_stall=[0.0, 0.6])
async def serves_every_input_once_a_round_when_all_want_one_output(dut, xbar, p_stall):
    rng = await start(dut)
    sources, sinks = ends(dut, xbar)
    rounds, num, dest = 40, len(sources), len(sinks) - 1

    for i, source in enumerate(sources):
        cocotb.start_soon(source.send([beat_of(dest, i, number) for number in range(rounds)]))
    got = await sinks[dest].receive(rounds * num, ready=lambda: rng.random() >= p_stall)

    for at in range((rounds - 1) * num):
        assert sorted(map(source_of, got[at : at + num])) == list(range(num)), f"from {at}"


@cocotb.test()
@cocotb.parametrize(xbar=[x for x, (_, ins, _, outs) in XBARS.items() if ins > 1 and outs > 1])
async def a_stalled_output_stops_no_other(dut, xbar):
    await start(dut)
    sources, sinks = ends(dut, xbar)
    blocked = cocotb.start_soon(sources[0].send([beat_of(0, 0, number) for number in range(8)]))
    await ClockCycles(dut.clk_i, 4)

    cocotb.start_soon(sources[1].send([beat_of(1, 1, number) for number in range(64)]))
    before = cycle()
    await sinks[1].receive(64)

    assert cycle() - before == 1 + 64
    await ReadOnly()
    assert not blocked.done() and sinks[0].valid.value == 1


def test_ti_xbar():
    run("ti_switch_top", "test_ti_xbar")
