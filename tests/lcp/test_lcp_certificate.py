import numpy as np
import pytest

from nonsmooth.lcp.certificate import infeasibility_certificate, is_certificate
from nonsmooth.lcp.result import LCPStatus
from nonsmooth.lcp.solve import solve_lcp

INFEASIBLE = {
    "both rows push down": ([[-1.0, 0.0], [0.0, -1.0]], [-1.0, 2.0]),
    "two rows contradict": ([[1.0, -2.0, 0.0], [-1.0, 2.0, -1.0], [3.0, 1.0, 1.0]], [-1.0, 0.5, 2.0]),
    "zero row": ([[0.0, 0.0], [1.0, 1.0]], [-1.0, -1.0]),
}


@pytest.mark.parametrize("case", INFEASIBLE)
@pytest.mark.parametrize("scale", [1.0, 1e12, 1e-12])
def test_infeasible_problems_are_called_so_with_a_proof(case, scale):
    A, b = np.array(INFEASIBLE[case][0]) * scale, np.array(INFEASIBLE[case][1])
    result = solve_lcp(A, b)
    assert result.status == LCPStatus.INFEASIBLE
    y = result.certificate
    assert (y >= 0).all()
    assert (A.T @ y <= 1e-15 * (np.abs(A).T @ y)).all()
    assert b @ y < 0


def test_a_feasible_problem_without_solution_is_not_called_infeasible():
    """w = (z_2 - z_1 - 1, 1): w_2 = 1 forces z_2 = 0, then w_1 < 0; yet z = (0, 2) is feasible."""
    A, b = np.array([[-1.0, 1.0], [0.0, 0.0]]), np.array([-1.0, 1.0])
    assert (A @ [0.0, 2.0] + b >= 0).all()
    result = solve_lcp(A, b)
    assert not result.success
    assert result.status != LCPStatus.INFEASIBLE
    assert result.certificate is None


def test_solvable_problems_have_no_certificate(families):
    rng = np.random.default_rng(0)
    for n in (1, 4, 9):
        assert infeasibility_certificate(families.p_matrix(rng, n), rng.standard_normal(n)) is None


def test_a_wrong_certificate_is_not_believed():
    A, b = np.array([[-1.0]]), np.array([-1.0])
    assert is_certificate(A, b, np.array([1.0]))
    assert not is_certificate(A, b, np.array([-1.0]))
    assert not is_certificate(-A, b, np.array([1.0]))
    assert not is_certificate(A, -b, np.array([1.0]))
    assert not is_certificate(A, b, np.array([0.0]))


def test_a_free_column_needs_an_equality():
    A, b = np.array([[0.0, 1.0], [0.0, 1.0]]), np.array([1.0, -1.0])
    free = np.array([True, False])
    y = infeasibility_certificate(A, b, free)  # w_1 = z_2 + 1 = 0 with z_2 >= 0
    assert y is not None
    assert is_certificate(A, b, y, free)
    assert not is_certificate(np.array([[-1.0, -1.0], [0.0, -1.0]]), b, np.array([-1.0, 0.0]), free)
