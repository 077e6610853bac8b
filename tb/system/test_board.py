# SPDX-License-Identifier: Apache-2.0
"""Through files that play a board come the model's hits; what goes wrong on it is one sentence."""

import subprocess

import numpy as np
import pytest
from agents.program import ROOT, SCENES, make

CORNELL = SCENES / "cornell.gltf"


@pytest.fixture
def board(ti, tmp_path):
    """A function that starts the stand-in of a board, with a fault or none, and gives its file."""
    started = []

    def start(*fault):
        process = subprocess.Popen(
            [ROOT / "build/sw/board_stand_in", tmp_path / "board", ti.config, *fault],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        started.append(process)
        return process.stdout.readline().strip()

    yield start
    for process in started:
        process.communicate()
        assert process.returncode == 0


@pytest.mark.parametrize("rays", ["random:2000", "shadow:1000"])
def test_hits_are_those_of_the_model(ti, board, images, tmp_path, rays):
    scene = images(CORNELL)
    model = ti.trace(tmp_path / "model", scene, rays).good()
    through = ["--board", board()]
    driven = ti.trace(tmp_path / "driven", scene, rays, *through, engine="board").good()

    assert driven.read("hits.npy") == model.read("hits.npy")
    assert driven.read("prims.npy") == model.read("prims.npy")
    assert driven.report["engine"] == "board" and driven.report["cycles"] is None
    assert driven.report["check"]["lock_step"] and driven.report["check"]["model_mismatches"] == 0


def test_make_renders_through_it(ti, board, tmp_path):
    size = ("--size", "24x16", "--spp", 1, "--dump")
    model = ti.render(tmp_path / "model", CORNELL, *size).good()
    words = {"ENGINE": "board", "BOARD": board(), "CONFIG": "tiny", "SIZE": "24x16", "DUMP": 1}
    driven = make("render", tmp_path / "driven", **words).good()
    assert driven.read("radiance.npy") == model.read("radiance.npy")


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ("dma", ["uio1: the DMA of the rays stops", "no memory is at an address"]),
        ("silent", ["uio1: the hits do not come"]),
        ("version", ["registers of version 2, the driver those of 1"]),
        ("small", ["udmabuf0: the buffer has 4096 bytes", "make it larger"]),
    ],
)
def test_what_goes_wrong_on_it_is_one_sentence(ti, board, images, out, fault, words):
    through = ["--board", board(fault)]
    ti.trace(out, images(CORNELL), "random:10", *through, engine="board").refused(*words)


def test_no_board_is_one_sentence(ti, out):
    given = {"ENGINE": "board", "CONFIG": "tiny", "RAYS": "random:9"}
    make("trace", out, **given).refused("BOARD= is missing")
    make("trace", out, BOARD="/nowhere.json", **given).refused("/nowhere.json")


def test_what_it_has_not_is_refused(ti, board, out):
    through = ["--board", board(), "--log-ray", 3]
    ti.trace(out, CORNELL, "random:10", *through, engine="board").refused("LOG_RAY=")
    for target in ("hardcases", "gallery"):
        make(target, ENGINE="board").refused("ENGINE=board", "render and trace")


def test_python_drives_it(module, ti, board):
    scene = module.Scene(CORNELL)
    rays = scene.random_rays(500)
    device = module.Device(board=board())
    device.load(scene.image(ti.config))
    answers = device.trace(rays)
    model = module.Engine(scene, ti.config).trace(rays)
    assert answers.hits.tobytes() == model.hits.tobytes()
    assert (np.asarray(answers.prims) == model.prims).all()
