"""What follows an event of an adaptive run: a jump of the velocities, if there is one, and new modes.

1. A slide that has come to rest is stopped, gamma_F = 0.
2. *Jump*: a plain step so short that smooth motion moves nothing in it by more than a hundredth of its tolerance. What
   moves by more is a jump: an impact, or what a slide that has lost its force is stopped by. It is taken at the
   instant, and again until there is none. Contacts that throw one another back strike in turn ever faster, until their
   gaps are within the band; each impact takes energy, and the series is that of one impact of all of them without
   restitution. A bounce that would stay within the tolerance is dropped (adaptive/substep.py), and so is a flight to
   which the impact of another contact throws one up (adaptive/hops.py).
3. *Modes*: a plain step of a thousandth of the step that the motion takes decides on them. It is not taken. They are
   kept if their event functions agree at the instant; else a step a tenth as long is asked.
4. Where no modes are found the motion goes on by plain steps for a while (adaptive/through.py).

So whatever the plain step decides is what is integrated: several impacts at once, paradoxes, the selection among
several solutions. Here a contact that sticks is one whose impulse stays within the cone, as in Moreau–Jean, and not one
whose velocity counts as zero: where a slide comes to rest both may be true of it. Where velocities alone decide,
whether a contact parts and whether one that is held closed slides, it is by mechanics/situation.py, within the
tolerances of the step (adaptive/scales.py).
"""

from __future__ import annotations

from nonsmooth.errors import Status
from nonsmooth.integrators.adaptive.events import NOWHERE, STANDS, arm_functions, event_values, find_fallen, set_bands
from nonsmooth.integrators.adaptive.held import NO_LOAD
from nonsmooth.integrators.adaptive.hops import drop_hops
from nonsmooth.integrators.adaptive.scales import closed_gap, evaluate_gaps, is_parting, length_of_instant
from nonsmooth.integrators.adaptive.series import add_series
from nonsmooth.integrators.adaptive.state import (
    GO_ON,
    GO_THROUGH,
    TRIAL_EVENTS,
    Extrapolation,
)
from nonsmooth.integrators.adaptive.substep import RETAKE, substep
from nonsmooth.integrators.adaptive.table import begin_trial
from nonsmooth.integrators.records import (
    EVENT_CONTACT,
    EVENT_KIND,
    EVENT_MODE_0,
    EVENT_MODE_1,
    EVENT_SLIP_0,
    EVENT_SLIP_1,
    EVENT_T,
    EVENT_WIDTH,
    FRICTION,
    IMPACT,
    INCONSISTENT,
    INDETERMINATE,
    MODE_CHANGE,
    N_FUNCTIONS,
    N_LEDGER,
    State,
    append_event,
    take_together,
)
from nonsmooth.integrators.rigid.census import note_several, slides_alone
from nonsmooth.integrators.rigid.hold import hold_constraints
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.jit.blocks import address, view
from nonsmooth.mechanics.laws import friction_coefficient, static_coefficient
from nonsmooth.mechanics.sys import Sys
from nonsmooth.mechanics.system import BILATERAL, GIVEN_FORCE, UNILATERAL, ContactMode

JUMP = 0.1  # chosen: of a tolerance: ten times what smooth motion does in an instant
JUMPS = 64  # chosen: at an instant, per contact: then the series is ended
# derived: rows of events, per contact, that there must be room for before an instant
EVENTS_AT_INSTANT = JUMPS + 2 * TRIAL_EVENTS
MODE_PROBE = 1e-3  # chosen: of the step that the motion takes: how far ahead modes are decided
MODE_PROBES = 8  # chosen: each a tenth of the one before
# chosen: tolerances: what holding the modes of a probe may change of a velocity; the end of a slide is within two
STAYED = 100.0
MOST_STALLS = 8  # chosen: events at an instant, per contact: then the motion goes on by plain steps


@rare_kernel("Tuple((int64, boolean))(int64, float64, int64, int64)", short_loops=True)
def decide_modes(sys_at, t, state_at, run_at):
    """Jump and find modes at the beginning of a step: (Status, whether the velocities have jumped). What is to be done
    next is in counters.to_do."""
    sys = view(sys_at, Sys)
    state, run = view(state_at, State), view(run_at, Extrapolation)
    n, n_c, x = state.q.shape[0], state.mode.shape[0], run.x
    contacts, counters = run.contacts, run.counters
    first_event = state.counters.n_events
    counters.stalls += 1
    for i in range(n):
        x[i], x[n + i], run.u_0[i] = state.q[i], state.u[i], state.u[i]
    stop_slides(run)
    for i in range(n_c):
        run.dropped[i] = 0.0
    status = hold_constraints(sys_at, t, x, False, address(contacts))
    has_jumped = False
    for k in range(JUMPS * n_c + 1):
        if status != Status.RUNNING:
            return status, has_jumped
        counters.ends_series = 1 if k == JUMPS * n_c else 0
        status, jumps = find_jump(sys, t, state, run)
        if not jumps:
            break
        has_jumped = True
    counters.ends_series = 0
    if status == Status.RUNNING:
        status = find_modes(sys, t, state, run)
    if status == Status.RUNNING and has_jumped and counters.to_do == GO_ON:
        status = add_series(sys, t, state, run)
    if status != Status.RUNNING:
        return status, has_jumped
    note_changes(t, first_event, state, run)
    for i in range(n):
        state.q[i], state.u[i] = x[i], x[n + i]
        run.largest[i] = max(run.largest[i], abs(x[i]))
        run.largest[n + i] = max(run.largest[n + i], abs(x[n + i]))
    for i in range(n_c):
        state.mode[i], state.slip[i] = contacts.mode[i], contacts.slip[i]
        run.g_0[i], run.gamma_0[i] = run.g_1[i], run.gamma_1[i]
    counters.is_first, counters.is_located, counters.has_jacobian = 0, 0, 0
    for i in range(n_c):
        if counters.to_do == GO_ON and slides_alone(sys, i, contacts):
            note_several(sys, t, i, False, state, contacts)
    return status, has_jumped


@kernel
def stop_slides(run):
    """Let the slides that have come to rest be held at rest, in contacts.mode; run.mode, run.slip: as they were."""
    contacts = run.contacts
    for i in range(contacts.mode.shape[0]):
        run.mode[i], run.slip[i], run.has_struck[i], run.is_stopped[i] = contacts.mode[i], contacts.slip[i], 0, 0
        value, band = run.f_0[N_FUNCTIONS * i + FRICTION], run.band[N_FUNCTIONS * i + FRICTION]
        highest = band if run.armed[N_FUNCTIONS * i + FRICTION] == 1 else -band
        is_at_rest = -2.0 * band <= value <= highest and run.counters.is_first == 0
        if contacts.mode[i] == ContactMode.SLIDE and is_at_rest:
            run.is_stopped[i] = 1
            contacts.mode[i], contacts.slip[i] = ContactMode.STICK.value, 0


@kernel
def find_jump(sys, t, state, run):
    """(Status, whether a plain step of an instant moves the velocities of run.x by a jump), which is taken then."""
    n, x, trial, contacts = state.q.shape[0], run.x, run.trial, run.contacts
    for i in range(state.mode.shape[0]):
        is_slide = run.is_stopped[i] == 1
        state.mode[i] = ContactMode.SLIDE.value if is_slide else contacts.mode[i]
        state.slip[i] = run.slip[i] if is_slide else contacts.slip[i]
    dt, longer = length_of_instant(run), 0.0
    for _ in range(2):  # what does not grow with the step is a jump
        status = try_instant(sys, t, dt, state, run)
        moved = 0.0
        for i in range(n):
            moved = max(moved, abs(trial.u[i] - x[n + i]) / run.tol[n + i])
        if status != Status.RUNNING or moved <= JUMP or moved < 0.5 * longer:
            return status, False
        dt, longer = 0.1 * dt, moved
    for i in range(n):
        x[n + i] = trial.u[i]
    if not evaluate_gaps(sys, t, x, run.g_1, run.gamma_1, run):
        return Status.NOT_FINITE.value, True
    take_jump(sys, state, run)
    return hold_constraints(address(sys), t, x, False, address(contacts)), True


@kernel
def try_instant(sys, t, dt, state, run):
    """A plain step from run.x, or the impact without collision before it; returns a Status."""
    n, trial = state.q.shape[0], run.trial
    begin_trial(state, trial)
    for i in range(n):
        trial.q[i], trial.u[i] = run.x[i], run.x[n + i]
    status = substep(address(sys), t, dt, address(run))
    return Status.RUNNING.value if status == RETAKE else status


@kernel
def take_jump(sys, state, run):
    """Take the jump of the trial: its impulses and works, its modes and events; what parts is open."""
    trial, contacts = run.trial, run.contacts
    for i in range(contacts.mode.shape[0]):
        parts = is_parting(sys, i, run.gamma_1[i], run)
        contacts.mode[i] = ContactMode.OPEN.value if parts else trial.mode[i]
        contacts.slip[i] = 0 if parts else trial.slip[i]
        run.is_stopped[i] = 0
        for k in range(state.P.shape[1]):
            state.P[i, k] = trial.P[i, k]
            state.P_sum[i, k] += trial.P_sum[i, k]
        state.several[i] = trial.several[i]
    for k in range(N_LEDGER):
        state.ledger[k] += trial.ledger[k]
    state.counters.gains += trial.counters.gains
    state.counters.pushes += trial.counters.pushes
    state.worst.gain = max(state.worst.gain, trial.worst.gain)
    state.worst.push = max(state.worst.push, trial.worst.push)
    take_together(trial, state)
    for e in range(trial.counters.n_events):
        kind = trial.events[e, EVENT_KIND]
        if kind == IMPACT or kind == INCONSISTENT:
            run.has_struck[int(trial.events[e, EVENT_CONTACT])] = 1
        if kind != MODE_CHANGE:
            copy_event(e, state, run)


@kernel
def copy_event(e, state, run):
    """Append event e of the trial to those of the run; count it as lost where there is no room but for the changes of
    modes."""
    m = state.counters.n_events
    if m + state.mode.shape[0] >= state.events.shape[0]:
        run.trial.counters.events_lost += 1
        return
    for k in range(EVENT_WIDTH):
        state.events[m, k] = run.trial.events[e, k]
    state.counters.n_events += 1


@kernel
def find_modes(sys, t, state, run):
    """Decide on the modes at run.x, to contacts.mode, by plain steps a part of the motion's long; returns a Status.

    Where those of none last, the contacts have the modes from before, and the motion is to go on by plain steps.
    """
    n, n_c, contacts, counters = state.q.shape[0], state.mode.shape[0], run.contacts, run.counters
    if not evaluate_gaps(sys, t, run.x, run.g_1, run.gamma_1, run):
        return Status.NOT_FINITE.value
    for i in range(n_c):
        state.mode[i], state.slip[i] = contacts.mode[i], contacts.slip[i]
        if run.is_stopped[i] == 1 and not is_caught(sys, i, run):
            state.mode[i], state.slip[i] = ContactMode.SLIDE.value, run.slip[i]
    status = try_modes(sys, t, state, run)
    for _ in range(n_c):
        if status != Status.RUNNING or counters.to_do != GO_ON or not drop_hops(sys, t, run):
            break
        status = hold_constraints(address(sys), t, run.x, False, address(contacts))
        if status != Status.RUNNING or not evaluate_gaps(sys, t, run.x, run.g_1, run.gamma_1, run):
            return status if status != Status.RUNNING else Status.NOT_FINITE.value
        for i in range(n_c):
            state.mode[i], state.slip[i] = contacts.mode[i], contacts.slip[i]
        status = try_modes(sys, t, state, run)
    if status != Status.RUNNING:
        return status
    for e in range(run.armed.shape[0]):
        run.armed[e] = 0
    if counters.to_do == GO_ON:
        arm_functions(run)
        for i in range(n):
            run.x[i], run.x[n + i] = run.y[i], run.y[n + i]
        return Status.RUNNING.value
    for i in range(n_c):
        contacts.mode[i], contacts.slip[i] = state.mode[i], state.slip[i]
    return Status.RUNNING.value


@kernel
def try_modes(sys, t, state, run):
    """Let plain steps decide, each a tenth as long as the one before, until modes last; returns a Status."""
    counters, n_c = run.counters, state.mode.shape[0]
    ahead, shortest = MODE_PROBE * run.clock.step, length_of_instant(run)
    counters.to_do = GO_THROUGH
    for _ in range(MODE_PROBES):
        if counters.stalls > MOST_STALLS * n_c:
            break
        ahead = max(ahead, shortest)
        status = probe_modes(sys, t, ahead, state, run)
        if status != Status.RUNNING:
            return status
        if counters.to_do == GO_ON or ahead == shortest:
            break
        ahead *= 0.1
    return Status.RUNNING.value


@kernel
def is_caught(sys, i, run):
    """Whether a slide that has come to rest is caught by static friction, which is above that of sliding."""
    laws = sys.laws
    return static_coefficient(laws, i) > friction_coefficient(laws, i, 0.0)


@kernel
def probe_modes(sys, t, ahead, state, run):
    """Let a plain step of the length ``ahead`` decide; if its modes last at the instant they are taken, with the state
    run.y that they hold, and counters.to_do is GO_ON. Returns a Status."""
    n, n_c, contacts, trial = state.q.shape[0], state.mode.shape[0], run.contacts, run.trial
    begin_trial(state, trial)
    for i in range(n):
        trial.q[i], trial.u[i] = run.x[i], run.x[n + i]
    for i in range(n_c):
        contacts.mode[i], contacts.slip[i] = state.mode[i], state.slip[i]
    if substep(address(sys), t, ahead, address(run)) != Status.RUNNING:
        return Status.RUNNING.value
    for i in range(n_c):
        was_open = state.mode[i] == ContactMode.OPEN and sys.kinds[i, 0] == UNILATERAL
        if was_open and trial.mode[i] != ContactMode.OPEN and run.g_1[i] > closed_gap(i, run):
            return Status.RUNNING.value
        take_trial_mode(sys, i, run)
    for i in range(2 * n):
        run.y[i] = run.x[i]
    status = hold_constraints(address(sys), t, run.y, False, address(contacts))
    if status != Status.RUNNING or not has_stayed(n, run):
        return status
    for i in range(n_c):
        contacts.several[i] = 1  # whether another force fits too is asked below
    status = event_values(sys, t, run.y, run, run.f_0)
    for i in range(n_c):
        contacts.several[i] = 0
    if status != Status.RUNNING:
        return status
    set_bands(sys, run)
    for i in range(n):
        run.force_0[i] = contacts.work.du[i]
    run.counters.has_forces = 1
    for e in range(run.armed.shape[0]):
        run.armed[e], run.rises[e] = 0, NOWHERE
    if find_fallen(run.f_0, 0.0, run) == STANDS:
        run.counters.to_do = GO_ON
    return status


@kernel
def has_stayed(n, run):
    """Whether modes hold the velocities that are there: a contact is not stopped by the name of its mode."""
    for i in range(n, 2 * n):
        if abs(run.y[i] - run.x[i]) > STAYED * run.tol[i]:
            return False
    return True


@kernel
def take_trial_mode(sys, i, run):
    """The mode of contact i that the trial ended with; one without any given normal force slides the way it goes."""
    contacts, trial = run.contacts, run.trial
    contacts.mode[i], contacts.slip[i], contacts.sign[i] = trial.mode[i], trial.slip[i], 1
    if sys.kinds[i, 0] == BILATERAL and trial.P[i, 0] < 0.0:
        contacts.sign[i] = -1
    if sys.kinds[i, 0] == GIVEN_FORCE:
        run.is_loaded[i] = 1 if run.step.work.N[i] > NO_LOAD * run.band[N_FUNCTIONS * i] else 0
        if contacts.mode[i] == ContactMode.OPEN:
            contacts.mode[i], contacts.slip[i] = ContactMode.SLIDE.value, way_of_slide(i, run)


@kernel
def way_of_slide(i, run):
    """The sign of the sliding velocity with which the trial ended; 1 at rest."""
    work, u = run.step.work, run.trial.u
    gamma = work.w_F[i, 0]
    for j in range(u.shape[0]):
        gamma += work.W_F[i, 0, j] * u[j]
    return -1 if gamma < 0.0 else 1


@kernel
def note_changes(t, first_event, state, run):
    """Note what changed since modes were decided before: the modes of a start are no event."""
    contacts, trial = run.contacts, run.trial
    for m in range(first_event, state.counters.n_events):
        i = int(state.events[m, EVENT_CONTACT])
        state.events[m, EVENT_MODE_1], state.events[m, EVENT_SLIP_1] = contacts.mode[i], contacts.slip[i]
    is_found = run.counters.to_do == GO_ON
    for i in range(contacts.mode.shape[0]):
        state.several[i] = trial.several[i] if is_found else state.several[i]
        run.several[i] = state.several[i]
    for e in range(trial.counters.n_events if is_found else 0):
        i = int(trial.events[e, EVENT_CONTACT])
        if trial.events[e, EVENT_KIND] == INDETERMINATE and run.has_struck[i] == 0:
            m = state.counters.n_events
            copy_event(e, state, run)
            if state.counters.n_events > m:
                set_modes(m, t, i, state, run)
            run.has_struck[i] = 1
            contacts.several[i] = 1
    for i in range(contacts.mode.shape[0]):
        changed = contacts.mode[i] != run.mode[i] or contacts.slip[i] != run.slip[i]
        if not changed or run.has_struck[i] == 1 or run.counters.is_first == 1:
            continue
        state.event.solutions, state.event.gamma_F = 1, contacts.gamma[i, 1]
        mode, slip = contacts.mode[i], contacts.slip[i]
        append_event(t, MODE_CHANGE, i, run.mode[i], run.slip[i], mode, slip, state)


@kernel
def set_modes(m, t, i, state, run):
    """Give event m of contact i its time, and the modes before and after."""
    row, contacts = state.events, run.contacts
    row[m, EVENT_T] = t
    row[m, EVENT_MODE_0], row[m, EVENT_SLIP_0] = run.mode[i], run.slip[i]
    row[m, EVENT_MODE_1], row[m, EVENT_SLIP_1] = contacts.mode[i], contacts.slip[i]
