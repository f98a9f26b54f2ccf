"""A run of a system: the integrator's loop, block after block. The loop itself never returns to Python."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np

from nonsmooth.errors import Status, said_by
from nonsmooth.integrators.contract import Integrator, Schedule
from nonsmooth.integrators.fixed_step import FixedStep
from nonsmooth.integrators.records import Columns, Record
from nonsmooth.jit import interpreted
from nonsmooth.jit.blocks import Block, numbers
from nonsmooth.mechanics.acceleration_problem import acceleration_problem_apart
from nonsmooth.mechanics.inspection import END, found_contradiction, is_due
from nonsmooth.mechanics.own_law import find_fault
from nonsmooth.mechanics.system import SURFACE_VELOCITY, TANGENT, System, evaluate
from nonsmooth.results.motion import Motion, join_motions
from nonsmooth.results.recorded import EVENTS, KINDS_BETWEEN, KINDS_OF_MOTION
from nonsmooth.results.solution import Solution, rest_of_run
from nonsmooth.results.stats import NONE_TOGETHER, Stats
from nonsmooth.runs.ongoing import Ongoing, columns_of, motion_between
from nonsmooth.runs.recorder import Recorder
from nonsmooth.runs.run import Run
from nonsmooth.runs.times import Timetable
from nonsmooth.runs.user_events import EventWatch

if TYPE_CHECKING:
    from nonsmooth.results.failed_problem import FailedProblem

FIRST_BLOCK = 100  # chosen: steps before the first look at the clock

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

    def block(self, run: SystemRun, max_steps: int) -> int:
        """A block of steps, and the events in it; at a reason to stop the run ends there."""


class Snapshot(NamedTuple):
    """A moment of a run that it can go back to."""

    memories: tuple[np.ndarray, ...]
    n_rows: int
    n_steps: int
    n_events: int


class SystemRun(Ongoing, Run):
    """One integration of a system in progress.

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

    first_block = FIRST_BLOCK
    watch: Watch | None = None
    bad_law = ""  # which friction law of the user's is none, and where
    contradiction = ""  # which functions of the model do not agree

    def keep_steps(self) -> None:
        """Keep the motion within the steps, whichever are recorded; before the first of them."""
        self.record = self.recorder.room(self, keeps_steps=True)

    @property
    def steps(self) -> int:
        """Taken so far."""
        return int(self.state.counters.steps)

    def take(self, most: int) -> Status:
        """Take a block of at most so many steps, with its records and events; ends where functions contradict."""
        status = Status(self.watch.block(self, most) if self.watch else self.block(most))
        self.recorder.take_events(self)
        if status == Status.NOT_SOLVED and self.load_for_retry():
            status = Status.RUNNING
        if status == Status.RUNNING and is_due(self.system, self.state.mode.tobytes()):
            return self._inspected(status)
        return status

    def settle(self) -> None:
        """Find out what an end is due to: a function of the model, a law of friction."""
        if self.status == Status.INTERRUPTED:
            self.recorder.take_events(self)
        if self.status not in WITHOUT_CULPRIT and self._culprit():
            self.status = Status.NOT_FINITE  # whatever NaN looked like to the step: no mode admissible, M indefinite
        if self.status not in WITHOUT_CULPRIT and self.system.own_laws:
            self.bad_law = find_fault(self.system, self._fastest_slip())
            if self.bad_law:
                self.status = Status.NEGATIVE_FRICTION
        if self.status not in WITHOUT_DOUBT and (self.status != Status.FINISHED or is_due(self.system, END)):
            self.status = self._inspected(self.status)

    def _fastest_slip(self) -> float:
        """Twice the largest sliding speed at the state that the run has come to: that of its last step is below."""
        t, q, u = self.now, self.state.q, self.state.u
        sliding = evaluate(self.system, TANGENT, t, q, u) @ u + evaluate(self.system, SURFACE_VELOCITY, t, q, u)
        return 2.0 * float(np.abs(sliding).max())

    def _inspected(self, status: Status) -> Status:
        """The status, or CONTRADICTED where functions of the model contradict one another at the state at hand."""
        self.contradiction = found_contradiction(self.system, self.now, self.state.q, self.state.u)
        return Status.CONTRADICTED if self.contradiction else status

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
        ends, is_straight = ((t[0], q[0], u[0]), (t[-1], q[-1], u[-1])), self.system.kinematics is not None
        return functools.partial(join_motions, self.recorder.steps, *ends, is_straight)

    def stats(self) -> Stats:
        """What the run cost."""
        return Stats.from_run(self.state, self.system, *self._about())

    def _about(self) -> tuple[Any, ...]:
        """What `Stats` has of a run beside its counters and worst figures."""
        recorder = self.recorder
        return self.wall_time, self.compile_time, recorder.events_dropped, self.model.is_compiled, recorder.recorded

    def where(self) -> str:
        """Where the run is, in words."""
        return f"{super().where()}, {self._state()}"

    def reason(self) -> str:
        """A sentence on an end that is none of those that all runs have."""
        if self.status == Status.CONTRADICTED:
            return f"{self.contradiction}; stopped at t = {self.now:.9g} s"
        if self.status == Status.NOT_FINITE:
            what = self._culprit() or "the velocities are not finite: the step is too large, or h or M is"
            return f"{what}; {self._state()}; at t = {self.now:.9g} s"
        if self.bad_law:
            return f"{self.bad_law}; stopped at {self.where()}"
        if reason := self.integrator.reason(self.status, self.state, self.memory):
            return f"{reason}; {self._state()}"
        contact, names = int(self.state.counters.failed_contact), self.system.described.contacts
        name = names[contact] if 0 <= contact < len(names) else "the closed contacts"
        return f"{MESSAGES[self.status].format(contact=name)}; stopped at {self.where()}"

    def _state(self) -> str:
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

    def failed_problem(self, message: str) -> FailedProblem | None:
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
    """What `SystemRun.solution` leaves for later, from the words of a record."""
    block = Record(words)
    record = Columns(*(column[: block.counts.rows] for column in columns_of(block)))
    recorded = about[-1]
    motion = motion_of_records(system, integrator, schedule, record, events, recorded)
    return rest_of_run(system, integrator, record, Stats.of_numbers(*figures, NONE_TOGETHER, *about), motion, recorded)
