"""The search for forces at many states, in one compiled loop.

A point sets natural variables s and parameters p; the model's ``natural_state(t, s, p, x)`` makes the state x = (q, u)
of them; ``paradox.forces`` does the rest.
"""

from __future__ import annotations

import math
from typing import Annotated as Array

from nonsmooth.contact.planar.forces import Forces, Outcome, forces_at_state, sliding_speed, solution_of
from nonsmooth.contact.planar.single import PULL_MINUS, SLIDE_PLUS
from nonsmooth.contact.spatial.forces import forces_in_space
from nonsmooth.jit import call_model, kernel
from nonsmooth.jit.blocks import Block, Floats, Ints, view
from nonsmooth.mechanics.sys import Sys
from nonsmooth.mechanics.system import BILATERAL, GIVEN_FORCE

VARIABLE, PARAMETER = 0, 1  # code: what a name sets
# code: codes of modes beside those of contact.planar.single; a slide in two directions has no sign
NO_SOLUTION, OPEN, SLIDE_IN_SPACE = -1, PULL_MINUS + 1, PULL_MINUS + 2
NATURAL = 0  # code: the only function of a compiled natural state


class Table(Block):
    """What the points are made of, and what is found there. a = names, m = points, c = contacts, k = kept."""

    d: int  # directions of friction
    values: Array[Floats, "a", "m"]  # of each name at each point
    names: Array[Ints, "a", 2]  # VARIABLE or PARAMETER, and its place in s or p
    links: Array[Ints, "l", 3]  # contact, column of its law, place in p: coefficients that are parameters
    s: Array[Floats, "n_s"]  # natural variables
    x: Array[Floats, "n_q + n_u"]
    q: Array[Floats, "n_q"]
    u: Array[Floats, "n_u"]
    states: Array[
        Floats, "n_states", "n_q + n_u"
    ]  # given, one a point, where the model has no natural state; else one row
    number: Array[Ints, "m"]  # solutions
    outcome: Array[Ints, "m"]
    p_s: Array[Floats, "m", "c"]  # the smallest p of the slides that the state admits
    b: Array[Floats, "m", "c"]
    gamma_F: Array[Floats, "m", "c"]
    la_N: Array[Floats, "m", "k * c"]
    modes: Array[Ints, "m", "k * c"]


@kernel("void(int64, int64, float64, int64, int64)", short_loops=True)
def search_points(sys_at, natural, t, forces_at, table_at):
    """Fill the results of every point."""
    sys = view(sys_at, Sys)
    table, forces = view(table_at, Table), view(forces_at, Forces)
    s, p, x, q, u, laws = table.s, sys.p, table.x, table.q, table.u, sys.laws
    n_q = q.shape[0]
    for m in range(table.values.shape[1]):
        set_point(m, sys, table)
        for link in range(table.links.shape[0]):
            laws[table.links[link, 0], table.links[link, 1]] = p[table.links[link, 2]]
        if natural != 0:
            if not call_model(natural, NATURAL, t, s, u, p, x):
                table.outcome[m] = Outcome.NOT_FINITE.value
                table.number[m] = 0
                continue
        else:
            for j in range(x.shape[0]):
                x[j] = table.states[m, j]
        for j in range(n_q):
            q[j] = x[j]
        for j in range(u.shape[0]):
            u[j] = x[n_q + j]
        if table.d > 1:
            outcome, found, n_k, _ = forces_in_space(sys_at, t, q, u, forces_at)
        else:
            outcome, found, n_k, _ = forces_at_state(sys_at, t, q, u, forces_at)
        table.outcome[m] = outcome
        table.number[m] = found
        write_coefficients(sys, m, n_k, forces, table)
        write_solutions(sys, m, found, n_k, forces, table)


@kernel
def set_point(m, sys, table):
    """Set s, and the p of the system, to the values of one point."""
    for a in range(table.names.shape[0]):
        if table.names[a, 0] == PARAMETER:
            sys.p[table.names[a, 1]] = table.values[a, m]
        else:
            table.s[table.names[a, 1]] = table.values[a, m]


@kernel
def write_coefficients(sys, m, n_k, forces, table):
    """p, b and gamma_F of each closed contact, with two directions the speed; nan where a contact is open or has no
    such row."""
    work, kinds, nan = forces.work, sys.kinds, math.nan
    for i in range(sys.n_c):
        table.p_s[m, i] = nan
        table.b[m, i] = nan
        table.gamma_F[m, i] = forces.gamma[i, 1] if kinds[i, 1] < 2 else sliding_speed(i, forces.gamma)
    for k in range(n_k):
        i = work.closed[k]
        if kinds[i, 0] == GIVEN_FORCE:
            continue
        a = work.start[k]
        table.b[m, i] = work.c[a]
        table.p_s[m, i] = work.G[a, a]
        if kinds[i, 1] > 0:
            tilt = forces.mu[k] * work.G[a, a + 1]
            s = forces.slip[k]
            if s == 0 and kinds[i, 1] > 1:  # the worst of all directions
                g_1, g_2 = work.G[a, a + 1], work.G[a, a + 2]
                tilt = forces.mu[k] * math.sqrt(g_1 * g_1 + g_2 * g_2)
            table.p_s[m, i] -= abs(tilt) if s == 0 or kinds[i, 0] == BILATERAL else s * tilt


@kernel
def write_solutions(sys, m, found, n_k, forces, table):
    """Normal forces and modes of the solutions that are kept, in places of n_c; beyond them nan and NO_SOLUTION."""
    kinds, n_c = sys.kinds, sys.n_c
    kept = table.modes.shape[1] // n_c
    for j in range(kept * n_c):
        is_one = j < found * n_c
        table.la_N[m, j] = 0.0 if is_one else math.nan
        table.modes[m, j] = OPEN if is_one else NO_SOLUTION
    for j in range(min(found, kept, forces.la.shape[0])):
        for k in range(n_k):
            i, row = forces.work.closed[k], solution_of(j, forces.island[k], forces)
            mode = forces.candidate[row, k]
            table.modes[m, j * n_c + i] = SLIDE_IN_SPACE if kinds[i, 1] > 1 and mode >= SLIDE_PLUS else mode
            given = kinds[i, 0] == GIVEN_FORCE
            table.la_N[m, j * n_c + i] = forces.normal[k] if given else forces.la[row, forces.work.start[k]]
