"""Adaptive Moreau–Jean between its steps: error, order, jumps, events of the user."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from models import (
    BeadChain,
    BeltOscillator,
    BouncingBall,
    PainleveRod,
    RockingBlock,
    SliderCrank,
    SpragSlip,
    WallPendulum,
    Woodpecker,
)
from nonsmooth.integrators.adaptive.polynomial import MOST_DERIVATIVES, highest_coefficients

BELT = BeltOscillator(vb=0.2)
SCENES = {
    "pendulum": (WallPendulum(), {"th": 1.0}, 5.0),
    "rod": (PainleveRod(mu=0.5), {"th": math.pi / 3, "thdot": 0.0, "slip": 1.0}, 0.3),
    "belt": (BELT, {"x": BELT.release_position(), "velocity": 0.2}, 10.0),
    "rocking block": (RockingBlock(), {"tilt": 0.1}, 1.5),
    "sprag-slip, seizures": (SpragSlip(), {"th": 0.8, "thdot": 0.0}, 1.0),
    "beads": (BeadChain(n=10), {"velocity": 1.0}, 0.3),
    "slider-crank": (SliderCrank(), {}, 0.05),
    "woodpecker": (Woodpecker(), {}, 0.1),
}
BETWEEN = 30.0  # tolerances that the motion between the steps may add: 22 are the most, of the crank; 5 of the others


def run(model, t_end, state, rtol, **options):
    return ns.simulate(model, (0.0, t_end), *state, integrator=ns.Adaptive(rtol, 1e-2 * rtol), **options)


@pytest.mark.filterwarnings("ignore::nonsmooth.SimultaneousImpactWarning")  # what is asked holds for it too
@pytest.mark.parametrize("scene", SCENES)
def test_motion_between_the_steps_is_nearly_as_exact_as_at_their_ends(scene):
    """At 2000 times, in units of rtol (1e-2 + max |q|), against located events at 1e-12."""
    model, start, t_end = SCENES[scene]
    state, t = model.state(**start), np.linspace(0.0, t_end, 2003)
    reference = ns.simulate(model, (0.0, t_end), *state, integrator=ns.EventDriven(1e-12, 1e-14))
    scale = 1e-2 + np.abs(reference.q).max(axis=0)
    for rtol in (1e-5, 1e-7, 1e-9):
        sol = run(model, t_end, state, rtol)
        at_ends = (np.abs(sol.q - reference(sol.t).q) / scale).max()
        assert (np.abs(sol(t).q - reference(t).q) / scale).max() < 1.5 * at_ends + BETWEEN * rtol


def test_error_between_the_steps_falls_faster_than_with_order_six():
    """Velocities half-way in the steps of a free swing, from the tolerance 1e-4 to 1e-9."""
    pendulum = WallPendulum(th_w=-1.5)
    start = pendulum.state(th=1.0)
    reference = ns.simulate(pendulum, (0.0, 5.0), *start, integrator=ns.EventDriven(1e-13, 1e-15))
    steps, errors = [], []
    for rtol in (1e-4, 1e-9):
        sol = run(pendulum, 5.0, start, rtol)
        middle = sol.motion.t + 0.5 * sol.motion.h
        steps.append(sol.stats.steps)
        errors.append(np.abs(sol(middle).u - reference(middle).u).max())
    assert errors[1] < 50e-9 and math.log(errors[0] / errors[1]) > 6.0 * math.log(steps[1] / steps[0])


def test_polynomial_is_exact_for_the_powers_that_its_conditions_determine():
    """u = theta^k for the highest powers: what is left is all of it, and the coefficient 1 comes back."""
    for L in range(1, MOST_DERIVATIVES + 1):
        for row, k in enumerate(range(L + 1, 2 * L + 3)):
            left = [math.perm(k, order) for order in range(L + 1)] + [1.0 / (k + 1)]
            found = highest_coefficients()[L, : L + 2, : L + 2] @ left
            assert found == pytest.approx(np.eye(L + 2)[row], abs=1e-11)


def test_flight_of_a_ball_is_its_parabola_and_every_impact_a_jump():
    ball = BouncingBall(e=0.8)
    sol = run(ball, 3.0, ball.state(height=1.0), 1e-8)
    t = np.linspace(0.0, 3.0, 4001)
    assert np.abs(sol(t).q[:, 0] - [ball.height(moment) for moment in t]).max() < 3e-8
    motion = sol.motion
    left, right = sol(motion.t[1:], "left"), sol(motion.t[1:])
    assert np.abs(left.q - right.q).max() < 1e-14
    jumps = right.u[:, 0] - left.u[:, 0]
    impacts = [event for event in sol.events if event.kind == ns.EventKind.IMPACT]
    large = jumps > 1e-3
    assert large.sum() == sum(event.P_N > 1e-3 * ball.m for event in impacts) > 5
    assert right.u[large, 0] == pytest.approx(-0.8 * left.u[large, 0], rel=1e-6)
    assert np.abs(jumps[~large]).max() < 1e-3


def test_impact_without_collision_is_before_its_step():
    """The seizures of a sprag-slip rod: at the time of the event the velocities jump from those of located events to
    those of located events, which a time error of 3e-9 s changes by 1e-6."""
    rod = SpragSlip()
    sol = run(rod, 1.0, rod.state(th=0.8, thdot=0.0), 1e-8)
    exact = ns.simulate(rod, (0.0, 1.0), *rod.state(th=0.8, thdot=0.0), integrator=ns.EventDriven(1e-11, 1e-13))
    times = [[event.t for event in run.paradoxes if event.kind == ns.EventKind.INCONSISTENT] for run in (sol, exact)]
    assert times[0] == pytest.approx(times[1], abs=1e-8) and len(times[0]) == 3
    for side in ("left", "right"):
        assert sol(times[0], side).u == pytest.approx(exact(times[1], side).u, abs=2e-6)


def test_heights_are_passed_at_the_times_of_the_parabola():
    """Within the tolerance of the height over the speed there."""
    ball = BouncingBall(e=0.8)

    def half(t, q, u):
        return q[0] - 0.3

    sol = run(ball, 1.0, ball.state(height=1.0), 1e-9, events=[half])
    speed = math.sqrt(2 * ball.g)
    rise = (0.8 * speed - math.sqrt(0.64 * speed**2 - 2 * ball.g * 0.3)) / ball.g
    exact = [math.sqrt(2 * 0.7 / ball.g), speed / ball.g + rise]
    assert sol.t_events[0] == pytest.approx(exact, abs=3e-9)
    assert np.abs(sol.q_events[0] - 0.3).max() < 1e-14


@pytest.mark.parametrize("options", [{}, {"every": 7}, {"t_eval": [0.1, 0.8, 2.0]}])
def test_terminal_event_ends_the_run_at_a_step_of_its_own(options):
    """The block of the belt turns round; until then the run is the one without the event."""

    def turns(t, q, u):
        return u[0]

    turns.terminal = 2
    state = BELT.state(x=BELT.release_position(), velocity=0.2)
    sol = run(BELT, 10.0, state, 1e-8, events=[turns], **options)
    reference = ns.simulate(BELT, (0.0, 10.0), *state, integrator=ns.EventDriven(1e-12, 1e-14), events=[turns])
    assert sol.status == ns.Status.EVENT_REACHED and sol.t[-1] == sol.t_events[0][-1]
    assert sol.t_events[0] == pytest.approx(reference.t_events[0], abs=1e-7)
    assert sol.u[-1, 0] == pytest.approx(0.0, abs=1e-7)
    alone = run(BELT, 10.0, state, 1e-8, **options)
    n = np.searchsorted(sol.t, 0.9 * sol.t[-1])
    assert np.array_equal(sol.q[:n], alone.q[:n])


def test_motion_is_whole_over_many_blocks_of_steps():
    """More steps than are kept at once: one begins where the one before it ends."""
    rod = SpragSlip()
    sol = run(rod, 3.0, rod.state(th=0.8, thdot=0.0), 1e-10)
    motion = sol.motion
    assert sol.stats.steps > 1024
    assert np.abs(motion.t[1:] - motion.t[:-1] - motion.h[:-1]).max() < 4e-15
    assert np.abs(sol(motion.t[1:], "left").q - sol(motion.t[1:]).q).max() < 1e-13
