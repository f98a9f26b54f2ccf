"""Smooth phases: they run backwards as they ran forwards, and keep what mechanics keeps.

An error is one of the tolerance times the size of the quantity, times ten for its growth over the run.
"""

import math

import numpy as np
import pytest

import nonsmooth as ns
from models import BeadChain, BouncingBall, FollowerForceArm, ModeCoupling, PainleveRod, SpragSlip, WallPendulum

RTOL = 1e-9
FINE = ns.EventDriven(RTOL, 1e-2 * RTOL)
PENDULUM = WallPendulum(th_w=-1.5)  # the wall is out of reach
ARM = FollowerForceArm(P=0.0)  # torsion springs alone
# frictionless, dampers away: forces that depend on the position only
SMOOTH = {
    "pendulum": (PENDULUM, PENDULUM.state(th=1.0), 5.0),
    "arm": (ARM, (ARM.equilibrium() + [0.05, 0.0], np.zeros(2)), 1.0),
    "sliding rod": (PainleveRod(mu=0.0), PainleveRod(mu=0.0).state(th=math.radians(50), thdot=1.0, slip=0.5), 0.07),
    "held rod": (SpragSlip(mu=0.0, cth=0.0, cy=0.0), SpragSlip(mu=0.0).state(th=0.8, thdot=1.0), 1.0),
    "flying rod": (
        PainleveRod(mu=0.3), (np.array([0.0, 2.0, 0.3]), np.array([1.0, 2.0, 5.0])), 0.4,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", SMOOTH)
@pytest.mark.parametrize("rtol", [1e-6, 1e-9])
def test_smooth_phase_runs_back_to_its_start(name, rtol):
    model, (q0, u0), t_end = SMOOTH[name]
    integrator = ns.EventDriven(rtol, 1e-2 * rtol)
    there = ns.simulate(model, (0, t_end), q0, u0, integrator=integrator)
    back = ns.simulate(model, (0, t_end), there.q[-1], -there.u[-1], integrator=integrator)
    assert not there.events and not back.events
    size = max(1.0, np.abs(there.q).max(), np.abs(there.u).max())
    assert np.abs(back.q[-1] - q0).max() < 10 * rtol * size and np.abs(back.u[-1] + u0).max() < 10 * rtol * size
    t = np.linspace(0, t_end, 101)  # and so does the motion between the steps
    assert np.abs(there(t).q - back(t_end - t).q).max() < 10 * rtol * size


@pytest.mark.parametrize("name", sorted(SMOOTH.keys() - {"arm"}))
def test_energy_of_a_smooth_phase_is_the_work_of_its_forces(name):
    """A constraint does no work. (The ledger is exact for a constant mass matrix, which the arm does not have.)"""
    model, (q0, u0), t_end = SMOOTH[name]
    sol = ns.simulate(model, (0, t_end), q0, u0, integrator=FINE)
    ledger = sol.ledger
    size = np.abs(ledger["kinetic"]).max()
    assert np.abs(ledger["kinetic"] - ledger["kinetic"][0] - ledger["force"]).max() < 10 * RTOL * size
    assert np.abs(ledger["normal"]).max() < 10 * RTOL * size and not ledger["friction"].any()
    if "potential" in ledger:
        total = ledger["kinetic"] + ledger["potential"]
        assert np.ptp(total) < 10 * RTOL * size


def test_energy_of_the_arm_and_its_springs_is_kept_between_the_steps():
    """SYSTEMS section B without the follower force: springs k1 at the base and k2, free at th0, at the elbow."""
    arm, (q0, u0), t_end = SMOOTH["arm"]
    sol = ns.simulate(arm, (0, t_end), q0, u0, integrator=FINE)
    q, u = sol(np.linspace(0, t_end, 2001))
    bend = q[:, 1] - q[:, 0]
    kinetic = 0.5 * arm.l**2 * ((arm.m1 + arm.m2) * u[:, 0] ** 2 + arm.m2 * u[:, 1] ** 2)
    kinetic += arm.m2 * arm.l**2 * np.cos(bend) * u[:, 0] * u[:, 1]
    springs = 0.5 * arm.k1 * q[:, 0] ** 2 + 0.5 * arm.k2 * (bend - arm.th0) ** 2
    assert np.ptp(kinetic + springs) < 10 * RTOL * kinetic.max()


def test_energy_of_the_pendulum_is_kept_between_the_steps():
    sol = ns.simulate(PENDULUM, (0, 5), *PENDULUM.state(th=1.0), integrator=FINE)
    q, u = sol(np.linspace(0, 5, 2001))
    inertia = PENDULUM.m * PENDULUM.l**2
    energy = 0.5 * inertia * u[:, 0] ** 2 - PENDULUM.m * PENDULUM.g * PENDULUM.l * np.cos(q[:, 0])
    assert np.ptp(energy) < 10 * RTOL * PENDULUM.m * PENDULUM.g * PENDULUM.l


def test_flying_rod_keeps_its_spin_and_falls_as_its_centre():
    rod, (q0, u0), t_end = SMOOTH["flying rod"]
    sol = ns.simulate(rod, (0, t_end), q0, u0, integrator=FINE)
    t = np.linspace(0, t_end, 101)
    q, u = sol(t)
    assert np.abs(u[:, 2] - u0[2]).max() < 1e-14 and np.abs(u[:, 0] - u0[0]).max() < 1e-14
    assert np.abs(q[:, 1] - (2.0 + 2.0 * t - 0.5 * rod.g * t**2)).max() < 1e-14


def test_momentum_of_a_chain_changes_by_the_impulse_of_its_wall_alone():
    chain = BeadChain(n=6, e=0.7)
    sol = ns.simulate(chain, (0, 2), *chain.state(velocity=1.0), integrator=FINE)
    momentum = chain.m * sol.u.sum(axis=1)
    assert np.abs(momentum - momentum[0] + np.cumsum(sol.P_N[:, -1])).max() < 1e-13


def test_angular_momentum_about_the_tip_is_that_of_the_weight():
    """Sliding without friction: no horizontal force, so the centre of the rod keeps its horizontal velocity."""
    rod, (q0, u0), t_end = SMOOTH["sliding rod"]
    sol = ns.simulate(rod, (0, t_end), q0, u0, integrator=FINE)
    assert np.abs(sol(np.linspace(0, t_end, 101)).u[:, 0] - u0[0]).max() < 1e-13


@pytest.mark.parametrize("e", [0.5, 0.8, 0.9])
@pytest.mark.parametrize("rtol", [1e-5, 1e-11])
def test_ball_is_exactly_at_rest_after_its_last_bounce_at_every_tolerance(e, rtol):
    ball = BouncingBall(e=e)
    sol = ns.simulate(ball, (0, 10), *ball.state(height=1.0), integrator=ns.EventDriven(rtol, 1e-2 * rtol))
    t_inf = ball.t_inf(height=1.0)
    assert abs(sol.events[-1].t - t_inf) < 1e-9
    q, u = sol(np.linspace(t_inf * (1 + 1e-12), 10.0, 301))
    assert (q == 0.0).all() and (u == 0.0).all() and sol.mode[-1, 0] != ns.ContactMode.OPEN


def test_mode_coupling_reaches_the_printed_extremes():
    """Section C, mu = 0.6: y1 from -1.014243 to 0.655763, y1' from -13.291654 to 10."""
    mass = ModeCoupling(mu=0.6)
    start = mass.equilibrium() + [0.090339759, -0.383585197], np.array([10.0, 21.995303625])
    sol = ns.simulate(mass, (0, 2), *start, integrator=FINE)
    q, u = sol(np.linspace(1.0, 1.5, 20001))
    y = q[:, 0] - mass.equilibrium()[0]
    assert abs(y.min() + 1.014243) < 2e-6 and abs(y.max() - 0.655763) < 2e-6
    assert abs(u[:, 0].min() + 13.291654) < 2e-5 and abs(u[:, 0].max() - 10.0) < 1e-9
