"""Friction laws in a run, and contacts of several kinds in one system."""

import math
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns
from models import BeltOscillator
from tests.systems import block


class Block(NamedTuple):
    m: float = 1.0  # mass [kg]
    g: float = 9.81  # gravity [m/s^2]
    F: float = 0.0  # horizontal load [N]
    vb: float = 0.0  # speed of the floor [m/s]
    rise: float = 0.0  # speed at which the floor rises [m/s]


def force(t, q, u, p, h):
    h[0] = p.F
    h[1] = -p.m * p.g


def gap(t, q, p, g_N):
    g_N[0] = q[1] - p.rise * t


def gap_rate(t, q, p, w_N):
    w_N[0] = -p.rise


def surface_velocity(t, q, p, w_F):
    w_F[0, 0] = -p.vb


def run(law, t_end=1.0, dt=1e-3, u0=(0.0, 0.0), **parameters):
    functions = {"force": force, "gap": gap, "gap_rate": gap_rate, "surface_velocity": surface_velocity}
    system = block(ns.Contact(mu=law), Block(**parameters), **functions)
    return ns.simulate(system, (0, t_end), [0.0, 0.0], u0, integrator=ns.MoreauJean(dt=dt))


@pytest.mark.parametrize(("load", "moves"), [(0.45, False), (0.55, True)])
def test_static_coefficient_holds_and_kinetic_one_brakes(load, moves):
    solution = run(ns.StaticKinetic(mu_s=0.5, mu_k=0.3), F=load * 9.81)
    assert (solution.q[-1, 0] > 0) == moves
    if moves:  # from rest at t = 0 with the kinetic coefficient
        assert np.isclose(solution.u[-1, 0], (load - 0.3) * 9.81, rtol=5e-3)


def test_block_carried_by_a_moving_floor_reaches_its_speed_and_stays():
    solution = run(0.3, vb=0.5)
    assert np.isclose(solution.u[-1, 0], 0.5, rtol=1e-13)
    assert np.isclose(solution.q[-1, 0], 0.5 * 1.0 - 0.5**2 / (2 * 0.3 * 9.81), atol=1e-5)


def test_rising_floor_lifts_the_block():
    solution = run(0.3, rise=0.2, u0=(0.0, 0.2))
    assert np.isclose(solution.q[-1, 1], 0.2, atol=1e-12)


def test_stribeck_friction_follows_its_own_equation_of_motion():
    from scipy.integrate import solve_ivp

    law = ns.Stribeck(mu_s=0.5, mu_k=0.2, v_s=0.3, m_v=0.05)

    def mu(v):
        return 0.2 + 0.3 * math.exp(-v / 0.3) + 0.05 * v

    exact = solve_ivp(lambda t, v: [-9.81 * mu(v[0])], (0, 0.5), [2.0], rtol=1e-11, atol=1e-12).y[0, -1]
    errors = [abs(run(law, 0.5, dt, (2.0, 0.0)).u[-1, 0] - exact) for dt in (1e-2, 5e-3)]
    assert 3.5 < errors[0] / errors[1] < 4.5  # second order with mu at the mid-point


def test_polynomial_friction_follows_its_own_equation_of_motion():
    from scipy.integrate import solve_ivp

    law = ns.Polynomial(m0=0.4, m1=0.1, m3=0.02)  # falling, then rising above 1.3 m/s

    def rate(t, v):
        return [-9.81 * (0.4 - 0.1 * v[0] + 0.02 * v[0] ** 3)]

    exact = solve_ivp(rate, (0, 0.4), [2.5], rtol=1e-11, atol=1e-12).y[0, -1]
    errors = [abs(run(law, 0.4, dt, (2.5, 0.0)).u[-1, 0] - exact) for dt in (1e-2, 5e-3)]
    assert 3.5 < errors[0] / errors[1] < 4.5


@pytest.mark.parametrize("load", [0.35, 0.45])
def test_polynomial_friction_holds_up_to_its_value_at_rest(load):
    solution = run(ns.Polynomial(m0=0.4, m1=0.1), F=load * 9.81)
    assert (solution.q[-1, 0] > 0) == (load > 0.4)


def test_stribeck_friction_holds_up_to_its_static_value_and_then_weakens():
    law = ns.Stribeck(mu_s=0.5, mu_k=0.2, v_s=0.1)
    assert run(law, F=0.49 * 9.81).q[-1, 0] == 0.0
    assert run(law, F=0.51 * 9.81).u[-1, 0] > (0.51 - 0.5) * 9.81  # faster than under the static coefficient


def test_friction_without_coefficient_is_none():
    solution = run(0.0, u0=(1.0, 0.0))
    assert (solution.u[:, 0] == 1.0).all() and set(solution.mode[1:, 0]) == {ns.ContactMode.LOCKED}


@pytest.mark.parametrize("e_F", [0.0, 0.5, 1.0])
def test_tangential_restitution_returns_the_sliding_velocity_of_an_impact_that_sticks(e_F):
    contact = ns.Contact(mu=10.0, e_N=0.5, e_F=e_F)
    system = block(contact, Block(), force=force)
    solution = ns.simulate(system, (0, 0.11), [0.0, 0.1], [0.3, -1.0], integrator=ns.MoreauJean(dt=1e-3))
    (impact,) = [event for event in solution.events if event.kind == ns.EventKind.IMPACT]
    after = solution.u[np.searchsorted(solution.t, impact.t + 1.5e-3)]
    assert np.allclose(after, [-e_F * 0.3, -0.5 * impact.gamma_N], atol=2 * 9.81e-3)  # gravity of two steps


def test_smoothed_friction_never_sticks_and_agrees_with_a_stiff_integrator():
    from scipy.integrate import solve_ivp

    belt = BeltOscillator(vb=0.2)
    system = belt.system()
    law = ns.Smoothed(m0=0.4, r=20.0, m1=0.45, m3=0.6)
    smooth = ns.System(
        n_q=1, mass=system.mass, force=system.force, tangent=system.tangent, normal_force=system.normal_force,
        surface_velocity=system.surface_velocity, contacts=[ns.Contact(mu=law, normal_force=True)], parameters=belt,
    )  # fmt: skip

    def f(v):
        return math.copysign(0.4 * (1 - math.exp(-20 * abs(v))), v) - 0.45 * v + 0.6 * v**3

    def rate(t, y):
        return [y[1], (-10 * y[0] - 0.1 * y[1] + f(0.2 - y[1])) / 1.0]

    exact = solve_ivp(rate, (0, 5), [0, 0], method="Radau", rtol=1e-10, atol=1e-12).y[:, -1]
    solution = ns.simulate(smooth, (0, 5), [0.0], [0.0], integrator=ns.MoreauJean(dt=1e-3))
    assert np.allclose([solution.q[-1, 0], solution.u[-1, 0]], exact, atol=2e-5)
    assert not (solution.mode == ns.ContactMode.STICK).any()


@pytest.mark.parametrize("law", [
    ns.Smoothed(m0=0.3, r=200.0), ns.Smoothed(m0=0.3, r=2e4, m1=0.1), ns.Friction(lambda v: 0.3 * math.tanh(50 * v)),
], ids=["smoothed", "steep", "own"])  # fmt: skip
def test_a_block_that_creeps_back_and_forth_on_two_feet_moves_as_on_one(law):
    """The loads of its feet add up to its weight, so that friction that vanishes with the speed is that of one contact
    with all of it. A step is solved to 1e-9 of g dt, 1e-11 m/s; 1500 of them in line are 1.5e-8 m/s."""

    def push(t, q, u, p, h):
        h[0] = p.F * math.sin(9.0 * t)
        h[1] = -p.m * p.g

    def masses(t, q, p, M):
        M[0, 0] = p.m
        M[1, 1] = p.m
        M[2, 2] = 0.1

    def feet(t, q, p, g_N):
        g_N[0] = q[1] - 0.3 * math.sin(q[2])
        g_N[1] = q[1] + 0.3 * math.sin(q[2])

    def normals(t, q, p, W_N):
        W_N[0, 1] = 1.0
        W_N[0, 2] = -0.3 * math.cos(q[2])
        W_N[1, 1] = 1.0
        W_N[1, 2] = 0.3 * math.cos(q[2])

    def tangents(t, q, p, W_F):
        for i in range(2):
            W_F[i, 0, 0] = 1.0
            W_F[i, 0, 2] = 0.1

    load, step = Block(m=2.0, F=4.0), ns.MoreauJean(dt=1e-3)
    on_one = ns.simulate(block(ns.Contact(mu=law), load, force=push), (0, 1.5), [0, 0], [0.3, 0], integrator=step)
    on_two = ns.simulate(
        ns.System(n_q=3, mass=masses, force=push, gap=feet, normal=normals, tangent=tangents,
                  contacts=[ns.Contact(mu=law)] * 2, parameters=load),
        (0, 1.5), [0, 0, 0], [0.3, 0, 0], integrator=step,
    )  # fmt: skip
    assert (np.diff(np.sign(on_one.u[1:, 0])) != 0).sum() >= 3  # it turns back
    assert np.allclose(on_two.u[:, 0], on_one.u[:, 0], rtol=0, atol=1.5e-8)
    assert np.abs(on_two.P_N.sum(axis=1) - on_one.P_N[:, 0])[1:].max() < 1e-9


def test_contacts_of_different_kinds_stand_in_one_system():
    """Block 1 slides on a floor, block 2 is held by a bilateral contact, block 3 is braked by a given force."""

    def masses(t, q, p, M):
        for i in range(4):
            M[i, i] = p.m

    def forces(t, q, u, p, h):
        h[1] = -p.m * p.g
        h[2] = p.F

    def gaps(t, q, p, g_N):
        g_N[0] = q[1]
        g_N[1] = q[2]

    def normals(t, q, p, W_N):
        W_N[0, 1] = 1.0
        W_N[1, 2] = 1.0

    def tangents(t, q, p, W_F):
        W_F[0, 0, 0] = 1.0
        W_F[2, 0, 3] = 1.0

    def pressing(t, q, u, p, N):
        N[2] = 2.0

    contacts = [ns.Contact(mu=0.3), ns.Contact(bilateral=True), ns.Contact(mu=0.5, normal_force=True)]
    system = ns.System(
        n_q=4, mass=masses, force=forces, gap=gaps, normal=normals, tangent=tangents, normal_force=pressing,
        contacts=contacts, parameters=Block(F=3.0),
    )  # fmt: skip
    solution = ns.simulate(system, (0, 0.5), np.zeros(4), [2.0, 0, 0, 1.0], integrator=ns.MoreauJean(dt=1e-3))
    assert np.allclose(solution.u[-1], [2 - 0.3 * 9.81 * 0.5, 0, 0, 0.5], atol=1e-12)
    assert np.allclose(solution.P_N[1:, 1], -3.0e-3, rtol=1e-12)
