import numpy as np
import pytest

from nonsmooth.errors import InvalidInput
from nonsmooth.lcp import mixed
from nonsmooth.lcp.mixed import solve_mlcp
from nonsmooth.lcp.result import LCPStatus


def mixed_error(A, b, z, free):
    w = A @ z + b
    d = np.abs(np.diagonal(A))
    d = np.where(d > 0, d, np.linalg.norm(A, axis=1))
    return np.abs(np.where(free, w, np.minimum(d * z, w))).max() / np.abs(b).max()


NAMES = ["Buck2_mlcp", "PD_mlcp", "RCD_mlcp", "diodeBridge20_mlcp", "m2n1_mlcp", "relay2_mlcp"]


@pytest.mark.parametrize("name", NAMES)
def test_circuit_problems_are_solved(families, name):
    problem = families.load("mlcp")[name]
    A, b, free = problem["M"].astype(float), problem["q"].astype(float), ~problem["is_comp"].astype(bool)
    result = solve_mlcp(A, b, free)
    assert result.success, result.message
    assert mixed_error(A, b, result.z, free) <= 1e-10


@pytest.mark.parametrize("way", ["_by_newton", "_by_enumeration"])
def test_the_ways_without_elimination_solve_a_singular_free_block(way):
    A = np.array([[0.0, 0.0, 1.0, 1.0], [0.0, 2.0, 0.0, 1.0], [-1.0, 0.0, 1.0, 0.0], [-1.0, -1.0, 0.0, 1.0]])
    b, free = np.array([-2.0, 1.0, 0.5, -1.0]), np.array([True, True, False, False])
    _, attempt = getattr(mixed, way)(A, b, free, "auto", 1e-10, None)
    assert mixed_error(A, b, attempt.z, free) <= 1e-10


def test_a_regular_free_block_gives_the_schur_complement_problem(families):
    rng = np.random.default_rng(0)
    for _ in range(10):
        A, b = families.p_matrix(rng, 9), rng.standard_normal(9)
        free = np.arange(9) % 3 == 0
        result = solve_mlcp(A, b, np.flatnonzero(free))
        assert mixed_error(A, b, result.z, free) <= 1e-12


def test_multipliers_of_equality_constraints_may_be_the_free_variables():
    """min |x|^2 / 2 + c.x, E x = e, x >= 0: the block of the multipliers is zero."""
    rng = np.random.default_rng(1)
    for _ in range(10):
        E, c = rng.uniform(0.1, 1, (3, 7)), rng.standard_normal(7)
        e = E @ rng.uniform(0, 1, 7)
        A = np.block([[np.eye(7), -E.T], [E, np.zeros((3, 3))]])
        b, free = np.concatenate([c, -e]), np.arange(10) >= 7
        result = solve_mlcp(A, b, free)
        assert result.success, result.message
        assert mixed_error(A, b, result.z, free) <= 1e-10


@pytest.mark.parametrize("scale", [1e-12, 1e12])
def test_scaling_changes_nothing(scale):
    A, b = np.array([[0.0, 1.0], [-1.0, 1.0]]), np.array([-2.0, 1.0])
    result = solve_mlcp(scale * A, b, [0])
    np.testing.assert_allclose(scale * result.z, [3.0, 2.0], rtol=1e-14)


def test_an_impossible_equation_is_infeasible():
    result = solve_mlcp([[0.0, 1.0], [0.0, 1.0]], [1.0, 1.0], [0])
    assert result.status == LCPStatus.INFEASIBLE
    assert result.certificate is not None


def test_without_free_variables_it_is_the_lcp():
    assert solve_mlcp([[2.0]], [-1.0], []).z.tolist() == [0.5]


def test_all_variables_free_is_a_linear_system():
    np.testing.assert_allclose(solve_mlcp([[2.0, 1.0], [0.0, 4.0]], [-1.0, 8.0], [0, 1]).z, [1.5, -2.0], rtol=1e-15)


@pytest.mark.parametrize("free", [[2], [-1], [0.5], np.array([True])])
def test_free_must_be_a_mask_or_indices(free):
    with pytest.raises(InvalidInput, match="free must be"):
        solve_mlcp(np.eye(2), np.ones(2), free)
