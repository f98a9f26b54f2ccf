"""The front door:  find P with  gamma = G P + c  and  K* contains gamma + mu |gamma_T| e_N  _|_  P in K.

Border checks, scaling, one solver by name or the ladder of "auto", and the natural map of the problem as it was given.
Equations: docs/theory/contact_solvers.md, (1).
"""

from __future__ import annotations

import contextlib
import math
import time
from typing import Any

import numpy as np

from nonsmooth.checks.arrays import as_name, as_positive, as_tolerance, as_vector
from nonsmooth.contact.blocks.faceted_lcp import FacetedLCP
from nonsmooth.contact.blocks.few_contacts import sweep_few
from nonsmooth.contact.blocks.frictionless import Frictionless
from nonsmooth.contact.blocks.interior import Interior
from nonsmooth.contact.blocks.ladder import (
    CHEAP_ENTRIES,
    FIRST_SWEEPS,
    POLISHED_ERROR,
    Climb,
    Single,
    Solver,
    climb,
    is_cheap,
    ladder_of,
)
from nonsmooth.contact.blocks.newton import Newton
from nonsmooth.contact.blocks.newton_few import FEW_UNKNOWNS, SWEEPS_BEFORE, newton_memory, step_few
from nonsmooth.contact.blocks.nsgs import NSGS
from nonsmooth.contact.blocks.one_contact import solve_one
from nonsmooth.contact.blocks.problem import Blocks, Problem, as_blocks, check_vectors, scale_problem, weighed_problem
from nonsmooth.contact.blocks.result import ContactResult, ContactStatus
from nonsmooth.numerics.one_blas_thread import one_blas_thread

SOLVERS: dict[str, Solver] = {
    "single": Single(),
    "nsgs": NSGS(),
    "newton": Newton(),
    "interior": Interior(),
    "lcp": FacetedLCP(),
    "frictionless": Frictionless(),
}


def solve_contact(
    G: Any,
    c: Any,
    mu: Any,
    dim: int,
    solver: str = "auto",
    tol: float = 1e-8,
    guess: Any = None,
    max_time: float | None = None,
) -> ContactResult:
    """Solve a contact problem with Coulomb friction, in the plane or in space.

    gamma = G P + c; every contact is open (P = 0, gamma_N >= 0), sticks (gamma = 0, |P_T| <= mu P_N), or slides
    (gamma_N = 0, P_T = -mu P_N gamma_T / |gamma_T|). The spatial cone is the round one.

    Parameters
    ----------
    G : array_like or scipy.sparse matrix, shape (n, n)
        Delassus matrix [1/kg], interleaved per contact (N, T1[, T2]). Used as given: it need be neither symmetric nor
        of full rank.
    c : array_like, shape (n,)
        Velocity without contact impulses [m/s]; restitution is already in it.
    mu : float or array_like, shape (n_c,)
        Friction coefficients [-].
    dim : {2, 3}
        Planar or spatial.
    solver : str
        "auto", "single" (one contact), "nsgs", "newton", "interior", "lcp" (exact in the plane only) or "frictionless"
        (mu = 0).
    tol : float
        Largest accepted natural-map error, relative to the norm of c [-].
    guess : array_like, shape (n,), optional
        Impulses to start from [N s].
    max_time : float, optional
        Wall time after which the best iterate is returned with the status BUDGET_SPENT [s]; unlimited by default. The
        clock is looked at between sweeps, linear systems and solvers; what was begun of these is finished, and of
        "lcp" and "frictionless" all of it. What ends in time has the same bits with and without it.

    Returns
    -------
    ContactResult
        Not solved is a status, never an exception; P is then the best iterate.

    Raises
    ------
    InvalidInput
        When G is not square, sizes differ, an entry is not finite, mu < 0, dim is not 2 or 3, tol <= 0, or
        max_time <= 0.
    UnknownName
        When there is no solver of this name.

    Source: V. Acary, M. Bremond, O. Huber, On solving contact problems with Coulomb friction: formulations and
    numerical comparisons, in: Advanced Topics in Nonsmooth Dynamics, 2018.

    Examples
    --------
    A block on a plane is pushed down at 1 m/s while it slides at 2 m/s; friction takes mu times the normal impulse:

    >>> from nonsmooth.contact.blocks.solve import solve_contact
    >>> result = solve_contact([[1.0, 0.0], [0.0, 1.0]], [-1.0, 2.0], 0.5, dim=2)
    >>> result.status.name, result.P.tolist(), result.gamma.tolist()
    ('SOLVED', [1.0, -0.5], [0.0, 1.5])
    """
    began = time.monotonic()
    as_name("contact solver", solver, ("auto", *SOLVERS))
    c, mu, dim = check_vectors(c, mu, dim)
    blocks = as_blocks("G", G, dim, len(mu))
    tol = as_tolerance("tol", tol)
    if max_time is not None:
        max_time = as_positive("max_time", max_time, "s")
    start = np.zeros(len(c)) if guess is None else as_vector("guess", guess, len(c))
    if len(mu) == 1 and solver in ("auto", "single"):
        result = _solved_at_once(blocks, c, mu, tol)
        if result is not None:
            return result
    elif solver == "auto" and 0 < blocks.G.size <= CHEAP_ENTRIES:
        result = _at_once(blocks, c, mu, start, tol)
        if result is not None:
            return result
    given = weighed_problem(blocks, c, mu)
    if given.n == 0:
        return ContactResult(start, start.copy(), ContactStatus.SOLVED, 0.0, 0.0, 0, solver, "empty problem")
    problem, factor = scale_problem(given)
    until = math.inf if max_time is None else began + max_time
    rungs = ladder_of(problem) if solver == "auto" else [SOLVERS[solver]]
    with one_blas_thread() if problem.blocks.is_full else contextlib.nullcontext():
        end = climb(problem, start / factor, tol, rungs, solver == "auto" and is_cheap(problem), until)
    return _judged(given, factor * end.P, tol, end, max_time if time.monotonic() >= until else None)


def _solved_at_once(blocks: Blocks, c: np.ndarray, mu: np.ndarray, tol: float) -> ContactResult | None:
    """The result for one contact, solved to rounding; None where the ladder has more to say."""
    P, gamma = np.empty(len(c)), np.empty(len(c))
    error, error_rho_1 = solve_one(blocks.G, c, mu, P, gamma, np.empty(blocks.G.shape))
    if not error <= min(tol, POLISHED_ERROR):
        return None
    message = f"solved; single: error {error:.1e} after 1"
    return ContactResult(P, gamma, ContactStatus.SOLVED, error, error_rho_1, 1, "single", message)


def _at_once(blocks: Blocks, c: np.ndarray, mu: np.ndarray, start: np.ndarray, tol: float) -> ContactResult | None:
    """The result for few contacts, by sweeps or by Newton's method, to rounding; None where neither gets there soon."""
    P, gamma, rho, rows = start.copy(), np.empty(len(c)), np.empty(len(mu)), (blocks.G, blocks.indices, blocks.indptr)
    goal, is_few = min(tol, POLISHED_ERROR), len(c) <= FEW_UNKNOWNS
    most = max(SWEEPS_BEFORE, len(c)) if is_few else FIRST_SWEEPS
    sweeps, error, error_rho_1 = sweep_few(rows, c, mu, P, gamma, rho, goal, most)
    if error <= goal:
        message = f"solved; nsgs: error {error:.1e} after {sweeps}"
        return ContactResult(P, gamma, ContactStatus.SOLVED, error, error_rho_1, sweeps, "nsgs", message)
    if not is_few:
        return None
    memory = newton_memory(len(mu), blocks.G.shape[1])
    steps, error, error_rho_1 = step_few(rows, c, mu, P, gamma, rho, memory, goal)
    if not error <= goal:
        return None
    message = f"solved; nsgs and newton: error {error:.1e} after {sweeps} and {steps}"
    return ContactResult(P, gamma, ContactStatus.SOLVED, error, error_rho_1, sweeps + steps, "newton", message)


def _judged(given: Problem, P: np.ndarray, tol: float, end: Climb, spent: float | None) -> ContactResult:
    """The result, judged by the problem as given; ``spent`` is the budget, where it was used up [s]."""
    error = given.error(P)
    notes = end.notes
    if error <= tol:
        status = ContactStatus.SOLVED
    elif end.solver == "single" and given.dim == 2:
        status = ContactStatus.NO_SOLUTION
    elif spent is not None:
        status, notes = ContactStatus.BUDGET_SPENT, [f"max_time = {spent:g} s is used up; best of", *notes]
    else:
        status = ContactStatus.STALLED if len(notes) > 1 else ContactStatus.MAX_ITERATIONS
    error_rho_1 = given.with_error_of(np.ones(given.n_c)).error(P)
    message = f"{status.name.lower().replace('_', ' ')}; " + "; ".join(notes)
    return ContactResult(P, given.velocity(P), status, error, error_rho_1, end.iterations, end.solver, message)
