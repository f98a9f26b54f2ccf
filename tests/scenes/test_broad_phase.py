"""Pairs of boxes that overlap, against all pairs."""

import numpy as np
import pytest

from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import new, view
from nonsmooth.scenes.broad_phase import Grid, find_pairs
from nonsmooth.scenes.detection import Motion
from nonsmooth.scenes.shape_rows import Shapes


@kernel("int64(int64, int64, int64)")
def pairs_of(shapes_at, motion_at, grid_at):
    return find_pairs(view(shapes_at, Shapes), view(motion_at, Motion), view(grid_at, Grid))


def found_and_all(lo, hi, unbounded=(), still=()):
    """The pairs found, in their order, and those of n^2 comparisons."""
    n, d = lo.shape
    shapes, motion = new(Shapes, n_s=n, n_x=3, n_w=0, n_e=0, n_v=0, n_f=0, n_k=0), new(Motion, n_b=n, n_x=3, n=3)
    grid = new(Grid, n_s=n, d=d, n_p=n * n)
    shapes.body[:], motion.moves[:], grid.lo[:], grid.hi[:] = np.arange(n), 1, lo, hi
    grid.level[list(unbounded)] = -1
    motion.still[list(still)] = 1
    m = pairs_of(shapes.address, motion.address, grid.address)
    overlap = ((lo[:, None] <= hi[None]) & (lo[None] <= hi[:, None])).all(-1)
    overlap[list(unbounded)] = overlap[:, list(unbounded)] = True
    for s in unbounded:
        overlap[s, list(unbounded)] = False
    overlap[np.ix_(list(still), list(still))] = False
    return list(zip(grid.i[:m].tolist(), grid.j[:m].tolist(), strict=True)), [
        (i, j) for i, j in np.argwhere(overlap).tolist() if i < j]  # fmt: skip


@pytest.mark.upkeep
@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("sizes", [(1.0, 1.0), (0.5, 2.0), (1e-3, 1e3)])
@pytest.mark.parametrize("at", [0.0, 1e5])
def test_the_pairs_found_are_those_of_all_comparisons(d, sizes, at):
    for seed in range(6):
        rng = np.random.default_rng(seed)
        n = 400
        half = np.exp(rng.uniform(*np.log(sizes), (n, d)))
        centre = at + rng.uniform(-1, 1, (n, d)) * sizes[1] * n ** (1 / d) / 2
        centre[::5] = at + (centre[::5] - at) * 1e-2  # a crowd
        found, every = found_and_all(centre - half, centre + half, unbounded=(3, 99))
        assert found == every and len(every) > 2 * n - 10


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("sizes", [(1.0, 1.0), (0.5, 2.0), (1e-3, 1e3)])
@pytest.mark.parametrize("share", [0.1, 0.5, 0.9, 1.0])
def test_of_bodies_that_are_still_only_the_pairs_with_others_are_found(d, sizes, share):
    for seed in range(3):
        rng = np.random.default_rng(seed)
        n = 300
        half = np.exp(rng.uniform(*np.log(sizes), (n, d)))
        centre = rng.uniform(-1, 1, (n, d)) * sizes[1] * n ** (1 / d) / 2
        still = np.flatnonzero(rng.random(n) < share)
        found, every = found_and_all(centre - half, centre + half, unbounded=(3, 99), still=still)
        assert found == every and (share == 1.0) == (len(every) == 0)


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("unbounded", [(), (3,), (290,)])
def test_of_what_is_still_only_what_is_near_others_is_looked_at(d, unbounded):
    rng = np.random.default_rng(d)
    half, centre = rng.uniform(0.5, 2.0, (300, d)), rng.uniform(-1, 1, (300, d)) * 300 ** (1 / d)
    centre[280:] *= 0.2
    found, every = found_and_all(centre - half, centre + half, unbounded=unbounded, still=range(280))
    assert found == every and len(every) > 20


def test_boxes_that_only_touch_and_points_are_pairs():
    lo = np.array([(0.0, 0.0), (1.0, 0.0), (2.0, 1.0), (2.0, 1.0), (5.0, 5.0)])
    found, every = found_and_all(lo, lo + [[1.0], [1.0], [0.0], [0.0], [0.0]])
    assert found == every == [(0, 1), (1, 2), (1, 3), (2, 3)]


def test_points_alone_have_cells_too():
    assert found_and_all(*2 * [np.array([(0.3, 0.7), (0.3, 0.7), (0.3, 0.9)])])[0] == [(0, 1)]


def test_the_candidates_looked_at_grow_with_the_number_of_bodies():
    """A row of 1e4 equal boxes, each touching the next, beside one that is a thousand times as wide as all of them."""
    n = 10_000
    lo = np.zeros((n, 2))
    lo[:, 0] = np.arange(n)
    hi = lo + 1.0
    lo[0], hi[0] = (-1e6, -1e6), (1e7, -0.5)
    shapes = new(Shapes, n_s=n, n_x=3, n_w=0, n_e=0, n_v=0, n_f=0, n_k=0)
    motion, grid = new(Motion, n_b=n, n_x=3, n=3), new(Grid, n_s=n, d=2, n_p=3 * n)
    shapes.body[:], motion.moves[:], grid.lo[:], grid.hi[:] = np.arange(n), 1, lo, hi
    assert pairs_of(shapes.address, motion.address, grid.address) == n - 2
    assert np.bincount(grid.bucket[1:], minlength=2).max() <= 3  # places in the table are spread
