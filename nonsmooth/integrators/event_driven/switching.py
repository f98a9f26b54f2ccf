"""What follows an event of rigid contacts: impacts, then new modes; where no force exists, an impact without collision.

1. Contacts that touch and approach strike (event_driven/impact.py); those that part are open.
2. Every set of forces of the contacts that still touch is enumerated (contact/planar/forces.py) with the sliding
   directions of the instant, island by island, and one is taken by the rule of docs/theory/selection.md. Islands that
   are no part of the event go on. An event that lies on the border of two modes is decided a moment later on the motion
   that the old modes would have gone on with: there one of the two no longer holds. Contacts that are left free and do
   not part are closed where they are redundant (event_driven/idle.py).
3. Where an island has none, its sliding is inconsistent: an impact without collision follows, of its contacts and
   those whose normal velocity that changes, then step 2 again. With
   selection="impact" the same is done where there are several. The contact has then stuck, if the force that holds it
   has the sign of the impulse; the force of a stiff contact falls through zero otherwise, and there it lets go.
4. Impacts slower than atol [m/s] have no restitution. A contact that leaves with the velocity v and will come back,
   gamma_N' = a < 0, begins a series of bounces. Where the next is lower than the tolerance, v^2/(2 |a|) < atol, it is
   closed instead: with the restitution e the series ends after the time 2 v/(|a| (1 - e)), by which the event is dated.
5. Contacts that throw one another back, as the corners of a slender slider do, strike in turn ever faster, and their
   gaps fall below rounding while they still approach. Each impact with e < 1 takes energy, so that the series ends
   with gamma_N = 0: its impulses add up to those of one impact of all of them without restitution.

Source: Génot, Brogliato, *Eur. J. Mech. A/Solids* 18 (1999) 653; Lötstedt, *SIAM J. Sci. Stat. Comput.* 5 (1984) 370.
"""

from __future__ import annotations

import math

from nonsmooth.contact.planar.enumerate import select
from nonsmooth.contact.planar.forces import Forces, Outcome, forces_of_closed, is_asked
from nonsmooth.contact.planar.single import STICK, Selection, sigma_of, slip_of
from nonsmooth.errors import Status
from nonsmooth.integrators.event_driven.idle import close_idle, close_island
from nonsmooth.integrators.event_driven.impact import solve_impact
from nonsmooth.integrators.event_driven.touch import COLLISION, END_OF_SERIES, WITHOUT_COLLISION, Touch, find_touching
from nonsmooth.integrators.moreau_jean.contact import mode_of
from nonsmooth.integrators.radau.events import NO_EVENT
from nonsmooth.integrators.radau.located import AT_START
from nonsmooth.integrators.records import (
    CLOSURE,
    FRICTION,
    IMPACT,
    INCONSISTENT,
    INDETERMINATE,
    MODE_CHANGE,
    N_FUNCTIONS,
    State,
    append_event,
)
from nonsmooth.integrators.rigid.hold import hold_constraints
from nonsmooth.integrators.rigid.modes import SINGULAR_SLIDE, RigidContacts, rounded_length, small_speed
from nonsmooth.integrators.rigid.rates import rigid_rates
from nonsmooth.integrators.rigid.series import find_landing, has_rough_guide, push, slides_by
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.jit.blocks import address, view
from nonsmooth.mechanics.acceleration_problem import find_row_rates, row_shift
from nonsmooth.mechanics.contact_problem import Problem, evaluate_rows
from nonsmooth.mechanics.laws import LAW_E_N
from nonsmooth.mechanics.sys import Sys
from nonsmooth.mechanics.system import BILATERAL, GIVEN_FORCE, UNILATERAL, ContactMode

SOLUTIONS_KEPT = 64  # chosen: solutions kept of one state
MAX_IMPACTS = 64  # chosen: at one instant, per contact
RESOLVED = 10.0  # chosen: times what rounding leaves of a gap: a lower bounce cannot be told from none


@rare_kernel("int64(int64, float64, float64, float64[::1], int64, int64, int64, int64)", short_loops=True)
def switch_modes(sys_at, t, moment, x, state_at, contacts_at, touch_at, forces_at):
    """Handle the event contacts.facts.event at the state x; ``moment`` [s] is short against the motion.

    Returns a Status; RUNNING with the new modes, and with x moved by the impulses.
    """
    sys = view(sys_at, Sys)
    state, contacts = view(state_at, State), view(contacts_at, RigidContacts)
    touch, forces = view(touch_at, Touch), view(forces_at, Forces)
    n, n_c, event = sys.n, sys.n_c, contacts.facts.event
    contacts.numbers.flight = math.inf
    for i in range(n_c):
        state.mode[i], state.slip[i] = contacts.mode[i], contacts.slip[i]
        touch.P[i, 0], touch.P[i, 1], touch.accumulates[i], touch.kind[i] = 0.0, 0.0, 0.0, MODE_CHANGE
        touch.impacts[i, 0], touch.impacts[i, 1] = 1, 0
    is_border = on_border(event, n_c, contacts)
    is_lost = event == N_FUNCTIONS * n_c and n_c > 0
    if is_border or is_lost:
        status = rigid_rates(sys_at, address(contacts), t, x, touch.rates)
        if status != Status.RUNNING:
            return status
        mark_lost(sys, contacts, touch)
    for j in range(n):
        touch.q[j] = moment * x[n + j] if is_border else 0.0
        touch.u[j] = moment * contacts.work.du[j] if is_border else 0.0
    status, has_struck = resolve_impacts(sys, t, x, event, state, contacts, touch)
    if status == Status.RUNNING:
        touch.ahead = moment if is_border and not has_struck else 0.0
        status = find_modes(sys_at, t, x, is_lost, state_at, contacts_at, touch_at, forces_at)
    if status == Status.RUNNING and has_struck:
        status = give_up_bounces(sys, t, x, state, contacts, touch, forces)
    if status != Status.RUNNING:
        return status
    gives_up = False
    for i in range(n_c):
        gives_up = gives_up or touch.accumulates[i] > 0.0
    status = hold_constraints(sys_at, t, x, gives_up, contacts_at)
    note_events(sys, t, state, contacts, touch)
    contacts.facts.event = NO_EVENT
    return status


@kernel
def mark_lost(sys, contacts, touch):
    """Mark the contacts of the islands that have lost their forces: where det A is least, and where it is as good as
    zero, as in two islands that are alike."""
    bound = max(contacts.numbers.determinant, 2.0 * SINGULAR_SLIDE)
    for i in range(sys.n_c):
        is_closed = contacts.mode[i] != ContactMode.OPEN
        touch.is_lost[i] = 1 if is_closed and contacts.determinant[i] <= bound else 0


@kernel
def on_border(event, n_c, contacts):
    """Whether an event is where one mode passes into another, and not where a contact comes to touch or to rest."""
    if event < 0 or event == N_FUNCTIONS * n_c:
        return False
    mode, function = contacts.mode[event // N_FUNCTIONS], event % N_FUNCTIONS
    if function == CLOSURE:
        return mode != ContactMode.OPEN
    return function != FRICTION or mode == ContactMode.STICK


@kernel
def resolve_impacts(sys, t, x, event, state, contacts, touch):
    """Impacts until no contact that touches approaches: (Status, whether there was one)."""
    n_c = sys.n_c
    has_struck = False
    for attempt in range(MAX_IMPACTS * n_c + 1):
        if not find_touching(address(sys), t, x, event, address(contacts), address(touch)):
            return Status.NOT_FINITE.value, has_struck
        speed = small_speed(sys, contacts)
        is_struck = False
        for i in range(n_c):
            if attempt == 0:
                touch.before[i, 0], touch.before[i, 1] = touch.gamma[i, 0], touch.gamma[i, 1]
            kind, gamma_N = sys.kinds[i, 0], touch.gamma[i, 0]
            touch.strikes[i] = 0
            approaches = gamma_N < -speed if kind == UNILATERAL else kind == BILATERAL and abs(gamma_N) > speed
            if touch.is_touching[i] == 1 and approaches:
                touch.kind[i] = IMPACT
                touch.strikes[i] = 1
                is_struck = True
        if not is_struck:
            return Status.RUNNING.value, has_struck
        if attempt == MAX_IMPACTS * n_c:
            break
        touch.impact = COLLISION
        status = solve_impact(address(sys), t, x, address(state), address(contacts), address(touch))
        if status != Status.RUNNING:
            return status, has_struck
        has_struck = True
        event = NO_EVENT
    return end_series(sys, t, x, state, contacts, touch), has_struck


@kernel
def end_series(sys, t, x, state, contacts, touch):
    """The end of a series of impacts of several contacts at one instant, by one without restitution; a Status."""
    n_c = sys.n_c
    for i in range(n_c):
        touch.strikes[i] = 0
        if touch.kind[i] == IMPACT:
            touch.is_touching[i], touch.strikes[i] = 1, 1
            if sys.laws[i, LAW_E_N] >= 1.0:
                return Status.CHATTERING.value
    speed = small_speed(sys, contacts)  # before: of what comes to rest rounding is left
    touch.impact = END_OF_SERIES
    status = solve_impact(address(sys), t, x, address(state), address(contacts), address(touch))
    if status != Status.RUNNING:
        return status
    if not find_touching(address(sys), t, x, NO_EVENT, address(contacts), address(touch)):
        return Status.NOT_FINITE.value
    for i in range(n_c):
        if touch.is_touching[i] == 1 and abs(touch.gamma[i, 0]) > speed:
            return Status.CHATTERING.value
    return Status.RUNNING.value


@rare_kernel("int64(int64, float64, float64[::1], boolean, int64, int64, int64, int64)", short_loops=True)
def find_modes(sys_at, t, x, is_lost, state_at, contacts_at, touch_at, forces_at):
    """Give the contacts that touch their modes, with an impact without collision of the islands that have none.

    ``is_lost`` tells that the islands marked in touch.is_lost have no forces even before they are looked for. Returns
    a Status.
    """
    sys = view(sys_at, Sys)
    state, contacts = view(state_at, State), view(contacts_at, RigidContacts)
    touch, forces = view(touch_at, Touch), view(forces_at, Forces)
    n, n_c = sys.n, sys.n_c
    for attempt in range(n_c + 1):
        later = t + touch.ahead
        for j in range(n):
            is_ahead = later > t
            contacts.q[j] = x[j] + (touch.q[j] if is_ahead else 0.0)
            contacts.u[j] = x[n + j] + (touch.u[j] if is_ahead else 0.0)
        n_k = list_touching(sys, contacts, touch, forces)
        outcome, _, _ = forces_of_closed(sys, later, contacts.q, contacts.u, n_k, forces)
        if outcome != Outcome.COMPLETE:
            return Status.NOT_FINITE.value if outcome == Outcome.NOT_FINITE else Status.NOT_SOLVED.value
        take_modes(sys, attempt == 0, is_lost and attempt == 0, n_k, state, contacts, touch, forces)
        close_idle(sys, later, n_k, contacts, touch, forces)
        if not must_strike(sys, later, is_lost, n_k, contacts, touch, forces):
            return Status.RUNNING.value
        status = resolve_lost_slides(sys, t, x, state, contacts, touch)
        if status != Status.RUNNING:
            return status
        touch.ahead = 0.0
    return Status.NO_SOLUTION.value


@kernel
def list_touching(sys, contacts, touch, forces):
    """Hand the contacts that touch over to the search for forces; returns their number.

    It is asked for the islands that something has happened to: the others go on, whatever else would fit them.
    """
    n_k = 0
    for i in range(sys.n_c):
        forces.gamma[i, 0], forces.gamma[i, 1] = 0.0, touch.gamma[i, 1]
        touch.strikes[i] = 0
        if touch.is_touching[i] == 0:
            contacts.mode[i], contacts.slip[i], contacts.sign[i] = ContactMode.OPEN.value, 0, 1
            continue
        forces.work.closed[n_k] = i
        forces.slip[n_k] = 0
        if sys.kinds[i, 1] > 0 and touch.is_resting[i] == 0:
            forces.slip[n_k] = 1 if touch.gamma[i, 1] > 0.0 else -1
        forces.asked[n_k] = 0 if goes_on(sys, i, forces.slip[n_k], contacts, touch) else 1
        n_k += 1
    return n_k


@kernel
def goes_on(sys, i, slip, contacts, touch):
    """Whether contact i is no part of the event, has not been struck, and moves as its mode says."""
    event, mode = contacts.facts.event, contacts.mode[i]
    if event < 0 or event // N_FUNCTIONS == i or touch.P[i, 0] != 0.0 or touch.P[i, 1] != 0.0:
        return False
    if event == N_FUNCTIONS * sys.n_c and touch.is_lost[i] == 1:
        return False
    if sys.kinds[i, 1] == 0:
        return mode != ContactMode.OPEN
    if slip == 0:
        return mode == ContactMode.STICK
    return mode == ContactMode.SLIDE and contacts.slip[i] == slip


@kernel
def take_modes(sys, is_first, is_lost, n_k, state, contacts, touch, forces):
    """Take one of the solutions of each island by the selection rule; those without one, or that the rule stops, are
    left with touch.strikes = 1."""
    for k in range(n_k):
        island = forces.island[k]
        if not is_first_of(k, forces) or not is_asked(island, n_k, forces):
            continue
        strikes = forces.number[island] == 0 or (is_lost and touch.is_lost[forces.work.closed[k]] == 1)
        if not strikes:
            slides = take_solution(sys, island, n_k, state, contacts, touch, forces)
            is_stopped = contacts.facts.selection == Selection.IMPACT and is_first
            strikes = forces.number[island] > 1 and slides and is_stopped
        if strikes:
            let_strike(island, 1, n_k, touch, forces)


@kernel
def let_strike(island, strikes, n_k, touch, forces):
    """Note whether the contacts of an island strike."""
    for k in range(n_k):
        if forces.island[k] == island:
            touch.strikes[forces.work.closed[k]] = strikes


@kernel
def is_first_of(k, forces):
    """Whether closed contact k is the first of its island."""
    for m in range(k):
        if forces.island[m] == forces.island[k]:
            return False
    return True


@kernel
def take_solution(sys, island, n_k, state, contacts, touch, forces):
    """Take one of the solutions of an island by the selection rule; returns whether a contact slides before."""
    work, tree, kinds, ranked = forces.work, forces.planar.tree, sys.kinds, forces.reduced
    found = forces.number[island]
    kept = min(found, forces.candidate.shape[0], tree.modes.shape[0])
    slides, has_hysteresis, bits = False, False, 0
    ranked.n, ranked.r, ranked.selection = 0, 0, contacts.facts.selection
    for k in range(n_k):
        if forces.island[k] != island:
            continue
        i = work.closed[k]
        slides = slides or forces.slip[k] != 0
        was_caught = touch.is_resting[i] == 1 and forces.mu_static[k] > forces.mu[k]  # by the static friction
        has_hysteresis = has_hysteresis or was_caught  # sticking beside a slide is none of the paradoxes then
        was_stuck = state.mode[i] == ContactMode.STICK
        for m in range(kept):
            if touch.kind[i] == INCONSISTENT and forces.candidate[m, k] == STICK:
                was_stuck = forces.la[m, work.start[k]] * touch.P[i, 0] > 0.0
            tree.modes[m, ranked.n] = forces.candidate[m, k]
            bits |= 1 << forces.candidate[m, k]
        add_ranked(sys, k, was_stuck or was_caught, forces)
    take, n = select(kept, view(address(ranked), Problem), tree), ranked.n
    is_noted = False
    is_indeterminate = found >= 3 or (found == 2 and (slides or n > 1 or not has_hysteresis))
    for m in range(n):
        k, candidate = ranked.place[m], tree.modes[take, m]
        i = work.closed[k]
        contacts.mode[i] = mode_of(candidate, kinds[i, 1])
        contacts.slip[i] = slip_of(candidate)
        contacts.sign[i] = 1
        if kinds[i, 0] == BILATERAL:
            pulls = forces.la[take, work.start[k]] < 0.0
            contacts.sign[i] = -1 if candidate == STICK and pulls else sigma_of(candidate)
        for a in range(work.start[k], work.start[k + 1]):
            forces.taken[a] = forces.la[take, a]
        if is_indeterminate:
            touch.found[i, 0], touch.found[i, 1] = found, bits if n == 1 else 0
        if is_indeterminate and kinds[i, 1] > 0 and touch.kind[i] == MODE_CHANGE:
            touch.kind[i] = INDETERMINATE
            is_noted = True
    for m in range(n):
        contacts.several[work.closed[ranked.place[m]]] = 1 if is_noted else 0
    if is_indeterminate:
        state.counters.several += 0 if slides and n == 1 else 1  # of these the steps are counted
    return slides


@kernel
def add_ranked(sys, k, was_stuck, forces):
    """Add closed contact k to those that the selection rule ranks, with what it asks: kind, friction, mode before, and
    the block of G that says whether D < 0."""
    work, ranked = forces.work, forces.reduced
    n, r, first, i = ranked.n, ranked.r, work.start[k], work.closed[k]
    ranked.place[n], ranked.start[n] = k, r
    ranked.kinds[n, 0], ranked.kinds[n, 1] = sys.kinds[i, 0], sys.kinds[i, 1]
    ranked.mu[n] = forces.mu[k]
    ranked.mode[n] = ContactMode.STICK.value if was_stuck else ContactMode.OPEN.value
    width = work.start[k + 1] - first
    for a in range(width):
        for b in range(width):
            ranked.G[r + a, r + b] = work.G[first + a, first + b]
    ranked.n, ranked.r = n + 1, r + width


@kernel
def must_strike(sys, t, is_lost, n_k, contacts, touch, forces):
    """Whether an island has no forces that its contacts could be given, or is to be stopped by the rule.

    Forces of rows that are nearly parallel or opposite are lost in G, by which they were looked for: such contacts may
    share a load all the same.
    """
    strikes = False
    for k in range(n_k):
        i, island = forces.work.closed[k], forces.island[k]
        has_none = forces.number[island] == 0 and not (is_lost and touch.is_lost[i] == 1)
        if touch.strikes[i] == 1 and has_none and is_first_of(k, forces):
            if close_island(sys, t, island, n_k, contacts, touch, forces):
                let_strike(island, 0, n_k, touch, forces)
        strikes = strikes or touch.strikes[i] == 1
    return strikes


@kernel
def resolve_lost_slides(sys, t, x, state, contacts, touch):
    """The impact that resolves sliding without force; NO_SOLUTION where no impulse does."""
    n_c = sys.n_c
    for i in range(n_c):
        touch.before[i, 0], touch.before[i, 1] = touch.gamma[i, 0], touch.gamma[i, 1]
    before = 0.0
    for i in range(n_c):
        before += abs(touch.P[i, 0]) + abs(touch.P[i, 1])
    touch.impact = WITHOUT_COLLISION
    status = solve_impact(address(sys), t, x, address(state), address(contacts), address(touch))
    if status != Status.RUNNING:
        state.counters.failed_contact = -1
        return status
    after = 0.0
    for i in range(n_c):
        after += abs(touch.P[i, 0]) + abs(touch.P[i, 1])
        is_sliding = sys.kinds[i, 1] > 0 and touch.is_resting[i] == 0
        if touch.P[i, 0] != 0.0 and is_sliding and touch.kind[i] != INDETERMINATE:
            touch.kind[i] = INCONSISTENT
    if after == before:
        state.counters.failed_contact = -1
        return Status.NO_SOLUTION
    is_finite = find_touching(address(sys), t, x, NO_EVENT, address(contacts), address(touch))
    return Status.RUNNING if is_finite else Status.NOT_FINITE


@kernel
def give_up_bounces(sys, t, x, state, contacts, touch, forces):
    """Close the contacts whose next bounce is lower than the tolerance; note how long the shortest other flight is.

    What closes changes the forces, and so which of the others come back: each is closed once.
    """
    for _ in range(sys.n_c):
        status, n_closed, last = close_low_bounces(sys, t, x, contacts, touch)
        if status != Status.RUNNING or n_closed == 0:
            return status
        v = touch.gamma[last, 0]
        for j in range(x.shape[0]):
            touch.flight[j] = touch.rates[j]
        touch.ahead = 0.0
        status = find_modes(
            address(sys), t, x, False, address(state), address(contacts), address(touch), address(forces)
        )
        if status == Status.RUNNING and n_closed == 1 and has_rough_guide(sys, contacts):
            status = add_series(sys, t, last, v, x, contacts, touch)
        if status != Status.RUNNING:
            return status
    return Status.RUNNING.value


@kernel
def add_series(sys, t, i, v, x, contacts, touch):
    """Give x the velocity from which contact i, held closed, comes to that after its series of bounces; a Status."""
    n, e, T = sys.n, sys.laws[i, LAW_E_N], touch.accumulates[i]
    status = rigid_rates(address(sys), address(contacts), t, x, touch.rates)
    if status != Status.RUNNING:
        return status
    for j in range(n, x.shape[0]):
        if not 2 * n <= j < 2 * n + sys.n_c:  # gaps are evaluated
            x[j] += T * (touch.flight[j] - touch.rates[j])
    status, m = find_landing(address(sys), t, i, v, x, address(contacts))
    times = (1.0 + e) / (1.0 - e)
    push(n, m, times, x, contacts)
    for k in range(m):
        place, P = contacts.contact[k], times * contacts.z[k]
        x[2 * n + (1 + contacts.part[k]) * sys.n_c + place] += P
        if slides_by(k, contacts):
            x[2 * n + 2 * sys.n_c + place] += contacts.ratio[place] * P
    return status


@kernel
def close_low_bounces(sys, t, x, contacts, touch):
    """Let the contacts touch whose next bounce is lower than the tolerance: (Status, how many, the last of them)."""
    work, kinds = contacts.work, sys.kinds
    n, n_c = sys.n, sys.n_c
    status = rigid_rates(address(sys), address(contacts), t, x, touch.rates)
    if status != Status.RUNNING:
        return status, 0, -1
    for i in range(n_c):
        work.closed[i] = i
    if not find_row_rates(sys, row_shift(sys, contacts.u), t, contacts.q, contacts.u, n_c, contacts.rates, work):
        return Status.NOT_FINITE.value, 0, -1
    for j in range(n):
        work.q_mid[j] = contacts.q[j]
    if not evaluate_rows(sys, True, t, contacts.u, work):
        return Status.NOT_FINITE.value, 0, -1
    height = max(contacts.numbers.atol, RESOLVED * rounded_length(n, contacts))
    r = 0
    n_closed, last = 0, -1
    contacts.numbers.flight = math.inf
    for i in range(n_c):
        v = touch.gamma[i, 0]
        if kinds[i, 0] == UNILATERAL and touch.is_touching[i] == 0 and v > 0.0 and work.g_N[i] <= height:
            a = contacts.rates[0, r]
            for j in range(n):
                a += work.W_N[i, j] * work.du[j]
            e = sys.laws[i, LAW_E_N]
            if a < 0.0 and e < 1.0 and v * v < 2.0 * -a * height:
                touch.is_touching[i] = 1
                touch.accumulates[i] = 2.0 * v / (-a * (1.0 - e))
                n_closed, last = n_closed + 1, i
            elif a < 0.0:
                contacts.numbers.flight = min(contacts.numbers.flight, 2.0 * v / -a)
        r += (1 if kinds[i, 0] != GIVEN_FORCE else 0) + kinds[i, 1]
    return Status.RUNNING.value, n_closed, last


@kernel
def note_events(sys, t, state, contacts, touch):
    """Append what changed: modes, impacts, paradoxes. The modes of a start are no event."""
    is_start = contacts.facts.event == AT_START and state.counters.steps == 0
    for i in range(sys.n_c):
        changed = contacts.mode[i] != state.mode[i] or contacts.slip[i] != state.slip[i]
        kind = touch.kind[i]
        if touch.impacts[i, 0] > 1 and kind != INDETERMINATE:
            write_event(t, i, INDETERMINATE, touch.impacts[i, 0], touch.impacts[i, 1], state, contacts, touch)
        if kind == MODE_CHANGE and (not changed or is_start):
            continue
        if kind == INDETERMINATE:
            write_event(t, i, kind, touch.found[i, 0], touch.found[i, 1], state, contacts, touch)
        else:
            write_event(t, i, kind, 0 if kind == INCONSISTENT else 1, 0, state, contacts, touch)
    for i in range(sys.n_c):
        state.mode[i], state.slip[i] = contacts.mode[i], contacts.slip[i]


@kernel
def write_event(t, i, kind, solutions, found, state, contacts, touch):
    """Append an event of contact i: impulses and velocities before it, number and modes of its solutions."""
    event = state.event
    event.P_N, event.P_F = touch.P[i, 0], touch.P[i, 1]
    event.gamma_N, event.gamma_F = touch.before[i, 0], touch.before[i, 1]
    event.solutions, event.found = solutions, found
    moment, mode, slip = t + touch.accumulates[i], contacts.mode[i], contacts.slip[i]
    append_event(moment, kind, i, state.mode[i], state.slip[i], mode, slip, state)
