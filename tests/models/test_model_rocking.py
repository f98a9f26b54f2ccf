"""Rocking block: Housner's closed forms against the contact rows and the pendulum equation."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from models import RockingBlock
from nonsmooth.mechanics.system import GAP, NORMAL, TANGENT


@pytest.mark.parametrize("tilt", [0.1, -0.2])
def test_tilted_block_turns_about_the_corner_on_the_ground(tilt):
    block = RockingBlock()
    system = block.system()
    q0, u0 = block.state(tilt=tilt, tilt_rate=0.7)
    pivot = 0 if tilt > 0 else 1
    g_N = system.evaluate(GAP, 0.0, q0, u0)
    assert g_N[pivot] == pytest.approx(0.0, abs=1e-15)
    assert g_N[1 - pivot] == pytest.approx(block.width * math.sin(abs(tilt)), rel=1e-13)
    assert system.evaluate(NORMAL, 0.0, q0, u0)[pivot] @ u0 == pytest.approx(0.0, abs=1e-15)
    assert system.evaluate(TANGENT, 0.0, q0, u0)[pivot, 0] @ u0 == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("tilt, tilt_rate, pivot", [(0.0, 0.0, 0), (0.0, 0.5, 0), (0.0, -0.5, 1)])
def test_upright_block_stands_on_both_corners(tilt, tilt_rate, pivot):
    block = RockingBlock()
    q0, u0 = block.state(tilt, tilt_rate)
    np.testing.assert_allclose(block.system().evaluate(GAP, 0.0, q0, u0), 0.0, atol=1e-16)
    rates = block.system().evaluate(NORMAL, 0.0, q0, u0) @ u0
    assert rates[pivot] == pytest.approx(0.0, abs=1e-16) and rates[1 - pivot] >= 0.0
    assert q0[0] == pytest.approx(0.0, abs=1e-16)


def pivot_acceleration(block, th):
    """th'' about the left corner, th > 0."""
    r = block.half_diagonal()
    return -block.m * block.g * r * math.sin(block.critical_tilt() - th) / (block.inertia() + block.m * r * r)


def test_contact_rows_give_the_rotation_about_the_corner(contact_problem):
    block = RockingBlock()
    for tilt, rate in ((0.1, 0.0), (0.2, -1.2)):
        q0, u0 = block.state(tilt, rate)
        W, G, b = contact_problem(block, q0, u0)
        force = -np.linalg.solve(G[:2, :2], b[:2])  # contact 0 sticks
        thddot = W[:2, 2] @ force / block.inertia()
        assert thddot == pytest.approx(pivot_acceleration(block, tilt), rel=1e-12)
        assert abs(force[1]) <= block.mu * force[0]


def test_fall_time_agrees_with_the_integrated_rotation():
    block = RockingBlock()

    def upright(t, y):
        return y[0]

    upright.terminal = True
    fall = solve_ivp(
        lambda t, y: [y[1], pivot_acceleration(block, y[0])], (0, 5), [0.1, 0.0],
        method="DOP853", rtol=1e-12, atol=1e-14, events=upright,
    )  # fmt: skip
    assert block.fall_time(0.1) == pytest.approx(fall.t_events[0][0], rel=1e-10)


def test_landing_corner_multiplies_the_rate_by_the_ratio(contact_problem):
    block = RockingBlock()
    q0, u0 = block.state(0.0, 1.0)
    u0[:] *= -1.0  # turning about the left corner, the right one coming down
    W, _, _ = contact_problem(block, q0, u0)
    M = np.diag([block.m, block.m, block.inertia()])
    right = W[2:]
    P = -np.linalg.solve(right @ np.linalg.solve(M, right.T), right @ u0)
    u1 = u0 + np.linalg.solve(M, right.T @ P)
    assert u1[2] / u0[2] == pytest.approx(block.rate_ratio(), rel=1e-13)
    assert (W[0] @ u1) > 0  # the left corner leaves the ground
    assert abs(P[1]) <= block.mu * P[0]


def test_next_tilt_has_the_energy_that_the_impact_leaves():
    block = RockingBlock()
    after = block.next_tilt(0.1)
    alpha = block.critical_tilt()
    energy = [math.cos(alpha - th) - math.cos(alpha) for th in (0.1, after)]
    assert energy[1] == pytest.approx(block.rate_ratio() ** 2 * energy[0], rel=1e-12)
    assert 0 < after < 0.1


def test_squat_block_does_not_rock():
    block = RockingBlock(width=1.0, height=0.5)
    assert block.rate_ratio() < 0
    assert block.next_tilt(0.1) == pytest.approx(0.0, abs=1e-15)
