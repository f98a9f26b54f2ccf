"""The search for forces at many states, in one compiled loop.

A point of the grid sets natural variables s and parameters p; the model's ``natural_state(t, s, p, x)`` makes the state
x = (q, u) of them; ``paradox.forces`` does the rest. Nothing is shared between two calls but the results, each of which
is written once, so that chunks of the grid run in threads.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from nonsmooth.blocks import Integers, IntegerTable, Matrix, Vector, view
from nonsmooth.contact_solvers.single import PULL_MINUS
from nonsmooth.jit import call_model, kernel
from nonsmooth.paradox.forces import Forces, Outcome, forces_at_state
from nonsmooth.system import BILATERAL, GIVEN_FORCE

VARIABLE, PARAMETER = 0, 1  # what an axis sets
NO_SOLUTION, OPEN = -1, PULL_MINUS + 1  # codes of modes beside those of contact_solvers.single
NATURAL = 0  # the only function of a compiled natural state


class Grid(NamedTuple):
    """What the points are made of, and what is found there. a = axes, m = points of a chunk, c = contacts, k = kept."""

    values: Matrix  # (a, longest) values along each axis
    shape: Integers  # (a,) number of values
    axes: IntegerTable  # (a, 2) VARIABLE or PARAMETER, and its place in s or p
    links: IntegerTable  # (l, 3) contact, column of its law, place in p: coefficients that are parameters
    laws: Matrix  # (c, LAW_WIDTH)
    s: Vector  # natural variables
    p: Vector  # parameters
    x: Vector  # (n_q + n_u,)
    q: Vector
    u: Vector
    states: Matrix  # (m, n_q + n_u) given states, where the model has no natural state of its own; else (1, 1)
    number: Integers  # (m,) solutions
    outcome: Integers  # (m,)
    p_s: Matrix  # (m, c) the smallest p of the slides that the state admits
    b: Matrix  # (m, c)
    gamma_F: Matrix  # (m, c)
    la_N: Matrix  # (m, k c)
    modes: IntegerTable  # (m, k c)


@kernel(
    "void(int64, int64, int64, int64[:, ::1], float64, int64, int64, boolean, int64, int64)",
    short_loops=True,
)
def search_points(model, has, natural, kinds, t, first, last, is_list, forces_at, grid_at):
    """Fill the results of the points ``first`` to ``last``; of a list, all axes advance together."""
    grid, forces = view(grid_at, Grid), view(forces_at, Forces)
    s, p, x, q, u, laws = grid.s, grid.p, grid.x, grid.q, grid.u, grid.laws
    n_q = q.shape[0]
    for point in range(first, last):
        m = point - first
        set_point(point, is_list, grid)
        for link in range(grid.links.shape[0]):
            laws[grid.links[link, 0], grid.links[link, 1]] = p[grid.links[link, 2]]
        if natural != 0:
            if not call_model(natural, NATURAL, t, s, u, p, x):
                grid.outcome[m] = Outcome.NOT_FINITE.value
                grid.number[m] = 0
                continue
        else:
            for j in range(x.shape[0]):
                x[j] = grid.states[m, j]
        for j in range(n_q):
            q[j] = x[j]
        for j in range(u.shape[0]):
            u[j] = x[n_q + j]
        outcome, found, n_k, _ = forces_at_state(model, has, t, q, u, p, kinds, laws, forces_at)
        grid.outcome[m] = outcome
        grid.number[m] = found
        write_coefficients(m, n_k, kinds, forces, grid)
        write_solutions(m, found, n_k, kinds, forces, grid)


@kernel
def set_point(point, is_list, grid):
    """Set s and p to the values of one point; the last axis runs fastest."""
    rest = point
    for back in range(grid.shape.shape[0]):
        a = grid.shape.shape[0] - 1 - back
        j = point if is_list else rest % grid.shape[a]
        rest //= grid.shape[a]
        if grid.axes[a, 0] == PARAMETER:
            grid.p[grid.axes[a, 1]] = grid.values[a, j]
        else:
            grid.s[grid.axes[a, 1]] = grid.values[a, j]


@kernel
def write_coefficients(m, n_k, kinds, forces, grid):
    """p, b and gamma_F of each closed contact; nan where a contact is open or has no such row."""
    work = forces.work
    nan = math.nan
    for i in range(kinds.shape[0]):
        grid.p_s[m, i] = nan
        grid.b[m, i] = nan
        grid.gamma_F[m, i] = forces.gamma[i, 1]
    for k in range(n_k):
        i = work.closed[k]
        if kinds[i, 0] == GIVEN_FORCE:
            continue
        a = work.start[k]
        grid.b[m, i] = work.c[a]
        grid.p_s[m, i] = work.G[a, a]
        if kinds[i, 1] > 0:
            tilt = forces.mu[k] * work.G[a, a + 1]
            s = forces.slip[k]
            grid.p_s[m, i] -= abs(tilt) if s == 0 or kinds[i, 0] == BILATERAL else s * tilt


@kernel
def write_solutions(m, found, n_k, kinds, forces, grid):
    """Normal forces and modes of the solutions that are kept, in places of n_c; beyond them nan and NO_SOLUTION."""
    n_c = kinds.shape[0]
    kept = grid.modes.shape[1] // n_c
    for j in range(kept * n_c):
        is_one = j < found * n_c
        grid.la_N[m, j] = 0.0 if is_one else math.nan
        grid.modes[m, j] = OPEN if is_one else NO_SOLUTION
    for j in range(min(found, kept, forces.la.shape[0])):
        for k in range(n_k):
            i = forces.work.closed[k]
            grid.modes[m, j * n_c + i] = forces.candidate[j, k]
            given = kinds[i, 0] == GIVEN_FORCE
            grid.la_N[m, j * n_c + i] = forces.normal[k] if given else forces.la[j, forces.work.start[k]]
