# SPDX-License-Identifier: Apache-2.0
"""Every proof promises something, can fail, and is told from one that failed or never ran."""

import re
import shutil
import subprocess
import sys

import formal
import mutants
import pytest
from agents.bench import ROOT

PROOFS = formal.load()
FAULTS = {fault.name: fault for fault in mutants.load()}


@pytest.mark.parametrize("proof", PROOFS.values(), ids=PROOFS)
def test_a_proof_has_a_promise_a_cover_and_a_fault(proof):
    assert re.fullmatch(r"[A-Z`].*\.", proof.promise())
    assert proof.covers() > 0
    assert proof.fault in FAULTS
    modules = {path.stem for path in (ROOT / "rtl").rglob("*.sv")}
    assert any(f"{proof.module}_".startswith(f"{module}_") for module in modules)  # or a mode of it


@pytest.mark.parametrize("proof", PROOFS.values(), ids=PROOFS)
def test_what_is_assumed_of_a_caller_is_asserted_in_the_rtl(proof):
    rtl = "".join(path.read_text() for path in (ROOT / "rtl").rglob("*.sv"))
    for name in proof.assume:
        assert re.search(rf"`TI_ASSERT(_NEXT)?\({name},", rtl), name


def test_each_file_of_properties_is_in_the_table():
    files = {path.name.removesuffix("_formal.sv") for path in formal.FOLDER.glob("*_formal.sv")}
    assert files == set(PROOFS)


@pytest.mark.parametrize(
    ("kind", "status", "text", "verdict"),
    [
        ("proof", 0, "", "pass"),
        ("proof", 2, "failed assertion a.\\b.Holds at x.sv:1", "fail"),
        ("proof", 4, "", "fail"),
        ("proof", 16, "engine_0 (abc pdr) returned FAIL", "fail"),
        ("proof", 16, "", "error"),
        ("proof", None, "", "error"),
        ("covers", 0, "", "pass"),
        ("covers", 2, "Unreached cover statement a.Seen at x.sv:1", "fail"),
        ("covers", None, "", "error"),
        ("fault", 0, "", "fail"),
        ("fault", 2, "failed assertion a.Holds at x.sv:1", "pass"),
        ("fault", 16, "", "error"),
    ],
)
def test_verdicts(tmp_path, kind, status, text, verdict):
    run = formal.Run(PROOFS["ti_stage"], "", kind, tmp_path)
    run.judge(status, text)
    assert run.result.status == verdict
    assert run.result.says or verdict == "pass"


def test_a_module_without_a_proof_is_refused():
    command = [sys.executable, ROOT / "scripts/formal.py", "--unit", "ti_none"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.startswith("formal: ti_none: no proof of it; there are ti_fifo, ")
    assert done.stderr.count("\n") == 1


@pytest.fixture
def stage(tmp_path):
    """Runs of a small proof, with SymbiYosys installed."""
    subprocess.run([ROOT / "scripts/setup.sh", "--formal"], check=True)
    return lambda kind: formal.Run(PROOFS["ti_stage"], "", kind, tmp_path)


def test_properties_of_the_rtl_and_of_its_file_are_proven(stage):
    result = stage("proof").go()
    assert result.status == "pass", result.says
    assert {"u_unit.OutHeldUntilTaken", "u_unit.u_formal.ComesUnchanged"} <= set(result.asserted)


def test_a_property_that_does_not_hold_is_named(stage, monkeypatch, tmp_path):
    shutil.copytree(formal.FOLDER, tmp_path / "formal")
    file = tmp_path / "formal/ti_stage_formal.sv"
    file.write_text(file.read_text().replace("out_data_o == data_q", "out_data_o != data_q"))
    monkeypatch.setattr(formal, "FOLDER", tmp_path / "formal")
    result = stage("proof").go()
    assert result.status == "fail"
    assert any("ComesUnchanged fails" in words for words in result.says)


def test_without_assertions_nothing_is_proven(stage, monkeypatch, tmp_path):
    source = tmp_path / "empty.sv"
    source.write_text(
        "module empty (input logic clk_i, output logic q_o);\n"
        "  always_ff @(posedge clk_i) q_o <= !q_o;\nendmodule\n"
    )
    run = stage("proof")
    listed = f"tee -q -o {run.folder / 'asserted.txt'} select -list t:$assert"
    script = f"read_slang --top empty {source}\nprep -top empty\n{listed}"
    monkeypatch.setattr(formal.Run, "script", lambda _: script)
    result = run.go()
    assert result.status == "error"
    assert "nothing is asserted" in result.says
