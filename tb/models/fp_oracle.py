# SPDX-License-Identifier: Apache-2.0
"""Floating-point results of any (E, M) from MPFR, independent of the project's own model."""

from dataclasses import dataclass
from functools import cached_property

import gmpy2

_WIDE = gmpy2.context(precision=64)


@dataclass(frozen=True)
class Oracle:
    """A format with its operations on images (integers of `width` bits).

    IEEE 754, round to nearest even or toward zero, every NaN result the quiet NaN with sign 0 and
    fraction 10...0; subnormals kept, or zeros of their sign as operands and, after rounding as if
    exponents had no end, as results: the written rule of `rtl/fp`.
    """

    exp_bits: int
    frac_bits: int
    toward_zero: bool = False
    flush: bool = False
    table_bits: int = 0  # of the index into the seeds of a reciprocal; 0: correctly rounded
    newton_steps: int = 0

    @property
    def width(self):
        return 1 + self.exp_bits + self.frac_bits

    @property
    def bias(self):
        return (1 << (self.exp_bits - 1)) - 1

    @property
    def inf(self):
        """The image of +infinity."""
        return ((1 << self.exp_bits) - 1) << self.frac_bits

    @property
    def nan(self):
        return self.inf | 1 << (self.frac_bits - 1)

    @property
    def sign(self):
        return 1 << (self.width - 1)

    @property
    def least_normal(self):
        return 2.0 ** (1 - self.bias)

    @cached_property
    def context(self):
        return gmpy2.context(
            precision=self.frac_bits + 1,
            emax=self.bias + 1,
            emin=-4096 if self.flush else 2 - self.bias - self.frac_bits,
            subnormalize=not self.flush,
            round=gmpy2.RoundToZero if self.toward_zero else gmpy2.RoundToNearest,
        )

    def value(self, bits):
        """The exact number that an image stands for."""
        negative, magnitude = bool(bits & self.sign), bits & (self.sign - 1)
        if magnitude > self.inf:
            return gmpy2.nan()
        if magnitude == self.inf:
            return gmpy2.inf(-1 if negative else 1)
        field, fraction = magnitude >> self.frac_bits, magnitude & ((1 << self.frac_bits) - 1)
        if field:
            fraction |= 1 << self.frac_bits
        elif self.flush:
            fraction = 0
        exponent = max(field, 1) - self.bias - self.frac_bits
        result = _WIDE.mul_2exp(gmpy2.mpfr(fraction, 64), exponent + 1024)
        result = _WIDE.div_2exp(result, 1024)
        return -result if negative else result

    def bits(self, value):
        """The image of a number of the format, or of one that is flushed."""
        if gmpy2.is_nan(value):
            return self.nan
        sign = self.sign if gmpy2.is_signed(value) else 0
        if gmpy2.is_infinite(value):
            return sign | self.inf
        if gmpy2.is_zero(value) or (self.flush and abs(value) < self.least_normal):
            return sign
        numerator, denominator = abs(value).as_integer_ratio()
        # value = m / 2^k: the unit of the last place is 2^(max(e, 1 - bias) - M).
        exponent = max(numerator.bit_length() - denominator.bit_length(), 1 - self.bias)
        scaled = numerator << (self.frac_bits + 2 * self.bias)
        fraction, rest = divmod(scaled, denominator << (exponent + 2 * self.bias))
        assert rest == 0, f"{value} is not a number of {self}"
        return sign | ((exponent + self.bias - 1) << self.frac_bits) + fraction

    def add(self, a, b):
        return self.bits(self.context.add(self.value(a), self.value(b)))

    def sub(self, a, b):
        return self.bits(self.context.sub(self.value(a), self.value(b)))

    def mul(self, a, b):
        return self.bits(self.context.mul(self.value(a), self.value(b)))

    def rcp(self, a):
        value = self.value(a)
        if self.table_bits and gmpy2.is_finite(value) and not gmpy2.is_zero(value):
            return self.newton(value)
        return self.bits(self.context.div(gmpy2.mpfr(1), value))

    def newton(self, value):
        """The image of 1 / value by the rule of docs/fp.md, rounded by MPFR at last."""
        m, k = self.frac_bits, self.table_bits
        numerator, denominator = abs(value).as_integer_ratio()
        exponent = numerator.bit_length() - denominator.bit_length()
        x = (numerator << m + max(0, -exponent)) // (denominator << max(0, exponent))
        y = (1 << m + 3) if x == 1 << m else self._newton_steps(x, m, k)
        inverse = gmpy2.div_2exp(_WIDE.mul_2exp(gmpy2.mpfr(y, 64), 1024), 1024 + m + 3)
        inverse = gmpy2.div_2exp(gmpy2.mul_2exp(inverse, 1024), 1024 + exponent)
        inverse = -inverse if gmpy2.is_signed(value) else inverse
        return self.bits(self.context.mul(inverse, gmpy2.mpfr(1)))

    def _newton_steps(self, x, m, k):
        middle = gmpy2.mpq(2 * (x >> m - k) + 1, 2 << k)  # of the interval, between 1 and 2
        y = int(gmpy2.mpq(2 << k) / middle + gmpy2.mpq(1, 2)) << m + 2 - k
        for _ in range(self.newton_steps):
            factor = 2 * (1 << m + 3) - 1 - x * y // (1 << m)
            y = y * factor // (1 << m + 3) + (not self.toward_zero)
        return y

    def lt(self, a, b):
        return int(self.value(a) < self.value(b))

    def le(self, a, b):
        return int(self.value(a) <= self.value(b))

    def eq(self, a, b):
        return int(self.value(a) == self.value(b))

    def specials(self):
        """Zeros, ends of the ranges, one and its neighbours, infinities, NaNs; both signs."""
        one = self.bias << self.frac_bits
        least_normal = 1 << self.frac_bits
        magnitudes = [0, 1, 2, least_normal - 1, least_normal, least_normal + 1]
        magnitudes += [one - 1, one, one + 1, one + (least_normal >> 1), 2 * one - 1]
        magnitudes += [self.inf - 1, self.inf, self.inf + 1, self.nan, self.sign - 1]
        magnitudes += [(2 * self.bias - 1) << self.frac_bits, 2 * self.bias << self.frac_bits]
        return [s | m for m in dict.fromkeys(magnitudes) for s in (0, self.sign)]

    def pairs(self, rng, count):
        """All pairs of specials, then `count` seeded ones: uniform, near exponents, cancelling."""
        specials = self.specials()
        yield from ((a, b) for a in specials for b in specials)
        for i in range(count):
            a = rng.getrandbits(self.width)
            if i % 4 == 0:
                b = rng.getrandbits(self.width)
            elif i % 4 == 1:
                b = rng.choice(specials)
            elif i % 4 == 2:  # so near that the smaller operand decides the rounding
                reach = self.frac_bits + 3
                field = (a >> self.frac_bits) % (1 << self.exp_bits) + rng.randint(-reach, reach)
                field = min(max(field, 0), (1 << self.exp_bits) - 1)
                b = field << self.frac_bits | rng.getrandbits(self.frac_bits)
                b |= rng.choice((0, self.sign))
            else:  # nearly equal magnitudes
                b = (a + rng.randint(-4, 4) ^ rng.choice((0, self.sign))) % (1 << self.width)
            yield (a, b) if rng.random() < 0.5 else (b, a)
