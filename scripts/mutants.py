#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Put each fault of `tb/mutants.yaml` into a copy of the project and see which tests find it.

For each fault the unit tests that it names run on the copy, then the engine `tiny` in lock-step
with the model on three short runs.  The unchanged copy goes first: a test that is red there proves
nothing.  The RTL of the project itself is only read.

Exit status: 0 when every fault is found, 1 when one survives, 2 when the table is wrong, a fault
does not build, or the unchanged copy is red.

Usage: scripts/mutants.py [--only PART_OF_A_NAME]
"""

import argparse
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[1]
TABLE = ROOT / "tb/mutants.yaml"
WORK = ROOT / "build/mutants"
COPIED = ("rtl", "tb", "configs", "lint", "scripts", "sim", "Makefile", "pyproject.toml")
TIMEOUT_S = 900  # of one command; a fault may well never end

# Runs of `ti trace` on the engine: rays, scene, further options.
RANDOM = "random:3000"
LOCK_STEP = {
    "cornell": (RANDOM, "scenes/cornell.gltf", []),
    "knot with stalls": (RANDOM, "build/scenes/knot.ply", ["--stall-seed", "1"]),
    "cornell with memory errors": (RANDOM, "scenes/cornell.gltf", ["--error-every", "40"]),
}


class TableError(Exception):
    """The table or a fault in it is of no use."""


@dataclass(frozen=True)
class Mutant:
    """One fault: `old` in `file` becomes `new`; `tests` are the unit tests that should find it."""

    name: str
    why: str
    file: str
    old: str
    new: str
    tests: tuple[str, ...]

    def apply(self, root: Path) -> None:
        """Change the file below `root`; the fault must fit exactly once."""
        path = root / self.file
        text = path.read_text()
        found = list(re.finditer(spaced(self.old), text))
        if len(found) != 1:
            raise TableError(
                f"{self.name}: `old` stands {len(found)} times in {self.file}, not once"
            )
        begin, end = found[0].span()
        path.write_text(text[:begin] + self.new.strip() + text[end:])


def spaced(text: str) -> str:
    """Pattern for `text` with any spaces and line breaks between its words and signs."""
    return r"\s*".join(re.escape(word) for word in re.findall(r"\w+|[^\w\s]", text))


def load(path: Path = TABLE) -> list[Mutant]:
    """The faults of a table in its order."""
    mutants = []
    for name, entry in yaml.safe_load(path.read_text()).items():
        try:
            mutant = Mutant(name=name, **{**entry, "tests": tuple(entry["tests"])})
        except (TypeError, KeyError) as error:
            raise TableError(f"{path}: {name}: {error}") from None
        mutants.append(mutant)
    return mutants


def copy(folder: Path) -> None:
    """A copy of the project in `folder` that builds its own RTL and shares the C++ programs."""
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "build").mkdir(parents=True)
    for name in COPIED:
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy2(source, folder / name)
    (folder / "sw").symlink_to(ROOT / "sw")
    (folder / "build/sw").symlink_to(ROOT / "build/sw")
    shutil.copy2(ROOT / "build/setup.stamp", folder / "build")


class Copy:
    """Commands in a copy of the project; their output goes to one log."""

    def __init__(self, folder: Path):
        self.folder = folder
        self.log = folder.with_suffix(".log")
        self.log.write_text("")
        self.environment = {
            **{
                k: v
                for k, v in os.environ.items()
                if k not in ("TEST", "UNIT", "WAVES", "MAKEFLAGS")
            },
            "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}",
            "CCACHE_DIR": os.environ.get("CCACHE_DIR", str(ROOT / "build/ccache")),
            "CCACHE_NOHASHDIR": "1",
            "PYTHONPYCACHEPREFIX": str(folder / "build/pycache"),
        }

    def run(self, *command) -> tuple[int | None, str]:
        """Status and output of a command; None when it did not end in time."""
        with subprocess.Popen(
            [str(word) for word in command],
            cwd=self.folder,
            env=self.environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            start_new_session=True,
        ) as process:
            try:
                output, _ = process.communicate(timeout=TIMEOUT_S)
                status = process.returncode
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)
                output, _ = process.communicate()
                status = None
        with self.log.open("a") as log:
            log.write(f"$ {' '.join(map(str, command))}\n{output}\nstatus {status}\n\n")
        return status, output

    def unit_test(self, name: str) -> list[str]:
        """What is red in a unit test file."""
        file = f"tb/unit/{name}.py"
        status, output = self.run(sys.executable, "-m", "pytest", "-x", file)
        if status == 0:
            return []
        if status is None:
            return [f"{name} (does not end)"]
        if status != 1 or "does not build" in output:
            raise TableError(f"{self.folder.name}: {file} does not run; see {self.log}")
        tests = re.findall(r"^(?:E +)?failed: (.*?) \(whole output", output, re.MULTILINE)
        return [f"{name} ({tests[0].split(', ')[0]})" if tests else name]

    def lock_step(self) -> list[str]:
        """Which runs of the engine are red."""
        old = [
            word for file in ("build/setup.stamp", "build/sw/libti_sw.a") for word in ("-o", file)
        ]
        status, _ = self.run("make", "engine", "CONFIG=tiny", "SET=", *old)
        if status != 0:
            raise TableError(f"{self.folder.name}: the engine does not build; see {self.log}")
        red = []
        for name, (rays, scene, options) in LOCK_STEP.items():
            command = ["build/tiny/ti", "trace", "--engine", "rtl", "--no-progress", "--rays", rays]
            command += ["--scene", ROOT / scene, "--config", "build/tiny/config/config.json"]
            status, _ = self.run(*command, "--out", "build/trace", *options)
            if status == 2:
                raise TableError(f"{self.folder.name}: ti does not run; see {self.log}")
            if status != 0:
                red.append(f"lock-step {name}{' (does not end)' if status is None else ''}")
        return red


def red_tests(name: str, tests: list[str], mutant: Mutant | None) -> list[str]:
    """Runs everything on a copy, changed or not; the red tests."""
    folder = WORK / name
    copy(folder)
    if mutant:
        mutant.apply(folder)
    here = Copy(folder)
    red = [line for test in tests for line in here.unit_test(test)]
    return red + here.lock_step()


def show(name: str, red: list[str], since: float) -> None:
    """One line a copy."""
    seconds = time.monotonic() - since
    print(
        f"{name:26} {'red: ' + ', '.join(red) if red else 'green'}  ({seconds:.0f} s)", flush=True
    )


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", default="", metavar="PART_OF_A_NAME")
    arguments = parser.parse_args()
    try:
        mutants = [m for m in load() if arguments.only in m.name]
        if not mutants:
            raise TableError(f"{arguments.only}: no fault of {TABLE} has this in its name")
        begin = time.monotonic()
        tests = list(dict.fromkeys(test for m in mutants for test in m.tests))
        red = red_tests("unchanged", tests, None)
        show("unchanged", red, begin)
        if red:
            raise TableError(f"the unchanged project is red; see {WORK / 'unchanged.log'}")
        shutil.rmtree(WORK / "unchanged")

        survivors = []
        for mutant in mutants:
            begin = time.monotonic()
            red = red_tests(mutant.name, mutant.tests, mutant)
            show(mutant.name, red, begin)
            if red:
                shutil.rmtree(WORK / mutant.name)
            else:
                survivors.append(mutant)
    except TableError as error:
        print(error, file=sys.stderr)
        return 2
    for mutant in survivors:
        print(f"not found: {mutant.name}, {mutant.why}; its copy is {WORK / mutant.name}")
    print(f"{len(mutants)} faults, {len(mutants) - len(survivors)} found")
    return 1 if survivors else 0


if __name__ == "__main__":
    sys.exit(main())
