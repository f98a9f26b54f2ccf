"""Moreau–Jean time stepping: velocities and impulses, one contact problem a step.

    q_mid = q_0 + dt/2 u_0
    Mhat (u_1 - u_0) = dt h(q_mid, u_0) + W^T P,    (gamma_1 + e gamma_0, P) in the laws of contact and friction
    q_1 = q_0 + dt ((1 - theta) u_0 + theta u_1)

Only contacts whose gap at the mid-point is closed take part. With theta = 1/2 the step is of second order in smooth
motion and of first order across impacts. Sources: Moreau (1988); Jean, *Comput. Methods Appl. Mech. Engrg.* 177 (1999)
235; the feedback of the gap and the passage through paradoxes: docs/theory/moreau_jean.md.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from nonsmooth.arrays import as_number, as_positive
from nonsmooth.blocks import Block, Integers, Matrix, Vector, address, frozen, new_block, view
from nonsmooth.contact_problem import (
    Work,
    add_restitution,
    apply_inverse,
    carry_to_ends,
    close_contacts,
    delassus,
    evaluate_rows,
    is_implicit,
    smooth_step,
    stack_rows,
    work_shapes,
)
from nonsmooth.contact_solvers.modes import enumerate_modes
from nonsmooth.contact_solvers.planar import Route, pivot, solve_planar
from nonsmooth.contact_solvers.planar_problem import Planar, planar_shapes
from nonsmooth.contact_solvers.redundant import enumerate_redundant
from nonsmooth.contact_solvers.single import (
    BOUNDARY,
    FREE,
    NO_CANDIDATE,
    SLIDE_MINUS,
    SLIDE_PLUS,
    STICK,
    count,
    slip_of,
    solve_given_force,
    solve_single,
)
from nonsmooth.errors import InvalidInput, Status
from nonsmooth.integrators.compliance import Compliance, add_compliance, find_end_gaps
from nonsmooth.integrators.projection import project
from nonsmooth.integrators.records import (
    FAILED_CONTACT,
    FOUND,
    INCONSISTENT,
    INDETERMINATE,
    INTERVAL,
    KEPT,
    N_EVENTS,
    PENETRATION,
    PIVOTS,
    RESIDUAL,
    SEVERAL,
    SKIPPED,
    SOLVED,
    STEP,
    STEPS,
    Record,
    State,
    add_event,
    book_energy,
    set_mode,
    write_record,
)
from nonsmooth.jit import Kernel, call_model, kernel
from nonsmooth.laws import LAW_E_F, LAW_E_N, LAW_IMPACT, depends_on_speed, friction_coefficient
from nonsmooth.paradox.impact import impulses_by_law
from nonsmooth.paradox.resolve import had_no_force
from nonsmooth.system import BILATERAL, GAP, GIVEN_FORCE, UNILATERAL, ContactMode, System

ROUNDING = 2e-15  # about eight units in the last place: a smaller change of a velocity is no change


@dataclass(frozen=True)
class MoreauJean:
    """Time stepping with a fixed step.

    Parameters
    ----------
    dt : float
        Step [s].
    theta : float
        Weight of the new velocity in the position, and of the implicit part of the force: 1/2 (second order) to 1.
    projection : bool
        Move the positions back to g_N = 0 after each step where contacts hold (closed contacts drift otherwise by
        O(dt); bilateral ones do not need it, their gap is fed back).
    compliance : Compliance, optional
        A spring and damper at every contact, implicit in the step, in place of e_N; needs theta = 1.

    Raises
    ------
    InvalidInput
        Unless dt > 0 and 1/2 <= theta <= 1, and theta = 1 with a compliance.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> ns.MoreauJean(dt=1e-3)
    MoreauJean(dt=0.001, theta=0.5, projection=False, compliance=None)
    """

    dt: float
    theta: float = 0.5
    projection: bool = False
    compliance: Compliance | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "dt", as_positive("dt", self.dt, "s"))
        theta = as_number("theta", self.theta)
        if not 0.5 <= theta <= 1.0:
            raise InvalidInput(f"theta must lie in [0.5, 1]; got {theta:g}")
        if not isinstance(self.projection, bool):
            raise InvalidInput(f"projection must be True or False; got {self.projection!r}")
        if self.compliance is not None:
            self._check_compliance(theta)

    def _check_compliance(self, theta: float) -> None:
        if not isinstance(self.compliance, Compliance):
            raise InvalidInput(f"compliance must be a Compliance(stiffness, damping); got {self.compliance!r}")
        if theta != 1.0:
            raise InvalidInput(f"a compliance needs theta = 1, with less a stiff contact rings; got theta = {theta:g}")
        if self.projection:
            raise InvalidInput("give either compliance or projection: a compliant contact has an indentation to keep")

    def steps_between(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Equal steps, none longer than dt, between the times t (m + 1,): their lengths and numbers, (m,) each."""
        spans = np.diff(t)
        steps = np.maximum(1, np.ceil(spans / self.dt * (1 - 1e-9))).astype(np.int64)
        dts = spans / steps
        is_dt = np.abs(dts - self.dt) <= 1e-9 * self.dt  # the step asked for, not one a rounding away
        return np.where(is_dt, self.dt, dts), steps

    def options(self, selection: int) -> np.ndarray:
        """The numbers that the compiled loop reads."""
        law = (0.0, 0.0) if self.compliance is None else (self.compliance.stiffness, self.compliance.damping)
        return np.array([self.theta, float(selection), float(self.projection), *law])

    def scratch(self, system: System) -> Block:
        """The arrays that the loop works in."""
        return new_block(Scratch, scratch_shapes(system.n_u, system.n_c, system.d))

    @property
    def loop(self) -> Kernel:
        """The loop over the steps."""
        return run

    def load(self, system: System) -> None:
        """Compile what the loop may reach for this system."""
        entry_points = [step]
        if system.n_c > 1:
            entry_points += [solve_planar, enumerate_modes, pivot]
        if system.d > 0 and (system.kinds[:, 0] != GIVEN_FORCE).any():
            entry_points.append(had_no_force)
        if self.projection:
            entry_points.append(project)
        for entry_point in entry_points:
            entry_point.load()

    def load_for_retry(self, system: System, scratch: Scratch, is_compiled: bool) -> bool:
        """Get ready what decides a contact problem that was not solved; False if there is nothing more to try."""
        if system.n_c < 2 or scratch.planar.can_decide_redundant[0] == 1:
            return False
        if is_compiled:
            enumerate_redundant.load()
        scratch.planar.can_decide_redundant[0] = 1
        return True


class Scratch(NamedTuple):
    """Arrays of one step."""

    work: Work
    there: Work  # the acceleration-level problem at the state before the step
    planar: Planar
    candidate: Integers  # (c,) the candidate taken by each closed contact
    offset: Vector  # (r,) (1 - e_F) gamma_0
    rates: Matrix  # (4, r)
    is_known: Integers  # (2,) 1 once M and the rows were evaluated, for those that are constant


@functools.lru_cache(maxsize=64)
def scratch_shapes(n: int, n_c: int, d: int) -> tuple:
    """Shapes of ``Scratch``."""
    r = max(1, n_c * (1 + d))
    work = work_shapes(n, n_c, d)
    return frozen({
        "work": work, "there": work, "planar": frozen(planar_shapes(n_c, d)), "candidate": (n_c,), "offset": (r,),
        "rates": (4, r), "is_known": (2,),
    })  # fmt: skip


RUN = (
    "int64(int64, int64, float64[::1], int64[:, ::1], float64[:, ::1], float64[::1], "
    "float64[::1], float64[::1], int64[::1], int64, int64, int64, int64)"
)


@kernel(RUN, short_loops=True)
def run(model, has, p, kinds, laws, options, t_record, dts, steps, max_steps, state_at, record_at, scratch_at):
    """Advance from counters[INTERVAL], counters[STEP] by at most max_steps steps; returns a Status.

    Interval j takes steps[j] steps of dts[j] from t_record[j] and ends with record j + 1. options: theta, selection,
    projection, stiffness (0 of a rigid contact), damping.
    """
    state, record, scratch = view(state_at, State), view(record_at, Record), view(scratch_at, Scratch)
    counters = state.counters
    n, n_c = state.q.shape[0], kinds.shape[0]
    scratch.is_known[0] = 0
    scratch.is_known[1] = 0
    if counters[INTERVAL] == 0 and counters[STEP] == 0:
        if not write_record(model, has, 0, t_record[0], p, n, n_c, state, record, scratch.work):
            return Status.NOT_FINITE
    for _ in range(max_steps):
        j = counters[INTERVAL]
        if j >= steps.shape[0]:
            break
        if counters[N_EVENTS] + 3 * n_c > state.events.shape[0]:
            return Status.RUNNING  # the events are full: the caller empties them
        t = t_record[j] + counters[STEP] * dts[j]
        status = step(model, has, p, kinds, laws, options, t, dts[j], n, n_c, state_at, scratch_at)
        if status != Status.RUNNING:
            return status
        counters[STEP] += 1
        if counters[STEP] == steps[j]:
            counters[INTERVAL] += 1
            counters[STEP] = 0
            if not write_record(model, has, j + 1, t_record[j + 1], p, n, n_c, state, record, scratch.work):
                return Status.NOT_FINITE
    return Status.FINISHED if counters[INTERVAL] >= steps.shape[0] else Status.RUNNING


@kernel(
    "int64(int64, int64, float64[::1], int64[:, ::1], float64[:, ::1], float64[::1], float64, float64, int64, int64, "
    "int64, int64)",
    short_loops=True,
)
def step(model, has, p, kinds, laws, options, t, dt, n, n_c, state_at, scratch_at):
    """One step; the state changes only once the step is known to be good. Returns a Status."""
    state, scratch = view(state_at, State), view(scratch_at, Scratch)
    work = scratch.work
    theta = options[0]
    t_mid = t + 0.5 * dt
    q, u, q_mid = state.q, state.u, work.q_mid
    for i in range(n):
        q_mid[i] = q[i] + 0.5 * dt * u[i]
    n_k = 0
    is_rigid = options[3] == 0.0
    if n_c > 0:
        reach = 0.5 * dt if is_rigid else dt
        for i in range(n):
            work.trial[i] = q[i] + reach * u[i]
        if has & (1 << GAP) and not call_model(model, GAP, t + reach, work.trial, state.u, p, work.g_N):
            return Status.NOT_FINITE
        n_k = close_contacts(n_c, kinds, state.mode, work)
    status = smooth_step(model, has, scratch.is_known[0] == 0, t_mid, dt, theta, n, state.u, p, work)
    if status != Status.RUNNING:
        return status
    scratch.is_known[0] = 1
    if n_k == 0:
        for i in range(n):
            work.u_1[i] = state.u[i] + work.du[i]
        state.counters[SKIPPED] += 1
    else:
        if not evaluate_rows(model, has, scratch.is_known[1] == 0, t_mid, state.u, p, work):
            return Status.NOT_FINITE
        scratch.is_known[1] = 1
        r = stack_rows(n, n_k, kinds, state.u, work)
        apply_inverse(has, n, work, r)
        delassus(n, r, work)
        if not carry_to_ends(model, has, t, dt, n, n_k, kinds, state.q, state.u, p, work, scratch.there):
            return Status.NOT_FINITE
        if is_rigid:
            add_restitution(n_k, kinds, laws, 1.0 / ((theta + 0.5) * dt), work)
        else:
            add_compliance(n_k, kinds, laws, options[3], options[4], dt, work)
        status = solve(model, has, p, kinds, laws, int(options[1]), t, dt, n, n_k, state, scratch)
        if status != Status.RUNNING:
            return status
        new_velocity(n, r, state.u, work)
        if not is_rigid:
            find_end_gaps(n, n_k, kinds, dt, work)
    if not all_finite(n, n_c, work):
        return Status.NOT_FINITE
    accept(has, kinds, t, dt, theta, n, n_c, n_k, state, scratch)
    if options[2] != 0.0 and n_k > 0 and not project(model, has, p, kinds, t + dt, n, n_k, state_at, address(work)):
        return Status.NOT_FINITE
    return Status.RUNNING


@kernel
def solve(model, has, p, kinds, laws, selection, t, dt, n, n_k, state, scratch):
    """Solve the contact problem of the closed contacts: impulses to work.P, modes to scratch.candidate."""
    work = scratch.work
    for k in range(n_k):
        i = work.closed[k]
        if kinds[i, 1] > 0:
            a = work.start[k + 1] - 1
            scratch.offset[a] = (1.0 - laws[i, LAW_E_F]) * work.gamma_0[a]
            if depends_on_speed(laws, i) and friction_coefficient(laws, i, abs(work.gamma_0[a])) < 0.0:
                state.counters[FAILED_CONTACT] = i
                return Status.NEGATIVE_FRICTION
    state.counters[SOLVED] += 1
    if n_k == 1:
        found = solve_one(kinds, laws, dt, selection, state, scratch)
        if found == 0:
            state.counters[FAILED_CONTACT] = work.closed[0]
            return Status.NO_SOLUTION
        if work.gamma_0[0] < 0.0 and has_impact_law(work.closed[0], kinds, laws):
            follow_impact_law(laws, scratch)
        note_paradoxes(model, has, p, kinds, laws, t, dt, n, n_k, found, state, scratch)
        return Status.RUNNING
    for k in range(n_k):
        scratch.planar.normal_impulse[k] = dt * max(0.0, work.N[work.closed[k]])
    route, found, pivots, residual = solve_planar(
        n_k, work.closed, work.start, kinds, laws, work.G, work.c, scratch.offset, state.P, state.mode, state.slip,
        selection, work.P, address(scratch.planar),
    )  # fmt: skip
    state.counters[FOUND] = 0
    state.counters[PIVOTS] += pivots
    if route <= Route.NO_SOLUTION:
        state.counters[FAILED_CONTACT] = -1
        return Status.NO_SOLUTION if route == Route.NO_SOLUTION else Status.NOT_SOLVED
    state.worst[RESIDUAL] = max(state.worst[RESIDUAL], residual)
    if route == Route.KEPT or route == Route.KEPT_MODES:
        state.counters[KEPT] += 1
    for k in range(n_k):
        scratch.candidate[k] = scratch.planar.candidate[k]
    note_paradoxes(model, has, p, kinds, laws, t, dt, n, n_k, found, state, scratch)
    return Status.RUNNING


@kernel
def solve_one(kinds, laws, dt, selection, state, scratch):
    """The single closed contact in closed form; returns the number of solutions."""
    work = scratch.work
    i = work.closed[0]
    kind, d = kinds[i, 0], kinds[i, 1]
    G, c, P = work.G, work.c, work.P
    was_stuck = state.mode[i] == ContactMode.STICK
    if kind == GIVEN_FORCE:
        scratch.candidate[0], P[0] = solve_given_force(
            laws, i, G[0, 0], c[0], scratch.offset[0], dt * max(0.0, work.N[i]), was_stuck, state.slip[i]
        )
        return 1
    if d == 0:
        P[0] = -c[0] / G[0, 0]
        if kind == UNILATERAL:
            P[0] = max(0.0, P[0])
        scratch.candidate[0] = STICK if P[0] != 0.0 or kind == BILATERAL else FREE
        return 1
    candidate, P[0], P[1], found = solve_single(
        kind, laws, i, G[0, 0], G[0, 1], G[1, 0], G[1, 1], c[0], c[1], scratch.offset[1],
        was_stuck, state.slip[i], selection,
    )  # fmt: skip
    scratch.candidate[0] = candidate
    state.counters[FOUND] = found
    if candidate == NO_CANDIDATE:
        return 0
    if candidate != FREE:
        error = abs(c[0] + G[0, 0] * P[0] + G[0, 1] * P[1])
        if candidate == STICK:
            error = max(error, abs(c[1] + G[1, 0] * P[0] + G[1, 1] * P[1]))
        size = max(abs(c[0]), abs(c[1]))
        if error > state.worst[RESIDUAL] * size:
            state.worst[RESIDUAL] = error / size
    return count(found)


@kernel
def has_impact_law(i, kinds, laws):
    """Whether impacts of contact i, the only one of its system, follow another law than Newton's, which c holds."""
    return laws[i, LAW_IMPACT] != 0.0 and laws[i, LAW_E_N] > 0.0 and kinds[i, 0] == UNILATERAL and kinds[i, 1] > 0


@kernel
def follow_impact_law(laws, scratch):
    """Replace the impulses of the single closed contact, which collides, by those of its law, and its mode."""
    work = scratch.work
    G, P, gamma_0 = work.G, work.P, work.gamma_0
    if impulses_by_law(laws, work.closed[0], gamma_0, G, P):
        gamma_F = gamma_0[1] + G[1, 0] * P[0] + G[1, 1] * P[1]
        if abs(gamma_F) <= BOUNDARY * abs(gamma_0[1]):
            scratch.candidate[0] = STICK
        else:
            scratch.candidate[0] = SLIDE_PLUS if gamma_F > 0.0 else SLIDE_MINUS


@kernel
def mode_of(candidate, d):
    """The ContactMode of a candidate."""
    if candidate == FREE:
        return ContactMode.OPEN.value
    if d == 0:
        return ContactMode.LOCKED.value
    return ContactMode.STICK.value if candidate == STICK else ContactMode.SLIDE.value


@kernel
def new_velocity(n, r, u, work):
    """u_1 = u_0 + du + X^T P; what cancels to rounding is set to exactly 0 or u_0, so that rest is rest for ever."""
    du, X, P, u_1 = work.du, work.X, work.P, work.u_1
    for i in range(n):
        change = du[i]
        size = abs(du[i])
        for k in range(r):
            part = X[k, i] * P[k]
            change += part
            size += abs(part)
        new = u[i] + change
        if abs(new) <= ROUNDING * (abs(u[i]) + size):
            new = 0.0
        elif abs(change) <= ROUNDING * size:
            new = u[i]
        u_1[i] = new


@kernel
def all_finite(n, n_c, work):
    """Whether the new velocities and the gaps are finite numbers."""
    u_1, g_N = work.u_1, work.g_N
    total = 0.0
    for i in range(n):
        total += 0.0 * u_1[i]
    for i in range(n_c):
        total += 0.0 * g_N[i]
    return total == 0.0


@kernel
def accept(has, kinds, t, dt, theta, n, n_c, n_k, state, scratch):
    """Move to the end of the step; book energy, impulses, modes, events and the worst penetration."""
    work = scratch.work
    book_energy(dt, theta, is_implicit(has), n, n_k, kinds, state, work)
    k = 0
    for i in range(n_c):
        if k == n_k or work.closed[k] != i:  # not closed: it was open already
            for m in range(state.P.shape[1]):
                state.P[i, m] = 0.0
            continue
        candidate = scratch.candidate[k]
        set_mode(t, i, mode_of(candidate, kinds[i, 1]), slip_of(candidate), k, kinds, state, work)
        shift = 0
        if kinds[i, 0] == GIVEN_FORCE:
            shift = 1
            state.P[i, 0] = dt * max(0.0, work.N[i])
        elif kinds[i, 0] == UNILATERAL:
            state.worst[PENETRATION] = max(state.worst[PENETRATION], -work.g_N[i])
        for m in range(work.start[k], work.start[k + 1]):
            state.P[i, m - work.start[k] + shift] = work.P[m]
        for m in range(state.P.shape[1]):
            state.P_sum[i, m] += state.P[i, m]
        k += 1
    q, u, u_1 = state.q, state.u, work.u_1
    for i in range(n):
        q[i] += dt * ((1.0 - theta) * u[i] + theta * u_1[i])
        u[i] = u_1[i]
    state.counters[STEPS] += 1


@kernel
def note_paradoxes(model, has, p, kinds, laws, t, dt, n, n_k, found, state, scratch):
    """Record the beginning of an episode with several solutions, and sliding that no force could go with."""
    work = scratch.work
    is_indeterminate = found >= 3 or (found == 2 and n_k > 1)
    if is_indeterminate:
        state.counters[SEVERAL] += 1
    for k in range(n_k):
        i = work.closed[k]
        if kinds[i, 1] == 0 or kinds[i, 0] == GIVEN_FORCE:
            continue
        candidate = scratch.candidate[k]
        mode = mode_of(candidate, 1)
        if is_indeterminate and state.several[i] == 0:
            add_event(t, INDETERMINATE, i, mode, slip_of(candidate), k, found, kinds, state, work)
        state.several[i] = 1 if is_indeterminate else 0
        if candidate == STICK and state.mode[i] == ContactMode.SLIDE:
            a = work.start[k]
            mu = friction_coefficient(laws, i, abs(work.gamma_0[a + 1]))
            has_negative = work.G[a, a] < mu * abs(work.G[a, a + 1])
            if has_negative and had_no_force(
                model, has, p, kinds, mu, state.slip[i], t, dt, n, n_k, k, state.q, state.u,
                address(work), address(scratch.there), scratch.rates,
            ):  # fmt: skip
                if has_impact_law(i, kinds, laws):
                    impulses_by_law(laws, i, work.gamma_0, work.G, work.P)
                add_event(t, INCONSISTENT, i, mode, 0, k, 0, kinds, state, work)
