"""A friction law of the user's as source: the file that is written of a model stands by itself.

What a law reads besides its arguments are ``math`` and what Python has by itself; a coefficient is a parameter, p.mu.
"""

from __future__ import annotations

import ast
import builtins
import inspect
import math
from typing import Any

from nonsmooth.errors import InvalidInput, shown
from nonsmooth.mechanics.laws import Friction


def source_of_law(law: Friction, name: str) -> str:
    """The function mu(v, p) of a law, called ``name``."""
    function: Any = getattr(law.function, "py_func", law.function)
    _require_self_contained(function, law)
    node = _node_of(function)
    if node is None:
        raise InvalidInput(
            f"the source of the friction law {law!r} cannot be read; write it on a line of its own, in a file or a cell"
        )
    if isinstance(node, ast.Lambda):
        body: list[ast.stmt] = [ast.Return(node.body)]
    else:
        body = node.body
    made = ast.parse(f"def {name}(): pass").body[0]
    assert isinstance(made, ast.FunctionDef)
    made.args, made.body = node.args, body
    for argument in made.args.args:
        argument.annotation = None
    return ast.unparse(ast.fix_missing_locations(made))


def _require_self_contained(function: Any, law: Friction) -> None:
    try:
        found = inspect.getclosurevars(function)
    except TypeError:
        raise InvalidInput(f"the friction law {law!r} must be a plain function; got {shown(law.function)}") from None
    read = {**found.nonlocals, **found.globals}
    known = {name for name, value in read.items() if value is math and name == "math"} | set(vars(builtins))
    attributes = set(function.__code__.co_names) - read.keys()  # as mu of p.mu: no name of their own
    foreign = sorted(set(read) - known) + sorted(found.unbound - attributes)
    if foreign:
        raise InvalidInput(
            f"the friction law {law!r} reads {foreign[0]}, which the source of the model has not; make it a parameter "
            f"of the model, p.{foreign[0]}, or write its value"
        )


def _node_of(function: Any) -> ast.FunctionDef | ast.Lambda | None:
    """The definition of a function in its file or cell, or nothing where it cannot be told."""
    try:
        tree = ast.parse("".join(inspect.findsource(function)[0]))
    except (OSError, TypeError, SyntaxError):
        return None
    kind = ast.Lambda if function.__name__ == "<lambda>" else ast.FunctionDef
    found = [
        node
        for node in ast.walk(tree)
        if isinstance(node, kind) and _first_line(node) == function.__code__.co_firstlineno
    ]
    return found[0] if len(found) == 1 else None


def _first_line(node: ast.FunctionDef | ast.Lambda) -> int:
    decorators = node.decorator_list if isinstance(node, ast.FunctionDef) else []
    return min([node.lineno, *(decorator.lineno for decorator in decorators)])
