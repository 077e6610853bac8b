# SPDX-License-Identifier: Apache-2.0
"""`ti_rd` deals rays that meet the scene to homes in tiles, and answers the others, in order."""

import cocotb
import pytest
from agents.bench import cycle, run, start
from agents.events import Events
from agents.stream import Sink, Source, stalls
from cocotb.triggers import ClockCycles, ReadOnly, RisingEdge
from models.numbers import hexed, numbers
from models.payload import parameter, payloads
from models.rays import clip, dispatched, random_ray, ray, setup_cases, unit_box

INVALID_RAY = 1


class Homes:
    """The homes: each has room for `slots` rays, or a list of that, one a home.

    A place comes back `busy()` cycles after it was taken, or never for None.  `dealt` lists
    (cycle, home, dispatch) as they come.
    """

    def __init__(self, dut, slots=1, busy=lambda: 0):
        self._dut, self._busy = dut, busy
        count = int(dut.NumTrv.value)
        self._room = list(slots) if isinstance(slots, list) else [slots] * count
        self._back = []  # (cycle, home)
        self.dealt = []
        cocotb.start_soon(self._run())

    async def _run(self):
        dut = self._dut
        while True:
            for due in [b for b in self._back if b[0] <= cycle()]:
                self._back.remove(due)
                self._room[due[1]] += 1
            ready = sum((room > 0) << home for home, room in enumerate(self._room))
            dut.dispatch_ready_i.value = ready
            await ReadOnly()
            valid = int(dut.dispatch_valid_o.value)
            assert valid & ~ready == 0, "dealt to a home without room"
            if valid:
                home = valid.bit_length() - 1
                assert valid == 1 << home, f"dealt to several homes: {valid:#b}"
                self.dealt.append((cycle(), home, int(dut.dispatch_data_o.value)))
                self._room[home] -= 1
                busy = self._busy()
                if busy is not None:
                    self._back.append((cycle() + 1 + busy, home))
            await RisingEdge(dut.clk_i)


async def setup(dut, **homes):
    rng = await start(dut)
    for port, corner in zip((dut.box_lo_i, dut.box_hi_i), unit_box(), strict=True):
        port.value = payloads().pack_vec(corner)
    events = Events(dut, "rd")
    return rng, Homes(dut, **{k: make(rng) for k, make in homes.items()}), events


def packed(rays):
    """The rays as beats; their number is their id."""
    for ray_id, given in enumerate(rays):
        yield payloads().pack("ray_t", given, ray_id=ray_id, any_hit=ray_id & 1)


def expected(ray_id, given):
    """("dispatch_t" or "hit_t", the beat)."""
    miss, status, inv, tmin, tmax = clip(*unit_box(), given)
    if ray_id & 1 and not parameter("AnyHit", 1):
        miss, status = 1, INVALID_RAY
    if miss:
        values = {"status": status, "prim": (1 << 32) - 1, "t": numbers().inf}
        return "hit_t", payloads().pack("hit_t", values, ray_id=ray_id)
    return "dispatch_t", dispatched(unit_box(), given, inv, tmin, tmax, ray_id, ray_id & 1)


def inside():
    """A ray that enters the box."""
    n = numbers()
    return ray(n.vec((0, 0, 0)), n.vec((0, 0, 1)))


def outside():
    """One that misses it."""
    n = numbers()
    return ray(n.vec((5, 0, 0)), n.vec((0, 0, 1)))


async def all_of(dut, rng, rays, homes, events, p_valid=1.0, p_ready=1.0):
    """Send the rays, check that each came out once, right and counted."""
    want = [expected(i, given) for i, given in enumerate(rays)]
    misses = [beat for kind, beat in want if kind == "hit_t"]
    deals = [beat for kind, beat in want if kind == "dispatch_t"]
    sink = Sink(dut, "hit")
    cocotb.start_soon(Source(dut, "ray").send(packed(rays), stalls(rng, 1 - p_valid)))
    got = await sink.receive(len(misses), ready=lambda: rng.random() < p_ready)
    for _ in range(20_000):
        if len(homes.dealt) == len(deals):
            break
        await RisingEdge(dut.clk_i)
    await sink.expect_none(2 * int(dut.Latency.value))
    for have, name in ((got, "hit_t"), ([beat for _, _, beat in homes.dealt], "dispatch_t")):
        for bits, beat in zip(have, misses if name == "hit_t" else deals, strict=True):
            shown = [hexed(payloads().unpack(name, b)) for b in (beat, bits)]
            assert bits == beat, f"want {shown[0]}, got {shown[1]}"
    counts = events.counts()
    assert (counts["rays"], counts["misses"]) == (len(rays), len(misses))


@cocotb.test()
@cocotb.parametrize(p_valid=[1.0, 0.2], p_ready=[1.0, 0.3], busy=[0, 60])
async def every_ray_leaves_once_and_in_order(dut, p_valid, p_ready, busy):
    """Misses and deals each in the order of the rays, whatever stalls."""
    rng, homes, events = await setup(dut, busy=lambda rng: lambda: rng.randint(0, busy))
    rays = [random_ray(rng) for _ in range(100)]
    rays += [given for _, _, given in rng.sample(list(setup_cases(rng, 0)), 120)]
    rng.shuffle(rays)

    await all_of(dut, rng, rays, homes, events, p_valid, p_ready)


@cocotb.test()
async def hits_and_misses_leave_in_one_order(dut):
    """A miss behind a ray that waits for a home waits with it."""
    rng, homes, _ = await setup(dut, busy=lambda rng: lambda: rng.randint(0, 30))
    kinds = [rng.random() < 0.5 for _ in range(200)]
    dut.hit_ready_i.value = 1
    rays = packed(inside() if k else outside() for k in kinds)
    cocotb.start_soon(Source(dut, "ray").send(rays))

    order = []
    idle = 0  # cycles since the last one left; longer than any waits for a home
    while idle < 300:
        await ReadOnly()
        idle += 1
        if dut.hit_valid_o.value:
            order.append(payloads().unpack("hit_t", int(dut.hit_data_o.value))["ray_id"])
            idle = 0
        elif int(dut.dispatch_valid_o.value):
            beat = payloads().unpack("dispatch_t", int(dut.dispatch_data_o.value))
            order.append(beat["ray_id"])
            idle = 0
        await RisingEdge(dut.clk_i)

    assert order == list(range(200))
    assert len(homes.dealt) == sum(kinds)


async def taken_without_pause(dut, rays):
    """The cycles in which the rays are taken when one always waits."""
    todo, taken = list(packed(rays)), []
    while todo:
        dut.ray_valid_i.value = 1
        dut.ray_data_i.value = todo[0]
        await ReadOnly()
        if dut.ray_ready_o.value == 1:
            taken.append(cycle())
            todo.pop(0)
        await RisingEdge(dut.clk_i)
    dut.ray_valid_i.value = 0
    await ClockCycles(dut.clk_i, int(dut.Latency.value) + 8)
    return taken


@cocotb.test()
async def takes_a_ray_in_its_cycles_and_gives_it_after_its_latency(dut):
    """More rays than there are credits: each comes back in time."""
    _, homes, events = await setup(dut, slots=lambda _: 1000)
    steps, count = int(dut.RayCycles.value), 6 * int(dut.Depth.value)

    taken = await taken_without_pause(dut, [inside()] * count)

    assert taken == list(range(taken[0], taken[0] + steps * count, steps))
    assert [at for at, _, _ in homes.dealt] == [at + int(dut.Latency.value) for at in taken]
    assert events.counts()["works"] == steps * count


@cocotb.test()
async def the_latency_is_that_of_its_steps(dut):
    """Accept, three axes, gather, check, queue: the same for each number of cycles a ray."""
    await start(dut)
    arithmetic, check = int(dut.u_clip.AxisLatency.value), int(dut.u_clip.CheckLatency.value)

    thick, shear = int(dut.ThickLatency.value), int(dut.ShearLatency.value)
    assert int(dut.Latency.value) == arithmetic + 5 + check + thick + shear
    assert (thick > 0, shear > 0) == (bool(int(dut.Padded.value)), bool(int(dut.Woop.value)))
    assert int(dut.u_clip.Lanes.value) == 4 - int(dut.RayCycles.value)


@cocotb.test()
async def misses_leave_at_the_rate_of_rays(dut):
    rng, _, _ = await setup(dut, slots=lambda _: 1000)
    steps, count = int(dut.RayCycles.value), 4 * int(dut.Depth.value)
    dut.hit_ready_i.value = 1

    taken = await taken_without_pause(dut, [rng.choice((inside, outside))() for _ in range(count)])

    assert taken == list(range(taken[0], taken[0] + steps * count, steps))


@cocotb.test()
async def keeps_its_rate_while_seven_rays_wait(dut):
    """There are credits for them beside those of the pipeline."""
    _, homes, _ = await setup(dut, slots=lambda _: [0] * int(dut.NumTrv.value))
    steps, count = int(dut.RayCycles.value), 4 * int(dut.Depth.value)
    task = cocotb.start_soon(taken_without_pause(dut, [inside()] * count))
    await ClockCycles(dut.clk_i, int(dut.Latency.value) + 7 * steps - 1)
    homes._room = [1000] * int(dut.NumTrv.value)

    taken = await task

    assert taken == list(range(taken[0], taken[0] + steps * count, steps))
    assert homes.dealt[0][0] - taken[0] >= int(dut.Latency.value) + 7 * steps - 1


@cocotb.test(skip=parameter("NumTrv") < 2)
async def rays_that_wait_are_dealt_one_a_cycle(dut):
    """But for the cycle in which a home is found full."""
    _, homes, _ = await setup(dut, slots=lambda _: [0] * int(dut.NumTrv.value))
    tile, count, depth = (int(dut[x].value) for x in ("DealTile", "NumTrv", "Depth"))
    cocotb.start_soon(Source(dut, "ray").send(packed([inside()] * depth)))
    await ClockCycles(dut.clk_i, 4 * depth + int(dut.Latency.value))
    assert not homes.dealt
    homes._busy = lambda: None
    homes._room = [1] + [1000] * (count - 1)
    await ClockCycles(dut.clk_i, 3 * depth)

    full = tile > 1  # a tile of one ray ends before its home is found full
    assert len(homes.dealt) == depth
    assert homes.dealt[-1][0] - homes.dealt[0][0] + 1 == depth + full


def dealing(rooms, tile, count):
    """The homes of `count` rays that enter the box, by the rule of the tiles."""
    rooms, home, dealt, homes = list(rooms), 0, 0, []

    def next_home():
        others = [(home + 1 + i) % len(rooms) for i in range(len(rooms))]
        return next((h for h in others if rooms[h]), home), 0

    for _ in range(count):
        if not rooms[home]:
            home, dealt = next_home()
        homes.append(home)
        rooms[home] -= 1
        dealt += 1
        if dealt == tile:
            home, dealt = next_home()
    return homes


@cocotb.test()
@cocotb.parametrize(p_miss=[0.0, 0.6], held=[False, True])
async def deals_in_tiles_in_turn_while_homes_have_room(dut, p_miss, held):
    """Rays that miss in between do not end a tile, whether rays wait to be dealt or not."""
    rng, homes, events = await setup(dut, slots=lambda _: 1000)
    tile, count = int(dut.DealTile.value), int(dut.NumTrv.value)
    rays = [outside() if rng.random() < p_miss else inside() for _ in range(4 * tile * count)]
    rays[0] = outside()  # held, it makes the rays behind it wait
    dut.hit_ready_i.value = 0

    await all_of(dut, rng, rays, homes, events, p_ready=0.01 if held else 1.0)

    enter = len(homes.dealt)
    assert [home for _, home, _ in homes.dealt] == dealing([1000] * count, tile, enter)
    assert [home for _, home, _ in homes.dealt] == [i // tile % count for i in range(enter)]
    together = [b - a for (a, _, _), (b, _, _) in zip(homes.dealt, homes.dealt[1:], strict=False)]
    in_a_row = held or int(dut.RayCycles.value) == 1
    assert (1 in together) == in_a_row, "held rays are dealt in consecutive cycles"


@cocotb.test(skip=parameter("NumTrv") < 2)
@cocotb.parametrize(seed=range(6))
async def a_full_home_ends_its_tile(dut, seed):
    """The next home with room starts a tile of its own; rooms do not come back here."""
    rng, homes, events = await setup(dut)
    tile, count = int(dut.DealTile.value), int(dut.NumTrv.value)
    rng.seed(seed)
    rooms = [rng.randint(0, 3 * tile + 1) for _ in range(count)]
    homes._room, homes._busy = list(rooms), lambda: None
    rays = [inside() if rng.random() < 0.7 else outside() for _ in range(8 * tile * count)]
    enter = [i for i, given in enumerate(rays) if given == inside()]
    rays = rays[: enter[sum(rooms)]]  # as many as there is room for

    await all_of(dut, rng, rays, homes, events)

    assert [home for _, home, _ in homes.dealt] == dealing(rooms, tile, sum(rooms))


@cocotb.test()
async def passes_over_homes_without_room(dut):
    count = int(dut.NumTrv.value)
    rooms = [0] * (count - 1) + [1000]
    rng, homes, events = await setup(dut, slots=lambda _: rooms)

    await all_of(dut, rng, [inside()] * 40, homes, events)

    assert {home for _, home, _ in homes.dealt} == {count - 1}


@cocotb.test()
async def tells_what_it_does_in_each_cycle(dut):
    """Nothing to do, a ray at a time, rays without pause, a home or a taker that waits."""
    _, homes, events = await setup(dut, slots=lambda _: [0] * int(dut.NumTrv.value))
    source, latency = Source(dut, "ray"), int(dut.Latency.value)

    async def during(cycles):
        before = events.counts()
        await ClockCycles(dut.clk_i, cycles)
        return events.activities(before)

    assert await during(20) == {"empty": 20}

    dut.hit_ready_i.value = 1
    before = events.counts()
    await source.send(packed([outside()]))
    await ClockCycles(dut.clk_i, 2 * latency)
    works = int(dut.RayCycles.value)
    assert events.activities(before) == {
        "empty": 1 + latency,  # the cycle in which it is taken, and after its hit
        "works": works,
        "latency": latency - works,
    }

    task = cocotb.start_soon(source.send(packed([outside()] * (250 // works))))
    await ClockCycles(dut.clk_i, 50)
    assert await during(100) == {"works": 100}
    await task
    await ClockCycles(dut.clk_i, 2 * latency)

    for given in (inside(), outside()):
        dut.hit_ready_i.value = 0
        depth = int(dut.Depth.value)
        cocotb.start_soon(source.send(packed([given] * depth)))
        await ClockCycles(dut.clk_i, 100)
        assert await during(30) == {"room": 30}
        homes._room = [depth] * int(dut.NumTrv.value)
        dut.hit_ready_i.value = 1
        await ClockCycles(dut.clk_i, 50)


@pytest.mark.parametrize(
    "params",
    [
        {"RayCycles": 3},
        {"RayCycles": 1},
        {"RayCycles": 3, "NumTrv": 3, "DealTile": 4},
        {"RayCycles": 2, "NumTrv": 3, "DealTile": 4},
        {"RayCycles": 1, "NumTrv": 3, "DealTile": 4},
        {"RayCycles": 1, "NumTrv": 4, "DealTile": 1},
    ],
    ids=lambda params: "-".join(map(str, params.values())),
)
def test_ti_rd(params):
    run("ti_rd", "test_ti_rd", params=params)


def test_ti_rd_without_any_hit_rays():
    """Every second ray is an any-hit ray, and invalid."""
    run("ti_rd", "test_ti_rd", params={"NumTrv": 3, "AnyHit": 0}, only="every_ray_leaves")


@pytest.mark.parametrize("ray_cycles", [1, 3])
def test_ti_rd_of_the_watertight_machine(ray_cycles):
    """Thick rays with the constants of Woop's test."""
    config = "tiny traversal=padded triangle_test=woop"
    run("ti_rd", "test_ti_rd", config=config, params={"NumTrv": 3, "RayCycles": ray_cycles})


@pytest.mark.parametrize("ray_cycles", [1, 3])
def test_ti_rd_of_deep_operators(ray_cycles):
    """The longest latency that a configuration can ask for."""
    deepest = "fp_add_stages=10 fp_mul_stages=8 fp_rcp_bits_per_stage=1 fp_rcp_end_stages=5"
    deepest += " fp_cmp_stages=1 lookup_stages=4"
    only = "takes_a_ray_in|the_latency_is|keeps_its_rate|misses_leave"
    config = f"tiny {deepest}"
    run("ti_rd", "test_ti_rd", config=config, params={"RayCycles": ray_cycles}, only=only)
