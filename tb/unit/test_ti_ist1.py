# SPDX-License-Identifier: Apache-2.0
"""`ti_ist1` answers each test once, as the model does, and takes one pass every cycle when fed."""

from collections import Counter

import cocotb
import pytest
from agents.bench import cycle, run, start
from agents.events import Events
from agents.idle import Idle, one
from agents.image_memory import ImageMemory
from agents.stream import Sink, Source, stalls
from cocotb.triggers import ClockCycles, ReadOnly, RisingEdge
from models.numbers import numbers
from models.payload import configuration, parameter, payloads
from models.rays import operands
from models.scene import BASE, Scene, rays_through, soup

SLOTS_TO_FILL = 64  # fewer cannot keep the pipeline busy
EARLY_EXIT = bool(parameter("EarlyExit", 1))
PATIENCE = 5000  # cycles without a beat after which one is lost


class Bench:
    """A scene in memory behind a reset unit, its events and `idle_o` under watch."""

    def __init__(self, dut, rng, triangles=60, size=0.8, **memory):
        self.scene = Scene(soup(rng, triangles, size))
        dut.plane_base_i.value = self.scene.plane_base
        dut.bary_base_i.value = self.scene.bary_base
        made = {k: make(rng, self.scene) for k, make in memory.items()}
        self.memory = ImageMemory(dut, self.scene.bytes, BASE, **made)
        self.events = Events(dut, "ist1")
        Idle(dut, {"test": one}, {"candidate": one, "return": one})

    def check_counts(self, a_passes, b_passes, errors=0):
        """Passes, and that each pass and each error is an access of the L1."""
        counts = self.events.counts()
        assert (counts["a_passes"], counts["b_passes"]) == (a_passes, b_passes)
        assert counts["works"] == a_passes + b_passes
        assert counts["l1_accesses"] == a_passes + b_passes + errors
        assert counts["l1_accesses"] == sum(counts[f"l1_{k}"] for k in ("hits", "merged", "misses"))
        assert counts["l1_misses"] == len(self.memory.asked)


async def setup(dut, **scene):
    rng = await start(dut)
    return rng, Bench(dut, rng, **scene)


def random_tests(rng, scene, count):
    """Half of them aimed at their triangle."""
    n = numbers()
    for i, (o, d) in enumerate(rays_through(rng, count)):
        record = rng.randrange(scene.count)
        if i % 2:
            o, d = scene.aimed(rng, record)
        yield {
            "home": {"trv": i & 1, "slot": i >> 1 & 7},
            "record": record,
            "operands": operands(o, d),
            "tnear": 0 if rng.random() < 0.5 else n.of(rng.uniform(0, 1)),
            "tfar": n.inf if rng.random() < 0.5 else n.of(rng.uniform(0, 2)),
        }


def outcome(scene, test):
    return scene.test(test["record"], test["operands"], test["tnear"], test["tfar"])


def passes(scene, test):
    """How many passes a test takes, (c) included."""
    return len(outcome(scene, test).passes) if EARLY_EXIT else 3


def candidate(scene, test):
    """The candidate of a test that is inside, else None; without early exit a miss is one too."""
    result = outcome(scene, test)
    if "c" not in result.passes:
        return None if EARLY_EXIT else payloads().pack("candidate_t", home=test["home"], miss=1)
    parts = dict(zip(("det", "dett", "detu", "detv"), result.after_b, strict=True))
    prim = scene.prim(test["record"])
    return payloads().pack("candidate_t", parts, home=test["home"], prim=prim)


def read(name, bits):
    """A beat; of a candidate that is a miss only what IST2 reads of it."""
    beat = payloads().unpack(name, bits)
    if beat.get("miss"):
        bits = payloads().pack(name, home=beat["home"], miss=1)
    return bits


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
    for name, taken, beats in zip(("candidate_t", "return_t"), got, want, strict=True):
        have = [read(name, bits) for bits in taken]
        wrong = next(iter(Counter(have) - Counter(beats)), None)
        assert wrong is None, f"not asked for: {payloads().unpack(name, wrong)}"
        assert len(have) == len(beats)


@cocotb.test()
@cocotb.parametrize(p_valid=[1.0, 0.3], p_ready=[1.0, 0.2], latency=[1, 40])
async def answers_each_test_once_as_the_model_does(dut, p_valid, p_ready, latency):
    rng, bench = await setup(
        dut, latency=lambda rng, _: lambda: rng.randint(1, latency), ready=mostly
    )
    scene = bench.scene
    todo = list(random_tests(rng, scene, 400))
    kept = [c for c in (candidate(scene, test) for test in todo) if c is not None]
    tokens = [token(test) for test in todo if candidate(scene, test) is None]
    assert len(kept) > 20 and (len(tokens) > 20) == EARLY_EXIT

    await collect(dut, rng, todo, (kept, tokens), p_valid, p_ready)

    bench.check_counts(len(todo), sum(passes(scene, test) > 1 for test in todo))


def mostly(rng, _):
    return lambda: rng.random() < 0.7


@cocotb.test()
@cocotb.parametrize(part=["plane", "bary"])
async def a_memory_error_comes_back_as_one(dut, part):
    line_bytes = configuration()["line_bytes"]

    def fails(rng, scene):
        start, size = {"plane": (scene.plane_base, 32), "bary": (scene.bary_base, 16)}[part]
        bad = {(start + size * r) // line_bytes for r in range(0, scene.count, 7)}
        return lambda line: line in bad

    rng, bench = await setup(dut, fails=fails)
    scene = bench.scene
    bad = fails(rng, scene)

    def failed(test, base, size):
        return bad((base + size * test["record"]) // line_bytes)

    todo = list(random_tests(rng, scene, 300))
    kept, tokens, errors, taken = [], [], 0, Counter()
    for test in todo:
        error_a = failed(test, scene.plane_base, 32)
        goes_on = not error_a and passes(scene, test) > 1
        error = error_a or (goes_on and failed(test, scene.bary_base, 16))
        errors += error
        taken["a"] += not error_a
        taken["b"] += goes_on and not error
        if error or candidate(scene, test) is None:
            tokens.append(token(test, int(error)))
        else:
            kept.append(candidate(scene, test))
    assert errors > 20

    await collect(dut, rng, todo, (kept, tokens), 1.0, 0.5)
    bench.check_counts(taken["a"], taken["b"], errors)


@cocotb.test(skip=not EARLY_EXIT)
async def a_miss_in_pass_a_fetches_nothing_more(dut):
    rng, bench = await setup(dut, size=0.3)
    scene, memory = bench.scene, bench.memory
    todo = [t for t in random_tests(rng, scene, 500) if outcome(scene, t).passes == "a"]

    await collect(dut, rng, todo, ([], [token(test) for test in todo]), 1.0, 1.0)

    assert all(line < memory.line_of(scene.bary_base) for line in memory.asked)
    bench.check_counts(len(todo), 0)


@cocotb.test(skip=EARLY_EXIT)
async def without_early_exit_each_test_takes_both_passes_and_goes_on_to_ist2(dut):
    """Also one with det = 0, one whose numbers are NaN, and one that (b) alone would keep."""
    rng, bench = await setup(dut, triangles=20)
    scene, n = bench.scene, numbers()
    todo = [t for t in random_tests(rng, scene, 300) if outcome(scene, t).passes != "abc"]
    inside = [t for t in random_tests(rng, scene, 400) if outcome(scene, t).passes == "abc"]
    for test in inside[:50]:
        behind = {**test, "tfar": n.of(1e-4), "tnear": 0}
        nan = {**test, "operands": {"o": (n.nan,) * 3, "d": test["operands"]["d"]}}
        still = {**test, "operands": {"o": test["operands"]["o"], "d": (0, 0, 0)}}
        todo += [t for t in (behind, nan, still) if outcome(scene, t).passes == "a"]
    assert len(todo) > 200

    await collect(dut, rng, todo, ([candidate(scene, test) for test in todo], []), 1.0, 0.7)

    bench.check_counts(len(todo), len(todo))


@cocotb.test()
async def a_pass_takes_its_latency_from_the_answer_to_the_result(dut):
    rng, bench = await setup(dut)
    todo = one_that_takes(rng, bench.scene, "abc")
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
@cocotb.parametrize(wanted=["a", "ab", "abc", ""])
async def takes_one_pass_every_cycle(dut, wanted):
    """With all lines in the L1 and a test always waiting, over 500 cycles.

    The tests take the `wanted` passes each; none: any.
    """
    rng, bench = await setup(dut, triangles=12)
    scene, events = bench.scene, bench.events
    pool = [t for t in random_tests(rng, scene, 2000) if wanted in ("", outcome(scene, t).passes)]
    packed = [payloads().pack("test_t", test) for test in pool]
    dut.candidate_ready_i.value = dut.return_ready_i.value = 1
    source = Source(dut, "test")
    cocotb.start_soon(source.send(rng.choice(packed) for _ in range(10_000)))

    await ClockCycles(dut.clk_i, 300)
    before, since = events.counts(), cycle()
    await ClockCycles(dut.clk_i, 500)
    done, until = events.since(before), cycle()

    assert done["l1_misses"] == 0
    assert done["a_passes"] + done["b_passes"] == done["works"] == until - since == 500


def one_that_takes(rng, scene, passes):
    """One that takes these passes."""
    return next(t for t in random_tests(rng, scene, 1000) if outcome(scene, t).passes == passes)


@cocotb.test()
async def a_flush_makes_it_ask_for_its_lines_again(dut):
    rng, bench = await setup(dut)
    todo = one_that_takes(rng, bench.scene, "abc")

    async def lines_asked_for():
        before = len(bench.memory.asked)
        cocotb.start_soon(Source(dut, "test").send([payloads().pack("test_t", todo)]))
        assert await Sink(dut, "candidate").receive(1) == [candidate(bench.scene, todo)]
        return bench.memory.asked[before:]

    first = await lines_asked_for()
    assert len(first) == 2 and await lines_asked_for() == []
    dut.flush_i.value = 1
    await RisingEdge(dut.clk_i)
    dut.flush_i.value = 0
    assert await lines_asked_for() == first


@cocotb.test(skip=not EARLY_EXIT)
async def tells_what_it_does_in_each_cycle(dut):
    """Nothing to do, a line that memory holds back, a test alone, takers that wait."""
    held = [False]
    rng, bench = await setup(dut, latency=lambda *_: lambda: None if held[0] else 5)
    source, events, memory = Source(dut, "test"), bench.events, bench.memory
    dut.candidate_ready_i.value = dut.return_ready_i.value = 1

    async def during(cycles):
        before = events.counts()
        await ClockCycles(dut.clk_i, cycles)
        return events.activities(before)

    assert await during(20) == {"empty": 20}

    for passes in ("abc", "a"):
        beat = payloads().pack("test_t", one_that_takes(rng, bench.scene, passes))
        held[0] = True
        cocotb.start_soon(source.send([beat]))
        for _ in range(min(len(passes), 2)):  # a part for each of the first two passes
            await ClockCycles(dut.clk_i, 50)
            assert await during(30) == {"memory": 30}
            memory.release(memory.held()[0])
        await ClockCycles(dut.clk_i, 60)
        held[0] = False

        cocotb.start_soon(source.send([beat]))  # its lines are in the L1
        works = min(len(passes), 2)
        steps = works * (2 + configuration()["lookup_stages"] + int(dut.PassLatency.value)) + 2
        moves = {"empty": 1 + 99 - works - steps, "works": works, "latency": steps}
        assert await during(100) == moves

        dut.candidate_ready_i.value = dut.return_ready_i.value = 0
        cocotb.start_soon(source.send([beat]))
        await ClockCycles(dut.clk_i, 80)
        assert await during(30) == {"room": 30}
        dut.candidate_ready_i.value = dut.return_ready_i.value = 1
        await ClockCycles(dut.clk_i, 5)
        assert await during(5) == {"empty": 5}


BUILDS = {
    "tiny": ("", {}),
    "large": ("ist1_rows=4", {"NumSlots": SLOTS_TO_FILL, "CacheBytes": 4096, "Ways": 4, "Rows": 4}),
    "lines": ("line_bytes=32 exp_bits=7 frac_bits=16 fp_cmp_stages=1", {"NumSlots": 5, "Rows": 1}),
    "wide": ("line_bytes=128 lookup_stages=5 fill_bytes=8", {"NumSlots": 16}),
    "all passes": ("", {"NumSlots": 16, "EarlyExit": 0}),
}


@pytest.mark.parametrize("build", BUILDS)
def test_ti_ist1(build):
    overrides, params = BUILDS[build]
    run("ti_ist1", "test_ti_ist1", config=f"tiny {overrides}", params=params)
