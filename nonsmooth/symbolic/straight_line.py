"""Straight-line programs: symbols bound to expressions, differentiated as they stand.

    s_k = f_k(s_m, ...),    D s_k = sum_m (df_k/ds_m) D s_m

D is a derivative along a direction: by one coordinate, or along the motion, D q = u, D t = 1. What a term shares with
another stays shared through every derivative, so that a chain of n links costs O(n) terms a derivative and not O(n^2).
Source: forward mode of Griewank and Walther, *Evaluating Derivatives* (2008), ch. 3.
"""

from __future__ import annotations

from typing import Any

import sympy as sp


class Direction:
    """The derivatives of the symbols that are not bound, and those found so far of the others."""

    def __init__(self, seeds: dict[Any, Any]) -> None:
        self.seeds = seeds
        self.found: dict[Any, Any] = {}


class StraightLine:
    """Bound symbols in the order in which they were met.

    Attributes
    ----------
    bound : dict
        Symbol -> expression in coordinates, velocities, parameters, time and bound symbols.
    """

    def __init__(self) -> None:
        self.bound: dict[Any, Any] = {}
        self._symbols: dict[Any, Any] = {}
        self._names = new_symbols()

    def let(self, expression: Any) -> Any:
        """The symbol of an expression; numbers and symbols stand for themselves, with their signs."""
        sign, rest = expression.as_coeff_Mul()
        if rest.is_Atom:
            return expression
        if sign == -1:
            return -self.let(rest)
        if expression not in self._symbols:
            self._bind(next(self._names), expression)
        return self._symbols[expression]

    def _bind(self, symbol: Any, expression: Any) -> None:
        self.bound[symbol] = expression
        self._symbols[expression] = symbol

    def shared(self, expressions: list[Any]) -> list[Any]:
        """The expressions with their common parts bound."""
        parts, reduced = sp.cse(expressions, symbols=self._names, order="none")
        for symbol, part in parts:
            self._bind(symbol, part)
        return reduced

    def derivative(self, expression: Any, direction: Direction) -> Any:
        """D of an expression, with every factor of the chain rule bound."""
        terms = []
        for symbol in sorted(expression.free_symbols, key=str):
            rate = self._rate(symbol, direction)
            if rate != 0:
                terms.append(self.let(slope(expression, symbol)) * rate)
        return sp.Add(*terms)

    def _rate(self, symbol: Any, direction: Direction) -> Any:
        if symbol not in self.bound:
            return direction.seeds.get(symbol, sp.S.Zero)
        if not isinstance(self.bound[symbol], sp.Expr):  # a condition of Piecewise, which only chooses
            return sp.S.Zero
        if symbol not in direction.found:
            direction.found[symbol] = self.let(self.derivative(self.bound[symbol], direction))
        return direction.found[symbol]

    def free_symbols(self, expression: Any) -> set[Any]:
        """What an expression depends on, through all that is bound."""
        seen, open_ = set(), list(expression.free_symbols)
        while open_:
            symbol = open_.pop()
            if symbol not in seen:
                seen.add(symbol)
                open_ += self.bound.get(symbol, sp.S.Zero).free_symbols
        return seen - self.bound.keys()

    def written_out(self, expression: Any) -> Any:
        """An expression with nothing bound."""
        while expression.free_symbols & self.bound.keys():
            expression = expression.xreplace(self.bound)
        return expression


def new_symbols() -> Any:
    """x0, x1, ... for bound parts; a dummy never is a coordinate of the same name."""
    return (sp.Dummy(f"x{k}", real=True) for k in iter(range(10**9)))


def slope(expression: Any, symbol: Any) -> Any:
    """df/ds on the branch that is taken: what has a kink has no jump there."""
    found = expression.diff(symbol)
    return found.replace(sp.DiracDelta, lambda *_: sp.S.Zero) if found.has(sp.DiracDelta) else found
