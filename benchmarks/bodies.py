"""``python -m benchmarks bodies``: contact problems of many bodies, given by masses and directions or by G, as a page.

    python -m benchmarks bodies > docs/benchmarks/bodies.md

Each problem is solved by `GlobalContactProblem.solve`, which knows the bodies, and by `solve_contact`, which is given
the assembled matrix, both to 1e-8 within CAP seconds of wall time. Times are those of the processor.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from benchmarks.problems import FAMILIES, RigidCase, heap
from benchmarks.solvers import table
from nonsmooth.contact.blocks.result import ContactResult
from nonsmooth.contact.blocks.solve import solve_contact

TOLERANCE = 1e-8
CAP = 10.0  # s of wall time for one problem
PROBLEMS: tuple[tuple[str, int, int, dict[str, float]], ...] = (
    ("wall", 400, 2, {}), ("wall", 1600, 2, {}), ("wall", 10_000, 2, {}), ("wall", 300, 3, {}), ("wall", 1000, 3, {}),
    ("wall", 3000, 3, {}), ("wall", 10_000, 3, {}), ("packing", 300, 2, {}), ("packing", 1000, 2, {}),
    ("packing", 100, 3, {}), ("packing", 500, 3, {}), ("packing", 1000, 3, {}), ("packing", 1000, 3, {"noise": 0.0}),
    ("packing", 1200, 3, {"disorder": 0.0}), ("packing", 1200, 3, {"disorder": 0.0, "noise": 0.0}),
    ("heap", 500, 3, {}), ("heap", 1000, 3, {}), ("heap", 1000, 3, {"noise": 0.0}),
    ("assembly", 1000, 3, {}), ("tower", 200, 3, {}),
)  # fmt: skip
SAID = {"noise": " at rest", "disorder": " in order"}


def main(words: list[str] | None = None) -> int:
    """Print the page; returns the exit code."""
    print("# Contact problems of many bodies\n")
    print("Made by `python -m benchmarks bodies` on one thread: processor time [s] to an error of")
    print(f"{TOLERANCE:g}, and the error where it is missed, {CAP:g} s of wall time at most. *By bodies* is")
    print("`GlobalContactProblem.solve`, *by G* `solve_contact` with the assembled matrix. The families are")
    print("described in `benchmarks/problems.py`; all are shaken but for those at rest.\n")
    print("\n".join(page()), flush=True)
    return 0


def page() -> Iterator[str]:
    """The table."""
    cases: list[Any] = [case_of(*problem) for problem in PROBLEMS]
    names = [
        f"{family} {dim}-D{''.join(SAID[key] for key in more)}, "
        f"{len(case.mu)} contacts of {len(case.given.f) // (3 * dim - 3)}"
        for (family, _, dim, more), case in zip(PROBLEMS, cases, strict=True)
    ]
    for case in (cases[0], cases[4]):  # compiled before it is timed
        case.given.solve(TOLERANCE)
        solve_contact(*case)
    columns = {"by bodies": list(map(cell(by_bodies), cases)), "by G": list(map(cell(by_matrix), cases))}
    yield from table("problem", names, columns)


def case_of(family: str, size: int, dim: int, more: dict[str, float]) -> Any:
    """A problem of the list."""
    rng = np.random.default_rng([0, size, dim])
    return heap(rng, size, **more) if family == "heap" else FAMILIES[family](rng, size, dim, **more)


def by_bodies(case: RigidCase) -> ContactResult:
    """With the bodies known."""
    return case.given.solve(TOLERANCE, CAP)


def by_matrix(case: RigidCase) -> ContactResult:
    """With G given."""
    return solve_contact(*case, tol=TOLERANCE, max_time=CAP)


def cell(solve: Callable[[RigidCase], ContactResult]) -> Callable[[RigidCase], str]:
    """Processor time of a solution, and the error where it is missed."""

    def timed(case: RigidCase) -> str:
        start = time.process_time()
        result = solve(case)
        seconds = time.process_time() - start
        return f"{seconds:.2g}" if result.success else f"{seconds:.2g} ({result.error:.0e})"

    return timed
