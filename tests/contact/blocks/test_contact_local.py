"""One contact: the inclusion itself, and in the plane an independent walk through the modes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nonsmooth.contact.blocks.nsgs import NSGS, local_planar
from nonsmooth.contact.blocks.problem import check_problem
from nonsmooth.contact.blocks.result import ContactStatus
from nonsmooth.contact.blocks.single_spatial import local_spatial
from nonsmooth.contact.blocks.solve import solve_contact
from nonsmooth.jit import interpreted

SEEDS = st.integers(0, 2**32 - 1)
ROUNDING = 1e-11  # 1e-16 times a condition number up to 1e4, with room


def random_contact(seed, dim):
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(dim, dim))
    G = root @ root.T + 1e-3 * np.eye(dim)
    scale = 10.0 ** rng.uniform(-3, 3)
    return scale * G, rng.normal(size=dim), float(rng.choice([0.0, 0.1, 0.5, 1.0, 3.0]))


def violation(G, c, mu, P):
    """How far (P, gamma) is from open, stick and slide, each tested in its own words; the least of the three."""
    gamma = G @ P + c
    velocity, impulse = np.linalg.norm(c), np.linalg.norm(c) / np.trace(G)
    P_T, gamma_T = np.linalg.norm(P[1:]), np.linalg.norm(gamma[1:])
    is_open = max(np.linalg.norm(P) / impulse, -gamma[0] / velocity)
    stick = max(np.linalg.norm(gamma) / velocity, (P_T - mu * P[0]) / impulse)
    slide = max(
        abs(gamma[0]) / velocity,
        -P[0] / impulse,
        abs(P_T - mu * P[0]) / impulse,
        (P[1:] @ gamma[1:] + P_T * gamma_T) / (impulse * velocity),
    )
    return min(is_open, stick, slide)


@settings(max_examples=150, deadline=None)
@given(SEEDS, st.sampled_from([2, 3]))
def test_single_contact_satisfies_the_inclusion_of_one_of_its_modes(seed, dim):
    G, c, mu = random_contact(seed, dim)
    result = solve_contact(G, c, mu, dim, tol=1e-10)
    assert result.status is ContactStatus.SOLVED
    assert result.solver == "single"
    assert violation(G, c, mu, result.P) < ROUNDING * np.linalg.cond(G)


@settings(max_examples=100, deadline=None)
@given(SEEDS)
def test_planar_contact_agrees_with_brute_force_over_modes(seed):
    G, c, mu = random_contact(seed, 2)
    candidates = [np.zeros(2), -np.linalg.solve(G, c)]
    for sign in (1.0, -1.0):
        normal = -c[0] / (G[0, 0] - sign * mu * G[0, 1])
        candidates.append(np.array([normal, -sign * mu * normal]))
    admissible = [P for P in candidates if P[0] >= -1e-14 and violation(G, c, mu, P) < 1e-9]
    P = solve_contact(G, c, mu, 2).P
    size = np.linalg.norm(c) / np.linalg.eigvalsh(G)[0]
    assert min(np.linalg.norm(P - other) for other in admissible) < 1e-9 * size


@pytest.mark.parametrize("kernel_and_dim", [(local_planar, 2), (local_spatial, 3)])
def test_compiled_sweep_equals_the_interpreted_local_solution(kernel_and_dim):
    kernel, dim = kernel_and_dim
    for seed in range(20):
        G, c, mu = random_contact(seed, dim)
        expected = interpreted(kernel)(G[None], 0, *c, mu)
        P, _ = NSGS(max_sweeps=1).run(check_problem(G, c, mu, dim), np.zeros(dim), 0.0)
        np.testing.assert_allclose(P, expected, rtol=1e-9, atol=1e-9 * np.abs(P).max())


def test_indeterminate_contact_with_negative_normal_resistance_is_reported_not_hidden():
    """G_NN - mu G_NT < 0 with c_N < 0 and no stick: no mode holds for this matrix, which is not positive definite."""
    result = solve_contact([[1.0, 2.0], [2.0, -1.0]], [-1.0, 1.0], 0.0, 2)
    assert result.status is ContactStatus.SOLVED  # frictionless: only G_NN counts
    G = np.array([[-1.0, 0.0], [0.0, 1.0]])
    result = solve_contact(G, [-1.0, 1.0], 0.5, 2)
    assert result.status is ContactStatus.NO_SOLUTION
    assert result.error > 0.1


def test_spatial_contact_without_coupling_decelerates_along_its_slip():
    """G = I: P_N = 1, P_T = -mu along the slip (3, 4)/5, whatever its direction in the plane."""
    result = solve_contact(np.eye(3), [-1.0, 3.0, 4.0], 0.5, 3)
    np.testing.assert_allclose(result.P, [1.0, -0.3, -0.4], atol=4e-16)


@pytest.mark.parametrize("solver", ["auto", "single", "nsgs", "newton", "interior"])
@pytest.mark.parametrize("dim", [2, 3])
def test_a_contact_without_friction_that_opens_straight_has_no_impulse(dim, solver):
    """Without friction and sliding the cone is a ray and the point lies on its line, behind its tip."""
    result = solve_contact(np.eye(dim), [1.0, *[0.0] * (dim - 1)], [0.0], dim, solver=solver)
    assert result.success and result.error == 0.0 and not result.P.any()
