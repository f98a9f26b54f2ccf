"""A wheel that rolls, or slides, down an incline.

rolls     a = g sin(al)/(1 + I/(m r^2)) = (2/3) g sin(al)     for tan(al) <= 3 mu
slides    a = g (sin(al) - mu cos(al)),  r omega' = 2 mu g cos(al)
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from nonsmooth.checks.arrays import as_non_negative, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Disc, HalfPlane


@dataclass(frozen=True)
class RollingWheel:
    """A disc on an incline that descends along x, at rest at the start: body "wheel".

    Parameters
    ----------
    r : float
        Radius [m].
    density : float
        Density [kg/m^2].
    alpha : float
        Angle of the incline [rad].
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
    >>> from nonsmooth.catalogue import RollingWheel
    >>> RollingWheel(mu=0.3, alpha=0.5).rolls(), RollingWheel(mu=0.1, alpha=0.5).rolls()
    (True, False)
    """

    r: float = 0.2  # [m]
    density: float = 500.0  # [kg/m^2]
    alpha: float = 0.3  # [rad]
    mu: float = 0.3  # friction [-]
    g: float = 9.81  # gravity [m/s^2]

    name = "rolling-wheel"
    source = "the wheel on an incline of textbooks"
    t_end = 1.0  # s
    dt = 1e-3  # s

    def __post_init__(self) -> None:
        as_positive("r", self.r, "m")
        as_positive("density", self.density, "kg/m^2")
        if not as_non_negative("alpha", self.alpha, "rad") < math.pi / 2:
            raise InvalidInput(f"alpha must be below pi/2; got {self.alpha:g} rad")
        as_non_negative("mu", self.mu)
        as_positive("g", self.g, "m/s^2")

    def scene(self) -> Scene:
        """The wheel on the incline."""
        normal = (math.sin(self.alpha), math.cos(self.alpha))
        scene = Scene(gravity=(0.0, -self.g), material=Material(mu=self.mu))
        scene.fixed(HalfPlane(normal), name="incline")
        place = (self.r * normal[0], self.r * normal[1])
        scene.body(Disc(self.r), density=self.density, position=place, name="wheel")
        return scene

    def rolls(self) -> bool:
        """Whether it rolls without sliding."""
        return math.tan(self.alpha) <= 3 * self.mu

    def acceleration(self) -> float:
        """Down the incline [m/s^2]."""
        if self.rolls():
            return 2 / 3 * self.g * math.sin(self.alpha)
        return self.g * (math.sin(self.alpha) - self.mu * math.cos(self.alpha))

    def spin(self, t: float) -> float:
        """At a time, positive as it rolls down [rad/s]."""
        if self.rolls():
            return self.acceleration() * t / self.r
        return 2 * self.mu * self.g * math.cos(self.alpha) * t / self.r
