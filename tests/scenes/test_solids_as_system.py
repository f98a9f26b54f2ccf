"""A scene of bodies that turn in space as a System: rows by differences, the rod by hand, motions of the scene."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import nonsmooth as ns
from models import SpatialPainleveRod
from nonsmooth.mechanics.system import GAP, GAP_RATE, KINEMATICS, NORMAL, ROW_RATES, SURFACE_VELOCITY, TANGENT
from nonsmooth.scenes.inertia import inertia_of
from tests.scenes.test_as_system import BY_DIFFERENCES, slope_of

G = 9.81
ROUNDING = 1e-9  # m, of the rod's tip: moves forces by this part of them


def rod_scene(th, phi, thdot=0.0, psidot=0.0, psi=0.3, mu=2.0):
    """Painlevé's rod as a capsule without thickness; its spin is across its axis."""
    rod = SpatialPainleveRod(mu=mu)
    q, u = rod.state(th=th, phi=phi, thdot=thdot, psidot=psidot, psi=psi)
    scene = ns.Scene(gravity=(0, 0, -G), material=ns.Material(mu=mu))
    scene.fixed(ns.HalfSpace((0, 0, 1)), name="ground")
    e = np.array([math.cos(th) * math.cos(psi), math.cos(th) * math.sin(psi), math.sin(th)])
    spin = np.array([0.0, 0.0, psidot]) - thdot * np.array([-math.sin(psi), math.cos(psi), 0.0])
    scene.body(
        ns.Capsule(1.0, ROUNDING), mass=1.0, inertia=np.diag([1e-3, 1 / 12, 1 / 12]), name="rod",
        position=q[:3] + [0, 0, ROUNDING], velocity=u[:3], spin=spin - (spin @ e) * e,
        turn=Rotation.from_euler("ZYX", [psi, -th, 0]).as_quat(scalar_first=True),
    )  # fmt: skip
    return scene, ns.classify(rod, state=dict(th=th, phi=phi, thdot=thdot, psidot=psidot, psi=psi))


STATES = [
    (math.pi / 3, 0.4, 0.0, 0.0), (math.pi / 3, 0.4, 0.0, 12.0), (math.pi / 3, 0.9, 0.0, 0.0), (1.0, 0.2, 3.0, 2.0),
    (1.1, -0.3, 6.0, 1.0), (0.4, 3.0, 1.0, -2.0),
]  # fmt: skip


@pytest.mark.upkeep
@pytest.mark.parametrize("state", STATES)
def test_the_spatial_rod_as_a_scene_has_the_solutions_of_the_rod_written_by_hand(state):
    scene, by_hand = rod_scene(*state)
    found = ns.classify(scene)
    assert (found.kind, found.n_solutions, found.flags) == (by_hand.kind, by_hand.n_solutions, by_hand.flags)
    assert found.mode == (by_hand.mode[0], "open")
    np.testing.assert_allclose([found.p[0], found.b[0]], [by_hand.p[0], by_hand.b[0]], rtol=100 * ROUNDING)
    for one, other in zip(found.solutions, by_hand.solutions, strict=True):
        assert one.la[0, 0] == pytest.approx(other.la[0, 0], rel=100 * ROUNDING)
    assert [a.law for a in found.impacts] == [a.law for a in by_hand.impacts]
    np.testing.assert_allclose(
        [a.P_N[0] for a in found.impacts], [a.P_N[0] for a in by_hand.impacts], rtol=100 * ROUNDING, atol=1e-12
    )


def various():
    """Corners of a box and of a solid, ends of a capsule, balls off the centre; belts on some of them."""
    scene = ns.Scene(gravity=(0.5, 0.2, -G), material=ns.Material(mu=0.4, e=0.2))
    scene.fixed(ns.HalfSpace((0.3, -0.2, 1)), position=(0.1, 0, -0.2), surface_velocity=(0.7, 0.1, 0), name="slope")
    scene.fixed(
        ns.Sphere(0.3), position=(-2, 0.5, 0), turn=(0.8, 0, 0.6, 0), surface_velocity=(0, 0.4, 0.1), name="knob"
    )
    scene.body(ns.Box(0.3, 0.4, 0.5), mass=2.0, position=(1, 1, 1), spin=(1, 2, 3), name="box",
               surface_velocity=(0.2, 0.5, -0.1))  # fmt: skip
    points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (0.5, 0.5, 0.7)]
    scene.body(ns.Polyhedron(points), density=3.0, position=(3, 1, 1), name="solid")
    scene.body(ns.Capsule(0.6, 0.1), mass=1.0, position=(0, 3, 1), velocity=(1, 0, 0), name="rod")
    two = ns.Compound((ns.Sphere(0.2), (0.6, 0.1, 0.0)), (ns.Sphere(0.3), (-0.5, 0.0, 0.2)))
    scene.body(two, mass=1.5, position=(-1, 2, 3), spin=(0, 0, 4.0), name="dumbbell")
    scene.body(ns.Sphere(0.25), mass=0.5, position=(1, 3, 2), name="ball")
    pairs = [("box", "slope"), ("slope", "solid"), ("rod", "slope"), ("dumbbell", "knob"), ("ball", "dumbbell")]
    return scene, scene.system(pairs)


def states(system, n=4):
    rng = np.random.default_rng(7)
    return [(rng.uniform(-3, 3, system.n_q), rng.uniform(-2, 2, system.n_u)) for _ in range(n)]


def moved(system, q, u, s):
    """Where u leads in a time s, u even: places go straight, quaternions by Rodrigues' formula."""
    there = q + s * (system.evaluate(KINEMATICS, 0.0, q, u) @ u)
    for b in range(system.n_q // 7):
        own, spin = slice(7 * b + 3, 7 * b + 7), u[6 * b + 3 : 6 * b + 6]
        turn = Rotation.from_quat(q[own], scalar_first=True) * Rotation.from_rotvec(s * spin)
        there[own] = np.linalg.norm(q[own]) * turn.as_quat(scalar_first=True)
    return there


def velocities(system, q, u):
    slip = system.evaluate(TANGENT, 0.0, q, u) @ u + system.evaluate(SURFACE_VELOCITY, 0.0, q, u)
    return np.concatenate(((system.evaluate(NORMAL, 0.0, q, u) @ u)[:, None], slip), axis=1)


def test_normal_rows_are_the_gradients_of_the_gaps():
    _, system = various()
    for q, u in states(system):
        slope = slope_of(lambda s, q=q, u=u: system.evaluate(GAP, 0.0, moved(system, q, u, s), u), 2.0**-11)
        W_N = system.evaluate(NORMAL, 0.0, q, u)
        np.testing.assert_allclose(W_N @ u, slope, atol=BY_DIFFERENCES * np.abs(slope).max())


def test_row_rates_are_those_of_the_rows_along_the_motion():
    _, system = various()
    for q, u in states(system):
        slope = slope_of(lambda s, q=q, u=u: velocities(system, moved(system, q, u, s), u), 2.0**-11)
        rates = system.evaluate(ROW_RATES, 0.0, q, u)
        np.testing.assert_allclose(rates, slope, atol=BY_DIFFERENCES * np.abs(slope).max())


@pytest.mark.upkeep
def test_tangential_rows_are_the_velocity_of_the_points_that_touch():
    """Of the ball on the dumbbell's two, by hand; and of a belt that a body which stands still feels."""
    scene, system = various()
    for q, u in states(system):
        slip = velocities(system, q, u)[-2:, 1:]
        (x_b, R_b, v_b, w_b), (x_d, R_d, v_d, w_d) = (
            (q[7 * k : 7 * k + 3], Rotation.from_quat(q[7 * k + 3 : 7 * k + 7], scalar_first=True),
             u[6 * k : 6 * k + 3], u[6 * k + 3 : 6 * k + 6]) for k in (4, 3)
        )  # fmt: skip
        body = scene["dumbbell"]
        inertia = inertia_of(body, 3)
        axes = Rotation.from_quat(inertia.axes, scalar_first=True)
        for row, (centre, r) in zip(slip, (((0.6, 0.1, 0.0), 0.2), ((-0.5, 0.0, 0.2), 0.3)), strict=True):
            arm = R_d.apply(axes.inv().apply(np.array(centre) - inertia.centre))
            n = x_b - x_d - arm
            n /= np.linalg.norm(n)
            of_ball = v_b + np.cross(R_b.apply(w_b), -0.25 * n)
            apart = of_ball - v_d - np.cross(R_d.apply(w_d), arm + r * n)
            across = apart - (apart @ n) * n
            assert np.linalg.norm(row) == pytest.approx(np.linalg.norm(across), rel=1e-10)
    still = ns.Scene(gravity=(0, 0, -G), material=ns.Material(mu=0.4))
    still.fixed(ns.HalfSpace((0, 0, 1)), surface_velocity=(0.7, 0.1, 0), name="belt")
    still.body(ns.Box(1, 1, 1), mass=1.0, position=(0, 0, 0.5), name="box")
    du = ns.classify(still.system([("belt", "box")]), 0.0, *still.state()).gamma_F
    np.testing.assert_allclose(np.linalg.norm(du, axis=1), math.hypot(0.7, 0.1), rtol=1e-12)
    sol = ns.simulate(still.system(), (0, 0.05), *still.state(), integrator=ns.MoreauJean(1e-3))
    np.testing.assert_allclose(sol.u[-1, :2], 0.05 * 0.4 * G * np.array([0.7, 0.1]) / math.hypot(0.7, 0.1), rtol=1e-6)


def test_gaps_are_those_that_the_scene_finds():
    scene, system = various()
    q, u = scene.state()
    gaps = system.evaluate(GAP, 0.0, q, u)
    corners = np.array([[x, y, z] for x in (0.85, 1.15) for y in (0.8, 1.2) for z in (0.75, 1.25)])
    n = np.array([0.3, -0.2, 1]) / math.sqrt(1.13)
    np.testing.assert_allclose(sorted(gaps[:8]), sorted((corners - [0.1, 0, -0.2]) @ n), atol=1e-12)
    ends = np.array([[-0.3, 3, 1], [0.3, 3, 1]]) - [0.1, 0, -0.2]
    np.testing.assert_allclose(sorted(gaps[13:15]), sorted(ends @ n - 0.1), atol=1e-12)
    balls = np.array([[-0.4, 2.1, 3], [-1.5, 2, 3.2]])
    away = np.linalg.norm(balls - [-2, 0.5, 0], axis=1) - 0.3 - [0.2, 0.3]
    np.testing.assert_allclose(sorted(gaps[15:17]), sorted(away), atol=1e-12)


def test_the_motion_of_the_scene_tends_to_that_of_its_system():
    """A capsule that slides and turns on both ends: the scene is of first order there, its system of second."""
    scene = ns.Scene(gravity=(0, 0, -G), material=ns.Material(mu=0.3))
    scene.fixed(ns.HalfSpace((0, 0, 1)), name="ground")
    start = {"position": (0, 0, 0.1), "velocity": (1.0, 0.5, 0), "spin": (0, 0, 3.0)}
    scene.body(ns.Capsule(0.6, 0.1), mass=1.0, name="rod", **start)
    system, (q0, u0) = scene.system(), scene.state()

    def of_system(dt):
        return ns.simulate(system, (0, 0.3), q0, u0, integrator=ns.MoreauJean(dt)).q[-1]

    def of_scene(dt):
        rod = ns.simulate(scene, (0, 0.3), integrator=ns.MoreauJean(dt))["rod"]
        return np.concatenate((rod.position[-1], rod.turn[-1]))

    exact = of_system(1.25e-4)
    errors = [np.abs(of_system(dt) - exact).max() for dt in (2e-3, 1e-3)]
    assert 3.4 < errors[0] / errors[1] < 4.6
    errors = [np.abs(of_scene(dt) - exact).max() for dt in (2e-3, 1e-3)]
    assert errors[1] < 1.5e-4 and 1.7 < errors[0] / errors[1] < 2.3


def test_coefficients_are_parameters_and_friction_has_a_critical_value():
    scene, _ = rod_scene(math.pi / 3, 0.4)
    system, (q0, _) = scene.system(), scene.state()
    assert ns.classify(system.with_parameters(mu_ground_rod=1.0), 0.0, *scene.state()).kind.name == "REGULAR"
    th = math.pi / 3
    least = (1 + 3 * math.cos(th) ** 2) / (3 * math.sin(th) * math.cos(th))  # of p = 0 over all directions
    assert ns.critical_friction(system, q0) == pytest.approx(least, rel=1e-6)
    mus = np.array([1.0, 1.4, 1.6, 2.0])
    chart = ns.paradox_map(scene, mu_ground_rod=mus, progress=False)
    p = 1 + 3 * math.cos(th) * (math.cos(th) - mus * math.cos(0.4) * math.sin(th))  # m = 1
    np.testing.assert_allclose(chart.p[:, 0], p, atol=1e-6)
    assert ((chart.kind == 0) == (p < 0)).all()


@pytest.mark.upkeep
def test_without_friction_there_are_no_tangential_rows():
    scene = ns.Scene(gravity=(0, 0, -G), material=ns.Material(mu=0.0))
    scene.fixed(ns.HalfSpace((0, 0, 1)), name="ground")
    scene.body(ns.Box(1, 1, 1), mass=1.0, position=(0, 0, 0.5), name="box")
    system = scene.system()
    assert system.d == 0 and not system.kinds[:, 1].any()
    # eight corners; the four below rest, which share the weight in any way
    assert ns.classify(scene).mode.count("open") == 4


def test_what_touches_along_faces_and_methods_of_the_plane_are_refused_by_name():
    scene = ns.Scene(gravity=(0, 0, -G), material=ns.Material(mu=0.3))
    scene.fixed(ns.HalfSpace((0, 0, 1)), name="ground")
    scene.body(ns.Box(1, 1, 1), mass=1.0, position=(0, 0, 0.5), name="box")
    scene.body(ns.Cylinder(0.1, 0.4), mass=1.0, position=(3, 0, 0.1), name="roll")
    with pytest.raises(ns.InvalidInput, match="ground and roll.*may touch along faces.*pairs="):
        scene.system()
    system = scene.system([("ground", "box")])
    assert system.n_c == 8 and system.n_q == 14
    with pytest.raises(ns.InvalidInput, match="may touch along faces"):
        ns.simulate(scene, (0, 0.1), integrator=ns.EventDriven())
    assert "touch along faces" in ns.simulate(scene, (0, 0.01), integrator="auto").about["chosen"]


def one_box(**given):
    scene = ns.Scene(gravity=(0, 0, -G), material=ns.Material(mu=0.3))
    scene.fixed(ns.HalfSpace((0, 0, 1)), name="ground")
    scene.body(ns.Box(0.4, 0.3, 0.2), mass=2.0, name="box", **({"position": (0, 0, 0.1)} | given))
    return scene


def test_a_scene_in_space_of_few_contacts_has_its_events_located_and_returns_as_steps_of_scenes_do(tmp_path):
    scene = one_box(position=(0, 0, 0.16), turn=(math.cos(0.1), 0.6 * math.sin(0.1), 0.8 * math.sin(0.1), 0),
                    spin=(1.0, 2.0, 0.5), velocity=(0.8, 0.1, 0))  # fmt: skip
    kinds = ("bodies", "contacts", "ledger", "events")
    sol = ns.simulate(scene, (0, 0.1), record=kinds)
    assert sol.about["integrator"] == repr(ns.EventDriven(1e-8, 1e-10)) and "8 contacts" in sol.about["chosen"]
    steps = ns.simulate(scene, (0, 0.1), integrator=ns.MoreauJean(2e-5), record=kinds)
    for name, by in (("position", 2e-4), ("turn", 2e-4), ("velocity", 5e-3), ("spin", 2e-2)):
        np.testing.assert_allclose(getattr(sol["box"], name)[-1], getattr(steps["box"], name)[-1], atol=by)
    first, theirs = sol.events[0], steps.events[0]
    assert first.kind == theirs.kind == ns.SceneEventKind.LANDING and first.t == pytest.approx(theirs.t, abs=4e-5)
    np.testing.assert_allclose(first.P, theirs.P, atol=2e-3)  # on the box, friction with it
    ours, others = sol.contacts(0.1), steps.contacts(0.1)
    assert len(ours) == len(others) == 1
    np.testing.assert_allclose(ours.point, others.point, atol=3e-4)
    np.testing.assert_allclose(ours.P[0] / ours.P[0, 2], others.P[0] / others.P[0, 2], atol=1e-2)
    energy = sol.ledger["kinetic"] + sol.ledger["potential"]
    lost = sum(sol.ledger[name] for name in ("friction", "normal"))
    np.testing.assert_allclose(energy - lost, energy[0], atol=1e-7)
    assert "turn in space" in ns.simulate(scene, (0, 0.01), integrator=ns.Adaptive()).about["chosen"]
    back = ns.SceneSolution.load(sol.save(tmp_path / "box.npz"))
    np.testing.assert_array_equal(back["box"].position, sol["box"].position)
    np.testing.assert_array_equal(back.contacts(0.1).P, ours.P)


def on_guided_bodies():
    """A rod on a half-space that moves, tilts and turns, and a ball with a belt that is pushed past."""
    scene = ns.Scene(gravity=(0, 0, -G), material=ns.Material(mu=0.4))
    scene.kinematic(
        ns.HalfSpace((0, 0, 1)), position=(0.1, 0.2, -0.05), velocity=(0.3, 0, 0.2), spin=(0.4, -0.3, 0.5), name="plate"
    )
    scene.kinematic(
        ns.Sphere(0.1), position=(1.0, 0.3, 0.4), velocity=(-0.8, 0, 0), spin=(1, 2, 3), name="ram",
        surface_velocity=(0.2, -0.1, 0.3),
    )  # fmt: skip
    scene.body(ns.Capsule(0.3, 0.1), mass=1.0, position=(0.2, 0.1, 0.3), spin=(1, 2, 3), name="rod")
    return scene


def test_gaps_and_rows_on_guided_bodies_move_as_these_do():
    of_rod = on_guided_bodies().system([("plate", "rod")])
    ball = ns.Scene(gravity=(0, 0, -G), material=ns.Material(mu=0.4))
    for body in on_guided_bodies().bodies[:2]:
        ball.kinematic(body.shape, position=body.position, velocity=body.velocity, spin=body.spin, name=body.name,
                       surface_velocity=body.surface_velocity)  # fmt: skip
    ball.body(ns.Sphere(0.1), mass=1.0, position=(0.2, 0.1, 0.3), name="ball")
    for system, (q, _) in ((of_rod, on_guided_bodies().state()), (ball.system(), ball.state())):
        t, h, u = 0.7, 1e-6, np.random.default_rng(1).normal(size=6)
        way = system.evaluate(KINEMATICS, t, q, u) @ u

        def velocities(t, q, system=system, u=u):
            gamma_N = system.evaluate(NORMAL, t, q, u) @ u + system.evaluate(GAP_RATE, t, q, u)
            gamma_T = system.evaluate(TANGENT, t, q, u) @ u + system.evaluate(SURFACE_VELOCITY, t, q, u)
            return np.column_stack([gamma_N, gamma_T])

        later, before = (t + h, q + h * way), (t - h, q - h * way)
        rate = (system.evaluate(GAP, *later, u) - system.evaluate(GAP, *before, u)) / (2 * h)
        np.testing.assert_allclose(rate, velocities(t, q)[:, 0], atol=BY_DIFFERENCES)
        rates = (velocities(*later) - velocities(*before)) / (2 * h)
        np.testing.assert_allclose(rates, system.evaluate(ROW_RATES, t, q, u), atol=BY_DIFFERENCES)


def test_a_ball_that_rolls_on_a_turntable_goes_round_in_a_circle():
    """v' = 2/7 Omega e_z x v, wherever the ball is: 2/5 of m r^2 over 2/5 + 1."""
    Omega, r, x, v = 3.0, 0.05, np.array([0.4, 0.0]), np.array([0.3, 0.1])
    scene = ns.Scene(gravity=(0, 0, -G), material=ns.Material(mu=0.5))
    scene.kinematic(ns.HalfSpace((0, 0, 1)), spin=(0, 0, Omega), name="table")
    rim = Omega * np.array([-x[1], x[0]]) - v  # what rolling adds to v where the ball touches
    scene.body(ns.Sphere(r), mass=1.0, position=(*x, r), velocity=(*v, 0), spin=(rim[1] / r, -rim[0] / r, 0), name="b")
    sol = ns.simulate(scene, (0, 3), integrator=ns.EventDriven(1e-11, 1e-13))
    rate, turn = 2 / 7 * Omega, 2 / 7 * Omega * 3
    way = np.array([[math.sin(turn), math.cos(turn) - 1], [1 - math.cos(turn), math.sin(turn)]]) @ v / rate
    np.testing.assert_allclose(sol["b"].position[-1, :2], x + way, atol=1e-11)
    assert len(sol.contacts(3.0).of("table")) == 1
    np.testing.assert_allclose(sol["table"].turn[-1], [math.cos(4.5), 0, 0, math.sin(4.5)], atol=1e-12)
