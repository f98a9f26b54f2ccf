"""Gaps, normals and points of cylinders, polyhedra and ellipsoids against proofs, brute force and closed forms."""

import itertools
import math

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

import nonsmooth as ns
from nonsmooth.numerics.rounding import EPS
from nonsmooth.scenes.parts import parts_of
from nonsmooth.scenes.places import ORIGIN

EVERYTHING = 1e6  # margin: every pair is found
GEM = np.random.default_rng(8).normal(size=(14, 3))
NAMES = ("cylinder", "coin", "cube", "gem", "wedge", "ellipsoid", "needle", "sphere", "capsule", "box")
SOLIDS = NAMES[:7]
PAIRS = [pair for pair in itertools.combinations_with_replacement(NAMES, 2) if set(pair) & set(SOLIDS)]


def shape_of(name, scale=1.0):
    """Shapes of different kinds, sizes and roundness."""
    a = scale
    corners = np.array(list(itertools.product((-0.4, 0.4), repeat=3)))
    return {
        "cylinder": lambda: ns.Cylinder(0.3 * a, 0.8 * a),
        "coin": lambda: ns.Cylinder(0.5 * a, 0.05 * a),
        "cube": lambda: ns.Polyhedron(a * corners),
        "gem": lambda: ns.Polyhedron(0.5 * a * GEM / np.linalg.norm(GEM, axis=1)[:, None]),
        "wedge": lambda: ns.Polyhedron(a * np.array([(0, 0, 0), (0.9, 0, 0), (0, 0.4, 0), (0.9, 0.4, 0), (0, 0, 0.1)])),
        "ellipsoid": lambda: ns.Ellipsoid(0.6 * a, 0.4 * a, 0.3 * a),
        "needle": lambda: ns.Ellipsoid(0.8 * a, 0.1 * a, 0.05 * a),
        "sphere": lambda: ns.Sphere(0.4 * a),
        "capsule": lambda: ns.Capsule(0.8 * a, 0.15 * a),
        "box": lambda: ns.Box(1.0 * a, 0.5 * a, 0.2 * a),
    }[name]()


def row_of(shape, body):
    (part,) = parts_of(shape, 3)
    return part.row(body, ORIGIN[3])


def pair_of(spatial, one, two, x=None):
    return spatial([row_of(one, 0), row_of(two, 1)], np.zeros((2, 7)) if x is None else x)


def core_radius(shape):
    return shape.radius if isinstance(shape, ns.Sphere | ns.Capsule) else 0.0


def support(shape, n):
    """max of n . p over the core, in the axes of the shape, n (k, 3)."""
    if isinstance(shape, ns.Sphere):
        return np.zeros(len(n))
    if isinstance(shape, ns.Capsule):
        return 0.5 * shape.length * np.abs(n[:, 0])
    if isinstance(shape, ns.Cylinder):
        return 0.5 * shape.length * np.abs(n[:, 0]) + shape.radius * np.hypot(n[:, 1], n[:, 2])
    if isinstance(shape, ns.Ellipsoid):
        return np.linalg.norm(n * [shape.a, shape.b, shape.c], axis=1)
    if isinstance(shape, ns.Box):
        return np.abs(n) @ (0.5 * np.array(shape.lengths))
    return (n @ shape.vertices.T).max(axis=1)


def outside(shape, p):
    """How far points (k, 3), in the axes of the shape, are outside of its core: a bound of the distance, 0 within."""
    if isinstance(shape, ns.Sphere):
        return np.linalg.norm(p, axis=1)
    if isinstance(shape, ns.Capsule):
        return np.linalg.norm(p - np.clip(p, [-0.5 * shape.length, 0, 0], [0.5 * shape.length, 0, 0]), axis=1)
    if isinstance(shape, ns.Cylinder):
        return np.maximum(np.abs(p[:, 0]) - 0.5 * shape.length, np.hypot(p[:, 1], p[:, 2]) - shape.radius)
    if isinstance(shape, ns.Ellipsoid):
        axes = np.array([shape.a, shape.b, shape.c])
        return (np.linalg.norm(p / axes, axis=1) - 1.0) * axes.min()
    if isinstance(shape, ns.Box):
        return (np.abs(p) - 0.5 * np.array(shape.lengths)).max(axis=1)
    planes = ConvexHull(shape.vertices).equations
    return (p @ planes[:, :3].T + planes[:, 3]).max(axis=1)


def random_places(rng, n, spread):
    x = np.zeros((n, 2, 7))
    x[:, :, :3] = rng.uniform(-0.5, 0.5, (n, 2, 3)) * spread
    q = rng.normal(size=(n, 2, 4))
    q[: n // 8] = [1, 0, 0, 0]  # axes that are parallel, and
    q[n // 8 : n // 4, :, 1:3] = 0  # those that have one in common
    x[:, :, 3:] = q / np.linalg.norm(q, axis=-1, keepdims=True)
    return x


def nearest_contacts(scene, x):
    """(gap, normal, point, key) of the contact of least gap at each of the places."""
    found = []
    for places in x:
        scene.motion.x[:] = places
        gap, normal, point, key = scene.contacts(margin=EVERYTHING)
        assert len(gap) == len(set(key.tolist())) > 0 and (np.diff(key) > 0).all()
        best = int(np.argmin(gap))
        found.append((gap[best], normal[best], point[best], key[best]))
    return [np.array(column) for column in zip(*found, strict=True)]


def in_axes(x, v):
    return np.einsum("nba,nb->na", Rotation.from_quat(x[:, [4, 5, 6, 3]]).as_matrix(), v)


def prove(spatial, names, n, seed, scale=1.0, spread=1.8, near=1e-6):
    """Along the normal the cores are apart by the gap (their supports): it is no more than the distance. The point has
    a point of either core at half the gap along the normal: it is no less. Returns the places, gaps and normals."""
    one, two = (shape_of(name, scale) for name in names)
    x = random_places(np.random.default_rng(seed), n, spread)
    x[:, :, :3] *= scale
    gap, normal, point, _ = nearest_contacts(pair_of(spatial, one, two), x)
    core = gap + core_radius(one) + core_radius(two)
    n_i, n_j = in_axes(x[:, 0], normal), in_axes(x[:, 1], -normal)
    proved = ((x[:, 1, :3] - x[:, 0, :3]) * normal).sum(axis=1) - support(one, n_i) - support(two, n_j)
    assert np.abs(np.linalg.norm(normal, axis=1) - 1).max() < 8 * EPS
    assert np.abs(proved - core).max() < 1e-8 * scale and np.median(np.abs(proved - core)) < 1e-13 * scale
    on_i = in_axes(x[:, 0], point - (0.5 * gap + core_radius(one))[:, None] * normal - x[:, 0, :3])
    on_j = in_axes(x[:, 1], point + (0.5 * gap + core_radius(two))[:, None] * normal - x[:, 1, :3])
    near *= scale  # two round cores: their points are known to the root of a rounding
    assert np.abs(outside(one, on_i)).max() < near, np.abs(outside(one, on_i)).argmax()
    assert np.abs(outside(two, on_j)).max() < near, np.abs(outside(two, on_j)).argmax()
    return one, two, x, core, normal


@pytest.mark.parametrize("names", PAIRS, ids="-".join)
def test_gap_normal_and_point_prove_each_other(names, spatial):
    prove(spatial, names, 30, PAIRS.index(names))


@pytest.mark.slow
@pytest.mark.parametrize("names", PAIRS, ids="-".join)
def test_gap_normal_and_point_prove_each_other_on_many_pairs(names, spatial):
    """10^5 in all, some of them at small and large scale."""
    for k, scale in enumerate((1.0, 1e-3, 1e3)):
        prove(spatial, names, 1200 if k == 0 else 300, 100 + PAIRS.index(names) + k, scale)


def corners_of(shape):
    if isinstance(shape, ns.Box):
        return np.array(list(itertools.product((-0.5, 0.5), repeat=3))) * shape.lengths
    return shape.vertices


def on_ground(spatial, solid, shape, x, is_first):
    """A shape at x above the ground z <= 0; contacts with everything."""
    rows = [row_of(shape, 0), solid.half_space(1)] if is_first else [solid.half_space(0), row_of(shape, 1)]
    places = np.array([x, (3, 4, 0, 1, 0, 0, 0)] if is_first else [(3, 4, 0, 1, 0, 0, 0), x], dtype=float)
    return spatial(rows, places).contacts(margin=EVERYTHING)


@pytest.mark.parametrize("is_first", [True, False])
@pytest.mark.parametrize("name", SOLIDS)
def test_on_the_ground_the_lowest_point_is_where_the_closed_form_has_it(name, is_first, spatial, solid):
    shape, rng = shape_of(name), np.random.default_rng(1)
    for x in random_places(rng, 40, 1.0)[:, 0]:
        gap, normal, point, key = on_ground(spatial, solid, shape, x, is_first)
        down = in_axes(x[None], np.array([[0.0, 0, -1]]))
        assert abs(gap.min() - (x[2] - support(shape, down)[0])) < 16 * EPS
        assert (normal == [0, 0, -1 if is_first else 1]).all() and (np.diff(key) > 0).all()
        on_shape = point + 0.5 * gap[:, None] * [0, 0, 1]
        held = in_axes(np.tile(x, (len(gap), 1)), on_shape - x[:3])
        assert np.abs(outside(shape, held)).max() < 32 * EPS
        np.testing.assert_allclose(on_shape[:, 2], gap, atol=16 * EPS)


def test_a_cylinder_stands_on_its_rim_and_lies_on_a_line(spatial, solid):
    s = math.sqrt(0.5)
    gap, _, point, key = on_ground(spatial, solid, ns.Cylinder(0.3, 0.8), (0, 0, 0.4, s, 0, s, 0), True)
    assert len(gap) == 9 == len(set(key)) and np.sort(np.abs(gap))[7] < 4 * EPS < np.abs(gap).max()
    assert np.abs(np.hypot(*point[np.abs(gap) < 1e-12, :2].T) - 0.3).max() < 4 * EPS
    gap, _, point, _ = on_ground(spatial, solid, ns.Cylinder(0.3, 0.8), (0, 0, 0.3, 1, 0, 0, 0), True)
    lying = np.abs(gap) < 1e-12
    assert sorted(point[lying, 0].round(12).tolist()) == [-0.4, 0.4] and np.abs(point[lying, 1]).max() < 4 * EPS


def test_a_lying_cylinder_touches_a_box_and_its_like_along_a_line(spatial):
    cylinder = ns.Cylinder(0.5, 1.0)
    for below in (ns.Box(4, 4, 1), ns.Polyhedron(corners_of(ns.Box(4, 4, 1))), cylinder):
        gap, normal, point, _ = pair_of(spatial, cylinder, below, [(0, 0, 1), (0.2, 0, 0)]).contacts(margin=0.01)
        ends = [-0.3, 0.5] if below is cylinder else [-0.5, 0.5]
        assert len(gap) == 2 and np.abs(gap).max() < 8 * EPS and np.abs(normal - [0, 0, -1]).max() < 8 * EPS
        np.testing.assert_allclose(sorted(point[:, 0]), ends, atol=8 * EPS)


@pytest.mark.parametrize("height", [1.0, 0.999, 1.001])
def test_a_cube_of_points_touches_as_a_box_does(height, spatial):
    box, cube, x = ns.Box(1, 1, 1), ns.Polyhedron(corners_of(ns.Box(1, 1, 1))), [(0, 0, 0), (0.2, 0.1, height)]
    wanted = pair_of(spatial, box, box, x).contacts(margin=0.1)
    for one, two in ((cube, box), (box, cube), (cube, cube)):
        found = pair_of(spatial, one, two, x).contacts(margin=0.1)
        assert np.abs(found[0] - wanted[0][0]).max() < 8 * EPS and (found[1] == [0, 0, 1]).all()
        order, like = (np.lexsort(p[:, :2].round(9).T) for p in (found[2], wanted[2]))
        np.testing.assert_allclose(found[2][order], wanted[2][like], atol=8 * EPS)


@pytest.mark.parametrize("names", [("cylinder", "gem"), ("cylinder", "coin"), ("ellipsoid", "box"), ("gem", "wedge")],
                         ids="-".join)  # fmt: skip
def test_swapped_and_mirrored_pairs_touch_alike(names, spatial):
    """Mirrored in y: of shapes with that symmetry the places alone are, of others the points too."""
    one, two = (shape_of(name) for name in names)
    x = random_places(np.random.default_rng(2), 40, 1.6)
    gap, normal, point, _ = nearest_contacts(pair_of(spatial, one, two), x)
    back, turned, at, _ = nearest_contacts(pair_of(spatial, two, one), x[:, ::-1])
    shallow = gap > -0.05
    np.testing.assert_allclose(back[shallow], gap[shallow], atol=1e-9)
    np.testing.assert_allclose(turned[shallow], -normal[shallow], atol=2e-5)
    mirror = np.array([1.0, -1.0, 1.0])
    other = [
        ns.Polyhedron(shape.vertices * mirror) if isinstance(shape, ns.Polyhedron) else shape for shape in (one, two)
    ]
    y = x * np.array([1, -1, 1, 1, -1, 1, -1.0])
    seen, normals, *_ = nearest_contacts(pair_of(spatial, *other), y)
    np.testing.assert_allclose(seen[shallow], gap[shallow], atol=1e-9)
    np.testing.assert_allclose(normals[shallow], normal[shallow] * mirror, atol=2e-5)


@pytest.mark.parametrize("scale", [1e-3, 1e3])
@pytest.mark.parametrize("names", [("cylinder", "gem"), ("coin", "coin"), ("ellipsoid", "wedge")], ids="-".join)
def test_shapes_of_all_scales_prove_their_gaps(names, scale, spatial):
    prove(spatial, names, 30, 7, scale)


def test_the_interpreter_finds_the_bits_of_compiled_code_for_all_solids(spatial):
    shapes = [shape_of(name) for name in NAMES]
    rng = np.random.default_rng(4)
    x = random_places(rng, len(NAMES), 1.2)[:, 0]
    scenes = [spatial([row_of(shape, b) for b, shape in enumerate(shapes)], x, room=400, pairs=400) for _ in range(2)]
    n = scenes[0].run(margin=0.2)
    assert n == scenes[1].run(margin=0.2, is_compiled=False) and n > 40
    assert scenes[0].found.words.tobytes() == scenes[1].found.words.tobytes()
