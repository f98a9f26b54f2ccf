"""Two-link arm under a follower force: flutter without friction and without contact.

    (m1 + m2) l^2 th1'' + m2 l^2 cos D th2'' - m2 l^2 th2'^2 sin D + k1 th1 - k2 (D - th0) = -P l sin D
    m2 l^2 cos D th1'' + m2 l^2 th2'' + m2 l^2 th1'^2 sin D + k2 (D - th0) = 0,               D = th2 - th1

Massless links of length l, point masses m1 (elbow) and m2 (tip), torsion springs k1 (base) and k2 (elbow, at rest at
the relative angle th0). The force P acts on the tip along the second link, towards the elbow: it has no potential,
d(T + V)/dt = -P l sin D th1'. Source: textbook chapter on friction-induced instability (follower force), corrected:
the stiffness of the linearised motion is K - dh/dq, and the quoted critical load "about 900 N" is 948.1 N.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_non_negative, as_number, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.system import System


def mass(t, q, p, M):
    coupling = p.m2 * p.l * p.l * math.cos(q[1] - q[0])
    M[0, 0] = (p.m1 + p.m2) * p.l * p.l
    M[0, 1] = coupling
    M[1, 0] = coupling
    M[1, 1] = p.m2 * p.l * p.l


def force(t, q, u, p, h):
    s = math.sin(q[1] - q[0])
    elbow = p.k2 * (q[1] - q[0] - p.th0)
    h[0] = p.m2 * p.l * p.l * u[1] * u[1] * s - p.k1 * q[0] + elbow - p.P * p.l * s
    h[1] = -p.m2 * p.l * p.l * u[0] * u[0] * s - elbow


def stiffness(t, q, u, p, K):
    c = math.cos(q[1] - q[0])
    follower = p.P * p.l * c
    inertia = p.m2 * p.l * p.l * c
    K[0, 0] = p.k1 + p.k2 - follower + inertia * u[1] * u[1]
    K[0, 1] = -p.k2 + follower - inertia * u[1] * u[1]
    K[1, 0] = -p.k2 - inertia * u[0] * u[0]
    K[1, 1] = p.k2 + inertia * u[0] * u[0]


def damping(t, q, u, p, C):
    inertia = 2.0 * p.m2 * p.l * p.l * math.sin(q[1] - q[0])
    C[0, 1] = -inertia * u[1]
    C[1, 0] = inertia * u[0]


def potential(t, q, p, V):
    V[0] = 0.5 * p.k1 * q[0] ** 2 + 0.5 * p.k2 * (q[1] - q[0] - p.th0) ** 2


@dataclass(frozen=True)
class FollowerForceArm:
    """Two-link arm with a follower force at its tip: q = (th1, th2), absolute angles of the links; no contact.

    Parameters
    ----------
    m1, m2 : float
        Masses at the elbow and at the tip [kg].
    l : float
        Length of each link [m].
    k1, k2 : float
        Torsional stiffness of the base and of the elbow [N m/rad].
    th0 : float
        Relative angle at which the elbow's spring is at rest [rad].
    P : float
        Follower force, compression positive [N].

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from nonsmooth.catalogue import FollowerForceArm
    >>> arm = FollowerForceArm(P=1000.0)
    >>> [round(load, 6) for load in arm.critical_loads()]
    [948.126555, 2698.363351]
    >>> round(float(arm.eigenvalues().real.max()), 9)
    5.790640885
    """

    m1: float = 1.0  # mass of the elbow [kg]
    m2: float = 1.0  # mass of the tip [kg]
    l: float = 0.5  # length of a link [m]
    k1: float = 1000.0  # stiffness of the base [N m/rad]
    k2: float = 100.0  # stiffness of the elbow [N m/rad]
    th0: float = math.pi / 6  # rest angle of the elbow [rad]
    P: float = 500.0  # follower force [N]

    name = "follower-force-arm"
    source = "textbook chapter on friction-induced instability: two-link manipulator, follower force (corrected)"
    coordinates = (("th1", "rad"), ("th2", "rad"))
    parts = ("arm",)
    t_end = 1.0  # s
    dt = 1e-4  # s

    def __post_init__(self) -> None:
        as_positive("m1", self.m1, "kg")
        as_positive("m2", self.m2, "kg")
        as_positive("l", self.l, "m")
        as_positive("k1", self.k1, "N m/rad")
        as_non_negative("k2", self.k2, "N m/rad")
        as_number("th0", self.th0, "rad")
        as_number("P", self.P, "N")

    def system(self) -> System:
        """The system; it has no contacts."""
        return System(
            n_q=2, mass=mass, force=force, stiffness=stiffness, damping=damping, potential=potential,
            parameters=self, name=self.name,
        )  # fmt: skip

    def state(
        self, phi1: float = 0.05, phi2: float = 0.0, phi1dot: float = 0.0, phi2dot: float = 0.0
    ) -> tuple[np.ndarray, np.ndarray]:
        """q0 (2,) and u0 (2,) from the deviations from equilibrium [rad] and their rates [rad/s]."""
        deviation = np.array([as_number("phi1", phi1, "rad"), as_number("phi2", phi2, "rad")])
        rates = np.array([as_number("phi1dot", phi1dot, "rad/s"), as_number("phi2dot", phi2dot, "rad/s")])
        return self.equilibrium() + deviation, rates

    def equilibrium(self) -> np.ndarray:
        """th1 = -(P l/k1) sin th0 and th2 = th1 + th0 [rad]."""
        th1 = -self.P * self.l / self.k1 * math.sin(self.th0)
        return np.array([th1, th1 + self.th0])

    def matrices(self) -> tuple[np.ndarray, np.ndarray]:
        """M and Lp = K - dh/dq of the linearised motion M w'' + Lp w = 0; Lp is not symmetric."""
        c = math.cos(self.th0)
        M = self.l**2 * np.array([[self.m1 + self.m2, self.m2 * c], [self.m2 * c, self.m2]])
        follower = self.P * self.l * c
        Lp = np.array([[self.k1 + self.k2 - follower, -self.k2 + follower], [-self.k2, self.k2]])
        return M, Lp

    def characteristic(self) -> tuple[float, float, float]:
        """(a4, a2, a0) of a4 w^4 + a2 w^2 + a0 = 0, w the circular frequency."""
        c, l2 = math.cos(self.th0), self.l**2
        a4 = l2**2 * self.m2 * (self.m1 + self.m2 * math.sin(self.th0) ** 2)
        a2 = (
            self.P * self.l**3 * self.m2 * c * (1 + c)
            - 2 * self.m2 * l2 * self.k2 * (1 + c)
            - l2 * (self.m1 * self.k2 + self.m2 * self.k1)
        )
        return a4, a2, self.k1 * self.k2

    def eigenvalues(self) -> np.ndarray:
        """The four eigenvalues at equilibrium [1/s]."""
        squares = -np.roots(self.characteristic()).astype(complex)
        roots = np.sqrt(squares)
        return np.concatenate([roots, -roots])

    def critical_loads(self) -> tuple[float, float]:
        """Loads between which the arm flutters [N]: a2 = -/+ 2 sqrt(a4 a0); static loss is excluded, det Lp = k1 k2.

        Raises
        ------
        InvalidInput
            For cos th0 (1 + cos th0) = 0: the load has no influence on the frequencies.
        """
        c, l2 = math.cos(self.th0), self.l**2
        b1 = self.m2 * self.l**3 * c * (1 + c)
        if abs(b1) <= 1e-12 * self.m2 * self.l**3:
            raise InvalidInput(f"the load does not couple the modes at th0 = {self.th0:g} rad; take another th0")
        a4, _, a0 = self.characteristic()
        b2 = 2 * self.m2 * l2 * self.k2 * (1 + c) + l2 * (self.m1 * self.k2 + self.m2 * self.k1)
        first, second = sorted(((b2 - 2 * math.sqrt(a4 * a0)) / b1, (b2 + 2 * math.sqrt(a4 * a0)) / b1))
        return first, second

    def energy(self, q: np.ndarray, u: np.ndarray) -> float:
        """T + V [J]."""
        D = q[1] - q[0]
        kinetic = 0.5 * self.l**2 * (
            (self.m1 + self.m2) * u[0] ** 2 + 2 * self.m2 * math.cos(D) * u[0] * u[1] + self.m2 * u[1] ** 2
        )  # fmt: skip
        return float(kinetic + 0.5 * self.k1 * q[0] ** 2 + 0.5 * self.k2 * (D - self.th0) ** 2)

    def power(self, q: np.ndarray, u: np.ndarray) -> float:
        """Power of the follower force, d(T + V)/dt = -P l sin D th1' [W]."""
        return float(-self.P * self.l * math.sin(q[1] - q[0]) * u[0])

    def shape(self, q: np.ndarray) -> list[np.ndarray]:
        """The arm as a polyline (3, 2): base, elbow, tip. Angles are counted from the x axis."""
        elbow = self.l * np.array([math.cos(q[0]), math.sin(q[0])])
        tip = elbow + self.l * np.array([math.cos(q[1]), math.sin(q[1])])
        return [np.array([np.zeros(2), elbow, tip])]

    def outline(self) -> list[np.ndarray]:
        """The wall that carries the base."""
        return [np.array([[0.0, -0.5 * self.l], [0.0, 0.5 * self.l]])]
