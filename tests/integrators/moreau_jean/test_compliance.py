"""Moreau–Jean with a compliant contact: rigid limit, depth at rest, stability, paradoxes by the sign of p + R."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from models import BouncingBall, PainleveRod, SlidingBlock, SpragSlip
from nonsmooth import ContactMode, EventKind

G = 9.81


def run(model, state, t_end, dt, k, c=0.0, **options):
    integrator = ns.MoreauJean(dt, theta=1.0, compliance=ns.Compliance(k, c))
    return ns.simulate(model, (0, t_end), *state, integrator=integrator, **options)


def test_stiff_contact_is_the_rigid_one_within_rounding():
    rod = SpragSlip()
    state = rod.state(th=0.78, thdot=1.0)
    rigid, stiff = (run(rod, state, 0.1, 1e-3, k) for k in (math.inf, 1e22))
    assert np.abs(stiff.q - rigid.q).max() < 1e-12 * np.abs(rigid.q).max()
    # a hundred steps of rounding, through an impulse of 13 N s at which p < 0 magnifies them


def test_distance_to_the_rigid_step_falls_like_1_over_k():
    ball = BouncingBall()
    state = ball.state(height=1.0)
    rigid = run(ball, state, 1.0, 1e-3, math.inf).q[-1, 0]
    distance = [abs(run(ball, state, 1.0, 1e-3, k).q[-1, 0] - rigid) for k in (1e8, 1e9, 1e10)]
    assert np.allclose(np.diff(np.log10(distance)), -1.0, atol=0.02)


def test_rigid_limit_lands_without_restitution():
    ball = BouncingBall(e=0.9)  # of the rigid step: a compliant contact has its own
    solution = run(ball, ball.state(height=1.0), 1.0, 1e-3, math.inf)
    landed = solution.t > math.sqrt(2 / G) + 3e-3
    assert np.abs(solution.q[landed]).max() < 1e-15 and np.abs(solution.u[landed]).max() < 1e-15


@pytest.mark.parametrize("k", [1e3, 1e6, 1e9])
def test_ball_rests_at_its_static_depth(k):
    ball = BouncingBall()
    solution = run(ball, ball.state(height=0.1), 20.0, 1e-2, k, c=2 * math.sqrt(k), every=100)
    assert abs(solution.q[-1, 0] + G / k) < 1e-12 * (1 + G / k)
    assert abs(solution.P_N[-1, 0] - G * 1.0) < 1e-9  # of a second


@pytest.mark.parametrize("dt", [1e-4, 1e-3, 1e-2])
@pytest.mark.parametrize("k", [1.0, 1e4, 1e8, 1e12, 1e18])
def test_no_stiffness_and_no_step_makes_a_bounce_gain_energy(k, dt):
    ball = BouncingBall()
    solution = run(ball, ball.state(height=1.0), 2.0, dt, k, every=10)
    in_flight = solution.mode[:, 0] == ContactMode.OPEN
    energy = 0.5 * solution.u[:, 0] ** 2 + G * solution.q[:, 0]
    # free flight with theta = 1 loses g^2 dt^2/2 a step; a landing adds at most the fall of the step before it
    assert energy[in_flight].max() < G * (1.0 + dt * math.sqrt(2 * G))


@pytest.mark.parametrize(("share", "slides"), [(2.0, True), (0.5, False)])
def test_sign_of_p_plus_R_decides_an_inconsistent_state(share, slides):
    """R = 1/(k dt^2) beside -p: where it is larger the step has a sliding solution, else it jumps to sticking."""
    rod, dt, th = PainleveRod(mu=2.0), 1e-3, math.pi / 3
    p, b = rod.coefficients(th, 0.0, -1.0)
    assert p < 0 and b < 0
    k = 1 / (share * -p * dt**2)
    solution = run(rod, rod.state(th=th, slip=-1.0), dt, dt, k)
    assert solution.mode[-1, 0] == (ContactMode.SLIDE if slides else ContactMode.STICK)
    assert any(event.kind == EventKind.INCONSISTENT for event in solution.paradoxes) != slides
    if slides:
        R = 1 / (k * dt**2)
        assert abs(solution.P_N[-1, 0] + dt * b / (p + R)) < 1e-3 * solution.P_N[-1, 0]  # rows change by O(dt)


def test_limits_of_step_and_stiffness_do_not_commute_in_an_impact_without_collision():
    """dt -> 0 first: the energetic impact, as resolved in time; k -> inf first: the plastic one."""
    rod, k, t_end = PainleveRod(mu=2.0), 1e8, 2e-3
    resolved = ns.simulate(rod, (0, t_end), *rod.state(slip=-1.0), integrator=ns.Penalty(k))
    after = next(e.gamma_N for e in resolved.events if e.mode_after == ContactMode.OPEN)

    def velocity(dt):
        solution = run(rod, rod.state(slip=-1.0), t_end, dt, k)
        return (solution.u[:, 1] - 0.5 * rod.l * np.cos(solution.q[:, 2]) * solution.u[:, 2]).max()

    errors = [abs(velocity(dt) - after) for dt in (1e-6, 1e-7)]
    assert errors[1] < 0.15 * errors[0] and errors[1] < 1e-3
    assert velocity(1e-3) < 0.02 * after  # |p| k dt^2 = 85


def test_step_is_of_first_order_towards_the_contact_resolved_in_time():
    block, k, c = SlidingBlock(mu=0.3), 1e4, 200.0
    q0, u0 = block.state(speed=2.0)
    u0[1] = -0.5  # it lands while it slides
    exact = ns.simulate(
        block, (0, 0.3), q0, u0, integrator=ns.Penalty(k, damping=c, rtol=1e-10, atol=1e-12), t_eval=[0.3]
    )
    dts = np.array([1e-4, 3e-5, 1e-5])
    errors = [np.abs(run(block, (q0, u0), 0.3, dt, k, c).q[-1] - exact.q[-1]).max() for dt in dts]
    assert 0.8 < np.polyfit(np.log(dts), np.log(errors), 1)[0] < 1.2


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: ns.Compliance(0.0), "stiffness must be positive"),
        (lambda: ns.Compliance(1e6, -1.0), "damping must not be negative"),
        (lambda: ns.MoreauJean(1e-3, compliance=ns.Compliance(1e6)), "a compliance needs theta = 1"),
        (lambda: ns.MoreauJean(1e-3, theta=1.0, compliance=1e6), "compliance must be a Compliance"),
        (lambda: ns.MoreauJean(1e-3, 1.0, True, ns.Compliance(1e6)), "either compliance or projection"),
    ],
)
def test_bad_input_is_refused_by_name(make, words):
    with pytest.raises(ns.InvalidInput, match=words):
        make()
