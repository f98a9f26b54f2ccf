"""A dense contact problem with joints, made one of its contacts alone: the Schur complement of the joints.

    gamma_j = G_jj P_j + G_jc P_c + c_j = 0   gives   P_j = -G_jj^+ (c_j + G_jc P_c),
    gamma_c = (G_cc - G_cj G_jj^+ G_jc) P_c + c_c - G_cj G_jj^+ c_j

so that solvers and files that know contacts only have the same problem. G_jj is singular where joints say something
twice, as two ball joints do along the line between them; the pseudoinverse then takes the impulse of least size.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

REDUNDANT = 1e-12  # chosen: of the largest eigenvalue of G_jj: what is below it is a row that joints say twice


class Eliminated(NamedTuple):
    """The problem of the contacts, and what gives the impulses of the joints."""

    G: np.ndarray
    c: np.ndarray
    A: np.ndarray  # G_jj^+ G_jc
    a: np.ndarray  # G_jj^+ c_j

    def joints(self, P_c: np.ndarray) -> np.ndarray:
        """P_j of impulses of the contacts."""
        return -(self.a + self.A @ P_c)


def without_joints(G: np.ndarray, c: np.ndarray, is_joint: np.ndarray) -> Eliminated:
    """The problem of the rows (n,) that are none of joints.

    Parameters
    ----------
    G : (n, n)
    c : (n,)
    is_joint : (n,) bool
    """
    j, k = np.flatnonzero(is_joint), np.flatnonzero(~is_joint)
    G_jc = G[np.ix_(j, k)]
    inverse = np.linalg.pinv(G[np.ix_(j, j)], rcond=REDUNDANT, hermitian=True)
    A, a = inverse @ G_jc, inverse @ c[j]
    return Eliminated(G[np.ix_(k, k)] - G_jc.T @ A, c[k] - G_jc.T @ a, A, a)
