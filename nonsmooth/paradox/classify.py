"""How many forces fit a state: the classification of Painlevé's paradoxes.

    0 solutions  INCONSISTENT    no force can go with the state: an impact without collision must occur
    1            REGULAR
    2 or more    INDETERMINATE   rigid-body theory does not decide

for the acceleration-level problem gamma' = G la + b of ``paradox.forces``. Source: Painlevé, *C. R. Acad. Sci. Paris*
121 (1895) 112; Génot, Brogliato, *Eur. J. Mech. A/Solids* 18 (1999) 653; Champneys, Várkonyi, *IMA J. Appl. Math.* 81
(2016) 538.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum, IntFlag
from typing import Any

import numpy as np

from nonsmooth.arrays import as_fraction, as_number, as_vector
from nonsmooth.contact_solvers.single import FREE, SLIDE_PLUS, STICK, sigma_of, slip_of
from nonsmooth.jit import interpreted
from nonsmooth.laws import LAW_E_N
from nonsmooth.paradox.alternatives import ImpactAlternative, impacts_without_collision, sticking_impulse
from nonsmooth.paradox.certificate import is_always_regular, solve_sliding
from nonsmooth.paradox.chatter import chatter_ratio
from nonsmooth.paradox.forces import Outcome
from nonsmooth.paradox.stability import (
    Stability,
    StabilityTag,
    effective_matrix,
    force_columns,
    is_regular,
    stability_of,
)
from nonsmooth.paradox.state_problem import Problem, problem_at
from nonsmooth.system import BILATERAL, GIVEN_FORCE, UNILATERAL, as_system

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
    n_solutions : int
    is_complete : bool
        Whether no solution can be missing.
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
        Impacts without collision that the state admits.
    chatter_ratio : ndarray (n_c,)
        Growth of the bounces of a contact at rest, from one to the next: above 1 they grow; nan where there are none.
    is_bilateral : ndarray (n_c,) of bool
        Whether the normal force may have either sign.
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

    def __str__(self) -> str:
        from nonsmooth.output.classification import as_text

        return as_text(self)

    def __repr__(self) -> str:
        return f"Classification({self.kind.name}, n_solutions={self.n_solutions}, is_complete={self.is_complete})"

    def to_dict(self) -> dict[str, Any]:
        """Plain lists, numbers and strings, as for JSON (which knows no nan: see ``json.dumps(allow_nan=)``)."""
        from nonsmooth.output.classification import as_dictionary

        return as_dictionary(self)


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
    Complete as far as the modes can be enumerated: 8 planar contacts at rest, 18 that slide; beyond, where a
    P-matrix says that there is one solution.
    Source: docs/theory/painleve.md.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> from models import PainleveRod
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
    is_always = is_always_regular(problem)
    solutions, is_complete = all_solutions(problem, bool(is_always))
    n_solutions = len(solutions) if is_complete else max(problem.found, len(solutions))
    a, b, p, k = coefficients(problem)
    restitutions = system.laws[:, LAW_E_N] if e is None else np.full(system.n_c, e)
    impacts = impacts_without_collision(problem, restitutions)
    chatter = chatter_ratios(problem, restitutions)
    kind = kind_of(n_solutions, is_complete)
    return Classification(
        t, q, u, kind, solutions, n_solutions, is_complete,
        flags_of(problem, kind, solutions, impacts, chatter, tolerance), mode_names(problem),
        problem.gamma[:, 0].copy(), problem.gamma[:, 1].copy(), problem.mu_of_contacts(),
        a, b, p, k, is_always, impacts or (), chatter, system.kinds[:, 0] == BILATERAL,
    )  # fmt: skip


def kind_of(n_solutions: int, is_complete: bool) -> ParadoxKind:
    """The kind by the number of solutions; two of them are several, whether or not others are missing."""
    if n_solutions >= 2:
        return ParadoxKind.INDETERMINATE
    if not is_complete:
        return ParadoxKind.NOT_ENUMERATED
    return ParadoxKind(n_solutions)


def all_solutions(problem: Problem, is_always: bool) -> tuple[tuple[ForceSolution, ...], bool]:
    """The solutions, and whether none can be missing; ``is_always`` says that there is exactly one."""
    if len(problem.closed) == 0:
        return (force_solution(problem, np.zeros(0, int), np.zeros(0)),), True
    if problem.outcome == Outcome.TOO_MANY:
        one = solve_sliding(problem)
        return (() if one is None else (force_solution(problem, *one),)), is_always and one is not None
    solutions = tuple(
        force_solution(problem, candidate, la) for candidate, la in zip(problem.candidate, problem.la, strict=True)
    )
    return solutions, problem.outcome == Outcome.COMPLETE and problem.found == len(solutions)


def force_solution(problem: Problem, candidate: np.ndarray, la: np.ndarray) -> ForceSolution:
    """One solution in the terms of the system: ``candidate`` (n,) and ``la`` (r,) of the closed contacts."""
    modes = [OPEN_NAME] * problem.system.n_c
    for k, i in enumerate(problem.closed):
        is_locked = problem.d(k) == 0 and candidate[k] == STICK
        modes[i] = LOCKED_NAME if is_locked else MODE_NAMES[candidate[k]]
    la_N, la_F = problem.spread(la, 0.0)
    for k, i in enumerate(problem.closed):
        if problem.kind(k) == GIVEN_FORCE:
            la_N[i] = problem.normal[k]
    dgamma_N, dgamma_F = problem.spread(problem.rates(problem.c, la), np.nan)
    tag, is_unique = judge_modes(problem, candidate)
    return ForceSolution(tuple(modes), la_N, la_F, problem.du + problem.X.T @ la, dgamma_N, dgamma_F, tag, is_unique)


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


def chatter_ratios(problem: Problem, restitution: np.ndarray) -> np.ndarray:
    """Growth of the bounces of the only closed contact, where it rests; nan elsewhere."""
    ratios = np.full(problem.system.n_c, np.nan)
    if len(problem.closed) == 1 and problem.kind(0) == UNILATERAL and problem.d(0) > 0 and problem.slip[0] == 0:
        i = problem.closed[0]
        b, a = problem.c
        if sticking_impulse(problem.G, 1.0) is not None:
            ratios[i] = chatter_ratio(restitution[i], problem.mu[0], problem.G, a, b)
    return ratios


def flags_of(problem: Problem, kind: ParadoxKind, solutions: tuple[ForceSolution, ...], impacts: tuple | None,
             chatter: np.ndarray, tolerance: float) -> ParadoxFlag:  # fmt: skip
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
    if (chatter > 1.0 + tolerance).any() and any("stick" in solution.modes for solution in solutions):
        flags |= ParadoxFlag.REVERSE_CHATTER
    if any(solution.stability.kind == Stability.FLUTTER for solution in solutions):
        flags |= ParadoxFlag.CONTACT_FLUTTER
    if kind == ParadoxKind.INCONSISTENT and impacts == ():
        flags |= ParadoxFlag.JAMMED
    return flags


def mode_names(problem: Problem) -> tuple[str, ...]:
    """What each contact does."""
    names = ["open"] * problem.system.n_c
    for k, i in enumerate(problem.closed):
        names[i] = "resting" if problem.slip[k] == 0 else f"sliding {'+' if problem.slip[k] > 0 else '-'}"
    return tuple(names)
