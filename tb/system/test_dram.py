# SPDX-License-Identifier: Apache-2.0
"""Hits are the same whatever the memory; a DRAM takes its time and says what it did."""

import shutil
import subprocess

import jsonschema
import numpy as np
import pytest
from agents.program import ROOT, SCENES, call, make
from test_engine import checked, same_hits, same_work
from test_report import SCHEMA

CORNELL = SCENES / "cornell.gltf"
DRAM = ["--mem", "dram"]
MEMORIES = ["ideal", "fixed", "dram"]


def of_dram(run):
    return run.good().report["memory"]["dram"]


def test_the_binding_of_dramsim3_keeps_its_promises(dram):
    del dram
    run = call(["scripts/build_dram.sh", "make", "dram_tests"])
    assert run.status == 0, run.stderr
    run = call([ROOT / "build/dram/dram_tests"]).good()

    assert "Status: SUCCESS!" in run.stdout


@pytest.mark.parametrize("rays", ["random:400", "ao:800"])
def test_every_memory_gives_the_models_hits(ti, dram, stored, tmp_path, rays):
    model = ti.trace(tmp_path / "model", stored, rays).good()
    cycles = {}
    for memory in MEMORIES:
        run = checked(dram.trace(tmp_path / memory, stored, rays, "--mem", memory))
        assert same_hits(run, model) and same_work(run, model)
        assert run.report["memory"]["kind"] == memory
        cycles[memory] = run.report["cycles"]

    assert cycles["ideal"] < cycles["dram"]
    assert len(set(cycles.values())) == 3


@pytest.mark.parametrize("seed", [1, 2])
def test_stalls_and_answers_out_of_order_change_no_hit(ti, dram, stored, tmp_path, seed):
    model = ti.trace(tmp_path / "model", stored, "inside:500").good()
    options = [*DRAM, "--stall-seed", seed, "--stall-share", 0.6]

    assert same_hits(checked(dram.trace(tmp_path / "rtl", stored, "inside:500", *options)), model)


def test_errors_of_the_memory_spoil_rays_with_a_dram_too(dram, out):
    run = dram.trace(out, CORNELL, "random:500", *DRAM, "--error-every", 7).failed_its_checks()
    check = run.report["check"]

    assert [check[name] for name in ("model_mismatches", "lost", "duplicated")] == [0, 0, 0]
    assert 0 < check["status"]["memory_error"] < 500


def test_make_renders_the_same_picture_with_each_memory(dram, tmp_path):
    del dram
    runs = {
        memory: make("render", tmp_path / memory, CONFIG="tiny", SIZE="24x24", DUMP=1, MEM=memory)
        for memory in [*MEMORIES, "40,16"]
    }
    names = ("hits.npy", "prims.npy", "image.png")

    assert all(run.good().read(n) == runs["dram"].read(n) for run in runs.values() for n in names)
    kinds = {memory: run.report["memory"]["kind"] for memory, run in runs.items()}
    assert kinds == {"ideal": "ideal", "fixed": "fixed", "dram": "dram", "40,16": "fixed"}
    assert " row hits" in runs["dram"].stdout and " row hits" not in runs["ideal"].stdout


def test_a_report_says_what_the_dram_did(dram, out):
    run = dram.trace(out, CORNELL, "inside:2000", *DRAM, "--waves", 4)
    report, figures = run.good().report, of_dram(run)
    jsonschema.validate(report, SCHEMA)

    assert report["memory"]["latency"] is None and report["memory"]["bytes_per_cycle"] is None
    assert figures["cycles"] == 2 * report["cycles"]
    assert figures["bytes"] == 64 * figures["reads"]
    assert figures["bytes"] <= report["per_ray"]["dram_bytes"] * report["rays"] + 1e-3
    assert figures["row_hit_share"] == pytest.approx(figures["row_hits"] / figures["reads"])
    assert figures["bandwidth_share"] == pytest.approx(figures["bytes"] / 128 / figures["cycles"])
    assert 0 < figures["bandwidth_share"] < 1 and figures["queue"] > 0
    assert 7.0 <= figures["latency"] < 100  # CL and a burst are 14 ns, a cycle is 2
    due = 8 * (figures["cycles"] // 3900)
    assert due - 16 <= figures["refreshes"] <= due

    waves = [wave["dram"] for wave in report["waves"]]
    for name in ("cycles", "reads", "row_hits", "bytes", "refreshes"):
        assert sum(wave[name] for wave in waves) == figures[name], name
    assert all(wave["cycles"] > 0 for wave in waves)


def test_the_same_command_takes_the_same_cycles(dram, tmp_path):
    a, b = (dram.trace(tmp_path / x, CORNELL, "random:300", *DRAM).good().report for x in "ab")

    assert (a["cycles"], a["memory"]) == (b["cycles"], b["memory"])


def test_the_clock_of_the_machine_is_beside_that_of_the_dram(dram, tmp_path):
    """Cycles of a slower machine are longer: a read takes fewer of them."""
    text = dram.config.read_text()
    (tmp_path / "slow.json").write_text(text.replace('"clock_mhz": 500', '"clock_mhz": 125'))
    config = {"config": tmp_path / "slow.json"}
    fast = of_dram(dram.trace(tmp_path / "fast", CORNELL, "random:300", *DRAM))
    slow = dram.trace(tmp_path / "slow", CORNELL, "random:300", *DRAM, **config)

    assert of_dram(slow)["cycles"] == pytest.approx(8 * slow.report["cycles"])
    assert of_dram(slow)["latency"] < fast["latency"] / 2


def test_bench_and_python_know_the_dram(dram, tmp_path):
    words = {"SCENES": "cornell", "RAYS": "primary", "N": 1000, "SIZE": "32x32", "MEM": "dram"}
    run = make("bench", tmp_path, CONFIG="tiny", **words).good()
    assert "cornell" in run.stdout

    code = f"""
import sys
sys.path.insert(0, "build/sw/python")
import ti
scene = ti.Scene("scenes/cornell.gltf")
options = dict(library="{dram.library}", memory="dram")
engine = ti.Engine(scene, "{dram.config}", "rtl", **options)
waves = [engine.trace(scene.random_rays(50)).report["memory"] for _ in range(2)]
first, second = (wave["dram"]["reads"] for wave in waves)
print(*(wave["kind"] for wave in waves), 0 < second < first)
try:
    ti.Engine(scene, "{dram.config}", "rtl", library="{dram.library}", memory="tape")
except ValueError as error:
    print(error)
"""
    told = call([ROOT / "build/venv/bin/python", "-c", code]).good().stdout.splitlines()
    assert told[0] == "dram dram True"  # the second wave finds some in the caches
    assert told[1].startswith("MEM=tape") and len(told) == 2


def test_a_dram_writes_no_files_of_its_own(dram, tmp_path):
    out, here = tmp_path / "out", tmp_path / "here"
    here.mkdir()
    words = ["trace", "--config", dram.config, "--rtl", dram.library, "--scene", CORNELL]
    words += ["--rays", "random:50", "--out", out, *DRAM]
    run = subprocess.run([str(w) for w in (dram.path, *words)], cwd=here, check=True)

    assert run.returncode == 0 and not list(here.iterdir())
    assert {path.name for path in out.iterdir()} == {"report.json", "hits.npy", "prims.npy"}
    assert np.load(out / "prims.npy").shape == (50,)


@pytest.mark.usefixtures("ti")
@pytest.mark.parametrize("target", ["render", "trace", "bench"])
@pytest.mark.parametrize("memory", ["nonsense", "100", "1,2,3", "fixed dram", "it's"])
def test_another_memory_is_refused(out, target, memory):
    words = {"CONFIG": "tiny", "RAYS": "random:9" if target == "trace" else "ao"}
    make(target, out, MEM=memory, **words).refused(f"MEM={memory}", "ideal, fixed and dram")


def test_settings_of_a_fixed_memory_are_of_no_other(ti, out):
    for memory in ("ideal", "dram"):
        options = ["--mem", memory, "--mem-latency", 5]
        ti.trace(out, CORNELL, "random:9", *options).refused("--mem-latency", "--mem fixed")
    ti.trace(out, CORNELL, "random:9", "--mem", "tape").refused("tape", "ideal, fixed, dram")


# --- Where the DRAM comes from, with a program that stands for cargo -----------------------------

GOOD = "f9d21c470100df7748909c4db7e326cf18a37ce33015b6596b31cb0873110f8b"
CARGO = """#!/bin/sh
echo fetched >>{folder}/log
mkdir -p vendor/dramsim3-0.2.2/DRAMsim3
echo '{{"files":{{}},"package":"{sum}"}}' >vendor/dramsim3-0.2.2/.cargo-checksum.json
exit {status}
"""


def fetch(folder, cargo=None):
    """`setup.sh --dram` in a folder of its own; `cargo`: its checksum and status, or none."""
    (folder / "bin").mkdir(exist_ok=True)
    (folder / "scripts").mkdir(exist_ok=True)
    shutil.copy2(ROOT / "scripts/setup.sh", folder / "scripts")
    for name in ("bash", "dirname", "flock", "grep", "mkdir", "mv", "rm", "touch"):
        if not (folder / "bin" / name).exists():
            (folder / "bin" / name).symlink_to(shutil.which(name))
    if cargo:
        program = folder / "bin/cargo"
        program.write_text(CARGO.format(folder=folder, sum=cargo[0], status=cargo[1]))
        program.chmod(0o755)
    return subprocess.run(
        ["bash", "scripts/setup.sh", "--dram"],
        cwd=folder,
        env={"PATH": str(folder / "bin"), "HOME": str(folder)},
        capture_output=True,
        text=True,
        check=False,
    )


def refused(run, *words):
    assert run.returncode == 2 and len(run.stderr.splitlines()) == 1, run.stderr
    assert all(word in run.stderr for word in (*words, "MEM=fixed")), run.stderr


def test_without_cargo_a_sentence_names_the_fixed_memory(tmp_path):
    refused(fetch(tmp_path), "MEM=dram", "cargo", "not installed")
    assert not (tmp_path / "build/dram/dramsim3").exists()


def test_the_crate_is_fetched_once_whole_and_as_it_is_known(tmp_path):
    refused(fetch(tmp_path, ("0" * 64, 0)), "another dramsim3-0.2.2")
    refused(fetch(tmp_path, (GOOD, 1)), "could not fetch dramsim3-0.2.2", "build/setup.log")
    assert not (tmp_path / "build/dram/dramsim3").exists()
    for _ in range(2):
        run = fetch(tmp_path, (GOOD, 0))
        assert run.returncode == 0, run.stderr
    assert (tmp_path / "build/dram/dramsim3/DRAMsim3").is_dir()
    assert len((tmp_path / "log").read_text().splitlines()) == 3
