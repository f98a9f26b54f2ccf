import numpy as np
import pytest

from nonsmooth.errors import InvalidInput
from nonsmooth.lcp.qp import why_not_a_qp
from nonsmooth.lcp.solve import solve_lcp
from nonsmooth.numerics.quadratic_program import solver_names


@pytest.mark.parametrize("name", ["qp", *solver_names()])
def test_every_installed_solver_solves_positive_definite_problems(families, name):
    rng = np.random.default_rng(0)
    for scale in (1.0, 1e12, 1e-12):
        B = rng.standard_normal((8, 8))
        A, b = scale * (B @ B.T + np.eye(8)), rng.standard_normal(8)
        result = solve_lcp(A, b, solver=name)
        assert result.success, result.message
        assert families.residual(A, b, result.z) <= 1e-10


def test_osqp_solves_a_rank_deficient_problem(families):
    rng = np.random.default_rng(1)
    W = rng.standard_normal((12, 4))
    A, b = W @ W.T, W @ rng.standard_normal(4)
    result = solve_lcp(A, b, solver="qp", tol=1e-8)
    assert result.success, result.message


def test_an_unsymmetric_matrix_is_refused_with_the_reason():
    with pytest.raises(InvalidInput, match=r"not symmetric.*lemke"):
        solve_lcp([[1.0, 0.5], [0.0, 1.0]], [-1.0, -1.0], solver="osqp")


def test_an_indefinite_matrix_is_refused_with_its_eigenvalue():
    with pytest.raises(InvalidInput, match=r"not positive semidefinite.*-1\.0e\+00"):
        solve_lcp([[0.0, 1.0], [1.0, 0.0]], [-1.0, -1.0], solver="qp")


def test_a_gram_matrix_with_rounding_is_a_qp():
    W = np.random.default_rng(2).standard_normal((20, 5))
    assert why_not_a_qp(W @ W.T) == ""
