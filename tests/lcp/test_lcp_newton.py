import numpy as np
import pytest
from scipy import sparse

from nonsmooth.lcp.newton import solve_by_semismooth_newton


@pytest.mark.parametrize("n", [1, 6, 40])
def test_p_matrices_are_solved_from_far_away(families, n):
    rng = np.random.default_rng(n)
    for start in (0.0, 1e3):
        A, b = families.p_matrix(rng, n), rng.standard_normal(n)
        z, is_converged, _ = solve_by_semismooth_newton(A, b, np.full(n, start), np.zeros(n, dtype=bool), 1e-10, 100)
        assert is_converged
        assert families.residual(A, b, z) <= 1e-12


def test_sparse_and_dense_take_the_same_path(families):
    rng = np.random.default_rng(3)
    A, b, free = families.p_matrix(rng, 15), rng.standard_normal(15), np.zeros(15, dtype=bool)
    z, _, iterations = solve_by_semismooth_newton(A, b, np.zeros(15), free, 1e-10, 100)
    z_sparse, _, iterations_sparse = solve_by_semismooth_newton(sparse.csr_matrix(A), b, np.zeros(15), free, 1e-10, 100)
    assert iterations_sparse == iterations
    np.testing.assert_allclose(z_sparse, z, rtol=1e-10, atol=1e-12)


def test_all_rows_free_is_one_linear_solve():
    A, b = np.array([[0.0, 2.0], [-1.0, 1.0]]), np.array([2.0, 3.0])
    z, is_converged, _ = solve_by_semismooth_newton(A, b, np.zeros(2), np.ones(2, dtype=bool), 1e-12, 50)
    assert is_converged
    np.testing.assert_allclose(z, [2.0, -1.0], rtol=1e-14)


def test_a_problem_without_solution_is_not_called_solved():
    _, is_converged, _ = solve_by_semismooth_newton(
        np.array([[-1.0]]), np.array([-1.0]), np.zeros(1), np.zeros(1, dtype=bool), 1e-10, 50
    )
    assert not is_converged
