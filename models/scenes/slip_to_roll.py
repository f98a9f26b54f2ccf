"""A ball that is put down sliding, and rolls in the end.

Friction -mu g slows it and spins it up, r omega' = (5/2) mu g, until v = r omega:

    t = 2 v_0/(7 mu g),    v = 5 v_0/7
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from nonsmooth.checks.arrays import as_non_negative, as_positive
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import HalfSpace, Sphere


@dataclass(frozen=True)
class SlipToRoll:
    """A ball on a plane that begins to slide without spin: body "ball".

    Parameters
    ----------
    r : float
        Radius [m].
    density : float
        Density [kg/m^3].
    v_0 : float
        Speed at the start [m/s].
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
    >>> from nonsmooth.catalogue import SlipToRoll
    >>> ball = SlipToRoll(mu=0.2, v_0=3.5)
    >>> round(ball.rolling_speed(), 4), round(ball.rolls_at(), 4)
    (2.5, 0.5097)
    """

    r: float = 0.1  # [m]
    density: float = 1000.0  # [kg/m^3]
    v_0: float = 3.0  # [m/s]
    mu: float = 0.2  # friction [-]
    g: float = 9.81  # gravity [m/s^2]

    name = "slip-to-roll"
    source = "Euler; the bowling ball of textbooks"
    t_end = 1.0  # s
    dt = 1e-3  # s

    def __post_init__(self) -> None:
        as_positive("r", self.r, "m")
        as_positive("density", self.density, "kg/m^3")
        as_positive("v_0", self.v_0, "m/s")
        as_non_negative("mu", self.mu)
        as_positive("g", self.g, "m/s^2")

    def scene(self) -> Scene:
        """The ball on the plane."""
        scene = Scene(gravity=(0.0, 0.0, -self.g), material=Material(mu=self.mu))
        scene.fixed(HalfSpace((0, 0, 1)), name="ground")
        scene.body(
            Sphere(self.r), density=self.density, position=(0, 0, self.r), velocity=(self.v_0, 0, 0), name="ball"
        )
        return scene

    def rolling_speed(self) -> float:
        """Of the ball that rolls, 5 v_0/7 [m/s]."""
        return 5 * self.v_0 / 7

    def rolls_at(self) -> float:
        """When it begins to roll, 2 v_0/(7 mu g) [s]; inf without friction."""
        return 2 * self.v_0 / (7 * self.mu * self.g) if self.mu > 0 else math.inf

    def distance(self, t: float) -> float:
        """Covered until a time [m]."""
        slides = min(t, self.rolls_at())
        return self.v_0 * slides - 0.5 * self.mu * self.g * slides**2 + self.rolling_speed() * (t - slides)
