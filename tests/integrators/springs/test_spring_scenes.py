"""Scenes with compliant contacts: closed forms, the `System` of the same mechanics, invariants, and what is refused."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from models.scenes import BoxStack

G = 9.81


def ball(k, zeta, v=1.0, dim=2, **options):
    """A ball of 2 kg without weight that flies against a wall; its velocities before and after, and the run."""
    scene = ns.Scene(gravity=(0.0,) * dim)
    up = np.eye(dim)[-1]
    scene.fixed(ns.HalfPlane(up) if dim == 2 else ns.HalfSpace(up))
    scene.body(ns.Disc(0.1) if dim == 2 else ns.Sphere(0.1), mass=2.0, position=0.1001 * up, velocity=-v * up, name="b")
    span = 0.0002 / v + 4.0 * math.sqrt(2.0 / k)
    return ns.simulate(scene, (0, span), integrator=ns.Penalty(k, damping_ratio=zeta, **options))


def block(k=1e6, v=1.0, mu=0.3, tilt=0.0, dim=2, a=(0.4, 0.2, 0.1), depth=None, **options):
    """A block of 2 kg on the ground, at the depth where its springs bear it, and the options of its run."""
    down = np.array([math.sin(tilt), -math.cos(tilt)] if dim == 2 else [math.sin(tilt), 0.0, -math.cos(tilt)])
    scene = ns.Scene(gravity=G * down, material=ns.Material(mu=mu))
    up = np.eye(dim)[-1]
    scene.fixed(ns.HalfPlane(up) if dim == 2 else ns.HalfSpace(up), name="ground")
    n = 2 if dim == 2 else 4
    depth = 2.0 * G * math.cos(tilt) / (n * k) if depth is None else depth
    sizes = (a[0], a[2]) if dim == 2 else a
    velocity = v * np.eye(dim)[0]
    scene.body(ns.Box(*sizes), mass=2.0, position=(0.5 * a[2] - depth) * up, velocity=velocity, name="block")
    return scene, ns.Penalty(k, **{"damping_ratio": 0.5, **options})


def not_closed(solution):
    """What is missing between the kinetic energy and the works, and between the springs and theirs [J]."""
    change = {name: float(column[-1] - column[0]) for name, column in solution.ledger.items()}
    works = sum(change[name] for name in ("force", "friction", "normal", "surface"))
    return change["kinetic"] - works, change["normal"] + change["friction"] + change["elastic"] - change["damping"]


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("zeta", [0.0, 0.2, 0.9])
def test_damped_ball_rebounds_with_the_closed_form_restitution(zeta, dim):
    """Clipped contact: e = exp(-2 zeta acos(zeta)/sqrt(1 - zeta^2)) (docs/penalty.md, (4)).

    Its tolerance is 1e-8 a step; some hundred steps are taken."""
    e = math.exp(-2 * zeta * math.acos(zeta) / math.sqrt(1 - zeta**2))
    with pytest.warns(ns.PenetrationWarning, match="the springs are soft"):
        solution = ball(1e5, zeta, dim=dim)
    assert abs(solution["b"].velocity[-1, -1] - e) < 1e-6


def test_undamped_ball_sinks_by_its_speed_over_omega_and_returns_on_time():
    """Deepest at v sqrt(m/k) in the half period pi sqrt(m/k), closed forms of the harmonic motion."""
    solution = ball(1e7, 0.0, v=0.1)
    depth, period = 0.1 * math.sqrt(2.0 / 1e7), math.pi * math.sqrt(2.0 / 1e7)
    lowest = solution["b"].position[:, 1].min()
    assert abs(solution["b"].velocity[-1, 1] - 0.1) < 1e-7  # rtol 1e-8 of a step; some tens of them have a kink
    assert lowest > 0.1 - depth * (1 + 1e-6) and lowest < 0.1 - 0.8 * depth
    t = solution["b"].t
    free = solution["b"].position[-1, 1] - 0.1 - 0.1 * (t[-1] - 0.0001 / 0.1 - period)
    assert abs(free) < 1e-7 * 0.1 * t[-1] + 1e-10


def test_a_stack_sinks_to_the_depth_that_bears_it():
    """Every contact at its load over n k, with damping, after a second; n points bear a box."""
    for dim, points, k in ((2, 2, 1e7), (3, 4, 1e6)):
        stack = BoxStack(n=5, dim=dim)
        solution = ns.simulate(stack, (0, 1), integrator=ns.Penalty(k, damping_ratio=0.5), t_eval=[1.0])
        depths = np.cumsum(stack.loads() / (points * k))
        sunk = solution.position[0, 1:, -1] - solution.position[-1, 1:, -1]
        assert np.abs(sunk / depths - 1).max() < 1e-8
        assert abs(solution.contacts().of("ground").P_N.sum() / stack.loads()[0] - 1) < 1e-8  # forces [N]


def test_a_block_slides_by_v_squared_over_two_mu_g():
    """From the depth at which it is borne its slide differs from Coulomb's by the way of the spring, mu m g/k_T, and by
    the torque of friction that the springs give way to, of the same order."""
    for dim in (2, 3):
        for k in (1e6, 1e8):
            scene, penalty = block(k, dim=dim)
            solution = ns.simulate(scene, (0, 0.6), integrator=penalty, t_eval=[0.6])
            way = 1.0 / (2 * 0.3 * G)
            assert abs(solution["block"].position[-1, 0] - way) < 3 * 2.0 * G / k
            assert np.abs(solution["block"].velocity[-1]).max() < 1e-6


def test_a_block_below_its_limit_hangs_on_its_tangential_springs():
    """x = m g sin(alpha)/(n k_T) and no creep: k_T = ratio k at each of n points, and the torque about its centre turns
    it a little."""
    for dim, n in ((2, 2), (3, 4)):
        scene, penalty = block(v=0.0, mu=0.5, tilt=0.2, dim=dim, friction=ns.TangentialSpring(ratio=0.5))
        solution = ns.simulate(scene, (0, 1), integrator=penalty, t_eval=[0.7, 1.0])
        x = solution["block"].position[:, 0]
        # tilted by the torque m g sin(alpha) h/2 over the springs at +-a/2: the lower edge moves by h/2 times that
        tilt = 2.0 * G * math.sin(0.2) * 0.05 / (n * 1e6 * 0.2**2)
        assert abs(x[-1] / (2.0 * G * math.sin(0.2) / (n * 0.5e6) + 0.05 * tilt) - 1) < 1e-4
        assert abs(x[2] - x[1]) < 1e-12


def two_discs(mu):
    scene = ns.Scene(gravity=(0, -G), material=ns.Material(mu=mu))
    scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    scene.body(ns.Disc(0.1), mass=2.0, position=(0, 0.1), velocity=(1.0, 0.0), name="low")
    scene.body(ns.Disc(0.08), mass=1.0, position=(0.05, 0.28), velocity=(0.0, -1.0), spin=5.0, name="high")
    return scene


@pytest.mark.upkeep
@pytest.mark.filterwarnings("ignore::nonsmooth.errors.PenetrationWarning")
def test_scene_and_system_of_the_same_mechanics_agree():
    """Two methods: explicit steps on found contacts, implicit ones with located events on counted contacts.

    Without friction the laws are the same, and the distance is the tolerances'. Friction is regularised, the one law
    that both have: it acts midway between the surfaces in a scene, on the undeformed ones in a system, so that its
    lever differs by half the depth, and the motion by a part of that, v sqrt(m/k)."""
    differences = []
    for k, mu in ((1e6, 0.0), (1e6, 0.4), (1e8, 0.4)):
        scene = two_discs(mu)
        penalty = ns.Penalty(k, damping_ratio=0.3, friction=ns.Regularised(0.05), rtol=1e-9, atol=1e-11)
        found = ns.simulate(scene, (0, 0.15), integrator=penalty, t_eval=[0.15])
        counted = ns.simulate(scene.system(), (0, 0.15), *scene.state(), integrator=penalty, t_eval=[0.15])
        u = np.concatenate((found.velocity[-1, 1:], found.spin[-1, 1:, None]), axis=1).ravel()
        differences.append(np.abs(u - counted.u[-1])[[0, 1, 3, 4]].max())
    assert differences[0] < 1e-6
    assert differences[1] < 2 * math.sqrt(1 / 1e6)
    assert differences[2] < 0.2 * differences[1]


@pytest.mark.upkeep
def test_frictionless_compliant_beads_agree_with_their_system():
    """Five discs in a row, struck at one end: impacts that run through springs one after the other."""
    scene = ns.Scene(gravity=(0, 0))
    for k in range(5):
        scene.body(ns.Disc(0.1), mass=1.0 + 0.2 * k, position=(0.2 * k, 0), velocity=(float(k == 0), 0), name=f"b{k}")
    penalty = ns.Penalty(1e7)
    found = ns.simulate(scene, (0, 0.02), integrator=penalty, t_eval=[0.02])
    counted = ns.simulate(scene.system(), (0, 0.02), *scene.state(), integrator=penalty, t_eval=[0.02])
    assert np.abs(found.velocity[-1, :, 0] - counted.u[-1, ::3]).max() < 1e-6
    assert abs(found.velocity[-1, :, 0] @ (1.0 + 0.2 * np.arange(5)) - 1.0) < 1e-13  # momentum, to rounding


@pytest.mark.filterwarnings("ignore::nonsmooth.errors.PenetrationWarning")
@pytest.mark.parametrize("dim", [2, 3])
def test_energy_closes_to_the_tolerance(dim):
    """The two balances of the ledger: the tolerance of all steps together, of a Joule; and both shrink with it."""
    left = []
    for rtol in (1e-5, 1e-8):
        scene, penalty = block(dim=dim, mu=0.3, v=1.0, depth=0.0, rtol=rtol, atol=1e-2 * rtol)
        scene.body(
            ns.Disc(0.1) if dim == 2 else ns.Sphere(0.1), mass=1.0, position=(0.1,) + (0.0,) * (dim - 2) + (0.3,),
            velocity=(0.5,) + (0.0,) * (dim - 2) + (-1.0,),
        )  # fmt: skip
        solution = ns.simulate(scene, (0, 0.4), integrator=penalty)
        left.append(abs(not_closed(solution)[0]))
        change = solution.ledger["friction"] + solution.ledger["normal"] + solution.ledger["elastic"]
        assert np.diff(change).max() < 2 * rtol  # springs, dampers and sliders together give nothing
        assert left[-1] < solution.stats.steps * rtol
    assert left[1] < 1e-2 * left[0]


def test_spinning_box_keeps_angular_momentum_and_energy():
    """Free rotation about unlike moments: no contact, the error is that of the method."""
    scene = ns.Scene(gravity=(0, 0, 0))
    scene.body(ns.Box(0.3, 0.2, 0.1), mass=1.0, spin=(0.1, 5.0, 0.2), name="box")
    solution = ns.simulate(scene, (0, 2), integrator=ns.Penalty(1e4, rtol=1e-9, atol=1e-11), t_eval=[2.0])
    kinetic = solution.ledger["kinetic"]
    assert abs(kinetic[-1] / kinetic[0] - 1) < 1e-7
    rigid = ns.simulate(scene, (0, 2), integrator=ns.MoreauJean(2e-4), t_eval=[2.0])
    assert np.abs(solution["box"].spin[-1] - rigid["box"].spin[-1]).max() < 2e-5  # of second order, 2e-4 s


def test_a_box_on_a_turning_table_turns_with_it():
    """What sticks turns with both: its springs turn with the mean spin. It follows at the centre without slip."""
    scene = ns.Scene(gravity=(0, 0, -G), material=ns.Material(mu=0.5))
    scene.kinematic(ns.Box(1.0, 1.0, 0.1), position=(0, 0, -0.05), spin=(0, 0, 1.0), name="table")
    scene.body(ns.Box(0.2, 0.2, 0.1), mass=1.0, position=(0, 0, 0.05), spin=(0, 0, 1.0), name="box")
    solution = ns.simulate(scene, (0, 1), integrator=ns.Penalty(1e5, damping_ratio=0.5), t_eval=[1.0])
    assert abs(solution["box"].spin[-1, 2] - 1.0) < 1e-6
    assert np.abs(solution["box"].position[-1, :2]).max() < 1e-6


def test_sphere_slips_until_it_rolls_at_five_sevenths():
    """Closed form 5/7 v, in space, on a sphere whose contact travels over it; its spring makes O(1/k) of it."""
    scene = ns.Scene(gravity=(0, 0, -G), material=ns.Material(mu=0.3))
    scene.fixed(ns.HalfSpace((0, 0, 1)))
    scene.body(ns.Sphere(0.1), mass=1.0, position=(0, 0, 0.1 - G / 1e6), velocity=(1.0, 0.5, 0), name="ball")
    solution = ns.simulate(scene, (0, 0.3), integrator=ns.Penalty(1e6, damping_ratio=0.5), t_eval=[0.3])
    assert np.abs(solution["ball"].velocity[-1, :2] - 5 / 7 * np.array([1.0, 0.5])).max() < 1e-4
    assert np.abs(solution["ball"].spin[-1] - 5 / 7 * np.array([-5.0, 10.0, 0.0])).max() < 1e-3


@pytest.mark.filterwarnings("ignore::nonsmooth.errors.PenetrationWarning")
def test_a_pile_that_falls_together_comes_to_rest_under_its_weight():
    """Rooms for contacts and springs grow in the middle of steps."""
    rng = np.random.default_rng(3)
    scene = ns.Scene(gravity=(0, -G), material=ns.Material(mu=0.5))
    for normal, offset in (((0, 1), 0.0), ((1, 0), -0.4), ((-1, 0), -0.4)):
        scene.fixed(ns.HalfPlane(normal, offset))
    for k in range(30):
        x, y = 0.12 * (k % 6) - 0.3 + 0.01 * rng.random(), 0.06 + 0.12 * (k // 6)
        scene.body(ns.Disc(0.05), density=1000, position=(x, y))
    solution = ns.simulate(scene, (0, 3), integrator=ns.Penalty(1e6, damping_ratio=0.3, rtol=1e-5), t_eval=[3.0])
    weight = solution.scene.bodies[3].density * math.pi * 0.05**2 * 30 * G
    ground = sum(solution.contacts().of(f"body {k}").P[:, 1].sum() * sign for k, sign in ((0, 1), (1, 1), (2, 1)))
    assert abs(ground / weight - 1) < 1e-3
    assert np.abs(solution.velocity[-1]).max() < 1e-3
    assert not_closed(solution)[0] < 1e-3


def test_deep_springs_and_passing_through_are_told():
    """Too soft for its motion: a warning that names the depth, the run being what it is."""
    with pytest.warns(ns.PenetrationWarning, match="a larger stiffness ends this"):
        ball(1e4, 0.0, v=2.0)


def test_thin_and_fast_is_told():
    """A bullet through a wall of 1 mm: soft springs let it through, with a word."""
    scene = ns.Scene(gravity=(0, 0))
    scene.fixed(ns.Box(1e-3, 1.0))
    scene.body(ns.Disc(1e-3), mass=0.01, position=(-0.01, 0), velocity=(100.0, 0), name="bullet")
    with pytest.warns(ns.PenetrationWarning):
        solution = ns.simulate(scene, (0, 1e-3), integrator=ns.Penalty(1e5), t_eval=[1e-3])
    assert solution["bullet"].position[-1, 0] > 0  # it went through


def test_a_stiffness_beyond_rounding_is_refused():
    """The rounding of a gap, 1e-16 m, times omega is more than the tolerance can be."""
    scene, _ = block()
    scene.body(ns.Disc(0.1), mass=1e-6, position=(100.0, 1.0))
    with pytest.raises(ns.InvalidInput, match="rtol = 1e-13 cannot be met: take a smaller stiffness"):
        ns.simulate(scene, (0, 1), integrator=ns.Penalty(1e14, rtol=1e-13))


def test_a_law_without_a_stiffness_is_refused_where_a_spring_would_need_it():
    scene, _ = block()
    with pytest.raises(ns.InvalidInput, match="hunt-crossley has no stiffness"):
        ns.simulate(scene, (0, 1), integrator=ns.Penalty(1e6, law="hunt-crossley"))


def test_a_system_takes_no_tangential_spring():
    with pytest.raises(ns.InvalidInput, match="a System sticks without a spring"):
        from models import BouncingBall

        bouncing = BouncingBall()
        start = bouncing.state(height=1.0)
        ns.simulate(bouncing, (0, 1), *start, integrator=ns.Penalty(1e6, friction=ns.TangentialSpring()))


def test_records_end_at_their_times_every_steps_and_budgets():
    """At t_eval exactly; every so many steps; and a budget leaves what was done."""
    scene, penalty = block()
    at = ns.simulate(scene, (0, 0.1), integrator=penalty, t_eval=[0.03, 0.1])
    assert at.t.tolist() == [0.0, 0.03, 0.1]
    all_steps = ns.simulate(scene, (0, 0.1), integrator=penalty)
    assert len(all_steps.t) == all_steps.stats.steps + 1 and all_steps.t[-1] == 0.1
    some = ns.simulate(scene, (0, 0.1), integrator=penalty, every=7)
    assert some.t.tolist() == [*all_steps.t[:-1:7].tolist(), 0.1]
    assert np.array_equal(some.velocity[-1], all_steps.velocity[-1])
    few = ns.simulate(scene, (0, 0.1), integrator=penalty, max_steps=5, on_failure="return")
    assert few.status == ns.Status.BUDGET_SPENT and few.stats.steps == 5


def test_what_was_saved_is_loaded_with_its_springs(tmp_path):
    """Figures and columns come back."""
    scene, penalty = block()
    run = ns.simulate(scene, (0, 0.05), integrator=penalty, t_eval=[0.05])
    again = ns.SceneSolution.load(run.save(tmp_path / "run.npz"), scene)
    assert again.stats == run.stats and again.ledger["elastic"].tolist() == run.ledger["elastic"].tolist()
    assert "longest step allowed" in again.summary()
