# SPDX-License-Identifier: Apache-2.0
"""Registers in front of an ECP5's multiplier stand in it where nothing but their place changes."""

import pytest
from dsp_registers import use_multiplier_registers

CLOCK, ENABLE, OTHER = 2, 3, 4
WIDTH = 12


def design(**first):
    """A multiplier of two operands from registers; `first` changes the first register."""
    cells = {}
    pins = {f"{side}{k}": ["0"] for side in "AB" for k in range(18)}
    for number, side in enumerate("AB"):
        for k in range(WIDTH):
            bit = 100 + 50 * number + k
            cells[f"{side}{k}_q"] = {
                "type": "TRELLIS_FF",
                "parameters": {"CEMUX": "CE", "CLKMUX": "CLK"},
                "port_directions": {"CLK": "input", "CE": "input", "LSR": "input", "DI": "input"}
                | {"Q": "output"},
                "connections": {"CLK": [CLOCK], "CE": [ENABLE], "LSR": ["0"], "DI": [bit + 200]}
                | {"Q": [bit]},
            }
            pins[f"{side}{k}"] = [bit]
    for part, values in first.items():
        cells["A0_q"][part] |= values
    products = {f"P{k}": [900 + k] for k in range(36)}
    cells["product"] = {
        "type": "MULT18X18D",
        "parameters": {},
        "port_directions": dict.fromkeys(pins, "input") | dict.fromkeys(products, "output"),
        "connections": pins | products,
    }
    outputs = {"product_o": {"direction": "output", "bits": list(range(900, 924))}}
    return {"cells": cells, "ports": outputs}


def test_both_operands_move_with_their_clock_and_enable():
    module = design()
    assert use_multiplier_registers(module) == 1
    assert list(module["cells"]) == ["product"]
    product = module["cells"]["product"]
    ends = product["connections"]
    assert [ends[pin] for pin in ("CLK0", "CE0", "RST0")] == [[CLOCK], [ENABLE], ["0"]]
    assert [ends[f"A{k}"] for k in range(WIDTH)] == [[300 + k] for k in range(WIDTH)]
    assert [ends[f"B{k}"] for k in range(WIDTH)] == [[350 + k] for k in range(WIDTH)]
    assert ends["A17"] == ["0"]
    assert product["parameters"] == {
        f"REG_INPUT{side}_{kind}": f"{kind}0" for side in "AB" for kind in ("CLK", "CE", "RST")
    }


@pytest.mark.parametrize(
    "first",
    [
        {"connections": {"LSR": [OTHER]}},
        {"connections": {"CE": [OTHER]}},
        {"connections": {"CLK": [OTHER]}},
        {"parameters": {"CLKMUX": "INV"}},
        {"parameters": {"CEMUX": "INV"}},
        {"type": "LUT4"},
    ],
    ids=["reset", "enable", "clock", "falling-edge", "inverted-enable", "no-register"],
)
def test_a_register_that_differs_keeps_all_in_place(first):
    kind = first.pop("type", None)
    module = design(**first)
    if kind:
        module["cells"]["A0_q"]["type"] = kind
    assert use_multiplier_registers(module) == 0
    assert len(module["cells"]) == 2 * WIDTH + 1
    assert module["cells"]["product"]["connections"]["A0"] == [100]


def test_a_register_that_something_else_reads_stays_beside():
    module = design()
    module["ports"]["seen_o"] = {"direction": "output", "bits": [103]}
    assert use_multiplier_registers(module) == 1
    assert sorted(module["cells"]) == ["A3_q", "product"]


def test_what_comes_from_outside_stays_outside():
    module = design()
    for k in range(WIDTH):
        del module["cells"][f"B{k}_q"]
    assert use_multiplier_registers(module) == 0
