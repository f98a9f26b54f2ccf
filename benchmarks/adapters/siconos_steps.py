"""Siconos on the contact problems of steps of scenes, run by the Python that has it (Debian: python3-siconos).

    python3 siconos_steps.py problems.npz answers.npz

problems: W_0 (n, n), q_0 (n,), mu_0 (n_c,) of u = W r + q, interleaved per contact (N, T1[, T2]), W_1, ...;
answers: for each k the impulses r_k (n,) and the processor time of its solution time_k [s]. In space Newton's method of
Alart and Curnier, and Gauss-Seidel where it stops before its tolerance; in the plane Gauss-Seidel.
"""

import sys
import time

import numpy as np
import siconos.numerics as sn

TOLERANCE = 1e-14
ITERATIONS = {"newton": 1000, "sweeps": 200_000}


def solve(W, q, mu, codes):
    """The impulses of the first solver that succeeds, and its time; without one, those of the last."""
    dim = len(q) // len(mu)
    problem = sn.FrictionContactProblem(dim, np.asfortranarray(W), q, mu)
    driver = sn.fc3d_driver if dim == 3 else sn.fc2d_driver
    for code, iterations in codes[dim]:
        options = sn.SolverOptions(code)
        options.dparam[sn.SICONOS_DPARAM_TOL], options.iparam[sn.SICONOS_IPARAM_MAX_ITER] = TOLERANCE, iterations
        r, u = np.zeros(len(q)), np.zeros(len(q))
        began = time.process_time()
        info = driver(problem, r, u, options)
        seconds = time.process_time() - began
        if info == 0:
            break
    return r, seconds


def main(source, target):
    """Solve every problem."""
    sweeps = ITERATIONS["sweeps"]
    codes = {
        3: [(sn.SICONOS_FRICTION_3D_NSN_AC, ITERATIONS["newton"]), (sn.SICONOS_FRICTION_3D_NSGS, sweeps)],
        2: [(sn.SICONOS_FRICTION_2D_NSGS, sweeps)],
    }
    problems, answers = np.load(source), {}
    for k in range(len(problems.files) // 3):
        r, seconds = solve(problems[f"W_{k}"], problems[f"q_{k}"], problems[f"mu_{k}"], codes)
        answers |= {f"r_{k}": r, f"time_{k}": seconds}
    np.savez(target, **answers)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
