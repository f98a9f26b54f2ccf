"""Mode coupling: critical friction, eigenvalues, steady sliding, loss of contact."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from models import ModeCoupling
from nonsmooth.mechanics.system import DAMPING, FORCE, NORMAL_FORCE, POTENTIAL, STIFFNESS

UNDAMPED = ModeCoupling(cx=0.0, cz=0.0)


def test_critical_friction_is_the_printed_one_with_and_without_damping():
    assert UNDAMPED.critical_friction() == 0.5 == ModeCoupling().critical_friction_undamped()
    assert ModeCoupling().critical_friction() == pytest.approx(0.522527017, abs=6e-10)


@pytest.mark.parametrize("mu, w2", [
    (0.0, (129.289322, 270.710678)), (0.6, (200 - 31.622777j, 200 + 31.622777j)),
])  # fmt: skip
def test_squared_frequencies_without_damping_are_the_printed_ones(mu, w2):
    squares = -(replace(UNDAMPED, mu=mu).eigenvalues() ** 2)
    assert all(np.sum(np.abs(squares - w) < 6e-7) == 2 for w in w2)  # each belongs to a pair +/- s


def test_eigenvalues_with_damping_are_the_printed_ones():
    expected = (0.538256313 + 14.303524084j, -1.703256313 + 14.043345425j)
    upper = sorted((s for s in ModeCoupling(mu=0.6).eigenvalues() if s.imag > 0), key=lambda s: -s.real)
    np.testing.assert_allclose(upper, expected, atol=6e-10)


def test_at_the_critical_friction_one_pair_is_undamped_at_the_printed_frequency():
    at = replace(ModeCoupling(), mu=ModeCoupling().critical_friction()).eigenvalues()
    edge = at[np.argmax(at.real)]
    assert edge.real == pytest.approx(0.0, abs=1e-12)
    assert abs(edge.imag) == pytest.approx(14.390328, abs=6e-7)


def test_unequal_damping_destabilises():
    a, b = replace(UNDAMPED, cx=0.2, cz=4.0), replace(UNDAMPED, cx=1.33, cz=1.33)
    assert a.critical_friction() < 0.5 < b.critical_friction()


@pytest.mark.parametrize("model", [ModeCoupling(), ModeCoupling(vb=-10.0), ModeCoupling(R=400.0)])
def test_steady_sliding_balances_the_forces(model):
    q, u = model.equilibrium(), np.zeros(2)
    system = model.system()
    h, N = system.evaluate(FORCE, 0.0, q, u), system.evaluate(NORMAL_FORCE, 0.0, q, u)
    friction = model.mu * N[0] * np.sign(model.vb)
    np.testing.assert_allclose(h + [friction, 0.0], 0.0, atol=1e-12 * model.R)
    assert N[0] == pytest.approx(model.normal_force_at_equilibrium()) and N[0] > 0


def test_depth_of_the_contact_grows_with_the_load_as_printed():
    assert ModeCoupling(mu=0.6, R=1.0).equilibrium()[1] == pytest.approx(-0.003658537, abs=6e-10)


def test_contact_is_lost_below_the_printed_load():
    assert ModeCoupling(mu=0.6).lift_off_load(1.460413) == pytest.approx(399.1795, abs=2e-4)
    q = np.array([0.1, 0.01])
    assert ModeCoupling().system().evaluate(NORMAL_FORCE, 0.0, q, np.zeros(2)) == [0.0]


@pytest.mark.parametrize("z", [-0.7, 0.3])
def test_jacobians_and_potential_belong_to_the_force_in_contact_and_apart(z):
    system = ModeCoupling().system()
    q, u, h = np.array([0.4, z]), np.array([0.3, -0.2]), 1e-6

    def force(dq, du):
        return system.evaluate(FORCE, 0.0, q + dq, u + du)

    zero = np.zeros(2)
    K = np.column_stack([(force(-h * e, zero) - force(h * e, zero)) / (2 * h) for e in np.eye(2)])
    C = np.column_stack([(force(zero, -h * e) - force(zero, h * e)) / (2 * h) for e in np.eye(2)])
    np.testing.assert_allclose(system.evaluate(STIFFNESS, 0.0, q, u), K, atol=1e-6)  # rounding 1e3 eps / h
    np.testing.assert_allclose(system.evaluate(DAMPING, 0.0, q, u), C, atol=1e-6)
    V = [(system.evaluate(POTENTIAL, 0.0, q + h * e, u) - system.evaluate(POTENTIAL, 0.0, q - h * e, u))[0]
         for e in np.eye(2)]  # fmt: skip
    np.testing.assert_allclose(force(zero, -u), -np.array(V) / (2 * h), atol=1e-6)


def test_belt_that_runs_the_other_way_never_flutters():
    growth = [ModeCoupling(vb=-10.0, mu=mu).eigenvalues().real.max() for mu in (0.3, 0.6, 1.2)]
    assert max(growth) < 0
