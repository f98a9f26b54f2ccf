"""A stretch of an event-driven run that another integrator takes over, because its events are too many to be followed.

It begins with the state and the modes of the run and takes its own steps; at the end of the stretch the state is moved
to the nearest admissible one and the contacts get their modes anew. Within the stretch the error is that of the other
integrator: of MoreauJean of first order in its dt, of Adaptive its tolerance.

Where too many contacts touch to decide, and again soon behind a stretch, the next one is twice as long: a stretch
begins with small steps, and where nothing but stepping helps, some ten stretches reach the end.
"""

from __future__ import annotations

import time
import warnings
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.errors import InitialStateWarning, Status
from nonsmooth.integrators.event_driven.touch import AT_RESUMPTION
from nonsmooth.integrators.records import EVENT_CONTACT, EVENT_T, N_WORKS, Columns
from nonsmooth.jit.blocks import numbers
from nonsmooth.mechanics.initial_state import project_state
from nonsmooth.results.solution import Solution
from nonsmooth.runs.event_run import EventRun
from nonsmooth.runs.extrapolation_run import ExtrapolationRun
from nonsmooth.runs.run import Run, motion_of_records
from nonsmooth.runs.times import Grid

STRETCH_PART = 1e-4  # chosen: of the span: what stands for the step of an integrator that chooses its steps
STRETCH_STEPS = 50  # chosen: steps of the time stepper until events are followed again
MOST_STEPS = 1000  # chosen: and of an integrator that chooses them; both are doubled where a stretch does not help
MOST_DOUBLINGS = 6  # chosen: so that of an integrator that chooses its steps ten stretches are the whole span
MANY_EVENTS = 100  # chosen: events within one of its steps
# chosen: steps between two looks at the events: the same ones on a fast machine as on a slow one
STEPS_BETWEEN_LOOKS = 100
GIVEN_UP = (Status.CHATTERING, Status.NOT_SOLVED)
ADDED = ("steps", "solved", "skipped", "kept", "pivots", "several", "gains")


class HandingRun(EventRun):
    """One integration in progress, of an integrator that hands over to another one (``hand_over``)."""

    def _block(self, max_steps: int) -> int:
        """A block, and where its events are too dense a stretch of another integrator."""
        stepper = self.integrator.hand_over
        steps_left = self.budget - int(self.state.counters.steps)
        status = super()._block(max(1, min(STEPS_BETWEEN_LOOKS, steps_left)))  # whatever the clock says
        if status in GIVEN_UP or (status == Status.RUNNING and are_dense(self._recent_events(), unit(self, stepper))):
            return step_over(self, stepper, status)
        return status

    def _recent_events(self) -> np.ndarray:
        """The last events (MANY_EVENTS, EVENT_WIDTH) since events are followed."""
        new = self.state.events[: int(self.state.counters.n_events)]
        rows = np.concatenate((*self.events[-MANY_EVENTS:], new))[-MANY_EVENTS:]
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
    """What the other integrator did, in m rows; the states x hold impulses and works since the start of the run."""

    t: np.ndarray  # (m,)
    x: np.ndarray  # (m, N)
    mode: np.ndarray  # (m, c)
    slip: np.ndarray  # (m, c)
    steps: tuple[np.ndarray, ...]  # of the motion, t, h, q, u, B; none where they are not kept


def unit(run: EventRun, stepper: Any) -> float:
    """The time [s] within which many events are too dense: a step of the time stepper."""
    dt = getattr(stepper, "dt", None)
    return STRETCH_PART * float(run.t_record[-1] - run.t_record[0]) if dt is None else dt


def longest(run: EventRun, stepper: Any) -> float:
    """The time [s] that a stretch may take."""
    return STRETCH_STEPS * unit(run, stepper) * 2.0**run.doublings


def are_dense(recent: np.ndarray, dt: float) -> bool:
    """Whether the recent events (m, EVENT_WIDTH), of several contacts, are many within dt [s].

    Those of one contact that accumulate are closed by the integrator itself.
    """
    times, contacts = recent[:, EVENT_T], recent[:, EVENT_CONTACT]
    return len(recent) >= MANY_EVENTS and times.max() - times.min() < dt and len(np.unique(contacts)) > 1


def step_over(run: EventRun, stepper: Any, why: int) -> int:
    """Step from the state of the run over a stretch, and put the run behind it; returns a Status."""
    t = run._time()
    is_stuck = why == Status.NOT_SOLVED and t - run.follows_since < longest(run, stepper)
    run.doublings = min(run.doublings + 1, MOST_DOUBLINGS) if is_stuck else 0
    t_end = min(t + longest(run, stepper), float(run.t_record[-1]))
    x = run.scratch.ode.x.copy()
    take = by_chosen_steps if getattr(stepper, "chooses_steps", False) else by_equal_steps
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", InitialStateWarning)
        other, stretch = take(run, stepper, t, t_end, x)
    for name in ADDED:
        setattr(run.state.counters, name, getattr(run.state.counters, name) + getattr(other.state.counters, name))
    run.state.counters.failed_contact = other.state.counters.failed_contact
    np.maximum(numbers(run.state.worst), numbers(other.state.worst), out=numbers(run.state.worst))
    if stretch is None:
        return other.status
    make_admissible(run, stretch)
    write(run, stretch)
    if run.keeps_steps:
        run.steps.append(stretch.steps)
    run.events += other.events
    run.stretches, run.handed_over = run.stretches + 1, run.handed_over + float(stretch.t[-1]) - t
    go_on(run, stretch, other.state.P[:, 0])
    return Status.FINISHED if stretch.t[-1] == run.t_record[-1] else Status.RUNNING


def by_equal_steps(run: EventRun, stepper: Any, t: float, t_end: float, x: np.ndarray) -> tuple[Run, Stretch | None]:
    """The stretch by a time stepper; None where it failed."""
    system, contacts, n = run.system, run.scratch.contacts, run.system.n_u
    times = np.unique(np.concatenate((np.arange(t, t_end, stepper.dt), asked(run, t, t_end), [t_end])))
    grid = Grid(times, *stepper.steps_between(times))
    steps = Run(system, stepper, grid, x[:n], x[n : 2 * n], int(contacts.facts.selection), project=False)
    steps.state.mode[:], steps.state.slip[:] = contacts.mode, contacts.slip
    steps.advance(None, None)
    if steps.status != Status.FINISHED:
        return steps, None
    record = Columns(*steps.record)
    rows = np.concatenate((*steps.events, steps.state.events[:0]))
    motion = motion_of_records(times, record, rows, stepper).steps if run.keeps_steps else ()
    return steps, Stretch(times, states_of(record, x, system.n_c), record.mode, record.slip, motion)


def by_chosen_steps(run: EventRun, stepper: Any, t: float, t_end: float, x: np.ndarray) -> tuple[Run, Stretch | None]:
    """The stretch by an integrator that chooses its steps, as far as it comes in its steps; None where it failed."""
    contacts, n = run.scratch.contacts, run.system.n_u
    times = np.unique(np.concatenate(([t], asked(run, t, t_end), [t_end])))
    start, selection = (x[:n].copy(), x[n : 2 * n].copy()), int(contacts.facts.selection)
    steps = ExtrapolationRun(run.system, stepper, times, min(run.every, 1), *start, selection, project=False)
    if run.keeps_steps:
        steps.keep_steps()
    stepper.begin(steps.scratch, contacts.mode, contacts.slip, selection)
    most = min(MOST_STEPS << run.doublings, run.budget - int(run.state.counters.steps))
    steps.advance(max(0.0, run.deadline - time.perf_counter()), None, max(1, most))
    mine, its = run.scratch.ode.counters, steps.scratch.counters
    mine.rejected += its.rejected
    mine.evaluations += its.substeps
    if steps.status not in (Status.FINISHED, Status.BUDGET_SPENT):
        return steps, None
    t_rows, x_rows, mode, slip = steps.rows_to_now()
    x_rows[:, 2 * n + run.system.n_c :] += x[2 * n + run.system.n_c :]
    motion = tuple(map(np.concatenate, zip(*steps.steps, strict=True)))
    return steps, Stretch(t_rows, x_rows, mode, slip, motion)


def make_admissible(run: EventRun, stretch: Stretch) -> None:
    """Move the end to the nearest admissible positions; in the motion the last step does it, by 6 theta (1 - theta)."""
    n, q, u = run.system.n_u, *np.split(stretch.x[-1, : 2 * run.system.n_u], 2)
    q_1, _ = project_state(run.system, float(stretch.t[-1]), q, u)
    if stretch.steps and len(stretch.steps[0]):
        _, h, _, _, B = stretch.steps
        bulge = 6.0 * (q_1 - q) / h[-1]
        B[-1, 0] += bulge
        B[-1, 1] -= bulge
    stretch.x[-1, :n] = q_1


def asked(run: EventRun, t: float, t_end: float) -> np.ndarray:
    """The record times within the stretch."""
    return run.t_record[(run.t_record > t) & (run.t_record < t_end)]


def states_of(record: Columns, x: np.ndarray, n_c: int) -> np.ndarray:
    """The records as states (m, N) of the run, which stood at x: q, u, gaps, impulses and works since its start."""
    P = np.cumsum(record.P, axis=0)
    P_F = P[:, :, 1] if P.shape[2] > 1 else np.zeros((len(P), n_c))
    works = record.ledger[:, :N_WORKS]
    n_state = record.q.shape[1] + record.u.shape[1]
    since = np.concatenate((P[:, :, 0], P_F, works), axis=1) + x[n_state + n_c :]
    return np.concatenate((record.q, record.u, record.g_N, since), axis=1)


def write(run: EventRun, stretch: Stretch) -> None:
    """The rows that were asked for: all, the last, or those at the record times; forces are the mean of a step."""
    n, n_c = run.system.n_u, run.system.n_c
    P = stretch.x[:, 2 * n + n_c : 2 * n + 3 * n_c].reshape(-1, 2, n_c).transpose(0, 2, 1)
    la = np.zeros_like(P)
    lasts = np.diff(stretch.t) > 0.0  # no jump of the velocities
    la[1:][lasts] = np.diff(P, axis=0)[lasts] / np.diff(stretch.t)[lasts, None, None]
    columns = (stretch.t, stretch.x, la, stretch.mode, stretch.slip)
    if run.every > 0:
        chosen = slice(1, None) if run.every == 1 else slice(-1, None)
        run.rows.append(tuple(column[chosen].copy() for column in columns))
        return
    counts, _, *trail = run.trail
    for k in np.flatnonzero(np.isin(stretch.t, run.t_record[counts.next :])):
        for target, column in zip(trail, columns, strict=True):
            target[counts.rows] = column[k]
        counts.rows += 1
        counts.next += 1


def go_on(run: EventRun, stretch: Stretch, P_N: np.ndarray) -> None:
    """Follow events again from the end of a stretch, where the normal impulses were P_N (n_c,)."""
    arrays, n = run.scratch, run.system.n_u
    contacts = arrays.contacts
    arrays.ode.x[:], arrays.ode.clock.now = stretch.x[-1], stretch.t[-1]
    run.state.q[:], run.state.u[:] = stretch.x[-1, :n], stretch.x[-1, n : 2 * n]
    contacts.mode[:], contacts.slip[:] = stretch.mode[-1], stretch.slip[-1]
    contacts.sign[:] = np.where(P_N < 0.0, -1, 1)
    contacts.facts.event = AT_RESUMPTION
    run.follows_since = float(stretch.t[-1])
    run.trail.counts.stalls = 0
