"""Rows of spheres: the same sweeps as by the rows of the network, and only where these are of spheres."""

import numpy as np
import pytest

from nonsmooth.contact.network.conjugate import conjugate_sweeps
from nonsmooth.contact.network.problem import Network, island_velocities, prepare_network
from nonsmooth.contact.network.round_sweeps import are_round, round_sweeps
from nonsmooth.contact.network.solve import Solver, solve_network
from nonsmooth.jit import interpreted, kernel
from nonsmooth.jit.blocks import view
from tests.contact.network.problems import copy_of, heap, judge, stack
from tests.contact.network.test_solve import prepare, solve, solver_of


def unlike_spheres(seed=0):
    """Spheres of several weights in a shaft that moves along and turns, some contacts with a conveyor."""
    rng = np.random.default_rng(seed)
    network = heap(40, 3, seed=seed)
    share = rng.uniform(0.2, 5.0, 40)[:, None, None]
    network.M[:40] *= share
    network.M_inv[:40] /= share
    network.v_free[40] = 0.02, -0.01, 0.03, 0.2, -0.1, 0.3
    network.b[:, 1:] = rng.normal(size=(network.n_c, 2)) * 0.01
    network.mu[:] = rng.choice([0.0, 0.3, 1.0], network.n_c)
    prepare(network)
    return network


def mirrored(network):
    """The same problem with the second tangent turned round: a frame that rows of spheres are not made from."""
    twin = copy_of(network)
    for rows in (twin.J_i, twin.J_j, twin.b[:, :, None]):
        rows[:, 2] *= -1.0
    prepare_network(twin.address, 3)
    return twin


def has_rows_of_spheres(solver):
    return bool(np.any(solver.rows.contact))


@kernel("int64(int64, int64, int64, float64)")
def sweep_spheres(network_at, solver_at, most, omega):
    """Sweep all islands by rows of spheres; how many islands had no such rows."""
    network, solver, refused = view(network_at, Network), view(solver_at, Solver), 0
    for k in range(network.islands.count):
        island_velocities(network, k, 3, 6)
        if are_round(network, solver.rows, k, 3):
            round_sweeps(network, solver.rows, solver.conjugate, k, most, 0.0, omega, 3)
        else:
            refused += 1
    return refused


@kernel("void(int64, int64, int64)")
def sweep_rows(network_at, solver_at, most):
    """Conjugate sweeps of all islands by the rows of the network."""
    network, solver = view(network_at, Network), view(solver_at, Solver)
    for k in range(network.islands.count):
        island_velocities(network, k, 3, 6)
        conjugate_sweeps(network, solver.conjugate, k, most, 0.0, 3, 6)


@pytest.mark.parametrize("sweeps", [1, 9, 40])
@pytest.mark.parametrize("scene", [lambda: heap(40, 3, seed=5), unlike_spheres])
def test_conjugate_sweeps_are_those_of_the_rows_of_the_network(scene, sweeps):
    network = scene()
    twin = copy_of(network)
    prepare_network(twin.address, 3)
    solver, other = solver_of(network), solver_of(twin)
    assert sweep_spheres(network.address, solver.address, sweeps, 1.0) == 0
    sweep_rows(twin.address, other.address, sweeps)
    judge(network), judge(twin)
    # a sweep adds some ten roundings to each impulse, and later ones do not enlarge them: they converge
    assert np.abs(network.P - twin.P).max() <= 1e-13 * np.abs(twin.P).max() and np.abs(twin.P).max() > 0.0
    assert np.abs(network.v - twin.v).max() <= 1e-13 * np.abs(twin.v).max()


def test_over_relaxed_sweeps_come_to_the_solution_in_fewer():
    shares = []
    for seed in range(7):  # in some heaps one contact changes its mode so late that both are as far
        residuals = []
        for omega in (1.0 + 1e-9, 1.4):  # 1 is that of conjugate sweeps
            network = heap(60, 3, seed=seed)
            solver = solver_of(network)
            assert sweep_spheres(network.address, solver.address, 60, omega) == 0
            residuals.append(judge(network))
        shares.append(residuals[1] / residuals[0])
    assert np.median(shares) < 0.3 and max(shares) < 1.0


def test_frames_that_turn_the_other_way_are_swept_by_their_own_rows_to_the_same_solution():
    network = unlike_spheres()
    twin = mirrored(network)
    solver, other = (solver_of(network, tol=1e-12, most_sweeps=5000, most_factors=0) for _ in range(2))
    solve(network, solver), solve(twin, other)
    assert has_rows_of_spheres(solver) and not has_rows_of_spheres(other)
    assert np.abs(network.v - twin.v).max() <= 1e-10 * np.abs(twin.v).max()


def test_spheres_are_solved_to_rounding():
    network = unlike_spheres(3)
    solver = solver_of(network, tol=1e-12, most_sweeps=5000, most_factors=0)
    assert solve(network, solver) == 0 and judge(network) <= 1e-12 and has_rows_of_spheres(solver)


def spoilt(what):
    """A heap of spheres with one row or one inertia that is of no sphere."""
    network = heap(8, 3)
    c = int(np.argmax((network.i[:, None] < 8).all(axis=1) & (network.j < 8)))
    if what == "arm":
        network.J_i[c, 0, 4] += 1e-9
    elif what == "other arms of two tangents":
        network.J_j[c, 1, 3:] *= 1.0 + 1e-9
    elif what == "frame":
        network.J_j[c, 1, :3] += 1e-9 * network.J_j[c, 0, :3]
    elif what == "frames of two bodies":
        network.J_i[c, :, :3] *= 1.0 + 1e-9
    else:
        network.M[3, 4, 4] *= 1.0 + 1e-9
        network.M_inv[3] = np.linalg.inv(network.M[3])
    prepare(network)
    return network


@pytest.mark.parametrize("what", ["arm", "other arms of two tangents", "frame", "frames of two bodies", "inertia"])
def test_what_is_no_sphere_by_little_is_swept_by_its_own_rows(what):
    network = spoilt(what)
    solver = solver_of(network, tol=1e-12, most_sweeps=400, most_factors=0)
    twin = copy_of(network)
    solve(network, solver)
    alone = solver_of(twin, tol=1e-12, most_sweeps=0, most_factors=200)
    assert solve(twin, alone) == 0 and judge(twin) <= 1e-12 and judge(network) <= 1e-12
    assert np.abs(network.v - twin.v).max() <= 1e-10 * np.abs(twin.v).max()


def test_boxes_are_no_spheres():
    network = stack(2)
    solver = solver_of(network, most_sweeps=3, most_factors=0)
    solve(network, solver)
    assert not has_rows_of_spheres(solver)


def test_kernels_have_the_same_bits_interpreted():
    network = unlike_spheres(1)
    twin = copy_of(network)
    solver, other = (solver_of(network, tol=1e-15, most_sweeps=6, most_factors=0) for _ in range(2))
    assert solve(network, solver) == interpreted(solve_network)(twin, other, other.direct.desk, 3) == 0
    assert has_rows_of_spheres(solver)
    assert (network.words.view(np.int64) == twin.words.view(np.int64)).all()
