#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Sweep number formats, triangle tests and walks of the tree: wrong hits beside what they cost.

A point is a scene with a format, a test and a walk.  `ti accuracy` counts its wrong hits against
exact arithmetic, for each kind of rays, on the model, which has the bits of the RTL, and renders it
beside an exact picture.  Beside it stand the operators of the machine (scripts/operators.py) with
their ECP5 cells in that format (scripts/area.py), the latency of a step and of a test, and
the bytes of a node and a triangle; with --rtl the cycles of primary rays on the RTL as well.

A scene may be moved before it is rounded: FILE@1e6 along x, FILE@1e6,0,2e5 along all axes.

A task of dask is a scene with all of its machines, which share what is exact; with --scheduler a
scene with those of one format.  `ti` writes a line a machine to a folder in OUT/runs; from there
points go to OUT/points.jsonl with the command that repeats them, and are not run again, so a sweep
that was stopped goes on.

OUT gets points.jsonl, points.csv, a table points.md, and index.html, which needs no other file.

Exit status: 0, 1 when a point failed, 2 for bad input.

Usage: scripts/accuracy.py --ti FILE --config NAME --out FOLDER --scene FILE[@MOVE] ...
                           [--formats "8,23 7,16"] [--tests "local woop"] [--traversals "plain"]
                           [--rays "edges far"] [--count N] [--seed N] [--work N] [--size 320x240]
                           [--rtl N] [--scheduler tcp://HOST:PORT | slurm:KEY=VALUE,...]
"""

import argparse
import hashlib
import json
import math
import subprocess
import sys
import time
from itertools import product
from pathlib import Path

import accuracy_cluster
import accuracy_page
import accuracy_pictures
import accuracy_tables
import configure
import points
from accuracy_costs import ROOT, AccuracyError, Costs, run
from config_schema import ConfigError

KEYS = ("format", "test", "traversal")  # of a machine
LOOKS = 0.5  # seconds between two looks for new lines


def wilson(count: int, of: int, z: float = 1.96) -> tuple[float, float]:
    """The 95 % interval of a rate in a million (Wilson 1927)."""
    if of == 0:
        return 0.0, 1e6
    share = count / of
    middle = (share + z * z / (2 * of)) / (1 + z * z / of)
    half = z / (1 + z * z / of) * math.sqrt(share * (1 - share) / of + z * z / (4 * of * of))
    return 1e6 * max(0.0, middle - half), 1e6 * min(1.0, middle + half)


def split_scene(scene: str) -> tuple[str, tuple[float, ...]]:
    """The file of FILE@MOVE and the three numbers by which it is moved, none where it is not."""
    file, at, text = scene.rpartition("@")
    if not at or Path(ROOT, scene).exists():
        return scene, ()
    try:
        numbers = tuple(float(x) for x in text.split(","))
    except ValueError:
        numbers = ()
    if len(numbers) not in (1, 3) or not all(abs(x) <= 3e38 for x in numbers):
        raise AccuracyError(
            f"SCENES={scene}: after @ give how far it is moved, in binary32: one number, along x, "
            "or three with commas"
        )
    return file, numbers if len(numbers) == 3 else (numbers[0], 0.0, 0.0)


def machine_of(config: str, fmt: str, test: str, walk: str) -> tuple[str, configure.Configuration]:
    """The overrides of a point's machine, and its configuration, checked."""
    exp_bits, _, frac_bits = fmt.partition(",")
    overrides = [f"exp_bits={exp_bits}", f"frac_bits={frac_bits}", f"triangle_test={test}"]
    overrides.append(f"traversal={walk}")
    return " ".join(overrides), configure.load(config, overrides)


def cycles_of(config: str, overrides: str, scene: str, rays: int) -> dict:
    """Primary rays on the RTL of a machine, which is built where it is new."""
    out = ROOT / "build/accuracy/rtl"
    run(["make", "-s", "trace", f"CONFIG={config}", f"SET={overrides}", f"SCENE={scene}",
         f"RAYS=primary:{rays}", f"OUT={out}"], f"{scene} on the RTL")  # fmt: skip
    report = json.loads((out / "report.json").read_text())
    return {
        "rays": report["rays"],
        "cycles_per_ray": report["cycles"] / report["rays"],
        "mrays_per_s": report["mrays_per_s"],
        "seconds": report["time"]["engine"],
    }


def with_rates(kinds: list[dict]) -> None:
    """Adds to each kind its rates in a million with their intervals."""
    for kind in kinds:
        for name in accuracy_tables.RATES:
            low, high = wilson(kind[name], kind["count"])
            rate = 1e6 * kind[name] / max(1, kind["count"])
            kind[f"{name}_per_million"] = {"rate": rate, "low": low, "high": high}


def trace(words: list[str]) -> str:
    """A task: runs `ti accuracy`; what it complains of, if anything."""
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    said = (done.stderr or done.stdout).strip().splitlines()
    return "" if done.returncode == 0 else said[-1] if said else f"status {done.returncode}"


class Task:
    """Machines of a scene that one run of `ti` traces, and the folder that it writes to."""

    def __init__(self, arguments: argparse.Namespace, scene: str, left: list[dict]):
        self.scene = scene
        self.waiting = {tuple(point[k] for k in KEYS): point for point in left}
        self.overrides = {}
        self.machines = {}
        words = [str(arguments.ti), "accuracy"]
        for key in self.waiting:
            fmt, test, walk = key
            self.overrides[key], self.machines[key] = machine_of(
                arguments.config, fmt[1:-1], test, walk
            )
            words.append(f"--config={self.folder_of(arguments, key)}/config.json")
        file, moved = split_scene(scene)
        words += [f"--scene={file}", f"--rays={arguments.rays}", f"--count={arguments.count}"]
        words += [
            f"--seed={arguments.seed}",
            f"--work={arguments.work}",
            f"--size={arguments.size}",
        ]
        if moved:
            words += ["--move", ",".join(f"{x:.17g}" for x in moved)]
        name = hashlib.sha256(json.dumps(words).encode()).hexdigest()[:8]
        self.out = arguments.out / "runs" / f"{accuracy_tables.scene_name(scene)}-{name}"
        self.words = [*words, f"--out={self.out}"]

    def folder_of(self, arguments: argparse.Namespace, key: tuple) -> Path:
        return arguments.out / "config" / configure.folder_name(self.overrides[key])

    def lines(self) -> list[tuple[dict, dict]]:
        """What is new in the folder: points with the lines of `ti`."""
        file = self.out / "points.jsonl"
        found = []
        for text in file.read_text().splitlines() if file.exists() else []:
            line = json.loads(text)
            point = self.waiting.pop(tuple(line[k] for k in KEYS), None)
            if point is not None:
                found.append((point, line))
        return found


class Sweep:
    """The points that are done, and what makes them of the lines of `ti`."""

    def __init__(self, arguments: argparse.Namespace):
        self.arguments = arguments
        self.file = arguments.out / "points.jsonl"
        self.done = points.load(self.file)
        self.failed: list[str] = []
        self.number = self.todo = 0
        self.costs = Costs(arguments.out)

    def tasks(self) -> list[Task]:
        """What is left to do."""
        arguments = self.arguments
        formats = arguments.formats.split()
        groups = [formats]
        if not accuracy_cluster.is_local(arguments.scheduler):
            groups = [[fmt] for fmt in formats]
        names = ("rays", "count", "seed", "work", "size")
        words = {name: getattr(arguments, name) for name in names}
        tasks = []
        for scene, group in product(dict.fromkeys(arguments.scene), groups):
            split_scene(scene)
            left = []
            others = (arguments.tests.split(), arguments.traversals.split())
            for fmt, test, walk in product(group, *others):
                point = {"scene": scene, "format": f"({fmt})", "test": test, "traversal": walk}
                point |= words
                if arguments.rtl:
                    point["rtl_rays"] = arguments.rtl
                if json.dumps(point) not in self.done:
                    left.append(point)
            if left:
                tasks.append(Task(arguments, scene, left))
        arguments.out.mkdir(parents=True, exist_ok=True)
        for task in tasks:
            for key, machine in task.machines.items():
                configure.write(task.folder_of(arguments, key), machine.files())
        self.todo = sum(len(task.waiting) for task in tasks)
        return tasks

    def add(self, task: Task, point: dict, line: dict) -> None:
        """Makes a point of a line of `ti`."""
        self.number += 1
        name = accuracy_page.name_of(point)
        head = f"[{self.number}/{self.todo}] {accuracy_tables.scene_name(point['scene'])} {name}"
        try:
            found = self.point_of(task, point, line)
        except AccuracyError as error:
            self.failed.append(f"{name}: {error}")
            print(f"{head}: FAILED, {error}", flush=True)
            return
        points.add(self.file, self.done, found)
        if "refused" in found:
            print(f"{head}: {found['refused']}", flush=True)
            return
        worst = max(k["cracks_per_million"]["rate"] for k in found["kinds"])
        pixels = found["picture"]["wrong_pixels"] if found["picture"] else "no picture, so no"
        print(f"{head}: at most {worst:.0f} cracks in a million, {pixels} wrong pixels, "
              f"{found['model_seconds']:.1f} s", flush=True)  # fmt: skip

    def point_of(self, task: Task, point: dict, line: dict) -> dict:
        arguments = self.arguments
        key = tuple(point[k] for k in KEYS)
        folder = task.folder_of(arguments, key)
        found = {"point": point}
        if "refused" in line:
            found["refused"] = line["refused"]
        else:
            for name in ("triangles", "dropped", "kinds", "model_seconds"):
                found[name] = line[name]
            with_rates(found["kinds"])
            found["picture"] = line["picture"]
            if line["picture"]:
                found["picture"] |= accuracy_pictures.compare(
                    arguments.out, task.out.relative_to(arguments.out), line["picture"]["file"]
                )
        found |= self.costs.of(task.machines[key], folder)
        if arguments.rtl and "refused" not in line and "@" not in point["scene"]:
            found["rtl"] = cycles_of(
                arguments.config, task.overrides[key], point["scene"], arguments.rtl
            )
        found["command"] = (
            f'make accuracy CONFIG={arguments.config} SCENES="{point["scene"]}" '
            f'FORMATS="{point["format"][1:-1]}" TESTS={point["test"]} '
            f'TRAVERSALS={point["traversal"]} RAYS="{arguments.rays}" N={arguments.count} '
            f"SEED={arguments.seed} WORK={arguments.work} SIZE={arguments.size}"
            + (f" RTL={arguments.rtl}" if arguments.rtl else "")
        )
        return found

    def run(self, tasks: list[Task], client) -> None:
        """Runs tasks and takes in their lines as they come."""
        running = {task: client.submit(trace, task.words, pure=False) for task in tasks}
        while running:
            time.sleep(LOOKS)
            for task, future in list(running.items()):
                ended = future.done()
                for point, line in task.lines():
                    self.add(task, point, line)
                if not ended:
                    continue
                del running[task]
                said = str(future.exception()) if future.status == "error" else future.result()
                self.number += len(task.waiting)
                if task.waiting:
                    names = ", ".join(map(accuracy_page.name_of, task.waiting.values()))
                    self.failed.append(said or f"{task.out}: {names}: not in what ti wrote")


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--ti", type=Path, required=True)
    parser.add_argument("--config", required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--scene", nargs="+", required=True, metavar="FILE[@MOVE]")
    parser.add_argument("--formats", default="5,10 8,13 7,16 8,20 8,23")
    parser.add_argument("--tests", default="np local woop")
    parser.add_argument("--traversals", default="plain padded")
    parser.add_argument("--rays", default="uniform edges vertices grazing far secondary")
    parser.add_argument("--count", type=int, default=100000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--work",
        type=float,
        default=1e8,
        help="steps and tests for rays of a kind, then fewer rays",
    )
    parser.add_argument("--size", default="320x240", metavar="WIDTHxHEIGHT")
    parser.add_argument("--rtl", type=int, default=0, metavar="N", help="rays on the RTL; 0: none")
    parser.add_argument("--scheduler", default="", metavar="ADDRESS")
    return parser.parse_args()


def main() -> int:
    arguments = parse_arguments()
    arguments.ti, arguments.out = arguments.ti.resolve(), arguments.out.resolve()
    try:
        accuracy_cluster.check(arguments.scheduler)
        sweep = Sweep(arguments)
        tasks = sweep.tasks()
        print(f"{len(sweep.done)} points are there, {sweep.todo} to do", flush=True)
        if tasks:
            with accuracy_cluster.client_of(arguments.scheduler) as client:
                sweep.run(tasks, client)
    except (AccuracyError, ConfigError, points.PointsError) as error:
        print(error, file=sys.stderr)
        return 2
    except OSError as error:
        print(
            f"{error.filename or arguments.scheduler}: {error.strerror or error}", file=sys.stderr
        )
        return 2
    lines = list(sweep.done.values())
    if lines:
        accuracy_tables.write_csv(arguments.out / "points.csv", lines)
        accuracy_tables.write_markdown(arguments.out / "points.md", lines)
        page = arguments.out / "index.html"
        page.write_text(accuracy_page.page(lines, arguments.out))
        print(f"{sweep.file}, {arguments.out / 'points.csv'}, {page}")
    for sentence in dict.fromkeys(sweep.failed):
        print(sentence, file=sys.stderr)
    return 0 if not sweep.failed else 1 if lines else 2


if __name__ == "__main__":
    sys.exit(main())
