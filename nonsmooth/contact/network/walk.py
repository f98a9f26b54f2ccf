"""A walk: conjugate sweeps of spheres that go on from where they are, better or not; the best impulses are kept.

    P_0 given,  P_(k+1) = sweep(P_k),    best = the P_k of the least residual, asked every ROUND sweeps

Sweeps of a dense packing do not settle: they come near to a solution, leave it along a mode that grows, and come near
to another one. The nearest approach of n sweeps is some 1/n, for plain, over-relaxed, damped and conjugate ones alike:
of 949 contacts of shaken spheres 3e-5, 9e-6, 3e-6 and 5e-7 in successive windows of 5000, 15,000, 30,000 and 50,000
sweeps. Who goes back to the best ones each time sees the same again and again. From near enough the direct rung ends
what a walk begins.
"""

from __future__ import annotations

from nonsmooth.contact.network.al_newton import copy_impulses, judge_island
from nonsmooth.contact.network.problem import Network
from nonsmooth.contact.network.round_sweeps import are_round, round_sweeps
from nonsmooth.contact.network.solve import ROUND, Solver
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import view
from nonsmooth.numerics.rounding import EPS


@kernel
def walk_island(network, solver, k, most, tol):
    """Walk island k until its residual is within tol, ``most`` sweeps at most; the best go to ``direct.best``."""
    islands, best, done = network.islands, solver.direct.best, 0
    least = judge_island(network, k, 3, 6)
    copy_impulses(islands, k, network.P, best, 3)
    is_walk = are_round(network, solver.rows, k, 3)  # their rows take the velocities just made
    while is_walk and done < most and not least <= tol:
        done += round_sweeps(network, solver.rows, solver.conjugate, k, min(ROUND, most - done), EPS, 1.0, 3)
        error = judge_island(network, k, 3, 6)
        if error < least:
            least = error
            copy_impulses(islands, k, network.P, best, 3)
    islands.sweeps[k] = done


@kernel("void(int64, int64, int64, float64)")
def walk_spatial(network_at, solver_at, most, tol):
    """Walk each island of spheres."""
    network, solver = view(network_at, Network), view(solver_at, Solver)
    for k in range(network.islands.count):
        walk_island(network, solver, k, most, tol)


@kernel("int64(int64, int64)")
def are_all_spheres(network_at, solver_at):
    """1 where all islands are of spheres, else 0."""
    network, solver = view(network_at, Network), view(solver_at, Solver)
    for k in range(network.islands.count):
        if not are_round(network, solver.rows, k, 3):
            return 0
    return 1
