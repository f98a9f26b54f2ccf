"""Slider-crank with clearance: its equations against Lagrange's by complex step, its motion by two integrators."""

from __future__ import annotations

import math

import numpy as np
import pytest

import nonsmooth as ns
from models import SliderCrank
from models.slider_crank import CORNERS
from nonsmooth.integrators.records import EVENT_CONTACT, EVENT_GAMMA_N, EVENT_KIND, EVENT_T, IMPACT
from nonsmooth.mechanics.system import FORCE, GAP, MASS, NORMAL, TANGENT

H = 1e-20  # complex step: no cancellation


def places(crank, q):
    """Centres of mass of crank, rod and slider (3, 2), and the corners (4, 2), from nothing but the geometry."""
    e = np.array([np.cos(q), np.sin(q)]).T
    A = crank.l1 * e[0]
    B = A + crank.l2 * e[1]
    turn = np.array([[np.cos(q[2]), -np.sin(q[2])], [np.sin(q[2]), np.cos(q[2])]])
    corners = np.array([B + turn @ [i * crank.a, j * crank.b] for i, j in CORNERS])
    return np.array([A / 2, (A + B) / 2, B]), corners


def jacobian(function, q):
    """d function/dq by complex steps, the derivative's index last."""
    return np.stack([function(q + 1j * H * np.eye(3)[k]).imag / H for k in range(3)], axis=-1)


def sample():
    return np.array([0.7, -0.4, 0.013]), np.array([30.0, -11.0, 4.0])


def test_mass_matrix_and_potential_are_those_of_the_bodies():
    crank, (q, u) = SliderCrank(), sample()
    system = crank.system()
    J = jacobian(lambda q: places(crank, q)[0], q)
    m = np.array([crank.m1, crank.m2, crank.m3])
    M = np.einsum("b,bij,bik->jk", m, J, J) + np.diag([crank.J1, crank.J2, crank.J3])
    np.testing.assert_allclose(system.evaluate(MASS, 0.0, q, u), M, rtol=1e-14, atol=1e-18)
    h = system.evaluate(FORCE, 0.0, q, 0 * u)
    np.testing.assert_allclose(h, -crank.g * np.einsum("b,bj->j", m, J[:, 1]), rtol=1e-14, atol=1e-17)


def test_velocity_forces_are_those_of_lagrange():
    # h(u) - h(0) = -(dM/dt) u + (1/2) d(u^T M u)/dq
    crank, (q, u) = SliderCrank(), sample()
    system = crank.system()
    step = 1e-6
    slopes = []
    for k in range(3):
        ahead, behind = (system.evaluate(MASS, 0.0, q + sign * step * np.eye(3)[k], u) for sign in (1, -1))
        slopes.append((ahead - behind) / (2 * step))
    dM = np.array(slopes)  # (q, row, column)
    expected = -np.einsum("k,kij,j->i", u, dM, u) + 0.5 * np.einsum("kij,i,j->k", dM, u, u)
    actual = system.evaluate(FORCE, 0.0, q, u) - system.evaluate(FORCE, 0.0, q, 0 * u)
    # central differences: truncation 1e-12 and rounding eps/step = 2e-10 of the terms
    np.testing.assert_allclose(actual, expected, atol=1e-8 * np.abs(actual).max())


def test_gaps_and_rows_are_those_of_the_corners():
    crank, (q, u) = SliderCrank(), sample()
    system = crank.system()
    side = np.array([j for _, j in CORNERS])
    wall = crank.b + crank.c
    np.testing.assert_allclose(system.evaluate(GAP, 0.0, q, u), wall - side * places(crank, q)[1][:, 1], atol=1e-16)
    J = jacobian(lambda q: places(crank, q)[1], q)
    np.testing.assert_allclose(system.evaluate(NORMAL, 0.0, q, u), -side[:, None] * J[:, 1], atol=1e-16)
    np.testing.assert_allclose(system.evaluate(TANGENT, 0.0, q, u)[:, 0], J[:, 0], atol=1e-16)


def test_slider_tilts_until_two_opposite_corners_touch():
    crank = SliderCrank()
    q = np.array([0.0, 0.0, crank.largest_tilt()])
    g_N = crank.system().evaluate(GAP, 0.0, q, q)
    np.testing.assert_allclose(g_N[[1, 2]], 0.0, atol=1e-17)
    assert (g_N[[0, 3]] > 0).all()


def test_guided_rod_keeps_the_slider_in_the_middle():
    crank = SliderCrank()
    for th1 in (0.3, 1.5, 2.9):
        B = crank.slider_centre(np.array([th1, crank.guided_rod_angle(th1), 0.0]))
        assert abs(B[1]) < 1e-16 and B[0] > 0


def end(crank, t_end, integrator):
    return ns.simulate(crank, (0.0, t_end), *crank.state(), integrator=integrator, t_eval=[t_end])


def test_without_restitution_time_steps_converge_to_the_event_driven_motion_with_order_one():
    crank = SliderCrank(e=0.0)
    exact = end(crank, 0.2, ns.EventDriven(rtol=1e-10, atol=1e-12)).q[-1]
    errors = [np.abs(end(crank, 0.2, ns.MoreauJean(dt)).q[-1] - exact).max() for dt in (1e-4, 1e-5, 1e-6)]
    orders = -np.diff(np.log10(errors))
    assert np.all(np.abs(orders - 1.0) < 0.3) and errors[-1] < 2e-4


@pytest.mark.filterwarnings("ignore::nonsmooth.SimultaneousImpactWarning")  # what is asked holds for it too
def test_bouncing_corners_of_a_plate_end_alike_by_time_steps_and_by_events():
    crank = SliderCrank(J3=8e-5)  # of a uniform plate
    exact = end(crank, 0.012, ns.EventDriven(rtol=1e-10, atol=1e-12)).q[-1]
    coarse, fine = (np.abs(end(crank, 0.012, ns.MoreauJean(dt)).q[-1] - exact).max() for dt in (1e-6, 1e-7))
    assert fine < 1e-6 and fine < 0.3 * coarse


@pytest.mark.filterwarnings("ignore::nonsmooth.SimultaneousImpactWarning")  # what is asked holds for it too
@pytest.mark.parametrize("rtol", [1e-6, 1e-9])
def test_event_driven_error_of_the_published_mechanism_follows_the_tolerance(rtol):
    crank = SliderCrank()
    exact = end(crank, 0.2, ns.EventDriven(rtol=1e-12, atol=1e-14))
    solution = end(crank, 0.2, ns.EventDriven(rtol=rtol, atol=rtol / 100))
    # errors of a step grow by the impacts between: ten times the tolerance of the largest angle and velocity
    np.testing.assert_allclose(solution.q[-1], exact.q[-1], atol=10 * rtol * np.abs(exact.q[-1]).max())
    np.testing.assert_allclose(solution.u[-1], exact.u[-1], atol=10 * rtol * 150)


def test_corners_of_a_light_slider_throw_one_another_back_until_both_rest():
    """Between two impacts in turn the time shrinks faster than the velocity; energy is lost to the last."""
    crank = SliderCrank()
    solution = ns.simulate(crank, (0, 0.004), *crank.state(), integrator=ns.EventDriven(rtol=1e-10, atol=1e-12))
    rows = solution.event_rows[solution.event_rows[:, EVENT_KIND] == IMPACT]
    t, gamma_N = rows[:-2, EVENT_T], -rows[:-2, EVENT_GAMMA_N]
    assert (np.diff(rows[:-2, EVENT_CONTACT]) != 0).all() and len(t) > 10
    times = np.diff(t)[6:12]
    assert np.all((times[1:] / times[:-1] > 0.4) & (times[1:] / times[:-1] < 0.5))
    assert np.all(np.abs(gamma_N[8:] / gamma_N[7:-1] - 0.946) < 0.01)
    # the slider lies on the upper wall, and does not turn against it
    np.testing.assert_allclose(solution.g_N[-1, :2], 0.0, atol=1e-15)
    assert abs(solution.u[-1, 2]) < 1e-9 and rows[-1, EVENT_T] - t[-1] < 1e-12


def test_energy_is_kept_where_the_slider_does_not_touch():
    crank = SliderCrank(c=1.0)
    solution = ns.simulate(crank, (0, 0.1), *crank.state(), integrator=ns.EventDriven(rtol=1e-11, atol=1e-13))
    energy = solution.ledger["kinetic"] + solution.ledger["potential"]
    assert len(solution.events) == 0
    assert np.abs(energy - energy[0]).max() < 1e-9 * energy[0]
    assert math.isclose(solution.u[-1, 2], -0.01)
