# SPDX-License-Identifier: Apache-2.0
"""Mapped netlists as Yosys writes them in JSON: names that the RTL has for registers; buffers."""

import re

# Flops of the OSU cells, of ECP5 and of Gowin, and their output.
REGISTERS = re.compile(r"^(DFF|LATCH|TRELLIS_FF|DL)")
INDEX = re.compile(r"\[\d+\]$")
READ = re.compile(r"^\$\\?(.*)\$rdreg\[\d+\]\$q")  # the register that Yosys moved behind an array


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
        return READ.sub(r"\1", self.net(found["connections"]["Q"][0]))


def word(name: str) -> str:
    """The register without the number of its bit."""
    return INDEX.sub("", name)


OUTPUTS = ("Y", "Q", "YS", "YC")  # of the OSU cells
FANOUT = 12  # sinks of a register or a buffer


def buffer_registers(module: dict) -> int:
    """Put trees of OSU buffers behind registers with more than FANOUT sinks; how many buffers.

    abc buffers what gates drive, but takes a register to drive any load at once.
    """
    sinks: dict[int, list] = {}
    roots = []
    for cell in module["cells"].values():
        for pin, bits in cell["connections"].items():
            if pin not in OUTPUTS:
                sinks.setdefault(bits[0], []).append((cell, pin))
            elif REGISTERS.match(cell["type"]):
                roots.append(bits[0])
    free = 1 + max(
        b for net in module["netnames"].values() for b in net["bits"] if isinstance(b, int)
    )
    count = 0
    for root in roots:
        level = sinks.get(root, [])
        while len(level) > FANOUT:
            above = []
            for at in range(0, len(level), FANOUT):
                buffer = {
                    "hide_name": 0,
                    "type": "BUFX4",
                    "parameters": {},
                    "attributes": {},
                    "connections": {"A": [root], "Y": [free]},
                }
                for cell, pin in level[at : at + FANOUT]:
                    cell["connections"][pin] = [free]
                module["cells"][f"buffer_{count}"] = buffer
                module["netnames"][f"buffered_{count}"] = {
                    "hide_name": 1,
                    "bits": [free],
                    "attributes": {},
                }
                above.append((buffer, "A"))
                free, count = free + 1, count + 1
            level = above
    return count
