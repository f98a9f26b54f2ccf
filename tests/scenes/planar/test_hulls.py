"""Gaps, normals and points of planar hulls against brute force and closed forms."""

import itertools

import numpy as np
import pytest
from scipy.optimize import nnls
from scipy.spatial import ConvexHull

from nonsmooth.numerics.rounding import EPS
from nonsmooth.scenes.detection import SAME_PLACE

EVERYTHING = 1e6  # margin: every pair is found


def regular(k, r, turn=0.3):
    angle = turn + 2 * np.pi * np.arange(k) / k
    return r * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def bank(shape):
    """Shapes of different kinds, sizes and roundness, as functions of their body."""
    return {
        "disc": lambda b: shape.disc(b, 0.4),
        "capsule": lambda b: shape.capsule(b, 0.7, 0.15),
        "segment": lambda b: shape.capsule(b, 0.5, 0.0),
        "box": lambda b: shape.box(b, 0.6, 0.3),
        "rounded box": lambda b: shape.box(b, 0.3, 0.4, 0.1),
        "triangle": lambda b: shape.polygon(b, [(-0.5, -0.2), (0.8, -0.2), (0.0, 0.5)]),
        "heptagon": lambda b: shape.polygon(b, regular(7, 0.5)),
        "needle": lambda b: shape.polygon(b, [(-1.0, 0.0), (1.0, -0.01), (1.0, 0.01)]),
    }


def world(row, x):
    """The vertices of a hull, (n, k, 2), at places x (n, 3)."""
    c, s = np.cos(x[:, 2, None]), np.sin(x[:, 2, None])
    p = np.asarray(row.vertices, dtype=float)
    return np.stack([x[:, 0, None] + c * p[:, 0] - s * p[:, 1], x[:, 1, None] + s * p[:, 0] + c * p[:, 1]], axis=-1)


def signed_distance(A, B):
    """Of two convex hulls (n, k, 2), (n, m, 2) in one place each.

    The hull of the differences B - A (Qhull) has the origin inside where they overlap, and its nearest face says how
    deep; outside, the least of all distances of a vertex from an edge.
    """
    outside = np.minimum(vertex_edge(A, B), vertex_edge(B, A))
    inside = np.array([deepest(a, b) for a, b in zip(A, B, strict=True)])
    return np.where(inside < 0, inside, outside)


def deepest(a, b):
    D = (b[:, None] - a[None]).reshape(-1, 2)
    if len(D) < 3:
        return 0.0
    return ConvexHull(D, qhull_options="QJ" if len(a) <= 2 and len(b) <= 2 else "Qt").equations[:, 2].max()


def vertex_edge(A, B):
    """The least distance of a vertex of A from an edge of B."""
    P, Q = A[:, :, None], B[:, None]
    E = np.roll(B, -1, axis=1)[:, None] - Q
    t = np.clip(((P - Q) * E).sum(-1) / np.maximum((E * E).sum(-1), 1e-300), 0, 1)
    return np.linalg.norm(P - Q - t[..., None] * E, axis=-1).min((1, 2))


def support(P, n):
    """max of n . p over the points (n, k, 2)."""
    return (P * n[:, None]).sum(-1).max(1)


def random_places(rng, n, spread=1.6):
    x = np.zeros((n, 2, 3))
    x[:, :, 2] = rng.uniform(-np.pi, np.pi, (n, 2))
    x[:, :, :2] = rng.uniform(-0.5, 0.5, (n, 2, 2)) * spread
    return x


PAIRS = list(itertools.combinations_with_replacement(
    ["disc", "capsule", "segment", "box", "rounded box", "triangle", "heptagon", "needle"], 2))  # fmt: skip


@pytest.mark.parametrize("names", PAIRS, ids="-".join)
def test_gap_normal_and_point_are_those_of_the_hull_of_differences(names, planar, shape):
    """3000 random pairs of each two kinds, 10^5 in all; every tenth also against Qhull."""
    prove_each_other(names, planar, shape, 3000, PAIRS.index(names), 10)


@pytest.mark.stress
@pytest.mark.parametrize("names", PAIRS, ids="-".join)
def test_a_hundred_thousand_pairs_of_a_kind_prove_their_gaps(names, planar, shape):
    prove_each_other(names, planar, shape, 100_000, 100 + PAIRS.index(names), 100)


def prove_each_other(names, planar, shape, n_pairs, seed, every):
    """The normal is its own proof: along it the cores are apart by the gap (their supports), and no direction does
    better than the distance where they are apart, or than the nearest face of the hull of differences where they
    overlap."""
    rng = np.random.default_rng(seed)
    rows = [bank(shape)[name](b) for b, name in enumerate(names)]
    scene, x = planar(rows, np.zeros((2, 3))), random_places(rng, n_pairs)
    gap, normal, point = np.zeros(len(x)), np.zeros((len(x), 2)), np.zeros((len(x), 2))
    for k in range(len(x)):
        scene.motion.x[:] = x[k]
        n = scene.run(margin=EVERYTHING)
        best = int(np.argmin(scene.found.gap[:n]))
        gap[k], normal[k], point[k] = scene.found.gap[best], scene.found.normal[best], scene.found.point[best]
    A, B = (world(row, x[:, b]) for b, row in enumerate(rows))
    r_A, r_B = (row.radius for row in rows)
    tol = 100 * EPS
    assert np.abs(np.linalg.norm(normal, axis=1) - 1).max() < tol
    core = gap + r_A + r_B
    assert np.abs(-support(B, -normal) - support(A, normal) - core).max() < tol
    apart = core > 0
    distance = np.minimum(vertex_edge(A, B), vertex_edge(B, A))
    assert np.abs(distance - core)[apart].max() < tol
    some = slice(None, None, every)
    exact = signed_distance(A[some], B[some])
    assert np.abs(exact - core[some]).max() < 1e-9  # Qhull merges and joggles
    for P, r, side in ((A, r_A, -0.5), (B, r_B, 0.5)):  # from the point to the surface, along the normal
        on = point + side * gap[:, None] * normal
        touching = vertex_edge(on[:, None], P)
        assert np.abs(touching - r).max() < tol


def test_parallel_faces_have_two_points_with_equal_gaps_at_the_ends_of_their_overlap(planar, shape):
    for r in (0.0, 0.1):
        scene = planar([shape.box(0, 0.5, 0.5, r), shape.box(1, 0.3, 0.2, r)], [(0, 0, 0), (0.4, 0.71 + 2 * r, 0)])
        gap, normal, point, _ = scene.contacts(margin=0.1)
        assert np.abs(gap - 0.01).max() < 4 * EPS and (normal == [0, 1]).all()
        assert np.abs(np.sort(point[:, 0]) - [0.1, 0.5]).max() < 4 * EPS
        assert np.abs(point[:, 1] - 0.505 - r).max() < 4 * EPS


def test_an_overlap_that_is_deep_has_the_face_of_least_penetration(planar, shape):
    scene = planar([shape.box(0, 1.0, 0.5), shape.box(1, 0.3, 0.3)], [(0, 0, 0), (0.5, 0.4, 0)])
    gap, normal, _, _ = scene.contacts()
    assert np.abs(gap + 0.4).max() < 4 * EPS and (normal == [0, 1]).all()


def test_a_disc_at_the_centre_of_another_has_a_normal(planar, shape):
    gap, normal, point, _ = planar([shape.disc(0, 0.3), shape.disc(1, 0.2)], [(1, 2, 0), (1, 2, 0)]).contacts()
    assert gap == [-0.5] and (normal == [0, 1]).all() and np.abs(point - [1, 2.05]).max() < 4 * EPS


def test_vertices_that_meet_have_the_normal_of_a_face(planar, shape):
    """Their difference has no direction any more."""
    scene = planar([shape.box(0), shape.box(1)], [(0, 0, 0), (1 + 1e-16, 1 + 1e-16, 0)])
    gap, normal, point, _ = scene.contacts()
    assert np.abs(gap).max() < 4 * EPS and np.abs(normal).sum() == len(normal) and np.abs(point - 0.5).max() < 4 * EPS


def test_collinear_segments_are_as_far_apart_as_their_ends(planar, shape):
    scene = planar([shape.capsule(0, 0.5, 0.1), shape.capsule(1, 0.5, 0.1)], [(0, 0, 0.0), (1.3, 0, 0.0)])
    gap, normal, _, _ = scene.contacts(margin=1.0)
    assert np.abs(gap - 0.1).max() < 8 * EPS and np.abs(normal - [1, 0]).max() < 4 * EPS


@pytest.mark.parametrize("names", PAIRS[::3], ids="-".join)
def test_swapping_two_shapes_turns_the_normal_round_and_nothing_else(names, planar, shape):
    rng = np.random.default_rng(7)
    x = random_places(rng, 200)
    there = planar([bank(shape)[name](b) for b, name in enumerate(names)], x[0])
    back = planar([bank(shape)[name](b) for b, name in enumerate(names[::-1])], x[0])
    for places in x:
        there.motion.x[:], back.motion.x[:] = places, places[::-1]
        (gap, normal, point, key), (other_gap, other_normal, other_point, _) = there.contacts(), back.contacts()
        order, other = np.lexsort(point.round(9).T), np.lexsort(other_point.round(9).T)
        assert len(gap) == len(other_gap) and len(set(key)) == len(key)
        assert np.abs(gap[order] - other_gap[other]).max(initial=0) < 100 * EPS
        assert np.abs(normal[order] + other_normal[other]).max(initial=0) < 100 * EPS
        assert np.abs(point[order] - other_point[other]).max(initial=0) < 100 * EPS


@pytest.mark.parametrize("names", PAIRS[1::3], ids="-".join)
@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_a_moved_and_scaled_world_has_its_contacts_moved_and_scaled(names, scale, planar, shape):
    """The rounding of the places themselves, some metres out, is left."""
    rng = np.random.default_rng(11)
    rows = [bank(shape)[name](b) for b, name in enumerate(names)]
    scaled = [shape.polygon(r.body, scale * np.asarray(r.vertices, dtype=float), scale * r.radius) for r in rows]
    here, there = planar(rows, np.zeros((2, 3))), planar(scaled, np.zeros((2, 3)))
    turn, shift = 0.7, np.array([3.0, -2.0])
    R = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    for places in random_places(rng, 200):
        here.motion.x[:] = places
        there.motion.x[:, :2] = scale * (places[:, :2] @ R.T + shift)
        there.motion.x[:, 2] = places[:, 2] + turn
        gap, normal, point, key = here.contacts(margin=0.5)
        gap_there, normal_there, point_there, key_there = there.contacts(margin=0.5 * scale)
        assert (key == key_there).all()
        assert np.abs(gap_there / scale - gap).max(initial=0) < 100 * EPS
        assert np.abs(normal_there - normal @ R.T).max(initial=0) < 1e-12
        assert np.abs(point_there / scale - (point @ R.T + shift)).max(initial=0) < 1e-13


def test_keys_stay_while_a_stack_trembles(planar, shape):
    """Angles and places of 1e-7 change which face is the farther out, and which vertex, but none of the keys."""
    rng = np.random.default_rng(3)
    rows = [shape.box(0, 0.5, 0.1), shape.box(1, 0.4, 0.1), shape.box(2, 0.5, 0.1), shape.half_plane(3)]
    rest = np.array([[0, 0.1, 0], [0.05, 0.3, 0], [-0.03, 0.5, 0], [0, 0, 0]])
    scene = planar(rows, rest)
    keys = scene.contacts()[3]
    assert len(keys) == 6
    for _ in range(300):
        scene.motion.x[:3] = rest[:3] + 1e-7 * rng.uniform(-1, 1, (3, 3))
        gap, _, _, key = scene.contacts()
        assert (key == keys).all() and np.abs(gap).max() < 1e-6


def test_the_gap_and_the_normal_of_two_boxes_change_without_a_jump(planar, shape):
    """A box that rolls off the edge of another, a hair above it: face, corner and the other's face in turn."""
    scene = planar([shape.box(0), shape.box(1)], np.zeros((2, 3)))
    before = None
    for tilt in np.linspace(0.2, 0.4, 2001):
        c, s = np.cos(tilt), np.sin(tilt)
        corner = np.array([0.5 + 0.03 * (tilt - 0.3), 0.52])  # of the moving one, lower left
        scene.motion.x[1] = corner[0] + 0.5 * c - 0.5 * s, corner[1] + 0.5 * s + 0.5 * c, tilt
        gap, normal, point, _ = scene.contacts(margin=0.05)
        best = np.argmin(gap)
        now = np.array([gap[best], *normal[best], *point[best]])
        assert before is None or np.abs(now - before).max() < 0.01
        before = now


def nearly(rng):
    """0, or of any size from 1e-16 to 1e-2, of either sign."""
    return rng.choice([-1, 0, 1], p=[0.4, 0.2, 0.4]) * 10 ** rng.uniform(-16, -2)


@pytest.mark.upkeep
@pytest.mark.parametrize("names", [("box", "box"), ("rounded box", "box"), ("segment", "box"), ("capsule", "box"),
                                   ("capsule", "capsule"), ("segment", "segment")], ids="-".join)  # fmt: skip
def test_edges_that_are_nearly_parallel_and_flush_are_as_far_apart_as_they_are(names, planar, shape):
    """Apart: the least of all distances of a vertex from an edge. Overlapping: no more than SAME_PLACE is lost along
    the normal, by which two vertices that meet have the normal of a face."""
    rng = np.random.default_rng(5)
    rows = [bank(shape)[name](b) for b, name in enumerate(names)]
    half = [np.abs(np.asarray(row.vertices, dtype=float)).max(0) for row in rows]
    scene, n = planar(rows, np.zeros((2, 3))), 2500
    x, core, normal = np.zeros((n, 2, 3)), np.zeros(n), np.zeros((n, 2))
    radius = rows[0].radius + rows[1].radius
    for k in range(n):
        quarters = rng.integers(0, 4, 2)
        x[k, :, 2] = np.pi / 2 * quarters + [nearly(rng), nearly(rng)]
        a, b = (h[::-1] if q % 2 else h for h, q in zip(half, quarters, strict=True))
        x[k, 1, :2] = [rng.choice([0, a[c] - b[c], a[c] + b[c], rng.uniform(-1, 1)]) + nearly(rng) for c in range(2)]
        c = rng.integers(2)
        x[k, 1, c] = a[c] + b[c] + rng.integers(2) * radius + nearly(rng)
        scene.motion.x[:] = x[k]
        m = scene.run(margin=EVERYTHING)
        assert m == len(set(scene.found.key[:m])) > 0
        best = int(np.argmin(scene.found.gap[:m]))
        core[k], normal[k] = scene.found.gap[best] + radius, scene.found.normal[best]
    A, B = (world(row, x[:, b]) for b, row in enumerate(rows))
    distance, proved = np.minimum(vertex_edge(A, B), vertex_edge(B, A)), -support(B, -normal) - support(A, normal)
    near = 3 * SAME_PLACE
    assert np.abs(distance - core)[core > near].max() < 1e-11 and (distance < 2 * near)[np.abs(core) <= near].all()
    assert np.abs(proved - core)[np.abs(core) > near].max() < 1e-11


SMALL = 1e-4  # m and rad of a small motion; of its square is the error of rows that are those of the place before


def held_apart(J, gap, w):
    """The motion nearest to w with J x >= -gap (Lawson and Hanson's least distance)."""
    h = -gap - J @ w
    E, f = np.vstack([J.T, h]), np.eye(4)[3]
    rest = E @ nnls(E, f)[0] - f
    return w - rest[:3] / rest[3]


def deepest_after_small_motions(planar, rows, n, seed):
    """The least gap after motions of size 1 that part, or keep, all points found, in units of the motion."""
    rng, worst = np.random.default_rng(seed), 0.0
    scene = planar(rows, np.zeros((2, 3)))
    for k, places in enumerate(random_places(rng, n)):
        if k % 2:
            places[:, 2] = places[0, 2] + np.pi / 2 * rng.integers(4, size=2)
        for _ in range(3):  # brought together
            scene.motion.x[:] = places
            gap, normal, *_ = scene.contacts(margin=EVERYTHING)
            places[1, :2] -= gap.min() * normal[np.argmin(gap)]
        scene.motion.x[:] = places
        gap, normal, point, _ = scene.contacts(margin=20 * SMALL, dt=0.0)
        assert abs(gap.min()) < 1e-9
        arm = point - places[1, :2]
        J = np.column_stack([normal, arm[:, 0] * normal[:, 1] - arm[:, 1] * normal[:, 0]])
        for _ in range(4):
            w = rng.normal(size=3)
            w = held_apart(J, np.maximum(gap, 0.0), SMALL * w / np.linalg.norm(w))
            scene.motion.x[1] = places[1] + w
            gap_then, normal_then, *_ = scene.contacts(margin=EVERYTHING)
            deepest = np.argmin(gap_then)
            if np.linalg.norm(normal - normal_then[deepest], axis=1).min() < 0.1:  # else it is another face
                worst = min(worst, gap_then[deepest] / max(SMALL, np.linalg.norm(w)))
    return worst


@pytest.mark.parametrize("names", PAIRS, ids="-".join)
def test_hulls_that_are_held_at_the_points_found_do_not_go_into_one_another(names, planar, shape):
    """No point of a manifold is missing: edges that lie on one another, flush ones, vertices."""
    rows = [bank(shape)[name](b) for b, name in enumerate(names)]
    assert deepest_after_small_motions(planar, rows, 60, PAIRS.index(names)) > -40 * SMALL
