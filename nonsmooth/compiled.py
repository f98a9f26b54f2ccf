"""From a System to what the loops call: a machine address, or the same functions run by the interpreter."""

from __future__ import annotations

import functools
import os
import sys
import weakref
from collections.abc import Callable
from typing import Any

import numpy as np

from nonsmooth.errors import InterpretedWarning, warn_caller
from nonsmooth.jit import CannotCompile, cache_directory, call_model, compile_model, interpreted, kernel
from nonsmooth.system import TAKES_U, System


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

    def __init__(self, handle: Any, keep: Any, is_compiled: bool) -> None:
        self.handle = handle
        self._keep = keep
        self.is_compiled = is_compiled

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
    if integrator in known and os.environ.get("NONSMOOTH_INTERPRET") != "1":
        return known[integrator]
    model = model_of(system)
    found = model, model.loop(integrator, system)
    if model.is_compiled:
        known[integrator] = found
    return found


def model_of(system: System) -> Model:
    """Compile a system's functions (once for all its parameter values), or fall back to the interpreter with a warning.

    ``NONSMOOTH_INTERPRET=1`` asks for the interpreter.
    """
    if os.environ.get("NONSMOOTH_INTERPRET") == "1":
        return _interpreted_model(system)
    try:
        return _compiled_or_by_differences(system)
    except CannotCompile as reason:
        warn_caller(
            f"numba cannot compile the model function {reason}; the same source runs in the interpreter, about a "
            "hundred times slower. Write the function with numbers, math and loops only.",
            InterpretedWarning,
        )
        return _interpreted_model(system)


def _compiled_or_by_differences(system: System) -> Model:
    """Machine code of the functions; where the compiler refuses dual numbers, derived rows are found by differences."""
    shape = (system.n_q, system.n_u, tuple(system.parameter_values), system.unpack)
    key = [(which, function, system.shape(which)) for which, function in system.functions.items()]
    try:
        return _compiled(tuple(key), *shape)
    except CannotCompile:
        if not any(hasattr(function, "by_differences") for _, function, _ in key):
            raise
        rough = [(which, getattr(function, "by_differences", function), size) for which, function, size in key]
        return _compiled(tuple(rough), *shape)


@functools.lru_cache(maxsize=128)
def _compiled(key: tuple, n_q: int, n_u: int, names: tuple[str, ...], unpack: Callable) -> Model:
    announce_first_compile()
    functions = {which: (function, which in TAKES_U, shape) for which, function, shape in key}
    compiled = compile_model(functions, n_q, n_u, unpack, len(names))
    return Model(compiled.address, compiled, True)


def _interpreted_model(system: System) -> Model:
    functions, unpack = system.functions, system.unpack

    def model(which: int, t: float, q: np.ndarray, u: np.ndarray, p: np.ndarray, out: np.ndarray) -> None:
        """What a compiled model does, in Python: clear, unpack the parameters, call."""
        out[...] = 0.0
        if which in TAKES_U:
            functions[which](t, q, u, unpack(*p), out)
        else:
            functions[which](t, q, unpack(*p), out)

    return Model(model, None, False)


@functools.cache
def announce_first_compile() -> None:
    """Say once, on stderr, that the first use on this machine compiles."""
    directory = cache_directory()
    if not directory.exists():
        print(f"nonsmooth: first use, compiling (kept in {directory})", file=sys.stderr)
