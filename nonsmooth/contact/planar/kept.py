"""What the step before says of this one: several contacts often go on as they were.

keep_impulses   every contact rested: the impulses of the step before are kept if they still balance the load
hold_modes      each contact open, sticking or sliding leaves one linear system,

                gamma_N = 0 (closed),  gamma_F = 0 (sticking),  P_F = f P_N (sliding),  f = -s mu sigma,

                whose solution is taken if it satisfies the inclusions.

Where contacts are redundant the system is singular, and of the impulses that solve it the least are taken, in the
metric diag G: a share of the load that no step before has a part in. With A the rows and columns of G that the modes
leave and a = 1e-10

    (A + a diag A) dP = -gamma

is repeated from P = 0: what is not in the null space of A falls by a/(a + lambda) each time, lambda an eigenvalue of A
scaled to a diagonal of ones. A contact that would pull is given no impulse then, and one beyond its cone the border of
it. Source of the shift: Rockafellar, *SIAM J. Control Optim.* 14 (1976) 877.
"""

from __future__ import annotations

import math

from nonsmooth.contact.planar.problem import (
    ACCEPTED_RESIDUAL,
    largest_velocity,
    name_modes,
    normal_impulse_of,
    residual,
    size_of_terms,
    sliding_candidate,
    velocities,
)
from nonsmooth.contact.planar.single import FREE, SLIDE_PLUS, STICK, STILL_VELOCITY, sigma_of, slip_of
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.mechanics.system import BILATERAL, GIVEN_FORCE, UNILATERAL, ContactMode
from nonsmooth.numerics.dense import lu, lu_solve
from nonsmooth.numerics.rounding import rounded_sum

BALANCED_ROUNDINGS = 8.0  # chosen: roundings of a sum of few terms, up to which impulses balance
KEPT_SLACK = 1e-13  # chosen: of max |c|, or of the largest impulse: what is less is rounding
# derived: shift, relative to the diagonal: far above rounding, far below the eigenvalues of mass ratios to 1e6
MODE_SHIFT = 1e-10
MODE_CORRECTIONS = 4  # derived: of a system: the eigenvalues of mass ratios to 1e6 leave (1e-4)^4
SHARES = 6  # chosen: ways to share a load among redundant contacts that are tried


@kernel
def begin_impulses(is_loaded, problem):
    """Start from the impulses of the step before, or from none; returns whether there are any."""
    size = 0.0
    for k in range(problem.n):
        shift = 1 if problem.kinds[k, 0] == GIVEN_FORCE else 0
        for row in range(problem.start[k], problem.start[k + 1]):
            P_k = problem.previous_P[k, row - problem.start[k] + shift] if is_loaded else 0.0
            problem.P[row] = P_k
            size += abs(P_k)
    return size > 0.0


@kernel
def keep_impulses(problem, planar):
    """Whether every contact rested and the impulses of the step before still balance the load, but for the rounding of
    the sums: what is more would add up, and a block at rest would creep."""
    for k in range(problem.n):
        if problem.mode[k] == ContactMode.OPEN or problem.mode[k] == ContactMode.SLIDE:
            return False
        problem.candidate[k] = STICK
    begin_impulses(True, problem)
    velocities(problem, planar)
    for row in range(problem.r):
        if not is_balanced(row, max(BALANCED_ROUNDINGS, problem.r + 1.0), problem, planar):
            return False
    for k in range(problem.n):
        P_N = normal_impulse_of(k, problem)
        reach = abs(P_N) if problem.kinds[k, 0] == BILATERAL else P_N
        friction = abs(problem.P[problem.start[k + 1] - 1])
        if reach < 0.0 or (problem.kinds[k, 1] > 0 and friction > problem.mu_static[k] * reach):
            return False
    return True


@kernel
def is_balanced(row, units, problem, planar):
    """Whether the velocity of a row is none, but for some roundings of the sum of the sizes of its terms."""
    speed = planar.gamma[row]
    return speed == 0.0 or abs(speed) <= rounded_sum(units, size_of_terms(row, problem))


@kernel
def recall_modes(problem):
    """The modes of the step before as candidates."""
    for k in range(problem.n):
        if problem.mode[k] == ContactMode.OPEN:
            problem.candidate[k] = STICK if problem.kinds[k, 0] == BILATERAL else FREE
        elif problem.mode[k] == ContactMode.SLIDE:
            is_pulled = problem.kinds[k, 0] == BILATERAL and problem.previous_P[k, 0] < 0.0
            problem.candidate[k] = sliding_candidate(problem.slip[k] > 0, is_pulled)
        else:
            problem.candidate[k] = STICK


@rare_kernel
def hold_modes(problem, planar):
    """Whether the modes in problem.candidate solve the problem; writes P, the velocities and their true modes.

    ``planar.is_shared`` tells whether other impulses would do as well.
    """
    for _ in range(SHARES):
        for row in range(problem.r):
            problem.P[row] = 0.0
        if not solve_for_modes(problem, planar):
            return False
        if planar.is_shared == 0 or not saturate(problem):
            break
    return (
        residual(problem, planar) <= ACCEPTED_RESIDUAL
        and goes_on(problem, planar)
        and name_modes(STILL_VELOCITY, problem, planar)
    )


@kernel
def solve_for_modes(problem, planar):
    """Change P to the impulses that the modes in problem.candidate ask for; False where there are none."""
    P, G, gamma, unknown = problem.P, problem.G, planar.gamma, planar.unknown
    size = impose_modes(P, problem, planar)
    assemble_modes(size, 0.0, problem, planar)
    planar.is_shared = 0
    if not lu(size, planar.A, planar.order):
        planar.is_shared = 1
        assemble_modes(size, MODE_SHIFT, problem, planar)
        if not lu(size, planar.A, planar.order):
            return False
    for _ in range(MODE_CORRECTIONS):
        velocities(problem, planar)
        is_done = True
        for e in range(size):
            row = unknown[e]
            planar.b[e] = -gamma[row] / G[row, row]
            is_done = is_done and is_balanced(row, 0.5 * max(BALANCED_ROUNDINGS, 0.5 * problem.r), problem, planar)
        if is_done:
            break
        lu_solve(size, planar.A, planar.order, planar.b, planar.z)
        for e in range(size):
            P[unknown[e]] += planar.z[e]
        for k in range(problem.n):
            if problem.candidate[k] >= SLIDE_PLUS and problem.kinds[k, 0] != GIVEN_FORCE:
                P[problem.start[k + 1] - 1] = factor(k, problem) * P[problem.start[k]]
    return True


@kernel
def impose_modes(P, problem, planar):
    """P = 0 open, P_F = f P_N sliding; lists the other rows in planar.unknown and returns their number."""
    unknown = planar.unknown
    size = 0
    for k in range(problem.n):
        a, t, candidate = problem.start[k], problem.start[k + 1] - 1, problem.candidate[k]
        is_given = problem.kinds[k, 0] == GIVEN_FORCE
        if candidate == FREE:
            for row in range(a, t + 1):
                P[row] = 0.0
            continue
        if not is_given:
            unknown[size] = a
            size += 1
        if problem.kinds[k, 1] > 0 and candidate == STICK:
            unknown[size] = t
            size += 1
        elif candidate >= SLIDE_PLUS:
            P[t] = factor(k, problem) * (problem.normal_impulse[k] if is_given else P[a])
    return size


@kernel
def factor(k, problem):
    """f of a sliding contact: P_F = f P_N."""
    return -slip_of(problem.candidate[k]) * sigma_of(problem.candidate[k]) * problem.mu[k]


@kernel
def assemble_modes(size, shift, problem, planar):
    """The rows and columns of G that ``impose_modes`` listed, f times the tangential column on that of the normal of a
    sliding contact, each row over its diagonal, with a shift of that."""
    A, G, unknown = planar.A, problem.G, planar.unknown
    column = 0
    for k in range(problem.n):
        t = problem.start[k + 1] - 1
        while column < size and unknown[column] <= t:
            for e in range(size):
                A[e, column] = G[unknown[e], unknown[column]]
                if problem.candidate[k] >= SLIDE_PLUS:
                    A[e, column] += factor(k, problem) * G[unknown[e], t]
            column += 1
    for e in range(size):
        row = unknown[e]
        for m in range(size):
            A[e, m] /= G[row, row]
        A[e, e] += shift


@kernel
def saturate(problem):
    """Of a load that redundant contacts share: free those that would pull, hold those beyond their cones at its border.
    Returns whether there are any."""
    P, G, slack, is_changed = problem.P, problem.G, KEPT_SLACK * load(problem), False
    for k in range(problem.n):
        kind, candidate = problem.kinds[k, 0], problem.candidate[k]
        a, t = problem.start[k], problem.start[k + 1] - 1
        if candidate == FREE or kind == GIVEN_FORCE:
            continue
        if kind == UNILATERAL and P[a] * G[a, a] < -slack:
            problem.candidate[k] = FREE
            is_changed = True
        elif problem.kinds[k, 1] > 0 and candidate == STICK:
            if G[t, t] * (abs(P[t]) - problem.mu_static[k] * abs(P[a])) > slack:
                problem.candidate[k] = sliding_candidate(P[t] < 0.0, P[a] < 0.0)
                is_changed = True
    return is_changed


@kernel
def load(problem):
    """The largest velocity that an impulse alone would give to its own row."""
    largest = 0.0
    for row in range(problem.r):
        largest = max(largest, problem.G[row, row] * abs(problem.P[row]))
    return largest


@kernel
def goes_on(problem, planar):
    """Whether no contact is past the end of its mode: the residual, relative to the fastest one, would let a slow one
    stick beyond its friction by a force of ACCEPTED_RESIDUAL max |c| / dt, which is no longer small where the step is.

    What rounding leaves of a redundant contact without load becomes 0, and what it adds to a friction impulse is taken
    off.
    """
    P, G, gamma = problem.P, problem.G, planar.gamma
    slack = KEPT_SLACK * largest_velocity(problem)
    rest = KEPT_SLACK * load(problem) if planar.is_shared == 1 else 0.0
    for k in range(problem.n):
        kind, candidate = problem.kinds[k, 0], problem.candidate[k]
        a, t = problem.start[k], problem.start[k + 1] - 1
        P_N = normal_impulse_of(k, problem)
        if candidate == FREE:
            if (kind == UNILATERAL and gamma[a] < -slack) or (kind == GIVEN_FORCE and P_N > 0.0):
                return False
            continue
        if kind == UNILATERAL and P_N < 0.0:
            if P_N * G[a, a] < -rest:
                return False
            for row in range(a, t + 1):
                P[row] = 0.0
            continue
        reach = problem.mu_static[k] * (abs(P_N) if kind == BILATERAL else P_N)
        if problem.kinds[k, 1] > 0 and candidate == STICK and abs(P[t]) > reach:
            if abs(P[t]) > reach * (1.0 + KEPT_SLACK) + rest / G[t, t]:
                return False
            P[t] = math.copysign(reach, P[t])
        if candidate >= SLIDE_PLUS and (sigma_of(candidate) * P_N < 0.0 or slip_of(candidate) * gamma[t] < -slack):
            return False
    return True
