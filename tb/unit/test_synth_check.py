# SPDX-License-Identifier: Apache-2.0
"""The engine is clean for a synthesis tool, and `scripts/synth_check.py` sees what is not."""

import json
import shutil
import subprocess
import sys

import pytest
from agents.bench import ROOT
from configure import configure
from synthesis import Synthesis


def check(folder, *arguments, rtl=ROOT / "rtl"):
    """Run the script on the configuration tiny; the finished process."""
    configure("tiny", [], folder / "config")
    command = [sys.executable, ROOT / "scripts/synth_check.py", folder / "config", "--rtl", rtl]
    return subprocess.run([*command, *arguments], capture_output=True, text=True, check=False)


def with_line(folder, line):
    """A copy of the RTL with one more line in `ti_fifo`."""
    rtl = folder / "rtl"
    shutil.copytree(ROOT / "rtl", rtl)
    file = rtl / "common/ti_fifo.sv"
    end = "endmodule : ti_fifo"
    text = file.read_text()
    assert text.count(end) == 1
    file.write_text(text.replace(end, line + end))
    return rtl


@pytest.mark.parametrize(("sync_reset", "found"), [(1, "none"), (0, "any")])
def test_registers_see_the_reset_as_the_configuration_says(tmp_path, sync_reset, found):
    configure("tiny", [f"sync_reset={sync_reset}"], tmp_path)
    synthesis = Synthesis(tmp_path, ROOT / "rtl")
    asynchronous = f"select -assert-{found} t:$adff t:$adffe t:$aldff t:$aldffe"
    good, text = synthesis.run("ti_ra", synthesis.read("ti_ra"), asynchronous)

    assert good, text[-2000:]


def test_top_is_clean(tmp_path):
    """The engine in it too."""
    done = check(tmp_path, "--quick", "--unit", "ti_top")
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize(
    "line, word",
    [
        ("logic held;\nalways_latch if (in_valid_i) held = out_ready_i;\n", "latch"),
        ("wire here, there;\nassign here = there & load;\nassign there = here | push;\n", "loop"),
        ("wire twice;\nassign twice = load;\nassign twice = push;\n", "driver"),
        ("logic late;\nassign late = early;\nlogic early;\nassign early = load;\n", "declar"),
    ],
)
def test_fault_is_reported(tmp_path, line, word):
    rtl = with_line(tmp_path, line)
    done = check(tmp_path, "--quick", "--unit", "ti_fifo", rtl=rtl)
    assert done.returncode == 1, done.stdout
    assert word in done.stdout


def test_every_ram_has_a_clocked_read(tmp_path):
    out = tmp_path / "out.json"
    done = check(tmp_path, "--unit", "ti_trv_return", "--json", out)
    assert done.returncode == 0, done.stdout
    rams = {m["name"]: m for m in json.loads(out.read_text())["memories"]}
    for name in (
        "u_sent",
        "u_back",
        "u_park",
        "u_best.u_interval",
        "u_best.u_key",
        "u_best.u_final",
        "u_best.u_tbest_hit",
        "u_best.u_tbest_start",
        "u_retire.u_ray_id",
        "u_retire.u_steps",
    ):
        assert rams[f"{name}.mem_q"]["clocked_read"], name


def test_unknown_unit_is_named(tmp_path):
    done = check(tmp_path, "--unit", "ti_nothing")
    assert done.returncode == 2
    assert "ti_nothing" in done.stderr
