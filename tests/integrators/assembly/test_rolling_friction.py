"""Rolling and spinning friction of contacts against closed forms, invariants, statics, and what is refused."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.integrators.assembly.progress import DONE, NOT_MET
from nonsmooth.integrators.assembly.stages import take_steps
from nonsmooth.integrators.assembly.step import PLACES
from nonsmooth.jit import interpreted
from nonsmooth.runs.recorder import SceneRecorder
from nonsmooth.runs.scene_run import SceneRun
from nonsmooth.scenes.detection import FIRST_ROLLING, contact_of

G, R, ROLLING, SPINNING = 10.0, 0.1, 0.004, 0.003
INERTIA = {2: 0.5, 3: 0.4}  # over m R^2


def run(scene, t_end, dt=1e-3, **options):
    sol = ns.simulate(scene, (0, t_end), integrator=ns.MoreauJean(dt=dt), **options)
    assert sol.stats.missed == 0
    return sol


def on_ground(dim, slope=0.0, rolling=ROLLING, spinning=SPINNING, mu=0.5):
    """A scene with a plane, under gravity that is turned against it by an angle."""
    s, c = G * math.sin(slope), G * math.cos(slope)
    scene = ns.Scene(
        gravity=(s, -c) if dim == 2 else (s, 0, -c), material=ns.Material(mu=mu, rolling=rolling, spinning=spinning)
    )
    scene.fixed(ns.HalfPlane((0, 1)) if dim == 2 else ns.HalfSpace((0, 0, 1)), name="ground")
    return scene


def ball(scene, x=0.0, v=0.0, height=R, mass=2.0, name="ball", direction=(0.6, 0.8), about=0.0):
    """A disc or a ball that rolls without slip, in space into a direction."""
    if scene.dim == 2:
        return scene.body(ns.Disc(R), mass=mass, position=(x, height), velocity=(v, 0), spin=-v / R, name=name)
    e_x, e_y = direction
    return scene.body(
        ns.Sphere(R), mass=mass, position=(x, 0, height), velocity=(v * e_x, v * e_y, 0),
        spin=(-v * e_y / R, v * e_x / R, about), name=name,
    )  # fmt: skip


@pytest.mark.upkeep
@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("dt", [4e-3, 1e-3])
def test_what_rolls_stops_where_its_closed_form_says_and_stays(dim, dt):
    """At v^2 (1 + I/(m R^2)) R/(2 g rolling), of half the energy by each of its parts; then it sleeps."""
    scene, v = on_ground(dim), 1.0
    ball(scene, v=v)
    sol = run(scene, 8.0, dt)
    way = v**2 * (1 + INERTIA[dim]) * R / (2 * G * ROLLING)
    x = np.linalg.norm(sol["ball"].position[:, : dim - 1], axis=1)
    assert x[-1] == pytest.approx(way, abs=0.1 * dt**2) and (sol["ball"].velocity[-1] == 0.0).all()
    assert sol.stats.asleep > 0.4 / dt and sol.stats.contacts == sol.stats.most_contacts == 1
    a = ROLLING * G / (R * (1 + INERTIA[dim]))
    t = sol.t[sol.t < v / a]
    np.testing.assert_allclose(x[: len(t)], v * t - 0.5 * a * t**2, atol=1e-10 + dt**2)
    assert sol.ledger["friction"][-1] == pytest.approx(-0.5 * 2.0 * v**2 * (1 + INERTIA[dim]), rel=1e-9)
    assert (np.diff(sol.ledger["kinetic"]) <= 1e-15).all()


@pytest.mark.parametrize("dt", [4e-3, 1e-3])
def test_a_ball_that_spins_about_the_vertical_stops_in_its_time(dt):
    """I w/(m g spinning); without that it spins for ever, and rolling friction is none of it."""
    for spinning in (SPINNING, 0.0):
        scene, w = on_ground(3, spinning=spinning), 10.0
        ball(scene, about=w)
        sol = run(scene, 2.0, dt)
        exact = np.maximum(0.0, w - spinning * G / (0.4 * R**2) * sol.t)
        np.testing.assert_allclose(sol["ball"].spin[:, 2], exact, atol=1e-9)
        assert np.abs(sol["ball"].position[:, :2]).max() < 1e-12


def test_rolling_and_spinning_are_lengths_of_their_own():
    """What spins while it rolls has both moments, each with its own limit."""
    scene = on_ground(3)
    ball(scene, v=1.0, about=5.0)
    sol = run(scene, 1.0)
    t = sol.t
    np.testing.assert_allclose(sol["ball"].spin[:, 2], np.maximum(0.0, 5.0 - SPINNING * G / 0.004 * t), atol=1e-6)
    a = ROLLING * G / (R * 1.4)
    np.testing.assert_allclose(np.linalg.norm(sol["ball"].velocity[:, :2], axis=1), 1.0 - a * t, atol=1e-6)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_ball_rests_on_a_slope_below_the_angle_of_its_rolling_friction_and_rolls_above_it(dim):
    critical = math.atan(ROLLING / R)
    scene = on_ground(dim, slope=0.99 * critical)
    ball(scene)
    sol = run(scene, 100.0, 5e-3, every=100)
    assert (sol["ball"].position == sol["ball"].position[0]).all() and sol.stats.asleep > 10_000
    scene = on_ground(dim, slope=1.5 * critical)
    ball(scene)
    sol = run(scene, 1.0)
    a = G * (math.sin(1.5 * critical) - ROLLING / R * math.cos(1.5 * critical)) / (1 + INERTIA[dim])
    np.testing.assert_allclose(sol["ball"].position[:, 0], 0.5 * a * sol.t**2, atol=1e-6)


@pytest.mark.parametrize("dim", [2, 3])
def test_two_bodies_that_roll_on_one_another_keep_their_momenta(dim):
    """Pressed together by a spring, without weight: the moments of a contact are opposite."""
    material = ns.Material(mu=0.5, rolling=0.02, spinning=0.02)
    scene = ns.Scene(gravity=(0,) * dim, material=material)
    shape = ns.Disc(R) if dim == 2 else ns.Sphere(R)
    for k, w in enumerate((3.0, 1.0)):
        spin = w if dim == 2 else (w, 0.5, 2 * w)
        scene.body(shape, mass=1.0 + k, position=(2 * R * k, *(0,) * (dim - 1)), spin=spin, name=f"{k}")
    scene.spring("0", "1", stiffness=100.0, length=0.1)
    sol = run(scene, 1.0)
    masses = np.array([1.0, 2.0])
    momentum = np.einsum("b,tbk->tk", masses, sol.velocity)
    if dim == 2:
        x, v = sol.position, sol.velocity
        angular = (masses * (x[..., 0] * v[..., 1] - x[..., 1] * v[..., 0]) + 0.5 * masses * R**2 * sol.spin).sum(1)
        turning = sol.spin[-1, 0] - sol.spin[-1, 1]
    else:
        angular = np.einsum("b,tbk->tk", masses, np.cross(sol.position, sol.velocity) + 0.4 * R**2 * sol.spin)
        turning = sol.spin[-1, 0] - sol.spin[-1, 1]
    assert np.abs(momentum).max() < 1e-13 and np.abs(angular - angular[0]).max() < 1e-6
    assert np.abs(turning).max() < 1e-9  # they turn as one
    assert sol.ledger["friction"][-1] < -1e-3 and (np.diff(sol.ledger["friction"]) <= 1e-10).all()


@pytest.mark.upkeep
@pytest.mark.parametrize("dim", [2, 3])
def test_a_heap_of_balls_comes_to_rest_sooner_and_no_step_misses_its_tolerance(dim):
    """Its problems are solved to the tolerance with limits that are those of the loads which they lead to."""

    def heap(rolling):
        scene = on_ground(dim, rolling=rolling, spinning=rolling)
        rng = np.random.default_rng(3)
        for k in range(12):
            x = 0.22 * (k % 3) + 0.1 * (k // 3 % 2) + 0.01 * rng.random()
            ball(scene, x=x, height=R + 0.21 * (k // 3), name=f"{k}", mass=1.0)
        sol = run(scene, 1.5, 2e-3)
        assert sol.stats.worst_residual < 1e-8
        return sol.ledger["kinetic"][-1]

    assert heap(0.005) < 0.7 * heap(0.0)


def test_limits_are_those_of_the_loads_that_they_lead_to():
    """A wheel on which a heavy one leans: its load depends on the moment, which depends on the load."""
    scene = on_ground(2, rolling=0.03)
    scene.fixed(ns.HalfPlane((1, 0)), position=(-R, 0), name="wall")
    ball(scene, name="low")
    scene.body(ns.Disc(R), mass=8.0, position=(0.12, R + 0.16), name="high")
    scene.body(ns.Disc(R), mass=1.0, position=(0.24, R), name="right")
    assembly = SceneRun(scene, (0, 1.0), ns.MoreauJean(dt=2e-3), 1, None).assembly
    assembly.take_steps(2e-3, 25)
    network, found, surfaces = assembly.network, assembly.found, assembly.surfaces
    n = int(network.n_c)
    rows = np.flatnonzero(found.key[:n] >= FIRST_ROLLING)
    pressed = 0
    for c in rows:
        of = interpreted(contact_of)(int(found.key[c]))
        limit = surfaces.rolling[0, 0] / R * network.P[of, 0]
        assert network.P[c, 0] == pytest.approx(limit, abs=1e-8 * np.abs(network.P[:n]).max())
        assert abs(network.P[c, 1]) <= network.P[c, 0] * (1 + 1e-9) + 1e-15
        pressed += network.P[of, 0] > 0.0
    assert pressed >= 3 and assembly.progress.counts.missed == 0


def test_a_pair_has_lengths_of_its_own_and_equal_materials_theirs():
    ice, rubber = ns.Material(mu=0.5, name="ice"), ns.Material(mu=0.5, rolling=0.01, name="rubber")
    for given, exact in ((None, 0.0), (ROLLING, ROLLING)):
        scene = ns.Scene(gravity=(0, -G), material=rubber)
        scene.fixed(ns.HalfPlane((0, 1)), material=ice, name="ground")
        ball(scene, v=1.0)
        if given is not None:
            scene.pair(ice, rubber, rolling=given)
        sol = run(scene, 0.5)
        a = exact * G / (R * 1.5)
        np.testing.assert_allclose(sol["ball"].velocity[:, 0], 1.0 - a * sol.t, atol=1e-9)


def test_a_file_holds_lengths_of_materials_and_pairs(tmp_path):
    scene = ns.Scene(gravity=(0, -G), material=ns.Material(mu=0.5, rolling=ROLLING, name="felt"))
    scene.fixed(ns.HalfPlane((0, 1)), material=ns.Material(mu=0.4, name="wood"), name="ground")
    ball(scene, v=1.0)
    scene.pair("felt", "wood", rolling=0.002)
    scene.pair("felt", "felt", mu=0.3, spinning=0.001)
    scene.save(tmp_path / "rolls.toml")
    read = ns.Scene.load(tmp_path / "rolls.toml")
    assert read.resistances == scene.resistances and read.pairs == scene.pairs
    assert (run(read, 0.5).position == run(scene, 0.5).position).all()


def test_what_sleeps_is_woken_and_a_run_is_resumed_to_the_last_bit(tmp_path):
    def table():
        scene = on_ground(3)
        ball(scene)
        ball(scene, x=-0.6, v=1.5, name="other", direction=(1.0, 0.0))
        return scene

    whole, place = run(table(), 3.0, 2e-3), tmp_path / "run.npz"
    assert whole["ball"].position[-1, 0] > 0.1 and whole.stats.missed == 0
    ns.simulate(
        table(), (0, 3.0), integrator=ns.MoreauJean(dt=2e-3), checkpoint=place, max_steps=400, on_failure="return"
    )
    resumed = run(table(), 3.0, 2e-3, checkpoint=place, resume=place)
    assert (resumed.position == whole.position).all() and (resumed.spin == whole.spin).all()
    assert (run(table(), 3.0, 2e-3, threads=2).position == whole.position).all()


@pytest.mark.parametrize("dim", [2, 3])
def test_the_interpreter_takes_steps_of_the_bits_of_compiled_code(dim):
    def begun():
        scene = on_ground(dim)
        ball(scene, v=0.3, about=1.0)
        ball(scene, x=0.1, height=0.275, name="other")
        return SceneRun(scene, (0, 0.01), ns.MoreauJean(dt=2e-3), 1, None, SceneRecorder(("pairs",))).assembly

    one, other = begun(), begun()
    one.take_steps(2e-3, 5)
    fields = {name: getattr(other.progress, name) for name in type(other.progress)._fields()}
    fields |= {name: getattr(one.progress, name) for name in ("whole", "margin", "widest")}
    fields["places"] = SimpleNamespace(
        motion=other.bodies.motion, **{name: getattr(other, name) for name in PLACES}
    )  # fmt: skip
    progress = SimpleNamespace(**fields)
    while (end := interpreted(take_steps)(progress, 5 - int(progress.counts.steps), dim)) == NOT_MET:
        other.rescue()
    assert end == DONE
    for name in ("bodies", "contacts", "ledger", "pairs"):
        found, expected = (getattr(assembly, name).words.view(np.int64) for assembly in (other, one))
        np.testing.assert_array_equal(found, expected)


def test_error_control_takes_rolling_friction():
    scene = on_ground(2)
    ball(scene, v=1.0)
    sol = ns.simulate(scene, (0, 1.0), integrator=ns.Adaptive(rtol=1e-6, atol=1e-6))
    a = ROLLING * G / (R * 1.5)
    assert sol["ball"].position[-1, 0] == pytest.approx(1.0 - 0.5 * a, abs=1e-6)


def test_methods_without_rolling_friction_say_so():
    scene = on_ground(2)
    ball(scene, v=1.0)
    with pytest.raises(ns.InvalidInput, match="rolling or spinning friction, which no system of a scene holds"):
        scene.system()
    with pytest.raises(ns.InvalidInput, match="rolling and spinning friction are laws of rigid contacts"):
        ns.simulate(scene, (0, 1), integrator=ns.Penalty(stiffness=1e5))
    with pytest.raises(ns.InvalidInput, match="rolling"):
        ns.Material(rolling=-0.1)
    with pytest.raises(ns.InvalidInput, match="spinning"):
        ns.Material(spinning=math.nan)
    with pytest.raises(ns.InvalidInput, match="needs mu=, e=, rolling=, spinning= or adhesion=; got none"):
        scene.pair(ns.Material(name="a"), ns.Material(name="b"))
