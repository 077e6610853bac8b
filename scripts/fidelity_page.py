# SPDX-License-Identifier: Apache-2.0
"""Points of `make fidelity` as rows, sentences, and a page with one plot that needs no other file.

`cells_of` makes of measurements what the others take.  Errors are percent of the full run's
Mrays/s, positive where a point is too fast; seconds are medians over the runs of a point.
"""

import math
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from statistics import mean, median
from typing import NamedTuple

from jinja2 import Environment, FileSystemLoader, StrictUndefined

SCRIPTS = Path(__file__).resolve().parent
MODEL = "model"
COLOURS = {MODEL: "#c8641f", "ideal": "#1f8a63", "fixed": "#a63a94", "dram": "#2f6fd0"}
MEMORIES = {"ideal": "ideal memory", "fixed": "fixed memory", "dram": "DRAM"}
LEAST_ERROR = 0.1  # percent; the plot has all that is less on its lowest line
CLOSE = 5.0  # percent; what the sentences call near enough

# The plot, in units of its view: a panel's place for points, and the margins around it.
WIDE, HIGH, LEFT, TOP, RIGHT, BOTTOM = 470, 300, 66, 40, 22, 46


class About(NamedTuple):
    """What the heading of the page says."""

    machine: str
    frame: tuple[int, int]
    samples: int  # secondary rays from a hit
    engines: tuple[str, ...]
    latency: int  # of the fixed memory, cycles
    bytes_per_cycle: float
    command: str


@dataclass(frozen=True)
class Point:
    """An engine on a sample, all runs together."""

    engine: str
    share: Fraction
    runs: int
    rays: float
    cycles: float | None  # none of the model
    mrays_per_s: float
    errors: tuple[float, ...]  # percent, of each run
    seconds: float  # of the processor
    wall: float
    busiest: str

    @property
    def size(self) -> str:
        return str(self.share) if self.share < 1 else "whole"

    @property
    def error(self) -> float:
        return mean(self.errors)

    @property
    def distances(self) -> list[float]:
        """Of the runs, least first."""
        return sorted(abs(error) for error in self.errors)

    @property
    def worst(self) -> float:
        return self.distances[-1]


@dataclass(frozen=True)
class Cell:
    """A scene with a kind of rays."""

    scene: str
    rays: str
    full: Point
    points: tuple[Point, ...]  # by engine, each with the smallest sample first

    @property
    def name(self) -> str:
        return f"{self.scene}, {self.rays}"

    @property
    def sentences(self) -> list[str]:
        return sentences_of(self)


def cells_of(lines: list[dict], full: str) -> list[Cell]:
    """Cells whose full run, the whole frame with the memory `full`, is there."""
    of_cell: dict[tuple, dict[tuple, list[dict]]] = {}
    for line in lines:
        point = line["point"]
        cell = of_cell.setdefault((point["scene"], point["rays"]), {})
        cell.setdefault((point["engine"], Fraction(point["share"])), []).append(line)
    cells = []
    for (scene, rays), groups in of_cell.items():
        if (full, Fraction(1)) not in groups:
            continue
        truth = groups[full, Fraction(1)][0]["mrays_per_s"]
        order = list(dict.fromkeys(engine for engine, _ in groups))
        keys = sorted(groups, key=lambda key: (order.index(key[0]), key[1]))
        points = {key: point_of(*key, groups[key], truth) for key in keys}
        name = Path(scene).name.split(".")[0]
        cells.append(Cell(name, rays, points[full, Fraction(1)], tuple(points.values())))
    return cells


def point_of(engine: str, share: Fraction, lines: list[dict], truth: float) -> Point:
    """A point of its runs."""
    speeds = [line["mrays_per_s"] for line in lines]
    return Point(
        engine,
        share,
        len(lines),
        mean(line["count"] for line in lines),
        None if engine == MODEL else mean(line["cycles"] for line in lines),
        mean(speeds),
        tuple(100 * (speed - truth) / truth for speed in speeds),
        median(line["seconds"]["cpu"] for line in lines),
        median(line["seconds"]["wall"] for line in lines),
        lines[0]["busiest"],
    )


def percent(value: float) -> str:
    """Without a sign."""
    return signed(abs(value)).removeprefix("+")


def signed(value: float) -> str:
    return f"{value:+.2g} %" if abs(value) < 1 else f"{value:+.1f} %"


def time_of(seconds: float) -> str:
    if seconds < 0.1:
        return f"{seconds:.2g} s"
    return f"{seconds:.{2 if seconds < 10 else 1}f} s"


def name_of(point: Point) -> str:
    """What a point is, in words."""
    if point.engine == MODEL:
        of = "" if point.share == 1 else f" of a sample of {point.share}"
        return f"the functional model's ceiling{of}"
    part = "the whole frame" if point.share == 1 else f"a sample of {point.share} of the frame"
    return f"{part} with {MEMORIES[point.engine]}"


def sentences_of(cell: Cell) -> list[str]:
    """What a reader can quote of a cell."""
    full = cell.full

    def times(point: Point) -> str:
        return f"{time_of(point.seconds)} of {time_of(full.seconds)}"

    samples = [p for p in cell.points if p.engine == full.engine and p.share < 1]
    middle = [p for p in samples if p.share == Fraction(1, 16)] or samples[-1:]
    found = [
        f"{cell.name}: {name_of(p)} is within {percent(p.worst)} of the full run in {times(p)}."
        for p in middle
    ]
    near = [p for p in cell.points if p.worst <= CLOSE and p is not full]
    if near:
        best = min(near, key=lambda p: p.seconds)
        found.append(
            f"{cell.name}: the soonest within {CLOSE:.0f} % is {name_of(best)}, "
            f"{times(best)}, {percent(best.worst)} off at most."
        )
    else:
        found.append(f"{cell.name}: nothing but the full run is within {CLOSE:.0f} %.")
    for p in cell.points:
        if p.share == 1 and p is not full:
            side = "above" if p.error > 0 else "below"
            found.append(
                f"{cell.name}: {name_of(p)} is {percent(p.error)} {side} it in {times(p)}."
            )
    return found


def csv_rows(cells: list[Cell]) -> list[dict]:
    """A row for each point."""
    return [
        {
            "scene": cell.scene, "rays": cell.rays, "engine": p.engine, "sample": str(p.share),
            "runs": p.runs, "count": f"{p.rays:.0f}",
            "cycles": "" if p.cycles is None else f"{p.cycles:.0f}",
            "mrays_per_s": f"{p.mrays_per_s:.6g}", "error_percent": f"{p.error:.4g}",
            "least_error_percent": f"{p.distances[0]:.4g}",
            "worst_error_percent": f"{p.worst:.4g}",
            "cpu_seconds": f"{p.seconds:.4g}", "wall_seconds": f"{p.wall:.4g}",
            "seconds_of_full": f"{p.seconds / cell.full.seconds:.4g}", "busiest": p.busiest,
        }
        for cell in cells for p in cell.points
    ]  # fmt: skip


def table(cells: list[Cell]) -> tuple[list[str], list[str], list[list[str]]]:
    """The table for documents: titles of words, of figures, rows."""
    words = ["scene", "rays", "engine", "sample"]
    figures = ["rays traced", "cycles", "Mrays/s", "error", "worst", "seconds", "of the full run"]
    rows = [
        [
            cell.scene, cell.rays, p.engine, p.size, f"{p.rays:,.0f}",
            "" if p.cycles is None else f"{p.cycles:,.0f}", f"{p.mrays_per_s:.1f}",
            "full run" if p is cell.full else signed(p.error),
            "" if p is cell.full else percent(p.worst),
            time_of(p.seconds), f"{100 * p.seconds / cell.full.seconds:.1f} %",
        ]
        for cell in cells for p in cell.points
    ]  # fmt: skip
    return words, figures, rows


def ticks(low: float, high: float) -> list[float]:
    """Round values of a logarithmic axis: decades, with 2 and 5 where there are few."""
    few = math.log10(high / low) < 2.5
    steps = (1, 2, 5) if few else (1,)
    powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    values = [step * 10.0**power for power in powers for step in steps]
    return [value for value in values if low <= value * 1.000001 and value <= high * 1.000001]


class Axes:
    """Where seconds and errors are in a panel; all panels have the same axes."""

    def __init__(self, cells: list[Cell]):
        points = [p for cell in cells for p in cell.points]
        seconds = [max(p.seconds, 1e-4) for p in points]
        self.left, self.right = min(seconds) / 1.6, max(seconds) * 1.6
        self.top = max(10.0, *(p.worst for p in points)) * 1.7

    def x(self, seconds: float) -> float:
        span = math.log10(self.right / self.left)
        return WIDE * math.log10(max(seconds, 1e-4) / self.left) / span

    def y(self, error: float) -> float:
        """Of a distance in percent; a tenth of the height is for what is below the least."""
        if error < LEAST_ERROR:
            return HIGH
        span = math.log10(self.top / LEAST_ERROR)
        return 0.92 * HIGH * (1 - math.log10(error / LEAST_ERROR) / span)

    @property
    def across(self) -> list[tuple[float, str]]:
        return [(self.x(v), f"{v:g}") for v in ticks(self.left, self.right)]

    @property
    def up(self) -> list[tuple[float, str]]:
        values = [v for v in (0.1, 1.0, 10.0, 100.0, 1000.0, 10000.0) if v <= self.top]
        return [(HIGH, f"< {LEAST_ERROR:g}"), *((self.y(v), f"{v:g}") for v in values)]


def mark_of(cell: Cell, point: Point, axes: Axes) -> dict:
    """A point as the plot shows it."""
    distances = point.distances
    middle = median(distances)
    words = (
        f"{point.engine}, {point.size}: {point.mrays_per_s:.1f} Mrays/s, {signed(point.error)}, "
        f"at most {percent(point.worst)}, {time_of(point.seconds)}"
    )
    return {
        "x": axes.x(point.seconds),
        "y": axes.y(middle),
        "low": axes.y(distances[0]),
        "high": axes.y(distances[-1]),
        "radius": radius_of(point.share),
        "filled": point.error > 0,
        "title": words,
        "full": point is cell.full,
        "label": label_of(cell, point),
        "label_y": axes.y(middle) - radius_of(point.share) - 5,
    }


def label_of(cell: Cell, point: Point) -> str:
    """Samples of the full run's engine have their size, the others are named once."""
    if point is cell.full:
        return "full run"
    if point.engine == cell.full.engine:
        return point.size
    return point.engine if point.share == 1 else ""


def radius_of(share: Fraction) -> float:
    """Grows with the logarithm of the sample."""
    return max(3.0, 9.0 + math.log2(float(share)))


def panels_of(cells: list[Cell], axes: Axes) -> list[dict]:
    """Panels of the plot, two in a row."""
    panels = []
    for number, cell in enumerate(cells):
        series, lifted = [], 0
        for engine in dict.fromkeys(p.engine for p in cell.points):
            marks = [mark_of(cell, p, axes) for p in cell.points if p.engine == engine]
            for mark in marks:
                # Labels of the lowest line stand above one another, the full run's lowest.
                if mark["label"] and mark["y"] == HIGH and not mark["full"]:
                    lifted += 1
                    mark["label_y"] -= 15 * lifted
            path = " ".join(f"{m['x']:.1f},{m['y']:.1f}" for m in marks)
            series.append(
                {"engine": engine, "colour": COLOURS[engine], "marks": marks, "path": path}
            )
        panels.append(
            {
                "name": cell.name,
                "speed": f"full run: {cell.full.mrays_per_s:.1f} Mrays/s, "
                f"{time_of(cell.full.seconds)}",
                "x": LEFT + (number % 2) * (LEFT + WIDE + RIGHT),
                "y": TOP + (number // 2) * (TOP + HIGH + BOTTOM),
                "series": series,
            }
        )
    return panels


def page(cells: list[Cell], about: About) -> str:
    """The whole page."""
    axes = Axes(cells)
    shares = sorted({p.share for cell in cells for p in cell.points})
    words, figures, rows = table(cells)
    environment = Environment(
        loader=FileSystemLoader(SCRIPTS),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=StrictUndefined,
    )
    return environment.get_template("fidelity.html.j2").render(
        about=about,
        full=MEMORIES[cells[0].full.engine],
        runs=max(p.runs for cell in cells for p in cell.points),
        axes=axes,
        panels=panels_of(cells, axes),
        columns=min(2, len(cells)),
        lines=math.ceil(len(cells) / 2),
        wide=WIDE,
        high=HIGH,
        left=LEFT,
        top=TOP,
        right=RIGHT,
        bottom=BOTTOM,
        colours={engine: COLOURS[engine] for engine in about.engines},
        sizes=[("whole" if s == 1 else str(s), radius_of(s)) for s in shares],
        sentences=[sentence for cell in cells for sentence in cell.sentences],
        words=words,
        figures=figures,
        rows=rows,
    )
