# SPDX-License-Identifier: Apache-2.0
"""`ti_rd` deals each ray that meets the scene to one home with room and answers the others."""

import cocotb
import pytest
from agents.bench import cycle, run, start
from agents.stream import Sink, Source, stalls
from cocotb.triggers import ReadOnly, RisingEdge
from models.numbers import hexed, numbers
from models.payload import payloads
from models.rays import clip, random_ray, ray, setup_cases, unit_box


class Homes:
    """The homes: each has room for `slots` rays, and gets a place back after `busy()` cycles.

    `closed` homes never have room.  `dealt` lists (cycle, home, dispatch) as they come.
    """

    def __init__(self, dut, slots=1, busy=lambda: 0, closed=()):
        self._dut, self._busy = dut, busy
        self._room = [0 if h in closed else slots for h in range(int(dut.NumTrv.value))]
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
                self._back.append((cycle() + 1 + self._busy(), home))
            await RisingEdge(dut.clk_i)


async def setup(dut, **homes):
    rng = await start(dut)
    for port, corner in zip((dut.box_lo_i, dut.box_hi_i), unit_box(), strict=True):
        port.value = payloads().pack_vec(corner)
    return rng, Homes(dut, **{k: make(rng) for k, make in homes.items()})


def packed(rays):
    """The rays as beats; their number is their id."""
    for ray_id, given in enumerate(rays):
        yield payloads().pack("ray_t", given, ray_id=ray_id, any_hit=ray_id & 1)


def expected(ray_id, given):
    """("dispatch_t" or "hit_t", the beat)."""
    p = payloads()
    miss, status, inv, tmin, tmax = clip(*unit_box(), given)
    if miss:
        beat = p.pack("hit_t", ray_id=ray_id, status=status, prim=(1 << 32) - 1, t=numbers().inf)
        return "hit_t", beat
    whole = {"ray_id": ray_id, "any_hit": ray_id & 1, **given}
    return "dispatch_t", p.pack("dispatch_t", ray=whole, inv=inv, tmin=tmin, tmax=tmax)


async def all_of(dut, rng, rays, homes, p_valid=1.0, p_ready=1.0):
    """Send the rays, check that each came out once and right; the misses' and homes' beats."""
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


@cocotb.test()
@cocotb.parametrize(p_valid=[1.0, 0.2], p_ready=[1.0, 0.3], busy=[0, 60])
async def every_ray_leaves_once_and_in_order(dut, p_valid, p_ready, busy):
    """Misses and deals each in the order of the rays, whatever stalls."""
    rng, homes = await setup(dut, busy=lambda rng: lambda: rng.randint(0, busy))
    rays = [random_ray(rng) for _ in range(300)]
    rays += [given for _, _, given in rng.sample(list(setup_cases(rng, 0)), 300)]
    rng.shuffle(rays)

    await all_of(dut, rng, rays, homes, p_valid, p_ready)


@cocotb.test()
async def hits_and_misses_leave_in_one_order(dut):
    """A miss behind a ray that waits for a home waits with it."""
    n = numbers()
    rng, homes = await setup(dut, busy=lambda rng: lambda: rng.randint(0, 30))
    inside, outside = (
        ray(n.vec((0, 0, 0)), n.vec((0, 0, 1))),
        ray(n.vec((5, 0, 0)), n.vec((0, 0, 1))),
    )
    kinds = [rng.random() < 0.5 for _ in range(200)]
    dut.hit_ready_i.value = 1
    cocotb.start_soon(Source(dut, "ray").send(packed(inside if k else outside for k in kinds)))

    order = []
    for _ in range(200 * 40):
        await ReadOnly()
        if dut.hit_valid_o.value == 1:
            order.append(payloads().unpack("hit_t", int(dut.hit_data_o.value))["ray_id"])
        elif int(dut.dispatch_valid_o.value):
            beat = payloads().unpack("dispatch_t", int(dut.dispatch_data_o.value))
            order.append(beat["ray"]["ray_id"])
        await RisingEdge(dut.clk_i)

    assert order == list(range(200))
    assert len(homes.dealt) == sum(kinds)


@cocotb.test()
async def takes_a_ray_in_three_cycles_and_gives_it_after_its_latency(dut):
    n = numbers()
    _, homes = await setup(dut, slots=lambda _: 1000)
    inside = ray(n.vec((0, 0, 0)), n.vec((0, 0, 1)))
    todo = list(packed([inside] * 60))
    taken = []
    for _ in range(60 * 3 + int(dut.Latency.value) + 8):
        dut.ray_valid_i.value = int(bool(todo))
        dut.ray_data_i.value = todo[0] if todo else 0
        await ReadOnly()
        if todo and dut.ray_ready_o.value == 1:
            taken.append(cycle())
            todo.pop(0)
        await RisingEdge(dut.clk_i)

    assert taken == list(range(taken[0], taken[0] + 180, 3))
    assert [at for at, _, _ in homes.dealt] == [at + int(dut.Latency.value) for at in taken]


@cocotb.test()
async def deals_in_tiles_in_turn_while_homes_have_room(dut):
    n = numbers()
    rng, homes = await setup(dut, slots=lambda _: 1000)
    tile, count = int(dut.DealTile.value), int(dut.NumTrv.value)
    rays = [ray(n.vec((0, 0, 0)), n.vec((0, 0, 1)))] * (3 * tile * count)

    await all_of(dut, rng, rays, homes)

    assert [home for _, home, _ in homes.dealt] == [i // tile % count for i in range(len(rays))]


@cocotb.test()
async def passes_over_homes_without_room(dut):
    n = numbers()
    count = int(dut.NumTrv.value)
    open_home = count - 1
    rng, homes = await setup(
        dut, slots=lambda _: 1000, closed=lambda _: [h for h in range(count) if h != open_home]
    )
    rays = [ray(n.vec((0, 0, 0)), n.vec((0, 0, 1)))] * 40

    await all_of(dut, rng, rays, homes)

    assert {home for _, home, _ in homes.dealt} == {open_home}


@pytest.mark.parametrize(
    "params", [{}, {"NumTrv": 3, "DealTile": 4}, {"NumTrv": 4, "DealTile": 1}], ids=["1", "3", "4"]
)
def test_ti_rd(params):
    run("ti_rd", "test_ti_rd", params=params)
