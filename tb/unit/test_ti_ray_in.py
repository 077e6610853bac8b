# SPDX-License-Identifier: Apache-2.0
"""`ti_ray_in` numbers the rays of each packet, a ray a cycle, and keeps the next one out."""

import cocotb
from agents.bench import cycle, run, start
from agents.stream import Sink
from cocotb.triggers import ClockCycles, ReadOnly, RisingEdge
from models.payload import payloads

WORDS = 8


async def begin(dut):
    for name in ("tvalid", "tdata", "tlast"):
        getattr(dut, f"s_axis_{name}").value = 0
    rng = await start(dut)
    dut.run_i.value = 1
    await RisingEdge(dut.clk_i)
    return rng


def any_ray(rng):
    """(the beat, the ray): values in the low bits of words, anything above them."""
    width = payloads().width("fp_t")
    words = [rng.getrandbits(32) for _ in range(WORDS)]
    values = [word & (1 << width) - 1 for word in words]
    beat = sum(word << 32 * i for i, word in enumerate(words))
    o, tmin, d, tmax = tuple(values[:3]), values[3], tuple(values[4:7]), values[7]
    return beat, {"o": o, "tmin": tmin, "d": d, "tmax": tmax}


async def offer(dut, beats, lasts):
    """Put beats at the port, each until it is taken."""
    for beat, last in zip(beats, lasts, strict=True):
        dut.s_axis_tdata.value, dut.s_axis_tlast.value, dut.s_axis_tvalid.value = beat, last, 1
        while True:
            await ReadOnly()
            taken = dut.s_axis_tready.value == 1
            assert dut.take_o.value == int(taken)
            await RisingEdge(dut.clk_i)
            if taken:
                break
    dut.s_axis_tvalid.value = 0


async def hits(dut, count):
    """So many hits pass; whether each was the last of its packet."""
    lasts = []
    for _ in range(count):
        dut.hit_i.value = 1
        await ReadOnly()
        lasts.append(int(dut.last_o.value))
        await RisingEdge(dut.clk_i)
        dut.hit_i.value = 0
    return lasts


@cocotb.test()
@cocotb.parametrize(p_stall=[0.0, 0.6])
async def a_beat_becomes_the_ray_with_its_number(dut, p_stall):
    rng = await begin(dut)
    for count in (20, 1, 5):
        made = [any_ray(rng) for _ in range(count)]
        lasts = [0] * (count - 1) + [1]
        cocotb.start_soon(offer(dut, [beat for beat, _ in made], lasts))
        got = await Sink(dut, "ray").receive(count, lambda: rng.random() >= p_stall)
        want = [{"ray_id": i, "any_hit": 0, **ray} for i, (_, ray) in enumerate(made)]
        assert [payloads().unpack("ray_t", bits) for bits in got] == want
        assert await hits(dut, count) == lasts


@cocotb.test()
async def takes_a_ray_a_cycle(dut):
    rng = await begin(dut)
    beats = [any_ray(rng)[0] for _ in range(100)]
    cocotb.start_soon(Sink(dut, "ray").receive(100))
    before = cycle()
    await offer(dut, beats, [0] * 100)
    assert cycle() - before == 100


@cocotb.test()
async def nothing_is_taken_behind_a_packet_until_its_last_hit_has_passed(dut):
    rng = await begin(dut)
    for count in (1, 4):
        sink = cocotb.start_soon(Sink(dut, "ray").receive(count))
        beats = [any_ray(rng)[0] for _ in range(count)]
        await offer(dut, beats, [0] * (count - 1) + [1])
        await sink
        for number in range(count):
            await ReadOnly()
            assert dut.s_axis_tready.value == 0
            await RisingEdge(dut.clk_i)
            assert await hits(dut, 1) == [int(number == count - 1)]
        await ReadOnly()
        assert dut.s_axis_tready.value == 1, "and without a beat that is offered"
        await RisingEdge(dut.clk_i)


@cocotb.test()
async def the_last_hit_of_all_so_far_is_not_that_of_a_packet_which_goes_on(dut):
    rng = await begin(dut)
    cocotb.start_soon(Sink(dut, "ray").receive(4))
    await offer(dut, [any_ray(rng)[0] for _ in range(3)], [0] * 3)
    assert await hits(dut, 3) == [0, 0, 0]
    await offer(dut, [any_ray(rng)[0]], [1])
    assert await hits(dut, 1) == [1]


@cocotb.test()
async def run_at_zero_takes_nothing_and_gives_what_is_inside(dut):
    rng = await begin(dut)
    await offer(dut, [any_ray(rng)[0] for _ in range(2)], [0, 0])
    dut.run_i.value = 0
    await ReadOnly()
    assert dut.s_axis_tready.value == 0 and dut.empty_o.value == 0
    await RisingEdge(dut.clk_i)
    await Sink(dut, "ray").receive(2)
    await ClockCycles(dut.clk_i, 2)
    assert dut.empty_o.value == 1 and dut.s_axis_tready.value == 0


def test_ti_ray_in():
    run("ti_ray_in", "test_ti_ray_in", config="tiny exp_bits=7 frac_bits=16")
