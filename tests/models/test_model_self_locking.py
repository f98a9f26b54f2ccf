"""Self-locking rod: normal force, jamming angle, no solution beyond it."""

from __future__ import annotations

import numpy as np
import pytest

from models import SelfLockingRod


@pytest.mark.parametrize("degrees, ratio", [(10, 1.214074), (20, 1.572253), (30, 2.366025), (44, 29.144981)])
def test_normal_force_grows_towards_the_jamming_angle(degrees, ratio):
    rod = SelfLockingRod(mu=1.0, R=2.5, th0=np.radians(degrees))
    assert rod.normal_force() / rod.R == pytest.approx(ratio, abs=6e-7)


@pytest.mark.parametrize("mu, degrees", [(0.3, 73.300756), (0.5, 63.434949), (1.0, 45.0), (1.3, 37.568592)])
def test_jamming_angle_is_the_printed_one(mu, degrees):
    assert np.degrees(SelfLockingRod(mu=mu).jam_angle()) == pytest.approx(degrees, abs=6e-7)


@pytest.mark.parametrize("vb", [0.7, -0.7])
@pytest.mark.parametrize("inertia", [0.1, 5.0])
def test_contact_rows_give_the_normal_force_whatever_the_inertia(contact_problem, vb, inertia):
    rod = SelfLockingRod(vb=vb, mu=0.8, l=1.7, R=3.0, I=inertia, th0=0.6)
    _, G, b = contact_problem(rod, *rod.state(th=rod.th0))
    p = G[0, 0] + np.sign(vb) * rod.mu * G[0, 1]  # gamma_F = -vb
    assert -b[0] / p == pytest.approx(rod.normal_force(), rel=1e-13)
    assert rod.normal_force() == pytest.approx(rod.R / (1 - np.sign(vb) * rod.mu * np.tan(0.6)), rel=1e-14)


def test_beyond_the_jamming_angle_neither_sliding_nor_sticking_nor_parting_is_possible(contact_problem):
    rod = SelfLockingRod(mu=1.0, th0=np.radians(50))
    assert rod.jams() and rod.normal_force() is None
    _, G, b = contact_problem(rod, *rod.state(th=rod.th0))
    assert b[0] < 0  # it cannot part
    assert G[0, 0] + rod.mu * G[0, 1] < 0  # sliding would need a negative normal force
    assert np.linalg.matrix_rank(G) == 1  # the tip cannot take up the velocity of the plane


def test_a_plane_that_moves_away_does_not_jam():
    rod = SelfLockingRod(mu=1.0, th0=np.radians(80), vb=-1.0)
    assert not rod.jams()
    assert rod.normal_force() == pytest.approx(1 / (1 + np.tan(np.radians(80))), rel=1e-13)
