"""Billiard ball on a table: from a parabola of sliding to a line of rolling.

    m v' = P,    J omega' = r x P,    r = (0, 0, -R),    J = 2/5 m R^2,    e' = (0, omega) e / 2
    s = v + omega x r,    sliding: P = -mu m g s/|s|,    rolling: s = 0

s keeps its direction while the ball slides, s' = -7/2 mu g s/|s|, so that its centre goes along a parabola; from
t = 2 |s_0|/(7 mu g) on it rolls with the velocity 5/7 v_0 + 2/7 R (omega_y, -omega_x)_0. The orientation is a unit
quaternion e, the angular velocity that in the axes of the table.

Source: Coriolis, *Théorie mathématique des effets du jeu de billard* (1835).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_fraction, as_number, as_positive
from nonsmooth.mechanics.system import Contact, System

INERTIA = 0.4  # J/(m R^2) of a solid sphere


def mass(t, q, p, M):
    for i in range(3):
        M[i, i] = p.m
        M[3 + i, 3 + i] = INERTIA * p.m * p.R**2


def force(t, q, u, p, h):
    h[2] = -p.m * p.g


def kinematics(t, q, p, B):
    for i in range(3):
        B[i, i] = 1.0
    B[3, 3], B[3, 4], B[3, 5] = -0.5 * q[4], -0.5 * q[5], -0.5 * q[6]
    B[4, 3], B[4, 4], B[4, 5] = 0.5 * q[3], 0.5 * q[6], -0.5 * q[5]
    B[5, 3], B[5, 4], B[5, 5] = -0.5 * q[6], 0.5 * q[3], 0.5 * q[4]
    B[6, 3], B[6, 4], B[6, 5] = 0.5 * q[5], -0.5 * q[4], 0.5 * q[3]


def gap(t, q, p, g_N):
    g_N[0] = q[2] - p.R


def normal(t, q, p, W_N):
    W_N[0, 2] = 1.0


def tangent(t, q, p, W_F):
    W_F[0, 0, 0], W_F[0, 0, 4] = 1.0, -p.R
    W_F[0, 1, 1], W_F[0, 1, 3] = 1.0, p.R


def row_rates(t, q, u, p, r):
    r[0, 0] = r[0, 1] = r[0, 2] = 0.0


def potential(t, q, p, V):
    V[0] = p.m * p.g * q[2]


@dataclass(frozen=True)
class BilliardBall:
    """Billiard ball on a table: q = (x, y, z, e_0, e_1, e_2, e_3), u = (v_x, v_y, v_z, w_x, w_y, w_z).

    Parameters
    ----------
    m : float
        Mass [kg].
    R : float
        Radius [m].
    g : float
        Gravity [m/s^2].
    mu : float
        Friction between ball and cloth.
    e : float
        Restitution coefficient of the table (Newton), 0 <= e <= 1.

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> from nonsmooth.catalogue import BilliardBall
    >>> ball = BilliardBall()
    >>> q, u = ball.state(speed=1.0, w_x=40.0, w_y=10.0)
    >>> ball.rolling_velocity(u).round(6)
    array([ 0.794286, -0.32    ])
    >>> sol = ns.simulate(ball, (0, 1), q, u, integrator=ns.MoreauJean(dt=1e-3))
    >>> sol.u[-1, :2].round(6)
    array([ 0.794286, -0.32    ])
    """

    m: float = 0.17  # mass [kg]
    R: float = 0.028  # radius [m]
    g: float = 9.81  # gravity [m/s^2]
    mu: float = 0.2  # friction [-]
    e: float = 0.0  # restitution [-]

    name = "billiard-ball"
    source = "Coriolis, Théorie mathématique des effets du jeu de billard (1835)"
    coordinates = (("x", "m"), ("y", "m"), ("z", "m"), ("e_0", "-"), ("e_1", "-"), ("e_2", "-"), ("e_3", "-"))
    velocities = (
        ("v_x", "m/s"), ("v_y", "m/s"), ("v_z", "m/s"), ("w_x", "rad/s"), ("w_y", "rad/s"), ("w_z", "rad/s"),
    )  # fmt: skip
    parts = ("ball", "mark")
    t_end = 1.0  # s
    dt = 1e-3  # s

    def __post_init__(self) -> None:
        as_positive("m", self.m, "kg")
        as_positive("R", self.R, "m")
        as_positive("g", self.g, "m/s^2")
        as_positive("mu", self.mu)
        as_fraction("e", self.e)

    def system(self) -> System:
        """The system with one unilateral contact, whose friction has two directions."""
        return System(
            n_q=7, n_u=6, mass=mass, force=force, kinematics=kinematics, gap=gap, normal=normal, tangent=tangent,
            row_rates=row_rates, potential=potential, parameters=self, name=self.name,
            contacts=[Contact(mu="mu", e_N="e", directions=2, name="cloth")],
        )  # fmt: skip

    def state(
        self, speed: float = 1.0, angle: float = 0.0, w_x: float = 40.0, w_y: float = 10.0, w_z: float = 0.0
    ) -> tuple[np.ndarray, np.ndarray]:
        """q0 (7,) and u0 (6,) of a ball on the table that is struck with a speed [m/s] at an angle [rad] from x, and an
        angular velocity [rad/s]."""
        v, a = as_number("speed", speed, "m/s"), as_number("angle", angle, "rad")
        spin = [as_number(name, w, "rad/s") for name, w in (("w_x", w_x), ("w_y", w_y), ("w_z", w_z))]
        q = np.array([0.0, 0.0, self.R, 1.0, 0.0, 0.0, 0.0])
        return q, np.array([v * math.cos(a), v * math.sin(a), 0.0, *spin])

    def slip(self, u: np.ndarray) -> np.ndarray:
        """Velocity of the point that touches the cloth (2,) [m/s]."""
        return np.array([u[0] - self.R * u[4], u[1] + self.R * u[3]])

    def rolling_time(self, u: np.ndarray) -> float:
        """When a ball with these velocities (6,) begins to roll, 2 |s|/(7 mu g) [s]."""
        return 2.0 * float(np.linalg.norm(self.slip(u))) / (7.0 * self.mu * self.g)

    def rolling_velocity(self, u: np.ndarray) -> np.ndarray:
        """Velocity (2,) with which it rolls on, 5/7 v + 2/7 R (omega_y, -omega_x) [m/s]."""
        return (5.0 * np.asarray(u[:2]) + 2.0 * self.R * np.array([u[4], -u[3]])) / 7.0

    def path(self, t: float, u: np.ndarray) -> np.ndarray:
        """Where the ball is (2,) at a time t [s] after the origin, struck with these velocities (6,) [m]."""
        s, until = self.slip(u), self.rolling_time(u)
        size = float(np.linalg.norm(s))
        a = -self.mu * self.g * s / size if size > 0.0 else np.zeros(2)
        slid = min(t, until)
        return np.asarray(u[:2]) * slid + 0.5 * a * slid**2 + max(0.0, t - until) * self.rolling_velocity(u)

    def shape(self, q: np.ndarray) -> list[np.ndarray]:
        """The ball and a mark on it from above, as polylines (k, 2)."""
        angle = np.linspace(0.0, 2 * np.pi, 33)
        circle = np.column_stack([np.cos(angle), np.sin(angle)])
        e_0, e_1, e_2, e_3 = q[3:]
        up = np.array([2 * (e_1 * e_3 + e_0 * e_2), 2 * (e_2 * e_3 - e_0 * e_1)])  # of its axis that was up
        return [q[:2] + self.R * circle, q[:2] + self.R * (up + 0.15 * circle)]

    def outline(self) -> list[np.ndarray]:
        """The cloth."""
        return [np.array([[-0.2, -0.8], [1.2, -0.8], [1.2, 0.8], [-0.2, 0.8], [-0.2, -0.8]])]
