# SPDX-License-Identifier: Apache-2.0
"""A windmill behind rows of flowers, and a balloon: 16 frames at 8 a second, then again.

The sails make a quarter of a turn, after which they look as before, and the balloon floats up and
down once. Nothing else moves.
"""

import numpy as np

from scenes.gltf import Gltf, about
from scenes.shapes import box, cloud, drum, ground, joined, lathe, lump, placed

BESIDE = {"background": [0.34, 0.58, 1.0]}  # the sky, which glTF has no words for

SECONDS = 2.0
KEYS = np.linspace(0, SECONDS, 9)
MILL = np.array([4.2, 0.0, -6.0])
BALLOON = np.array([-6.4, 7.6, -12.0])
TREES = [(8.6, -9, 1.2), (10.6, -7.5, 0.95), (12.5, -12, 1.4), (-15, -22, 1.6)]  # x, z, size
TREES += [(-11.5, -24, 1.3), (-19, -19, 1.5), (0.5, -27, 1.3), (17, -18, 1.6), (-5.5, -26, 1.1)]
FACES = -24.0  # degrees that the mill is turned from the eye's side


def plain(x, z):
    """Fields that are flat, with low dunes at the end."""
    far = np.clip((-z - 40) / 50, 0, 1)
    return far * (2.0 + 1.5 * np.sin(0.09 * x + 1.0) + 0.9 * np.sin(0.21 * x)) - 0.02


def row(x, seed, near=9.0, far=-15.0, parts=120):
    """A row of flowers: a ridge that is uneven as flowers are."""
    z = np.linspace(near, far, parts)[:, None]
    s = np.array([-0.36, -0.24, 0.0, 0.24, 0.36])[None, :]
    high = np.array([0.0, 0.30, 0.42, 0.30, 0.0])[None, :]
    wave = 1 + 0.16 * np.sin(11.3 * z + 3 * seed + 5 * s) * np.sin(2.3 * z + 9 * s + seed)
    vertices = np.stack([x + s * wave, high * wave, z + 0 * s], axis=-1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(parts - 1), np.arange(4), indexing="ij")
    v = i * 5 + j
    quads = np.stack([v, v + 1, v + 6, v, v + 6, v + 5], axis=-1)
    return vertices, quads.reshape(-1, 3)


def sail():
    """One sail along +y from the axle: a spar with its lattice, and the cloth on it."""
    spar = box((-0.06, 0.0, -0.05), (0.06, 4.1, 0.05))
    rails = [box((x - 0.02, 0.8, -0.02), (x + 0.02, 4.0, 0.02)) for x in (0.42, 0.8)]
    slats = [
        box((0.0, y - 0.02, -0.025), (0.84, y + 0.02, 0.025)) for y in np.arange(0.8, 4.1, 0.4)
    ]
    cloth = box((0.08, 0.84, 0.03), (0.78, 3.96, 0.045))
    return joined(spar, *rails, *slats), cloth


def mill(scene, plaster, brick, thatch, wood, cloth, glass):
    """The mill, facing +z before it is turned; the node of its sails."""
    tower = [(0, 0), (1.75, 0), (1.62, 1.0), (1.5, 2.0), (1.30, 3.6), (1.14, 5.2), (0, 5.2)]
    foot = [(0, 0), (1.95, 0), (1.95, 0.7), (1.76, 0.8), (0, 0.8)]
    deck = joined(
        drum(2.5, 1.95, 2.05, 24),
        *(placed(box((-0.04, 2.05, 2.36), (0.04, 2.6, 2.44)), turn=15 * k) for k in range(24)),
        lathe([(2.36, 2.56), (2.44, 2.56), (2.44, 2.64), (2.36, 2.64), (2.36, 2.56)], 24),
    )
    cap = [(0, 5.2), (1.34, 5.2), (1.36, 5.35), (1.22, 5.8), (0.9, 6.25), (0.45, 6.52), (0, 6.6)]
    openings = joined(
        box((-0.38, 0, 1.6), (0.38, 1.45, 1.98)),
        *(box((-0.2, y, 1.0), (0.2, y + 0.5, z)) for y, z in ((2.75, 1.46), (4.0, 1.31))),
        *(placed(box((-0.2, 3.4, 1.0), (0.2, 3.9, 1.38)), turn=90 * s) for s in (-1, 1)),
    )
    parts = [(lathe(tower, 8), plaster), (lathe(foot, 8), brick), (deck, wood)]
    parts += [(lathe(cap, 8), thatch), (openings, glass)]
    body = scene.put("body", *parts)
    upright, sides = drum(0.16, -0.9, 0.3, 16)
    hub = (upright[:, [0, 2, 1]], sides[:, ::-1])  # along z
    lattice, canvas = sail()
    mesh = scene.mesh("sail", (lattice, wood), (canvas, cloth))
    one = [scene.node(f"sail {k}", mesh=mesh, rotation=about((0, 0, 1), 90 * k)) for k in range(4)]
    axis = scene.put("hub", (hub, wood))
    sails = scene.node("sails", at=[0, 5.65, 1.85], children=[*one, axis],
                       rotation=about((0, 0, 1), 20))  # fmt: skip
    scene.node("mill", at=MILL, children=[body, sails], rotation=about((0, 1, 0), FACES))
    return sails


def balloon(scene, red, cream, wicker):
    """A balloon of gores in two colours; its node."""
    a = np.radians(np.arange(0, 181, 10))
    profile = [(np.sin(t) * (1.0 if t > 1.5 else 0.92 + 0.08 * np.sin(t)), -np.cos(t)) for t in a]
    profile = [(r if r > 0.05 else 0.0, y * (1.25 if y < 0 else 1.0)) for r, y in profile]
    vertices, triangles = lathe(profile, 48)
    corner = vertices[triangles].mean(axis=1)
    gore = np.floor((np.arctan2(corner[:, 2], corner[:, 0]) / (2 * np.pi) + 1) * 12).astype(int) % 2
    ropes = [
        box((x, -1.75, z), (x + 0.02, -1.0, z + 0.02)) for x in (-0.2, 0.18) for z in (-0.2, 0.18)
    ]
    basket = joined(box((-0.22, -2.1, -0.22), (0.22, -1.75, 0.22)), *ropes)
    parts = [((vertices, triangles[gore == k]), colour) for k, colour in ((0, red), (1, cream))]
    return scene.put("balloon", *parts, (basket, wicker), at=BALLOON, size=1.7)


def windmill():
    scene = Gltf("windmill")
    plaster = scene.material("plaster", [0.82, 0.79, 0.72])
    brick = scene.material("brick", [0.42, 0.17, 0.10])
    thatch = scene.material("thatch", [0.30, 0.14, 0.09])
    wood = scene.material("wood", [0.24, 0.15, 0.09])
    cloth = scene.material("cloth", [0.86, 0.80, 0.66])
    shade = scene.material("window", [0.05, 0.10, 0.12])
    grass = scene.material("grass", [0.20, 0.32, 0.09])
    white = scene.material("cloud", [0.90, 0.90, 0.92])
    sand = scene.material("sand", [0.62, 0.52, 0.38])
    leaf = scene.material("leaf", [0.10, 0.21, 0.06])
    red = scene.material("red", [0.72, 0.06, 0.05])
    cream = scene.material("cream", [0.88, 0.80, 0.60])
    flowers = [
        scene.material("tulip red", [0.74, 0.05, 0.06]),
        scene.material("tulip yellow", [0.90, 0.62, 0.05]),
        scene.material("tulip pink", [0.82, 0.28, 0.42]),
        scene.material("tulip violet", [0.30, 0.10, 0.42]),
        scene.material("tulip white", [0.85, 0.82, 0.76]),
        scene.material("tulip orange", [0.85, 0.28, 0.04]),
    ]
    scene.put("fields", (ground(100, 60, plain), grass))
    for k, x in enumerate(np.arange(-13.5, 1.6, 1.0)):
        scene.put(f"row {k}", (row(x, k), flowers[k // 2 % len(flowers)]))
    for k, x in enumerate(np.arange(5.0, 14.1, 1.0)):
        scene.put(f"near row {k}", (row(x, k + 40, far=-2.0, parts=56), flowers[(k // 2 + 2) % 6]))
    scene.put("path", (box((2.35, -0.1, -14), (3.95, 0.01, 14)), sand))
    for k, (x, z, size) in enumerate(TREES):
        crown = joined(
            placed(lump(6, k), at=(0, 2.3, 0), size=(1.2, 1.5, 1.2)),
            placed(lump(5, k + 4), at=(0.6, 1.7, 0.3), size=0.85),
        )
        trunk = (drum(0.14, 0, 1.3, 10), wood)
        scene.put(f"tree {k}", (crown, leaf), trunk, at=[x, 0, z], size=size)
    for k, (x, y, z, size) in enumerate(
        [(-15, 14.5, -42, 2.6), (2.5, 18.5, -50, 2.2), (20, 13.0, -45, 2.9)]
    ):
        scene.put(f"cloud {k}", (cloud(k), white), at=[x, y, z], size=size)
    sails = mill(scene, plaster, brick, thatch, wood, cloth, shade)
    floats = balloon(scene, red, cream, wood)
    scene.sun([0.55, -0.62, -0.56], [1.0, 0.90, 0.74], 5.0)
    scene.camera([0.6, 2.3, 13.0], [0.2, 3.7, -4.0], 42.0, aspect=1.5)

    turns = [about((0, 0, 1), 20 - 90 * t / SECONDS) for t in KEYS]
    rise = 0.5 * np.sin(2 * np.pi * KEYS / SECONDS)
    lift = BALLOON + rise[:, None] * (0, 1, 0)
    scene.animation("wind", (sails, "rotation", KEYS, turns), (floats, "translation", KEYS, lift))
    return scene.document()
