# SPDX-License-Identifier: Apache-2.0
"""What `rtl/count/counters.yaml` becomes: a package, a C++ header, the table of docs/counters.md.

Event i of a unit is bit i of its struct and counter i of its bank: activities first, then the
unit's own events, then those of its cache.

Usage: scripts/counters.py --check FILE | --write FILE      the table of docs/counters.md
"""

import argparse
import sys
from pathlib import Path

import yaml

SOURCE = Path(__file__).resolve().parents[1] / "rtl/count/counters.yaml"
HEAD = "// SPDX-License-Identifier: Apache-2.0\n"


def description() -> dict:
    """{"activity": {name: text}, "cache": {...}, "units": {unit: {name: text, "cache": True}}}."""
    return yaml.safe_load(SOURCE.read_text())


def kinds(table: dict) -> dict[str, str]:
    """Kinds of units in the order of their numbers: name -> its unit in the table."""
    return {
        f"{of}_{unit}" if of else unit: unit
        for unit, entry in table["units"].items()
        for of in entry.get("of", [""])
    }


def own_events(table: dict, unit: str) -> dict[str, str]:
    return {k: v for k, v in table["units"][unit].items() if k not in ("cache", "of")}


def events(table: dict, unit: str) -> dict[str, str]:
    """Names and meanings of a unit's events, in the order of their numbers."""
    own = own_events(table, unit)
    cache = table["cache"] if has_cache(table, unit) else {}
    return {**table["activity"], **own, **cache}


def has_cache(table: dict, unit: str) -> bool:
    return table["units"][unit].get("cache", False)


def counts_of(config: dict[str, int]) -> dict[str, int]:
    """How many units of each kind a core has."""
    readers = ("trv", "list", "ist1")
    replicated = {unit: config[f"num_{unit}"] for unit in readers}
    banks = {f"{u}_l2": config[f"{u}_l2_banks"] if config[f"{u}_l2_bytes"] else 0 for u in readers}
    return {kind: (replicated | banks).get(kind, 1) for kind in kinds(description())}


def camel(name: str) -> str:
    return "".join(part.capitalize() for part in name.split("_"))


def package(config: dict[str, int]) -> str:
    """`ti_count_pkg`: structs of events, their numbers, the numbers of the units of a core."""
    table = description()
    lines = [
        HEAD,
        "/// What is counted, written by scripts/counters.py from rtl/count/counters.yaml.",
        "package ti_count_pkg;\n",
        struct("activity_t", [f"logic {name}" for name in table["activity"]]),
        struct("cache_events_t", [f"logic {name}" for name in table["cache"]]),
    ]
    for unit in table["units"]:
        own = own_events(table, unit)
        fields = ["activity_t activity", *(f"logic {name}" for name in own)]
        fields += ["cache_events_t cache"] if has_cache(table, unit) else []
        lines.append(struct(f"{unit}_events_t", fields))
    for unit in table["units"]:
        number = len(events(table, unit))
        lines.append(f"  localparam int unsigned Num{camel(unit)}Events = {number};")
    lines.append("\n  // Units of a core, kind by kind.")
    first = 0
    for kind, count in counts_of(config).items():
        lines.append(f"  localparam int unsigned Unit{camel(kind)} = {first};")
        first += count
    widest = max(len(events(table, unit)) for unit in table["units"])
    lines += [
        f"  localparam int unsigned NumUnits = {first};\n",
        f"  typedef logic [{(first - 1).bit_length() - 1}:0] unit_index_t;",
        f"  typedef logic [{(widest - 1).bit_length() - 1}:0] event_index_t;",
        "  typedef logic [47:0] count_t;\n",
        "endpackage : ti_count_pkg\n",
    ]
    return "\n".join(lines)


def struct(name: str, fields: list[str]) -> str:
    """A packed struct whose first field is the lowest."""
    body = "".join(f"    {field};\n" for field in reversed(fields))
    return f"  typedef struct packed {{\n{body}  }} {name};\n"


def header(config: dict[str, int]) -> str:
    """`ti_counters.hpp`: the same for C++."""
    table = description()
    rows, first = [], 0
    for kind, count in counts_of(config).items():
        names = ", ".join(f'"{name}"' for name in events(table, kinds(table)[kind]))
        rows.append(f'    {{"{kind}", {first}, {count}, {{{names}}}}},\n')
        first += count
    return (
        f"{HEAD}// What is counted, written by scripts/counters.py from rtl/count/counters.yaml.\n"
        "#pragma once\n\n#include <vector>\n\nnamespace ti::config {\n\n"
        "/// A kind of unit: its number in a core, and the names of its events by their numbers.\n"
        "struct CountedUnit {\n  const char* name;\n  int first;\n  int count;\n"
        "  std::vector<const char*> events;\n};\n\n"
        f"inline constexpr int kActivities = {len(table['activity'])};  ///< the first events\n\n"
        f"inline const std::vector<CountedUnit> kCountedUnits = {{\n{''.join(rows)}}};\n\n"
        "}  // namespace ti::config\n"
    )


def markdown() -> str:
    """The table of docs/counters.md."""
    table = description()
    lines = ["| unit | number | counter | counts cycles in which |", "|---|---:|---|---|"]
    lines += [
        f"| every | {i} | `{n}` | {t} |" for i, (n, t) in enumerate(table["activity"].items())
    ]
    for unit in table["units"]:
        for number, (name, text) in enumerate(events(table, unit).items()):
            if name not in table["activity"]:
                kinds_of = table["units"][unit].get("of")
                shown = ", ".join(f"`{of}_{unit}`" for of in kinds_of) if kinds_of else f"`{unit}`"
                lines.append(f"| {shown} | {number} | `{name}` | {text} |")
    return "\n".join(lines) + "\n"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    group = parser.add_mutually_exclusive_group(required=True)
    group.add_argument("--check", type=Path, metavar="FILE")
    group.add_argument("--write", type=Path, metavar="FILE")
    arguments = parser.parse_args()
    path = arguments.check or arguments.write
    text = path.read_text()
    head = text[: text.index("| unit |")]
    wanted = head + markdown()
    if arguments.write:
        path.write_text(wanted)
    elif text != wanted:
        print(f"{path}: its table is not that of {SOURCE.name}; run scripts/counters.py --write")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
