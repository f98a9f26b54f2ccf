"""Mode coupling: mass on a conveyor with an oblique spring; friction makes the stiffness unsymmetric.

    m x'' + cx x' + (kx + k/2) x - (k/2) z = la_F,    gamma_F = x' - vb,    |la_F| <= mu N
    m z'' + cz z' - (k/2) x + (k/2) z      = N - R,   N = max(0, -kz z)

The spring k stands at 45 degrees. N is the force of the contact spring kz: the contact is lost where z > 0. Steady
sliding at q_eq = Lp^-1 (0, -R), Lp = [[kx + k/2, -k/2 + mu kz], [-k/2, kz + k/2]], flutters above a critical mu
although mu is constant. Source: textbook chapter on friction-induced instability (mode coupling), corrected: the
condition has a 2 in its denominator, the load vector is (0, -R), see docs/models.md.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_non_negative, as_number, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.system import Contact, System


def mass(t, q, p, M):
    M[0, 0] = p.m
    M[1, 1] = p.m


def force(t, q, u, p, h):
    oblique = 0.5 * p.k * (q[0] - q[1])
    N = -p.kz * q[1] if q[1] < 0.0 else 0.0
    h[0] = -p.cx * u[0] - p.kx * q[0] - oblique
    h[1] = -p.cz * u[1] + oblique + N - p.R


def tangent(t, q, p, W_F):
    W_F[0, 0, 0] = 1.0


def surface_velocity(t, q, p, w_F):
    w_F[0, 0] = -p.vb


def row_rates(t, q, u, p, r):
    r[0, 0] = 0.0
    r[0, 1] = 0.0


def normal_force(t, q, u, p, N):
    N[0] = -p.kz * q[1] if q[1] < 0.0 else 0.0


def stiffness(t, q, u, p, K):
    K[0, 0] = p.kx + 0.5 * p.k
    K[0, 1] = -0.5 * p.k
    K[1, 0] = -0.5 * p.k
    K[1, 1] = 0.5 * p.k + (p.kz if q[1] < 0.0 else 0.0)


def damping(t, q, u, p, C):
    C[0, 0] = p.cx
    C[1, 1] = p.cz


def potential(t, q, p, V):
    contact = 0.5 * p.kz * q[1] ** 2 if q[1] < 0.0 else 0.0
    V[0] = 0.5 * p.kx * q[0] ** 2 + 0.25 * p.k * (q[0] - q[1]) ** 2 + contact + p.R * q[1]


def foot(q):
    """Return the middle of the lower side of the mass and the normal of the belt."""
    return (q[0], max(q[1], 0.0)), (0.0, 1.0)


@dataclass(frozen=True)
class ModeCoupling:
    """Mass on a conveyor with an oblique spring: q = (x, z), friction under the force of the contact spring.

    Parameters
    ----------
    m : float
        Mass [kg].
    k, kx, kz : float
        Stiffness of the oblique, of the horizontal and of the contact spring [N/m].
    cx, cz : float
        Damping of the two directions [N s/m]; zero for the undamped study.
    mu : float
        Friction coefficient.
    R : float
        Load that presses the mass on the belt [N].
    vb : float
        Belt speed [m/s].

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from nonsmooth.catalogue import ModeCoupling
    >>> ModeCoupling().critical_friction_undamped()
    0.5
    >>> round(ModeCoupling().critical_friction(), 9)
    0.522527017
    >>> round(float(ModeCoupling(mu=0.6).eigenvalues().real.max()), 9)
    0.538256313
    """

    m: float = 1.0  # mass [kg]
    k: float = 100.0  # oblique spring [N/m]
    kx: float = 100.0  # horizontal spring [N/m]
    kz: float = 200.0  # contact spring [N/m]
    cx: float = 1.33  # horizontal damping [N s/m]
    cz: float = 1.0  # vertical damping [N s/m]
    mu: float = 0.6  # friction coefficient [-]
    R: float = 1000.0  # load [N]
    vb: float = 10.0  # belt speed [m/s]

    name = "mode-coupling"
    source = "textbook chapter on friction-induced instability: mode coupling, mass on a conveyor (corrected)"
    coordinates = (("x", "m"), ("z", "m"))
    parts = ("mass",)
    t_end = 10.0  # s
    dt = 1e-3  # s

    def __post_init__(self) -> None:
        as_positive("m", self.m, "kg")
        as_non_negative("k", self.k, "N/m")
        as_non_negative("kx", self.kx, "N/m")
        as_positive("kz", self.kz, "N/m")
        as_non_negative("cx", self.cx, "N s/m")
        as_non_negative("cz", self.cz, "N s/m")
        as_non_negative("mu", self.mu)
        as_number("R", self.R, "N")
        as_number("vb", self.vb, "m/s")

    def system(self) -> System:
        """The system with one friction contact under the force of the contact spring."""
        return System(
            n_q=2, mass=mass, force=force, tangent=tangent, surface_velocity=surface_velocity, row_rates=row_rates,
            normal_force=normal_force, stiffness=stiffness, damping=damping, potential=potential,
            contacts=[Contact(mu="mu", normal_force=True, at=foot)], parameters=self, name=self.name,
        )  # fmt: skip

    def state(
        self, y1: float = 0.1, y2: float = 0.0, y1dot: float = 0.0, y2dot: float = 0.0
    ) -> tuple[np.ndarray, np.ndarray]:
        """q0 (2,) and u0 (2,) from the deviations from steady sliding [m] and their rates [m/s]."""
        deviation = np.array([as_number("y1", y1, "m"), as_number("y2", y2, "m")])
        rates = np.array([as_number("y1dot", y1dot, "m/s"), as_number("y2dot", y2dot, "m/s")])
        return self.equilibrium() + deviation, rates

    def stiffness_matrix(self) -> np.ndarray:
        """Lp of steady sliding below the belt's speed; unsymmetric by mu kz."""
        half, s = 0.5 * self.k, math.copysign(1.0, self.vb)
        return np.array([[self.kx + half, -half + s * self.mu * self.kz], [-half, self.kz + half]])

    def equilibrium(self) -> np.ndarray:
        """(x, z) of steady sliding, Lp^-1 (0, -R) [m]; the contact is kept while z < 0.

        Raises
        ------
        InvalidInput
            When Lp is singular.
        """
        Lp = self.stiffness_matrix()
        if abs(np.linalg.det(Lp)) <= 1e-12 * np.abs(Lp).max() ** 2:
            raise InvalidInput("the stiffness of steady sliding is singular: kx = k = 0 leaves x free; change kx or k")
        return np.linalg.solve(Lp, np.array([0.0, -self.R]))

    def normal_force_at_equilibrium(self) -> float:
        """-kz z_eq [N]; the contact is lost where it is not positive."""
        return float(-self.kz * self.equilibrium()[1])

    def eigenvalues(self) -> np.ndarray:
        """The four eigenvalues of steady sliding [1/s]."""
        top = np.hstack([np.zeros((2, 2)), np.eye(2)])
        bottom = np.hstack([-self.stiffness_matrix() / self.m, -np.diag([self.cx, self.cz]) / self.m])
        return np.linalg.eigvals(np.vstack([top, bottom])).astype(complex)

    def critical_friction_undamped(self) -> float:
        """mu_cr = ((kx - kz)^2 + k^2)/(2 k kz): the frequencies meet, w^2 = (kx + kz + k)/(2 m); cx = cz = 0, vb > 0.

        Raises
        ------
        InvalidInput
            Without the oblique spring: nothing couples the directions.
        """
        if self.k == 0:
            raise InvalidInput("k = 0 leaves the directions uncoupled, so they never meet; take k > 0")
        return ((self.kx - self.kz) ** 2 + self.k**2) / (2 * self.k * self.kz)

    def critical_friction(self) -> float:
        """mu at which steady sliding begins to flutter, with the model's damping, by Hurwitz's condition, for vb > 0.

        s^4 + a3 s^3 + a2 s^2 + a1 s + a0 has a pair +/- i w where a1 a2 a3 = a1^2 + a0 a3^2, w^2 = a1/a3; only a0 holds
        mu. Without damping it is `critical_friction_undamped`. For vb < 0 both off-diagonal stiffnesses are negative at
        every mu, so the frequencies part instead of meeting: there is no flutter.

        Raises
        ------
        InvalidInput
            Without the oblique spring: nothing couples the directions.
        """
        if self.cx == 0 and self.cz == 0:
            return self.critical_friction_undamped()
        if self.k == 0:
            raise InvalidInput("k = 0 leaves the directions uncoupled, so they never meet; take k > 0")
        m, half = self.m, 0.5 * self.k
        cx, cz, k11, k22 = self.cx / m, self.cz / m, (self.kx + half) / m, (self.kz + half) / m
        a3, a2, a1 = cx + cz, k11 + k22 + cx * cz, cx * k22 + cz * k11
        a0 = a1 * (a2 * a3 - a1) / a3**2
        return ((a0 - k11 * k22) * m * m / half + half) / self.kz

    def lift_off_load(self, amplitude: float) -> float:
        """Load R at which a motion whose y2 reaches ``amplitude`` [m] just keeps contact, |z_eq| = amplitude [N]."""
        (k11, k12), (k21, k22) = self.stiffness_matrix()
        return as_positive("amplitude", amplitude, "m") * (k11 * k22 - k12 * k21) / k11

    def shape(self, q: np.ndarray) -> list[np.ndarray]:
        """The mass (a square of 1 m) on the belt as a polyline (5, 2)."""
        a = 0.5
        box = np.array([[-a, 0.0], [a, 0.0], [a, 2 * a], [-a, 2 * a], [-a, 0.0]])
        return [box + np.array([q[0], max(q[1], 0.0)])]

    def outline(self) -> list[np.ndarray]:
        """The belt."""
        return [np.array([[-5.0, 0.0], [5.0, 0.0]])]
