# SPDX-License-Identifier: Apache-2.0
"""The page of a sweep of accuracy: `page` makes one HTML file of its points, which is whole."""

import base64
import json
from pathlib import Path

from accuracy_tables import scene_name
from jinja2 import Environment, FileSystemLoader

SCRIPTS = Path(__file__).resolve().parent
# What counts as wrong: heading, field, and which kinds of rays it is looked for in.
WRONGS = {
    "cracks": ("Cracks", "cracks_per_million"),
    "missed": ("Missed hits", "missed_per_million"),
    "false": ("False hits", "false_hits_per_million"),
    "wrong": ("Wrong triangles", "wrong_triangle_per_million"),
}
# Costs of the plot: heading, and whether less is better.
COSTS = {
    "lut": ("LUTs of the operators of the core", True),
    "dsp": ("DSPs of the operators of the core", True),
    "ff": ("flip-flops of the operators of the core", True),
    "cycles": ("cycles a primary ray", True),
    "mrays": ("millions of primary rays a second", False),
}
# The formats that sentences are about, and what they are called.
QUOTED = {"(7,16)": "24 bits (7,16)", "(8,23)": "binary32 (8,23)", "(5,10)": "16 bits (5,10)"}


def name_of(point: dict) -> str:
    return f"{point['format']} {point['test']} {point['traversal']}"


def places_of(kind: dict) -> list[int]:
    """The cracks of a kind of rays as whole tenths of pixels and 0 or 1: x, y, seen, x, ..."""
    return [
        round(v * f)
        for place in kind.get("crack_places", ())
        for v, f in zip(place, (10, 10, 1), strict=True)
    ]


class Embedded:
    """The pictures of a page, each once, by number."""

    def __init__(self):
        self.uris: list[str] = []

    def add(self, path: Path) -> int | None:
        """The number of a PNG file; None when it is gone."""
        if not path.is_file():
            return None
        uri = "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode()
        if uri not in self.uris:
            self.uris.append(uri)
        return self.uris.index(uri)


def row_of(line: dict, out: Path, embedded: Embedded) -> dict:
    """A point as the page shows it: rates by kind of rays with their intervals, costs, pictures."""
    point = line["point"]
    rtl = line.get("rtl")
    row = {
        "scene": scene_name(point["scene"]),
        "machine": name_of(point),
        "format": point["format"],
        "test": point["test"],
        "traversal": point["traversal"],
        "lut": line["operator_lut"],
        "dsp": line["operator_dsp"],
        "ff": line["operator_ff"],
        "cycles": rtl["cycles_per_ray"] if rtl else None,
        "mrays": rtl["mrays_per_s"] if rtl else None,
        "latency": line["latency"],
        "bytes": line["bytes"],
        "command": line["command"],
    }
    if "refused" in line:
        return row | {"refused": line["refused"]}
    kinds = {kind["rays"]: kind for kind in line["kinds"]}
    row |= {
        "rates": {w: {k: v[f] for k, v in kinds.items()} for w, (_, f) in WRONGS.items()},
        "count": {k: v["count"] for k, v in kinds.items()},
        "errors": {e: {k: v[f"{e}_ulp"] for k, v in kinds.items()} for e in ("t", "u", "v")},
        "steps": {k: v["steps_per_ray"] for k, v in kinds.items()},
        "tests": {k: v["tests_per_ray"] for k, v in kinds.items()},
        "places": {k: places_of(v) for k, v in kinds.items()},
        "seconds": line["model_seconds"],
        "triangles": line["triangles"],
        "dropped": line["dropped"],
    }
    picture = line["picture"]
    if not picture:
        return row
    return row | {
        "pixels": picture["width"] * picture["height"],
        "size": [picture["width"], picture["height"]],
        "wrong_pixels": picture["wrong_pixels"],
        "psnr": picture["psnr_db"],
        "flip": picture["flip"],
        "picture": embedded.add(out / picture["file"]),
        "differences": embedded.add(out / picture["flip_file"]),
        "reference": embedded.add(out / picture["reference_file"]),
    }


def sentence_of(name: str, local: dict, tight: dict) -> str:
    """What a reader can quote of a format: `local plain` and `woop padded` side by side."""
    leaks, none = (row["rates"]["cracks"]["edges"] for row in (local, tight))
    text = (
        f"{name}: of a million rays aimed at edges {leaks['rate']:,.0f} leak with local plain and "
        f"{none['rate']:,.0f} (95 %: at most {none['high']:,.0f}) with woop padded"
    )
    if "flip" in local and "flip" in tight:
        text += (
            f"; of {local['pixels']:,} pixels {local['wrong_pixels']:,} and "
            f"{tight['wrong_pixels']:,} are wrong, FLIP {local['flip']:.4f} and {tight['flip']:.4f}"
        )
    if local["mrays"] and tight["mrays"]:
        text += f"; {local['mrays']:.1f} and {tight['mrays']:.1f} Mrays/s of primary rays"
    return (
        f"{text}; {local['lut']:,} and {tight['lut']:,} LUTs, {local['dsp']:,} and "
        f"{tight['dsp']:,} DSPs of operators ({tight['lut'] / local['lut']:.2f} times the LUTs)."
    )


def sentences(rows: list[dict]) -> list[tuple[str, str]]:
    """Scenes with what is to be said of them: figures of the points that are there."""
    found = []
    by_machine = {(r["scene"], r["machine"]): r for r in rows if "rates" in r}
    for scene in dict.fromkeys(row["scene"] for row in rows):
        for fmt, name in QUOTED.items():
            pair = [by_machine.get((scene, f"{fmt} {m}")) for m in ("local plain", "woop padded")]
            if all(row and "edges" in row["steps"] for row in pair):
                found.append((scene, sentence_of(name, *pair)))
    return found


def page(lines: list[dict], out: Path) -> str:
    """The whole page of points whose pictures are below the folder `out`."""
    embedded = Embedded()
    rows = [row_of(line, out, embedded) for line in lines]
    kinds = list(dict.fromkeys(kind for row in rows for kind in row.get("steps", ())))
    costs = {k: v for k, v in COSTS.items() if any(row[k] is not None for row in rows)}
    template = Environment(
        loader=FileSystemLoader(SCRIPTS), autoescape=True, trim_blocks=True, lstrip_blocks=True
    ).get_template("accuracy.html.j2")
    return template.render(
        rows=rows,
        kinds=kinds,
        scenes=list(dict.fromkeys(row["scene"] for row in rows)),
        wrongs={name: heading for name, (heading, _) in WRONGS.items()},
        costs=costs,
        sentences=sentences(rows),
        count=max((n for row in rows for n in row.get("count", {}).values()), default=0),
        data=script_of(rows),
        pictures=script_of(embedded.uris),
        cost_data=script_of(costs),
    )


def script_of(value) -> str:
    """JSON that may stand in a script."""
    return json.dumps(value, separators=(",", ":")).replace("</", "<\\/")
