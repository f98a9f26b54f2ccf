"""Adaptive Moreau–Jean: closed forms, order of the rows, several contacts, what ends a run, input."""

import math
import subprocess
import sys
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns
from models import (
    BeadChain,
    BilateralRod,
    BouncingBall,
    InclinedBlock,
    PainleveRod,
    RockingBlock,
    SlidingBlock,
    SpragSlip,
    Woodpecker,
)
from nonsmooth.errors import InvalidInput, Status
from nonsmooth.integrators.adaptive.state import N_ROWS, extrapolation_weights
from nonsmooth.runs import workspace
from tests.systems import ball


def run(model, t_end, state, rtol, **options):
    return ns.simulate(model, (0.0, t_end), *state, integrator=ns.Adaptive(rtol, 1e-2 * rtol), **options)


def test_ball_bounces_to_rest_at_the_accumulation_of_its_impacts():
    """The height against the parabolas of the closed form, a bounce of tol dropped; at rest exactly after t_inf."""
    for e, t_end in ((0.5, 2.0), (0.8, 4.5)):
        ball = BouncingBall(e=e)
        t = np.linspace(0.0, t_end, 301)
        for rtol in (1e-5, 1e-7, 1e-9):
            sol = run(ball, t_end, ball.state(height=1.0), rtol, t_eval=t)
            assert np.abs(sol.q[:, 0] - [ball.height(moment) for moment in t]).max() < 5 * rtol
            assert sol.q[-1, 0] == 0.0 and sol.u[-1, 0] == 0.0


def test_block_stops_where_its_kinetic_energy_is_spent_and_stays():
    block = SlidingBlock()
    sol = run(block, 1.0, block.state(), 1e-9)
    assert sol.q[-1, 0] == pytest.approx(block.stop_distance(), abs=1e-9 * (1 + block.stop_distance()))
    at_rest = sol(np.linspace(block.stop_time() + 1e-6, 1.0, 50)).q[:, 0]
    assert (at_rest == at_rest[0]).all()


def test_block_that_sticks_on_an_incline_does_not_creep():
    block = InclinedBlock()
    q0, u0 = block.state(slip=0.0)
    sol = run(block, 100.0, (q0, u0), 1e-6)
    assert block.sticks and (sol.q == q0).all() and (sol.u == 0.0).all()


def test_weights_are_exact_for_the_powers_that_they_remove():
    """Of T + c/m^2 + ... + c/m^K the rows 1..K give T; powers above K are left."""
    weights = extrapolation_weights()
    for last in range(N_ROWS):
        m = np.arange(1.0, last + 2.0)
        assert weights[0, last, : last + 1].sum() == pytest.approx(1.0, abs=1e-12)
        for power in range(2, last + 2):
            assert abs(weights[0, last, : last + 1] @ m**-power) < 1e-12
        assert abs(weights[0, last, : last + 1] @ m ** -(last + 2.0)) > 1e-12


class Driven(NamedTuple):
    k: float = 40.0  # stiffness [N/m]


def oscillator(damped):
    """q'' = -k sin q - q'/2 + cos 3t, no contact."""

    def mass(t, q, p, M):
        M[0, 0] = 1.0

    def force(t, q, u, p, h):
        h[0] = -p.k * math.sin(q[0]) + math.cos(3.0 * t)
        if damped:
            h[0] -= 0.5 * u[0]

    return ns.System(n_q=1, mass=mass, force=force, parameters=Driven(), name="driven pendulum")


def test_smooth_motion_is_reached_to_the_tolerance_with_few_steps():
    """Error against DOP853 at 1e-12; 1000 times less error costs less than three times the plain steps: order > 6."""
    from scipy.integrate import solve_ivp

    system, costs = oscillator(True), []
    exact = solve_ivp(
        lambda t, y: [y[1], -40.0 * math.sin(y[0]) - 0.5 * y[1] + math.cos(3.0 * t)], (0.0, 3.0), [0.7, 0.0],
        method="DOP853", rtol=1e-12, atol=1e-13,
    ).y[0, -1]  # fmt: skip
    for rtol in (1e-6, 1e-9):
        sol = run(system, 3.0, ([0.7], [0.0]), rtol, every=1000)
        assert abs(sol.q[-1, 0] - exact) < 10 * rtol
        costs.append(sol.stats.evaluations)
    assert costs[1] < 3.0 * costs[0]


def test_motion_without_dissipation_runs_back_to_its_start():
    """A swing of a pendulum, the velocity turned round, and as long again."""
    system = oscillator(False)
    there = ns.simulate(system, (0.0, 2.0), [0.7], [0.0], integrator=ns.Adaptive(1e-10, 1e-12))

    def mass(t, q, p, M):
        M[0, 0] = 1.0

    def force(t, q, u, p, h):
        h[0] = -p.k * math.sin(q[0]) + math.cos(3.0 * (2.0 - t))

    mirrored = ns.System(n_q=1, mass=mass, force=force, parameters=Driven(), name="mirrored")
    back = ns.simulate(mirrored, (0.0, 2.0), there.q[-1], -there.u[-1], integrator=ns.Adaptive(1e-10, 1e-12))
    assert back.q[-1, 0] == pytest.approx(0.7, abs=1e-8) and back.u[-1, 0] == pytest.approx(0.0, abs=1e-7)


def test_momentum_of_a_chain_changes_at_the_wall_only():
    """Impacts between beads conserve it to rounding, whatever the tolerance."""
    beads = BeadChain(n=5, e=0.9)
    sol = run(beads, 0.02, beads.state(velocity=1.0), 1e-6)
    momentum = sol.u.sum(axis=1)
    wall = np.cumsum(sol.P_N[:, -1])
    assert np.abs(momentum + wall - 1.0).max() < 1e-12


def test_energy_ledger_balances_to_the_tolerance():
    """Kinetic energy is the sum of the works of forces, friction, normal forces and surfaces."""
    cases = (
        (PainleveRod(mu=0.5), {"th": math.pi / 3, "thdot": 0.0, "slip": 1.0}, 0.3),
        (SpragSlip.set_1(cth=0.5), {"th": 0.8, "thdot": 0.0}, 1.0),
        (RockingBlock(), {"tilt": 0.1}, 1.0),
    )
    for model, start, t_end in cases:
        sol = run(model, t_end, model.state(**start), 1e-8)
        ledger = sol.ledger
        works = sum(ledger[name] for name in ("force", "friction", "normal", "surface"))
        size = 1.0 + np.abs(ledger["kinetic"]).max() + np.abs(ledger["surface"]).max()
        assert np.abs(ledger["kinetic"] - ledger["kinetic"][0] - works).max() < 1e-6 * size


def test_two_impacts_at_once_are_one_event():
    """A block that falls flat on both corners without restitution stays, and its corners share the impulse."""
    block = RockingBlock()
    q0, u0 = block.state(tilt=0.0)
    sol = run(block, 0.5, (q0 + [0.0, 0.1, 0.0], u0), 1e-8)
    assert sol.q[-1] == pytest.approx(q0, abs=1e-8)
    impulse = sol.P_N[sol.t <= 0.2].sum(axis=0)
    fall = block.m * math.sqrt(2 * block.g * 0.1)
    assert impulse.sum() > 0.99 * fall and impulse[0] == pytest.approx(impulse[1], rel=1e-6)


def test_no_gap_is_passed():
    """A fast ball and a step that could jump over the floor; the deepest gap is far below the tolerance."""
    ball = BouncingBall(e=0.9)
    sol = run(ball, 3.0, ball.state(height=1.0, velocity=-50.0), 1e-6, every=1)
    assert sol.stats.worst_penetration < 1e-6 * np.abs(sol.q).max() and sol.g_N.min() > -1e-6


def test_woodpecker_agrees_with_the_event_driven_motion():
    toy = Woodpecker()
    state = toy.state()
    reference = ns.simulate(toy, (0.0, 0.15), *state, integrator=ns.EventDriven(1e-10, 1e-12), every=1000).q[-1]
    assert np.abs(run(toy, 0.15, state, 1e-8, every=1000).q[-1] - reference).max() < 1e-7


def test_two_runs_are_equal_bit_for_bit():
    rod = SpragSlip()
    sols = [run(rod, 0.5, rod.state(), 1e-7) for _ in range(2)]
    assert np.array_equal(sols[0].t, sols[1].t) and np.array_equal(sols[0].q, sols[1].q)


def test_interpreted_and_compiled_runs_agree(monkeypatch):
    ball = BouncingBall(e=0.5)
    compiled = run(ball, 1.2, ball.state(height=1.0), 1e-4)
    monkeypatch.setenv("NONSMOOTH_INTERPRET", "1")
    interpreted = run(ball, 1.2, ball.state(height=1.0), 1e-4)
    assert not interpreted.stats.is_compiled
    assert interpreted.q[-1] == pytest.approx(compiled.q[-1], abs=1e-12)


def test_times_asked_for_are_the_ends_of_steps():
    ball = BouncingBall(e=0.5)
    t = np.array([0.1, 0.3, 0.45])
    sol = run(ball, 1.0, ball.state(height=1.0), 1e-6, t_eval=t)
    assert np.array_equal(sol.t, t)
    assert sol.q[:, 0] == pytest.approx([ball.height(moment) for moment in sol.t], abs=1e-6)


def test_wall_budget_ends_a_run_with_what_was_computed():
    rod = SpragSlip()
    sol = ns.simulate(
        rod, (0.0, 1e6), *rod.state(), integrator=ns.Adaptive(1e-9), max_wall_time=0.05, on_failure="return"
    )
    assert not sol.success and 0.0 < sol.t[-1] < 1e6 and np.isfinite(sol.q).all()


def test_a_force_that_fails_is_named():
    def mass(t, q, p, M):
        M[0, 0] = 1.0

    def force(t, q, u, p, h):
        h[0] = math.sqrt(1.0 - q[0])

    system = ns.System(n_q=1, mass=mass, force=force, name="sqrt")
    sol = ns.simulate(system, (0.0, 10.0), [0.0], [1.0], integrator=ns.Adaptive(1e-6), on_failure="return")
    assert sol.status == Status.NOT_FINITE and "force" in sol.message and sol.q[-1, 0] < 1.001


@pytest.mark.parametrize(
    ("options", "word"),
    [({"rtol": 0.0}, "rtol"), ({"rtol": -1e-6}, "rtol"), ({"rtol": math.nan}, "rtol"), ({"rtol": 1.0}, "rtol"),
     ({"atol": 0.0}, "atol"), ({"atol": -1.0}, "atol"), ({"atol": math.nan}, "atol"), ({"rtol": "fine"}, "rtol")],
)  # fmt: skip
def test_tolerances_that_mean_nothing_are_refused(options, word):
    with pytest.raises(InvalidInput, match=word):
        ns.Adaptive(**options)


def test_times_outside_the_run_are_refused():
    ball = BouncingBall()
    with pytest.raises(InvalidInput, match="t_eval"):
        run(ball, 1.0, ball.state(), 1e-6, t_eval=[0.5, 1.5])


def test_step_budget_ends_a_run_with_what_was_computed():
    """As many steps as were allowed, and the exception holds them."""
    rod = SpragSlip()
    with pytest.raises(ns.BudgetSpent) as spent:
        ns.simulate(rod, (0.0, 10.0), *rod.state(), integrator=ns.Adaptive(1e-9), max_steps=50)
    sol = spent.value.solution
    assert sol.stats.steps == 50 and 0.0 < sol.t[-1] < 10.0 and np.isfinite(sol.q).all()


class Row(NamedTuple):
    k: float = 100.0  # springs [N/m]
    mu: float = 0.3
    g: float = 9.81  # m/s^2


def row_of_blocks():
    """Three blocks of 1 kg in a row of springs on the ground: q = x_1, y_1, x_2, ..."""

    def mass(t, q, p, M):
        for i in range(6):
            M[i, i] = 1.0

    def force(t, q, u, p, h):
        for i in range(3):
            h[2 * i + 1] = -p.g
        h[0] = p.k * (q[2] - q[0])
        h[2] = p.k * (q[0] + q[4] - 2.0 * q[2])
        h[4] = p.k * (q[2] - q[4])

    def gap(t, q, p, g_N):
        for i in range(3):
            g_N[i] = q[2 * i + 1]

    def normal(t, q, p, W_N):
        for i in range(3):
            W_N[i, 2 * i + 1] = 1.0

    def tangent(t, q, p, W_F):
        for i in range(3):
            W_F[i, 0, 2 * i] = 1.0

    return ns.System(n_q=6, mass=mass, force=force, gap=gap, normal=normal, tangent=tangent,
                     contacts=[ns.Contact(mu="mu")] * 3, parameters=Row(), name="row of blocks")  # fmt: skip


def test_block_at_rest_slides_as_soon_as_its_spring_pulls_harder_than_friction_holds():
    """However short the steps are, and however fast its neighbour is: x_1'' = -mu g - k x_1 until k x_1 = mu g.

    Being late by s leaves a velocity k v s^2/2 out, of which the tolerance is 2 rtol.
    """
    row = Row()
    omega, away = math.sqrt(row.k), row.mu * row.g / row.k
    size = math.hypot(away, 2.0 / omega)  # x_1 + away = size sin(omega t + phase), away from the start at -away
    starts = (math.asin(2 * away / size) - math.asin(away / size)) / omega
    for rtol in (1e-6, 1e-8, 1e-10):
        sol = run(row_of_blocks(), 0.1, (np.zeros(6), np.array([2.0, 0, 0, 0, 0, 0])), rtol, max_steps=2000)
        moved = next(event.t for event in sol.events if event.contact == 1 and event.slip_after != 0)
        assert moved == pytest.approx(starts, abs=math.sqrt(2 * 2 * rtol / (2 * row.k)))


@pytest.mark.parametrize("selection", ["compliant-limit", "lift-off", "impact"])
@pytest.mark.parametrize(
    ("model", "start"),
    [(BilateralRod(mu=2.0), {"th": 1.0, "thdot": 0.0, "slip": 1.0}), (SpragSlip(), {"th": 0.8, "thdot": 0.0}),
     (SpragSlip.set_1(cth=0.5), {"th": 0.8, "thdot": 0.0}),
     (PainleveRod(mu=2.0), {"th": 1.0, "thdot": 0.0, "slip": 1.0})],
    ids=["bilateral rod", "set 2", "set 1", "rod"],
)  # fmt: skip
def test_rule_among_several_solutions_is_asked_where_a_mode_is_decided(model, start, selection):
    """Through regions of three solutions the motion is that of located events, whose modes are decided at events."""
    state = model.state(**start)
    sol = run(model, 0.3, state, 1e-7, selection=selection, max_steps=5000)
    exact = ns.simulate(model, (0.0, 0.3), *state, integrator=ns.EventDriven(1e-10, 1e-12), selection=selection)
    assert np.abs(sol.q[-1] - exact.q[-1]).max() < 1e-5


@pytest.mark.parametrize("push", [3.0, 30.0, 300.0, 3e4])
@pytest.mark.parametrize("rtol", [1e-4, 1e-7])
def test_body_that_is_pushed_off_its_surface_strikes_it_first(push, rtol):
    """m = 1, v = -2: the push turns it within the surface, v^2/2a deep, and a long step would not see the impact.

    From y = 0.99 v^2/2a it arrives at v/10 and leaves with e v/10; the time is rtol over that speed off.
    """

    def force(t, q, u, p, h):
        h[0] = push

    body = ball(force=force)
    impact, t_end = 1.8 / push, 1.8 / push + 1.0
    sol = ns.simulate(body, (0.0, t_end), [1.98 / push], [-2.0], integrator=ns.Adaptive(rtol, 1e-2 * rtol))
    (event,) = [event for event in sol.events if event.kind == ns.EventKind.IMPACT]
    assert event.t == pytest.approx(impact, abs=10 * rtol)
    assert sol.u[-1, 0] == pytest.approx(0.1 + push, rel=10 * rtol)
    assert sol.q[-1, 0] == pytest.approx(0.1 + 0.5 * push, rel=10 * rtol)


@pytest.mark.filterwarnings("ignore::nonsmooth.SimultaneousImpactWarning")  # what is asked holds for it too
def test_many_impacts_at_one_instant_have_room_wherever_the_last_ones_were_emptied(monkeypatch):
    """Twelve beads come to rest on one another: hundreds of impacts at one time."""
    chain = BeadChain(n=12, e=0.46)
    runs = []
    for capacity in (0, 1024, 20000):
        monkeypatch.setattr(workspace, "EVENT_CAPACITY", capacity)
        runs.append(ns.simulate(chain, (0, 0.5), *chain.state(), integrator=ns.Adaptive(1e-6, 1e-8)))
    assert all(one.stats.events_dropped == 0 for one in runs)
    assert np.array_equal(runs[0].event_rows, runs[1].event_rows) and len(runs[0].events) > 200
    assert np.array_equal(runs[0].event_rows, runs[2].event_rows)


WEDGE = """
import nonsmooth as ns

def mass(t, q, p, M):
    M[0, 0] = 2.0

def force(t, q, u, p, h):
    h[0] = -3.0

def gap(t, q, p, g_N):
    g_N[0] = q[0]

def normal(t, q, p, W_N):
    W_N[0, 0] = 1.0

def tangent(t, q, p, W_F):
    W_F[0, 0, 0] = 0.5

wedge = ns.System(mass, force, n_q=1, gap=gap, normal=normal, tangent=tangent, contacts=[ns.Contact(mu=0.5)])
sol = ns.simulate(wedge, (0.0, 1.0), [0.1], [0.0], integrator=ns.Adaptive(1e-6, 1e-8))
assert abs(sol.events[0].t - (2.0 * 0.1 / 1.5) ** 0.5) < 1e-6 and abs(sol.q[-1, 0]) < 1e-7 and sol.u[-1, 0] == 0.0
"""


@pytest.mark.upkeep
def test_wedge_rests_on_normal_and_tangent_that_are_one_row():
    """One coordinate, so that both rows of its contact are parallel and share the load. In a process of its own: what
    others have loaded does not count."""
    done = subprocess.run([sys.executable, "-c", WEDGE], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
