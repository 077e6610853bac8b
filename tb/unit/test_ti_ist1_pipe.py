# SPDX-License-Identifier: Apache-2.0
"""`ti_ist1_pipe` takes pass (a) or (b) each cycle, in any mixture, and does what the model does."""

from fractions import Fraction

import cocotb
import pytest
from agents.bench import run, start
from agents.fixed_latency import replay
from cocotb.triggers import ReadOnly, RisingEdge
from models.ist1_cases import expected, near_end, pass_a, pass_a_cases, pass_b_cases
from models.numbers import hexed, numbers
from models.payload import payloads

FORMATS = [
    "",
    "exp_bits=7 frac_bits=16 rounding=zero reciprocal=newton fp_cmp_stages=1 lookup_stages=4",
    "exp_bits=5 frac_bits=10 rounding=zero subnormals=flush",
    "triangle_test=np",
]
TAG_WIDTH = 9


def ports(case, rng):
    """A case as port values; ports that its pass does not read get noise."""
    p, n = payloads(), numbers()

    def noise(words):
        return tuple(rng.getrandbits(n.width) for _ in range(words))

    plane, bary = case.get("plane", noise(8)), case.get("bary", noise(4))
    det, dett, audet, av = case.get("after_a", noise(4))
    return {
        "pass_b_i": int("after_a" in case),
        "tag_i": rng.getrandbits(TAG_WIDTH),
        "axis_i": case["axis"],
        "o_i": p.pack_vec(case.get("o", noise(3))),
        "d_i": p.pack_vec(case["d"]),
        "tnear_i": case.get("tnear", *noise(1)),
        "tfar_i": case.get("tfar", *noise(1)),
        "plane_i": sum(word << 32 * i for i, word in enumerate(plane)),
        "bary_i": sum(word << 32 * i for i, word in enumerate(bary)),
        "det_i": det,
        "dett_i": dett,
        "audet_i": audet,
        "av_i": av,
    }


def reader(dut):
    """(tag, pass, what is kept as (det, dett, x, y) or None)."""
    outputs = (dut.det_o, dut.dett_o, dut.x_o, dut.y_o)

    def read():
        kept = tuple(int(o.value) for o in outputs) if dut.keep_o.value == 1 else None
        return int(dut.tag_o.value), int(dut.pass_b_o.value), kept

    return read


async def check(dut, rng, cases, gap=lambda: False):
    """Run the cases; the cycles of inputs and outputs, and what was kept of each case."""
    beats = [ports(case, rng) for case in cases]
    sent, got = await replay(dut, beats, gap=gap, read=reader(dut))
    assert len(got) == len(cases)
    for case, beat, (_, result) in zip(cases, beats, got, strict=True):
        want = beat["tag_i"], beat["pass_b_i"], expected(case)
        assert result == want, f"{hexed(case)}: want {hexed(want)}, got {hexed(result)}"
    return sent, [cycle for cycle, _ in got], [result[2] for _, result in got]


@cocotb.test()
async def pass_a_is_the_model_s(dut):
    rng = await start(dut)
    _, _, kept = await check(dut, rng, list(pass_a_cases(rng, 3000)))

    assert 100 < sum(k is not None for k in kept) < len(kept) - 100


@cocotb.test()
async def pass_b_is_the_model_s(dut):
    rng = await start(dut)
    _, _, kept = await check(dut, rng, list(pass_b_cases(rng, 3000)))

    assert 100 < sum(k is not None for k in kept) < len(kept) - 100


@cocotb.test()
async def culls_at_the_far_end_only_what_the_final_comparison_rejects(dut):
    rng = await start(dut)
    n = numbers()
    cases = list(near_end(rng, 2000, "tfar"))
    _, _, kept = await check(dut, rng, cases)

    culled = 0
    for case, keeps in zip(cases, kept, strict=True):
        det, dett, _, _ = pass_a(case["plane"], case["o"], case["d"], 0, n.inf)
        t, _, _ = n.model("pass_c", (det, dett, 0, 0))
        if keeps is None:
            culled += 1
            assert n.less(case["tfar"], t), hexed(case)
    assert 100 < culled < len(cases) - 100


@cocotb.test()
async def culls_at_the_near_end_only_what_lies_before_it(dut):
    """dett / det, exactly, is less than tnear; so of two ranges that meet one keeps each test."""
    rng = await start(dut)
    n = numbers()
    cases = list(near_end(rng, 2000, "tnear"))
    _, _, kept = await check(dut, rng, cases)

    culled = 0
    for case, keeps in zip(cases, kept, strict=True):
        if keeps is None:
            culled += 1
            a = pass_a(case["plane"], case["o"], case["d"], 0, n.inf)
            det, dett = (Fraction(n.float(bits)) for bits in a[:2])
            assert dett / det < Fraction(n.float(case["tnear"])), hexed(case)
    assert 100 < culled < len(cases) - 100


@cocotb.test()
@cocotb.parametrize(p_gap=[0.0, 0.5, 0.9])
async def mixes_both_passes_at_one_a_cycle(dut, p_gap):
    rng = await start(dut)
    cases = [*rng.sample(list(pass_a_cases(rng, 300)), 200)]
    cases += [*rng.sample(list(pass_b_cases(rng, 300)), 200)]
    rng.shuffle(cases)
    gap = (lambda: rng.random() < p_gap) if p_gap else (lambda: False)

    sent, came, _ = await check(dut, rng, cases, gap)

    if not p_gap:
        assert sent == list(range(len(cases)))
    assert came == [cycle + int(dut.Latency.value) for cycle in sent]


@cocotb.test()
async def forgets_what_is_inside_on_reset(dut):
    await start(dut)
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
def test_ti_ist1_pipe(overrides):
    run("ti_ist1_pipe", "test_ti_ist1_pipe", config=f"tiny {overrides}", TagWidth=TAG_WIDTH)
