# SPDX-License-Identifier: Apache-2.0
"""`ti_fp_rcp` gives the rounded 1 / a of every operand after `Latency` cycles, one a cycle.

By division or by Newton steps.
"""

import pytest
from agents.bench import run
from fp_operator_claims import MODES

FORMATS = [(3, 2), (7, 16), (8, 23)]

STAGES = [(2, 2), (2, 5), (3, 4)]  # bits a stage, end stages


@pytest.mark.parametrize(("bits_per_stage", "end_stages"), STAGES)
@pytest.mark.parametrize(("exp_bits", "frac_bits"), FORMATS)
def test_ti_fp_rcp(exp_bits, frac_bits, bits_per_stage, end_stages):
    run(
        "ti_fp_rcp",
        "fp_operator_claims",
        ExpBits=exp_bits,
        FracBits=frac_bits,
        BitsPerStage=bits_per_stage,
        EndStages=end_stages,
    )


def test_ti_fp_rcp_with_one_bit_a_stage():
    run("ti_fp_rcp", "fp_operator_claims", ExpBits=7, FracBits=16, BitsPerStage=1)


@pytest.mark.parametrize("modes", MODES)
def test_ti_fp_rcp_in_other_modes(modes):
    run("ti_fp_rcp", "fp_operator_claims", EndStages=3, **modes)


# A number of steps, of stages of a product, and a way to round each.
NEWTON = [
    {"ExpBits": 5, "FracBits": 10, "TableBits": 9, "NewtonSteps": 0, "EndStages": 5},
    {"ExpBits": 7, "FracBits": 16, "TableBits": 8, "NewtonSteps": 1, "TowardZero": 1, "Flush": 1},
    {"ExpBits": 8, "FracBits": 23, "TableBits": 7, "NewtonSteps": 2, "ProductStages": 2},
]


@pytest.mark.parametrize("newton", NEWTON, ids=lambda n: f"{n['FracBits']}-{n['NewtonSteps']}")
def test_ti_fp_rcp_by_newton_steps(newton):
    run("ti_fp_rcp", "fp_operator_claims", **newton)
