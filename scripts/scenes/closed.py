# SPDX-License-Identifier: Apache-2.0
"""Closed meshes, through which no ray may slip: a sphere, a torus, the torus knot alone."""

import numpy as np

from scenes.knot import knot
from scenes.ply import ply_bytes

GRID = 2.0**16  # coordinates are multiples of its inverse
CAMERA = {"target": [0, 0, 0], "up": [0, 1, 0], "fov_y_deg": 40}


def on_grid(vertices):
    return np.round(np.asarray(vertices, dtype=float) * GRID) / GRID


def icosphere(levels=4):
    """A unit icosahedron, each triangle split in four `levels` times: vertices and triangles."""
    golden = (1 + 5**0.5) / 2
    corners = [(-1, golden, 0), (1, golden, 0), (-1, -golden, 0), (1, -golden, 0)]
    corners += [(c[2], c[0], c[1]) for c in corners[:4]] + [(c[1], c[2], c[0]) for c in corners[:4]]
    vertices = [np.array(c) / np.linalg.norm(c) for c in corners]
    side = min(np.linalg.norm(vertices[0] - v) for v in vertices[1:])
    near = [
        [j for j, w in enumerate(vertices) if 0 < np.linalg.norm(v - w) < 1.01 * side]
        for v in vertices
    ]
    triangles = []
    for a in range(12):
        for b in near[a]:
            for c in near[a]:
                if a < b < c and c in near[b]:
                    turns = np.linalg.det([vertices[a], vertices[b], vertices[c]]) > 0
                    triangles.append((a, b, c) if turns else (a, c, b))
    for _ in range(levels):
        middles, finer = {}, []

        def middle(i, j, middles=middles):
            key = min(i, j), max(i, j)
            if key not in middles:
                point = vertices[i] + vertices[j]
                middles[key] = len(vertices)
                vertices.append(point / np.linalg.norm(point))
            return middles[key]

        for a, b, c in triangles:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            finer += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        triangles = finer
    return on_grid(vertices), np.array(triangles)


def torus(around=96, across=48):
    """A ring of radius 1 and a tube of radius 0.4: vertices and triangles."""
    a = 2 * np.pi * np.arange(around)[:, None] / around
    b = 2 * np.pi * np.arange(across)[None, :] / across
    r = 1 + 0.4 * np.cos(b)
    places = [r * np.cos(a), r * np.sin(a), np.broadcast_to(0.4 * np.sin(b), (around, across))]
    vertices = np.stack(places, axis=-1).reshape(-1, 3)
    triangles = []
    for i in range(around):
        for k in range(across):
            here, next_ring = i * across, (i + 1) % around * across
            up = (k + 1) % across
            triangles += [
                (here + k, next_ring + k, next_ring + up),
                (here + k, next_ring + up, here + up),
            ]
    return on_grid(vertices), np.array(triangles)


def tube():
    """The knot of `knot.ply` without its room."""
    vertices, triangles = knot()
    return on_grid(vertices), np.asarray(triangles)


def files(mesh, eye):
    """The description beside a mesh, and its bytes."""
    vertices, triangles = mesh()
    return {"camera": {"eye": eye, **CAMERA}}, ply_bytes(vertices, triangles)
