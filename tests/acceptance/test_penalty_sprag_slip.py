"""The sprag-slip rod with a compliant contact: trajectories through every region, seizures, orbits, orders.

SYSTEMS H of the design papers; its numbers are copied here."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from models import SpragSlip
from nonsmooth import ContactMode

ROD = SpragSlip()

TRAJECTORIES = {  # start: (th, th') at 0.1 s and at 0.4 s, kappa = 1e6
    (0.60, 0.0): (0.724215917, 3.045806937, 1.186246473, -1.144009893),
    (0.85, 0.0): (0.819261066, -0.587997211, 1.156443135, -1.522310527),
    (0.90, 2.0): (1.063767760, 1.126580412, 0.819395022, 2.736977924),
    (0.80, 3.5): (1.050080702, 2.225075422, 0.949257312, -2.249010399),
    (1.00, 4.0): (1.189939012, 1.148632367, 0.847675162, 2.667577120),
    (0.78, 1.0): (1.034042028, 2.276691529, 0.965232398, -2.235085643),
    (0.73, 3.3): (0.995080241, 2.375991151, 1.002262544, -2.188013998),
}


def run(kappa, th, thdot, t_end, rod=ROD, force=0.0, rtol=1e-9, **options):
    """kc = cc = kappa; the contact starts with a force [N] in the spring."""
    q0, u0 = rod.state(th=th, thdot=thdot)
    q0[0] -= force / kappa
    integrator = ns.Penalty(stiffness=kappa, damping=kappa, rtol=rtol, atol=1e-2 * rtol)
    return ns.simulate(rod, (0, t_end), q0, u0, integrator=integrator, **options)


def stops(solution):
    """Times at which the slip ends [s]."""
    return [e.t for e in solution.events if e.mode_before == ContactMode.SLIDE and e.mode_after == ContactMode.STICK]


@pytest.mark.parametrize("start", TRAJECTORIES)
def test_trajectory_from_each_region(start):
    solution = run(1e6, *start, 0.4, t_eval=[0.1, 0.4])
    found = np.column_stack((solution.q[:, 1], solution.u[:, 1])).ravel()
    assert np.abs(found - TRAJECTORIES[start]).max() < 1e-6


@pytest.mark.parametrize(
    ("start", "t", "th"),
    [((0.60, 0.0), 0.108096, None), ((0.85, 0.0), 0.108757, 0.813931), ((0.90, 2.0), 0.396689, 0.810294),
     ((0.80, 3.5), 1.76978e-5, 0.8000606), ((0.78, 1.0), 2.78669e-5, 0.7800324), ((0.73, 3.3), 0.003503, None)],
)  # fmt: skip
def test_time_and_place_of_the_seizure(start, t, th):
    solution = run(1e6, *start, t * 1.001 + 1e-5)
    moment = min(stops(solution), key=lambda found: abs(found - t))  # the tip may stop for a moment before
    digits = 6 if t > 1e-3 else 10
    assert abs(moment - t) < 1.01 * 10.0**-digits
    if th is not None:
        row = np.flatnonzero(solution.t == moment)[0]
        speed = abs(solution.u[row, 1])  # the time is printed to one unit of its last digit, and th changes with it
        assert abs(solution.q[row, 1] - th) < 1e-6 + speed * 10.0**-digits


@pytest.mark.parametrize(
    ("kappa", "t", "excess", "force"),
    [(1e4, 1.634599e-3, -5.93e-3, 2.9730e4), (1e5, 2.21393e-4, -7.66e-4, 2.9337e5),
     (1e6, 2.7867e-5, -9.32e-5, 2.92795e6), (1e7, 3.358e-6, -1.10e-5, 2.92719e7)],
)  # fmt: skip
def test_force_history_of_a_seizure(kappa, t, excess, force):
    solution = run(kappa, 0.78, 1.0, 1.2 * t)
    moment = stops(solution)[0]
    row = np.flatnonzero(solution.t == moment)[0]
    limit = 2.843819889
    assert abs(moment / t - 1) < 2e-4  # four to seven digits are printed
    assert abs((solution.u[row, 1] - limit) / excess - 1) < 1e-2
    assert abs(solution.la[row, 0, 0] / force - 1) < 1e-4


def test_impulse_of_a_seizure_tends_to_that_of_the_impact():
    """Up to the end of slip P = 7.253789216, in all 13.107965209 N s, within O(1/kappa)."""
    assert abs(ROD.seizure(0.78, 1.0).P_N - 13.107965209) < 1e-8
    to_stick, total = [], []
    for kappa in (1e5, 1e6, 1e7):
        solution = run(kappa, 0.78, 1.0, 200.0 / kappa)
        row = np.flatnonzero(solution.t == stops(solution)[0])[0]
        P = np.cumsum(solution.P_N[:, 0])
        to_stick.append(abs(P[row] - 7.253789216))
        total.append(abs(P[-1] - 13.107965209))
    assert (np.array(to_stick[1:]) < 0.2 * np.array(to_stick[:-1])).all()
    assert (np.array(total[1:]) < 0.2 * np.array(total[:-1])).all()


@pytest.mark.parametrize(
    ("start", "root"), [((0.85, 0.0), 38.80895774), ((0.90, 2.0), 90.89698531), ((0.73, 3.3), -169.1341771)]
)
def test_branch_taken_by_the_initial_force(start, root):
    """Below Lambda/M+ the branch with M- is followed, beyond it the contact seizes."""
    for share, seizes in ((-1.0, False), (0.0, False), (0.5, False), (0.9, False), (1.1, True), (2.0, True)):
        solution = run(1e6, *start, 1e-3, force=share * root)
        assert bool(stops(solution)) == seizes


def test_threshold_force_at_finite_stiffness():
    low, high = 38.0, 40.0
    while high - low > 1e-8:
        force = 0.5 * (low + high)
        low, high = (low, force) if stops(run(1e6, 0.85, 0.0, 2e-4, force=force, rtol=1e-11)) else (force, high)
    assert abs(high - 38.809198788) < 1e-6


def mean_period(rod, kappa, first, last):
    solution = run(kappa, 0.8, 0.0, last, rod=rod, every=10_000)
    ends = np.array([e.t for e in solution.events if e.mode_before == ContactMode.STICK and e.t > first])
    ends = ends[np.concatenate(([True], np.diff(ends) > 0.1))]
    return (ends[-1] - ends[0]) / (len(ends) - 1)


@pytest.mark.parametrize(
    ("rod", "rigid", "periods"),
    [(ROD, 0.46013428, {1e6: 0.46019980, 1e7: 0.46014229}),
     (SpragSlip.set_1(cth=0.5), 0.377442788, {1e6: 0.377464055, 1e7: 0.377444916})],
    ids=["seizure orbit", "limit cycle"],
)  # fmt: skip
def test_period_of_the_attracting_orbit(rod, rigid, periods):
    """The contact creeps with rate kc/cc = 1 1/s, and the period with it by some 1e-7 s: 1e-6 s can be asked."""
    found = {kappa: mean_period(rod, kappa, 4.0, 7.0) for kappa in periods}
    for kappa, period in periods.items():
        assert abs(found[kappa] - period) < 1e-6
    assert abs((found[1e6] - rigid) / (found[1e7] - rigid) / 10 - 1) < 0.3  # O(ln kappa/kappa) to O(1/kappa)


def test_seizure_orbit_at_the_default_tolerance_nears_the_rigid_one_with_the_stiffness():
    """Period minus the rigid one's: (a + b ln kappa)/kappa from 1e6 to 1e9, then what an event's time is known to.
    A normal velocity within 1e-8 of the others' would be a force of 0.5 N through the damper at 1e10, and ends and
    begins sticking at the wrong time: 3e-5 s then."""
    rigid, kappas = 0.460134276, np.logspace(6, 10, 5)
    q0, u0 = ROD.state(th=0.8, thdot=0.0)
    errors = []
    for kappa in kappas:
        run = ns.simulate(ROD, (0, 7), q0, u0, integrator=ns.Penalty(kappa, damping=kappa), every=10_000)
        ends = np.array([e.t for e in run.events if e.mode_before == ContactMode.STICK and e.t > 4.0])
        ends = ends[np.concatenate(([True], np.diff(ends) > 0.1))]
        errors.append(abs((ends[-1] - ends[0]) / (len(ends) - 1) - rigid))
    decades = np.diff(np.array(errors[:4]) * kappas[:4])  # b ln 10 each
    assert np.allclose(decades, decades[0], rtol=0.02, atol=2e-9 * kappas[3])  # the period to 2e-9 s
    assert errors[4] < 5e-8 and (np.diff(errors) < 0).all()


def test_smooth_branch_is_of_first_order_with_its_constant():
    """(0.85, 0), t = 0.05 s: th' differs from its limit by 0.799/kappa."""
    kappas = (1e5, 1e6)
    thdot = [run(kappa, 0.85, 0.0, 0.05, rtol=1e-11).u[-1, 1] for kappa in kappas]
    difference = (thdot[0] - thdot[1]) / (1 / kappas[0] - 1 / kappas[1])
    assert abs(abs(difference) - 0.799) < 1e-3


def test_damping_like_the_square_root_of_the_stiffness_has_the_same_limit_with_half_the_order():
    limit_errors = []
    limit = run(1e9, 0.78, 1.0, 0.05).q[-1, 1]
    for k in (1e8, 1e10):
        integrator = ns.Penalty(stiffness=k, damping_ratio=0.5, mass=ROD.m, rtol=1e-9)
        solution = ns.simulate(ROD, (0, 0.05), *ROD.state(th=0.78, thdot=1.0), integrator=integrator)
        limit_errors.append(solution.q[-1, 1] - limit)
    assert np.allclose(limit_errors, [-1.15e-3, -1.53e-4], rtol=0.01)


def test_tip_that_sticks_moves_with_the_belt():
    solution = run(1e6, 0.78, 1.0, 0.05)
    stuck = solution.mode[:, 0] == ContactMode.STICK
    gamma_F = ROD.l * np.sin(solution.q[stuck, 1]) * solution.u[stuck, 1] - ROD.vb
    assert stuck.sum() > 10
    assert np.abs(gamma_F).max() < 1e-7 * ROD.vb  # the drift of an acceleration held at zero, some hundred steps
    assert math.isclose(solution.u[stuck, 1][-1], ROD.stick_rate(solution.q[stuck, 1][-1]), rel_tol=1e-7)
