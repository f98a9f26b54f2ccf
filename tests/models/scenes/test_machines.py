"""Machines of joints, against their closed forms."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from models.scenes import (
    AndrewsSqueezer,
    CarOnBump,
    CrankInSlot,
    DoublePendulum,
    FourBars,
    Governor,
    Gripper,
    JammingDrawer,
    RimlessWheel,
    ShoeBrake,
    VibratingFeeder,
)


def run(model, t_end, dt=None):
    return ns.simulate(model, (0, t_end), integrator=ns.MoreauJean(dt or model.dt))


@pytest.mark.parametrize("mode", [0, 1])
def test_a_double_pendulum_swings_back_in_each_of_its_modes(mode):
    small = 1e-3 * DoublePendulum().mode(mode)
    model = DoublePendulum(th_1=small[0], th_2=small[1])
    period = 2 * math.pi / model.frequencies()[mode]
    sol = run(model, period)
    # frequencies err by (w dt)^2/24, and by th^2/16: a cosine at its top sees the square of both
    np.testing.assert_allclose([sol["upper"].turn[-1], sol["lower"].turn[-1]], small, rtol=2e-6)
    assert DoublePendulum(l_2=1.0, m_2=1.0).frequencies() ** 2 == pytest.approx(
        9.81 * (3 + np.array([-6, 6]) / math.sqrt(7)), rel=1e-12
    )


@pytest.mark.upkeep
@pytest.mark.parametrize("n", [2, 10])
def test_a_row_of_four_bars_passes_where_it_lies_flat_as_one_pendulum(n):
    """Where it is flat its rate jumps by what the soft joints of loops take, at any step."""
    model = FourBars(n=n)
    for dt in (2e-3, 1e-3):
        sol = run(model, 2.0, dt)
        angle = 0.5 * math.pi - sol["crank 0"].turn
        assert angle[-1] > 1.9 * math.pi  # it lay flat twice
        assert np.abs(np.abs(sol["crank 0"].spin) - [model.rate(th) for th in angle]).max() < 4e-3
        turns = [sol[f"crank {k}"].turn for k in range(n + 1)]
        # all cranks are parallel; where they lie flat a gap of 1e-9 m leaves angles of sqrt(1e-9)
        assert np.ptp(turns, axis=0).max() < 3e-5 and sol.stats.worst_joint_drift < 1e-8


@pytest.mark.parametrize("F", [8.0, 11.8])
def test_a_box_slips_out_of_the_gripper_by_newtons_law(F):
    model = Gripper(F=F)
    sol = run(model, 0.18)  # later it is out
    np.testing.assert_allclose(sol["box"].position[:, 1], -0.5 * model.slip() * sol.t**2, atol=1e-9)


def test_the_gripper_holds_the_box_with_little_more_than_the_least_force():
    model = Gripper(F=1.001 * Gripper().least_force())
    sol = run(model, 0.5)
    assert np.ptp(sol["box"].position[:, 1]) < 1e-9


BOUNDS = JammingDrawer().bounds()


@pytest.mark.parametrize("mu", [0.3, 0.99 * BOUNDS[0]])
def test_a_drawer_that_slides_has_the_acceleration_of_its_statics(mu):
    model = JammingDrawer(mu=mu)
    sol = run(model, 0.1)
    assert model.outcome() == "slides" and not sol.paradoxes
    assert 2 * sol["drawer"].position[-1, 1] / 0.1**2 == pytest.approx(model.acceleration(), rel=1e-3)


@pytest.mark.parametrize("mu", [1.01 * BOUNDS[0], 0.99 * BOUNDS[1]])
def test_a_drawer_that_may_jam_or_slide_is_named_indeterminate(mu):
    model = JammingDrawer(mu=mu)
    sol = run(model, 0.01)
    assert model.outcome() == "slides or jams"
    assert {(paradox.kind.name, paradox.n_solutions) for paradox in sol.paradoxes} == {("INDETERMINATE", 2)}


@pytest.mark.upkeep
@pytest.mark.parametrize("mu", [1.01 * BOUNDS[1], 2.0])
def test_a_drawer_that_jams_stands_still_whatever_pulls(mu):
    for F in (20.0, 2e4):
        model = JammingDrawer(mu=mu, F=F)
        sol = run(model, 0.1)
        assert model.outcome() == "jams" and not sol.paradoxes
        assert abs(sol["drawer"].position[-1, 1]) < 1e-12 * F


def test_a_slider_crank_of_bodies_is_the_one_of_three_angles():
    """To second order until its slider strikes, at 2.69 ms; then three corners strike in turns, every microsecond, and
    steps take what comes within one together: crank and rod keep to 1e-3 rad, the slider to 1e-2 of its 0.04."""
    model, times = CrankInSlot(), np.array([0.0, 0.0025, 0.01, 0.02])
    exact = ns.simulate(
        model.model(), (0, 0.02), *model.start(), integrator=ns.EventDriven(rtol=1e-10, atol=1e-12), t_eval=times
    ).q
    errors = []
    for dt in (2e-5, 1e-5):
        sol = ns.simulate(model, (0, 0.02), integrator=ns.MoreauJean(dt), t_eval=times)
        errors.append(np.abs(model.angles(sol) - exact))
        assert errors[-1][:, :2].max() < 1.5e-3 and errors[-1][:, 2].max() < 1e-2
    assert 3.5 < errors[0][1].max() / errors[1][1].max() < 4.5


@pytest.mark.upkeep
def test_andrews_squeezer_has_its_published_angles():
    """By its system, to what the published ones err by; by steps, of joints in loops, to their order."""
    model, published = AndrewsSqueezer(), AndrewsSqueezer().published()
    sol = ns.simulate(model, (0, 0.03), integrator=ns.Adaptive(rtol=1e-10, atol=1e-12), every=10**6)
    assert abs(model.angles(sol)[-1] - published).max() < 2e-9 and sol.stats.worst_joint_drift < 1e-12
    force, beta = sol.spring("spring").force, model.angles(sol)[:, 0]
    done = model.M * (beta[-1] - beta[0]) + (force[0] ** 2 - force[-1] ** 2) / (2 * model.k)
    assert sol.ledger["kinetic"][-1] == pytest.approx(done, rel=1e-9)
    by_steps = run(model, 0.03, 5e-6)
    assert abs(model.angles(by_steps)[-1] - published).max() < 2e-4 and by_steps.stats.worst_joint_drift < 1e-12


@pytest.mark.parametrize("spin", [30.0, -30.0])
def test_a_brake_slows_its_wheel_by_the_balance_of_its_lever(spin):
    model = ShoeBrake(spin=spin)
    sol = run(model, 1.2 * model.stop_time())
    expected = spin * np.maximum(0.0, 1 - sol.t / model.stop_time())
    assert abs(sol["wheel"].spin - expected).max() < 1e-9 * abs(spin)
    assert abs(sol["wheel"].spin[-1]) < 1e-12


@pytest.mark.parametrize("F", [50.0, 1e-3])
def test_a_brake_that_locks_stops_its_wheel_at_once(F):
    model = ShoeBrake(mu=0.81, F=F)
    assert model.locks() and not ShoeBrake(mu=0.81, spin=-30.0).locks() and not ShoeBrake(mu=0.79).locks()
    sol = run(model, 0.01)
    assert abs(sol["wheel"].spin[1:]).max() < 1e-6 * model.spin


def test_a_rimless_wheel_comes_to_its_gait():
    """Before the last landings, of which a step of dt is late by up to itself: w changes by g dt/l in it."""
    model = RimlessWheel(rate=5.0)
    sol = run(model, 6.0)
    rate = -sol["wheel"].spin
    last = rate[sol.t > 5.0]
    assert last.max() == pytest.approx(model.gait(), abs=2 * model.g * model.dt / model.l)
    assert last[last > 0].min() < model.kept() * model.gait() + 0.02
    assert sol["wheel"].position[-1, 0] > 20 * 2 * model.l * math.sin(model.alpha) * 0.5


@pytest.mark.parametrize(("share", "passes"), [(0.99, False), (1.01, True)])
def test_a_rimless_wheel_passes_over_its_foot_or_rocks_back(share, passes):
    model = RimlessWheel(rate=share * RimlessWheel().least_rate())
    sol = run(model, 2.0)
    assert (sol["wheel"].turn.min() < -model.alpha) == passes


@pytest.mark.upkeep
def test_a_car_over_a_bump_follows_the_linear_equations_and_does_not_hop():
    """To first order in the step, for the wheel strikes the bump; two per cent is the square of its slope."""
    model, errors = CarOnBump(), []
    for dt in (5e-4, 1e-4):
        sol = run(model, 1.2, dt)
        expected = model.linear(sol.t)
        found = np.array([sol["chassis"].position[:, 1] - model.r, sol["chassis"].turn])
        errors.append(np.max(abs(found - expected).max(axis=1) / abs(expected).max(axis=1)))
        for wheel in ("rear", "front"):
            x, y = sol[wheel].position.T
            assert max(y - model.r - [model.lift(at) for at in x]) < 0.1 * dt  # a step's way along the slope of 0.1
            assert all(sol.contacts(t).of(wheel).P_N.sum() > 0.0 for t in sol.t[1:])
    assert errors[1] < 0.01 < errors[0] < 0.03


@pytest.mark.upkeep
@pytest.mark.parametrize(("a", "mu", "hops"), [(3e-4, 0.4, True), (1.5e-4, 0.2, False)])
def test_a_feeder_conveys_as_its_phases_say(a, mu, hops):
    model = VibratingFeeder(a=a, mu=mu)
    assert (model.throw() > 1.0) == hops
    errors = []
    for dt in (1e-4, 2.5e-5):
        sol = run(model, 0.2, dt)
        way = sol["part"].position[:, 0] - sol["plate"].position[:, 0]
        errors.append(abs(way - model.way(sol.t)).max() / way[-1])
    assert errors[1] < 0.012 and errors[1] < 0.6 * errors[0] and abs(sol["part"].turn).max() < 1e-9


def test_a_feeder_below_its_friction_carries_nothing():
    model = VibratingFeeder(a=3e-5)
    sol = run(model, 0.1, 1e-4)
    assert model.speed(periods=5) == 0.0
    way = sol["part"].position[:, 0] - sol["plate"].position[:, 0]
    assert abs(way).max() < 1e-5 * model.a and abs(way[-1] - way[1]) < 1e-14  # after five periods


@pytest.mark.upkeep
def test_a_governor_swings_by_the_energy_of_its_one_angle_and_rests_where_that_is_least():
    model, errors = Governor(), []
    for dt in (2e-3, 1e-3):
        sol = run(model, 2.0, dt)
        errors.append(abs(model.angle(sol) - model.angle_at(sol.t)).max())
    assert errors[1] < 5e-5 and 3.5 < errors[0] / errors[1] < 4.5 and sol.stats.worst_joint_drift < 1e-12
    rest, small = model.rest(), 1e-3
    slope, bend = (model.potential(rest + small) - model.potential(rest - small)) / small, model.frequency() ** 2
    assert abs(slope) < 1e-5 * model.g
    curve = (model.potential(rest + small) - 2 * model.potential(rest) + model.potential(rest - small)) / small**2
    assert curve / (2 * model.inertia(rest)) == pytest.approx(bend, rel=1e-4)
    still = run(Governor(alpha=rest), 2.0)
    assert np.ptp(model.angle(still)) < 5e-5 and Governor(w=3.0).rest() == 0.0
