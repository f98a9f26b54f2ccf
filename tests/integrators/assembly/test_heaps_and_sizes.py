"""Heaps, friction of box on box, sizes from 1e-3 to 1e3 m, masses of 1 to 1e6, orders of bodies, a million steps."""

import itertools
import math

import numpy as np
import pytest

import nonsmooth as ns
from models.scenes import SphereBox
from nonsmooth.integrators.assembly.progress import PREDICT
from nonsmooth.integrators.assembly.project import SHARE
from nonsmooth.integrators.assembly.step import DRIVEN_IN
from nonsmooth.runs.scene_run import SceneRun
from tests.scenes.spatial.test_solids import shape_of

G, DT = 9.81, 2e-3
HEXAGON = ns.Polygon(0.05 * np.stack([np.cos(np.arange(6) * math.pi / 3), np.sin(np.arange(6) * math.pi / 3)], axis=1))
COARSE = ns.ContactSolver(tol=1e-5)


SEEDS = 16


def collapsed(mu, seed):
    """The slope [degrees] of what 44 hexagons fall into, by the mean height and the mean distance from the middle, of
    a triangle a third of its height and of half its base. They are laid in bond: one on the other some columns stand
    for seconds."""
    rng, scene = np.random.default_rng(seed), ns.Scene(gravity=(0, -G), material=ns.Material(mu=mu))
    scene.fixed(ns.HalfPlane((0, 1)), material=ns.Material(mu=0.8))
    for k in range(44):
        across = 0.12 * (k % 4 - 1.5) + 0.06 * (k // 4 % 2) + rng.uniform(-0.009, 0.009)
        scene.body(HEXAGON, density=1000, position=(across, 0.06 + 0.11 * (k // 4)), turn=rng.uniform(0, 1))
    x = ns.simulate(scene, (0, 1.5), integrator=ns.MoreauJean(DT, contacts=COARSE), every=1000).position[-1, 1:]
    return math.degrees(math.atan2(x[:, 1].mean(), np.abs(x[:, 0] - np.median(x[:, 0])).mean()))


@pytest.mark.upkeep
@pytest.mark.filterwarnings("ignore::nonsmooth.errors.ResidualWarning")
@pytest.mark.filterwarnings("ignore::nonsmooth.errors.PenetrationWarning")
def test_the_angle_of_repose_grows_with_friction():
    """Means of 16 heaps, which do not grow by 2.6 of their standard errors by chance in 199 of 200 cases. Of 40 heaps
    they are 4.6, 12.7 and 16.2 degrees with deviations of 0.6, 1.3 and 1.9: 22 and 6 standard errors."""
    angles = np.array([[collapsed(mu, seed) for seed in range(SEEDS)] for mu in (0.05, 0.2, 0.5)])
    mean, error = angles.mean(axis=1), angles.std(axis=1, ddof=1) / math.sqrt(SEEDS)
    assert (np.diff(mean) > 2.6 * np.hypot(error[1:], error[:-1])).all() and angles.max() < 45.0, (mean, error)


def falling_discs(seed, r=0.05, pitch=0.12, a_row=12):
    """Five hundred discs over a floor between two walls, in rows up to 5 m that are not quite regular."""
    rng, scene = np.random.default_rng(seed), ns.Scene(gravity=(0, -G), material=ns.Material(mu=0.5))
    scene.fixed(ns.HalfPlane((0, 1)))
    for side in (1, -1):
        scene.fixed(ns.HalfPlane((side, 0), -0.5 * pitch * a_row))
    for k in range(500):
        place = pitch * np.array([k % a_row - 0.5 * (a_row - 1), k // a_row + 0.5])
        scene.body(ns.Disc(r), density=1000, position=place + rng.uniform(-0.005, 0.005, 2))
    return scene


@pytest.mark.upkeep
@pytest.mark.filterwarnings("ignore::nonsmooth.errors.ResidualWarning")
@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2))])
def test_discs_that_fall_from_high_do_not_go_into_one_another(seed):
    """A step lets them in by a part of their size, and takes a share of what is there back: d < 0.8 d + 3e-4 r."""
    stats = ns.simulate(falling_discs(seed), (0, 1.0), integrator=ns.MoreauJean(DT), every=500).stats
    assert 0.0 < stats.worst_penetration < DRIVEN_IN[2] * 0.05 / SHARE


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("mu", [0.3, 1.2])
def test_a_box_on_a_box_slides_where_the_slope_is_beyond_its_coefficient(dim, mu):
    """On a fixed box, with gravity aslant: at 0.999 of mu nothing moves, at 1.001 with what is left of the pull."""
    for share in (0.999, 1.001):
        tilt = math.atan(share * mu)
        pull, press = G * math.sin(tilt), G * math.cos(tilt)
        scene = ns.Scene(gravity=(pull, -press) if dim == 2 else (pull, 0, -press), material=ns.Material(mu=mu))
        up = np.eye(dim)[-1]
        for k, add in enumerate((scene.fixed, scene.body)):
            sides = (4.0 - 3 * k, *(1.0,) * (dim - 2), 0.2)
            add(ns.Box(*sides), **({"density": 1000} if k else {}), position=0.2 * k * up, name=f"box {k}")
        box = ns.simulate(scene, (0, 0.5), integrator=ns.MoreauJean(DT))["box 1"]
        wanted = max(0.0, (pull - mu * press) * 0.5)
        assert box.velocity[-1, 0] == pytest.approx(wanted, rel=1e-9, abs=0.0)


@pytest.mark.parametrize("shape_of", [lambda r: ns.Disc(r), lambda r: ns.Box(2 * r, 2 * r), lambda r: ns.Sphere(r)],
                         ids=["discs", "boxes", "spheres"])  # fmt: skip
def test_sizes_from_a_millimetre_to_a_kilometre_stand_in_one_scene(shape_of):
    """Each on the ground by itself, the smallest on the largest: all at rest with their weights."""
    dim = 3 if isinstance(shape_of(1.0), ns.Sphere) else 2
    up, along = np.eye(dim)[-1], np.eye(dim)[0]
    scene = ns.Scene(gravity=-G * up, material=ns.Material(mu=0.5))
    scene.fixed((ns.HalfPlane if dim == 2 else ns.HalfSpace)(up), name="ground")
    sizes = [1e-3, 1e-1, 10.0, 1e3]
    for k, r in enumerate(sizes):
        scene.body(shape_of(r), density=1000, position=r * up - 3 * r * along, name=f"size {k}")
    scene.body(shape_of(1e-3), density=1000, position=(2e3 + 1e-3) * up - 3e3 * along, name="on top")
    sol = ns.simulate(scene, (0, 1.0), integrator=ns.MoreauJean(DT))
    assert np.abs(sol.position - sol.position[0]).max() < 1e-9
    densities = {ns.Disc: math.pi, ns.Box: 4.0, ns.Sphere: 4 / 3 * math.pi}
    mass = 1000 * densities[type(shape_of(1.0))] * np.array([*sizes, 1e-3]) ** dim
    for k, name in enumerate([*(f"size {k}" for k in range(3)), "on top"]):
        P = sol.contacts(1.0).of(name).P_N
        assert P.sum() == pytest.approx(G * DT * mass[k if name != "on top" else 4], rel=1e-9)


UPRIGHT = (math.sqrt(0.5), 0, math.sqrt(0.5), 0)
SMALL = {
    "box": (ns.Box(2e-3, 2e-3, 2e-3), (1, 0, 0, 0)), "sphere": (ns.Sphere(1e-3), (1, 0, 0, 0)),
    "capsule": (ns.Capsule(2e-3, 1e-3), (1, 0, 0, 0)), "cylinder": (ns.Cylinder(1e-3, 2e-3), UPRIGHT),
    "polyhedron": (ns.Polyhedron(1e-3 * np.array(list(np.ndindex(2, 2, 2))) * 2 - 1e-3), (1, 0, 0, 0)),
}  # fmt: skip


@pytest.mark.parametrize("shape", SMALL)
def test_what_is_small_falls_on_what_is_a_million_times_larger_and_lies_on_it(shape):
    """Of 1e-18 of its mass: the impulse that bears it is no digit of those of the island. At a part of 1e-15 it sank
    by 4 um, at 1e-18 it fell through, with a residual of 1e-16."""
    small, turn = SMALL[shape]
    for size in (1.0, 30.0, 1e3):
        scene = ns.Scene(gravity=(0, 0, -G), material=ns.Material(mu=0.6))
        scene.fixed(ns.HalfSpace((0, 0, 1)))
        scene.body(ns.Box(2 * size, 2 * size, size), density=1000, position=(0, 0, size / 2), name="large")
        for k in range(3 if shape in ("box", "polyhedron") else 1):  # one on the other
            place = (0.3 * size, -0.2 * size, size + 1e-3 + 4e-4 + 2.3e-3 * k)
            scene.body(small, density=1000, position=place, turn=turn, name=f"small {k}")
        awake = ns.MoreauJean(1e-3, contacts=ns.ContactSolver(may_sleep=False))
        sol = ns.simulate(scene, (0, 0.1), integrator=awake, every=100)
        for k in range(len(scene) - 2):
            body = sol[f"small {k}"]
            assert abs(body.position[-1, 2] - (size + 1e-3 + 2e-3 * k)) < 1e-15 * size + 1e-12, (size, k)
            assert np.abs(body.velocity[-1]).max() < 1e-12 and np.abs(body.spin[-1]).max() < 1e-9
        assert sol.stats.missed == 0 and sol.stats.worst_residual < 1e-8


def test_a_stack_whose_top_is_a_million_times_heavier_stands():
    """No setting touched; each step taken."""
    scene = ns.Scene(gravity=(0, 0, -G), material=ns.Material(mu=0.5))
    scene.fixed(ns.HalfSpace((0, 0, 1)), name="ground")
    for k in range(10):
        scene.body(ns.Box(0.2, 0.2, 0.2), density=1e9 if k == 9 else 1e3, position=(0, 0, 0.1 + 0.2 * k))
    awake = ns.MoreauJean(DT, contacts=ns.ContactSolver(may_sleep=False))
    sol = ns.simulate(scene, (0, 1.0), integrator=awake)
    assert np.abs(sol.position - sol.position[0]).max() < 1e-10 and sol.stats.missed == 0
    assert sol.contacts(1.0).of("ground").P_N.sum() == pytest.approx(8.0 * (9 + 1e6) * G * DT, rel=1e-9)


PRISM = ns.Polyhedron([(0.15 * math.cos(k * math.pi / 4), 0.15 * math.sin(k * math.pi / 4), z)
                       for k in range(8) for z in (-0.1, 0.1)])  # fmt: skip


@pytest.mark.parametrize("heavy", [(2,), (4,), (3, 7)])
@pytest.mark.parametrize(
    "shape, turn", [(ns.Cylinder(0.15, 0.2), UPRIGHT), (PRISM, (1, 0, 0, 0))], ids=["cylinders", "prisms"]
)
def test_what_stands_on_eight_points_bears_what_is_1e4_to_1e6_times_heavier_within_a_stack(shape, turn, heavy):
    """Of 48 to 80 contacts, more than factors solve with such masses: it once moved by centimetres."""
    for ratio in (1e4, 1e6):
        scene = ns.Scene(gravity=(0, 0, -G), material=ns.Material(mu=0.5))
        scene.fixed(ns.HalfSpace((0, 0, 1)), name="ground")
        n = 10 if len(heavy) > 1 else 4 + heavy[0]
        for k in range(n):
            density = 1000 * (ratio if k in heavy else 1)
            scene.body(shape, density=density, position=(0, 0, 0.1 + 0.2 * k), turn=turn)
        awake = ns.MoreauJean(DT, contacts=ns.ContactSolver(may_sleep=False))
        sol = ns.simulate(scene, (0, 0.1), integrator=awake, every=50)
        assert sol.stats.missed == 0 and np.abs(sol.position - sol.position[0]).max() < 1e-7


def test_the_order_of_bodies_changes_a_rolling_heap_by_rounding_only():
    """Solved to rounding, since it has no more than 32 bodies; what roundings grow by in 0.1 s is less than 1e4."""
    rng = np.random.default_rng(0)
    places = [(0.21 * (k % 4) + rng.uniform(-0.004, 0.004), 0.11 + 0.21 * (k // 4)) for k in range(12)]
    runs = []
    for order in (range(12), rng.permutation(12)):
        scene = ns.Scene(gravity=(0, -G), material=ns.Material(mu=0.4))
        scene.fixed(ns.HalfPlane((0, 1)))
        for k in order:
            scene.body(ns.Disc(0.1), density=1000, position=places[k], velocity=(0.3 * (k % 3), 0), name=f"disc {k}")
        sol = ns.simulate(scene, (0, 0.1), integrator=ns.MoreauJean(DT))
        runs.append(np.array([sol[f"disc {k}"].position for k in range(12)]))
    assert np.abs(runs[0] - runs[1]).max() < 1e-12 and np.ptp(runs[0], axis=1).max() > 0.01


def thrown_at_one_another(names, order, seed):
    """Velocities and spins of two bodies after 0.15 s, in which they met at 16 m/s; how many points they touched in."""
    rng = np.random.default_rng(seed)
    turns, spins, places = rng.normal(size=(2, 4)), rng.uniform(-4, 4, (2, 3)), rng.uniform(-0.05, 0.05, (2, 3))
    turns, places[:, 0] = turns / np.linalg.norm(turns, axis=1)[:, None], [-0.9, 0.9]
    scene = ns.Scene(gravity=(0, 0, 0), material=ns.Material(mu=0.4, e=0.5))
    for k in order:
        state = {"turn": turns[k], "velocity": (8 - 16 * k, *places[k, :2]), "spin": spins[k]}
        scene.body(shape_of(names[k]), density=1000, position=places[k], **state, name=f"{k}")
    sol = ns.simulate(scene, (0, 0.15), integrator=ns.MoreauJean(1e-3))
    return np.array([[sol[f"{k}"].velocity[-1], sol[f"{k}"].spin[-1]] for k in (0, 1)]), sol.stats.most_contacts


KINDS = ("gem", "box", "capsule", "ellipsoid", "needle", "sphere")


@pytest.mark.parametrize("names", list(itertools.combinations_with_replacement(KINDS, 2)), ids="-".join)
def test_which_of_two_thrown_bodies_is_named_first_changes_their_velocities_by_rounding_only(names):
    """It once did by 1e-3 m/s and rad/s, since the normal of round cores is known to a root of a rounding."""
    for seed in range(3):
        one, points = thrown_at_one_another(names, (0, 1), seed)
        assert points > 0
        assert np.abs(one - thrown_at_one_another(names, (1, 0), seed)[0]).max() < 1e-12


@pytest.mark.stress
@pytest.mark.parametrize("dim", [2, 3])
def test_a_pile_at_rest_does_not_drift_in_a_million_steps(dim):
    """Each of them taken. Measured: none at all in the plane, 1e-59 m in space, by which the ball rolls."""
    up = np.eye(dim)[-1]
    scene = ns.Scene(gravity=-G * up, material=ns.Material(mu=0.5))
    scene.fixed((ns.HalfPlane if dim == 2 else ns.HalfSpace)(up))
    for k in range(4):
        scene.body(ns.Box(*(0.2,) * dim), density=1000, position=(0.1 + 0.2 * k) * up + 0.02 * k * np.eye(dim)[0])
    ball = ns.Disc(0.1) if dim == 2 else ns.Sphere(0.1)
    scene.body(ball, density=1000, position=0.1 * up - 0.2 * np.eye(dim)[0])
    awake = ns.MoreauJean(DT, contacts=ns.ContactSolver(may_sleep=False))
    sol = ns.simulate(scene, (0, DT * 1_000_000), integrator=awake, every=100_000)
    assert sol.stats.steps == 1_000_000 and np.abs(sol.position - sol.position[0]).max() < 1e-15
    assert sol.penetration.max() < 1e-15


def test_a_step_whose_rebound_goes_to_other_solvers_is_whole_when_it_is_recorded():
    # it was counted before it rebounded, and its record had the velocities before that
    run = SceneRun(SphereBox(n=64, e=0.5).scene(), (0, 1), ns.MoreauJean(dt=2e-3), 1, None)
    assembly = run.assembly
    for _ in range(300):
        before = assembly.bodies.motion.v.copy()
        assembly.take_steps(2e-3, 1)
        np.testing.assert_array_equal(assembly.bodies.v_0[:, :3], before[:, :3])
        assert assembly.progress.stage == PREDICT
    assert assembly.progress.counts.inside > 10 and assembly.progress.counts.impacts > 50


@pytest.mark.upkeep
@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize(("n", "heavy", "light"), [(6, 1e4, 1e-4), (6, 1e1, 1e-7), (8, 1e4, 1e-3), (40, 1e3, 1e-3)])
@pytest.mark.parametrize("lowest", ["heavy", "light"])
def test_a_stack_of_masses_that_alternate_stands(lowest, n, heavy, light, dim):
    """Impulses are known to roundings of the weights that they hold, up to 40 tons, and so is what light bodies between
    are given: some 1e-8 m/s, as many times as there are bodies. A residual of 1e-8 would let them go centimetres."""
    scene, flat = ns.Scene(gravity=(0,) * (dim - 1) + (-G,), material=ns.Material(mu=0.5)), (0,) * (dim - 2)
    scene.fixed(ns.HalfPlane((0, 1)) if dim == 2 else ns.HalfSpace((0, 0, 1)))
    for k in range(n):
        mass = heavy if (k % 2 == 0) == (lowest == "heavy") else light
        scene.body(ns.Box(*(0.2,) * dim), mass=mass, position=(0.01 * (k % 2), *flat, 0.1 + 0.2 * k))
    sol = ns.simulate(scene, (0, 0.5), integrator=ns.MoreauJean(dt=DT))
    assert sol.stats.missed == 0
    assert np.abs(sol.position[-1] - sol.position[0]).max() < 5e-5
