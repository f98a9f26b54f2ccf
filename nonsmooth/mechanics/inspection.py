"""When the functions of a system are tried and held against one another.

They are called once at the first state of every system. They are tried thoroughly and held against one another at the
first, second, fourth, eighth, ... start of systems of one class; they are held against one another at as many ends, and
on the way wherever Python has the run in its hands, by the modes of the contacts: at the first, second, fourth, ...
time that the contacts are found so. Systems are of one class if they have the same functions and kinds of contact, and
parameters of the same signs: a term that a parameter switches on is seen. A run that failed is looked at in any case.
"""

from __future__ import annotations

import functools
import weakref
from collections import Counter

import numpy as np

from nonsmooth.errors import InvalidInput, NonsmoothWarning, warn_caller
from nonsmooth.mechanics.agreement import contradiction, doubt_of_potential
from nonsmooth.mechanics.compiled import Model
from nonsmooth.mechanics.system import System
from nonsmooth.mechanics.trial import require_manners, require_same_code, try_functions

START, INSTANT, END = b"start", b"instant", b"end"

_looks: weakref.WeakKeyDictionary[System, Counter[bytes]] = weakref.WeakKeyDictionary()


def inspect_start(system: System, t: float, q: np.ndarray, u: np.ndarray, model: Model | None = None) -> None:
    """Try the functions of a system and hold them, and their machine code, against one another if it is time to.

    Raises
    ------
    InvalidInput
        For a function that cannot be right; the message names it.
    """
    _inspect(system, t, q, u, model, is_instant=False)


def inspect_instant(system: System, t: float, q: np.ndarray, u: np.ndarray, model: Model | None = None) -> None:
    """The same where no motion follows."""
    _inspect(system, t, q, u, model, is_instant=True)


def _inspect(system: System, t: float, q: np.ndarray, u: np.ndarray, model: Model | None, is_instant: bool) -> None:
    if not is_due(system, INSTANT if is_instant else START):
        try_functions(system, t, q, u, model)
        return
    try:
        require_manners(system, t, q, u)
        try_functions(system, t, q, u, model)
        if model is not None:
            require_same_code(system, model, t, q, u)
    except InvalidInput:
        forget_looks(system)
        raise
    said = found_contradiction(system, t, q, u, is_instant)
    if said:
        raise InvalidInput(said)
    doubt = doubt_of_potential(system, t, q, u)
    if doubt:
        warn_caller(doubt, NonsmoothWarning)


def found_contradiction(system: System, t: float, q: np.ndarray, u: np.ndarray, is_instant: bool = False) -> str:
    """A sentence on functions that contradict one another, or nothing."""
    said = contradiction(system, t, q, u, is_instant)
    if said:
        forget_looks(system)
    return said


def forget_looks(system: System) -> None:
    """Begin anew with a class of systems of which one was refused: so is the next."""
    looks_of(system).clear()


def is_due(system: System, occasion: bytes) -> bool:
    """Whether a system is looked at on this occasion: at the first, second, fourth, eighth, ... time of its class."""
    looks = looks_of(system)
    looks[occasion] += 1
    return not looks[occasion] & (looks[occasion] - 1)


def looks_of(system: System) -> Counter[bytes]:
    """How often systems of this one's class came by, by occasion."""
    looks = _looks.get(system)
    if looks is None:
        signs = np.sign(system.p).tobytes()
        looks = _looks[system] = _of_class(tuple(system.functions.items()), system.kinds.tobytes(), signs)
    return looks


@functools.lru_cache(maxsize=256)
def _of_class(functions: tuple, kinds: bytes, signs: bytes) -> Counter[bytes]:
    return Counter()
