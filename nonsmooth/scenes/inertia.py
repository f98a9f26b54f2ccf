"""Mass, centre and principal moments of a body, from its shape and its density or mass."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.checks.arrays import as_floats, as_positive, as_vector
from nonsmooth.errors import InvalidInput, shown
from nonsmooth.numerics.rounding import EPS
from nonsmooth.scenes.elements import Body
from nonsmooth.scenes.mass_properties import Mass, combined, mass_of
from nonsmooth.scenes.parts import parts_of
from nonsmooth.scenes.places import ORIGIN, quaternion_of
from nonsmooth.scenes.ranges import HEAVIEST, LARGEST_MOMENT, require_between
from nonsmooth.scenes.shapes import PLANAR, Shape

SHAPES_AT_HAND = 256  # chosen: shapes whose mass properties are kept: many bodies have the same
MOMENT_ROUNDINGS = 64  # chosen: of moments that are sums over parts: what differs by less is equal


class Inertia(NamedTuple):
    """Of a body."""

    mass: float  # [kg]
    centre: np.ndarray  # (2|3,) in the shape's frame [m]
    axes: float | np.ndarray  # of the principal axes in the shape's frame: 0, or a unit quaternion
    moments: np.ndarray  # (1|3,) about them [kg m^2]


def inertia_of(body: Body, dim: int) -> Inertia:
    """The inertia of a body.

    Raises
    ------
    InvalidInput
        When the shape has no volume, and for a mass or a moment that is out of range.
    """
    whole = mass_of_shape(body.shape, dim)
    if whole is None:
        raise InvalidInput(f"{body.name} has a shape without volume, {body.shape!r}; round it, or fix the body")
    mass = body.density * whole.mass if body.density is not None else float(body.mass)  # type: ignore[arg-type]
    require_between(f"mass of {body.name}", mass, HEAVIEST, "kg")
    if body.inertia is None:
        tensor, axes, moments = spread_evenly(body.shape, dim, mass)
    else:
        tensor = np.atleast_2d(body.inertia)
        axes, moments = principal_axes(tensor)
    for moment in tensor.diagonal().tolist():
        require_between(f"moment of inertia of {body.name}", moment, LARGEST_MOMENT, "kg m^2")
    return Inertia(mass, whole.centroid if body.centre is None else body.centre, axes, moments)


@lru_cache(SHAPES_AT_HAND)
def mass_of_shape(shape: Shape, dim: int) -> Mass | None:
    """The mass properties of a shape of density 1, in its own frame; None of one without volume."""
    parts = [mass_of(part.row(0, ORIGIN[dim]), 1.0) for part in parts_of(shape, dim)]
    return combined(parts) if sum(part.mass for part in parts) > 0 else None


@lru_cache(SHAPES_AT_HAND)
def spread_evenly(shape: Shape, dim: int, mass: float) -> tuple[np.ndarray, Any, np.ndarray]:
    """The tensor of inertia of a mass that is spread evenly over a shape, its principal axes and moments."""
    whole = mass_of_shape(shape, dim)
    assert whole is not None
    tensor = mass / whole.mass * whole.inertia
    return tensor, *principal_axes(tensor)


def principal_axes(tensor: np.ndarray) -> tuple[Any, np.ndarray]:
    """The turn of the principal axes, and the moments (1|3,): axes that are principal already stay as they are."""
    if len(tensor) == 1:
        return 0.0, tensor[0]
    off = np.abs(tensor - np.diag(np.diag(tensor))).max()
    if off <= MOMENT_ROUNDINGS * EPS * np.abs(tensor).max():
        moments = np.diag(tensor).copy()
        if np.ptp(moments) <= MOMENT_ROUNDINGS * EPS * moments.max():  # a cube, a ball: no turn changes the moments
            moments[:] = moments.mean()
        return np.array([1.0, 0.0, 0.0, 0.0]), moments
    moments, axes = np.linalg.eigh(tensor)
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    return quaternion_of(axes), moments


def as_inertia(name: str, value: Any, dim: int) -> Any:
    """A moment of inertia, or a symmetric positive definite matrix of them; three numbers are its diagonal."""
    if dim == PLANAR:
        return as_positive(name, value, "kg m^2")
    matrix = as_floats(name, value)
    if matrix.ndim == 1:
        matrix = np.diag(as_vector(name, value, 3))
    if matrix.shape != (3, 3) or not np.isfinite(matrix).all() or not np.allclose(matrix, matrix.T, rtol=1e-12):
        raise InvalidInput(f"{name} must be three moments or a symmetric (3, 3) matrix [kg m^2]; got {shown(value)}")
    moments = np.linalg.eigvalsh(matrix)
    if not moments[0] > 0:
        raise InvalidInput(f"{name} must be positive definite; its smallest moment is {moments[0]:g} kg m^2")
    if moments[2] > (moments[0] + moments[1]) * (1 + 1e-9):
        raise InvalidInput(
            f"{name} is that of no body: the largest moment must not exceed the sum of the others; they are "
            f"{np.array2string(moments, precision=4)} kg m^2"
        )
    return matrix
