"""Slider-crank mechanism whose slider has clearance in its slot.

The crank turns about the origin, the rod joins its end A to the centre B of the slider; all angles are counted from the
axis of the slot, the x-axis, and e_i = (cos th_i, sin th_i):

    A = l1 e_1,    B = A + l2 e_2,    corner k of the slider: C_k = B + R(th3) (i_k a, j_k b),  i_k, j_k = -1 or 1

The walls of the slot are the lines y = -d/2 and y = d/2, d = 2 (b + c). The corners j = 1 can meet the upper one, the
corners j = -1 the lower one: with y_k = l1 sin th1 + l2 sin th2 + i_k a sin th3 + j_k b cos th3,

    g_k = d/2 - j_k y_k,    gamma_F,k = C_k' . e_x

    B = l1 l2 (m2/2 + m3),    D = th1 - th2
    (J1 + l1^2 (m1/4 + m2 + m3)) th1'' + B cos D th2'' = -B sin D th2'^2 - g l1 (m1/2 + m2 + m3) cos th1
    B cos D th1'' + (J2 + l2^2 (m2/4 + m3)) th2''      =  B sin D th1'^2 - g l2 (m2/2 + m3) cos th2
    J3 th3'' = 0,    and the contacts on the right-hand sides

with the masses of crank and rod at their middles. Lagrange's equations of these positions; the parameters and the law
of impact, Newton's also for two corners at once, are those of Flores, Leine, Glocker, *Multibody Syst. Dyn.* 23 (2010)
165.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_fraction, as_non_negative, as_number, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.system import Contact, System

CORNERS = ((-1.0, 1.0), (1.0, 1.0), (-1.0, -1.0), (1.0, -1.0))  # i_k, j_k: upper left and right, lower left and right


def mass(t, q, p, M):
    B = p.l1 * p.l2 * (p.m2 / 2 + p.m3) * math.cos(q[0] - q[1])
    M[0, 0] = p.J1 + p.l1 * p.l1 * (p.m1 / 4 + p.m2 + p.m3)
    M[0, 1] = B
    M[1, 0] = B
    M[1, 1] = p.J2 + p.l2 * p.l2 * (p.m2 / 4 + p.m3)
    M[2, 2] = p.J3


def force(t, q, u, p, h):
    B = p.l1 * p.l2 * (p.m2 / 2 + p.m3) * math.sin(q[0] - q[1])
    h[0] = -B * u[1] * u[1] - p.g * p.l1 * (p.m1 / 2 + p.m2 + p.m3) * math.cos(q[0])
    h[1] = B * u[0] * u[0] - p.g * p.l2 * (p.m2 / 2 + p.m3) * math.cos(q[1])


def gap(t, q, p, g_N):
    y = p.l1 * math.sin(q[0]) + p.l2 * math.sin(q[1])
    s, c = math.sin(q[2]), math.cos(q[2])
    for k in range(4):
        i, j = CORNERS[k]
        g_N[k] = p.b + p.c - j * (y + i * p.a * s) - p.b * c


def normal(t, q, p, W_N):
    s, c = math.sin(q[2]), math.cos(q[2])
    for k in range(4):
        i, j = CORNERS[k]
        W_N[k, 0] = -j * p.l1 * math.cos(q[0])
        W_N[k, 1] = -j * p.l2 * math.cos(q[1])
        W_N[k, 2] = -i * j * p.a * c + p.b * s


def tangent(t, q, p, W_F):
    s, c = math.sin(q[2]), math.cos(q[2])
    for k in range(4):
        i, j = CORNERS[k]
        W_F[k, 0, 0] = -p.l1 * math.sin(q[0])
        W_F[k, 0, 1] = -p.l2 * math.sin(q[1])
        W_F[k, 0, 2] = -i * p.a * s - j * p.b * c


def row_rates(t, q, u, p, r):
    s, c = math.sin(q[2]), math.cos(q[2])
    along = -p.l1 * math.cos(q[0]) * u[0] * u[0] - p.l2 * math.cos(q[1]) * u[1] * u[1]
    across = -p.l1 * math.sin(q[0]) * u[0] * u[0] - p.l2 * math.sin(q[1]) * u[1] * u[1]
    for k in range(4):
        i, j = CORNERS[k]
        r[k, 0] = -j * across + (i * j * p.a * s + p.b * c) * u[2] * u[2]
        r[k, 1] = along + (-i * p.a * c + j * p.b * s) * u[2] * u[2]


def potential(t, q, p, V):
    crank, rod = p.l1 * (p.m1 / 2 + p.m2 + p.m3), p.l2 * (p.m2 / 2 + p.m3)
    V[0] = p.g * (crank * math.sin(q[0]) + rod * math.sin(q[1]))


@functools.cache
def corner(i, j):
    """Return what says where a corner of the slider is, with the normal and the tangent of its wall."""

    def at(q, p):
        s, c = math.sin(q[2]), math.cos(q[2])
        x = p.l1 * math.cos(q[0]) + p.l2 * math.cos(q[1]) + i * p.a * c - j * p.b * s
        y = p.l1 * math.sin(q[0]) + p.l2 * math.sin(q[1]) + i * p.a * s + j * p.b * c
        return (x, y), (0.0, -j), (1.0, 0.0)

    return at


@dataclass(frozen=True)
class SliderCrank:
    """Slider-crank mechanism with clearance: q = (th1, th2, th3), the angles of crank, rod and slider to the slot.

    No torque drives it: it coasts from its initial velocities. The contacts are the corners of the slider, upper left,
    upper right, lower left, lower right. The pins have no clearance.

    Parameters
    ----------
    l1, l2 : float
        Lengths of crank and rod [m].
    a, b : float
        Half the length and half the height of the slider [m].
    c : float
        Clearance above, and below, the slider in the middle of the slot [m].
    m1, m2, m3 : float
        Masses of crank, rod and slider [kg].
    J1, J2, J3 : float
        Their central moments of inertia [kg m^2].
    g : float
        Gravity, across the slot [m/s^2].
    mu : float
        Friction coefficient of the corners.
    e : float
        Their restitution coefficient (Newton); the tangential one is zero.

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from nonsmooth.catalogue import SliderCrank
    >>> crank = SliderCrank()
    >>> round(crank.largest_tilt(), 6), round(crank.guided_rod_angle(0.5), 6)
    (0.020102, -0.24207)
    """

    l1: float = 0.153  # length of the crank [m]
    l2: float = 0.306  # length of the rod [m]
    a: float = 0.05  # half length of the slider [m]
    b: float = 0.025  # half height of the slider [m]
    c: float = 0.001  # clearance on either side [m]
    m1: float = 0.038  # mass of the crank [kg]
    m2: float = 0.038  # mass of the rod [kg]
    m3: float = 0.076  # mass of the slider [kg]
    J1: float = 7.4e-5  # inertia of the crank [kg m^2]
    J2: float = 5.9e-4  # inertia of the rod [kg m^2]
    J3: float = 2.7e-6  # inertia of the slider [kg m^2]
    g: float = 9.81  # gravity [m/s^2]
    mu: float = 0.01  # friction coefficient [-]
    e: float = 0.4  # restitution [-]

    name = "slider-crank"
    source = "Flores, Leine, Glocker, Multibody Syst. Dyn. 23 (2010) 165"
    coordinates = (("th1", "rad"), ("th2", "rad"), ("th3", "rad"))
    parts = ("crank", "rod", "slider")
    t_end = 0.2  # s
    dt = 1e-5  # s

    def __post_init__(self) -> None:
        for key in ("l1", "l2", "a", "b", "c"):
            as_positive(key, getattr(self, key), "m")
        for key in ("m1", "m2", "m3"):
            as_positive(key, getattr(self, key), "kg")
        for key in ("J1", "J2", "J3"):
            as_positive(key, getattr(self, key), "kg m^2")
        as_non_negative("g", self.g, "m/s^2")
        as_non_negative("mu", self.mu)
        as_fraction("e", self.e)
        if self.l2 <= self.l1:
            raise InvalidInput(f"the rod must be longer than the crank, or it cannot turn; got {self.l2:g} m")

    def system(self) -> System:
        """The system with four unilateral contacts with friction."""
        return System(
            n_q=3, mass=mass, force=force, gap=gap, normal=normal, tangent=tangent, row_rates=row_rates,
            potential=potential, parameters=self, name=self.name,
            contacts=[Contact(mu="mu", e_N="e", impact="newton", at=corner(i, j)) for i, j in CORNERS],
        )  # fmt: skip

    def state(
        self, th1: float = 0.0, th2: float = 0.0, th3: float = 0.0,
        th1dot: float = 150.0, th2dot: float = -75.0, th3dot: float = -0.01,
    ) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
        """q0 (3,) and u0 (3,): angles [rad] and angular velocities [rad/s] of crank, rod and slider."""
        angles = {"th1": th1, "th2": th2, "th3": th3}
        rates = {"th1dot": th1dot, "th2dot": th2dot, "th3dot": th3dot}
        q0 = np.array([as_number(key, value, "rad") for key, value in angles.items()])
        return q0, np.array([as_number(key, value, "rad/s") for key, value in rates.items()])

    def slider_centre(self, q: np.ndarray) -> np.ndarray:
        """B (2,) [m]."""
        return np.array([
            self.l1 * math.cos(q[0]) + self.l2 * math.cos(q[1]), self.l1 * math.sin(q[0]) + self.l2 * math.sin(q[1]),
        ])  # fmt: skip

    def guided_rod_angle(self, th1: float) -> float:
        """th2 [rad] of the mechanism without clearance: l1 sin th1 + l2 sin th2 = 0."""
        return -math.asin(self.l1 / self.l2 * math.sin(as_number("th1", th1, "rad")))

    def largest_tilt(self) -> float:
        """Greatest |th3| [rad] in the slot, at two opposite corners: a sin|th3| + b cos th3 = b + c."""
        r = math.hypot(self.a, self.b)
        return math.asin(min(1.0, (self.b + self.c) / r)) - math.atan2(self.b, self.a)

    def shape(self, q: np.ndarray) -> list[np.ndarray]:
        """Crank (2, 2), rod (2, 2) and slider (5, 2) as polylines."""
        A = self.l1 * np.array([math.cos(q[0]), math.sin(q[0])])
        B = self.slider_centre(q)
        s, c = math.sin(q[2]), math.cos(q[2])
        box = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]]) * [self.a, self.b]
        return [np.array([[0.0, 0.0], A]), np.array([A, B]), B + box @ np.array([[c, s], [-s, c]])]

    def outline(self) -> list[np.ndarray]:
        """The walls of the slot, as far as the slider goes."""
        x = np.array([self.l2 - self.l1 - 1.2 * self.a, self.l2 + self.l1 + 1.2 * self.a])
        return [np.column_stack([x, np.full(2, side * (self.b + self.c))]) for side in (-1, 1)]
