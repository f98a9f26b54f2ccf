"""Entry points that are loaded when a loop first comes to them: then, once, with the bits of those loaded before."""

import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.catalogue import BilateralRod, RockingBlock
from nonsmooth.errors import NonsmoothError
from nonsmooth.jit import Callback, cache, interpreted, kernel, late, late_kernel, running_time, waited
from nonsmooth.jit.kernels import called_by, reaches_late
from nonsmooth.jit.late import stopped_clock

STEP = "int64(int64, float64[::1])"


@late_kernel(STEP)
def seldom(k, x):
    x[0] += 2.0 * k
    return k + 1


@kernel
def between(k, x):
    return seldom(k, x) + 1


@kernel(STEP)
def counts(n, x):
    total = 0
    for k in range(n):
        x[0] += 1.0
        if k == 5:
            total += between(k, x)
    return total


def test_it_is_compiled_when_a_loop_comes_to_it_and_kept(tmp_path, monkeypatch):
    monkeypatch.setenv("NONSMOOTH_CACHE_DIR", str(tmp_path / "cache"))
    x, y = np.zeros(1), np.zeros(1)
    assert counts(5, x) == 0 and x[0] == 5.0
    assert not seldom.is_loaded and not list(cache.cache_directory().glob("*.seldom-*"))
    before, clock, began = waited(), running_time(), time.perf_counter()
    assert counts(7, x) == 7 and x[0] == 5.0 + 7.0 + 10.0
    assert seldom.is_loaded and len(list(cache.cache_directory().glob("*.seldom-*"))) == 1
    passed, waiting = time.perf_counter() - began, waited() - before
    assert 0.0 < waiting < passed and running_time() - clock < passed - 0.5 * waiting  # the clock of a run stood still
    assert counts(7, y) == 7 == interpreted(counts)(7, np.zeros(1)) and waited() - before == waiting


@late_kernel(STEP)
def asked_twice(k, x):
    return k


@kernel(STEP)
def asks(n, x):
    return asked_twice(n, x)


def test_two_threads_that_come_to_it_at_once_load_it_once(monkeypatch):
    asks.load()
    loads, load = [], asked_twice.load

    def slow_load():
        if not asked_twice.is_loaded:
            loads.append(threading.get_ident())
            time.sleep(0.2)  # in which the other one comes as well
        load()

    slot = next(at for at, (name, _) in late._loaders.items() if name == "asked_twice")
    monkeypatch.setitem(late._loaders, slot, ("asked_twice", slow_load))
    answers = []
    both = [threading.Thread(target=lambda k=k: answers.append(asks(k, np.zeros(1)))) for k in (3, 4)]
    for thread in both:
        thread.start()
    for thread in both:
        thread.join()
    assert sorted(answers) == [3, 4] and len(loads) == 1


@late_kernel(STEP)
def refused(k, x):
    return k + unknown  # noqa: F821


@kernel
def before_it(k, x):
    x[0] = 1.0
    answer = refused(k, x)
    x[0] = 2.0
    return answer


@kernel(STEP)
def comes_to_it(n, x):
    return before_it(n, x)


@kernel(STEP)
def comes_to_it_by_an_entry_point(n, x):
    answer = comes_to_it(n, x)
    x[0] = 3.0
    return answer


@pytest.mark.parametrize("loop", [comes_to_it, comes_to_it_by_an_entry_point])
def test_one_that_cannot_be_compiled_ends_the_loop_in_one_sentence(loop):
    x = np.zeros(1)
    comes_to_it.load()
    with pytest.raises(
        NonsmoothError, match=r"^the run has come to refused, which cannot be .*'unknown' is not"
    ) as told:
        loop(1, x)
    assert "\n" not in str(told.value) and x[0] == 1.0  # nothing was done after it


@late_kernel(STEP)
def interrupted(k, x):
    return k


@kernel(STEP)
def goes_on(n, x):
    answer = interrupted(n, x)
    x[0] = 1.0
    return answer


def test_ctrl_c_meanwhile_is_raised_once_the_loop_has_come_back(monkeypatch):
    goes_on.load()
    slot = next(at for at, (name, _) in late._loaders.items() if name == "interrupted")

    def load():
        signal.raise_signal(signal.SIGINT)
        interrupted.load()

    monkeypatch.setitem(late._loaders, slot, ("interrupted", load))
    x = np.zeros(1)
    with pytest.raises(KeyboardInterrupt):
        goes_on(1, x)
    assert interrupted.is_loaded and x[0] == 1.0


def test_only_what_may_come_to_one_hands_its_exception_on():
    from nonsmooth.integrators.moreau_jean.step import step
    from nonsmooth.integrators.rigid.rates import rigid_forces

    assert reaches_late(counts) and reaches_late(rigid_forces) and not reaches_late(step)


# in runs


RUN = """
import sys
import numpy as np
import nonsmooth as ns
from nonsmooth.catalogue import BilateralRod
from nonsmooth.integrators.adaptive.through import step_through

rod = BilateralRod()
if sys.argv[1] == "before":
    step_through.load()
before = step_through.is_loaded
found = ns.simulate(rod, (0, rod.t_end), *rod.state(), integrator=ns.Adaptive(), on_failure="return")
print(before, step_through.is_loaded)
print(b"".join(np.ascontiguousarray(each).tobytes() for each in (found.t, found.q, found.u, found.P_N)).hex())
"""


def test_a_run_has_the_bits_of_one_with_all_loaded_before():
    done = [
        subprocess.run([sys.executable, "-c", RUN, case], capture_output=True, text=True, timeout=600, env=os.environ)
        for case in ("before", "late")
    ]
    first, second = (each.stdout.splitlines() for each in done)
    assert first[0].startswith("True True") and second[0].startswith("False True"), done[1].stderr
    assert first[1] == second[1]


def test_a_sweep_over_processes_has_the_values_of_one_process():
    task = ns.RunTask(BilateralRod(), t_span=(0.0, BilateralRod.t_end), integrator=ns.Adaptive())
    here, elsewhere = (ns.sweep(task, {"mu": [1.5, 2.0, 2.5]}, workers=n, progress=False) for n in (1, 2))
    assert here.identical(elsewhere)


@pytest.mark.parametrize("integrator", [ns.EventDriven(), ns.Adaptive(), ns.MoreauJean(dt=1e-3)])
def test_what_a_run_of_two_contacts_may_come_to_is_loaded_before_it_or_late(integrator):
    loaded = integrator.entry_points(RockingBlock().system())
    below = set().union(*map(entry_points_below, loaded)) - set(loaded)
    named = {entry.__name__ for entry in below if not entry.is_late}
    # of laws of impact and systems of other kinds, of options, and what is loaded where a step was not solved
    others = {"strike", "spring_back", "collide_in_space", "solve_spatial"}
    assert named <= {*others, "solve_by_newton", "project", "enumerate_redundant"}
    assert {entry.__name__ for entry in loaded if entry.is_late} == set()


def entry_points_below(entry):
    """The entry points that one calls itself, or by the kernels in it."""
    found, open_ends, below = {entry}, [entry], set()
    while open_ends:
        for other in called_by(open_ends.pop()) - found:
            found.add(other)
            if other.signature is None:
                open_ends.append(other)
            elif not isinstance(other, Callback):
                below.add(other)
    return below


def test_what_is_compiled_within_a_run_is_no_part_of_its_clock():
    """Also where one wait is within another."""
    began, first = running_time(), waited()
    with stopped_clock():
        time.sleep(0.1)
        with stopped_clock():
            time.sleep(0.2)
    assert running_time() - began < 0.1 and 0.3 < waited() - first < 1.0
