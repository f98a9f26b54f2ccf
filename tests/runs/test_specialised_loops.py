"""A loop compiled for one system takes the steps of the generic one, to the last bit, and is never a stale one."""

import os
import subprocess
import sys
import threading
import time
import warnings

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.catalogue import BeltOscillator, RockingBlock
from nonsmooth.catalogue import load as load_model
from nonsmooth.catalogue.entries import model_entries
from nonsmooth.jit import beside
from nonsmooth.jit.specialised import Specialised
from nonsmooth.runs import specialise
from tests.systems import ball

pytestmark = pytest.mark.upkeep

OWN, GENERIC = (ns.MoreauJean(dt=1e-3, specialise=wish) for wish in (True, False))


@pytest.fixture(autouse=True)
def none_made(monkeypatch):
    monkeypatch.setattr(specialise, "_made", {})


def rebounding_ball(**changes):
    return ball(ns.Contact(e_N=0.8), **changes)


def run_of(system, integrator, start, t_end=2.0):
    return ns.simulate(system, (0.0, t_end), *start, integrator=integrator)


def assert_same(one, other):
    for name in ("t", "q", "u", "la", "mode", "g_N"):
        a, b = (np.asarray(getattr(sol, name)) for sol in (one, other))
        assert a.tobytes() == b.tobytes(), name
    assert repr(one.events) == repr(other.events) and repr(one.ledger) == repr(other.ledger)
    assert one.stats.worst_residual == other.stats.worst_residual and one.stats.steps == other.stats.steps


def test_steps_events_and_ledger_are_those_of_the_generic_loop_to_the_last_bit():
    system = rebounding_ball()
    assert_same(run_of(system, OWN, ([1.0], [0.0])), run_of(system, GENERIC, ([1.0], [0.0])))
    (found,) = specialise._made.values()
    assert found.address and found.is_on_disk


def test_parameters_laws_and_starts_are_not_built_in():
    class Heavier(type(ball().parameters)):
        pass

    run_of(rebounding_ball(), OWN, ([1.0], [0.0]))
    other = ball(ns.Contact(e_N=0.3), parameters=Heavier(m=3.0, g=1.6))
    assert_same(run_of(other, OWN, ([0.5], [-1.0])), run_of(other, GENERIC, ([0.5], [-1.0])))
    assert len(specialise._made) == 1


def test_options_that_are_built_in_have_a_loop_each():
    system = rebounding_ball()
    run_of(system, OWN, ([1.0], [0.0]), 0.1)
    implicit = [ns.MoreauJean(dt=1e-3, theta=1.0, specialise=wish) for wish in (True, False)]
    assert_same(*(run_of(system, integrator, ([1.0], [0.0])) for integrator in implicit))
    assert len(specialise._made) == 2


def test_a_function_that_reads_another_number_has_another_loop():
    def system(lift):
        def force(t, q, u, p, h):
            h[0] = -p.m * p.g + lift

        return rebounding_ball(force=force)

    for lift in (0.0, 5.0):
        assert_same(*(run_of(system(lift), integrator, ([1.0], [0.0])) for integrator in (OWN, GENERIC)))
    assert len(specialise._made) == 2


@pytest.mark.parametrize("is_rocking", [True, False])
def test_models_with_two_contacts_friction_and_their_own_row_rates_keep_their_bits(is_rocking):
    model = RockingBlock() if is_rocking else BeltOscillator()
    both = [ns.MoreauJean(dt=2e-3, projection=is_rocking, specialise=wish) for wish in (True, False)]
    assert_same(*(run_of(model, integrator, model.state(), 3.0) for integrator in both))


def test_functions_that_allocate_index_from_the_end_and_raise_do_so_in_the_loop():
    def force(t, q, u, p, h):
        weights = np.zeros(2)
        weights[-1] = -p.m * p.g
        if t > 0.5:
            raise ValueError("too late")
        h[-1] = weights.sum()

    system = rebounding_ball(force=force)
    early = [run_of(system, integrator, ([1.0], [0.0]), 0.4) for integrator in (OWN, GENERIC)]
    assert_same(*early)
    with pytest.raises(ns.ModelFunctionError, match="force"):
        run_of(system, OWN, ([1.0], [0.0]), 1.0)


def test_a_model_that_fails_at_its_start_has_no_loop_compiled():
    def force(t, q, u, p, h):
        h[1] = -p.m * p.g

    with pytest.raises(ns.InvalidInput, match="force"):
        run_of(rebounding_ball(force=force), OWN, ([1.0], [0.0]))
    assert not specialise._made


def test_cells_of_a_sweep_are_the_same():
    found = [
        ns.sweep(
            ns.RunTask(rebounding_ball(), ["final_state", "impacts"], t_span=(0, 2), integrator=one,
                       state={"q0": [1.0], "u0": [0.0]}),
            {"g": np.linspace(1.0, 10.0, 7)},
        )
        for one in (OWN, GENERIC)
    ]  # fmt: skip
    assert found[0].equals(found[1])
    assert len(specialise._made) == 1


def test_it_is_read_from_disk_by_the_next_process(tmp_path):
    program = """
import nonsmooth as ns
from nonsmooth.jit import specialised
from nonsmooth.catalogue import BouncingBall
if {refuses}:
    specialised.inlined_model = None
ball = BouncingBall()
print(ns.simulate(ball, (0, 1), *ball.state(), integrator=ns.MoreauJean(dt=1e-3, specialise=True)).q[-1, 0].hex())
"""
    said = [
        subprocess.run([sys.executable, "-W", "error", "-c", program.format(refuses=refuses)], check=True,
                       capture_output=True, text=True, timeout=200).stdout
        for refuses in (False, True)
    ]  # fmt: skip
    assert said[0] == said[1] != ""


def test_it_is_made_where_the_steps_pay_for_it(monkeypatch):
    system = rebounding_ball()
    run_of(system, ns.MoreauJean(dt=1e-3), ([1.0], [0.0]))
    assert not specialise._made
    monkeypatch.setattr(specialise, "SAVED", 1.0)
    monkeypatch.setattr(specialise, "has_free_processor", lambda: False)  # which would compile it beside the run
    run_of(system, ns.MoreauJean(dt=1e-3), ([1.0], [0.0]))
    assert [found.address > 0 for found in specialise._made.values()] == [True]


def test_what_a_run_waits_for_its_loop_is_told_as_compiling(monkeypatch):
    load, waited = Specialised.load, 0.2  # s

    def slowly(self):
        time.sleep(waited)
        load(self)

    monkeypatch.setattr(Specialised, "load", slowly)
    assert run_of(rebounding_ball(), OWN, ([1.0], [0.0])).stats.compile_time >= waited


def pays_at_once(monkeypatch, load):
    """Every run pays for a loop of its own, which ``load`` makes beside it."""
    monkeypatch.setattr(specialise, "SAVED", 1.0)
    monkeypatch.setattr(specialise, "has_free_processor", lambda: True)
    monkeypatch.setattr(Specialised, "time_to_load", lambda self: 0.0 if self.address else 8.0)
    monkeypatch.setattr(Specialised, "load", load)


def test_a_run_changes_over_when_its_loop_is_ready_and_keeps_its_bits(monkeypatch, capfd):
    """The loop is compiled, or read from disk, only after the first blocks of steps were taken by the generic one."""
    may_load, is_loaded, load, taken = threading.Event(), threading.Event(), Specialised.load, []

    def later(self):
        may_load.wait(60)
        load(self)
        is_loaded.set()

    def look(part):
        (found,) = specialise._made.values()
        taken.append(found.address > 0)
        if part > 0.01 and not may_load.is_set():
            may_load.set()
            assert is_loaded.wait(120)

    pays_at_once(monkeypatch, later)
    auto, system = ns.MoreauJean(dt=1e-3), rebounding_ball()
    own = ns.simulate(system, (0.0, 20.0), [1.0], [0.0], integrator=auto, progress=look)
    assert_same(own, run_of(system, GENERIC, ([1.0], [0.0]), 20.0))
    assert taken[0] is False and taken[-1] is True and "compiling a loop" not in capfd.readouterr().err


def test_a_run_does_not_wait_for_a_loop_that_cannot_be_compiled_beside_it(monkeypatch):
    def refuse(self):
        raise TypeError("no such thing")

    pays_at_once(monkeypatch, refuse)
    auto, system = ns.MoreauJean(dt=1e-3), rebounding_ball()
    for _ in range(3):
        assert_same(*(run_of(system, integrator, ([1.0], [0.0])) for integrator in (auto, GENERIC)))
        beside.finish()
    assert list(specialise._made.values()) == [None]


def test_a_compilation_beside_a_run_is_given_up_where_nobody_needs_it_any_more(monkeypatch):
    """At the end of the process, and before it is forked: it would hold numba's lock for ever."""
    steps = []

    def long(self):
        while True:
            beside.go_on()
            steps.append(time.sleep(0.01))

    pays_at_once(monkeypatch, long)
    run_of(rebounding_ball(), ns.MoreauJean(dt=1e-3), ([1.0], [0.0]))
    (found,) = specialise._made.values()
    assert found.is_begun
    if hasattr(os, "fork"):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # of a fork while threads run
            child = os.fork()
        if child == 0:
            os._exit(0)
        os.waitpid(child, 0)
    beside.finish()
    assert not found.is_begun and not found.address and steps
    beside.go_on()  # the thread that asks is none of these


@pytest.mark.parametrize(
    ("count", "busy", "expected"), [(1, 0.0, False), (2, 0.5, True), (2, 1.5, False), (8, 3, True)]
)
def test_a_processor_is_free_where_fewer_are_busy_than_there_are(monkeypatch, count, busy, expected):
    monkeypatch.setattr(os, "sched_getaffinity", lambda pid: set(range(count)), raising=False)
    monkeypatch.setattr(os, "getloadavg", lambda: (busy, 9.0, 9.0), raising=False)
    assert beside.has_free_processor() is expected


def test_what_cannot_be_compiled_is_told_where_it_was_asked_for(monkeypatch):
    def refuse(self):
        raise TypeError

    monkeypatch.setattr(specialise.Specialised, "load", refuse)
    with pytest.warns(ns.InterpretedWarning, match="cannot compile a loop for this system alone"):
        told = run_of(rebounding_ball(), OWN, ([1.0], [0.0]))
    assert_same(told, run_of(rebounding_ball(), GENERIC, ([1.0], [0.0])))
    monkeypatch.setattr(specialise, "_made", {})
    monkeypatch.setattr(specialise, "SAVED", 1.0)
    run_of(rebounding_ball(), ns.MoreauJean(dt=1e-3), ([1.0], [0.0]))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::nonsmooth.SimultaneousImpactWarning")  # of the slider-crank
@pytest.mark.parametrize("name", model_entries())
def test_every_model_keeps_its_bits(name):
    model = load_model(name)()
    both = [ns.MoreauJean(dt=model.dt, specialise=wish) for wish in (True, False)]
    assert_same(*(ns.simulate(model, (0.0, 500 * model.dt), *model.state(), integrator=one, on_failure="return")
                  for one in both))  # fmt: skip
