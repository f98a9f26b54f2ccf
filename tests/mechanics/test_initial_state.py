"""``project=True`` moves an inadmissible start to the nearest admissible one in the mass metric."""

import itertools
import math
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.mechanics.compiled import model_of
from nonsmooth.mechanics.initial_state import ContactsByCode, contact_state

STEP = ns.MoreauJean(dt=1e-6)


class P(NamedTuple):
    m: float = 2.0  # mass [kg]
    I: float = 0.3  # inertia [kg m^2]
    rise: float = 0.0  # speed of the floor [m/s]


ARMS = np.array([-0.5, 0.2, 0.6])  # feet of a table, from its centre [m]


def mass(t, q, p, M):
    M[0, 0] = p.m
    M[1, 1] = p.I


def force(t, q, u, p, h):
    h[0] = 0.0


def gap(t, q, p, g_N):
    g_N[0] = q[0] - 0.5 * q[1] - p.rise * t
    g_N[1] = q[0] + 0.2 * q[1] - p.rise * t
    g_N[2] = q[0] + 0.6 * q[1] - p.rise * t


def normal(t, q, p, W_N):
    W_N[0, 0] = W_N[1, 0] = W_N[2, 0] = 1.0
    W_N[0, 1] = -0.5
    W_N[1, 1] = 0.2
    W_N[2, 1] = 0.6


def gap_rate(t, q, p, w_N):
    w_N[0] = w_N[1] = w_N[2] = -p.rise


def table(**parameters):
    """A beam on three feet: q = (height, tilt), linear gaps."""
    return ns.System(
        n_q=2, mass=mass, force=force, gap=gap, normal=normal, gap_rate=gap_rate, contacts=[ns.Contact()] * 3,
        parameters=P(**parameters),
    )  # fmt: skip


def nearest(M, x, W, bound):
    """argmin |y - x|_M with W y >= bound: the best feasible point over all sets of active rows."""
    best, least = x, math.inf
    for k in range(3):
        for rows in map(list, itertools.combinations(range(len(W)), k)):
            W_a = W[rows]
            shift = np.linalg.solve(M, W_a.T @ np.linalg.solve(W_a @ np.linalg.solve(M, W_a.T), bound[rows] - W_a @ x))
            if (W @ (x + shift) >= bound - 1e-12).all() and shift @ M @ shift < least:
                best, least = x + shift, shift @ M @ shift
    return best


M, W = np.diag([2.0, 0.3]), np.column_stack([np.ones(3), ARMS])


@pytest.mark.parametrize("seed", range(8))
def test_velocity_moves_to_the_nearest_at_which_no_closed_contact_approaches(seed):
    u0, rise = np.random.default_rng(seed).standard_normal(2), 0.1 * seed
    solution = ns.simulate(table(rise=rise), (0, 1e-6), [0.0, 0.0], u0, integrator=STEP, project=True)
    assert np.allclose(solution.u[0], nearest(M, u0, W, np.full(3, rise)), atol=1e-12)


def test_a_landing_is_no_inconsistent_start_but_an_impact_of_the_first_step():
    solution = ns.simulate(table(), (0, 1e-6), [0.0, 0.0], [-1.0, 0.0], integrator=STEP)
    assert solution.u[0].tolist() == [-1.0, 0.0] and np.allclose(solution.u[1], 0.0, atol=1e-15)
    assert {event.kind for event in solution.events} == {ns.EventKind.IMPACT}


def test_an_admissible_start_is_not_moved_by_a_bit():
    q0, u0 = np.array([0.3, 0.1]), np.array([-0.7, 0.2])
    solution = ns.simulate(table(), (0, 1e-6), q0, u0, integrator=STEP, project=True)
    assert (solution.q[0] == q0).all() and (solution.u[0] == u0).all()


def test_contacts_that_exclude_each_other_are_refused_in_one_sentence():
    def between(t, q, p, g_N):
        g_N[0] = q[0] - 0.1
        g_N[1] = -0.1 - q[0]

    def rows(t, q, p, W_N):
        W_N[0, 0] = 1.0
        W_N[1, 0] = -1.0

    squeezed = ns.System(
        n_q=2, mass=mass, force=force, gap=between, normal=rows, contacts=[ns.Contact()] * 2, parameters=P()
    )
    with pytest.raises(ns.InvalidInput, match="no admissible state is near the initial one"):
        ns.simulate(squeezed, (0, 1e-6), [0.0, 0.0], [0.0, 0.0], integrator=STEP, project=True)


@pytest.mark.parametrize("seed", range(6))
def test_penetrating_feet_are_moved_out_by_the_least_motion(seed):
    rng = np.random.default_rng(seed)
    q0 = np.array([-0.05, 0.1]) * rng.uniform(0.5, 1.5, 2) * [1, rng.choice([-1, 1])]
    with pytest.warns(ns.InitialStateWarning, match="penetrates by"):
        ns.simulate(table(), (0, 1e-6), q0, [0.0, 0.0], integrator=STEP)
    solution = ns.simulate(table(), (0, 1e-6), q0, [0.0, 0.0], integrator=STEP, project=True)
    assert np.allclose(solution.q[0], nearest(M, q0, W, np.zeros(3)), atol=1e-12)
    assert (W @ solution.q[0] >= -1e-15).all()


ROWS = np.array([[0.3, -1.2, 0.7], [-0.4, 0.5, 1.1]])
LIFTS, BELTS = np.array([0.25, -0.75]), np.array([1.5, -2.5])  # [m/s]


def two_on_belts():
    """Two contacts of three coordinates, on floors that rise and belts that run."""

    def mass(t, q, p, M):
        for k in range(3):
            M[k, k] = 1.0

    def gap(t, q, p, g_N):
        g_N[0] = 0.3 * q[0] - 1.2 * q[1] + 0.7 * q[2] + 0.25 * t
        g_N[1] = -0.4 * q[0] + 0.5 * q[1] + 1.1 * q[2] - 0.75 * t

    def tangent(t, q, p, W_F):
        for k in range(3):
            W_F[0, 0, k] = 0.5 * (k - 1.0)
            W_F[1, 0, k] = 1.0 / (1.0 + k)

    def surface_velocity(t, q, p, w_F):
        w_F[0, 0], w_F[1, 0] = 1.5, -2.5

    contacts = [ns.Contact(mu=0.3), ns.Contact(mu=0.3)]
    return ns.System(n_q=3, mass=mass, force=still, gap=gap, tangent=tangent, surface_velocity=surface_velocity,
                     contacts=contacts)  # fmt: skip


def still(t, q, u, p, h):
    h[0] = 0.0


def test_velocities_of_contacts_are_those_of_their_rows_floors_and_belts():
    """By machine code and by the functions: gamma_N = W_N u + w_N, gamma_F = W_F u + w_F."""
    system, q, u = two_on_belts(), np.array([0.2, -0.1, 0.4]), np.array([1.0, -2.0, 0.5])
    tangents = np.array([[-0.5, 0.0, 0.5], [1.0, 1.0 / 2.0, 1.0 / 3.0]])
    expected = ROWS @ q, ROWS @ u + LIFTS, tangents @ u + BELTS
    by_code = ContactsByCode(system, model_of(system), q, u, system.p)
    for found in (contact_state(system, 0.0, q, u), by_code.columns(0.0)):
        for column, right in zip(found, expected, strict=True):
            np.testing.assert_allclose(column, right, rtol=0, atol=1e-14 * 8)  # sums of four products of up to 3
