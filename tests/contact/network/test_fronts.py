"""Factors by fronts: which bodies and contacts stand where, and that they solve the assembled equations."""

import numpy as np
import pytest

from nonsmooth.contact.network import elimination_tree
from nonsmooth.contact.network.al_newton import begin_direct
from nonsmooth.contact.network.multifrontal import factorise_fronts, lay_out_fronts, room_for_fronts, solve_fronts
from nonsmooth.jit import interpreted
from tests.contact.network.problems import assembled, heap, joined, judge, pyramid, stack
from tests.contact.network.test_joint_rows import hanging_bridge
from tests.contact.network.test_solve import solver_of

SCENES = {
    "pyramid": lambda: pyramid(6),
    "stack": lambda: stack(6),
    "discs": lambda: heap(30, 2),
    "spheres": lambda: heap(27, 3),
    "bridge of joints": lambda: hanging_bridge(3),
    "the second of two heaps": lambda: joined([heap(8, 3), heap(20, 3, seed=1)]),
}
SHARES = "ZEROS_OF_FEW", "ZEROS_OF_SOME", "ZEROS_OF_MANY"
MERGED = {"as they are": None, "no two columns": 0.0, "all that follow one another": 1e9}


def laid_out(network, fill=2000):
    judge(network)
    direct = solver_of(network, fill=fill).direct
    begin_direct(network.address, direct.address)
    return lay_out_fronts(network, direct, int(network.islands.count) - 1)


def contacts_of_island(network):
    islands = network.islands
    k = int(islands.count) - 1
    return k, islands.contacts[islands.contact_start[k] : islands.contact_start[k + 1]]


@pytest.fixture
def shares(monkeypatch):
    """Sets the shares of zeros in fronts, for the interpreter."""
    yield lambda share: [monkeypatch.setattr(elimination_tree, name, share) for name in SHARES] and forget()
    monkeypatch.undo()
    forget()


def forget():
    """Let kernels be read again, whose constants have changed."""
    interpreted.cache_clear()


@pytest.mark.upkeep
@pytest.mark.parametrize("merged", MERGED)
@pytest.mark.parametrize("name", SCENES)
def test_fronts_solve_the_assembled_equations(name, merged, shares):
    """M + J^T D J with D of no symmetry, and its fronts however many columns they have."""
    network, rng = SCENES[name](), np.random.default_rng(0)
    tree, fronts = laid_out(network)
    if MERGED[merged] is not None:
        shares(MERGED[merged])
        count = int(tree.count)
        tree, fronts = laid_out_interpreted(network)
        assert tree.count > count if MERGED[merged] == 0.0 else tree.count < count
    k, contacts = contacts_of_island(network)
    d, n = network.b.shape[1], network.v.shape[1]
    D = np.zeros((len(contacts), 3, 3))
    D[:, :d, :d] = np.eye(d) + 0.3 * rng.normal(size=(len(contacts), d, d))
    assert interpreted(factorise_fronts)(network, tree, fronts, D.reshape(-1, 9), k, d, n)
    bodies = tree.body[: tree.first[tree.count]]
    J = assembled(network).J.reshape(-1, d, len(network.v), n)[contacts][:, :, bodies].reshape(len(contacts), d, -1)
    A = np.einsum("cax,cab,cby->xy", J, D[:, :d, :d], J)
    for place, body in enumerate(bodies):
        A[n * place : n * (place + 1), n * place : n * (place + 1)] += network.M[body]
    x = rng.normal(size=(len(bodies), n))
    fronts.x[: len(bodies)] = (A @ x.ravel()).reshape(x.shape)
    interpreted(solve_fronts)(tree, fronts, n)
    np.testing.assert_allclose(fronts.x[: len(bodies)], x, atol=1e-9)


def laid_out_interpreted(network):
    """The same by the interpreter, which knows changed constants."""
    k, direct = int(network.islands.count) - 1, solver_of(network, fill=2000).direct
    begin_direct(network.address, direct.address)
    tree, _ = lay_out_fronts(network, direct, k)
    assert interpreted(elimination_tree.grow_tree)(network, direct, tree, k)
    return tree, room_for_fronts(tree, network.b.shape[1])


@pytest.mark.parametrize("name", SCENES)
def test_each_body_is_eliminated_once_and_each_contact_stands_at_its_first_one(name):
    network = SCENES[name]()
    tree, _ = laid_out(network)
    k, contacts = contacts_of_island(network)
    count = int(tree.count)
    bodies = network.islands.bodies[network.islands.body_start[k] : network.islands.body_start[k + 1]]
    n_b = int(tree.first[count])
    assert sorted(tree.body[:n_b]) == sorted(bodies) and (tree.place[tree.body[:n_b]] == np.arange(n_b)).all()
    assert sorted(tree.contact[: len(contacts)]) == list(range(len(contacts)))
    for s in range(count):
        rows = tree.row[tree.row_start[s] : tree.row_start[s + 1]]
        assert (np.diff(rows) > 0).all() and (rows >= tree.first[s + 1]).all()
        in_front = {*range(tree.first[s], tree.first[s + 1]), *rows.tolist()}
        for q in range(tree.first[s], tree.first[s + 1]):
            for row in tree.contact[tree.contact_start[q] : tree.contact_start[q + 1]]:
                places = [tree.place[body] for body in (network.i[contacts[row]], network.j[contacts[row]])]
                assert min(place for place in places if place >= 0) == q
                assert {place for place in places if place >= 0} <= in_front


def test_a_matrix_without_pivots_is_not_factorised():
    network = heap(12, 3)
    tree, fronts = laid_out(network)
    k, contacts = contacts_of_island(network)
    network.M[:] = 0.0
    assert not interpreted(factorise_fronts)(network, tree, fronts, np.zeros((len(contacts), 9)), k, 3, 6)
