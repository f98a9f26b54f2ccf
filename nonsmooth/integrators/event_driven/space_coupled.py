"""The modes of coupled contacts with friction in two directions: one solution of their problem in a short step.

    gamma/tau = (G + S) la + b + gamma_0/tau,    tau b the speed that counts as none

A fast slide keeps its direction, and its friction is a column of its normal force. S is a compliance of a millionth of
G, which makes the share of redundant contacts one: of equal springs, softer along the surface where a contact is near
its limit, as far as the problem is solved then. At last it is taken about the share that was found, so that the
contacts are rigid. Slides that have no force are stopped together. Source: the proximal point method, Rockafellar,
*SIAM J. Control Optim.* 14 (1976) 877; the rule of shares is ours: docs/theory/event_driven.md.
"""

from __future__ import annotations

import math

from nonsmooth.contact.planar.single import FREE, STICK
from nonsmooth.contact.spatial.solve import solve_spatial
from nonsmooth.errors import Status
from nonsmooth.integrators.event_driven.space_hold import give
from nonsmooth.integrators.event_driven.space_motion import (
    STAYS,
    TO_DECIDE,
    is_alone,
    space_forces,
    take_course,
)
from nonsmooth.integrators.moreau_jean.energy_gain import note_gains
from nonsmooth.integrators.moreau_jean.step import VELOCITY_ROUNDINGS
from nonsmooth.integrators.penalty.rates import length_along
from nonsmooth.integrators.records import (
    INCONSISTENT,
)
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.jit.blocks import address, view
from nonsmooth.mechanics.contact_problem import fill_problem, recall_impulses
from nonsmooth.mechanics.laws import (
    LAW_C,
    LAW_CODE,
    STATIC_KINETIC,
    friction_coefficient,
    static_coefficient,
)
from nonsmooth.mechanics.sys import Sys
from nonsmooth.mechanics.system import ContactMode
from nonsmooth.numerics.dense import lu, lu_solve
from nonsmooth.numerics.rounding import rounded_sum

EVENT_COMPLIANCE = 1e-6  # chosen: of the mean diagonal of G, with which coupled contacts share a load
# chosen: of the speed that counts as none: what the largest acceleration changes in the step that decides on coupled
# contacts. Those that come to rest together do so in it, though their events are apart by rounding.
PER_STEP_OF_EVENT = 10.0
# chosen: of the speed that counts as none: a slide that is faster keeps its direction in that step, and only an impact
# stops it
FAST_SLIDE = 100.0
# chosen: solutions after the first, the last of them as rigid contacts, each of which leaves a millionth of what the
# compliance moves
SHARES_TRIED, SETTLING = 14, 2
FAR_FROM_LIMIT = 0.9  # chosen: of its limit: more friction is shared with others, where they can
MOST_SOFTENING = 10.0  # chosen: of a contact in one of them
LOCKED_PART = 1e-4  # chosen: of G along a slide: what others leave of it by their compliance, and more
SOFTER, MOST_SOFTER = 100.0, 2  # chosen: compliance where the problem is not solved, and how often it is tried
LOAD_OF_LOST = 1e-6  # chosen: of the loads of contacts that slide without force, which an impact does not see


@kernel
def decide_coupled(sys_at, t, n_k, speed, x, state, c):
    """Decide the modes of the coupled contacts that are undecided, by one solution of their problem: (Status, whether a
    slide was stopped by an impact without collision, after which they are still undecided). The forces of the solution
    are the load from which redundant ones share."""
    sys, work, none = view(sys_at, Sys), c.work, max(c.numbers.v_stop, speed)
    set_up_coupled(sys, n_k, none, speed, c)
    let_slide(n_k, c)
    status = solve_shared(n_k, c)
    if status == Status.NOT_SOLVED:
        return lose_together(sys_at, t, n_k, none, x, state, c), True
    state.counters.uncounted += 1
    for k in range(n_k):
        i, first = work.closed[k], work.start[k]
        if not is_decided_now(k, n_k, c):
            continue
        has_friction, slide, is_fast = work.start[k + 1] - first > 1, slide_of(k, c), c.is_fast[k] == 1
        for a in range(2 if is_fast else 0):
            work.P[first + 1 + a] = -c.mu[i] * work.P[first] * c.course[i, a]
        for a in range(work.start[k + 1] - first):
            c.share[i, a] = work.P[first + a]
        c.open_case[i] = STAYS
        if work.candidate[k] == FREE:
            c.mode[i] = ContactMode.OPEN.value
        elif not has_friction:
            c.mode[i] = ContactMode.LOCKED.value
        elif is_fast:
            c.mode[i] = ContactMode.SLIDE.value
        elif work.candidate[k] == STICK or (another_sticks(k, n_k, c) and not is_free_to_slide(k, n_k, c)):
            c.mode[i] = ContactMode.STICK.value
        else:
            c.mode[i] = ContactMode.SLIDE.value
            size = math.hypot(work.P[first + 1], work.P[first + 2])
            if slide > none:
                take_course(i, c)
            elif size > 0.0:
                c.course[i, 0], c.course[i, 1] = -work.P[first + 1] / size, -work.P[first + 2] / size
    return Status.RUNNING.value, False


@kernel
def is_decided_now(k, n_k, c):
    """Whether closed contact k is undecided, and coupled to another one."""
    return c.open_case[c.work.closed[k]] == TO_DECIDE and not is_alone(k, n_k, c)


@kernel
def set_up_coupled(sys, n_k, none, rounded, c):
    """The problem of a step that changes speeds which count as none, divided by its length: c = b + gamma_T/tau. Laws
    are those of the speeds, a speed that is rounding is none, and what is not to be decided takes no part. Returns
    1/tau."""
    work, largest, trace, r = c.work, 0.0, 0.0, c.work.start[n_k]
    fill_problem(sys, n_k, 0, c.mode, c.slip, work)
    recall_impulses(c.P_none, work)
    for a in range(r):
        largest, trace = max(largest, abs(work.c[a])), trace + work.G[a, a]
        work.offset[a], c.centre[a] = 0.0, 0.0
    rate = largest / (PER_STEP_OF_EVENT * none)
    c.numbers.compliance = EVENT_COMPLIANCE * trace / r
    for k in range(n_k):
        c.softness[k], c.is_fast[k] = 1.0, 0
        i, first = work.closed[k], work.start[k]
        work.normal_impulse[k] = 0.0
        if not is_decided_now(k, n_k, c):
            for a in range(first, work.start[k + 1]):
                work.c[a] = max(1.0, largest) if a == first else 0.0
            continue
        for a in range(first, work.start[k + 1]):
            work.G[a, a] += c.numbers.compliance
        if work.start[k + 1] - first == 1:
            continue
        slide = slide_of(k, c)
        slides = slide > none
        c.is_fast[k] = 1 if slide > FAST_SLIDE * none else 0
        work.laws[k, LAW_CODE], work.laws[k, LAW_C] = STATIC_KINETIC, static_coefficient(sys.laws, i)
        work.laws[k, LAW_C + 1] = friction_coefficient(sys.laws, i, slide if slides else 0.0)
        if slides:
            work.laws[k, LAW_C] = work.laws[k, LAW_C + 1]
        for a in range(2):
            work.c[first + 1 + a] += rate * c.gamma[i, 1 + a] if slide > rounded else 0.0
    return rate


@kernel
def slide_of(k, c):
    """The speed with which closed contact k slides."""
    has_friction = c.work.start[k + 1] - c.work.start[k] > 1
    return length_along(c.gamma, c.work.closed[k]) if has_friction else 0.0


@kernel
def let_slide(n_k, c):
    """Give the fast slides of coupled contacts the friction of their course, as columns of their normal impulses."""
    work = c.work
    for k in range(n_k):
        if c.is_fast[k] == 1:
            i, first = work.closed[k], work.start[k]
            take_course(i, c)
            c.mu[i] = work.laws[k, LAW_C]
            for a in range(work.start[n_k]):
                along = work.G[a, first + 1] * c.course[i, 0] + work.G[a, first + 2] * c.course[i, 1]
                work.G[a, first] -= c.mu[i] * along
            work.laws[k, LAW_C], work.laws[k, LAW_C + 1] = 0.0, 0.0
            work.c[first + 1], work.c[first + 2] = 0.0, 0.0


@kernel
def solve_shared(n_k, c):
    """Solve the problem of the coupled contacts: with equal compliance, along the surface the softer the nearer a
    contact is to its limit, then as rigid ones, whose compliance is about the share found before; returns a Status."""
    work = c.work
    status, _, _ = solve_spatial(address(work), address(c.spatial))
    for _ in range(MOST_SOFTER):
        if status == Status.NOT_SOLVED:
            soften(n_k, c)
            status, _, _ = solve_spatial(address(work), address(c.spatial))
    settled = 0
    for share in range(SHARES_TRIED if status == Status.RUNNING else 0):
        for a in range(work.start[n_k]):
            c.z[a] = work.P[a]
        for k in range(n_k):
            c.held[k] = work.candidate[k]
        if share + SETTLING >= SHARES_TRIED or settled > 0 or not share_evenly(n_k, c):
            settle(n_k, c)
            settled += 1
        again, _, _ = solve_spatial(address(work), address(c.spatial))
        if again != Status.RUNNING:
            for a in range(work.start[n_k]):
                work.P[a] = c.z[a]
            for k in range(n_k):
                work.candidate[k] = c.held[k]
        if again != Status.RUNNING or settled == SETTLING:
            break
    return status


@kernel
def soften(n_k, c):
    """Make the compliance of the coupled contacts a hundred times as large."""
    work = c.work
    for k in range(n_k):
        for a in range(work.start[k], work.start[k + 1]):
            work.G[a, a] += (SOFTER - 1.0) * c.numbers.compliance if is_decided_now(k, n_k, c) else 0.0
    c.numbers.compliance *= SOFTER


@kernel
def settle(n_k, c):
    """Let the compliance of the coupled contacts be about their last impulses."""
    work = c.work
    for k in range(n_k):
        for a in range(work.start[k], work.start[k + 1]):
            if is_decided_now(k, n_k, c):
                work.c[a] -= softness_of(k, a, c) * (work.P[a] - c.centre[a])
                c.centre[a] = work.P[a]


@kernel
def softness_of(k, a, c):
    """The compliance of row a of closed contact k."""
    return c.numbers.compliance * (c.softness[k] if a > c.work.start[k] else 1.0)


@kernel
def share_evenly(n_k, c):
    """Make coupled contacts softer along the surface that bear a larger part of the friction which they can than others
    do, so that where shares are free they come to equal parts; False where none is near its limit."""
    work, total, count, largest = c.work, 0.0, 0, 0.0
    for k in range(n_k):
        part = part_of_cone(k, n_k, c)
        total, count, largest = total + part, count + (1 if part > 0.0 else 0), max(largest, part)
    if not (largest > FAR_FROM_LIMIT and count > 1):
        return False
    for k in range(n_k):
        part = part_of_cone(k, n_k, c)
        change = min(MOST_SOFTENING, max(1.0 / MOST_SOFTENING, part * count / total)) if part > 0.0 else 1.0
        for a in range(work.start[k] + 1, work.start[k + 1]):
            work.G[a, a] += c.numbers.compliance * (change - 1.0) * c.softness[k]
        c.softness[k] *= change
    return True


@kernel
def part_of_cone(k, n_k, c):
    """The part of its limit of friction that a loaded contact bears which is to be decided; 0 of others."""
    work, a = c.work, c.work.start[k]
    if not is_decided_now(k, n_k, c) or work.start[k + 1] - a == 1 or c.is_fast[k] == 1 or not work.P[a] > 0.0:
        return 0.0
    most = work.laws[k, LAW_C] * work.P[a]
    return math.hypot(work.P[a + 1], work.P[a + 2]) / most if most > 0.0 else 0.0


@kernel
def is_free_to_slide(k, n_k, c):
    """Whether closed contact k, which slides in the solution, can do so against its friction while the normals of its
    island and all rows of those that stick are held: d.(G_TT - G_TH G_HH^-1 G_HT) d is no rounding."""
    work, first, m = c.work, c.work.start[k], 0
    size = math.hypot(work.P[first + 1], work.P[first + 2])
    if size == 0.0:
        return True
    d_1, d_2 = work.P[first + 1] / size, work.P[first + 2] / size
    for other in range(n_k):
        if c.island[other] != c.island[k] or work.candidate[other] == FREE:
            continue
        rows = work.start[other + 1] if work.candidate[other] == STICK and other != k else work.start[other] + 1
        for a in range(work.start[other], rows):
            c.row[m], c.b[m], m = a, work.G[a, first + 1] * d_1 + work.G[a, first + 2] * d_2, m + 1
    for e in range(m):
        for f in range(m):
            c.factor[e, f] = work.G[c.row[e], c.row[f]]
    if not lu(m, c.factor, c.order):
        return True
    lu_solve(m, c.factor, c.order, c.b, c.left)
    G_dd = d_1 * (work.G[first + 1, first + 1] * d_1 + 2.0 * work.G[first + 1, first + 2] * d_2)
    G_dd += d_2 * work.G[first + 2, first + 2] * d_2
    free = G_dd
    for e in range(m):
        free -= c.b[e] * c.left[e]
    return free > LOCKED_PART * G_dd


@kernel
def another_sticks(k, n_k, c):
    """Whether a contact of the island of closed contact k sticks in the solution."""
    for m in range(n_k):
        if c.island[m] == c.island[k] and c.work.candidate[m] == STICK and c.is_fast[m] == 0:
            return True
    return False


@rare_kernel
def lose_together(sys_at, t, n_k, none, x, state, c):
    """The impact without collision of coupled contacts that slide without force, by Newton's law: what stops all of
    them if friction can, else a solution of a problem in which a millionth of their loads presses; returns a Status."""
    sys, work, is_lost = view(sys_at, Sys), c.work, False
    status = space_forces(sys_at, t, x, address(c))
    if status != Status.RUNNING:
        return status
    rate = set_up_coupled(sys, n_k, none, none, c)
    for k in range(n_k):
        is_lost = is_lost or c.is_fast[k] == 1
    if not is_lost:
        return Status.NOT_SOLVED.value
    for k in range(n_k):
        work.c[work.start[k]] *= LOAD_OF_LOST if is_decided_now(k, n_k, c) else 1.0
    if not hold_all(n_k, c):
        status, _, _ = solve_spatial(address(work), address(c.spatial))
        if status != Status.RUNNING:
            return status
    for k in range(n_k):
        if is_decided_now(k, n_k, c) and work.P[work.start[k]] > 0.0:
            i = work.closed[k]
            c.kind[i], c.found[i], c.stuck[i] = INCONSISTENT, 0, 1
    for a in range(work.start[n_k]):
        work.P[a] /= rate
    gain, size, push = give(sys, True, n_k, x, c)
    note_gains(sys, gain, push, rounded_sum(VELOCITY_ROUNDINGS, size), True, n_k, state, work)
    return Status.RUNNING.value


@kernel
def hold_all(n_k, c):
    """Write the impulses that stop all coupled contacts to work.P; whether their cones hold them."""
    work, m = c.work, 0
    for k in range(n_k):
        for a in range(work.start[k], work.start[k + 1]):
            work.P[a] = 0.0
            if is_decided_now(k, n_k, c):
                c.row[m], c.contact[m], c.z[m], m = a, k, 0.0, m + 1
    for e in range(m):
        for f in range(m):
            c.factor[e, f] = work.G[c.row[e], c.row[f]]
    if not lu(m, c.factor, c.order):
        return False
    for _ in range(SHARES_TRIED):
        for e in range(m):
            c.b[e] = softness_of(c.contact[e], c.row[e], c) * c.z[e] - work.c[c.row[e]]
        lu_solve(m, c.factor, c.order, c.b, c.z)
    for e in range(m):
        work.P[c.row[e]] = c.z[e]
    for k in range(n_k):
        a, has_friction = work.start[k], work.start[k + 1] - work.start[k] > 1
        pull = math.hypot(work.P[a + 1], work.P[a + 2]) if has_friction else 0.0
        most = work.laws[k, LAW_C] * work.P[a] if has_friction else 0.0
        if is_decided_now(k, n_k, c) and not (work.P[a] > 0.0 and pull <= most):
            return False
    return True
