"""One solver of Siconos on one problem, run by the Python that has it (Debian: python3-siconos, python3-scipy).

    python3 siconos_others.py problem.npz SOLVER STORAGE answer.npz

problem: M, q (lcp); with n, m too, the free rows first (mlcp); or data, indices, indptr, shape of W, with q, mu, dim
(friction), W in dense or sparse STORAGE. Answer: z (impulses, for friction), and the least processor time of a call
[s].
"""

import sys
import time

import numpy as np
import siconos.numerics as sn

TOLERANCE = 1e-8
ITERATIONS = 20_000
LOOP, ROUNDS = 2e-3, 5  # seconds of a timed loop, and how many of them


def lcp(given, solver):
    """The call, and where its answer is."""
    problem = sn.LCP(np.asfortranarray(given["M"]), given["q"])
    z, w, options = np.zeros(len(given["q"])), np.zeros(len(given["q"])), options_of(f"LCP_{solver}")
    return lambda: sn.linearComplementarity_driver(problem, z, w, options), z


def mlcp(given, solver):
    """The call, and where its answer is."""
    n, m = int(given["n"]), int(given["m"])
    problem = sn.MLCP(n, np.asfortranarray(given["M"]), given["q"])
    assert problem.m == m
    z, w, options = np.zeros(n + m), np.zeros(n + m), options_of(f"MLCP_{solver}")
    sn.mlcp_driver_init(problem, options)
    return lambda: sn.mlcp_driver(problem, z, w, options), z


def friction(given, solver, storage):
    """The call, and where its answer is."""
    from scipy.sparse import csc_matrix, csr_matrix

    dim, rows = int(given["dim"]), (given["data"], given["indices"], given["indptr"])
    W = csc_matrix(csr_matrix(rows, shape=tuple(given["shape"])))
    W = np.asfortranarray(W.toarray()) if storage == "dense" else W
    problem = sn.FrictionContactProblem(dim, W, given["q"], given["mu"])
    r, u, options = np.zeros(len(given["q"])), np.zeros(len(given["q"])), options_of(f"FRICTION_{dim}D_{solver}")
    driver = sn.fc3d_driver if dim == 3 else sn.fc2d_driver
    return lambda: driver(problem, r, u, options), r


def options_of(name):
    """Its default ones, with our tolerance."""
    options = sn.SolverOptions(getattr(sn, f"SICONOS_{name}"))
    options.dparam[sn.SICONOS_DPARAM_TOL], options.iparam[sn.SICONOS_IPARAM_MAX_ITER] = TOLERANCE, ITERATIONS
    return options


def least_time(call, z):
    """Of a call from zero impulses: short ones in loops."""
    seconds = timed(call, z, 1)
    times = max(1, round(LOOP / max(seconds, 1e-6)))
    rounds = ROUNDS if seconds < 1.0 else 1
    return min([seconds, *(timed(call, z, times) for _ in range(rounds - 1))])


def timed(call, z, times):
    """The mean processor time of some calls."""
    began = time.process_time()
    for _ in range(times):
        z[:] = 0.0
        call()
    return (time.process_time() - began) / times


def main(source, solver, storage, target):
    """Solve it."""
    given = dict(np.load(source, allow_pickle=False))
    if "mu" in given:
        call, z = friction(given, solver, storage)
    else:
        call, z = (mlcp if "n" in given else lcp)(given, solver)
    seconds = least_time(call, z)
    np.savez(target, z=z, seconds=seconds)


if __name__ == "__main__":
    main(*sys.argv[1:])
