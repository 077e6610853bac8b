#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Random machines trace random rays on random scenes, against the model and exact arithmetic.

A round is one machine, drawn from the seed and the round's number with its scenes and rays
(scripts/soak_round.py); its RTL is built with assertions.  Rounds go on until the hours or rays are
reached, some at a time, and each leaves a line in `OUT/rounds.jsonl`: a second call goes on behind
the last.  A run that fails leaves `OUT/failures/ROUND-RUN`: rays and triangles that still fail, as
few as were found, the steps of a ray, waves, and the command that repeats it.

Exit status: 0 when no run failed, 1 when one did, 2 when something cannot be.

Usage: scripts/soak.py [--hours H] [--rays N] [--round R] [--seed S] [--rays-a-run N] [--jobs N]
         [--out DIR]
"""

import argparse
import concurrent.futures
import json
import os
import shutil
import subprocess
import sys
import threading
import time
from pathlib import Path

import configure
import soak_reduce
import soak_round
from soak_round import ROOT, Round, Run

TI = ROOT / "build/sw/ti"
TIMEOUT_S = 1800  # of one run
NEVER = ("model_mismatches", "work_differs", "lost", "duplicated", "truth_unexplained")
NO_RAY = "no ray"  # what `ti` says of a kind of rays that a scene has none of


class SoakError(Exception):
    """One sentence: what cannot be."""


class Machine:
    """The RTL of a round, in a folder of its own."""

    def __init__(self, folder: Path, round_: Round):
        self.folder, self.round = folder, round_
        shutil.rmtree(folder, ignore_errors=True)
        round_.write_meshes(folder)
        configure.configure(soak_round.BASE, round_.overrides, folder / "config")

    def build(self, name: str = "", *words: str) -> Path:
        """The library of the RTL, with assertions; with `waves=1` one that writes waves."""
        engine = self.folder / name if name else self.folder
        engine.mkdir(exist_ok=True)
        command = ["scripts/build_engine.sh", engine, "make", "ASSERT=1", "-j", "1"]
        command += [f"config={self.folder}/config", f"what=round {self.round.number}", *words]
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise SoakError(f"round {self.round.number} does not build: {done.stdout}{done.stderr}")
        return engine / "libti_rtl.so"

    def scene(self, run: Run) -> Path:
        own = self.folder / run.scene
        return own if own.is_file() else ROOT / run.scene

    def trace(self, run: Run, library: Path, out: Path, *more, scene=None, rays=None):
        """One call of `ti trace`: its status, output and report."""
        shutil.rmtree(out, ignore_errors=True)
        command = [TI, "trace", "--engine", "rtl", "--rtl", library, "--no-progress"]
        command += ["--config", self.folder / "config/config.json", "--out", out]
        command += ["--scene", scene or self.scene(run), "--rays", rays or run.rays]
        command += [*run.options, *more]
        words = [str(word) for word in command]
        try:
            done = subprocess.run(
                words, cwd=ROOT, capture_output=True, text=True, timeout=TIMEOUT_S, check=False
            )
            status, said = done.returncode, done.stdout + done.stderr
        except subprocess.TimeoutExpired:
            status, said = None, f"does not end in {TIMEOUT_S} s"
        report = out / "report.json"
        return words, status, said, json.loads(report.read_text()) if report.is_file() else None


def verdict(run: Run, status: int | None, said: str, report: dict | None) -> str:
    """What is wrong with a run; empty when nothing is."""
    if status == 2 and NO_RAY in said:
        return ""
    if report is None:
        return f"status {status}: {said.strip()[-500:]}"
    check = report["check"]
    never = NEVER[:-1] if run.faults else NEVER  # a ray that memory failed is unlike the truth
    bad = [f"{name} {check[name]}" for name in never if check[name]]
    ends = check["status"]
    if ends["watchdog"]:
        bad.append(f"watchdog {ends['watchdog']}")
    if ends["memory_error"] and not run.faults:
        bad.append(f"memory_error {ends['memory_error']}")
    if status not in (0, 1) or (status == 1 and not bad and not ends["memory_error"]):
        bad.append(f"status {status}")
    return ", ".join(bad)


def play(round_: Round, out: Path) -> dict:
    """Builds and runs a round; its line of the log."""
    begin = time.monotonic()
    line = {"round": round_.number, "seed": round_.seed, "machine": " ".join(round_.overrides)}
    line |= {"refused": round_.refused, "rays": 0, "cycles": 0, "failures": [], "runs": []}
    machine = Machine(out / "work" / str(round_.number), round_)
    try:
        library = machine.build()
    except SoakError as error:
        line["failures"].append(str(error)[-2000:])
        return line | {"seconds": round(time.monotonic() - begin)}
    for number, run in enumerate(round_.runs):
        folder = machine.folder / f"run-{number}"
        words, status, said, report = machine.trace(run, library, folder)
        wrong = verdict(run, status, said, report)
        rays = report["rays"] if report else 0
        line["runs"].append([run.scene, run.rays, *run.options])
        line["rays"] += rays
        line["cycles"] += report["cycles"] if report else 0
        if wrong:
            case = out / "failures" / f"{round_.number}-{number}"
            line["failures"].append(f"run {number}: {wrong}; {case}")
            soak_reduce.reduce(machine, run, library, case, verdict, [*map(str, words)])
    if not line["failures"]:
        shutil.rmtree(machine.folder)
    return line | {"seconds": round(time.monotonic() - begin)}


def lines_of(log: Path, seed: int) -> list[dict]:
    """The rounds of this seed that a log has; a line cut short by a kill is none."""
    lines = []
    for text in log.read_text().splitlines() if log.is_file() else ():
        try:
            line = json.loads(text)
        except json.JSONDecodeError:
            continue
        if line["seed"] == seed:
            lines.append(line)
    return lines


def show(line: dict, seed: int) -> None:
    what = "; ".join(line["failures"]) or "good"
    print(
        f"round {line['round']:>4}  {line['rays']:>8} rays  {line['cycles']:>10} cycles  "
        f"{line['seconds']:>5} s  {what}"
    )
    if line["failures"]:
        print(f"repeat: make soak ROUND={line['round']} SEED={seed}")
    sys.stdout.flush()


def soak(arguments: argparse.Namespace) -> int:
    """Rounds until there is enough; the exit status."""
    out = arguments.out.resolve()
    out.mkdir(parents=True, exist_ok=True)
    log = out / "rounds.jsonl"
    before = [] if arguments.round is not None else lines_of(log, arguments.seed)
    done = {line["round"] for line in before}
    rays, failed = sum(line["rays"] for line in before), any(line["failures"] for line in before)
    if before:
        print(f"soak: {len(before)} rounds and {rays} rays are in {log}; going on")
    end = time.monotonic() + 3600 * arguments.hours
    lock = threading.Lock()
    numbers = iter([arguments.round] if arguments.round is not None else Numbers(done))

    def enough() -> bool:
        late = arguments.hours and time.monotonic() >= end
        return bool(late or (arguments.rays and rays >= arguments.rays))

    def work() -> None:
        nonlocal rays, failed
        while True:
            with lock:
                number = None if enough() else next(numbers, None)
            if number is None:
                return
            line = play(soak_round.draw(arguments.seed, number, arguments.rays_a_run), out)
            with lock:
                rays += line["rays"]
                failed = failed or bool(line["failures"])
                with log.open("a") as file:
                    file.write(json.dumps(line) + "\n")
                show(line, arguments.seed)

    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        for worker in [pool.submit(work) for _ in range(arguments.jobs)]:
            worker.result()
    lines = lines_of(log, arguments.seed)
    bad = sum(bool(line["failures"]) for line in lines)
    runs = sum(len(line["runs"]) for line in lines)
    rays, cycles = (sum(line[what] for line in lines) for what in ("rays", "cycles"))
    print(f"soak: seed {arguments.seed}, {len(lines)} machines, {runs} runs, {rays} rays,")
    print(f"      {cycles} cycles; {bad} rounds failed")
    return 1 if failed else 0


class Numbers:
    """0, 1, 2, ... without those that are done."""

    def __init__(self, done: set[int]):
        self._done, self._next = done, -1

    def __iter__(self):
        return self

    def __next__(self) -> int:
        self._next += 1
        while self._next in self._done:
            self._next += 1
        return self._next


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--hours", type=float, default=0.0)
    parser.add_argument("--rays", type=int, default=0)
    parser.add_argument("--round", type=int)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--rays-a-run", type=int, default=20000)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--out", type=Path, default=ROOT / "build/soak")
    arguments = parser.parse_args()
    if min(arguments.hours, arguments.rays, arguments.round or 0, arguments.seed) < 0:
        print("soak: hours, rays, round and seed are 0 or more", file=sys.stderr)
        return 2
    if arguments.round is None and not arguments.hours and not arguments.rays:
        print(
            "soak: say how long: HOURS=2 or RAYS=1000000, or ROUND= of one round", file=sys.stderr
        )
        return 2
    if arguments.rays_a_run < 1 or arguments.jobs < 1:
        print("soak: a run has a ray or more, and a job does them", file=sys.stderr)
        return 2
    return soak(arguments)


if __name__ == "__main__":
    sys.exit(main())
