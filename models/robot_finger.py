"""Robot finger on a table: two uniform links in an upright plane that turns about the vertical, and a tip that slides.

    e_i = (cos th_i h, sin th_i),    h = (cos psi, sin psi, 0),    the tip at l1 e_1 + l2 e_2 from a joint at height H
    rho = l1 cos th1 + l2 cos th2,    g_N = H + l1 sin th1 + l2 sin th2
    J psi'' + J' psi' = tau_psi + rho la_t,
    J = (m1/3 + m2) l1^2 cos^2 th1 + m2 l1 l2 cos th1 cos th2 + m2 l2^2 cos^2 th2/3

Constant torques turn the finger about the vertical (tau_psi), its first joint (tau_1) and its second (tau_2, on
th2 - th1). At rest they press the tip on the table with J_tip^T la = -Q, whatever the friction. The tip that slides at
the angle phi from h has

    gamma_N' = p la_N + b,    p = G_NN - mu cos phi G_Nh,

as a turn about the vertical moves it across h alone: a paradox is that of the plane with mu cos phi for mu, and the
spin psi' alone, by the centrifugal force, changes b.
Source: Liu, Zhao, Chen, *Nonlinear Dyn.* 49 (2007) 217; Or, Rimon, *Nonlinear Dyn.* 67 (2012) 1647: two links in the
plane.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_fraction, as_non_negative, as_number, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.system import Contact, System

from .spatial_painleve_rod import oblique


def mass(t, q, p, M):
    a, b = p.l1 * math.cos(q[1]), p.l2 * math.cos(q[2])
    M[0, 0] = (p.m1 / 3 + p.m2) * a * a + p.m2 * a * b + p.m2 * b * b / 3
    M[1, 1] = (p.m1 / 3 + p.m2) * p.l1**2
    M[1, 2] = M[2, 1] = 0.5 * p.m2 * p.l1 * p.l2 * math.cos(q[1] - q[2])
    M[2, 2] = p.m2 * p.l2**2 / 3


def force(t, q, u, p, h):
    a, b = p.l1 * math.cos(q[1]), p.l2 * math.cos(q[2])
    a_1, b_2 = -p.l1 * math.sin(q[1]), -p.l2 * math.sin(q[2])
    J_1 = (2 * (p.m1 / 3 + p.m2) * a + p.m2 * b) * a_1
    J_2 = (p.m2 * a + 2 * p.m2 * b / 3) * b_2
    bend = 0.5 * p.m2 * p.l1 * p.l2 * math.sin(q[1] - q[2])
    h[0] = p.tau_psi - (J_1 * u[1] + J_2 * u[2]) * u[0]
    h[1] = p.tau_1 - p.tau_2 - (0.5 * p.m1 + p.m2) * p.g * a + 0.5 * J_1 * u[0] ** 2 - bend * u[2] ** 2
    h[2] = p.tau_2 - 0.5 * p.m2 * p.g * b + 0.5 * J_2 * u[0] ** 2 + bend * u[1] ** 2


def gap(t, q, p, g_N):
    g_N[0] = p.H + p.l1 * math.sin(q[1]) + p.l2 * math.sin(q[2])


def normal(t, q, p, W_N):
    W_N[0, 1], W_N[0, 2] = p.l1 * math.cos(q[1]), p.l2 * math.cos(q[2])


def tangent(t, q, p, W_F):
    rho = p.l1 * math.cos(q[1]) + p.l2 * math.cos(q[2])
    in_1, in_2 = -p.l1 * math.sin(q[1]), -p.l2 * math.sin(q[2])
    c, s = math.cos(q[0]), math.sin(q[0])
    W_F[0, 0, 0], W_F[0, 0, 1], W_F[0, 0, 2] = -rho * s, in_1 * c, in_2 * c
    W_F[0, 1, 0], W_F[0, 1, 1], W_F[0, 1, 2] = rho * c, in_1 * s, in_2 * s


def row_rates(t, q, u, p, r):
    rho = p.l1 * math.cos(q[1]) + p.l2 * math.cos(q[2])
    rho_1 = -p.l1 * math.sin(q[1]) * u[1] - p.l2 * math.sin(q[2]) * u[2]
    along = -p.l1 * math.cos(q[1]) * u[1] ** 2 - p.l2 * math.cos(q[2]) * u[2] ** 2 - rho * u[0] ** 2
    across = 2 * rho_1 * u[0]
    r[0, 0] = -p.l1 * math.sin(q[1]) * u[1] ** 2 - p.l2 * math.sin(q[2]) * u[2] ** 2
    r[0, 1] = along * math.cos(q[0]) - across * math.sin(q[0])
    r[0, 2] = along * math.sin(q[0]) + across * math.cos(q[0])


def potential(t, q, p, V):
    a, b = p.l1 * math.sin(q[1]), p.l2 * math.sin(q[2])
    V[0] = (0.5 * p.m1 + p.m2) * p.g * a + 0.5 * p.m2 * p.g * b
    V[0] -= p.tau_psi * q[0] + p.tau_1 * q[1] + p.tau_2 * (q[2] - q[1])


@dataclass(frozen=True)
class RobotFinger:
    """Two-link finger whose tip slides on a table: q = (psi, th1, th2), turn about the vertical, slopes of the links.

    Parameters
    ----------
    m1, m2 : float
        Masses of the links, upper and lower [kg].
    l1, l2 : float
        Their lengths [m].
    H : float
        Height of the upper joint above the table, less than l1 + l2 [m].
    tau_psi, tau_1, tau_2 : float
        Torques about the vertical, at the upper joint and at the middle one [N m].
    mu : float
        Friction coefficient of tip and table.
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
    >>> from nonsmooth.catalogue import RobotFinger
    >>> finger = RobotFinger()
    >>> th1, th2 = finger.slopes(th2=-1.2)
    >>> round(th1, 6), round(finger.critical_friction(th2=-1.2), 6)
    (-0.259538, 1.018613)
    >>> torques = finger.torques_that_press((0.5, 0.0, 0.0), th2=-1.2)
    >>> finger.with_torques(torques).force_at_rest(th2=-1.2).round(12) + 0.0
    array([0.5, 0. , 0. ])
    """

    m1: float = 0.06  # upper link [kg]
    m2: float = 0.04  # lower link [kg]
    l1: float = 0.06  # upper link [m]
    l2: float = 0.05  # lower link [m]
    H: float = 0.062  # joint above the table [m]
    tau_psi: float = 0.0  # about the vertical [N m]
    tau_1: float = 0.0  # upper joint [N m]
    tau_2: float = 0.0  # middle joint [N m]
    mu: float = 1.2  # friction [-]
    g: float = 9.81  # gravity [m/s^2]
    e: float = 0.0  # restitution [-]

    name = "robot-finger"
    source = "Liu, Zhao, Chen, Nonlinear Dyn. 49 (2007) 217; Or, Rimon, Nonlinear Dyn. 67 (2012) 1647"
    coordinates = (("psi", "rad"), ("th1", "rad"), ("th2", "rad"))
    parts = ("finger", "shadow")
    map_axes = (("th2", -2.2, -0.6), ("phi", -math.pi, math.pi))
    t_end = 0.05  # s
    dt = 1e-5  # s

    def __post_init__(self) -> None:
        for name, unit in (("m1", "kg"), ("m2", "kg"), ("l1", "m"), ("l2", "m"), ("H", "m")):
            as_positive(name, getattr(self, name), unit)
        for name in ("tau_psi", "tau_1", "tau_2"):
            as_number(name, getattr(self, name), "N m")
        as_non_negative("mu", self.mu)
        as_non_negative("g", self.g, "m/s^2")
        as_fraction("e", self.e)
        if not self.H < self.l1 + self.l2:
            raise InvalidInput(f"H must be less than l1 + l2 = {self.l1 + self.l2:g} m: the finger reaches the table")

    def with_torques(self, torques: np.ndarray) -> RobotFinger:
        """The finger with other torques (tau_psi, tau_1, tau_2) [N m]."""
        tau_psi, tau_1, tau_2 = (float(x) for x in torques)
        return dataclasses.replace(self, tau_psi=tau_psi, tau_1=tau_1, tau_2=tau_2)

    def system(self) -> System:
        """The system with one unilateral contact, whose friction has two directions, at the tip."""
        return System(
            n_q=3, mass=mass, force=force, gap=gap, normal=normal, tangent=tangent, row_rates=row_rates,
            potential=potential, contacts=[Contact(mu="mu", e_N="e", directions=2, name="tip")], parameters=self,
            name=self.name,
        )  # fmt: skip

    def slopes(self, th2: float) -> tuple[float, float]:
        """th1 in [-pi/2, pi/2] with which the tip touches the table, and th2 [rad]."""
        sine = -(self.H + self.l2 * math.sin(as_number("th2", th2, "rad"))) / self.l1
        if abs(sine) > 1:
            raise InvalidInput(f"the tip does not reach the table with th2 = {th2:g} rad")
        return math.asin(sine), th2

    def state(
        self, th2: float = -1.2, phi: float = 2.5, slip: float = 0.1, psi: float = 0.0
    ) -> tuple[np.ndarray, np.ndarray]:
        """q0 (3,) and u0 (3,) of a tip on the table that slides.

        Parameters
        ----------
        th2 : float
            Slope of the lower link [rad].
        phi : float
            Angle of the slide from h, counted as psi is [rad].
        slip : float
            Speed of the tip [m/s]; 0: it rests.
        psi : float
            Turn of the finger about the vertical [rad].
        """
        q = np.array([as_number("psi", psi, "rad"), *self.slopes(th2)])
        v = as_non_negative("slip", slip, "m/s")
        if v == 0:
            return q, np.zeros(3)
        phi = as_number("phi", phi, "rad")
        return q, np.linalg.solve(self.tip_rows(th2), v * np.array([0.0, math.cos(phi), math.sin(phi)]))

    def tip_rows(self, th2: float) -> np.ndarray:
        """J_tip (3, 3): velocity of the tip along n, h and across h, of (psi', th1', th2')."""
        th1, th2 = self.slopes(th2)
        a, b = self.l1 * math.cos(th1), self.l2 * math.cos(th2)
        rows = np.array([[0.0, a, b], [0.0, -self.l1 * math.sin(th1), -self.l2 * math.sin(th2)], [a + b, 0.0, 0.0]])
        if abs(a + b) < 1e-12 * (self.l1 + self.l2) or abs(math.sin(th1 - th2)) < 1e-12:
            raise InvalidInput("the finger is stretched, or its tip is below the joint: some slides move no joint")
        return rows

    def torques_that_press(self, force: tuple[float, float, float], th2: float) -> np.ndarray:
        """(tau_psi, tau_1, tau_2) at which the table holds the tip at rest with a force along n, h and across [N m]."""
        th1, th2 = self.slopes(th2)
        weight_1 = (0.5 * self.m1 + self.m2) * self.g * self.l1 * math.cos(th1)
        weight_2 = 0.5 * self.m2 * self.g * self.l2 * math.cos(th2)
        psi, on_1, on_2 = np.array([0.0, weight_1, weight_2]) - self.tip_rows(th2).T @ np.asarray(force, float)
        return np.array([psi, on_1 + on_2, on_2])

    def force_at_rest(self, th2: float) -> np.ndarray:
        """The force (3,) of the table on a tip at rest along n, h and across h [N]: it sticks if |la_T| <= mu la_N."""
        rest = self.torques_that_press((0.0, 0.0, 0.0), th2) - np.array([self.tau_psi, self.tau_1, self.tau_2])
        return np.linalg.solve(self.tip_rows(th2).T, [rest[0], rest[1] - rest[2], rest[2]])

    def delassus(self, th2: float) -> np.ndarray:
        """G (3, 3) of the tip along n, h and across h [1/kg]."""
        M, rows = np.zeros((3, 3)), self.tip_rows(th2)
        mass(0.0, np.array([0.0, *self.slopes(th2)]), self, M)
        return np.asarray(rows @ np.linalg.solve(M, rows.T))

    def p(self, th2: float, phi: float) -> float:
        """p of gamma_N' = p la_N + b for a slide at phi from h [1/kg]."""
        G = self.delassus(th2)
        return float(G[0, 0] - self.mu * math.cos(phi) * G[0, 1])

    def critical_friction(self, th2: float) -> float:
        """Friction above which p < 0 in some direction, G_NN/|G_Nh|."""
        G = self.delassus(th2)
        return float(G[0, 0] / abs(G[0, 1]))

    def shape(self, q: np.ndarray) -> list[np.ndarray]:
        """The finger and its shadow in an oblique view, as polylines (3, 2)."""
        reach = np.cumsum([0.0, self.l1 * math.cos(q[1]), self.l2 * math.cos(q[2])])
        height = self.H + np.cumsum([0.0, self.l1 * math.sin(q[1]), self.l2 * math.sin(q[2])])
        points = np.column_stack([reach * math.cos(q[0]), reach * math.sin(q[0]), height])
        return [oblique(points), oblique(points * [1.0, 1.0, 0.0])]

    def outline(self) -> list[np.ndarray]:
        """A square of the table."""
        corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [-1, -1, 0]])
        return [oblique((self.l1 + self.l2) * corners)]
