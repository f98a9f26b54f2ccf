"""The direct rung: solutions to rounding, of stacks, pyramids and heaps, against methods of their own."""

import numpy as np
import pytest

from nonsmooth.contact.blocks.solve import solve_contact
from nonsmooth.contact.network.al_newton import MET, NO_ROOM, begin_direct, solve_by_al_newton
from nonsmooth.contact.network.lagrangian import Direct
from nonsmooth.contact.planar.enumerate import Tree, enumerate_modes
from nonsmooth.contact.planar.problem import problem_of
from nonsmooth.jit import interpreted
from nonsmooth.jit.blocks import new
from nonsmooth.mechanics.system import UNILATERAL
from tests.contact.network.problems import (
    GRAVITY,
    STEP,
    assembled,
    chosen,
    copy_of,
    heap,
    joined,
    judge,
    pyramid,
    stack,
)
from tests.contact.network.test_network import natural_map, sweep

TIGHT = 1e-13  # of the natural map
SCENES = {
    "stack": lambda: stack(6),
    "stack with a top a thousand times heavier": lambda: stack(10, 1e3),
    "pyramid": lambda: pyramid(6),
    "discs": lambda: heap(40, 2),
    "discs, rough": lambda: heap(40, 2, mu=1.0),
    "spheres": lambda: heap(40, 3),
    "spheres without friction": lambda: heap(30, 3, mu=0.0),
}


def direct_of(network, fill=3000):
    sizes = {"d": network.b.shape[1], "n": network.v.shape[1], "m": len(network.i), "n_b": len(network.v)}
    return new(Direct, fill=fill, **sizes)


def solve(network, direct=None, tol=TIGHT, sweeps=20, most=200):
    """Status of each island."""
    direct = direct or direct_of(network)
    newton = solve_by_al_newton[network.b.shape[1]]
    sweep(network, sweeps)
    begin_direct(network.address, direct.address)
    return [newton(network.address, direct.address, k, tol, most) for k in range(network.islands.count)]


@pytest.mark.parametrize("scene", SCENES)
def test_solution_holds_by_the_definition_and_has_the_motion_of_block_solvers(scene):
    network = SCENES[scene]()
    assert set(solve(network)) == {MET}
    assert judge(network) <= TIGHT and natural_map(network) <= 10 * TIGHT
    dense = assembled(network)
    result = solve_contact(dense.G, dense.c, dense.mu, dense.dim, tol=1e-11)
    assert result.success
    assert np.abs(network.gamma.ravel() - result.gamma).max() <= 1e-7 * np.abs(dense.c).max()


@pytest.mark.parametrize("ratio", [1.0, 1e3, 1e6])
def test_stack_carries_the_weight_that_stands_on_each_of_its_boxes(ratio):
    network = stack(10, ratio)
    assert solve(network) == [MET]
    judge(network)
    fall, slip = GRAVITY * STEP, TIGHT * np.linalg.norm(network.P) / network.rho.min()  # all stick: F = rho gamma
    weight = np.array([network.M[k:, 0, 0].sum() for k in range(1, 11)]) * fall
    carried = network.P[:, 0].reshape(10, 4).sum(axis=1)
    assert np.abs(network.gamma).max() <= slip
    assert np.abs(carried / weight - 1.0).max() <= 10 * slip / fall  # the velocities of ten contacts add up


@pytest.mark.parametrize("seed", range(12))
def test_few_contacts_have_the_one_solution_of_all_their_modes(seed):
    whole, rng, is_complete = heap(4, 2, seed=seed, speed=0.2), np.random.default_rng(seed), False
    while not is_complete:  # some choices are redundant
        network = chosen(whole, rng.choice(whole.n_c, 5, replace=False).tolist())
        dense, n_c = assembled(network), network.n_c
        problem = problem_of(np.tile([UNILATERAL, 1], (n_c, 1)), dense.G, dense.c, dense.mu, dense.mu)
        tree = new(Tree, n=n_c, r=2 * n_c)
        found, is_complete = enumerate_modes(problem.address, tree.address)
    assert found == 1
    assert set(solve(network)) == {MET}
    judge(network)
    assert np.abs(network.P.ravel() - tree.solutions[0]).max() <= 1e-12 * np.abs(tree.solutions[0]).max()


def test_five_bodies_are_one_body_of_fifteen_coordinates():
    """J M^-1 J^T of the dense 15 x 15 mass matrix, solved by blocks; the impulses of discs are unique here."""
    network = heap(5, 2, seed=3)
    assert set(solve(network, tol=1e-15)) == {MET}
    judge(network)
    dense = assembled(network)
    J = dense.J.reshape(len(dense.c), -1)[:, :15]
    M = np.zeros((15, 15))
    for body in range(5):
        M[3 * body : 3 * body + 3, 3 * body : 3 * body + 3] = network.M[body]
    G = J @ np.linalg.solve(M, J.T)
    result = solve_contact(G, dense.c, dense.mu, 2, tol=1e-15)
    assert np.abs(network.gamma.ravel() - result.gamma).max() <= 1e-14 * np.abs(dense.c).max()
    loaded = result.P != 0
    amplified = 4 * np.linalg.cond(G[np.ix_(loaded, loaded)]) * np.finfo(float).eps  # some roundings of each of the two
    assert amplified <= 4e-14
    assert np.abs(network.P.ravel() - result.P).max() <= amplified * np.abs(result.P).max()


def test_a_second_solve_with_the_same_contacts_makes_no_factor():
    network = stack(6)
    direct = direct_of(network)
    solve(network, direct, sweeps=0)
    made, P = direct.desk.factors, network.P.copy()
    network.v_free[:] *= 1.0 + 1e-7
    assert solve(network, direct, sweeps=0) == [MET]
    assert judge(network) <= TIGHT and np.abs(network.P - P).max() <= 1e-5 * np.abs(P).max()
    assert made > 0 and direct.desk.factors == made


def test_columns_are_laid_out_anew_when_other_bodies_touch():
    network = pyramid(5)
    other = joined([network], np.random.default_rng(4))
    alone, direct = copy_of(other), direct_of(network)
    solve(network, direct)
    made = direct.desk.factors
    assert solve(other, direct) == solve(alone) == [MET] and direct.desk.factors > made
    assert (other.P == alone.P).all()


def test_too_little_room_is_said_and_leaves_the_problem():
    network = pyramid(6)
    direct = direct_of(network, fill=30)
    assert solve(network, direct) == [NO_ROOM] and direct.desk.graph.wanted > 30
    assert solve(network, direct) == [NO_ROOM]
    assert judge(network) < 1e-1
    assert solve(network, direct_of(network, fill=300)) == [MET]


def test_islands_solved_together_or_alone_have_the_same_bits():
    one, other = heap(12, 3, seed=1), heap(15, 3, seed=2)
    both = joined([one, other])
    for network in (one, other, both):
        solve(network)
    assert (both.P == np.concatenate([one.P, other.P])).all()


def test_order_of_bodies_and_contacts_changes_the_motion_by_rounding_only():
    network = pyramid(5)
    shuffled = joined([network], np.random.default_rng(1))
    assert solve(network) == solve(shuffled) == [MET]
    sizes = np.linalg.norm(network.P), np.linalg.norm(shuffled.P)
    judge(network), judge(shuffled)
    assert np.abs(network.v).max() <= 1e-12 * GRAVITY * STEP and np.abs(shuffled.v).max() <= 1e-12 * GRAVITY * STEP
    assert 0.5 < sizes[0] / sizes[1] < 2.0


@pytest.mark.parametrize("scene", ["stack", "discs, rough"])
def test_kernels_have_the_same_bits_interpreted(scene):
    network = {"stack": lambda: stack(3), "discs, rough": lambda: heap(9, 2, mu=1.0, speed=0.5)}[scene]()
    sweep(network, 5)
    twin, direct, twin_direct = copy_of(network), direct_of(network), direct_of(network)
    newton = solve_by_al_newton[network.b.shape[1]]
    begin_direct(network.address, direct.address)
    interpreted(begin_direct)(twin, twin_direct)
    for k in range(network.islands.count):
        newton(network.address, direct.address, k, TIGHT, 30)
        interpreted(newton)(twin, twin_direct, k, TIGHT, 30)
    assert direct.desk.factors > 1
    assert (network.words.view(np.int64) == twin.words.view(np.int64)).all()
    assert (direct.words.view(np.int64) == twin_direct.words.view(np.int64)).all()
