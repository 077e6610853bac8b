#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Score of the tests: how many of the mutations that are drawn from the RTL they find.

All mutations of the RTL are found (scripts/mutations.py), those that Verilator does not take are
left out, and a number of the others are drawn by the seed.  They go into one copy of the project,
each behind a number (scripts/mutation_switch.py), so that one build serves all.  For each, up to
the first that finds it:

1. *lint*: the mutation alone, written into its file, before `verilator -Wall`;
2. *unit*: the unit tests of its module, or of the nearest module above that has some;
3. *lock-step*: the runs of scripts/mutants.py, where the engine has the module;
4. *above*: other unit tests, which tb/mutants.yaml names for its file.

What runs five times as long as without the mutation has been found too.  Results are kept as they
come, in build/mutants/generated; a second call goes on where the first stopped, and tries again
what survived if tests have changed.  tb/survivors.yaml says of survivors why no test finds them.

Exit status: 0 when all are found or explained there, 1 when one is neither, 2 when something could
not be tried.

Usage: scripts/mutation_score.py --count N [--seed N] [--unit MODULE] [--json FILE] [--jobs N]
"""

import argparse
import concurrent.futures
import json
import os
import queue
import shutil
import signal
import sys
import threading
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import configure
import mutants
import mutation_switch as switch
import mutation_table
import rtl_syntax
from mutants import LOCK_STEP, ROOT, Copy, UselessError
from mutation_design import Design, Tests
from mutations import Mutation

PATIENCE, LEAST_S = 5, 30  # times the time without a mutation; at least


class ScoreError(Exception):
    """One sentence: what could not be tried."""


@dataclass(frozen=True)
class Outcome:
    """What came of one mutation: `by` is the stage that found it, or empty; `says` what was red."""

    number: int
    by: str
    says: str
    seconds: float
    rtl: str
    tests: str


class Score:
    """A sample of mutations, tried one after the other or several at once."""

    def __init__(self, design: Design, sample: dict[int, Mutation], folder: Path, jobs: int):
        self.design, self.sample, self.folder, self.jobs = design, sample, folder, jobs
        self.tests = Tests()
        self.project = folder / "project"
        self.times = folder / f"seconds-{design.digest}.json"
        # Seconds of each check without a mutation, once it is built; by its name and digest.
        self.green: dict[str, float] = read_times(self.times)
        self.useless: dict[str, str] = {}  # what is red in a check without one
        self.firsts: dict[str, list[str]] = {}
        self.locks: dict[str, threading.Lock] = {}
        self.lock = threading.Lock()
        self.copies: list[Copy] = []
        self.stopped = False
        self.results = folder.parent / "results.jsonl"  # of all samples
        self.outcomes = self.known()

    def known(self) -> dict[int, Outcome]:
        """Results of earlier calls that still hold."""
        lines = self.results.read_text().splitlines() if self.results.is_file() else []
        outcomes = {}
        for line in lines:
            outcome = Outcome(**json.loads(line))
            same = outcome.rtl == self.design.digest and outcome.number in self.sample
            if same and (outcome.by or outcome.tests == self.tests_of(outcome.number)):
                outcomes[outcome.number] = outcome
        return outcomes

    def tests_of(self, number: int) -> str:
        checks = self.design.checks(self.sample[number])
        return self.tests.digest(check for check, _ in checks)

    def prepare(self) -> None:
        """The copy of the project with the sample in it."""
        mutants.copy_project(self.project)
        switch.write(ROOT, self.project, self.design.files, self.sample)
        waivers = "lint/verilator.vlt"
        text = (ROOT / waivers).read_text() + switch.ANY_WARNING
        switch.put(self.project / waivers, text, ROOT / waivers)

    def run(self) -> None:
        """Try what has not been tried."""
        left = [number for number in self.sample if number not in self.outcomes]
        if left:
            self.prepare()
        names: queue.SimpleQueue[str] = queue.SimpleQueue()
        for job in range(self.jobs):
            names.put(f"job{job}")
        with concurrent.futures.ThreadPoolExecutor(self.jobs) as pool:
            tries = [pool.submit(self.try_one, number, names) for number in left]
            try:
                for done in concurrent.futures.as_completed(tries):
                    self.keep(done.result())
            finally:
                self.stopped = True
                for waiting in tries:
                    waiting.cancel()
                for copy in self.copies:
                    copy.stop()

    def keep(self, outcome: Outcome) -> None:
        self.outcomes[outcome.number] = outcome
        with self.results.open("a") as file:
            file.write(json.dumps(asdict(outcome)) + "\n")
        m = self.sample[outcome.number]
        what = f"{outcome.by}: {outcome.says}" if outcome.by else "SURVIVES"
        place = f"{m.file}:{m.line}"
        change = f"{' '.join(m.old.split())} -> {' '.join(m.new.split())}"
        progress = f"{len(self.outcomes)}/{len(self.sample)}"
        print(
            f"{progress:9}{outcome.number:5} {place:44} {m.kind:10} {change[:60]:60} "
            f"{what[:70]}  ({outcome.seconds:.0f} s)",
            flush=True,
        )

    def try_one(self, number: int, names: queue.SimpleQueue) -> Outcome:
        name = names.get()
        try:
            begin = time.monotonic()
            by, says = self.stages(number, name)
            seconds = round(time.monotonic() - begin, 1)
            complete = by or not says
            tests = self.tests_of(number) if complete else ""
            return Outcome(number, by, says, seconds, self.design.digest, tests)
        finally:
            names.put(name)

    def stages(self, number: int, name: str) -> tuple[str, str]:
        """Which stage finds a mutation, and what it says; empty when none does."""
        mutation = self.sample[number]
        if says := self.lint(mutation, name):
            return "lint", says
        here = self.copy(name, number)
        useless: set[str] = set()
        for check, stage in self.design.checks(mutation):
            # Most are found by the first shape, so that the others are built only for the rest.
            for part in [*self.first_of(check, name), check]:
                try:
                    says = self.red(here, part, name, useless)
                except UselessError as error:
                    if stage != "lock-step":
                        raise ScoreError(f"mutation {number}: {error}; see {here.log}") from None
                    says = f"{part} ({error})"
                if says:
                    return stage, says
        return "", f"{', '.join(sorted(useless))} left out" if useless else ""

    def red(self, here: Copy, check: str, name: str, useless: set[str]) -> str:
        """What is red in a check with a mutation, and not without it, as it is in the `useless`."""
        suspect = check
        if self.firsts.get(check):  # shapes of a file up to the first that is red, which is judged
            says = here.unit_test(check, mutants.TIMEOUT_S)
            suspect = here.failed or check
            if says and suspect != check:
                self.without(suspect, name)
            elif says:  # did not end, but with what was built meanwhile
                says = self.in_time(here, check, name)
        else:
            says = self.in_time(here, check, name)
        if self.stopped:
            raise ScoreError("stopped")
        if suspect in self.useless:
            useless.add(suspect)
            return ""
        return says

    def in_time(self, here: Copy, check: str, name: str) -> str:
        """What is red in a check, which may take some times as long as without a mutation."""
        seconds = self.without(check, name)
        if check in self.useless:
            return ""
        return self.check(here, check, max(LEAST_S, PATIENCE * seconds))

    def first_of(self, check: str, name: str) -> list[str]:
        """The first test of a file that has several, where a check is one."""
        if check in LOCK_STEP:
            return []
        with self.lock:
            if check not in self.firsts:
                self.firsts[check] = self.copy(f"unchanged-{name}", 0).collect(check)[:-1][:1]
        return self.firsts[check]

    def copy(self, name: str, number: int) -> Copy:
        """Commands in the copy of the project with a mutation on."""
        here = Copy(self.project, name)
        here.environment["TI_MUTANT"] = str(number)
        self.copies.append(here)
        return here

    def check(self, here: Copy, check: str, timeout: float) -> str:
        """What is red in a check whose engine or simulation has been built."""
        if check in LOCK_STEP:
            return here.trace(check, engine_folder(check), timeout)
        return here.unit_test(check, timeout)

    def without(self, check: str, name: str) -> float:
        """Seconds of a check without a mutation; what it needs is built first."""
        with self.lock:
            mine = self.locks.setdefault(check.partition("::")[0], threading.Lock())
        key = f"{check} {self.tests.digest([check])}"
        with mine:
            if key not in self.green:
                here = self.copy(f"unchanged-{name}", 0)
                begin = time.monotonic()
                try:
                    says = here.check(check)
                    if not says:
                        begin = time.monotonic()
                        says = self.check(here, check, mutants.TIMEOUT_S)
                except UselessError as error:
                    says = str(error)
                self.green[key] = time.monotonic() - begin
                if says:
                    self.useless[check] = says
                    print(f"{check} is red without a mutation: {says}; see {here.log}", flush=True)
                else:
                    print(f"{check}: {self.green[key]:.1f} s without a mutation", flush=True)
                    good = {
                        k: s
                        for k, s in self.green.items()
                        if k.rpartition(" ")[0] not in self.useless
                    }
                    self.times.write_text(json.dumps(good, indent=1))
        return self.green[key]

    def lint(self, mutation: Mutation, name: str) -> str:
        """The first complaint of Verilator of the mutation as it would be written."""
        shape = self.design.shape_of(mutation.module)
        file = self.folder / f"lint-{name}" / Path(mutation.file).name
        file.parent.mkdir(exist_ok=True)
        file.write_text(mutation.apply((ROOT / mutation.file).read_text()))
        _, said = switch.verilate(ROOT, self.design.folder, shape, replaced={mutation.file: file})
        shutil.rmtree(file.parent)
        first = said.partition("\n")[0]
        return first.replace(f"{file.parent}/", "")


def read_times(file: Path) -> dict[str, float]:
    return json.loads(file.read_text()) if file.is_file() else {}


def engine_folder(check: str) -> Path:
    return Path("build", configure.load("tiny", LOCK_STEP[check][0].split()).folder)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, required=True, help="mutations to draw")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--unit", default="", metavar="MODULE", help="of this module alone")
    parser.add_argument("--json", type=Path, metavar="FILE", help="the table and all results")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="mutations at once")
    arguments = parser.parse_args()
    # Ends what was started too: `run` of a copy cleans up after any exception.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))
    try:
        if arguments.count < 1 or arguments.jobs < 1:
            raise ScoreError("--count and --jobs must be 1 or more")
        mutants.GENERATED.mkdir(parents=True, exist_ok=True)
        design = Design(mutants.GENERATED)
        sample = design.draw(arguments.count, arguments.seed, arguments.unit)
        if not sample:
            raise ScoreError(f"{arguments.unit}: no module of rtl/ti.f that has a mutation")
        words = [f"seed-{arguments.seed}", str(arguments.count), arguments.unit]
        folder = mutants.GENERATED / "-".join(word for word in words if word)
        folder.mkdir(exist_ok=True)
        print(
            f"{design.all} mutations, {design.all - len(design.numbered)} of which do not compile; "
            f"{len(sample)} drawn with seed {arguments.seed}",
            flush=True,
        )
        score = Score(design, sample, folder, arguments.jobs)
        score.run()
        status = mutation_table.report(design, sample, score.outcomes, arguments.json)
        for check, says in score.useless.items():
            print(f"{check} is red without a mutation and was left out: {says}")
        return 2 if score.useless else status
    except (
        ScoreError,
        mutants.TableError,
        rtl_syntax.SyntaxProblem,
        switch.BuildProblem,
        mutation_table.ExplanationError,
    ) as error:
        print(error, file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
