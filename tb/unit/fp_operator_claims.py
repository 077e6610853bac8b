# SPDX-License-Identifier: Apache-2.0
"""`ti_fp_add`, `ti_fp_mul` and `ti_fp_rcp` give the rounded result of every case after `Latency`.

One a cycle, with and without bubbles.  Run by the test file of each.
"""

import cocotb
import pytest
from agents.bench import start
from agents.fixed_latency import replay
from cocotb.triggers import ReadOnly, RisingEdge
from models.fp_oracle import Oracle


def oracle_of(dut):
    names = ["ExpBits", "FracBits", "TowardZero", "Flush"]
    if dut._name == "ti_fp_rcp":
        names += ["TableBits", "NewtonSteps"]
    return Oracle(*(int(getattr(dut, name).value) for name in names))


# A format for each way to round and to be near zero, other than by default.
MODES = [
    pytest.param({"ExpBits": 7, "FracBits": 16, "TowardZero": 1}, id="zero"),
    pytest.param({"ExpBits": 3, "FracBits": 2, "Flush": 1}, id="flush"),
    pytest.param({"ExpBits": 8, "FracBits": 23, "TowardZero": 1, "Flush": 1}, id="zero-flush"),
]


def sums(oracle, rng, count):
    """Sums and differences of the oracle's pairs; each pair as one of the two."""
    for i, (a, b) in enumerate(oracle.pairs(rng, count)):
        yield {"a_i": a, "b_i": b, "negate_b_i": (i ^ i >> 8) & 1}


def products(oracle, rng, count):
    for a, b in oracle.pairs(rng, count):
        yield {"a_i": a, "b_i": b}


def operands(oracle, rng, count):
    """Specials, then every value of a small format or `count` random ones of a large one."""
    for a in oracle.specials():
        yield {"a_i": a}
    for i in range(min(count, 1 << oracle.width)):
        yield {"a_i": i if oracle.width <= 10 else rng.getrandbits(oracle.width)}


CASES = {"ti_fp_add": sums, "ti_fp_mul": products, "ti_fp_rcp": operands}


def cases(dut, rng, count):
    return CASES[dut._name](oracle_of(dut), rng, count)


def expected(dut, beat):
    oracle = oracle_of(dut)
    if dut._name == "ti_fp_add":
        return (oracle.sub if beat["negate_b_i"] else oracle.add)(beat["a_i"], beat["b_i"])
    if dut._name == "ti_fp_mul":
        return oracle.mul(beat["a_i"], beat["b_i"])
    return oracle.rcp(beat["a_i"])


def text(case):
    return " ".join(f"{port}={value:#x}" for port, value in case.items())


def latency(dut):
    """What the parameters ask for, as `ti_fp_pkg` has it."""
    if dut._name == "ti_fp_rcp" and int(dut.TableBits.value):
        products = 2 * int(dut.NewtonSteps.value)
        return int(dut.EndStages.value) + 1 + products * int(dut.ProductStages.value)
    if dut._name == "ti_fp_rcp":
        bits = int(dut.BitsPerStage.value)
        return int(dut.EndStages.value) + (int(dut.FracBits.value) + 1 + bits) // bits
    return int(dut.Stages.value)


@cocotb.test()
async def rounds_every_case_as_mpfr_does(dut):
    rng = await start(dut)
    beats = list(cases(dut, rng, 3000))

    _, got = await replay(dut, beats)

    assert len(got) == len(beats)
    for beat, (_, result) in zip(beats, got, strict=True):
        want = expected(dut, beat)
        assert result == want, f"{text(beat)}: want {want:#x}, got {result:#x}"


@cocotb.test()
@cocotb.parametrize(p_gap=[0.0, 0.5, 0.9])
async def keeps_its_latency_with_and_without_bubbles(dut, p_gap):
    rng = await start(dut)
    beats = list(cases(dut, rng, 0))[:200]

    sent, got = await replay(dut, beats, gap=lambda: rng.random() < p_gap)

    assert [cycle for cycle, _ in got] == [cycle + latency(dut) for cycle in sent]
    assert [result for _, result in got] == [expected(dut, beat) for beat in beats]


@cocotb.test()
async def takes_and_gives_one_a_cycle(dut):
    rng = await start(dut)
    beats = list(cases(dut, rng, 100))[-100:]

    sent, got = await replay(dut, beats)

    assert sent == list(range(100))
    assert [cycle - got[0][0] for cycle, _ in got] == list(range(100))


@cocotb.test()
async def forgets_what_is_inside_on_reset(dut):
    await start(dut)
    dut.valid_i.value = 1
    for _ in range(latency(dut) + 2):
        await RisingEdge(dut.clk_i)
    dut.valid_i.value = 0
    dut.rst_ni.value = 0
    await RisingEdge(dut.clk_i)
    dut.rst_ni.value = 1

    for _ in range(latency(dut) + 2):
        await ReadOnly()
        assert dut.valid_o.value == 0
        await RisingEdge(dut.clk_i)
