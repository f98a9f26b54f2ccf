"""Several contacts: enumeration against brute force, random and rigid bodies, redundant contacts, unknown numbers."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns
from benchmarks.contact_scenes import Block, block
from models import RockingBlock


def assembled(system, q, u):
    """G (2 n, 2 n) and c (2 n,) of all contacts, rows (N, T) interleaved, for rows that are constant."""
    from nonsmooth.mechanics.system import FORCE, MASS, NORMAL, TANGENT

    M, h = system.evaluate(MASS, 0.0, q, u), system.evaluate(FORCE, 0.0, q, u)
    W = np.stack([system.evaluate(NORMAL, 0.0, q, u), system.evaluate(TANGENT, 0.0, q, u)[:, 0]], axis=1)
    W = W.reshape(-1, system.n_u)
    return W @ np.linalg.solve(M, W.T), W @ np.linalg.solve(M, h)


def check_against_brute_force(c, G, free, mu, slip, kinds, brute_force):
    """Same number of motions, and each found motion is one of those of brute force."""
    motions = brute_force(G, free, mu, slip, kinds)
    scale = np.abs(free).max()
    found = [np.column_stack([s.dgamma_N, s.dgamma_F]).ravel() for s in c.solutions]
    assert c.is_complete
    assert len(found) == len(motions), (c.n_solutions, len(motions))
    for motion in found:
        assert min(np.abs(motion - other).max() for other in motions) <= 1e-6 * scale  # the tolerance of HiGHS
    return len(found)


@pytest.mark.upkeep
@pytest.mark.parametrize("kinds", ["u", "b", "uu", "ub", "bb", "uuu", "ubu"])
def test_enumeration_agrees_with_brute_force_over_all_modes(kinds, references):
    make, randomise, brute_force = references
    template = make(len(kinds), kinds)
    rng = np.random.default_rng(len(kinds))
    met = set()
    for _ in range(30 if len(kinds) < 3 else 12):
        slip = rng.choice([-1.0, 0.0, 1.0], len(kinds))
        system, u = randomise(template, rng, slip)
        q = np.ones(system.n_q)
        G, free = assembled(system, q, u)
        c = ns.classify(system, 0.0, q, u)
        mu = system.laws[:, 3]
        met.add(check_against_brute_force(c, G, free, mu, slip, kinds, brute_force))
        for s in c.solutions:  # and each satisfies the laws as they are written
            assert_laws_hold(s, G, free, mu, slip, kinds)
    assert len(met) > 1  # several counts are met


def assert_laws_hold(s, G, free, mu, slip, kinds):
    gamma = G @ np.column_stack([s.la_N, s.la_F]).ravel() + free
    forces = np.abs(s.la_N).max() + np.abs(s.la_F).max()
    small = 1e-11 * (np.abs(free).max() + np.abs(G).max() * forces)
    for i, kind in enumerate(kinds):
        la_N, la_F = s.la_N[i], s.la_F[i]
        reach = mu[i] * (abs(la_N) if kind == "b" else la_N)
        rate = gamma[2 * i + 1] if slip[i] == 0 else slip[i]
        if kind == "u":
            assert la_N >= -small and gamma[2 * i] >= -small and abs(la_N * gamma[2 * i]) <= small * (1 + forces)
        else:
            assert abs(gamma[2 * i]) <= small
        assert abs(la_F) <= reach + small * (1 + mu[i])
        if abs(rate) > small:
            assert la_F == pytest.approx(-np.sign(rate) * reach, abs=small * (1 + mu[i]))


def test_contacts_at_rest_have_an_odd_number_of_solutions(references):
    # generic contacts in the plane at rest: the number of solutions is odd; of one contact it is 1 or 3
    make, randomise, _ = references
    for kinds, numbers in [("u", {1, 3}), ("b", {1, 3}), ("uu", None), ("uuu", None)]:
        template = make(len(kinds), kinds)
        rng = np.random.default_rng(11)
        met = set()
        for _ in range(200):
            system, _ = randomise(template, rng, np.zeros(len(kinds)))
            c = ns.classify(system, 0.0, np.ones(6), np.zeros(6))
            assert c.is_complete and c.n_solutions % 2 == 1
            met.add(c.n_solutions)
            if kinds == "u" and c.n_solutions == 3:
                names = {s.modes[0] for s in c.solutions}
                assert {"free", "stick"} < names
        assert met == numbers if numbers else {1, 3} <= met


def test_p_of_both_slips_is_never_negative_together(references):
    make, randomise, _ = references
    template = make(1, "u")
    rng = np.random.default_rng(4)
    for _ in range(200):
        system, u = randomise(template, rng, np.ones(1))
        c = ns.classify(system, 0.0, np.ones(6), u)
        assert c.p[0].max() > 0
        assert c.n_solutions == [[2, 0], [1, 1]][int(c.p[0, 0] > 0)][int(c.b[0] < 0)]


def tall_block(mu):
    """A block twice as high as wide: its corners have the critical friction 4/3 of the slender rod."""
    return RockingBlock(width=1.0, height=2.0, mu=mu)


def test_sliding_block_presses_on_both_corners_then_on_one_then_jams(references):
    # mu h/2 < w/2: both corners press; beyond, it tips over the leading one, which has p < 0 above 4/3
    *_, brute_force = references
    for mu, number, pressing in [(0.4, 1, 2), (0.9, 1, 1), (2.0, 0, 0)]:
        block = tall_block(mu)
        q, _ = block.state(tilt=0.0)
        for speed in (-1.0, 1.0):
            u = np.array([speed, 0.0, 0.0])
            c = ns.classify(block, 0.0, q, u)
            G, free = assembled(block.system(), q, u)
            found = check_against_brute_force(c, G, free, np.full(2, mu), np.full(2, speed), "uu", brute_force)
            assert found == number and bool(c.impacts) == (number == 0)
            assert [(s.la_N > 0).sum() for s in c.solutions] == [pressing] * number


def test_block_at_rest_is_held_by_redundant_friction(references):
    *_, brute_force = references
    block = tall_block(0.4)
    q, _ = block.state(tilt=0.0)
    c = ns.classify(block, 0.0, q, np.zeros(3))
    (solution,) = c.solutions
    assert c.is_complete and solution.modes == ("stick", "stick") and not solution.is_unique_force
    assert np.abs(solution.du).max() <= 1e-12 * block.g
    assert solution.la_N == pytest.approx(np.full(2, 0.5 * block.m * block.g), rel=1e-12)
    assert abs(solution.la_F.sum()) <= 1e-12 * block.m * block.g
    G, free = assembled(block.system(), q, np.zeros(3))
    assert len(brute_force(G, free, np.full(2, 0.4), np.zeros(2), "uu")) == 1


class Stool(NamedTuple):
    m: float = 2.0
    I: float = 0.5
    g: float = 9.81
    left: float = -0.6
    middle: float = 0.1
    right: float = 0.5
    h: float = 1.2
    mu: float = 0.3
    push: float = 0.0


def stool_mass(t, q, p, M):
    M[0, 0] = p.m
    M[1, 1] = p.m
    M[2, 2] = p.I


def stool_force(t, q, u, p, h):
    h[0] = p.push
    h[1] = -p.m * p.g


def stool_gap(t, q, p, g_N):
    g_N[0] = q[1] + p.left * math.sin(q[2]) - p.h * math.cos(q[2])
    g_N[1] = q[1] + p.middle * math.sin(q[2]) - p.h * math.cos(q[2])
    g_N[2] = q[1] + p.right * math.sin(q[2]) - p.h * math.cos(q[2])


def stool_normal(t, q, p, W_N):
    W_N[0, 2] = p.left * math.cos(q[2]) + p.h * math.sin(q[2])
    W_N[1, 2] = p.middle * math.cos(q[2]) + p.h * math.sin(q[2])
    W_N[2, 2] = p.right * math.cos(q[2]) + p.h * math.sin(q[2])
    W_N[0, 1] = W_N[1, 1] = W_N[2, 1] = 1.0


def stool_tangent(t, q, p, W_F):
    W_F[0, 0, 2] = -p.left * math.sin(q[2]) + p.h * math.cos(q[2])
    W_F[1, 0, 2] = -p.middle * math.sin(q[2]) + p.h * math.cos(q[2])
    W_F[2, 0, 2] = -p.right * math.sin(q[2]) + p.h * math.cos(q[2])
    W_F[0, 0, 0] = W_F[1, 0, 0] = W_F[2, 0, 0] = 1.0


STOOL = ns.System(
    n_q=3, mass=stool_mass, force=stool_force, gap=stool_gap, normal=stool_normal, tangent=stool_tangent,
    contacts=[ns.Contact(mu="mu")] * 3, parameters=Stool(),
)  # fmt: skip


@pytest.mark.parametrize("speed", [-1.0, 0.0, 1.0])
@pytest.mark.parametrize("mu", [0.3, 0.9, 2.5])
def test_three_legged_body_agrees_with_brute_force(mu, speed, references):
    # three feet on a plane: six rows for three coordinates, so that most combinations of modes are singular
    *_, brute_force = references
    system = STOOL.with_parameters(mu=mu, push=4.0)
    q, u = np.array([0.0, 1.2, 0.0]), np.array([speed, 0.0, 0.0])
    c = ns.classify(system, 0.0, q, u)
    G, free = assembled(system, q, u)
    check_against_brute_force(c, G, free, np.full(3, mu), np.full(3, speed), "uuu", brute_force)
    for s in c.solutions:
        assert_laws_hold(s, G, free, np.full(3, mu), np.full(3, speed), "uuu")


def test_rod_leaves_a_paradox_through_the_velocities_of_both_its_contacts(references):
    # several closed contacts: the impacts are the solutions P != 0 of gamma+ = G P + gamma-
    make, randomise, _ = references
    template = make(2, "uu")
    rng = np.random.default_rng(8)
    seen = 0
    for _ in range(60):
        slip = rng.choice([-1.0, 1.0], 2)
        system, u = randomise(template, rng, slip)
        c = ns.classify(system, 0.0, np.ones(6), u)
        G, _ = assembled(system, np.ones(6), u)
        before = np.column_stack([np.zeros(2), slip]).ravel()
        for impact in c.impacts:
            seen += 1
            P = np.column_stack([impact.P_N, impact.P_F]).ravel()
            after = G @ P + before
            np.testing.assert_allclose(np.column_stack([impact.gamma_N, impact.gamma_F]).ravel(), after, atol=1e-9)
            assert impact.P_N.min() >= -1e-12 and np.abs(impact.P_N * impact.gamma_N).max() <= 1e-9 * (1 + P @ P)
            reach = system.laws[:, 3] * impact.P_N
            assert (np.abs(impact.P_F) <= reach + 1e-9 * (1 + np.abs(P).max())).all()
            # work of friction is not positive: the impact takes energy
            assert P @ (before + after) <= 1e-9 * (1 + P @ P)
        if c.kind == ns.ParadoxKind.INCONSISTENT:
            assert c.impacts  # existence fails only where velocities can jump
    assert seen > 10


def test_more_contacts_than_are_enumerated_are_said_to_be_so(references):
    make, randomise, _ = references
    template = make(10, "u" * 10)  # 4^10 modes at rest
    system, _ = randomise(template, np.random.default_rng(1), np.zeros(10))
    c = ns.classify(system, 0.0, np.ones(6), np.zeros(6))
    assert not c.is_complete and c.kind == ns.ParadoxKind.NOT_ENUMERATED
    assert "NOT_ENUMERATED" in str(c)


def test_a_block_on_more_feet_than_are_tried_is_said_not_to_be_enumerated(monkeypatch):
    """The interpreter refuses every index out of the arrays of 18 contacts, which compiled code would not."""
    monkeypatch.setenv("NONSMOOTH_INTERPRET", "1")
    c = ns.classify(block(20, Block()), 0.0, np.zeros(3), np.zeros(3))
    assert not c.is_complete and c.kind == ns.ParadoxKind.NOT_ENUMERATED


def test_eight_contacts_at_rest_are_enumerated(references):
    # eight independent unit contacts: each presses with its weight and sticks, or slides alone, in one way
    class Feet(NamedTuple):
        g: float = 1.0
        push: float = 0.3

    def mass(t, q, p, M):
        for j in range(16):
            M[j, j] = 1.0

    def force(t, q, u, p, h):
        for i in range(8):
            h[2 * i] = p.push * i
            h[2 * i + 1] = -p.g

    def gap(t, q, p, g_N):
        for i in range(8):
            g_N[i] = q[2 * i + 1]

    def normal(t, q, p, W_N):
        for i in range(8):
            W_N[i, 2 * i + 1] = 1.0

    def tangent(t, q, p, W_F):
        for i in range(8):
            W_F[i, 0, 2 * i] = 1.0

    feet = ns.System(n_q=16, mass=mass, force=force, gap=gap, normal=normal, tangent=tangent,
                     contacts=[ns.Contact(mu=1.0)] * 8, parameters=Feet())  # fmt: skip
    c = ns.classify(feet, 0.0, np.zeros(16), np.zeros(16))
    assert c.is_complete and c.n_solutions == 1
    assert c.solutions[0].modes == ("stick",) * 4 + ("slide +",) * 4  # 0.3 i <= 1 sticks


def feet(n):
    """n unit feet that slide with a coupling of their own: p = 1 + mu c for slip -, weight 1. Neighbours drag masses of
    each other along, so that all are one island; feet that stay down feel nothing of that."""

    class Feet(NamedTuple):
        g: float = 1.0
        c: float = 0.5
        mu: float = 0.5

    def mass(t, q, p, M):
        for j in range(2 * n):
            M[j, j] = 1.0
        for i in range(n - 1):
            M[2 * i + 1, 2 * i + 3] = M[2 * i + 3, 2 * i + 1] = 0.1

    def force(t, q, u, p, h):
        for i in range(n):
            h[2 * i + 1] = -p.g

    def gap(t, q, p, g_N):
        for i in range(n):
            g_N[i] = q[2 * i + 1]

    def normal(t, q, p, W_N):
        for i in range(n):
            W_N[i, 2 * i + 1] = 1.0

    def tangent(t, q, p, W_F):
        for i in range(n):
            W_F[i, 0, 2 * i] = 1.0
            W_F[i, 0, 2 * i + 1] = p.c

    return ns.System(n_q=2 * n, mass=mass, force=force, gap=gap, normal=normal, tangent=tangent,
                     contacts=[ns.Contact(mu="mu")] * n, parameters=Feet())  # fmt: skip


def test_sliding_contacts_beyond_enumeration_are_certified_by_a_p_matrix():
    system, u = feet(20), np.tile([1.0, 0.0], 20)  # 2^20 modes
    c = ns.classify(system, 0.0, np.zeros(40), u)
    assert c.is_always_regular and c.is_complete and c.kind == ns.ParadoxKind.REGULAR and len(c.islands) == 1
    assert c.solutions[0].la_N == pytest.approx(np.full(20, 1 / (1 - 0.5 * 0.5)), rel=1e-12)  # p = 1 - mu c
    assert c.solutions[0].la_F == pytest.approx(np.full(20, -0.5 / 0.75), rel=1e-12)
    steep = ns.classify(system.with_parameters(mu=3.0), 0.0, np.zeros(40), u)  # p = -1/2 each
    assert steep.is_always_regular is False and not steep.is_complete
    assert steep.kind == ns.ParadoxKind.NOT_ENUMERATED


def test_certificate_is_true_to_the_number_of_solutions(references):
    make, randomise, _ = references
    template = make(3, "uuu")
    rng = np.random.default_rng(21)
    met = set()
    for _ in range(80):
        slip = rng.choice([-1.0, 1.0], 3)
        system, u = randomise(template, rng, slip)
        c = ns.classify(system, 0.0, np.ones(6), u)
        met.add((c.is_always_regular, c.n_solutions))
        assert c.n_solutions == 1 or not c.is_always_regular
    assert {(True, 1), (False, 1)} < met and len(met) > 3
    assert ns.classify(system, 0.0, np.ones(6), np.zeros(6)).is_always_regular is None


def test_impacts_of_bodies_with_redundant_contacts_are_all_found(references):
    # velocities gamma+ = G P + gamma-: brute force, where the motion without impulses is one more
    *_, brute_force = references
    block = tall_block(2.0)
    stool = STOOL.with_parameters(mu=2.5)
    for system, q in [(block.system(), block.state(tilt=0.0)[0]), (stool, np.array([0.0, 1.2, 0.0]))]:
        n = system.n_c
        for speed in (-1.0, 1.0):
            c = ns.classify(system, 0.0, q, [speed, 0.0, 0.0])
            G, _ = assembled(system, q, np.zeros(3))
            before = np.column_stack([np.zeros(n), np.full(n, speed)]).ravel()
            motions = brute_force(G, before, system.laws[:, 3], np.zeros(n), "u" * n)
            assert len(c.impacts) == len(motions) - 1 > 0
            for impact in c.impacts:
                after = np.column_stack([impact.gamma_N, impact.gamma_F]).ravel()
                assert min(np.abs(after - motion).max() for motion in motions) <= 1e-6


def test_eight_bilateral_contacts_at_rest_are_enumerated():
    # independent guides, each loaded by g with the coupling c: p_+- = 1 -+ mu c > 0, one mode each, 5^8 are tried
    system = feet(8)
    guides = ns.System(**{name: getattr(system, name) for name in ("n_q", "mass", "force", "gap", "normal", "tangent")},
                       contacts=[ns.Contact(mu="mu", bilateral=True)] * 8, parameters=system.parameters)  # fmt: skip
    c = ns.classify(guides, 0.0, np.zeros(16), np.zeros(16))
    assert c.is_complete and c.n_solutions == 1
    # stick: la_F = -c la_N/(1 + c^2) ... within the cone iff |la_F| <= mu |la_N|
    G = np.array([[1.0, 0.5], [0.5, 1.25]])
    la_N, la_F = -np.linalg.solve(G, [-1.0, -0.5])
    assert abs(la_F) <= 0.5 * la_N
    assert c.solutions[0].la_N == pytest.approx(np.full(8, la_N), rel=1e-12)
