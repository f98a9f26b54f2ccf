"""Islands of contacts: against the connected components of the matrix, and of bodies that are coupled or are not."""

import numpy as np
import pytest
from scipy.sparse.csgraph import connected_components

from nonsmooth.contact.islands import UNCOUPLED, find_islands
from nonsmooth.jit import interpreted

islands_of = interpreted(find_islands)


def delassus(M, rows):
    W = np.asarray(rows, dtype=float)
    return W @ np.linalg.solve(M, W.T)


def numbers(G, start):
    island = np.full(len(start) - 1, -7)
    count = islands_of(len(island), np.asarray(start), np.ascontiguousarray(G), island)
    assert sorted(set(island)) == list(range(count))
    return island.tolist()


def test_islands_are_the_connected_components_of_the_blocks():
    rng = np.random.default_rng(5)
    for _ in range(300):
        n = int(rng.integers(1, 9))
        start = np.concatenate(([0], np.cumsum(rng.integers(1, 3, n))))
        is_coupled = np.triu(rng.random((n, n)) < 1.2 / n, 1)
        G = np.diag(rng.uniform(0.1, 10.0, start[-1]))
        for k, m in np.argwhere(is_coupled):
            a, b = rng.integers(start[k], start[k + 1]), rng.integers(start[m], start[m + 1])
            G[a, b] = G[b, a] = 0.01 * rng.normal()
        _, expected = connected_components(is_coupled, directed=False)
        assert numbers(G, start) == expected.tolist()  # both number them by their first contact


def test_bodies_that_share_nothing_are_two_islands_and_a_light_link_makes_them_one():
    """Particles of 1 kg on a floor; then a link of 1e-20 kg held by both, with a contact at each of its ends."""
    apart = delassus(np.eye(2), np.eye(2))
    assert numbers(apart, [0, 1, 2]) == [0, 1]
    joints = [[1, 0, 0], [0, 0, 1], [1, -1, 0], [0, 1, -1]]
    assert numbers(delassus(np.diag([1.0, 1e-20, 1.0]), joints), [0, 1, 2, 3, 4]) == [0, 0, 0, 0]


@pytest.mark.parametrize("a", [0.1, 0.3, 1 / 7])
def test_ends_of_a_dumbbell_are_apart_though_one_body_carries_both(a):
    """1/m - a^2/I = 0 with I = m a^2, in coordinates that mix translation and rotation: zero but for rounding."""
    m = 0.7
    rows = np.array([[1.0, a], [1.0, -a]])
    turn = np.array([[0.8, -0.6], [0.6, 0.8]])
    G = delassus(turn.T @ np.diag([m, m * a * a]) @ turn, rows @ turn)
    assert numbers(G, [0, 1, 2]) == [0, 1]
    assert numbers(delassus(np.diag([m, 0.9 * m * a * a]), rows), [0, 1, 2]) == [0, 0]


def test_what_is_coupled_does_not_depend_on_the_units_of_a_contact():
    G = np.array([[1.0, 2 * UNCOUPLED, 0.0], [2 * UNCOUPLED, 1.0, 0.5 * UNCOUPLED], [0.0, 0.5 * UNCOUPLED, 1.0]])
    for scales in ([1.0, 1.0, 1.0], [1e-9, 1e3, 1e12]):
        assert numbers(np.diag(scales) @ G @ np.diag(scales), [0, 1, 2, 3]) == [0, 0, 1]
