# SPDX-License-Identifier: Apache-2.0
"""A bench writes its cells one by one, goes on where it was stopped, and its interval holds."""

import json
import signal
import subprocess
import sys
import time

import jsonschema
import pytest
from agents.program import ROOT, SCENES, call, make

CORNELL = SCENES / "cornell.gltf"
SCHEMA = json.loads((ROOT / "sw/report/bench.schema.json").read_text())


def command(program, out, *options):
    """The words of a bench of a small frame."""
    words = ["--config", program.config, "--library", program.library, "--scene", CORNELL]
    words += ["--count", 2000, "--frame", "64x64", "--out", out, *options]
    return [str(word) for word in (sys.executable, ROOT / "scripts/bench.py", *words)]


def cells_of(out):
    """The cells of a valid bench.json, without what is of the host."""
    bench = json.loads((out / "bench.json").read_text())
    jsonschema.validate(bench, SCHEMA)
    for cell in bench["cells"]:
        del cell["sim"]
    return bench["cells"]


def test_a_bench_that_was_killed_goes_on_and_gives_the_same(tiny, tmp_path):
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    call(command(tiny, whole), whole).good()
    words = command(tiny, parts)
    with subprocess.Popen(words, cwd=ROOT, stdout=subprocess.PIPE, text=True) as run:
        while not (parts / "bench.json").exists() and run.poll() is None:
            time.sleep(0.02)
        run.send_signal(signal.SIGKILL)
    killed = len(cells_of(parts))
    again = call(words, parts).good()

    assert 1 <= killed <= 3
    assert f"going on behind {killed} cells" in again.stdout
    assert cells_of(parts) == cells_of(whole)
    assert [cell["ray_type"] for cell in cells_of(parts)] == ["primary", "ao", "diffuse"]


def test_a_bench_of_something_else_begins_anew(tiny, out):
    call(command(tiny, out, "--rays", "primary"), out).good()
    other = call(command(tiny, out, "--rays", "primary", "--mem-latency", 300), out).good()

    assert "going on" not in other.stdout
    (cell,) = cells_of(out)
    assert cell["mem"]["latency"] == 300


def test_the_interval_of_a_sample_holds_the_frame(small, tmp_path):
    options = ["--rays", "diffuse", "--samples", 2, "--frame", "128x128"]
    call(command(small, tmp_path / "sample", *options, "--count", 4000), tmp_path).good()
    call(command(small, tmp_path / "frame", *options, "--count", 1_000_000), tmp_path).good()
    (sample,), (frame,) = cells_of(tmp_path / "sample"), cells_of(tmp_path / "frame")

    low, high = sample["ci95"]
    assert low < frame["mrays_per_s"] < high
    assert low < sample["mrays_per_s"] < high
    assert frame["ci95"] is None and frame["switches"]["whole_frame"]
    assert sample["rays"] < frame["rays"] / 4


def test_make_bench_takes_its_words(out):
    words = {"SCENES": "cornell", "RAYS": "ao", "N": 1000, "SIZE": "64x64", "MEM": "50,32"}
    make("bench", out, CONFIG="tiny", CORES=2, **words).good()

    (cell,) = cells_of(out)
    assert (cell["cores"], cell["ray_type"], cell["rays"] >= 1000) == (2, "ao", True)
    fixed = {"kind": "fixed", "latency": 50, "bytes_per_cycle": 32, "dram": None}
    assert cell["mem"] == fixed
    assert all(abs(sum(unit.values()) - 1) < 1e-9 for unit in cell["stalls"].values())


@pytest.mark.parametrize(
    "words",
    [
        {"SCENES": "nowhere"},
        {"RAYS": "primary sideways"},
        {"N": "many"},
        {"N": 10},
        {"SIZE": "64"},
        {"MEM": "slow"},
        {"CORES": 0},
    ],
)
def test_bad_words_are_refused(out, words):
    make("bench", out, CONFIG="tiny", **({"SCENES": "cornell"} | words)).refused(
        *(str(word).split()[-1] for word in words.values())
    )
