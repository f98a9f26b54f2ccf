"""Position projection: after a step, move the closed contacts back to their surfaces.

    min |q - q_1|_M   subject to   g_N(q_1) + W_N (q - q_1) >= 0   (= 0 for bilateral contacts)

One linearisation a step, solved by projected Gauss–Seidel on the Delassus matrix of the step. Velocities and impulses
are left as they are. Source: Gear, Gupta, Leimkuhler, *J. Comput. Appl. Math.* 12 (1985) 77, in the form of Acary,
*Appl. Numer. Math.* 62 (2012) 1259 for unilateral contacts.
"""

from __future__ import annotations

from nonsmooth.integrators.records import PROJECTION_WORK, State
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import view
from nonsmooth.mechanics.contact_problem import Work
from nonsmooth.mechanics.kinematics import move
from nonsmooth.mechanics.sys import Sys, evaluate
from nonsmooth.mechanics.system import GAP, GIVEN_FORCE, UNILATERAL, ContactMode

PROJECTION_SWEEPS = 100  # chosen: of Gauss–Seidel on the gaps of a step
CLOSED_GAP = 1e-12  # chosen: of the largest gap: what is left then is far below the error of the linearisation


@kernel("boolean(int64, float64, int64, int64, int64)", short_loops=True)
def project(sys_at, t, n_k, state_at, work_at):
    """Project the positions; False if a gap is not finite. ``work.c`` is overwritten with the multipliers."""
    sys = view(sys_at, Sys)
    n = sys.n
    state, work = view(state_at, State), view(work_at, Work)
    if not sys.has & (1 << GAP):
        return True
    if not evaluate(sys, GAP, t, state.q, state.u, work.g_N):
        return False
    largest = 0.0
    for k in range(n_k):
        work.c[work.start[k]] = 0.0
        if takes_part(sys, k, state, work):
            largest = max(largest, abs(work.g_N[work.closed[k]]))
    if not largest > 0.0:
        return largest == 0.0
    for _ in range(PROJECTION_SWEEPS):
        worst = 0.0
        for k in range(n_k):
            if takes_part(sys, k, state, work):
                worst = max(worst, abs(relax(sys, k, n_k, state, work)))
        if worst <= CLOSED_GAP * largest:
            break
    for k in range(n_k):
        if takes_part(sys, k, state, work):
            for i in range(n):
                shift = work.X[work.start[k], i] * work.c[work.start[k]]
                work.rhs[i] = shift
                state.ledger[PROJECTION_WORK] += work.h[i] * shift
            move(sys, state.q, 1.0, work.rhs, work, state.q)
    return True


@kernel
def takes_part(sys, k, state, work):
    """Whether a contact of the step is held at its surface: bilateral, or unilateral and pressed."""
    i = work.closed[k]
    if sys.kinds[i, 0] == GIVEN_FORCE:
        return False
    return sys.kinds[i, 0] != UNILATERAL or state.mode[i] != ContactMode.OPEN


@kernel
def relax(sys, k, n_k, state, work):
    """One contact's multiplier with the others held; returns the change of its gap."""
    a = work.start[k]
    i = work.closed[k]
    gap = work.g_N[i]
    for m in range(n_k):
        if takes_part(sys, m, state, work):
            gap += work.G[a, work.start[m]] * work.c[work.start[m]]
    change = -gap / work.G[a, a]
    if sys.kinds[i, 0] == UNILATERAL:
        change = max(change, -work.c[a])
    work.c[a] += change
    return change * work.G[a, a]
