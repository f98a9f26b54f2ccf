"""A model function rewritten for dual numbers: its source, with the operations that know real numbers only replaced.

    x / y  ->  quotient(x, y)        x**y  ->  power(x, y)        math.sin(x)  ->  sin(x)
    x < y  ->  real(x) < real(y)     min(x, y, z)  ->  least(least(x, y), z)

and every Python function that it calls likewise. What is made is a plain Python function again, which runs and
compiles. Where the source is not at hand (a function typed into a shell, a lambda, one made by exec), or calls
something that is not known here, the function is not continued: a rewriting that guesses would be wrong without a word.
"""

from __future__ import annotations
import __future__

import ast
import builtins
import functools
import inspect
import operator
import textwrap
import types
from collections.abc import Callable, Iterator
from typing import Any

from nonsmooth.numerics import dual

KEPT = (range, len, enumerate, zip)  # as they are: they count
OPERATORS: dict[type, Callable] = {ast.Div: dual.dual_quotient, ast.Pow: dual.dual_power}
REFUSED = (ast.FloorDiv, ast.Mod, ast.MatMult)  # of operators: piecewise, or of arrays
# derived: the bits of a code that say under which ``from __future__`` it was compiled
FUTURE_FLAGS = functools.reduce(
    operator.or_, (getattr(__future__, name).compiler_flag for name in __future__.all_feature_names)
)
COMPARED = (ast.Lt, ast.LtE, ast.Gt, ast.GtE, ast.Eq, ast.NotEq)


class CannotContinue(Exception):
    """A function cannot be rewritten; ``str`` says why."""


def continued(function: Callable) -> Callable:
    """The function for dual numbers, of the same arguments.

    Raises
    ------
    CannotContinue
        Where that cannot be done with certainty.
    """
    function = getattr(function, "py_func", function)
    if not isinstance(function, types.FunctionType):
        raise CannotContinue(f"{function!r} is no Python function")
    tree = source_tree(function)
    scope: dict[str, Any] = {stand_in.__name__: stand_in for stand_in in _stand_ins()}
    tree.name = f"dual_of_{function.__name__}"
    rewritten = Rewriting(function, scope).visit(tree)
    made = compiled(rewritten, function, scope | _read_by(function))
    made.__module__ = function.__module__
    return made


def _stand_ins() -> set[Callable]:
    return {*dual.STANDS_IN.values(), *OPERATORS.values(), dual.dual_real}


def _read_by(function: types.FunctionType) -> dict[str, Any]:
    """The globals that a function reads, by name."""
    names = function.__code__.co_names
    return {name: function.__globals__[name] for name in names if name in function.__globals__}


def source_tree(function: types.FunctionType) -> ast.FunctionDef:
    """The syntax tree of a function, from a source that is its own."""
    try:
        lines, _ = inspect.findsource(function)
        tree = ast.parse(textwrap.dedent(inspect.getsource(function))).body[0]
        flags = function.__code__.co_flags & FUTURE_FLAGS  # of whoever compiled it, as SymPy does
        is_own = function.__code__ in codes_of(compile("".join(lines), "", "exec", flags, dont_inherit=True))
    except (OSError, TypeError, SyntaxError) as error:
        raise CannotContinue(f"the source of {function.__name__} is not at hand: {error}") from None
    if not isinstance(tree, ast.FunctionDef):
        raise CannotContinue(f"{function.__name__} is not written with def")
    if not is_own:
        raise CannotContinue(f"the source of {function.__name__} has changed since it was read")
    tree.decorator_list, tree.returns, tree.args.defaults = [], None, []
    for argument in tree.args.args:
        argument.annotation = None
    return tree


def codes_of(code: types.CodeType) -> Iterator[types.CodeType]:
    """A code object and all within it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield from codes_of(constant)


def compiled(tree: ast.FunctionDef, function: types.FunctionType, scope: dict[str, Any]) -> types.FunctionType:
    """The function of a tree, with the closure and the defaults of another."""
    outer = ast.parse(f"def outer({', '.join(function.__code__.co_freevars)}): pass").body[0]
    assert isinstance(outer, ast.FunctionDef)
    outer.body = [tree, ast.Return(ast.Name(tree.name, ast.Load()))]
    module = ast.fix_missing_locations(ast.Module([outer], []))
    whole = compile(module, f"<{function.__name__} for dual numbers>", "exec")
    _, _, code, *_ = codes_of(whole)  # the module, outer, the function
    cells = dict(zip(function.__code__.co_freevars, function.__closure__ or (), strict=True))
    scope = {"__builtins__": builtins, "__name__": __name__} | scope
    closure = tuple(cells[name] for name in code.co_freevars)
    return types.FunctionType(code, scope, tree.name, function.__defaults__, closure or None)


class Rewriting(ast.NodeTransformer):
    """The rewriting of one function; functions that it calls are put into ``scope``."""

    def __init__(self, function: types.FunctionType, scope: dict[str, Any]) -> None:
        self.function, self.scope = function, scope
        code = function.__code__
        self.local = {*code.co_varnames, *code.co_cellvars}
        self.closed = {
            name: cell.cell_contents
            for name, cell in zip(code.co_freevars, function.__closure__ or (), strict=True)
        }  # fmt: skip

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        """Quotients and powers."""
        self.generic_visit(node)
        if isinstance(node.op, REFUSED):
            raise CannotContinue(f"{self.function.__name__} uses //, % or @")
        stand_in = OPERATORS.get(type(node.op))
        return node if stand_in is None else _call(stand_in.__name__, node.left, node.right)

    def visit_AugAssign(self, node: ast.AugAssign) -> ast.AST:
        """``x /= y`` is ``x = x / y``."""
        if type(node.op) not in OPERATORS and not isinstance(node.op, REFUSED):
            return self.generic_visit(node)
        value = ast.parse(ast.unparse(node.target), mode="eval").body
        return self.visit(ast.Assign([node.target], ast.BinOp(value, node.op, node.value)))

    def visit_Raise(self, node: ast.Raise) -> ast.AST:
        """As it is: whoever raises differentiates nothing."""
        return node

    def visit_Compare(self, node: ast.Compare) -> ast.AST:
        """Real parts decide."""
        self.generic_visit(node)
        if all(isinstance(operator, COMPARED) for operator in node.ops):
            node.left = _call("dual_real", node.left)
            node.comparators = [_call("dual_real", part) for part in node.comparators]
        return node

    def visit_Call(self, node: ast.Call) -> ast.AST:
        """What is called must be known."""
        called = self.object_of(node.func)
        stand_in = dual.STANDS_IN.get(called) if _is_hashable(called) else None
        given = node.args
        if stand_in is None and any(called is kept for kept in KEPT):
            return self.generic_visit(node)
        if node.keywords or any(isinstance(argument, ast.Starred) for argument in given):
            raise CannotContinue(f"{self.function.__name__} calls {ast.unparse(node.func)} with more than plain values")
        if stand_in is None:
            name = f"dual_{called.__name__}_{len(self.scope)}" if hasattr(called, "__name__") else ""
            self.scope[name] = continued(called)
            self.generic_visit(node)
            return ast.Call(ast.Name(name, ast.Load()), node.args, [])
        node.args = [self.visit(argument) for argument in given]
        n = stand_in.__code__.co_argcount
        if len(given) != n and not (stand_in in dual.TWO_OR_MORE and len(given) > n):
            raise CannotContinue(f"{self.function.__name__} calls {ast.unparse(node.func)} with {len(given)} values")
        name = stand_in.__name__
        if n == 1:
            return _call(name, *node.args)
        return functools.reduce(lambda x, y: _call(name, x, y), node.args)  # type: ignore[arg-type,return-value]

    def object_of(self, node: ast.expr) -> Any:
        """The object that is called."""
        if isinstance(node, ast.Name) and node.id not in self.local:
            scopes = (self.closed, self.function.__globals__, vars(builtins))
            found = [scope[node.id] for scope in scopes if node.id in scope]
            if found:
                return found[0]
        if isinstance(node, ast.Attribute):
            module = self.object_of(node.value)
            if isinstance(module, types.ModuleType) and hasattr(module, node.attr):
                return getattr(module, node.attr)
        raise CannotContinue(f"{self.function.__name__} calls {ast.unparse(node)}, which is not known here")


def _is_hashable(value: Any) -> bool:
    try:
        hash(value)
    except TypeError:
        return False
    return True


def _call(name: str, *arguments: ast.expr) -> ast.Call:
    """A call with ``x - 0.0`` for x, the same bits: the imaginary part of a literal 2 is 2 in numba."""
    nothing = ast.Constant(0.0)
    return ast.Call(ast.Name(name, ast.Load()), [ast.BinOp(x, ast.Sub(), nothing) for x in arguments], [])
