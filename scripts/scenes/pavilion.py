# SPDX-License-Identifier: Apache-2.0
"""A round temple by a pool, between cypresses, in the low sun."""

import numpy as np

from scenes.gltf import Gltf
from scenes.shapes import ball, box, cloud, drum, ground, joined, lathe, lump, placed

BESIDE = {"background": [0.30, 0.54, 1.0]}  # the sky, which glTF has no words for

COLUMNS, RING = 10, 2.7
TREES = [(-10.5, -5, 1.25), (-13.5, 1, 1.0), (10.8, -7, 1.35), (14.5, -1, 1.05)]  # x, z, size
TREES += [(-8.5, -12, 1.5), (8.0, -14, 1.5), (-17, -9, 1.4), (18, -11, 1.5), (2.5, -17, 1.3)]
TREES += [(-3.5, -18, 1.4)]
CYPRESS = [(0, 0.25), (0.34, 0.45), (0.50, 0.95), (0.52, 1.6), (0.44, 2.5), (0.28, 3.5), (0, 4.6)]
DOME = [(np.cos(a), np.sin(a)) for a in np.radians(np.arange(0, 90, 6))]


def hills(x, z):
    """A lawn that rises to hills far behind."""
    far = np.clip((np.hypot(x, z) - 26) / 60, 0, 1)
    behind = np.clip((10 - z) / 30, 0, 1)
    wave = 5.5 + 3.2 * np.sin(0.11 * x + 0.7) + 2.2 * np.sin(0.23 * x - 0.06 * z)
    return far * behind * np.maximum(wave, 0) * 1.6 - 0.02


def column():
    """A column with its base and its capital, 3.4 high."""
    shaft = [(0.27, 0.22), (0.272, 1.2), (0.255, 2.2), (0.225, 3.12)]
    base = [(0, 0), (0.37, 0), (0.37, 0.10), (0.32, 0.13), (0.33, 0.19), (0.28, 0.22), (0, 0.22)]
    head = [(0, 3.12), (0.24, 3.12), (0.26, 3.18), (0.34, 3.26), (0, 3.26)]
    slab = box((-0.36, 3.26, -0.36), (0.36, 3.4, 0.36))
    return joined(lathe(base, 40), lathe(shaft, 120, 20, 0.09), lathe(head, 40), slab)


def temple(scene, stone, marble, roof, gold):
    """Steps, columns, ring and dome about the origin."""
    for k, radius in enumerate((4.1, 3.7, 3.3)):
        scene.put(f"step {k}", (drum(radius, 0.22 * k, 0.22 * (k + 1), 120), stone))
    mesh = scene.mesh("column", (column(), marble))
    for k in range(COLUMNS):
        a = 2 * np.pi * (k + 0.5) / COLUMNS + np.pi / 2
        scene.node(f"column {k}", mesh=mesh, at=[RING * np.cos(a), 0.66, RING * np.sin(a)])
    ring = [(2.42, 0), (3.0, 0), (3.0, 0.24), (3.05, 0.26), (3.05, 0.5), (3.25, 0.6), (3.25, 0.7)]
    ring += [(2.42, 0.7), (2.42, 0)]
    scene.put("ring", (lathe(ring, 160), marble), at=[0, 4.06, 0])
    scene.put("drum", (drum(2.85, 0, 0.3, 160), marble), at=[0, 4.76, 0])
    dome = [(2.75 * x, 2.1 * y) for x, y in DOME] + [(0, 2.1)]
    scene.put("dome", (lathe(dome, 160, 16, 0.03), roof), at=[0, 5.06, 0])
    tip = [(0, 0), (0.28, 0), (0.22, 0.10), (0.10, 0.16), (0.10, 0.24), (0, 0.24)]
    scene.put("finial", (lathe(tip, 48), marble), at=[0, 7.12, 0])
    scene.put("finial ball", (ball(12), gold), at=[0, 7.52, 0], size=0.2)
    foot = [(0, 0), (0.5, 0), (0.5, 0.14), (0.34, 0.22), (0.30, 0.95), (0.42, 1.06), (0.42, 1.16)]
    scene.put("pedestal", (lathe([*foot, (0, 1.16)], 64), stone), at=[0, 0.66, 0])
    scene.put("orb", (ball(28), gold), at=[0, 2.36, 0], size=0.54)


def garden(scene, stone, grass, gravel, leaves, wood, water):
    """Lawn, pool, hedges and trees."""
    scene.put("lawn", (ground(90, 90, hills), grass))
    path = joined(
        box((-5.4, -0.1, 3.2), (5.4, 0.02, 5.6)),
        box((-3.6, -0.1, 5.6), (-2.3, 0.02, 17)),
        box((2.3, -0.1, 5.6), (3.6, 0.02, 17)),
        drum(5.4, -0.1, 0.021, 120),
    )
    scene.put("path", (path, gravel))
    rim = joined(
        box((-2.3, -0.1, 5.6), (2.3, 0.16, 5.95)),
        box((-2.3, -0.1, 5.95), (-1.95, 0.16, 17)),
        box((1.95, -0.1, 5.95), (2.3, 0.16, 17)),
    )
    scene.put("rim", (rim, stone))
    scene.put("water", (box((-1.95, -0.1, 5.95), (1.95, 0.07, 17)), water))
    hedge = joined(
        *(
            box((s * 4.6 - 0.4, 0, z), (s * 4.6 + 0.4, 0.75, z + 2.1))
            for s in (-1, 1)
            for z in (6, 9)
        )
    )
    scene.put("hedges", (hedge, leaves[1]))
    tall = scene.mesh("cypress", (lathe(CYPRESS, 14), leaves[0]), (drum(0.09, 0, 0.4, 10), wood))
    places = [(s * 6.3, z, 1 + 0.08 * ((k * 7) % 5 - 2)) for s in (-1, 1)
              for k, z in enumerate((6.6, 3.2, -0.4, -5.6))]  # fmt: skip
    for k, (x, z, size) in enumerate(places):
        scene.node(f"cypress {k}", mesh=tall, at=[x, 0, z], size=size * 1.12)
    trunk = drum(0.2, 0, 2.2, 12)
    for k, (x, z, size) in enumerate(TREES):
        crown = joined(
            placed(lump(6, k), at=(0, 3.1, 0), size=1.55),
            placed(lump(5, k + 9), at=(0.9, 2.6, 0.4), size=1.05),
            placed(lump(5, k + 5), at=(-0.8, 2.7, -0.3), size=1.1),
        )
        scene.put(f"tree {k}", (crown, leaves[2 - k % 2]), (trunk, wood), at=[x, 0, z], size=size)


def clouds(scene, white):
    """Above the trees."""
    for k, (x, y, z, size) in enumerate(
        [(-22, 19, -42, 3.2), (24, 22, -48, 3.6), (38, 14, -44, 2.6)]
    ):
        scene.put(f"cloud {k}", (cloud(3 * k), white), at=[x, y, z], size=size)


def pavilion():
    scene = Gltf("pavilion")
    stone = scene.material("stone", [0.62, 0.58, 0.52])
    marble = scene.material("marble", [0.84, 0.80, 0.73])
    roof = scene.material("copper roof", [0.22, 0.47, 0.42])
    gold = scene.material("gold", [1.0, 0.76, 0.33], metal=1.0, rough=0.0)
    grass = scene.material("grass", [0.17, 0.30, 0.07])
    gravel = scene.material("gravel", [0.60, 0.50, 0.37])
    dark = scene.material("cypress", [0.05, 0.13, 0.05])
    hedge = scene.material("hedge", [0.08, 0.20, 0.05])
    crown = scene.material("crown", [0.20, 0.30, 0.06])
    wood = scene.material("wood", [0.20, 0.13, 0.08])
    white = scene.material("cloud", [0.90, 0.90, 0.92])
    water = scene.material("water", [0.16, 0.24, 0.26], metal=1.0, rough=0.0)
    temple(scene, stone, marble, roof, gold)
    garden(scene, stone, grass, gravel, [dark, hedge, crown], wood, water)
    clouds(scene, white)
    scene.sun([0.72, -0.52, -0.60], [1.0, 0.86, 0.66], 5.6)
    scene.camera([0.0, 2.1, 16.6], [0.0, 2.45, 0.0], 41.0, aspect=1.5)
    return scene.document()
