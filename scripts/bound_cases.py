# SPDX-License-Identifier: Apache-2.0
"""Number formats as `certify.py` gives them to Gappa, and what the code says of each."""

from dataclasses import dataclass
from fractions import Fraction
from functools import cache

import ti_model

ROUNDINGS = {"nearest": "ne", "zero": "zr"}
NEWTON = {"rcp_table_bits": 7, "rcp_newton_steps": 2}


def dyadic(value: Fraction) -> str:
    """A dyadic number as Gappa reads it."""
    places = value.denominator.bit_length() - 1
    assert value.denominator == 1 << places, value
    return f"{value.numerator}b-{places}"


def power(exponent: int) -> Fraction:
    return Fraction(2) ** exponent


@dataclass(frozen=True)
class Case:
    """A number format with its rounding and reciprocal, and what the code says of it."""

    exp_bits: int
    frac_bits: int
    rounding: str
    reciprocal: str

    def name(self, inverse: bool) -> str:
        """As in a table; the reciprocal where it counts."""
        name = f"({self.exp_bits},{self.frac_bits}) {self.rounding}"
        return f"{name}, {self.reciprocal}" if inverse else name

    @property
    def newton(self) -> bool:
        return self.reciprocal == "newton"

    @property
    def u(self) -> Fraction:
        """Half a unit in the last place of 1."""
        return power(-self.frac_bits - 1)

    @property
    def least_normal(self) -> int:
        """Its exponent."""
        return 2 - (1 << (self.exp_bits - 1))

    @property
    def config(self) -> dict[str, object]:
        """Keys of a configuration."""
        return {
            "frac_bits": self.frac_bits,
            "rounding": self.rounding,
            "reciprocal": self.reciprocal,
        } | NEWTON

    def used(self, name: str) -> Fraction:
        """A bound of the code."""
        return Fraction(bounds_of(self)[name])

    def numbers(self) -> dict[str, str]:
        """What stands for @NAME@ in every template."""
        m = self.frac_bits
        operation = self.used("rounding_unit")
        return {
            "P": str(m + 1),
            "M": str(m),
            "Q": str(m + 3),
            "EMIN": str(self.least_normal - m),
            "NORMAL": f"1b{self.least_normal}",
            "TWICE": f"1b{self.least_normal + 1}",
            "LARGE": f"1b{1 - self.least_normal}",
            "ROUND": ROUNDINGS[self.rounding],
            "A": dyadic(operation),
            "H": dyadic(self.used("half_ulps") * self.u),
            "UP": "0" if self.rounding == "zero" else f"1b-{m + 3}",
            "SEED": dyadic(3 * power(-NEWTON["rcp_table_bits"] - 2)),
        }


@cache
def bounds_of(case: Case) -> dict[str, float]:
    """All that the code says of a case, by name."""
    form = ti_model.Format(
        case.exp_bits,
        case.frac_bits,
        toward_zero=case.rounding == "zero",
        table_bits=NEWTON["rcp_table_bits"] if case.newton else 0,
        newton_steps=NEWTON["rcp_newton_steps"],
    )
    return ti_model.bounds_used(form)
