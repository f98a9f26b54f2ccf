"""Friction laws of the user's: from mu(v, p), a Python function, to the two numbers in the row of laws of its contact.

    row = [code, handle, address of p]

The handle is the address of the machine code, or below zero where there is none: then everything runs in the
interpreter. The parameters are found where the run has them, so that a sweep compiles nothing anew.
"""

from __future__ import annotations

import functools
import math
import os
from collections.abc import Callable
from typing import Any

import numpy as np

from nonsmooth.errors import InvalidInput, said_by
from nonsmooth.jit import CannotCompile, Unpack, call_law
from nonsmooth.jit.own_law import LAWS, KnownLaw, numbers_at
from nonsmooth.mechanics.laws import LAW_C, LAW_CODE, OWN, Friction
from nonsmooth.mechanics.shelf import Same, Shelf
from nonsmooth.mechanics.signatures import takes
from nonsmooth.numerics.complex_step import complexified

LAW_P = LAW_C + 1  # code: column of the address of the parameters, behind that of the handle
LARGEST_ADDRESS = 2**53  # defined: by float64, which holds whole numbers up to it


def own_laws(contacts: Any) -> dict[int, Friction]:
    """The contacts that have a law of the user's, by number."""
    return {i: contact.law for i, contact in enumerate(contacts) if isinstance(contact.law, Friction)}


def write_handles(laws: np.ndarray, found: dict[int, Friction], unpack: Unpack, p: np.ndarray) -> None:
    """Write code and parameters, p (..., n_p), of the users' laws into the rows (..., n_c, LAW_WIDTH)."""
    for i, law in found.items():
        laws[..., i, LAW_C] = handle_of_law(law.function, unpack)
    point_to(laws, p)


def point_to(laws: np.ndarray, p: np.ndarray) -> None:
    """Let the users' laws find their parameters in p (..., n_p), for rows of laws (..., n_c, LAW_WIDTH)."""
    own = laws[..., LAW_CODE] == OWN
    if own.any():
        first = p.ctypes.data + p.strides[0] * np.arange(len(p))[:, None] if p.ndim == 2 else p.ctypes.data
        laws[..., LAW_P] = np.where(own, first, laws[..., LAW_P])


def handle_of_law(function: Callable, unpack: Unpack) -> int:
    """By what kernels call a law; below zero for the interpreter alone."""
    if os.environ.get("NONSMOOTH_INTERPRET") == "1":
        return _interpreted_handle(Same(function), unpack)
    try:
        model = _shelf(Same(function), unpack).model()
    except CannotCompile:
        return _interpreted_handle(Same(function), unpack)
    handle = int(model.handle)
    assert handle < LARGEST_ADDRESS
    LAWS.setdefault(handle, KnownLaw(_of_two(Same(function)), unpack, model))
    return handle


def require_compiled_laws(system: Any) -> None:
    """Raise `CannotCompile` where numba refuses a law: the system runs in the interpreter then."""
    for law in own_laws(system.contacts).values():
        _shelf(Same(law.function), system.unpack).model()


def require_values(system: Any) -> None:
    """Raise `InvalidInput` unless the users' laws can be called, and mu(0) is a number >= 0."""
    for i, law in own_laws(system.contacts).items():
        name = system.contacts[i].name or f"contact {i}"
        try:
            value = float(_of_two(Same(law.function))(0.0, system.unpacked))
        except Exception as error:
            raise InvalidInput(f"the friction law of {name} raised {said_by(error)} at v = 0; it is called as mu(v, p) "
                               "with the speed [m/s] and the parameters, and returns a number") from error  # fmt: skip
        if not (math.isfinite(value) and value >= 0.0):
            raise InvalidInput(f"the friction law of {name} must be a finite number >= 0; got mu(0) = {value:g}")


def find_fault(system: Any, speed: float) -> str:
    """Where a law of the user's is negative or no number up to a speed [m/s], in a sentence; nothing if it is not."""
    for i, law in own_laws(system.contacts).items():
        for v in np.linspace(0.0, speed, SPEEDS_TRIED).tolist():
            try:
                value = float(_of_two(Same(law.function))(v, system.unpacked))
            except Exception as error:
                return f"the friction law of {system.described.contacts[i]} raised {said_by(error)} at v = {v:g} m/s"
            if not (math.isfinite(value) and value >= 0.0):
                return (
                    f"the friction law of {system.described.contacts[i]} is {value:g} at v = {v:g} m/s; "
                    "it must be a finite number >= 0"
                )
    return ""


SPEEDS_TRIED = 65  # chosen: from rest to the fastest speed of a run, where a law is looked for its fault


@functools.lru_cache(maxsize=128)
def _shelf(law: Same, unpack: Unpack) -> Shelf:
    return Shelf({0: (_written(law), False, (1,))}, 1, 1, unpack, unpack.size)


@functools.lru_cache(maxsize=128)
def _interpreted_handle(law: Same, unpack: Unpack) -> int:
    handle = -1 - len(LAWS)
    LAWS[handle] = KnownLaw(_of_two(law), unpack, None)
    return handle


@functools.lru_cache(maxsize=128)
def _of_two(law: Same) -> Callable:
    """The law as a function of v and p."""
    function: Any = getattr(law.function, "py_func", law.function)
    return function if takes(function, ("v", "p")) else lambda v, p: function(v)


@functools.lru_cache(maxsize=128)
def _written(law: Same) -> Callable:
    """The law as a model function that writes, with v in the place of the time."""
    function: Any = getattr(law.function, "py_func", law.function)
    if takes(function, ("v", "p")):

        def written(t, q, p, out):  # type: ignore[no-untyped-def]
            out[0] = function(t, p)
    else:

        def written(t, q, p, out):  # type: ignore[no-untyped-def]
            out[0] = function(t)

    written.__name__ = getattr(function, "__name__", "mu")
    return written


def _continued(handle: int, p: int, v: Any) -> Any:
    """A law of a complex speed, for derivatives."""
    law = LAWS[handle]
    return complexified(law.function)(v, numbers_at(p, law.unpack))


call_law.continuation = _continued
