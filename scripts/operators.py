#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Count the floating-point operators and the memory bits of the elaborated engine.

Walks the instances of `ti_engine` as the compiler slang elaborates them and sums, for each kind of
unit, the instances of `ti_fp_add`, `ti_fp_mul`, `ti_fp_rcp` and `ti_fp_cmp` and the bits of
everything that an `always_ff` assigns.  The operators stand beside the published core (Nah et al.
2011), whose counts for one unit are the budget, but for the reciprocals of RD; the memory beside
its register files and caches.

Exit status: 0 within the budget and what `agreed` allows, 1 when a unit has more operators, 2 when
the design cannot be read.

Usage: scripts/operators.py DIR [--rtl DIR] [--json FILE]
DIR is the folder that scripts/configure.py wrote.
"""

import argparse
import json
import sys
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from pyslang import ast, driver

ROOT = Path(__file__).resolve().parents[1]

# Module of an operator and its heading.
OPERATORS = {"ti_fp_add": "ADD", "ti_fp_mul": "MUL", "ti_fp_rcp": "RCP", "ti_fp_cmp": "CMP"}

# Module of a unit, its heading, and the published operators of one unit in the order of OPERATORS.
UNITS = {
    "ti_rd": ("RD", (6, 9, 1, 12)),
    "ti_trv": ("TRV", (1, 1, 0, 3)),
    "ti_list": ("LIST", (0, 0, 0, 0)),
    "ti_ist1": ("IST1", (7, 7, 0, 3)),
    "ti_woop_ist1": ("IST1", (7, 7, 0, 3)),
    "ti_ist2": ("IST2", (0, 3, 1, 0)),
    "ti_woop_ist2": ("IST2", (0, 3, 1, 0)),
}
# mm2 of the published core, and of one operator in its area table.
PAPER_MM2 = {"core": 12.12, "ADD": 0.003, "MUL": 0.01, "RCP": 0.11, "CMP": 0.00072}


def agreed(config: dict) -> dict[tuple[str, str], int]:
    """What a unit may have above the published budget, by heading and operator (decisions.md)."""
    padded = config["traversal"] == "padded"  # thick rays (accuracy.md)
    woop = config["triangle_test"] == "woop"  # another test than the published one
    lanes = 4 - config["rd_cycles"]
    more = {
        ("RD", "ADD"): 6 * lanes - 6 if padded else 0,
        ("RD", "RCP"): lanes - 1,  # each lane has its own
        ("TRV", "ADD"): int(padded),
        ("TRV", "MUL"): int(padded),
        # A token home every cycle, and beside a stage of comparison also the one in front of it.
        ("TRV", "CMP"): 2 + (2 - padded) * config["fp_cmp_stages"] + 4 * padded,
        ("IST1", "ADD"): 11 * woop,
        ("IST1", "MUL"): 5 if woop else int(config["interval_cull"]),  # its near end
        ("IST2", "ADD"): 4 * woop,
        ("IST2", "MUL"): 4 * woop,
    }
    return {place: count for place, count in more.items() if count}


BETWEEN = "between"  # in no unit: arbiters, crossbars, memory port

# Kinds of storage, in the order of the table.
STORES = {
    "slots": "RAM of the slots and stacks",
    "queues": "words of queues",
    "delays": "operands beside pipelines",
    "arrays": "other arrays",
    "registers": "single registers, those in the operators included",
    "counters": "counters of events",
    "l1_lines": "L1 lines",
    "l1_tags": "L1 tags and state",
    "l2_lines": "L2 lines",
    "l2_tags": "L2 tags and state",
}
# What the published core calls register files; its registers and counters are not given.
REGISTER_FILES = ("slots", "queues", "delays", "arrays")
PAPER_KB = {"register files": 476, "L1": 344, "L2": 288}


class DesignError(Exception):
    """The sources do not elaborate."""


@dataclass
class Unit:
    """What one unit instance holds."""

    path: str
    operators: Counter = field(default_factory=Counter)
    bits: Counter = field(default_factory=Counter)


def elaborate(
    package: Path, rtl: Path, module: str = "ti_engine", parameters: dict[str, int] | None = None
) -> tuple[driver.Driver, ast.InstanceSymbol]:
    """A module with the configuration `package`; the compiler's messages go to the terminal.

    The sources live in the driver, which the caller keeps as long as the instance.
    """
    slang = driver.Driver()
    slang.addStandardArgs()
    sources = [package, package.with_name("ti_count_pkg.sv")]
    include = [package.parent]
    for line in (rtl / "ti.f").read_text().split():
        if line.startswith("+incdir+"):
            include.append(rtl.parent / line.removeprefix("+incdir+"))
        else:
            sources.append(rtl.parent / line)
    options = ["--top", module, "-DSYNTHESIS", *(f"-I{path}" for path in include)]
    for name, value in (parameters or {}).items():
        options += ["-G", f"{name}={value}"]
    words = ["slang", *options, *sources]
    good = slang.parseCommandLine(" ".join(f'"{word}"' for word in words))
    if not (good and slang.processOptions() and slang.parseAllSources()):
        raise DesignError(f"{rtl}/ti.f: slang cannot read the sources")
    compilation = slang.createCompilation()
    slang.reportCompilation(compilation, True)
    if not slang.reportDiagnostics(True):
        raise DesignError(f"{rtl}/ti.f: {module} does not elaborate; the messages above say where")
    return slang, compilation.getRoot().topInstances[0]


def members(scope):
    """Symbols of a module body, those in its instantiated generate blocks included."""
    for symbol in scope:
        if symbol.kind == ast.SymbolKind.GenerateBlock:
            if not symbol.isUninstantiated:
                yield from members(symbol)
        elif symbol.kind in (ast.SymbolKind.GenerateBlockArray, ast.SymbolKind.InstanceArray):
            yield from members(symbol)
        else:
            yield symbol


def target(expression):
    """(variable, member names, type, no index on the way) of what an assignment writes.

    Names and type go as far as the first index.
    """
    if expression.kind == ast.ExpressionKind.NamedValue:
        return expression.symbol, (), expression.type, True
    if expression.kind == ast.ExpressionKind.MemberAccess:
        symbol, names, kind, whole = target(expression.value)
        if whole:
            return symbol, (*names, expression.member.name), expression.type, True
        return symbol, names, kind, False
    symbol, names, kind, _ = target(expression.value)
    return symbol, names, kind, False


def stored(body) -> list[tuple[str, bool, int]]:
    """(name, is an array, bits) of each variable, or member of one, that an `always_ff` assigns."""
    written = {}

    def note(node):
        if isinstance(node, ast.AssignmentExpression) and node.isNonBlocking:
            lefts = [node.left]
            if node.left.kind == ast.ExpressionKind.Concatenation:
                lefts = list(node.left.operands)
            for left in lefts:
                symbol, names, kind, _ = target(left)
                written[(symbol.hierarchicalPath, *names)] = (symbol.name, kind)

    for symbol in members(body):
        if symbol.kind == ast.SymbolKind.ProceduralBlock:
            symbol.visit(note)
    # A member counts once where its whole is written too.
    alone = {
        key: value
        for key, value in written.items()
        if not any(key[:n] in written for n in range(1, len(key)))
    }
    return [(name, kind.isUnpackedArray, kind.bitstreamWidth) for name, kind in alone.values()]


def signature(body):
    """Equal for two instances of a module that hold the same bits."""
    values = []
    for parameter in body.parameters:
        if parameter.kind == ast.SymbolKind.TypeParameter:
            values.append(parameter.targetType.type.bitstreamWidth)
        else:
            values.append(str(parameter.value))
    return (body.definition.name, *values)


def store_kind(modules: list[str], instance: str, name: str, is_array: bool) -> str:
    """Which of STORES a variable is, from the modules around it and the instance it is in."""
    module = modules[-1]
    if module == "ti_counters":
        return "counters"
    if "ti_l1" in modules and not (module == "ti_ram_1r1w" and not is_array):
        level = "l2" if "ti_l2_bank" in modules else "l1"
        return f"{level}_lines" if instance == "u_lines" else f"{level}_tags"
    if module == "ti_delay":
        return "delays"
    if module == "ti_fifo" and name == "data_q":
        return "queues"
    if not is_array:
        return "registers"
    if module == "ti_ram_1r1w":
        return "slots"
    return "queues" if "ti_fifo" in modules else "arrays"


def measure(top) -> dict[str, list[Unit]]:
    """Units by heading; what is in no unit is one more, BETWEEN."""
    units = {heading: [] for heading, _ in UNITS.values()}
    between = Unit(top.name)
    known = {}

    def walk(instance, modules, unit):
        module = instance.definition.name
        modules = [*modules, module]
        if module in UNITS:
            unit = Unit(instance.hierarchicalPath)
            units[UNITS[module][0]].append(unit)
        if module in OPERATORS:
            unit.operators[OPERATORS[module]] += 1
        key = signature(instance.body)
        if key not in known:
            known[key] = stored(instance.body)
        for name, is_array, bits in known[key]:
            unit.bits[store_kind(modules, instance.name, name, is_array)] += bits
        for symbol in members(instance.body):
            if symbol.kind == ast.SymbolKind.Instance:
                walk(symbol, modules, unit)

    walk(top, [], between)
    return {**units, BETWEEN: [between]}


def excess(units: dict[str, list[Unit]], config: dict) -> list[str]:
    """One sentence for the first unit of a kind with more of an operator than it may have."""
    budgets = dict(UNITS.values())
    budgets[BETWEEN] = (0, 0, 0, 0)
    found = []
    for heading, instances in units.items():
        for name, published in zip(OPERATORS.values(), budgets[heading], strict=True):
            more = agreed(config).get((heading, name), 0)
            for unit in instances:
                if unit.operators[name] > published + more:
                    found.append(
                        f"{unit.path}: {unit.operators[name]} {name}, the published {heading} "
                        f"has {published}" + (f" and ours may have {more} more" if more else "")
                    )
                    break
    return found


def summary(units: dict[str, list[Unit]]) -> dict:
    """Counts by heading, as `--json` writes them; bits are bits."""
    names = list(OPERATORS.values())
    budgets = dict(UNITS.values())
    kinds = {}
    for heading, instances in units.items():
        budget = budgets.get(heading, (0, 0, 0, 0))
        kinds[heading] = {
            "units": len(instances),
            "operators": {n: sum(u.operators[n] for u in instances) for n in names},
            "published": {n: b * len(instances) for n, b in zip(names, budget, strict=True)},
            "bits": {s: sum(u.bits[s] for u in instances) for s in STORES},
        }
    total = {
        "operators": {n: sum(k["operators"][n] for k in kinds.values()) for n in names},
        "published": {n: sum(k["published"][n] for k in kinds.values()) for n in names},
        "bits": {s: sum(k["bits"][s] for k in kinds.values()) for s in STORES},
    }
    return {"kinds": kinds, "total": total}


def kilobytes(bits: int) -> str:
    """Bits as KB of 1024 bytes; `-` for none."""
    return f"{bits / 8192:.1f}" if bits else "-"


def print_table(name: str, numbers: dict, config: dict) -> None:
    """The two tables for people."""
    kinds, total = numbers["kinds"], numbers["total"]
    names = list(OPERATORS.values())
    print(f"FP operators of configuration {name}: ours/published, budget of one unit times units\n")
    print(f"{'unit':8}{'n':>4}" + "".join(f"{n:>9}" for n in names))
    rows = [(h, str(k["units"]), k) for h, k in kinds.items() if h != BETWEEN]
    for heading, count, kind in [*rows, ("total", "", total)]:
        cells = [f"{kind['operators'][n]}/{kind['published'][n]}" for n in names]
        print(f"{heading:8}{count:>4}" + "".join(f"{c:>9}" for c in cells))
    for heading, operator in agreed(config):
        more = kinds[heading]["operators"][operator] - kinds[heading]["published"][operator]
        area = more * PAPER_MM2[operator]
        share = area / PAPER_MM2["core"]
        print(
            f"{heading}: {more} {operator} more than published, {area:.4f} mm2 at the published "
            f"{PAPER_MM2[operator]}, {share:.2%} of the core's {PAPER_MM2['core']}"
        )

    print("\nMemory in KB (1024 bytes)\n")
    print(f"{'unit':8}{'n':>4}" + "".join(f"{s:>11}" for s in STORES))
    for heading, kind in [*kinds.items(), ("total", total)]:
        count = str(kind["units"]) if "units" in kind else ""
        cells = "".join(f"{kilobytes(kind['bits'][s]):>11}" for s in STORES)
        print(f"{heading:8}{count:>4}{cells}")
    print()
    for store, meaning in STORES.items():
        print(f"  {store:10} {meaning}")

    bits = total["bits"]
    files = sum(bits[s] for s in REGISTER_FILES)
    rows = [
        (" + ".join(REGISTER_FILES), files, "register files"),
        ("the same with registers", files + bits["registers"], ""),
        ("l1_lines", bits["l1_lines"], "L1"),
        ("l2_lines", bits["l2_lines"], "L2"),
    ]
    print(f"\n{'KB':34}{'ours':>8}{'published':>11}")
    for what, ours, theirs in rows:
        print(f"{what:34}{kilobytes(ours):>8}{PAPER_KB.get(theirs, '-'):>11} {theirs}".rstrip())


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("config", type=Path, metavar="DIR", help="folder of ti_config_pkg.sv")
    parser.add_argument("--rtl", type=Path, default=ROOT / "rtl", help="folder of ti.f")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the counts to FILE")
    arguments = parser.parse_args()
    package = arguments.config / "ti_config_pkg.sv"
    if not package.is_file():
        print(f"{package}: no such file; scripts/configure.py writes it", file=sys.stderr)
        return 2
    try:
        _slang, top = elaborate(package, arguments.rtl)
        units = measure(top)
    except (DesignError, OSError) as error:
        print(error, file=sys.stderr)
        return 2
    numbers = summary(units)
    config = json.loads((arguments.config / "config.json").read_text())
    print_table(config["name"], numbers, config)
    if arguments.json:
        arguments.json.parent.mkdir(parents=True, exist_ok=True)
        arguments.json.write_text(
            json.dumps({"config": config, "paper_kb": PAPER_KB, **numbers}, indent=2) + "\n"
        )
    above = excess(units, config)
    for sentence in above:
        print(sentence, file=sys.stderr)
    return 1 if above else 0


if __name__ == "__main__":
    sys.exit(main())
