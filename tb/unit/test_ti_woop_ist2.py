# SPDX-License-Identifier: Apache-2.0
"""`ti_woop_ist2` turns each candidate into one return token with the model's t, u, v, in order."""

import cocotb
import pytest
from accuracy_costs import latencies
from agents.bench import cycle, run, start
from agents.events import Events
from agents.stream import Sink, Source, stalls
from cocotb.triggers import ClockCycles, ReadOnly, RisingEdge
from models.numbers import hexed, numbers
from models.payload import configuration, payloads

FORMATS = ["", "exp_bits=5 frac_bits=10", "exp_bits=5 frac_bits=10 rounding=zero subnormals=flush"]


def candidates(rng, count):
    """Weights of one sign, all 0 among them: ordinary, of small triangles, and any bits."""
    n = numbers()
    for i in range(count):
        sign = rng.choice((1, -1))
        weight = tuple(n.of(sign * rng.choice((0, rng.uniform(0, 1)))) for _ in range(3))
        z, sz = n.vec(rng.uniform(-3, 9) for _ in range(3)), n.of(rng.uniform(-2, 2))
        if i % 3 == 1:
            small = 2.0 ** -rng.randrange(n.bias - 3, n.bias + n.frac_bits)
            weight = tuple(
                n.of(sign * small * rng.choice((0, rng.uniform(0, 1), rng.uniform(0, 2**-9))))
                for _ in range(3)
            )
        elif i % 3 == 2:
            weight, z, sz = n.any_vec(rng), n.any_vec(rng), n.any(rng)
        yield {
            "home": {"trv": rng.getrandbits(1), "slot": rng.getrandbits(3)},
            "miss": int(rng.random() < 0.1),
            "prim": rng.getrandbits(32),
            "edges": {"weight": weight, "z": z, "sz": sz},
        }


def expected(candidate):
    """The token; of a miss only what a home reads of it."""
    hit = numbers().model("woop_pass_c", *candidate["edges"].values())
    hit = None if candidate["miss"] else hit
    token = {"home": candidate["home"], "count": 1, "error": 0, "hit": int(hit is not None)}
    if hit:
        token.update(zip("tuv", hit, strict=True), prim=candidate["prim"])
    return token


def read(bits):
    token = payloads().unpack("return_t", bits)
    if not token["hit"]:
        for field in ("prim", "t", "u", "v"):
            del token[field]
    return token


def packed(todo):
    return [payloads().pack("woop_candidate_t", candidate) for candidate in todo]


async def setup(dut):
    rng = await start(dut)
    return rng, Events(dut, "ist2")


@cocotb.test()
@cocotb.parametrize(p_valid=[1.0, 0.3], p_ready=[1.0, 0.3])
async def gives_the_model_s_values_in_order(dut, p_valid, p_ready):
    rng, events = await setup(dut)
    source, sink = Source(dut, "candidate"), Sink(dut, "return")
    todo = list(candidates(rng, 600))

    cocotb.start_soon(source.send(packed(todo), stalls(rng, 1 - p_valid)))
    got = await sink.receive(len(todo), ready=lambda: rng.random() < p_ready)

    for candidate, bits in zip(todo, got, strict=True):
        want = expected(candidate)
        assert read(bits) == want, (
            f"{hexed(candidate)}: want {hexed(want)}, got {hexed(read(bits))}"
        )
    assert 100 < sum(read(bits)["hit"] for bits in got) < len(got) - 100
    await sink.expect_none(2 * int(dut.Latency.value))
    assert events.counts()["c_passes"] == len(todo)


@cocotb.test()
async def takes_and_gives_one_a_cycle_after_its_latency(dut):
    rng, _ = await setup(dut)
    beats = packed(candidates(rng, 200))
    took, came = [], []

    async def watch():
        while True:
            await ReadOnly()
            if dut.candidate_valid_i.value == 1 and dut.candidate_ready_o.value == 1:
                took.append(cycle())
            if dut.return_valid_o.value == 1 and dut.return_ready_i.value == 1:
                came.append(cycle())
            await RisingEdge(dut.clk_i)

    cocotb.start_soon(watch())
    cocotb.start_soon(Source(dut, "candidate").send(beats))
    await Sink(dut, "return").receive(len(beats))
    await ClockCycles(dut.clk_i, 2)

    assert took == list(range(took[0], took[0] + len(beats)))
    assert came == [at + int(dut.Latency.value) for at in took]
    stated = latencies(configuration())  # in a sweep of accuracy
    assert stated["hit"] - stated["test"] == int(dut.Latency.value)


@cocotb.test()
async def takes_no_more_than_it_has_room_for(dut):
    rng, _ = await setup(dut)
    source = Source(dut, "candidate")
    cocotb.start_soon(source.send(packed(candidates(rng, 100))))
    dut.return_ready_i.value = 0
    await ClockCycles(dut.clk_i, 80)
    assert dut.candidate_ready_o.value == 0 and dut.idle_o.value == 0
    assert len(await Sink(dut, "return").receive(100)) == 100
    await ClockCycles(dut.clk_i, 3)
    assert dut.idle_o.value == 1


@pytest.mark.parametrize("overrides", FORMATS)
def test_ti_woop_ist2(overrides):
    run("ti_woop_ist2", "test_ti_woop_ist2", config=f"tiny triangle_test=woop {overrides}")
