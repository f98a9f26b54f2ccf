"""Beads in a line: the cascade of impacts, one by one."""

from __future__ import annotations

import numpy as np
import pytest

from models import BeadChain
from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.system import GAP


def test_cascade_of_a_hundred_beads_has_the_printed_energy_and_momentum():
    chain = BeadChain(n=100, e=0.9)
    q, u = chain.exact(t=2.0, velocity=1.0)
    assert u.sum() == pytest.approx(1.0, abs=1e-13)
    assert 0.5 * (u**2).sum() == pytest.approx(0.0080414, abs=6e-8)
    assert chain.system().evaluate(GAP, 0.0, q, u).min() > -1e-15
    assert u[-1] == 0.0  # the wave has not reached the wall


def test_elastic_beads_hand_the_velocity_on():
    chain = BeadChain(n=5, e=1.0)
    q, u = chain.exact(t=3.5e-3, velocity=1.0)
    np.testing.assert_allclose(u, [0, 0, 0, 1, 0], atol=1e-15)
    np.testing.assert_allclose(q, np.array([1, 1, 1, 0.5, 0]) * 1e-3, atol=1e-15)


def test_last_bead_bounces_off_the_wall():
    chain = BeadChain(n=1, e=0.5)
    q, u = chain.exact(t=3e-3, velocity=1.0)
    assert (q[0], u[0]) == pytest.approx((0.0, -0.5), abs=1e-15)


def test_gaps_close_to_the_right_of_each_bead():
    chain = BeadChain(n=3, gap=0.1)
    g_N = chain.system().evaluate(GAP, 0.0, np.array([0.01, 0.03, 0.06]), np.zeros(3))
    np.testing.assert_allclose(g_N, [0.12, 0.13, 0.04])


def test_accumulating_impacts_are_reported():
    with pytest.raises(InvalidInput, match="accumulate"):
        BeadChain(n=20, e=0.05).exact(t=20.0, most=2000)


def test_number_of_beads_sets_the_size_of_the_system():
    system = BeadChain(n=7).system()
    assert system.n_q == system.n_c == 7
    assert BeadChain(n=2).coordinates == (("x_0", "m"), ("x_1", "m"))
