"""What an adaptive run carries along: the state that is tried, the table of extrapolation, tolerances, step control."""

from __future__ import annotations

import functools
from typing import NamedTuple

import numpy as np

from nonsmooth.blocks import Cube, Integers, Matrix, Vector, frozen
from nonsmooth.integrators import moreau_jean_contact
from nonsmooth.integrators.records import N_LEDGER, State, state_shapes
from nonsmooth.integrators.rigid_modes import N_WORKS, RigidContacts, contacts_shapes
from nonsmooth.laws import LAW_WIDTH

FIRST_STEP = 1e-4  # of the span
ROWS = 7  # of the table: row j takes j substeps
# clock: the time, the step to try, the shortest step that the time resolves, tolerances
NOW, STEP, LEAST, RTOL, ATOL = range(5)
# counters: refused steps and plain steps, the row of the table at which steps are to converge
REJECTED, SUBSTEPS, TARGET = range(3)
TRIAL_EVENTS = 8  # of the substeps of a row, per contact


class Extrapolation(NamedTuple):
    """Arrays of an adaptive run. n = n_u, c = n_c, N = 2 n + c (1 + d) + N_LEDGER."""

    contacts: RigidContacts
    step: moreau_jean_contact.Scratch
    trial: State
    clock: Vector  # (5,)
    counters: Integers  # (3,)
    weights: Cube  # (2, ROWS, ROWS) of the rows in the extrapolated value, and in the one of an order less
    table: Matrix  # (ROWS, N) changes of coordinates, velocities, impulses, works over the step, row by row
    change: Vector  # (N,) of the accepted step
    errors: Vector  # (ROWS,) estimates of the rows, in tolerances
    largest: Vector  # (2 n,) the largest coordinates and velocities so far
    a_0: Vector  # (n,) accelerations before the step
    a_1: Vector  # (n,) and in the last substep of the row
    tol: Vector  # (2 n,) tolerances of coordinates and velocities
    tol_g: Vector  # (c,) of gaps
    tol_gamma: Vector  # (c,) of their rates
    lid: Vector  # (c,) the gap below which an open contact takes part in this step
    g_0: Vector  # (c,) gaps at the beginning of the step
    gamma_0: Vector  # (c,) their rates
    g_1: Vector  # (c,) and at the end
    gamma_1: Vector  # (c,)
    a_N: Vector  # (c,) the last acceleration of the gaps in smooth motion, 0 after an event
    several: Integers  # (c,) whether the last substep of the row, before the probe, had several solutions
    laws: Matrix  # (c, LAW_WIDTH) laws of a substep
    x: Vector  # (2 n + 3 c + N_WORKS,) a row of the record


@functools.lru_cache(maxsize=64)
def extrapolation_shapes(n: int, n_c: int, d: int) -> tuple:
    """Shapes of ``Extrapolation``."""
    N = 2 * n + n_c * (1 + d) + N_LEDGER
    per_contact = dict.fromkeys(
        ("tol_g", "lid", "g_0", "gamma_0", "g_1", "gamma_1", "a_N", "several", "tol_gamma"), (n_c,)
    )
    return frozen({
        "contacts": contacts_shapes(n, n_c, d), "step": moreau_jean_contact.scratch_shapes(n, n_c, d),
        "trial": state_shapes(n, n_c, d, TRIAL_EVENTS * max(1, n_c)), "clock": (5,), "counters": (3,),
        "weights": (2, ROWS, ROWS), "table": (ROWS, N), "change": (N,), "errors": (ROWS,),
        "largest": (2 * n,), "tol": (2 * n,), "a_0": (n,), "a_1": (n,), **per_contact, "laws": (n_c, LAW_WIDTH),
        "x": (2 * n + 3 * n_c + N_WORKS,),
    })  # fmt: skip


@functools.cache
def extrapolation_weights() -> np.ndarray:
    """(2, ROWS, ROWS): weights[0, j] of rows 0..j, weights[1, j] of rows 1..j, in the limit of many substeps.

    A value with m substeps is T + c_2 m^-2 + c_3 m^-3 + ...: the weights sum to 1 and make sum_i w_i m_i^-k vanish for
    k = 2, 3, ..., as far as the rows reach: w_i = m_i / (sum_j m_j) prod_(j != i) m_i / (m_i - m_j), the weights of
    Aitken-Neville (all powers) times m_i / sum_j m_j.
    """
    weights = np.zeros((2, ROWS, ROWS))
    for which in range(2):
        for last in range(which, ROWS):
            m = np.arange(which + 1.0, last + 2.0)
            for i, m_i in enumerate(m):
                others = np.delete(m, i)
                weights[which, last, which + i] = m_i / m.sum() * np.prod(m_i / (m_i - others))
    return weights
