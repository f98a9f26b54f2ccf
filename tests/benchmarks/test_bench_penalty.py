"""The benchmark of compliant contact compares runs of the same motion at equal error."""

import math

import numpy as np

from benchmarks import penalty
from benchmarks.penalty import Figures


def test_every_motion_is_the_same_by_another_method():
    for case in penalty.cases().values():
        exact, _, _ = penalty.compiled_run(case, 1e-10)
        assert penalty.measure(case, "compiled", 1e-8, exact).error < 1e-5 * np.abs(exact).max()
        assert penalty.measure(case, "LSODA", 1e-8, exact).error < 1e-5 * np.abs(exact).max()


def test_costs_are_read_off_at_equal_error_on_a_log_scale():
    own = [Figures(1.0, 1, 10, 1e-4), Figures(4.0, 1, 160, 1e-8)]
    assert math.isclose(penalty.cost_for(1e-6, own), 2.0) and math.isclose(
        penalty.cost_for(1e-6, own, "evaluations"), 40.0
    )
    assert math.isclose(penalty.cost_for(1e-12, own), 4.0) and math.isclose(penalty.cost_for(1.0, own), 1.0)
