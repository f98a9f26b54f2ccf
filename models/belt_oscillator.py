"""Mass on a conveyor: friction that falls with the sliding speed acts as negative damping.

    m x'' + c x' + k x = la_F,    gamma_F = x' - vb,    |la_F| <= N mu(|gamma_F|), opposed to gamma_F

    law                 mu(v), v > 0                                        limit of sticking
    "cubic"             m0 - m1 v + m3 v^3                                  m0
    "smoothed"          m0 (1 - exp(-r v)) - m1 v + m3 v^3                  0: it never sticks
    "two-coefficient"   mu_k                                                m0
    "stribeck"          mu_k + (m0 - mu_k) exp(-v/v_s) + m_v v              m0

With v = vb - x' = -gamma_F the force is N f(v), f(v) = mu(|v|) sgn v, and steady sliding is unstable where
c + N f'(vb) < 0. Source: textbook chapter on friction-induced instability (negative damping); the slopes, the averaged
equation and the condition of sticking are the corrected ones, see docs/models.md. Averaged motions of every law:
`nonsmooth.averaged_amplitude`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_non_negative, as_number, as_positive
from nonsmooth.errors import InvalidInput, UnknownName, nearest
from nonsmooth.mechanics.laws import FrictionLaw, Polynomial, Smoothed, StaticKinetic, Stribeck
from nonsmooth.mechanics.system import Contact, System

LAWS: dict[str, FrictionLaw] = {
    "cubic": Polynomial("m0", "m1", "m3"),
    "smoothed": Smoothed("m0", "r", "m1", "m3"),
    "two-coefficient": StaticKinetic("m0", "mu_k"),
    "stribeck": Stribeck("m0", "mu_k", "v_s", 1.0, "m_v"),
}


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


def foot(q):
    """Return the middle of the lower side of the mass and the normal of the belt."""
    return (q[0], 0.0), (0.0, 1.0)


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
        Cubic law mu(v) = m0 - m1 v + m3 v^3: m0 [-], m1 [s/m], m3 [s^3/m^3]. Constant friction: m1 = m3 = 0. In every
        law but the smoothed one m0 is the limit of sticking.
    vb : float
        Belt speed [m/s].
    r : float
        Rate of the smoothed law [s/m].
    mu_k : float
        Kinetic friction coefficient of the two-coefficient and of Stribeck's law, at most m0.
    v_s, m_v : float
        Speed over which Stribeck's law falls [m/s], and its viscous part [s/m].
    law : {"cubic", "smoothed", "two-coefficient", "stribeck"}
        Law of friction: cubic, smoothed, two-coefficient or stribeck.

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from nonsmooth.catalogue import BeltOscillator
    >>> belt = BeltOscillator(vb=0.42)
    >>> round(belt.vb_max(), 6), round(belt.vb_min(), 6), round(belt.averaged_amplitude(), 6)
    (0.440959, 0.394405, 0.849575)
    >>> BeltOscillator(m1=0.0, m3=0.0).vb_max()
    0.0
    >>> low, high = BeltOscillator(law="smoothed", r=20.0).unstable_speeds()
    >>> round(low, 9), round(high, 9)
    (0.163896782, 0.440201331)
    """

    m: float = 1.0  # mass [kg]
    k: float = 10.0  # stiffness [N/m]
    c: float = 0.1  # damping [N s/m]
    N: float = 1.0  # normal force [N]
    m0: float = 0.4  # friction coefficient at v -> 0 [-]
    m1: float = 0.45  # falling part [s/m]
    m3: float = 0.6  # rising part [s^3/m^3]
    vb: float = 0.2  # belt speed [m/s]
    r: float = 20.0  # rate of the smoothed law [s/m]
    mu_k: float = 0.3  # kinetic coefficient of the laws of two levels [-]
    v_s: float = 0.1  # Stribeck's speed [m/s]
    m_v: float = 0.0  # viscous part of Stribeck's law [s/m]
    law: str = "cubic"

    name = "belt-oscillator"
    source = "textbook chapter on friction-induced instability: negative damping, mass on a conveyor (corrected)"
    coordinates = (("x", "m"),)
    parts = ("mass", "spring")
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
        as_positive("r", self.r, "s/m")
        as_non_negative("mu_k", self.mu_k)
        as_positive("v_s", self.v_s, "m/s")
        as_number("m_v", self.m_v, "s/m")
        if self.law not in LAWS:
            raise UnknownName(f"there is no friction law {self.law!r}; {nearest(self.law, LAWS)}")
        if self.law in ("two-coefficient", "stribeck"):
            as_non_negative("m0 - mu_k", self.m0 - self.mu_k)

    @property
    def idle(self) -> tuple[str, ...]:
        """The parameters of the other laws of friction, which this one does not read."""
        named = {law: {value for value in vars(one).values() if isinstance(value, str)} for law, one in LAWS.items()}
        return tuple(sorted(set().union(*named.values()) - named[self.law]))

    def system(self) -> System:
        """The system with one friction contact under the given normal force N."""
        return System(
            n_q=1, mass=mass, force=force, tangent=tangent, surface_velocity=surface_velocity, row_rates=row_rates,
            normal_force=normal_force, stiffness=stiffness, damping=damping, potential=potential,
            contacts=[Contact(mu=LAWS[self.law], normal_force=True, at=foot)], parameters=self, name=self.name,
        )  # fmt: skip

    def state(self, x: float = 0.0, velocity: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """q0 (1,) and u0 (1,) from the position x [m] (spring at rest: 0) and the velocity [m/s]."""
        return np.array([as_number("x", x, "m")]), np.array([as_number("velocity", velocity, "m/s")])

    def friction(self, v: float) -> float:
        """f(v) = mu(|v|) sgn v with v = vb - x'; at v = 0, the middle of its set of values, zero. v may be an array."""
        speed = np.abs(v)
        cubic = speed * (self.m3 * speed**2 - self.m1)
        mu = {
            "cubic": self.m0 + cubic,
            "smoothed": -self.m0 * np.expm1(-self.r * speed) + cubic,
            "two-coefficient": self.mu_k + 0 * speed,
            "stribeck": self.mu_k + (self.m0 - self.mu_k) * np.exp(-speed / self.v_s) + self.m_v * speed,
        }
        return np.sign(v) * mu[self.law]

    def slope(self, v: float | None = None) -> float:
        """f'(v) [s/m] at a sliding speed v [m/s], at the belt's speed when left out. v may be an array."""
        speed = np.abs(self.vb if v is None else v)
        cubic = 3 * self.m3 * speed**2 - self.m1
        return {
            "cubic": cubic,
            "smoothed": self.r * self.m0 * np.exp(-self.r * speed) + cubic,
            "two-coefficient": 0.0 * speed,
            "stribeck": -(self.m0 - self.mu_k) / self.v_s * np.exp(-speed / self.v_s) + self.m_v,
        }[self.law]

    def equilibrium(self) -> float:
        """Position of steady sliding, x = N f(vb)/k [m]."""
        return self.N * self.friction(self.vb) / self.k

    def eigenvalues(self) -> np.ndarray:
        """The two eigenvalues of steady sliding [1/s]: m s^2 + (c + N f'(vb)) s + k = 0."""
        return np.roots([self.m, self.c + self.N * self.slope(), self.k]).astype(complex)

    def vb_max(self) -> float:
        """Belt speed below which steady sliding is unstable under the cubic law, sqrt((m1 N - c)/(3 m3 N)) [m/s].

        0: stable at every speed. Of the other laws see `unstable_speeds`.
        """
        drive = self.m1 * self.N - self.c
        if drive <= 0:
            return 0.0
        return math.sqrt(drive / (3 * self.m3 * self.N)) if self.m3 > 0 else math.inf

    def vb_min(self) -> float:
        """Belt speed above which the averaged motion never sticks, sqrt(4/5) vb_max [m/s] (cubic law, first order)."""
        return math.sqrt(0.8) * self.vb_max()

    def unstable_speeds(self) -> tuple[float, float] | None:
        """The range of belt speeds in which steady sliding is unstable, c + N f'(vb) < 0 [m/s], or None.

        With the smoothed law it begins above zero: c/N + r m0 exp(-r v) - m1 + 3 m3 v^2 falls to its only minimum and
        rises again, so it has two zeros or none.
        """
        if self.law == "cubic":
            high = self.vb_max()
            return (0.0, high) if high > 0 else None
        if self.law == "stribeck":
            return self._falling_speeds()
        if self.law == "two-coefficient" or self.N == 0:
            return None
        return self._between_the_zeros()

    def _falling_speeds(self) -> tuple[float, float] | None:
        fall, rise = (self.m0 - self.mu_k) / self.v_s * self.N, self.c + self.N * self.m_v
        if fall <= rise:
            return None
        return 0.0, self.v_s * math.log(fall / rise) if rise > 0 else math.inf

    def _between_the_zeros(self) -> tuple[float, float] | None:
        from scipy.optimize import brentq

        def growth(v: float) -> float:
            return float(self.c + self.N * self.slope(v))

        def curvature(v: float) -> float:
            return 6 * self.m3 * v - self.r**2 * self.m0 * math.exp(-self.r * v)

        if self.m1 * self.N <= self.c:
            return None
        level = self.r * self.m0 * self.N / (self.m1 * self.N - self.c)
        falling = max(math.log(level), 0.0) / self.r if level > 0 else 0.0  # the zero for m3 = 0
        if self.m3 <= 0:
            return falling, math.inf
        high = self.vb_max() * (1 + 1e-12)  # there c + N f' > 0, the exponential adds to it
        lowest = brentq(curvature, 0.0, max(high, 1.0 / self.r) + high, xtol=1e-15) if self.m0 > 0 else 0.0
        if growth(lowest) >= 0:
            return None
        low = brentq(growth, 0.0, lowest, xtol=1e-15) if growth(0.0) > 0 else 0.0
        return low, brentq(growth, lowest, high, xtol=1e-15)

    def averaged_rate(self, a: float) -> float:
        """da/d(omega t) of the averaged motion, a in units of N/k, omega^2 = k/m: first order, in closed form.

        With Lo = (N/k) omega, k1 = -Lo f'(vb) of the cubic part, k3 = Lo^3 m3 and c~ = c/(m omega),

            a' = (k1 - c~) a/2 - (3/8) k3 a^3 - (2 m0/pi) sqrt(1 - (vb/(Lo a))^2)        cubic, last term for Lo a > vb
            a' = (k1 - c~) a/2 - (3/8) k3 a^3 - m0 exp(-r vb) I1(r Lo a)                 smoothed, Lo a <= vb

        Raises
        ------
        InvalidInput
            For a law without a closed form, and for a smoothed one where the mass overtakes the belt.
        """
        from scipy.special import ive

        Lo, vb = self.N / math.sqrt(self.k * self.m), abs(self.vb)
        k_1, k_3 = Lo * (self.m1 - 3 * self.m3 * vb**2), Lo**3 * self.m3
        smooth = 0.5 * (k_1 - self.c / math.sqrt(self.k * self.m)) * a - 0.375 * k_3 * a**3
        overtakes = Lo * a > vb
        if self.law == "cubic":
            return smooth - (2 * self.m0 / math.pi * math.sqrt(1 - (vb / (Lo * a)) ** 2) if overtakes else 0.0)
        if self.law == "smoothed" and not overtakes:
            return smooth - self.m0 * math.exp(self.r * (Lo * a - vb)) * float(ive(1, self.r * Lo * a))
        raise InvalidInput(
            f"the averaged motion has no closed form for the law {self.law!r} at a = {a:g}; "
            "use nonsmooth.averaged_amplitude, which integrates"
        )

    def averaged_amplitude(self) -> float:
        """Amplitude a_1 of the averaged motion in units of N/k: y = x - equilibrium() swings by a_1 N/k.

        Zero where steady sliding is stable. For the cubic law.

        Raises
        ------
        InvalidInput
            For |vb| < vb_min(): the averaged motion would overtake the belt, so the mass sticks and slips; and for
            another law.
        """
        if self.law != "cubic":
            raise InvalidInput(
                f"this is the cubic law's closed form; for {self.law!r} use nonsmooth.averaged_amplitude"
            )
        if abs(self.vb) >= self.vb_max():
            return 0.0
        if abs(self.vb) < self.vb_min() or self.m3 <= 0:
            raise InvalidInput(
                f"pure-slip averaging holds for |vb| > vb_min = {self.vb_min():g} m/s and m3 > 0; "
                f"got vb = {self.vb:g}, m3 = {self.m3:g}; integrate the motion instead"
            )
        Lo = self.N / math.sqrt(self.k * self.m)  # velocity scale (N/k) omega [m/s]
        k_1 = Lo * (self.m1 - 3 * self.m3 * self.vb**2)
        return 2 * math.sqrt((k_1 - self.c / math.sqrt(self.k * self.m)) / (3 * Lo**3 * self.m3))

    def release_position(self) -> float:
        """Position at which the sticking mass lets go of the belt, x = (N m0 - c vb)/k for vb > 0 [m].

        Raises
        ------
        InvalidInput
            For the smoothed law, under which nothing sticks.
        """
        if self.law == "smoothed":
            raise InvalidInput("the smoothed law has no sticking, so nothing is released; take another law")
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
