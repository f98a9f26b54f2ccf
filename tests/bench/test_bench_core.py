"""The benchmark compares like with like."""

import shutil

import pytest

from nonsmooth.bench import core


@pytest.mark.skipif(shutil.which("cc") is None and shutil.which("gcc") is None, reason="no C compiler")
def test_the_c_program_takes_the_same_steps(tmp_path):
    program = core.compile_c(tmp_path)
    for steps in (300, 3000):
        assert abs(core.run_rod(steps)[1] - core.run_c(program, steps)[1]) < 1e-12
