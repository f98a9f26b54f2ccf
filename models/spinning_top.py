"""Spinning top on a rough plane: a body of revolution on a spherical tip; with its centre of mass low, a tippe-top.

    r_P - r_C = rho = -h a - r n    from the centre of mass to the contact, a the axis, n up, r the tip's radius
    m v' = F - m g n,    (J omega)' = rho x F,    J = A 1 + (C - A) a a^T,    a' = omega x a
    gamma = v + omega x rho,    g_N = z - h a_z - r

h is how far the centre of mass is above that of the tip along a: r = 0 is a point, and h < 0 the eccentric sphere that
turns over. As rho' = -h omega x a is across the angular momentum J omega, and rho x F across rho, whatever the force,

    Jellett's integral  J omega . rho = constant

sliding, rolling, in impacts and in flight; with r = 0 it is -h C omega_a. Rolling at a steady tilt th about the
vertical, with the spin w = omega . a, a top turns at one of two rates Om, and a sleeping one is stable where they exist
at th = 0:

    [A cos th + m (h cos th + r)(h + r cos th)] Om^2 - [C + m r (h cos th + r)] w Om + m g h = 0

Source: Routh, *Advanced Dynamics of a System of Rigid Bodies* (1905), chapter V; Jellett, *A Treatise on the Theory of
Friction* (1872), chapter VIII; Cohen, *Am. J. Phys.* 45 (1977) 12.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from nonsmooth.checks.arrays import as_fraction, as_non_negative, as_number, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.system import Contact, System

from .billiard_ball import kinematics
from .spatial_painleve_rod import oblique

SIDE = 24  # lines of a circle, in pictures


def axis_x(q):
    return 2.0 * (q[4] * q[6] + q[3] * q[5]) / (q[3] * q[3] + q[4] * q[4] + q[5] * q[5] + q[6] * q[6])


def axis_y(q):
    return 2.0 * (q[5] * q[6] - q[3] * q[4]) / (q[3] * q[3] + q[4] * q[4] + q[5] * q[5] + q[6] * q[6])


def axis_z(q):
    up, aside = q[3] * q[3] + q[6] * q[6], q[4] * q[4] + q[5] * q[5]
    return (up - aside) / (up + aside)


def mass(t, q, p, M):
    a = (axis_x(q), axis_y(q), axis_z(q))
    for i in range(3):
        M[i, i] = p.m
        for j in range(3):
            M[3 + i, 3 + j] = (p.C - p.A) * (a[i] * a[j])
        M[3 + i, 3 + i] += p.A


def force(t, q, u, p, h):
    a_x, a_y, a_z = axis_x(q), axis_y(q), axis_z(q)
    turning = (p.A - p.C) * (u[3] * a_x + u[4] * a_y + u[5] * a_z)
    h[2] = -p.m * p.g
    h[3] = turning * (u[4] * a_z - u[5] * a_y)
    h[4] = turning * (u[5] * a_x - u[3] * a_z)
    h[5] = turning * (u[3] * a_y - u[4] * a_x)


def gap(t, q, p, g_N):
    g_N[0] = q[2] - p.h * axis_z(q) - p.r


def normal(t, q, p, W_N):
    W_N[0, 2], W_N[0, 3], W_N[0, 4] = 1.0, -p.h * axis_y(q), p.h * axis_x(q)


def tangent(t, q, p, W_F):
    down = -p.h * axis_z(q) - p.r
    W_F[0, 0, 0], W_F[0, 0, 4], W_F[0, 0, 5] = 1.0, down, p.h * axis_y(q)
    W_F[0, 1, 1], W_F[0, 1, 3], W_F[0, 1, 5] = 1.0, -down, -p.h * axis_x(q)


def row_rates(t, q, u, p, r):
    a_x, a_y, a_z = axis_x(q), axis_y(q), axis_z(q)
    square, along = u[3] * u[3] + u[4] * u[4] + u[5] * u[5], u[3] * a_x + u[4] * a_y + u[5] * a_z
    r[0, 0] = p.h * (square * a_z - along * u[5])  # -h omega x (omega x a)
    r[0, 1] = p.h * (square * a_x - along * u[3])
    r[0, 2] = p.h * (square * a_y - along * u[4])


def potential(t, q, p, V):
    V[0] = p.m * p.g * q[2]


@dataclass(frozen=True)
class SpinningTop:
    """Spinning top on a rough plane: q = (x, y, z, e_0 ... e_3), u = (v_x, v_y, v_z, w_x, w_y, w_z), of its centre.

    Parameters
    ----------
    m : float
        Mass [kg].
    A, C : float
        Moments of inertia about the centre of mass, across the axis and about it [kg m^2]; C <= 2 A.
    h : float
        Height of the centre of mass above that of the tip, along the axis [m]; below zero: a tippe-top.
    r : float
        Radius of the tip [m]; 0: a point.
    mu : float
        Friction coefficient.
    g : float
        Gravity [m/s^2].
    e : float
        Restitution coefficient (Newton).

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from nonsmooth.catalogue import SpinningTop
    >>> top = SpinningTop()
    >>> round(top.sleeping_spin(), 4)
    80.1009
    >>> slow, fast = top.precessions(th=0.3, spin=200.0)
    >>> round(slow, 6), round(top.friction_of_precession(0.3, 200.0, slow), 6)
    (3.196079, 0.00973)
    >>> SpinningTop.tippe_top().turns_over()
    True
    """

    m: float = 0.05  # mass [kg]
    A: float = 1.5e-5  # across the axis [kg m^2]
    C: float = 2.25e-5  # about the axis [kg m^2]
    h: float = 0.03  # of the centre of mass above that of the tip [m]
    r: float = 0.001  # radius of the tip [m]
    mu: float = 0.3  # friction [-]
    g: float = 9.81  # gravity [m/s^2]
    e: float = 0.0  # restitution [-]

    name = "spinning-top"
    source = "Routh, Advanced Dynamics of a System of Rigid Bodies (1905), chapter V; " \
             "Jellett, A Treatise on the Theory of Friction (1872), chapter VIII"  # fmt: skip
    coordinates = (("x", "m"), ("y", "m"), ("z", "m"), ("e_0", "-"), ("e_1", "-"), ("e_2", "-"), ("e_3", "-"))
    velocities = (
        ("v_x", "m/s"), ("v_y", "m/s"), ("v_z", "m/s"), ("w_x", "rad/s"), ("w_y", "rad/s"), ("w_z", "rad/s"),
    )  # fmt: skip
    parts = ("axis", "tip", "equator")
    t_end = 1.0  # s
    dt = 1e-4  # s

    def __post_init__(self) -> None:
        for name, unit in (("m", "kg"), ("A", "kg m^2"), ("C", "kg m^2"), ("g", "m/s^2"), ("mu", "")):
            as_positive(name, getattr(self, name), unit)
        as_number("h", self.h, "m")
        as_non_negative("r", self.r, "m")
        as_fraction("e", self.e)
        if self.C > 2 * self.A:
            raise InvalidInput(f"C must be at most 2 A, that of a disc; got C = {self.C:g}, A = {self.A:g} kg m^2")

    @classmethod
    def tippe_top(cls, m: float = 0.02, r: float = 0.02, eccentricity: float = 0.3, **others: float) -> Self:
        """An eccentric sphere, h = -eccentricity r, with A = 0.374 m r^2 and C = 0.4 m r^2 unless they are given."""
        own = {"A": 0.374 * m * r * r, "C": 0.4 * m * r * r, "h": -eccentricity * r}
        return cls(m=m, r=r, **(own | others))

    def system(self) -> System:
        """The system with one unilateral contact, whose friction has two directions, at the tip."""
        return System(
            n_q=7, n_u=6, mass=mass, force=force, kinematics=kinematics, gap=gap, normal=normal, tangent=tangent,
            row_rates=row_rates, potential=potential, parameters=self, name=self.name,
            contacts=[Contact(mu="mu", e_N="e", directions=2, name="tip")],
        )  # fmt: skip

    def state(
        self, th: float = 0.3, thdot: float = 0.0, precession: float = 0.0, spin: float = 200.0, slip_x: float = 0.0,
        slip_y: float = 0.0,
    ) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
        """q0 (7,) and u0 (6,) of a top that touches the plane at the origin, its axis tilted towards x.

        Parameters
        ----------
        th, thdot : float
            Tilt of the axis from the vertical [rad] and its rate [rad/s].
        precession : float
            Rate of the axis about the vertical [rad/s].
        spin : float
            omega . a, about the axis [rad/s].
        slip_x, slip_y : float
            Velocity of the contact point [m/s]; 0: it rolls.
        """
        th = as_number("th", th, "rad")
        thdot, precession, spin = (
            as_number(name, w, "rad/s") for name, w in (("thdot", thdot), ("precession", precession), ("spin", spin))
        )
        v = np.array([as_number("slip_x", slip_x, "m/s"), as_number("slip_y", slip_y, "m/s"), 0.0])
        a, rho = self.axis_and_arm(th)
        w = (spin - precession * math.cos(th)) * a + np.array([0.0, thdot, precession])
        q = np.array([*-rho, math.cos(0.5 * th), 0.0, math.sin(0.5 * th), 0.0])
        return q, np.concatenate([v - np.cross(w, rho), w])

    def axis_and_arm(self, th: float) -> tuple[np.ndarray, np.ndarray]:
        """a (3,) tilted by th from n towards x, and rho (3,) [m]."""
        a = np.array([math.sin(th), 0.0, math.cos(th)])
        return a, -self.h * a - np.array([0.0, 0.0, self.r])

    def axis(self, q: np.ndarray) -> np.ndarray:
        """a (..., 3) of states (..., 7)."""
        there = np.moveaxis(np.asarray(q), -1, 0)
        return np.stack([axis_x(there), axis_y(there), axis_z(there)], axis=-1)

    def jellett(self, q: np.ndarray, u: np.ndarray) -> np.ndarray:
        """Jellett's integral J omega . rho of states (..., 7) and velocities (..., 6) [J s m]."""
        a, w = self.axis(q), np.asarray(u)[..., 3:]
        momentum = self.A * w + (self.C - self.A) * (w * a).sum(axis=-1, keepdims=True) * a
        return np.asarray(-self.h * (momentum * a).sum(axis=-1) - self.r * momentum[..., 2])

    def precessions(self, th: float, spin: float) -> tuple[float, ...]:
        """Both rates about the vertical of a top that rolls at a steady tilt [rad/s], the smaller first; () if none."""
        c = math.cos(th)
        square = self.A * c + self.m * (self.h * c + self.r) * (self.h + self.r * c)
        half = 0.5 * (self.C + self.m * self.r * (self.h * c + self.r)) * spin
        rest = half * half - square * self.m * self.g * self.h
        sum_of_both = half + math.copysign(math.sqrt(max(rest, 0.0)), half)  # neither root by a difference
        if rest < 0 or sum_of_both == 0:
            return ()
        slow = self.m * self.g * self.h / sum_of_both
        return (slow, sum_of_both / square) if square != 0 else (slow,)

    def friction_of_precession(self, th: float, spin: float, precession: float) -> float:
        """|F_T|/F_N of a steady precession, whose centre of mass goes round a circle: less than mu if it rolls on."""
        speed = math.sin(th) * ((self.h + self.r * math.cos(th)) * precession - self.r * spin)
        return abs(speed * precession) / self.g

    def sleeping_spin(self) -> float:
        """The spin above which an upright top that rolls sleeps [rad/s]; 0 where h <= 0.

        2 sqrt(m g h (A + m (h + r)^2))/(C + m r (h + r)).
        """
        arm, weight = self.h + self.r, max(0.0, self.m * self.g * self.h)
        return 2.0 * math.sqrt(weight * (self.A + self.m * arm**2)) / (self.C + self.m * self.r * arm)

    def turns_over(self) -> bool:
        """Whether friction turns it over wholly from a fast upright spin: |A/C - 1| < -h/r."""
        return abs(self.A / self.C - 1) * self.r < -self.h

    def spin_turned_over(self, spin: float) -> float:
        """Spin w_z of a top upside down [rad/s], by Jellett's integral (r + h)/(r - h) of what it had upright."""
        if not abs(self.h) < self.r:
            raise InvalidInput(f"only a sphere lies upside down, |h| < r; got h = {self.h:g}, r = {self.r:g} m")
        return (self.r + self.h) / (self.r - self.h) * spin

    def critical_friction(self, th: float) -> float:
        """(A/m + h^2 sin^2 th)/|h sin th (h cos th + r)|: p < 0 in some direction above it; inf: nowhere."""
        across = abs(self.h * math.sin(th) * (self.h * math.cos(th) + self.r))
        return (self.A / self.m + (self.h * math.sin(th)) ** 2) / across if across > 0 else math.inf

    def shape(self, q: np.ndarray) -> list[np.ndarray]:
        """Axis, circle of the tip and a circle about the centre of mass in an oblique view, as polylines (k, 2)."""
        a, size = self.axis(q), max(abs(self.h), self.r)
        across = np.cross(a, [1.0, 0.0, 0.0] if abs(a[0]) < 0.7 else [0.0, 1.0, 0.0])
        across /= np.linalg.norm(across)
        turn = np.linspace(0.0, 2 * np.pi, SIDE + 1)[:, None]
        centre, tip = np.asarray(q[:3]), q[:3] - self.h * a
        ring = centre + size * (np.cos(turn) * across + np.sin(turn) * np.cross(a, across))
        circle = tip + self.r * (np.cos(turn) * np.array([1.0, 0, 0]) + np.sin(turn) * np.array([0, 0, 1.0]))
        return [oblique(np.stack([tip, centre + size * a])), oblique(circle), oblique(ring)]

    def outline(self) -> list[np.ndarray]:
        """A square of the plane."""
        corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [-1, -1, 0]])
        return [oblique(3 * max(abs(self.h), self.r) * corners)]
