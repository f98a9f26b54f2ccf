"""A wheel of spokes without a rim, that walks down a slope: the simplest passive walker.

    pivots about a foot:    w_b^2 = w_a^2 + 4 g l sin(slope) sin(alpha)/(J + l^2),    alpha = pi/n,  J = I/m
    the next foot lands:    w_a = eta w_b,    eta = (J + l^2 cos 2 alpha)/(J + l^2)

from just after one landing to just before the next, and through it: angular momentum about the foot that lands is kept.
Its gait tends to w_b^2 = 4 g l sin(slope) sin(alpha)/((J + l^2)(1 - eta^2)), in which each step loses what it falls by;
it needs w_a^2 (J + l^2)/2 >= g l (1 - cos(alpha - slope)) to pass over its foot.
Source: McGeer, *Int. J. Robotics Research* 9 (1990) 62; Coleman, Chatterjee, Ruina, *Dyn. Stab. Syst.* 12 (1997) 139.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_count, as_non_negative, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import HalfPlane, Polygon

STEEPEST = 0.5 * math.pi  # derived: a wall


@dataclass(frozen=True)
class RimlessWheel:
    """A wheel whose feet are the corners of a polygon: bodies "ground" and "wheel"; x points down the slope.

    Parameters
    ----------
    n : int
        Spokes, 4 or more.
    l : float
        Their length [m].
    m : float
        Mass [kg].
    J : float
        Inertia over mass [m^2].
    slope : float
        Of the ground [rad].
    rate : float
        Rate at which it rolls at the start, two feet on the ground [rad/s].
    mu : float
        Friction coefficient: with enough of it no foot slips.
    g : float
        Gravity [m/s^2].

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from nonsmooth.catalogue import RimlessWheel
    >>> wheel = RimlessWheel()
    >>> round(wheel.gait(), 4), round(wheel.least_rate(), 4)
    (2.608, 0.9832)
    """

    n: int = 8  # spokes [-]
    l: float = 0.5  # their length [m]
    m: float = 1.0  # mass [kg]
    J: float = 0.125  # inertia over mass [m^2]
    slope: float = 0.12  # of the ground [rad]
    rate: float = 4.0  # at the start [rad/s]
    mu: float = 1.0  # friction [-]
    g: float = 9.81  # gravity [m/s^2]

    name = "rimless-wheel"
    source = "McGeer, Int. J. Robotics Research 9 (1990) 62"
    t_end = 4.0  # s
    dt = 5e-4  # s

    def __post_init__(self) -> None:
        if as_count("n", self.n) < 4:
            raise InvalidInput(f"n must be 4 or more, so that it can roll; got {self.n}")
        for name, unit in (("l", "m"), ("m", "kg"), ("J", "m^2"), ("g", "m/s^2")):
            as_positive(name, getattr(self, name), unit)
        for name, unit in (("rate", "rad/s"), ("mu", ""), ("slope", "rad")):
            as_non_negative(name, getattr(self, name), unit)
        if self.slope >= STEEPEST:
            raise InvalidInput(f"slope must be below pi/2 rad; got {self.slope:g}")

    @property
    def alpha(self) -> float:
        """Half the angle between two spokes [rad]."""
        return math.pi / self.n

    def scene(self) -> Scene:
        """The wheel on two feet, about to turn about the one in front."""
        down = self.g * math.sin(self.slope), -self.g * math.cos(self.slope)
        scene = Scene(gravity=down, material=Material(mu=self.mu))
        scene.fixed(HalfPlane((0.0, 1.0)), name="ground")
        angles = -0.5 * math.pi + self.alpha * (2 * np.arange(self.n) + 1)
        feet = self.l * np.column_stack((np.cos(angles), np.sin(angles)))
        high, ahead = self.l * math.cos(self.alpha), self.l * math.sin(self.alpha)
        scene.body(
            Polygon(feet), mass=self.m, inertia=self.m * self.J, position=(0.0, high), spin=-self.rate,
            velocity=(self.rate * high, self.rate * ahead), name="wheel",
        )  # fmt: skip
        return scene

    def kept(self) -> float:
        """eta, the part of its rate that a landing leaves."""
        return (self.J + self.l**2 * math.cos(2 * self.alpha)) / (self.J + self.l**2)

    def gain(self) -> float:
        """What a step adds to the square of the rate [rad^2/s^2]."""
        return 4 * self.g * self.l * math.sin(self.slope) * math.sin(self.alpha) / (self.J + self.l**2)

    def gait(self) -> float:
        """The rate to which it tends, before a landing [rad/s]."""
        return math.sqrt(self.gain() / (1 - self.kept() ** 2))

    def least_rate(self) -> float:
        """With which it just passes over its foot [rad/s]; 0 where the slope is steeper than alpha."""
        rise = self.l * (1 - math.cos(max(0.0, self.alpha - self.slope)))
        return math.sqrt(2 * self.g * rise / (self.J + self.l**2))
