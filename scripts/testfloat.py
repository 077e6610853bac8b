#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Replay a file of Berkeley TestFloat lines through an RTL operator and its model.

    scripts/testfloat.py --op add --format 8,23 --file add.txt

Builds the bench of the format in build/fp_rtl/ when needed.  Exit status 0: all values agree;
1: some differ; 2: bad input, told in one sentence.
"""

import argparse
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
OPS = ("add", "sub", "mul", "rcp", "lt", "le", "eq")
ALIASES = ("lt_quiet", "le_quiet", "eq_signaling")


class BadInputError(Exception):
    """One sentence for the user."""


def parse_format(text):
    """(E, M) of "E,M"."""
    match = re.fullmatch(r"\(?(\d{1,2}),\s*(\d{1,2})\)?", text)
    if not match:
        raise BadInputError(f"FORMAT '{text}' is not E,M, for example FORMAT=8,23.")
    exp_bits, frac_bits = map(int, match.groups())
    if not (3 <= exp_bits <= 8 and 2 <= frac_bits <= 23):
        raise BadInputError(f"FORMAT {text} is outside 3 <= E <= 8, 2 <= M <= 23.")
    return exp_bits, frac_bits


def build(exp_bits, frac_bits):
    """Path of the bench's program, built or brought up to date."""
    out = ROOT / "build" / "fp_rtl" / f"{exp_bits}_{frac_bits}"
    out.mkdir(parents=True, exist_ok=True)
    log = out / "build.log"
    command = [ROOT / "scripts/build_fp_rtl.sh", str(exp_bits), str(frac_bits), out]
    with log.open("w") as stream:
        failed = subprocess.run(command, stdout=stream, stderr=stream, check=False).returncode
    if failed:
        raise BadInputError(f"The RTL bench does not build; see {log}.")
    return out / "fp_rtl"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--op", required=True, help=", ".join(OPS))
    parser.add_argument("--format", required=True, help="E,M: exponent bits, fraction bits")
    parser.add_argument("--file", required=True, help="lines A B RESULT FLAGS in hex")
    args = parser.parse_args()
    try:
        if args.op not in OPS + ALIASES:
            raise BadInputError(f"There is no operation '{args.op}': OP is {', '.join(OPS)}.")
        exp_bits, frac_bits = parse_format(args.format)
        if not Path(args.file).is_file():
            raise BadInputError(
                f"There is no TestFloat file '{args.file}'; give its path as FILE=."
            )
        program = build(exp_bits, frac_bits)
    except BadInputError as error:
        print(error, file=sys.stderr)
        return 2
    command = [program, "--testfloat", args.file, "--op", args.op]
    return subprocess.run(command, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
