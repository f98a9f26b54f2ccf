"""Adhesion of contacts, 0 <= g_N _|_ P_N + F dt >= 0, against statics and closed forms."""

import math

import numpy as np
import pytest

import nonsmooth as ns

G = 9.81


def run(scene, t_end, dt=2e-3, **options):
    return ns.simulate(scene, (0, t_end), integrator=ns.MoreauJean(dt=dt), **options)


def point(dim, x, y):
    return (x, y) if dim == 2 else (x, 0.0, y)


def ball(dim, r):
    return ns.Disc(r) if dim == 2 else ns.Sphere(r)


def half_space(dim, x, y):
    return ns.HalfPlane((x, y)) if dim == 2 else ns.HalfSpace((x, 0, y))


def box(dim, width, height):
    return ns.Box(width, height) if dim == 2 else ns.Box(width, 0.3, height)


def hanging(dim, adhesion, speed=0.0, mu=0.5):
    """A ball of 2 kg at a ceiling."""
    scene = ns.Scene(gravity=point(dim, 0, -G), material=ns.Material(mu=mu, adhesion=adhesion))
    scene.fixed(half_space(dim, 0, -1), name="ceiling")
    scene.body(ball(dim, 0.1), mass=2.0, position=point(dim, 0, -0.1), velocity=point(dim, speed, 0), name="ball")
    return scene


def gained(sol):
    works = sum(sol.ledger[name] for name in ("force", "friction", "normal", "surface"))
    return np.abs(sol.ledger["kinetic"] - sol.ledger["kinetic"][0] - works).max()


@pytest.mark.parametrize("dim", [2, 3])
def test_a_ball_hangs_from_the_ceiling_as_long_as_it_adheres_by_more_than_its_weight(dim):
    sol = run(hanging(dim, (1 + 1e-9) * 2.0 * G), 2.0, record=("bodies", "contacts", "ledger"))
    assert np.abs(sol["ball"].position[:, -1] + 0.1).max() < 1e-14 and sol.stats.missed == 0
    sol = run(hanging(dim, (1 - 1e-6) * 2.0 * G), 0.5)
    late = np.maximum(sol.t - sol.t[1], 0.0)  # in the first step its pull is as large as the weight
    np.testing.assert_allclose(sol["ball"].position[:, -1], -0.1 - G / 2 * late**2, atol=1e-6)
    assert abs(sol.ledger["normal"][-1]) < 1e-8 and gained(sol) < 1e-12


@pytest.mark.parametrize("dim", [2, 3])
def test_contacts_record_what_friction_is_of_and_pairs_what_bodies_exchange(dim):
    sol = run(hanging(dim, 50.0), 0.1, record=("bodies", "contacts", "ledger", "pairs", "events"))
    last = sol.contacts(sol.t[-1])
    np.testing.assert_allclose(last.P_N, (50.0 - 2.0 * G) * 2e-3, rtol=1e-12)
    assert list(last.mode) == [ns.ContactMode.STICK] and len(sol.events) == 0
    (total,) = sol.pairs.total()
    np.testing.assert_allclose(total.P, point(dim, 0, 2.0 * G * 0.1), atol=1e-12)


@pytest.mark.parametrize("dim", [2, 3])
def test_it_slides_along_the_ceiling_by_friction_of_what_holds_it(dim):
    """|a| = mu (F/m - g), until it rolls with 2/3 v, 5/7 v in space."""
    sol = run(hanging(dim, 50.0, speed=1.0), 1.0)
    a, rolls = 0.5 * (25.0 - G), 2 / 3 if dim == 2 else 5 / 7
    np.testing.assert_allclose(sol["ball"].velocity[:, 0], np.maximum(1.0 - a * sol.t, rolls), atol=1e-10)
    assert sol.stats.missed == 0 and gained(sol) < 1e-12


@pytest.mark.parametrize("dim", [2, 3])
def test_it_is_torn_off_when_the_pull_is_above_f(dim):
    scene, dt = hanging(dim, 50.0), 2e-3
    scene.force("ball", lambda t, bodies: point(dim, 0, -60.0 * t))
    sol = run(scene, 0.8, dt)
    left = float(sol.t[np.argmax(sol["ball"].position[:, -1] < -0.1 - 1e-9)])
    assert abs(left - (50.0 - 2.0 * G) / 60.0) <= 2 * dt
    tau = 0.8 - (50.0 - 2.0 * G) / 60.0  # from then on it falls, by 25 m/s^2 to begin with
    assert sol["ball"].velocity[-1, -1] == pytest.approx(-(25.0 * tau + 15.0 * tau**2), abs=2 * 25.0 * dt)


@pytest.mark.parametrize("dim, points", [(2, 2), (3, 4)])
@pytest.mark.parametrize("width, height, mu", [(0.05, 0.4, 0.5), (0.4, 0.4, 2.0)])
def test_a_block_stays_on_a_wall_where_neither_friction_nor_its_upper_corners_give_way(dim, points, width, height, mu):
    """n mu F = m g of n corners; m g a/2 = n/2 F b of the upper ones."""
    slides, peels = G / (mu * points), G * (width / 2) / height / (points / 2)
    for part in (1.0 + 1e-6, 0.99):
        material = ns.Material(mu=mu, adhesion=part * max(slides, peels))
        scene = ns.Scene(gravity=point(dim, 0, -G), material=material)
        scene.fixed(half_space(dim, 1, 0), name="wall")
        scene.body(box(dim, width, height), mass=1.0, position=point(dim, width / 2, 0), name="block")
        sol = run(scene, 1.0)
        fell = -sol["block"].position[-1, -1]
        if part > 1.0:
            assert abs(fell) < 1e-12
        elif slides > peels:
            assert fell == pytest.approx(0.01 * G / 2, rel=1e-9) and (sol["block"].spin == 0.0).all()
        else:
            assert fell > 1.0
        assert sol.stats.missed == 0


@pytest.mark.parametrize("dim, points", [(2, 2), (3, 4)])
def test_without_weight_friction_is_mu_f(dim, points):
    scene = ns.Scene(gravity=point(dim, 0, 0), material=ns.Material(mu=0.5, adhesion=3.0))
    scene.fixed(half_space(dim, 0, 1), name="floor")
    scene.body(box(dim, 0.4, 0.01), mass=2.0, position=point(dim, 0, 0.005), velocity=point(dim, 2, 0), name="plate")
    sol = run(scene, 2.0)
    slowing = points * 0.5 * 3.0 / 2.0
    np.testing.assert_allclose(sol["plate"].velocity[:, 0], np.maximum(2.0 - slowing * sol.t, 0.0), atol=1e-10)
    assert sol.ledger["friction"][-1] == pytest.approx(-4.0, rel=1e-9)


@pytest.mark.parametrize("part", [0.998, 1.002])
def test_a_disc_that_slides_about_a_drum_is_held_by_its_centripetal_force(part):
    """F = m v^2/(R + r): beyond it goes on along the tangent."""
    R, r, v = 0.3, 0.1, 1.0
    scene = ns.Scene(gravity=(0, 0), material=ns.Material(mu=0.0, adhesion=part * v**2 / (R + r)))
    scene.fixed(ns.Disc(R), name="drum")
    scene.body(ns.Disc(r), mass=1.0, position=(0, R + r), velocity=(v, 0), name="disc")
    sol = run(scene, 2.0)
    way = np.linalg.norm(sol["disc"].position, axis=1) - R - r
    if part > 1.0:
        assert np.abs(way).max() < 1e-6
        assert np.linalg.norm(sol["disc"].velocity[-1]) == pytest.approx(v, rel=1e-6)
    else:
        assert way[-1] == pytest.approx(math.hypot(R + r, 2.0 * v) - R - r, rel=1e-2)


def test_two_discs_that_turn_about_one_another_hold_together():
    r, omega = 0.1, 5.0
    for part in (0.99, 1.01):
        scene = ns.Scene(gravity=(0, 0), material=ns.Material(mu=0.5, adhesion=part * omega**2 * r))
        for side in (1, -1):
            scene.body(ns.Disc(r), mass=1.0, position=(side * r, 0), velocity=(0, side * omega * r), spin=omega)
        sol = run(scene, 3.0)
        apart = np.linalg.norm(sol.position[:, 0] - sol.position[:, 1], axis=1) - 2 * r
        assert np.abs(apart).max() < 1e-6 if part > 1.0 else apart[-1] > 2.5
        assert gained(sol) < 1e-12


def test_adaptive_steps_hold_it_too():
    sol = ns.simulate(hanging(2, 1.001 * 2.0 * G), (0, 1.0), integrator=ns.Adaptive(rtol=1e-6, atol=1e-8))
    assert np.abs(sol["ball"].position[:, 1] + 0.1).max() < 1e-12


def test_discs_that_adhere_stand_in_a_column_that_hangs():
    """The upmost bears all: n m g <= F."""
    for part in (1.0 + 1e-6, 0.999):
        scene = ns.Scene(gravity=(0, -G), material=ns.Material(mu=0.3, adhesion=part * 6 * 0.5 * G))
        scene.fixed(ns.HalfPlane((0, -1)), name="ceiling")
        for k in range(6):
            scene.body(ns.Disc(0.1), mass=0.5, position=(0, -0.1 - 0.2 * k))
        sol = run(scene, 0.4)
        fell = sol.position[0, 1:, 1] - sol.position[-1, 1:, 1]
        assert np.abs(fell).max() < 1e-12 if part > 1.0 else fell.min() > 0.7
        assert sol.stats.missed == 0


def test_a_heap_that_adheres_is_solved_and_its_run_resumed(tmp_path):
    scene = ns.Scene(gravity=(0, -G), material=ns.Material(mu=0.4, e=0.2, adhesion=2.0))
    for normal, offset in (((0, 1), 0.0), ((1, 0), 0.0), ((-1, 0), -0.9)):
        scene.fixed(ns.HalfPlane(normal, offset))
    random = np.random.default_rng(3)
    for k in range(20):
        place = 0.1 + 0.17 * (k % 5) + 0.01 * random.random(), 0.1 + 0.2 * (k // 5)
        scene.body(ns.Disc(0.08), mass=0.5, position=place)
    whole = run(scene, 0.8)
    assert whole.stats.missed == 0 and whole.stats.worst_residual < 1e-8 and whole.stats.asleep == 0
    assert gained(whole) < 1e-9
    run(scene, 0.8, checkpoint=tmp_path / "run", max_steps=223, on_failure="return")
    resumed = run(scene, 0.8, checkpoint=tmp_path / "run", resume=tmp_path / "run")
    assert (resumed.position[-1] == whole.position[-1]).all()
    assert (run(scene, 0.8, threads=2).position == whole.position).all()


def test_methods_that_have_no_adhesion_say_so():
    scene, springs = hanging(2, 30.0), ns.Compliance(stiffness=1e5, damping=1.0)
    for method, said in (
        (ns.Penalty(stiffness=1e5, damping=1.0), "Penalty has springs that push"),
        (ns.MoreauJean(1e-3, theta=1.0, compliance=springs), "MoreauJean with compliance="),
        (ns.EventDriven(), "a material has adhesion, which no system of a scene holds"),
    ):
        with pytest.raises(ns.InvalidInput, match=said):
            ns.simulate(scene, (0, 0.1), integrator=method)
    with pytest.raises(ns.InvalidInput, match="a material has adhesion, which no system of a scene holds"):
        scene.system()


def test_a_file_and_a_pair_hold_the_adhesion(tmp_path):
    scene = ns.Scene(gravity=(0, -G), material=ns.Material(name="tape", adhesion=20.0))
    felt = ns.Material(name="felt", adhesion=5.0)
    scene.fixed(ns.HalfPlane((0, -1)), name="ceiling")
    scene.body(ns.Disc(0.1), mass=1.0, position=(0, -0.1), material=felt, name="ball")
    scene.save(tmp_path / "one.toml")
    one = ns.Scene.load(tmp_path / "one.toml")
    assert one["ball"].material == felt
    assert run(one, 0.1)["ball"].position[-1, 1] == -0.1  # sqrt(5 * 20) N hold 9.81 N
    scene.pair("tape", "felt", adhesion=9.0)
    scene.save(tmp_path / "two.toml")
    two = ns.Scene.load(tmp_path / "two.toml")
    assert two.resistances == scene.resistances == {frozenset(("tape", "felt")): {"adhesion": 9.0}}
    assert run(two, 0.1)["ball"].position[-1, 1] < -0.11
