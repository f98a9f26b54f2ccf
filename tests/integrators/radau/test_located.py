"""The loop of located events: two families run in it, and begin where their header says."""

import numpy as np
import pytest

import nonsmooth as ns
from models import BouncingBall
from nonsmooth.runs.simulate_system import new_run

BALL = BouncingBall(e=0.5)
METHODS = (ns.EventDriven(1e-8, 1e-10), ns.Penalty(stiffness=1e6, damping=10.0))
of_every_method = pytest.mark.parametrize("integrator", METHODS, ids=lambda integrator: type(integrator).__name__)


def test_the_families_that_locate_events_share_one_loop():
    assert len({integrator.loop for integrator in METHODS}) == 1


@of_every_method
def test_a_loop_that_takes_no_step_leaves_the_start_where_it_is(integrator):
    q, u = BALL.state(height=1.0)
    task = BALL.system(), integrator, (0.0, 1.0), 1, None, q, u, 0, False
    run = new_run(*task)
    assert run.step_loop(0) == ns.Status.RUNNING and run.record.counts.rows == 0
    assert np.array_equal(run.state.q, q) and np.array_equal(run.state.u, u) and run.now == 0.0
    assert run.step_loop(1) == ns.Status.RUNNING and run.record.t[0] == 0.0


@of_every_method
def test_rows_at_given_times_lie_on_the_motion_that_rows_of_steps_show(integrator):
    """The landing at sqrt(2 h/g) is located once: neither the rows nor the times asked for move it."""
    start = BALL.state(height=1.0)
    rows, times = (
        ns.simulate(BALL, (0, 0.7), *start, integrator=integrator, t_eval=t_eval) for t_eval in (None, [0.1, 0.5, 0.7])
    )
    assert [event.t for event in rows.events] == [event.t for event in times.events] and len(rows.events) > 0
    assert np.array_equal(rows.q[-1], times.q[-1]) and np.array_equal(rows.u[-1], times.u[-1])
    assert times.q[0, 0] == pytest.approx(start[0][0] - 0.5 * BALL.g * 0.1**2, rel=1e-8)
