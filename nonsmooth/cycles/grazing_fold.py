"""Folds at a cycle that grazes: one that sticks and one that never stops meet where both just stop, gamma_F = 0.

Where steady sliding and a stick-slip motion are both stable, an unstable cycle without sticking lies between the two.
With the parameter the stick grows shorter, as the square root of the distance, until it is an instant: there both
cycles end, and the branch turns back along the other one. Source: Hetzler, Schwarzer, Seemann, *Commun. Nonlinear Sci.
Numer. Simul.* 12 (2007) 83; di Bernardo, Budd, Champneys, Kowalczyk, *Piecewise-smooth Dynamical Systems* (2008),
chapter 8.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from nonsmooth.cycles.cycle import LimitCycle
from nonsmooth.cycles.cycle_margins import least_slip
from nonsmooth.cycles.phase import PhaseGuess
from nonsmooth.cycles.shooting import Shooting
from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.system import System

GRAZE_ACCURACY = 1e-12  # chosen: relative accuracy of the value at which a cycle grazes
SHORT_STICK = 0.02  # chosen: of the period: so short a stick is left out to find the cycle without it
STICK_HALVINGS = 40  # derived: of an interval of values, until doubles do not tell them apart

At = Callable[[float], System]


class GrazingFold(NamedTuple):
    """Where the branch turns, the cycle there, and the one on the other side of the fold at the value before."""

    value: float
    grazing: LimitCycle
    beyond: LimitCycle


def grazing_value(at: At, values: tuple[float, float], free: LimitCycle) -> float | None:
    """Where the cycle that never stops sliding first does; None where it does not between the values."""
    from scipy.optimize import brentq

    def margin(value: float) -> float:
        return least_slip(Shooting(at(value), free.guesses(), free.scale, **free.closing).solve(checked=False))

    if margin(values[0]) * margin(values[1]) > 0:
        return None
    return float(brentq(margin, *values, xtol=1e-300, rtol=GRAZE_ACCURACY))


def fold_of_sticking(at: At, last: LimitCycle, before: float, value: float) -> GrazingFold | None:
    """The fold that a cycle which sticks comes to between two values, at the second of which it is gone.

    Raises
    ------
    InvalidInput
        Where a cycle on the way does not close.
    """
    if sum(phase.sticks for phase in last.phases) != 1:
        return None
    low, high, near = before, value, last
    for _ in range(STICK_HALVINGS):
        if near.stick_duration <= SHORT_STICK * near.period:
            break
        middle = 0.5 * (low + high)
        try:
            near, low = Shooting(at(middle), near.guesses(), near.scale, **near.closing).solve(), middle
        except InvalidInput:
            high = middle
    else:
        return None
    free = Shooting(at(low), without_stick(near), **near.closing).solve()
    place = grazing_value(at, (low, high), free)
    if place is None:
        return None
    grazing = Shooting(at(place), free.guesses(), free.scale, **free.closing).solve(checked=False)
    return GrazingFold(place, grazing, Shooting(at(before), free.guesses(), free.scale, **free.closing).solve())


def without_stick(cycle: LimitCycle) -> list[PhaseGuess]:
    """The phases of a cycle as if its only stick were an instant: its neighbours are one where they slide alike."""
    k = next(k for k, phase in enumerate(cycle.phases) if phase.sticks)
    phases = cycle.guesses()
    first, *others = [*phases[k + 1 :], *phases[:k]]
    if others and others[-1].states == first.states:
        last = others.pop()
        first = last._replace(duration=last.duration + first.duration, jump=first.jump)
    return [first, *others]
