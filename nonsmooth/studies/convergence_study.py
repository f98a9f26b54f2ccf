"""Convergence with the step or the tolerance: errors of an integrator against dt or rtol, their order and their cost.

    e(x) = max |q(t; x) - q_ref(t)|    (and likewise for the velocities),    x = dt or rtol

Source: Roache, *J. Fluids Eng.* 116 (1994) 405.
"""

from __future__ import annotations

import functools
import os
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.checks.arrays import as_positive, as_vector, result_of
from nonsmooth.errors import InvalidInput, shown
from nonsmooth.integrators.moreau_jean.options import MoreauJean
from nonsmooth.mechanics.start import answers_start
from nonsmooth.studies.affordable import Choice, choose_affordable, require_affordable
from nonsmooth.studies.comparison import ComparisonTask, as_motion, run_comparison
from nonsmooth.studies.reference import as_reference, with_step, with_tolerance
from nonsmooth.studies.study import Study, require_xarray
from nonsmooth.sweeps.progress import part_shown

STUDY_STEPS = (1e-2, 3e-3, 1e-3, 3e-4, 1e-4)  # chosen: s
STUDY_TOLERANCES = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10)  # chosen: relative
FINER = {"dt": 8.0, "rtol": 100.0}  # the reference that is not given is finer than the finest run by so much
FINEST_RTOL = 1e-13  # derived: of such a reference: a few roundings
UNITS = {"dt": "s", "rtol": ""}
TITLES = {"dt": "convergence with the step", "rtol": "convergence with the tolerance"}


@answers_start
def convergence_study(
    system: Any,
    t_span: tuple[float, float] | None = None,
    q0: ArrayLike | None = None,
    u0: ArrayLike | None = None,
    *,
    state: Any = None,
    dt: ArrayLike | None = None,
    rtol: ArrayLike | None = None,
    integrator: Any = MoreauJean,
    reference: Any = None,
    times: ArrayLike | None = None,
    delay: float | None = None,
    workers: int = 1,
    journal: str | os.PathLike[str] | None = None,
    progress: Any = True,
) -> Study:
    """Errors of an integrator, over its step or its tolerance.

    Parameters
    ----------
    system, t_span, q0, u0, state
        As of `simulate`.
    dt : array_like (n,), optional
        Steps [s], of an integrator with steps of a fixed length; when left out 1e-2 to 1e-4, as far as some seconds are
        enough.
    rtol : array_like (n,), optional
        Relative tolerances, of an integrator that controls its error; when left out 1e-4 to 1e-10, as far as some
        seconds are enough. The absolute one is changed by the same factor.
    integrator : integrator, class or callable
        ``MoreauJean``, ``EventDriven``, ``Penalty(stiffness=1e6)``, ``MoreauJean(1e-3, theta=1.0)``, whose step or
        tolerance is replaced; or what makes one of dt or rtol.
    reference : (q, u) or integrator, optional
        States at the times, or what computes them. When left out, the integrator itself with an eighth of the smallest
        step or a hundredth of the smallest tolerance. An error within ten times that of the reference counts as
        unknown.
    times, delay, workers, journal, progress
        As of `penalty_study`.

    Returns
    -------
    Study
        After Ctrl-C of the runs that were finished.

    Raises
    ------
    InvalidInput
        For dt where the integrator has a tolerance, and the other way round; steps that are not positive; what
        `penalty_study` refuses of times and references.
    MissingExtra
        Where xarray is not installed.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> from nonsmooth.catalogue import WallPendulum
    >>> pendulum = WallPendulum(th_w=-1.5)  # the wall is out of reach: smooth motion
    >>> study = ns.convergence_study(pendulum, (0, 1), *pendulum.state(th=1.0), dt=[1e-2, 5e-3, 2.5e-3])
    >>> study.orders("error_q").round(1).tolist()
    [2.0, 2.0]
    """
    require_xarray()
    over, values = varied(integrator, dt, rtol)
    make = maker(integrator, over, float(values[0]))
    problem = as_motion(system, t_span, q0, u0, state, times)

    def finer(x: float) -> Any:
        return make(max(x / FINER[over], FINEST_RTOL if over == "rtol" else 0.0)) if reference is None else reference

    chosen = Choice(values.tolist())
    if dt is None and rtol is None:
        chosen = choose_affordable(
            problem, chosen.values, make, ComparisonTask.runs, finer if reference is None else None
        )
        if hasattr(reference, "load"):
            require_affordable(problem, reference)
    with part_shown("the reference", progress):
        exact = as_reference(finer(chosen.values[-1]), problem, delay)
    task = ComparisonTask(problem, exact, over, {x: make(x) for x in chosen.values})
    data = run_comparison(task, UNITS[over], workers, journal, progress)
    data.attrs |= {"left_out": chosen.left_out, **problem.about}
    return Study(over, data, problem.titled(TITLES[over]))


def varied(integrator: Any, dt: ArrayLike | None, rtol: ArrayLike | None) -> tuple[str, np.ndarray]:
    """What is varied, "dt" or "rtol", and its values, decreasing."""
    if dt is not None and rtol is not None:
        raise InvalidInput("give either dt or rtol; got both")
    options = [field.name for field in fields(integrator)] if is_dataclass(integrator) else []
    over = "rtol" if rtol is not None or (dt is None and "rtol" in options) else "dt"
    if options and over not in options:
        name = getattr(integrator, "__name__", type(integrator).__name__)
        words = "it controls its error; vary rtol" if "rtol" in options else "its steps have a fixed length; vary dt"
        raise InvalidInput(f"{name} has no {over}: {words}")
    given = {"dt": STUDY_STEPS if dt is None else dt, "rtol": STUDY_TOLERANCES if rtol is None else rtol}[over]
    values = np.sort(as_vector(over, given))[::-1]
    if values.size == 0:
        raise InvalidInput(f"{over} must have at least one value; it is empty")
    for x in values:
        as_positive(over, x, UNITS[over])
    return over, values


def maker(integrator: Any, over: str, first: float) -> Callable[[float], Any]:
    """The integrator as a function of what is varied."""
    if isinstance(integrator, type):
        try:
            integrator = integrator() if over == "rtol" else integrator(dt=first)
        except TypeError:
            name = integrator.__name__
            raise InvalidInput(f"{name} needs further options; give integrator={name}(...) with them") from None
    if is_dataclass(integrator):
        change: Callable[..., Any] = with_tolerance if over == "rtol" else with_step
        return functools.partial(change, integrator)
    if callable(integrator) and hasattr(result_of("the function that makes integrators", integrator, first), "load"):
        return integrator
    raise InvalidInput(f"integrator must be an integrator, or make one of {over}; got {shown(integrator)}")
