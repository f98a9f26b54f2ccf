"""Observed orders of convergence, and which law an error follows.

    p_i = ln(e_(i+1)/e_i) / ln(x_(i+1)/x_i),    ln e = ln C + ln f(x),  least squares in C (and p)

x is a stiffness k (the error falls as it grows), a step dt or a tolerance rtol. The laws tried are those that occur:
k^-1 in regular contact, ln k/k after a seizure, k^-1/2 where a force jumps or a contact vibrates, k^-1/2 ln k in an
impact without collision; dt and dt^2 for steps; rtol, and rtol^5/4 of a method of order 5 whose error estimate is of
order 4 (dt ~ rtol^1/4); and a free power.
Source: Roache, *J. Fluids Eng.* 116 (1994) 405 (observed orders).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

LAWS: dict[str, dict[str, Callable[[np.ndarray], np.ndarray]]] = {
    "stiffness": {
        "k^-1": lambda k: 1 / k,
        "ln k/k": lambda k: np.log(k) / k,
        "k^-1/2": lambda k: k**-0.5,
        "k^-1/2 ln k": lambda k: k**-0.5 * np.log(k),
    },
    "dt": {"dt": lambda dt: dt, "dt^2": lambda dt: dt**2, "dt^1/2": lambda dt: dt**0.5},
    "rtol": {"rtol": lambda rtol: rtol, "rtol^5/4": lambda rtol: rtol**1.25},
}
LEAST_KNOWN = 3  # chosen: errors: two lie on any law
SPREAD = 0.5  # chosen: of ln(error/fit): a factor of 1.6 up and down
POWER = {"stiffness": "k^{:.3g}", "dt": "dt^{:.3g}", "rtol": "rtol^{:.3g}"}


@dataclass(frozen=True)
class Fit:
    """A law that errors were fitted by.

    Attributes
    ----------
    law : str
    constant : float
        C in error = C f(x).
    spread : float
        Standard deviation of ln(error/fit): 0.01 means 1 %.
    """

    law: str
    constant: float
    spread: float

    def __str__(self) -> str:
        return f"{self.constant:.4g} {self.law} ({100 * self.spread:.2g} %)"


def observed_orders(x: np.ndarray, errors: np.ndarray) -> np.ndarray:
    """Exponents between neighbours, (n - 1,); NaN where an error is not known."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.diff(np.log(errors)) / np.diff(np.log(x))


def fit_laws(of: str, x: np.ndarray, errors: np.ndarray) -> list[Fit]:
    """The laws that fit the errors that are known, the closest first; the free power is last.

    Parameters
    ----------
    of : {"stiffness", "dt", "rtol"}
    x, errors : ndarray (n,)
        Errors that are NaN or not positive are left out; with fewer than three nothing is fitted. A law from which the
        errors spread by more than SPREAD is none.
    """
    known = np.isfinite(errors) & (errors > 0)
    x, errors = x[known], np.log(errors[known])
    if len(x) < LEAST_KNOWN:
        return []
    fits = []
    for law, shape in LAWS[of].items():
        offset = errors - np.log(shape(x))
        fits.append(Fit(law, float(np.exp(offset.mean())), float(offset.std())))
    power, constant = np.polyfit(np.log(x), errors, 1)
    free = Fit(POWER[of].format(power), float(np.exp(constant)), float((errors - constant - power * np.log(x)).std()))
    return [fit for fit in (*sorted(fits, key=lambda fit: fit.spread), free) if fit.spread <= SPREAD]
