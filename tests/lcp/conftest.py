"""Families of complementarity problems that several test files share."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.problems import frictional_lcp

DATA = Path(__file__).parents[1] / "data"


def residual(A, b, z):
    """The measure of the package, written out a second time in NumPy."""
    A, b, z = np.asarray(A, float), np.asarray(b, float), np.asarray(z, float)
    d = np.abs(np.diagonal(A))
    d = np.where(d > 0, d, np.linalg.norm(A, axis=1))
    return np.abs(np.minimum(d * z, A @ z + b)).max() / np.abs(b).max()


def load(folder):
    return {path.stem: np.load(path, allow_pickle=False) for path in sorted((DATA / folder).glob("*.npz"))}


def p_matrix(rng, n):
    """Unsymmetric, x.Ax > 0."""
    B, C = rng.standard_normal((2, n, n))
    return B @ B.T / n + 0.1 * np.eye(n) + (C - C.T)


def m_matrix(rng, n):
    """Diagonally dominant, off-diagonal entries <= 0."""
    A = -rng.uniform(0, 1, (n, n))
    np.fill_diagonal(A, 0)
    np.fill_diagonal(A, 1.1 * np.abs(A).sum(axis=1) + 0.1)
    return A


def copositive(rng, n):
    """Nonnegative with positive diagonal: strictly copositive, in general neither P nor semidefinite."""
    return rng.uniform(0, 1, (n, n)) + 0.01 * np.eye(n)


def murty(n):
    """The family on which Murty's least-index rule takes 2^n steps."""
    return np.eye(n) + 2 * np.triu(np.ones((n, n)), 1), -np.ones(n)


class Families:
    """The functions of this file, for the fixture."""

    residual = staticmethod(residual)
    load = staticmethod(load)
    p_matrix = staticmethod(p_matrix)
    m_matrix = staticmethod(m_matrix)
    copositive = staticmethod(copositive)
    murty = staticmethod(murty)
    frictional_lcp = staticmethod(frictional_lcp)


@pytest.fixture(scope="session")
def families():
    return Families
