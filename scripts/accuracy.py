#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Sweep number formats, triangle tests and walks of the tree: wrong hits beside what they cost.

A point is a scene with a format, a test and a walk.  `ti accuracy` counts its wrong hits against
exact arithmetic, for each kind of rays, on the model, which has the bits of the RTL.  Beside it
stand the operators of the machine (scripts/operators.py) with their ECP5 cells in that format
(scripts/synth_check.py), the latency of a step and of a test, and the bytes of a node and a
triangle; with --rtl the cycles of primary rays on the RTL as well.

Points are tasks of dask.distributed: a cluster of this machine, one task at a time, as each uses
all processors, or any other by --scheduler.  Each is written to OUT/points.jsonl when it is done,
with the command that repeats it, and is not run again, so a sweep that was stopped goes on.

OUT gets points.jsonl, points.csv, a table points.md, and index.html, which needs no other file.

Exit status: 0, 1 when a point failed, 2 for bad input.

Usage: scripts/accuracy.py --ti FILE --config NAME --out FOLDER --scene FILE ...
                           [--formats "8,23 7,16"] [--tests "local woop"] [--traversals "plain"]
                           [--rays "edges far"] [--count N] [--seed N] [--rtl N]
                           [--scheduler ADDRESS]
"""

import argparse
import json
import math
import subprocess
import sys
import time
from itertools import product
from pathlib import Path

import accuracy_page
import configure
import points
from config_schema import ConfigError
from dask.distributed import Client, LocalCluster, as_completed

ROOT = Path(__file__).resolve().parents[1]
VENV = ROOT / "build/venv/bin/python"  # has what the other scripts ask for
OPERATORS = {"ADD": "ti_fp_add", "MUL": "ti_fp_mul", "RCP": "ti_fp_rcp", "CMP": "ti_fp_cmp"}
CELLS = {"lut": ("LUT4",), "ff": ("TRELLIS_FF",), "dsp": ("MULT18X18D",)}
NODE_BYTES = 8


class AccuracyError(Exception):
    """One sentence for the user."""


def wilson(count: int, of: int, z: float = 1.96) -> tuple[float, float]:
    """The 95 % interval of a rate in a million (Wilson 1927)."""
    if of == 0:
        return 0.0, 1e6
    share = count / of
    middle = (share + z * z / (2 * of)) / (1 + z * z / of)
    half = z / (1 + z * z / of) * math.sqrt(share * (1 - share) / of + z * z / (4 * of * of))
    return 1e6 * max(0.0, middle - half), 1e6 * min(1.0, middle + half)


def run(words: list, what: str) -> str:
    """What a program prints; its last words when it fails."""
    done = subprocess.run([str(w) for w in words], cwd=ROOT, capture_output=True, text=True)
    if done.returncode != 0:
        said = (done.stderr or done.stdout).strip().splitlines()
        raise AccuracyError(f"{what}: {said[-1] if said else f'status {done.returncode}'}")
    return done.stdout


def machine_of(config: str, fmt: str, test: str, walk: str) -> tuple[str, configure.Configuration]:
    """The overrides of a point's machine, and its configuration, checked."""
    exp_bits, _, frac_bits = fmt.partition(",")
    overrides = [f"exp_bits={exp_bits}", f"frac_bits={frac_bits}", f"triangle_test={test}"]
    overrides.append(f"traversal={walk}")
    return " ".join(overrides), configure.load(config, overrides)


def latencies(keys: dict) -> dict[str, int]:
    """Cycles from a node to the next, and from a record to the verdict and to the hit."""
    add, mul = keys["fp_add_stages"], keys["fp_mul_stages"]
    rcp = configure.reciprocal_stages(keys)
    if keys["triangle_test"] == "woop":
        passes, last = 3 * add + 2 * mul + 2, 3 * mul + 2 * add + rcp + 1
    else:
        one = (5 if keys["triangle_test"] == "np" else 4) * add + 3 * mul + 2
        passes, last = 2 * one, rcp + mul + 1
    return {"step": 2 + add + mul, "test": passes, "hit": passes + last}


def triangle_bytes(keys: dict) -> int:
    if keys["triangle_test"] != "woop":
        return 48
    return 32 if 9 * (1 + keys["exp_bits"] + keys["frac_bits"]) + 32 <= 256 else 64


class Costs:
    """Operators and cells of machines, each counted once."""

    def __init__(self, folder: Path):
        self._folder = folder
        self._cells: dict[tuple[int, int], dict] = {}
        self._operators: dict[tuple[str, str], dict] = {}

    def of(self, machine: configure.Configuration, folder: Path) -> dict:
        keys = machine.values
        cells = self._cells_of(keys, folder)
        operators = self._operators_of(keys, folder)
        sums = {c: sum(operators[o] * cells[o][c] for o in OPERATORS) for c in CELLS}
        return {
            "operators": operators,
            **{f"operator_{c}": total for c, total in sums.items()},
            "latency": latencies(keys),
            "bytes": {"node": NODE_BYTES, "triangle": triangle_bytes(keys)},
        }

    def _cells_of(self, keys: dict, folder: Path) -> dict:
        fmt = keys["exp_bits"], keys["frac_bits"]
        if fmt not in self._cells:
            self._cells[fmt] = {name: self._synthesize(folder, m) for name, m in OPERATORS.items()}
        return self._cells[fmt]

    def _synthesize(self, folder: Path, module: str) -> dict:
        out = self._folder / "cells.json"
        words = [VENV, "scripts/synth_check.py", folder, "--unit", module, "--json", out]
        run(words, module)
        cells = json.loads(out.read_text())["ecp5_cells"][module]
        return {c: sum(cells.get(n, 0) for n in names) for c, names in CELLS.items()}

    def _operators_of(self, keys: dict, folder: Path) -> dict:
        kind = keys["triangle_test"], keys["traversal"]
        if kind not in self._operators:
            out = self._folder / "operators.json"
            run([VENV, "scripts/operators.py", folder, "--json", out], "operators")
            self._operators[kind] = json.loads(out.read_text())["total"]["operators"]
        return self._operators[kind]


def count_wrong(ti: str, folder: str, scene: str, words: dict) -> dict:
    """A task: the wrong hits of a point, by kind of rays."""
    begin = time.monotonic()
    out = Path(folder) / f"{Path(scene).name.split('.')[0]}.json"
    options = [f"--{k}={v}" for k, v in words.items()]
    run([ti, "accuracy", f"--config={folder}/config.json", f"--scene={scene}", *options,
         f"--out={out}"], scene)  # fmt: skip
    return {"kinds": json.loads(out.read_text())["points"], "seconds": time.monotonic() - begin}


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
        for name in ("missed", "through", "cracks", "false_hits", "wrong_triangle", "self_hits"):
            low, high = wilson(kind[name], kind["count"])
            rate = 1e6 * kind[name] / max(1, kind["count"])
            kind[f"{name}_per_million"] = {"rate": rate, "low": low, "high": high}


def sweep(arguments: argparse.Namespace, client: Client, done: dict, file: Path) -> list[str]:
    """Runs the points that are not done; the sentences of those that failed."""
    costs, waiting, failed = Costs(arguments.out), {}, []
    axes = (arguments.formats.split(), arguments.tests.split(), arguments.traversals.split())
    words = {"rays": arguments.rays, "count": arguments.count, "seed": arguments.seed}
    todo = []
    for fmt, test, walk, scene in product(*axes, arguments.scene):
        overrides, machine = machine_of(arguments.config, fmt, test, walk)
        point = {"scene": scene, "format": f"({fmt})", "test": test, "traversal": walk, **words}
        if arguments.rtl:
            point["rtl_rays"] = arguments.rtl
        if points.key_of(point) not in done:
            todo.append((point, overrides, machine))
    print(f"{len(done)} points are there, {len(todo)} to do", flush=True)
    for point, overrides, machine in todo:
        folder = arguments.out / "config" / overrides.replace(" ", "-")
        configure.write(folder, machine.files())
        task = client.submit(
            count_wrong, str(arguments.ti), str(folder), point["scene"], words, pure=False
        )
        waiting[task.key] = point, overrides, machine, folder, task
    for number, task in enumerate(as_completed([w[-1] for w in waiting.values()]), 1):
        point, overrides, machine, folder, _ = waiting[task.key]
        name = f"{Path(point['scene']).name} {point['format']} {point['test']} {point['traversal']}"
        try:
            found = task.result()
            with_rates(found["kinds"])
            cost = costs.of(machine, folder)
            if arguments.rtl:
                cost["rtl"] = cycles_of(arguments.config, overrides, point["scene"], arguments.rtl)
        except AccuracyError as error:
            failed.append(f"{name}: {error}")
            print(f"[{number}/{len(todo)}] {name}: FAILED, {error}", flush=True)
            continue
        command = (
            f"make accuracy CONFIG={arguments.config} SCENES={point['scene']} "
            f'FORMATS="{point["format"][1:-1]}" TESTS={point["test"]} '
            f'TRAVERSALS={point["traversal"]} RAYS="{arguments.rays}" N={arguments.count} '
            f"SEED={arguments.seed}"
        )
        line = {"point": point, **found, **cost, "command": command}
        points.add(file, done, line)
        worst = max(k["cracks_per_million"]["rate"] for k in found["kinds"])
        print(f"[{number}/{len(todo)}] {name}: at most {worst:.0f} cracks in a million, "
              f"{found['seconds']:.1f} s", flush=True)  # fmt: skip
    return failed


def write_csv(path: Path, lines: list[dict]) -> None:
    """A row for each point and kind of rays."""
    rows = []
    for line in lines:
        point = line["point"]
        shared = {k: point[k] for k in ("scene", "format", "test", "traversal")}
        for kind in line["kinds"]:
            rates = {k: v["rate"] for k, v in kind.items() if k.endswith("_per_million")}
            rows.append({
                **shared, "rays": kind["rays"], "count": kind["count"], **rates,
                "t_ulp_median": kind["t_ulp"]["median"], "t_ulp_p99_9": kind["t_ulp"]["p99_9"],
                "t_ulp_max": kind["t_ulp"]["max"], "steps_per_ray": kind["steps_per_ray"],
                "tests_per_ray": kind["tests_per_ray"],
                "restarts_per_ray": kind["restarts_per_ray"],
                **line["operators"], "operator_lut": line["operator_lut"],
                "operator_ff": line["operator_ff"], "operator_dsp": line["operator_dsp"],
                "triangle_bytes": line["bytes"]["triangle"],
                "cycles_per_ray": line.get("rtl", {}).get("cycles_per_ray"),
                "mrays_per_s": line.get("rtl", {}).get("mrays_per_s"),
            })  # fmt: skip
    points.write_csv(path, rows)


def write_table(path: Path, lines: list[dict]) -> None:
    """The table for documents: cracks by kind of rays in a million, and what a machine costs."""
    kinds = list(dict.fromkeys(kind["rays"] for line in lines for kind in line["kinds"]))
    names = [f"cracks, {kind}" for kind in kinds]
    names += ["missed, edges", "wrong, uniform", "t p99.9, uniform, ulp", "steps, uniform"]
    names += ["LUT", "DSP", "bytes a triangle", "cycles a ray", "Mrays/s"]
    rows = []
    for line in lines:
        point, of, rtl = line["point"], {k["rays"]: k for k in line["kinds"]}, line.get("rtl")

        def rate(kind, name, of=of):
            return f"{of[kind][f'{name}_per_million']['rate']:,.0f}" if kind in of else ""

        row = [Path(point["scene"]).name.split(".")[0]]
        row += [point["format"], point["test"], point["traversal"]]
        row += [rate(kind, "cracks") for kind in kinds]
        row += [rate("edges", "missed"), rate("uniform", "wrong_triangle")]
        uniform = of.get("uniform")
        row += [f"{uniform['t_ulp']['p99_9']:.1f}" if uniform else ""]
        row += [f"{uniform['steps_per_ray']:.1f}" if uniform else ""]
        row += [f"{line['operator_lut']:,}", str(line["operator_dsp"])]
        row += [str(line["bytes"]["triangle"])]
        row += [f"{rtl['cycles_per_ray']:.2f}", f"{rtl['mrays_per_s']:.1f}"] if rtl else ["", ""]
        rows.append(row)
    points.write_table(path, ["scene", "format", "test", "walk"], names, rows)


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--ti", type=Path, required=True)
    parser.add_argument("--config", required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--scene", nargs="+", required=True)
    parser.add_argument("--formats", default="5,10 8,13 7,16 8,20 8,23")
    parser.add_argument("--tests", default="np local woop")
    parser.add_argument("--traversals", default="plain padded")
    parser.add_argument("--rays", default="uniform edges vertices grazing far secondary")
    parser.add_argument("--count", type=int, default=100000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--rtl", type=int, default=0, metavar="N", help="rays on the RTL; 0: none")
    parser.add_argument("--scheduler", default="", metavar="ADDRESS")
    return parser.parse_args()


def main() -> int:
    arguments = parse_arguments()
    arguments.ti, arguments.out = arguments.ti.resolve(), arguments.out.resolve()
    try:
        arguments.out.mkdir(parents=True, exist_ok=True)
        file = arguments.out / "points.jsonl"
        done = points.load(file)
        if arguments.scheduler:
            client = Client(arguments.scheduler)
        else:
            cluster = LocalCluster(
                n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None
            )
            client = Client(cluster)
        with client:
            failed = sweep(arguments, client, done, file)
    except (AccuracyError, ConfigError, points.PointsError) as error:
        print(error, file=sys.stderr)
        return 2
    except OSError as error:
        print(
            f"{error.filename or arguments.scheduler}: {error.strerror or error}", file=sys.stderr
        )
        return 2
    if done:
        write_csv(arguments.out / "points.csv", list(done.values()))
        write_table(arguments.out / "points.md", list(done.values()))
        page = arguments.out / "index.html"
        page.write_text(accuracy_page.page(list(done.values())))
        print(f"{file}, {arguments.out / 'points.csv'}, {page}")
    for sentence in failed:
        print(sentence, file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
