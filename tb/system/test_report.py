# SPDX-License-Identifier: Apache-2.0
"""A run leaves the files it promises, and an exit status that says what it found."""

import json

import jsonschema
import numpy as np
import pytest
from agents.program import ROOT, SCENES
from PIL import Image

CORNELL = SCENES / "cornell.gltf"
SCHEMA = json.loads((ROOT / "sw/report/report.schema.json").read_text())
KEYS = {  # a report has at least these, and below some of them at least those
    "config": None,
    "scene": None,
    "triangles": None,
    "rays": None,
    "cycles": None,
    "clock_mhz": None,
    "mrays_per_s": None,
    "rays_per_cycle": None,
    "per_ray": {"steps", "leaves", "tests", "restarts", "dram_bytes"},
    "phase": {"a_tests", "b_share", "c_share"},
    "utilization": {"trv", "list", "ist1", "ist2"},
    "cache": {"trv_l1", "list_l1", "ist1_l1"},
    "check": {"model_mismatches", "truth_unexplained", "lost", "duplicated"},
    "sim": {"seconds", "cycles_per_s", "rays_per_s"},
}


def picture(run):
    return np.asarray(Image.open(run.out / "image.png").convert("RGB")).astype(int)


@pytest.mark.parametrize("name", ["rtl", "model", "embree"])
def test_the_report_has_every_key_whatever_the_engine(tiny, out, name):
    options = ["--size", "12x8", "--effects", "none"]
    report = tiny.render(out, CORNELL, *options, engine=name).good().report

    jsonschema.validate(report, SCHEMA)
    for key, below in KEYS.items():
        assert key in report
        if below and (name == "rtl" or key != "cache"):  # only the RTL has caches
            assert below <= set(report[key]), key
    assert (report["config"], report["scene"], report["engine"]) == ("tiny", "cornell", name)
    assert (report["triangles"], report["rays"]) == (38, 96)


def test_two_runs_of_a_command_give_one_report_but_for_times(ti, tiny, tmp_path):
    for name, program in {"rtl": tiny, "model": ti}.items():
        a, b = (
            program.trace(tmp_path / name / x, CORNELL, "inside:400", "--waves", 3).good().report
            for x in "ab"
        )
        for report in (a, b):
            jsonschema.validate(report, SCHEMA)
            del report["sim"], report["time"]
        assert a == b


def test_a_report_says_what_it_was_made_from(tiny, tmp_path, out):
    options = ["--size", "20x10", "--spp", 2, "--seed", 7, "--stall-seed", 3, "--effects", "none"]
    config = tiny.with_keys(tmp_path, layout="dfl")
    report = tiny.render(out, CORNELL, *options, config=config).good().report

    made = report["provenance"]
    assert made["commit"] and (made["command"], made["scene"]) == ("render", "cornell.gltf")
    assert (made["size"], made["spp"], made["seed"]) == ([20, 10], 2, 7)
    assert (made["layout"], made["waves"]) == ("dfl", 2)  # a wave a sample
    assert report["keys"] == json.loads(config.read_text())
    assert report["switches"]["stall_seed"] == 3 and report["switches"]["lock_step"]
    assert 0 < report["hits"] <= report["rays"] == 400


def test_steps_and_tests_of_each_ray_add_up_to_those_of_the_machine(engine, out):
    run = engine.render(out, CORNELL, "--size", "32x24", "--dump").good()
    steps, tests = (np.load(out / f"{name}.npy").astype(int) for name in ("steps", "tests"))

    report = run.report
    assert steps.sum() == round(report["per_ray"]["steps"] * report["rays"])
    assert tests.sum() == report["phase"]["a_tests"]
    assert report["spread"]["steps"]["max"] == steps.max()
    for name, counts in {"steps": steps, "tests": tests}.items():
        colours = np.asarray(Image.open(out / f"{name}.png").convert("RGB"))
        assert colours.shape == (24, 32, 3)
        assert len(np.unique(colours.reshape(-1, 3), axis=0)) > 3, name
        assert counts.max() > counts.min()


def test_the_figures_of_a_report_agree_with_one_another(engine, stored, out):
    report = engine.trace(out, stored, "random:600").good().report

    rays, cycles, work = report["rays"], report["cycles"], report["per_ray"]
    assert report["rays_per_cycle"] == pytest.approx(rays / cycles)
    assert report["mrays_per_s"] == pytest.approx(report["rays_per_cycle"] * report["clock_mhz"])
    assert report["phase"]["a_tests"] == round(work["tests"] * rays)
    assert 0 <= report["phase"]["c_share"] <= report["phase"]["b_share"] <= 1
    assert all(0 < share <= 1 for share in report["utilization"].values())
    for cache in report["cache"].values():
        assert cache["accesses"] == cache["hits"] + cache["merged"] + cache["misses"]
    caches = report["cache"].values()
    lines = sum(cache["misses"] for cache in caches)
    assert work["dram_bytes"] * rays == pytest.approx(64 * lines)
    assert report["cache"]["trv_l1"]["accesses"] == round(work["steps"] * rays)
    passes = report["phase"]["a_tests"] * (1 + report["phase"]["b_share"])
    assert report["cache"]["list_l1"]["accesses"] == report["phase"]["a_tests"]
    assert report["cache"]["ist1_l1"]["accesses"] == round(passes)


def test_a_picture_looks_the_same_from_every_engine(tiny, tmp_path):
    rtl, model, embree = (
        picture(tiny.render(tmp_path / name, CORNELL, "--size", "48x48", engine=name).good())
        for name in ("rtl", "model", "embree")
    )

    assert (rtl == model).all()
    assert (abs(rtl - embree).max(axis=2) > 2).mean() < 0.01
    assert rtl.shape == (48, 48, 3)
    left, right = rtl[24, 3], rtl[24, -4]  # a red and a green wall
    assert left[0] > left[1] + 30 and right[1] > right[0] + 30


def test_more_samples_smooth_the_edges_and_count_as_rays(tiny, tmp_path):
    one, four = (
        tiny.render(
            *(tmp_path / f"{spp}", CORNELL, "--size", "16x16", "--spp", spp),
            *("--effects", "none", "--dump"),
        ).good()
        for spp in (1, 4)
    )

    assert (one.report["rays"], four.report["rays"]) == (256, 1024)
    assert len(four.prims) == len(np.load(four.out / "rays.npy")) == 1024
    assert picture(one).shape == picture(four).shape
    assert 0 < abs(picture(one) - picture(four)).mean() < 20


def test_two_samples_are_the_models_too(ti, tiny, tmp_path):
    options = ["--size", "16x16", "--spp", 2, "--dump"]
    rtl = tiny.render(tmp_path / "rtl", CORNELL, *options).good()
    model = ti.render(tmp_path / "model", CORNELL, *options).good()

    for name in ("image.png", "rays.npy", "hits.npy", "prims.npy"):
        assert rtl.read(name) == model.read(name)


@pytest.mark.parametrize(("name", "hits"), [("empty.ply", False), ("one_triangle.obj", True)])
def test_the_least_scenes_are_rendered(engine, out, name, hits):
    run = engine.render(out, SCENES / name, "--size", "24x24", "--dump").good()

    assert (run.prims >= 0).any() == hits
    assert len(np.unique(picture(run).reshape(-1, 3), axis=0)) > 1 if hits else True


def test_only_what_was_asked_for_is_written(ti, tmp_path):
    ti.render(tmp_path / "a", CORNELL, "--size", "4x4").good()
    ti.render(tmp_path / "b", CORNELL, "--size", "4x4", "--dump").good()
    ti.trace(tmp_path / "c/deep", CORNELL, "random:4").good()

    names = [{path.name for path in (tmp_path / x).iterdir()} for x in ("a", "b", "c/deep")]
    arrays = ("radiance", "rays", "hits", "prims", "steps", "tests")
    assert names[0] == {"image.png", "radiance.exr", "steps.png", "tests.png", "report.json"}
    assert names[1] == names[0] | {f"{x}.npy" for x in arrays}
    assert names[2] == {"report.json", "hits.npy", "prims.npy"}


def other_config(program, folder, key, value):
    """The configuration of a program with another value, for the model alone to follow."""
    keys = json.loads(program.config.read_text())
    if program.library:  # whose copy then says that it has the value
        said, lie = (f'"{key}": {x},'.encode() for x in (keys[key], value))
        lie = lie.ljust(len(said))
        whole = program.library.read_bytes()
        assert whole.count(said) == 1
        (folder / "libti_rtl.so").write_bytes(whole.replace(said, lie))
    path = folder / "config.json"
    path.write_text(json.dumps(keys | {key: value}))
    return path


@pytest.mark.parametrize(
    ("key", "value", "says"), [("stack_depth", 1, "restarts"), ("watchdog_steps", 12, "status 3")]
)
def test_lock_step_finds_a_machine_that_is_not_the_model(tiny, tmp_path, out, key, value, says):
    config = other_config(tiny, tmp_path, key, value)
    options = ["--no-truth", "--rtl", tmp_path / "libti_rtl.so"]
    run = tiny.trace(out, CORNELL, "random:1000", *options, config=config).failed_its_checks()

    check = run.report["check"]
    assert 0 < check["model_mismatches"] < 1000
    assert check["work_differs"]
    assert f"{check['model_mismatches']} mismatches in 1000 rays" in run.stdout
    assert "DIFFERS" in run.stdout and "ray " in run.stdout and says in run.stdout


def test_lock_step_finds_it_in_hard_cases_too(tiny, tmp_path):
    config = other_config(tiny, tmp_path, "watchdog_steps", 1)
    file = SCENES / "hardcases.jsonl"
    options = ["--file", file, "--rtl", tmp_path / "libti_rtl.so"]
    run = tiny.run("hardcases", "--engine", "rtl", *options, config=config)

    assert "0 mismatches" not in run.failed_its_checks().stdout.splitlines()[-1]


def test_lock_step_is_off_only_by_name(tiny, tmp_path, out):
    config = other_config(tiny, tmp_path, "stack_depth", 1)
    options = ["--no-lock-step", "--rtl", tmp_path / "libti_rtl.so"]
    run = tiny.trace(out, CORNELL, "random:1000", *options, config=config).good()

    assert not run.report["check"]["lock_step"]
    assert run.report["check"]["model_mismatches"] is None
    assert "not compared" in run.stdout


def test_a_ray_that_the_watchdog_ends_fails_the_run(ti, tmp_path, out):
    config = other_config(ti, tmp_path, "watchdog_steps", 3)
    run = ti.trace(out, CORNELL, "random:300", "--no-truth", config=config).failed_its_checks()

    count = run.report["check"]["status"]["watchdog"]
    assert 0 < count < 300
    assert f"{count} of 300 rays were ended by the watchdog" in run.stdout


def test_the_step_logs_of_model_and_rtl_are_the_same(tiny, out):
    tiny.trace(out, CORNELL, "inside:20", "--log-ray", 13).good()
    model, rtl = ((out / f"ray-13.{who}.log").read_text() for who in ("model", "rtl"))

    assert rtl == model
    assert model.startswith("node 0 ") and " leaf " in model.splitlines()[-1]
