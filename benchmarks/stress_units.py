"""The same motion in other units: lengths times L, masses times B, times times T.

With powers of two every number of the run is the same up to its exponent, so the scaled runs agree bit for bit, unless
something in them has an absolute size. Located events and compliant contact have one: the tolerance atol serves
coordinates and velocities alike, so that with T = 1 and without angles it scales with L. SI against millimetre, tonne
and second (L = 1000, B = 1/1000) rounds otherwise: each of n + r terms of each coordinate in every step by EPS, and a
velocity that is off by so much moves the body for the rest of the run.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from benchmarks.stress_figures import EPS, Outcome, name_of
from nonsmooth.catalogue.entries import load
from nonsmooth.integrators.adaptive.options import Adaptive
from nonsmooth.integrators.event_driven.options import EventDriven
from nonsmooth.integrators.moreau_jean.options import MoreauJean
from nonsmooth.integrators.penalty.options import Penalty
from nonsmooth.results.solution import Solution
from nonsmooth.runs.simulate import simulate_whole

POWERS = ((2.0**10, 1, 1), (1, 2.0**-30, 1), (1, 1, 2.0**7), (2.0**-20, 2.0**12, 2.0**-5), (1, 2.0**13, 1))
MILLIMETRES = (1e3, 1e-3, 1.0)
DT, RTOL, ATOL, STIFFNESS = 1e-3, 1e-8, 1e-10, 1e6
TERMS = 3 + 4  # of a step of the block: three coordinates, two contacts with friction


class Trial(NamedTuple):
    """A motion in units scaled by (L, B, T), and how far it may be from the motion in SI."""

    scale: tuple[float, float, float]
    make: Callable[[tuple[float, float, float]], tuple[Any, np.ndarray, np.ndarray, np.ndarray]]
    integrator: Any
    scaled: Any
    bound: float

    @property
    def name(self) -> str:
        L, B, T = self.scale
        return f"{self.make.__name__} in other units, L = {L:.3g}, B = {B:.3g}, T = {T:.3g}"


def trials() -> Iterator[Trial]:
    """The scaled runs."""
    for scale in POWERS:
        yield Trial(scale, block, MoreauJean(DT), MoreauJean(DT * scale[2]), 0.0)
    for scale in POWERS[:2]:
        L, B, _ = scale
        yield Trial(scale, ball, EventDriven(RTOL, ATOL), EventDriven(RTOL, ATOL * L), 0.0)
        yield Trial(scale, ball, Adaptive(RTOL, ATOL), Adaptive(RTOL, ATOL * L), 0.0)
        soft = Penalty(STIFFNESS, damping_ratio=0.5, rtol=RTOL, atol=ATOL)
        yield Trial(scale, ball, soft, replace(soft, stiffness=STIFFNESS * B, atol=ATOL * L), 0.0)
    steps = 0.4 / DT
    yield Trial(MILLIMETRES, block, MoreauJean(DT), MoreauJean(DT), TERMS * EPS * steps**2)
    for method in (EventDriven, Adaptive):
        yield Trial(MILLIMETRES, ball, method(RTOL, ATOL), method(RTOL, ATOL * 1e3), 100 * RTOL)


def block(scale: tuple[float, float, float]) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray]:
    """A rocking block, its start, and the units of its coordinates."""
    L, B, T = scale
    one = load("rocking-block")(mu=0.4, e=0.3)
    q0, u0 = one.state(tilt=0.2)
    model = replace(one, m=one.m * B, width=one.width * L, height=one.height * L, g=one.g * L / T**2)
    unit = np.array([L, L, 1.0])
    return model, q0 * unit, u0 * unit / T, unit


def ball(scale: tuple[float, float, float]) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray]:
    """A bouncing ball, its start, and the unit of its coordinate."""
    L, B, T = scale
    one = load("bouncing-ball")(e=0.8)
    q0, u0 = one.state(height=1.0)
    return replace(one, m=one.m * B, g=one.g * L / T**2), q0 * L, u0 * L / T, np.array([L])


def compare(trial: Trial) -> Outcome:
    """One motion in SI and in other units."""
    T, unit, nan = trial.scale[2], trial.make(trial.scale)[3], math.nan
    si, other = run(trial.make((1.0, 1.0, 1.0)), 1.0, trial.integrator), run(trial.make(trial.scale), T, trial.scaled)
    error = math.inf
    if si.q.shape == other.q.shape:
        errors = np.abs(other.q / unit - si.q).max(), np.abs(other.u * T / unit - si.u).max()
        error = float(max(errors) / max(np.abs(si.q).max(), np.abs(si.u).max()))
    failure = "" if si.success and other.success else other.status.name
    return Outcome(trial.name, name_of(trial.integrator), si.stats.steps, nan, nan, nan, nan, error,
                   (nan, nan, nan, nan, trial.bound), failure)  # fmt: skip


def run(model: tuple[Any, np.ndarray, np.ndarray, np.ndarray], T: float, integrator: Any) -> Solution:
    """0.4 s of a motion."""
    system, q0, u0, _ = model
    return simulate_whole(system, (0.0, 0.4 * T), q0, u0, integrator=integrator, on_failure="return")
