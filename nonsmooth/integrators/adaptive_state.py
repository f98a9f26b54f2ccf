"""What an adaptive run carries along: the state that is tried, the table of extrapolation, tolerances, step control."""

from __future__ import annotations

import functools
from typing import NamedTuple

import numpy as np

from nonsmooth.blocks import Cube, Integers, Matrix, Vector, frozen
from nonsmooth.integrators import moreau_jean_contact
from nonsmooth.integrators.records import N_LEDGER, State, state_shapes
from nonsmooth.integrators.rigid_modes import N_FUNCTIONS, N_WORKS, RigidContacts, contacts_shapes
from nonsmooth.laws import LAW_WIDTH

FIRST_STEP = 1e-4  # of the span
ROWS = 7  # of the table: row j takes j substeps
MOST = 3  # derivatives of the velocities at an end of a step
DEGREE = 2 * MOST + 2  # of the velocities within a step
# clock: the time, the step that the error asks for, the shortest step that the time resolves, tolerances, where the
# next step is to end because an event is there (inf: nowhere), the next step through what has no modes, the way since
# the budget was looked at and the time of that
NOW, STEP, LEAST, RTOL, ATOL, CUT, THROUGH, WAY, LOOKED = range(9)
# counters: refused steps and plain steps, the row of the table at which steps are to converge; whether the step is the
# first; what is to be done before it (see below); whether its end was located; whether differences for the
# Jacobians of the forces were taken at its beginning; events in a row without any motion, tries since the budget was
# looked at, whether the rows of the step are near enough to one another to tell where its events are,
# whether an impact is to end a series of them
REJECTED, SUBSTEPS, TARGET, IS_FIRST, TO_DO, IS_LOCATED, HAS_JACOBIAN, STALLS, TRIES, IS_SEEN, ENDS_SERIES = range(11)
# TO_DO: a smooth step; modes are to be decided first; plain steps until there are modes that last
GO_ON, DECIDE, GO_THROUGH = range(3)
TRIAL_EVENTS = 8  # of the substeps of a row, per contact


class Extrapolation(NamedTuple):
    """Arrays of an adaptive run. n = n_u, c = n_c, N = 2 n + c (1 + d) + N_LEDGER, E = 3 c + 1 event functions."""

    contacts: RigidContacts
    step: moreau_jean_contact.Scratch
    trial: State
    clock: Vector  # (9,)
    counters: Integers  # (11,)
    is_known: Integers  # (2,) 1 once M and the rows of a held step were evaluated, for those that are constant
    weights: Cube  # (2, ROWS, ROWS) of the rows in the extrapolated value, and in the one of an order less
    slope_shares: Cube  # (5, ROWS, ROWS) weights of the rows in the slopes of the velocities
    slopes: Cube  # (ROWS, 5, n) of the velocities, row by row
    highest: Cube  # (4, 5, 5) coefficients of the motion within a step
    ends: Matrix  # (2, 4) derivatives of a velocity at the beginning and at the end
    left: Vector  # (5,) what terms of lower degree leave of it
    B: Matrix  # (DEGREE, n) the motion within the step that was tried
    node_q: Matrix  # (ROWS + 1, n) coordinates between the substeps of the last row
    node_u: Matrix  # (ROWS + 1, n) velocities before an impact without collision there
    begin_u: Matrix  # (ROWS, n) velocities with which each substep begins, after it
    piece: Matrix  # (6, n) of the motion: q, u at its beginning and at its end; those of the next end
    table: Matrix  # (ROWS, N) changes of coordinates, velocities, impulses, works over the step, row by row
    change: Vector  # (N,) of the accepted step
    distance: Vector  # (N,) of it from the extrapolated value of an order less
    errors: Vector  # (ROWS,) estimates of the rows, in tolerances
    largest: Vector  # (2 n,) the largest coordinates and velocities so far
    a_0: Vector  # (n,) accelerations before the step
    a_1: Vector  # (n,) and in the last substep of the row
    way: Vector  # (n,) what the substeps of a row have moved the coordinates by
    u_mid: Vector  # (n,) velocities at which the forces of a held step are taken
    rate: Vector  # (r,) dt (W' u + w') of it
    tol: Vector  # (2 n,) tolerances of coordinates and velocities
    tol_g: Vector  # (c,) of gaps
    tol_gamma: Vector  # (c,) of their rates
    tol_slip: Vector  # (c,) of sliding velocities
    lid: Vector  # (c,) the gap below which an open contact takes part in this step
    g_0: Vector  # (c,) gaps at the beginning of the step
    gamma_0: Vector  # (c,) their rates
    g_1: Vector  # (c,) and at the end
    gamma_1: Vector  # (c,)
    several: Integers  # (c,) whether the last substep of the row, before the probe, had several solutions
    is_loaded: Integers  # (c,) of a given normal force: whether there is one
    heaviest: Vector  # (c,) the largest given normal force so far
    mode: Integers  # (c,) modes that are tried
    slip: Integers  # (c,)
    has_struck: Integers  # (c,) whether an event of the contact is noted already
    is_stopped: Integers  # (c,) whether its slide has just come to rest
    armed: Integers  # (E,) event functions that have been above their band since the last event
    band: Vector  # (E,) within which an event function counts as zero
    f_0: Vector  # (E,) event functions at the beginning of the step
    f_1: Vector  # (E,) at its end
    f_in: Vector  # (E,) and within it
    rises: Vector  # (E,) the place in a step from which on a function is armed
    scale: Vector  # (E,) what they fall by
    sample: Matrix  # (ROWS, E) in the substeps of the last row
    function: Vector  # (2 E,) values and tolerances as rigid_forces.py has them
    laws: Matrix  # (c, LAW_WIDTH) laws of a substep
    u_0: Vector  # (n,) velocities before an event
    x: Vector  # (2 n + 3 c + N_WORKS,) a row of the record
    y: Vector  # (2 n + 3 c + N_WORKS,) a state within a step


@functools.lru_cache(maxsize=64)
def extrapolation_shapes(n: int, n_c: int, d: int) -> tuple:
    """Shapes of ``Extrapolation``."""
    N = 2 * n + n_c * (1 + d) + N_LEDGER
    E = N_FUNCTIONS * n_c + 1
    floats = ("tol_g", "tol_gamma", "tol_slip", "lid", "g_0", "gamma_0", "g_1", "gamma_1", "heaviest")
    integers = ("several", "is_loaded", "mode", "slip", "has_struck", "is_stopped")
    return frozen({
        "contacts": contacts_shapes(n, n_c, d), "step": moreau_jean_contact.scratch_shapes(n, n_c, d),
        "trial": state_shapes(n, n_c, d, TRIAL_EVENTS * max(1, n_c)), "clock": (9,), "counters": (11,),
        "is_known": (2,), "weights": (2, ROWS, ROWS), "slope_shares": (5, ROWS, ROWS), "slopes": (ROWS, 5, n),
        "highest": (4, 5, 5), "ends": (2, 4), "left": (5,), "B": (DEGREE, n), "node_q": (ROWS + 1, n),
        "node_u": (ROWS + 1, n), "begin_u": (ROWS, n), "piece": (6, n), "table": (ROWS, N), "change": (N,),
        "distance": (N,),
        "errors": (ROWS,), "largest": (2 * n,), "tol": (2 * n,),
        **dict.fromkeys(("a_0", "a_1", "way", "u_mid", "u_0"), (n,)), "rate": (max(1, n_c * (1 + d)),),
        **dict.fromkeys((*floats, *integers), (n_c,)),
        **dict.fromkeys(("armed", "band", "f_0", "f_1", "f_in", "rises", "scale"), (E,)),
        "sample": (ROWS, E), "function": (2 * E,), "laws": (n_c, LAW_WIDTH),
        **dict.fromkeys(("x", "y"), (2 * n + 3 * n_c + N_WORKS,)),
    })  # fmt: skip


@functools.cache
def extrapolation_weights() -> np.ndarray:
    """(2, ROWS, ROWS): weights[0, j] of rows 0..j, weights[1, j] of rows 1..j, in the limit of many substeps.

    A value with m substeps is T + c_2 m^-2 + c_3 m^-3 + ...: the weights sum to 1 and make sum_i w_i m_i^-k vanish for
    k = 2, 3, ..., as far as the rows reach: those of Aitken-Neville times m_i / sum_j m_j.
    """
    m = np.arange(1.0, ROWS + 1.0)
    weights = np.array([aitken_neville(first) for first in range(2)]) * m
    total = weights.sum(axis=2, keepdims=True)
    return np.divide(weights, total, out=np.zeros_like(weights), where=total > 0.0)


def aitken_neville(first: int) -> np.ndarray:
    """(ROWS, ROWS): weights[j] of rows first..j, for values D + c_1 m^-1 + c_2 m^-2 + ... of m substeps.

    w_i = prod_(j != i) m_i / (m_i - m_j).
    """
    weights = np.zeros((ROWS, ROWS))
    for last in range(first, ROWS):
        m = np.arange(first + 1.0, last + 2.0)
        for i, m_i in enumerate(m):
            weights[last, first + i] = np.prod(m_i / (m_i - np.delete(m, i)))
    return weights
