# SPDX-License-Identifier: Apache-2.0
"""Rays, configurations, settings and cases that make no sense end in one sentence and status 2."""

import json
import os

import numpy as np
import pytest
from agents.program import ROOT, SCENES, Program, call, make

CORNELL = SCENES / "cornell.gltf"
RAYS = np.tile(np.float32([0, 0, -1, 0, 0, 0, 1, np.inf]), (4, 1))


def saved(array, cut=0, more=b""):
    """Write an array, without the last `cut` bytes, with `more` after it."""

    def write(path):
        np.save(path, array)
        data = path.read_bytes()
        path.write_bytes(data[: len(data) - cut] + more)

    return write


BAD_RAYS = {
    "seven-columns": (saved(RAYS[:, :7]), ["(4, 7)", "(N, 8)"]),
    "one-dimension": (saved(RAYS.ravel()), ["(32)", "(N, 8)"]),
    "three-dimensions": (saved(RAYS[None]), ["(1, 4, 8)", "(N, 8)"]),
    "no-dimension": (saved(RAYS[0, 0]), ["()", "(N, 8)"]),
    "float64": (saved(RAYS.astype("<f8")), ["<f8", "<f4"]),
    "int32": (saved(np.zeros((4, 8), "<i4")), ["<i4", "<f4"]),
    "big-endian": (saved(RAYS.astype(">f4")), [">f4", "<f4"]),
    "objects": (saved(np.full((4, 8), None)), ["<f4"]),
    "fortran-order": (saved(np.asfortranarray(RAYS)), ["Fortran"]),
    "no-ray": (saved(RAYS[:0]), ["no ray"]),
    "cut": (saved(RAYS, cut=1), ["cut", "4 rays"]),
    "cut-in-its-header": (saved(RAYS, cut=4 * 32 + 40), ["cut in its header"]),
    "too-long": (saved(RAYS, more=b"\0"), ["1 bytes follow"]),
    "empty": (lambda path: path.write_bytes(b""), [".npy"]),
    "text": (lambda path: path.write_text("0 0 -1 0 0 0 1 1\n"), [".npy"]),
    "folder": (lambda path: path.mkdir(), ["folder"]),
    "missing": (lambda path: None, ["no such file"]),
}

BAD_SETTINGS = {  # command, options, words of the sentence
    "size-0": ("render", ["--size", "0x0"], ["SIZE=0x0", "256x256"]),
    "size-word": ("render", ["--size", "abc"], ["SIZE=abc"]),
    "size-negative": ("render", ["--size=-4x4"], ["SIZE=-4x4"]),
    "size-huge": ("render", ["--size", "99999x1"], ["SIZE=99999x1"]),
    "size-three": ("render", ["--size", "4x4x4"], ["SIZE=4x4x4"]),
    "spp-0": ("render", ["--spp", "0"], ["SPP=0"]),
    "spp-word": ("render", ["--spp", "x"], ["spp"]),
    "effects": ("render", ["--effects", "glow"], ["EFFECTS=glow", "none", "soft-shadows"]),
    "bounces": ("render", ["--bounces", "-1"], ["BOUNCES=-1"]),
    "engine": ("render", ["--engine", "gpu"], ["gpu", "embree, model, rtl"]),
    "engine-number": ("render", ["--engine", "1"], ["embree, model, rtl"]),
    "unknown-option": ("render", ["--frobnicate"], ["frobnicate"]),
    "no-rays": ("trace", [], ["--rays"]),
    "rays-empty": ("trace", ["--rays", ""], ["RAYS="]),
    "rays-0": ("trace", ["--rays", "random:0"], ["RAYS=random:0"]),
    "rays-word": ("trace", ["--rays", "ao:many"], ["RAYS=ao:many"]),
    "rays-unknown": ("trace", ["--rays", "caustic:10"], ["caustic:10", "random, inside, primary"]),
    "rays-unknown-kind": (
        "trace",
        ["--rays", "reflection:10"],
        ["`reflection`", "ao, uniform, diffuse"],
    ),
    "rays-many": ("trace", ["--rays", "random:1000000000"], ["RAYS=random:1000000000", "67108864"]),
    "rays-too-many-digits": ("trace", ["--rays", "ao:99999999999999999999"], ["67108864"]),
    "rays-file": ("trace", ["--rays", "./reflection:10"], ["./reflection:10", "no such file"]),
    "size-times-spp": ("render", ["--size", "8192x8192", "--spp", "2"], ["SPP=2", "2^26"]),
    "log-ray": ("trace", ["--rays", "random:4", "--log-ray", "4"], ["LOG_RAY=4", "4 rays"]),
    "latency-0": ("trace", ["--rays", "random:4", "--mem-latency", "0"], ["--mem-latency"]),
}

BAD_CONFIGS = {
    "missing-key": (lambda keys: keys.pop("stack_depth"), ["`stack_depth` is missing"]),
    "no-units": (lambda keys: keys.update(num_trv=0), ["`num_trv`"]),
    "unknown-format": (lambda keys: keys.update(exp_bits=11, frac_bits=52), ["`exp_bits`"]),
    "a-word": (lambda keys: keys.update(watchdog_steps="many"), ["`watchdog_steps`"]),
    "a-layout": (lambda keys: keys.update(layout="bvh"), ["`layout` must be one of odfl, dfl"]),
    "no-name": (lambda keys: keys.pop("name"), ["`name`"]),
}

CASE = json.loads((SCENES / "hardcases.jsonl").read_text().splitlines()[0])
BAD_CASES = {
    "not-json": ([json.dumps(CASE), '{"n": 2, '], ["line 2", "not JSON"]),
    "a-number": (["7"], ["line 1", "JSON object"]),
    "without-a-rule": ([{k: v for k, v in CASE.items() if k != "rule"}], ["line 1", '"rule"']),
    "unknown-rule": ([CASE | {"rule": "guess"}], ["guess", "exact"]),
    "short-word": ([CASE, CASE | {"tmin": "0"}], ["line 2", '"tmin"']),
    "two-corners": ([CASE | {"tris": [CASE["tris"][0][:2]]}], ["line 1", "three corners"]),
    "id-of-no-triangle": ([CASE | {"exact_ids": [9]}], ["line 1", "exact_ids"]),
    "t-of-no-number": ([CASE | {"exact_t": "1/0"}], ["line 1", "exact_t"]),
    "blank": (["", "  "], ["no case"]),
    "empty": ([], ["no case"]),
}


@pytest.mark.parametrize("case", BAD_RAYS)
def test_bad_rays_are_refused(ti, tmp_path, out, case):
    write, words = BAD_RAYS[case]
    write(tmp_path / "rays.npy")

    ti.trace(out, CORNELL, tmp_path / "rays.npy").refused("rays.npy", *words)


@pytest.mark.parametrize("case", BAD_SETTINGS)
def test_bad_settings_are_refused(ti, out, case):
    command, options, words = BAD_SETTINGS[case]
    words_of_command = [ti.path, command, "--config", ti.config, "--scene", CORNELL, "--out", out]
    if "--engine" not in options:
        words_of_command += ["--engine", "model"]

    call([*words_of_command, *options], out).refused(*words)


@pytest.mark.parametrize("words", [[], ["frobnicate"]])
def test_a_program_without_a_command_says_so(ti, words):
    call([ti.path, *words]).refused()


def test_rays_that_a_scene_cannot_give_are_refused(ti, out):
    for kind in ("ao", "diffuse", "shadow", "edges", "secondary"):
        ti.trace(out, SCENES / "empty.ply", f"{kind}:10").refused(f"RAYS={kind}:10", "no such ray")


@pytest.mark.parametrize("case", BAD_CONFIGS)
def test_an_impossible_configuration_is_refused(ti, tmp_path, out, case):
    change, words = BAD_CONFIGS[case]
    keys = json.loads(ti.config.read_text())
    change(keys)
    config = tmp_path / "config.json"
    config.write_text(json.dumps(keys))

    ti.trace(out, CORNELL, "random:10", config=config).refused("config.json", *words)


@pytest.mark.parametrize("text", ["", "[]", '{"name": ', "\xff"])
def test_a_configuration_that_is_no_json_object_is_refused(ti, tmp_path, out, text):
    config = tmp_path / "config.json"
    config.write_bytes(text.encode("latin-1"))

    ti.trace(out, CORNELL, "random:10", config=config).refused("config.json", "JSON")


def test_a_missing_configuration_is_refused(ti, tmp_path, out):
    ti.trace(out, CORNELL, "random:10", config=tmp_path / "none.json").refused("none.json")


def test_the_rtl_of_another_configuration_is_refused(tiny, tmp_path, out):
    config = tmp_path / "config.json"
    config.write_text(tiny.config.read_text().replace('"num_trv": 1', '"num_trv": 2'))
    run = tiny.trace(out, CORNELL, "random:10", config=config)
    run.refused("num_trv 1 and not 2", "make engine CONFIG=")


def test_what_is_no_library_of_the_rtl_is_refused(tiny, ti, out):
    for library in ("/nowhere/libti_rtl.so", SCENES / "cornell.gltf"):
        tiny.trace(out, CORNELL, "random:10", "--rtl", library).refused("make engine CONFIG=")
    ti.trace(out, CORNELL, "random:10", engine="rtl").refused("make engine CONFIG=")


@pytest.mark.parametrize("command", ["render", "trace"])
def test_a_ray_to_log_that_is_not_there_leaves_nothing(tiny, out, command):
    words = [
        "--log-ray",
        16,
        *(["--size", "4x4", "--effects", "none"] if command == "render" else []),
    ]
    run = tiny.render if command == "render" else tiny.trace
    rays = ["random:16"] if command == "trace" else []
    run(out, CORNELL, *rays, *words).refused("LOG_RAY=16", "16 rays")


def test_an_image_beyond_the_addresses_is_refused(knot, ti, out):
    make("engine", CONFIG="tiny", SET="addr_bits=21").good()
    narrow = Program("tiny-addr_bits-21")
    narrow.trace(out, knot, "random:10").refused("addr_bits", "21")
    narrow.trace(out, CORNELL, "random:10").good()


def test_an_output_that_cannot_be_a_folder_is_refused_before_any_work(ti, tmp_path):
    file = tmp_path / "file"
    file.write_text("mine")
    for place in (file, file / "below"):
        run = ti.trace(place, CORNELL, "random:10")
        assert (run.status, run.stdout) == (2, "")
        assert "folder cannot be made" in run.stderr and len(run.stderr.splitlines()) == 1
    assert file.read_text() == "mine"


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_an_output_without_permission_is_refused(ti, tmp_path):
    tmp_path.chmod(0o500)
    ti.trace(tmp_path / "out", CORNELL, "random:10").refused("permissions")
    tmp_path.chmod(0o700)


@pytest.mark.parametrize("case", BAD_CASES)
def test_bad_hard_cases_are_refused(ti, tmp_path, case):
    lines, words = BAD_CASES[case]
    file = tmp_path / "cases.jsonl"
    texts = [line if isinstance(line, str) else json.dumps(line) for line in lines]
    file.write_text("".join(f"{text}\n" for text in texts))

    run = ti.run("hardcases", "--engine", "model", "--file", file)
    run.refused("cases.jsonl", *words)
    assert run.stdout == ""


def test_hard_cases_that_are_not_there_are_refused(ti, tmp_path):
    for place in (tmp_path / "none.jsonl", tmp_path):
        ti.run("hardcases", "--engine", "model", "--file", place).refused(str(place))


@pytest.fixture(scope="module")
def testfloat():
    """A function that replays a file on the RTL operators of binary16."""
    program = ROOT / "build/fp/5-10/fp_rtl"
    made = call([ROOT / "scripts/build_fp_rtl.sh", 5, 10, program.parent])
    assert made.status == 0, made.stderr
    return lambda file, op: call([program, "--testfloat", file, "--op", op])


@pytest.mark.parametrize(
    ("text", "op", "words"),
    [
        ("3C00 3C00 4000 00\n3C00 4000\n", "add", [":2", "2 words"]),
        ("3C00 3C00 4000 00\n3C00 3C00 4000 00 00\n", "add", [":2", "5 words"]),
        ("3C00 zz 4000 00\n", "add", [":1", "zz"]),
        ("13C00 3C00 4000 00\n", "add", [":1", "13C00", "16 bits"]),
        ("3C00 3C00 2 00\n", "le", [":1", "1 bits"]),
        ("", "add", ["empty"]),
        ("\n \n", "add", ["no lines"]),
        ("3C00 3C00 4000 00\n", "fma", ["fma", "add, sub"]),
    ],
)
def test_a_bad_testfloat_file_is_refused(testfloat, tmp_path, text, op, words):
    file = tmp_path / "lines.txt"
    file.write_text(text)

    testfloat(file, op).refused(*words)


def test_a_testfloat_file_that_is_not_there_is_refused(testfloat, tmp_path):
    for place in (tmp_path / "none.txt", tmp_path):
        testfloat(place, "add").refused(str(place))
