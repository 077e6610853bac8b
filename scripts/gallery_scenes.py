# SPDX-License-Identifier: Apache-2.0
"""The scenes of the gallery, each with the effects that it is there for, in metres."""

import math
from typing import Any

import numpy as np
from gltf import Gltf, material, turned
from shapes import ball, box, curve, lathe, moved, prism, quad, ring, together, turned_about_y

# A scene is a glTF object and what stands beside it.
Made = tuple[dict[str, Any], dict[str, Any]]


def cornell_glass(room: list, light: list) -> Made:
    """The Cornell box (quads in millimetres) with a ball that mirrors and one of glass."""
    scene = Gltf(
        "cornell_glass",
        [
            material("white", [0.73, 0.71, 0.68]),
            material("red", [0.57, 0.043, 0.044]),
            material("green", [0.105, 0.378, 0.076]),
            material("light", [0.78, 0.78, 0.78], emissive=[1.0, 0.86, 0.66], strength=18.0),
            material("mirror", [0.95, 0.93, 0.88], metallic=1.0, roughness=0.0),
            material("glass", [1.0, 1.0, 1.0], roughness=0.0, transmission=1.0),
        ],
    )
    for name, number, quads in [*room, ("light", 3, [light])]:
        shapes = [quad(*(np.array(corner) / 1000 for corner in corners)) for corners in quads]
        scene.mesh(name, together(*shapes), number)
    scene.mesh("mirror ball", moved(ball(0.1), [0.385, 0.1, 0.36]), 4)
    scene.mesh("glass ball", moved(ball(0.09), [0.17, 0.09, 0.17]), 5)
    scene.camera(0.686686, translation=[0.278, 0.273, -0.8], rotation=[0, 1, 0, 0])
    return scene.json(), {}


def tree(height: float, radius: float) -> tuple:
    """Trunk and crown of a cypress that stands at the origin."""
    trunk = lathe([(0.0, 0.2 * height), (0.05 * height, 0.2 * height), (0.06 * height, 0.0)], 12)
    crown = curve([(0, 1), (0.45, 0.72), (1, 0.35), (0.8, 0.16), (0, 0.12)], 8)
    return trunk, lathe(crown * [radius, height], 24)


def pavilion() -> Made:
    """A round temple on steps under the sun, a pool before it, and trees behind."""
    scene = Gltf(
        "pavilion",
        [
            material("marble", [0.78, 0.74, 0.66]),
            material("lawn", [0.16, 0.26, 0.07]),
            material("leaves", [0.06, 0.15, 0.05]),
            material("bark", [0.16, 0.10, 0.06]),
            material("copper", [0.25, 0.46, 0.38]),
            material("water", [0.60, 0.70, 0.75], metallic=1.0, roughness=0.0),
            material("gravel", [0.55, 0.48, 0.38]),
        ],
    )
    far = 60.0
    scene.mesh("lawn", quad((-far, 0, far), (far, 0, far), (far, 0, -far), (-far, 0, -far)), 1)
    scene.mesh("path", lathe([(0, 0.02), (5.6, 0.02), (5.6, 0)], 96), 6)
    for k in range(3):
        r, top = 4.2 - 0.4 * k, 0.25 * (k + 1)
        scene.mesh(f"step {k}", lathe([(0, top), (r, top), (r, top - 0.25)], 96), 0)
    shaft = curve([(0.21, 3.6), (0.235, 2.4), (0.25, 1.2), (0.25, 0)], 8)
    column = together(
        moved(box((-0.34, 0, -0.34), (0.34, 0.14, 0.34)), [0, 3.86, 0]),
        lathe([(0.0, 3.86), (0.34, 3.86), (0.30, 3.74), (0.21, 3.6)], 40),
        lathe(shaft, 40),
        lathe([(0.26, 0.16), (0.34, 0.12), (0.36, 0.0)], 40),
    )
    columns = 10
    for k in range(columns):
        angle = 360 * (k + 0.5) / columns
        at = [2.8 * math.cos(math.radians(angle)), 0.75, 2.8 * math.sin(math.radians(angle))]
        scene.mesh(f"column {k}", moved(turned_about_y(column, -angle), at), 0)
    beam = [(2.4, 4.75), (3.2, 4.75), (3.2, 5.05), (3.35, 5.15), (3.35, 5.3), (2.4, 5.3)]
    scene.mesh("beam", lathe([*reversed(beam), beam[-1]], 96), 0)
    dome = [(3.1 * math.sin(a), 5.3 + 2.1 * math.cos(a)) for a in np.linspace(0, math.pi / 2, 33)]
    dome[0] = (0.0, dome[0][1])
    scene.mesh("dome", lathe(dome, 96), 4)
    scene.mesh("finial", moved(ball(0.22, 24, 48), [0, 7.6, 0]), 4)
    scene.mesh(
        "pool", moved(quad((-2.2, 0, 4), (2.2, 0, 4), (2.2, 0, 0), (-2.2, 0, 0)), [0, 0.06, 6.2]), 5
    )
    rim = together(
        box((-2.5, 0, 5.9), (2.5, 0.14, 6.2)),
        box((-2.5, 0, 10.2), (2.5, 0.14, 10.5)),
        box((-2.5, 0, 6.2), (-2.2, 0.14, 10.2)),
        box((2.2, 0, 6.2), (2.5, 0.14, 10.2)),
    )
    scene.mesh("rim", rim, 0)
    places = [(-6.5, -4.5, 6.2), (-8.4, -1.5, 5.2), (6.8, -4.0, 6.6), (8.8, -0.8, 5.0)]
    places += [(-4.2, -8.5, 7.4), (4.6, -8.8, 7.0), (-11.5, -7.0, 6.4), (11.8, -6.5, 6.8)]
    for k, (x, z, height) in enumerate(places):
        trunk, crown = tree(height, 0.16 * height)
        scene.mesh(f"trunk {k}", moved(trunk, [x, 0, z]), 3)
        scene.mesh(f"crown {k}", moved(crown, [x, 0, z]), 2)
    scene.light(
        {"name": "sun", "type": "directional", "color": [1.0, 0.92, 0.78], "intensity": 7.0},
        rotation=turned([0.8, 0.6, 0.0], -52.0),
    )
    camera = {"eye": [3.6, 2.0, 14.5], "target": [-0.2, 3.1, 0], "fov_y_deg": 40}
    return scene.json(), {"camera": camera, "background": [0.50, 0.80, 1.45]}


def still_life() -> Made:
    """Metals, glaze and glass on a table between two soft boxes, seen through a lens."""
    scene = Gltf(
        "still_life",
        [
            material("table", [0.46, 0.33, 0.23]),
            material("backdrop", [0.30, 0.33, 0.38]),
            material("softbox", [0, 0, 0], emissive=[1.0, 0.95, 0.88], strength=9.0),
            material("rim light", [0, 0, 0], emissive=[0.75, 0.85, 1.0], strength=6.0),
            material("gold", [1.0, 0.77, 0.34], metallic=1.0, roughness=0.25),
            material("copper", [0.95, 0.64, 0.54], metallic=1.0, roughness=0.45),
            material("steel", [0.62, 0.61, 0.60], metallic=1.0, roughness=0.12),
            material("blue glaze", [0.03, 0.09, 0.30], roughness=0.2),
            material("red glaze", [0.45, 0.04, 0.03], roughness=0.35),
            material("glass", [1.0, 1.0, 1.0], roughness=0.0, transmission=1.0),
            material("top light", [0, 0, 0], emissive=[1.0, 1.0, 1.0], strength=1.6),
        ],
    )
    scene.mesh("table", box((-3, -0.2, -1.6), (3, 0, 2.2)), 0)
    bend = [(-2.2, 5.0)] + [
        (-2.2 + 1.0 * (1 - math.cos(a)), 0.8 - 1.0 * math.sin(a)) for a in np.linspace(0, 1.57, 25)
    ]
    rows = np.array([[(x, y, z) for x in (-6, 6)] for z, y in bend]).reshape(-1, 3)
    k = np.arange(len(bend) - 1)
    strip = np.stack([2 * k, 2 * k + 2, 2 * k + 3, 2 * k, 2 * k + 3, 2 * k + 1], axis=1)
    scene.mesh("backdrop", moved((rows, strip.reshape(-1, 3)), [0, 0, 0]), 1)
    vase = curve(
        [
            (0.17, 1.5),
            (0.13, 1.36),
            (0.12, 1.2),
            (0.24, 1.0),
            (0.42, 0.7),
            (0.40, 0.4),
            (0.22, 0.08),
            (0.2, 0),
        ],
        10,
    )
    inner = np.array([(0.15, 1.5), (0.11, 1.3), (0.0, 1.25)])
    scene.mesh("vase", moved(lathe([*inner[::-1], *vase], 96), [-0.72, 0, -0.25]), 7)
    bowl = curve([(0.5, 0.34), (0.46, 0.2), (0.3, 0.07), (0.14, 0.03), (0.13, 0.0)], 10)
    hollow = curve([(0.0, 0.06), (0.2, 0.09), (0.42, 0.22), (0.48, 0.34)], 10)
    scene.mesh("bowl", moved(lathe([*hollow, *bowl], 96), [0.85, 0, -0.45]), 8)
    scene.mesh("gold ball", moved(ball(0.16), [0.78, 0.27, -0.5]), 4)
    scene.mesh("steel ball", moved(ball(0.14), [1.02, 0.3, -0.38]), 6)
    scene.mesh("great ball", moved(ball(0.34), [0.12, 0.34, 0.25]), 6)
    scene.mesh("ring", moved(ring(0.3, 0.09), [-0.55, 0.09, 0.78]), 5)
    scene.mesh("marble", moved(ball(0.15), [0.72, 0.15, 0.72]), 9)
    scene.mesh("bead", moved(ball(0.09, 32, 64), [-0.98, 0.09, 0.42]), 4)
    scene.mesh(
        "key light", quad((-3.4, 1.6, 1.2), (-2.6, 1.6, 2.6), (-2.2, 3.6, 2.2), (-3.0, 3.6, 0.8)), 2
    )
    scene.mesh(
        "top light",
        quad((-1.4, 3.6, -1.0), (1.6, 3.6, -1.0), (1.6, 3.6, 1.2), (-1.4, 3.6, 1.2)),
        10,
    )
    scene.mesh(
        "fill light", quad((2.9, 1.0, -0.2), (2.9, 1.0, 1.0), (2.9, 3.0, 1.0), (2.9, 3.0, -0.2)), 3
    )
    camera = {
        "eye": [0.35, 1.25, 4.2],
        "target": [0.05, 0.52, 0.1],
        "fov_y_deg": 32,
        "aperture": 0.11,
        "focus_distance": 3.95,
    }
    return scene.json(), {"camera": camera, "background": [0.05, 0.06, 0.08]}


def windmill() -> Made:
    """A mill whose sails turn by a quarter in two seconds, houses and trees around it."""
    scene = Gltf(
        "windmill",
        [
            material("meadow", [0.20, 0.30, 0.08]),
            material("brick", [0.42, 0.16, 0.10]),
            material("plaster", [0.72, 0.68, 0.60]),
            material("roof", [0.20, 0.11, 0.08]),
            material("sail", [0.80, 0.76, 0.66]),
            material("wood", [0.30, 0.19, 0.11]),
            material("leaves", [0.08, 0.19, 0.05]),
            material("road", [0.48, 0.42, 0.33]),
        ],
    )
    far = 80.0
    scene.mesh("meadow", quad((-far, 0, far), (far, 0, far), (far, 0, -far), (-far, 0, -far)), 0)
    scene.mesh(
        "road", quad((2.2, 0.02, 20), (4.6, 0.02, 20), (1.2, 0.02, -30), (0.2, 0.02, -30)), 7
    )
    tower = curve([(1.15, 6.0), (1.35, 4.4), (1.6, 2.2), (1.95, 0.0)], 8)
    scene.mesh("tower", moved(lathe([(0, 6.0), *tower], 64), [-2.2, 0, 0]), 1)
    cap = [(1.3 * math.sin(a), 6.0 + 1.1 * math.cos(a)) for a in np.linspace(0, math.pi / 2, 17)]
    cap[0] = (0.0, cap[0][1])
    scene.mesh("cap", moved(lathe([*cap, (0.0, 6.0)], 64), [-2.2, 0, 0]), 3)
    balcony = [(1.62, 2.3), (2.35, 2.3), (2.35, 2.15), (1.6, 2.15)]
    scene.mesh("balcony", moved(lathe(balcony, 64), [-2.2, 0, 0]), 5)

    hub = scene.node("sails", translation=[-2.2, 6.3, 1.9])
    scene.mesh("axle", moved(box((-0.16, -0.16, -1.2), (0.16, 0.16, 0.2)), [0, 0, 0]), 5, hub)
    for k in range(4):
        arm = together(
            box((-0.06, 0.1, -0.05), (0.06, 4.0, 0.05)),
            *(box((0.06, 0.9 + 0.5 * b, -0.02), (0.85, 0.95 + 0.5 * b, 0.02)) for b in range(7)),
        )
        canvas = prism([(0.1, 0.95), (0.8, 0.95), (0.72, 3.9), (0.1, 3.9)], 0.03)
        turn = {"rotation": turned([0.0, 0.0, 1.0], 90.0 * k + 20.0)}
        arms = scene.node(f"arm {k}", hub, **turn)
        scene.mesh(f"spar {k}", arm, 5, arms)
        scene.mesh(f"canvas {k}", moved(canvas, [0, 0, -0.06]), 4, arms)

    gable = [(-1.3, 0), (1.3, 0), (1.3, 1.5), (0, 2.7), (-1.3, 1.5)]
    roof = [(-1.55, 1.35), (0, 2.78), (1.55, 1.35), (1.55, 1.5), (0, 2.95), (-1.55, 1.5)]
    for k, (x, z, angle) in enumerate([(5.4, -3.2, 25), (8.2, 0.2, -60), (3.4, -9.0, 10)]):
        scene.mesh(f"house {k}", moved(turned_about_y(prism(gable, 3.4), angle), [x, 0, z]), 2)
        left = prism([roof[0], roof[1], roof[4], roof[5]][::-1], 3.8)
        right = prism([roof[1], roof[2], roof[3], roof[4]][::-1], 3.8)
        both = together(left, right)
        flipped = both[1][:, [0, 2, 1]]
        scene.mesh(f"roof {k}", moved(turned_about_y((both[0], flipped), angle), [x, 0, z]), 3)
    places = [(-8.5, -4, 3.6), (-7, -9, 4.4), (-11, 1, 3.2), (9.5, -7, 4.2), (0.8, -12, 4.8)]
    places += [(12.5, -2, 3.8), (-4.5, -14, 5.0), (6.5, -14, 4.6)]
    for k, (x, z, height) in enumerate(places):
        trunk, _ = tree(height, 0.0)
        scene.mesh(f"trunk {k}", moved(trunk, [x, 0, z]), 5)
        crown = ball(0.32 * height, 24, 48)
        scene.mesh(f"crown {k}", moved(crown, [x, 0.48 * height, z]), 6)
    scene.light(
        {"name": "sun", "type": "directional", "color": [1.0, 0.88, 0.70], "intensity": 7.0},
        rotation=turned([0.78, 0.62, 0.0], -48.0),
    )
    seconds, quarter = 2.0, 90.0
    keys = [turned([0.0, 0.0, 1.0], -angle) for angle in (0.0, quarter)]
    scene.turn(hub, [0.0, seconds], keys)
    camera = {"eye": [3.0, 2.4, 17.0], "target": [0.7, 4.5, 0], "fov_y_deg": 44}
    return scene.json(), {"camera": camera, "background": [0.50, 0.80, 1.45]}
