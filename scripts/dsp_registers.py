# SPDX-License-Identifier: Apache-2.0
"""Registers in front of a multiplier, moved into the ECP5's MULT18X18D.

Yosys leaves a multiplier of an ECP5 without its own registers; vendor tools use them.  Where every
bit of both operands comes from a register with one clock and one enable and without reset, the
multiplier takes over these registers, and those that nothing else reads are gone.
"""

from collections import defaultdict

MULTIPLIER, REGISTER = "MULT18X18D", "TRELLIS_FF"
OPERANDS = ("A", "B")
BITS = 18
# What a register must be to stand in a multiplier.
PLAIN = {"CEMUX": "CE", "CLKMUX": "CLK"}


def use_multiplier_registers(module: dict) -> int:
    """Moves the registers of one module of Yosys's JSON; the number of multipliers changed."""
    cells = module["cells"]
    driver, sinks = {}, defaultdict(int)
    for name, cell in cells.items():
        for port, bits in cell["connections"].items():
            for bit in bits:
                if cell["port_directions"][port] == "output":
                    driver[bit] = name
                else:
                    sinks[bit] += 1
    for port in module["ports"].values():
        if port["direction"] == "output":
            for bit in port["bits"]:
                sinks[bit] += 1
    changed = 0
    for cell in [c for c in cells.values() if c["type"] == MULTIPLIER]:
        pins = [f"{side}{k}" for side in OPERANDS for k in range(BITS)]
        nets = {pin: cell["connections"][pin][0] for pin in pins}
        nets = {pin: net for pin, net in nets.items() if isinstance(net, int)}
        registers = {pin: cells.get(driver.get(net)) for pin, net in nets.items()}
        if not registers or not all(movable(r) for r in registers.values()):
            continue
        controls = {
            (r["connections"]["CLK"][0], r["connections"]["CE"][0]) for r in registers.values()
        }
        if len(controls) != 1:
            continue
        clock, enable = controls.pop()
        for pin, register in registers.items():
            sinks[nets[pin]] -= 1
            cell["connections"][pin] = register["connections"]["DI"]
            sinks[register["connections"]["DI"][0]] += 1
        for port, net in (("CLK0", clock), ("CE0", enable), ("RST0", "0")):
            cell["connections"][port] = [net]
            cell["port_directions"][port] = "input"
        for side in OPERANDS:
            for kind in ("CLK", "CE", "RST"):
                cell["parameters"][f"REG_INPUT{side}_{kind}"] = f"{kind}0"
        changed += 1
    for name in [n for n, c in cells.items() if c["type"] == REGISTER]:
        if not any(sinks[bit] for bit in cells[name]["connections"]["Q"]):
            del cells[name]
    return changed


def movable(cell: dict | None) -> bool:
    """Whether a register may stand in a multiplier: no reset, both edges of control as drawn."""
    return (
        cell is not None
        and cell["type"] == REGISTER
        and cell["connections"].get("LSR", ["0"]) == ["0"]
        and "M" not in cell["connections"]
        and all(cell["parameters"].get(k, v) == v for k, v in PLAIN.items())
    )
