"""Ropes, distances, and limits of joints that rebound, against closed forms and invariants."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns

G = 10.0


def run(scene, t_end, dt, **options):
    sol = ns.simulate(scene, (0, t_end), integrator=ns.MoreauJean(dt=dt), **options)
    assert sol.stats.missed == 0
    return sol


def point(dim, x, y):
    return (x, y) if dim == 2 else (x, 0.0, y)


def ball(dim, r):
    return ns.Disc(r) if dim == 2 else ns.Sphere(r)


def hooked(dim, gravity=G):
    scene = ns.Scene(gravity=point(dim, 0, -gravity))
    scene.fixed(ball(dim, 0.01), name="hook")
    return scene


def bob(scene, x, y, v_x=0.0, v_y=0.0, name="bob", mass=2.0):
    return scene.body(
        ball(scene.dim, 0.05), mass=mass, position=point(scene.dim, x, y), velocity=point(scene.dim, v_x, v_y),
        name=name,
    )  # fmt: skip


def order(errors):
    return math.log2(errors[-2] / errors[-1])


# --- ropes


@pytest.mark.upkeep
@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
def test_a_mass_falls_into_its_rope_and_rebounds_to_e_squared_of_its_height(dim, e):
    scene, dt = hooked(dim), 1e-3
    bob(scene, 0, -0.2)
    scene.rope("hook", "bob", length=1.0, e=e, name="rope")
    sol = run(scene, 3.0, dt)
    height, rope = 1.0 + sol["bob"].position[:, -1], sol.joint("rope")
    assert height.min() > -1e-12
    inside = (height[1:-1] >= height[:-2]) & (height[1:-1] > height[2:]) & (height[1:-1] > 1e-3)
    peaks = height[1:-1][inside]
    exact = [0.8 * e ** (2 * k) for k in range(1, 1 + len(peaks))]
    np.testing.assert_allclose(peaks, exact, atol=G * dt**2)
    assert len(peaks) == {0.0: 0, 0.5: 4, 1.0: 3}[e]
    falls = math.sqrt(1.6 / G)
    if e == 1.0:
        np.testing.assert_allclose(sol.t[1:-1][inside], falls * np.array([2, 4, 6]), atol=2 * dt)
    else:
        assert rope.at_limit[-1] == 1 and sol.stats.asleep > 500  # it hangs still
        np.testing.assert_allclose(rope.P[-1] / dt, point(dim, 0, 2.0 * G), atol=1e-9)
    np.testing.assert_allclose(rope.distance, 1.0 - height)
    np.testing.assert_allclose(rope.distance_rate, -sol["bob"].velocity[:, -1], atol=1e-12)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("e", [0.0, 0.4])
def test_two_bodies_that_fly_apart_are_caught_by_their_rope(dim, e):
    scene = ns.Scene(gravity=point(dim, 0, 0))
    bob(scene, 0, 0, v_x=-1.0, name="a", mass=1.0)
    bob(scene, 0.5, 0, v_x=2.0, name="b", mass=3.0)
    scene.rope("a", "b", length=1.1, e=e, name="rope")
    sol = run(scene, 1.0, 1e-2)
    v, V = sol.velocity[-1, :, 0], (3.0 * 2.0 - 1.0) / 4.0
    np.testing.assert_allclose(v, [V + e * 3.0 * 0.75, V - e * 3.0 * 0.25], atol=1e-12)
    assert sol.joint("rope").distance.max() < 1.1 + 1e-12
    np.testing.assert_allclose(sol.velocity[:, :, 0] @ [1.0, 3.0], 5.0, atol=1e-12)
    lost = 0.5 * 0.75 * 9.0 * (1 - e**2)  # reduced mass 3/4, 3 m/s apart
    assert sol.ledger["kinetic"][0] - sol.ledger["kinetic"][-1] == pytest.approx(lost, abs=1e-12)
    assert sol.ledger["normal"][-1] == pytest.approx(-lost, abs=1e-12)


def swinging(kind, dim=2, v=3.0, angle=0.0):
    scene = hooked(dim)
    s, c = math.sin(angle), math.cos(angle)
    bob(scene, s, -c, v * c, v * s)
    getattr(scene, kind)("hook", "bob", name="tie")
    return scene


@pytest.mark.parametrize("kind", ["rope", "distance"])
@pytest.mark.parametrize("dim", [2, 3])
def test_a_bob_swings_on_a_taut_rope_and_on_a_rod_to_second_order(kind, dim):
    exact = solve_ivp(lambda t, y: [y[1], -G * math.sin(y[0])], (0, 1.5), [0, 3.0], rtol=1e-11, atol=1e-12).y[0, -1]
    errors = []
    for dt in (4e-3, 2e-3):
        sol = run(swinging(kind, dim), 1.5, dt)
        x = sol["bob"].position[-1]
        errors.append(abs(math.atan2(x[0], -x[-1]) - exact))
        length = sol.joint("tie").distance
        assert np.abs(length - 1.0).max() < (1e-10 if kind == "distance" else 60 * dt**3)
        E = sol.ledger["kinetic"] + sol.ledger["potential"]
        assert np.abs(E - E[0]).max() < 100 * dt**2
    assert abs(order(errors) - 2) < 0.2 and errors[-1] < 1e-4


def test_a_rope_goes_slack_where_the_weight_is_all_that_its_circle_needs():
    """From the lowest point with v^2 = 3.5 g l it leaves the circle at cos(angle from the top) = (v^2/(g l) - 2)/3."""
    v = math.sqrt(3.5 * G)
    above = math.acos(0.5)
    found = []
    for dt in (2e-3, 1e-3):
        sol = run(swinging("rope", v=v), 0.9, dt)
        x, slack = sol["bob"].position, sol.joint("tie").distance < 1.0 - 1e-5
        k = int(np.argmax(slack))
        assert not slack[:k].any() and slack[k : k + 50].all()
        found.append(abs(math.atan2(x[k, 0], x[k, 1]) - above))
        speed = math.sqrt(G * math.cos(above))  # it flies on from there
        start = np.array([math.sin(above), math.cos(above)])
        velocity = speed * np.array([-math.cos(above), math.sin(above)])
        t = sol.t[k : k + 50, None] - sol.t[k]
        flown = x[k] + velocity * t + 0.5 * np.array([0, -G]) * t**2
        assert np.abs(x[k : k + 50] - flown).max() < 60 * dt and np.linalg.norm(x[k] - start) < 30 * dt
    assert found[1] < 0.03


def test_a_slack_rope_is_not_there_and_its_bodies_touch():
    def thrown(has_rope):
        scene = hooked(2)
        scene.fixed(ns.HalfPlane((0, 1)), position=(0, -1), name="ground")
        bob(scene, 0.3, 0.2, 0.4, 1.0)
        bob(scene, 0.3, 0.5, 0.0, -1.0, name="other")
        if has_rope:
            scene.rope("bob", "other", length=5.0)
            scene.rope("hook", "bob", length=6.0)
        return run(scene, 1.0, 2e-3)

    with_rope, without = thrown(True), thrown(False)
    assert (with_rope.position == without.position).all() and with_rope.stats.contacts == without.stats.contacts
    assert (with_rope.joint_impulses == 0.0).all()


@pytest.mark.parametrize("dim", [2, 3])
def test_ropes_off_the_centre_turn_a_body_and_hold_it_level_by_statics(dim):
    scene, dt = ns.Scene(gravity=point(dim, 0, -G)), 2e-3
    scene.fixed(ball(dim, 0.01), position=point(dim, 0, 2), name="ceiling")
    box = ns.Box(1.0, 0.1) if dim == 2 else ns.Box(1.0, 0.4, 0.1)
    scene.body(box, mass=3.0, position=point(dim, 0, 0), name="swing")
    for k, x in enumerate((-0.5, 0.2)):
        if dim == 2:
            scene.rope("ceiling", "swing", at_a=(x, 2), at_b=(x, 0.05), name=f"{k}")
        else:
            for side in (-0.2, 0.2):
                scene.rope("ceiling", "swing", at_a=(x, side, 2), at_b=(x, side, 0.05), name=f"{k} {side}")
    sol = run(scene, 1.0, dt)
    assert np.abs(sol["swing"].position - sol["swing"].position[0]).max() < 1e-10
    for k, share in enumerate((0.2 / 0.7, 0.5 / 0.7)):
        names = [name for name in sol.joint_names if name.startswith(f"{k}")]
        pull = sum(sol.joint(name).P[-1, -1] for name in names) / dt
        assert pull == pytest.approx(30.0 * share, rel=1e-7)


# --- distances


def test_two_bodies_on_a_rod_keep_their_momenta_and_their_distance():
    turns = []
    for dt in (2e-3, 1e-3):
        scene = ns.Scene(gravity=(0, 0, 0))
        box, I = ns.Box(0.2, 0.3, 0.4), np.array([0.1, 0.08, 0.05])
        scene.body(box, mass=1.0, inertia=I, spin=(1.0, -2.0, 3.0), name="a")
        scene.body(
            box, mass=2.0, inertia=2 * I, position=(1, 0.5, 0), spin=(3, -1, 2), velocity=(0, 1.2, -0.6), name="b"
        )
        scene.distance("a", "b", at_a=(0.1, 0.1, 0.2), at_b=(0.9, 0.4, 0.1), name="rod")
        sol = run(scene, 2.0, dt)
        assert np.ptp(sol.joint("rod").distance) < 1e-10 and sol.stats.worst_joint_drift < 1e-10
        momentum = np.einsum("b,tbk->tk", [1.0, 2.0], sol.velocity)
        assert np.abs(momentum - momentum[0]).max() < 1e-12
        E = sol.ledger["kinetic"]
        turns.append(np.abs(E[1:] - E[1]).max())
    assert order(turns) > 1.7 and turns[-1] < 1e-4


# --- limits that rebound


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("e", [0.3, 1.0])
def test_a_hinge_without_weight_turns_back_from_its_stops_at_e_of_its_rate(dim, e):
    scene = hooked(dim, gravity=0.0)
    bar = ns.Box(1.0, 0.05) if dim == 2 else ns.Box(1.0, 0.2, 0.05)
    scene.body(
        bar, mass=2.0, position=point(dim, 0.5, 0), velocity=point(dim, 0, 1.0),
        spin=2.0 if dim == 2 else (0, -2.0, 0), name="bar",
    )  # fmt: skip
    axis = {} if dim == 2 else {"axis": (0, -1, 0)}
    scene.hinge("hook", "bar", at=point(dim, 0, 0), limits=(-0.4, 0.6), e=e, name="hinge", **axis)
    sol = run(scene, 1.7 if e == 1.0 else 2.0, 1e-3)
    hinge, t = sol.joint("hinge"), sol.t
    first, second = 0.3, 0.3 + 1.0 / (2.0 * e)
    exact = np.where(t < first, 2.0 * t, 0.6 - 2.0 * e * (t - first))
    if e == 1.0:
        exact = np.where(t < second, exact, -0.4 + 2.0 * (t - second))
        exact = np.where(t < second + 0.5, exact, 0.6 - 2.0 * (t - second - 0.5))
    else:
        exact = np.where(t < second, exact, -0.4 + 2.0 * e**2 * (t - second))
    np.testing.assert_allclose(hinge.angle, exact, atol=3e-5)
    assert hinge.angle.max() < 0.6 + 1e-9 and hinge.angle.min() > -0.4 - 1e-9


@pytest.mark.parametrize("dim", [2, 3])
def test_a_cart_falls_on_its_stop_and_rebounds_as_a_ball_does(dim):
    """Until it rests: after (1 + e)/(1 - e) times the time of its fall."""
    scene, e = hooked(dim), 0.5
    bob(scene, 0, 0)
    scene.slider("hook", "bob", axis=point(dim, 0, 1), limits=(-0.8, np.inf), e=e, name="way")
    sol = run(scene, 2.0, 1e-3)
    travel, falls = sol.joint("way").travel, math.sqrt(1.6 / G)
    np.testing.assert_allclose(travel[sol.t > 3 * falls + 0.01], -0.8, atol=1e-9)
    between = (sol.t > falls) & (sol.t < falls + 2 * e * falls)
    t = sol.t[between] - falls
    np.testing.assert_allclose(travel[between], -0.8 + e * G * falls * t - 0.5 * G * t**2, atol=1e-6)


def test_a_cylindrical_joint_and_a_slot_rebound_too():
    scene = ns.Scene(gravity=(0, 0, 0))
    scene.fixed(ns.Sphere(0.01), name="hook")
    scene.body(ns.Sphere(0.1), mass=1.0, velocity=(0, 0, 1.0), spin=(0, 0, 2.0), name="nut")
    scene.cylindrical(
        "hook", "nut", at=(0, 0, 0), axis=(0, 0, 1), limits=(-1, 0.3), angle_limits=(-1, 0.4), e=0.5, name="screw"
    )
    sol = run(scene, 0.6, 1e-3)
    np.testing.assert_allclose(sol["nut"].velocity[-1], (0, 0, -0.5), atol=1e-9)
    np.testing.assert_allclose(sol["nut"].spin[-1], (0, 0, -1.0), atol=1e-9)
    slotted = ns.Scene(gravity=(0, 0))
    slotted.fixed(ns.Disc(0.01), name="hook")
    slotted.body(ns.Disc(0.1), mass=1.0, velocity=(1.0, 0), name="pin")
    slotted.slot("hook", "pin", at=(0, 0), axis=(1, 0), limits=(-1, 0.3), e=0.5)
    assert run(slotted, 0.6, 1e-3)["pin"].velocity[-1, 0] == pytest.approx(-0.5, abs=1e-9)


# --- files, checkpoints, what is refused


def tied():
    scene = hooked(2)
    bob(scene, 0.3, -0.2)
    bob(scene, 0.6, -0.2, name="other")
    scene.rope("hook", "bob", at_b=(0.3, -0.18), length=0.8, e=0.25, name="rope")
    scene.distance("bob", "other", at_a=(0.32, -0.2), name="rod")
    scene.slider("hook", "other", axis=(0, 1), limits=(-1.0, 1.0), e=0.5, name="way")
    return scene


def test_a_file_holds_ropes_distances_and_restitution(tmp_path):
    tied().save(tmp_path / "tied.toml")
    read = ns.Scene.load(tmp_path / "tied.toml")
    assert [(j.kind, j.e, j.length) for j in read.joints] == [(j.kind, j.e, j.length) for j in tied().joints]
    assert (run(read, 1.0, 2e-3).position == run(tied(), 1.0, 2e-3).position).all()


def test_a_run_with_ropes_is_resumed(tmp_path):
    whole, place = run(tied(), 1.0, 2e-3), tmp_path / "run.npz"
    options = {"checkpoint": place, "max_steps": 200, "on_failure": "return"}
    ns.simulate(tied(), (0, 1.0), integrator=ns.MoreauJean(dt=2e-3), **options)
    resumed = run(tied(), 1.0, 2e-3, checkpoint=place, resume=place)
    assert (resumed.position == whole.position).all() and (resumed.joint_impulses == whole.joint_impulses).all()


@pytest.mark.parametrize(
    ("method", "options", "message"),
    [
        ("rope", {"length": 0.1}, "the ends of tie are 0.360555 m apart, and it is 0.1 m long"),
        ("rope", {"length": -1.0}, "length of tie"),
        ("rope", {"length": 1.0, "e": 1.5}, "e of tie"),
        ("distance", {"at_a": (0.3, -0.2)}, "length of tie"),
        ("rope", {"b": "hook", "length": 1.0}, "tie joins hook to itself"),
        ("hinge", {"at": (0, 0), "e": 0.5}, "e of tie is that of its limits, and it has none; give limits="),
        ("hinge", {"at": (0, 0), "limits": (-1, 1), "e": -0.5}, "e of tie"),
    ],
)
def test_what_is_no_rope_and_no_stop_is_refused(method, options, message):
    scene = hooked(2)
    bob(scene, 0.3, -0.2)
    with pytest.raises(ns.InvalidInput, match=message.replace("(", r"\(")):
        getattr(scene, method)("hook", options.pop("b", "bob"), name="tie", **options)


def test_methods_that_hold_no_ropes_say_so():
    scene = swinging("rope")
    with pytest.raises(ns.InvalidInput, match="tie is a rope joint, which no system of a scene holds"):
        scene.system()
    stops = hooked(2)
    bob(stops, 0, -0.2)
    stops.rope("hook", "bob", length=1.0, e=0.5, name="stop")
    with pytest.raises(ns.InvalidInput, match="springs and dampers say how bodies rebound, and stop has e = 0.5"):
        ns.simulate(stops, (0, 1), integrator=ns.Penalty(stiffness=1e5))
    with pytest.raises(ns.InvalidInput, match="the motor of tie has force=, and a rope joint has no angle or travel"):
        scene.joints[0].motor(force=1.0)
    law = hooked(2)
    ball = bob(law, 0, -0.2)
    object.__setattr__(ball, "material", ns.Material(e=0.5, impact="poisson"))
    law.fixed(ns.HalfPlane((0, 1)), position=(0, -3), material=ball.material, name="ground")
    law.rope("hook", "bob", length=1.0, e=0.5, name="tie")
    with pytest.raises(ns.InvalidInput, match="limits and ropes rebound by Newton's law, tie does"):
        ns.simulate(law, (0, 1), integrator=ns.MoreauJean(dt=1e-3))


@pytest.mark.parametrize("kind", ["rope", "distance"])
def test_ties_are_springs_that_tend_to_the_rigid_ones(kind):
    rigid = run(swinging(kind), 0.5, 1e-4)["bob"].position[-1]
    errors = []
    for k in (1e5, 4e5):
        sol = ns.simulate(swinging(kind), (0, 0.5), integrator=ns.Penalty(stiffness=k))
        errors.append(np.abs(sol["bob"].position[-1] - rigid).max())
        stretch = sol.joint("tie").distance.max() - 1.0
        assert 20.0 / k < stretch < 80.0 / k  # the pull is 2 kg (g cos + v^2/l), 38 N at the start
    assert errors[1] < 0.5 * errors[0] and errors[1] < 2e-4


def test_error_control_takes_ropes():
    scene = hooked(2)
    bob(scene, 0, -0.2)
    scene.rope("hook", "bob", length=1.0, e=0.5)
    y = ns.simulate(scene, (0, 0.7), integrator=ns.Adaptive(rtol=1e-8, atol=1e-8))["bob"].position[-1, 1]
    falls = math.sqrt(1.6 / G)
    t = 0.7 - falls
    assert y == pytest.approx(-1.0 + 0.5 * G * falls * t - 0.5 * G * t**2, abs=1e-6)
