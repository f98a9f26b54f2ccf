"""A ball on a turntable.

A homogeneous ball that rolls on a table turning at Omega moves on a circle, wherever and however it was put there, at

    2 Omega/7,    v' = (2/7) Omega x v

Source: Routh, *Dynamics of a System of Rigid Bodies*, advanced part (1905), art. 249; Weltner, *Am. J. Phys.* 47 (1979)
984-986.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_non_negative, as_number, as_positive
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import HalfSpace, Sphere


@dataclass(frozen=True)
class Turntable:
    """A ball that rolls on a turning table: bodies "table" and "ball".

    Parameters
    ----------
    Omega : float
        Angular velocity of the table [rad/s].
    r : float
        Radius of the ball [m].
    density : float
        Density [kg/m^3].
    x_0, v_x, v_y : float
        Distance of the ball from the axis [m], and its velocity along x [m/s] and y [m/s], at the start.
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
    >>> from nonsmooth.catalogue import Turntable
    >>> round(Turntable(Omega=7.0).rate(), 6)
    2.0
    """

    Omega: float = 7.0  # of the table [rad/s]
    r: float = 0.05  # [m]
    density: float = 1000.0  # [kg/m^3]
    x_0: float = 0.3  # [m]
    v_x: float = 0.0  # [m/s]
    v_y: float = 0.2  # [m/s]
    mu: float = 0.5  # friction [-]
    g: float = 9.81  # gravity [m/s^2]

    name = "turntable"
    source = "Routh (1905); Weltner, Am. J. Phys. 47 (1979) 984-986"
    t_end = math.pi  # s
    dt = 2e-3  # s

    def __post_init__(self) -> None:
        as_positive("r", self.r, "m")
        as_positive("density", self.density, "kg/m^3")
        for name, unit in (("Omega", "rad/s"), ("x_0", "m"), ("v_x", "m/s"), ("v_y", "m/s")):
            as_number(name, getattr(self, name), unit)
        as_non_negative("mu", self.mu)
        as_positive("g", self.g, "m/s^2")

    def scene(self) -> Scene:
        """The ball where it rolls: r omega = n x (v - v of the table)."""
        scene = Scene(gravity=(0.0, 0.0, -self.g), material=Material(mu=self.mu))
        scene.kinematic(HalfSpace((0, 0, 1)), spin=(0, 0, self.Omega), name="table")
        slips_x, slips_y = self.v_x, self.v_y - self.Omega * self.x_0
        scene.body(
            Sphere(self.r), density=self.density, position=(self.x_0, 0, self.r), velocity=(self.v_x, self.v_y, 0),
            spin=(-slips_y / self.r, slips_x / self.r, 0), name="ball",
        )  # fmt: skip
        return scene

    def rate(self) -> float:
        """At which the ball goes round [rad/s]."""
        return 2 * self.Omega / 7

    def position(self, t: float) -> np.ndarray:
        """Of the ball (2,) [m]: z = z_c + (z_0 - z_c) exp(i rate t), in complex numbers."""
        v_0, rate = complex(self.v_x, self.v_y), self.rate()
        z = self.x_0 + (v_0 * t if rate == 0 else v_0 * (np.exp(1j * rate * t) - 1) / (1j * rate))
        return np.array([z.real, z.imag])
