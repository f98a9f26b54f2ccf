"""What an adaptive run carries along: the state that is tried, the table of extrapolation, tolerances, step control."""

from __future__ import annotations

import functools
from typing import Annotated as Array

import numpy as np

from nonsmooth.integrators.moreau_jean import contact as moreau_jean_contact
from nonsmooth.integrators.records import N_FUNCTIONS, N_LEDGER, N_WORKS, State
from nonsmooth.integrators.rigid.modes import RigidContacts
from nonsmooth.jit.blocks import Block, Floats, Ints
from nonsmooth.mechanics.sys import Sys

THETA = 0.5  # derived: the mid-point rule, whose error has even powers of the step only
NOWHERE = 2.0  # code: a place that is not in the step
FIRST_STEP = 1e-4  # chosen: of the span
N_ROWS = 7  # chosen: of the table: row j takes j substeps
MOST_DERIVATIVES = 3  # chosen: derivatives of the velocities at an end of a step
VELOCITY_DEGREE = 2 * MOST_DERIVATIVES + 2  # derived: of the velocities within a step
# TO_DO: a smooth step; modes are to be decided first; plain steps until there are modes that last
GO_ON, DECIDE, GO_THROUGH = range(3)
TRIAL_EVENTS = 8  # chosen: of the substeps of a row, per contact


class ExtrapolationClock(Block):
    """Times and step sizes [s], and tolerances."""

    now: float
    step: float  # that the error asks for
    least: float  # the shortest step that the time resolves
    rtol: float
    atol: float
    cut: float  # where the next step is to end because an event is there; inf: nowhere
    through: float  # the next step through what has no modes
    way: float  # since the budget was looked at
    looked: float  # the time of that


class ExtrapolationCounters(Block):
    """What the integrator did, and how the step stands."""

    rejected: int  # refused steps
    substeps: int  # and plain steps
    target: int  # the row of the table at which steps are to converge
    is_first: int  # whether the step is the first
    to_do: int  # what is to be done before it: GO_ON, DECIDE, GO_THROUGH
    is_located: int  # whether its end was located
    has_jacobian: int  # whether differences for the Jacobians of the forces were taken at its beginning
    stalls: int  # events in a row without any motion
    tries: int  # since the budget was looked at
    is_seen: int  # whether the rows of the step are near enough to one another to tell where its events are
    ends_series: int  # whether an impact is to end a series of them
    has_forces: int  # whether the accelerations at the beginning of the step are known
    at_jump: int  # whether the forces jump where the next step is to end
    jumps: int  # how often that was seen since the budget was looked at, 1 if before only


class Extrapolation(
    Block,
    N=f"2 * n + n_c * (1 + d) + {N_LEDGER}",
    E=f"{N_FUNCTIONS} * n_c + 1",
    r="max(1, n_c * (1 + d))",
    row=f"2 * n + 3 * n_c + {N_WORKS}",
    nodes=N_ROWS + 1,
    trial_events=f"{TRIAL_EVENTS} * max(1, n_c)",
):
    """Arrays of an adaptive run. n = n_u, c = n_c, N = 2 n + c (1 + d) + N_LEDGER, E = 3 c + 1 event functions."""

    contacts: RigidContacts
    step: moreau_jean_contact.Scratch
    trial: Array[State, "capacity = trial_events"]
    clock: ExtrapolationClock
    counters: ExtrapolationCounters
    is_known: Array[Ints, 2]  # 1 once M and the rows of a held step were evaluated, for those that are constant
    weights: Array[Floats, 2, N_ROWS, N_ROWS]  # of the rows in the extrapolated value, and in one of an order less
    slope_shares: Array[Floats, 5, N_ROWS, N_ROWS]  # weights of the rows in the slopes of the velocities
    slopes: Array[Floats, N_ROWS, 5, "n"]  # of the velocities, row by row
    highest: Array[Floats, 4, 5, 5]  # coefficients of the motion within a step
    ends: Array[Floats, 2, 4]  # derivatives of a velocity at the beginning and at the end
    left: Array[Floats, 5]  # what terms of lower degree leave of it
    B: Array[Floats, VELOCITY_DEGREE, "n"]  # the motion within the step that was tried
    node_q: Array[Floats, "nodes", "n"]  # coordinates between the substeps of the last row
    node_u: Array[Floats, "nodes", "n"]  # velocities before an impact without collision there
    begin_u: Array[Floats, N_ROWS, "n"]  # velocities with which each substep begins, after it
    piece: Array[Floats, 6, "n"]  # of the motion: q, u at its beginning and at its end; those of the next end
    table: Array[Floats, N_ROWS, "N"]  # changes of coordinates, velocities, impulses, works over the step
    change: Array[Floats, "N"]  # of the accepted step
    distance: Array[Floats, "N"]  # of it from the extrapolated value of an order less
    errors: Array[Floats, N_ROWS]  # estimates of the rows, in tolerances
    largest: Array[Floats, "2 * n"]  # the largest coordinates and velocities so far
    a_0: Array[Floats, "n"]  # accelerations before the step
    a_1: Array[Floats, "n"]  # and in the last substep of the row
    force_0: Array[Floats, "n"]  # accelerations of the forces at the beginning of the step
    force_1: Array[Floats, "n"]  # and at its end
    jump: Array[Floats, 4, "n"]  # what they differ by from the motion of the step at places, times H
    way: Array[Floats, "n"]  # what the substeps of a row have moved the coordinates by
    u_mid: Array[Floats, "n"]  # velocities at which the forces of a held step are taken
    rate: Array[Floats, "r"]  # dt (W' u + w') of it
    tol: Array[Floats, "2 * n"]  # tolerances of coordinates and velocities
    tol_g: Array[Floats, "n_c"]  # of gaps
    tol_gamma: Array[Floats, "n_c"]  # of their rates
    tol_slip: Array[Floats, "n_c"]  # of sliding velocities
    lid: Array[Floats, "n_c"]  # the gap below which an open contact takes part in this step
    g_0: Array[Floats, "n_c"]  # gaps at the beginning of the step
    gamma_0: Array[Floats, "n_c"]  # their rates
    g_1: Array[Floats, "n_c"]  # and at the end
    gamma_1: Array[Floats, "n_c"]
    several: Array[Ints, "n_c"]  # whether the last substep of the row, before the probe, had several solutions
    is_loaded: Array[Ints, "n_c"]  # of a given normal force: whether there is one
    heaviest: Array[Floats, "n_c"]  # the largest given normal force so far
    mode: Array[Ints, "n_c"]  # modes that are tried
    slip: Array[Ints, "n_c"]
    has_struck: Array[Ints, "n_c"]  # whether an event of the contact is noted already
    is_stopped: Array[Ints, "n_c"]  # whether its slide has just come to rest
    dropped: Array[Floats, "n_c"]  # how fast it came in whose bounces the jump of an instant leaves out, else 0
    armed: Array[Ints, "E"]  # event functions that have been above their band since the last event
    band: Array[Floats, "E"]  # within which an event function counts as zero
    f_0: Array[Floats, "E"]  # event functions at the beginning of the step
    f_1: Array[Floats, "E"]  # at its end
    f_in: Array[Floats, "E"]  # and within it
    rises: Array[Floats, "E"]  # the place in a step from which on a function is armed
    scale: Array[Floats, "E"]  # what they fall by
    sample: Array[Floats, N_ROWS, "E"]  # in the substeps of the last row
    function: Array[Floats, "2 * E"]  # values and tolerances as rigid/rates.py has them
    system: Sys  # with the laws of a substep
    u_0: Array[Floats, "n"]  # velocities before an event
    x: Array[Floats, "row"]  # a row of the record
    y: Array[Floats, "row"]  # a state within a step


@functools.cache
def extrapolation_weights() -> np.ndarray:
    """(2, N_ROWS, N_ROWS): weights[0, j] of rows 0..j, weights[1, j] of rows 1..j, in the limit of many substeps.

    A value with m substeps is T + c_2 m^-2 + c_3 m^-3 + ...: the weights sum to 1 and make sum_i w_i m_i^-k vanish for
    k = 2, 3, ..., as far as the rows reach: those of Aitken-Neville times m_i / sum_j m_j.
    """
    m = np.arange(1.0, N_ROWS + 1.0)
    weights = np.array([aitken_neville(first) for first in range(2)]) * m
    total = weights.sum(axis=2, keepdims=True)
    return np.divide(weights, total, out=np.zeros_like(weights), where=total > 0.0)


def aitken_neville(first: int) -> np.ndarray:
    """(N_ROWS, N_ROWS): weights[j] of rows first..j, for values D + c_1 m^-1 + c_2 m^-2 + ... of m substeps.

    w_i = prod_(j != i) m_i / (m_i - m_j).
    """
    weights = np.zeros((N_ROWS, N_ROWS))
    for last in range(first, N_ROWS):
        m = np.arange(first + 1.0, last + 2.0)
        for i, m_i in enumerate(m):
            weights[last, first + i] = np.prod(m_i / (m_i - np.delete(m, i)))
    return weights
