"""Newton's law of impact with friction may gain energy; where it does, the run says so."""

import math
import warnings
from dataclasses import replace

import numpy as np
import pytest

import nonsmooth as ns
from models import BouncingBall, PainleveRod, SpragSlip, WallPendulum, Woodpecker
from tests.systems import block

ROD = PainleveRod(m=1.0, l=2.0, I=1 / 3, mu=1.0, e=0.9)  # at 45 degrees G = ((2.5, -1.5), (-1.5, 2.5))
INTEGRATORS = [ns.MoreauJean(dt=1e-6), ns.Adaptive(rtol=1e-6, atol=1e-8), ns.EventDriven()]
G_NN, G_NF, G_FF = 2.5, -1.5, 2.5
D = G_NN * G_FF - G_NF**2
FALL = 1.0  # m/s
WORST_SLIP = -G_NF * FALL / G_NN  # m/s, at which the gain is largest


def gain_by_hand(slip, e=ROD.e):
    """T_+ - T_- of an impact that ends sticking [J]: P = G^-1 (gamma_+ - gamma_-), gamma_+ = (e FALL, 0)."""
    P = np.linalg.solve([[G_NN, G_NF], [G_NF, G_FF]], [(1 + e) * FALL, -slip])
    assert abs(P[1]) <= ROD.mu * P[0]  # it does stick
    return 0.5 * (P[0] * (e - 1.0) * FALL + P[1] * slip)


def strike(integrator, slip=WORST_SLIP, impact="newton", t_end=1e-3, **contact):
    """The rod falls on its tip, with the sliding velocity ``slip``, and does not turn."""
    laws = {"mu": "mu", "e_N": "e", "impact": impact, **contact}
    system = replace(ROD.system(), contacts=[ns.Contact(**laws)])
    q, _ = ROD.state(th=math.pi / 4)
    return ns.simulate(system, (0, t_end), q, [slip, -FALL, 0.0], integrator=integrator)


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=lambda integrator: type(integrator).__name__)
def test_impact_that_gains_energy_is_counted_with_its_gain_and_warned_of_once(integrator):
    exact = (G_NF**2 / G_NN - (1 - ROD.e**2) * G_FF) * FALL**2 / (2 * D)
    assert gain_by_hand(WORST_SLIP) == pytest.approx(exact, rel=1e-12) and exact > 0.05
    with pytest.warns(ns.EnergyGainWarning, match="gained energy in one impact, up to 0.0531 J") as caught:
        solution = strike(integrator)
    assert len(caught) == 1 and solution.stats.energy_gains == 1
    # gravity and the time of the step move gamma by no more than g dt = 1e-5 m/s of 1 m/s
    assert solution.stats.worst_energy_gain == pytest.approx(exact, rel=1e-3)
    kinetic = solution.ledger["kinetic"]
    assert np.diff(kinetic).max() == pytest.approx(exact, rel=1e-3)
    assert "gained energy in one impact" in solution.summary()


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=lambda integrator: type(integrator).__name__)
@pytest.mark.parametrize("law", [{"impact": "poisson"}, {"impact": "energetic"}, {"e_F": 0.9}, {"e_N": 0.0}])
def test_no_other_law_gains_on_the_same_rod(integrator, law):
    solution = strike(integrator, **law)
    stats, ledger = solution.stats, solution.ledger
    assert stats.energy_gains == 0 and stats.worst_energy_gain == 0.0
    assert ledger["friction"][-1] + ledger["normal"][-1] <= 0.0
    assert "gained" not in solution.summary()


@pytest.mark.parametrize("part", [-0.9, -0.5, -0.1, 0.1, 0.5, 0.9])
def test_flag_is_raised_exactly_where_the_closed_form_is_positive(part):
    """The gain is a parabola of the sliding velocity, positive between two roots."""
    half = math.sqrt(G_NF**2 - (1 - ROD.e**2) * G_NN * G_FF) * FALL / G_NN
    for slip in (WORST_SLIP + part * half, WORST_SLIP + part / abs(part) * (2 - abs(part)) * half):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ns.EnergyGainWarning)
            stats = strike(ns.EventDriven(), slip, t_end=1e-6).stats
        exact = gain_by_hand(slip)
        assert (stats.energy_gains == 1) == (exact > 0.0)
        assert stats.worst_energy_gain == pytest.approx(max(0.0, exact), rel=1e-9)


def shaken_block(theta):
    """A block under a force that turns: it slides to and fro, and in each turn a step's friction works forward."""

    def force(t, q, u, p, h):
        h[0], h[1] = 20.0 * math.cos(30.0 * t), -10.0

    shaken = block(ns.Contact(mu=0.3, e_N=0.8), force=force)
    return ns.simulate(shaken, (0, 1), [0.0, 0.0], [0.3, 0.0], integrator=ns.MoreauJean(dt=1e-2, theta=theta))


@pytest.mark.parametrize("theta", [0.5, 1.0])
def test_steps_in_which_forces_turn_a_slide_are_no_gains_of_an_impact(theta):
    solution = shaken_block(theta)
    friction = np.diff(solution.ledger["friction"])
    assert friction.max() > 1e-6  # J: there are such steps, of O(dt^2)
    assert solution.stats.energy_gains == 0


@pytest.mark.parametrize("dt", [1e-4, 1e-2])
@pytest.mark.parametrize("model", [SpragSlip(), PainleveRod(), BouncingBall(e=1.0), WallPendulum(e=1.0)])
def test_curved_constraints_surfaces_and_elastic_impacts_gain_nothing(model, dt):
    solution = ns.simulate(model, (0, 0.3), *model.state(), integrator=ns.MoreauJean(dt=dt))
    assert solution.stats.energy_gains == 0


def push_by_hand(slip, e=ROD.e):
    """The work of friction in an impact that ends sticking [J]: P_F gamma_F / 2."""
    P = np.linalg.solve([[G_NN, G_NF], [G_NF, G_FF]], [(1 + e) * FALL, -slip])
    assert abs(P[1]) <= ROD.mu * P[0]
    return 0.5 * P[1] * slip


@pytest.mark.parametrize(
    "integrator", [ns.EventDriven(), ns.Adaptive(), ns.MoreauJean(dt=1e-7)], ids=lambda one: type(one).__name__
)
@pytest.mark.parametrize("slip", [-0.4, 0.05, 0.3, 0.6, 1.0, 1.3])
def test_friction_that_does_work_is_counted_with_its_work_also_where_all_together_loses(slip, integrator):
    exact = push_by_hand(slip)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        solution = strike(integrator, slip, t_end=1e-6)
    stats = solution.stats
    assert stats.friction_gains == int(exact > 0.0)
    assert stats.worst_friction_gain == pytest.approx(max(0.0, exact), rel=1e-4, abs=1e-12)
    kinds = [one.category for one in caught]
    gains = gain_by_hand(slip) > 0.0
    assert kinds == ([ns.EnergyGainWarning] if gains else [ns.FrictionGainWarning] if exact > 0.0 else [])
    assert ("friction did work in one impact" in solution.summary()) == (exact > 0.0)
    assert solution.ledger["friction"][-1] == pytest.approx(exact, rel=1e-3, abs=1e-7)


@pytest.mark.parametrize("law", [{"impact": "poisson"}, {"impact": "energetic"}, {"mu": 0.0}])
def test_friction_does_no_work_under_laws_that_follow_the_slide(law):
    stats = strike(ns.EventDriven(), 0.3, t_end=1e-6, **law).stats
    assert stats.friction_gains == 0 and stats.worst_friction_gain == 0.0


def test_a_woodpecker_whose_friction_takes_more_than_it_does_tells_it_in_the_summary(recwarn):
    """In all its friction takes 5 mJ a second, and drives the slide by up to 13 uJ where the beak and the ring hit."""
    toy = Woodpecker()
    solution = ns.simulate(toy, (0, 1), *toy.state(), integrator=ns.EventDriven())
    assert not recwarn.list and solution.stats.friction_gains > 0 and solution.ledger["friction"][-1] < -0.005
    assert "friction did work in" in solution.summary()
