"""What the name of an axis means for a model: a parameter, a variable of its state, an option of the integrator.

    mu, vb, ...        a field of the model (or a parameter of the system)
    th, slip, ...      an argument of model.state(...)
    q0[i], u0[i]       an entry of the initial state, or q[i], u[i]
    dt, theta, ...     an option of the integrator
    t_end              the end of the run

A name that means two of these is refused; "model.x", "state.x" and "integrator.x" say which one is meant.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from nonsmooth.checks.arrays import as_instance
from nonsmooth.checks.parameters import numeric_fields
from nonsmooth.errors import InvalidInput, UnknownName, nearest
from nonsmooth.mechanics.model_system import as_system
from nonsmooth.mechanics.start import COMPONENT, state_function, variables_of
from nonsmooth.mechanics.system import System
from nonsmooth.mechanics.units import unit_of_parameter

Columns = Mapping[str, np.ndarray]
END = "t_end"


@dataclass(frozen=True)
class Parts:
    """The columns of a batch by what they change."""

    fields: Columns
    arguments: Columns
    components: Columns
    options: Columns

    @property
    def length(self) -> int:
        """Cells along the axis: the length of the longest column."""
        return max(len(values) for part in vars(self).values() for values in part.values())


class AxisNames:
    """The names that a model and an integrator know."""

    def __init__(self, model: Any, integrator: Any) -> None:
        self.model = model
        parameters = model.parameters if isinstance(model, System) else model
        self.known: dict[str, dict[str, str]] = {
            "fields": {name: f"model.{name}" for name in numeric_fields(parameters)},
            "arguments": {name: f"state.{name}" for name in state_names(model)},
            "options": {name: f"integrator.{name}" for name in option_names(integrator)} | {END: END},
        }

    def resolve(self, name: str) -> tuple[str, str]:
        """The part that an axis belongs to, and its plain name there."""
        as_instance("the name of an axis", name, str, "a text")
        match = COMPONENT.fullmatch(name)
        if match:
            n = as_system(self.model).n_q
            if not int(match[2]) < n:
                raise InvalidInput(f"{name}: the state has {n} entries, counted from 0")
            return "components", f"{match[1]}0[{int(match[2])}]"
        meanings = [(part, plain) for part, names in self.known.items() for plain in names if name == plain]
        meanings += [(part, plain) for part, names in self.known.items() for plain, full in names.items()
                     if name == full and full != plain]  # fmt: skip
        if not meanings:
            names = {plain for part in self.known.values() for plain in part} | {"q0[0]", "u0[0]"}
            raise UnknownName(f"there is no axis {name!r}; {nearest(name, names)}")
        if len(meanings) > 1:
            choices = " or ".join(self.known[part][plain] for part, plain in meanings)
            raise InvalidInput(f"the axis {name!r} has two meanings; say {choices}")
        return meanings[0]

    def split(self, columns: Columns) -> Parts:
        """The columns by what they change, under their plain names."""
        parts: dict[str, dict[str, np.ndarray]] = {field.name: {} for field in fields(Parts)}
        for name, values in columns.items():
            part, plain = self.resolve(name)
            if plain in parts[part]:
                varied = plain if part == "components" else self.known[part][plain]
                raise InvalidInput(f"two axes vary {varied}; keep one of them")
            parts[part][plain] = values
        return Parts(**parts)


def state_names(model: Any) -> tuple[str, ...]:
    """The arguments of ``state`` of a model; of a system without one its coordinates and their rates."""
    return tuple(variables_of(state_function(model)))


def option_names(integrator: Any) -> tuple[str, ...]:
    """The options of an integrator that are numbers."""
    values = {field.name: getattr(integrator, field.name) for field in fields(integrator)}
    return tuple(
        name for name, value in values.items() if isinstance(value, int | float) and not isinstance(value, bool)
    )


def require_unit(name: str, given: str, known: str) -> None:
    """Raise where the unit of an axis is not that of the model: values are taken as they are, so they would be labelled
    with another unit than they are used in."""
    if given and known not in ("", "-", given) and spelled(given) != spelled(known):
        raise InvalidInput(
            f"the axis {name} is in {known}, and values are not converted; give them in {known}, without {given!r}"
        )


def spelled(unit: str) -> str:
    """A unit in one spelling: "N*s/m", "N·s/m" and "N s/m" are one."""
    return "".join(sign for sign in unit if sign not in " *·⋅")


def unit_of(system: System, name: str) -> str:
    """Unit of a variable that is a coordinate of the model, its rate or a parameter; empty where it is not known."""
    return system.described.unit_of(name) or unit_of_parameter(system.parameters, name)
