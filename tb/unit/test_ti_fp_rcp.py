# SPDX-License-Identifier: Apache-2.0
"""`ti_fp_rcp` gives the rounded 1 / a of every operand after `Latency` cycles, one a cycle."""

import pytest
from agents.bench import run

FORMATS = [(3, 2), (7, 16), (8, 23)]


@pytest.mark.parametrize(("exp_bits", "frac_bits"), FORMATS)
def test_ti_fp_rcp(exp_bits, frac_bits):
    run("ti_fp_rcp", "fp_operator_claims", ExpBits=exp_bits, FracBits=frac_bits)


@pytest.mark.parametrize("bits_per_stage", [1, 3])
def test_ti_fp_rcp_with_other_stages(bits_per_stage):
    run(
        "ti_fp_rcp",
        "fp_operator_claims",
        ExpBits=7,
        FracBits=16,
        BitsPerStage=bits_per_stage,
    )
