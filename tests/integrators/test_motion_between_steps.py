"""The motion between the steps: its order, its joints, its jumps, and what it refuses."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from models import BeltOscillator, BouncingBall, PainleveRod, RockingBlock, SpragSlip, WallPendulum

EPS = np.finfo(float).eps


def run(model, t_end, state, integrator, **options):
    return ns.simulate(model, (0, t_end), *state, integrator=integrator, **options)


def free_pendulum():
    """A pendulum that swings freely, 5 s of smooth motion."""
    pendulum = WallPendulum(th_w=-1.5)
    return pendulum, pendulum.state(th=1.0)


# order


def test_smooth_motion_is_known_between_the_steps_with_order_5():
    """The error of velocities half-way in the steps, against the number of steps: slope 5, to a tenth.

    Locally the interpolation is of order 5 in u and 6 in q; the collocation polynomial of the method has order 4.
    """
    pendulum, start = free_pendulum()
    reference = run(pendulum, 5.0, start, ns.EventDriven(1e-13, 1e-15))
    steps, errors = [], []
    for rtol in (1e-4, 1e-5, 1e-6, 1e-7, 1e-8):
        sol = run(pendulum, 5.0, start, ns.EventDriven(rtol, 1e-2 * rtol))
        middle = 0.5 * (sol.t[1:] + sol.t[:-1])
        steps.append(sol.stats.steps)
        errors.append(np.abs(sol(middle).u - reference(middle).u).max())
    slope = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert slope < -4.9


SCENES = {
    "pendulum": (WallPendulum(), {"th": 1.0}, 5.0),
    "rod": (PainleveRod(mu=1.0), {"th": math.radians(75), "thdot": -0.5, "slip": -0.5}, 0.7),
    "belt": (BeltOscillator(vb=0.2), {"x": 0.1, "velocity": 0.2}, 5.0),
    "sprag-slip": (SpragSlip(), {"th": 0.8, "thdot": 0.0}, 1.0),
}


@pytest.mark.parametrize("scene", SCENES)
def test_motion_between_the_steps_is_as_exact_as_at_their_ends(scene):
    """Half as much again between the steps, and the error of the reference."""
    model, start, t_end = SCENES[scene]
    state = model.state(**start)
    reference = run(model, t_end, state, ns.EventDriven(1e-13, 1e-15))
    t = np.linspace(0, t_end, 1709)
    for rtol in (1e-5, 1e-7, 1e-9):
        sol = run(model, t_end, state, ns.EventDriven(rtol, 1e-2 * rtol))
        at_ends = np.abs(sol.q - reference(sol.t).q).max()
        assert np.abs(sol(t).q - reference(t).q).max() < 1.5 * at_ends + 1e-12


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8])
def test_compliant_contact_is_known_between_the_steps(rtol):
    """Steps up to the seizure, through it and after it are longer than the contact's own motion: 1 us."""
    rod = SpragSlip()
    stiff = {"stiffness": 1e6, "damping": 1e6}
    state = rod.state(th=0.78, thdot=1.0)
    reference = run(rod, 0.4, state, ns.Penalty(**stiff, rtol=1e-11, atol=1e-13))
    sol = run(rod, 0.4, state, ns.Penalty(**stiff, rtol=rtol, atol=1e-2 * rtol))
    t = np.linspace(0, 0.4, 997)
    at_ends = np.abs(sol.q - reference(sol.t).q).max()
    assert np.abs(sol(t).q - reference(t).q).max() < 1.5 * at_ends


@pytest.mark.parametrize("rtol", [1e-4, 1e-5])
def test_stiff_motion_does_not_ring_between_long_steps(rtol):
    """The contact relaxes in 1e-8 s, the steps last 2e-3 s: accelerations at their ends say nothing of the motion
    between. Through them alone the error would be 7 to 25 times that at the ends."""
    rod = SpragSlip()
    stiff = {"stiffness": 1e8, "damping": 1e8}
    state = rod.state(th=0.85, thdot=0.0)
    reference = run(rod, 0.1, state, ns.Penalty(**stiff, rtol=1e-11, atol=1e-13))
    sol = run(rod, 0.1, state, ns.Penalty(**stiff, rtol=rtol, atol=1e-2 * rtol))
    t = np.linspace(0, 0.1, 2003)
    at_ends = np.abs(sol.u - reference(sol.t).u).max()
    assert np.abs(sol(t).u - reference(t).u).max() < 2 * at_ends


@pytest.mark.parametrize("dt, bound", [(1e-2, 1e-3), (1e-3, 1e-5)])
def test_time_stepping_is_of_second_order_between_the_steps_of_smooth_motion(dt, bound):
    pendulum, start = free_pendulum()
    reference = run(pendulum, 2.0, start, ns.EventDriven(1e-12, 1e-14))
    sol = run(pendulum, 2.0, start, ns.MoreauJean(dt=dt))
    t = np.linspace(0, 2, 1709)
    assert np.abs(sol(t).q - reference(t).q).max() < bound and np.abs(sol(t).u - reference(t).u).max() < 4 * bound


# joints and jumps


@pytest.mark.parametrize("integrator", [
    ns.EventDriven(1e-6, 1e-8), ns.Adaptive(1e-6, 1e-8), ns.MoreauJean(dt=1e-3),
    ns.MoreauJean(dt=1e-3, theta=1.0, projection=True),
    ns.Penalty(stiffness=1e5, damping=10.0, rtol=1e-6),
])  # fmt: skip
def test_motion_passes_through_every_record_and_its_velocity_is_its_derivative(integrator):
    block = RockingBlock()
    sol = run(block, 0.8, block.state(tilt=0.1), integrator)
    motion, scale = sol.motion, (np.abs(sol.q).max(), np.abs(sol.u).max())
    first = np.searchsorted(sol.t, sol.t, "left") == np.arange(len(sol.t))  # of two rows at a jump, the one before
    last = np.searchsorted(sol.t, sol.t, "right") - 1 == np.arange(len(sol.t))
    for side, rows in (("left", first), ("right", last)):
        q, u = sol(sol.t[rows], side)
        step = np.maximum(np.searchsorted(motion.t, sol.t[rows], side) - 1, 0)
        bend = np.abs(motion.B[step]).sum(axis=(1, 2)) / motion.h[step]  # of u, which the rounding of t moves along
        assert np.abs(q - sol.q[rows]).max() < 100 * EPS * scale[0]
        assert (np.abs(u - sol.u[rows]).max(axis=1) < 1e3 * EPS * scale[1] + 4 * EPS * sol.t[rows] * bend).all()
    is_long = motion.h > 1e-2 * motion.h.max()
    k, middle = np.flatnonzero(is_long), motion.t[is_long] + 0.5 * motion.h[is_long]
    step = 1e-4 * motion.h[is_long]
    ahead, behind = (motion.within(k, middle + sign * step)[0] for sign in (1, -1))
    slope = (ahead - behind) / (2 * step[:, None])
    # rounding of q over the step, and its third derivative, which is what u bends by over the step
    allowed = 4 * EPS * scale[0] / step[:, None] + 1e-7 * scale[1]
    assert (np.abs(slope - motion.within(k, middle)[1]) < allowed).all()


def test_positions_are_continuous_and_velocities_jump_at_impacts_only():
    ball = BouncingBall(e=0.8)
    sol = run(ball, 3.0, ball.state(height=1.0), ns.EventDriven())
    motion = sol.motion
    q_left, u_left = sol(motion.t[1:], "left")
    q_right, u_right = sol(motion.t[1:])
    assert np.abs(q_left - q_right).max() < 1e-15
    impacts = np.array([e.t for e in sol.events if e.kind == ns.EventKind.IMPACT])
    is_impact = np.isin(motion.t[1:], impacts)
    assert is_impact.sum() == len(impacts) > 5
    assert np.abs((u_right - u_left)[~is_impact]).max() < 1e-14
    assert np.abs(u_right[is_impact] + 0.8 * u_left[is_impact]).max() < 1e-14
    speed = math.sqrt(2 * ball.g)
    assert abs(sol(impacts[0], side="left").u[0] + speed) < 1e-14
    assert abs(sol(impacts[0]).u[0] - 0.8 * speed) < 1e-14


def test_impact_at_the_start_and_at_the_end_of_a_run_is_kept():
    ball = BouncingBall(e=0.5, g=10.0)
    sol = run(ball, 0.1, ([0.0], [-2.0]), ns.EventDriven())
    assert sol(0.0, side="left").u[0] == -2.0 and sol(0.0).u[0] == 1.0
    sol = run(ball, 1.0, ball.state(height=5.0), ns.EventDriven())  # falls for one second
    at_end = np.array([sol(sol.t[-1], side=side).u[0] for side in ("left", "right")])
    assert np.abs(at_end - (sol.u[-2:, 0] if sol.t[-2] == sol.t[-1] else sol.u[-1, 0])).max() < 1e-14


def test_a_step_of_time_stepping_with_an_impact_goes_on_with_both_velocities():
    """theta = 1/2: the ball flies on with u_0 to the middle of its step and then with u_1, and so reaches q_1."""
    ball = BouncingBall(e=0.5)
    sol = run(ball, 0.6, ball.state(height=1.0), ns.MoreauJean(dt=1e-2))
    k = int(np.flatnonzero((sol.u[:-1, 0] < 0) & (sol.u[1:, 0] > 0))[0])
    before, after = sol(sol.t[k] + 0.004), sol(sol.t[k] + 0.006)
    assert before.u == sol.u[k] and abs(after.u[0] - sol.u[k + 1, 0]) < 1e-12
    assert abs(before.q[0] - (sol.q[k, 0] + 0.004 * sol.u[k, 0])) < 1e-15
    assert abs(after.q[0] - (sol.q[k + 1, 0] - 0.004 * sol.u[k + 1, 0])) < 1e-14


def test_ball_at_rest_is_exactly_at_rest_between_the_steps():
    ball = BouncingBall(e=0.5)
    sol = run(ball, 3.0, ball.state(height=1.0), ns.EventDriven())
    q, u = sol(np.linspace(ball.t_inf(height=1.0) + 1e-9, 3.0, 1001))
    assert (q == 0.0).all() and (u == 0.0).all()


# times asked for


@pytest.mark.parametrize("integrator", [ns.EventDriven(1e-5, 1e-7), ns.Penalty(stiffness=1e4, damping=20.0, rtol=1e-5)])
def test_records_at_times_asked_for_are_the_motion_at_these_times(integrator):
    ball = BouncingBall(e=0.8)
    t = np.linspace(0.0, 2.0, 313)
    asked = run(ball, 2.0, ball.state(height=1.0), integrator, t_eval=t)
    sol = run(ball, 2.0, ball.state(height=1.0), integrator)
    apart = np.abs(asked.u - sol(t).u).max(axis=1)
    assert (asked.t == t).all() and apart.max() < 1e-13
    assert np.abs(asked.q - sol(t).q).max() < 1e-14


def test_shapes_follow_the_time():
    rod = SpragSlip()
    sol = run(rod, 0.1, rod.state(th=0.8, thdot=0.0), ns.EventDriven())
    q, u = sol(0.05)
    assert q.shape == u.shape == (2,)
    assert sol([0.05]).q.shape == (1, 2) and sol(np.array([0.0, 0.05, 0.1])).u.shape == (3, 2)
    assert sol([]).q.shape == (0, 2) and (sol([0.05]).q[0] == q).all()


@pytest.mark.parametrize("t, side, message", [
    (1.5, "right", r"t must be a time within \[0, 1\]"), (-1e-9, "right", "got -1e-09"), (math.nan, "right", "got nan"),
    ([[0.5]], "right", r"got an array of shape \(1, 1\)"), (0.5, "both", "side must be 'left' or 'right'"),
])  # fmt: skip
def test_times_outside_the_run_are_refused(t, side, message):
    ball = BouncingBall()
    sol = run(ball, 1.0, ball.state(height=1.0), ns.EventDriven())
    with pytest.raises(ns.InvalidInput, match=message):
        sol(t, side)


@pytest.mark.parametrize("options", [{"every": 2}, {"t_eval": [0.0, 0.5, 1.0]}])
@pytest.mark.parametrize("integrator", [ns.EventDriven(), ns.Adaptive(1e-5), ns.MoreauJean(dt=1e-3)])
def test_motion_whose_steps_were_not_recorded_is_refused(integrator, options):
    ball = BouncingBall()
    sol = run(ball, 1.0, ball.state(height=1.0), integrator, **options)
    with pytest.raises(ns.InvalidInput, match="run without every=, t_eval= and checkpoint="):
        sol(0.3)


def test_motion_of_a_saved_solution_is_that_of_the_run_and_of_a_checkpoint_refused(tmp_path):
    ball = BouncingBall()
    sol = run(ball, 0.3, ball.state(height=1.0), ns.EventDriven())
    assert ns.Solution.load(sol.save(tmp_path / "ball.npz"))(0.1).q == sol(0.1).q
    streamed = run(ball, 0.3, ball.state(height=1.0), ns.EventDriven(), checkpoint=tmp_path / "ball")
    with pytest.raises(ns.InvalidInput, match="keeps no steps, or none in a checkpoint"):
        streamed(0.1)


def test_run_that_failed_knows_its_motion_until_then():
    def failing(t, q, u, p, h):
        h[0] = -math.sqrt(0.5 - t)

    def mass(t, q, p, M):
        M[0, 0] = 1.0

    point = ns.System(n_q=1, mass=mass, force=failing)
    sol = ns.simulate(point, (0, 1), [1.0], [0.0], integrator=ns.EventDriven(), on_failure="return")
    exact = 1.0 - 2 / 3 * (math.sqrt(0.5) ** 3 * 0.25 - 2 / 5 * (0.5**2.5 - 0.25**2.5))
    assert abs(sol(0.25).q[0] - exact) < 1e-8
    with pytest.raises(ns.InvalidInput, match="t must be a time within"):
        sol(0.6)
