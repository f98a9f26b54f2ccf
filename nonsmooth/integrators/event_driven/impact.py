"""Impacts of the contacts that strike, and of those that they strike: the contact problem at velocity level, at one
instant.

    M (u_+ - u_-) = W^T P,    (gamma_+ + e gamma_-, P) in the laws of contact and friction (Newton)

It is the problem of a Moreau–Jean step without duration, so that both integrators mean the same impact. A contact that
touches takes no part where the impulses of the others do not change its normal velocity: P = 0 solves its problem.

An *impact without collision* has gamma_N = 0 before: P = 0 solves it too, and the solution that sticks is asked for.
For one contact that is where the impulse map of mechanics/impact.py ends, with P_F/P_N = -G_NN/G_NF, which is inside
the cone where p < 0 and on it where p = 0, at a Génot–Brogliato point. Source: Moreau (1988); Génot, Brogliato, *Eur.
J. Mech. A/Solids* 18 (1999) 653.
"""

from __future__ import annotations

import math

from nonsmooth.contact.islands import find_islands, spread_strike
from nonsmooth.contact.planar.impacts import add_shock, has_shock, strike
from nonsmooth.contact.planar.ladder import Route, solve_planar, solve_uncoupled
from nonsmooth.contact.planar.single import Selection, count, stick
from nonsmooth.errors import Status
from nonsmooth.integrators.event_driven.touch import END_OF_SERIES, WITHOUT_COLLISION, Touch
from nonsmooth.integrators.moreau_jean.energy_gain import note_gains
from nonsmooth.integrators.moreau_jean.step import VELOCITY_ROUNDINGS
from nonsmooth.integrators.moreau_jean.struck_together import note_together
from nonsmooth.integrators.records import State, book_contact_energy
from nonsmooth.integrators.rigid.modes import NEARLY_SINGULAR, RigidContacts
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.jit.blocks import address, view
from nonsmooth.mechanics.acceleration_problem import acceleration_problem_apart
from nonsmooth.mechanics.contact_problem import add_restitution, fill_problem, recall_impulses, row_velocities
from nonsmooth.mechanics.impact import follows_own_law, impulses_by_law
from nonsmooth.mechanics.laws import LAW_E_F, friction_coefficient, static_coefficient
from nonsmooth.mechanics.sys import Sys
from nonsmooth.mechanics.system import GIVEN_FORCE, UNILATERAL
from nonsmooth.numerics.dense import SINGULAR
from nonsmooth.numerics.rounding import rounded_sum

# derived: P_F/P_N exceeds mu by the part p/(G_NN - p), where a slide ends before p is exactly 0
CONE = 2.0 * NEARLY_SINGULAR


@rare_kernel("int64(int64, float64, float64[::1], int64, int64, int64)", short_loops=True)
def solve_impact(sys_at, t, x, state_at, contacts_at, touch_at):
    """Change u by the impulses of the contacts marked in touch.strikes, and of those that touch and whose normal
    velocity these change; mark these too, book the impulses in x and in touch.P. Returns a Status."""
    sys = view(sys_at, Sys)
    state, contacts, touch = view(state_at, State), view(contacts_at, RigidContacts), view(touch_at, Touch)
    work, kinds = contacts.work, sys.kinds
    n, n_c = sys.n, sys.n_c
    for j in range(n):
        contacts.q[j], contacts.u[j] = x[j], x[n + j]
    n_k = 0
    for i in range(n_c):
        if touch.is_touching[i] == 1 and kinds[i, 0] != GIVEN_FORCE:
            work.closed[n_k], touch.spread[n_k] = i, touch.strikes[i]
            n_k += 1
    status, _ = acceleration_problem_apart(address(sys), t, contacts.q, contacts.u, n_k, contacts.rates, address(work))
    if status != Status.RUNNING:
        return status
    spread_strike(n_k, work.start, work.G, touch.spread)
    for k in range(n_k):
        touch.strikes[work.closed[k]] = touch.spread[k]
        touch.number[work.closed[k]] = -1
    count = find_islands(n_k, work.start, work.G, contacts.island)
    for k in range(n_k):
        if touch.spread[k] == 1:
            touch.number[work.closed[k]] = contacts.island[k]
    for island in range(count):
        status = solve_impact_of(sys, island, t, x, n_k, state, contacts, touch)
        if status != Status.RUNNING:
            return status
    return Status.RUNNING.value


@kernel
def solve_impact_of(sys, island, t, x, n_touching, state, contacts, touch):
    """The impact of the contacts of one island: another one does not change their velocities. Returns a Status."""
    work, kinds = contacts.work, sys.kinds
    n_k = 0
    for i in range(sys.n_c):
        if touch.is_touching[i] == 1 and kinds[i, 0] != GIVEN_FORCE and touch.number[i] == island:
            work.closed[n_k] = i
            n_k += 1
    if n_k == 0:
        return Status.RUNNING.value
    if n_k < n_touching:
        status, _ = acceleration_problem_apart(
            address(sys), t, contacts.q, contacts.u, n_k, contacts.rates, address(work)
        )
        if status != Status.RUNNING:
            return status
    r = row_velocities(sys, n_k, contacts.u, work)
    for a in range(r):
        work.c[a] = work.gamma_0[a]
    add_restitution(sys, n_k, 0.0, work)
    for k in range(n_k):
        a = work.start[k]
        if touch.impact == WITHOUT_COLLISION:
            work.c[a] = 0.0  # what is left of gamma_N is rounding
        elif touch.impact == END_OF_SERIES or abs(work.gamma_0[a]) <= contacts.numbers.atol:
            work.c[a] = work.gamma_0[a]
    if not find_impulses(sys, n_k, contacts, touch):
        return Status.NO_SOLUTION.value
    if touch.impact != WITHOUT_COLLISION:
        note_solutions(n_k, contacts, touch)
    gain, size, push = apply_impulses(sys, n_k, r, x, contacts, touch)
    note_gains(sys, gain, push, rounded_sum(VELOCITY_ROUNDINGS, size), True, n_k, state, work)
    if n_k > 1 and touch.impact != WITHOUT_COLLISION and touch.impact != END_OF_SERIES:
        note_together(sys, t, contacts.numbers.atol, n_k, state, work)
    return Status.RUNNING.value


@kernel
def find_impulses(sys, n_k, contacts, touch):
    """Solve for work.P; False where there is no solution. Their number is left in touch.planar.found, and the modes of
    a single contact in touch.planar.bits."""
    work, kinds, laws, planar = contacts.work, sys.kinds, sys.laws, touch.planar
    G, c, P = work.G, work.c, work.P
    must_stick = touch.impact == WITHOUT_COLLISION
    selection = Selection.IMPACT.value if must_stick else contacts.facts.selection
    fill_problem(sys, n_k, selection, contacts.mode, contacts.slip, work)
    for k in range(n_k):
        b = work.start[k + 1] - 1
        work.offset[b] = (1.0 - laws[work.closed[k], LAW_E_F]) * work.gamma_0[b]
        work.normal_impulse[k], planar.found[k], planar.bits[k] = 0.0, 1, 0
    if n_k > 1:
        recall_impulses(touch.none, work)
        is_struck = touch.impact != WITHOUT_COLLISION and touch.impact != END_OF_SERIES and has_shock(n_k, sys, work)
        if is_struck and not strike(address(sys), n_k, contacts.numbers.atol, address(work), address(planar)):
            return False
        route, _, _, _ = solve_planar(address(work), address(planar))
        if is_struck:
            add_shock(n_k, work)
        return route > Route.NO_SOLUTION
    i = work.closed[0]
    follows_law = follows_own_law(i, kinds, laws)
    if must_stick and kinds[i, 1] > 0:
        if follows_law and impulses_of_lost_slide(sys, i, work.gamma_0, G, P):
            return True
        P[0], P[1], exists = stick(G[0, 0], G[0, 1], G[1, 0], G[1, 1], 0.0, c[1])
        reach = P[0] if kinds[i, 0] == UNILATERAL else abs(P[0])
        return exists and abs(P[1]) <= static_coefficient(laws, i) * reach * (1.0 + CONE)
    if work.gamma_0[0] < 0.0 and follows_law:
        return impulses_by_law(laws, i, work.gamma_0, G, P)
    route, planar.bits[0], _ = solve_uncoupled(0, work, planar)
    planar.found[0] = count(planar.bits[0])
    return route > Route.NO_SOLUTION


@kernel
def note_solutions(n_k, contacts, touch):
    """Note how many solutions the impact has that the selection rule took this one of."""
    for k in range(n_k):
        i = contacts.work.closed[k]
        if touch.planar.found[k] > touch.impacts[i, 0]:
            touch.impacts[i, 0], touch.impacts[i, 1] = touch.planar.found[k], touch.planar.bits[k]


@kernel
def impulses_of_lost_slide(sys, i, gamma_0, G, P):
    """``impulses_by_law`` of a slide without force: where p is not quite 0 yet, it is taken as just below."""
    G_NN = G[0, 0]
    p = G_NN - math.copysign(friction_coefficient(sys.laws, i, abs(gamma_0[1])), gamma_0[1]) * G[0, 1]
    if p >= 0.0:
        G[0, 0] -= p + SINGULAR * G_NN
    is_found = impulses_by_law(sys.laws, i, gamma_0, G, P)
    G[0, 0] = G_NN
    return is_found


@kernel
def apply_impulses(sys, n_k, r, x, contacts, touch):
    """u += X^T P, what cancels to rounding set to 0; impulses and works are added to the quadratures of x, with the
    mean velocities of the impact.

    Returns what the contacts gained, relative to their surfaces, the sum of the sizes of its parts, and the work with
    which friction drives a slide.
    """
    n = sys.n
    work, kinds = contacts.work, sys.kinds
    n_c = sys.n_c
    for j in range(n):
        before = x[n + j]
        total, size = before, abs(before)
        for a in range(r):
            part = work.X[a, j] * work.P[a]
            total += part
            size += abs(part)
        x[n + j] = 0.0 if abs(total) <= rounded_sum(VELOCITY_ROUNDINGS, size) < math.inf else total
        work.trial[j] = 0.5 * (before + x[n + j])
    for m in range(touch.ledger.shape[0]):
        touch.ledger[m] = 0.0
    _, gain, size, push = book_contact_energy(sys, n_k, work.trial, touch.ledger, work)
    for m in range(4):
        x[2 * n + 3 * n_c + m] += touch.ledger[m]
    for k in range(n_k):
        i = work.closed[k]
        a, b = work.start[k], work.start[k + 1] - 1
        touch.P[i, 0] += work.P[a]
        x[2 * n + n_c + i] += work.P[a]
        if kinds[i, 1] > 0:
            touch.P[i, 1] += work.P[b]
            x[2 * n + 2 * n_c + i] += work.P[b]
    return gain, size, push
