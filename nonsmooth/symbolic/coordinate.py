"""The symbol of a coordinate, which unpacks as a sequence of one.

th = l.coordinates("th")    and    th, = l.coordinates("th")    name the same
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import sympy as sp
from sympy.utilities.iterables import NotIterable


class Symbol(sp.Symbol, NotIterable):
    """It has the name of SymPy's class, by which symbols are sorted in expressions, and hashed."""

    __slots__ = ()

    def __iter__(self) -> Iterator[Any]:
        yield self

    def __eq__(self, other: object) -> bool:
        return isinstance(other, sp.Symbol) and self._hashable_content() == other._hashable_content()

    __hash__ = sp.Symbol.__hash__
