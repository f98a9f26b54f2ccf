"""The penalty limit: what a compliant contact tends to as k -> inf, how fast, at what cost, and on which branch.

    e(k) = max |q_k(t) - q_ref(t)|,    order -d ln e/d ln k,    e^2 = W_expansion/W_compression of the contact

The rigid solution of the same system (a complementarity problem a step) stands beside it: as the reference, and with
its own errors and costs. Where the distance does not fall, the two have taken different solutions.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.arrays import as_positive, as_vector
from nonsmooth.errors import InvalidInput, StepFailure
from nonsmooth.integrators.moreau_jean import MoreauJean
from nonsmooth.integrators.penalty import Penalty
from nonsmooth.simulation import simulate
from nonsmooth.solution import Solution, mode_name
from nonsmooth.studies.convergence_study import dataset, measure, study_times
from nonsmooth.studies.force_history import force_episode
from nonsmooth.studies.reference import Reference, as_reference, coarser, largest
from nonsmooth.studies.study import Study, require_xarray
from nonsmooth.system import System, as_system

REFERENCE_STEPS = 1_000_000  # of the rigid run that stands as the reference where none is given
BESIDE_STEPS = (1_000, 10_000, 100_000)  # of the rigid runs whose cost stands beside
BRANCH = 5  # modes named
STIFFNESSES = tuple(10.0**n for n in range(4, 13))  # N/m


def penalty_study(
    system: Any,
    t_span: tuple[float, float],
    q0: ArrayLike,
    u0: ArrayLike,
    *,
    stiffness: ArrayLike = STIFFNESSES,
    damping: float | Callable[[float], float] | None = None,
    damping_ratio: float | None = None,
    penalty: Penalty | None = None,
    reference: Any = None,
    times: ArrayLike | None = None,
    contact: int = 0,
    limit: float | None = None,
    beside: Sequence[Any] | None = None,
) -> Study:
    """Runs with growing contact stiffness against the rigid solution.

    Parameters
    ----------
    system : System or model
    t_span : (float, float)
        Start and end [s].
    q0, u0 : array_like
        Initial state.
    stiffness : array_like (n,)
        k [N/m], increasing.
    damping : float or callable, optional
        c [N s/m], or c(k): ``lambda k: k`` keeps the relaxation time c/k at 1 s.
    damping_ratio : float, optional
        zeta, c = 2 zeta sqrt(k m), instead.
    penalty : Penalty, optional
        The other options (law, friction, mass, tolerances); its stiffness and damping are replaced.
    reference : (q, u) or integrator, optional
        States at the times, or what computes them; Moreau–Jean with a million steps when left out.
    times : array_like, optional
        When the distance is measured [s]; at the end when left out.
    contact : int
        The contact whose first episode is looked at.
    limit : float, optional
        Where the normal velocity after the episode should tend to [m/s]: gives "error_gamma_N".
    beside : sequence of integrators, optional
        Rigid runs whose errors and costs stand beside; Moreau–Jean with 1e3, 1e4 and 1e5 steps when left out.

    Returns
    -------
    Study
        ``data`` holds also, over "stiffness": "branch" (the first modes of the contact), "stop_time" (end of slip) [s],
        "peak_force" [N], "P_N" [N s] and "gamma_N" [m/s] of the first episode, its effective "restitution";
        "own_q", "own_u": errors of the integration, over "stiffness" and "time";
        over "beside": "beside_error_q", "beside_error_u" (at the last time), "beside_wall_time", "beside_steps".

    Raises
    ------
    InvalidInput
        For stiffnesses that do not increase, both forms of damping, times outside the span.
    MissingExtra
        Where xarray is not installed.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> from models import PainleveRod
    >>> rod = PainleveRod(mu=2.0)
    >>> limit = rod.impact_without_collision(e=1.0, law="energetic").gamma_N
    >>> study = ns.penalty_study(rod, (0, 0.01), *rod.state(slip=-1.0), stiffness=np.logspace(8, 12, 3), limit=limit)
    >>> study.fits("error_gamma_N")[0].law
    'k^-1/2 ln k'
    """
    system = as_system(system)
    require_xarray()
    k = as_vector("stiffness", stiffness)
    for value in k:
        as_positive("stiffness", value, "N/m")
    if (np.diff(k) <= 0).any():
        raise InvalidInput("stiffness must increase from value to value")
    if damping is not None and damping_ratio is not None:
        raise InvalidInput("give either damping or damping_ratio; got both")
    t, start = study_times(t_span, q0, u0, times, system)
    span = t[-1] - start[0]
    exact = as_reference(MoreauJean(span / REFERENCE_STEPS) if reference is None else reference, system, start, t)
    rows = []
    for value in k:
        integrator = penalty_at(penalty, float(value), damping, damping_ratio)
        row = measure(system, start, t, integrator, exact)
        row |= own_error(system, start, t, integrator, exact, row)
        rows.append(row | (contact_row(system, start, t[-1], integrator, contact, limit) if row["status"] == 1 else {}))
    data = dataset("stiffness", "N/m", k, t, rows, exact)
    rigid = [MoreauJean(span / n) for n in BESIDE_STEPS] if beside is None else list(beside)
    data = data.assign(beside_columns([measure(system, start, t, integrator, exact) for integrator in rigid]))
    return Study("stiffness", data, f"{system.name or 'system'}: the penalty limit")


def penalty_at(
    penalty: Penalty | None, k: float, damping: float | Callable[[float], float] | None, damping_ratio: float | None
) -> Penalty:
    """The integrator at one stiffness."""
    c = damping(k) if callable(damping) else damping
    if penalty is None:
        return Penalty(k, damping=c, damping_ratio=damping_ratio)
    return replace(penalty, stiffness=k, damping=c, damping_ratio=damping_ratio)


def own_error(
    system: System, start: tuple, t: np.ndarray, integrator: Penalty, exact: Reference, row: dict[str, Any]
) -> dict[str, Any]:
    """The error of the integration at one stiffness, from a run with ten times the tolerance."""
    coarse = measure(system, start, t, coarser(integrator), exact)
    if row["status"] != 1 or coarse["status"] != 1:
        return {}
    return {f"own_{name}": largest(row[f"end_{name}"] - coarse[f"end_{name}"]) for name in ("q", "u")}


def contact_row(
    system: System, start: tuple, t_end: float, integrator: Penalty, contact: int, limit: float | None
) -> dict[str, Any]:
    """What a contact did: branch, force history, restitution; what it did not do is NaN."""
    t_0, q0, u0 = start
    try:
        run = simulate(system, (t_0, t_end), q0, u0, integrator=integrator)
        episode = force_episode(run, contact)
    except (InvalidInput, StepFailure):
        return {"branch": ""}
    row = {
        "branch": branch(run, contact), "stop_time": episode.stop, "peak_force": episode.peak_force,
        "P_N": episode.P_N, "gamma_N": episode.gamma_N, "restitution": episode.restitution,
    }  # fmt: skip
    return row if limit is None else row | {"error_gamma_N": abs(episode.gamma_N - limit)}


def branch(run: Solution, contact: int) -> str:
    """The first modes of a contact, in order."""
    names = [mode_name(int(run.mode[0, contact]), int(run.slip[0, contact]))]
    names += [mode_name(e.mode_after, e.slip_after) for e in run.events if e.contact == contact]
    return ", ".join(names[:BRANCH]) + (", ..." if len(names) > BRANCH else "")


def beside_columns(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Errors at the last time and costs of the rigid runs."""
    columns: dict[str, Any] = {}
    for name in ("error_q", "error_u"):
        columns[f"beside_{name}"] = ("beside", [float(row[name][-1]) if name in row else np.nan for row in rows])
    for name in ("wall_time", "steps"):
        columns[f"beside_{name}"] = ("beside", [float(row.get(name, np.nan)) for row in rows])
    return columns
