"""Impacts of contacts with friction in two directions: with and, of a slide that has no force, without collision.

A contact that G couples to no other is struck by Newton's law with the exact cone, or by its own along the hodograph
(mechanics/impact_in_space.py); several coupled ones by Newton's law, in one problem. Source: Pfeiffer, Glocker (1996),
chapter 8; docs/theory/event_driven.md.
"""

from __future__ import annotations

from nonsmooth.contact.islands import find_islands
from nonsmooth.contact.planar.single import FREE
from nonsmooth.contact.spatial.all_solutions import list_solutions
from nonsmooth.contact.spatial.solve import solve_spatial
from nonsmooth.errors import Status
from nonsmooth.integrators.event_driven.space_hold import give
from nonsmooth.integrators.event_driven.space_motion import (
    BOUNCES,
    TO_DECIDE,
    is_alone,
    space_forces,
)
from nonsmooth.integrators.moreau_jean.energy_gain import note_gains
from nonsmooth.integrators.moreau_jean.step import VELOCITY_ROUNDINGS
from nonsmooth.integrators.moreau_jean.struck_together import note_together
from nonsmooth.integrators.penalty.rates import length_along
from nonsmooth.integrators.records import (
    IMPACT,
    INCONSISTENT,
    MODE_CHANGE,
)
from nonsmooth.integrators.rigid.modes import small_speed
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import address, view
from nonsmooth.mechanics.contact_problem import add_restitution, fill_problem, recall_impulses
from nonsmooth.mechanics.impact import follows_own_law
from nonsmooth.mechanics.impact_in_space import collide_in_space, lose
from nonsmooth.mechanics.laws import (
    LAW_E_N,
    LAW_IMPACT,
    friction_coefficient,
    static_coefficient,
)
from nonsmooth.mechanics.sys import Sys
from nonsmooth.mechanics.system import ContactMode
from nonsmooth.numerics.rounding import rounded_sum


@kernel
def strike_all(sys_at, t, x, state, c):
    """The impacts of the contacts that approach, and of those that these strike; returns a Status."""
    sys, work = view(sys_at, Sys), c.work
    n_k, speed, approaches = work.n, small_speed(sys, c), False
    for k in range(n_k):
        approaches = approaches or c.gamma[work.closed[k], 0] < -speed
    if approaches:
        find_islands(n_k, work.start, work.G, c.island)
        for a in range(work.start[n_k]):
            work.c[a] = work.gamma_0[a]
        add_restitution(sys, n_k, 0.0, work)
        status = find_impulses(sys, n_k, speed, c)
        if status != Status.RUNNING:
            return status
        gain, size, push = give(sys, True, n_k, x, c)
        note_gains(sys, gain, push, rounded_sum(VELOCITY_ROUNDINGS, size), True, n_k, state, work)
        if n_k > 1:
            note_together(sys, t, c.numbers.atol, n_k, state, work)
        status = space_forces(sys_at, t, x, address(c))
        if status != Status.RUNNING:
            return status
    for k in range(n_k):
        i = work.closed[k]
        if c.gamma[i, 0] > speed:
            c.mode[i], c.open_case[i], c.touches[i] = ContactMode.OPEN.value, BOUNCES, 1
    return Status.RUNNING.value


@kernel
def find_impulses(sys, n_k, speed, c):
    """Write the impulses of the impacts to work.P; returns a Status."""
    work, joint = c.work, False
    for a in range(work.start[n_k]):
        work.P[a] = 0.0
    for k in range(n_k):
        if not is_struck(k, n_k, speed, c):
            continue
        i = work.closed[k]
        c.open_case[i], c.kind[i] = TO_DECIDE, IMPACT if c.gamma[i, 0] < -speed else MODE_CHANGE
        if not is_alone(k, n_k, c):
            joint = True
            continue
        c.found[i] = strike(sys, k, False, c)
        if c.found[i] == 0:
            return Status.NO_SOLUTION.value
    return strike_together(sys, n_k, speed, c) if joint else Status.RUNNING.value


@kernel
def is_struck(k, n_k, speed, c):
    """Whether a contact of the island of closed contact k approaches."""
    for m in range(n_k):
        if c.island[m] == c.island[k] and c.gamma[c.work.closed[m], 0] < -speed:
            return True
    return False


@kernel
def strike(sys, k, is_lost, c):
    """Write the impulses of an impact, with or without collision, of closed contact k, which is coupled to no other, at
    the state that was evaluated last; returns the number of solutions, 0 where there is none."""
    work, h, laws, i, first = c.work, c.hodograph, sys.laws, c.work.closed[k], c.work.start[k]
    if work.start[k + 1] - first == 1:
        work.P[first] = -work.c[first] / work.G[first, first]
        return 1
    mu, law = friction_coefficient(laws, i, length_along(c.gamma, i)), int(laws[i, LAW_IMPACT])
    if is_lost or follows_own_law(i, sys.kinds, laws):
        for a in range(3):
            h.before[a] = c.gamma[i, a]
            for b in range(3):
                h.G[a, b] = work.G[first + a, first + b]
        h.mu, h.e, h.law = mu, laws[i, LAW_E_N], law
        if is_lost:
            lose(h)
        if not collide_in_space(address(h)):
            return 0
        for a in range(3):
            work.P[first + a] = h.impulse[a]
        return 1
    answers = take_block(k, c)
    found = list_solutions(answers.G, 0, answers.c, mu, max(mu, static_coefficient(laws, i)), answers)
    if found > 0:
        last = 1 if found > 1 and answers.modes[0] == FREE else 0  # sticking before slides
        for a in range(3):
            work.P[first + a] = answers.P[last, a]
    return found


@kernel
def take_block(k, c):
    """The block of closed contact k, for all its solutions."""
    answers, first = c.answers, c.work.start[k]
    for a in range(3):
        answers.c[a] = c.work.c[first + a]
        for b in range(3):
            answers.G[0, a, b] = c.work.G[first + a, first + b]
    return answers


@kernel
def strike_together(sys, n_k, speed, c):
    """The impulses of coupled contacts by Newton's law, to work.P, beside those of the others; returns a Status."""
    work = c.work
    fill_problem(sys, n_k, 0, c.mode, c.slip, work)
    recall_impulses(c.P_none, work)
    for k in range(n_k):
        work.normal_impulse[k] = 0.0
        apart = is_alone(k, n_k, c) or not is_struck(k, n_k, speed, c)
        for a in range(work.start[k], work.start[k + 1]):
            work.offset[a] = work.gamma_0[a] if a > work.start[k] else 0.0
            c.z[a] = work.P[a]
            if apart:
                work.c[a] = 1.0 if a == work.start[k] else 0.0
    status, _, _ = solve_spatial(address(work), address(c.spatial))
    for k in range(n_k):
        apart = is_alone(k, n_k, c) or not is_struck(k, n_k, speed, c)
        for a in range(work.start[k], work.start[k + 1]):
            work.P[a] = c.z[a] if apart else work.P[a]
        if not apart and work.P[work.start[k]] > 0.0:
            c.kind[work.closed[k]] = IMPACT
    return status


@kernel
def lose_slide(sys, k, n_k, x, state, c):
    """The impact without collision of closed contact k; False where there is none."""
    work, i = c.work, c.work.closed[k]
    for a in range(work.start[n_k]):
        work.P[a] = 0.0
    if strike(sys, k, True, c) == 0:
        return False
    gain, size, push = give(sys, True, n_k, x, c)
    note_gains(sys, gain, push, rounded_sum(VELOCITY_ROUNDINGS, size), True, n_k, state, work)
    c.kind[i], c.found[i], c.stuck[i] = INCONSISTENT, 0, 1
    return True
