"""The ladder of ``solve_contact(..., solver="auto")``: which solvers are tried, in which order, and the climb.

Each rung starts from the best iterate so far, until the error is within the tolerance:

    one contact     single (closed form in the plane, a bracketed root in space)
    no friction     the linear complementarity problem of the normals first
    otherwise       nsgs (100 sweeps); newton where factors are cheap; interior points from four distances, each with
                    newton after it
    few contacts    then pivoting on the cone with the fewest facets, and from its solution newton and interior
    at last         nsgs (20 000 sweeps)

then a polish where factors are cheap. ``python -m benchmarks ladder`` compares ladders (docs/benchmarks/ladder.md).
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterable
from typing import NamedTuple, Protocol

import numpy as np

from nonsmooth.contact.blocks.faceted_lcp import FacetedLCP
from nonsmooth.contact.blocks.frictionless import Frictionless
from nonsmooth.contact.blocks.interior import Interior
from nonsmooth.contact.blocks.natural_map import put_on_cones_entry
from nonsmooth.contact.blocks.newton import Newton
from nonsmooth.contact.blocks.nsgs import NSGS
from nonsmooth.contact.blocks.problem import Problem
from nonsmooth.errors import InvalidInput

CHEAP_ENTRIES = 50_000  # measured: stored entries of G up to which a sparse LU takes a few milliseconds
FIRST_SWEEPS = 100  # measured: sweeps: enough for most loose assemblies, and a good start for Newton on the others
# measured: within which a first Newton must halve the error; a success rarely takes more (benchmarks/problems.py)
NEWTON_TRIAL_STEPS = 4
# chosen: distances from the boundary, for interior points: where one path fails, another ends; from OUTERMOST those of
# 14 towers of masses over six decades, of 18 that no other rung solved (of 480 problems)
NEAR, INSIDE, FAR, OUTERMOST = 0.03, 0.3, 3.0, 30.0
LAST_SWEEPS = 20_000  # measured: of 240 random problems two are ended by these, and one of the two by 10 000
POLISHED_ERROR = 1e-13  # chosen: some hundreds of roundings of the largest term
POLISH_STEPS = 4  # chosen: of Newton's method near a solution, where the modes are known
LCP_CONTACTS = 150  # measured: planar contacts: an LCP with 600 unknowns, about a second
FACET_CONTACTS = 50  # measured: spatial contacts with four facets: an LCP with 300 unknowns, a tenth of a second


class Solver(Protocol):
    """A frozen options object that improves an iterate of a scaled problem."""

    @property
    def name(self) -> str:
        """The name in ``SOLVERS``."""

    def run(self, problem: Problem, P: np.ndarray, tol: float, until: float = math.inf) -> tuple[np.ndarray, int]:
        """The best iterate found, starting from P, and the iterations it took.

        At ``until``, a moment of `time.monotonic` [s], the best iterate so far is returned.
        """


class Single(NamedTuple):
    """One contact, exactly: a Gauss-Seidel sweep is its closed form."""

    name: str = "single"

    def run(self, problem: Problem, P: np.ndarray, tol: float, until: float = math.inf) -> tuple[np.ndarray, int]:
        """Solve; P is not used."""
        if problem.n_c != 1:
            raise InvalidInput(f"solver 'single' takes one contact; got {problem.n_c}; use solver='auto'")
        return NSGS(max_sweeps=1).run(problem, np.zeros(problem.n), tol, until)


class FromFacets(NamedTuple):
    """Few contacts afresh: the complementarity problem of the coarsest faceted cone, then inside the round one."""

    name: str = "facets"

    def run(self, problem: Problem, P: np.ndarray, tol: float, until: float = math.inf) -> tuple[np.ndarray, int]:
        """The best iterate from the faceted solution; P is not used."""
        P, pivots = FacetedLCP(facets=4).run(problem, P, tol)
        rungs = [Newton(patience=NEWTON_TRIAL_STEPS), *from_inside(INSIDE, NEAR, FAR)]
        end = climb(problem, P, tol, rungs, until=until)
        return end.P, pivots + end.iterations


class Climb(NamedTuple):
    """Where a ladder ended."""

    P: np.ndarray
    solver: str
    iterations: int
    notes: list[str]


def is_cheap(problem: Problem) -> bool:
    """Whether factors of its matrix cost little."""
    return problem.blocks.is_full or problem.blocks.G.size <= CHEAP_ENTRIES


def ladder_of(problem: Problem) -> list[Solver]:
    """What `solve_contact` climbs: the rungs of `solver="auto"` for a problem."""
    if problem.n_c == 1:
        return [Single()]
    is_few = problem.n_c <= (LCP_CONTACTS if problem.dim == 2 else FACET_CONTACTS)
    rungs: list[Solver] = [
        NSGS(max_sweeps=FIRST_SWEEPS), *([Newton(patience=NEWTON_TRIAL_STEPS)] if is_cheap(problem) else []),
        *from_inside(INSIDE, NEAR, FAR, OUTERMOST), *([FromFacets()] if is_few else []), NSGS(max_sweeps=LAST_SWEEPS),
    ]  # fmt: skip
    return rungs if problem.mu.any() else [Frictionless(), *rungs]


def from_inside(*starts: float) -> list[Solver]:
    """Interior points from some distances, each with Newton's method after it for the last digits."""
    return [solver for start in starts for solver in (Interior(start=start), Newton(patience=NEWTON_TRIAL_STEPS))]


def climb(problem: Problem, P: np.ndarray, tol: float, rungs: Iterable[Solver], use_polish: bool = False,
          until: float = math.inf) -> Climb:  # fmt: skip
    """Try the solvers in turn, each from the best iterate so far; at ``until`` the climb ends where it is."""
    least, name, iterations = problem.error(P), "guess", 0
    notes: list[str] = []
    for solver in rungs:
        if notes and (least <= tol or time.monotonic() >= until):
            break
        trial, count = solver.run(problem, P, tol, until)
        error = problem.error(trial)
        iterations += count
        notes.append(f"{solver.name}: error {error:.1e} after {count}")
        if error <= least or len(notes) == 1:
            P, least, name = trial, error, solver.name
    if use_polish and POLISHED_ERROR < least <= tol and time.monotonic() < until:
        P, count = Newton(max_iterations=POLISH_STEPS).run(problem, P, POLISHED_ERROR)
        iterations += count
        notes.append(f"polish: error {problem.error(P):.1e} after {count}")
    put_on_cones_entry(problem.mu, on_cone := P.copy(), problem.dim)  # Newton leaves the cone by roundings
    if problem.error(on_cone) <= max(tol, least):
        P = on_cone
    return Climb(P, name, iterations, notes)
