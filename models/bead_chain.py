"""Beads in a line, and a wall at its end: a cascade of impacts.

    m x_i'' = la_(i-1) - la_i,    g_i = gap + x_(i+1) - x_i >= 0,    g_(n-1) = gap - x_(n-1) >= 0

x_i are displacements from the evenly spaced positions; contact i lies to the right of bead i, the last one at the wall.
Two equal beads meet with restitution e: their mean velocity stays, their difference is multiplied by -e; what
a step finds struck at once is struck one after the other.
Source: Newton's cradle with gaps; e.g. Acary and Brogliato, *Numerical Methods for Nonsmooth Dynamical Systems* (2008).
"""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_count, as_fraction, as_non_negative, as_number, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.system import Contact, System

# The number of beads is read from the arrays, so that these functions serve every n.


def mass(t, q, p, M):
    for i in range(M.shape[0]):
        M[i, i] = p.m


def force(t, q, u, p, h):
    h[0] = 0.0


def gap(t, q, p, g_N):
    last = g_N.shape[0] - 1
    for i in range(last):
        g_N[i] = p.gap + q[i + 1] - q[i]
    g_N[last] = p.gap - q[last]


def normal(t, q, p, W_N):
    last = W_N.shape[0] - 1
    for i in range(last):
        W_N[i, i] = -1.0
        W_N[i, i + 1] = 1.0
    W_N[last, last] = -1.0


def row_rates(t, q, u, p, r):
    r[0, 0] = 0.0


def potential(t, q, p, V):
    V[0] = 0.0


@functools.cache
def right_end(i):
    """Return what says where bead i ends, with the normal on it."""

    def at(q, p):
        return (i * (2 * p.r + p.gap) + q[i] + p.r, 0.0), (-1.0, 0.0)

    return at


@dataclass(frozen=True)
class BeadChain:
    """n equal beads in a line and a wall: q = (x_0 .. x_(n-1)), displacements; frictionless contacts.

    Parameters
    ----------
    n : int
        Number of beads, and of contacts. It sets the size of the system: change it in the model, not in the System.
    m : float
        Mass of a bead [kg].
    gap : float
        Distance between neighbours, and from the last bead to the wall, at zero displacement [m].
    e : float
        Restitution coefficient (Newton) of all contacts.
    r : float
        Radius of the beads, for pictures [m].

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from nonsmooth.catalogue import BeadChain
    >>> chain = BeadChain(n=100)
    >>> q, u = chain.exact(t=2.0, velocity=1.0)
    >>> round(float(u.sum()), 12), round(float(0.5 * (u**2).sum()), 7)
    (1.0, 0.0080414)
    """

    n: int = 100  # number of beads
    m: float = 1.0  # mass [kg]
    gap: float = 1e-3  # gap [m]
    e: float = 0.9  # restitution [-]
    r: float = 5e-3  # radius [m]

    name = "bead-chain"
    source = "Newton's cradle with gaps; Acary and Brogliato, Numerical Methods for Nonsmooth Dynamical Systems (2008)"
    t_end = 2.0  # s
    dt = 1e-3  # s

    def __post_init__(self) -> None:
        as_count("n", self.n)
        as_positive("m", self.m, "kg")
        as_non_negative("gap", self.gap, "m")
        as_fraction("e", self.e)
        as_positive("r", self.r, "m")

    @property
    def coordinates(self) -> tuple[tuple[str, str], ...]:
        """Names and units of the coordinates."""
        return tuple((f"x_{i}", "m") for i in range(self.n))

    def system(self) -> System:
        """The system with n frictionless unilateral contacts."""
        return System(
            n_q=self.n, mass=mass, force=force, gap=gap, normal=normal, row_rates=row_rates, potential=potential,
            contacts=[Contact(e_N="e", impact="sequential", at=right_end(i)) for i in range(self.n)],
            parameters=self, name=self.name,
        )  # fmt: skip

    def state(self, velocity: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
        """q0 (n,) and u0 (n,): evenly spaced, the first bead moving at a velocity [m/s], the others at rest."""
        u0 = np.zeros(self.n)
        u0[0] = as_number("velocity", velocity, "m/s")
        return np.zeros(self.n), u0

    def exact(self, t: float, velocity: float = 1.0, most: int = 1_000_000) -> tuple[np.ndarray, np.ndarray]:
        """q (n,) and u (n,) at time t [s], impact by impact, from `state`.

        Raises
        ------
        InvalidInput
            When more than ``most`` impacts happen: they accumulate, and no impact comes next.
        """
        q, u = self.state(velocity)
        for _ in range(most):
            g_N = np.append(self.gap + np.diff(q), self.gap - q[-1])
            closing = np.append(u[:-1] - u[1:], u[-1])
            wait = np.full(self.n, np.inf)
            np.divide(np.maximum(g_N, 0.0), closing, out=wait, where=closing > 0)
            i = int(np.argmin(wait))
            if wait[i] >= t:
                return q + u * t, u
            t -= wait[i]
            q = q + u * wait[i]
            if i == self.n - 1:
                u[i] *= -self.e
            else:
                mean, half = 0.5 * (u[i] + u[i + 1]), 0.5 * self.e * closing[i]
                u[i], u[i + 1] = mean - half, mean + half
        raise InvalidInput(f"more than {most} impacts with {t:g} s to go; they accumulate")

    def shape(self, q: np.ndarray) -> list[np.ndarray]:
        """The beads as polylines (17, 2), the first one at the origin."""
        angle = np.linspace(0.0, 2 * np.pi, 17)
        circle = self.r * np.column_stack([np.cos(angle), np.sin(angle)])
        return [circle + np.array([i * (2 * self.r + self.gap) + q[i], 0.0]) for i in range(self.n)]

    @property
    def parts(self) -> tuple[str, ...]:
        """Names of what ``shape`` gives."""
        return tuple(f"bead {i}" for i in range(self.n))

    def outline(self) -> list[np.ndarray]:
        """The wall."""
        x = self.n * (2 * self.r + self.gap) - self.r
        return [np.array([[x, -4 * self.r], [x, 4 * self.r]])]
