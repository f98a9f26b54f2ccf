"""The penalty limit: what a compliant contact tends to as k -> inf, how fast, at what cost, and on which branch.

    e(k) = max |q_k(t) - q_ref(t)|,    order -d ln e/d ln k,    e^2 = W_expansion/W_compression of the contact

The rigid solution of the same system (a complementarity problem a step) is compared with it: as the reference, and with
its own errors and costs. Where the distance does not fall, the two have taken different solutions.
"""

from __future__ import annotations

import functools
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.checks.arrays import as_instance, as_name, as_positive, as_vector
from nonsmooth.errors import InvalidInput
from nonsmooth.integrators.event_driven.options import refused_in_space
from nonsmooth.integrators.moreau_jean.options import MoreauJean
from nonsmooth.integrators.penalty.options import Penalty
from nonsmooth.mechanics.start import answers_start
from nonsmooth.mechanics.system import BILATERAL, System
from nonsmooth.results.events import mode_name
from nonsmooth.results.solution import Solution
from nonsmooth.studies.affordable import Choice, choose_affordable, require_affordable
from nonsmooth.studies.comparison import ComparisonTask, as_motion, run_comparison
from nonsmooth.studies.equal_restitution import RESTITUTIONS, chosen_damping, compared
from nonsmooth.studies.force_history import first_episode
from nonsmooth.studies.reference import (
    EXACT,
    EXACT_IN_SPACE,
    Observed,
    Problem,
    Reference,
    SceneProblem,
    as_reference,
    coarser,
    largest_differences,
)
from nonsmooth.studies.stiffnesses import STIFFNESSES, beside_columns, penalty_at
from nonsmooth.studies.study import Study, require_xarray
from nonsmooth.sweeps.progress import part_shown
from nonsmooth.sweeps.task import Variable

BESIDE_STEPS = (1_000, 10_000, 100_000)  # chosen: of the rigid runs whose cost is compared
BRANCH = 5  # chosen: modes named


@answers_start
def penalty_study(
    system: Any,
    t_span: tuple[float, float] | None = None,
    q0: ArrayLike | None = None,
    u0: ArrayLike | None = None,
    *,
    state: Any = None,
    stiffness: ArrayLike | None = None,
    damping: float | Callable[[float], float] | None = None,
    damping_ratio: float | None = None,
    restitution: str = "equal",
    penalty: Penalty | None = None,
    reference: Any = None,
    times: ArrayLike | None = None,
    contact: int | str = 0,
    limit: float | None = None,
    beside: Sequence[Any] | None = None,
    delay: float | None = None,
    workers: int = 1,
    journal: str | os.PathLike[str] | None = None,
    progress: Any = True,
) -> Study:
    """Runs with growing contact stiffness against the rigid solution.

    Parameters
    ----------
    system, t_span, q0, u0, state
        As of `simulate`; a scene too, from its own start.
    stiffness : array_like (n,), optional
        k [N/m], increasing; when left out 1e4, 1e5, ... as far as 1e12 or as the runs, whose steps grow with k, take
        some seconds together. Of a scene from the power of ten on at which the weight of all bodies presses one contact
        in by less than a hundredth of half the thinnest body.
    damping : float or callable, optional
        c [N s/m], or c(k): ``lambda k: k`` keeps the relaxation time c/k at 1 s.
    damping_ratio : float, optional
        zeta, c = 2 zeta sqrt(k m), instead.
    restitution : {"equal", "own"}
        "equal": springs and rigid contact give back the same part of a frictionless collision. Where no damping is
        given zeta is chosen for the e_N of the contact, of a scene for the largest (where it is 0 for 0.01: no damper
        of a clipped contact gives back nothing); where it is given, the rigid contacts take the e of the stiffest
        springs in place of the model's. "own": each keeps its own; then springs without damping give back all, those of
        a scene have zeta = 1. A bilateral contact has none, and no damper where none is given.
    penalty : Penalty, optional
        The other options (law, friction, mass, tolerances); its stiffness and damping are replaced.
    reference : (q, u) or integrator, optional
        States at the times, or what computes them; ``EventDriven(rtol=1e-12, atol=1e-14)`` when left out, in
        space ``Adaptive(rtol=1e-9, atol=1e-11)``, of a scene Moreau-Jean with 4000 steps.
    times : array_like, optional
        When the distance is measured [s]; at the end when left out.
    contact : int or str
        The contact, by number or name, whose first episode is looked at.
    limit : float, optional
        Where the normal velocity after the episode should tend to [m/s]: gives "error_gamma_N".
    beside : sequence of integrators, optional
        Rigid runs whose errors and costs are compared; Moreau–Jean with 1e3, 1e4 and 1e5 steps when left out, of a
        scene with 250 and 1000.
    delay : float, optional
        Time after each matched event at which the distance is measured too [s]; half the time to the next event of the
        reference when left out. A reference that does not locate its events has none.
    workers : int
        Processes; their wall times are those of runs that share the machine.
    journal : path-like, optional
        Of the sweep that makes the runs.
    progress : bool, "json" or callable
        As of `sweep`.

    Returns
    -------
    Study
        ``data`` holds also, over "stiffness": "branch" (the first modes of the contact), "stop_time" (end of slip) [s],
        "peak_force" [N], "P_N" [N s] and "gamma_N" [m/s] of the first episode, its effective "restitution";
        "e_springs", by the closed form of their damping ratio at the start (measured at the stiffest where there is no
        such form), to be compared with ``data.attrs["e_N"]`` of the rigid contact and ``["e_N_of_model"]``;
        "own_q", "own_u" and so on: errors of the integration, for each "error_q", "error_u";
        Of a scene there is "penetration" [m] in their place, the deepest of the run;
        over "beside": "beside_error_q", "beside_error_u" (at the last time), "beside_wall_time", "beside_steps".
        After Ctrl-C it holds the runs that were finished.

    Raises
    ------
    InvalidInput
        For stiffnesses that do not increase, both forms of damping, times outside the span, a delay without events;
        where neither stiffness nor reference is given, for a motion of so many events that the reference takes long.
    MissingExtra
        Where xarray is not installed.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> from nonsmooth.catalogue import PainleveRod
    >>> rod = PainleveRod(mu=2.0)
    >>> limit = rod.impact_without_collision(e=1.0, law="energetic").gamma_N
    >>> study = ns.penalty_study(rod, (0, 0.01), *rod.state(slip=-1.0), stiffness=np.logspace(8, 12, 3), limit=limit,
    ...                          restitution="own")
    >>> study.fits("error_gamma_N")[0].law
    'k^-1/2 ln k'
    """
    require_xarray()
    if penalty is not None:
        as_instance("penalty", penalty, Penalty, "a Penalty, whose stiffness is varied")
    k = as_vector("stiffness", STIFFNESSES if stiffness is None else stiffness)
    if k.size == 0:
        raise InvalidInput("stiffness must hold at least one value; got none")
    for value in k:
        as_positive("stiffness", value, "N/m")
    if (np.diff(k) <= 0).any():
        raise InvalidInput("stiffness must increase from value to value")
    if damping is not None and damping_ratio is not None:
        raise InvalidInput("give either damping or damping_ratio; got both")
    as_name("restitution", restitution, RESTITUTIONS)
    problem = as_motion(system, t_span, q0, u0, state, times)
    if isinstance(problem, SceneProblem):
        from nonsmooth.studies.penalty_of_scenes import study_of_scene

        taken = {"contact": contact or None, "limit": limit, "delay": delay}
        return study_of_scene(
            problem, None if stiffness is None else k, damping, damping_ratio, restitution, penalty, reference, beside,
            workers, journal, progress, taken,
        )  # fmt: skip
    if problem.system.n_c == 0:
        raise InvalidInput("a penalty study needs a system with contacts; this one has none")
    contact = problem.system.described.contact(contact)
    is_free = stiffness is None and reference is None
    is_followed = not problem.system.is_spatial or not any(refused_in_space(problem.system))
    best = EXACT if is_followed else EXACT_IN_SPACE
    if is_free:
        require_affordable(problem, best)
    is_equal = restitution == "equal"
    chosen_ratio = None
    if is_equal and damping is None and damping_ratio is None:
        chosen_ratio = damping_ratio = chosen_damping(problem, contact, "clipped" if penalty is None else penalty.law)
    make = functools.partial(penalty_at, penalty, damping=damping, damping_ratio=damping_ratio)
    chosen = (
        Choice(k.tolist()) if stiffness is not None else choose_affordable(problem, k.tolist(), make, PenaltyTask.runs)
    )
    compliant = {x: make(x) for x in chosen.values}
    may_change = is_equal and not isinstance(reference, tuple | list)  # states that are known have their own
    found, rigid = compared(problem, list(compliant.values()), contact, chosen_ratio, may_change)
    if is_free and rigid is not problem:
        require_affordable(rigid, best)
    with part_shown("the reference", progress):
        exact = as_reference(best if reference is None else reference, rigid, delay)
    task = PenaltyTask(problem, exact, "stiffness", compliant, contact, limit)
    data = run_comparison(task, "N/m", workers, journal, progress)
    data.attrs |= {"left_out": chosen.left_out, "doubt": exact.doubt, **problem.about}
    data.attrs["undamped"] = undamped_ones(problem.system, compliant.values())
    data = data if found is None else found.columns(data)
    span = problem.span[1] - problem.span[0]
    steppers = [MoreauJean(span / n) for n in BESIDE_STEPS] if beside is None else beside
    if len(steppers) and not data.attrs["interrupted"]:
        runs = ComparisonTask(rigid, exact, "beside", dict(enumerate(steppers)))
        try:
            data = data.assign(beside_columns(runs, progress))
        except KeyboardInterrupt:  # the runs that the study is of are finished
            data.attrs["interrupted"] = 1
    return Study("stiffness", data, problem.titled("the penalty limit"))


def undamped_ones(system: System, runs: Iterable[Penalty]) -> str:
    """What is to be said of bilateral contacts whose springs have no damper."""
    if any(run.damping or run.damping_ratio for run in runs):
        return ""
    names = [system.described.contacts[i] for i in np.flatnonzero(system.kinds[:, 0] == BILATERAL)]
    if not names:
        return ""
    return (
        f"the springs of {', '.join(names)}, held on both sides, have no damper and vibrate for ever: velocities and "
        "forces do not converge, and where friction follows these forces nor does the motion; give damping_ratio=1"
    )


class PenaltyTask(ComparisonTask):
    """Runs with compliant contact, compared with a reference, and what one of their contacts did."""

    def __init__(
        self, problem: Problem, reference: Reference, over: str, integrators: Mapping[float, Any], contact: int,
        limit: float | None,
    ) -> None:  # fmt: skip
        super().__init__(problem, reference, over, integrators)
        self.contact, self.limit = contact, limit

    def identity(self) -> str:
        """Also the contact, and the limit of its velocity."""
        return f"{super().identity()}\n{self.contact}\n{self.limit}"

    runs = 5  # of a cell: two more with a larger tolerance, and one of the episode of the contact with every step

    def further(self, integrator: Penalty, run: Solution, observed: Observed) -> dict[str, Any]:
        """The part of the errors that the integration has, and what the contact did."""
        problem, loose = self.problem, coarser(integrator)
        coarse = self.reference.observe(problem, loose, problem.run(loose, problem.times))
        own = {f"own_{name}": error for name, error in largest_differences(observed, coarse).items()}
        return own | self.contact_row(integrator, run)

    def contact_row(self, integrator: Penalty, run: Solution) -> dict[str, Any]:
        """What the contact did: branch, force history, restitution; of one that never closes the branch alone."""
        row: dict[str, Any] = {"branch": branch(run, self.contact)}
        episode = first_episode(self.problem, integrator, run, self.contact)
        if episode is None:
            return row
        row |= {
            "stop_time": episode.stop, "peak_force": episode.peak_force,
            "P_N": episode.P_N, "gamma_N": episode.gamma_N, "restitution": episode.restitution,
        }  # fmt: skip
        return row if self.limit is None else row | {"error_gamma_N": abs(episode.gamma_N - self.limit)}

    @property
    def variables(self) -> dict[str, Variable]:  # type: ignore[override]
        """Also what the contact did."""
        units = {"stop_time": "s", "peak_force": "N", "P_N": "N s", "gamma_N": "m/s", "error_gamma_N": "m/s"}
        return super().variables | {name: Variable((), unit) for name, unit in units.items()}


def branch(run: Solution, contact: int) -> str:
    """The first modes of a contact, in order."""
    names = [mode_name(int(run.mode[0, contact]), int(run.slip[0, contact]))]
    names += [mode_name(e.mode_after, e.slip_after) for e in run.events if e.contact == contact]
    return ", ".join(names[:BRANCH]) + (", ..." if len(names) > BRANCH else "")
