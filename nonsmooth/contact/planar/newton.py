"""Semismooth Newton on a planar contact problem, with a proximal shift: many contacts, redundant ones among them.

With x = P - gamma / diag G the inclusions are F(P) = 0,

    F_N = P_N - max(0, x_N)  (gamma_N / G_NN, bilateral),    F_F = P_F - proj_[-R, R](x_F),    R = mu max(0, x_N).

x names the modes: open where x_N <= 0, sticking where |x_F| <= R, else sliding. Given modes the equations are linear. A
step imposes them on P (P = 0 open, P_F = f P_N sliding, f = -+mu) and solves for the impulses of the other rows

    (A + alpha diag A) dP = -gamma,    A the rows and columns of G, f times the tangential column on the normal one.

alpha makes A regular where contacts are redundant: of the impulses that balance the load, those nearest to the last
ones. The part of gamma outside the null space of A falls by alpha / (alpha + lambda) in a step, lambda the least
eigenvalue but 0 of A scaled to a diagonal of ones: steps refine the impulses to rounding. No other mass or unit enters,
and no root. A step is shortened until the merit F . diag(G) F, an energy, falls below the largest of the last ones.
Where the iteration ends without a solution it starts again elsewhere, at last behind sweeps of Gauss–Seidel.

Source: Alart, Curnier, *Comput. Methods Appl. Mech. Engrg.* 92 (1991) 353; the shift is that of Rockafellar's proximal
points, *SIAM J. Control Optim.* 14 (1976) 877; the search that of Grippo, Lampariello, Lucidi, *SIAM J. Numer. Anal.*
23 (1986) 707.
"""

from __future__ import annotations

import math

from nonsmooth.contact.planar.kept import MODE_SHIFT, assemble_modes, begin_impulses, factor, impose_modes
from nonsmooth.contact.planar.problem import ACCEPTED_RESIDUAL, MERITS, Planar, name_modes, residual, sliding_candidate
from nonsmooth.contact.planar.single import FREE, SLIDE_PLUS, STICK, STILL_VELOCITY
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import view
from nonsmooth.mechanics.contact_problem import Problem
from nonsmooth.mechanics.system import BILATERAL, GIVEN_FORCE
from nonsmooth.numerics.dense import lu, lu_solve

MOST_NEWTON_STEPS = 150  # chosen: from one start
MERIT_PATIENCE = 40  # chosen: steps within which the merit must halve
LINE_SEARCH_HALVINGS = 10  # chosen: a thousandth of a step that does not lower the merit is no way down
MERIT_DESCENT = 1e-4  # chosen: least part of the merit by which a full step must lower it
START_SWEEPS = 100  # chosen: of Gauss–Seidel, before the Newton that starts from them
BEFORE, STUCK, UNLOADED, SWEPT = range(4)  # where it starts: impulses of the step before; all stuck; none; after sweeps
N_STARTS = 4  # derived: how many these are


@kernel("boolean(int64, int64)", short_loops=True)
def solve_by_newton(problem_at, planar_at):
    """Whether impulses P were found that satisfy the inclusions; the modes are in ``problem.candidate``."""
    problem, planar = view(problem_at, Problem), view(planar_at, Planar)
    for first in range(N_STARTS):
        is_loaded = begin_impulses(first == BEFORE, problem)
        if first == SWEPT:
            sweep(problem)
        if (is_loaded or first != BEFORE) and iterate(first == STUCK, problem, planar):
            return True
    return False


@kernel
def sweep(problem):
    """Projected Gauss–Seidel, row by row: P = proj(x)."""
    G, P = problem.G, problem.P
    for _ in range(START_SWEEPS):
        for k in range(problem.n):
            kind = problem.kinds[k, 0]
            pressed = problem.normal_impulse[k]
            for row in range(problem.start[k], problem.start[k + 1]):
                x = P[row] - velocity_of(row, P, problem) / G[row, row]
                if kind != GIVEN_FORCE and row == problem.start[k]:
                    pressed = x if kind == BILATERAL else max(0.0, x)
                    P[row] = pressed
                else:
                    reach = problem.mu[k] * abs(pressed)
                    P[row] = max(-reach, min(reach, x))


@kernel
def velocity_of(row, P, problem):
    """(G P + c) of a row."""
    total = problem.c[row]
    for m in range(problem.r):
        total += problem.G[row, m] * P[m]
    return total


@kernel
def iterate(is_stuck, problem, planar):
    """Step until the merit stops falling at impulses that are accepted; these to P, with their modes."""
    P, best, merits, r = problem.P, planar.best, planar.merits, problem.r
    merit = evaluate(P, problem, planar)
    if is_stuck:
        for k in range(problem.n):
            problem.candidate[k] = STICK
    for k in range(MERITS):
        merits[k] = merit
    least, mark, since, is_found = math.inf, merit, 0, False
    for count in range(MOST_NEWTON_STEPS):
        if merit < least:
            least = merit
            for k in range(r):
                best[k] = P[k]
            is_found = residual(problem, planar) <= ACCEPTED_RESIDUAL
        since += 1
        if merit <= 0.5 * mark:
            mark, since = merit, 0
        if since == MERIT_PATIENCE or (is_found and since > 0 and count > 0):
            break
        if not newton_step(problem, planar):
            break
        merit = search(problem, planar)
        merits[count % MERITS] = merit
    for k in range(r):
        P[k] = best[k]
    if not is_found:
        return False
    evaluate(P, problem, planar)
    impose_modes(P, problem, planar)
    return residual(problem, planar) <= ACCEPTED_RESIDUAL and name_modes(STILL_VELOCITY, problem, planar)


@kernel
def evaluate(P, problem, planar):
    """The merit at P; the modes to ``problem.candidate``, the velocities to ``planar.gamma``."""
    G, gamma = problem.G, planar.gamma
    for row in range(problem.r):
        gamma[row] = velocity_of(row, P, problem)
    merit = 0.0
    for k in range(problem.n):
        kind, d = problem.kinds[k, 0], problem.kinds[k, 1]
        a, t = problem.start[k], problem.start[k + 1] - 1
        pressed = problem.normal_impulse[k]
        if kind != GIVEN_FORCE:
            pressed = P[a] - gamma[a] / G[a, a]
            if kind != BILATERAL:
                pressed = max(0.0, pressed)
            merit += G[a, a] * (P[a] - pressed) ** 2
        if pressed == 0.0 and kind != BILATERAL:
            problem.candidate[k] = FREE
            if d > 0:
                merit += G[t, t] * P[t] ** 2
        elif d == 0:
            problem.candidate[k] = STICK
        else:
            x_F = P[t] - gamma[t] / G[t, t]
            problem.candidate[k] = STICK
            if abs(x_F) > problem.mu_static[k] * abs(pressed):
                problem.candidate[k] = sliding_candidate(x_F < 0.0, pressed < 0.0)
                x_F = math.copysign(problem.mu[k] * abs(pressed), x_F)
            merit += G[t, t] * (P[t] - x_F) ** 2
    return merit


@kernel
def newton_step(problem, planar):
    """The full step to ``planar.step``; False where its matrix is singular even so, or not finite."""
    trial, step, unknown, r = planar.trial, planar.step, planar.unknown, problem.r
    A, b, z, P = planar.A, planar.b, planar.z, problem.P
    for k in range(r):
        trial[k] = P[k]
    size = impose_modes(trial, problem, planar)
    assemble_modes(size, MODE_SHIFT, problem, planar)
    for e in range(size):
        row = unknown[e]
        b[e] = -velocity_of(row, trial, problem) / problem.G[row, row]
    if not lu(size, A, planar.order):
        return False
    lu_solve(size, A, planar.order, b, z)
    for k in range(r):
        step[k] = trial[k] - P[k]
    total = 0.0
    for e in range(size):
        step[unknown[e]] += z[e]
        total += 0.0 * z[e]
    for k in range(problem.n):
        if problem.candidate[k] >= SLIDE_PLUS and problem.kinds[k, 0] != GIVEN_FORCE:
            a, t = problem.start[k], problem.start[k + 1] - 1
            step[t] = factor(k, problem) * (P[a] + step[a]) - P[t]
    return total == 0.0


@kernel
def search(problem, planar):
    """Take the longest of the halved steps with a merit below those of the last steps, or else the best one."""
    P, trial, step, r = problem.P, planar.trial, planar.step, problem.r
    bound = 0.0
    for k in range(MERITS):
        bound = max(bound, planar.merits[k])
    length, least, shortest = 1.0, math.inf, 1.0
    for _ in range(LINE_SEARCH_HALVINGS):
        for k in range(r):
            trial[k] = P[k] + length * step[k]
        merit = evaluate(trial, problem, planar)
        if merit < least:
            least, shortest = merit, length
        if merit <= (1.0 - MERIT_DESCENT * length) * bound:
            break
        length *= 0.5
    for k in range(r):
        P[k] += shortest * step[k]
    return evaluate(P, problem, planar)
