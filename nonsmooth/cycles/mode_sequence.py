"""From a simulated motion to the sequence of modes of one period, the guess from which a cycle is computed.

The records are grouped into runs of equal modes, cut where the velocities jump. A period is found where the last m runs
repeat the m before them from nearly the same states, m as small as possible; a motion without events is cut where its
most moving coordinate rises through its mean. Under a periodic excitation the times at which two periods begin lie a
multiple of the excitation's period apart. What drifts (drift.py) is taken off the coordinates first.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nonsmooth.cycles.cycle import LimitCycle
from nonsmooth.cycles.drift import NONE, Drift
from nonsmooth.cycles.jump import read_jump
from nonsmooth.cycles.mode_flow import ContactState, mode_flow
from nonsmooth.cycles.phase import PhaseGuess
from nonsmooth.errors import InvalidInput
from nonsmooth.integrators.event_driven.options import EventDriven
from nonsmooth.integrators.records import EVENT_KIND, EVENT_T, IMPACT, INCONSISTENT
from nonsmooth.mechanics.system import BILATERAL, GIVEN_FORCE, ContactMode, System
from nonsmooth.results.events import Event
from nonsmooth.results.solution import Solution
from nonsmooth.runs.simulate import simulate_whole

ARTEFACT = 2  # chosen: runs of no more records are transitions blurred by a fixed time step
# chosen: of the motion's extent: states of successive periods lie closer, also while the motion still grows
NEAR_RETURN = 0.25
EQUAL_STATES = 1e-6  # chosen: of the motion's extent: states that near count as equal
# chosen: times nearer, a later return is the period and the first return only a neighbour (period doubling)
CLOSER = 100
INSTANTS = (0.0, 0.6180339887, 1.9021130326)  # chosen: s, at which functions that read the time are compared
MOST_RUNS = 48  # chosen: runs in a period
# chosen: of a coordinate's extent in a period: a coordinate that ends no farther from where it began comes back
RETURN_DISTANCE = 0.05
STEADY = 0.02  # chosen: of what a coordinate goes on by: twice so nearly the same is no approach to a cycle
CONSTRAINT_JUMP = 1e-8  # chosen: of the fastest velocity: a smaller jump is what holds a constraint
VANISHED_FORCE = 1e-10  # chosen: of the largest normal force: a force that an event has located at zero
REST_EXTENT = 1e-7  # chosen: of the motion's whole extent: a motion that ends smaller has died out


class ContactLost(InvalidInput):
    """The given normal force of a contact vanishes on the way."""


class Run(NamedTuple):
    """Consecutive records of equal modes, without a jump."""

    states: tuple[ContactState, ...]
    start: int  # record at which it begins
    end: int  # record at which it ends


def is_forced(system: System) -> bool:
    """Whether a model function changes with time, at the present parameters."""
    reading = [which for which in system.functions if system.reads(which, "t")]
    q, u = np.linspace(0.3, 0.7, system.n_q), np.linspace(0.2, 0.6, system.n_u)
    early, *others = ([system.evaluate(which, t, q, u) for which in reading] for t in INSTANTS)
    return any((a != b).any() for later in others for a, b in zip(early, later, strict=True))


def period_of(solution: Solution, forcing: float | None = None, drift: Drift = NONE) -> list[PhaseGuess]:
    """The phases of the last period of a motion.

    ``forcing`` is the period of its excitation [s]; the motion may go on along the directions of ``drift``.

    Raises
    ------
    InvalidInput
        When the motion has come to rest, or has no period yet.
    """
    t, states = solution.t, np.concatenate([solution.q, solution.u], axis=1)
    x = np.concatenate([drift.rest(t, solution.q), solution.u], axis=1) if drift else states
    full = states if forcing is None and not drift.has_time else np.column_stack([states, t])
    scale = np.ptp(x, axis=0)
    late = x[t >= t[-1] - 0.1 * (t[-1] - t[0])]
    if (np.ptp(late, axis=0) <= REST_EXTENT * np.maximum(scale, 1e-300)).all():
        ending = "goes on steadily" if drift else "has come to rest"
        raise InvalidInput(f"the motion {ending}, so there is no cycle near this start; give another one")
    _require_contact(solution, t >= t[-1] - 0.1 * (t[-1] - t[0]))
    half = int(np.searchsorted(t, 0.5 * (t[0] + t[-1])))
    scale = np.ptp(x[half:], axis=0)
    scale[scale == 0] = 1.0
    runs = runs_of(solution)
    settled = [run for run in runs if run.start >= half]
    _require_no_drift(settled, t, x, scale, forcing)
    m = _runs_of_a_period(settled, t, x / scale, forcing)
    if m:
        return _phases(solution, full, settled[-1 - m :])
    if len(settled) <= 1 and forcing is None:
        return [_smooth_period(t, x, full, half, runs[-1])]
    if len(settled) <= 1:
        return [_forced_period(t, x, full, runs[-1], forcing)]  # type: ignore[arg-type]
    raise InvalidInput(
        f"the modes of the motion do not repeat yet ({len(settled)} changes in its second half); simulate for longer"
    )


def _runs_of_a_period(settled: list[Run], t: np.ndarray, y: np.ndarray, forcing: float | None) -> int:
    """How many runs the last period has, 0 where nothing repeats; ``y`` are the states over their extents."""
    found: list[tuple[int, float]] = []
    for m in range(1, min(MOST_RUNS, (len(settled) - 1) // 2) + 1):
        here, before = settled[-1 - m : -1], settled[-1 - 2 * m : -1 - m]
        if settled[-1].states != here[0].states or any(a.states != b.states for a, b in zip(here, before, strict=True)):
            continue
        returns = float(np.abs(y[here[0].start] - y[settled[-1].start]).max())
        if forcing is not None:
            periods = (t[settled[-1].start] - t[here[0].start]) / forcing
            returns = max(returns, abs(periods - round(periods)), NEAR_RETURN if round(periods) == 0 else 0.0)
        if returns <= NEAR_RETURN:
            found.append((m, returns))
    least = min((returns for _, returns in found), default=0.0)
    return next((m for m, returns in found if returns <= max(EQUAL_STATES, CLOSER * least)), 0)


def _require_no_drift(
    settled: list[Run], t: np.ndarray, x: np.ndarray, scale: np.ndarray, forcing: float | None
) -> None:
    """Raise where modes and velocities repeat and coordinates go on, twice by the same amount, with which the system
    changes: what drifts without that was taken off."""
    n = x.shape[1] // 2
    m = _runs_of_a_period(settled, t, (x / scale)[:, n:], forcing)
    if not m:
        return
    first, second, third = (settled[-1 - k * m].start for k in (2, 1, 0))
    before, gone = x[second, :n] - x[first, :n], x[third, :n] - x[second, :n]
    far = np.abs(gone) > RETURN_DISTANCE * np.ptp(x[second : third + 1, :n], axis=0)
    steady = far & (np.abs(gone - before) <= STEADY * np.abs(gone))
    if steady.any():
        words = ", ".join(f"coordinate {j} by {gone[j]:.6g}" for j in np.flatnonzero(steady))
        raise InvalidInput(
            f"the modes and velocities repeat, but each time {words} goes on, and the system changes with it: the "
            "motion does not close, nor does it but for a drift"
        )


def _phases(solution: Solution, x: np.ndarray, runs: list[Run]) -> list[PhaseGuess]:
    """The phases of all runs but the last, which begins the next period."""
    t, phases, events = solution.t, [], solution.events
    speed = CONSTRAINT_JUMP * np.abs(solution.u).max()
    for run, following in zip(runs[:-1], runs[1:], strict=True):
        jump, before, after = None, x[run.end], x[following.start]
        if np.abs(solution.u[following.start] - solution.u[run.end]).max() > speed:
            flow = mode_flow(solution.system, run.states, t[run.end])
            jump = read_jump(flow, before, after, _events_at(events, t[run.end]))
        phases.append(PhaseGuess(run.states, x[run.start], float(t[run.end] - t[run.start]), jump))
    return phases


def sequence_near(system: System, cycle: LimitCycle) -> list[PhaseGuess]:
    """The phases that the motion passes in one period from the middle of a cycle's longest slip, at other parameters.

    Raises
    ------
    InvalidInput
        When it does not end in the mode it begins with.
    """
    phase = max(cycle.phases, key=lambda phase: (not phase.sticks, phase.duration))
    begins = float(phase.x[-1]) - phase.begins if cycle.has_time else 0.0
    k = int(np.searchsorted(cycle.t, phase.begins + 0.5 * phase.duration))
    t_0 = begins + float(cycle.t[k])
    span = t_0, t_0 + cycle.period
    run = simulate_whole(system, span, cycle.q[k], cycle.u[k], integrator=EventDriven(), progress=None)
    _require_contact(run, run.t > t_0)
    runs = runs_of(run)
    if runs[0].states != runs[-1].states:
        raise InvalidInput("the motion does not come back in one period")
    if len(runs) == 1:
        return [PhaseGuess(runs[0].states, _state(run, 0, cycle.has_time), cycle.period)]
    x = np.array([_state(run, j, cycle.has_time) for j in range(len(run.t))])
    first, *others = _phases(run, x, runs)
    last = runs[-1]
    duration = float(run.t[last.end] - run.t[last.start]) + first.duration
    return [*others, PhaseGuess(last.states, x[last.start], duration, first.jump)]


def _state(run: Solution, k: int, has_time: bool) -> np.ndarray:
    """q, u, and where it belongs to the state t, of a record."""
    return np.concatenate([run.q[k], run.u[k], run.t[[k]][:has_time]])


def _events_at(events: list[Event], t: float) -> list[Event]:
    """The events of an instant; the end of an accumulation of impacts is dated later than its record."""
    here = [event for event in events if event.t == t]
    if not here:
        raise InvalidInput(
            f"at t = {t:.6g} s the impacts of a contact accumulate; cycles through endlessly many impacts are not "
            "computed"
        )
    return here


def runs_of(solution: Solution) -> list[Run]:
    """The runs of equal modes, without those that are no longer than a blurred transition.

    Raises
    ------
    InvalidInput
        When an integrator of fixed steps met an impact.
    """
    is_located = solution.la is not None
    normal = solution.P_N if solution.la is None else solution.la[:, :, 0]
    artefact = 0 if is_located else ARTEFACT  # located events are not blurred
    signs = _signs(normal)
    bilateral = solution.system.kinds[:, 0] == BILATERAL if solution.system else np.zeros(0, bool)
    table = np.stack([solution.mode, solution.slip, np.where(bilateral, signs, 1)], axis=2)[1:]
    if not is_located:
        _require_no_jump(solution)
    instants = (np.diff(solution.t) == 0) & is_located  # of a jump there are two records
    table[instants] = -1
    cuts = np.flatnonzero((table[1:] != table[:-1]).any(axis=(1, 2))) + 1
    edges = [0, *cuts.tolist(), len(table)]
    kept: list[Run] = []
    for start, end in zip(edges[:-1], edges[1:], strict=True):
        if instants[start]:
            continue
        states = tuple(contact_state(*row) for row in table[start])
        continues = bool(kept) and kept[-1].end == start
        if continues and (kept[-1].states == states or end - start <= artefact):
            kept[-1] = kept[-1]._replace(end=end)
        else:
            kept.append(Run(states, start, end))
    return kept


def _signs(force: np.ndarray) -> np.ndarray:
    """Signs of the normal forces (n_t, n_c); of one that an event has located at zero, the sign before."""
    signs = np.sign(np.where(np.abs(force) <= VANISHED_FORCE * np.abs(force).max(axis=0), 0.0, force)).astype(int)
    last = np.maximum.accumulate(np.where(signs != 0, np.arange(len(force))[:, None], 0), axis=0)
    signs = np.take_along_axis(signs, last, axis=0)
    return np.where(signs == 0, 1, signs)


def _require_contact(solution: Solution, when: np.ndarray) -> None:
    """Raise where a given normal force vanishes at some of the records."""
    if solution.la is None or solution.system is None:
        return
    for i in np.flatnonzero(solution.system.kinds[:, 0] == GIVEN_FORCE):
        lost = when & (solution.la[:, i, 0] <= 0)
        if solution.la[:, i, 0].any() and lost.any():
            raise ContactLost(
                f"{solution.described.contacts[i]} loses its normal force at t = {solution.t[lost][0]:.6g} s, where it "
                "lifts off; cycles with a lift-off from a given normal force are not computed"
            )


def _require_no_jump(solution: Solution) -> None:
    """Raise when the second half of a motion of fixed steps met a jump of the velocities."""
    half = 0.5 * (solution.t[0] + solution.t[-1])
    names = {IMPACT: "an impact", INCONSISTENT: "an impact without collision"}
    for row in solution.event_rows:
        if row[EVENT_T] >= half and row[EVENT_KIND] in names:
            raise InvalidInput(
                f"the motion passes {names[int(row[EVENT_KIND])]} at t = {row[EVENT_T]:.6g} s, which a fixed time step "
                "does not locate; simulate with ns.EventDriven"
            )


def contact_state(mode: int, slip: int, normal: int) -> ContactState:
    """The state of a contact; the sign of its normal force matters while it slides only."""
    is_sliding = mode == ContactMode.SLIDE
    return ContactState(ContactMode(mode), int(np.sign(slip)) if is_sliding else 0, int(normal) if is_sliding else 1)


def _smooth_period(t: np.ndarray, x: np.ndarray, full: np.ndarray, half: int, run: Run) -> PhaseGuess:
    n = x.shape[1] // 2
    j = int(np.argmax(np.ptp(x[half:, :n], axis=0)))
    mean = np.trapezoid(x[half:, j], t[half:]) / (t[-1] - t[half])
    y = x[half:, j] - mean
    rises = half + np.flatnonzero((y[:-1] < 0) & (y[1:] >= 0))
    if rises.size < 2:
        raise InvalidInput("the motion does not oscillate in its second half; simulate for longer, or from elsewhere")
    return PhaseGuess(run.states, full[rises[-2]], float(t[rises[-1]] - t[rises[-2]]))


def _forced_period(t: np.ndarray, x: np.ndarray, full: np.ndarray, run: Run, forcing: float) -> PhaseGuess:
    """A motion without events: the multiple of the excitation's period after which it comes nearest to itself."""
    start = int(np.searchsorted(t, t[-1] - 0.25 * (t[-1] - t[run.start])))
    longest = max(1, min(MOST_RUNS, int((t[-1] - t[start]) / forcing)))
    after = [_at(t, x, t[start] + k * forcing) for k in range(1, longest + 1)]
    returns = np.abs(np.array(after) - x[start]).max(axis=1)
    k = 1 + int(np.flatnonzero(returns <= max(EQUAL_STATES * np.abs(x).max(), CLOSER * returns.min()))[0])
    return PhaseGuess(run.states, full[start], k * forcing)


def _at(t: np.ndarray, x: np.ndarray, time: float) -> np.ndarray:
    return np.array([np.interp(time, t, column) for column in x.T])
