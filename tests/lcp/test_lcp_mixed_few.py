"""Few mixed unknowns in one compiled call: right, to rounding, and the same bits interpreted."""

import numpy as np
import pytest

from nonsmooth.jit import interpreted
from nonsmooth.lcp.mixed import ROUNDED_RESIDUAL, _by_elimination, mlcp_residual, solve_mlcp
from nonsmooth.lcp.mixed_few import mixed_memory, solve_mixed


def monotone(seed, n=9, rank=9):
    """A positive (semi-)definite problem of some free unknowns; its solution exists."""
    rng = np.random.default_rng(seed)
    root, skew = rng.normal(size=(n, rank)), rng.normal(size=(n, n))
    A = root @ root.T + skew - skew.T
    z, w = np.maximum(rng.normal(size=n), 0.0), np.zeros(n)
    w[z == 0.0] = rng.uniform(0.1, 1.0, np.count_nonzero(z == 0.0))
    free = np.zeros(n, dtype=bool)
    free[rng.choice(n, rng.integers(1, n), replace=False)] = True
    z[free], w[free] = rng.normal(size=free.sum()), 0.0
    return A, w - A @ z, free, z


def saddle(seed, n=8, equations=3):
    """min |x|^2 / 2 + c.x, E x = e, x >= 0: the block of the free multipliers is zero."""
    rng = np.random.default_rng(seed)
    E, c = rng.uniform(0.1, 1, (equations, n)), rng.standard_normal(n)
    A = np.block([[np.eye(n), -E.T], [E, np.zeros((equations, equations))]])
    return A, np.concatenate([c, -E @ rng.uniform(0, 1, n)]), np.arange(n + equations) >= n


def at_once(A, b, free, solve=solve_mixed):
    z, w = np.full(len(b), np.nan), np.full(len(b), np.nan)
    return solve(A, b, free, z, w, mixed_memory(len(b)), 1000), z, w


@pytest.mark.parametrize("seed", range(20))
def test_monotone_problems_have_the_solution_they_were_made_of(seed):
    A, b, free, z = monotone(seed)
    (_, residual), found, w = at_once(A, b, free)
    assert residual <= ROUNDED_RESIDUAL
    np.testing.assert_allclose(found, z, rtol=0, atol=100 * np.linalg.cond(A) * np.finfo(float).eps * np.abs(z).max())
    assert residual == pytest.approx(mlcp_residual(A, b, found, free), abs=1e-15)
    np.testing.assert_allclose(w, A @ found + b, atol=1e-13 * np.abs(b).max())


@pytest.mark.parametrize("seed", range(20))
def test_free_multipliers_are_exchanged_with_pairs(seed):
    """A_FF = 0: each free unknown needs a pair. Elimination by singular values is the second way."""
    A, b, free = saddle(seed)
    (_, residual), z, _ = at_once(A, b, free)
    assert residual <= ROUNDED_RESIDUAL
    name, second = _by_elimination(A, b, free, "auto", 1e-10, None)
    assert name == "lemke"
    np.testing.assert_allclose(z[~free], second.z[~free], atol=1e-10 * np.abs(z).max())  # x is unique


@pytest.mark.parametrize("problem", [monotone(3)[:3], saddle(3), monotone(4, rank=6)[:3]])
def test_the_source_gives_the_same_bits(problem):
    compiled, source = at_once(*problem), at_once(*problem, interpreted(solve_mixed))
    assert compiled[0] == source[0]
    assert compiled[1].tolist() == source[1].tolist() and compiled[2].tolist() == source[2].tolist()


@pytest.mark.parametrize("power", [-80, 60])
def test_units_change_no_bit(power):
    A, b, free, _ = monotone(5)
    (_, residual), z, w = at_once(A, b, free)
    scaled = at_once(np.ldexp(A, power), np.ldexp(b, power // 2), free)
    assert scaled[0][1] == residual
    assert (scaled[1] == np.ldexp(z, power // 2 - power)).all() and (scaled[2] == np.ldexp(w, power // 2)).all()


def test_what_has_no_pivots_is_left_to_the_other_ways():
    """0 z = 1 has no solution; 0 z = 0 has many, of which none is found here."""
    A, free = np.array([[0.0, 0.0], [0.0, 1.0]]), np.array([True, False])
    for b in ([1.0, -1.0], [0.0, -1.0]):
        assert at_once(A, np.array(b), free)[0] == (0, np.inf)
    assert not solve_mlcp(A, [1.0, -1.0], free).success
    assert solve_mlcp(A, [0.0, -1.0], free).z[1] == 1.0


def test_a_guess_and_a_named_solver_take_the_ways_that_know_them():
    A, b, free, z = monotone(6)
    assert "free variables eliminated (" in solve_mlcp(A, b, free, guess=z).message
    assert "free variables eliminated (" in solve_mlcp(A, b, free, solver="lemke").message
    assert "pivots, residual" in solve_mlcp(A, b, free).message
