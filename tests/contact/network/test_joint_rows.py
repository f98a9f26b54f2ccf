"""Joints among the contacts of a network: every solver finds the same, and it is that of the dense equations."""

import numpy as np
import pytest

from nonsmooth.contact.network.al_newton import MET, begin_direct, solve_by_al_newton
from nonsmooth.contact.network.eliminated import without_joints
from nonsmooth.contact.network.joint import JOINED, solve_joint
from nonsmooth.contact.network.matrices import matrices_of
from nonsmooth.contact.network.problem import prepare_network
from nonsmooth.contact.network.rescue import rescue
from nonsmooth.contact.network.spheres import are_spheres
from nonsmooth.jit import interpreted
from tests.contact.network.problems import STEP, assembled, box_mass, copy_of, falling, judge, network_of
from tests.contact.network.test_network import sweep
from tests.contact.network.test_solve import said, solve, solver_of

HALF, LINKS = 0.1, 6


def hanging_bridge(dim, is_free=False, is_hooked=True):
    """Boxes in a row, each joined to the next, the ends to what is fixed; in the middle a floor just below.

    The floor is touched, or not there, and so are the joints at the ends; body 0 is what is fixed.
    """
    rng = np.random.default_rng(3)
    x = np.zeros((LINKS + 1, dim))
    x[1:, 0] = 2 * HALF * np.arange(LINKS)
    x[1:, -1] = rng.uniform(-0.2, 0.2, LINKS) * HALF
    points = np.zeros((LINKS + 1, dim))
    points[:, 0] = HALF * (2 * np.arange(LINKS + 1) - 1)
    first = np.eye(dim)[0]
    contacts = []
    for k in (3, 4):
        below = x[k] - HALF * np.eye(dim)[-1]
        contacts.append((0, k, np.eye(dim)[-1], below + 0.3 * HALF * first, 0.0))
    contacts = [] if is_free else contacts
    n = len(contacts)
    joined = range(LINKS + 1) if is_hooked else range(1, LINKS)
    contacts += [(k, (k + 1) % (LINKS + 1), first, points[k], 0.0) for k in joined]
    M = [box_mass(HALF, dim)] * (LINKS + 1)
    v_free = falling(LINKS + 1, dim, (0,))
    v_free[1:] += rng.normal(size=v_free[1:].shape) * 0.1 * STEP
    network = network_of(x, M, v_free, contacts, 0.5, (0,))
    network.mu[n:] = JOINED
    prepare_network(network.address, dim)
    return network


def dense_joints(network):
    """The impulses where there are joints only."""
    problem = assembled(network)
    return -np.linalg.lstsq(problem.G, problem.c, rcond=1e-12)[0].reshape(network.P.shape)


def velocities_without_joint(network):
    """Relative velocities of the joints, from the impulses alone."""
    judge(network)
    is_joint = network.mu == JOINED
    return network.gamma[is_joint]


@pytest.mark.parametrize("dim", [2, 3])
def test_joints_alone_are_a_linear_problem(dim):
    network = hanging_bridge(dim, is_free=True)
    assert solve(network, tol=1e-12) == 0
    found = network.v.copy()
    network.P[:] = dense_joints(network)  # along the bridge, which is straight, there is one row too many
    assert judge(network) <= 1e-12
    np.testing.assert_allclose(found, network.v, atol=1e-10 * np.abs(network.v_free).max())


@pytest.mark.parametrize("dim", [2, 3])
def test_sweeps_factors_and_elimination_agree(dim):
    sweeps, direct, dense = (hanging_bridge(dim) for _ in range(3))
    sweep(sweeps, 20_000, 1e-15)
    solver = solver_of(direct)
    begin_direct(direct.address, solver.direct.address)
    assert solve_by_al_newton(direct.address, solver.direct.address, 0, 1e-13, 200, dim) == MET
    dense.islands.residual[0] = judge(dense)
    rescue(dense, solver_of(dense), 1e-10)
    assert dense.islands.is_met[0] == 1
    assert (direct.P[:2, 0] > 0.0).any()  # the floor bears some of it
    size = np.abs(direct.P).max()
    for other in (sweeps, dense):
        assert judge(other) <= 1e-9
        np.testing.assert_allclose(other.v, direct.v, atol=1e-8 * size * direct.M_inv.max())
    assert np.abs(velocities_without_joint(direct)).max() <= 1e-12


@pytest.mark.parametrize("dim", [2, 3])
def test_ladder_does_nothing_when_it_is_called_again(dim):
    network = hanging_bridge(dim)
    assert solve(network, tol=1e-6) == 0 and network.islands.is_met[0] == 1
    P = network.P.copy()
    prepare_network(network.address, dim)
    assert solve(network, tol=1e-6) == 0
    np.testing.assert_array_equal(network.P, P)


@pytest.mark.parametrize("dim", [2, 3])
def test_matrices_for_other_programs_have_the_contacts_alone(dim):
    network = hanging_bridge(dim)
    solve(network, tol=1e-12)
    G, c, mu, P, d = matrices_of(network, np.arange(network.n_c))
    assert G.shape == (2 * dim, 2 * dim) and (mu >= 0.0).all() and d == dim
    judge(network)
    np.testing.assert_allclose(G @ P + c, network.gamma[:2].ravel(), atol=1e-10 * np.abs(c).max())


def test_elimination_takes_rows_that_joints_say_twice():
    rng = np.random.default_rng(0)
    J = rng.normal(size=(7, 9))
    J[6] = J[5] + J[4]  # three of joints, one of them twice
    G, c = J @ J.T, J @ rng.normal(size=9)
    is_joint = np.arange(7) > 3
    left = without_joints(G, c, is_joint)
    P = np.zeros(7)
    P[:4] = rng.normal(size=4)
    P[4:] = left.joints(P[:4])
    gamma = G @ P + c
    np.testing.assert_allclose(gamma[4:], 0.0, atol=1e-12 * np.abs(G).max())
    np.testing.assert_allclose(left.G @ P[:4] + left.c, gamma[:4], atol=1e-12 * np.abs(G).max())


@pytest.mark.parametrize("dim", [2, 3])
def test_one_joint_is_solved_by_its_factors_interpreted_and_compiled(dim):
    rng = np.random.default_rng(1)
    A = rng.normal(size=(dim, 5))
    W, b = (A @ A.T)[None], rng.normal(size=dim)
    said = interpreted(solve_joint)(W, 0, *b, *([0.0] if dim == 2 else []), dim)
    np.testing.assert_allclose(said[:dim], -np.linalg.solve(W[0], b), rtol=1e-10)
    assert dim == 3 or said[2] == 0.0


def test_a_joint_of_balls_is_not_swept_as_a_contact_of_spheres():
    # its arms lie along its first axis, so that its rows are those of two spheres which touch there
    x, first = [(0.0, 0, 0), (2 * HALF, 0, 0)], (1.0, 0, 0)
    M = [np.diag([1.0] * 3 + [0.004] * 3)] * 2
    v_free = np.array([[0.0, 0, 0, 0, 0, 0], [1.0, 0.5, 0, 0, 0, 0]])
    network = network_of(x, M, v_free, [(0, 1, first, (HALF, 0, 0), 0.0)], 0.5)
    spheres = solver_of(network).rows
    assert interpreted(are_spheres)(network, spheres, 0)
    network.mu[:] = JOINED
    assert not interpreted(are_spheres)(network, spheres, 0)
    assert solve(copy_of(network), tol=1e-12) == 0
    assert solve(network, tol=1e-12) == 0 and network.P[0, 0] < 0.0  # it pulls


@pytest.mark.parametrize("dim", [2, 3])
def test_joints_of_bodies_that_fly_freely_are_solved_by_no_impulse(dim):
    network = hanging_bridge(dim, is_free=True, is_hooked=False)
    network.v_free[1:] = np.concatenate((np.linspace(0.1, 3.3, dim), np.zeros(2 * dim - 3)))
    prepare_network(network.address, dim)
    assert judge(network) == 0.0
    assert solve(network, tol=1e-12) == 0 and set(said(network, "is_met")) == {1}
    assert not network.P.any()
