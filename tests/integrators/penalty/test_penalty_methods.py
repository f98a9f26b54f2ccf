"""The compiled integrator beside SciPy's solvers, over rates, modes and events that are written in Python alone."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from benchmarks.adapters.scipy_springs import motion
from models import BouncingBall, PainleveRod, SpragSlip

# measured, with three times as much room: errors at the end for each tolerance of a step, which gather over the steps;
# those of multistep methods more, and those before a seizure grow with the speed in it
MARGIN = {"Radau": 100.0, "BDF": 3e4, "LSODA": 3e4}
MARGIN_OF_SEIZURE = 5e4
SENSITIVITY_OF_SEIZURE = 62.0  # measured: of the end to the start, by a start that is 1e-10 and 1e-9 off
DEFAULT_RTOL = 1e-8  # of the compiled integrator


def ends(model, state, t_end, stiffness, damping, method, rtol):
    """Coordinates and velocities at the end: of the compiled integrator at its default, and of a method of SciPy."""
    ours = compiled_end(model, state, t_end, stiffness=stiffness, damping=damping)
    times = np.array([0.0, t_end])
    theirs, _, _ = motion(model.system(), stiffness, damping, *state, times, method, rtol, 1e-2 * rtol)
    return ours, theirs[-1]


def compiled_end(model, state, t_end, **options):
    found = ns.simulate(model, (0, t_end), *state, integrator=ns.Penalty(**options), t_eval=[t_end])
    return np.concatenate((found.q[-1], found.u[-1]))


def test_seizure_by_another_method_ends_in_the_same_state():
    rod, rtol = SpragSlip(), 1e-8
    ours, theirs = ends(rod, rod.state(th=0.78, thdot=1.0), 0.4, 1e6, 1e6, "Radau", rtol)
    assert np.abs(ours - theirs).max() < MARGIN["Radau"] * rtol


@pytest.mark.parametrize("method", MARGIN)
def test_impact_without_collision_by_another_method(method):
    rod, rtol = PainleveRod(mu=2.0), 1e-9
    ours, theirs = ends(rod, rod.state(th=math.pi / 3, slip=-1.0), 6e-3, 1e8, 0.0, method, rtol)
    assert ours[1] > 1e-6  # it has left the ground
    assert np.abs(ours - theirs).max() < MARGIN[method] * rtol


@pytest.mark.parametrize("method", MARGIN)
def test_bounces_by_another_method(method):
    ball, rtol = BouncingBall(), 1e-9
    damping = 2 * 0.2 * math.sqrt(1e6 * ball.m)
    ours, theirs = ends(ball, ball.state(height=1.0), 1.3, 1e6, damping, method, rtol)
    assert np.abs(ours - theirs).max() < MARGIN[method] * rtol


@pytest.mark.upkeep
@pytest.mark.parametrize(("start", "t_end"), [((0.85, 0.0), 0.12), ((0.73, 3.3), 0.01)])
def test_stiff_seizure_by_another_method_ends_in_the_same_state(start, t_end):
    """Each start reaches A3 and seizes, at 0.1088 and 0.0035 s, by a force that grows at the rate k/1 s.

    Below 1e-10 SciPy's Radau comes no nearer, by 1e-6 on some processors, where Jacobians by differences end.
    """
    rod, rtol = SpragSlip(), 1e-10
    state = rod.state(th=start[0], thdot=start[1])
    ours, theirs = ends(rod, state, t_end, 1e8, 1e8, "Radau", rtol)
    assert np.abs(ours - theirs).max() < MARGIN_OF_SEIZURE * rtol
    exact = compiled_end(rod, state, t_end, stiffness=1e8, damping=1e8, rtol=1e-11, atol=1e-13)
    assert np.abs(ours - exact).max() < 3 * SENSITIVITY_OF_SEIZURE * DEFAULT_RTOL


def test_a_growing_force_is_followed_where_an_implicit_method_damps_it():
    """SciPy's Radau steps over the saddle of the seizure and calls it a success; ours refuses such steps."""
    rod, t_end, rtol = SpragSlip(), 0.12, 1e-5
    state = rod.state(th=0.85, thdot=0.0)
    exact, damped = ends(rod, state, t_end, 1e8, 1e8, "Radau", rtol)
    assert np.abs(damped - exact).max() > 1.0  # m/s: it goes on to slide where the rod is thrown back
    ours = compiled_end(rod, state, t_end, stiffness=1e8, damping=1e8, rtol=rtol, atol=1e-2 * rtol)
    assert np.abs(ours - exact).max() < MARGIN["Radau"] * rtol
