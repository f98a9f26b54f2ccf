"""Checks of inputs: once, where they enter; they are trusted afterwards."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from nonsmooth.errors import InvalidInput, NonsmoothError, UnknownName, nearest, said_by, shown

LARGEST_COUNT = 2**62  # chosen: no computer has as many of anything, and int64 holds it
FLOAT = np.dtype(np.float64)
NUMERIC = "biufO"  # kinds of dtype: no texts, no complex numbers, no dates; objects are asked for their float

Vector = np.ndarray
Matrix = np.ndarray


def as_vector(name: str, value: Any, length: int | None = None) -> Vector:
    """A new float64 vector of the given length with finite entries, or `InvalidInput`."""
    vector = as_floats(name, value)
    if vector.ndim == 0 and length == 1:
        vector = vector.reshape(1)
    if vector.ndim != 1:
        raise InvalidInput(f"{name} must be a vector; got shape {vector.shape}")
    if length is not None and len(vector) != length:
        raise InvalidInput(f"{name} must have {length} entries; got {vector.shape[0]}")
    _require_finite(name, vector)
    return vector


def as_square_matrix(name: str, value: Any) -> Matrix:
    """A new C-ordered float64 square matrix with finite entries, or `InvalidInput`."""
    matrix = as_floats(name, value)
    if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1]:
        raise InvalidInput(f"{name} must be a square matrix; got shape {matrix.shape}")
    _require_finite(name, matrix)
    return matrix


def as_array(name: str, value: Any) -> np.ndarray:
    """A new float64 array of any shape with finite entries, or `InvalidInput`."""
    array = as_floats(name, value)
    _require_finite(name, array)
    return array


def as_number(name: str, value: Any, unit: str = "") -> float:
    """A finite float, or `InvalidInput`; a text is no number, nor is an array."""
    if type(value) is float and math.isfinite(value):
        return value  # what follows would take as long as a small problem
    try:
        is_plain = type(value) in (float, int)  # measured: asking NumPy costs 3 us
        if not is_plain and (isinstance(value, str | bytes) or np.ndim(value) > 0 or np.iscomplexobj(value)):
            raise TypeError
        number = float(value)
    except Exception:  # whatever an object raises that is asked for its float
        raise InvalidInput(f"{name} must be a number{_of(unit)}; got {shown(value)}") from None
    if not math.isfinite(number):
        raise InvalidInput(f"{name} must be finite; got {number}")
    return number


def is_number(name: str, value: Any) -> bool:
    """Whether a value is one number and not a list of them; `InvalidInput` for an object that does not say."""
    try:
        return not isinstance(value, Sequence) and np.ndim(value) == 0
    except Exception:  # whatever an object raises that is asked for its array
        raise InvalidInput(f"{name} must be a number or a list of numbers; got {shown(value)}") from None


def as_positive(name: str, value: Any, unit: str = "") -> float:
    """A finite float above zero, or `InvalidInput`."""
    number = as_number(name, value, unit)
    if not number > 0:
        raise InvalidInput(f"{name} must be positive{_of(unit)}; got {number:g}")
    return number


def as_non_negative(name: str, value: Any, unit: str = "") -> float:
    """A finite float not below zero, or `InvalidInput`."""
    number = as_number(name, value, unit)
    if not number >= 0:
        raise InvalidInput(f"{name} must not be negative; got {number:g}{' ' + unit if unit else ''}")
    return number


def as_tolerance(name: str, value: Any) -> float:
    """A relative error above 0 and below 1, or `InvalidInput`: with a larger one anything would pass."""
    number = as_positive(name, value)
    if not number < 1:
        raise InvalidInput(f"{name} must lie in (0, 1), it is a relative error; got {number:g}")
    return number


def as_fraction(name: str, value: Any) -> float:
    """A float in [0, 1], or `InvalidInput`."""
    number = as_number(name, value)
    if not 0 <= number <= 1:
        raise InvalidInput(f"{name} must lie in [0, 1]; got {number:g}")
    return number


def as_count(name: str, value: Any, least: int = 1) -> int:
    """A whole number of at least ``least``, or `InvalidInput`."""
    is_whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
    if not (is_whole and least <= value <= LARGEST_COUNT):
        rule = f"at least {least}{f' and at most {LARGEST_COUNT}' * bool(is_whole and value > least)}"
        raise InvalidInput(f"{name} must be a whole number of {rule}; got {shown(value)}")
    return int(value)


def as_index(name: str, value: Any, length: int) -> int:
    """A whole number from 0 to length - 1, or `InvalidInput`."""
    is_whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
    if not (is_whole and 0 <= value < length):
        rule = f"must be a whole number from 0 to {length - 1}" if length else "has nothing to choose from"
        raise InvalidInput(f"{name} {rule}; got {shown(value)}")
    return int(value)


def as_flag(name: str, value: Any) -> bool:
    """True or False, or `InvalidInput`."""
    if not isinstance(value, bool | np.bool_):
        raise InvalidInput(f"{name} must be True or False; got {shown(value)}")
    return bool(value)


def as_name(what: str, value: Any, known: Iterable[str]) -> str:
    """One of the known names, or `UnknownName` with the nearest of them."""
    if not isinstance(value, str) or value not in known:
        raise UnknownName(f"there is no {what} {shown(value)}; {nearest(value, known)}")
    return value


def as_instance(name: str, value: Any, cls: Any, cure: str) -> Any:
    """An object of a class, or `InvalidInput`; ``cure`` says where such objects come from."""
    if not isinstance(value, cls):
        raise InvalidInput(f"{name} must be {cure}; got {shown(value)}")
    return value


def result_of(name: str, function: Callable, *arguments: Any, **more: Any) -> Any:
    """What a function of the user's returns, or `InvalidInput` with what it raised; Ctrl-C passes."""
    try:
        return function(*arguments, **more)
    except (NonsmoothError, KeyboardInterrupt):
        raise
    except BaseException as error:
        raise InvalidInput(f"{name} raised {said_by(error)}") from error


def as_listed(name: str, value: Any, cure: str) -> list[Any]:
    """The entries of what can be gone through, or `InvalidInput`; a text is one thing."""
    try:
        if isinstance(value, str | bytes):
            raise TypeError
        return list(value)
    except Exception:  # whatever an object raises that is asked for its entries
        raise InvalidInput(f"{name} must be {cure}; got {shown(value)}") from None


def as_floats(name: str, value: Any) -> np.ndarray:
    """A new float64 array of any shape, whose entries may be NaN or infinite, or `InvalidInput`."""
    if type(value) is np.ndarray and value.dtype is FLOAT:
        return value.copy()
    try:
        array = np.asarray(value)
        if array.dtype.kind not in NUMERIC:
            raise TypeError
        return np.array(array, dtype=np.float64, order="C")
    except Exception:  # whatever an object raises that is asked for its array
        raise InvalidInput(f"{name} must be an array of numbers; got {shown(value)}") from None


def _require_finite(name: str, array: np.ndarray) -> None:
    finite = np.isfinite(array)
    if 0 in finite.tobytes():  # a quarter of the time of finite.all() where there are few entries
        index = tuple(int(i) for i in np.argwhere(~finite)[0])
        raise InvalidInput(f"{name} must be finite; {name}{list(index)} is {array[index]}")


def _of(unit: str) -> str:
    return f" [{unit}]" if unit else ""
