# SPDX-License-Identifier: Apache-2.0
"""Shapes of triangles: vertices [N,3] and triangles [M,3], counterclockwise from outside."""

import numpy as np

Shape = tuple[np.ndarray, np.ndarray]


def rounded(vertices: np.ndarray) -> np.ndarray:
    """To multiples of 2^-16, so that every machine writes the same bytes."""
    return np.round(np.asarray(vertices, dtype=np.float64) * 65536) / 65536


def together(*shapes: Shape) -> Shape:
    """Shapes as one."""
    base = np.cumsum([0] + [len(vertices) for vertices, _ in shapes])
    triangles = [triangles + base[k] for k, (_, triangles) in enumerate(shapes)]
    return np.concatenate([vertices for vertices, _ in shapes]), np.concatenate(triangles)


def moved(shape: Shape, offset) -> Shape:
    return rounded(shape[0] + np.asarray(offset, dtype=np.float64)), shape[1]


def turned_about_y(shape: Shape, degrees: float) -> Shape:
    a = np.radians(degrees)
    x, y, z = shape[0].T
    turned = np.stack([x * np.cos(a) + z * np.sin(a), y, z * np.cos(a) - x * np.sin(a)], axis=1)
    return rounded(turned), shape[1]


def grid(rows: int, columns: int, closed: bool) -> np.ndarray:
    """Triangles of a grid of vertices, row by row; `closed`: its last column meets the first."""
    i, j = np.meshgrid(np.arange(rows - 1), np.arange(columns - (not closed)), indexing="ij")
    k = (j + 1) % columns
    quads = [i * columns + j, (i + 1) * columns + j, (i + 1) * columns + k]
    quads += [i * columns + j, (i + 1) * columns + k, i * columns + k]
    return np.stack(quads, axis=-1).reshape(-1, 3)


def lathe(profile, around: int = 48) -> Shape:
    """A profile of (radius, height) from the top down, turned about y."""
    profile = np.asarray(profile, dtype=np.float64)
    angle = 2 * np.pi * np.arange(around) / around
    x = profile[:, :1] * np.cos(angle)
    z = -profile[:, :1] * np.sin(angle)
    y = np.broadcast_to(profile[:, 1:], x.shape)
    vertices = rounded(np.stack([x, y, z], axis=-1).reshape(-1, 3))
    triangles = grid(len(profile), around, True)
    # At a point of the axis one of the two triangles of a quad has no area.
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return vertices, triangles[area > 0]


def curve(points, steps: int) -> np.ndarray:
    """Points of a Catmull-Rom spline through (radius, height) pairs, `steps` between two."""
    p = np.asarray(points, dtype=np.float64)
    p = np.concatenate([[2 * p[0] - p[1]], p, [2 * p[-1] - p[-2]]])
    t = (np.arange(steps) / steps)[:, None]
    parts = []
    for k in range(1, len(p) - 2):
        a, b, c, d = p[k - 1 : k + 3]
        parts.append(
            0.5
            * (
                2 * b
                + (c - a) * t
                + (2 * a - 5 * b + 4 * c - d) * t**2
                + (3 * b - a - 3 * c + d) * t**3
            )
        )
    out = np.concatenate([*parts, p[-2:-1]])
    out[:, 0] = np.maximum(out[:, 0], 0.0)
    return out


def ball(radius: float, rings: int = 64, around: int = 128) -> Shape:
    theta = np.pi * np.arange(rings + 1) / rings
    profile = radius * np.stack([np.sin(theta), np.cos(theta)], axis=1)
    profile[[0, -1], 0] = 0.0
    return lathe(profile, around)


def ring(radius: float, thickness: float, around: int = 96, across: int = 32) -> Shape:
    """A torus that lies on its side, in the plane y = 0."""
    a = 2 * np.pi * np.arange(across + 1) / across
    profile = np.stack([radius + thickness * np.cos(a), thickness * np.sin(a)], axis=1)
    profile[-1] = profile[0]
    return lathe(profile[::-1], around)


def box(low, high) -> Shape:
    (x0, y0, z0), (x1, y1, z1) = low, high
    vertices = [(x, y, z) for x in (x0, x1) for y in (y0, y1) for z in (z0, z1)]
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    return rounded(np.array(vertices)), np.array(triangles)


def quad(a, b, c, d) -> Shape:
    return rounded(np.array([a, b, c, d])), np.array([(0, 1, 2), (0, 2, 3)])


def prism(outline, depth: float) -> Shape:
    """A convex outline of (x, y), counterclockwise, from z = -depth / 2 to depth / 2."""
    points = np.asarray(outline, dtype=np.float64)
    n = len(points)
    front = np.concatenate([points, np.full((n, 1), depth / 2)], axis=1)
    back = np.concatenate([points, np.full((n, 1), -depth / 2)], axis=1)
    triangles = [(0, k, k + 1) for k in range(1, n - 1)]
    triangles += [(n, n + k + 1, n + k) for k in range(1, n - 1)]
    for k in range(n):
        m = (k + 1) % n
        triangles += [(k, n + k, n + m), (k, n + m, m)]
    return rounded(np.concatenate([front, back])), np.array(triangles)
