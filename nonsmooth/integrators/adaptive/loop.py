"""The loop of an adaptive run: try a step, accept it, decide on modes at events, write rows, choose the next length.

The step is that of adaptive/step.py, events are those of adaptive/switch.py and adaptive/through.py.

Budget: BUDGET_TRIES tries in which no coordinate has moved by LEAST_WAY tolerances in all, and of the span no more than
LEAST_TIME has passed, end the run. A step that follows a motion moves it by many tolerances, and a stretch at rest is
covered in few steps. So do BUDGET_TRIES tries in which no more than HOPELESS of the span has passed, whatever moved: at
that pace the run would take 2e10 tries, days; and so do those in which the forces jumped more than MOST_JUMPS times and
no more than LEAST_TIME of the span has passed: they drive the motion from both sides to where they jump.
"""

from __future__ import annotations

import math

from nonsmooth.errors import Status
from nonsmooth.integrators.adaptive.events import arm_functions, event_values, only_enters_region, set_bands
from nonsmooth.integrators.adaptive.jumps import keep_forces
from nonsmooth.integrators.adaptive.polynomial import STEP_PIECES, keep_event, keep_smooth
from nonsmooth.integrators.adaptive.scales import evaluate_gaps, length_of_instant, set_tolerances
from nonsmooth.integrators.adaptive.state import (
    DECIDE,
    FIRST_STEP,
    GO_ON,
    GO_THROUGH,
    Extrapolation,
)
from nonsmooth.integrators.adaptive.step import AT_EVENT, AT_ONCE, FAILED_STEP_PART, SMOOTH, UNRESOLVED, try_step
from nonsmooth.integrators.adaptive.switch import EVENTS_AT_INSTANT, decide_modes
from nonsmooth.integrators.adaptive.table import FASTEST
from nonsmooth.integrators.adaptive.through import step_through
from nonsmooth.integrators.contract import LOOP, Schedule
from nonsmooth.integrators.radau.method import SMALLEST_STEP
from nonsmooth.integrators.records import (
    EVENT_WIDTH,
    N_FUNCTIONS,
    N_LEDGER,
    Record,
    State,
    is_full,
    take_together,
    write_row,
)
from nonsmooth.integrators.rigid.census import count_step, enters_region, note_several
from nonsmooth.integrators.rigid.modes import UNIQUE, note_side
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import address, view
from nonsmooth.mechanics.sys import Sys
from nonsmooth.mechanics.system import GAP, UNILATERAL

BUDGET_TRIES = 20_000  # chosen: tries between two looks at the budget
LEAST_WAY = 1_000.0  # chosen: tolerances, over that many tries: one in twenty a try
LEAST_TIME = 1e-3  # chosen: of the span
HOPELESS = 1e-6  # chosen: of the span
MOST_JUMPS = 1_000  # chosen: of the forces, over that many tries: at that pace there would be a million in the span
QUIET_STEP = 100.0  # chosen: instants: a step that is longer ends a series of events
TWICE = 2.0  # chosen: the way to an event as a straight line has it: the step that looks for it ends behind it
FIRST_THROUGH = 4.0  # chosen: instants: the first plain steps where no modes last


@kernel(LOOP, short_loops=True)
def run(sys_at, schedule_at, max_steps, state_at, record_at, run_at):
    """Try at most max_steps steps; returns a Status.

    Rows are written every so many steps and at every event, or, where every = 0, at the times t, at which steps end.
    The last of these is the end.
    """
    sys, schedule = view(sys_at, Sys), view(schedule_at, Schedule)
    state, record, run = view(state_at, State), view(record_at, Record), view(run_at, Extrapolation)
    status = advance(sys, schedule, max_steps, state, record, run)
    state.now = run.clock.now
    state.counters.rejected += run.counters.rejected
    state.counters.evaluations += run.counters.substeps
    run.counters.rejected, run.counters.substeps = 0, 0
    return status


@kernel
def advance(sys, schedule, max_steps, state, record, run):
    """``run``, that leaves the header to be filled."""
    sys_at, state_at, run_at = address(sys), address(state), address(run)
    every, t_record = schedule.every, schedule.t
    clock, counters, end = run.clock, run.counters, t_record.shape[0] - 1
    for k in range(2):
        run.step.is_known[k], run.is_known[k] = 0, 0
    if state.counters.is_begun == 0:
        if not begin_run(sys, schedule.span, state, run):
            return Status.NOT_FINITE.value
        write_state(sys, clock.now, state, run, record)
        state.counters.is_begun, record.counts.next = 1, 1
    for _ in range(max_steps):
        t = clock.now
        clock.least = SMALLEST_STEP * max(abs(t), FIRST_STEP * (t_record[end] - t_record[0]))
        if t >= t_record[end]:
            return Status.FINISHED.value
        if is_full(2 * min(every, 1), EVENTS_AT_INSTANT * sys.n_c, state, record) or has_no_room(record.steps):
            return Status.RUNNING.value
        if is_spent(t_record[end] - t_record[0], run):
            return Status.BUDGET_SPENT.value
        set_tolerances(sys, run)
        if counters.to_do == DECIDE:
            counters.has_forces = 0
            status, has_jumped = decide_modes(sys_at, t, state_at, run_at)
            collect(state, run.trial)
            if status != Status.RUNNING:
                return status
            if has_jumped and every > 0:
                write_state(sys, t, state, run, record)
            continue
        stop = t_record[record.counts.next] if every == 0 else t_record[end]
        goes_through = counters.to_do == GO_THROUGH
        H = through_length(run) if goes_through else min(clock.step, clock.cut)
        is_last = t + H >= stop - clock.least
        H = stop - t if is_last else H
        if goes_through:
            status, is_accepted = step_through(sys_at, t, H, state_at, run_at)
        else:
            status, is_accepted = go_on(sys, t, H, is_last, state_at, run, run_at)
        collect(state, run.trial)
        if not is_accepted:
            if goes_through:
                clock.through = FAILED_STEP_PART * H
            elif counters.to_do != GO_ON:
                continue
            counters.rejected += 1
            if H < clock.least:
                return status if status != Status.RUNNING else Status.STEP_VANISHED.value
            continue
        t_1 = stop if is_last else t + H
        if record.steps.is_kept != 0:
            if goes_through:
                keep_event(t, H, state, run, record.steps)
            else:
                keep_smooth(t, H, state, run, record.steps)
        if goes_through:
            status = end_stretch(sys, t_1, H, state, run)
        else:
            end_smooth(sys, t_1, H, state, run)
        accept_step(sys, t_1, state, run)
        if status != Status.RUNNING:
            return status
        if is_last and every == 0:
            record.counts.next += 1
        at_event = counters.to_do != GO_ON
        if (is_last and every == 0) or (every > 0 and (state.counters.steps % every == 0 or at_event or is_last)):
            write_state(sys, t_1, state, run, record)
    return Status.RUNNING.value


@kernel
def begin_run(sys, span, state, run):
    """Take the start from the header, its gaps and scales; False if a model function raised."""
    n, contacts, clock = state.q.shape[0], run.contacts, run.clock
    clock.now, clock.looked, clock.step, clock.cut = state.now, state.now, FIRST_STEP * span, math.inf
    take_system(sys, run)
    for i in range(n):
        run.x[i], run.x[n + i] = state.q[i], state.u[i]
    if not evaluate_gaps(sys, run.clock.now, run.x, run.g_1, run.gamma_1, run):
        return False
    for i in range(state.mode.shape[0]):
        contacts.mode[i], contacts.slip[i], contacts.sign[i] = state.mode[i], state.slip[i], 1
    remember(n, run)
    run.counters.is_first = 1
    run.counters.to_do = DECIDE if state.mode.shape[0] > 0 else GO_ON
    return True


@kernel
def take_system(sys, run):
    """Parameters and laws, which differ from cell to cell of a sweep."""
    for k in range(sys.p.shape[0]):
        run.system.p[k] = sys.p[k]
    for i in range(sys.n_c):
        for k in range(sys.laws.shape[1]):
            run.system.laws[i, k] = sys.laws[i, k]


@kernel
def has_no_room(steps):
    """Whether the motion of one more step has no room: the caller takes what there is."""
    return steps.is_kept != 0 and steps.n_steps + STEP_PIECES > steps.t.shape[0]


@kernel
def is_spent(span, run):
    """Count a try; whether so many got nowhere that the run is to end."""
    run.counters.tries += 1
    if run.counters.tries < BUDGET_TRIES:
        return False
    passed = run.clock.now - run.clock.looked
    moves = run.clock.way >= LEAST_WAY and run.counters.jumps < MOST_JUMPS
    is_nowhere = passed < HOPELESS * span or (not moves and passed < LEAST_TIME * span)
    run.counters.jumps = min(1, run.counters.jumps)
    run.counters.tries, run.clock.way, run.clock.looked = 0, 0.0, run.clock.now
    return is_nowhere


@kernel
def through_length(run):
    """The length of the next plain steps where no modes last."""
    run.clock.through = max(run.clock.through, FIRST_THROUGH * length_of_instant(run))
    return run.clock.through


@kernel
def go_on(sys, t, H, is_last, state_at, run, run_at):
    """Try a step of smooth motion: (Status, whether it is accepted); what is to be done next is in counters.to_do."""
    clock, counters = run.clock, run.counters
    is_cut = H == clock.cut
    clock.cut = math.inf
    counters.at_jump = counters.at_jump if is_cut else 0
    status, outcome, factor = try_step(address(sys), t, H, state_at, run_at)
    if outcome == SMOOTH or outcome == AT_EVENT:
        keep_forces(run)
        clock.step = max(clock.step, factor * H) if is_cut or is_last else factor * H
        if is_cut:
            clock.cut = FASTEST * H
        counters.to_do = GO_THROUGH if counters.at_jump == 1 else GO_ON
        if outcome == AT_EVENT and not only_enters_region(sys, run):
            counters.to_do = DECIDE
        return status, True
    if outcome == AT_ONCE:
        counters.to_do = DECIDE
    elif outcome == UNRESOLVED:
        counters.to_do = GO_THROUGH
    elif factor < 1.0:
        clock.step = factor * H
        counters.is_located = 0
    return status, False


@kernel
def end_smooth(sys, t_1, H, state, run):
    """The event functions at the end of a step of smooth motion as those at the beginning of the next."""
    clock, counters, contacts = run.clock, run.counters, run.contacts
    n, n_c = state.q.shape[0], state.mode.shape[0]
    enters = n_c > 0 and only_enters_region(sys, run)
    if counters.to_do != GO_ON or enters:
        clock.cut = math.inf
    way = 0.0
    for i in range(n):
        way = max(way, abs(run.x[i] - state.q[i]) / run.tol[i], abs(run.x[n + i] - state.u[i]) / run.tol[n + i])
    clock.way += way
    counters.has_jacobian = 0
    if H > QUIET_STEP * length_of_instant(run):
        counters.stalls, clock.through = 0, 0.0
    if n_c == 0:
        return
    if counters.is_located == 1 and counters.to_do == GO_ON and not enters:
        clock.cut = what_is_left(H, run)
    counters.is_located = 0
    for e in range(run.f_0.shape[0]):
        run.f_0[e] = run.f_1[e]
    set_bands(sys, run)
    arm_functions(run)
    count_step(sys, state, contacts)
    for i in range(n_c):
        if contacts.la[i, 1] == 0.0:
            note_side(sys, i, contacts)
        e = N_FUNCTIONS * i + UNIQUE
        if enters and enters_region(sys, e, contacts) and run.f_0[e] < 0.0:
            note_several(sys, t_1, i, True, state, contacts)
            run.f_0[e] = 1.0


@kernel
def what_is_left(H, run):
    """A length that reaches an event which a step was to end at, by the slope of its function over that step."""
    rest = math.inf
    for e in range(run.f_0.shape[0]):
        fall = run.f_0[e] - run.f_1[e]
        if fall > 0.0 and run.f_1[e] < fall:
            rest = min(rest, TWICE * (run.f_1[e] + run.band[e]) / fall * H)
    return max(rest, FIRST_THROUGH * run.clock.least)


@kernel
def end_stretch(sys, t_1, H, state, run):
    """After plain steps where no modes last: decide anew. Returns a Status."""
    counters = run.counters
    run.clock.through *= FASTEST
    if H > QUIET_STEP * length_of_instant(run):
        counters.stalls = 0
    counters.to_do = DECIDE if state.mode.shape[0] > 0 else GO_ON
    counters.has_jacobian, counters.is_located, counters.has_forces, counters.at_jump = 0, 0, 0, 0
    status = event_values(sys, t_1, run.x, run, run.f_0)
    set_bands(sys, run)
    for e in range(run.armed.shape[0]):
        run.armed[e] = 0
    for i in range(state.mode.shape[0]):
        state.mode[i], state.slip[i], state.several[i] = run.contacts.mode[i], run.contacts.slip[i], run.several[i]
    keep_events(state, run)
    state.counters.gains += run.trial.counters.gains
    state.counters.pushes += run.trial.counters.pushes
    state.worst.gain = max(state.worst.gain, run.trial.worst.gain)
    state.worst.push = max(state.worst.push, run.trial.worst.push)
    take_together(run.trial, state)
    return status


@kernel
def remember(n, run):
    """The end of a step as the beginning of the next."""
    for i in range(2 * n):
        run.largest[i] = max(run.largest[i], abs(run.x[i]))
    for i in range(run.g_0.shape[0]):
        run.g_0[i], run.gamma_0[i] = run.g_1[i], run.gamma_1[i]


@kernel
def accept_step(sys, t_1, state, run):
    """Move to the end of the step, run.x, with its impulses and works."""
    trial, change, n, width = run.trial, run.change, state.q.shape[0], state.P.shape[1]
    for i in range(n):
        state.q[i], state.u[i] = run.x[i], run.x[n + i]
        run.a_0[i] = run.a_1[i]
    end = 2 * n
    for i in range(state.mode.shape[0]):
        for k in range(width):
            state.P[i, k] = trial.P[i, k]
            state.P_sum[i, k] += change[end + k]
        end += width
        if sys.kinds[i, 0] == UNILATERAL:
            state.worst.penetration = max(state.worst.penetration, -run.g_1[i])
    for k in range(N_LEDGER):
        state.ledger[k] += change[end + k]
    remember(n, run)
    state.counters.steps += 1
    run.clock.now = t_1


@kernel
def keep_events(state, run):
    """Append the events of the accepted row."""
    trial = run.trial
    m = state.counters.n_events
    for e in range(trial.counters.n_events):
        for k in range(EVENT_WIDTH):
            state.events[m, k] = trial.events[e, k]
        m += 1
    state.counters.n_events = m


@kernel
def collect(state, trial):
    """Add what the substeps counted, and their worst figures."""
    total, its = state.counters, trial.counters
    total.solved, total.skipped, total.kept = (
        total.solved + its.solved,
        total.skipped + its.skipped,
        total.kept + its.kept,
    )
    total.pivots, total.several = total.pivots + its.pivots, total.several + its.several
    total.uncounted, total.shared = total.uncounted + its.uncounted, total.shared + its.shared
    its.solved, its.skipped, its.kept, its.pivots, its.several, its.uncounted, its.shared = 0, 0, 0, 0, 0, 0, 0
    state.counters.events_lost = trial.counters.events_lost
    state.counters.failed_contact = trial.counters.failed_contact
    state.worst.residual = max(state.worst.residual, trial.worst.residual)
    state.worst.ledger_error = max(state.worst.ledger_error, trial.worst.ledger_error)


@kernel
def write_state(sys, t, state, run, record):
    """Append a row of the header, with the gaps there and the modes of the contacts."""
    for i in range(state.mode.shape[0]):
        state.g_N[i] = run.g_0[i] if sys.has & (1 << GAP) else 0.0
    write_row(t, state, record)
    for i in range(state.mode.shape[0]):
        record.mode[record.counts.rows - 1, i] = run.contacts.mode[i]
        record.slip[record.counts.rows - 1, i] = run.contacts.slip[i]
