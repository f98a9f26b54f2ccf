"""Numbers of a file that are written as formulas: ``"0.1 + 0.2 * k"``.

A formula has numbers, names, + - * / // % **, and functions of one or two numbers; nothing else is carried out.
"""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Mapping
from typing import Any

from nonsmooth.errors import InvalidInput, nearest, shown

OPERATORS: dict[type[ast.AST], Callable[..., Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv, ast.Mod: operator.mod, ast.Pow: math.pow, ast.USub: operator.neg,
    ast.UAdd: operator.pos,
}  # fmt: skip
FUNCTIONS = {
    name: getattr(math, name)
    for name in (
        "sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "hypot", "radians", "degrees",
        "floor",
    )
} | {"abs": abs, "min": min, "max": max}  # fmt: skip
CONSTANTS = {"pi": math.pi}


def value_of(formula: str, names: Mapping[str, float]) -> float:
    """The number that a formula is, with numbers by name.

    Raises
    ------
    InvalidInput
        For what is no formula, a name that is not known, and what has no value.
    """
    try:
        tree = ast.parse(formula.strip(), mode="eval").body
    except (SyntaxError, ValueError, MemoryError, RecursionError) as error:
        raise InvalidInput(f"{shown(formula)} is no formula") from error
    try:
        return _value(tree, formula, {**CONSTANTS, **names})  # type: ignore[no-any-return]
    except InvalidInput:
        raise
    except (ArithmeticError, RecursionError, ValueError, TypeError) as error:
        raise InvalidInput(f"{shown(formula)} has no value: {error}") from error


def _value(node: ast.AST, formula: str, names: Mapping[str, float]) -> Any:
    match node:
        case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
            return number
        case ast.Name(id=name) if name in names:
            return names[name]
        case ast.Name(id=name):
            raise InvalidInput(f"{shown(formula)} has the name {name}, which is not known; {nearest(name, [*names])}")
        case ast.UnaryOp(op=act, operand=one) if type(act) in OPERATORS:
            return OPERATORS[type(act)](_value(one, formula, names))
        case ast.BinOp(left=left, op=act, right=right) if type(act) in OPERATORS:
            return OPERATORS[type(act)](_value(left, formula, names), _value(right, formula, names))
        case ast.Call(func=ast.Name(id=name), args=given, keywords=[]) if name in FUNCTIONS:
            return FUNCTIONS[name](*(_value(one, formula, names) for one in given))
    raise InvalidInput(
        f"{shown(formula)} has more than numbers, names, + - * / // % ** and the functions {', '.join(FUNCTIONS)}"
    )
