# SPDX-License-Identifier: Apache-2.0
"""The MPFR oracle of the operators agrees with Berkeley SoftFloat and, in every mode, the model."""

import random

import pytest
import ti_model
from models.fp_oracle import Oracle

softfloat = pytest.importorskip("softfloatpy")

# In all modes; those that the bindings of the model compile in the default ones, and others.
FORMATS = [(7, 16), (8, 23), (6, 12), (3, 23), (8, 2)]

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


@pytest.mark.parametrize("flush", [False, True], ids=["keep", "flush"])
@pytest.mark.parametrize("toward_zero", [False, True], ids=["nearest", "zero"])
@pytest.mark.parametrize(("exp_bits", "frac_bits"), FORMATS)
def test_the_model_in_every_mode(exp_bits, frac_bits, toward_zero, flush):
    oracle = Oracle(exp_bits, frac_bits, toward_zero, flush)
    number_format = ti_model.Format(exp_bits, frac_bits, toward_zero, flush)
    for a, b in oracle.pairs(random.Random(SEED), 3000):
        for name in ("add", "sub", "mul", "lt", "le", "eq"):
            want = getattr(oracle, name)(a, b)
            got = int(getattr(ti_model, f"fp_{name}")(number_format, a, b))
            assert got == want, f"{number_format} {name} {a:x} {b:x}: MPFR {want:x}, model {got:x}"
        want, got = oracle.rcp(a), ti_model.fp_rcp(number_format, a)
        assert got == want, f"{number_format} rcp {a:x}: MPFR {want:x}, model {got:x}"


# Bits of exponent and fraction, whether toward zero and flushed, table bits, Newton steps.
NEWTON = [
    (3, 2, False, False, 2, 2),
    (5, 10, False, False, 9, 0),
    (7, 16, False, True, 8, 1),
    (8, 23, False, False, 7, 2),
    (8, 23, True, False, 12, 1),
    (6, 12, True, True, 4, 2),
]


@pytest.mark.parametrize("numbers", NEWTON, ids=lambda n: "-".join(map(str, n)))
def test_the_model_by_newton_steps(numbers):
    oracle, number_format = Oracle(*numbers), ti_model.Format(*numbers)
    rng = random.Random(SEED)
    for a in [*oracle.specials(), *(rng.getrandbits(oracle.width) for _ in range(3000))]:
        want, got = oracle.rcp(a), ti_model.fp_rcp(number_format, a)
        assert got == want, f"{number_format} rcp {a:x}: {want:x}, model {got:x}"
