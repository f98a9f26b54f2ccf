"""The smooth system that remains when every closed contact slides in a known direction.

    M(q) u' = f(q, u, la_N),    f = h + W_N^T la_N - sum_i mu_i(s_i gamma_F) n_i la_N s_i W_F^T,    g_N(q) = 0

s_i is the sign of sliding, s gamma_F > 0, and n_i the sign of the normal force (-1 only for a bilateral contact that is
pulled), so that n_i la_N is what presses; a contact with a given normal force is pressed by N(q, u) and has no row in
g_N. In space s is the direction gamma_F/|gamma_F|, which turns with the motion, s gamma_F the speed. Nothing is left
of the set-valued laws: f can be differentiated, friction included. See docs/stability.md.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.laws import friction_coefficient
from nonsmooth.mechanics.system import (
    DAMPING,
    FORCE,
    GAP,
    GIVEN_FORCE,
    MASS,
    NORMAL,
    NORMAL_FORCE,
    STIFFNESS,
    SURFACE_VELOCITY,
    TAKES_U,
    TANGENT,
    System,
)
from nonsmooth.numerics.complex_step import complexified, jacobian

mu_of = complexified(friction_coefficient)


@dataclass(frozen=True, eq=False)
class SlidingMode:
    """A system whose contacts slide as told.

    Parameters
    ----------
    system : System
    closed : tuple of int
        The contacts that are closed.
    sliding, normal : ndarray (n_c,)
        Signs of gamma_F, 1 of one in space, and of la_N.
    t : float
        Time at which the functions are evaluated [s].
    """

    system: System
    closed: tuple[int, ...]
    sliding: np.ndarray
    normal: np.ndarray
    t: float = 0.0

    @cached_property
    def constrained(self) -> list[int]:
        """The closed contacts that have a gap."""
        return [i for i in self.closed if self.system.kinds[i, 0] != GIVEN_FORCE]

    @cached_property
    def n_a(self) -> int:
        """Number of constraints."""
        return len(self.constrained)

    @cached_property
    def constants(self) -> dict[int, np.ndarray]:
        """What those model functions write that read neither t nor the state."""
        zero, found = np.zeros(self.system.n_q), {}
        for which in (MASS, NORMAL, TANGENT, SURFACE_VELOCITY, NORMAL_FORCE):
            reads = ("t", "q", "u") if which in TAKES_U else ("t", "q")
            if which in self.system.functions and not any(self.system.reads(which, name) for name in reads):
                found[which] = self.system.evaluate(which, self.t, zero, zero).astype(complex)
        return found

    def call(self, which: int, q: np.ndarray, u: np.ndarray, t: complex | None = None) -> np.ndarray:
        """A model function of complex arguments, not to be written to; zeros where the model leaves it out."""
        if which in self.constants:
            return self.constants[which]
        out = np.zeros(self.system.shape_of(which), complex)
        if which in self.system.functions:
            function = complexified(self.system.functions[which])
            now = self.t if t is None else t
            state = (q, u) if which in TAKES_U else (q,)
            function(now, *state, self.system.unpacked, out)
        return out

    def mass(self, q: np.ndarray) -> np.ndarray:
        """M(q) (n, n)."""
        return self.system.evaluate(MASS, self.t, q, np.zeros(self.system.n_u))

    def gaps(self, q: np.ndarray, t: complex | None = None) -> np.ndarray:
        """g_N (n_a,) of the constraints."""
        return self.call(GAP, q, q, t)[self.constrained]

    def normal_rows(self, q: np.ndarray) -> np.ndarray:
        """W_N (n_a, n) of the constraints."""
        return self.call(NORMAL, q, q)[self.constrained]

    def contact_force(self, q: np.ndarray, u: np.ndarray, la_N: np.ndarray) -> np.ndarray:
        """(n,) what the closed contacts add to the smooth forces."""
        system, total = self.system, np.zeros(self.system.n_u, complex)
        if not self.closed:
            return total
        pressing = self.call(NORMAL_FORCE, q, u).copy()
        if self.constrained:
            rows = self.normal_rows(q)
            total += la_N @ rows
            pressing[self.constrained] = self.normal[self.constrained] * la_N
        if system.d:
            W_F, gamma_F = self.along(q, u)
            for i in self.closed:
                if system.kinds[i, 1]:
                    s = self.sliding[i]
                    total -= mu_of(system.laws, i, s * gamma_F[i]) * pressing[i] * s * W_F[i]
        return total

    def along(self, q: np.ndarray, u: np.ndarray, t: complex | None = None) -> tuple[np.ndarray, np.ndarray]:
        """W_F (n_c, n) and gamma_F (n_c,), in space those along the slides of the closed contacts."""
        W_F, w_F = self.call(TANGENT, q, u, t), self.call(SURFACE_VELOCITY, q, u, t)
        rows, gamma_F = W_F[:, 0], W_F[:, 0] @ u + w_F[:, 0]
        if self.system.d == 1:
            return rows, gamma_F
        rows = rows.copy()
        for i in self.closed:
            if self.system.kinds[i, 1] == 2:
                gamma = W_F[i] @ u + w_F[i]
                gamma_F[i] = np.sqrt(gamma @ gamma)
                rows[i] = gamma / gamma_F[i] @ W_F[i]
        return rows, gamma_F

    def force(self, q: np.ndarray, u: np.ndarray, la_N: np.ndarray) -> np.ndarray:
        """f (n,), complex."""
        return self.call(FORCE, q, u) + self.contact_force(q, u, la_N)

    def force_rows(self, q: np.ndarray) -> np.ndarray:
        """R = df/dla_N (n_a, n), the directions W_N - mu n s W_F that the normal forces act along, at rest."""
        if not self.n_a:
            return np.zeros((0, q.size))
        u = np.zeros_like(q)
        return jacobian(lambda la_N: self.contact_force(q, u, la_N), np.zeros(self.n_a))[1].T

    def stiffness(self, q: np.ndarray, la_N: np.ndarray) -> np.ndarray:
        """K = -df/dq (n, n) at rest, friction's unsymmetric part included."""
        rest = np.zeros_like(q)
        smooth = self._smooth(STIFFNESS, q, lambda x: self.call(FORCE, x, rest), q)
        return smooth - jacobian(lambda x: self.contact_force(x, rest, la_N), q)[1]

    def damping(self, q: np.ndarray, la_N: np.ndarray) -> np.ndarray:
        """C = -df/du (n, n) at rest, the slope of the friction law included."""
        rest = np.zeros_like(q)
        smooth = self._smooth(DAMPING, q, lambda x: self.call(FORCE, q, x), rest)
        return smooth - jacobian(lambda x: self.contact_force(q, x, la_N), rest)[1]

    def _smooth(self, which: int, q: np.ndarray, force: Callable, x: np.ndarray) -> np.ndarray:
        """-dh/dx by a complex step, or the model's own Jacobian where its force takes real numbers only."""
        try:
            return -jacobian(force, x)[1]
        except InvalidInput:
            if which not in self.system.functions:
                raise
            return self.system.evaluate(which, self.t, q, np.zeros_like(q))
