# SPDX-License-Identifier: Apache-2.0
"""`ti_fp_cmp` orders every pair as MPFR does, and calls NaN unordered."""

import random

import cocotb
import pytest
from agents.bench import run
from cocotb.triggers import Timer
from models.fp_oracle import Oracle

FORMATS = [(3, 2), (7, 16), (8, 23)]


@cocotb.test()
async def orders_every_pair_as_mpfr_does(dut):
    rng = random.Random(cocotb.RANDOM_SEED)
    flush = dut.Flush.value == 1
    oracle = Oracle(int(dut.ExpBits.value), int(dut.FracBits.value), flush=flush)

    for a, b in oracle.pairs(rng, 3000):
        dut.a_i.value = a
        dut.b_i.value = b
        await Timer(1, unit="ns")
        got = [int(port.value) for port in (dut.lt_o, dut.le_o, dut.eq_o, dut.unordered_o)]
        nan = any(bits & (oracle.sign - 1) > oracle.inf for bits in (a, b))
        want = [oracle.lt(a, b), oracle.le(a, b), oracle.eq(a, b), int(nan)]
        assert got == want, f"a_i={a:#x} b_i={b:#x}: want {want}, got {got}"


@pytest.mark.parametrize(("exp_bits", "frac_bits"), FORMATS)
def test_ti_fp_cmp(exp_bits, frac_bits):
    run("ti_fp_cmp", "test_ti_fp_cmp", ExpBits=exp_bits, FracBits=frac_bits)


def test_ti_fp_cmp_where_subnormals_are_zeros():
    run("ti_fp_cmp", "test_ti_fp_cmp", ExpBits=7, FracBits=16, Flush=1)
