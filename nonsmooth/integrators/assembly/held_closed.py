"""Contacts that stay closed over gaps which are less than their island knows of its places.

    0 < g_N <= delta,   P_N > 0 in the step before:   b_N = 0

In a heap that is pressed at more contacts than it needs, gaps that the position pass opened, where it took back the
penetration of a neighbour (project.py), contradict each other when they are asked to close within the step: the only
solutions are ones in which the load leaves some of these contacts, so impulses as large as weights have to move for
gaps of 1e-9 m, anew in every step. Measured, 400 boxes at rest: neither 2000 sweeps nor 60 factors come below 1e-8;
with these gaps held, 2000 sweeps or 6 to 15 factors come to 2e-16.

delta is a part of g dt^2 where an island has penetrations, and else that below which a penetration is a rounding. Where
that ends in gaps that cannot close all at once, an island at rest that is not solved, it stays the part of g dt^2 until
no held gap is wider than roundings: with velocities of 2e-8 m/s, then penetrations of 1e-11 m, in turns, one of 38
heaps of 400 boxes found no end of it in 12 s. Held gaps are drawn together by the position pass, so that none is left
of them at rest; what is left after DRAWN_TOGETHER steps is contradicted by the places: the widest are let go for a
step, and the load leaves their contacts. Only islands that are too large to be solved to rounding anyway have gaps
held, and none where the tolerance is one for speed.
"""

from __future__ import annotations

from nonsmooth.contact.network.joint import is_contact
from nonsmooth.contact.network.problem import Network
from nonsmooth.contact.network.solve import EXACT_BODIES, FINE, Solver, bodies_of
from nonsmooth.integrators.assembly.bodies import Bodies, fall_of
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import view
from nonsmooth.scenes.detection import Found

HELD_SHARE = 1e-3  # chosen: of g dt^2, up to which a gap may be held: 4e-8 m at 2 ms
# chosen: steps in which held gaps are drawn together before the widest are let go: a hundredth a step leaves 0.13 of
# them; which are let go, of the widest. Measured: without it 4 of 25 heaps hold such gaps for ever, with it none
DRAWN_TOGETHER, LET_GO = 200, 0.5


@kernel("void(int64, int64, int64, int64, float64, float64)")
def hold_closed(bodies_at, found_at, network_at, solver_at, dt, tight):
    """Let b_N be 0 where a gap is held; the islands are known. ``tight`` [m]: the penetration that is a rounding."""
    bodies, found = view(bodies_at, Bodies), view(found_at, Found)
    network, solver = view(network_at, Network), view(solver_at, Solver)
    if solver.tol > FINE:
        return
    widest = max(tight, HELD_SHARE * dt * fall_of(bodies, dt))
    is_wide = False
    for k in range(network.islands.count):
        if bodies_of(network, k) > EXACT_BODIES:
            is_loose = solver.contradicted > 0 or deepest_of(found, network, k) > tight
            most = widest if is_loose else tight
            largest = largest_gap(found, network, k, most)
            is_wide = is_wide or largest > tight
            is_stuck = largest > tight and solver.contradicted > DRAWN_TOGETHER
            hold_island(found, network, k, LET_GO * largest if is_stuck else most)
    if solver.contradicted > 0:
        solver.contradicted = solver.contradicted % (DRAWN_TOGETHER + 1) + 1 if is_wide else 0


@kernel
def deepest_of(found, network, k):
    """The deepest penetration of island k [m]."""
    islands, deepest = network.islands, 0.0
    for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
        deepest = max(deepest, -found.gap[islands.contacts[at]])
    return deepest


@kernel
def hold_island(found, network, k, widest):
    """Hold the gaps of island k up to the widest [m]."""
    islands = network.islands
    for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
        c = islands.contacts[at]
        if may_be_held(found, network, c, widest):
            network.b[c, 0] = network.turn[c, 0]


@kernel
def largest_gap(found, network, k, widest):
    """The largest gap of island k that may be held [m]."""
    islands, largest = network.islands, 0.0
    for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
        c = islands.contacts[at]
        if may_be_held(found, network, c, widest):
            largest = max(largest, found.gap[c])
    return largest


@kernel
def may_be_held(found, network, c, widest):
    """Whether contact c is pressed over a gap no wider than this."""
    is_rigid = network.soft[c] == 0.0 and is_contact(network, c)
    return is_rigid and network.P[c, 0] > 0.0 and 0.0 < found.gap[c] <= widest


@kernel
def is_held(found, network, c):
    """Whether the gap of contact c is held: open, and not asked to close."""
    return found.gap[c] > 0.0 and network.b[c, 0] == network.turn[c, 0] and is_contact(network, c)
