#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Put each fault of `tb/mutants.yaml` into a copy of the project and see which tests find it.

For each fault the unit tests that it names run on the copy, then the engine in lock-step with the
model: three short runs of `tiny` and one of a shape with several units of each kind, up to the
first check that finds it; with --every-check the others too, but for the last run.  The unchanged
copy goes first: a test that is red there proves nothing and is left out.  The project itself is
only read.

With --quick only the faults marked `quick` are tried, and the last run is left out.

Exit status: 0 when every fault is found, 1 when one survives, 2 when something could not be tried:
the table is wrong, a test is red on the unchanged copy, or a fault does not build.

Usage: scripts/mutants.py [--only PART_OF_A_NAME] [--quick] [--every-check]
"""

import argparse
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import configure
import yaml

ROOT = Path(__file__).resolve().parents[1]
TABLE = ROOT / "tb/mutants.yaml"
WORK = ROOT / "build/mutants"
SNAPSHOT = WORK / "snapshot"
GENERATED = WORK / "generated"  # of scripts/mutation_score.py
NOT_COPIED = (".git", "__pycache__")
TIMEOUT_S = 900  # of one command; a fault may well never end

# What copies take from the project as it is, by links; and what `make` must not build again there.
LINKED = ("build/sw", "build/scenes")
SHARED = ("build/setup.stamp", "build/sw/libti_sw.a")

CORNELL, KNOT = "scenes/cornell.gltf", "build/scenes/knot.ply"
# Several units of each kind, unlike in number, so that a wire to the wrong one shows.
SEVERAL = "cores=2 core_tile=4 num_trv=3 num_list=2 num_ist1=3 deal_tile=4 rd_cycles=1"
# Runs of `ti trace` on the engine: overrides of `tiny`, scene, further options.
LOCK_STEP = {
    "lock-step cornell": ("", CORNELL, []),
    "lock-step knot, stalls": ("", KNOT, ["--stall-seed", "1"]),
    "lock-step cornell, memory errors": ("", CORNELL, ["--error-every", "40"]),
    "lock-step cornell, several units": (SEVERAL, CORNELL, []),
}
# Builds an engine of its own, so it runs only on a copy that all before it took for good, and not
# when little time is meant to pass.
LAST = "lock-step cornell, several units"


class TableError(Exception):
    """The table or a fault in it is wrong."""


class UselessError(Exception):
    """A check says nothing, as it does not build or run."""


@dataclass(frozen=True)
class Mutant:
    """One fault: `old` in `file` becomes `new`; `tests` are the unit tests that should find it.

    Those that are `quick` are also tried by `make test`.
    """

    name: str
    why: str
    file: str
    old: str
    new: str
    tests: tuple[str, ...]
    quick: bool = False

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


def copy_project(to: Path) -> None:
    """The project as it is now in the folder `to`, which builds its own RTL.

    What was built there stays, and files keep their times, so that it is built again only where
    they differ.
    """
    to.mkdir(parents=True, exist_ok=True)
    (to.parent / "FUSESOC_IGNORE").touch()  # a copy has a ti.core
    for old in to.iterdir():
        if old.name != "build":
            shutil.rmtree(old) if old.is_dir() and not old.is_symlink() else old.unlink()

    def left_out(folder: str, names: list[str]) -> set[str]:
        return {
            name for name in names if name in NOT_COPIED or Path(folder, name) == ROOT / "build"
        }

    shutil.copytree(ROOT, to, symlinks=True, ignore=left_out, dirs_exist_ok=True)
    (to / "build").mkdir(exist_ok=True)
    for name in LINKED:
        if not (to / name).is_symlink():
            (to / name).symlink_to(ROOT / name)
    shutil.copy2(ROOT / "build/setup.stamp", to / "build")


def take_snapshot() -> None:
    """The project as it is now, which all copies are made from."""
    WORK.mkdir(parents=True, exist_ok=True)
    for old in WORK.iterdir():
        if old != GENERATED:
            shutil.rmtree(old) if old.is_dir() else old.unlink()
    copy_project(SNAPSHOT)


def run_group(
    command: Sequence,
    folder: Path,
    environment: dict[str, str] | None = None,
    timeout: float = TIMEOUT_S,
    started: Callable[[subprocess.Popen], None] = lambda process: None,
) -> tuple[int | None, str]:
    """Status and output of a command; None when it did not end in time.

    All that it started ends with it, also when this is interrupted.
    """
    with subprocess.Popen(
        [str(word) for word in command],
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        start_new_session=True,
    ) as process:
        started(process)
        try:
            output, _ = process.communicate(timeout=timeout)
            return process.returncode, output
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            return None, process.communicate()[0]
        except BaseException:
            os.killpg(process.pid, signal.SIGKILL)
            raise


class Copy:
    """Commands in a copy of the project; their output goes to one log.

    Those of several processes in one copy keep their output apart by a `name`.
    """

    def __init__(self, folder: Path, name: str = ""):
        self.folder, self.name = folder, name
        self.log = folder.with_name(f"{folder.name}{name and '-'}{name}.log")
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
            "TI_RUN": f"{name and '-'}{name}",
        }
        self.process: subprocess.Popen | None = None
        self.failed = ""  # the test that was red last, as FILE::TEST

    def run(self, *command, timeout: float = TIMEOUT_S) -> tuple[int | None, str]:
        """Status and output of a command; None when it did not end in time."""
        status, output = run_group(command, self.folder, self.environment, timeout, self.started)
        with self.log.open("a") as log:
            log.write(f"$ {' '.join(map(str, command))}\n{output}\nstatus {status}\n\n")
        return status, output

    def started(self, process: subprocess.Popen) -> None:
        self.process = process

    def stop(self) -> None:
        """End the command that runs, from another thread."""
        if self.process and self.process.poll() is None:
            os.killpg(self.process.pid, signal.SIGKILL)

    def check(self, name: str, timeout: float = TIMEOUT_S) -> str:
        """What is red in a unit test file or a run of LOCK_STEP; empty when it is green."""
        if name in LOCK_STEP:
            return self.trace(name, self.engine(name), timeout)
        return self.unit_test(name, timeout)

    def collect(self, name: str) -> list[str]:
        """The tests of a unit test file, each as a name for `check`."""
        _, output = self.run(sys.executable, "-m", "pytest", "--collect-only", f"tb/unit/{name}.py")
        tests = re.findall(r"^tb/unit/\w+\.py(::.+)$", output, re.MULTILINE)
        return [f"{name}{test}" for test in tests]

    def unit_test(self, name: str, timeout: float) -> str:
        """The first failure of a unit test file, or of one test of it: FILE::TEST."""
        file, colons, test = name.partition("::")
        file = f"tb/unit/{file}.py{colons}{test}"
        status, output = self.run(sys.executable, "-m", "pytest", "-x", file, timeout=timeout)
        red = re.search(r"^FAILED tb/unit/(\w+)\.py(::.+?)(?: - |$)", output, re.MULTILINE)
        self.failed = "".join(red.groups()) if red else ""
        if status == 0:
            return ""
        if status is None:
            return f"{name} (does not end)"
        if status != 1 or "does not build" in output:
            raise UselessError(f"{name} does not build")
        tests = re.findall(r"^(?:E +)?failed: (.*?) \(whole output", output, re.MULTILINE)
        return f"{name} ({tests[0].split(', ')[0]})" if tests else name

    def engine(self, name: str) -> Path:
        """Build the engine of a run; the folder of its configuration."""
        ready = [word for file in SHARED for word in ("-o", file)]
        overrides = LOCK_STEP[name][0]
        status, _ = self.run("make", "engine", "CONFIG=tiny", f"SET={overrides}", *ready)
        if status != 0:
            raise UselessError("the engine does not build")
        return Path("build", configure.load("tiny", overrides.split()).folder)

    def trace(self, name: str, build: Path, timeout: float) -> str:
        """Whether the engine and the model differ in a run."""
        _, scene, options = LOCK_STEP[name]
        out = Path("build/trace", self.name)
        command = [ROOT / "build/sw/ti", "trace", "--engine", "rtl", "--no-progress", "--no-truth"]
        command += ["--rtl", build / "engine/libti_rtl.so"]
        command += ["--config", build / "config.json", "--scene", scene]
        command += ["--rays", "random:3000", "--out", out, *options]
        report = self.folder / out / "report.json"
        report.unlink(missing_ok=True)
        status, _ = self.run(*command, timeout=timeout)
        if status == 2:
            raise UselessError("ti does not run")
        if status == 0 or (status == 1 and only_memory_failed(report)):
            return ""
        return f"{name}{' (does not end)' if status is None else ''}"


def only_memory_failed(report: Path) -> bool:
    """Whether all rays of a run agree with the model or say that memory failed.

    `ti` ends with status 1 also when a ray only reports an error that memory was told to make.
    """
    if not report.is_file():
        return False
    check = json.loads(report.read_text())["check"]
    bad = ("model_mismatches", "work_differs", "lost", "duplicated")
    return check["status"]["memory_error"] > 0 and not any(check[key] for key in bad)


def try_out(
    name: str, checks: list[str], mutant: Mutant | None = None, every_check: bool = True
) -> dict[str, str]:
    """Run checks on a copy, with a fault or without: what each says that is not green.

    A check that did not build or run says so in a sentence that begins with `!`.  The first check
    that is red is the last, unless `every_check`.  LAST is left out where a fault has been found.
    """
    begin = time.monotonic()
    folder = WORK / name
    shutil.copytree(SNAPSHOT, folder, symlinks=True)
    if mutant:
        mutant.apply(folder)
    here = Copy(folder)
    said = {}
    for check in checks:
        if mutant and check == LAST and is_found(said):
            continue
        try:
            said[check] = here.check(check)
            if said[check] and not every_check:
                break
        except UselessError as error:
            said[check] = f"! {error}"
    said = {check: what for check, what in said.items() if what}
    what = "; ".join(said.values()) or "green"
    print(f"{name:26} {what}  ({time.monotonic() - begin:.0f} s)", flush=True)
    return said


def is_found(said: dict[str, str]) -> bool:
    """Whether a check was red, and not merely useless."""
    return any(what and not what.startswith("!") for what in said.values())


def run(mutants: list[Mutant], quick: bool, every_check: bool) -> int:
    """The exit status of all faults, each tried on its own."""
    take_snapshot()
    runs = [name for name in LOCK_STEP if not (quick and name == LAST)]
    checks = list(dict.fromkeys(test for m in mutants for test in m.tests)) + runs
    useless = try_out("unchanged", checks)
    sound = not useless
    shutil.rmtree(WORK / "unchanged")
    survivors = []
    for mutant in mutants:
        mine = [check for check in (*mutant.tests, *runs) if check not in useless]
        said = try_out(mutant.name, mine, mutant, every_check)
        sound = sound and not any(what.startswith("!") for what in said.values())
        if is_found(said):
            shutil.rmtree(WORK / mutant.name)
        else:
            survivors.append(mutant)
    for mutant in survivors:
        print(f"not found: {mutant.name}, {mutant.why}; its copy is {WORK / mutant.name}")
    print(f"{len(mutants)} faults, {len(mutants) - len(survivors)} found")
    for check in useless:
        print(f"{check} is red on the unchanged copy and was left out; see {WORK}/unchanged.log")
    return 1 if survivors else 0 if sound else 2


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", default="", metavar="PART_OF_A_NAME", help="a regular expression")
    parser.add_argument("--quick", action="store_true", help="only the faults marked `quick`")
    parser.add_argument("--every-check", action="store_true", help="go on when a fault is found")
    arguments = parser.parse_args()
    # Ends what was started too: `run` of a copy cleans up after any exception.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))
    try:
        mutants = [mutant for mutant in load() if re.search(arguments.only, mutant.name)]
        if arguments.quick:
            mutants = [mutant for mutant in mutants if mutant.quick]
        if not mutants:
            raise TableError(f"{arguments.only}: no such fault in {TABLE}")
        return run(mutants, arguments.quick, arguments.every_check)
    except TableError as error:
        print(error, file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
