# SPDX-License-Identifier: Apache-2.0
"""The ladder of formats and tests: a table of all hard cases, rates of rays, what is refused."""

import json

import pytest
from agents.program import ROOT, SCENES, call, make

CASES = SCENES / "hardcases.jsonl"


@pytest.fixture(scope="module")
def ladder(ti, tmp_path_factory):
    """A function that runs it: cells by (case, format, test), and the run."""
    folder = tmp_path_factory.mktemp("ladder")

    def run(name, *options, file=CASES, scene=SCENES / "one_triangle.obj"):
        out = folder / name
        words = ["ladder", "--config", ti.config, "--file", file, "--scene", scene, "--out", out]
        return call([ti.path, *words, *options], out)

    return run


def lines(run):
    return [json.loads(line) for line in run.read("hardcases.json").decode().splitlines()]


def test_every_case_has_a_cell_for_each_format_and_test(ladder):
    run = ladder("all", "--count", 0).good()
    cells = lines(run)

    numbers = [json.loads(line)["n"] for line in CASES.read_text().splitlines()]
    machines = {(cell["format"], cell["test"]) for cell in cells}
    assert len(machines) == 15 and len(cells) == 15 * len(numbers)
    assert not [c for c in cells if c["outcome"] == "FAIL"]
    for cell in cells:
        assert bool(cell["absent"]) == (cell["outcome"] == "n.a."), cell
        assert cell["format"] != "8,23" or cell["outcome"] in ("pass", "policy"), cell
    table = run.read("table.md").decode()
    assert f"| {'23':<3} | subnormal direction" in table
    assert table.count("\n| ") >= len(numbers) + 15
    assert run.stdout.startswith(table.split("\n")[0])


def test_a_wrong_expected_answer_fails(ladder, tmp_path):
    case = json.loads(CASES.read_text().splitlines()[0])
    wrong = case | {"n": 99, "exact_hit": False, "exact_ids": []}
    file = tmp_path / "cases.jsonl"
    file.write_text(f"{json.dumps(case)}\n{json.dumps(wrong)}\n")
    run = ladder("wrong", "--formats", "8,23", "--tests", "local woop", "--count", 0, file=file)

    said = run.failed_its_checks().stdout
    assert [cell["outcome"] for cell in lines(run)] == ["pass", "pass", "FAIL", "FAIL"]
    assert "failed: case 99 with 8,23 local: required miss, got hit 0 at 5" in said
    assert said.splitlines()[-3].endswith("on 2 machines, 2 failed")
    [repeat] = [line for line in said.splitlines() if "woop traversal=padded" in line]
    assert repeat.startswith("repeat: make hardcase ID=99 CONFIG=tiny ") and str(file) in repeat


def test_rates_are_those_of_accuracy(ti, ladder, tmp_path):
    scene = SCENES / "cornell.gltf"
    words = ["--formats", "8,23", "--tests", "local woop", "--rays", "edges far secondary"]
    rates = [
        cell
        for cell in lines(ladder("rates", *words, "--count", 500, scene=scene))
        if "rays" in cell
    ]
    assert [(cell["rays"], cell["test"]) for cell in rates] == [
        (kind, test) for kind in ("edges", "far", "secondary") for test in ("local", "woop")
    ]
    out = tmp_path / "counted"
    call([ti.path, "accuracy", "--config", ti.config, "--scene", scene, "--count", 500,
          "--size", "40x30", "--rays", "edges far secondary", "--out", out]).good()  # fmt: skip
    [counted] = [json.loads(line) for line in (out / "points.jsonl").read_text().splitlines()]
    for rate, point in zip(rates[::2], counted["kinds"], strict=True):
        assert rate["traced"] == point["count"]
        for ours, theirs in (("missed", "missed"), ("wrong_triangle", "wrong_triangle")):
            assert rate[ours]["count"] == point[theirs]
        cracks = rate["cracks"]
        assert cracks["count"] == point["cracks"]
        assert cracks["low"] <= cracks["per_million"] <= cracks["high"]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--formats", "9,9"], ["FORMATS=9,9", "8,23"]),
        (["--formats", "8,23 half"], ["FORMATS=half"]),
        (["--formats", "4,23"], ["FORMATS=4,23", "6"]),
        (["--tests", "embree"], ["TESTS=embree", "woop"]),
        (["--tests", " "], ["TESTS="]),
        (["--rays", "edges corners"], ["corners", "vertices"]),
        (["--count", "-1"], ["--count"]),
        (["--scene", SCENES / "empty.ply"], ["empty.ply"]),
        (["--file", SCENES / "none.jsonl"], ["none.jsonl"]),
    ],
)
def test_bad_words_are_refused(ti, out, options, said):
    words = {"--scene": SCENES / "one_triangle.obj", "--file": CASES, "--count": "0"}
    words |= dict(zip(options[::2], options[1::2], strict=True))
    flat = [part for word in words.items() for part in word]
    call([ti.path, "ladder", "--config", ti.config, *flat, "--out", out], out).refused(*said)


@pytest.mark.usefixtures("ti")
def test_make_hardcases_refuses_a_format_and_traces_the_rest(tmp_path):
    words = {"CONFIG": "tiny", "ENGINE": "model", "N": 200}
    make("hardcases", tmp_path / "none", FORMATS="9,9", **words).refused("FORMATS=9,9")
    run = make("hardcases", tmp_path / "out", FORMATS="7,16", TESTS="local", **words).good()

    assert "63 cases and 6 kinds of rays on 1 machines, 0 failed" in run.stdout
    assert "63 cases, 0 failed" in run.stdout  # those of CONFIG=
    assert "cracks of a million" in run.read("table.md").decode()
    assert (ROOT / "build/scenes/icosphere.ply").is_file()
