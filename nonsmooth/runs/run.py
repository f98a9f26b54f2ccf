"""One integration in progress: the integrator's loop, block after block, until the end, a failure or Ctrl-C.

Between two blocks Python looks for Ctrl-C and shows progress; the loop itself never returns to Python.
"""

from __future__ import annotations

import functools
import math
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.errors import InitialStateWarning, InvalidInput, Status, said_by, warn_caller
from nonsmooth.integrators.records import EVENT_KIND, EVENT_T, INCONSISTENT, Columns, Record, State
from nonsmooth.jit.blocks import Block, new
from nonsmooth.mechanics.compiled import loop_of
from nonsmooth.mechanics.contact_problem import model_facts
from nonsmooth.mechanics.initial_state import examine_state, project_state
from nonsmooth.mechanics.inspection import END, found_contradiction, inspect_start, is_due
from nonsmooth.mechanics.sys import new_sys
from nonsmooth.mechanics.system import GAP, ContactMode, System
from nonsmooth.results.failures import (
    BudgetSpent,
    EventFunctionError,
    ModelFunctionError,
    ProgressError,
    StepFailure,
)
from nonsmooth.results.motion import Motion, between_records
from nonsmooth.results.solution import MAX_EVENTS, Solution, Stats
from nonsmooth.runs.times import Grid, intervals_of
from nonsmooth.runs.user_events import START, EventWatch, Stop

if TYPE_CHECKING:
    from nonsmooth.results.failed_problem import FailedProblem

FIRST_BLOCK = 100  # chosen: steps before the first look at the clock
LOOK_EVERY = 0.02  # chosen: s between two looks at the clock and at Ctrl-C
EVENT_CAPACITY = 256  # chosen: 26 kB; the loop comes back to have them emptied

MESSAGES = {
    Status.NO_SOLUTION: "the contact problem of this step has no solution: every mode of {contact} was tried and none "
    "is admissible (rigid mechanics ends here; a compliant contact would go on)",
    Status.NOT_SOLVED: "the contact problem of this step was not solved to the accepted residual; try a smaller dt",
    Status.MASS_NOT_POSITIVE: "the mass matrix is not positive definite; check mass(t, q, p, M) and the parameters",
    Status.STEP_VANISHED: "the step fell below the resolution of time: the tolerance cannot be met in double precision "
    "(a larger rtol, or a smaller stiffness, can)",
    Status.CHATTERING: "one contact after the other changes its mode and no time passes; time stepping goes on through "
    "that: Adaptive or MoreauJean(dt), or EventDriven(hand_over=Adaptive()) for this stretch alone",
    Status.NEGATIVE_FRICTION: "the friction law of {contact} became negative; check its coefficients at this speed",
}


FAILURES: dict[Status, type[StepFailure]] = {
    Status.NOT_FINITE: ModelFunctionError,
    Status.BUDGET_SPENT: BudgetSpent,
    Status.EVENT_FAILED: EventFunctionError,
    Status.CONTRADICTED: ModelFunctionError,
    Status.PROGRESS_FAILED: ProgressError,
}
# chosen: ends that no model function can be the reason of
WITHOUT_CULPRIT = (
    Status.FINISHED, Status.INTERRUPTED, Status.BUDGET_SPENT, Status.EVENT_REACHED,
    Status.EVENT_FAILED, Status.CONTRADICTED, Status.PROGRESS_FAILED,
)  # fmt: skip
# chosen: ends at which nothing more is asked of the model's functions
WITHOUT_DOUBT = (
    Status.INTERRUPTED, Status.EVENT_FAILED, Status.NOT_FINITE, Status.CONTRADICTED, Status.PROGRESS_FAILED,
)  # fmt: skip


class Run:
    """One integration in progress."""

    def __init__(
        self, system: System, integrator: Any, grid: Grid, q0: np.ndarray, u0: np.ndarray, selection: int, project: bool
    ) -> None:
        self.system, self.integrator, self.grid = system, integrator, grid
        started = time.perf_counter()
        self.model, self.loop = loop_of(system, integrator)
        self.has = model_facts(system)
        self.sys, self.intervals = new_sys(system, self.model.handle, self.has), intervals_of(grid)
        self.compile_time = time.perf_counter() - started
        inspect_start(system, float(grid.t[0]), q0, u0, self.model)
        start = examine_state(system, self.model, self.has, float(grid.t[0]), q0, u0)
        if project:
            q0, u0 = project_state(system, float(grid.t[0]), q0, u0)
            start = examine_state(system, self.model, self.has, float(grid.t[0]), q0, u0)
        elif not start.is_admissible:
            warn_caller(start.message, InitialStateWarning)
        sizes = {"n": system.n_u, "n_c": system.n_c, "d": system.d}
        self.state = new(State, **sizes, capacity=EVENT_CAPACITY + 4 * system.n_c)
        self.record = new(Record, m=len(grid.t), **sizes)
        self.scratch = integrator.scratch(system, selection)
        self.state.q[:], self.state.u[:] = q0, u0
        self.state.mode[:] = start.mode
        self.state.slip[:] = start.slip
        self.selection = selection
        self.events: list[np.ndarray] = []
        self.events_dropped = 0
        self.status = Status.RUNNING
        self.wall_time = 0.0

    interrupted = 0  # runs of this process that Ctrl-C cut short: who makes many of them ends with the first
    watch: EventWatch | None = None
    stop: Stop | None = None
    budget = sys.maxsize  # steps
    deadline = math.inf  # [s] of the clock
    spent = ""  # which budget was used up
    cause: BaseException | None = None  # of a failure, an exception of the user's
    contradiction = ""  # which functions of the model do not agree

    def look_for(self, events: Sequence[Callable]) -> None:
        """Look for events of the user from step to step.

        Raises
        ------
        InvalidInput
            For what is no event function, and where not every step is recorded.
        """
        if self.grid.steps.max(initial=1) > 1:
            raise InvalidInput(
                f"{type(self.integrator).__name__} looks for events from record to record; give events without every= "
                "and t_eval=, so that every step is one"
            )
        self.watch = EventWatch(events, START)

    def advance(
        self, max_wall_time: float | None, progress: Callable[[float], None] | None, max_steps: int | None = None
    ) -> None:
        """Run block after block until the end, a failure, Ctrl-C or the end of the budget."""
        block, started = FIRST_BLOCK, time.perf_counter()
        self.budget = sys.maxsize if max_steps is None else max_steps
        self.deadline = math.inf if max_wall_time is None else started + max_wall_time
        try:
            while self.status == Status.RUNNING:
                began, before = time.perf_counter(), int(self.state.counters.steps)
                if before >= self.budget and self._fraction_done() < 1.0:
                    self.status, self.spent = Status.BUDGET_SPENT, f"max_steps = {max_steps}"
                    break
                block = max(1, min(block, self.budget - before))
                self.status = Status(self._watched_block(block) if self.watch else self._block(block))
                self._collect_events()
                if self.status == Status.NOT_SOLVED and self._load_for_retry():
                    self.status = Status.RUNNING
                if self.status == Status.RUNNING and is_due(self.system, self._modes().tobytes()):
                    self._inspect()
                now = time.perf_counter()
                self.wall_time = now - started
                block = next_block(int(self.state.counters.steps) - before, now - began)
                if progress is not None:
                    self._show(progress)
                if max_wall_time is not None and self.wall_time > max_wall_time and self.status == Status.RUNNING:
                    self.status, self.spent = Status.BUDGET_SPENT, f"max_wall_time = {max_wall_time:g} s"
        except KeyboardInterrupt:
            Run.interrupted += 1
            self.status = Status.INTERRUPTED
            self._collect_events()
        self.wall_time = time.perf_counter() - started
        if self.status not in WITHOUT_CULPRIT and self._culprit():
            self.status = Status.NOT_FINITE  # whatever NaN looked like to the step: no mode admissible, M indefinite
        if self.status not in WITHOUT_DOUBT and (self.status != Status.FINISHED or is_due(self.system, END)):
            self._inspect()

    def _show(self, progress: Callable[[float], None]) -> None:
        """Call the user's function of the fraction done; whatever it raises ends the run, with its name."""
        try:
            progress(self._fraction_done())
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            self.status, self.cause = Status.PROGRESS_FAILED, error

    def _inspect(self) -> None:
        """End the run where functions of the model contradict one another at the state that it has come to."""
        self.contradiction = found_contradiction(self.system, self._time(), *self._place())
        if self.contradiction:
            self.status = Status.CONTRADICTED

    def _place(self) -> tuple[np.ndarray, np.ndarray]:
        """The coordinates and velocities that the run has come to."""
        return self.state.q, self.state.u

    def _modes(self) -> np.ndarray:
        """What the contacts do there, (n_c,)."""
        return self.state.mode

    def _block(self, max_steps: int) -> int:
        sys, intervals, *blocks = self._handed(self.sys, self.intervals, self.state, self.record, self.scratch)
        # what is not finite is found by the loop itself; the interpreter would warn of it
        with nullcontext() if self.model.is_compiled else np.errstate(all="ignore"):
            return self.loop(sys, intervals, max_steps, *blocks)

    def _watched_block(self, max_steps: int) -> int:
        """A block, and the events of the user in it; at a reason to stop the records end there."""
        assert self.watch is not None
        first = int(self.state.counters.interval)
        status = self._block(max_steps)
        rows = slice(first, int(self.state.counters.interval) + 1)
        new_events = self.state.events[: int(self.state.counters.n_events)]
        record = Columns(*(column[rows] for column in self.record))
        motion = motion_of_records(self.grid.t[rows], record, new_events, self.integrator)
        self.stop = self.watch.scan(motion, has_ended=status == Status.FINISHED)
        if self.stop is None:
            return status
        self._cut(motion, self.stop.t)
        return self.stop.status

    def _cut(self, motion: Motion, t: float) -> None:
        """Go back to a time in a step: impulses and works in proportion, of a step with an impact all or nothing."""
        state, record, counters = self.state, self.record, self.state.counters
        k = max(0, int(np.searchsorted(self.grid.t, t)) - 1)
        part = (t - self.grid.t[k]) / (self.grid.t[k + 1] - self.grid.t[k])
        nodes = motion.t[(motion.t > self.grid.t[k]) & (motion.t < self.grid.t[k + 1])]
        if len(nodes):
            part = float(t >= nodes[0])
        after = k + (part > 0.0)
        state.q[:], state.u[:] = motion(t)
        state.P_sum[:] = part * record.P[k + 1]
        state.ledger[:] = (1.0 - part) * record.ledger[k] + part * record.ledger[k + 1]
        state.mode[:], state.slip[:] = record.mode[after], record.slip[after]
        kept = state.events[: counters.n_events]
        kept = kept[kept[:, EVENT_T] < self.grid.t[k] + part * (t - self.grid.t[k])]
        state.events[: len(kept)] = kept
        is_within = t > self.grid.t[k]
        counters.n_events, counters.interval = len(kept), k
        counters.step, counters.steps = is_within, k + is_within

    def _load_for_retry(self) -> bool:
        started = time.perf_counter()
        is_ready = self.integrator.load_for_retry(self.system, self.scratch, self.model.is_compiled)
        self.compile_time += time.perf_counter() - started
        return bool(is_ready)

    def _handed(self, *blocks: Block) -> tuple[Any, ...]:
        """Blocks as the loop takes them: by their addresses, or themselves in the interpreter."""
        return tuple(block.address if self.model.is_compiled else block for block in blocks)

    def _collect_events(self) -> None:
        count = int(self.state.counters.n_events)
        if count == 0:
            return
        room = MAX_EVENTS - sum(len(rows) for rows in self.events)
        self.events.append(self.state.events[: min(count, room)].copy())
        self.events_dropped += max(0, count - room)
        self.state.counters.n_events = 0

    def _fraction_done(self) -> float:
        span = self.grid.t[-1] - self.grid.t[0]
        return float((self._time() - self.grid.t[0]) / span) if span > 0 else 1.0

    def _time(self) -> float:
        interval, step = self.state.counters.interval, self.state.counters.step
        if self.stop is not None:
            return self.stop.t
        if interval >= len(self.grid.steps):
            return float(self.grid.t[-1])
        return float(self.grid.t[interval] + step * self.grid.dts[interval])

    def solution(self) -> Solution:
        """What was computed; of an unfinished run, the records and the state it stopped at."""
        m = int(self.state.counters.interval) + 1
        record, t = Columns(*(column[:m] for column in self.record)), self.grid.t[:m].copy()
        if self.status != Status.FINISHED and self.state.counters.step > 0:
            t = np.append(t, self._time())
            last = last_row(record, self.state, self.system, float(t[-1]))
            record = Columns(*map(np.concatenate, zip(record, last, strict=True)))
        rows = np.concatenate(self.events) if self.events else self.state.events[:0]
        return Solution.from_run(
            self.system, self.integrator, t, record, rows, self.status, self._message(), self._stats(),
            find_motion=self._motion_of_records(t, record, rows), user_events=self._user_events(),
        )  # fmt: skip

    def _user_events(self) -> tuple[list[np.ndarray], ...]:
        """Times and states of the user's events."""
        return self.watch.columns() if self.watch is not None else ([], [], [])

    def _motion_of_records(self, t: np.ndarray, record: Columns, rows: np.ndarray) -> Callable[[], Motion] | None:
        """What interpolates the records, if each step is one."""
        if (self.grid.steps > 1).any():
            return None
        return functools.partial(motion_of_records, t, record, rows, self.integrator)

    def _stats(self) -> Stats:
        return Stats.from_run(
            self.state, self.wall_time, self.compile_time, self.events_dropped, self.model.is_compiled
        )

    def _message(self) -> str:
        where = f"t = {self._time():.9g} s"
        if self.status == Status.FINISHED:
            return "the end was reached"
        if self.status == Status.INTERRUPTED:
            return f"interrupted at {where}"
        if self.status == Status.BUDGET_SPENT:
            return (
                f"{self.spent} is used up after {self.state.counters.steps} steps; stopped at {where}, {self._where()}"
            )
        if self.status == Status.PROGRESS_FAILED:
            assert self.cause is not None
            return f"the progress function raised {said_by(self.cause)}; stopped at {where}"
        if self.status == Status.CONTRADICTED:
            return f"{self.contradiction}; stopped at {where}"
        if self.stop is not None:
            return self.stop.message
        if self.status == Status.NOT_FINITE:
            what = self._culprit() or "the velocities are not finite: the step is too large, or h or M is"
            return f"{what}; {self._where()}; at {where}"
        contact = int(self.state.counters.failed_contact)
        name = f"contact {contact}" if contact >= 0 else "the closed contacts"
        return f"{MESSAGES[self.status].format(contact=name)}; stopped at {where}, {self._where()}"

    def _where(self) -> str:
        return f"q = {np.array2string(self.state.q, precision=6)}, u = {np.array2string(self.state.u, precision=6)}"

    def _culprit(self) -> str:
        """Which model function raised or wrote a number that is not finite: each is called again, in Python."""
        with np.errstate(all="ignore"):
            for moment, place, u in self._suspects():
                for which in self.system.functions:
                    name = self.system.name_of(which)
                    try:
                        out = self.system.evaluate(which, moment, place, u)
                    except Exception as error:
                        self.cause = error
                        return f"the model function {name} raised {said_by(error)}"
                    if not np.isfinite(out).all():
                        return f"the model function {name} wrote {out[~np.isfinite(out)][0]}"
        return ""

    def _suspects(self) -> list[tuple[float, np.ndarray, np.ndarray]]:
        """(t, q, u) at which the step that failed called the model functions."""
        t, q, u = self._time(), self.state.q, self.state.u
        interval = min(int(self.state.counters.interval), len(self.grid.dts) - 1)
        dt = float(self.grid.dts[interval]) if interval >= 0 else 0.0
        return [(t + part * dt, q + part * dt * u, u) for part in (0.0, 0.5, 1.0)]

    def failure(self, solution: Solution) -> StepFailure:
        """The exception of a run that did not end well."""
        kind = FAILURES.get(self.status, StepFailure)
        error = kind(solution.message, solution, self._time(), self._failed_problem(solution.message))
        error.__cause__ = self.stop.cause if self.stop is not None else self.cause
        return error

    def _failed_problem(self, message: str) -> FailedProblem | None:
        """The contact problem of the step that failed: the step is taken again, in fresh arrays."""
        if self.status not in (Status.NO_SOLUTION, Status.NOT_SOLVED, Status.NEGATIVE_FRICTION):
            return None
        from nonsmooth.results.failed_problem import FailedProblem

        dt = float(self.grid.dts[int(self.state.counters.interval)])
        self.scratch = self.integrator.scratch(self.system, self.selection)
        self.scratch.work.closed[:] = -1
        self._block(1)
        return FailedProblem.of_step(
            self.scratch,
            self.state,
            self.system.kinds,
            self.system.laws,
            dt,
            self.selection,
            message,
        )


def next_block(steps: int, elapsed: float) -> int:
    """Steps until the next look at the clock, from those just taken and their seconds; at most ten times more."""
    return max(1, int(steps * min(10.0, LOOK_EVERY / max(elapsed, 1e-9))))


def motion_of_records(t: np.ndarray, record: Columns, rows: np.ndarray, integrator: Any) -> Motion:
    """The motion between the records; a step in which a contact lands, or sliding had no force, has a jump."""
    mode = record.mode
    lands = ((mode[:-1] == ContactMode.OPEN) & (mode[1:] != ContactMode.OPEN)).any(axis=1)
    seizes = np.isin(t[:-1], rows[rows[:, EVENT_KIND] == INCONSISTENT, EVENT_T])
    return between_records(t, record.q, record.u, lands & ~seizes, seizes, integrator.theta)


def last_row(record: Columns, state: State, system: System, t: float) -> Columns:
    """One row of a record, filled from a state between two records."""
    row = Columns(*(np.zeros((1, *column.shape[1:]), column.dtype) for column in record))
    row.q[0], row.u[0], row.ledger[0] = state.q, state.u, state.ledger
    row.mode[0], row.slip[0], row.P[0] = state.mode, state.slip, state.P_sum
    if GAP in system.functions:
        try:
            row.g_N[0] = system.evaluate(GAP, t, state.q, state.u)
        except Exception:  # the gap function is what failed: the gap there is not known
            row.g_N[0] = np.nan
    return row
