"""Several contacts at rest whose forces are not unique: the paradox is reported, and the selection rule is followed.

Contact 0 at rest has G = ((2, 1), (1, 1)) and b = (1, 3) m/s^2. By hand:

    free      b_N = 1 >= 0
    stick     la = -G^-1 b = (2, -5), inside the cone for mu >= 5/2
    slide +   la_N = 1/(mu - 2), gamma_F' = 3 + (1 - mu) la_N >= 0 for mu >= 5/2; at mu = 5/2 it is the stick
    slide -   la_N = -1/(2 + mu) < 0: none

Contact 1 belongs to another body, which stands under its weight: one solution for itself.
"""

import itertools

import numpy as np
import pytest

import nonsmooth as ns
from benchmarks import stress_random
from benchmarks.core_scenes import row_of_blocks
from benchmarks.stress_scenes import Tower, tower
from nonsmooth.mechanics.laws import LAW_C, LAW_E_N
from nonsmooth.mechanics.system import NORMAL, TANGENT

STICK, OPEN = ns.ContactMode.STICK, ns.ContactMode.OPEN
G = 9.81
END = 0.5  # s


def bodies(mu):
    """q = (y, x) of one body, whose mass matrix is the inverse of G, and (z, w) of the other."""

    def mass(t, q, p, M):
        M[0, 0], M[0, 1], M[1, 0], M[1, 1] = 1.0, -1.0, -1.0, 2.0
        M[2, 2] = M[3, 3] = 1.0

    def force(t, q, u, p, h):  # M b
        h[0], h[1], h[2], h[3] = -2.0, 5.0, -9.81, 0.0

    def gap(t, q, p, g_N):
        g_N[0], g_N[1] = q[0], q[2]

    def normal(t, q, p, W_N):
        W_N[0, 0] = W_N[1, 2] = 1.0

    def tangent(t, q, p, W_F):
        W_F[0, 0, 1] = W_F[1, 0, 3] = 1.0

    return ns.System(
        n_q=4, mass=mass, force=force, gap=gap, normal=normal, tangent=tangent, contacts=[ns.Contact(mu=mu)] * 2
    )


def run(mu, selection="compliant-limit"):
    return ns.simulate(bodies(mu), (0, END), np.zeros(4), np.zeros(4), integrator=ns.EventDriven(), selection=selection)


@pytest.mark.parametrize("mu, number", [(2.5, 2), (3.0, 3)])
@pytest.mark.parametrize("selection", ["compliant-limit", "lift-off", "impact"])
def test_number_of_solutions_is_reported_with_what_was_taken(mu, number, selection):
    solution = run(mu, selection)
    assert [(event.t, event.contact) for event in solution.paradoxes] == [(0.0, 0)]  # contact 1 has one solution
    for event in solution.paradoxes:
        assert event.kind == ns.EventKind.INDETERMINATE and event.n_solutions == number
    assert solution.stats.indeterminate_steps == 1
    la = solution.la[0, 0]
    if selection == "lift-off":
        assert solution.mode[-1, 0] == OPEN and la == pytest.approx([0.0, 0.0], abs=0.0)
        assert solution.q[-1, :2] == pytest.approx([END**2 / 2, 3 * END**2 / 2], rel=1e-12)
    else:
        assert solution.mode[-1, 0] == STICK and la == pytest.approx([2.0, -5.0], rel=1e-12)
        assert np.abs(solution.q[:, :2]).max() == 0.0
    assert solution.mode[-1, 1] == STICK and solution.la[-1, 1] == pytest.approx([G, 0.0], rel=1e-12)


def test_a_narrower_cone_leaves_one_solution_and_no_paradox():
    solution = run(2.4)
    assert solution.paradoxes == [] and solution.mode[-1, 0] == OPEN
    assert solution.q[-1, :2] == pytest.approx([END**2 / 2, 3 * END**2 / 2], rel=1e-12)


def test_more_contacts_than_are_tried_are_refused_with_their_number_and_a_cure():
    """Ten masses upon each other: 4^10 modes are more than 400000."""
    masses = tower(10, Tower())
    with pytest.raises(ns.StepFailure, match=r"10 contacts touch at once.*400000.*Adaptive or MoreauJean") as failure:
        ns.simulate(masses, (0, 1), np.zeros(20), np.zeros(20), integrator=ns.EventDriven())
    assert "smaller dt" not in str(failure.value)
    solution = ns.simulate(masses, (0, 1), np.zeros(20), np.zeros(20), integrator=ns.MoreauJean(dt=1e-2))
    assert solution.success and np.abs(solution.q).max() == 0.0


def test_any_number_of_contacts_that_share_nothing_is_decided():
    """Sixteen masses side by side, pushed one after the other harder: mass i stops after v_i/(mu g)."""
    masses, u = row_of_blocks(16, k=0.0), np.zeros(32)
    u[::2] = np.linspace(0.1, 1.6, 16)
    solution = ns.simulate(masses, (0, 1), np.zeros(32), u, integrator=ns.EventDriven())
    assert solution.q[-1, ::2] == pytest.approx(u[::2] ** 2 / (2 * 0.3 * G), rel=1e-11)
    assert [(e.contact, e.mode_after) for e in solution.events] == [(i, STICK) for i in range(16)]
    assert [e.t for e in solution.events] == pytest.approx(u[::2] / (0.3 * G), rel=1e-11)


def velocities_after_impact(M, W, mu, e, u):
    """Every u+ after an impact of contacts that touch, W (c, 2, n) their rows: each is open, sticks or slides."""
    n, c, found = len(u), len(mu), []
    bounce = e * np.maximum(0.0, -W[:, 0] @ u)
    for modes in itertools.product((None, 0, 1, -1), repeat=c):  # open, the signs of slip
        A, b = np.zeros((n + 2 * c, n + 2 * c)), np.zeros(n + 2 * c)
        A[:n, :n], b[:n] = M, M @ u
        for i, (slip, N, F) in enumerate(zip(modes, range(n, n + 2 * c, 2), range(n + 1, n + 2 * c, 2), strict=True)):
            A[:n, N], A[:n, F] = -W[i, 0], -W[i, 1]
            if slip is None:
                A[N, N] = 1.0
            else:
                A[N, :n], b[N] = W[i, 0], bounce[i]
            if slip == 0:
                A[F, :n] = W[i, 1]
            else:
                A[F, F], A[F, N] = 1.0, (slip or 0) * mu[i]
        if np.linalg.matrix_rank(A) < len(A):  # four velocities of three coordinates: all can be zero by no impulse
            continue
        x = np.linalg.solve(A, b)
        u_1, (P_N, P_F), (gamma_N, gamma_F) = x[:n], x[n:].reshape(c, 2).T, (W @ x[:n]).T
        is_open = np.array([slip is None for slip in modes])
        slack = np.where(
            is_open, gamma_N - bounce, np.minimum(P_N, [gamma_F[i] * (slip or 0) for i, slip in enumerate(modes)])
        )
        sticks = np.array([slip == 0 for slip in modes])
        slack = np.where(sticks, np.minimum(P_N, mu * P_N - np.abs(P_F)), slack)
        if slack.min() > -1e-9 and all(np.abs(u_1 - other).max() > 1e-7 for other in found):
            found.append(u_1)
    return found


@pytest.mark.filterwarnings("ignore::nonsmooth.FrictionGainWarning")  # which one of the solutions has
@pytest.mark.filterwarnings("ignore::nonsmooth.SimultaneousImpactWarning")  # what is asked holds for it too
@pytest.mark.parametrize(
    "integrator", [ns.EventDriven(1e-10), ns.Adaptive(1e-7, 1e-9)], ids=lambda one: type(one).__name__
)
def test_an_impact_with_several_solutions_is_reported_with_their_number(integrator):
    """Contact 0 strikes while contact 2 slides: what was taken is one of those that an enumeration finds."""
    s = stress_random.sample(809)
    run = ns.simulate(s.system, (0, 0.06), s.q0, s.u0, integrator=integrator, selection=s.selection)
    (struck,) = [event for event in run.events if event.kind == ns.EventKind.IMPACT and event.contact == 0]
    noted = [event for event in run.paradoxes if event.t == struck.t]
    rows, n = [0, 2], 3
    ends = [
        ns.simulate(s.system, (0, struck.t + late), s.q0, s.u0, integrator=integrator, selection=s.selection).u[-1, :n]
        for late in (-1e-7, 1e-7)
    ]
    N, F = (s.system.evaluate(which, 0.0, s.q0, s.u0) for which in (NORMAL, TANGENT))
    W, laws = np.stack([N[rows], F[rows, 0]], axis=1)[:, :, :n], s.system.laws[rows]
    solutions = velocities_after_impact(s.M[:n, :n], W, laws[:, LAW_C], laws[:, LAW_E_N], ends[0])
    assert len(solutions) > 1 and sorted(event.contact for event in noted) == rows
    assert {event.n_solutions for event in noted} == {len(solutions)}
    assert min(np.abs(ends[1] - u).max() for u in solutions) < 1e-5  # 1e-7 s of acceleration
