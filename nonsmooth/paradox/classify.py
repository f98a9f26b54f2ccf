"""How many forces fit a state: the classification of Painlevé's paradoxes.

    0 solutions  INCONSISTENT    no force can go with the state: an impact without collision must occur
    1            REGULAR
    2 or more    INDETERMINATE   rigid-body theory does not decide

for the acceleration-level problem gamma' = G la + b of ``paradox.forces``. Contacts that G does not couple are islands:
each is decided for itself, and a solution of all is one of each. Source: Painlevé, *C. R. Acad. Sci. Paris*
121 (1895) 112; Génot, Brogliato, *Eur. J. Mech. A/Solids* 18 (1999) 653; Champneys, Várkonyi, *IMA J. Appl. Math.* 81
(2016) 538.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from enum import IntEnum, IntFlag
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.checks.arrays import as_fraction, as_number, as_vector
from nonsmooth.contact.planar.forces import FORCES_KEPT, Outcome
from nonsmooth.contact.planar.single import FREE, SLIDE_PLUS, STICK, sigma_of, slip_of
from nonsmooth.jit import interpreted
from nonsmooth.mechanics.laws import LAW_E_N
from nonsmooth.mechanics.system import BILATERAL, GIVEN_FORCE, UNILATERAL, as_system
from nonsmooth.paradox.alternatives import (
    Impact,
    ImpactAlternative,
    impacts_without_collision,
    outcome_of,
    sticking_impulse,
)
from nonsmooth.paradox.certificate import is_always_regular, solve_sliding
from nonsmooth.paradox.chatter import chatter_ratio
from nonsmooth.paradox.stability import (
    Stability,
    StabilityTag,
    effective_matrix,
    force_columns,
    is_regular,
    stability_of,
)
from nonsmooth.paradox.state_problem import Problem, problem_at
from nonsmooth.views import view

MODE_NAMES = ("free", "stick", "slide +", "slide -", "slide +", "slide -")
LOCKED_NAME = "closed"
OPEN_NAME = "open"

slip_sign, sigma_sign = interpreted(slip_of), interpreted(sigma_of)


class ParadoxKind(IntEnum):
    """What the number of solutions says."""

    INCONSISTENT = 0  # none
    REGULAR = 1  # one
    INDETERMINATE = 2  # several
    NOT_ENUMERATED = 3  # more contacts than are enumerated
    INADMISSIBLE = 4  # (maps only) the state penetrates or lands: there is no acceleration-level problem
    NOT_REACHED = 5  # (maps only) Ctrl-C came before


class ParadoxFlag(IntFlag):
    """Facts about a state beside the number of its solutions."""

    P_ZERO = 1  # p = 0 for the present slip (at rest: for either), within the tolerance
    B_ZERO = 2  # b = 0
    GENOT_BROGLIATO = 4  # p = b = 0
    REVERSE_CHATTER = 8  # bounces that grow out of a contact at rest coexist with sticking
    CONTACT_FLUTTER = 16  # a solution that a stiff contact leaves unless it is damped enough
    JAMMED = 32  # no forces, and no impact either: self-locking


@dataclass(frozen=True, eq=False)
class ForceSolution:
    """One set of contact forces that fits the state.

    Attributes
    ----------
    modes : tuple of str
        Mode of each contact: "free", "stick", "slide +", "slide -", "closed" (no friction), "open".
    la_N, la_F : ndarray (n_c,)
        Contact forces [N].
    du : ndarray (n_u,)
        Accelerations u'.
    dgamma_N, dgamma_F : ndarray (n_c,)
        Accelerations of the closed contacts [m/s^2]; nan for open ones.
    stability : StabilityTag
        Whether a stiff contact stays in this mode.
    is_unique_force : bool
        False where redundant contacts leave the forces of this motion undetermined; these are then one choice.
    """

    modes: tuple[str, ...]
    la_N: np.ndarray
    la_F: np.ndarray
    du: np.ndarray
    dgamma_N: np.ndarray
    dgamma_F: np.ndarray
    stability: StabilityTag
    is_unique_force: bool = True


@dataclass(frozen=True)
class ContactIsland:
    """Closed contacts that the Delassus matrix couples with one another, and with no others.

    Attributes
    ----------
    contacts : tuple of int
    kind : ParadoxKind
    n_solutions : int
        Sets of forces of these contacts that fit the state.
    is_complete : bool
        Whether no solution can be missing.
    """

    contacts: tuple[int, ...]
    kind: ParadoxKind
    n_solutions: int
    is_complete: bool


@dataclass(frozen=True, eq=False)
class Classification:
    """Every solution of the contact problem at a state, and what it means. ``print`` it to read it.

    Attributes
    ----------
    t, q, u
        The state.
    kind : ParadoxKind
        INCONSISTENT, REGULAR, INDETERMINATE, or NOT_ENUMERATED where ``is_complete`` is False.
    solutions : tuple of ForceSolution
        Each is one solution of every island; the first 256 of these products.
    n_solutions : int
        The product of the numbers of the islands.
    is_complete : bool
        Whether no solution can be missing: every island is complete and all products are listed, or an island surely
        has none.
    flags : ParadoxFlag
    mode : tuple of str
        What each contact does: "open", "resting", "sliding +", "sliding -".
    gamma_N, gamma_F : ndarray (n_c,)
        Contact velocities [m/s].
    mu : ndarray (n_c,)
        Friction coefficient at the present speed.
    a, b : ndarray (n_c,)
        Free tangential and normal accelerations [m/s^2]; nan where the contact is open.
    p, k : ndarray (n_c, 2)
        p_s = G_NN - s mu G_NF and k_s = G_NF - s mu G_FF [1/kg] for s = +1 and s = -1: gamma_N' = p la_N + b and
        gamma_F' = k la_N + a of a contact that slides alone. For la_N < 0 (bilateral) exchange the columns.
    is_always_regular : bool or None
        Where all closed contacts slide: whether there is one solution for every load (a P-matrix); None where it is not
        known.
    impacts : tuple of ImpactAlternative
        Impacts without collision that the state admits, each of one island.
    chatter_ratio : ndarray (n_c,)
        Growth of the bounces of a contact at rest that no other is coupled to, from one to the next: above 1 they
        grow; nan where there are none.
    is_bilateral : ndarray (n_c,) of bool
        Whether the normal force may have either sign.
    islands : tuple of ContactIsland
        The groups of closed contacts that are decided apart.
    """

    t: float
    q: np.ndarray
    u: np.ndarray
    kind: ParadoxKind
    solutions: tuple[ForceSolution, ...]
    n_solutions: int
    is_complete: bool
    flags: ParadoxFlag
    mode: tuple[str, ...]
    gamma_N: np.ndarray
    gamma_F: np.ndarray
    mu: np.ndarray
    a: np.ndarray
    b: np.ndarray
    p: np.ndarray
    k: np.ndarray
    is_always_regular: bool | None
    impacts: tuple[ImpactAlternative, ...]
    chatter_ratio: np.ndarray
    is_bilateral: np.ndarray
    islands: tuple[ContactIsland, ...] = ()

    def __str__(self) -> str:
        return view(self, "text")(self)

    def _repr_html_(self) -> str:
        return view(self, "html")(str(self))

    def __repr__(self) -> str:
        return f"Classification({self.kind.name}, n_solutions={self.n_solutions}, is_complete={self.is_complete})"

    def to_dict(self) -> dict[str, Any]:
        """Plain lists, numbers and strings, as for JSON (which knows no nan: see ``json.dumps(allow_nan=)``)."""
        return view(self, "dictionary")(self)


def classify(system: Any, t: float, q: Any, u: Any, *, restitution: float | None = None,
             tolerance: float = 1e-9) -> Classification:  # fmt: skip
    """Find every solution of the contact problem at a state, and classify it.

    Parameters
    ----------
    system : System or model
    t : float
        Time [s].
    q, u : array-like (n_q,), (n_u,)
        The state. Contacts with g_N = 0 and gamma_N = 0 take part, and all bilateral ones.
    restitution : float, optional
        Coefficient e of the impacts listed; each contact's own e_N when left out.
    tolerance : float
        p and b count as zero below this part of the terms they are sums of.

    Returns
    -------
    Classification

    Raises
    ------
    InvalidInput
        Where a contact penetrates, approaches or violates its constraint: an impact comes first, and there is no
        problem of forces.

    Notes
    -----
    Complete as far as the modes can be enumerated: 8 planar contacts of one island at rest, 18 that slide; beyond,
    where a P-matrix says that there is one solution.
    Source: docs/theory/painleve.md.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> from nonsmooth.catalogue import PainleveRod
    >>> rod = PainleveRod(mu=2.0)
    >>> ns.classify(rod, 0.0, *rod.state(thdot=0.0))
    Classification(INCONSISTENT, n_solutions=0, is_complete=True)
    >>> c = ns.classify(rod, 0.0, *rod.state(thdot=6.0))
    >>> [(solution.modes, round(float(solution.la_N[0]), 6)) for solution in c.solutions]
    [(('free',), 0.0), (('slide -',), 6.813606)]
    """
    system = as_system(system)
    t = as_number("t", t, "s")
    q, u = as_vector("q", q, system.n_q), as_vector("u", u, system.n_u)
    tolerance = as_fraction("tolerance", tolerance)
    e = None if restitution is None else as_fraction("restitution", restitution)
    problem = problem_at(system, t, q, u)
    restitutions = system.laws[:, LAW_E_N] if e is None else np.full(system.n_c, e)
    parts = [decide(problem, island, restitutions) for island in range(len(problem.counts))]
    islands = tuple(part.island for part in parts)
    solutions = all_solutions(problem, parts)
    n_solutions = math.prod(island.n_solutions for island in islands)
    is_listed = all(island.is_complete for island in islands) and len(solutions) == n_solutions
    has_none = any(island.is_complete and island.n_solutions == 0 for island in islands)
    is_complete = is_listed or has_none
    a, b, p, k = coefficients(problem)
    chatter = np.full(system.n_c, np.nan)
    for part in parts:
        chatter[list(part.island.contacts)] = part.chatter
    impacts = tuple(
        outcome_of(problem, problem.rows(problem.members(j)), impact)
        for j, part in enumerate(parts)
        for impact in part.impacts or ()
    )
    return Classification(
        t, q, u, kind_of(n_solutions, is_complete), solutions, n_solutions, is_complete,
        flags_of(problem, parts, tolerance), mode_names(problem),
        problem.gamma[:, 0].copy(), problem.gamma[:, 1].copy(), problem.mu_of_contacts(),
        a, b, p, k, all_or_unknown([part.is_always for part in parts]), impacts, chatter,
        system.kinds[:, 0] == BILATERAL, islands,
    )  # fmt: skip


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


def kind_of(n_solutions: int, is_complete: bool) -> ParadoxKind:
    """The kind by the number of solutions; two of them are several, whether or not others are missing."""
    if n_solutions >= 2:
        return ParadoxKind.INDETERMINATE
    if not is_complete:
        return ParadoxKind.NOT_ENUMERATED
    return ParadoxKind(n_solutions)


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


def coefficients(problem: Problem) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """a (n_c,), b (n_c,), p (n_c, 2), k (n_c, 2); nan where a contact is open or has no such row."""
    n_c = problem.system.n_c
    p, slope = np.full((n_c, 2), np.nan), np.full((n_c, 2), np.nan)
    b, a = problem.spread(problem.c, np.nan)
    for k, i in enumerate(problem.closed):
        if problem.kind(k) == GIVEN_FORCE:
            continue
        N, T = problem.start[k], problem.start[k + 1] - 1
        p[i] = problem.G[N, N]
        if problem.d(k) > 0:
            signs = np.array([1.0, -1.0]) * problem.mu[k]
            p[i] -= signs * problem.G[N, T]
            slope[i] = problem.G[N, T] - signs * problem.G[T, T]
    return a, b, p, slope


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
