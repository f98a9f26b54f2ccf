"""From a System to what the loops call: a machine address, or the same functions run by the interpreter."""

from __future__ import annotations

import functools
import os
import weakref
from collections.abc import Callable
from typing import Any

import numpy as np

from nonsmooth.errors import InterpretedWarning, warn_caller
from nonsmooth.jit import CannotCompile, Unpack
from nonsmooth.jit.watch import Watch
from nonsmooth.mechanics.own_law import require_compiled_laws
from nonsmooth.mechanics.shelf import Model, Same, Shelf
from nonsmooth.mechanics.system import TAKES_U, System

_loops: weakref.WeakKeyDictionary[System, dict[Any, tuple[Model, Callable]]] = weakref.WeakKeyDictionary()


def loop_of(system: System, integrator: Any) -> tuple[Model, Callable]:
    """The model of a system and the integrator's loop for it; compiled ones are found once and remembered."""
    known = _loops.setdefault(system, {})
    found = known.get(integrator)
    if found is not None and os.environ.get("NONSMOOTH_INTERPRET") != "1" and found[0].is_current:
        return found
    model = model_of(system)
    found = model, model.loop(integrator, system)
    if model.is_compiled:
        known[integrator] = found
    return found


def model_of(system: System) -> Model:
    """Compile a system's functions (once for all its parameter values), or fall back to the interpreter with a warning.

    What they read, globals and constants of modules, is looked at again each time: where it has changed they are
    compiled again. ``NONSMOOTH_INTERPRET=1`` asks for the interpreter.
    """
    if os.environ.get("NONSMOOTH_INTERPRET") == "1":
        return interpreted_model(system)
    try:
        require_compiled_laws(system)
        return _compiled_or_by_differences(system)
    except CannotCompile as reason:
        warn_caller(
            f"{reason}; the same source runs in the interpreter, about a hundred times slower. {reason.cure}",
            InterpretedWarning,
        )
        return interpreted_model(system)


def _compiled_or_by_differences(system: System) -> Model:
    """Machine code of the functions; where the compiler refuses dual numbers, derived rows are found by differences."""
    functions = system.functions
    try:
        return _shelf_of(system, functions).model()
    except CannotCompile:
        rough = {which: getattr(function, "by_differences", function) for which, function in functions.items()}
        if rough == functions:
            raise
        return _shelf_of(system, rough).model()


def _shelf_of(system: System, functions: dict[int, Callable]) -> Shelf:
    key = tuple((which, Same(function), system.shape_of(which)) for which, function in functions.items())
    return _shelf(key, system.n_q, system.n_u, len(system.p), system.unpack)


@functools.lru_cache(maxsize=128)
def _shelf(key: tuple, n_q: int, n_u: int, n_p: int, unpack: Unpack) -> Shelf:
    functions = {which: (same.function, which in TAKES_U, shape) for which, same, shape in key}
    return Shelf(functions, n_q, n_u, unpack, n_p)


def interpreted_model(system: System) -> Model:
    """A system's functions, run by Python."""
    functions, unpack = system.functions, system.unpack

    def model(which: int, t: float, q: np.ndarray, u: np.ndarray, p: np.ndarray, out: np.ndarray) -> None:
        """What a compiled model does, in Python: clear, unpack the parameters, call."""
        out[...] = 0.0
        if which in TAKES_U:
            functions[which](t, q, u, unpack(*p), out)
        else:
            functions[which](t, q, unpack(*p), out)

    return Model(model, None, False, Watch())
