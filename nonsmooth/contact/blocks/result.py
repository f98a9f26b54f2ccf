"""What `solve_contact` returns: impulses, velocities, and an error that was recomputed from them."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from nonsmooth.views import Worded


class ContactStatus(IntEnum):
    """How a contact solve ended; every status but SOLVED comes with the best iterate."""

    SOLVED = 0
    MAX_ITERATIONS = 1  # the iterations ran out above the tolerance
    STALLED = 2  # no solver of the ladder made further progress
    NO_SOLUTION = 3  # every mode of the problem was tried and none holds
    BUDGET_SPENT = 4  # max_time was used up above the tolerance


@dataclass(frozen=True, repr=False)
class ContactResult(Worded):
    """Solution, or best iterate, of a frictional contact problem.

    Attributes
    ----------
    P : ndarray, shape (n,)
        Impulses, interleaved per contact (N, T1[, T2]) as G [N s].
    gamma : ndarray, shape (n,)
        G P + c [m/s].
    status : ContactStatus
        SOLVED when ``error <= tol``.
    error : float
        Natural-map error with rho_i the mean diagonal of G_ii, relative to the norm of c [-].
    error_rho_1 : float
        The same with rho = 1, which depends on the units; for comparison with published tables only.
    iterations : int
        Sweeps, Newton steps or outer iterations, summed over all solvers that ran.
    solver : str
        The solver whose iterate this is.
    message : str
        What was tried and why it stopped.
    """

    P: np.ndarray
    gamma: np.ndarray
    status: ContactStatus
    error: float
    error_rho_1: float
    iterations: int
    solver: str
    message: str

    @property
    def success(self) -> bool:
        """Whether the tolerance was met."""
        return self.status is ContactStatus.SOLVED
