"""What rigid mechanics leaves open in a step: several solutions are noted, and an impact without collision is taken.

A slide that runs out of forces ends at once, at the state before the step, by the impulses that stop it:

    M (u_+ - u_0) = W^T P,    W u_+ + w = 0,    or P of the contact's own law of impact

and the step is taken again from u_+. Spread over the step, with rows carried to its ends by u_0, they would hand the
next steps an error of contact velocity of O(dt), an error of their forces of O(1), and end the sticking. Where other
contacts are coupled to it they are spread all the same. The event holds the impulses of the step's own contact problem,
which tend to those of the impact. Theory: docs/theory/moreau_jean.md.
"""

from __future__ import annotations

from nonsmooth.contact.islands import is_block
from nonsmooth.contact.planar.single import FREE, STICK, slip_of, stick
from nonsmooth.contact.spatial.all_solutions import is_surely_unique
from nonsmooth.integrators.moreau_jean.contact import (
    Scratch,
    mode_of,
    set_up_impact,
    strike_lost_slide,
)
from nonsmooth.integrators.moreau_jean.slide_end import had_no_force, slid_without_force, turned_without_force
from nonsmooth.integrators.records import (
    INCONSISTENT,
    INDETERMINATE,
    State,
    append_event,
    book_energy,
    describe_closed,
    set_mode,
)
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.jit.blocks import address, view
from nonsmooth.mechanics.contact_problem import row_velocities
from nonsmooth.mechanics.impact import follows_own_law, impulses_by_law
from nonsmooth.mechanics.laws import friction_coefficient
from nonsmooth.mechanics.sys import Sys
from nonsmooth.mechanics.system import BILATERAL, GIVEN_FORCE, ContactMode


@kernel
def note_paradoxes(sys, t, dt, n_k, state, scratch):
    """Record sliding that no force could go with, and the beginning of an episode with several solutions.

    Returns whether the velocity has jumped, so that the step must be taken again.
    """
    work = scratch.work
    if scratch.spatial.mu.shape[0] > 0:
        note_in_space(sys, t, dt, n_k, state, scratch)
        return False
    found, members, has_several = state.counters.solutions, 1, False
    for k in range(n_k):
        i = work.closed[k]
        if sys.kinds[i, 1] == 0 or sys.kinds[i, 0] == GIVEN_FORCE:
            continue
        if n_k > 1:  # of the island of the contact
            found, members = scratch.planar.found[k], scratch.planar.members[k]
            state.counters.found = scratch.planar.bits[k]
        is_indeterminate = found >= 3 or (found == 2 and members > 1)
        has_several = has_several or is_indeterminate
        candidate = work.candidate[k]
        if candidate == STICK and state.mode[i] == ContactMode.SLIDE:
            a = work.start[k]
            mu = friction_coefficient(sys.laws, i, abs(work.gamma_0[a + 1]))
            has_negative = work.G[a, a] < mu * abs(work.G[a, a + 1])
            if has_negative and end_slide(address(sys), mu, t, dt, n_k, k, address(state), address(scratch)):
                return True
        if is_indeterminate and state.several[i] == 0:
            mode = mode_of(candidate, 1)
            describe_closed(sys, k, found, state, work)
            append_event(t, INDETERMINATE, i, state.mode[i], state.slip[i], mode, slip_of(candidate), state)
        state.several[i] = 1 if is_indeterminate else 0
    if has_several:
        state.counters.several += 1
    return False


@rare_kernel
def note_in_space(sys, t, dt, n_k, state, scratch):
    """The same where contacts have friction in two directions: the impulses that end a slide are spread over the step,
    and the solutions of a contact are known where it is the only one that is closed."""
    work, found = scratch.work, state.counters.solutions
    for k in range(n_k):
        i = work.closed[k]
        if sys.kinds[i, 1] < 2 or sys.kinds[i, 0] == GIVEN_FORCE:
            continue
        is_indeterminate = n_k == 1 and found > 1
        candidate = work.candidate[k]
        if (
            candidate != FREE
            and state.mode[i] == ContactMode.SLIDE
            and not is_surely_unique(scratch.spatial.G, k, scratch.spatial.mu[k])
            and has_lost_slide(sys, t, dt, n_k, k, state, scratch)
        ):
            describe_closed(sys, k, 0, state, work)
            append_event(t, INCONSISTENT, i, state.mode[i], 0, mode_of(work.candidate[k], 2), 0, state)
        if is_indeterminate and state.several[i] == 0:
            describe_closed(sys, k, found, state, work)
            append_event(t, INDETERMINATE, i, state.mode[i], 0, mode_of(candidate, 2), 0, state)
        state.several[i] = 1 if is_indeterminate else 0
        state.counters.several += state.several[i]


@rare_kernel
def has_lost_slide(sys, t, dt, n_k, k, state, scratch):
    """Closed contact k slid and is not to part: has its slide run out of forces? Then the only contact of the step
    gets the impulses of its law, of Newton's too, since a slide turns past rest."""
    is_alone = n_k == 1 and scratch.options.stiffness == 0.0
    if is_alone:
        set_up_impact(sys, scratch)
        if turned_without_force(scratch):
            strike_lost_slide(sys, n_k, scratch)
            return True
    return scratch.work.candidate[k] == STICK and slid_without_force(sys, t, dt, n_k, k, state, scratch)


@rare_kernel(
    "boolean(int64, float64, float64, float64, int64, int64, int64, int64)",
    short_loops=True,
)
def end_slide(sys_at, mu, t, dt, n_k, k, state_at, scratch_at):
    """Closed contact k slid and is to stick: is it for want of a force? Then take the impact, or book it as the
    step's. Returns whether the velocity has jumped."""
    sys = view(sys_at, Sys)
    state, scratch = view(state_at, State), view(scratch_at, Scratch)
    work, there = scratch.work, scratch.there
    i = work.closed[k]
    if not had_no_force(sys, mu, t, dt, n_k, k, state, scratch):
        return False
    if follows_own_law(i, sys.kinds, sys.laws):
        impulses_by_law(sys.laws, i, work.gamma_0, work.G, work.P)
    describe_closed(sys, k, 0, state, work)
    append_event(t, INCONSISTENT, i, state.mode[i], state.slip[i], ContactMode.STICK.value, 0, state)
    if scratch.options.stiffness == 0.0 and is_first_alone(n_k, there) and has_impact(sys, i, state, there):
        jump(sys, t, i, state, there)
        return True
    return False


@kernel
def is_first_alone(n_k, there):
    """Whether no other closed contact is coupled to the first of ``there``, so that its impact strikes none."""
    return not is_block(there.start[0], there.start[1], there.start[1], there.start[n_k], there.G)


@kernel
def has_impact(sys, i, state, there):
    """Whether impulses end the slide of the first contact, by its own law or to rest; they are in there.P.

    ``there`` holds the acceleration-level problem of the state, so its rows and G.
    """
    row_velocities(sys, 1, state.u, there)
    G, P, gamma_0 = there.G, there.P, there.gamma_0
    if follows_own_law(i, sys.kinds, sys.laws) and impulses_by_law(sys.laws, i, gamma_0, G, P):
        return True
    P[0], P[1], exists = stick(G[0, 0], G[0, 1], G[1, 0], G[1, 1], gamma_0[0], gamma_0[1])
    return exists and (sys.kinds[i, 0] == BILATERAL or P[0] > 0.0)


@kernel
def jump(sys, t, i, state, there):
    """The impact of there.P at the state before the step: velocity, mode, energy, impulses."""
    n = sys.n
    u, u_1, X, P = state.u, there.u_1, there.X, there.P
    for j in range(n):
        u_1[j] = u[j] + X[0, j] * P[0] + X[1, j] * P[1]
    if state.skips.ledger == 0:
        book_energy(sys, 0.0, 0.5, False, 1, state, there)
    set_mode(sys, t, i, ContactMode.STICK.value, 0, 0, state, there)
    if state.skips.impulses == 0:
        for m in range(2):
            state.P_sum[i, m] += P[m]
    for j in range(n):
        u[j] = u_1[j]
