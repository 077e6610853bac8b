# SPDX-License-Identifier: Apache-2.0
"""Through registers, streams and the driver come the engine's hits and pictures, bit for bit."""

import configure
import pytest
from agents.program import SCENES, Program, make

CORNELL = SCENES / "cornell.gltf"


@pytest.mark.parametrize("rays", ["random:2000", "shadow:1000", "primary:100"])
@pytest.mark.parametrize("stalls", [(), ("--stall-seed", 3, "--stall-share", 0.5)])
def test_hits_are_those_of_the_engine(tiny, top, images, tmp_path, rays, stalls):
    scene = images(CORNELL)
    engine = tiny.trace(tmp_path / "engine", scene, rays).good()
    driven = top.trace(tmp_path / "top", scene, rays, *stalls).good()

    assert driven.read("hits.npy") == engine.read("hits.npy")
    assert driven.read("prims.npy") == engine.read("prims.npy")
    assert driven.report["per_ray"]["steps"] == engine.report["per_ray"]["steps"]
    assert driven.report["check"]["model_mismatches"] == 0


def test_pictures_are_those_of_the_engine(tiny, top, tmp_path):
    size = ("--size", "24x16", "--spp", 1, "--dump")
    engine = tiny.render(tmp_path / "engine", CORNELL, *size).good()
    driven = top.render(tmp_path / "top", CORNELL, *size).good()

    assert driven.read("radiance.npy") == engine.read("radiance.npy")
    assert driven.read("image.png") == engine.read("image.png")


def test_its_cycles_are_those_of_the_engine(tiny, top, images, tmp_path):
    """A packet begins with writes to registers and drains at its end: no more than that."""
    scene = images(CORNELL)
    engine = tiny.trace(tmp_path / "engine", scene, "random:2000").good().report["cycles"]
    driven = top.trace(tmp_path / "top", scene, "random:2000").good().report["cycles"]
    assert abs(driven - engine) < 0.01 * engine + 100


def test_memory_errors_end_rays_with_their_status(top, images, tmp_path):
    run = top.trace(tmp_path / "top", images(CORNELL), "random:500", "--error-every", 40)
    assert run.failed_its_checks().report["check"]["status"]["memory_error"] > 0
    assert run.report["rays"] == 500


def test_a_library_of_another_configuration_is_refused(top, tiny_with, out):
    other = Program(configure.load("tiny", ["stack_depth=2"]).folder.name)
    make("config", CONFIG="tiny", SET="stack_depth=2")
    top.trace(out, CORNELL, "random:10", config=other.config).refused("stack_depth 4 and not 2")


def test_what_it_has_not_is_refused(top, out):
    top.trace(out, CORNELL, "random:10", "--log-ray", 3).refused("LOG_RAY=", "ENGINE=rtl")


@pytest.mark.parametrize("command", ["hardcases", "hardcase ID=1"])
def test_hard_cases_are_of_the_engine_itself(command):
    target, *words = command.split()
    make(target, ENGINE="top", **dict(w.split("=") for w in words)).refused("ENGINE=top")
