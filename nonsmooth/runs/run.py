"""One integration in progress: the integrator's loop, block after block, until the end, a failure or Ctrl-C.

Between two blocks Python looks for Ctrl-C and shows progress; the loop itself never returns to Python.
"""

from __future__ import annotations

import functools
import math
import sys
from collections.abc import Callable
from contextlib import closing
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np

from nonsmooth.errors import Status, said_by
from nonsmooth.integrators.contract import Integrator, Schedule
from nonsmooth.integrators.fixed_step import FixedStep
from nonsmooth.integrators.records import Columns, Record
from nonsmooth.jit import interpreted, running_time, waited
from nonsmooth.jit.blocks import Block, numbers
from nonsmooth.mechanics.acceleration_problem import acceleration_problem_apart
from nonsmooth.mechanics.inspection import END, found_contradiction, is_due
from nonsmooth.mechanics.own_law import find_fault
from nonsmooth.mechanics.system import SURFACE_VELOCITY, TANGENT, System, evaluate
from nonsmooth.results.failures import (
    BudgetSpent,
    EventFunctionError,
    ModelFunctionError,
    ProgressError,
    StepFailure,
)
from nonsmooth.results.motion import Motion, join_motions
from nonsmooth.results.recorded import EVENTS, KINDS_BETWEEN, KINDS_OF_MOTION
from nonsmooth.results.solution import Solution, rest_of_run
from nonsmooth.results.stats import NONE_TOGETHER, Stats
from nonsmooth.runs.ongoing import Ongoing, columns_of, motion_between
from nonsmooth.runs.recorder import Recorder
from nonsmooth.runs.times import Timetable
from nonsmooth.runs.user_events import EventWatch

if TYPE_CHECKING:
    from nonsmooth.results.failed_problem import FailedProblem

FIRST_BLOCK = 100  # chosen: steps before the first look at the clock
LOOK_EVERY = 0.02  # chosen: s between two looks at the clock and at Ctrl-C

MESSAGES = {
    Status.NO_SOLUTION: "the contact problem of this step has no solution: every mode of {contact} was tried and none "
    "is admissible (rigid mechanics ends here; a compliant contact would go on)",
    Status.NOT_SOLVED: "the contact problem of this step was not solved to the accepted residual; try a smaller dt",
    Status.MASS_NOT_POSITIVE: "the mass matrix is not positive definite; check mass(t, q, p, M) and the parameters",
    Status.STEP_VANISHED: "the step fell below the resolution of time: the tolerance cannot be met in double precision "
    "(a larger rtol, or a smaller stiffness, can)",
    Status.CHATTERING: "one contact after the other changes its mode and no time passes; time stepping goes on through "
    "that: Adaptive or MoreauJean(dt)",
    Status.NEGATIVE_FRICTION: "the friction law of {contact} became negative, or no number; check its coefficients at "
    "this speed",
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


class Watch(Protocol):
    """What looks for events of the user (watched.py)."""

    events: EventWatch

    def block(self, run: Run, max_steps: int) -> int:
        """A block of steps, and the events in it; at a reason to stop the run ends there."""


class Snapshot(NamedTuple):
    """A moment of a run that it can go back to."""

    memories: tuple[np.ndarray, ...]
    n_rows: int
    n_steps: int
    n_events: int


class Run(Ongoing):
    """One integration in progress.

    Parameters
    ----------
    recorder : Recorder, optional
        Where the rows go; into memory when left out. The others are those of `Ongoing`.
    """

    def __init__(
        self, system: System, integrator: Integrator, table: Timetable, q0: np.ndarray, u0: np.ndarray, selection: int,
        project: bool, recorder: Recorder | None = None,
    ) -> None:  # fmt: skip
        self.recorder = Recorder() if recorder is None else recorder
        kept = self.recorder.kept(integrator)
        super().__init__(system, integrator, table, q0, u0, selection, project, kept)
        self.schedule = self.workspace.schedule_of(table, self.recorder.window(self))
        self.record = self.recorder.room(self, keeps_steps=integrator.chooses_steps and table.every == 1)
        self.recorder.begin(self)

    interrupted = 0  # runs of this process that Ctrl-C cut short: who makes many of them ends with the first
    watch: Watch | None = None
    budget = sys.maxsize  # steps
    deadline = math.inf  # [s] of `running_time`
    spent = ""  # which budget was used up
    cause: BaseException | None = None  # of a failure, an exception of the user's
    bad_law = ""  # which friction law of the user's is none, and where
    contradiction = ""  # which functions of the model do not agree

    def keep_steps(self) -> None:
        """Keep the motion within the steps, whichever are recorded; before the first of them."""
        self.record = self.recorder.room(self, keeps_steps=True)

    def advance(
        self, max_wall_time: float | None, progress: Callable[[float], None] | None, max_steps: int | None = None
    ) -> None:
        """Run block after block until the end, a failure, Ctrl-C or the end of the budget."""
        with closing(self.recorder):
            self._run_blocks(max_wall_time, progress, max_steps)
            self.recorder.end(self)

    def _run_blocks(
        self, max_wall_time: float | None, progress: Callable[[float], None] | None, max_steps: int | None
    ) -> None:
        block, started, waited_before = FIRST_BLOCK, running_time(), waited()
        self.budget = sys.maxsize if max_steps is None else max_steps
        self.deadline = math.inf if max_wall_time is None else started + max_wall_time
        try:
            while self.status == Status.RUNNING:
                began, before = running_time(), int(self.state.counters.steps)
                if before >= self.budget and self.fraction_done() < 1.0:
                    self.status, self.spent = Status.BUDGET_SPENT, f"max_steps = {max_steps}"
                    break
                block = max(1, min(block, self.budget - before))
                self.status = Status(self.watch.block(self, block) if self.watch else self.block(block))
                self.recorder.take_events(self)
                if self.status == Status.NOT_SOLVED and self.load_for_retry():
                    self.status = Status.RUNNING
                if self.status == Status.RUNNING and is_due(self.system, self.state.mode.tobytes()):
                    self._inspect()
                now = running_time()
                self.wall_time = now - started
                if self.status == Status.RUNNING:
                    block = next_block(int(self.state.counters.steps) - before, now - began)
                if progress is not None:
                    self._show(progress)
                if max_wall_time is not None and self.wall_time > max_wall_time and self.status == Status.RUNNING:
                    self.status, self.spent = Status.BUDGET_SPENT, f"max_wall_time = {max_wall_time:g} s"
        except KeyboardInterrupt:
            Run.interrupted += 1
            self.status = Status.INTERRUPTED
            self.recorder.take_events(self)
        self.wall_time = running_time() - started
        self.compile_time += waited() - waited_before
        if self.status not in WITHOUT_CULPRIT and self._culprit():
            self.status = Status.NOT_FINITE  # whatever NaN looked like to the step: no mode admissible, M indefinite
        if self.status not in WITHOUT_CULPRIT and self.system.own_laws:
            self.bad_law = find_fault(self.system, self._fastest_slip())
            if self.bad_law:
                self.status = Status.NEGATIVE_FRICTION
        if self.status not in WITHOUT_DOUBT and (self.status != Status.FINISHED or is_due(self.system, END)):
            self._inspect()

    def _fastest_slip(self) -> float:
        """Twice the largest sliding speed at the state that the run has come to: that of its last step is below."""
        t, q, u = self.time(), self.state.q, self.state.u
        sliding = evaluate(self.system, TANGENT, t, q, u) @ u + evaluate(self.system, SURFACE_VELOCITY, t, q, u)
        return 2.0 * float(np.abs(sliding).max())

    def _show(self, progress: Callable[[float], None]) -> None:
        """Call the user's function of the fraction done; whatever it raises ends the run, with its name."""
        try:
            progress(self.fraction_done())
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            self.status, self.cause = Status.PROGRESS_FAILED, error

    def _inspect(self) -> None:
        """End the run where functions of the model contradict one another at the state that it has come to."""
        self.contradiction = found_contradiction(self.system, self.time(), self.state.q, self.state.u)
        if self.contradiction:
            self.status = Status.CONTRADICTED

    def block(self, max_steps: int) -> int:
        """Take at most so many steps, and what they left behind; returns a Status."""
        return self.recorder.take(self, self.step_loop(max_steps))

    def snapshot(self) -> Snapshot:
        """All that the next step depends on, and how much was written."""
        recorder = self.recorder
        memories = tuple(block.words.copy() for block in (self.state, self.record, self.memory))
        return Snapshot(memories, len(recorder.rows), len(recorder.steps), len(recorder.events))

    def go_back(self, before: Snapshot) -> None:
        """Go back to a moment, as if nothing had been done since."""
        for block, words in zip((self.state, self.record, self.memory), before.memories, strict=True):
            block.words[:] = words
        recorder = self.recorder
        del recorder.rows[before.n_rows :], recorder.steps[before.n_steps :], recorder.events[before.n_events :]

    def fraction_done(self) -> float:
        """The part of the span that lies behind."""
        t_0, t_1 = self.table.span
        return float((self.time() - t_0) / (t_1 - t_0)) if t_1 > t_0 else 1.0

    def solution(self) -> Solution:
        """What was computed; of an unfinished run, the records and the state it stopped at."""
        stored = self.recorder.stored(self)
        if stored is not None:
            return stored
        events = self.recorder.event_rows()
        rest = self._rest_of_short(events) if self._is_short() else self._rest(events)
        known = events if EVENTS in self.recorder.recorded else None
        return Solution.from_run(self.system, rest, known, self.status, self.message(), self.user_events())

    def _rest(self, events: np.ndarray) -> dict[str, Any]:
        """The rows of the run, its figures and its motion."""
        record = self.recorder.records(self)
        motion, recorded = self.motion_of(record, events), self.recorder.recorded
        return rest_of_run(self.system, self.integrator, record, self.stats(), motion, recorded)

    def _is_short(self) -> bool:
        """Whether the run came to a good end of which there is nothing to say, and its rows are lent."""
        is_done = self.status == Status.FINISHED and isinstance(self.integrator, FixedStep)
        counters = self.state.counters
        is_told = counters.gains or counters.pushes or self.state.together.count
        return is_done and self.workspace.lends(self.record) and not (self.recorder.rows or is_told)

    def _rest_of_short(self, events: np.ndarray) -> Callable[[], dict[str, Any]]:
        """The same from a copy of the blocks: they are lent to the next run, and most of it is never asked for."""
        figures = numbers(self.state.counters).tolist(), numbers(self.state.worst).tolist()
        about = self._about()
        words, facts = self.record.words.copy(), (self.system, self.integrator, self.schedule)
        return functools.partial(rest_of_words, *facts, words, events, figures, about)

    def user_events(self) -> tuple[list[np.ndarray], ...]:
        """Times and states of the user's events."""
        return self.watch.events.columns(self.system.n_q, self.system.n_u) if self.watch is not None else ([], [], [])

    def motion_of(self, record: Columns, events: np.ndarray) -> Callable[[], Motion] | None:
        """What joins the steps to the motion, or interpolates the records, if each step is one."""
        if isinstance(self.integrator, FixedStep):
            task = self.system, self.integrator, self.schedule
            return motion_of_records(*task, record, events, self.recorder.recorded)
        if not self.recorder.has_all_steps(self) or not set(KINDS_OF_MOTION) <= set(self.recorder.recorded):
            return None
        t, q, u = record.t, record.q, record.u
        return functools.partial(join_motions, self.recorder.steps, (t[0], q[0], u[0]), (t[-1], q[-1], u[-1]))

    def stats(self) -> Stats:
        """What the run cost."""
        return Stats.from_run(self.state, self.system, *self._about())

    def _about(self) -> tuple[Any, ...]:
        """What `Stats` has of a run beside its counters and worst figures."""
        recorder = self.recorder
        return self.wall_time, self.compile_time, recorder.events_dropped, self.model.is_compiled, recorder.recorded

    def message(self) -> str:
        """How the run ended, in a sentence."""
        if self.status == Status.FINISHED:
            return "the end was reached"
        where = f"t = {self.time():.9g} s"
        if self.status == Status.INTERRUPTED:
            return f"interrupted at {where}"
        if self.status == Status.BUDGET_SPENT:
            spent = self.spent or self.integrator.budget
            return f"{spent} is used up after {self.state.counters.steps} steps; stopped at {where}, {self._where()}"
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
        if self.bad_law:
            return f"{self.bad_law}; stopped at {where}, {self._where()}"
        if reason := self.integrator.reason(self.status, self.state, self.memory):
            return f"{reason}; {self._where()}"
        contact, names = int(self.state.counters.failed_contact), self.system.described.contacts
        name = names[contact] if 0 <= contact < len(names) else "the closed contacts"
        return f"{MESSAGES[self.status].format(contact=name)}; stopped at {where}, {self._where()}"

    def _where(self) -> str:
        return f"q = {np.array2string(self.state.q, precision=6)}, u = {np.array2string(self.state.u, precision=6)}"

    def _culprit(self) -> str:
        """Which model function raised or wrote a number that is not finite: each is called again, in Python."""
        with np.errstate(all="ignore"):
            for moment, place, u in self.integrator.suspects(self.schedule, self.state, self.memory):
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

    def failure(self, solution: Solution) -> StepFailure:
        """The exception of a run that did not end well."""
        kind = FAILURES.get(self.status, StepFailure)
        error = kind(solution.message, solution, self.time(), self._failed_problem(solution.message))
        error.__cause__ = self.stop.cause if self.stop is not None else self.cause
        return error

    def _failed_problem(self, message: str) -> FailedProblem | None:
        """The contact problem of the step that failed: the step is taken again, in fresh arrays; of a method that
        chooses its steps that of the instant at which it stopped."""
        unsolved = (Status.NO_SOLUTION, Status.NOT_SOLVED, Status.NEGATIVE_FRICTION)
        if self.system.own_laws or self.status not in unsolved or not self.integrator.is_rigid:
            return None
        memory = self.integrator.step_problem(self.system, self.selection)
        if memory is None:
            from nonsmooth.results.problem_of_instant import problem_of_instant

            tolerances = getattr(self.integrator, "rtol", 0.0), getattr(self.integrator, "atol", 0.0)
            return problem_of_instant(
                self.system, self._set_up_instant, self.state, tolerances, self.selection, message
            )  # fmt: skip
        from nonsmooth.results.failed_problem import FailedProblem

        dt = float(self.schedule.dt[int(self.state.counters.interval)])
        self.memory = memory
        self.step_loop(1)
        return FailedProblem.of_step(
            memory, self.state, self.system.kinds, self.system.laws, dt, self.selection, message
        )  # fmt: skip

    def _set_up_instant(self, t: float, q: np.ndarray, u: np.ndarray, n: int, rates: np.ndarray, work: Block
    ) -> tuple[int, int]:  # fmt: skip
        """The contact problem of the accelerations of n contacts, to ``work``; (Status, rows)."""
        kernel = acceleration_problem_apart
        sys_at, work_at = self.handed(self.sys, work)
        return (kernel.compiled if self.model.is_compiled else interpreted(kernel))(sys_at, t, q, u, n, rates, work_at)


def motion_of_records(
    system: System, integrator: Integrator, schedule: Schedule, record: Columns, events: np.ndarray,
    recorded: tuple[str, ...],
) -> Callable[[], Motion] | None:  # fmt: skip
    """What interpolates the records of a fixed step, if each step is one and has what it takes."""
    if (schedule.steps > 1).any() or not set(KINDS_BETWEEN) <= set(recorded):
        return None
    return functools.partial(motion_between, system, integrator, record, events)


def rest_of_words(
    system: System, integrator: Integrator, schedule: Schedule, words: np.ndarray, events: np.ndarray,
    figures: tuple[list[int], list[float]], about: tuple[Any, ...],
) -> dict[str, Any]:  # fmt: skip
    """What `Run.solution` leaves for later, from the words of a record."""
    block = Record(words)
    record = Columns(*(column[: block.counts.rows] for column in columns_of(block)))
    recorded = about[-1]
    motion = motion_of_records(system, integrator, schedule, record, events, recorded)
    return rest_of_run(system, integrator, record, Stats.of_numbers(*figures, NONE_TOGETHER, *about), motion, recorded)


def next_block(steps: int, elapsed: float) -> int:
    """Steps until the next look at the clock, from those just taken and their seconds; at most ten times more."""
    return max(1, int(steps * min(10.0, LOOK_EVERY / max(elapsed, 1e-9))))
