"""Impacts of several unilateral contacts at one instant, by another law than Newton's.

    gamma_+ = gamma_- + G P,    P = P_shock + P_rest

SEQUENTIAL: one after the other. While a contact approaches, the one that approaches fastest is struck alone, of equal
ones that with the lowest number, by the energetic law of a single contact (mechanics/impact.py); without friction

    P_i += -(1 + e_i) gamma_i/G_ii,    gamma += G_(. i) P_i

which is Newton's and Poisson's law too, and changes the kinetic energy by -(1 - e_i^2) gamma_i^2/(2 G_ii). Blows that
have become slower than SLOWEST_BLOW of the fastest one, or the BLOWS-th for each contact, leave the rest to an impact
without rebound: equal beads with e = 1 need one blow for each pair that passes, those with e < 1 may strike for ever.

POISSON: compression, then expansion, with one e,

    gamma_C = gamma_- + G P_C,    0 <= gamma_CN _|_ P_CN >= 0,    |P_CF| <= mu P_CN, opposed to gamma_CF
    gamma_E = gamma_C + G P_E,    P_EN = e P_CN,                  |P_EF| <= mu P_EN, opposed to gamma_EF

so that P_shock = P_C + P_E. Without friction, x = P_rest, the energies are T_+ - T_C = (e^2 P_C.G P_C - x.G x)/2 and
T_- - T_C = P_C.G P_C/2: nothing is gained. With several e it could be, and with friction, which compression may
have spent on what expansion gives back: there e is lowered, for all contacts alike, to the largest with T_E <= T_-.
A contact that no other is coupled to has Poisson's law of a single contact.

ENERGETIC: all at once, each compressed and given back in its own time (energetic.py). With e = 0 at all there is no
shock.

In all of them P_rest is the solution of the problem of a step from there without restitution, 0 <= gamma_+ _|_ P_rest
>= 0 with friction within mu P_rest. No part of it gains energy.
Source: Ivanov, *J. Appl. Math. Mech.* 59 (1995) 887; Han, Gilmore, *J. Mech. Design* 115 (1993) 412; Glocker, Pfeiffer,
*Nonlinear Dynamics* 7 (1995) 471.
"""

from __future__ import annotations

import math

from nonsmooth.contact.planar.energetic import spring_back
from nonsmooth.contact.planar.ladder import Route, solve_planar
from nonsmooth.contact.planar.problem import Planar
from nonsmooth.contact.planar.single import BORDER_WIDTH, FREE, SLIDE_MINUS, SLIDE_PLUS, STICK
from nonsmooth.jit import Kernel, kernel, rare_kernel
from nonsmooth.jit.blocks import address, view
from nonsmooth.mechanics.contact_problem import Work
from nonsmooth.mechanics.impact import impulse_map
from nonsmooth.mechanics.laws import LAW_E_F, LAW_E_N, LAW_IMPACT, ImpactLaw, friction_coefficient
from nonsmooth.mechanics.sys import Sys
from nonsmooth.mechanics.system import System

SLOWEST_BLOW = 1e-10  # chosen: of the fastest approach: what strikes slower is rounding of what struck before
BLOWS = 1000  # chosen: for each contact; a series of them converges like a geometric one
EXPANSION_SWEEPS = 10_000  # chosen: of Gauss-Seidel on the friction of an expansion
SETTLED_FRICTION = 1e-15  # chosen: of the largest limit: what a last sweep may change
HALVINGS = 50  # derived: of the restitution, to the last place but three


def kernels_of_shock(system: System) -> list[Kernel]:
    """Entry points that an impact of several contacts of the system needs."""
    law = system.law_numbers[:, LAW_IMPACT]
    if system.n_c < 2 or not law.any():
        return []
    return [strike, spring_back] if (law == ImpactLaw.ENERGETIC).any() else [strike]


@kernel
def has_shock(n_k, sys, work):
    """Whether several closed contacts follow another law of impact than Newton's: all of a system have the same."""
    return n_k > 1 and sys.laws[work.closed[0], LAW_IMPACT] != 0.0


@rare_kernel("boolean(int64, int64, float64, int64, int64)", short_loops=True)
def strike(sys_at, n_k, slow, work_at, planar_at):
    """Find the impulses of a shock from work.gamma_0, to work.shock, and take it into work.c, which is kept in
    work.c_kept; velocities within ``slow`` are none. False where the compression has no solution."""
    sys, work, planar = view(sys_at, Sys), view(work_at, Work), view(planar_at, Planar)
    c, gamma_0, shock, start = work.c, work.gamma_0, work.shock, work.start
    fastest = 0.0
    for a in range(start[n_k]):
        shock[a], work.c_kept[a] = 0.0, c[a]
    for k in range(n_k):
        fastest = max(fastest, -gamma_0[start[k]])
    if fastest <= slow:
        return True
    law = int(sys.laws[work.closed[0], LAW_IMPACT])
    if law == ImpactLaw.SEQUENTIAL:
        if not strike_in_turn(sys, n_k, max(slow, SLOWEST_BLOW * fastest), work):
            return False
    elif law == ImpactLaw.ENERGETIC:
        if not give_back_energy(sys, n_k, slow, work, planar):
            return False
    elif not compress_and_expand(sys, n_k, slow, work, planar):
        return False
    go_on_from_shock(sys, n_k, work)
    return True


@kernel
def give_back_energy(sys, n_k, slow, work, planar):
    """The impulses of the energetic law; none where nothing is given back. False where they have no end."""
    if sys.laws[work.closed[0], LAW_E_N] == 0.0:
        return True
    return spring_back(address(sys), n_k, slow, address(work), address(planar.springs)) == 1


@kernel
def go_on_from_shock(sys, n_k, work):
    """work.c of a step without restitution from the velocities after the shock."""
    c, gamma_0, start = work.c, work.gamma_0, work.start
    for k in range(n_k):
        for a in range(start[k], start[k + 1]):
            e = sys.laws[work.closed[k], LAW_E_N if a == start[k] else LAW_E_F]
            change = row_of_shock(a, start[n_k], work)
            c[a] = work.c_kept[a] - e * gamma_0[a] + change
            if a > start[k]:
                work.offset[a] = gamma_0[a] + change


@kernel
def row_of_shock(a, r, work):
    """What the shock changes of the velocity of row a."""
    total = 0.0
    for b in range(r):
        total += work.G[a, b] * work.shock[b]
    return total


@kernel
def strike_in_turn(sys, n_k, slow, work):
    """One contact after the other, while one approaches; c holds the velocities on the way. False where a blow has no
    end."""
    gamma, start = work.c, work.start
    for a in range(start[n_k]):
        gamma[a] = work.gamma_0[a]
    for _ in range(BLOWS * n_k):
        i = 0
        for k in range(n_k):
            if gamma[start[k]] < gamma[start[i]]:
                i = k
        if gamma[start[i]] >= -slow:
            return True
        if not blow(i, sys.laws[work.closed[i], LAW_E_N], start[n_k], work):
            return False
    return True


@kernel
def blow(i, e, r, work):
    """Strike contact i alone; False where its compression has no end."""
    G, gamma, a = work.G, work.c, work.start[i]
    if work.start[i + 1] == a + 1:
        P_N, P_F, after = -(1.0 + e) * gamma[a] / G[a, a], 0.0, -e * gamma[a]
    else:
        P_N, P_F = impulses_alone(ImpactLaw.ENERGETIC, i, e, gamma, work)
        after = gamma[a] + G[a, a] * P_N + G[a, a + 1] * P_F
        work.shock[a + 1] += P_F
    if P_N == math.inf:
        return False
    work.shock[a] += P_N
    for b in range(r):
        gamma[b] += G[b, a] * P_N
        if P_F != 0.0:
            gamma[b] += G[b, a + 1] * P_F
    gamma[a] = after
    return True


@kernel
def impulses_alone(law, i, e, gamma, work):
    """(P_N, P_F) of contact i with friction, struck alone; inf where its compression has no end."""
    G, a = work.G, work.start[i]
    mu = friction_coefficient(work.laws, i, abs(gamma[a + 1]))
    P_N, P_F, _, P_c = impulse_map(law, e, mu, G[a, a], G[a, a + 1], G[a + 1, a + 1], min(0.0, gamma[a]), gamma[a + 1])
    return (math.inf if P_c == math.inf else P_N), P_F


@kernel
def compress_and_expand(sys, n_k, slow, work, planar):
    """The impulses of compression and expansion; False where there is no solution."""
    start, shock, r = work.start, work.shock, work.start[n_k]
    for a in range(r):
        work.c[a] = work.gamma_0[a]
    for k in range(n_k):
        if abs(work.c[start[k]]) <= slow:
            work.c[start[k]] = 0.0
    route, _, _, _ = solve_planar(address(work), address(planar))
    if route <= Route.NO_SOLUTION:
        return False
    e, has_friction = sys.laws[work.closed[0], LAW_E_N], False
    for a in range(r):
        shock[a] = work.P[a]
    for k in range(n_k):
        e = max(e, sys.laws[work.closed[k], LAW_E_N])  # an integrator may have hidden the bounces of some
        has_friction = has_friction or start[k + 1] > start[k] + 1
        if planar.members[k] == 1 and start[k + 1] > start[k] + 1 and shock[start[k]] > 0.0:
            shock[start[k]], shock[start[k] + 1] = impulses_alone(ImpactLaw.POISSON, k, e, work.gamma_0, work)
            if shock[start[k]] == math.inf:
                return False
    expand(e, n_k, work, planar)
    if has_friction and energy_of_shock(r, work) > 0.0:
        low, high = 0.0, e
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            expand(middle, n_k, work, planar)
            if energy_of_shock(r, work) > 0.0:
                high = middle
            else:
                low = middle
        expand(low, n_k, work, planar)
    for a in range(r):
        shock[a] += work.P[a]
    return True


@kernel
def expand(e, n_k, work, planar):
    """Impulses of expansion, to work.P: those of the normals are given, and friction is within them. The contacts that
    are alone have theirs already."""
    start, P = work.start, work.P
    most = 0.0
    for k in range(n_k):
        a = start[k]
        for b in range(a, start[k + 1]):
            P[b] = 0.0
        if planar.members[k] > 1 or start[k + 1] == a + 1:
            P[a] = e * work.shock[a]
        if start[k + 1] > a + 1:
            work.mu[k] = friction_coefficient(work.laws, k, abs(work.gamma_0[a + 1]))
            most = max(most, work.mu[k] * P[a])
    for _ in range(EXPANSION_SWEEPS):
        change = 0.0
        for k in range(n_k):
            if start[k + 1] > start[k] + 1 and P[start[k]] > 0.0:
                change = max(change, abs(rub(k, start[n_k], work)))
        if change <= SETTLED_FRICTION * most:
            return


@kernel
def rub(k, r, work):
    """The friction of contact k in expansion with that of the others held; returns its change."""
    a, P, G = work.start[k], work.P, work.G
    t = a + 1
    gamma = work.gamma_0[t]
    for b in range(r):
        gamma += G[t, b] * (work.shock[b] + P[b])
    limit, before = work.mu[k] * P[a], P[t]
    if G[t, t] > 0.0:
        P[t] = min(limit, max(-limit, before - gamma / G[t, t]))
    return P[t] - before


@kernel
def energy_of_shock(r, work):
    """What compression and expansion add to the kinetic energy."""
    total = 0.0
    for a in range(r):
        mean = work.gamma_0[a]
        for b in range(r):
            mean += 0.5 * work.G[a, b] * (work.shock[b] + work.P[b])
        total += (work.shock[a] + work.P[a]) * mean
    return total


@rare_kernel
def add_shock(n_k, work):
    """The impulses of the shock beside those of the rest; a contact that was struck was closed."""
    start, r = work.start, work.start[n_k]
    for k in range(n_k):
        a = start[k]
        if work.shock[a] > 0.0 and work.candidate[k] == FREE:
            work.candidate[k] = STICK if start[k + 1] == a + 1 else struck_mode(a + 1, r, work)
    for a in range(r):
        work.P[a] += work.shock[a]
        work.c[a] = work.c_kept[a]


@kernel
def struck_mode(t, r, work):
    """The mode in which a blow ends, by the sliding velocity of row t after it."""
    gamma = work.c[t]
    for b in range(r):
        gamma += work.G[t, b] * work.P[b]
    if abs(gamma) <= BORDER_WIDTH * abs(work.gamma_0[t]):
        return STICK
    return SLIDE_PLUS if gamma > 0.0 else SLIDE_MINUS
