"""Where events are too dense to be followed: a stretch of time stepping, or an error that names the cure.

An elastic ball of 1 kg between the floor and a piston of 1e6 kg that falls on it with 1 m/s. The speed of the ball
times the gap is nearly constant, 0.5 m^2/s, until the ball has the energy of the piston: 1000 m/s in a gap of 0.5 mm, a
million bounces a second. Then the piston is thrown back. Energy and momentum are kept throughout.
"""

import math
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns
from benchmarks.stress_scenes import Tower, tower
from models import BouncingBall
from nonsmooth.runs import hand_over
from nonsmooth.runs import run as runs
from nonsmooth.runs.hand_over import MANY_EVENTS, are_dense

STEPPED = ns.EventDriven(hand_over=ns.MoreauJean(dt=1e-3))
ADAPTED = ns.EventDriven(hand_over=ns.Adaptive(1e-6, 1e-8))
BOTH = pytest.mark.parametrize("integrator", [STEPPED, ADAPTED], ids=["MoreauJean", "Adaptive"])


class Piston(NamedTuple):
    m: float = 1.0  # kg
    M: float = 1e6  # kg


PISTON = Piston()


def mass(t, q, p, M):
    M[0, 0] = p.m
    M[1, 1] = p.M


def no_force(t, q, u, p, h):
    h[0] = 0.0


def gaps(t, q, p, g_N):
    g_N[0] = q[0]
    g_N[1] = q[1] - q[0]


def normals(t, q, p, W_N):
    W_N[0, 0] = 1.0
    W_N[1, 0] = -1.0
    W_N[1, 1] = 1.0


def squeezed(integrator=STEPPED, t_end=2.0, **options):
    ball = ns.System(n_q=2, mass=mass, force=no_force, gap=gaps, normal=normals,
                     contacts=[ns.Contact(e_N=1.0)] * 2, parameters=PISTON)  # fmt: skip
    return ns.simulate(ball, (0, t_end), [0.5, 1.0], [1.0, -1.0], integrator=integrator, **options)


def momentum_error(sol):
    """Of the momentum against the impulses of the floor, in that of the piston."""
    momentum = PISTON.m * sol.u[:, 0] + PISTON.M * sol.u[:, 1]
    return np.abs(momentum - momentum[0] - np.cumsum(sol.P_N[:, 0])).max() / PISTON.M


def test_piston_is_thrown_back_by_the_ball():
    """Bounce by bounce, 3139 of them; and with steps of 1 ms where 1000 bounces fall into one. There the ball has
    passed its fastest stretch, and the piston lacks what the ball keeps of its energy: v^2/(2 M V) of its speed."""
    alone, sol = squeezed(ns.EventDriven()), squeezed()
    for run in (alone, sol):
        energy = 0.5 * (PISTON.m * run.u[:, 0] ** 2 + PISTON.M * run.u[:, 1] ** 2)
        assert np.ptp(energy) < 1e-9 * energy[0] and momentum_error(run) < 1e-13
        assert run.success and 0.0 <= run.q[-1, 0] <= run.q[-1, 1]
    assert abs(alone.u[-1, 1] - 1.0) < 1e-6 and abs(sol.u[-1, 1] - 1.0) < 1e-3
    assert sol.stats.steps < 0.6 * alone.stats.steps
    before = sol.t < 0.9  # bounces are followed one by one while they are few
    assert (sol.q[before] == alone.q[: before.sum()]).all() and sol.g_N[before].min() > -1e-12


def test_adaptive_stretches_keep_the_tolerance():
    """The piston comes back as it does bounce by bounce, with as many events, each with its impulse."""
    alone, sol = squeezed(ns.EventDriven()), squeezed(ADAPTED)
    assert sol.success and sol.stats.lcp_solved > 0 == alone.stats.lcp_solved  # plain steps decide in the stretches
    assert np.abs(sol.u[-1] - alone.u[-1]).max() < 1e-5 and momentum_error(sol) < 1e-13
    assert len(sol.events) == len(alone.events) and sol.g_N.min() > -1e-10
    assert sum(event.P_N for event in sol.events) == pytest.approx(sum(event.P_N for event in alone.events), rel=1e-6)
    plan = np.abs(np.sort([event.t for event in sol.events]) - np.sort([event.t for event in alone.events]))
    assert plan.max() < 1e-6


def test_budget_ends_a_run_within_an_adaptive_stretch():
    with pytest.raises(ns.BudgetSpent, match="max_steps = 5000") as failure:
        squeezed(ADAPTED, max_steps=5000)
    assert failure.value.solution.stats.steps == 5000 and 0.9 < failure.value.t < 1.1


@BOTH
def test_run_does_not_depend_on_when_the_clock_is_looked_at(monkeypatch, integrator):
    sol = squeezed(integrator)
    monkeypatch.setattr(runs, "LOOK_EVERY", 1e-9)
    slow = squeezed(integrator, events=[lambda t, q, u: 1.0])
    assert (sol.t == slow.t).all() and (sol.q == slow.q).all()


@BOTH
def test_motion_and_records_are_whole_through_the_stretches(integrator):
    sol = squeezed(integrator)
    motion = sol.motion
    assert np.abs(motion.t[1:] - motion.t[:-1] - motion.h[:-1]).max() < 1e-12
    assert np.abs(sol(motion.t[1:], "left").q - sol(motion.t[1:]).q).max() < 1e-9
    t = np.linspace(0.0, 2.0, 41)
    asked = squeezed(integrator, t_eval=t)
    assert asked.success and (asked.t == t).all() and momentum_error(asked) < 1e-9
    assert squeezed(integrator, every=100).success


@BOTH
def test_events_of_the_user_are_found_within_the_stretches(integrator):
    def late(t, q, u):
        return t - 1.02

    late.terminal = True
    sol = squeezed(integrator, events=[late])
    assert sol.status == ns.Status.EVENT_REACHED and abs(sol.t[-1] - 1.02) < 1e-12
    assert (np.diff(sol.event_rows[:, 0]) >= 0).all() and sol.event_rows[-1, 0] <= 1.02
    assert momentum_error(sol) < 1e-13


def test_without_time_stepping_a_budget_ends_the_run():
    with pytest.raises(ns.BudgetSpent) as failure:
        squeezed(ns.EventDriven(), max_steps=2000)
    assert failure.value.t < 1.0 and failure.value.solution.stats.steps == 2000


@BOTH
def test_plain_accumulation_is_not_handed_over(integrator):
    ball = BouncingBall(e=0.9)
    handed = ns.simulate(ball, (0, 10), *ball.state(height=1.0), integrator=integrator)
    plain = ns.simulate(ball, (0, 10), *ball.state(height=1.0), integrator=ns.EventDriven())
    assert (handed.t == plain.t).all() and (handed.q == plain.q).all()


def test_many_events_of_one_contact_are_left_to_its_accumulation():
    rows = np.zeros((MANY_EVENTS, 13))
    rows[:, 0] = np.linspace(0.0, 1e-6, MANY_EVENTS)
    assert not are_dense(rows, 1e-3)
    rows[0, 2] = 1.0
    assert are_dense(rows, 1e-3) and not are_dense(rows, 1e-7) and not are_dense(rows[1:], 1e-3)


def pushed_tower():
    """Ten masses upon each other, the upper one pushed: ten frictional contacts decided at once, and q0, u0."""
    u0 = np.zeros(20)
    u0[18] = 1.0
    return tower(10, Tower()), (np.zeros(20), u0)


def test_more_contacts_than_can_be_enumerated_end_with_the_cure_or_are_stepped():
    masses, start = pushed_tower()
    with pytest.raises(ns.StepFailure, match=r"contacts touch at once.*hand_over=Adaptive") as failure:
        ns.simulate(masses, (0, 0.2), *start, integrator=ns.EventDriven(1e-6, 1e-8))
    assert failure.value.t == 0.0 and failure.value.u[18] == 1.0
    stepped = ns.simulate(masses, (0, 0.05), *start, integrator=ns.EventDriven(1e-6, 1e-8, ns.MoreauJean(dt=1e-3)))
    plain = ns.simulate(masses, (0, 0.05), *start, integrator=ns.MoreauJean(dt=1e-3))
    assert np.abs(stepped.q[-1] - plain.q[-1]).max() < 1e-12 and stepped.stats.steps == plain.stats.steps


@BOTH
def test_a_stretch_that_does_not_help_is_followed_by_one_twice_as_long(integrator):
    """Two hundred stretches would be the span; 50 units, 100, 200, ... 3200 and as many again are some ten."""
    masses, start = pushed_tower()
    stepper = ns.MoreauJean(dt=1e-4) if isinstance(integrator.hand_over, ns.MoreauJean) else ns.Adaptive(1e-4, 1e-6)
    sol = ns.simulate(masses, (0, 1), *start, integrator=ns.EventDriven(1e-6, 1e-8, stepper), t_eval=[0.5, 1.0])
    assert int(sol.about["handed over"].split()[0]) <= 11 and "of 1 s in all" in sol.about["handed over"]
    assert f"to {type(stepper).__name__}" in sol.summary().splitlines()[1]
    mu, g = masses.parameters.mu, masses.parameters.g
    assert sol.q[-1, 18] == pytest.approx(1 / (2 * mu * g), rel=1e-3)  # the upper mass alone, v^2/(2 mu g)


def test_a_last_stretch_that_is_given_up_early_is_not_the_end(monkeypatch):
    """The span ends where the bounces are densest; of the stretch that would reach the end two steps are taken."""
    monkeypatch.setattr(hand_over, "MOST_STEPS", 2)
    sol = squeezed(ADAPTED, t_end=1.0)
    assert sol.success and sol.t[-1] == 1.0 and momentum_error(sol) < 1e-13


@pytest.mark.parametrize("stepper", [1e-3, ns.EventDriven(), ns.MoreauJean(1e-3, 1.0, compliance=ns.Compliance(1e5))])
def test_what_cannot_take_over_is_refused(stepper):
    with pytest.raises(ns.InvalidInput, match="hand_over must be an Adaptive"):
        ns.EventDriven(hand_over=stepper)


# stiff models


@pytest.mark.parametrize("c, most", [(1e6, 120), (2e4, 120), (1e3, 300)])
def test_stiff_spring_does_not_stall_the_run(c, most):
    """k = 1e8 N/m between two unit masses on a soft spring, with the dampings 50, 1 and 0.05 of the critical one.

    An explicit method of order 5 needs steps of 3/omega = 2e-4 s, or m/c 3 = 1e-6 s: 2e4 to 5e6 of them. The masses
    move as one of 2 kg: x'' = -2 x, cos(sqrt(2) t), to f/k = 2e-8 m.
    """

    def force(t, q, u, p, h):
        pull = p.k * (q[1] - q[0]) + p.c * (u[1] - u[0])
        h[0] = pull - 4.0 * q[0]
        h[1] = -pull

    class Spring(NamedTuple):
        k: float = 1e8
        c: float = 1e6

    pair = ns.System(n_q=2, mass=pair_mass, force=force, parameters=Spring(c=c))
    sol = ns.simulate(pair, (0, 5), [1.0, 1.0], [0.0, 0.0], integrator=ns.EventDriven(1e-6, 1e-8))
    assert sol.success and sol.stats.steps < most
    assert np.abs(sol.q - np.cos(math.sqrt(2) * sol.t)[:, None]).max() < 1e-6


def pair_mass(t, q, p, M):
    M[0, 0] = M[1, 1] = 1.0
