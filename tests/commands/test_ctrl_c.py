"""Ctrl-C: every command ends soon, with its code and in one line, and what was cut is no result."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import nonsmooth as ns
from models import SpragSlip
from nonsmooth.commands.watch import is_compiling
from nonsmooth.studies.comparison import ComparisonTask

pytestmark = pytest.mark.upkeep

pytest.importorskip("xarray")

PROMPT = 1.0  # s: half a second is promised, of a machine that nobody else works on
LONG = ["--every", "10000000", "--no-plot"]  # 20 s of the fastest loop, 1e9 steps
COMMANDS = [
    ["run", "bouncing-ball", "--t-end", "1e6", *LONG],
    ["run", "sprag-slip", "--integrator", "penalty", "--stiffness", "1e8", "--t-end", "1e5", *LONG],
    ["map", "slider-crank", "--axis", "mu=0.1:0.9:400", "e=0.1:0.9:400", "--workers", "2"],
    ["sweep", "painleve-rod", "--axis", "mu=0:2:400", "th=0.1:1.5:400", "--measure", "paradoxes", "--dt", "1e-5"],
    ["study", "penalty", "sprag-slip", "--stiffness", "1e11", "1e12", "--no-plot"],
    ["study", "stability", "sprag-slip", "--axis", "mu=0.5:2:400", "kth=500:2000:400", "--no-plot"],
]
MOMENTS = [pytest.param(seconds, marks=() if seconds == 2.0 else pytest.mark.slow) for seconds in (0.15, 0.8, 2.0, 6.0)]


@pytest.mark.parametrize("after", MOMENTS)
@pytest.mark.parametrize("words", COMMANDS, ids=lambda words: " ".join(words[:2]))
def test_a_command_ends_soon_after_ctrl_c(words, after, tmp_path):
    assert_ends_soon(["nonsmooth", *words], after, tmp_path)


@pytest.mark.parametrize("after", MOMENTS[:-1])  # the last one comes when it is done
def test_a_large_map_ends_soon_after_ctrl_c(after, tmp_path):
    """6e6 states, 5 s of two processors, which it saves: it is to be there still when Ctrl-C comes."""
    axes = ("mu=0.5:2:2500", "th=0.1:1.5:2500")
    assert_ends_soon(["nonsmooth", "map", "sprag-slip", "--axis", *axes, "--workers", "2"], after, tmp_path)


@pytest.mark.parametrize("after", MOMENTS)
def test_a_benchmark_ends_soon_after_ctrl_c(after, tmp_path):
    assert_ends_soon(["benchmarks", "stability"], after, tmp_path)


def assert_ends_soon(words, after, folder):
    program = subprocess.Popen(
        [sys.executable, "-m", *words], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True, env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
    )  # fmt: skip
    time.sleep(after)
    began = time.perf_counter()
    program.send_signal(signal.SIGINT)
    try:
        _, said = program.communicate(timeout=60)
    finally:
        program.kill()
    assert program.returncode == 130 and "nonsmooth: interrupted" in said and "Traceback" not in said, said
    assert time.perf_counter() - began < PROMPT


def test_ctrl_c_after_the_last_word_changes_no_exit_code():
    """It comes among what is done at exit, and when the interpreter has given its handlers back."""
    code = """
import atexit, os, signal, sys
class Left:
    def __del__(self, kill=os.kill, process=os.getpid(), number=signal.SIGINT): kill(process, number)
left = sys.left = Left()
atexit.register(signal.raise_signal, signal.SIGINT)
sys.argv = ["nonsmooth", *sys.argv[1:]]
from nonsmooth.__main__ import nonsmooth
nonsmooth()
"""
    for words, expected in ((["list"], 0), (["run", "nobody"], 2)):
        ended = subprocess.run([sys.executable, "-c", code, *words], capture_output=True, text=True, timeout=60)
        assert ended.returncode == expected and "KeyboardInterrupt" not in ended.stderr, ended


def test_nothing_is_raised_within_a_compilation():
    """Its frames are those of the compiler; a compiled function has none, so that its caller is free."""
    frame = {"__name__": "numba.core.compiler"}
    exec("import sys\ndef called(): return sys._getframe()", frame)  # noqa: S102
    assert is_compiling(frame["called"]()) and not is_compiling(sys._getframe())


def cut_at(k, monkeypatch):
    """Ctrl-C some way into the first run of the k-th cell."""
    measured, run = [], ComparisonTask.measure

    def measure(task, integrator):
        measured.append(integrator)
        if len(measured) == k:
            signal.setitimer(signal.ITIMER_REAL, 0.05)
        return run(task, integrator)

    monkeypatch.setattr(ComparisonTask, "measure", measure)
    signal.signal(signal.SIGALRM, lambda *_: signal.raise_signal(signal.SIGINT))


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="an alarm stands for the user")
def test_a_run_that_ctrl_c_cut_is_no_number_and_not_in_the_journal(tmp_path, monkeypatch):
    """The last of the three runs vibrates: it takes 70 000 steps, 0.4 s; Ctrl-C comes after 0.05 s."""
    rod, journal = SpragSlip(), tmp_path / "j.jsonl"
    start, options = rod.state(th=0.78, thdot=1.0), {"beside": [], "progress": False}

    def study(**more):
        return ns.penalty_study(rod, (0, 0.3), *start, stiffness=[1e5, 1e6, 1e8], **options, **more)

    whole = study()
    with monkeypatch.context() as patch:
        cut_at(3, patch)
        cut = study(journal=journal)
    assert cut.is_interrupted and np.isnan(cut.errors("error_q")).tolist() == [False, False, True]
    assert "not run" in cut.table() and "interrupted: 2 of 3 runs are finished" in cut.table()
    assert len(Path(journal).read_text().splitlines()) == 1 + 2  # its heading, and what was finished
    resumed = study(journal=journal)
    assert not resumed.is_interrupted and resumed.data.attrs["cells_from_journal"] == 2
    assert resumed.errors("error_q").tolist() == whole.errors("error_q").tolist()
