"""One plain step of Moreau–Jean within an adaptive step: what an error estimate asks of it.

It is the step of moreau_jean/step.py with theta = 1/2 and six changes:

1. a contact takes part where its gap at the mid-point is not above its lid, or where it was active before; the lid is
   zero but for a contact that was closed within the tolerance when the step began;
2. no gap is fed back, since the positions are moved back after the adaptive step (rigid/hold.py): what 1/dt times the
   rounding of a gap does to the velocities depends on the step, and would enter every difference of two step sizes;
3. the velocities are carried through the step by the rates of the rows, which lose nothing in short steps;
4. a contact that was open when the adaptive step began, and parts, takes no part;
5. a bounce that would stay within the tolerance of the gap does not take place, nor one that is slower than the band
   of the velocity: (e gamma_N)^2 / (2 a) <= tol_g, with a the free acceleration towards the surface, or
   |gamma_N| within its band: slower ones, of which nothing comes back, would be off by their velocity from then on;
6. ``selection="impact"`` is asked where a contact decides on its mode: at the start, where it lands and where it stops
   sticking. What slides goes on sliding: stopped anew in every step, it would follow neither mode in the limit.
"""

from __future__ import annotations

from nonsmooth.contact.planar.impacts import has_shock
from nonsmooth.contact.planar.single import Selection
from nonsmooth.errors import Status
from nonsmooth.integrators.adaptive.scales import BAND, is_parting
from nonsmooth.integrators.adaptive.state import THETA, Extrapolation
from nonsmooth.integrators.moreau_jean.contact import solve
from nonsmooth.integrators.moreau_jean.paradox import note_paradoxes
from nonsmooth.integrators.moreau_jean.step import VELOCITY_ROUNDINGS, accept_step, all_finite, new_velocity
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.jit.blocks import address, view
from nonsmooth.mechanics.acceleration_problem import find_row_rates, row_shift
from nonsmooth.mechanics.contact_problem import (
    ROWS_ARE_CONSTANT,
    SURFACES_ARE_CONSTANT,
    add_restitution,
    apply_inverse,
    clear_rounding,
    delassus,
    evaluate_rows,
    is_implicit,
    row_velocities,
    smooth_step,
    stack_rows,
)
from nonsmooth.mechanics.impact import follows_own_law
from nonsmooth.mechanics.laws import LAW_E_N
from nonsmooth.mechanics.sys import Sys, evaluate
from nonsmooth.mechanics.system import GAP, UNILATERAL, ContactMode
from nonsmooth.numerics.rounding import rounded_sum

DROPPED = 0.1  # chosen: of the tolerance of a gap: the height of a bounce that does not take place
# code: no Status: an impact without collision changed the velocities, and the step is to be taken from them
RETAKE = -1


@rare_kernel("int64(int64, float64, float64, int64)", short_loops=True)
def substep(sys_at, t, dt, run_at):
    """Advance ``run.trial`` by one step, or by the impact before it (RETAKE); returns a Status."""
    sys = view(sys_at, Sys)
    run = view(run_at, Extrapolation)
    trial, step, work = run.trial, run.step, run.step.work
    q, u, t_mid, n, n_c = trial.q, trial.u, t + 0.5 * dt, sys.n, sys.n_c
    run.counters.substeps += 1
    for j in range(n):
        work.q_mid[j] = q[j] + 0.5 * dt * u[j]
    if sys.has & (1 << GAP) and not evaluate(sys, GAP, t_mid, work.q_mid, u, work.g_N):
        return Status.NOT_FINITE.value
    n_k = close_within(sys, trial.mode, run.lid, work)
    status = smooth_step(sys, step.is_known[0] == 0, t_mid, dt, THETA, u, work)
    if status != Status.RUNNING:
        return status
    step.is_known[0] = 1
    r = 0
    if n_k > 0:
        if not evaluate_rows(sys, step.is_known[1] == 0, t_mid, u, work):
            return Status.NOT_FINITE.value
        step.is_known[1] = 1
        r = assemble(sys, t, dt, n_k, run)
        touching = leave_out_parting(sys, n_k, run, work) if run.counters.ends_series == 0 else n_k
        if 0 < touching < n_k:
            r = assemble(sys, t, dt, touching, run)
        n_k = touching
        if r < 0:
            return Status.NOT_FINITE.value
    if n_k == 0:
        for j in range(n):
            work.u_1[j] = u[j] + work.du[j]
    else:
        choose_restitution(sys, dt, n_k, run, work)
        add_restitution(run.system, n_k, 0.0, work)
        status = solve(address(run.system), rule(n_k, run, work), dt, n_k, address(trial), address(step))
        if status != Status.RUNNING:
            return status
        if note_paradoxes(run.system, t, dt, n_k, trial, step):
            return RETAKE
        new_velocity(n, r, u, work)
    if not all_finite(n, n_c, work):
        return Status.NOT_FINITE.value
    accept_step(run.system, t, dt, THETA, n_k, trial, step)
    return Status.RUNNING.value


@kernel
def rule(n_k, run, work):
    """The selection rule of this step."""
    selection = run.contacts.facts.selection
    if selection != Selection.IMPACT or run.counters.is_first == 1:
        return selection
    for k in range(n_k):
        if run.trial.mode[work.closed[k]] == ContactMode.SLIDE:
            return Selection.COMPLIANT_LIMIT.value
    return selection


@kernel
def assemble(sys, t, dt, n_k, run):
    """G and c of the closed contacts; returns the number of rows, -1 if a model function raised."""
    n = sys.n
    work, u = run.step.work, run.trial.u
    r = stack_rows(sys, n_k, u, work)
    apply_inverse(sys, is_implicit(sys), r, work)
    delassus(n, r, work)
    return r if find_free_velocities(sys, t, dt, n_k, r, run) else -1


@kernel
def find_free_velocities(sys, t, dt, n_k, r, run):
    """c = gamma_0 + W du + dt (W' u + w') of the r rows, gamma_0 at the beginning of the step; False if a row is none.

    A gamma_0 of rounding is zero: an impulse of dt la_N is lost in it where steps are short.
    """
    n = sys.n
    work, there, has = run.step.work, run.step.there, sys.has
    q, u, c, gamma_0 = run.trial.q, run.trial.u, work.c, work.gamma_0
    if not has & ROWS_ARE_CONSTANT or not has & SURFACES_ARE_CONSTANT:
        for k in range(n_k):
            there.closed[k] = work.closed[k]
        rates = run.step.rates
        if not find_row_rates(sys, row_shift(sys, u), t + 0.5 * dt, work.q_mid, u, n_k, rates, there):
            return False
        for j in range(n):
            there.q_mid[j] = q[j]
        if not evaluate_rows(sys, True, t, u, there):
            return False
        row_velocities(sys, n_k, u, there)
        for k in range(r):
            c[k] += there.gamma_0[k] - gamma_0[k] + dt * rates[0, k]
            gamma_0[k] = there.gamma_0[k]
    for k in range(r):
        size = abs(work.w[k])
        for j in range(n):
            size += abs(work.W[k, j] * u[j])
        if abs(gamma_0[k]) <= rounded_sum(VELOCITY_ROUNDINGS, size):
            c[k] -= gamma_0[k]
            gamma_0[k] = 0.0
    clear_rounding(n, r, work)
    return True


@kernel
def close_within(sys, mode, lid, work):
    """List the contacts that take part; returns their number."""
    n_c = sys.n_c
    n_k = 0
    for i in range(n_c):
        if sys.kinds[i, 0] != UNILATERAL or work.g_N[i] <= lid[i] or mode[i] != ContactMode.OPEN:
            work.closed[n_k] = i
            n_k += 1
    return n_k


@kernel
def leave_out_parting(sys, n_k, run, work):
    """Leave out contacts that were open when the adaptive step began, and part; returns how many are left.

    Where two contacts throw a body from one to the other, the one that it leaves would stop it on its way.
    """
    left = 0
    for k in range(n_k):
        i = work.closed[k]
        was_open = sys.kinds[i, 0] == UNILATERAL and run.contacts.mode[i] == ContactMode.OPEN
        if was_open and is_parting(sys, i, work.gamma_0[work.start[k]], run):
            run.trial.mode[i], run.trial.slip[i] = ContactMode.OPEN.value, 0
            continue
        work.closed[left] = i
        left += 1
    return left


@kernel
def choose_restitution(sys, dt, n_k, run, work):
    """e_N of this step, in ``run.system.laws``: none for a contact that parts, or whose bounce its tolerance hides."""
    strikes = False
    for k in range(n_k):
        i = work.closed[k]
        if sys.kinds[i, 0] != UNILATERAL:
            continue
        row = work.start[k]
        e, gamma_N = sys.laws[i, LAW_E_N], work.gamma_0[row]
        was_closed = run.trial.mode[i] != ContactMode.OPEN
        has_own_law = was_closed and n_k == 1 and follows_own_law(i, sys.kinds, sys.laws)
        run.system.laws[i, LAW_E_N] = e if has_own_law else 0.0  # which an impact without collision follows too
        if e == 0.0 or gamma_N >= 0.0 or run.counters.ends_series == 1:
            continue
        inward = (gamma_N - work.c[row]) / dt
        if -gamma_N > BAND * run.tol_gamma[i] and e * gamma_N * (e * gamma_N) > 2.0 * inward * DROPPED * run.tol_g[i]:
            run.system.laws[i, LAW_E_N] = e
            strikes = True
        else:
            run.dropped[i] = max(run.dropped[i], -gamma_N)
    if strikes and has_shock(n_k, sys, work):  # which goes on to contacts that do not approach yet
        for k in range(n_k):
            i = work.closed[k]
            run.system.laws[i, LAW_E_N] = sys.laws[i, LAW_E_N]
