"""The benchmark compares like with like."""

import math
import shutil

import pytest

import nonsmooth as ns
from benchmarks import core
from benchmarks.core_scenes import sliding_rod


@pytest.mark.skipif(shutil.which("cc") is None and shutil.which("gcc") is None, reason="no C compiler")
def test_the_c_programs_take_the_same_steps(tmp_path):
    programs = core.compile_c(tmp_path)
    assert len(programs) == 4
    for steps in (300, 3000):
        for program in programs.values():
            assert abs(core.run_rod(steps)[1] - core.run_c(program, steps)[1]) < 1e-12


@pytest.mark.skipif(shutil.which("cc") is None and shutil.which("gcc") is None, reason="no C compiler")
def test_the_c_programs_that_book_as_much_book_the_same_work_of_friction(tmp_path):
    programs, th = core.compile_c(tmp_path), math.pi / 3
    integrator = ns.MoreauJean(dt=core.SPAN / 3000)
    whole = ns.simulate(sliding_rod(), (0, core.SPAN), [0, math.sin(th), th], [1, 0, 0], integrator=integrator)
    for name, program in programs.items():
        expected = whole.ledger["friction"][-1] if "books" in name else 0.0
        assert core.run_c(program, 3000)[2] == pytest.approx(expected, rel=1e-12)


def test_the_import_takes_time():
    assert core.import_time() > 0
