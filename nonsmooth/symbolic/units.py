"""Dimensions of typed expressions, from the units of their symbols.

    [a b] = [a][b],    [a + b] = [a] = [b],    [a^n] = [a]^n,    [sin x] = [x] = 1

A symbol without a unit fits everywhere, and so does whatever is made of it; so do a number that is added, as 2 in
2 - x, and a decimal one of any value, which may have a unit of its own, as 0.5 in 0.5 sin th; whole numbers and
fractions of them (1/2 of SymPy) have none.
Angles are numbers (rad = 1).
"""

from __future__ import annotations

import re
from fractions import Fraction
from typing import Any

import sympy as sp

from nonsmooth.errors import InvalidInput

BASES = {
    "kg": (1, 0, 0), "m": (0, 1, 0), "s": (0, 0, 1), "N": (1, 1, -2), "J": (1, 2, -2), "W": (1, 2, -3),
    "Hz": (0, 0, -1), "Pa": (1, -1, -2), "rad": (0, 0, 0), "-": (0, 0, 0), "1": (0, 0, 0),
}  # fmt: skip
NAMES: dict[tuple[float, ...], str] = {  # a whole fraction is equal to its number
    (1, 2, -2): "J or N m", (0, 1, 0): "m", (0, 1, -1): "m/s", (1, 1, -2): "N", (0, 0, 0): "1 or rad", (1, 0, 0): "kg",
    (1, 2, -3): "W", (1, 2, 0): "kg m^2", (0, 1, -2): "m/s^2",
}  # fmt: skip
FACTOR = re.compile(r"(-|1|[A-Za-z]+)(?:\^?(-?\d+))?")

Dimension = tuple[Fraction, Fraction, Fraction]  # exponents of kg, m, s


def dimension(unit: str) -> Dimension | None:
    """The dimension of a unit such as ``"kg m^2/s"``; None where no unit is given.

    Raises
    ------
    InvalidInput
        For what is no product of kg, m, s, N, J, W, Hz, Pa, rad.
    """
    if not unit:
        return None
    over, *under = unit.split("/")
    factors = [(part, 1) for part in over.split()] + [(part, -1) for text in under for part in _bare(text).split()]
    total = [Fraction(0)] * 3
    for part, sign in factors:
        found = FACTOR.fullmatch(part)
        if not found or found[1] not in BASES:
            raise InvalidInput(
                f"a unit must be a product of kg, m, s, N, J, W, Hz, Pa and rad, such as 'kg m^2/s'; got {unit!r}"
            )
        exponent = sign * int(found[2] or 1)
        total = [sum_ + exponent * base for sum_, base in zip(total, BASES[found[1]], strict=True)]
    return total[0], total[1], total[2]


def _bare(text: str) -> str:
    return text.strip().removeprefix("(").removesuffix(")")


def unit_of(found: Dimension) -> str:
    """A dimension in words."""
    powers = [f"{base}^{exponent}" for base, exponent in zip(("kg", "m", "s"), found, strict=True) if exponent]
    return NAMES.get(tuple(map(float, found))) or " ".join(power.removesuffix("^1") for power in powers)


class Dimensions:
    """Dimensions of expressions whose symbols have known units.

    Parameters
    ----------
    units : dict
        Symbol -> dimension or None.
    """

    def __init__(self, units: dict[Any, Dimension | None]) -> None:
        self._units = units

    def of(self, expression: Any) -> Dimension | None:
        """The dimension of an expression, None where it is not known.

        Raises
        ------
        InvalidInput
            Where terms of different dimensions are added, or a function is taken of what has one.
        """
        if expression.is_Number or expression.is_NumberSymbol:
            return None if expression.is_Float else dimension("1")
        if expression.is_Symbol:
            return self._units.get(expression)
        branches = [part.args[0] if isinstance(part, sp.Tuple) else part for part in expression.args]
        parts = [self.of(part) for part in branches]
        if expression.is_Mul:
            return _product(parts)
        if expression.is_Pow:
            return self._power(expression, parts[0])
        if expression.is_Add or isinstance(expression, sp.Max | sp.Min | sp.Abs | sp.Piecewise):
            return self._same(expression, [part for part, of in zip(parts, branches, strict=True) if not of.is_number])
        if isinstance(expression, sp.sign):
            return dimension("1")
        return self._function(expression, parts)

    def _same(self, expression: Any, parts: list[Dimension | None]) -> Dimension | None:
        known = [part for part in parts if part is not None]
        if len({*known}) > 1:
            raise InvalidInput(
                f"the terms of {shortened(expression)} have different units, {unit_of(known[0])} and "
                f"{unit_of(next(part for part in known if part != known[0]))}"
            )
        return known[0] if known else None

    def _function(self, expression: Any, parts: list[Dimension | None]) -> Dimension | None:
        if isinstance(expression, sp.atan2):
            self._same(sp.Add(*expression.args), parts)
            return dimension("1")
        for part, argument in zip(parts, expression.args, strict=False):
            if part is not None and part != dimension("1"):
                raise InvalidInput(
                    f"{type(expression).__name__} is taken of {shortened(argument)}, which has the unit {unit_of(part)}"
                )
        return dimension("1")

    def _power(self, expression: Any, base: Dimension | None) -> Dimension | None:
        if base is None:
            return None
        if expression.exp.is_Rational:
            factor = Fraction(int(expression.exp.p), int(expression.exp.q))
            return base[0] * factor, base[1] * factor, base[2] * factor
        return base if not any(base) else None


def _product(parts: list[Dimension | None]) -> Dimension | None:
    known = [part for part in parts if part is not None]
    if len(known) < len(parts):
        return None
    kg, m, s = (sum(column, Fraction(0)) for column in zip(*known, strict=True))
    return kg, m, s


def shortened(expression: Any) -> str:
    """An expression in a message."""
    text = str(expression)
    return text if len(text) <= 60 else text[:57] + "..."
