"""Laws of friction in scenes: closed forms of sliding bodies, and the same bodies as a System."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.mechanics.laws import Coulomb

G, V = 9.81, 2.0
M0, M1 = 0.5, 0.1


def sliding(law, dim=2, speed=V, tilt=0.0, **ground):
    """A box on a floor that is tilted against gravity; it slides in a direction of its own in space."""
    along = np.array([1.0, 0.0]) if dim == 2 else np.array([0.6, 0.8, 0.0])
    up = np.eye(dim)[-1]
    scene = ns.Scene(gravity=G * (math.sin(tilt) * along - math.cos(tilt) * up), material=ns.Material(mu=law))
    scene.fixed(ns.HalfPlane((0, 1)) if dim == 2 else ns.HalfSpace((0, 0, 1)), name="ground", **ground)
    sizes = (0.2, 0.02) if dim == 2 else (0.2, 0.2, 0.02)
    scene.body(ns.Box(*sizes), mass=1.0, position=0.01 * up, velocity=speed * along, name="box")
    return scene


def speed_of(sol):
    return np.linalg.norm(sol["box"].velocity, axis=1)


def slid(t):
    """v of v' = -g (m_0 - m_1 v), v(0) = V."""
    return M0 / M1 + (V - M0 / M1) * math.exp(G * M1 * t)


@pytest.mark.parametrize("dim", [2, 3])
def test_friction_that_falls_with_the_speed_brakes_to_second_order_as_its_closed_form(dim):
    end, steps = 0.3, np.array([1e-2, 5e-3, 2.5e-3])
    errors = np.array([
        abs(speed_of(ns.simulate(sliding(ns.Polynomial(M0, M1), dim), (0, end), integrator=ns.MoreauJean(dt)))[-1]
            - slid(end)) for dt in steps
    ])  # fmt: skip
    # midpoint rule: (m_1 g)^2 g (m_0 - m_1 V) t dt^2/12 at most e^(m_1 g t) times that
    assert (errors < (M1 * G) ** 2 * G * M0 * end * math.exp(M1 * G * end) * steps**2 / 12).all()
    np.testing.assert_allclose(np.log2(errors[:-1] / errors[1:]), 2.0, atol=0.05)


@pytest.mark.parametrize("dim", [2, 3])
def test_static_friction_holds_what_kinetic_friction_would_not(dim):
    mu_s, mu_k = 0.6, 0.3
    law = ns.StaticKinetic(mu_s, mu_k)
    tilt, end, dt = math.atan(0.45), 0.2, 1e-3
    held = ns.simulate(sliding(law, dim, 0.0, tilt), (0, end), integrator=ns.MoreauJean(dt))
    # contact problems of weight m g dt are solved to tol = 1e-8 of it in each of 200 steps
    assert speed_of(held).max() < 200 * 1e-8 * G * dt * 200
    pushed = ns.simulate(sliding(law, dim, 0.1, tilt), (0, end), integrator=ns.MoreauJean(dt))
    assert speed_of(pushed)[-1] == pytest.approx(0.1 + G * (math.sin(tilt) - mu_k * math.cos(tilt)) * end, rel=1e-6)
    steep = math.atan(0.65)
    broken = ns.simulate(sliding(law, dim, 0.0, steep), (0, end), integrator=ns.MoreauJean(dt))
    assert speed_of(broken)[-1] == pytest.approx(G * (math.sin(steep) - mu_k * math.cos(steep)) * end, rel=1e-6)


def test_what_came_to_rest_by_kinetic_friction_is_held_by_static_friction():
    mu_s, mu_k, tilt = 0.6, 0.3, -math.atan(0.45)  # it slides upwards, stops, and would slide back by mu_k alone
    scene = sliding(ns.StaticKinetic(mu_s, mu_k), 2, 1.0, tilt)
    sol = ns.simulate(scene, (0, 1.0), integrator=ns.MoreauJean(1e-3))
    deceleration = G * (math.sin(-tilt) + mu_k * math.cos(tilt))
    assert sol["box"].position[-1, 0] == pytest.approx(1.0 / (2 * deceleration), abs=1e-3)
    assert abs(sol["box"].velocity[-1, 0]) < 1e-8
    kinetic = ns.simulate(sliding(mu_k, 2, 1.0, tilt), (0, 1.0), integrator=ns.MoreauJean(1e-3))
    assert kinetic["box"].velocity[-1, 0] < -0.1


LAWS = [
    ns.Stribeck(0.6, 0.2, 0.5), ns.StaticKinetic(0.5, 0.3), ns.Polynomial(0.5, 0.2, 0.02), ns.Smoothed(0.4, 20.0, 0.05),
    ns.Friction(lambda v: 0.2 + 0.3 / (1.0 + v)),
]  # fmt: skip


@pytest.mark.upkeep
@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
def test_a_scene_with_a_law_moves_as_its_system_by_the_same_step(law):
    scene, dt, end = sliding(law, speed=1.0, surface_velocity=(0.3, 0.0)), 2e-3, 0.4
    by_steps = ns.simulate(scene, (0, end), integrator=ns.MoreauJean(dt))
    as_system = ns.simulate(scene.system(), (0, end), *scene.state(), integrator=ns.MoreauJean(dt))
    # both take mu at the mean velocity of the step; a scene solves it to tol = 1e-8 of an impulse m g dt, the friction
    # of the last slide and of static friction may begin a step apart
    apart = 1e-6 if not isinstance(law, ns.StaticKinetic) else 0.6 * G * dt
    np.testing.assert_allclose(by_steps["box"].velocity[:, 0], as_system.u[:, 0], atol=apart)
    located = ns.simulate(scene, (0, end), integrator=ns.EventDriven(rtol=1e-9))
    np.testing.assert_allclose(by_steps["box"].position[-1, 0], located["box"].position[-1, 0], atol=2e-4)


def test_a_box_on_a_belt_comes_to_ride_on_it_under_stribecks_law():
    scene = sliding(ns.Stribeck(0.5, 0.2, 0.3), speed=0.0, surface_velocity=(0.5, 0.0))
    sol = ns.simulate(scene, (0, 1.0), integrator=ns.MoreauJean(1e-3))
    assert sol["box"].velocity[-1, 0] == pytest.approx(0.5, abs=1e-7)
    assert (sol.contacts().mode == ns.ContactMode.STICK).all()


def test_a_law_of_ones_own_has_the_motion_of_the_same_law_built_in():
    own, known = (
        ns.simulate(sliding(law), (0, 0.3), integrator=ns.MoreauJean(1e-2))
        for law in (ns.Friction(lambda v: M0 - M1 * v), ns.Polynomial(M0, M1))
    )
    np.testing.assert_allclose(own.velocity, known.velocity, rtol=0, atol=1e-13)


def test_coulombs_law_as_an_object_has_the_bits_of_its_number():
    one, other = (ns.simulate(sliding(law), (0, 0.3), integrator=ns.MoreauJean(1e-2)) for law in (0.3, Coulomb(0.3)))
    np.testing.assert_array_equal(one.position, other.position)


def test_a_pair_of_materials_has_the_law_that_it_is_given():
    scene = ns.Scene(gravity=(0, -G))
    scene.fixed(ns.HalfPlane((0, 1)), material=ns.Material(mu=0.9, name="floor"), name="ground")
    felt = ns.Material(mu=ns.Stribeck(0.6, 0.2, 0.5), name="felt")
    scene.body(ns.Box(0.2, 0.02), mass=1.0, position=(0, 0.01), velocity=(V, 0), material=felt, name="box")
    with pytest.raises(
        ns.InvalidInput, match=r"rub by unlike laws, which have no mean; give both a name, and scene.pai"
    ):
        ns.simulate(scene, (0, 0.1), integrator=ns.MoreauJean(1e-3))
    scene.pair("floor", "felt", mu=ns.Polynomial(M0, M1))
    sol = ns.simulate(scene, (0, 0.3), integrator=ns.MoreauJean(1e-3))
    assert speed_of(sol)[-1] == pytest.approx(slid(0.3), abs=1e-6)


@pytest.mark.parametrize(
    ("law", "message"),
    [
        (ns.Stribeck("mu_s", 0.2, 0.5), "mu_s of a law of a material must be a number"),
        (ns.Friction(lambda v, p: p.mu), r"a law of a material is a function mu\(v\) of the speed"),
        (lambda v: 0.3, r"give the law of it, mu=ns.Friction"),
    ],
)
def test_laws_that_need_parameters_are_refused(law, message):
    with pytest.raises(ns.InvalidInput, match=message):
        ns.Material(mu=law)
    with pytest.raises(ns.InvalidInput, match=message):
        ns.Scene().pair("a", "b", mu=law)


def test_a_law_that_turns_negative_ends_the_run_with_the_bodies():
    with pytest.raises(ns.ModelFunctionError, match="the friction law of ground and box is negative") as failure:
        ns.simulate(sliding(ns.Polynomial(0.1, 0.2), tilt=0.8), (0, 1.0), integrator=ns.MoreauJean(1e-3))
    assert failure.value.solution["box"].velocity[-1, 0] == pytest.approx(V, abs=0.1)


def test_a_run_with_laws_goes_on_to_the_same_bits(tmp_path):
    scene, options = sliding(ns.StaticKinetic(0.6, 0.3), 2, 0.3), {"integrator": ns.MoreauJean(1e-3)}
    whole = ns.simulate(scene, (0, 0.2), **options)
    with pytest.raises(ns.BudgetSpent):
        ns.simulate(scene, (0, 0.2), checkpoint=tmp_path / "run", max_steps=70, **options)
    resumed = ns.simulate(scene, (0, 0.2), resume=tmp_path / "run", **options)
    np.testing.assert_array_equal(resumed.position, whole.position)
    np.testing.assert_array_equal(resumed.velocity, whole.velocity)
