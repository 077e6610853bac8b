# SPDX-License-Identifier: Apache-2.0
"""`ti_fp_add` gives the rounded a + b or a - b of every pair after `Latency`, one a cycle."""

import cocotb
import pytest
from agents.bench import run, start
from agents.fixed_latency import replay
from cocotb.triggers import ReadOnly, RisingEdge
from models.fp_oracle import Oracle

FORMATS = [(3, 2), (7, 16), (8, 23)]


def oracle_of(dut):
    return Oracle(int(dut.ExpBits.value), int(dut.FracBits.value))


def cases(oracle, rng, count):
    """Sums and differences of the oracle's pairs; each pair as one of the two."""
    for i, (a, b) in enumerate(oracle.pairs(rng, count)):
        yield {"a_i": a, "b_i": b, "negate_b_i": (i ^ i >> 8) & 1}


def expected(oracle, beat):
    operation = oracle.sub if beat["negate_b_i"] else oracle.add
    return operation(beat["a_i"], beat["b_i"])


def text(case):
    return " ".join(f"{port}={value:#x}" for port, value in case.items())


@cocotb.test()
async def rounds_every_case_as_mpfr_does(dut):
    rng = await start(dut)
    oracle = oracle_of(dut)
    beats = list(cases(oracle, rng, 3000))

    _, got = await replay(dut, beats)

    assert len(got) == len(beats)
    for beat, (_, result) in zip(beats, got, strict=True):
        want = expected(oracle, beat)
        assert result == want, f"{text(beat)}: want {want:#x}, got {result:#x}"


@cocotb.test()
@cocotb.parametrize(p_gap=[0.0, 0.5, 0.9])
async def keeps_its_latency_with_and_without_bubbles(dut, p_gap):
    rng = await start(dut)
    oracle = oracle_of(dut)
    beats = list(cases(oracle, rng, 0))[:200]

    sent, got = await replay(dut, beats, gap=lambda: rng.random() < p_gap)

    assert [cycle for cycle, _ in got] == [cycle + int(dut.Latency.value) for cycle in sent]
    assert [result for _, result in got] == [expected(oracle, beat) for beat in beats]


@cocotb.test()
async def takes_and_gives_one_a_cycle(dut):
    rng = await start(dut)
    beats = list(cases(oracle_of(dut), rng, 100))[-100:]

    sent, got = await replay(dut, beats)

    assert sent == list(range(100))
    assert [cycle - got[0][0] for cycle, _ in got] == list(range(100))


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


@pytest.mark.parametrize(("exp_bits", "frac_bits"), FORMATS)
def test_ti_fp_add(exp_bits, frac_bits):
    run("ti_fp_add", "test_ti_fp_add", ExpBits=exp_bits, FracBits=frac_bits)
