"""Cycles that close but for a drift: against long event-driven runs, turning frames, and closed forms."""

from __future__ import annotations

import dataclasses
import math
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns
from models import BeltOscillator, Woodpecker
from nonsmooth.cycles.drift import find_drift
from nonsmooth.integrators.records import EVENT_CONTACT, EVENT_KIND, EVENT_T, IMPACT


@pytest.mark.upkeep
def test_woodpecker_climbs_down_by_the_drift_of_its_cycle():
    """A long run tends to it by the largest multiplier: 0.84 from one period to the next, with a minus."""
    toy = Woodpecker()
    cycle = ns.limit_cycle(toy)
    assert cycle.is_stable and cycle.residual < 1e-11 and cycle.drift[0] < 0 and (cycle.drift[1:] == 0).all()
    run = ns.simulate(toy, (0, 8.0), *toy.state(), integrator=ns.EventDriven(1e-11, 1e-13))
    rows = run.event_rows
    strokes = rows[(rows[:, EVENT_KIND] == IMPACT) & (rows[:, EVENT_CONTACT] == 0), EVENT_T]
    heights = run(strokes).q[:, 0]
    left = np.diff(strokes) - cycle.period, np.diff(heights) - cycle.drift[0]
    for errors in left:
        late = errors[20:30]
        assert np.allclose(late[1:] / late[:-1], cycle.multipliers[0].real, atol=5e-3)
        assert abs(errors[-1]) < 1e-5 * abs(cycle.drift[0])


# A drill string: the bit sticks and slips at the end of a shaft that is turned on and on ----------------------------


class Drill(NamedTuple):
    J: float = 0.4  # inertia of the bit [kg m^2]
    J_top: float = 2.0  # of the table [kg m^2]
    k: float = 10.0  # stiffness of the string [N m/rad]
    c: float = 0.05  # its damping [N m s/rad]
    d: float = 3.0  # of the motor [N m s/rad]
    W: float = 1.0  # its speed [rad/s]
    N: float = 1.0  # force on the bit [N]
    mu_s: float = 1.2
    mu_k: float = 0.6
    v_s: float = 0.5


BIT = {"contacts": [ns.Contact(mu=ns.Stribeck(mu_s="mu_s", mu_k="mu_k", v_s="v_s"), normal_force=True)]}


def bit_mass(t, q, p, M):
    M[0, 0] = p.J


def driven(t, q, u, p, h):
    h[0] = p.k * (p.W * t - q[0]) + p.c * (p.W - u[0])


def in_its_frame(t, q, u, p, h):
    h[0] = -p.k * q[0] - p.c * u[0]


def at_the_rock(t, q, p, W_F):
    W_F[0, 0, 0] = 1.0


def rock_speed(t, q, p, w_F):
    w_F[0, 0] = p.W


def weight_on_bit(t, q, u, p, N):
    N[0] = p.N


def discs(t, q, p, M):
    M[0, 0] = p.J_top
    M[1, 1] = p.J


def twisted(t, q, u, p, h):
    moment = p.k * (q[0] - q[1]) + p.c * (u[0] - u[1])
    h[0] = p.d * (p.W - u[0]) - moment
    h[1] = moment


def second_at_the_rock(t, q, p, W_F):
    W_F[0, 0, 1] = 1.0


def drill(**parameters):
    """The bit alone, its shaft turned at a constant rate: the force reads the time, without a period."""
    return ns.System(n_q=1, mass=bit_mass, force=driven, tangent=at_the_rock, normal_force=weight_on_bit,
                     parameters=Drill(**parameters), **BIT)  # fmt: skip


def drill_in_its_frame(**parameters):
    return ns.System(n_q=1, mass=bit_mass, force=in_its_frame, tangent=at_the_rock, surface_velocity=rock_speed,
                     normal_force=weight_on_bit, parameters=Drill(**parameters), **BIT)  # fmt: skip


def drill_of_two_discs(**parameters):
    """The shaft between a turned table and the bit: no function changes where both turn by the same angle."""
    return ns.System(n_q=2, mass=discs, force=twisted, tangent=second_at_the_rock, normal_force=weight_on_bit,
                     parameters=Drill(**parameters), **BIT)  # fmt: skip


def test_a_constant_drive_gives_the_cycle_of_the_frame_that_turns_with_it():
    outside = ns.limit_cycle(drill(), ([0.0], [0.1]), duration=20.0)
    inside = ns.limit_cycle(drill_in_its_frame(), ([0.0], [-0.9]), duration=20.0)
    assert outside.stick_duration > 0.1
    assert outside.period == pytest.approx(inside.period, rel=1e-10)
    assert outside.stick_duration == pytest.approx(inside.stick_duration, rel=1e-9)
    assert outside.drift == pytest.approx([Drill().W * outside.period], rel=1e-12)
    assert (inside.drift == 0).all() and not inside.drifts
    assert outside.multipliers == pytest.approx(inside.multipliers, abs=1e-6)  # a stick each
    assert outside.amplitudes == pytest.approx(inside.amplitudes, rel=1e-9)  # without what it goes on
    assert max(outside.residual, inside.residual) < 1e-9


class Dragged(NamedTuple):
    """A disc that a turning drive drags through a spring and a damper over dry friction."""

    W: float = 1.5
    k: float = 9.0
    c: float = 0.2
    m2: float = 0.0  # of a second disc on a shaft to the first


def of_one(t, q, p, M):
    M[0, 0] = 1.0


def dragged(t, q, u, p, h):
    h[0] = p.k * (p.W * t - q[0]) + p.c * (p.W - u[0])


def of_two(t, q, p, M):
    M[0, 0], M[1, 1] = 1.0, p.m2


def dragged_with_another(t, q, u, p, h):
    shaft = 7.0 * (q[1] - q[0]) + 0.1 * (u[1] - u[0])
    h[0] = p.k * (p.W * t - q[0]) + p.c * (p.W - u[0]) + shaft
    h[1] = -shaft


def under_it(t, q, p, W_F):
    W_F[0, 0, 0] = 1.0


def steady_load(t, q, u, p, N):
    N[0] = 2.0


DRY = {"tangent": under_it, "normal_force": steady_load, "contacts": [ns.Contact(mu=0.3, normal_force=True)]}


@pytest.mark.upkeep
@pytest.mark.parametrize("duration", [60.0, 100.0, 140.0, 160.0, 185.0, 220.0])
@pytest.mark.parametrize(("bodies", "change"), [(1, {}), (1, {"W": 0.4, "k": 2.0}), (1, {"c": 0.11}), (2, {"m2": 0.6})])
def test_a_transient_that_decays_towards_steady_turning_is_no_cycle(duration, bodies, change):
    """The disc slides at all times, so the system is linear and damped: nothing but steady turning repeats."""
    mass, force = (of_one, dragged) if bodies == 1 else (of_two, dragged_with_another)
    p = Dragged(**change)
    system = ns.System(n_q=bodies, mass=mass, force=force, parameters=p, **DRY)
    with pytest.raises(ns.InvalidInput, match="goes on steadily|leads back to a state of rest|dies out|oscillate"):
        ns.limit_cycle(system, ([0.0] * bodies, [0.93 * p.W] * bodies), duration=duration)


def test_two_discs_on_a_shaft_turn_on_together():
    cycle = ns.limit_cycle(drill_of_two_discs(), ([0.0, 0.0], [0.1, 0.1]), duration=40.0)
    assert cycle.drifts and cycle.drift[0] == pytest.approx(cycle.drift[1], rel=1e-12)
    assert cycle.residual < 1e-10  # across the drift
    assert len(cycle.multipliers) == 2 and cycle.is_stable  # of four: one in time, one along the common angle
    start = cycle.phases[0]
    run = ns.simulate(
        drill_of_two_discs(), (0, 5 * cycle.period), start.q, start.u, integrator=ns.EventDriven(1e-11, 1e-13)
    )
    assert np.abs(run.q[-1] - start.q - 5 * cycle.drift).max() < 1e-8 * np.abs(cycle.drift).max()
    assert np.abs(run.u[-1] - start.u).max() < 1e-8
    # power in balance: the motor's torque turns the table as far as the friction torque holds back the bit
    samples = ns.simulate(drill_of_two_discs(), (0, cycle.period), start.q, start.u, integrator=ns.EventDriven(1e-11))
    motor = Drill().d * (Drill().W * cycle.period - cycle.drift[0])  # impulse of the motor's torque in a period
    assert motor == pytest.approx(-samples.P_F.sum(), rel=1e-8)


def test_a_branch_of_a_system_of_ones_own_begins_at_a_state():
    started = ns.continue_cycle(drill(), "W", [1.0, 1.1], state=([0.0], [0.1]), duration=20.0)
    handed = ns.continue_cycle(drill(), "W", [1.0, 1.1], cycle=ns.limit_cycle(drill(), ([0.0], [0.1]), duration=20.0))
    assert started.periods == pytest.approx(handed.periods, rel=1e-9) and not started.changes
    with pytest.raises(ns.InvalidInput, match=r"no default state; give state=\(q0, u0\)"):
        ns.continue_cycle(drill(), "W", [1.0, 1.1])
    with pytest.raises(ns.InvalidInput, match="no t_end of its own; give duration="):
        ns.continue_cycle(drill(), "W", [1.0, 1.1], state=([0.0], [0.1]))


def test_the_rate_of_the_drive_can_be_followed():
    branch = ns.continue_cycle(
        drill(), "W", [1.0, 1.1, 1.2], cycle=ns.limit_cycle(drill(), ([0.0], [0.1]), duration=20)
    )
    assert not branch.changes and len(branch.cycles) == 3
    for W, cycle in zip(branch.values, branch.cycles, strict=True):
        assert cycle.drift[0] / cycle.period == pytest.approx(W, rel=1e-9)
    alone = ns.limit_cycle(drill_in_its_frame(W=1.2), ([0.0], [-1.1]), duration=20.0)
    assert branch.cycles[-1].period == pytest.approx(alone.period, rel=1e-8)


# Forced and smooth cycles that drift --------------------------------------------------------------------------------


class Conveyor(NamedTuple):
    m: float = 1.0  # mass of the part [kg]
    A: float = 0.02  # amplitude of the trough [m]
    w: float = 30.0  # its angular frequency [rad/s]
    N: float = 9.81  # [N]
    mu: float = 0.3


def part(t, q, p, M):
    M[0, 0] = p.m


def no_force(t, q, u, p, h):
    pass


def trough(t, q, p, w_F):
    w_F[0, 0] = -p.A * p.w * (math.cos(p.w * t) + 0.5 * math.cos(2.0 * p.w * t + 1.0))


def test_a_shaken_trough_conveys_by_the_drift_of_its_forced_cycle():
    system = ns.System(n_q=1, mass=part, force=no_force, tangent=at_the_rock, surface_velocity=trough,
                       normal_force=weight_on_bit, contacts=[ns.Contact(mu="mu", normal_force=True)],
                       parameters=Conveyor())  # fmt: skip
    T = 2 * math.pi / Conveyor().w
    cycle = ns.limit_cycle(system, ([0.0], [0.0]), duration=40 * T, forcing=T)
    run = ns.simulate(system, (0, 80 * T), [0.0], [0.0], integrator=ns.EventDriven(1e-11, 1e-13))
    gone = float((run(80 * T).q - run(79 * T).q)[0])
    assert cycle.period == pytest.approx(T, rel=1e-12) and abs(cycle.drift[0]) > 1e-3
    assert cycle.drift[0] == pytest.approx(gone, rel=1e-7)


class Swimmer(NamedTuple):
    m: float = 1.0
    k: float = 4.0
    b: float = 0.3


def swimmer_mass(t, q, p, M):
    M[0, 0] = M[1, 1] = p.m


def swimmer_force(t, q, u, p, h):
    """A van der Pol oscillator q[1] that pushes q[0] through a fluid, where nothing depends on q[0]."""
    h[1] = -p.k * q[1] + p.b * (1.0 - q[1] * q[1]) * u[1]
    h[0] = -u[0] + q[1] * q[1]


def test_a_smooth_cycle_drifts_too():
    system = ns.System(n_q=2, mass=swimmer_mass, force=swimmer_force, parameters=Swimmer())
    cycle = ns.limit_cycle(system, ([0.0, 2.0], [0.0, 0.0]), duration=60.0)
    t, x = cycle.t, cycle.q[:, 1] ** 2
    assert cycle.drift[0] == pytest.approx(np.trapezoid(x, t), rel=1e-4)  # u_0' = x^2 - u_0 over a period
    assert cycle.drift[1] == 0 and len(cycle.multipliers) == 2 and cycle.is_stable


# What drifts, and what cannot ---------------------------------------------------------------------------------------


def places(system):
    return [(0.2, 0.3 + 0.1 * np.arange(system.n_q), 0.4 + 0.0 * np.arange(system.n_q))]


@pytest.mark.parametrize(
    ("system", "expected"),
    [(Woodpecker().system(), [[1, 0, 0, 0]]), (drill(W=2.5), [[2.5, 1]]), (drill_of_two_discs(), [[1, 1, 0]]),
     (drill_in_its_frame(), []), (BeltOscillator().system(), [])],
    ids=["woodpecker", "constant drive", "two discs", "turning frame", "belt"],
)  # fmt: skip
def test_the_directions_are_those_along_which_nothing_changes(system, expected):
    found = find_drift(system, places(system), is_forced=False).directions
    assert np.allclose(found, np.reshape(expected, (-1, system.n_q + 1)), atol=1e-12)


def heavier_below(t, q, u, p, h):
    moment = p.cphi * (q[2] - q[1])
    g = p.g * (1.0 - 1e-3 * q[0])
    h[0] = -(p.mM + p.mS) * g
    h[1] = moment - p.mS * g * p.lM
    h[2] = -moment - p.mS * g * p.lG


@pytest.mark.upkeep
def test_a_coordinate_that_goes_on_while_the_system_changes_with_it_is_named():
    toy = Woodpecker()
    system = dataclasses.replace(toy.system(), force=heavier_below, stiffness=None, potential=None)
    with pytest.raises(ns.InvalidInput, match=r"coordinate 0 by -0.019[0-9]* goes on, and the system changes with it"):
        ns.limit_cycle(system, toy.state(), duration=1.2)
    with pytest.raises(ns.InvalidInput, match="coordinate 0 cannot drift: force changes with it"):
        ns.limit_cycle(system, toy.state(), duration=1.2, drift=[0])


def test_what_is_asked_to_drift_must_be_able_to():
    discs, start = drill_of_two_discs(), ([0.0, 0.0], [0.1, 0.1])
    named = ns.limit_cycle(discs, start, duration=40.0, drift=[0, 1])
    assert named.drift[0] == pytest.approx(named.drift[1], rel=1e-12)
    with pytest.raises(ns.InvalidInput, match="coordinate 1 cannot drift alone: force changes with it"):
        ns.limit_cycle(discs, start, duration=40.0, drift=[1])
    with pytest.raises(ns.InvalidInput, match="does not close|do not repeat|goes on"):
        ns.limit_cycle(discs, start, duration=40.0, drift=[])
    with pytest.raises(ns.UnknownName, match="no coordinate 'height'.*known: phi_M, phi_S, y"):
        ns.limit_cycle(Woodpecker(), drift=["height"])
    assert ns.limit_cycle(Woodpecker(), drift=["y"]).drift[0] < 0


def test_steady_turning_is_no_cycle():
    steady = drill_of_two_discs(W=4.0)
    with pytest.raises(ns.InvalidInput, match="the motion goes on steadily, so there is no cycle"):
        ns.limit_cycle(steady, ([0.0, 0.0], [4.0, 4.0]), duration=60.0)
