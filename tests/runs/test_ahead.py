"""Runs that begin in the interpreter while their machine code is compiled elsewhere (runs/ahead.py)."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import nonsmooth as ns
from models import BeadChain, BouncingBall, PainleveRod, RockingBlock, SpragSlip, WallPendulum
from nonsmooth.jit import at_work, elsewhere, loading
from nonsmooth.jit.turns import in_turn
from nonsmooth.mechanics.model_system import as_system
from nonsmooth.runs import ahead, run
from nonsmooth.runs.simulate import simulate, simulate_at_once
from nonsmooth.runs.system_run import SystemRun

pytestmark = [
    pytest.mark.upkeep,
    pytest.mark.skipif(sys.platform == "win32", reason="nothing is compiled elsewhere there"),
]


class After:
    """In the place of processes that compile: done after so many looks."""

    def __init__(self, looks):
        self.looks, self.is_waited_for, self.is_left = looks, False, False

    @property
    def is_over(self):
        self.looks -= 1
        return self.looks < 0

    def wait(self):
        self.is_waited_for = True

    def leave(self):
        self.is_left = True


@pytest.fixture
def run_ahead(monkeypatch):
    """``run_ahead(looks, *arguments, **options)``: `simulate` with code that is there after so many looks."""

    def begin(looks, *arguments, **options):
        other = After(looks)
        monkeypatch.setattr(ahead, "compiled_elsewhere", lambda system, integrator: other)
        return simulate_at_once(*arguments, **options), other

    monkeypatch.setattr(SystemRun, "first_block", 7)
    monkeypatch.setattr(run, "LOOK_EVERY", 0.0)  # blocks of one step from there on
    return begin


def motion(model, t_end, integrator, **options):
    return (model, (0, t_end), *model.state()), dict(integrator=integrator, **options)


# impacts, friction, stick and slip, several contacts, bilateral ones, a start with two solutions
RUNS = {
    "ball": motion(BouncingBall(e=0.5), 0.6, ns.MoreauJean(1e-2)),
    "rod": ((PainleveRod(mu=1.6), (0, 0.05), *PainleveRod(mu=1.6).state(th=0.8, thdot=-1.0, slip=1.0)),
            dict(integrator=ns.MoreauJean(1e-3))),
    "pendulum": motion(WallPendulum(), 0.3, ns.MoreauJean(5e-3, projection=True), t_eval=np.linspace(0.05, 0.3, 9)),
    "sprag-slip": motion(SpragSlip(), 0.1, ns.MoreauJean(2e-3), every=3),
    "rocking block": motion(RockingBlock(), 0.3, ns.Adaptive(rtol=1e-5)),
    "sprag-slip, events": motion(SpragSlip(), 1.0, ns.EventDriven(1e-5, 1e-7)),
    "beads, events": motion(BeadChain(n=4), 0.01, ns.EventDriven(1e-5, 1e-7), every=2),
    "rocking block, springs": motion(RockingBlock(), 0.02, ns.Penalty(1e5, damping_ratio=0.5, rtol=1e-4, atol=1e-6)),
}  # fmt: skip


@pytest.mark.parametrize("looks", [1, 3, 10_000])
@pytest.mark.parametrize("name", RUNS)
def test_a_run_that_goes_ahead_has_the_bits_of_machine_code(name, looks, run_ahead, bits):
    arguments, options = RUNS[name]
    begun, other = run_ahead(looks, *arguments, **options)
    told = begun.about.pop("interpreted")
    whole = simulate(*arguments, **options)
    assert bits(begun) | {"is_compiled": True} == bits(whole)
    assert other.is_left and begun.stats.is_compiled == other.is_waited_for == (looks < 10_000)
    number = int(told.split(" steps")[0].split()[-1])
    assert number == whole.stats.steps if looks == 10_000 else 0 < number <= 7 + looks


def test_code_that_is_there_before_the_first_step_takes_all_of_them(run_ahead, bits):
    arguments, options = RUNS["ball"]
    begun, _ = run_ahead(0, *arguments, **options)
    assert bits(begun) == bits(simulate(*arguments, **options))  # and "interpreted" is no part of what is told


def test_a_run_of_which_much_is_left_waits_for_its_code(run_ahead, monkeypatch, bits):
    monkeypatch.setattr(ahead, "FIRST_GUESS", 0.0)
    monkeypatch.setattr(ahead, "LONGEST_LEFT", 0.0)
    arguments, options = RUNS["ball"]
    begun, other = run_ahead(10_000, *arguments, **options)
    assert other.is_waited_for and begun.about.pop("interpreted").startswith("the first 7 steps")
    assert bits(begun) == bits(simulate(*arguments, **options))


def test_blocks_that_are_long_to_copy_wait_for_their_code(run_ahead, monkeypatch):
    monkeypatch.setattr(ahead, "MOST_WORDS_KEPT", 1)
    arguments, options = RUNS["ball"]
    begun, other = run_ahead(10_000, *arguments, **options)
    assert other.is_waited_for and "interpreted" not in begun.about


def falling_into(what):
    """A ball whose force does something at 0.05 s that machine code and Python tell in different ways."""

    def mass(t, q, p, M):
        M[0, 0] = 1.0

    def force(t, q, u, p, h):
        h[0] = -9.81 if t < 0.05 else what(t)

    return ns.System(n_q=1, mass=mass, force=force)


def divide(t):
    return 1.0 / (int(t) * 1)  # Python raises, machine code has infinity


def nan(t):
    return float("nan")


@pytest.mark.parametrize("what", [divide, nan])
def test_what_fails_in_the_interpreter_fails_as_machine_code_does(what, run_ahead, bits):
    arguments = falling_into(what), (0, 0.1), [1.0], [0.0]
    options = dict(integrator=ns.MoreauJean(1e-3), on_failure="return")
    begun, other = run_ahead(10_000, *arguments, **options)
    assert begun.about.pop("interpreted").startswith("the first ") and other.is_waited_for
    whole = simulate(*arguments, **options)
    assert not whole.success and begun.message == whole.message and bits(begun) == bits(whole)


def test_ctrl_c_in_the_interpreter_stops_between_two_steps(run_ahead, monkeypatch):
    monkeypatch.setattr(SystemRun, "first_block", 1)

    def force(t, q, u, p, h):
        h[0] = -9.81
        if t > 0.05:
            os.kill(os.getpid(), signal.SIGINT)

    def mass(t, q, p, M):
        M[0, 0] = 1.0

    system = ns.System(n_q=1, mass=mass, force=force)
    stopped, _ = run_ahead(10_000, system, (0, 0.1), [1.0], [0.0], integrator=ns.MoreauJean(1e-2))
    assert stopped.status == ns.Status.INTERRUPTED
    t = stopped.t[-1]  # a fall with theta = 1/2 is exact but for rounding
    assert 0.05 < t < 0.07 and stopped.q[-1, 0] == pytest.approx(1.0 - 0.5 * 9.81 * t * t, rel=1e-13)


# who goes ahead


@pytest.fixture
def cold(monkeypatch, tmp_path):
    """A machine that has compiled nothing yet."""
    monkeypatch.delenv("NONSMOOTH_INTERPRET", raising=False)
    monkeypatch.setenv("NONSMOOTH_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr("nonsmooth.jit.kernels.Kernel.is_loaded", property(lambda kernel: False))
    begun = []

    def start_process(pipes, kernels):
        begun.append(list(in_turn(pipes[:1], kernels)))
        return subprocess.Popen([sys.executable, "-c", "import sys; sys.stdin.read()"], stdin=subprocess.PIPE)

    monkeypatch.setattr(elsewhere, "start_process", start_process)
    monkeypatch.setattr(elsewhere, "may_start_process", lambda: True)
    return begun


def end(other):
    for process in other._processes:
        process.stdin.close()
        process.wait()


def test_each_entry_point_is_compiled_once_and_a_second_command_begins_none(cold):
    integrator, system = ns.MoreauJean(1e-3), as_system(SpragSlip())
    first = ahead.compiled_elsewhere(system, integrator)
    assert sorted(map(id, sum(cold, []))) == sorted(map(id, integrator.entry_points(system)))
    second, number = ahead.compiled_elsewhere(system, integrator), len(cold)
    assert not first.is_over and not second.is_over and len(cold) == number
    end(first)
    assert first.is_over and second.is_over
    second.wait()
    end(ahead.compiled_elsewhere(system, integrator))
    assert len(cold) == 2 * number


def test_what_is_not_of_this_package_is_compiled_first(cold):
    own = ns.System(n_q=1, mass=lambda t, q, p, M: None, force=lambda t, q, u, p, h: None)
    assert ahead.compiled_elsewhere(own, ns.MoreauJean(1e-3)) is None and not cold


@pytest.mark.parametrize("wish", ["0", "1"])
def test_who_asks_for_one_of_the_two_gets_it(cold, wish, monkeypatch):
    monkeypatch.setenv("NONSMOOTH_INTERPRET", wish)
    assert ahead.compiled_elsewhere(as_system(SpragSlip()), ns.MoreauJean(1e-3)) is None and not cold


is_told = pytest.mark.skipif(not os.path.exists("/proc/self/stat"), reason="the system tells of no processes of others")


@is_told
def test_nobody_waits_for_processes_that_were_stopped(cold):
    integrator, system = ns.MoreauJean(1e-3), as_system(SpragSlip())
    first = ahead.compiled_elsewhere(system, integrator)
    second, number = ahead.compiled_elsewhere(system, integrator), len(cold)
    for process in first._processes:
        os.kill(process.pid, signal.SIGSTOP)
        while not at_work.is_stopped(process.pid):
            time.sleep(0.01)
    assert first.is_over and second.is_over
    third = ahead.compiled_elsewhere(system, integrator)
    assert len(cold) == 2 * number and not third.is_over
    for process in first._processes:
        os.kill(process.pid, signal.SIGCONT)
    end(first)
    end(third)
    assert first.is_over and second.is_over and third.is_over


@is_told
def test_a_compilation_waits_for_no_helper_that_was_stopped():
    with subprocess.Popen([sys.executable, "-c", "import sys; sys.stdin.read()"], stdin=subprocess.PIPE) as helper:
        os.kill(helper.pid, signal.SIGSTOP)
        began = time.monotonic()
        loading.wait_for(helper, began + 60.0)
        assert time.monotonic() - began < 30.0 and helper.poll() is None
        os.kill(helper.pid, signal.SIGCONT)


@is_told
def test_a_process_is_known_again_by_its_number_and_its_start():
    sign = at_work.sign_of(os.getpid())
    assert at_work.is_at_work(sign) and not at_work.is_stopped(os.getpid())
    others = (sign + "0", f"{os.getppid()} {sign.split()[1]}0", sign.split()[0], "", "no number 1", f"-{sign}", "1 2 3")
    assert not any(map(at_work.is_at_work, others))
    gone = subprocess.Popen([sys.executable, "-c", ""])
    sign = at_work.sign_of(gone.pid)
    gone.wait()
    assert not at_work.is_at_work(sign) and at_work.sign_of(gone.pid) == ""


def removed(folder, note):
    shutil.rmtree(folder)


def replaced_by_a_file(folder, note):
    shutil.rmtree(folder)
    folder.write_text("")


def note_is_removed(folder, note):
    note.unlink()


def note_is_a_folder(folder, note):
    note.unlink()
    note.mkdir()


def note_is_a_pipe(folder, note):
    note.unlink()
    os.mkfifo(note)


def note_is_another(folder, note):
    note.write_bytes(bytes(range(256)) * 64)


SPOILT = [removed, replaced_by_a_file, note_is_removed, note_is_a_folder, note_is_a_pipe, note_is_another]


@pytest.mark.parametrize("spoil", SPOILT)
def test_whatever_becomes_of_the_folder_a_run_goes_on(spoil, cold, tmp_path, capsys):
    """Without the note a second command begins processes of its own, and waits for nobody else."""
    integrator, system = ns.MoreauJean(1e-3), as_system(SpragSlip())
    first = ahead.compiled_elsewhere(system, integrator)
    second, number = ahead.compiled_elsewhere(system, integrator), len(cold)
    spoil(tmp_path / "cache", tmp_path / "cache" / elsewhere.NOTE)
    assert not first.is_over and second.is_over
    second.wait()
    third = ahead.compiled_elsewhere(system, integrator)
    assert (third is None and len(cold) == number) if spoil is replaced_by_a_file else len(cold) == 2 * number
    for each in filter(None, (first, third)):
        end(each)
        assert each.is_over


@pytest.mark.parametrize("how", ["once", *(pytest.param(how, marks=pytest.mark.slow)
                                           for how in ("again and again", "replaced by a file"))])  # fmt: skip
def test_a_command_whose_cache_is_removed_ends_well(how, tmp_path):
    """What cannot be kept is compiled by the command itself; it waits for its code, since much is left of its run."""
    cache = tmp_path / "cache"
    environment = {**os.environ, "NONSMOOTH_CACHE_DIR": str(cache)}
    environment.pop("NONSMOOTH_INTERPRET", None)
    command = [sys.executable, "-m", "nonsmooth", "run", "bouncing-ball", "--t-end", "400", "--no-plot", "--quiet"]
    with subprocess.Popen(command, env=environment, stderr=subprocess.PIPE, text=True, cwd=tmp_path) as process:
        while not cache.exists() and process.poll() is None:
            time.sleep(0.01)
        time.sleep(0.2)
        shutil.rmtree(cache, ignore_errors=True)
        if how == "replaced by a file":
            cache.write_text("")
        while how == "again and again" and process.poll() is None:
            shutil.rmtree(cache, ignore_errors=True)
            time.sleep(0.02)
        said = process.stderr.read()
    assert process.returncode == 0 and "Traceback" not in said, said


@pytest.mark.parametrize("begin, asks", [(simulate, False), (simulate_at_once, True)])
def test_only_who_waits_for_one_run_goes_ahead(begin, asks, monkeypatch):
    asked = []
    monkeypatch.setattr(ahead, "compiled_elsewhere", lambda system, integrator: asked.append(system))
    arguments, options = RUNS["ball"]
    assert begin(*arguments, **options).stats.is_compiled and bool(asked) == asks


def test_a_first_command_ends_before_its_code_is_there_and_leaves_it_for_the_next(tmp_path):
    """Of a whole process: the same figures, and machine code some seconds later."""
    environment = {**os.environ, "NONSMOOTH_CACHE_DIR": str(tmp_path / "cache")}
    environment.pop("NONSMOOTH_INTERPRET", None)
    command = [sys.executable, "-m", "nonsmooth", "run", "bouncing-ball", "--no-plot", "--json"]

    def told():
        done = subprocess.run(command, env=environment, capture_output=True, text=True, cwd=tmp_path)
        assert done.returncode == 0 and done.stderr == "", done.stderr
        return json.loads(done.stdout)

    first = told()
    assert first["about"].pop("interpreted").startswith("all ") and not first["stats"]["is_compiled"]
    elsewhere.Elsewhere(tmp_path / "cache" / elsewhere.NOTE, []).wait()
    environment["NONSMOOTH_QUIET"] = "1"  # the model is compiled now
    second = told()
    assert second["stats"]["is_compiled"]
    for each in (first, second):
        for of_the_clock in ("wall_time", "compile_time", "is_compiled"):
            del each["stats"][of_the_clock]
    assert first == second
