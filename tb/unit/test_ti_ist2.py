# SPDX-License-Identifier: Apache-2.0
"""`ti_ist2` turns each candidate into one return token with the model's t, u, v, in order."""

import cocotb
import pytest
from accuracy_costs import latencies
from agents.bench import cycle, run, start
from agents.events import Events
from agents.stream import Sink, Source, stalls
from cocotb.triggers import ClockCycles, ReadOnly, RisingEdge
from models.ist1_cases import finite_not_zero, pass_b_cases
from models.numbers import hexed, numbers
from models.payload import configuration, payloads

FORMATS = ["", "exp_bits=7 frac_bits=16", "exp_bits=5 frac_bits=10"]


def candidates(rng, count):
    """Ends of the range, products that overflow or vanish, then tests that pass (b) has kept."""
    n = numbers()
    least, most, one = 1, n.inf - 1, n.one
    values = [v | s for v in (0, least, 1 << n.frac_bits, one, most) for s in (0, n.sign)]
    after_b = [(d, t, t, d) for d in values if d & (n.sign - 1) for t in values]
    for case in pass_b_cases(rng, count):
        plane = (0, 0, 0, 0, 0, case["axis"], 0, 0)
        kept = n.model("pass_b", plane, case["bary"], case["d"], case["after_a"])
        if kept is not None and kept[1] & (n.sign - 1) < n.inf:
            after_b.append(kept)
    for _ in range(count):
        after_b.append(tuple(finite_not_zero(rng) for _ in range(4)))
    for det, dett, detu, detv in after_b:
        yield {
            "home": {"trv": rng.getrandbits(1), "slot": rng.getrandbits(3)},
            "miss": int(rng.random() < 0.1),
            "prim": rng.getrandbits(32),
            "det": det,
            "dett": dett,
            "detu": detu,
            "detv": detv,
        }


def expected(candidate):
    """The token; of a miss only what a home reads of it."""
    hit = numbers().model("pass_c", tuple(candidate[k] for k in ("det", "dett", "detu", "detv")))
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


def packed(candidates):
    return [payloads().pack("candidate_t", c) for c in candidates]


async def setup(dut):
    rng = await start(dut)
    return rng, Events(dut, "ist2")


@cocotb.test()
@cocotb.parametrize(p_valid=[1.0, 0.3], p_ready=[1.0, 0.3])
async def gives_the_model_s_values_in_order(dut, p_valid, p_ready):
    rng, events = await setup(dut)
    source, sink = Source(dut, "candidate"), Sink(dut, "return")
    todo = list(candidates(rng, 500))

    cocotb.start_soon(source.send(packed(todo), stalls(rng, 1 - p_valid)))
    got = await sink.receive(len(todo), ready=lambda: rng.random() < p_ready)

    for candidate, bits in zip(todo, got, strict=True):
        want = expected(candidate)
        assert read(bits) == want, (
            f"{hexed(candidate)}: want {hexed(want)}, got {hexed(read(bits))}"
        )
    await sink.expect_none(2 * int(dut.Latency.value))
    assert events.counts()["c_passes"] == len(todo)


@cocotb.test()
async def a_t_that_is_not_finite_is_a_miss(dut):
    rng, events = await setup(dut)
    n = numbers()
    source, sink = Source(dut, "candidate"), Sink(dut, "return")
    most, least = n.inf - 1, 1
    overflows = [(n.of(0.5), most), (least, n.one), (least | n.sign, n.one), (n.sign | least, most)]
    finite = [(n.one, most), (n.of(2.0), most), (n.one, 0), (most, most)]
    dets = [(det, dett, hit) for pairs, hit in ((overflows, 0), (finite, 1)) for det, dett in pairs]
    todo = [{"det": det, "dett": dett, "prim": rng.getrandbits(32)} for det, dett, _ in dets]

    cocotb.start_soon(source.send(packed(todo)))
    got = await sink.receive(len(todo))

    assert [payloads().unpack("return_t", bits)["hit"] for bits in got] == [h for _, _, h in dets]
    assert events.counts()["c_passes"] == len(todo)


@cocotb.test()
async def takes_latency_cycles_and_gives_one_a_cycle(dut):
    rng, events = await setup(dut)
    todo = packed(candidates(rng, 100))[-100:]
    dut.return_ready_i.value = 1
    sent, came = [], []
    for _ in range(100 + int(dut.Latency.value) + 8):
        dut.candidate_valid_i.value = int(bool(todo))
        dut.candidate_data_i.value = todo[-1] if todo else 0
        await ReadOnly()
        if todo and dut.candidate_ready_o.value == 1:
            sent.append(cycle())
            todo.pop()
        if dut.return_valid_o.value == 1:
            came.append(cycle())
        await RisingEdge(dut.clk_i)

    assert sent == list(range(sent[0], sent[0] + 100))
    assert came == [c + int(dut.Latency.value) for c in sent]
    stated = latencies(configuration())  # in a sweep of accuracy
    assert stated["hit"] - stated["test"] == int(dut.Latency.value)
    assert events.counts()["works"] == 100


@cocotb.test()
async def credits_stop_the_input_before_anything_is_lost(dut):
    rng, events = await setup(dut)
    source, sink = Source(dut, "candidate"), Sink(dut, "return")
    todo = list(candidates(rng, 100))[:200]
    latency = int(dut.Latency.value)

    cocotb.start_soon(source.send(packed(todo)))
    await ClockCycles(dut.clk_i, 4 * latency)
    await ReadOnly()
    assert dut.candidate_ready_o.value == 0
    assert events.counts()["c_passes"] == latency + 2
    await RisingEdge(dut.clk_i)

    got = await sink.receive(len(todo))
    assert [read(bits) for bits in got] == [expected(candidate) for candidate in todo]


@cocotb.test()
async def is_idle_except_while_a_candidate_is_inside(dut):
    """From the cycle after the first one in to that in which the last result goes."""
    rng, _ = await setup(dut)
    todo = packed(candidates(rng, 20))[-20:]
    source = Source(dut, "candidate")
    await RisingEdge(dut.clk_i)
    cocotb.start_soon(source.send(todo, stalls(rng, 0.5)))
    inside = 0
    for _ in range(20 * 8 + int(dut.Latency.value)):
        dut.return_ready_i.value = int(rng.random() < 0.5)
        await ReadOnly()
        assert dut.idle_o.value == (inside == 0), f"{inside} inside"
        inside += dut.candidate_valid_i.value == 1 and dut.candidate_ready_o.value == 1
        inside -= dut.return_valid_o.value == 1 and dut.return_ready_i.value == 1
        await RisingEdge(dut.clk_i)
    assert inside == 0


@cocotb.test()
async def tells_what_it_does_in_each_cycle(dut):
    """Nothing to do, one candidate, one in every cycle, a taker that waits."""
    rng, events = await setup(dut)
    source, latency = Source(dut, "candidate"), int(dut.Latency.value)
    todo = packed(candidates(rng, 100))[-100:]

    async def during(cycles):
        before = events.counts()
        await ClockCycles(dut.clk_i, cycles)
        return events.activities(before)

    assert await during(20) == {"empty": 20}

    dut.return_ready_i.value = 1
    cocotb.start_soon(source.send(todo[:1]))
    assert await during(2 * latency) == {"works": 1, "latency": latency, "empty": latency - 1}

    task = cocotb.start_soon(source.send(todo))
    assert await during(100) == {"works": 100}
    await task
    await ClockCycles(dut.clk_i, 2 * latency)

    dut.return_ready_i.value = 0
    cocotb.start_soon(source.send(todo))
    await ClockCycles(dut.clk_i, 3 * latency)
    assert await during(30) == {"room": 30}


@pytest.mark.parametrize("overrides", FORMATS)
def test_ti_ist2(overrides):
    run("ti_ist2", "test_ti_ist2", config=f"tiny {overrides}")
