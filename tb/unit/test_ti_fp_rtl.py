# SPDX-License-Identifier: Apache-2.0
"""The RTL operators equal the model at volume, and TestFloat lines are judged as they should be."""

import random
import subprocess
import sys
from pathlib import Path

import pytest
from models.fp_oracle import Oracle

ROOT = Path(__file__).resolve().parents[2]
HALF = Oracle(5, 10)
EXHAUSTIVE = [(3, 2), (3, 4), (4, 3), (5, 4)]
SAMPLED = [(5, 10), (7, 16), (8, 23)]
SEED = 1


def replay(file, op="add", form="5,10"):
    command = [sys.executable, ROOT / "scripts/testfloat.py", "--op", op, "--format", form]
    return subprocess.run(
        [*command, "--file", file], capture_output=True, text=True, check=False, timeout=600
    )


def lines(op, count=500):
    """What testfloat_gen writes, from the oracle; NaN results as SoftFloat's 0xFE00."""
    for a, b in HALF.pairs(random.Random(SEED), count):
        operands = (a,) if op == "rcp" else (a, b)
        result = getattr(HALF, op)(*operands)
        if op in ("lt", "le", "eq"):
            text = f"{result:x}"
        else:
            text = f"{0xFE00 if result == HALF.nan else result:04X}"
        yield " ".join([*(f"{x:04X}" for x in operands), text, "00"])


@pytest.fixture
def write(tmp_path):
    def write_lines(*text):
        file = tmp_path / "lines.txt"
        file.write_text("".join(f"{line}\n" for line in text))
        return file

    return write_lines


@pytest.mark.parametrize(("exp_bits", "frac_bits"), EXHAUSTIVE + SAMPLED)
def test_rtl_equals_model_at_volume(exp_bits, frac_bits):
    out = ROOT / "build" / "fp_rtl" / f"{exp_bits}_{frac_bits}"
    script = ROOT / "scripts/build_fp_rtl.sh"
    subprocess.run([script, str(exp_bits), str(frac_bits), out], check=True, capture_output=True)

    run = subprocess.run(
        [out / "fp_rtl", "--pairs", "100000", "--seed", str(SEED)],
        capture_output=True,
        text=True,
        check=False,
    )

    assert run.returncode == 0, run.stdout + run.stderr
    assert "0 differences in all" in run.stdout


@pytest.mark.parametrize("op", ["add", "sub", "mul", "rcp", "lt", "le", "eq"])
def test_right_lines_pass(write, op):
    text = list(lines(op))

    run = replay(write(*text), op)

    assert run.returncode == 0, run.stdout + run.stderr
    assert f"{len(text)} lines, 0 model differences, 0 RTL differences" in run.stdout


def test_a_wrong_line_is_found_and_shown(write):
    run = replay(write("3C00 3C00 4000 00", "3C00 3C00 4001 00", "8000 8000 0000 00"))

    assert run.returncode == 1
    assert "line 2: add 3c00 3c00: file 4001, model 4000, RTL 4000" in run.stdout
    assert "3 lines, 2 model differences, 2 RTL differences" in run.stdout


def test_a_number_is_not_nan(write):
    run = replay(write("7C00 FC00 0000 10", "3C00 3C00 7E00 00"))

    assert "2 lines, 2 model differences, 2 RTL differences" in run.stdout


@pytest.mark.parametrize(
    ("text", "op", "form"),
    [
        ("3C00 3C00 4000 00", "fma", "5,10"),
        ("3C00 3C00 4000 00", "add", "9,10"),
        ("3C00 3C00 4000 00", "add", "half"),
        ("3C00 3C00", "add", "5,10"),
        ("3C00 3C00 4000 00 00", "add", "5,10"),
        ("3C00 3CG0 4000 00", "add", "5,10"),
        ("3F800000 3C00 4000 00", "add", "5,10"),
        ("-3C00 3C00 4000 00", "add", "5,10"),
        ("3C00 3C00 2 00", "lt", "5,10"),
        ("", "add", "5,10"),
    ],
)
def test_bad_input_ends_in_one_sentence_and_status_2(write, text, op, form):
    run = replay(write(text), op, form)

    assert run.returncode == 2
    assert run.stdout == ""
    assert run.stderr.count("\n") == 1
    assert run.stderr.rstrip().endswith(".")


def test_a_missing_file_ends_in_one_sentence_and_status_2(tmp_path):
    run = replay(tmp_path / "none.txt")

    assert run.returncode == 2
    assert "none.txt" in run.stderr
