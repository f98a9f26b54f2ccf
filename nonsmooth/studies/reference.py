"""What a study measures against: states at given times, with the error that they have themselves.

A reference is given as arrays, or is the run of an integrator; then its error is the difference from a run with twice
the step, or ten times the tolerance.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from nonsmooth.errors import InvalidInput
from nonsmooth.simulation import simulate
from nonsmooth.solution import Solution
from nonsmooth.system import System

COARSER_DT, COARSER_RTOL = 2.0, 10.0


@dataclass(frozen=True)
class Reference:
    """States at the times of a study.

    Attributes
    ----------
    q, u : ndarray (n_t, n)
    floor_q, floor_u : ndarray (n_t,)
        Their own errors.
    """

    q: np.ndarray
    u: np.ndarray
    floor_q: np.ndarray
    floor_u: np.ndarray

    def errors(self, solution: Solution) -> tuple[np.ndarray, np.ndarray]:
        """Largest differences of the coordinates and of the velocities, (n_t,) each."""
        n = len(self.q)
        return largest(solution.q[-n:] - self.q), largest(solution.u[-n:] - self.u)


def as_reference(given: Any, system: System, start: tuple, times: np.ndarray) -> Reference:
    """A reference from arrays (q, u) or from an integrator.

    Parameters
    ----------
    given : (array_like, array_like) or integrator
    start : (t_0, q0, u0)
    times : ndarray (n_t,)

    Raises
    ------
    InvalidInput
        For arrays of other shapes.
    """
    shape = (len(times), system.n_q)
    if isinstance(given, tuple | list) and len(given) == 2:
        q, u = (np.asarray(column, dtype=float) for column in given)
        q, u = (column.reshape(shape) if column.size == shape[0] * shape[1] else column for column in (q, u))
        if q.shape != shape or u.shape != shape:
            raise InvalidInput(
                f"reference must be a pair of arrays {shape}: (times, coordinates); got {q.shape}, {u.shape}"
            )
        return Reference(q, u, np.zeros(len(times)), np.zeros(len(times)))
    if not hasattr(given, "load"):
        raise InvalidInput(f"reference must be an integrator, or a pair (q, u) of states at the times; got {given!r}")
    fine, coarse = (run_at(system, start, times, integrator) for integrator in (given, coarser(given)))
    n = len(times)
    q, u = fine.q[-n:], fine.u[-n:]
    return Reference(q, u, largest(q - coarse.q[-n:]), largest(u - coarse.u[-n:]))


def coarser(integrator: Any) -> Any:
    """The same method with a larger step or tolerance."""
    if hasattr(integrator, "dt"):
        return replace(integrator, dt=COARSER_DT * integrator.dt)
    return replace(integrator, rtol=COARSER_RTOL * integrator.rtol, atol=COARSER_RTOL * integrator.atol)


def run_at(system: System, start: tuple, times: np.ndarray, integrator: Any, on_failure: str = "raise") -> Solution:
    """The states at the times; the start comes first where it is not one of them."""
    t_0, q0, u0 = start
    return simulate(system, (t_0, float(times[-1])), q0, u0, integrator=integrator, t_eval=times, on_failure=on_failure)


def largest(differences: np.ndarray) -> np.ndarray:
    """Largest entry of each row."""
    return np.abs(differences).max(axis=1)
