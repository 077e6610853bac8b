# SPDX-License-Identifier: Apache-2.0
"""`ti_ist1_choice` names the IST1 of a test: by its triangle, by its ray, or by who is crowded."""

import random
from collections import Counter

import cocotb
import pytest
from agents.bench import run
from cocotb.triggers import Timer
from models.payload import configuration, parameter, payloads

UNITS = parameter("NumIst1", 1)


def choice():
    return configuration()["ist1_choice"]


async def unit_of(dut, record, trv=0, slot=0, crowded=0):
    dut.record_i.value, dut.crowded_i.value = record, crowded
    dut.home_i.value = payloads().pack("home_t", trv=trv, slot=slot)
    await Timer(1, "ns")
    index = int(dut.index_o.value)
    assert index < UNITS
    return index


def homes():
    config = configuration()
    return [(t, s) for t in range(config["num_trv"]) for s in range(config["trv_slots"])]


@cocotb.test()
async def triangles_of_a_line_have_one_unit_and_lines_spread_evenly(dut):
    rng = random.Random(cocotb.RANDOM_SEED)
    if choice() == "slot":
        return
    for first in (0, 12345, 1 << 20, (1 << 29) - 4000):
        seen = Counter()
        for record in range(first & ~1, first + 2000, 2):
            unit = await unit_of(dut, record, *rng.choice(homes()))
            assert await unit_of(dut, record + 1, *rng.choice(homes())) == unit
            seen[unit] += 1
        assert len(seen) == UNITS and max(seen.values()) <= 1.3 * 1000 / UNITS + 2


@cocotb.test()
async def rays_of_a_tile_spread_evenly_over_the_units(dut):
    """By their slots, whatever the triangle, where the triangle has no say."""
    if choice() == "hash":
        return
    crowded = (1 << UNITS) - 1
    for record in (0, 77, (1 << 29) - 1):
        for trv in range(configuration()["num_trv"]):
            slots = range(configuration()["trv_slots"])
            units = [await unit_of(dut, record, trv, slot, crowded) for slot in slots]
            least, most = len(units) // UNITS, -(-len(units) // UNITS)
            assert all(least <= units.count(unit) <= most for unit in range(UNITS))


@cocotb.test()
async def only_a_crowded_unit_spills_and_only_its_own_tests(dut):
    rng = random.Random(cocotb.RANDOM_SEED)
    if choice() != "spill":
        return
    for _ in range(300):
        record, (trv, slot) = rng.getrandbits(29), rng.choice(homes())
        by_triangle = await unit_of(dut, record, trv, slot)
        by_ray = await unit_of(dut, record, trv, slot, (1 << UNITS) - 1)
        others = rng.getrandbits(UNITS) & ~(1 << by_triangle)
        assert await unit_of(dut, record, trv, slot, others) == by_triangle
        assert await unit_of(dut, record, trv, slot, others | 1 << by_triangle) == by_ray


@cocotb.test()
async def without_spilling_it_does_not_matter_who_is_crowded(dut):
    rng = random.Random(cocotb.RANDOM_SEED)
    if choice() == "spill":
        return
    for _ in range(200):
        test = (rng.getrandbits(29), *rng.choice(homes()))
        assert await unit_of(dut, *test, rng.getrandbits(UNITS)) == await unit_of(dut, *test)


@pytest.mark.parametrize(
    ("units", "choice"), [(1, "spill"), (3, "spill"), (8, "hash"), (8, "slot")]
)
def test_ti_ist1_choice(units, choice):
    config = f"tiny num_trv=3 ist1_choice={choice}"
    run("ti_ist1_choice", "test_ti_ist1_choice", config=config, NumIst1=units)
