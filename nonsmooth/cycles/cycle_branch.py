"""Cycles along a parameter, and what happens to them on the way.

Each cycle starts from the four before it, continued by a cubic. Where the sequence of modes no longer closes, the
motion is simulated from the last cycle and a new sequence is read from it; where stick begins or ends between two
values, the value at which the cycle without it touches the limit (grazing) is found as the root of its least margin.
Multipliers that cross the unit circle name folds (+1), period doublings (-1) and tori. Source: di Bernardo, Budd,
Champneys, Kowalczyk, *Piecewise-smooth Dynamical Systems* (2008), chapters 7 and 8.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.checks.arrays import as_name, as_tolerance, as_vector
from nonsmooth.cycles.arclength import follow_arc
from nonsmooth.cycles.cycle import LimitCycle
from nonsmooth.cycles.cycle_margins import least_p, paradox_at
from nonsmooth.cycles.drift import NONE, find_drift
from nonsmooth.cycles.grazing_fold import GrazingFold, fold_of_sticking, grazing_value
from nonsmooth.cycles.limit_cycle import limit_cycle
from nonsmooth.cycles.mode_sequence import ContactLost, period_of, sequence_near
from nonsmooth.cycles.phase import PhaseGuess
from nonsmooth.cycles.shooting import OtherSequence, Shooting
from nonsmooth.errors import InvalidInput
from nonsmooth.integrators.event_driven.options import EventDriven
from nonsmooth.mechanics.model_system import as_rated
from nonsmooth.mechanics.start import answers_start
from nonsmooth.mechanics.system import System
from nonsmooth.results.failures import StepFailure
from nonsmooth.runs.simulate import simulate_whole
from nonsmooth.scenes.given import as_model
from nonsmooth.signals.telling import tell
from nonsmooth.views import Worded, view

if TYPE_CHECKING:
    from pathlib import Path

TURNS = 8  # chosen: folds
SAME_BRANCH = 0.3  # chosen: of the amplitude: a cycle that simulation finds so near continues the branch
SETTLE = 60  # chosen: periods that a motion is given to settle where its sequence of modes has changed
BRANCH_DEGREE = 3  # chosen: of the polynomial along the branch by which the next cycle is predicted
ENTRY_ACCURACY = 1e-9  # chosen: relative accuracy of the value at which a cycle enters a paradox
TURNS_AT_GRAZING = "the cycle that sticks and the one that never stops meet where both just stop"


@dataclass(frozen=True)
class CycleChange:
    """What happens to the cycle between two values of the parameter.

    Attributes
    ----------
    kind : str
        "stick begins", "stick ends", "new sequence", "paradox entry", "paradox exit", "fold", "period doubling",
        "torus", "jump" to a cycle that is not the continuation of the last, "end" of the branch, or "interrupted" by
        Ctrl-C.
    value : float
        Where: to about 1e-9 for stick that begins or ends by grazing, for a paradox, and for a fold that the branch
        goes round, else the middle of the two values.
    before, after : float
        The two values.
    message : str
        Why, where a sequence of modes did not close; of a paradox, what it is.
    """

    kind: str
    value: float
    before: float
    after: float
    message: str = ""

    @property
    def is_located(self) -> bool:
        """Whether the value was found, and is not the middle of the two."""
        return self.value != 0.5 * (self.before + self.after)

    def where(self, digits: int) -> str:
        """The value in words, or the two between which it lies."""
        if self.is_located:
            return f"at {self.value:.{digits}g}"
        return f"between {self.before:.{digits}g} and {self.after:.{digits}g}"


@dataclass(frozen=True, eq=False, repr=False)
class CycleBranch(Worded):
    """Cycles along a parameter.

    Attributes
    ----------
    parameter : str
    values : ndarray (k,)
        Those at which a cycle was found.
    cycles : tuple of LimitCycle
    changes : tuple of CycleChange
    """

    parameter: str
    values: np.ndarray
    cycles: tuple[LimitCycle, ...]
    changes: tuple[CycleChange, ...]

    def plot(self, path: str | Path | None = None, label: str = "", coordinate: int = 0) -> Any:
        """Amplitude, period and sticking along the parameter, which ``label`` names (needs the extra [plot]); returns
        the Matplotlib figure, saved to ``path`` if given."""
        return view(self, "plot")(self, path, label, coordinate)

    @property
    def periods(self) -> np.ndarray:
        """(k,) [s]"""
        return np.array([cycle.period for cycle in self.cycles])

    @property
    def stick_durations(self) -> np.ndarray:
        """(k,) [s]"""
        return np.array([cycle.stick_duration for cycle in self.cycles])

    @property
    def amplitudes(self) -> np.ndarray:
        """Half peak-to-peak (k, n_q)."""
        return np.array([cycle.amplitudes for cycle in self.cycles])


@answers_start
def continue_cycle(
    system: Any,
    parameter: str,
    values: ArrayLike,
    cycle: LimitCycle | None = None,
    rtol: float = 1e-9,
    forcing: float | None = None,
    state: Any = None,
    duration: float | None = None,
) -> CycleBranch:
    """Follow a cycle along a parameter.

    Parameters
    ----------
    system : System, model, or Scene
    parameter : str
    values : (k,)
        In the order in which they are visited.
    cycle : LimitCycle, optional
        Near the first value; ``limit_cycle`` of the system there when left out.
    rtol : float
        Relative accuracy of the integration along the branch.
    forcing : float, optional
        Period of the excitation [s], as of `limit_cycle`.
    state, duration : optional
        Where the simulation begins that finds the first cycle, and how long it is [s], as of `limit_cycle`.

    Returns
    -------
    CycleBranch
        At a fold it turns round and visits the values backwards, with the fold itself between. It ends early, with a
        change of the kind "end", where no cycle is left, and with "interrupted" after Ctrl-C.

    Raises
    ------
    InvalidInput
        When there are no values, or there is no cycle at the first one.
    """
    grid, system = as_vector("values", values), as_rated(as_model(system), "continue_cycle")
    if grid.size == 0:
        raise InvalidInput(f"values of {parameter} must be at least one; got none")
    as_name("parameter", parameter, system.parameter_values)
    rtol = as_tolerance("rtol", rtol)
    first = system.with_parameters(**{parameter: float(grid[0])})
    begun = limit_cycle(first, cycle, duration, forcing=forcing, state=state)
    branch = _Growing(system, parameter, rtol, [float(grid[0])], [begun], [])
    k, direction, turns = 1, 1, 0
    while 0 <= k < grid.size:
        tell(k / grid.size)
        outcome = branch.reach_or_stop(float(grid[k]))
        if outcome == "end":
            break
        if outcome == "turned":
            direction, turns = -direction, turns + 1
            k += direction  # the value before is visited already
        if turns > TURNS:
            break
        k += direction
    return CycleBranch(parameter, np.array(branch.values), tuple(branch.cycles), tuple(branch.changes))


@dataclass(eq=False)
class _Growing:
    """A branch while it is followed."""

    system: System
    parameter: str
    rtol: float
    values: list[float]
    cycles: list[LimitCycle]
    changes: list[CycleChange]

    def at(self, value: float) -> System:
        """The system at a value of the parameter."""
        return self.system.with_parameters(**{self.parameter: value})

    def reach_or_stop(self, value: float) -> str:
        """`reach`; after Ctrl-C the end, which keeps the cycles that were found."""
        n = len(self.cycles), len(self.changes)
        try:
            return self.reach(value)
        except KeyboardInterrupt:
            del self.values[n[0] :], self.cycles[n[0] :], self.changes[n[1] :]
            before = self.values[-1]
            self.changes.append(CycleChange("interrupted", 0.5 * (before + value), before, value))
            return "end"

    def reach(self, value: float) -> str:
        """Add the cycle at the next value: "reached", "turned" round a fold back to the last value, or "end"."""
        last = self.cycles[-1]
        guess = _predicted(np.array([*self.values, value]), self.cycles, len(self.cycles))
        try:
            found = Shooting(self.at(value), guess, last.scale, self.rtol, **last.closing).solve()
        except ContactLost as lost:
            return self._end(value, str(lost))
        except InvalidInput as broken:
            return self._beyond(value, guess, broken)
        return self._add(value, found)

    def _beyond(self, value: float, guess: list[PhaseGuess], broken: InvalidInput) -> str:
        """Where the predicted cycle does not close: another sequence, or a fold, or what simulation settles in."""
        try:
            found = self._with_another_sequence(value, guess, broken)
        except ContactLost as lost:
            return self._end(value, str(lost))
        message = "no cycle near the last one"
        if found is None:
            try:
                found = _resimulated(self.at(value), self.cycles[-1])
            except InvalidInput as lost:
                message = str(lost)
        if found is not None and _is_near(found, self.cycles[-1]):
            return self._change(value, found, str(broken))
        if not isinstance(broken, OtherSequence):
            try:
                return self._round_the_arc(value)
            except InvalidInput:
                pass
        fold = self._grazing_fold(value)
        if fold is not None:
            return self._turn(value, fold.value, fold.grazing, fold.beyond, TURNS_AT_GRAZING)
        return self._end(value, message) if found is None else self._change(value, found, str(broken))

    def _with_another_sequence(self, value: float, guess: list[PhaseGuess], broken: InvalidInput) -> LimitCycle | None:
        """The cycle with the sequence that one period from the predicted cycle passes, where it is another one."""
        near, system = self.cycles[-1], self.at(value)
        try:
            if isinstance(broken, OtherSequence):
                near = Shooting(system, guess, near.scale, self.rtol, **near.closing).solve(checked=False)
            found = Shooting(system, sequence_near(system, near), **near.closing).solve()
        except ContactLost:
            raise
        except (InvalidInput, StepFailure):
            return None
        return found if found.sequence() != self.cycles[-1].sequence() else None

    def _round_the_arc(self, value: float) -> str:
        """By arclength, round a fold if there is one."""
        before = self.values[-1]
        way = follow_arc(self.at, self.cycles[-1], before, value - before, self.rtol)
        if way.fold is None and way.cycle is not None:
            return self._add(value, way.cycle)
        if way.fold is None or way.turning is None:
            return self._end(value, way.message)
        return self._turn(value, way.fold, way.turning, way.cycle, way.message)

    def _turn(self, value: float, fold: float, turning: LimitCycle, beyond: LimitCycle | None, message: str) -> str:
        """Add a fold, the cycle there, and the one beyond it at the value before."""
        before = self.values[-1]
        self.changes.append(CycleChange("fold", fold, before, value, message if beyond is not None else ""))
        self.values.append(fold)
        self.cycles.append(turning)
        if beyond is None:
            return self._end(value, message)
        self.values.append(before)
        self.cycles.append(beyond)
        return "turned"

    def _grazing_fold(self, value: float) -> GrazingFold | None:
        """The fold at a cycle that grazes, where there is one."""
        last, before = self.cycles[-1], self.values[-1]
        try:
            if any(phase.sticks for phase in last.phases):
                return fold_of_sticking(self.at, last, before, value)
            place = grazing_value(self.at, (before, value), last)
            if place is None:
                return None
            grazing = Shooting(self.at(place), last.guesses(), last.scale, **last.closing).solve(checked=False)
            beyond = _resimulated(self.at(before), grazing)
            return GrazingFold(place, grazing, beyond) if any(phase.sticks for phase in beyond.phases) else None
        except (InvalidInput, StepFailure):
            return None

    def _end(self, value: float, message: str) -> str:
        before = self.values[-1]
        self.changes.append(CycleChange("end", 0.5 * (before + value), before, value, message))
        return "end"

    def _change(self, value: float, found: LimitCycle, broken: str) -> str:
        """Add a cycle with another sequence, or one of the same that is not the continuation of the last."""
        before, last = self.values[-1], self.cycles[-1]
        if found.sequence() == last.sequence():
            self.changes.append(CycleChange("jump", 0.5 * (before + value), before, value, broken))
        else:
            self.changes.append(_changed(self.system, self.parameter, (before, value), (last, found), broken))
        return self._add(value, found, is_continuation=False)

    def _add(self, value: float, found: LimitCycle, is_continuation: bool = True) -> str:
        before, last = self.values[-1], self.cycles[-1]
        kind = crossing(last.multipliers, found.multipliers) if is_continuation else ""
        if kind and found.sequence() == last.sequence():
            self.changes.append(CycleChange(kind, 0.5 * (before + value), before, value))
        self._note_paradox(value, found)
        self.values.append(value)
        self.cycles.append(found)
        return "reached"

    def _note_paradox(self, value: float, found: LimitCycle) -> None:
        """Where the least p of the cycle has changed its sign since the last one."""
        before, last = self.values[-1], self.cycles[-1]
        (p_0, x_0), (p_1, x_1) = least_p(last), least_p(found)
        if (p_0 < 0) == (p_1 < 0):
            return
        kind = "paradox entry" if p_1 < 0 else "paradox exit"
        what = paradox_at(found, x_1) if p_1 < 0 else paradox_at(last, x_0)
        near = found if p_1 < 0 else last
        place = 0.5 * (before + value)
        if found.sequence() == last.sequence():
            place = self._zero_of(lambda cycle: least_p(cycle)[0], (before, value), near, place)
        self.changes.append(CycleChange(kind, place, before, value, what))

    def _zero_of(
        self, margin: Callable[[LimitCycle], float], values: tuple[float, float], near: LimitCycle, place: float
    ) -> float:
        """The value at which a margin of the cycle vanishes; ``place`` where it does not along this sequence."""
        from scipy.optimize import brentq

        def at(value: float) -> float:
            problem = Shooting(self.at(value), near.guesses(), near.scale, self.rtol, **near.closing)
            return margin(problem.solve(checked=False))

        try:
            return float(brentq(at, *values, xtol=1e-300, rtol=ENTRY_ACCURACY))
        except (InvalidInput, ValueError):  # a cycle that does not close, or no change of sign
            return place


def _is_near(found: LimitCycle, last: LimitCycle) -> bool:
    """Whether a cycle continues another: a sequence of modes changes without a jump of the motion."""
    sizes, others = found.amplitudes, last.amplitudes
    return bool(np.abs(sizes - others).max() <= SAME_BRANCH * others.max() and found.is_stable == last.is_stable)


def _predicted(grid: np.ndarray, cycles: list[LimitCycle], k: int) -> list[PhaseGuess]:
    """The phases at grid[k], on the polynomial through the last cycles with the same sequence (Lagrange)."""
    last = cycles[-1].guesses()
    known = [k - 1]
    for j in range(k - 2, max(k - 2 - BRANCH_DEGREE, -1), -1):
        if cycles[j].sequence() != cycles[-1].sequence() or grid[j] in grid[known]:
            break
        known.append(j)
    weights = lagrange_weights(grid[known], grid[k])
    paths = [cycles[j].guesses() for j in known]
    guess = []
    for i, phase in enumerate(last):
        x = sum(w * path[i].x for w, path in zip(weights, paths, strict=True))
        duration = sum(w * path[i].duration for w, path in zip(weights, paths, strict=True))
        guess.append(phase._replace(x=np.asarray(x), duration=max(float(duration), 0.1 * phase.duration)))
    return guess


def lagrange_weights(points: np.ndarray, at: float) -> np.ndarray:
    """Weights (k,) of the values at k distinct points in their polynomial's value elsewhere."""
    return np.array(
        [np.prod([(at - other) / (point - other) for other in points if other != point]) for point in points]
    )


def _resimulated(system: System, last: LimitCycle) -> LimitCycle:
    """The cycle that the motion from the last one settles in."""
    start, t = last.phases[0], float(last.phases[0].x[-1]) if last.has_time else 0.0
    span = t, t + SETTLE * last.period
    run = simulate_whole(system, span, start.q, start.u, integrator=EventDriven(), progress=None)
    drift = find_drift(system, [(t, start.q, start.u)], last.forcing is not None) if last.drifts else NONE
    return Shooting(system, period_of(run, last.forcing, drift), **last.closing).solve()


def _changed(
    system: System, parameter: str, values: tuple[float, float], cycles: tuple[LimitCycle, LimitCycle], message: str
) -> CycleChange:
    """What changed between two cycles with different sequences, and where."""
    sticks = [sum(phase.sticks for phase in cycle.phases) for cycle in cycles]
    kind = "stick begins" if sticks[1] > sticks[0] else "stick ends" if sticks[1] < sticks[0] else "new sequence"
    value = 0.5 * (values[0] + values[1])
    free = cycles[int(np.argmin(sticks))]
    stops = any(phase.sticks or (phase.ends_by and phase.ends_by[1] == "slip") for phase in free.phases)
    if kind != "new sequence" and not stops:
        value = grazing_value(lambda value: system.with_parameters(**{parameter: value}), values, free) or value
    return CycleChange(kind, value, *values, message)


def crossing(before: np.ndarray, after: np.ndarray) -> str:
    """Which bifurcation lies between two sets of multipliers: "", "fold", "period doubling" or "torus"."""
    if before.size != after.size or (np.abs(before).max(initial=0) < 1) == (np.abs(after).max(initial=0) < 1):
        return ""
    outside = max(np.concatenate([before, after]), key=abs)
    if abs(outside.imag) > 1e-6 * abs(outside):
        return "torus"
    return "fold" if outside.real > 0 else "period doubling"
