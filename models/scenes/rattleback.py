"""A rattleback: a stone like half an almond that may be spun one way, and turns itself back when it is spun the other.

Its principal axes are turned by an angle (skew) about the vertical from the axes of its ellipsoid. Rolling without slip
it couples spin to rocking, and one sense of spin is unstable: the stone rattles, stops, and turns the other way. A
mirror image reverses from the other sense; without skew neither does.
Source: Bondi, *Proc. R. Soc. Lond. A* 405 (1986) 265-274; Garcia and Hubbard, *Proc. R. Soc. Lond. A* 418 (1988)
165-197.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_number, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Ellipsoid, HalfSpace


@dataclass(frozen=True)
class Rattleback:
    """An ellipsoid on its flattest side, with skewed inertia: body "stone".

    Parameters
    ----------
    a, b, c : float
        Half axes, the vertical one last and shortest [m].
    skew : float
        Of the principal axes about the vertical [rad].
    mass : float
        Mass [kg].
    spin : float
        About the vertical, at the start [rad/s].
    rocking : float
        About the horizontal axes, at the start [rad/s].
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
    >>> from models.scenes import Rattleback
    >>> Rattleback(skew=0.3).reverses(), Rattleback(skew=0.3, spin=5.0).reverses()
    (True, False)
    """

    a: float = 0.1  # [m]
    b: float = 0.025  # [m]
    c: float = 0.02  # [m]
    skew: float = 0.3  # [rad]
    mass: float = 1.0  # [kg]
    spin: float = -5.0  # [rad/s]
    rocking: float = 0.01  # [rad/s]
    mu: float = 1.0  # friction [-]
    g: float = 9.81  # gravity [m/s^2]

    name = "rattleback"
    source = "Garcia and Hubbard, Proc. R. Soc. Lond. A 418 (1988) 165-197"
    t_end = 4.0  # s
    dt = 1e-3  # s

    def __post_init__(self) -> None:
        for name, unit in (("a", "m"), ("b", "m"), ("c", "m"), ("mass", "kg"), ("mu", ""), ("g", "m/s^2")):
            as_positive(name, getattr(self, name), unit)
        if not self.c < self.b < self.a:
            raise InvalidInput(f"a > b > c is asked of the half axes; got {self.a:g}, {self.b:g}, {self.c:g} m")
        for name, unit in (("spin", "rad/s"), ("rocking", "rad/s")):
            as_number(name, getattr(self, name), unit)
        if not abs(as_number("skew", self.skew, "rad")) < 0.25 * math.pi:
            raise InvalidInput(f"skew must lie within an eighth of a turn; got {self.skew:g} rad")

    def scene(self) -> Scene:
        """The stone on the ground, spinning and rocking a little."""
        scene = Scene(gravity=(0.0, 0.0, -self.g), material=Material(mu=self.mu))
        scene.fixed(HalfSpace((0, 0, 1)), name="ground")
        scene.body(
            Ellipsoid(self.a, self.b, self.c), mass=self.mass, inertia=self.inertia(), position=(0, 0, self.c),
            spin=(self.rocking, self.rocking, self.spin), name="stone",
        )  # fmt: skip
        return scene

    def inertia(self) -> np.ndarray:
        """That of the full ellipsoid, turned by the skew [kg m^2]."""
        a, b, c = self.a**2, self.b**2, self.c**2
        cosine, sine = math.cos(self.skew), math.sin(self.skew)
        turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
        return self.mass / 5 * turn @ np.diag([b + c, a + c, a + b]) @ turn.T

    def reverses(self) -> bool:
        """Whether this sense of spin is the unstable one."""
        return self.spin * self.skew < 0
