"""The contact problem of one step: solve it, follow the law of impact, and name what rigid mechanics leaves open.

One closed contact is solved in closed form, several by the ladder of contact_solvers/planar.py. Theory:
docs/theory/moreau_jean.md.
"""

from __future__ import annotations

from nonsmooth.blocks import address
from nonsmooth.contact_solvers.planar import Route, solve_planar
from nonsmooth.contact_solvers.single import (
    BOUNDARY,
    FREE,
    NO_CANDIDATE,
    SLIDE_MINUS,
    SLIDE_PLUS,
    STICK,
    count,
    slip_of,
    solve_given_force,
    solve_single,
)
from nonsmooth.errors import Status
from nonsmooth.integrators.records import (
    FAILED_CONTACT,
    FOUND,
    INCONSISTENT,
    INDETERMINATE,
    KEPT,
    PIVOTS,
    RESIDUAL,
    SEVERAL,
    SOLVED,
    add_event,
)
from nonsmooth.jit import kernel
from nonsmooth.laws import LAW_E_F, depends_on_speed, friction_coefficient
from nonsmooth.paradox.impact import follows_own_law, impulses_by_law
from nonsmooth.paradox.resolve import had_no_force
from nonsmooth.system import BILATERAL, GIVEN_FORCE, UNILATERAL, ContactMode


@kernel
def solve(model, has, p, kinds, laws, selection, t, dt, n, n_k, state, scratch):
    """Solve the contact problem of the closed contacts: impulses to work.P, modes to scratch.candidate."""
    work = scratch.work
    for k in range(n_k):
        i = work.closed[k]
        if kinds[i, 1] > 0:
            a = work.start[k + 1] - 1
            scratch.offset[a] = (1.0 - laws[i, LAW_E_F]) * work.gamma_0[a]
            if depends_on_speed(laws, i) and friction_coefficient(laws, i, abs(work.gamma_0[a])) < 0.0:
                state.counters[FAILED_CONTACT] = i
                return Status.NEGATIVE_FRICTION
    state.counters[SOLVED] += 1
    if n_k == 1:
        found = solve_one(kinds, laws, dt, selection, state, scratch)
        if found == 0:
            state.counters[FAILED_CONTACT] = work.closed[0]
            return Status.NO_SOLUTION
        if work.gamma_0[0] < 0.0 and follows_own_law(work.closed[0], kinds, laws):
            follow_impact_law(laws, scratch)
        note_paradoxes(model, has, p, kinds, laws, t, dt, n, n_k, found, state, scratch)
        return Status.RUNNING
    for k in range(n_k):
        scratch.planar.normal_impulse[k] = dt * max(0.0, work.N[work.closed[k]])
    route, found, pivots, residual = solve_planar(
        n_k, work.closed, work.start, kinds, laws, work.G, work.c, scratch.offset, state.P, state.mode, state.slip,
        selection, work.P, address(scratch.planar),
    )  # fmt: skip
    state.counters[FOUND] = 0
    state.counters[PIVOTS] += pivots
    if route <= Route.NO_SOLUTION:
        state.counters[FAILED_CONTACT] = -1
        return Status.NO_SOLUTION if route == Route.NO_SOLUTION else Status.NOT_SOLVED
    state.worst[RESIDUAL] = max(state.worst[RESIDUAL], residual)
    if route == Route.KEPT or route == Route.KEPT_MODES:
        state.counters[KEPT] += 1
    for k in range(n_k):
        scratch.candidate[k] = scratch.planar.candidate[k]
    note_paradoxes(model, has, p, kinds, laws, t, dt, n, n_k, found, state, scratch)
    return Status.RUNNING


@kernel
def solve_one(kinds, laws, dt, selection, state, scratch):
    """The single closed contact in closed form; returns the number of solutions."""
    work = scratch.work
    i = work.closed[0]
    kind, d = kinds[i, 0], kinds[i, 1]
    G, c, P = work.G, work.c, work.P
    was_stuck = state.mode[i] == ContactMode.STICK
    if kind == GIVEN_FORCE:
        scratch.candidate[0], P[0] = solve_given_force(
            laws, i, G[0, 0], c[0], scratch.offset[0], dt * max(0.0, work.N[i]), was_stuck, state.slip[i]
        )
        return 1
    if d == 0:
        P[0] = -c[0] / G[0, 0]
        if kind == UNILATERAL:
            P[0] = max(0.0, P[0])
        scratch.candidate[0] = STICK if P[0] != 0.0 or kind == BILATERAL else FREE
        return 1
    candidate, P[0], P[1], found = solve_single(
        kind, laws, i, G[0, 0], G[0, 1], G[1, 0], G[1, 1], c[0], c[1], scratch.offset[1],
        was_stuck, state.slip[i], selection,
    )  # fmt: skip
    scratch.candidate[0] = candidate
    state.counters[FOUND] = found
    if candidate == NO_CANDIDATE:
        return 0
    if candidate != FREE:
        error = abs(c[0] + G[0, 0] * P[0] + G[0, 1] * P[1])
        if candidate == STICK:
            error = max(error, abs(c[1] + G[1, 0] * P[0] + G[1, 1] * P[1]))
        size = max(abs(c[0]), abs(c[1]))
        if error > state.worst[RESIDUAL] * size:
            state.worst[RESIDUAL] = error / size
    return count(found)


@kernel
def follow_impact_law(laws, scratch):
    """Replace the impulses of the single closed contact, which collides, by those of its law, and its mode."""
    work = scratch.work
    G, P, gamma_0 = work.G, work.P, work.gamma_0
    if impulses_by_law(laws, work.closed[0], gamma_0, G, P):
        gamma_F = gamma_0[1] + G[1, 0] * P[0] + G[1, 1] * P[1]
        if abs(gamma_F) <= BOUNDARY * abs(gamma_0[1]):
            scratch.candidate[0] = STICK
        else:
            scratch.candidate[0] = SLIDE_PLUS if gamma_F > 0.0 else SLIDE_MINUS


@kernel
def mode_of(candidate, d):
    """The ContactMode of a candidate."""
    if candidate == FREE:
        return ContactMode.OPEN.value
    if d == 0:
        return ContactMode.LOCKED.value
    return ContactMode.STICK.value if candidate == STICK else ContactMode.SLIDE.value


@kernel
def note_paradoxes(model, has, p, kinds, laws, t, dt, n, n_k, found, state, scratch):
    """Record the beginning of an episode with several solutions, and sliding that no force could go with."""
    work = scratch.work
    is_indeterminate = found >= 3 or (found == 2 and n_k > 1)
    if is_indeterminate:
        state.counters[SEVERAL] += 1
    for k in range(n_k):
        i = work.closed[k]
        if kinds[i, 1] == 0 or kinds[i, 0] == GIVEN_FORCE:
            continue
        candidate = scratch.candidate[k]
        mode = mode_of(candidate, 1)
        if is_indeterminate and state.several[i] == 0:
            add_event(t, INDETERMINATE, i, mode, slip_of(candidate), k, found, kinds, state, work)
        state.several[i] = 1 if is_indeterminate else 0
        if candidate == STICK and state.mode[i] == ContactMode.SLIDE:
            a = work.start[k]
            mu = friction_coefficient(laws, i, abs(work.gamma_0[a + 1]))
            has_negative = work.G[a, a] < mu * abs(work.G[a, a + 1])
            if has_negative and had_no_force(
                model, has, p, kinds, mu, state.slip[i], t, dt, n, n_k, k, state.q, state.u,
                address(work), address(scratch.there), scratch.rates,
            ):  # fmt: skip
                if follows_own_law(i, kinds, laws):
                    impulses_by_law(laws, i, work.gamma_0, work.G, work.P)
                add_event(t, INCONSISTENT, i, mode, 0, k, 0, kinds, state, work)
