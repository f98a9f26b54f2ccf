"""Which contacts of spatial shapes are kept, in which order, and what happens where there is no room."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from nonsmooth.numerics.rounding import EPS
from nonsmooth.scenes.detection import NOT_FINITE, SHAPE_BITS
from nonsmooth.scenes.shape_rows import HALF_SPACE

WALL = (0, -2.0, 0, *Rotation.from_rotvec([-np.pi / 2, 0, 0]).as_quat()[[3, 0, 1, 2]])


def heap(spatial, solid, n=80, seed=0):
    """Shapes of all kinds, thrown about in a corner, with velocities."""
    rng = np.random.default_rng(seed)
    kinds = [solid.sphere, solid.capsule, solid.box, lambda b: solid.box(b, 0.3, 0.2, 0.4, 0.1)]
    rows = [kinds[b % 4](b) for b in range(n)] + [solid.half_space(n), solid.half_space(n, WALL)]
    x = np.zeros((n + 1, 7))
    x[:, 3] = 1
    x[:n, :3] = rng.uniform([-2, -2, 0.2], [2, 2, 3], (n, 3))
    turned = rng.permutation(n)[: 3 * n // 4]
    q = rng.normal(size=(len(turned), 4))
    x[turned, 3:] = q / np.linalg.norm(q, axis=1, keepdims=True)
    v = rng.uniform(-3, 3, (n + 1, 6))
    v[n] = 0
    moves = np.ones(n + 1, dtype=int)
    moves[n] = 0
    return spatial(rows, x, v, moves, room=40 * n, pairs=40 * n)


@pytest.mark.parametrize("margin", [0.0, 0.3])
def test_the_interpreter_finds_the_bits_of_compiled_code(spatial, solid, margin):
    one, two = heap(spatial, solid), heap(spatial, solid)
    n = one.run(margin=margin, dt=1e-2)
    assert n == two.run(margin=margin, dt=1e-2, is_compiled=False) and n > 300
    assert one.found.words.tobytes() == two.found.words.tobytes()


def test_contacts_come_in_the_order_of_their_keys_and_each_key_once(spatial, solid):
    scene = heap(spatial, solid)
    n = scene.run(margin=0.1)
    f = scene.found
    assert (np.diff(f.key[:n]) > 0).all() and (f.shape_i[:n] < f.shape_j[:n]).all()
    assert (f.key[:n] >> (63 - 2 * SHAPE_BITS) == (f.shape_i[:n] << SHAPE_BITS) + f.shape_j[:n]).all()


def test_a_pair_is_found_in_a_heap_as_it_is_found_alone(spatial, solid):
    """The broad phase loses none, and what is found does not depend on the steps before."""
    scene = heap(spatial, solid)
    heap_ = heap(spatial, solid, seed=1)
    heap_.run()
    heap_.motion.x[:], heap_.motion.v[:] = scene.motion.x, scene.motion.v
    n = heap_.run(margin=0.05)
    found = [(k >> (63 - 2 * SHAPE_BITS), g) for k, g in zip(heap_.found.key[:n], heap_.found.gap[:n], strict=True)]
    alone = []
    for i in range(len(scene.rows)):
        for j in range(i + 1, len(scene.rows)):
            a, b = scene.rows[i].body, scene.rows[j].body
            if a != b:
                rows = [type(row)(k, row.kind, row.place, row.radius, row.size) for k, row in enumerate((scene.rows[i],
                        scene.rows[j]))]  # fmt: skip
                pair = spatial(rows, scene.motion.x[[a, b]], scene.motion.v[[a, b]])
                alone += [((i << SHAPE_BITS) + j, g) for g in pair.contacts(margin=0.05)[0]]
    assert found == alone


def test_every_vertex_near_the_ground_is_a_point(spatial, solid):
    tilt, ground = Rotation.from_rotvec([0.1, 0.2, 0.3]), Rotation.from_rotvec([0.2, 0, 0.1])
    x = np.zeros((2, 7))
    x[0], x[1] = (0.2, 0.1, 0.5, *tilt.as_quat()[[3, 0, 1, 2]]), (7.0, 3.0, 0, *ground.as_quat()[[3, 0, 1, 2]])
    signs = np.array([[1 if k & 1 << a else -1 for a in range(3)] for k in range(8)])
    n = ground.as_matrix()[:, 2]
    for size, r, own in (((0.5, 0.4, 0.2), 0.05, range(8)), ((0, 0, 0.5), 0.2, (0, 4)), ((0, 0, 0), 0.3, (0,))):
        for first in (True, False):
            make = solid.box if own == range(8) else solid.capsule if len(own) == 2 else solid.sphere
            args = {"r": r, **dict(zip("abc", size, strict=True))} if own == range(8) else {"r": r}
            rows = [make(0, **args), solid.half_space(1)] if first else [solid.half_space(0), make(1, **args)]
            gap, normal, point, key = spatial(rows, x if first else x[::-1]).contacts(margin=9.0)
            corners = x[0, :3] + tilt.apply(signs[list(own)] * size)
            height = (corners - x[1, :3]) @ n
            assert np.abs(gap - (height - r)).max() < 32 * EPS and (np.diff(key) > 0).all()
            assert np.abs(normal - (-n if first else n)).max() < 4 * EPS
            assert np.abs(point - (corners - 0.5 * (height[:, None] + r) * n)).max() < 32 * EPS


def test_a_gap_that_closes_within_the_step_is_kept_and_one_that_does_not_is_not(spatial, solid):
    for speed, kept in ((-49.8, 0), (-50.0, 1), (50.0, 0)):  # gap + dt speed = 0.002, 0, 1
        v = np.zeros((2, 6))
        v[1, 2] = speed
        scene = spatial([solid.sphere(0), solid.sphere(1)], [(0, 0, 0), (0, 0, 1.5)], v)
        assert len(scene.contacts(dt=1e-2)[0]) == kept


def test_a_body_that_turns_closes_the_gap_of_its_far_end(spatial, solid):
    """A blade 2 m long, turning about y, beside a ball: v = omega arm at the point."""
    for omega, kept in ((22.0, 0), (22.4, 1), (-22.4, 0)):  # 0.2 - dt 0.9 omega < 1e-3 from 22.1 on
        v = np.zeros((2, 6))
        v[1, 4] = omega
        scene = spatial([solid.sphere(0, 0.1), solid.capsule(1, 1.0, 0.0)], [(0.3, 0, 0.9), (0, 0, 0)], v)
        assert (len(scene.contacts(dt=1e-2)[0]) > 0) == kept


@pytest.mark.parametrize(("v", "kept"), [
    ((0, 0, 40, 0, 0, 0), 1), ((0, 0, 30, 0, 0, 0), 0), ((9, 0, 0, 0, 0, 0), 0), ((0, 0, 0, 0, -20, 0), 1), (
        (0, 0, 0, 0, -10, 0), 0)])  # fmt: skip
def test_a_half_space_that_rises_or_turns_closes_gaps_too(spatial, solid, v, kept):
    """A ball 0.35 m above it, 2 m from its place."""
    scene = spatial([solid.half_space(0), solid.sphere(1)], [(0, 0, 0), (2, 0, 0.85)], [v, np.zeros(6)])
    assert len(scene.contacts(dt=1e-2)[0]) == kept


def test_shapes_of_one_body_and_of_bodies_that_cannot_move_or_collide_do_not_touch(spatial, solid):
    rows = [
        solid.sphere(0),
        solid.box(0, place=(0.3, 0, 0, 1, 0, 0, 0)),
        solid.sphere(1),
        solid.sphere(2),
        solid.sphere(3),
    ]
    scene = spatial(rows, np.zeros((4, 3)), moves=[1, 0, 0, 1], apart=((3, 0),))
    n = scene.run()
    assert sorted(zip(scene.found.shape_i[:n].tolist(), scene.found.shape_j[:n].tolist(), strict=True)) == [
        (0, 2), (0, 3), (1, 2), (1, 3), (2, 4), (3, 4)]  # fmt: skip


def test_the_number_needed_comes_back_where_there_is_no_room(spatial, solid):
    rows, x = [solid.box(b) for b in range(3)], np.zeros((3, 3))
    wide = spatial(rows, x)
    assert wide.run() == 12
    narrow = spatial(rows, x, room=5)
    assert narrow.run() == 12 and (narrow.found.key == wide.found.key[:5]).all()
    assert spatial(rows, x, pairs=2).run() == -3


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e300])
@pytest.mark.parametrize("column", range(3))
def test_a_place_that_is_not_finite_is_told(spatial, solid, bad, column):
    x = np.zeros((2, 3))
    x[1, column] = bad
    for rows in (
        [solid.sphere(0), solid.sphere(1)],
        [solid.box(0), solid.capsule(1)],
        [solid.sphere(0), solid.half_space(1)],
    ):
        is_plane_far = rows[1].kind == HALF_SPACE and bad == 1e300
        assert spatial(rows, x).run() == NOT_FINITE or is_plane_far
        for k in (column, 3 + column):
            v = np.zeros((2, 6))
            v[1, k] = bad
            assert spatial(rows, np.zeros((2, 3)), v).run() == NOT_FINITE or bad == 1e300


def test_a_shape_is_where_its_body_carries_it(spatial, solid):
    """A ball at (1, 0.5, 0) of a body that is turned by a quarter about z, over the ground: x = -0.5, y = 1."""
    s = np.sqrt(0.5)
    place = (1.0, 0.5, 0, 1, 0, 0, 0)
    gap, _, point, _ = spatial([solid.sphere(0, 0.5, place), solid.half_space(1)],
                               [(2, 3, 1, s, 0, 0, s), (0, 0, 0, 1, 0, 0, 0)]).contacts(margin=9.0)  # fmt: skip
    assert np.abs(gap - 0.5).max() < 8 * EPS and np.abs(point - [1.5, 4.0, 0.25]).max() < 8 * EPS


def test_a_box_far_above_the_ground_does_not_touch_and_one_above_a_ground_that_turns_is_looked_at(spatial, solid):
    for spin, pairs in ((0.0, 0), (1e-9, 1)):
        scene = spatial(
            [solid.half_space(0), solid.box(1)], [(0, 0, 0), (0, 0, 5)], [(0, 0, 0, spin, 0, 0), np.zeros(6)]
        )
        assert len(scene.contacts()[0]) == 0 and scene.scratch.grid.n_pairs == pairs
