"""The loop of an adaptive run: try a step, accept it, write rows and events, choose the next length.

The step is that of adaptive_step.py.
"""

from __future__ import annotations

from nonsmooth.blocks import view
from nonsmooth.errors import Status
from nonsmooth.integrators.adaptive_gaps import observe, set_tolerances
from nonsmooth.integrators.adaptive_polynomial import PIECES, keep_event, keep_smooth
from nonsmooth.integrators.adaptive_state import (
    FIRST_STEP,
    IS_FIRST,
    LEAST,
    NOW,
    REJECTED,
    ROW,
    STEP,
    Extrapolation,
)
from nonsmooth.integrators.adaptive_step import EVENT, REFUSED, try_step
from nonsmooth.integrators.penalty_loop import NEXT, ROWS, Trail, write_row
from nonsmooth.integrators.radau import SMALLEST
from nonsmooth.integrators.records import (
    EVENT_WIDTH,
    EVENTS_LOST,
    FAILED_CONTACT,
    GAIN,
    GAINS,
    KEPT,
    LEDGER_ERROR,
    N_EVENTS,
    N_LEDGER,
    PENETRATION,
    PIVOTS,
    RESIDUAL,
    SEVERAL,
    SHARED,
    SKIPPED,
    SOLVED,
    STEPS,
    UNCOUNTED,
    State,
)
from nonsmooth.integrators.rigid_modes import HAS, N_WORKS
from nonsmooth.integrators.step_polynomial import IS_KEPT, N_STEPS
from nonsmooth.jit import kernel
from nonsmooth.system import GAP, UNILATERAL, ContactMode

SUMMED = (SOLVED, SKIPPED, KEPT, PIVOTS, SEVERAL, UNCOUNTED, SHARED)


@kernel("int64(int64, float64[::1], float64[::1], int64, int64, int64, int64, int64)", short_loops=True)
def run(model, p, t_record, every, max_steps, state_at, trail_at, run_at):
    """Try at most max_steps steps; returns a Status.

    Rows are written every so many steps and at every event, or, where every = 0, at the times t_record, at which
    steps end. The last of these is the end.
    """
    state, trail, run = view(state_at, State), view(trail_at, Trail), view(run_at, Extrapolation)
    clock, counters, end = run.clock, run.counters, t_record.shape[0] - 1
    run.step.is_known[0] = 0
    run.step.is_known[1] = 0
    if state.counters[STEPS] == 0 and trail.counts[NEXT] == 0:
        if not begin(model, p, state, run):
            return Status.NOT_FINITE.value
        write_state(clock[NOW], state, run, trail)
        trail.counts[NEXT] = 1
    for _ in range(max_steps):
        t = clock[NOW]
        clock[LEAST] = SMALLEST * max(abs(t), FIRST_STEP * (t_record[end] - t_record[0]))
        if t >= t_record[end]:
            return Status.FINISHED.value
        if every > 0 and trail.counts[ROWS] >= trail.t.shape[0]:
            return Status.RUNNING.value  # the rows, or the events, are full: the caller empties them
        if state.counters[N_EVENTS] + run.trial.events.shape[0] > state.events.shape[0]:
            return Status.RUNNING.value
        stop = t_record[trail.counts[NEXT]] if every == 0 else t_record[end]
        if trail.steps.counts[IS_KEPT] != 0 and trail.steps.counts[N_STEPS] + PIECES > trail.steps.t.shape[0]:
            return Status.RUNNING.value
        H, is_last = clock[STEP], False
        if t + H >= stop - clock[LEAST]:
            H, is_last = stop - t, True
        set_tolerances(run)
        counters[IS_FIRST] = 1 if state.counters[STEPS] == 0 else 0
        status, outcome, factor = try_step(model, p, t, H, state_at, run_at)
        collect(state, run.trial)
        if outcome == REFUSED:
            counters[REJECTED] += 1
            clock[STEP] = factor * H
            if clock[STEP] < clock[LEAST]:
                return status if status != Status.RUNNING else Status.STEP_VANISHED.value
            continue
        t_1 = stop if is_last else t + H
        if trail.steps.counts[IS_KEPT] != 0:
            if outcome == EVENT:
                keep_event(t, H, state, run, trail.steps)
            else:
                keep_smooth(t, H, counters[ROW], state, run, trail.steps)
        has_changed = accept(t_1, outcome == EVENT, state, run)
        clock[STEP] = max(clock[STEP], factor * H) if is_last else factor * H
        if is_last and every == 0:
            trail.counts[NEXT] += 1
        if (is_last and every == 0) or (every > 0 and (state.counters[STEPS] % every == 0 or has_changed or is_last)):
            write_state(t_1, state, run, trail)
    return Status.RUNNING.value


@kernel
def begin(model, p, state, run):
    """Gaps and scales at the start; False if a model function raised."""
    n = state.q.shape[0]
    for i in range(n):
        run.x[i], run.x[n + i] = state.q[i], state.u[i]
    if not observe(model, p, run.clock[NOW], run.x, run.g_1, run.gamma_1, run):
        return False
    for i in range(state.mode.shape[0]):
        state.mode[i], state.slip[i] = run.contacts.mode[i], run.contacts.slip[i]
    remember(n, run)
    return True


@kernel
def remember(n, run):
    """The end of a step as the beginning of the next."""
    for i in range(2 * n):
        run.largest[i] = max(run.largest[i], abs(run.x[i]))
    for i in range(run.g_0.shape[0]):
        run.g_0[i], run.gamma_0[i] = run.g_1[i], run.gamma_1[i]


@kernel
def accept(t_1, has_event, state, run):
    """Move to the end of the step, run.x, with its impulses, works, modes and events; whether a mode changed.

    A contact that parts at the end, of an impact in the last substep, is open.
    """
    contacts, trial, change = run.contacts, run.trial, run.change
    n, n_c, width = state.q.shape[0], state.mode.shape[0], state.P.shape[1]
    for i in range(n):
        state.q[i], state.u[i] = run.x[i], run.x[n + i]
        run.a_0[i] = run.a_1[i]
    end = 2 * n
    has_changed = False
    for i in range(n_c):
        if has_event:
            has_changed = has_changed or trial.mode[i] != state.mode[i] or trial.slip[i] != state.slip[i]
            parts = contacts.kinds[i, 0] == UNILATERAL and run.gamma_1[i] > run.tol_gamma[i]
            state.mode[i] = ContactMode.OPEN.value if parts else trial.mode[i]
            state.slip[i] = 0 if parts else trial.slip[i]
            contacts.mode[i], contacts.slip[i] = state.mode[i], state.slip[i]
        state.several[i] = run.several[i]
        for k in range(width):
            state.P[i, k] = trial.P[i, k]
            state.P_sum[i, k] += change[end + k]
        end += width
        if contacts.kinds[i, 0] == UNILATERAL:
            state.worst[PENETRATION] = max(state.worst[PENETRATION], -run.g_1[i])
    for k in range(N_LEDGER):
        state.ledger[k] += change[end + k]
    keep_events(state, run)
    remember(n, run)
    state.counters[STEPS] += 1
    state.counters[GAINS] += trial.counters[GAINS]
    state.worst[GAIN] = max(state.worst[GAIN], trial.worst[GAIN])
    run.clock[NOW] = t_1
    return has_changed


@kernel
def keep_events(state, run):
    """Append the events of the accepted row."""
    trial = run.trial
    m = state.counters[N_EVENTS]
    for e in range(trial.counters[N_EVENTS]):
        for k in range(EVENT_WIDTH):
            state.events[m, k] = trial.events[e, k]
        m += 1
    state.counters[N_EVENTS] = m


@kernel
def collect(state, trial):
    """Add what the substeps counted, and their worst figures."""
    for which in SUMMED:
        state.counters[which] += trial.counters[which]
        trial.counters[which] = 0
    state.counters[EVENTS_LOST] = trial.counters[EVENTS_LOST]
    state.counters[FAILED_CONTACT] = trial.counters[FAILED_CONTACT]
    state.worst[RESIDUAL] = max(state.worst[RESIDUAL], trial.worst[RESIDUAL])
    state.worst[LEDGER_ERROR] = max(state.worst[LEDGER_ERROR], trial.worst[LEDGER_ERROR])


@kernel
def write_state(t, state, run, trail):
    """Append a row: the state, the gaps, the impulses and works since the start."""
    x, n, n_c = run.x, state.q.shape[0], state.mode.shape[0]
    has_gap = run.contacts.facts[HAS] & (1 << GAP)
    for i in range(n):
        x[i], x[n + i] = state.q[i], state.u[i]
    end = 2 * n
    for i in range(n_c):
        x[end + i] = run.g_0[i] if has_gap else 0.0
        x[end + n_c + i] = state.P_sum[i, 0]
        x[end + 2 * n_c + i] = state.P_sum[i, 1] if state.P_sum.shape[1] > 1 else 0.0
    for k in range(N_WORKS):
        x[end + 3 * n_c + k] = state.ledger[k]
    write_row(t, x, run.contacts, trail)
