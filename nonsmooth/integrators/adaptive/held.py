"""One plain step of Moreau–Jean with the modes held: the contacts are equations, and nothing is decided.

    Mhat (u_1 - u_0) = dt (h(t_mid, q_mid, u_mid) + C (u_mid - u_0)) + W^T P,    Mhat = M + dt/2 C + dt^2/4 K
    gamma_N = 0 (closed),    gamma_F = 0 (sticking),    P_F = -s mu(v) sigma P_N (sliding),    P = 0 (open)

with v = s (gamma_F0 + gamma_F1)/2 and the velocities carried through the step by the rates of the rows. It is the step
of moreau_jean/step.py for theta = 1/2 where no mode changes, and it goes on smoothly where one should have: so the
values with different numbers of steps can be extrapolated whatever is in the step, and where a mode ends is found on
the motion that results (adaptive/events.py).

u_mid is u_0 where the Jacobian C of the forces is exact. Where it is one of differences, taken once in an adaptive
step, or the given normal forces read u, the step is taken twice, the second time with u_mid = (u_0 + u_1)/2: it is of
second order then whatever C is. Source: Steihaug, Wolfbrandt, *Math. Comp.* 33 (1979) 521.
"""

from __future__ import annotations

from nonsmooth.errors import Status
from nonsmooth.integrators.adaptive.state import THETA, Extrapolation
from nonsmooth.integrators.moreau_jean.step import VELOCITY_ROUNDINGS, new_velocity
from nonsmooth.integrators.records import CLOSURE, FRICTION, N_FUNCTIONS, SIGN, book_energy
from nonsmooth.integrators.rigid.modes import BACKWARD, FORWARD, list_islands
from nonsmooth.integrators.rigid.rates import force_function, pressing_force, solve_island
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.jit.blocks import view
from nonsmooth.mechanics.acceleration_problem import find_row_rates, row_shift
from nonsmooth.mechanics.contact_problem import (
    DAMPING_BY_DIFFERENCES,
    MASS_IS_CONSTANT,
    NORMAL_FORCE_READS_U,
    ROWS_ARE_CONSTANT,
    ROWS_READ_T,
    STIFFNESS_BY_DIFFERENCES,
    SURFACES_ARE_CONSTANT,
    apply_inverse,
    clear_rounding,
    delassus,
    difference_forces,
    evaluate_unloaded_rows,
    find_loads,
    is_implicit,
    row_velocities,
    stack_rows,
)
from nonsmooth.mechanics.laws import depends_on_speed, friction_coefficient, static_coefficient
from nonsmooth.mechanics.sys import Sys, evaluate
from nonsmooth.mechanics.system import (
    BILATERAL,
    DAMPING,
    FORCE,
    GAP,
    GIVEN_FORCE,
    MASS,
    NORMAL_FORCE,
    STIFFNESS,
    UNILATERAL,
    ContactMode,
)
from nonsmooth.numerics.dense import bandwidth, cholesky, cholesky_solve, lu, lu_solve
from nonsmooth.numerics.rounding import rounded_sum

# derived: facts of a model whose forces on the contacts read the velocities
READS_U = DAMPING_BY_DIFFERENCES | NORMAL_FORCE_READS_U
# chosen: iterations of Newton's method on the sliding speeds: it is quadratic, and starts from those before
SPEEDS = 10
# chosen: of the speeds: the difference that gives the slope of a friction law, which steers the iteration only
SLOPE = 1e-6
SHIFT_ROUNDING = 1e-2  # chosen: of the shift of the rows: below it a difference of moving rows is rounding
# derived: bands: a given normal force that is none. Models cut it at zero, and there its function, armed or not, must
# be farther below its threshold than the two bands within which an event counts as located: 4 - 1 > 2
NO_LOAD = 4.0
SETTLED_IMPULSE = 1e-14  # chosen: of the largest impulse: a smaller correction is rounding


@kernel("int64(int64, float64, float64, int64, int64)", short_loops=True)
def held_step(sys_at, t, dt, k, run_at):
    """Advance ``run.trial`` by one step, the k-th of its row, with the modes of run.contacts; returns a Status."""
    sys = view(sys_at, Sys)
    run = view(run_at, Extrapolation)
    contacts, trial, work = run.contacts, run.trial, run.contacts.work
    n = trial.q.shape[0]
    run.counters.substeps += 1
    n_k = list_closed(sys, contacts)
    status, r = prepare_step(sys, t, dt, n_k, run)
    if status != Status.RUNNING:
        return status
    status = find_end_velocity(sys, t + 0.5 * dt, dt, n_k, r, run)
    if status != Status.RUNNING:
        return status
    total = 0.0
    for j in range(n):
        total += 0.0 * (work.u_1[j] * work.u_1[j])
    if total != 0.0:
        return Status.NOT_FINITE.value
    take_samples(sys, k, dt, n_k, run)
    book_step(sys, dt, n_k, run)
    return Status.RUNNING.value


@kernel
def list_closed(sys, contacts):
    """List the contacts that are not open; returns their number."""
    n_k = 0
    for i in range(sys.n_c):
        if contacts.mode[i] != ContactMode.OPEN:
            contacts.work.closed[n_k] = i
            n_k += 1
    return n_k


@kernel
def prepare_step(sys, t, dt, n_k, run):
    """What does not depend on the forces: gaps, M, Mhat, rows and their rates, G. Returns (Status, rows)."""
    n = sys.n
    trial, work = run.trial, run.contacts.work
    has, t_mid, u = sys.has, t + 0.5 * dt, trial.u
    for j in range(n):
        work.q_mid[j] = trial.q[j] + 0.5 * dt * u[j]
    if n_k < sys.n_c and not evaluate(sys, GAP, t_mid, work.q_mid, u, work.g_N):
        return Status.NOT_FINITE.value, 0
    if run.is_known[0] == 0 or not has & MASS_IS_CONSTANT:
        if not evaluate(sys, MASS, t_mid, work.q_mid, u, work.M):
            return Status.NOT_FINITE.value, 0
        work.band = bandwidth(n, work.M)
        if not cholesky(n, work.band, work.M, work.factor):
            return Status.MASS_NOT_POSITIVE.value, 0
        run.is_known[0] = 1
    if is_implicit(sys):
        status = find_jacobians(sys, t_mid, dt, run)
        if status != Status.RUNNING:
            return status, 0
    if n_k == 0:
        return Status.RUNNING.value, 0
    for i in range(work.N.shape[0]):
        work.N[i] = 0.0  # the loads are those at u_mid: find_loads
    if not evaluate_unloaded_rows(sys, run.is_known[1] == 0, t_mid, u, work):
        return Status.NOT_FINITE.value, 0
    run.is_known[1] = 1
    r = stack_rows(sys, n_k, u, work)
    apply_inverse(sys, is_implicit(sys), r, work)
    is_finite = carry_velocities(sys, t, dt, n_k, r, run)
    return Status.RUNNING.value if is_finite else Status.NOT_FINITE.value, r


@kernel
def find_jacobians(sys, t_mid, dt, run):
    """C, K and the factors of Mhat; differences are taken in the first plain step of an adaptive one only."""
    n = sys.n
    work, u = run.contacts.work, run.trial.u
    has, is_first = sys.has, run.counters.has_jacobian == 0
    if is_first and has & (DAMPING_BY_DIFFERENCES | STIFFNESS_BY_DIFFERENCES):
        if not evaluate(sys, FORCE, t_mid, work.q_mid, u, work.h):
            return Status.NOT_FINITE.value
    if is_first and has & DAMPING_BY_DIFFERENCES:
        for j in range(n):
            work.trial[j] = dt * work.h[j]
        cholesky_solve(n, work.band, work.factor, work.trial)
        if not difference_forces(sys, t_mid, work.q_mid, u, True, work):
            return Status.NOT_FINITE.value
    elif has & (1 << DAMPING) and not evaluate(sys, DAMPING, t_mid, work.q_mid, u, work.C):
        return Status.NOT_FINITE.value
    if is_first and has & STIFFNESS_BY_DIFFERENCES:
        for j in range(n):
            work.trial[j] = dt * u[j]
        if not difference_forces(sys, t_mid, work.q_mid, u, False, work):
            return Status.NOT_FINITE.value
    elif has & (1 << STIFFNESS) and not evaluate(sys, STIFFNESS, t_mid, work.q_mid, u, work.K):
        return Status.NOT_FINITE.value
    for i in range(n):
        for j in range(n):
            work.Mhat[i, j] = work.M[i, j] + THETA * dt * (work.C[i, j] + THETA * dt * work.K[i, j])
    is_regular = lu(n, work.Mhat, work.order)
    run.counters.has_jacobian = 1 if is_regular else 0
    return Status.RUNNING.value if is_regular else Status.MASS_NOT_POSITIVE.value


@kernel
def carry_velocities(sys, t, dt, n_k, r, run):
    """work.gamma_0 at the beginning of the step, run.rate = dt (W' u + w') of its middle; False if a row is none.

    The differences of rows that move with the time reach from the beginning of the step to its end: what they are off
    by is extrapolated. A gamma_0 of rounding is zero: an impulse of dt la_N is lost in it where steps are short.
    """
    n = sys.n
    contacts, there, work = run.contacts, run.step.there, run.contacts.work
    has, q, u = sys.has, run.trial.q, run.trial.u
    for k in range(r):
        run.rate[k] = 0.0
    if not has & ROWS_ARE_CONSTANT or not has & SURFACES_ARE_CONSTANT:
        for k in range(n_k):
            there.closed[k] = work.closed[k]
        e = row_shift(sys, u)
        if has & ROWS_READ_T:
            e = max(0.25 * dt, SHIFT_ROUNDING * e)
        if not find_row_rates(sys, e, t + 0.5 * dt, work.q_mid, u, n_k, contacts.rates, there):
            return False
        for j in range(n):
            there.q_mid[j] = q[j]
        if not evaluate_unloaded_rows(sys, True, t, u, there):
            return False
        row_velocities(sys, n_k, u, there)
        for k in range(r):
            run.rate[k] = dt * contacts.rates[0, k]
            work.gamma_0[k] = there.gamma_0[k]
    for k in range(r):
        size = abs(work.w[k])
        for j in range(n):
            size += abs(work.W[k, j] * u[j])
        if abs(work.gamma_0[k]) <= rounded_sum(VELOCITY_ROUNDINGS, size):
            work.gamma_0[k] = 0.0
    return True


@kernel
def find_end_velocity(sys, t_mid, dt, n_k, r, run):
    """work.u_1 by the forces at u before the step, or where they read u by those in its middle; returns a Status.

    By itself: LLVM unrolls the loops of an entry point before it inlines what they call.
    """
    u, u_mid, u_1 = run.trial.u, run.u_mid, run.contacts.work.u_1
    for j in range(sys.n):
        u_mid[j] = u[j]
    for _ in range(2 if sys.has & READS_U else 1):
        status = find_new_velocity(sys, t_mid, dt, n_k, r, run)
        if status != Status.RUNNING:
            return status
        for j in range(sys.n):
            u_mid[j] = 0.5 * (u[j] + u_1[j])
    return Status.RUNNING.value


@kernel
def find_new_velocity(sys, t_mid, dt, n_k, r, run):
    """The velocities work.u_1 after the step, by the forces at u_mid; returns a Status."""
    n = sys.n
    work, u = run.contacts.work, run.trial.u
    has = sys.has
    if not evaluate(sys, FORCE, t_mid, work.q_mid, run.u_mid, work.h):
        return Status.NOT_FINITE.value
    if is_implicit(sys):
        for i in range(n):
            for j in range(n):
                work.h[i] += work.C[i, j] * (run.u_mid[j] - u[j])
            work.rhs[i] = dt * work.h[i]
        lu_solve(n, work.Mhat, work.order, work.rhs, work.du)
    else:
        for i in range(n):
            work.du[i] = dt * work.h[i]
        cholesky_solve(n, work.band, work.factor, work.du)
    if n_k > 0:
        if has & (1 << NORMAL_FORCE) and not find_loads(sys, t_mid, run.u_mid, work):
            return Status.NOT_FINITE.value
        delassus(n, r, work)
        for k in range(r):
            work.c[k] += run.rate[k]
        clear_rounding(n, r, work)
        find_impulses(sys, dt, n_k, r, run)
    new_velocity(n, r, u, work)
    return Status.RUNNING.value


@kernel
def find_impulses(sys, dt, n_k, r, run):
    """work.P from the equations of the modes, island by island; redundant contacts share their load."""
    contacts, work = run.contacts, run.contacts.work
    varies = set_friction(sys, dt, n_k, run)
    for k in range(n_k):
        i = work.closed[k]
        if sys.kinds[i, 0] == GIVEN_FORCE:
            work.P[work.start[k]] = contacts.la[i, 1]
    for island in range(list_islands(sys, n_k, contacts)):
        for e in range(solve_island(sys, island, n_k, False, contacts)):
            i, a = contacts.contact[e], contacts.row[e]
            work.P[a] = contacts.z[e]
            if contacts.part[e] == 0 and contacts.mode[i] == ContactMode.SLIDE:
                work.P[a + 1] = contacts.ratio[i] * contacts.z[e]
        varies = varies and contacts.facts.is_shared == 0 and contacts.facts.is_admissible == 0
    if varies:
        settle_speeds(sys, n_k, r, run)


@kernel
def set_friction(sys, dt, n_k, run):
    """P_F/P_N of the contacts that slide, P_F itself under a given normal force, both to contacts, at the speed before
    the step; whether a law depends on the speed."""
    contacts, work = run.contacts, run.contacts.work
    varies = False
    for k in range(n_k):
        i = work.closed[k]
        is_given = sys.kinds[i, 0] == GIVEN_FORCE
        if is_given:
            contacts.la[i, 0] = dt * work.N[i] if run.is_loaded[i] == 1 else 0.0
            contacts.la[i, 1] = 0.0
        if contacts.mode[i] != ContactMode.SLIDE:
            continue
        s = contacts.slip[i]
        varies = varies or depends_on_speed(sys.laws, i)
        mu = coefficient(sys, i, s * work.gamma_0[work.start[k + 1] - 1])
        contacts.ratio[i] = -s * mu * contacts.sign[i]
        if is_given:
            contacts.la[i, 1] = -s * mu * contacts.la[i, 0]
    return varies


@kernel
def coefficient(sys, i, v):
    """mu(v), carried on beyond v = 0 with the slope that it has there: mu(-v) = 2 mu(0) - mu(v)."""
    if v >= 0.0 or not depends_on_speed(sys.laws, i):
        return friction_coefficient(sys.laws, i, max(0.0, v))
    return 2.0 * friction_coefficient(sys.laws, i, 0.0) - friction_coefficient(sys.laws, i, -v)


@rare_kernel
def settle_speeds(sys, n_k, r, run):
    """Newton's method for P where mu depends on the speed in the middle of the step: all r equations at once."""
    contacts, work = run.contacts, run.contacts.work
    J, order, rest, change, P, G = contacts.factor, contacts.order, contacts.left, contacts.sum, work.P, work.G
    for _ in range(SPEEDS):
        largest = 0.0
        for a in range(r):
            rest[a] = -work.c[a]
            largest = max(largest, abs(P[a]))
            for b in range(r):
                J[a, b] = G[a, b]
                rest[a] -= G[a, b] * P[b]
        for k in range(n_k):
            if contacts.mode[work.closed[k]] == ContactMode.SLIDE:
                linearise_friction(sys, k, r, run)
        if not lu(r, J, order):
            return
        lu_solve(r, J, order, rest, change)
        moved = 0.0
        for a in range(r):
            P[a] += change[a]
            moved = max(moved, abs(change[a]))
        if not moved > SETTLED_IMPULSE * largest:
            return


@kernel
def linearise_friction(sys, k, r, run):
    """The equation P_F + s mu(v) sigma P_N = 0 of closed contact k, about the impulses that are there, times G_FF."""
    contacts, work = run.contacts, run.contacts.work
    i, b = work.closed[k], work.start[k + 1] - 1
    s, G, P = contacts.slip[i], work.G, work.P
    gamma = -contacts.left[b]  # of the friction row, at the end of the step
    v = 0.5 * s * (work.gamma_0[b] + gamma)
    step = SLOPE * (abs(v) + abs(work.gamma_0[b]) + abs(gamma))
    mu = coefficient(sys, i, v)
    slope = (coefficient(sys, i, v + step) - mu) / step if step > 0.0 else 0.0
    is_given = sys.kinds[i, 0] == GIVEN_FORCE
    normal = contacts.la[i, 0] if is_given else contacts.sign[i] * P[b - 1]
    for c in range(r):
        contacts.factor[b, c] = G[b, b] * 0.5 * slope * normal * G[b, c]  # s^2 = 1
    contacts.factor[b, b] += G[b, b]
    if not is_given:
        contacts.factor[b, b - 1] += G[b, b] * s * mu * contacts.sign[i]
    contacts.left[b] = -G[b, b] * (P[b] + s * mu * normal)


@kernel
def take_samples(sys, k, dt, n_k, run):
    """The event functions of the k-th plain step of a row: of forces and gaps in its middle, of sliding at its end."""
    contacts, work = run.contacts, run.contacts.work
    for e in range(run.sample.shape[1]):
        run.sample[k, e] = 1.0
    for i in range(sys.n_c):
        if contacts.mode[i] == ContactMode.OPEN and sys.kinds[i, 0] == UNILATERAL:
            run.sample[k, N_FUNCTIONS * i + CLOSURE] = work.g_N[i]
    r = work.start[n_k] if n_k > 0 else 0
    for m in range(n_k):
        i, a, b = work.closed[m], work.start[m], work.start[m + 1] - 1
        e, kind, mode = N_FUNCTIONS * i, sys.kinds[i, 0], contacts.mode[i]
        normal = work.P[a] / dt
        if kind == GIVEN_FORCE:
            normal = max(0.0, work.N[i])
            run.sample[k, e + CLOSURE] = load(i, run)
        elif kind == UNILATERAL:
            run.sample[k, e + CLOSURE] = force_function(normal, i, contacts)
        if mode == ContactMode.SLIDE:
            if contacts.ratio[i] != 0.0 or depends_on_speed(sys.laws, i):
                gamma = work.c[b]
                for c in range(r):
                    gamma += work.G[b, c] * work.P[c]
                run.sample[k, e + FRICTION] = contacts.slip[i] * gamma
            if kind == BILATERAL:
                run.sample[k, e + SIGN] = force_function(contacts.sign[i] * normal, i, contacts)
        elif mode == ContactMode.STICK:
            pull = work.P[b] / dt
            most = static_coefficient(sys.laws, i) * pressing_force(normal, pull, i, contacts)
            run.sample[k, e + FORWARD] = force_function(most + pull, i, contacts)
            run.sample[k, e + BACKWARD] = force_function(most - pull, i, contacts)


@kernel
def load(i, run):
    """The event function of a given normal force that acts, or does not."""
    excess = run.contacts.work.N[i] - NO_LOAD * run.band[N_FUNCTIONS * i + CLOSURE]
    return excess if run.is_loaded[i] == 1 else -excess


@kernel
def book_step(sys, dt, n_k, run):
    """Move to the end of the step; book energy and impulses."""
    n = sys.n
    trial, work, kinds = run.trial, run.contacts.work, sys.kinds
    book_energy(sys, dt, THETA, is_implicit(sys), n_k, trial, work)
    for i in range(sys.n_c):
        for m in range(trial.P.shape[1]):
            trial.P[i, m] = 0.0
    for k in range(n_k):
        i, shift = work.closed[k], 0
        if kinds[i, 0] == GIVEN_FORCE:
            shift = 1
            trial.P[i, 0] = dt * max(0.0, work.N[i])
        for m in range(work.start[k], work.start[k + 1]):
            trial.P[i, m - work.start[k] + shift] = work.P[m]
        for m in range(trial.P.shape[1]):
            trial.P_sum[i, m] += trial.P[i, m]
    for j in range(n):
        way = 0.5 * dt * (trial.u[j] + work.u_1[j])
        run.way[j] += way
        trial.q[j] += way
        trial.u[j] = work.u_1[j]
    if n_k == 0:
        trial.counters.skipped += 1
    else:
        trial.counters.kept += 1
        trial.counters.solved += 1
