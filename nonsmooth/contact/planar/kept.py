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

from nonsmooth.contact.planar.problem import ACCEPTED, UNIT, name_modes, residual, sliding, velocities
from nonsmooth.contact.planar.single import FREE, SLIDE_PLUS, STICK, STILL, sigma_of, slip_of
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.mechanics.system import BILATERAL, GIVEN_FORCE, UNILATERAL, ContactMode
from nonsmooth.numerics.dense import lu, lu_solve

BALANCED = 8.0  # roundings of a sum of few terms, up to which impulses balance
ROUNDED = 1e-13  # of max |c|, or of the largest impulse: what is less is rounding
ALPHA = 1e-10  # shift, relative to the diagonal: far above rounding, far below the eigenvalues of mass ratios to 1e6
CORRECTIONS = 4  # of a system: the eigenvalues of mass ratios to 1e6 leave (1e-4)^4
SHARES = 6  # ways to share a load among redundant contacts that are tried


@kernel
def begin(is_loaded, n, closed, start, kinds, previous_P, P):
    """Start from the impulses of the step before, or from none; returns whether there are any."""
    size = 0.0
    for k in range(n):
        i = closed[k]
        shift = 1 if kinds[i, 0] == GIVEN_FORCE else 0
        for row in range(start[k], start[k + 1]):
            P[row] = previous_P[i, row - start[k] + shift] if is_loaded else 0.0
            size += abs(P[row])
    return size > 0.0


@kernel
def keep_impulses(n, closed, start, kinds, G, c, previous_P, mode, P, planar):
    """Whether every contact rested and the impulses of the step before still balance the load, but for the rounding of
    the sums: what is more would add up, and a block at rest would creep."""
    for k in range(n):
        i = closed[k]
        if mode[i] == ContactMode.OPEN or mode[i] == ContactMode.SLIDE:
            return False
        planar.candidate[k] = STICK
    begin(True, n, closed, start, kinds, previous_P, P)
    r = start[n]
    velocities(r, G, c, P, planar.gamma)
    for k in range(r):
        if not is_balanced(k, max(BALANCED, r + 1.0), r, G, c, P, planar):
            return False
    for k in range(n):
        i = closed[k]
        r = start[k]
        P_N = planar.normal_impulse[k] if kinds[i, 0] == GIVEN_FORCE else P[r]
        reach = abs(P_N) if kinds[i, 0] == BILATERAL else P_N
        if reach < 0.0 or (kinds[i, 1] > 0 and abs(P[start[k + 1] - 1]) > planar.mu_static[k] * reach):
            return False
    return True


@kernel
def is_balanced(k, units, r, G, c, P, planar):
    """Whether the velocity of row k is none, but for some roundings of the sum of the sizes of its terms."""
    if planar.gamma[k] == 0.0:
        return True
    size = abs(c[k])
    for m in range(r):
        size += abs(G[k, m] * P[m])
    return abs(planar.gamma[k]) <= units * UNIT * size


@kernel
def recall_modes(n, closed, kinds, mode, slip, previous_P, planar):
    """The modes of the step before as candidates."""
    for k in range(n):
        i = closed[k]
        if mode[i] == ContactMode.OPEN:
            planar.candidate[k] = FREE
        elif mode[i] == ContactMode.SLIDE:
            planar.candidate[k] = sliding(slip[i] > 0, kinds[i, 0] == BILATERAL and previous_P[i, 0] < 0.0)
        else:
            planar.candidate[k] = STICK


@rare_kernel
def hold_modes(n, closed, start, kinds, G, c, P, planar):
    """Whether the modes in planar.candidate solve the problem; writes P, the velocities and their true modes.

    ``planar.is_shared`` tells whether other impulses would do as well.
    """
    for _ in range(SHARES):
        for row in range(start[n]):
            P[row] = 0.0
        if not solve_for_modes(n, closed, start, kinds, G, c, P, planar):
            return False
        if planar.is_shared == 0 or not saturate(n, closed, start, kinds, G, P, planar):
            break
    return (
        residual(n, closed, start, kinds, G, c, P, planar) <= ACCEPTED
        and goes_on(n, closed, start, kinds, G, c, P, planar)
        and name_modes(STILL, n, closed, start, kinds, G, c, P, planar)
    )


@kernel
def solve_for_modes(n, closed, start, kinds, G, c, P, planar):
    """Change P to the impulses that the modes in planar.candidate ask for; False where there are none."""
    r = start[n]
    size = impose_modes(n, closed, start, kinds, P, planar)
    assemble_modes(n, size, start, G, 0.0, planar)
    planar.is_shared = 0
    if not lu(size, planar.A, planar.order):
        planar.is_shared = 1
        assemble_modes(n, size, start, G, ALPHA, planar)
        if not lu(size, planar.A, planar.order):
            return False
    for _ in range(CORRECTIONS):
        velocities(r, G, c, P, planar.gamma)
        is_done = True
        for e in range(size):
            row = planar.unknown[e]
            planar.b[e] = -planar.gamma[row] / G[row, row]
            is_done = is_done and is_balanced(row, 0.5 * max(BALANCED, 0.5 * r), r, G, c, P, planar)
        if is_done:
            break
        lu_solve(size, planar.A, planar.order, planar.b, planar.z)
        for e in range(size):
            P[planar.unknown[e]] += planar.z[e]
        for k in range(n):
            if planar.candidate[k] >= SLIDE_PLUS and kinds[closed[k], 0] != GIVEN_FORCE:
                P[start[k + 1] - 1] = factor(k, planar) * P[start[k]]
    return True


@kernel
def impose_modes(n, closed, start, kinds, P, planar):
    """P = 0 open, P_F = f P_N sliding; lists the other rows and returns their number."""
    unknown = planar.unknown
    size = 0
    for k in range(n):
        a, t, candidate = start[k], start[k + 1] - 1, planar.candidate[k]
        if candidate == FREE:
            for row in range(a, t + 1):
                P[row] = 0.0
            continue
        if kinds[closed[k], 0] != GIVEN_FORCE:
            unknown[size] = a
            size += 1
        if kinds[closed[k], 1] > 0 and candidate == STICK:
            unknown[size] = t
            size += 1
        elif candidate >= SLIDE_PLUS:
            P_N = planar.normal_impulse[k] if kinds[closed[k], 0] == GIVEN_FORCE else P[a]
            P[t] = factor(k, planar) * P_N
    return size


@kernel
def factor(k, planar):
    """f of a sliding contact: P_F = f P_N."""
    return -slip_of(planar.candidate[k]) * sigma_of(planar.candidate[k]) * planar.mu[k]


@kernel
def assemble_modes(n, size, start, G, shift, planar):
    """The rows and columns of G that ``impose_modes`` listed, f times the tangential column on that of the normal of a
    sliding contact, each row over its diagonal, with a shift of that."""
    A, unknown = planar.A, planar.unknown
    column = 0
    for k in range(n):
        t = start[k + 1] - 1
        while column < size and unknown[column] <= t:
            for e in range(size):
                A[e, column] = G[unknown[e], unknown[column]]
                if planar.candidate[k] >= SLIDE_PLUS:
                    A[e, column] += factor(k, planar) * G[unknown[e], t]
            column += 1
    for e in range(size):
        row = unknown[e]
        for m in range(size):
            A[e, m] /= G[row, row]
        A[e, e] += shift


@kernel
def saturate(n, closed, start, kinds, G, P, planar):
    """Of a load that redundant contacts share: free those that would pull, hold those beyond their cones at its border.
    Returns whether there are any."""
    slack, is_changed = ROUNDED * load(n, start, G, P), False
    for k in range(n):
        kind, a, t, candidate = kinds[closed[k], 0], start[k], start[k + 1] - 1, planar.candidate[k]
        if candidate == FREE or kind == GIVEN_FORCE:
            continue
        if kind == UNILATERAL and P[a] * G[a, a] < -slack:
            planar.candidate[k] = FREE
            is_changed = True
        elif kinds[closed[k], 1] > 0 and candidate == STICK:
            if G[t, t] * (abs(P[t]) - planar.mu_static[k] * abs(P[a])) > slack:
                planar.candidate[k] = sliding(P[t] < 0.0, P[a] < 0.0)
                is_changed = True
    return is_changed


@kernel
def load(n, start, G, P):
    """The largest velocity that an impulse alone would give to its own row."""
    largest = 0.0
    for row in range(start[n]):
        largest = max(largest, G[row, row] * abs(P[row]))
    return largest


@kernel
def goes_on(n, closed, start, kinds, G, c, P, planar):
    """Whether no contact is past the end of its mode: the residual, relative to the fastest one, would let a slow one
    stick beyond its friction by a force of ACCEPTED max |c| / dt, which is no longer small where the step is.

    What rounding leaves of a redundant contact without load becomes 0, and what it adds to a friction impulse is taken
    off.
    """
    scale = 0.0
    for k in range(start[n]):
        scale = max(scale, abs(c[k]))
    slack, rest = ROUNDED * scale, ROUNDED * load(n, start, G, P) if planar.is_shared == 1 else 0.0
    for k in range(n):
        i, a, t, candidate = closed[k], start[k], start[k + 1] - 1, planar.candidate[k]
        kind = kinds[i, 0]
        P_N = planar.normal_impulse[k] if kind == GIVEN_FORCE else P[a]
        if candidate == FREE:
            if (kind == UNILATERAL and planar.gamma[a] < -slack) or (kind == GIVEN_FORCE and P_N > 0.0):
                return False
            continue
        if kind == UNILATERAL and P_N < 0.0:
            if P_N * G[a, a] < -rest:
                return False
            for row in range(a, t + 1):
                P[row] = 0.0
            continue
        reach = planar.mu_static[k] * (abs(P_N) if kind == BILATERAL else P_N)
        if kinds[i, 1] > 0 and candidate == STICK and abs(P[t]) > reach:
            if abs(P[t]) > reach * (1.0 + ROUNDED) + rest / G[t, t]:
                return False
            P[t] = math.copysign(reach, P[t])
        if candidate >= SLIDE_PLUS and (
            sigma_of(candidate) * P_N < 0.0 or slip_of(candidate) * planar.gamma[t] < -slack
        ):
            return False
    return True
