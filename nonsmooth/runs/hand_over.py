"""A stretch of an event-driven run that time stepping takes over, because its events are too many to be followed.

The time stepper begins with the state and the modes of the run and takes its own equal steps; at the end of the stretch
the state is moved to the nearest admissible one and the contacts get their modes anew. Within the stretch the error is
that of the time stepper, of first order in its dt.
"""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.errors import InitialStateWarning, Status
from nonsmooth.initial_state import project_state
from nonsmooth.integrators.compliant_contacts import N_WORKS
from nonsmooth.integrators.penalty_loop import NEXT, ROWS, STALLS
from nonsmooth.integrators.radau_stages import NOW
from nonsmooth.integrators.records import (
    EVENT_CONTACT,
    EVENT_T,
    FAILED_CONTACT,
    GAINS,
    KEPT,
    PIVOTS,
    SEVERAL,
    SKIPPED,
    SOLVED,
    STEPS,
    Record,
)
from nonsmooth.integrators.rigid_modes import EVENT, SELECTION
from nonsmooth.integrators.rigid_touch import RESUME
from nonsmooth.runs.run import Run, between
from nonsmooth.runs.times import Grid

if TYPE_CHECKING:
    from nonsmooth.runs.event_run import EventRun

STRETCH = 50  # steps of the time stepper until events are followed again
MANY = 100  # events within one of its steps
LOOK = 100  # steps between two looks at the events: the same ones on a fast machine as on a slow one
GIVEN_UP = (Status.CHATTERING, Status.NOT_SOLVED)
ADDED = [STEPS, SOLVED, SKIPPED, KEPT, PIVOTS, SEVERAL, GAINS]


def are_dense(recent: np.ndarray, dt: float) -> bool:
    """Whether the recent events (m, EVENT_WIDTH), of several contacts, are many within dt [s].

    Those of one contact that accumulate are closed by the integrator itself.
    """
    times, contacts = recent[:, EVENT_T], recent[:, EVENT_CONTACT]
    return len(recent) >= MANY and times.max() - times.min() < dt and len(np.unique(contacts)) > 1


def step_over(run: EventRun, stepper: Any) -> int:
    """Step from the state of the run over a stretch, and put the run behind it; returns a Status."""
    system, arrays = run.system, run.scratch_block.arrays
    contacts, n = arrays.contacts, run.system.n_u
    t = run._time()
    t_end = min(t + STRETCH * stepper.dt, float(run.t_record[-1]))
    asked = run.t_record[(run.t_record > t) & (run.t_record < t_end)]
    times = np.unique(np.concatenate((np.arange(t, t_end, stepper.dt), asked, [t_end])))
    grid = Grid(times, *stepper.steps_between(times))
    x = arrays.ode.x
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", InitialStateWarning)
        steps = Run(system, stepper, grid, x[:n], x[n : 2 * n], int(contacts.facts[SELECTION]), project=False)
    steps.state.mode[:], steps.state.slip[:] = contacts.mode, contacts.slip
    steps.advance(None, None)
    run.state.counters[ADDED] += steps.state.counters[ADDED]
    run.state.counters[FAILED_CONTACT] = steps.state.counters[FAILED_CONTACT]
    run.state.worst[:] = np.maximum(run.state.worst, steps.state.worst)
    if steps.status != Status.FINISHED:
        return steps.status
    record = steps.record
    record.q[-1], _ = project_state(system, t_end, record.q[-1], record.u[-1])
    states = states_of(record, x, system.n_c)
    write(run, times, states, record)
    if run.keeps_steps:
        rows = np.concatenate((*steps.events, steps.state.events[:0]))
        run.steps.append(between(times, record, rows, stepper).steps)
    run.events += steps.events
    x[:], arrays.ode.clock[NOW] = states[-1], t_end
    run.state.q[:], run.state.u[:] = record.q[-1], record.u[-1]
    contacts.mode[:], contacts.slip[:] = record.mode[-1], record.slip[-1]
    contacts.sign[:] = np.where(record.P[-1, :, 0] < 0.0, -1, 1)
    contacts.facts[EVENT] = RESUME
    run.follows_since = t_end
    run.trail_block.arrays.counts[STALLS] = 0
    return Status.RUNNING


def states_of(record: Record, x: np.ndarray, n_c: int) -> np.ndarray:
    """The records as states (m, N) of the run, which stood at x: q, u, gaps, impulses and works since its start."""
    P = np.cumsum(record.P, axis=0)
    P_F = P[:, :, 1] if P.shape[2] > 1 else np.zeros((len(P), n_c))
    works = record.ledger[:, :N_WORKS]
    n_state = record.q.shape[1] + record.u.shape[1]
    since = np.concatenate((P[:, :, 0], P_F, works), axis=1) + x[n_state + n_c :]
    return np.concatenate((record.q, record.u, record.g_N, since), axis=1)


def write(run: EventRun, times: np.ndarray, states: np.ndarray, record: Record) -> None:
    """The rows that were asked for: all, the last, or those at the record times."""
    la = np.zeros((len(times), run.system.n_c, 2))
    la[1:, :, : record.P.shape[2]] = record.P[1:] / np.diff(times)[:, None, None]
    columns = (times, states, la, record.mode, record.slip)
    if run.every > 0:
        chosen = slice(1, None) if run.every == 1 else slice(-1, None)
        run.rows.append(tuple(column[chosen].copy() for column in columns))
        return
    counts, _, *trail = run.trail_block.arrays
    for k in np.flatnonzero(np.isin(times, run.t_record[counts[NEXT] :])):
        for target, column in zip(trail, columns, strict=True):
            target[counts[ROWS]] = column[k]
        counts[[ROWS, NEXT]] += 1
