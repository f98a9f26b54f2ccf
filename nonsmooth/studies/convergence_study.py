"""Convergence with the step: errors of an integrator against dt, their order and their cost.

    e(dt) = max |q(t; dt) - q_ref(t)|    (and likewise for the velocities) at given times

Source: Roache, *J. Fluids Eng.* 116 (1994) 405.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.arrays import as_positive, as_vector
from nonsmooth.errors import InvalidInput, StepFailure
from nonsmooth.integrators.moreau_jean import MoreauJean
from nonsmooth.runs.times import as_span
from nonsmooth.studies.reference import Reference, as_reference, run_at
from nonsmooth.studies.study import Study, require_xarray
from nonsmooth.system import System, as_system

OVER_TIME = ("error_q", "error_u", "own_q", "own_u")
REPEATS, SHORT = 4, 0.05  # a run shorter than so many seconds is timed again, the least time counts
STEPS = (1e-2, 3e-3, 1e-3, 3e-4, 1e-4)  # s
FINER = 8.0  # the step of a reference that is not given is so much smaller than the smallest of the study


def convergence_study(
    system: Any,
    t_span: tuple[float, float],
    q0: ArrayLike,
    u0: ArrayLike,
    *,
    dt: ArrayLike = STEPS,
    integrator: Callable[[float], Any] = MoreauJean,
    reference: Any = None,
    times: ArrayLike | None = None,
) -> Study:
    """Errors of an integrator at some times, over its step.

    Parameters
    ----------
    system : System or model
    t_span : (float, float)
        Start and end [s].
    q0, u0 : array_like
        Initial state.
    dt : array_like (n,)
        Steps [s].
    integrator : callable
        Makes the integrator of a step: `MoreauJean`, or ``lambda dt: MoreauJean(dt, theta=1.0)``.
    reference : (q, u) or integrator, optional
        States at the times, or what computes them; the integrator itself with an eighth of the smallest step when left
        out. An error within ten times that of the reference counts as unknown.
    times : array_like, optional
        When errors are measured [s]; at the end when left out.

    Returns
    -------
    Study

    Raises
    ------
    InvalidInput
        For steps that are not positive, times outside the span, references of another shape.
    MissingExtra
        Where xarray is not installed.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> from models import WallPendulum
    >>> pendulum = WallPendulum(th_w=-1.5)  # the wall is out of reach: smooth motion
    >>> study = ns.convergence_study(pendulum, (0, 1), *pendulum.state(th=1.0), dt=[1e-2, 5e-3, 2.5e-3])
    >>> study.orders("error_q").round(1).tolist()
    [2.0, 2.0]
    """
    system = as_system(system)
    steps = as_vector("dt", np.sort(as_vector("dt", dt))[::-1])
    for step in steps:
        as_positive("dt", step, "s")
    t, start = study_times(t_span, q0, u0, times, system)
    given = integrator(float(steps[-1]) / FINER) if reference is None else reference
    exact = as_reference(given, system, start, t)
    rows = [measure(system, start, t, integrator(float(step)), exact) for step in steps]
    return Study(
        "dt", dataset("dt", "s", steps, t, rows, exact), f"{system.name or 'system'}: convergence with the step"
    )


def study_times(
    t_span: tuple[float, float], q0: ArrayLike, u0: ArrayLike, times: ArrayLike | None, system: System
) -> tuple[np.ndarray, tuple]:
    """The times of a study and its start (t_0, q0, u0), checked."""
    t_0, t_1 = as_span(t_span)
    t = as_vector("times", [t_1] if times is None else times)
    if t.size == 0 or t[0] <= t_0 or t[-1] > t_1 or (np.diff(t) <= 0).any():
        raise InvalidInput(f"times must increase within ({t_0:g}, {t_1:g}] s; got {t.tolist()}")
    return t, (t_0, as_vector("q0", q0, system.n_q), as_vector("u0", u0, system.n_u))


def measure(system: System, start: tuple, t: np.ndarray, integrator: Any, exact: Reference) -> dict[str, Any]:
    """Errors and cost of one run; of a run that fails, its status and message."""
    try:
        run = run_at(system, start, t, integrator, on_failure="return")
    except (InvalidInput, StepFailure) as error:
        return {"status": 0, "message": str(error)}
    if not run.success:
        return {"status": int(run.status), "message": run.message}
    wall_time = run.stats.wall_time
    for _ in range(REPEATS if wall_time < SHORT else 0):
        wall_time = min(wall_time, run_at(system, start, t, integrator, on_failure="return").stats.wall_time)
    error_q, error_u = exact.errors(run)
    n = len(t)
    return {
        "end_q": run.q[-n:], "end_u": run.u[-n:],
        "error_q": error_q, "error_u": error_u, "steps": run.stats.steps, "wall_time": wall_time,
        "status": int(run.status), "message": run.message,
    }  # fmt: skip


def dataset(of: str, unit: str, x: np.ndarray, t: np.ndarray, rows: Sequence[dict[str, Any]], exact: Reference) -> Any:
    """The rows of a study as a Dataset over what was varied and the times."""
    xarray = require_xarray()
    empty = np.full(len(t), np.nan)
    over_time = [name for name in OVER_TIME if any(name in row for row in rows)]
    variables: dict[str, Any] = {
        name: ((of, "time"), np.array([row.get(name, empty) for row in rows])) for name in over_time
    }
    variables |= {"floor_q": ("time", exact.floor_q), "floor_u": ("time", exact.floor_u)}
    names = dict.fromkeys(name for row in rows for name in row if name not in (*OVER_TIME, "end_q", "end_u"))
    for name in names:
        is_text = any(isinstance(row.get(name), str) for row in rows)
        variables[name] = (of, [row.get(name, "" if is_text else np.nan) for row in rows])
    return xarray.Dataset(variables, {of: (of, x, {"units": unit}), "time": ("time", t, {"units": "s"})})
