# SPDX-License-Identifier: Apache-2.0
"""The MPFR oracle of the operators agrees with Berkeley SoftFloat where that has the format."""

import random

import pytest
from models.fp_oracle import Oracle

softfloat = pytest.importorskip("softfloatpy")

SEED = 1


def check(oracle, number, count):
    size = oracle.width // 8

    def soft(bits):
        return number.from_bytes(bits.to_bytes(size, "big"))

    def image(value):
        bits = int.from_bytes(value.to_bytes(), "big")
        return oracle.nan if bits & (oracle.sign - 1) > oracle.inf else bits

    one = soft(oracle.bias << oracle.frac_bits)
    for a, b in oracle.pairs(random.Random(SEED), count):
        x, y = soft(a), soft(b)
        for name in ("add", "sub", "mul"):
            want, got = image(getattr(number, name)(x, y)), getattr(oracle, name)(a, b)
            assert got == want, f"{name} {a:x} {b:x}: SoftFloat {want:x}, MPFR {got:x}"
        for name in ("lt", "le", "eq"):
            want, got = int(getattr(number, name)(x, y)), getattr(oracle, name)(a, b)
            assert got == want, f"{name} {a:x} {b:x}: SoftFloat {want}, MPFR {got}"
        want, got = image(number.div(one, x)), oracle.rcp(a)
        assert got == want, f"rcp {a:x}: SoftFloat {want:x}, MPFR {got:x}"


def test_binary32():
    check(Oracle(8, 23), softfloat.Float32, 5000)


def test_binary16():
    check(Oracle(5, 10), softfloat.Float16, 5000)
