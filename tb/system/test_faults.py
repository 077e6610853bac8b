# SPDX-License-Identifier: Apache-2.0
"""Whatever has happened to an image in memory, RTL and model end each ray in the same way."""

import json

import pytest
from agents.program import SCENES

CORNELL = SCENES / "cornell.gltf"
IMAGES, RAYS = 300, 32
MACHINES = {
    "plain": ["watchdog_steps=1000", "read_timeout=1000"],  # circles and lost reads soon end
    "padded": ["triangle_test=woop", "traversal=padded"],
}
NEVER = ("silent", "false_alarm", "mismatches", "lost")


@pytest.mark.parametrize("machine", MACHINES)
def test_rays_on_damaged_images_end_as_on_the_model(tiny_with, tmp_path, machine):
    program = tiny_with(MACHINES[machine])
    out = tmp_path / "a"
    options = ["--images", IMAGES, "--rays", f"inside:{RAYS}", "--no-progress", "--out", out]
    run = program.run("faults", "--engine", "rtl", "--scene", CORNELL, *options)
    assert run.status == 0, run.stdout + run.stderr
    counts = json.loads((out / "faults.json").read_text())["faults"]

    def sum_of(name):
        return sum(count[name] for count in counts)

    assert [sum_of(name) for name in NEVER] == [0, 0, 0, 0]
    assert sum_of("images") == IMAGES
    assert sum_of("rays") == RAYS * (IMAGES - sum_of("refused"))
    assert sum_of("memory_error") > 50
    assert (sum_of("watchdog") > 5) == (machine == "plain")


LATE = {
    "late": ["--late-every", 40],
    "lost": ["--lose-every", 700],  # fewer than there are ids
    "all of it": ["--late-every", 90, "--lose-every", 800, "--error-every", 50],
}


@pytest.mark.parametrize("stalls", [[], ["--stall-seed", 5]], ids=["no-stalls", "stalls"])
@pytest.mark.parametrize("faults", LATE)
def test_rays_whose_answers_do_not_come_say_so_and_the_others_are_right(
    ti, tiny_with, tmp_path, faults, stalls
):
    rays = "inside:2000"
    model = ti.trace(tmp_path / "model", CORNELL, rays).good()
    options = ["--mem-latency", 20, *LATE[faults], *stalls]
    program = tiny_with(MACHINES["plain"])
    run = program.trace(tmp_path / "a", CORNELL, rays, *options).failed_its_checks()
    check = run.report["check"]
    assert [check[name] for name in ("model_mismatches", "lost", "duplicated")] == [0, 0, 0]
    spoilt = check["status"]["memory_error"]
    assert 0 < spoilt < 1000
    differ = (run.hits != model.hits).any(axis=1) | (run.prims != model.prims)
    assert differ.sum() <= spoilt and (run.prims[differ] == -1).all()


def test_a_memory_that_answers_nothing_ends_every_ray(tiny_with, tmp_path):
    program = tiny_with(MACHINES["plain"])
    run = program.trace(tmp_path / "a", CORNELL, "inside:300", "--lose-every", 1)
    status = run.failed_its_checks().report["check"]["status"]
    assert status == {"ok": 0, "invalid_ray": 0, "memory_error": 300, "watchdog": 0}


def test_bits_that_are_wrong_lose_no_ray(tiny_with, tmp_path):
    program = tiny_with(MACHINES["plain"])
    options = ["--spoil-every", 20, "--no-truth"]
    run = program.trace(tmp_path / "a", CORNELL, "inside:2000", *options).failed_its_checks()
    check = run.report["check"]
    assert [check[name] for name in ("lost", "duplicated")] == [0, 0]
    assert check["model_mismatches"] > 0


def test_answers_that_never_come_ask_for_a_time_out(tiny, tmp_path):
    run = tiny.trace(tmp_path / "a", CORNELL, "inside:10", "--lose-every", 3)
    run.refused("read_timeout")


def test_a_part_of_a_campaign_is_that_part(ti, tmp_path):
    def campaign(name, first, images):
        out = tmp_path / name
        options = ["--images", images, "--first", first, "--rays", "inside:8", "--no-progress"]
        ti.run("faults", "--engine", "model", "--scene", CORNELL, *options, "--out", out).good()
        return json.loads((out / "faults.json").read_text())["faults"]

    def added(a, b):
        return {key: a[key] + b[key] if key != "fault" else a[key] for key in a}

    parts = zip(campaign("a", 0, 70), campaign("b", 70, 130), strict=True)
    assert [added(a, b) for a, b in parts] == campaign("c", 0, 200)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--rays", "rays.npy"], "KIND:COUNT"),
        (["--rays", "inside:0"], "inside:0"),
        (["--rays", "inside:8", "--images", "0"], "--images"),
        (["--rays", "inside:8", "--engine", "embree"], "model"),
    ],
    ids=["file", "no-rays", "no-images", "embree"],
)
def test_a_campaign_that_cannot_be_is_refused(ti, tmp_path, options, says):
    engine = [] if "--engine" in options else ["--engine", "model"]
    words = [*engine, "--scene", CORNELL, "--out", tmp_path / "a", *options]
    run = ti.run("faults", *words)
    run.refused(says)
    assert not (tmp_path / "a").exists()
