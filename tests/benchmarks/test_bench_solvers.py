"""The page of the solvers compares answers that are right."""

import numpy as np
import pytest

from benchmarks import lcp_times, solvers
from benchmarks.problems import frictional_lcp, frictionless_lcp
from nonsmooth.lcp.solve import solve_lcp


@pytest.mark.parametrize("n", [3, 24])
def test_everything_that_is_timed_solves_the_problem(n):
    A, b = solvers.batch(frictionless_lcp, n, 3)
    for k in range(3):
        expected = solve_lcp(A[k], b[k])
        assert expected.success
        bound = np.linalg.norm(np.linalg.inv(A[k]), np.inf)
        for z, tolerance in [(lcp_times.pivoting_in_numpy(A[k], b[k]), 1e-12), (lcp_times.by_osqp(A[k], b[k]), 1e-7)]:
            np.testing.assert_allclose(z, expected.z, rtol=0, atol=tolerance * bound * max(1.0, np.abs(b[k]).max()))


def test_a_wrong_answer_is_counted_as_a_failure():
    A, b = solvers.batch(frictional_lcp, 8, 5)
    z = solvers.by_lemke(A, b)
    assert solvers.misses(A, b, z) == 0
    z[2] *= 1.001
    assert solvers.misses(A, b, z) == 1


def test_a_table_has_one_line_a_row():
    lines = list(solvers.table("n", (3, 6), {"a": [1, 2], "b": ["x", "y"]}))
    assert lines == ["| n | a | b |", "|---|---|---|", "| 3 | 1 | x |", "| 6 | 2 | y |"]
