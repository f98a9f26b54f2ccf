"""What a user declares: parts of the energies, forces, contacts, parameters.

    T = sum w (dr/dt)^2/2 + sum omega.I omega/2 + T_typed,    Q = sum (dr/dq)^T F - dR/du
    g_N = n.r + offset,    gamma_F = tau.(dr/dt - v_surface)

Expressions are those of SymPy, in coordinates, rates, parameters and time; nothing is derived here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, fields, is_dataclass, replace
from typing import Any


@dataclass(frozen=True)
class Weighted:
    """w (dr/dt)^2/2 - w g r: a mass and one component of its position, or a moment of inertia and an angle."""

    weight: Any
    position: Any
    gravity: Any


@dataclass(frozen=True)
class Turning:
    """omega.I omega/2 with the angular velocity in a frame of the body, where I is constant."""

    inertia: tuple[tuple[Any, ...], ...]  # (3, 3)
    omega: tuple[Any, ...]  # (3,)


@dataclass(frozen=True)
class Force:
    """A force on a point, or a moment on an angle: (dr/dq)^T F."""

    position: tuple[Any, ...]
    force: tuple[Any, ...]


@dataclass(frozen=True)
class Given:
    """M and h that another program derived."""

    mass: tuple[tuple[Any, ...], ...]
    force: tuple[Any, ...]


@dataclass(frozen=True)
class DeclaredContact:
    """A contact: its gap or its given normal force, and its sliding velocity in one of two forms.

    Attributes
    ----------
    arguments : str
        Of `Contact`, as they are typed.
    gap, normal_force : expression or None
    point, tangent, surface : tuple
        gamma_F = tangent.(dr/dt - surface); empty where it does not slide, or slides with ``slip``.
    slip : expression or None
        gamma_F itself, linear in the rates.
    place : tuple
        Its point, normal and tangent in the plane, one after the other, for pictures; empty where they are not known.
    """

    arguments: str
    gap: Any = None
    normal_force: Any = None
    point: tuple[Any, ...] = ()
    tangent: tuple[Any, ...] = ()
    surface: tuple[Any, ...] = ()
    slip: Any = None
    place: tuple[Any, ...] = ()

    @property
    def slides(self) -> bool:
        """Whether it has a sliding velocity."""
        return self.slip is not None or bool(self.tangent)


@dataclass(frozen=True)
class Parameter:
    """A field of the model."""

    name: str
    value: float
    unit: str
    doc: str


@dataclass
class Declared:
    """All that was declared of a system, in the order in which it was typed."""

    q: list[Any] = field(default_factory=list)
    u: list[Any] = field(default_factory=list)
    t: Any = None
    energies: list[Weighted | Turning] = field(default_factory=list)
    kinetic: list[Any] = field(default_factory=list)
    potentials: list[Any] = field(default_factory=list)
    dissipations: list[Any] = field(default_factory=list)
    forces: list[Force] = field(default_factory=list)
    given: list[Given] = field(default_factory=list)
    contacts: list[DeclaredContact] = field(default_factory=list)
    lines: list[tuple[tuple[Any, Any], ...]] = field(default_factory=list)

    def mapped(self, change: Callable[[list[Any]], list[Any]]) -> Declared:
        """The same with all expressions changed at once."""
        names = [entry.name for entry in fields(self) if entry.name not in ("q", "u", "t")]
        parts = {name: getattr(self, name) for name in names}
        changed = iter(change([expression for part in parts.values() for expression in expressions_of(part)]))
        return replace(self, **{name: _rebuilt(part, changed) for name, part in parts.items()})

    def expressions(self) -> list[Any]:
        """Every expression, in the order of the fields."""
        return [e for entry in fields(self) for e in expressions_of(getattr(self, entry.name))]


def expressions_of(part: Any) -> Iterator[Any]:
    """The expressions of a declared part; texts and None are none."""
    if isinstance(part, list | tuple):
        for entry in part:
            yield from expressions_of(entry)
    elif is_dataclass(part):
        for entry in fields(part):
            yield from expressions_of(getattr(part, entry.name))
    elif part is not None and not isinstance(part, str):
        yield part


def _rebuilt(part: Any, changed: Iterator[Any]) -> Any:
    if isinstance(part, list | tuple):
        return type(part)(_rebuilt(entry, changed) for entry in part)
    if is_dataclass(part) and not isinstance(part, type):
        return replace(part, **{entry.name: _rebuilt(getattr(part, entry.name), changed) for entry in fields(part)})
    return part if part is None or isinstance(part, str) else next(changed)
