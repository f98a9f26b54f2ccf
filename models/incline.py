"""Block on an oblique plane, in the coordinates of the horizontal frame.

    m (x'', y'') = (F, -m g) + n la_N + t la_F,    n = (-sin alpha, cos alpha),    t = (cos alpha, sin alpha)

The rows of the contact are oblique to the coordinates. The block sticks while

    m g tan(alpha - phi) <= F <= m g tan(alpha + phi),    phi = arctan mu      (alpha + phi < pi/2)

Source: Coulomb (1785), the wedge and the screw; any textbook of statics.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_fraction, as_non_negative, as_number, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.system import Contact, System


def mass(t, q, p, M):
    M[0, 0] = p.m
    M[1, 1] = p.m


def force(t, q, u, p, h):
    h[0] = p.F
    h[1] = -p.m * p.g


def gap(t, q, p, g_N):
    g_N[0] = math.cos(p.alpha) * q[1] - math.sin(p.alpha) * q[0]


def normal(t, q, p, W_N):
    W_N[0, 0] = -math.sin(p.alpha)
    W_N[0, 1] = math.cos(p.alpha)


def tangent(t, q, p, W_F):
    W_F[0, 0, 0] = math.cos(p.alpha)
    W_F[0, 0, 1] = math.sin(p.alpha)


def row_rates(t, q, u, p, r):
    r[0, 0] = 0.0
    r[0, 1] = 0.0


def potential(t, q, p, V):
    V[0] = p.m * p.g * q[1] - p.F * q[0]


def foot(q, p):
    """Return the middle of the lower side of the block and the normal of the plane."""
    return q, (-math.sin(p.alpha), math.cos(p.alpha))


@dataclass(frozen=True)
class InclinedBlock:
    """Block on a plane that rises with the angle alpha: q = (x, y) in the horizontal frame.

    Parameters
    ----------
    m : float
        Mass [kg].
    g : float
        Gravity [m/s^2].
    mu : float
        Friction coefficient.
    alpha : float
        Angle of the plane, |alpha| < pi/2 [rad]; the default is half the friction limit, tan alpha = mu/2.
    F : float
        Horizontal load [N]; uphill when positive and alpha > 0.
    e : float
        Restitution coefficient (Newton) of the plane.

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from nonsmooth.catalogue import InclinedBlock
    >>> low, high = InclinedBlock(mu=0.3, alpha=0.15).sticking_loads()
    >>> round(low, 4), round(high, 4)
    (-1.397, 4.6358)
    >>> InclinedBlock(mu=0.3, alpha=0.15, F=1.001 * high).sticks()
    False
    """

    m: float = 1.0  # mass [kg]
    g: float = 9.81  # gravity [m/s^2]
    mu: float = 0.3  # friction coefficient [-]
    alpha: float = math.atan(0.15)  # angle of the plane [rad]
    F: float = 0.0  # horizontal load [N]
    e: float = 0.0  # restitution [-]

    name = "inclined-block"
    source = "Coulomb (1785)"
    coordinates = (("x", "m"), ("y", "m"))
    parts = ("block",)
    t_end = 1.0  # s
    dt = 2e-3  # s

    def __post_init__(self) -> None:
        as_positive("m", self.m, "kg")
        as_positive("g", self.g, "m/s^2")
        as_non_negative("mu", self.mu)
        as_number("F", self.F, "N")
        as_fraction("e", self.e)
        if not abs(as_number("alpha", self.alpha, "rad")) < math.pi / 2:
            raise InvalidInput(f"alpha must lie in (-pi/2, pi/2) rad; got {self.alpha:g}")

    def system(self) -> System:
        """The system with one unilateral contact with friction."""
        return System(
            n_q=2, mass=mass, force=force, gap=gap, normal=normal, tangent=tangent, row_rates=row_rates,
            potential=potential, contacts=[Contact(mu="mu", e_N="e", at=foot)], parameters=self, name=self.name,
        )  # fmt: skip

    def state(self, slip: float = 2.0, distance: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """q0 (2,) and u0 (2,): on the plane at a distance [m] uphill from the origin, slipping uphill at slip [m/s].

        Left out, the block was pushed uphill: it slides, and comes to rest.
        """
        t = np.array([math.cos(self.alpha), math.sin(self.alpha)])
        return as_number("distance", distance, "m") * t, as_number("slip", slip, "m/s") * t

    def normal_force(self) -> float:
        """la_N = m g cos alpha + F sin alpha [N] while the block is on the plane (not below zero)."""
        return max(0.0, self.m * self.g * math.cos(self.alpha) + self.F * math.sin(self.alpha))

    def downhill_load(self) -> float:
        """Component of the loads along the plane, downhill, m g sin alpha - F cos alpha [N]."""
        return self.m * self.g * math.sin(self.alpha) - self.F * math.cos(self.alpha)

    def sticks(self) -> bool:
        """Whether a block at rest stays at rest."""
        return abs(self.downhill_load()) <= self.mu * self.normal_force()

    def sticking_loads(self) -> tuple[float, float]:
        """The least and the largest horizontal load F [N] at which the block sticks (inf where it jams)."""
        phi = math.atan(self.mu)
        low, high = self.alpha - phi, self.alpha + phi
        weight = self.m * self.g
        return (
            weight * math.tan(low) if low > -math.pi / 2 else -math.inf,
            weight * math.tan(high) if high < math.pi / 2 else math.inf,
        )

    def acceleration(self, slip: float = 0.0) -> float:
        """Acceleration along the plane, uphill [m/s^2], while slipping at ``slip`` or from rest (slip = 0)."""
        if slip == 0 and self.sticks():
            return 0.0
        direction = math.copysign(1.0, slip if slip != 0 else -self.downhill_load())
        return (-self.downhill_load() - direction * self.mu * self.normal_force()) / self.m

    def shape(self, q: np.ndarray) -> list[np.ndarray]:
        """The block, drawn 0.2 m by 0.1 m, as polylines (k, 2)."""
        box = np.array([[-0.1, 0.0], [0.1, 0.0], [0.1, 0.1], [-0.1, 0.1], [-0.1, 0.0]])
        c, s = math.cos(self.alpha), math.sin(self.alpha)
        return [np.asarray(q) + box @ np.array([[c, s], [-s, c]])]

    def outline(self) -> list[np.ndarray]:
        """The plane."""
        return [np.outer([-1.0, 1.0], [math.cos(self.alpha), math.sin(self.alpha)])]
