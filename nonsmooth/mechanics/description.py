"""What a system is called and how it looks: coordinates with units, names of contacts, polylines of its bodies.

Each is what the system was given, else an attribute of its parameters (a model's class has them), else a number. A
system without a name is called as its class, or as its variable in the module that has its functions.
"""

from __future__ import annotations

import inspect
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from nonsmooth.checks.arrays import as_index, as_name
from nonsmooth.errors import InvalidInput, shown

RATE = "dot"  # defined: thdot is the rate of th


@dataclass(frozen=True)
class Description:
    """Names and pictures of a system.

    Attributes
    ----------
    coordinates : tuple of (str, str)
        Name and unit of each; "q[0]" and no unit where they have no names.
    has_names : bool
        Whether the coordinates have names of their own.
    contacts : tuple of str
        "tip", or "contact 0" where it has no name.
    shape, outline, contact_frames : callable or None
        ``shape(q)``, ``outline()`` and ``contact_frames(q)``: points, normals and tangents (n_c, 2), NaN where a
        contact has no ``at``; None where none has one.
    parts : sequence of str or None
        Names of the polylines of ``shape``.
    velocities : tuple of (str, str)
        Name and unit of each velocity where q' = B u; none where they are the rates of the coordinates.
    """

    coordinates: tuple[tuple[str, str], ...]
    has_names: bool
    contacts: tuple[str, ...]
    shape: Callable[..., Lines] | None
    outline: Callable[..., Lines] | None
    parts: Sequence[str] | None
    contact_frames: Callable[..., Any] | None
    velocities: tuple[tuple[str, str], ...] = ()

    @property
    def names(self) -> list[str]:
        """The names of the coordinates."""
        return [name for name, _ in self.coordinates]

    @property
    def rates(self) -> tuple[tuple[str, str], ...]:
        """Name and unit of each velocity: thdot [rad/s]."""
        if self.velocities:
            return self.velocities
        if not self.has_names:
            return tuple((f"u[{k}]", "") for k in range(len(self.coordinates)))
        return tuple((name + RATE, f"{unit}/s" if unit else "") for name, unit in self.coordinates)

    def unit_of(self, name: str) -> str:
        """Unit of a coordinate or its rate; empty where it is not known."""
        return dict((*self.coordinates, *self.rates)).get(name, "")

    def coordinate(self, coordinate: int | str, what: str = "coordinate") -> int:
        """The place of a coordinate in q, given by number or name."""
        if isinstance(coordinate, str):
            return self.names.index(as_name("coordinate", coordinate, self.names))
        return as_index(what, coordinate, len(self.coordinates))

    def contact(self, contact: int | str) -> int:
        """The number of a contact, given by number or name."""
        if isinstance(contact, str):
            return self.contacts.index(as_name("contact", contact, self.contacts))
        return as_index("contact", contact, len(self.contacts))

    def label(self, place: int) -> str:
        """A coordinate as an axis has it: th [rad]."""
        return with_unit(*self.coordinates[place])


def with_unit(name: str, unit: str) -> str:
    """A name as an axis has it."""
    return f"{name} [{unit}]" if unit else name


def numbered(n_q: int, n_c: int) -> Description:
    """That of a system of which no more is known, as of a run read from a file."""
    coordinates = tuple((f"q[{k}]", "") for k in range(n_q))
    return Description(coordinates, False, tuple(f"contact {i}" for i in range(n_c)), None, None, None, None)


def names_in_file(description: Description) -> dict[str, Any]:
    """Its names, as a file holds them."""
    return {
        "coordinates": description.coordinates, "has_names": description.has_names, "contacts": description.contacts,
        "velocities": description.velocities,
    }  # fmt: skip


def of_names(names: dict[str, Any]) -> Description:
    """The names that a file holds."""
    coordinates, velocities = (
        tuple((str(name), str(unit)) for name, unit in names[kind]) for kind in ("coordinates", "velocities")
    )
    contacts = tuple(str(name) for name in names["contacts"])
    return Description(coordinates, bool(names["has_names"]), contacts, None, None, None, None, velocities)


def described(system: Any) -> Description:
    """The names and pictures of a system."""
    model = system.parameters
    of_model = as_names("coordinates", "coordinate", getattr(model, "coordinates", None) or (), None)
    fits = len(of_model) == system.n_q  # parameters may be those of another system
    own = system.coordinates or (of_model if fits else ())
    names = tuple(contact.name or f"contact {i}" for i, contact in enumerate(system.contacts))
    return Description(
        own or tuple((f"q[{k}]", "") for k in range(system.n_q)), bool(own), names,
        in_lines("shape(q)", _drawn(system, system.shape, 1) or getattr(model, "shape", None), least=1),
        in_lines("outline()", _drawn(system, system.outline, 0) or getattr(model, "outline", None), least=0),
        getattr(model, "parts", None) if system.shape is None else None,
        _frames(system), _velocities_of(system),
    )  # fmt: skip


def _velocities_of(system: Any) -> tuple[tuple[str, str], ...]:
    """Names of the velocities of a system with q' = B u; none where they are rates of the coordinates."""
    if system.kinematics is None:
        return ()
    of_model = as_names("velocities", "velocity", getattr(system.parameters, "velocities", None) or (), None)
    own = system.velocities or (of_model if len(of_model) == system.n_u else ())
    return own or tuple((f"u[{k}]", "") for k in range(system.n_u))


def title_of(system: Any) -> str:
    """What titles and summaries call a system; empty where it has no name, and none is found."""
    if system.name:
        return str(system.name)
    if callable(getattr(type(system.parameters), "system", None)):
        return type(system.parameters).__name__
    module = sys.modules.get(getattr(system.mass, "__module__", None) or "")
    named = [name for name, value in [*vars(module).items()] if not name.startswith("_") and _is_of(value, system)] \
        if module else []  # fmt: skip
    return named[0] if len(named) == 1 else ""


def _is_of(value: Any, system: Any) -> bool:
    """Whether it is the system, or one of the same functions with other parameters."""
    return isinstance(value, type(system)) and value.mass is system.mass and value.force is system.force


def _drawn(system: Any, function: Callable[..., Any] | None, n: int) -> Callable[..., Any] | None:
    """A function of the user's with the parameters as its last argument, where it takes them."""
    if function is None or len(inspect.signature(function).parameters) == n:
        return function
    return lambda *q: function(*q, system.unpacked)


def _frames(system: Any) -> Callable[[np.ndarray], tuple[np.ndarray, ...]] | None:
    """Points, normals and tangents of the contacts as a function of q."""
    drawn = {i: _drawn(system, contact.at, 1) for i, contact in enumerate(system.contacts)}
    placed = {i: at for i, at in drawn.items() if at is not None}
    if not placed:
        return None

    def contact_frames(q: np.ndarray) -> tuple[np.ndarray, ...]:
        frames = np.full((3, system.n_c, 2), np.nan)
        for i, at in placed.items():
            frames[:, i] = as_frame(system.contacts[i].name or f"contact {i}", at(q))
        return tuple(frames)

    return contact_frames


def as_frame(name: str, given: Any) -> np.ndarray:
    """Point, normal and tangent (3, 2) of a contact; without a tangent it is the normal, turned clockwise."""
    try:
        frame = np.array(given, dtype=float)
    except (TypeError, ValueError):
        frame = np.empty(0)
    if frame.shape == (2, 2):
        frame = np.vstack([frame, [frame[1, 1], -frame[1, 0]]])
    if frame.shape != (3, 2):
        raise InvalidInput(
            f"at(q) of {name!r} must return its point and its normal, each (x, y), or these and its tangent; "
            f"got {shown(given)}"
        )
    return frame


class Lines(list[np.ndarray]):
    """Polylines (k, 2) [m], and their names."""

    def __init__(self, lines: Iterable[np.ndarray], names: Iterable[str]) -> None:
        super().__init__(lines)
        self.names = list(names)


def in_lines(name: str, drawn: Callable[..., Any] | None, least: int) -> Callable[..., Lines] | None:
    """A function of the user's whose result is looked at each time."""
    return None if drawn is None else lambda *q: as_lines(name, drawn(*q), least)


def as_lines(name: str, given: Any, least: int) -> Lines:
    """At least so many polylines, in a sequence, or in a dictionary by their names, or `InvalidInput`."""
    is_named = isinstance(given, Mapping)
    try:
        found = [np.asarray(line, dtype=float) for line in (given.values() if is_named else given)]
    except (TypeError, ValueError):
        found = [np.empty(0)]
    if len(found) < least or any(line.ndim != 2 or line.shape[0] == 0 or line.shape[1] != 2 for line in found):
        raise InvalidInput(
            f"{name} must return a list of polylines (k, 2) [m], or a dict of them by name; got {shown(given)}"
        )
    return Lines(found, map(str, given) if is_named else (f"part {k}" for k in range(len(found))))


def require_drawn(name: str, function: Any, names: tuple[str, ...], returned: str = "polylines") -> None:
    """Raise `InvalidInput` for what is no function of these arguments, or of all but the last."""
    try:
        signature = inspect.signature(function)
        number = len(signature.parameters)
        signature.bind(*names[:number])
    except Exception:  # whatever an object raises that is asked what it takes
        number = -1
    if number not in (len(names), len(names) - 1):
        expected = " or ".join(f"{name}({', '.join(some)})" for some in (names, names[:-1]))
        raise InvalidInput(f"{name} must be a function {expected} that returns {returned}; got {shown(function)}")


def _pairs(what: str, given: Sequence[Any]) -> tuple[tuple[str, str], ...]:
    """Names with units."""
    pairs = [(entry, "") if isinstance(entry, str) else entry for entry in given]
    for pair in pairs:
        is_pair = isinstance(pair, tuple | list) and len(pair) == 2 and all(isinstance(text, str) for text in pair)
        if not is_pair or not pair[0]:
            raise InvalidInput(f"a {what} is a name with its unit, as ('th', 'rad'); got {shown(pair)}")
    many = [name for name, count in Counter(name for name, _ in pairs).items() if count > 1]
    if many:
        raise InvalidInput(f"the {what} {many[0]!r} is named twice; give each a name of its own")
    return tuple((name, unit) for name, unit in pairs)


def as_names(kind: str, what: str, given: Any, n: int | None) -> tuple[tuple[str, str], ...]:
    """Names and units of n coordinates or velocities, or `InvalidInput`."""
    if isinstance(given, str) or not isinstance(given, list | tuple):
        raise InvalidInput(f'{kind} must be a list as [("x", "m"), ("th", "rad")]; got {shown(given)}')
    pairs = _pairs(what, given)
    if pairs and isinstance(n, int) and len(pairs) != n:
        of = "n_q" if what == "coordinate" else "n_u"
        raise InvalidInput(f"{kind} must have {n} entries, one for each {what} of {of}; got {len(pairs)}")
    return pairs
