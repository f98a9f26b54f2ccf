"""A tippe-top: a spinning ball whose centre of mass lies below its middle turns over by friction, and rises.

It is made of a large ball and a small one in it, whose masses add. With e the distance of the centre of mass from the
middle, of the radius, and moments A (across) and C, it turns over wholly from a fast spin for

    1 - e < A/C < 1 + e

and keeps, whatever friction does, Jellett's integral, L . (vector from the point of contact to the centre of mass). As
long as the contact slides, that is: one that sticks does no work, and a top that was spun about its own slanted axis
rolls away upright. It is spun about the vertical here.
Source: Cohen, *Am. J. Phys.* 45 (1977) 12-17; Rauch-Wojciechowski, Skoldstam and Glad, *Regul. Chaotic Dyn.* 10 (2005)
333-362.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_number, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Compound, HalfSpace, Sphere


@dataclass(frozen=True)
class TippeTop:
    """A ball with a smaller one in it, below its middle at the start: body "top".

    Parameters
    ----------
    r : float
        Radius of the large ball [m].
    inner, below : float
        Radius of the small ball and how far below the middle it is, of r.
    density : float
        Of each ball [kg/m^3].
    tilt : float
        Of its axis from the vertical, at the start [rad].
    spin : float
        About the vertical, at the start [rad/s].
    mu : float
        Friction coefficient.
    g : float
        Gravity [m/s^2].

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from nonsmooth.catalogue import TippeTop
    >>> top = TippeTop()
    >>> top.turns_over(), round(top.eccentricity(), 4)
    (True, 0.0715)
    """

    r: float = 0.02  # [m]
    inner: float = 0.7  # [-]
    below: float = 0.28  # [-]
    density: float = 1000.0  # [kg/m^3]
    tilt: float = 0.3  # [rad]
    spin: float = 200.0  # [rad/s]
    mu: float = 0.3  # friction [-]
    g: float = 9.81  # gravity [m/s^2]

    name = "tippe-top"
    source = "Cohen, Am. J. Phys. 45 (1977) 12-17"
    t_end = 2.0  # s
    dt = 2e-4  # s

    def __post_init__(self) -> None:
        for name, unit in (("r", "m"), ("inner", ""), ("below", ""), ("density", "kg/m^3"), ("mu", ""), ("g", "m/s^2")):
            as_positive(name, getattr(self, name), unit)
        if not self.inner + self.below < 1:
            reach = self.inner + self.below
            raise InvalidInput(f"inner + below must be less than 1: the small ball is in the large one; got {reach:g}")
        as_number("tilt", self.tilt, "rad")
        as_number("spin", self.spin, "rad/s")

    def scene(self) -> Scene:
        """The top on the ground, spinning about the vertical through its centre of mass, which is at rest."""
        scene = Scene(gravity=(0.0, 0.0, -self.g), material=Material(mu=self.mu))
        scene.fixed(HalfSpace((0, 0, 1)), name="ground")
        r = self.r
        shape = Compound((Sphere(r), (0, 0, 0)), (Sphere(self.inner * r), (0, 0, -self.below * r)))
        turn = (math.cos(0.5 * self.tilt), 0.0, math.sin(0.5 * self.tilt), 0.0)
        scene.body(shape, density=self.density, position=(0, 0, r), turn=turn, spin=(0, 0, self.spin), name="top")
        return scene

    def eccentricity(self) -> float:
        """Of the centre of mass, of r."""
        cube = self.inner**3
        return self.below * cube / (1 + cube)

    def moments(self) -> tuple[float, float]:
        """A, about the centre of mass across the axis, and C about the axis [kg m^2]."""
        mass, cube = self.density * 4 / 3 * math.pi * self.r**3, self.inner**3
        along = 0.4 * (1 + cube * self.inner**2)
        across = along + cube / (1 + cube) * self.below**2
        return mass * self.r**2 * across, mass * self.r**2 * along

    def axis(self, turn: np.ndarray) -> np.ndarray:
        """Of the top in the world (..., 3), from its middle away from the small ball, for turns (..., 4)."""
        w, x, y, z = np.moveaxis(turn, -1, 0)
        return np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=-1)

    def jellett(self, turn: np.ndarray, spin: np.ndarray) -> np.ndarray:
        """Jellett's integral [J s m] for turns (..., 4) and angular velocities in the world (..., 3)."""
        A, C = self.moments()
        axis = self.axis(turn)
        momentum = A * spin + (C - A) * (spin * axis).sum(axis=-1, keepdims=True) * axis
        return (momentum * (np.array([0, 0, 1.0]) - self.eccentricity() * axis)).sum(axis=-1) * self.r

    def turns_over(self) -> bool:
        """Whether a fast spin turns it over wholly."""
        A, C = self.moments()
        return abs(A / C - 1) < self.eccentricity()
