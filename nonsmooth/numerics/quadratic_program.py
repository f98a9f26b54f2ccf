"""A convex quadratic program by any solver that qpsolvers finds installed, osqp by default:

    min  x.P x / 2 + q.x   subject to   G x <= h,   A x = b,   x >= lower

The caller scales x to order one: osqp stops at an absolute error of 1e-9 (its defaults leave errors of order one in the
impulses of a contact problem). What a solver says of its answer is not asked; the caller computes the residual.
Source: Stellato, Banjac, Goulart, Bemporad, Boyd, *Math. Prog. Comp.* 12 (2020) 637.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

SETTINGS: dict[str, dict[str, Any]] = {
    "osqp": {
        "eps_abs": 1e-9, "eps_rel": 0.0, "max_iter": 50_000,
        "polishing": False,  # it prints
        "raise_error": False,  # returns where it stops early
    },
}  # fmt: skip


def minimise(
    P: Any, q: np.ndarray, G: Any = None, h: Any = None, A: Any = None, b: Any = None, lower: Any = None,
    guess: Any = None, solver: str = "osqp",
) -> np.ndarray | None:  # fmt: skip
    """The minimiser, or None where the solver gives none; what is wrong with the call itself is raised.

    Parameters
    ----------
    P : (n, n), q : (n,)
        P symmetric, positive semidefinite.
    G : (m, n), h : (m,), A : (k, n), b : (k,), lower : (n,)
        Constraints; none where left out or without rows.
    guess : (n,)
        Where to start.
    solver : str
        A name of `solver_names`.
    """
    import qpsolvers
    from scipy.sparse import csc_matrix

    form = csc_matrix if solver in qpsolvers.sparse_solvers else np.asarray
    inequalities = (form(G), h) if G is not None and G.shape[0] else (None, None)
    equalities = (form(A), b) if A is not None and A.shape[0] else (None, None)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # "not solved" is told by the residual
        try:
            x = qpsolvers.solve_qp(
                form(P), q, *inequalities, *equalities, lb=lower, initvals=guess, solver=solver,
                **settings_of(solver),
            )  # fmt: skip
        except refusals():
            return None
    return x if x is not None and np.isfinite(x).all() else None


def refusals() -> tuple[type[Exception], ...]:
    """How solvers say that a program has no answer: by qpsolvers, which words most of them, by an exception of osqp's
    own, by ArithmeticError (cvxopt) or ValueError (scs). A solver that is not there, options that it does not have, and
    what is wrong in the program text are none of these.
    """
    import osqp
    from qpsolvers.exceptions import ProblemError, SolverError

    return ProblemError, SolverError, osqp.OSQPException, ArithmeticError, ValueError


def settings_of(solver: str) -> dict[str, Any]:
    """The options of a solver."""
    return SETTINGS.get(solver, {})


def solver_names() -> list[str]:
    """The installed solvers that qpsolvers finds."""
    import qpsolvers

    return sorted(qpsolvers.available_solvers)
