# SPDX-License-Identifier: Apache-2.0
"""An animation: only what moved is traced anew, and the pictures are those of a whole new frame."""

import base64
import json

import numpy as np
import pytest
from agents.program import SCENES

FRAMES = 4
CORNELL = SCENES / "cornell.gltf"


def float_view(gltf: dict, values, kind: str) -> int:
    """Adds an accessor of float32 numbers with a buffer of its own; its number."""
    data = np.asarray(values, dtype="<f4").tobytes()
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    gltf["buffers"].append({"byteLength": len(data), "uri": uri})
    gltf["bufferViews"].append({"buffer": len(gltf["buffers"]) - 1, "byteLength": len(data)})
    view = len(gltf["bufferViews"]) - 1
    gltf["accessors"].append(
        {"bufferView": view, "componentType": 5126, "count": len(values), "type": kind}
    )
    return len(gltf["accessors"]) - 1


def moving_cornell(path, node: str, to, source=CORNELL) -> None:
    """The Cornell box with a node that moves by `to` in half a second, then rests."""
    gltf = json.loads(source.read_text())
    number = next(i for i, n in enumerate(gltf["nodes"]) if n["name"] == node)
    start = gltf["nodes"][number].get("translation", [0, 0, 0])
    end = [a + b for a, b in zip(start, to, strict=True)]
    sampler = {
        "input": float_view(gltf, [0.0, 0.5, 1.0], "SCALAR"),
        "output": float_view(gltf, [start, end, end], "VEC3"),
    }
    channel = {"sampler": 0, "target": {"node": number, "path": "translation"}}
    gltf["animations"] = [{"channels": [channel], "samplers": [sampler]}]
    path.write_text(json.dumps(gltf))


def render(program, out, scene, *options):
    """The report and the radiance of each frame."""
    words = ["--size", "48x48", "--frames", ":", "--fps", FRAMES, "--dump"]
    run = program.render(out, scene, *words, *options).good()
    return run.report, [np.load(name) for name in sorted(out.glob("radiance-*.npy"))]


@pytest.fixture
def block(tmp_path):
    path = tmp_path / "block.gltf"
    moving_cornell(path, "short block", [0.0, 0.1, 0.0])
    return path


@pytest.mark.parametrize("effects", ["none+motion", "auto"])
def test_frames_are_those_of_all_tiles_and_new_trees_bit_for_bit(tiny, tmp_path, block, effects):
    whole = "all" if effects == "auto" else effects
    report, pictures = render(tiny, tmp_path / "auto", block, "--effects", effects, "--bounces", 1)
    everything, others = render(tiny, tmp_path / "all", block, "--effects", whole, "--bounces", 1)

    assert len(pictures) == len(others) == FRAMES
    for picture, other in zip(pictures, others, strict=True):
        assert picture.tobytes() == other.tobytes()
    assert not np.array_equal(pictures[0], pictures[1])
    frames = report["frames"]
    assert [f["moved_triangles"] for f in frames] == [0, 10, 10, 0]
    assert frames[0]["traced_tiles"] == frames[0]["tiles"] == 36
    assert frames[1]["rays"] > 0
    # Nothing moved in the last frame: it is the picture before, without a ray.
    assert frames[3]["traced_tiles"] == frames[3]["rays"] == frames[3]["cycles"] == 0
    assert sum(f["rays"] for f in frames) == report["rays"]
    assert sum(f["cycles"] for f in frames) == report["cycles"]
    if effects == "auto":
        assert all(f["traced_tiles"] == 36 for f in everything["frames"])


def test_frames_have_one_scale_which_is_that_of_all_they_reach(ti, tmp_path):
    path = tmp_path / "rising.gltf"
    moving_cornell(path, "short block", [0.0, 30.0, 0.0])
    config = ti.with_keys(tmp_path, exp_bits=5, frac_bits=10, triangle_test="woop")
    words = ["--size", "16x16", "--effects", "none+motion"]

    def scale(name, *frames):
        run = ti.render(tmp_path / name, path, *words, *frames, config=config).good()
        return run.report["range"]["scale"]

    assert scale("first", "--frames", "0", "--fps", FRAMES) == -1
    assert scale("both", "--frames", "0:2", "--fps", FRAMES) == -1
    assert scale("still") == 4


def test_primary_rays_are_traced_where_the_block_was_and_is_alone(tiny, tmp_path, block):
    report, _ = render(tiny, tmp_path / "out", block, "--effects", "none+motion")
    second = report["frames"][1]
    assert 0 < second["traced_tiles"] < 18
    assert second["rays"] == 64 * second["traced_tiles"]


def with_bulb(path) -> None:
    """Adds a lamp without an area to a scene, at the node `bulb`."""
    gltf = json.loads(path.read_text())
    lights = {"lights": [{"type": "point", "intensity": 0.1}]}
    gltf["extensions"] = {"KHR_lights_punctual": lights}
    at = {"translation": [0.2, 0.3, 0.1], "extensions": {"KHR_lights_punctual": {"light": 0}}}
    gltf["nodes"].append({"name": "bulb", **at})
    gltf["scenes"][0]["nodes"].append(len(gltf["nodes"]) - 1)
    path.write_text(json.dumps(gltf))


@pytest.mark.parametrize("what", ["camera", "light", "bulb"])
def test_what_lights_or_sees_all_traces_every_tile(tiny, tmp_path, what):
    source, path = tmp_path / "source.gltf", tmp_path / "moving.gltf"
    source.write_text(CORNELL.read_text())
    if what == "bulb":
        with_bulb(source)
    moving_cornell(path, what, [0.05, 0.0, 0.0], source)
    report, pictures = render(tiny, tmp_path / "out", path, "--bounces", 1)
    assert [f["traced_tiles"] for f in report["frames"]] == [36, 36, 36, 0]
    assert not np.array_equal(pictures[0], pictures[1])
    assert next(d for d in report["plan"] if d["effect"] == "motion")["on"]


def test_motion_left_out_shows_the_first_frame(tiny, tmp_path, block):
    report, pictures = render(tiny, tmp_path / "out", block, "--effects", "none")
    assert [f["rays"] for f in report["frames"]] == [48 * 48, 0, 0, 0]
    assert all(picture.tobytes() == pictures[0].tobytes() for picture in pictures)


def test_a_frame_by_its_number_is_that_of_the_animation(tiny, tmp_path, block):
    _, pictures = render(tiny, tmp_path / "all", block, "--effects", "none+motion")
    words = ["--size", "48x48", "--frames", "2", "--fps", FRAMES, "--dump", "--effects", "none"]
    out = tmp_path / "one"
    tiny.render(out, block, *words).good()
    assert np.load(out / "radiance-0002.npy").tobytes() == pictures[2].tobytes()
    assert (out / "frame-0002.png").is_file()
    assert not (out / "frame-0000.png").exists()


def test_two_runs_give_one_report_but_for_times(tiny, tmp_path, block):
    reports = []
    for name in ("one", "two"):
        report, _ = render(tiny, tmp_path / name, block, "--effects", "none+motion")
        assert len(report["time"]["frames"]) == FRAMES
        reports.append({key: report[key] for key in report if key not in ("sim", "time")})
    assert reports[0] == reports[1]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--frames", "0:9"], "4 frames"),
        (["--frames", "x"], "FRAMES=x"),
        (["--frames", ":", "--fps", "0"], "FPS=0"),
        (["--frames", ":", "--log-ray", "3"], "LOG_RAY"),
        (["--frames", ":", "--image", "x.tiim"], "IMAGE"),
    ],
)
def test_bad_words_are_refused(tiny, tmp_path, block, options, said):
    if "--fps" not in options:
        options = ["--fps", FRAMES, *options]
    tiny.render(tmp_path / "out", block, "--size", "16x16", *options).refused(said)
