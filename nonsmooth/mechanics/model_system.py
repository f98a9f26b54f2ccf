"""The system of a model: what its method ``system()`` builds.

It is asked each time, since it may read anything: attributes of the model and of its class, lists, files, the clock. Of
two systems that are the same in every part the first is taken, which is compiled and whose start is known. A system
whose parameters were written to, an array or an attribute, gives way to one of the parameters as they are.
"""

from __future__ import annotations

import functools
import types
from collections.abc import Hashable
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np

from nonsmooth.checks.parameters import constant_fields, numeric_fields, with_changes
from nonsmooth.errors import InvalidInput
from nonsmooth.jit.bytecode import SCALARS, scalar
from nonsmooth.mechanics.shelf import Same
from nonsmooth.mechanics.system import System

MOST_SYSTEMS = 32  # chosen: systems of models that are at work in turns


def as_system(candidate: Any) -> System:
    """The system itself, or the one that a model builds with its ``system()`` method."""
    if isinstance(candidate, System):
        given = numeric_fields(candidate.parameters, constant_fields(candidate.parameters))
        is_as_given = given == candidate.parameter_values
        return candidate if is_as_given else _first_of(_Made(replace(candidate)))
    if isinstance(candidate, type):
        raise InvalidInput(f"a system or a model is needed; got the class {candidate.__name__}: call it first")
    if not callable(getattr(candidate, "system", None)):
        raise InvalidInput(f"a system or a model is needed; got {type(candidate).__name__} without a system() method")
    made = candidate.system()
    return _first_of(_Made(made)) if type(made) is System else made


def as_rated(candidate: Any, what: str) -> System:
    """`as_system` for ``what`` takes coordinates with q' = u alone.

    Raises
    ------
    InvalidInput
        For a system with kinematics.
    """
    system = as_system(candidate)
    if system.kinematics is not None:
        raise InvalidInput(f"{what} takes no system with kinematics (q' = B u); MoreauJean(dt=...) simulates it")
    return system


def require_planar(system: System, what: str) -> None:
    """Raise `InvalidInput` for a system with q' = B u or friction in two directions, which ``what`` does not take."""
    if system.is_spatial:
        has = "friction in two directions" if system.d > 1 else "kinematics (q' = B u)"
        raise InvalidInput(f"{what} takes no system with {has}; MoreauJean(dt=...) simulates it")


class _Made:
    """A system that was built, equal to each that is the same in every part."""

    def __init__(self, system: System) -> None:
        self.system = system
        given = tuple(content_of(getattr(system, part.name)) for part in PARTS)
        self._content = given, content_of(tuple(system.numbers.items()))

    def __hash__(self) -> int:
        return hash(self._content)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Made) and other._content == self._content


PARTS = [part for part in fields(System) if part.init]


@functools.lru_cache(maxsize=MOST_SYSTEMS)
def _first_of(made: _Made) -> System:
    return made.system


def content_of(value: Any) -> Hashable:
    """What is equal for two values that nobody can ever tell apart: for what can change it is the object itself."""
    kind = type(value)
    if kind in SCALARS:
        return (kind, value) if kind in (str, bool, int, type(None)) else scalar(value)
    if kind is list or isinstance(value, tuple):
        return kind, *map(content_of, value)
    if kind is np.ndarray and not value.dtype.hasobject:
        return kind, repr(value.dtype), value.shape, value.tobytes()
    if kind is types.MethodType:
        return kind, content_of(value.__func__), content_of(value.__self__)
    if kind is types.FunctionType and not value.__closure__ and value.__globals__.get(value.__name__) is not value:
        defaults = content_of(value.__defaults__), content_of(tuple((value.__kwdefaults__ or {}).items()))
        return kind, value.__code__, Same(value.__globals__), *defaults
    if is_dataclass(value) and not isinstance(value, type) and kind.__dataclass_params__.frozen:  # type: ignore[attr-defined]
        return kind, *(content_of(getattr(value, part.name)) for part in fields(value))
    return Same(value)


def with_values(model: Any, changes: dict[str, Any]) -> Any:
    """A model or system with some parameters changed."""
    if not changes:
        return model
    return model.with_parameters(**changes) if isinstance(model, System) else with_changes(model, changes)


def idle_parameters(system: System | None) -> tuple[str, ...]:
    """The parameters that a model does not read as it is chosen, its attribute ``idle``: titles leave them out."""
    return tuple(getattr(system.parameters, "idle", ())) if system is not None else ()
