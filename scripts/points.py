# SPDX-License-Identifier: Apache-2.0
"""The points of a sweep that can be stopped: a file of JSON lines, a CSV, a table in Markdown.

A line has under `point` what makes it that point and no other; the rest is what was measured.
"""

import csv
import json
from pathlib import Path


class PointsError(ValueError):
    """One sentence for the user."""


def key_of(point: dict) -> str:
    """The same for two points exactly when they are the same."""
    return json.dumps(point)


def load(file: Path) -> dict[str, dict]:
    """The lines that are there, by point; one at the end that was cut short leaves the file."""
    if not file.exists():
        return {}
    whole, _, cut = file.read_text().rpartition("\n")
    try:
        lines = {key_of(line["point"]): line for line in map(json.loads, whole.splitlines())}
    except (ValueError, KeyError, TypeError):
        raise PointsError(f"{file}: has other lines than points; give another OUT=") from None
    if cut:
        store(file, lines)
    return lines


def store(file: Path, lines: dict[str, dict]) -> None:
    """Writes all lines anew."""
    file.write_text("".join(json.dumps(line) + "\n" for line in lines.values()))


def add(file: Path, lines: dict[str, dict], line: dict) -> None:
    """Writes a line behind the others."""
    with file.open("a") as out:
        out.write(json.dumps(line) + "\n")
    lines[key_of(line["point"])] = line


def write_csv(path: Path, rows: list[dict]) -> None:
    """A row for each; all have the columns of the first."""
    with path.open("w", newline="") as out:
        table = csv.DictWriter(out, rows[0], lineterminator="\n")
        table.writeheader()
        table.writerows(rows)


def write_table(path: Path, words: list[str], figures: list[str], rows: list[list[str]]) -> None:
    """A table in Markdown: columns of words, then of figures, which stand to the right."""
    rule = ["---"] * len(words) + ["---:"] * len(figures)
    lines = [[*words, *figures], rule, *rows]
    path.write_text("".join(f"| {' | '.join(line)} |\n" for line in lines))
