# SPDX-License-Identifier: Apache-2.0
"""The Cornell box, and the same with a mirror and a glass sphere in place of its blocks.

Quads in millimetres as published by the Cornell University Program of Computer Graphics, "Cornell
Box Data"; in the files metres. The ceiling is cut around the light into four quads, so that no two
surfaces coincide.
"""

import numpy as np

from scenes.gltf import Gltf
from scenes.shapes import ball

CEILING = 548.8
LIGHT = [(343, CEILING, 227), (343, CEILING, 332), (213, CEILING, 332), (213, CEILING, 227)]
# A larger one for the box with glass, as light that glass has bent is found by chance only.
PANEL = [(418, CEILING, 160), (418, CEILING, 400), (138, CEILING, 400), (138, CEILING, 160)]
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


def ceiling(light):
    """Four quads around a light."""
    return [[OUTER[i], OUTER[(i + 1) % 4], light[(i + 1) % 4], light[i]] for i in range(4)]


FLOOR = [("floor", 0, [[(552.8, 0, 0), (0, 0, 0), (0, 0, 559.2), (549.6, 0, 559.2)]])]
WALLS = [  # name, material, quads
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
]
BLOCKS = [("short block", 0, block(SHORT_TOP)), ("tall block", 0, block(TALL_TOP))]


def room(name, light, strength, *more):
    """The box with a light in its ceiling, and more quads in it."""
    scene = Gltf(name)
    scene.material("white", [0.73, 0.71, 0.68])
    scene.material("red", [0.57, 0.043, 0.044])
    scene.material("green", [0.105, 0.378, 0.076])
    scene.material("light", [0.78, 0.78, 0.78], emissive=[1.0, 0.86, 0.66], strength=strength)
    top, lamp = ("ceiling", 0, ceiling(light)), ("light", 3, [light])
    for part, material, quads in [*FLOOR, top, *WALLS, lamp, *more]:
        scene.quads(part, np.array(quads, dtype=np.float64) / 1000, material)
    return scene


def camera(scene):
    """Position (278, 273, -800), looking along +z; focal length 0.035, film 0.025."""
    view = {"yfov": 0.686686, "aspectRatio": 1.0, "znear": 0.01}
    scene.cameras.append({"type": "perspective", "perspective": view})
    place = {"translation": [0.278, 0.273, -0.8], "rotation": [0, 1, 0, 0]}
    scene.node("camera", camera=0, **place)
    return scene


def cornell():
    """The box with its two blocks."""
    return camera(room("cornell", LIGHT, 18.0, *BLOCKS)).document()


def cornell_glass():
    """The box with a mirror and a glass sphere, round to a degree."""
    scene = room("cornell_glass", PANEL, 4.0)
    mirror = scene.material("mirror", [0.95, 0.95, 0.95], metal=1.0, rough=0.0)
    glass = scene.material("glass", [1.0, 1.0, 1.0], rough=0.0, glass=1.5)
    shape = ball(32)
    scene.put("mirror sphere", (shape, mirror), at=[0.386, 0.1206, 0.36], size=0.12)
    scene.put("glass sphere", (shape, glass), at=[0.17, 0.1006, 0.19], size=0.1)
    return camera(scene).document()
