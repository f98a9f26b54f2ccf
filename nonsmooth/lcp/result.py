"""What a solver of  w = A z + b,  0 <= w _|_ z >= 0  hands back, and the measure by which it is judged.

    residual = max_i |min(d_i z_i, w_i)| / max(min(s_i, b), eps b),     s_i = |b_i| + sum_j |A_ij z_j|,  b = max_i |b_i|

with d_i = |A_ii|, or the norm of row i where A_ii = 0. A row is judged by the largest b and by its own summands, of
which w_i is the sum: rows of unlike units do not hide one another (the row by row backward error; Higham, *Accuracy and
Stability of Numerical Algorithms*, 2002, section 7.1). A row whose summands are all below a rounding eps = 2^-52 of the
largest b holds nothing but rounding, as where mu la_N of an open contact is its friction bound: it is judged by that
rounding, and a wrong one is seen where its summands are above 1e-26 of the largest b. The measure has no unit and does
not change when A, or b, or both are multiplied by a number. It is always computed from A, b and z alone: no solver's
own statement of success is believed.
Equations: docs/theory/lcp.md, (1) and (2).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any

import numpy as np

from nonsmooth.jit import kernel
from nonsmooth.numerics.rounding import EPS
from nonsmooth.views import Worded


class LCPStatus(IntEnum):
    """How the solution of a complementarity problem ended."""

    SOLVED = 0  # the residual is within the tolerance
    RAY = 1  # the path of Lemke's method went to infinity: a solution may exist or not
    MAX_ITERATIONS = 2  # the iterations ran out, or no longer improved the iterate
    INVALID = 3  # the numbers overflowed or a matrix met on the way was singular
    INFEASIBLE = 4  # there is no z >= 0 with A z + b >= 0, and `certificate` proves it
    NO_SOLUTION = 5  # every active set was tried, or left where a row has no right sign: there is none


SOLVED, RAY, MAX_ITERATIONS, INVALID, INFEASIBLE = map(int, list(LCPStatus)[:-1])  # code: for kernels


@dataclass(frozen=True, repr=False)
class LCPResult(Worded):
    """The outcome of one complementarity problem w = A z + b, 0 <= w _|_ z >= 0.

    Attributes
    ----------
    z, w : ndarray, shape (n,)
        The solution, or the best iterate when `success` is false; w is A z + b exactly as computed.
    status : LCPStatus
        How it ended.
    residual : float
        max_i |min(d_i z_i, w_i)| / min(s_i, max |b|), s_i the sum of the sizes of the summands of w_i, recomputed from
        A, b and z.
    iterations : int
        Pivots, sweeps or Newton steps, summed over the solvers tried.
    solver : str
        The solver that produced z.
    message : str
        What was done and why it stopped.
    certificate : ndarray or None, shape (n,)
        For INFEASIBLE: y >= 0 with A^T y <= 0 and b.y < 0, checked.
    """

    z: np.ndarray
    w: np.ndarray
    status: LCPStatus
    residual: float
    iterations: int
    solver: str
    message: str
    certificate: np.ndarray | None = field(default=None, repr=False)

    @property
    def success(self) -> bool:
        """Whether the problem is solved to the tolerance asked for."""
        return self.status == LCPStatus.SOLVED


@kernel
def natural_scale(n, A, i):
    """d_i: |A_ii|, or the norm of row i where that is 0, or the largest entry of A where that too is 0 (or 1)."""
    if A[i, i] != 0.0:
        return abs(A[i, i])
    largest = 0.0
    for j in range(n):
        largest = max(largest, abs(A[i, j]))
    if largest > 0.0:
        total = 0.0
        for j in range(n):
            part = A[i, j] / largest
            total += part * part
        return largest * math.sqrt(total)
    for k in range(n):
        for j in range(n):
            largest = max(largest, abs(A[k, j]))
    return largest if largest > 0.0 else 1.0


@kernel
def lcp_residual(n, A, b, z):
    """max_i |min(d z, A z + b)|_i / min(s_i, max |b|); where b = 0 it is 0 at a solution and inf elsewhere.

    Where anything is NaN, or b infinite, it is NaN.
    """
    worst = 0.0
    scale = 0.0
    for i in range(n):
        scale = max(scale, abs(b[i]))
    for i in range(n):
        w, size = b[i], abs(b[i])
        for j in range(n):
            part = A[i, j] * z[j]
            w += part
            size += abs(part)
        dz = natural_scale(n, A, i) * z[i]
        if math.isnan(w) or math.isnan(dz):
            return math.nan
        worst = max(worst, part_of(abs(w) if w < dz else abs(dz), size, scale))
    return math.nan if math.isinf(scale) else worst


@kernel
def part_of(error, size, scale):
    """By which part of its own summands, or of the largest b, a row is wrong; at least of a rounding of that."""
    least = max(min(size, scale), EPS * scale)
    if error == 0.0:
        return 0.0
    return error / least if least > 0.0 else math.inf


@kernel
def judge(n, A, b, z, w):
    """Write w = A z + b and return `lcp_residual`: the last step of every solver called from Python."""
    for i in range(n):
        w[i] = b[i]
        for j in range(n):
            w[i] += A[i, j] * z[j]
    return lcp_residual(n, A, b, z)


@kernel("float64(float64[:, ::1], float64[::1], float64[::1], float64[::1])", takes_arrays=True)
def judge_solution(A, b, z, w):
    """`judge` for calls from Python."""
    return judge(b.shape[0], A, b, z, w)


def judge_sparse(A: Any, b: np.ndarray, z: np.ndarray, w: np.ndarray) -> float:
    """`judge_solution` for a scipy.sparse CSR matrix."""
    w[:] = A @ z + b
    return worst_part(np.abs(np.minimum(natural_scales(A) * z, w)), A, b, z)


def worst_part(error: np.ndarray, A: Any, b: np.ndarray, z: np.ndarray) -> float:
    """The largest part of its own summands, or of the largest b, by which a row is wrong: max of `part_of`."""
    scale = np.abs(b).max(initial=0.0)
    least = np.maximum(np.minimum(np.abs(b) + abs(A) @ np.abs(z), scale), EPS * scale)
    wrong = error > 0.0
    with np.errstate(divide="ignore"):
        return float((error[wrong] / least[wrong]).max(initial=0.0)) if not np.isnan(error).any() else math.nan


def natural_scales(A: Any) -> np.ndarray:
    """The d_i of `natural_scale` for a dense or scipy.sparse matrix, shape (n,)."""
    d = np.abs(A.diagonal())
    if not d.all():
        square = A**2 if isinstance(A, np.ndarray) else A.power(2)
        d = np.where(d > 0, d, np.sqrt(np.asarray(square.sum(axis=1)).ravel()))
    return np.where(d > 0, d, abs(A).max() or 1.0)
