"""The rod whose lower tip touches the ground: what the unilateral and the bilateral Painlevé rod share.

Rod of mass m, length l, central inertia I; q = (x, y, th), its centre and its angle, counter-clockwise from the ground.
The tip is at (x, y) - (l/2) (cos th, sin th):

    g_N = y - (l/2) sin th,    W_N = [0, 1, -(l/2) cos th],    W_F = [1, 0, (l/2) sin th]
    gamma_N' = G_NN la_N + G_NF la_F + b,    b = (l/2) th'^2 sin th - g
    gamma_F' = G_NF la_N + G_FF la_F + (l/2) th'^2 cos th

Sliding, la_F = -mu_s la_N with mu_s = mu sgn(gamma_F) sgn(la_N), leaves gamma_N' = p la_N + b, p = G_NN - mu_s G_NF.
Source: Painlevé, *C. R. Acad. Sci. Paris* 121 (1895) 112; Génot and Brogliato, *Eur. J. Mech. A/Solids* 18 (1999) 653.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from nonsmooth.checks.arrays import as_non_negative, as_number, as_positive
from nonsmooth.errors import InvalidInput


def mass(t, q, p, M):
    M[0, 0] = p.m
    M[1, 1] = p.m
    M[2, 2] = p.I


def force(t, q, u, p, h):
    h[1] = -p.m * p.g


def gap(t, q, p, g_N):
    g_N[0] = q[1] - 0.5 * p.l * math.sin(q[2])


def normal(t, q, p, W_N):
    W_N[0, 1] = 1.0
    W_N[0, 2] = -0.5 * p.l * math.cos(q[2])


def tangent(t, q, p, W_F):
    W_F[0, 0, 0] = 1.0
    W_F[0, 0, 2] = 0.5 * p.l * math.sin(q[2])


def row_rates(t, q, u, p, r):
    r[0, 0] = 0.5 * p.l * math.sin(q[2]) * u[2] * u[2]
    r[0, 1] = 0.5 * p.l * math.cos(q[2]) * u[2] * u[2]


def potential(t, q, p, V):
    V[0] = p.m * p.g * q[1]


def tip_state(t, s, p, x):
    th, thdot, slip = s[0], s[1], s[2]
    half = 0.5 * p.l
    x[0] = s[3]
    x[1] = half * math.sin(th)
    x[2] = th
    x[3] = slip - half * math.sin(th) * thdot
    x[4] = half * math.cos(th) * thdot
    x[5] = thdot


def tip(q, p):
    """Return the lower tip of the rod and the normal of the ground."""
    return (q[0] - 0.5 * p.l * math.cos(q[2]), q[1] - 0.5 * p.l * math.sin(q[2])), (0.0, 1.0)


FUNCTIONS = {
    "mass": mass,
    "force": force,
    "gap": gap,
    "normal": normal,
    "tangent": tangent,
    "row_rates": row_rates,
    "potential": potential,
}


@dataclass(frozen=True)
class TipRod:
    """Rod with its lower tip on the ground; use `PainleveRod` or `BilateralRod`.

    Parameters
    ----------
    m : float
        Mass [kg].
    l : float
        Length [m].
    I : float
        Central moment of inertia [kg m^2]; m l^2/12 for a uniform slender rod, see `slender`.
    mu : float
        Friction coefficient.
    g : float
        Gravity [m/s^2].

    Raises
    ------
    InvalidInput
        When a parameter is out of range.
    """

    m: float = 1.0  # mass [kg]
    l: float = 1.0  # length [m]
    I: float = 1.0 / 12.0  # central inertia [kg m^2]
    mu: float = 2.0  # friction coefficient [-]
    g: float = 9.81  # gravity [m/s^2]

    coordinates = (("x", "m"), ("y", "m"), ("th", "rad"))
    parts = ("rod",)
    natural_state = staticmethod(tip_state)
    map_axes = (("th", 0.0, math.pi / 2), ("mu", 0.0, 3.0))

    def __post_init__(self) -> None:
        as_positive("m", self.m, "kg")
        as_positive("l", self.l, "m")
        as_positive("I", self.I, "kg m^2")
        as_non_negative("mu", self.mu)
        as_non_negative("g", self.g, "m/s^2")

    @classmethod
    def slender(cls, m: float = 1.0, l: float = 1.0, **others: float) -> Self:
        """A uniform slender rod, I = m l^2/12; the other parameters as in the class."""
        return cls(m=m, l=l, I=m * l * l / 12, **others)

    def tip_state(self, th: float, thdot: float, slip: float, x: float) -> tuple[np.ndarray, np.ndarray]:
        """q0 (3,) and u0 (3,) with the tip on the ground, gamma_N = 0 and gamma_F = slip."""
        th, thdot = as_number("th", th, "rad"), as_number("thdot", thdot, "rad/s")
        slip, x = as_number("slip", slip, "m/s"), as_number("x", x, "m")
        state = np.zeros(6)
        tip_state(0.0, (th, thdot, slip, x), self, state)
        return state[:3], state[3:]

    def kappa(self) -> float:
        """m l^2/(4 I); 3 for a uniform slender rod."""
        return self.m * self.l**2 / (4 * self.I)

    def delassus(self, th: float) -> np.ndarray:
        """G = [[G_NN, G_NF], [G_NF, G_FF]] (2, 2) of the tip [1/kg]."""
        a = self.l**2 / (4 * self.I)
        s, c = math.sin(th), math.cos(th)
        return np.array([[1 / self.m + a * c * c, -a * s * c], [-a * s * c, 1 / self.m + a * s * s]])

    def p(self, th: float, mu_s: float) -> float:
        """p = G_NN - mu_s G_NF [1/kg], with mu_s = mu sgn(gamma_F) sgn(la_N); the literature's A."""
        G = self.delassus(th)
        return float(G[0, 0] - mu_s * G[0, 1])

    def b(self, th: float, thdot: float) -> float:
        """b = (l/2) th'^2 sin th - g [m/s^2], the free normal acceleration of the tip; the literature's B."""
        return 0.5 * self.l * thdot**2 * math.sin(th) - self.g

    def stick_forces(self, th: float, thdot: float) -> np.ndarray:
        """(la_N, la_F) (2,) that keep the tip at rest [N], whatever the friction limit."""
        free = np.array([self.b(th, thdot), 0.5 * self.l * thdot**2 * math.cos(th)])
        return -np.linalg.solve(self.delassus(th), free)

    def critical_friction(self, th: float) -> float:
        """mu_P(th) = (1 + kappa cos^2 th)/(kappa |sin th cos th|): p < 0 is possible above it; inf if th is upright."""
        product = self.kappa() * abs(math.sin(th) * math.cos(th))
        return (1 + self.kappa() * math.cos(th) ** 2) / product if product > 0 else math.inf

    def least_critical_friction(self) -> tuple[float, float]:
        """The least mu_P, 2 sqrt(1 + kappa)/kappa, and its angle arctan sqrt(1 + kappa) [rad]."""
        root = math.sqrt(1 + self.kappa())
        return 2 * root / self.kappa(), math.atan(root)

    def paradoxical_angles(self) -> tuple[float, float] | None:
        """The angles in (0, pi/2) between which mu > mu_P(th) [rad], or None when there are none.

        kappa mu tan th = (1 + tan^2 th) + kappa has them as roots.
        """
        half = 0.5 * self.kappa() * self.mu
        discriminant = half * half - (1 + self.kappa())
        if discriminant <= 0:
            return None
        return math.atan(half - math.sqrt(discriminant)), math.atan(half + math.sqrt(discriminant))

    def shape(self, q: np.ndarray) -> list[np.ndarray]:
        """The rod as a polyline (2, 2)."""
        half = 0.5 * self.l * np.array([math.cos(q[2]), math.sin(q[2])])
        centre = np.array([q[0], q[1]])
        return [np.array([centre - half, centre + half])]

    def outline(self) -> list[np.ndarray]:
        """The ground."""
        return [np.array([[-1.5 * self.l, 0.0], [1.5 * self.l, 0.0]])]


def slip_sign(slip: float) -> float:
    """sgn(slip), or `InvalidInput` at slip = 0."""
    if as_number("slip", slip, "m/s") == 0:
        raise InvalidInput("slip must not be zero: the coefficients of sliding need a direction; see stick_forces")
    return math.copysign(1.0, slip)
