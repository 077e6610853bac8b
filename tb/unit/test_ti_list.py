# SPDX-License-Identifier: Apache-2.0
"""`ti_list` sends one test for every id of every leaf, and accounts for those it cannot read."""

import struct
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
from models.payload import parameter, payloads

BASE = 0x40_0000
SLOTS_TO_FILL = 8  # fewer cannot keep the unit busy
PATIENCE = 5000  # cycles without a beat after which one is lost


class List:
    """Random ids in memory, from an odd place in a line on, behind a reset unit.

    Ids at the places `beyond` name no record; entries from `count` on are in memory but not in the
    list.  `events` counts what the unit does.
    """

    def __init__(self, dut, rng, count=600, beyond=(), **memory):
        self.records = rng.randrange(1 << 28, 1 << 29)
        self.ids = [rng.randrange(self.records) for _ in range(count + 40)]
        for place in beyond:
            self.ids[place] = rng.choice(
                (self.records, self.records + 1, (1 << 29) - 1, 1 << 29, (1 << 32) - 1)
            )
        self.ids[count - 1] = self.records - 1 if count - 1 not in beyond else self.records
        self.count = count
        offset = 4 * rng.randrange(1, 16)
        dut.list_base_i.value = BASE + offset
        dut.num_list_i.value, dut.num_records_i.value = count, self.records
        data = bytes(offset) + struct.pack(f"<{len(self.ids)}I", *self.ids)
        self.memory = ImageMemory(dut, data, BASE, **memory)
        self.events = Events(dut, "list")
        self.idle = Idle(
            dut, {"leaf": count_of("leaf_t")}, {"test": one, "return": count_of("return_t")}
        )
        self._start, self._rng = BASE + offset, rng

    def leaf(self, first, count):
        rng = self._rng
        return {
            "home": {"trv": rng.getrandbits(1), "slot": rng.getrandbits(3)},
            "first": first,
            "count": count,
            "operands": {"o": numbers().any_vec(rng), "d": numbers().any_vec(rng)},
            "tnear": numbers().any(rng),
            "tfar": numbers().any(rng),
        }

    def leaves(self, counts):
        for count in counts:
            yield self.leaf(self._rng.randrange(self.count - count + 1), count)

    def tests(self, leaf, good=lambda line: True):
        """The tests of a leaf as far as its entries are good, and how many are left."""
        shared = {k: leaf[k] for k in ("home", "operands", "tnear", "tfar")}
        tests = []
        for place in range(leaf["first"], leaf["first"] + leaf["count"]):
            if place >= self.count or self.ids[place] >= self.records or not good(self.line(place)):
                break
            tests.append(payloads().pack("test_t", shared, record=self.ids[place]))
        return tests, leaf["count"] - len(tests)

    def line(self, place):
        return self.memory.line_of(self._start + 4 * place)


def count_of(name):
    """The tests that a beat stands for."""
    return lambda bits: payloads().unpack(name, bits)["count"]


def packed(leaves):
    return [payloads().pack("leaf_t", leaf) for leaf in leaves]


def shown(name, beats):
    return [payloads().unpack(name, bits) for bits in beats]


async def check(dut, rng, listed, leaves, good=lambda line: True, p_valid=1.0, p_ready=1.0):
    """Send the leaves; every test and every error comes once, the tests of a leaf in order."""
    parts = [listed.tests(leaf, good) for leaf in leaves]
    want = [test for tests, _ in parts for test in tests]
    errors = [
        payloads().pack("return_t", home=leaf["home"], count=left, error=1)
        for leaf, (_, left) in zip(leaves, parts, strict=True)
        if left
    ]
    test_sink, return_sink = Sink(dut, "test"), Sink(dut, "return")
    cocotb.start_soon(Source(dut, "leaf").send(packed(leaves), stalls(rng, 1 - p_valid)))
    tasks = [
        cocotb.start_soon(sink.receive(len(beats), lambda: rng.random() < p_ready, PATIENCE))
        for sink, beats in ((test_sink, want), (return_sink, errors))
    ]
    got, failed = [await task for task in tasks]
    for sink in (test_sink, return_sink):
        await sink.expect_none(100)

    assert Counter(got) == Counter(want), shown("test_t", Counter(got) - Counter(want))
    assert Counter(failed) == Counter(errors), shown("return_t", failed)
    for tests, _ in parts:  # ids are all but unique, so a leaf's tests tell their order
        places = [got.index(test) for test in tests]
        assert len(set(tests)) < len(tests) or places == sorted(places)
    counts = listed.events.counts()
    assert counts["ids"] == len(want)
    assert counts["l1_accesses"] == len(want) + len(errors)
    assert counts["l1_accesses"] == sum(counts[f"l1_{k}"] for k in ("hits", "merged", "misses"))
    assert counts["l1_misses"] == len(listed.memory.asked)


@cocotb.test()
@cocotb.parametrize(p_valid=[1.0, 0.2], p_ready=[1.0, 0.3], latency=[1, 50])
async def sends_every_id_of_every_leaf_once(dut, p_valid, p_ready, latency):
    rng = await start(dut)
    listed = List(
        dut, rng, latency=lambda: rng.randint(1, latency), ready=lambda: rng.random() < 0.7
    )
    counts = [1, 1, 2, 15, 16, 17, 33, 600] + [rng.randint(1, 24) for _ in range(30)]

    await check(dut, rng, listed, list(listed.leaves(counts)), p_valid=p_valid, p_ready=p_ready)


@cocotb.test()
async def crosses_line_boundaries_at_every_place(dut):
    rng = await start(dut)
    listed = List(dut, rng)
    leaves = [listed.leaf(first, count) for first in range(34) for count in (1, 2, 17)]

    await check(dut, rng, listed, leaves)


@cocotb.test()
@cocotb.parametrize(p_ready=[1.0, 0.3])
async def an_error_accounts_for_the_tests_that_are_left(dut, p_ready):
    rng = await start(dut)
    bad = set()
    listed = List(dut, rng, fails=lambda line: line in bad)
    bad |= {listed.line(place) for place in range(20, 600, 90)}
    leaves = list(listed.leaves([1, 600, *(rng.randint(1, 60) for _ in range(40))]))
    edge = next(place for place in range(600) if listed.line(place) in bad)
    leaves += [
        listed.leaf(edge - before, before + left) for before in range(5) for left in range(1, 5)
    ]
    whole = [leaf for leaf in leaves if not listed.tests(leaf, lambda line: line not in bad)[1]]
    assert 5 < len(whole) < len(leaves) - 5

    await check(dut, rng, listed, leaves, lambda line: line not in bad, p_ready=p_ready)


@cocotb.test()
@cocotb.parametrize(p_ready=[1.0, 0.3])
async def an_id_that_names_no_record_ends_its_leaf_with_an_error(dut, p_ready):
    rng = await start(dut)
    beyond = [*range(7, 600, 60), 599]
    listed = List(dut, rng, beyond=beyond)
    leaves = [
        listed.leaf(max(b - before, 0), left)
        for b in beyond
        for before in (0, 1, 5)
        for left in (1, 2, 9)
    ]
    leaves = [leaf for leaf in leaves if leaf["first"] + leaf["count"] <= listed.count]
    whole = [leaf for leaf in leaves if not listed.tests(leaf)[1]]
    assert 5 < len(whole) < len(leaves) - 5

    await check(dut, rng, listed, leaves, p_ready=p_ready)


@cocotb.test()
@cocotb.parametrize(p_ready=[1.0, 0.3])
async def a_place_beyond_the_list_ends_its_leaf_with_an_error(dut, p_ready):
    """The entry behind the last one is in memory and names a record."""
    rng = await start(dut)
    listed = List(dut, rng)
    leaves = [
        listed.leaf(listed.count - n, n + more)
        for n in (0, 1, 2, 20)
        for more in range(3)
        if n + more
    ]
    leaves += [listed.leaf(first, 40) for first in (listed.count + 1, 1 << 30, (1 << 32) - 40)]
    whole = [leaf for leaf in leaves if not listed.tests(leaf)[1]]
    assert len(whole) == 3

    await check(dut, rng, listed, leaves, p_ready=p_ready)


@cocotb.test()
async def a_flush_makes_it_ask_for_its_lines_again(dut):
    rng = await start(dut)
    listed = List(dut, rng)
    source, sink = Source(dut, "leaf"), Sink(dut, "test")
    leaf = listed.leaf(0, 12)

    async def lines_asked_for():
        before = len(listed.memory.asked)
        cocotb.start_soon(source.send(packed([leaf])))
        assert await sink.receive(12) == listed.tests(leaf)[0]
        return listed.memory.asked[before:]

    async def flush():
        dut.flush_i.value = 1
        await RisingEdge(dut.clk_i)
        dut.flush_i.value = 0

    first = await lines_asked_for()
    assert first and await lines_asked_for() == []
    await flush()
    assert await lines_asked_for() == first


@cocotb.test()
async def tells_what_it_does_in_each_cycle(dut):
    """Nothing to do, an id at a time, a line that memory holds back, takers that wait."""
    rng = await start(dut)
    held = [False]
    listed = List(dut, rng, latency=lambda: None if held[0] else 5)
    source, events, memory = Source(dut, "leaf"), listed.events, listed.memory
    dut.test_ready_i.value = 1

    async def during(cycles):
        before = events.counts()
        await ClockCycles(dut.clk_i, cycles)
        return events.activities(before)

    assert await during(20) == {"empty": 20}

    held[0] = True
    cocotb.start_soon(source.send(packed([listed.leaf(0, 1)])))
    await ClockCycles(dut.clk_i, 10)
    assert await during(30) == {"memory": 30}
    memory.release(memory.held()[0])
    await ClockCycles(dut.clk_i, 10)
    held[0] = False

    cocotb.start_soon(source.send(packed([listed.leaf(0, 1)])))  # its line is in the L1
    assert await during(20) == {"empty": 1 + 15, "latency": 3, "works": 1}

    dut.test_ready_i.value = 0
    for first in (0, listed.count):  # a test waits, an error waits
        cocotb.start_soon(source.send(packed([listed.leaf(first, 1)])))
        await ClockCycles(dut.clk_i, 40)
        assert await during(30) == {"room": 30}
        dut.test_ready_i.value = 1
        await ClockCycles(dut.clk_i, 5)


@cocotb.test()
async def the_first_test_comes_four_cycles_after_its_leaf(dut):
    rng = await start(dut)
    listed = List(dut, rng)
    [leaf] = packed([listed.leaf(0, 1)])
    source, sink = Source(dut, "leaf"), Sink(dut, "test")
    cocotb.start_soon(source.send([leaf]))
    await sink.receive(1)  # the line is in the L1 now
    await ClockCycles(dut.clk_i, 5)

    taken, came = cycle(), None
    cocotb.start_soon(source.send([leaf]))
    dut.test_ready_i.value = 1
    while came is None:
        await ReadOnly()
        came = cycle() if dut.test_valid_o.value == 1 else None
        await RisingEdge(dut.clk_i)

    assert came - taken == 4  # queue 1, RA 2, operands 1


@cocotb.test(skip=parameter("NumSlots") < SLOTS_TO_FILL)
@cocotb.parametrize(count=[1, 5, 100])
async def sends_one_test_every_cycle(dut, count):
    """With all lines in the L1 and a leaf always waiting, over 500 cycles."""
    rng = await start(dut)
    listed = List(dut, rng, count=120)
    [whole], leaves = packed([listed.leaf(0, 120)]), packed(listed.leaves([count] * 30))
    dut.test_ready_i.value = 1
    source = Source(dut, "leaf")
    cocotb.start_soon(source.send([whole, *(rng.choice(leaves) for _ in range(10_000))]))

    await ClockCycles(dut.clk_i, 1500)
    before, since = listed.events.counts(), cycle()
    await ClockCycles(dut.clk_i, 500)
    done, until = listed.events.since(before), cycle()

    assert done["l1_misses"] == 0
    assert done["ids"] == done["works"] == until - since == 500


BUILDS = {
    "tiny": ("", {}),
    "large": ("list_rows=3", {"NumSlots": SLOTS_TO_FILL, "CacheBytes": 4096, "Ways": 4, "Rows": 3}),
    "lines": ("line_bytes=32 exp_bits=7 frac_bits=16", {"NumSlots": 3, "Rows": 1, "Ways": 1}),
}


@pytest.mark.parametrize("build", BUILDS)
def test_ti_list(build):
    overrides, params = BUILDS[build]
    run("ti_list", "test_ti_list", config=f"tiny {overrides}", params=params)
