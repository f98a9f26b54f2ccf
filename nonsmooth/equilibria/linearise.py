"""Small motions about steady sliding.

    M y'' + C y' + K y = R^T dla_N,    W_N y = 0,    C = -df/du,  K = -df/dq,  R = df/dla_N = W_N - mu n s W_F

The constraint is solved by y = Z x, W_N Z = 0, and the normal forces are removed by Y, R Y = 0. Both Z and Y have a
unit matrix in the rows of the coordinates that are kept, so that

    M_r x'' + C_r x' + K_r x = 0,    M_r = Y^T M Z,  C_r = Y^T C Z,  K_r = Y^T K Z

is the equation of motion in these coordinates. Friction makes Y differ from Z: the reduced matrices are unsymmetric,
and M_r need not be positive. It loses its sign with W_N M^-1 R^T, the p of the contact problem la_N = -p^-1 b: a
negative effective inertia is a Painlevé paradox, not an instability of the usual kind. See docs/theory/flutter.md and
docs/theory/sprag_slip.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property
from typing import Any

import numpy as np

from nonsmooth.equilibria.equilibrium import Equilibrium, as_equilibrium, equilibrium
from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.model_system import as_rated
from nonsmooth.scenes.given import as_model
from nonsmooth.views import Worded

# derived: a real part below this part of |s| counts as zero: a double eigenvalue is known to sqrt(eps) only
NEUTRAL = 1e-8
PIVOT = 1e-3  # chosen: smallest part of a row's largest entry that a coordinate must have to be solved for


class Verdict(IntEnum):
    """What becomes of a small disturbance."""

    STABLE = 0  # it dies out
    MARGINAL = 1  # to rounding it neither grows nor dies out, as in a system without damping
    DIVERGENCE = 2  # it grows without oscillation: the stiffness along the mode is negative
    FLUTTER = 3  # it grows by the work of unsymmetric position-dependent forces
    NEGATIVE_DAMPING = 4  # it grows by the work of velocity-dependent forces
    NEGATIVE_INERTIA = 5  # no equation of motion in the usual sense: a paradox


@dataclass(frozen=True, eq=False, repr=False)
class Linearisation(Worded):
    """M_r x'' + C_r x' + K_r x = 0 about a state of steady sliding; n_r kept coordinates.

    Attributes
    ----------
    M, C, K : ndarray (n_r, n_r)
        Reduced matrices, friction included.
    Z : ndarray (n_q, n_r)
        From the kept coordinates to all: y = Z x.
    kept : tuple of int
        The kept coordinates.
    inertia : ndarray (n_a, n_a)
        W_N M^-1 R^T [1/kg] of the constraints: p of a single contact.
    equilibrium : Equilibrium
    """

    M: np.ndarray
    C: np.ndarray
    K: np.ndarray
    Z: np.ndarray
    kept: tuple[int, ...]
    inertia: np.ndarray
    equilibrium: Equilibrium

    @cached_property
    def companion(self) -> np.ndarray:
        """A (2 n_r, 2 n_r) of d(x, x')/dt = A (x, x')."""
        n = len(self.kept)
        try:
            inverse = np.linalg.inv(self.M)
        except np.linalg.LinAlgError:
            raise InvalidInput("the effective inertia vanishes here: the motion has no equation; move off it") from None
        return np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ self.K, -inverse @ self.C]])

    @cached_property
    def _eigen(self) -> tuple[np.ndarray, np.ndarray]:
        n = len(self.kept)
        s, x = np.linalg.eig(self.companion)
        s = s.astype(complex)
        order = np.lexsort((-s.imag, -s.real, np.abs(s.imag)))
        return s[order], x[:n, order].astype(complex)

    @property
    def eigenvalues(self) -> np.ndarray:
        """s (2 n_r,) [1/s], by increasing frequency; of a pair, the one with positive imaginary part first."""
        return self._eigen[0]

    @property
    def mode_shapes(self) -> np.ndarray:
        """(n_q, 2 n_r) columns y with y exp(s t), the largest entry 1."""
        shapes = self.Z @ self._eigen[1]
        return shapes / shapes[np.abs(shapes).argmax(axis=0), np.arange(shapes.shape[1])]

    @property
    def frequencies(self) -> np.ndarray:
        """|Im s| (2 n_r,) [rad/s]."""
        return np.abs(self.eigenvalues.imag)

    @property
    def damping_ratios(self) -> np.ndarray:
        """-Re s/|s| (2 n_r,); zero for s = 0."""
        size = np.abs(self.eigenvalues)
        return 0.0 - self.eigenvalues.real / np.where(size > 0, size, 1.0)

    @property
    def dominant(self) -> complex:
        """The eigenvalue of largest real part, that with Im s >= 0 of a pair."""
        return complex(self.eigenvalues[self._dominant])

    @property
    def growth(self) -> float:
        """max Re s [1/s]."""
        return float(self.eigenvalues.real.max())

    @property
    def has_negative_inertia(self) -> bool:
        """Whether W_N M^-1 R^T has a real eigenvalue that is not positive."""
        values = np.linalg.eigvals(self.inertia) if self.inertia.size else np.ones(1)
        return bool(((np.abs(values.imag) == 0) & (values.real <= 0)).any())

    @cached_property
    def verdict(self) -> Verdict:
        """What becomes of a small disturbance; for growth, by which forces."""
        if self.has_negative_inertia:
            return Verdict.NEGATIVE_INERTIA
        s = self.dominant
        if abs(s.real) <= NEUTRAL * np.abs(self.eigenvalues).max():
            return Verdict.MARGINAL
        return Verdict.STABLE if s.real < 0 else self.cause

    @property
    def cause(self) -> Verdict:
        """Which forces feed the dominant mode: flutter, negative damping or divergence.

        With the mode x, 0 = x^H (s^2 M + s C + K) x = a_M (s^2 + s z + k): the imaginary part says that 2 Re s Im s is
        fed by -Im s Re z, the work of velocity-dependent forces, and by -Im k, that of unsymmetric position-dependent
        ones. The larger names the instability.
        """
        s, x = self.dominant, self._eigen[1][:, self._dominant]
        a_M, a_C, a_K = (np.vdot(x, A @ x) for A in (self.M, self.C, self.K))
        z, k = a_C / a_M, a_K / a_M
        if abs(s.imag) <= NEUTRAL * abs(s):
            return Verdict.DIVERGENCE if k.real < 0 else Verdict.NEGATIVE_DAMPING
        return Verdict.NEGATIVE_DAMPING if -s.imag * z.real > -k.imag else Verdict.FLUTTER

    @property
    def is_unstable(self) -> bool:
        """Whether a small disturbance grows."""
        return self.verdict > Verdict.MARGINAL

    @cached_property
    def _dominant(self) -> int:
        s = self.eigenvalues
        return int(np.lexsort((-s.imag, -s.real))[0])

    def summary(self) -> str:
        """The verdict and the eigenvalues, as a table."""
        lines = [f"{self.verdict.name.lower().replace('_', ' ')}, largest growth {self.growth:.9g} 1/s"]
        lines += [f"contradiction: {text}" for text in self.equilibrium.wrong]
        lines.append(f"{'Re s [1/s]':>16} {'Im s [rad/s]':>16} {'damping ratio':>14}")
        rows = zip(self.eigenvalues, self.damping_ratios, strict=True)
        lines += [f"{s.real:16.9f} {s.imag:16.9f} {ratio:14.6f}" for s, ratio in rows]
        return "\n".join(lines)


def linearise(system: Any, at: Equilibrium | None = None) -> Linearisation:
    """Linearise the sliding motion about an equilibrium.

    Parameters
    ----------
    system : System, model, or Scene
    at : Equilibrium, optional
        Of this system; ``equilibrium(system)`` when left out.

    Returns
    -------
    Linearisation

    Raises
    ------
    InvalidInput
        When no equilibrium is found, or the constraints of the contacts depend on one another or leave no motion.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> from nonsmooth.catalogue import ModeCoupling, SpragSlip
    >>> flutter = ns.linearise(ModeCoupling(mu=0.6))
    >>> flutter.verdict.name, round(flutter.growth, 9)
    ('FLUTTER', 0.538256313)
    >>> paradox = ns.linearise(SpragSlip())
    >>> paradox.verdict.name, round(float(paradox.M[0, 0]), 9)
    ('NEGATIVE_INERTIA', -6.43482615)
    """
    system = as_model(system)
    at = equilibrium(system) if at is None else as_equilibrium(at)
    system = as_rated(system, "linearise")
    if at.mode.system.functions != system.functions or not np.array_equal(at.mode.system.p, system.p):
        raise InvalidInput("the equilibrium is another system's; leave it out, or compute it for this one")
    mode, q, la_N = at.mode, at.q, at.multipliers
    M, C, K = mode.mass(q), mode.damping(q, la_N), mode.stiffness(q, la_N)
    W_N, R = mode.normal_rows(q).real, mode.force_rows(q)
    kept, solved = split_coordinates(W_N, R)
    if not kept:
        raise InvalidInput("the constraints of the closed contacts leave the system no motion: nothing is to linearise")
    Z, Y = null_space(W_N, kept, solved), null_space(R, kept, solved)
    inertia = W_N @ np.linalg.solve(M, R.T)
    return Linearisation(Y.T @ M @ Z, Y.T @ C @ Z, Y.T @ K @ Z, Z, tuple(kept), inertia, at)


def split_coordinates(W_N: np.ndarray, R: np.ndarray) -> tuple[list[int], list[int]]:
    """The coordinates that are kept, and those that the constraints give: the first ones that allow it."""
    rows, others = W_N.copy(), R.copy()
    solved: list[int] = []
    for j in range(W_N.shape[1]):
        k = len(solved)
        if k == len(W_N):
            break
        i = k + int(np.abs(rows[k:, j]).argmax())
        if min(abs(rows[i, j]) / np.abs(W_N).max(), abs(others[i, j]) / np.abs(R).max()) < PIVOT:
            continue
        for A in (rows, others):
            A[[k, i]] = A[[i, k]]
            A[k + 1 :] -= np.outer(A[k + 1 :, j] / A[k, j], A[k])
        solved.append(j)
    if len(solved) < len(W_N):
        raise InvalidInput("the constraints of the closed contacts depend on one another; leave redundant contacts out")
    return [j for j in range(W_N.shape[1]) if j not in solved], solved


def null_space(A: np.ndarray, kept: list[int], solved: list[int]) -> np.ndarray:
    """N (n, n_r) with A N = 0 and a unit matrix in the rows of the kept coordinates."""
    N = np.zeros((A.shape[1], len(kept)))
    N[kept] = np.eye(len(kept))
    if solved:
        N[solved] = -np.linalg.solve(A[:, solved], A[:, kept])
    return N
