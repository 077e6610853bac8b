# SPDX-License-Identifier: Apache-2.0
"""`ti_trv_return` takes a token a cycle, keeps the best hits, and ends each ray once."""

import cocotb
import pytest
from agents.bench import cycle, only_if, run, start
from agents.stream import Sink, Source
from agents.way_home import (
    MEMORY_ERROR,
    NO_PRIM,
    Expected,
    Leaf,
    Story,
    done,
    hit,
    miss,
    packed,
    park,
    random_story,
    tell,
)
from cocotb.triggers import ClockCycles, ReadOnly, RisingEdge
from models.numbers import numbers
from models.payload import parameter, payloads


@cocotb.test()
@cocotb.parametrize(p_ready=[1.0, 0.2, 0.05], p_gap=[0.0, 0.5])
async def every_ray_ends_once_by_the_rules(dut, p_ready, p_gap):
    """Each token is taken at once, however long hits wait."""
    await tell(dut, lambda rng: [random_story(rng) for _ in range(400)], p_ready, p_gap)


@cocotb.test()
async def the_least_prim_wins_a_tie_in_any_order(dut):
    def stories(rng):
        n = numbers()
        for t in (n.one, 0, n.inf - 1):
            for _ in range(20):
                prims = rng.sample(range(1 << 31), 5) + [0, NO_PRIM - 1][: rng.randint(0, 2)]
                rng.shuffle(prims)
                signs = (0, n.sign) if t == 0 else (0,)  # -0 equals 0
                yield Story([Leaf([hit(t | rng.choice(signs), p) for p in prims], n.inf)])

    await tell(dut, lambda rng: list(stories(rng)))


@cocotb.test()
async def both_ends_of_the_interval_belong_to_it(dut):
    n = numbers()
    one, two = n.one, n.of(2.0)
    places = [one - 1, one, one + 1, two - 1, two, two + 1]
    stories = [Story([Leaf([hit(t, 5)], n.inf)], tmin=one, tmax=two) for t in places]
    assert [Expected(story).hit["hit"] for story in stories] == [0, 1, 1, 1, 1, 0]

    await tell(dut, stories)


@cocotb.test()
async def a_leaf_ends_the_ray_only_when_the_best_hit_is_not_beyond_it(dut):
    n = numbers()
    one = n.one
    stories = [
        Story([Leaf([hit(t, 5), miss(3)], one, next=44, restart=r), Leaf([miss()], n.inf)])
        for t in (one - 1, one, one + 1)
        for r in (0, 1)
    ]
    assert [len(Expected(story).resumes) for story in stories] == [0, 0, 0, 0, 1, 1]

    await tell(dut, stories)


@only_if(parameter("AnyHit", 1))
async def an_any_hit_ray_ends_at_the_leaf_of_its_first_hit_and_reports_only_that(dut):
    n = numbers()
    far = n.of(100.0)
    leaves = [Leaf([miss(), miss()], n.one), Leaf([hit(far, 9), miss()], n.one), Leaf([miss()], 0)]
    story = Story(leaves, any_hit=1)
    expected = Expected(story)
    assert len(expected.resumes) == 1
    assert expected.hit["hit"] == 1 and expected.hit["t"] == expected.hit["prim"] == 0

    await tell(dut, [story])


@cocotb.test()
@cocotb.parametrize(place=[0, 1, 2])
async def a_memory_error_ends_the_ray_after_all_tests_without_a_hit(dut, place):
    """The error is the first token of the leaf, in the middle, or the last."""
    n = numbers()
    tokens = [hit(n.one, 3), miss(2)]
    tokens.insert(place, miss(7, error=1))
    leaf = Leaf(tokens, n.inf, steps=77)
    after = Leaf([hit(n.one, 3)], n.inf)  # the slot forgets the error
    stories = [Story([each]) for _ in range(20) for each in (leaf, after)]
    assert Expected(stories[0]).hit["status"] == MEMORY_ERROR

    await tell(dut, stories)


async def start_slot(dut, slot, ray_id=0):
    dut.start_tmax_i.value = numbers().inf
    dut.start_slot_i.value, dut.start_ray_id_i.value, dut.start_i.value = slot, ray_id, 1
    await RisingEdge(dut.clk_i)
    dut.start_i.value = 0


async def park_slot(dut, slot, leaf):
    park(dut, slot, leaf)
    await RisingEdge(dut.clk_i)
    dut.park_i.value = 0


async def done_slot(dut, slot):
    done(dut, slot)
    await RisingEdge(dut.clk_i)
    dut.done_i.value = 0


async def parked(dut, count, slots=1):
    """Slots with a ray each in a leaf of that many tests, and the source of their tokens."""
    await start(dut)
    dut.hit_ready_i.value = 1
    for slot in range(slots):
        await start_slot(dut, slot, slot)
        await park_slot(dut, slot, Leaf([miss(count)], numbers().inf))
    return Source(dut, "return")


@cocotb.test()
@cocotb.parametrize(what=["miss", "far", "hit", "error"], which=["one slot", "all slots"])
async def takes_a_token_in_every_cycle_whatever_it_is(dut, what, which):
    """Better hits, hits that are no better, misses, errors."""
    n = numbers()
    slots = int(dut.NumSlots.value) if which == "all slots" else 1
    source = await parked(dut, 60_000, slots)
    times = {"hit": [n.inf - 1 - i for i in range(200)], "far": [n.one] + [n.of(2.0)] * 199}
    kinds = {"hit": hit(0, 5), "far": hit(0, 5), "miss": miss(), "error": miss(error=1)}
    tokens = [{**kinds[what], "t": t} for t in times.get(what, [0] * 200)]

    since = cycle()
    await source.send([packed(i % slots, token) for i, token in enumerate(tokens)], patience=1)
    assert cycle() - since == len(tokens)


@cocotb.test()
@cocotb.parametrize(go=[0, 1], p_ready=[0, 1])
async def takes_the_last_token_of_a_leaf_in_every_cycle(dut, go, p_ready):
    """All slots end their leaves in a row, while the hits before them wait or leave."""
    slots, n = int(dut.NumSlots.value), numbers()
    await start(dut)
    source = Source(dut, "return")
    dut.hit_ready_i.value = p_ready
    for slot in range(slots):
        await start_slot(dut, slot)
        # Some tests of each are back.
        await park_slot(dut, slot, Leaf([miss(4)], n.one, go=go, next=100 + slot))
        await source.send([packed(slot, hit(n.of(2.0), 7)), packed(slot, miss(2))])
    ended = []

    async def watch():
        while True:
            await ReadOnly()
            if dut.resume_o.value == 1:
                ended.append((cycle(), int(dut.resume_node_o.value)))
            if dut.hit_valid_o.value == 1:
                ended.append((cycle(), "hit"))
            await RisingEdge(dut.clk_i)

    cocotb.start_soon(watch())
    since = cycle()
    await source.send([packed(slot, miss()) for slot in range(slots)], patience=1)
    assert cycle() - since == slots
    await ClockCycles(dut.clk_i, 20)
    first = since + int(dut.LeafLatency.value)
    if go:
        assert ended == [(first + slot, 100 + slot) for slot in range(slots)]
    elif p_ready:
        retire = int(dut.u_retire.Latency.value)
        assert ended == [(first + retire + slot, "hit") for slot in range(slots)]
    else:
        dut.hit_ready_i.value = 1
        sink = Sink(dut, "hit")
        hits = [payloads().unpack("hit_t", beat) for beat in await sink.receive(slots)]
        assert all(h["prim"] == 7 and h["hit"] == 1 for h in hits)


@cocotb.test()
async def a_slot_can_park_again_right_after_it_goes_on(dut):
    """Nothing of the leaf before it is left in its count."""
    await start(dut)
    source = Source(dut, "return")
    await start_slot(dut, 0)
    for count in (2, 1, 3, 1, 1, 2):
        await park_slot(dut, 0, Leaf([miss(count)], 0, next=count))
        await source.send([packed(0, miss())] * count, patience=1)
        for _ in range(int(dut.LeafLatency.value) - 1):
            await ReadOnly()
            assert dut.resume_o.value == 0
            await RisingEdge(dut.clk_i)
        await ReadOnly()
        assert dut.resume_o.value == 1 and int(dut.resume_node_o.value) == count
        await RisingEdge(dut.clk_i)


@cocotb.test()
async def tokens_and_slots_that_are_done_go_side_by_side(dut):
    """A token and a done slot in each cycle; neither takes the other's turn."""
    slots = int(dut.NumSlots.value)
    source = await parked(dut, 1000)
    for slot in range(1, slots):
        await start_slot(dut, slot, ray_id=slot)
    since, sink = cycle(), Sink(dut, "hit")
    tokens = cocotb.start_soon(source.send([packed(0, miss())] * 3 * slots, patience=1))
    taken = cocotb.start_soon(sink.receive(slots - 1))
    for slot in range(1, slots):
        await done_slot(dut, slot)
    hits = [payloads().unpack("hit_t", beat)["ray_id"] for beat in await taken]
    assert hits == list(range(1, slots))
    assert cycle() - since == slots - 1 + int(dut.u_retire.Latency.value)
    await tokens
    assert cycle() - since == 3 * slots


@cocotb.test()
async def tokens_wait_for_nothing(dut):
    """A hit is not taken: tokens and all slots but two go on to their ends; each comes out once."""
    slots, n = int(dut.NumSlots.value), numbers()
    source = await parked(dut, 3, slots)
    dut.hit_ready_i.value = 0
    order = [packed(slot, hit(n.of(k), slot)) for slot in range(slots) for k in (3, 1, 2)]
    await source.send(order, patience=1)
    await ClockCycles(dut.clk_i, 20)
    await ReadOnly()
    assert dut.hit_valid_o.value == 1 and dut.free_o.value == 0
    await RisingEdge(dut.clk_i)

    sink = Sink(dut, "hit")
    hits = [payloads().unpack("hit_t", beat) for beat in await sink.receive(slots)]
    await sink.expect_none(20)
    assert [h["ray_id"] for h in hits] == list(range(slots))
    assert all(h["t"] == n.one and h["prim"] == h["ray_id"] for h in hits)


@cocotb.test()
async def offers_the_best_t_to_the_step_pipeline(dut):
    source = await parked(dut, 100)
    n = numbers()

    async def best():
        dut.tbest_slot_i.value, dut.tbest_read_i.value = 0, 1
        await RisingEdge(dut.clk_i)
        dut.tbest_read_i.value = 0
        await ReadOnly()
        value = int(dut.tbest_o.value)
        await RisingEdge(dut.clk_i)
        return value

    assert await best() == n.inf
    for t, want in [(5.0, 5.0), (7.0, 5.0), (3.0, 3.0), (3.0, 3.0)]:
        await source.send([packed(0, hit(n.of(t), 1))])
        await ClockCycles(dut.clk_i, 5)
        assert await best() == n.of(want)


@pytest.mark.parametrize(
    ("slots", "any_hit", "cmp"), [(8, 0, 0), (2, 1, 0), (8, 1, 0), (2, 1, 1), (8, 0, 1)]
)
def test_ti_trv_return(slots, any_hit, cmp):
    params = {"NumSlots": slots, "AnyHit": any_hit, "CmpStages": cmp}
    run("ti_trv_return", "test_ti_trv_return", config=f"tiny trv_slots={slots}", params=params)
