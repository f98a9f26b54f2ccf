"""Friction that differs by direction, against closed forms of statics and of slip along the normal of the ellipse."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import nonsmooth as ns

G = 10.0
ALONG, ACROSS = 0.2, 0.6
SMOOTH = ns.Material(mu=0.5)


def wood(direction=(1, 0, 0), along=ALONG, across=ACROSS, **own):
    return ns.Material(mu=ns.EllipticFriction(along, across, direction), **own)


def block(material, floor=SMOOTH, gravity=(0, 0, -G), velocity=(0, 0, 0), turn=None, spin=None, height=0.01):
    scene = ns.Scene(gravity=gravity, material=SMOOTH)
    scene.fixed(ns.HalfSpace((0, 0, 1)), material=floor, name="floor")
    scene.body(
        ns.Box(0.1, 0.1, height), mass=2.0, position=(0, 0, height / 2), velocity=velocity, turn=turn, spin=spin,
        material=material, name="block",
    )  # fmt: skip
    return scene


def run(scene, t_end, dt=1e-3, **options):
    return ns.simulate(scene, (0, t_end), integrator=ns.MoreauJean(dt=dt), **options)


def pulled(angle, size):
    """Gravity that pulls along the floor by a part of what presses."""
    return (size * G * math.cos(angle), size * G * math.sin(angle), -G)


def holds(angle):
    """The largest part that is held: on the ellipse."""
    return 1.0 / math.hypot(math.cos(angle) / ALONG, math.sin(angle) / ACROSS)


@pytest.mark.parametrize("angle", [0.0, 0.4, 1.2, math.pi / 2, 2.5])
def test_a_block_sticks_within_the_ellipse_and_slides_beyond_it(angle):
    for part in (1 - 1e-6, 1 + 1e-6):
        sol = run(block(wood(), gravity=pulled(angle, part * holds(angle))), 0.5)
        moved = np.linalg.norm(sol["block"].position[-1, :2])
        assert moved < 1e-13 if part < 1.0 else moved > 1e-8
        assert sol.stats.missed == 0


@pytest.mark.parametrize("angle", [0.3, 0.8, 1.4])
def test_it_slides_from_rest_straight_along_the_normal_of_the_ellipse(angle):
    """a (cos b, sin b) = f - friction, friction = (m_1^2 cos b, m_2^2 sin b)/sqrt(m_1^2 cos^2 b + m_2^2 sin^2 b) g."""
    size = 1.5 * holds(angle)

    def left(b):
        root = math.hypot(ALONG * math.cos(b), ACROSS * math.sin(b))
        rubs = np.array([ALONG**2 * math.cos(b), ACROSS**2 * math.sin(b)]) / root
        return G * (size * np.array([math.cos(angle), math.sin(angle)]) - rubs)

    b = brentq(lambda b: left(b) @ [-math.sin(b), math.cos(b)], 0.0, math.pi / 2, xtol=1e-14)
    sol = run(block(wood(), gravity=pulled(angle, size)), 0.3, dt=5e-3)
    np.testing.assert_allclose(sol["block"].velocity[-1, :2], 0.3 * left(b), rtol=1e-7)
    assert sol.ledger["friction"][-1] < 0.0 and sol.stats.missed == 0


def test_a_block_that_is_thrown_stops_along_a_power_law_to_first_order():
    """v_2 = v_1^(mu_2/mu_1)^2, with its energy in friction."""
    exact = solve_ivp(
        lambda t, v: -G * np.array([ALONG**2, ACROSS**2]) * v / math.hypot(ALONG * v[0], ACROSS * v[1]), (0, 0.15),
        [1.0, 1.0], rtol=1e-11, atol=1e-13,
    ).y[:, -1]  # fmt: skip
    assert exact[1] == pytest.approx(exact[0] ** 9, rel=1e-8)
    errors = []
    for dt in (1e-3, 5e-4, 2.5e-4):
        sol = run(block(wood(), velocity=(1, 1, 0)), 0.15, dt)
        errors.append(np.abs(sol["block"].velocity[-1, :2] - exact).max())
        assert sol.ledger["friction"][-1] == pytest.approx(sol.ledger["kinetic"][-1] - 2.0, rel=1e-10)
    assert abs(math.log2(errors[1] / errors[2]) - 1.0) < 0.1 and errors[-1] < 2e-3


def test_the_axes_go_with_the_body_that_has_them():
    """Turned by 90 degrees, the block slides along y as it did along x; a grain of the floor stays."""
    quarter = (math.cos(math.pi / 4), 0, 0, math.sin(math.pi / 4))
    for material, floor, mu in ((wood(), SMOOTH, ACROSS), (SMOOTH, wood(), ALONG), (wood((0, 3, 0)), SMOOTH, ALONG)):
        sol = run(block(material, floor, velocity=(1, 0, 0), turn=quarter), 0.1)
        np.testing.assert_allclose(sol["block"].velocity[-1], (1.0 - mu * G * 0.1, 0, 0), atol=1e-9)


def test_on_an_end_face_friction_is_that_across_and_between_it_is_of_the_tensor():
    for direction, mu in (((0, 0, 1), ACROSS), ((1, 0, 1), math.sqrt((ALONG**2 + ACROSS**2) / 2))):
        sol = run(block(wood(direction), velocity=(1, 0, 0)), 0.1)
        assert sol["block"].velocity[-1, 0] == pytest.approx(1.0 - mu * G * 0.1, rel=1e-9)


def test_an_ellipse_that_is_a_circle_is_the_round_cone():
    start, nearly = {"velocity": (1.0, 0.4, 0), "spin": (0, 0, 3.0)}, wood((1, 2, 0), 0.3, 0.3 * (1 + 1e-15))
    of_circle = run(block(ns.Material(mu=0.3), ns.Material(mu=0.3), **start), 0.3).position
    np.testing.assert_allclose(run(block(SMOOTH, nearly, **start), 0.3).position, of_circle, atol=1e-13)
    # rows that turn with the block lead to others of the loads with which four corners may bear it
    np.testing.assert_allclose(run(block(nearly, **start), 0.3).position, of_circle, atol=2e-6)


def test_contacts_are_recorded_along_the_world_and_slide_on_their_ellipse():
    scene = block(wood(), gravity=pulled(1.2, 1.5 * holds(1.2)))
    sol = run(scene, 0.1, record=("bodies", "contacts", "ledger", "pairs", "events"))
    last = sol.contacts(sol.t[-1])
    assert set(last.mode) == {ns.ContactMode.SLIDE} and len(last) == 4
    P = last.P.sum(axis=0) / (2.0 * G * 1e-3)
    assert P[2] == pytest.approx(1.0) and math.hypot(P[0] / ALONG, P[1] / ACROSS) == pytest.approx(1.0)
    np.testing.assert_allclose(last.mu, np.hypot(P[0], P[1]), rtol=1e-8)
    gained = sol["block"].velocity[-1] - 0.1 * np.array(scene.gravity)
    np.testing.assert_allclose(sol.pairs.total()[0].P, 2.0 * gained, atol=1e-12)
    held = run(block(wood(), gravity=pulled(1.2, 0.9 * holds(1.2))), 0.1, record=("bodies", "contacts"))
    assert set(held.contacts(0.1).mode) == {ns.ContactMode.STICK}


def test_what_sticks_sleeps_and_a_run_goes_on_with_the_same_bits(tmp_path):
    sol = run(block(wood(), gravity=pulled(0.4, 0.9 * holds(0.4))), 1.0)
    assert sol.stats.asleep > 900
    start = {"velocity": (1.0, 0.4, 0.5), "spin": (2.0, 1.0, 3.0), "height": 0.05}
    scene = block(wood(e=0.3), ns.Material(mu=0.5, e=0.3), **start)
    whole = run(scene, 0.6)
    assert whole.stats.impacts > 0 and whole.stats.missed == 0
    run(scene, 0.6, checkpoint=tmp_path / "run", max_steps=223, on_failure="return")
    resumed = run(scene, 0.6, checkpoint=tmp_path / "run", resume=tmp_path / "run")
    assert (resumed.position[-1] == whole.position[-1]).all()
    works = sum(whole.ledger[name] for name in ("force", "friction", "normal", "surface"))
    np.testing.assert_allclose(whole.ledger["kinetic"] - whole.ledger["kinetic"][0], works, atol=1e-11)


def test_spheres_roll_on_a_floor_with_a_grain():
    """Their islands lose the sweeps of round bodies: along the grain a ball slips longer, t = 2 v/(7 mu g)."""
    scene = ns.Scene(gravity=(0, 0, -G), material=SMOOTH)
    scene.fixed(ns.HalfSpace((0, 0, 1)), material=wood(), name="floor")
    for k, velocity in enumerate(((1, 0, 0), (0, 1, 0))):
        scene.body(ns.Sphere(0.1), mass=1.0, position=(k, 0, 0.1), velocity=velocity, name=f"ball {k}")
    sol = run(scene, 0.6)
    for k, mu in enumerate((ALONG, ACROSS)):
        speed = sol[f"ball {k}"].velocity[:, k]
        np.testing.assert_allclose(speed, np.maximum(1.0 - mu * G * sol.t, 5 / 7), atol=1e-9)
    assert sol.stats.missed == 0


def test_adaptive_steps_slide_on_the_ellipse_too():
    left = []
    for rtol in (1e-4, 1e-6):
        method = ns.Adaptive(rtol=rtol, atol=1e-2 * rtol)
        v = ns.simulate(block(wood(), velocity=(1, 1, 0)), (0, 0.15), integrator=method)["block"].velocity[-1]
        left.append(abs(v[1] - v[0] ** 9))
    assert left[1] < 0.15 * left[0] and left[1] < 1e-3


def test_where_it_has_no_place_it_is_refused():
    plane = ns.Scene(gravity=(0, -G))
    with pytest.raises(ns.InvalidInput, match="disc lies in the plane, where friction has one direction"):
        plane.body(ns.Disc(0.1), mass=1.0, material=wood(), name="disc")
    with pytest.raises(ns.InvalidInput, match="rub by unlike laws, which have no mean"):
        run(block(wood(), wood((0, 1, 0))), 0.1)
    with pytest.raises(ns.InvalidInput, match="rub by unlike laws, which have no mean"):
        run(block(wood(), ns.Material(mu=ns.Stribeck(0.3, 0.2, 0.1))), 0.1)
    scene = block(wood())
    with pytest.raises(ns.InvalidInput, match="springs of Penalty rub alike in all directions"):
        ns.simulate(scene, (0, 0.1), integrator=ns.Penalty(stiffness=1e5, damping=1.0))
    with pytest.raises(ns.InvalidInput, match="a material has EllipticFriction, which no system of a scene holds"):
        scene.system()
    named = block(wood(name="wood"), ns.Material(name="floor"))
    with pytest.raises(ns.InvalidInput, match="EllipticFriction goes with the axes of a body"):
        named.pair("wood", "floor", mu=ns.EllipticFriction(0.1, 0.2, (1, 0, 0)))
    mixed = block(wood(name="wood"), ns.Material(name="floor"))
    rubber = ns.Material(mu=ns.Stribeck(0.3, 0.2, 0.1), name="rubber")
    for k in range(2):
        mixed.body(ns.Sphere(0.1), mass=1.0, position=(k + 1, 0, 0.1), material=rubber)
    for other in ("wood", "floor"):
        mixed.pair("rubber", other, mu=0.3)
    with pytest.raises(ns.InvalidInput, match="laws of the sliding speed or EllipticFriction, and this one has both"):
        run(mixed, 0.1)


def test_a_pair_may_have_its_own_number():
    scene = block(wood(name="wood"), wood((0, 1, 0), name="floor"), velocity=(1, 0, 0))
    scene.pair("wood", "floor", mu=0.4)
    assert run(scene, 0.1)["block"].velocity[-1, 0] == pytest.approx(1.0 - 0.4 * G * 0.1, rel=1e-9)


def test_a_file_holds_it(tmp_path):
    scene = block(wood((1, 2, 0), name="wood"), velocity=(1, 0.5, 0))
    scene.save(tmp_path / "grain.toml")
    read = ns.Scene.load(tmp_path / "grain.toml")
    assert read["block"].material == scene["block"].material
    assert (run(read, 0.1).position == run(scene, 0.1).position).all()
