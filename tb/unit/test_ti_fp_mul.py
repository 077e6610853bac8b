# SPDX-License-Identifier: Apache-2.0
"""`ti_fp_mul` gives the rounded product of every pair after `Stages` cycles, one a cycle."""

import pytest
from agents.bench import run
from fp_operator_claims import MODES

FORMATS = [(3, 2), (7, 16), (8, 23)]

STAGES = [3, 4, 5, 6, 7, 8]


@pytest.mark.parametrize("stages", STAGES)
@pytest.mark.parametrize(("exp_bits", "frac_bits"), FORMATS)
def test_ti_fp_mul(exp_bits, frac_bits, stages):
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
