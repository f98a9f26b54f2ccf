"""Friction of guides and balls, in proportion to what they bear, against statics and closed forms."""

import math

import numpy as np
import pytest

import nonsmooth as ns

G = 9.81
HERE = (0.0, 0.0)


def run(scene, t_end, dt=5e-3, **options):
    return ns.simulate(scene, (0, t_end), integrator=ns.MoreauJean(dt=dt), **options)


def point(dim, x, y):
    return (x, y) if dim == 2 else (x, 0.0, y)


def ball(dim, r):
    return ns.Disc(r) if dim == 2 else ns.Sphere(r)


def guided(dim, friction, angle=0.0, gravity=G, aside=0.0, speed=0.0):
    """A block on a rail that is inclined, its centre of mass aside of the guide by some of the rail's normal."""
    scene = ns.Scene(gravity=point(dim, 0, -gravity))
    scene.fixed(ball(dim, 0.02), name="rail")
    along, up = point(dim, math.cos(angle), math.sin(angle)), point(dim, -math.sin(angle), math.cos(angle))
    scene.body(ball(dim, 0.1), mass=2.0, position=aside * np.array(up), velocity=speed * np.array(along), name="block")
    scene.slider("rail", "block", axis=along, at=point(dim, *HERE), friction=friction, name="way")
    return scene


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("length", [0.0, 0.3])
def test_a_block_on_an_inclined_guide_sticks_as_long_as_tan_alpha_is_below_mu(dim, length):
    alpha = 0.4
    for part in (1.0 + 1e-9, 1.0 - 1e-9):
        sol = run(guided(dim, ns.GuideFriction(part * math.tan(alpha), length), alpha), 1.0)
        travel = sol.joint("way").travel
        assert (travel == 0.0).all() if part > 1.0 else travel[-1] < 0.0
        assert sol.stats.missed == 0


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("length", [0.0, 0.3])
def test_a_block_on_an_inclined_guide_slides_with_the_acceleration_of_statics(dim, length):
    alpha, mu = 0.5, 0.3
    sol = run(guided(dim, ns.GuideFriction(mu, length), alpha), 1.0)
    a = G * (math.sin(alpha) - mu * math.cos(alpha))
    np.testing.assert_allclose(sol.joint("way").travel_rate, -a * sol.t, atol=1e-11)
    slid = -float(sol.joint("way").travel[-1])
    assert sol.ledger["friction"][-1] == pytest.approx(-mu * 2.0 * G * math.cos(alpha) * slid, rel=1e-9)
    assert sol.ledger["kinetic"][-1] == pytest.approx(sol.ledger["force"][-1] + sol.ledger["friction"][-1], rel=1e-9)


def accelerations(mu, h, pull, l, d):
    """Of a drawer of 2 kg with its mass at d, pulled at l from the middle of its guide: of all sliding states.

    f = mu 2 |M|/h,    M = pull (l - d) + f d,    2 a = pull - f > 0
    """
    found = []
    for sign in (1.0, -1.0):
        f = sign * 2 * mu / h * pull * (l - d) / (1.0 - sign * 2 * mu / h * d)
        if f >= 0.0 and sign * (pull * (l - d) + f * d) >= 0.0 and f < pull:
            found.append((pull - f) / 2.0)
    return found


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("aside", [0.0, 0.2, -0.1])
def test_a_drawer_jams_where_mu_is_h_over_2_l_however_hard_one_pulls(dim, aside):
    h, l = 0.4, 0.3
    for pull in (1e-3, 10.0, 1e5):
        for part in (0.5, 1.0 - 1e-7, 1.0 + 1e-7, 2.0):
            mu = part * h / (2 * l)
            scene = guided(dim, ns.GuideFriction(mu, h), gravity=0.0, aside=aside)
            scene.force("block", point(dim, pull, 0), at=point(dim, 0, l))
            sol = run(scene, 0.2)
            rate = sol.joint("way").travel_rate[-1] / 0.2
            if part < 1.0:
                (expected,) = accelerations(mu, h, pull, l, aside)
                assert rate == pytest.approx(expected, rel=1e-6)
            else:
                assert (sol.joint("way").travel == 0.0).all() and accelerations(mu, h, pull, l, aside) == []
            assert sol.stats.missed == 0


def test_a_guide_with_its_mass_far_aside_may_slide_or_jam():
    """Beyond mu = h/(2 d) friction makes more load than it needs: pulled from the side of the mass it slides, though it
    may jam; where the load of before jams it, it stays jammed as one pulls less far aside."""
    h, l, d, mu = 0.4, 0.3, 0.5, 0.7
    slides = guided(2, ns.GuideFriction(mu, h), gravity=0.0, aside=d)
    slides.force("block", (10.0, 0.0), at=(0, l))
    assert mu > h / (2 * l) and mu > h / (2 * d)
    rate = run(slides, 0.2).joint("way").travel_rate[-1] / 0.2
    assert min(abs(rate - a) for a in accelerations(mu, h, 10.0, l, d)) < 1e-9
    jammed = guided(2, ns.GuideFriction(mu, h), gravity=0.0, aside=d)
    jammed.force("block", lambda t, bodies: ((10.0, 0.0), -4.0) if t < 0.1 else ((10.0, 0.0), (d - l) * 10.0))
    assert (run(jammed, 0.2).joint("way").travel == 0.0).all()


def test_a_guide_sticks_without_creep_for_a_hundred_thousand_steps():
    scene = guided(2, ns.GuideFriction(0.5, 0.3), math.atan(0.4999))
    awake = ns.MoreauJean(1e-3, contacts=ns.ContactSolver(may_sleep=False))
    sol = ns.simulate(scene, (0, 100.0), integrator=awake, every=1000)
    assert (sol.joint("way").travel == 0.0).all() and sol.stats.steps == 100_000 and sol.stats.asleep == 0
    assert run(scene, 1.0, 1e-3).stats.asleep > 900


def test_what_a_guide_bears_in_space_are_the_forces_in_its_two_ends():
    """A load across the axis beyond one end, and a moment about the other axis: |N_1| + |N_2| by statics."""
    h, mu, force = 0.4, 0.2, np.array([0.0, 3.0, -5.0])
    scene = ns.Scene(gravity=(0, 0, 0))
    scene.fixed(ns.Sphere(0.02), name="rail")
    scene.body(ns.Sphere(0.1), mass=2.0, velocity=(4.0, 0, 0), name="block")
    scene.slider("rail", "block", axis=(1, 0, 0), friction=ns.GuideFriction(mu, h), name="way")
    torque = np.array([0.7, 1.0, 2.0])  # that about the axis presses nothing
    scene.force("block", lambda t, bodies: (force, torque))
    sol = run(scene, 0.5)
    couple = np.array([0.0, torque[2], -torque[1]]) / h  # +- at the ends, that holds the moment
    ends = np.linalg.norm(force / 2 + couple) + np.linalg.norm(force / 2 - couple)
    np.testing.assert_allclose(sol["block"].velocity[:, 0], 4.0 - mu * ends / 2.0 * sol.t, rtol=1e-10)


def test_a_guide_goes_on_from_a_checkpoint_with_the_same_bits(tmp_path):
    scene = guided(2, ns.GuideFriction(0.3, 0.2), 0.2, aside=0.15, speed=1.5)
    whole, place = run(scene, 1.0), tmp_path / "way"
    run(scene, 1.0, checkpoint=place, max_steps=97, on_failure="return")
    resumed = run(scene, 1.0, checkpoint=place, resume=place)
    assert (resumed.position[-1] == whole.position[-1]).all() and whole.stats.missed == 0


@pytest.mark.upkeep
@pytest.mark.filterwarnings("ignore::nonsmooth.errors.ResidualWarning")
@pytest.mark.parametrize("dim", [2, 3])
def test_chains_of_guides_pins_and_balls_find_their_loads_in_nearly_all_steps(dim):
    """Some have none, or several: such a step is counted as missed."""
    random, missed = np.random.default_rng(0), 0
    for _ in range(12):
        scene, place, before = ns.Scene(gravity=(*np.zeros(dim - 1), -G)), np.zeros(dim), "b"
        scene.fixed(ball(dim, 0.02), name="b")
        for k in range(5):
            way, axis = 0.2 * random.normal(size=dim), random.normal(size=dim)
            place, name = place + way, f"b{k}"
            scene.body(ball(dim, 0.1), mass=random.uniform(0.5, 2), position=place, name=name)
            at, pin = place - way / 2, ns.PinFriction(0.3, 0.02)
            guide = ns.GuideFriction(random.uniform(0.05, 0.3), random.uniform(0.2, 0.5))
            if k % 2 == 0:
                scene.slider(before, name, axis=axis, at=at, friction=guide)
            else:
                (scene.hinge if dim == 2 else scene.joint)(before, name, at=at, friction=pin)
            before = name
        scene.ignore(*scene.bodies)
        missed += run(scene, 0.5, 2e-3).stats.missed
    assert missed <= 12 * 250 // 1000


@pytest.mark.parametrize("azimuth", [0.0, 0.7])
def test_a_spherical_pendulum_rests_within_its_circle_of_friction_and_not_beyond(azimuth):
    friction = ns.PinFriction(mu=0.4, radius=0.05)
    for part in (1.0 - 1e-6, 1.0 + 1e-6):
        aside = part * 0.05 * math.sin(math.atan(0.4))
        scene = ns.Scene(gravity=(0, 0, -G))
        scene.fixed(ns.Sphere(0.02), name="hook")
        start = (aside * math.cos(azimuth), aside * math.sin(azimuth), -0.5)
        scene.body(ns.Sphere(0.1), mass=2.0, position=start, name="bob")
        scene.joint("hook", "bob", at=(0, 0, 0), friction=friction)
        sol = run(scene, 5.0)
        moved = np.linalg.norm(sol["bob"].position - start, axis=1).max()
        if part < 1.0:
            assert moved < 1e-12
        else:  # as an oscillator under dry friction: twice what is beyond
            assert moved == pytest.approx(2e-6 * aside, rel=0.01)
        assert sol.stats.missed == 0


def test_a_ball_that_swings_in_a_plane_is_a_pin():
    friction = ns.PinFriction(mu=0.4, radius=0.05)

    def swung(join):
        scene = ns.Scene(gravity=(0, 0, -G))
        scene.fixed(ns.Sphere(0.02), name="hook")
        scene.body(ns.Sphere(0.1), mass=2.0, position=(0.3, 0, -0.4), name="bob")
        join(scene)
        return run(scene, 3.0, 2e-3)

    ball = swung(lambda scene: scene.joint("hook", "bob", at=(0, 0, 0), friction=friction))
    pin = swung(lambda scene: scene.hinge("hook", "bob", at=(0, 0, 0), axis=(0, 1, 0), friction=friction))
    np.testing.assert_allclose(ball.position, pin.position, atol=1e-8)
    assert pin.ledger["friction"][-1] < -1.0 and ball.stats.missed == 0
    np.testing.assert_allclose(ball.ledger["friction"][-1], pin.ledger["friction"][-1], rtol=1e-8)


def test_friction_of_the_wrong_joint_is_refused():
    scene = ns.Scene()
    scene.fixed(ns.Disc(0.1), name="a")
    scene.body(ns.Disc(0.1), mass=1.0, name="b")
    pin, guide = ns.PinFriction(0.1, 0.1), ns.GuideFriction(0.1)
    with pytest.raises(ns.InvalidInput, match=r"friction of a joint in the plane is that of a pin; take scene.hinge"):
        scene.joint("a", "b", at=(0, 0), friction=pin)
    with pytest.raises(ns.InvalidInput, match=r"friction of s must be ns.GuideFriction\(mu=0.2, length=0.1\)"):
        scene.slider("a", "b", axis=(1, 0), friction=pin, name="s")
    with pytest.raises(ns.InvalidInput, match=r"friction of h must be ns.PinFriction"):
        scene.hinge("a", "b", at=(0, 0), friction=guide, name="h")
    scene.slider("a", "b", axis=(1, 0), friction=guide, name="s")
    with pytest.raises(ns.InvalidInput, match="a joint on springs has no set-valued law, and s has friction"):
        ns.simulate(scene, (0, 1), integrator=ns.Penalty(stiffness=1e4, damping=1.0))
    pinned = ns.Scene(gravity=(0, -G))
    pinned.fixed(ns.Disc(0.1), name="a")
    pinned.body(ns.Disc(0.1), mass=1.0, name="b")
    pinned.hinge("a", "b", at=(0, 0), friction=pin, name="h")
    with pytest.raises(ns.InvalidInput, match="friction"):
        pinned.system()


def test_a_file_holds_the_friction_of_guides_and_balls(tmp_path):
    scene = guided(3, ns.GuideFriction(0.3, 0.2), 0.2, speed=1.5)
    scene.body(ns.Sphere(0.1), mass=1.0, position=(2.0, 0, 0), name="bob")
    scene.joint("rail", "bob", at=(1.5, 0, 0), friction=ns.PinFriction(0.2, 0.01))
    scene.save(tmp_path / "way.toml")
    read = ns.Scene.load(tmp_path / "way.toml")
    assert [joint.friction for joint in read.joints] == [joint.friction for joint in scene.joints]
    assert (run(read, 0.2).position == run(scene, 0.2).position).all()
