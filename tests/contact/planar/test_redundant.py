"""Redundant contacts: every solution, beside a linear programme for each combination of modes."""

import itertools

import numpy as np
import pytest
from scipy.optimize import linprog

from nonsmooth.contact.planar.problem import Planar, problem_of
from nonsmooth.contact.planar.redundant import enumerate_redundant
from nonsmooth.jit.blocks import new
from nonsmooth.mechanics.system import BILATERAL, UNILATERAL

FREE, STICK, PLUS, MINUS, PULL_PLUS, PULL_MINUS = range(6)
SLIP = {PLUS: 1, MINUS: -1, PULL_PLUS: 1, PULL_MINUS: -1}


def solutions(G, c, mu, kinds):
    """Impulses found, (found, 2 n)."""
    problem = problem_of(np.array([(kind, 1) for kind in kinds]), G, c, mu, mu)
    planar = new(Planar, n=len(mu), d=1)
    found = enumerate_redundant(problem.address, G, planar.address)
    return planar.tree.solutions[:found].copy(), planar.tree.modes[:found].copy()


def motions_by_linear_programmes(G, c, mu, kinds):
    """The velocities G P + c of every combination of modes that a linear programme finds feasible."""
    choices = [
        [(STICK, 1), (STICK, -1), (PLUS, 1), (MINUS, 1), (PULL_PLUS, -1), (PULL_MINUS, -1)]
        if kind == BILATERAL
        else [(FREE, 1), (STICK, 1), (PLUS, 1), (MINUS, 1)]
        for kind in kinds
    ]
    found = []
    for modes in itertools.product(*choices):
        A, a, C, e = [], [], [], []  # A P = a, C P <= e
        unit = np.eye(len(c))
        for k, (mode, sigma) in enumerate(modes):
            N, F = 2 * k, 2 * k + 1
            C.append(-sigma * unit[N])
            e.append(0.0)
            if mode == FREE:
                A += [unit[N], unit[F]]
                a += [0.0, 0.0]
                C.append(-G[N])
                e.append(c[N])
                continue
            A.append(G[N])
            a.append(-c[N])
            if mode == STICK:
                A.append(G[F])
                a.append(-c[F])
                C += [unit[F] - mu[k] * sigma * unit[N], -unit[F] - mu[k] * sigma * unit[N]]
                e += [0.0, 0.0]
            else:
                A.append(unit[F] + SLIP[mode] * mu[k] * sigma * unit[N])
                a.append(0.0)
                C.append(-SLIP[mode] * G[F])
                e.append(SLIP[mode] * c[F])
        answer = linprog(np.zeros(len(c)), C, e, A, a, bounds=(None, None), method="highs")
        if answer.status == 0:
            gamma = G @ answer.x + c
            if not any(np.abs(gamma - other).max() < 1e-6 for other in found):
                found.append(gamma)
    return found


def problem(seed):
    """Contacts on a body with three coordinates: G has rank 3 at most, and the velocities before may be anything."""
    rng = np.random.default_rng(seed)
    n = 2 if seed % 3 else 3
    kinds = [BILATERAL if seed % 4 == 0 and k == 0 else UNILATERAL for k in range(n)]
    W = rng.normal(size=(2 * n, 3))
    if seed % 2:  # corners of a block on a floor: rows (y, x) with levers
        levers = rng.uniform(-1, 1, n)
        W = np.array([row for x in levers for row in ([0, 1, x], [1, 0, 0.7])], dtype=float)
    c = W @ rng.normal(size=3)
    if seed % 5 == 0:
        c += 0.1 * rng.normal(size=2 * n)
    return W @ W.T, c, rng.choice([0.2, 0.7, 1.5], n), kinds


@pytest.mark.parametrize("seed", range(60))
def test_motions_are_those_of_the_linear_programmes(seed):
    G, c, mu, kinds = problem(seed)
    expected = motions_by_linear_programmes(G, c, mu, kinds)
    impulses, _ = solutions(G, c, mu, kinds)
    motions = [G @ P + c for P in impulses]
    assert len(motions) == len(expected)
    for gamma in motions:  # 1e-6: the feasibility tolerance of the linear programmes is 1e-7
        assert min(np.abs(gamma - other).max() for other in expected) < 1e-6


def test_a_block_that_sticks_on_two_corners_has_one_solution_with_the_least_impulses():
    """Levers -1, 1 and the centre 1 above the floor: only the sum of the two friction impulses is determined."""
    W = np.array([[0.0, 1, -1], [1, 0, 1], [0, 1, 1], [1, 0, 1]])
    c = W @ np.array([0.2, -1.0, 0.0])
    impulses, modes = solutions(W @ W.T, c, [2.0, 2.0], [UNILATERAL] * 2)
    assert len(impulses) == 1 and (modes == STICK).all()
    (P,) = impulses
    assert W.T @ P == pytest.approx(-np.array([0.2, -1.0, 0.0]), abs=1e-13)
    assert P[1] == pytest.approx(P[3])  # the null vector of W^T is (0, 1, 0, -1): the least member has equal shares
