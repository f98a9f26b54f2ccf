"""The motion of a scene between its records, and events of the user that are located on it."""

import math
import pickle

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.results.scene_motion import rate_of, spin_of, struck_bodies, vector_of
from nonsmooth.scenes.places import turn_by

G = 9.81


def thrown(dim=2, spin=None, height=1.0, e=0.0):
    scene = ns.Scene(gravity=-G * np.eye(dim)[-1], material=ns.Material(mu=0.0, e=e))
    shape = ns.Box(0.2, 0.1) if dim == 2 else ns.Box(0.3, 0.2, 0.1)
    velocity = [1.0, *[0.0] * (dim - 1)]
    scene.body(shape, mass=1.0, position=height * np.eye(dim)[-1], velocity=velocity, spin=spin, name="box")
    return scene


def test_a_thrown_body_is_on_its_parabola_at_any_time():
    sol = ns.simulate(thrown(spin=3.0), (0, 0.4), integrator=ns.MoreauJean(0.1))
    t = np.linspace(0, 0.4, 23)
    at = sol(t)["box"]
    np.testing.assert_allclose(at.position, np.stack((t, 1.0 - G * t**2 / 2), axis=1), atol=1e-14)
    np.testing.assert_allclose(at.velocity, np.stack((np.ones_like(t), -G * t), axis=1), atol=1e-13)
    np.testing.assert_allclose(at.turn, 3.0 * t, atol=1e-14)
    one = sol(0.25)
    assert one["box"].position.tolist() == sol([0.25])["box"].position[0].tolist() and one["box"].spin == pytest.approx(
        3.0, rel=1e-14
    )


def test_records_keep_their_digits():
    sol = ns.simulate(thrown(3, (5.0, 1.0, 2.0)), (0, 0.4), integrator=ns.MoreauJean(0.01))
    at = sol(sol.t)
    for name in ("position", "turn", "velocity", "spin"):
        np.testing.assert_array_equal(getattr(at, name), getattr(sol, name))


def test_a_turn_in_space_is_of_second_order_between_the_records_of_a_step_of_second_order():
    errors = []
    reference = ns.simulate(thrown(3, (5.0, 1.0, 2.0)), (0, 0.4), integrator=ns.MoreauJean(1e-4))
    for dt in (2e-2, 1e-2, 5e-3):
        sol = ns.simulate(thrown(3, (5.0, 1.0, 2.0)), (0, 0.4), integrator=ns.MoreauJean(dt))
        middles = sol.t[:-1] + 0.37 * np.diff(sol.t)
        turn, exact = sol(middles)["box"].turn, reference(middles)["box"].turn
        np.testing.assert_allclose(np.linalg.norm(turn, axis=1), 1.0, atol=1e-13)
        errors.append(np.abs(turn - exact).max())
        spin, exact = sol(middles)["box"].spin, reference(middles)["box"].spin
        assert np.abs(spin - exact).max() < 40 * dt**2 * 30  # (I_3 - I_1)/I omega^2 of the torque-free motion
    np.testing.assert_allclose(np.log2(np.array(errors[:-1]) / errors[1:]), 2.0, atol=0.2)


def test_rates_of_rotation_vectors_are_those_of_their_turns():
    rng, h = np.random.default_rng(3), 1e-5
    for size in (1e-9, 1e-5, 0.3, 2.0):
        phi, rate = size * rng.normal(size=3), rng.normal(size=3)
        first, last = turn_by(phi - h * rate), turn_by(phi + h * rate)
        product = 2.0 * (last[1:] * first[0] - first[1:] * last[0] - np.cross(last[1:], first[1:])) / (2 * h)
        np.testing.assert_allclose(spin_of(phi, rate), product, atol=1e-8)
        np.testing.assert_allclose(rate_of(phi, spin_of(phi, rate)), rate, rtol=1e-7)
        np.testing.assert_allclose(vector_of(turn_by(phi)), phi, rtol=1e-12)


def test_nothing_is_smoothed_over_an_impact():
    scene = thrown(e=0.8, height=0.3)
    scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    sol = ns.simulate(scene, (0, 0.6), integrator=ns.MoreauJean(0.01))
    t = np.linspace(0, 0.6, 1001)
    y, speed = sol(t)["box"].position[:, 1], sol(t)["box"].velocity[:, 1]
    # between records it never leaves what its ends and gravity allow: a cubic through the jump would dip below
    assert y.min() >= 0.05 - 1e-12
    landing = np.flatnonzero(np.diff(sol.velocity[:, 0, 1]) > 1.0)[0]
    inside = (t > sol.t[landing]) & (t < sol.t[landing + 1])
    way = np.diff(sol.position[landing : landing + 2, 0, 1]) / np.diff(sol.t[landing : landing + 2])
    np.testing.assert_allclose(speed[inside], way[0], rtol=1e-9, atol=1e-9)


def test_an_impact_reaches_what_is_loaded_or_joined_with_what_is_struck_and_no_further():
    moves = np.array([False, True, True, True, True, True])
    before = np.array([[0, 1], [0, 5]])
    after = np.array([[0, 1], [1, 2], [0, 5]])  # 2 lands on 1; 5 rests beside, on the ground too
    struck = struck_bodies(before, after, np.array([[2, 3]]), moves)
    assert struck.tolist() == [False, True, True, True, False, False]
    assert not struck_bodies(after, after, np.array([[2, 3]]), moves).any()


@pytest.mark.upkeep
def test_a_state_between_records_is_one_to_classify():
    scene = thrown(height=0.5)
    scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    sol = ns.simulate(scene, (0, 0.2), integrator=ns.MoreauJean(0.01))
    found = ns.classify(scene, state=sol(0.123))
    np.testing.assert_allclose(found.q, [0.123, 0.5 - G * 0.123**2 / 2, 0.0], atol=1e-13)
    assert found.mode == ("open",) * 4


@pytest.mark.parametrize("integrator", [ns.EventDriven(), ns.Adaptive()])
def test_a_run_by_the_system_is_known_between_its_records_as_that_is(integrator):
    scene = thrown(spin=3.0)
    sol = ns.simulate(scene, (0, 0.4), integrator=integrator, t_eval=[0.4])
    at = ns.simulate(scene, (0, 0.4), integrator=integrator)(0.123)["box"]
    np.testing.assert_allclose(at.position, [0.123, 1.0 - G * 0.123**2 / 2], rtol=1e-9)
    assert at.turn == pytest.approx(3.0 * 0.123, rel=1e-9) and sol.t.tolist() == [0.4]


def test_what_does_not_know_its_steps_says_so(tmp_path):
    scene = thrown()
    for options in ({"every": 2}, {"t_eval": [0.0, 0.3]}):
        with pytest.raises(ns.InvalidInput, match="not every step was recorded; run without every= and t_eval="):
            ns.simulate(scene, (0, 0.4), integrator=ns.MoreauJean(0.01), **options)(0.1)
    sol = ns.simulate(scene, (0, 0.4), integrator=ns.MoreauJean(0.01))
    with pytest.raises(ns.InvalidInput, match=r"t must lie in \[0, 0.4\] s"):
        sol(0.5)
    sol.save(tmp_path / "run.npz")
    with pytest.raises(ns.InvalidInput, match="give its scene to load"):
        ns.SceneSolution.load(tmp_path / "run.npz")(0.1)
    back = ns.SceneSolution.load(tmp_path / "run.npz", scene)
    assert back(0.123)["box"].position.tolist() == sol(0.123)["box"].position.tolist()
    assert "box" in pickle.loads(pickle.dumps(sol)).names
    with pytest.raises(ns.InvalidInput, match="contacts"):
        ns.simulate(scene, (0, 0.4), integrator=ns.MoreauJean(0.01), record="bodies")(0.1)


def height(t, bodies):
    return bodies["box"].position[1] - 0.7


@pytest.mark.parametrize("integrator", [ns.MoreauJean(0.05), ns.Penalty(1e5)])
def test_events_of_the_user_are_located_to_rounding_on_a_parabola(integrator):
    sol = ns.simulate(thrown(), (0, 0.4), integrator=integrator, events=height)
    assert sol.t_events[0] == pytest.approx([math.sqrt(2 * 0.3 / G)], rel=1e-9)


@pytest.mark.upkeep
def test_events_of_the_user_are_located_to_second_order_in_space():
    def upside_down(t, bodies):
        return bodies["box"].turn[0] - 0.5

    exact = ns.simulate(thrown(3, (5.0, 1.0, 2.0)), (0, 0.6), integrator=ns.MoreauJean(1e-4), events=upside_down)
    errors = [
        abs(ns.simulate(thrown(3, (5.0, 1.0, 2.0)), (0, 0.6), integrator=ns.MoreauJean(dt), events=upside_down
                        ).t_events[0][0] - exact.t_events[0][0])
        for dt in (2e-2, 1e-2)
    ]  # fmt: skip
    assert errors[0] / errors[1] == pytest.approx(4.0, abs=0.8)
