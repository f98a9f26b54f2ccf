"""What the forces of a state are judged by: stability, impacts without collision, flags, coefficients; each apart.

Contacts that G does not couple are islands: each is decided for itself, and a solution of all is one of each.
"""

from __future__ import annotations

import functools
import itertools
import math
from typing import NamedTuple

import numpy as np

from nonsmooth.contact.planar.forces import FORCES_KEPT, Outcome
from nonsmooth.contact.planar.single import FREE, SLIDE_PLUS, STICK, sigma_of, slip_of
from nonsmooth.jit import interpreted
from nonsmooth.mechanics.laws import LAW_E_N
from nonsmooth.mechanics.system import BILATERAL, GIVEN_FORCE, UNILATERAL
from nonsmooth.paradox.alternatives import (
    Impact,
    ImpactAlternative,
    impacts_without_collision,
    outcome_of,
    sticking_impulse,
)
from nonsmooth.paradox.certificate import is_always_regular, solve_sliding
from nonsmooth.paradox.chatter import chatter_ratio
from nonsmooth.paradox.kinds import ContactIsland, ForceSolution, ParadoxFlag, ParadoxKind, kind_of
from nonsmooth.paradox.stability import (
    Stability,
    StabilityTag,
    effective_matrix,
    force_columns,
    is_regular,
    stability_of,
)
from nonsmooth.paradox.state_problem import Found, Problem

MODE_NAMES = ("free", "stick", "slide +", "slide -", "slide +", "slide -")
LOCKED_NAME = "closed"
OPEN_NAME = "open"

slip_sign, sigma_sign = interpreted(slip_of), interpreted(sigma_of)


class Judgement:
    """What was found at a state, and what follows from it once it is asked for.

    Parameters
    ----------
    found : Found
    restitution : float or None
        Of the impacts; None: each contact's own.
    """

    def __init__(self, found: Found, restitution: float | None) -> None:
        self.found, self.restitution = found, restitution

    @functools.cached_property
    def problem(self) -> Problem:
        """The problem as plain arrays."""
        return self.found.problem()

    @functools.cached_property
    def parts(self) -> list[Part]:
        """What is decided of each island."""
        system, e = self.found.system, self.restitution
        restitutions = system.laws[:, LAW_E_N] if e is None else np.full(system.n_c, e)
        return [decide(self.problem, island, restitutions) for island in range(len(self.problem.counts))]

    @functools.cached_property
    def islands(self) -> tuple[ContactIsland, ...]:
        """The groups of closed contacts that are decided apart."""
        return tuple(part.island for part in self.parts)

    def count(self) -> tuple[int, bool]:
        """The number of solutions of all islands, and whether none can be missing."""
        if self.found.is_listed:
            return self.found.total, True
        islands = self.islands
        n_solutions = math.prod(island.n_solutions for island in islands)
        is_listed = all(island.is_complete for island in islands) and n_solutions <= FORCES_KEPT
        return n_solutions, is_listed or any(island.is_complete and island.n_solutions == 0 for island in islands)

    def impacts(self) -> tuple[ImpactAlternative, ...]:
        """The impacts without collision of every island."""
        return tuple(
            outcome_of(self.problem, self.problem.rows(self.problem.members(j)), impact)
            for j, part in enumerate(self.parts)
            for impact in part.impacts or ()
        )

    def chatter_ratios(self) -> np.ndarray:
        """Growth of the bounces of each contact (n_c,)."""
        chatter = np.full(self.found.system.n_c, np.nan)
        for part in self.parts:
            chatter[list(part.island.contacts)] = part.chatter
        return chatter


class Part(NamedTuple):
    """What is decided of one island."""

    island: ContactIsland
    solutions: list[PartSolution]
    is_always: bool | None
    impacts: tuple[Impact, ...] | None
    chatter: float  # of the only contact of an island


class PartSolution(NamedTuple):
    """Modes (n,) and forces (r,) of one solution of an island, and how it is judged."""

    candidate: np.ndarray
    la: np.ndarray
    stability: StabilityTag
    is_unique: bool


def decide(problem: Problem, island: int, restitutions: np.ndarray) -> Part:
    """Everything that one island is judged by."""
    part = problem.part(island)
    is_always = is_always_regular(part)
    solutions, is_complete = solutions_of(part, bool(is_always))
    number = len(solutions) if is_complete else max(int(part.counts[0]), len(solutions))
    contacts = tuple(int(i) for i in part.closed)
    return Part(
        ContactIsland(contacts, kind_of(number, is_complete), number, is_complete),
        [PartSolution(*solution, *judge_modes(part, solution[0])) for solution in solutions], is_always,
        impacts_without_collision(part, restitutions), chatter_of(part, restitutions),
    )  # fmt: skip


def all_or_unknown(known: list[bool | None]) -> bool | None:
    """Whether all are true; None where one is not known, or where there are none."""
    return None if not known or any(one is None for one in known) else all(known)


def solutions_of(part: Problem, is_always: bool) -> tuple[list[tuple[np.ndarray, np.ndarray]], bool]:
    """Modes and forces of the solutions of an island, and whether none can be missing; ``is_always`` says that there is
    exactly one."""
    if part.outcomes[0] == Outcome.TOO_MANY:
        one = solve_sliding(part)
        return [] if one is None else [one], is_always and one is not None
    solutions = list(zip(part.candidate, part.la, strict=True))
    return solutions, bool(part.outcomes[0] == Outcome.COMPLETE and part.counts[0] == len(solutions))


def all_solutions(problem: Problem, parts: list[Part]) -> tuple[ForceSolution, ...]:
    """The first products of a solution of each island; the motion without forces where no contact is closed."""
    products = itertools.product(*(part.solutions for part in reversed(parts)))
    return tuple(force_solution(problem, chosen[::-1]) for chosen in itertools.islice(products, FORCES_KEPT))


def force_solution(problem: Problem, chosen: tuple[PartSolution, ...]) -> ForceSolution:
    """One solution in the terms of the system, of one of each island."""
    candidate, la = np.zeros(len(problem.closed), int), np.zeros(len(problem.c))
    for island, solution in enumerate(chosen):
        members = problem.members(island)
        candidate[members], la[problem.rows(members)] = solution.candidate, solution.la
    modes = [OPEN_NAME] * problem.system.n_c
    for k, i in enumerate(problem.closed):
        is_locked = problem.d(k) == 0 and candidate[k] == STICK
        modes[i] = LOCKED_NAME if is_locked else MODE_NAMES[candidate[k]]
    la_N, la_F = problem.spread(la, 0.0)
    for k, i in enumerate(problem.closed):
        if problem.kind(k) == GIVEN_FORCE:
            la_N[i] = problem.normal[k]
    dgamma_N, dgamma_F = problem.spread(problem.rates(problem.c, la), np.nan)
    return ForceSolution(
        tuple(modes), la_N, la_F, problem.du + problem.X.T @ la, dgamma_N, dgamma_F,
        together([solution.stability for solution in chosen]), all(solution.is_unique for solution in chosen),
    )  # fmt: skip


def together(tags: list[StabilityTag]) -> StabilityTag:
    """The stability of islands side by side: that of the worst, with all eigenvalues."""
    rho = np.concatenate([np.zeros(0, complex), *(tag.rho for tag in tags)])
    kind = max((tag.kind for tag in tags), default=Stability.STABLE)
    return StabilityTag(kind, max((tag.damping for tag in tags), default=0.0), rho)


def judge_modes(problem: Problem, candidate: np.ndarray) -> tuple[StabilityTag, bool]:
    """The stability of modes under stiff contacts, and whether their equations determine the forces."""
    rows: list[int] = []  # closed normal rows, each a spring of the stiff contact
    slides: list[int] = []  # their rows of sliding friction, -1 without
    ratio: list[float] = []  # la_F/la_N there
    sticks: list[int] = []
    for k, mode in enumerate(candidate):
        T = problem.start[k + 1] - 1
        is_slide = mode >= SLIDE_PLUS
        if mode == FREE:
            continue
        if not is_slide and problem.d(k) > 0:
            sticks.append(T)
        if problem.kind(k) != GIVEN_FORCE:
            rows.append(problem.start[k])
            slides.append(T if is_slide else -1)
            ratio.append(-slip_sign(mode) * sigma_sign(mode) * problem.mu[k] if is_slide else 0.0)
    normal, stuck = np.array(rows, int), np.array(sticks, int)
    columns = force_columns(problem.G, normal, np.array(slides, int), np.array(ratio, float))
    return stability_of(effective_matrix(problem.G, columns, normal, stuck)), is_regular(
        problem.G, columns, normal, stuck
    )


def free_accelerations(problem: Problem) -> tuple[np.ndarray, np.ndarray]:
    """b (n_c,), a (n_c,); nan where a contact is open or has no such row."""
    return problem.spread(problem.c, np.nan)


def slopes(problem: Problem) -> tuple[np.ndarray, np.ndarray]:
    """p (n_c, 2), k (n_c, 2); nan where a contact is open or has no such row."""
    n_c = problem.system.n_c
    p, slope = np.full((n_c, 2), np.nan), np.full((n_c, 2), np.nan)
    for k, i in enumerate(problem.closed):
        if problem.kind(k) == GIVEN_FORCE:
            continue
        N, T = problem.start[k], problem.start[k + 1] - 1
        p[i] = problem.G[N, N]
        if problem.d(k) > 0:
            signs = np.array([1.0, -1.0]) * problem.mu[k]
            p[i] -= signs * problem.G[N, T]
            slope[i] = problem.G[N, T] - signs * problem.G[T, T]
    return p, slope


def chatter_of(part: Problem, restitution: np.ndarray) -> float:
    """Growth of the bounces of the only contact of an island, where it rests; nan elsewhere."""
    if len(part.closed) == 1 and part.kind(0) == UNILATERAL and part.d(0) > 0 and part.slip[0] == 0:
        b, a = part.c
        if sticking_impulse(part.G, 1.0) is not None:
            return chatter_ratio(restitution[part.closed[0]], part.mu[0], part.G, a, b)
    return math.nan


def flags_of(problem: Problem, parts: list[Part], tolerance: float) -> ParadoxFlag:
    """The flags of a state."""
    flags = ParadoxFlag(0)
    for k in range(len(problem.closed)):
        if problem.kind(k) == GIVEN_FORCE or problem.d(k) == 0:
            continue
        N, T = problem.start[k], problem.start[k + 1] - 1
        G_NN, tilt = problem.G[N, N], problem.mu[k] * problem.G[N, T]
        s = problem.slip[k]
        # p of the present slip; of either sign where la_N or the slip may have either
        either = s == 0 or problem.kind(k) == BILATERAL
        p = G_NN - abs(tilt) if either else G_NN - s * tilt
        is_p_zero = abs(p) <= tolerance * (G_NN + abs(tilt))
        is_b_zero = abs(problem.c[N]) <= tolerance * problem.c_scale[N]
        flags |= ParadoxFlag.P_ZERO if is_p_zero else ParadoxFlag(0)
        flags |= ParadoxFlag.B_ZERO if is_b_zero else ParadoxFlag(0)
        flags |= ParadoxFlag.GENOT_BROGLIATO if is_p_zero and is_b_zero else ParadoxFlag(0)
    for part in parts:
        sticks = any((solution.candidate == STICK).any() for solution in part.solutions)
        if part.chatter > 1.0 + tolerance and sticks:
            flags |= ParadoxFlag.REVERSE_CHATTER
        if any(solution.stability.kind == Stability.FLUTTER for solution in part.solutions):
            flags |= ParadoxFlag.CONTACT_FLUTTER
        if part.island.kind == ParadoxKind.INCONSISTENT and part.impacts == ():
            flags |= ParadoxFlag.JAMMED
    return flags


def mode_names(problem: Problem) -> tuple[str, ...]:
    """What each contact does."""
    names = ["open"] * problem.system.n_c
    for k, i in enumerate(problem.closed):
        names[i] = "resting" if problem.slip[k] == 0 else f"sliding {'+' if problem.slip[k] > 0 else '-'}"
    return tuple(names)
