import numpy as np
from scipy import sparse

from nonsmooth.jit import interpreted
from nonsmooth.lcp.pgs import pgs, pgs_entry, pgs_sparse_entry
from nonsmooth.lcp.result import INVALID, SOLVED


def test_m_matrices_are_solved(families):
    rng = np.random.default_rng(0)
    for n in (1, 5, 30):
        A, b, z = families.m_matrix(rng, n), rng.standard_normal(n), np.zeros(n)
        status, _ = pgs_entry(A, b, z, 1e-10, 5000)
        assert status == SOLVED
        assert families.residual(A, b, z) <= 1e-10


def test_sparse_and_dense_sweeps_agree(families):
    rng = np.random.default_rng(1)
    A = families.m_matrix(rng, 20) * (rng.uniform(size=(20, 20)) < 0.3) + 20 * np.eye(20)
    b, z, z_sparse = rng.standard_normal(20), np.zeros(20), np.zeros(20)
    rows = sparse.csr_matrix(A)
    pgs_entry(A, b, z, 1e-30, 40)
    pgs_sparse_entry(rows.data, rows.indices, rows.indptr, rows.diagonal(), b, z_sparse, 1e-30, 40)
    np.testing.assert_allclose(z_sparse, z, rtol=1e-13, atol=1e-15)


def test_a_diagonal_that_is_not_positive_is_refused():
    A, b, z = np.array([[0.0, 1.0], [1.0, 1.0]]), -np.ones(2), np.zeros(2)
    assert pgs_entry(A, b, z, 1e-10, 10) == (INVALID, 0)
    rows = sparse.csr_matrix(A)
    assert pgs_sparse_entry(rows.data, rows.indices, rows.indptr, rows.diagonal(), b, z, 1e-10, 10) == (INVALID, 0)


def test_the_interpreted_kernel_agrees(families):
    rng = np.random.default_rng(2)
    A, b = families.m_matrix(rng, 5), rng.standard_normal(5)
    z, compiled = np.zeros(5), np.zeros(5)
    assert interpreted(pgs)(5, A, b, z, 1e-10, 500) == pgs_entry(A, b, compiled, 1e-10, 500)
    np.testing.assert_allclose(z, compiled, rtol=1e-13)
