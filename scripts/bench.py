#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Speed of a machine on scenes and kinds of rays: a table, and `bench.json`.

A cell is a scene with a kind of rays.  `primary` are the camera rays of a frame; `ao` and `diffuse`
are cosine-distributed rays from the hits of a frame, 32 a hit, any-hit of a twentieth of the
scene's diagonal, and closest-hit without an end (after Aila and Laine, Understanding the Efficiency
of Ray Traversal on GPUs, HPG 2009; length and number are ours).  A sample of at least N rays is
whole tiles of 8x8 pixels, evenly spread over the frame in Morton order, behind an unmeasured
twentieth of it that warms the caches.  All of it runs in this process, on one engine a scene and
kind.

`ci95` is the 95 % interval of Mrays/s over all such samples: the answers are cut into batches of
tiles that follow one another, whose rates give a mean and a spread (method of batch means with
Student's t).  A whole frame is no sample: its interval is null.

Each cell is written as soon as it is there.  A bench that was stopped goes on where it stood when
it is started again with the same words; otherwise it begins anew.

Exit status: 0, 1 when a check of some cell failed, 2 for bad input.

Usage: scripts/bench.py --config FILE --library FILE --out FOLDER --scene FILE ... [--rays KIND ...]
"""

import argparse
import hashlib
import json
import math
import os
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "build/sw/python"))

SCHEMA = "ti-bench-1"
KINDS = ("primary", "ao", "diffuse")
MEMORIES = ("ideal", "fixed", "dram")
TILE = 64  # rays of a tile of primary rays: 8x8 pixels, as rays come in Morton order
SAMPLES = 32  # secondary rays from a hit
AO_RADIUS = 0.05  # of the scene's diagonal
BATCHES = 32
T_OF_BATCHES = 2.0395  # Student's t at 97.5 % with BATCHES - 1 degrees of freedom
SEED = 1


class BenchError(Exception):
    """One sentence for the user."""


class Parser(argparse.ArgumentParser):
    """Says one sentence of what is wrong."""

    def error(self, message: str) -> None:
        raise BenchError(f"{Path(self.prog).stem}: {message}")


def parse_arguments(words: list[str]) -> argparse.Namespace:
    parser = Parser(description=__doc__.splitlines()[0])
    parser.add_argument("--config", type=Path, required=True, help="config.json of the machine")
    parser.add_argument("--library", type=Path, required=True, help="its libti_rtl.so")
    parser.add_argument("--scene", type=Path, nargs="+", required=True, help="scenes")
    parser.add_argument("--rays", nargs="+", default=list(KINDS), help=", ".join(KINDS))
    parser.add_argument("--count", type=int, default=500_000, help="rays of a sample, at least")
    parser.add_argument("--frame", default="1024x768", help="WIDTHxHEIGHT")
    parser.add_argument("--samples", type=int, default=SAMPLES, help="secondary rays from a hit")
    parser.add_argument("--sample-primary", action="store_true", help="sample primary rays too")
    parser.add_argument("--mem", default="fixed", help=", ".join(MEMORIES))
    parser.add_argument("--mem-latency", type=int, default=100, help="of a fixed one: cycles")
    parser.add_argument("--mem-bytes-per-cycle", type=float, default=64.0, help="bytes a cycle")
    parser.add_argument("--out", type=Path, required=True, help="folder of bench.json")
    arguments = parser.parse_args(words)
    for kind in arguments.rays:
        if kind not in KINDS:
            raise BenchError(f"RAYS={kind}: no such kind of rays; there are {', '.join(KINDS)}")
    if arguments.mem not in MEMORIES:
        raise BenchError(f"MEM={arguments.mem}: no such memory; there are {', '.join(MEMORIES)}")
    for scene in arguments.scene:
        if not scene.is_file():
            raise BenchError(f"SCENES={scene}: there is no such file or scene of the project")
    if not 1000 <= arguments.count <= 100_000_000:
        raise BenchError(f"N={arguments.count}: give 1000 to 100000000 rays")
    if not 1 <= arguments.samples <= 4096:
        raise BenchError(f"--samples {arguments.samples}: give 1 to 4096")
    arguments.frame = frame_of(arguments.frame)
    return arguments


def frame_of(text: str) -> tuple[int, int]:
    """Width and height."""
    try:
        width, height = (int(word) for word in text.split("x"))
    except ValueError:
        width = height = 0
    if not (8 <= width <= 16384 and 8 <= height <= 16384):
        raise BenchError(f"SIZE={text}: give WIDTHxHEIGHT, each 8 to 16384")
    return width, height


def sample_tiles(tiles: int, wanted: int, seed: int = SEED) -> np.ndarray:
    """`wanted` of the numbers of `tiles` tiles, evenly spread, each tile as likely as another."""
    if wanted >= tiles:
        return np.arange(tiles)
    start = np.random.default_rng(seed).uniform(0, tiles / wanted)
    return np.minimum(tiles - 1, (start + np.arange(wanted) * (tiles / wanted)).astype(int))


def places_of(tiles: np.ndarray, rays: int) -> np.ndarray:
    """The numbers of the rays of tiles, of a frame of `rays` rays."""
    return np.concatenate([np.arange(TILE * i, min(TILE * (i + 1), rays)) for i in tiles])


def secondary_rays(
    scene, finder, kind: str, rays: np.ndarray, found, tiles: np.ndarray, samples: int
) -> np.ndarray:
    """`samples` rays of a kind from each hit of tiles of a frame, all of it in `rays`, `found`."""
    places = places_of(tiles, len(rays))
    start = (rays[places], found.hits[places], found.prims[places], samples)
    options = {"seed": SEED, "format": finder.format, "scale": finder.scale}
    if kind == "ao":
        return scene.ao_rays(*start, radius=AO_RADIUS * scene.diagonal, **options)
    return scene.diffuse_rays(*start, **options)


def rays_of(scene, finder, kind: str, arguments: argparse.Namespace) -> tuple[np.ndarray, bool]:
    """The rays of a cell in the order of the frame, and whether they are the whole frame."""
    rays, _ = scene.primary_rays(*arguments.frame, seed=SEED)
    tiles = math.ceil(len(rays) / TILE)
    if kind == "primary":
        whole = not arguments.sample_primary or arguments.count >= len(rays)
        if whole:
            return rays, True
        chosen = sample_tiles(tiles, math.ceil(arguments.count / TILE))
        return rays[places_of(chosen, len(rays))], False

    # As many tiles as give enough hits, by the hit rate of the frame.
    found = finder.trace(rays)
    rate = max(1, (found.prims >= 0).sum()) / len(rays)
    wanted = math.ceil(arguments.count / (arguments.samples * TILE * rate))
    chosen = sample_tiles(tiles, wanted)
    secondary = secondary_rays(scene, finder, kind, rays, found, chosen, arguments.samples)
    if len(secondary) < BATCHES:
        raise BenchError(f"{scene.name}: {kind} rays need hits, and camera rays have almost none")
    return secondary, wanted >= tiles


def interval(answered: np.ndarray, clock_mhz: float) -> list[float]:
    """95 % interval of Mrays/s from the cycles of answers, by batch means."""
    ends = np.sort(answered)
    edges = np.linspace(0, len(ends) - 1, BATCHES + 1).astype(int)
    cycles = np.diff(ends[edges]).astype(float)
    per_ray = cycles / np.diff(edges)
    mean = (ends[-1] - ends[0]) / (len(ends) - 1)
    half = T_OF_BATCHES * per_ray.std(ddof=1) / math.sqrt(BATCHES)
    return [clock_mhz / (mean + half), clock_mhz / max(mean - half, 1e-9)]


def measure(ti, path: Path, kind: str, arguments: argparse.Namespace) -> dict:
    """One cell."""
    scene = ti.Scene(path)
    finder = ti.Engine(scene, arguments.config)
    rays, whole = rays_of(scene, finder, kind, arguments)
    any_hit = kind == "ao"
    machine = ti.Engine(
        scene,
        arguments.config,
        "rtl",
        library=arguments.library,
        memory=arguments.mem,
        memory_latency=arguments.mem_latency,
        memory_bytes_per_cycle=arguments.mem_bytes_per_cycle,
    )
    warm_up = machine.trace(rays[: max(1, len(rays) // 20)], any_hit=any_hit)
    wave = machine.trace(rays, any_hit=any_hit)
    report = wave.report
    ci95 = None if whole else interval(wave.answered, report["clock_mhz"])
    return {
        "scene": scene.name,
        "ray_type": kind,
        "config": report["config"],
        "switches": report["switches"] | {"whole_frame": whole, "frame": list(arguments.frame)},
        "cores": report["keys"]["cores"],
        "mem": report["memory"],
        "rays": report["rays"],
        "cycles": report["cycles"],
        "mrays_per_s": report["mrays_per_s"],
        "ci95": ci95,
        "utilization": report["utilization"],
        "stalls": report["stalls"],
        "per_ray": report["per_ray"],
        "cache": report["cache"],
        "sim": report["sim"],
        "hits_sha256": hashlib.sha256(wave.hits.tobytes() + wave.prims.tobytes()).hexdigest(),
        "good": wave.good and warm_up.good,
    }


def sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def heading(arguments: argparse.Namespace, commit: str) -> dict:
    """What makes two benches the same: all that a cell's cycles depend on."""
    config = json.loads(arguments.config.read_text())
    return {
        "schema": SCHEMA,
        "commit": commit,
        "config": config,
        "library": sha256(arguments.library),
        "frame": list(arguments.frame),
        "count": arguments.count,
        "samples": arguments.samples,
        "sample_primary": arguments.sample_primary,
        "memory": [arguments.mem, arguments.mem_latency, arguments.mem_bytes_per_cycle],
        "scenes": [scene.name for scene in arguments.scene],
        "scene_sha256": [sha256(scene) for scene in arguments.scene],
        "rays": arguments.rays,
    }


def write_text(path: Path, text: str) -> None:
    """The old file or the whole new one, whoever looks and whatever happens."""
    partial = path.with_suffix(f".{os.getpid()}.part")
    try:
        partial.write_text(text)
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


def line(cell: dict) -> str:
    """A row of the table."""
    ci95 = "whole frame"
    if cell["ci95"]:
        ci95 = "{:.1f} to {:.1f}".format(*cell["ci95"])
    busy = cell["utilization"]
    return (
        f"{cell['scene']:16} {cell['ray_type']:8} {cell['rays']:>8} {cell['cycles']:>9} "
        f"{cell['mrays_per_s']:>8.1f} {ci95:>18} "
        f"{100 * busy['trv']:>4.0f} {100 * busy['list']:>4.0f} {100 * busy['ist1']:>4.0f} "
        f"{100 * busy['ist2']:>4.0f} {100 * cell['stalls'].get('axi', {}).get('works', 0):>5.0f} "
        f"{cell['per_ray']['dram_bytes']:>7.0f}{'' if cell['good'] else '  CHECKS FAILED'}"
    )


def run(words: list[str]) -> int:
    arguments = parse_arguments(words)
    if not arguments.library.is_file():
        raise BenchError(f"{arguments.library}: there is no such library; run `make engine`")
    import ti

    head = heading(arguments, ti.commit)
    file = arguments.out / "bench.json"
    arguments.out.mkdir(parents=True, exist_ok=True)
    cells = []
    if file.is_file():
        try:
            old = json.loads(file.read_text())
            if {key: old.get(key) for key in head} == head:
                cells = old["cells"]
        except (ValueError, KeyError, TypeError):
            cells = []
    if cells:
        print(f"{file}: going on behind {len(cells)} cells")
    mhz = head["config"]["clock_mhz"]
    print(f"{head['config']['name']}: Mrays/s if the clock is {mhz} MHz; % busy; bytes a ray")
    print(
        f"{'scene':16} {'rays':8} {'count':>8} {'cycles':>9} {'Mrays/s':>8} {'95 % interval':>18} "
        f"{'TRV':>4} {'LIST':>4} {'IST1':>4} {'IST2':>4} {'port':>5} {'B/ray':>7}"
    )
    for cell in cells:
        print(line(cell))
    wanted = [(scene, kind) for scene in arguments.scene for kind in arguments.rays]
    for scene, kind in wanted[len(cells) :]:
        cells.append(measure(ti, scene, kind, arguments))
        print(line(cells[-1]), flush=True)
        write_text(file, json.dumps(head | {"cells": cells}, indent=1) + "\n")
    print(f"{file}: {len(cells)} cells")
    return 0 if all(cell["good"] for cell in cells) else 1


def status_of(name: str, run, *refusals: type[Exception]) -> int:
    """The exit status of `run` on the words of the command; what refuses them is one sentence."""
    try:
        return run(sys.argv[1:])
    except (BenchError, *refusals) as error:
        print(error, file=sys.stderr)
    except OSError as error:
        print(f"{error.filename}: {error.strerror}", file=sys.stderr)
    except KeyboardInterrupt:
        print(f"{name}: stopped; the same command goes on from here", file=sys.stderr)
        return 130
    return 2


if __name__ == "__main__":
    sys.exit(status_of("bench", run, ValueError))
