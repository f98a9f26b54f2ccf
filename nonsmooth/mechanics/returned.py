"""Model functions that return their values, as ``sympy.lambdify`` makes them, in the form that writes them.

    def mass(t, q, p):                       def mass(t, q, p, out):
        return [[p.m, 0], [0, p.J]]    ->        out[0, 0] = p.m; out[0, 1] = 0; out[1, 0] = 0; out[1, 1] = p.J; return

Where a source is at hand and every return is a list, a tuple or an array of entries, the source is rewritten so: the
machine code is that of a function that writes. What else is returned is copied, ``out[...] = function(t, q, p)``, its
size compared each time. Shapes agree where they do without their axes of length 1: SymPy's vectors are columns.
"""

from __future__ import annotations

import ast
import functools
import hashlib
import linecache
import types
from collections.abc import Callable
from typing import Any

import numpy as np

from nonsmooth.numerics.continuation import CannotContinue, codes_of, source_tree

NAMELESS = {"<lambda>", "_lambdifygenerated"}  # defined: by Python and SymPy


def writing(name: str, function: Callable, takes_u: bool, shape: tuple[int, ...]) -> Callable:
    """The form that writes of a function that returns its values, the model's ``name`` for messages where its own says
    nothing; its attribute ``returned_from`` is the function."""
    return _writing(name, function, getattr(function, "__code__", None), takes_u, shape)


@functools.lru_cache(maxsize=512)
def _writing(
    name: str, function: Any, code: types.CodeType | None, takes_u: bool, shape: tuple[int, ...]
) -> types.FunctionType:
    made = _by_source(function, shape) or _by_copy(function, takes_u)
    vars(made)["returned_from"] = function
    if made.__name__ in NAMELESS:
        made.__name__ = name
    return made


# The form by copying


def copied(t, q, p, out):
    store(function(t, q, p), out)


def copied_with_u(t, q, u, p, out):
    store(function(t, q, u, p), out)


def function(*arguments):
    """The function that returns; another one is bound under this name."""


def store(values, out):
    found, written = np.asarray(values).ravel(), out.reshape(out.size)
    if found.size != written.size:
        raise ValueError("the number of values that are returned")
    for k in range(written.size):
        written[k] = found[k]


def _by_copy(function: Callable, takes_u: bool) -> types.FunctionType:
    code = (copied_with_u if takes_u else copied).__code__
    name = getattr(function, "__name__", "function")
    made = types.FunctionType(code, {"function": function, "store": store}, name)
    made.__module__ = __name__
    return made


# The form by its source


def _by_source(function: Any, shape: tuple[int, ...]) -> types.FunctionType | None:
    """The function rewritten, with the globals and the closure of the original, or None where that cannot be done."""
    if not isinstance(function, types.FunctionType) or function.__kwdefaults__:
        return None
    try:
        tree = source_tree(function)
    except CannotContinue:
        return None
    used = {*function.__code__.co_varnames, *function.__code__.co_names, *function.__code__.co_freevars}
    out = next(name for name in ("out", "out_", "out__", f"out_of_{function.__name__}") if name not in used)
    tree.args.args.append(ast.arg(out))
    rewriting = Returns(function, out, shape)
    tree = rewriting.visit(tree)
    return _compiled(tree, function) if rewriting.is_done else None


class Returns(ast.NodeTransformer):
    """``return [[a, b], [c, d]]`` as writing of the entries; ``is_done`` is False where something else is returned."""

    def __init__(self, function: types.FunctionType, out: str, shape: tuple[int, ...]) -> None:
        self.function, self.out, self.shape = function, out, shape
        self.is_done = True
        self._depth = 0

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        """Functions within the function return what they return."""
        self._depth += 1
        if self._depth == 1:
            node.body = [line for part in node.body for line in _lines(self.visit(part))]
        self._depth -= 1
        return node

    def visit_Lambda(self, node: ast.Lambda) -> ast.AST:
        """As it is."""
        return node

    def visit_Return(self, node: ast.Return) -> list[ast.stmt] | ast.stmt:
        """Its entries, one by one."""
        entries = entries_of(node.value, self.function) if node.value is not None else None
        if entries is None or without_ones(entries.shape) != without_ones(self.shape):
            self.is_done = False
            return node
        places = np.ndindex(self.shape)
        writes = [
            ast.parse(f"{self.out}[{', '.join(map(str, place))}] = 0").body[0]
            for place, _ in zip(places, entries.flat, strict=True)
        ]
        for write, entry in zip(writes, entries.flat, strict=True):
            assert isinstance(write, ast.Assign)
            write.value = entry
        return [*writes, ast.Return(None)]


def _lines(visited: Any) -> list[Any]:
    return visited if isinstance(visited, list) else [visited]


def entries_of(node: ast.expr | None, function: types.FunctionType) -> np.ndarray | None:
    """The expressions in a list, a tuple or an array that is written out, in their shape; None for anything else."""
    if isinstance(node, ast.Call):
        is_array = len(node.args) == 1 and not node.keywords and _is_array_of(node.func, function)
        return entries_of(node.args[0], function) if is_array else None
    if not isinstance(node, ast.List | ast.Tuple) or any(isinstance(part, ast.Starred) for part in node.elts):
        return None
    parts = [entries_of(part, function) for part in node.elts]
    if all(part is None for part in parts):
        entries = np.empty(len(parts), object)
        entries[:] = node.elts
        return entries
    if any(part is None or part.shape != parts[0].shape for part in parts):  # type: ignore[union-attr]
        return None
    return np.stack(parts)  # type: ignore[arg-type]


def _is_array_of(node: ast.expr, function: types.FunctionType) -> bool:
    """Whether ``array(...)`` or ``np.array(...)`` is NumPy's."""
    if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
        found: Any = getattr(function.__globals__.get(node.value.id), node.attr, None)
    else:
        found = function.__globals__.get(node.id) if isinstance(node, ast.Name) else None
    return found is np.array or found is np.asarray


def without_ones(shape: tuple[int, ...]) -> tuple[int, ...]:
    """A shape without its axes of length 1."""
    return tuple(length for length in shape if length != 1)


def _compiled(tree: ast.FunctionDef, function: types.FunctionType) -> types.FunctionType:
    """The function of a tree; its source is kept for those who read it, as derivatives of the gap do."""
    free = function.__code__.co_freevars
    outer = ast.parse(f"def outer({', '.join(free)}): pass").body[0]
    assert isinstance(outer, ast.FunctionDef)
    outer.body = [tree]
    text = ast.unparse(ast.fix_missing_locations(ast.Module([outer], []))) + "\n"
    file = f"<{function.__name__} that writes {hashlib.sha256(text.encode()).hexdigest()[:16]}>"
    linecache.cache[file] = len(text), None, text.splitlines(keepends=True), file
    _, _, code, *_ = codes_of(compile(text, file, "exec", dont_inherit=True))  # the module, outer, the function
    cells = dict(zip(free, function.__closure__ or (), strict=True))
    made = types.FunctionType(
        code, function.__globals__, function.__name__, function.__defaults__,
        tuple(cells[name] for name in code.co_freevars) or None,
    )  # fmt: skip
    made.__module__ = function.__module__
    return made


def shape_fault(values: Any, shape: tuple[int, ...]) -> str:
    """What is wrong with returned values, the rest of a sentence that begins with the function's name; or empty."""
    if values is None:
        return f"returns nothing; it must return an array of shape {shape}, or take a last argument and write into it"
    try:
        found = np.shape(values)
    except ValueError:
        return f"returns lists of different lengths; it must return an array of shape {shape}"
    if without_ones(found) != without_ones(shape):
        return f"returns an array of shape {found}; it must have the shape {shape}"
    return ""
