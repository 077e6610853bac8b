# SPDX-License-Identifier: Apache-2.0
"""`ti_l1` finds what it was given, keeps it until it is the tree pseudo-LRU victim, spares pins."""

import cocotb
import pytest
from agents.bench import cycle, run, start
from cocotb.triggers import ReadOnly, RisingEdge
from models.cache import Cache
from models.payload import parameter

# CacheBytes, Ways, LineBytes, WordBytes: many sets and one, a single line, every depth of the tree.
SHAPES = [(256, 1, 64, 8), (16, 1, 16, 16), (256, 2, 32, 8), (128, 4, 16, 16), (128, 8, 16, 8)]
PULSES = ("touch_i", "alloc_i", "write_i", "fill_i", "unpin_i", "flush_i")
COMPARE = parameter("Compare", 0) == 1


class L1:
    """Plays the `ti_ra`: one look-up, use or fill at a time, each checked against the model."""

    def __init__(self, dut):
        self._dut = dut
        self.ways = int(dut.Ways.value)
        self._line_bytes, self._word_bytes = int(dut.LineBytes.value), int(dut.WordBytes.value)
        self.words = self._line_bytes // self._word_bytes
        self.sets = int(dut.CacheBytes.value) // (self.ways * self._line_bytes)
        self._cache = Cache(self.sets, self.ways)
        self._data = {}
        self._reserved = 0  # the last cycle of `alloc_i`

    async def _step(self, **ports):
        for name, value in ports.items():
            getattr(self._dut, name).value = value
        await RisingEdge(self._dut.clk_i)
        for name in ports:
            if name.endswith("_en_i") or name in PULSES:
                getattr(self._dut, name).value = 0

    async def look_up(self, line, settle=0):
        """Look `line` up; returns the way that holds it, or None.  `settle` extra cycles first."""
        await self._step(lookup_en_i=1, lookup_set_i=self._cache.set_of(line))
        if COMPARE:
            for _ in range(settle):
                await RisingEdge(self._dut.clk_i)
            await self._step(compare_en_i=1, compare_line_i=line)
        self._dut.line_i.value = line
        for _ in range(settle):
            await RisingEdge(self._dut.clk_i)
        return await self.see(line)

    async def see(self, line):
        """Check hit, way and victim of the look-up that stands."""
        await ReadOnly()
        hit = self._dut.hit_o.value == 1
        way = int(self._dut.hit_way_o.value) if hit else None
        victim = self._dut.victim_valid_o.value == 1
        victim_way = int(self._dut.victim_way_o.value) if victim else None
        await RisingEdge(self._dut.clk_i)
        assert way == self._cache.way_of(line), f"line {line:#x}"
        assert victim_way == self._cache.victim(line), f"line {line:#x}"
        return way

    async def use(self, line, way):
        """The hit of the look-up that stands is used: the line is read and touched."""
        place = self._cache.set_of(line), way
        await self._read(place, 0, touch_i=1, compare_en_i=1)
        self._cache.touch(line)
        for index in range(1, self.words):
            await self._read(place, index)

    async def use_and_see(self, line, way, then):
        """The hit of the look-up that stands is used as `then` is looked up."""
        await self._as_it_is_used(then, touch_i=1)
        self._cache.touch(line)
        return await self.see(then)

    async def alloc(self, line, then=None, early=False):
        """Reserve a place for the look-up that stands; look `then` up in the same cycle.

        With `early`, and a comparison of its own, its tags have been read before.
        """
        if then is None:
            await self._step(alloc_i=1, compare_en_i=1)
        else:
            await self._as_it_is_used(then, early, alloc_i=1)
        self._reserved = cycle() - 1
        return self._cache.alloc(line)

    async def _as_it_is_used(self, then, early=True, **ports):
        """Look `then` up in the cycle of `ports`."""
        look = {"lookup_en_i": 1, "lookup_set_i": self._cache.set_of(then)}
        compare = {"compare_en_i": 1, "compare_line_i": then}
        if not COMPARE:
            await self._step(**ports, **look)
        elif early:
            await self._step(**look)
            await self._step(**ports, **compare)
        else:
            await self._step(**ports, **look, compare_en_i=1)
            await self._step(**compare)
        self._dut.line_i.value = then

    async def fill(self, place, line, data, good=True, then=None):
        """The line has come; with `then`, as that is compared, its tags having been read."""
        if cycle() < self._reserved + 2:
            await RisingEdge(self._dut.clk_i)
        ports = {"fill_set_i": place[0], "fill_way_i": place[1]}
        for index in range(self.words):
            ports |= {"write_index_i": index, "write_word_i": self._word(data, index)}
            if index < self.words - 1:
                await self._step(**ports, write_i=1)
        ports |= {"write_i": 1, "fill_i": 1, "fill_good_i": int(good)}
        if then is None:
            await self._step(**ports)
        else:
            await self._as_it_is_used(then, **ports)
        self._cache.fill(place, line if good else None)
        self._data[place] = data

    async def drain(self, place):
        """Read a pinned place, as one that hands out does."""
        for index in range(self.words):
            await self._read(place, index)

    async def unpin(self, place):
        await self._step(unpin_i=1, unpin_set_i=place[0], unpin_way_i=place[1])
        self._cache.unpin(place)

    async def flush(self):
        """Nothing is pinned."""
        await self._step(flush_i=1)
        self._cache.flush()

    async def _read(self, place, index, **ports):
        """Read a word and check it."""
        ports |= {"read_set_i": place[0], "read_way_i": place[1], "read_index_i": index}
        await self._step(read_en_i=1, **ports)
        want = self._word(self._data[place], index)
        for _ in range(2):  # and it stays
            await ReadOnly()
            assert self._dut.word_o.value == want, f"place {place}, word {index}"
            await RisingEdge(self._dut.clk_i)

    def _word(self, data, index):
        return data >> 8 * self._word_bytes * index & ((1 << 8 * self._word_bytes) - 1)

    async def bring(self, line, data):
        """Miss, fill and unpin `line`."""
        assert await self.look_up(line) is None
        place = await self.alloc(line)
        await self.fill(place, line, data)
        await self.unpin(place)

    def line(self, set_, number):
        """The number-th line of a set."""
        return number * self.sets + set_

    def data(self, rng):
        return rng.getrandbits(8 * self._line_bytes)


@cocotb.test()
@cocotb.parametrize(lines_a_way=[1, 2, 8], p_error=[0.0, 0.3])
async def agrees_with_the_model_under_random_use(dut, lines_a_way, p_error):
    rng = await start(dut)
    l1 = L1(dut)
    lines = range(l1.sets * l1.ways * lines_a_way + 1)
    reserved, arrived = {}, []  # place -> line on its way; places that hand out
    for step in range(1, 801):
        settles = step % 200 > 150  # nothing new any more, then a flush
        if step % 200 == 0:
            assert not reserved and not arrived
            await l1.flush()
            continue
        choice = rng.random() / 2 if settles else rng.random()
        if reserved and choice < 0.3:
            place = rng.choice(list(reserved))
            line = reserved.pop(place)
            await l1.fill(place, line, l1.data(rng), good=rng.random() >= p_error)
            arrived.append(place)
        elif arrived and choice < 0.6:
            place = arrived.pop(rng.randrange(len(arrived)))
            await l1.drain(place)
            await l1.unpin(place)
        elif not settles:
            line = rng.choice(lines)
            way = await l1.look_up(line, settle=rng.randrange(2))
            if way is not None:
                await l1.use(line, way)
            elif line not in reserved.values() and dut.victim_valid_o.value == 1:
                reserved[await l1.alloc(line)] = line


@cocotb.test()
async def is_empty_after_reset(dut):
    rng = await start(dut)
    l1 = L1(dut)
    for number in range(l1.ways):
        await l1.bring(l1.line(0, number), l1.data(rng))
    dut.rst_ni.value = 0
    await RisingEdge(dut.clk_i)
    dut.rst_ni.value = 1

    fresh = L1(dut)
    for number in range(l1.ways):
        assert await fresh.look_up(l1.line(0, number)) is None


@cocotb.test()
async def is_empty_after_a_flush(dut):
    rng = await start(dut)
    l1 = L1(dut)
    lines = [l1.line(s, number) for s in range(l1.sets) for number in range(l1.ways)]
    for _ in range(3):
        for line in lines:
            await l1.bring(line, l1.data(rng))  # misses
        await l1.flush()
    for line in lines:
        assert await l1.look_up(line) is None


@cocotb.test()
async def keeps_a_full_set_and_every_other_set(dut):
    rng = await start(dut)
    l1 = L1(dut)
    lines = [l1.line(s, number) for s in range(l1.sets) for number in range(l1.ways)]
    for line in lines:
        await l1.bring(line, l1.data(rng))

    for line in lines:
        way = await l1.look_up(line)
        assert way is not None
        await l1.use(line, way)


@cocotb.test()
async def tells_the_highest_line_from_the_lowest(dut):
    rng = await start(dut)
    l1 = L1(dut)
    top = (1 << int(dut.LineAddrWidth.value)) - 1
    line = top // l1.sets * l1.sets  # set 0, tag all ones
    await l1.bring(line, l1.data(rng))

    assert await l1.look_up(l1.line(0, 0)) is None
    for bit in range(l1.sets.bit_length() - 1, int(dut.LineAddrWidth.value)):
        assert await l1.look_up(line ^ 1 << bit) is None, f"bit {bit} of the tag is not compared"
    assert await l1.look_up(line) is not None


@cocotb.test(skip=parameter("Ways") == 1)
async def spares_the_way_used_last(dut):
    rng = await start(dut)
    l1 = L1(dut)
    for number in range(l1.ways):
        await l1.bring(l1.line(0, number), l1.data(rng))
    for extra in range(4 * l1.ways):  # the storm passes, the line that is used stays
        way = await l1.look_up(l1.line(0, 0))
        assert way is not None, f"gone after {extra} other lines"
        await l1.use(l1.line(0, 0), way)
        await l1.bring(l1.line(0, l1.ways + extra), l1.data(rng))


@cocotb.test()
async def has_no_victim_while_all_ways_are_pinned(dut):
    rng = await start(dut)
    l1 = L1(dut)
    places = {}
    for number in range(l1.ways):
        assert await l1.look_up(l1.line(0, number)) is None
        places[number] = await l1.alloc(l1.line(0, number))
    assert len(set(places.values())) == l1.ways

    await l1.look_up(l1.line(0, 99))
    assert dut.victim_valid_o.value == 0
    last = l1.ways - 1
    await l1.fill(places[last], l1.line(0, last), l1.data(rng))
    await l1.see(l1.line(0, 99))
    assert dut.victim_valid_o.value == 0, "a line that hands out is pinned still"
    await l1.unpin(places[last])
    await l1.see(l1.line(0, 99))
    assert dut.victim_valid_o.value == 1


@cocotb.test()
@cocotb.parametrize(early=[False, True] if COMPARE else [False])
async def sees_a_set_as_the_write_in_the_same_cycle_leaves_it(dut, early):
    rng = await start(dut)
    l1 = L1(dut)
    old, new = l1.line(0, 1), l1.line(0, 2)
    await l1.bring(old, l1.data(rng))
    await l1.look_up(new)
    place = await l1.alloc(new, then=old, early=early)
    await l1.see(old)  # gone with the only way, else it stays
    await l1.fill(place, new, l1.data(rng))
    await l1.unpin(place)

    last = l1.line(0, 3)
    await l1.look_up(last)
    place = await l1.alloc(last, then=last, early=early)
    assert await l1.see(last) is None  # reserved, not there yet
    await l1.fill(place, last, l1.data(rng))
    assert await l1.see(last) is not None
    await l1.unpin(place)
    await l1.see(last)


@cocotb.test()
async def sees_a_set_as_a_fill_or_a_hit_in_the_same_cycle_leaves_it(dut):
    rng = await start(dut)
    l1 = L1(dut)
    for number in range(3 * l1.ways):
        line = l1.line(0, number)
        await l1.look_up(line)
        place = await l1.alloc(line)
        await l1.fill(place, line, l1.data(rng), good=number % 2 == 0, then=line)
        way = await l1.see(line)
        if way is not None:  # another line of the set: its victim depends on this hit
            await l1.use_and_see(line, way, l1.line(0, 99))
        await l1.unpin(place)
        await l1.see(l1.line(0, 99) if way is not None else line)


@pytest.mark.parametrize("compare", [0, 1])
@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: "-".join(map(str, shape)))
def test_ti_l1(shape, compare):
    names = ("CacheBytes", "Ways", "LineBytes", "WordBytes")
    run("ti_l1", "test_ti_l1", params=dict(zip(names, shape, strict=True)), Compare=compare)
