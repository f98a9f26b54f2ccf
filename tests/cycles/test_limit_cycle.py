"""Cycles through stick, slip and changes of the normal force's sign: printed values, invariants, refusals."""

from __future__ import annotations

import functools

import numpy as np
import pytest

import nonsmooth as ns
from models import BeltOscillator, BouncingBall, FollowerForceArm, ModeCoupling, SpragSlip
from nonsmooth.cycles.cycle_branch import lagrange_weights
from nonsmooth.cycles.mode_flow import ContactState
from nonsmooth.cycles.phase import PhaseGuess
from nonsmooth.cycles.shooting import Shooting, ending
from nonsmooth.mechanics.system import ContactMode
from nonsmooth.studies.cycle import describe

SLIDE, STICK, OPEN = ContactMode.SLIDE, ContactMode.STICK, ContactMode.OPEN
LENGTH = 0.1  # N/k of the belt [m]

# Printed: corrected tables of the textbook chapter, mass on a conveyor. Period, stick duration [s], half peak to peak,
# y max, y min [m], y' min [m/s], y where stick begins and ends [m]; y = x - x of steady sliding.
STICK_SLIP = {
    0.05: (2.042809386, 0.303681193, 0.018770409, 0.017189662, -0.020351156, -0.059318283, -0.013441560, 0.0017425),
    0.10: (2.037780395, 0.292866358, 0.037176962, 0.034336553, -0.040017371, -0.117505656, -0.025846636, 0.0034400),
    0.20: (2.020348258, 0.250147633, 0.071634355, 0.068330977, -0.074937734, -0.226506509, -0.043509527, 0.0065200),
    0.30: (1.999912298, 0.176927619, 0.101503869, 0.101641330, -0.101366407, -0.320936464, -0.044198286, 0.0088800),
    0.35: (1.992112980, 0.121269023, 0.114445695, 0.117933223, -0.110958167, -0.361702872, -0.032766658, 0.0096775),
    0.39: (1.989427764, 0.038706254, 0.123824814, 0.130753458, -0.116896169, -0.391108761, -0.005004579, 0.0100909),
}
PURE_SLIP = {0.40: (0.1176282, 1.9893366), 0.42: (0.0850607, 1.9882990), 0.44: (0.0183799, 1.9869879)}
SMOOTHED = {  # half peak to peak of x in units of N/k
    20.0: {0.20: 0.369972, 0.25: 0.592365, 0.30: 0.753587, 0.35: 0.857276, 0.40: 0.828973, 0.44: 0.078413},
    200.0: {0.05: 0.128988, 0.10: 0.322441, 0.20: 0.675981, 0.25: 0.835153, 0.30: 0.981028, 0.35: 1.113017,
            0.40: 1.173479, 0.44: 0.183799},
}  # fmt: skip


@functools.cache
def cycle_of(belt):
    start = belt.state(x=belt.equilibrium() + belt.vb / 4, velocity=0.0)
    return ns.limit_cycle(belt, start, duration=60.0)


@pytest.mark.upkeep
@pytest.mark.parametrize("vb", STICK_SLIP)
def test_stick_slip_cycles_of_the_belt_are_the_printed_ones(vb):
    belt = BeltOscillator(vb=vb)
    cycle = cycle_of(belt)
    period, stick, half, high, low, slowest, begin, end = STICK_SLIP[vb]
    assert (cycle.period, cycle.stick_duration) == pytest.approx((period, stick), abs=6e-10)
    rest = belt.equilibrium()
    found = (cycle.amplitudes[0], cycle.extremes[1][0] - rest, cycle.extremes[0][0] - rest, cycle.extremes[0][1])
    assert found == pytest.approx((half, high, low, slowest), abs=6e-10)
    slips, sticks = sorted(cycle.phases, key=lambda phase: phase.sticks)
    assert sticks.q[0] - rest == pytest.approx(begin, abs=6e-10)
    assert slips.q[0] - rest == pytest.approx(end, abs=6e-8)
    assert slips.q[0] == pytest.approx(belt.release_position(), rel=1e-9)
    assert cycle.is_stable and np.abs(cycle.multipliers).max() < 1e-12  # stick forgets where it came from
    assert cycle.time_shift < 1e-6 and cycle.residual < 1e-10


@pytest.mark.parametrize("vb", PURE_SLIP)
def test_cycles_without_stick_are_the_printed_ones_and_near_the_averaged(vb):
    belt = BeltOscillator(vb=vb)
    near = ns.simulate(belt, (0.0, 400.0), *belt.state(x=belt.equilibrium() + PURE_SLIP[vb][0]),
                       integrator=ns.MoreauJean(dt=1e-3))  # fmt: skip
    cycle = ns.limit_cycle(belt, near)
    assert cycle.amplitudes[0] == pytest.approx(PURE_SLIP[vb][0], abs=6e-8)
    assert cycle.period == pytest.approx(PURE_SLIP[vb][1], abs=6e-8)
    assert len(cycle.phases) == 1 and cycle.is_stable
    # averaging is of the first order in c~ and k_1, here 0.03 and less; measured 2e-3 and less
    assert cycle.amplitudes[0] == pytest.approx(ns.averaged_amplitude(belt).amplitude, rel=5e-3)


@pytest.mark.parametrize("vb", [0.40, 0.42])
def test_multiplier_of_a_weak_cycle_is_the_averaged_rate_of_return(vb):
    belt = BeltOscillator(vb=vb)
    near = ns.simulate(belt, (0.0, 400.0), *belt.state(x=belt.equilibrium() + PURE_SLIP[vb][0]),
                       integrator=ns.MoreauJean(dt=1e-3))  # fmt: skip
    cycle, motion = ns.limit_cycle(belt, near), ns.averaged_amplitude(belt)
    a, h = motion.amplitude, 1e-6
    slope = (motion.rate(a + h) - motion.rate(a - h)) / (2 * h)
    assert cycle.multipliers[0].real == pytest.approx(np.exp(slope * cycle.period), abs=5e-3)


@pytest.mark.parametrize("r, vb", [(r, vb) for r, table in SMOOTHED.items() for vb in table if vb < 0.44])
def test_cycles_of_the_smoothed_law_have_the_printed_amplitudes(r, vb):
    cycle = cycle_of(BeltOscillator(law="smoothed", r=r, vb=vb))
    assert cycle.amplitudes[0] / LENGTH == pytest.approx(SMOOTHED[r][vb], abs=6e-7)
    assert cycle.is_stable and cycle.stick_duration == 0


@pytest.mark.parametrize("r", SMOOTHED)
def test_weak_cycle_of_the_smoothed_law_has_the_printed_amplitude(r):
    """Just below the end of its range the cycle attracts by 0.1 % a period: it is started at the averaged amplitude."""
    cycle = near(0.44, law="smoothed", r=r)
    assert cycle.amplitudes[0] / LENGTH == pytest.approx(SMOOTHED[r][0.44], abs=6e-7)
    assert cycle.is_stable and len(cycle.phases) == 1


def test_smoothed_friction_below_its_unstable_range_brings_the_mass_to_rest():
    belt = BeltOscillator(law="smoothed", r=20.0, vb=0.1)
    with pytest.raises(ns.InvalidInput, match="come to rest"):
        ns.limit_cycle(belt, duration=60.0)


@pytest.fixture(scope="module")
def coupled():
    return ns.limit_cycle(ModeCoupling(mu=0.6), duration=60.0, dt=5e-4)


def test_mode_coupling_has_the_printed_cycle(coupled):
    assert (coupled.period, coupled.stick_duration) == pytest.approx((0.416823626, 0.088711270), abs=6e-10)
    rest = np.concatenate([ModeCoupling(mu=0.6).equilibrium(), np.zeros(2)])
    low, high = (x - rest for x in coupled.extremes)
    np.testing.assert_allclose(low, [-1.014243, -1.527588, -13.291654, -22.428607], atol=6e-7)
    np.testing.assert_allclose(high, [0.655763, 1.460413, 10.0, 22.594766], atol=6e-7)
    (slips,) = [phase for phase in coupled.phases if not phase.sticks]
    end_of_stick = np.concatenate([slips.q, slips.u]) - rest
    np.testing.assert_allclose(end_of_stick, [0.090339759, -0.383585197, 10.0, 21.995303625], atol=6e-9)


def test_mode_coupling_returns_with_the_printed_multipliers_and_a_zero_for_the_stick(coupled):
    np.testing.assert_allclose(coupled.multipliers, [0.8756, -0.4306, 0.0], atol=6e-5)
    assert coupled.is_stable and coupled.time_shift < 1e-6


def test_cycle_of_mode_coupling_scales_with_the_belts_speed_and_does_not_depend_on_the_load(coupled):
    faster = ns.limit_cycle(ModeCoupling(mu=0.6, vb=11.0), duration=60.0, dt=5e-4)
    assert faster.period == pytest.approx(coupled.period, rel=1e-10)
    np.testing.assert_allclose(faster.amplitudes, 1.1 * coupled.amplitudes, rtol=1e-10)
    heavy = ns.limit_cycle(ModeCoupling(mu=0.6, R=1500.0), duration=60.0, dt=5e-4)
    assert heavy.period == pytest.approx(coupled.period, rel=1e-10)


def test_load_below_which_the_mass_lifts_off_is_the_printed_one(coupled):
    model = ModeCoupling(mu=0.6)
    highest = coupled.extremes[1][1] - model.equilibrium()[1]
    assert model.lift_off_load(highest) == pytest.approx(399.1795, abs=6e-5)


@pytest.mark.upkeep
def test_branch_ends_where_the_contact_is_lost_and_says_so(coupled):
    branch = ns.continue_cycle(ModeCoupling(mu=0.6), "R", [1000.0, 420.0, 400.0, 390.0], coupled)
    assert branch.values.tolist() == [1000.0, 420.0, 400.0]
    np.testing.assert_allclose(branch.periods, coupled.period, rtol=1e-7)
    assert branch.changes[-1].kind == "end" and "normal force" in branch.changes[-1].message


@pytest.mark.upkeep
def test_cycle_that_loses_its_contact_is_refused():
    with pytest.raises(ns.InvalidInput, match="normal force"):
        ns.limit_cycle(ModeCoupling(mu=0.6, R=380.0), duration=30.0, dt=5e-4)


@pytest.fixture(scope="module")
def sprag():
    rod = SpragSlip.set_1(cth=0.5)
    return ns.limit_cycle(rod, rod.state(th=0.78, thdot=0.0), duration=6.0, dt=1e-4)


def test_sprag_slip_has_the_printed_cycle_phase_by_phase(sprag):
    assert sprag.period == pytest.approx(0.377442788, abs=6e-10)
    (low, high) = sprag.extremes
    assert (high[1], low[1]) == pytest.approx((0.899886645, 0.7532243), abs=6e-8)
    assert (low[3], high[3]) == pytest.approx((-1.338581, 1.389914), abs=6e-7)
    phases = {(p.states[0].mode, p.states[0].normal, round(p.q[1], 3)): p for p in sprag.phases}
    assert [p.states[0].mode for p in sprag.phases].count(STICK) == 1
    by_kind = [(SLIDE, 1, 0.821), (STICK, 1, 0.803), (SLIDE, 1, 0.825), (SLIDE, -1, 0.831)]
    angles = [phases[key].q[1] for key in by_kind]
    assert angles == pytest.approx([0.820830335, 0.803037060, 0.825162958, 0.830592534], abs=6e-10)
    durations = [phases[key].duration for key in by_kind[:3]]
    printed = [0.259262266 - 0.108644837, 0.016087590, 0.279364694 - 0.259262266 - 0.016087590]
    assert durations == pytest.approx(printed, abs=2e-9)  # differences of printed times
    assert sprag.stick_duration == pytest.approx(0.016087590, abs=6e-10)


def test_cycle_read_from_an_event_driven_motion_is_the_same(sprag):
    rod = SpragSlip.set_1(cth=0.5)
    run = ns.simulate(rod, (0.0, 4.0), *rod.state(th=0.78, thdot=0.0), integrator=ns.EventDriven(rtol=1e-7))
    again = ns.limit_cycle(rod, run)
    assert again.period == pytest.approx(sprag.period, abs=1e-11)
    assert len(again.phases) == len(sprag.phases) == 4


def test_sprag_slip_returns_to_one_cycle_and_keeps_its_constraint(sprag):
    assert (
        sprag.is_stable and not sprag.is_marginal and sprag.multipliers.size == 1 and abs(sprag.multipliers[0]) < 1e-6
    )
    rod = SpragSlip.set_1(cth=0.5)
    np.testing.assert_allclose(sprag.q[:, 0], rod.l * np.sin(sprag.q[:, 1]), atol=1e-9)


def test_sprag_slip_cycle_visits_states_with_two_solutions(sprag):
    low, high = SpragSlip.set_1().paradoxical_angles()
    assert low < sprag.extremes[1][1] < high


def test_cycle_of_another_speed_starts_from_a_near_one_and_refuses_where_stick_is_lost():
    cycle = cycle_of(BeltOscillator(vb=0.39))
    assert ns.limit_cycle(BeltOscillator(vb=0.394), cycle).stick_duration > 0.01
    with pytest.raises(ns.InvalidInput, match="does not close"):
        ns.limit_cycle(BeltOscillator(vb=0.40), cycle)


@pytest.mark.upkeep
def test_branch_ends_its_stick_where_the_cycle_grazes_from_both_sides():
    speeds = np.array([0.39, 0.398])
    up = ns.continue_cycle(BeltOscillator(), "vb", speeds, cycle_of(BeltOscillator(vb=0.39)))
    down = ns.continue_cycle(BeltOscillator(), "vb", speeds[::-1], up.cycles[-1])
    assert [change.kind for change in up.changes] == ["stick ends"]
    assert [change.kind for change in down.changes] == ["stick begins"]
    assert up.changes[0].value == pytest.approx(down.changes[0].value, abs=1e-11)
    graze = up.changes[0].value
    touching = ns.limit_cycle(BeltOscillator(vb=graze + 1e-9), up.cycles[-1])
    assert touching.extremes[1][1] == pytest.approx(graze, abs=2e-8)  # the slope of the margin is about 5
    cycle, sticks = up.cycles[0], []
    for below in (4e-4, 1e-4, 4e-5, 1e-5):
        cycle = ns.limit_cycle(BeltOscillator(vb=graze - below), cycle)
        sticks.append(cycle.stick_duration)
    assert sticks[2] / sticks[3] == pytest.approx(2.0, rel=0.02)  # stick begins as the square root of the distance


def test_branch_agrees_with_single_cycles_and_tells_where_no_cycle_is_left():
    branch = ns.continue_cycle(BeltOscillator(), "vb", [0.41, 0.42, 0.43, 0.44, 0.45], near(0.41))
    assert branch.values.tolist() == [0.41, 0.42, 0.43, 0.44]
    assert branch.changes[-1].kind == "end"
    assert branch.periods[1] == pytest.approx(PURE_SLIP[0.42][1], abs=6e-8)
    assert branch.amplitudes[3, 0] == pytest.approx(PURE_SLIP[0.44][0], abs=6e-8)
    assert branch.stick_durations.max() == 0


def test_cycle_is_predicted_exactly_where_it_moves_as_a_cubic():
    points = np.array([0.3, 0.1, 0.25, 0.0])
    weights = lagrange_weights(points, 0.37)
    for power in range(4):
        assert weights @ points**power == pytest.approx(0.37**power, rel=1e-12)
    assert lagrange_weights(points[:1], 0.37).tolist() == [1.0]


def test_branch_may_visit_a_value_twice_and_turn_back():
    branch = ns.continue_cycle(BeltOscillator(), "vb", [0.2, 0.2, 0.21, 0.21, 0.2], cycle_of(BeltOscillator(vb=0.2)))
    assert not branch.changes
    np.testing.assert_allclose(branch.periods[[0, 1, 4]], STICK_SLIP[0.20][0], atol=2e-9)


def near(vb, **law):
    belt = BeltOscillator(vb=vb, **law)
    a = ns.averaged_amplitude(belt).amplitude
    run = ns.simulate(belt, (0.0, 200.0), *belt.state(x=belt.equilibrium() + a), integrator=ns.MoreauJean(dt=1e-3))
    return ns.limit_cycle(belt, run)


def contact(mode, slip=0, normal=1):
    return (ContactState(mode, slip, normal),)


@pytest.mark.parametrize("before, after, margin", [
    (contact(SLIDE, -1), contact(STICK), (0, "slip")),
    (contact(SLIDE, -1), contact(SLIDE, 1), (0, "slip")),
    (contact(STICK), contact(SLIDE, 1), (0, "friction +")),
    (contact(STICK), contact(SLIDE, -1), (0, "friction -")),
    (contact(SLIDE, -1, 1), contact(SLIDE, -1, -1), (0, "normal")),
])  # fmt: skip
def test_a_phase_ends_where_the_right_margin_vanishes(before, after, margin):
    assert ending(before, after) == margin


@pytest.mark.parametrize("before, after, message", [
    (contact(OPEN), contact(SLIDE, 1), "opens or closes"),
    (contact(STICK) * 2, contact(SLIDE, 1) * 2, "at once"),
])  # fmt: skip
def test_an_impact_or_two_changes_at_once_are_refused(before, after, message):
    with pytest.raises(ns.InvalidInput, match=message):
        ending(before, after)


def test_periodic_motions_of_the_undamped_arm_form_a_family_and_are_not_called_stable():
    motion = ns.limit_cycle(FollowerForceArm(P=500.0))
    assert np.abs(motion.multipliers - 1).min() < 1e-2  # a second multiplier 1, to the root of the accuracy
    assert not motion.is_stable and motion.is_marginal and motion.residual < 1e-9
    assert "marginal" in describe(motion)
    fast = 2 * np.pi / 54.716541708  # of a mode of small vibration: the period is near it
    assert motion.period == pytest.approx(fast, rel=1e-3)


@pytest.mark.parametrize("law, vb, c", [("two-coefficient", 0.288, 0.103), ("stribeck", 0.3694, 0.135)])
def test_a_motion_that_dies_out_slowly_is_said_to(law, vb, c):
    belt = BeltOscillator(law=law, vb=vb, c=c)
    assert (ns.linearise(belt, ns.equilibrium(belt)).eigenvalues.real < 0).all()
    with pytest.raises(ns.InvalidInput, match="dies out|come to rest"):
        ns.limit_cycle(belt)


def test_newtons_iteration_does_not_run_away_to_endless_periods():
    """A guess on a spiral into the equilibrium of a belt that is too fast: no cycle solves the equations."""
    belt = BeltOscillator(law="stribeck", vb=0.3694, c=0.135)
    start = np.concatenate(belt.state(x=belt.equilibrium() + 0.05))
    problem = Shooting(belt.system(), [PhaseGuess(contact(SLIDE, -1), start, 2.0)])
    with pytest.raises(ns.InvalidInput, match="does not close|state of rest"):
        problem.solve()
    assert problem.T.sum() <= 2 * 10 * 2.0  # the last step at most doubles a period that was below ten times the guess


@pytest.mark.parametrize("guess", ["x", 1.0, ([0.0],)])
def test_a_guess_that_is_no_start_is_refused(guess):
    with pytest.raises(ns.InvalidInput, match=r"guess must be a pair \(q0, u0\)"):
        ns.limit_cycle(BeltOscillator(), guess)


def test_a_cycle_of_another_kind_of_system_and_a_branch_without_values_are_refused():
    with pytest.raises(ns.InvalidInput, match="with 2 coordinates and 1 contacts; got one with 1 and 1"):
        ns.limit_cycle(ModeCoupling(), cycle_of(BeltOscillator(vb=0.2)))
    with pytest.raises(ns.InvalidInput, match="at least one"):
        ns.continue_cycle(BeltOscillator(), "vb", [])


def test_a_ball_that_comes_to_rest_has_no_cycle():
    with pytest.raises(ns.InvalidInput, match="come to rest"):
        ns.limit_cycle(BouncingBall(), duration=5.0)
