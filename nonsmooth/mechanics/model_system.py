"""The system of a model: what its method ``system()`` builds, kept until that, or what it reads, has changed."""

from __future__ import annotations

import functools
import types
from typing import Any

from nonsmooth.checks.parameters import with_changes
from nonsmooth.errors import InvalidInput
from nonsmooth.jit.fingerprint import LooseSurvey
from nonsmooth.jit.watch import MISSING, Watch
from nonsmooth.mechanics.system import System


def as_system(candidate: Any) -> System:
    """The system itself, or the one that a model builds with its ``system()`` method."""
    if isinstance(candidate, System):
        return candidate
    if isinstance(candidate, type):
        raise InvalidInput(f"a system or a model is needed; got the class {candidate.__name__}: call it first")
    if not callable(getattr(candidate, "system", None)):
        raise InvalidInput(f"a system or a model is needed; got {type(candidate).__name__} without a system() method")
    try:
        kept = _kept(candidate)
    except TypeError:  # an unhashable model
        system: System = candidate.system()
        return system
    if not kept or not kept[0][1].holds():  # its method has changed, or what that reads
        kept[:] = [(candidate.system(), _watch_on_method(type(candidate)))]
    return kept[0][0]


@functools.lru_cache(maxsize=64)
def _kept(model: Any) -> list[tuple[System, Watch]]:
    """Where the system of a model is kept, with the watch on what it was made from."""
    return []


def _watch_on_method(cls: type) -> Watch:
    """On ``system`` and all that it reads."""
    method = getattr(cls, "system", None)
    survey = LooseSurvey(method)
    survey.watch.name(vars(cls), "system", vars(cls).get("system", MISSING))  # type: ignore[arg-type]
    if isinstance(method, types.FunctionType):
        survey.function(method)
    return survey.watch


def with_values(model: Any, changes: dict[str, Any]) -> Any:
    """A model or system with some parameters changed."""
    if not changes:
        return model
    return model.with_parameters(**changes) if isinstance(model, System) else with_changes(model, changes)


def idle_parameters(system: System | None) -> tuple[str, ...]:
    """The parameters that a model does not read as it is chosen, its attribute ``idle``: titles leave them out."""
    return tuple(getattr(system.parameters, "idle", ())) if system is not None else ()
