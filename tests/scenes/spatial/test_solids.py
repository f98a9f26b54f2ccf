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
from nonsmooth.scenes.spatial.solids import solid_contact

EVERYTHING = 1e6  # margin: every pair is found
GEM = np.random.default_rng(8).normal(size=(14, 3))
NAMES = ("cylinder", "coin", "cube", "gem", "wedge", "ellipsoid", "needle", "sphere", "capsule", "box")
SOLIDS = NAMES[:7]
PAIRS = [pair for pair in itertools.combinations_with_replacement(NAMES, 2) if set(pair) & set(SOLIDS)]


@pytest.fixture(scope="module", autouse=True)
def loaded():
    solid_contact.load()


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


def prove(spatial, names, n, seed, scale=1.0, spread=1.8):
    """Along the normal the cores are apart by the gap (their supports): it is no more than the distance. The point has a
    point of either core at half the gap along the normal: it is no less. Returns the places, gaps and depths."""
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
    near = 1e-6 * scale  # two round cores: their points are known to the root of a rounding
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
