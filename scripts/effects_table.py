#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What is left out, and what that saves: EFFECTS=auto beside EFFECTS=all, scene by scene.

Both pictures are made of the same random numbers.  The table has rays by kind, cycles of the RTL,
seconds of the host, and whether `radiance.npy` is the same bit for bit.  Exit status: 0, 1 when a
picture is not, 2 for bad input.

Usage: scripts/effects_table.py --config FILE --library FILE --out FOLDER --scene NAME ...
                                [--size WxH] [--spp N] [--bounces N]
"""

import argparse
import shutil
import sys
from pathlib import Path

import bench
from pictures import PictureError, render, scene_file

KINDS = ("primary", "shadow", "diffuse", "glossy", "mirror", "glass")


def seconds(report: dict) -> float:
    time = report["time"]
    return sum(time[key] for key in ("engine", "lock_step", "truth", "shading"))


def row_of(name: str, some: dict, whole: dict, same: bool) -> str:
    """A line of the table."""
    kinds = [f"{some['rays_of'][k]:,} / {whole['rays_of'][k]:,}" for k in KINDS]
    cells = [name, *kinds, f"{some['rays']:,} / {whole['rays']:,}"]
    if some["cycles"] is not None:
        ratio = whole["cycles"] / some["cycles"]
        cells += [f"{some['cycles']:,} / {whole['cycles']:,}", f"{ratio:.2f}"]
    else:
        cells += ["", ""]
    cells += [f"{seconds(some):.1f} / {seconds(whole):.1f}", "yes" if same else "NO"]
    return f"| {' | '.join(cells)} |"


def run(words: list[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--config", type=Path, required=True, help="config.json of the machine")
    parser.add_argument("--library", type=Path, help="its libti_rtl.so; without it the model")
    parser.add_argument("--scene", nargs="+", required=True, help="names or files of scenes")
    parser.add_argument("--out", type=Path, required=True, help="folder of effects.md")
    parser.add_argument("--size", default="64x48", help="pixels")
    parser.add_argument("--spp", type=int, default=1, help="samples a pixel")
    parser.add_argument("--bounces", type=int, default=4)
    arguments = parser.parse_args(words)
    scenes = {name: scene_file(name) for name in arguments.scene}
    arguments.out.mkdir(parents=True, exist_ok=True)
    engine = "rtl" if arguments.library else "model"
    options = {"size": arguments.size, "spp": arguments.spp, "bounces": arguments.bounces}
    head = ["scene", *KINDS, "all rays", "cycles", "ratio", "seconds", "same bits"]
    lines = [
        f"`EFFECTS=auto` / `EFFECTS=all`, {arguments.size}, {arguments.spp} a pixel, "
        f"at most {arguments.bounces} scatterings, {engine}.",
        "",
        f"| {' | '.join(head)} |",
        "|---|" + "---:|" * (len(head) - 1),
    ]
    good = True
    for name, file in scenes.items():
        reports, pictures = [], []
        for effects in ("auto+dim-paths", "all"):
            folder = arguments.out / "run"
            report, radiance = render(
                file,
                folder,
                arguments.config,
                engine,
                arguments.library,
                effects=effects,
                **options,
            )
            shutil.rmtree(folder)
            reports.append(report)
            pictures.append(radiance.tobytes())
        same = pictures[0] == pictures[1]
        good = good and same
        lines.append(row_of(name, *reports, same))
        print(lines[-1], flush=True)
        bench.write_text(arguments.out / "effects.md", "\n".join(lines) + "\n")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(bench.status_of("effects-table", run, PictureError))
