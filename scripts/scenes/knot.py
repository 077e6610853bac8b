# SPDX-License-Identifier: Apache-2.0
"""A ribbed torus knot above a chessboard in a room, with four spheres: a PLY and what it lacks."""

import numpy as np

from scenes.ply import ply_bytes

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


def files():
    """The description beside the mesh, and the bytes of the mesh."""
    vertices, triangles, materials = knot_scene()
    beside = {
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
    }
    return beside, ply_bytes(vertices, triangles, materials)
