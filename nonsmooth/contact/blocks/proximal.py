"""Proximal point: Newton on a sequence of regular problems, for G without full rank.

    P_k+1 solves the contact problem with G + alpha I and c - alpha P_k

Each has the same solutions at a fixed point as the problem itself, and a regular Newton matrix. Where G is monotone on
the active contacts the outer error falls by alpha / (alpha + lambda), lambda the smallest nonzero eigenvalue, so a
small alpha is fast; a large one makes the inner problem easy. alpha falls after an inner success and grows after a
failure.

Source: Rockafellar, SIAM J. Control Optim. 14 (1976) 877-898; Acary, Bremond and Huber (2018), section 6.3.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace

import numpy as np

from nonsmooth.contact.blocks.newton import Newton
from nonsmooth.contact.blocks.nsgs import NSGS
from nonsmooth.contact.blocks.problem import Blocks, Problem


@dataclass(frozen=True)
class Proximal:
    """Options of the proximal point method.

    Parameters
    ----------
    alpha : float
        First shift of the diagonal, in units of the mean diagonal [-].
    max_iterations : int
        Outer iterations after which the best iterate is returned.
    max_solves : int
        Linear solves after which the best iterate is returned, too.
    sweeps : int
        Gauss-Seidel sweeps between a failed inner solve and the next, with a larger alpha.
    """

    alpha: float = 1e-2
    max_iterations: int = 60
    max_solves: int = 800
    sweeps: int = 20

    name = "proximal"

    def run(self, problem: Problem, P: np.ndarray, tol: float, until: float = math.inf) -> tuple[np.ndarray, int]:
        """Iterate from P; returns the best iterate found and the number of linear solves."""
        alpha, solves = self.alpha, 0
        best, least = P, problem.error(P)
        for _ in range(self.max_iterations):
            if least <= tol or solves >= self.max_solves or time.monotonic() >= until:
                break
            inner = shifted(problem, alpha, P)
            aim = max(0.1 * tol, 1e-3 * least * min(alpha, 1.0))
            trial, count = Newton(max_iterations=20).run(inner, P, aim, until)
            solves += count
            converged = inner.error(trial) <= aim
            error = problem.error(trial)
            if error < least:
                best, least = trial, error
            if converged:
                P = trial
                alpha = max(alpha * 0.1, 1e-9)
            else:
                P, _ = NSGS(max_sweeps=self.sweeps).run(problem, best, tol, until)
                alpha = min(alpha * 10.0, 1e3)
        return best, solves


def shifted(problem: Problem, alpha: float, anchor: np.ndarray) -> Problem:
    """The problem with G + alpha I and c - alpha anchor."""
    blocks, dim = problem.blocks, problem.dim
    rows = np.repeat(np.arange(problem.n_c), np.diff(blocks.indptr))
    G = blocks.G.copy()
    for a in range(dim):
        G[blocks.indices == rows, a, a] += alpha
    moved = Blocks(G, blocks.indices, blocks.indptr)
    return replace(problem, blocks=moved, c=problem.c - alpha * anchor)
