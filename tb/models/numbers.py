# SPDX-License-Identifier: Apache-2.0
"""Bit patterns of the simulation's number format: from floats, special and random ones."""

from functools import cache

import ti_model
from models.fp_oracle import Oracle
from models.payload import payloads


class Numbers:
    """Images of a format with its modes, and the model's functions on it."""

    def __init__(self, exp_bits, frac_bits, *modes):
        self.oracle = Oracle(exp_bits, frac_bits, *modes)
        self.inf, self.nan, self.sign = self.oracle.inf, self.oracle.nan, self.oracle.sign
        self.width, self.bias, self.frac_bits = self.oracle.width, self.oracle.bias, frac_bits
        self.one = self.bias << frac_bits
        self.specials = [self.entering(bits) for bits in self.oracle.specials()]
        self.format = ti_model.Format(exp_bits, frac_bits, *modes)

    def of(self, value):
        """Bits of the number nearest to a float."""
        return ti_model.fp_from_double(self.format, value)

    def vec(self, values):
        return tuple(self.of(value) for value in values)

    def float(self, bits):
        return ti_model.fp_to_double(self.format, bits)

    def model(self, name, *arguments):
        """`ti_model.<name>` in this format."""
        return getattr(ti_model, name)(self.format, *arguments)

    def any(self, rng):
        """Any number that enters an engine; every third a special one."""
        if rng.random() < 1 / 3:
            return rng.choice(self.specials)
        return self.entering(rng.getrandbits(self.width))

    def entering(self, bits):
        """What programs make of bits that enter an engine: zero of what would be flushed."""
        tiny = bits & (self.sign - 1) < 1 << self.frac_bits
        return bits & self.sign if self.oracle.flush and tiny else bits

    def any_vec(self, rng):
        return tuple(self.any(rng) for _ in range(3))

    def direction(self, rng):
        """A direction of ordinary length; every third has components that are 0 or -0."""
        d = [rng.uniform(-1, 1) for _ in range(3)]
        if rng.random() < 1 / 3:
            for axis in rng.sample(range(3), rng.randint(1, 2)):
                d[axis] = rng.choice((0.0, -0.0))
        return self.vec(d)

    def less(self, a, b):
        return self.model("fp_lt", a, b)


@cache
def numbers():
    """Those of the configuration that this simulation was built for."""
    return Numbers(*payloads().format)


def hexed(value):
    """A case as text that can be pasted back, with its integers in hexadecimal."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{k!r}: {hexed(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "(" + ", ".join(hexed(v) for v in value) + ",)"
    return f"{value:#x}" if type(value) is int else repr(value)
