"""A straight-line program as the flat source of one model function.

Of what is bound only what the function needs is written, in order; what is common is computed once (sp.cse), what is
needed once stands where it is needed. Only the coordinates, rates and time that are read are unpacked, so a function
that is constant reads none, and is known to be.
"""

from __future__ import annotations

import re
import textwrap
from collections import Counter
from typing import Any

import sympy as sp
from sympy.printing.pycode import PythonCodePrinter

from nonsmooth.symbolic.straight_line import StraightLine, new_symbols

LONGEST_LINE = 116  # chosen: characters
LARGEST_PART = 12  # chosen: operations of what may stand where it is needed: longer lines read badly
LARGEST_POWER = 8  # chosen: up to which a power is a product, with the same bits compiled and interpreted
INDENT = "    "
NUMBER = re.compile(r"(?<!\w)\((\d+\.\d+)\)")
WHOLE = re.compile(r"^\(([^()]*)\)$")


class FlatPrinter(PythonCodePrinter):
    """Python of one expression: floats with all their digits, small powers as products, signs by comparison."""

    def __init__(self, names: dict[Any, str]) -> None:
        super().__init__({"fully_qualified_modules": True, "precision": 17})
        self.names = names

    def _print_Symbol(self, symbol: Any) -> str:
        return self.names[symbol]

    _print_Dummy = _print_Symbol

    def _print_Float(self, number: Any) -> str:
        return repr(float(number))

    def _print_Rational(self, number: Any) -> str:
        is_exact = number.q & (number.q - 1) == 0
        return repr(number.p / number.q) if is_exact else f"{number.p}.0/{number.q}.0"

    def _print_Pow(self, power: Any, **_: Any) -> str:
        base, exponent = power.as_base_exp()
        if exponent.is_Integer and 2 <= abs(exponent) <= LARGEST_POWER and base.is_Symbol:
            product = "*".join([self.names[base]] * abs(int(exponent)))
            return f"({product})" if exponent > 0 else f"(1.0/({product}))"
        if exponent == -1:
            return f"(1.0/({self._print(base)}))"
        return f"({super()._print_Pow(power)})"

    def _print_sign(self, sign: Any) -> str:
        x = self._print(sign.args[0])
        return f"(1.0 if {x} > 0.0 else -1.0 if {x} < 0.0 else 0.0)"

    def _print_Heaviside(self, step: Any) -> str:
        return f"(1.0 if {self._print(step.args[0])} > 0.0 else 0.0)"

    def _print_Abs(self, magnitude: Any) -> str:
        return f"abs({self._print(magnitude.args[0])})"


class FlatCode:
    """Writes functions over one straight-line program.

    Parameters
    ----------
    line : StraightLine
    names : dict
        Symbol -> (how it is read, such as ``p.m``, ``q[0]``, ``u[0]`` or ``t``, and its name in the function).
    """

    def __init__(self, line: StraightLine, names: dict[Any, tuple[str, str]]) -> None:
        self._line = line
        self._names = names

    def body(self, out: str, entries: list[tuple[tuple[int, ...], Any]]) -> list[str]:
        """The lines that write the entries that are not zero into an array; one zero where all are."""
        kept = [(index, value) for index, value in entries if value != 0] or entries[:1]
        parts, values = self.reduced([value for _, value in kept])
        targets = [f"{out}[{', '.join(map(str, index))}]" for index, _ in kept]
        return self._assignments(parts, list(zip(targets, values, strict=True)))

    def returned(self, expressions: list[Any]) -> tuple[list[str], list[str]]:
        """The lines before, and the expressions, of something that returns them."""
        parts, values = self.reduced(expressions)
        printer = self._printer(parts)
        return self._assignments(parts, [], values), [python_of(printer, value) for value in values]

    def reduced(self, values: list[Any]) -> tuple[dict[Any, Any], list[Any]]:
        """Definitions in order, and the values in terms of them."""
        needed, values = inlined(ordered(self._line.bound, values), values)
        symbols = new_symbols()
        fresh, reduced = sp.cse([*needed.values(), *values], symbols=symbols, order="none")
        count = len(needed)
        definitions = dict(fresh) | dict(zip(needed, reduced[:count], strict=True))
        definitions, values = with_bases_bound(definitions, reduced[count:], symbols)
        definitions = ordered(definitions, values)
        return inlined(definitions, values)

    def _assignments(self, parts: dict[Any, Any], targets: list[tuple[str, Any]], then: Any = ()) -> list[str]:
        printer = self._printer(parts)
        values = [*parts.values(), *(value for _, value in targets), *then]
        used = {symbol for value in values for symbol in sp.S(value).free_symbols}
        lines = [
            f"{name} = {source}" for symbol, (source, name) in self._names.items() if symbol in used and source != name
        ]
        lines += [f"{printer.names[symbol]} = {python_of(printer, part)}" for symbol, part in parts.items()]
        lines += [f"{target} = {python_of(printer, value)}" for target, value in targets]
        return [wrapped for line in lines for wrapped in broken(line)]

    def _printer(self, parts: dict[Any, Any]) -> FlatPrinter:
        names = {symbol: name for symbol, (_, name) in self._names.items()}
        taken = {*names.values()}
        free = (name for name in (f"x{k}" for k in iter(range(10**9))) if name not in taken)
        return FlatPrinter(names | {symbol: next(free) for symbol in parts})


def python_of(printer: FlatPrinter, value: Any) -> str:
    """An expression as Python, whole numbers as floats, without brackets around a number or around the whole."""
    value = sp.S(value)
    text = repr(float(value)) if value.is_Integer else printer.doprint(value)
    return WHOLE.sub(r"\1", NUMBER.sub(r"\1", text))


def ordered(definitions: dict[Any, Any], values: list[Any]) -> dict[Any, Any]:
    """The definitions that the values need, each after those that it needs."""
    found: dict[Any, Any] = {}
    stack = [(symbol, False) for value in reversed(values) for symbol in by_name(sp.S(value))]
    while stack:
        symbol, is_ready = stack.pop()
        if symbol in found or symbol not in definitions:
            continue
        if is_ready:
            found[symbol] = definitions[symbol]
        else:
            stack.append((symbol, True))
            stack += [(part, False) for part in by_name(definitions[symbol])]
    return found


def by_name(expression: Any) -> list[Any]:
    """The symbols of an expression, last first, in an order that no hash decides."""
    return sorted(
        expression.free_symbols, key=lambda symbol: (str(symbol), getattr(symbol, "dummy_index", 0)), reverse=True
    )


def with_bases_bound(definitions: dict[Any, Any], values: list[Any], symbols: Any) -> tuple[dict[Any, Any], list[Any]]:
    """The same where a small power is one of a symbol."""
    bases: dict[Any, Any] = {}

    def of_symbol(power: Any) -> Any:
        """A power of a sum as one of the symbol that is bound to it."""
        base = bases.get(power.base) or bases.setdefault(power.base, next(symbols))
        return base**power.exp

    def is_small(e: Any) -> bool:
        """Whether a power is to be a product, and its base is no symbol."""
        return e.is_Pow and e.exp.is_Integer and 2 <= abs(e.exp) <= LARGEST_POWER and not e.base.is_Symbol

    changed = {symbol: part.replace(is_small, of_symbol) for symbol, part in definitions.items()}
    values = [sp.S(value).replace(is_small, of_symbol) for value in values]
    return changed | {symbol: base for base, symbol in bases.items()}, values


def inlined(definitions: dict[Any, Any], values: list[Any]) -> tuple[dict[Any, Any], list[Any]]:
    """Definitions without those that are needed once and are short, or are names of names."""
    uses: Counter[Any] = Counter()
    for expression in [*definitions.values(), *values]:
        for atom in sp.preorder_traversal(sp.S(expression)):
            if atom in definitions:
                uses[atom] += 1
    bases = {power.base for e in [*definitions.values(), *values] for power in sp.S(e).atoms(sp.Pow)}
    kept: dict[Any, Any] = {}
    put: dict[Any, Any] = {}
    for symbol, part in definitions.items():
        part = part.xreplace(put)
        is_short = uses[symbol] == 1 and symbol not in bases and part.count_ops() <= LARGEST_PART
        (put if is_short or part.is_Atom else kept)[symbol] = part
    return kept, [sp.S(value).xreplace(put) for value in values]


def broken(line: str) -> list[str]:
    """A long assignment on several lines, in brackets."""
    if len(line) <= LONGEST_LINE:
        return [line]
    target, _, value = line.partition(" = ")
    rows = textwrap.wrap(value, LONGEST_LINE - 2 * len(INDENT), break_long_words=False, break_on_hyphens=False)
    return [f"{target} = (", *(INDENT + row for row in rows), ")"]
