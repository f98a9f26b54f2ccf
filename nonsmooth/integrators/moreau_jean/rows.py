"""The closed contacts of one step as plain arrays, solved as the step solves them.

For a problem that a file holds, and for an impact of a scene that follows a law of its own.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from nonsmooth.contact.planar.energetic import spring_back
from nonsmooth.contact.planar.enumerate import enumerate_modes
from nonsmooth.contact.planar.impacts import strike
from nonsmooth.contact.planar.ladder import solve_planar
from nonsmooth.contact.planar.lemke import pivot
from nonsmooth.contact.planar.newton import solve_by_newton
from nonsmooth.contact.planar.redundant import enumerate_redundant
from nonsmooth.contact.spatial.solve import solve_spatial
from nonsmooth.errors import Status
from nonsmooth.integrators.moreau_jean.contact import Scratch, solve
from nonsmooth.integrators.records import State
from nonsmooth.jit import Kernel, load_all
from nonsmooth.jit.blocks import new
from nonsmooth.mechanics.sys import Sys


class Answer(NamedTuple):
    """What the solver of the step says: its status, the impulses (r,), the residual relative to max |c|."""

    status: Status
    P: np.ndarray
    residual: float


@dataclass(frozen=True, eq=False, repr=False)
class StepRows:
    """The closed contacts of one step; what the arrays are, `FailedProblem` says."""

    G: np.ndarray
    c: np.ndarray
    gamma_0: np.ndarray
    start: np.ndarray
    kinds: np.ndarray
    laws: np.ndarray
    N: np.ndarray
    P_before: np.ndarray
    mode_before: np.ndarray
    slip_before: np.ndarray
    dt: float
    selection: int

    def solve(self) -> Answer:
        """Solve it as the step does, redundant contacts included."""
        n, r = len(self.kinds), len(self.c)
        width = self.P_before.shape[1]
        state = new(State, n=1, n_c=n, d=width - 1, capacity=1)
        scratch = new(Scratch, n=1, n_c=n, d=width - 1)
        work = scratch.work
        work.G[:r, :r], work.c[:r], work.gamma_0[:r] = self.G, self.c, self.gamma_0
        work.start[: n + 1], work.closed[:], work.N[:] = self.start, np.arange(n), self.N
        state.P[:], state.mode[:], state.slip[:] = self.P_before, self.mode_before, self.slip_before
        others: tuple[Kernel, ...] = (solve_spatial,) if width > 2 else ()
        if n > 1 and width < 3:
            scratch.planar.can_decide_redundant = scratch.planar.has_newton = 1
            others = solve_planar, enumerate_modes, pivot, enumerate_redundant, solve_by_newton, strike, spring_back
        load_all((solve, *others))
        sys = new(Sys, n_p=0, n_c=n)
        sys.n, sys.n_c, sys.kinds[:], sys.laws[:] = 1, n, self.kinds, self.laws
        status = solve(sys.address, self.selection, self.dt, n, state.address, scratch.address)
        is_solved = status == Status.RUNNING
        residual = float(state.worst.residual) if is_solved else np.inf
        return Answer(Status.FINISHED if is_solved else Status(status), work.P[:r].copy(), residual)
