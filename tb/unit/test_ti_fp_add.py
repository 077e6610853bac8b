# SPDX-License-Identifier: Apache-2.0
"""`ti_fp_add` gives the rounded a + b or a - b of every pair after `Stages` cycles, one a cycle."""

import pytest
from agents.bench import run
from fp_operator_claims import MODES

# Formats with their numbers of stages.
CASES = [
    *(((8, 23), stages) for stages in range(4, 11)),
    *((small, stages) for small in [(3, 2), (7, 16)] for stages in [4, 10]),
]


@pytest.mark.parametrize(("number_format", "stages"), CASES)
def test_ti_fp_add(number_format, stages):
    exp_bits, frac_bits = number_format
    run(
        "ti_fp_add",
        "fp_operator_claims",
        ExpBits=exp_bits,
        FracBits=frac_bits,
        Stages=stages,
    )


@pytest.mark.parametrize("modes", MODES)
def test_ti_fp_add_in_other_modes(modes):
    run("ti_fp_add", "fp_operator_claims", Stages=5, **modes)
