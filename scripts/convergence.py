#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Noise against samples, and each effect on the machine's arithmetic beside Embree.

Convergence: the error of pictures of 1, 2, 4, ... samples a pixel, the root of the mean square over
pixels and channels in units of the reference's mean, against the mean of pictures of other seeds.
The exponent is that of a line through the points; independent samples give -0.5, and points of low
discrepancy may do better.  One that is above -0.4 is status 1.

Each effect: the picture with it alone by the model, which has the bits of the RTL, and by Embree,
with the same random numbers: pixels that are equal within 1e-4 of the mean, and the rest.  Those
have a ray on which both differ, and `report.json` has each such hit judged by exact arithmetic.

Usage: scripts/convergence.py --config FILE --out FOLDER --scene NAME ... [--size WxH] [--most N]
"""

import argparse
import shutil
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import bench
import matplotlib.pyplot as plt
import numpy as np
from pictures import PictureError, converged, render, scene_file

STEEPEST_BAD = -0.4
REFERENCE_SEED = 1000
EFFECTS = ("shadows", "soft-shadows", "interreflection", "glossy", "mirror", "glass", "lens", "ao")
EQUAL = 1e-4  # of the mean radiance


def errors(scene: Path, arguments: argparse.Namespace) -> tuple[list[int], list[float]]:
    """Samples a pixel and the error of each."""
    out = arguments.out / "run"
    words = {"size": arguments.size, "effects": "auto+dim-paths"}
    runs = 16
    reference, _ = converged(
        scene, out, arguments.config, runs, REFERENCE_SEED, spp=arguments.most, **words
    )
    counts, found = [], []
    spp = 1
    while spp <= arguments.most:
        _, radiance = render(scene, out, arguments.config, seed=1, spp=spp, **words)
        shutil.rmtree(out)
        counts.append(spp)
        found.append(float(np.sqrt(np.mean((radiance - reference) ** 2)) / reference.mean()))
        spp *= 2
    return counts, found


def exponent(counts: list[int], found: list[float]) -> float:
    return float(np.polyfit(np.log(counts), np.log(found), 1)[0])


def effect_rows(name: str, scene: Path, arguments: argparse.Namespace) -> list[str]:
    """A row for each effect that a scene has, alone."""
    rows = []
    out = arguments.out / "run"
    for effect in EFFECTS:
        reports, pictures = {}, {}
        for engine in ("model", "embree"):
            words = {"size": arguments.size, "spp": 4, "seed": 1, "effects": effect}
            reports[engine], radiance = render(scene, out, arguments.config, engine, **words)
            pictures[engine] = radiance.astype(np.float64)
            shutil.rmtree(out)
        rays = reports["model"]["rays_of"]
        more = sum(count for kind, count in rays.items() if kind != "primary")
        if more == 0 and effect != "lens":
            continue
        off = np.abs(pictures["model"] - pictures["embree"]).max(axis=2)
        mean = pictures["embree"].mean()
        differ = int((off > EQUAL * mean).sum())
        brightness = pictures["model"].mean() / mean - 1
        truth = reports["model"]["check"]["truth"]
        judged = truth["edge"] + truth["grazing"] + truth["tie"] + truth["embree_wrong"]
        rows.append(
            f"| {name} | {effect} | {more:,} | {off.size - differ} of {off.size} | "
            f"{brightness:+.1e} | {judged} | {truth['unexplained']} |"
        )
        print(rows[-1], flush=True)
    return rows


def plot(curves: dict[str, tuple[list[int], list[float]]], path: Path) -> None:
    figure, axis = plt.subplots(figsize=(7, 5))
    for name, (counts, found) in curves.items():
        axis.loglog(counts, found, "o-", label=f"{name}: {exponent(counts, found):.2f}")
    counts, found = next(iter(curves.values()))
    axis.loglog(counts, [found[0] * n**-0.5 for n in counts], "k--", label="1 / sqrt(n)")
    axis.set_xlabel("samples a pixel, n")
    axis.set_ylabel("error, of the mean radiance")
    axis.legend(title="scene: exponent")
    axis.grid(True, which="both", alpha=0.3)
    figure.tight_layout()
    figure.savefig(path, dpi=80)
    plt.close(figure)


def run(words: list[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--config", type=Path, required=True, help="config.json")
    parser.add_argument("--scene", nargs="+", required=True, help="names or files of scenes")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--size", default="48x36", help="pixels")
    parser.add_argument("--most", type=int, default=256, help="samples a pixel")
    arguments = parser.parse_args(words)
    scenes = {name: scene_file(name) for name in arguments.scene}
    arguments.out.mkdir(parents=True, exist_ok=True)
    curves, rows, good = {}, [], True
    for name, scene in scenes.items():
        curves[name] = errors(scene, arguments)
        slope = exponent(*curves[name])
        print(f"{name}: exponent {slope:.3f}", flush=True)
        good = good and slope < STEEPEST_BAD
        rows += effect_rows(name, scene, arguments)
    plot(curves, arguments.out / "convergence.png")
    lines = ["| scene | exponent | error by samples a pixel |", "|---|---:|---|"]
    for name, (counts, found) in curves.items():
        text = ", ".join(f"{n}: {e:.3g}" for n, e in zip(counts, found, strict=True))
        lines.append(f"| {name} | {exponent(counts, found):.2f} | {text} |")
    head = [
        "scene",
        "effect alone",
        "its rays",
        "equal pixels",
        "brightness",
        "judged",
        "unexplained",
    ]
    lines += ["", f"| {' | '.join(head)} |"]
    lines += ["|---|---|---:|---:|---:|---:|---:|", *rows]
    bench.write_text(arguments.out / "convergence.md", "\n".join(lines) + "\n")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(bench.status_of("convergence", run, PictureError))
