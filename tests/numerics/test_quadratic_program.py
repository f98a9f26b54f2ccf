"""Quadratic programs with known minimisers; no solver's own opinion reaches the user."""

import warnings

import numpy as np

from nonsmooth.numerics.quadratic_program import minimise


def test_the_nearest_point_of_a_half_plane_is_the_foot_of_the_perpendicular():
    G, h = np.array([[1.0, 1.0]]), np.array([-2.0])  # x + y <= -2
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        x = minimise(np.eye(2), np.zeros(2), G, h)
    assert np.allclose(x, [-1, -1], atol=1e-8)


def test_equality_and_bound_hold_together():
    x = minimise(np.eye(3), np.zeros(3), A=np.ones((1, 3)), b=np.array([3.0]), lower=np.array([2.0, 0.0, 0.0]))
    assert np.allclose(x, [2, 0.5, 0.5], atol=1e-8)


def test_rows_that_exclude_each_other_have_no_minimiser_and_say_so_without_a_warning():
    G, h = np.array([[1.0], [-1.0]]), np.array([-1.0, -1.0])  # x <= -1 and x >= 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert minimise(np.eye(1), np.zeros(1), G, h) is None
