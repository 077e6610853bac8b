# SPDX-License-Identifier: Apache-2.0
"""Each fault of `tb/mutants.yaml` fits the RTL once, changes it, and names tests that exist."""

import shutil

import mutants
import pytest
from agents.bench import ROOT

TABLE = mutants.load()


@pytest.mark.parametrize("mutant", TABLE, ids=lambda m: m.name)
def test_fault_fits_the_rtl(tmp_path, mutant):
    (tmp_path / mutant.file).parent.mkdir(parents=True)
    shutil.copy(ROOT / mutant.file, tmp_path / mutant.file)
    mutant.apply(tmp_path)
    assert (tmp_path / mutant.file).read_text() != (ROOT / mutant.file).read_text()
    assert mutant.why
    for test in mutant.tests:
        assert (ROOT / f"tb/unit/{test}.py").is_file(), test


def test_some_faults_are_tried_by_every_run():
    assert sum(mutant.quick for mutant in TABLE) >= 3


def test_spacing_does_not_matter_and_words_do(tmp_path):
    file = tmp_path / "a.sv"
    file.write_text("assign a   = b &&\n      c[1:0];\n")
    fault = {"name": "n", "why": "w", "file": "a.sv", "new": "b || c[1:0]", "tests": ()}
    mutants.Mutant(old="b && c[1:0]", **fault).apply(tmp_path)
    assert file.read_text() == "assign a   = b || c[1:0];\n"
    with pytest.raises(mutants.TableError):
        mutants.Mutant(old="b && c[1:0]", **fault).apply(tmp_path)


def test_fusesoc_finds_no_core_in_the_copies(tmp_path, monkeypatch):
    monkeypatch.setattr(mutants, "WORK", tmp_path)
    monkeypatch.setattr(mutants, "SNAPSHOT", tmp_path / "snapshot")
    mutants.take_snapshot()
    assert (tmp_path / "snapshot/ti.core").is_file()
    assert (tmp_path / "FUSESOC_IGNORE").is_file()
