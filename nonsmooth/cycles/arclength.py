"""A branch of cycles followed by its arclength, which goes round the folds where the parameter turns back.

With z the states and durations of the phases, z and the parameter p in their units, the next cycle solves

    F(z, p) = 0  (shooting),      t_z . (z - z_0) + t_p (p - p_0) = ds

(z_0, p_0) being the last cycle and t the tangent of the branch, the null vector of [dF/dz, dF/dp]. At a fold t_p = 0.
dF/dz is exact, dF/dp a central difference. Source: Keller, *Numerical Solution of Bifurcation and Nonlinear Eigenvalue
Problems* (1977); Allgower, Georg, *Introduction to Numerical Continuation Methods* (2003), chapter 6.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from nonsmooth.cycles.cycle import LimitCycle
from nonsmooth.cycles.shooting import AtRest, Shooting
from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.system import System

STATE_UNIT = 0.1  # chosen: of z: a step of the arclength 1 moves no state by more of the motion's extent
ARC_NEWTON_STEPS = 8  # chosen: of a corrector, which is quadratic: more mean that the arc was too long
PARAMETER_INCREMENT = 1e-3  # derived: of the parameter's unit, for dF/dp: its error, 1e-6, slows Newton's method only
LEAST_INCREMENT = 1e-5  # chosen: of the parameter itself: a smaller difference would drown in the integration's error
SHORTEST_ARC = 1.0 / 64  # chosen: step of the arclength
MOST_ARCS = 100  # chosen: steps of the arclength before the branch is given up
SHRUNK = 0.2  # chosen: of the last cycle: a smaller one at a "fold" is the rest from which the branch grows (Hopf)
FOLD_ACCURACY = 1e-5  # derived: of the arclength: of a fold, where the parameter's error is quadratic in it


@dataclass(frozen=True, eq=False)
class ArcPoint:
    """A cycle on the branch: y = (z, p) in their units, and the tangent there, of unit length."""

    y: np.ndarray
    tangent: np.ndarray
    problem: Shooting

    @property
    def value(self) -> float:
        """The parameter in its unit, counted from the start of the arc."""
        return float(self.y[-1])


class Arc:
    """The branch through a cycle, by arclength.

    Parameters
    ----------
    at : callable
        The system at a value of the parameter.
    cycle : LimitCycle
    value, unit : float
        The parameter there, and its unit; the arc sets out in the direction of the unit's sign.
    rtol : float
        Of the integration.
    """

    def __init__(self, at: Callable[[float], System], cycle: LimitCycle, value: float, unit: float, rtol: float):
        self.at, self.cycle, self.origin, self.unit, self.rtol = at, cycle, value, unit, rtol
        self.scale = Shooting(at(value), cycle.guesses(), **cycle.closing).scale
        states = np.array([np.append(phase.x / self.scale, phase.duration / cycle.period) for phase in cycle.phases])
        self.shape = states.shape
        y = np.append(states.ravel() / STATE_UNIT, 0.0)
        problem = self.problem(y)
        J = np.column_stack([problem.linearised(rtol)[1] * self._units(problem), self._by_parameter(y)])
        self.point = ArcPoint(y, _null_vector(J, np.append(np.zeros(y.size - 1), 1.0)), problem)

    def parameter(self, point: ArcPoint) -> float:
        """Its value."""
        return self.origin + self.unit * point.value

    def problem(self, y: np.ndarray) -> Shooting:
        """The shooting problem at y.

        Raises
        ------
        InvalidInput
            Where a phase has shrunk to nothing.
        """
        states = (y[:-1] * STATE_UNIT).reshape(self.shape)
        if states[:, -1].min() <= 0:
            raise InvalidInput("the branch is lost: one of its phases shrinks to nothing")
        guess = [
            phase._replace(x=row[:-1] * self.scale, duration=float(row[-1] * self.cycle.period))
            for phase, row in zip(self.cycle.guesses(), states, strict=True)
        ]
        system = self.at(self.origin + self.unit * y[-1])
        return Shooting(system, guess, self.scale, self.rtol, **self.cycle.closing)

    def _units(self, problem: Shooting) -> np.ndarray:
        """d(states over their scale, logarithms of the durations)/dz, (m (d + 1),)."""
        units = np.full(self.shape, STATE_UNIT)
        units[:, -1] *= self.cycle.period / problem.T
        return units.ravel()

    def _by_parameter(self, y: np.ndarray) -> np.ndarray:
        """dF/dp."""
        h = max(PARAMETER_INCREMENT, LEAST_INCREMENT * abs(self.origin / self.unit))
        step = np.append(np.zeros(y.size - 1), h)
        ahead, behind = (self.problem(y + s * step).linearised(self.rtol)[0] for s in (1, -1))
        return (ahead - behind) / (2 * h)

    def corrected(self, start: ArcPoint, ds: float) -> ArcPoint:
        """The point of the branch at the arclength ds from another.

        Raises
        ------
        InvalidInput
            When Newton's method does not get there.
        """
        y = start.y + ds * start.tangent
        by_parameter = self._by_parameter(y)  # kept during Newton's iteration, which it hardly slows
        for _ in range(ARC_NEWTON_STEPS):
            problem = self.problem(y)
            F, by_z = problem.linearised(self.rtol)
            J = np.column_stack([by_z * self._units(problem), by_parameter])
            ahead = start.tangent @ (y - start.y) - ds
            step = -np.linalg.lstsq(np.vstack([J, start.tangent]), np.append(F, ahead), rcond=1e-13)[0]
            if np.abs(step).max() > 1:
                break
            if np.abs(step).max() ** 2 <= self.rtol:
                return ArcPoint(y + step, _null_vector(J, start.tangent), problem)
            y = y + step
        raise InvalidInput("the branch is lost: Newton's method does not reach its next cycle")

    def advance(self, ds: float) -> tuple[ArcPoint, ArcPoint]:
        """The next point of the branch, no farther than ds, and the one before."""
        before = self.point
        while True:
            try:
                after = self.corrected(before, ds)
            except InvalidInput:
                if ds <= SHORTEST_ARC:
                    raise
                ds /= 2
                continue
            if after.tangent @ before.tangent < 0.8 and ds > SHORTEST_ARC:  # a bend of more than 37 degrees
                ds /= 2
                continue
            self.point = after
            return before, after

    def fold_between(self, before: ArcPoint, after: ArcPoint) -> ArcPoint:
        """Where t_p = 0."""
        from scipy.optimize import brentq

        end = float(before.tangent @ (after.y - before.y))
        s = brentq(lambda ds: self.corrected(before, ds).tangent[-1] if ds > 0 else before.tangent[-1], 0.0, end,
                   xtol=FOLD_ACCURACY)  # fmt: skip
        return self.corrected(before, float(s))


def _null_vector(J: np.ndarray, towards: np.ndarray) -> np.ndarray:
    """The direction in which J vanishes, of unit length, pointing along another."""
    tangent = np.linalg.svd(J)[2][-1]
    return tangent if tangent @ towards >= 0 else -tangent


class Passage(NamedTuple):
    """Where the arc from one value of the parameter towards the next has come out."""

    cycle: LimitCycle | None  # at the next value, or beyond a fold back at the first; None where it was lost
    fold: float | None  # the parameter there
    turning: LimitCycle | None  # the cycle there
    message: str = ""


def follow_arc(at: Callable[[float], System], cycle: LimitCycle, value: float, unit: float, rtol: float) -> Passage:
    """Follow the branch from the cycle at a value to the value + unit, or round a fold and back.

    Raises
    ------
    InvalidInput
        When the branch is lost before a fold, or its sequence of modes ends.
    """
    arc, fold, turning = Arc(at, cycle, value, unit, rtol), None, None
    size = np.abs(cycle.amplitudes).max()
    for _ in range(MOST_ARCS):
        before, after = arc.advance(1.0)
        if fold is None and after.tangent[-1] <= 0:
            point = arc.fold_between(before, after)
            fold = arc.parameter(point)
            try:
                turning = point.problem.cycle()
            except AtRest:
                turning = None
            if turning is None or np.abs(turning.amplitudes).max() < SHRUNK * size:
                return Passage(None, None, None, f"the cycle shrinks to a rest at {fold:.10g} (a Hopf bifurcation)")
        if after.value >= 1 or (fold is not None and after.value <= 0):
            end = value + unit if after.value >= 1 else value
            try:
                found = Shooting(at(end), after.problem.found(), arc.scale, rtol, **cycle.closing).solve()
            except InvalidInput as lost:
                if fold is None:
                    raise
                return Passage(None, fold, turning, str(lost))
            return Passage(found, fold, turning)
    raise InvalidInput(
        f"the branch has not come back to its parameter's values after {MOST_ARCS} steps of the arclength"
    )
