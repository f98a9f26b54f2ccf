"""Impacts of several frictionless contacts at one instant, by another law than Newton's.

    gamma_+ = gamma_- + G P,    P = P_shock + P_rest

SEQUENTIAL: one after the other. While a contact approaches, the one that approaches fastest is struck alone, of equal
ones that with the lowest number,

    P_i += -(1 + e_i) gamma_i/G_ii,    gamma += G_(. i) P_i

which is Newton's, Poisson's and the energetic law of a single contact without friction. A blow changes the kinetic
energy by -(1 - e_i^2) gamma_i^2/(2 G_ii). Blows that have become slower than SLOWEST_BLOW of the fastest one, or the
BLOWS-th for each contact, leave the rest to an impact without rebound: equal beads with e = 1 need one blow for each
pair that passes, those with e < 1 may strike without end.

POISSON: compression, then expansion, with one e,

    gamma_C = gamma_- + G P_C,    0 <= gamma_C _|_ P_C >= 0
    gamma_+ = gamma_C + G P_E,    0 <= gamma_+ _|_ P_E - e P_C >= 0

so that P_shock = (1 + e) P_C. With x = P_E - e P_C the energies are T_+ - T_C = (e^2 P_C.G P_C - x.G x)/2 and
T_- - T_C = P_C.G P_C/2: nothing is gained. With several e it could be.

In both P_rest is the solution of the problem of a step from there without restitution, 0 <= gamma_+ _|_ P_rest >= 0.
Source: Ivanov, *J. Appl. Math. Mech.* 59 (1995) 887; Han, Gilmore, *J. Mech. Design* 115 (1993) 412; Glocker, Pfeiffer,
*Nonlinear Dynamics* 7 (1995) 471.
"""

from __future__ import annotations

from nonsmooth.contact.planar.ladder import Route, solve_planar
from nonsmooth.contact.planar.single import FREE, STICK
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.jit.blocks import address
from nonsmooth.mechanics.laws import LAW_E_N, LAW_IMPACT, ImpactLaw

SLOWEST_BLOW = 1e-10  # chosen: of the fastest approach: what strikes slower is rounding of what struck before
BLOWS = 1000  # chosen: for each contact; a series of them converges like a geometric one


@kernel
def has_shock(n_k, sys, work):
    """Whether several closed contacts follow another law of impact than Newton's: all of a system have the same."""
    return n_k > 1 and sys.laws[work.closed[0], LAW_IMPACT] != 0.0


@rare_kernel
def strike(sys, n_k, slow, work, planar):
    """Find the impulses of a shock from work.gamma_0, to work.shock, and take it into work.c, which is kept in
    work.c_kept; velocities within ``slow`` are none. False where the compression has no solution."""
    c, gamma_0, shock = work.c, work.gamma_0, work.shock
    fastest = 0.0
    for k in range(n_k):
        shock[k], work.c_kept[k] = 0.0, c[k]
        fastest = max(fastest, -gamma_0[k])
    if fastest > slow:
        if int(sys.laws[work.closed[0], LAW_IMPACT]) == ImpactLaw.SEQUENTIAL:
            strike_in_turn(sys, n_k, max(slow, SLOWEST_BLOW * fastest), work)
        elif not compress_and_expand(sys, n_k, slow, work, planar):
            return False
    for k in range(n_k):
        total = work.c_kept[k] - sys.laws[work.closed[k], LAW_E_N] * gamma_0[k] if fastest > slow else c[k]
        for m in range(n_k):
            total += work.G[k, m] * shock[m]
        c[k] = total
    return True


@kernel
def strike_in_turn(sys, n_k, slow, work):
    """One contact after the other, while one approaches; c holds the velocities on the way."""
    G, gamma, shock = work.G, work.c, work.shock
    for k in range(n_k):
        gamma[k] = work.gamma_0[k]
    for _ in range(BLOWS * n_k):
        i = 0
        for k in range(n_k):
            if gamma[k] < gamma[i]:
                i = k
        if gamma[i] >= -slow:
            return
        e = sys.laws[work.closed[i], LAW_E_N]
        P = -(1.0 + e) * gamma[i] / G[i, i]
        shock[i] += P
        after = -e * gamma[i]
        for k in range(n_k):
            gamma[k] += G[k, i] * P
        gamma[i] = after


@kernel
def compress_and_expand(sys, n_k, slow, work, planar):
    """(1 + e) times the impulses of compression; False where there is no solution."""
    for k in range(n_k):
        gamma = work.gamma_0[k]
        work.c[k] = 0.0 if abs(gamma) <= slow else gamma
    route, _, _, _ = solve_planar(address(work), address(planar))
    for k in range(n_k):
        work.shock[k] = (1.0 + sys.laws[work.closed[k], LAW_E_N]) * work.P[k]
    return route > Route.NO_SOLUTION


@rare_kernel
def add_shock(n_k, work):
    """The impulses of the shock beside those of the rest; a contact that was struck was closed."""
    for k in range(n_k):
        work.P[k] += work.shock[k]
        work.c[k] = work.c_kept[k]
        if work.shock[k] > 0.0 and work.candidate[k] == FREE:
            work.candidate[k] = STICK
