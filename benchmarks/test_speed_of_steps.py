"""Time of many Moreau–Jean steps: the rod, the belt, and rows of 2, 6 and 12 sliding blocks."""

import pytest

from benchmarks.core import ROD_STEPS, STEPS, run_model, run_rod, run_row


def test_sliding_rod(benchmark):
    benchmark.extra_info["steps"] = ROD_STEPS
    benchmark(run_rod, ROD_STEPS)


def test_belt_oscillator_in_its_stick_slip_cycle(benchmark):
    benchmark.extra_info["steps"] = STEPS
    benchmark(run_model, "belt-oscillator", False)


@pytest.mark.parametrize("n", [2, 6, 12])
def test_row_of_sliding_blocks(benchmark, n):
    benchmark.extra_info["steps"] = STEPS
    benchmark(run_row, n)
