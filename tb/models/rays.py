# SPDX-License-Identifier: Apache-2.0
"""Rays and boxes as bits: the corner cases of ray set-up, and random ones."""

from models.numbers import numbers
from models.payload import configuration, payloads

KEYS = ("o", "d", "tmin", "tmax")


def unit_box():
    n = numbers()
    return n.vec((-1, -1, -1)), n.vec((1, 1, 1))


def setup_cases(rng, count):
    """(box_lo, box_hi, ray), a ray being a dict of o, d, tmin, tmax; ten random rays a box."""
    box = unit_box()
    corners = [
        *parallel_rays(),
        *rays_from_faces(),
        *bad_rays(),
        *odd_intervals(),
        *odd_directions(),
    ]
    yield from ((*box, ray) for ray in corners)
    n = numbers()
    flat = n.vec((-1, 0.5, -1)), n.vec((1, 0.5, 1))
    point = (n.vec((1, 1, 1)),) * 2
    for o, d in [((0, 2, 0), (0, -1, 0)), ((0, 0.5, 0), (1, 0, 0)), ((2, 2, 2), (-1, -1, -1))]:
        for around in (flat, point):
            yield (*around, ray(n.vec(o), n.vec(d)))
    for i in range(count):
        if i % 10 == 0:
            lo = [rng.uniform(-2, 1) for _ in range(3)]
            hi = [x + rng.choice((0, rng.uniform(0, 2))) for x in lo]
        yield n.vec(lo), n.vec(hi), random_ray(rng)


def clip(box_lo, box_hi, given):
    """What the model makes of a ray: (miss, status, inverse, tmin, tmax)."""
    miss, status, inv, tmin, tmax = numbers().model(
        "clip", box_lo, box_hi, *given.values(), padded()
    )
    return int(miss), status, tuple(inv), tmin, tmax


def padded():
    """Whether the configuration's rays are thick."""
    return configuration()["traversal"] == "padded"


def origins(box_lo, box_hi, o, d):
    """Where a ray begins for its way through the tree."""
    least, most = (o, o)
    if padded():
        least, most = numbers().model("thick_origins", box_lo, box_hi, o, d)
    return {"least": tuple(least), "most": tuple(most)}


def operands(o, d):
    """What the configuration's triangle test needs of a ray."""
    if configuration()["triangle_test"] != "woop":
        return {"o": o, "d": d}
    n = numbers()
    z, (sx, sy, sz) = n.model("shear", d, [n.model("fp_rcp", x) for x in d])
    top = n.width - 2  # the bit in which the axis stands
    return {"o": o, "d": (sx & ~(1 << top) | (z & 1) << top, sy & ~(1 << top) | z >> 1 << top, sz)}


def shear_of(d):
    """(z, (sx, sy, sz)) of operands of Woop's test."""
    top = 1 << numbers().width - 2
    z = int(bool(d[0] & top)) | int(bool(d[1] & top)) << 1
    return z, (d[0] & ~top, d[1] & ~top, d[2])


def dispatched(box, given, inv, tmin, tmax, ray_id=0, any_hit=0):
    """A ray as RD sends it to its home, in a scene of that box."""
    return payloads().pack(
        "dispatch_t",
        ray_id=ray_id,
        any_hit=any_hit,
        operands=operands(given["o"], given["d"]),
        origins=origins(*box, given["o"], given["d"]),
        ray_tmin=given["tmin"],
        ray_tmax=given["tmax"],
        inv=inv,
        tmin=tmin,
        tmax=tmax,
    )


def ray(o, d, tmin=0, tmax=None):
    return dict(zip(KEYS, (o, d, tmin, numbers().inf if tmax is None else tmax), strict=True))


def random_ray(rng):
    """Ordinary (some with zeros in d, some with any interval), or any bits at all."""
    n = numbers()
    if rng.random() < 0.3:
        return ray(n.any_vec(rng), n.any_vec(rng), n.any(rng), n.any(rng))
    o = n.vec(rng.choice((0, 1, -1, rng.uniform(-3, 3))) for _ in range(3))
    tmin, tmax = rng.choice((0, n.sign, n.of(rng.uniform(-2, 2)))), n.of(rng.uniform(0, 8))
    return ray(o, n.direction(rng), tmin, rng.choice((n.inf, tmax)))


def parallel_rays():
    """Along one axis and across one, both zeros, origin in, on, just beyond and far from a face."""
    n = numbers()
    one = n.one
    places = [0, one, one | n.sign, one + 1, one - 1, one + 1 | n.sign, n.of(3.0)]
    for axis in range(3):
        for zero in (0, n.sign):
            for place in places:
                o = tuple(place if a == axis else 0 for a in range(3))
                across = tuple(zero if a == axis else one for a in range(3))
                along = tuple(one | zero if a == axis else zero for a in range(3))
                yield ray(o, across)
                yield ray(o, along)
                yield ray(tuple(place if a != axis else 0 for a in range(3)), along)


def rays_from_faces():
    """Origin on faces, edges, corners; directions inward, outward and along them."""
    n = numbers()
    values = (0, n.one, n.one | n.sign)
    for o in [(x, y, z) for x in values for y in values for z in values]:
        for d in [(1, 1, 1), (-1, -1, -1), (1, -1, 1), (-1, 1, 0.5), (0, 1, -1), (-0.0, -0.0, 1)]:
            yield ray(o, n.vec(d))


def bad_rays():
    """NaN and infinity in each place, no direction at all."""
    n = numbers()
    o, d = n.vec((0, 0, 0)), n.vec((1, 1, 1))
    negative_nan = n.nan | n.sign
    for bad in (n.nan, negative_nan, n.inf + 1, n.inf, n.inf | n.sign):
        for axis in range(3):
            yield ray(tuple(bad if a == axis else o[a] for a in range(3)), d)
            yield ray(o, tuple(bad if a == axis else d[a] for a in range(3)))
        yield ray(o, d, tmin=bad)
        yield ray(o, d, tmax=bad)
    for zeros in [(0, 0, 0), (n.sign, 0, n.sign), (n.sign,) * 3, (1, 1, 1), (1, n.sign, 0)]:
        yield ray(o, zeros)
        yield ray(n.vec((5, 5, 5)), zeros)


def odd_intervals():
    """tmin above, at and below tmax; negative ends; ends on the box and a few ulp beside it."""
    n = numbers()
    o, d = n.vec((-3, 0, 0)), n.vec((1, 0, 0))  # inside from 2 to 4
    two, four = n.of(2.0), n.of(4.0)
    ends = [0, n.sign, 1, 1 | n.sign, n.one, n.one | n.sign, n.of(3.0), n.inf, n.inf | n.sign]
    ends += [e + ulps for e in (two, four) for ulps in (-5, -4, -1, 0, 1, 4, 5)] + [n.inf - 1]
    for tmin in ends:
        for tmax in ends:
            yield ray(o, d, tmin, tmax)
    for behind in (n.vec((3, 0, 0)), n.vec((1, 0, 0))):
        yield ray(behind, d)


def odd_directions():
    """Subnormal, least, most: inverses that are infinite, subnormal or just finite."""
    n = numbers()
    least_normal = 1 << n.frac_bits
    sizes = [1, 2, least_normal >> 2, (least_normal >> 2) + 1, (least_normal >> 1) + 1]
    sizes += [least_normal - 1, least_normal, n.inf - 1, n.inf - 2, (2 * n.bias) << n.frac_bits]
    for size in sizes:
        for sign in (0, n.sign):
            for o in (n.vec((-3, 0, 0)), n.vec((0, 0.5, 0)), n.vec((1, 1, 1))):
                yield ray(o, (size | sign, 0, 0))
                yield ray(o, (size | sign, n.one, size))
                yield ray(o, (size | sign,) * 3)
