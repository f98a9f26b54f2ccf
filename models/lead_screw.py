"""Lead screw: a nut that drives a mass along a screw, rigid bilateral threads with friction.

The screw (inertia I, mean thread radius r, lead angle lam) is turned by a torsion spring k from the input angle
thi + omega t; the nut (mass m) moves against the load R:

    I th'' = k (thi + omega t - th) - c th' - r (la_N sin lam - la_F cos lam)
    m x''  = la_N cos lam + la_F sin lam - cx x' - R
    g_N = x cos lam - r th sin lam,    W_N = [cos lam, -r sin lam],    W_F = [sin lam, r cos lam]

with |la_F| <= mu |la_N|. On the constraint x = r th tan lam, with mu_s = mu sgn(la_N th') and
xi = tan(lam + arctan mu_s),

    Gamma th'' + (c + cx r^2 xi tan lam) th' + k (th - thi) + r xi R = 0,    Gamma = I + m r^2 xi tan lam
    la_N = Lambda_0/((cos lam - mu_s sin lam) Gamma)

Gamma(-mu) < 0 is the paradox: none or two forces. Source: Vahid-Araghi and Golnaraghi, *Friction-Induced Vibration in
Lead Screw Drives* (2011), chapters 4 and 8.
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
    M[1, 1] = p.I


def force(t, q, u, p, h):
    h[0] = -p.cx * u[0] - p.R
    h[1] = p.k * (p.thi + p.omega * t - q[1]) - p.c * u[1]


def gap(t, q, p, g_N):
    g_N[0] = q[0] * math.cos(p.lam) - p.r * q[1] * math.sin(p.lam)


def normal(t, q, p, W_N):
    W_N[0, 0] = math.cos(p.lam)
    W_N[0, 1] = -p.r * math.sin(p.lam)


def tangent(t, q, p, W_F):
    W_F[0, 0, 0] = math.sin(p.lam)
    W_F[0, 0, 1] = p.r * math.cos(p.lam)


def row_rates(t, q, u, p, r):
    r[0, 0] = 0.0


def stiffness(t, q, u, p, K):
    K[1, 1] = p.k


def damping(t, q, u, p, C):
    C[0, 0] = p.cx
    C[1, 1] = p.c


def potential(t, q, p, V):
    V[0] = p.R * q[0] + 0.5 * p.k * (p.thi + p.omega * t - q[1]) ** 2


def natural_state(t, s, p, x):
    lead = p.r * math.tan(p.lam)
    x[0] = lead * s[0]
    x[1] = s[0]
    x[2] = lead * s[1]
    x[3] = s[1]


@dataclass(frozen=True)
class LeadScrew:
    """Lead screw with rigid threads: q = (x, th), the nut and the screw; bilateral contact.

    Parameters
    ----------
    m, I : float
        Mass of the nut [kg] and inertia of the screw [kg m^2].
    r, lam : float
        Mean radius of the thread [m] and lead angle [rad].
    k, c, cx : float
        Stiffness of the coupling [N m/rad], damping of the rotation [N m s/rad] and of the nut [N s/m].
    R : float
        Load on the nut, against x [N].
    mu : float
        Friction coefficient; mu tan(lam) < 1.
    thi, omega : float
        Input angle at t = 0 [rad] and its speed [rad/s].

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from nonsmooth.catalogue import LeadScrew
    >>> screw = LeadScrew(mu=0.25)
    >>> round(screw.critical_friction(), 9)
    0.219303854
    >>> screw.normal_forces(th=0.0, thdot=-1.0)
    ()
    """

    m: float = 10.0  # mass [kg]
    I: float = 3.12e-6  # inertia [kg m^2]
    r: float = 5.18e-3  # thread radius [m]
    lam: float = math.radians(5.57)  # lead angle [rad]
    k: float = 1.0  # coupling stiffness [N m/rad]
    c: float = 2e-5  # damping of the rotation [N m s/rad]
    cx: float = 0.0  # damping of the nut [N s/m]
    R: float = 100.0  # load [N]
    mu: float = 0.25  # friction coefficient [-]
    thi: float = 0.0  # input angle [rad]
    omega: float = 0.0  # input speed [rad/s]

    name = "lead-screw"
    source = "Vahid-Araghi and Golnaraghi, Friction-Induced Vibration in Lead Screw Drives (2011), chapters 4 and 8"
    coordinates = (("x", "m"), ("th", "rad"))
    parts = ("nut", "mark")
    natural_state = staticmethod(natural_state)
    map_axes = (("th", -0.2, 0.3), ("thdot", -50.0, 50.0))
    t_end = 0.02  # s
    dt = 1e-5  # s

    def __post_init__(self) -> None:
        as_positive("m", self.m, "kg")
        as_positive("I", self.I, "kg m^2")
        as_positive("r", self.r, "m")
        as_non_negative("k", self.k, "N m/rad")
        as_non_negative("c", self.c, "N m s/rad")
        as_non_negative("cx", self.cx, "N s/m")
        as_number("R", self.R, "N")
        as_non_negative("mu", self.mu)
        as_number("thi", self.thi, "rad")
        as_number("omega", self.omega, "rad/s")
        if not 0 < as_number("lam", self.lam, "rad") < math.pi / 2:
            raise InvalidInput(f"lam must lie in (0, pi/2) rad; got {self.lam:g}")
        if not self.mu * math.tan(self.lam) < 1:
            raise InvalidInput(
                f"mu tan(lam) must be below 1; got {self.mu * math.tan(self.lam):g}: no thread is that steep"
            )

    def system(self) -> System:
        """The system with one bilateral contact with friction in the thread."""
        return System(
            n_q=2, mass=mass, force=force, gap=gap, normal=normal, tangent=tangent, row_rates=row_rates,
            stiffness=stiffness, damping=damping, potential=potential, contacts=[Contact(mu="mu", bilateral=True)],
            parameters=self, name=self.name,
        )  # fmt: skip

    def state(self, th: float = -0.5, thdot: float = 10.0) -> tuple[np.ndarray, np.ndarray]:
        """q0 (2,) and u0 (2,) on the constraint x = r th tan(lam), from the angle [rad] and its rate [rad/s].

        From the default the nut slides, under one of two possible forces, until la_N vanishes; then it seizes.
        """
        state = np.zeros(4)
        natural_state(0.0, (as_number("th", th, "rad"), as_number("thdot", thdot, "rad/s")), self, state)
        return state[:2], state[2:]

    def xi(self, branch: int) -> float:
        """tan(lam + arctan mu_s), with mu_s = branch mu and branch = sgn(la_N th')."""
        if branch not in (-1, 1):
            raise InvalidInput(f"branch must be +1 or -1, the sign of la_N th'; got {branch!r}")
        return math.tan(self.lam + math.atan(branch * self.mu))

    def Gamma(self, branch: int) -> float:
        """Effective inertia I + m r^2 xi tan(lam) of a branch [kg m^2]."""
        return self.I + self.m * self.r**2 * math.tan(self.lam) * self.xi(branch)

    def Lambda_0(self, th: float, thdot: float) -> float:
        """Free moment of the constraint [N kg m^2] at t = 0: la_N = Lambda_0/((cos lam - mu_s sin lam) Gamma)."""
        lead = self.r * math.tan(self.lam)
        return (
            self.I * self.R
            + (self.I * self.cx - self.m * self.c) * lead * thdot
            - self.m * lead * self.k * (th - self.thi)
        )

    def normal_forces(self, th: float, thdot: float) -> tuple[float, ...]:
        """Every la_N while the screw turns [N], in increasing order.

        Raises
        ------
        InvalidInput
            At th' = 0, where the thread sticks.
        """
        if thdot == 0:
            raise InvalidInput("the screw must turn (th' != 0): the direction of friction decides the force")
        Lambda_0 = self.Lambda_0(th, thdot)
        if Lambda_0 == 0:
            return (0.0,)
        solutions = []
        for branch in (1, -1):
            divisor = (math.cos(self.lam) - branch * self.mu * math.sin(self.lam)) * self.Gamma(branch)
            if divisor != 0 and branch * thdot * Lambda_0 / divisor > 0:
                solutions.append(Lambda_0 / divisor)
        return tuple(sorted(solutions))

    def angular_acceleration(self, th: float, thdot: float, la_N: float) -> float:
        """th'' of the turning screw on the branch of the solution la_N [rad/s^2], at t = 0."""
        branch = 1 if la_N * thdot >= 0 else -1
        xi, lead = self.xi(branch), self.r * math.tan(self.lam)
        moment = (self.c + self.cx * self.r * lead * xi) * thdot + self.k * (th - self.thi) + self.r * xi * self.R
        return -moment / self.Gamma(branch)

    def is_self_locking(self) -> bool:
        """mu >= tan(lam): no load on the nut turns the screw."""
        return self.mu >= math.tan(self.lam)

    def critical_friction(self) -> float:
        """(I + m r^2 tan^2 lam)/((m r^2 - I) tan lam): Gamma(-mu) < 0 above it; inf unless m r^2 > I."""
        square, slope = self.m * self.r**2, math.tan(self.lam)
        return (self.I + square * slope**2) / ((square - self.I) * slope) if square > self.I else math.inf

    phase_axes = (1, 1)  # the coordinate and the velocity of the phase plane, th and th'

    def phase_map(self, th: np.ndarray, thdot: np.ndarray) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Numbers of solutions on a grid of the phase plane, and the fields whose zeros bound the regions."""
        Lambda_0 = self.Lambda_0(th, thdot) + 0 * thdot
        numbers = np.where(Lambda_0 * thdot > 0, 2, 0) if self.Gamma(-1) < 0 else np.ones(np.shape(Lambda_0), int)
        return numbers, {"$\\dot\\theta = 0$": thdot + 0 * th, "$N = 0$": Lambda_0}

    def shape(self, q: np.ndarray) -> list[np.ndarray]:
        """The nut on the screw, and a mark that turns with it."""
        r, x = self.r, q[0]
        nut = np.array([[x - r, -2 * r], [x + r, -2 * r], [x + r, 2 * r], [x - r, 2 * r], [x - r, -2 * r]])
        mark = r * math.cos(q[1])
        return [nut, np.array([[-10 * r, mark], [10 * r, mark]])]

    def outline(self) -> list[np.ndarray]:
        """The screw."""
        return [self.r * np.array([[-10.0, side], [10.0, side]]) for side in (-1.0, 1.0)]
