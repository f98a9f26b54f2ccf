"""First-order averaging of a weakly nonlinear oscillator with one coordinate.

    y'' + omega^2 y = g(y, y'),      y = a cos phi,  y' = -a omega sin phi
    a' = -1/(2 pi omega) int_0^{2 pi} g(a cos s, -a omega sin s) sin s ds

y is counted from steady sliding, omega^2 is the linear stiffness over the mass, g all the rest: damping, friction,
nonlinear springs. The error of the amplitudes is of the first order in the size of g. Where the mass overtakes the
surface it slides on, friction changes its sign: the integral is split there, and each arc is done by Gauss's rule with
as many points as it takes. Source: Bogoliubov and Mitropolsky, *Asymptotic Methods in the Theory of Non-Linear
Oscillations* (1961), chapter 1; see docs/theory/averaging.md for the closed forms.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.checks.arrays import as_non_negative, as_positive
from nonsmooth.equilibria.equilibrium import Equilibrium, as_equilibrium, equilibrium
from nonsmooth.equilibria.linearise import linearise
from nonsmooth.equilibria.oscillator import Oscillator
from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.initial_state import evaluate
from nonsmooth.mechanics.model_system import require_planar
from nonsmooth.mechanics.system import GIVEN_FORCE, TANGENT
from nonsmooth.numerics.rounding import rounding_of_sum
from nonsmooth.views import Worded, view

if TYPE_CHECKING:
    from pathlib import Path

FARTHEST_SPEED = 20.0  # chosen: default range of amplitudes: velocities up to this multiple of the sliding speed
NEAREST_SPEED = 1e-4  # chosen: and down to this
SCAN = 160  # chosen: amplitudes at which the sign of a' is looked at, evenly spaced in their logarithm
QUARTER_TURN_SAMPLES = 16  # chosen: of sin s on a quarter turn, between which sliding changes its sign at most once
FEWEST_GAUSS_POINTS, MOST_GAUSS_POINTS = 16, 1024  # chosen: Gauss points on an arc
INTEGRAL_TOLERANCE = 1e-12  # chosen: of the integral, relative to the integral of |g|
FORCE_ROUNDINGS = 36  # chosen: of g, relative to the spring's force at the equilibrium


@dataclass(frozen=True, eq=False, repr=False)
class AveragedMotion(Worded):
    """The averaged amplitude equation and its equilibria.

    Attributes
    ----------
    omega : float
        Frequency of the motion [rad/s].
    amplitudes : ndarray (k,)
        Equilibria of the amplitude equation, in the unit of the coordinate, increasing; the first is 0, steady sliding.
    is_stable : ndarray (k,) of bool
    overtakes : ndarray (k,) of bool
        Whether the mass overtakes the surface it slides on.
    equation : AmplitudeEquation
        a' as a function of a; its ``at`` is the steady sliding about which the motion swings.
    """

    omega: float
    amplitudes: np.ndarray
    is_stable: np.ndarray
    overtakes: np.ndarray
    equation: AmplitudeEquation

    @property
    def amplitude(self) -> float:
        """The stable amplitude that a small disturbance of steady sliding reaches: 0 where it dies out, inf if none."""
        stable = self.amplitudes[self.is_stable]
        return float(stable[0]) if stable.size else math.inf

    def rate(self, a: float) -> float:
        """a' at an amplitude a >= 0, per second."""
        return self.equation(as_non_negative("a", a))

    def plot(self, path: str | Path | None = None) -> Any:
        """The averaged rate against the amplitude, with its equilibria: see `plot_averaged`."""
        return view(self, "plot")(self, path)


def averaged_amplitude(system: Any, at: Equilibrium | None = None, largest: float | None = None) -> AveragedMotion:
    """Amplitudes of the vibration about steady sliding, by first-order averaging.

    Parameters
    ----------
    system : System or model
        With one coordinate; contacts with a given normal force only.
    at : Equilibrium, optional
        Steady sliding; ``equilibrium(system)`` when left out.
    largest : float, optional
        Amplitude up to which equilibria are looked for; when left out, that with twenty times the sliding velocity.

    Returns
    -------
    AveragedMotion

    Raises
    ------
    InvalidInput
        When there are several coordinates or a contact with a gap, when steady sliding has no positive stiffness, or
        when the range of amplitudes must be given.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> from nonsmooth.catalogue import BeltOscillator
    >>> motion = ns.averaged_amplitude(BeltOscillator(vb=0.42))
    >>> [round(float(a), 7) for a in motion.amplitudes], motion.is_stable.tolist()
    ([0.0, 0.0849575], [False, True])
    """
    at = equilibrium(system) if at is None else as_equilibrium(at)
    require_planar(at.mode.system, "averaged_amplitude")
    if at.q.size != 1 or (at.mode.system.kinds[:, 0] != GIVEN_FORCE).any():
        raise InvalidInput("averaging needs one coordinate and no contact with a gap; use simulate for this system")
    small = linearise(at.mode.system, at)
    square = float(small.K[0, 0] / small.M[0, 0])
    if not square > 0:
        raise InvalidInput(f"steady sliding has the stiffness {small.K[0, 0]:g}; averaging needs a positive one")
    omega = math.sqrt(square)
    reach = _reach(at, omega)
    if largest is None and not reach > 0:
        raise InvalidInput("nothing slides in this system, so the range of amplitudes is not known; give largest=")
    top = FARTHEST_SPEED * reach if largest is None else as_positive("largest", largest)
    bottom = NEAREST_SPEED * (min(reach, top) if reach > 0 else top)
    if not bottom > 0:
        raise InvalidInput(f"largest must be an amplitude above the rounding of zero; got {top:g}")
    equation = AmplitudeEquation(at, omega)
    roots, stable = _equilibria(equation, bottom, top, reach)
    amplitudes = np.array([0.0, *roots])
    is_stable = np.array([small.growth < 0, *stable])
    return AveragedMotion(omega, amplitudes, is_stable, (amplitudes > reach) & (reach > 0), equation)


class AmplitudeEquation:
    """a' of an oscillator about steady sliding, by quadrature."""

    def __init__(self, at: Equilibrium, omega: float) -> None:
        self.at, self.omega = at, omega
        self._oscillator = Oscillator(at.mode.system, at.mode.t)

    def __call__(self, a: float) -> float:
        """a' [unit of the coordinate per second]."""
        if a == 0:
            return 0.0
        ends = self._arcs(a)
        total = sum(self._gauss(a, start, end) for start, end in zip(ends[:-1], ends[1:], strict=True))
        return -total / (2 * math.pi * self.omega)

    def _states(self, a: float, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return self.at.q[0] + a * np.cos(s), -a * self.omega * np.sin(s)

    def _integrand(self, a: float, s: np.ndarray) -> np.ndarray:
        """g(a cos s, -a omega sin s) sin s."""
        acceleration, _ = self._oscillator.accelerations(*self._states(a, s))
        return (acceleration + self.omega**2 * a * np.cos(s)) * np.sin(s)

    def _arcs(self, a: float) -> list[float]:
        """0, 2 pi, and the phases between them at which a contact's sliding changes its sign."""
        from scipy.optimize import brentq

        def sliding(s: float, i: int) -> float:
            return float(self._oscillator.accelerations(*self._states(a, np.array([s])))[1][i, 0])

        quarter = np.arcsin(np.linspace(0.0, 1.0, QUARTER_TURN_SAMPLES))  # the largest velocity is among the samples
        half = np.concatenate([quarter, math.pi - quarter[-2::-1]])
        phases = np.concatenate([half, math.pi + half[1:]])
        found = [0.0, 2 * math.pi]
        for i, gamma in enumerate(self._oscillator.accelerations(*self._states(a, phases))[1]):
            for k in np.flatnonzero((gamma[:-1] < 0) != (gamma[1:] < 0)):
                found.append(brentq(sliding, phases[k], phases[k + 1], (i,), xtol=1e-15, rtol=1e-15))
        return sorted(found)

    def _gauss(self, a: float, start: float, end: float) -> float:
        """Integral over an arc by Gauss-Legendre rules of 16, 32, ... points, until two agree."""
        rounding = rounding_of_sum(FORCE_ROUNDINGS, self.omega**2 * (abs(self.at.q[0]) + a) * (end - start))
        before, n = math.inf, FEWEST_GAUSS_POINTS
        while True:
            x, w = _rule(n)
            values = self._integrand(a, start + (end - start) * x)
            integral, size = (end - start) * float(w @ values), (end - start) * float(w @ np.abs(values))
            if abs(integral - before) <= INTEGRAL_TOLERANCE * size + rounding or n >= MOST_GAUSS_POINTS:
                return integral
            before, n = integral, 2 * n


@functools.cache
def _rule(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Points and weights on [0, 1]."""
    x, w = np.polynomial.legendre.leggauss(n)
    return 0.5 * (1 + x), 0.5 * w


def _reach(at: Equilibrium, omega: float) -> float:
    """Amplitude at which the mass first keeps up with a surface it slides on; 0 where nothing slides."""
    W_F = evaluate(at.mode.system, TANGENT, at.mode.t, at.q, at.q)
    speeds = [abs(at.gamma_F[i] / W_F[i, 0, 0]) for i in at.mode.closed if W_F[i, 0, 0] != 0]
    return min(speeds, default=0.0) / omega


def _equilibria(rate: Any, bottom: float, top: float, reach: float) -> tuple[list[float], list[bool]]:
    """Amplitudes at which a' changes its sign, and whether it falls there."""
    from scipy.optimize import brentq

    grid = np.geomspace(bottom, top, SCAN)
    if bottom < reach < top:  # there friction begins to change its sign, with a vertical tangent of a'
        grid = np.sort(np.concatenate([grid, reach * np.array([1.0 - 1e-9, 1.0 + 1e-6, 1.0 + 1e-3])]))
    values = np.array([rate(a) for a in grid])
    roots, stable = [], []
    for k in np.flatnonzero((values[:-1] < 0) != (values[1:] < 0)):
        roots.append(float(brentq(rate, grid[k], grid[k + 1], xtol=1e-300, rtol=1e-13)))
        stable.append(bool(values[k] > 0))
    return roots, stable
