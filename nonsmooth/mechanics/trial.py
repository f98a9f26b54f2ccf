"""A trial of the model functions: each is called in Python before compiled code calls it without asking.

Machine code does not notice an index out of range, an argument that is written to, or a function that keeps a state of
its own; it does as it is told, in the memory of others.
"""

from __future__ import annotations

import dis
import functools
import math
import weakref
from collections.abc import Callable

import numpy as np

from nonsmooth.errors import InvalidInput, said_by
from nonsmooth.jit import cache_directory
from nonsmooth.jit.content import Glance
from nonsmooth.mechanics.agreement import DIFFERENCE_STEPS, generic_direction
from nonsmooth.mechanics.compiled import Model
from nonsmooth.mechanics.returned import shape_fault
from nonsmooth.mechanics.system import GAP, GIVEN_FORCE, TAKES_U, TANGENT, System

# chosen: numbers on either side of the array: an index out of range is mostly out by one, or by a row
GUARD_NUMBERS = 8
GUARD = -6.02214076e-133  # code: what stands there; no model function writes it by chance
GUARDS = np.full(GUARD_NUMBERS, GUARD).tobytes()
# derived: of the largest entry: sin and cos of two libraries differ by 1e-16, which may cancel to 1e-12
SAME_CODE = 1e-6

# Systems whose functions have been called, with the machine code that they had then.
_tried: weakref.WeakKeyDictionary[System, Model | None] = weakref.WeakKeyDictionary()


def try_functions(system: System, t: float, q: np.ndarray, u: np.ndarray, model: Model | None = None) -> None:
    """Call every function of a system in Python, once for each system and again where its machine code is new.

    Raises
    ------
    InvalidInput
        For a function that raises, as at an index out of range; the message names it.
    """
    if system in _tried and (model is None or not model.is_compiled or _tried[system] is model):
        return
    q, u = q.copy(), u.copy()
    with np.errstate(all="ignore"):
        for which in system.functions:
            try:
                require_returned_shape(system, which, t, q, u)
                system.call(which, t, q, u, np.zeros(system.shape_of(which)))
            except InvalidInput:
                raise
            except ArithmeticError:  # 1/0 is inf in compiled code
                continue
            except Exception as error:
                raise InvalidInput(
                    f"the model function {system.name_of(which)} raised {said_by(error)}, at t = {t:g} s; it "
                    f"writes an array of shape {system.shape_of(which)}"
                ) from error
    _tried[system] = model


def require_returned_shape(system: System, which: int, t: float, q: np.ndarray, u: np.ndarray) -> None:
    """Raise `InvalidInput` for a function that returns an array of another shape than is needed."""
    function = getattr(system.functions[which], "returned_from", None)
    if function is not None:
        values = function(t, q, u, system.unpacked) if which in TAKES_U else function(t, q, system.unpacked)
        if fault := shape_fault(values, system.shape_of(which)):
            raise InvalidInput(f"the model function {system.name_of(which)} {fault}")


def require_manners(system: System, t: float, q: np.ndarray, u: np.ndarray) -> None:
    """Call every function with guards about its array, and again.

    Raises
    ------
    InvalidInput
        For a function that writes beyond its array or into its arguments, writes nothing of what it found, or writes
        something else when it is called again; the message names it.
    """
    with np.errstate(all="ignore"):
        for which in system.functions:
            try:
                fault = fault_of(system, which, t, q, u)
            except Exception:  # it was tried: 1/0, or a function that raises now and then, which is named when it does
                continue
            if fault:
                raise InvalidInput(f"the model function {system.name_of(which)} {fault}")
        _require_all_contacts(system, t, q, u)


def _require_all_contacts(system: System, t: float, q: np.ndarray, u: np.ndarray) -> None:
    """Raise for a contact that gap, or while it is closed tangent, writes nothing for: it would be closed for ever, or
    without friction."""
    for which in {GAP, TANGENT} & system.functions.keys() if system.n_c else ():
        out = np.full(system.shape_of(which), GUARD)
        try:
            system.call(which, t, q.copy(), u.copy(), out)
            gaps = system.evaluate(GAP, t, q, u) if GAP in system.functions else np.zeros(system.n_c)
        except Exception:  # whoever needs its value says so
            continue
        has_gap = system.kinds[:, 0] != GIVEN_FORCE
        is_needed = has_gap if which == GAP else (system.kinds[:, 1] > 0) & ~(has_gap & (gaps > 0))
        idle = is_needed & (out.reshape(system.n_c, -1) == GUARD).all(axis=1)
        _require_both_rows(system, which, is_needed & ~idle, out)
        if idle.any():
            name = system.described.contacts[int(idle.argmax())]
            raise InvalidInput(
                f"the model function {system.name_of(which)} writes nothing for {name}; the system has "
                f"{system.n_c} contacts: write its entry, also where it is zero, or list fewer contacts"
            )


def _require_both_rows(system: System, which: int, is_written: np.ndarray, out: np.ndarray) -> None:
    """Raise for a contact with two directions of friction of which ``tangent`` writes one: it would be smooth along the
    other."""
    if which != TANGENT or system.d < 2:
        return
    half = (out == GUARD).all(axis=2).any(axis=1) & (system.kinds[:, 1] == 2) & is_written
    if half.any():
        i = int(half.argmax())
        raise InvalidInput(
            f"the model function tangent writes one row for {system.described.contacts[i]}, which has directions=2: "
            f"write W_F[{i}, 0, :] and W_F[{i}, 1, :]"
        )


def require_same_code(system: System, model: Model, t: float, q: np.ndarray, u: np.ndarray) -> None:
    """Hold the machine code of every function against its source, near a state.

    At the state itself much may cancel, a gap that is closed to nothing but rounding; a step away it does not. Helpers
    that numba compiled are no source: Python calls their machine code, which may be older than the values they read.

    Raises
    ------
    InvalidInput
        For a function whose machine code writes other numbers than its source; the message names it.
    """
    if not model.is_compiled:
        return
    q, u = q + DIFFERENCE_STEPS[0] * generic_direction(q.size), u + DIFFERENCE_STEPS[0] * generic_direction(u.size)
    places = [given.ctypes.data for given in (q, u, system.p)]
    with np.errstate(all="ignore"):
        for which, function in system.functions.items():
            if Glance(function).meets_compiled:
                continue
            written, found = np.zeros(system.shape_of(which)), np.zeros(math.prod(system.shape_of(which)))
            try:
                system.call(which, t, q, u, written)
            except Exception:  # it is defined at the state only
                continue
            is_done = model.call(which, t, *places, found.ctypes.data)
            written = written.ravel()
            other = np.abs(found - written) > SAME_CODE * np.abs(written).max(initial=0.0)
            if is_done and other.any():
                k = int(other.argmax())
                raise InvalidInput(
                    f"the machine code of the model function {system.name_of(which)} writes {found[k]:.9g} where its "
                    f"source writes {written[k]:.9g}, near t = {t:g} s: it is not the code of this source; delete "
                    f"{cache_directory()}, or set NONSMOOTH_INTERPRET=1, which runs the source"
                )


def fault_of(system: System, which: int, t: float, q: np.ndarray, u: np.ndarray) -> str:
    """What is wrong with one function at a state, the rest of a sentence that begins with its name; else empty."""
    shape, q_1, u_1 = system.shape_of(which), q.copy(), u.copy()
    room = np.zeros(math.prod(shape) + 2 * GUARD_NUMBERS)
    room[:GUARD_NUMBERS] = room[-GUARD_NUMBERS:] = GUARD
    out, again = room[GUARD_NUMBERS:-GUARD_NUMBERS].reshape(shape), np.zeros(shape)
    answer = system.call(which, t, q_1, u_1, out)
    first = out.tobytes()
    for name, given, kept in (("q", q, q_1), ("u", u, u_1)):
        if given.tobytes() != kept.tobytes():
            return f"writes into {name}, which it may only read; it writes its last argument alone"
    if room[:GUARD_NUMBERS].tobytes() != GUARDS or room[-GUARD_NUMBERS:].tobytes() != GUARDS:
        return f"writes beyond its array of shape {shape}; check its indices"
    system.call(which, t, q_1, u_1, again)
    if again.tobytes() != first:
        entry = int(np.flatnonzero(out.ravel().view(np.int64) != again.ravel().view(np.int64))[0])
        return (
            f"writes {out.ravel()[entry]:.17g} when it is called first and {again.ravel()[entry]:.17g} when it is "
            "called again with the same arguments; it must keep no state and draw no random numbers"
        )
    return "" if out.any() else nothing_written(system, which, t, q_1, u_1, answer is not None)


def nothing_written(system: System, which: int, t: float, q: np.ndarray, u: np.ndarray, has_answer: bool) -> str:
    """Whether a function that wrote zeros wrote anything, where it looks as if it meant to."""
    function, shape = system.functions[which], system.shape_of(which)
    name = last_argument(function)
    if not has_answer and (name is None or not assigns(function, name)):
        return ""
    out = np.full(shape, GUARD)
    system.call(which, t, q, u, out)
    if (out != GUARD).any():
        return ""
    if has_answer:
        return (
            f"returns its values; it must write them into its last argument, an array of shape {shape}, or be defined "
            f"without that argument"
        )
    return (
        f"assigns {name} anew, which leaves the array as it was; write into it, as {name}[:] = ... does: it has the "
        f"shape {shape}"
    )


def last_argument(function: Callable) -> str | None:
    """The name of the argument that a function writes into, where its code is known."""
    code = getattr(function, "__code__", None)
    return code.co_varnames[code.co_argcount - 1] if code is not None and code.co_argcount else None


@functools.lru_cache(maxsize=512)
def assigns(function: Callable, name: str) -> bool:
    """Whether a function's code binds a local name anew."""
    return any(
        instruction.opname.startswith("STORE_FAST") and name in str(instruction.argrepr).replace(",", " ").split()
        for instruction in dis.get_instructions(function)
    )
