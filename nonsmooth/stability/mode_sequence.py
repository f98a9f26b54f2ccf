"""From a simulated motion to the sequence of modes of one period, the guess from which a cycle is computed.

The records are grouped into runs of equal modes. A period is found where the last m changes of mode repeat the m before
them from nearly the same states, m as small as possible; a motion without changes of mode is cut where its most moving
coordinate rises through its mean.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nonsmooth.errors import InvalidInput
from nonsmooth.solution import Solution
from nonsmooth.stability.mode_flow import ContactState
from nonsmooth.system import BILATERAL, ContactMode

ARTEFACT = 2  # runs of no more records are transitions blurred by a fixed time step
NEAR = 0.25  # of the motion's extent: states of successive periods lie closer, also while the motion still grows
LONGEST = 24  # changes of mode in a period
REST = 1e-7  # of the motion's whole extent: a motion that ends smaller has died out


class PhaseGuess(NamedTuple):
    """A phase of a motion: what the contacts do, the state it begins in, and how long it lasts [s]."""

    states: tuple[ContactState, ...]
    x: np.ndarray  # (2 n_q,) q, u
    duration: float


class Run(NamedTuple):
    """Consecutive records of equal modes."""

    states: tuple[ContactState, ...]
    start: int  # record at which it begins
    end: int  # record at which it ends


def period_of(solution: Solution) -> list[PhaseGuess]:
    """The phases of the last period of a motion.

    Raises
    ------
    InvalidInput
        When the motion has come to rest, or has no period yet.
    """
    t, x = solution.t, np.concatenate([solution.q, solution.u], axis=1)
    scale = np.ptp(x, axis=0)
    late = x[len(x) - max(len(x) // 10, 2) :]
    if (np.ptp(late, axis=0) <= REST * np.maximum(scale, 1e-300)).all():
        raise InvalidInput("the motion has come to rest, so there is no cycle near this start; give another one")
    scale = np.ptp(x[len(x) // 2 :], axis=0)
    scale[scale == 0] = 1.0
    runs = runs_of(solution)
    settled = [run for run in runs if run.start >= len(t) // 2]
    for m in range(1, min(LONGEST, (len(settled) - 1) // 2) + 1):
        here, before = settled[-1 - m : -1], settled[-1 - 2 * m : -1 - m]
        repeats = all(a.states == b.states for a, b in zip(here, before, strict=True))
        returns = np.abs((x[here[0].start] - x[settled[-1].start]) / scale).max() <= NEAR
        if repeats and returns and settled[-1].states == here[0].states:
            _require_no_jump(solution, float(t[here[0].start]))
            return [PhaseGuess(run.states, x[run.start], float(t[run.end] - t[run.start])) for run in here]
    if len(settled) <= 1:
        return [_smooth_period(t, x, scale, runs[-1])]
    raise InvalidInput(
        f"the modes of the motion do not repeat yet ({len(settled)} changes in its second half); simulate for longer"
    )


def _require_no_jump(solution: Solution, start: float) -> None:
    """Raise when the motion after ``start`` passes an impact without collision."""
    jumps = [event.t for event in solution.paradoxes if event.n_solutions == 0 and event.t >= start]
    if jumps:
        raise InvalidInput(
            f"the motion passes an impact without collision at t = {jumps[0]:.6g} s; cycles with jumps of the "
            "velocity are not computed"
        )


def runs_of(solution: Solution) -> list[Run]:
    """The runs of equal modes, without those that are no longer than a blurred transition."""
    normal = solution.P_N if solution.la is None else solution.la[:, :, 0]
    artefact = ARTEFACT if solution.la is None else 0  # located events are not blurred
    signs = np.where(normal < 0, -1, 1)
    bilateral = solution.system.kinds[:, 0] == BILATERAL if solution.system else np.zeros(0, bool)
    table = np.stack([solution.mode, solution.slip, np.where(bilateral, signs, 1)], axis=2)[1:]
    cuts = np.flatnonzero((table[1:] != table[:-1]).any(axis=(1, 2))) + 1
    edges = [0, *cuts.tolist(), len(table)]
    kept: list[Run] = []
    for start, end in zip(edges[:-1], edges[1:], strict=True):
        states = tuple(contact_state(*row) for row in table[start])
        if kept and (kept[-1].states == states or end - start <= artefact):
            kept[-1] = kept[-1]._replace(end=end)
        else:
            kept.append(Run(states, start, end))
    return kept


def contact_state(mode: int, slip: int, normal: int) -> ContactState:
    """The state of a contact; the sign of its normal force matters while it slides only."""
    is_sliding = mode == ContactMode.SLIDE
    return ContactState(ContactMode(mode), int(np.sign(slip)) if is_sliding else 0, int(normal) if is_sliding else 1)


def _smooth_period(t: np.ndarray, x: np.ndarray, scale: np.ndarray, run: Run) -> PhaseGuess:
    half = len(t) // 2
    n = x.shape[1] // 2
    j = int(np.argmax(np.ptp(x[half:, :n], axis=0)))
    y = x[half:, j] - x[half:, j].mean()
    rises = half + np.flatnonzero((y[:-1] < 0) & (y[1:] >= 0))
    if rises.size < 2:
        raise InvalidInput("the motion does not oscillate in its second half; simulate for longer, or from elsewhere")
    return PhaseGuess(run.states, x[rises[-2]], float(t[rises[-1]] - t[rises[-2]]))
