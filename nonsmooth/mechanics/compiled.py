"""From a System to what the loops call: a machine address, or the same functions run by the interpreter."""

from __future__ import annotations

import functools
import os
import weakref
from collections.abc import Callable
from typing import Any

import numpy as np

from nonsmooth.errors import InterpretedWarning, warn_caller
from nonsmooth.jit import (
    CannotCompile,
    CompiledModel,
    Unpack,
    call_model,
    compile_model,
    interpreted,
    kernel,
    survey_of,
)
from nonsmooth.jit.watch import CHANGED, Watch
from nonsmooth.mechanics.system import TAKES_U, System


@kernel("boolean(int64, int64, float64, float64[::1], float64[::1], float64[::1], float64[::1])")
def call_once(model, which, t, q, u, p, out):
    """Call one function of a model from Python; False if it raised."""
    return call_model(model, which, t, q, u, p, out)


class Model:
    """A system's functions, ready to be called from a loop.

    Attributes
    ----------
    handle : int or callable
        The ``model`` argument of the loops: an address, or a Python function in the interpreted case.
    is_compiled : bool
    """

    def __init__(self, handle: Any, keep: Any, is_compiled: bool, watch: Watch) -> None:
        self.handle = handle
        self._keep = keep
        self.is_compiled = is_compiled
        self._watch = watch

    @property
    def is_current(self) -> bool:
        """Whether it does what the functions do now: nothing that they read has changed since it was compiled."""
        return self._watch.holds()

    def loop(self, integrator: Any, system: System) -> Callable:
        """The integrator's loop that fits this model: compiled, or its source."""
        if not self.is_compiled:
            return interpreted(integrator.loop)
        integrator.load(system)
        return integrator.loop.dispatcher


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
    compiled anew. ``NONSMOOTH_INTERPRET=1`` asks for the interpreter.
    """
    if os.environ.get("NONSMOOTH_INTERPRET") == "1":
        return _interpreted_model(system)
    try:
        return _compiled_or_by_differences(system)
    except CannotCompile as reason:
        warn_caller(
            f"{reason}; the same source runs in the interpreter, about a hundred times slower. {reason.cure}",
            InterpretedWarning,
        )
        return _interpreted_model(system)


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


class Shelf:
    """The machine code of some functions, compiled when it is asked for and again where what they read has changed.

    Parameters are those of `compile_model`.
    """

    def __init__(self, functions: dict[int, Any], n_q: int, n_u: int, unpack: Unpack, n_p: int) -> None:
        self._arguments = functions, n_q, n_u, unpack, n_p
        self._made_from, self._watch = b"", CHANGED
        self._made: CompiledModel | CannotCompile | None = None
        self._model: Model | None = None

    def model(self) -> Model:
        """The machine code.

        Raises
        ------
        CannotCompile
        """
        if not self._watch.holds():
            self._update()
        if self._model is None:
            assert isinstance(self._made, CannotCompile)
            raise self._made.with_traceback(None)
        return self._model

    def _update(self) -> None:
        survey = survey_of(*self._arguments)  # imports numba, and refuses one that does not fit before a word is said
        made_from = survey.digest()
        if made_from != self._made_from:
            try:
                self._made = compile_model(*self._arguments, survey)
            except CannotCompile as reason:
                self._made = reason
        made = self._made
        self._model = Model(made.address, made, True, survey.watch) if isinstance(made, CompiledModel) else None
        self._made_from, self._watch = made_from, survey.watch


def _shelf_of(system: System, functions: dict[int, Callable]) -> Shelf:
    key = tuple((which, Same(function), system.shape_of(which)) for which, function in functions.items())
    return _shelf(key, system.n_q, system.n_u, len(system.p), system.unpack)


class Same:
    """A key that is equal for the same object only: not every callable can be a key itself."""

    def __init__(self, function: Callable) -> None:
        self.function = function

    def __hash__(self) -> int:
        return id(self.function)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Same) and other.function is self.function


@functools.lru_cache(maxsize=128)
def _shelf(key: tuple, n_q: int, n_u: int, n_p: int, unpack: Unpack) -> Shelf:
    functions = {which: (same.function, which in TAKES_U, shape) for which, same, shape in key}
    return Shelf(functions, n_q, n_u, unpack, n_p)


def _interpreted_model(system: System) -> Model:
    functions, unpack = system.functions, system.unpack

    def model(which: int, t: float, q: np.ndarray, u: np.ndarray, p: np.ndarray, out: np.ndarray) -> None:
        """What a compiled model does, in Python: clear, unpack the parameters, call."""
        out[...] = 0.0
        if which in TAKES_U:
            functions[which](t, q, u, unpack(*p), out)
        else:
            functions[which](t, q, unpack(*p), out)

    return Model(model, None, False, Watch())
