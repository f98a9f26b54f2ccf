"""Starts that overlap, moved apart by ``project=True``: closed forms of the nearest places, no gap left, bits kept."""

import itertools

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.runs.scene_run import SceneRun

STEP = ns.MoreauJean(dt=1e-3)
EXACT = 1e-12  # of the size: what docs/scenes.md says is left
# the displacement is settled to 1e-9 of itself, and each problem is solved to 1e-10
NEAREST = 1e-8


def started(scene):
    return SceneRun(scene, (0, 0.1), STEP, 1, None, project=True)


def places(run):
    return run.world.bodies.motion.x[:, : run.scene.dim]


def least_gap(run):
    n = run.assembly.find_contacts()
    return run.assembly.found.gap[:n].min(initial=0.0)


def on_ground(dim):
    up = (0, 1) if dim == 2 else (0, 0, 1)
    scene = ns.Scene(gravity=tuple(-9.81 * np.array(up)), material=ns.Material(mu=0.5))
    scene.fixed((ns.HalfPlane if dim == 2 else ns.HalfSpace)(up), name="ground")
    return scene


def test_two_overlapping_bodies_share_the_way_by_their_inverse_masses():
    scene = ns.Scene(gravity=(0, -9.81))
    scene.body(ns.Disc(0.1), mass=1.0, position=(0, 0))
    scene.body(ns.Disc(0.1), mass=3.0, position=(0.09, 0.12))  # 0.15 apart: 0.05 in one another along (0.6, 0.8)
    moved = places(started(scene)) - [(0, 0), (0.09, 0.12)]
    np.testing.assert_allclose(
        moved, 0.05 * np.array([(-0.75 * 0.6, -0.75 * 0.8), (0.25 * 0.6, 0.25 * 0.8)]), atol=1e-15
    )


def test_two_overlapping_boxes_on_the_ground_part_upwards_and_only_the_upper_one_moves():
    scene = on_ground(2)
    scene.body(ns.Box(0.2, 0.2), mass=1.0, position=(0, 0.1))
    scene.body(ns.Box(0.2, 0.2), mass=1.0, position=(0.02, 0.28))
    run = started(scene)
    np.testing.assert_allclose(places(run), [(0, 0), (0, 0.1), (0.02, 0.3)], atol=1e-12)
    assert least_gap(run) >= -EXACT * 0.1


@pytest.mark.parametrize("dim", [2, 3])
def test_a_stack_that_was_laid_too_tightly_stands_box_on_box(dim):
    scene = on_ground(dim)
    for k in range(6):
        scene.body(ns.Box(*[0.2] * dim), mass=1.0, position=(0.01 * k, *[0.0] * (dim - 2), 0.095 + 0.19 * k))
    run = started(scene)
    np.testing.assert_allclose(places(run)[1:, -1], 0.1 + 0.2 * np.arange(6), atol=6 * NEAREST * 0.05)
    np.testing.assert_allclose(places(run)[1:, 0], 0.01 * np.arange(6), atol=6 * NEAREST * 0.05)
    assert least_gap(run) >= -EXACT * 0.1


@pytest.mark.parametrize(("dim", "shape"), [(2, ns.Disc), (2, ns.Box), (3, ns.Sphere)])
def test_a_heap_thrown_into_one_another_is_left_without_a_gap_below_rounding(dim, shape):
    rng, scene = np.random.default_rng(3), on_ground(dim)
    for _ in range(40):
        size = rng.uniform(0.05, 0.15, size=2 if shape is ns.Box else 1)
        turn = {"turn": rng.uniform(0, 6)} if shape is ns.Box else {}
        scene.body(
            shape(*size), density=1000, position=(*rng.uniform(-0.3, 0.3, dim - 1), rng.uniform(0.1, 0.8)), **turn
        )
    run = started(scene)
    assert least_gap(run) >= -EXACT * 0.025
    np.testing.assert_array_equal(places(run)[0], 0.0)


def test_a_row_of_discs_moves_to_the_nearest_places_that_quadratic_programming_finds():
    from scipy.optimize import minimize

    rng = np.random.default_rng(5)
    mass, x_0, r = rng.uniform(1, 5, 7), np.sort(rng.uniform(0, 0.5, 7)), 0.1
    scene = ns.Scene(gravity=(0, -9.81))
    for m, x in zip(mass, x_0, strict=True):
        scene.body(ns.Disc(r), mass=m, position=(x, 0))
    apart = {"type": "ineq", "fun": lambda x: np.diff(x) - 2 * r, "jac": lambda x: np.diff(np.eye(7), axis=0)}
    solved = minimize(
        lambda x: 0.5 * mass @ (x - x_0) ** 2, x_0, jac=lambda x: mass * (x - x_0), constraints=apart,
        method="SLSQP", options={"ftol": 1e-15},
    )  # fmt: skip
    np.testing.assert_allclose(places(started(scene))[:, 0], solved.x, atol=1e-7)  # what SLSQP leaves


def test_the_way_of_a_heap_is_made_of_pushes_along_the_normals_of_what_touches_in_the_end():
    """M (x - x_0) = J_N^T lambda, lambda >= 0 of closed gaps alone: no way near by is shorter (Karush-Kuhn-Tucker)."""
    from scipy.optimize import nnls

    rng, scene = np.random.default_rng(11), on_ground(2)
    r, x_0 = rng.uniform(0.05, 0.15, 25), np.stack([rng.uniform(-0.3, 0.3, 25), rng.uniform(0.1, 0.6, 25)], axis=1)
    for radius, place in zip(r, x_0, strict=True):
        scene.body(ns.Disc(radius), density=1000, position=place)
    run = started(scene)
    x = places(run)[1:]
    pushes = np.zeros((0, 25, 2))
    for k in np.flatnonzero(x[:, 1] - r < 1e-11):
        pushes = np.concatenate((pushes, np.eye(25)[k][None, :, None] * [0.0, 1.0]))
    for a in range(25):
        for b in range(a):
            way = x[a] - x[b]
            if np.linalg.norm(way) - r[a] - r[b] < 1e-11:
                pushes = np.concatenate((pushes, (np.eye(25)[a] - np.eye(25)[b])[None, :, None] * way))
    wanted = (1000 * np.pi * r**2)[:, None] * (x - x_0)
    _, left = nnls(pushes.reshape(len(pushes), -1).T, wanted.ravel())
    assert left <= 1e-6 * np.linalg.norm(wanted)  # normals of places that are settled to 1e-9 of a radius of curvature


def test_a_start_without_overlap_keeps_every_bit():
    scene = on_ground(3)
    scene.body(ns.Box(0.2, 0.2, 0.1), density=1000, position=(0, 0, 0.05), name="low")
    scene.body(ns.Box(0.2, 0.2, 0.1), density=1000, position=(0.05, 0, 0.15), turn=(np.cos(0.3), 0, 0, np.sin(0.3)))
    plain, moved = (ns.simulate(scene, (0, 0.02), integrator=STEP, project=project) for project in (False, True))
    np.testing.assert_array_equal(plain.q, moved.q)
    np.testing.assert_array_equal(plain.u, moved.u)


def test_bodies_that_touch_no_overlap_keep_their_bits_where_others_are_moved():
    scene = on_ground(2)
    scene.body(ns.Box(0.2, 0.1), density=1000, position=(3, 0.05), turn=0.0, name="aside")
    scene.body(ns.Disc(0.1), density=1000, position=(0, 0.07), name="sunk")
    x = places(started(scene))
    np.testing.assert_array_equal(x[1], (3, 0.05))
    assert x[2, 1] == pytest.approx(0.1, abs=1e-13)


def test_the_run_from_places_moved_apart_is_that_of_a_scene_laid_there():
    def scene(low, high, turns=(0.0, 0.0)):
        scene = on_ground(2)
        scene.body(ns.Disc(0.1), density=1000, position=low, turn=turns[0])
        scene.body(ns.Disc(0.1), density=1000, position=high, turn=turns[1])
        return scene

    moved = ns.simulate(scene((0, 0.09), (0.15, 0.12)), (0, 0.1), integrator=STEP, project=True)
    laid = ns.simulate(scene(*moved.position[0, 1:], moved.turn[0, 1:]), (0, 0.1), integrator=STEP)
    np.testing.assert_array_equal(moved.q, laid.q)


def test_what_fixed_bodies_press_from_both_sides_is_refused_by_name():
    scene = on_ground(2)
    scene.fixed(ns.HalfPlane((0, -1), -0.3), name="lid")
    scene.body(ns.Disc(0.2), mass=1.0, position=(0, 0.14), name="ball")
    with pytest.raises(
        ns.InvalidInput, match="ground and ball overlap at the start by 0.06 m, and project=True finds no"
    ):
        started(scene)


def test_bodies_that_are_told_how_to_move_push_and_are_not_pushed():
    scene = ns.Scene(gravity=(0, -9.81))
    scene.kinematic(ns.Box(1.0, 0.1), velocity=(1.0, 0), position=(0, 0), name="tray")
    scene.body(ns.Box(0.1, 0.1), mass=2.0, position=(0.1, 0.08), name="cup")
    x = places(started(scene))
    np.testing.assert_allclose(x, [(0, 0), (0.1, 0.1)], atol=1e-13)
    assert (x[0] == 0.0).all()


CORNERS = 0.04 * np.array([*np.eye(3), *-np.eye(3)])
THIN = ns.Polygon([(-0.05, -0.03), (0.05, -0.03), (0.0, 0.06)])
# a shape, and the radius of a ball about its origin that it holds
HOLD = {
    2: [(ns.Disc(0.05), 0.05), (ns.Box(0.1, 0.06), 0.03), (ns.Capsule(0.06, 0.03), 0.03), (THIN, 0.026),
        (ns.Compound((ns.Disc(0.03), (0, 0)), (ns.Box(0.1, 0.02), (0, 0))), 0.03)],
    3: [(ns.Sphere(0.05), 0.05), (ns.Box(0.1, 0.08, 0.06), 0.03), (ns.Capsule(0.06, 0.03), 0.03),
        (ns.Cylinder(0.05, 0.08), 0.04), (ns.Ellipsoid(0.05, 0.04, 0.03), 0.03), (ns.Polyhedron(CORNERS), 0.023),
        (ns.Compound((ns.Cylinder(0.03, 0.06), (0, 0, 0)), (ns.Polyhedron(CORNERS), (0, 0, 0))), 0.03)],
}  # fmt: skip


def any_turn(rng, dim):
    turn = rng.normal(size=4)
    return turn / np.linalg.norm(turn) if dim == 3 else turn[0]


@pytest.mark.parametrize(
    "dim, first, second",
    [(dim, *pair) for dim in (2, 3) for pair in itertools.combinations_with_replacement(range(len(HOLD[dim])), 2)],
)
def test_every_pair_of_shapes_that_overlaps_is_refused_by_name_and_moved_apart_when_asked(dim, first, second):
    """Balls that both hold overlap, and so do they, however they are turned. Overlaps of cylinders, ellipsoids and
    polyhedra with one another and with boxes were once taken in silence."""
    (a, r_a), (b, r_b), rng = HOLD[dim][first], HOLD[dim][second], np.random.default_rng((dim, first, second))
    for share in (0.1, 0.6, 0.95):
        way = rng.normal(size=dim)
        scene = ns.Scene(gravity=-9.81 * np.eye(dim)[-1])
        scene.body(a, mass=1.0, turn=any_turn(rng, dim), name="a")
        place = share * (r_a + r_b) / np.linalg.norm(way) * way
        scene.body(b, mass=2.0, position=place, turn=any_turn(rng, dim), name="b")
        with pytest.raises(ns.InvalidInput, match="^a and b overlap at the start by"):
            SceneRun(scene, (0, 0.1), STEP, 1, None)
        assert least_gap(started(scene)) >= -EXACT * 0.1
