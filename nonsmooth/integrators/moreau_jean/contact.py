"""The contact problem of one step: solve it, and follow the law of impact.

One closed contact is solved in closed form, several by the ladder of contact/planar/ladder.py. Theory:
docs/theory/moreau_jean.md, (4).
"""

from __future__ import annotations

import math
from typing import Annotated as Array

from nonsmooth.contact.planar.impacts import add_shock, go_on_from_shock, has_shock, strike
from nonsmooth.contact.planar.ladder import Route, solve_planar
from nonsmooth.contact.planar.problem import Planar
from nonsmooth.contact.planar.single import (
    FREE,
    STICK,
    count,
    solve_alone,
)
from nonsmooth.contact.spatial.all_solutions import SLIDE
from nonsmooth.contact.spatial.problem import Spatial
from nonsmooth.contact.spatial.solve import solve_spatial
from nonsmooth.errors import Status
from nonsmooth.integrators.records import State
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.jit.blocks import Block, Floats, Ints, address, view
from nonsmooth.mechanics.contact_problem import Work, fill_problem, recall_impulses
from nonsmooth.mechanics.impact import follows_own_law, impulses_by_law
from nonsmooth.mechanics.impact_in_space import Hodograph, collide_in_space, lose
from nonsmooth.mechanics.laws import (
    LAW_E_F,
    LAW_E_N,
    LAW_IMPACT,
    depends_on_speed,
    friction_coefficient,
    is_no_friction,
)
from nonsmooth.mechanics.sys import Sys
from nonsmooth.mechanics.system import ContactMode


class Options(Block):
    """What the integrator was asked for."""

    theta: float
    selection: int  # the rule where there are several solutions
    projection: int  # whether positions are moved back
    stiffness: float  # [N/m] of compliant contacts; 0 of rigid ones
    damping: float  # [N s/m]


class Scratch(Block, r="max(1, n_c * (1 + d))", n_q=0):
    """Arrays of one step."""

    options: Options
    work: Array[Work, "n_q = n_q"]
    there: Array[Work, "n_q = n_q"]  # the acceleration-level problem at the state before the step
    planar: Array[Planar, "n = n_c if d < 2 else 1"]
    spatial: Array[Spatial, "n = n_c if d > 1 else 0"]
    hodograph: Array[Hodograph, "most = 1"]  # of an impact with friction in two directions
    is_struck: int  # whether the impulses of the step hold those of one
    rates: Array[Floats, 4, "r"]
    is_known: Array[Ints, 2]  # 1 once M and the rows were evaluated, for those that are constant


@kernel("int64(int64, int64, float64, int64, int64, int64)", short_loops=True)
def solve(sys_at, selection, dt, n_k, state_at, scratch_at):
    """Solve the contact problem of the closed contacts: impulses to work.P, modes to work.candidate."""
    sys = view(sys_at, Sys)
    state, scratch = view(state_at, State), view(scratch_at, Scratch)
    work = scratch.work
    if scratch.spatial.mu.shape[0] > 0:
        return solve_in_space(sys, selection, dt, n_k, state, scratch)
    for k in range(n_k):
        i = work.closed[k]
        work.normal_impulse[k] = dt * max(0.0, work.N[i])
        if sys.kinds[i, 1] > 0:
            a = work.start[k + 1] - 1
            work.offset[a] = (1.0 - sys.laws[i, LAW_E_F]) * work.gamma_0[a]
            if depends_on_speed(sys.laws, i) and is_no_friction(
                friction_coefficient(sys.laws, i, abs(work.gamma_0[a]))
            ):
                state.counters.failed_contact = i
                return Status.NEGATIVE_FRICTION
    state.counters.solved += 1
    fill_problem(sys, n_k, selection, state.mode, state.slip, work)
    if n_k == 1:
        is_struck = work.gamma_0[0] < 0.0 and strike_alone(sys, work)
        found = solve_one(state, work)
        if is_struck:
            if found == 0:
                work.P[0], work.P[1], work.candidate[0], found = 0.0, 0.0, FREE, 1
            add_shock(1, work)
        elif found == 0:
            state.counters.failed_contact = work.closed[0]
            return Status.NO_SOLUTION
        state.counters.solutions = found
        return Status.RUNNING
    recall_impulses(state.P, work)
    is_struck = scratch.options.stiffness == 0.0 and has_shock(n_k, sys, work)
    if is_struck and not strike(address(sys), n_k, 0.0, address(work), address(scratch.planar)):
        state.counters.failed_contact = -1
        return Status.NOT_SOLVED
    route, found, pivots, residual = solve_planar(address(work), address(scratch.planar))
    if is_struck:
        add_shock(n_k, work)
    state.counters.found = 0
    state.counters.pivots += pivots
    if route <= Route.NO_SOLUTION:
        state.counters.failed_contact = -1
        return Status.NO_SOLUTION if route == Route.NO_SOLUTION else Status.NOT_SOLVED
    state.worst.residual = max(state.worst.residual, residual)
    if route == Route.KEPT or route == Route.KEPT_MODES:
        state.counters.kept += 1
    if scratch.planar.is_counted == 0:
        state.counters.uncounted += 1
    if scratch.planar.is_shared == 1:
        state.counters.shared += 1
    state.counters.solutions = found
    return Status.RUNNING


@rare_kernel
def solve_in_space(sys, selection, dt, n_k, state, scratch):
    """The same where some contacts have friction in two directions."""
    work, counters = scratch.work, state.counters
    for k in range(n_k):
        i = work.closed[k]
        work.normal_impulse[k] = dt * max(0.0, work.N[i])
        for a in range(work.start[k + 1] - sys.kinds[i, 1], work.start[k + 1]):
            work.offset[a] = (1.0 - sys.laws[i, LAW_E_F]) * work.gamma_0[a]
    counters.solved += 1
    fill_problem(sys, n_k, selection, state.mode, state.slip, work)
    recall_impulses(state.P, work)
    scratch.is_struck = 0
    if n_k == 1 and work.gamma_0[0] < 0.0 and follows_law_in_space(sys, scratch):
        set_up_impact(sys, scratch)
        strike_in_space(sys, scratch)
    status, found, error = solve_and_add_shock(n_k, scratch)
    if status != Status.RUNNING:
        counters.failed_contact = found if status == Status.NEGATIVE_FRICTION else work.closed[0] if n_k == 1 else -1
        return status
    state.worst.residual = max(state.worst.residual, error)
    counters.uncounted += 1 if found == 0 else 0
    counters.solutions, counters.found = found, 0
    return status


@kernel
def follows_law_in_space(sys, scratch):
    """Whether the only closed contact, with friction in two directions, follows another law than Newton's."""
    return scratch.options.stiffness == 0.0 and follows_own_law(scratch.work.closed[0], sys.kinds, sys.laws)


@rare_kernel
def set_up_impact(sys, scratch):
    """Write what goes into an impact of the single closed contact by its own law to the hodograph."""
    work, h, i = scratch.work, scratch.hodograph, scratch.work.closed[0]
    for a in range(3):
        h.before[a] = work.gamma_0[a]
        for b in range(3):
            h.G[a, b] = work.G[a, b]
    h.before[0] = min(0.0, work.gamma_0[0])
    h.mu = friction_coefficient(sys.laws, i, math.sqrt(h.before[1] * h.before[1] + h.before[2] * h.before[2]))
    h.e, h.law = sys.laws[i, LAW_E_N], int(sys.laws[i, LAW_IMPACT])


@rare_kernel
def strike_in_space(sys, scratch):
    """Find the impulses of the impact of the hodograph, to work.shock, and take it into work.c; nothing where its
    compression never ends."""
    work, h = scratch.work, scratch.hodograph
    if collide_in_space(address(h)):
        scratch.is_struck = 1
        for a in range(3):
            work.c_kept[a], work.shock[a] = work.c[a], h.impulse[a]
        go_on_from_shock(sys, 1, work)


@rare_kernel
def strike_lost_slide(sys, n_k, scratch):
    """Strike with the slide of the hodograph, which has no force, once the step was solved without that; then solve
    the step from there."""
    work, h = scratch.work, scratch.hodograph
    if scratch.is_struck == 1:  # by what the rounding of gamma_N was
        scratch.is_struck = 0
        for a in range(3):
            work.c[a] = work.c_kept[a]
    approach = h.before[0]
    lose(h)
    h.before[0] = min(h.before[0], approach)
    strike_in_space(sys, scratch)
    solve_and_add_shock(n_k, scratch)


@kernel
def solve_and_add_shock(n_k, scratch):
    """The step's own problem, and the impulses of an impact before it: (Status, number of solutions, residual)."""
    work, h = scratch.work, scratch.hodograph
    status, found, error = solve_spatial(address(work), address(scratch.spatial))
    if scratch.is_struck == 1 and status == Status.RUNNING:
        if work.candidate[0] == FREE:
            work.candidate[0] = STICK if h.sticks == 1 else SLIDE
        add_shock(n_k, work)
    return status, found, error


@kernel
def solve_one(state, work):
    """The single closed contact in closed form; returns the number of solutions."""
    found, error = solve_alone(0, work)
    state.counters.found = found
    if error > 0.0:
        size = max(abs(work.c[0]), abs(work.c[1]))
        if error > state.worst.residual * size:
            state.worst.residual = error / size
    return count(found)


@kernel
def strike_alone(sys, work):
    """Find the impulses of an impact of the single closed contact by its own law, to work.shock, and take it into
    work.c; False where it has none, or its compression never ends. A step from there without a solution, which a slide
    that goes on has, is that of the impact alone."""
    i = work.closed[0]
    if not follows_own_law(i, sys.kinds, sys.laws):
        return False
    for a in range(2):
        work.c_kept[a] = work.c[a]
    if not impulses_by_law(sys.laws, i, work.gamma_0, work.G, work.shock):
        return False
    go_on_from_shock(sys, 1, work)
    return True


@kernel
def mode_of(candidate, d):
    """The ContactMode of a candidate."""
    if candidate == FREE:
        return ContactMode.OPEN.value
    if d == 0:
        return ContactMode.LOCKED.value
    return ContactMode.STICK.value if candidate == STICK else ContactMode.SLIDE.value
