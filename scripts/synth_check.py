#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Read the engine as a synthesis tool does: no latch, no combinational loop, one driver a wire.

Yosys with its slang front end elaborates `ti_engine` and each unit of a configuration, flattened,
so that loops through several modules are seen.  The longer form also lists the memories (a clocked
read port can be block RAM, an asynchronous one is distributed RAM) and maps the operators, or the
unit named, to Lattice ECP5 for cell counts.

Exit status: 0 clean, 1 when a unit is not, 2 when the arguments are wrong.

Usage: scripts/synth_check.py DIR [--unit MODULE] [--quick | --cells] [--rtl DIR] [--json FILE]
DIR is the folder that scripts/configure.py wrote; logs go to `synth` in it.
"""

import argparse
import json
import re
import subprocess
import sys
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]

FORMAT = {"ExpBits": "exp_bits", "FracBits": "frac_bits"}
OPERATORS = ("ti_fp_add", "ti_fp_mul", "ti_fp_cmp", "ti_fp_rcp")


def cached(unit: str) -> dict[str, str]:
    """Parameters of a unit with slots and an L1, and their keys in the configuration."""
    return {
        "NumSlots": f"{unit}_slots",
        "Rows": f"{unit}_rows",
        "CacheBytes": f"{unit}_l1_bytes",
        "Ways": f"{unit}_l1_ways",
    }


STACK = {"StackDepth": "stack_depth", "Restart": "restart"}
STEPS = {**STACK, "WatchdogSteps": "watchdog_steps"}
ANY_HIT = {"AnyHit": "any_hit"}
# What `ti_engine` sets on its units; other modules are read with their defaults.
PARAMETERS = {
    **dict.fromkeys(OPERATORS, FORMAT),
    "ti_rd": {"NumTrv": "num_trv", "DealTile": "deal_tile", "RayCycles": "rd_cycles", **ANY_HIT},
    "ti_rd_clip": {"RayCycles": "rd_cycles", **ANY_HIT},
    "ti_trv": {**cached("trv"), **STEPS, **ANY_HIT},
    "ti_kd_decide": STEPS,
    "ti_trv_best": {"NumSlots": "trv_slots"},
    "ti_trv_retire": {"NumSlots": "trv_slots", **ANY_HIT},
    "ti_trv_return": {"NumSlots": "trv_slots", "Restart": "restart", **ANY_HIT},
    "ti_kd_state": {"NumSlots": "trv_slots", **STACK},
    "ti_ra": cached("ist1"),
    "ti_l1": {"CacheBytes": "ist1_l1_bytes", "Ways": "ist1_l1_ways"},
    "ti_l2_bank": {
        "NumUnits": "num_trv",
        "UnitIds": "trv_rows",
        "NumBanks": "trv_l2_banks",
        "Ways": "trv_l2_ways",
    },
    "ti_list": cached("list"),
    "ti_ist1": cached("ist1"),
}
UNITS = ("ti_rd", "ti_trv", "ti_list", "ti_ist1", "ti_ist2", *OPERATORS)

YOSYS = (
    "import sys; from pyosys import libyosys as y; d = y.Design(); "
    "[y.run_pass(c, d) for c in sys.argv[1:]]"
)


class Synthesis:
    """Yosys runs on one configuration."""

    def __init__(self, folder: Path, rtl: Path, work: str = "synth"):
        self.config = json.loads((folder / "config.json").read_text())
        self.packages = [folder / "ti_config_pkg.sv", folder / "ti_count_pkg.sv"]
        self.rtl = rtl
        self.work = folder / work
        self.work.mkdir(parents=True, exist_ok=True)

    def read(self, module: str) -> str:
        """Yosys command that elaborates a module of the configuration."""
        sources, options = [*self.packages], ["-DSYNTHESIS", f"--top {module}"]
        options.append(f"-I{self.packages[0].parent}")
        for word in (self.rtl / "ti.f").read_text().split():
            if word.startswith("+incdir+"):
                options.append(f"-I{self.rtl.parent / word.removeprefix('+incdir+')}")
            else:
                sources.append(self.rtl.parent / word)
        for name, key in PARAMETERS.get(module, {}).items():
            options.append(f"-G {name}={int(self.config[key])}")
        return " ".join(["read_slang", *options, *map(str, sources)])

    def run(self, name: str, *commands: str) -> tuple[bool, str]:
        """Whether Yosys took all commands, and its output, which stays in `work`."""
        log = self.work / f"{name}.log"
        with log.open("w") as out:
            done = subprocess.run(
                [sys.executable, "-c", YOSYS, *commands],
                stdout=out,
                stderr=subprocess.STDOUT,
                check=False,
            )
        text = log.read_text(errors="replace")
        # An error ends the interpreter; its status says so only in some versions.
        return done.returncode == 0 and not re.search(r"^ERROR:", text, re.MULTILINE), text

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
        found = self.work / f"{module}.memories.json"
        good, text = self.run(
            f"{module}.memories",
            self.read(module),
            "opt_clean; opt_dff; opt_clean; memory -nomap",
            "select t:$mem_v2",
            f"write_json -selected {found}",
        )
        if not good:
            raise SystemExit(text)
        counts = Counter()
        for part in json.loads(found.read_text())["modules"].values():
            for name, cell in part["cells"].items():
                value = {k: int(v, 2) for k, v in cell["parameters"].items() if set(v) <= {*"01"}}
                ports = (value["RD_PORTS"], value["WR_PORTS"])
                clocked = cell["parameters"]["RD_CLK_ENABLE"].count("1") == ports[0] > 0
                name = re.sub(r"\[\d+\]", "", name)
                counts[(name, value["SIZE"], value["WIDTH"], *ports, clocked)] += 1
        keys = ("name", "words", "bits", "read_ports", "write_ports", "clocked_read", "count")
        rows = [dict(zip(keys, (*key, count), strict=True)) for key, count in counts.items()]
        return sorted(rows, key=lambda r: (-r["words"] * r["bits"] * r["count"], r["name"]))

    def cells(self, module: str) -> dict[str, int]:
        """Cells of a module mapped to ECP5."""
        out = self.work / f"{module}.stat.json"
        good, text = self.run(
            f"{module}.ecp5",
            self.read(module),
            f"synth_ecp5 -noabc9 -top {module}",
            f"tee -q -o {out} stat -json",
        )
        if not good:
            raise SystemExit(text)
        return json.loads(out.read_text())["design"]["num_cells_by_type"]


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
        bits = sum(
            r["words"] * r["bits"] * r["count"] for r in rows if r["clocked_read"] == clocked
        )
        count = sum(r["count"] for r in rows if r["clocked_read"] == clocked)
        print(f"{count} memories with {what}, {bits / 8192:.1f} KB")


def print_cells(cells: dict[str, dict[str, int]]) -> None:
    """One line a module; the headings are ECP5 cell types, most frequent first."""
    total = sum((Counter(c) for c in cells.values()), Counter())
    names = [name for name, _ in total.most_common()]
    print(f"\n{'ECP5 cells':14}" + "".join(f"{n:>17}" for n in names))
    for module, counts in cells.items():
        print(f"{module:14}" + "".join(f"{counts.get(n, 0):17}" for n in names))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("config", type=Path, metavar="DIR", help="folder of ti_config_pkg.sv")
    parser.add_argument("--unit", metavar="MODULE", help="this module instead of all")
    parts = parser.add_mutually_exclusive_group()
    parts.add_argument("--quick", action="store_true", help="no tables of memories and cells")
    parts.add_argument("--cells", action="store_true", help="the table of cells alone")
    parser.add_argument("--rtl", type=Path, default=ROOT / "rtl", help="folder of ti.f")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the counts to FILE")
    arguments = parser.parse_args()
    unit = arguments.unit
    if not (arguments.config / "config.json").is_file():
        print(
            f"{arguments.config}: no config.json; scripts/configure.py writes it", file=sys.stderr
        )
        return 2
    if unit and not any(arguments.rtl.rglob(f"{unit}.sv")):
        print(f"{unit}: there is no such module in {arguments.rtl}", file=sys.stderr)
        return 2

    synthesis = Synthesis(arguments.config, arguments.rtl)
    bad = 0
    for module in [] if arguments.cells else [unit] if unit else ["ti_engine", *UNITS]:
        problems = synthesis.check(module)
        bad += bool(problems)
        print(f"synth: {module}: {'NOT clean' if problems else 'no latch, no loop, one driver'}")
        if problems:
            print("\n".join(problems), f"\nwhole output: {synthesis.work / module}.log")
    if bad or arguments.quick:
        return 1 if bad else 0

    memories = [] if arguments.cells else synthesis.memories(unit or "ti_engine")
    if memories:
        print_memories(memories)
    cells = {module: synthesis.cells(module) for module in ([unit] if unit else OPERATORS)}
    print_cells(cells)
    if arguments.json:
        arguments.json.parent.mkdir(parents=True, exist_ok=True)
        result = {"config": synthesis.config, "memories": memories, "ecp5_cells": cells}
        arguments.json.write_text(json.dumps(result, indent=2) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
