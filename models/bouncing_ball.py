"""Ball bouncing on the ground under gravity.

    m y'' = -m g + la_N,    0 <= y  _|_  la_N >= 0,    y'_plus = -e y'_minus

Source: the standard example of an infinity of impacts in a finite time (Zeno); Moreau, *Unilateral contact and dry
friction in finite freedom dynamics* (1988); Brogliato, *Nonsmooth Mechanics* (2016).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_count, as_fraction, as_non_negative, as_number, as_positive
from nonsmooth.mechanics.system import Contact, System


def mass(t, q, p, M):
    M[0, 0] = p.m


def force(t, q, u, p, h):
    h[0] = -p.m * p.g


def gap(t, q, p, g_N):
    g_N[0] = q[0]


def normal(t, q, p, W_N):
    W_N[0, 0] = 1.0


def row_rates(t, q, u, p, r):
    r[0, 0] = 0.0


def potential(t, q, p, V):
    V[0] = p.m * p.g * q[0]


def lowest_point(q):
    """Return the lowest point of the ball and the normal of the ground."""
    return (0.0, q[0]), (0.0, 1.0)


@dataclass(frozen=True)
class BouncingBall:
    """Ball bouncing on the ground: q = (y,), the height of its lowest point.

    Parameters
    ----------
    m : float
        Mass [kg].
    g : float
        Gravity [m/s^2].
    e : float
        Restitution coefficient (Newton), 0 <= e <= 1.

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from nonsmooth.catalogue import BouncingBall
    >>> ball = BouncingBall(e=0.5)
    >>> ball.impact_times(3, height=1.0).round(4)
    array([0.4515, 0.903 , 1.1288])
    >>> round(ball.t_inf(height=1.0), 4)
    1.3546
    """

    m: float = 1.0  # mass [kg]
    g: float = 9.81  # gravity [m/s^2]
    e: float = 0.5  # restitution [-]

    name = "bouncing-ball"
    source = "Brogliato, Nonsmooth Mechanics (2016)"
    coordinates = (("y", "m"),)
    parts = ("ball",)
    t_end = 2.0  # s
    dt = 1e-3  # s

    def __post_init__(self) -> None:
        as_positive("m", self.m, "kg")
        as_positive("g", self.g, "m/s^2")
        as_fraction("e", self.e)

    def system(self) -> System:
        """The system with one frictionless unilateral contact."""
        return System(
            n_q=1, mass=mass, force=force, gap=gap, normal=normal, row_rates=row_rates, potential=potential,
            contacts=[Contact(e_N="e", at=lowest_point)], parameters=self, name=self.name,
        )  # fmt: skip

    def state(self, height: float = 1.0, velocity: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """q0 (1,) and u0 (1,) at a height [m] and an upward velocity [m/s]."""
        return np.array([as_non_negative("height", height, "m")]), np.array([as_number("velocity", velocity, "m/s")])

    def impact_speed(self, height: float = 1.0, velocity: float = 0.0) -> float:
        """Speed of the first impact, sqrt(velocity^2 + 2 g height) [m/s]."""
        (y,), (v,) = self.state(height, velocity)
        return math.sqrt(v * v + 2 * self.g * y)

    def impact_times(self, n: int, height: float = 1.0, velocity: float = 0.0) -> np.ndarray:
        """Times of the first n impacts (n,) [s]: t_1 = (v_0 + v_1)/g, t_(k+1) = t_k + 2 e^k v_1/g."""
        v_1 = self.impact_speed(height, velocity)
        flights = 2 * v_1 / self.g * self.e ** np.arange(1, as_count("n", n))
        return (velocity + v_1) / self.g + np.concatenate([[0.0], np.cumsum(flights)])

    def t_inf(self, height: float = 1.0, velocity: float = 0.0) -> float:
        """Time at which the impacts accumulate and the ball comes to rest [s]; inf for e = 1."""
        v_1 = self.impact_speed(height, velocity)
        if self.e == 1:
            return math.inf
        return (velocity + v_1) / self.g + 2 * v_1 / self.g * self.e / (1 - self.e)

    def height(self, t: float, height: float = 1.0, velocity: float = 0.0) -> float:
        """Height at time t [m] of the motion that starts at the given height and velocity."""
        v_1 = self.impact_speed(height, velocity)
        if t >= self.t_inf(height, velocity):
            return 0.0
        since = t - (velocity + v_1) / self.g  # time since the last impact
        if since < 0:
            return height + velocity * t - 0.5 * self.g * t * t
        v = self.e * v_1  # speed at which it left the ground
        while since > 2 * v / self.g:
            since -= 2 * v / self.g
            v *= self.e
        return max(0.0, v * since - 0.5 * self.g * since * since)

    def shape(self, q: np.ndarray) -> list[np.ndarray]:
        """The ball, drawn with a radius of 0.05 m, as polylines (k, 2)."""
        angle = np.linspace(0.0, 2 * np.pi, 33)
        return [np.column_stack([0.05 * np.cos(angle), q[0] + 0.05 + 0.05 * np.sin(angle)])]

    def outline(self) -> list[np.ndarray]:
        """The ground."""
        return [np.array([[-0.5, 0.0], [0.5, 0.0]])]
