"""Seconds that one linear complementarity problem takes: kernels in a compiled loop, calls from Python, other codes."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from nonsmooth.jit import kernel
from nonsmooth.lcp.lemke import lemke, lemke_workspace
from nonsmooth.lcp.pivoting import pivoting, pivoting_workspace
from nonsmooth.numerics.quadratic_program import settings_of

REPEATS = 5
AT_LEAST = 5e-4  # s: a kernel is called as often as this takes
MOST = 100_000  # pivots or iterations

SIGNATURE = (
    "void(float64[:, ::1], float64[::1], float64[::1], float64[::1], float64[:, ::1], float64[:, ::1],"
    " int64[::1], int64)"
)


@kernel(SIGNATURE)
def repeat_lemke(A, b, guess, z, tableau, scales, basis, times):
    """Solve the same problem some times."""
    for _ in range(times):
        lemke(b.shape[0], A, b, z, tableau, scales, basis, MOST)


@kernel(SIGNATURE)
def repeat_pivoting(A, b, guess, z, lu, scales, active, times):
    """Solve the same problem some times from the same guess."""
    for _ in range(times):
        for i in range(b.shape[0]):
            z[i] = guess[i]
        pivoting(b.shape[0], A, b, z, lu, scales, active, MOST)


def lemke_time(A: np.ndarray, b: np.ndarray) -> float:
    """Seconds of a solve by Lemke's kernel."""
    return _kernel_time(repeat_lemke, A, b, np.zeros(len(b)), lemke_workspace(len(b)))


def pivoting_time(A: np.ndarray, b: np.ndarray) -> float:
    """Seconds of a solve by block pivoting from nothing."""
    return _kernel_time(repeat_pivoting, A, b, np.zeros(len(b)), pivoting_workspace(len(b)))


def warm_pivoting_time(A: np.ndarray, b: np.ndarray) -> float:
    """Seconds of a solve by block pivoting from the solution of a problem whose b differs by one per cent."""
    guess = np.zeros(len(b))
    nearby = b * (1.0 + 0.01 * np.random.default_rng(len(b)).standard_normal(len(b)))
    repeat_lemke(A, nearby, guess, guess, *lemke_workspace(len(b)), 1)
    return _kernel_time(repeat_pivoting, A, b, guess, pivoting_workspace(len(b)))


def _kernel_time(repeat: Callable[..., None], A: np.ndarray, b: np.ndarray, guess: np.ndarray, memory: Any) -> float:
    def seconds(times: int) -> float:
        start = time.perf_counter()
        repeat(A, b, guess, np.zeros(len(b)), *memory, times)
        return time.perf_counter() - start

    times = max(1, round(AT_LEAST / max(min(seconds(1) for _ in range(3)), 1e-7)))
    return min(seconds(times) for _ in range(REPEATS)) / times


def call_time(solve: Callable[[np.ndarray, np.ndarray], Any]) -> Callable[[np.ndarray, np.ndarray], float]:
    """The function that measures the seconds of one call from Python."""

    def measure(A: np.ndarray, b: np.ndarray) -> float:
        least = np.inf
        for _ in range(REPEATS):
            start = time.perf_counter()
            solve(A, b)
            least = min(least, time.perf_counter() - start)
        return least

    return measure


def pivoting_in_numpy(A: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Block pivoting in the fewest lines of NumPy, without the safeguard: what a user would write."""
    active = b < 0
    for _ in range(100):
        z = np.zeros_like(b)
        z[active] = np.linalg.solve(A[np.ix_(active, active)], -b[active])
        following = z > A @ z + b
        if (following == active).all():
            break
        active = following
    return z


def by_osqp(A: np.ndarray, b: np.ndarray) -> np.ndarray | None:
    """The quadratic program through qpsolvers."""
    import qpsolvers
    from scipy.sparse import csc_matrix

    return qpsolvers.solve_qp(csc_matrix(A), b, lb=np.zeros(len(b)), solver="osqp", **settings_of("osqp"))
