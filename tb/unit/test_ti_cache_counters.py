# SPDX-License-Identifier: Apache-2.0
"""`ti_cache_counters` counts each event once, in every cycle, from zero after reset."""

import cocotb
from agents.bench import run, start
from cocotb.triggers import RisingEdge

WIDTH = 48
FIELDS = ("misses", "merged", "hits", "accesses")  # from the lowest bits of the word up


def read(dut):
    word = int(dut.counters_o.value)
    return {name: word >> WIDTH * i & ((1 << WIDTH) - 1) for i, name in enumerate(FIELDS)}


async def event(dut, kind=None):
    """One cycle in which a request becomes `kind`, or nothing happens."""
    dut.event_access_i.value = kind is not None
    dut.event_hit_i.value = kind == "hits"
    dut.event_merged_i.value = kind == "merged"
    dut.event_miss_i.value = kind == "misses"
    await RisingEdge(dut.clk_i)


@cocotb.test()
async def counts_every_event_once(dut):
    rng = await start(dut)
    want = dict.fromkeys(FIELDS, 0)
    for _ in range(1000):
        kind = rng.choice([None, "hits", "merged", "misses"])
        await event(dut, kind)
        if kind:
            want[kind] += 1
            want["accesses"] += 1
        await event(dut)
        assert read(dut) == want


@cocotb.test()
async def counts_in_every_cycle(dut):
    await start(dut)
    for _ in range(100):
        await event(dut, "hits")
    await event(dut)
    assert read(dut) == {"accesses": 100, "hits": 100, "merged": 0, "misses": 0}


@cocotb.test()
async def starts_at_zero_after_reset(dut):
    await start(dut)
    await event(dut, "hits")
    dut.rst_ni.value = 0
    await event(dut)
    dut.rst_ni.value = 1
    await event(dut)
    assert set(read(dut).values()) == {0}


def test_ti_cache_counters():
    run("ti_cache_counters", "test_ti_cache_counters")
