"""Many planar contacts by Newton's method: against closed forms, the enumeration and a convex programme; and which
violations are rounding, in exact arithmetic."""

from fractions import Fraction

import numpy as np
import pytest

import nonsmooth as ns
from benchmarks.stress_scenes import Tower, stack, tower
from nonsmooth.contact.planar.enumerate import Tree, enumerate_modes
from nonsmooth.contact.planar.ladder import exceeds_enumeration
from nonsmooth.contact.planar.newton import solve_by_newton
from nonsmooth.contact.planar.problem import ACCEPTED_RESIDUAL, Planar, problem_of, residual
from nonsmooth.jit import interpreted
from nonsmooth.jit.blocks import new
from nonsmooth.mechanics.system import BILATERAL, GIVEN_FORCE, MASS, NORMAL, TANGENT, UNILATERAL, evaluate
from nonsmooth.numerics.rounding import UNIT_ROUNDOFF

GRAVITY, DT = 9.81, 1e-3


class Many:
    """A problem of n contacts and the memory to solve it in; ``given`` are the normal impulses of given forces."""

    def __init__(self, G, c, mu, kinds=None, given=0.0):
        table = np.array([(UNILATERAL, 1)] * len(mu) if kinds is None else kinds)
        self.problem, self.planar = problem_of(table, G, c, mu, mu), new(Planar, n=len(mu), d=1)
        self.problem.normal_impulse[:] = given

    def solve(self, before=None):
        self.problem.previous_P[:] = 0.0 if before is None else before
        solve_by_newton.load()
        found = solve_by_newton(self.problem.address, self.planar.address)
        return found, self.problem.P.copy()

    def residual(self, P):
        self.problem.P[:] = P
        return interpreted(residual)(self.problem, self.planar)


def free_fall(system):
    """G and c of all contacts of a system at rest in one step of free fall."""
    q, u = np.zeros(system.n_q), np.zeros(system.n_u)
    M = np.diag(evaluate(system, MASS, 0.0, q, u))
    rows = np.stack([evaluate(system, NORMAL, 0.0, q, u), evaluate(system, TANGENT, 0.0, q, u)[:, 0]], axis=1)
    W = rows.reshape(-1, system.n_u)
    falls = np.zeros(system.n_u)
    falls[1 :: system.n_u // system.n_c if system.n_u == 2 * system.n_c else 3] = -GRAVITY * DT
    return (W / M) @ W.T, W @ falls, M


@pytest.mark.parametrize("ratio", [1.0, 1e3, 1e6, 1e-6])
@pytest.mark.parametrize("n", [3, 10, 30])
def test_boxes_carry_what_stands_on_them(n, ratio):
    """Two corners share the weight of a box and all above it evenly; only the sum of their friction is determined."""
    G, c, M = free_fall(stack(n, Tower(ratio=ratio ** (1 / (n - 1)))))
    found, P = Many(G, c, np.full(2 * n, 0.3)).solve()
    carried = np.cumsum(M[1::3][::-1])[::-1] * GRAVITY * DT
    assert found
    # the residual, at most 2 ACCEPTED_RESIDUAL of the velocity of the fall, acts on the mass above over that of the
    # lightest box
    error = 2 * ACCEPTED_RESIDUAL * carried.max() * max(1.0, M[0] / M[-3], M[-3] / M[0])
    assert np.abs(P[0::4] + P[2::4] - carried).max() <= error
    assert np.abs(P[1::4] + P[3::4]).max() <= error


def random_pile(seed, n, bodies, mu):
    """Contacts with random normals, mostly upwards, between bodies or with the ground; masses over a factor of 400."""
    rng = np.random.default_rng(seed)
    W = np.zeros((2 * n, 3 * bodies))
    for k in range(n):
        below, above = sorted(rng.choice(bodies + 1, 2, replace=False) - 1)
        angle = 0.5 * rng.normal()
        for row, (x, y) in ((2 * k, (np.sin(angle), np.cos(angle))), (2 * k + 1, (np.cos(angle), -np.sin(angle)))):
            for body, sign in ((above, 1), (below, -1)):
                if body >= 0:
                    a, b = 0.3 * rng.normal(size=2)
                    W[row, 3 * body : 3 * body + 3] = np.multiply(sign, (x, y, a * y - b * x))
    inverse = np.repeat(np.exp(rng.uniform(-3, 3, bodies)), 3)
    u = 0.1 * rng.normal(size=3 * bodies)
    u[1::3] -= 0.1
    return (W * inverse) @ W.T, W @ u, np.full(n, mu)


def violations(G, c, mu, P):
    """Of the inclusions of unilateral contacts, written without the library."""
    gamma, D = G @ P + c, np.diag(G)
    R = mu * np.maximum(P[::2], 0.0)
    friction = P[1::2] - np.clip(P[1::2] - gamma[1::2] / D[1::2], -R, R)
    return np.concatenate((np.minimum(D[::2] * P[::2], gamma[::2]), D[1::2] * friction))


def test_piles_of_random_bodies_end_in_solutions():
    solved = 0
    for seed in range(40):
        G, c, mu = random_pile(seed, 24, 10, 0.5)
        found, P = Many(G, c, mu).solve()
        solved += found
        assert not found or np.abs(violations(G, c, mu, P)).max() <= 1.01 * ACCEPTED_RESIDUAL * np.abs(c).max()
    assert solved >= 38  # the ladder goes on to Gauss-Seidel with the others


@pytest.mark.parametrize("seed", range(10))
def test_velocities_without_friction_are_those_of_the_convex_programme(seed):
    """They are unique: the velocity of least distance to the free one in the kinetic metric."""
    G, c, mu = random_pile(seed, 20, 8, 0.0)
    found, P = Many(G, c, mu).solve()
    other = ns.solve_lcp(G[::2, ::2], c[::2])
    assert found and other.success
    apart = np.abs(G[::2, ::2] @ (P[::2] - other.z)).max()
    assert apart <= 1e-7 * np.abs(c).max()  # both residuals, 1e-9 and 1e-8 at most, may share a small eigenvalue


def test_mixed_kinds_of_contact_have_a_solution_of_the_enumeration():
    """Unilateral, bilateral, without friction, and friction under a given force, in one problem."""
    kinds = [(UNILATERAL, 1), (BILATERAL, 1), (UNILATERAL, 0), (GIVEN_FORCE, 1), (BILATERAL, 0)]
    mu, given, several = np.array([0.4, 0.3, 0.0, 0.5, 0.0]), np.array([0.0, 0, 0, 0.7, 0]), 0
    for seed in range(40):
        rng = np.random.default_rng(seed)
        W, c = rng.normal(size=(7, 9)), rng.normal(size=7)
        G = W @ W.T
        found, P = (many := Many(G, c, mu, kinds, given)).solve()
        tree = new(Tree, n=5, r=7)
        enumerate_modes.load()
        count, _ = enumerate_modes(many.problem.address, tree.address)
        assert found == (count > 0)
        several += count > 1
        if found:
            nearest = min(np.abs(G @ (P - Q[:7])).max() for Q in tree.solutions[:count])
            assert nearest <= 1e-8 * np.abs(c).max()


def test_impulses_of_the_step_before_are_kept_where_they_still_hold():
    """Redundant friction may be shared in many ways: the way of the step before is taken."""
    n = 12
    G, c, _ = free_fall(stack(n, Tower()))
    many = Many(G, c, np.full(2 * n, 0.3))
    _, P = many.solve()
    shared = P.copy()
    shared[1::4] += 1e-4  # to the left corner what the right one gives
    shared[3::4] -= 1e-4
    found, Q = many.solve(shared.reshape(-1, 2))
    assert found and np.abs(Q - shared).max() <= 1e-9 * np.abs(P).max()


def test_interpreted_source_takes_the_same_steps():
    G, c, _ = free_fall(stack(4, Tower(ratio=10.0)))
    compiled, twin = Many(G, c, np.full(8, 0.3)), Many(G, c, np.full(8, 0.3))
    found, P = interpreted(solve_by_newton)(twin.problem, twin.planar), twin.problem.P
    both, Q = compiled.solve()
    assert found and both
    assert np.abs(P - Q).max() <= 1e-12 * np.abs(Q).max()


def test_what_is_put_down_to_rounding_is_less_than_rounding_in_exact_arithmetic():
    """A tower whose head weighs a million times its foot: rounding alone leaves more than ACCEPTED."""
    n = 50
    G, c, _ = free_fall(tower(n, Tower(ratio=1e6 ** (1 / (n - 1)))))
    found, P = (many := Many(G, c, np.full(n, 0.3))).solve()
    assert found
    scale, r = Fraction(float(np.abs(c).max())), 2 * n
    exact = [[Fraction(float(x)) for x in row] for row in G]
    for k in range(0, r, 2):  # every contact is closed: gamma_N = 0
        terms = [g * Fraction(float(p)) for g, p in zip(exact[k], P, strict=True)]
        gamma, size = sum(terms) + Fraction(float(c[k])), sum(map(abs, terms)) + abs(Fraction(float(c[k])))
        assert abs(gamma) <= max(
            Fraction(1e-9) * scale, 2 * (r + 1) * Fraction(UNIT_ROUNDOFF) * size
        )  # 2: gamma is rounded too


def test_a_violation_that_is_not_rounding_is_not_accepted():
    n = 50
    G, c, _ = free_fall(tower(n, Tower(ratio=1e6 ** (1 / (n - 1)))))
    _, P = (many := Many(G, c, np.full(n, 0.3))).solve()
    assert many.residual(P) <= ACCEPTED_RESIDUAL
    off = P.copy()
    off[0] *= 1 + 1e-12  # a hundred times the rounding of the sum
    assert many.residual(off) > ACCEPTED_RESIDUAL


def test_a_jammed_particle_has_no_solution_with_huge_impulses():
    """Two opposite walls close in: impulses of 2e15 leave their speed as it is, and have a rounding greater than it."""
    G, c = np.array([[1.0, -1], [-1, 1]]), np.array([-1.0, -1.0])
    kinds = [(UNILATERAL, 0)] * 2
    many = Many(G, c, np.zeros(2), kinds)
    assert 1.0 < 3 * UNIT_ROUNDOFF * 4e15 and many.residual(np.full(2, 2e15)) == 1.0
    found, _ = many.solve()
    assert not found


def test_only_scenes_of_many_contacts_load_it():
    loaded = [exceeds_enumeration(tower(n, Tower())) for n in (1, 2, 8, 9)]
    assert loaded == [False, False, False, True]
