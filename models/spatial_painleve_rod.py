"""Painlevé's rod in space: a slender rod that slides on rough ground on its lower tip, and turns about the vertical.

    e = (cos th cos psi, cos th sin psi, sin th)    from the tip to the centre, at the elevation th and the azimuth psi
    tip = (x, y, z) - s e,    s = l/2,    kappa = m s^2/I,    h = (cos psi, sin psi, 0),    no spin about its own axis
    a_tip = W la + g + s w^2 e,    W = (1/m) [(1 + kappa) 1 - kappa e e^T],    w^2 = th'^2 + psi'^2 cos^2 th

The tip slides along d, at the angle phi from -h (phi = 0: it drags ahead of the rod, as in the plane), with friction
la = la_N (n - mu d), which leaves

    gamma_N' = p la_N + b,    p = (1/m) [1 + kappa cos th (cos th - mu cos phi sin th)],    b = s w^2 sin th - g

that is the rod of the plane with mu cos phi for mu, and w^2 for th'^2. What is new: phi turns of itself, since the
force along h is not along d, and the spin psi' alone makes b positive.
Source: Champneys, Várkonyi, *IMA J. Appl. Math.* 81 (2016) 538; Cheesman, Hogan, Uldall Kristiansen, *The Painlevé
paradox in three dimensions*, arXiv 2110.14324 (2021). Equations: docs/theory/painleve_in_space.md.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from nonsmooth.checks.arrays import as_fraction, as_name, as_non_negative, as_number, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.jit.blocks import new
from nonsmooth.mechanics.impact_in_space import Hodograph, collide_in_space
from nonsmooth.mechanics.system import Contact, System

LAWS = ("newton", "poisson", "energetic")  # in the order of ImpactLaw
DEPTH = 0.35  # of a metre towards the horizon, in pictures


def mass(t, q, p, M):
    M[0, 0], M[1, 1], M[2, 2] = p.m, p.m, p.m
    M[3, 3], M[4, 4] = p.I, p.I * math.cos(q[3]) ** 2


def force(t, q, u, p, h):
    turning = p.I * math.sin(q[3]) * math.cos(q[3])
    h[2] = -p.m * p.g
    h[3] = -turning * u[4] * u[4]
    h[4] = 2.0 * turning * u[3] * u[4]


def gap(t, q, p, g_N):
    g_N[0] = q[2] - 0.5 * p.l * math.sin(q[3])


def normal(t, q, p, W_N):
    W_N[0, 2] = 1.0
    W_N[0, 3] = -0.5 * p.l * math.cos(q[3])


def tangent(t, q, p, W_F):
    a, b = 0.5 * p.l * math.sin(q[3]), 0.5 * p.l * math.cos(q[3])
    W_F[0, 0, 0], W_F[0, 0, 3], W_F[0, 0, 4] = 1.0, a * math.cos(q[4]), b * math.sin(q[4])
    W_F[0, 1, 1], W_F[0, 1, 3], W_F[0, 1, 4] = 1.0, a * math.sin(q[4]), -b * math.cos(q[4])


def row_rates(t, q, u, p, r):
    a, b = 0.5 * p.l * math.sin(q[3]), 0.5 * p.l * math.cos(q[3])
    along, across = b * (u[3] * u[3] + u[4] * u[4]), 2.0 * a * u[3] * u[4]
    r[0, 0] = a * u[3] * u[3]
    r[0, 1] = along * math.cos(q[4]) - across * math.sin(q[4])
    r[0, 2] = along * math.sin(q[4]) + across * math.cos(q[4])


def potential(t, q, p, V):
    V[0] = p.m * p.g * q[2]


def tip_state(t, s, p, x):
    th, phi, thdot, psidot, slip, psi = s[0], s[1], s[2], s[3], s[4], s[5]
    a, b = 0.5 * p.l * math.sin(th), 0.5 * p.l * math.cos(th)
    x[0], x[1], x[2], x[3], x[4] = b * math.cos(psi), b * math.sin(psi), a, th, psi
    x[5] = -slip * math.cos(psi + phi) - a * math.cos(psi) * thdot - b * math.sin(psi) * psidot
    x[6] = -slip * math.sin(psi + phi) - a * math.sin(psi) * thdot + b * math.cos(psi) * psidot
    x[7], x[8], x[9] = b * thdot, thdot, psidot


class SpatialRodImpact(NamedTuple):
    """Outcome of an impact without collision, horizontal vectors along h and to its left.

    Attributes
    ----------
    P_c : float
        Normal impulse at the greatest compression [N s].
    P_N : float
        Normal impulse [N s].
    P_F : ndarray (2,)
        Friction impulse [N s].
    gamma_N : float
        Normal velocity of the tip after the impact [m/s].
    gamma_F : ndarray (2,)
        Its horizontal velocity [m/s].
    u : ndarray (5,)
        Velocities x', y', z' [m/s], th' and psi' [rad/s] after the impact.
    path : ndarray (n, 4)
        Normal impulse, gamma_N and gamma_F on the way.
    """

    P_c: float
    P_N: float
    P_F: np.ndarray
    gamma_N: float
    gamma_F: np.ndarray
    u: np.ndarray
    path: np.ndarray


@dataclass(frozen=True)
class SpatialPainleveRod:
    """Slender rod that slides on its lower tip over rough ground: q = (x, y, z, th, psi), centre, elevation, azimuth.

    Parameters
    ----------
    m : float
        Mass [kg].
    l : float
        Length [m].
    I : float
        Moment of inertia about an axis across the rod through its centre [kg m^2]; m l^2/12 if uniform, see `slender`.
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
    >>> import numpy as np
    >>> from nonsmooth.catalogue import SpatialPainleveRod
    >>> rod = SpatialPainleveRod(mu=2.0)
    >>> round(float(np.degrees(rod.critical_azimuth())), 4)
    48.1897
    >>> rod.normal_forces(th=np.pi / 3, phi=0.4)
    ()
    >>> len(rod.normal_forces(th=np.pi / 3, phi=0.4, psidot=12.0)), len(rod.normal_forces(th=np.pi / 3, phi=0.9))
    (2, 1)
    """

    m: float = 1.0  # mass [kg]
    l: float = 1.0  # length [m]
    I: float = 1.0 / 12.0  # central inertia [kg m^2]
    mu: float = 2.0  # friction coefficient [-]
    g: float = 9.81  # gravity [m/s^2]
    e: float = 0.0  # restitution [-]

    name = "spatial-painleve-rod"
    source = "Champneys, Várkonyi, IMA J. Appl. Math. 81 (2016) 538; " \
             "Cheesman, Hogan, Uldall Kristiansen, arXiv 2110.14324 (2021)"  # fmt: skip
    coordinates = (("x", "m"), ("y", "m"), ("z", "m"), ("th", "rad"), ("psi", "rad"))
    parts = ("rod", "shadow")
    natural_state = staticmethod(tip_state)
    map_axes = (("th", 0.02, 1.55), ("phi", -math.pi / 2, math.pi / 2))
    t_end = 0.3  # s
    dt = 1e-4  # s

    def __post_init__(self) -> None:
        as_positive("m", self.m, "kg")
        as_positive("l", self.l, "m")
        as_positive("I", self.I, "kg m^2")
        as_non_negative("mu", self.mu)
        as_non_negative("g", self.g, "m/s^2")
        as_fraction("e", self.e)

    @classmethod
    def slender(cls, m: float = 1.0, l: float = 1.0, **others: float) -> Self:
        """A uniform slender rod, I = m l^2/12; the other parameters as in the class."""
        return cls(m=m, l=l, I=m * l * l / 12, **others)

    def system(self) -> System:
        """The system with one unilateral contact, whose friction has two directions, at the tip."""
        return System(
            n_q=5, mass=mass, force=force, gap=gap, normal=normal, tangent=tangent, row_rates=row_rates,
            potential=potential, contacts=[Contact(mu="mu", e_N="e", directions=2, name="tip")], parameters=self,
            name=self.name,
        )  # fmt: skip

    def state(
        self, th: float = math.pi / 3, phi: float = 0.4, thdot: float = 0.0, psidot: float = 0.0, slip: float = 1.0,
        psi: float = 0.0,
    ) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
        """q0 (5,) and u0 (5,) with the tip at the origin, neither rising nor falling.

        Parameters
        ----------
        th, psi : float
            Elevation and azimuth [rad].
        phi : float
            Angle of the slide from -h [rad], counted as psi is.
        thdot, psidot : float
            Their rates [rad/s].
        slip : float
            Speed of the tip [m/s]; 0: it rests.
        """
        angles = [as_number(name, x, "rad") for name, x in (("th", th), ("phi", phi))]
        rates = [as_number(name, x, "rad/s") for name, x in (("thdot", thdot), ("psidot", psidot))]
        state = np.zeros(10)
        tip_state(
            0.0, (*angles, *rates, as_non_negative("slip", slip, "m/s"), as_number("psi", psi, "rad")), self, state
        )
        return state[:5], state[5:]

    def kappa(self) -> float:
        """m l^2/(4 I); 3 for a uniform slender rod."""
        return self.m * self.l**2 / (4 * self.I)

    def delassus(self, th: float) -> np.ndarray:
        """G (3, 3) of the tip in the axes N, h, and h turned by a right angle [1/kg]."""
        e = np.array([math.sin(th), math.cos(th), 0.0])
        return ((1 + self.kappa()) * np.eye(3) - self.kappa() * np.outer(e, e)) / self.m

    def p(self, th: float, phi: float) -> float:
        """p of gamma_N' = p la_N + b in the direction phi of slip [1/kg]."""
        return (1 + self.kappa() * math.cos(th) * (math.cos(th) - self.mu * math.cos(phi) * math.sin(th))) / self.m

    def b(self, th: float, thdot: float = 0.0, psidot: float = 0.0) -> float:
        """The free normal acceleration of the tip, (l/2) (th'^2 + psi'^2 cos^2 th) sin th - g [m/s^2]."""
        return 0.5 * self.l * (thdot**2 + (psidot * math.cos(th)) ** 2) * math.sin(th) - self.g

    def normal_forces(self, th: float, phi: float, thdot: float = 0.0, psidot: float = 0.0) -> tuple[float, ...]:
        """Every la_N that solves 0 <= la_N _|_ p la_N + b >= 0 [N], in increasing order."""
        p, b = self.p(th, phi), self.b(th, thdot, psidot)
        return ((0.0,) if b >= 0 else ()) + ((-b / p,) if b * p < 0 else ())

    def slip_acceleration(
        self, th: float, phi: float, thdot: float = 0.0, psidot: float = 0.0, la_N: float = 0.0
    ) -> tuple[float, float]:
        """Acceleration of the tip along its slide, and to the left of it [m/s^2].

        The speed v of the slide grows by the first; phi' is the second over v, less psi'.
        """
        kappa, ahead, side = self.kappa(), -math.cos(phi), math.sin(phi)  # h along d, and to its left
        free = 0.5 * self.l * (thdot**2 + (psidot * math.cos(th)) ** 2) * math.cos(th)
        tilt = kappa * math.cos(th) * (math.sin(th) - self.mu * math.cos(th) * ahead) / self.m
        return (free - la_N * tilt) * ahead - la_N * self.mu * (1 + kappa) / self.m, (free - la_N * tilt) * side

    def rate_of_p(
        self, th: float, phi: float, thdot: float = 0.0, psidot: float = 0.0, slip: float = 1.0
    ) -> float:  # fmt: skip
        """dp/ds at a state with p = 0, dt = p ds [1/(kg^2 s)]; where it is negative the slide turns into the paradox.

        (mu b kappa^2/(v m^2)) sin th cos^2 th sin^2 phi (sin th + mu cos th cos phi): where b < 0, unless phi = 0.
        """
        s, c, mu = math.sin(th), math.cos(th), self.mu
        turning = (self.kappa() / self.m * c * math.sin(phi)) ** 2 * s * (s + mu * c * math.cos(phi))
        return mu * self.b(th, thdot, psidot) / as_positive("slip", slip, "m/s") * turning

    def impact_without_collision(
        self, th: float = math.pi / 3, phi: float = 0.4, thdot: float = 0.0, psidot: float = 0.0, slip: float = 1.0,
        e: float | None = None, law: str = "newton",
    ) -> SpatialRodImpact:  # fmt: skip
        """The impact that resolves a state with p < 0 and psi = 0, at frozen configuration: dv/dP = W (n - mu d).

        The slide turns while it is braked, stops, and the tip sticks while gamma_N rises again.

        Parameters
        ----------
        th, phi, thdot, psidot, slip : float
            The state, as in `state`.
        e : float, optional
            Restitution coefficient; the model's when left out.
        law : {"newton", "poisson", "energetic"}
            What e is a ratio of: velocities, impulses, or, squared, works.

        Raises
        ------
        InvalidInput
            Where p >= 0 (there is no such impact), for e outside [0, 1], and slip = 0.
        UnknownName
            For another law.
        """
        q, u = self.state(th, phi, thdot, psidot, as_positive("slip", slip, "m/s"))
        if self.p(th, phi) >= 0:
            raise InvalidInput(f"an impact without collision needs p < 0; got p = {self.p(th, phi):g} 1/kg")
        h = new(Hodograph)
        h.mu, h.e, h.law = self.mu, as_fraction("e", self.e if e is None else e), LAWS.index(as_name("law", law, LAWS))
        h.G[:], h.before[1:] = self.delassus(th), [-slip * math.cos(phi), -slip * math.sin(phi)]
        collide_in_space(h.address)
        P_N, P_1, P_2 = h.impulse.tolist()
        u += np.array([P_1, P_2, P_N, 0.0, 0.0]) / self.m
        u[3] += 0.5 * self.l * (P_1 * math.sin(th) - P_N * math.cos(th)) / self.I
        u[4] -= 0.5 * self.l * P_2 / (self.I * math.cos(th))
        return SpatialRodImpact(
            h.P_c, P_N, np.array([P_1, P_2]), float(h.gamma[0]), h.gamma[1:].copy(), u, h.path[: h.n].copy()
        )

    def critical_friction(self, th: float, phi: float = 0.0) -> float:
        """mu_P(th)/cos phi, mu_P = (1 + kappa cos^2 th)/(kappa sin th cos th): p < 0 above it; inf: nowhere."""
        product = self.kappa() * math.sin(th) * math.cos(th) * math.cos(phi)
        return (1 + self.kappa() * math.cos(th) ** 2) / product if product > 0 else math.inf

    def least_critical_friction(self, phi: float = 0.0) -> tuple[float, float]:
        """The least of all elevations, 2 sqrt(1 + kappa)/(kappa cos phi), and its elevation arctan sqrt(1 + kappa)."""
        th = math.atan(math.sqrt(1 + self.kappa()))
        return self.critical_friction(th, phi), th

    def critical_azimuth(self, th: float | None = None) -> float | None:
        """phi_max = arccos(mu_P/mu): p < 0 needs |phi| below it [rad]; at one elevation, or that of the least mu_P.

        None where there is no paradox.
        """
        mu_P = self.least_critical_friction()[0] if th is None else self.critical_friction(th)
        return math.acos(mu_P / self.mu) if mu_P < self.mu else None

    def paradoxical_angles(self, phi: float = 0.0) -> tuple[float, float] | None:
        """The elevations th_1 and th_2 between which p < 0 [rad], or None when there are none.

        kappa mu cos phi tan th = 1 + tan^2 th + kappa has them as roots.
        """
        half = 0.5 * self.kappa() * self.mu * math.cos(phi)
        discriminant = half * half - (1 + self.kappa())
        if discriminant <= 0 or half < 0:
            return None
        return math.atan(half - math.sqrt(discriminant)), math.atan(half + math.sqrt(discriminant))

    def lift_off_spin(self, th: float, thdot: float = 0.0) -> float:
        """psi' above which b > 0 [rad/s]; 0 where th' alone lifts the tip."""
        lacking = self.g / (0.5 * self.l * math.sin(th)) - thdot**2
        return math.sqrt(lacking) / math.cos(th) if lacking > 0 else 0.0

    def least_lift_off_spin(self) -> tuple[float, float]:
        """Psi_c = sqrt(3 sqrt(3) g/l), above which b > 0 is possible with th' = 0, and its elevation [rad/s, rad].

        sin th = 1/sqrt(3) whatever mu and kappa.
        """
        th = math.asin(1 / math.sqrt(3))
        return self.lift_off_spin(th), th

    def critical_spins(self, phi: float = 0.0) -> tuple[float, float] | None:
        """Psi_1 and Psi_2, psi' of p = b = 0 with th' = 0 at th_1 and th_2 [rad/s], or None."""
        angles = self.paradoxical_angles(phi)
        return None if angles is None else (self.lift_off_spin(angles[0]), self.lift_off_spin(angles[1]))

    def genot_brogliato_rate(self, th: float, psidot: float = 0.0) -> float | None:
        """|th'| with b = 0 [rad/s], where p = 0 a point of p = b = 0; None where psi' alone lifts the tip."""
        square = self.g / (0.5 * self.l * math.sin(th)) - (psidot * math.cos(th)) ** 2
        return math.sqrt(square) if square >= 0 else None

    def shape(self, q: np.ndarray) -> list[np.ndarray]:
        """The rod and its shadow in an oblique view, as polylines (2, 2)."""
        half = (
            0.5 * self.l * np.array([math.cos(q[3]) * math.cos(q[4]), math.cos(q[3]) * math.sin(q[4]), math.sin(q[3])])
        )
        ends = np.array([q[:3] - half, q[:3] + half])
        return [oblique(ends), oblique(ends * [1.0, 1.0, 0.0])]

    def outline(self) -> list[np.ndarray]:
        """A square of the ground."""
        corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [-1, -1, 0]])
        return [oblique(1.5 * self.l * corners)]


def oblique(points: np.ndarray) -> np.ndarray:
    """Points (n, 3) from the side, y towards the horizon (n, 2)."""
    return np.asarray(points[:, [0, 2]] + DEPTH * points[:, 1:2])
