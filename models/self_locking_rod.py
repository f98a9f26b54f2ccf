"""Self-locking: a pivoted rod whose free end is pressed on a moving plane.

The pivot is fixed above the plane at the height l sin th0; th is the angle of the rod below the horizontal, and the
free end is at (-l cos th, l (sin th0 - sin th)) from the foot of the pivot. The plane moves with vb, towards the pivot
if vb > 0; the load R presses the free end down:

    I th'' = (R - la_N) l cos th + la_F l sin th
    g_N = l (sin th0 - sin th),    W_N = [-l cos th],    W_F = [l sin th],    w_F = -vb

In contact la_N = R/(1 - mu sgn(vb) tan th0). With vb > 0 it grows without bound as th0 nears arctan(1/mu); beyond,
the problem has no solution whatever: sticking is infeasible too, because G has rank one.
Source: textbook chapter on friction-induced instability (kinematic constraint, self-locking). There the rod is
massless; the normal force does not depend on its inertia.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_fraction, as_non_negative, as_number, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.system import Contact, System

FLICK = -0.5  # chosen: rad/s: of the default rod a flight of 1.1 s


def mass(t, q, p, M):
    M[0, 0] = p.I


def force(t, q, u, p, h):
    h[0] = p.R * p.l * math.cos(q[0])


def gap(t, q, p, g_N):
    g_N[0] = p.l * (math.sin(p.th0) - math.sin(q[0]))


def normal(t, q, p, W_N):
    W_N[0, 0] = -p.l * math.cos(q[0])


def tangent(t, q, p, W_F):
    W_F[0, 0, 0] = p.l * math.sin(q[0])


def surface_velocity(t, q, p, w_F):
    w_F[0, 0] = -p.vb


def row_rates(t, q, u, p, r):
    r[0, 0] = p.l * math.sin(q[0]) * u[0] * u[0]
    r[0, 1] = p.l * math.cos(q[0]) * u[0] * u[0]


def potential(t, q, p, V):
    V[0] = -p.R * p.l * math.sin(q[0])


def free_end(q, p):
    """Return the end of the rod that touches, and the normal of the plane."""
    return (-p.l * math.cos(q[0]), p.l * (math.sin(p.th0) - math.sin(q[0]))), (0.0, 1.0)


@dataclass(frozen=True)
class SelfLockingRod:
    """Pivoted rod on a moving plane: q = (th,), unilateral contact at its free end.

    Parameters
    ----------
    l : float
        Length [m].
    I : float
        Moment of inertia about the pivot [kg m^2]; the contact force does not depend on it.
    mu : float
        Friction coefficient.
    R : float
        Load on the free end, downwards [N].
    vb : float
        Velocity of the plane [m/s]: towards the pivot if positive, away from it if negative.
    th0 : float
        Angle at which the free end touches the plane, 0 < th0 < pi/2 [rad].
    e : float
        Restitution coefficient (Newton).

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> import numpy as np
    >>> from nonsmooth.catalogue import SelfLockingRod
    >>> rod = SelfLockingRod(mu=1.0, th0=np.radians(30))
    >>> round(rod.normal_force(), 6), round(float(np.degrees(rod.jam_angle())), 6)
    (2.366025, 45.0)
    >>> SelfLockingRod(mu=1.0, th0=np.radians(50)).normal_force() is None
    True
    """

    l: float = 1.0  # length [m]
    I: float = 1.0  # inertia about the pivot [kg m^2]
    mu: float = 1.0  # friction coefficient [-]
    R: float = 1.0  # load on the free end [N]
    vb: float = 1.0  # velocity of the plane, towards the pivot [m/s]
    th0: float = math.pi / 6  # angle at contact [rad]
    e: float = 0.0  # restitution [-]

    name = "self-locking-rod"
    source = "textbook chapter on friction-induced instability: self-locking (the inertia is added here)"
    coordinates = (("th", "rad"),)
    parts = ("rod",)
    t_end = 2.0  # s
    dt = 1e-3  # s

    def __post_init__(self) -> None:
        as_positive("l", self.l, "m")
        as_positive("I", self.I, "kg m^2")
        as_non_negative("mu", self.mu)
        as_non_negative("R", self.R, "N")
        as_number("vb", self.vb, "m/s")
        as_fraction("e", self.e)
        if not 0 < as_number("th0", self.th0, "rad") < math.pi / 2:
            raise InvalidInput(f"th0 must lie in (0, pi/2) rad; got {self.th0:g}")

    def system(self) -> System:
        """The system with one unilateral contact with friction."""
        return System(
            n_q=1, mass=mass, force=force, gap=gap, normal=normal, tangent=tangent, surface_velocity=surface_velocity,
            row_rates=row_rates, potential=potential,
            contacts=[Contact(mu="mu", e_N="e", at=free_end)],
            parameters=self, name=self.name,
        )  # fmt: skip

    def state(self, th: float | None = None, thdot: float | None = None) -> tuple[np.ndarray, np.ndarray]:
        """q0 (1,) and u0 (1,) at an angle [rad] (th0, in contact, when left out) and an angular velocity [rad/s].

        Both left out, the rod was flicked off the plane at FLICK: it falls back, and slides or jams. With an angle
        alone it is at rest there.
        """
        if thdot is None:
            thdot = FLICK if th is None else 0.0
        th = self.th0 if th is None else as_number("th", th, "rad")
        return np.array([th]), np.array([as_number("thdot", thdot, "rad/s")])

    def normal_force(self) -> float | None:
        """la_N = R/(1 - mu sgn(vb) tan th0) [N] while the plane slides; None beyond the jamming angle.

        Raises
        ------
        InvalidInput
            For vb = 0: the friction force, and with it the normal force, is not determined.
        """
        if self.vb == 0:
            raise InvalidInput("vb must not be zero: the direction of sliding decides the normal force")
        divisor = 1 - self.mu * math.copysign(math.tan(self.th0), self.vb)
        if self.jams() or divisor <= 0:
            return None if self.R > 0 else 0.0
        return self.R / divisor

    def jam_angle(self) -> float:
        """arctan(1/mu) [rad]: at and beyond it a plane moving towards the pivot jams; pi/2 without friction."""
        return math.atan2(1.0, self.mu)

    def jams(self) -> bool:
        """Whether the contact has no solution: vb > 0, R > 0 and th0 at or beyond the jamming angle."""
        return self.vb > 0 and self.R > 0 and self.th0 >= self.jam_angle()

    def shape(self, q: np.ndarray) -> list[np.ndarray]:
        """The rod as a polyline (2, 2) from its pivot to its free end; the foot of the pivot is the origin."""
        pivot = np.array([0.0, self.l * math.sin(self.th0)])
        return [np.array([pivot, pivot - self.l * np.array([math.cos(q[0]), math.sin(q[0])])])]

    def outline(self) -> list[np.ndarray]:
        """The plane."""
        return [np.array([[-1.5 * self.l, 0.0], [0.5 * self.l, 0.0]])]
