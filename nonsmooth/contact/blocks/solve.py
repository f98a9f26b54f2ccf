"""The front door:  find P with  gamma = G P + c  and  K* contains gamma + mu |gamma_T| e_N  _|_  P in K.

    border checks -> scaling -> one solver by name, or the ladder of "auto" -> natural map of the problem as given

The ladder, each rung starting from the best iterate so far, until the error is within the tolerance:

    one contact                     single (closed form in the plane, a bracketed root in space)
    no friction anywhere            the linear complementarity problem of the normals first
    otherwise                       nsgs (100 sweeps), newton, then interior and newton, from three distances
    large: factors cost more        nsgs (25 sweeps), admm, nsgs while it pays, then interior and newton once
    planar, up to 150 contacts      then the linear complementarity problem, newton
    spatial, up to 50 contacts      then the one of the cone with four facets, from it interior and newton
    at last                         proximal, admm, nsgs while it pays, nsgs (20 000 sweeps), newton

then a polish where factors are cheap. "While it pays": as long as the observed rate promises to finish soon.
"""

from __future__ import annotations

import functools
from typing import Any, NamedTuple, Protocol

import numpy as np

from nonsmooth.checks.arrays import as_name, as_tolerance, as_vector
from nonsmooth.contact.blocks.admm import ADMM, project
from nonsmooth.contact.blocks.convex import Convex
from nonsmooth.contact.blocks.faceted_lcp import FacetedLCP
from nonsmooth.contact.blocks.frictionless import Frictionless
from nonsmooth.contact.blocks.interior import Interior
from nonsmooth.contact.blocks.newton import Newton
from nonsmooth.contact.blocks.nsgs import NSGS
from nonsmooth.contact.blocks.polish import polish
from nonsmooth.contact.blocks.problem import Problem, check_problem, scale_problem
from nonsmooth.contact.blocks.proximal import Proximal
from nonsmooth.contact.blocks.result import ContactResult, ContactStatus
from nonsmooth.errors import InvalidInput

CHEAP_ENTRIES = 50_000  # measured: stored entries of G up to which a sparse LU takes a few milliseconds
FIRST_SWEEPS = 100  # measured: sweeps: enough for most loose assemblies, and a good start for Newton on the others
BRIEF_SWEEPS = 25  # chosen: sweeps: a start for methods that factorise a large matrix
# measured: within which a first Newton must halve the error; a success rarely takes more (benchmarks/problems.py)
NEWTON_TRIAL_STEPS = 4
# chosen: distances from the boundary for interior points: a path that fails from one, ends from another
START_DISTANCES = (0.3, 0.03, 3.0)
LAST_SWEEPS = 20_000  # chosen: sweeps: the last resort
WORTH_WAITING = 3_000  # chosen: further sweeps that Gauss-Seidel may promise to need
LCP_CONTACTS = 150  # measured: planar contacts: an LCP with 600 unknowns, about a second
FACET_CONTACTS = 50  # measured: spatial contacts with four facets: an LCP with 300 unknowns, a tenth of a second


class Solver(Protocol):
    """A frozen options object that improves an iterate of a scaled problem."""

    @property
    def name(self) -> str:
        """The name in ``SOLVERS``."""

    def run(self, problem: Problem, P: np.ndarray, tol: float) -> tuple[np.ndarray, int]:
        """The best iterate found, starting from P, and the iterations it took."""


class Single(NamedTuple):
    """One contact, exactly: a Gauss-Seidel sweep is its closed form."""

    name: str = "single"

    def run(self, problem: Problem, P: np.ndarray, tol: float) -> tuple[np.ndarray, int]:
        """Solve; P is not used."""
        if problem.n_c != 1:
            raise InvalidInput(f"solver 'single' takes one contact; got {problem.n_c}; use solver='auto'")
        return NSGS(max_sweeps=1).run(problem, np.zeros(problem.n), tol)


class PatientNSGS(NamedTuple):
    """Gauss-Seidel in portions, for as long as the observed rate promises an end."""

    name: str = "nsgs"

    def run(self, problem: Problem, P: np.ndarray, tol: float) -> tuple[np.ndarray, int]:
        """Sweep from P; returns the best iterate and the number of sweeps."""
        total, before = 0, problem.error(P)
        while True:
            P, sweeps = NSGS(max_sweeps=2 * FIRST_SWEEPS).run(problem, P, tol)
            total, error = total + sweeps, problem.error(P)
            rate = np.log(before / error) / sweeps if 0 < error < before else 0.0
            if error <= tol or rate == 0.0 or np.log(error / tol) / rate > WORTH_WAITING:
                return P, total
            before = error


class FromFacets(NamedTuple):
    """Spatial contacts afresh: the complementarity problem of the coarsest faceted cone, then inside the round one."""

    name: str = "facets"

    def run(self, problem: Problem, P: np.ndarray, tol: float) -> tuple[np.ndarray, int]:
        """The best iterate from the faceted solution; P is not used."""
        P, pivots = FacetedLCP(facets=4).run(problem, P, tol)
        climb = _climb(problem, P, tol, _from_inside(), use_polish=False)
        return climb.P, pivots + climb.iterations


SOLVERS: dict[str, Solver] = {
    "single": Single(),
    "nsgs": NSGS(),
    "newton": Newton(),
    "interior": Interior(),
    "proximal": Proximal(),
    "admm": ADMM(),
    "lcp": FacetedLCP(),
    "frictionless": Frictionless(),
    "convex": Convex(),
}


def solve_contact(
    G: Any, c: Any, mu: Any, dim: int, solver: str = "auto", tol: float = 1e-8, guess: Any = None
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
        "auto", "single" (one contact), "nsgs", "newton", "interior", "proximal", "admm", "lcp" (exact in the plane
        only), "frictionless" (mu = 0) or "convex" (G positive semidefinite).
    tol : float
        Largest accepted natural-map error, relative to the norm of c [-].
    guess : array_like, shape (n,), optional
        Impulses to start from [N s].

    Returns
    -------
    ContactResult
        Not solved is a status, never an exception; P is then the best iterate.

    Raises
    ------
    InvalidInput
        When G is not square, sizes differ, an entry is not finite, mu < 0, dim is not 2 or 3, or tol <= 0.
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
    as_name("contact solver", solver, ("auto", *SOLVERS))
    given = check_problem(G, c, mu, dim)
    tol = as_tolerance("tol", tol)
    start = np.zeros(given.n) if guess is None else as_vector("guess", guess, given.n)
    if given.n == 0:
        return ContactResult(start, start.copy(), ContactStatus.SOLVED, 0.0, 0.0, 0, solver, "empty problem")
    problem, factor = scale_problem(given)
    if solver == "auto":
        climb = _climb(problem, start / factor, tol, _ladder(problem), use_polish=_is_cheap(problem))
    else:
        climb = _climb(problem, start / factor, tol, [SOLVERS[solver]], use_polish=False)
    return _judged(given, factor * climb.P, tol, climb)


class Climb(NamedTuple):
    """Where a ladder ended."""

    P: np.ndarray
    solver: str
    iterations: int
    notes: list[str]


def _is_cheap(problem: Problem) -> bool:
    return problem.blocks.is_full or problem.blocks.G.size <= CHEAP_ENTRIES


def _ladder(problem: Problem) -> list[Solver]:
    if problem.n_c == 1:
        return [Single()]
    has_lcp = problem.n_c <= (LCP_CONTACTS if problem.dim == 2 else FACET_CONTACTS)
    rungs = _rungs(problem.dim, has_lcp, _is_cheap(problem))
    return rungs if problem.mu.any() else [Frictionless(), *rungs]


@functools.cache
def _rungs(dim: int, has_lcp: bool, is_cheap: bool) -> list[Solver]:
    last: list[Solver] = [PatientNSGS(), NSGS(max_sweeps=LAST_SWEEPS), Newton()]
    last = [Proximal(alpha=1e-4, max_solves=200), ADMM(max_iterations=1000), Proximal(), *last]
    if has_lcp:
        last = [FacetedLCP(), Newton(), *last] if dim == 2 else [FromFacets(), *last]
    if is_cheap:
        return [NSGS(max_sweeps=FIRST_SWEEPS), Newton(patience=NEWTON_TRIAL_STEPS), *_from_inside(), *last]
    first: list[Solver] = [NSGS(max_sweeps=BRIEF_SWEEPS), ADMM(max_iterations=300), PatientNSGS()]
    return [*first, Interior(), Newton(patience=NEWTON_TRIAL_STEPS), *last]


def _from_inside() -> list[Solver]:
    rungs: list[Solver] = []
    for start in START_DISTANCES:
        rungs += [Interior(start=start), Newton(patience=NEWTON_TRIAL_STEPS)]
    return rungs


def _climb(problem: Problem, P: np.ndarray, tol: float, ladder: list[Solver], use_polish: bool) -> Climb:
    """Try the solvers in turn, each from the best iterate so far."""
    least, name, iterations = problem.error(P), "guess", 0
    notes: list[str] = []
    for solver in ladder:
        if least <= tol and notes:
            break
        trial, count = solver.run(problem, P, tol)
        error = problem.error(trial)
        iterations += count
        notes.append(f"{solver.name}: error {error:.1e} after {count}")
        if error <= least or len(notes) == 1:
            P, least, name = trial, error, solver.name
    if use_polish and 1e-13 < least <= tol:
        P, count = polish(problem, P)
        iterations += count
        notes.append(f"polish: error {problem.error(P):.1e} after {count}")
    project(problem.mu, problem.dim, on_cone := P.copy())  # Newton leaves the cone by roundings
    if problem.error(on_cone) <= max(tol, least):
        P = on_cone
    return Climb(P, name, iterations, notes)


def _judged(given: Problem, P: np.ndarray, tol: float, climb: Climb) -> ContactResult:
    error = given.error(P)
    if error <= tol:
        status = ContactStatus.SOLVED
    elif climb.solver == "single" and given.dim == 2:
        status = ContactStatus.NO_SOLUTION
    else:
        status = ContactStatus.STALLED if len(climb.notes) > 1 else ContactStatus.MAX_ITERATIONS
    error_rho_1 = given.with_error_of(np.ones(given.n_c)).error(P)
    message = f"{status.name.lower().replace('_', ' ')}; " + "; ".join(climb.notes)
    return ContactResult(P, given.velocity(P), status, error, error_rho_1, climb.iterations, climb.solver, message)
