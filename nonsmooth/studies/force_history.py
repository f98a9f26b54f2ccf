"""The force history of a compliant contact: when it stops the slip, how hard, and with which impulse.

The impulses are quadratures of the forces, integrated with the motion. An episode begins where the contact closes (or
with the run) and ends where it opens, or, in a contact that stays closed, where the force has fallen to a hundredth of
its peak. The effective energetic restitution is e^2 = W_expansion/W_compression, works of the normal force.
Source: Stronge, *Impact Mechanics* (2000), chapter 3 (energetic restitution).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.checks.arrays import as_instance
from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.system import ContactMode
from nonsmooth.results.solution import Solution
from nonsmooth.views import Worded

if TYPE_CHECKING:
    from nonsmooth.studies.reference import Problem

TAIL = 0.1  # chosen: of an episode, that is run beyond its end
FADED = 0.01  # chosen: of the peak force: the episode of a contact that stays closed ends there


@dataclass(frozen=True, repr=False)
class Episode(Worded):
    """One episode of contact.

    Attributes
    ----------
    start, stop, end : float
        Times at which it begins, at which the slip first ends in sticking (NaN where it does not), and at which it
        ends [s].
    peak_force : float
        Largest normal force, with its sign [N].
    P_stop, P_N, P_F : float
        Normal impulse until the slip ends, and the impulses of the episode [N s].
    gamma_N : float
        Normal velocity where the contact opens [m/s]; NaN where it does not.
    restitution : float
        Energetic, from the works of the normal force; NaN with several contacts, or where the contact does not open.
    """

    start: float
    stop: float
    end: float
    peak_force: float
    P_stop: float
    P_N: float
    P_F: float
    gamma_N: float
    restitution: float


def force_episode(solution: Solution, contact: int | str = 0) -> Episode:
    """The first episode of a contact in a run of `Penalty` with every step recorded.

    Parameters
    ----------
    solution : Solution
        Of ``simulate(..., integrator=Penalty(...))`` without ``t_eval``.
    contact : int or str
        Its number, or its name.

    Returns
    -------
    Episode

    Raises
    ------
    InvalidInput
        For a solution without forces, or a contact that never closes.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> from nonsmooth.catalogue import PainleveRod
    >>> rod = PainleveRod(mu=2.0)
    >>> sol = ns.simulate(rod, (0, 1e-4), *rod.state(slip=-1.0), integrator=ns.Penalty(stiffness=1e12))
    >>> impact = ns.force_episode(sol)
    >>> round(impact.gamma_N, 3), round(impact.restitution, 3)
    (0.255, 1.0)
    """
    as_instance("solution", solution, Solution, "a Solution, as ns.simulate(...) gives")
    contact = solution.described.contact(contact)
    if solution.la is None:
        raise InvalidInput("this solution holds no contact forces; run it with integrator=Penalty(...)")
    force, events = solution.la[:, contact, 0], [e for e in solution.events if e.contact == contact]
    closed = np.flatnonzero(force != 0.0)
    if len(closed) == 0:
        raise InvalidInput(f"{solution.described.contacts[contact]} never closes in this run")
    first = max(0, int(closed[0]) - 1)
    start = float(solution.t[first])
    opening = next((e for e in events if e.mode_after == ContactMode.OPEN and e.t > start), None)
    last = _row(solution, opening.t) if opening else _faded(force, first)
    inside = [e for e in events if start <= e.t <= solution.t[last]]
    stop = next(
        (e.t for e in inside if (e.mode_before, e.mode_after) == (ContactMode.SLIDE, ContactMode.STICK)), np.nan
    )
    P_N, P_F = np.cumsum(solution.P_N[:, contact]), np.cumsum(solution.P_F[:, contact].sum(axis=1))
    peak = first + int(np.argmax(np.abs(force[first : last + 1])))
    work = solution.ledger["normal"][first : last + 1] - solution.ledger["normal"][first]
    is_known = opening is not None and solution.g_N.shape[1] == 1 and work.min() < 0
    return Episode(
        start, float(stop), float(solution.t[last]), float(force[peak]),
        float(P_N[_row(solution, stop)] - P_N[first]) if np.isfinite(stop) else np.nan,
        float(P_N[last] - P_N[first]), float(P_F[last] - P_F[first]), opening.gamma_N if opening else np.nan,
        float(np.sqrt(max(0.0, 1 - work[-1] / work.min()))) if is_known else np.nan,
    )  # fmt: skip


def first_episode(problem: Problem, integrator: Any, run: Solution, contact: int) -> Episode | None:
    """The first episode of a contact in a motion whose run, recorded at some times, is known: its part is run again
    with every step. None of a contact that never closes."""
    try:
        return force_episode(problem.until(end_of_episode(run, contact)).run(integrator), contact)
    except InvalidInput:
        return None


def end_of_episode(run: Solution, contact: int) -> float:
    """When the run of the first episode of a contact may end [s]: a tenth of it after the contact opens, or with the
    run. Only this much is recorded at every step."""
    closings = [e.t for e in run.events if e.contact == contact and e.mode_before == ContactMode.OPEN]
    start = float(run.t[0]) if run.mode[0, contact] != ContactMode.OPEN else min(closings, default=np.inf)
    openings = [e.t for e in run.events if e.contact == contact and e.mode_after == ContactMode.OPEN and e.t > start]
    end = float(run.t[-1])
    return min(end, openings[0] + TAIL * (openings[0] - start)) if openings else end


def _row(solution: Solution, t: float) -> int:
    return int(np.searchsorted(solution.t, t))


def _faded(force: np.ndarray, first: int) -> int:
    """The row at which the force has fallen to a hundredth of its peak, or the last one."""
    peak = first + int(np.argmax(np.abs(force[first:])))
    faded = np.flatnonzero(np.abs(force[peak:]) < FADED * abs(force[peak]))
    return peak + int(faded[0]) if len(faded) else len(force) - 1
