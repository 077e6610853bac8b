# SPDX-License-Identifier: Apache-2.0
"""Cases for the passes of IST1: a dict of what the pass reads, as bits.

(a): plane, axis, o, d, tnear, tfar.  (b): bary, axis, d, after_a = (det, dett, audet, av), det
finite and not 0, as pass (a) leaves it.
"""

from models.numbers import numbers
from models.payload import configuration
from models.scene import Scene, rays_through, soup


def plane_words(nu, nv, p, axis, prim=0):
    return (nu, nv, *p, axis, prim, 0)


def pass_a(*case):
    """Pass (a) of the configuration's test."""
    return numbers().model("pass_a", *case, configuration()["triangle_test"] == "np")


def expected(case):
    """What the model makes of a case: (det, dett, x, y), or None when the test is done."""
    n, plane = numbers(), case.get("plane", plane_words(0, 0, (0, 0, 0), case["axis"]))
    if "after_a" in case:
        return n.model("pass_b", plane, case["bary"], case["d"], case["after_a"])
    return pass_a(plane, case["o"], case["d"], case["tnear"], case["tfar"])


def pass_a_cases(rng, count):
    yield from corners_of_a(rng)
    for end in ("tnear", "tfar"):
        yield from near_end(rng, count // 6, end)
    n = numbers()
    for _ in range(count // 3):
        axis = rng.randrange(3)
        plane = plane_words(n.any(rng), n.any(rng), n.any_vec(rng), axis)
        yield case_a(plane, n.any_vec(rng), n.any_vec(rng), n.any(rng), n.any(rng))
    scene = Scene(soup(rng, 40))
    for o, d in rays_through(rng, count // 3):
        tnear = rng.choice((0, n.of(rng.uniform(0, 1.5))))
        tfar = rng.choice((n.inf, n.of(rng.uniform(0, 3))))
        yield case_a(rng.choice(scene.planes), o, d, tnear, tfar)


def case_a(plane, o, d, tnear, tfar):
    return {"plane": plane, "axis": plane[5], "o": o, "d": d, "tnear": tnear, "tfar": tfar}


def corners_of_a(rng):
    """det 0, no tilt, tiny and huge values, a plane through the origin of the ray."""
    n = numbers()
    least, most, one, minus = 1, n.inf - 1, n.one, n.one | n.sign
    zero = (0, 0, 0)
    far = (one, one, n.of(2.0))  # u, v, w
    for axis in range(3):
        along = tuple(n.one if a == axis else 0 for a in range(3))
        across = tuple(0 if a == axis else n.one for a in range(3))
        skew = tuple(minus if a == axis else one for a in range(3))
        ends = (n.inf, one, 0, n.sign, least, most, n.of(2.0), n.nan)
        for tnear, tfar in [*((0, end) for end in ends), *((end, n.inf) for end in ends)]:
            for nu, nv in [(0, 0), (n.sign, 0), (one, 0), (one, minus), (least, least), (most, 0)]:
                for p in (zero, far, (most, most, most), (least, least, least)):
                    for d in (along, across, skew):
                        yield case_a(plane_words(nu, nv, p, axis), zero, d, tnear, tfar)


def near_end(rng, count, end):
    """That end of the range is the t of this very test, or up to 12 ulp beside it."""
    n = numbers()
    while count > 0:
        axis = rng.randrange(3)
        scale = 2.0 ** rng.choice((0, 0, -6, 4))
        plane = plane_words(
            n.of(rng.uniform(-1, 1)),
            n.of(rng.uniform(-1, 1)),
            n.vec(rng.uniform(-2, 2) * scale for _ in range(3)),
            axis,
        )
        o = n.vec(rng.uniform(-2, 2) * scale for _ in range(3))
        d = n.direction(rng)
        a = pass_a(plane, o, d, 0, n.inf)
        if a is None:
            continue
        hit = n.model("pass_c", (a[0], a[1], 0, 0))
        if hit is None or not 12 < hit[0] < n.inf - 12:
            continue
        for _ in range(8):
            yield {**case_a(plane, o, d, 0, n.inf), end: hit[0] + rng.randint(-12, 12)}
        count -= 8


def pass_b_cases(rng, count):
    yield from corners_of_b()
    n = numbers()
    for _ in range(count // 2):
        after_a = (finite_not_zero(rng), finite_not_zero(rng), *map(one_nan, n.any_vec(rng)[:2]))
        bary = (*n.any_vec(rng), n.any(rng))
        yield case_b(bary, rng.randrange(3), n.any_vec(rng), after_a)
    scene = Scene(soup(rng, 60, size=1.0))
    left = count // 2
    while left > 0:
        for o, d in rays_through(rng, left):
            record = rng.randrange(scene.count)
            plane = scene.planes[record]
            after_a = pass_a(plane, o, d, 0, n.inf)
            if after_a is not None:
                left -= 1
                yield case_b(scene.barys[record], plane[5], d, after_a)


def case_b(bary, axis, d, after_a):
    return {"bary": bary, "axis": axis, "d": d, "after_a": after_a}


def corners_of_b():
    """On an edge, on a corner, one ulp beyond; infinite and NaN products.

    With d = 0 and det = +-1, Du = -audet and Dv = -av*det; the edges are unit vectors, so that detu
    and detv are Du and Dv up to sign.
    """
    n = numbers()
    one, half, s = n.one, n.of(0.5), n.sign
    zero = (0, 0, 0)
    values = (0, s, 1, s | 1, half, half + 1, half - 1, one, one - 1, one + 1)
    for sign in (0, s):
        for x in (*values, n.inf, n.nan):
            for y in (*values, n.inf, n.nan):
                for fx, fy in ((0, 0), (0, s), (s, 0), (s, s)):
                    after_a = (one | sign, one, one_nan(x ^ fx), one_nan(y ^ fy))
                    yield case_b((one, 0, 0, one), 0, zero, after_a)


def one_nan(bits):
    n = numbers()
    return n.nan if bits & (n.sign - 1) > n.inf else bits


def finite_not_zero(rng):
    n = numbers()
    while True:
        bits = n.any(rng)
        if 0 < bits & (n.sign - 1) < n.inf:
            return bits
