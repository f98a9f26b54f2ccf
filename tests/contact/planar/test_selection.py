"""One selection rule: of one contact alone and of several, by what the rules say physically."""

import numpy as np
import pytest

from nonsmooth.contact.planar.enumerate import Tree, enumerate_modes, select
from nonsmooth.contact.planar.problem import problem_of
from nonsmooth.contact.planar.selection import FREE, PULL_MINUS, SLIDE_PLUS, STICK, Selection
from nonsmooth.contact.planar.single import solve_single
from nonsmooth.jit import interpreted
from nonsmooth.jit.blocks import new
from nonsmooth.mechanics.laws import StaticKinetic, law_row
from nonsmooth.mechanics.system import BILATERAL, GIVEN_FORCE, UNILATERAL, ContactMode

RULES = list(Selection)


def of_contacts(kinds, G, c, mu, mu_static, was_stuck, rule, N=1.0):
    """A problem whose contacts have a static and a kinetic coefficient."""
    n = len(kinds)
    problem = problem_of(np.array([[kind, 1] for kind in kinds]), np.array(G), np.array(c), mu, mu_static)
    problem.laws[:] = law_row(StaticKinetic(mu_static, mu), 0.0, 0.0, "newton", {})
    problem.mode[:] = np.where(np.broadcast_to(was_stuck, n), ContactMode.STICK, ContactMode.OPEN)
    problem.selection, problem.normal_impulse[:] = rule, N
    return problem


def taken_of_several(problem):
    """The modes that are taken from an enumeration, and how many solutions there are."""
    tree = new(Tree, n=problem.n, r=problem.r)
    found, _ = enumerate_modes(problem.address, tree.address)
    return tuple(int(mode) for mode in tree.modes[interpreted(select)(found, problem, tree)]), found


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("kind", [UNILATERAL, BILATERAL])
def test_a_contact_alone_takes_what_it_takes_in_an_enumeration(kind, rule):
    """Random contacts, some with a static coefficient above the kinetic one; some have several solutions."""
    rng, several = np.random.default_rng(4), 0
    for _ in range(600):
        C, B, c = rng.uniform(0.1, 3), rng.uniform(-2, 2), rng.normal(size=2)
        G = [[C, B], [B, B * B / C * rng.uniform(1.02, 3)]]
        mu = rng.uniform(0, 4)
        mu_static = mu * rng.choice([1.0, 1.5])
        problem = of_contacts([kind], G, c, mu, mu_static, rng.random() < 0.5, rule)
        (taken,), found = taken_of_several(problem)
        several += found > 1
        assert interpreted(solve_single)(0, problem)[0] == taken
    assert several > 25


# D_+ = 1 + 2 * 0.9 > 0, D_- = 1 - 2 * 0.9 < 0: stick, a slide that is stable and one that is a saddle
PARADOX = [[1.0, -0.9], [-0.9, 1.2]]
HYSTERESIS = [[1.0, 0.0], [0.0, 1.0]], [-1.0, 0.7]  # |P_F| = 0.7 P_N


@pytest.mark.parametrize(("kind", "c", "stuck", "moving"), [
    (UNILATERAL, [0.5, -1.0], {Selection.LIFT_OFF: FREE}, FREE),
    (BILATERAL, [0.5, -1.0], {Selection.LIFT_OFF: PULL_MINUS}, PULL_MINUS),
])  # fmt: skip
def test_in_a_paradox_lift_off_lets_go_also_what_stuck(kind, c, stuck, moving):
    for rule in RULES:
        for was_stuck in (True, False):
            expected = stuck.get(rule, STICK) if was_stuck else STICK if rule == Selection.IMPACT else moving
            problem = of_contacts([kind], PARADOX, c, 2.0, 2.0, was_stuck, rule)
            assert interpreted(solve_single)(0, problem)[0] == expected
            assert taken_of_several(problem) == ((expected,), 3)


@pytest.mark.parametrize("rule", RULES)
def test_what_static_friction_holds_is_no_paradox(rule):
    """What stuck sticks up to mu_s = 0.9 and what slides slides on by mu = 0.5; an impact stops it."""
    for was_stuck in (True, False):
        expected = STICK if was_stuck or rule == Selection.IMPACT else SLIDE_PLUS
        problem = of_contacts([UNILATERAL], *HYSTERESIS, 0.5, 0.9, was_stuck, rule)
        assert interpreted(solve_single)(0, problem)[0] == expected
        assert taken_of_several(problem) == ((expected,), 2)


@pytest.mark.parametrize("rule", RULES)
def test_two_contacts_that_share_nothing_take_what_each_takes_alone(rule):
    """A contact held by static friction, one that slides, in each order; and a paradox beside them."""
    G = np.zeros((6, 6))
    G[:2, :2], G[2:4, 2:4], G[4:, 4:] = PARADOX, *[np.eye(2)] * 2
    c = np.array([0.5, -1.0, -1.0, 0.7, -1.0, 0.7])
    for was_stuck in ([1, 1, 0], [1, 0, 1], [0, 1, 1], [0, 0, 0]):
        mu, mu_static = np.array([2.0, 0.5, 0.5]), np.array([2.0, 0.9, 0.9])
        problem = problem_of(np.array([[UNILATERAL, 1]] * 3), G, c, mu, mu_static)
        problem.mode[:], problem.selection = np.where(was_stuck, ContactMode.STICK, ContactMode.OPEN), rule
        alone = []
        for k in range(3):
            rows = slice(2 * k, 2 * k + 2)
            one = of_contacts([UNILATERAL], G[rows, rows], c[rows], mu[k], mu_static[k], was_stuck[k], rule)
            alone.append(interpreted(solve_single)(0, one)[0])
        assert taken_of_several(problem) == (tuple(alone), 12)


@pytest.mark.parametrize("rule", RULES)
def test_friction_under_a_given_force_knows_no_paradox_whatever_the_rule(rule):
    """N = 1 holds 0.7 up to mu_s = 0.9 where it stuck; what slides is not stopped, by an impact neither."""
    for was_stuck in (True, False):
        problem = of_contacts([GIVEN_FORCE], [[1.0]], [0.7], 0.5, 0.9, was_stuck, rule)
        expected = STICK if was_stuck else SLIDE_PLUS
        assert interpreted(solve_single)(0, problem)[0] == expected
        assert taken_of_several(problem)[0] == (expected,)
