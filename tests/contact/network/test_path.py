"""Paths of smoothed problems: the equations by dense matrices, the folds, and the packings that they lead to."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import sparse

from benchmarks.problems import FAMILIES
from nonsmooth.contact.blocks.problem import check_problem
from nonsmooth.contact.blocks.solve import solve_contact
from nonsmooth.contact.network import path as paths
from nonsmooth.contact.network.given import network_of
from nonsmooth.contact.network.path import Direction, Path, Returns, follow, follow_paths
from nonsmooth.contact.network.rounds import Rounds, solve_in_rounds
from nonsmooth.contact.network.smoothed import ROUNDING_OF_SLIP


def case_of(size, seed, family="packing", mu=None, noise=0.1):
    more = {"noise": noise} if family == "packing" else {}
    case = FAMILIES[family](np.random.default_rng([seed, size, 3]), size, 3, **more)
    if mu is not None:
        case.mu[:] = mu
        case.given.mu[:] = mu
    return case


def rounds_of(problem, order=None):
    H, w, mu = problem.H.tocsc(), problem.w, problem.mu
    if order is not None:
        rows = (3 * order[:, None] + np.arange(3)).ravel()
        H, w, mu = H[:, rows], w[rows], mu[order]
    rounds = Rounds(network_of(problem.M, H, problem.f, w, mu))
    rounds.factorise()
    return rounds


def path_of(case):
    return Path(rounds_of(case.given), 0)


def until_smoothing(t):
    """An attempt that ends the path there."""
    return lambda path: path.s <= math.log(t)


def dense(path, case):
    """G, c and S of the path's contacts in its units, by the assembled problem."""
    G, unit = case.G.toarray() * path.point.P_unit / path.point.v_unit, path.point.v_unit
    scale = np.ones((len(case.mu), 3))
    scale[:, 0] = case.mu
    return G, case.c / unit, scale.ravel()


def smoothed_y(gamma, mu, t):
    a = gamma[:, 0] / mu + paths.PATH_OPENING * t**2
    y = gamma.copy()
    y[:, 0] = a + np.sqrt((gamma[:, 1:] ** 2).sum(axis=1) + (ROUNDING_OF_SLIP * a) ** 2)
    return y


def settled(case, steps=12):
    """A path some steps from its start, corrected to rounding."""
    path = path_of(case)
    tangent, length = path.settle(), paths.FIRST_LENGTH
    for _ in range(steps):
        tangent, length = path.advance(tangent, length, 1e-9)
    return path, tangent


def test_a_point_of_the_path_obeys_the_smoothed_equations_of_the_assembled_problem():
    case = case_of(60, 0)
    path, _ = settled(case)
    G, c, scale = dense(path, case)
    x, y, t = path.point.x, path.point.y, math.exp(path.s)
    gamma = (G @ (x.ravel() / scale) + c).reshape(-1, 3)
    np.testing.assert_allclose(y, smoothed_y(gamma, case.mu, t), atol=1e-9 * np.abs(y).max())
    product = np.column_stack([(x * y).sum(axis=1), x[:, :1] * y[:, 1:] + y[:, :1] * x[:, 1:]])
    np.testing.assert_allclose(product, t * np.eye(1, 3) * np.ones((len(x), 1)), atol=1e-8 * t)
    assert (np.hypot(x[:, 1], x[:, 2]) < x[:, 0]).all() and (np.hypot(y[:, 1], y[:, 2]) < y[:, 0]).all()


def test_the_derivative_along_the_path_is_of_first_order():
    """Off the path by h^2 after a step h of it: half the step, a quarter of the correction."""
    path, _ = settled(case_of(60, 1))
    assert path.linearise()
    along, place, sizes = path.derivative(), path.place(), []
    for h in (1e-2, 5e-3, 2.5e-3):
        path.go_to(place)
        path.move(along, h)
        assert path.linearise()
        sizes.append(path.size(path.correction()))
    ratios = np.array(sizes[:-1]) / sizes[1:]
    np.testing.assert_allclose(ratios, 4.0, rtol=0.1)


def test_the_sign_of_the_determinant_is_that_of_the_dense_system():
    """det(I + G S^-1 W^2 C_) = det(M + J^T S^-1 W^2 C_ J) / det(M), from W as a matrix."""
    case = case_of(40, 0)
    path = path_of(case)
    network, factor = path.rounds.network, path.rounds.solver.direct.factor
    signs, tangent, length = [], path.settle(), paths.FIRST_LENGTH
    for _ in range(25):
        tangent, length = path.advance(tangent, length, paths.CORRECTED)
        assert path.linearise()
        G, _, scale = dense(path, case)
        product = np.eye(3 * len(case.mu))
        for c, (w_N, w_1, w_2, eta) in enumerate(path.point.w):
            w, J = np.array([w_N, w_1, w_2]), np.diag([1.0, -1.0, -1.0])
            C = np.eye(3)
            C[0] = path.point.C[c]
            part = slice(3 * c, 3 * c + 3)
            product[:, part] += G[:, part] @ (eta**2 * (2 * np.outer(w, w) - J) @ C / scale[part, None])
        sign, size = np.linalg.slogdet(product)
        inverses = np.linalg.slogdet(factor.D[path.bodies].reshape(-1, 6, 6))[1]
        masses = np.linalg.slogdet(network.M[factor.columns.body[path.bodies]])[1]
        assert path.sign_of_determinant() == sign
        assert size == pytest.approx(-inverses.sum() - masses.sum(), rel=1e-6)
        signs.append(sign)
    assert signs[0] == 1.0


def test_at_its_start_the_path_goes_towards_the_problem():
    path = path_of(case_of(100, 0))
    tangent = path.settle()
    assert tangent.step.s < 0.0 and path.sign_of_determinant() == 1.0
    assert tangent.form.dot(tangent.step) == pytest.approx(1.0, rel=1e-12)


def test_velocities_of_little_friction_are_those_of_dense_interior_points():
    """With little friction velocities are unique; the smoothed ones are off by sqrt(2 n_c t) in the norm of energy."""
    case, t = case_of(100, 1, mu=0.01), 1e-8
    path = path_of(case)
    assert follow(path, 500, math.inf, until_smoothing(t))
    found = solve_contact(*case, tol=1e-10)
    gamma = case.G @ path_impulses(path, len(case.c)) + case.c
    G_size = np.abs(case.G).sum(axis=1).max() * path.point.P_unit / path.point.v_unit
    bound = path.point.v_unit * math.sqrt(2.0 * len(case.mu) * G_size * t)
    assert found.success and np.abs(gamma - found.gamma).max() <= bound <= 0.02 * np.abs(case.c).max()


def path_impulses(path, n):
    P = np.zeros((n // 3, 3))
    P[path.contacts] = path.impulses()
    return P.ravel()


def test_contacts_in_another_order_have_the_same_path():
    case = case_of(60, 2)
    order = np.random.default_rng(3).permutation(len(case.mu))
    first, other = path_of(case), Path(rounds_of(case.given, order), 0)
    ends = []
    for path in (first, other):
        tangent = path.settle()
        for _ in range(20):
            tangent, _ = path.advance(tangent, 0.3, 1e-10)
        ends.append((path_impulses(path, len(case.c)).reshape(-1, 3), path.s))
    assert ends[1][1] == pytest.approx(ends[0][1], abs=1e-7)
    np.testing.assert_allclose(ends[1][0], ends[0][0][order], atol=1e-6 * np.abs(ends[0][0]).max())


@pytest.mark.parametrize("noise", [0.1, 0.0])
@pytest.mark.parametrize("size, seed", [(100, 1), (100, 2), (100, 3), (300, 0), (300, 2)])
def test_paths_solve_packings_that_sweeps_and_factors_may_leave(size, seed, noise):
    case = case_of(size, seed, noise=noise)
    rounds = rounds_of(case.given)
    assert rounds.least > 1e-6
    follow_paths(rounds, 1e-8, math.inf)
    found = rounds.end()
    assert found.error <= 1e-8 and check_problem(*case).error(found.P) <= 1e-8
    assert found.sweeps == 0


def test_packings_that_do_not_touch_have_a_path_each(monkeypatch):
    cases = [case_of(100, seed) for seed in (1, 2)]
    M, H = (sparse.block_diag([getattr(case.given, name) for case in cases], format="csc") for name in "MH")
    parts = (np.concatenate([getattr(case.given, name) for case in cases]) for name in ("f", "w", "mu"))
    problem, followed = type(cases[0].given)(M, H, *parts, 3), []
    rounds = rounds_of(problem)
    monkeypatch.setattr(
        paths, "follow", lambda path, *more: followed.append(path.contacts.tolist()) or follow(path, *more)
    )
    follow_paths(rounds, 1e-8, math.inf)
    P, n = rounds.end().P, len(cases[0].mu)
    assert followed == [list(range(n)), list(range(n, len(problem.mu)))]
    for case, part in zip(cases, np.split(P, [3 * n]), strict=True):
        assert check_problem(*case).error(part) <= 1e-8


@pytest.mark.parametrize("size, seed", [(100, 0), (100, 4), (140, 3)])
def test_a_path_is_followed_through_its_folds(size, seed):
    """It turns back in t, where one that only falls would end, and comes on."""
    path = path_of(case_of(size, seed))
    tangent, length, forward = path.settle(), paths.FIRST_LENGTH, []
    while path.s > math.log(1e-5) and len(forward) < 300:
        tangent, length = path.advance(tangent, length, 1e-4)
        forward.append(tangent.step.s < 0.0)
    assert path.s <= math.log(1e-5)
    turns = np.count_nonzero(np.diff(forward))
    assert turns >= 2 and turns % 2 == 0 and forward[0] and forward[-1]


def test_mirrored_packings_are_solved_too():
    """x -> -x: frames turn into left-handed ones, which networks of spheres turn back."""
    case = case_of(100, 2)
    mirror = np.tile([-1.0, 1.0, 1.0, 1.0, -1.0, -1.0], len(case.given.f) // 6)
    given = case.given
    problem = type(given)(given.M, mirror[:, None] * given.H.toarray(), mirror * given.f, given.w, given.mu, 3)
    result = problem.solve()
    assert result.success and result.solver == "network"
    assert check_problem(*case).error(result.P) <= 1e-8  # impulses of a mirrored frame are those of the frame


def smooth(case):
    """One contact without friction: its cone is a half-line."""
    case.given.mu[0] = 0.0
    return case


def test_nothing_is_followed_in_walls_without_friction_in_large_packings_nor_when_the_time_is_up():
    large = case_of(1000, 0)
    assert len(large.mu) > paths.MOST_PATH_CONTACTS
    walls, smooths, late = case_of(100, 0, "wall"), smooth(case_of(100, 1)), case_of(300, 1)
    for case, until in ((walls, math.inf), (smooths, math.inf), (large, math.inf), (late, 0.0)):
        rounds = Rounds(network_of(case.given.M, case.given.H, case.given.f, case.given.w, case.given.mu))
        rounds.sweep(5, 1e-8)
        before, factors = rounds.least, rounds.factors
        follow_paths(rounds, 1e-8, until)
        assert (rounds.least, rounds.factors) == (before, factors)


def test_a_path_that_is_cut_short_leaves_the_best_impulses(monkeypatch):
    monkeypatch.setattr(paths, "MOST_PATH_FACTORS", 120)
    rounds = solve_in_rounds(rounds_of(case_of(300, 1).given).network, 1e-8)
    before = rounds.least
    follow_paths(rounds, 1e-8, math.inf)
    assert rounds.measured_error(rounds.rho) == rounds.least <= before
    assert (rounds.network.P == rounds.best).all()


def test_a_path_goes_back_farther_each_time_and_forgets_that_when_it_is_through():
    returns, nothing = Returns(), SimpleNamespace()
    for s in range(100):
        returns.remember(Direction(None, None, None, float(s)), nothing)
    assert [returns.go_back()[0].s for _ in range(3)] == [96.0, 90.0, 78.0]
    assert returns.level == 3 and returns.fine == 4 * (paths.FINE_STEPS + paths.STEPS_BACK)
    for s in range(returns.fine + paths.RECOVERY):
        assert returns.level == 3
        returns.remember(Direction(None, None, None, 100.0 + s), nothing)
    assert returns.level == 0 and returns.fine == 0
