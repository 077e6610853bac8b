# SPDX-License-Identifier: Apache-2.0
"""The module `ti` answers numpy arrays of rays in this process, as the program does."""

import os
import re
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest
from agents.program import ROOT, SCENES

CORNELL = SCENES / "cornell.gltf"


def children():
    """Numbers of the processes that this one has started and that still run."""
    found = set()
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:  # NUMBER (NAME) STATE PARENT ...
            parent = stat.read_text().rpartition(")")[2].split()[1]
        except OSError:  # it has just ended
            continue
        if int(parent) == os.getpid():
            found.add(stat.parent.name)
    return found


def test_model_and_rtl_answer_an_array_without_a_process(module, tiny, ti, tmp_path):
    program = ti.trace(tmp_path, CORNELL, "random:500", "--dump").good()
    rays = np.load(tmp_path / "rays.npy")
    before = children()
    scene = module.Scene(CORNELL)
    model = module.Engine(scene, tiny.config).trace(rays)
    rtl = module.Engine(scene, tiny.config, "rtl", library=tiny.library).trace(rays)

    assert children() == before
    for wave in (model, rtl):
        assert wave.good
        assert wave.hits.tobytes() == program.hits.tobytes()
        assert wave.prims.tobytes() == program.prims.tobytes()
        assert wave.steps.tobytes() == np.load(tmp_path / "steps.npy").tobytes()
    assert (rtl.tests == np.load(tmp_path / "tests.npy")).all()
    assert rtl.answered.max() < rtl.report["cycles"]


def test_an_engine_stays_warm_and_two_of_them_do_not_mix(module, small, tiny):
    scene = module.Scene(CORNELL)
    rays = scene.random_rays(300)
    engines = [
        module.Engine(scene, p.config, "rtl", library=p.library, truth=True) for p in (small, tiny)
    ]
    waves = [engine.trace(rays) for _ in range(2) for engine in engines]

    assert all(wave.good for wave in waves)
    assert all(wave.hits.tobytes() == waves[0].hits.tobytes() for wave in waves)
    assert waves[2].report["per_ray"]["dram_bytes"] < waves[0].report["per_ray"]["dram_bytes"] / 10
    assert waves[2].report["config"] == "small" and waves[3].report["config"] == "tiny"


def test_secondary_rays_start_from_hits(module, ti):
    scene = module.Scene(CORNELL)
    rays, index = scene.primary_rays(16, 16)
    assert sorted(index) == list(range(256))
    engine = module.Engine(scene, ti.config, "embree")
    first = engine.trace(rays)
    hits = (first.prims >= 0).sum()

    start = (rays, first.hits, first.prims)
    radius = 0.1 * scene.diagonal
    assert engine.format == (8, 23)
    ao = scene.ao_rays(*start, samples=3, radius=radius, format=engine.format)
    diffuse = scene.diffuse_rays(*start, samples=2, format=engine.format)
    assert (len(ao), len(diffuse)) == (3 * hits, 2 * hits)
    occluded = engine.trace(ao, any_hit=True)
    assert 0 < (occluded.prims >= 0).sum() < len(ao)

    half = scene.ao_rays(*start, samples=3, radius=radius, format=(5, 10))[:, :3]
    assert (half == half.astype(np.float16)).all() and not (half == ao[:, :3]).all()
    with pytest.raises(ValueError, match=r"\(9, 10\).*\(3, 2\) to \(8, 23\)"):
        scene.diffuse_rays(*start, format=(9, 10))


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda ti, scene, config: ti.Scene("/nowhere.obj"), "/nowhere.obj"),
        (lambda ti, scene, config: ti.Engine(scene, "/nowhere.json"), "/nowhere.json"),
        (lambda ti, scene, config: ti.Engine(scene, config, "gpu"), "there are rtl, model, embree"),
        (lambda ti, scene, config: ti.Engine(scene, config, "rtl"), "make engine"),
    ],
)
def test_bad_input_raises_one_sentence(module, ti, make, says):
    with pytest.raises(ValueError, match=says) as error:
        make(module, module.Scene(CORNELL), ti.config)
    assert "\n" not in str(error.value)


def test_an_array_of_another_shape_is_no_rays(module, ti):
    engine = module.Engine(module.Scene(CORNELL), ti.config)
    for array in (np.zeros((4, 7), np.float32), np.zeros(8, np.float32), [1, 2]):
        with pytest.raises(TypeError):
            engine.trace(array)
    assert len(engine.trace(np.zeros((0, 8), np.float32)).prims) == 0


def test_an_engine_without_room_has_the_scene_scaled(module, ti, tmp_path):
    rows = "v 0 0 0\nv 600 0 0\nv 600 500 0\nv 0 500 0\nf 1 2 3\nf 1 3 4\n"
    (tmp_path / "wall.obj").write_text(rows)
    scene = module.Scene(tmp_path / "wall.obj")
    config = ti.with_keys(tmp_path, exp_bits=5, frac_bits=10, triangle_test="woop")
    engine = module.Engine(scene, config, truth=True)
    assert engine.format == (5, 10, "woop") and engine.scale == -6

    rays = np.array([[300, 200, 400, 0, 0, 0, -1, np.inf]], np.float32)
    wave = engine.trace(rays)
    assert wave.good and abs(wave.hits[0, 0] - 400) < 1
    assert wave.report["range"]["scale"] == -6
    on = {"format": engine.format, "scale": engine.scale}
    [ray] = scene.diffuse_rays(rays, wave.hits, wave.prims, **on)
    assert ray[2] > 0 and engine.trace(ray[None]).prims[0] == -1
    with pytest.raises(ValueError, match=r"scale=1000: .*Engine\.scale"):
        scene.diffuse_rays(rays, wave.hits, wave.prims, format=engine.format, scale=1000)


def test_the_module_shares_no_types_with_other_modules(module, ti):
    """Those of the tests bind classes of the same programs; either may come first."""
    del module
    folders = [str(ROOT / "build/sw"), str(ROOT / "build/sw/python")]
    for first, second in (("ti", "ti_model"), ("ti_model", "ti")):
        lines = f"""
            import gc, sys
            sys.path[:0] = {folders}
            import {first}, {second}
            assert ti.Image is not ti_model.Image
            scene = ti.Scene({str(CORNELL)!r})
            kept = [scene.image({str(ti.config)!r}) for _ in range(3)]
            assert all(isinstance(image, ti.Image) and image.bytes > 0 for image in kept)
            kept.append(kept)
            del scene, kept
            gc.collect()
        """
        words = [sys.executable, "-W", "error", "-c", textwrap.dedent(lines)]
        done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr


def test_a_device_answers_as_the_model_does(module, top):
    scene = module.Scene(CORNELL)
    rays = scene.random_rays(500)
    model = module.Engine(scene, top.config)
    device = module.Device(library=top.library)
    device.load(scene.image(top.config))
    device.flush()
    for any_hit in (False, True):
        wave, answers = model.trace(rays, any_hit), device.trace(rays, any_hit)
        assert answers.hits.tobytes() == wave.hits.tobytes()
        assert answers.prims.tobytes() == wave.prims.tobytes()
        assert answers.steps.tobytes() == wave.steps.tobytes()
        assert not answers.status.any()


def test_a_device_has_a_scene_without_room_scaled(module, top, tmp_path):
    rows = "v 0 0 0\nv 1e38 0 0\nv 1e38 1e38 0\nv 0 1e38 0\nf 1 2 3\nf 1 3 4\n"
    (tmp_path / "wall.obj").write_text(rows)
    scene = module.Scene(tmp_path / "wall.obj")
    model = module.Engine(scene, top.config)
    assert model.scale < -100
    device = module.Device(library=top.library)
    device.load(scene.image(top.config))
    rays = np.array([[3e37, 2e37, 5e37, 0, 0, 0, -1, np.inf]], np.float32)
    answers = device.trace(rays)
    assert answers.hits.tobytes() == model.trace(rays).hits.tobytes()
    assert abs(answers.hits[0, 0] - 5e37) < 1e31


def test_a_device_says_what_it_is_and_what_has_come(module, top, images):
    device = module.Device(library=top.library)
    machine = device.identify()
    assert (machine["format"], machine["cores"], machine["triangle_test"]) == ((8, 23), 1, "local")
    device.load(module.Image(images(CORNELL).image))
    rays = np.array([[0, 0, 0, 0, 0, 0, 1, np.inf], [0, 0, 0, 0, 0, 0, 0, 1]], np.float32)
    assert device.trace(rays).status.tolist() == [0, 1]
    expected = {"rays": 2, "hits": 2, "invalid_rays": 1, "memory_errors": 0, "watchdogs": 0}
    assert device.counters() == expected
    assert device.counter(core=0, unit=0, event=0) == device.counter(core=0, unit=0, event=0) > 0

    device.drain()
    assert device.irq_status() == {"invalid_ray", "drained"}
    device.clear_irq({"invalid_ray"})
    assert device.irq_status() == {"drained"}
    device.enable_irq({"watchdog", "memory_error"})


def test_a_device_refuses_in_one_sentence(module, top, tiny):
    image = module.Scene(CORNELL).image(tiny.config)
    device = module.Device(library=top.library, memory_bytes=1024)
    refused = {
        "give library=.* or board=": module.Device,
        "no registers and streams": lambda: module.Device(library=tiny.library),
        "nowhere.json": lambda: module.Device(board="/nowhere.json"),
        "no scene yet": lambda: device.trace(np.zeros((1, 8), np.float32)),
        "no memory for": lambda: device.load(image),
        "there are the interrupts": lambda: device.clear_irq({"smoke"}),
    }
    for says, action in refused.items():
        with pytest.raises(ValueError, match=says) as error:
            action()
        assert "\n" not in str(error.value)


def test_the_example_of_a_device_runs(module, top):
    text = (ROOT / "docs/python.md").read_text().split("## A device")[1]
    example = re.search(r"```python\n(.*?)```", text, re.DOTALL)[1]
    done = subprocess.run(
        [sys.executable, "-c", example], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert re.fullmatch(r"\(8, 23\) 1 stream\n.*% hit, .* steps a ray\n", done.stdout)
