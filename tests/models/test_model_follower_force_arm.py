"""Two-link arm under a follower force: critical loads, frequencies, growth, nonlinear motion, energy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from models import FollowerForceArm
from nonsmooth.mechanics.system import FORCE, MASS

# Printed values: corrected equations of the textbook chapter, two-link manipulator; the last digit is rounded.
P_CR, P_UPPER = 948.126555160, 2698.363351


def motion(arm, t_end, phi1, times=None):
    """States (4, n) of the motion from rest, by an eighth-order Runge-Kutta method on the model's own functions."""
    system = arm.system()

    def rates(t, x):
        q, u = x[:2], x[2:]
        return np.concatenate([u, np.linalg.solve(system.evaluate(MASS, t, q, u), system.evaluate(FORCE, t, q, u))])

    start = np.concatenate(arm.state(phi1))
    return solve_ivp(rates, (0, t_end), start, method="DOP853", rtol=1e-12, atol=1e-14, t_eval=times).y


def test_arm_flutters_between_the_printed_loads():
    first, second = FollowerForceArm().critical_loads()
    assert first == pytest.approx(P_CR, abs=6e-10)
    assert second == pytest.approx(P_UPPER, abs=6e-7)


def test_squared_frequencies_meet_at_the_critical_load():
    squares = np.roots(FollowerForceArm(P=P_CR).characteristic())
    assert squares.mean().real == pytest.approx(1131.370850, abs=6e-7)
    assert abs(squares[0] - squares[1]) < 0.01  # P_cr is printed to 5e-13 of itself; the split is the root of that


def test_frequencies_below_and_growth_above_the_critical_load_are_the_printed_ones():
    below = np.sort(FollowerForceArm(P=500.0).eigenvalues().imag)[2:]
    assert below == pytest.approx([20.676943655, 54.716541708], abs=6e-10)
    above = FollowerForceArm(P=1000.0).eigenvalues()
    fastest = above[np.argmax(above.real + 1e-9 * above.imag)]
    assert (fastest.real, fastest.imag) == pytest.approx((5.790640885, 33.133658537), abs=6e-10)


def test_beyond_the_second_load_the_squared_frequencies_are_real_and_negative():
    squares = np.roots(FollowerForceArm(P=P_UPPER + 1.0).characteristic())
    assert np.isreal(squares).all() and (squares < 0).all()


def test_linearised_motion_is_that_of_the_printed_matrices():
    arm = FollowerForceArm(P=1000.0)
    M, Lp = arm.matrices()
    squares = np.linalg.eigvals(np.linalg.solve(M, -Lp)).astype(complex)
    both = np.concatenate([np.sqrt(squares), -np.sqrt(squares)])
    np.testing.assert_allclose(np.sort_complex(both), np.sort_complex(arm.eigenvalues()), rtol=1e-12)
    assert np.linalg.det(Lp) == pytest.approx(arm.k1 * arm.k2)  # no static loss of stability


@pytest.mark.parametrize("P, t, phi1, expected", [
    (500.0, 1.0, 0.05, (-0.021525545, 0.013952941, 2.625585437, -4.058975616)),
    (1000.0, 0.5, 0.01, (0.128952859, -0.240257355, 8.535722285, -13.650474257)),
    (1000.0, 1.0, 0.01, (0.384635644, -0.636994466, 6.667450408, -5.10260154)),
])  # fmt: skip
def test_nonlinear_motion_reaches_the_printed_states(P, t, phi1, expected):
    arm = FollowerForceArm(P=P)
    end = motion(arm, t, phi1)[:, -1] - np.concatenate([arm.equilibrium(), np.zeros(2)])
    np.testing.assert_allclose(end, expected, atol=2e-9 * max(1.0, np.abs(expected).max()))


def test_motion_below_the_critical_load_stays_within_the_printed_bounds():
    arm = FollowerForceArm(P=500.0)
    phi = motion(arm, 3.0, 0.05)[:2] - arm.equilibrium()[:, None]
    assert np.abs(phi).max(axis=1) == pytest.approx([0.0558, 0.1140], rel=5e-3)


def test_energy_changes_by_the_work_of_the_follower_force():
    arm = FollowerForceArm(P=1000.0)
    t, weights = np.polynomial.legendre.leggauss(60)  # the motion has about three oscillations: exact to rounding
    start, *nodes, end = motion(arm, 0.5, 0.01, times=[0.0, *(0.25 * (1 + t)), 0.5]).T
    work = 0.25 * sum(w * arm.power(x[:2], x[2:]) for w, x in zip(weights, nodes, strict=True))
    assert arm.energy(end[:2], end[2:]) - arm.energy(start[:2], start[2:]) == pytest.approx(
        work, rel=1e-7
    )  # of the dense output
    assert abs(work) > 1.0


def test_arm_has_no_contact_and_no_contact_problem_is_solved():
    arm = FollowerForceArm(P=500.0)
    run = ns.simulate(arm, (0, 0.05), *arm.state(), integrator=ns.MoreauJean(dt=1e-4))
    assert arm.system().n_c == 0
    assert run.stats.lcp_solved == 0 and run.stats.lcp_skipped == run.stats.steps == 500


def test_without_load_the_arm_rests_with_its_springs():
    assert FollowerForceArm(P=0.0).equilibrium() == pytest.approx([0.0, np.pi / 6], abs=1e-16)
