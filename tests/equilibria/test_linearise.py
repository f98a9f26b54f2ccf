"""The linearised sliding motion: printed matrices and eigenvalues, verdicts, mode shapes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import nonsmooth as ns
from models import BeltOscillator, FollowerForceArm, ModeCoupling, SpragSlip
from nonsmooth.equilibria.linearise import null_space, split_coordinates
from nonsmooth.mechanics.system import FORCE, MASS

# Printed values: corrected equations of the textbook chapter on friction-induced instability; last digits rounded.
SPRAG_SLIP = [
    (SpragSlip.set_1(), 0.489459549014, 1.489459549, 675.731326054, (-1.521534877 + 37.124805254j,)),
    (SpragSlip.set_1(cth=0.5), 0.489459549014, -3.010540451, 675.731326054, (3.075372068 + 37.028479852j,)),
    (SpragSlip(), -6.434826150, 4.782586925, 641.360025451, (10.362024806, -9.618789976)),
]


@pytest.mark.parametrize("rod, M, C, K, eigenvalues", SPRAG_SLIP)
def test_sprag_slip_has_the_printed_inertia_damping_stiffness_and_eigenvalues(rod, M, C, K, eigenvalues):
    small = ns.linearise(rod)
    assert small.kept == (1,)
    assert (small.M[0, 0], small.C[0, 0], small.K[0, 0]) == pytest.approx((M, C, K), abs=6e-10)
    for s in eigenvalues:
        assert np.abs(small.eigenvalues - s).min() < 1e-9
    np.testing.assert_allclose(small.eigenvalues, sorted_like(small, rod.eigenvalues()), rtol=1e-11)
    assert small.inertia[0, 0] == pytest.approx(small.M[0, 0] / (rod.m * rod.I), rel=1e-12)  # p = M+/(m I)


def sorted_like(small, eigenvalues):
    return [min(eigenvalues, key=lambda s: abs(s - own)) for own in small.eigenvalues]


def test_virtual_equilibrium_is_a_sink_of_the_assumed_signs_only():
    rod = SpragSlip()
    small = ns.linearise(rod, ns.equilibrium(rod, guess=[2.7, 0.57], normal=[-1]))
    assert small.eigenvalues[0] == pytest.approx(-0.308037 + 4.503983j, abs=6e-7)
    assert small.verdict == ns.Verdict.STABLE and small.equilibrium.is_virtual
    assert "contradiction" in small.summary()


@pytest.mark.parametrize("model, verdict", [
    (SpragSlip.set_1(), "STABLE"),
    (SpragSlip.set_1(cth=0.5), "NEGATIVE_DAMPING"),
    (SpragSlip(), "NEGATIVE_INERTIA"),
    (FollowerForceArm(P=500.0), "MARGINAL"),
    (FollowerForceArm(P=1000.0), "FLUTTER"),
    (FollowerForceArm(P=2800.0), "DIVERGENCE"),
    (ModeCoupling(mu=0.52), "STABLE"),
    (ModeCoupling(mu=0.53), "FLUTTER"),
    (ModeCoupling(mu=0.49, cx=0.0, cz=0.0), "MARGINAL"),
    (BeltOscillator(vb=0.43), "NEGATIVE_DAMPING"),
    (BeltOscillator(vb=0.45), "STABLE"),
    (BeltOscillator(vb=0.01, m1=20.0), "NEGATIVE_DAMPING"),  # so much that it does not even oscillate
])  # fmt: skip
def test_verdict_names_the_kind_of_instability(model, verdict):
    small = ns.linearise(model)
    assert small.verdict.name == verdict
    assert small.is_unstable == (small.growth > 1e-7)


@pytest.mark.parametrize("P", [500.0, 1000.0, 2800.0])
def test_arm_has_the_printed_matrices_and_eigenvalues(P):
    arm = FollowerForceArm(P=P)
    small, (M, Lp) = ns.linearise(arm), arm.matrices()
    np.testing.assert_allclose(small.M, M, rtol=1e-14)
    np.testing.assert_allclose(small.K, Lp, rtol=2e-14, atol=1e-11)  # P l = 500 to 1400: rounding 1e-13
    assert np.abs(small.C).max() == 0.0
    np.testing.assert_allclose(small.eigenvalues, sorted_like(small, arm.eigenvalues()), rtol=1e-10, atol=1e-10)


def test_frequencies_and_growth_of_the_arm_are_the_printed_ones():
    assert ns.linearise(FollowerForceArm(P=500.0)).frequencies[::2] == pytest.approx(
        [20.676943655, 54.716541708], abs=6e-10
    )
    fast = ns.linearise(FollowerForceArm(P=1000.0)).dominant
    assert (fast.real, fast.imag) == pytest.approx((5.790640885, 33.133658537), abs=6e-10)


def test_mode_coupling_has_the_printed_eigenvalues_and_an_unsymmetric_stiffness():
    model = ModeCoupling(mu=0.6)
    small = ns.linearise(model)
    np.testing.assert_allclose(small.K, model.stiffness_matrix(), rtol=1e-14)
    np.testing.assert_allclose(
        small.eigenvalues[::2], [-1.703256313 + 14.043345425j, 0.538256313 + 14.303524084j], atol=6e-10
    )


@pytest.mark.parametrize("law", ["cubic", "smoothed", "two-coefficient", "stribeck"])
def test_damping_of_the_belt_holds_the_slope_of_the_friction_law(law):
    belt = BeltOscillator(law=law, vb=0.25)
    assert ns.linearise(belt).C[0, 0] == pytest.approx(belt.c + belt.N * belt.slope(), rel=1e-14)
    assert ns.linearise(replace(belt, vb=-0.25)).C[0, 0] == pytest.approx(belt.c + belt.N * belt.slope(), rel=1e-14)


@pytest.mark.parametrize("model", [SpragSlip.set_1(cth=0.5), ModeCoupling(), FollowerForceArm(P=1000.0)])
def test_each_mode_solves_the_equation_of_small_motions(model):
    small = ns.linearise(model)
    for s, y in zip(small.eigenvalues, small.mode_shapes.T, strict=True):
        x = y[list(small.kept)]
        np.testing.assert_allclose(small.Z @ x, y, atol=1e-14)
        terms = s**2 * small.M @ x, s * small.C @ x, small.K @ x
        assert np.abs(sum(terms)).max() < 1e-12 * max(np.abs(term).max() for term in terms)
        assert np.abs(y).max() == pytest.approx(1.0, rel=1e-14)


def test_damping_ratio_of_a_damped_oscillator_is_c_over_twice_its_critical_value():
    belt = BeltOscillator(law="two-coefficient")
    ratio = belt.c / (2 * np.sqrt(belt.k * belt.m))
    assert ns.linearise(belt).damping_ratios == pytest.approx([ratio, ratio], rel=1e-14)


def test_small_motion_of_the_nonlinear_arm_follows_its_dominant_mode():
    from scipy.integrate import solve_ivp

    arm = FollowerForceArm(P=1000.0)
    small, system = ns.linearise(arm), arm.system()
    k = int(np.argmax(small.eigenvalues.real + 1e-9 * small.eigenvalues.imag))
    s, y = small.eigenvalues[k], small.mode_shapes[:, k]

    def rates(t, x):
        a = np.linalg.solve(system.evaluate(MASS, t, x[:2], x[2:]), system.evaluate(FORCE, t, x[:2], x[2:]))
        return np.concatenate([x[2:], a])

    size, t = 1e-7, 0.1
    start = np.concatenate([small.equilibrium.q + size * y.real, size * (s * y).real])
    end = solve_ivp(rates, (0, t), start, method="DOP853", rtol=1e-13, atol=1e-17).y[:2, -1] - small.equilibrium.q
    np.testing.assert_allclose(end, size * (y * np.exp(s * t)).real, atol=1e-5 * size)  # quadratic terms: size itself


def test_negative_inertia_begins_where_the_models_closed_form_says():
    rod = SpragSlip.set_1()
    th = ns.equilibrium(rod).q[1]
    # M+ = 0 at th_eq when mu is critical there, but th_eq moves with mu: shift th0 so that it stays.
    for factor, negative in ((0.999, False), (1.001, True)):
        mu = factor * rod.critical_friction(th)
        moved = replace(rod, mu=mu)
        held = replace(moved, th0=float(rod.th0 + moved.reduced(th).F / moved.kth))
        small = ns.linearise(held)
        assert small.equilibrium.q[1] == pytest.approx(th, abs=1e-12)
        assert (small.verdict == ns.Verdict.NEGATIVE_INERTIA) == negative


def test_reduction_does_not_depend_on_the_coordinates_that_are_kept():
    rng = np.random.default_rng(1)
    n, m = 5, 2
    A = rng.normal(size=(n, n))
    M, C, K = A @ A.T + n * np.eye(n), rng.normal(size=(n, n)), rng.normal(size=(n, n))
    W, R = rng.normal(size=(m, n)), rng.normal(size=(m, n))
    found = []
    for solved in ([0, 1], [2, 4], split_coordinates(W, R)[1]):
        kept = [j for j in range(n) if j not in solved]
        Z, Y = null_space(W, kept, solved), null_space(R, kept, solved)
        np.testing.assert_allclose(W @ Z, 0, atol=1e-12)
        np.testing.assert_allclose(R @ Y, 0, atol=1e-12)
        small = ns.Linearisation(Y.T @ M @ Z, Y.T @ C @ Z, Y.T @ K @ Z, Z, tuple(kept), np.eye(m), None)
        found.append(np.sort_complex(np.round(small.eigenvalues, 9)))
    np.testing.assert_allclose(found[0], found[1], atol=1e-8)
    np.testing.assert_allclose(found[0], found[2], atol=1e-8)


def test_constraints_that_depend_on_one_another_are_refused():
    W = np.array([[1.0, 2.0, 0.0], [2.0, 4.0, 0.0]])
    with pytest.raises(ns.InvalidInput, match="depend on one another"):
        split_coordinates(W, W)


def test_equilibrium_of_another_system_is_refused():
    with pytest.raises(ns.InvalidInput, match="another system"):
        ns.linearise(ModeCoupling(mu=0.5), ns.equilibrium(ModeCoupling(mu=0.6)))
