# SPDX-License-Identifier: Apache-2.0
"""A memory image as the model's builder makes it, with what the units must make of its parts."""

import struct
from dataclasses import dataclass

import ti_model
from models.numbers import numbers
from models.payload import configuration, payloads
from models.rays import shear_of

BASE = 0x100000  # address of the image in memory


@dataclass(frozen=True)
class Outcome:
    """What becomes of one ray against one triangle."""

    passes: str  # those that it takes: a, ab or abc; of Woop's test a or ac
    after_b: tuple | None = None  # det, dett, detu, detv; of Woop's test weights, ways along z, sz
    hit: tuple | None = None  # t, u, v when t is finite


class Scene:
    """The image of `triangles` in the simulation's format."""

    def __init__(self, triangles):
        self.triangles = triangles
        self.test_kind = configuration()["triangle_test"]
        self.image = ti_model.Image.build(numbers().format, triangles, self.test_kind)
        self.bytes = self.image.bytes
        self.root = self.image.root
        self.node_base = BASE + self.image.node_offset
        self.list_base = BASE + self.image.list_offset
        self.plane_base = BASE + self.image.record_offset
        self.bary_base = BASE + self.image.bary_offset
        self.box = tuple(self.image.box_lo), tuple(self.image.box_hi)
        count = self.image.triangle_count
        self.nodes = self._records(self.image.node_offset, self.image.node_count, 2)
        self.ids = [r[0] for r in self._records(self.image.list_offset, self.image.list_count, 1)]
        self.count = count
        if self.test_kind == "woop":
            size = ti_model.corner_bytes(numbers().format)
            self.parts = [(self.plane_base, size, count)]
            self.corners = [self._corners(i, size) for i in range(count)]
        else:
            self.planes = self._records(self.image.record_offset, count, 8)
            self.barys = self._records(self.image.bary_offset, count, 4)
            self.parts = [(self.plane_base, 32, count), (self.bary_base, 16, count)]

    def _records(self, offset, count, words):
        end = offset + 4 * words * count
        return list(struct.iter_unpack(f"<{words}I", self.bytes[offset:end]))

    def _corners(self, record, size):
        """(prim, corners) of a record of Woop's test, packed into `size` bytes."""
        width = payloads().width("fp_t")
        start = self.image.record_offset + size * record
        bits = int.from_bytes(self.bytes[start : start + size], "little")
        words = [bits >> i * width & ((1 << width) - 1) for i in range(9)]
        return bits >> 9 * width & 0xFFFFFFFF, [tuple(words[i : i + 3]) for i in (0, 3, 6)]

    def prim(self, record):
        return self.corners[record][0] if self.test_kind == "woop" else self.planes[record][6]

    def test(self, record, operands, tnear, tfar):
        """The passes of the model on bits; Woop's test has no (b)."""
        n = numbers()
        o, d = operands["o"], operands["d"]
        if self.test_kind == "woop":
            z, d = shear_of(d)
            edges = n.model("edge_functions", self.corners[record][1], o, z, d)
            if edges is None:
                return Outcome("a")
            after = *(tuple(part) for part in edges), d[2]
            return Outcome("ac", after, n.model("woop_pass_c", *after))
        plane, bary = self.planes[record], self.barys[record]
        after_a = n.model("pass_a", plane, o, d, tnear, tfar, self.test_kind == "np")
        if after_a is None:
            return Outcome("a")
        after_b = n.model("pass_b", plane, bary, d, after_a)
        if after_b is None:
            return Outcome("ab")
        return Outcome("abc", after_b, n.model("pass_c", after_b))

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
