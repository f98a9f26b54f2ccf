"""One adaptive step of smooth motion: extrapolated plain steps with the modes held, to its end or to its first event.

1. Rows of 1, 2, 3, ... plain steps are extrapolated until the error is below the tolerance (adaptive/table.py). Modes
   are held, so no event within the step disturbs them.
2. The end is moved onto the constraints of the modes, and events are looked for on the motion (adaptive/events.py).
   A step that holds one is taken anew to end there. Where the first rows see one near the beginning, the step is cut
   to just behind it before the others are computed.
3. Modes are decided at events only (adaptive/switch.py). A step that cannot be resolved although nothing moves in it is
   one through something that is not smooth and no event: it is taken by plain steps (adaptive/through.py).

Sources: Studer, Leine, Glocker, *Int. J. Numer. Meth. Engng* 76 (2008) 1747; Eich, *SIAM J. Numer. Anal.* 30 (1993)
1467.
"""

from __future__ import annotations

import math

from nonsmooth.errors import Status
from nonsmooth.integrators.adaptive.events import NOWHERE, crossing, find_event
from nonsmooth.integrators.adaptive.held import list_closed
from nonsmooth.integrators.adaptive.jumps import (
    CHANCE,
    begin_forces,
    end_before,
    find_jump,
    jump_between_nodes,
    note_forces,
)
from nonsmooth.integrators.adaptive.polynomial import fit_polynomial, followed_growth
from nonsmooth.integrators.adaptive.scales import evaluate_gaps, length_of_instant
from nonsmooth.integrators.adaptive.state import N_ROWS, Extrapolation
from nonsmooth.integrators.adaptive.table import (
    LEAST_GAIN,
    MOST_GAIN,
    SLOWEST,
    STEP_SAFETY,
    converges,
    extrapolate,
    fill_row,
    growth_of_step,
)
from nonsmooth.integrators.records import FORCE_WORK, N_LEDGER, State
from nonsmooth.integrators.rigid.hold import hold_constraints
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import address, view
from nonsmooth.mechanics.sys import Sys

# How a step that was tried ended: it is refused; accepted; accepted, and modes are to be decided at its end; not taken,
# since they are to be decided at its beginning; not taken, since it cannot be resolved; it converged, but the motion
# within it is not followed yet: more rows give more of its derivatives.
REFUSED, SMOOTH, AT_EVENT, AT_ONCE, UNRESOLVED, UNFOLLOWED = range(6)
FAILED_STEP_PART = 0.3  # chosen: of a step that fails
EARLY_EVENT = 0.3  # chosen: of the step: an event before it is not worth the other rows
BEHIND_EVENT = 2.0  # chosen: of the way to an event as the first rows see it: where the step that looks for it ends
# chosen: of it: where a step ends that does not converge, maybe because the forces are not smooth behind it
BEFORE_EVENT = 0.9


@kernel("Tuple((int64, int64, float64))(int64, float64, float64, int64, int64)", short_loops=True)
def try_step(sys_at, t, H, state_at, run_at):
    """Try one step of length H: (Status, how it ended, what to multiply H by). ``run.change`` is what it changes, and
    clock.cut where an event is to end the next one."""
    sys = view(sys_at, Sys)
    state, run = view(state_at, State), view(run_at, Extrapolation)
    target = run.counters.target
    place = NOWHERE
    for j in range(N_ROWS):
        status = fill_row(sys, t, H, j, state, run)
        if status != Status.RUNNING:
            return status, REFUSED, FAILED_STEP_PART
        if j == 0:
            continue
        extrapolate(sys, j, list_closed(sys, run.contacts), state, run)
        if run.counters.is_seen == 1 and run.counters.is_located == 0:
            place = crossing(j + 1, run)
            if place < EARLY_EVENT and BEHIND_EVENT * place * H > run.clock.least:
                run.clock.cut = BEHIND_EVENT * place * H
                return Status.RUNNING.value, REFUSED, 1.0
        if converges(j, run):
            status, outcome, factor = end_step(sys, t, H, j, state_at, state, run_at, run)
            if outcome != UNFOLLOWED:
                return status, outcome, factor
            if j >= target:
                return status, REFUSED, factor
        elif j == target or is_hopeless(j, target, run):
            break
    if H <= length_of_instant(run):
        return Status.RUNNING.value, UNRESOLVED, 1.0
    if run.errors[j] > CHANCE * run.errors[j - 1]:
        status, jump = jump_between_nodes(sys, t, H, j + 1, state, run)
        if status != Status.RUNNING:
            return status, REFUSED, FAILED_STEP_PART
        if jump < 1.0:
            return status, REFUSED if end_before(jump, H, run) else UNRESOLVED, 1.0
    factor = shorter(j, target, run)
    if factor < BEFORE_EVENT * place < 1.0:
        run.clock.cut = BEFORE_EVENT * place * H
        return Status.RUNNING.value, REFUSED, 1.0
    return Status.RUNNING.value, REFUSED, factor


@kernel
def is_hopeless(j, target, run):
    """Whether no later row will do: the rows diverge, or the last one would have to gain more than is believed."""
    return (j > 1 and run.errors[j] > run.errors[j - 1]) or (j == target - 1 and run.errors[j] > MOST_GAIN)


@kernel
def shorter(j, target, run):
    """The factor of a step whose rows ended at row j: so long steps are not yet of the order of their rows, and their
    errors fall with half of it, as measured."""
    error = run.errors[j] if j >= target else run.errors[j] / LEAST_GAIN
    if not math.isfinite(error):
        return SLOWEST
    return min(STEP_SAFETY, max(SLOWEST, STEP_SAFETY * error ** (-2.0 / (j + 2.0))))


@kernel
def end_step(sys, t, H, j, state_at, state, run_at, run):
    """End a step that converged at row j, if it holds no event; returns as ``try_step`` does."""
    n, n_c, x = state.q.shape[0], state.mode.shape[0], run.x
    for i in range(n):
        x[i] = state.q[i] + run.change[i]
        x[n + i] = state.u[i] + run.change[n + i]
    if n_c > 0:
        status = hold_constraints(address(sys), t + H, x, False, address(run.contacts))
        if status != Status.RUNNING:
            return status, REFUSED, FAILED_STEP_PART
        book_constraint_work(n, state, run)
    fit_polynomial(H, j, state, run)
    followed = followed_growth(H, j, state, run)
    if followed < 1.0 and H > length_of_instant(run):
        return Status.RUNNING.value, UNFOLLOWED, STEP_SAFETY * max(SLOWEST, followed)
    factor = min(growth_of_step(j, run), STEP_SAFETY * followed) if j >= run.counters.target else growth_of_step(j, run)
    status, place = begin_forces(sys, t, state, run), NOWHERE
    if status == Status.RUNNING and n_c > 0:
        status, place = find_event(address(sys), t, H, j, state_at, run_at)
    if status == Status.RUNNING and place >= 1.0:
        status = note_forces(sys, t + H, run)
    if status != Status.RUNNING:
        return status, REFUSED, FAILED_STEP_PART
    if place < 1.0:
        run.clock.cut = place * H
        if place * H <= run.clock.least:
            return Status.RUNNING.value, AT_ONCE, 1.0
        run.counters.is_located = 1
        return Status.RUNNING.value, REFUSED, 1.0
    status, jump = find_jump(sys, t, H, j, state, run)
    if status != Status.RUNNING:
        return status, REFUSED, FAILED_STEP_PART
    if jump < 1.0 and (1.0 - jump) * H > length_of_instant(run):
        return status, REFUSED if end_before(jump, H, run) else UNRESOLVED, 1.0
    if jump < 1.0:
        run.counters.at_jump = 1
    if n_c > 0 and not evaluate_gaps(sys, t + H, x, run.g_1, run.gamma_1, run):
        return Status.NOT_FINITE.value, REFUSED, FAILED_STEP_PART
    return Status.RUNNING.value, AT_EVENT if place == 1.0 else SMOOTH, factor


@kernel
def book_constraint_work(n, state, run):
    """Count what the move onto the constraints changed, the work of the forces over it included."""
    x, change = run.x, run.change
    works = change.shape[0] - N_LEDGER
    for i in range(n):
        moved = x[i] - state.q[i] - change[i]
        change[works + FORCE_WORK] += run.contacts.work.h[i] * moved
