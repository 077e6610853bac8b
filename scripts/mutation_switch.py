# SPDX-License-Identifier: Apache-2.0
"""Many mutations in one copy of the RTL, each switched on by a number when a simulation begins.

The number is TI_MUTANT of the environment; with 0, or none, the copy does what the RTL does.  So it
is built once for all its mutations (mutant schemata: R. H. Untch, A. J. Offutt, M. J. Harrold,
"Mutation analysis using mutant schemata", ISSTA 1993).
"""

import hashlib
import json
import os
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import configure
from mutants import run_group
from mutations import Mutation

# Read before anything is evaluated, as the initial value of a variable is.
PACKAGE = "rtl/ti_mutant_pkg.sv"
PACKAGE_TEXT = """\
// SPDX-License-Identifier: Apache-2.0
package ti_mutant_pkg;
  int id = $c32("(std::getenv(\\"TI_MUTANT\\") ? std::atoi(std::getenv(\\"TI_MUTANT\\")) : 0)");
endpackage
"""
# Configurations that have every module between them, as small as that allows.
SHAPES = (
    "tiny",
    "tiny triangle_test=woop traversal=padded",
    "tiny cores=2 stream_clock=own line_bytes=32 ring_delays=0 counters=0 sync_reset=0 "
    "early_exit=0 any_hit=0 ray_accumulation=retry stack_depth=0 lookup_stages=5 fill_bytes=16",
    "tiny triangle_test=np rd_cycles=3",
    "tiny stack_depth=6 restart=0 watchdog_steps=100 reciprocal=newton",
)
MOST_ROUNDS = 40
# At the end of a list of waivers: no warning matters in a copy with mutations.
ANY_WARNING = "lint_off\n"


class BuildProblem(Exception):
    """One sentence: the copy does not build for a reason that no mutation is."""


@dataclass(frozen=True)
class Span:
    """Part of a switched text that is there because of mutation `number`."""

    number: int
    begin: int
    end: int


def switched(text: str, mutations: Iterable[tuple[int, Mutation]]) -> tuple[str, list[Span]]:
    """The text of a file with numbered mutations in it, and where what is of whom."""
    places: dict[tuple[int, int, bool], list[tuple[int, Mutation]]] = {}
    for number, mutation in mutations:
        key = (mutation.start, -mutation.end, mutation.value is not None)
        places.setdefault(key, []).append((number, mutation))
    ordered = [places[key] for key in sorted(places)]
    out: list[str] = []
    spans: list[Span] = []
    length = 0

    def put(words: str) -> int:
        """Write; where it begins."""
        nonlocal length
        out.append(words)
        length += len(words)
        return length - len(words)

    def render(begin: int, end: int, at: int) -> int:
        """Write text[begin:end], whose places begin at number `at`; the number after them."""
        while at < len(ordered) and ordered[at][0][1].start < end:
            here = ordered[at]
            first = here[0][1]
            put(text[begin : first.start])
            if first.value is None:
                opened = put(f"begin if (ti_mutant_pkg::id != 32'd{here[0][0]}) ")
            else:
                opened = put(first.before + "(")
                for number, mutation in here:
                    put(f"(ti_mutant_pkg::id == 32'd{number}) ? (")
                    mine = put(mutation.switched)
                    spans.append(Span(number, mine, length))
                    put(") : ")
                put("(")
            if first.before:  # `.name` of a port
                put(first.before[1:-1])
                at += 1
            else:
                at = render(first.start, first.end, at + 1)
            put(" end" if first.value is None else "))" + first.after)
            spans.extend(Span(number, opened, length) for number, _ in here)
            begin = first.end
        put(text[begin:end])
        return at

    render(0, len(text), 0)
    return "".join(out), spans


def write(
    root: Path, to: Path, files: list[str], mutations: dict[int, Mutation]
) -> dict[str, list[Span]]:
    """Copy `files` to the folder `to`, with mutations; they keep their times, so that what has been
    built of the same copy stays good."""
    spans = {}
    for file in files:
        mine = [(number, m) for number, m in mutations.items() if m.file == file]
        text, spans[file] = switched((root / file).read_text(), mine)
        put(to / file, text, root / file)
    lines = (root / "rtl/ti.f").read_text()
    put(
        to / "rtl/ti.f",
        re.sub("^rtl/", f"{PACKAGE}\nrtl/", lines, count=1, flags=re.M),
        root / "rtl/ti.f",
    )
    put(to / PACKAGE, PACKAGE_TEXT, root / "rtl/ti.f")
    return spans


def put(file: Path, text: str, source: Path) -> None:
    """Write a file whose time is that of its source."""
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text)
    time = source.stat()
    os.utime(file, ns=(time.st_atime_ns, time.st_mtime_ns))


def verilate(
    root: Path, folder: Path, shape: str, options: Iterable[str] = (), replaced: dict | None = None
) -> tuple[int | None, str]:
    """Status and words of Verilator on the whole design in a shape, as scripts/lint.sh has it.

    Files are those of `root`, but for the `replaced`: name there, and what is read.
    """
    name, *overrides = shape.split()
    config = folder / configure.folder_name(shape)
    if not config.is_dir():
        configure.configure(name, overrides, config)
    command = ["verilator", "--lint-only", "-Wall", "--quiet-stats", *options, f"-I{config}"]
    command += [
        root / "lint/verilator.vlt",
        config / "ti_config_pkg.sv",
        config / "ti_count_pkg.sv",
    ]
    for word in (root / "rtl/ti.f").read_text().split():
        include = word.startswith("+incdir+")
        command.append(
            f"-I{root / word.removeprefix('+incdir+')}"
            if include
            else (replaced or {}).get(word, root / word)
        )
    command += ["--top-module", "ti_top"]
    return run_group(command, root)


def compilable(
    root: Path, folder: Path, files: list[str], mutations: list[Mutation]
) -> list[tuple[int, Mutation]]:
    """The mutations that Verilator takes, with their numbers from 1, in order.

    All are put into one copy, and those that an error names are taken out until none is left.
    Which ones, is kept in `folder` for the same RTL.
    """
    numbered = dict(enumerate(mutations, 1))
    known = folder / f"bad-{digest([root / file for file in files], list(numbered.values()))}.json"
    if known.is_file():
        bad = set(json.loads(known.read_text()))
        return [(n, m) for n, m in numbered.items() if n not in bad]
    copy = folder / "all"
    left = dict(numbered)
    for shape in SHAPES:
        for _ in range(MOST_ROUNDS):
            spans = write(root, copy, files, left)
            (copy / "lint").mkdir(exist_ok=True)
            (copy / "lint/verilator.vlt").write_text(
                (root / "lint/verilator.vlt").read_text() + ANY_WARNING
            )
            headers = ["--error-limit", "100000", f"-I{root}/rtl/common"]
            status, said = verilate(copy, folder, shape, headers)
            if status == 0:
                break
            blamed = blame(said, copy, spans)
            if not blamed:
                raise BuildProblem(f"a copy with all mutations does not build: {said[:2000]}")
            left = {n: m for n, m in left.items() if n not in blamed}
        else:
            raise BuildProblem(f"{shape}: errors after {MOST_ROUNDS} rounds")
    known.write_text(json.dumps(sorted(numbered.keys() - left.keys())))
    return list(left.items())


def digest(files: Iterable[Path], mutations: list[Mutation]) -> str:
    text = "".join(file.read_text() for file in files) + repr(mutations) + "".join(SHAPES)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def blame(errors: str, copy: Path, spans: dict[str, list[Span]]) -> set[int]:
    """The mutations that errors of Verilator point at: the smallest that a place is of."""
    found = set()
    for path, line, column in re.findall(r"^%Error[^:]*: ([^:\s]+):(\d+):(\d+):", errors, re.M):
        file = os.path.relpath(path, copy)
        if file not in spans:
            continue
        lines = (copy / file).read_text().splitlines(keepends=True)
        at = sum(map(len, lines[: int(line) - 1])) + int(column) - 1
        around = [span for span in spans[file] if span.begin <= at < span.end]
        if around:
            least = min(span.end - span.begin for span in around)
            found |= {span.number for span in around if span.end - span.begin == least}
            continue
        # The name of a port stands before what is connected.
        rest = len(lines[int(line) - 1]) - int(column)
        behind = [span for span in spans[file] if at <= span.begin <= at + rest]
        first = min((span.begin for span in behind), default=None)
        found |= {span.number for span in behind if span.begin == first}
    return found
