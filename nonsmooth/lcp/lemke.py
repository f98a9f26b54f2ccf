"""Lemke's method with the lexicographic rule for  w = A z + b,  0 <= w _|_ z >= 0.

    w = b + A z + d z_0,      d > 0

is kept as a dictionary  basic = rhs + T nonbasic  of n rows and n + 1 columns (condensed: unit columns are not stored).
z_0 enters first and lifts every w to >= 0; then the complement of whatever left last enters, until z_0 leaves (solved)
or nothing blocks (secondary ray). Ties are decided as if b were b + (eps, eps^2, ...) for an infinitesimal eps: the
coefficients of that perturbation are the columns of w in the full tableau, all of which the condensed one still holds
(unit columns while w_k is basic, minus its stored column afterwards). So no basis ever returns.

The matrix is equilibrated first; with the entries near 1 the tolerances below are plain numbers.

Source: R. W. Cottle, J.-S. Pang, R. E. Stone, The Linear Complementarity Problem, 1992, algorithms 4.4.5 and 4.9.2.
Equations: docs/theory/lcp.md, (4) and (5).
"""

from __future__ import annotations

import numpy as np

from nonsmooth.jit import kernel
from nonsmooth.lcp.basis import resolve_basis
from nonsmooth.lcp.result import MAX_ITERATIONS, RAY, SOLVED, judge, lcp_residual
from nonsmooth.lcp.scaling import equilibrate
from nonsmooth.numerics.golden_ratio import GOLDEN_RATIO

PIVOT_TOLERANCE = 1e-11  # chosen: smallest pivot, relative to 1: 1e5 roundings of an entry near 1
TIE_TOLERANCE = 1e-13  # chosen: two values are equal when closer than this, relative to the largest |b|
# measured: redundant contacts of bodies with masses over six decades leave noise of 1e-10 where an exact tableau has
# zeros. Who takes it for pivots ends on a wrong basis, so an answer that misses ACCEPTED_LCP_RESIDUAL is sought again
# by a blunter eye: both tolerances times this. A regular matrix of condition 1e13 still needs the sharp ones.
BLUNT = 1e3
ACCEPTED_LCP_RESIDUAL = 1e-10  # chosen: residual: what `solve_lcp` asks for by default
COVERING_VECTORS = 6  # chosen: attempts before a ray is reported; a copositive or P matrix needs one


def lemke_workspace(n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Allocate what `lemke` needs for problems of up to n unknowns.

    Returns
    -------
    tableau : ndarray, shape (n, n + 2)
        The dictionary: columns of the n + 1 nonbasic variables, then the right-hand side.
    scales : ndarray, shape (4, n + 2)
        Row scales, column scales, scratch, covering vector d.
    basis : ndarray of int64, shape (4 n + 2,)
        Variable of each row, variable of each column, place of each variable.
    """
    return np.empty((n, n + 2)), np.empty((4, n + 2)), np.empty(4 * n + 2, np.int64)


@kernel
def lemke(n, A, b, z, tableau, scales, basis, max_pivots):
    """Solve w = A z + b, 0 <= w _|_ z >= 0; write z. Arrays may be larger than n.

    A secondary ray depends on the covering vector unless A is copositive or P, so a ray is followed by attempts with
    other ones. Returns (status, pivots): SOLVED, RAY or MAX_ITERATIONS. SOLVED is the method's own word: z is the final
    basis re-solved to full accuracy, and the caller still looks at `lcp_residual`.
    """
    if is_trivial(n, b):
        _rest(n, z, basis)
        return SOLVED, 0
    total, status = 0, RAY
    for attempt in range(COVERING_VECTORS + 1):
        _covering_vector(n, scales, max(0, attempt - 1))
        size = equilibrate(n, A, b, scales)
        load(n, A, b, size, tableau, scales, basis)
        status, pivots = lemke_pivots(n, tableau, scales, basis, 1.0 if attempt == 0 else BLUNT, max_pivots - total)
        _read(n, z, size, tableau, scales, basis)
        total += pivots
        if status == SOLVED and pivots > 0:
            resolve_basis(n, A, b, z, tableau, scales, basis)
            if attempt == 0 and not lcp_residual(n, A, b, z) <= ACCEPTED_LCP_RESIDUAL:
                continue
        if status != RAY:
            break
    return status, total


@kernel
def _covering_vector(n, scales, attempt):
    """d = 1 at first, then numbers in (0, 1) that no structure of the problem shares."""
    for i in range(n):
        scales[3, i] = 1.0 if attempt == 0 else 0.01 + (GOLDEN_RATIO * (i + 1) * (i + attempt)) % 0.99


@kernel
def lemke_pivots(n, tableau, scales, basis, noise, max_pivots):
    """The pivots of Lemke's method for d = scales[3, :n] on a loaded tableau. Returns (status, pivots).

    Both tolerances are multiplied by ``noise``.
    Variables are numbered w_k = k, z_k = n + k, z_0 = 2 n. On return basis[:n] holds the variable of each row.
    """
    row = _first_row(n, tableau)
    column = n  # z_0
    pivots = 0
    status = MAX_ITERATIONS
    while pivots < max_pivots:
        leaving = basis[row]
        exchange(n, tableau, scales, row, column)
        swap(n, basis, row, column)
        pivots += 1
        if leaving == 2 * n:
            status = SOLVED
            break
        entering = leaving + n if leaving < n else leaving - n
        column = basis[2 * n + 1 + entering] - n
        row = _leaving_row(n, tableau, basis, column, noise)
        if row < 0:
            status = RAY
            break
    return status, pivots


@kernel
def _read(n, z, size, tableau, scales, basis):
    """Write z as the tableau has it."""
    for i in range(n):
        z[i] = 0.0
    for i in range(n):
        variable = basis[i]
        if n <= variable < 2 * n:
            k = variable - n
            z[k] = max(0.0, tableau[i, n + 1] * size * scales[1, k])


@kernel
def _rest(n, z, basis):
    """Write z = 0, whose basis is that of w."""
    for i in range(n):
        z[i] = 0.0
        basis[i] = i


@kernel
def is_trivial(n, b):
    """Whether b >= 0, so that z = 0 is a solution."""
    for i in range(n):
        if not b[i] >= 0.0:
            return False
    return True


@kernel
def load(n, A, b, size, tableau, scales, basis):
    for i in range(n):
        for j in range(n):
            tableau[i, j] = scales[0, i] * A[i, j] * scales[1, j]
        tableau[i, n] = scales[3, i]
        tableau[i, n + 1] = scales[0, i] * b[i] / size
    for i in range(n):
        basis[i] = i
        basis[n + i] = n + i
        basis[2 * n + 1 + i] = i
        basis[3 * n + 1 + i] = n + i
    basis[2 * n] = 2 * n
    basis[4 * n + 1] = 2 * n


@kernel
def _first_row(n, tableau):
    """The row that z_0 replaces: lowest b_i / d_i, the last of equal ones (e_i is lexicographically least)."""
    row = 0
    for i in range(1, n):
        if tableau[i, n + 1] * tableau[row, n] <= tableau[row, n + 1] * tableau[i, n]:
            row = i
    return row


@kernel
def exchange(n, tableau, scales, row, column):
    """Exchange the basic variable of the row with the nonbasic one of the column.

    The pivot row is copied to scales[2]: from another array the inner loop vectorises (three times faster).
    """
    inverse = 1.0 / tableau[row, column]
    for j in range(n + 2):
        scales[2, j] = -inverse * tableau[row, j]
    scales[2, column] = inverse
    for i in range(n):
        factor = tableau[i, column]
        if i != row and factor != 0.0:
            tableau[i, column] = 0.0
            for j in range(n + 2):
                tableau[i, j] += factor * scales[2, j]
    for j in range(n + 2):
        tableau[row, j] = scales[2, j]


@kernel
def swap(n, basis, row, column):
    leaving = basis[row]
    entering = basis[n + column]
    basis[row] = entering
    basis[n + column] = leaving
    basis[2 * n + 1 + entering] = row
    basis[2 * n + 1 + leaving] = n + column


@kernel
def _leaving_row(n, tableau, basis, column, noise):
    """The row that blocks first, ties decided lexicographically, z_0 before all others; -1 if none blocks."""
    smallest = noise * PIVOT_TOLERANCE
    least = np.inf
    row = -1
    for i in range(n):
        slope = -tableau[i, column]
        if slope > smallest:
            ratio = max(tableau[i, n + 1], 0.0) / slope
            if ratio < least:
                least = ratio
                row = i
    if row < 0 or basis[row] == 2 * n:
        return row
    best = row
    for i in range(n):
        slope = -tableau[i, column]
        if i != row and slope > smallest and tableau[i, n + 1] - least * slope <= noise * TIE_TOLERANCE:
            if basis[i] == 2 * n:
                return i
            if _is_before(n, tableau, basis, column, i, best, noise):
                best = i
    return best


@kernel
def _is_before(n, tableau, basis, column, i, best, noise):
    """Whether row i is lexicographically before row `best`: first difference of B^-1 e_k / slope over k."""
    slope_i = -tableau[i, column]
    slope_best = -tableau[best, column]
    for k in range(n):
        place = basis[2 * n + 1 + k]
        if place < n:
            entry_i = 1.0 if place == i else 0.0
            entry_best = 1.0 if place == best else 0.0
        else:
            entry_i = -tableau[i, place - n]
            entry_best = -tableau[best, place - n]
        left = entry_i * slope_best
        right = entry_best * slope_i
        if abs(left - right) > noise * TIE_TOLERANCE * (abs(left) + abs(right)):
            return left < right
    return i < best


LEMKE = (
    "UniTuple(int64, 2)(float64[:, ::1], float64[::1], float64[::1], float64[:, ::1], float64[:, ::1],"
    "int64[::1], int64)"
)


@kernel(LEMKE, takes_arrays=True)
def lemke_entry(A, b, z, tableau, scales, basis, max_pivots):
    """`lemke` for calls from Python: returns (status, pivots)."""
    return lemke(b.shape[0], A, b, z, tableau, scales, basis, max_pivots)


@kernel(
    "Tuple((int64, int64, float64))(float64[:, ::1], float64[::1], float64[::1], float64[::1], float64[:, ::1],"
    "float64[:, ::1], int64[::1], int64)",
    takes_arrays=True,
)
def judged_lemke(A, b, z, w, tableau, scales, basis, max_pivots):
    """`lemke`, and w and the residual of what it leaves, in one call: (status, pivots, residual)."""
    n = b.shape[0]
    status, pivots = lemke(n, A, b, z, tableau, scales, basis, max_pivots)
    return status, pivots, judge(n, A, b, z, w)
