"""Problems given by masses and directions: solved on the graph of the bodies, judged by the assembled problem."""

import numpy as np
import pytest
from scipy import sparse

import nonsmooth as ns
from benchmarks.problems import FAMILIES
from nonsmooth.contact.blocks.problem import check_problem
from nonsmooth.contact.blocks.result import ContactStatus
from nonsmooth.contact.network import rounds as rounds_of_sweeps
from nonsmooth.contact.network.given import network_of
from nonsmooth.contact.network.problem import judge_network
from nonsmooth.contact.network.rounds import Rounds


def given(name, size, dim, **more):
    return FAMILIES[name](np.random.default_rng([0, size, dim]), size, dim, **more)


def arguments(problem):
    return problem.M, problem.H, problem.f, problem.w, problem.mu


def changed(problem, **fields):
    return ns.GlobalContactProblem(**{**vars(problem), **fields})


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize(
    "name, size", [("wall", 400), ("packing", 100), ("arch", 30), ("assembly", 60), ("one_body", 30)]
)
def test_what_the_bodies_say_holds_for_the_assembled_problem(name, size, dim):
    case = given(name, size, dim)
    result = case.given.solve()
    assert result.status is ContactStatus.SOLVED and result.solver == "network"
    problem = check_problem(*case)  # another way to G, c and the error
    assert problem.error(result.P) <= 1e-8
    np.testing.assert_allclose(result.gamma, problem.velocity(result.P), atol=1e-11 * np.abs(case.c).max())
    assert result.error == pytest.approx(problem.error(result.P), rel=1e-2, abs=1e-12)


def test_velocities_of_the_network_are_those_of_masses_and_directions():
    case = given("packing", 60, 3)
    network = network_of(*arguments(case.given))
    network.P[:] = np.random.default_rng(1).normal(size=network.P.shape)
    judge_network(network.address, 3)
    expected = case.G @ network.P.ravel() + case.c
    np.testing.assert_allclose(network.gamma.ravel(), expected, atol=1e-12 * np.abs(expected).max())


def test_surfaces_that_move_and_full_masses_are_taken_as_they_are():
    case = given("wall", 40, 3)
    rng = np.random.default_rng(2)
    n_b = len(case.given.f) // 6
    roots = rng.normal(size=(n_b, 6, 6))
    M = sparse.block_diag(roots @ roots.transpose(0, 2, 1) + 5 * np.eye(6), format="csr")
    problem = changed(case.given, M=M, w=0.01 * rng.normal(size=len(case.c)))
    result, local = problem.solve(), problem.local()
    assert result.solver == "network" and result.success
    assert check_problem(local.G, local.c, local.mu, local.dim).error(result.P) <= 1e-8


def coupled(problem):
    M = sparse.lil_array(problem.M)
    M[0, 9] = M[9, 0] = 1e-3
    return changed(problem, M=M.tocsr())


def touching_three(problem):
    H = sparse.lil_array(problem.H)
    H[:, 0] = 1.0
    return changed(problem, H=H.tocsr())


def constrained(problem):
    G = np.zeros((len(problem.f), 1))
    G[0] = 1.0
    return changed(problem, G=sparse.csr_array(G), b=np.zeros(1))


@pytest.mark.parametrize("other", [coupled, touching_three, constrained])
def test_what_is_no_network_of_bodies_is_solved_with_the_masses_eliminated(other):
    problem = other(given("wall", 40, 3).given)
    result, local = problem.solve(), problem.local()
    assert result.solver != "network" and result.success
    assert check_problem(local.G, local.c, local.mu, local.dim).error(result.P) <= 1e-8


@pytest.mark.parametrize("entry", [-1.0, 0.0])
def test_masses_that_are_not_positive_make_no_network(entry):
    problem = given("wall", 40, 3).given
    M = sparse.lil_array(problem.M)
    M[0, 0] = entry
    assert network_of(M, *arguments(problem)[1:]) is None


def test_what_rounds_leave_is_handed_on_to_the_solvers_of_dense_problems(monkeypatch):
    """A tower of masses over six decades is the work of interior points, which are left out here."""
    monkeypatch.setattr(rounds_of_sweeps, "STARTS", ())
    case = given("tower", 200, 3)
    result = case.given.solve()
    assert result.success and result.solver != "network" and "network" in result.message
    assert check_problem(*case).error(result.P) <= 1e-8


def test_at_the_end_of_its_time_the_best_impulses_come_back_with_their_true_error():
    case = given("packing", 500, 3)
    result = case.given.solve(max_time=1e-3)
    assert result.status is ContactStatus.BUDGET_SPENT
    assert check_problem(*case).error(result.P) == pytest.approx(result.error, rel=1e-6)


def test_a_round_never_leaves_worse_impulses_than_it_found():
    rounds = Rounds(network_of(*arguments(given("packing", 200, 3).given)))
    for most in (5, 10, 20):
        before = rounds.least
        rounds.sweep(most, 1e-8)
        assert rounds.measured_error(rounds.rho) == rounds.least <= before
        rounds.factorise()
        assert rounds.measured_error(rounds.rho) == rounds.least <= before


def packing(size, seed):
    return FAMILIES["packing"](np.random.default_rng([seed, size, 3]), size, 3)


def test_the_same_problem_has_the_same_solution_to_the_last_bit():
    first, second = (packing(300, 2).given.solve() for _ in range(2))
    assert first.success and first.solver == "network" and first.P.tobytes() == second.P.tobytes()


def test_factors_that_want_more_room_get_it():
    case = given("wall", 300, 3)
    rounds = Rounds(network_of(*arguments(case.given)))
    rounds.sweep(500, 1e-8)
    rounds.solver = rounds._solver(1)
    rounds.factorise()
    assert rounds.factors > 0 and rounds.least <= 1e-8


@pytest.mark.parametrize("wrong", [{"tol": 0.0}, {"tol": 1.0}, {"max_time": -1.0}, {"max_time": np.nan}])
def test_tolerances_and_times_that_mean_nothing_are_refused(wrong):
    with pytest.raises(ns.InvalidInput):
        given("wall", 20, 2).given.solve(**wrong)
