import numpy as np
import pytest

from nonsmooth.jit import interpreted
from nonsmooth.lcp.pivoting import PIVOTING_PATIENCE, pivoting, pivoting_entry, pivoting_workspace
from nonsmooth.lcp.result import SOLVED


def solve(A, b, guess=None, most=10_000):
    z = np.zeros(len(b)) if guess is None else guess.copy()
    status, iterations = pivoting_entry(A, b, z, *pivoting_workspace(len(b)), most)
    return status, iterations, z


@pytest.mark.parametrize("n", [1, 3, 10, 40])
def test_p_matrices_are_solved(families, n):
    rng = np.random.default_rng(n)
    for _ in range(20):
        A, b = families.p_matrix(rng, n), rng.standard_normal(n)
        status, _, z = solve(A, b)
        assert status == SOLVED
        assert families.residual(A, b, z) <= 1e-12


@pytest.mark.parametrize("n", range(2, 11))
def test_the_safeguard_terminates_on_the_exponential_family(families, n):
    A, b = families.murty(n)
    status, _, z = solve(A, b)
    assert status == SOLVED
    np.testing.assert_array_equal(z, [0.0] * (n - 1) + [1.0])


def test_the_safeguard_ends_a_cycle_of_block_steps():
    """From the active set {0, 1} block steps alone go round {0, 1}, {1, 2}, {2, 0} for ever."""
    A = np.array([[1.0, 2.0, 0.0], [0.0, 1.0, 2.0], [2.0, 0.0, 1.0]])
    status, iterations, z = solve(A, -np.ones(3), guess=np.array([1.0, 0.0, 0.0]))
    assert status == SOLVED
    assert iterations > PIVOTING_PATIENCE
    np.testing.assert_allclose(z, np.full(3, 1 / 3), rtol=1e-15)


def test_a_guess_with_the_right_active_set_needs_one_iteration(families):
    rng = np.random.default_rng(5)
    A, b = families.p_matrix(rng, 30), rng.standard_normal(30)
    _, cold, z = solve(A, b)
    status, warm, _ = solve(A, b + 1e-9 * rng.standard_normal(30), z)
    assert status == SOLVED
    assert warm == 1 < cold


def test_the_interpreted_kernel_agrees(families):
    rng = np.random.default_rng(6)
    A, b = families.p_matrix(rng, 6), rng.standard_normal(6)
    z = np.zeros(6)
    outcome = interpreted(pivoting)(6, A, b, z, *pivoting_workspace(6), 100)
    status, iterations, compiled = solve(A, b)
    assert outcome == (status, iterations)
    np.testing.assert_allclose(z, compiled, rtol=1e-12, atol=1e-14)
