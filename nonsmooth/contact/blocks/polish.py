"""Active-set polish: a few Newton steps from an accepted solution, to rounding where the rank allows.

Near a solution the Alart-Curnier equations are those of a fixed set of open, sticking and sliding contacts, and one
Newton step solves the linear part exactly. Where that system is singular a few proximal steps with a small shift
do the same, because each reduces the error by the ratio of the shift to the smallest nonzero eigenvalue.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.contact.blocks.newton import Newton
from nonsmooth.contact.blocks.problem import Problem
from nonsmooth.contact.blocks.proximal import Proximal

POLISHED_ERROR = 1e-13  # chosen: some hundreds of roundings of the largest term


def polish(problem: Problem, P: np.ndarray) -> tuple[np.ndarray, int]:
    """A solution at least as good as P, and the number of linear solves."""
    P, solves = Newton(max_iterations=4).run(problem, P, POLISHED_ERROR)
    if problem.error(P) <= 10 * POLISHED_ERROR:
        return P, solves
    P, more = Proximal(alpha=1e-6, max_iterations=4, sweeps=1).run(problem, P, POLISHED_ERROR)
    return P, solves + more
