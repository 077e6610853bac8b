# SPDX-License-Identifier: Apache-2.0
"""The RTL operators equal the model at volume, and TestFloat lines are judged as they should be."""

import random
import subprocess
from pathlib import Path

import configure
import pytest
from models.fp_oracle import Oracle

ROOT = Path(__file__).resolve().parents[2]
HALF = Oracle(5, 10)
EXHAUSTIVE = [(3, 2), (3, 4), (4, 3), (5, 4)]
SAMPLED = [(5, 10), (7, 16), (8, 23)]
KEYS = ("fp_add_stages", "fp_mul_stages", "fp_rcp_bits_per_stage", "fp_rcp_end_stages")
PAPER = configure.load("paper").values
# The first stages are those of the configuration `paper`; 7 and 5 are the most.
DEEPER = [tuple(PAPER[key] for key in KEYS), (7, 4, 1, 4), (6, 5, 3, 4)]
MODES = {
    "zero": ["rounding=zero"],
    "flush": ["subnormals=flush"],
    "newton": ["reciprocal=newton", "rcp_table_bits=4", "rcp_newton_steps=1"],
    "newton-2": ["reciprocal=newton", "fp_mul_stages=5"],
}
SEED = 1


def build(exp_bits, frac_bits, stages=(), modes=()):
    """The finished build of the bench of a format, and the path of its program."""
    out = ROOT / "build" / "fp" / "-".join(map(str, [exp_bits, frac_bits, *stages, *modes]))
    keys = [f"{key}={value}" for key, value in zip(KEYS, stages, strict=False)]
    keys += [key for mode in modes for key in MODES[mode]]
    command = [ROOT / "scripts/build_fp_rtl.sh", str(exp_bits), str(frac_bits), out, *keys]
    made = subprocess.run(command, capture_output=True, text=True, check=False)
    return made, out / "fp_rtl"


def bench(exp_bits, frac_bits, *arguments, stages=(), modes=()):
    made, program = build(exp_bits, frac_bits, stages, modes)
    assert made.returncode == 0, made.stderr
    return subprocess.run([program, *arguments], capture_output=True, text=True, check=False)


def replay(file, op="add"):
    return bench(5, 10, "--testfloat", file, "--op", op)


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
    run = bench(exp_bits, frac_bits, "--pairs", "100000", "--seed", str(SEED))

    assert run.returncode == 0, run.stdout + run.stderr
    assert "0 differences in all" in run.stdout


@pytest.mark.parametrize(
    ("exp_bits", "frac_bits", "stages"),
    [(8, 23, stages) for stages in DEEPER]
    + [(3, 4, DEEPER[0]), (4, 3, DEEPER[1]), (5, 4, DEEPER[2])],
)
def test_rtl_equals_model_at_other_stages(exp_bits, frac_bits, stages):
    arguments = ["--pairs", "100000", "--seed", str(SEED)]
    run = bench(exp_bits, frac_bits, *arguments, stages=stages)

    assert run.returncode == 0, run.stdout + run.stderr
    assert "0 differences in all" in run.stdout
    add, mul, bits, ends = stages
    rcp = ends + -(-(frac_bits + 2) // bits)
    assert f"latencies measured: add {add}, mul {mul}, rcp {rcp}\n" in run.stdout


@pytest.mark.parametrize(
    ("exp_bits", "frac_bits", "modes"),
    [
        (3, 4, ["zero", "newton"]),
        (4, 3, ["flush"]),
        (8, 23, ["zero", "flush"]),
        (8, 23, ["newton-2"]),
    ],
)
def test_rtl_equals_model_in_other_modes(exp_bits, frac_bits, modes):
    run = bench(exp_bits, frac_bits, "--pairs", "100000", "--seed", str(SEED), modes=modes)

    assert run.returncode == 0, run.stdout + run.stderr
    assert "0 differences in all" in run.stdout


def test_tiny_keeps_its_latencies():
    run = bench(8, 23, "--pairs", "1000")

    assert "latencies measured: add 4, mul 3, rcp 15\n" in run.stdout


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
    ("text", "op"),
    [
        ("3C00 3C00 4000 00", "fma"),
        ("3C00 3C00", "add"),
        ("3C00 3C00 4000 00 00", "add"),
        ("3C00 3CG0 4000 00", "add"),
        ("3F800000 3C00 4000 00", "add"),
        ("-3C00 3C00 4000 00", "add"),
        ("3C00 3C00 2 00", "lt"),
        ("", "add"),
    ],
)
def test_bad_input_ends_in_one_sentence_and_status_2(write, text, op):
    run = replay(write(text), op)

    assert run.returncode == 2
    assert run.stdout == ""
    assert run.stderr.count("\n") == 1
    assert run.stderr.rstrip().endswith(".")


@pytest.mark.parametrize(("exp_bits", "frac_bits"), [(9, 10), (2, 10), (8, 24), (8, 1), ("x", 10)])
def test_a_bad_format_ends_in_one_sentence_and_status_2(exp_bits, frac_bits):
    made, _ = build(exp_bits, frac_bits)

    assert made.returncode == 2
    assert made.stderr.count("\n") == 1
    assert f"{exp_bits},{frac_bits}" in made.stderr


def test_a_missing_file_ends_in_one_sentence_and_status_2(tmp_path):
    run = replay(tmp_path / "none.txt")

    assert run.returncode == 2
    assert "none.txt" in run.stderr
