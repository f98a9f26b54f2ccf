"""A stretch of an event-driven run that another integrator takes over, because its events are too many to be followed.

It begins with the state and the modes of the run and takes its own steps; at the end of the stretch the state is moved
to the nearest admissible one and the contacts get their modes anew. Within the stretch the error is that of the other
integrator: of MoreauJean of first order in its dt, of Adaptive its tolerance.

Where too many contacts touch to decide, and again soon behind a stretch, the next one is twice as long: a stretch
begins with small steps, and where nothing but stepping helps, some ten stretches reach the end.
"""

from __future__ import annotations

import math
import warnings
from typing import NamedTuple, cast

import numpy as np

from nonsmooth.errors import InitialStateWarning, Status
from nonsmooth.integrators.contract import Integrator
from nonsmooth.integrators.event_driven.options import EventDriven
from nonsmooth.integrators.fixed_step import FixedStep
from nonsmooth.integrators.records import EVENT_CONTACT, EVENT_T, Columns, State
from nonsmooth.jit import running_time
from nonsmooth.jit.blocks import numbers
from nonsmooth.mechanics.initial_state import project_state
from nonsmooth.results.solution import Solution
from nonsmooth.runs.ongoing import motion_between
from nonsmooth.runs.recorder import Steps
from nonsmooth.runs.run import Run, Snapshot
from nonsmooth.runs.times import Timetable, listed

STRETCH_PART = 1e-4  # chosen: of the span: what stands for the step of an integrator that chooses its steps
STRETCH_STEPS = 50  # chosen: steps of the time stepper until events are followed again
MOST_STEPS = 1000  # chosen: and of an integrator that chooses them; both are doubled where a stretch does not help
MOST_DOUBLINGS = 6  # chosen: so that of an integrator that chooses its steps ten stretches are the whole span
MANY_EVENTS = 100  # chosen: events within one of its steps
# chosen: steps between two looks at the events: the same ones on a fast machine as on a slow one
STEPS_BETWEEN_LOOKS = 100
GIVEN_UP = (Status.CHATTERING, Status.NOT_SOLVED)
ADDED = ("steps", "solved", "skipped", "kept", "pivots", "several", "gains", "pushes", "rejected", "evaluations")


class HandingRun(Run):
    """One integration in progress, of an integrator that hands over to another one (``hand_over``)."""

    follows_since = -math.inf  # [s] begin of the stretch whose events are followed
    doublings = 0  # of the length of a stretch that another integrator takes over
    stretches, handed_over = 0, 0.0  # how many there were, and their time [s]

    def block(self, max_steps: int) -> int:
        """A block, and where its events are too dense a stretch of another integrator."""
        stepper = self.integrator.hand_over
        assert stepper is not None
        steps_left = self.budget - int(self.state.counters.steps)
        status = super().block(max(1, min(STEPS_BETWEEN_LOOKS, steps_left)))  # whatever the clock says
        if status in GIVEN_UP or (status == Status.RUNNING and are_dense(self._recent_events(), unit(self, stepper))):
            return step_over(self, stepper, status)
        return status

    def snapshot(self) -> Snapshot:
        self._handed_before = self.follows_since, self.doublings, self.stretches, self.handed_over
        return super().snapshot()

    def go_back(self, before: Snapshot) -> None:
        super().go_back(before)
        self.follows_since, self.doublings, self.stretches, self.handed_over = self._handed_before

    def _recent_events(self) -> np.ndarray:
        """The last events (MANY_EVENTS, EVENT_WIDTH) since events are followed."""
        new = self.state.events[: int(self.state.counters.n_events)]
        rows = np.concatenate((*self.recorder.events[-MANY_EVENTS:], new))[-MANY_EVENTS:]
        return rows[rows[:, EVENT_T] >= self.follows_since]

    def solution(self) -> Solution:
        """What was computed, and how much of it by the other integrator."""
        solution = super().solution()
        if self.stretches:
            name, several = type(self.integrator.hand_over).__name__, "es" if self.stretches > 1 else ""
            solution.about["handed over"] = (
                f"{self.stretches} stretch{several} of {self.handed_over:.3g} s in all to {name}"
            )
        return solution


class Stretch(NamedTuple):
    """What the other integrator did: its rows, from the one that the run stood at on."""

    rows: Columns  # m of them
    steps: Steps  # of the motion; none where they are not kept


def unit(run: HandingRun, stepper: Integrator) -> float:
    """The time [s] within which many events are too dense: a step of the time stepper."""
    if isinstance(stepper, FixedStep):
        return stepper.dt
    return STRETCH_PART * float(run.schedule.t[-1] - run.schedule.t[0])


def longest(run: HandingRun, stepper: Integrator) -> float:
    """The time [s] that a stretch may take."""
    return STRETCH_STEPS * unit(run, stepper) * 2.0**run.doublings


def are_dense(recent: np.ndarray, dt: float) -> bool:
    """Whether the recent events (m, EVENT_WIDTH), of several contacts, are many within dt [s].

    Those of one contact that accumulate are closed by the integrator itself.
    """
    times, contacts = recent[:, EVENT_T], recent[:, EVENT_CONTACT]
    return len(recent) >= MANY_EVENTS and times.max() - times.min() < dt and len(np.unique(contacts)) > 1


def step_over(run: HandingRun, stepper: Integrator, why: int) -> int:
    """Step from the state of the run over a stretch, and put the run behind it; returns a Status."""
    t = run.time()
    is_stuck = why == Status.NOT_SOLVED and t - run.follows_since < longest(run, stepper)
    run.doublings = min(run.doublings + 1, MOST_DOUBLINGS) if is_stuck else 0
    t_end = min(t + longest(run, stepper), float(run.schedule.t[-1]))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", InitialStateWarning)
        other = begin_stretch(run, stepper, t, t_end)
    most = min(MOST_STEPS << run.doublings, run.budget - int(run.state.counters.steps))
    other.advance(max(0.0, run.deadline - running_time()), None, max(1, most) if stepper.chooses_steps else None)
    add_counts(run.state, other.state)
    if other.status not in ((Status.FINISHED, Status.BUDGET_SPENT) if stepper.chooses_steps else (Status.FINISHED,)):
        return int(other.status)
    stretch = stretch_of(run, other)
    make_admissible(run, stretch)
    write(run, stretch)
    run.recorder.events += other.recorder.events
    run.stretches, run.handed_over = run.stretches + 1, run.handed_over + float(stretch.rows.t[-1]) - t
    go_on(run, stretch, other.state.P)
    return int(Status.FINISHED if stretch.rows.t[-1] == run.schedule.t[-1] else Status.RUNNING)


def begin_stretch(run: HandingRun, stepper: Integrator, t: float, t_end: float) -> Run:
    """A run of the other integrator from the state and the modes of this one."""
    within = run.schedule.t[(run.schedule.t > t) & (run.schedule.t < t_end)]
    nodes = np.arange(t, t_end, stepper.dt) if isinstance(stepper, FixedStep) else [t]
    times = np.unique(np.concatenate((nodes, within, [t_end])))
    every = 0 if isinstance(stepper, FixedStep) else min(int(run.schedule.every), 1)
    table = Timetable(stepper, listed(times), every)
    other = Run(run.system, stepper, table, run.state.q.copy(), run.state.u.copy(), run.selection, project=False)
    other.state.mode[:], other.state.slip[:] = run.state.mode, run.state.slip
    if run.record.steps.is_kept:
        other.keep_steps()
    return other


def add_counts(mine: State, its: State) -> None:
    """What the other integrator counted, and its worst figures."""
    for name in ADDED:
        setattr(mine.counters, name, getattr(mine.counters, name) + getattr(its.counters, name))
    mine.counters.failed_contact = its.counters.failed_contact
    np.maximum(numbers(mine.worst), numbers(its.worst), out=numbers(mine.worst))


def stretch_of(run: HandingRun, other: Run) -> Stretch:
    """The rows of the other run, the state that it has come to as the last, and its motion."""
    rows = other.recorder.records(other)
    if rows.t[-1] < other.time():
        rows = Columns(*map(np.concatenate, zip(rows, other.present_row(), strict=True)))
    if not run.record.steps.is_kept:
        return Stretch(rows, ())
    if isinstance(other.integrator, FixedStep):
        return Stretch(rows, motion_between(other.integrator, rows, other.recorder.event_rows()).steps)
    return Stretch(rows, tuple(map(np.concatenate, zip(*other.recorder.steps, strict=True))))


def make_admissible(run: HandingRun, stretch: Stretch) -> None:
    """Move the end to the nearest admissible positions; in the motion the last step does it, by 6 theta (1 - theta)."""
    rows = stretch.rows
    q, u = rows.q[-1].copy(), rows.u[-1]
    q_1, _ = project_state(run.system, float(rows.t[-1]), q, u)
    if stretch.steps and len(stretch.steps[0]):
        _, h, _, _, B = stretch.steps
        bulge = 6.0 * (q_1 - q) / h[-1]
        B[-1, 0] += bulge
        B[-1, 1] -= bulge
    rows.q[-1] = q_1


def write(run: HandingRun, stretch: Stretch) -> None:
    """The rows that were asked for: all, the last, or those at the record times; impulses and works go on from those of
    the run, forces are the mean of a step."""
    rows, state, every = stretch.rows, run.state, int(run.schedule.every)
    dt = np.diff(rows.t)
    la = np.zeros((len(rows.t), run.system.n_c, 2))
    lasts = dt > 0.0  # no jump of the velocities
    la[1:, :, : rows.P.shape[2]][lasts] = rows.P[1:][lasts] / dt[lasts, None, None]
    rows = rows._replace(P=rows.P.copy(), ledger=rows.ledger + state.ledger, la=la)
    rows.P[0] += state.P_sum
    state.ledger[:] = rows.ledger[-1]
    chosen = np.arange(len(rows.t))[1 if every == 1 else -1 :]
    if every == 0:
        chosen = np.flatnonzero(np.isin(rows.t, run.schedule.t[run.record.counts.next :]))
        run.record.counts.next += len(chosen)
    taken, rest = impulses_between(rows.P, chosen)
    state.P_sum[:] = rest
    run.recorder.rows.append(Columns(*(column[chosen] for column in rows))._replace(P=taken))
    if stretch.steps:
        run.recorder.steps.append(stretch.steps)


def impulses_between(P: np.ndarray, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The impulses (k, n_c, 1 + d) from one chosen row to the next, and those behind the last of them."""
    ends = np.split(P, chosen + 1)
    sums = [part.sum(axis=0) for part in ends]
    return np.array(sums[:-1]).reshape(-1, *P.shape[1:]), sums[-1]


def go_on(run: HandingRun, stretch: Stretch, P: np.ndarray) -> None:
    """Follow events again from the end of a stretch, whose last step had the impulses P (n_c, 1 + d)."""
    state, rows = run.state, stretch.rows
    state.now, state.P[:] = rows.t[-1], P
    for name in ("q", "u", "g_N", "mode", "slip"):
        getattr(state, name)[:] = getattr(rows, name)[-1]
    cast(EventDriven, run.integrator).resume(state, run.memory)
    run.follows_since = float(rows.t[-1])
