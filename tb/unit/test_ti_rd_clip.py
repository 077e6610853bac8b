# SPDX-License-Identifier: Apache-2.0
"""`ti_rd_clip` sets up each ray as the model does, at each rate and always after its latency."""

from itertools import groupby

import cocotb
import pytest
from agents.bench import run, start
from agents.fixed_latency import replay
from cocotb.triggers import ReadOnly, RisingEdge
from models.numbers import hexed, numbers
from models.payload import parameter, payloads
from models.rays import clip, origins, random_ray, ray, setup_cases, unit_box

FORMATS = [
    "",
    "exp_bits=7 frac_bits=16 rounding=zero reciprocal=newton fp_cmp_stages=1 lookup_stages=4",
    "exp_bits=5 frac_bits=10 rounding=zero subnormals=flush",
]
OK, INVALID = 0, 1


def beats(dut, case):
    """The steps of a ray."""
    p, (lo, hi, given) = payloads(), case
    for step in range(int(dut.RayCycles.value)):
        yield {
            "box_lo_i": p.pack_vec(lo),
            "box_hi_i": p.pack_vec(hi),
            "step_i": step,
            "ray_i": p.pack("ray_t", given),
            "origins_i": p.pack("origins_t", origins(lo, hi, given["o"], given["d"])),
        }


def expected(case):
    """(miss, status, inverse, tmin, tmax); of a miss only the first two."""
    *box, given = case
    if given.get("any_hit") and not parameter("AnyHit", 1):
        return 1, INVALID
    result = clip(*box, {k: given[k] for k in given if k != "any_hit"})
    return result[:2] if result[0] else result


def reader(dut):
    def read():
        verdict = int(dut.miss_o.value), int(dut.status_o.value)
        if verdict[0]:
            return verdict
        inv = payloads().unpack_vec(int(dut.inv_o.value))
        return *verdict, inv, int(dut.tmin_o.value), int(dut.tmax_o.value)

    return read


async def check(dut, cases, gap=lambda: False):
    """Run the cases, those of one box together; (cycles of all steps, of all results) for each
    box, and the results of all."""
    cycles, results = [], []
    for _, group in groupby(cases, key=lambda case: case[:2]):
        group = list(group)
        flat = [beat for case in group for beat in beats(dut, case)]
        drain = int(dut.Latency.value) + 8
        sent, got = await replay(dut, flat, gap=gap, drain=drain, read=reader(dut))
        assert len(got) == len(group)
        for case, (_, result) in zip(group, got, strict=True):
            want = expected(case)
            assert result == want, f"{hexed(case)}: want {hexed(want)}, got {hexed(result)}"
        cycles.append((sent, [cycle for cycle, _ in got]))
        results += [result for _, result in got]
    return cycles, results


@cocotb.test()
async def sets_up_what_the_model_sets_up(dut):
    rng = await start(dut)

    _, results = await check(dut, list(setup_cases(rng, 1000)))

    verdicts = {result[:2] for result in results}
    assert verdicts == {(0, OK), (1, OK), (1, INVALID)}


@cocotb.test()
async def treats_both_zeros_of_a_direction_alike(dut):
    await start(dut)
    n = numbers()
    origins = [n.vec(o) for o in [(0, 0, -3), (1, 0, -3), (1, -1, -3), (1.5, 0, -3)]]
    pairs = [[ray(o, (x, y, n.one)) for x in (0, n.sign) for y in (0, n.sign)] for o in origins]

    _, results = await check(dut, [(*unit_box(), r) for rays in pairs for r in rays])

    for i in range(0, len(results), 4):
        miss, _, *rest = results[i]
        assert all(r[0] == miss and r[3:] == tuple(rest[1:]) for r in results[i : i + 4])
    assert [results[i][0] for i in range(0, len(results), 4)] == [0, 0, 0, 1]


@cocotb.test()
async def says_invalid_of_exactly_the_rays_that_cannot_be_traced(dut):
    rng = await start(dut)
    n = numbers()
    cases = list(setup_cases(rng, 300))

    _, results = await check(dut, cases)

    for case, result in zip(cases, results, strict=True):
        given = case[2]
        unbounded = [x for x in (*given["o"], *given["d"]) if x & (n.sign - 1) >= n.inf]
        nan = [x for x in (given["tmin"], given["tmax"]) if x & (n.sign - 1) > n.inf]
        no_axis = all(n.model("fp_rcp", d) & (n.sign - 1) == n.inf for d in given["d"])
        assert (result[1] == INVALID) == bool(unbounded or nan or no_axis), hexed(case)
        assert result[1] == OK or result[0] == 1


@cocotb.test()
async def an_any_hit_ray_is_set_up_as_any_other_or_invalid_where_it_cannot_be_traced(dut):
    """Flagged rays between rays without the flag, whose verdicts stay their own."""
    rng = await start(dut)
    cases = [(lo, hi, {**r, "any_hit": rng.getrandbits(1)}) for lo, hi, r in setup_cases(rng, 300)]

    _, results = await check(dut, cases)

    flagged = [result for case, result in zip(cases, results, strict=True) if case[2]["any_hit"]]
    assert any(result[1] == OK for result in flagged) == bool(parameter("AnyHit", 1))


@cocotb.test()
@cocotb.parametrize(p_gap=[0.0, 0.5, 0.9])
async def keeps_its_latency_with_and_without_bubbles(dut, p_gap):
    rng = await start(dut)
    cases = [(*unit_box(), random_ray(rng)) for _ in range(300)]
    gap = (lambda: rng.random() < p_gap) if p_gap else (lambda: False)

    [(sent, came)], _ = await check(dut, cases, gap)

    steps = int(dut.RayCycles.value)
    assert came == [cycle + int(dut.Latency.value) for cycle in sent[steps - 1 :: steps]]
    if not p_gap:
        assert came[-1] - came[0] == steps * (len(cases) - 1)


@cocotb.test()
async def takes_as_long_at_each_rate(dut):
    """From the first step on; so does RD."""
    await start(dut)

    [(sent, [came])], _ = await check(dut, [(*unit_box(), ray((0, 0, 0), (numbers().one,) * 3))])

    operators = int(dut.AxisLatency.value)
    assert came - sent[0] == operators + 3 + int(dut.CheckLatency.value)


@cocotb.test()
@cocotb.parametrize(kinds=[(a, b) for a in range(4) for b in range(4) if a != b])
async def rays_of_unlike_kind_do_not_mix(dut, kinds):
    """Each ray's neighbours bound it on other axes, are parallel on others, invalid, or miss."""
    rng = await start(dut)
    n = numbers()

    def of_kind(kind):
        axes = [rng.choice((0, 1, -1, rng.uniform(-1, 1))) for _ in range(3)]
        if kind == 0:  # in the box, each axis may bound it
            return ray(n.vec(rng.uniform(-1, 1) for _ in range(3)), n.direction(rng))
        if kind == 1:  # one axis or two parallel, inside or out
            return ray(n.vec(rng.choice((0, 1.5)) for _ in range(3)), n.vec(axes))
        if kind == 2:
            d = n.vec((0, 0, 0)) if rng.random() < 0.5 else (n.nan, n.one, n.one)
            return ray(n.vec(axes), d)
        return ray(n.vec(rng.choice((-3, 0, 3)) for _ in range(3)), n.direction(rng))

    cases = [(*unit_box(), of_kind(kinds[i % 2])) for i in range(60)]

    await check(dut, cases)


@cocotb.test()
async def forgets_what_is_inside_on_reset(dut):
    await start(dut)
    dut.step_i.value = int(dut.RayCycles.value) - 1
    dut.valid_i.value = 1
    for _ in range(int(dut.Latency.value) + 2):
        await RisingEdge(dut.clk_i)
    dut.valid_i.value = 0
    dut.rst_ni.value = 0
    await RisingEdge(dut.clk_i)
    dut.rst_ni.value = 1

    for _ in range(int(dut.Latency.value) + 2):
        await ReadOnly()
        assert dut.valid_o.value == 0
        await RisingEdge(dut.clk_i)


def test_ti_rd_clip_without_any_hit_rays():
    params = {"RayCycles": 2, "AnyHit": 0}
    run("ti_rd_clip", "test_ti_rd_clip", only="invalid|any_hit", params=params)


@pytest.mark.parametrize("ray_cycles", [1, 3])
def test_ti_rd_clip_of_thick_rays(ray_cycles):
    only = "sets_up|takes_as_long"
    params = {"RayCycles": ray_cycles}
    run("ti_rd_clip", "test_ti_rd_clip", config="tiny traversal=padded", params=params, only=only)


# Every number of lanes, every format.
@pytest.mark.parametrize(
    ("overrides", "ray_cycles"),
    [(FORMATS[0], 1), (FORMATS[0], 2), (FORMATS[0], 3), (FORMATS[1], 2), (FORMATS[2], 1)],
)
def test_ti_rd_clip(overrides, ray_cycles):
    params = {"RayCycles": ray_cycles}
    run("ti_rd_clip", "test_ti_rd_clip", config=f"tiny {overrides}", params=params)
