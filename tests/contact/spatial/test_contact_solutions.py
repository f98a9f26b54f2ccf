"""Every solution of one contact with the round cone, against a sampling of directions that proves what it finds.

A slide has the direction d of gamma_T, P_N = -c_N/p, p = G_NN - mu G_NT d, and d x gamma_T = 0. With p,

    F(d) = d x (p c_T - c_N (G_TN - mu G_TT d)) = 0

is a trigonometric polynomial of degree 2 in the angle of d. Nothing of the quartic in alpha is in it.
"""

import math

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.contact.spatial.exact_count import count_slides

DIRECTIONS = 180
HALVINGS = 24  # of cells of directions: an angle of 2e-9


def random_contacts(n, rng):
    """G (n, 3, 3), c (n, 3) and mu (n,) up to three times where p = 0, velocities of unlike sizes."""
    A = rng.normal(size=(n, 3, 3))
    G = A @ A.transpose(0, 2, 1) + 0.05 * np.eye(3)
    c = rng.normal(size=(n, 3)) * 10.0 ** rng.uniform(-1, 1, size=(n, 3))
    return G, c, rng.uniform(0.0, 3.0, n) * G[:, 0, 0] / np.linalg.norm(G[:, 0, 1:], axis=1)


def along(G, c, mu, angle):
    """F, p and d . gamma_T p of directions; the problems are those of the first axes."""
    d = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    p = G[..., 0, 0] - mu * (G[..., 0, 1:] * d).sum(-1)
    k = G[..., 1:, 0] - mu[..., None] * (G[..., 1:, 1:] * d[..., None, :]).sum(-1)
    T = p[..., None] * c[..., 1:] - c[..., :1] * k
    return d[..., 0] * T[..., 1] - d[..., 1] * T[..., 0], p, (d * T).sum(-1)


def bounds_of(G, c, mu):
    """Largest |F''| and |(p, d . T)'| over all directions, by the sizes of their terms."""
    g, k = np.linalg.norm(G[:, 0, 1:], axis=1), np.linalg.norm(G[:, 1:, 0], axis=1)
    s, b, S = np.linalg.norm(c[:, 1:], axis=1), np.abs(c[:, 0]), np.linalg.norm(G[:, 1:, 1:], axis=(1, 2))
    largest = (G[:, 0, 0] + mu * g) * s + b * (k + mu * S)
    return 4.0 * largest, mu * g, 2.0 * largest


def sampled(G, c, mu):
    """Slides of each problem (n,); cells of directions are halved until Taylor's bounds decide them: -1 where they do
    not."""
    n, h = len(mu), 2.0 * math.pi / DIRECTIONS
    curvature, of_p, of_T = bounds_of(G, c, mu)
    which, cell = (x.ravel() for x in np.meshgrid(np.arange(n), np.arange(DIRECTIONS), indexing="ij"))
    low, found = -math.pi + h * cell, np.zeros(n, int)
    for _ in range(HALVINGS):
        one, other = (along(G[which], c[which], mu[which], low + x) for x in (0.0, h))
        slack = curvature[which] * h * h / 8.0
        crosses = (one[0] < 0.0) != (other[0] < 0.0)
        has_none = ~crosses & (np.minimum(np.abs(one[0]), np.abs(other[0])) > slack)
        has_one = crosses & (np.abs(one[0] - other[0]) > 4.0 * slack)
        is_sure = (np.abs(one[1]) > of_p[which] * h) & (np.abs(one[2]) > of_T[which] * h)
        slides = (-c[which, 0] * one[1] > 0.0) & (one[1] * one[2] > 0.0)
        np.add.at(found, which[has_one & is_sure & slides], 1)
        left = ~has_none & ~(has_one & is_sure)
        h /= 2.0
        which, low = np.repeat(which[left], 2), (low[left, None] + [0.0, h]).ravel()
    found[which] = -1
    return found


def check(G, c, mu):
    """Count and laws of each problem; the number with several solutions."""
    several, counts = 0, sampled(G, c, mu)
    assert (counts >= 0).mean() > 0.9999
    for i in np.flatnonzero(counts >= 0):
        found = ns.contact_solutions(G[i], c[i], mu[i])
        stick = -np.linalg.solve(G[i], c[i])
        sticks = stick[0] > 0 and np.linalg.norm(stick[1:]) < mu[i] * stick[0]
        assert found.is_complete
        assert len(found) == int(c[i, 0] > 0) + int(sticks) + counts[i]
        several += len(found) > 1
        for mode, P, gamma in zip(found.modes, found.P, found.gamma, strict=True):
            size = np.abs(c[i]).max() + np.abs(G[i]).max() * np.abs(P).max()
            friction, speed = np.linalg.norm(P[1:]), np.linalg.norm(gamma[1:])
            assert P[0] >= 0 and gamma[0] >= -1e-12 * size and abs(P[0] * gamma[0]) < 1e-12 * size * (1 + P[0])
            assert friction <= mu[i] * P[0] * (1 + 1e-12)
            if mode == "slide":
                assert friction == pytest.approx(mu[i] * P[0], rel=1e-12)
                assert P[1:] @ gamma[1:] == pytest.approx(-friction * speed, rel=1e-6, abs=1e-9 * friction * size)
            if mode == "stick":
                assert np.abs(gamma).max() < 1e-9 * size
    return several


@pytest.mark.upkeep
def test_all_solutions_of_one_contact_are_those_of_all_directions():
    assert check(*random_contacts(3_000, np.random.default_rng(5))) > 100


@pytest.mark.stress
def test_all_solutions_of_100_000_contacts_are_those_of_all_directions():
    rng = np.random.default_rng(6)
    assert sum(check(*random_contacts(1_000, rng)) for _ in range(100)) > 5_000


@pytest.fixture(scope="module")
def regular_along_every_direction():
    """Pressed contacts with mu below G_NN/|G_NT|, so that p > 0 along every direction, that have several slides."""
    G, c, mu = random_contacts(10_000, np.random.default_rng(0))
    mu, c[:, 0] = 0.97 * G[:, 0, 0] / np.linalg.norm(G[:, 0, 1:], axis=1), -np.abs(c[:, 0])
    several = sampled(G, c, mu) > 1
    return G[several], c[several], mu[several]


@pytest.mark.upkeep
def test_several_slides_at_once_are_found_where_no_direction_is_paradoxical(regular_along_every_direction):
    assert len(regular_along_every_direction[2]) > 5
    for G, c, mu in zip(*regular_along_every_direction, strict=True):
        found = ns.contact_solutions(G, c, mu)
        assert found.modes.count("slide") >= 2 and found.is_complete


def test_the_exact_count_is_that_of_roots_placed_by_hand():
    """G without coupling: one slide wherever the contact neither opens nor sticks; p = b = 0: infinitely many."""
    G = np.diag([1.0, 2.0, 3.0])
    assert count_slides(G, np.array([-1.0, 4.0, 0.0]), 0.5) == 1
    assert count_slides(G, np.array([-1.0, 0.5, 0.0]), 0.5) == 0
    assert count_slides(G, np.array([1.0, 4.0, 0.0]), 0.5) == 0
    along_x = np.array([[1.0, 0.5, 0.0], [0.5, 1.0, 0.0], [0.0, 0.0, 1.0]])
    assert count_slides(along_x, np.array([0.0, 3.0, 0.0]), 2.0) is None
    found = ns.contact_solutions(along_x, [0.0, 3.0, 0.0], 2.0)
    assert not found.is_complete and found.modes == ("free", "stick")


def test_folds_of_two_slides_are_found_to_the_last_place(regular_along_every_direction):
    """c_N is halved until the exact count falls between two neighbours; a millionth to either side of a fold, where
    the count falls by two, the roots in floating point are as many."""
    folds = 0
    for G, c, mu in zip(*regular_along_every_direction, strict=True):

        def count(b, G=G, c=c, mu=mu):
            return count_slides(G, np.array([b, *c[1:]]), mu)

        low, high = c[0], 1e3 * c[0]
        while (middle := 0.5 * (low + high)) not in (low, high):
            low, high = (middle, high) if count(middle) >= 2 else (low, middle)
        if count(low) - count(high) == 2:
            folds += 1
            for b, slides in ((low * (1 - 1e-6), count(low)), (high * (1 + 1e-6), count(high))):
                found = ns.contact_solutions(G, [b, *c[1:]], mu)
                assert found.modes.count("slide") == slides and found.is_complete
    assert folds >= 3


def test_planar_friction_has_open_stick_and_two_slides():
    G = [[1.0, 0.8], [0.8, 1.0]]
    assert ns.contact_solutions(G, [-1.0, 3.0], 0.5).modes == ("slide",)
    wedged = ns.contact_solutions(G, [0.5, -1.0], 2.0)  # free and moving, or held, or sliding with p < 0
    assert wedged.modes == ("free",)
    held = ns.contact_solutions(G, [0.5, 1.0], 2.0)
    assert set(held.modes) == {"free", "stick", "slide"} and held.is_complete
    assert held.P.shape == (3, 2) and held.gamma.shape == (3, 2)


def test_without_friction_a_pressed_contact_slides_freely():
    found = ns.contact_solutions(np.eye(3), [-2.0, 1.0, 1.0], 0.0)
    assert found.modes == ("slide",) and found.P.tolist() == [[2.0, 0.0, 0.0]]


def test_sticking_has_its_own_coefficient():
    c = [-1.0, 0.6, 0.0]
    assert ns.contact_solutions(np.eye(3), c, 0.5).modes == ("slide",)
    assert ns.contact_solutions(np.eye(3), c, 0.5, mu_static=0.7).modes == ("stick", "slide")


def test_a_singular_contact_is_not_called_complete():
    assert not ns.contact_solutions(np.outer([1.0, 0.5, 0.2], [1.0, 0.5, 0.2]), [-1.0, 0.1, 0.3], 0.4).is_complete
