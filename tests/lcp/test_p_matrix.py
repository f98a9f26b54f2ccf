"""P-matrices by their definition and by what they promise."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import nonsmooth as ns


def by_minors(A):
    """The definition: every principal minor is positive."""
    n = len(A)
    return all(
        np.linalg.det(A[np.ix_(rows, rows)]) > 0
        for size in range(1, n + 1)
        for rows in itertools.combinations(range(n), size)
    )


def test_recursion_agrees_with_the_principal_minors():
    rng = np.random.default_rng(0)
    met = {True: 0, False: 0}
    for _ in range(400):
        n = int(rng.integers(1, 6))
        A = rng.normal(size=(n, n)) + rng.uniform(0, 2) * np.eye(n)
        met[by_minors(A)] += 1
        assert ns.is_p_matrix(A) is by_minors(A)
    assert min(met.values()) > 50


def test_p_matrix_has_one_solution_for_every_right_hand_side():
    rng = np.random.default_rng(1)
    for _ in range(60):
        A = rng.normal(size=(4, 4)) + 1.5 * np.eye(4)
        counts = {len(ns.lcp_solutions(A, rng.normal(size=4))) for _ in range(40)}
        if ns.is_p_matrix(A):
            assert counts == {1}


def test_large_matrices_are_decided_where_a_sufficient_test_holds():
    rng = np.random.default_rng(2)
    skew = rng.normal(size=(40, 40))
    assert ns.is_p_matrix(np.eye(40) + skew - skew.T) is True  # its symmetric part is the identity
    assert ns.is_p_matrix(np.diag(np.r_[-1.0, np.ones(39)])) is False
    doubtful = np.eye(40)
    doubtful[0, 1] = 3.0  # triangular: a P-matrix that neither test sees
    assert ns.is_p_matrix(doubtful) is None
    with pytest.raises(ns.InvalidInput, match="square"):
        ns.is_p_matrix(np.ones((2, 3)))
