"""Factors of mass matrices: they solve, they refuse what is not positive definite, and they scale without rounding."""

import numpy as np
import pytest

from nonsmooth.jit import interpreted
from nonsmooth.numerics.dense import bandwidth, cholesky, cholesky_solve, cholesky_solve_rows, lu, lu_solve

EPS = np.finfo(float).eps


def banded(n, band, seed):
    B = np.tril(np.triu(np.random.default_rng(seed).normal(size=(n, n)), -band))
    return B @ B.T + np.eye(n)


@pytest.mark.parametrize("band", [0, 1, 3, 7])
def test_factor_solves_with_the_rounding_of_the_condition(band):
    M = banded(8, band, band)
    L, x_exact = np.zeros((8, 8)), np.arange(1.0, 9.0)
    assert interpreted(bandwidth)(8, M) == band
    assert interpreted(cholesky)(8, band, M, L)
    x, X = M @ x_exact, np.tile(M @ x_exact, (2, 1))
    interpreted(cholesky_solve)(8, band, L, x)
    interpreted(cholesky_solve_rows)(8, band, L, 2, X)
    bound = 4 * 8 * EPS * np.linalg.cond(M) * np.abs(x_exact).max()  # Higham (2002), theorem 10.4: (3 n + 1) u
    assert np.abs(x - x_exact).max() <= bound
    assert (X == x).all()


def test_masses_times_an_odd_power_of_two_leave_every_bit():
    M, b = banded(6, 5, 1), np.arange(6.0)
    answers = []
    for power in (0, 1, 13, -7):
        L, x = np.zeros((6, 6)), b * 2.0**power
        assert interpreted(cholesky)(6, 5, M * 2.0**power, L)
        interpreted(cholesky_solve)(6, 5, L, x)
        answers.append(x)
    assert all((x == answers[0]).all() for x in answers)


@pytest.mark.parametrize("M", [[[1.0, 2.0], [2.0, 1.0]], [[1.0, 1.0], [1.0, 1.0]], [[np.nan, 0.0], [0.0, 1.0]]])
def test_what_is_not_positive_definite_is_refused(M):
    assert not interpreted(cholesky)(2, 1, np.array(M), np.zeros((2, 2)))


def test_zeros_below_a_pivot_change_nothing():
    """Rows that an elimination step passes over are those that it would leave as they are."""
    rng = np.random.default_rng(3)
    A = rng.normal(size=(9, 9)) * (rng.random((9, 9)) < 0.4) + 4 * np.eye(9)
    factors, order, x = A.copy(), np.zeros(9, dtype=np.int64), np.zeros(9)
    assert interpreted(lu)(9, factors, order)
    interpreted(lu_solve)(9, factors, order, A @ np.ones(9), x)
    assert np.abs(x - 1.0).max() <= 100 * EPS * np.linalg.cond(A)
