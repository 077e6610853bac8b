#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What a faster simulation gets wrong: error of Mrays/s against the seconds that it takes.

A cell is a scene with a kind of rays (scripts/bench.py).  The full run is the RTL with the last of
the memories, a DRAM unless --mem says otherwise, and the whole frame.  Beside it stand the RTL with
each memory and the functional model, on samples of the frame and on all of it.  The model has no
cycles: its Mrays/s are the ceiling that its work puts on the machine, units x operations a cycle
over operations a ray, of the unit whose ceiling is lowest.

A sample is whole tiles of 8x8 pixels, drawn as the bench draws them, each run another draw; as
there a twentieth of it is traced before and not counted, but its seconds are.  Seconds are those of
the processor, of tracing alone: scene, tree and rays are made before.  Engines follow one another
within a sample, and samples within a run, so that what else the machine does meets all alike.

Each measurement is a line of OUT/points.jsonl as soon as it is there.  Started again with the same
machine, frame and memories it goes on where it stood, with other cells, samples and runs too; with
another it begins anew.  OUT also gets points.csv, a row for each point, points.md, and index.html,
which needs no other file.

Exit status: 0, 1 when hits of the RTL are not the model's, 2 for bad input.

Usage: scripts/fidelity.py --config NAME [--set "KEY=VALUE ..."] [--cores N] --out FOLDER
                           --scene FILE ... [--rays KIND ...] [--shares "1/64 1/16"] [--runs N]
                           [--frame WIDTHxHEIGHT] [--mem "ideal fixed dram"]
                           [--mem-latency CYCLES] [--mem-bytes-per-cycle BYTES]
"""

import argparse
import hashlib
import json
import math
import sys
import time
from collections.abc import Iterator
from fractions import Fraction
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import bench
import compare
import fidelity_page
import numpy as np
import points
from config_schema import ConfigError

MODEL = "model"
SAMPLES = 4  # secondary rays from a hit


class Point(NamedTuple):
    """One measurement."""

    scene: str
    rays: str
    share: str  # of the frame: "1/16", and "1" for all of it
    engine: str  # `model`, or the memory behind the RTL
    run: int  # the number of the draw, from 1


def shares_of(text: str) -> list[Fraction]:
    """The samples of a list such as "1/64 1/16", ascending, and the whole frame."""
    shares = {Fraction(1)}
    for word in text.split():
        try:
            share = Fraction(word)
        except (ValueError, ZeroDivisionError):
            share = Fraction(0)
        if not Fraction(1, 65536) <= share <= 1:
            raise bench.BenchError(f"N={word}: give shares of the frame from 1/65536 to 1, as 1/16")
        shares.add(share)
    return sorted(shares)


def memories_of(text: str) -> list[str]:
    """Kinds of memory, each once; the last is that of the full run."""
    memories = list(dict.fromkeys(text.split()))
    for name in memories or [text]:
        if name not in bench.MEMORIES:
            raise bench.BenchError(
                f"MEM={name}: no such memory; give some of {', '.join(bench.MEMORIES)}, "
                "that of the full run last"
            )
    return memories


def parse_arguments(words: list[str]) -> argparse.Namespace:
    parser = bench.Parser(description=__doc__.splitlines()[0])
    parser.add_argument("--config", required=True, help="name or file of a configuration")
    parser.add_argument("--set", default="", help="overrides of it")
    parser.add_argument("--cores", default="", help="its cores")
    parser.add_argument("--out", type=Path, required=True, help="folder of the points")
    parser.add_argument("--scene", type=Path, nargs="+", required=True, help="scenes")
    parser.add_argument("--rays", nargs="+", default=["primary", "diffuse"], help="kinds of rays")
    parser.add_argument("--shares", default="1/64 1/16 1/4", help="samples, shares of the frame")
    parser.add_argument("--runs", default="3", help="runs of each point, each another sample")
    parser.add_argument("--frame", default="128x128", help="WIDTHxHEIGHT")
    parser.add_argument("--mem", default=" ".join(bench.MEMORIES), help="the full run's last")
    parser.add_argument("--mem-latency", type=int, default=100, help="of a fixed one: cycles")
    parser.add_argument("--mem-bytes-per-cycle", type=float, default=64.0, help="bytes a cycle")
    arguments = parser.parse_args(words)
    for kind in arguments.rays:
        if kind not in bench.KINDS:
            known = ", ".join(bench.KINDS)
            raise bench.BenchError(f"RAYS={kind}: no such kind of rays; there are {known}")
    for scene in arguments.scene:
        if not scene.is_file():
            raise bench.BenchError(f"SCENES={scene}: there is no such file or scene of the project")
    if not (arguments.runs.isdecimal() and 1 <= int(arguments.runs) <= 99):
        raise bench.BenchError(f"RUNS={arguments.runs}: give 1 to 99")
    arguments.runs = int(arguments.runs)
    arguments.shares = shares_of(arguments.shares)
    arguments.mem = memories_of(arguments.mem)
    arguments.frame = bench.frame_of(arguments.frame)
    return arguments


def ceilings(report: dict[str, Any]) -> dict[str, float]:
    """Mrays/s that the rays' work allows, by kind of unit: peak operations over those a ray has."""
    keys, work, phase = report["keys"], report["per_ray"], report["phase"]
    tests = work["tests"]
    cycles = {
        "rd": keys["rd_cycles"],
        "trv": work["steps"] / keys["num_trv"],
        "list": tests / keys["num_list"],
        "ist1": tests * (1 + phase["b_share"]) / keys["num_ist1"],
        "ist2": tests * phase["c_share"],
    }
    peak = keys["cores"] * report["clock_mhz"]
    return {unit: peak / needed for unit, needed in cycles.items() if needed > 0}


def hits_of(wave) -> str:
    """The same for two waves exactly when their hits are."""
    return hashlib.sha256(wave.hits.tobytes() + wave.prims.tobytes()).hexdigest()


class Frame:
    """A scene with the rays of a frame, and the model, which finds their hits."""

    def __init__(self, ti, path: Path, config: Path, size: tuple[int, int]):
        self.scene = ti.Scene(path)
        self.model = ti.Engine(self.scene, config)
        self._rays, _ = self.scene.primary_rays(*size, seed=bench.SEED)

    @cached_property
    def _found(self):
        return self.model.trace(self._rays)

    @cached_property
    def _lit(self) -> np.ndarray:
        """Tiles in which a ray hits."""
        return np.unique(np.flatnonzero(self._found.prims >= 0) // bench.TILE)

    def rays(self, kind: str, share: Fraction, run: int) -> np.ndarray:
        """A sample: of primary rays tiles of the frame, of others tiles with hits."""
        every = np.arange(math.ceil(len(self._rays) / bench.TILE))
        tiles = every if kind == "primary" else self._lit
        if len(tiles) == 0:
            raise bench.BenchError(
                f"{self.scene.name}: {kind} rays need hits, and camera rays have none"
            )
        tiles = tiles[bench.sample_tiles(len(tiles), math.ceil(len(tiles) * share), run)]
        if kind == "primary":
            return self._rays[bench.places_of(tiles, len(self._rays))]
        start = (self._rays, self._found, tiles, SAMPLES)
        return bench.secondary_rays(self.scene, self.model, kind, *start)


class Measurement:
    """All that the points of a sweep share."""

    def __init__(self, ti, arguments: argparse.Namespace, config: Path, library: Path):
        self._ti, self._arguments, self._config, self._library = ti, arguments, config, library
        self._frames: dict[Path, Frame] = {}
        self._hits: dict[tuple, str] = {}

    def heading(self) -> dict:
        """What makes two measurements of a point the same."""
        arguments = self._arguments
        return {
            "commit": self._ti.commit,
            "config": json.loads(self._config.read_text()),
            # Not of the whole library, which is linked anew with DRAMsim3 and without.
            "rtl": bench.sha256(self._library.parent / "verilated/libVti_engine.a"),
            "frame": list(arguments.frame),
            "samples": SAMPLES,
            "full": arguments.mem[-1],
            "fixed": [arguments.mem_latency, arguments.mem_bytes_per_cycle],
        }

    def of(self, point: Point, path: Path) -> dict:
        """Measures a point."""
        if path not in self._frames:
            self._frames[path] = Frame(self._ti, path, self._config, self._arguments.frame)
        frame = self._frames[path]
        rays = frame.rays(point.rays, Fraction(point.share), point.run)
        any_hit = point.rays == "ao"
        sample = point[:3], point.run
        if point.engine == MODEL:
            waves, seconds = self._trace(frame.model, [rays], any_hit)
            bounds = ceilings(waves[-1].report)
            binds = min(bounds, key=bounds.__getitem__)
            found = {"cycles": None, "mrays_per_s": bounds[binds], "ceilings": bounds}
        else:
            engine = self._machine(frame.scene, point.engine)
            warm_up = rays[: max(1, len(rays) // 20)]
            waves, seconds = self._trace(engine, [warm_up, rays], any_hit)
            report = waves[-1].report
            found = {k: report[k] for k in ("cycles", "mrays_per_s")} | {"ceilings": None}
            binds = max(report["stalls"], key=lambda unit: report["stalls"][unit]["works"])
        if point.engine == MODEL:
            self._hits[sample] = hits_of(waves[-1])
        elif sample not in self._hits:
            self._hits[sample] = hits_of(frame.model.trace(rays, any_hit=any_hit))
        good = hits_of(waves[-1]) == self._hits[sample] and all(wave.good for wave in waves)
        return found | {"count": len(rays), "busiest": binds, "seconds": seconds, "good": good}

    def _machine(self, scene, memory: str):
        arguments = self._arguments
        return self._ti.Engine(
            scene,
            self._config,
            "rtl",
            library=self._library,
            lock_step=False,
            memory=memory,
            memory_latency=arguments.mem_latency,
            memory_bytes_per_cycle=arguments.mem_bytes_per_cycle,
        )

    @staticmethod
    def _trace(engine, waves: list[np.ndarray], any_hit: bool) -> tuple[list, dict[str, float]]:
        """What came of the waves, and the seconds of all of them."""
        begin = time.process_time(), time.monotonic()
        traced = [engine.trace(wave, any_hit=any_hit) for wave in waves]
        end = time.process_time(), time.monotonic()
        return traced, {"cpu": end[0] - begin[0], "wall": end[1] - begin[1]}


def wanted(arguments: argparse.Namespace) -> Iterator[tuple[Point, Path]]:
    """Points in the order in which they are measured, each with the file of its scene."""
    for run in range(1, arguments.runs + 1):
        for path in arguments.scene:
            for kind in arguments.rays:
                for share in arguments.shares:
                    for engine in (MODEL, *arguments.mem):
                        yield Point(path.name, kind, str(share), engine, run), path


def say(number: int, of: int, point: Point, line: dict) -> None:
    cycles = "" if line["cycles"] is None else f", {line['cycles']} cycles"
    print(
        f"[{number}/{of}] {point.scene} {point.rays} {point.share} {point.engine}, run {point.run}:"
        f" {line['mrays_per_s']:.1f} Mrays/s{cycles}, {line['seconds']['cpu']:.2f} s"
        f"{'' if line['good'] else '  CHECKS FAILED'}",
        flush=True,
    )


def run(words: list[str]) -> int:
    arguments = parse_arguments(words)
    # All that may be wrong in the words is said before anything is built.
    machine, _ = compare.machine_of(arguments, "")
    config, library = compare.build_engine(arguments, "", "dram" in arguments.mem)
    sys.path.insert(0, str(bench.ROOT / "build/sw/python"))
    import ti

    measurement = Measurement(ti, arguments, config, library)
    text = json.dumps(measurement.heading(), sort_keys=True)
    of_run = hashlib.sha256(text.encode()).hexdigest()[:16]
    arguments.out.mkdir(parents=True, exist_ok=True)
    file = arguments.out / "points.jsonl"
    there = points.load(file)
    scenes = {path.name: bench.sha256(path) for path in arguments.scene}
    lines = {
        key: line
        for key, line in there.items()
        if line["heading"] == of_run
        and line["scene_sha256"] == scenes.get(line["point"]["scene"], line["scene_sha256"])
    }
    if len(lines) < len(there):
        print(f"{file}: of another machine, frame, memory or scene; those points begin anew")
        points.store(file, lines)
    todo = [
        (point, path)
        for point, path in wanted(arguments)
        if points.key_of(point._asdict()) not in lines
    ]
    print(f"{machine.name}: {len(lines)} measurements are there, {len(todo)} to do", flush=True)
    sitting = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
    for number, (point, path) in enumerate(todo, 1):
        line = {"point": point._asdict(), "heading": of_run, "sitting": sitting}
        line["scene_sha256"] = scenes[point.scene]
        line |= measurement.of(point, path)
        points.add(file, lines, line)
        say(number, len(todo), point, line)

    about = fidelity_page.About(
        machine.name, arguments.frame, SAMPLES, (MODEL, *arguments.mem), arguments.mem_latency,
        arguments.mem_bytes_per_cycle, command_of(arguments),
    )  # fmt: skip
    cells = fidelity_page.cells_of(list(lines.values()), arguments.mem[-1])
    points.write_csv(arguments.out / "points.csv", fidelity_page.csv_rows(cells))
    points.write_table(arguments.out / "points.md", *fidelity_page.table(cells))
    bench.write_text(arguments.out / "index.html", fidelity_page.page(cells, about))
    for sentence in (s for cell in cells for s in cell.sentences):
        print(sentence)
    print(f"{file}, {arguments.out / 'points.csv'}, {arguments.out / 'index.html'}")
    return 0 if all(line["good"] for line in lines.values()) else 1


def command_of(arguments: argparse.Namespace) -> str:
    """What makes the page again."""
    words = {
        "SCENES": " ".join(path.name.split(".")[0] for path in arguments.scene),
        "RAYS": " ".join(arguments.rays),
        "N": " ".join(str(share) for share in arguments.shares[:-1]),
        "SIZE": "x".join(map(str, arguments.frame)),
        "RUNS": str(arguments.runs),
        "MEM": " ".join(arguments.mem),
        "CONFIG": arguments.config,
        "SET": arguments.set,
        "CORES": arguments.cores,
    }
    given = [f'{k}="{v}"' if " " in v else f"{k}={v}" for k, v in words.items() if v]
    return " ".join(["make fidelity", *given])


if __name__ == "__main__":
    refusals = (ValueError, compare.CompareError, ConfigError)
    sys.exit(bench.status_of("fidelity", run, *refusals))
