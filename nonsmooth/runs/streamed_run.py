"""A run with a checkpoint, of whatever integrator; and that of a fixed step, on a window of the record times."""

from __future__ import annotations

from typing import Any

import numpy as np

from nonsmooth.errors import InvalidInput, Status
from nonsmooth.integrators.records import Columns, bytes_of_record
from nonsmooth.mechanics.system import System
from nonsmooth.results.checkpoint import Checkpoint, Shape
from nonsmooth.runs.identity import facts_of_run
from nonsmooth.runs.run import Run, last_row
from nonsmooth.runs.streaming import Place, Streaming
from nonsmooth.runs.times import Grid, RecordTimes, grid_times, intervals_of, record_times

WINDOW = 2**22  # chosen: bytes of records in memory


def streamed_run(
    system: System, integrator: Any, t_span: tuple[float, float], every: int, t_eval: Any, q0: np.ndarray,
    u0: np.ndarray, selection: int, project: bool, place: Place,
) -> Run:  # fmt: skip
    """The run of an integrator, with its checkpoint.

    Raises
    ------
    InvalidInput
        For a checkpoint of another run, and a method that cannot be checkpointed.
    """
    run: Streaming
    if not getattr(integrator, "chooses_steps", False):
        times = grid_times(integrator, t_span, every, t_eval)
        run, has_forces = StreamedRun(system, integrator, times, q0, u0, selection, project), False
    elif not integrator.is_compiled:
        raise InvalidInput(
            f"a run by SciPy's {integrator.method} cannot be checkpointed, its state is SciPy's own; "
            "method='compiled' can"
        )
    elif getattr(integrator, "hand_over", None) is not None:
        raise InvalidInput(
            "an EventDriven run that may be handed over cannot be checkpointed; give integrator=EventDriven() without "
            "hand_over, or MoreauJean(dt)"
        )
    else:
        from nonsmooth.runs.streamed_adaptive_run import adaptive_run

        moments = record_times(t_span, every, t_eval)
        run = adaptive_run(system, integrator, *moments, q0, u0, selection, project)
        has_forces = not getattr(integrator, "extrapolates", False)
    facts = facts_of_run(
        system, integrator, t_span, every, t_eval, q0, u0, selection, project, run.model.is_compiled
    )  # fmt: skip
    shape = Shape(system.n_u, system.n_c, system.d, has_forces)
    run.attach(Checkpoint(place.path, facts, shape, place.may_begin, place.may_resume), place.seconds)
    return run


class StreamedRun(Streaming):
    """One integration in progress, of a fixed step, on a window of the record times."""

    def __init__(
        self, system: System, integrator: Any, times: RecordTimes, q0: np.ndarray, u0: np.ndarray, selection: int,
        project: bool,
    ) -> None:  # fmt: skip
        self.times, self.first = times, 0
        self.window = max(2, WINDOW // bytes_of_record(system.n_u, system.n_c, system.d))
        super().__init__(system, integrator, self._window(integrator), q0, u0, selection, project)

    def _window(self, integrator: Any) -> Grid:
        t = self.times.part(self.first, min(self.first + self.window, self.times.count))
        return Grid(t, *integrator.steps_between(t))

    def new_rows(self) -> np.ndarray:
        new = slice(self.store.n_records - self.first, int(self.state.counters.interval) + 1)
        return self.as_rows(self.grid.t[new], Columns(*(column[new] for column in self.record)))

    def go_on(self) -> None:
        """Begin a window with the last record."""
        self.first = self.store.n_records - 1
        self.state.counters.interval = 0
        self.grid = self._window(self.integrator)
        self.intervals = intervals_of(self.grid)

    def next_window(self, status: int) -> int:
        if status != Status.FINISHED or self.store.n_records == self.times.count:
            return status
        self.go_on()
        return Status.RUNNING

    def last_row(self) -> np.ndarray | None:
        if self.state.counters.step == 0:
            return None
        t = self._time()
        return self.as_rows(np.array([t]), last_row(Columns(*self.record), self.state, self.system, t))

    def _fraction_done(self) -> float:
        t_0, t_1 = self.times.part(0, 1)[0], self.times.part(self.times.count - 1, self.times.count)[-1]
        return float((self._time() - t_0) / (t_1 - t_0)) if t_1 > t_0 else 1.0
