"""A census that is not taken anew in each step: what it can miss, and that it says so."""

import numpy as np

import nonsmooth as ns
from benchmarks.contacts import at_rest, struck_stack
from nonsmooth.contact.planar.census import MATERIAL
from nonsmooth.contact.planar.enumerate import Tree, enumerate_modes
from nonsmooth.contact.planar.ladder import Route, solve_planar
from nonsmooth.contact.planar.lemke import pivot
from nonsmooth.contact.planar.problem import Planar, problem_of
from nonsmooth.contact.planar.single import FREE, SLIDE_PLUS, STICK
from nonsmooth.contact.planar.single import slip_of as compiled_slip_of
from nonsmooth.jit import interpreted, load_all
from nonsmooth.jit.blocks import new
from nonsmooth.mechanics.laws import Coulomb, law_row
from nonsmooth.mechanics.system import UNILATERAL

N = 4  # contacts: 256 combinations of modes, more than are tried with each problem
KINDS = np.tile([UNILATERAL, 1], (N, 1))
slip_of = interpreted(compiled_slip_of)
LOOKED_AT = 400  # problems on the way from one to another


class Steps:
    """``solve_planar`` on one problem after the other, as Moreau's step calls it."""

    def __init__(self, mu):
        load_all((solve_planar, enumerate_modes, pivot))
        self.problem, self.planar = problem_of(KINDS, np.eye(2 * N), np.zeros(2 * N), mu, mu), new(Planar, n=N, d=1)
        self.planar.may_wait = 1
        self.problem.laws[:] = [law_row(Coulomb(m), 0.0, 0.0, "newton", {}) for m in mu]

    def solve(self, G, c):
        """(route, solutions, whether they were counted)"""
        problem = self.problem
        problem.G[:], problem.c[:], problem.offset[:] = G, c, c
        route, found, _, _ = solve_planar(problem.address, self.planar.address)
        if route > Route.NO_SOLUTION:
            problem.previous_P[:] = problem.P.reshape(N, 2)
            for k, candidate in enumerate(problem.candidate):
                names = {FREE: ns.ContactMode.OPEN, STICK: ns.ContactMode.STICK}
                problem.mode[k] = names.get(candidate, ns.ContactMode.SLIDE)
                problem.slip[k] = slip_of(candidate) if candidate >= SLIDE_PLUS else 0
        return route, found, self.planar.is_counted == 1


def random_problem(rng):
    W = rng.normal(size=(2 * N, 2 * N + 1))
    W[1::2] += rng.uniform(-3.0, 3.0, (N, 1)) * W[::2]  # sliding couples to the gap: paradoxes are rare otherwise
    return W @ W.T, rng.normal(size=2 * N)


def test_a_paradox_on_the_way_is_seen_before_the_numbers_have_changed_by_a_hundredth():
    """Problems that drift from one to another, beside an enumeration of all modes of each of them."""
    tree, rng = new(Tree, n=N, r=2 * N), np.random.default_rng(4)
    seen = late = said = 0
    for trial in range(24):
        mu = rng.uniform(0.0, 3.0, N)
        (G_0, c_0), (G_1, c_1) = random_problem(rng), random_problem(rng)
        if trial % 2:
            G_1 = G_0
        steps, last_regular = Steps(mu), None
        for s in np.linspace(0.0, 1.0, LOOKED_AT):
            G, c = (1.0 - s) * G_0 + s * G_1, (1.0 - s) * c_0 + s * c_1
            problem = problem_of(KINDS, G, c, mu, mu)
            expected, is_complete = enumerate_modes(problem.address, tree.address)
            route, found, is_counted = steps.solve(G, c)
            assert is_complete and (route > Route.NO_SOLUTION or expected == 0)
            if expected == 1:
                last_regular = G, c
                assert found == 1
                continue
            if route == Route.NO_SOLUTION or found > 1:
                seen += 1
            elif not is_counted:
                said += 1
            else:
                late += 1
                G_j, c_j = last_regular
                assert (np.abs(c - c_j) <= 1.1 * MATERIAL * np.abs(c_j)).all()
                assert (np.abs(G - G_j) <= 1.1 * MATERIAL * np.sqrt(np.outer(G.diagonal(), G.diagonal()))).all()
    assert seen > 100 and said > 100 and 0 < late < 0.1 * (seen + said)  # each branch is reached


def run(scene):
    return ns.simulate(scene.system, (0.0, 0.1), scene.q0, scene.u0, integrator=ns.MoreauJean(1e-3))


def test_a_census_that_waits_is_said_in_the_summary():
    """A stack of six boxes has 4^12 combinations of modes; a block at rest on five feet those of one on two."""
    stack, rest = run(struck_stack(12)), run(at_rest(5))
    assert stack.stats.uncounted > 50
    assert f"in {stack.stats.uncounted} the solutions were not counted" in stack.summary()
    assert rest.stats.uncounted == 0 and "not counted" not in rest.summary()
    assert rest.stats.shared == rest.stats.steps
    assert f"in {rest.stats.steps} the impulses are one share of many" in rest.summary()


def test_two_contacts_are_counted_in_each_step_unless_one_motion_is_certain():
    """Problems that drift, and whose friction changes: the count is that of an enumeration of each of them."""
    tree, rng = new(Tree, n=2, r=4), np.random.default_rng(8)
    certain = several = 0
    for _ in range(40):
        begin, change = rng.normal(size=(2, 24)) * [[1.0], [0.2]]
        mu_0, mu_1 = rng.uniform(0.0, 2.5, (2, 2))
        problem, planar = problem_of(KINDS[:2], np.eye(4), np.zeros(4), mu_0, mu_0), new(Planar, n=2, d=1)
        planar.may_wait = 1
        for s in np.linspace(0.0, 1.0, 100):
            mu = mu_0 if s < 0.5 else (1 - s) * mu_0 + s * mu_1
            W, c = np.split(begin + s * change, [20])
            W = W.reshape(4, 5)
            problem.G[:], problem.c[:] = W @ W.T, c
            problem.offset[:] = problem.c
            problem.laws[:] = [law_row(Coulomb(m), 0.0, 0.0, "newton", {}) for m in mu]
            other = problem_of(KINDS[:2], problem.G, problem.c, mu, mu)
            expected, _ = enumerate_modes(other.address, tree.address)
            route, found, _, _ = solve_planar(problem.address, planar.address)
            assert found == expected and (route > Route.NO_SOLUTION) == (expected > 0)
            certain, several = certain + (route == Route.KEPT_MODES), several + (expected > 1)
            for k, candidate in enumerate(problem.candidate):
                names = {FREE: ns.ContactMode.OPEN, STICK: ns.ContactMode.STICK}
                problem.mode[k] = names.get(candidate, ns.ContactMode.SLIDE)
                problem.slip[k] = slip_of(candidate) if candidate >= SLIDE_PLUS else 0
    assert certain > 200 and several > 5  # each is met
