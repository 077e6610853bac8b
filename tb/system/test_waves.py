# SPDX-License-Identifier: Apache-2.0
"""One engine answers wave after wave: same hits, warm caches; and a run can be stopped."""

import resource
import signal
import subprocess

import numpy as np
import pytest
from agents.program import ROOT, SCENES

CORNELL = SCENES / "cornell.gltf"


def hit_rate(wave, cache):
    return wave["cache"][cache]["hits"] / wave["cache"][cache]["accesses"]


@pytest.mark.parametrize("options", [[], ["--stall-seed", 5]], ids=["free", "stalls"])
def test_ten_waves_give_the_hits_of_one(engine, stored, tmp_path, options):
    one = engine.trace(tmp_path / "one", stored, "inside:2000", *options).good()
    ten = engine.trace(tmp_path / "ten", stored, "inside:2000", "--waves", 10, *options).good()

    for name in ("hits.npy", "prims.npy"):
        assert ten.read(name) == one.read(name)
    waves = ten.report["waves"]
    assert [wave["rays"] for wave in waves] == [200] * 10
    assert sum(wave["cycles"] for wave in waves) == ten.report["cycles"]
    assert ten.report["phase"] == one.report["phase"]


def test_caches_stay_warm_from_wave_to_wave(small, out):
    """The same rays three times: the first wave alone fetches the scene."""
    rays = small.trace(out / "rays", CORNELL, "inside:300", "--dump").good()
    np.save(out / "thrice.npy", np.tile(np.load(rays.out / "rays.npy"), (3, 1)))
    run = small.trace(out / "run", CORNELL, out / "thrice.npy", "--waves", 3).good()

    first, *later = run.report["waves"]
    for wave in later:
        assert wave["dram_bytes"] < first["dram_bytes"] / 10
        assert wave["cycles"] < first["cycles"]
        assert all(hit_rate(wave, cache) > 0.99 for cache in wave["cache"])


def test_more_waves_than_rays_leave_some_empty(ti, tiny, out):
    for program in (ti, tiny):
        run = program.trace(out, CORNELL, "random:3", "--waves", 7).good()
        assert sorted(wave["rays"] for wave in run.report["waves"]) == [0, 0, 0, 0, 1, 1, 1]


def test_the_cycles_of_each_unit_add_up_exactly_over_waves(tiny, out):
    report = tiny.trace(out, CORNELL, "random:500", "--waves", 3).good().report

    for unit, shares in report["stalls"].items():
        total = sum(shares.values()) * report["cycles"]
        assert total == pytest.approx(report["cycles"], abs=1e-6 * report["cycles"]), unit


def test_a_slow_memory_is_no_lost_ray(tiny, out):
    """A ray waits for longer than the cycles that once counted as for ever."""
    run = tiny.trace(out, SCENES / "one_triangle.obj", "primary:2", "--mem-latency", 1_000_000)

    assert run.good().report["cycles"] > 2_000_000


def start(program, out, *options):
    """`ti trace` of many rays in the background, once its tree is built."""
    command = [program.path, "trace", "--config", program.config, "--scene", CORNELL]
    command += ["--rays", "inside:3000000", "--out", out, "--no-truth", *options]
    run = subprocess.Popen(
        [str(word) for word in command],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    assert any(line.startswith("tree:") for line in run.stdout), run.wait()
    return run


def test_an_interrupt_ends_a_run_with_what_it_has(tiny, out):
    run = start(tiny, out, "--rtl", tiny.library, "--dump")
    run.send_signal(signal.SIGINT)
    said, _ = run.communicate(timeout=300)

    assert run.returncode == 130, said
    prims = np.load(out / "prims.npy")
    assert f"of the first {len(prims)} rays" in said
    assert 0 <= len(prims) < 3_000_000
    assert len(np.load(out / "hits.npy")) == len(np.load(out / "rays.npy")) == len(prims)
    assert not list(out.glob("*.part"))


def test_a_second_interrupt_ends_it_at_once_and_leaves_nothing(tiny, out):
    run = start(tiny, out, "--rtl", tiny.library)
    while run.poll() is None:  # until one is the second: the first may stop the run by itself
        run.send_signal(signal.SIGINT)
    run.communicate(timeout=300)

    assert run.returncode in (-signal.SIGINT, 130)
    assert run.returncode == 130 or not out.exists()


def test_a_full_disk_leaves_the_folder_as_it_was(ti, tmp_path):
    before = ti.trace(tmp_path, CORNELL, "random:100").good()
    files = {path.name: path.read_bytes() for path in tmp_path.iterdir()}

    def full():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (20000, 20000))

    words = ["--rays", "random:5000", "--engine", "model", "--out", tmp_path, "--scene", CORNELL]
    command = [str(word) for word in (ti.path, "trace", "--config", ti.config, *words)]
    run = subprocess.run(command, cwd=ROOT, preexec_fn=full, capture_output=True, text=True)

    assert run.returncode == 2, run
    assert len(run.stderr.splitlines()) == 1 and "cannot be written" in run.stderr
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == files
    assert before.report["rays"] == 100
