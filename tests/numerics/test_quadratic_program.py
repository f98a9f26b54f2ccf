"""Quadratic programs with known minimisers; no solver's own opinion reaches the user."""

import warnings

import numpy as np
import osqp
import pytest
import qpsolvers

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


@pytest.mark.parametrize(
    "P, bound",
    [(np.diag([1.0, -1.0]), 0.0), (np.diag([np.nan, 1.0]), 0.0), (np.eye(2), -np.inf)],
    ids=["without a bound below", "not a number", "a bound that nothing reaches"],
)
def test_a_program_that_osqp_refuses_has_no_minimiser(P, bound):
    assert minimise(P, np.zeros(2), -np.eye(2), np.array([0.0, bound])) is None


@pytest.mark.parametrize(
    "refusal",
    [qpsolvers.ProblemError("P"), qpsolvers.SolverError("no"), osqp.OSQPException(4), ZeroDivisionError("no root"),
     ValueError("no memory for this")],
)  # fmt: skip
def test_what_a_solver_says_of_the_program_is_no_minimiser(monkeypatch, refusal):
    monkeypatch.setattr(qpsolvers, "solve_qp", raising(refusal))
    assert minimise(np.eye(2), np.zeros(2)) is None


@pytest.mark.parametrize(
    "error", [TypeError("a list"), NameError("x"), AttributeError("shape"), IndexError("3"), MemoryError(),
              qpsolvers.exceptions.ParamError("tolerance")],
)  # fmt: skip
def test_an_error_in_the_program_text_is_not_taken_for_a_program_without_minimiser(monkeypatch, error):
    """It was told as closed contacts that exclude each other."""
    monkeypatch.setattr(qpsolvers, "solve_qp", raising(error))
    with pytest.raises(type(error)):
        minimise(np.eye(2), np.zeros(2))


def test_a_solver_that_is_not_there_and_arrays_that_do_not_fit_are_errors_of_the_caller():
    with pytest.raises(qpsolvers.SolverNotFound):
        minimise(np.eye(2), np.zeros(2), solver="abacus")
    with pytest.raises(AssertionError, match="dimension of q"):
        minimise(np.eye(2), np.zeros(3), -np.eye(2), np.zeros(2))


def raising(error):
    def solve(*_, **__):
        raise error

    return solve
