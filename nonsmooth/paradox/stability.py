"""Does a compliant contact stay in a mode? The stiff limit of contact springs and dampers.

Each active contact carries la_N = -k z - c z', z the gap. With the friction of the mode,

    z'' = b_a + P_aa la_N,    P_aa = G_NN + G_NF F,    la_F = F la_N + f_0 ,

F = -mu s sigma where the contact slides, and from gamma_F' = 0 where it sticks. An eigenvalue rho = x + i y of P_aa
gives s^2 + rho c s + rho k = 0, which is stable iff

    x > 0    and    c^2/k > y^2/(x |rho|^2).

(s^2 + alpha s + beta with complex coefficients is stable iff Re alpha > 0 and (Re alpha)^2 Re beta
+ Re alpha Im alpha Im beta > (Im beta)^2.) Source: docs/theory/painleve.md, (7) and (8); for one contact Champneys,
Várkonyi, *IMA J. Appl. Math.* 81 (2016) 538.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

ZERO_SINGULAR_VALUE = 1e-12  # chosen: singular values below this part of the largest count as zero
REAL_EIGENVALUE = 1e-12  # chosen: an imaginary part below this part of |rho| counts as rounding of a real eigenvalue


class Stability(IntEnum):
    """What a stiff contact makes of a mode."""

    STABLE = 0  # for every damping of the contact
    FLUTTER = 1  # only with enough damping: c^2/k above ``StabilityTag.damping``
    SADDLE = 2  # for no damping: the mode is left at once


@dataclass(frozen=True)
class StabilityTag:
    """The stability of a mode of contact.

    Attributes
    ----------
    kind : Stability
    damping : float
        The least c^2/k [kg] with which the mode is stable: 0 if STABLE, inf if SADDLE.
    rho : ndarray (m,), complex
        Eigenvalues of P_aa, m active contacts [1/kg].
    """

    kind: Stability
    damping: float
    rho: np.ndarray


def force_columns(G: np.ndarray, normal: np.ndarray, slides: np.ndarray, ratio: np.ndarray) -> np.ndarray:
    """G applied to unit normal forces and the sliding friction that goes with them (r, m).

    Parameters
    ----------
    G : (r, r)
    normal : (m,) rows of the normal forces of the active contacts.
    slides, ratio : (m,)
        For each the row of its sliding friction, -1 if it has none, and la_F/la_N there.
    """
    columns = G[:, normal].copy()
    has_slide = slides >= 0
    columns[:, has_slide] += G[:, slides[has_slide]] * ratio[has_slide]
    return columns


def effective_matrix(G: np.ndarray, columns: np.ndarray, normal: np.ndarray, sticks: np.ndarray) -> np.ndarray:
    """P_aa (m, m) of m active contacts: their ``columns``, and the friction rows ``sticks`` (j,) held at rest."""
    if len(sticks) == 0:
        return columns[normal]
    held = np.linalg.lstsq(G[np.ix_(sticks, sticks)], columns[sticks], rcond=ZERO_SINGULAR_VALUE)[0]
    return columns[normal] - G[np.ix_(normal, sticks)] @ held


def is_regular(G: np.ndarray, columns: np.ndarray, normal: np.ndarray, sticks: np.ndarray) -> bool:
    """Whether the equations of the modes, gamma' = 0 in the closed rows, determine the forces."""
    rows = np.concatenate([normal, sticks])
    equations = np.column_stack([columns, G[:, sticks]])[rows]
    return len(rows) == 0 or int(np.linalg.matrix_rank(equations, rtol=ZERO_SINGULAR_VALUE)) == len(rows)


def stability_of(P: np.ndarray) -> StabilityTag:
    """The tag of a mode with the matrix P_aa (m, m); without active contacts it is STABLE."""
    if len(P) == 0:
        return StabilityTag(Stability.STABLE, 0.0, np.zeros(0, complex))
    rho = np.linalg.eigvals(P).astype(complex)
    x, y = rho.real, np.where(np.abs(rho.imag) > REAL_EIGENVALUE * np.abs(rho), rho.imag, 0.0)
    if not (x > REAL_EIGENVALUE * np.abs(rho)).all():
        return StabilityTag(Stability.SADDLE, np.inf, rho)
    damping = float((y**2 / (x * np.abs(rho) ** 2)).max())
    return StabilityTag(Stability.FLUTTER if damping > 0 else Stability.STABLE, damping, rho)
