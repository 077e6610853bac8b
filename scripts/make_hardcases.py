#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the hard cases of the triangle test, `scenes/hardcases.jsonl`, with exact results.

One JSON object a line: binary32 words in hex for origin, direction, tmin, tmax and corners; the
rule; and what rational arithmetic says (closed triangle, both sides, closed interval, triangles
with a NaN or an infinity left out).
`--check FILE` compares the cases with those of the same number in another file instead of writing.
"""

import argparse
import json
import math
import struct
import sys
from fractions import Fraction
from pathlib import Path

NAN = math.nan
INF = math.inf
FLT_MAX = (2 - 2.0**-23) * 2.0**127


def word(x):
    """binary32 word of `x`, rounded to nearest even."""
    if math.isnan(x):
        return "7FC00000"
    try:
        return struct.pack(">f", x).hex().upper()
    except OverflowError:
        return "7F800000" if x > 0 else "FF800000"


def number(text):
    """Value of a binary32 word."""
    return struct.unpack(">f", bytes.fromhex(text))[0]


def ulps(x, count):
    """The binary32 value `count` places above `x` > 0."""
    return number(f"{int(word(x), 16) + count:08X}")


def sub(a, b):
    return [x - y for x, y in zip(a, b, strict=True)]


def cross(a, b):
    return [a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


def meet(o, d, tri):
    """(t, on the boundary) of the line with the closed triangle, or None (Moeller, Trumbore)."""
    e1, e2, s = sub(tri[1], tri[0]), sub(tri[2], tri[0]), sub(o, tri[0])
    p, q = cross(d, e2), cross(s, e1)
    det = dot(e1, p)
    if det == 0:
        return None
    weights = [Fraction(dot(s, p), 1) / det, Fraction(dot(d, q), 1) / det]
    weights.append(1 - weights[0] - weights[1])
    if min(weights) < 0:
        return None
    return dot(e2, q) / det, 0 in weights


def exact(case):
    """Adds the exact result to `case`."""
    values = {key: [number(x) for x in case[key]] for key in ("o", "d")}
    tmin, tmax = number(case["tmin"]), number(case["tmax"])
    best, ids, boundary = None, [], False
    if all(map(math.isfinite, values["o"] + values["d"])):
        o, d = ([Fraction(x) for x in values[key]] for key in ("o", "d"))
        for i, words in enumerate(case["tris"]):
            corners = [[number(x) for x in p] for p in words]
            if not all(math.isfinite(x) for p in corners for x in p):
                continue
            met = meet(o, d, [[Fraction(x) for x in p] for p in corners])
            if met is None or not tmin <= met[0] <= tmax or (best is not None and met[0] > best):
                continue
            if best is None or met[0] < best:
                best, ids, boundary = met[0], [], False
            ids.append(i)
            boundary = boundary or met[1]
    case["exact_hit"] = best is not None
    case["exact_ids"] = ids
    case["exact_t"] = None if best is None else str(best)
    case["exact_t_f32"] = None if best is None else word(nearest(best))
    case["on_boundary"] = boundary
    return case


def nearest(q):
    """`q` as a double; word() rounds it again, which is right for the values used here."""
    try:
        return float(q)
    except OverflowError:
        return INF if q > 0 else -INF


def corner(n, name, rule, o, d, tris, why="", tmin=0.0, tmax=INF):
    return exact(
        {
            "n": n,
            "name": name,
            "rule": rule,
            "why": why,
            "o": [word(x) for x in o],
            "d": [word(x) for x in d],
            "tmin": word(tmin),
            "tmax": word(tmax),
            "tris": [[[word(x) for x in p] for p in tri] for tri in tris],
        }
    )


def wall(z, size=1.0):
    """The usual triangle: across the z axis at `z`."""
    return [(-size, -size, z), (size, -size, z), (0, size, z)]


def quad(lo, hi, z):
    """A square of two triangles that share the diagonal from (lo, lo) to (hi, hi)."""
    return [[(lo, lo, z), (hi, lo, z), (hi, hi, z)], [(lo, lo, z), (hi, hi, z), (lo, hi, z)]]


def fan():
    """Six triangles around (0, 0, 5)."""
    rim = [(math.cos(math.tau * k / 6), math.sin(math.tau * k / 6), 5.25) for k in range(7)]
    return [[(0, 0, 5), rim[k], rim[k + 1]] for k in range(6)]


ZERO = (0, 0, 0)
UP = (0, 0, 1)
TRI = [wall(5)]
QUAD = quad(0, 2, 5)
FLAT = [[(0, 0, 5), (2, 0, 5), (0, 2, 5)]]
GROUND = [[(0, 0, 0), (4, 0, 0), (0, 4, 0)]]
SLIVERS = [
    [(0, 0, 5), (1024, 0, 5), (512, 2**-10, 5)],
    [(0, 0, 5), (512, -(2**-10), 5), (1024, 0, 5)],
]
FAR = 1e6


def cases():
    """The catalogue in order of its numbers."""
    # fmt: off
    yield corner(1, "axis ray, dir zeros positive", "exact", ZERO, UP, TRI)
    yield corner(2, "axis ray, dir zeros negative", "exact", ZERO, (-0.0, -0.0, 1), TRI,
                 "inv = -inf: the near child flips, the result must not")
    yield corner(3, "axis ray backwards, negative zeros", "exact", (0, 0, 10), (-0.0, -0.0, -1),
                 TRI)
    yield corner(4, "axis ray in a scene-box face (o.x = box lo.x)", "watertight", (0, 1, 0), UP,
                 QUAD, "lo-o = 0, inv = inf: 0*inf = NaN in the clip; ray lies in the box face")
    yield corner(5, "origin on the split plane, dir away from it zero", "watertight", (1, 1, 0),
                 UP, QUAD, "split x=1: (1-1)*inf = NaN; also the diagonal, both triangles")
    yield corner(6, "inner point of a shared edge, exact", "watertight", (0.5, 0.5, 0), UP, QUAD,
                 "both signs are 0")
    yield corner(7, "shared vertex, exact", "watertight", ZERO, UP, QUAD)
    yield corner(8, "shared vertex of the quad, outer corner", "watertight", (2, 2, 0), UP, QUAD)
    yield corner(9, "edge 1 ulp outside the quad", "exact", (ulps(2, 1), 1, 0), UP, QUAD,
                 "must miss: no neighbour there")
    yield corner(10, "edge 1 ulp inside the quad", "exact", (ulps(2, -1), 1, 0), UP, QUAD,
                 "must hit: no neighbour there")
    yield corner(11, "ray in the triangle plane, through its inside", "nohit", (-1, 0.5, 5),
                 (1, 0, 0), FLAT, "det = 0 exactly")
    yield corner(12, "ray in plane, along an edge", "nohit", (-1, 0, 5), (1, 0, 0), FLAT)
    yield corner(13, "grazing, slope 2^-20", "exact", (-1, 1, 2**-19), (1, 0, -(2**-20)), GROUND)
    yield corner(14, "grazing, slope 2^-40", "exact", (-1, 1, 2**-39), (1, 0, -(2**-40)), GROUND)
    yield corner(15, "degenerate: three equal points", "nohit", (1, 1, 0), UP, [[(1, 1, 5)] * 3])
    yield corner(16, "degenerate: collinear", "nohit", (1, 1, 0), UP, [[(0, 0, 5), (1, 1, 5), (2,
                 2, 5)]])
    yield corner(17, "degenerate: two equal points", "nohit", (1, 1, 0), UP,
                 [[(0, 0, 5), (2, 2, 5), (2, 2, 5)]])
    yield corner(18, "sliver, height 2^-20 of its length", "exact", (512, 2**-11, 0), UP,
                 SLIVERS[:1], "1/n_w is large")
    yield corner(19, "sliver pair sharing the long edge", "watertight", (300, 0, 0), UP, SLIVERS)
    yield corner(20, "huge coordinates 1e20: products overflow", "exact", ZERO, UP, [wall(5e20,
                 1e20)], "normal 4e40 > FLT_MAX; prescale in the builder")
    yield corner(21, "tiny coordinates 1e-20: products underflow", "exact", ZERO, UP, [wall(5e-20,
                 1e-20)], "normal 4e-40 is subnormal, det flushes")
    yield corner(22, "tiny coordinates 1e-30: products vanish", "exact", ZERO, UP, [wall(5e-30,
                 1e-30)], "normal 4e-60 is 0")
    yield corner(23, "subnormal direction", "policy", ZERO, (0, 0, 2.0**-128), TRI,
                 "t = 5*2^128 > FLT_MAX; 1/d overflows to inf; FTZ makes it a zero direction")
    yield corner(24, "smallest subnormal direction component", "exact", ZERO, (2.0**-149, 0, 1),
                 TRI)
    yield corner(25, "subnormal vertex", "watertight", ZERO, UP, [[(-(2.0**-129), -1, 5),
                 *wall(5)[1:]]])
    yield corner(26, "direction FLT_MAX: inv is subnormal", "exact", ZERO, (0, 0, FLT_MAX), TRI,
                 "1/FLT_MAX is subnormal")
    yield corner(27, "direction 2^126..2^127: inv near the smallest normal", "exact", ZERO, (0, 0,
                 2.0**127), TRI, "1/2^127 is subnormal")
    yield corner(28, "NaN origin", "nohit", (NAN, 0, 0), UP, TRI)
    yield corner(29, "NaN direction", "nohit", ZERO, (0, NAN, 1), TRI)
    yield corner(30, "Inf origin", "nohit", (0, 0, -INF), UP, TRI)
    yield corner(31, "Inf direction", "nohit", ZERO, (0, 0, INF), TRI)
    yield corner(32, "zero direction", "nohit", (0, 0, 5), ZERO, TRI)
    yield corner(33, "NaN vertex beside a good triangle", "exact", ZERO, UP,
                 [[(NAN, 0, 1), (1, 0, 1), (0, 1, 1)], *TRI],
                 "the NaN triangle is inactive, the other must be hit")
    yield corner(34, "Inf vertex beside a good triangle", "exact", ZERO, UP,
                 [[(INF, 0, 1), (-1, 0, 1), (0, 1, 1)], *TRI],
                 "the infinite triangle is inactive, the other must be hit")
    yield corner(35, "tmin > tmax", "nohit", ZERO, UP, TRI, tmin=6, tmax=4)
    yield corner(36, "tmin = tmax = t", "exact", ZERO, UP, TRI, tmin=5, tmax=5)
    yield corner(37, "tmax 1 ulp below t", "exact", ZERO, UP, TRI, tmax=ulps(5, -1))
    yield corner(38, "tmin 1 ulp above t", "exact", ZERO, UP, TRI, tmin=ulps(5, 1))
    yield corner(39, "tmax NaN", "nohit", ZERO, UP, TRI, tmax=NAN)
    yield corner(40, "negative tmin, hit behind the origin", "policy", ZERO, UP, [wall(-5)],
                 "negative tmin allowed or not is a policy", tmin=-10, tmax=0)
    yield corner(41, "t tie: two equal coplanar triangles", "tie", ZERO, UP, TRI * 2,
                 "lowest id, whatever the order of the leaves")
    yield corner(42, "t tie: the same triangle wound both ways", "tie", ZERO, UP, [TRI[0],
                 TRI[0][::-1]], "lowest id")
    yield corner(43, "near tie: planes 1 ulp apart", "exact", ZERO, UP, [wall(ulps(5, 1)), wall(5)])
    yield corner(44, "origin on the triangle (t = 0), tmin 0", "policy", (0, 0, 5), UP, TRI,
                 "self-intersection: closed or open at tmin is a policy")
    yield corner(45, "origin on the triangle, tmin one subnormal", "nohit", (0, 0, 5), UP, TRI,
                 tmin=2.0**-149)
    yield corner(46, "secondary ray from a rounded hit point", "self", (0.3, 0.3, ulps(0.4, -2)),
                 (0.25, 0.5, 1), [[(1, 0, 0), (0, 1, 0), (0, 0, 1)]],
                 "o lies an ulp behind its own surface: whoever spawns the ray must move it off")
    yield corner(47, "scene at 1e6 offset, unit triangle", "exact", (FAR + 0.25, FAR + 0.25, FAR),
                 UP, [[(FAR, FAR, FAR + 5), (FAR + 1, FAR, FAR + 5), (FAR, FAR + 1, FAR + 5)]],
                 "np ~ 1e6 cancels; p-o is exact")
    yield corner(48, "scene at 1e6, edge pair", "watertight", (FAR + 0.5, FAR + 0.5, FAR), UP,
                 quad(FAR, FAR + 1, FAR + 5))
    yield corner(49, "far origin 1e6, unit scene", "exact", (0, 0, -FAR), UP, TRI)
    yield corner(50, "far origin 1e6, edge pair", "watertight", (1, 1, -FAR), UP, QUAD)
    yield corner(51, "long ray, unnormalised direction 1e-6", "exact", ZERO, (0, 0, 1e-6), TRI)
    yield corner(52, "unnormalised direction 1e6", "exact", ZERO, (0, 0, 1e6), TRI)
    yield corner(53, "mixed scale: 1 beside 1e6", "exact", ZERO, UP, [wall(5, 1e6), wall(4, 1e-3)])
    yield corner(54, "axis-aligned wall, nu = nv = 0", "exact", ZERO, (1, 0.5, 0.25), [[(5, 0, 0),
                 (5, 4, 0), (5, 0, 4)]], "exact zeros times anything must stay zeros")
    yield corner(55, "normal tie |nx|=|ny|=|nz|: choice of the dominant axis", "exact", ZERO, (1,
                 1, 1), [[(1, 0, 0), (0, 1, 0), (0, 0, 1)]])
    yield corner(56, "two triangles across a dominant-axis change share an edge", "watertight",
                 ZERO, (1, 0, 1), [[(0, 0, 1), (1, 0, 0), (0, 1, 0)], [(0, 0, 1), (0, -1, 0.5), (1,
                 0, 0)]])
    yield corner(57, "exactly through a vertex with a fan of six", "watertight", ZERO, UP, fan())
    yield corner(58, "slanted ray exactly through a vertex with a fan of six", "watertight", (-5,
                 -5, 0), (1, 1, 1), fan())
    yield corner(59, "T-junction: vertex on a neighbour edge, not shared", "watertight",
                 (1.5, 0.5, 0), UP,
                 [[(0, 0, 5), (3, 1, 5), (0, 2, 5)], [(0, 0, 5), (3, -2, 5), (1.5, 0.5, 5)],
                  [(1.5, 0.5, 5), (3, -2, 5), (3, 1, 5)]])
    yield corner(60, "backface", "exact", ZERO, UP, [[(-1, -1, 5), (0, 1, 5), (1, -1, 5)]],
                 "no culling: must be hit")
    yield corner(61, "just behind the origin", "nohit", ZERO, UP, [wall(-(2.0**-149))])
    slant = [[(0, 0, 0), (1, 0, -1), (0, 1, -1)], [(0, 0, 0), (2, 0, -2), (0, 2, -2)]]
    yield corner(62, "det is the last bit of its terms, hit", "exact", (-0.5, -0.5, ulps(1, 2)),
                 (1, 1, -ulps(2, 1)), slant[1:])
    yield corner(63, "cancelling det: nu*du+nv*dv+dw to the last bit", "exact", (-3, -3, 7), (1, 1,
                 -ulps(2, 1)), slant[:1])
    # fmt: on


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--out", type=Path, default="scenes/hardcases.jsonl", help="file to write (%(default)s)"
    )
    parser.add_argument(
        "--check", type=Path, metavar="FILE", help="compare with FILE and write nothing"
    )
    args = parser.parse_args()
    made = list(cases())
    if args.check is None:
        args.out.write_text("".join(json.dumps(case) + "\n" for case in made), encoding="utf-8")
        print(f"{args.out}: {len(made)} cases")
        return 0
    by_number = {case["n"]: case for case in made}
    lines = args.check.read_text(encoding="utf-8").splitlines()
    given = [json.loads(line) for line in lines if line.strip()]
    wrong = 0
    for case in given:
        own = by_number.get(case["n"], {})
        for key in case:
            if case[key] != own.get(key):
                wrong += 1
                print(f"case {case['n']}, {key}: {case[key]!r} there, {own.get(key)!r} here")
    print(f"{len(given)} cases compared, {wrong} fields differ")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
