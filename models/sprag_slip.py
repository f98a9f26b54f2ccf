"""Sprag-slip rod: a guided pivot, a rod and a conveyor; rigid bilateral contact at the tip.

The pivot O (mass m) moves vertically at the height y, on a spring ky and a damper cy; the rod (inertia I about O,
length l) hangs on a torsion spring kth and a damper cth. Its tip rubs on a conveyor of speed vb; R loads the tip. No
gravity.

    m y''  + cy y'  + ky y          = la_N - R
    I th'' + cth th' + kth (th - th0) = (R - la_N) l cos th + la_F l sin th
    g_N = y - l sin th,    W_N = [1, -l cos th],    W_F = [0, l sin th],    w_F = -vb,    |la_F| <= mu |la_N|

gamma_F is minus the v_t of the literature (belt minus tip). On the constraint, with mu_s = mu sgn(v_t la_N),

    M th'' + C th' + G th'^2 + F = 0,    la_N = Lambda/M

Source: textbook chapter on friction-induced instability (kinematic constraint, sprag-slip), corrected: see
docs/models.md.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from nonsmooth.checks.arrays import as_non_negative, as_number, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.system import Contact, System

SOLUTIONS = (1, 2, 0, 0, 2)  # number of solutions in the regions A0 .. A4


def mass(t, q, p, M):
    M[0, 0] = p.m
    M[1, 1] = p.I


def force(t, q, u, p, h):
    h[0] = -p.cy * u[0] - p.ky * q[0] - p.R
    h[1] = -p.cth * u[1] - p.kth * (q[1] - p.th0) + p.R * p.l * math.cos(q[1])


def gap(t, q, p, g_N):
    g_N[0] = q[0] - p.l * math.sin(q[1])


def normal(t, q, p, W_N):
    W_N[0, 0] = 1.0
    W_N[0, 1] = -p.l * math.cos(q[1])


def tangent(t, q, p, W_F):
    W_F[0, 0, 1] = p.l * math.sin(q[1])


def surface_velocity(t, q, p, w_F):
    w_F[0, 0] = -p.vb


def row_rates(t, q, u, p, r):
    r[0, 0] = p.l * math.sin(q[1]) * u[1] * u[1]
    r[0, 1] = p.l * math.cos(q[1]) * u[1] * u[1]


def stiffness(t, q, u, p, K):
    K[0, 0] = p.ky
    K[1, 1] = p.kth + p.R * p.l * math.sin(q[1])


def damping(t, q, u, p, C):
    C[0, 0] = p.cy
    C[1, 1] = p.cth


def potential(t, q, p, V):
    V[0] = 0.5 * p.ky * q[0] ** 2 + 0.5 * p.kth * (q[1] - p.th0) ** 2 + p.R * (q[0] - p.l * math.sin(q[1]))


def natural_state(t, s, p, x):
    th, thdot = s[0], s[1]
    x[0] = p.l * math.sin(th)
    x[1] = th
    x[2] = p.l * math.cos(th) * thdot
    x[3] = thdot


class Reduced(NamedTuple):
    """Coefficients of M th'' + C th' + G th'^2 + F = 0 on one branch, and K = dF/dth."""

    M: float  # kg m^2
    C: float  # N m s/rad
    G: float  # kg m^2
    F: float  # N m
    K: float  # N m/rad


class Seizure(NamedTuple):
    """Velocity jump of a state without solution: the tip is seized by the belt, no restitution."""

    thdot: float  # angular velocity after it [rad/s]
    P_N: float  # normal impulse [N s]
    P_F: float  # friction impulse [N s]


def tip(q, p):
    """Return the tip of the rod and the normal of the belt."""
    return (-p.l * math.cos(q[1]), q[0] - p.l * math.sin(q[1])), (0.0, 1.0)


@dataclass(frozen=True)
class SpragSlip:
    """Sprag-slip rod with a rigid bilateral contact: q = (y, th). The defaults are set 2 of the literature.

    Parameters
    ----------
    m : float
        Mass of the pivot [kg].
    I : float
        Inertia of the rod about the pivot [kg m^2].
    ky, kth : float
        Stiffness of the guide [N/m] and of the torsion spring [N m/rad].
    R : float
        Load on the tip [N].
    mu : float
        Friction coefficient.
    cy, cth : float
        Damping of the guide [N s/m] and of the rotation [N m s/rad].
    vb : float
        Speed of the conveyor, towards the side of the pivot [m/s].
    th0 : float
        Angle at which the torsion spring is at rest [rad].
    l : float
        Length of the rod [m].

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from nonsmooth.catalogue import SpragSlip
    >>> rod = SpragSlip()
    >>> round(rod.equilibrium(), 9)
    0.84962671
    >>> int(rod.region(0.78, 1.0)), rod.normal_forces(0.78, 1.0)
    (3, ())
    >>> round(SpragSlip.set_1(cth=0.5).equilibrium(), 9)
    0.828053559
    """

    m: float = 2.0  # mass [kg]
    I: float = 4.0  # inertia about the pivot [kg m^2]
    ky: float = 10.0  # stiffness [N/m]
    kth: float = 1000.0  # torsional stiffness [N m/rad]
    R: float = 1.0  # load [N]
    mu: float = 1.3  # friction coefficient [-]
    cy: float = 1.0  # damping [N s/m]
    cth: float = 10.0  # torsional damping [N m s/rad]
    vb: float = 10.0  # belt speed [m/s]
    th0: float = math.pi / 4  # rest angle of the torsion spring [rad]
    l: float = 5.0  # length [m]

    name = "sprag-slip"
    source = "textbook chapter on friction-induced instability: sprag-slip, kinematic constraint (corrected)"
    coordinates = (("y", "m"), ("th", "rad"))
    parts = ("rod",)
    natural_state = staticmethod(natural_state)
    map_axes = (("th", 0.65, 1.25), ("thdot", -4.5, 4.5))
    t_end = 1.0  # s
    dt = 1e-4  # s

    def __post_init__(self) -> None:
        as_positive("m", self.m, "kg")
        as_positive("I", self.I, "kg m^2")
        as_positive("l", self.l, "m")
        as_non_negative("ky", self.ky, "N/m")
        as_non_negative("kth", self.kth, "N m/rad")
        as_non_negative("mu", self.mu)
        as_non_negative("cy", self.cy, "N s/m")
        as_non_negative("cth", self.cth, "N m s/rad")
        as_number("R", self.R, "N")
        as_number("vb", self.vb, "m/s")
        as_number("th0", self.th0, "rad")

    @classmethod
    def set_1(cls, cth: float = 5.0) -> Self:
        """Set 1 of the literature: a stable equilibrium for cth = 5, a stick-slip limit cycle for cth = 0.5."""
        return cls(m=1.0, mu=1.2, cth=cth, vb=5.0)

    def system(self) -> System:
        """The system with one bilateral contact with friction at the tip."""
        return System(
            n_q=2, mass=mass, force=force, gap=gap, normal=normal, tangent=tangent, surface_velocity=surface_velocity,
            row_rates=row_rates, stiffness=stiffness, damping=damping, potential=potential,
            contacts=[Contact(mu="mu", bilateral=True, at=tip)], parameters=self, name=self.name,
        )  # fmt: skip

    def state(self, th: float = 0.78, thdot: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
        """q0 (2,) and u0 (2,) on the constraint, y = l sin th, from the angle [rad] and its rate [rad/s].

        The default state lies in region A3 of set 2: it has no solution with finite forces.
        """
        state = np.zeros(4)
        natural_state(0.0, (as_number("th", th, "rad"), as_number("thdot", thdot, "rad/s")), self, state)
        return state[:2], state[2:]

    def v_t(self, th: float, thdot: float) -> float:
        """vb - l th' sin th = -gamma_F: velocity of the belt relative to the tip [m/s]."""
        return self.vb - self.l * thdot * np.sin(th)

    def reduced(self, th: float, branch: int = 1) -> Reduced:
        """Coefficients of the reduced equation; branch = sgn(v_t la_N): +1 for mu_s = mu, -1 for mu_s = -mu.

        th may be an array.
        """
        if branch not in (-1, 1):
            raise InvalidInput(f"branch must be +1 or -1, the sign of v_t la_N; got {branch!r}")
        mu_s, s, c, l = branch * self.mu, np.sin(th), np.cos(th), self.l
        c_xi, ll = c - mu_s * s, l * l  # xi cos th
        return Reduced(
            M=self.I + self.m * ll * c * c_xi,
            C=self.cth + self.cy * ll * c * c_xi,
            G=-self.m * ll * s * c_xi,
            F=self.ky * ll * s * c_xi + self.kth * (th - self.th0) - l * self.R * mu_s * s,
            K=self.kth + self.ky * ll * (np.cos(2 * th) - mu_s * np.sin(2 * th)) - l * self.R * mu_s * c,
        )

    def Lambda(self, th: float, thdot: float) -> float:
        """Lambda(th, th') [N kg m^2], la_N = Lambda/M: the same on both branches. Arguments may be arrays."""
        s, c, m, l = np.sin(th), np.cos(th), self.m, self.l
        return (
            self.I * self.ky * l * s
            - self.kth * m * l * c * (th - self.th0)
            + (m * l * l * c * c + self.I) * self.R
            - m * self.I * l * thdot**2 * s
            + (self.I * self.cy - self.cth * m) * l * thdot * c
        )

    def region(self, th: float, thdot: float) -> np.ndarray:
        """0 .. 4 for the regions A0 .. A4, 0 < th < pi/2 and vb > 0; arrays broadcast.

        A0: M+ > 0, one solution. M+ < 0: A1 (v_t > 0, Lambda < 0) two, A2 (v_t < 0, Lambda < 0) none, A3 (v_t > 0,
        Lambda > 0) none, A4 (v_t < 0, Lambda > 0) two; `SOLUTIONS` holds these numbers.
        """
        slips = self.v_t(th, thdot) > 0
        inside = np.where(self.Lambda(th, thdot) > 0, np.where(slips, 3, 4), np.where(slips, 1, 2))
        return np.where(self.reduced(th).M > 0, 0, inside)

    def normal_forces(self, th: float, thdot: float) -> tuple[float, ...]:
        """Every la_N while the tip slips [N], in increasing order.

        Raises
        ------
        InvalidInput
            At v_t = 0, where the tip sticks: see `stick_forces`.
        """
        v_t, Lambda = self.v_t(th, thdot), self.Lambda(th, thdot)
        if v_t == 0:
            raise InvalidInput("the tip must slip (v_t != 0); see stick_forces")
        if Lambda == 0:
            return (0.0,)
        solutions = []
        for branch in (1, -1):
            M = float(self.reduced(th, branch).M)
            if M != 0 and branch * v_t * Lambda / M > 0:
                solutions.append(float(Lambda) / M)
        return tuple(sorted(solutions))

    def angular_acceleration(self, th: float, thdot: float, la_N: float) -> float:
        """th'' of the slipping rod on the branch of the solution la_N [rad/s^2]."""
        r = self.reduced(th, 1 if la_N * self.v_t(th, thdot) >= 0 else -1)
        return float(-(r.C * thdot + r.G * thdot**2 + r.F) / r.M)

    def stick_forces(self, th: float) -> tuple[float, float]:
        """(la_N, la_F) [N] while the tip moves with the belt: th' = vb/(l sin th), th'' = -th'^2 cot th."""
        s, c, l = math.sin(th), math.cos(th), self.l
        thdot = self.vb / (l * s)
        thddot = -(thdot**2) * c / s
        la_N = self.m * l * (c * thddot - s * thdot**2) + self.cy * l * c * thdot + self.ky * l * s + self.R
        moment = self.I * thddot + self.cth * thdot + self.kth * (th - self.th0)
        return la_N, (moment - (self.R - la_N) * l * c) / (l * s)

    def equilibrium(self, branch: int = 1, near: float | None = None) -> float:
        """Angle with F = 0 on a branch [rad], by Newton's method from ``near`` (th0 when left out).

        The equilibrium exists on the + branch while la_N v_t > 0; F- = 0 is virtual where la_N > 0.

        Raises
        ------
        InvalidInput
            When Newton's method does not converge from there.
        """
        th = self.th0 if near is None else as_number("near", near, "rad")
        for _ in range(50):
            r = self.reduced(th, branch)
            change = float(r.F / r.K)
            th -= change
            if not math.isfinite(th):
                break
            if abs(change) <= 1e-15 * (1 + abs(th)):  # two units in the last place
                return th
        raise InvalidInput(f"Newton's method for F = 0 did not converge from {near}; give another start")

    def eigenvalues(self, branch: int = 1, th: float | None = None) -> np.ndarray:
        """The two eigenvalues at an equilibrium of a branch [1/s], M s^2 + C s + K = 0."""
        r = self.reduced(self.equilibrium(branch) if th is None else th, branch)
        return np.roots([r.M, r.C, r.K]).astype(complex)

    def critical_friction(self, th: float) -> float:
        """cot th + I/(m l^2 sin th cos th): M+ < 0 above it, 0 < th < pi/2."""
        return 1 / math.tan(th) + self.I / (self.m * self.l**2 * math.sin(th) * math.cos(th))

    def damping_friction(self, th: float) -> float:
        """cot th + cth/(cy l^2 sin th cos th): C+ < 0 above it, 0 < th < pi/2; inf without the damper cy."""
        if self.cy == 0:
            return math.inf
        return 1 / math.tan(th) + self.cth / (self.cy * self.l**2 * math.sin(th) * math.cos(th))

    def paradoxical_angles(self) -> tuple[float, float] | None:
        """The angles between which M+ < 0 [rad], or None: mu sin 2th - cos 2th = 1 + 2 I/(m l^2)."""
        level = (1 + 2 * self.I / (self.m * self.l**2)) / math.hypot(1.0, self.mu)
        if level >= 1:
            return None
        shift = math.atan2(1.0, self.mu)
        return 0.5 * (math.asin(level) + shift), 0.5 * (math.pi - math.asin(level) + shift)

    def stick_rate(self, th: float) -> float:
        """th' on the curve v_t = 0, vb/(l sin th) [rad/s]. th may be an array."""
        return self.vb / (self.l * np.sin(th))

    def zero_force_rates(self, th: float) -> tuple[float, float] | None:
        """The two th' on the curve Lambda = 0 at an angle th in (0, pi/2) [rad/s], or None beyond its apex."""
        square, free = -self.m * self.I * self.l * math.sin(th), float(self.Lambda(th, 0.0))
        linear = (self.I * self.cy - self.cth * self.m) * self.l * math.cos(th)
        discriminant = linear**2 - 4 * square * free
        if discriminant < 0:
            return None
        half, root = -linear / (2 * square), math.sqrt(discriminant) / (2 * abs(square))
        return half - root, half + root

    def seizure(self, th: float, thdot: float) -> Seizure:
        """The jump that seizes the tip: th'+ = vb/(l sin th), no restitution, frozen configuration."""
        after, s, c = float(self.stick_rate(th)), math.sin(th), math.cos(th)
        P_N = self.m * self.l * c * (after - thdot)
        return Seizure(after, P_N, (self.I * (after - thdot) + self.l * c * P_N) / (self.l * s))

    def shape(self, q: np.ndarray) -> list[np.ndarray]:
        """The rod as a polyline (2, 2) from its pivot, on the line x = 0, to its tip."""
        pivot = np.array([0.0, q[0]])
        return [np.array([pivot, pivot - self.l * np.array([math.cos(q[1]), math.sin(q[1])])])]

    phase_axes = (1, 1)  # the coordinate and the velocity of the phase plane, th and th'

    def phase_map(self, th: np.ndarray, thdot: np.ndarray) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Numbers of solutions on a grid of the phase plane, and the fields whose zeros bound the regions."""
        M = self.I + self.m * self.l**2 * np.cos(th) * (np.cos(th) - self.mu * np.sin(th))
        fields = {"$v_t = 0$": self.v_t(th, thdot), "$N = 0$": self.Lambda(th, thdot), "$M = 0$": M + 0 * thdot}
        return np.take(SOLUTIONS, self.region(th, thdot)), fields

    def outline(self) -> list[np.ndarray]:
        """The belt and the guide of the pivot."""
        return [np.array([[-1.5 * self.l, 0.0], [0.5 * self.l, 0.0]]), np.array([[0.0, 0.0], [0.0, 1.5 * self.l]])]
