"""The benchmark compares like with like."""

import shutil

import pytest

from benchmarks import core


@pytest.mark.skipif(shutil.which("cc") is None and shutil.which("gcc") is None, reason="no C compiler")
def test_the_c_programs_take_the_same_steps(tmp_path):
    programs = core.compile_c(tmp_path)
    assert len(programs) == 2
    for program in programs.values():
        for steps in (300, 3000):
            assert abs(core.run_rod(steps)[1] - core.run_c(program, steps)[1]) < 1e-12


def test_the_import_takes_time():
    assert core.import_time() > 0
