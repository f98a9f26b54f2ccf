"""Contacts that do not couple are decided apart: every integrator and ``classify`` treat each as if it were alone.

The pairs: Painlevé's rods side by side, of which one is inconsistent; a rod and a ball; two feet of one body that
decouple by symmetry; two sliders on one cart, which friction couples but no normal force does.
"""

import itertools
import math

import numpy as np
import pytest

import nonsmooth as ns
from models import BouncingBall, PainleveRod

ROD = PainleveRod(mu=2.0)
INCONSISTENT = ROD.state(th=math.pi / 3, thdot=0.0, slip=-1.0)  # p < 0, b < 0
INDETERMINATE = ROD.state(th=math.pi / 3, thdot=6.0, slip=-1.0)  # p < 0 < b
REGULAR = ROD.state(th=1.5, thdot=0.0, slip=-1.0)
END = 0.15  # s


def rods(n):
    """n slender rods of 1 kg and 1 m (PainleveRod with mu = 2), each with its end on the floor."""

    def mass(t, q, p, M):
        for r in range(q.shape[0] // 3):
            M[3 * r, 3 * r] = M[3 * r + 1, 3 * r + 1] = 1.0
            M[3 * r + 2, 3 * r + 2] = 1.0 / 12.0

    def force(t, q, u, p, h):
        for r in range(q.shape[0] // 3):
            h[3 * r + 1] = -9.81

    def gap(t, q, p, g_N):
        for r in range(g_N.shape[0]):
            g_N[r] = q[3 * r + 1] - 0.5 * math.sin(q[3 * r + 2])

    def normal(t, q, p, W_N):
        for r in range(W_N.shape[0]):
            W_N[r, 3 * r + 1] = 1.0
            W_N[r, 3 * r + 2] = -0.5 * math.cos(q[3 * r + 2])

    def tangent(t, q, p, W_F):
        for r in range(W_F.shape[0]):
            W_F[r, 0, 3 * r] = 1.0
            W_F[r, 0, 3 * r + 2] = 0.5 * math.sin(q[3 * r + 2])

    return ns.System(n_q=3 * n, mass=mass, force=force, gap=gap, normal=normal, tangent=tangent,
                     contacts=[ns.Contact(mu=2.0)] * n)  # fmt: skip


def side_by_side(*states):
    return tuple(np.concatenate(parts) for parts in zip(*states, strict=True))


@pytest.fixture(scope="module")
def of_rods():
    """The systems of two and of three rods, compiled once."""
    return {n: rods(n) for n in (2, 3)}


INTEGRATORS = [
    (ns.EventDriven(), 1e-9), ("auto", 1e-9), (ns.Adaptive(), 2e-8), (ns.MoreauJean(1e-4), 1e-12),
]  # fmt: skip


@pytest.mark.parametrize("selection", ["compliant-limit", "lift-off", "impact"])
@pytest.mark.parametrize("integrator, tolerance", INTEGRATORS)
def test_rods_that_share_nothing_move_as_each_does_alone(of_rods, integrator, tolerance, selection):
    """Two and three rods in every combination of paradoxes; the tolerance of the steps, which they share; none where
    the steps are the same."""
    alone = {}
    for name, state in (("none", INCONSISTENT), ("several", INDETERMINATE), ("one", REGULAR)):
        alone[name] = state, ns.simulate(ROD, (0, END), *state, integrator=integrator, selection=selection).q[-1]
    for names in [*itertools.product(alone, repeat=2), ("none", "several", "one"), ("several", "none", "none")]:
        state = side_by_side(*(alone[name][0] for name in names))
        sol = ns.simulate(of_rods[len(names)], (0, END), *state, integrator=integrator, selection=selection)
        expected = np.concatenate([alone[name][1] for name in names])
        assert np.abs(sol.q[-1] - expected).max() < tolerance, names


def test_only_the_rod_without_forces_is_struck(of_rods):
    """Rod 1 lifts off as it does alone, or goes into its own impact where the rule asks for one."""
    start = side_by_side(INCONSISTENT, INDETERMINATE)
    for selection, struck in (("compliant-limit", False), ("lift-off", False), ("impact", True)):
        sol = ns.simulate(of_rods[2], (0, END), *start, integrator=ns.EventDriven(), selection=selection)
        first, second = (event for event in sol.paradoxes if event.t == 0.0)
        assert first.kind == ns.EventKind.INCONSISTENT and first.contact == 0 and first.P_N > 0.3
        assert second.kind == ns.EventKind.INDETERMINATE and second.n_solutions == 2
        assert second.alternatives == ("free", "slide -") and (second.P_N > 0.3) == struck


def test_an_entry_into_the_region_of_several_solutions_is_noted_once_beside_other_events(of_rods):
    """A rod that slides in that region goes on sliding while the other one is struck, stops and slides again."""
    slides = ROD.state(th=1.25, thdot=4.0, slip=-1.0)
    alone = ns.simulate(ROD, (0, END), *slides, integrator=ns.EventDriven())
    for other in (INCONSISTENT, REGULAR):
        both = ns.simulate(of_rods[2], (0, END), *side_by_side(slides, other), integrator=ns.EventDriven())
        mine = [(e.kind, e.n_solutions) for e in both.paradoxes if e.contact == 0]
        assert mine == [(e.kind, e.n_solutions) for e in alone.paradoxes]
        assert np.abs(both.q[-1, :3] - alone.q[-1]).max() < 1e-9


def test_a_solution_of_all_rods_is_one_of_each(of_rods):
    """Products of the sets {free, slide -} of each; none where one of the rods has none."""
    several = side_by_side(INDETERMINATE, INDETERMINATE, REGULAR)
    c = ns.classify(of_rods[3], 0.0, *several)
    one = ns.classify(ROD, 0.0, *INDETERMINATE)
    assert c.kind == ns.ParadoxKind.INDETERMINATE and c.n_solutions == 4 and c.is_complete
    assert [(i.contacts, i.n_solutions) for i in c.islands] == [((0,), 2), ((1,), 2), ((2,), 1)]
    sets = {s.modes[:2] for s in c.solutions}
    assert sets == set(itertools.product([s.modes[0] for s in one.solutions], repeat=2)) and len(c.solutions) == 4
    for s in c.solutions:
        for r in range(2):
            (alike,) = [o for o in one.solutions if o.modes[0] == s.modes[r]]
            assert s.la_N[r] == pytest.approx(alike.la_N[0], rel=1e-11)  # W' u by differences, the model's own
            assert s.du[3 * r : 3 * r + 3] == pytest.approx(alike.du, rel=1e-11)
    none = ns.classify(of_rods[2], 0.0, *side_by_side(INCONSISTENT, INDETERMINATE))
    assert none.kind == ns.ParadoxKind.INCONSISTENT and none.solutions == () and none.is_complete
    assert [(i.kind.name, i.n_solutions) for i in none.islands] == [("INCONSISTENT", 0), ("INDETERMINATE", 2)]
    for impact in none.impacts:  # of one rod each, the other one keeps its velocity
        (struck,) = np.flatnonzero(impact.P_N)
        assert impact.gamma_F[1 - struck] == none.gamma_F[1 - struck] and impact.gamma_N[1 - struck] == 0.0
    assert "contact 0, decided apart: INCONSISTENT" in str(none)
    assert none.to_dict()["islands"][1]["n_solutions"] == 2


def test_solutions_of_a_hundred_rods_are_counted_without_listing_them():
    """2^100 sets of forces; with one inconsistent rod among them there is none."""
    row = rods(100)
    c = ns.classify(row, 0.0, *side_by_side(*[INDETERMINATE] * 100))
    assert c.n_solutions == 2**100 and len(c.solutions) == 256 and not c.is_complete
    c = ns.classify(row, 0.0, *side_by_side(*[INDETERMINATE] * 99, INCONSISTENT))
    assert c.n_solutions == 0 and c.is_complete and c.kind == ns.ParadoxKind.INCONSISTENT


def rod_and_ball():
    """Coordinates of the rod, then the height of a ball of 1 kg with e = 0.8."""

    def mass(t, q, p, M):
        M[0, 0] = M[1, 1] = M[3, 3] = 1.0
        M[2, 2] = 1.0 / 12.0

    def force(t, q, u, p, h):
        h[1] = h[3] = -9.81

    def gap(t, q, p, g_N):
        g_N[0] = q[1] - 0.5 * math.sin(q[2])
        g_N[1] = q[3]

    def normal(t, q, p, W_N):
        W_N[0, 1] = 1.0
        W_N[0, 2] = -0.5 * math.cos(q[2])
        W_N[1, 3] = 1.0

    def tangent(t, q, p, W_F):
        W_F[0, 0, 0] = 1.0
        W_F[0, 0, 2] = 0.5 * math.sin(q[2])

    return ns.System(n_q=4, mass=mass, force=force, gap=gap, normal=normal, tangent=tangent,
                     contacts=[ns.Contact(mu=2.0), ns.Contact(e_N=0.8)])  # fmt: skip


@pytest.mark.parametrize("state", [INCONSISTENT, INDETERMINATE])
def test_a_bouncing_ball_leaves_a_rod_in_peace(state):
    """Each landing of the ball decides on the ball alone, and the rod's paradox does not strike a ball at rest."""
    system, ball = rod_and_ball(), BouncingBall(e=0.8)
    rod = ns.simulate(ROD, (0, 0.5), *state, integrator=ns.EventDriven())
    for height, velocity in ((0.0, 0.0), (0.01, 0.0), (0.0, 0.5)):
        x = ball.state(height=height, velocity=velocity)
        both = ns.simulate(system, (0, 0.5), *side_by_side(state, x), integrator=ns.EventDriven())
        single = ns.simulate(ball, (0, 0.5), *x, integrator=ns.EventDriven())
        assert np.abs(both.q[-1, :3] - rod.q[-1]).max() < 1e-9
        assert abs(both.q[-1, 3] - single.q[-1, 0]) < 1e-9
        assert sum(e.contact == 1 for e in both.events) == len(single.events)


def feet_of_a_dumbbell(height):
    """Two masses m = 1/2 at +-a of a massless bar, q = (x, y, th): 1/m - a^2/I = 0, the feet do not feel each other.

    The contacts lie ``height`` below the bar; h > 0 couples them by friction.
    """

    def mass(t, q, p, M):
        M[0, 0] = M[1, 1] = 1.0
        M[2, 2] = 0.09

    def force(t, q, u, p, h):
        h[1] = -9.81

    def gap(t, q, p, g_N):
        g_N[0], g_N[1] = q[1] - 0.3 * q[2], q[1] + 0.3 * q[2]

    def normal(t, q, p, W_N):
        W_N[0, 1] = W_N[1, 1] = 1.0
        W_N[0, 2], W_N[1, 2] = -0.3, 0.3

    def tangent(t, q, p, W_F):
        W_F[0, 0, 0] = W_F[1, 0, 0] = 1.0
        W_F[0, 0, 2] = W_F[1, 0, 2] = height

    return ns.System(n_q=3, mass=mass, force=force, gap=gap, normal=normal, tangent=tangent,
                     contacts=[ns.Contact(mu=0.2)] * 2)  # fmt: skip


def test_feet_that_decouple_by_symmetry_are_apart_while_they_slide():
    c = ns.classify(feet_of_a_dumbbell(0.0), 0.0, np.zeros(3), [1.0, 0.0, 0.0])
    assert [i.contacts for i in c.islands] == [(0,), (1,)] and c.kind == ns.ParadoxKind.REGULAR
    assert c.solutions[0].la_N == pytest.approx([4.905, 4.905], rel=1e-13)
    at_rest = ns.classify(feet_of_a_dumbbell(0.0), 0.0, np.zeros(3), np.zeros(3))
    assert [i.contacts for i in at_rest.islands] == [(0, 1)]  # friction holds both
    coupled = ns.classify(feet_of_a_dumbbell(0.1), 0.0, np.zeros(3), [1.0, 0.0, 0.0])
    assert [i.contacts for i in coupled.islands] == [(0, 1)]


def test_a_foot_that_lands_does_not_strike_the_other_foot_of_a_dumbbell():
    """The centre of percussion: foot 0 rests, foot 1 lands with 1 m/s, and foot 0 feels nothing of it."""
    q, u = [0.0, 0.0, 0.0], [0.0, -0.5, -1.0 / 0.6]
    sol = ns.simulate(feet_of_a_dumbbell(0.0), (0, 0.1), q, u, integrator=ns.EventDriven())
    assert [(e.contact, e.kind) for e in sol.events if e.kind == ns.EventKind.IMPACT] == [(1, ns.EventKind.IMPACT)]
    assert sol.P_N[1] == pytest.approx([0.0, 0.5], abs=1e-15) and np.abs(sol.u[-1]).max() == 0.0


def sliders_on_a_cart():
    """q = (X, y_1, th_1, y_2): a cart carries a rod and a block, each free to rise; both slide on the floor.

    The rod's normal force turns it, so that friction presses it into the floor; the block has G_NF = 0. Friction of
    either acts on the cart, so on both velocities of sliding, but not on the other's normal velocity.
    """

    def mass(t, q, p, M):
        M[0, 0], M[1, 1], M[2, 2], M[3, 3] = 3.0, 1.0, 1.0 / 12.0, 1.0

    def force(t, q, u, p, h):
        h[1] = h[3] = -9.81

    def gap(t, q, p, g_N):
        g_N[0] = q[1] - 0.5 * math.sin(q[2])
        g_N[1] = q[3]

    def normal(t, q, p, W_N):
        W_N[0, 1] = 1.0
        W_N[0, 2] = -0.5 * math.cos(q[2])
        W_N[1, 3] = 1.0

    def tangent(t, q, p, W_F):
        W_F[0, 0, 0] = W_F[1, 0, 0] = 1.0
        W_F[0, 0, 2] = 0.5 * math.sin(q[2])

    return ns.System(n_q=4, mass=mass, force=force, gap=gap, normal=normal, tangent=tangent,
                     contacts=[ns.Contact(mu=2.0), ns.Contact(mu=0.5)])  # fmt: skip


def test_friction_alone_does_not_hand_an_impact_on():
    """The rod is inconsistent and stops; the block slides on with another velocity, and its normal impulse is zero."""
    th = math.pi / 3
    q, u = np.array([0.0, 0.5 * math.sin(th), th, 0.0]), np.array([-1.0, 0.0, 0.0, 0.0])
    c = ns.classify(sliders_on_a_cart(), 0.0, q, u)
    assert [(i.contacts, i.kind.name) for i in c.islands] == [((0,), "INCONSISTENT"), ((1,), "REGULAR")]
    W = np.array([[0, 1, -0.5 * math.cos(th), 0], [1, 0, 0.5 * math.sin(th), 0]])  # the rod's rows
    X = W @ np.diag([1 / 3, 1.0, 12.0, 1.0])
    P = np.linalg.solve(X @ W.T, -W @ u)  # the impulse that stops its end
    sol = ns.simulate(sliders_on_a_cart(), (0, 0.05), q, u, integrator=ns.EventDriven())
    assert [(e.contact, e.kind.name) for e in sol.events if e.t == 0.0 and e.P_N] == [(0, "INCONSISTENT")]
    assert sol.P_N[1] == pytest.approx([P[0], 0.0], rel=1e-12, abs=1e-15)
    assert sol.u[1] == pytest.approx(u + X.T @ P, rel=1e-12, abs=1e-13)
    assert sol.mode[2, 1] == ns.ContactMode.SLIDE


def chain(link):
    """Two blocks on a floor held together by a link of a given mass in two bilateral joints, all along y."""

    def mass(t, q, p, M):
        M[0, 0] = M[2, 2] = 1.0
        M[1, 1] = link

    def force(t, q, u, p, h):
        h[0] = h[2] = -9.81
        h[1] = -9.81 * link

    def gap(t, q, p, g_N):
        g_N[0], g_N[1], g_N[2], g_N[3] = q[0], q[2], q[0] - q[1], q[1] - q[2]

    def normal(t, q, p, W_N):
        W_N[0, 0] = W_N[1, 2] = W_N[2, 0] = W_N[3, 1] = 1.0
        W_N[2, 1] = W_N[3, 2] = -1.0

    contacts = [ns.Contact(e_N=0.5), ns.Contact(e_N=0.5), ns.Contact(bilateral=True), ns.Contact(bilateral=True)]
    return ns.System(n_q=3, mass=mass, force=force, gap=gap, normal=normal, contacts=contacts)


@pytest.mark.filterwarnings("ignore::nonsmooth.SimultaneousImpactWarning")  # what is asked holds for it too
@pytest.mark.parametrize("link", [1.0, 1e-6, 1e-12])
def test_a_light_chain_still_hands_an_impact_on(link):
    """Both blocks touch with 1 m/s and rebound with e = 1/2 as one body of 2 m, whatever the link weighs."""
    sol = ns.simulate(chain(link), (0, 0.05), np.zeros(3), -np.ones(3), integrator=ns.EventDriven(1e-6, 1e-8))
    assert sol.u[1] == pytest.approx(np.full(3, 0.5), rel=1e-6)
    c = ns.classify(chain(link), 0.0, np.zeros(3), np.zeros(3))
    assert len(c.islands) == 1
