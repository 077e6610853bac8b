# SPDX-License-Identifier: Apache-2.0
"""Scenes are the same bytes everywhere, valid glTF, and made of closed shapes that look outward."""

import base64
import json

import make_scenes
import numpy as np
import pytest
from agents.bench import ROOT

from scenes import closed, gltf, shapes

GLTF = [file for file in make_scenes.BIG if file.endswith(".gltf")]
FORMS = {5123: ("<u2", 2), 5125: ("<u4", 4), 5126: ("<f4", 4)}
WIDTH = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}


def document(file):
    return json.loads(make_scenes.BIG[file]()[1])


def values(scene, number):
    """What an accessor gives, a row an element."""
    accessor = scene["accessors"][number]
    view = scene["bufferViews"][accessor["bufferView"]]
    data = base64.b64decode(scene["buffers"][0]["uri"].split(",")[1])
    assert len(data) == scene["buffers"][0]["byteLength"]
    form, size = FORMS[accessor["componentType"]]
    width = WIDTH[accessor["type"]]
    assert view["byteOffset"] % size == 0
    assert view["byteLength"] == accessor["count"] * width * size
    assert view["byteOffset"] + view["byteLength"] <= len(data)
    return np.frombuffer(data, form, accessor["count"] * width, view["byteOffset"]).reshape(
        -1, width
    )


def test_the_small_scenes_in_git_are_what_the_script_writes(tmp_path):
    make_scenes.make_small(tmp_path)

    written = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert written == {name: (ROOT / "scenes" / name).read_bytes() for name in written}


def test_the_makefile_names_the_large_scenes():
    lines = (ROOT / "Makefile").read_text().splitlines()

    def names(variable):
        return next(line for line in lines if line.startswith(f"{variable} :=")).split()[2:]

    files = [f"{name}.gltf" for name in names("gallery_names")]
    files += [f"{name}.ply" for name in ["knot", *names("closed_names")]]
    assert sorted(files) == sorted(make_scenes.BIG)


@pytest.mark.parametrize("mesh", [closed.icosphere, closed.torus, closed.tube])
def test_in_a_closed_mesh_each_edge_has_two_triangles_that_run_along_it_in_turn(mesh):
    vertices, triangles = mesh()
    starts = triangles.astype(np.int64).ravel()
    ends = np.roll(triangles.astype(np.int64), -1, axis=1).ravel()
    edges, turned = starts * len(vertices) + ends, ends * len(vertices) + starts

    assert len(np.unique(edges)) == len(edges)
    assert np.array_equal(np.sort(edges), np.sort(turned))
    places = {tuple(v) for v in vertices}
    assert len(places) == len(vertices)


@pytest.mark.parametrize("file", make_scenes.BIG)
def test_a_large_scene_is_the_same_bytes_again(file, tmp_path):
    for folder in (tmp_path / "one", tmp_path / "two"):
        make_scenes.make_big(folder, file)
    assert (tmp_path / "one" / file).read_bytes() == (tmp_path / "two" / file).read_bytes()
    assert not list((tmp_path / "one").glob("*.[0-9]*"))


@pytest.mark.parametrize("file", GLTF)
def test_numbers_of_a_gltf_are_multiples_of_a_power_of_two(file):
    scene = document(file)

    # Those of Cornell's box are as they were published.
    box = file == "cornell_glass.gltf"
    nodes = [node for node in scene["nodes"] if not (box and "camera" in node)]
    computed = [node.get(key, []) for node in nodes for key in ("translation", "scale", "rotation")]
    for primitive in (p for mesh in scene["meshes"] for p in mesh["primitives"]):
        points = values(scene, primitive["attributes"]["POSITION"])
        if not box or len(points) > 100:
            computed.append(points.reshape(-1))
    for numbers in computed:
        steps = np.array(numbers, dtype=np.float64) * 65536
        assert (steps == np.round(steps)).all()


@pytest.mark.parametrize("file", GLTF)
def test_a_gltf_is_whole(file):
    scene = document(file)

    assert scene["asset"]["version"] == "2.0"
    assert "extensionsUsed" not in scene or scene["extensionsUsed"]
    for primitive in (p for mesh in scene["meshes"] for p in mesh["primitives"]):
        accessor = scene["accessors"][primitive["attributes"]["POSITION"]]
        points = values(scene, primitive["attributes"]["POSITION"])
        corners = values(scene, primitive["indices"]).reshape(-1, 3)
        assert corners.max() < len(points)
        assert points.min(axis=0).tolist() == accessor["min"]
        assert points.max(axis=0).tolist() == accessor["max"]
        a, b, c = (points[corners[:, k]].astype(np.float64) for k in range(3))
        assert (np.linalg.norm(np.cross(b - a, c - a), axis=1) > 0).all()
        assert primitive["material"] < len(scene["materials"])
    below = [child for node in scene["nodes"] for child in node.get("children", [])]
    assert sorted(below + scene["scenes"][0]["nodes"]) == list(range(len(scene["nodes"])))
    for node in scene["nodes"]:
        assert abs(np.linalg.norm(node.get("rotation", [1])) - 1) < 1e-4
    names = [material["name"] for material in scene["materials"]]
    assert len(set(names)) == len(names)


def test_the_windmill_moves_two_things_in_16_frames_and_begins_again():
    scene = document("windmill.gltf")

    (animation,) = scene["animations"]
    moved = {}
    for channel in animation["channels"]:
        sampler = animation["samplers"][channel["sampler"]]
        times = values(scene, sampler["input"])[:, 0]
        assert sampler["interpolation"] == "LINEAR"
        assert (times[0], times[-1]) == (0, 16 / 8) and (np.diff(times) > 0).all()
        assert scene["accessors"][sampler["input"]]["max"] == [2.0]
        moved[channel["target"]["path"]] = (
            scene["nodes"][channel["target"]["node"]],
            values(scene, sampler["output"]),
        )
        assert len(values(scene, sampler["output"])) == len(times)
    sails, turns = moved["rotation"]
    balloon, lift = moved["translation"]
    # The still is the first frame.
    assert sails["name"] == "sails" and sails["rotation"] == turns[0].tolist()
    assert balloon["name"] == "balloon" and balloon["translation"] == lift[0].tolist()
    # Four sails: after a quarter of a turn they look as before. Quaternions have the half angle.
    assert abs(turns[0] @ turns[-1] - np.cos(np.pi / 4)) < 1e-4
    assert lift[0].tolist() == lift[-1].tolist()


SOLIDS = {  # a shape and its volume, about
    "ball": (shapes.ball(24), 4 / 3 * np.pi),
    "box": (shapes.box((0, 1, 2), (1, 3, 5)), 6),
    "drum": (shapes.drum(2, 1, 4, 400), 12 * np.pi),
    "torus": (shapes.torus(2, 0.5, 200, 100), np.pi**2),
    "cone": (shapes.lathe([(0, 0), (1, 0), (0, 3)], 400), np.pi),
    "pair": (shapes.joined(shapes.box((0, 0, 0), (1, 1, 1)), shapes.box((2, 0, 0), (3, 1, 1))), 2),
    "placed": (shapes.placed(shapes.box((0, 0, 0), (1, 1, 1)), (5, 0, 0), 2, 30), 8),
    "lump": (shapes.lump(8, 1, 0.0), 4 / 3 * np.pi),
}


@pytest.mark.parametrize("name", SOLIDS)
def test_a_solid_is_closed_and_its_triangles_look_outward(name):
    (vertices, triangles), volume = SOLIDS[name]

    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    assert abs((np.cross(a, b) * c).sum() / 6 / volume - 1) < 0.02
    edges = {tuple(edge) for k in range(3) for edge in triangles[:, [k, (k + 1) % 3]].tolist()}
    assert len(edges) == 3 * len(triangles)
    assert {(b, a) for a, b in edges} == edges


@pytest.mark.parametrize("direction", [(0, 0, -1), (0, 0, 1), (1, 0.2, 0), (-1, -1, -1), (3, 1, 2)])
def test_a_camera_looks_where_it_is_told(direction):
    x, y, z, w = gltf.looking(direction)

    # -z turned by the quaternion, and the image upright.
    forward = -np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
    up = np.array([2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)])
    assert np.allclose(forward, direction / np.linalg.norm(direction), atol=1e-4)
    assert up[1] > 0
    assert abs(up @ forward) < 1e-4


def test_a_quaternion_of_a_known_turn():
    half = round(np.sqrt(0.5) * 65536) / 65536
    assert gltf.about((0, 1, 0), 90) == [0, half, 0, half]
