"""What the step before says of this one: several contacts often go on as they were.

keep_impulses   every contact rested: the impulses of the step before are kept if they still balance the load
keep_modes      each contact open, sticking or sliding as before leaves one linear system,

                gamma_N = 0 (closed),  gamma_F = 0 (sticking),  P_F = -s mu P_N (sliding),

                whose solution is taken if it satisfies the inclusions. Only where the solution is known to be unique.
"""

from __future__ import annotations

from nonsmooth.contact_solvers.planar_problem import ACCEPTED, name_modes, residual
from nonsmooth.contact_solvers.single import STICK
from nonsmooth.dense import lu, lu_solve
from nonsmooth.jit import kernel
from nonsmooth.system import BILATERAL, GIVEN_FORCE, UNILATERAL, ContactMode

BALANCED = 1e-13  # largest relative residual of impulses kept from the step before


@kernel
def keep_impulses(n, closed, start, kinds, G, c, previous_P, mode, P, planar):
    """Whether every contact rested and the impulses of the step before still balance the load."""
    scale = 0.0
    worst = 0.0
    for k in range(n):
        i = closed[k]
        if mode[i] == ContactMode.OPEN or mode[i] == ContactMode.SLIDE:
            return False
        for r in range(start[k], start[k + 1]):
            P[r] = previous_P[i, r - start[k]]
        planar.candidate[k] = STICK
    for k in range(start[n]):
        total = c[k]
        for m in range(start[n]):
            total += G[k, m] * P[m]
        planar.gamma[k] = total
        worst = max(worst, abs(total))
        scale = max(scale, abs(c[k]))
    if not worst <= BALANCED * scale:
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
def keep_modes(n, closed, start, kinds, G, c, mode, slip, P, planar):
    """Whether the modes of the step before solve this one; writes P and the candidates."""
    size = list_unknowns(n, closed, start, kinds, mode, planar)
    assemble(n, size, closed, start, kinds, G, c, mode, slip, planar)
    if not lu(size, planar.A, planar.order):
        return False
    lu_solve(size, planar.A, planar.order, planar.b, planar.z)
    for k in range(start[n]):
        P[k] = 0.0
    for k in range(size):
        P[planar.unknown[k]] = planar.z[k]
    for k in range(n):
        i = closed[k]
        if mode[i] == ContactMode.SLIDE:
            P_N = planar.normal_impulse[k] if kinds[i, 0] == GIVEN_FORCE else P[start[k]]
            P[start[k + 1] - 1] = -slip[i] * planar.mu[k] * P_N
    return (
        residual(n, closed, start, kinds, G, c, P, planar) <= ACCEPTED
        and goes_on(n, closed, start, kinds, c, mode, slip, P, planar)
        and name_modes(n, closed, start, kinds, P, planar)
    )


@kernel
def goes_on(n, closed, start, kinds, c, mode, slip, P, planar):
    """Whether no contact is past the end of its mode: the residual, relative to the fastest one, would let a slow one
    stick beyond its friction by a force of ACCEPTED max |c| / dt, which is no longer small where the step is."""
    scale = 0.0
    for k in range(start[n]):
        scale = max(scale, abs(c[k]))
    slack = BALANCED * scale
    for k in range(n):
        i, r, t = closed[k], start[k], start[k + 1] - 1
        is_unilateral = kinds[i, 0] == UNILATERAL
        if mode[i] == ContactMode.OPEN:
            if is_unilateral and planar.gamma[r] < -slack:
                return False
            continue
        P_N = planar.normal_impulse[k] if kinds[i, 0] == GIVEN_FORCE else P[r]
        reach = abs(P_N) if kinds[i, 0] == BILATERAL else P_N
        if is_unilateral and P_N < 0.0:
            return False
        if kinds[i, 1] > 0 and mode[i] == ContactMode.STICK and abs(P[t]) > planar.mu_static[k] * reach:
            return False
        if mode[i] == ContactMode.SLIDE and slip[i] * planar.gamma[t] < -slack:
            return False
    return True


@kernel
def list_unknowns(n, closed, start, kinds, mode, planar):
    """List the rows with gamma = 0, whose impulses are unknown; returns their number."""
    size = 0
    for k in range(n):
        i = closed[k]
        if mode[i] == ContactMode.OPEN:
            continue
        if kinds[i, 0] != GIVEN_FORCE:
            planar.unknown[size] = start[k]
            size += 1
        if kinds[i, 1] > 0 and mode[i] == ContactMode.STICK:
            planar.unknown[size] = start[k + 1] - 1
            size += 1
    return size


@kernel
def assemble(n, size, closed, start, kinds, G, c, mode, slip, planar):
    """A z + c = 0 for the unknown impulses z: sliding contacts add -s mu times their tangential column."""
    A, b, unknown = planar.A, planar.b, planar.unknown
    for a in range(size):
        b[a] = -c[unknown[a]]
        for e in range(size):
            A[a, e] = G[unknown[a], unknown[e]]
    column = 0
    for k in range(n):
        i = closed[k]
        if mode[i] == ContactMode.OPEN:
            continue
        t = start[k + 1] - 1
        if mode[i] == ContactMode.SLIDE:
            ratio = -slip[i] * planar.mu[k]
            for a in range(size):
                if kinds[i, 0] == GIVEN_FORCE:
                    b[a] -= G[unknown[a], t] * ratio * planar.normal_impulse[k]
                else:
                    A[a, column] += G[unknown[a], t] * ratio
        column += (0 if kinds[i, 0] == GIVEN_FORCE else 1) + (
            1 if kinds[i, 1] > 0 and mode[i] == ContactMode.STICK else 0
        )
