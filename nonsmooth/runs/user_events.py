"""Events of the user: where a function f(t, q, u) of his reaches zero, as in SciPy's ``solve_ivp``.

An event is where f reaches zero from another value, or passes through it; a jump of the velocities through zero is one
as well, at the time of the jump. f is looked at in a few places of each step, and its root is found by Brent's method
on the motion within the step (results/motion.py), to the rounding of the time. The run itself is not changed, unless
the event is terminal. Source: Brent, *Algorithms for Minimization without Derivatives* (1973), chapter 4.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.checks.arrays import as_count, as_number
from nonsmooth.errors import InvalidInput, Status, said_by, shown
from nonsmooth.mechanics.signatures import require_arguments
from nonsmooth.numerics.rounding import EPS, rounding_of_sum
from nonsmooth.results.motion import Motion

PLACES_OF_STEP = (0.0, 0.25, 0.5, 0.75)  # chosen: of a step of several figures of its motion, at which f is looked at
OF_SYSTEM, OF_SCENE = ("t", "q", "u"), ("t", "bodies")  # defined: arguments of the functions
START = (0.0,)  # chosen: of a step of time stepping
JUMP_ROUNDINGS = 200  # chosen: of the velocities: what is less is no jump
EVENT_TIME_RESOLUTION = 4.0 * EPS  # defined: of the time within a step: the finest that SciPy's brentq takes


class Stop(NamedTuple):
    """Why and when a run ends before its end."""

    t: float
    status: Status
    message: str
    is_jump: bool = False  # the velocities jump through the event
    cause: BaseException | None = None


class EventFailed(Exception):
    """The user's function raised, or returned no finite number."""


class UserEvent:
    """One function of the user, and what was found of it."""

    def __init__(self, function: Callable[..., Any], number: int, arguments: tuple[str, ...] = OF_SYSTEM) -> None:
        if not callable(function):
            listed = ", ".join(arguments)
            raise InvalidInput(f"events must be functions f({listed}); events[{number}] is {shown(function)}")
        self.name = f"events[{number}] ({getattr(function, '__name__', type(function).__name__)})"
        require_arguments(self.name, function, arguments)
        self.function = function
        terminal, direction = getattr(function, "terminal", None), getattr(function, "direction", None)
        terminal = False if terminal is None else terminal
        self.limit = int(terminal) if isinstance(terminal, bool) else as_count(f"{self.name}.terminal", terminal)
        self.direction = 0.0 if direction is None else as_number(f"{self.name}.direction", direction)
        self.found: list[tuple[Any, ...]] = []  # times, and of a system coordinates and velocities
        self.seen = (math.nan, 0.0)  # when it was looked at last, and its value; 0 before the start

    def __call__(self, t: float, *state: Any) -> float:
        """f(t, ...), a finite number or `EventFailed`."""
        try:
            value = float(self.function(t, *state))
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            raise EventFailed(f"raised {said_by(error)}", t, *state) from error
        if not math.isfinite(value):
            raise EventFailed(f"returned {value}", t, *state)
        return value

    def is_reached(self, before: float, after: float) -> bool:
        """Whether f reaches zero between two of its values, in the direction that was asked for."""
        if before == 0.0 or (after != 0.0 and (before < 0.0) == (after < 0.0)):
            return False
        return self.direction == 0.0 or (before < 0.0) == (self.direction > 0.0)


def as_functions(events: Any, arguments: tuple[str, ...]) -> list[Callable[..., Any]]:
    """The functions of ``events``, of which one may stand alone, or `InvalidInput`."""
    if callable(events):
        return [events]
    if not isinstance(events, list | tuple):
        raise InvalidInput(f"events must be functions f({', '.join(arguments)}) in a list; got {shown(events)}")
    return list(events)


class Look(NamedTuple):
    """Where f is looked at: m times with their states, in order."""

    t: np.ndarray  # (m,)
    q: np.ndarray  # (m, n)
    u: np.ndarray  # (m, n)
    step: np.ndarray  # (m,) that leads to it
    is_jump: np.ndarray  # (m,) bool: it differs from the one before by a jump


class EventWatch:
    """The events of a run, looked for block after block of its steps."""

    def __init__(self, functions: Sequence[Callable[..., Any]], places: Sequence[float]) -> None:
        self.events = [UserEvent(function, k) for k, function in enumerate(functions)]
        self.places = np.array(places)
        self.last: Motion | None = None  # the step that was looked at last, but for its end

    def scan(self, motion: Motion, has_ended: bool) -> Stop | None:
        """Look for events in the steps of a block, and at the state that a run ended with; the first reason to stop."""
        n_old = 0
        if self.last is not None:
            n_old, motion = 1, motion.after(self.last)
        look = look_at(motion, n_old, self.places, has_ended)
        stops = [self._follow(event, motion, look) for event in self.events]
        first = min((stop for stop in stops if stop is not None), key=lambda stop: stop.t, default=None)
        if first is not None:
            for event in self.events:
                event.found = [found for found in event.found if found[0] <= first.t]
        self.last = motion.last_step()
        return first

    def _follow(self, event: UserEvent, motion: Motion, look: Look) -> Stop | None:
        """Follow one function through the places of a block."""
        try:
            for m, (t, q, u) in enumerate(zip(look.t, look.q, look.u, strict=True)):
                (t_before, before), event.seen = event.seen, (t, event(t, q, u))
                if not event.is_reached(before, event.seen[1]):
                    continue
                if not look.is_jump[m]:
                    within = functools.partial(state, motion, look.step[m])
                    t = root(event, within, t_before, t, before, event.seen[1])
                    q, u = within(t)
                event.found.append((float(t), q.copy(), u.copy()))
                if len(event.found) == event.limit:
                    message = f"{event.name} was reached at t = {t:.9g} s"
                    return Stop(float(t), Status.EVENT_REACHED, message, bool(look.is_jump[m]))
        except EventFailed as failed:
            what, moment, *place = failed.args
            q, u = (np.array2string(x, precision=6) for x in place)
            message = f"the event function {event.name} {what}, at t = {moment:.9g} s, q = {q}, u = {u}"
            return Stop(float(moment), Status.EVENT_FAILED, message, cause=failed.__cause__)
        return None

    def columns(self, n_q: int, n_u: int) -> tuple[list[np.ndarray], ...]:
        """Times (k,), and states (k, n_q), (k, n_u), of each function's events."""

        def of(j: int, *width: int) -> list[np.ndarray]:
            all_found = (event.found for event in self.events)
            return [np.array([each[j] for each in found]).reshape(len(found), *width) for found in all_found]

        return of(0), of(1, n_q), of(2, n_u)


def look_at(motion: Motion, n_old: int, places: np.ndarray, has_ended: bool) -> Look:
    """The places in the steps from number n_old on, the left limit of each step that ends with a jump, and the end."""
    m = len(motion.t)
    each = np.arange(m)
    left = motion.within(each, motion.t + motion.h)
    size = np.abs(motion.u) + np.abs(motion.B).sum(axis=1)
    beyond = np.vstack((motion.u, motion.end[2][None]))[1:]
    jumps = (np.abs(left[1] - beyond) > rounding_of_sum(JUMP_ROUNDINGS, size)).any(axis=1)
    k = np.repeat(each[n_old:], len(places))
    t = motion.t[k] + np.tile(places, m - n_old) * motion.h[k]
    starts = np.tile(places == 0.0, m - n_old)
    before = np.maximum(k - 1, 0)
    looks = [Look(t, *motion.within(k, t), np.where(starts, before, k), starts & (k > 0) & jumps[before])]
    order = [k + np.tile(places, m - n_old)]
    ends = each if has_ended else each[:-1]
    ends = ends[jumps[ends]]
    looks.append(Look(motion.t[ends] + motion.h[ends], left[0][ends], left[1][ends], ends, np.zeros(len(ends), bool)))
    order.append(ends + 0.5 * (places[-1] + 1.0))
    if has_ended:
        t_end, q_end, u_end = (np.array([x]) for x in motion.end)
        looks.append(Look(t_end, q_end, u_end, np.array([m - 1]), jumps[-1:] if m else np.ones(1, bool)))
        order.append(np.array([m]))
    first_to_last = np.argsort(np.concatenate(order))
    return Look(*(np.concatenate(column)[first_to_last] for column in zip(*looks, strict=True)))


def state(motion: Motion, k: int, t: float) -> tuple[np.ndarray, np.ndarray]:
    """q and u at a time of step k."""
    q, u = motion.within(np.array([k]), np.array([t]))
    return q[0], u[0]


def root(
    event: UserEvent, state_at: Callable[[float], tuple[Any, ...]], t_a: float, t_b: float, f_a: float, f_b: float
) -> float:
    """The time in [t_a, t_b] of a step at which the function of a state falls to zero or passes through it [s]."""
    from scipy.optimize import brentq

    known = {t_a: f_a, t_b: f_b}

    def value(t: float) -> float:
        return known[t] if t in known else event(t, *state_at(t))

    return float(brentq(value, t_a, t_b, xtol=EVENT_TIME_RESOLUTION * (t_b - t_a), rtol=EVENT_TIME_RESOLUTION))
