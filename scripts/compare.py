#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Bench several variants of a machine on the same rays: tables side by side, and a CSV.

A variant is KEY=VALUE overrides of the configuration; none is the machine as it is, which goes
first.  Each is built where its RTL is new, and measured by `scripts/bench.py` into a folder of its
own below OUT, so a comparison that was stopped goes on where it stood.  Options that are not known
here (scenes, rays, count, memory) are those of the bench; of all kinds of rays a sample is traced.

OUT gets `compare.csv`, a row for each variant and cell, and `compare.md`, a table for each measure:
variants down, cells across, and the geometric mean of Mrays/s; and in how many cells the hits of a
variant are those of the machine as it is, bit for bit.

Exit status: 0, 1 when a check of some cell failed, 2 for bad input.

Usage: scripts/compare.py --config NAME [--set "KEY=VALUE ..."] [--cores N]
                          --variants "KEY=VALUE ...; ..." --out FOLDER BENCH_OPTIONS
"""

import argparse
import csv
import json
import os
import subprocess
import sys
from pathlib import Path
from statistics import geometric_mean

import bench
import configure
from config_schema import ConfigError

ROOT = Path(__file__).resolve().parents[1]
BUILD = "build"
# Of all kinds of rays, unless the words say otherwise: a variant takes minutes.
SAMPLE = ["--sample-primary", "--count", "60000"]

# Columns of compare.csv behind variant, scene and ray_type: what each is of a cell.
MEASURES = {
    "rays": lambda cell: cell["rays"],
    "cycles": lambda cell: cell["cycles"],
    "mrays_per_s": lambda cell: cell["mrays_per_s"],
    "bytes_per_ray": lambda cell: cell["per_ray"]["dram_bytes"],
    "steps_per_ray": lambda cell: cell["per_ray"]["steps"],
    "tests_per_ray": lambda cell: cell["per_ray"]["tests"],
    "restarts_per_ray": lambda cell: cell["per_ray"]["restarts"],
    **{
        f"{unit}_busy": lambda cell, unit=unit: cell["utilization"][unit]
        for unit in ("trv", "list", "ist1", "ist2")
    },
    **{
        f"{unit}_misses_per_ray": lambda cell, unit=unit: (
            (cell["cache"][unit]["misses"] + cell["cache"][unit]["merged"]) / cell["rays"]
        )
        for unit in ("trv_l1", "list_l1", "ist1_l1")
    },
}
# The tables of compare.md: a measure, its heading, the form of a figure.
TABLES = {
    "mrays_per_s": ("Mrays/s", "{:.1f}"),
    "bytes_per_ray": ("Bytes from memory a ray", "{:.0f}"),
    "steps_per_ray": ("Traversal steps a ray", "{:.1f}"),
    "tests_per_ray": ("Tests a ray", "{:.1f}"),
    "trv_busy": ("Share of the cycles in which a TRV works", "{:.0%}"),
    "trv_l1_misses_per_ray": ("Nodes' lines that an L1 missed, a ray", "{:.2f}"),
}


class CompareError(Exception):
    """One sentence for the user."""


def variants_of(text: str) -> list[str]:
    """The machine as it is, then the variants of a list with semicolons; each once."""
    variants = [" ".join(variant.split()) for variant in text.split(";")]
    return list(dict.fromkeys(["", *variants]))


def folder_of(variant: str) -> str:
    """Name of a variant's folder."""
    return configure.folder_name(variant) or "as-it-is"


def machine_of(
    arguments: argparse.Namespace, variant: str
) -> tuple[configure.Configuration, list[str]]:
    """A variant's configuration, checked, and its overrides; those of the variant go last."""
    cores = [f"cores={arguments.cores}"] if arguments.cores else []
    overrides = [*arguments.set.split(), *cores, *variant.split()]
    return configure.load(arguments.config, overrides), overrides


def bench_words(options: list[str]) -> argparse.Namespace:
    """The options of the bench, checked."""
    return bench.parse_arguments([*options, "--config", "-", "--library", "-", "--out", "-"])


def build_engine(arguments: argparse.Namespace, variant: str, dram: bool) -> tuple[Path, Path]:
    """A variant's `config.json` and the library of its RTL, which is built where it is new."""
    machine, overrides = machine_of(arguments, variant)
    make = ["make", "-s", "engine", f"CONFIG={arguments.config}", f"SET={' '.join(overrides)}"]
    # What is not in the overrides would come from a `make` above, which hands its own down.
    make += ["CORES=", "MEM=dram" if dram else "MEM="]
    without = {k: v for k, v in os.environ.items() if k not in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL")}
    if subprocess.run(make, cwd=ROOT, env=without).returncode != 0:
        raise CompareError(f"{variant or arguments.config}: the engine does not build")
    folder = ROOT / BUILD
    return folder / machine.folder / "config.json", folder / machine.engine / "libti_rtl.so"


def measure(arguments: argparse.Namespace, options: list[str], variant: str) -> tuple[list, bool]:
    """The cells of a variant, and whether all of their hits are right."""
    dram = bench_words(options).mem == "dram"
    config, library = build_engine(arguments, variant, dram)
    out = arguments.out / folder_of(variant)
    words = [sys.executable, ROOT / "scripts/bench.py", *options, "--out", out]
    words += ["--config", config, "--library", library]
    status = subprocess.run([str(word) for word in words]).returncode
    if status not in (0, 1):
        sys.exit(status)
    return json.loads((out / "bench.json").read_text())["cells"], status == 0


def table(measured: dict[str, list], name: str) -> list[str]:
    """The lines of a table in Markdown."""
    heading, form = TABLES[name]
    value = MEASURES[name]
    cells = next(iter(measured.values()))
    mean = len(cells) > 1 and name == "mrays_per_s"
    titles = [f"{cell['scene']} {cell['ray_type']}" for cell in cells] + ["mean"] * mean
    lines = [f"## {heading}", "", f"| variant | {' | '.join(titles)} |"]
    lines.append("|---|" + "---:|" * len(titles))
    for variant, cells in measured.items():
        figures = [value(cell) for cell in cells]
        figures += [geometric_mean(figures)] * mean
        row = " | ".join(form.format(figure) for figure in figures)
        lines.append(f"| {f'`{variant}`' if variant else 'as it is'} | {row} |")
    return [*lines, ""]


def same_hits(measured: dict[str, list], variant: str) -> list[bool]:
    """Of each cell whether the variant's hits are the machine's as it is, bit for bit."""
    pairs = zip(measured[variant], measured[""], strict=True)
    return [cell["hits_sha256"] == machine["hits_sha256"] for cell, machine in pairs]


def hits_table(measured: dict[str, list]) -> list[str]:
    """The lines of the table of hits in Markdown."""
    lines = ["## Cells with the hits of the machine as it is, bit for bit", ""]
    lines += ["| variant | cells |", "|---|---:|"]
    for variant in list(measured)[1:]:
        same = same_hits(measured, variant)
        lines.append(f"| `{variant}` | {sum(same)} of {len(same)} |")
    return [*lines, ""]


def write(out: Path, measured: dict[str, list]) -> None:
    """Both files, each whole or not at all."""
    partial = out / f"compare.{os.getpid()}.part"
    try:
        with partial.open("w", newline="") as file:
            rows = csv.writer(file, lineterminator="\n")
            rows.writerow(["variant", "scene", "ray_type", *MEASURES, "same_hits"])
            for variant, cells in measured.items():
                for cell, same in zip(cells, same_hits(measured, variant), strict=True):
                    figures = [f"{value(cell):.6g}" for value in MEASURES.values()]
                    rows.writerow([variant, cell["scene"], cell["ray_type"], *figures, int(same)])
        partial.replace(out / "compare.csv")
        lines = [line for name in TABLES for line in table(measured, name)]
        partial.write_text("\n".join(lines + hits_table(measured)))
        partial.replace(out / "compare.md")
    finally:
        partial.unlink(missing_ok=True)


def run(words: list[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--config", required=True, help="name or file of a configuration")
    parser.add_argument("--set", default="", help="overrides that all variants have")
    parser.add_argument("--cores", default="", help="cores of all variants")
    parser.add_argument("--variants", required=True, help="overrides, variants apart by semicolons")
    parser.add_argument("--out", type=Path, required=True, help="folder of the tables")
    arguments, given = parser.parse_known_args(words)
    options = [*SAMPLE, *given]
    variants = variants_of(arguments.variants)
    # All that may be wrong in the words is said before anything is built.
    for variant in variants:
        machine_of(arguments, variant)
    bench_words(options)
    measured, good = {}, True
    for variant in variants:
        print(f"\n{variant or 'as it is'}", flush=True)
        measured[variant], right = measure(arguments, options, variant)
        good = good and right
        write(arguments.out, measured)
    print(f"\n{(arguments.out / 'compare.md').read_text()}")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(bench.status_of("compare", run, CompareError, ConfigError))
