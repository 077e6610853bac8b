# SPDX-License-Identifier: Apache-2.0
"""The RTL gives the model's hits bit for bit, whatever the rays, the scene and the timing."""

import json

import numpy as np
import pytest
from agents.program import SCENES

CORNELL = SCENES / "cornell.gltf"
RAYS = ["random:1000", "inside:500", "primary:900", "ao:1500", "diffuse:500", "shadow:500"]
SLOW = ["--mem-latency", 400, "--mem-bytes-per-cycle", 2]
TIMINGS = {
    "stalls-1": ["--stall-seed", 1],
    "stalls-2": ["--stall-seed", 2, "--stall-share", 0.6],
    "stalls-3": ["--stall-seed", 3, "--stall-share", 0.9],
    "latency-1": ["--mem-latency", 1],
    "slow-memory": SLOW,
    "slow-memory-and-stalls": [*SLOW, "--stall-seed", 4],
}


def same_hits(a, b):
    """Whether two runs wrote the same bytes; with numbers of rays that differ when not."""
    if all(a.read(name) == b.read(name) for name in ("hits.npy", "prims.npy")):
        return True
    differ = (a.hits != b.hits).any(axis=1) | (a.prims != b.prims)
    print(f"rays {np.flatnonzero(differ)[:10]}: {a.command}; {b.command}")
    return False


def same_work(a, b):
    """Whether two runs took the same steps, leaves and tests."""
    known = {key: value for key, value in b.report["per_ray"].items() if key != "dram_bytes"}
    return a.report["phase"] == b.report["phase"] and known.items() <= a.report["per_ray"].items()


def checked(run):
    """A good run in which every ray was compared with the model and the truth."""
    check = run.good().report["check"]
    assert check["lock_step"] and not check["work_differs"]
    counts = ("model_mismatches", "truth_unexplained", "lost", "duplicated")
    assert [check[name] for name in counts] == [0, 0, 0, 0]
    return run


@pytest.mark.parametrize("rays", RAYS)
def test_hits_and_work_are_the_models(ti, engine, stored, tmp_path, rays):
    model = ti.trace(tmp_path / "model", stored, rays).good()
    rtl = checked(engine.trace(tmp_path / "rtl", stored, rays))

    assert same_hits(rtl, model)
    assert same_work(rtl, model)
    assert (model.prims >= 0).any()
    assert rtl.report["check"]["status"]["ok"] == rtl.report["rays"] == len(model.prims)


@pytest.mark.parametrize("timing", TIMINGS)
@pytest.mark.parametrize("rays", ["random:400", "ao:800"])
def test_results_do_not_depend_on_timing(ti, engine, stored, tmp_path, rays, timing):
    model = ti.trace(tmp_path / "model", stored, rays).good()
    rtl = checked(engine.trace(tmp_path / "rtl", stored, rays, *TIMINGS[timing]))

    assert same_hits(rtl, model)
    assert same_work(rtl, model)


def test_memory_settings_have_their_effect(tiny, tmp_path):
    """Without which the test above would show nothing."""
    plain = tiny.trace(tmp_path / "a", CORNELL, "random:200").good()
    for options in TIMINGS.values():
        other = tiny.trace(tmp_path / "b", CORNELL, "random:200", *options).good()
        assert other.report["cycles"] != plain.report["cycles"]
    slow = tiny.trace(tmp_path / "c", CORNELL, "random:200", "--mem-latency", 1000).good()
    assert slow.report["cycles"] > 2 * plain.report["cycles"]


def test_the_same_command_gives_the_same_cycles(tiny, tmp_path):
    options = ["--stall-seed", 7]
    a, b = (tiny.trace(tmp_path / x, CORNELL, "random:200", *options).good() for x in "ab")

    assert a.report["cycles"] == b.report["cycles"]
    assert same_hits(a, b)


def test_the_seed_chooses_the_rays(ti, tmp_path):
    runs = [ti.trace(tmp_path / f"{n}", CORNELL, "random:200", "--seed", n) for n in (1, 2)]

    assert runs[0].good().read("hits.npy") != runs[1].good().read("hits.npy")


def test_the_rays_that_were_made_give_the_same_hits_when_brought(ti, tiny, stored, tmp_path):
    made = ti.trace(tmp_path / "made", stored, "random:500", "--dump").good()
    rays = np.load(tmp_path / "made/rays.npy")
    assert (rays.dtype, rays.shape) == (np.float32, (500, 8))

    assert same_hits(
        checked(tiny.trace(tmp_path / "rtl", stored, tmp_path / "made/rays.npy")), made
    )


def test_both_layouts_give_the_same_hits(ti, tiny, scene, tmp_path):
    odfl = ti.trace(tmp_path / "odfl", scene, "random:1000").good()
    for name, program in [("model", ti), ("rtl", tiny)]:
        config = program.with_keys(tmp_path, layout="dfl")
        dfl = program.trace(tmp_path / name, scene, "random:1000", config=config).good()
        assert dfl.report["provenance"]["layout"] == "dfl"
        assert same_hits(dfl, odfl)
        assert same_work(dfl, odfl)


def test_rays_that_are_not_rays_come_back_as_misses(ti, engine, tmp_path):
    good = [0.3, 0.3, -1, 0, 0, 0, 1, np.inf]
    nan, inf = float("nan"), float("inf")
    changes = [(0, nan), (1, inf), (3, nan), (4, -inf), (6, nan), (7, nan), (6, 0)]
    rays = np.float32([good for _ in range(2 * len(changes))])
    for i, (column, value) in enumerate(changes):
        rays[2 * i + 1, column] = value
    np.save(tmp_path / "rays.npy", rays)
    model = ti.trace(tmp_path / "model", CORNELL, tmp_path / "rays.npy").good()
    rtl = checked(engine.trace(tmp_path / "rtl", CORNELL, tmp_path / "rays.npy"))

    assert same_hits(rtl, model)
    assert list(rtl.prims >= 0) == [True, False] * len(changes)
    assert rtl.report["check"]["status"]["invalid_ray"] == len(changes)
    assert f"{len(changes)} of {len(rays)} rays are invalid" in rtl.stdout


def test_hard_cases_give_what_they_require(ti, engine):
    file = SCENES / "hardcases.jsonl"
    count = len(file.read_text().splitlines())
    model = ti.run("hardcases", "--engine", "model", "--file", file).good()
    rtl = engine.run("hardcases", "--engine", "rtl", "--file", file).good()

    assert f"{count} cases, 0 failed" in model.stdout
    assert rtl.stdout == model.stdout + "0 mismatches between RTL and model\n"


@pytest.mark.parametrize("options", TIMINGS.values(), ids=TIMINGS.keys())
def test_hard_cases_do_not_depend_on_timing(ti, tiny, options):
    file = SCENES / "hardcases.jsonl"
    model = ti.run("hardcases", "--engine", "model", "--file", file).good()
    rtl = tiny.run("hardcases", "--engine", "rtl", "--file", file, *options).good()

    assert rtl.stdout == model.stdout + "0 mismatches between RTL and model\n"


def test_a_hard_case_that_asks_for_what_is_wrong_fails(ti, tmp_path):
    case = json.loads((SCENES / "hardcases.jsonl").read_text().splitlines()[0])
    wrong = case | {"exact_hit": False, "exact_ids": []}
    (tmp_path / "cases.jsonl").write_text(f"{json.dumps(case)}\n{json.dumps(wrong)}\n")

    run = ti.run("hardcases", "--engine", "model", "--file", tmp_path / "cases.jsonl")
    assert "2 cases, 1 failed" in run.failed_its_checks().stdout


def test_only_a_library_that_was_built_for_waves_writes_them(tiny, tmp_path):
    words = ["--file", SCENES / "hardcases.jsonl", "--id", 1, "--out", tmp_path / "steps"]
    words += ["--engine", "rtl", "--waves-file", tmp_path / "ray.fst"]
    run = tiny.run("hardcases", *words)

    assert "built without waves: give WAVES=1" in run.failed_its_checks().stdout
    assert not (tmp_path / "ray.fst").exists()


def test_an_empty_scene_misses_every_ray(ti, engine, tmp_path):
    empty = SCENES / "empty.ply"
    for name, program in [("model", ti), ("rtl", engine)]:
        run = program.trace(tmp_path / name, empty, "random:300").good()
        assert (run.prims == -1).all() and (run.hits == [np.inf, 0, 0]).all()
        assert "every ray misses" in run.stdout


def test_one_triangle_is_hit_where_it_is(ti, engine, tmp_path):
    x, y = (a.ravel() for a in np.meshgrid(np.linspace(-1.1, 1.1, 23), np.linspace(-1.1, 1.1, 23)))
    ones, zeros = np.ones_like(x), np.zeros_like(x)
    columns = [x, y, 3 * ones, zeros, zeros, zeros, -2 * ones, np.inf * ones]
    np.save(tmp_path / "rays.npy", np.stack(columns, axis=1).astype(np.float32))
    file = SCENES / "one_triangle.obj"
    model = ti.trace(tmp_path / "model", file, tmp_path / "rays.npy").good()
    rtl = checked(engine.trace(tmp_path / "rtl", file, tmp_path / "rays.npy"))

    assert same_hits(rtl, model)
    edge = np.minimum(y + 1, (1 - y) / 2 - abs(x))  # 0 on the triangle's outline
    sure = abs(edge) > 1e-3
    assert ((rtl.prims >= 0) == (edge > 0))[sure].all()
    assert (rtl.hits[rtl.prims >= 0, 0] == 1.5).all()


@pytest.mark.parametrize("name", ["utah_teapot"])
def test_a_benchmark_scene_gives_the_models_hits(ti, small, benchmark, images, tmp_path, name):
    scene = images(benchmark(name))
    model = ti.trace(tmp_path / "model", scene, "random:20000", "--no-truth").good()
    rtl = checked(small.trace(tmp_path / "rtl", scene, "random:20000"))

    assert same_hits(rtl, model)
    assert same_work(rtl, model)
