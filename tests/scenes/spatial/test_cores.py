"""Gaps, normals and points of spatial shapes against proofs, brute force and closed forms."""

import itertools

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from nonsmooth.numerics.rounding import EPS
from nonsmooth.scenes.detection import SAME_PLACE
from nonsmooth.scenes.spatial.boxes import FACE_OVER_EDGES

EVERYTHING = 1e6  # margin: every pair is found
NAMES = ("sphere", "capsule", "cube", "box", "plate", "rounded box")


def bank(solid):
    """Shapes of different kinds, sizes and roundness, as functions of their body."""
    return {
        "sphere": lambda b: solid.sphere(b, 0.4),
        "capsule": lambda b: solid.capsule(b, 0.5, 0.15),
        "cube": lambda b: solid.box(b, 0.4, 0.4, 0.4),
        "box": lambda b: solid.box(b, 0.6, 0.3, 0.2),
        "plate": lambda b: solid.box(b, 0.7, 0.5, 0.02),
        "rounded box": lambda b: solid.box(b, 0.3, 0.2, 0.4, 0.1),
    }


def matrices(x):
    return Rotation.from_quat(x[..., [4, 5, 6, 3]]).as_matrix()


def corners(row, x):
    """The vertices of a core, (n, 8, 3), at places x (n, 7)."""
    signs = np.array(list(itertools.product((-1, 1), repeat=3)))
    return x[:, None, :3] + np.einsum("nab,kb->nka", matrices(x), signs * np.asarray(row.size))


def support(P, n):
    """max of n . p over the points (n, k, 3)."""
    return (P * n[:, None]).sum(-1).max(1)


def distance_from_box(row, x, p):
    """Of points p (n, 3) from the core: 0 inside."""
    q = np.einsum("nba,nb->na", matrices(x), p - x[:, :3])
    return np.linalg.norm(q - np.clip(q, -np.asarray(row.size), row.size), axis=1)


def depth(A, B):
    """The signed distance of the origin from the hull of all differences, its nearest face (Qhull)."""
    D = (B[:, None] - A[None]).reshape(-1, 3)
    return ConvexHull(D, qhull_options="QJ").equations[:, 3].max()


def random_places(rng, n, spread=1.5):
    x = np.zeros((n, 2, 7))
    x[:, :, :3] = rng.uniform(-0.5, 0.5, (n, 2, 3)) * spread
    q = rng.normal(size=(n, 2, 4))
    q[: n // 8] = [1, 0, 0, 0]  # axes that are parallel, and
    q[n // 8 : n // 4, :, 1:3] = 0  # those that have one in common
    x[:, :, 3:] = q / np.linalg.norm(q, axis=-1, keepdims=True)
    return x


PAIRS = list(itertools.combinations_with_replacement(NAMES, 2))


def nearest_contacts(scene, x):
    """(gap, normal, point, key) of the contact of least gap at each of the places."""
    gap, normal, point, key = np.zeros(len(x)), np.zeros((len(x), 3)), np.zeros((len(x), 3)), np.zeros(len(x), int)
    for k in range(len(x)):
        scene.motion.x[:] = x[k]
        n = scene.run(margin=EVERYTHING)
        assert n == len(set(scene.found.key[:n].tolist())) > 0
        best = int(np.argmin(scene.found.gap[:n]))
        gap[k], key[k] = scene.found.gap[best], scene.found.key[best]
        normal[k], point[k] = scene.found.normal[best], scene.found.point[best]
    return gap, normal, point, key


@pytest.mark.parametrize("names", PAIRS, ids="-".join)
def test_gap_normal_and_point_prove_each_other(names, spatial, solid):
    """5000 random pairs of each two kinds, 10^5 in all.

    Along the normal the cores are apart by the gap (their supports): it is no more than the distance. The point has a
    point of either surface at half the gap along the normal: it is no less. Where cores overlap the first says that
    they part along the normal by so much, and Qhull that no face of the differences is nearer.
    """
    rng = np.random.default_rng(PAIRS.index(names))
    rows = [bank(solid)[name](b) for b, name in enumerate(names)]
    x = random_places(rng, 5000)
    gap, normal, point, _ = nearest_contacts(spatial(rows, np.zeros((2, 3))), x)
    A, B = (corners(row, x[:, b]) for b, row in enumerate(rows))
    r_A, r_B = (row.radius for row in rows)
    tol = 100 * EPS
    core = gap + r_A + r_B
    assert np.abs(np.linalg.norm(normal, axis=1) - 1).max() < tol
    proved = -support(B, -normal) - support(A, normal)  # the direction of two points d apart is known to EPS/d
    assert (np.abs(proved - core) < tol * (1 + 0.1 / np.maximum(np.abs(core), 1e-9))).mean() > 0.999
    preferred = FACE_OVER_EDGES * sum(np.linalg.norm(row.size) for row in rows)  # a face, where edges do no better
    assert (core - proved).min() > -tol and (core - proved).max() < max(preferred, 1e-11)
    on_A, on_B = (point + side * gap[:, None] * normal for side in (-0.5, 0.5))
    apart = core > 0
    assert np.abs(distance_from_box(rows[0], x[:, 0], on_A - r_A * normal)).max() < tol
    assert np.abs(distance_from_box(rows[1], x[:, 1], on_B + r_B * normal)).max() < tol
    if any(min(row.size) > 0 for row in rows):
        assert (~apart).sum() > 50
        for k in np.flatnonzero(~apart)[:100]:
            assert abs(depth(A[k], B[k]) - core[k]) < 1e-8  # Qhull joggles


def test_a_box_on_a_box_touches_at_the_corners_of_the_overlap(spatial, solid):
    scene = spatial([solid.box(0), solid.box(1, 0.2, 0.3, 0.25)], [(0, 0, 0), (0.4, 0.1, 0.76)])
    gap, normal, point, _ = scene.contacts(margin=0.1)
    assert (
        np.abs(gap - 0.01).max() < 4 * EPS
        and (normal == [0, 0, 1]).all()
        and np.abs(point[:, 2] - 0.505).max() < 4 * EPS
    )
    corners_ = sorted(map(tuple, point[:, :2].round(12).tolist()))
    assert corners_ == [(0.2, -0.2), (0.2, 0.4), (0.5, -0.2), (0.5, 0.4)]


@pytest.mark.parametrize("beside", [-1e-13, 0.0, 1e-13])
def test_boxes_that_meet_along_an_edge_touch_at_both_ends_of_it(beside, spatial, solid):
    """Flush in x and in z, and beside each other by a rounding or not."""
    _, _, point, _ = spatial([solid.box(0), solid.box(1)], [(0, 0, 0), (1 + beside, 0.3, 1 + beside)]).contacts()
    assert abs(point[:, 1].min() + 0.2) < 1e-9 and abs(point[:, 1].max() - 0.5) < 1e-9


def test_a_turned_face_on_an_equal_one_touches_in_eight_points(spatial, solid):
    turn = np.pi / 8
    scene = spatial([solid.box(0), solid.box(1)], [(0, 0, 0, 1, 0, 0, 0), (0, 0, 1, np.cos(turn), 0, 0, np.sin(turn))])
    gap, normal, point, key = scene.contacts()
    assert len(gap) == 8 == len(set(key)) and np.abs(gap).max() < 4 * EPS and (normal == [0, 0, 1]).all()
    assert np.abs(np.abs(point[:, :2]).max(1) - 0.5).max() < 4 * EPS  # where the edges of the two squares cross
    assert np.abs(np.abs(point[:, :2]).min(1) - 0.5 * (np.sqrt(2) - 1)).max() < 4 * EPS


def test_two_crossed_edges_touch_in_one_point(spatial, solid):
    """Two cubes on edge, the upper one turned by a quarter: the distance of the edges is known."""
    s = np.sin(np.pi / 8)
    c = np.cos(np.pi / 8)
    for height, gap_ in ((2 * np.sqrt(0.5) + 0.01, 0.01), (2 * np.sqrt(0.5) - 0.02, -0.02)):
        scene = spatial([solid.box(0), solid.box(1)], [(0, 0, 0, c, s, 0, 0), (0.1, 0.2, height, c, 0, s, 0)])
        gap, normal, point, _ = scene.contacts(margin=0.1)
        assert len(gap) == 1 and abs(gap[0] - gap_) < 8 * EPS and np.abs(normal - [0, 0, 1]).max() < 8 * EPS

        assert np.abs(point[0] - [0.0, 0.0, np.sqrt(0.5) + gap_ / 2] - [0, 0, 0])[2] < 8 * EPS


def test_corners_that_meet_have_the_normal_of_a_face(spatial, solid):
    gap, normal, point, _ = spatial([solid.box(0), solid.box(1)], [(0, 0, 0), (1, 1 + 1e-16, 1)]).contacts()
    assert np.abs(gap).max() < 4 * EPS and np.abs(normal).sum() == len(normal) and np.abs(point - 0.5).max() < 4 * EPS


def test_a_sphere_at_the_centre_of_another_and_of_a_capsule_and_a_box_has_a_normal(spatial, solid):
    for other, gap_ in (
        (solid.sphere(1, 0.2), -0.5),
        (solid.capsule(1, 0.5, 0.2), -0.5),
        (solid.box(1, 0.5, 0.4, 0.6), -0.7),
    ):
        gap, normal, _, _ = spatial([solid.sphere(0, 0.3), other], np.zeros((2, 3))).contacts()
        assert np.abs(gap - gap_).max() < 4 * EPS and np.abs(normal).sum() == 1


def test_capsules_side_by_side_touch_at_both_ends_of_their_overlap(spatial, solid):
    for shift, ends in ((0.0, (-0.5, 0.5)), (0.3, (-0.2, 0.5)), (0.7, (0.2, 0.5))):
        scene = spatial([solid.capsule(0), solid.capsule(1)], [(0, 0, 0), (0.4, 0, shift)])
        gap, normal, point, key = scene.contacts()
        assert len(gap) == 2 == len(set(key)) and np.abs(gap).max() < 4 * EPS
        assert np.abs(normal - [1, 0, 0]).max() < 4 * EPS and np.abs(np.sort(point[:, 2]) - ends).max() < 4 * EPS


def test_capsules_in_a_line_are_as_far_apart_as_their_ends(spatial, solid):
    gap, normal, _, _ = spatial([solid.capsule(0), solid.capsule(1)], [(0, 0, 0), (0, 0, 1.5)]).contacts(margin=1.0)
    assert np.abs(gap - 0.1).max() < 4 * EPS and (normal == [0, 0, 1]).all()


def test_capsules_whose_axes_meet_part_across_both(spatial, solid):
    s = np.sqrt(0.5)
    gap, normal, _, _ = spatial([solid.capsule(0), solid.capsule(1)],
                                [(0, 0, 0, 1, 0, 0, 0), (0.1, 0, 0.1, s, s, 0, 0)]).contacts()  # fmt: skip
    gap, normal = gap[np.argmin(gap)], normal[np.argmin(gap)]
    assert abs(gap + 0.3) < 4 * EPS
    scene = spatial([solid.capsule(0), solid.capsule(1)], [(0, 0, 0, 1, 0, 0, 0), (0, 0, 0.1, s, s, 0, 0)])
    gap, normal, _, key = scene.contacts()
    assert abs(gap.min() + 0.4) < 4 * EPS and np.abs(np.abs(normal[np.argmin(gap)]) - [1, 0, 0]).max() < 4 * EPS
    same = spatial([solid.capsule(0), solid.capsule(1)], np.zeros((2, 3))).contacts()
    assert np.abs(same[0] + 0.4).max() < 4 * EPS and (same[1] == [1, 0, 0]).all()


def test_a_capsule_that_lies_on_a_box_touches_at_its_ends_or_at_the_border(spatial, solid):
    s = np.sqrt(0.5)
    scene = spatial([solid.box(0), solid.capsule(1)], [(0, 0, 0, 1, 0, 0, 0), (0.2, 0.1, 0.7, s, 0, s, 0)])
    gap, normal, point, _ = scene.contacts()
    assert len(gap) == 2 and np.abs(gap).max() < 8 * EPS and np.abs(normal - [0, 0, 1]).max() < 4 * EPS
    assert np.abs(np.sort(point[:, 0]) - [-0.3, 0.5]).max() < 8 * EPS


@pytest.mark.parametrize("names", PAIRS, ids="-".join)
def test_swapping_two_shapes_turns_the_normal_round_and_nothing_else(names, spatial, solid):
    rng = np.random.default_rng(7)
    x = random_places(rng, 80)[20:]
    there = spatial([bank(solid)[name](b) for b, name in enumerate(names)], np.zeros((2, 3)))
    back = spatial([bank(solid)[name](b) for b, name in enumerate(names[::-1])], np.zeros((2, 3)))
    for places in x:
        there.motion.x[:], back.motion.x[:] = places, places[::-1]
        (gap, normal, point, key), (other_gap, other_normal, other_point, _) = there.contacts(), back.contacts()
        order, other = np.lexsort(point.round(9).T), np.lexsort(other_point.round(9).T)
        assert len(gap) == len(other_gap) and len(set(key)) == len(key)
        for one, two in ((gap, other_gap), (normal, -other_normal), (point, other_point)):
            assert np.abs(one[order] - two[other]).max(initial=0) < 1e-12


@pytest.mark.parametrize("names", PAIRS[1::2], ids="-".join)
@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_a_moved_and_scaled_world_has_its_contacts_moved_and_scaled(names, scale, spatial, solid):
    """The rounding of the places themselves, some metres out, is left."""
    rng = np.random.default_rng(11)
    rows = [bank(solid)[name](b) for b, name in enumerate(names)]
    scaled = [r._replace(radius=scale * r.radius, size=scale * np.asarray(r.size)) for r in rows]
    here, there = spatial(rows, np.zeros((2, 3))), spatial(scaled, np.zeros((2, 3)))
    turn, shift = Rotation.from_rotvec([0.3, -0.5, 0.7]), np.array([3.0, -2.0, 1.0])
    R = turn.as_matrix()
    for places in random_places(rng, 120)[40:]:
        here.motion.x[:] = places
        there.motion.x[:, :3] = scale * (places[:, :3] @ R.T + shift)
        there.motion.x[:, 3:] = (turn * Rotation.from_quat(places[:, [4, 5, 6, 3]])).as_quat()[:, [3, 0, 1, 2]]
        gap, normal, point, key = here.contacts(margin=0.1)
        gap_there, normal_there, point_there, key_there = there.contacts(margin=0.1 * scale)
        assert (key == key_there).all()
        assert np.abs(gap_there / scale - gap).max(initial=0) < 1e-12
        assert np.abs(normal_there - normal @ R.T).max(initial=0) < 1e-11
        assert np.abs(point_there / scale - (point @ R.T + shift)).max(initial=0) < 1e-11


def test_keys_stay_while_a_stack_trembles(spatial, solid):
    """Angles and places of 1e-8 change which face is the farther out, and which edge, but none of the keys."""
    rng = np.random.default_rng(3)
    rows = [solid.box(0, 0.5, 0.5, 0.1), solid.box(1, 0.4, 0.3, 0.1), solid.box(2, 0.5, 0.5, 0.1), solid.half_space(3)]
    turn = np.cos(0.2), 0, 0, np.sin(0.2)
    rest = np.array(
        [(0, 0, 0.1, 1, 0, 0, 0), (0.05, 0, 0.3, *turn), (-0.03, 0, 0.5, 1, 0, 0, 0), (0, 0, 0, 1, 0, 0, 0)]
    )
    scene = spatial(rows, rest)
    keys = scene.contacts()[3]
    assert len(keys) == 14  # a corner of the middle one is cut off above and below
    for _ in range(300):
        scene.motion.x[:3] = rest[:3] + 1e-8 * rng.uniform(-1, 1, (3, 7))
        gap, _, _, key = scene.contacts()
        assert (key == keys).all() and np.abs(gap).max() < 1e-7


def nearly(rng):
    """0, or of any size from 1e-16 to 1e-2, of either sign."""
    return rng.choice([-1, 0, 1], p=[0.4, 0.2, 0.4]) * 10 ** rng.uniform(-16, -2)


def nearly_aligned(rng, rows, n):
    """Places of two cores whose faces are parallel, flush or concentric but for ``nearly``."""
    x = np.zeros((n, 2, 7))
    for k in range(n):
        extent, radius = [], rows[0].radius + rows[1].radius
        for b, row in enumerate(rows):
            quarter = Rotation.from_euler("xyz", np.pi / 2 * rng.integers(0, 4, 3))
            turn = Rotation.from_rotvec([nearly(rng) for _ in range(3)]) * quarter
            x[k, b, 3:] = turn.as_quat()[[3, 0, 1, 2]]
            extent.append(np.abs(quarter.as_matrix()) @ np.asarray(row.size))
        a, b = extent
        x[k, 1, :3] = [rng.choice([0, a[c] - b[c], a[c] + b[c], rng.uniform(-1, 1)]) + nearly(rng) for c in range(3)]
        c = rng.integers(3)
        x[k, 1, c] = a[c] + b[c] + rng.integers(2) * radius + nearly(rng)
    return x


@pytest.mark.upkeep
@pytest.mark.parametrize("names", [("box", "box"), ("rounded box", "box"), ("capsule", "box"), ("box", "capsule"),
                                   ("capsule", "capsule")], ids="-".join)  # fmt: skip
def test_faces_and_edges_that_are_nearly_parallel_and_flush_have_the_points_of_least_distance(names, spatial, solid):
    """Both points are on the surfaces, and along the normal the cores are apart by the gap, but for what the direction
    of two points d apart is worth that are known to SAME_PLACE, and for FACE_OVER_EDGES."""
    rng = np.random.default_rng(PAIRS.index(tuple(sorted(names, key=NAMES.index))))
    rows = [bank(solid)[name](b) for b, name in enumerate(names)]
    scene, x = spatial(rows, np.zeros((2, 3))), nearly_aligned(rng, rows, 1500)
    gap, normal, point, _ = nearest_contacts(scene, x)
    A, B = (corners(row, x[:, b]) for b, row in enumerate(rows))
    r_A, r_B = (row.radius for row in rows)
    core, scale = gap + r_A + r_B, sum(np.linalg.norm(row.size) + row.radius for row in rows)
    lost = core + support(B, -normal) + support(A, normal)
    assert lost.min() > -SAME_PLACE * scale
    assert (lost < scale * (FACE_OVER_EDGES + 2 * SAME_PLACE / np.maximum(np.abs(core), 1e-12))).all()
    on_A, on_B = (point + side * gap[:, None] * normal for side in (-0.5, 0.5))
    assert distance_from_box(rows[0], x[:, 0], on_A - r_A * normal).max() < 3 * SAME_PLACE * scale
    assert distance_from_box(rows[1], x[:, 1], on_B + r_B * normal).max() < 3 * SAME_PLACE * scale
