"""Event-driven integration: closed forms, printed references, orders.

Unless a tolerance is derived beside it, a figure is compared to the last printed digit: half a unit of it, and as much
for the accumulated error at rtol = 1e-11.
"""

import math
from typing import NamedTuple

import numpy as np
import pytest
from scipy.optimize import brentq

import nonsmooth as ns
from models import (
    BeltOscillator,
    BouncingBall,
    FollowerForceArm,
    PainleveRod,
    RockingBlock,
    SlidingBlock,
    SpragSlip,
    WallPendulum,
)
from nonsmooth.errors import InvalidInput

FINE = ns.EventDriven(rtol=1e-11, atol=1e-13)
STICK, SLIDE, OPEN = ns.ContactMode.STICK, ns.ContactMode.SLIDE, ns.ContactMode.OPEN


def run(model, t_end, state, integrator=FINE, **options):
    sol = ns.simulate(model, (0, t_end), *state, integrator=integrator, **options)
    assert sol.success
    return sol


def times(sol, kind=None, to=None, after=0.0):
    return np.array([e.t for e in sol.events if e.t >= after and kind in (None, e.kind) and to in (None, e.mode_after)])


# Zeno: NUMERICS section 5, t_inf = sqrt(2 h/g) (1 + e)/(1 - e)


@pytest.mark.parametrize("e, t_inf", [(0.5, 1.3545709), (0.8, 4.0637128), (0.9, 8.5789492)])
def test_ball_comes_to_rest_where_its_bounces_accumulate(e, t_inf):
    ball = BouncingBall(e=e)
    sol = run(ball, 10.0, ball.state(height=1.0))
    assert abs(sol.events[-1].t - t_inf) < 1e-7
    assert abs(sol.events[-1].t - ball.t_inf(height=1.0)) < 1e-12
    is_after = sol.t > ball.t_inf(height=1.0)
    assert is_after.any() and (sol.q[is_after] == 0.0).all() and (sol.u[is_after] == 0.0).all()


def test_ball_follows_its_parabolas_at_the_times_asked_for():
    ball = BouncingBall(e=0.8)
    t = np.linspace(0.0, 5.0, 501)
    sol = run(ball, 5.0, ball.state(height=1.0), t_eval=t)
    assert (sol.t == t).all()
    exact = [ball.height(moment, height=1.0) for moment in t]
    assert np.abs(sol.q[:, 0] - exact).max() < 1e-12  # parabolas are integrated exactly


def test_elastic_ball_bounces_for_ever_at_its_height():
    ball = BouncingBall(e=1.0)
    sol = run(ball, 20.0, ball.state(height=1.0))
    impacts = times(sol, ns.EventKind.IMPACT)
    assert np.abs(impacts - ball.impact_times(len(impacts), height=1.0)).max() < 1e-12


class Table(NamedTuple):
    """A ball on a table that is shaken with the amplitude a and the frequency omega."""

    g: float = 9.81  # m/s^2
    a: float = 0.1  # m
    omega: float = 20.0  # 1/s


def unit_mass(t, q, p, M):
    M[0, 0] = 1.0


def gravity(t, q, u, p, h):
    h[0] = -p.g


def table_gap(t, q, p, g_N):
    g_N[0] = q[0] - p.a * math.sin(p.omega * t)


def table_rate(t, q, p, w_N):
    w_N[0] = -p.a * p.omega * math.cos(p.omega * t)


def upwards(t, q, p, W_N):
    W_N[0, 0] = 1.0


def shaken_ball(t_end, y, e, table):
    """Height at t_end of a ball released at y, impact by impact: a parabola until its first root over the table."""
    t, v = 0.0, 0.0

    def above(s):
        return y + v * s - 0.5 * table.g * s * s - table.a * math.sin(table.omega * (t + s))

    while True:
        s = 1e-6
        while above(s) > 0.0 and t + s < t_end:
            s += 1e-4
        if t + s >= t_end:
            s = t_end - t
            return y + v * s - 0.5 * table.g * s * s
        s = brentq(above, s - 1e-4, s, xtol=1e-15)
        y, t = y + v * s - 0.5 * table.g * s * s, t + s
        w = table.a * table.omega * math.cos(table.omega * t)
        v = w - e * (v - table.g * s - w)


def test_ball_on_a_shaken_table_flies_its_parabolas():
    """Four impacts amplify an error of their times some hundred times."""
    ball = ns.System(
        n_q=1, mass=unit_mass, force=gravity, gap=table_gap, gap_rate=table_rate, normal=upwards,
        contacts=[ns.Contact(e_N=0.5)], parameters=Table(),
    )  # fmt: skip
    sol = run(ball, 3.0, ([0.5], [0.0]))
    assert len(times(sol, ns.EventKind.IMPACT)) == 4
    assert abs(sol.q[-1, 0] - shaken_ball(3.0, 0.5, 0.5, Table())) < 1e-11


def test_start_in_the_air_below_a_failing_force_names_the_time():
    """A force that is not a number from t = 1/2 on ends the run there, with what was computed."""

    def failing(t, q, u, p, h):
        h[0] = -math.sqrt(0.5 - t)

    ball = ns.System(
        n_q=1, mass=unit_mass, force=failing, gap=table_gap, normal=upwards, contacts=[ns.Contact()], parameters=Table()
    )
    with pytest.raises(ns.ModelFunctionError) as failure:
        ns.simulate(ball, (0, 1), [1.0], [0.0], integrator=FINE)
    assert abs(failure.value.t - 0.5) < 1e-6 and failure.value.solution.t[-1] == failure.value.t


# friction


def test_block_stops_where_its_kinetic_energy_is_spent():
    block = SlidingBlock()
    sol = run(block, 2.0, block.state(speed=2.0))
    assert abs(times(sol, to=STICK)[0] - block.stop_time(2.0)) < 1e-14
    assert abs(sol.q[-1, 0] - block.stop_distance(2.0)) < 1e-14
    assert sol.u[-1, 0] == 0.0


def test_bouncing_block_slides_as_far_as_its_impulses_allow():
    """Friction takes mu times the normal impulse whatever the bounces: once over, u = u_0 - mu (g t - v_0)."""
    block = SlidingBlock(mu=0.1, e=0.5)
    q0, u0 = block.state(speed=5.0)
    sol = run(block, 1.0, (q0, u0 + [0.0, 2.0]))
    assert abs(sol.u[-1, 0] - (5.0 - block.mu * (block.g * 1.0 - 2.0))) < 1e-12
    assert abs(sol.q[-1, 1]) < 1e-15


# SYSTEMS section D: paradoxes of the rod


def test_inconsistent_rod_passes_through_the_impact_without_collision():
    rod = PainleveRod(mu=2.0)
    sol = run(rod, 0.01, rod.state(th=math.pi / 3, thdot=0.0, slip=-1.0))
    exact = rod.impact_without_collision(th=math.pi / 3, thdot=0.0, slip=-1.0)
    (event,) = sol.paradoxes
    assert event.kind == ns.EventKind.INCONSISTENT and event.n_solutions == 0 and event.mode_after == STICK
    assert abs(event.P_N - exact.P_N) < 1e-14 and abs(event.P_F - exact.P_F) < 1e-14
    assert abs(sol.u[1] - exact.u).max() < 1e-14


def test_indeterminate_rod_does_what_is_selected():
    rod = PainleveRod(mu=2.0)
    start = rod.state(th=math.pi / 3, thdot=6.0, slip=-1.0)
    sol = run(rod, 0.01, start)
    (event,) = sol.paradoxes
    assert event.kind == ns.EventKind.INDETERMINATE and event.n_solutions == 2
    assert sol.mode[0, 0] == OPEN


# SYSTEMS section A: stick-slip on a conveyor


@pytest.mark.parametrize("vb, period, stick", [
    (0.05, 2.042809386, 0.303681193), (0.20, 2.020348258, 0.250147633), (0.39, 1.989427764, 0.038706254),
])  # fmt: skip
def test_belt_oscillator_reaches_the_printed_stick_slip_cycle(vb, period, stick):
    belt = BeltOscillator(vb=vb)
    sol = run(belt, 20.0, belt.state(x=belt.release_position(), velocity=vb))
    begins = times(sol, to=STICK)
    ends = times(sol, to=SLIDE, after=begins[-2])
    assert abs(begins[-1] - begins[-2] - period) < 1e-9
    assert abs(ends[0] - begins[-2] - stick) < 1e-9


# without contacts, and with impacts between smooth arcs


def test_follower_force_arm_without_contacts():
    """SYSTEMS section B, P = 500 N, from a deviation of 0.05 rad at the base."""
    arm = FollowerForceArm(P=500.0)
    rest = arm.equilibrium()
    sol = run(arm, 1.0, (rest + [0.05, 0.0], np.zeros(2)))
    assert np.abs(sol.q[-1] - rest - [-0.021525545, 0.013952941]).max() < 1e-9
    assert np.abs(sol.u[-1] - [2.625585437, -4.058975616]).max() < 1e-9
    assert sol.events == [] and sol.P_N.shape == (len(sol.t), 0)


def test_pendulum_strikes_the_wall_at_the_times_of_elliptic_integrals():
    pendulum = WallPendulum()
    sol = run(pendulum, 5.0, pendulum.state(th=1.0))
    impacts = times(sol, ns.EventKind.IMPACT)
    assert len(impacts) == 5 and np.abs(impacts - pendulum.impact_times(5, th=1.0)).max() < 1e-12


def test_pendulum_that_leans_on_the_wall_comes_to_rest_there():
    pendulum = WallPendulum(th_w=0.2)
    sol = run(pendulum, 12.0, pendulum.state(th=1.0))
    n = 20
    assert np.abs(times(sol, ns.EventKind.IMPACT)[:n] - pendulum.impact_times(n, th=1.0)).max() < 1e-11
    assert sol.mode[-1, 0] == ns.ContactMode.LOCKED and sol.u[-1, 0] == 0.0 and abs(sol.q[-1, 0] - 0.2) < 1e-15


def test_rocking_block_rocks_as_housner_says():
    block = RockingBlock()
    sol = run(block, 1.2, block.state(tilt=0.1))
    falls = times(sol, ns.EventKind.IMPACT)
    assert abs(falls[0] - block.fall_time(0.1)) < 1e-11
    next_tilt = block.next_tilt(0.1)
    assert abs(falls[1] - falls[0] - 2 * block.fall_time(next_tilt)) < 1e-11


# order, ledger, two speeds, bad input


def test_error_shrinks_in_proportion_to_the_tolerance():
    """Over five decades of rtol; the slope of log error over log rtol lies within 0.25 of one."""
    rod = PainleveRod(mu=1.0)
    start = rod.state(th=math.radians(75), thdot=-0.5, slip=-0.5)
    tolerances = 10.0 ** -np.arange(5, 11)
    errors = []
    reference = run(rod, 0.7, start, ns.EventDriven(rtol=1e-13, atol=1e-15)).q[-1]
    for rtol in tolerances:
        sol = run(rod, 0.7, start, ns.EventDriven(rtol=rtol, atol=1e-2 * rtol))
        errors.append(np.abs(sol.q[-1] - reference).max())
    slope = np.polyfit(np.log(tolerances), np.log(errors), 1)[0]
    assert abs(slope - 1.0) < 0.25
    assert (np.array(errors) < 10 * tolerances).all()


def test_energy_ledger_balances_through_slips_sticks_and_impacts():
    rod = SpragSlip()
    sol = run(rod, 3.0, rod.state(th=0.8, thdot=0.0))
    ledger = sol.ledger
    works = sum(ledger[name] for name in ("force", "friction", "normal", "surface"))
    change = ledger["kinetic"] - ledger["kinetic"][0]
    assert np.abs(change - works).max() < 1e-8 * np.abs(ledger["kinetic"]).max()


def test_interpreted_loop_agrees_bit_for_bit(monkeypatch):
    rod = PainleveRod(mu=0.3)
    start = rod.state(th=math.radians(50), thdot=0.0, slip=0.8)
    coarse = ns.EventDriven(rtol=1e-5, atol=1e-7)
    compiled = run(rod, 0.3, start, coarse)
    monkeypatch.setenv("NONSMOOTH_INTERPRET", "1")
    twin = run(rod, 0.3, start, coarse)
    assert not twin.stats.is_compiled and (twin.t == compiled.t).all() and (twin.q == compiled.q).all()


@pytest.mark.parametrize("options", [
    {"rtol": 0.0}, {"rtol": -1e-6}, {"rtol": math.nan}, {"rtol": 1e-16}, {"rtol": 1.0}, {"atol": 0.0},
    {"atol": math.nan}, {"atol": -1.0},
])  # fmt: skip
def test_tolerances_that_mean_nothing_are_refused(options):
    with pytest.raises(InvalidInput):
        ns.EventDriven(**options)
