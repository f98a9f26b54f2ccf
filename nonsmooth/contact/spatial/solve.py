"""Contacts with friction in two directions: the round cone |P_T| <= mu P_N, to a residual by our own natural map.

    open     P = 0,         gamma_N >= 0
    sticks   gamma = 0,     |P_T| <= mu_s P_N
    slides   gamma_N = 0,   P_T = -mu(|v|) P_N v / |v|,    v = (offset + gamma_T) / 2

One contact by the exact solver (contact/blocks/one_contact.py), of which all solutions are known (all_solutions.py);
several by Gauss–Seidel and Newton's method (few_contacts.py, newton_few.py), each exact to rounding or not taken.

v is the sliding velocity in the middle of the step, offset that before it: with the direction at the end of the step
the motion along a curve would be of first order only. It is taken where a slide goes on: what lands, begins to slide,
stops or turns back in a step is braked along its velocity at the end, as in Moreau's step. Coefficient and
directions are found by solving again, the coefficient of sticking first: the speed changes mu by O(dt) of itself.
Source: Acary, Brogliato, *Numerical Methods for Nonsmooth Dynamical Systems* (2008), chapter 13.
"""

from __future__ import annotations

import math

from nonsmooth.contact.blocks.few_contacts import error_of, measure_sizes, put_on_cones, sweep_some
from nonsmooth.contact.blocks.natural_map import velocity
from nonsmooth.contact.blocks.newton_few import SWEEPS_BEFORE, step_some
from nonsmooth.contact.blocks.nsgs import sweep
from nonsmooth.contact.blocks.one_contact import decide_one, judge_one
from nonsmooth.contact.planar.problem import ACCEPTED_RESIDUAL
from nonsmooth.contact.planar.selection import FREE, SLIDE_MINUS, SLIDE_PLUS, STICK, WORST_RANK, rank
from nonsmooth.contact.planar.single import STILL_VELOCITY
from nonsmooth.contact.spatial.all_solutions import SLIDE, is_saddle, is_surely_unique, list_solutions
from nonsmooth.contact.spatial.problem import (
    ROWS,
    Spatial,
    begin_from,
    fill_blocks,
    fill_free_velocities,
    take_impulses,
)
from nonsmooth.errors import Status
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.jit.blocks import view
from nonsmooth.mechanics.contact_problem import Problem
from nonsmooth.mechanics.laws import friction_coefficient, is_no_friction, static_coefficient
from nonsmooth.mechanics.system import GIVEN_FORCE, ContactMode

EXACT_SOLUTION = 1e-13  # chosen: some hundreds of roundings of the largest term
MOST_SWEEPS = 2_000  # chosen: of Gauss–Seidel where Newton's method goes nowhere, as redundant contacts may
MOST_PASSES = 60  # chosen: of coefficients and directions: a change of mu by dt of itself comes to rounding in ten
SAME_COEFFICIENT = 1e-14  # chosen: of mu: some tens of roundings
GOES_ON = 0.5  # chosen: of the sliding velocity: a slide that keeps less in a step is at its end
SAME_DIRECTION = 1e-15  # chosen: sine of the angle by which a slide has not turned
# code: where in the step the velocity is taken that friction opposes; END_FOR_GOOD: for good
BY_END, BY_MIDDLE, END_FOR_GOOD = 0, 1, 2


@kernel("Tuple((int64, int64, float64))(int64, int64)", short_loops=True)
def solve_spatial(problem_at, spatial_at):
    """Solve a problem of contacts, of which some have friction in two directions: impulses and modes of the contacts.

    Returns the Status (RUNNING, NOT_SOLVED, or NEGATIVE_FRICTION with the number of the contact in place of the number
    of solutions), the number of solutions, 0 where it is not known, and the residual.
    """
    work, spatial = view(problem_at, Problem), view(spatial_at, Spatial)
    n_k = work.n
    fill_blocks(n_k, work, spatial)
    begin_from(n_k, work, spatial)
    for k in range(n_k):
        spatial.mu[k] = static_coefficient(work.laws, k) if work.kinds[k, 1] > 0 else 0.0
        spatial.state[k] = BY_END
    solutions = 0
    for _ in range(MOST_PASSES):
        fill_free_velocities(n_k, work, spatial)
        error, solutions = solve_blocks(n_k, work, spatial)
        if not error <= ACCEPTED_RESIDUAL:
            return Status.NOT_SOLVED.value, 0, error
        verdict = follow_slides(n_k, work, spatial)
        if verdict < 0:
            return Status.NEGATIVE_FRICTION.value, work.closed[-1 - verdict], error
        if verdict == 0:
            take_impulses(n_k, work, spatial)
            take_modes(n_k, work, spatial)
            return Status.RUNNING.value, solutions, error
    return Status.NOT_SOLVED.value, 0, ACCEPTED_RESIDUAL


@kernel
def solve_blocks(n_k, work, spatial):
    """Write spatial.P and gamma: (error, number of solutions; 0 where it is not known)."""
    G, c, mu, P, gamma = spatial.G, spatial.c, spatial.mu, spatial.P, spatial.gamma
    if n_k == 1:
        error, _ = decide_one(G, c, mu, P, gamma, spatial.scaled, ROWS)
        if work.kinds[0, 1] < 2 or is_surely_unique(G, 0, mu[0]):
            return error, 1
        return choose_one(error, work, spatial)
    rows, error = (G, spatial.columns, spatial.starts), math.inf
    memory = (spatial.jacobian, spatial.vectors, spatial.matrix, spatial.order)
    for _ in range(2):  # from the impulses before, then from none
        _, error, _ = sweep_some(rows, c, mu, P, gamma, spatial.rho, EXACT_SOLUTION, max(SWEEPS_BEFORE, c.shape[0]))
        if not error <= EXACT_SOLUTION:
            _, error, _ = step_some(rows, c, mu, P, gamma, spatial.rho, memory, EXACT_SOLUTION)
        if error <= EXACT_SOLUTION:
            return error, 0
        for i in range(P.shape[0]):
            P[i] = 0.0
    return sweep_long(rows, c, mu, P, gamma, spatial.rho), 0


@rare_kernel
def sweep_long(rows, c, mu, P, gamma, rho):
    """Sweep until the residual is accepted: redundant contacts may give Newton's method no step."""
    norm, error = measure_sizes(rows, c, rho), math.inf
    for _ in range(MOST_SWEEPS if norm > 0.0 else 0):
        if math.sqrt(sweep(rows, c, mu, rho, P)) <= ACCEPTED_RESIDUAL * norm:
            put_on_cones(mu, P, ROWS)
            velocity(rows[0], rows[1], rows[2], c, P, gamma)
            error = error_of(mu, rho, P, gamma, ROWS)[0] / norm
            if error <= ACCEPTED_RESIDUAL:
                break
    return error


@rare_kernel
def choose_one(error, work, spatial):
    """Of all solutions of one contact the one that the rule of selection takes: (error, number of solutions)."""
    G, c, mu, P, answers = spatial.G, spatial.c, spatial.mu[0], spatial.P, spatial.answers
    modes, was_stuck, best, slides = answers.modes, work.mode[0] == ContactMode.STICK, WORST_RANK, 0
    found = list_solutions(G, 0, c, mu, mu, answers)
    for m in range(found):
        is_left = modes[m] == SLIDE and is_saddle(G, 0, c, mu, answers.alphas[slides])
        slides += 1 if modes[m] == SLIDE else 0
        its_rank = rank(modes[m], is_left, was_stuck, False, work.selection)
        if its_rank > best:
            best = its_rank
            for a in range(ROWS):
                P[a] = answers.P[m, a]
    if found > 1:
        error, _ = judge_one(G, c, spatial.mu, P, spatial.gamma, ROWS)
    return error, found


@kernel
def follow_slides(n_k, work, spatial):
    """Coefficients and directions of the contacts that slide, by their velocities: 1 where some have changed, else 0;
    -1 - k where contact k has no friction coefficient."""
    changed = 0
    for k in range(n_k):
        i = ROWS * k
        if work.kinds[k, 1] == 0:
            continue
        if not slides(k, spatial):
            if spatial.state[k] == BY_MIDDLE:
                changed = take_end(k, spatial)
            continue
        o_1, o_2 = offset_of(k, 1, work, spatial), offset_of(k, 2, work, spatial)
        v_1, v_2 = spatial.gamma[i + 1] - spatial.offset[i + 1], spatial.gamma[i + 2] - spatial.offset[i + 2]
        mu = friction_coefficient(work.laws, k, 0.5 * math.sqrt((o_1 + v_1) ** 2 + (o_2 + v_2) ** 2))
        if is_no_friction(mu):
            return -1 - k
        if abs(mu - spatial.mu[k]) > SAME_COEFFICIENT * mu:
            spatial.mu[k], changed = mu, 1
        ahead, across = o_1 * v_1 + o_2 * v_2, abs(o_1 * v_2 - o_2 * v_1)
        if spatial.state[k] == BY_MIDDLE and not ahead > 0.0:
            changed = take_end(k, spatial)
        elif spatial.state[k] == BY_END and ahead > GOES_ON * (o_1 * o_1 + o_2 * o_2):
            if work.mode[k] == ContactMode.SLIDE and across > SAME_DIRECTION * ahead:
                spatial.offset[i + 1], spatial.offset[i + 2] = o_1, o_2
                spatial.state[k], changed = BY_MIDDLE, 1
    return changed


@kernel
def take_end(k, spatial):
    """Friction of contact k opposes its velocity at the end of the step, whatever comes out; returns 1."""
    spatial.offset[ROWS * k + 1], spatial.offset[ROWS * k + 2] = 0.0, 0.0
    spatial.state[k] = END_FOR_GOOD
    return 1


@kernel
def offset_of(k, a, work, spatial):
    """The sliding velocity before the step of contact k in one direction."""
    row = spatial.row[k, a]
    return work.offset[row] if row >= 0 else 0.0


@kernel
def slides(k, spatial):
    """Whether closed contact k slides: of |gamma_T| and what the cone leaves of |P_T|, one is rounding."""
    i, P, gamma, largest = ROWS * k, spatial.P, spatial.gamma, 0.0
    for a in range(ROWS):
        largest = max(largest, abs(spatial.c[i + a]))
    speed = math.sqrt(gamma[i + 1] * gamma[i + 1] + gamma[i + 2] * gamma[i + 2])
    left = spatial.mu[k] * P[i] - math.sqrt(P[i + 1] * P[i + 1] + P[i + 2] * P[i + 2])
    return speed > STILL_VELOCITY * largest and speed > spatial.size[k] * left


@kernel
def take_modes(n_k, work, spatial):
    """What each contact does."""
    for k in range(n_k):
        i, d = ROWS * k, work.kinds[k, 1]
        if work.kinds[k, 0] != GIVEN_FORCE and spatial.P[i] <= 0.0:
            work.candidate[k] = FREE
        elif d == 0 or not slides(k, spatial):
            work.candidate[k] = STICK
        elif d == 1:
            work.candidate[k] = SLIDE_PLUS if spatial.gamma[i + 1] > 0.0 else SLIDE_MINUS
        else:
            work.candidate[k] = SLIDE
