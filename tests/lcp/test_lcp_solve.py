import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import sparse

from nonsmooth.errors import InvalidInput, UnknownName
from nonsmooth.lcp.enumerate import lcp_solutions
from nonsmooth.lcp.mixed import solve_mlcp
from nonsmooth.lcp.result import LCPStatus
from nonsmooth.lcp.solve import SOLVERS, solve_lcp

GENERAL = [
    "auto",
    "lemke",
    "pivoting",
    "newton",
    "interior",
    "enumeration",
]  # need no symmetry and no diagonal dominance
NAMES = ["CPS_1", "CPS_2", "CPS_3", "CPS_4", "Pang_isolated_sol", "deudeu", "exp_murty", "mmc", "ortiz", "trivial"]
seeds = st.integers(0, 2**32 - 1)
few = settings(max_examples=25, derandomize=True, deadline=None)


@pytest.mark.parametrize("name", NAMES)
def test_published_problems_are_solved(families, name):
    problem = families.load("lcp")[f"lcp_{name}"]
    A, b = problem["M"].astype(float), problem["q"].astype(float)
    result = solve_lcp(A, b)
    assert result.status == LCPStatus.SOLVED, result.message
    assert families.residual(A, b, result.z) <= 1e-10
    assert result.solver in result.message


@pytest.mark.upkeep
@few
@given(seeds, st.integers(1, 7), st.sampled_from([1.0, 1e12, 1e-12]))
def test_every_general_solver_finds_the_one_solution_of_a_p_matrix(seed, n, scale):
    rng = np.random.default_rng(seed)
    B, C = rng.standard_normal((2, n, n))
    A, b = B @ B.T / n + 0.1 * np.eye(n) + (C - C.T), rng.standard_normal(n)
    (only,) = lcp_solutions(A, b)
    for solver in GENERAL:
        result = solve_lcp(scale * A, b, solver)
        assert result.success, result.message
        np.testing.assert_allclose(scale * result.z, only.z, rtol=1e-8, atol=1e-9 * max(1, np.abs(only.z).max()))


@few
@given(seeds, st.integers(1, 12))
def test_every_solver_finds_the_solution_of_a_symmetric_m_matrix(seed, n):
    rng = np.random.default_rng(seed)
    A = -rng.uniform(0, 1, (n, n))
    A = A + A.T
    np.fill_diagonal(A, 0)
    np.fill_diagonal(A, 1.2 * np.abs(A).sum(axis=1) + 0.1)
    b = rng.standard_normal(n)
    reference = solve_lcp(A, b, "lemke")
    for solver in SOLVERS:
        result = solve_lcp(A, b, solver)
        assert result.success, result.message
        np.testing.assert_allclose(result.z, reference.z, rtol=1e-7, atol=1e-8)


@few
@given(seeds, st.integers(2, 10), st.integers(1, 9))
def test_rank_deficient_semidefinite_problems_are_solved(seed, n, rank):
    rng = np.random.default_rng(seed)
    W = rng.standard_normal((n, min(rank, n)))
    A, b = W @ W.T, W @ rng.standard_normal(min(rank, n))
    result = solve_lcp(A, b)
    assert result.success, result.message
    assert (result.z >= 0).all()


@few
@given(seeds, st.integers(1, 6))
def test_auto_agrees_with_enumeration(seed, n):
    """It finds one of the solutions, and fails only where there is none."""
    rng = np.random.default_rng(seed)
    A, b = rng.standard_normal((n, n)), rng.standard_normal(n)
    solutions = lcp_solutions(A, b)
    result = solve_lcp(A, b)
    assert result.success == bool(solutions)
    if solutions:
        assert min(np.abs(s.z - result.z).max() for s in solutions) <= 1e-7 * max(1, np.abs(result.z).max())
    elif result.status == LCPStatus.INFEASIBLE:
        assert b @ result.certificate < 0


@few
@given(seeds, st.integers(2, 8))
def test_permutation_and_diagonal_scaling_carry_the_solution_along(seed, n):
    rng = np.random.default_rng(seed)
    B, C = rng.standard_normal((2, n, n))
    A, b = B @ B.T / n + 0.1 * np.eye(n) + (C - C.T), rng.standard_normal(n)
    z = solve_lcp(A, b).z
    order = rng.permutation(n)
    R, E = 10.0 ** rng.integers(-3, 4, (2, n))
    other = solve_lcp((R[:, None] * A * E)[np.ix_(order, order)], (R * b)[order], tol=1e-8)
    np.testing.assert_allclose((E[order] * other.z), z[order], rtol=1e-7, atol=1e-9 * max(1, np.abs(z).max()))


@few
@given(seeds, st.integers(1, 8))
def test_integer_problems_with_ties_and_zero_rows_never_yield_a_wrong_answer(seed, n):
    rng = np.random.default_rng(seed)
    A, b = rng.integers(-1, 2, (n, n)).astype(float), rng.integers(-1, 2, n).astype(float)
    result = solve_lcp(A, b)
    w = A @ result.z + b
    np.testing.assert_allclose(result.w, w, rtol=1e-12, atol=1e-14 * n * max(1, np.abs(result.z).max()))
    if result.success:
        assert (result.z >= 0).all()
        assert (w >= -1e-10).all()
        assert np.minimum(result.z, w).max() <= 1e-10
    if n <= 6:
        assert result.success == bool(lcp_solutions(A, b))


@pytest.mark.parametrize("scale_A", [1e-12, 1.0, 1e12])
@pytest.mark.parametrize("scale_b", [1e-12, 1.0, 1e12])
def test_scaled_problems_take_the_same_path(families, scale_A, scale_b):
    rng = np.random.default_rng(0)
    A, b = families.frictional_lcp(rng, 4)
    reference = solve_lcp(A, b)
    result = solve_lcp(scale_A * A, scale_b * b)
    assert (result.success, result.solver, result.iterations) == (True, reference.solver, reference.iterations)
    np.testing.assert_allclose(result.z * scale_A / scale_b, reference.z, rtol=1e-9, atol=1e-10)


@pytest.mark.parametrize("n", range(2, 11))
@pytest.mark.parametrize("solver", ["lemke", "pivoting", "newton"])
def test_the_exponential_family_terminates(families, n, solver):
    A, b = families.murty(n)
    np.testing.assert_allclose(solve_lcp(A, b, solver).z, [0.0] * (n - 1) + [1.0], atol=1e-12)


def test_a_good_guess_saves_iterations(families):
    rng = np.random.default_rng(2)
    A, b = families.p_matrix(rng, 40), rng.standard_normal(40)
    cold = solve_lcp(A, b)
    warm = solve_lcp(A, b, guess=cold.z)
    assert (warm.solver, warm.iterations) == ("pivoting", 1)
    np.testing.assert_allclose(warm.z, cold.z, rtol=1e-12, atol=1e-13)


def test_a_bad_guess_does_no_harm(families):
    rng = np.random.default_rng(3)
    for _ in range(10):
        A, b = families.frictional_lcp(rng, 6)
        assert solve_lcp(A, b, guess=rng.uniform(0, 100, 18)).success


def test_a_large_sparse_obstacle_problem_is_solved_without_a_dense_matrix():
    """A string pressed on a floor: -z'' = -1 with z >= 0 off the ends held at height 1."""
    n = 5000
    A = sparse.diags([-np.ones(n - 1), 2 * np.ones(n), -np.ones(n - 1)], [-1, 0, 1], format="csc")
    b = np.full(n, 4e-7)
    b[[0, -1]] -= 1.0
    result = solve_lcp(A, b)
    assert result.success, result.message
    w = A @ result.z + b
    assert np.abs(np.minimum(2 * result.z, w)).max() <= 1e-10 * np.abs(b).max()
    assert result.z[0] > 0.99
    assert result.z[n // 2] == 0


def test_small_sparse_matrices_are_accepted():
    A = sparse.csr_matrix([[2.0, 0.0], [0.0, 1.0]])
    assert solve_lcp(A, [-1.0, 1.0]).z.tolist() == [0.5, 0.0]


def test_lemke_alone_reports_its_ray_and_auto_goes_on():
    A = np.array([[0, 0, 10, 20], [0, 0, 30, 15], [10, 20, 0, 0], [30, 15, 0, 0.0]])
    assert solve_lcp(A, -np.ones(4), "lemke").status == LCPStatus.RAY
    result = solve_lcp(A, -np.ones(4))
    assert result.success
    assert "lemke: secondary ray" in result.message


def test_a_result_never_claims_more_than_its_residual():
    result = solve_lcp(np.diag([1.0, -1.0]), [-1.0, -1.0])
    assert not result.success
    assert result.residual >= 1.0


def test_an_empty_problem_returns_at_once():
    result = solve_lcp(np.zeros((0, 0)), np.zeros(0))
    assert result.success
    assert result.z.shape == (0,)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([[1.0, 2.0]], [1.0]), r"A must be a square matrix; got shape \(1, 2\)"),
        ((np.eye(2), [1.0]), "b must have 2 entries; got 1"),
        (([[np.nan]], [1.0]), r"A must be finite; A\[0, 0\] is nan"),
        (([[1.0]], [np.inf]), r"b must be finite; b\[0\] is inf"),
        ((sparse.csr_matrix([[1.0, 2.0]]), [1.0]), r"A must be a square matrix; got shape \(1, 2\)"),
        ((sparse.csr_matrix([[np.nan]]), [1.0]), "A must be finite"),
        ((np.eye(25), -np.ones(25), "enumeration"), "at most 20 unknowns; got 25"),
    ],
)
def test_bad_input_is_refused_in_one_sentence(arguments, message):
    with pytest.raises(InvalidInput, match=message):
        solve_lcp(*arguments)


def test_a_guess_of_wrong_length_is_refused():
    with pytest.raises(InvalidInput, match="guess must have 2 entries; got 3"):
        solve_lcp(np.eye(2), np.ones(2), guess=np.ones(3))


def test_a_tolerance_must_be_positive():
    with pytest.raises(InvalidInput, match="tol must be positive"):
        solve_lcp(np.eye(2), np.ones(2), tol=0.0)


def test_an_unknown_solver_is_named_with_those_that_exist():
    with pytest.raises(UnknownName, match=r"auto, lemke.*newton.*got 'lemk'; did you mean 'lemke'"):
        solve_lcp(np.eye(2), np.ones(2), "lemk")


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("b", [[1.0, 2.0], [-1.0, 2.0]])
def test_an_entry_that_no_impulse_meets_is_refused_too(bad, b):
    """z_2 = 0: what is taken without a look is looked at by its residual, 0 times infinity included."""
    for i in range(2):
        A = np.array([[2.0, 0.0], [0.0, 1.0]])
        A[i, 1] = bad
        with pytest.raises(InvalidInput, match="A must be finite"):
            solve_lcp(A, np.array(b))
    with pytest.raises(InvalidInput, match="b must be finite"):
        solve_lcp(np.eye(2), np.array([b[0], bad]))


@few
@given(seeds, st.integers(1, 6), st.booleans())
def test_rows_and_columns_of_unlike_units_change_no_verdict(seed, n, is_whole):
    """z >= 0 and w >= 0 do not depend on the units of either, here powers of two up to 1e12 apart."""
    rng = np.random.default_rng(seed)
    draw = (
        (lambda *shape: rng.integers(-2, 3, shape).astype(float))
        if is_whole
        else (lambda *shape: rng.normal(size=shape))
    )
    A, b = draw(n, n), draw(n)
    R, E = 2.0 ** rng.integers(-20, 21, (2, n))
    plain, scaled = solve_lcp(A, b), solve_lcp(R[:, None] * A * E, R * b)
    assert plain.success == scaled.success == bool(lcp_solutions(A, b))
    if scaled.success:
        z = E * scaled.z
        w, size = A @ z + b, np.abs(A) @ np.abs(z) + np.abs(b)
        assert (z >= 0).all() and (w >= -1e-9 * size).all()
        assert (np.minimum(np.abs(np.diag(A)) * z, w) <= 1e-9 * np.maximum(size, 1e-300)).all()
    else:
        assert plain.status in (LCPStatus.INFEASIBLE, LCPStatus.NO_SOLUTION)
        assert scaled.status in (LCPStatus.INFEASIBLE, LCPStatus.NO_SOLUTION)


@pytest.mark.parametrize(("diagonal", "b"), [
    ((1.0, -1.0), (-1e12, -1.0)), ((1e8, -1e-4), (-1e8, -1e-4)), ((1.0, -1e-6), (-1e6, -1e-6)),
    ((-1e-9, 1e9), (-1e-9, -1.0)),
])  # fmt: skip
def test_a_small_row_without_a_solution_is_not_hidden_by_a_large_one(diagonal, b):
    result = solve_lcp(np.diag(diagonal), b)
    assert result.status == LCPStatus.INFEASIBLE and result.residual > 0.1
    assert lcp_solutions(np.diag(diagonal), b) == ()


@pytest.mark.parametrize("solver", ["auto", "enumeration"])
def test_that_there_is_no_solution_is_said_where_every_active_set_was_looked_at(solver):
    """w = (z_2 - z_1 - 1, 1) has feasible points, and no certificate."""
    result = solve_lcp([[-1.0, 1.0], [0.0, 0.0]], [-1.0, 1.0], solver)
    assert result.status == LCPStatus.NO_SOLUTION and not result.success and "none of 4 active sets" in result.message
    assert "newton" not in result.message  # whose 300 steps would take a hundred times longer
    mixed = solve_mlcp([[-1.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]], [-1.0, 1.0, 1.0], free=[2])
    assert mixed.status == LCPStatus.NO_SOLUTION and mixed.certificate is None


@few
@given(seeds, st.integers(1, 5))
def test_no_solution_is_said_exactly_where_a_search_of_all_active_sets_finds_none(seed, n):
    """Every active set alpha by hand: z_alpha = -A_alpha^-1 b_alpha where that is regular (it is, almost surely)."""
    rng = np.random.default_rng(seed)
    A, b = rng.normal(size=(n, n)), rng.normal(size=n)
    found = False
    for bits in range(2**n):
        alpha = [i for i in range(n) if bits >> i & 1]
        z = np.zeros(n)
        if alpha:
            z[alpha] = np.linalg.solve(A[np.ix_(alpha, alpha)], -b[alpha])
        w = A @ z + b
        found = found or bool((z >= 0).all() and (np.delete(w, alpha) >= 0).all())
    status = solve_lcp(A, b).status
    assert (status == LCPStatus.SOLVED) == found
    assert found or status in (LCPStatus.INFEASIBLE, LCPStatus.NO_SOLUTION)


def game_of_groups(rng, groups=4, each=4):
    """Equilibria of two teams whose groups mix `each` moves: costs in 1 .. 250 between the teams, 1 within one; a zero
    block for the values, and b in {0, -1}."""
    m = groups * each
    G = np.kron(np.eye(groups), np.ones((each, 1)))
    own, Z, z = np.ones((m, m)), np.zeros((m, groups)), np.zeros((groups, groups))
    one, other = rng.integers(1, 251, (2, m, m)).astype(float)
    A = np.block([[own, one, -G, Z], [other, own, Z, -G], [G.T, Z.T, z, z], [Z.T, G.T, z, z]])
    return A, np.concatenate([np.zeros(2 * m), -np.ones(2 * groups)])


def test_problems_on_which_the_lexicographic_rule_goes_round_are_solved_beside_b():
    gone_round = 0
    for seed in range(25):
        A, b = game_of_groups(np.random.default_rng(seed))
        gone_round += solve_lcp(A, b, "lemke").status == LCPStatus.MAX_ITERATIONS
        for solver in ("auto", "perturbed"):
            result = solve_lcp(A, b, solver)
            assert result.success and result.residual <= 1e-10, result.message
        assert result.iterations < 500
    assert gone_round >= 2  # else this would say nothing
