"""When a run steps and records: its span, its record times, its timetable."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.checks.arrays import as_count, as_number, as_vector
from nonsmooth.errors import InvalidInput, shown
from nonsmooth.integrators.contract import Integrator, Schedule
from nonsmooth.integrators.fixed_step import FixedStep
from nonsmooth.integrators.moreau_jean.options import MoreauJean
from nonsmooth.jit.blocks import new
from nonsmooth.mechanics.start import own_time

RECORD_TIMES_AT_ONCE = 2**12  # chosen: in memory: their arrays take 100 kB


@dataclass(frozen=True)
class RecordTimes:
    """The times of the records of a run, found a part at a time: a long run need not hold them all."""

    count: int
    part: Callable[[int, int], np.ndarray]  # part(first, stop): the times of the records first, ..., stop - 1
    span: tuple[float, float]  # the first and the last [s]


def listed(t: np.ndarray) -> RecordTimes:
    """Times [s] that are held all."""
    return RecordTimes(len(t), lambda first, stop: t[first:stop], (float(t[0]), float(t[-1])))


@dataclass(frozen=True)
class Timetable:
    """When a run records.

    Attributes
    ----------
    integrator : Integrator
    times : RecordTimes
        Of a method that chooses its steps and records every so many of them, the start and the end.
    every : int
        Steps between two records of such a method; 0: it records at the times.
    """

    integrator: Integrator
    times: RecordTimes
    every: int

    def schedule(self, first: int = 0, stop: int | None = None) -> Schedule:
        """The block of the records first, ..., stop - 1 that the loop reads."""
        t_0, t_1 = self.times.span
        t = self.times.part(first, self.count if stop is None else stop)
        return schedule_of(self.integrator, t, self.every, t_1 - t_0)

    @property
    def has_each_step(self) -> bool:
        """Whether a fixed step records each of its steps; the times are looked at a part after the other."""
        parts = range(0, self.count - 1, RECORD_TIMES_AT_ONCE)
        return all((self.schedule(first, first + RECORD_TIMES_AT_ONCE + 1).steps <= 1).all() for first in parts)

    @property
    def count(self) -> int:
        """The number of times."""
        return self.times.count

    @property
    def span(self) -> tuple[float, float]:
        """Start and end [s]."""
        return self.times.span


def make_timetable(integrator: Integrator, t_span: tuple[float, float], every: int, t_eval: Any) -> Timetable:
    """The record times of an integrator."""
    if not isinstance(integrator, FixedStep):
        t, every = record_times(t_span, every, t_eval)
        return Timetable(integrator, listed(t), every)
    return Timetable(integrator, grid_times(integrator, t_span, every, t_eval), 0)


def schedule_of(integrator: Integrator, t: np.ndarray, every: int, span: float) -> Schedule:
    """The block of the record times t (m + 1,) of a run over so long a span [s]."""
    schedule = new(Schedule, m=len(t) - 1)
    schedule.t[:], schedule.every, schedule.span = t, every, span
    if isinstance(integrator, FixedStep):
        schedule.dt[:], schedule.steps[:] = integrator.steps_between(t)
    return schedule


def grid_times(integrator: FixedStep, t_span: tuple[float, float], every: int, t_eval: ArrayLike | None) -> RecordTimes:
    """The record times of a fixed step: ``t_eval``, or every so many steps and the end."""
    t_0, t_1 = as_span(t_span)
    if t_eval is not None:
        given = as_record_times(t_eval, t_0, t_1)
        return listed(given)
    return _grid(integrator.dt, t_0, t_1, as_count("every", every))


@functools.lru_cache(maxsize=64)
def _grid(dt: float, t_0: float, t_1: float, every: int) -> RecordTimes:
    stride = dt * every
    if not (t_1 - t_0) / dt < 2**62 or (t_1 > t_0 and t_0 + dt == t_0):
        raise InvalidInput(f"dt = {dt:g} s is too small for the span ({t_0:g}, {t_1:g}); take a larger one")
    whole = int((t_1 - t_0) / stride * (1 + 1e-12)) + 1
    has_rest = t_1 - (t_0 + stride * (whole - 1)) > 1e-9 * min(dt, t_1 - t_0)

    def part(first: int, stop: int) -> np.ndarray:
        t = t_0 + stride * np.arange(first, min(stop, whole))
        if has_rest:
            return np.append(t, t_1) if stop > whole else t
        if stop >= whole > first:
            t[-1] = t_1  # not a rounding away
        return t

    return RecordTimes(whole + has_rest, part, (t_0, t_1))


def span_of(model: Any, t_span: tuple[float, float] | None) -> tuple[float, float]:
    """Start and end [s]; where no span is given, 0 and the model's ``t_end``."""
    if t_span is not None:
        return as_span(t_span)
    t_end = own_time(model, "t_end")
    if t_end is None:
        raise InvalidInput(
            "there is no t_end to run to; give t_span=(start, end), or t_end= of the system or the scene"
        )
    return 0.0, t_end


def own_steps(model: Any) -> MoreauJean:
    """`MoreauJean` with the model's ``dt``, where no integrator is given."""
    dt = own_time(model, "dt")
    if dt is None:
        raise InvalidInput("there is no dt to step with; give integrator=MoreauJean(dt=...), or dt= of the system or "
                           "the scene")  # fmt: skip
    return MoreauJean(dt)


def as_span(t_span: tuple[float, float]) -> tuple[float, float]:
    """Start and end [s]."""
    is_listed = isinstance(t_span, tuple | list) or (isinstance(t_span, np.ndarray) and t_span.ndim > 0)
    if not is_listed or len(t_span) != 2:
        raise InvalidInput(f"t_span must be a pair (start, end) [s]; got {shown(t_span)}")
    start, end = t_span
    t_0, t_1 = as_number("t_span[0]", start, "s"), as_number("t_span[1]", end, "s")
    if not t_1 >= t_0:
        raise InvalidInput(f"t_span must not run backwards; got ({t_0:g}, {t_1:g})")
    return t_0, t_1


def as_record_times(t_eval: ArrayLike, t_0: float, t_1: float) -> np.ndarray:
    """The start and the times of ``t_eval`` [s]."""
    t = as_vector("t_eval", t_eval)
    if t.size == 0 or t[0] < t_0 or t[-1] > t_1 or (np.diff(t) <= 0).any():
        raise InvalidInput(f"t_eval must increase within [{t_0:g}, {t_1:g}]; got {np.array2string(t, threshold=6)}")
    return np.concatenate(([t_0], t)) if t[0] > t_0 else t


def record_times(t_span: tuple[float, float], every: int, t_eval: Any) -> tuple[np.ndarray, int]:
    """The times to record and 0, or start and end and to record every so many steps."""
    t_0, t_1 = as_span(t_span)
    if t_eval is None:
        return np.array([t_0, t_1]), as_count("every", every)
    return as_record_times(t_eval, t_0, t_1), 0
