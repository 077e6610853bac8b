#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Make the project's own scenes.

Without arguments the small ones are written to `scenes/`, where they are kept in git;
`--large NAME` writes one of the others to `build/scenes` or `--to DIR`. The same bytes come out on
every machine: computed coordinates are rounded to multiples of 2^-16.
"""

import argparse
import json
import os
from pathlib import Path

import gallery_scenes
import numpy as np
from gltf import Gltf, material

ROOT = Path(__file__).resolve().parent.parent

# --- Cornell box --------------------------------------------------------------------------------
# Quads in millimetres as published by the Cornell University Program of Computer Graphics, "Cornell
# Box Data".
# The ceiling is cut around the light into four quads, so that no two surfaces coincide.

CEILING = 548.8
LIGHT = [(343, CEILING, 227), (343, CEILING, 332), (213, CEILING, 332), (213, CEILING, 227)]
OUTER = [(556, CEILING, 0), (556, CEILING, 559.2), (0, CEILING, 559.2), (0, CEILING, 0)]
SHORT_TOP = [(130, 165, 65), (82, 165, 225), (240, 165, 272), (290, 165, 114)]
TALL_TOP = [(423, 330, 247), (265, 330, 296), (314, 330, 456), (472, 330, 406)]


def block(top):
    """Five quads of a block that stands on the floor."""
    quads = [top]
    for i in range(4):
        (ax, ay, az), (bx, by, bz) = top[i], top[(i + 1) % 4]
        quads.append([(ax, 0, az), (ax, ay, az), (bx, by, bz), (bx, 0, bz)])
    return quads


CORNELL = [  # name, material, quads
    ("floor", 0, [[(552.8, 0, 0), (0, 0, 0), (0, 0, 559.2), (549.6, 0, 559.2)]]),
    (
        "ceiling",
        0,
        [[OUTER[i], OUTER[(i + 1) % 4], LIGHT[(i + 1) % 4], LIGHT[i]] for i in range(4)],
    ),
    (
        "back wall",
        0,
        [[(549.6, 0, 559.2), (0, 0, 559.2), (0, CEILING, 559.2), (556, CEILING, 559.2)]],
    ),
    ("right wall", 2, [[(0, 0, 559.2), (0, 0, 0), (0, CEILING, 0), (0, CEILING, 559.2)]]),
    (
        "left wall",
        1,
        [[(552.8, 0, 0), (549.6, 0, 559.2), (556, CEILING, 559.2), (556, CEILING, 0)]],
    ),
    ("light", 3, [LIGHT]),
    ("short block", 0, block(SHORT_TOP)),
    ("tall block", 0, block(TALL_TOP)),
]


def cornell_gltf():
    """The Cornell box as a glTF 2.0 object, in metres, with an embedded buffer."""
    scene = Gltf(
        "cornell",
        [
            material("white", [0.73, 0.71, 0.68]),
            material("red", [0.57, 0.043, 0.044]),
            material("green", [0.105, 0.378, 0.076]),
            material("light", [0.78, 0.78, 0.78], emissive=[1.0, 0.86, 0.66], strength=18.0),
        ],
    )
    for name, number, quads in CORNELL:
        points = (np.array(quads, dtype=np.float64).reshape(-1, 3) / 1000).astype("<f4")
        corners = np.array([0, 1, 2, 0, 2, 3])
        indices = np.concatenate([4 * i + corners for i in range(len(quads))])
        scene.mesh(name, (points, indices), number)
    # Position (278, 273, -800), looking along +z; focal length 0.035, film 0.025.
    scene.camera(0.686686, translation=[0.278, 0.273, -0.8], rotation=[0, 1, 0, 0])
    return scene.json()


# --- PLY ----------------------------------------------------------------------------------------


def ply_bytes(vertices, triangles, materials=None):
    """Binary PLY of float32 vertices and int32 triangles, with a material id a face when given."""
    faces = [("n", "u1"), ("v", "<i4", 3)] + ([("m", "<u2")] if materials is not None else [])
    array = np.empty(len(triangles), dtype=faces)
    array["n"] = 3
    array["v"] = triangles
    if materials is not None:
        array["m"] = materials
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(vertices)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face {len(triangles)}\n"
        "property list uchar int vertex_indices\n"
        + ("property ushort material\n" if materials is not None else "")
        + "end_header\n"
    )
    return header.encode() + np.asarray(vertices, dtype="<f4").tobytes() + array.tobytes()


# --- Knot ---------------------------------------------------------------------------------------

SEGMENTS, SIDES = 1536, 32  # along and around the tube: 98,304 triangles


def knot():
    """A (3, 5) torus knot whose tube swells and is ribbed: vertices and triangles."""
    t = np.linspace(0, 2 * np.pi, SEGMENTS, endpoint=False)
    p, q = 3, 5
    radius = 2.0 + 0.8 * np.cos(q * t)
    centre = np.stack([radius * np.cos(p * t), 0.8 * np.sin(q * t), radius * np.sin(p * t)], axis=1)
    forward = np.roll(centre, -1, axis=0) - np.roll(centre, 1, axis=0)
    forward /= np.linalg.norm(forward, axis=1, keepdims=True)
    # A frame that closes without a twist: perpendicular to the direction from the torus' ring.
    ring = np.stack([2.0 * np.cos(p * t), 0 * t, 2.0 * np.sin(p * t)], axis=1)
    side = np.cross(forward, centre - ring)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    up = np.cross(side, forward)
    a = np.linspace(0, 2 * np.pi, SIDES, endpoint=False)[None, :]
    s = t[:, None]
    thick = 0.24 + 0.05 * np.sin(9 * s) + 0.03 * np.cos(6 * a + 60 * s) + 0.015 * np.sin(256 * s)
    ribs = np.cos(a)[..., None] * side[:, None, :] + np.sin(a)[..., None] * up[:, None, :]
    vertices = (centre[:, None, :] + thick[..., None] * ribs).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(SEGMENTS), np.arange(SIDES), indexing="ij")
    i2, j2 = (i + 1) % SEGMENTS, (j + 1) % SIDES
    v00, v01, v10, v11 = i * SIDES + j, i * SIDES + j2, i2 * SIDES + j, i2 * SIDES + j2
    quads = np.stack([v00, v10, v11, v00, v11, v01], axis=-1)
    return vertices, quads.reshape(-1, 3)


def sphere(centre, radius, rings=24, around=48):
    """A sphere of latitudes and longitudes, its poles single vertices."""
    theta = np.pi * np.arange(1, rings) / rings
    phi = 2 * np.pi * np.arange(around) / around
    x = np.sin(theta)[:, None] * np.cos(phi)
    z = np.sin(theta)[:, None] * np.sin(phi)
    y = np.broadcast_to(np.cos(theta)[:, None], x.shape)
    body = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    vertices = np.concatenate([body, [[0, 1, 0], [0, -1, 0]]]) * radius + centre
    triangles = []
    for j in range(around):
        k = (j + 1) % around
        last = (rings - 2) * around
        triangles += [(len(body), k, j), (len(body) + 1, last + j, last + k)]
        for r in range(0, last, around):
            triangles += [(r + j, r + k, r + around + k), (r + j, r + around + k, r + around + j)]
    return vertices, np.array(triangles)


def floor(size, tiles):
    """A square floor at y = 0 and the colour, 0 or 1, of each of its triangles: a chessboard."""
    line = np.linspace(-size, size, tiles + 1)
    x, z = np.meshgrid(line, line, indexing="ij")
    vertices = np.stack([x, 0 * x, z], axis=-1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(tiles), np.arange(tiles), indexing="ij")
    v = i * (tiles + 1) + j
    quads = np.stack([v, v + 1, v + tiles + 2, v, v + tiles + 2, v + tiles + 1], axis=-1)
    return vertices, quads.reshape(-1, 3), np.repeat((i + j).reshape(-1) % 2, 2)


def knot_scene():
    """The knot above a chessboard in a room, with four spheres: vertices, triangles, materials."""
    size, height = 6.0, 6.0
    parts = []
    vertices, triangles, colour = floor(size, 24)
    parts.append((vertices, triangles, colour))
    box = np.array([(x, y, z) for x in (-size, size) for y in (0, height) for z in (-size, size)])
    walls = np.array([(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (1, 5, 7), (1, 7, 3), (0, 2, 6)])
    walls = np.concatenate([walls, [(0, 6, 4), (2, 3, 7), (2, 7, 6)]])
    parts.append((box, walls, np.array([3, 3, 4, 4, 2, 2, 2, 2, 2, 2])))
    for k, (x, z) in enumerate([(-4.2, -4.2), (4.2, -4.2), (-4.2, 4.2), (4.2, 4.2)]):
        vertices, triangles = sphere(np.array([x, 0.9, z]), 0.9)
        parts.append((vertices, triangles, np.full(len(triangles), 6 + k % 2)))
    vertices, triangles = knot()
    parts.append((vertices + np.array([0, 2.4, 0]), triangles, np.full(len(triangles), 5)))

    base = np.cumsum([0] + [len(part[0]) for part in parts])
    vertices = np.concatenate([part[0] for part in parts])
    vertices = np.round(vertices * 65536) / 65536
    triangles = np.concatenate([part[1] + base[k] for k, part in enumerate(parts)])
    return vertices, triangles, np.concatenate([part[2] for part in parts])


KNOT_MATERIALS = [
    ("tile light", [0.75, 0.72, 0.66]),
    ("tile dark", [0.12, 0.13, 0.16]),
    ("wall", [0.70, 0.70, 0.68]),
    ("wall left", [0.55, 0.25, 0.18]),
    ("wall right", [0.18, 0.35, 0.50]),
    ("knot", [0.80, 0.52, 0.16]),
    ("sphere green", [0.25, 0.55, 0.28]),
    ("sphere violet", [0.45, 0.30, 0.60]),
]


def write_json(path, value, **style):
    path.write_text(json.dumps(value, **style) + "\n")


def make_small(folder):
    """Write the scenes that are kept in git."""
    folder.mkdir(parents=True, exist_ok=True)
    write_json(folder / "cornell.gltf", cornell_gltf(), separators=(",", ":"))
    (folder / "one_triangle.obj").write_text(
        "# One triangle in the plane z = 0.\nv -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n"
    )
    camera = {"eye": [0, 0, 4], "target": [0, 0, 0], "up": [0, 1, 0], "fov_y_deg": 40}
    write_json(folder / "one_triangle.json", {"camera": camera}, indent=1)
    nothing = np.empty((0, 3))
    (folder / "empty.ply").write_bytes(ply_bytes(nothing, nothing))
    write_json(folder / "empty.json", {"camera": camera}, indent=1)


def whole(path, data):
    """Write a file whole or not at all."""
    partial = path.with_suffix(f".{os.getpid()}.part")
    partial.write_bytes(data)
    partial.replace(path)


def make_knot(folder):
    """Write `knot.ply` and `knot.json`; the mesh last, as the Makefile takes it for the scene."""
    vertices, triangles, materials = knot_scene()
    write_json(
        folder / "knot.json",
        {
            "name": "knot",
            "triangles": len(triangles),
            "vertices": len(vertices),
            "materials": [{"name": n, "Kd": kd} for n, kd in KNOT_MATERIALS],
            "lights": [[-3.0, 5.4, 3.5, 1.0, 0.95, 0.85], [3.5, 5.0, 4.5, 0.45, 0.5, 0.6]],
            "camera": {
                "eye": [0.6, 4.0, 5.8],
                "target": [0, 2.1, 0],
                "up": [0, 1, 0],
                "fov_y_deg": 55,
            },
        },
        indent=1,
    )
    whole(folder / "knot.ply", ply_bytes(vertices, triangles, materials))


GALLERY = {
    "cornell_glass": lambda: gallery_scenes.cornell_glass(
        [part for part in CORNELL if "block" not in part[0] and part[0] != "light"], LIGHT
    ),
    "pavilion": gallery_scenes.pavilion,
    "still_life": gallery_scenes.still_life,
    "windmill": gallery_scenes.windmill,
}


def make_large(name, folder):
    """Write a scene that is too large for git."""
    folder.mkdir(parents=True, exist_ok=True)
    if name == "knot":
        make_knot(folder)
        return
    scene, beside = GALLERY[name]()
    if beside:
        write_json(folder / f"{name}.json", beside, indent=1)
    whole(folder / f"{name}.gltf", json.dumps(scene, separators=(",", ":")).encode() + b"\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    names = ["knot", *GALLERY]
    parser.add_argument("--large", choices=names, help="write only this one, into --to")
    parser.add_argument("--to", type=Path, default=ROOT / "build/scenes", help="folder for it")
    args = parser.parse_args()
    if args.large:
        make_large(args.large, args.to)
    else:
        make_small(ROOT / "scenes")


if __name__ == "__main__":
    main()
