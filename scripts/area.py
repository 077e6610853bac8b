#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Cells of a configuration, or of one unit, on FPGA families and in standard cells.

Parts (docs/synthesis.md says what each column counts and where each factor is from):

  xcup xc7 ecp5 gowin   UltraScale+, 7 series, ECP5, GW2A: LUT, FF, DSP, BRAM, LUTRAM by Yosys
  osu018                gate equivalents; with CACTI's SRAM, mm2 at 65 nm
  sky130                um2 of the sky130_fd_sc_hd cells, without memories

The engine is read with its hierarchy; of equal instances of a unit one stands for all, so that each
distinct unit is mapped once, flattened inside, and counted as often as it is there.  Nothing is
optimized across the border of a unit.  The RAM bits that Yosys finds are compared with
those that the elaborated RTL asks for: a RAM that became registers ends with status 1.

Exit status: 0, 1 when RAM bits are missing or a baseline is exceeded, 2 for bad input.

Usage: scripts/area.py DIR [--part PART ...] [--unit MODULE ...] [--rtl DIR] [--json FILE]
         [--baseline FILE] [--record REASON]
DIR is the folder that scripts/configure.py wrote; logs go to `area` in it.
"""

import argparse
import re
import sys
import time
from pathlib import Path

import baselines
import cells
import operators
import silicon
from synthesis import (
    CUT_FILES,
    CUT_RAMS,
    RAM,
    ROOT,
    MeasureError,
    Synthesis,
    heading,
    memory_bits,
    memory_rows,
    rams,
    write_json,
)

# Modules that are mapped once each; what is in none of them is mapped with the top.
BORDERS = (*operators.UNITS, "ti_l2_bank", "ti_counters")
PARTS = (*cells.FPGAS, *silicon.LIBRARIES)
# A baseline may move so far, relative, before it is red.
TOLERANCES = {
    "LUT": 0.03,
    "FF": 0.02,
    "DSP": 0,
    "BRAM": 0,
    "LUTRAM": 0.02,
    "gate_equivalents": 0.03,
    "um2": 0.03,
    "ram_bits": 0,
}


class Area(Synthesis):
    """Cells of one configuration."""

    def __init__(self, folder: Path, rtl: Path):
        super().__init__(folder, rtl, "area")
        self._elaborated: dict[str, tuple[dict, int]] = {}

    def elaborated(self, top: str) -> tuple[dict[tuple, list[str]], int]:
        """Instances of BORDERS by module and parameters; bits that the RAM wrapper asks for."""
        if top not in self._elaborated:
            slang, root = operators.elaborate(self.packages[0], self.rtl, top, self.parameters(top))
            groups: dict[tuple, list[str]] = {}
            bits = 0

            def walk(instance, inside):
                nonlocal bits
                module = instance.definition.name
                if module in BORDERS and instance is not root and not inside:
                    key = operators.signature(instance.body)
                    groups.setdefault(key, []).append(instance.hierarchicalPath)
                    inside = True
                if module == RAM:
                    stored = operators.stored(instance.body)
                    bits += sum(width for _, is_array, width in stored if is_array)
                for symbol in operators.members(instance.body):
                    if symbol.kind == operators.ast.SymbolKind.Instance:
                        walk(symbol, inside)

            walk(root, False)
            self._elaborated[top] = groups, bits
            del slang
        return self._elaborated[top]

    def hierarchy(self, top: str) -> tuple[list[str], dict[str, int]]:
        """Commands that read a module with each distinct unit once; how often each stands there."""
        groups, _ = self.elaborated(top)
        commands, counts = self.marked(top), {top: 1}
        for (module, *_), paths in groups.items():
            kept = f"{module}${paths[0]}"
            counts[kept] = len(paths)
            commands += [f"chtype -set {kept} t:{pattern(module, path)}" for path in paths[1:]]
            commands.append(f"setattr -mod -set keep_hierarchy 1 {pattern(module, paths[0])}")
        return [*commands, f"hierarchy -check -top {top}", "flatten -noscopeinfo"], counts

    def memories(self, top: str) -> list[dict]:
        """Memories of a module of the configuration, those of equal units counted."""
        commands, counts = self.hierarchy(top)
        netlist = self.result(
            f"{top}.memories",
            f"{top}.memories.json",
            *commands,
            "opt_clean; opt_dff; opt_clean; memory -nomap",
            "write_json {out}",
        )
        return memory_rows(netlist["modules"], counts)

    def mapped(self, top: str, part: str) -> dict[str, tuple[int, dict]]:
        """Number of each unit and what `stat` says of one, on a part."""
        commands, counts = self.hierarchy(top)
        if part in cells.FPGAS:
            commands.append(f"{cells.FPGAS[part].command} -top {top}")
            stat = "stat -json"
        else:
            liberty, steps = silicon.library(part, self.work)
            commands += [f"synth -top {top} -run begin:fine", *CUT_RAMS, *CUT_FILES]
            commands += [f"synth -noabc -top {top} -run fine:check", *steps]
            stat = f"stat -json -liberty {liberty}"
        stat = f"tee -q -o {{out}} {stat}"
        found = self.result(f"{top}.{part}", f"{top}.{part}.json", *commands, stat)["modules"]
        found = {name.removeprefix("\\"): what for name, what in found.items()}
        if part not in cells.FPGAS:
            silicon.take_out_units(found)
        return {name: (count, found[name]) for name, count in counts.items()}


def pattern(module: str, path: str) -> str:
    """The name of an instance's module, for Yosys to match: brackets are no sets of characters."""
    return re.sub(r"[\[\]]", "?", f"{module}${path}")


def measure(design: Area, top: str, part: str) -> dict:
    """One module on one part: rows of units, the instances of one summed, and the sum of rows."""
    begin = time.monotonic()
    rows: dict[str, dict] = {}
    for name, (count, stat) in design.mapped(top, part).items():
        each = cells.columns(part, stat) if part in cells.FPGAS else silicon.columns(part, stat)
        row = rows.setdefault(name.partition("$")[0], {"count": 0, **dict.fromkeys(each, 0)})
        row["count"] += count
        for column, value in each.items():
            row[column] += count * value
    total = {c: sum(row[c] for row in rows.values()) for c in each}
    return {"rows": rows, **total, "seconds": time.monotonic() - begin}


def print_part(top: str, part: str, result: dict) -> None:
    """The table of one part: a line a unit, all of its instances, and their sum."""
    rows, columns = result["rows"], [c for c in result if c not in ("rows", "seconds")]
    what = cells.FPGAS[part].name if part in cells.FPGAS else silicon.LIBRARIES[part]
    print(f"\n{part}, {what}; {result['seconds']:.0f} s")
    print(f"{'':22}{'n':>4}" + "".join(f"{c.replace('_', ' '):>17}" for c in columns))
    for module in [*list(rows)[1:], top]:
        row, name = rows[module], "between" if module == top and rows.keys() > {top} else module
        print(f"{name:22}{row['count']:4}" + "".join(f"{row[c]:17,.10g}" for c in columns))
    if rows.keys() > {top}:
        print(f"{'all':26}" + "".join(f"{result[c]:17,.10g}" for c in columns))


def beside_published(design: Area, result: dict) -> dict[str, float]:
    """Prints the engine beside the published core; gate equivalents of its operators."""
    gates = {
        name: measure(design, module, "osu018")["gate_equivalents"]
        for module, name in operators.OPERATORS.items()
    }
    slang, root = operators.elaborate(design.packages[0], design.rtl)
    bits = operators.summary(operators.measure(root))["total"]["bits"]
    del slang
    silicon.print_published(result, gates, bits)
    return gates


def run(arguments: argparse.Namespace) -> int:
    """Measure what the arguments say and print the tables as they come."""
    design = Area(arguments.config, arguments.rtl)
    units, parts = arguments.unit or ["ti_engine"], arguments.part or PARTS
    for unit in units:
        design.known(unit)
    for part in parts:
        if part not in PARTS:
            raise MeasureError(f"{part}: no such part; there are {', '.join(PARTS)}")
        if part not in cells.FPGAS:
            silicon.available(part)
    status, results, compared = 0, {}, {}
    out = {**heading(design.config), "tolerances": TOLERANCES, "units": results}
    if set(parts) & set(silicon.LIBRARIES):
        out["factors"] = silicon.factors()
    for unit in units:
        print(f"{unit} of {design.config['name']}")
        memories = design.memories(unit)
        asked, found = design.elaborated(unit)[1], memory_bits(rams(memories))
        print(f"RAM bits: {asked} asked for by the RTL, {found} in its memories by Yosys")
        if asked != found:
            print(f"{unit}: {asked - found} bits of RAM became registers", file=sys.stderr)
            status = 1
        results[unit] = {"ram_bits": found, "ram_bits_asked": asked, "memories": memories}
        for part in parts:
            result = measure(design, unit, part)
            print_part(unit, part, result)
            if part == "osu018":
                result |= silicon.at_65_nm(result, memories)
                silicon.print_65_nm(result)
                if unit == "ti_engine":
                    result["operators"] = beside_published(design, result)
            results[unit][part] = result
            compared.setdefault(part, {})[unit] = {**result, "ram_bits": found}
            sys.stdout.flush()
            if arguments.json:
                write_json(arguments.json, out)
    for part, values in compared.items():
        one = {**out, "part": part, "units": values}
        status |= baselines.settle(arguments, one, tuple(TOLERANCES))
    return status


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("config", type=Path, metavar="DIR", help="folder of ti_config_pkg.sv")
    parser.add_argument(
        "--part", nargs="*", metavar="PART", help=f"of {', '.join(PARTS)}; else all"
    )
    parser.add_argument("--unit", nargs="*", metavar="MODULE", help="in place of ti_engine")
    parser.add_argument("--rtl", type=Path, default=ROOT / "rtl", help="folder of ti.f")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the result to FILE")
    baselines.add_arguments(parser)
    try:
        return run(parser.parse_args())
    except (MeasureError, operators.DesignError, OSError) as error:
        print(f"area: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
