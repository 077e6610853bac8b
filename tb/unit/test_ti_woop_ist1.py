# SPDX-License-Identifier: Apache-2.0
"""`ti_woop_ist1` answers each test once, as the model does, and takes one every cycle when fed."""

from collections import Counter

import cocotb
import pytest
from agents.bench import cycle, run, start
from agents.events import Events
from agents.idle import Idle, one
from agents.image_memory import ImageMemory
from agents.stream import Sink, Source, stalls
from cocotb.triggers import ClockCycles, RisingEdge
from models.numbers import numbers
from models.payload import configuration, parameter, payloads
from models.rays import operands
from models.scene import BASE, Scene, rays_through, soup

SLOTS_TO_FILL = 64  # fewer cannot keep the pipeline busy
EARLY_EXIT = bool(parameter("EarlyExit", 1))
PATIENCE = 5000  # cycles without a beat after which one is lost


class Bench:
    """A scene in memory behind a reset unit, its events and `idle_o` under watch."""

    def __init__(self, dut, rng, triangles=60, **memory):
        self.scene = Scene(soup(rng, triangles, 0.8))
        dut.corner_base_i.value = self.scene.plane_base
        self.memory = ImageMemory(dut, self.scene.bytes, BASE, **memory)
        self.events = Events(dut, "ist1")
        Idle(dut, {"test": one}, {"candidate": one, "return": one})


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
            "tnear": n.of(rng.uniform(0, 1)),
            "tfar": n.of(rng.uniform(0, 2)),
        }


def answer(scene, test):
    """("candidate" or "return", its beat); without early exit a miss is a candidate too."""
    result = scene.test(test["record"], test["operands"], test["tnear"], test["tfar"])
    if "c" in result.passes:
        edges = dict(zip(("weight", "z", "sz"), result.after_b, strict=True))
        prim = scene.prim(test["record"])
        return "candidate", payloads().pack(
            "woop_candidate_t", home=test["home"], prim=prim, edges=edges
        )
    if EARLY_EXIT:
        return "return", payloads().pack("return_t", home=test["home"], count=1)
    return "candidate", payloads().pack("woop_candidate_t", home=test["home"], miss=1)


def read(name, bits):
    """A beat; of a candidate that is a miss only what IST2 reads of it."""
    if name == "candidate" and (beat := payloads().unpack("woop_candidate_t", bits))["miss"]:
        return payloads().pack("woop_candidate_t", home=beat["home"], miss=1)
    return bits


async def collect(dut, rng, todo, answers, p_valid, p_ready):
    """Send the tests, take what comes, and compare with the answers in any order."""
    sinks = {name: Sink(dut, name) for name in ("candidate", "return")}
    packed = [payloads().pack("test_t", test) for test in todo]
    cocotb.start_soon(Source(dut, "test").send(packed, stalls(rng, 1 - p_valid)))
    want = {name: [beat for kind, beat in answers if kind == name] for name in sinks}
    tasks = {
        name: cocotb.start_soon(
            sink.receive(len(want[name]), lambda: rng.random() < p_ready, PATIENCE)
        )
        for name, sink in sinks.items()
    }
    for name, task in tasks.items():
        assert Counter(read(name, bits) for bits in await task) == Counter(want[name]), name
    for sink in sinks.values():
        await sink.expect_none(int(dut.PassLatency.value))
    return {name: len(beats) for name, beats in want.items()}


@cocotb.test()
@cocotb.parametrize(p_valid=[1.0, 0.3], p_ready=[1.0, 0.2], latency=[1, 40])
async def answers_each_test_once_as_the_model_does(dut, p_valid, p_ready, latency):
    rng = await start(dut)
    bench = Bench(
        dut, rng, latency=lambda: rng.randint(1, latency), ready=lambda: rng.random() < 0.7
    )
    todo = list(random_tests(rng, bench.scene, 400))
    answers = [answer(bench.scene, test) for test in todo]

    sent = await collect(dut, rng, todo, answers, p_valid, p_ready)

    assert sent["candidate"] > 20 and (sent["return"] > 20) == EARLY_EXIT
    counts = bench.events.counts()
    assert (counts["a_passes"], counts["b_passes"]) == (len(todo), 0)
    assert counts["works"] == counts["l1_accesses"] == len(todo)
    assert counts["l1_misses"] == len(bench.memory.asked)


@cocotb.test()
async def a_memory_error_comes_back_as_one(dut):
    rng = await start(dut)
    bad = set()
    bench = Bench(dut, rng, fails=lambda line: line in bad, latency=lambda: rng.randint(1, 9))
    scene, line_bytes = bench.scene, configuration()["line_bytes"]
    [(base, size, count)] = scene.parts
    bad |= {(base + size * r) // line_bytes for r in range(0, count, 7)}
    todo = list(random_tests(rng, scene, 400))
    answers = [
        ("return", payloads().pack("return_t", home=test["home"], count=1, error=1))
        if (base + size * test["record"]) // line_bytes in bad
        else answer(scene, test)
        for test in todo
    ]

    await collect(dut, rng, todo, answers, 0.7, 0.7)

    errors = sum(payloads().unpack("return_t", b)["error"] for k, b in answers if k == "return")
    assert errors > 20
    assert bench.events.counts()["a_passes"] == len(todo) - errors


@cocotb.test(skip=parameter("NumSlots") < SLOTS_TO_FILL)
async def takes_one_test_every_cycle(dut):
    """With all lines in the L1 and a test always waiting, over 500 cycles."""
    rng = await start(dut)
    bench = Bench(dut, rng, triangles=12)
    packed = [payloads().pack("test_t", test) for test in random_tests(rng, bench.scene, 500)]
    dut.candidate_ready_i.value = dut.return_ready_i.value = 1
    cocotb.start_soon(Source(dut, "test").send(rng.choice(packed) for _ in range(10_000)))

    await ClockCycles(dut.clk_i, 300)
    before, since = bench.events.counts(), cycle()
    await ClockCycles(dut.clk_i, 500)
    done, until = bench.events.since(before), cycle()

    assert done["l1_misses"] == 0
    assert done["a_passes"] == done["works"] == until - since == 500


@cocotb.test()
async def a_flush_makes_it_ask_for_its_lines_again(dut):
    rng = await start(dut)
    bench = Bench(dut, rng)
    todo = next(random_tests(rng, bench.scene, 1))
    kind, want = answer(bench.scene, todo)

    async def lines_asked_for():
        before = len(bench.memory.asked)
        cocotb.start_soon(Source(dut, "test").send([payloads().pack("test_t", todo)]))
        [got] = await Sink(dut, kind).receive(1)
        assert read(kind, got) == want
        return bench.memory.asked[before:]

    first = await lines_asked_for()
    assert len(first) == 1 and await lines_asked_for() == []
    dut.flush_i.value = 1
    await RisingEdge(dut.clk_i)
    dut.flush_i.value = 0
    assert await lines_asked_for() == first


BUILDS = {
    "tiny": ("", {}),
    "large": ("ist1_rows=4", {"NumSlots": SLOTS_TO_FILL, "CacheBytes": 4096, "Ways": 4, "Rows": 4}),
    "packed": ("exp_bits=7 frac_bits=16 line_bytes=32 lookup_stages=4", {"NumSlots": 5, "Rows": 1}),
    "all passes": ("line_bytes=128", {"NumSlots": 16, "EarlyExit": 0}),
}


@pytest.mark.parametrize("build", BUILDS)
def test_ti_woop_ist1(build):
    overrides, params = BUILDS[build]
    config = f"tiny triangle_test=woop {overrides}"
    run("ti_woop_ist1", "test_ti_woop_ist1", config=config, params=params)
