import numpy as np
import pytest

from nonsmooth.jit import interpreted
from nonsmooth.lcp.lemke import judged_lemke, lemke, lemke_entry, lemke_workspace
from nonsmooth.lcp.result import RAY, SOLVED, judge_solution


def solve(A, b):
    z = np.zeros(len(b))
    status, pivots = lemke_entry(np.ascontiguousarray(A), b, z, *lemke_workspace(len(b)), 100_000)
    return status, pivots, z


def failures(families, n_c, count):
    rng = np.random.default_rng(n_c)
    failed = 0
    for _ in range(count):
        A, b = families.frictional_lcp(rng, n_c)
        status, _, z = solve(A, b)
        failed += status != SOLVED or not families.residual(A, b, z) <= 1e-10
    return failed


@pytest.mark.parametrize("n_c", [8, 16, 32])
def test_lemke_solves_random_frictional_problems(families, n_c):
    assert failures(families, n_c, 30) == 0


@pytest.mark.slow
@pytest.mark.parametrize("n_c", [1, 8, 16, 32])
def test_lemke_solves_a_thousand_random_frictional_problems(families, n_c):
    assert failures(families, n_c, 1000) == 0


def test_the_interpreted_kernel_makes_the_same_pivots(families):
    rng = np.random.default_rng(0)
    for n in (1, 2, 5, 9):
        A, b = families.p_matrix(rng, n), rng.standard_normal(n)
        z, z_interpreted = np.zeros(n), np.zeros(n)
        compiled = lemke_entry(A, b, z, *lemke_workspace(n), 100)
        assert interpreted(lemke)(n, A, b, z_interpreted, *lemke_workspace(n), 100) == compiled
        np.testing.assert_allclose(z_interpreted, z, rtol=1e-12, atol=1e-12 * np.abs(z).max())


def test_arrays_larger_than_the_problem_change_nothing(families):
    rng = np.random.default_rng(1)
    A, b = families.p_matrix(rng, 4), rng.standard_normal(4)
    _, pivots, z = solve(A, b)
    large_A, large_b, large_z = np.full((9, 9), np.nan), np.full(9, np.nan), np.full(9, np.nan)
    large_A[:4, :4], large_b[:4] = A, b
    tableau, scales, basis = lemke_workspace(9)
    outcome = interpreted(lemke)(4, large_A, large_b, large_z, tableau, scales, basis, 100)
    assert outcome == (SOLVED, pivots)
    np.testing.assert_allclose(large_z[:4], z, rtol=1e-12, atol=1e-12)
    assert np.isnan(large_z[4:]).all()


@pytest.mark.parametrize("n", range(2, 13))
def test_lemke_terminates_on_the_exponential_family(families, n):
    A, b = families.murty(n)
    status, _, z = solve(A, b)
    assert status == SOLVED
    np.testing.assert_array_equal(z, [0.0] * (n - 1) + [1.0])


def test_every_strictly_copositive_problem_is_solved(families):
    rng = np.random.default_rng(2)
    for _ in range(50):
        A, b = families.copositive(rng, 8), rng.standard_normal(8)
        status, _, z = solve(A, b)
        assert status == SOLVED
        assert families.residual(A, b, z) <= 1e-12


def test_ties_in_every_ratio_test_do_not_cycle(families):
    """Integer data with equal rows of b: each ratio test is tied, each basis degenerate."""
    rng = np.random.default_rng(3)
    for n in (3, 5, 8):
        for _ in range(30):
            B = rng.integers(-1, 2, (n, n)).astype(float)
            A, b = B @ B.T, -(B @ B.T) @ rng.integers(0, 2, n) * 1.0
            status, pivots, z = solve(A, b)
            assert status == SOLVED
            assert pivots <= 2 * n * n
            assert np.abs(np.minimum(z, A @ z + b)).max() <= 1e-12 * n


def test_a_problem_that_no_z_can_satisfy_ends_on_a_ray():
    assert solve(np.array([[-1.0]]), np.array([-1.0]))[0] == RAY


def test_the_budget_of_pivots_is_kept(families):
    A, b = families.murty(6)
    z = np.zeros(6)
    status, pivots = lemke_entry(A, -b * 0 - 1.0, z, *lemke_workspace(6), 1)
    assert pivots == 1
    assert status not in (SOLVED, RAY)


def test_accuracy_of_an_ill_conditioned_problem_is_that_of_one_refined_solve(families):
    """Hilbert matrix with a known active set: the residual is a few roundings however bad the condition (1e13)."""
    n = 10
    A = 1.0 / (np.arange(n)[:, None] + np.arange(n) + 1)
    b = -A @ np.ones(n)
    status, _, z = solve(A, b)
    assert status == SOLVED
    assert families.residual(A, b, z) <= 2e-16 * n * (A @ z).max() / np.abs(b).max() * 4


@pytest.mark.parametrize("seed", range(10))
def test_towers_with_masses_over_six_decades_do_not_mislead_the_pivots(seed):
    """Redundant contacts leave zeros in the tableau that rounding fills."""
    from benchmarks.problems import tower
    from nonsmooth.contact.blocks.faceted_lcp import faceted
    from nonsmooth.contact.blocks.problem import check_problem, scale_problem

    problem, _ = scale_problem(check_problem(*tower(np.random.default_rng([seed, 40, 2]), 40, 2)))
    A, b, impulses = faceted(problem, 2)
    status, _, z = solve(A, b)
    assert status == SOLVED and problem.error(impulses @ z) <= 1e-8


@pytest.mark.parametrize("n", [1, 3, 8])
def test_solving_and_judging_in_one_call_is_the_same_as_one_after_the_other(n):
    rng = np.random.default_rng(n)
    for _ in range(20):
        A, b = rng.normal(size=(n, n)) + n * np.eye(n), rng.normal(size=n)
        z, w, apart_z, apart_w = np.empty((4, n))
        apart = (*lemke_entry(A, b, apart_z, *lemke_workspace(n), 100), judge_solution(A, b, apart_z, apart_w))
        assert judged_lemke(A, b, z, w, *lemke_workspace(n), 100) == apart
        assert (z == apart_z).all() and (w == apart_w).all()
        by_source = interpreted(judged_lemke)(A, b, z, w, *lemke_workspace(n), 100)
        assert by_source == apart and (z == apart_z).all() and (w == apart_w).all()
