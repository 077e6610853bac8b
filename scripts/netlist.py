# SPDX-License-Identifier: Apache-2.0
"""Names that the RTL has for registers of a mapped netlist, as Yosys writes it in JSON."""

import re

# Flops of the OSU cells, of ECP5 and of Gowin, and their output.
REGISTERS = re.compile(r"^(DFF|LATCH|TRELLIS_FF|DL)")
INDEX = re.compile(r"\[\d+\]$")


class Netlist:
    """One module: nets by bit, registers by cell."""

    def __init__(self, module: dict):
        self._module = module
        self._names: dict[int, tuple] = {}
        for name, net in module["netnames"].items():
            # Names of the RTL before those of the harness and of Yosys, then the shortest.
            made = name.startswith("harness_") or bool(re.search(r"_[A-Z]\w*_[A-Z]\d?(_|$)", name))
            rank = (net["hide_name"], made, len(name))
            for index, bit in enumerate(net["bits"]):
                text = name if len(net["bits"]) == 1 else f"{name}[{index}]"
                if bit not in self._names or (*rank, text) < self._names[bit]:
                    self._names[bit] = (*rank, text)

    def net(self, bit: int) -> str:
        """The name of a net."""
        return self._names[bit][-1] if bit in self._names else f"net {bit}"

    def register(self, cell: str) -> str:
        """The register that a cell is a bit of, by what it drives; else the cell's own name."""
        found = self._module["cells"].get(cell)
        if found is None or not REGISTERS.match(found["type"]) or not found["connections"].get("Q"):
            return cell
        return self.net(found["connections"]["Q"][0])


def word(name: str) -> str:
    """The register without the number of its bit."""
    return INDEX.sub("", name)
