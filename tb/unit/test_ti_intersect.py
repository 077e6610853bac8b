# SPDX-License-Identifier: Apache-2.0
"""`ti_intersect` answers every test of every leaf once, as the model does, to the ray's home."""

from collections import Counter

import cocotb
import pytest
from agents.bench import run, start
from agents.events import Events
from agents.image_memory import ImageMemory
from agents.lanes import Lanes
from agents.stream import Sink, Source, stalls
from cocotb.triggers import ClockCycles, ReadOnly, RisingEdge
from models.numbers import numbers
from models.payload import configuration, parameter, payloads
from models.rays import operands
from models.scene import BASE, Scene, rays_through, soup

PATIENCE = 20_000  # cycles without a token after which one is lost


class Bench:
    """A scene in memory behind each LIST and IST1; the homes are streams of leaves and tokens."""

    def __init__(self, dut, rng, p=1.0, latency=1, triangles=60, fails=None, list_end=0):
        self.dut, self.rng, self.p = dut, rng, p
        config = configuration()
        self.homes, self.slots = range(config["num_trv"]), config["trv_slots"]
        self.scene = scene = Scene(soup(rng, triangles, 0.8))
        self.list_end = list_end or len(scene.ids)
        dut.list_base_i.value, dut.num_list_i.value = scene.list_base, self.list_end
        dut.num_records_i.value = scene.count
        dut.plane_base_i.value, dut.bary_base_i.value = scene.plane_base, scene.bary_base
        self.lanes = lanes = Lanes(dut)
        ports = config["num_list"] + config["num_ist1"]
        memories = [
            ImageMemory(
                lanes[port],
                scene.bytes,
                BASE,
                latency=lambda: rng.randint(1, latency),
                ready=lambda: rng.random() < p,
                fails=fails,
            )
            for port in range(ports)
        ]
        self.list_memories = memories[: config["num_list"]]
        self.ist1_memories = memories[config["num_list"] :]
        self.list = [Events(dut, "list", port) for port in dut.list_events_o]
        self.ist1 = [Events(dut, "ist1", port) for port in dut.ist1_events_o]
        self.ist2 = Events(dut, "ist2", dut.ist2_events_o)

    def leaf(self, home, slot, count):
        """A leaf of a random ray, which is aimed at one of its triangles half of the time."""
        rng, n = self.rng, numbers()
        first = rng.randrange(len(self.scene.ids) - count + 1)
        [(o, d)] = rays_through(rng, 1)
        if rng.random() < 0.5:
            o, d = self.scene.aimed(rng, self.scene.ids[first + rng.randrange(count)])
        return {
            "home": {"trv": home, "slot": slot},
            "first": first,
            "count": count,
            "operands": operands(o, d),
            "tnear": 0 if rng.random() < 0.5 else n.of(rng.uniform(0, 1)),
            "tfar": n.inf if rng.random() < 0.5 else n.of(rng.uniform(0, 2)),
        }

    def records(self, leaf):
        """The triangles of its tests, and how many tests stand beyond the list."""
        end = leaf["first"] + leaf["count"]
        return self.scene.ids[leaf["first"] : min(end, self.list_end)], max(
            0, min(end - self.list_end, leaf["count"])
        )

    def outcome(self, leaf, record):
        return self.scene.test(record, leaf["operands"], leaf["tnear"], leaf["tfar"])

    def expected(self, leaf):
        """Its tokens, and the passes that its tests take."""
        tokens, passes = Counter(), Counter()
        records, beyond = self.records(leaf)
        for record in records:
            outcome = self.outcome(leaf, record)
            passes.update({k: k in outcome.passes for k in "abc"})
            hit = outcome.hit
            values = dict(zip("tuv", hit, strict=True), prim=self.scene.prim(record)) if hit else {}
            tokens[token(leaf["home"]["slot"], 1, bool(hit), 0, values)] += 1
        if beyond:
            tokens[token(leaf["home"]["slot"], beyond, 0, 1, {})] += 1
        return tokens, passes

    async def send(self, leaves):
        """All leaves of each home through its stream, as slots are free; the tokens of each."""
        tasks = [cocotb.start_soon(self._home(home, leaves[home])) for home in self.homes]
        got = [await task for task in tasks]
        for home in self.homes:
            await Sink(self.lanes[home], "return").expect_none(60 // len(self.homes))
        return got

    async def _home(self, home, leaves):
        rng, sink = self.rng, Sink(self.lanes[home], "return")
        gap = stalls(rng, 1 - self.p)
        waiting, left, got = list(leaves), {}, []  # tests of the leaf in a slot that are out

        async def send():
            source = Source(self.lanes[home], "leaf")
            while waiting:
                free = next((leaf for leaf in waiting if leaf["home"]["slot"] not in left), None)
                if free is None:
                    await RisingEdge(self.dut.clk_i)
                    continue
                waiting.remove(free)
                left[free["home"]["slot"]] = free["count"]
                await source.send([payloads().pack("leaf_t", free)], gap)

        cocotb.start_soon(send())
        while waiting or left:
            [bits] = await sink.receive(1, lambda: rng.random() < self.p, PATIENCE)
            values = payloads().unpack("return_t", bits)
            assert values["home"]["trv"] == home, f"{values} came to home {home}"
            slot = values["home"]["slot"]
            left[slot] -= values["count"]
            assert left[slot] >= 0, f"more tests came back than the leaf in slot {slot} has"
            if left[slot] == 0:
                del left[slot]
            got.append(token(slot, values["count"], values["hit"], values["error"], values))
        return got


def token(slot, count, hit, error, values):
    """What a home reads of a token: of a miss neither t, u, v nor the primitive."""
    read = tuple(values[k] for k in ("t", "u", "v", "prim")) if hit else ()
    return slot, count, int(hit), error, read


def counted(watched):
    return sum((Counter(events.counts()) for events in watched), Counter())


async def check(bench, leaves):
    """Send the leaves; every token as the model has it, and every event counted."""
    want = [Counter() for _ in bench.homes]
    passes, errors = Counter(), 0
    for home in bench.homes:
        for leaf in leaves[home]:
            tokens, taken = bench.expected(leaf)
            want[home] += tokens
            passes += taken
            errors += any(error for _, _, _, error, _ in tokens)

    got = await bench.send(leaves)

    for home in bench.homes:
        wrong = Counter(got[home]) - want[home]
        assert not wrong, f"home {home}: not asked for: {wrong}"
        assert Counter(got[home]) == want[home]
    lists, ist1 = counted(bench.list), counted(bench.ist1)
    assert lists["ids"] == passes["a"] and lists["l1_accesses"] == passes["a"] + errors
    assert (ist1["a_passes"], ist1["b_passes"]) == (passes["a"], passes["b"])
    assert ist1["l1_accesses"] == passes["a"] + passes["b"]
    assert bench.ist2.counts()["c_passes"] == passes["c"]
    asked = (bench.list_memories, lists), (bench.ist1_memories, ist1)
    assert all(n["l1_misses"] == sum(len(m.asked) for m in memories) for memories, n in asked)
    return passes


def random_leaves(bench, count, most=12):
    """`count` leaves for each home, one after the other in its slots."""
    return [
        [bench.leaf(home, i % bench.slots, bench.rng.randint(1, most)) for i in range(count)]
        for home in bench.homes
    ]


@cocotb.test()
@cocotb.parametrize((("p", "latency"), [(1.0, 1), (0.3, 40), (1.0, 40)]))
async def answers_every_test_once_as_the_model_does(dut, p, latency):
    rng = await start(dut)
    bench = Bench(dut, rng, p, latency)

    passes = await check(bench, random_leaves(bench, 120 // len(bench.homes)))

    assert passes["c"] > 20
    units = [*bench.list, *bench.ist1, bench.ist2]
    waits = sum(events.counts()["arbitration"] for events in units)
    assert waits > 0 or latency > 1, "with fast memory some must meet on the way home"
    assert all(events.counts()["ids"] for events in bench.list)
    assert all(events.counts()["a_passes"] for events in bench.ist1)


@cocotb.test()
async def a_place_beyond_the_list_comes_back_as_one_error(dut):
    rng = await start(dut)
    bench = Bench(dut, rng, 0.5, 10, list_end=50)
    assert len(bench.scene.ids) > 70

    await check(bench, random_leaves(bench, 40))


@cocotb.test()
@cocotb.parametrize(part=["list", "record", "second"])
async def a_memory_error_comes_back_to_the_home_of_the_test(dut, part):
    """Every test of a leaf is accounted for, and a test that needs a bad line is an error."""
    rng = await start(dut)
    bad = set()
    bench = Bench(dut, rng, 0.7, 10, fails=lambda line: line in bad)
    scene, line_of = bench.scene, bench.list_memories[0].line_of
    base, size, count = {
        "list": (scene.list_base, 4, len(scene.ids)),
        "record": scene.parts[0],
        "second": scene.parts[-1],
    }[part]
    bad |= {line_of(base + size * i) for i in range(count // 8, count, count // 4)}
    good = {line_of(b + s * i) for b, s, n in all_parts(scene) for i in range(n) if b != base}
    bad -= good  # lines that hold something of another part
    assert bad
    leaves = random_leaves(bench, 30)

    got = await bench.send(leaves)

    errors, passes = 0, Counter()
    for home in bench.homes:
        want = Counter()
        for leaf in leaves[home]:
            slot = leaf["home"]["slot"]
            for i in range(leaf["count"]):
                place = leaf["first"] + i
                if line_of(scene.list_base + 4 * place) in bad:
                    want[token(slot, leaf["count"] - i, 0, 1, {})] += 1
                    break
                record = scene.ids[place]
                outcome = bench.outcome(leaf, record)
                places = [line_of(base + size * record) for base, size, _ in scene.parts]
                failed_a = places[0] in bad
                failed_b = "b" in outcome.passes and places[-1] in bad
                failed = failed_a or failed_b
                passes["ids"] += 1
                passes["a_passes"] += not failed_a
                passes["b_passes"] += "b" in outcome.passes and not failed
                passes["c_passes"] += "c" in outcome.passes and not failed
                hit = () if failed or not outcome.hit else outcome.hit
                values = dict(zip("tuv", hit, strict=False), prim=scene.prim(record)) if hit else {}
                want[token(slot, 1, bool(hit), int(failed), values)] += 1
        errors += sum(n for (_, _, _, error, _), n in want.items() if error)
        assert Counter(got[home]) == want
    assert errors > 5
    counts = counted([*bench.list, *bench.ist1, bench.ist2])
    assert {k: counts[k] for k in passes} == dict(passes)


def all_parts(scene):
    return (
        (scene.list_base, 4, len(scene.ids)),
        *scene.parts,
    )


@cocotb.test()
async def tells_homes_when_another_was_served(dut):
    """`leaf_lost_o` exactly where a leaf waits while one goes to the same LIST."""
    rng = await start(dut)
    bench = Bench(dut, rng, 0.9, 5)
    lists, lost = configuration()["num_list"], []

    async def watch():
        while True:
            await ReadOnly()
            valid, ready = int(dut.leaf_valid_i.value), int(dut.leaf_ready_o.value)
            served = {home % lists for home in bench.homes if ready >> home & 1}
            want = sum((home % lists in served) << home for home in bench.homes) & valid & ~ready
            assert dut.leaf_lost_o.value == want
            lost.append(want)
            await RisingEdge(dut.clk_i)

    cocotb.start_soon(watch())
    await bench.send(random_leaves(bench, 30, most=2))
    assert any(lost) == (len(bench.homes) > lists)


@cocotb.test(skip=parameter("NumIst1") < 2)
async def the_tests_of_a_pair_of_triangles_go_to_one_ist1(dut):
    """So that the private L1s hold different triangles; every IST1 has some."""
    rng = await start(dut)
    bench = Bench(dut, rng)
    pairs = [set() for _ in bench.ist1]

    async def watch():
        while True:
            await ReadOnly()
            moves = int(dut.ist1_test_valid.value) & int(dut.ist1_test_ready.value)
            for i, seen in enumerate(pairs):
                if moves >> i & 1:
                    test = payloads().unpack("test_t", int(dut.ist1_test_data[i].value))
                    seen.add(test["record"] >> 1)
            await RisingEdge(dut.clk_i)

    cocotb.start_soon(watch())
    await check(bench, random_leaves(bench, 60))

    assert all(pairs) and sum(map(len, pairs)) == len(set().union(*pairs))


@cocotb.test()
async def is_idle_except_while_a_test_is_inside(dut):
    """From the cycle after the first leaf in to that in which the last token goes."""
    rng = await start(dut)
    bench = Bench(dut, rng, 0.6, 20)
    inside = [0]

    def tests(name, valid, ready, data):
        moves = int(valid.value) & int(ready.value)
        lanes = [i for i in bench.homes if moves >> i & 1]
        return sum(payloads().unpack(name, int(data[i].value))["count"] for i in lanes)

    async def watch():
        while True:
            await ReadOnly()
            assert dut.idle_o.value == (inside[0] == 0), f"{inside[0]} inside"
            inside[0] += tests("leaf_t", dut.leaf_valid_i, dut.leaf_ready_o, dut.leaf_data_i)
            inside[0] -= tests(
                "return_t", dut.return_valid_o, dut.return_ready_i, dut.return_data_o
            )
            await RisingEdge(dut.clk_i)

    cocotb.start_soon(watch())
    await ClockCycles(dut.clk_i, 5)
    await bench.send(random_leaves(bench, 3))
    await bench.send(random_leaves(bench, 12))
    assert inside[0] == 0


@cocotb.test()
async def a_flush_makes_every_unit_ask_for_its_lines_again(dut):
    rng = await start(dut)
    bench = Bench(dut, rng, triangles=4)  # all that it reads stays in the L1s
    leaves = [[bench.leaf(home, 0, 1)] for home in bench.homes]
    memories = bench.list_memories + bench.ist1_memories

    async def lines_asked_for():
        before = [len(memory.asked) for memory in memories]
        await bench.send(leaves)
        return [sorted(m.asked[b:]) for m, b in zip(memories, before, strict=True)]

    first = await lines_asked_for()
    assert all(first[: len(bench.list_memories)]) and any(first[len(bench.list_memories) :])
    assert not any(await lines_asked_for())
    dut.flush_i.value = 1
    await RisingEdge(dut.clk_i)
    dut.flush_i.value = 0
    assert await lines_asked_for() == first


BUILDS = {
    "tiny": "",
    "lines": "num_trv=3 num_list=2 num_ist1=3 line_bytes=32",
    "as_published": "triangle_test=np",
    "woop": "triangle_test=woop num_trv=3 num_list=2",
    "wide": "num_trv=3 num_list=3 num_ist1=2 line_bytes=128 exp_bits=7 frac_bits=16",
}


@pytest.mark.parametrize("build", BUILDS)
def test_ti_intersect(build):
    only = "^(?!.*second)" if build == "woop" else None  # its records have no second part
    run("ti_intersect", "test_ti_intersect", config=f"tiny {BUILDS[build]}", only=only)
