"""Time of single complementarity and contact problems, by size and solver."""

import numpy as np
import pytest

import nonsmooth as ns


def positive_definite(n):
    """A and b of an LCP with one solution."""
    rng = np.random.default_rng(0)
    B = rng.standard_normal((n, n))
    return B @ B.T / n + np.eye(n), rng.standard_normal(n)


@pytest.mark.parametrize("n", [4, 20, 100])
@pytest.mark.parametrize("solver", ["lemke", "pivoting", "newton", "pgs", "qp"])
def test_linear_complementarity(benchmark, solver, n):
    A, b = positive_definite(n)
    result = benchmark(ns.solve_lcp, A, b, solver=solver, tol=1e-8)
    assert result.success


@pytest.mark.parametrize("n_c", [1, 4, 30])
@pytest.mark.parametrize("dim", [2, 3])
def test_contacts_with_friction(benchmark, dim, n_c):
    G, c = positive_definite(dim * n_c)
    result = benchmark(ns.solve_contact, G, c, np.full(n_c, 0.5), dim)
    assert result.success
