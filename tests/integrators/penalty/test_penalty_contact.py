"""Compliant contact against closed forms: restitution of each law, depth at rest, sticking, creep, energy."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import nonsmooth as ns
from models import BeltOscillator, BouncingBall, InclinedBlock, PainleveRod, RockingBlock, SlidingBlock
from nonsmooth import ContactMode

G = 9.81
STIFF = 1e10
FALL = math.sqrt(2 * G)  # velocity after a fall of 1 m [m/s]
# gravity during the contact changes the velocity by about g pi/omega: relative to the fall,
LOADED = G * math.pi / math.sqrt(STIFF) / FALL


def run(model, t_end, state=None, stiffness=STIFF, **options):
    q0, u0 = model.state() if state is None else state
    chosen = {name: options.pop(name) for name in ("every", "t_eval") if name in options}
    return ns.simulate(model, (0.0, t_end), q0, u0, integrator=ns.Penalty(stiffness=stiffness, **options), **chosen)


def restitution(**law):
    ball = BouncingBall()
    solution = run(ball, 0.6, ball.state(height=1.0), **law)
    lift_off = next(e for e in solution.events if e.mode_after == ContactMode.OPEN)
    return lift_off.gamma_N / FALL


@pytest.mark.parametrize("zeta", [0.0, 0.1, 0.5, 0.9, 1.5])
def test_clipped_contact_bounces_with_the_restitution_of_its_damping_ratio(zeta):
    """Of d'' + 2 zeta d' + d = 0 until d + 2 zeta d' = 0: e = exp(-2 zeta arccos zeta/sqrt(1 - zeta^2))."""
    angle = math.acos(zeta) if zeta < 1 else math.acosh(zeta)
    expected = math.exp(-2 * zeta * angle / math.sqrt(abs(1 - zeta**2)))
    assert abs(restitution(damping_ratio=zeta) - expected) < 2 * LOADED


@pytest.mark.parametrize("zeta", [0.0, 0.1, 0.5])
def test_kelvin_voigt_contact_pulls_until_the_gap_opens(zeta):
    expected = math.exp(-math.pi * zeta / math.sqrt(1 - zeta**2))
    assert abs(restitution(damping_ratio=zeta, law="kelvin-voigt") - expected) < 2 * LOADED


@pytest.mark.parametrize("ratio", [0.0, 0.1, 0.5, 2.0])
def test_hunt_crossley_contact_keeps_its_energy_integral(ratio):
    """v dv/(1 + r v) = -k d^n dd/m, r = c/k: r v - ln(1 + r v) is the same at both ends of the contact."""
    integral = lambda v: v - math.log1p(ratio * v) / ratio
    if ratio == 0:
        expected = 1.0
    else:
        expected = brentq(lambda e: integral(-e * FALL) - integral(FALL), 0.0, min(1.0, (1 - 1e-12) / (ratio * FALL)))
    # the contact lasts about ten times as long as that of a spring
    assert abs(restitution(law="hunt-crossley", damping=ratio * STIFF) - expected) < 10 * LOADED


def test_ball_comes_to_rest_at_its_static_depth():
    k = 1e6
    solution = run(BouncingBall(), 3.0, stiffness=k, damping_ratio=0.7)
    assert abs(solution.g_N[-1, 0] + G / k) < 1e-6 * G / k
    assert abs(solution.la[-1, 0, 0] - G) < 1e-6 * G


def test_block_stops_where_its_kinetic_energy_is_spent_and_never_moves_again():
    block = SlidingBlock(mu=0.3)
    q0, u0 = block.state(speed=2.0)
    k = 1e8
    q0[-1] -= G / k  # the static depth: no vertical motion
    solution = run(block, 2.0, (q0, u0), stiffness=k, t_eval=np.linspace(0, 2, 201))
    distance = 2.0**2 / (2 * 0.3 * G)
    assert abs(solution.q[-1, 0] - distance) < 1e-7  # rtol 1e-8 of a metre, some ten steps
    stopped = solution.t > 2.0 / (0.3 * G)
    assert (solution.mode[stopped, 0] == ContactMode.STICK).all()
    assert np.ptp(solution.q[stopped, 0]) < 1e-15


@pytest.mark.parametrize(("share", "sticks"), [(0.999, True), (1.001, False)])
def test_block_holds_just_below_the_friction_limit_and_slides_just_above(share, sticks):
    block = InclinedBlock(mu=0.3, alpha=math.atan(0.3 * share))
    solution = run(block, 1.0, block.state(slip=0.0), stiffness=1e6, damping_ratio=1.0)
    assert (solution.mode[-1, 0] == ContactMode.STICK) == sticks


def test_regularised_friction_creeps_at_the_speed_at_which_it_carries_the_load():
    alpha, mu, v_s = 0.2, 0.3, 1e-3
    block = InclinedBlock(mu=mu, alpha=alpha)
    solution = run(block, 5.0, block.state(slip=0.0), stiffness=1e6, damping_ratio=1.0,
                   friction=ns.Regularised(v_s))  # fmt: skip
    creep = v_s * math.atanh(math.tan(alpha) / mu)
    assert abs(np.linalg.norm(solution.u[-1]) - creep) < 1e-6 * creep


def test_friction_with_a_given_normal_force_sticks_and_slips_like_the_exact_cycle():
    """The belt oscillator does not feel the stiffness: period of its stick-slip cycle at vb = 0.2."""
    belt = BeltOscillator(vb=0.2)
    solution = run(belt, 40.0, stiffness=1.0, rtol=1e-9)
    ends = [e.t for e in solution.events if e.mode_before == ContactMode.STICK]
    assert abs(ends[-1] - ends[-2] - 2.020348258) < 1e-8


def test_two_feet_share_the_weight_of_a_block_at_rest():
    block = RockingBlock()
    q0, u0 = block.state(tilt=0.0)
    solution = run(block, 2.0, (q0, u0), stiffness=1e7, damping_ratio=1.0)
    la_N = solution.la[-1, :, 0]
    assert abs(la_N.sum() - block.m * G) < 1e-6 * block.m * G
    assert abs(la_N[0] - la_N[1]) < 1e-6 * block.m * G


@pytest.mark.parametrize(
    ("mu", "tilt", "options"),
    [
        (0.2549, -0.00187, {"stiffness": 1.77e6, "law": "kelvin-voigt", "damping_ratio": 0.5}),
        (0.1303, 0.00923, {"stiffness": 4.63e6, "law": "hunt-crossley", "damping": 2.3e4}),
        (0.1517, 0.0829, {"stiffness": 5.1e4, "damping_ratio": 0.5}),
    ],
)
def test_rocking_on_two_feet_dies_out_in_steps_of_the_contact(mu, tilt, options):
    """The feet slip against each other by a part tilt^2 of their distance: thousands of steps, not millions."""
    block = RockingBlock(mu=mu)
    solution = run(block, 1.0, block.state(tilt=tilt), rtol=1e-7, **options)
    assert solution.stats.steps < 20_000  # a few dozen in each of the contact's periods that energy lasts for
    assert abs(solution.q[-1, 2]) < abs(tilt)


def test_work_of_the_contact_closes_the_energy_balance():
    """T - T_0 = works of forces and friction, plus that of the normal force: none of it is computed from the state."""
    rod = PainleveRod(mu=0.3)
    rtol = 1e-9
    solution = run(rod, 0.3, rod.state(th=0.87, thdot=0.0, slip=0.8), stiffness=1e8, damping_ratio=0.3, rtol=rtol)
    ledger = solution.ledger
    works = ledger["force"] + ledger["friction"] + ledger["normal"]
    error = np.abs(ledger["kinetic"] - ledger["kinetic"][0] - works).max()
    assert error < 1000 * rtol * np.abs(ledger["force"]).max()  # some thousand steps of relative error rtol


def test_gap_of_the_contact_stays_that_of_the_coordinates():
    rod = PainleveRod(mu=0.3)
    rtol = 1e-9
    solution = run(rod, 0.3, rod.state(th=0.87, thdot=0.0, slip=0.8), stiffness=1e8, damping_ratio=0.3, rtol=rtol)
    gaps = solution.q[:, 1] - 0.5 * rod.l * np.sin(solution.q[:, 2])
    assert np.abs(gaps - solution.g_N[:, 0]).max() < 100 * rtol * rod.l


def test_impulses_add_up_to_the_change_of_momentum():
    ball = BouncingBall()
    solution = run(ball, 1.0, ball.state(height=1.0), damping_ratio=0.2)
    change = solution.u[-1, 0] - solution.u[0, 0] + G * 1.0
    assert abs(solution.P_N.sum() - change) < 1e-6 * change


def test_times_asked_for_are_recorded_exactly_and_agree_with_the_steps():
    ball = BouncingBall()
    t = np.linspace(0.0, 1.0, 11)
    solution = run(ball, 1.0, ball.state(height=1.0), t_eval=t, damping_ratio=0.2)
    assert (solution.t == t).all()
    assert abs(solution.q[4, 0] - (1 - G * 0.4**2 / 2)) < 1e-12  # a parabola is a polynomial of the method's degree
    steps = run(ball, 1.0, ball.state(height=1.0), damping_ratio=0.2)
    assert abs(steps.q[-1, 0] - solution.q[-1, 0]) < 1e-8


def test_interpreter_and_machine_code_agree_bit_for_bit(monkeypatch):
    rod = PainleveRod(mu=2.0)
    compiled = run(rod, 0.004, rod.state(th=math.pi / 3, thdot=0.0, slip=-1.0), stiffness=1e6, damping_ratio=0.1)
    monkeypatch.setenv("NONSMOOTH_INTERPRET", "1")
    slow = run(rod, 0.004, rod.state(th=math.pi / 3, thdot=0.0, slip=-1.0), stiffness=1e6, damping_ratio=0.1)
    assert not slow.stats.is_compiled
    assert (slow.u == compiled.u).all() and (slow.t == compiled.t).all()
