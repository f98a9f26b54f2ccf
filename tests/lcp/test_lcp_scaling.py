import numpy as np
from scipy import sparse

from nonsmooth.jit import interpreted
from nonsmooth.lcp.scaling import EVEN, equilibrate, scaled_problem


def badly_scaled(rng, n):
    return 2.0 ** rng.integers(-40, 40, n), 2.0 ** rng.integers(-40, 40, n), rng.uniform(0.5, 2, (n, n))


def test_rows_and_columns_come_near_one():
    rng = np.random.default_rng(0)
    for n in (1, 4, 12):
        left, right, core = badly_scaled(rng, n)
        scaled, c, _, _ = scaled_problem(left[:, None] * core * right, left * 3.0)
        assert np.abs(scaled).max(axis=0).min() >= 1 / EVEN
        assert np.abs(scaled).max(axis=1).min() >= 1 / EVEN
        assert np.abs(scaled).max() <= 4
        assert 0.5 <= np.abs(c).max() < 1


def test_scaling_rounds_nothing():
    rng = np.random.default_rng(1)
    left, right, core = badly_scaled(rng, 6)
    A, b = left[:, None] * core * right, left * rng.standard_normal(6)
    scaled, c, row, column = scaled_problem(A, b)
    s = np.abs(row * b / np.where(c == 0, 1, c)).max()
    np.testing.assert_array_equal(scaled / row[:, None] / (column / s), A)
    np.testing.assert_array_equal(c * s / row, b)


def test_kernel_numpy_and_sparse_scale_alike():
    rng = np.random.default_rng(2)
    for _ in range(10):
        A = rng.standard_normal((8, 8)) * 10.0 ** rng.integers(-9, 9, (8, 1)) * (rng.uniform(size=(8, 8)) < 0.5)
        b, scales = rng.standard_normal(8), np.empty((4, 10))
        s = interpreted(equilibrate)(8, A, b, scales)
        dense, c, row, column = scaled_problem(A, b)
        np.testing.assert_array_equal(row, scales[0, :8])
        np.testing.assert_array_equal(column, s * scales[1, :8])
        rows, c_sparse, _, _ = scaled_problem(sparse.csr_matrix(A), b)
        np.testing.assert_array_equal(rows.toarray(), dense)
        np.testing.assert_array_equal(c_sparse, c)
