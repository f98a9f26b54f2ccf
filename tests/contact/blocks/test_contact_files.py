"""Real friction problems: the shared collection where it is there, else the copies that travel with the tests."""

from pathlib import Path

import numpy as np
import pytest
from scipy import sparse

from nonsmooth.contact.blocks.solve import solve_contact

SHARED = Path(__file__).parents[4] / "shared" / "problems"
COLLECTION = SHARED if SHARED.is_dir() else Path(__file__).parents[2] / "data"
FILES = sorted(COLLECTION.glob("fc?d/*.npz"))


def load(path):
    with np.load(path, allow_pickle=False) as file:
        G = sparse.csr_array((file["data"], file["indices"], file["indptr"]), shape=tuple(file["shape"]))
        return G, file["q"], file["mu"], int(file["dim"])


def test_the_collection_is_there():
    assert len(FILES) >= 21


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_auto_reaches_1e8_on_every_problem_and_1e12_when_asked(path):
    G, c, mu, dim = load(path)
    result = solve_contact(G, c, mu, dim)
    assert result.success and result.error <= 1e-8, result.message
    sharper = solve_contact(G, c, mu, dim, tol=1e-12, guess=result.P)
    assert sharper.success and sharper.error <= 1e-12, sharper.message


@pytest.mark.slow
def test_thousands_of_planar_grains_settle():
    """A triangular packing of 60 x 60 discs falling on a floor, a random half of its 10 000 contacts closed."""
    side = 60
    x, y = np.meshgrid(np.arange(side, dtype=float), np.arange(side, dtype=float))
    x = x + 0.5 * (y % 2)
    centre = np.column_stack([x.ravel(), y.ravel() * np.sqrt(3) / 2])
    pairs = [(i, j) for i in range(side**2) for j in _neighbours(i, side)]
    entries = []
    for k, (i, j) in enumerate(pairs + [(-1, j) for j in range(side)]):
        normal = centre[j] - centre[i] if i >= 0 else np.array([0.0, 1.0])
        tangent = np.array([-normal[1], normal[0]])
        for body, sign in ((j, 1.0), (i, -1.0)):
            if body >= 0:
                entries += [
                    (2 * k + a, 3 * body + b, sign * d[b]) for a, d in enumerate((normal, tangent)) for b in (0, 1)
                ]
                entries += [(2 * k + 1, 3 * body + 2, -1.0)]  # spin in units of the radius, inertia m r^2
    rows, columns, values = (np.array(part) for part in zip(*entries, strict=True))
    H = sparse.csr_array((values, (rows, columns)), shape=(2 * (len(pairs) + side), 3 * side**2))
    velocity = np.tile([0.0, -1.0, 0.0], side**2) + 0.1 * np.random.default_rng(0).normal(size=3 * side**2)
    closed = np.flatnonzero(np.random.default_rng(1).random(H.shape[0] // 2) < 0.5)
    H = H[(2 * closed[:, None] + [0, 1]).ravel()]
    result = solve_contact((H @ H.T).tocsr(), H @ velocity, 0.4, 2)
    assert result.success, result.message


def _neighbours(i, side):
    row, column = divmod(i, side)
    shift = row % 2
    upper = [(row + 1, column + shift - 1), (row + 1, column + shift)]
    around = [(row, column + 1), *upper]
    return [r * side + k for r, k in around if r < side and 0 <= k < side]
