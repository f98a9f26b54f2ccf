from itertools import product

import numpy as np
import pytest

from nonsmooth.errors import InvalidInput
from nonsmooth.jit import interpreted
from nonsmooth.lcp.enumerate import lcp_solutions, tree_entry


def regular_solutions(A, b):
    """All solutions whose active set has a regular matrix, by brute force."""
    n, found = len(b), []
    for active in product([False, True], repeat=n):
        index = np.flatnonzero(active)
        z = np.zeros(n)
        block = A[np.ix_(index, index)]
        if len(index) and np.linalg.matrix_rank(block) < len(index):
            continue
        z[index] = np.linalg.solve(block, -b[index])
        w = A @ z + b
        w[index] = 0
        if z.min() >= -1e-9 and w.min() >= -1e-9 and not any(np.allclose(z, other, atol=1e-7) for other in found):
            found.append(z)
    return found


@pytest.mark.parametrize("seed", range(40))
def test_all_solutions_of_a_random_problem_are_found(seed):
    rng = np.random.default_rng(seed)
    n = 1 + seed % 6
    A, b = rng.standard_normal((n, n)), rng.standard_normal(n)
    solutions = lcp_solutions(A, b)
    expected = regular_solutions(A, b)
    assert len(solutions) == len(expected)
    assert all(solution.is_isolated for solution in solutions)
    for z in expected:
        assert min(np.abs(solution.z - z).max() for solution in solutions) <= 1e-9 * max(1, np.abs(z).max())


@pytest.mark.parametrize("seed", range(30))
def test_every_point_of_a_singular_problem_lies_on_a_face_found(seed):
    """Integer matrices are often singular: each basic solution is listed or lies on a listed face."""
    rng = np.random.default_rng(seed)
    n = 2 + seed % 4
    A, b = rng.integers(-1, 2, (n, n)).astype(float), rng.integers(-1, 2, n).astype(float)
    solutions = lcp_solutions(A, b)
    for solution in solutions:
        assert np.abs(np.minimum(solution.z, A @ solution.z + b)).max() <= 1e-9 * max(1, np.abs(solution.z).max())
    for z in regular_solutions(A, b):
        w = A @ z + b
        assert any(
            (np.abs(z[~s.active]) < 1e-9).all()
            and (np.abs(w[s.active]) < 1e-9).all()
            and (not s.is_isolated or np.allclose(s.z, z, atol=1e-9))
            for s in solutions
        )


def test_a_segment_a_ray_and_a_point_are_told_apart():
    (segment,) = lcp_solutions(np.ones((2, 2)), [-1.0, -1.0])
    assert (segment.dimension, segment.is_bounded) == (1, True)
    np.testing.assert_allclose(np.abs(segment.directions), [[np.sqrt(0.5)] * 2], rtol=1e-12)
    (ray,) = lcp_solutions(np.zeros((2, 2)), [0.0, 1.0])
    assert (ray.dimension, ray.is_bounded) == (1, False)
    (quadrant,) = lcp_solutions(np.zeros((2, 2)), [0.0, 0.0])
    assert (quadrant.dimension, quadrant.is_bounded) == (2, False)
    (point,) = lcp_solutions([[1.0, 2.0], [0.0, 1.0]], [-1.0, -1.0])
    assert point.is_isolated
    assert point.dimension == 0


def test_two_to_the_n_solutions_of_minus_the_identity():
    solutions = lcp_solutions(-np.eye(9), np.ones(9))
    assert {tuple(s.z) for s in solutions} == set(product([0.0, 1.0], repeat=9))


def test_no_diagonal_pivot_is_needed(families):
    """A bimatrix game has a zero diagonal and zero principal blocks; it has an odd number of equilibria."""
    rng = np.random.default_rng(0)
    for _ in range(20):
        A = np.zeros((6, 6))
        A[:3, 3:], A[3:, :3] = rng.uniform(0.1, 1, (2, 3, 3))
        solutions = lcp_solutions(A, -np.ones(6))
        assert len(solutions) % 2 == 1
        assert max(families.residual(A, -np.ones(6), s.z) for s in solutions) <= 1e-12


@pytest.mark.parametrize("scale", [1e-12, 1e12])
def test_scaling_changes_neither_number_nor_kind(scale):
    A, b = np.array([[-1.0, 1.0], [1.0, 1.0]]), np.array([1.0, -1.0])
    reference = lcp_solutions(A, b)
    scaled = lcp_solutions(scale * A, b)
    assert [s.dimension for s in scaled] == [s.dimension for s in reference]
    for one, other in zip(scaled, reference, strict=True):
        np.testing.assert_allclose(scale * one.z, other.z, rtol=1e-12, atol=1e-12)


def test_too_large_a_problem_is_refused_and_the_cure_named():
    with pytest.raises(InvalidInput, match=r"at most 20.*got 21.*solve_lcp"):
        lcp_solutions(np.eye(21), np.ones(21))


def test_the_interpreted_tree_agrees():
    rng = np.random.default_rng(1)
    A, b = rng.standard_normal((5, 5)), np.abs(rng.standard_normal(5))
    outcomes = []
    for tree in (tree_entry, interpreted(tree_entry)):
        found = np.zeros((64, 5), dtype=np.int8)
        count = tree(
            A, b, np.zeros(5, np.int8), np.zeros((6, 5, 7)), np.zeros((6, 2, 5), np.int8), np.zeros(5, np.int8), found
        )
        outcomes.append(found[:count].tolist())
    assert outcomes[0] == outcomes[1]
    assert outcomes[0]
