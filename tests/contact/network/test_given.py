"""Problems given by masses and directions: solved on the graph of the bodies, judged by the assembled problem."""

import time

import numpy as np
import pytest
from scipy import sparse

import nonsmooth as ns
from benchmarks.problems import FAMILIES
from nonsmooth.contact.blocks.problem import check_problem
from nonsmooth.contact.blocks.result import ContactStatus
from nonsmooth.contact.network import kicks
from nonsmooth.contact.network import rounds as rounds_of_sweeps
from nonsmooth.contact.network.given import network_of
from nonsmooth.contact.network.kicks import contact_errors, kick, kick_and_walk, worst_contacts
from nonsmooth.contact.network.problem import judge_spatial
from nonsmooth.contact.network.rounds import Rounds, solve_in_rounds


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
    judge_spatial(network.address)
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


def test_what_rounds_and_kicks_leave_is_handed_on_to_the_solvers_of_dense_problems(monkeypatch):
    """A tower of masses over six decades is interior points' work, or that of kicks, which are left out here."""
    monkeypatch.setattr(kicks, "MOST_KICKS", 0)
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


def test_kicks_and_walks_solve_packings_that_rounds_leave(monkeypatch):
    """Without the interior points of the rounds, which solve this one."""
    monkeypatch.setattr(rounds_of_sweeps, "STARTS", ())
    case = packing(300, 0)
    network = network_of(*arguments(case.given))
    rounds = solve_in_rounds(network, 1e-8)
    assert rounds.least > 1e-5
    kick_and_walk(rounds, 1e-8, np.inf)
    found = rounds.end()
    assert found.error <= 1e-8 and check_problem(*case).error(found.P) <= 1e-8


def test_a_longer_walk_comes_no_less_near():
    """Its sweeps are those of the shorter one as far as that goes."""
    approaches = []
    for most in (100, 200, 400):
        rounds = Rounds(network_of(*arguments(packing(300, 0).given)))
        nearest = rounds.walk(most, 1e-14, 0.0)
        assert rounds.sweeps == most and rounds.factors == 0  # the time is up before factors
        assert rounds.least == nearest <= rounds.measured_error(rounds.rho)  # it stands where it ended
        approaches.append(nearest)
    assert approaches[2] <= approaches[1] <= approaches[0] < 1.0


def test_only_spheres_walk():
    for name, dim, expected in (("packing", 3, True), ("packing", 2, False), ("wall", 3, False), ("tower", 3, False)):
        rounds = Rounds(network_of(*arguments(given(name, 100, dim).given)))
        assert rounds.are_spheres() is expected


def test_a_walk_that_comes_as_near_as_the_one_before_goes_in_a_circle_and_is_kicked(monkeypatch):
    nearest = iter([1.0, 0.5, 0.5 * (1.0 - 0.5 * kicks.CIRCLE), 0.4, 0.5, 0.5])
    walks, kicked = [], []

    def walk(rounds, most, tol, until):
        walks.append(most)
        return next(nearest)

    monkeypatch.setattr(kicks, "MOST_KICKS", 6)
    monkeypatch.setattr(Rounds, "walk", walk)
    monkeypatch.setattr(kicks, "kick", lambda rounds, draw: kicked.append(len(walks)))
    rounds = Rounds(network_of(*arguments(packing(100, 0).given)))
    kick_and_walk(rounds, 1e-8, np.inf)
    assert kicked == [3, 6] and walks == [kicks.WALK_SWEEPS] * 6
    assert (rounds.network.P == rounds.best).all()


def test_a_kick_scatters_impulses_along_themselves_near_the_worst_contact_only():
    rounds = Rounds(network_of(*arguments(packing(500, 0).given)))
    rounds.sweep(100, 1e-8)
    before = rounds.network.P.copy()
    reached = worst_contacts(rounds, min(kicks.KICKED_SHARES), max(kicks.KICK_REACHES))
    kick(rounds, np.random.default_rng(5))
    after = rounds.network.P
    moved = (after != before).any(axis=1)
    assert moved.any() and not (moved & ~reached).any()
    factors = after[moved, 0] / before[moved, 0]
    assert (factors > 0.0).all()
    np.testing.assert_allclose(after[moved], factors[:, None] * before[moved], rtol=1e-14)


def test_the_same_problem_has_the_same_solution_to_the_last_bit():
    first, second = (packing(300, 2).given.solve() for _ in range(2))
    assert first.success and first.solver == "network" and first.P.tobytes() == second.P.tobytes()


def test_a_kick_reaches_the_bodies_about_the_worst_contact_and_not_through_the_ground():
    rounds = Rounds(network_of(*arguments(packing(300, 0).given)))
    rounds.sweep(20, 1e-8)
    network, ground = rounds.network, len(rounds.network.v) - 1
    rounds.measured_error(rounds.rho)
    errors = contact_errors(rounds)
    norm = np.linalg.norm(errors) * rounds.weight[0]
    assert norm == pytest.approx(rounds.measured_error(rounds.rho), rel=1e-12)
    worst = int(errors.argmax())
    near, count = {int(network.i[worst]), int(network.j[worst])} - {ground}, 1
    for reach in (1, 2, 3):
        expected = [{int(a), int(b)} & near != set() for a, b in zip(network.i, network.j, strict=True)]
        found = worst_contacts(rounds, 1.0 - 1e-12, reach)
        assert found.tolist() == expected and count < found.sum() < len(found)
        near = {int(k) for pair in (network.i[found], network.j[found]) for k in pair} - {ground}
        count = found.sum()


def test_kicks_and_walks_leave_no_worse_impulses_and_end_in_time():
    rounds = Rounds(network_of(*arguments(packing(500, 1).given)))
    rounds.sweep(100, 1e-8)
    before = rounds.least
    kick_and_walk(rounds, 1e-8, 0.0)
    assert rounds.least == before
    kick_and_walk(rounds, 1e-8, time.monotonic() + 0.2)
    assert rounds.measured_error(rounds.rho) == rounds.least <= before


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
