"""All pairs of spatial shapes against brute force: all faces and pairs of edges, many directions, small motions."""

import itertools

import numpy as np
import pytest
from scipy.optimize import nnls
from scipy.spatial.transform import Rotation

import nonsmooth as ns
from tests.scenes.spatial.test_solids import (
    EVERYTHING,
    NAMES,
    PAIRS,
    core_radius,
    corners_of,
    in_axes,
    nearest_contacts,
    pair_of,
    prove,
    random_places,
    shape_of,
    support,
)

ALL_PAIRS = list(itertools.combinations_with_replacement(NAMES, 2))
FLAT = ("cube", "gem", "wedge", "box")
QUARTERS = Rotation.create_group("O")
# Derived: what lies between the rim, r = 0.5 m, and the chord of two of its eight points, is not held on half a chord
CHORD = np.sin(np.pi / 8) * 0.5
SAME_NORMAL = 0.1  # rad: else it is another face that touches now, where a corner met the border of two
# What is documented of 100,000 pairs of a kind: a point in the size of the shapes, and a depth of one pair of 79,000
NEAR, DEEPER = 3e-5, 5e-6
SMALL = 1e-4  # m and rad of a small motion; of its square is the error of rows that are those of the place before


def edges_of(shape):
    """Corners, outward normals of faces and directions of edges of a box or a polyhedron."""
    hull = ns.Polyhedron(corners_of(shape)) if isinstance(shape, ns.Box) else shape
    corners = hull.vertices
    loops = [corners[list(face)] for face in hull.faces]
    normals = np.array([np.cross(loop[1] - loop[0], loop[2] - loop[0]) for loop in loops])
    pairs = {frozenset(edge) for face in hull.faces for edge in zip(face, (*face[1:], face[0]), strict=True)}
    edges = np.array([corners[b] - corners[a] for a, b in map(sorted, pairs)])
    return corners, normals, edges


def largest_separation(one, two, x):
    """s of all faces of the differences of two polyhedra: their own faces, and the products of two of their edges."""
    sides = []
    for shape, place in zip((one, two), x, strict=True):
        turn = Rotation.from_quat(place[[4, 5, 6, 3]])
        corners, normals, edges = (turn.apply(part) for part in edges_of(shape))
        sides.append((corners + place[:3], normals, edges))
    (A, n_A, e_A), (B, n_B, e_B) = sides
    across = np.cross(e_A[:, None], e_B[None]).reshape(-1, 3)
    n = np.concatenate([n_A, -n_B, across, -across])
    length = np.linalg.norm(n, axis=1)
    n = n[length > 1e-7 * length.max()] / length[length > 1e-7 * length.max()][:, None]
    return ((B @ n.T).min(axis=0) - (A @ n.T).max(axis=0)).max()


@pytest.mark.upkeep
@pytest.mark.parametrize("names", list(itertools.combinations_with_replacement(FLAT, 2)), ids="-".join)
def test_the_gap_of_polyhedra_that_overlap_is_that_of_the_nearest_face_of_their_differences(names, spatial):
    one, two = (shape_of(name) for name in names)
    x = random_places(np.random.default_rng(3), 150, 1.0)
    gap, *_ = nearest_contacts(pair_of(spatial, one, two), x)
    wanted = np.array([largest_separation(one, two, places) for places in x])
    deep = wanted < 0
    assert deep.sum() > 10
    preferred = 2e-6 if names == ("box", "box") else 1e-11  # a face of two boxes, where edges do no better
    assert (gap - wanted)[deep].max() < 1e-11 and (wanted - gap)[deep].max() < preferred
    assert (gap >= wanted - preferred).all()  # the distance is no less than what separates


def directions(n):
    """n unit vectors, evenly spread (Fibonacci)."""
    k = np.arange(n) + 0.5
    z, turn = 1 - 2 * k / n, np.pi * (1 + np.sqrt(5)) * k
    rho = np.sqrt(1 - z * z)
    return np.stack([rho * np.cos(turn), rho * np.sin(turn), z], axis=1)


def separations(one, two, x, n):
    """s of directions n (m, 3) at places x (k, 2, 7): (k, m)."""
    k, m = len(x), len(n)
    where = np.repeat(x, m, axis=0)
    n = np.tile(n, (k, 1))
    s = ((where[:, 1, :3] - where[:, 0, :3]) * n).sum(axis=1)
    return (s - support(one, in_axes(where[:, 0], n)) - support(two, in_axes(where[:, 1], -n))).reshape(k, m)


def no_direction_is_better(spatial, names, n, seed, many, rounding=1e-11):
    """Of pairs that overlap: along none of so many directions do the cores part sooner than by the gap found."""
    one, two = (shape_of(name) for name in names)
    x = random_places(np.random.default_rng(seed), n, 0.8)
    gap, *_ = nearest_contacts(pair_of(spatial, one, two), x)
    core, tried = gap + core_radius(one) + core_radius(two), directions(many)
    deep = np.flatnonzero(core < 0)
    for some in np.array_split(deep, len(deep) // 200 + 1):
        best = separations(one, two, x[some], tried).max(axis=1, initial=-np.inf)
        assert (best <= core[some] + (2e-6 if names == ("box", "box") else rounding)).all()
    return len(deep)


@pytest.mark.parametrize("names", ALL_PAIRS, ids="-".join)
def test_no_direction_parts_overlapping_cores_sooner(names, spatial):
    deep = no_direction_is_better(spatial, names, 60, ALL_PAIRS.index(names), 2000)
    assert deep > 5 or {"sphere", "capsule"} & set(names)  # points and lines in thin ones


def aligned_places(rng, n):
    """Places of pairs of which each fourth has all axes along the other's, and another one axis."""
    x = random_places(rng, n, 1.0)
    for k in range(0, n, 2):
        turn = Rotation.from_rotvec(rng.uniform(0, 6) * (k % 4 // 2) * np.eye(3)[rng.integers(3)])
        for b in (0, 1):
            x[k, b, 3:] = (turn * QUARTERS[rng.integers(24)]).as_quat()[[3, 0, 1, 2]]
            turn = Rotation.identity() if k % 8 < 4 else turn
    return x


@pytest.mark.parametrize("names", [("box", "box"), ("cube", "box"), ("capsule", "box")], ids="-".join)
def test_bodies_with_axes_along_one_another_have_a_gap_wherever_they_are(names, spatial):
    """Where the cosine of two axes is 1 to rounding their product may be 0, and the foot of their perpendicular NaN."""
    scene = pair_of(spatial, *(shape_of(name) for name in names))
    for places in aligned_places(np.random.default_rng(1054), 2500):
        scene.motion.x[:] = places
        gap, *_ = scene.contacts(margin=EVERYTHING)
        assert len(gap) > 0 and np.isfinite(gap).all()


def brought_together(scene, places):
    """The places with the second body moved along the normal until the gap is none."""
    for _ in range(20):  # the normal may turn on the way
        scene.motion.x[:] = places
        gap, normal, *_ = scene.contacts(margin=EVERYTHING)
        nearest = np.argmin(gap)
        if abs(gap[nearest]) < 1e-12:
            break
        places[1, : normal.shape[1]] -= gap[nearest] * normal[nearest]
    return places


def held_apart(J, gap, w):
    """The motion nearest to w with J x >= -gap (Lawson and Hanson's least distance)."""
    h = -gap - J @ w
    E, f = np.vstack([J.T, h]), np.eye(7)[6]
    rest = E @ nnls(E, f)[0] - f
    return w - rest[:6] / rest[6]


def moved(places, w):
    """The second body displaced and turned by (v, omega)."""
    there = places.copy()
    there[1, :3] += w[:3]
    there[1, 3:] = (Rotation.from_rotvec(w[3:]) * Rotation.from_quat(places[1, [4, 5, 6, 3]])).as_quat()[[3, 0, 1, 2]]
    return there


def deepest_after_small_motions(spatial, names, n, seed):
    """The least gap after motions of size 1 that part, or keep, all points found, in units of the motion."""
    rng, worst = np.random.default_rng(seed), 0.0
    scene = pair_of(spatial, *(shape_of(name) for name in names))
    for places in aligned_places(rng, n):
        scene.motion.x[:] = brought_together(scene, places)
        gap, normal, point, _ = scene.contacts(margin=20 * SMALL, dt=0.0)
        assert abs(gap.min()) < 1e-7
        J = np.hstack([normal, np.cross(point - places[1, :3], normal)])
        for _ in range(4):
            w = rng.normal(size=6)
            w = held_apart(J, np.maximum(gap, 0.0), SMALL * w / np.linalg.norm(w))
            scene.motion.x[:] = moved(places, w)
            gap_then, normal_then, *_ = scene.contacts(margin=EVERYTHING)
            deepest = np.argmin(gap_then)
            if np.linalg.norm(normal - normal_then[deepest], axis=1).min() < SAME_NORMAL:
                worst = min(worst, gap_then[deepest] / max(SMALL, np.linalg.norm(w)))
    return worst


def bound_of(names):
    """Of the second order of a small motion (measured 32/m, of two boxes at a corner); and of faces on rims of eight
    points, where lines are held at the rim itself."""
    has_rim = {"cylinder", "coin"} & set(names) and not {"capsule", "sphere", "ellipsoid", "needle"} & set(names)
    return 40 * SMALL + (CHORD if has_rim else 0.0)


@pytest.mark.parametrize("names", ALL_PAIRS, ids="-".join)
def test_bodies_that_are_held_at_the_points_found_do_not_go_into_one_another(names, spatial):
    """No point of a manifold is missing: faces and edges that lie on one another, corners, and round bodies."""
    assert deepest_after_small_motions(spatial, names, 16, ALL_PAIRS.index(names)) > -bound_of(names)


@pytest.mark.stress
@pytest.mark.parametrize("names", ALL_PAIRS, ids="-".join)
def test_many_bodies_that_are_held_at_the_points_found_do_not_go_into_one_another(names, spatial):
    assert deepest_after_small_motions(spatial, names, 2000, 1000 + ALL_PAIRS.index(names)) > -bound_of(names)


@pytest.mark.stress
@pytest.mark.parametrize("names", PAIRS, ids="-".join)
def test_a_hundred_thousand_pairs_of_a_kind_prove_their_gaps(names, spatial):
    for k, scale in enumerate((1.0, 1e-3, 1e3)):
        prove(spatial, names, 80_000 if k == 0 else 10_000, 500 + 3 * PAIRS.index(names) + k, scale, near=NEAR)


@pytest.mark.stress
@pytest.mark.parametrize("names", ALL_PAIRS, ids="-".join)
def test_no_direction_parts_a_hundred_thousand_overlapping_pairs_sooner(names, spatial):
    no_direction_is_better(spatial, names, 100_000, 2000 + ALL_PAIRS.index(names), 400, rounding=DEEPER)
