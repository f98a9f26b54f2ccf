"""Every solution of a small  w = A z + b,  0 <= w _|_ z >= 0,  by a binary tree with shared pivots.

Level k of the tree decides index k: out (z_k = 0) or in (w_k = 0). The dictionary  basic = rhs + T nonbasic  of a node
serves all leaves below it, so that a leaf costs about 6 n operations instead of the n^3 / 3 of a fresh elimination.
An index that is in waits, row and column pending, until its row or another pending one has a pivot that is not small;
pending pairs left at a leaf mean that A_aa is singular: there the solutions form a face

    {z >= 0 : A z + b >= 0, z_i = 0 for i not in alpha, (A z + b)_i = 0 for i in alpha},

a point, a segment, a ray or more. A node is left when one of its rows can no longer be met: a row that must become
>= 0 with rhs < 0 and no positive coefficient (all nonbasic variables are >= 0), or likewise a row that must become 0.
Beside each rhs stands the sum of the sizes of the summands that it came from, and what is 0 is told by that: rows of
unlike units have each its own rounding.

Source: R. W. Cottle, J.-S. Pang, R. E. Stone, The Linear Complementarity Problem, 1992, sections 1.3 and 4.1 (pivots);
the pending rows and the pruning are ours.
Equations: docs/theory/lcp.md, (10).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.checks.arrays import as_square_matrix, as_vector
from nonsmooth.errors import InvalidInput
from nonsmooth.jit import kernel
from nonsmooth.lcp.scaling import scaled_problem

LARGEST_N = 20  # derived: 2^20 leaves: about a second when nothing can be pruned
SMALL_PIVOT = 1e-3  # chosen: a pending pivot below this waits for a better one
ZERO_PIVOT = 1e-11  # chosen: below this the pending block is singular
SIGN_SLACK = 1e-9  # chosen: of its summands: a value this far below 0 still counts as 0
SAME_SOLUTION = 1e-8  # chosen: scaled solutions closer than this are one
ACTIVE_SETS_TRIED = 256  # chosen: active sets that a solver of one solution looks at
DEAD, UNDECIDED, PENDING, DECIDED, UNSIGNED = range(5)


@dataclass(frozen=True)
class LCPSolution:
    """One solution, or one convex set (face) of solutions.

    Attributes
    ----------
    z, w : ndarray, shape (n,)
        The solution; of a face a point of its relative interior.
    active : ndarray of bool, shape (n,)
        The set alpha: z_i = 0 outside it and w_i = 0 inside it, all over the face.
    directions : ndarray, shape (k, n)
        Orthonormal directions that span the face; k = 0 for an isolated solution.
    is_bounded : bool
        False for a ray and every other face that goes to infinity.
    """

    z: np.ndarray
    w: np.ndarray
    active: np.ndarray
    directions: np.ndarray = field(repr=False)
    is_bounded: bool

    @property
    def dimension(self) -> int:
        """0 for a point, 1 for a segment or ray, ..."""
        return len(self.directions)

    @property
    def is_isolated(self) -> bool:
        """Whether no other solution is near."""
        return self.dimension == 0


def lcp_solutions(A: Any, b: Any) -> tuple[LCPSolution, ...]:
    """Every solution of w = A z + b, 0 <= w _|_ z >= 0.

    Parameters
    ----------
    A : array_like, shape (n, n)
        With n <= 20: the tree has up to 2^n leaves.
    b : array_like, shape (n,)

    Returns
    -------
    tuple of LCPSolution
        Isolated solutions first, then faces that no other face contains. Empty if there is none. Points that lie on a
        face are not listed apart.

    Raises
    ------
    InvalidInput
        When A is not square, the sizes differ, an entry is not finite, or n > 20.

    Examples
    --------
    >>> from nonsmooth.lcp.enumerate import lcp_solutions
    >>> [solution.z.tolist() for solution in lcp_solutions([[-1.0]], [2.0])]
    [[0.0], [2.0]]
    >>> (segment,) = lcp_solutions([[1.0, 1.0], [1.0, 1.0]], [-1.0, -1.0])
    >>> segment.dimension, segment.is_bounded
    (1, True)
    """
    A = as_square_matrix("A", A)
    b = as_vector("b", b, len(A))
    if len(b) > LARGEST_N:
        raise InvalidInput(f"n must be at most {LARGEST_N} to list every solution; got {len(b)}; use solve_lcp for one")
    return tuple(enumerate_solutions(A, b, np.zeros(len(b), dtype=bool), limit=None))


def enumerate_solutions(A: np.ndarray, b: np.ndarray, free: np.ndarray, limit: int | None = None) -> list[LCPSolution]:
    """The solutions of the mixed problem, with at most `limit` supports looked at in detail."""
    n = len(b)
    if n == 0:
        empty = np.zeros(0)
        return [LCPSolution(empty, empty, np.zeros(0, dtype=bool), np.zeros((0, 0)), True)]
    scaled, c, _, column = scaled_problem(A, b)
    supports = _supports(np.ascontiguousarray(scaled), c, free, limit)
    points: list[_Face] = []
    faces: list[_Face] = []
    for active in supports:
        face = _face(scaled, c, active, free)
        if face is not None:
            (faces if len(face.directions) else points).append(face)
    faces.sort(key=lambda face: -len(face.directions))
    kept: list[_Face] = []
    for face in faces + points:
        if not any(_contains(other, face, free) for other in kept):
            kept.append(face)
    kept.sort(key=lambda face: len(face.directions))
    return [_in_units_of(A, b, face, column) for face in kept]


class FirstFound(NamedTuple):
    """A solution or None, and where there is none whether every active set was looked at."""

    z: np.ndarray | None
    is_complete: bool


def first_solution(A: np.ndarray, b: np.ndarray, free: np.ndarray) -> FirstFound:
    """One solution of the mixed problem, from at most `ACTIVE_SETS_TRIED` of the active sets that the tree leaves."""
    scaled, c, _, column = scaled_problem(A, b)
    for limit in (1, ACTIVE_SETS_TRIED):
        supports = _supports(np.ascontiguousarray(scaled), c, free, limit)
        for active in supports:
            face = _face(scaled, c, active, free)
            if face is not None:
                return FirstFound(column * face.z, False)
        if len(supports) < limit:
            return FirstFound(None, True)
    return FirstFound(None, False)


@dataclass
class _Face:
    """A set of solutions of the scaled problem with a point z of its relative interior."""

    z: np.ndarray
    w: np.ndarray
    active: np.ndarray
    directions: np.ndarray
    is_bounded: bool


def _supports(A: np.ndarray, b: np.ndarray, free: np.ndarray, limit: int | None) -> np.ndarray:
    """The active sets that may carry solutions, shape (n_found, n), as found by the tree."""
    n = len(b)
    capacity = limit or 256
    while True:
        found = np.zeros((capacity, n), dtype=np.int8)
        tableaux = np.zeros((n + 1, n, n + 2))
        kinds = np.zeros((n + 1, 2, n), dtype=np.int8)
        count = tree_entry(A, b, free.astype(np.int8), tableaux, kinds, np.zeros(n, dtype=np.int8), found)
        if count <= capacity and (count < capacity or limit is not None):
            return found[:count].astype(bool)
        if limit is not None:
            return found.astype(bool)
        capacity *= 8


def _face(A: np.ndarray, b: np.ndarray, active: np.ndarray, free: np.ndarray) -> _Face | None:
    """The solutions with this active set; None if there are none."""
    n = len(b)
    index = np.flatnonzero(active)
    z = np.zeros(n)
    null = np.zeros((0, n))
    if len(index):
        block = A[np.ix_(index, index)]
        U, s, V = np.linalg.svd(block)
        rank = int((s > ZERO_PIVOT * s[0]).sum()) if s[0] > 0 else 0
        null = np.zeros((len(index) - rank, n))
        null[:, index] = V[rank:]
        if rank == len(index):
            z[index] = np.linalg.solve(block, -b[index])
            z[index] += np.linalg.solve(block, -b[index] - block @ z[index])
        else:
            z[index] = V[:rank].T @ ((U[:, :rank].T @ -b[index]) / s[:rank])
    is_bounded = True
    if len(null):
        found = _relative_interior(A, b, z, null, active, free)
        if found is None:
            return None
        z, null, is_bounded = found
    w = A @ z + b
    slack = SIGN_SLACK * (np.abs(A) @ np.abs(z) + np.abs(b))
    has_wrong_z = (z < -SIGN_SLACK * max(1.0, np.abs(z).max())) & active & ~free
    if (np.where(active, np.abs(w), -w) > slack).any() or has_wrong_z.any():
        return None
    z = np.where(free, z, np.maximum(z, 0.0))
    return _Face(z, np.where(active, 0.0, np.maximum(w, 0.0)), active, null, is_bounded)


def _relative_interior(A: np.ndarray, b: np.ndarray, z: np.ndarray, null: np.ndarray, active: np.ndarray,
                       free: np.ndarray) -> tuple[np.ndarray, np.ndarray, bool] | None:  # fmt: skip
    """A point of the relative interior of {z + null^T t : all signs right}, the directions that span it, boundedness.

    Maximise sum s_i over 0 <= s_i <= 1, s <= tau v + V t, tau >= 1: the rows with s_i = 0 hold with equality all over.
    """
    from scipy.linalg import null_space
    from scipy.optimize import linprog

    k = len(null)
    values = np.concatenate([z[active & ~free], (A @ z + b)[~active]])
    slopes = np.vstack([null[:, active & ~free].T, (A @ null.T)[~active]])
    m = len(values)
    cost = np.concatenate([-np.ones(m), np.zeros(k + 1)])
    rows = np.hstack([np.eye(m), -values[:, None], -slopes])
    bounds = [(0, 1)] * m + [(1, None)] + [(None, None)] * k
    answer = linprog(cost, A_ub=rows, b_ub=np.zeros(m), bounds=bounds, method="highs")
    if answer.status != 0:
        return None
    tau, t = answer.x[m], answer.x[m + 1 :] / answer.x[m]
    is_equality = answer.x[:m] < 0.5  # homogeneous: an s_i that can be positive reaches 1
    spanning = null_space(slopes[is_equality]) if is_equality.any() else np.eye(k)
    z = z + null.T @ t
    if not np.isfinite(tau) or spanning.shape[1] == 0:
        return z, np.zeros((0, len(b))), True
    reduced = slopes[~is_equality] @ spanning
    recession = linprog(
        -reduced.sum(axis=0), A_ub=-reduced, b_ub=np.zeros(len(reduced)), bounds=(-1, 1), method="highs"
    )
    has_line = np.linalg.matrix_rank(reduced, tol=SAME_SOLUTION) < spanning.shape[1]
    is_bounded = not has_line and not (recession.status == 0 and recession.fun < -SAME_SOLUTION)
    return z, (null.T @ spanning).T, is_bounded


def _contains(face: _Face, other: _Face, free: np.ndarray) -> bool:
    """Whether the other set lies in the face (or is the same point): its interior point obeys the face's zeros."""
    size = max(1.0, np.abs(other.z).max())
    if not len(face.directions):
        return bool(np.abs(face.z - other.z).max() <= SAME_SOLUTION * size)
    zeros = np.concatenate([other.z[~face.active], other.w[face.active]])
    return bool(np.abs(zeros).max(initial=0.0) <= SAME_SOLUTION * size)


def _in_units_of(A: np.ndarray, b: np.ndarray, face: _Face, column: np.ndarray) -> LCPSolution:
    z = column * face.z
    directions = face.directions * column
    if len(directions):
        directions = np.linalg.qr((directions / np.abs(directions).max()).T)[0].T
    return LCPSolution(z, A @ z + b, face.active, directions, face.is_bounded)


# ---------------------------------------------------------------------------------------------------------------
# The tree


TREE = "int64(float64[:, ::1], float64[::1], int8[::1], float64[:, :, ::1], int8[:, :, ::1], int8[::1], int8[:, ::1])"


@kernel(TREE, takes_arrays=True)
def tree_entry(A, b, free, tableaux, kinds, choice, found):
    """Write the active sets of all leaves that survive; return how many, at most the rows of `found`.

    Level k has its dictionary in tableaux[k] and the kinds of its rows and columns in kinds[k, 0] and kinds[k, 1].
    choice[k] is what level k tries next: 0 out, 1 in, 2 both done; so choice - 1 is the path that led to a leaf.
    """
    n = b.shape[0]
    for i in range(n):
        for j in range(n):
            tableaux[0, i, j] = A[i, j]
        tableaux[0, i, n], tableaux[0, i, n + 1] = b[i], abs(b[i])
        kinds[0, 0, i] = UNDECIDED
        kinds[0, 1, i] = UNDECIDED
    count = 0
    level = 0
    choice[0] = 1 if free[0] == 1 else 0
    while level >= 0:
        if choice[level] > 1:
            level -= 1
            continue
        is_in = choice[level] == 1
        choice[level] += 1
        decide(n, tableaux, kinds, level, is_in, free)
        if is_hopeless(n, tableaux, kinds, level + 1, free):
            continue
        if level + 1 < n:
            level += 1
            choice[level] = 1 if free[level] == 1 else 0
            continue
        if not pivot_pending(n, tableaux, kinds, n, ZERO_PIVOT, free):
            continue
        for i in range(n):
            found[count, i] = choice[i] - 1
        count += 1
        if count == found.shape[0]:
            return count
    return count


@kernel
def decide(n, tableaux, kinds, level, is_in, free):
    """Copy the node of this level to the next with index `level` decided."""
    for i in range(n):
        for j in range(level, n + 2):
            tableaux[level + 1, i, j] = tableaux[level, i, j]
        for j in range(level):
            if kinds[level, 1, j] == PENDING:
                tableaux[level + 1, i, j] = tableaux[level, i, j]
        kinds[level + 1, 0, i] = kinds[level, 0, i]
        kinds[level + 1, 1, i] = kinds[level, 1, i]
    kinds[level + 1, 0, level] = PENDING if is_in else DECIDED
    kinds[level + 1, 1, level] = PENDING if is_in else DEAD
    if is_in:
        pivot_pending(n, tableaux, kinds, level + 1, SMALL_PIVOT, free)


@kernel
def pivot_pending(n, tableaux, kinds, level, smallest, free):
    """Exchange pending rows and columns while a pivot above `smallest` is left; False if a row cannot become 0."""
    while True:
        best = smallest
        row = -1
        column = -1
        for i in range(n):
            if kinds[level, 0, i] == PENDING:
                for j in range(n):
                    if kinds[level, 1, j] == PENDING and abs(tableaux[level, i, j]) > best:
                        best = abs(tableaux[level, i, j])
                        row = i
                        column = j
        if row < 0:
            break
        exchange(n, tableaux, kinds, level, row, column)
        kinds[level, 0, row] = UNSIGNED if free[column] == 1 else DECIDED
        kinds[level, 1, column] = DEAD
    return not is_hopeless(n, tableaux, kinds, level, free)


@kernel
def exchange(n, tableaux, kinds, level, row, column):
    """z_column becomes basic in this row; the column's new variable is 0 for good, so the column is not formed."""
    inverse = -1.0 / tableaux[level, row, column]
    tableaux[level, row, n + 1] *= abs(inverse)
    for j in range(n + 1):
        if j == n or (kinds[level, 1, j] != DEAD and j != column):
            tableaux[level, row, j] *= inverse
    for i in range(n):
        factor = tableaux[level, i, column]
        if i != row and factor != 0.0:
            for j in range(n + 1):
                if j == n or (kinds[level, 1, j] != DEAD and j != column):
                    tableaux[level, i, j] += factor * tableaux[level, row, j]
            tableaux[level, i, n + 1] += abs(factor) * tableaux[level, row, n + 1]


@kernel
def is_hopeless(n, tableaux, kinds, level, free):
    """Whether some row can have no right value for any nonbasic variables >= 0 (of either sign if free)."""
    for i in range(n):
        kind = kinds[level, 0, i]
        value, slack = tableaux[level, i, n], SIGN_SLACK * tableaux[level, i, n + 1]
        if kind == UNSIGNED or (kind != PENDING and value >= -slack) or abs(value) <= slack:
            continue
        is_open = False
        for j in range(n):
            if kinds[level, 1, j] != DEAD:
                slope = tableaux[level, i, j] if value < 0.0 else -tableaux[level, i, j]
                if slope > ZERO_PIVOT or (free[j] == 1 and slope < -ZERO_PIVOT):
                    is_open = True
                    break
        if not is_open:
            return True
    return False
