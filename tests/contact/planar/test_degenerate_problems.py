"""Contact problems on the borders of their modes: no load, no velocity, D = 0, rows that repeat; on every path, beside
a linear programme for each combination of modes.

Small whole numbers in the rows and the velocities make all of these common: c = 0 in some rows, P = 0 in a mode that
slides, G of less than full rank, a friction coefficient at which G_NN = mu |G_NF|.
"""

import itertools
from typing import NamedTuple

import numpy as np
import pytest
from scipy.optimize import linprog

from nonsmooth.contact.planar.enumerate import enumerate_modes
from nonsmooth.contact.planar.ladder import Route, solve_planar
from nonsmooth.contact.planar.lemke import pivot
from nonsmooth.contact.planar.newton import solve_by_newton
from nonsmooth.contact.planar.problem import ACCEPTED_RESIDUAL, Planar, problem_of, residual
from nonsmooth.contact.planar.redundant import enumerate_redundant
from nonsmooth.contact.planar.selection import Selection
from nonsmooth.contact.planar.single import count, solve_alone
from nonsmooth.jit import interpreted, load_all
from nonsmooth.jit.blocks import new
from nonsmooth.mechanics.laws import Coulomb, law_row
from nonsmooth.mechanics.system import BILATERAL, GIVEN_FORCE, UNILATERAL, ContactMode

MODES_BEFORE = (ContactMode.OPEN, ContactMode.STICK, ContactMode.SLIDE)
SAME_VELOCITY = 1e-6  # of the largest velocity: motions of linear programmes that are one


class Degenerate(NamedTuple):
    """A problem of planar contacts: ``kinds`` (kind, directions of friction), ``given`` normal impulses."""

    G: np.ndarray
    c: np.ndarray
    mu: np.ndarray
    kinds: list[tuple[int, int]]
    given: np.ndarray

    @property
    def start(self):
        """First row of each contact."""
        return np.concatenate([[0], np.cumsum([d + (kind != GIVEN_FORCE) for kind, d in self.kinds])])

    def block(self, selection, before, rng):
        """As the solvers take it, with a mode before."""
        problem = problem_of(np.array(self.kinds), self.G, self.c, self.mu, self.mu)
        problem.normal_impulse[:], problem.selection, problem.offset[:] = self.given, selection, self.c
        problem.mode[:] = before
        directions = np.array([d for _, d in self.kinds])
        problem.slip[:] = rng.choice([-1, 1], len(self.mu)) * directions if before == ContactMode.SLIDE else 0
        problem.laws[:] = [law_row(Coulomb(mu), 0.0, 0.0, "newton", {}) for mu in self.mu]
        return problem


def degenerate(rng, n):
    """A random one."""
    kinds = []
    for kind in rng.choice([UNILATERAL, BILATERAL, GIVEN_FORCE], n, p=[0.4, 0.45, 0.15]):
        kinds.append((int(kind), 1 if kind == GIVEN_FORCE else int(rng.random() < 0.85)))
    r = sum(d + (kind != GIVEN_FORCE) for kind, d in kinds)
    freedoms = rng.integers(max(1, r - 2), r + 2)
    W = rng.integers(-2, 3, (r, freedoms)).astype(float)
    W[~W.any(axis=1), 0] = 1.0
    if r > 1 and rng.random() < 0.3:
        one, other = rng.choice(r, 2, replace=False)
        W[one] = W[other] * rng.choice([1.0, -1.0, 2.0])
    G, c = W @ W.T, W @ rng.integers(-2, 3, freedoms)
    c = c * rng.choice([0.0, 1.0]) if rng.random() < 0.5 else np.where(rng.random(r) < 0.6, 0.0, c)
    problem = Degenerate(G, c, rng.choice([0.0, 0.25, 0.5, 1.0, 2.0], n), kinds, np.zeros(n))
    for k, (kind, d) in enumerate(kinds):
        a = problem.start[k]
        if kind == GIVEN_FORCE:
            problem.given[k] = rng.integers(0, 3)
        elif d and G[a, a + 1] != 0.0 and rng.random() < 0.4:
            problem.mu[k] = G[a, a] / abs(G[a, a + 1])  # D = 0
    return problem


def motions(problem):
    """The velocities of every combination of modes that is feasible, and whether one of these leaves them open."""
    G, c, unit, found, is_open = problem.G, problem.c, np.eye(len(problem.c)), [], False
    for modes in itertools.product(*(modes_of(*kind) for kind in problem.kinds)):
        equal, at_most = [], []  # (row, value)
        for k, mode in enumerate(modes):
            add_conditions(k, *mode, problem, unit, equal, at_most)
        arguments = {"bounds": (None, None), "method": "highs"}
        for name, conditions in (("eq", equal), ("ub", at_most)):
            if conditions:
                arguments["A_" + name], arguments["b_" + name] = map(np.array, zip(*conditions, strict=True))
        answer = linprog(np.zeros(len(c)), **arguments)
        if answer.status != 0:
            continue
        gamma = G @ answer.x + c
        is_open = is_open or moves_within(G, answer.x, arguments)
        if not any(np.abs(gamma - other).max() <= SAME_VELOCITY * scale_of(c) for other in found):
            found.append(gamma)
    return found, is_open


def modes_of(kind, d):
    """(name, sign of sliding, sign of P_N) of the modes of a contact."""
    signs = (1, -1) if kind == BILATERAL and d else (1,)
    closed = [("stick", 0, sigma) for sigma in signs]
    slides = [("slide", s, sigma) for s in (1, -1) for sigma in signs] if d else []
    return closed + slides + ([("free", 0, 1)] if kind == UNILATERAL else [])


def add_conditions(k, name, s, sigma, problem, unit, equal, at_most):
    """What a mode of contact k asks of P."""
    G, c, (kind, d), mu = problem.G, problem.c, problem.kinds[k], problem.mu[k]
    a, t = problem.start[k], problem.start[k + 1] - 1
    normal = 0.0 if kind == GIVEN_FORCE else sigma * mu * unit[a]
    load = mu * problem.given[k]
    if name == "free":
        equal += [(unit[row], 0.0) for row in range(a, t + 1)]
        at_most.append((-G[a], c[a]))
        return
    if kind != GIVEN_FORCE:
        equal.append((G[a], -c[a]))
        at_most += [(-sigma * unit[a], 0.0)] if kind == UNILATERAL or d else []
    if d and name == "stick":
        equal.append((G[t], -c[t]))
        at_most += [(unit[t] - normal, load), (-unit[t] - normal, load)]
    elif d:
        equal.append((unit[t] + s * normal, -s * load))
        at_most.append((-s * G[t], s * c[t]))


def moves_within(G, P, arguments):
    """Whether the impulses of a combination of modes have more than one motion."""
    if np.linalg.matrix_rank(arguments.get("A_eq", np.zeros((1, len(P))))) == len(P):
        return False
    for row in np.concatenate([G, -G]):
        other = linprog(row, **arguments)
        if other.status == 3 or abs(row @ (other.x - P)) > SAME_VELOCITY * (1.0 + abs(row @ P)):
            return True
    return False


def scale_of(c):
    return max(1.0, np.abs(c).max())


def solve(problem, block, planar):
    """(whether there is a solution, number of motions counted, or 0)."""
    if problem.kinds[1:]:
        route, found, _, _ = solve_planar(block.address, planar.address)
        return route > Route.NO_SOLUTION, found if planar.is_counted else 0
    bits, _ = interpreted(solve_alone)(0, block)
    return bits != 0, interpreted(count)(bits)


@pytest.mark.upkeep
@pytest.mark.parametrize(("n", "seeds"), [(1, 200), (2, 80), (3, 12)])
def test_a_problem_on_the_border_of_its_modes_is_solved_exactly_where_it_has_a_solution(n, seeds):
    load_all((solve_planar, enumerate_modes, enumerate_redundant, solve_by_newton, pivot))
    is_without = is_several = is_singular = 0
    for seed in range(seeds):
        rng = np.random.default_rng((n, seed))
        problem = degenerate(rng, n)
        expected, is_open = motions(problem)
        is_without, is_several = is_without + (not expected), is_several + (len(expected) > 1)
        for selection, before in itertools.product(Selection, MODES_BEFORE):
            block, planar = problem.block(selection, before, rng), new(Planar, n=n, d=1)
            planar.can_decide_redundant = 1
            is_solved, found = solve(problem, block, planar)
            assert is_solved == bool(expected), (seed, selection, before)
            if not is_solved:
                continue
            gamma = problem.G @ block.P + problem.c
            block.mu[:] = block.mu_static[:] = problem.mu
            assert interpreted(residual)(block, new(Planar, n=2, d=1) if n == 1 else planar) <= ACCEPTED_RESIDUAL
            if not is_open:
                assert min(np.abs(gamma - other).max() for other in expected) <= SAME_VELOCITY * scale_of(problem.c)
                assert found <= len(expected), (seed, selection, before)
                assert n > 1 or found == len(expected), (seed, selection, before)
        if n > 1 and not is_open:
            block, planar = problem.block(Selection.LIFT_OFF, ContactMode.OPEN, rng), new(Planar, n=n, d=1)
            is_singular += np.linalg.matrix_rank(problem.G) < len(problem.c)
            assert enumerate_redundant(block.address, problem.G, planar.address) == len(expected), seed
    assert is_several > 0 and (n > 2 or is_without > 0) and (n == 1 or is_singular > 0)  # each kind is met


@pytest.mark.parametrize("s", [1, -1])
@pytest.mark.parametrize("coupling", [0.0, 0.3, 2.0, -2.0])
def test_a_bilateral_contact_without_load_slides_on_without_impulse_and_that_is_one_motion(coupling, s):
    """c_N = 0: P = 0 whatever mu; where mu |G_NF| > G_NN it may stick as well, if impulses stop it."""
    mu = 0.8
    G = np.array([[1.0, coupling], [coupling, 1.0 + coupling**2]])
    problem = Degenerate(G, np.array([0.0, 0.5 * s]), np.array([mu]), [(BILATERAL, 1)], np.zeros(1))
    block = problem.block(Selection.COMPLIANT_LIMIT, ContactMode.SLIDE, np.random.default_rng(0))
    bits, error = interpreted(solve_alone)(0, block)
    assert (block.P == 0.0).all() and error == 0.0
    assert interpreted(count)(bits) == (2 if mu * abs(coupling) > 1.0 else 1)
