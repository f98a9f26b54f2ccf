"""The source of a model: a file as those of `models`, with its equations on top.

Functions first, flat and in the names of the declaration; then one frozen dataclass with the parameters, ``system()``,
``state(...)`` and the picture.
"""

from __future__ import annotations

import re
import textwrap
from typing import Any

import sympy as sp

import nonsmooth
from nonsmooth.mechanics import laws
from nonsmooth.symbolic.equations import Equations
from nonsmooth.symbolic.flat_code import FlatCode
from nonsmooth.symbolic.units import shortened

SOURCE_WIDTH = 118  # chosen: characters of a line
OUT = {  # function: (arguments, its array, what it writes, unit)
    "mass": ("t, q, p", "M", "M", ""),
    "force": ("t, q, u, p", "h", "h, all smooth forces", ""),
    "stiffness": ("t, q, u, p", "K", "K = -dh/dq", ""),
    "damping": ("t, q, u, p", "C", "C = -dh/du", ""),
    "potential": ("t, q, p", "V", "V", " [J]"),
    "gap": ("t, q, p", "g_N", "g_N", ""),
    "normal": ("t, q, p", "W_N", "W_N = dg_N/dq", ""),
    "gap_rate": ("t, q, p", "w_N", "w_N = dg_N/dt", " [m/s]"),
    "tangent": ("t, q, p", "W_F", "W_F = d gamma_F/du", ""),
    "surface_velocity": ("t, q, p", "w_F", "w_F = gamma_F at u = 0", " [m/s]"),
    "row_rates": ("t, q, u, p", "r", "W' u + w', (N, F) of each contact", " [m/s^2]"),
    "normal_force": ("t, q, u, p", "N", "N of the contacts under a given force", " [N]"),
}
IMPORTED = {"System", "Contact", "DerivedModel", *vars(laws)}  # names that the class must not hide
LEFT_OUT_AS_ZERO = {"stiffness", "damping", "gap_rate", "surface_velocity"}


def class_name(name: str) -> str:
    """A name of letters and digits, its words begun by capitals."""
    words = re.findall(r"[A-Za-z0-9]+", name)
    joined = "".join(word[0].upper() + word[1:] for word in words)
    is_free = joined[0].isalpha() and joined not in IMPORTED
    return joined if is_free else f"Model{joined}"


def plain(text: str) -> str:
    """A text of the user's as it may stand in a docstring or a comment."""
    return " ".join(re.sub(r"[^\w ,.;:'()\[\]+*/^=-]", " ", text).split())


class Writer:
    """The source of one model, in the order of its sections."""

    def __init__(self, declaration: Any, jacobians: bool, t_end: float, dt: float) -> None:
        self.declaration, self.t_end, self.dt = declaration, t_end, dt
        self.declared = declaration.complete()
        self.equations = Equations(self.declared, jacobians)
        self.code = FlatCode(self.equations.line, self._names())
        self.title = plain(declaration.name)[:1].upper() + plain(declaration.name)[1:]
        self.written = [name for name, entries in self.equations.functions.items() if self._is_written(name, entries)]

    def text(self) -> str:
        """The whole file."""
        parts = [
            self._header(),
            self._imports(),
            *map(self._function, self.written),
            *(self._place(i) for i in range(len(self.declared.contacts)) if self._has_place(i)),
            *self.declaration.laws,
            self._natural_state(),
            self._class(),
        ]
        return "\n\n\n".join(part.strip("\n") for part in parts if part) + "\n"

    def _names(self) -> dict[Any, tuple[str, str]]:
        """How each symbol is read, and its name within a function, where it hides no argument."""
        taken = {"t", "q", "u", "p", "math", "np", *(out for _, out, _, _ in OUT.values())}
        read = {q: f"q[{i}]" for i, q in enumerate(self.declared.q)}
        read |= {u: f"u[{i}]" for i, u in enumerate(self.declared.u)}
        read |= {symbol: f"p.{symbol}" for symbol in self.declaration.parameter_fields}
        names = {self.declared.t: ("t", "t")}
        for symbol, source in read.items():
            name = str(symbol)
            while name in taken:
                name += "_"
            taken.add(name)
            names[symbol] = source, name
        return names

    def _is_written(self, name: str, entries: list[Any]) -> bool:
        return bool(entries) and not (name in LEFT_OUT_AS_ZERO and all(value == 0 for _, value in entries))

    # sections

    def _header(self) -> str:
        declared, check = self.declared, self.declaration.expressions
        of_q = ", ".join(f"{q}{bracketed(self.declaration.coordinate_units[q])}" for q in declared.q)
        lines = [
            f"{self.title}: written from its energies.", "",
            "    M u' = h + W_N^T la_N + W_F^T la_F,    q' = u,    d/dt dT/du - dT/dq + dV/dq + dR/du = Q", "",
            *wrapped(f"q = ({of_q})"),
        ]  # fmt: skip
        for part in declared.energies:
            lines += wrapped(_energy_line(part))
        for letter, energies in (("T", declared.kinetic), ("V", declared.potentials), ("R", declared.dissipations)):
            for energy in energies:
                lines += wrapped(f"{letter} += {energy}")
        for force in declared.forces:
            lines += wrapped(f"Q += ({listed(force.force)}) at ({listed(force.position)})")
        for i, contact in enumerate(declared.contacts):
            said = f"g_N[{i}] = {contact.gap}" if contact.gap is not None else f"N[{i}] = {contact.normal_force}"
            unit = check.unit(contact.gap if contact.gap is not None else contact.normal_force)
            lines += wrapped(f"{said}{bracketed(unit)}    {contact.arguments}")
        lines += ["", f"Derived by nonsmooth {nonsmooth.__version__} with SymPy {sp.__version__}; SI units."]
        return '"""' + "\n".join(lines).replace("\\", "\\\\") + '\n"""'

    def _imports(self) -> str:
        laws = sorted(set(re.findall(r"mu=([A-Z][A-Za-z]+)\(", " ".join(c.arguments for c in self.declared.contacts))))
        has_contacts = bool(self.declared.contacts)
        lines = [
            "from __future__ import annotations", "", "import math", "from dataclasses import dataclass", "",
            "import numpy as np", "", "from nonsmooth.checks.arrays import as_number",
            f"from nonsmooth.mechanics.laws import {', '.join(laws)}" if laws else "",
            f"from nonsmooth.mechanics.system import {'Contact, ' if has_contacts else ''}System",
            "from nonsmooth.symbolic.derived_model import DerivedModel",
        ]  # fmt: skip
        return "\n".join(line for k, line in enumerate(lines) if line or k < 7)

    def _function(self, name: str) -> str:
        arguments, out, says, unit = OUT[name]
        body = self.code.body(out, self.equations.functions[name])
        return "\n".join([f"def {name}({arguments}, {out}):", f"    # {says}{unit}", *("    " + line for line in body)])

    def _has_place(self, i: int) -> bool:
        """Whether contact i is drawn: pictures know no time."""
        place = self.declared.contacts[i].place
        return bool(place) and not any(sp.S(part).has(self.declared.t) for part in place)

    def _place(self, i: int) -> str:
        before, values = self.code.returned(list(self.declared.contacts[i].place))
        pairs = ", ".join(f"({values[k]}, {values[k + 1]})" for k in (0, 2, 4))
        lines = [f"def at_{i}(q, p):", f"    # point [m], normal and tangent of contact {i}"]
        return "\n".join([*lines, *("    " + row for row in before), f"    return {pairs}"])

    def _natural_state(self) -> str:
        size = 2 * len(self.declared.q)
        return "\n".join(["def natural_state(t, s, p, x):", f"    for i in range({size}):", "        x[i] = s[i]"])

    def _class(self) -> str:
        fields = self.declaration.parameter_fields.values()
        lines = [
            "@dataclass(frozen=True)", f"class {class_name(self.declaration.name)}(DerivedModel):",
            *indented(self._docstring()), "",
            *(f"    {f.name}: float = {f.value!r}{comment(f.doc, f.unit)}" for f in fields), *([""] if fields else []),
            f"    name = {self.declaration.name!r}",
            f"    coordinates = {tuple((str(q), unit) for q, unit in self.declaration.coordinate_units.items())!r}",
            "    natural_state = staticmethod(natural_state)",
            f"    t_end = {self.t_end!r}  # s", f"    dt = {self.dt!r}  # s", "",
            *indented(self._post_init()), *indented(self._system()), "", *indented(self._state()),
            *indented(self._picture()),
        ]  # fmt: skip
        return "\n".join(lines)

    def _docstring(self) -> list[str]:
        q = ", ".join(map(str, self.declared.q))
        lines = [f'"""{self.title}: q = ({q}).']
        for k, f in enumerate(self.declaration.parameter_fields.values()):
            lines += ["", "Parameters", "----------"] if k == 0 else []
            said = f"{plain(f.doc)}{bracketed(f.unit)}".strip()
            lines += [f"{f.name} : float", *([f"    {said}"] if said else [])]
        return [*lines, '"""'] if len(lines) > 1 else [lines[0] + '"""']

    def _post_init(self) -> list[str]:
        fields = self.declaration.parameter_fields.values()
        checks = [f'    as_number("{f.name}", self.{f.name}{f", {f.unit!r}" if f.unit else ""})' for f in fields]
        return ["def __post_init__(self) -> None:", *checks, ""] if checks else []

    def _system(self) -> list[str]:
        given = [f"{name}={name}" for name in self.written]
        contacts = [
            f"Contact({', '.join(filter(None, [contact.arguments, f'at=at_{i}' if self._has_place(i) else '']))})"
            for i, contact in enumerate(self.declared.contacts)
        ]
        inner = textwrap.wrap(
            ", ".join([f"n_q={len(self.declared.q)}", *given]) + ",", SOURCE_WIDTH - 12, break_long_words=False
        )
        count = f"{len(contacts)} contact{'s' * (len(contacts) != 1)}"
        lines = ["def system(self) -> System:", f'    """The system with {count}."""', "    return System("]
        lines += ["        " + row for row in inner]
        if contacts:
            lines += ["        contacts=[", *(f"            {contact}," for contact in contacts), "        ],"]
        return [*lines, "        parameters=self, name=self.name,", "    )  # fmt: skip"]

    def _state(self) -> list[str]:
        starts = self.declaration.starts
        symbols = [*self.declared.q, *self.declared.u]
        arguments = ", ".join(f"{s}: float = {starts.get(str(s), 0.0)!r}" for s in symbols)
        head = textwrap.wrap(arguments, SOURCE_WIDTH - 8, break_long_words=False)
        n = len(self.declared.q)
        units = [unit for unit in self.declaration.coordinate_units.values()]
        units += [f"{unit}/s" if unit else "" for unit in units]
        checked = [
            f'as_number("{s}", {s}{f", {unit!r}" if unit else ""})' for s, unit in zip(symbols, units, strict=True)
        ]
        return [
            "def state(", "    self,", *("    " + row for row in head), ") -> tuple[np.ndarray, np.ndarray]:",
            f'    """q0 ({n},) and u0 ({n},), the coordinates and their rates."""',
            "    q0 = [", *(f"        {check}," for check in checked[:n]), "    ]",
            "    u0 = [", *(f"        {check}," for check in checked[n:]), "    ]",
            "    return np.array(q0), np.array(u0)",
        ]  # fmt: skip

    def _picture(self) -> list[str]:
        moving = [line for line in self.declared.lines if self._moves(line)]
        still = [line for line in self.declared.lines if not self._moves(line)]
        shape = [
            "def shape(self, q: np.ndarray) -> list[np.ndarray]:",
            '    """The moving lines (k, 2) [m]."""',
            *self._lines(moving),
        ]
        outline = [
            "def outline(self) -> list[np.ndarray]:",
            '    """What stands still (k, 2) [m]."""',
            *self._lines(still),
        ]
        return [*(["", *shape] if moving else []), *(["", *outline] if still else [])]

    def _moves(self, line: Any) -> bool:
        return any(sp.S(part).free_symbols & {*self.declared.q} for corner in line for part in corner)

    def _lines(self, lines: list[Any]) -> list[str]:
        flat = [part for line in lines for corner in line for part in corner]
        before, values = self.code.returned([part.subs(self.declared.t, 0) for part in flat])
        corners = iter(values)
        rows = []
        for line in lines:
            rows.append(
                "np.array([" + ", ".join(f"[{next(corners)}, {next(corners)}]" for _ in line) + "], dtype=float)"
            )
        used = [*before, *rows]
        setup = ["    p = self"] if any("p." in row for row in used) else []
        return [
            *setup,
            *("    " + row for row in before),
            "    return [",
            *(f"        {row}," for row in rows),
            "    ]",
        ]


def _energy_line(part: Any) -> str:
    if hasattr(part, "omega"):
        return f"T += omega.I omega/2,  omega = ({listed(part.omega)}),  I = {part.inertia}"
    pull = "" if part.gravity == 0 else f"  V += {-part.weight * part.gravity}*r,"
    return f"T += {part.weight}*r'**2/2,{pull}  r = {part.position}"


def listed(parts: Any) -> str:
    """Expressions in a row."""
    return ", ".join(shortened(part) for part in parts)


def bracketed(unit: str) -> str:
    """A unit behind a name."""
    return f" [{unit}]" if unit else ""


def comment(doc: str, unit: str) -> str:
    """What stands behind a field."""
    said = f"{plain(doc)}{bracketed(unit)}".strip()
    return f"  # {said}" if said else ""


def wrapped(text: str) -> list[str]:
    """A line of the header, broken where it is long."""
    return textwrap.wrap(
        text, SOURCE_WIDTH, initial_indent="    ", subsequent_indent="        ", break_long_words=False
    )


def indented(lines: list[str]) -> list[str]:
    """The lines of a method."""
    return ["    " + line if line else "" for line in lines]
