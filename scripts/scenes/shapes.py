# SPDX-License-Identifier: Apache-2.0
"""Shapes as arrays: vertices [N,3], and triangles [M,3] whose fronts look outward.

A shape is the pair of both. Nothing is rounded here: what writes a file does that.
"""

import numpy as np


def joined(*shapes):
    """One shape of several."""
    base = np.cumsum([0] + [len(vertices) for vertices, _ in shapes])
    triangles = [triangles + base[k] for k, (_, triangles) in enumerate(shapes)]
    return np.concatenate([vertices for vertices, _ in shapes]), np.concatenate(triangles)


def placed(shape, at=(0, 0, 0), size=1.0, turn=0.0):
    """A shape scaled, turned about the y axis by degrees, and moved."""
    vertices, triangles = shape
    angle = np.radians(turn)
    c, s = np.cos(angle), np.sin(angle)
    turned = (vertices * np.asarray(size)) @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
    return turned + np.asarray(at), triangles


def box(low, high):
    """A box between two corners."""
    corners = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    vertices = np.asarray(low) + corners * (np.asarray(high) - np.asarray(low))
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return vertices, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def grid(columns, rows, closed=False):
    """Triangles between vertices in rows; `closed`: the last column meets the first."""
    j = np.arange(columns if closed else columns - 1)
    i, j = np.meshgrid(np.arange(rows - 1) * columns, j, indexing="ij")
    k = (j + 1) % columns
    v00, v01, v10, v11 = i + j, i + k, i + columns + j, i + columns + k
    return np.stack([v00, v10, v11, v00, v11, v01], axis=-1).reshape(-1, 3)


def lathe(profile, around, ribs=0, depth=0.0):
    """A profile of (radius, y), from the bottom up, turned about the y axis.

    A radius of 0, at an end only, is a single vertex. `ribs` flutes are `depth` of the radius deep.
    """
    profile = np.asarray(profile, dtype=np.float64)
    phi = 2 * np.pi * np.arange(around) / around
    flute = 1 - depth * np.abs(np.sin(ribs * phi / 2))
    ends = [int(profile[0, 0] == 0), int(profile[-1, 0] == 0)]
    body = profile[ends[0] : len(profile) - ends[1]]
    radius = body[:, :1] * flute
    height = np.broadcast_to(body[:, 1:], radius.shape)
    vertices = np.stack([radius * np.cos(phi), height, radius * np.sin(phi)], axis=-1)
    vertices = vertices.reshape(-1, 3)
    triangles = [grid(around, len(body), closed=True)]
    ring = np.arange(around)
    after = (ring + 1) % around
    if ends[0]:
        tip = np.full(around, len(vertices))
        vertices = np.concatenate([vertices, [[0, profile[0, 1], 0]]])
        triangles.append(np.stack([tip, ring, after], axis=-1))
    if ends[1]:
        top = (len(body) - 1) * around
        tip = np.full(around, len(vertices))
        vertices = np.concatenate([vertices, [[0, profile[-1, 1], 0]]])
        triangles.append(np.stack([tip, top + after, top + ring], axis=-1))
    return vertices, np.concatenate(triangles)


def drum(radius, low, high, around, ribs=0, depth=0.0):
    """A solid cylinder with both of its ends."""
    profile = [(0, low), (radius, low), (radius, high), (0, high)]
    return lathe(profile, around, ribs, depth)


def torus(radius, tube, around, sides):
    """A torus about the y axis."""
    t = 2 * np.pi * np.arange(around)[:, None] / around
    a = 2 * np.pi * np.arange(sides)[None, :] / sides
    out = radius + tube * np.cos(a)
    vertices = np.stack([out * np.cos(t), tube * np.sin(a) + 0 * t, out * np.sin(t)], axis=-1)
    i, j = np.meshgrid(np.arange(around), np.arange(sides), indexing="ij")
    i2, j2 = (i + 1) % around * sides, (j + 1) % sides
    i = i * sides
    quads = np.stack([i + j, i + j2, i2 + j2, i + j, i2 + j2, i2 + j], axis=-1)
    return vertices.reshape(-1, 3), quads.reshape(-1, 3)


def ball(parts):
    """A sphere of radius 1: an icosahedron's 20 faces, each in parts^2 triangles of like size."""
    g = (1 + np.sqrt(5)) / 2
    corners = np.array([(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0)])
    corners = np.concatenate([corners, corners[:, [2, 0, 1]], corners[:, [1, 2, 0]]])
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4)]
    faces += [(11, 10, 2), (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8)]
    faces += [(3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    steps = [(i, j) for i in range(parts + 1) for j in range(parts + 1 - i)]
    number = {step: k for k, step in enumerate(steps)}
    up = [((i, j), (i + 1, j), (i, j + 1)) for i, j in steps if i + j < parts]
    down = [((i + 1, j), (i + 1, j + 1), (i, j + 1)) for i, j in steps if i + j < parts - 1]
    local = np.array([[number[step] for step in corner] for corner in up + down])
    weights = np.array([(parts - i - j, i, j) for i, j in steps]) / parts
    vertices = np.concatenate([weights @ corners[list(face)] for face in faces])
    vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
    triangles = np.concatenate([local + k * len(steps) for k in range(len(faces))])
    # Faces share the vertices of their edges.
    _, first, same = np.unique(
        np.round(vertices * 2**20), axis=0, return_index=True, return_inverse=True
    )
    return vertices[first], same.reshape(-1)[triangles]


def lump(parts, seed, rough=0.12):
    """A ball with waves in it: a crown of leaves, a cloud."""
    vertices, triangles = ball(parts)
    x, y, z = (vertices * (3.1, 3.7, 2.9) + seed).T
    wave = np.sin(x) * np.sin(1.7 * y + 1) * np.sin(z + 2) + 0.5 * np.sin(2.3 * x + z) * np.sin(
        3 * y
    )
    return vertices * (1 + rough * wave)[:, None], triangles


def cloud(seed):
    """Lumps side by side, about 3 wide."""
    puffs = [(0, 0, 1.0), (1.0, -0.15, 0.75), (-1.05, -0.2, 0.7), (0.45, 0.35, 0.7)]
    puffs += [(1.8, -0.3, 0.45)]
    lumps = [
        placed(lump(7, seed + k, 0.08), at=(x, y, 0), size=(1.25 * r, 0.8 * r, r))
        for k, (x, y, r) in enumerate(puffs)
    ]
    return joined(*lumps)


def ground(size, parts, height):
    """A square of side 2 x size about the origin; `height` gives y for arrays of x and z."""
    line = np.linspace(-size, size, parts + 1)
    x, z = np.meshgrid(line, line, indexing="ij")
    vertices = np.stack([x, height(x, z) + 0 * x, z], axis=-1).reshape(-1, 3)
    return vertices, grid(parts + 1, parts + 1)[:, ::-1]
