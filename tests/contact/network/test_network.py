"""The problem, its islands and the sweeps, against dense matrices and the solvers of one block matrix."""

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from nonsmooth.contact.blocks.solve import solve_contact
from nonsmooth.contact.network.conjugate import Conjugate, conjugate_sweeps
from nonsmooth.contact.network.problem import (
    Network,
    island_velocities,
    judge_network,
    prepare_network,
)
from nonsmooth.jit import in_dimensions, interpreted, kernel
from nonsmooth.jit.blocks import new, view
from nonsmooth.numerics.rounding import EPS
from tests.contact.network.problems import (
    GRAVITY,
    STEP,
    assembled,
    box_mass,
    copy_of,
    falling,
    heap,
    joined,
    judge,
    network_of,
    pyramid,
    stack,
)

SCENES = {
    "stack": lambda: stack(3),
    "pyramid": lambda: pyramid(4),
    "discs": lambda: heap(30, 2),
    "spheres": lambda: heap(30, 3),
    "without friction": lambda: heap(20, 3, mu=0.0),
}


@kernel
def sweep_islands(network, memory, most, tol, d, n):
    """Sweep each island from the impulses that it has; the sweeps of all together."""
    total = 0
    for k in range(network.islands.count):
        island_velocities(network, k, d, n)
        total += conjugate_sweeps(network, memory, k, most, tol, d, n)
    return total


@in_dimensions("int64(int64, int64, int64, float64)")
def sweep_network(network_at, memory_at, most, tol, d):
    """``sweep_islands`` of a network."""
    return sweep_islands(view(network_at, Network), view(memory_at, Conjugate), most, tol, d, 3 * (d - 1))


def memory_of(network):
    d, n = network.b.shape[1], network.v.shape[1]
    return new(Conjugate, m=len(network.i), n_b=len(network.v), d=d, n=n)


def sweep(network, most, tol=0.0):
    memory = memory_of(network)
    return sweep_network(network.address, memory.address, most, tol, network.b.shape[1])


def natural_map(network):
    """|F| / |P| from the dense matrices, in the words of its definition."""
    dense, P = assembled(network), network.P[: network.n_c]
    d, gamma = dense.dim, (dense.G @ P.ravel() + dense.c).reshape(P.shape)
    total = 0.0
    for c in range(network.n_c):
        W = dense.G[c * d : (c + 1) * d, c * d : (c + 1) * d]
        step = gamma[c] + network.mu[c] * np.linalg.norm(gamma[c, 1:]) * np.eye(d)[0]
        x = P[c] - d / np.trace(W) * step
        x_T = np.linalg.norm(x[1:])
        if x_T > network.mu[c] * x[0]:
            axis = np.array([1.0, *(network.mu[c] * x[1:] / x_T)])
            x = max(axis @ x, 0.0) / (axis @ axis) * axis
        total += np.sum((P[c] - x) ** 2)
    return np.sqrt(total) / np.linalg.norm(P)


@pytest.mark.parametrize("scene", SCENES)
def test_parts_of_the_rows_make_the_delassus_matrix(scene):
    network = SCENES[scene]()
    dense, d = assembled(network), network.b.shape[1]
    network.P[:] = np.random.default_rng(1).normal(size=network.P.shape) * 1e-2
    judge(network)
    gamma = (dense.G @ network.P.ravel() + dense.c).reshape(-1, d)
    assert np.abs(network.gamma - gamma).max() <= 1e3 * EPS * np.abs(network.v).max()
    for c in range(network.n_c):
        block = dense.G[c * d : (c + 1) * d, c * d : (c + 1) * d]
        assert np.abs(network.W[c] - block).max() <= 10 * EPS * np.abs(block).max()


@pytest.mark.parametrize("scene", SCENES)
def test_residual_is_that_of_the_definition(scene):
    network = SCENES[scene]()
    sweep(network, 3)
    residual = judge(network)
    assert 1e-9 < residual < 1.0
    assert residual == pytest.approx(natural_map(network), rel=1e-9)


@pytest.mark.parametrize("dimensions", [2, 3])
def test_light_contacts_are_judged_by_themselves(dimensions):
    """A box on the ground, solved, and one of a part of its mass on it, that of which alone is not: its residual is 1
    where the heavy one's impulse has no digits for it, and else the part that its impulse is."""
    up, half = np.eye(dimensions)[-1], 0.1
    for ratio in (1e-3, 1e-9, 1e-20):
        x = [np.zeros(dimensions), 0.3 * up, 0.5 * up]
        M = [box_mass(half, dimensions), box_mass(half, dimensions), box_mass(half, dimensions, ratio)]
        v = falling(3, dimensions, fixed=(0,))
        network = network_of(x, M, v, [(0, 1, up, 0.2 * up, 0.0), (1, 2, up, 0.4 * up, 0.0)], fixed=(0,))
        heavy = M[1][0, 0] * GRAVITY * STEP
        network.P[0, 0] = heavy
        share = dimensions / (1.0 + 2.5 * (dimensions - 1))  # rho of a box that a corner would turn, of its mass
        assert judge(network) == pytest.approx(1.0 if ratio < 1e-6 else share * ratio, rel=2e-3)
        network.P[:, 0] = heavy * (1.0 + ratio), heavy * ratio
        assert judge(network) < 10 * EPS


def test_problem_without_contacts_is_solved():
    network = network_of(np.zeros((2, 2)), [np.eye(3)] * 2, np.ones((2, 3)), [])
    assert judge(network) == 0.0 and network.islands.count == 0
    assert (network.v == 1.0).all() and sweep(network, 5) == 0


def test_contact_of_two_bodies_that_cannot_move_has_no_impulse():
    contacts = [(0, 1, (0, 1), (0, 0), 0.0), (1, 2, (0, 1), (0, 1), 0.0)]
    v = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    network = network_of([[0, -1], [0, 0.5], [0, 2]], [np.eye(3)] * 3, v, contacts, fixed=(0, 1))
    network.P[:] = 1.0
    sweep(network, 5)
    assert judge(network) == 0.0 and network.islands.count == 1
    assert network.P[0].tolist() == [0.0, 0.0] and network.P[1, 0] > 0.0


def test_body_in_motion_that_is_given_strikes_as_it_moves():
    """A piston that comes at 1 m/s throws a ball at 1 m/s, whatever the ball weighs."""
    v = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 0.0]])
    network = network_of([[0, 0], [0, 1]], [np.eye(3)] * 2, v, [(0, 1, (0, 1), (0, 0.5), 0.0)], fixed=(0,))
    sweep(network, 3)
    assert judge(network) <= EPS and np.abs(network.v - [[0, 1, 0], [0, 1, 0]]).max() <= EPS


@pytest.mark.parametrize("seed", range(5))
def test_islands_are_the_components_of_the_bodies_that_can_move(seed):
    rng = np.random.default_rng(seed)
    n_b, n_c = 40, 30
    pairs = rng.integers(0, n_b, (n_c, 2))
    pairs = pairs[pairs[:, 0] != pairs[:, 1]]
    fixed = set(rng.choice(n_b, 6, replace=False).tolist())
    contacts = [(i, j, (0, 1), (0, 0), 0.0) for i, j in pairs]
    islands = network_of(np.zeros((n_b, 2)), [np.eye(3)] * n_b, np.zeros((n_b, 3)), contacts, fixed=fixed).islands
    free = [c for c, (i, j) in enumerate(pairs) if i not in fixed or j not in fixed]
    edges = np.array([(i, j) for i, j in pairs if i not in fixed and j not in fixed]).T
    _, label = connected_components(coo_array((np.ones(edges.shape[1]), edges), (n_b, n_b)))
    groups = {}
    for c in free:
        groups.setdefault(label[pairs[c, 0] if pairs[c, 0] not in fixed else pairs[c, 1]], []).append(c)
    start = islands.contact_start
    assert [islands.contacts[start[k] : start[k + 1]].tolist() for k in range(islands.count)] == list(groups.values())
    start = islands.body_start
    for k, component in enumerate(groups):
        touched = {b for c in groups[component] for b in pairs[c].tolist() if b not in fixed}
        assert islands.bodies[start[k] : start[k + 1]].tolist() == sorted(touched)
        assert (islands.of[sorted(touched)] == k).all()
    assert (islands.of >= 0).sum() == start[islands.count]


@pytest.mark.parametrize("scene", SCENES)
def test_sweeps_find_the_motion_that_block_solvers_find(scene):
    """Impulses are shared in many ways where contacts are redundant; velocities are not."""
    network = SCENES[scene]()
    dense = assembled(network)
    sweep(network, 20_000, 1e-15)
    assert judge(network) < 1e-11
    result = solve_contact(dense.G, dense.c, dense.mu, dense.dim, tol=1e-12)
    assert result.success
    assert np.abs(network.gamma.ravel() - result.gamma).max() <= 1e-8 * np.abs(dense.c).max()


def test_sweeps_end_when_nothing_changes():
    network = pyramid(3)
    assert sweep(network, 100_000, 1e-14) < 100_000
    assert sweep(network, 100, 1e-13) == 1


def two_heaps():
    """Two heaps that share the shaft only, as one problem; and the contacts of the first."""
    one, other = heap(12, 3, seed=1), heap(15, 3, seed=2)
    both = type(one)(joined([one, other]).words)
    return one, other, both


@pytest.mark.parametrize("most", [1, 7])
def test_islands_solved_together_or_alone_have_the_same_bits(most):
    one, other, both = two_heaps()
    for network in (one, other, both):
        sweep(network, most)
    P, v = np.concatenate([one.P, other.P]), np.concatenate([one.v, other.v])
    assert (both.P == P).all() and (both.v == v).all()


@pytest.mark.parametrize("scene", SCENES)
def test_kernels_have_the_same_bits_interpreted(scene):
    network = SCENES[scene]()
    twin = copy_of(network)
    d = network.b.shape[1]
    assert sweep(network, 4) == interpreted(sweep_network)(twin, memory_of(twin), 4, 0.0, d)
    assert judge(network) == interpreted(judge_network)(twin, d)
    prepare_network(network.address, d), interpreted(prepare_network)(twin, d)
    assert (network.words.view(np.int64) == twin.words.view(np.int64)).all()


def test_what_is_not_finite_is_never_solved():
    network = heap(10, 2)
    network.v_free[3, 1] = np.nan
    sweep(network, 5)
    assert not judge(network) <= 1.0
