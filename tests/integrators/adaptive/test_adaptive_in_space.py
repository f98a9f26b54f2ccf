"""Error control of systems with q' = B u and friction in two directions: closed forms, orders, records, refusals."""

import dataclasses
import math
from dataclasses import replace

import numpy as np
import pytest

import nonsmooth as ns
from models import BilliardBall, BouncingBall, SpatialPainleveRod
from nonsmooth import ContactMode

TOLERANCES = (1e-4, 1e-6, 1e-8)


def adaptive(rtol):
    return ns.Adaptive(rtol, rtol / 100)


@pytest.mark.parametrize("rtol", TOLERANCES)
def test_a_billiard_ball_slips_along_its_parabola_and_rolls_on(rtol):
    """Coordinates are a place and a quaternion: the error is within ten tolerances of the largest coordinate."""
    ball = BilliardBall()
    q, u = ball.state(w_z=30.0)
    sol = ns.simulate(ball, (0, 1.0), q, u, integrator=adaptive(rtol))
    assert abs(sol.q[-1, :2] - ball.path(1.0, u)).max() < 10 * rtol
    assert abs(sol.u[-1, :2] - ball.rolling_velocity(u)).max() < 10 * rtol
    begins = next(event.t for event in sol.events if event.mode_after == ContactMode.STICK)
    assert abs(begins - ball.rolling_time(u)) < 0.05 * math.sqrt(rtol)
    assert abs(np.linalg.norm(sol.q[:, 3:], axis=1) - 1).max() < 1e-13


def free_ball(e):
    """A ball that falls on rough ground and spins: the plane's closed forms hold between its impacts."""
    ball = BilliardBall(m=1.0, R=0.1, mu=0.3, e=e)
    q, u = ball.state(speed=0.0, w_x=0.0, w_y=0.0)
    q[2] += 0.5
    return ball, q, u


@pytest.mark.parametrize("rtol", TOLERANCES)
def test_bounces_are_those_of_the_ball_of_the_plane(rtol):
    ball, q, u = free_ball(0.8)
    sol = ns.simulate(ball, (0, 1.4), q, u, integrator=adaptive(rtol))
    plane = BouncingBall(e=0.8, g=ball.g)
    other = ns.simulate(plane, (0, 1.4), *plane.state(height=0.5), integrator=ns.EventDriven(1e-10, 1e-12))
    assert sum(event.kind == ns.EventKind.IMPACT for event in sol.events) == len(
        [event for event in other.events if event.kind == ns.EventKind.IMPACT]
    )
    assert abs(sol.q[-1, 2] - ball.R - other.q[-1, 0]) < 100 * rtol  # six impacts, at velocities of 3 m/s


def test_a_rod_that_falls_and_strikes_is_that_of_short_steps():
    rod = SpatialPainleveRod(mu=0.6, e=0.5)
    q, u = rod.state(th=1.2, phi=1.0, thdot=2.0, psidot=4.0, slip=1.0)
    q[2] += 0.05
    sol = ns.simulate(rod, (0, 0.3), q, u, integrator=adaptive(1e-6))
    other = ns.simulate(rod, (0, 0.3), q, u, integrator=ns.MoreauJean(1e-6), every=1000)
    assert abs(sol.q[-1] - other.q[-1]).max() < 1e-4  # of the steps: 1e-6 s at each of some impacts of 5 m/s and more
    assert sol.stats.steps < 0.1 * other.stats.steps


def test_a_slide_that_turns_is_as_wrong_as_its_tolerance():
    rod = SpatialPainleveRod(mu=0.4)
    start = rod.state(th=1.0, phi=0.5, thdot=0.5, psidot=0.3, slip=1.0)
    exact = ns.simulate(rod, (0, 0.1), *start, integrator=ns.Penalty(1e10, damping_ratio=0.5, rtol=1e-9, atol=1e-11))
    for rtol in TOLERANCES:
        sol = ns.simulate(rod, (0, 0.1), *start, integrator=adaptive(rtol))
        assert abs(sol.q[-1] - exact.q[-1]).max() < 10 * rtol  # and 1e-9 of a spring under 10 N
        assert abs(sol.u[-1] - exact.u[-1]).max() < 10 * rtol * abs(sol.u).max()
        # of second order; what rows of a place ahead leave of the velocities, of first, would take 100 times as many
        assert sol.stats.steps < 2 / math.sqrt(rtol)


def test_a_state_without_a_solution_is_passed_by_the_impact_of_its_contact():
    rod = SpatialPainleveRod(mu=2.0)
    state = {"th": 1.0, "phi": 0.4, "slip": 1.0}
    limit = rod.impact_without_collision(**state, e=0.0)
    sol = ns.simulate(rod, (0, 0.01), *rod.state(**state), integrator=adaptive(1e-6))
    assert sol.events[0].kind == ns.EventKind.INCONSISTENT
    assert abs(sol.events[0].P_N - limit.P_N) < 1e-6 * limit.P_N
    assert abs(sol.u[1] - limit.u).max() < 100 * sol.t[1]  # gravity, and what the forces do in the step


def test_records_motion_and_events_are_those_of_every_integrator():
    ball = BilliardBall()
    q, u = ball.state()
    times = np.linspace(0, 0.5, 11)
    whole = ns.simulate(ball, (0, 0.5), q, u, integrator=adaptive(1e-6))
    asked = ns.simulate(ball, (0, 0.5), q, u, integrator=adaptive(1e-6), t_eval=times)
    assert np.array_equal(asked.t, times)
    exact = np.array([ball.path(t, u) for t in times])
    assert abs(asked.q[:, :2] - exact).max() < 1e-5
    assert abs(whole(times).q[:, :2] - exact).max() < 1e-5

    def reaches(t, q, u):
        return q[0] - 0.2

    reaches.terminal = True
    stopped = ns.simulate(ball, (0, 0.5), q, u, integrator=adaptive(1e-6), events=reaches)
    assert stopped.status == ns.Status.EVENT_REACHED and stopped.q[-1, 0] == pytest.approx(0.2, abs=1e-6)
    assert len(ns.simulate(ball, (0, 0.5), q, u, integrator=adaptive(1e-6), every=7).t) < 0.2 * len(whole.t)


def test_a_run_that_was_cut_goes_on_with_the_same_bits(tmp_path):
    ball, q, u = free_ball(0.5)
    task = {"integrator": adaptive(1e-6)}
    whole = ns.simulate(ball, (0, 1.0), q, u, **task)
    cut = ns.simulate(ball, (0, 1.0), q, u, **task, checkpoint=tmp_path / "c", max_steps=37, on_failure="return")
    assert cut.status == ns.Status.BUDGET_SPENT
    rest = ns.simulate(ball, (0, 1.0), q, u, **task, resume=tmp_path / "c")
    assert np.array_equal(rest.q[-1], whole.q[-1]) and np.array_equal(rest.u[-1], whole.u[-1])
    assert rest.stats.steps == whole.stats.steps


def test_a_scene_as_a_system_keeps_its_tolerance():
    scene = ns.Scene(gravity=(0, 0, -9.81), material=ns.Material(mu=0.4))
    scene.fixed(ns.HalfSpace((0, 0, 1)))
    scene.body(
        ns.Capsule(0.2, 0.02), mass=1.0, position=(0, 0, 0.15), turn=(0.8, 0.0, 0.6, 0.0), velocity=(0.3, 0.2, 0)
    )
    system, start = scene.system(), scene.state()
    coarse, fine = (ns.simulate(system, (0, 0.25), *start, integrator=adaptive(rtol)) for rtol in (1e-4, 1e-7))
    short = ns.simulate(system, (0, 0.25), *start, integrator=ns.MoreauJean(2e-6), every=1000)
    assert abs(fine.q[-1] - short.q[-1]).max() < 1e-4
    assert abs(coarse.q[-1] - fine.q[-1]).max() < 30 * 1e-4


def chalk():
    """On a tip of 1 mm, stopped at its start, where no force fits: it spins about its axis, which was at rest."""
    scene = ns.Scene(gravity=(0, 0, -9.81), material=ns.Material(mu=2.0))
    scene.fixed(ns.HalfSpace((0, 0, 1)))
    tilt, push = (math.cos(math.pi / 6), 0, -math.sin(math.pi / 6), 0), (-math.cos(0.4), -math.sin(0.4), 0)
    scene.body(ns.Capsule(1, 0.001), mass=1, position=(0.25, 0, math.sqrt(3) / 4 + 0.001), turn=tilt, velocity=push)
    return scene.system(), scene.state()


@pytest.mark.parametrize("rtol, most", [(1e-4, 20_000), (1e-5, 50_000)])
def test_what_an_impact_sets_going_out_of_rest_takes_no_vanishing_steps(rtol, most):
    """A part of a quaternion that begins at zero errs by as large a part of itself in any step."""
    system, start = chalk()
    exact = ns.simulate(system, (0, 0.5), *start, integrator=ns.EventDriven(1e-10, 1e-12))
    sol = ns.simulate(system, (0, 0.5), *start, integrator=ns.Adaptive(rtol))
    assert np.abs(sol.q[-1] - exact.q[-1]).max() < 10 * rtol and sol.stats.steps < most


def test_where_a_function_fails_it_is_named():
    ball = BilliardBall()
    system = ball.system()

    def force(t, q, u, p, h):
        h[2] = -p.m * p.g if t < 0.1 else math.nan

    with pytest.raises(ns.ModelFunctionError, match="force wrote nan"):
        ns.simulate(replace(system, force=force), (0, 1.0), *ball.state(), integrator=adaptive(1e-6))


def test_auto_with_a_tolerance_takes_it_where_events_are_not_located():
    system, start = BilliardBall().system(), BilliardBall().state()
    followed = ns.simulate(system, (0, 0.2), *start, integrator=ns.Auto(rtol=1e-6))
    assert followed.about["integrator"] == "EventDriven(rtol=1e-06, atol=1e-08)"
    springy = dataclasses.replace(system, contacts=[dataclasses.replace(system.contacts[0], e_F=0.1)])
    sol = ns.simulate(springy, (0, 0.2), *start, integrator=ns.Auto(rtol=1e-6))
    assert sol.about["integrator"] == "Adaptive(rtol=1e-06, atol=1e-08)"
