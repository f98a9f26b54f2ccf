"""How large, heavy and fast the bodies of a scene may be: so that no product of a step overflows or vanishes.

Lengths from 1e-25 to 1e25 m and masses from 1e-45 to 1e45 kg are more than nature has, from nuclei to galaxies. Moments
of inertia m l^2 then lie within 1e-95 and 1e95, and their determinants, the highest products of a step, within 1e-285
and 1e285. Beyond that squares of impulses were 0 or infinite, and bodies fell through the ground with a residual of 0.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from nonsmooth.checks.arrays import as_non_negative, as_positive
from nonsmooth.errors import InvalidInput

FARTHEST_PLACE = 1e25  # chosen: of lengths, places, velocities and accelerations [m, m/s, m/s^2, rad/s]
HEAVIEST = 1e45  # chosen: of masses [kg]
LARGEST_MOMENT = 1e95  # derived: HEAVIEST FARTHEST_PLACE^2 [kg m^2]
ROUGHEST = 1e12  # chosen: of coefficients of friction: nothing slides long before that


def as_length(name: str, value: Any) -> float:
    """A positive number of metres, or `InvalidInput`."""
    return require_between(name, as_positive(name, value, "m"), FARTHEST_PLACE, "m")


def as_mass(name: str, value: Any) -> float:
    """A positive number of kilograms, or `InvalidInput`."""
    return require_between(name, as_positive(name, value, "kg"), HEAVIEST, "kg")


def as_friction(name: str, value: Any) -> float:
    """A coefficient of friction, or `InvalidInput`."""
    mu = as_non_negative(name, value)
    if mu > ROUGHEST:
        raise InvalidInput(f"{name} must be at most {ROUGHEST:g}; got {mu:g}")
    return mu


def require_between(name: str, value: float, largest: float, unit: str) -> float:
    """The value, or `InvalidInput` where it is more than the largest, or less than its inverse."""
    if not 1.0 / largest <= value <= largest:
        raise InvalidInput(f"{name} must lie within {1.0 / largest:g} and {largest:g} {unit}; got {value:g}")
    return value


def require_within(name: str, values: Any, unit: str) -> Any:
    """The values, or `InvalidInput` where one is larger than any place or velocity may be."""
    largest = float(np.abs(values).max(initial=0.0))
    if not largest <= FARTHEST_PLACE:
        raise InvalidInput(
            f"{name} must not be larger than {FARTHEST_PLACE:g} {unit}; its largest entry is {largest:g}"
        )
    return values
