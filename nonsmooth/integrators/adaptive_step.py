"""One adaptive step: plain steps of Moreau–Jean with 1, 2, 3, ... substeps, extrapolated where the motion is smooth.

    T_j = T + c_2 (H/j)^2 + c_3 (H/j)^3 + ...        (theta = 1/2, no event within H)

1. Every substep has the modes of the accepted step before, no gap has fallen below its tolerance on the way, and a
   short probe from the end has these modes too: the extrapolated value is accepted once it differs from the one of an
   order less by no more than the tolerance.
2. One of the first two rows saw an event: two substeps are accepted if one agrees with them. A contact may only land
   from a gap that is closed, so that its impact is in time: the steps before it lead there (adaptive_gaps.py).
3. An event that only a deeper row, a gap or the probe saw lies where the first rows cannot measure it: the step is cut.

Order and step of the smooth rows are those of least work for the length. Source: Studer, Leine, Glocker, *Int. J.
Numer. Meth. Engng* 76 (2008) 1747; Hairer, Norsett, Wanner, *Solving Ordinary Differential Equations I* (1993), II.9.
"""

from __future__ import annotations

import math

from nonsmooth.blocks import address, view
from nonsmooth.errors import Status
from nonsmooth.integrators.adaptive_gaps import closed_gap, first_landing, next_landing, observe
from nonsmooth.integrators.adaptive_polynomial import FIRST_1, note_slopes
from nonsmooth.integrators.adaptive_state import ROW, ROWS, RTOL, TARGET, Extrapolation
from nonsmooth.integrators.adaptive_substep import RETAKE, substep
from nonsmooth.integrators.records import FORCE_WORK, GAIN, GAINS, N_EVENTS, N_LEDGER, State
from nonsmooth.integrators.rigid_hold import hold
from nonsmooth.jit import kernel
from nonsmooth.system import BILATERAL, GIVEN_FORCE, UNILATERAL, ContactMode

# How a step that was tried ended.
REFUSED, SMOOTH, EVENT = range(3)
# What the rows of a step saw: no event; an event in the second substep; one in the first, whose time is not known
# better than the step; a landing from where the gap was closed; a landing from above, which comes too early.
NOTHING, LATER, AT_ONCE, LANDED, EARLY = range(5)
SHRINK = 0.3  # of a step that holds an event which it cannot resolve
FASTEST, SLOWEST = 4.0, 0.1  # bounds of the change of a step
SAFETY = 0.8
HIDDEN = 0.1  # of the tolerances of the positions: a change of the velocities in the time of such a move is a jump
PROBE = 1e-3  # of the step: how far beyond its end the modes are looked at


@kernel("Tuple((int64, int64, float64))(int64, float64[::1], float64, float64, int64, int64)", short_loops=True)
def try_step(model, p, t, H, state_at, run_at):
    """Try one step of length H: (Status, how it ended, what to multiply H by). ``run.change`` is what it changes."""
    state, run = view(state_at, State), view(run_at, Extrapolation)
    target = run.counters[TARGET]
    event = NOTHING
    for j in range(ROWS):
        status, seen = fill_row(model, p, t, H, j, state, run)
        if status != Status.RUNNING:
            return status, REFUSED, SHRINK
        if seen == EARLY:
            return Status.RUNNING.value, REFUSED, shorter(next_landing(state, run) / H)
        if seen != NOTHING and j >= 2:
            return Status.RUNNING.value, REFUSED, SHRINK
        event = max(event, seen)
        if j == 0:
            continue
        if event != NOTHING:
            return judge_event(model, p, t, H, event, state, run)
        extrapolate(j, state, run)
        if run.errors[j] <= 1.0:
            status, part = check_end(model, p, t, H, state, run)
            if status != Status.RUNNING or part < 1.0:
                return status, REFUSED, shorter(part)
            run.counters[ROW] = j
            return Status.RUNNING.value, SMOOTH, plan(j, run)
        if j == target or (j > 1 and run.errors[j] > run.errors[j - 1]):
            break
    if farthest(state.q.shape[0], run) <= HIDDEN:
        fill_row(model, p, t, H, 1, state, run)
        return judge_event(model, p, t, H, LATER, state, run)
    factor = SAFETY * run.errors[j] ** (-1.0 / (j + 2.0)) if math.isfinite(run.errors[j]) else SLOWEST
    return Status.RUNNING.value, REFUSED, min(SAFETY, max(SLOWEST, factor))


@kernel
def shorter(part):
    """The part of a step to try instead, where a landing is expected; a fixed one if that is no shorter."""
    return part if 0.0 < part < 1.0 - PROBE else SHRINK


@kernel
def fill_row(model, p, t, H, j, state, run):
    """Row j of the table: (Status, what it saw)."""
    trial, kinds = run.trial, run.contacts.kinds
    begin_trial(state, trial)
    dt, n = H / (j + 1), trial.u.shape[0]
    seen = NOTHING
    for k in range(j + 1):
        note_node(k, n, run)
        status = substep(model, p, t + k * dt, dt, address(run))
        for _ in range(kinds.shape[0]):  # slides that share nothing end one after the other
            if status == RETAKE:
                for i in range(n):
                    run.begin_u[k, i] = trial.u[i]
                status = substep(model, p, t + k * dt, dt, address(run))
        if status != Status.RUNNING:
            return status if status != RETAKE else Status.NOT_SOLVED.value, NOTHING
        at_once = NOTHING
        for i in range(kinds.shape[0]):
            if not differs(i, kinds, state, trial):
                continue
            if state.mode[i] == ContactMode.OPEN:
                if run.g_0[i] > closed_gap(i, run):
                    return Status.RUNNING, EARLY
                at_once = LANDED
            at_once = max(at_once, AT_ONCE)
        seen = max(seen, at_once if k == 0 else min(LATER, at_once))
    note_node(j + 1, n, run)
    note_slopes(j, n, run)
    for i in range(n):
        run.a_1[i] = run.slopes[j, FIRST_1, i] / H
    for i in range(kinds.shape[0]):
        run.several[i] = trial.several[i]
    write_change(j, state, run)
    return Status.RUNNING, seen


@kernel
def note_node(k, n, run):
    """Note the state after k substeps of a row."""
    for i in range(n):
        run.node_q[k, i], run.node_u[k, i] = run.trial.q[i], run.trial.u[i]
        if k < ROWS:
            run.begin_u[k, i] = run.trial.u[i]


@kernel
def differs(i, kinds, state, trial):
    """Whether the last substep of contact i followed other equations than the accepted one: its mode, its direction of
    sliding; of a bilateral contact that slides the sign of its force, of a given normal force whether there is one."""
    if trial.mode[i] != state.mode[i] or trial.slip[i] != state.slip[i]:
        return True
    if kinds[i, 0] == GIVEN_FORCE:
        return (trial.P[i, 0] > 0.0) != (state.P[i, 0] > 0.0)
    return kinds[i, 0] == BILATERAL and trial.mode[i] == ContactMode.SLIDE and trial.P[i, 0] * state.P[i, 0] < 0.0


@kernel
def begin_trial(state, trial):
    """The accepted state, to be tried from."""
    for i in range(state.q.shape[0]):
        trial.q[i], trial.u[i] = state.q[i], state.u[i]
    for i in range(state.mode.shape[0]):
        trial.mode[i], trial.slip[i], trial.several[i] = state.mode[i], state.slip[i], state.several[i]
        for k in range(state.P.shape[1]):
            trial.P[i, k] = state.P[i, k]
            trial.P_sum[i, k] = 0.0
    for k in range(N_LEDGER):
        trial.ledger[k] = 0.0
    trial.counters[N_EVENTS], trial.counters[GAINS], trial.worst[GAIN] = 0, 0, 0.0


@kernel
def write_change(j, state, run):
    """The changes over the trial, as a row of the table."""
    trial, table = run.trial, run.table
    n, width = state.q.shape[0], state.P.shape[1]
    for i in range(n):
        table[j, i] = trial.q[i] - state.q[i]
        table[j, n + i] = trial.u[i] - state.u[i]
    end = 2 * n
    for i in range(state.mode.shape[0]):
        for k in range(width):
            table[j, end + k] = trial.P_sum[i, k]
        end += width
    for k in range(N_LEDGER):
        table[j, end + k] = trial.ledger[k]


@kernel
def extrapolate(j, state, run):
    """run.change from the rows 0..j, and errors[j], its distance in tolerances from that of the rows 1..j."""
    table, weights, tol = run.table, run.weights, run.tol
    error = 0.0
    for i in range(run.change.shape[0]):
        best, other = 0.0, 0.0
        for k in range(j + 1):
            best += weights[0, j, k] * table[k, i]
            other += weights[1, j, k] * table[k, i]
        run.change[i] = best
        if i < tol.shape[0]:
            error = max(error, abs(best - other) / (tol[i] + run.clock[RTOL] * abs(best)))
    run.errors[j] = error


@kernel
def plan(j, run):
    """The factor of the next step after convergence at row j: so that the next one converges at the row aimed at."""
    target = run.counters[TARGET]
    if j < target - 1:
        return FASTEST
    if not run.errors[j] > 0.0:
        return FASTEST
    aim = 0.5 if j == target else 1.0 / SAFETY
    return min(FASTEST, max(SLOWEST, SAFETY * (aim / run.errors[j]) ** (1.0 / (j + 2.0))))


@kernel
def judge_event(model, p, t, H, event, state, run):
    """Accept two substeps with an event if one agrees with them: (Status, how it ended, factor of the next step).

    An event in the first substep may have come at any time in it, and one and two substeps agree. What it changes, to
    first order, is the change of the velocities beyond the acceleration before it. The time of a landing is known.
    Where no position moves by its tolerance, one substep and two may differ on whether a jump has come yet.
    """
    table, tol, n = run.table, run.tol, state.q.shape[0]
    error = 0.0
    for i in range(n):
        in_q, in_u = abs(table[1, i] - table[0, i]), abs(table[1, n + i] - table[0, n + i])
        if event == AT_ONCE:
            beyond = abs(table[1, n + i] - H * run.a_0[i])
            in_q, in_u = max(in_q, H * beyond), max(in_u, beyond)
        q_size = max(abs(table[0, i]), abs(table[1, i]))
        u_size = max(abs(table[0, n + i]), abs(table[1, n + i]))
        error = max(error, in_q / (tol[i] + run.clock[RTOL] * q_size))
        error = max(error, in_u / (tol[n + i] + run.clock[RTOL] * u_size))
    if not (error <= 1.0 or farthest(n, run) <= 1.0):
        return Status.RUNNING.value, REFUSED, SHRINK
    for i in range(run.change.shape[0]):
        run.change[i] = table[1, i]
    status, is_good = hold_event(model, p, t + H, state, run)
    for i in range(state.mode.shape[0]):
        run.contacts.mode[i] = state.mode[i]
        run.a_N[i] = 0.0
    if not is_good:
        return status, REFUSED, SHRINK
    return status, EVENT, FASTEST


@kernel
def hold_event(model, p, t_1, state, run):
    """Move the end of a step with an event onto the constraints of its modes, but for contacts that part.

    Returns (Status, whether no gap has fallen).
    """
    contacts, trial, x, n = run.contacts, run.trial, run.x, state.q.shape[0]
    for i in range(n):
        x[i], x[n + i] = trial.q[i], trial.u[i]
    if state.mode.shape[0] == 0:
        return Status.RUNNING.value, True
    if not observe(model, p, t_1, x, run.g_1, run.gamma_1, run):
        return Status.NOT_FINITE.value, False
    for i in range(state.mode.shape[0]):
        is_unilateral = contacts.kinds[i, 0] == UNILATERAL
        if is_unilateral and run.g_1[i] < min(0.0, run.g_0[i]) - closed_gap(i, run):
            return Status.RUNNING.value, False
        parts = is_unilateral and run.gamma_1[i] > run.tol_gamma[i]
        contacts.mode[i] = ContactMode.OPEN.value if parts else trial.mode[i]
    status = hold(model, p, t_1, x, False, contacts)
    if status != Status.RUNNING:
        return status, False
    book_hold(n, state, run)
    is_finite = observe(model, p, t_1, x, run.g_1, run.gamma_1, run)
    return Status.RUNNING.value if is_finite else Status.NOT_FINITE.value, is_finite


@kernel
def farthest(n, run):
    """The largest change of a coordinate in the first two rows, in tolerances."""
    largest = 0.0
    for i in range(n):
        largest = max(largest, abs(run.table[0, i]) / run.tol[i], abs(run.table[1, i]) / run.tol[i])
    return largest


@kernel
def check_end(model, p, t, H, state, run):
    """Move the end of a smooth step onto its constraints: (Status, the part of the step free of events, 1.0 if all).

    No gap may have fallen below its surface, and a short step from the end must have the modes of the step.
    """
    contacts, trial, x = run.contacts, run.trial, run.x
    n, n_c = state.q.shape[0], state.mode.shape[0]
    for i in range(n):
        x[i] = state.q[i] + run.change[i]
        x[n + i] = state.u[i] + run.change[n + i]
    if n_c == 0:
        return Status.RUNNING, 1.0
    status = hold(model, p, t + H, x, False, contacts)
    if status != Status.RUNNING:
        return status, SHRINK
    book_hold(n, state, run)
    if not observe(model, p, t + H, x, run.g_1, run.gamma_1, run):
        return Status.NOT_FINITE, SHRINK
    landing = first_landing(H, state, run)
    if landing <= 1.0:
        return Status.RUNNING, landing
    is_active = False
    for i in range(n_c):
        is_active = is_active or state.mode[i] != ContactMode.OPEN
        run.a_N[i] = (run.gamma_1[i] - run.gamma_0[i]) / H
    if not is_active:
        return Status.RUNNING, 1.0
    for i in range(n):
        trial.q[i], trial.u[i] = x[i], x[n + i]
    n_events = trial.counters[N_EVENTS]
    status = substep(model, p, t + H, PROBE * H, address(run))
    if status == RETAKE:
        return Status.RUNNING, SHRINK
    trial.counters[N_EVENTS] = n_events
    if is_harmless(H, n, run):
        return status, 1.0
    for i in range(n_c):
        if state.mode[i] != ContactMode.OPEN and differs(i, contacts.kinds, state, trial):
            return status, SHRINK
    return status, 1.0


@kernel
def is_harmless(H, n, run):
    """Whether the acceleration of the probe is that of the step, whatever its modes are: over the step, the difference
    changes the velocities by less than their tolerances. So it is where redundant contacts share a load at rest."""
    for i in range(n):
        difference = (run.trial.u[i] - run.x[n + i]) / PROBE - H * run.a_1[i]
        if not abs(difference) <= run.tol[n + i]:
            return False
    return True


@kernel
def book_hold(n, state, run):
    """Count what the move onto the constraints changed, the work of the forces over it included."""
    x, change = run.x, run.change
    works = change.shape[0] - N_LEDGER
    for i in range(n):
        moved = x[i] - state.q[i] - change[i]
        change[works + FORCE_WORK] += run.contacts.work.h[i] * moved
