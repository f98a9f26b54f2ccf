"""A block on 3 to 9 feet that slides, rocks, is shaken or lands: every step beside an enumeration of its own.

Motions are told apart by what each closed foot does: part, stick, slide to one side or the other. A tree of these is
walked, in which a linear programme decides whether any impulses within the cones make the feet named so far do so.
"""

import numpy as np
import pytest
from scipy.optimize import linprog

import nonsmooth as ns
from benchmarks.contact_scenes import Block, block
from benchmarks.contacts import tilted
from nonsmooth.contact.planar.ladder import Route, solve_planar
from nonsmooth.contact.planar.problem import ACCEPTED_RESIDUAL
from nonsmooth.contact.planar.single import FREE, STICK, slip_of
from nonsmooth.integrators.moreau_jean import contact as moreau_jean_contact
from nonsmooth.jit import interpreted

pytestmark = pytest.mark.filterwarnings("ignore::nonsmooth.SimultaneousImpactWarning")  # of several feet

SCENES = {
    "sliding": (Block(), np.zeros(3), [0.3, 0.0, 0.0]),
    "shaken": (Block(v=0.5), np.zeros(3), np.zeros(3)),
    "rocking": (Block(), tilted(Block(), 0.0), np.zeros(3)),
    "landing": (Block(e=0.3), tilted(Block(), 0.03), [0.5, 0.0, 0.0]),
}
MU = Block().mu
MOVES = 1e-6  # of max |c|: least velocity of a foot that parts or slides; linear programmes are exact to 1e-9 or so
PART, HOLD, PLUS, MINUS = range(4)


def motions_of(G, c):
    """gamma = G P + c of every motion, with rows (N, F) of each foot; those that nearly stick are not told."""
    scale = np.abs(c).max()
    found = []

    def walk(names):
        gamma = motion(G, c / scale, names)
        if gamma is None:
            return
        if len(names) == len(c) // 2:
            found.append(scale * gamma)
            return
        for name in (PART, HOLD, PLUS, MINUS):
            walk((*names, name))

    walk(())
    return found


def motion(G, c, names):
    """gamma = G P + c of impulses with which the first feet do as their names say; None if there are none."""
    unit, A, a, C, e = np.eye(len(c)), [], [], [], []  # A P = a, C P <= e
    for k in range(len(c) // 2):
        N, F = 2 * k, 2 * k + 1
        C += [unit[F] - MU * unit[N], -unit[F] - MU * unit[N], -G[N]]
        e += [0.0, 0.0, c[N]]
        if k >= len(names):
            continue
        if names[k] == PART:
            A += [unit[N]]
            a += [0.0]
            C += [-G[N]]
            e += [c[N] - MOVES]
            continue
        A += [G[N]]
        a += [-c[N]]
        if names[k] == HOLD:
            A += [G[F]]
            a += [-c[F]]
        else:
            slip = 1.0 if names[k] == PLUS else -1.0
            A += [unit[F] + slip * MU * unit[N]]
            a += [0.0]
            C += [-slip * G[F]]
            e += [slip * c[F] - MOVES]
    bounds = [(0.0, None), (None, None)] * (len(c) // 2)
    answer = linprog(np.zeros(len(c)), C, e, A or None, a or None, bounds=bounds, method="highs")
    return G @ answer.x + c if answer.status == 0 else None


def problems_of_a_run(name, n, monkeypatch):
    """The run, and of each of its contact problems: G, c, P, the candidates, whether its solutions were counted, the
    route, and how many there are."""
    parameters, q0, u0 = SCENES[name]
    solve, problems = interpreted(solve_planar), []

    def noting(problem, planar):
        route, found, pivots, residual = solve(problem, planar)
        n, r = problem.n, problem.r
        arrays = (problem.G[:r, :r], problem.c[:r], problem.P[:r], problem.candidate[:n])
        problems.append((*map(np.copy, arrays), planar.is_counted == 1, route, found))
        return route, found, pivots, residual

    monkeypatch.setenv("NONSMOOTH_INTERPRET", "1")
    monkeypatch.setitem(interpreted(moreau_jean_contact.solve).__globals__, "solve_planar", noting)
    return ns.simulate(block(n, parameters), (0, 0.4), q0, u0, integrator=ns.MoreauJean(dt=4e-3)), problems


def assert_modes_are_true(gamma, P, candidate, scale):
    """What parts is open, what slides slides with the friction of its law, what sticks does not move, to ACCEPTED."""
    small = ACCEPTED_RESIDUAL * scale
    for k, mode in enumerate(candidate):
        gamma_N, gamma_F, P_N, P_F = *gamma[2 * k : 2 * k + 2], *P[2 * k : 2 * k + 2]
        assert P_N >= 0.0 and abs(P_F) <= MU * P_N * (1.0 + 1e-12)
        if mode == FREE:
            assert P_N == 0.0 and gamma_N > 0.0
            continue
        assert abs(gamma_N) <= small
        if mode == STICK:
            assert abs(gamma_F) <= small
        else:
            assert np.sign(gamma_F) == slip_of(mode) and P_F == pytest.approx(-slip_of(mode) * MU * P_N, rel=1e-12)


def is_told(gamma, scale):
    """Whether no velocity is so small that a linear programme cannot tell it from none."""
    return not ((np.abs(gamma) > 1e-12 * scale) & (np.abs(gamma) < 10.0 * MOVES * scale)).any()


FEET = [n if n in (3, 5, 8) else pytest.param(n, marks=pytest.mark.slow) for n in (3, 4, 5, 6, 7, 8, 9)]


@pytest.mark.upkeep
@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("n", FEET)
def test_steps_of_a_block_on_feet_are_motions_of_an_enumeration_of_its_own(name, n, monkeypatch):
    """Each set of modes once: the motion is one of those there are, and it is said whether it is the only one."""
    solution, problems = problems_of_a_run(name, n, monkeypatch)
    kept, checked = 0, set()
    for G, c, P, candidate, is_counted, route, found in problems:
        gamma, scale, modes = G @ P + c, np.abs(c).max(), (len(c), *candidate)
        assert_modes_are_true(gamma, P, candidate, scale)
        kept += route == Route.KEPT
        if modes in checked or not is_told(gamma, scale):
            continue
        checked.add(modes)
        motions = motions_of(G, c)
        assert any(np.abs(gamma - other).max() <= MOVES * scale for other in motions)
        if is_counted:
            assert (found > 1) == (len(motions) > 1)
    assert checked
    assert solution.stats.worst_residual <= ACCEPTED_RESIDUAL and solution.stats.ledger_error <= 1e-15
    assert solution.stats.energy_gains == 0
    if name in ("sliding", "rocking"):
        assert kept > 30 and (solution.mode[-1] == ns.ContactMode.STICK).all()
