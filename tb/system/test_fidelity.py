# SPDX-License-Identifier: Apache-2.0
"""Points of `make fidelity` are those of bench and model, go on, and stand on a whole page."""

import argparse
import csv
import json
import re
import sys
from fractions import Fraction
from types import SimpleNamespace

import pytest
from agents.program import ROOT, SCENES, call, make

sys.path.insert(0, str(ROOT / "scripts"))
import fidelity
import fidelity_page

WORDS = {"CONFIG": "tiny", "SCENES": "cornell", "RAYS": "primary", "SIZE": "64x64"}
WORDS |= {"N": "1/8", "RUNS": 2, "MEM": "ideal fixed"}


def lines_of(out):
    """The measurements by engine, sample and run; of one scene and kind of rays."""
    lines = [json.loads(line) for line in (out / "points.jsonl").read_text().splitlines()]
    return {(p["engine"], p["share"], p["run"]): line for line in lines for p in [line["point"]]}


@pytest.fixture(scope="module")
def measured(tiny, tmp_path_factory):
    """A folder with points of the machine `tiny`."""
    out = tmp_path_factory.mktemp("fidelity") / "out"
    make("fidelity", out, **WORDS).good()
    return out


def test_the_full_run_is_the_cell_of_the_bench(measured, tmp_path):
    make("bench", tmp_path, **(WORDS | {"MEM": "fixed", "N": 1000})).good()
    (cell,) = json.loads((tmp_path / "bench.json").read_text())["cells"]
    lines = lines_of(measured)
    for run in (1, 2):
        full = lines["fixed", "1", run]
        assert (
            (full["count"], full["cycles"])
            == (4096, cell["cycles"])
            == (cell["rays"], full["cycles"])
        )
        assert full["mrays_per_s"] == cell["mrays_per_s"]


def test_no_engine_is_faster_than_the_ceiling_of_its_rays(measured):
    lines = lines_of(measured)
    assert len(lines) == 3 * 2 * 2
    for (engine, share, run), line in lines.items():
        ceiling = lines["model", share, run]
        assert line["mrays_per_s"] <= ceiling["mrays_per_s"]
        assert line["good"] and (line["cycles"] is None) == (engine == "model")
    assert lines["ideal", "1", 1]["cycles"] < lines["fixed", "1", 1]["cycles"]


def test_a_sample_is_its_share_of_the_frame_and_each_run_draws_another(measured):
    lines = lines_of(measured)
    samples = [lines["fixed", "1/8", run] for run in (1, 2)]
    assert [line["count"] for line in samples] == [4096 / 8] * 2
    assert samples[0]["cycles"] != samples[1]["cycles"]
    assert lines["fixed", "1", 1]["cycles"] == lines["fixed", "1", 2]["cycles"]


def test_table_and_page_say_what_the_points_say(measured):
    lines = lines_of(measured)
    with (measured / "points.csv").open(newline="") as file:
        rows = {(row["engine"], row["sample"]): row for row in csv.DictReader(file)}
    assert set(rows) == {(e, s) for e in ("model", "ideal", "fixed") for s in ("1/8", "1")}
    assert float(rows["fixed", "1"]["error_percent"]) == 0
    full, ideal = (lines[engine, "1", 1]["mrays_per_s"] for engine in ("fixed", "ideal"))
    error = float(rows["ideal", "1"]["error_percent"])
    assert error == pytest.approx(100 * (ideal / full - 1), rel=1e-3)

    text = (measured / "index.html").read_text()
    assert not re.search(r"(src|href)=|<script", text)
    assert text.count("<circle") == len(rows) + 2  # the key has the two sizes
    assert f"cornell, primary: the whole frame with ideal memory is {error:.1f} % above it" in text
    assert len((measured / "points.md").read_text().splitlines()) == 2 + len(rows)


def test_a_sweep_goes_on_where_it_was_cut_short(tiny, measured, tmp_path):
    file = tmp_path / "points.jsonl"
    whole = (measured / "points.jsonl").read_text()
    file.write_text(whole[:-20])  # a stop in the middle of the last line
    run = make("fidelity", tmp_path, **(WORDS | {"N": "1/8 1/16"})).good()

    assert "11 measurements are there, 7 to do" in run.stdout
    lines, before = lines_of(tmp_path), lines_of(measured)
    assert len(lines) == 18
    for key, line in before.items():
        assert lines[key]["cycles"] == line["cycles"]


def test_a_library_that_is_linked_with_dram_meanwhile_is_of_the_same_machine(tmp_path):
    config, library = tmp_path / "config.json", tmp_path / "libti_rtl.so"
    model = tmp_path / "verilated/libVti_engine.a"
    model.parent.mkdir()
    for file in (config, library, model):
        file.write_text("1")
    arguments = argparse.Namespace(
        frame=(8, 8), mem=["fixed"], mem_latency=1, mem_bytes_per_cycle=1
    )
    module = SimpleNamespace(commit="1")
    measurement = fidelity.Measurement(module, arguments, config, library)
    heading = measurement.heading()
    library.write_text("2")
    assert measurement.heading() == heading
    model.write_text("2")
    assert measurement.heading() != heading


def test_another_frame_begins_anew(tiny, measured, tmp_path):
    (tmp_path / "points.jsonl").write_text((measured / "points.jsonl").read_text())
    run = make("fidelity", tmp_path, **(WORDS | {"SIZE": "32x32", "RUNS": 1})).good()
    assert "0 measurements are there, 6 to do" in run.stdout
    assert len(lines_of(tmp_path)) == 6


def test_a_file_of_something_else_is_left_as_it_is(tiny, tmp_path):
    file = tmp_path / "points.jsonl"
    file.write_text("notes\n")
    run = make("fidelity", tmp_path, **WORDS)
    assert run.status == 2 and str(file) in run.stderr
    assert file.read_text() == "notes\n"


def test_hits_unlike_the_models_end_it_with_a_status(measured, tmp_path):
    text = (measured / "points.jsonl").read_text()
    (tmp_path / "points.jsonl").write_text(text.replace('"good": true', '"good": false', 1))
    words = {"config": "tiny", "scene": SCENES / "cornell.gltf", "rays": "primary"}
    words |= {"frame": "64x64", "shares": "1/8", "runs": 2, "mem": "ideal fixed", "out": tmp_path}
    options = [part for name, value in words.items() for part in (f"--{name}", value)]
    run = call([sys.executable, ROOT / "scripts/fidelity.py", *options]).failed_its_checks()
    assert "12 measurements are there, 0 to do" in run.stdout


def test_secondary_rays_leave_hits_of_the_sample(tiny, out):
    make("fidelity", out, **(WORDS | {"RAYS": "ao", "RUNS": 1})).good()
    lines = lines_of(out)
    share = lines["fixed", "1/8", 1]["count"] / lines["fixed", "1", 1]["count"]
    assert share == pytest.approx(1 / 8, rel=0.2)


def test_the_dram_is_the_full_run_unless_it_is_said(dram, out):
    del dram
    words = {k: v for k, v in WORDS.items() if k != "MEM"} | {"RUNS": 1, "SIZE": "32x32"}
    make("fidelity", out, **words).good()
    with (out / "points.csv").open(newline="") as file:
        rows = {(row["engine"], row["sample"]): row for row in csv.DictReader(file)}
    assert {engine for engine, _ in rows} == {"model", "ideal", "fixed", "dram"}
    assert float(rows["dram", "1"]["error_percent"]) == 0


@pytest.mark.parametrize(
    "words",
    [
        {"SCENES": "nowhere"},
        {"RAYS": "primary sideways"},
        {"N": "1/16 many"},
        {"N": "1/0"},
        {"N": "2"},
        {"RUNS": "0"},
        {"SIZE": "64"},
        {"MEM": "ideal slow"},
        {"CORES": 0},
        {"CONFIG": "nothing"},
        {"MEM_LATENCY": "soon"},
    ],
)
def test_bad_words_are_refused(out, words):
    make("fidelity", out, **(WORDS | words)).refused(
        *(str(word).split()[-1] for word in words.values())
    )


def line_of(engine, share, run, speed, seconds):
    point = {"scene": "box.ply", "rays": "primary", "share": share, "engine": engine, "run": run}
    return {
        "point": point, "count": 100, "cycles": None if engine == "model" else 50,
        "mrays_per_s": speed, "seconds": {"cpu": seconds, "wall": 2 * seconds}, "busiest": "trv",
    }  # fmt: skip


def test_errors_are_of_each_draw_and_seconds_their_median():
    lines = [line_of("dram", "1", run, 100.0, 8.0) for run in (1, 2, 3)]
    lines += [
        line_of("dram", "1/16", *r) for r in ((1, 96.0, 0.5), (2, 101.0, 9.0), (3, 99.0, 0.4))
    ]
    lines += [line_of("model", "1", 1, 150.0, 0.1)]
    (cell,) = fidelity_page.cells_of(lines, "dram")

    sample, full, model = cell.points
    assert (full, full.error, sample.share) == (cell.full, 0, Fraction(1, 16))
    assert sample.errors == pytest.approx((-4, 1, -1))
    assert (sample.error, sample.worst, sample.seconds) == pytest.approx((-4 / 3, 4, 0.5))
    assert (model.worst, model.cycles) == (pytest.approx(50), None)
    assert cell.sentences == [
        "box, primary: a sample of 1/16 of the frame with DRAM is within 4.0 % of the full run in "
        "0.50 s of 8.00 s.",
        "box, primary: the soonest within 5 % is a sample of 1/16 of the frame with DRAM, "
        "0.50 s of 8.00 s, 4.0 % off at most.",
        "box, primary: the functional model's ceiling is 50.0 % above it in 0.10 s of 8.00 s.",
    ]


def test_a_cell_without_its_full_run_is_left_out():
    assert fidelity_page.cells_of([line_of("fixed", "1", 1, 9.0, 1.0)], "dram") == []
