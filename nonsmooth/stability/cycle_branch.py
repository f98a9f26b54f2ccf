"""Cycles along a parameter, and what happens to them on the way.

Each cycle starts from the four before it, continued by a cubic. Where the sequence of modes no longer closes, the
motion is simulated from the last cycle and a new sequence is read from it; where stick begins or ends between two
values, the value at which the cycle without it touches the limit (grazing) is found as the root of its least margin.
Multipliers that cross the unit circle name folds (+1), period doublings (-1) and tori. Source: di Bernardo, Budd,
Champneys, Kowalczyk, *Piecewise-smooth Dynamical Systems* (2008), chapters 7 and 8.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.arrays import as_name, as_tolerance, as_vector
from nonsmooth.errors import InvalidInput
from nonsmooth.integrators.event_driven import EventDriven
from nonsmooth.simulation import simulate
from nonsmooth.stability.arclength import passage
from nonsmooth.stability.cycle import LimitCycle
from nonsmooth.stability.flow_map import flow_curve
from nonsmooth.stability.limit_cycle import limit_cycle
from nonsmooth.stability.mode_flow import mode_flow
from nonsmooth.stability.mode_sequence import ContactLost, PhaseGuess, period_of, sequence_near
from nonsmooth.stability.shooting import SAMPLES, OtherSequence, Shooting
from nonsmooth.system import System, as_system

TURNS = 8  # folds
SETTLE = 60  # periods that a motion is given to settle where its sequence of modes has changed
DEGREE = 3  # of the polynomial along the branch by which the next cycle is predicted
GRAZE = 1e-12  # relative accuracy of the value at which a cycle grazes


@dataclass(frozen=True)
class CycleChange:
    """What happens to the cycle between two values of the parameter.

    Attributes
    ----------
    kind : str
        "stick begins", "stick ends", "new sequence", "fold", "period doubling", "torus", "jump" to a cycle that is not
        the continuation of the last, or "end" of the branch.
    value : float
        Where: to about 1e-10 for stick that begins or ends by grazing and for a fold that the branch goes round, else
        the middle of the two values.
    before, after : float
        The two values.
    message : str
        Why, where a sequence of modes did not close.
    """

    kind: str
    value: float
    before: float
    after: float
    message: str = ""


@dataclass(frozen=True, eq=False)
class CycleBranch:
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


def continue_cycle(
    system: Any,
    parameter: str,
    values: ArrayLike,
    cycle: LimitCycle | None = None,
    rtol: float = 1e-9,
    forcing: float | None = None,
) -> CycleBranch:
    """Follow a cycle along a parameter.

    Parameters
    ----------
    system : System or model
    parameter : str
    values : (k,)
        In the order in which they are visited.
    cycle : LimitCycle, optional
        Near the first value; ``limit_cycle`` of the system there when left out.
    rtol : float
        Relative accuracy of the integration along the branch.
    forcing : float, optional
        Period of the excitation [s], as of `limit_cycle`.

    Returns
    -------
    CycleBranch
        At a fold it turns round and visits the values backwards, with the fold itself between. It ends early, with a
        change of the kind "end", where no cycle is left.

    Raises
    ------
    InvalidInput
        When there are no values, or there is no cycle at the first one.
    """
    grid, system = as_vector("values", values), as_system(system)
    if grid.size == 0:
        raise InvalidInput(f"values of {parameter} must be at least one; got none")
    as_name("parameter", parameter, system.parameter_values)
    rtol = as_tolerance("rtol", rtol)
    first = system.with_parameters(**{parameter: float(grid[0])})
    branch = _Growing(system, parameter, rtol, [float(grid[0])], [limit_cycle(first, cycle, forcing=forcing)], [])
    k, direction, turns = 1, 1, 0
    while 0 <= k < grid.size:
        outcome = branch.reach(float(grid[k]))
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

    def reach(self, value: float) -> str:
        """Add the cycle at the next value: "reached", "turned" round a fold back to the last value, or "end"."""
        last = self.cycles[-1]
        guess = _predicted(np.array([*self.values, value]), self.cycles, len(self.cycles))
        try:
            found = Shooting(self.at(value), guess, last.scale, self.rtol, last.forcing).solve()
        except ContactLost as lost:
            return self._end(value, str(lost))
        except InvalidInput as broken:
            return self._beyond(value, guess, broken)
        return self._add(value, found)

    def _beyond(self, value: float, guess: list[PhaseGuess], broken: InvalidInput) -> str:
        """Where the predicted cycle does not close: with another sequence, or along the arc, else by simulation."""
        before, last = self.values[-1], self.cycles[-1]
        try:
            near = last
            if isinstance(broken, OtherSequence):
                near = Shooting(self.at(value), guess, last.scale, self.rtol, last.forcing).solve(checked=False)
            found = Shooting(self.at(value), sequence_near(self.at(value), near), forcing=last.forcing).solve()
            if found.sequence() != last.sequence():
                return self._change(value, found, str(broken))
        except ContactLost as lost:
            return self._end(value, str(lost))
        except InvalidInput:
            pass
        if isinstance(broken, OtherSequence):
            return self._simulated(value, str(broken))
        try:
            way = passage(self.at, last, before, value - before, self.rtol)
        except InvalidInput:
            return self._simulated(value, str(broken))
        if way.fold is None and way.cycle is not None:
            return self._add(value, way.cycle)
        if way.turning is not None:
            self.changes.append(CycleChange("fold", way.fold, before, value))
            self.values.append(way.fold)
            self.cycles.append(way.turning)
        if way.cycle is None:
            return self._end(value, way.message)
        self.values.append(before)
        self.cycles.append(way.cycle)
        return "turned"

    def _simulated(self, value: float, broken: str) -> str:
        """The cycle that the motion from the last one settles in at the next value."""
        try:
            found = _resimulated(self.at(value), self.cycles[-1])
        except InvalidInput as none:
            return self._end(value, str(none))
        return self._change(value, found, broken)

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
        self.values.append(value)
        self.cycles.append(found)
        return "reached"


def _predicted(grid: np.ndarray, cycles: list[LimitCycle], k: int) -> list[PhaseGuess]:
    """The phases at grid[k], on the polynomial through the last cycles with the same sequence (Lagrange)."""
    last = cycles[-1].guesses()
    known = [k - 1]
    for j in range(k - 2, max(k - 2 - DEGREE, -1), -1):
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
    start, t = last.phases[0], 0.0 if last.forcing is None else float(last.phases[0].x[-1])
    run = simulate(system, (t, t + SETTLE * last.period), start.q, start.u, integrator=EventDriven())
    return Shooting(system, period_of(run, last.forcing), forcing=last.forcing).solve()


def _changed(
    system: System, parameter: str, values: tuple[float, float], cycles: tuple[LimitCycle, LimitCycle], message: str
) -> CycleChange:
    """What changed between two cycles with different sequences, and where."""
    sticks = [sum(phase.sticks for phase in cycle.phases) for cycle in cycles]
    kind = "stick begins" if sticks[1] > sticks[0] else "stick ends" if sticks[1] < sticks[0] else "new sequence"
    value = 0.5 * (values[0] + values[1])
    free = cycles[int(np.argmin(sticks))]
    if kind != "new sequence" and len(free.phases) == 1:
        value = _grazing(system, parameter, values, free)
    return CycleChange(kind, value, *values, message)


def _grazing(system: System, parameter: str, values: tuple[float, float], free: LimitCycle) -> float:
    """Where the cycle without events first touches the limit of its mode."""
    from scipy.optimize import brentq

    def margin(value: float) -> float:
        moved = system.with_parameters(**{parameter: value})
        return least_margin(Shooting(moved, free.guesses(), free.scale, forcing=free.forcing).solve(checked=False))

    low, high = margin(values[0]), margin(values[1])
    if low * high > 0:
        return 0.5 * (values[0] + values[1])
    return float(brentq(margin, *values, xtol=1e-300, rtol=GRAZE))


def least_margin(cycle: LimitCycle) -> float:
    """Least sliding velocity s gamma_F [m/s] of a cycle without events, negative where the mode's limit is passed."""
    from scipy.optimize import minimize_scalar

    (phase,) = cycle.phases
    flow = mode_flow(cycle.system, phase.states)
    curve = flow_curve(flow, phase.x, phase.duration, cycle.scale, pieces=SAMPLES)
    sliding = [i for i in flow.closed if cycle.system.kinds[i, 1]]
    least = np.inf
    for i in sliding:

        def slip(s: float, i: int = i) -> float:
            return float(flow.margins(curve(s))[i, "slip"].real)

        s = np.linspace(0, phase.duration, SAMPLES + 1)
        k = int(np.argmin([slip(time) for time in s[:-1]]))
        for j in (k - 1, k):  # the samples' neighbours, around the end of the period
            ends = s[j % SAMPLES], s[j % SAMPLES + 1]
            least = min(
                least, float(minimize_scalar(slip, bounds=ends, method="bounded", options={"xatol": 1e-12}).fun)
            )
    return least


def crossing(before: np.ndarray, after: np.ndarray) -> str:
    """Which bifurcation lies between two sets of multipliers: "", "fold", "period doubling" or "torus"."""
    if before.size != after.size or (np.abs(before).max(initial=0) < 1) == (np.abs(after).max(initial=0) < 1):
        return ""
    outside = max(np.concatenate([before, after]), key=abs)
    if abs(outside.imag) > 1e-6 * abs(outside):
        return "torus"
    return "fold" if outside.real > 0 else "period doubling"
