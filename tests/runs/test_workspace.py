"""Runs of one system one after the other use the same blocks: each is the run that it would be by itself."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import nonsmooth as ns
from models import BeltOscillator, BouncingBall, PainleveRod, SpragSlip
from nonsmooth.runs import workspace
from tests.systems import ball

METHODS = [
    ns.MoreauJean(dt=1e-3), ns.MoreauJean(dt=1e-3, theta=1.0, compliance=ns.Compliance(1e5, 10.0)), ns.Adaptive(),
    ns.EventDriven(), ns.Penalty(1e5),
]  # fmt: skip


def bits(solution):
    ledger = np.concatenate([solution.ledger[name] for name in solution.ledger])
    columns = (solution.t, solution.q, solution.u, solution.P_N, solution.mode, solution.event_rows, ledger)
    return [column.tobytes() for column in columns]


def runs_of(system, integrator, heights):
    return [ns.simulate(system, (0, 0.05), [y], [-1.0], integrator=integrator) for y in heights]


@pytest.mark.parametrize("integrator", METHODS, ids=repr)
def test_a_run_has_the_bits_of_the_first_run_of_its_system_and_keeps_them(integrator):
    heights = (0.03, 0.0, 0.02, 0.01)
    alone = [bits(ns.simulate(ball(), (0, 0.05), [y], [-1.0], integrator=integrator)) for y in heights]
    in_turn = runs_of(ball(), integrator, heights)
    assert [bits(solution) for solution in in_turn] == alone  # looked at after the last of them has run


@pytest.mark.parametrize("model", [BeltOscillator(), PainleveRod(), SpragSlip()], ids=repr)
def test_contacts_events_and_motion_are_those_of_each_run(model):
    q, u = model.state()
    step = ns.MoreauJean(dt=1e-3)
    first = ns.simulate(model.system(), (0, 0.3), q, u, integrator=step)
    system = model.system()
    again = ns.simulate(system, (0, 0.3), q, u, integrator=step)
    ns.simulate(system, (0, 0.3), q, 0.5 * np.asarray(u), integrator=step)
    ns.simulate(system, (0, 0.1), q, u, integrator=step, every=3)
    assert bits(again) == bits(first)
    assert np.array_equal(again(0.1234).q, first(0.1234).q)
    assert again.stats.steps == first.stats.steps and again.stats.worst_residual == first.stats.worst_residual


def test_runs_in_threads_share_no_block():
    system, step, heights = ball(), ns.MoreauJean(dt=1e-5), np.linspace(0.0, 0.03, 24)
    alone = [bits(solution) for solution in runs_of(system, step, heights)]
    with ThreadPoolExecutor(4) as pool:
        together = pool.map(lambda y: bits(*runs_of(system, step, [y])), heights)
        assert list(together) == alone


def test_parameters_that_are_changed_in_place_reach_the_next_run():
    system = ball()
    (before,) = runs_of(system, METHODS[0], [1.0])
    system.p[1] *= 2.0  # g
    (after,) = runs_of(system, METHODS[0], [1.0])
    fallen = [solution.q[0, 0] - solution.q[-1, 0] - 0.05 for solution in (before, after)]
    assert fallen[1] == pytest.approx(2.0 * fallen[0], rel=1e-12)


def test_a_run_that_did_not_end_well_keeps_its_blocks():
    model = BouncingBall()
    system = model.system()
    cut = ns.simulate(system, (0, 1), [1.0], [0.0], integrator=METHODS[0], max_steps=10, on_failure="return")
    assert cut.status == ns.Status.BUDGET_SPENT and not any(workspace._idle.get(system, {}).values())
    ns.simulate(system, (0, 1), [1.0], [0.0], integrator=METHODS[0])
    assert len(workspace._idle[system][METHODS[0], 0]) == 1
