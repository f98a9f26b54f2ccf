"""All loads of bearings that slide: against signs, a scan, closed forms; how many they may be."""

import itertools

import numpy as np
import pytest

from nonsmooth.contact.bearing_loads import all_loads

SIZES = (0.3, 1.0, 1.5, 3.0)  # of A: from one load for sure to none or several


def random_bearings(n, dim, seed):
    rng = np.random.default_rng(seed)
    A, b = np.zeros((n, n, 3)), np.zeros((n, 3))
    A[:, :, :dim] = rng.normal(size=(n, n, dim)) * rng.choice(SIZES) / np.sqrt(n)
    b[:, :dim] = rng.normal(size=(n, dim))
    return A, b


def loads_by_signs(A, b):
    """Where all bearings bear along one axis: rho = S (b + A rho), with every choice of signs S."""
    found = []
    for signs in itertools.product((-1.0, 1.0), repeat=len(b)):
        S = np.diag(signs)
        rho = np.linalg.solve(np.eye(len(b)) - S @ A[:, :, 0], S @ b[:, 0])
        if rho.min() >= 0.0:
            found.append(rho)
    return np.array(sorted(found, key=max)).reshape(len(found), len(b))


def roots_by_scan(A, b, n=20_001):
    """How many loads two bearings have: the first one of each second one is a quadratic's root."""
    share = np.linspace(0.0, 1.0, n)
    second = share / (1.0 - share + 1e-12)
    count = 0
    for sign in (-1.0, 1.0):
        c = b[0] + A[0, 1] * second[:, None]
        p, q, r = 1.0 - A[0, 0] @ A[0, 0], -2.0 * c @ A[0, 0], -(c * c).sum(axis=1)
        square = q * q - 4.0 * p * r
        first = (-q + sign * np.sqrt(np.maximum(square, 0.0))) / (2.0 * p)
        off = second - np.linalg.norm(b[1] + A[1, 0] * first[:, None] + A[1, 1] * second[:, None], axis=1)
        off = np.where((square >= 0.0) & (first >= 0.0), off, np.nan)
        count += int(np.nansum(off[1:] * off[:-1] < 0.0))
    return count


@pytest.mark.parametrize("n", [1, 2, 3, 4])
@pytest.mark.parametrize("seed", range(25))
def test_bearings_along_one_axis_have_the_loads_of_all_signs(n, seed):
    A, b = random_bearings(n, 1, [n, seed])
    expected, loads = loads_by_signs(A, b), all_loads(A, b)
    assert loads.shape == expected.shape
    np.testing.assert_allclose(loads, expected, rtol=1e-8, atol=1e-10)


@pytest.mark.parametrize("seed", range(40))
def test_two_bearings_in_space_have_as_many_loads_as_a_scan_finds(seed):
    A, b = random_bearings(2, 3, seed)
    assert len(all_loads(A, b)) == roots_by_scan(A, b)


@pytest.mark.parametrize("n", [1, 2, 3, 4, 6])
@pytest.mark.parametrize("seed", range(6))
def test_what_is_found_are_loads(n, seed):
    A, b = random_bearings(n, 3, [7, n, seed])
    for rho in all_loads(A, b):
        borne = np.linalg.norm(b + np.einsum("pqa,q->pa", A, rho), axis=1)
        np.testing.assert_allclose(rho, borne, rtol=0, atol=1e-10 * rho.max())


@pytest.mark.parametrize("seed", range(60))
def test_a_contraction_has_one_load(seed):
    A, b = random_bearings(3, 3, [11, seed])
    radius = np.abs(np.linalg.eigvals(np.linalg.norm(A, axis=2))).max()
    assert len(all_loads(A / max(radius, 1.0) * 0.99, b)) == 1


def test_one_bearing_has_none_or_two_loads_where_its_friction_makes_more_than_it_needs():
    A, b = np.zeros((1, 1, 3)), np.zeros((1, 3))
    A[0, 0], b[0] = (-2.0, 0, 0), (1.0, 0, 0)
    np.testing.assert_allclose(all_loads(A, b), [[1 / 3], [1.0]], rtol=1e-12)  # rho = |1 - 2 rho|
    assert len(all_loads(A, -b)) == 0


@pytest.mark.parametrize("scale", [1e-9, 1e9])
def test_loads_grow_as_what_is_borne(scale):
    A, b = random_bearings(3, 3, 5)
    np.testing.assert_allclose(all_loads(A, scale * b), scale * all_loads(A, b), rtol=1e-8)


def test_a_bearing_that_bears_nothing_has_no_load():
    A, b = np.zeros((2, 2, 3)), np.zeros((2, 3))
    A[0, 0, 0], b[0, 0] = 0.5, 1.0
    np.testing.assert_allclose(all_loads(A, b), [[2.0, 0.0]], rtol=1e-12)
    np.testing.assert_array_equal(all_loads(A, 0.0 * b), [[0.0, 0.0]])
