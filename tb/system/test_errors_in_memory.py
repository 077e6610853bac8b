# SPDX-License-Identifier: Apache-2.0
"""Whatever the memory answers, every ray comes back once, and only what it spoilt is wrong."""

import pytest
from agents.program import SCENES

CORNELL = SCENES / "cornell.gltf"
SHARES = [2, 7, 50]  # each n-th answer is an error
STALLS = {"no-stalls": [], "stalls": ["--stall-seed", 5]}


@pytest.mark.parametrize("every", SHARES)
@pytest.mark.parametrize("stalls", STALLS)
@pytest.mark.parametrize("rays", ["random:500", "ao:500"])
def test_spoilt_rays_are_misses_and_the_others_right(
    ti, engine, stored, tmp_path, rays, stalls, every
):
    model = ti.trace(tmp_path / "model", stored, rays).good()
    options = ["--error-every", every, *STALLS[stalls]]
    run = engine.trace(tmp_path / "rtl", stored, rays, *options).failed_its_checks()
    check = run.report["check"]

    assert [check[name] for name in ("model_mismatches", "lost", "duplicated")] == [0, 0, 0]
    spoilt = check["status"]["memory_error"]
    assert 0 < spoilt <= len(model.prims) == sum(check["status"].values())
    differ = (run.hits != model.hits).any(axis=1) | (run.prims != model.prims)
    assert (run.prims[differ] == -1).all()
    assert differ.sum() == check["truth_unexplained"] <= spoilt
    assert f"{spoilt} of {len(model.prims)} rays ended with an error of the memory" in run.stdout


def test_a_memory_of_errors_ends_every_ray(engine, tmp_path):
    run = engine.trace(tmp_path / "a", CORNELL, "inside:200", "--error-every", 1)

    status = run.failed_its_checks().report["check"]["status"]
    assert status == {"ok": 0, "invalid_ray": 0, "memory_error": 200, "watchdog": 0}
    assert (run.prims == -1).all()


def test_rare_errors_fail_a_run_even_without_the_truth(tiny, tmp_path):
    run = tiny.trace(tmp_path / "a", CORNELL, "random:500", "--error-every", 100, "--no-truth")

    assert run.failed_its_checks().report["check"]["status"]["memory_error"] > 0
