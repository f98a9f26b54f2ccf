"""The billiard ball: Coriolis' parabola and line, and what friction takes."""

import numpy as np
import pytest

import nonsmooth as ns
from models import BilliardBall

STRUCK = {"speed": 1.3, "angle": 0.4, "w_x": 40.0, "w_y": -30.0, "w_z": 12.0}


def run(ball, dt=1e-3, **state):
    q, u = ball.state(**state)
    return ns.simulate(ball, (0, 1), q, u, integrator=ns.MoreauJean(dt=dt)), u


def test_the_ball_follows_its_parabola_and_rolls_on_along_a_line():
    """The direction of the slip is constant, so that steps make no error until the one in which it begins to roll."""
    ball = BilliardBall()
    sol, u = run(ball, **STRUCK)
    until = ball.rolling_time(u)
    assert 0.1 < until < 0.9
    sliding = sol.t < until - 1e-3
    exact = np.array([ball.path(t, u) for t in sol.t])
    np.testing.assert_allclose(sol.q[sliding, :2], exact[sliding], atol=1e-12)
    np.testing.assert_allclose(sol.q[:, :2], exact, atol=ball.mu * ball.g * 1e-3**2)
    np.testing.assert_allclose(sol.u[-1, :2], ball.rolling_velocity(u), rtol=1e-12)
    assert sol.mode[-1, 0] == ns.ContactMode.STICK
    assert abs(sol.events[-1].t - until) < 2e-3


def test_what_friction_takes_is_the_energy_that_is_lost():
    """m s^2/7 of the slip s, and the spin about the vertical is left."""
    ball = BilliardBall()
    sol, u = run(ball, **STRUCK)
    s = ball.slip(u)
    assert sol.ledger["friction"][-1] == pytest.approx(-ball.m * s @ s / 7.0, rel=1e-10)
    assert sol.u[-1, 5] == STRUCK["w_z"]


def test_a_ball_that_rolls_from_the_start_goes_straight():
    ball = BilliardBall()
    sol, u = run(ball, speed=1.0, w_x=0.0, w_y=1.0 / ball.R)
    assert ball.rolling_time(u) == pytest.approx(0.0, abs=1e-15)
    np.testing.assert_allclose(sol.q[-1, :2], [1.0, 0.0], atol=1e-12)
    assert (sol.mode[1:] == ns.ContactMode.STICK).all()


def test_a_ball_turns_as_far_as_it_rolls():
    """Along x by 1 m: it has turned by 1/R about y."""
    ball = BilliardBall(R=0.5)
    sol, _ = run(ball, speed=1.0, w_x=0.0, w_y=1.0 / ball.R)
    angle = 2.0 * np.arctan2(sol.q[-1, 5], sol.q[-1, 3])
    assert angle == pytest.approx(1.0 / ball.R, abs=1e-5)


def test_a_dropped_ball_with_side_spin_jumps_aside():
    """An impact at 1 m/s: friction takes mu (1 + e) from the slip's direction, unless it would stop it."""
    ball = BilliardBall(e=0.5)
    q, u = ball.state(speed=0.0, w_x=60.0, w_y=0.0)
    q[2], u[2] = ball.R + 0.01, -1.0
    sol = ns.simulate(ball, (0, 0.05), q, u, integrator=ns.MoreauJean(dt=1e-4))
    impact = next(event for event in sol.events if event.kind == ns.EventKind.IMPACT)
    after = sol.u[np.searchsorted(sol.t, impact.t) + 1]
    assert after[1] == pytest.approx(-ball.mu * 1.5 * abs(impact.gamma_N), rel=1e-2)
