# SPDX-License-Identifier: Apache-2.0
"""A scene that cannot be used ends in one sentence and status 2, with nothing written."""

import base64
import json
import struct

import numpy as np
import pytest
from agents.program import SCENES

CORNELL = SCENES / "cornell.gltf"
SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
FACES = [(0, 1, 2), (0, 2, 3)]


def glb():
    """The Cornell box as one binary glTF file."""
    document = json.loads(CORNELL.read_text())
    [buffer] = document["buffers"]
    data = base64.b64decode(buffer.pop("uri").split(",", 1)[1])
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    data += bytes(-len(data) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", len(data), b"BIN\0") + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def gltf(indices):
    """A glTF file of three vertices and one triangle with these indices."""
    data = struct.pack("<9f", *SQUARE[0], *SQUARE[1], *SQUARE[2]) + struct.pack("<3H", *indices)
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    primitive = {"attributes": {"POSITION": 0}, "indices": 1}
    return json.dumps(
        {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [primitive]}],
            "buffers": [{"byteLength": len(data), "uri": uri}],
            "bufferViews": [
                {"buffer": 0, "byteOffset": 0, "byteLength": 36},
                {"buffer": 0, "byteOffset": 36, "byteLength": 6},
            ],
            "accessors": [
                {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}
                | {"min": [0, 0, 0], "max": [1, 1, 0]},
                {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"},
            ],
        }
    ).encode()


def ply(vertices=SQUARE, faces=FACES):
    """A binary PLY file."""
    header = f"""ply
format binary_little_endian 1.0
element vertex {len(vertices)}
property float x
property float y
property float z
element face {len(faces)}
property list uchar int vertex_indices
end_header
"""
    body = b"".join(struct.pack("<3f", *vertex) for vertex in vertices)
    return header.encode() + body + b"".join(struct.pack("<B3i", 3, *face) for face in faces)


def obj(*faces):
    vertices = [f"v {x} {y} {z}" for x, y, z in SQUARE]
    return "\n".join([*vertices, *(f"f {face}" for face in faces), ""]).encode()


def zst(data):
    """One Zstandard frame of one raw block (RFC 8878)."""
    block = struct.pack("<I", len(data) << 3 | 1)[:3] + data
    return struct.pack("<IBI", 0xFD2FB528, 0xA0, len(data)) + block


def flat(count):
    """Triangles of no area: points, and corners on one line."""
    return ply([(0, 0, 0), (1, 1, 1), (2, 2, 2)], [(0, 1, 2), (1, 1, 1)] * (count // 2))


NAN = [(float("nan"), 0, 0), *SQUARE[1:3]]
MAX = 3.4028234663852886e38
FAR = [(-MAX, 0, 0), (MAX, 0, 0), (0, MAX, 0)]
HALF = len(glb()) // 2

BAD = {  # name of the file, its bytes, what the sentence must say
    "glb-cut-in-half": ("a.glb", glb()[:HALF], ["is cut"]),
    "glb-cut-in-its-header": ("a.glb", glb()[:7], ["is cut"]),
    "glb-cut-by-one-byte": ("a.glb", glb()[:-1], ["is cut"]),
    "glb-empty": ("a.glb", b"", ["is cut"]),
    "gltf-index": ("a.gltf", gltf((0, 1, 3)), ["index 3", "3 vertices"]),
    "gltf-not-json": ("a.gltf", CORNELL.read_bytes()[:500], ["JSON"]),
    "obj-index": ("a.obj", obj("1 2 3", "1 2 5"), ["line 6", "index 5", "4 vert"]),
    "obj-index-0": ("a.obj", obj("1 2 0"), ["line 5", "index 0"]),
    "ply-index": ("a.ply", ply(faces=[(0, 1, 2), (0, 1, 4)]), ["face 1", "index 4"]),
    "ply-index-negative": ("a.ply", ply(faces=[(0, 1, -1)]), ["face 0", "index -1"]),
    "ply-cut": ("a.ply", ply()[:-5], ["is cut"]),
    "ply-cut-in-its-header": ("a.ply", ply()[:50], ["end_header"]),
    "zst-cut": ("a.ply.zst", zst(ply())[:-9], ["Zstandard"]),
    "zst-of-a-cut-ply": ("a.ply.zst", zst(ply()[:-9]), ["is cut"]),
    "zst-of-nothing-known": ("a.ply.zst", ply(), ["Zstandard"]),
    "unknown-ending": ("a.stl", ply(), ["extension", ".gltf", ".ply.zst"]),
    "only-flat-triangles": ("a.ply", flat(6), ["none of its 6 triangles", "6 of zero area"]),
    "only-nan": ("a.ply", ply(NAN, [(0, 1, 2)]), ["none of its 1 triangles", "1 not finite"]),
}
BAD_SIDECARS = {
    "not-json": ('{"camera": ', ["line 1", "JSON"]),
    "no-target": ('{"camera": {"eye": [0, 0, 1]}}', ["camera.target"]),
    "light-of-two": ('{"lights": [[1, 2]]}', ["lights[0]"]),
}


@pytest.fixture
def trace(ti, tmp_path, out):
    """A function that writes a scene file and traces it."""

    def run(name, data, *options):
        path = tmp_path / name
        path.write_bytes(data)
        return ti.trace(out, path, "random:10", *options)

    return run


@pytest.mark.parametrize("case", BAD)
def test_a_bad_scene_is_refused(trace, case):
    name, data, words = BAD[case]

    trace(name, data).refused(name, *words)


@pytest.mark.parametrize("engine", ["model", "embree"])
def test_flat_triangles_are_refused_whatever_the_engine(ti, tmp_path, out, engine):
    path = tmp_path / "flat.ply"
    path.write_bytes(flat(2))

    ti.trace(out, path, "random:10", engine=engine).refused("none of its 2 triangles")
    ti.render(out, path, "--size", "8x8", engine=engine).refused("none of its 2 triangles")


def test_the_files_that_were_spoilt_are_good_when_whole(trace):
    """So that each refusal above is for the fault it names."""
    for name, data, triangles in [
        ("a.glb", glb(), 38),
        ("a.gltf", gltf((0, 1, 2)), 1),
        ("a.obj", obj("1 2 3", "1 2 4"), 2),
        ("a.ply", ply(), 2),
        ("b.ply.zst", zst(ply()), 2),
    ]:
        assert trace(name, data).good().report["triangles"] == triangles


def test_coordinates_at_the_end_of_the_range_are_scaled(trace):
    report = trace("a.ply", ply(FAR, [(0, 1, 2)])).good().report

    assert report["range"]["scale"] == -118
    assert report["range"]["dropped_overflow"] == 0


def test_one_usable_triangle_among_flat_ones_is_enough(trace):
    run = trace("a.ply", ply(SQUARE, [(0, 0, 1), (0, 1, 2), (2, 2, 2)])).good()

    assert "dropped 2 of zero area out of 3 triangles" in run.stdout
    assert set(np.unique(run.prims)) <= {-1, 1}


@pytest.mark.parametrize("case", BAD_SIDECARS)
def test_a_bad_description_beside_the_scene_is_refused(trace, tmp_path, case):
    text, words = BAD_SIDECARS[case]
    (tmp_path / "a.json").write_text(text)

    trace("a.ply", ply()).refused("a.json", *words)


def test_a_missing_file_is_refused(ti, tmp_path, out):
    ti.trace(out, tmp_path / "none.gltf", "random:10").refused("none.gltf", "no such file")
    ti.trace(out, tmp_path / "none", "random:10").refused("none", "no such file")


def test_a_folder_is_refused(ti, tmp_path, out):
    ti.trace(out, tmp_path, "random:10").refused(str(tmp_path), "folder")


def test_a_glb_cut_anywhere_is_refused(trace):
    whole = glb()
    for length in range(0, len(whole), 211):
        trace("a.glb", whole[:length]).refused("a.glb")


def test_earlier_results_stay_when_a_scene_is_refused(ti, tmp_path, out):
    ti.trace(out, SCENES / "cornell.gltf", "random:10").good()
    before = {path.name: path.read_bytes() for path in out.iterdir()}
    (tmp_path / "a.glb").write_bytes(glb()[:HALF])

    assert ti.trace(out, tmp_path / "a.glb", "random:10").status == 2
    assert {path.name: path.read_bytes() for path in out.iterdir()} == before
