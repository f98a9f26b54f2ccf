"""What every integrator promises by its contract (integrators/contract.py), one row of a table each.

An oscillator q = cos(omega t) without contacts has a closed form, and every method takes it. The last row is a toy that
was written by the recipe of CONTRIBUTING; a method of your own gets these tests by one more row.
"""

import math
import signal
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns
from models import BouncingBall
from nonsmooth.integrators.contract import Integrator
from nonsmooth.integrators.fixed_step import FixedStep
from tests.integrators.verlet.options import Verlet

T_END = 2.0


class Spring(NamedTuple):
    m: float = 2.0  # [kg]
    k: float = 18.0  # [N/m]


def mass(t, q, p, M):
    M[0, 0] = p.m


def force(t, q, u, p, h):
    h[0] = -p.k * q[0]


OSCILLATOR = ns.System(n_q=1, mass=mass, force=force, parameters=Spring())
START = [1.0], [0.0]


@pytest.mark.parametrize("integrator", [ns.MoreauJean(1e-3), ns.Adaptive(), ns.EventDriven()], ids=type)
def test_a_loop_is_compiled_at_once_with_what_it_calls(integrator, monkeypatch):
    asked = []
    monkeypatch.setattr("nonsmooth.integrators.contract.load_all", asked.extend)
    integrator.load(OSCILLATOR)
    assert integrator.loop in asked and len(asked) > 1


class Row(NamedTuple):
    integrator: Integrator
    order: int | None  # of a fixed step, or None: the error follows rtol
    wrong: tuple[dict, ...]  # options that are refused


TOLERANCES = ({"rtol": 0.0}, {"rtol": 1.0}, {"atol": -1.0}, {"atol": math.nan})
TABLE = {
    "Moreau-Jean": Row(ns.MoreauJean(1e-2), 2, ({"dt": 0.0}, {"dt": math.nan}, {"theta": 0.4})),
    "Adaptive": Row(ns.Adaptive(1e-6, 1e-8), None, TOLERANCES),
    "event-driven": Row(ns.EventDriven(1e-6, 1e-8), None, TOLERANCES),
    "compliant": Row(ns.Penalty(stiffness=1e4, rtol=1e-6, atol=1e-8), None, ({"stiffness": 0.0}, *TOLERANCES)),
    "toy": Row(Verlet(1e-2), 2, ({"dt": 0.0}, {"dt": -1.0}, {"dt": math.nan})),
}
every_integrator = pytest.mark.parametrize("row", TABLE.values(), ids=TABLE)


def run(integrator, system=OSCILLATOR, t_end=T_END, **options):
    return ns.simulate(system, (0, t_end), *START, integrator=integrator, **options)


def bits(solution):
    """Times, states, impulses, modes and ledger, as bytes."""
    columns = solution.t, solution.q, solution.u, solution.g_N, solution.P_N, solution.mode, *solution.ledger.values()
    return [np.ascontiguousarray(column).tobytes() for column in columns]


def error(integrator):
    return abs(run(integrator).q[-1, 0] - math.cos(3.0 * T_END))


@every_integrator
def test_the_error_falls_as_the_order_says_or_follows_the_tolerance(row):
    """Of half the step it is 2^-order; of a hundredth of the tolerance at most a tenth, and below a thousand."""
    if row.order is not None:
        finer = replace(row.integrator, dt=row.integrator.dt / 2)
        assert math.log2(error(row.integrator) / error(finer)) == pytest.approx(row.order, abs=0.05)
        return
    finer = replace(row.integrator, rtol=1e-2 * row.integrator.rtol, atol=1e-2 * row.integrator.atol)
    assert error(row.integrator) < 1e3 * row.integrator.rtol
    assert error(finer) < 0.1 * max(error(row.integrator), row.integrator.rtol)


@every_integrator
def test_the_source_has_the_bits_of_the_machine_code(row, monkeypatch):
    compiled = run(row.integrator, t_end=0.2)
    monkeypatch.setenv("NONSMOOTH_INTERPRET", "1")
    twin = run(row.integrator, t_end=0.2)
    assert bits(twin) == bits(compiled) and compiled.stats.is_compiled and not twin.stats.is_compiled


@every_integrator
def test_a_run_that_was_stopped_goes_on_to_the_same_bits(row, tmp_path):
    place = tmp_path / "run.ckpt"
    stopped = run(row.integrator, checkpoint=place, max_steps=7, on_failure="return")
    assert stopped.status == ns.Status.BUDGET_SPENT and stopped.stats.steps == 7
    assert bits(run(row.integrator, resume=place)) == bits(run(row.integrator))


@pytest.mark.filterwarnings("ignore::nonsmooth.UnsettledWarning")  # the rows of long steps miss the crests
@every_integrator
def test_a_cell_of_a_sweep_has_the_bits_of_its_run(row):
    task = ns.RunTask(
        OSCILLATOR, ["final_state", "amplitude", "end_time"], t_span=(0, 20.0), integrator=row.integrator,
        state={"q0": START[0], "u0": START[1]},
    )  # fmt: skip
    assert task.is_block
    found = ns.sweep(task, {"k": [8.0, 18.0]}, progress=False)
    for k, q in zip((8.0, 18.0), found.q.values, strict=True):
        assert q.tobytes() == run(row.integrator, OSCILLATOR.with_parameters(k=k), 20.0).q[-1].tobytes()
    assert found.amplitude.values[:, 0] == pytest.approx(1.0, abs=0.05) and (found.end_time.values == 20.0).all()


@every_integrator
def test_options_that_cannot_be_are_refused(row):
    for wrong in row.wrong:
        with pytest.raises(ns.InvalidInput, match=next(iter(wrong))):
            replace(row.integrator, **wrong)


@pytest.mark.upkeep
@every_integrator
def test_ctrl_c_stops_with_what_was_computed(row):
    fine = (
        replace(row.integrator, dt=1e-6)
        if isinstance(row.integrator, FixedStep)
        else replace(row.integrator, rtol=1e-13, atol=1e-15)
    )
    solution = run(fine, t_end=200.0, every=50, progress=lambda done: signal.raise_signal(signal.SIGINT))
    assert solution.status == ns.Status.INTERRUPTED and 0.0 < solution.t[-1] < 200.0
    assert np.isfinite(solution.q).all()


@every_integrator
def test_events_of_the_user_are_found(row):
    """q = cos(3 t) falls through zero at pi/6; between the records of a fixed step to its second order."""
    solution = run(row.integrator, events=lambda t, q, u: q[0], t_end=1.0)
    assert solution.t_events[0] == pytest.approx([math.pi / 6], abs=1e-3 if row.order else 1e-5)


def test_the_toy_refuses_contacts():
    ball = BouncingBall()
    with pytest.raises(ns.InvalidInput, match="Verlet takes systems without contacts"):
        ns.simulate(ball, (0, 1), *ball.state(), integrator=Verlet(1e-3))
