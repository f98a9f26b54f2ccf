"""Events of the user: located to rounding, in the direction asked for, terminal or not; and budgets.

Of all but MoreauJean the roots are those of the motion within the steps; the closed forms here are parabolas,
which both integrate exactly.
"""

import math

import numpy as np
import pytest

import nonsmooth as ns
from models import BouncingBall, PainleveRod, SlidingBlock, WallPendulum

BALL = BouncingBall(e=0.8)
EVENT_DRIVEN = ns.EventDriven()
INTEGRATORS = [EVENT_DRIVEN, ns.Adaptive(1e-6), ns.MoreauJean(dt=1e-3), ns.Penalty(stiffness=1e6, damping=30.0)]
EPS = np.finfo(float).eps


def event(function, terminal=False, direction=0):
    """A fresh function with its attributes."""

    def wrapped(t, q, u):
        return function(t, q, u)

    wrapped.terminal, wrapped.direction = terminal, direction
    return wrapped


def fall(t_end, integrator=EVENT_DRIVEN, **options):
    return ns.simulate(BALL, (0, t_end), *BALL.state(height=1.0), integrator=integrator, **options)


def passes(height):
    return lambda t, q, u: q[0] - height


# where they are


def test_heights_are_passed_at_the_times_of_the_parabola_to_rounding():
    sol = fall(1.0, events=[event(passes(0.3))])
    speed = math.sqrt(2 * BALL.g)
    landing = speed / BALL.g
    rise = (0.8 * speed - math.sqrt(0.64 * speed**2 - 2 * BALL.g * 0.3)) / BALL.g
    exact = np.array([math.sqrt(2 * 0.7 / BALL.g), landing + rise])
    assert np.abs(sol.t_events[0] - exact).max() < 10 * EPS
    assert np.abs(sol.q_events[0] - 0.3).max() < 10 * EPS and sol.u_events[0].shape == (2, 1)


@pytest.mark.parametrize("direction, expected", [(0, 2), (1, 1), (-1, 1)])
def test_direction_selects_rise_or_fall(direction, expected):
    sol = fall(0.9, events=event(passes(0.3), direction=direction))
    assert [len(t) for t in sol.t_events] == [expected]
    assert (np.sign(sol.u_events[0][:, 0]) == direction).all() or direction == 0


def test_event_that_comes_and_goes_within_one_step_is_seen():
    """In free flight a step is one parabola: the height 0.63 m is passed twice around the second apex, at 0.64 m."""
    sol = fall(1.1, events=[passes(0.63)])
    ends = sol.t[1:][np.diff(sol.t) > 0]
    apex = (1 + 0.8) * math.sqrt(2 / BALL.g)
    around = sol.t_events[0][1:]
    assert len(around) == 2 and abs(around.mean() - apex) < 1e-14
    assert not ((ends > around[0]) & (ends < around[1])).any()


def test_jump_of_the_velocity_through_zero_is_an_event_at_the_impact():
    sol = fall(2.0, events=[event(lambda t, q, u: u[0], direction=1)])
    impacts = [e.t for e in sol.events if e.kind == ns.EventKind.IMPACT]
    assert (sol.t_events[0] == impacts).all() and (sol.u_events[0] > 0).all()


def test_quantity_that_rests_at_zero_gives_one_event():
    """The block stops at 1.0194 s and rests: its velocity reaches zero once."""
    block = SlidingBlock()
    sol = ns.simulate(block, (0, 3), *block.state(speed=2.0), integrator=EVENT_DRIVEN, events=[lambda t, q, u: u[0]])
    (times,) = sol.t_events
    assert len(times) == 1 and abs(times[0] - block.stop_time(2.0)) < 1e-12


def test_a_function_that_starts_at_zero_is_no_event_until_it_returns_there():
    sol = fall(1.0, events=[lambda t, q, u: q[0] - 1.0, lambda t, q, u: 0.0])
    assert [len(t) for t in sol.t_events] == [0, 0]


def test_events_of_smooth_motion_are_as_exact_as_the_motion():
    """The pendulum passes 0.5 rad; between the steps the motion is of order 5."""
    pendulum = WallPendulum(th_w=-1.5)
    start = pendulum.state(th=1.0)
    fine, coarse = (
        ns.simulate(pendulum, (0, 5), *start, integrator=ns.EventDriven(rtol, 1e-2 * rtol), events=[passes(0.5)])
        for rtol in (1e-12, 1e-7)
    )
    assert len(fine.t_events[0]) == 5
    assert np.abs(coarse.t_events[0] - fine.t_events[0]).max() < 1e-8


@pytest.mark.parametrize("dt", [1e-3, 1e-4])
def test_time_stepping_finds_events_with_its_own_error(dt):
    sol = fall(0.44, ns.MoreauJean(dt=dt), events=[passes(0.3)])
    assert abs(sol.t_events[0][0] - math.sqrt(1.4 / BALL.g)) < dt**2


def test_compiled_function_gives_the_same_events():
    import numba

    compiled = numba.njit("float64(float64, float64[::1], float64[::1])")(lambda t, q, u: q[0] - 0.3)
    by_numba, by_python = fall(1.0, events=[compiled]), fall(1.0, events=[passes(0.3)])
    assert (by_numba.t_events[0] == by_python.t_events[0]).all() and len(by_numba.t_events[0]) == 2


@pytest.mark.parametrize("options", [{"every": 5}, {"t_eval": [0.0, 0.9]}])
@pytest.mark.parametrize("integrator", [EVENT_DRIVEN, ns.Penalty(stiffness=1e6, damping=30.0)])
def test_events_do_not_depend_on_what_is_recorded(options, integrator):
    few, all_steps = (fall(0.9, integrator, events=[passes(0.3)], **given) for given in (options, {}))
    assert np.abs(few.t_events[0] - all_steps.t_events[0]).max() < 1e-12 and len(few.t_events[0]) == 2


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_events_do_not_change_the_run(integrator):
    plain, watched = fall(0.9, integrator), fall(0.9, integrator, events=[passes(0.3)])
    assert (plain.t == watched.t).all() and (plain.q == watched.q).all() and plain.t_events == []


# terminal


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_terminal_event_ends_the_run_there(integrator):
    sol = fall(3.0, integrator, events=[event(passes(0.3), terminal=True), passes(0.9)])
    assert sol.success and sol.status == ns.Status.EVENT_REACHED and "events[0]" in sol.message
    assert sol.t[-1] == sol.t_events[0][0] and abs(sol.t[-1] - math.sqrt(1.4 / BALL.g)) < 1e-6
    assert abs(sol.q[-1, 0] - 0.3) < 1e-12 and abs(sol.g_N[-1, 0] - 0.3) < 1e-12
    assert len(sol.t_events[1]) == 1 and (np.diff(sol.t) > 0).all()
    assert np.abs(sol(sol.t[-1]).q - sol.q[-1]).max() < 1e-15
    ledger = sol.ledger  # a work in proportion of the step differs from that of u(t) by m g^2 dt^2/8 at most
    allowed = BALL.g**2 * 1e-6 / 8 if isinstance(integrator, ns.MoreauJean) else 1e-12
    assert abs(ledger["kinetic"][-1] - ledger["force"][-1]) < allowed


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_terminal_counts_events(integrator):
    sol = fall(3.0, integrator, events=[event(passes(0.3), terminal=3)])
    assert len(sol.t_events[0]) == 3 and sol.t[-1] == sol.t_events[0][-1]
    assert all(e.t <= sol.t[-1] for e in sol.events)


def test_terminal_jump_ends_after_the_jump():
    sol = fall(3.0, events=[event(lambda t, q, u: u[0], terminal=True, direction=1)])
    speed = math.sqrt(2 * BALL.g)
    assert abs(sol.t[-1] - speed / BALL.g) < 1e-15
    assert abs(sol.u[-2, 0] + speed) < 1e-14 and abs(sol.u[-1, 0] - 0.8 * speed) < 1e-14
    assert len(sol.events) == 1


def test_terminal_event_ends_records_at_times_asked_for():
    sol = fall(3.0, t_eval=[0.1, 0.2, 2.0], events=[event(passes(0.3), terminal=True)])
    assert np.allclose(sol.t, [0.1, 0.2, math.sqrt(1.4 / BALL.g)], rtol=0, atol=1e-14)


def test_run_can_go_on_from_a_terminal_event():
    """A rod is followed to th = 40 degrees and on; the whole is the same motion."""
    rod = PainleveRod(mu=0.3)
    start = rod.state(th=math.radians(50), thdot=0.0, slip=0.8)
    fine = ns.EventDriven(1e-10, 1e-12)
    stop = event(lambda t, q, u: q[2] - math.radians(40), terminal=True)
    first = ns.simulate(rod, (0, 0.3), *start, integrator=fine, events=[stop])
    second = ns.simulate(rod, (first.t[-1], 0.3), first.q[-1], first.u[-1], integrator=fine)
    whole = ns.simulate(rod, (0, 0.3), *start, integrator=fine)
    assert np.abs(second.q[-1] - whole.q[-1]).max() < 1e-8
    assert abs(first.q[-1, 2] - math.radians(40)) < 1e-10


@pytest.mark.parametrize("integrator", [ns.EventDriven(1e-5, 1e-7), ns.MoreauJean(dt=1e-2)])
def test_interpreted_run_has_the_same_motion_and_events(integrator, monkeypatch):
    watched = {"events": [event(passes(0.3), terminal=2)]}
    compiled = fall(2.0, integrator, **watched)
    monkeypatch.setenv("NONSMOOTH_INTERPRET", "1")
    twin = fall(2.0, integrator, **watched)
    assert not twin.stats.is_compiled and (twin.t_events[0] == compiled.t_events[0]).all()
    t = np.linspace(0, twin.t[-1], 57)
    assert (twin(t).q == compiled(t).q).all() and (twin(t).u == compiled(t).u).all()


# functions that fail


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("function, said", [
    (lambda t, q, u: math.nan if t > 0.2 else 1.0, "returned nan"),
    (lambda t, q, u: math.sqrt(0.2 - t), "raised ValueError"), (lambda t, q, u: "low", "raised ValueError"),
    (lambda t, q, u: -math.inf, "returned -inf"), (lambda t, q, u: None, "raised TypeError"),
])  # fmt: skip
def test_function_that_fails_ends_the_run_with_what_was_computed(integrator, function, said):
    with pytest.raises(ns.EventFunctionError, match=r"the event function events\[0\].*" + said) as failure:
        fall(1.0, integrator, events=[function])
    error = failure.value
    assert isinstance(error, ns.StepFailure) and error.t == error.solution.t[-1] <= 0.45
    assert error.q == error.solution.q[-1] and error.u == error.solution.u[-1]
    back = fall(1.0, integrator, events=[function], on_failure="return")
    assert back.status == ns.Status.EVENT_FAILED and not back.success


def test_terminal_event_before_a_failure_counts():
    sol = fall(1.0, events=[lambda t, q, u: math.sqrt(0.2 - t), event(lambda t, q, u: t - 0.1, terminal=True)])
    assert sol.success and abs(sol.t[-1] - 0.1) < 1e-15


@pytest.mark.parametrize("events, message", [
    ([3], r"events must be functions f\(t, q, u\); events\[0\] is 3"),
    ([lambda t, q: 0.0], r"events\[0\] \(<lambda>\) must take \(t, q, u\)"),
    ([event(passes(0.3), terminal=-1)], r"terminal must be a whole number"),
    ([event(passes(0.3), direction=math.nan)], r"direction must be finite"),
])  # fmt: skip
def test_what_is_no_event_function_is_refused(events, message):
    with pytest.raises(ns.InvalidInput, match=message):
        fall(1.0, events=events)


@pytest.mark.parametrize("integrator, options, message", [
    (ns.MoreauJean(dt=1e-3), {"every": 5}, "from record to record"),
    (ns.MoreauJean(dt=1e-3), {"t_eval": [0.0, 0.9]}, "from record to record"),
])  # fmt: skip
def test_events_that_could_not_be_located_are_refused(integrator, options, message):
    with pytest.raises(ns.InvalidInput, match=message):
        fall(1.0, integrator, events=[passes(0.3)], **options)


# budgets


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("events", [(), (passes(0.3),)])
def test_steps_that_are_used_up_end_the_run_with_what_was_computed(integrator, events):
    with pytest.raises(ns.BudgetSpent, match="max_steps = 9 is used up after 9 steps") as failure:
        fall(3.0, integrator, max_steps=9, events=events)
    error = failure.value
    assert error.solution.stats.steps == 9 and error.t == error.solution.t[-1] < 3.0
    assert len(error.q) == len(error.u) == 1 and error.solution(0.5 * error.t).q[0] < 1.0
    back = fall(3.0, integrator, max_steps=9, on_failure="return")
    assert back.status == ns.Status.BUDGET_SPENT and not back.success


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_seconds_that_are_used_up_end_the_run(integrator):
    with pytest.raises(ns.BudgetSpent):
        fall(1e3, integrator, max_wall_time=1e-6, every=10**3)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_budget_that_is_just_enough_is_enough(integrator):
    steps = fall(0.9, integrator).stats.steps
    assert fall(0.9, integrator, max_steps=steps).success
    assert not fall(0.9, integrator, max_steps=steps - 1, on_failure="return").success


@pytest.mark.parametrize("budget", [0, -1, 1.5, math.nan, True])
def test_budget_that_is_no_number_of_steps_is_refused(budget):
    with pytest.raises(ns.InvalidInput, match="max_steps must be a whole number of at least 1"):
        fall(1.0, max_steps=budget)
