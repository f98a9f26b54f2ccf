"""Blocks of steps in which events of the user are looked for (user_events.py), and how a run ends at one of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from nonsmooth.errors import InvalidInput, Status
from nonsmooth.integrators.radau.method import SMALLEST_STEP
from nonsmooth.integrators.records import EVENT_T, Columns
from nonsmooth.results.motion import Motion, join_motions
from nonsmooth.runs.ongoing import STEPS_PER_VISIT, columns_of, motion_between
from nonsmooth.runs.system_run import SystemRun
from nonsmooth.runs.times import schedule_of
from nonsmooth.runs.user_events import PLACES_OF_STEP, START, EventWatch, Stop

SPAN_LEFT = 0.75 * SMALLEST_STEP  # chosen: of the time: what is left to the end is no step


def watch_of(run: SystemRun, functions: Sequence[Callable]) -> WatchedRecords | WatchedSteps:
    """What looks for the events of a run.

    Raises
    ------
    InvalidInput
        For what is no event function, and where not every fixed step is recorded.
    """
    return WatchedSteps(run, functions) if run.integrator.chooses_steps else WatchedRecords(run, functions)


class WatchedRecords:
    """Of a fixed step: from record to record, each of them a step."""

    def __init__(self, run: SystemRun, functions: Sequence[Callable]) -> None:
        if run.schedule.steps.max(initial=1) > 1:
            raise InvalidInput(
                f"{type(run.integrator).__name__} looks for events from record to record; give events without every= "
                "and t_eval=, so that every step is one"
            )
        self.events = EventWatch(functions, START)

    def block(self, run: SystemRun, max_steps: int) -> int:
        """A block, and the events in it; at a reason to stop the records end there."""
        first = max(0, int(run.record.counts.rows) - 1)
        status = run.block(max_steps)
        rows = slice(first, int(run.record.counts.rows))
        record = Columns(*(column[rows] for column in columns_of(run.record)))
        motion = motion_between(run.system, run.integrator, record, run.state.events[: run.state.counters.n_events])
        stop = self.events.scan(motion, has_ended=status == Status.FINISHED)
        if stop is None:
            return status
        cut(run, motion, stop.t)
        run.stop = stop
        return stop.status


def cut(run: SystemRun, motion: Motion, t: float) -> None:
    """Go back to a time in a step: impulses and works in proportion, of a step with an impact all or nothing."""
    state, record, counters, times = run.state, run.record, run.state.counters, run.schedule.t
    k = max(0, int(np.searchsorted(times, t)) - 1)
    part = (t - times[k]) / (times[k + 1] - times[k])
    nodes = motion.t[(motion.t > times[k]) & (motion.t < times[k + 1])]
    if len(nodes):
        part = float(t >= nodes[0])
    after = k + (part > 0.0)
    state.q[:], state.u[:] = motion(t)
    state.P_sum[:] = part * record.P[k + 1]
    state.ledger[:] = (1.0 - part) * record.ledger[k] + part * record.ledger[k + 1]
    state.mode[:], state.slip[:] = record.mode[after], record.slip[after]
    kept = state.events[: counters.n_events]
    kept = kept[kept[:, EVENT_T] < times[k] + part * (t - times[k])]
    state.events[: len(kept)] = kept
    is_within = t > times[k]
    counters.n_events, counters.interval, record.counts.rows = len(kept), k, k + 1
    counters.step, counters.steps = is_within, k + is_within


class WatchedSteps:
    """Of steps of chosen length: within each of them, whichever are recorded."""

    def __init__(self, run: SystemRun, functions: Sequence[Callable]) -> None:
        self.events = EventWatch(functions, PLACES_OF_STEP)
        run.keep_steps()

    def block(self, run: SystemRun, max_steps: int) -> int:
        """A block, and the events in it; at a reason to stop the block is run anew, to end there."""
        before = run.snapshot()
        n_steps = len(run.recorder.steps)
        status = run.block(max_steps)
        here = (run.now, run.state.q.copy(), run.state.u.copy())
        motion = join_motions(run.recorder.steps[n_steps:], here, here, run.system.kinematics is not None)
        stop = self.events.scan(motion, has_ended=status == Status.FINISHED)
        if stop is not None:
            run.go_back(before)
            end_at(run, stop)
            status = Status.RUNNING
            while status == Status.RUNNING:
                status = run.block(STEPS_PER_VISIT)
                run.recorder.take_events(run)
            run.stop = stop
            status = stop.status if status == Status.FINISHED else status
        if run.schedule.every != 1:
            run.recorder.steps.clear()
        return status


def end_at(run: SystemRun, stop: Stop) -> None:
    """Let the run end at a stop; at an instant later, if the velocities jump there, so that they have jumped."""
    times, every = run.schedule.t, int(run.schedule.every)
    instant = SPAN_LEFT * abs(stop.t) if stop.is_jump and every > 0 else 0.0
    t_end = min(times[-1], stop.t + instant)
    run.schedule = schedule_of(run.integrator, np.append(times[times < t_end], t_end), every, float(run.schedule.span))
