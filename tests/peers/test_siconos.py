"""Siconos and we agree wherever both have found the one solution."""

import numpy as np
import pytest

from benchmarks import siconos
from benchmarks.problems import frictionless_lcp
from benchmarks.solvers import batch
from nonsmooth.lcp.solve import solve_lcp

pytestmark = [
    pytest.mark.peers,
    pytest.mark.skipif(siconos.interpreter() is None, reason="no Siconos (Debian: apt-get install python3-siconos)"),
]


@pytest.mark.parametrize("n", [3, 12, 48])
def test_siconos_finds_the_solution_of_a_definite_problem_too(n):
    A, b = batch(frictionless_lcp, n, 10)
    for answers in siconos.solve_lcps([(A, b)]).values():
        for k, z in enumerate(answers[0].z):
            ours = solve_lcp(A[k], b[k])
            assert ours.success
            # |z - z*| <= |A^-1| |residual|; Siconos stops at 1e-12 or better after pivots that round in n steps
            bound = 1e-10 * np.abs(b[k]).max() * np.linalg.norm(np.linalg.inv(A[k]), np.inf)
            np.testing.assert_allclose(z, ours.z, atol=bound, rtol=0)
