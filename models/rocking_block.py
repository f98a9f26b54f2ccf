"""Rigid block rocking on its two bottom corners.

    M = diag(m, m, I),    I = m (width^2 + height^2)/12,    corner i at r_i = R(th) (-+width/2, -height/2)

While it turns about a corner that does not slip, (I + m r^2) |th|'' = -m g r sin(alpha - |th|) with r the half diagonal
and tan alpha = width/height; when the other corner lands without bouncing, th' is multiplied by 1 - (3/2) sin^2 alpha.
Source: Housner, *Bull. Seism. Soc. Am.* 53 (1963) 403.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_fraction, as_non_negative, as_number, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.system import Contact, System


def mass(t, q, p, M):
    M[0, 0] = p.m
    M[1, 1] = p.m
    M[2, 2] = p.m * (p.width * p.width + p.height * p.height) / 12.0


def force(t, q, u, p, h):
    h[1] = -p.m * p.g


def gap(t, q, p, g_N):
    s, c = math.sin(q[2]), math.cos(q[2])
    for i in range(2):
        a = (i - 0.5) * p.width
        g_N[i] = q[1] + a * s - 0.5 * p.height * c


def normal(t, q, p, W_N):
    s, c = math.sin(q[2]), math.cos(q[2])
    for i in range(2):
        a = (i - 0.5) * p.width
        W_N[i, 1] = 1.0
        W_N[i, 2] = a * c + 0.5 * p.height * s


def tangent(t, q, p, W_F):
    s, c = math.sin(q[2]), math.cos(q[2])
    for i in range(2):
        a = (i - 0.5) * p.width
        W_F[i, 0, 0] = 1.0
        W_F[i, 0, 2] = -a * s + 0.5 * p.height * c


def row_rates(t, q, u, p, r):
    s, c = math.sin(q[2]), math.cos(q[2])
    for i in range(2):
        a = (i - 0.5) * p.width
        r[i, 0] = (-a * s + 0.5 * p.height * c) * u[2] * u[2]
        r[i, 1] = (-a * c - 0.5 * p.height * s) * u[2] * u[2]


def potential(t, q, p, V):
    V[0] = p.m * p.g * q[1]


@functools.cache
def corner(side):
    """Return what says where the left (-1) or the right (1) bottom corner is, with the normal of the ground."""

    def at(q, p):
        a, b, s, c = 0.5 * side * p.width, 0.5 * p.height, math.sin(q[2]), math.cos(q[2])
        return (q[0] + a * c + b * s, q[1] + a * s - b * c), (0.0, 1.0)

    return at


@dataclass(frozen=True)
class RockingBlock:
    """Uniform rectangular block on rough ground: q = (x, y, th), its centre and its tilt (counter-clockwise).

    Contact 0 is the left bottom corner, contact 1 the right one.

    Parameters
    ----------
    m : float
        Mass [kg].
    width, height : float
        Sides [m].
    g : float
        Gravity [m/s^2].
    mu : float
        Friction coefficient of both corners.
    e : float
        Restitution coefficient (Newton) of both corners.

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from nonsmooth.catalogue import RockingBlock
    >>> block = RockingBlock()
    >>> round(block.critical_tilt(), 6), round(block.rate_ratio(), 6)
    (0.244979, 0.911765)
    """

    m: float = 1.0  # mass [kg]
    width: float = 0.2  # width [m]
    height: float = 0.8  # height [m]
    g: float = 9.81  # gravity [m/s^2]
    mu: float = 10.0  # friction coefficient [-]
    e: float = 0.0  # restitution [-]

    name = "rocking-block"
    source = "Housner, Bull. Seism. Soc. Am. 53 (1963) 403"
    coordinates = (("x", "m"), ("y", "m"), ("th", "rad"))
    parts = ("block",)
    t_end = 3.0  # s
    dt = 1e-3  # s

    def __post_init__(self) -> None:
        as_positive("m", self.m, "kg")
        as_positive("width", self.width, "m")
        as_positive("height", self.height, "m")
        as_positive("g", self.g, "m/s^2")
        as_non_negative("mu", self.mu)
        as_fraction("e", self.e)

    def system(self) -> System:
        """The system with two unilateral contacts with friction."""
        return System(
            n_q=3, mass=mass, force=force, gap=gap, normal=normal, tangent=tangent, row_rates=row_rates,
            potential=potential,
            contacts=[Contact(mu="mu", e_N="e", at=corner(side)) for side in (-1, 1)],
            parameters=self, name=self.name,
        )  # fmt: skip

    def state(self, tilt: float = 0.1, tilt_rate: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """q0 (3,) and u0 (3,): tilted [rad] about a bottom corner that stays where it is, turning at tilt_rate [rad/s].

        The left corner for tilt > 0, the right one for tilt < 0; upright, the centre is over x = 0. From the upright
        position the block turns about the corner to which tilt_rate points.
        """
        tilt, tilt_rate = as_number("tilt", tilt, "rad"), as_number("tilt_rate", tilt_rate, "rad/s")
        side = math.copysign(1.0, tilt if tilt != 0 else tilt_rate)
        s, c = math.sin(tilt), math.cos(tilt)
        a, b = 0.5 * self.width * side, 0.5 * self.height  # centre seen from the corner
        r = np.array([a * c - b * s, a * s + b * c])
        return np.array([r[0] - a, r[1], tilt]), tilt_rate * np.array([-r[1], r[0], 1.0])

    def half_diagonal(self) -> float:
        """r [m]: distance from a corner to the centre."""
        return 0.5 * math.hypot(self.width, self.height)

    def inertia(self) -> float:
        """Central moment of inertia I = m (width^2 + height^2)/12 [kg m^2]."""
        return self.m * (self.width**2 + self.height**2) / 12

    def critical_tilt(self) -> float:
        """alpha = arctan(width/height) [rad]: beyond it the block topples."""
        return math.atan2(self.width, self.height)

    def rate_ratio(self) -> float:
        """th'_plus/th'_minus = 1 - (3/2) sin^2 alpha when the other corner lands, for e = 0 and no slip.

        Negative for a block with sin^2 alpha > 2/3: then the first corner stays on the ground too, and it stops.
        """
        return 1 - 1.5 * math.sin(self.critical_tilt()) ** 2

    def fall_time(self, tilt: float = 0.1) -> float:
        """Time from rest at a tilt in (0, alpha) to the upright position [s], a quarter of the rocking period.

        (I + m r^2) th'^2/2 = m g r (cos(alpha - th_0) - cos(alpha - th)), integrated by Gauss-Legendre quadrature.

        Raises
        ------
        InvalidInput
            When |tilt| is zero or not below the critical tilt.
        """
        th_0, alpha = abs(as_number("tilt", tilt, "rad")), self.critical_tilt()
        if not 0 < th_0 < alpha:
            raise InvalidInput(f"the tilt must lie between 0 and the critical tilt {alpha:g} rad; got {tilt:g}")
        r = self.half_diagonal()
        rate = 2 * self.m * self.g * r / (self.inertia() + self.m * r * r)
        node, weight = np.polynomial.legendre.leggauss(60)
        s, weight = 0.5 * (node + 1), 0.5 * weight
        th = th_0 * (1 - s * s)  # takes the root's singularity away
        # cos(alpha - th_0) - cos(alpha - th) without cancellation
        fall = 2 * np.sin(alpha - 0.5 * (th_0 + th)) * np.sin(0.5 * (th_0 - th))
        return float(np.sum(weight * 2 * th_0 * s / np.sqrt(rate * fall)))

    def next_tilt(self, tilt: float = 0.1) -> float:
        """Greatest tilt on the other side after one impact (e = 0, no slip) [rad]."""
        alpha, r = self.critical_tilt(), max(0.0, self.rate_ratio())
        start = math.cos(alpha - abs(tilt)) - math.cos(alpha)
        return alpha - math.acos(math.cos(alpha) + r * r * start)

    def shape(self, q: np.ndarray) -> list[np.ndarray]:
        """The block as a polyline (5, 2)."""
        a, b = 0.5 * self.width, 0.5 * self.height
        s, c = math.sin(q[2]), math.cos(q[2])
        box = np.array([[-a, -b], [a, -b], [a, b], [-a, b], [-a, -b]])
        return [np.array([q[0], q[1]]) + box @ np.array([[c, s], [-s, c]])]

    def outline(self) -> list[np.ndarray]:
        """The ground."""
        return [np.array([[-self.height, 0.0], [self.height, 0.0]])]
