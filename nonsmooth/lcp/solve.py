"""The front door:  find z with  w = A z + b,  0 <= w _|_ z >= 0.

    border checks -> one solver by name, or the ladder of "auto" -> w and the residual computed here -> LCPResult

The ladder, until the residual is within the tolerance:

    n <= 20            pivoting if there is a guess, lemke, pivoting, perturbed, enumeration and certificate, newton
    n <= 300           pivoting if there is a guess, lemke, pivoting, perturbed, newton, certificate
    larger, dense      interior, newton, lemke, certificate (n <= 1000)
    larger, sparse     pgs (positive diagonal), interior, newton, lemke and certificate (n <= 1000)

Sources and conditions are in the files of the solvers.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.checks.arrays import FLOAT, as_square_matrix, as_tolerance, as_vector
from nonsmooth.errors import InvalidInput, UnknownName, nearest, shown
from nonsmooth.lcp.certificate import infeasibility_certificate
from nonsmooth.lcp.enumerate import ACTIVE_SETS_TRIED, LARGEST_N, first_solution
from nonsmooth.lcp.interior import solve_by_interior_point
from nonsmooth.lcp.lemke import judged_lemke, lemke_workspace
from nonsmooth.lcp.newton import solve_active_set
from nonsmooth.lcp.newton import solve_by_semismooth_newton as newton_iterations
from nonsmooth.lcp.pgs import pgs_entry, pgs_sparse_entry
from nonsmooth.lcp.pivoting import pivoting_entry, pivoting_workspace
from nonsmooth.lcp.qp import solve_as_qp
from nonsmooth.lcp.result import LCPResult, LCPStatus, judge_solution, judge_sparse, natural_scales
from nonsmooth.numerics.golden_ratio import GOLDEN_RATIO
from nonsmooth.numerics.quadratic_program import solver_names

SMALL_N = 300  # Lemke's n^3 kernel is faster than Newton with LAPACK up to about here (measured)
DENSE_N = 4000  # derived: a sparse matrix is made dense up to here where a solver needs it: 128 MB
CERTIFICATE_N = 1000  # measured: a linear program, or Lemke on a sparse matrix made dense, takes seconds from here on
MAX_SWEEPS = 20_000  # chosen: of Gauss–Seidel
MAX_NEWTON = 100  # chosen: steps of Newton's method before it is given up
MAX_INTERIOR = 60  # chosen: steps of the interior-point method before it is given up
PIVOTS_PER_ROW = 50  # measured: Lemke needs 1 to 3 n pivots; exponential families excepted
PIVOTS_AT_LEAST = 10_000  # derived: lets the exponential family finish up to n = 13
PERTURBATIONS = (
    1e-7,
    -1e-7,
    1e-5,
)  # chosen: of b, by which it is moved aside: above rounding, below what is told apart
STATUSES = tuple(LCPStatus)


class Attempt(NamedTuple):
    """What one solver hands to the front door; `status` is its own word, not believed.

    `w` and `residual` come along where they were computed in the same compiled call.
    """

    z: np.ndarray
    status: LCPStatus
    iterations: int
    note: str
    w: np.ndarray | None = None
    residual: float = math.nan


def solve_lcp(A: Any, b: Any, solver: str = "auto", tol: float = 1e-10, guess: Any = None) -> LCPResult:
    """Solve the linear complementarity problem w = A z + b, 0 <= w _|_ z >= 0.

    Parameters
    ----------
    A : array_like or scipy.sparse matrix, shape (n, n)
    b : array_like, shape (n,)
    solver : str
        "auto", "lemke", "pivoting", "perturbed", "pgs", "newton", "interior", "enumeration", "qp" (osqp), or the name
        of an installed solver that qpsolvers knows, for symmetric positive semidefinite A.
    tol : float
        Largest accepted residual max_i |min(d_i z_i, w_i)| / min(s_i, max |b|), d_i = |A_ii| (the norm of row i where
        that is 0), s_i the sum of the sizes of the summands of w_i.
    guess : array_like, shape (n,), optional
        Where to start; "auto", "pivoting", "pgs", "newton", "interior" and the QP solvers use it.

    Returns
    -------
    LCPResult
        Not solved is a status, never an exception; z is then the best iterate.

    Raises
    ------
    InvalidInput
        When A is not square, sizes differ, an entry is not finite, tol <= 0, a QP solver is asked to solve an
        unsymmetric or indefinite problem, or a large one is sent to a solver for small ones.
    UnknownName
        When there is no solver of this name.

    Source: R. W. Cottle, J.-S. Pang, R. E. Stone, The Linear Complementarity Problem, 1992.

    Examples
    --------
    >>> from nonsmooth.lcp.solve import solve_lcp
    >>> result = solve_lcp([[2.0, 1.0], [1.0, 2.0]], [-5.0, -6.0])
    >>> result.status.name, result.z.round(12).tolist()
    ('SOLVED', [1.333333333333, 2.333333333333])
    >>> solve_lcp([[-1.0]], [-1.0]).status.name
    'INFEASIBLE'
    """
    if isinstance(solver, str) and solver == "auto" and guess is None:
        result = _at_once(A, b, tol)
        if result is not None:
            return result
    A = as_square(A)
    b = as_vector("b", b, A.shape[0])
    tol = as_tolerance("tol", tol)
    start = None if guess is None else np.maximum(as_vector("guess", guess, len(b)), 0.0)
    if not isinstance(solver, str) or (solver != "auto" and solver not in SOLVERS):
        _require_qp_solver(solver)
    if len(b) == 0:
        return LCPResult(b, b.copy(), LCPStatus.SOLVED, 0.0, 0, solver, "empty problem")
    if solver == "auto":
        if start is None and len(b) <= SMALL_N:
            first = _lemke(A, b, None, tol)  # most problems end here: what follows would take as long as a small one
            if first.residual <= tol:
                return _solved(first, "lemke")
            return climb(A, b, _ladder(A, False), tol, None, first)
        return climb(A, b, _ladder(A, start is not None), tol, start)
    return climb(A, b, (solver,), tol, start, use_certificate=False)


def _at_once(A: Any, b: Any, tol: Any) -> LCPResult | None:
    """The result for arrays of floats that Lemke's method ends at once; None where there is more to check or to try.

    Every entry goes into the residual, also those times 0: within the tolerance none is NaN or infinite.
    """
    if not (type(A) is type(b) is np.ndarray and A.dtype is b.dtype is FLOAT and type(tol) is float and 0 < tol < 1):
        return None
    if b.ndim != 1 or A.shape != (n := len(b), n) or not 0 < n <= SMALL_N:
        return None
    attempt = _lemke(A.copy(), b.copy(), None, tol)  # in the order of C, and writeable
    return _solved(attempt, "lemke") if attempt.residual <= tol else None


def climb(A: Any, b: np.ndarray, ladder: tuple[str, ...], tol: float, guess: np.ndarray | None,
          first: Attempt | None = None, use_certificate: bool = True) -> LCPResult:  # fmt: skip
    """Try the solvers in turn until the residual is within tol; the best iterate otherwise.

    ``first`` is what the first of them has done already.
    """
    best: LCPResult | None = None
    notes: list[str] = []
    iterations = 0
    for name in ladder:
        if name == "certificate":
            y = infeasibility_certificate(A, b)
            if y is not None and best is not None:
                notes.append("certificate: no z >= 0 has A z + b >= 0")
                return _infeasible(best, iterations, "; ".join(notes), y)
            if best is not None and best.status == LCPStatus.NO_SOLUTION:
                break
            continue
        attempt = first if first is not None and not notes else _run(name, A, b, guess, tol)
        result = _judged(A, b, attempt, name, tol)
        iterations += attempt.iterations
        notes.append(result.message)
        if result.success:
            if not best:
                return result
            return _replaced(result, iterations, "; ".join(notes))
        if best is None or not best.residual <= result.residual:
            best = _ranked(result, best)
        elif result.status == LCPStatus.NO_SOLUTION:
            best = _ranked(best, result)
        if name == "pgs" and use_certificate and np.isfinite(result.residual):
            guess = result.z
    assert best is not None
    return _replaced(best, iterations, "; ".join(notes))


def _ladder(A: Any, has_guess: bool) -> tuple[str, ...]:
    n = A.shape[0]
    if n <= SMALL_N:
        first = ("pivoting",) if has_guess else ()
        rest = ("enumeration", "certificate", "newton") if n <= LARGEST_N else ("newton", "certificate")
        return (*first, "lemke", "pivoting", "perturbed", *rest)
    last = ("certificate",) if n <= CERTIFICATE_N else ()
    if isinstance(A, np.ndarray):
        return ("interior", "newton", "lemke", *last)
    return ("pgs", "interior", "newton", *(("lemke",) if n <= CERTIFICATE_N else ()), *last)


def _judged(A: Any, b: np.ndarray, attempt: Attempt, name: str, tol: float) -> LCPResult:
    w, residual = attempt.w, attempt.residual
    if w is None:
        w = np.empty_like(b)
        residual = judge_solution(A, b, attempt.z, w) if isinstance(A, np.ndarray) else judge_sparse(A, b, attempt.z, w)
    if residual <= tol:
        return _solved(attempt._replace(w=w, residual=residual), name)
    if attempt.status != LCPStatus.SOLVED:
        status = attempt.status
    else:
        status = LCPStatus.MAX_ITERATIONS if np.isfinite(residual) else LCPStatus.INVALID
    message = f"{name}: {_REASONS[status]}, {attempt.note}, residual {residual:.1e} > {tol:.1e}"
    return LCPResult(attempt.z, w, status, residual, attempt.iterations, name, message)


def _solved(attempt: Attempt, name: str) -> LCPResult:
    """The result of an attempt whose residual is within the tolerance."""
    assert attempt.w is not None
    message = f"{name}: solved, {attempt.note}"
    return LCPResult(attempt.z, attempt.w, LCPStatus.SOLVED, attempt.residual, attempt.iterations, name, message)


_REASONS = {
    LCPStatus.RAY: "secondary ray",
    LCPStatus.MAX_ITERATIONS: "not converged",
    LCPStatus.INVALID: "broke off at a singular matrix, a diagonal entry <= 0 or an overflow",
    LCPStatus.NO_SOLUTION: "there is no solution",
}


def _ranked(result: LCPResult, previous: LCPResult | None) -> LCPResult:
    """The better iterate with the more telling status: that there is none, or a ray, is remembered."""
    known = [result.status, *([previous.status] if previous is not None else [])]
    status = next((told for told in (LCPStatus.NO_SOLUTION, LCPStatus.RAY) if told in known), result.status)
    return LCPResult(result.z, result.w, status, result.residual, result.iterations, result.solver, result.message)


def _replaced(result: LCPResult, iterations: int, message: str) -> LCPResult:
    return LCPResult(result.z, result.w, result.status, result.residual, iterations, result.solver, message)


def _infeasible(result: LCPResult, iterations: int, message: str, y: np.ndarray) -> LCPResult:
    return LCPResult(
        result.z, result.w, LCPStatus.INFEASIBLE, result.residual, iterations, result.solver, message, certificate=y
    )


# ---------------------------------------------------------------------------------------------------------------
# The solvers by name


def _lemke(A: Any, b: np.ndarray, guess: np.ndarray | None, tol: float) -> Attempt:
    n = len(b)
    z, w = np.empty(n), np.empty(n)
    most = max(PIVOTS_AT_LEAST, PIVOTS_PER_ROW * n)
    status, pivots, residual = judged_lemke(_dense(A, "lemke"), b, z, w, *lemke_workspace(n), most)
    return Attempt(z, STATUSES[status], pivots, f"{pivots} pivots", w, residual)


def _perturbed(A: Any, b: np.ndarray, guess: np.ndarray | None, tol: float) -> Attempt:
    """Lemke's method for b moved aside by numbers that no structure shares, which leaves no ties to go round in; then
    the equations of what it finds active, for b itself."""
    n, pivots, status = len(b), 0, LCPStatus.RAY
    z, dense = np.zeros(n), _dense(A, "perturbed")
    aside = np.maximum(np.abs(b), np.abs(b).max(initial=0.0)) * (0.5 + np.arange(1, n + 1) * GOLDEN_RATIO % 1.0)
    for size in PERTURBATIONS:
        near, w = np.empty(n), np.empty(n)
        code, more, _ = judged_lemke(dense, b - size * aside, near, w, *lemke_workspace(n), PIVOTS_AT_LEAST)
        status, pivots = STATUSES[code], pivots + more
        corner = solve_active_set(dense, b, near > 0.0) if status == LCPStatus.SOLVED else None
        if corner is None:
            continue
        z = np.maximum(corner, 0.0)
        if judge_solution(dense, b, z, w) <= tol:
            break
    return Attempt(z, status, pivots, f"{pivots} pivots beside b")


def _pivoting(A: Any, b: np.ndarray, guess: np.ndarray | None, tol: float) -> Attempt:
    n = len(b)
    z = np.zeros(n) if guess is None else guess.copy()
    most = max(200, 4 * n)
    status, iterations = pivoting_entry(_dense(A, "pivoting"), b, z, *pivoting_workspace(n), most)
    return Attempt(z, STATUSES[status], iterations, f"{iterations} iterations")


def _pgs(A: Any, b: np.ndarray, guess: np.ndarray | None, tol: float) -> Attempt:
    z = np.zeros(len(b)) if guess is None else guess.copy()
    if isinstance(A, np.ndarray):
        status, sweeps = pgs_entry(A, b, z, tol, MAX_SWEEPS)
    else:
        rows = A.indices.astype(np.int32, copy=False), A.indptr.astype(np.int32, copy=False)
        status, sweeps = pgs_sparse_entry(A.data, *rows, A.diagonal(), b, z, tol, MAX_SWEEPS)
    return Attempt(z, STATUSES[status], sweeps, f"{sweeps} sweeps")


def _newton(A: Any, b: np.ndarray, guess: np.ndarray | None, tol: float) -> Attempt:
    n = len(b)
    d = natural_scales(A)
    starts = [np.zeros(n), np.maximum(-b, 0.0) / d, np.full(n, np.abs(b).max()) / d]
    free = np.zeros(n, dtype=bool)
    total = 0
    for start in ([] if guess is None else [guess]) + starts:
        z, is_converged, iterations = newton_iterations(A, b, start, free, min(tol, 1e-10), MAX_NEWTON)
        total += iterations
        if is_converged:
            return Attempt(z, LCPStatus.SOLVED, total, f"{total} iterations")
    return Attempt(np.maximum(z, 0.0), LCPStatus.MAX_ITERATIONS, total, f"{total} iterations")


def _interior(A: Any, b: np.ndarray, guess: np.ndarray | None, tol: float) -> Attempt:
    start = np.zeros(len(b)) if guess is None else guess
    z, is_converged, steps = solve_by_interior_point(A, b, start, 0.5 * tol, MAX_INTERIOR)
    status = LCPStatus.SOLVED if is_converged else LCPStatus.MAX_ITERATIONS
    return Attempt(z, status, steps, f"{steps} steps")


def _enumeration(A: Any, b: np.ndarray, guess: np.ndarray | None, tol: float) -> Attempt:
    n = len(b)
    if n > LARGEST_N:
        raise InvalidInput(f"solver 'enumeration' takes problems of at most {LARGEST_N} unknowns; got {n}; use 'auto'")
    found = first_solution(_dense(A, "enumeration"), b, np.zeros(n, dtype=bool))
    if found.z is not None:
        return Attempt(found.z, LCPStatus.SOLVED, 2**n, "an active set found")
    if found.is_complete:
        return Attempt(np.zeros(n), LCPStatus.NO_SOLUTION, 2**n, f"none of {2**n} active sets is one")
    note = f"none of the first {ACTIVE_SETS_TRIED} candidates among {2**n} active sets is a solution"
    return Attempt(np.zeros(n), LCPStatus.MAX_ITERATIONS, 2**n, note)


def _quadratic(name: str) -> Callable[..., Attempt]:
    def solve(A: Any, b: np.ndarray, guess: np.ndarray | None, tol: float) -> Attempt:
        backend = "osqp" if name == "qp" else name
        z, is_claimed = solve_as_qp(_dense(A, name), b, np.zeros(len(b)) if guess is None else guess, backend)
        status = LCPStatus.SOLVED if is_claimed else LCPStatus.MAX_ITERATIONS
        return Attempt(z, status, 1, "one quadratic program")

    return solve


SOLVERS: dict[str, Callable[..., Attempt]] = {
    "lemke": _lemke,
    "pivoting": _pivoting,
    "perturbed": _perturbed,
    "pgs": _pgs,
    "newton": _newton,
    "interior": _interior,
    "enumeration": _enumeration,
    "qp": _quadratic("qp"),
}


def _run(name: str, A: Any, b: np.ndarray, guess: np.ndarray | None, tol: float) -> Attempt:
    """An attempt of the solver of this name."""
    return (SOLVERS.get(name) or _quadratic(name))(A, b, guess, tol)


def _require_qp_solver(name: Any) -> None:
    installed = solver_names()
    if not isinstance(name, str) or name not in installed:
        known = ["auto", *SOLVERS, *installed]
        raise UnknownName(f"solver must be one of {', '.join(known)}; got {shown(name)}; {nearest(name, known)}")


def as_square(A: Any) -> Any:
    """A dense float64 array or a CSR matrix with sorted indices, square and finite, or `InvalidInput`."""
    if isinstance(A, np.ndarray) or not hasattr(A, "tocsr"):
        return as_square_matrix("A", A)
    A = A.tocsr().astype(np.float64)
    if A.shape[0] != A.shape[1]:
        raise InvalidInput(f"A must be a square matrix; got shape {A.shape}")
    if not np.isfinite(A.data).all():
        raise InvalidInput(f"A must be finite; one of its entries is {A.data[~np.isfinite(A.data)][0]}")
    return as_square_matrix("A", A.toarray()) if A.shape[0] <= SMALL_N else A


def _dense(A: Any, solver: str) -> np.ndarray:
    if isinstance(A, np.ndarray):
        return A
    if A.shape[0] > DENSE_N:
        raise InvalidInput(
            f"solver {solver!r} makes a sparse A dense and takes at most {DENSE_N} rows; got {A.shape[0]}; use 'auto'"
        )
    return A.toarray()
