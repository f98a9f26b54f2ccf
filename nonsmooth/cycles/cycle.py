"""A periodic motion: its phases, its Floquet multipliers, its extremes."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.cycles.flow_map import flow_curve
from nonsmooth.cycles.jump import Jump
from nonsmooth.cycles.mode_flow import ContactState, Margin, mode_flow
from nonsmooth.cycles.phase import PhaseGuess
from nonsmooth.mechanics.system import ContactMode, System
from nonsmooth.results.events import mode_name
from nonsmooth.views import Worded, view

if TYPE_CHECKING:
    from pathlib import Path

RATE_PIECES = 48  # chosen: of a phase, between which its rates change their sign at most once
ATTRACTING = 1e-7  # chosen: a multiplier must lie so far inside the unit circle to count as attracting
REPELLING = 1e-6  # derived: and so far outside to count as repelling: the accuracy of multipliers


@dataclass(frozen=True, eq=False)
class CyclePhase:
    """One phase of a cycle.

    Attributes
    ----------
    states : tuple of ContactState
        What each contact does.
    begins, duration : float
        Since the beginning of the cycle [s].
    x : ndarray (2 n_q,)
        The state (q, u) at the beginning; under an excitation (q, u, t).
    ends_by : tuple (contact, kind) or None
        The margin that vanishes at the end: "gap", "slip", "normal", "friction +" or "friction -".
    jump : Jump or None
        Of the velocities at the end.
    """

    states: tuple[ContactState, ...]
    begins: float
    duration: float
    x: np.ndarray
    ends_by: Margin | None
    jump: Jump | None = None

    @property
    def q(self) -> np.ndarray:
        """Coordinates at the beginning (n_q,)."""
        return self.x[: self.x.size // 2]

    @property
    def u(self) -> np.ndarray:
        """Velocities at the beginning (n_q,)."""
        n = self.x.size // 2
        return self.x[n : 2 * n]

    @property
    def label(self) -> str:
        """What the contacts do, in words."""
        states = self.states
        words = [f"{mode_name(state.mode, state.slip)}{', pulled' if state.normal < 0 else ''}" for state in states]
        return "; ".join(words)

    @property
    def sticks(self) -> bool:
        """Whether a contact sticks."""
        return any(state.mode == ContactMode.STICK for state in self.states)


@dataclass(frozen=True, eq=False, repr=False)
class LimitCycle(Worded):
    """A periodic motion.

    Attributes
    ----------
    system : System
    phases : tuple of CyclePhase
    t : ndarray (k,)
        Times of one period [s], with the states q, u (k, n_q).
    multipliers : ndarray (2 n_r - 1,), or (2 n_r,) under an excitation
        Floquet multipliers in the directions that the constraints leave, by decreasing modulus, without the 1 that
        belongs to a shift in time, and those of the drift. Their accuracy is the square root of the integration's,
        1e-6.
    time_shift : float
        |multiplier - 1| of these, the largest: zero but for rounding.
    residual : float
        Largest mismatch of the phases, relative to the extent of the motion.
    scale : ndarray (2 n_q,)
        That extent; under an excitation (2 n_q + 1,) with its period.
    forcing : float or None
        Period of the excitation [s].
    drift : ndarray (n_q,)
        How far each coordinate goes on in a period; zero of those that come back.
    drifts : bool
        Whether the cycle closes but for a shift along directions in which the system does not change.
    """

    system: System
    phases: tuple[CyclePhase, ...]
    t: np.ndarray
    q: np.ndarray
    u: np.ndarray
    multipliers: np.ndarray
    time_shift: float
    residual: float
    scale: np.ndarray
    forcing: float | None = None
    drift: np.ndarray = field(default_factory=lambda: np.zeros(0))
    drifts: bool = False

    first = ("period", "stick_duration", "is_stable")  # of what it says

    def plot(self, path: str | Path | None = None) -> Any:
        """Draw the phase planes (needs the extra [plot]); returns the Matplotlib figure, saved to ``path`` if given."""
        return view(self, "plot")(self, path)

    @property
    def period(self) -> float:
        """[s]"""
        return float(sum(phase.duration for phase in self.phases))

    @property
    def stick_duration(self) -> float:
        """How long a contact sticks in a period [s]."""
        return float(sum(phase.duration for phase in self.phases if phase.sticks))

    @property
    def is_stable(self) -> bool:
        """Whether every multiplier lies inside the unit circle."""
        return bool((np.abs(self.multipliers) < 1 - ATTRACTING).all())

    @property
    def is_marginal(self) -> bool:
        """Whether none lies outside and one on the unit circle, as far as the accuracy shows: of a family of motions,
        as of an undamped oscillator, or where the stability changes."""
        return not self.is_stable and bool((np.abs(self.multipliers) < 1 + REPELLING).all())

    @cached_property
    def extremes(self) -> tuple[np.ndarray, np.ndarray]:
        """Least and largest (q, u), (2 n_q,) each; of coordinates that go on, without their mean motion."""
        return _extremes(self)

    @property
    def amplitudes(self) -> np.ndarray:
        """(max q - min q)/2 of each coordinate; of those that go on, without their mean motion."""
        low, high = self.extremes
        return 0.5 * (high - low)[: self.system.n_q]

    @property
    def has_time(self) -> bool:
        """Whether the states end with their time: under an excitation, or a drive that goes on."""
        return self.phases[0].x.size > 2 * self.system.n_q

    @property
    def closing(self) -> dict[str, Any]:
        """How a cycle nearby closes, as `Shooting` takes it."""
        return {"forcing": self.forcing, "drifts": self.drifts}

    def guesses(self) -> list[PhaseGuess]:
        """The phases as a guess for a cycle nearby."""
        return [PhaseGuess(phase.states, phase.x, phase.duration, phase.jump) for phase in self.phases]

    def sequence(self) -> tuple[tuple[ContactState, ...], ...]:
        """What the contacts do, phase by phase."""
        return tuple(phase.states for phase in self.phases)


def _extremes(cycle: LimitCycle) -> tuple[np.ndarray, np.ndarray]:
    """Least and largest of every state: from samples, then the vertex where the rate changes its sign."""
    from scipy.optimize import brentq

    n = cycle.system.n_q
    mean = np.zeros(2 * n)  # rates at which coordinates go on
    mean[: cycle.drift.size] = cycle.drift / cycle.period
    x = np.concatenate([cycle.q, cycle.u], axis=1) - np.outer(cycle.t, mean)
    low, high = x.min(axis=0), x.max(axis=0)
    for phase in cycle.phases:
        flow = mode_flow(cycle.system, phase.states)
        curve = flow_curve(flow, phase.x, phase.duration, cycle.scale, pieces=RATE_PIECES)
        s = np.linspace(0, phase.duration, RATE_PIECES + 1)
        rates = np.array([flow.rate(x).real for x in curve(s).T])[:, : 2 * n] - mean
        for k, j in zip(*np.nonzero(rates[:-1] * rates[1:] < 0), strict=True):
            vertex = brentq(lambda s, j=j, c=curve, f=flow: f.rate(c(s)).real[j] - mean[j], s[k], s[k + 1], xtol=1e-14)
            value = curve(vertex)[j] - mean[j] * (phase.begins + vertex)
            low[j], high[j] = min(low[j], value), max(high[j], value)
    return low, high
