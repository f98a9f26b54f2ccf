"""Checks of what is typed: an expression, of what it may read, real and finite, in the unit that it must have."""

from __future__ import annotations

import math
from typing import Any

import sympy as sp

from nonsmooth.checks.arrays import as_listed
from nonsmooth.errors import InvalidInput, shown
from nonsmooth.symbolic.units import Dimension, Dimensions, dimension, shortened, unit_of

FUNCTIONS = (
    sp.sin, sp.cos, sp.tan, sp.asin, sp.acos, sp.atan, sp.atan2, sp.sinh, sp.cosh, sp.tanh, sp.asinh, sp.acosh,
    sp.atanh, sp.exp, sp.log, sp.Abs, sp.sign, sp.Max, sp.Min, sp.Piecewise,
)  # fmt: skip


class Expressions:
    """The checks of one declaration.

    Parameters
    ----------
    owner : Lagrangian
        Whose symbols they may read.
    """

    def __init__(self, owner: Any) -> None:
        self._owner = owner
        self.translation: dict[Any, Any] = {}  # from the symbols of another program to ours

    def of_parameters(self, what: str, value: Any, unit: str = "") -> Any:
        """An expression in parameters alone."""
        return self._checked(what, value, unit, {*self._owner.parameter_fields}, "parameters")

    def of_configuration(self, what: str, value: Any, unit: str = "") -> Any:
        """An expression in coordinates, parameters and time."""
        allowed = {*self._owner.symbols} - {*self._owner.declared.u}
        return self._checked(what, value, unit, allowed, "coordinates, parameters and time")

    def of_state(self, what: str, value: Any, unit: str = "") -> Any:
        """An expression that may read the rates too."""
        return self._checked(what, value, unit, {*self._owner.symbols}, "coordinates, rates, parameters and time")

    def vector(self, what: str, value: Any, unit: str = "", rates: bool = False) -> tuple[Any, ...]:
        """The components of a vector, one to three."""
        entries = as_listed(what, value, "a vector of expressions")
        if not 1 <= len(entries) <= 3:
            raise InvalidInput(f"{what} must have one to three components; got {len(entries)}")
        check = self.of_state if rates else self.of_configuration
        return tuple(check(what, entry, unit) for entry in entries)

    def require_unit(self, what: str, expression: Any, unit: str) -> None:
        """Refuse an expression whose symbols all have units, and that has another one."""
        found, wanted = self._dimension(expression), dimension(unit)
        if found not in (None, wanted) and not expression.is_number:
            raise InvalidInput(f"{what} must have the unit {unit}; {shortened(expression)} has {unit_of(found)}")

    def sample(self, expression: Any) -> float:
        """The value at the parameters, and at coordinates that are nobody's choice; NaN where there is none."""
        values = {symbol: field.value for symbol, field in self._owner.parameter_fields.items()}
        values |= {symbol: 0.37 + 0.11 * k for k, symbol in enumerate([*self._owner.declared.q, self._owner.t])}
        value = expression.subs(values)
        return float(value) if value.is_real else math.nan

    def unit(self, expression: Any) -> str:
        """The unit of an expression in words; nothing where it is not known."""
        found = self._dimension(expression)
        return "" if found is None else unit_of(found)

    def _dimension(self, expression: Any) -> Dimension | None:
        owner = self._owner
        units: dict[Any, Dimension | None] = {s: dimension(field.unit) for s, field in owner.parameter_fields.items()}
        for q, u in zip(owner.declared.q, owner.declared.u, strict=True):
            of_q = units[q] = dimension(owner.coordinate_units[q])
            units[u] = None if of_q is None else (of_q[0], of_q[1], of_q[2] - 1)
        units[owner.t] = dimension("s")
        is_known = all(units.get(symbol) is not None for symbol in expression.free_symbols)
        return Dimensions(units).of(expression) if is_known else None

    def _checked(self, what: str, value: Any, unit: str, allowed: set[Any], kinds: str) -> Any:
        expression = as_expression(what, value).xreplace(self.translation)
        unknown = sorted(map(str, expression.free_symbols - allowed))
        if unknown:
            own = unknown[0] in {str(symbol) for symbol in allowed}
            cure = (
                "take the symbol that was returned, not one of the same name"
                if own
                else "declare it first, or check its place"
            )
            raise InvalidInput(f"{what} may read {kinds}; {unknown[0]} is none of them: {cure}")
        _require_real(what, expression)
        if unit:
            self.require_unit(what, expression, unit)
        return expression


def as_expression(what: str, value: Any) -> Any:
    """A SymPy expression, of a number too; a text is none."""
    try:
        if isinstance(value, str | bytes):
            raise TypeError
        expression = sp.sympify(value, strict=True)
        if not isinstance(expression, sp.Expr):
            raise TypeError
    except Exception:  # whatever an object raises that is asked what it is
        raise InvalidInput(f"{what} must be a number or an expression of SymPy; got {shown(value)}") from None
    return expression


def _require_real(what: str, expression: Any) -> None:
    if expression.has(sp.nan, sp.oo, -sp.oo, sp.zoo):
        raise InvalidInput(f"{what} must be finite; got {shortened(expression)}")
    if expression.has(sp.I) or expression.is_real is False:
        raise InvalidInput(f"{what} must be real; got {shortened(expression)}")
    for function in expression.atoms(sp.Function, sp.Derivative, sp.Integral):
        if not isinstance(function, FUNCTIONS):
            raise InvalidInput(
                f"{what} uses {shortened(function)}, which no compiled code is known for; the elementary functions are"
            )
