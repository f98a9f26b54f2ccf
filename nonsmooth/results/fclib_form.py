"""The contact problem of a step in FCLIB's local form, which other programs read.

    u = W r + q,    K* contains u + mu |u_T| e_N  _|_  r in K = {|r_T| <= mu r_N},   rows (N, T) of each contact

u is the velocity with restitution, gamma_1 + e gamma_0, as c holds it already. What has no place in the form is brought
into it, or refused:

    bilateral, no friction    0 = G_BB P_B + G_BI P_I + c_B: P_B is eliminated, W = G_II - G_IB G_BB^-1 G_BI, likewise q
    unilateral, no friction   mu = 0, and a tangent of its own: W_TT = G_NN, no coupling, q_T = 0, so that r_T = 0
    laws mu(v), bilateral contacts with friction, given normal forces, impact by Poisson or energy: refused

Source: Acary, Bremond, Koziara and Perignon, FCLIB, INRIA RT-0444 (2014).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.laws import CONSTANT, LAW_C, LAW_CODE, LAW_IMPACT, ImpactLaw
from nonsmooth.mechanics.system import BILATERAL, GIVEN_FORCE
from nonsmooth.results.failed_problem import FailedProblem
from nonsmooth.results.fclib import ContactProblem, write_fclib


def write_fclib_form(problem: FailedProblem, path: Path) -> Path:
    """Write the problem in that form."""
    write_fclib(path, fclib_form(problem))
    return path


def fclib_form(problem: FailedProblem) -> ContactProblem:
    """The problem with rows (N, T), in space (N, T1, T2), for each unilateral contact.

    Raises
    ------
    InvalidInput
        For laws that the form does not have, and bilateral contacts that depend on one another.
    """
    require_plain_laws(problem)
    is_bilateral = problem.kinds[:, 0] == BILATERAL
    rows = np.arange(len(problem.c))
    of_bilateral = np.isin(rows, problem.start[:-1][is_bilateral])
    G, c = without(problem.G, problem.c, of_bilateral)
    kept = problem.kinds[~is_bilateral]
    dim = 3 if kept[:, 1].max() > 1 else 2
    has_row = np.column_stack([np.ones(len(kept), bool), *(kept[:, 1] >= k for k in range(1, dim))])
    places, lone = np.flatnonzero(has_row), np.flatnonzero(~has_row)  # of the rows in the form
    W, q = np.zeros((has_row.size, has_row.size)), np.zeros(has_row.size)
    W[np.ix_(places, places)], q[places] = G, c
    W[lone, lone] = np.diag(W)[lone - lone % dim]
    mu = np.where(kept[:, 1] > 0, problem.laws[~is_bilateral, LAW_C], 0.0)
    return ContactProblem(W, q, mu, dim, about=problem.about)


def require_plain_laws(problem: FailedProblem) -> None:
    """Raise unless FCLIB has the laws of all contacts."""
    kind, directions = problem.kinds.T
    has_friction = directions > 0
    reasons = {
        "a given normal force": kind == GIVEN_FORCE,
        "friction of a bilateral contact": (kind == BILATERAL) & has_friction,
        "friction that depends on the sliding speed": has_friction & (problem.laws[:, LAW_CODE] != CONSTANT),
        "another law of impact than Newton's": problem.laws[:, LAW_IMPACT] != ImpactLaw.NEWTON,
        "bilateral contacts only": np.full(len(kind), (kind == BILATERAL).all()),
    }
    for what, is_so in reasons.items():
        if is_so.any():
            raise without_place(what)


def without_place(what: str) -> InvalidInput:
    """The refusal of what FCLIB does not have."""
    return InvalidInput(f"FCLIB has no place for {what}; write .npz, which holds every contact problem")


def without(G: np.ndarray, c: np.ndarray, is_free: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Eliminate the rows whose velocity is zero, whatever the sign of their impulse."""
    I, B = ~is_free, is_free
    if not B.any():
        return G, c
    try:
        held = np.linalg.solve(G[np.ix_(B, B)], np.column_stack((G[np.ix_(B, I)], c[B])))
    except np.linalg.LinAlgError:
        raise without_place("bilateral contacts that depend on one another") from None
    return G[np.ix_(I, I)] - G[np.ix_(I, B)] @ held[:, :-1], c[I] - G[np.ix_(I, B)] @ held[:, -1]
