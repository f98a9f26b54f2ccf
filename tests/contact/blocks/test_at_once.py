"""One contact and few ones in a compiled call: the impulses of the ladder, judged by the problem as it was given."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from benchmarks.problems import FAMILIES
from nonsmooth.contact.blocks.few_contacts import sweep_few
from nonsmooth.contact.blocks.ladder import FIRST_SWEEPS, POLISHED_ERROR, Single, climb
from nonsmooth.contact.blocks.newton_few import FEW_UNKNOWNS, STEPS_AT_MOST, newton_memory, step_few
from nonsmooth.contact.blocks.one_contact import solve_one
from nonsmooth.contact.blocks.problem import as_matrix, check_problem, scale_problem
from nonsmooth.contact.blocks.result import ContactStatus
from nonsmooth.contact.blocks.solve import solve_contact
from nonsmooth.jit import interpreted


def one_contact(seed, dim):
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(dim, dim))
    return root @ root.T + 1e-2 * np.eye(dim), rng.normal(size=dim), rng.choice([0.0, 0.3, 1.5], 1)


def few_contacts(name, dim, size=6, seed=0):
    return FAMILIES[name](np.random.default_rng([seed, size, dim]), size, dim)


def on_the_cones(mu, dim, P):
    """Whether no impulse is outside its cone by more than the rounding of a product."""
    P = P.reshape(-1, dim)
    return (np.linalg.norm(P[:, 1:], axis=1) <= mu * P[:, 0] * (1 + 4e-16)).all()


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("seed", range(10))
def test_one_contact_is_solved_as_a_rung_of_the_ladder_solves_it(seed, dim):
    G, c, mu = one_contact(seed, dim)
    problem, factor = scale_problem(check_problem(G, c, mu, dim))
    P = factor * climb(problem, np.zeros(dim), 1e-8, [Single()]).P
    result = solve_contact(G, c, mu, dim)
    np.testing.assert_allclose(result.P, P, rtol=1e-14, atol=1e-15 * np.abs(P).max())
    assert result.error == pytest.approx(check_problem(G, c, mu, dim).error(result.P), rel=1e-12, abs=1e-30)
    assert (result.gamma == check_problem(G, c, mu, dim).velocity(result.P)).all()
    assert on_the_cones(mu, dim, result.P)


@pytest.mark.parametrize("dim", [2, 3])
def test_one_contact_has_the_same_bits_interpreted(dim):
    for seed in range(10):
        G, c, mu = one_contact(seed, dim)
        ends = []
        for solve in (solve_one, interpreted(solve_one)):
            P, gamma = np.zeros(dim), np.zeros(dim)
            ends.append((solve(G[None], c, mu, P, gamma, np.empty((1, dim, dim))), P.tolist(), gamma.tolist()))
        assert ends[0] == ends[1]


@pytest.mark.parametrize("power", [-200, 200])
@pytest.mark.parametrize("dim", [2, 3])
def test_units_of_one_contact_change_no_digit(dim, power):
    """G of one power of two and c of another: the impulse scales by their ratio, bit for bit."""
    G, c, mu = one_contact(3, dim)
    reference = solve_contact(G, c, mu, dim)
    result = solve_contact(np.ldexp(G, power), np.ldexp(c, power // 2), mu, dim)
    assert (result.P == np.ldexp(reference.P, power // 2 - power)).all() and result.error == reference.error


def test_one_contact_without_a_solution_is_said_to_have_none():
    """G_NN - mu G_NT < 0 with an indefinite G: neither lifting off nor sticking nor sliding holds."""
    result = solve_contact([[1.0, 2.0], [2.0, 1.0]], [-1.0, 3.0], 0.6, 2)
    assert result.status is ContactStatus.NO_SOLUTION and result.error > 1e-3


@pytest.mark.parametrize("name", ["assembly", "packing", "elastic", "one_body"])
@pytest.mark.parametrize("dim", [2, 3])
def test_few_contacts_are_solved_to_rounding_and_judged_as_given(name, dim):
    case = few_contacts(name, dim)
    result = solve_contact(*case)
    assert result.status is ContactStatus.SOLVED and result.error <= POLISHED_ERROR
    problem = check_problem(*case)
    assert problem.error(result.P) == pytest.approx(result.error, rel=1e-6, abs=1e-16)
    assert (problem.velocity(result.P) == result.gamma).all()
    assert on_the_cones(case.mu, dim, result.P)


@pytest.mark.parametrize("dim", [2, 3])
def test_sweeps_of_few_contacts_have_the_same_bits_interpreted(dim):
    problem, ends = check_problem(*few_contacts("elastic", dim)), []
    rows = problem.blocks.G, problem.blocks.indices, problem.blocks.indptr
    for sweep in (sweep_few, interpreted(sweep_few)):
        P, gamma, rho = np.zeros(problem.n), np.zeros(problem.n), np.zeros(problem.n_c)
        end = sweep(rows, problem.c, problem.mu, P, gamma, rho, POLISHED_ERROR, FIRST_SWEEPS)
        ends.append((end, P.tolist(), gamma.tolist(), rho.tolist()))
    assert ends[0] == ends[1] and ends[0][0][1] <= POLISHED_ERROR


def stepped(case, step=step_few):
    """Newton's method alone, from no impulses: what it returns and writes."""
    problem = check_problem(*case)
    rows = problem.blocks.G, problem.blocks.indices, problem.blocks.indptr
    P, gamma, rho = np.zeros(problem.n), np.zeros(problem.n), np.zeros(problem.n_c)
    end = step(rows, problem.c, problem.mu, P, gamma, rho, newton_memory(problem.n_c, problem.dim), POLISHED_ERROR)
    return end, P, gamma, rho


@pytest.mark.parametrize(("name", "dim"), [("assembly", 2), ("assembly", 3), ("wall", 2), ("arch", 3)])
def test_newton_steps_of_few_contacts_have_the_same_bits_interpreted(name, dim):
    case = few_contacts(name, dim, size=2)
    compiled, source = stepped(case), stepped(case, interpreted(step_few))
    assert compiled[0] == source[0] and compiled[0][1] <= POLISHED_ERROR
    assert [x.tolist() for x in compiled[1:]] == [x.tolist() for x in source[1:]]


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("name", ["wall", "arch"])
def test_redundant_contacts_are_solved_to_rounding_at_once(name, dim):
    """More rows than velocities: a shift of the Jacobian by 1e-11 would leave errors of 1e-12 and more in them."""
    ends = 0
    for seed in range(10):
        case = few_contacts(name, dim, size=2, seed=seed)
        problem = check_problem(*case)
        result = solve_contact(*case)
        assert np.linalg.matrix_rank(as_matrix(problem.blocks)) < problem.n <= FEW_UNKNOWNS
        assert problem.error(result.P) <= 10 * POLISHED_ERROR
        assert (problem.velocity(result.P) == result.gamma).all() and on_the_cones(case.mu, dim, result.P)
        ends += result.message.startswith("solved; nsgs and newton")
    assert ends >= 8  # who gives up is no failure: the ladder goes on


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("power", [-60, 80])
def test_newton_steps_of_few_contacts_know_no_units(dim, power):
    """G of one power of four and c of another: the same steps, impulses that scale bit for bit."""
    case = few_contacts("assembly", dim)
    G = as_matrix(check_problem(*case).blocks)
    end = stepped((G, case.c, case.mu, dim))
    scaled = stepped((np.ldexp(G, power), np.ldexp(case.c, power // 2), case.mu, dim))
    assert scaled[0][0] == end[0][0] and end[0][1] <= POLISHED_ERROR
    assert (scaled[1] == np.ldexp(end[1], power // 2 - power)).all()


def test_newton_steps_that_go_nowhere_are_given_up_and_the_ladder_goes_on():
    """A tower of masses over six decades, from no impulses."""
    case = FAMILIES["tower"](np.random.default_rng([0, 20, 2]), 20, 2)
    end = stepped(case)[0]
    assert end[1] == np.inf and end[0] <= STEPS_AT_MOST
    assert solve_contact(*case).status is ContactStatus.SOLVED


def test_sweeps_that_would_not_end_are_given_up_and_the_ladder_ends_them():
    """A tower of masses over six decades: sweeps gain a digit in thousands."""
    case = FAMILIES["tower"](np.random.default_rng([0, 20, 2]), 20, 2)
    problem = check_problem(*case)
    rows = problem.blocks.G, problem.blocks.indices, problem.blocks.indptr
    P, gamma = np.zeros(problem.n), np.zeros(problem.n)
    sweeps, error, _ = sweep_few(rows, problem.c, problem.mu, P, gamma, np.zeros(problem.n_c), 1e-13, FIRST_SWEEPS)
    assert error == np.inf and sweeps < FIRST_SWEEPS
    assert solve_contact(*case).status is ContactStatus.SOLVED


def test_sizes_whose_squares_overflow_are_left_to_the_scaled_ladder():
    G, c, mu, dim = few_contacts("elastic", 2)
    reference = solve_contact(G, c, mu, dim)
    result = solve_contact(np.ldexp(G, -400), np.ldexp(c, 400), mu, dim)
    assert result.status is ContactStatus.SOLVED
    np.testing.assert_allclose(np.ldexp(result.P, -800), reference.P, atol=1e-7 * np.abs(reference.P).max())


def test_threads_do_not_meet_in_the_memory_of_a_call():
    cases = [few_contacts("assembly", dim, seed=seed) for seed in range(8) for dim in (2, 3)]
    cases += [(*one_contact(seed, 3), 3) for seed in range(8)]
    alone = [solve_contact(*case).P.tolist() for case in cases]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(lambda case: solve_contact(*case).P.tolist(), cases * 5))
    assert together == alone * 5
