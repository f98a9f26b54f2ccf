"""Impacts of several coupled contacts at once under Newton's law: one answer of many, which the run tells of.

    gamma_N+ >= -e gamma_N-    for all closed contacts of an impact at once

With one contact, or contacts that the Delassus matrix G does not couple, that is each one's own law; e = 0 asks for
nothing that a rigid body could not do. Where an approach with e > 0 is answered through a contact that presses too, the
outcome depends on the order in which the blows follow one another, which rigid mechanics does not know: five touching
beads of e = 1 leave with (-.6, .4, .4, .4, .4) under this law, with (0, 0, 0, 0, 1) one blow after the other.

A contact strikes when it approaches faster than the forces of the step change its velocity, so what rests does not, and
faster than the rounding of what the velocity is made of. Source: Ivanov, *J. Appl. Math. Mech.* 59 (1995) 887.
"""

from __future__ import annotations

from nonsmooth.contact.islands import is_block
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.mechanics.laws import LAW_E_N, LAW_IMPACT
from nonsmooth.mechanics.system import GIVEN_FORCE, UNILATERAL
from nonsmooth.numerics.rounding import rounded_sum

BY_FORCES = -1.0  # code: no approach is what the forces of a step change
APPROACH_ROUNDINGS = 18  # chosen: of a velocity, made from a few terms: a slower approach is none


@rare_kernel
def note_together(sys, t, slow, n_k, state, work):
    """Count an impact, or a step with one, in which Newton's law rebounds coupled contacts together; keep which they
    were at the first one. An approach of ``slow`` [m/s] is none."""
    together = state.together
    if sys.laws[work.closed[0], LAW_IMPACT] != 0.0:
        return
    for k in range(n_k):
        if strikes(sys, k, slow, state, work) and spread(sys, k, n_k, together.reached, work) > 1:
            if together.count == 0:
                together.t = t
                for m in range(n_k):
                    is_unilateral = sys.kinds[work.closed[m], 0] == UNILATERAL
                    together.struck[work.closed[m]] = together.reached[m] if is_unilateral else 0
            together.count += 1
            return


@kernel
def strikes(sys, k, slow, state, work):
    """Whether closed contact k comes back from an approach by its restitution."""
    a, i = work.start[k], work.closed[k]
    if sys.kinds[i, 0] != UNILATERAL or work.gamma_0[a] >= 0.0 or work.P[a] <= 0.0:
        return False
    e, approach = sys.laws[i, LAW_E_N], -work.gamma_0[a]
    if e == 0.0 or approach <= (slow if slow != BY_FORCES else abs(work.c[a] + (1.0 + e) * approach)):
        return False
    size = abs(work.w[a])
    for j in range(sys.n):
        size += abs(work.W[a, j] * state.u[j])
    return approach > rounded_sum(APPROACH_ROUNDINGS, size)


@kernel
def spread(sys, k, n_k, reached, work):
    """Mark the closed contacts that answer the blow at contact k, itself among them: those with impulses whose normal
    velocity the impulses of the others change. Returns how many of them are unilateral."""
    for m in range(n_k):
        reached[m] = 1 if m == k else 0
    count, grows = 1, True
    while grows:
        grows = False
        for m in range(n_k):
            if reached[m] == 0 and work.P[work.start[m]] != 0.0 and is_reached(sys, m, n_k, reached, work):
                reached[m] = 1
                grows = True
                count += 1 if sys.kinds[work.closed[m], 0] == UNILATERAL else 0
    return count


@kernel
def is_reached(sys, m, n_k, reached, work):
    """Whether the impulses of a contact that is reached change the normal velocity of contact m."""
    if sys.kinds[work.closed[m], 0] == GIVEN_FORCE:
        return False
    a, start = work.start[m], work.start
    for k in range(n_k):
        if reached[k] == 1 and is_block(a, a + 1, start[k], start[k + 1], work.G):
            return True
    return False
