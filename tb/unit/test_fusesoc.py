# SPDX-License-Identifier: Apache-2.0
"""`ti.core` gives each tool the files of `rtl/ti.f` in order, and constraints that there are."""

import re
import subprocess
from pathlib import Path

import yaml
from agents.bench import ROOT

CORE = "ti-engine:ray_tracing:ti"
RTL = [Path(word).name for word in (ROOT / "rtl/ti.f").read_text().split()][1:]
FILES = ["ti_config_pkg.sv", "ti_count_pkg.sv", *RTL, "ti_top_wrapper.v"]
TARGETS = yaml.safe_load((ROOT / "ti.core").read_text().partition("\n")[2])["targets"]


def fusesoc(folder, target, *words):
    """Run a target in a folder; all that it printed."""
    command = ["fusesoc", "run", f"--target={target}", f"--work-root={folder}", *words, CORE]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


def names(text, pattern):
    return [Path(path).name for path in re.findall(pattern, text, re.MULTILINE)]


def test_the_targets_are_those_that_the_documents_name():
    documented = re.findall(r"--target=(\w+)", (ROOT / "docs/parts.md").read_text())
    assert set(documented) == set(TARGETS) - {"default"}


def test_lint_is_clean(tmp_path):
    printed = fusesoc(tmp_path, "lint")
    (arguments,) = tmp_path.glob("*.vc")
    assert names(arguments.read_text(), r"^(src/\S+\.s?v)$") == FILES
    assert "Warning-" not in printed


def test_a_vivado_project_has_files_and_constraints_in_order(tmp_path):
    fusesoc(tmp_path, "vivado", "--setup")
    (project,) = tmp_path.glob("ti*_1.0.0.tcl")
    text = project.read_text()
    assert names(text, r"^read_verilog(?: -sv)? {(.*)}") == FILES
    read = ["clock.xdc", "vivado_ports.tcl", "vivado_crossings.tcl"]
    assert names(text, r"^read_xdc(?: -unmanaged)? {(.*)}") == read
    assert names(text, r"^source {(.*)}") == ["project.tcl"]
    part = re.search(r"set part (\S+)", (ROOT / "constraints/arty_a7_100t/board.tcl").read_text())
    assert f"set_property part {part[1]} " in text
    for path in re.findall(r"^(?:read_\w+|source)(?: -\w+)? {(.*)}", text, re.MULTILINE):
        assert (tmp_path / path).is_file(), path


def test_a_quartus_project_has_files_and_constraints_in_order(tmp_path):
    fusesoc(tmp_path, "quartus", "--setup")
    (project,) = tmp_path.glob("ti*.tcl")
    text = project.read_text()
    assert names(text, r"-name (?:SYSTEM)?VERILOG_FILE (.*)") == ["ti_top_wrapper_plain.v"]
    read = ["clock.sdc", "quartus_ports.sdc", "quartus_crossings.sdc"]
    assert names(text, r"-name SDC_FILE (.*)") == read
    assert names(text, r"^source (.*)") == ["project.tcl"]
    part = re.search(r"set part (\S+)", (ROOT / "constraints/de10_nano/board.tcl").read_text())[1]
    assert f"-name DEVICE {part}\n" in text


def test_the_block_passes_its_smoke_test(tmp_path):
    assert "ti_top_smoke: passed" in fusesoc(tmp_path, "sim")
