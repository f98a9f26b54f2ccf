"""The compliant rod: impacts without collision, the branch of indeterminate states, regular contact. SYSTEMS D and
NUMERICS 2, 3 of the design papers; their numbers are copied here, closed forms come from the model."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from models import PainleveRod
from nonsmooth import ContactMode

TH = math.pi / 3
ROD = PainleveRod(mu=2.0)  # p = -0.848 at 60 degrees: b < 0 inconsistent, b > 0 indeterminate
WINDOW = 20.0  # length of an impact without collision in units of ln(k)/sqrt(k)


def run(rod, k, thdot=0.0, depth=0.0, approach=0.0, rtol=1e-10, **damping):
    """From rest in the normal direction, but for `approach` [m/s] and `depth` [m], until after the impact."""
    q0, u0 = rod.state(th=TH, thdot=thdot, slip=-1.0)
    q0[1] -= depth
    u0[1] -= approach
    t_end = WINDOW * math.log10(k) / math.sqrt(k)
    return ns.simulate(
        rod, (0, t_end), q0, u0, integrator=ns.Penalty(stiffness=k, rtol=rtol, atol=1e-2 * rtol, **damping)
    )


def velocity_after_impact(rod, k, **damping):
    """gamma_N where the contact opens for the first time."""
    return next(e.gamma_N for e in run(rod, k, **damping).events if e.mode_after == ContactMode.OPEN)


def test_impact_without_collision_tends_to_the_energetic_law_as_slowly_as_expected():
    limit = ROD.impact_without_collision(th=TH, e=1.0, law="energetic").gamma_N
    assert abs(limit - 0.255296505) < 1e-9
    errors = [velocity_after_impact(ROD, k) - limit for k in (1e6, 1e8, 1e10, 1e12)]
    assert np.allclose(errors, [0.0438, 0.00788, 0.00117, 0.000155], rtol=0, atol=[5e-5, 5e-6, 5e-6, 5e-7])
    order = -np.diff(np.log10(errors)) / 2  # a decade of k
    assert (np.diff(order) > 0).all() and 0.32 < order[0] and order[-1] < 0.5


@pytest.mark.parametrize("zeta", [0.0, 0.1, 0.5, 1.0])
def test_damped_impact_without_collision_tends_to_its_closed_form(zeta):
    limit = ROD.compliant_limit(th=TH, zeta=zeta)
    assert abs(limit.gamma_N - {0.0: 0.255296505, 0.1: 0.200882468, 0.5: 0.091258409, 1.0: 0.043548397}[zeta]) < 1e-9
    at_k = [abs(velocity_after_impact(ROD, k, damping_ratio=zeta, mass=ROD.m) - limit.gamma_N) for k in (1e10, 1e12)]
    assert at_k[1] < 2e-4
    assert 5 < at_k[0] / at_k[1] < 10  # k^-1/2 ln k over two decades: 10 ln(1e10)/ln(1e12) = 8.3


@pytest.mark.parametrize(
    ("zeta", "e"), [(0.05, 0.8889), (0.1, 0.7945), (0.2, 0.6439), (0.5, 0.3739), (1.0, 0.1838), (2.0, 0.0678)]
)
def test_damping_sets_an_effective_energetic_restitution(zeta, e):
    rod = PainleveRod(m=1.0, l=2.0, I=1 / 3, mu=1.8)
    elastic = rod.impact_without_collision(th=TH, e=1.0, law="energetic").gamma_N
    at_k = velocity_after_impact(rod, 1e12, damping_ratio=zeta, mass=1.0) / elastic
    assert abs(at_k - e) < 1e-3  # k^-1/2 ln k = 2.8e-5 times a constant of the order of 30, and four printed digits


def first_force_that_seizes(k):
    """N0/N* between lift-off and an impact without collision, by bisection."""
    force = 6.813606125
    low, high = 1.0, 1.2
    while high - low > 1e-7:
        ratio = 0.5 * (low + high)
        modes = {e.mode_after for e in run(ROD, k, thdot=6.0, depth=ratio * force / k).events}
        low, high = (low, ratio) if ContactMode.STICK in modes else (ratio, high)
    return high


@pytest.mark.parametrize(("k", "expected", "digits"), [(1e6, 1.0708, 4), (1e8, 1.0063, 4), (1e10, 1.00062, 5)])
def test_indeterminate_state_seizes_beyond_the_saddle_and_lifts_off_below(k, expected, digits):
    assert ROD.normal_forces(th=TH, thdot=6.0, slip=-1.0)[1] == pytest.approx(6.813606125, abs=1e-9)
    assert round(first_force_that_seizes(k), digits) == expected


def test_contact_released_at_rest_lifts_off_and_an_approaching_one_seizes():
    k = 1e10
    assert ContactMode.STICK not in {e.mode_after for e in run(ROD, k, thdot=6.0).events}
    assert ContactMode.STICK in {e.mode_after for e in run(ROD, k, thdot=6.0, approach=1e-3).events}


@pytest.mark.parametrize("zeta", [0.0, 0.3])
def test_separating_velocity_of_an_indeterminate_state(zeta):
    """From zero gap: impact iff gamma_N < v_c = -s z*, z* = b/(p k), s the negative root of s^2 + p c s + p k = 0."""
    k = 1e12
    c = 2 * zeta * math.sqrt(k * ROD.m)
    p, b = ROD.coefficients(TH, 6.0, -1.0)
    root = (-p * c - math.sqrt((p * c) ** 2 - 4 * p * k)) / 2
    expected = -root * b / (p * k)
    low, high = 0.5 * abs(expected), 2 * abs(expected)
    while high - low > 1e-6 * low:
        middle = 0.5 * (low + high)
        solution = run(ROD, k, thdot=6.0, approach=middle, damping_ratio=zeta, mass=ROD.m)
        is_impact = ContactMode.STICK in {e.mode_after for e in solution.events}
        low, high = (low, middle) if is_impact else (middle, high)
    assert expected < 0
    assert abs(high / abs(expected) - 1) < 1e-4


@pytest.mark.parametrize(
    ("mu", "th", "thdot", "slip", "t_end", "changes"),
    [
        (1.0, 75, -0.5, -0.5, 0.721927014, [0.007552851, 0.587985263]),  # slip, stick, slip
        (0.3, 50, 0.0, -0.4, 0.361904031, []),  # slip throughout
    ],
)
def test_regular_motion_is_that_of_the_rigid_rod_up_to_1_over_k(mu, th, thdot, slip, t_end, changes):
    rod = PainleveRod(mu=mu)
    q0, u0 = rod.state(th=math.radians(th), thdot=thdot, slip=slip)
    errors = []
    for k in (1e6, 1e7, 1e8):
        solution = ns.simulate(
            rod, (0, t_end), q0, u0, integrator=ns.Penalty(stiffness=k, damping_ratio=1.0, rtol=1e-9)
        )
        found = [e.t for e in solution.events if e.mode_before in (ContactMode.STICK, ContactMode.SLIDE)]
        if changes:
            assert np.abs(np.array(found)[: len(changes)] - changes).max() < 1000 / k
        errors.append(abs(solution.q[-1, 2] - math.radians(2)))
    order = -np.polyfit([6, 7, 8], np.log10(errors), 1)[0]
    assert 0.85 < order < 1.15


def test_reversal_at_which_the_normal_force_jumps_costs_half_an_order():
    """The rigid force jumps, the compliant one follows within k^-1/2; meanwhile the friction is wrong."""
    rod = PainleveRod(mu=0.3)
    q0, u0 = rod.state(th=math.radians(50), thdot=0.0, slip=0.8)
    errors, delays = [], []
    for k in (1e6, 1e7, 1e8, 1e9):
        solution = ns.simulate(
            rod, (0, 0.330648443), q0, u0, integrator=ns.Penalty(stiffness=k, damping_ratio=1.0, rtol=1e-9, atol=1e-12)
        )
        reversals = [e.t for e in solution.events if e.mode_before == ContactMode.SLIDE]
        assert np.abs(np.array(reversals) - [0.112538799, 0.200072319]).max() < 1000 / k
        delays.append(solution.events[-1].t - reversals[-1])  # it sticks until the force has arrived
        errors.append(abs(solution.q[-1, 2] - math.radians(2)))
    assert abs(np.polyfit([6, 7, 8, 9], np.log10(delays), 1)[0] + 0.5) < 0.05
    assert abs(np.polyfit([6, 7, 8, 9], np.log10(errors), 1)[0] + 0.5) < 0.1


def test_lift_off_of_the_rigid_rod_is_met_up_to_1_over_k():
    rod = PainleveRod(mu=0.3)
    q0, u0 = rod.state(th=math.radians(20), thdot=6.0, slip=-1.0)
    exact = np.array([0.042777016, 0.602423510, 5.884309335, -2.018621486])
    errors = []
    for k in (1e6, 1e8):
        solution = ns.simulate(rod, (0, 0.1), q0, u0, integrator=ns.Penalty(stiffness=k, damping_ratio=1.0, rtol=1e-10))
        opening = [e.t for e in solution.events if e.mode_after == ContactMode.OPEN][-1]
        row = np.flatnonzero(solution.t == opening)[0]
        found = [opening, solution.q[row, 2], solution.u[row, 2], solution.u[row, 0]]
        errors.append(np.abs(found - exact).max())
    assert errors[1] < 0.02 * errors[0] + 1e-8
