# SPDX-License-Identifier: Apache-2.0
"""The Makefile does what its help says, and names in one sentence what it cannot do."""

import os
import shutil

import numpy as np
import pytest
from agents.program import ROOT, SCENES, call, make

TINY = {"CONFIG": "tiny"}
MODEL = TINY | {"ENGINE": "model"}
BAD = {  # target, variables, words of the sentence
    "no-such-scene": ("trace", MODEL | {"RAYS": "random:9", "SCENE": "nowhere"}, ["nowhere"]),
    "no-rays": ("trace", MODEL, ["RAYS="]),
    "no-such-engine": (
        "render",
        TINY | {"ENGINE": "gpu"},
        ["ENGINE=gpu", "rtl, top, board, model and embree"],
    ),
    "no-such-config": ("render", {"CONFIG": "huge"}, ["huge", "paper, small, tiny"]),
    "no-ways": ("render", TINY | {"SET": "trv_l1_ways=0"}, ["trv_l1_ways is 0", "from 1 to 16"]),
    "odd-cache": ("render", TINY | {"SET": "trv_l1_bytes=1000"}, ["trv_l1_bytes is 1000"]),
    "unknown-key": ("render", TINY | {"SET": "num_rays=7"}, ["num_rays", "did you mean num_trv?"]),
    "short-range": ("render", TINY | {"SET": "exp_bits=4"}, ["exp_bits is 4", "23", "6 or more"]),
    "short-addresses": ("render", TINY | {"SET": "addr_bits=20"}, ["addr_bits is 20", "21"]),
    "odd-config": ("render", {"CONFIG": "it's (not) #1 $a"}, ["it's (not) #1 $a: no such"]),
    "odd-set": ("render", TINY | {"SET": "num_trv=$(a);'b"}, ["num_trv is $(a);'b, but"]),
    "odd-engine": ("render", TINY | {"ENGINE": "it's"}, ["ENGINE=it's: no such engine"]),
    "odd-scene": (
        "trace",
        MODEL | {"RAYS": "random:9", "SCENE": "it's (not) #1"},
        ["it's (not) #1"],
    ),
    "no-number": ("render", TINY | {"SET": "num_trv=many"}, ["num_trv is many"]),
    "size": ("render", MODEL | {"SIZE": "0x0"}, ["SIZE=0x0"]),
    "effects": ("render", MODEL | {"EFFECTS": "glow"}, ["EFFECTS=glow"]),
    "cases": ("hardcases", MODEL | {"FILE": "none.jsonl"}, ["none.jsonl"]),
    "format": ("testfloat", {"FORMAT": "9,99", "OP": "add", "FILE": "x"}, ["FORMAT=9,99", "8,23"]),
    "format-word": ("testfloat", {"FORMAT": "half", "OP": "add", "FILE": "x"}, ["FORMAT=half"]),
    "no-file": ("testfloat", {"OP": "add"}, ["FILE="]),
    "no-operation": ("testfloat", {"FILE": "x"}, ["OP="]),
    "unknown-operation": ("testfloat", {"FORMAT": "5,10", "OP": "fma", "FILE": "x"}, ["fma"]),
    "no-unit": ("sim", {}, ["UNIT="]),
    "unknown-unit": ("sim", {"UNIT": "ti_gpu"}, ["ti_gpu", "ti_fifo"]),
    "image-of-nothing": ("image", TINY | {"SCENE": "nowhere"}, ["nowhere"]),
}
WRITES = {"render", "trace", "image"}


@pytest.mark.usefixtures("ti")
@pytest.mark.parametrize("case", BAD)
def test_what_cannot_be_done_is_refused(out, case):
    target, variables, words = BAD[case]

    make(target, out if target in WRITES else None, **variables).refused(*words)


@pytest.mark.parametrize(
    "change", ["num_trv=0", "num_trv=many", "num_rays=7", "exp_bits=4", "addr_bits=20"]
)
def test_a_wrong_configuration_is_refused_before_anything_is_built(change):
    run = make("engine", SET=change, **TINY)
    run.refused(change.split("=")[0])
    assert run.stdout == ""


@pytest.mark.usefixtures("tiny")
def test_render_traces_on_the_rtl_and_writes_a_picture(out):
    run = make("render", out, SCENE="cornell", SIZE="16x16", EFFECTS="none", DUMP=1, **TINY).good()

    dumped = {"rays.npy", "hits.npy", "prims.npy"}
    assert dumped | {"image.png", "report.json"} <= {path.name for path in out.iterdir()}
    assert (run.report["engine"], run.report["config"], run.report["rays"]) == ("rtl", "tiny", 256)
    assert "0 mismatches in 256 rays" in run.stdout and "0 unexplained" in run.stdout


@pytest.mark.usefixtures("tiny")
def test_trace_takes_rays_and_an_engine(tmp_path):
    rays = np.tile(np.float32([0.278, 0.273, -0.8, 0, 0, 0, 1, np.inf]), (7, 1))
    np.save(tmp_path / "rays.npy", rays)
    runs = {
        engine: make(
            "trace", tmp_path / engine, RAYS=tmp_path / "rays.npy", ENGINE=engine, **TINY
        ).good()
        for engine in ("rtl", "model", "embree")
    }

    assert runs["rtl"].read("hits.npy") == runs["model"].read("hits.npy")
    assert runs["rtl"].read("prims.npy") == runs["model"].read("prims.npy")
    assert (runs["embree"].prims == runs["model"].prims).all()
    assert {name: run.report["engine"] for name, run in runs.items()} == {n: n for n in runs}
    assert all(run.report["rays"] == 7 for run in runs.values())


@pytest.mark.usefixtures("ti")
def test_image_writes_what_trace_takes(tmp_path):
    file = tmp_path / "cornell.tiim"
    make("image", OUT=file, **MODEL).good()
    named = MODEL | {"RAYS": "random:50"}
    built = make("trace", tmp_path / "built", **named).good()
    stored = make("trace", tmp_path / "stored", IMAGE=file, **named).good()

    assert stored.read("hits.npy") == built.read("hits.npy")
    file.write_bytes(file.read_bytes()[:-1])
    make("trace", tmp_path / "cut", IMAGE=file, **named).refused("cornell.tiim", "damaged")


@pytest.mark.usefixtures("ti")
@pytest.mark.parametrize("name", ["one_triangle", "one_triangle.obj", "scenes/one_triangle.obj"])
def test_a_scene_is_found_by_name_file_and_path(out, name):
    run = make("trace", out, SCENE=name, RAYS="random:20", **MODEL).good()

    assert (run.report["scene"], run.report["triangles"]) == ("one_triangle", 1)


@pytest.mark.usefixtures("tiny")
def test_hard_cases_run_on_model_and_rtl(tmp_path):
    lines = (SCENES / "hardcases.jsonl").read_text().splitlines()
    (tmp_path / "few.jsonl").write_text("\n".join(lines[:5]) + "\n")

    for file, count in [(None, len(lines)), (tmp_path / "few.jsonl", 5)]:
        run = make("hardcases", **TINY, **({"FILE": file} if file else {})).good()
        assert run.stdout.count(f"{count} cases, 0 failed") == 2
        assert run.stdout.count("0 mismatches between RTL and model") == 1


def test_testfloat_replays_lines_and_finds_a_wrong_one(tmp_path):
    file = tmp_path / "lines.txt"
    file.write_text("3C00 3C00 4000 00\n3C00 BC00 0000 00\n7C00 FC00 FE00 10\n")
    named = {"OP": "add", "FORMAT": "5,10", "FILE": file}
    run = make("testfloat", **named).good()
    assert "3 lines, 0 model differences, 0 RTL differences" in run.stdout

    file.write_text("3C00 3C00 4000 00\n3C00 3C00 4001 00\n")
    run = make("testfloat", **named)
    assert run.status != 0
    assert "line 2: add 3c00 3c00: file 4001, model 4000, RTL 4000" in run.stdout


def test_help_names_every_target_a_user_types():
    text = make("help").good().stdout

    targets = ["render", "trace", "image", "hardcases", "testfloat", "test", "sim", "waves"]
    for target in [*targets, "engine", "config", "sw"]:
        assert f"make {target} " in text
    assert call(["make"]).stdout == text


def test_help_needs_no_python(tmp_path):
    (tmp_path / "python").write_text("#!/bin/sh\necho python >&2\n")
    (tmp_path / "python").chmod(0o755)
    path = f"{tmp_path}:{os.environ['PATH']}"
    run = call(["env", f"PATH={path}", "make", "help", "CONFIG=nowhere"]).good()

    assert run.stderr == ""


# --- Names ---------------------------------------------------------------------------------------

ODD = "it's a (very) odd, #1 $HOME & co"


@pytest.mark.usefixtures("tiny")
def test_paths_may_have_spaces_and_signs(tmp_path):
    folder = tmp_path / ODD
    folder.mkdir()
    scene, config = folder / "one triangle.obj", folder / "my 'tiny'.yaml"
    rays, cases, image = folder / "rays 'n.npy", folder / "a case.jsonl", folder / "my image.tiim"
    shutil.copy(SCENES / "one_triangle.obj", scene)
    shutil.copy(ROOT / "configs/tiny.yaml", config)
    shutil.copy(SCENES / "hardcases.jsonl", cases)
    np.save(rays, np.tile(np.float32([0, 0, -9, 0, 0, 0, 1, np.inf]), (4, 1)))
    named = {"CONFIG": config, "SCENE": scene, "ENGINE": "model"}

    make("image", OUT=image, **named).good()
    run = make("trace", folder / "my hits", RAYS=rays, IMAGE=image, **named).good()
    assert (run.report["triangles"], run.report["rays"]) == (1, 4)
    run = make("render", folder / "my 'picture'", SIZE="4x4", **named).good()
    assert (run.out / "image.png").is_file()
    make("hardcases", FILE=cases, CONFIG=config, ENGINE="model").good()
    make("testfloat", FORMAT="5,10", OP="add", FILE=folder / "no lines").refused("no lines")


@pytest.fixture
def default_out():
    """A function that removes and gives the folder of outputs that a run without OUT names."""
    made = []

    def find(run):
        folder = ROOT / run.good().stdout.splitlines()[-1].split(": ")[0]
        assert folder.is_dir() and folder.is_relative_to(ROOT / "build"), run.stdout
        made.append(folder)
        return folder

    yield find
    for folder in made:
        shutil.rmtree(folder, ignore_errors=True)


@pytest.mark.usefixtures("ti")
def test_what_differs_has_outputs_of_its_own(default_out, tmp_path):
    for name in ("test v1.2.obj", "test v1.3.obj", "test v1.2.x"):
        shutil.copy(SCENES / "one_triangle.obj", tmp_path / name)
    np.save(tmp_path / "four.npy", np.tile(np.float32([0, 0, -9, 0, 0, 0, 1, np.inf]), (4, 1)))
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        shutil.copy(ROOT / "configs/tiny.yaml", tmp_path / folder / "mine.yaml")

    def folder(scene="test v1.2.obj", rays="random:5", **variables):
        named = MODEL | {"SCENE": tmp_path / scene, "RAYS": rays} | variables
        return default_out(make("trace", **named))

    names = [
        folder(),
        folder("test v1.3.obj"),
        folder(rays="inside:5"),
        folder(rays=tmp_path / "four.npy"),
        folder(SET="num_trv=2"),
        folder(SET="clock_mhz=600"),
        folder(CONFIG=tmp_path / "a/mine.yaml"),
        folder(CONFIG=tmp_path / "b/mine.yaml"),
        folder(ENGINE="embree"),
    ]
    assert len(set(names)) == len(names)
    assert names[0].name == "test v1.2-tiny-model-random-5"
    assert folder(SET="num_trv=1") == names[0]
