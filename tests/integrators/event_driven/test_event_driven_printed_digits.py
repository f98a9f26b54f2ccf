"""Motions of the rod and of sprag-slip: figures printed in SYSTEMS D (T1 to T4), G and the rigid columns of H.

Each is met to its last digit: half a unit of it for rounding, a tenth of a unit for the integration.
"""

import dataclasses
import math

import numpy as np
import pytest

import nonsmooth as ns
from models import PainleveRod, SpragSlip

FINE = ns.EventDriven(rtol=1e-11, atol=1e-13)


def rounded(printed):
    """A figure as it is printed, and half a unit of its last digit."""
    return pytest.approx(float(printed), rel=0.0, abs=0.6 * 10.0 ** -len(printed.split(".")[1]))


# section D: the unilateral rod


@pytest.mark.parametrize(
    "mu, th, thdot, slip, printed, end, slips",
    [
        (0.3, 50, 0.0, -0.4, [], 0.361904031, []),  # T1: it slides left throughout
        (0.3, 50, 0.0, 0.8, ["0.112538799", "0.200072319"], 0.330648443, [-1, 1]),  # T2: two reversals, no stick
        (1.0, 75, -0.5, -0.5, ["0.007552851", "0.587985263"], 0.721927014, [0, 1]),  # T4: slide, stick, slide
    ],
)
def test_rod_changes_its_modes_at_the_printed_times(mu, th, thdot, slip, printed, end, slips):
    """And has fallen to 2 degrees at the printed end."""
    rod = PainleveRod(mu=mu)
    sol = ns.simulate(rod, (0.0, end), *rod.state(th=math.radians(th), thdot=thdot, slip=slip), integrator=FINE)
    assert [event.t for event in sol.events] == [rounded(t) for t in printed]
    assert [event.slip_after for event in sol.events] == slips and sol.slip[0, 0] == np.sign(slip)
    assert abs(sol.q[-1, 2] - math.radians(2)) < 0.6e-9 * abs(sol.u[-1, 2])


def test_rod_lifts_off_where_its_normal_force_fades():
    """T3."""
    rod = PainleveRod(mu=0.3)
    sol = ns.simulate(rod, (0.0, 0.1), *rod.state(th=math.radians(20), thdot=6.0, slip=-1.0), integrator=FINE)
    (event,) = sol.events
    assert event.mode_after == ns.ContactMode.OPEN and event.t == rounded("0.042777016")
    q, u = sol(event.t)
    assert (q[2], u[2], u[0]) == (rounded("0.602423510"), rounded("5.884309335"), rounded("-2.018621486"))


@pytest.mark.parametrize("law, thdot", [("newton", "1.29903811"), ("energetic", "1.107565727")])
def test_impact_without_collision_turns_the_rod_as_printed(law, thdot):
    """Section D: mu = 2, 60 degrees at rest, slip -1 m/s; without restitution, and with all of the energetic one."""
    rod = PainleveRod(mu=2.0, e=0.0 if law == "newton" else 1.0)
    system = dataclasses.replace(rod.system(), contacts=[ns.Contact(mu="mu", e_N="e", impact=law)])
    start = rod.state(th=math.pi / 3, thdot=0.0, slip=-1.0)
    sol = ns.simulate(system, (0.0, 1e-3), *start, integrator=FINE)
    assert sol(0.0).u[2] == rounded(thdot)
    if law == "newton":
        assert sol.paradoxes[0].P_N == rounded("0.32475953") and sol.paradoxes[0].P_F == rounded("0.4375")


# section G: sprag-slip, rigid contact


@pytest.mark.parametrize("t, th, thdot", [(0.1, "0.84797101", "0.70989253"), (1.0, "0.81310806", "-0.15110466")])
def test_strongly_damped_sprag_slip_falls_back_to_its_equilibrium_as_printed(t, th, thdot):
    """Section G, set 1 with cth = 5, from 0.05 rad below the equilibrium at rest."""
    rod = SpragSlip.set_1(cth=5.0)
    start = rod.state(th=rod.equilibrium() - 0.05, thdot=0.0)
    sol = ns.simulate(rod, (0.0, t), *start, integrator=FINE)
    assert (sol.q[-1, 1], sol.u[-1, 1]) == (rounded(th), rounded(thdot))


@pytest.fixture(scope="module")
def cycle():
    """A period of the limit cycle of set 1 from its greatest angle: (run, start of the period [s])."""
    rod = SpragSlip.set_1(cth=0.5)
    sol = ns.simulate(rod, (0.0, 8.0), *rod.state(th=0.8, thdot=0.0), integrator=FINE, events=[lambda t, q, u: u[1]])
    greatest = sol.t_events[0][sol.q_events[0][:, 1] > 0.85]
    assert greatest[-1] - greatest[-2] == rounded("0.377442788")
    return sol, greatest[-2]


def test_normal_force_of_the_limit_cycle_changes_its_sign_where_printed(cycle):
    """Located as events, so that a record lies where the force is zero; two where the event rounds the velocities."""
    sol, start = cycle
    period = (sol.t > start) & (sol.t < start + 0.377442788)
    t, th, la_N = sol.t[period] - start, sol.q[period, 1], sol.la[period, 0, 0]
    zeros = (np.abs(la_N) < 1e-9) & (np.diff(t, prepend=0.0) > 0.0)
    assert t[zeros].tolist() == [rounded("0.108644837"), rounded("0.279364694")]
    assert th[zeros].tolist() == [rounded("0.820830335"), rounded("0.830592534")]
    assert (la_N.min(), la_N.max()) == (rounded("-6.5777"), rounded("116.97"))


def test_limit_cycle_begins_to_stick_and_slides_on_where_printed(cycle):
    sol, start = cycle
    begins, ends = [event.t for event in sol.events if event.t > start][:2]
    assert (begins - start, ends - begins) == (rounded("0.259262266"), rounded("0.016087590"))
    assert (sol(begins).q[1], sol(ends).q[1]) == (rounded("0.803037060"), rounded("0.825162958"))


def test_limit_cycle_has_the_printed_extremes(cycle):
    sol, start = cycle
    turns = sol.q_events[0][sol.t_events[0] >= start - 1e-9, 1]
    assert (turns.max(), turns.min()) == (rounded("0.899886645"), rounded("0.7532243"))
    between = sol(np.linspace(start, start + 0.377442788, 20001)).u[:, 1]
    thdot = np.append(between, sol.u[sol.t > start, 1])  # the greatest is where sticking begins
    assert (thdot.min(), thdot.max()) == (rounded("-1.338581"), rounded("1.389914"))


# section H: the rigid limit


def test_seizure_orbit_has_the_printed_jump():
    """Section H, set 2: the rigid limit's attracting orbit."""
    rod = SpragSlip()
    sol = ns.simulate(rod, (0.0, 8.0), *rod.state(th=0.8, thdot=0.0), integrator=FINE)
    first, second = [p for p in sol.paradoxes if p.kind == ns.EventKind.INCONSISTENT][-2:]
    assert second.t - first.t == rounded("0.460134276")
    assert (second.P_N, second.P_F) == (rounded("34.772865558"), rounded("38.865743710"))
    before, after = sol(second.t, side="left"), sol(second.t)
    assert (before.q[1], before.u[1], after.u[1]) == (
        rounded("0.807078634"), rounded("-2.258755703"), rounded("2.769048317"),
    )  # fmt: skip
    release = next(event.t for event in sol.events if event.t > first.t and event.mode_before == ns.ContactMode.STICK)
    assert (release - first.t, sol(release).q[1]) == (rounded("0.061700499"), rounded("0.966466904"))
    q, u = sol(np.linspace(first.t, second.t, 20001))
    assert (q[:, 1].max(), u[:, 1].min()) == (rounded("1.215713"), rounded("-2.275685"))


def test_seizure_from_rest_of_the_force_has_the_printed_impulse():
    """Section H, from (0.78, 1) in A3: in all 13.107965209 N s."""
    rod = SpragSlip()
    sol = ns.simulate(rod, (0.0, 1e-3), *rod.state(th=0.78, thdot=1.0), integrator=FINE)
    assert sol.paradoxes[0].P_N == rounded("13.107965209") and sol(0.0).u[1] == rounded("2.843819889")


@pytest.mark.parametrize("start, th, thdot", [
    ((0.60, 0.0), "1.186249428", "-1.143968348"), ((0.85, 0.0), "1.156378253", "-1.522946610"),
    ((0.90, 2.0), "0.819553913", "2.736571747"), ((0.80, 3.5), "0.949267286", "-2.249010944"),
    ((1.00, 4.0), "0.847841624", "2.667185293"), ((0.78, 1.0), "0.965195612", "-2.235129844"),
    ((0.73, 3.3), "1.002287299", "-2.187982995"),
])  # fmt: skip
def test_sprag_slip_is_after_two_fifths_of_a_second_where_the_rigid_limit_is_printed(start, th, thdot):
    rod = SpragSlip()
    sol = ns.simulate(rod, (0.0, 0.4), *rod.state(*start), integrator=FINE)
    assert (sol.q[-1, 1], sol.u[-1, 1]) == (rounded(th), rounded(thdot))
