"""Border checks: inputs are checked once, where they enter, and trusted afterwards."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from nonsmooth.errors import InvalidInput

Vector = np.ndarray
Matrix = np.ndarray


def as_vector(name: str, value: Any, length: int | None = None) -> Vector:
    """A new float64 vector of the given length with finite entries, or `InvalidInput`."""
    vector = _as_float_array(name, value)
    if vector.ndim == 0 and length == 1:
        vector = vector.reshape(1)
    if vector.ndim != 1:
        raise InvalidInput(f"{name} must be a vector; got shape {vector.shape}")
    if length is not None and vector.shape != (length,):
        raise InvalidInput(f"{name} must have {length} entries; got {vector.shape[0]}")
    _require_finite(name, vector)
    return vector


def as_square_matrix(name: str, value: Any) -> Matrix:
    """A new C-ordered float64 square matrix with finite entries, or `InvalidInput`."""
    matrix = _as_float_array(name, value)
    if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1]:
        raise InvalidInput(f"{name} must be a square matrix; got shape {matrix.shape}")
    _require_finite(name, matrix)
    return matrix


def as_number(name: str, value: Any, unit: str = "") -> float:
    """A finite float, or `InvalidInput`."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise InvalidInput(f"{name} must be a number{_of(unit)}; got {value!r}") from None
    if not math.isfinite(number):
        raise InvalidInput(f"{name} must be finite; got {number}")
    return number


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


def as_fraction(name: str, value: Any) -> float:
    """A float in [0, 1], or `InvalidInput`."""
    number = as_number(name, value)
    if not 0 <= number <= 1:
        raise InvalidInput(f"{name} must lie in [0, 1]; got {number:g}")
    return number


def as_count(name: str, value: Any) -> int:
    """A whole number of at least one, or `InvalidInput`."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < 1:
        raise InvalidInput(f"{name} must be a whole number of at least 1; got {value!r}")
    return int(value)


def _as_float_array(name: str, value: Any) -> np.ndarray:
    try:
        return np.array(value, dtype=np.float64, order="C")
    except (TypeError, ValueError):
        raise InvalidInput(f"{name} must be an array of numbers; got {value!r}") from None


def _require_finite(name: str, array: np.ndarray) -> None:
    finite = np.isfinite(array)
    if not finite.all():
        index = tuple(int(i) for i in np.argwhere(~finite)[0])
        raise InvalidInput(f"{name} must be finite; {name}{list(index)} is {array[index]}")


def _of(unit: str) -> str:
    return f" [{unit}]" if unit else ""
