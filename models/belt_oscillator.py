"""Mass on a conveyor: friction that falls with the sliding speed acts as negative damping.

    m x'' + c x' + k x = la_F,    gamma_F = x' - vb,    |la_F| <= N mu(|gamma_F|), opposed to gamma_F
    mu(v) = m0 - m1 v + m3 v^3

With v = vb - x' = -gamma_F the force is N f(v), f(v) = m0 sgn v - m1 v + m3 v^3, and steady sliding is unstable where
c + N f'(vb) < 0. Source: textbook chapter on friction-induced instability (negative damping); the slope, the averaged
equation and the condition of sticking are the corrected ones, see docs/models.md.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nonsmooth.arrays import as_non_negative, as_number, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.laws import Polynomial
from nonsmooth.system import Contact, System


def mass(t, q, p, M):
    M[0, 0] = p.m


def force(t, q, u, p, h):
    h[0] = -p.c * u[0] - p.k * q[0]


def tangent(t, q, p, W_F):
    W_F[0, 0, 0] = 1.0


def surface_velocity(t, q, p, w_F):
    w_F[0, 0] = -p.vb


def row_rates(t, q, u, p, r):
    r[0, 0] = 0.0
    r[0, 1] = 0.0


def normal_force(t, q, u, p, N):
    N[0] = p.N


def stiffness(t, q, u, p, K):
    K[0, 0] = p.k


def damping(t, q, u, p, C):
    C[0, 0] = p.c


def potential(t, q, p, V):
    V[0] = 0.5 * p.k * q[0] * q[0]


@dataclass(frozen=True)
class BeltOscillator:
    """Mass, spring and damper on a moving belt, under a given normal force: q = (x,).

    Parameters
    ----------
    m, k, c : float
        Mass [kg], stiffness [N/m], damping [N s/m].
    N : float
        Normal force [N].
    m0, m1, m3 : float
        Friction law mu(v) = m0 - m1 v + m3 v^3; m1 [s/m], m3 [s^3/m^3]. Constant friction: m1 = m3 = 0.
    vb : float
        Belt speed [m/s].

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from models import BeltOscillator
    >>> belt = BeltOscillator(vb=0.42)
    >>> round(belt.vb_max(), 6), round(belt.vb_min(), 6), round(belt.averaged_amplitude(), 6)
    (0.440959, 0.394405, 0.849575)
    >>> BeltOscillator(m1=0.0, m3=0.0).vb_max()
    0.0
    """

    m: float = 1.0  # mass [kg]
    k: float = 10.0  # stiffness [N/m]
    c: float = 0.1  # damping [N s/m]
    N: float = 1.0  # normal force [N]
    m0: float = 0.4  # friction coefficient at v -> 0 [-]
    m1: float = 0.45  # falling part [s/m]
    m3: float = 0.6  # rising part [s^3/m^3]
    vb: float = 0.2  # belt speed [m/s]

    name = "belt-oscillator"
    source = "textbook chapter on friction-induced instability: negative damping, mass on a conveyor (corrected)"
    coordinates = (("x", "m"),)
    t_end = 20.0  # s
    dt = 1e-3  # s

    def __post_init__(self) -> None:
        as_positive("m", self.m, "kg")
        as_positive("k", self.k, "N/m")
        as_non_negative("c", self.c, "N s/m")
        as_non_negative("N", self.N, "N")
        as_non_negative("m0", self.m0)
        as_number("m1", self.m1, "s/m")
        as_number("m3", self.m3, "s^3/m^3")
        as_number("vb", self.vb, "m/s")

    def system(self) -> System:
        """The system with one friction contact under the given normal force N."""
        return System(
            n_q=1, mass=mass, force=force, tangent=tangent, surface_velocity=surface_velocity, row_rates=row_rates,
            normal_force=normal_force, stiffness=stiffness, damping=damping, potential=potential,
            contacts=[Contact(mu=Polynomial("m0", "m1", "m3"), normal_force=True)], parameters=self, name=self.name,
        )  # fmt: skip

    def state(self, x: float = 0.0, velocity: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """q0 (1,) and u0 (1,) from the position x [m] (spring at rest: 0) and the velocity [m/s]."""
        return np.array([as_number("x", x, "m")]), np.array([as_number("velocity", velocity, "m/s")])

    def friction(self, v: float) -> float:
        """f(v) = m0 sgn v - m1 v + m3 v^3 with v = vb - x'; at v = 0, the middle of its set of values, zero."""
        return self.m0 * float(np.sign(v)) - self.m1 * v + self.m3 * v**3

    def slope(self) -> float:
        """f'(vb) = -m1 + 3 m3 vb^2 [s/m]."""
        return -self.m1 + 3 * self.m3 * self.vb**2

    def equilibrium(self) -> float:
        """Position of steady sliding, x = N f(vb)/k [m]."""
        return self.N * self.friction(self.vb) / self.k

    def eigenvalues(self) -> np.ndarray:
        """The two eigenvalues of steady sliding [1/s]: m s^2 + (c + N f'(vb)) s + k = 0."""
        return np.roots([self.m, self.c + self.N * self.slope(), self.k]).astype(complex)

    def vb_max(self) -> float:
        """Belt speed below which steady sliding is unstable, sqrt((m1 N - c)/(3 m3 N)) [m/s]; 0: always stable."""
        drive = self.m1 * self.N - self.c
        if drive <= 0:
            return 0.0
        return math.sqrt(drive / (3 * self.m3 * self.N)) if self.m3 > 0 else math.inf

    def vb_min(self) -> float:
        """Belt speed above which the averaged motion never sticks, sqrt(4/5) vb_max [m/s] (first-order averaging)."""
        return math.sqrt(0.8) * self.vb_max()

    def averaged_amplitude(self) -> float:
        """Amplitude a_1 of the averaged motion in units of N/k: y = x - equilibrium() swings by a_1 N/k.

        Zero where steady sliding is stable.

        Raises
        ------
        InvalidInput
            For |vb| < vb_min(): the averaged motion would overtake the belt, so the mass sticks and slips.
        """
        if abs(self.vb) >= self.vb_max():
            return 0.0
        if abs(self.vb) < self.vb_min() or self.m3 <= 0:
            raise InvalidInput(
                f"pure-slip averaging holds for |vb| > vb_min = {self.vb_min():g} m/s and m3 > 0; "
                f"got vb = {self.vb:g}, m3 = {self.m3:g}; integrate the motion instead"
            )
        Lo = self.N / self.k * math.sqrt(self.k / self.m)  # velocity scale Lambda omega [m/s]
        k_1 = Lo * self.m1 - 3 * Lo * self.m3 * self.vb**2
        k_3 = Lo**3 * self.m3
        return 2 * math.sqrt((k_1 - self.c / math.sqrt(self.k * self.m)) / (3 * k_3))

    def release_position(self) -> float:
        """Position at which the sticking mass lets go of the belt, x = (N m0 - c vb)/k for vb > 0 [m]."""
        return (math.copysign(self.N * self.m0, self.vb) - self.c * self.vb) / self.k

    def shape(self, q: np.ndarray) -> list[np.ndarray]:
        """The mass (0.06 m square) and its spring as polylines (k, 2)."""
        x, a = float(q[0]), 0.03
        box = np.array([[-a, 0.0], [a, 0.0], [a, 2 * a], [-a, 2 * a], [-a, 0.0]]) + np.array([x, 0.0])
        coils = np.linspace(-0.4, x - a, 18)
        zigzag = a + 0.01 * np.concatenate([[0.0], np.tile([1.0, -1.0], 8), [0.0]])
        return [box, np.column_stack([coils, zigzag])]

    def outline(self) -> list[np.ndarray]:
        """The belt and the wall."""
        return [np.array([[-0.4, 0.0], [0.4, 0.0]]), np.array([[-0.4, 0.0], [-0.4, 0.1]])]
