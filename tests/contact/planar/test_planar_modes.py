"""One contact in closed form, several by enumeration: against brute force over all modes, and by property."""

import itertools

import numpy as np
import pytest

from nonsmooth.contact.blocks.nsgs import local_planar
from nonsmooth.contact.planar.enumerate import Tree, enumerate_modes
from nonsmooth.contact.planar.problem import problem_of
from nonsmooth.contact.planar.single import Selection, count, solve_single
from nonsmooth.jit import interpreted
from nonsmooth.jit.blocks import new
from nonsmooth.mechanics.laws import Coulomb, law_row
from nonsmooth.mechanics.system import BILATERAL, UNILATERAL, ContactMode


def single(kind, mu, rows, was_stuck=False, slip=0, selection=Selection.COMPLIANT_LIMIT):
    """(candidate, P_N, P_F, found) of a contact with ``rows`` G_NN, G_NF, G_FF, c_N, c_F."""
    G_NN, G_NF, G_FF, c_N, c_F = rows
    problem = problem_of(np.array([[kind, 1]]), np.array([[G_NN, G_NF], [G_NF, G_FF]]), np.array([c_N, c_F]), mu, mu)
    problem.laws[:], problem.offset[1], problem.slip[0], problem.selection = laws_of(mu), c_F, slip, selection
    problem.mode[0] = ContactMode.STICK if was_stuck else ContactMode.SLIDE
    return interpreted(solve_single)(0, problem)


popcount = interpreted(count)


def laws_of(mu):
    return law_row(Coulomb(mu), 0.0, 0.0, "newton", {}).reshape(1, -1)


def random_contact(rng):
    B = rng.uniform(-2, 2)
    A = rng.uniform(0.1, 3)
    C = B * B / A * rng.uniform(1.02, 3)
    return C, B, A, rng.normal(), rng.normal(), rng.uniform(0, 4)


@pytest.mark.upkeep
def test_a_sweep_takes_a_mode_that_the_enumeration_of_one_contact_finds():
    """The planar closed form of Gauss-Seidel against the one of the integrator."""
    rng = np.random.default_rng(3)
    for _ in range(2000):
        C, B, A, c_N, c_F, mu = random_contact(rng)
        P_N, P_F = interpreted(local_planar)(np.array([[[C, B], [B, A]]]), 0, c_N, c_F, mu)
        found = []
        for rule in Selection:
            for was_stuck in (False, True):
                for slip in (-1, 0, 1):
                    _, *P, _ = single(UNILATERAL, mu, (C, B, A, c_N, c_F), was_stuck, slip, rule)
                    found.append(P)
        assert min(np.abs(np.subtract(P, (P_N, P_F))).max() for P in found) <= 1e-9 * (1 + abs(P_N) + abs(P_F))


@pytest.mark.parametrize("kind", [UNILATERAL, BILATERAL])
def test_one_contact_has_one_solution_or_three(kind):
    rng = np.random.default_rng(1)
    for _ in range(3000):
        C, B, A, c_N, c_F, mu = random_contact(rng)
        *_, found = single(kind, mu, (C, B, A, c_N, c_F))
        assert popcount(found) in (1, 3)


def test_solution_of_one_contact_satisfies_the_inclusions():
    rng = np.random.default_rng(2)
    for _ in range(2000):
        C, B, A, c_N, c_F, mu = random_contact(rng)
        _, P_N, P_F, _ = single(UNILATERAL, mu, (C, B, A, c_N, c_F))
        gamma_N, gamma_F = c_N + C * P_N + B * P_F, c_F + B * P_N + A * P_F
        small = 1e-11 * (abs(c_N) + abs(c_F)) * (1 + abs(P_N) * C / (abs(c_N) + abs(c_F)))
        assert P_N >= 0 and gamma_N >= -small and abs(P_N * gamma_N) <= small * (1 + P_N)
        pulled = np.clip(P_F - gamma_F / A, -mu * P_N, mu * P_N)
        assert abs(P_F - pulled) <= small / A + 1e-11 * abs(P_F)


def test_a_contact_that_stuck_keeps_sticking_where_it_may():
    mu, C, B, A = 2.0, 1.0, -0.9, 1.2
    # p_- = C + mu B < 0 and c_N > 0: free, slide and stick are all admissible
    arguments = (UNILATERAL, mu, (C, B, A, 0.5, -1.0))
    candidate, *_, found = single(*arguments, was_stuck=True)
    assert (candidate, popcount(found)) == (1, 3)
    candidate, *_ = single(*arguments, slip=-1)
    assert candidate == 0


def brute_force(G, c, mu):
    """Velocities of every admissible combination of free, stick, slide + and slide -, by dense solves."""
    n = len(mu)
    motions = []
    for modes in itertools.product(range(4), repeat=n):
        rows, columns = [], []
        for i, mode in enumerate(modes):
            N, T = 2 * i, 2 * i + 1
            unit = np.zeros((2, 2 * n))
            unit[0, N] = unit[1, T] = 1
            if mode == 1:
                rows += [N, T]
                columns += [unit[0], unit[1]]
            elif mode > 1:
                rows.append(N)
                columns.append(unit[0] + (-mu[i] if mode == 2 else mu[i]) * unit[1])
        P = np.zeros(2 * n)
        if rows:
            basis = np.array(columns).T
            P = basis @ np.linalg.solve((G @ basis)[rows], -c[rows])
        gamma = G @ P + c
        if all(_admissible(mode, P, gamma, i, mu[i]) for i, mode in enumerate(modes)):
            motions.append(gamma)
    return motions


def _admissible(mode, P, gamma, i, mu):
    N, T = 2 * i, 2 * i + 1
    if mode == 0:
        return gamma[N] >= 0
    if mode == 1:
        return P[N] >= 0 and abs(P[T]) <= mu * P[N]
    return P[N] > 0 and (gamma[T] > 0 if mode == 2 else gamma[T] < 0)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_enumeration_finds_what_brute_force_finds(n):
    rng = np.random.default_rng(n)
    tree = new(Tree, n=n, r=2 * n)
    kinds = np.tile([UNILATERAL, 1], (n, 1))
    several = 0
    for _ in range(60):
        W = rng.normal(size=(2 * n, 2 * n + 1))
        G, c, mu = W @ W.T, rng.normal(size=2 * n), rng.uniform(0, 8, n)
        problem = problem_of(kinds, G, c, mu, mu)
        found, is_complete = enumerate_modes(problem.address, tree.address)
        expected = brute_force(G, c, mu)
        assert is_complete
        assert found == len(expected)
        several += found > 1
        for motion in expected:
            assert min(np.abs(tree.motions[:found] - motion).max(axis=1)) < 1e-8 * np.abs(c).max()
    assert several > 0 or n == 1


def test_contacts_listed_before_leave_nothing_behind():
    # the same memory serves rows (N, N F) and then (N F, N F): impulses of a contact must not keep coefficients of rows
    # that belonged to two contacts before
    rng = np.random.default_rng(7)
    used, fresh = (new(Tree, n=2, r=4) for _ in range(2))

    def solve(tree, d_0, G, c, mu):
        kinds, r = np.array([[UNILATERAL, d_0], [UNILATERAL, 1]]), 3 + d_0
        problem = problem_of(kinds, G[:r, :r], c[:r], mu, mu)
        found, _ = enumerate_modes(problem.address, tree.address)
        return tree.solutions[:found, :r].copy()

    for _ in range(40):
        W = rng.normal(size=(4, 6))
        G, c, mu = W @ W.T, rng.normal(size=4) - 0.5, rng.uniform(0.2, 2.0, 2)
        solve(used, 0, G, c, mu)
        np.testing.assert_array_equal(solve(used, 1, G, c, mu), solve(fresh, 1, G, c, mu))
