"""Cycles through impacts and seizures: closed forms, printed values, finite differences of the return map."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns
from models import BouncingBall, PainleveRod, SpragSlip
from nonsmooth.cycles.jump import apply_jump, read_jump
from nonsmooth.cycles.mode_flow import mode_flow
from nonsmooth.cycles.mode_sequence import runs_of
from nonsmooth.numerics.complex_step import jacobian


class Table(NamedTuple):
    m: float = 1.0  # mass of the ball [kg]
    g: float = 9.81  # gravity [m/s^2]
    A: float = 0.009  # amplitude of the table [m]
    w: float = 30.0  # its angular frequency [rad/s]
    e: float = 0.6  # restitution [-]


def ball_mass(t, q, p, M):
    M[0, 0] = p.m


def weight(t, q, u, p, h):
    h[0] = -p.m * p.g


def height(t, q, p, g_N):
    g_N[0] = q[0] - p.A * math.sin(p.w * t)


def upwards(t, q, p, W_N):
    W_N[0, 0] = 1.0


def table_speed(t, q, p, w_N):
    w_N[0] = -p.A * p.w * math.cos(p.w * t)


def table_acceleration(t, q, u, p, r):
    r[0, 0] = p.A * p.w**2 * math.sin(p.w * t)


def ball_on(table):
    return ns.System(n_q=1, mass=ball_mass, force=weight, gap=height, normal=upwards, gap_rate=table_speed,
                     row_rates=table_acceleration, contacts=[ns.Contact(e_N="e")], parameters=table)  # fmt: skip


def periodic_bounce(table, n, rising=False):
    """Closed form: each flight lasts n periods, so the ball leaves with V = g n T/2 and comes back with -V; Newton's
    law gives the table's speed at the impact. Returns the phase of the impact, V, and the two multipliers."""
    T, g, e = 2 * math.pi / table.w, table.g, table.e
    V = g * n * T / 2
    phase = math.acos(V * (1 - e) / ((1 + e) * table.A * table.w)) * (-1 if rising else 1)
    trace = 1 + e**2 - (1 + e) ** 2 * table.A * table.w**2 * math.sin(phase) / g  # determinant e^2
    return phase, V, np.roots([1, -trace, e**2])


@pytest.mark.parametrize("table, n, rising", [
    (Table(), 1, False), (Table(), 1, True), (Table(A=0.02, e=0.8), 2, False),
    (Table(A=0.012, w=40.0, e=0.5), 1, False),
])  # fmt: skip
def test_ball_on_a_table_has_the_bounce_and_the_multipliers_of_the_closed_form(table, n, rising):
    phase, V, multipliers = periodic_bounce(table, n, rising)
    T = 2 * math.pi / table.w
    leaves = phase / table.w + T
    # a motion of little more than two flights from a start that is off by 1e-4 is guess enough, stable or not
    start = [table.A * math.sin(phase) + 1e-9], [V * (1 + 1e-5)]
    run = ns.simulate(ball_on(table), (leaves, leaves + 6.3 * n * T), *start, integrator=ns.EventDriven(rtol=1e-9))
    cycle = ns.limit_cycle(ball_on(table), run, forcing=T)
    assert cycle.period == pytest.approx(n * T, rel=1e-11)
    (flight,) = cycle.phases
    assert (table.w * flight.x[-1]) % (2 * math.pi) == pytest.approx(phase % (2 * math.pi), abs=1e-9)
    assert flight.u[0] == pytest.approx(V, rel=1e-10) and flight.ends_by == (0, "gap")
    np.testing.assert_allclose(np.sort_complex(cycle.multipliers), np.sort_complex(multipliers), rtol=1e-5)
    assert cycle.is_stable == (np.abs(multipliers) < 1).all()


def test_steady_bounce_is_found_from_a_start_and_followed_along_the_tables_amplitude():
    table = Table()
    T = 2 * math.pi / table.w
    phase, V, _ = periodic_bounce(table, 1)
    flown = T - phase / table.w  # at t = 0
    start = [table.A * math.sin(phase) + V * flown - table.g * flown**2 / 2], [0.98 * (V - table.g * flown)]
    cycle = ns.limit_cycle(ball_on(table), start, duration=40 * T, forcing=T)
    assert cycle.is_stable and cycle.period == pytest.approx(T, rel=1e-11)
    branch = ns.continue_cycle(ball_on(table), "A", [0.009, 0.0095, 0.01], cycle)
    found = [branch_cycle.multipliers for branch_cycle in branch.cycles]
    closed = [periodic_bounce(table._replace(A=A), 1)[2] for A in branch.values]
    np.testing.assert_allclose(np.prod(found, axis=1), table.e**2, rtol=1e-5)
    np.testing.assert_allclose(np.sum(found, axis=1), np.sum(closed, axis=1), rtol=1e-4)


def test_ball_that_rests_on_the_table_moves_with_it():
    table = Table(A=0.005)  # A w^2 < g
    cycle = ns.limit_cycle(ball_on(table), ([0.05], [0.0]), duration=5.0, forcing=2 * math.pi / table.w)
    assert cycle.amplitudes[0] == pytest.approx(table.A, rel=1e-4)  # the samples miss the top
    assert cycle.phases[0].states[0].mode == ns.ContactMode.LOCKED


def test_an_excitation_without_its_period_is_refused_and_so_is_a_period_without_excitation():
    with pytest.raises(ns.InvalidInput, match="give forcing="):
        ns.limit_cycle(ball_on(Table()), ([0.1], [0.0]), duration=1.0)
    with pytest.raises(ns.InvalidInput, match="leave forcing out"):
        ns.limit_cycle(SpragSlip(), forcing=1.0)


def test_impacts_that_accumulate_are_refused_by_name():
    table = Table(A=0.012)
    with pytest.raises(ns.InvalidInput, match="accumulate"):
        ns.limit_cycle(ball_on(table), ([0.0], [0.1]), duration=1.0, forcing=2 * math.pi / table.w)


@pytest.fixture(scope="module")
def seizing():
    return ns.limit_cycle(SpragSlip())


def test_seizure_orbit_of_the_sprag_slip_rod_has_the_printed_values(seizing):
    """Printed: rigid limit of the sprag-slip rod, set 2."""
    assert seizing.period == pytest.approx(0.460134276, abs=6e-10)
    sticks, slides = sorted(seizing.phases, key=lambda phase: not phase.sticks)
    assert sticks.duration == pytest.approx(0.061700499, abs=6e-10)
    assert (sticks.q[1], sticks.u[1]) == pytest.approx((0.807078634, 2.769048317), abs=6e-10)
    assert slides.q[1] == pytest.approx(0.966466904, abs=6e-10)
    assert slides.ends_by == (0, "normal") and slides.jump is not None and not slides.jump.closing
    (low, high) = seizing.extremes
    assert (high[1], low[3]) == pytest.approx((1.215713, -2.275685), abs=6e-7)
    assert seizing.is_stable and np.abs(seizing.multipliers).max() < 1e-6  # a seizure forgets where it came from


def test_seizure_orbit_of_other_rods_agrees_with_long_simulations():
    for change in ({"vb": 8.0}, {"mu": 1.25, "cth": 8.0}):
        rod = SpragSlip(**change)
        cycle = ns.limit_cycle(rod)
        run = ns.simulate(rod, (0.0, 12.0), *rod.state(), integrator=ns.EventDriven(rtol=1e-9))
        jumps = [event.t for event in run.paradoxes if event.n_solutions == 0]
        assert cycle.period == pytest.approx(np.diff(jumps)[-1], abs=1e-8)


class Stop(NamedTuple):
    """Mass on a belt, in front of a stop: negative damping of the friction feeds what the impacts take away."""

    m: float = 1.0
    k: float = 10.0
    c: float = 0.02
    N: float = 1.0
    m0: float = 0.4
    m1: float = 0.30
    m3: float = 0.2
    vb: float = 0.5
    x_s: float = 0.06  # position of the stop [m]
    e: float = 0.85


def mass(t, q, p, M):
    M[0, 0] = p.m


def force(t, q, u, p, h):
    h[0] = -p.k * q[0] - p.c * u[0]


def tangent(t, q, p, W_F):
    W_F[0, 0, 0] = 1.0
    W_F[1, 0, 0] = 0.0


def belt_speed(t, q, p, w_F):
    w_F[0, 0] = -p.vb


def normal_force(t, q, u, p, N):
    N[0] = p.N


def distance(t, q, p, g_N):
    g_N[1] = p.x_s - q[0]


def towards(t, q, p, W_N):
    W_N[1, 0] = -1.0


@pytest.fixture(scope="module")
def stopped():
    system = ns.System(n_q=1, mass=mass, force=force, tangent=tangent, surface_velocity=belt_speed, gap=distance,
                       normal=towards, normal_force=normal_force, parameters=Stop(),
                       contacts=[ns.Contact(mu=ns.Polynomial("m0", "m1", "m3"), normal_force=True),
                                 ns.Contact(e_N="e")])  # fmt: skip
    return system, ns.limit_cycle(system, ([0.0], [0.1]), duration=100.0)


def test_mass_between_belt_and_stop_returns_with_the_multiplier_of_its_return_map(stopped):
    system, cycle = stopped
    assert len(cycle.phases) == 1 and cycle.phases[0].jump is not None and cycle.residual < 1e-10
    h = 1e-6
    away = cycle.phases[0].duration / 2  # start in mid-flight, one period long
    half = ns.simulate(system, (0.0, away), *states(cycle), integrator=ns.EventDriven(rtol=1e-12, atol=1e-14))
    x_0 = np.concatenate([half.q[-1], half.u[-1]])
    ends = np.array([returned(system, x_0 + d, cycle.period) for d in (*(h * np.eye(2)), *(-h * np.eye(2)))])
    monodromy = (ends[:2] - ends[2:]).T / (2 * h)
    eigenvalues = np.sort(np.linalg.eigvals(monodromy).real)
    # differences of second order, h^2, and of motions good to 1e-12/h
    assert eigenvalues == pytest.approx(np.sort([1.0, cycle.multipliers[0].real]), abs=5e-5)
    assert 0.1 < abs(cycle.multipliers[0]) < 1


def states(cycle):
    return cycle.phases[0].q, cycle.phases[0].u


def returned(system, x, period):
    run = ns.simulate(system, (0.0, period), x[:1], x[1:], integrator=ns.EventDriven(rtol=1e-12, atol=1e-14))
    return np.concatenate([run.q[-1], run.u[-1]])


@pytest.mark.filterwarnings("ignore::nonsmooth.FrictionGainWarning")  # of Newton's law where the slide is reversed
@pytest.mark.parametrize("law", ["newton", "poisson", "energetic"])
@pytest.mark.parametrize("thdot, xdot", [(-1.0, 3.0), (4.0, -0.2), (-2.0, 0.1)])
def test_jump_is_that_of_the_integrator_and_its_derivative_that_of_differences(law, thdot, xdot):
    from dataclasses import replace

    rod = PainleveRod(mu=0.3, e=0.6)
    free = rod.system()
    system = replace(free, contacts=[replace(free.contacts[0], impact=law)])
    q = np.array([0.0, 0.5 * rod.l * math.sin(0.9) + 1e-3, 0.9])
    run = ns.simulate(system, (0.0, 0.3), q, [xdot, -2.0, thdot], integrator=ns.EventDriven(rtol=1e-9))
    first, second = runs_of(run)[:2]
    x = np.concatenate([run.q, run.u], axis=1)
    before, after = x[first.end], x[second.start]
    flow = mode_flow(system, first.states)
    jump = read_jump(flow, before, after, [event for event in run.events if event.t == run.t[first.end]])
    assert jump.closing == (0,) and jump.has_own_law == (law != "newton")
    np.testing.assert_allclose(apply_jump(jump, flow, before).real, after, rtol=1e-12, atol=1e-12)
    R, h = jacobian(lambda z: apply_jump(jump, flow, z), before)[1], 1e-6
    ahead, behind = ([apply_jump(jump, flow, before + s * d).real for d in h * np.eye(6)] for s in (1, -1))
    np.testing.assert_allclose(R, (np.array(ahead) - behind).T / (2 * h), atol=1e-7)


def test_motion_of_fixed_steps_through_impacts_is_refused_for_one_with_located_events():
    ball = BouncingBall(e=0.9)
    run = ns.simulate(ball, (0.0, 4.0), *ball.state(), integrator=ns.MoreauJean(dt=1e-3))
    with pytest.raises(ns.InvalidInput, match="EventDriven"):
        ns.limit_cycle(ball, run)
