"""Bouncing ball and sliding blocks: closed forms against the motion they describe."""

from __future__ import annotations

import math

import numpy as np
import pytest

from models import BouncingBall, InclinedBlock, SlidingBlock


def test_impacts_of_the_ball_accumulate_at_three_times_the_first_for_e_one_half():
    ball = BouncingBall(e=0.5)
    t_1 = math.sqrt(2 / 9.81)
    assert ball.impact_times(1, height=1.0)[0] == pytest.approx(t_1, rel=1e-15)
    assert ball.t_inf(height=1.0) == pytest.approx(3 * t_1, rel=1e-15)
    assert ball.t_inf(height=1.0) == pytest.approx(1.3546, abs=6e-5)
    assert ball.impact_times(60)[-1] == pytest.approx(ball.t_inf(), rel=1e-15)


def test_perfectly_elastic_ball_bounces_for_ever_and_a_plastic_one_once():
    assert BouncingBall(e=1.0).t_inf() == math.inf
    assert np.diff(BouncingBall(e=1.0).impact_times(4)) == pytest.approx(2 * math.sqrt(2 / 9.81))
    plastic = BouncingBall(e=0.0)
    assert plastic.t_inf() == plastic.impact_times(1)[0]
    assert plastic.height(plastic.t_inf() + 0.1) == 0.0


@pytest.mark.parametrize("height, velocity", [(1.0, 0.0), (0.3, 2.0), (0.0, 1.0), (2.0, -3.0)])
def test_ball_is_on_the_ground_at_its_impacts_and_highest_between_them(height, velocity):
    ball = BouncingBall(e=0.7)
    times = ball.impact_times(5, height, velocity)
    for k, t in enumerate(times):
        assert ball.height(t, height, velocity) == pytest.approx(0.0, abs=1e-14)
        if k + 1 < len(times):
            v = ball.impact_speed(height, velocity) * ball.e ** (k + 1)
            peak = ball.height(0.5 * (t + times[k + 1]), height, velocity)
            assert peak == pytest.approx(v * v / (2 * ball.g), rel=1e-12)


def test_ball_falls_freely_before_its_first_impact():
    assert BouncingBall().height(0.2, height=1.0, velocity=0.5) == pytest.approx(1 + 0.1 - 0.5 * 9.81 * 0.04)


@pytest.mark.parametrize("speed", [2.0, -2.0])
def test_block_stops_where_its_kinetic_energy_is_spent(speed):
    block = SlidingBlock(mu=0.3, m=2.0)
    t, x = block.stop_time(speed), block.stop_distance(speed)
    assert (t, x) == pytest.approx((0.67958, 0.67958), abs=6e-6)
    assert block.mu * block.m * block.g * x == pytest.approx(0.5 * block.m * speed**2, rel=1e-14)
    assert block.position(t, speed) == pytest.approx(math.copysign(x, speed), rel=1e-14)
    assert block.position(10 * t, speed) == block.position(t, speed)


def test_block_without_friction_never_stops():
    assert SlidingBlock(mu=0.0).stop_time() == SlidingBlock(mu=0.0).stop_distance() == math.inf
    assert SlidingBlock(mu=0.0).position(3.0, speed=-2.0) == -6.0


@pytest.mark.parametrize("alpha", [0.15, -0.2, 0.5, 0.0])
def test_sticking_loads_are_those_at_which_the_force_leaves_the_friction_cone(alpha, contact_problem):
    for side, load in enumerate(InclinedBlock(alpha=alpha).sticking_loads()):
        for factor, sticks in ((0.999, True), (1.001, False)):
            middle = 9.81 * math.tan(alpha)
            block = InclinedBlock(alpha=alpha, F=middle + factor * (load - middle))
            assert block.sticks() == sticks
            _, G, b = contact_problem(block, *block.state(slip=0.0))
            la_N, la_F = -np.linalg.solve(G, b)
            assert la_N == pytest.approx(block.normal_force(), rel=1e-12)
            assert la_F == pytest.approx(block.downhill_load(), rel=1e-9, abs=1e-12)
            assert (abs(la_F) <= block.mu * la_N) == sticks
            assert np.sign(block.acceleration()) == (0 if sticks else (-1, 1)[side])


def test_slipping_inclined_block_is_braked_by_friction_and_weight():
    block = InclinedBlock(alpha=0.2, mu=0.3)
    up = -block.g * (math.sin(0.2) + 0.3 * math.cos(0.2))
    down = -block.g * (math.sin(0.2) - 0.3 * math.cos(0.2))
    assert (block.acceleration(1.0), block.acceleration(-1.0)) == pytest.approx((up, down), rel=1e-14)


def test_steep_inclined_block_jams_against_any_push():
    low, high = InclinedBlock(alpha=1.4, mu=0.5).sticking_loads()
    assert high == math.inf and low > 0
    assert InclinedBlock(alpha=1.4, mu=0.5, F=1e9).sticks()


def test_default_inclined_block_is_at_half_its_friction_limit():
    block = InclinedBlock()
    assert block.downhill_load() == pytest.approx(0.5 * block.mu * block.normal_force(), rel=1e-14)
