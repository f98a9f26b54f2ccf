"""Mixed complementarity:  w = A z + b,  w_i = 0 and z_i free (i in F),  0 <= w_i _|_ z_i >= 0 (i in C).

With K = F + S for a set S of complementary indices such that A_KK is regular, the principal pivot transform

    z_K = A_KK^-1 (w_K - b_K - A_KR z_R),      w_R = A_RK z_K + A_RR z_R + b_R

is an LCP in the unknowns w_S and z_R, R = C - S, with the complements z_S and w_R. S is empty when A_FF is regular
(a Schur complement). When A_FF has rank |F| - r, S collects r indices greedily so that the left and the right null
vectors of A_FF both see them. What is left over goes to the Newton iteration on the mixed problem, then to enumeration.

The residual counts |w_i| in free rows and |min(d_i z_i, w_i)| in the others, both over max |b|.

Source: R. W. Cottle, J.-S. Pang, R. E. Stone, The Linear Complementarity Problem, 1992, sections 1.5 and 2.3; the
choice of S is ours.
Equations: docs/theory/lcp.md, (11).
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from nonsmooth.checks.arrays import as_tolerance, as_vector
from nonsmooth.errors import InvalidInput, shown
from nonsmooth.lcp.certificate import infeasibility_certificate
from nonsmooth.lcp.enumerate import ACTIVE_SETS_TRIED, LARGEST_N, first_solution
from nonsmooth.lcp.mixed_few import FEW_MIXED, mixed_memory, solve_mixed
from nonsmooth.lcp.newton import linear_solve, solve_by_semismooth_newton
from nonsmooth.lcp.result import LCPResult, LCPStatus, natural_scales, worst_part
from nonsmooth.lcp.scaling import scaled_problem
from nonsmooth.lcp.solve import MAX_NEWTON, PIVOTS_AT_LEAST, PIVOTS_PER_ROW, Attempt, as_square, solve_lcp

ROUNDED_RESIDUAL = 1e-14  # chosen: some tens of roundings; what has more is solved again on its active set
RANK = 1e-9  # chosen: singular values of the equilibrated A_FF below this, relative to the largest, count as 0


def solve_mlcp(A: Any, b: Any, free: Any, solver: str = "auto", tol: float = 1e-10, guess: Any = None) -> LCPResult:
    """Solve the mixed problem w = A z + b with w_i = 0 in the free rows and 0 <= w_i _|_ z_i >= 0 in the others.

    Parameters
    ----------
    A : array_like or scipy.sparse matrix, shape (n, n)
    b : array_like, shape (n,)
    free : array_like
        A boolean mask, shape (n,), or the indices of the rows with w_i = 0 and z_i of either sign.
    solver : str
        The solver of `solve_lcp` for the problem without free variables; "auto" goes on to Newton and enumeration.
    tol : float
        Largest accepted residual.
    guess : array_like, shape (n,), optional
        Where to start.

    Returns
    -------
    LCPResult
        z, w of the whole problem, in the order given.

    Raises
    ------
    InvalidInput, UnknownName
        As `solve_lcp`; also when `free` is neither a mask nor indices.

    Source: R. W. Cottle, J.-S. Pang, R. E. Stone, The Linear Complementarity Problem, 1992, section 1.5.

    Examples
    --------
    >>> from nonsmooth.lcp.mixed import solve_mlcp
    >>> result = solve_mlcp([[0.0, 1.0], [-1.0, 1.0]], [-2.0, 1.0], free=[0])
    >>> result.success, result.z.tolist()
    (True, [3.0, 2.0])
    """
    A = as_square(A)
    b = as_vector("b", b, A.shape[0])
    free = _as_mask(free, len(b))
    tol = as_tolerance("tol", tol)
    start = None if guess is None else as_vector("guess", guess, len(b))
    if not free.any():
        return solve_lcp(A, b, solver, tol, None if start is None else np.maximum(start, 0.0))
    dense = A if isinstance(A, np.ndarray) else A.toarray()
    if isinstance(solver, str) and solver == "auto" and start is None and len(b) <= FEW_MIXED:
        result = _at_once(dense, b, free, tol)
        if result is not None:
            return result
    best: LCPResult | None = None
    notes: list[str] = []
    is_small = int((~free).sum()) <= LARGEST_N  # then the tree is complete before Newton's method has given up
    for attempt in (_by_elimination, *((_by_enumeration, _by_newton) if is_small else (_by_newton,))):
        if attempt is not _by_elimination and solver != "auto":
            break
        name, found = attempt(dense, b, free, solver, tol, start)
        result = _judged(dense, b, free, found, name, tol)
        notes.append(result.message)
        if best is None or not best.residual <= result.residual:
            best = result
        if result.status == LCPStatus.NO_SOLUTION:
            best = replace(best, status=result.status)
        if best.status in (LCPStatus.SOLVED, LCPStatus.NO_SOLUTION):
            break
    assert best is not None
    y = None if best.success or solver != "auto" else infeasibility_certificate(dense, b, free)
    if y is not None:
        notes.append("certificate: no z with these signs has w with its signs")
    return LCPResult(
        best.z, best.w, LCPStatus.INFEASIBLE if y is not None else best.status, best.residual, best.iterations,
        best.solver, "; ".join(notes), y,
    )  # fmt: skip


def _at_once(A: np.ndarray, b: np.ndarray, free: np.ndarray, tol: float) -> LCPResult | None:
    """The result where eliminating and pivoting end at rounding; None where the ways below have more to say."""
    n = len(b)
    z, w = np.empty(n), np.empty(n)
    most = max(PIVOTS_AT_LEAST, PIVOTS_PER_ROW * n)
    pivots, residual = solve_mixed(A, b, free, z, w, mixed_memory(n), most)
    if not residual <= min(tol, ROUNDED_RESIDUAL):
        return None
    note = f"{int(free.sum())} free variables eliminated, {pivots} pivots"
    message = f"lemke: SOLVED, {note}, residual {residual:.1e}"
    return LCPResult(z, w, LCPStatus.SOLVED, residual, pivots, "lemke", message)


def mlcp_residual(A: Any, b: np.ndarray, z: np.ndarray, free: np.ndarray) -> float:
    """max of |w_i| (free rows) and |min(d_i z_i, w_i)| (others), each over the lesser of max |b| and its summands."""
    w = A @ z + b
    return worst_part(np.abs(np.where(free, w, np.minimum(natural_scales(A) * z, w))), A, b, z)


def _as_mask(free: Any, n: int) -> np.ndarray:
    try:
        given = np.asarray(free)
    except Exception:  # rows of different lengths, or whatever an object raises: refused below
        given = np.zeros((1, 1))
    if given.dtype == bool and given.shape == (n,):
        return given.copy()
    if given.size == 0:
        return np.zeros(n, dtype=bool)
    if given.ndim != 1 or given.dtype.kind not in "iu" or given.min() < 0 or given.max() >= n:
        raise InvalidInput(
            f"free must be a boolean mask of {n} entries or indices from 0 to {n - 1}; got {shown(free)}"
        )
    mask = np.zeros(n, dtype=bool)
    mask[given] = True
    return mask


def _judged(A: np.ndarray, b: np.ndarray, free: np.ndarray, attempt: Attempt, name: str, tol: float) -> LCPResult:
    """The attempt, or the exact solution on its active set where that is better, with its residual."""
    z = attempt.z
    corner = _on_active_set(A, b, z, free)
    if mlcp_residual(A, b, corner, free) < mlcp_residual(A, b, z, free):
        z = corner
    residual = mlcp_residual(A, b, z, free)
    if residual <= tol:
        status = LCPStatus.SOLVED
    else:
        status = attempt.status if attempt.status != LCPStatus.SOLVED else LCPStatus.MAX_ITERATIONS
    message = f"{name}: {status.name}, {attempt.note}, residual {residual:.1e}"
    return LCPResult(z, A @ z + b, status, residual, attempt.iterations, name, message)


def _on_active_set(A: np.ndarray, b: np.ndarray, z: np.ndarray, free: np.ndarray) -> np.ndarray:
    scaled, c, _, column = scaled_problem(A, b)
    x = z / column
    K = np.flatnonzero(free | (x > scaled @ x + c))
    block = scaled[np.ix_(K, K)]
    step = linear_solve(block, -c[K] - block @ x[K])
    if step is None:
        step = np.linalg.lstsq(block, -c[K] - block @ x[K], rcond=None)[0]
    corner = np.zeros(len(b))
    corner[K] = x[K] + step
    again = linear_solve(block, -c[K] - block @ corner[K])
    if again is not None:
        corner[K] += again
    return np.where(free, corner, np.maximum(corner, 0.0)) * column


# ---------------------------------------------------------------------------------------------------------------
# Three ways


def _by_elimination(A: np.ndarray, b: np.ndarray, free: np.ndarray, solver: str, tol: float,
                    guess: np.ndarray | None) -> tuple[str, Attempt]:  # fmt: skip
    n = len(b)
    scaled, c, row, column = scaled_problem(A, b)
    S = _completing_set(scaled, free)
    if S is None:
        return "elimination", Attempt(np.zeros(n), LCPStatus.INVALID, 0, "no complementary rows complete A_FF")
    is_K = free.copy()
    is_K[S] = True
    K, R = np.flatnonzero(is_K), np.flatnonzero(~is_K)
    A_KK, A_KR, A_RK, A_RR = (scaled[np.ix_(i, j)] for i in (K, R) for j in (K, R))
    solution = np.linalg.solve(A_KK, np.column_stack([np.eye(len(K)), A_KR, c[K]]))
    inverse, X, x = solution[:, : len(K)], solution[:, len(K) : -1], solution[:, -1]
    s = np.flatnonzero(~free[K])  # places of S in K
    reduced = np.block([[inverse[np.ix_(s, s)], -X[s]], [A_RK @ inverse[:, s], A_RR - A_RK @ X]])
    c_reduced = np.concatenate([-x[s], c[R] - A_RK @ x])
    start = None
    if guess is not None:
        w_guess = (A @ guess + b) * row * np.abs(c).max() / max(np.abs(row * b).max(), np.finfo(float).tiny)
        start = np.maximum(np.concatenate([w_guess[K][s], (guess / column)[R]]), 0.0)
    result = solve_lcp(reduced, c_reduced, solver, tol, start)
    w_K = np.zeros(len(K))
    w_K[s] = result.z[: len(s)]
    z = np.zeros(n)
    z[R] = result.z[len(s) :]
    z[K] = inverse @ w_K - x - X @ z[R]
    z = np.where(free, z, np.maximum(z, 0.0)) * column
    note = f"{int(free.sum())} free variables eliminated" + (f" with {len(S)} others exchanged" if len(S) else "")
    return result.solver, Attempt(z, result.status, result.iterations, f"{note} ({result.message})")


def _completing_set(A: np.ndarray, free: np.ndarray) -> list[int] | None:
    """Complementary indices S such that A on F + S is regular; empty when A_FF is; None when the search fails."""
    F, C = np.flatnonzero(free), np.flatnonzero(~free)
    U, size, V = np.linalg.svd(A[np.ix_(F, F)])
    rank = int((size > RANK * max(size[0], np.finfo(float).tiny)).sum())
    left = U[:, rank:].T @ A[np.ix_(F, C)]  # (r, |C|): what the left null vectors see of each column
    right = A[np.ix_(C, F)] @ V[rank:].T  # (|C|, r)
    S: list[int] = []
    for _ in range(len(F) - rank):
        weight = np.linalg.norm(left, axis=0) * np.linalg.norm(right, axis=1)
        i = int(weight.argmax()) if len(weight) else -1
        if i < 0 or not weight[i] > RANK:
            return None
        S.append(int(C[i]))
        u, v = left[:, i] / np.linalg.norm(left[:, i]), right[i] / np.linalg.norm(right[i])
        left = left - np.outer(u, u @ left)
        right = right - np.outer(right @ v, v)
    K = np.concatenate([F, np.array(S, dtype=int)])
    spectrum = np.linalg.svd(A[np.ix_(K, K)], compute_uv=False)
    return S if spectrum[-1] > 1e-3 * RANK * spectrum[0] else None


def _by_newton(A: np.ndarray, b: np.ndarray, free: np.ndarray, solver: str, tol: float,
               guess: np.ndarray | None) -> tuple[str, Attempt]:  # fmt: skip
    n = len(b)
    total = 0
    starts = [np.zeros(n), np.where(free, 0.0, np.abs(b).max() / natural_scales(A))]
    for start in ([] if guess is None else [guess]) + starts:
        z, is_converged, iterations = solve_by_semismooth_newton(A, b, start, free, min(tol, 1e-10), MAX_NEWTON)
        total += iterations
        if is_converged:
            break
    status = LCPStatus.SOLVED if is_converged else LCPStatus.MAX_ITERATIONS
    return "newton", Attempt(z, status, total, f"{total} iterations on the mixed problem")


def _by_enumeration(A: np.ndarray, b: np.ndarray, free: np.ndarray, solver: str, tol: float,
                    guess: np.ndarray | None) -> tuple[str, Attempt]:  # fmt: skip
    m, zero = int((~free).sum()), np.zeros(len(b))
    found = first_solution(A, b, free)
    if found.z is not None:
        return "enumeration", Attempt(found.z, LCPStatus.SOLVED, 2**m, "an active set found")
    if found.is_complete:
        return "enumeration", Attempt(zero, LCPStatus.NO_SOLUTION, 2**m, f"none of {2**m} active sets works")
    note = f"none of the first {ACTIVE_SETS_TRIED} candidates among {2**m} active sets works"
    return "enumeration", Attempt(zero, LCPStatus.MAX_ITERATIONS, 2**m, note)
