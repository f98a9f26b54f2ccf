"""A row of dominoes, and the speed of the wave that runs through it.

Each turns about its lower front edge, angle th, and leans with its upper edge on the next one, which is smooth:

    h sin(th_i - th_{i+1}) = (s + d) cos th_{i+1} - d

so that the whole train behind the foremost one has one degree of freedom. With a_i = dth_i/dth of the foremost one,
which is 1 for itself, A = sum a_i^2, and I the moment about the edge:

    I A omega^2/2 + m g/2 sum (h cos th_i + d sin th_i) = const     while the foremost one falls by asin(s/h)
    omega_plus = omega_minus A/(1 + A)                              when it hits the next one, without rebound

The speed of the wave is s + d over the time of one such stage, when stages have become alike. After van Leeuwen,
*Am. J. Phys.* 78 (2010) 721-727, here without friction between dominoes and with the ground not slipping.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_count, as_non_negative, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Box, HalfPlane

TRAIN = 40  # chosen: dominoes of a train that are followed; those behind lie still, to rounding
STAGES = 200  # chosen: until stages are alike: each forgets a part 1/(1 + A) of the speed before
POINTS = 64  # chosen: of Gauss's rule for the time of a stage, a smooth integral: its error is rounding


@dataclass(frozen=True)
class DominoRow:
    """A row of dominoes of which the first is pushed: bodies "domino 0" to "domino n-1".

    Parameters
    ----------
    n : int
        Number of dominoes.
    h, d : float
        Height and thickness [m].
    s : float
        Space between two [m].
    density : float
        Density [kg/m^2].
    omega : float
        Angular velocity at which the first begins to fall [rad/s].
    mu : float
        Friction coefficient of the ground.
    mu_d : float
        Friction coefficient of dominoes on one another.
    g : float
        Gravity [m/s^2].

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from nonsmooth.catalogue import DominoRow
    >>> row = DominoRow()
    >>> round(row.wave_speed(), 4), round(row.wave_speed() / (row.g * row.h) ** 0.5, 3)
    (1.2345, 1.799)
    """

    n: int = 40
    h: float = 0.048  # height [m]
    d: float = 0.0075  # thickness [m]
    s: float = 0.0165  # space [m]
    density: float = 800.0  # [kg/m^2]
    omega: float = 10.0  # of the first [rad/s]
    mu: float = 2.0  # of the ground [-]
    mu_d: float = 0.0  # of one another [-]
    g: float = 9.81  # gravity [m/s^2]

    name = "domino-row"
    source = "van Leeuwen, Am. J. Phys. 78 (2010) 721-727"
    t_end = 1.0  # s
    dt = 5e-4  # s

    def __post_init__(self) -> None:
        as_count("n", self.n)
        for name in ("h", "d", "s"):
            as_positive(name, getattr(self, name), "m")
        if not self.s < self.h:
            raise InvalidInput(f"s must be below h, or dominoes do not meet; got {self.s:g} and {self.h:g} m")
        as_positive("density", self.density, "kg/m^2")
        as_positive("omega", self.omega, "rad/s")
        as_non_negative("mu", self.mu)
        as_non_negative("mu_d", self.mu_d)
        as_positive("g", self.g, "m/s^2")

    def scene(self) -> Scene:
        """The dominoes upright; the first turns about its lower front edge."""
        wood = Material(mu=self.mu_d, name="domino")
        scene = Scene(gravity=(0.0, -self.g), material=wood)
        scene.fixed(HalfPlane((0, 1)), material=Material(mu=self.mu, name="ground"), name="ground")
        scene.pair("domino", "ground", mu=self.mu)
        for k in range(self.n):
            first = {"spin": -self.omega, "velocity": (0.5 * self.h * self.omega, 0.5 * self.d * self.omega)}
            scene.body(
                Box(self.d, self.h), density=self.density, position=(k * (self.s + self.d), 0.5 * self.h),
                name=f"domino {k}", **(first if k == 0 else {}),
            )  # fmt: skip
        return scene

    def hit_angle(self) -> float:
        """By which a domino has fallen when it meets the next, asin(s/h) [rad]."""
        return math.asin(self.s / self.h)

    def rest_angle(self) -> float:
        """Of dominoes far behind the wave, acos(d/(s + d)) [rad]."""
        return math.acos(self.d / (self.s + self.d))

    def wave_speed(self) -> float:
        """Of the steady wave [m/s]."""
        inertia = (self.h**2 + self.d**2) / 3  # about the edge, of the mass
        rule, weights = np.polynomial.legendre.leggauss(POINTS)
        angles = 0.5 * self.hit_angle() * (rule + 1)
        A, fall = np.transpose([self._train(th) for th in (0.0, *angles, self.hit_angle())])
        speed_squared = 0.0  # of the foremost one at the beginning of a stage
        for _ in range(STAGES):
            at_end = (inertia * A[0] * speed_squared + self.g * (fall[0] - fall[-1])) / (inertia * A[-1])
            speed_squared = at_end * (A[-1] / (1 + A[-1])) ** 2
        squared = (inertia * A[0] * speed_squared + self.g * (fall[0] - fall[1:-1])) / (inertia * A[1:-1])
        time = 0.5 * self.hit_angle() * float(weights @ (1 / np.sqrt(squared)))
        return (self.s + self.d) / time

    def _train(self, th: float) -> tuple[float, float]:
        """A, and the sum of h cos th_i + d sin th_i, of a train whose foremost domino has fallen by th."""
        a, A, height = 1.0, 0.0, 0.0
        for _ in range(TRAIN):
            A += a * a
            height += self.h * math.cos(th) + self.d * math.sin(th)
            lean = math.asin(((self.s + self.d) * math.cos(th) - self.d) / self.h)
            a *= 1 - (self.s + self.d) * math.sin(th) / (self.h * math.cos(lean))
            th += lean
        return A, height
