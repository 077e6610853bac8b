# SPDX-License-Identifier: Apache-2.0
"""`ti_fp_mul` gives the rounded product of every pair after `Stages` cycles, one a cycle."""

import pytest
from agents.bench import run
from fp_operator_claims import MODES

# Formats with their numbers of stages.
CASES = [
    *(((8, 23), stages) for stages in range(3, 9)),
    *((small, stages) for small in [(3, 2), (7, 16)] for stages in [3, 8]),
]


@pytest.mark.parametrize(("number_format", "stages"), CASES)
def test_ti_fp_mul(number_format, stages):
    exp_bits, frac_bits = number_format
    run(
        "ti_fp_mul",
        "fp_operator_claims",
        ExpBits=exp_bits,
        FracBits=frac_bits,
        Stages=stages,
    )


@pytest.mark.parametrize("modes", MODES)
def test_ti_fp_mul_in_other_modes(modes):
    run("ti_fp_mul", "fp_operator_claims", Stages=4, **modes)
