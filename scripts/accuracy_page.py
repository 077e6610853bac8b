# SPDX-License-Identifier: Apache-2.0
"""The page of a sweep of accuracy: `page` makes one HTML file of its points, which is whole."""

import json
from pathlib import Path

from jinja2 import Environment, FileSystemLoader

SCRIPTS = Path(__file__).resolve().parent
# What counts as wrong: heading, field, and which kinds of rays it is looked for in.
WRONGS = {
    "cracks": ("Cracks", "cracks_per_million"),
    "missed": ("Missed hits", "missed_per_million"),
    "false": ("False hits", "false_hits_per_million"),
    "wrong": ("Wrong triangles", "wrong_triangle_per_million"),
}


def name_of(point: dict) -> str:
    return f"{point['format']} {point['test']} {point['traversal']}"


def row_of(line: dict) -> dict:
    """A point as the page shows it: rates by kind of rays with their intervals, costs."""
    point = line["point"]
    rates = {
        wrong: {kind["rays"]: kind[field] for kind in line["kinds"]}
        for wrong, (_, field) in WRONGS.items()
    }
    return {
        "scene": Path(point["scene"]).name.split(".")[0],
        "machine": name_of(point),
        "format": point["format"],
        "test": point["test"],
        "traversal": point["traversal"],
        "rates": rates,
        "self": {kind["rays"]: kind["self_hits_per_million"] for kind in line["kinds"]},
        "t_ulp": {kind["rays"]: kind["t_ulp"] for kind in line["kinds"]},
        "steps": {kind["rays"]: kind["steps_per_ray"] for kind in line["kinds"]},
        "tests": {kind["rays"]: kind["tests_per_ray"] for kind in line["kinds"]},
        "lut": line["operator_lut"],
        "dsp": line["operator_dsp"],
        "ff": line["operator_ff"],
        "latency": line["latency"],
        "bytes": line["bytes"]["triangle"],
        "rtl": line.get("rtl"),
        "seconds": line["seconds"],
        "command": line["command"],
    }


def sentences(rows: list[dict]) -> list[str]:
    """What a reader can quote: figures of the points that are there."""
    found = []
    by_machine = {(r["scene"], r["format"], r["test"], r["traversal"]): r for r in rows}
    for (scene, fmt, test, walk), row in by_machine.items():
        tight = by_machine.get((scene, fmt, "woop", "padded"))
        if (test, walk) != ("local", "plain") or tight is None or "edges" not in row["steps"]:
            continue
        local, none = (r["rates"]["cracks"]["edges"] for r in (row, tight))
        text = (
            f"{scene}, {fmt}: of a million rays aimed at edges {local['rate']:,.0f} slip through "
            f"with the test local and {none['rate']:,.0f} (95 %: at most {none['high']:,.0f}) with "
            f"woop and padded, for {tight['lut'] / row['lut']:.2f} times the LUTs of the operators"
        )
        if row["rtl"] and tight["rtl"]:
            speed = tight["rtl"]["mrays_per_s"] / row["rtl"]["mrays_per_s"]
            text += f" and {speed:.2f} times the primary rays a second"
        found.append(text + ".")
    return found


def page(lines: list[dict]) -> str:
    """The whole page."""
    rows = [row_of(line) for line in lines]
    kinds = list(dict.fromkeys(kind for row in rows for kind in row["steps"]))
    template = Environment(
        loader=FileSystemLoader(SCRIPTS), autoescape=True, trim_blocks=True, lstrip_blocks=True
    ).get_template("accuracy.html.j2")
    return template.render(
        rows=rows,
        kinds=kinds,
        scenes=list(dict.fromkeys(row["scene"] for row in rows)),
        wrongs={name: heading for name, (heading, _) in WRONGS.items()},
        sentences=sentences(rows),
        count=max(kind["count"] for line in lines for kind in line["kinds"]),
        data=json.dumps(rows).replace("</", "<\\/"),
    )
