# SPDX-License-Identifier: Apache-2.0
"""Rays in volume, `local` and watertight, in (8,23) and (7,16): no crack that is not known.

Two hundred thousand rays of each kind on the models (secondary ones from the hits of as many), or
`make test TEST=volume N=...`; two thousand on the RTL of each machine.

The model is the RTL bit for bit, and rays are made and judged by arithmetic that is the same on
every processor, so counts are exact: one that differs is a change of what the machine does.
"""

import json
import math
import os

import pytest
from agents.program import SCENES, call
from scenes.ply import ply_bytes

from scenes import closed

KINDS = ["uniform", "edges", "vertices", "grazing", "far", "secondary"]
WATERTIGHT = ["triangle_test=woop", "traversal=padded"]
SHORT = ["exp_bits=7", "frac_bits=16"]
MACHINES = {
    ("8,23", "local"): [],
    ("8,23", "woop"): WATERTIGHT,
    ("7,16", "local"): SHORT,
    ("7,16", "woop"): [*SHORT, *WATERTIGHT],
}
USUAL = 200_000
# Of so many rays of seed 1 with `local`, in the order of KINDS.
CRACKS = {"8,23": [0, 6758, 518, 1, 9234, 0], "7,16": [2, 5762, 3104, 4, 10514, 1]}
COUNT = int(os.environ.get("N") or USUAL)
RTL_RAYS = 2_000


@pytest.fixture(scope="module")
def ball(tmp_path_factory):
    """A closed mesh of 320 triangles, small so that walks are short."""
    path = tmp_path_factory.mktemp("mesh") / "ball.ply"
    path.write_bytes(ply_bytes(*closed.icosphere(2)))
    return path


@pytest.fixture(scope="module")
def counted(ti, ball, tmp_path_factory):
    """Points by format, test and kind of rays."""
    out = tmp_path_factory.mktemp("volumes") / "out"
    run = call([ti.path, "ladder", "--config", ti.config, "--file", SCENES / "hardcases.jsonl",
                "--scene", ball, "--formats", "8,23 7,16", "--tests", "local woop",
                "--count", COUNT, "--out", out], out)  # fmt: skip
    assert run.status in (0, 1), run
    points = [json.loads(line) for line in run.read("hardcases.json").decode().splitlines()]
    return {(p["format"], p["test"], p["rays"]): p for p in points if "rays" in p}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("machine", MACHINES, ids="-".join)
def test_a_volume_on_the_model(counted, machine, kind):
    point = counted[(*machine, kind)]
    cracks = point["cracks"]["count"]

    if kind != "secondary":  # one from each hit
        assert point["traced"] == COUNT
    assert point["failed"]["count"] == point["self_hits"]["count"] == 0
    if machine[1] == "woop":
        assert cracks == 0
        return
    known = CRACKS[machine[0]][KINDS.index(kind)]
    if COUNT == USUAL:
        assert cracks == known
    else:  # Poisson counts, both of them uncertain
        scale = COUNT / USUAL
        sigma = math.sqrt((known + 1) * scale * (1 + scale))
        assert abs(cracks - known * scale) <= 5 * sigma


@pytest.mark.parametrize("machine", MACHINES, ids="-".join)
def test_a_volume_on_the_rtl(tiny_with, ball, tmp_path, machine):
    """Lock-step with the model; no hit that exact arithmetic and the bounds leave unexplained."""
    program = tiny_with(MACHINES[machine])
    for kind in KINDS:
        options = ["--mem", "ideal"]  # a quarter of the cycles
        run = program.trace(tmp_path / kind, ball, f"{kind}:{RTL_RAYS}", *options).good()
        check = run.report["check"]
        assert run.report["rays"] == RTL_RAYS
        assert check["lock_step"] and not check["work_differs"]
        counts = ("model_mismatches", "truth_unexplained", "lost", "duplicated")
        assert [check[name] for name in counts] == [0, 0, 0, 0], kind
