"""What an expression reads and does not depend on: found by numbers, removed by algebra.

    m (a sin th)^2 + m (a cos th)^2 = m a^2,    x sin th cos th th'^2 - x cos th sin th th'^2 = 0

A constant mass matrix must not read q, nor a force u that its terms cancel: then it is known to be constant. Whether an
entry varies is seen at random states, to rounding; only where it does not, it is expanded, with 1 - cos^2 for sin^2,
and the result is taken where it reads less. Nothing is believed: an entry that algebra does not free keeps its form.
"""

from __future__ import annotations

import math
import random
from typing import Any

import sympy as sp

from nonsmooth.symbolic.straight_line import StraightLine

SAMPLED_STATES = 3  # chosen: random states: an expression that varies would have to be stationary at all of them
SAME_VALUE = 1e-11  # chosen: of the largest value that occurs on the way: 1e5 roundings
# measured: operations, written out, of what is expanded: beyond them the algebra takes longer than a second
MOST_OPERATIONS = 400


class Apparent:
    """The samples of one program.

    Parameters
    ----------
    line : StraightLine
    groups : sequence of set
        Symbols that are asked for together: coordinates, velocities, time.
    """

    def __init__(self, line: StraightLine, groups: list[set[Any]]) -> None:
        self._line, self._groups = line, groups
        rng = random.Random(1)
        self._samples = [_Sample(line, rng) for _ in range(SAMPLED_STATES)]

    def freed(self, expressions: list[Any]) -> list[Any]:
        """The expressions of one function, freed of groups that none depends on, and of all where one is constant."""
        states: set[Any] = set().union(*self._groups)
        spurious = [group for group in self._groups if self._only_seem(expressions, group)]
        return [self._freed(e, [g for g in (states, *spurious) if self._only_seem([e], g)]) for e in expressions]

    def _only_seem(self, expressions: list[Any], group: set[Any]) -> bool:
        """Whether some of them read the group, and none varies with it."""
        reading = [e for e in expressions if self._line.free_symbols(e) & group]
        return bool(reading) and not any(sample.varies(e, group) for e in reading for sample in self._samples)

    def _freed(self, expression: Any, groups: list[set[Any]]) -> Any:
        if not groups:
            return expression
        plain = self._line.written_out(expression)
        if plain.count_ops() > MOST_OPERATIONS:
            return expression
        plain = without_squares(plain)
        reads = plain.free_symbols
        return plain if not any(reads & group for group in groups) else expression


class _Sample:
    """One random state, and each symbol of the program changed there."""

    def __init__(self, line: StraightLine, rng: random.Random) -> None:
        self._line, self._rng = line, rng
        self._base: dict[Any, float] = {}
        self._known: dict[Any, float] = {}
        self._moved: dict[frozenset[Any], dict[Any, float]] = {}

    def varies(self, expression: Any, group: set[Any]) -> bool:
        """Whether a change of the group changes the value; also where that cannot be computed."""
        key = frozenset(group)
        moved = self._moved.setdefault(key, {})
        try:
            one = self._value(expression, self._known, frozenset())
            other = self._value(expression, moved, key)
        except (ArithmeticError, ValueError, TypeError, AttributeError):
            return True
        size = max(self._size(expression, self._known), abs(one), abs(other))
        return not abs(one - other) <= SAME_VALUE * size

    def _value(self, expression: Any, known: dict[Any, float], moved: frozenset[Any]) -> float:
        for symbol in sorted(expression.free_symbols, key=str):
            if symbol not in known:
                bound = self._line.bound.get(symbol)
                known[symbol] = self._seed(symbol, moved) if bound is None else self._value(bound, known, moved)
        return number(expression, known)

    def _seed(self, symbol: Any, moved: frozenset[Any]) -> float:
        base = self._base.setdefault(symbol, self._rng.uniform(0.3, 0.9))
        return (
            base + 0.37 * (0.5 + self._base.setdefault(("moved", symbol), self._rng.random()))
            if symbol in moved
            else base
        )

    def _size(self, expression: Any, known: dict[Any, float]) -> float:
        return max((abs(known.get(symbol, 0.0)) for symbol in expression.free_symbols), default=0.0)


def number(expression: Any, values: dict[Any, float]) -> float:
    """An expression as a float."""
    if expression.is_Symbol:
        return values[expression]
    if expression.is_Number or expression.is_NumberSymbol:
        return float(expression)
    parts = [number(part, values) for part in expression.args]
    if expression.is_Add:
        return math.fsum(parts)
    if expression.is_Mul:
        return math.prod(parts)
    if expression.is_Pow:
        return parts[0] ** parts[1]
    return float(getattr(math, type(expression).__name__)(*parts))  # what has a kink is not there, and is said to vary


def without_squares(expression: Any) -> Any:
    """Expanded, with 1 - cos^2 for sin^2."""

    def is_high(e: Any) -> bool:
        """A power of a sine, of 2 or more."""
        return e.is_Pow and isinstance(e.base, sp.sin) and e.exp.is_Integer and e.exp >= 2

    def lowered(e: Any) -> Any:
        """The even part of it by the cosine."""
        return (1 - sp.cos(e.base.args[0]) ** 2) ** (e.exp // 2) * e.base ** (e.exp % 2)

    return sp.factor_terms(sp.expand(sp.expand(expression).replace(is_high, lowered)))
