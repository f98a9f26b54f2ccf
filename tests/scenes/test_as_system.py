"""A planar scene as a System: its rows by differences, its motions by closed forms and by systems written by hand."""

import math
import warnings
from dataclasses import replace

import numpy as np
import pytest

import nonsmooth as ns
from models import PainleveRod, RockingBlock
from nonsmooth.mechanics.model_system import as_system
from nonsmooth.mechanics.system import GAP, GAP_RATE, NORMAL, ROW_RATES, SURFACE_VELOCITY, TANGENT

G = 9.81
EPS = np.finfo(float).eps
UP = ns.HalfPlane((0, 1))
ROUNDING = 1e-9  # m, of the rod's tip: moves forces by this part of them


def on_ground(material=None, **ground):
    scene = ns.Scene(gravity=(0, -G), material=material or ns.Material())
    scene.fixed(UP, name="ground", **ground)
    return scene


def rod_scene(th, thdot, slip, mu):
    q, u = PainleveRod(mu=mu).state(th=th, thdot=thdot, slip=slip)
    scene = on_ground(ns.Material(mu=mu))
    scene.body(
        ns.Capsule(1.0, ROUNDING), mass=1.0, inertia=1 / 12, name="rod",
        position=(q[0], q[1] + ROUNDING), turn=q[2], velocity=(u[0] - ROUNDING * thdot, u[1]), spin=u[2],
    )  # fmt: skip
    return scene


# Normal forces from p la_N + b of models/painleve_rod.py: (mu, th [deg], th' [rad/s], slip [m/s], la_N [N]), m = l = 1
RODS = [
    (0.5, 60, 0, -1, (8.914284273,)),
    (2.0, 60, 0, -1, ()),
    (2.0, 60, 6, -1, (0.0, 6.813606125)),
    (2.0, 60, 0, 1, (2.256170206,)),
    (1.5, 65, 3, -1, ()),
    (1.5, 65, 5, -1, (0.0, 8.088379598)),
]


@pytest.mark.parametrize(("mu", "th", "thdot", "slip", "forces"), RODS)
def test_painleve_rod_as_a_scene_has_the_solutions_of_the_rod_written_by_hand(mu, th, thdot, slip, forces):
    th = math.radians(th)
    scene, rod = rod_scene(th, thdot, slip, mu), PainleveRod(mu=mu)
    found = ns.classify(scene.system(), 0.0, *scene.state())
    by_hand = ns.classify(rod, 0.0, *rod.state(th=th, thdot=thdot, slip=slip))
    assert (found.kind, found.n_solutions) == (by_hand.kind, by_hand.n_solutions)
    assert found.mode[1] == "open"  # the upper tip
    la_N = sorted(solution.la_N[0] for solution in found.solutions)
    np.testing.assert_allclose(la_N, forces, rtol=1e2 * ROUNDING, atol=1e-12)


def various():
    """Of every kind of contact: vertices, rounded ones, discs off the centre, fixed discs; belts on all of them."""
    scene = ns.Scene(gravity=(0.5, -G), material=ns.Material(mu=0.4, e=0.2))
    scene.fixed(ns.HalfPlane((-0.3, 1), 0.1), position=(0.1, -0.2), turn=0.2, surface_velocity=(0.7, 0.1), name="slope")
    scene.fixed(ns.Disc(0.3), position=(-2, 0.5), turn=0.4, surface_velocity=(0.4, -0.2), name="roller")
    scene.body(ns.Polygon([(0, 0), (1, 0), (0, 1)], 0.1), density=2.0, position=(1, 1), turn=0.3, name="wedge",
               surface_velocity=(0.2, 0.5))  # fmt: skip
    dumbbell = ns.Compound((ns.Disc(0.2), (0.6, 0.1)), (ns.Disc(0.3), (-0.5, 0.0), 0.7))
    scene.body(dumbbell, mass=1.5, position=(-1, 2), turn=-0.4, velocity=(1, 2), spin=3.0, name="dumbbell")
    scene.body(ns.Disc(0.25), mass=0.5, position=(1, 3), surface_velocity=(0.3, 0.0), name="disc")
    pairs = [("wedge", "slope"), ("dumbbell", "roller"), ("slope", "disc"), ("disc", "dumbbell")]
    return scene, scene.system(pairs)


def states(system, n=4):
    rng = np.random.default_rng(5)
    return [(rng.uniform(-3, 3, system.n_q), rng.uniform(-2, 2, system.n_q)) for _ in range(n)]


def slope_of(function, h=2.0**-10):
    """f'(0) by a difference of sixth order."""
    f = [function(k * h) for k in (-3, -2, -1, 1, 2, 3)]
    return (f[5] - f[0] - 9 * (f[4] - f[1]) + 45 * (f[3] - f[2])) / (60 * h)


# h^6/140 of a seventh derivative ~ (3 of the spins)^7, discs of random states as near as 0.3 m; measured 1e-12
BY_DIFFERENCES = 1e-8


def test_normal_rows_are_the_gradients_of_the_gaps():
    _, system = various()
    for q, u in states(system):
        W_N = system.evaluate(NORMAL, 0.0, q, u)
        slope = slope_of(lambda s, q=q, u=u: system.evaluate(GAP, 0.0, q + s * u, u))
        np.testing.assert_allclose(W_N @ u, slope, atol=BY_DIFFERENCES * np.abs(slope).max())


def relative_velocities(system, q, u):
    row = system.evaluate(TANGENT, 0.0, q, u)[:, 0] @ u + system.evaluate(SURFACE_VELOCITY, 0.0, q, u)[:, 0]
    return np.stack([system.evaluate(NORMAL, 0.0, q, u) @ u, row], axis=1)


def test_row_rates_are_those_of_the_rows_along_the_motion():
    _, system = various()
    for q, u in states(system):
        rates = system.evaluate(ROW_RATES, 0.0, q, u)
        slope = slope_of(lambda s, q=q, u=u: relative_velocities(system, q + s * u, u))
        np.testing.assert_allclose(rates, slope, atol=BY_DIFFERENCES * np.abs(slope).max())


def test_tangential_row_is_the_velocity_of_the_points_that_touch():
    scene = ns.Scene(gravity=(0, -G), material=ns.Material(mu=0.4))
    scene.body(ns.Compound((ns.Disc(0.2), (0.6, 0.1)), (ns.Disc(0.1), (-0.6, 0.0))), mass=1.0, name="dumbbell")
    scene.body(ns.Disc(0.3), mass=1.0, name="disc")
    system = scene.system()
    centre = scene.state()[0][:2]
    arm = np.array([0.6, 0.1]) - centre
    for q, u in states(system):
        R = np.array([[math.cos(q[2]), -math.sin(q[2])], [math.sin(q[2]), math.cos(q[2])]])
        d = q[:2] + R @ arm - q[3:5]
        n = d / np.linalg.norm(d)
        r_i, r_j = R @ arm - 0.2 * n, 0.3 * n
        v = u[:2] + u[2] * np.array([-r_i[1], r_i[0]]) - u[3:5] - u[5] * np.array([-r_j[1], r_j[0]])
        found = system.evaluate(TANGENT, 0.0, q, u)[0, 0] @ u
        assert found == pytest.approx(n[1] * v[0] - n[0] * v[1], abs=1e-14)
        assert system.evaluate(GAP, 0.0, q, u)[0] == pytest.approx(np.linalg.norm(d) - 0.5, abs=1e-14)


@pytest.mark.upkeep
@pytest.mark.parametrize("integrator", [ns.EventDriven(1e-10), ns.MoreauJean(dt=1e-3)], ids=lambda i: type(i).__name__)
def test_rocking_block_as_a_scene_moves_as_the_one_written_by_hand(integrator):
    block = RockingBlock(mu=10.0, e=0.0)
    q, u = block.state(tilt=0.1)
    scene = on_ground(ns.Material(mu=block.mu, e=block.e))
    scene.body(ns.Box(block.width, block.height), mass=block.m, position=q[:2], turn=q[2], velocity=u[:2], spin=u[2])
    t_eval = np.linspace(0.0, 1.0, 51)
    found = ns.simulate(scene.system(), (0, 1), *scene.state(), integrator=integrator, t_eval=t_eval)
    by_hand = ns.simulate(block, (0, 1), q, u, integrator=integrator, t_eval=t_eval)
    assert np.ptp(by_hand.q[:, 2]) > 0.15  # it has rocked to the other side
    # roundings of 1000 steps, or of the accelerations, that grow by cosh(t sqrt(3 g/(4 r))) ~ 40 a second at most
    np.testing.assert_allclose(found.q, by_hand.q, atol=1e5 * EPS)


@pytest.mark.upkeep
def test_two_discs_part_as_newtons_law_has_it_along_the_line_of_their_centres():
    e, (m, M) = 0.6, (1.0, 2.5)
    scene = ns.Scene(gravity=(0, 0), material=ns.Material(mu=0.0, e=e))
    scene.body(ns.Disc(0.2), mass=m, position=(-1, 0.15), velocity=(2, 0), name="a")
    scene.body(ns.Disc(0.3), mass=M, position=(0, 0), name="b")
    solution = ns.simulate(scene.system(), (0, 1), *scene.state(), integrator=ns.EventDriven(1e-10))
    n = np.array([-math.sqrt(0.5**2 - 0.15**2), 0.15]) / 0.5  # from b to a when they touch
    v = np.array([2.0, 0.0])
    impulse = (1 + e) * -(n @ v) / (1 / m + 1 / M)
    np.testing.assert_allclose(solution.u[-1, :3], [*(v + impulse / m * n), 0.0], atol=1e-9)
    np.testing.assert_allclose(solution.u[-1, 3:], [*(-impulse / M * n), 0.0], atol=1e-9)


INTEGRATORS = [ns.EventDriven(1e-9), ns.Adaptive(rtol=1e-6)]


@pytest.mark.upkeep
@pytest.mark.parametrize("integrator", INTEGRATORS, ids=lambda i: type(i).__name__)
@pytest.mark.parametrize(("belt", "v_0", "v_end"), [(0.0, 1.5, 1.0), (1.5, 0.0, 0.5)], ids=["ground", "belt"])
def test_disc_slides_until_it_rolls(integrator, belt, v_0, v_end):
    # (2/3) v_0 on ground at rest, belt/3 from rest: friction acts at mu g on the centre, at 2 mu g on the rim
    mu, r = 0.5, 0.1
    scene = ns.Scene(gravity=(0, -G), material=ns.Material(mu=mu))
    scene.fixed(ns.HalfPlane((1, 0)), turn=math.pi / 2, surface_velocity=(0, -belt), name="ground")  # belts turn along
    scene.body(ns.Disc(r), density=100, position=(0, r), velocity=(v_0, 0), name="disc")
    solution = ns.simulate(scene.system(), (0, 0.3), *scene.state(), integrator=integrator)
    assert solution.u[-1, 0] == pytest.approx(v_end, abs=1e-5)
    assert solution.u[-1, 2] * r == pytest.approx(belt - v_end, abs=1e-5)


def test_disc_sinks_in_under_penalty_by_its_weight_over_the_stiffness():
    k, m = 1e5, 2.0
    scene = on_ground(ns.Material(mu=0.3))
    scene.body(ns.Disc(0.1), mass=m, position=(0, 0.1 - m * G / k), name="disc")
    solution = ns.simulate(scene.system(), (0, 0.05), *scene.state(), integrator=ns.Penalty(stiffness=k))
    np.testing.assert_allclose(solution.q[:, 1], 0.1 - m * G / k, atol=1e-9)


@pytest.mark.upkeep
def test_energy_of_a_frictionless_elastic_bounce_is_kept_with_the_potential_of_the_scene():
    scene = on_ground(ns.Material(mu=0.0, e=1.0))
    scene.body(ns.Box(0.2, 0.1), mass=1.0, position=(0, 0.5), turn=0.3, spin=1.0, name="box")
    solution = ns.simulate(scene.system(), (0, 1.0), *scene.state(), integrator=ns.EventDriven(1e-9))
    m, moment = 1.0, (0.2**2 + 0.1**2) / 12
    energy = 0.5 * solution.u**2 @ [m, m, moment] + m * G * solution.q[:, 1]
    np.testing.assert_allclose(energy, energy[0], rtol=1e-7)


def test_pairs_of_materials_are_parameters_named_after_the_bodies():
    rubber, steel = ns.Material(mu=0.8, name="rubber"), ns.Material(mu=0.2, e=0.5, name="steel")
    scene = on_ground(rubber)
    scene.body(ns.Disc(0.1), mass=1.0, material=steel, name="left disc", position=(0, 1))
    scene.body(ns.Disc(0.1), mass=1.0, material=steel, name="right", position=(1, 1))
    scene.pair(rubber, steel, mu=0.7)
    system = scene.system([("left disc", "ground"), ("left disc", "right")])
    assert system.parameter_values == pytest.approx(
        {"mu_left_disc_ground": 0.7, "e_left_disc_ground": 0.0, "mu_left_disc_right": 0.2, "e_left_disc_right": 0.5}
    )
    assert (system.with_parameters(mu_left_disc_ground=0.1).laws != system.laws).sum(axis=1).tolist() == [1, 0]
    assert system.parameters.coordinates[3] == ("x of right", "m")


def test_scene_that_has_grown_is_not_taken_for_what_it_was():
    scene = on_ground()
    scene.body(ns.Disc(0.1), mass=1.0, position=(0, 0.1), name="first")
    assert as_system(scene).n_c == 1
    scene.body(ns.Disc(0.1), mass=1.0, position=(1, 0.1), name="second")
    assert as_system(scene).n_c == 3


def refused(scene, pairs=None):
    with pytest.raises(ns.InvalidInput) as refusal:
        scene.system(pairs)
    return str(refusal.value)


def test_what_touches_along_faces_is_refused_by_name_with_the_cure():
    scene = on_ground()
    scene.fixed(ns.Segment((0, 0), (1, 1)), name="wall")
    scene.body(ns.Box(0.1, 0.1), mass=1.0, position=(0, 1), name="box")
    scene.body(ns.Disc(0.1), mass=1.0, position=(1, 3), name="disc")
    assert "wall and box, Segment((0.0, 0.0), (1.0, 1.0)) and Box(0.1, 0.1), may touch along faces" in refused(scene)
    assert "MoreauJean(dt)) takes it" in refused(scene, [("box", "disc")])
    assert scene.system([("box", "ground"), ("disc", "ground")]).n_c == 5


@pytest.mark.parametrize(
    ("pairs", "message"),
    [
        (3, "pairs must"),
        (("disc", "ground"), "a pair must be a tuple of the names of two bodies; got 'disc'"),
        ([(1, "disc")], "there is no body 1; known: disc, ground, lid"),
        ([("disc",)], r"a pair has the names of two bodies"),
        ([("disc", "disc")], "a pair is one of two bodies, at least one of them dynamic"),
        ([("ground", "lid")], "a pair is one of two bodies, at least one of them dynamic"),
        ([("disc", "grund")], "there is no body 'grund'; did you mean 'ground'"),
        ([("disc", "ground"), ("ground", "disc")], "pairs names two bodies twice"),
    ],
)
def test_bad_pairs_are_named(pairs, message):
    scene = on_ground()
    scene.fixed(ns.HalfPlane((0, -1), -3), name="lid")
    scene.body(ns.Disc(0.1), mass=1.0, position=(0, 1), name="disc")
    with pytest.raises(ns.InvalidInput, match=message):
        scene.system(pairs)


def test_scenes_without_a_system_say_why():
    scene = on_ground()
    assert "no body of the scene moves by forces" in refused(scene)
    with pytest.raises(ns.InvalidInput, match="no body of the scene moves by forces"):
        scene.state()
    scene.body(ns.Disc(0.1), mass=1.0, name="a b", position=(0, 1))
    scene.body(ns.Disc(0.1), mass=1.0, name="a_b", position=(1, 1))
    assert "two pairs of bodies would both have a coefficient e_ground_a_b; give a_b another name" in refused(scene)
    scene.pair("felt", "felt", mu=0.1)
    assert "scene.pair names a material 'felt'" in refused(scene)
    scene.kinematic(ns.Disc(0.1), motion=lambda t: (t, 0), name="piston")
    assert "piston moves as a function says" in refused(scene)
    with pytest.raises(ns.InvalidInput, match="lid is a half-plane that turns"):
        turning = on_ground()
        turning.kinematic(UP, spin=1.0, name="lid")
        turning.system()


def guided_and_joined():
    """A guided body that turns, on a dynamic one and on one that a pin of it holds; a guided half-plane; belts."""
    scene = ns.Scene(gravity=(0.5, -G), material=ns.Material(mu=0.4, e=0.2))
    scene.kinematic(ns.HalfPlane((-0.3, 1)), position=(0.1, -0.2), turn=0.2, velocity=(0.3, 0.2), name="lift",
                    surface_velocity=(0.7, 0.1))  # fmt: skip
    scene.kinematic(ns.Compound((ns.Disc(0.3), (0.2, 0.1))), position=(-2, 0.5), turn=0.4, velocity=(0.4, -0.2),
                    spin=1.5, name="cam", surface_velocity=(0.4, -0.2))  # fmt: skip
    scene.body(ns.Disc(0.2), mass=1.5, position=(-1, 2), turn=-0.4, name="ball", surface_velocity=(0.3, 0.0))
    scene.body(ns.Compound((ns.Disc(0.1), (0.5, 0.2)), (ns.Disc(0.3), (0, 0))), mass=1.0, position=(1, 3), name="rod")
    scene.joint("cam", "rod", at=(0, 1), name="pin")
    scene.joint("rod", "ball", at=(0.3, 2), name="link")
    return scene, scene.system()


def test_rows_of_guided_and_joined_bodies_are_the_rates_of_their_gaps():
    _, system = guided_and_joined()
    assert [contact.name for contact in system.contacts[-4:]] == ["pin x", "pin y", "link x", "link y"]
    for q, u in states(system):
        along = relative_at_times(system, q, u)
        rate = slope_of(lambda s, q=q, u=u: system.evaluate(GAP, 0.7 + s, q + s * u, u))
        np.testing.assert_allclose(along(0.0)[:, 0], rate, atol=BY_DIFFERENCES * np.abs(rate).max())
        rates, slope = system.evaluate(ROW_RATES, 0.7, q, u), slope_of(along)
        has_friction = system.kinds[:, 1] > 0  # a joint has no tangential row
        np.testing.assert_allclose(rates[:, 0], slope[:, 0], atol=BY_DIFFERENCES * np.abs(slope).max())
        of_friction = rates[has_friction, 1], slope[has_friction, 1]
        np.testing.assert_allclose(*of_friction, atol=BY_DIFFERENCES * np.abs(slope).max())


def relative_at_times(system, q, u, t=0.7):
    """Contact velocities (n_c, 2) along q + s u at the time t + s."""

    def along(s):
        at = t + s, q + s * u, u
        normal = system.evaluate(NORMAL, *at) @ u + system.evaluate(GAP_RATE, *at)
        tangent = system.evaluate(TANGENT, *at)[:, 0] @ u + system.evaluate(SURFACE_VELOCITY, *at)[:, 0]
        return np.stack([normal, tangent], axis=1)

    return along


def test_a_disc_on_a_guided_one_slides_as_fast_as_their_surfaces_pass_one_another():
    scene = ns.Scene(gravity=(0, -G), material=ns.Material(mu=0.4))
    scene.kinematic(ns.Disc(0.3), velocity=(0.5, 0), spin=2.0, name="roller")
    scene.body(ns.Disc(0.2), mass=1.0, position=(0, 0.5), velocity=(0.1, 0), spin=-3.0, name="disc")
    system, (q, u) = scene.system(), scene.state()
    gamma = relative_at_times(system, q, u, t=0.0)(0.0)[0]
    # at the top of the roller: 0.5 - 0.3*2 along x; at the bottom of the disc: 0.1 + 0.2*(-3)
    np.testing.assert_allclose(gamma, [0.0, (0.1 - 0.6) - (0.5 - 0.6)], rtol=1e-14, atol=1e-15)


def test_only_a_guided_body_makes_functions_read_the_time():
    for (_, system), reads in ((various(), False), (guided_and_joined(), True)):
        assert system.reads(GAP, "t") is reads and system.reads(ROW_RATES, "t") is reads


def test_a_scene_that_did_not_change_has_one_system():
    scene, first = various()
    pairs = [("wedge", "slope"), ("dumbbell", "roller"), ("slope", "disc"), ("disc", "dumbbell")]
    assert scene.system(pairs) is first and scene.system(pairs[:1]) is not first
    scene.bodies[1].position[0] += 0.1
    assert scene.system(pairs) is not first


def resting_rod(mu=2.0):
    return rod_scene(math.radians(60), 0.0, -1.0, mu)


@pytest.mark.parametrize("state", [None, "scene", "pair", "names"])
def test_a_scene_is_classified_at_its_start_or_at_a_state_that_is_given(state):
    scene, other = resting_rod(), rod_scene(math.radians(60), 6.0, -1.0, 2.0)
    given = {
        None: None, "scene": other, "pair": other.state(),
        "names": dict(zip(("x' of rod", "y' of rod", "angle' of rod"), other.state()[1], strict=True)),
    }[state]  # fmt: skip
    if state == "names":
        given = {name.replace("' of rod", " of rodot"): value for name, value in given.items()}
        given = dict(zip([name for name, _ in scene.system().described.rates], given.values(), strict=True))
    found = ns.classify(scene, state=given)
    assert found.n_solutions == (0 if state is None else 2)


def test_maps_linearisations_cycles_and_sweeps_take_a_scene_as_its_system():
    scene = resting_rod()
    system = scene.system()
    chart = ns.paradox_map(scene, progress=False, mu_ground_rod=[0.5, 2.0])
    assert chart.n_solutions.values.tolist() == [1, 0]
    assert ns.critical_friction(scene) == ns.critical_friction(system, scene.state()[0])
    task = ns.RunTask(scene, t_span=(0, 0.01), integrator=ns.MoreauJean(1e-3))
    found = ns.sweep(task, {"mu_ground_rod": [0.0, 0.2]}, progress=False)
    slip = found.u.values[:, 0]
    assert slip[0] == pytest.approx(-1.0, abs=1e-12) and slip[1] > -1.0  # no friction: nothing along x


def test_small_motions_of_a_pinned_rod_have_the_frequency_of_the_pendulum():
    scene = ns.Scene(gravity=(0, -G))
    scene.fixed(ns.Disc(0.01), name="hook")
    scene.body(ns.Box(0.02, 1.0), mass=1.0, inertia=1 / 12, position=(0, -0.5), name="rod")
    scene.joint("hook", "rod", at=(0, 0), name="pin")
    small = ns.linearise(scene)
    # m g l/2 over m l^2/3
    np.testing.assert_allclose(small.frequencies, np.sqrt(1.5 * G), rtol=1e-12)


@pytest.mark.parametrize(
    "ask",
    [
        ns.classify, ns.linearise, ns.equilibrium, ns.limit_cycle, ns.RunTask,
        lambda scene: ns.paradox_map(scene, x=[0.0, 1.0]),
        lambda scene: ns.critical_friction(scene, [0.0]),
    ],
)  # fmt: skip
def test_what_the_system_of_a_scene_does_not_hold_is_refused_with_the_way_out(ask):
    scene = on_ground()
    scene.body(ns.Box(0.1, 0.1), mass=1.0, position=(0, 0.05), name="box")
    scene.body(ns.Box(0.1, 0.1), mass=1.0, position=(0, 0.15), name="lid")
    with pytest.raises(ns.InvalidInput, match=r"box and lid, .* may touch along faces.*MoreauJean\(dt\)\) takes it"):
        ask(scene)


def smooth(e=0.0, gravity=(0, 0, -G)):
    return ns.Scene(gravity=gravity, material=ns.Material(mu=0.0, e=e))


def spheres_of_all_kinds():
    """On a slanted ground that is put and turned, a fixed sphere named first, and one another."""
    scene = smooth(0.3)
    tilt = (math.cos(0.1), 0, math.sin(0.1), 0)
    scene.fixed(ns.Sphere(0.3), position=(0.5, -2, 1), name="knob")
    scene.body(ns.Sphere(0.2), mass=1.5, position=(0, 0, 2), name="a")
    scene.fixed(ns.HalfSpace((0.3, 0.2, 1), 0.1), position=(0.1, 0.2, -0.3), turn=tilt, name="slope")
    scene.body(ns.Sphere(0.1), mass=0.7, position=(1, 0, 2), name="b")
    return scene


def test_rows_of_spheres_are_the_gradients_of_their_gaps_and_their_rates():
    system = spheres_of_all_kinds().system()
    assert (system.n_q, system.n_c) == (6, 5)
    for q, u in states(system):
        W_N = system.evaluate(NORMAL, 0.0, q, u)
        slope = slope_of(lambda s, q=q, u=u: system.evaluate(GAP, 0.0, q + s * u, u))
        np.testing.assert_allclose(W_N @ u, slope, atol=BY_DIFFERENCES * np.abs(slope).max())
        slope = slope_of(lambda s, q=q, u=u: system.evaluate(NORMAL, 0.0, q + s * u, u) @ u)
        rates = system.evaluate(ROW_RATES, 0.0, q, u)[:, 0]
        np.testing.assert_allclose(rates, slope, atol=BY_DIFFERENCES * np.abs(slope).max())


def test_gaps_of_spheres_are_known_to_a_rounding_of_their_places():
    scene = smooth()
    scene.fixed(ns.HalfSpace((0.3, 0.2, 1), 0.1), position=(0.1, 0.2, -0.3), name="slope")
    normal = np.array([0.3, 0.2, 1]) / np.linalg.norm([0.3, 0.2, 1])
    foot = np.array([0.1, 0.2, -0.3]) + 0.1 * normal
    scene.body(ns.Sphere(0.2), mass=1, position=foot + (0.2 + 1e-9) * normal, name="a")
    scene.body(ns.Sphere(0.1), mass=1, position=foot + (0.5 + 3e-9) * normal, name="b")
    gaps = scene.system().evaluate(GAP, 0.0, *scene.state())
    np.testing.assert_allclose(gaps, [1e-9, 0.4 + 3e-9, 2e-9], atol=1e-15)


def test_sphere_rebounds_from_a_slope_at_the_time_of_its_parabola():
    e, r, height = 0.5, 0.1, 1.0
    scene = smooth(e)
    n = np.array([0.6, 0.0, 0.8])
    scene.fixed(ns.HalfSpace(n), name="slope")
    scene.body(ns.Sphere(r), mass=2.0, position=(r + height) * n, name="ball")
    t_1 = math.sqrt(2 * height / (0.8 * G))
    solution = ns.simulate(scene.system(), (0, 1.2 * t_1), *scene.state(), integrator=ns.EventDriven(1e-11))
    assert solution.events[0].t == pytest.approx(t_1, abs=1e-10)
    v = np.array([0, 0, -G * t_1])
    v -= (1 + e) * (v @ n) * n
    np.testing.assert_allclose(solution.u[-1], v + [0, 0, -G * 0.2 * t_1], atol=1e-9)


@pytest.mark.upkeep
@pytest.mark.parametrize("dim", [2, 3])
def test_a_cradle_in_contact_is_told_apart_from_gaps_of_a_nanometre(dim):
    """Apart by 1e-9 m the balls are struck one after the other, and the last one flies; in contact at once, by Newton's
    law, which hands what it may to all, or by the law that strikes one after the other."""
    last = {}
    for gap, impact in ((1e-9, "newton"), (0.0, "newton"), (0.0, "sequential")):
        scene = ns.Scene(gravity=(0,) * dim, material=ns.Material(mu=0.0, e=1.0))
        for k in range(5):
            place = np.eye(dim)[0] * (0.2 + gap) * k - (k == 0) * 0.1 * np.eye(dim)[0]
            ball = ns.Disc(0.1) if dim == 2 else ns.Sphere(0.1)
            scene.body(ball, mass=1.0, position=place, velocity=np.eye(dim)[0] * (k == 0), name=f"ball {k}")
        system = scene.system([(f"ball {k}", f"ball {k + 1}") for k in range(4)])
        if impact == "sequential":
            system = replace(system, contacts=[replace(contact, impact=impact) for contact in system.contacts])
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ns.SimultaneousImpactWarning)
            solution = ns.simulate(system, (0, 0.5), *scene.state(), integrator=ns.EventDriven(1e-12))
        v = solution.u[-1].reshape(5, 3)[:, 0]
        assert v.sum() == pytest.approx(1.0, abs=1e-12) and (v**2).sum() == pytest.approx(1.0, abs=1e-11)
        last[gap, impact] = v[-1]
    assert last[1e-9, "newton"] == pytest.approx(1.0, abs=1e-7) and last[0.0, "newton"] < 0.9
    assert last[0.0, "sequential"] == pytest.approx(1.0, abs=1e-12)


def test_what_touches_along_faces_in_space_is_refused_by_name_with_the_cure():
    scene = ns.Scene(gravity=(0, 0, -G), material=ns.Material(mu=0.3))
    scene.fixed(ns.HalfSpace((0, 0, 1)), name="ground")
    scene.fixed(ns.Box(1, 1, 1), name="step")
    scene.body(ns.Sphere(0.1), mass=1.0, position=(0, 0, 1), name="ball")
    said = refused(scene)
    assert "step and ball, Box(1, 1, 1) and Sphere(radius=0.1), may touch along faces" in said
    assert "MoreauJean(dt)) takes it" in said
