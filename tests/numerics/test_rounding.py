"""Bounds of rounding errors hold where sums are made, and are no larger than they must be."""

import math
from fractions import Fraction

import numpy as np
import pytest

from nonsmooth.jit import interpreted
from nonsmooth.numerics.rounding import (
    CENTRAL_INCREMENT,
    EPS,
    FORWARD_INCREMENT,
    UNIT_ROUNDOFF,
    rounded_sum,
    rounding_of_sum,
    spacing,
)


def test_the_unit_is_that_of_double_precision():
    assert EPS == np.finfo(float).eps and UNIT_ROUNDOFF == EPS / 2
    assert 1.0 + EPS > 1.0 == 1.0 + UNIT_ROUNDOFF  # to even


@pytest.mark.parametrize("n", [2, 10, 300])
def test_an_inner_product_is_no_farther_from_the_exact_one_than_its_bound(n):
    """Against rational arithmetic. A bound of half as many roundings would still hold for most sums, not for all."""
    rng = np.random.default_rng(n)
    for _ in range(200):
        x, y = rng.normal(size=n), rng.normal(size=n)
        total = 0.0
        for a, b in zip(x, y, strict=True):
            total += a * b
        exact = sum(Fraction(a) * Fraction(b) for a, b in zip(x, y, strict=True))
        assert abs(Fraction(total) - exact) <= Fraction(rounding_of_sum(n, float(np.abs(x) @ np.abs(y))))


def test_the_bound_is_met_where_every_rounding_goes_the_same_way():
    n = 1000
    x = [1.0] + [UNIT_ROUNDOFF] * n  # each is half of the last place of 1, and is lost
    total = 0.0
    for part in x:
        total += part
    error = float(sum(map(Fraction, x)) - Fraction(total))
    assert 0.9 * rounding_of_sum(n, math.fsum(x)) < error <= rounding_of_sum(n, math.fsum(x))


def test_no_double_is_farther_from_its_neighbour_than_the_spacing():
    x = np.concatenate([np.logspace(-300, 300, 61), [1.0, np.nextafter(2.0, 1.0)]])
    apart = np.nextafter(x, np.inf) - x
    bound = np.array([interpreted(spacing)(value) for value in x])
    assert (apart <= bound).all() and (apart > 0.49 * bound).all()
    assert interpreted(spacing)(-3.0) == interpreted(spacing)(3.0)


def test_bounds_of_many_sums_are_taken_at_once():
    sizes = np.array([0.0, 1.0, 2.5])
    assert rounding_of_sum(8, sizes).tolist() == [8 * UNIT_ROUNDOFF * size for size in sizes]
    assert rounding_of_sum(8, 2.5) == rounded_sum(8, 2.5)  # compiled


@pytest.mark.parametrize("is_central", [False, True])
def test_differences_with_the_increments_are_as_exact_as_any(is_central):
    """d exp/dx at 1: a step ten times longer or shorter is worse, of truncation and of rounding."""

    def largest_error(h):
        x = 1.0 + 1e-3 * np.arange(200)
        below = np.exp(x - h) if is_central else np.exp(x)
        return np.abs((np.exp(x + h) - below) / ((2.0 if is_central else 1.0) * h) / np.exp(x) - 1.0).max()

    h = CENTRAL_INCREMENT if is_central else FORWARD_INCREMENT
    assert largest_error(h) < min(largest_error(30.0 * h), largest_error(h / 30.0))
