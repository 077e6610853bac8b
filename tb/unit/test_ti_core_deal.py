# SPDX-License-Identifier: Apache-2.0
"""`ti_core_deal` gives every ray to one core, in tiles, and lets no core wait for another."""

import cocotb
import pytest
from agents.bench import cycle, run, start
from agents.stream import Sink, Source, stalls
from cocotb.triggers import ClockCycles
from models.payload import parameter, payloads


def beats(count):
    return [payloads().pack("ray_t", ray_id=i) for i in range(count)]


def ids(taken):
    return [payloads().unpack("ray_t", bits)["ray_id"] for bits in taken]


async def take_for_ever(sink, taken, ready):
    while True:
        taken += await sink.receive(1, ready, patience=1_000_000)


def sinks(dut, ready):
    """What each core takes, as it comes; `ready(core)` is its ready bit of each cycle."""
    taken = [[] for _ in range(parameter("NumCores"))]
    for core, into in enumerate(taken):
        sink = CoreSink(dut, core)
        cocotb.start_soon(take_for_ever(sink, into, lambda core=core: ready(core)))
    return taken


class CoreSink(Sink):
    """A core: its valid and ready are bits of vectors that all cores share."""

    def __init__(self, dut, core):
        self._clk, self._name, self._core = dut.clk_i, f"core[{core}]", core
        self.valid, self.data = dut.core_valid_o[core], dut.core_data_o[core]
        self.ready = dut.core_ready_i[core]
        self._waiting = None
        self.ready.value = 0


@cocotb.test()
@cocotb.parametrize((("p_valid", "p_ready"), [(1.0, 1.0), (1.0, 0.2), (0.3, 1.0), (0.5, 0.4)]))
async def every_ray_goes_to_one_core_and_tiles_stay_together(dut, p_valid, p_ready):
    rng = await start(dut)
    tile, cores = parameter("Tile"), parameter("NumCores")
    taken = sinks(dut, lambda core: rng.random() < p_ready)
    count = 8 * tile * cores
    await Source(dut, "ray").send(beats(count), stalls(rng, 1 - p_valid))
    await ClockCycles(dut.clk_i, int(40 * tile / p_ready))

    assert sorted(ray for core in taken for ray in ids(core)) == list(range(count))
    for core in taken:
        got = ids(core)
        assert got == sorted(got), "rays of a core keep their order"
        for at in range(0, len(got), tile):
            assert got[at] % tile == 0 and got[at : at + tile] == list(
                range(got[at], got[at] + tile)
            )


@cocotb.test()
async def tiles_go_round_when_all_cores_keep_up(dut):
    await start(dut)
    tile, cores = parameter("Tile"), parameter("NumCores")
    taken = sinks(dut, lambda core: 1)
    await Source(dut, "ray").send(beats(4 * tile * cores))
    await ClockCycles(dut.clk_i, 4 * tile + 8)
    for core, got in enumerate(taken):
        assert {ray // tile % cores for ray in ids(got)} == {core}


@cocotb.test()
async def a_core_that_takes_nothing_holds_up_nobody_else(dut):
    await start(dut)
    tile, cores = parameter("Tile"), parameter("NumCores")
    if cores == 1:
        taken = sinks(dut, lambda core: 1)  # its one core is never held up by another
        await Source(dut, "ray").send(beats(4 * tile))
        await ClockCycles(dut.clk_i, 2 * tile + 8)
        assert len(taken[0]) == 4 * tile
        return
    taken = sinks(dut, lambda core: core != 0)
    count = 2 * tile + 10 * tile * (cores - 1)  # two tiles fill the queue of core 0
    await Source(dut, "ray").send(beats(count), patience=20 * tile)
    await ClockCycles(dut.clk_i, 4 * tile + 8)
    assert not taken[0] and sum(len(core) for core in taken) == count - 2 * tile


@cocotb.test()
async def takes_a_ray_a_cycle(dut):
    await start(dut)
    tile, cores = parameter("Tile"), parameter("NumCores")
    sinks(dut, lambda core: 1)
    count = 4 * tile * cores
    begin = cycle()
    await Source(dut, "ray").send(beats(count))
    assert cycle() - begin <= count + 1


@pytest.mark.parametrize(("cores", "tile"), [(1, 4), (2, 1), (3, 4), (4, 16)])
def test_ti_core_deal(cores, tile):
    run("ti_core_deal", "test_ti_core_deal", NumCores=cores, Tile=tile)
