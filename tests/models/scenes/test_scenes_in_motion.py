"""Scenes that move, against their closed forms; orders measured where the step has an error."""

import math

import numpy as np
import pytest

from models.scenes import (
    BilliardBreak,
    Conveyor,
    DominoRow,
    EulersDisc,
    Hourglass,
    NewtonsCradle,
    Rattleback,
    RollingWheel,
    SlipToRoll,
    SphereBox,
    TippeTop,
    TumblingBox,
    Turntable,
    WreckingBall,
)
from nonsmooth.integrators.assembly.world import turned_back


def test_sliding_ball_rolls_with_five_sevenths_of_its_speed(simulate):
    model = SlipToRoll()
    ball = simulate(model, 1.0)["ball"]
    assert ball.velocity[-1, 0] == pytest.approx(model.rolling_speed(), rel=1e-12)
    rolls = ball.t[np.argmax(np.abs(ball.velocity[:, 0] - model.r * ball.spin[:, 1]) < 1e-9)]
    assert abs(rolls - model.rolls_at()) <= model.dt
    # the step in which it begins to roll is shared by both: at most the change of its acceleration dt^2/8
    way = [model.distance(t) for t in ball.t]
    assert np.abs(ball.position[:, 0] - way).max() <= model.mu * model.g * model.dt**2 / 8 * 1.01


@pytest.mark.parametrize("alpha", [0.3, 0.9])
def test_wheel_goes_down_as_it_rolls_or_slides(alpha, simulate):
    model = RollingWheel(alpha=alpha)
    wheel = simulate(model, 1.0)["wheel"]
    speed = np.linalg.norm(wheel.velocity, axis=1)
    np.testing.assert_allclose(speed, model.acceleration() * wheel.t, atol=1e-10)
    np.testing.assert_allclose(-wheel.spin, [model.spin(t) for t in wheel.t], atol=1e-9)


def circle_error(simulate, dt):
    model = Turntable()
    ball = simulate(model, dt=dt)["ball"]
    return np.abs(ball.position[:, :2] - [model.position(t) for t in ball.t]).max()


def test_ball_on_a_turntable_goes_round_at_two_sevenths_of_its_rate(simulate):
    errors = [circle_error(simulate, math.pi / steps) for steps in (800, 1600)]
    assert errors[1] < 2e-5
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)


@pytest.mark.parametrize("w_1, w_3", [(3.0, 2.0), (1.0, 6.0)])
def test_tumbling_box_follows_jacobi_to_second_order(w_1, w_3, simulate):
    model = TumblingBox(w_1=w_1, w_3=w_3)
    errors = []
    for dt in (1e-2, 5e-3):
        solution = simulate(model, 5.0, dt)
        found = turned_back(solution.turn[:, 0], solution.spin[:, 0])
        errors.append(np.abs(found - [model.angular_velocity(t) for t in solution.t]).max())
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05) and errors[1] < 5e-3


@pytest.mark.filterwarnings("ignore::nonsmooth.SimultaneousImpactWarning")  # what is asked holds for it too
@pytest.mark.parametrize("e", [1.0, 0.8])
@pytest.mark.parametrize("dim", [2, 3])
def test_cradle_with_spaces_passes_the_impact_on_and_without_is_hit_at_once(e, dim, simulate):
    for gap in (0.01, 0.0):
        model = NewtonsCradle(e=e, gap=gap, dim=dim)
        velocity = simulate(model, 0.5)
        balls = [velocity[f"ball {k}"].velocity[-1, 0] for k in range(model.n)]
        np.testing.assert_allclose(balls, model.velocities(), atol=1e-9)


@pytest.mark.filterwarnings("ignore::nonsmooth.SimultaneousImpactWarning")  # what is asked holds for it too
def test_cradle_is_hit_at_once_where_a_step_does_not_resolve_its_spaces(simulate):
    narrow = simulate(NewtonsCradle(gap=1e-9), 0.5).velocity[-1, 1:, 0]
    np.testing.assert_allclose(narrow, NewtonsCradle(gap=0.0).velocities(), atol=1e-9)


@pytest.mark.filterwarnings("ignore::nonsmooth.errors.ResidualWarning")
def test_wave_of_dominoes_has_the_speed_of_a_train_that_leans_without_friction(simulate):
    model = DominoRow()
    solution = simulate(model, 1.0)
    falls = [solution.t[np.argmax(-solution[f"domino {k}"].turn > 1e-3)] for k in range(model.n)]
    k = np.arange(18, model.n - 3)
    speed = np.polyfit(np.array(falls)[k], k * (model.s + model.d), 1)[0]
    # times are known to a step, 1/40 of that from one domino to the next, over 18 of them; first order in dt beside it
    assert speed == pytest.approx(model.wave_speed(), rel=5e-3)


def test_speed_of_dominoes_scales_as_the_root_of_their_height():
    one, four = DominoRow(), DominoRow(h=4 * 0.048, d=4 * 0.0075, s=4 * 0.0165)
    assert four.wave_speed() == pytest.approx(2 * one.wave_speed(), rel=1e-12)


@pytest.mark.upkeep
@pytest.mark.parametrize("r, l, n", [(0.35, 0.4, 8), (0.7, 0.8, 4)])
def test_wrecking_ball_comes_as_a_pendulum_the_more_so_the_lighter_its_chain(r, l, n, simulate):
    model = WreckingBall(r=r, l=l, n=n)
    solution = simulate(model)
    ball = solution["ball"]
    hit = np.argmax(np.abs(ball.velocity[:, 0] - ball.velocity[:, 0].max()) < 1e-12)  # the wall slows it down
    share = 1 - model.density * math.pi * r**2 * model.n * model.l / model.moments()[1]  # of the links in S
    assert abs(ball.t[hit] / model.hit_time() - 1) < 0.1 * share and 0.01 < share < 0.14
    assert abs(ball.velocity[hit, 0] / model.hit_speed() - 1) < 0.15 * share
    bricks = [solution[f"brick {k}"].position[-1] for k in range(model.courses)]
    assert sum(brick[0] > r + 0.5 for brick in bricks) >= model.courses - 2  # thrown off, all but the lowest
    assert solution.stats.missed == 0 and solution.stats.worst_joint_drift < 1e-5
    works = solution.ledger
    rest = works["kinetic"] - sum(works[name] for name in ("force", "friction", "normal", "surface"))
    assert np.ptp(rest) < 1e-12 * np.abs(works["force"]).max()  # some 4 roundings a step


def test_tippe_top_turns_over_and_keeps_jellett_s_integral(simulate):
    model = TippeTop()
    errors = []
    for dt in (4e-4, 2e-4):
        top = simulate(model, 1.5, dt)["top"]
        jellett = model.jellett(top.turn, top.spin)
        errors.append(np.abs(jellett / jellett[0] - 1).max())
    assert errors[1] < 1e-6 and errors[0] / errors[1] == pytest.approx(4.0, rel=0.2)
    assert model.turns_over() and model.axis(top.turn)[0, 2] > 0.9 and model.axis(top.turn)[-1, 2] < -0.7
    assert top.position[-1, 2] > model.r > top.position[0, 2]


def test_tippe_top_knows_where_its_mass_is(simulate):
    model = TippeTop()
    solution = simulate(model, model.dt)
    k = solution.names.index("top")
    assert solution.centres[k, 2] == pytest.approx(-model.eccentricity() * model.r, rel=1e-12)
    # what is kept is the energy with these moments
    A, C = model.moments()
    w_3 = model.spin * math.cos(model.tilt)
    kinetic = 0.5 * (A * (model.spin**2 - w_3**2) + C * w_3**2)
    assert solution.ledger["kinetic"][0] == pytest.approx(kinetic, rel=1e-12)


def test_parcels_take_the_speed_of_the_belt_where_they_should(simulate):
    model = Conveyor(n=2)
    solution = simulate(model, 1.0)
    for name in ("parcel 0", "parcel 1"):
        parcel = solution[name]
        assert parcel.velocity[-1, 0] == pytest.approx(model.v, abs=1e-9)
        way = parcel.position[-1, 0] - parcel.position[0, 0]
        exact = model.way() + model.v * (1.0 - model.carried_at())
        assert abs(way - exact) <= model.mu * model.g * model.dt**2 / 8 * 1.01


@pytest.mark.filterwarnings("ignore::nonsmooth.SimultaneousImpactWarning")  # what is asked holds for it too
def test_break_gains_no_energy_and_mirrors_itself(simulate):
    model = BilliardBreak(rows=3, mu_b=0.0)
    straight = simulate(model, 0.2, dt=2e-5, every=100)
    assert straight.ledger["kinetic"].max() <= model.energy() * (1 + 1e-9)
    aside = [simulate(BilliardBreak(rows=3, mu_b=0.0, aside=y), 0.12, dt=2e-5, every=100) for y in (0.01, -0.01)]
    triangle = model.triangle()
    partner = [int(np.argmin(np.abs(triangle - ball * (1, -1)).sum(axis=1))) for ball in triangle]
    for k, other in enumerate(partner):
        one, mirrored = (run[f"ball {b + 1}"].position for run, b in zip(aside, (k, other), strict=True))
        np.testing.assert_allclose(one * (1, -1, 1), mirrored, atol=1e-7)


@pytest.mark.filterwarnings("ignore::nonsmooth.errors.ResidualWarning")
def test_discs_run_through_the_hourglass_and_none_leaves_it(simulate):
    model = Hourglass(n=40, neck=6.0)
    solution = simulate(model, 1.5, tol=1e-4, every=10)
    assert model.passed(solution)[-1] == model.n
    assert (solution.position[:, 5:, 1] > -20 * model.r).all()


@pytest.mark.filterwarnings("ignore::nonsmooth.errors.ResidualWarning")
def test_spheres_end_in_their_box_with_their_weight_on_its_floor_and_walls(simulate):
    model = SphereBox(n=27)
    solution = simulate(model, 1.5, tol=1e-6)
    lasts = [solution.contacts(t) for t in solution.t[-100:]]
    carried = [contacts.P[contacts.i < 5, 2].sum() / model.dt for contacts in lasts]  # bodies 0 to 4 are the box
    assert np.mean(carried) == pytest.approx(model.weight(), rel=1e-3)
    assert solution.penetration.max() < 1e-3 * model.r


def test_eulers_disc_precesses_as_a_disc_that_rolls_on_its_rim(simulate):
    """Steadily at the rate of the closed form, to second order."""
    for tilt in (0.3, 0.1):
        model, errors = EulersDisc(tilt=tilt), []
        for dt in (1e-4, 5e-5):
            disc = simulate(model, 0.05, dt)["disc"]
            rate = abs(np.diff(model.azimuth(disc.turn)[[0, -1]])[0]) / 0.05
            errors.append(abs(rate / model.precession() - 1))
        assert errors[1] < 2e-5 and errors[1] < 0.3 * errors[0]
        assert np.abs(disc.position[:, :2]).max() < 1e-2 * model.r


def test_eulers_disc_turns_the_faster_the_flatter_it_lies(simulate):
    """Omega as alpha^(-1/2) of discs that lie ever flatter; at 1 ms none sinks by more than 2 % in 0.6 s."""
    tilts, rates = [0.15, 0.1, 0.05, 0.03], []
    for tilt in tilts:
        model = EulersDisc(tilt=tilt)
        disc = simulate(model, 0.6, 1e-3)["disc"]
        seen, azimuth = model.tilt_of(disc.turn), model.azimuth(disc.turn)
        assert seen[-1] == pytest.approx(tilt, rel=0.02)
        rates.append(abs(azimuth[-1] - azimuth[0]) / 0.6)
        assert rates[-1] == pytest.approx(model.precession(), rel=0.02)
    assert np.polyfit(np.log(np.sin(tilts)), np.log(rates), 1)[0] == pytest.approx(-0.5, abs=0.03)


@pytest.mark.parametrize("spin", [-5.0, 5.0])
@pytest.mark.parametrize("skew", [-0.3, 0.3])
def test_rattleback_reverses_one_way_only(simulate, spin, skew):
    model = Rattleback(spin=spin, skew=skew)
    turning = simulate(model, 4.0, every=20)["stone"].spin[:, 2]
    if model.reverses():
        assert turning[-1] * spin < -0.5 * spin**2
    else:
        assert np.abs(turning / spin - 1).max() < 0.02
