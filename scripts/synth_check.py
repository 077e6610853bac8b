#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Read the engine as a synthesis tool does: no latch, no combinational loop, one driver a wire.

Yosys with its slang front end elaborates `ti_engine` and each unit of a configuration, flattened,
so that loops through several modules are seen.  The longer form also lists the memories: a clocked
read port can be block RAM, an asynchronous one is distributed RAM.  `scripts/area.py` counts cells.

Exit status: 0 clean, 1 when a unit is not, 2 when the arguments are wrong.

Usage: scripts/synth_check.py DIR [--unit MODULE] [--quick] [--rtl DIR] [--json FILE]
DIR is the folder that scripts/configure.py wrote; logs go to `synth` in it.
"""

import argparse
import re
import sys
from pathlib import Path

from synthesis import (
    ROOT,
    UNITS,
    MeasureError,
    Synthesis,
    heading,
    memory_bits,
    memory_rows,
    write_json,
)


class Check(Synthesis):
    """What a synthesis tool would find wrong with one configuration, and its memories."""

    def check(self, module: str) -> list[str]:
        """What is wrong with a module, in Yosys' words; nothing when it is clean."""
        good, text = self.run(
            module,
            self.read(module),
            "check",
            "select -list t:$dlatch t:$adlatch t:$dlatchsr t:$sr",
            "select -assert-none t:$dlatch t:$adlatch t:$dlatchsr t:$sr",
            "check -assert",
        )
        if good:
            return []
        problems = re.findall(
            r"^(?:Warning|ERROR): .*(?:\n {4}.*)*|^\S+:\d+: ERROR: .*", text, re.M
        )
        latches = text.partition("Running command `select -list")[2].partition("\n-- ")[0]
        problems += [f"latch {line}" for line in latches.splitlines() if re.match(r"\w+/", line)]
        return list(dict.fromkeys(problems)) or [text.strip().rpartition("\n")[2]]

    def memories(self, module: str) -> list[dict]:
        """Memories of a module: name without indices, how many, words, bits a word, ports."""
        netlist = self.result(
            f"{module}.memories",
            f"{module}.memories.json",
            self.read(module),
            "opt_clean; opt_dff; opt_clean; memory -nomap",
            "select t:$mem_v2",
            "write_json -selected {out}",
        )
        return memory_rows(netlist["modules"])


def print_memories(rows: list[dict]) -> None:
    """The table of memories: all that can be block RAM, the larger ones of the others."""
    print(f"\n{'memory':52}{'n':>4}{'words':>7}{'bits':>6}{'R':>3}{'W':>3}  read")
    for row in rows:
        if row["clocked_read"] or row["words"] * row["bits"] >= 1024:
            print(
                f"{row['name']:52}{row['count']:4}{row['words']:7}{row['bits']:6}"
                f"{row['read_ports']:3}{row['write_ports']:3}  "
                f"{'clocked' if row['clocked_read'] else 'asynchronous'}"
            )
    for clocked, what in [(True, "clocked reads"), (False, "asynchronous reads")]:
        chosen = [row for row in rows if row["clocked_read"] == clocked]
        bits, count = memory_bits(chosen), sum(row["count"] for row in chosen)
        print(f"{count} memories with {what}, {bits / 8192:.1f} KB")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("config", type=Path, metavar="DIR", help="folder of ti_config_pkg.sv")
    parser.add_argument("--unit", metavar="MODULE", help="this module instead of all")
    parser.add_argument("--quick", action="store_true", help="no table of memories")
    parser.add_argument("--rtl", type=Path, default=ROOT / "rtl", help="folder of ti.f")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the counts to FILE")
    arguments = parser.parse_args()
    try:
        return run(arguments)
    except (MeasureError, OSError) as error:
        print(f"synth: {error}", file=sys.stderr)
        return 2


def run(arguments: argparse.Namespace) -> int:
    """Check what the arguments say; 1 when something is not clean."""
    unit = arguments.unit
    synthesis = Check(arguments.config, arguments.rtl)
    if unit:
        synthesis.known(unit)
    bad = 0
    for module in [unit] if unit else ["ti_engine", *UNITS]:
        problems = synthesis.check(module)
        bad += bool(problems)
        print(f"synth: {module}: {'NOT clean' if problems else 'no latch, no loop, one driver'}")
        if problems:
            print("\n".join(problems), f"\nwhole output: {synthesis.work / module}.log")
    if bad or arguments.quick:
        return 1 if bad else 0

    memories = synthesis.memories(unit or "ti_engine")
    if memories:
        print_memories(memories)
    if arguments.json:
        write_json(arguments.json, {**heading(synthesis.config), "memories": memories})
    return 0


if __name__ == "__main__":
    sys.exit(main())
