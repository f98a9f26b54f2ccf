"""Interior points: large problems, and properties of the method."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import sparse

from benchmarks.problems import normals, packing
from nonsmooth.lcp.interior import solve_by_interior_point
from nonsmooth.lcp.solve import solve_lcp


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 30))
def test_monotone_problems_symmetric_or_not_are_solved(families, seed, n):
    rng = np.random.default_rng(seed)
    A, b = families.p_matrix(rng, n), rng.standard_normal(n)
    z, is_converged, _ = solve_by_interior_point(A, b, np.zeros(n), 1e-10, 60)
    assert is_converged and families.residual(A, b, z) <= 1e-10


@pytest.mark.parametrize("seed", range(3))
def test_redundant_contacts_that_stall_the_sweeps_are_solved(seed):
    A, b = normals(packing(np.random.default_rng(seed), 500, 2))
    assert not solve_lcp(A, b, solver="pgs", tol=1e-8).success
    result = solve_lcp(A, b, solver="interior", tol=1e-8)
    assert result.success and result.iterations <= 60, result.message
    assert solve_lcp(A, b, tol=1e-8).success


def test_sparse_and_dense_take_the_same_path():
    rng = np.random.default_rng(0)
    H = sparse.random_array((40, 60), density=0.1, rng=rng)
    A, b = (H @ H.T).tocsr() + 0.1 * sparse.eye_array(40), rng.standard_normal(40)
    dense, sparse_ = (
        solve_by_interior_point(A.toarray(), b, np.zeros(40), 1e-9, 60),
        solve_by_interior_point(A.tocsr(), b, np.zeros(40), 1e-9, 60),
    )
    assert dense[2] == sparse_[2]
    np.testing.assert_allclose(dense[0], sparse_[0], atol=1e-7 * np.abs(dense[0]).max())


def test_without_a_load_nothing_is_to_be_done():
    z, is_converged, steps = solve_by_interior_point(np.eye(3), np.array([0.0, 1.0, 2.0]), np.ones(3), 1e-10, 60)
    assert is_converged and steps == 0 and not z.any()


def test_an_impossible_problem_ends_without_a_claim():
    with np.errstate(all="ignore"):
        _, is_converged, _ = solve_by_interior_point(-np.eye(2), -np.ones(2), np.zeros(2), 1e-10, 60)
    assert not is_converged
