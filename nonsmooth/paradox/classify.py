"""How many forces fit a state: the classification of Painlevé's paradoxes.

    0 solutions  INCONSISTENT    no force can go with the state: an impact without collision must occur
    1            REGULAR
    2 or more    INDETERMINATE   rigid-body theory does not decide

for the acceleration-level problem gamma' = G la + b of ``paradox.forces``. Contacts that G does not couple are islands:
each is decided for itself, and a solution of all is one of each. Source: Painlevé, *C. R. Acad. Sci. Paris*
121 (1895) 112; Génot, Brogliato, *Eur. J. Mech. A/Solids* 18 (1999) 653; Champneys, Várkonyi, *IMA J. Appl. Math.* 81
(2016) 538.
Equations: docs/theory/painleve.md, (1) to (3).
"""

from __future__ import annotations

import functools
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from nonsmooth.checks.arrays import as_fraction, as_number, as_vector
from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.model_system import as_system
from nonsmooth.mechanics.start import answers_start, forms_of, start_of
from nonsmooth.mechanics.system import BILATERAL
from nonsmooth.paradox.alternatives import ImpactAlternative
from nonsmooth.paradox.in_space import SpatialClassification, classify_in_space
from nonsmooth.paradox.judgement import (
    Judgement,
    all_or_unknown,
    all_solutions,
    flags_of,
    free_accelerations,
    mode_names,
    slopes,
)
from nonsmooth.paradox.kinds import ContactIsland, ForceSolution, ParadoxFlag, ParadoxKind, kind_of
from nonsmooth.paradox.state_problem import forces_found
from nonsmooth.scenes.given import as_model
from nonsmooth.views import view

STATED = ("t", "q", "u", "kind", "n_solutions", "is_complete")
FOUND_WHEN_ASKED = (
    "solutions", "flags", "mode", "gamma_N", "gamma_F", "mu", "a", "b", "p", "k", "is_always_regular", "impacts",
    "chatter_ratio", "is_bilateral", "islands", "contacts",
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Classification:
    """Every solution of the contact problem at a state, and what it means. ``print`` it to read it.

    The number of solutions is known from the start; what follows from them is found when it is first asked for.

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
    contacts : tuple of str
        What the contacts are called.
    """

    t: float
    q: np.ndarray
    u: np.ndarray
    kind: ParadoxKind
    n_solutions: int
    is_complete: bool
    _judged: Judgement = field(repr=False)
    _tolerance: float = field(repr=False)

    @functools.cached_property
    def solutions(self) -> tuple[ForceSolution, ...]:
        return all_solutions(self._judged.problem, self._judged.parts)

    @functools.cached_property
    def flags(self) -> ParadoxFlag:
        return flags_of(self._judged.problem, self._judged.parts, self._tolerance)

    @functools.cached_property
    def mode(self) -> tuple[str, ...]:
        return mode_names(self._judged.problem)

    @functools.cached_property
    def gamma_N(self) -> np.ndarray:
        return self._judged.problem.gamma[:, 0].copy()

    @functools.cached_property
    def gamma_F(self) -> np.ndarray:
        return self._judged.problem.gamma[:, 1].copy()

    @functools.cached_property
    def mu(self) -> np.ndarray:
        return self._judged.problem.mu_of_contacts()

    @functools.cached_property
    def a(self) -> np.ndarray:
        return free_accelerations(self._judged.problem)[1]

    @functools.cached_property
    def b(self) -> np.ndarray:
        return free_accelerations(self._judged.problem)[0]

    @functools.cached_property
    def p(self) -> np.ndarray:
        return slopes(self._judged.problem)[0]

    @functools.cached_property
    def k(self) -> np.ndarray:
        return slopes(self._judged.problem)[1]

    @functools.cached_property
    def is_always_regular(self) -> bool | None:
        return all_or_unknown([part.is_always for part in self._judged.parts])

    @functools.cached_property
    def impacts(self) -> tuple[ImpactAlternative, ...]:
        return self._judged.impacts()

    @functools.cached_property
    def chatter_ratio(self) -> np.ndarray:
        return self._judged.chatter_ratios()

    @functools.cached_property
    def is_bilateral(self) -> np.ndarray:
        return self._judged.found.system.kinds[:, 0] == BILATERAL

    @functools.cached_property
    def islands(self) -> tuple[ContactIsland, ...]:
        return self._judged.islands

    @functools.cached_property
    def contacts(self) -> tuple[str, ...]:
        return self._judged.found.system.described.contacts

    def __getstate__(self) -> dict[str, Any]:
        """All that can be asked for: another process, or a copy, need not have the system."""
        return {name: getattr(self, name) for name in STATED + FOUND_WHEN_ASKED}

    def __str__(self) -> str:
        return view(self, "text")(self)

    def _repr_html_(self) -> str:
        return view(self, "html")(str(self))

    def __repr__(self) -> str:
        return f"Classification({self.kind.name}, n_solutions={self.n_solutions}, is_complete={self.is_complete})"

    def plot(self, path: str | Path | None = None, title: str = "") -> Any:
        """Draw the state: gamma_N' against la_N where one contact that slides decides, else the forces of every
        solution in the friction cones of the contacts. See `plot_graphical_problem`.

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
        """Plain lists, numbers and strings, as for JSON (which knows no nan: see ``json.dumps(allow_nan=)``)."""
        return view(self, "dictionary")(self)


@answers_start
def classify(system: Any, t: float = 0.0, q: Any = None, u: Any = None, *, state: Any = None,
             restitution: float | None = None, tolerance: float = 1e-9
             ) -> Classification | SpatialClassification:  # fmt: skip
    """Find every solution of the contact problem at a state, and classify it.

    Parameters
    ----------
    system : System, model, or Scene
        A scene as its ``system()``.
    t : float
        Time [s].
    q, u : array-like (n_q,), (n_u,)
        The state. Contacts with g_N = 0 and gamma_N = 0 take part, and all bilateral ones.
    state : (q, u), dict, or a state of a scene, optional
        In their place, as of `simulate`: ``state=dict(th=0.8)``; of a scene another one at its start, or
        ``{"angle of rod": 0.8}``. Left out for a scene: its start.
    restitution : float, optional
        Coefficient e of the impacts listed; each contact's own e_N when left out.
    tolerance : float
        p and b count as zero below this part of the terms they are sums of.

    Returns
    -------
    Classification or SpatialClassification
        The latter of a system with friction in two directions: its p and b along the slide, and all solutions where
        they are known.

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
    >>> c = ns.classify(rod, state=dict(thdot=6.0))
    >>> [(solution.modes, round(float(solution.la_N[0]), 6)) for solution in c.solutions]
    [(('free',), 0.0), (('slide -',), 6.813606)]
    """
    model = as_model(system)
    state = {} if model is not system and q is None and u is None and state is None else state
    system, t = as_system(model), as_number("t", t, "s")
    if state is not None and (q is not None or u is not None):
        raise InvalidInput("give either q and u, or state; got both")
    if state is None and (q is None or u is None):
        raise InvalidInput(f"a classification needs q and u, or state={forms_of(model)}")
    q, u = (q, u) if state is None else start_of(model, state)
    q, u = as_vector("q", q, system.n_q), as_vector("u", u, system.n_u)
    tolerance = as_fraction("tolerance", tolerance)
    e = None if restitution is None else as_fraction("restitution", restitution)
    if system.d > 1:
        return classify_in_space(system, t, q, u, tolerance, e)
    judged = Judgement(forces_found(system, t, q, u), e)
    n_solutions, is_complete = judged.count()
    return Classification(t, q, u, kind_of(n_solutions, is_complete), n_solutions, is_complete, judged, tolerance)
