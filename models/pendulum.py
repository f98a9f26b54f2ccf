"""Pendulum striking a wall.

    m l^2 th'' = -m g l sin th + W_N la_N,    g_N = l (sin th - sin th_w) >= 0,    th'_plus = -e th'_minus

th is measured from the hanging position; the wall is the vertical line that the bob meets at th_w. Between impacts
the motion is the free pendulum's, known through elliptic integrals. With th_w > 0 gravity presses the bob on the wall
and the impacts accumulate; with th_w <= 0 they do not.
Source: the standard impact pendulum, e.g. Brogliato, *Nonsmooth Mechanics* (2016); Whittaker, *Analytical Dynamics*.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_count, as_fraction, as_number, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.system import Contact, System


def mass(t, q, p, M):
    M[0, 0] = p.m * p.l * p.l


def force(t, q, u, p, h):
    h[0] = -p.m * p.g * p.l * math.sin(q[0])


def gap(t, q, p, g_N):
    g_N[0] = p.l * (math.sin(q[0]) - math.sin(p.th_w))


def normal(t, q, p, W_N):
    W_N[0, 0] = p.l * math.cos(q[0])


def row_rates(t, q, u, p, r):
    r[0, 0] = -p.l * math.sin(q[0]) * u[0] * u[0]


def potential(t, q, p, V):
    V[0] = -p.m * p.g * p.l * math.cos(q[0])


def bob(q, p):
    """Return the place of the bob and the normal of the wall."""
    return (p.l * math.sin(q[0]), -p.l * math.cos(q[0])), (1.0, 0.0)


@dataclass(frozen=True)
class WallPendulum:
    """Point mass on a massless rod that swings against a wall: q = (th,), frictionless contact.

    Parameters
    ----------
    m : float
        Mass of the bob [kg].
    l : float
        Length [m].
    g : float
        Gravity [m/s^2].
    th_w : float
        Angle at which the bob meets the wall, -pi/2 < th_w < pi/2 [rad]; it swings on the side th >= th_w.
    e : float
        Restitution coefficient (Newton).

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from nonsmooth.catalogue import WallPendulum
    >>> pendulum = WallPendulum()
    >>> pendulum.impact_times(2, th=1.0).round(6)
    array([0.534784, 1.578109])
    """

    m: float = 1.0  # mass [kg]
    l: float = 1.0  # length [m]
    g: float = 9.81  # gravity [m/s^2]
    th_w: float = 0.0  # angle at the wall [rad]
    e: float = 0.8  # restitution [-]

    name = "wall-pendulum"
    source = "Brogliato, Nonsmooth Mechanics (2016); Whittaker, Analytical Dynamics"
    coordinates = (("th", "rad"),)
    parts = ("rod", "bob")
    t_end = 5.0  # s
    dt = 1e-3  # s

    def __post_init__(self) -> None:
        as_positive("m", self.m, "kg")
        as_positive("l", self.l, "m")
        as_positive("g", self.g, "m/s^2")
        as_fraction("e", self.e)
        if not abs(as_number("th_w", self.th_w, "rad")) < math.pi / 2:
            raise InvalidInput(f"th_w must lie in (-pi/2, pi/2) rad; got {self.th_w:g}")

    def system(self) -> System:
        """The system with one frictionless unilateral contact."""
        return System(
            n_q=1, mass=mass, force=force, gap=gap, normal=normal, row_rates=row_rates, potential=potential,
            contacts=[Contact(e_N="e", at=bob)], parameters=self, name=self.name,
        )  # fmt: skip

    def state(self, th: float = 1.0, thdot: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """q0 (1,) and u0 (1,) from the angle [rad] and the angular velocity [rad/s]."""
        return np.array([as_number("th", th, "rad")]), np.array([as_number("thdot", thdot, "rad/s")])

    def omega(self) -> float:
        """sqrt(g/l) [rad/s]."""
        return math.sqrt(self.g / self.l)

    def peak_angles(self, n: int, th: float = 1.0) -> np.ndarray:
        """The n greatest angles th_0, th_1, ... (n,) [rad], from rest at th_0 = th; one impact between two of them.

        cos th_w - cos th_k is multiplied by e^2 at each impact.
        """
        self._check_start(th)
        drop = (math.cos(self.th_w) - math.cos(th)) * self.e ** (2 * np.arange(as_count("n", n)))
        return np.arccos(math.cos(self.th_w) - drop)

    def impact_times(self, n: int, th: float = 1.0) -> np.ndarray:
        """Times of the first n impacts (n,) [s], from rest at th."""
        swings = np.array([self._fall_time(peak) for peak in self.peak_angles(n, th)])
        return np.cumsum(swings) + np.concatenate([[0.0], np.cumsum(swings[1:])])

    def impact_rates(self, n: int, th: float = 1.0) -> np.ndarray:
        """Angular velocities just before the first n impacts (n,) [rad/s], from rest at th."""
        self._check_start(th)
        first = -self.omega() * math.sqrt(2 * (math.cos(self.th_w) - math.cos(th)))
        return first * self.e ** np.arange(as_count("n", n))

    def _check_start(self, th: float) -> None:
        low, high = abs(self.th_w), math.pi - max(0.0, self.th_w)  # above high the bob is behind the wall
        if not low < as_number("th", th, "rad") < high:
            raise InvalidInput(f"th must lie between {low:g} and {high:g} rad; got {th:g}")

    def _fall_time(self, peak: float) -> float:
        """Time from rest at ``peak`` to th_w: (K(k) - F(arcsin(sin(th_w/2)/k), k))/omega, k = sin(peak/2)."""
        from scipy.special import ellipk, ellipkinc

        k = math.sin(0.5 * peak)
        phase = math.asin(max(-1.0, min(1.0, math.sin(0.5 * self.th_w) / k))) if k > 0 else 0.0
        return float(ellipk(k * k) - ellipkinc(phase, k * k)) / self.omega()

    def shape(self, q: np.ndarray) -> list[np.ndarray]:
        """The rod (2, 2) and the bob, drawn with a radius of 0.05 l, as polylines; the pivot is the origin."""
        bob = self.l * np.array([math.sin(q[0]), -math.cos(q[0])])
        angle = np.linspace(0.0, 2 * np.pi, 25)
        return [np.array([[0.0, 0.0], bob]), bob + 0.05 * self.l * np.column_stack([np.cos(angle), np.sin(angle)])]

    def outline(self) -> list[np.ndarray]:
        """The wall."""
        x = self.l * math.sin(self.th_w)
        return [np.array([[x, -1.2 * self.l], [x, 1.2 * self.l]])]
