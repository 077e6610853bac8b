#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Prove the error bounds that the machine leans on, by Gappa.

A certificate is a template in sw/certificates, in the language of Gappa; here it gets the numbers
of a format, a rounding and a reciprocal.  The bound that the code uses is read from the code, by
the module `ti_model` (tb/models/bind_bounds.cpp).  Of an error Gappa finds a bound, which must not
be more; of a guard, in units in the last place or as a factor, it must prove the code's, and the
least whole number down from there that it proves stands beside it.  docs/certificates.md says what
each stands for.

All bounds in the table are in u = 2^-(M+1) of what the quantity is relative to, or in what its
row says.  OUT gets table.md, and each script as Gappa read it: `gappa OUT/NAME.g` runs it again.

Exit status: 0 when all are proved, 1 when one is not, 2 for bad input or where gappa is missing.

Usage: scripts/certify.py [--formats "8,23 7,16"] [--only PART_OF_A_NAME] --out FOLDER
"""

import argparse
import math
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache
from pathlib import Path

import configure
from bound_cases import NEWTON, ROUNDINGS, Case, dyadic, power

TEMPLATES = Path(__file__).resolve().parents[1] / "sw/certificates"
FORMATS = "5,10 8,13 7,16 8,20 8,23"


class CertifyError(Exception):
    """One sentence for the user."""


@dataclass(frozen=True, eq=False)
class Quantity:
    """What is certified: `used` is the code's bound, in units of `unit`; a guard is a whole number.

    `inverse`: whether there is a reciprocal in it.  `needs` are bounds of other quantities, or of
    the code, that its template takes, by NAME.
    """

    name: str
    template: str
    used: Callable[[Case], Fraction]
    unit: Callable[[Case], Fraction] = field(default=lambda case: case.u)
    label: str = "u"
    guard: bool = False
    needs: dict[str, Callable[[Case], Fraction]] = field(default_factory=dict)
    inverse: bool = True
    holds: Callable[[Case], bool] = field(default=lambda case: True)


@dataclass(frozen=True)
class Result:
    """`proven` is the least bound that was proved, in the unit of the quantity; None: none was."""

    quantity: Quantity
    case: Case
    used: Fraction
    proven: Fraction | None

    @property
    def good(self) -> bool:
        return self.proven is not None and self.proven <= self.used


def code(name: str) -> Callable[[Case], Fraction]:
    """A bound of the code as it stands there."""
    return lambda case: case.used(name)


def in_u(name: str) -> Callable[[Case], Fraction]:
    """A bound of the code that stands there as a number."""
    return lambda case: case.used(name) / case.u


def in_operations(name: str) -> Callable[[Case], Fraction]:
    """A bound of the code that stands there in units of the error of an operation."""
    return lambda case: case.used(name) * case.used("rounding_unit") / case.u


def share(operations: int, reciprocals: int) -> Callable[[Case], Fraction]:
    """Of the thickness of a ray: so many of 17 operations and 4 reciprocals (sw/model/rd.hpp)."""

    def used(case: Case) -> Fraction:
        a = case.used("rounding_unit") / case.u
        h = case.used("half_ulps")
        return case.used("thickness") * (operations * a + reciprocals * h) / (17 * a + 4 * h)

    return used


def proven(name: str) -> Callable[[Case], Fraction]:
    """What is proven of another quantity, as a number."""

    def value(case: Case) -> Fraction:
        quantity = NAMED[name]
        result = certify(quantity, case)
        if result.proven is None:
            raise CertifyError(f"{name}: Gappa proves no bound for {case.name(quantity.inverse)}")
        return result.proven * quantity.unit(case)

    return value


def thickness(case: Case) -> Fraction:
    """What the thickness of a ray must cover, as a number: errors of test and walk, of A.

    A is rounded too, and to a plane it is as far as A and the thickness.
    """
    places = proven("corner")(case) + proven("way")(case) + proven("weights")(case)
    plane = proven("plane")(case) * (1 + case.used("thickness") * case.u)
    return (places + plane) * (1 + 2 * case.used("rounding_unit"))


def seed_error(case: Case) -> Fraction:
    """The largest relative error of a seed, of all intervals: at their ends."""
    k = NEWTON["rcp_table_bits"]
    worst = Fraction(0)
    for index in range(1 << k):
        middle = Fraction(2 * ((1 << k) + index) + 1, 1 << (k + 1))
        seed = Fraction(int((1 << (k + 1)) / middle + Fraction(1, 2)), 1 << (k + 1))
        for end in (index, index + 1):
            worst = max(worst, abs(seed * (1 + Fraction(end, 1 << k)) - 1))
    return worst


def interval_guard(case: Case) -> Fraction:
    return Fraction(configure.outward_ulps(case.config))


ULPS = {"label": "ulp", "guard": True}
QUANTITIES = (
    Quantity("operation", "operation", in_u("rounding_unit"), inverse=False),
    Quantity(
        "operation, subnormal",
        "underflow",
        lambda case: case.used("underflow_unit") / power(case.least_normal) / case.u,
        lambda case: power(case.least_normal) * case.u,
        "u x least normal",
        inverse=False,
    ),
    Quantity("sum, subnormal", "exact_sum", lambda case: Fraction(0), inverse=False),
    Quantity(
        "reciprocal", "reciprocal", in_u("reciprocal_unit"), holds=lambda case: not case.newton
    ),
    Quantity(
        "seed of a reciprocal",
        "",
        lambda case: Fraction(3, 4),
        lambda case: power(-NEWTON["rcp_table_bits"]),
        "2^-k",
        holds=lambda case: case.newton,
    ),
    Quantity(
        "reciprocal by Newton steps",
        "newton",
        code("half_ulps"),
        lambda case: case.u / 2,
        "half ulp",
        holds=lambda case: case.newton,
    ),
    Quantity("corner", "corner", share(6, 1), label="u A"),
    Quantity("way", "plane", share(2, 1), label="u A"),
    Quantity("weights", "weights", share(7, 1), label="u A"),
    Quantity("plane", "plane", share(2, 1), label="u A"),
    Quantity("thickness", "", code("thickness"), label="u A"),
    Quantity("interval of a ray", "outward", code("outward_ulps"), **ULPS),
    Quantity("interval_guard", "outward", interval_guard, **ULPS),
    Quantity("cull, far", "cull_far", code("cull_ulps"), **ULPS),
    Quantity("cull, near", "cull_near", code("cull_ulps"), **ULPS),
    Quantity("static det", "det", in_operations("static_det"), label="u D", inverse=False),
    Quantity("static dett", "dett", in_operations("static_dett"), label="u A", inverse=False),
    Quantity(
        "static dett of np", "dett_np", in_operations("static_dett"), label="u A", inverse=False
    ),
    Quantity(
        "static detu",
        "inside",
        in_operations("static_inside"),
        label="u S A D",
        needs={"DET": proven("static det"), "DETT": proven("static dett")},
        inverse=False,
    ),
    Quantity(
        "static sum",
        "sum",
        in_operations("static_sum"),
        label="u S A D",
        needs={"INSIDE": proven("static detu")},
        inverse=False,
    ),
    Quantity("static sum, det", "det", in_operations("static_sum_det"), label="u D", inverse=False),
    Quantity("static corner", "corner", in_operations("static_corner"), label="u A"),
    Quantity(
        "static weight",
        "weight",
        code("static_weight"),
        label="factor",
        guard=True,
        needs={"CORNER": lambda case: case.used("static_corner") * case.used("rounding_unit")},
    ),
    Quantity(
        "stand-off, test",
        "stand_off",
        in_operations("stand_off_test"),
        label="u N L",
        inverse=False,
    ),
    Quantity("stand-off, point", "point", lambda case: gamma(case) / case.u, inverse=False),
)
NAMED = {quantity.name: quantity for quantity in QUANTITIES}
SUMS = {"thickness": thickness, "seed of a reciprocal": seed_error}


def gamma(case: Case) -> Fraction:
    """gamma_n of the interpolated point."""
    part = case.used("stand_off_point") * case.used("rounding_unit")
    return part / (1 - part)


def script(quantity: Quantity, case: Case, units: int | None = None) -> str:
    """The template with all its numbers: of a guard that many units, the code's when left out."""
    k = int(quantity.used(case)) if units is None else units
    values = case.numbers() | {"GOAL": "?", "K": str(k), "G": dyadic((k + 1) * 2 * case.u)}
    for name, value in quantity.needs.items():
        values[name] = dyadic(short(value(case)))
    text = (TEMPLATES / f"{quantity.template}.g.in").read_text()
    return re.sub(r"@(\w+)@", lambda name: values[name[1]], text)


def short(value: Fraction) -> Fraction:
    """A number that is not less, of at most 80 places."""
    return Fraction(math.ceil(value * (1 << 80)), 1 << 80)


@cache
def gappa(text: str) -> tuple[bool, str]:
    """Whether Gappa proves a script, and what it says.  A hint that it cannot check is an error."""
    done = subprocess.run(
        ["gappa", "-Eprecision=100", "-Eno-auto-dichotomy"],
        input=text,
        capture_output=True,
        text=True,
        check=False,
    )
    said = done.stdout + done.stderr
    if "syntax error" in said or "Warning" in said:
        raise CertifyError(f"gappa: {said.strip()}\n{text}")
    return done.returncode == 0, said


def found(said: str) -> Fraction:
    """The largest size in the interval that Gappa gives for `?`."""
    inside = re.search(r" in \[([^ ,]+)(?: \{.*?\})?, ([^ \]]+)", said)
    if not inside:
        raise CertifyError(f"gappa says no interval: {said.strip()}")
    ends = []
    for end in inside.groups():
        digits, _, exponent = end.partition("b")
        ends.append(abs(int(digits) * power(int(exponent or 0))))
    return max(ends)


@cache
def certify(quantity: Quantity, case: Case) -> Result:
    """The least bound that is proved, beside the code's."""
    used = quantity.used(case)
    if quantity.name in SUMS:
        return Result(quantity, case, used, SUMS[quantity.name](case) / quantity.unit(case))
    if not quantity.guard:
        good, said = gappa(script(quantity, case))
        return Result(quantity, case, used, found(said) / quantity.unit(case) if good else None)
    least = None
    for units in range(int(used), -1, -1):
        if not gappa(script(quantity, case, units))[0]:
            break
        least = Fraction(units)
    return Result(quantity, case, used, least)


def rows(formats: list[tuple[int, int]], only: str) -> list[Result]:
    """All quantities whose name has `only`, of all formats, roundings and reciprocals."""
    chosen = [quantity for quantity in QUANTITIES if only in quantity.name]
    if not chosen:
        raise CertifyError(f"--only {only}: no such quantity; there are {', '.join(NAMED)}")
    cases = [
        Case(e, m, rounding, reciprocal)
        for e, m in formats
        for rounding in ROUNDINGS
        for reciprocal in ("division", "newton")
        if reciprocal == "division" or m >= NEWTON["rcp_table_bits"]
    ]
    work = [
        (q, case)
        for q in chosen
        for case in cases
        if q.holds(case) and (q.inverse or not case.newton)
    ]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(lambda pair: certify(*pair), work))


def table(results: list[Result]) -> str:
    """Markdown, a row a result."""
    lines = [
        "| quantity | format, rounding, reciprocal | in | used | proved | margin | |",
        "|---|---|---|---:|---:|---:|---|",
    ]
    for r in results:
        numbers = [f"{float(r.used):.5g}"]
        numbers += (
            ["none", ""]
            if r.proven is None
            else [f"{float(r.proven):.5g}", f"{float(r.used - r.proven):.2g}"]
        )
        what = [r.quantity.name, r.case.name(r.quantity.inverse), r.quantity.label, *numbers]
        lines.append(f"| {' | '.join(what)} | {'' if r.good else 'NOT PROVED'} |")
    return "\n".join(lines) + "\n"


def write(out: Path, results: list[Result]) -> None:
    """The table, and the scripts, named after their templates and cases."""
    out.mkdir(parents=True, exist_ok=True)
    (out / "table.md").write_text(table(results))
    for r in results:
        if r.quantity.template:
            name = f"{r.quantity.name} {r.case.name(r.quantity.inverse)}"
            file = re.sub(r"\W+", "-", name).strip("-")
            (out / f"{file}.g").write_text(script(r.quantity, r.case))


def formats_of(text: str) -> list[tuple[int, int]]:
    """Pairs of E and M, of words "E,M"."""
    pairs = []
    for word in text.split():
        found = re.fullmatch(r"([3-8]),(\d+)", word)
        if not found or not 2 <= int(found[2]) <= 23:
            raise CertifyError(
                f"FORMATS={word}: not E,M with E from 3 to 8 and M from 2 to 23, as in 8,23"
            )
        pairs.append((int(found[1]), int(found[2])))
    if not pairs:
        raise CertifyError("FORMATS=: none is named; write them as in '8,23 7,16'")
    return pairs


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--formats", default=FORMATS)
    parser.add_argument("--only", default="")
    parser.add_argument("--out", type=Path, required=True)
    args = parser.parse_args()
    if shutil.which("gappa") is None:
        raise CertifyError("gappa is not installed; `make setup` installs it")
    results = rows(formats_of(args.formats), args.only)
    write(args.out, results)
    print(table(results), end="")
    wrong = [r for r in results if not r.good]
    print(f"{len(results)} bounds, {len(results) - len(wrong)} proved; {args.out}/table.md")
    return 1 if wrong else 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (CertifyError, OSError) as error:
        print(f"certify: {error}", file=sys.stderr)
        sys.exit(2)
