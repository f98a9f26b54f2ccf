"""What compiles says so: once for all that is compiled together, and nothing where nobody waits."""

import time

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.integrators.assembly import step
from nonsmooth.jit import Kernel, cache, loading
from nonsmooth.jit.waiting import ERASED, sentence, waiting
from nonsmooth.scenes.find_contacts import find_contacts


@pytest.fixture
def impatient(monkeypatch):
    monkeypatch.setenv("NONSMOOTH_QUIET", "0")
    monkeypatch.setattr("nonsmooth.jit.waiting.SILENT_TIME", 0.01)
    monkeypatch.setattr("os.getloadavg", lambda: (0.0, 0.0, 0.0))


def long_wait(words):
    with waiting(lambda: words):
        time.sleep(0.2)


def test_a_wait_within_a_wait_is_said_once(impatient, capsys):
    with waiting(lambda: "outer"):
        long_wait("inner")
        long_wait("inner")
    assert capsys.readouterr().err == "outer\n"
    long_wait("another")
    assert capsys.readouterr().err == "another\n"


def test_a_short_wait_and_a_quiet_one_say_nothing(impatient, monkeypatch, capsys):
    monkeypatch.setattr("nonsmooth.jit.waiting.SILENT_TIME", 10.0)
    long_wait("short")
    monkeypatch.setattr("nonsmooth.jit.waiting.SILENT_TIME", 0.01)
    monkeypatch.setenv("NONSMOOTH_QUIET", "1")
    long_wait("quiet")
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(("running", "said"), [
    (0.5, "about 20 s; kept"), (7.0, "about 40 to 80 s (20 s if nothing else ran); kept"),
])  # fmt: skip
def test_the_time_that_is_said_takes_the_load_of_the_machine_into_account(running, said, monkeypatch):
    monkeypatch.setattr("os.getloadavg", lambda: (running, 0.0, 0.0))
    monkeypatch.setattr("os.cpu_count", lambda: 4)
    assert said in sentence("it", "new", 20.0, "here")


def test_in_a_terminal_the_seconds_move_and_are_taken_away(impatient, monkeypatch, capsys):
    monkeypatch.setattr("nonsmooth.jit.waiting.TICK", 0.02)
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    long_wait("words")
    first, *moved = capsys.readouterr().err.split(ERASED)
    assert first == "words\n" and len(moved) >= 3 and set(moved) == {"0 s", ""} and moved[-1] == ""


def test_a_wait_that_fails_is_over(impatient, capsys):
    with pytest.raises(ZeroDivisionError), waiting(lambda: "late"):
        raise ZeroDivisionError
    time.sleep(0.1)
    assert capsys.readouterr().err == ""
    long_wait("next")
    assert capsys.readouterr().err == "next\n"


def test_a_new_model_says_which_functions_compile_and_one_that_is_known_nothing(impatient, capsys):
    def mass(t, q, p, M):
        M[0, 0] = 1.25

    def force(t, q, u, p, h):
        h[0] = -9.75 + 0.015625 * NUMBER

    def run():
        ns.simulate(ns.System(n_q=1, mass=mass, force=force), (0, 0.1), [1], [0], integrator=ns.MoreauJean(dt=0.1))

    NUMBER = float(time.time_ns() % 2**40)  # no earlier run compiled this one
    ns.simulate(ns.System(n_q=1, mass=mass, force=lambda t, q, u, p, h: None), (0, 0.1), [1], [0],
                integrator=ns.MoreauJean(dt=0.1))  # fmt: skip
    capsys.readouterr()
    run()
    said = capsys.readouterr().err
    assert said.startswith("nonsmooth: compiling the model functions mass, force (new, or changed), about 2 s; kept in")
    assert said.count("\n") == 1
    run()
    assert capsys.readouterr().err == ""


def test_a_scene_that_compiles_says_it_once_with_the_reason(impatient, monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(Kernel, "is_loaded", False)
    monkeypatch.setattr(Kernel, "is_on_disk", False)
    monkeypatch.setattr(cache, "cache_directory", lambda: tmp_path)

    def compile_one(entry_points, missing):
        (tmp_path / f"{step.stages_of(2, has_restitution=False).take.kept_name}-0123.code").write_bytes(b"")
        time.sleep(0.2)

    monkeypatch.setattr(loading, "_load", compile_one)
    step.stages_of(2, has_restitution=False).load()
    said = capsys.readouterr().err
    assert said.count("compiling") == 1
    assert "functions of assembly (first use on this machine)" in said
    step.stages_of(2, has_restitution=False).load()
    assert "(changed since, or another version of something beneath)" in capsys.readouterr().err


def test_the_time_that_is_said_grows_with_the_code(impatient):
    few, many = step.stages_of(2, has_restitution=False), step.stages_of(3, has_restitution=True)
    seconds = [
        float(loading.words_for(kernels, loading.shares(kernels, 2)).split("about ")[1].split(" s")[0])
        for stages in (few, many)
        for kernels in [[stages.take, stages.find, *stages.others]]
    ]
    assert 5 < seconds[0] < seconds[1] < 300
    assert np.isfinite(seconds).all()


def test_a_function_of_one_room_is_no_reason_for_that_of_another(monkeypatch, tmp_path):
    monkeypatch.setattr(cache, "cache_directory", lambda: tmp_path)
    planar, spatial = find_contacts[2], find_contacts[3]
    (tmp_path / f"{spatial.kept_name}-0123.code").write_bytes(b"")
    assert planar.kept_name.endswith(".find_contacts") and spatial.kept_name.endswith(".find_contacts")
    assert "first use" in cache.words_of([planar.kept_name], 1.0)
    assert "changed since" in cache.words_of([spatial.kept_name], 1.0)
