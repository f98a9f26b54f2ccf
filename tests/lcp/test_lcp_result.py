import math

import numpy as np
import pytest

from nonsmooth.jit import interpreted
from nonsmooth.lcp.result import judge_solution, judge_sparse, lcp_residual, natural_scale, natural_scales


def measure(A, b, z):
    A, b, z = np.array(A, float), np.array(b, float), np.array(z, float)
    w = np.empty_like(b)
    value = judge_solution(A, b, z, w)
    assert interpreted(lcp_residual)(len(b), A, b, z) == value or math.isnan(value)
    return value


def test_the_residual_is_zero_at_a_solution_only():
    A, b = [[2.0, 1.0], [1.0, 2.0]], [-4.0, 1.0]
    assert measure(A, b, [2.0, 0.0]) == 0.0
    assert measure(A, b, [0.0, 0.0]) == 1.0  # w_1 = -4 = -max |b|
    assert measure(A, b, [2.0, 0.5]) == 0.25  # min(2 * 0.5, 4) and min(2 * 2, 0.5): 1 of 4
    assert measure(A, b, [2.0, -0.5]) == 0.25  # z_2 < 0 counts as |d z|


def test_the_residual_has_no_unit():
    rng = np.random.default_rng(0)
    A, b, z = rng.standard_normal((4, 4)), rng.standard_normal(4), rng.uniform(size=4)
    reference = measure(A, b, z)
    for power in (-40, 40):
        assert measure(A * 2.0**power, b, z * 2.0**-power) == reference
        assert measure(A, b * 2.0**power, z * 2.0**power) == reference


def test_a_zero_diagonal_is_replaced_by_the_norm_of_the_row():
    assert measure([[0.0, 3.0], [4.0, 0.0]], [10.0, 10.0], [1.0, 0.0]) == 0.3
    assert measure([[0.0, 0.0], [0.0, 5.0]], [10.0, 10.0], [1.0, 0.0]) == 0.5


def test_without_b_only_an_exact_solution_counts():
    assert measure([[1.0]], [0.0], [0.0]) == 0.0
    assert measure([[1.0]], [0.0], [1e-300]) == math.inf


def test_nan_is_never_a_small_residual():
    assert math.isnan(measure([[1.0, 0.0], [0.0, 1.0]], [1.0, 1.0], [math.nan, 0.0]))
    assert math.isnan(measure([[1.0, 0.0], [0.0, 1.0]], [1.0, 1.0], [0.0, math.nan]))


def test_dense_and_sparse_measures_agree():
    from scipy import sparse

    rng = np.random.default_rng(1)
    A = rng.standard_normal((7, 7)) * (rng.uniform(size=(7, 7)) < 0.4)
    A[2] = 0.0
    b, z, w, w_sparse = rng.standard_normal(7), rng.uniform(size=7), np.empty(7), np.empty(7)
    np.testing.assert_allclose(
        judge_sparse(sparse.csr_matrix(A), b, z, w_sparse), judge_solution(A, b, z, w), rtol=1e-14
    )
    np.testing.assert_allclose(w_sparse, w, rtol=1e-14, atol=1e-15)
    expected = [interpreted(natural_scale)(7, A, i) for i in range(7)]
    for d in (natural_scales(A), natural_scales(sparse.csr_matrix(A))):
        np.testing.assert_allclose(d, expected, rtol=1e-15)


@pytest.mark.parametrize("place", range(3))
def test_a_residual_that_is_not_a_number_anywhere_is_none(place):
    """Rows after the one that is NaN must not make it a number again; 0 times NaN counts."""
    A, b, z = np.eye(3), np.ones(3), np.zeros(3)
    A[place, 1] = np.nan
    assert np.isnan(judge_solution(A, b, z, np.empty(3)))
    b[place] = np.inf
    assert np.isnan(judge_solution(np.eye(3), b, z, np.empty(3)))
    z[place] = np.nan
    assert np.isnan(judge_solution(np.eye(3), np.ones(3), z, np.empty(3)))


@pytest.mark.parametrize("size", [1e-12, 1e-6, 1e-3])
def test_a_row_is_judged_by_its_own_summands_too(size):
    """The second row is wrong by all of itself, however small it is beside the first."""
    assert measure([[1.0, 0.0], [0.0, -1.0]], [-1.0, -size], [1.0, 0.0]) == 1.0
    assert measure([[1.0, 0.0], [size, 1.0]], [-1.0, -size], [1.0, 0.0]) == 0.0
    assert measure([[1.0, 0.0], [size, 1.0]], [-1.0, -1.5 * size], [1.0, 0.0]) == pytest.approx(0.2)  # 0.5 of 2.5


def test_powers_of_two_in_rows_leave_a_residual_that_the_summands_decide():
    rng = np.random.default_rng(5)
    A, b, z = rng.standard_normal((5, 5)), rng.standard_normal(5), rng.uniform(size=5)
    alone = [measure([[A[i, i]]], [b[i] + A[i] @ z - A[i, i] * z[i]], [z[i]]) for i in range(5)]
    rows = 2.0 ** np.array([-60, -20, 0, 30, 50])
    assert measure(rows[:, None] * A, rows * b, z) > 0.1 * min(alone) > 0.0


def test_a_row_of_nothing_but_rounding_is_judged_by_the_rounding_of_the_largest_b():
    """The friction bound mu la_N of an open contact is 0; solvers leave it at rounding, or at the square of that."""
    for left in (1e-31, 1e-27):
        assert measure([[1.0, 0.0], [0.0, 1.0]], [-1.0, 0.0], [1.0, left]) < 1e-10
    assert measure([[1.0, 0.0], [0.0, 1.0]], [-1.0, 0.0], [1.0, 1e-20]) > 1e-10
