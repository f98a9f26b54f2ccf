"""Block thrown along a horizontal plane with Coulomb friction.

    m x'' = la_F,    m y'' = -m g + la_N,    |la_F| <= mu la_N,    y >= 0

It stops where its kinetic energy is spent, x = v^2/(2 mu g), and then sticks: x must not creep.
Source: Coulomb (1785); Moreau, *Unilateral contact and dry friction in finite freedom dynamics* (1988).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_fraction, as_non_negative, as_number, as_positive
from nonsmooth.mechanics.system import Contact, System


def mass(t, q, p, M):
    M[0, 0] = p.m
    M[1, 1] = p.m


def force(t, q, u, p, h):
    h[1] = -p.m * p.g


def gap(t, q, p, g_N):
    g_N[0] = q[1]


def normal(t, q, p, W_N):
    W_N[0, 1] = 1.0


def tangent(t, q, p, W_F):
    W_F[0, 0, 0] = 1.0


def row_rates(t, q, u, p, r):
    r[0, 0] = 0.0
    r[0, 1] = 0.0


def potential(t, q, p, V):
    V[0] = p.m * p.g * q[1]


def foot(q):
    """Return the middle of the lower side of the block and the normal of the plane."""
    return q, (0.0, 1.0)


@dataclass(frozen=True)
class SlidingBlock:
    """Block (a point mass) sliding on a plane: q = (x, y), y the gap.

    Parameters
    ----------
    m : float
        Mass [kg].
    g : float
        Gravity [m/s^2].
    mu : float
        Friction coefficient.
    e : float
        Restitution coefficient (Newton) of the plane.

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from nonsmooth.catalogue import SlidingBlock
    >>> block = SlidingBlock(mu=0.3)
    >>> round(block.stop_time(speed=2.0), 5), round(block.stop_distance(speed=2.0), 5)
    (0.67958, 0.67958)
    """

    m: float = 1.0  # mass [kg]
    g: float = 9.81  # gravity [m/s^2]
    mu: float = 0.3  # friction coefficient [-]
    e: float = 0.0  # restitution [-]

    name = "sliding-block"
    source = "Coulomb (1785); Moreau, Unilateral contact and dry friction in finite freedom dynamics (1988)"
    coordinates = (("x", "m"), ("y", "m"))
    parts = ("block",)
    t_end = 1.0  # s
    dt = 1e-3  # s

    def __post_init__(self) -> None:
        as_positive("m", self.m, "kg")
        as_positive("g", self.g, "m/s^2")
        as_non_negative("mu", self.mu)
        as_fraction("e", self.e)

    def system(self) -> System:
        """The system with one unilateral contact with friction."""
        return System(
            n_q=2, mass=mass, force=force, gap=gap, normal=normal, tangent=tangent, row_rates=row_rates,
            potential=potential, contacts=[Contact(mu="mu", e_N="e", at=foot)], parameters=self, name=self.name,
        )  # fmt: skip

    def state(self, speed: float = 2.0, height: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """q0 (2,) and u0 (2,): thrown along x at a speed [m/s], at a height [m] above the plane."""
        q0 = np.array([0.0, as_non_negative("height", height, "m")])
        return q0, np.array([as_number("speed", speed, "m/s"), 0.0])

    def stop_time(self, speed: float = 2.0) -> float:
        """Time at which a block thrown along the plane stops, |v|/(mu g) [s]; inf without friction."""
        return abs(speed) / (self.mu * self.g) if self.mu > 0 else math.inf

    def stop_distance(self, speed: float = 2.0) -> float:
        """Distance it covers until then, v^2/(2 mu g) [m]; inf without friction."""
        return speed * speed / (2 * self.mu * self.g) if self.mu > 0 else math.inf

    def position(self, t: float, speed: float = 2.0) -> float:
        """x(t) [m] of the block thrown along the plane at t = 0."""
        since = min(t, self.stop_time(speed))
        return speed * since - math.copysign(0.5 * self.mu * self.g * since * since, speed)

    def shape(self, q: np.ndarray) -> list[np.ndarray]:
        """The block, drawn 0.2 m by 0.1 m, as polylines (k, 2)."""
        return [np.array([[-0.1, 0.0], [0.1, 0.0], [0.1, 0.1], [-0.1, 0.1], [-0.1, 0.0]]) + np.asarray(q)]

    def outline(self) -> list[np.ndarray]:
        """The plane."""
        return [np.array([[-0.2, 0.0], [1.0, 0.0]])]
