"""What the direct rung is made of: derivative, order of elimination, factors. Wrong ones would only cost steps."""

import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.sparse.csgraph import reverse_cuthill_mckee

from nonsmooth.contact.network import al_newton, lagrangian
from nonsmooth.contact.network.block_factor import back_substitute, factorise
from nonsmooth.contact.planar.selection import FREE, SLIDE_MINUS, SLIDE_PLUS, STICK
from nonsmooth.jit import interpreted
from tests.contact.network.problems import heap, pyramid, stack
from tests.contact.network.test_direct import direct_of

SCENES = {"discs": lambda: heap(16, 2), "spheres": lambda: heap(12, 3), "without friction": lambda: heap(12, 3, mu=0.0)}


class Linearised:
    """The equations of an island of a network at random velocities, by the interpreter."""

    def __init__(self, network, seed=0):
        rng = np.random.default_rng(seed)
        self.network, self.direct = network, direct_of(network, fill=20 * len(network.v))
        self.d, self.n = network.b.shape[1], network.v.shape[1]
        interpreted(al_newton.recall_graph)(network, self.direct)
        assert network.islands.count == 1 and interpreted(al_newton.is_laid_out)(
            network, self.direct, self.direct.desk, 0
        )
        self.bodies = network.islands.bodies[: network.islands.body_start[1]]
        self.place = self.direct.factor.columns.place[self.bodies]
        self.direct.P[:] = 0.1 * rng.normal(size=network.P.shape)
        self.direct.P[:, 0] = rng.uniform(-0.05, 0.4, network.n_c)
        self.direct.rho[:] = rng.uniform(1.0, 9.0, network.n_c)
        network.v[self.bodies] = 0.02 * rng.normal(size=(len(self.bodies), self.n))
        self.g()
        self.is_symmetric = interpreted(lagrangian.assemble)(network, self.direct, self.direct.desk, 0, self.d, self.n)

    def g(self):
        interpreted(lagrangian.imbalance)(self.network, self.direct, 0, self.d, self.n)
        return self.direct.g[self.place].ravel().copy()

    def A(self):
        """The blocks as one dense matrix, by bodies."""
        factor, n = self.direct.factor, self.n
        m = len(self.bodies)
        A = np.zeros((m, n, m, n))
        for k in range(m):
            A[k, :, k] = factor.D[k].reshape(n, n)
            for at in range(factor.columns.first[k], factor.columns.last[k]):
                A[factor.columns.row[at], :, k] = factor.L[at].reshape(n, n)
                A[k, :, factor.columns.row[at]] = factor.U[at].reshape(n, n)
        return A[self.place][:, :, self.place].reshape(m * n, m * n)


@pytest.mark.parametrize("scene", SCENES)
def test_derivative_is_that_of_the_equations(scene):
    linearised = Linearised(SCENES[scene]())
    A, v = linearised.A(), linearised.network.v
    modes = set(linearised.direct.mode.tolist())
    increment, columns = 1e-8, []
    for body in linearised.bodies:
        for x in range(linearised.n):
            kept = v[body, x]
            v[body, x] = kept + increment
            ahead = linearised.g()
            v[body, x] = kept - increment
            columns.append((ahead - linearised.g()) / (2 * increment))
            v[body, x] = kept
    assert np.abs(A - np.array(columns).T).max() <= 1e-6 * np.abs(A).max()
    wanted = {"discs": {FREE, STICK, SLIDE_PLUS, SLIDE_MINUS}, "spheres": {FREE, STICK, SLIDE_PLUS}}
    assert modes >= wanted.get(scene, {FREE, SLIDE_PLUS})
    assert linearised.is_symmetric == (scene == "without friction") == bool(np.allclose(A, A.T, rtol=1e-12, atol=0.0))


@pytest.mark.parametrize("scene", SCENES)
def test_factors_solve(scene):
    linearised = Linearised(SCENES[scene]())
    A, direct, m = linearised.A(), linearised.direct, len(linearised.bodies)
    x = np.random.default_rng(2).normal(size=(m, linearised.n))
    direct.step[linearised.place] = (A @ x.ravel()).reshape(x.shape)
    assert interpreted(factorise)(direct.factor, direct.desk.square, 0, m, linearised.is_symmetric, linearised.n)
    interpreted(back_substitute)(direct.factor, direct.desk.square, 0, m, direct.step, linearised.n)
    assert np.abs(direct.step[linearised.place] - x).max() <= 1e-15 * np.linalg.cond(A) * np.abs(x).max()


def graph_of(network):
    m = network.islands.body_start[1]
    place = -np.ones(len(network.v), int)
    place[network.islands.bodies[:m]] = np.arange(m)
    pairs = place[np.column_stack((network.i, network.j))]
    graph = np.eye(m, dtype=bool)
    for i, j in pairs[(pairs >= 0).all(axis=1)]:
        graph[i, j] = graph[j, i] = True
    return graph


def eliminated(graph):
    """The rows below the diagonal of each column of the factor, by elimination in the given order."""
    graph, rows = graph.copy(), []
    for k in range(len(graph)):
        below = k + 1 + np.flatnonzero(graph[k + 1 :, k])
        graph[np.ix_(below, below)] = True
        rows.append(below.tolist())
    return rows


@pytest.mark.parametrize("scene", [lambda: stack(7), lambda: pyramid(9), lambda: heap(60, 3), lambda: heap(80, 2)])
def test_columns_are_those_of_the_elimination_and_few(scene):
    network = scene()
    direct = direct_of(network, fill=20 * len(network.v))
    interpreted(al_newton.recall_graph)(network, direct)
    assert interpreted(al_newton.is_laid_out)(network, direct, direct.desk, 0)
    columns, graph = direct.factor.columns, graph_of(network)
    bodies = network.islands.bodies[: len(graph)].tolist()
    order = [bodies.index(body) for body in columns.body[: len(graph)]]
    assert sorted(order) == list(range(len(graph)))
    expected = eliminated(graph[np.ix_(order, order)])
    laid_out = [columns.row[columns.first[k] : columns.last[k]].tolist() for k in range(len(graph))]
    assert laid_out == expected
    banded = reverse_cuthill_mckee(csr_array(graph), symmetric_mode=True)
    assert direct.desk.graph.top <= sum(map(len, eliminated(graph[np.ix_(banded, banded)])))
