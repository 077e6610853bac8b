# SPDX-License-Identifier: Apache-2.0
"""Pictures with what is left out and without it stand side by side, and so do others' pictures."""

import sys

import numpy as np
import pytest
from agents.program import ROOT, call, make

sys.path.insert(0, str(ROOT / "scripts"))
import effects_table

WORDS = {"CONFIG": "tiny", "SIZE": "16x12", "BOUNCES": 2}


def rows_of(out):
    """The cells of each row, by scene."""
    lines = (out / "effects.md").read_text().splitlines()[4:]
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    return {row[0]: row[1:] for row in cells}


@pytest.mark.parametrize("engine", ["model", "rtl"])
def test_each_scene_has_a_row_and_loses_nothing(tiny, out, engine):
    make("effects-table", out, SCENES="cornell one_triangle", ENGINE=engine, **WORDS).good()

    rows = rows_of(out)
    assert [*rows] == ["cornell", "one_triangle"]
    for row in rows.values():
        assert row[0] == "192 / 192"
        assert row[-1] == "yes"
        assert (row[7] != "") == (engine == "rtl")
    some, whole = (int(word.replace(",", "")) for word in rows["one_triangle"][6].split(" / "))
    assert some == 192 < whole  # lit from the eye: no other ray is called for


def test_a_picture_that_differs_is_told_and_ends_with_status_1(tmp_path, monkeypatch):
    def other_pictures(scene, folder, *words, effects, **options):
        folder.mkdir(parents=True)
        kinds = dict.fromkeys(effects_table.KINDS, 1)
        time = dict.fromkeys(("engine", "lock_step", "truth", "shading"), 0.0)
        report = {"rays_of": kinds, "rays": 6, "cycles": 5, "time": time}
        return report, np.full((2, 2, 3), 1.0 if effects == "all" else 1.5, dtype=np.float32)

    monkeypatch.setattr(effects_table, "render", other_pictures)
    words = ["--config", "none", "--scene", "cornell", "--out", str(tmp_path / "out")]
    assert effects_table.run(words) == 1
    assert rows_of(tmp_path / "out")["cornell"][-1] == "NO"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ({"SCENES": "cornell nowhere"}, "nowhere"),
        ({"SCENES": "cornell", "SIZE": "x"}, "SIZE=x"),
        ({"SCENES": "cornell", "ENGINE": "steam"}, "steam"),
    ],
)
def test_bad_words_are_refused(tiny, tmp_path, words, said):
    run = make("effects-table", tmp_path / "out", **(WORDS | {"ENGINE": "model"} | words))
    assert run.status == 2
    assert said in run.stderr


@pytest.mark.parametrize("command", ["second_opinion", "convergence"])
def test_others_pictures_are_like_ours(ti, tmp_path, command):
    """A small one of each, where `make second-opinion` has installed what it needs."""
    python = ROOT / "build/checks/bin/python"
    if not python.is_file():
        pytest.skip("build/checks is not there; `make second-opinion` installs it")
    words = [python, ROOT / f"scripts/{command}.py", "--config", ti.config, "--out", tmp_path / "o"]
    if command == "second_opinion":
        words += ["--size", 16, "--runs", 2, "--spp", 64]
    else:
        words += ["--scene", "cornell", "--size", "16x12", "--most", 16]
    run = call(words)
    assert run.status in (0, 1), run.stderr  # so few samples are noise
    name = command.replace("_", "-")
    assert "|---|" in (tmp_path / f"o/{name}.md").read_text()
    assert [*(tmp_path / "o").glob("*.png")]
