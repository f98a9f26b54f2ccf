"""The task of the studies of limits: runs with one option varied, each compared with the same reference.

    e(x) = max |q_x - q_ref|    at given times, and after matched events;    cost: steps, wall time

Each value is a cell of a sweep; a run that fails is a cell with its status and its message.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.checks.arrays import as_vector
from nonsmooth.errors import InvalidInput
from nonsmooth.jit import identity
from nonsmooth.mechanics.model_system import as_system
from nonsmooth.mechanics.start import the_start
from nonsmooth.results.solution import Solution
from nonsmooth.runs.times import span_of
from nonsmooth.scenes.given import as_scene
from nonsmooth.signals.telling import tell_in_parts
from nonsmooth.studies.reference import Observed, Problem, Reference, SceneProblem
from nonsmooth.sweeps.progress import ANNOUNCED_TIME
from nonsmooth.sweeps.sweep import sweep
from nonsmooth.sweeps.task import CellStatus, FunctionTask, Variable

if TYPE_CHECKING:
    import xarray

# chosen: a run shorter than so many seconds is timed again, the least time counts
SHORT_RUN_REPEATS, SHORT_RUN_TIME = 4, 0.05
# chosen: s of each run that its cost is foreseen from; the longer where it is long
PROBE_TIME, LONGER_PROBE_TIME = 0.1, 0.5
ROWS = {"q": "time", "u": "time", "event_t": "event", "after_q": "event", "after_u": "event"}
OF = {
    "q": "a coordinate at the time", "u": "a velocity at the time", "event_t": "the time of the event",
    "after_q": "a coordinate after the event", "after_u": "a velocity after the event",
}  # fmt: skip


def as_problem(
    model: Any, t_span: tuple[float, float] | None, q0: ArrayLike | None, u0: ArrayLike | None, times: ArrayLike | None
) -> Problem:
    """The motion that a study looks at, checked; without ``times`` it is looked at in the end."""
    t_0, t_1 = span_of(model, t_span)
    t = as_vector("times", [t_1] if times is None else times)
    if t.size == 0 or t[0] <= t_0 or t[-1] > t_1 or (np.diff(t) <= 0).any():
        raise InvalidInput(f"times must increase within ({t_0:g}, {t_1:g}] s; got {t.tolist()}")
    if as_scene(model) is not None:
        if q0 is not None or u0 is not None:
            raise InvalidInput("the bodies of a scene have their start; leave out q0 and u0")
        return SceneProblem(model, (t_0, np.zeros(0), np.zeros(0)), t)
    system = as_system(model)
    return Problem(model, (t_0, as_vector("q0", q0, system.n_q), as_vector("u0", u0, system.n_u)), t)


def as_motion(
    model: Any, t_span: tuple[float, float] | None, q0: ArrayLike | None, u0: ArrayLike | None, state: Any,
    times: ArrayLike | None,
) -> Problem:  # fmt: skip
    """The same with the start of a system in any form (mechanics/start.py); a scene has its own."""
    if as_scene(model) is None:
        return as_problem(model, t_span, *the_start(model, q0, u0, state), times)
    if state is not None:
        raise InvalidInput("the bodies of a scene have their start; leave out state")
    return as_problem(model, t_span, q0, u0, times)


class ComparisonTask(FunctionTask):
    """Runs that are compared with a reference.

    Parameters
    ----------
    problem : Problem
    reference : Reference
    over : str
        What is varied.
    integrators : mapping
        Its values, and the integrator with each.
    """

    def __init__(self, problem: Problem, reference: Reference, over: str, integrators: Mapping[float, Any]) -> None:
        self.problem, self.reference, self.over, self.integrators = problem, reference, over, dict(integrators)

    runs = 2  # of a cell: at the times, and at those after events

    @property
    def function(self) -> Any:  # type: ignore[override]
        """What is done in a cell."""
        return self._cell

    def _cell(self, **cell: float) -> dict[str, Any]:
        with tell_in_parts(self.runs):
            return self.measure(self.integrators[cell[self.over]])

    def measure(self, integrator: Any) -> dict[str, Any]:
        """Errors and cost of the run of an integrator."""
        problem = self.problem
        run = problem.run(integrator, problem.times)
        wall_time = run.stats.wall_time
        for _ in range(SHORT_RUN_REPEATS if wall_time < SHORT_RUN_TIME else 0):
            wall_time = min(wall_time, problem.run(integrator, problem.times).stats.wall_time)
        observed = self.reference.observe(problem, integrator, run)
        errors = {f"error_{name}": error for name, error in self.reference.errors(observed).items()}
        return errors | {"steps": run.stats.steps, "wall_time": wall_time} | self.further(integrator, run, observed)

    def further(self, integrator: Any, run: Solution, observed: Observed) -> dict[str, Any]:
        """What else is measured of a run."""
        return {}

    def costs(self, columns: Mapping[str, np.ndarray]) -> np.ndarray:
        """Seconds that each cell will take, from the beginning of its run; looked at longer where it is long."""
        integrators = [self.integrators[value] for value in columns[self.over].tolist()]
        seconds = self.runs * self._foreseen(integrators, PROBE_TIME)
        return seconds if seconds.sum() < ANNOUNCED_TIME else self.runs * self._foreseen(integrators, LONGER_PROBE_TIME)

    def _foreseen(self, integrators: list[Any], wall_time: float) -> np.ndarray:
        """Seconds of each run, from so many of it; from the last one back, which takes the longest, until one has ended
        within that."""
        seconds = np.zeros(len(integrators))
        for k in reversed(range(len(integrators))):
            try:
                foreseen = self.problem.foreseen(integrators[k], max_wall_time=wall_time)
            except InvalidInput:
                continue  # the cell will say why
            seconds[: k + 1] = foreseen.seconds
            if foreseen.has_ended:
                break
        return seconds

    @property
    def variables(self) -> dict[str, Variable]:  # type: ignore[override]
        """Errors over the times and the events, and costs."""
        of_q, of_u = (
            ", ".join(dict.fromkeys(unit for unit in units if unit)) for units in self.problem.units_of_motion
        )
        units = {"q": of_q, "u": of_u, "event_t": "s", "after_q": of_q, "after_u": of_u}
        errors = {
            f"{kind}_{name}": Variable((row,), units[name], f"{what} of {OF[name]}")
            for kind, what in (("error", "distance to the reference"), ("own", "error of the integration"))
            for name, row in ROWS.items()
        }
        return errors | {"steps": Variable(), "wall_time": Variable((), "s")}

    def identity(self) -> str:
        """The motion, the reference and the integrators."""
        observed = {name: values.tolist() for name, values in self.reference.observed.items()}
        delay = None if self.reference.delay is None else self.reference.delay.tolist()
        parts = (self.problem.times.tolist(), observed, delay, self.integrators)
        return f"{self.problem.identity()}\n{identity(parts).hex()}"


def run_comparison(
    task: ComparisonTask, unit: str, workers: int = 1, journal: str | os.PathLike[str] | None = None,
    progress: Any = False,
) -> xarray.Dataset:  # fmt: skip
    """Run a study; its Dataset over what is varied, "time" and "event". After Ctrl-C what was finished, if there is
    any."""
    values = np.array(list(task.integrators))
    data = sweep(task, {task.over: (values, unit)}, workers=workers, journal=journal, progress=progress)
    if data.attrs["interrupted"] and (data.status == CellStatus.NOT_RUN).all():
        raise KeyboardInterrupt
    reference = task.reference
    data = data.assign_coords(time=("time", task.problem.times, {"units": "s"}))
    if reference.events is not None:
        data = data.assign_coords(
            event=("event", np.arange(len(reference.events.t))),
            event_time=("event", reference.events.t, {"units": "s"}),
            event_mode=("event", reference.events.names),
            delay=("event", reference.delay, {"units": "s"}),
        )
    return data.assign({f"floor_{name}": (ROWS[name], floor) for name, floor in reference.floor.items()})
