"""``python -m benchmarks solvers [FILE...]``: time and failures of the complementarity and friction solvers, as a page.

    python -m benchmarks solvers > docs/benchmarks/solvers.md

Kernels are timed in a compiled loop, as an integrator calls them; calls from Python stand beside. Every answer is
judged by its residual. Times are medians over random problems of the least of some repeats; the machine may be shared.
"""

from __future__ import annotations

import platform
import statistics
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from benchmarks import siconos
from benchmarks.lcp_times import (
    MOST,
    REPEATS,
    by_osqp,
    call_time,
    lemke_time,
    pivoting_in_numpy,
    pivoting_time,
    warm_pivoting_time,
)
from benchmarks.problems import FAMILIES, frictional_lcp, frictionless_lcp, normals
from nonsmooth.commands.solve_files import format_table, solve_files
from nonsmooth.contact.blocks.solve import solve_contact
from nonsmooth.lcp.lemke import lemke_entry, lemke_workspace
from nonsmooth.lcp.result import judge_solution, judge_sparse
from nonsmooth.lcp.solve import solve_lcp
from nonsmooth.numerics.quadratic_program import settings_of

SIZES = (3, 6, 12, 24, 48, 96)
SAMPLES = 20  # problems a size
TOLERANCE = 1e-10
CONTACTS = (8, 16, 32)
RANDOM = 1000  # frictional problems a size for the count of failures
FAMILY_SIZES = (10, 30, 100)
FAMILY_SAMPLES = 10
LARGE = (("packing", 300, 2), ("packing", 1000, 2), ("packing", 1000, 3), ("wall", 1000, 2), ("assembly", 3000, 3))
LARGE_TOLERANCE = 1e-8
QP_SOLVERS = ("osqp", "piqp")

Batch = tuple[np.ndarray, np.ndarray]  # A (count, n, n), b (count, n)


def main(files: list[str] | None = None) -> int:
    """Print the page; returns the exit code."""
    print("# Complementarity and friction solvers\n")
    print(
        f"Made by `python -m benchmarks solvers` on {platform.machine()}, Python {platform.python_version()}. Times of"
    )
    print(f"one problem are in microseconds: the median over {SAMPLES} random ones of the least of {REPEATS} repeats.")
    print("Where the machine is shared, single long runs may take two or three times as long as on a quiet one.\n")
    for section in (frictionless, frictional, failures, families, many_frictionless):
        print("\n".join(section()), flush=True)
    if files:
        print("\n".join(real_problems(files)))
    return 0


# ---------------------------------------------------------------------------------------------------------------
# The sections of the page


def frictionless() -> Iterator[str]:
    """Symmetric positive definite problems, which everybody can solve."""
    batches = [batch(frictionless_lcp, n, SAMPLES) for n in SIZES]
    yield "## Contacts without friction\n"
    yield "The matrix is symmetric and positive definite. A kernel runs in a compiled loop, as within an integrator;"
    yield "*warm* starts from the solution of a problem whose b differs by 1 %. The last column is one linear solve,"
    yield "for scale.\n"
    columns = {
        "Lemke kernel": microseconds(lemke_time, batches),
        "pivoting kernel": microseconds(pivoting_time, batches),
        "the same, warm": microseconds(warm_pivoting_time, batches),
        "`solve_lcp` call": microseconds(call_time(solve_lcp), batches),
        "pivoting in NumPy": microseconds(call_time(pivoting_in_numpy), batches),
        "osqp by qpsolvers": microseconds(call_time(by_osqp), batches),
        **siconos_times(batches),
        "`numpy.linalg.solve`": microseconds(call_time(np.linalg.solve), batches),
    }
    yield from table("n", SIZES, columns)


def frictional() -> Iterator[str]:
    """Planar friction as an unsymmetric LCP of three rows a contact: no quadratic program."""
    batches = [batch(frictional_lcp, n // 3, SAMPLES) for n in SIZES]
    yield "\n## Planar contacts with friction\n"
    yield "Three rows a contact, friction coefficients up to 1. The matrix is neither symmetric nor definite, so that"
    yield "quadratic programming does not apply.\n"
    columns = {
        "Lemke kernel": microseconds(lemke_time, batches),
        "`solve_lcp` call": microseconds(call_time(solve_lcp), batches),
        **siconos_times(batches),
        "`numpy.linalg.solve`": microseconds(call_time(np.linalg.solve), batches),
    }
    yield from table("n", SIZES, columns)


def failures() -> Iterator[str]:
    """How often Lemke's method alone misses the tolerance."""
    batches = [batch(frictional_lcp, n_c, RANDOM) for n_c in CONTACTS]
    yield f"\n## Failures in {RANDOM} random problems with friction\n"
    yield f"A failure is a residual above {TOLERANCE:g} in our measure, whatever a solver says of itself. There is no"
    yield "fallback here: these are the pivots alone.\n"
    columns = {"Lemke kernel": [misses(A, b, by_lemke(A, b)) for A, b in batches]}
    for name, answers in siconos.solve_lcps(batches).items():
        columns[f"Siconos {name}"] = [misses(A, b, found.z) for (A, b), found in zip(batches, answers, strict=True)]
    yield from table("contacts", CONTACTS, columns)


def families() -> Iterator[str]:
    """`solve_contact` on bodies of every kind."""
    yield "\n## Random friction problems of rigid and elastic bodies\n"
    yield f'`solve_contact(..., solver="auto")` to 1e-8: solved of {FAMILY_SAMPLES}; median and longest processor time'
    yield "in ms, on one thread (`OPENBLAS_NUM_THREADS=1`). The families are described in `benchmarks/problems.py`, the"
    yield "columns are dimension and contacts.\n"
    columns = {
        f"{dim}-D, {size}": [solved_and_time(name, size, dim) for name in FAMILIES]
        for dim in (2, 3)
        for size in FAMILY_SIZES
    }
    yield from table("family", list(FAMILIES), columns)


def many_frictionless() -> Iterator[str]:
    """Convex programming against Gauss-Seidel and interior points."""
    yield "\n## Many contacts without friction\n"
    yield "Normals of packings, walls and loose assemblies, sparse, mostly of deficient rank: milliseconds, and the"
    yield "residual where it misses 1e-8. Quadratic programs go straight to qpsolvers, scaled to order one.\n"
    problems = {}
    for family, size, dim in LARGE:
        A, b = normals(FAMILIES[family](np.random.default_rng(size), size, dim))
        problems[f"{family} {dim}-D, n = {len(b)}"] = A, b
    columns = {name: [milliseconds(A, b, name) for A, b in problems.values()] for name in ("pgs", "interior", "auto")}
    for name in QP_SOLVERS:
        columns[name] = [milliseconds_of_qp(A, b, name) for A, b in problems.values()]
    yield from table("contacts", list(problems), columns)


def real_problems(files: list[str]) -> Iterator[str]:
    """Problems from files, one row each."""
    yield "\n## Problems from files\n\n```text"
    yield format_table(solve_files(files))
    yield "```"


# ---------------------------------------------------------------------------------------------------------------
# Their numbers


def batch(draw: Callable[[np.random.Generator, int], tuple[np.ndarray, np.ndarray]], size: int, count: int) -> Batch:
    """Problems of one size, each with its own seed."""
    problems = [draw(np.random.default_rng([size, k]), size) for k in range(count)]
    return np.array([A for A, _ in problems]), np.array([b for _, b in problems])


def microseconds(seconds: Callable[[np.ndarray, np.ndarray], float], batches: list[Batch]) -> list[str]:
    """The median of each batch."""
    medians = [statistics.median(map(seconds, A, b)) for A, b in batches]
    return [f"{1e6 * value:.3g}" for value in medians]


def siconos_times(batches: list[Batch]) -> dict[str, list[str]]:
    """Columns of the solvers of Siconos where it is installed."""
    return {
        f"Siconos {name}": [f"{1e6 * statistics.median(found.time):.3g}" for found in answers]
        for name, answers in siconos.solve_lcps(batches).items()
    }


def by_lemke(A: np.ndarray, b: np.ndarray) -> np.ndarray:
    """What Lemke's kernel leaves for each problem of a batch."""
    z = np.zeros_like(b)
    memory = lemke_workspace(b.shape[1])
    for matrix, vector, answer in zip(A, b, z, strict=True):
        lemke_entry(matrix, vector, answer, *memory, MOST)
    return z


def misses(A: np.ndarray, b: np.ndarray, z: np.ndarray) -> int:
    """How many answers miss the tolerance."""
    w = np.empty(b.shape[1])
    return sum(not judge_solution(A[k], b[k], np.ascontiguousarray(z[k]), w) <= TOLERANCE for k in range(len(b)))


def solved_and_time(name: str, size: int, dim: int) -> str:
    """Solved problems of a family, and the median time in ms."""
    solved, times = 0, []
    for k in range(FAMILY_SAMPLES):
        case = FAMILIES[name](np.random.default_rng([k, size, dim]), size, dim)
        start = time.process_time()
        solved += solve_contact(*case).success
        times.append(time.process_time() - start)
    return f"{solved}; {1e3 * statistics.median(times):.2g}, {1e3 * max(times):.2g}"


def milliseconds(A: Any, b: np.ndarray, solver: str) -> str:
    """Time of `solve_lcp` on one large problem."""
    start = time.perf_counter()
    result = solve_lcp(A, b, solver=solver, tol=LARGE_TOLERANCE)
    return _cell(time.perf_counter() - start, result.residual)


def milliseconds_of_qp(A: Any, b: np.ndarray, solver: str) -> str:
    """Time of the quadratic program."""
    import qpsolvers
    from scipy.sparse import csc_matrix

    if solver not in qpsolvers.available_solvers:
        return "-"
    d = 1.0 / np.sqrt(A.diagonal())
    size = np.abs(d * b).max()
    P = csc_matrix(A.multiply(d[:, None]).multiply(d))
    start = time.perf_counter()
    x = qpsolvers.solve_qp(P, d * b / size, lb=np.zeros(len(b)), solver=solver, **settings_of(solver))
    elapsed = time.perf_counter() - start
    z = np.zeros(len(b)) if x is None else d * size * np.maximum(x, 0.0)
    return _cell(elapsed, judge_sparse(A, b, z, np.empty(len(b))))


def _cell(seconds: float, residual: float) -> str:
    missed = "" if residual <= LARGE_TOLERANCE else f" ({residual:.0e})"
    return f"{1e3 * seconds:.3g}{missed}"


def table(name: str, rows: Any, columns: dict[str, list]) -> Iterator[str]:
    """A Markdown table."""
    yield f"| {name} | " + " | ".join(columns) + " |"
    yield "|---" * (len(columns) + 1) + "|"
    for k, row in enumerate(rows):
        yield f"| {row} | " + " | ".join(str(values[k]) for values in columns.values()) + " |"
