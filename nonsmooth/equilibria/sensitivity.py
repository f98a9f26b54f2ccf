"""How eigenvalues move with a parameter.

    ds/dp = w^H (dA/dp) v/(w^H v),    A v = s v,  w^H A = s w^H

of the companion matrix A(p), the equilibrium moving with p. dA/dp is a central difference with the step eps^(1/3) |p|:
truncation and rounding are both about 1e-10 of A. Source: Lancaster, *Numerische Mathematik* 6 (1964) 377.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from nonsmooth.checks.arrays import as_instance, as_name
from nonsmooth.equilibria.equilibrium import follow_equilibrium
from nonsmooth.equilibria.linearise import Linearisation, linearise
from nonsmooth.errors import InvalidInput
from nonsmooth.numerics.rounding import CENTRAL_INCREMENT


def eigenvalue_sensitivity(system: Any, parameter: str, at: Linearisation | None = None) -> np.ndarray:
    """ds/dp of every eigenvalue of steady sliding.

    Parameters
    ----------
    system : System or model
    parameter : str
    at : Linearisation, optional
        Of this system; ``linearise(system)`` when left out.

    Returns
    -------
    ndarray (2 n_r,) complex
        In the order of ``Linearisation.eigenvalues`` [1/s per unit of the parameter]; not finite where an eigenvalue is
        double and has one mode only, as on the boundary of flutter.

    Raises
    ------
    UnknownName
        When there is no such parameter.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> from nonsmooth.catalogue import BeltOscillator
    >>> slopes = ns.eigenvalue_sensitivity(BeltOscillator(), "c")
    >>> round(float(slopes[0].real), 9)  # Re s = -(c + N f')/(2 m)
    -0.5
    """
    from scipy.linalg import eig

    cure = "a Linearisation, as ns.linearise(system) gives"
    at = linearise(system) if at is None else as_instance("at", at, Linearisation, cure)
    p = parameter_value(at, parameter)
    s, w, v = eig(at.companion, left=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        slopes = np.einsum("ik,ij,jk->k", w.conj(), _derivative(at, parameter, p), v)
        slopes = slopes / np.einsum("ik,ik->k", w.conj(), v)
    return slopes[[int(np.abs(s - own).argmin()) for own in at.eigenvalues]]


def parameter_value(at: Linearisation, parameter: str) -> float:
    """The value of a numeric parameter of the linearised system."""
    values = at.equilibrium.mode.system.parameter_values
    return values[as_name("parameter", parameter, values)]


def _derivative(at: Linearisation, parameter: str, p: float) -> np.ndarray:
    """dA/dp, central; to one side where the other is out of the parameter's range."""
    h = CENTRAL_INCREMENT * (abs(p) or 1.0)

    def companion(value: float) -> np.ndarray:
        moved = follow_equilibrium(at.equilibrium, **{parameter: value})
        return linearise(moved.mode.system, moved).companion

    try:
        return (companion(p + h) - companion(p - h)) / (2 * h)
    except InvalidInput:
        return (4 * companion(p + h) - companion(p + 2 * h) - 3 * at.companion) / (2 * h)
