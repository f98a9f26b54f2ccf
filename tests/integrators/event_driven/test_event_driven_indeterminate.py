"""A slide that enters a region of several solutions is noted there: at p' = 0, or where it begins."""

import math

import pytest
from scipy.optimize import brentq

import nonsmooth as ns
from models import BilateralRod, PainleveRod, SpragSlip

EXACT = ns.EventDriven(rtol=1e-10, atol=1e-12)


def borders(mu):
    """Angles in (0, pi/2) where m p = 1 + 3 cos^2 th - 3 mu sin th cos th = 0 for a slender rod."""

    def p(th):
        return 1 + 3 * math.cos(th) ** 2 - 3 * mu * math.sin(th) * math.cos(th)

    least = 0.5 * math.atan2(mu, -1.0)  # p' = -3 sin 2 th - 3 mu cos 2 th = 0
    return brentq(p, 0.0, least, xtol=1e-15), brentq(p, least, math.pi / 2, xtol=1e-15)


@pytest.mark.parametrize(("th", "thdot", "side"), [(0.5, 4.0, 0), (1.45, -3.0, 1)])
def test_second_force_is_noted_where_its_determinant_falls_through_zero(th, thdot, side):
    rod = BilateralRod(mu=2.0)
    start = rod.state(th=th, thdot=thdot, slip=9.0)
    solution = ns.simulate(rod, (0, 0.2), *start, integrator=EXACT)
    (event,) = solution.paradoxes
    assert solution(event.t).q[2] == pytest.approx(borders(2.0)[side], rel=1e-9)  # ten of its tolerances
    assert event.n_solutions == 2 and event.alternatives == ("slide +", "slide + (P_N < 0)")
    moment = 1e-6  # s
    for t, number in ((event.t - moment, 1), (event.t + moment, 2)):
        state = solution(t)
        assert len(ns.classify(rod, t, state.q, state.u).solutions) == number
    assert 0 < solution.stats.indeterminate_steps <= solution.stats.steps


def test_slide_that_begins_where_two_forces_fit_is_noted_at_its_beginning():
    """Sprag-slip set 2 lets go in the region of two solutions after each seizure; plain steps see it within 7 ms."""
    model = SpragSlip(mu=1.3)
    start = model.state(0.78, 1.0)
    exact = ns.simulate(model, (0, 1), *start, integrator=EXACT)
    steps = ns.simulate(model, (0, 1), *start, integrator=ns.MoreauJean(1e-4))
    slides = [event.t for event in exact.events if event.kind == ns.EventKind.MODE_CHANGE]
    several = [event for event in exact.paradoxes if event.n_solutions == 2]
    assert [event.t for event in several] == slides and len(slides) == 3
    late = [event.t for event in steps.paradoxes if event.n_solutions > 1]
    assert all(0.0 < b - a < 8e-3 for a, b in zip(slides, late, strict=True))


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-7, 1e-8, 1e-9, 1e-11])
def test_each_region_that_a_slide_passes_is_noted_once(rtol):
    """The limit cycle of sprag-slip set 1 enters the region of two forces where p' = 0, 0.85 rad, each time round."""
    model = SpragSlip.set_1(cth=0.5)
    run = ns.simulate(model, (0, 0.5), *model.state(th=0.8, thdot=0.0), integrator=ns.EventDriven(rtol, rtol / 100))
    first, second = run.paradoxes
    assert run(first.t).q[1] == pytest.approx(run(second.t).q[1], abs=10 * rtol)


def test_slide_of_a_unilateral_rod_that_may_as_well_lift_is_noted_once():
    rod = PainleveRod(mu=2.0)
    q, u = rod.state(thdot=6.0)
    assert len(ns.classify(rod, 0.0, q, u).solutions) == 2
    solution = ns.simulate(rod, (0, 0.01), q, u, integrator=EXACT)
    assert [(event.t, event.n_solutions) for event in solution.paradoxes][:1] == [(0.0, 2)]
    assert sum(event.n_solutions == 2 for event in solution.paradoxes) == 1
