# SPDX-License-Identifier: Apache-2.0
"""A memory image as the model's builder makes it, with what the units must make of its parts."""

import struct
from dataclasses import dataclass

import ti_model
from models.numbers import numbers

BASE = 0x100000  # address of the image in memory


@dataclass(frozen=True)
class Outcome:
    """What becomes of one ray against one triangle."""

    passes: int  # 1: done after pass (a), 2: after (b), 3: inside, (c) is taken
    after_b: tuple | None = None  # det, dett, detu, detv
    hit: tuple | None = None  # t, u, v when t is finite


class Scene:
    """The image of `triangles` in the simulation's format."""

    def __init__(self, triangles):
        self.triangles = triangles
        self.image = ti_model.Image.build(numbers().format, triangles)
        self.bytes = self.image.bytes
        self.root = self.image.root
        self.node_base = BASE + self.image.node_offset
        self.list_base = BASE + self.image.list_offset
        self.plane_base = BASE + self.image.plane_offset
        self.bary_base = BASE + self.image.bary_offset
        self.box = tuple(self.image.box_lo), tuple(self.image.box_hi)
        count = self.image.triangle_count
        self.nodes = self._records(self.image.node_offset, self.image.node_count, 2)
        self.ids = [r[0] for r in self._records(self.image.list_offset, self.image.list_count, 1)]
        self.planes = self._records(self.image.plane_offset, count, 8)
        self.barys = self._records(self.image.bary_offset, count, 4)

    def _records(self, offset, count, words):
        end = offset + 4 * words * count
        return list(struct.iter_unpack(f"<{words}I", self.bytes[offset:end]))

    def prim(self, record):
        return self.planes[record][6]

    def test(self, record, o, d, tnear, tfar):
        """The three passes of the model on bits."""
        n = numbers()
        plane, bary = self.planes[record], self.barys[record]
        after_a = n.model("pass_a", plane, o, d, tnear, tfar)
        if after_a is None:
            return Outcome(1)
        after_b = n.model("pass_b", plane, bary, d, after_a)
        if after_b is None:
            return Outcome(2)
        return Outcome(3, after_b, n.model("pass_c", after_b))

    def aimed(self, rng, record):
        """(o, d) of a ray that meets the triangle near its middle."""
        n = numbers()
        corners = self.triangles[self.prim(record)]
        target = [sum(axis) / 3 for axis in zip(*corners, strict=True)]
        o = n.vec(rng.uniform(-2, 2) for _ in range(3))
        return o, n.vec(to - n.float(start) for to, start in zip(target, o, strict=True))


def soup(rng, count, size=0.3, reach=1.0):
    """Random triangles of about `size` with their first corners within `reach` of the origin."""

    def near(corner):
        return tuple(c + rng.uniform(-size, size) for c in corner)

    corners = [tuple(rng.uniform(-reach, reach) for _ in range(3)) for _ in range(count)]
    return [(corner, near(corner), near(corner)) for corner in corners]


def rays_through(rng, count, reach=1.0):
    """(o, d) as bits: from around a scene of that reach, through it; some along an axis."""
    n = numbers()
    for _ in range(count):
        o = n.vec(rng.uniform(-2, 2) * reach for _ in range(3))
        target = [rng.uniform(-reach, reach) for _ in range(3)]
        d = [to - n.float(start) for to, start in zip(target, o, strict=True)]
        if rng.random() < 0.2:
            d[rng.randrange(3)] = rng.choice((0.0, -0.0))
        yield o, n.vec(d)
