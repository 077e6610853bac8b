# SPDX-License-Identifier: Apache-2.0
"""`ti_rd_thick` gives each ray the model's two origins, and the ray as it came, after `Latency`."""

from itertools import groupby

import cocotb
import pytest
from agents.bench import run, start
from agents.fixed_latency import replay
from models.numbers import hexed, numbers
from models.payload import configuration, payloads
from models.rays import setup_cases

FORMATS = [
    "",
    "exp_bits=7 frac_bits=16 rounding=zero subnormals=flush",
    "exp_bits=5 frac_bits=10 reciprocal=newton",
]


def beats(dut, case):
    """The steps of a ray."""
    p, (lo, hi, given) = payloads(), case
    for step in range(int(dut.RayCycles.value)):
        yield {
            "box_lo_i": p.pack_vec(lo),
            "box_hi_i": p.pack_vec(hi),
            "step_i": step,
            "ray_i": p.pack("ray_t", given),
        }


def valid_cases(rng):
    """(box_lo, box_hi, ray) of rays with a finite origin and direction."""
    n = numbers()
    return [
        (lo, hi, given)
        for lo, hi, given in setup_cases(rng, 1500)
        if all(x & (n.sign - 1) < n.inf for x in (*given["o"], *given["d"]))
    ]


def reader(dut):
    def read():
        origins = payloads().unpack("origins_t", int(dut.origins_o.value))
        return int(dut.step_o.value), int(dut.ray_o.value), origins

    return read


async def origins_of(dut, cases, gap=lambda: False):
    """Run the cases, those of one box together; (case, its origins) of all."""
    results, last = [], int(dut.RayCycles.value) - 1
    for _, group in groupby(cases, key=lambda case: case[:2]):
        group = list(group)
        flat = [beat for case in group for beat in beats(dut, case)]
        drain = int(dut.Latency.value) + 8
        sent, got = await replay(dut, flat, gap=gap, drain=drain, read=reader(dut))
        assert [cycle for cycle, _ in got] == [cycle + int(dut.Latency.value) for cycle in sent]
        for beat, (_, (step, given, _)) in zip(flat, got, strict=True):
            assert (step, given) == (beat["step_i"], beat["ray_i"])
        ends = [origins for _, (step, _, origins) in got if step == last]
        results += zip(group, ends, strict=True)
    return results


@cocotb.test()
@cocotb.parametrize(p_gap=[0.0, 0.5])
async def gives_what_the_model_gives(dut, p_gap):
    rng = await start(dut)
    n = numbers()
    cases = valid_cases(rng)
    # A ray goes on in consecutive cycles: gaps are between rays.
    gaps = iter(())

    def gap():
        nonlocal gaps
        step = next(gaps, None)
        if step is None:
            if rng.random() < p_gap:
                return True
            gaps = iter(range(int(dut.RayCycles.value) - 1))
        return False

    for (lo, hi, given), origins in await origins_of(dut, cases, gap):
        least, most = n.model("thick_origins", lo, hi, given["o"], given["d"])
        want = {"least": tuple(least), "most": tuple(most)}
        assert origins == want, f"{hexed((lo, hi, given))}: {hexed(want)}, not {hexed(origins)}"


@cocotb.test()
async def the_origins_enclose_o_by_the_errors_that_they_stand_for(dut):
    """On each axis by 17 operations and 4 reciprocals, by division, at the farthest plane."""
    rng = await start(dut)
    n, toward_zero = numbers(), configuration()["rounding"] == "zero"

    for (lo, hi, given), origins in await origins_of(dut, valid_cases(rng)):
        o = [n.float(x) for x in given["o"]]
        planes = [(n.float(lo[a]), n.float(hi[a])) for a in range(3)]
        far = max(abs(x - o[a]) for a in range(3) for x in planes[a])
        margin = (42 if toward_zero else 21) * far * 2.0 ** -(n.frac_bits + 1)
        for axis in range(3):
            least, most = (n.float(origins[k][axis]) for k in ("least", "most"))
            along = -1 if given["d"][axis] & n.sign else 1
            assert along * (least - o[axis]) >= margin, hexed(given)
            assert along * (o[axis] - most) >= margin, hexed(given)


@pytest.mark.parametrize("overrides,ray_cycles", [("", 1), ("", 3), *((f, 2) for f in FORMATS[1:])])
def test_ti_rd_thick(overrides, ray_cycles):
    config = f"tiny traversal=padded {overrides}"
    run("ti_rd_thick", "test_ti_rd_thick", config=config, params={"RayCycles": ray_cycles})
