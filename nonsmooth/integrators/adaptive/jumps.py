"""Where the forces jump within an adaptive step, as the friction of a signum in ``force`` or a load that is switched.

Plain steps evaluate forces in their middles, so that the first and the last 1/(2 m) of a step of m of them are seen by
none. There the accelerations are compared with the slopes u' of the polynomial of the step (polynomial.py):

    r(theta) = M^-1 (h + W^T la) - u'(theta),    H |r| <= SEEN_JUMP tolerances of the velocities at both ends

of which a jump could have moved them by 1/(2 m). The end of a step is the beginning of the next: one evaluation serves
both. Where r is larger it is asked for half a plain step from there: nearly the same of a smooth motion, whose slope at
an end is not exact, and none if the forces have jumped between. The interval is then halved: the change of r fades with
it, or does not where there is a jump, which is enclosed to the resolution of time. The step ends before it, and plain
steps so short that nothing moves in them by its tolerance go over it (through.py). Where the rows of a step do
not approach one another, or did not before the last, the same is asked of the motion between the nodes of the last row,
of the interval with the first large change of the accelerations.
"""

from __future__ import annotations

import math

from nonsmooth.errors import Status
from nonsmooth.integrators.adaptive.events import event_values, values_within
from nonsmooth.integrators.adaptive.scales import length_of_instant
from nonsmooth.integrators.adaptive.state import NOWHERE, VELOCITY_DEGREE
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.numerics.rounding import spacing

SEEN_JUMP = 200.0  # tolerances of H r: 1 to 100 of a smooth motion, as measured
SEEN_JUMP_AGAIN = 2.0  # chosen: once the forces have jumped: there may be hundreds
# chosen: of the error of a row, that of the next: so little is gained where the rows do not approach one another
CHANCE = 0.5
FADES = 0.3  # chosen: of the change of r: in a quarter of an interval that of a smooth motion is less
STEEP = 1.0 / 32.0  # chosen: of the interval: what changes within it is a jump for this step, however smooth it may be
JUMP_HALVINGS = 100  # chosen: bisection takes 52 to the last place
# chosen: of a step with many jumps at an end of it, none of which stands out, or of a motion without its forces
JUMPY_STEP_PART = 0.3
LARGE_JUMP = 0.5  # chosen: of the largest change of the accelerations between two plain steps
BEGIN, MIDDLE, END, LAST = range(4)
# chosen: where the forces are looked at once they have jumped: these of no plain step
PLACES_LOOKED_AT, PLACE_OF_LOOK = 8, 0.37


@kernel
def begin_forces(sys, t, state, run):
    """The accelerations at the beginning of the step, to run.force_0, unless they are known; returns a Status."""
    n, status = state.q.shape[0], Status.RUNNING.value
    if run.counters.has_forces == 1:
        return status
    for i in range(n):
        run.y[i], run.y[n + i] = state.q[i], state.u[i]
    status = event_values(sys, t, run.y, run, run.f_in)
    for i in range(n):
        run.force_0[i] = run.contacts.work.du[i]
    run.counters.has_forces = 1
    return status


@kernel
def keep_forces(run):
    """The accelerations at the end of a step as those at the beginning of the next."""
    for i in range(run.force_1.shape[0]):
        run.force_0[i] = run.force_1[i]


@kernel
def note_forces(sys, t_1, run):
    """The accelerations at the end of the step, to run.force_1; returns a Status. With contacts they are known."""
    status = Status.RUNNING.value
    if sys.n_c == 0:
        status = event_values(sys, t_1, run.x, run, run.f_1)
    for i in range(run.force_1.shape[0]):
        run.force_1[i] = run.contacts.work.du[i]
    return status


@kernel
def seen(run):
    """Tolerances of H r above which a jump is looked for."""
    return SEEN_JUMP if run.counters.jumps == 0 else SEEN_JUMP_AGAIN


@kernel
def are_followed(H, run):
    """Whether the motion of a fitted step has the accelerations (of its beginning, of its end)."""
    n = run.force_1.shape[0]
    at_begin, at_end = True, True
    for i in range(n):
        tol, slope = seen(run) * run.tol[n + i], 0.0
        for k in range(VELOCITY_DEGREE):
            slope += (k + 1) * run.B[k, i]
        run.jump[BEGIN, i] = H * run.force_0[i] - run.B[0, i]
        run.jump[END, i] = H * run.force_1[i] - slope
        at_begin = at_begin and not abs(run.jump[BEGIN, i]) > tol
        at_end = at_end and not abs(run.jump[END, i]) > tol
    return at_begin, at_end


@kernel
def find_jump(sys, t, H, j, state, run):
    """(Status, place) of a jump of the forces in a fitted step that converged at row j; NOWHERE if there is none."""
    m, status, place = j + 1, Status.RUNNING.value, NOWHERE
    at_begin, at_end = are_followed(H, run)
    is_chance = run.counters.jumps == 0 and j > 1 and run.errors[j - 1] > CHANCE * run.errors[j - 2]
    if at_begin and at_end and not is_chance and run.counters.jumps == 0:
        return status, place
    if not at_begin:
        status, place = jump_at_end(sys, t, H, m, BEGIN, state, run)
    if not at_end and status == Status.RUNNING and place == NOWHERE:
        are_followed(H, run)
        status, place = jump_at_end(sys, t, H, m, END, state, run)
    if is_chance and status == Status.RUNNING and place == NOWHERE:
        status, place = jump_between_nodes(sys, t, H, m, state, run)
    if run.counters.jumps > 0 and status == Status.RUNNING and place == NOWHERE:
        status, place = jump_between_places(sys, t, H, state, run)
    if status == Status.RUNNING and sys.n_c > 0:
        status = event_values(sys, t + H, run.x, run, run.f_1)  # the forces at the end are known again
    return status, place


@rare_kernel
def jump_at_end(sys, t, H, m, end, state, run):
    """(Status, place) of a jump in the half plain step at an end of the fitted step, whose r is in run.jump.

    Of a smooth motion r is that of the middle of the plain step too, nearly: the slope at the end is not exact.
    """
    part = 0.5 / m
    status = rest_at(sys, t, H, part if end == BEGIN else 1.0 - part, 0, MIDDLE, state, run)
    has_jumped = run.counters.jumps > 0
    if status != Status.RUNNING or distance(MIDDLE, end, run) < FADES * size_of_rest(end, run):
        return status, JUMPY_STEP_PART if has_jumped and size_of_rest(MIDDLE, run) > SEEN_JUMP else NOWHERE
    low = 0.0 if end == BEGIN else 1.0 - 2.0 * part
    status, place = enclose_jump(sys, t, H, low, low + 2.0 * part, 0, state, run)
    return status, JUMPY_STEP_PART if place == NOWHERE and has_jumped else place


@rare_kernel
def jump_between_places(sys, t, H, state, run):
    """(Status, place) of a jump within a fitted step of forces that have jumped before; NOWHERE if there is none."""
    n = state.q.shape[0]
    for i in range(n):
        run.jump[LAST, i] = H * run.force_0[i] - run.B[0, i]
    largest, first, before = seen(run), NOWHERE, 0.0
    for k in range(PLACES_LOOKED_AT):
        place = (k + PLACE_OF_LOOK) / PLACES_LOOKED_AT
        status = rest_at(sys, t, H, place, 0, MIDDLE, state, run)
        if status != Status.RUNNING:
            return status, NOWHERE
        change = distance(LAST, MIDDLE, run)
        if change > largest:
            largest, first = change, before
        for i in range(n):
            run.jump[LAST, i] = run.jump[MIDDLE, i]
        before = place
    if first == NOWHERE:
        return Status.RUNNING.value, NOWHERE
    return enclose_jump(sys, t, H, first, first + 1.0 / PLACES_LOOKED_AT, 0, state, run)


@rare_kernel
def jump_between_nodes(sys, t, H, m, state, run):
    """(Status, place) of the first jump of the forces among the m plain steps of the last row; NOWHERE if none is
    enclosed."""
    n, largest, first = state.q.shape[0], 0.0, 0
    for k in range(m - 1, 0, -1):
        change = 0.0
        for i in range(n):
            bend = run.node_u[k + 1, i] - 2.0 * run.node_u[k, i] + run.node_u[k - 1, i]
            change = max(change, abs(bend) / run.tol[n + i])
        first = k if change >= LARGE_JUMP * largest else first
        largest = max(largest, change)
    if first == 0:
        return Status.RUNNING.value, NOWHERE
    return enclose_jump(sys, t, H, (first - 0.5) / m, (first + 0.5) / m, m, state, run)


@rare_kernel
def enclose_jump(sys, t, H, low, high, m, state, run):
    """(Status, the place before a jump of the forces between two others), on the motion that was fitted or, where
    m > 0, on that between the nodes; NOWHERE if their change fades as the interval does."""
    r, width = run.jump, high - low
    status = rest_at(sys, t, H, low, m, BEGIN, state, run)
    if status == Status.RUNNING:
        status = rest_at(sys, t, H, high, m, END, state, run)
    change = distance(BEGIN, END, run)
    largest, earlier = change, change
    for _ in range(JUMP_HALVINGS):
        if status != Status.RUNNING or (high - low) * H <= run.clock.least or high - low <= spacing(high):
            break
        middle = 0.5 * (low + high)
        status = rest_at(sys, t, H, middle, m, MIDDLE, state, run)
        before, after = distance(BEGIN, MIDDLE, run), distance(MIDDLE, END, run)
        largest = max(largest, before, after)
        is_before = before >= after
        if not max(before, after) >= FADES * earlier:
            break
        earlier, change = change, before if is_before else after
        low, high = (low, middle) if is_before else (middle, high)
        for i in range(r.shape[1]):
            r[END if is_before else BEGIN, i] = r[MIDDLE, i]
    is_jump = high - low <= STEEP * width and largest > SEEN_JUMP_AGAIN
    run.counters.jumps += 1 if is_jump else 0
    return status, low if is_jump else NOWHERE


@rare_kernel
def rest_at(sys, t, H, place, m, which, state, run):
    """run.jump[which] = H r at a place of the step; returns a Status."""
    n, theta = state.q.shape[0], place
    if m == 0:
        status = values_within(sys, t, H, place, state, run)
    else:
        state_between(place, H, m, n, run)
        status = event_values(sys, t + place * H, run.y, run, run.f_in)
    for i in range(n):
        slope = 0.0
        if m == 0:
            for k in range(VELOCITY_DEGREE - 1, -1, -1):
                slope = (k + 1) * run.B[k, i] + theta * slope
        run.jump[which, i] = H * run.contacts.work.du[i] - slope
    return status


@kernel
def state_between(place, H, m, n, run):
    """run.y: the state at a place of a step of m plain steps, velocities linear between their ends."""
    k = min(m - 1, int(math.floor(place * m)))
    part, dt = place * m - k, H / m
    for i in range(n):
        change = part * (run.node_u[k + 1, i] - run.node_u[k, i])
        run.y[i] = run.node_q[k, i] + part * dt * (run.node_u[k, i] + 0.5 * change)
        run.y[n + i] = run.node_u[k, i] + change


@kernel
def distance(a, b, run):
    """Between two of run.jump, in tolerances of the velocities."""
    n, largest = run.force_1.shape[0], 0.0
    for i in range(n):
        largest = max(largest, abs(run.jump[a, i] - run.jump[b, i]) / run.tol[n + i])
    return largest


@kernel
def size_of_rest(which, run):
    """Of one of run.jump, in tolerances of the velocities."""
    n, largest = run.force_1.shape[0], 0.0
    for i in range(n):
        largest = max(largest, abs(run.jump[which, i]) / run.tol[n + i])
    return largest


@kernel
def end_before(place, H, run):
    """Whether there is a step that ends where the forces jump, which is asked for: else the jump is at hand."""
    if not place * H > length_of_instant(run):
        return False
    run.clock.cut = place * H
    run.counters.at_jump = 1
    return True
