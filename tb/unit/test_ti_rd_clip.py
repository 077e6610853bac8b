# SPDX-License-Identifier: Apache-2.0
"""`ti_rd_clip` sets up each ray as the model does, `Latency` cycles after its last axis."""

import cocotb
import pytest
from agents.bench import run, start
from agents.fixed_latency import replay
from cocotb.triggers import ReadOnly, RisingEdge
from models.numbers import hexed, numbers
from models.payload import payloads
from models.rays import clip, ray, setup_cases, unit_box

FORMATS = ["", "exp_bits=7 frac_bits=16", "exp_bits=5 frac_bits=10"]
OK, INVALID = 0, 1


def beats(case):
    """The three cycles of a ray."""
    p, (lo, hi, given) = payloads(), case
    for axis in range(3):
        yield {
            "box_lo_i": p.pack_vec(lo),
            "box_hi_i": p.pack_vec(hi),
            "axis_i": axis,
            "ray_i": p.pack("ray_t", given),
        }


def expected(case):
    """(miss, status, inverse, tmin, tmax); of a miss only the first two."""
    result = clip(*case)
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
    """Run the cases; the cycles of all axes and of the results, and the results."""
    flat = [beat for case in cases for beat in beats(case)]
    sent, got = await replay(dut, flat, gap=gap, read=reader(dut))
    assert len(got) == len(cases)
    for case, (_, result) in zip(cases, got, strict=True):
        want = expected(case)
        assert result == want, f"{hexed(case)}: want {hexed(want)}, got {hexed(result)}"
    return sent, [cycle for cycle, _ in got], [result for _, result in got]


@cocotb.test()
async def sets_up_what_the_model_sets_up(dut):
    rng = await start(dut)

    _, _, results = await check(dut, list(setup_cases(rng, 1000)))

    verdicts = {result[:2] for result in results}
    assert verdicts == {(0, OK), (1, OK), (1, INVALID)}


@cocotb.test()
async def treats_both_zeros_of_a_direction_alike(dut):
    await start(dut)
    n = numbers()
    origins = [n.vec(o) for o in [(0, 0, -3), (1, 0, -3), (1, -1, -3), (1.5, 0, -3)]]
    pairs = [[ray(o, (x, y, n.one)) for x in (0, n.sign) for y in (0, n.sign)] for o in origins]

    _, _, results = await check(dut, [(*unit_box(), r) for rays in pairs for r in rays])

    for i in range(0, len(results), 4):
        miss, _, *rest = results[i]
        assert all(r[0] == miss and r[3:] == tuple(rest[1:]) for r in results[i : i + 4])
    assert [results[i][0] for i in range(0, len(results), 4)] == [0, 0, 0, 1]


@cocotb.test()
async def says_invalid_of_exactly_the_rays_that_cannot_be_traced(dut):
    rng = await start(dut)
    n = numbers()
    cases = list(setup_cases(rng, 300))

    _, _, results = await check(dut, cases)

    for case, result in zip(cases, results, strict=True):
        given = case[2]
        unbounded = [x for x in (*given["o"], *given["d"]) if x & (n.sign - 1) >= n.inf]
        nan = [x for x in (given["tmin"], given["tmax"]) if x & (n.sign - 1) > n.inf]
        no_axis = all(n.model("fp_rcp", d) & (n.sign - 1) == n.inf for d in given["d"])
        assert (result[1] == INVALID) == bool(unbounded or nan or no_axis), hexed(case)
        assert result[1] == OK or result[0] == 1


@cocotb.test()
@cocotb.parametrize(p_gap=[0.0, 0.5, 0.9])
async def keeps_its_latency_with_and_without_bubbles(dut, p_gap):
    rng = await start(dut)
    cases = rng.sample(list(setup_cases(rng, 100)), 100)
    gap = (lambda: rng.random() < p_gap) if p_gap else (lambda: False)

    sent, came, _ = await check(dut, cases, gap)

    assert came == [cycle + int(dut.Latency.value) for cycle in sent[2::3]]


@cocotb.test()
async def forgets_what_is_inside_on_reset(dut):
    await start(dut)
    dut.axis_i.value = 2
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


@pytest.mark.parametrize("overrides", FORMATS)
def test_ti_rd_clip(overrides):
    run("ti_rd_clip", "test_ti_rd_clip", config=f"tiny {overrides}")
