# SPDX-License-Identifier: Apache-2.0
"""`scripts/fmax.py` gives the longest paths of a unit by name, the same on every machine."""

import json
import re
import subprocess
import sys
from collections import Counter

import pytest
from agents.bench import ROOT
from configure import configure
from fmax import FPGAS, LIBERTY, TOOLS
from harness import harness
from netlist import FANOUT, buffer_registers
from paths import longest

needs_cells = pytest.mark.skipif(
    not (LIBERTY.is_file() and subprocess.run(["which", "sta"], capture_output=True).stdout),
    reason="OSU cells or OpenSTA are missing; 'scripts/setup.sh --extra' installs them",
)
needs_nextpnr = pytest.mark.skipif(
    not (TOOLS / "bin" / FPGAS["ecp5-85k"][1]).is_file(),
    reason="nextpnr is missing; 'scripts/setup.sh --synthesis' installs it",
)
BASELINE = ROOT / "tb/baselines/fmax-tiny.json"

SDF = r"""(DELAYFILE
  (CELL
    (CELLTYPE "top")
    (INSTANCE )
        (INTERCONNECT a_q/Q lut/A (1:2:100) (1:2:100))
        (INTERCONNECT b\[0\]/Q lut/B (1:2:300) (1:2:300))
        (INTERCONNECT lut/F c_q/M (1:2:50) (1:2:50))
        (INTERCONNECT b\[0\]/Q pass_passthrough_lut\$/A (1:2:10) (1:2:10))
        (INTERCONNECT pass_passthrough_lut\$/F d_q/M (1:2:20) (1:2:20))
        (INTERCONNECT pin/O a_q/M (1:2:9000) (1:2:9000))
  )
  (CELL
    (CELLTYPE "LUT")
    (INSTANCE lut)
        (IOPATH A F (1:2:200) (1:2:200))
        (IOPATH B F (1:2:30) (1:2:30))
  )
  (CELL
    (CELLTYPE "LUT")
    (INSTANCE pass_passthrough_lut\$)
  )
"""
for name in ("a_q", r"b\[0\]", "c_q", "d_q"):
    SDF += f"""  (CELL
    (CELLTYPE "FF")
    (INSTANCE {name})
        (IOPATH CLK Q (1:2:500) (1:2:500))
      (SETUPHOLD (posedge M) (posedge CLK) (1:2:7) (0:0:0))
  )
"""


def fmax(folder, *arguments, overrides=()):
    """Run the script on the configuration tiny; the finished process."""
    configure("tiny", list(overrides), folder / "config")
    command = [sys.executable, ROOT / "scripts/fmax.py", folder / "config", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_longest_paths_are_those_of_the_delays(tmp_path):
    file = tmp_path / "a.sdf"
    file.write_text(SDF)
    found = [(path.ns, path.start, path.end) for path in longest(file, 10)]
    # Clock to output, wire, table, wire, setup; the table that passes is as slow as the slowest.
    assert found == [(0.887, "b[0]", "c_q"), (0.737, "b[0]", "d_q")]


def test_a_harness_drives_every_input_and_takes_every_output():
    ports = {
        "clk_i": {"direction": "input", "bits": [2]},
        "rst_ni": {"direction": "input", "bits": [3]},
        "data_i": {"direction": "input", "bits": [*range(4, 9)]},
        "valid_i": {"direction": "input", "bits": [9]},
        "data_o": {"direction": "output", "bits": [*range(10, 17)]},
    }
    text, places = harness("ti_some", ports)
    assert re.search(r"ti_some u_unit \(.*\.clk_i\(clk_i\), \.rst_ni\(reset_q\[1\]\)", text)
    assert r".\data_i (in_q[4:0])" in text and r".\valid_i (in_q[5:5])" in text
    assert places["in_q[5]"] == "input valid_i" and places["tree0_q[6]"] == "output data_o"
    assert len(places) == 6 + 7


def test_a_register_with_many_sinks_gets_a_tree_of_buffers():
    def cell(kind, **pins):
        return {"type": kind, "connections": {pin: [bit] for pin, bit in pins.items()}}

    cells = {"source": cell("DFFPOSX1", CLK=2, D=3, Q=4)}
    cells |= {f"sink_{i}": cell("INVX1", A=4, Y=10 + i) for i in range(200)}
    module = {"cells": cells, "netnames": {"all": {"bits": [*range(2, 210)], "hide_name": 0}}}
    count = buffer_registers(module)
    assert count == 17 + 2

    driver, sinks = {}, Counter()
    for name, what in cells.items():
        for pin, (bit,) in what["connections"].items():
            if pin in ("Y", "Q"):
                driver[bit] = name
            else:
                sinks[bit] += 1
    assert max(sinks.values()) <= FANOUT
    for i in range(200):
        name = f"sink_{i}"
        while name != "source":
            name = driver[cells[name]["connections"]["A"][0]]


@needs_nextpnr
def test_a_placed_unit_has_the_clock_of_its_baseline_and_of_nextpnr(tmp_path):
    out = tmp_path / "out.json"
    words = ["--part", "ecp5-85k", "--unit", "ti_fp_cmp", "--seeds", "2", "--json", out]
    done = fmax(tmp_path, *words, "--baseline", BASELINE)
    assert done.returncode == 0, done.stdout + done.stderr
    unit = json.loads(out.read_text())["units"]["ti_fp_cmp"]
    for seed, mhz in unit["mhz"].items():
        report = tmp_path / f"config/fmax/ecp5-85k/ti_fp_cmp.{seed}.report.json"
        (clock,) = json.loads(report.read_text())["fmax"].values()
        assert mhz == pytest.approx(clock["achieved"], rel=1e-4)
    assert unit["paths"][0]["start"].startswith("input ")
    assert unit["paths"][0]["end"].startswith("output ")


@needs_cells
def test_longest_paths_are_between_named_registers(tmp_path):
    out = tmp_path / "out.json"
    done = fmax(tmp_path, "--part", "osu018", "--unit", "ti_fp_add", "--json", out)
    assert done.returncode == 0, done.stderr
    unit = json.loads(out.read_text())["units"]["ti_fp_add"]
    assert 100 < unit["median_mhz"] < 400
    assert 3 < unit["gates_ns"] < 1000 / unit["median_mhz"]
    assert len(unit["paths"]) > 5
    for path in unit["paths"]:
        for end in (path["start"], path["end"]):
            assert re.fullmatch(r"(input|output) \w+_[io]|\w+_q\d?|\w+_o", end), path


@needs_cells
def test_a_path_over_the_limit_gives_status_1(tmp_path):
    done = fmax(tmp_path, "--part", "osu018", "--unit", "ti_fp_cmp", "--limit", "0.5")
    assert done.returncode == 1
    assert "input" in done.stdout and "output" in done.stdout
    assert "over 0.5 ns: ti_fp_cmp" in done.stdout


@pytest.mark.parametrize(
    "words, said",
    [
        (["--part", "ice40"], "ice40"),
        (["--part", "ecp5-85k", "--unit", "ti_nothing"], "ti_nothing"),
        (["--part", "ecp5-85k", "--speed", "9"], "speed"),
    ],
)
def test_bad_input_ends_in_one_sentence(tmp_path, words, said):
    done = fmax(tmp_path, *words)
    assert done.returncode == 2
    assert said in done.stderr or "is missing" in done.stderr
    assert done.stderr.count("\n") == 1


def test_a_folder_without_a_configuration_is_named(tmp_path):
    for script in (["fmax.py", "--part", "ecp5-85k"], ["area.py"], ["synth_check.py"]):
        command = [sys.executable, ROOT / "scripts" / script[0], tmp_path, *script[1:]]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 2
        assert done.stderr.count("\n") == 1, done.stderr
