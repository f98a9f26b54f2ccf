"""Event-driven integration with several contacts, with bilateral ones, and through paradoxes.

References: closed forms, printed figures, and Moreau–Jean, whose error is of first order in dt. "Printed" as in
test_event_driven.py: half a unit of the last digit, and as much for the accumulated error.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

import nonsmooth as ns
from models import (
    BeadChain,
    BilateralRod,
    InclinedBlock,
    ModeCoupling,
    PainleveRod,
    RockingBlock,
    SelfLockingRod,
    SpragSlip,
)
from models.rod_geometry import FUNCTIONS

FINE = ns.EventDriven(rtol=1e-11, atol=1e-13)
INCONSISTENT = ns.EventKind.INCONSISTENT


def run(model, t_end, state, integrator=FINE, **options):
    sol = ns.simulate(model, (0, t_end), *state, integrator=integrator, **options)
    assert sol.success
    return sol


# several contacts


@pytest.mark.parametrize("n, e, t", [(2, 0.9, 3.0), (5, 0.9, 3.0), (12, 0.8, 0.2), (8, 1.0, 1.0)])
def test_beads_pass_their_impacts_on(n, e, t):
    chain = BeadChain(n=n, e=e)
    sol = run(chain, t, chain.state(velocity=1.0))
    q, u = chain.exact(t, velocity=1.0)
    assert np.abs(sol.q[-1] - q).max() < 1e-12 and np.abs(sol.u[-1] - u).max() < 1e-12


@pytest.mark.filterwarnings("ignore::nonsmooth.SimultaneousImpactWarning")  # what is asked holds for it too
def test_beads_that_collapse_inelastically_move_on_together():
    """e = 0.5: infinitely many impacts in a finite time. The momentum that is lost went to the wall."""
    chain = BeadChain(n=12, e=0.5)
    sol = run(chain, 2.0, chain.state(velocity=1.0))
    before = sol.t < 0.05
    assert before.any() and (sol.P_N[before, -1] == 0.0).all()
    assert np.abs(chain.m * sol.u.sum(axis=1) - 1.0 + np.cumsum(sol.P_N[:, -1])).max() < 1e-13
    assert sol.g_N.min() > -1e-13 and np.ptp(sol.u[-1]) < 1e-12


@pytest.mark.filterwarnings("ignore::nonsmooth.SimultaneousImpactWarning")  # what is asked holds for it too
@pytest.mark.parametrize("balls, after", [(3, [-1 / 3, 2 / 3, 2 / 3]), (4, [-1 / 2, 1 / 2, 1 / 2, 1 / 2])])
def test_balls_that_touch_are_struck_at_once(balls, after):
    """NUMERICS section 7: simultaneous impacts under Newton's law with e = 1."""
    chain = BeadChain(n=balls, e=1.0, gap=1.0)
    together = replace(chain.system(), contacts=[ns.Contact(e_N=1.0)] * balls)  # of its own they are struck in turn
    _, u0 = chain.state(velocity=1.0)
    sol = run(together, 0.1, (-chain.gap * np.arange(balls), u0))
    assert np.abs(sol.u[-1] - after).max() < 1e-14


@pytest.mark.parametrize("mu, e, tilt, push", [
    (0.5, 0.4, 0.2, (0.5, 0.3, -1.0)), (0.3, 0.0, -0.3, (1.0, 0.0, 2.0)),
])  # fmt: skip
@pytest.mark.filterwarnings("ignore::nonsmooth.SimultaneousImpactWarning")  # what is asked holds for it too
def test_tumbling_block_moves_as_moreau_jean_in_the_limit(mu, e, tilt, push):
    """The distance falls by ten with dt, down from 5 velocities times 2e-4 s."""
    block = RockingBlock(width=0.5, height=0.5, mu=mu, e=e)
    q0, u0 = block.state(tilt=tilt)
    start = q0 + [0.0, 0.1, 0.0], u0 + np.array(push)
    sol = run(block, 1.0, start, ns.EventDriven(rtol=1e-9, atol=1e-11))
    coarse = run(block, 1.0, start, ns.MoreauJean(dt=2e-4))
    fine = run(block, 1.0, start, ns.MoreauJean(dt=2e-5))
    apart = [np.abs(sol.q[-1] - other.q[-1]).max() for other in (coarse, fine)]
    assert apart[0] < 5 * 3.0 * 2e-4 and apart[1] < 5 * 3.0 * 2e-5


def test_block_on_both_corners_rests_for_ever():
    block = RockingBlock()
    sol = run(block, 10.0, block.state(tilt=0.0))
    assert np.abs(sol.u).max() == 0.0 and sol.events == []
    assert np.abs(sol.la[-1, :, 0] - 0.5 * block.m * block.g).max() < 1e-12 * block.g  # the load is shared


def test_interpreted_loop_agrees_bit_for_bit_with_two_contacts(monkeypatch):
    block = RockingBlock(width=0.5, height=0.5, mu=0.5, e=0.4)
    q0, u0 = block.state(tilt=0.2)
    coarse = ns.EventDriven(rtol=1e-4, atol=1e-5)
    compiled = run(block, 0.3, (q0, u0), coarse)
    monkeypatch.setenv("NONSMOOTH_INTERPRET", "1")
    twin = run(block, 0.3, (q0, u0), coarse)
    assert (twin.t == compiled.t).all() and (twin.q == compiled.q).all()
    assert len(twin.events) == len(compiled.events) > 2


# bilateral contacts: SYSTEMS section E


@pytest.mark.parametrize("mu, th, thdot", [
    (1.549807886758189, 0.45682152, -0.98834987), (1.518707393289783, 0.50688406, 3.97546778),
    (1.5353742926722211, 0.6921072, -1.74209912),
])  # fmt: skip
def test_rod_leaves_a_seizure_as_its_stiff_contact_does(mu, th, thdot):
    """Three solutions exist after these seizures. The stiff contact sticks in the first two; in the third the force
    that holds has the other sign than the impulse, and it slides. Its distance from the rigid limit is of the size
    ln(kappa)/kappa: it falls by 7 or more from kappa = 1e6 to 1e7, by 5 at least."""
    rod = SpragSlip(mu=mu)
    start = rod.state(th=th, thdot=thdot)
    sol = run(rod, 0.6, start, ns.EventDriven(1e-9, 1e-11))
    apart = [
        abs(run(rod, 0.6, start, ns.Penalty(stiffness=kappa, damping=kappa)).q[-1, 1] - sol.q[-1, 1])
        for kappa in (1e6, 1e7)
    ]
    assert apart[0] < 3e-4 and apart[1] < 0.2 * apart[0]
    coarse = run(rod, 0.6, start, ns.EventDriven(1e-5, 1e-7))
    assert abs(coarse.q[-1, 1] - sol.q[-1, 1]) < 1e-5


def test_bilateral_rod_changes_the_sign_of_its_force_and_reverses():
    """U1: N changes sign at 0.042777016 s and no mode changes; the slip reverses twice."""
    rod = BilateralRod(mu=0.3)
    sol = run(rod, 0.3, rod.state(th=math.radians(20), thdot=6.0, slip=-1.0))
    reversals = [e.t for e in sol.events]
    assert len(reversals) == 2 and np.abs(np.array(reversals) - [0.067382918, 0.275053724]).max() < 1e-9
    crossing = np.flatnonzero(np.diff(np.sign(sol.la[:, 0, 0])))[0]
    assert sol.t[crossing] - 1e-9 < 0.042777016 < sol.t[crossing + 1] + 1e-9


def test_bilateral_rod_reverses_and_sticks():
    rod = BilateralRod(mu=0.8)
    sol = run(rod, 0.22, rod.state(th=math.radians(40), thdot=7.0, slip=-0.3))
    assert np.abs(np.array([e.t for e in sol.events]) - [0.012095236, 0.061687512, 0.216340381]).max() < 1e-9
    assert [e.mode_after for e in sol.events] == [ns.ContactMode.SLIDE, ns.ContactMode.STICK, ns.ContactMode.SLIDE]


# a given normal force: SYSTEMS section C


def test_mode_coupling_repeats_the_printed_limit_cycle():
    mass = ModeCoupling(mu=0.6)
    start = mass.equilibrium() + [0.090339759, -0.383585197], np.array([10.0, 21.995303625])
    sol = run(mass, 8.5, start)
    sticks = np.array([e.t for e in sol.events if e.mode_after == ns.ContactMode.STICK])
    slips = np.array([e.t for e in sol.events if e.mode_before == ns.ContactMode.STICK and e.t > sticks[0]])
    assert np.abs(np.diff(sticks) - 0.416823626).max() < 2e-9  # the start is known to 1e-9
    assert np.abs(slips - sticks[: len(slips)] - 0.088711270).max() < 2e-9


# paradoxes


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8, 1e-10])
def test_rod_finds_the_genot_brogliato_point_at_every_tolerance(rtol):
    """NUMERICS section 1: mu = 2, phi_1 = 37.377368 degrees, phidot sqrt(s/g) = 1.283463.

    The slide ends where p is 1e-9 of G_NN; b p^-chi is constant on the way, so that the rate is near its limit only.
    """
    rod = PainleveRod(mu=2.0)
    sol = run(rod, 0.3, rod.state(th=math.radians(34), thdot=2.0, slip=-6.0), ns.EventDriven(rtol, 1e-2 * rtol))
    event = next(e for e in sol.paradoxes if e.kind == INCONSISTENT)
    k = np.searchsorted(sol.t, event.t)
    assert abs(math.degrees(sol.q[k, 2]) - 37.377368) < 1e-6
    assert abs(sol.u[k, 2] * math.sqrt(0.5 / rod.g) - 1.283463) < 3e-3
    th, u = sol.q[k, 2], sol.u[k + 1]
    tip = u[0] + 0.5 * rod.l * u[2] * math.sin(th), u[1] - 0.5 * rod.l * u[2] * math.cos(th)
    assert np.abs(tip).max() < 1e-14  # both velocities of the tip end at zero
    assert abs(event.t - 0.0203153845) < 10 * rtol + 1e-9
    assert np.abs(sol.q[-1] - [-0.71942599, 0.71102366, 2.64361064]).max() < 10 * rtol + 1e-8


@pytest.mark.parametrize("law", ["poisson", "energetic"])
@pytest.mark.parametrize("rtol", [1e-4, 1e-9])
def test_genot_brogliato_point_under_other_laws_of_impact(law, rtol):
    """With p = 0 nothing is compressed before the slide stops, at P_1: Poisson's law leaves gamma_N = e P_1 C_s with
    C_s = G_NN - G_NF^2/G_FF, the energetic one 0. p is below 1e-3 where the slide ends."""
    rod = PainleveRod(mu=2.0)
    contacts = [ns.Contact(mu="mu", e_N=0.5, impact=law)]
    system = ns.System(n_q=3, **FUNCTIONS, contacts=contacts, parameters=rod)
    start = rod.state(th=math.radians(34), thdot=2.0, slip=-6.0)
    sol = ns.simulate(system, (0, 0.03), *start, integrator=ns.EventDriven(rtol, 1e-2 * rtol))
    event = next(e for e in sol.paradoxes if e.kind == INCONSISTENT)
    k = np.searchsorted(sol.t, event.t)
    (G_NN, G_NF), (_, G_FF) = rod.delassus(sol.q[k, 2])
    P_1 = event.gamma_F / (G_NF + rod.mu * G_FF)
    C_s = G_NN - G_NF**2 / G_FF
    expected = 0.5 * abs(P_1) * C_s if law == "poisson" else 0.0
    th, u = sol.q[k, 2], sol.u[k + 1]
    gamma_N = u[1] - 0.5 * rod.l * u[2] * math.cos(th)
    assert abs(gamma_N - expected) < 2e-3 * abs(P_1) * C_s + 1e-12


@pytest.mark.parametrize("rtol", [1e-4, 1e-5, 1e-6, 1e-8, 1e-10])
def test_point_where_the_steps_vanish_is_the_same_point(rtol):
    """Found among random starts: coarse tolerances stop at p = 1e-5 already, and the impact is the same."""
    rod = PainleveRod(mu=1.5842920063731072, e=1.0)
    start = rod.state(th=0.5513768573407218, thdot=3.5967919140249034, slip=-2.753602)
    sol, fine = (run(rod, 0.3, start, ns.EventDriven(r, 1e-2 * r)) for r in (rtol, 1e-12))
    (event,) = sol.paradoxes
    assert event.kind == INCONSISTENT and np.abs(sol.q[-1] - fine.q[-1]).max() < 10 * rtol + 1e-8


def test_self_locking_rod_has_no_solution_beyond_its_jamming_angle():
    rod = SelfLockingRod(mu=1.0, th0=math.radians(50))
    sol = ns.simulate(rod, (0, 0.1), *rod.state(th=rod.th0), integrator=FINE, on_failure="return")
    assert sol.status == ns.Status.NO_SOLUTION and "no solution" in sol.message


def test_selection_makes_an_impact_of_an_indeterminate_start():
    rod = PainleveRod(mu=2.0)
    start = rod.state(th=math.pi / 3, thdot=6.0, slip=-1.0)
    exact = rod.impact_without_collision(th=math.pi / 3, thdot=6.0, slip=-1.0)
    lifts, strikes = run(rod, 1e-3, start), run(rod, 1e-3, start, selection="impact")
    assert lifts.mode[-1, 0] == ns.ContactMode.OPEN and lifts.paradoxes[0].P_N == 0.0
    (event,) = strikes.paradoxes
    assert event.n_solutions == 2 and abs(event.P_N - exact.P_N) < 1e-14
    assert np.abs(strikes.u[1] - exact.u).max() < 1e-14


def test_block_on_a_slope_below_the_friction_angle_stays_exactly():
    block = InclinedBlock()
    q0, u0 = block.state(slip=0.0)
    sol = run(block, 100.0, (q0, u0))
    assert (sol.q == sol.q[0]).all() and (sol.u == 0.0).all()


@pytest.mark.parametrize(("model", "state", "order"), [
    (BilateralRod(m=1.7, mu=1.78, g=15.4), {}, 1.5),
    (SpragSlip(mu=1.549807886758189), dict(th=0.45682152, thdot=-0.98834987), 0.8),
])  # fmt: skip
def test_time_stepping_takes_the_same_branch_from_an_indeterminate_state(model, state, order):
    """Small forces among several solutions: the gap that is fed back must not disturb them. Errors fall with dt."""
    q, u = model.state(**state)
    end = run(model, 0.3, (q, u)).q[-1]
    errors = []
    for dt in (1e-3, 1e-4, 1e-5):
        stepped = ns.simulate(model, (0, 0.3), q, u, integrator=ns.MoreauJean(dt=dt))
        errors.append(np.abs(stepped.q[-1] - end).max())
    assert errors[0] < 1e-3 and errors[2] < errors[0] / 10 ** (2 * order)
