# SPDX-License-Identifier: Apache-2.0
"""`scripts/timing.py` gives the longest path of a unit by name, and tells when it is too long."""

import json
import subprocess
import sys

import pytest
from agents.bench import ROOT
from configure import configure
from timing import LIBERTY

needs_liberty = pytest.mark.skipif(
    not LIBERTY.is_file(), reason=f"{LIBERTY} is missing; 'scripts/setup.sh --extra' installs it"
)


def timing(folder, *arguments, overrides=()):
    """Run the script on the configuration tiny; the finished process."""
    configure("tiny", list(overrides), folder / "config")
    command = [sys.executable, ROOT / "scripts/timing.py", folder / "config", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@needs_liberty
def test_longest_path_is_between_named_registers(tmp_path):
    out = tmp_path / "out.json"
    done = timing(tmp_path, "--unit", "ti_fp_add", "--limit", "6.5", "--json", out)
    assert done.returncode == 0, done.stderr
    (row,) = json.loads(out.read_text())["units"]
    assert 3 < row["delay_ns"] < 6.5
    assert 2000 < row["gates"] < 5000
    assert row["start"].startswith("register ") and row["end"].startswith("register ")


@needs_liberty
def test_a_path_over_the_limit_gives_status_1(tmp_path):
    done = timing(tmp_path, "--unit", "ti_fp_cmp", "--limit", "0.5")
    assert done.returncode == 1
    assert "input" in done.stdout and "output" in done.stdout
    assert "over 0.5 ns: ti_fp_cmp" in done.stdout


@needs_liberty
def test_the_words_of_a_ram_are_no_flops(tmp_path):
    flops = []
    for slots in (8, 16):
        out = tmp_path / f"{slots}.json"
        overrides = [f"trv_slots={slots}"]
        done = timing(tmp_path, "--unit", "ti_trv_return", "--json", out, overrides=overrides)
        assert done.returncode == 0, done.stderr
        flops.append(json.loads(out.read_text())["units"][0]["flops"])
    # A slot has some 20 flops, and more than 300 bits in RAMs.
    assert flops[0] < flops[1] < flops[0] + 8 * 40


@needs_liberty
def test_unknown_unit_is_named(tmp_path):
    done = timing(tmp_path, "--unit", "ti_nothing")
    assert done.returncode == 2
    assert "ti_nothing" in done.stderr and done.stderr.count("\n") == 1


def test_a_folder_without_a_configuration_is_named(tmp_path):
    command = [sys.executable, ROOT / "scripts/timing.py", tmp_path]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert str(tmp_path) in done.stderr and done.stderr.count("\n") == 1
