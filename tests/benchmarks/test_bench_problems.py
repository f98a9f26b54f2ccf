"""The random problems are what they say they are."""

import numpy as np
import pytest

from benchmarks.problems import FAMILIES, frictional_lcp, frictionless_lcp, heap, normals


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("name", FAMILIES)
def test_a_delassus_matrix_is_semidefinite_and_rest_is_within_reach(name, dim):
    """G = H M^-1 H^T >= 0, and c = H v = -G P for some P: some impulses bring every contact to rest."""
    require_consistent(FAMILIES[name](np.random.default_rng(3), 12, dim))


def test_a_heap_has_settled_into_its_box():
    """Each sphere is held: three contacts at least, but for one or two on top; without friction 3 n in all at most."""
    case = heap(np.random.default_rng(3), 100)
    require_consistent(case)
    n = len(case.given.f) // 6
    touched = np.abs(case.given.H.toarray()).reshape(n, 6, -1)[:, :3].any(axis=1).sum(axis=1) // 3
    assert np.median(touched) >= 4 and 2 * n < len(case.mu) < 3.3 * n


def require_consistent(case):
    dim = case.dim
    G = case.G if isinstance(case.G, np.ndarray) else case.G.toarray()
    size = np.sqrt(np.diag(G))
    scaled = G / size[:, None] / size  # masses differ by 1e6
    assert np.abs(scaled - scaled.T).max() < 1e-12
    eigenvalues, vectors = np.linalg.eigh(scaled)
    assert eigenvalues[0] > -1e-12 * eigenvalues[-1]
    null = vectors[:, eigenvalues < 1e-10 * eigenvalues[-1]]
    assert np.abs(null.T @ (case.c / size)).max(initial=0.0) < 1e-8 * np.linalg.norm(case.c / size)
    assert len(case.mu) * dim == len(case.c) and (case.mu >= 0).all()


def test_a_seed_gives_one_problem():
    for family in FAMILIES.values():
        first, second = (family(np.random.default_rng(5), 9, 2) for _ in range(2))
        np.testing.assert_array_equal(first.c, second.c)


def test_friction_makes_the_problem_unsymmetric_and_its_absence_definite():
    A, _ = frictional_lcp(np.random.default_rng(0), 4)
    assert A.shape == (12, 12) and np.abs(A - A.T).max() > 0.1
    A, _ = frictionless_lcp(np.random.default_rng(0), 5)
    assert (A == A.T).all() and np.linalg.eigvalsh(A)[0] > 0


def test_normals_are_every_second_or_third_row():
    case = FAMILIES["packing"](np.random.default_rng(0), 12, 3)
    A, b = normals(case)
    np.testing.assert_array_equal(A.toarray(), case.G.toarray()[::3, ::3])
    np.testing.assert_array_equal(b, case.c[::3])
