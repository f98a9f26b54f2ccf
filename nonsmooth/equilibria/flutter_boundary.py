"""The value of a parameter at which steady sliding loses its stability.

The bracket is halved until the verdict at its unstable end is that of the crossing; then the root of a function that
passes through zero is found to rounding:

    with damping                  max Re s
    without, divergence           det K_r
    without, flutter              ((s_1^2 - s_2^2)/2)^2, s_1 and s_2 the pair that meets on the imaginary axis
    negative inertia              det(W_N M^-1 R^T)

Without damping max Re s will not do: it is zero up to the boundary and rises as a square root beyond. Source: Bolotin,
*Nonconservative Problems of the Theory of Elastic Stability* (1963), section 2.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from nonsmooth.checks.arrays import as_name, as_vector
from nonsmooth.equilibria.equilibrium import Equilibrium, NotIsolated, as_equilibrium, equilibrium, follow_equilibrium
from nonsmooth.equilibria.linearise import Linearisation, Verdict, linearise
from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.model_system import as_rated
from nonsmooth.scenes.given import as_model
from nonsmooth.views import Worded

# chosen: 1/4096 of the bracket: near enough for one crossing, far enough for verdicts above rounding
BRACKET_HALVINGS = 12


@dataclass(frozen=True, eq=False, repr=False)
class StabilityBoundary(Worded):
    """Where steady sliding loses its stability.

    Attributes
    ----------
    parameter : str
    value : float
    verdict : Verdict
        On the unstable side.
    eigenvalue : complex
        The one that crosses, at the boundary [1/s].
    at : Linearisation
        At the boundary; just beyond it where the equilibrium itself vanishes or ceases to be isolated (divergence).
    """

    parameter: str
    value: float
    verdict: Verdict
    eigenvalue: complex
    at: Linearisation

    @property
    def frequency(self) -> float:
        """|Im s| at the boundary [rad/s]; zero for divergence."""
        return abs(self.eigenvalue.imag)


def flutter_boundary(
    system: Any, parameter: str, bracket: tuple[float, float], at: Equilibrium | None = None
) -> StabilityBoundary:
    """Find where steady sliding loses its stability, to about 1e-13 of the bracket's values.

    Parameters
    ----------
    system : System, model, or Scene
    parameter : str
    bracket : (low, high)
        One end stable, the other unstable; of several boundaries between them one is found.
    at : Equilibrium, optional
        Whose contacts and signs are kept; ``equilibrium`` at the first end when left out.

    Returns
    -------
    StabilityBoundary

    Raises
    ------
    InvalidInput
        When both ends are stable or both unstable, or no equilibrium is found on the way.
    UnknownName
        When there is no such parameter.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> from nonsmooth.catalogue import FollowerForceArm, ModeCoupling
    >>> round(ns.flutter_boundary(FollowerForceArm(), "P", (0.0, 2000.0)).value, 9)
    948.12655516
    >>> edge = ns.flutter_boundary(ModeCoupling(), "mu", (0.3, 0.8))
    >>> edge.verdict.name, round(edge.value, 9), round(edge.frequency, 6)
    ('FLUTTER', 0.522527017, 14.390328)
    """
    from scipy.optimize import brentq

    ends = as_vector("bracket", bracket, 2)
    system = as_rated(as_model(system), "flutter_boundary")
    as_name("parameter", parameter, system.parameter_values)
    start = equilibrium(system.with_parameters(**{parameter: float(ends[0])})) if at is None else as_equilibrium(at)

    def small(value: float) -> Linearisation:
        moved = follow_equilibrium(start, **{parameter: float(value)})
        return linearise(moved.mode.system, moved)

    stable, unstable = _sides(parameter, ends, small)
    has_damping = small(stable).verdict == Verdict.STABLE
    for _ in range(BRACKET_HALVINGS):
        middle = 0.5 * (stable + unstable)
        if _is_beyond(small(middle), has_damping):
            unstable = middle
        else:
            stable = middle
    before, beyond = small(stable), small(unstable)
    crossing = _crossing(beyond, has_damping)
    ends = np.array([crossing(before), crossing(beyond)])
    if ends[0] * ends[1] > 0:  # one end lies on the boundary to rounding
        value = (stable, unstable)[int(np.abs(ends).argmin())]
    else:
        value = brentq(_on_the_way(small, crossing), stable, unstable, xtol=1e-300, rtol=1e-15)
    verdict = beyond.verdict if beyond.has_negative_inertia else beyond.cause
    try:
        edge = small(value)
    except NotIsolated:
        edge = beyond
    return StabilityBoundary(parameter, float(value), verdict, _crossed(edge, beyond), edge)


def _on_the_way(
    small: Callable[[float], Linearisation], crossing: Callable[[Linearisation], float]
) -> Callable[[float], float]:
    """The crossing function of the parameter; zero where the equilibrium itself is singular, as it is at divergence."""

    def function(value: float) -> float:
        try:
            return crossing(small(value))
        except NotIsolated:
            return 0.0

    return function


def _sides(parameter: str, ends: np.ndarray, small: Callable[[float], Linearisation]) -> tuple[float, float]:
    """The stable and the unstable end."""
    low, high = (small(end).is_unstable for end in ends)
    if low == high:
        which = "unstable" if low else "stable"
        raise InvalidInput(
            f"steady sliding is {which} at both ends of the bracket, {parameter} = {ends[0]:g} and {ends[1]:g}; "
            "give a bracket with one stable end (ns.eigen_path shows where)"
        )
    return (ends[1], ends[0]) if low else (ends[0], ends[1])


def _is_beyond(small: Linearisation, has_damping: bool) -> bool:
    """Whether the motion is unstable; with damping to rounding, since its growth passes through zero with a slope."""
    return small.has_negative_inertia or small.growth > 0 if has_damping else small.is_unstable


def _crossing(beyond: Linearisation, has_damping: bool) -> Callable[[Linearisation], float]:
    """A smooth function of the linearised motion that vanishes at the boundary."""
    if beyond.verdict == Verdict.NEGATIVE_INERTIA:
        return lambda small: float(np.linalg.det(small.inertia))
    if has_damping:
        return lambda small: small.growth
    if abs(beyond.dominant.imag) <= 1e-6 * np.abs(beyond.eigenvalues).max():
        return lambda small: float(np.linalg.det(small.K))
    return lambda small: _split(small, beyond.dominant)


def _split(small: Linearisation, s: complex) -> float:
    """((s_1^2 - s_2^2)/2)^2 of the two eigenvalues above the real axis nearest to s and its mirror image."""
    upper = small.eigenvalues[small.eigenvalues.imag > 0]
    s_1, s_2 = upper[np.abs(upper.imag - s.imag).argsort()[:2]]
    return float((((s_1**2 - s_2**2) / 2) ** 2).real)


def _crossed(edge: Linearisation, beyond: Linearisation) -> complex:
    """The eigenvalue of the boundary nearest to the unstable one beyond; zero at divergence."""
    if edge is beyond:
        return 0j
    return complex(edge.eigenvalues[np.abs(edge.eigenvalues - beyond.dominant).argmin()])
