"""Critical friction: the least coefficient with which a contact can be paradoxical at a configuration.

    p = G_NN - mu G_NF d < 0,  |d| = 1,    needs    mu > G_NN/|G_NF|

which the direction d of G_NF meets first; in the plane d is a sign.
For the slender rod it is (1 + 3 cos^2 th)/(3 sin th cos th), least at arctan 2 with 4/3. Source: Génot, Brogliato,
*Eur. J. Mech. A/Solids* 18 (1999) 653; docs/theory/painleve.md, (3) and (4).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.checks.arrays import as_number, as_vector
from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.model_system import as_system
from nonsmooth.mechanics.start import start_of
from nonsmooth.mechanics.system import MASS, NORMAL, TANGENT, System
from nonsmooth.scenes.given import as_model

SCANNED = 400  # chosen: points of a range, between which the critical friction is taken to have one minimum at most
ANGLE = 1e-12  # chosen: G_NF below this part of sqrt(G_NN G_FF) is rounding: no friction couples sliding to the gap


class LeastFriction(NamedTuple):
    """The least critical friction over a range."""

    mu: float  # coefficient [-]; inf if no friction is critical anywhere
    at: float  # the coordinate's value there


def critical_friction(system: Any, q: Any = None, contact: int | str = 0, *, t: float = 0.0) -> float:
    """G_NN/|G_NF| of a contact: above it p < 0 for some direction of sliding.

    Parameters
    ----------
    system : System, model, or Scene
    q : array-like (n_q,), optional
        Configuration, of a scene its start when left out; only its inertia counts, whether or not the contact is
        closed.
    contact : int or str
    t : float
        Time [s].

    Returns
    -------
    float
        The coefficient; inf where sliding does not feel the gap.

    Raises
    ------
    InvalidInput
        For a contact without friction or without a gap.

    Examples
    --------
    >>> import math
    >>> import nonsmooth as ns
    >>> from nonsmooth.catalogue import PainleveRod
    >>> rod = PainleveRod()
    >>> round(ns.critical_friction(rod, rod.state(th=math.pi / 3)[0]), 6)
    1.347151
    """
    q = configuration(system, q)
    system = as_system(as_model(system))
    i = checked_contact(system, contact)
    return _critical_friction(system, as_number("t", t, "s"), as_vector("q", q, system.n_q), i)


def least_critical_friction(system: Any, q: Any, coordinate: int | str, between: tuple[float, float],
                            contact: int | str = 0, *, t: float = 0.0) -> LeastFriction:  # fmt: skip
    """The least critical friction while one coordinate runs through a range, the others as in q.

    Parameters
    ----------
    system, q, contact, t
        As in `critical_friction`.
    coordinate : int or str
        Index of the coordinate, or its name where the model names them.
    between : (float, float)
        The range.

    Returns
    -------
    LeastFriction
        ``mu`` and the coordinate's value ``at`` which it is met, to rounding of a square root: about 1e-8.

    Examples
    --------
    >>> import math
    >>> import nonsmooth as ns
    >>> from nonsmooth.catalogue import PainleveRod
    >>> rod = PainleveRod()
    >>> least = ns.least_critical_friction(rod, rod.state()[0], "th", (0, math.pi / 2))
    >>> round(least.mu, 9), round(math.degrees(least.at), 4)
    (1.333333333, 63.4349)
    """
    from scipy.optimize import minimize_scalar

    q = configuration(system, q)
    system = as_system(as_model(system))
    i, j = checked_contact(system, contact), system.described.coordinate(coordinate)
    q, t = as_vector("q", q, system.n_q), as_number("t", t, "s")
    low, high = as_vector("between", between, 2)
    if not low < high:
        raise InvalidInput(f"between must be (low, high) with low < high; got ({low:g}, {high:g})")

    def slope(value: float) -> float:
        """1/mu, which is finite where mu is not: its maximum is sought."""
        there = q.copy()
        there[j] = value
        return -1.0 / _critical_friction(system, t, there, i)

    values = np.linspace(low, high, SCANNED + 1)
    best = int(np.argmin([slope(value) for value in values]))
    bracket = values[max(best - 1, 0)], values[min(best + 1, SCANNED)]
    found = minimize_scalar(slope, bounds=bracket, method="bounded", options={"xatol": 1e-12 * (high - low)})
    return LeastFriction(math.inf if found.fun == 0 else -1.0 / float(found.fun), float(found.x))


def configuration(system: Any, q: Any) -> Any:
    """q as it was given, or the start of a scene."""
    if q is not None:
        return q
    model = as_model(system)
    if model is system:
        raise InvalidInput("critical friction is that of a configuration; give q")
    return start_of(model, {})[0]


def _critical_friction(system: System, t: float, q: np.ndarray, i: int) -> float:
    u = np.zeros(system.n_u)
    W = np.vstack([system.evaluate(NORMAL, t, q, u)[i], system.evaluate(TANGENT, t, q, u)[i, : system.kinds[i, 1]]])
    G = W @ np.linalg.solve(system.evaluate(MASS, t, q, u), W.T)
    coupling = float(np.linalg.norm(G[0, 1:]))
    if not coupling > ANGLE * math.sqrt(G[0, 0] * np.trace(G[1:, 1:])):
        return math.inf
    return float(G[0, 0] / coupling)


def checked_contact(system: System, contact: int | str) -> int:
    """The index of a contact with a gap and friction."""
    contact = system.described.contact(contact)
    chosen = system.contacts[contact]
    if not chosen.has_friction or chosen.normal_force:
        raise InvalidInput(
            f"{system.described.contacts[contact]} has no friction or no gap; critical friction needs both"
        )
    return contact
