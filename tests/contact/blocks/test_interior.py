"""Interior points: the algebra of the cone, and problems that stop the other methods."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.problems import FAMILIES
from nonsmooth.contact.blocks.interior import Interior, correct
from nonsmooth.contact.blocks.problem import check_problem, scale_problem
from nonsmooth.contact.blocks.second_order_cone import (
    distance_to_boundary,
    jordan_product,
    jordan_quotient,
    scale,
    scaling_point,
)
from nonsmooth.contact.blocks.solve import solve_contact
from nonsmooth.jit import interpreted

SEEDS = st.integers(0, 2**32 - 1)


def inside(rng, depth=1.0):
    """A point of the cone, some way from its boundary."""
    T = rng.normal(size=2)
    return np.array([np.hypot(*T) + depth * rng.uniform(0.1, 1), *T])


@settings(max_examples=50, deadline=None)
@given(SEEDS)
def test_the_scaling_matrix_maps_x_and_y_on_one_point(seed):
    rng = np.random.default_rng(seed)
    x, y = inside(rng), inside(rng)
    w_N, w_1, w_2, eta = interpreted(scaling_point)(*x, *y)
    from_y = np.array(interpreted(scale)(w_N, w_1, w_2, eta, *y))
    from_x = np.array(interpreted(scale)(w_N, -w_1, -w_2, 1 / eta, *x))
    np.testing.assert_allclose(from_y, from_x, rtol=1e-10, atol=1e-10 * from_y[0])
    assert from_y @ from_y == pytest.approx(x @ y, rel=1e-10)  # W keeps the gap


@settings(max_examples=50, deadline=None)
@given(SEEDS)
def test_the_quotient_undoes_the_product(seed):
    rng = np.random.default_rng(seed)
    a, q = inside(rng), rng.normal(size=3)
    b = interpreted(jordan_product)(*a, *q)
    np.testing.assert_allclose(
        interpreted(jordan_quotient)(*a, *b), q, rtol=0, atol=1e-12 * np.abs(q).max() * (a @ a) / 0.01
    )


@settings(max_examples=50, deadline=None)
@given(SEEDS)
def test_the_way_out_ends_on_the_boundary(seed):
    rng = np.random.default_rng(seed)
    x, d = inside(rng), rng.normal(size=3)
    length = interpreted(distance_to_boundary)(*x, *d)
    if np.isinf(length):
        assert d[0] >= np.hypot(*d[1:]) * (1 - 1e-12)  # only directions of the cone never leave it
    else:
        end = x + length * d
        assert abs(end[0] - np.hypot(*end[1:])) < 1e-10 * (1 + abs(end[0]))
        before = x + 0.999 * length * d
        assert before[0] > np.hypot(*before[1:])


@settings(max_examples=50, deadline=None)
@given(SEEDS)
def test_the_way_out_along_the_axis_ends_at_the_apex(seed):
    rng = np.random.default_rng(seed)
    x_N, d_N = rng.uniform(0.1, 1), -rng.uniform(0.1, 1)
    assert interpreted(distance_to_boundary)(x_N, 0.0, 0.0, d_N, 0.0, 0.0) == pytest.approx(-x_N / d_N, rel=1e-6)


def test_the_interpreted_corrector_agrees():
    rng = np.random.default_rng(0)
    n_c = 4
    x, y = (np.array([inside(rng) for _ in range(n_c)]) for _ in range(2))
    w = np.array([interpreted(scaling_point)(*a, *b) for a, b in zip(x, y, strict=True)])
    dx, dy = rng.normal(size=(2, n_c, 3))
    compiled, plain = np.empty((2, n_c, 3))
    correct(w, y, dx, dy, 0.1, compiled)
    interpreted(correct)(w, y, dx, dy, 0.1, plain)
    np.testing.assert_allclose(compiled, plain, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_sliding_block_is_stopped_by_mu_times_its_weight(dim):
    """G = I / m, c = (-g dt, v): P_N = m g dt, P_T = -mu P_N along the slip."""
    m, impulse, v, mu = 2.0, 0.3, 5.0, 0.4
    c = np.zeros(dim)
    c[0], c[1] = -impulse / m, v
    problem, factor = scale_problem(check_problem(np.eye(dim) / m, c, mu, dim))
    P, _ = Interior().run(problem, np.zeros(dim), 1e-10)
    expected = np.zeros(dim)
    expected[0], expected[1] = impulse, -mu * impulse
    np.testing.assert_allclose(factor * P, expected, atol=1e-9 * v * m)


def test_where_there_is_no_friction_there_is_no_tangential_impulse():
    case = FAMILIES["assembly"](np.random.default_rng(1), 12, 3)
    mu = case.mu.copy()
    mu[::2] = 0.0
    problem, _ = scale_problem(check_problem(case.G, case.c, mu, 3))
    P, _ = Interior().run(problem, np.zeros(problem.n), 1e-9)
    assert problem.error(P) <= 1e-9
    assert not P.reshape(-1, 3)[::2, 1:].any()


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("seed", range(4))
def test_towers_with_masses_over_six_decades_stand(seed, dim):
    """Twelve to twenty-five blocks, the heavy ones anywhere: sweeps and alternating directions do not get there."""
    result = solve_contact(*FAMILIES["tower"](np.random.default_rng([seed, 50]), 50, dim))
    assert result.success, result.message


@pytest.mark.parametrize(
    ("size", "seed", "dim"), [(60, 408, 3), (90, 412, 3), (130, 407, 3), (160, 403, 2), (160, 411, 2)]
)
def test_tall_towers_stand_from_far_inside_the_cones(size, seed, dim):
    """Paths from nearer by stop where a tenth of the motion is left."""
    result = solve_contact(*FAMILIES["tower"](np.random.default_rng(seed), size, dim))
    assert result.success, result.message


@pytest.mark.parametrize("seed", range(4))
def test_few_steps_settle_a_planar_packing_of_hundreds_of_contacts(seed):
    problem, _ = scale_problem(check_problem(*FAMILIES["packing"](np.random.default_rng(seed), 300, 2)))
    P, steps = Interior().run(problem, np.zeros(problem.n), 1e-8)
    assert problem.error(P) <= 1e-8 and steps <= 40


def test_a_matrix_of_nonsense_ends_with_the_best_iterate():
    problem, _ = scale_problem(check_problem(-np.eye(4), -np.ones(4), 0.5, 2))
    with np.errstate(all="ignore"):
        P, _ = Interior().run(problem, np.zeros(4), 1e-8)
    assert np.isfinite(P).all() and problem.error(P) <= problem.error(np.zeros(4))
