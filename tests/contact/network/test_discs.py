"""Rows of discs: the same sweeps as by the rows of the network, and only where these are of discs; the few swept."""

import numpy as np
import pytest

from nonsmooth.contact.network.conjugate import conjugate_sweeps
from nonsmooth.contact.network.patience import LONG_SWEEPS
from nonsmooth.contact.network.problem import Network, island_velocities, prepare_network
from nonsmooth.contact.network.round_sweeps import are_round, round_sweeps
from nonsmooth.contact.network.solve import (
    PAYING_SWEEPS,
    SWEEPS_WHERE_DEEP,
    Solver,
    fastest_approach,
    solve_network,
)
from nonsmooth.jit import interpreted, kernel
from nonsmooth.jit.blocks import view
from tests.contact.network.problems import copy_of, heap, judge, pyramid
from tests.contact.network.test_solve import prepare, said, solve, solver_of


def unlike_discs(seed=0):
    """Discs of several weights in a shaft that moves along and turns, some contacts with a conveyor."""
    rng = np.random.default_rng(seed)
    network = heap(40, 2, seed=seed)
    share = rng.uniform(0.2, 5.0, 40)[:, None, None]
    network.M[:40] *= share
    network.M_inv[:40] /= share
    network.v_free[40] = 0.02, -0.01, 0.3
    network.b[:, 1] = rng.normal(size=network.n_c) * 0.01
    network.mu[:] = rng.choice([0.0, 0.3, 1.0], network.n_c)
    prepare(network)
    return network


def over_relaxed(network, **options):
    """A solver that sweeps discs over-relaxed."""
    solver = solver_of(network, **options)
    solver.over_relaxation = 1.4
    return solver


def has_rows(solver):
    return bool(np.any(solver.rows.contact))


@kernel("int64(int64, int64, int64, float64)")
def sweep_discs(network_at, solver_at, most, omega):
    """Sweep all islands by rows of discs; how many islands had no such rows."""
    network, solver, refused = view(network_at, Network), view(solver_at, Solver), 0
    for k in range(network.islands.count):
        island_velocities(network, k, 2, 3)
        if are_round(network, solver.rows, k, 2):
            round_sweeps(network, solver.rows, solver.conjugate, k, most, 0.0, omega, 2)
        else:
            refused += 1
    return refused


@kernel("void(int64, int64, int64)")
def sweep_planar_rows(network_at, solver_at, most):
    """Conjugate sweeps of all islands by the rows of the network."""
    network, solver = view(network_at, Network), view(solver_at, Solver)
    for k in range(network.islands.count):
        island_velocities(network, k, 2, 3)
        conjugate_sweeps(network, solver.conjugate, k, most, 0.0, 2, 3)


@pytest.mark.parametrize("sweeps", [1, 9, 40])
@pytest.mark.parametrize("scene", [lambda: heap(40, 2, seed=5), unlike_discs])
def test_conjugate_sweeps_are_those_of_the_rows_of_the_network(scene, sweeps):
    network = scene()
    twin = copy_of(network)
    prepare_network(twin.address, 2)
    solver, other = solver_of(network), solver_of(twin)
    assert sweep_discs(network.address, solver.address, sweeps, 1.0) == 0
    sweep_planar_rows(twin.address, other.address, sweeps)
    judge(network), judge(twin)
    # a sweep adds some ten roundings to each impulse, and later ones do not enlarge them: they converge
    assert np.abs(network.P - twin.P).max() <= 1e-13 * np.abs(twin.P).max() and np.abs(twin.P).max() > 0.0
    assert np.abs(network.v - twin.v).max() <= 1e-13 * np.abs(twin.v).max()


@pytest.mark.parametrize("scene", [lambda: heap(60, 2, seed=3), unlike_discs])
def test_over_relaxed_sweeps_and_factors_come_to_the_same_velocities(scene):
    network = scene()
    twin = copy_of(network)
    solver = over_relaxed(network, tol=1e-12, most_sweeps=5000, most_factors=0)
    assert solve(network, solver) == 0 and judge(network) <= 1e-12 and has_rows(solver)
    prepare(twin)
    assert solve(twin, solver_of(twin, tol=1e-12, most_sweeps=0, most_factors=200)) == 0 and judge(twin) <= 1e-12
    assert np.abs(network.v - twin.v).max() <= 1e-9 * np.abs(twin.v).max()


def test_over_relaxed_sweeps_come_to_the_solution_in_fewer():
    shares = []
    for seed in range(7):  # in some heaps one contact changes its mode so late that both are as far
        residuals = []
        for omega in (1.0 + 1e-9, 1.4):  # 1 is that of conjugate sweeps
            network = heap(60, 2, seed=seed)
            assert sweep_discs(network.address, solver_of(network).address, 60, omega) == 0
            residuals.append(judge(network))
        shares.append(residuals[1] / residuals[0])
    assert np.median(shares) < 0.5


def test_contacts_that_close_between_two_sweeps_of_all_are_not_missed():
    """From no impulses the first sweeps leave open what the blows of later ones close."""
    for seed in range(5):
        network = heap(50, 2, seed=seed, speed=1.0)
        solver = over_relaxed(network, tol=1e-11, most_sweeps=3000, most_factors=0)
        assert solve(network, solver) == 0 and judge(network) <= 1e-11
        assert (network.P[:, 0] == 0.0).any()


@pytest.mark.parametrize("n, mu", [(60, 2.0), (300, 1.0)])
def test_impacts_of_rough_discs_are_solved_but_for_a_few(n, mu):
    """Half of them were not, however long they were swept: three discs that touch one another, two contacts sliding and
    one sticking, went round for ever over-relaxed, and conjugate sweeps after that did not end it."""
    solved = 0
    for seed in range(12):
        network = heap(n, 2, seed=seed, mu=mu, speed=1.0)
        solve(network, over_relaxed(network, tol=1e-10, most_sweeps=4000, most_factors=0))
        solved += judge(network) <= 1e-10
    assert solved >= 10


def test_sweeps_go_on_beyond_the_budget_only_while_the_tolerance_is_in_sight():
    network = heap(60, 2, seed=1)
    needed = over_relaxed(network, tol=1e-8, most_sweeps=1000, most_factors=0)
    solve(network, needed)
    most = int(0.6 * max(said(network, "sweeps")))
    network = heap(60, 2, seed=1)
    solve(network, over_relaxed(network, tol=1e-8, most_sweeps=most, most_factors=0))
    assert min(said(network, "is_met")) == 1 and most < max(said(network, "sweeps")) <= PAYING_SWEEPS * most
    network = heap(400, 2, seed=1)
    solve(network, over_relaxed(network, tol=1e-14, most_sweeps=12, most_factors=0))
    assert max(said(network, "sweeps")) == 12 and min(said(network, "is_met")) == 0


def not_of_discs(what):
    """A heap of discs with one row or one inertia that is of no disc."""
    network = heap(8, 2)
    c = int(np.argmax((network.i < 8) & (network.j < 8)))
    if what == "arm":
        network.J_i[c, 0, 2] += 1e-9
    elif what == "frame":
        network.J_j[c, 1, :2] *= 1.0 + 1e-9
    elif what == "frames of two bodies":
        network.J_i[c, :, :2] *= 1.0 + 1e-9
    else:
        network.M[3, 0, 1] = network.M[3, 1, 0] = 1e-9
        network.M_inv[3] = np.linalg.inv(network.M[3])
    prepare(network)
    return network


@pytest.mark.upkeep
@pytest.mark.parametrize("scene", [lambda: heap(400, 2, speed=1.0), lambda: heap(216, 3, speed=1.0)])
def test_sweeps_go_on_while_bodies_approach_faster_than_they_should(scene):
    """Ten sweeps leave an approach that is 20 times the one asked for; where none is asked for it stays."""

    def left(approach):
        network = scene()
        solver = over_relaxed(network, tol=1e-12, most_sweeps=10, most_factors=0)
        solver.approach, solver.patience.left[LONG_SWEEPS] = approach, 2
        solve(network, solver)
        count = network.islands.count
        assert (judge(network) == network.islands.residual[:count]).all() and count == 1
        return interpreted(fastest_approach)(network, 0, network.v.shape[1]), said(network, "sweeps")[0]

    fastest, sweeps = left(0.0)
    assert sweeps == 10 and left(2.0 * fastest) == (fastest, 10)
    slow, more = left(0.05 * fastest)
    assert slow <= 0.05 * fastest and 10 < more <= 10 * SWEEPS_WHERE_DEEP
    assert left(1e-9 * fastest)[1] == 10 * SWEEPS_WHERE_DEEP


@pytest.mark.parametrize("what", ["arm", "frame", "frames of two bodies", "inertia"])
def test_what_is_no_disc_by_little_is_swept_by_its_own_rows(what):
    network = not_of_discs(what)
    assert sweep_discs(network.address, solver_of(network).address, 1, 1.0) > 0


def test_squares_are_no_discs():
    network = pyramid(4)
    solver = solver_of(network, most_sweeps=3, most_factors=0)
    solve(network, solver)
    assert not has_rows(solver)


@pytest.mark.parametrize("omega", [0.0, 1.4])
def test_kernels_have_the_same_bits_interpreted(omega):
    network = unlike_discs(1)
    twin = copy_of(network)
    solver, other = (solver_of(network, tol=1e-15, most_sweeps=14, most_factors=0) for _ in range(2))
    solver.over_relaxation = other.over_relaxation = omega
    assert solve(network, solver) == interpreted(solve_network)(twin, other, other.direct.desk, 2) == 0
    assert has_rows(solver)
    assert (network.words.view(np.int64) == twin.words.view(np.int64)).all()
