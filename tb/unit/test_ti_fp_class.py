# SPDX-License-Identifier: Apache-2.0
"""`ti_fp_class` says of every number what the model and MPFR take it for."""

import math
import random

import cocotb
import gmpy2
import pytest
import ti_model
from agents.bench import run
from cocotb.triggers import Timer
from models.fp_oracle import Oracle

FORMATS = [(3, 2), (5, 4), (7, 16), (8, 23)]
SMALL = 10  # bits of a format of which every value is tried


def classes(oracle, bits):
    """(zero, finite, normal, nan) of the value that the model and MPFR give."""
    number_format = ti_model.Format(oracle.exp_bits, oracle.frac_bits, flush=oracle.flush)
    value = ti_model.fp_to_double(number_format, bits)
    exact = oracle.value(bits)
    least_normal = oracle.least_normal
    model = (
        value == 0,
        math.isfinite(value),
        least_normal <= abs(value) < math.inf,
        math.isnan(value),
    )
    mpfr = (
        gmpy2.is_zero(exact),
        gmpy2.is_finite(exact),
        gmpy2.is_finite(exact) and abs(exact) >= least_normal,
        gmpy2.is_nan(exact),
    )
    assert model == mpfr, f"{bits:#x}: model {model}, MPFR {mpfr}"
    return model


@cocotb.test()
async def tells_the_class_of_every_number(dut):
    """All values of a small format; of others special ones, those beside them, random ones."""
    rng = random.Random(cocotb.RANDOM_SEED)
    flush = dut.Flush.value == 1
    oracle = Oracle(int(dut.ExpBits.value), int(dut.FracBits.value), flush=flush)
    if oracle.width <= SMALL:
        numbers = range(1 << oracle.width)
    else:
        numbers = [(s + ulp) % (1 << oracle.width) for s in oracle.specials() for ulp in (-1, 0, 1)]
        numbers += [rng.getrandbits(oracle.width) for _ in range(2000)]

    seen = set()
    for bits in numbers:
        dut.x_i.value = bits
        await Timer(1, unit="ns")
        got = tuple(port.value == 1 for port in (dut.zero_o, dut.finite_o, dut.normal_o, dut.nan_o))
        assert got == classes(oracle, bits), f"x_i={bits:#x}: {got}"
        seen.add(got)

    assert len(seen) == 5 - flush  # zero, subnormal, normal, infinite, NaN


@pytest.mark.parametrize(("exp_bits", "frac_bits"), FORMATS)
def test_ti_fp_class(exp_bits, frac_bits):
    run("ti_fp_class", "test_ti_fp_class", ExpBits=exp_bits, FracBits=frac_bits)


def test_ti_fp_class_where_subnormals_are_zeros():
    run("ti_fp_class", "test_ti_fp_class", ExpBits=5, FracBits=4, Flush=1)
