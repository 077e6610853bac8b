# SPDX-License-Identifier: Apache-2.0
"""`scripts/merit.py` divides what was measured, says why a clock is missing, never guesses one."""

import json
import subprocess
import sys

import pytest
from agents.bench import ROOT
from bench import SCHEMA, sha256
from configure import load
from merit import PUBLISHED, clock_of, misfit, with_merit
from synthesis import configuration_hash

SCENE = ROOT / "scenes/cornell.gltf"
FPGA = {"LUT": 40000, "FF": 30000, "DSP": 100, "BRAM": 20, "LUTRAM": 10000, "seconds": 1}
CELLS = {"gate_equivalents": 500000, "FF": 30000, "mm2_65nm": 2.0, "seconds": 1}


def merit(out, *words, config="tiny"):
    """Run the script; the finished process."""
    command = [sys.executable, ROOT / "scripts/merit.py", "--config", config, "--out", out, *words]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def stored(folder, areas, clocks, name="tiny", cycles=100_000):
    """Files as the commands write them, of made-up results: words of merit that take them."""
    config = load(name)
    values = {"name": config.name, **config.values}
    head = {"tools": {"pyosys": "0"}, "configuration_hash": configuration_hash(values)}
    memory = {"kind": "fixed", "latency": 100, "bytes_per_cycle": 64.0}
    cell = {"scene": "cornell", "cycles": cycles, "rays": 40000, "mem": memory, "good": True}
    cells = [cell | {"cycles": 1}, cell]
    found = {"area": head | {"units": {"ti_engine": areas}}}
    found["bench"] = {"schema": SCHEMA, "config": values, "cells": cells}
    found["bench"] |= {"scene_sha256": [sha256(SCENE)], "rays": ["ao", "primary"]}
    for device, units in clocks.items():
        timed = {unit: {"median_mhz": mhz, "mhz": {"1": mhz}} for unit, mhz in units.items()}
        found[f"fmax-{device}"] = head | {"part": device, "units": timed}
    files = []
    for what, value in found.items():
        files.append(folder / f"{name}-{what}.json")
        files[-1].write_text(json.dumps(value))
    return ["--scene", SCENE, "--file", *files, "--part", *areas]


def rows_of(out):
    """Rows of the table by part: heading and text."""
    lines = [line for line in (out / "merit.md").read_text().splitlines() if line[:1] == "|"]
    titles, _, *rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    return {row[1]: dict(zip(titles, row, strict=True)) for row in rows}


def test_figures_are_what_was_measured_divided():
    row = {"LUT": 50000, "mm2_65nm": 4.0, "mhz": 100.0, "cycles_per_ray": 2.5}
    found = with_merit(row)
    assert found["mrays_per_s"] == 40
    assert found["mrays_per_s_klut"] == pytest.approx(0.8)
    assert found["mrays_per_s_mm2"] == 10
    assert found["rays_per_kcycle_klut"] == pytest.approx(8)
    assert "mrays_per_s" not in with_merit(row | {"mhz": None})
    assert "mrays_per_s_klut" not in with_merit(row | {"LUT": 0})


def test_the_clock_of_units_is_an_estimate_and_that_of_the_engine_is_not():
    units = {unit: {"median_mhz": mhz, "mhz": {}} for unit, mhz in (("a", 90), ("b", 70))}
    assert clock_of(units) == {"mhz": 70, "of": "b", "seeds": {}, "estimate": True, "units": 2}
    whole = clock_of(units | {"ti_engine": {"median_mhz": 60, "mhz": {}}})
    assert whole["mhz"] == 60 and "estimate" not in whole


def test_what_a_device_has_too_little_of_is_named():
    cells = {"LUT": 90000, "FF": 10, "DSP": 156, "BRAM": 300}
    assert misfit("ecp5", cells) == "does not fit: 90,000 of 83,640 LUT, 300 of 208 BRAM"
    assert misfit("ecp5", cells | {"LUT": 83640, "BRAM": 208}) is None
    assert misfit("osu018", {"FF": 10}) is None


def test_a_row_takes_area_clock_and_cycles_together(tmp_path):
    clocks = {"ecp5-85k-6": {"ti_engine": 50.0}, "osu018": {"ti_trv": 200.0, "ti_list": 150.0}}
    words = stored(tmp_path, {"ecp5": FPGA, "xcup": FPGA, "osu018": CELLS}, clocks)
    done = merit(tmp_path / "out", *words)
    assert done.returncode == 0, done.stderr
    rows = rows_of(tmp_path / "out")

    ecp5 = rows["ecp5"]
    assert (ecp5["LUT"], ecp5["MHz"], ecp5["cycles a ray"]) == ("50,000", "50.0", "2.50")
    assert (ecp5["Mrays/s"], ecp5["Mrays/s per kLUT"]) == ("20.000", "0.4000")
    # Nothing open times this part: cycles, but nothing that has a clock in it.
    assert rows["xcup"]["MHz"] == "no open tool times it"
    assert rows["xcup"]["rays per kcycle and kLUT"] == "8.000"
    assert rows["xcup"]["Mrays/s"] == rows["xcup"]["Mrays/s per kLUT"] == ""
    cells = rows["osu018"]
    assert (cells["MHz"], cells["Mrays/s"]) == ("estimate 150.0", "estimate 60.000")
    assert cells["Mrays/s per mm2"] == "estimate 30.000"

    text = (tmp_path / "out/merit.md").read_text()
    assert "tiny, osu018: estimate: ti_list, slowest of 2 units timed alone." in text
    assert "tiny, ecp5: timed whole on ecp5-85k-6, seeds: 1." in text
    assert text.count("40,000 primary rays of cornell, memory fixed, 100 cycles, 64 bytes") == 1
    value = json.loads((tmp_path / "out/merit.json").read_text())
    assert [row["part"] for row in value["rows"]] == ["ecp5", "xcup", "osu018"]
    assert value["rows"][0]["mrays_per_s"] == 20
    assert value["tools"] == [{"pyosys": "0"}]


def test_published_engines_stand_beside_with_what_differs(tmp_path):
    done = merit(tmp_path, *stored(tmp_path, {"xcup": FPGA}, {}))
    assert done.returncode == 0, done.stderr
    rows = rows_of(tmp_path)
    assert rows["65 nm"]["mm2 at 65 nm"] == "12.120" and rows["65 nm"]["Mrays/s"] == ""
    assert rows["U55C"]["LUT"] == "67,881"
    assert float(rows["U55C"]["Mrays/s"]) == pytest.approx(297.5 / 67, abs=1e-3)
    text = (tmp_path / "merit.md").read_text()
    assert all(row["differs"] in text for row in PUBLISHED)


def test_an_engine_that_does_not_fit_has_no_clock_but_an_estimate_where_units_were_timed(tmp_path):
    areas = {"ecp5": FPGA | {"LUT": 100000}}
    assert merit(tmp_path, *stored(tmp_path, areas, {})).returncode == 0
    row = rows_of(tmp_path)["ecp5"]
    assert row["MHz"] == "does not fit: 110,000 of 83,640 LUT" and row["Mrays/s"] == ""

    words = stored(tmp_path, areas, {"ecp5-85k-6": {"ti_trv": 80.0}})
    assert merit(tmp_path, *words).returncode == 0
    assert rows_of(tmp_path)["ecp5"]["MHz"] == "estimate 80.0"
    assert "the engine does not fit: 110,000" in (tmp_path / "merit.md").read_text()


@pytest.mark.parametrize(
    "words, said",
    [
        (["--part", "xc9", "--scene", SCENE], "PART=xc9: no such part; there are xcup"),
        (["--part", "xcup", "--scene", "nowhere"], "SCENE=nowhere: there is no such file or scene"),
        (["--part", "xcup", "--scene", SCENE, "--unit", "ti_nothing"], "UNIT=ti_nothing"),
        (["--part", "xcup", "--scene", SCENE, "--file", ROOT / "README.md"], "README.md: no JSON"),
        (["--part", "xcup", "--scene", SCENE, "--count", "5"], "N=5"),
    ],
)
def test_bad_input_ends_in_one_sentence(tmp_path, words, said):
    done = merit(tmp_path, *words)
    assert done.returncode == 2
    assert said in done.stderr and done.stderr.count("\n") == 1, done.stderr


def test_results_of_another_configuration_are_refused(tmp_path):
    done = merit(tmp_path, *stored(tmp_path, {"xcup": FPGA}, {}), config="small")
    assert done.returncode == 2
    assert "it is of another configuration than CONFIG=" in done.stderr
