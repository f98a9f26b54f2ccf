"""Time of what a user waits for beside the steps: a call, an import, the help text, a first run from the disk cache."""

import math
import subprocess
import sys

import pytest

import nonsmooth as ns
from benchmarks.core_scenes import sliding_rod

COMMANDS = {
    "an empty interpreter": "pass",
    "import nonsmooth": "import nonsmooth",
    "nonsmooth --help": "from nonsmooth.commands.cli import main; main(['--help'])",
    "nonsmooth list": "from nonsmooth.commands.cli import main; main(['list'])",
    "a run of one step": (
        "from nonsmooth.commands.cli import main; main('run bouncing-ball --t-end 1e-3 --no-plot'.split())"
    ),
}


def test_one_simulate_call_of_one_step(benchmark):
    system, integrator, th = sliding_rod(), ns.MoreauJean(dt=1e-3), math.pi / 3
    benchmark(ns.simulate, system, (0, 1e-3), [0, math.sin(th), th], [1, 0, 0], integrator=integrator)


@pytest.mark.parametrize("code", COMMANDS.values(), ids=COMMANDS.keys())
def test_a_fresh_interpreter(benchmark, code):
    command = [sys.executable, "-c", code]
    benchmark.pedantic(subprocess.run, (command,), {"capture_output": True, "check": True}, rounds=5, warmup_rounds=1)
