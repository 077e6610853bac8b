# SPDX-License-Identifier: Apache-2.0
"""`configure.py` writes one set of values in every form; what cannot be built gets one sentence."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
SCRIPT = ROOT / "scripts/configure.py"


def configure(*arguments):
    command = [sys.executable, str(SCRIPT), *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True)


@pytest.mark.parametrize("path", sorted((ROOT / "configs").glob("*.yaml")), ids=lambda p: p.stem)
def test_every_form_has_the_values_of_the_yaml(path, tmp_path):
    assert configure(path.stem, "--out", tmp_path).returncode == 0
    wanted = yaml.safe_load(path.read_text())

    written = json.loads((tmp_path / "config.json").read_text())
    assert written.pop("name") == path.stem
    assert written == wanted

    package = (tmp_path / "ti_config_pkg.sv").read_text()
    header = (tmp_path / "ti_config.hpp").read_text()
    for key, value in wanted.items():
        name = key.title().replace("_", "")
        assert f"localparam int unsigned {name} = {value};" in package
        assert f"inline constexpr int k{name} = {value};" in header


def test_an_override_changes_one_key_and_the_name(tmp_path):
    assert configure("tiny", "num_ist1=3", "--out", tmp_path).returncode == 0
    written = json.loads((tmp_path / "config.json").read_text())
    assert written["num_ist1"] == 3
    assert written["name"] == "tiny num_ist1=3"


def test_unchanged_files_keep_their_date(tmp_path):
    dates = []
    for _ in range(2):
        assert configure("tiny", "--out", tmp_path).returncode == 0
        dates.append({p.name: p.stat().st_mtime_ns for p in tmp_path.iterdir()})
    assert dates[0] == dates[1]


@pytest.mark.parametrize(
    ("override", "allowed"),
    [
        ("exp_bits=2", "3 to 8"),
        ("exp_bits=9", "3 to 8"),
        ("frac_bits=1", "2 to 23"),
        ("frac_bits=24", "2 to 23"),
        ("fp_add_stages=3", "4 to 7"),
        ("fp_add_stages=8", "4 to 7"),
        ("fp_mul_stages=2", "3 to 5"),
        ("fp_mul_stages=6", "3 to 5"),
        ("fp_rcp_bits_per_stage=0", "1 to 3"),
        ("fp_rcp_bits_per_stage=4", "1 to 3"),
        ("fp_rcp_end_stages=1", "2 to 4"),
        ("fp_rcp_end_stages=5", "2 to 4"),
        ("num_trv=0", "1 to 256"),
        ("num_list=2", "at most num_trv, 1"),
        ("trv_slots=24", "power of two from 2 to 256"),
        ("ist1_slots=1", "power of two from 2 to 256"),
        ("stack_depth=0", "1 to 64"),
        ("stack_depth=65", "1 to 64"),
        ("line_bytes=16", "power of two from 32 to 128"),
        ("line_bytes=96", "power of two from 32 to 128"),
        ("trv_l1_ways=0", "1 to 16"),
        ("trv_l1_bytes=1536", "128, times a power of two"),
        ("list_l1_bytes=64", "128, times a power of two"),
        ("ist1_rows=9", "1 to ist1_slots, 8"),
        ("list_rows=0", "1 to 256"),
        ("watchdog_steps=65536", "1 to 65535"),
        ("no_such_key=1", "the keys are exp_bits"),
    ],
)
def test_an_impossible_value_names_file_key_and_range(override, allowed, tmp_path):
    out = tmp_path / "config"
    result = configure("tiny", override, "--out", out)
    assert result.returncode == 2
    assert result.stderr.count("\n") == 1
    assert "tiny.yaml" in result.stderr
    assert re.search(rf"\b{override.split('=')[0]}\b", result.stderr)
    assert allowed in result.stderr
    assert not out.exists()


def test_an_adder_deeper_than_the_reciprocal_is_named(tmp_path):
    values = ["frac_bits=2", "fp_rcp_bits_per_stage=3", "fp_add_stages=5"]
    result = configure("tiny", *values, "--out", tmp_path / "config")
    assert result.returncode == 2
    assert (
        "fp_add_stages is 5, but must be at most the stages of the reciprocal, 4" in result.stderr
    )
    assert not (tmp_path / "config").exists()


@pytest.mark.parametrize("override", ["num_trv", "num_trv=two", "num_trv=", "num_trv=1.5"])
def test_an_override_that_is_no_number_is_named(override, tmp_path):
    result = configure("tiny", override, "--out", tmp_path)
    assert result.returncode == 2
    assert result.stderr.startswith(f"{override}: not an override")


@pytest.mark.parametrize(
    ("edit", "sentence"),
    [
        (lambda text: text.replace("num_trv:", "#"), "key num_trv is missing"),
        (lambda text: text.replace("num_trv: 1 ", "num_trv: many "), "num_trv is many"),
        (lambda text: text.replace("num_trv: 1 ", "num_trv: true "), "num_trv is True"),
        (lambda text: text.replace("num_trv: 1 ", "num_trv: 1.5 "), "num_trv is 1.5"),
        (lambda text: text.replace("num_trv: 1 ", "num_trv: [1 "), "is not YAML"),
        (lambda text: "", "holds no keys"),
    ],
)
def test_a_broken_file_is_named(edit, sentence, tmp_path):
    path = tmp_path / "broken.yaml"
    path.write_text(edit((ROOT / "configs/tiny.yaml").read_text()))
    result = configure(path, "--out", tmp_path / "config")
    assert result.returncode == 2
    assert str(path) in result.stderr
    assert sentence in result.stderr
    assert not (tmp_path / "config").exists()


def test_an_unknown_name_lists_the_known_ones(tmp_path):
    result = configure("nothing", "--out", tmp_path)
    assert result.returncode == 2
    assert "paper, small, tiny" in result.stderr
