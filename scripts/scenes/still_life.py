# SPDX-License-Identifier: Apache-2.0
"""Metals and glazes on a table under two soft boxes, through a lens that is wide open."""

import numpy as np

from scenes.gltf import Gltf, about
from scenes.shapes import ball, drum, grid, lathe, torus

VASE = [(0, 0), (0.30, 0), (0.34, 0.03), (0.30, 0.10), (0.36, 0.25), (0.50, 0.50), (0.56, 0.75)]
VASE += [(0.52, 1.00), (0.38, 1.22), (0.24, 1.38), (0.19, 1.52), (0.20, 1.66), (0.28, 1.78)]
VASE += [(0.25, 1.77), (0.17, 1.64), (0.15, 1.52), (0.10, 1.45), (0, 1.44)]
BOWL = [(0, 0), (0.20, 0), (0.22, 0.03), (0.16, 0.07), (0.42, 0.20), (0.60, 0.40), (0.68, 0.62)]
BOWL += [(0.65, 0.63), (0.56, 0.43), (0.38, 0.25), (0, 0.18)]

# The lens is what glTF has no words for, so the whole camera stands beside the file.
BESIDE = {
    "camera": {
        "eye": [0.0, 2.05, 6.4],
        "target": [0.0, 0.62, 0.0],
        "up": [0, 1, 0],
        "fov_y_deg": 27,
        "aperture": 0.16,
        "focus_distance": 5.75,
    },
    "background": [0.06, 0.07, 0.09],
}


def smooth(profile, parts=6):
    """A curve through the points of a profile (Catmull and Rom), its ends as they are."""
    p = np.asarray(profile, dtype=np.float64)
    p = np.concatenate([p[:1], p, p[-1:]])
    t = np.arange(parts)[:, None] / parts
    curve = []
    for a, b, c, d in zip(p, p[1:], p[2:], p[3:], strict=False):
        curve.append(
            0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t**2)
            + 0.5 * (3 * b - a - 3 * c + d) * t**3
        )
    curve = np.concatenate([*curve, p[-1:]])
    inside = (curve[:, 0] > 1e-9) | (np.arange(len(curve)) % (len(curve) - 1) == 0)
    return np.maximum(curve, 0)[inside]


def sweep(width, depth, height, radius, parts=24):
    """A table that bends up into a wall, so that there is no edge behind the things."""
    a = np.pi / 2 * np.arange(parts + 1) / parts
    z = np.concatenate([[depth], -depth + radius - radius * np.sin(a), [-depth]])
    y = np.concatenate([[0], radius - radius * np.cos(a), [height]])
    rows = [np.stack([np.full_like(z, x), y, z], axis=-1) for x in (width, -width)]
    return np.stack(rows, axis=1).reshape(-1, 3), grid(2, len(z))


def panel(width, height):
    """A rectangle that shines towards -y."""
    corners = [(-width, 0, -height), (width, 0, -height), (width, 0, height), (-width, 0, height)]
    return np.array(corners) / 2, np.array([(0, 1, 2), (0, 2, 3)])


def still_life():
    scene = Gltf("still_life")
    paper = scene.material("paper", [0.32, 0.34, 0.36])
    gold = scene.material("gold", [1.0, 0.77, 0.34], metal=1.0, rough=0.22)
    copper = scene.material("copper", [0.95, 0.60, 0.48], metal=1.0, rough=0.32)
    chrome = scene.material("chrome", [0.90, 0.91, 0.93], metal=1.0, rough=0.0)
    steel = scene.material("blued steel", [0.30, 0.45, 0.72], metal=1.0, rough=0.45)
    red = scene.material("red glaze", [0.62, 0.03, 0.03], rough=0.12)
    jade = scene.material("jade glaze", [0.05, 0.36, 0.24], rough=0.25)
    ivory = scene.material("ivory", [0.80, 0.74, 0.62], rough=0.5)
    black = scene.material("black", [0.02, 0.02, 0.025], rough=0.2)
    day = scene.material("soft box", [0, 0, 0], emissive=[1.0, 0.96, 0.90], strength=4.5)
    warm = scene.material("warm box", [0, 0, 0], emissive=[1.0, 0.62, 0.32], strength=5.0)

    scene.put("table", (sweep(9, 6, 9, 3.5), paper))
    scene.put("vase", (lathe(smooth(VASE), 96), copper), at=[-0.95, 0, -0.75])
    scene.put("bowl", (lathe(smooth(BOWL), 96), jade), at=[1.08, 0, -0.25])
    sphere = scene.mesh("sphere", (ball(24), chrome))
    scene.node("chrome sphere", mesh=sphere, at=[0.13, 0.48, -0.15], size=0.48)
    for name, material, place, size in [
        ("red sphere", red, [-0.62, 0.25, 0.62], 0.25),
        ("steel sphere", steel, [0.55, 0.21, 0.82], 0.21),
        ("black sphere", black, [-1.55, 0.2, 0.25], 0.2),
        ("ivory egg", ivory, [1.0, 0.55, -0.2], [0.19, 0.25, 0.19]),
        ("red fruit", red, [1.28, 0.52, -0.32], 0.21),
        ("gold fruit", gold, [1.12, 0.56, 0.08], 0.17),
    ]:
        scene.put(name, (ball(20), material), at=place, size=size)
    scene.put("ring", (torus(0.27, 0.085, 96, 32), gold), at=[-0.03, 0.085, 0.95])
    scene.put("plinth", (drum(0.34, 0, 0.16, 96), ivory), at=[2.15, 0, -1.5])
    scene.put("far sphere", (ball(20), gold), at=[2.15, 0.5, -1.5], size=0.34)
    scene.put("far ring", (torus(0.34, 0.12, 96, 32), steel), at=[-2.3, 0.12, -1.7])

    scene.put("soft box", (panel(5.0, 3.6), day), at=[-1.6, 4.8, 1.4])
    scene.put(
        "warm box", (panel(2.4, 3.0), warm), at=[5.0, 1.9, 1.2], rotation=about((0, 0, 1), -90)
    )
    return scene.document()
