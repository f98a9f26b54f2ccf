"""The contact problem of the instant at which a method that chooses its steps found no way on.

    c = gamma_0 + e gamma_0 + dt b,    gamma_0 = W u + w,    b = W M^-1 h + W' u + w'

dt is so short that no slide comes to its end: its solutions in impulses are then those that the contacts have in
forces, gamma' = G la + b, and the impacts with and without collision. Where none is left the method stopped.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from nonsmooth.errors import Status
from nonsmooth.integrators.moreau_jean.contact import Scratch
from nonsmooth.integrators.records import State
from nonsmooth.jit.blocks import new
from nonsmooth.mechanics.laws import LAW_E_F, LAW_E_N
from nonsmooth.mechanics.system import GAP, GIVEN_FORCE, UNILATERAL, ContactMode, System
from nonsmooth.results.failed_problem import FailedProblem

ZERO_TOLERANCES = 10.0  # chosen: tolerances that a gap or a velocity may be off where it is held at zero
LONGEST_INSTANT = 1e-3  # chosen: [s] of a problem in which nothing slides
PART_OF_SLIDE = 1e-3  # chosen: of the time in which the free accelerations would end a slide


def problem_of_instant(
    system: System, set_up: Callable[..., tuple[int, int]], state: State, tolerances: tuple[float, float],
    selection: int, about: str,
) -> FailedProblem | None:  # fmt: skip
    """Of the contacts that touch in the state where a run stopped; None where none does, or none can be set up.

    Parameters
    ----------
    set_up : callable
        `acceleration_problem_apart` for this system: (t, q, u, n, rates, work).
    tolerances : (rtol, atol)
        Of the run, which say what is zero.
    """
    t, q, u = float(state.now), state.q, state.u
    rtol, atol = tolerances
    length, speed = (ZERO_TOLERANCES * (atol + rtol * float(np.abs(x).max(initial=0.0))) for x in (q, u))
    closed = touching(system, t, q, state.mode, length)
    if not len(closed):
        return None
    scratch = new(Scratch, **system.sizes)
    work = scratch.work
    work.closed[: len(closed)] = closed
    status, r = set_up(t, q, u, len(closed), scratch.rates, work)
    if status != Status.RUNNING:
        return None
    start, b = work.start[: len(closed) + 1].copy(), work.c[:r].copy()
    gamma_0 = work.W[:r] @ u + work.w[:r]
    gamma_0[np.abs(gamma_0) <= speed] = 0.0
    is_normal = np.zeros(r, dtype=bool)
    is_normal[start[:-1][system.kinds[closed, 0] != GIVEN_FORCE]] = True
    dt = short_time(gamma_0[~is_normal], b[~is_normal])
    contact = np.repeat(np.arange(len(closed)), np.diff(start))
    e = np.where(is_normal, system.laws[closed, LAW_E_N][contact], system.laws[closed, LAW_E_F][contact])
    e[is_normal & (gamma_0 > 0.0)] = 0.0
    return FailedProblem(
        work.G[:r, :r].copy(), (1.0 + e) * gamma_0 + dt * b, gamma_0, start, system.kinds[closed],
        system.laws[closed], work.N[closed], np.zeros_like(state.P[closed]), state.mode[closed], state.slip[closed],
        dt, selection, about,
    )  # fmt: skip


def touching(system: System, t: float, q: np.ndarray, mode: np.ndarray, length: float) -> np.ndarray:
    """The contacts whose gap is zero, or that their mode holds closed."""
    closed = (system.kinds[:, 0] != UNILATERAL) | (mode != ContactMode.OPEN)
    if GAP in system.functions:
        closed |= system.evaluate(GAP, t, q, np.zeros_like(q)) <= length
    return np.flatnonzero(closed)


def short_time(gamma_F: np.ndarray, b_F: np.ndarray) -> float:
    """A time in which no slide comes to its end [s]."""
    is_slide = (gamma_F != 0.0) & (b_F != 0.0)
    times: Any = np.abs(gamma_F[is_slide] / b_F[is_slide])
    return float(min(LONGEST_INSTANT, PART_OF_SLIDE * times.min(initial=np.inf)))
