# SPDX-License-Identifier: Apache-2.0
"""`ti_ist1` answers each test once, as the model does, and takes one pass every cycle when fed."""

from collections import Counter

import cocotb
import pytest
from agents.bench import cycle, run, start
from agents.image_memory import ImageMemory
from agents.stream import Sink, Source, stalls
from cocotb.triggers import ClockCycles, ReadOnly, RisingEdge
from models.numbers import numbers
from models.payload import parameter, payloads
from models.scene import BASE, Scene, rays_through, soup

SLOTS_TO_FILL = 64  # fewer cannot keep the pipeline busy
PATIENCE = 5000  # cycles without a beat after which one is lost


async def setup(dut, triangles=60, **memory):
    """A scene in memory behind a reset unit; (rng, scene)."""
    rng = await start(dut)
    scene = Scene(soup(rng, triangles, size=0.8))
    dut.plane_base_i.value, dut.bary_base_i.value = scene.plane_base, scene.bary_base
    ImageMemory(dut, scene.bytes, BASE, **{k: make(rng, scene) for k, make in memory.items()})
    return rng, scene


def random_tests(rng, scene, count):
    """Half of them aimed at their triangle."""
    n = numbers()
    for i, (o, d) in enumerate(rays_through(rng, count)):
        record = rng.randrange(len(scene.planes))
        if i % 2:
            o, d = scene.aimed(rng, record)
        yield {
            "home": {"trv": i & 1, "slot": i >> 1 & 7},
            "record": record,
            "o": o,
            "d": d,
            "tbest": n.inf if rng.random() < 0.5 else n.of(rng.uniform(0, 2)),
        }


def outcome(scene, test):
    return scene.test(test["record"], test["o"], test["d"], test["tbest"])


def candidate(scene, test):
    """The candidate of a test that is inside, else None."""
    result = outcome(scene, test)
    if result.passes < 3:
        return None
    parts = dict(zip(("det", "dett", "detu", "detv"), result.after_b, strict=True))
    prim = scene.prim(test["record"])
    return payloads().pack("candidate_t", parts, home=test["home"], prim=prim)


def token(test, error=0):
    return payloads().pack("return_t", home=test["home"], count=1, error=error)


async def collect(dut, rng, todo, want, p_valid, p_ready):
    """Send the tests, take what comes, and compare with (candidates, tokens) in any order."""
    source = Source(dut, "test")
    sinks = Sink(dut, "candidate"), Sink(dut, "return")
    packed = [payloads().pack("test_t", test) for test in todo]
    cocotb.start_soon(source.send(packed, stalls(rng, 1 - p_valid)))
    tasks = [
        cocotb.start_soon(sink.receive(len(beats), lambda: rng.random() < p_ready, PATIENCE))
        for sink, beats in zip(sinks, want, strict=True)
    ]
    got = [await task for task in tasks]
    for sink in sinks:
        await sink.expect_none(int(dut.PassLatency.value))
    for name, have, beats in zip(("candidate_t", "return_t"), got, want, strict=True):
        wrong = next(iter(Counter(have) - Counter(beats)), None)
        assert wrong is None, f"not asked for: {payloads().unpack(name, wrong)}"
        assert len(have) == len(beats)


def counters(dut):
    return payloads().unpack("ist1_counters_t", int(dut.counters_o.value))


@cocotb.test()
@cocotb.parametrize(p_valid=[1.0, 0.3], p_ready=[1.0, 0.2], latency=[1, 40])
async def answers_each_test_once_as_the_model_does(dut, p_valid, p_ready, latency):
    rng, scene = await setup(
        dut, latency=lambda rng, _: lambda: rng.randint(1, latency), ready=mostly
    )
    todo = list(random_tests(rng, scene, 400))
    kept = [c for c in (candidate(scene, test) for test in todo) if c is not None]
    over = [token(test) for test in todo if candidate(scene, test) is None]
    assert min(len(kept), len(over)) > 20

    await collect(dut, rng, todo, (kept, over), p_valid, p_ready)

    passes = [outcome(scene, test).passes for test in todo]
    assert counters(dut)["a_passes"] == len(todo)
    assert counters(dut)["b_passes"] == sum(p > 1 for p in passes)


def mostly(rng, _):
    return lambda: rng.random() < 0.7


@cocotb.test()
@cocotb.parametrize(part=["plane", "bary"])
async def a_memory_error_comes_back_as_one(dut, part):
    def fails(rng, scene):
        start, size = {"plane": (scene.plane_base, 32), "bary": (scene.bary_base, 16)}[part]
        lines = len(dut.line_rsp_data_i) // 8
        bad = {(start + size * r) // lines for r in range(0, len(scene.planes), 7)}
        return lambda line: line in bad

    rng, scene = await setup(dut, fails=fails)
    bad = fails(rng, scene)
    line_bytes = len(dut.line_rsp_data_i) // 8

    def failed(test, base, size):
        return bad((base + size * test["record"]) // line_bytes)

    todo = list(random_tests(rng, scene, 300))
    kept, over, errors = [], [], 0
    for test in todo:
        result = outcome(scene, test)
        error = failed(test, scene.plane_base, 32)
        error = error or (result.passes > 1 and failed(test, scene.bary_base, 16))
        errors += error
        if error or result.passes < 3:
            over.append(token(test, int(error)))
        else:
            kept.append(candidate(scene, test))
    assert errors > 20

    await collect(dut, rng, todo, (kept, over), 1.0, 0.5)


@cocotb.test()
async def a_miss_in_pass_a_fetches_nothing_more(dut):
    rng = await start(dut)
    scene = Scene(soup(rng, 60))
    dut.plane_base_i.value, dut.bary_base_i.value = scene.plane_base, scene.bary_base
    memory = ImageMemory(dut, scene.bytes, BASE)
    todo = [t for t in random_tests(rng, scene, 500) if outcome(scene, t).passes == 1]

    await collect(dut, rng, todo, ([], [token(test) for test in todo]), 1.0, 1.0)

    assert all(line < memory.line_of(scene.bary_base) for line in memory.asked)
    assert counters(dut)["b_passes"] == 0


@cocotb.test()
async def a_pass_takes_its_latency_from_the_answer_to_the_result(dut):
    rng, scene = await setup(dut)
    todo = next(t for t in random_tests(rng, scene, 100) if outcome(scene, t).passes == 3)
    dut.candidate_ready_i.value = 1
    cocotb.start_soon(Source(dut, "test").send([payloads().pack("test_t", todo)]))

    answers, results = [], []
    while not results or len(results) < 2:
        await ReadOnly()
        if dut.rsp_valid.value == 1:
            answers.append(cycle())
        if dut.result_valid.value == 1:
            results.append(cycle())
        await RisingEdge(dut.clk_i)

    assert results == [answer + int(dut.PassLatency.value) for answer in answers]


@cocotb.test(skip=parameter("NumSlots") < SLOTS_TO_FILL)
@cocotb.parametrize(passes=[1, 2, 3, 0])
async def takes_one_pass_every_cycle(dut, passes):
    """With all lines in the L1 and a test always waiting, over 500 cycles.

    The tests take `passes` passes each; 0: any number.
    """
    rng, scene = await setup(dut, triangles=12)
    pool = [t for t in random_tests(rng, scene, 2000) if passes in (0, outcome(scene, t).passes)]
    packed = [payloads().pack("test_t", test) for test in pool]
    dut.candidate_ready_i.value = dut.return_ready_i.value = 1
    source = Source(dut, "test")
    cocotb.start_soon(source.send(rng.choice(packed) for _ in range(10_000)))

    await ClockCycles(dut.clk_i, 300)
    before, since = counters(dut), cycle()
    await ClockCycles(dut.clk_i, 500)
    after, until = counters(dut), cycle()

    assert after["cache"]["misses"] == before["cache"]["misses"]
    taken = sum(after[k] - before[k] for k in ("a_passes", "b_passes"))
    assert taken == until - since == 500


@pytest.mark.parametrize(
    "params",
    [{}, {"NumSlots": SLOTS_TO_FILL, "CacheBytes": 4096, "Ways": 4, "Rows": 4}],
    ids=["tiny", "large"],
)
def test_ti_ist1(params):
    run("ti_ist1", "test_ti_ist1", params=params)
