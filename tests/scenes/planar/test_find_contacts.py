"""Which contacts are kept, in which order, and what happens where there is no room."""

import numpy as np
import pytest

from nonsmooth.numerics.rounding import EPS
from nonsmooth.scenes.detection import NOT_FINITE, SHAPE_BITS, key_of
from nonsmooth.scenes.shape_rows import HALF_PLANE


def heap(planar, shape, n=60, seed=0, **options):
    """Shapes of all kinds, thrown about in a corner, with velocities."""
    rng = np.random.default_rng(seed)
    kinds = [shape.disc, shape.capsule, shape.box, lambda b: shape.box(b, 0.3, 0.2, 0.1)]
    rows = [kinds[b % 4](b) for b in range(n)] + [shape.half_plane(n), shape.half_plane(n, (0, 0, -1.2))]
    x = np.zeros((n + 1, 3))
    x[:n] = rng.uniform([-2, 0.2, -3], [5, 6, 3], (n, 3))
    v = rng.uniform(-3, 3, (n + 1, 3))
    v[n] = 0
    moves = np.ones(n + 1, dtype=int)
    moves[n] = 0
    return planar(rows, x, v, moves, room=20 * n, pairs=40 * n, **options)


@pytest.mark.parametrize("margin", [0.0, 1e-2, 0.5])
def test_the_interpreter_finds_the_bits_of_compiled_code(planar, shape, margin):
    one, two = heap(planar, shape), heap(planar, shape)
    n = one.run(margin=margin, dt=1e-2)
    assert n == two.run(margin=margin, dt=1e-2, is_compiled=False) and n > 30
    assert one.found.words.tobytes() == two.found.words.tobytes()


def test_contacts_come_in_the_order_of_their_keys_and_each_key_once(planar, shape):
    scene = heap(planar, shape)
    n = scene.run(margin=0.1)
    f = scene.found
    assert (np.diff(f.key[:n]) > 0).all() and (f.shape_i[:n] < f.shape_j[:n]).all()
    assert (f.key[:n] >> (63 - 2 * SHAPE_BITS) == (f.shape_i[:n] << SHAPE_BITS) + f.shape_j[:n]).all()


def test_the_largest_key_is_a_number_of_63_bits():
    top = 2**SHAPE_BITS - 1
    assert key_of(top, top, 2**19 - 1) == 2**63 - 1


def test_what_is_found_does_not_depend_on_the_steps_before(planar, shape):
    one, two = heap(planar, shape, seed=1), heap(planar, shape, seed=2)
    one.run()
    one.motion.x[:], one.motion.v[:] = two.motion.x, two.motion.v
    n = one.run(margin=0.1)
    assert n == two.run(margin=0.1) and one.found.key[:n].tolist() == two.found.key[:n].tolist()


def test_a_gap_that_closes_within_the_step_is_kept_and_one_that_does_not_is_not(planar, shape):
    margin, dt, gap = 1e-3, 1e-2, 0.5
    for speed, kept in ((-49.8, 0), (-50.0, 1), (50.0, 0)):  # gap + dt speed = 0.002, 0, 1
        scene = planar([shape.disc(0), shape.disc(1)], [(0, 0, 0), (1 + gap, 0, 0)], [(0, 0, 0), (speed, 0, 0)])
        assert len(scene.contacts(margin=margin, dt=dt)[0]) == kept


def test_a_body_that_turns_closes_the_gap_of_its_far_end(planar, shape):
    """A blade 2 m long above a disc: v = omega arm at the point."""
    rows, x = [shape.disc(0, 0.1), shape.capsule(1, 1.0, 0.0)], [(0.9, 0, 0), (0, 0.3, 0)]
    for omega, kept in ((-22.0, 0), (-22.4, 1), (22.4, 0)):  # 0.2 - dt 0.9 omega < 1e-3 from 22.1 on
        scene = planar(rows, x, [(0, 0, 0), (0, 0, omega)])
        assert (len(scene.contacts(margin=1e-3, dt=1e-2)[0]) > 0) == kept


def test_the_spin_of_a_disc_closes_nothing(planar, shape):
    scene = planar([shape.disc(0), shape.disc(1)], [(0, 0, 0), (1.01, 0, 0)], [(0, 0, 0), (0, 0, 1e6)])
    assert len(scene.contacts(margin=1e-3)[0]) == 0 and scene.scratch.grid.n_pairs == 0


def test_shapes_of_one_body_and_of_bodies_that_cannot_move_do_not_touch(planar, shape):
    rows = [shape.disc(0), shape.disc(0, place=(0.3, 0, 0)), shape.disc(1), shape.disc(2)]
    scene = planar(rows, np.zeros((3, 3)), moves=[1, 0, 0])
    assert sorted(set(zip(*(scene.found.shape_i[: scene.run()], scene.found.shape_j[: scene.run()]), strict=True))) == [
        (0, 2), (0, 3), (1, 2), (1, 3)]  # fmt: skip


def test_bodies_that_are_said_not_to_collide_do_not(planar, shape):
    rows, x = [shape.disc(b) for b in range(4)], np.zeros((4, 3))
    every = {(a, b) for a in range(4) for b in range(a + 1, 4)}
    for apart in ([], [(2, 0)], [(0, 1), (3, 2)], sorted(every)):
        scene = planar(rows, x, apart=tuple(apart))
        n = scene.run()
        assert set(zip(scene.found.shape_i[:n].tolist(), scene.found.shape_j[:n].tolist(), strict=True)) == every - {
            (min(p), max(p)) for p in apart}  # fmt: skip


def test_the_number_needed_comes_back_where_there_is_no_room(planar, shape):
    rows, x = [shape.box(b) for b in range(4)], np.zeros((4, 3))
    wide = planar(rows, x)
    assert wide.run() == 12
    narrow = planar(rows, x, room=5)
    assert narrow.run() == 12 and (narrow.found.key == wide.found.key[:5]).all()
    assert planar(rows, x, pairs=3).run() == -6


@pytest.mark.parametrize(("bad", "column"), [
    (1e300, 0), (-1e300, 1), *((bad, column) for bad in (np.nan, np.inf, -np.inf) for column in range(3))])  # fmt: skip
def test_a_place_that_is_not_finite_is_told(planar, shape, bad, column):
    x = np.zeros((2, 3))
    x[1, column] = bad
    for rows in ([shape.disc(0), shape.disc(1)], [shape.box(0), shape.box(1)], [shape.disc(0), shape.half_plane(1)]):
        is_plane_far = rows[1].kind == HALF_PLANE and abs(bad) == 1e300
        for far in (planar(rows, x), planar(rows, np.zeros((2, 3)), x)):
            assert far.run() == NOT_FINITE or is_plane_far


@pytest.mark.parametrize(
    ("v", "kept"), [((0, 40, 0), 1), ((0, 30, 0), 0), ((9, 0, 0), 0), ((0, 0, 20), 1), ((0, 0, 10), 0)]
)
def test_a_half_plane_that_rises_or_turns_closes_gaps_too(planar, shape, v, kept):
    """A disc 0.35 m above it, 2 m from its place."""
    scene = planar([shape.half_plane(0), shape.disc(1)], [(0, 0, 0), (2, 0.85, 0)], [v, (0, 0, 0)])
    assert len(scene.contacts(margin=1e-3, dt=1e-2)[0]) == kept


def test_a_shape_is_where_its_body_carries_it(planar, shape):
    """A disc at (1, 0.5) of a body that is turned by a quarter, over the ground: x = -0.5, y = 1."""
    scene = planar([shape.disc(0, 0.5, (1.0, 0.5, 0.3)), shape.half_plane(1)], [(2, 3, np.pi / 2), (0, 0, 0)])
    gap, _, point, _ = scene.contacts(margin=9.0)
    assert np.abs(gap - 3.5).max() < 8 * EPS and np.abs(point - [1.5, 1.75]).max() < 8 * EPS
