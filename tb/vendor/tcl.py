# SPDX-License-Identifier: Apache-2.0
"""Scripts and constraints in a real Tcl interpreter, with stand-ins for vendors' commands."""

import json
import subprocess
from pathlib import Path

from elaborated import Block, spell

HERE = Path(__file__).resolve().parent


def names(collection: str) -> list[str]:
    """Names of a list of Tcl; none of ours has a space or a brace."""
    return collection.replace("{", " ").replace("}", " ").split()


class Tcl:
    """What scripts see of a block."""

    def __init__(self, block: Block, tool: str):
        self._tool = tool
        separator = {"vivado": "/", "quartus": "|"}[tool]
        ports = [
            n if bits == 1 else f"{n}[{bit}]"
            for n, bits in block.ports().items()
            for bit in range(bits)
        ]
        inputs = [port for port in ports if port.partition("[")[0] in block.inputs()]
        cells, clocks, self.register_of = [], {}, {}
        clock_of = block.clocks_outside_of_engine()
        for path, bits in block.cells().items():
            for cell in spell(path, bits, tool):
                cells.append(cell)
                self.register_of[cell] = ".".join(path)
                if ".".join(path) in clock_of:
                    clocks[cell] = clock_of[".".join(path)]
        instances = [separator.join(path) for path in block.instances()]
        lists = {"ports": ports, "inputs": inputs, "cells": cells, "instances": instances}
        self._objects = "".join(
            f"set ti_{name} [list {' '.join(f'{{{word}}}' for word in values)}]\n"
            for name, values in lists.items()
        )
        for cell, clock in clocks.items():
            self._objects += f"set {{ti_cell_clocks({cell})}} {clock}\n"

    def run(self, folder: Path, text: str, *arguments: object) -> tuple[list[list[str]], str]:
        """Commands of the tool that a script gives, with arguments, and the error that ends it."""
        script = folder / "stand_in.tcl"
        sources = [HERE / "record.tcl", HERE / f"{self._tool}.tcl"]
        script.write_text(
            self._objects + "".join(f"source {{{path}}}\n" for path in sources) + text + "\n"
        )
        done = subprocess.run(
            ["tclsh", script, *map(str, arguments)],
            cwd=folder,
            capture_output=True,
            text=True,
            check=False,
        )
        lines = [line for line in done.stdout.splitlines() if line.startswith("RECORD ")]
        return [json.loads(line.removeprefix("RECORD ")) for line in lines], done.stderr

    def constraints(self, folder: Path, *files: Path) -> tuple[list[list[str]], str]:
        """The same for files of constraints, one after the other."""
        return self.run(folder, "".join(f"source {{{path}}}\n" for path in files))


def values(record: list[str], option: str) -> list[str]:
    """The names behind an option of a command."""
    return names(record[record.index(option) + 1]) if option in record else []
