"""What is known of the forces of a state with friction in two directions.

    gamma' = G la + c    at a state,    0 <= la_N,    |la_T| <= mu la_N

A contact that slides along d carries la_T = -mu la_N d, so that with p = G_NN - mu G_NT d and b = c_N

    0 <= la_N  _|_  p la_N + b >= 0        p < 0 and b < 0: none;  p < 0 and b > 0: it lifts off, or slides

The search is that of contact/spatial/forces.py: contacts that are coupled and all slide (or have no friction) are one
complementarity problem of their la_N; one that rests by itself has free, stick and the roots of a quartic, whose number
is exact (contact/spatial/exact_count.py), and so has one that rests among others that slide, for each set of these. Of
coupled contacts of which several rest the complete answer is not known, and none is given. Contacts that G does not
couple are decided apart.
Source: Génot, Brogliato, *Eur. J. Mech. A/Solids* 18 (1999) 653; Champneys, Várkonyi, *IMA J. Appl. Math.* 81 (2016)
538.
"""

from __future__ import annotations

import functools
import itertools
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.contact.planar.forces import Outcome
from nonsmooth.contact.planar.single import FREE, STICK
from nonsmooth.contact.spatial.all_solutions import SLIDE, OneContact, list_of_one
from nonsmooth.contact.spatial.contact_solutions import are_all_slides
from nonsmooth.jit.blocks import new
from nonsmooth.mechanics.laws import LAW_E_N
from nonsmooth.mechanics.situation import Situation
from nonsmooth.mechanics.system import GIVEN_FORCE, System
from nonsmooth.paradox.alternatives import ImpactAlternative, impacts_in_space
from nonsmooth.paradox.kinds import ParadoxFlag, ParadoxKind, kind_of
from nonsmooth.paradox.stability import StabilityTag
from nonsmooth.paradox.stability_in_space import stability_in_space
from nonsmooth.paradox.state_problem import Problem, forces_found
from nonsmooth.views import view

MOST_LISTED = 256  # chosen: solutions of all islands that are listed
MODES = {Situation.OPEN: "open", Situation.RESTING: "resting", Situation.SLIDING: "sliding"}


class SpatialSolution(NamedTuple):
    """One set of contact forces that fits the state.

    Attributes
    ----------
    modes : tuple of str
        Of each contact: "open", "free", "stick", "slide", "closed" (no friction).
    la : ndarray (n_c, 3)
        Forces N, T1, T2 [N].
    du : ndarray (n_u,)
        Accelerations u'.
    stability : StabilityTag
        Whether a stiff contact stays in this mode; a slide that begins at rest also in its direction.
    """

    modes: tuple[str, ...]
    la: np.ndarray
    du: np.ndarray
    stability: StabilityTag


@dataclass(frozen=True, eq=False)
class SpatialClassification:
    """What is known of a state with friction in two directions. ``print`` it to read it.

    Attributes
    ----------
    t, q, u
        The state.
    kind : ParadoxKind
        INCONSISTENT, REGULAR, INDETERMINATE; NOT_ENUMERATED where coupled contacts of which some rest are not decided.
    n_solutions : int
        Sets of forces: the product of those of the groups of contacts that G does not couple.
    is_complete : bool
        Whether no solution can be missing.
    solutions : tuple of SpatialSolution
        The first 256 of them.
    flags : ParadoxFlag
        PAINLEVE where p <= 0 for the present slip, at rest for some direction; P_ZERO, B_ZERO, GENOT_BROGLIATO.
    mode : tuple of str
        What each contact does: "open", "resting", "sliding", "closed" (no friction).
    gamma_N : ndarray (n_c,), gamma_F : ndarray (n_c, 2)
        Contact velocities [m/s].
    direction : ndarray (n_c, 2)
        Unit vector of sliding; nan where the contact does not slide.
    mu : ndarray (n_c,)
        Friction coefficient at the present speed; nan where the contact is open.
    b : ndarray (n_c,)
        Free normal acceleration [m/s^2]; nan where the contact is open.
    p : ndarray (n_c,)
        G_NN - mu G_NT d [1/kg] of a contact that slides along d alone; at rest G_NN - mu |G_NT|, the least of all
        directions; nan where it is open.
    contacts : tuple of str
        What the contacts are called.
    impacts : tuple of ImpactAlternative
        Impacts without collision, under each law, of a contact that slides with p < 0 and is coupled to no other; found
        when they are first asked for.
    """

    t: float
    q: np.ndarray
    u: np.ndarray
    kind: ParadoxKind
    n_solutions: int
    is_complete: bool
    solutions: tuple[SpatialSolution, ...]
    flags: ParadoxFlag
    mode: tuple[str, ...]
    gamma_N: np.ndarray
    gamma_F: np.ndarray
    direction: np.ndarray
    mu: np.ndarray
    b: np.ndarray
    p: np.ndarray
    contacts: tuple[str, ...]
    _problem: Problem = field(repr=False)
    _restitution: np.ndarray = field(repr=False)

    @functools.cached_property
    def impacts(self) -> tuple[ImpactAlternative, ...]:
        return impacts_in_space(self._problem, self._restitution)

    def __getstate__(self) -> dict[str, Any]:
        """All that can be asked for: another process, or a copy, need not have the system."""
        stated = [part.name for part in fields(self) if not part.name.startswith("_")]
        return {name: getattr(self, name) for name in (*stated, "impacts")}

    def __str__(self) -> str:
        return view(self, "text")(self)

    def _repr_html_(self) -> str:
        return view(self, "html")(str(self))

    def __repr__(self) -> str:
        return (
            f"SpatialClassification({self.kind.name}, n_solutions={self.n_solutions}, is_complete={self.is_complete})"
        )

    def plot(self, path: str | Path | None = None, title: str = "") -> Any:
        """Draw the forces of every solution, |la_T| and la_N, in the friction cones of the contacts.

        Parameters
        ----------
        path : path-like, optional
            Where to save; the ending names the format.
        title : str
            What stands above; the kind by default.

        Returns
        -------
        matplotlib.figure.Figure
        """
        return view(self, "plot")(self, path, title)

    def to_dict(self) -> dict[str, Any]:
        """Plain lists, numbers and strings."""
        return view(self, "dictionary")(self)


def classify_in_space(
    system: System, t: float, q: np.ndarray, u: np.ndarray, tolerance: float, restitution: float | None = None
) -> SpatialClassification:
    """The classification of a state; of impacts with each contact's own restitution, unless it is given.

    Raises
    ------
    InvalidInput
        Where a contact penetrates or approaches, and where a model function wrote no number.
    """
    found = forces_found(system, t, q, u)
    problem = found.problem()
    gamma_N, gamma_F = problem.gamma[:, 0], problem.gamma[:, 1:]
    speed = np.linalg.norm(gamma_F, axis=1)
    is_sliding = problem.situation == Situation.SLIDING
    direction = np.where(is_sliding[:, None], gamma_F / np.where(speed > 0.0, speed, 1.0)[:, None], np.nan)
    islands = range(len(problem.counts))
    is_known = [is_complete(problem, island) for island in islands]
    is_all = all(is_known) or any(known and problem.counts[m] == 0 for m, known in enumerate(is_known))
    b, p, flags = slopes(problem, tolerance)
    kept = [range(min(int(problem.counts[island]), len(problem.la))) for island in islands]
    listed = itertools.islice(itertools.product(*kept), MOST_LISTED)
    names = [MODES[Situation(kind)] for kind in problem.situation]
    mode = [("closed" if not system.kinds[i, 1] and name == "resting" else name) for i, name in enumerate(names)]
    return SpatialClassification(
        t, q, u, kind_of(found.total, is_all), found.total, is_all,
        tuple(solution(problem, chosen, direction) for chosen in listed), flags, tuple(mode), gamma_N.copy(),
        gamma_F.copy(), direction, spread(problem.mu, problem), spread(b, problem), spread(p, problem),
        system.described.contacts, problem,
        system.laws[:, LAW_E_N].copy() if restitution is None else np.full(system.n_c, restitution),
    )  # fmt: skip


def rests_in_space(problem: Problem, k: int) -> bool:
    """Whether a closed contact with friction in two directions rests."""
    return problem.d(k) == 2 and problem.slip[k] == 0


def is_complete(problem: Problem, island: int) -> bool:
    """Whether no solution of an island can be missing."""
    if problem.outcomes[island] != Outcome.COMPLETE:
        return False
    members = problem.members(island)
    resting = [k for k in members if rests_in_space(problem, k)]
    if not resting:
        return True
    (k,), others = resting, [other for other in members if other not in resting]
    sets = itertools.chain.from_iterable(itertools.combinations(others, n) for n in range(len(others) + 1))
    return all(are_slides_of(problem, k, loaded) for loaded in sets)


def are_slides_of(problem: Problem, k: int, loaded: tuple[int, ...]) -> bool:
    """Whether the slides that are found of contact k, which rests, are all that there are while others are loaded."""
    G, c = reduced_to_one(problem, k, loaded)
    one = new(OneContact)
    one.G[0], one.c[:], one.mu, one.mu_static = G, c, problem.mu[k], problem.mu[k]
    slides = int((one.modes[: list_of_one(one.address)] == SLIDE).sum())
    return are_all_slides(G, c, float(problem.mu[k]), slides)


def reduced_to_one(problem: Problem, k: int, loaded: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray]:
    """G (3, 3) and c (3,) of a contact while others slide, or are held without friction: contact/spatial/forces.py."""
    rows, normal = problem.rows(np.array([k])), problem.start[list(loaded)].astype(int)
    columns = [
        problem.G[:, a] - (problem.slip[other] * problem.mu[other] * problem.G[:, a + 1] if problem.d(other) else 0.0)
        for a, other in zip(normal, loaded, strict=True)
    ]
    G, c = problem.G[np.ix_(rows, rows)], problem.c[rows]
    if not loaded:
        return G.copy(), c.copy()
    by = np.array(columns).T
    weights = by[rows] @ np.linalg.inv(by[normal])
    return G - weights @ problem.G[np.ix_(normal, rows)], c - weights @ problem.c[normal]


def slopes(problem: Problem, tolerance: float) -> tuple[np.ndarray, np.ndarray, ParadoxFlag]:
    """b and p of each closed contact, nan under a given force, and what they say."""
    n, flags, G = len(problem.closed), ParadoxFlag(0), problem.G
    b, p = np.full(n, np.nan), np.full(n, np.nan)
    for k in range(n):
        if problem.kind(k) == GIVEN_FORCE:
            continue
        N, d = int(problem.start[k]), problem.d(k)
        tilt = problem.mu[k] * G[N, N + 1 : N + 1 + d]
        along = np.linalg.norm(tilt) if problem.slip[k] == 0 else problem.slip[k] * tilt[0]
        b[k], p[k] = problem.c[N], G[N, N] - along
        is_p_zero = abs(p[k]) <= tolerance * (G[N, N] + abs(along))
        flags |= ParadoxFlag.PAINLEVE if p[k] <= 0.0 or is_p_zero else ParadoxFlag(0)
        flags |= ParadoxFlag.P_ZERO if is_p_zero else ParadoxFlag(0)
        is_b_zero = abs(b[k]) <= tolerance * problem.c_scale[N]
        flags |= ParadoxFlag.B_ZERO if is_b_zero else ParadoxFlag(0)
        flags |= ParadoxFlag.GENOT_BROGLIATO if is_p_zero and is_b_zero else ParadoxFlag(0)
    return b, p, flags


def solution(problem: Problem, chosen: tuple[int, ...], direction: np.ndarray) -> SpatialSolution:
    """A solution of all contacts from one of each island, its friction in the tangential axes of the system."""
    n_c, candidate = problem.system.n_c, np.zeros(len(problem.closed), int)
    modes, forces, rows = ["open"] * n_c, np.zeros((n_c, 3)), np.zeros(len(problem.c))
    for k, i in enumerate(problem.closed):
        m = chosen[problem.island[k]]
        candidate[k] = problem.candidate[m, k]
        own = slice(problem.start[k], problem.start[k + 1])
        rows[own] = problem.la[m, own]
        d, la = problem.d(k), problem.la[m, own]
        modes[i] = mode_of(candidate[k], d)
        forces[i, 0] = problem.normal[k] if problem.kind(k) == GIVEN_FORCE else la[0]
        forces[i, 1 : 1 + d] = la[len(la) - d :]
        if d == 2 and problem.slip[k] != 0:
            forces[i, 1:] = la[-2] * direction[i]
    stability = stability_in_space(problem, candidate, rows)
    return SpatialSolution(tuple(modes), forces, problem.du + problem.X.T @ rows, stability)


def mode_of(candidate: int, d: int) -> str:
    """What a contact does."""
    if candidate == FREE:
        return "free"
    if candidate == STICK:
        return "stick" if d else "closed"
    return "slide"


def spread(values: np.ndarray, problem: Problem) -> np.ndarray:
    """Values of the closed contacts, nan of the others."""
    found = np.full(problem.system.n_c, np.nan)
    found[problem.closed] = values
    return found
