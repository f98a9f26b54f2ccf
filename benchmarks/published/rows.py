"""A row of the page: what is printed, what comes out here, and who errs where they differ.

A row agrees if it is within half a unit of the last printed digit, unless the source states another error. Where the
source errs, ``corrected`` is what it should say: the row then has to meet that, and to miss what is printed.
"""

from __future__ import annotations

import ast
import functools
import inspect
import sys
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from types import CodeType
from typing import Any, NamedTuple

Printed = str | Callable[[], float]  # digits as they are printed, or the formula as it is printed
FORMULA = 1e-6  # chosen: of the value of a formula, of which no digits are printed


@dataclass(frozen=True)
class Row:
    """One printed result.

    Attributes
    ----------
    what : str
        The quantity with its unit, and its place in the source.
    printed : str or callable
    ours : callable
        Computes it: a lambda, whose body is the program that the page shows.
    corrected : str or callable
        What the source should say where it errs, from another route than ``ours``.
    errs : str
        Who errs, and why.
    within : float, optional
        Error that the source states, or that follows from it, in the place of half a unit of the last digit.
    why : str
        Of ``within``.
    is_slow : bool
        Whether it takes longer than 0.2 s: it is left out of the quick tests.
    """

    what: str
    printed: Printed
    ours: Callable[..., Any]
    corrected: Printed = ""
    errs: str = ""
    within: float | None = None
    why: str = ""
    is_slow: bool = False


@dataclass(frozen=True)
class Section:
    """Rows of one source.

    Attributes
    ----------
    name : str
        By which the command is told of it.
    title : str
    source : str
        Where it is printed, with what else is to be known.
    rows : tuple of Row
    functions : tuple of callable
        What the programs of the rows call.
    table : str
        Letter of the corrected table that holds the printed numbers; empty where others print them.
    picture : str
        Of the section, in Markdown.
    """

    name: str
    title: str
    source: str
    rows: tuple[Row, ...]
    functions: tuple[Callable[..., Any], ...] = ()
    table: str = ""
    picture: str = ""


class Found(NamedTuple):
    """A row with its number."""

    row: Row
    ours: float

    @property
    def difference(self) -> float:
        """Ours less what is printed."""
        return self.ours - value_of(self.row.printed)

    @property
    def is_as_said(self) -> bool:
        """Whether it agrees or, where the source errs, misses the print and meets the correction."""
        as_printed = abs(self.difference) <= tolerance(self.row.printed, self.row.within)
        if not self.row.errs:
            return as_printed
        met = abs(self.ours - value_of(self.row.corrected)) <= tolerance(self.row.corrected, None)
        return met and not as_printed

    @property
    def verdict(self) -> str:
        """Of the page."""
        if not self.is_as_said:
            return "**DIFFERS**"
        if self.row.errs:
            return f"the source errs: {shown(self.row.corrected, of='')} is right"
        if self.row.within is not None:
            return f"agrees within {self.row.within:g}: {self.row.why}"
        return "agrees to the printed digits"


def computed(row: Row) -> Found:
    """The row with its number of today."""
    return Found(row, float(row.ours()))


def value_of(printed: Printed) -> float:
    """Of printed digits ("1.2e-3", "-80/7") or of a formula."""
    return float(Fraction(printed)) if isinstance(printed, str) else float(printed())


def tolerance(printed: Printed, within: float | None) -> float:
    """Half a unit of the last printed digit, with the rounding of the comparison."""
    if within is not None:
        return within
    if not isinstance(printed, str):
        return FORMULA * abs(printed())
    return (0.5 + 1e-9) * 10.0 ** last_place(printed)


def last_place(printed: str) -> int:
    """Power of ten of the last printed digit."""
    digits, _, exponent = printed.partition("e")
    return int(exponent or 0) - len(digits.partition(".")[2])


def shown(printed: Printed, of: str = " (formula)") -> str:
    """As it stands on the page."""
    return printed if isinstance(printed, str) else f"{printed():.9g}{of}"


def shown_as(ours: float, printed: Printed) -> str:
    """Our number with two digits more than are printed."""
    if not isinstance(printed, str) or "/" in printed:
        return f"{ours:.12g}"
    return f"{ours:.{max(0, 2 - last_place(printed))}f}" if "e" not in printed else f"{ours:.{len(printed)}g}"


# ---------------------------------------------------------------------------------------------------------------
# The program of a row: the body of its lambda, with the values of its defaults in the place of their names


def program(function: Callable[..., Any]) -> str:
    """What a lambda computes, as one can type it."""
    body = body_of(function)
    names = inspect.signature(function).parameters
    values = {name: value.default for name, value in names.items()}

    class Values(ast.NodeTransformer):
        def visit_Name(self, node: ast.Name) -> ast.expr:
            return ast.parse(repr(values[node.id]), mode="eval").body if node.id in values else node

    return ast.unparse(Values().visit(ast.parse(ast.unparse(body), mode="eval").body))


def body_of(function: Callable[..., Any]) -> ast.expr:
    """Of a lambda, from its file: the smallest that holds all places of its code."""
    code = function.__code__
    found = [node.body for node in lambdas(function.__module__) if holds(node.body, code)]
    return min(found, key=lambda node: len(ast.unparse(node)))


@functools.cache
def lambdas(module: str) -> list[ast.Lambda]:
    """All of a module."""
    tree = ast.parse(inspect.getsource(sys.modules[module]))
    return [node for node in ast.walk(tree) if isinstance(node, ast.Lambda)]


def holds(node: ast.expr, code: CodeType) -> bool:
    """Whether an expression holds all places of a code, but that of its beginning."""
    places = [(line, column) for line, _, column, _ in list(code.co_positions())[1:] if line and column is not None]
    first, last = (node.lineno, node.col_offset), (node.end_lineno or 0, node.end_col_offset or 0)
    return all(first <= place < last for place in places if place != (code.co_firstlineno, 0))
