"""Siconos on complementarity problems, run by the Python that has it (Debian: python3-siconos).

    python3 siconos_lcp.py problems.npz answers.npz

problems: A_0 (count, n, n), b_0 (count, n), A_1, ...; answers: for each solver and each k the solutions SOLVER_z_k
(count, n) and the least time of some repeats SOLVER_time_k (count,) in seconds, the call from Python included.
"""

import sys
import time

import numpy as np
import siconos.numerics as numerics

REPEATS = 5
SOLVERS = {
    "lemke": (numerics.lcp_lexicolemke, numerics.SICONOS_LCP_LEMKE),
    "pivot": (numerics.lcp_pivot, numerics.SICONOS_LCP_PIVOT),
}


def solve(A, b, name):
    """The solution and the least time."""
    function, code = SOLVERS[name]
    problem, options = numerics.LCP(np.asfortranarray(A), b), numerics.SolverOptions(code)
    least = np.inf
    for _ in range(REPEATS):
        z, w = np.zeros(len(b)), np.zeros(len(b))
        start = time.perf_counter()
        function(problem, z, w, options)
        least = min(least, time.perf_counter() - start)
    return z, least


def main(source, target):
    """Solve every problem with every solver."""
    problems, answers = np.load(source), {}
    for k in range(len(problems.files) // 2):
        for name in SOLVERS:
            pairs = [solve(A, b, name) for A, b in zip(problems[f"A_{k}"], problems[f"b_{k}"], strict=True)]
            answers[f"{name}_z_{k}"] = np.array([z for z, _ in pairs])
            answers[f"{name}_time_{k}"] = np.array([least for _, least in pairs])
    np.savez(target, **answers)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
