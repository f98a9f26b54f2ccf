"""Sprag-slip rod: reduced equation, equilibria, eigenvalues, regions, seizure."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from models import SpragSlip
from models.sprag_slip import SOLUTIONS

SET_2 = SpragSlip()


@pytest.mark.parametrize("cth, C, eigenvalue", [
    (5.0, 1.489459549, -1.521534877 + 37.124805254j),
    (0.5, -3.010540451, 3.075372068 + 37.028479852j),
])  # fmt: skip
def test_equilibrium_of_set_1_is_a_focus(cth, C, eigenvalue):
    rod = SpragSlip.set_1(cth=cth)
    th = rod.equilibrium()
    assert th == pytest.approx(0.828053558508, abs=6e-13)
    r = rod.reduced(th)
    assert (r.M, r.C, r.K) == pytest.approx((0.489459549014, C, 675.731326054), abs=6e-10)
    values = sorted(rod.eigenvalues(), key=lambda s: s.imag)
    np.testing.assert_allclose(values, [np.conj(eigenvalue), eigenvalue], atol=1e-8)
    assert rod.normal_forces(th, 0.0) == pytest.approx((37.830818394,), abs=6e-10)


def test_equilibrium_of_set_2_is_a_saddle_in_A1():
    th = SET_2.equilibrium()
    assert th == pytest.approx(0.849626709900, abs=6e-13)
    r = SET_2.reduced(th)
    assert (r.M, r.C, r.K) == pytest.approx((-6.434826150, 4.782586925, 641.360025451), abs=6e-10)
    np.testing.assert_allclose(np.sort(SET_2.eigenvalues().real), [-9.618789976, 10.362024806], atol=1e-8)
    assert SET_2.region(th, 0.0) == 1
    N = SET_2.ky * SET_2.l * np.sin(th) + SET_2.R
    assert N == pytest.approx(38.551699381, abs=6e-10)
    assert SET_2.Lambda(th, 0.0) / r.M == pytest.approx(N, rel=1e-11)


def test_virtual_equilibrium_of_set_2_is_a_spiral_sink_in_A0():
    th = SET_2.equilibrium(branch=-1, near=0.57)
    assert th == pytest.approx(0.572612565, abs=6e-10)
    value = SET_2.eigenvalues(branch=-1, th=th)
    np.testing.assert_allclose(sorted(value.imag), [-4.503983, 4.503983], atol=6e-7)
    np.testing.assert_allclose(value.real, -0.308037, atol=6e-7)
    assert SET_2.region(th, 0.0) == 0
    assert SET_2.normal_forces(th, 0.0)[0] > 0


@pytest.mark.parametrize("rod, th", [(SpragSlip.set_1(), 0.827428104), (SET_2, 0.848190459)])
def test_one_newton_step_from_the_rest_angle(rod, th):
    r = rod.reduced(rod.th0)
    assert rod.th0 - r.F / r.K == pytest.approx(th, abs=6e-10)


def test_stiffness_is_the_derivative_of_F():
    for branch in (1, -1):
        slope = (SET_2.reduced(0.9 + 1e-6, branch).F - SET_2.reduced(0.9 - 1e-6, branch).F) / 2e-6
        assert SET_2.reduced(0.9, branch).K == pytest.approx(slope, rel=1e-8)


@pytest.mark.parametrize("rod, angles", [
    (SpragSlip.set_1(), (0.850692310, 1.414842293)),
    (SET_2, (0.720658419, 1.505833534)),
])  # fmt: skip
def test_effective_inertia_vanishes_at_the_printed_angles(rod, angles):
    assert rod.paradoxical_angles() == pytest.approx(angles, abs=6e-10)
    for th in rod.paradoxical_angles():
        assert rod.reduced(th).M == pytest.approx(0.0, abs=1e-12)
        assert rod.critical_friction(th) == pytest.approx(rod.mu, rel=1e-12)
    assert rod.reduced(np.mean(angles)).M < 0


def test_there_are_no_paradoxical_angles_at_little_friction():
    assert SpragSlip(mu=0.3).paradoxical_angles() is None


@pytest.mark.parametrize("rod, inertia, damping", [
    (SpragSlip.set_1(5.0), 1.239300, 1.319592),
    (SpragSlip.set_1(0.5), 1.239300, 0.958278),
    (SET_2, 1.040469, None),
])  # fmt: skip
def test_critical_frictions_at_the_equilibrium(rod, inertia, damping):
    th = rod.equilibrium()
    assert rod.critical_friction(th) == pytest.approx(inertia, abs=6e-7)
    if damping is not None:
        assert rod.damping_friction(th) == pytest.approx(damping, abs=6e-7)


@pytest.mark.parametrize("th, stick, rates", [
    (0.73, 2.99908692, (-5.90440381, 3.66956101)),
    (0.75, 2.93410545, (-5.16977147, 3.02291917)),
    (0.78, 2.84381989, (-3.91369798, 1.89198792)),
    (0.80, 2.78801564, (-2.81053350, 0.86810430)),
])  # fmt: skip
def test_boundaries_of_the_regions_of_set_2(th, stick, rates):
    assert SET_2.stick_rate(th) == pytest.approx(stick, abs=6e-9)
    assert SET_2.zero_force_rates(th) == pytest.approx(rates, abs=6e-9)
    for thdot in SET_2.zero_force_rates(th):
        assert SET_2.Lambda(th, thdot) == pytest.approx(0.0, abs=1e-10)


def test_boundaries_meet_and_end_where_they_are_printed_to():
    th = brentq(lambda th: SET_2.Lambda(th, SET_2.stick_rate(th)), 0.72, 0.8, xtol=1e-15)
    assert (th, SET_2.stick_rate(th)) == pytest.approx((0.752865415, 2.925120353), abs=1e-9)
    apex = 0.814381459
    assert SET_2.zero_force_rates(apex + 1e-9) is None
    low, high = SET_2.zero_force_rates(apex - 1e-9)
    assert 0.5 * (low + high) == pytest.approx(-0.943650815, abs=6e-9)


@pytest.mark.parametrize("th, thdot, region", [
    (0.60, 0, 0), (0.85, 0, 1), (0.90, 2, 1), (0.80, 3.5, 2), (1.0, 4, 2), (0.78, 1, 3), (0.73, 3.3, 4),
])  # fmt: skip
def test_starts_lie_in_the_printed_regions(th, thdot, region):
    assert SET_2.region(th, thdot) == region
    assert len(SET_2.normal_forces(th, thdot)) == SOLUTIONS[region]


@pytest.mark.parametrize("th, thdot, forces", [
    (0.85, 0.0, (-4.315375307, 38.80895774)),
    (0.90, 2.0, (-13.7744419, 90.89698531)),
    (0.73, 3.3, (-169.1341771, 1.416322438)),
])  # fmt: skip
def test_two_solutions_are_the_printed_ones(th, thdot, forces):
    assert SET_2.normal_forces(th, thdot) == pytest.approx(forces, abs=6e-8)


def test_contact_rows_give_the_reduced_equation_and_its_numbers_of_solutions(contact_problem, bilateral_solutions):
    rng = np.random.default_rng(3)
    counts = set()
    for _ in range(300):
        th, thdot = rng.uniform(0.6, 1.5), rng.uniform(-6, 6)
        q0, u0 = SET_2.state(th, thdot)
        W, G, b = contact_problem(SET_2, q0, u0)
        v_t = SET_2.v_t(th, thdot)
        for branch in (1, -1):  # p = M/(m I), b = -Lambda/(m I)
            M = SET_2.reduced(th, branch).M
            assert G[0, 0] + branch * SET_2.mu * G[0, 1] == pytest.approx(M / (SET_2.m * SET_2.I), abs=1e-12)
        assert b[0] == pytest.approx(-SET_2.Lambda(th, thdot) / (SET_2.m * SET_2.I), rel=1e-11, abs=1e-9)
        found = bilateral_solutions(G, b, SET_2.mu, -v_t)
        assert len(found) == SOLUTIONS[SET_2.region(th, thdot)]
        counts.add(int(SET_2.region(th, thdot)))
        np.testing.assert_allclose([la_N for la_N, _ in found], SET_2.normal_forces(th, thdot), rtol=1e-9)
        for la_N, la_F in found:
            h = np.array([
                -SET_2.cy * u0[0] - SET_2.ky * q0[0] - SET_2.R,
                -SET_2.cth * thdot - SET_2.kth * (th - SET_2.th0) + SET_2.R * SET_2.l * np.cos(th),
            ])  # fmt: skip
            acceleration = (h + W.T @ [la_N, la_F]) / [SET_2.m, SET_2.I]
            expected = SET_2.angular_acceleration(th, thdot, la_N)
            assert acceleration[1] == pytest.approx(expected, rel=1e-9, abs=1e-8)
    assert counts == {0, 1, 2, 3, 4}


def test_stick_forces_carry_the_tip_with_the_belt(contact_problem):
    th = 0.95
    q0, u0 = SET_2.state(th, SET_2.stick_rate(th))
    _, G, b = contact_problem(SET_2, q0, u0)
    np.testing.assert_allclose(G @ SET_2.stick_forces(th) + b, 0.0, atol=1e-10 * np.abs(b).max())


def test_stick_of_the_attracting_orbit_ends_where_it_is_printed_to():
    def margin(th):
        la_N, la_F = SET_2.stick_forces(th)
        return abs(la_F) - SET_2.mu * abs(la_N)

    assert brentq(margin, 0.94, 0.99, xtol=1e-14) == pytest.approx(0.966466904, abs=6e-10)


def test_seizures_jump_as_printed():
    jump = SET_2.seizure(0.78, 1.0)
    assert (jump.thdot, jump.P_N) == pytest.approx((2.843819889, 13.107965209), abs=6e-10)
    jump = SET_2.seizure(0.807078634, -2.258755703)
    assert jump == pytest.approx((2.769048317, 34.772865558, 38.865743710), abs=2e-7)
    q0, u0 = SET_2.state(0.78, 1.0)
    _, u1 = SET_2.state(0.78, SET_2.seizure(0.78, 1.0).thdot)
    assert SET_2.m * (u1[0] - u0[0]) == pytest.approx(SET_2.seizure(0.78, 1.0).P_N, rel=1e-14)


def test_regions_of_arrays_are_those_of_their_entries():
    th, thdot = np.linspace(0.6, 1.5, 7)[:, None], np.linspace(-5, 5, 6)[None, :]
    grid = SET_2.region(th, thdot)
    assert grid.shape == (7, 6)
    assert grid[3, 2] == SET_2.region(float(th[3, 0]), float(thdot[0, 2]))
