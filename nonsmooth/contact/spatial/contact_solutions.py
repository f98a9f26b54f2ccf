"""Every solution of one contact, of a step or at an instant of rest: free, stick, and each slide.

The list is that of all_solutions.py; how many slides there are is known exactly (exact_count.py), so that none can be
missing where both agree.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from nonsmooth.checks.arrays import as_non_negative, as_square_matrix, as_vector
from nonsmooth.contact.planar.single import FREE, STICK
from nonsmooth.contact.spatial.all_solutions import SLIDE, OneContact, list_of_one
from nonsmooth.contact.spatial.exact_count import count_slides
from nonsmooth.errors import InvalidInput
from nonsmooth.jit.blocks import new
from nonsmooth.numerics.rounding import rounding_of_sum

MODES = {FREE: "free", STICK: "stick", SLIDE: "slide"}
SINGULAR_ROUNDINGS = 900  # chosen: of the largest entry of G: an eigenvalue of S below is none


@dataclass(frozen=True, eq=False)
class ContactSolutions:
    """Every solution of one contact with friction.

    Attributes
    ----------
    modes : tuple of str
        "free" (no impulse), "stick" or "slide", of each solution.
    P : ndarray (m, n)
        Impulses (N, T1[, T2]) [N s] of each.
    gamma : ndarray (m, n)
        Velocities G P + c [m/s].
    is_complete : bool
        Whether no solution can be missing: the number of slides is the exact one of these G, c and mu, and S is
        regular.
    """

    modes: tuple[str, ...]
    P: np.ndarray
    gamma: np.ndarray
    is_complete: bool

    def __len__(self) -> int:
        return len(self.modes)


def contact_solutions(G: Any, c: Any, mu: float, mu_static: float | None = None) -> ContactSolutions:
    """Find every solution of one contact with Coulomb friction, in the plane or in space.

    gamma = G P + c; the contact is free (P = 0, gamma_N >= 0), sticks (gamma = 0, |P_T| <= mu P_N), or slides
    (gamma_N = 0, P_T = -mu P_N gamma_T/|gamma_T|): one contact of a time step, or forces and accelerations at rest.

    Parameters
    ----------
    G : array_like (2, 2) or (3, 3)
        Delassus matrix [1/kg], rows N, T1[, T2].
    c : array_like (2,) or (3,)
        Velocity without impulses [m/s].
    mu : float
        Friction coefficient.
    mu_static : float, optional
        Of sticking; mu when left out.

    Returns
    -------
    ContactSolutions

    Raises
    ------
    InvalidInput
        For another size, an entry that is not finite, and mu < 0.

    Notes
    -----
    At most free, stick and four slides; several slides also where p > 0 along every direction.
    Source: Bonnefon and Daviet, Quartic formulation of Coulomb 3D frictional contact, INRIA RT-0400 (2011).

    Examples
    --------
    >>> import nonsmooth as ns
    >>> G = [[1.0, 0.8, 0.0], [0.8, 1.0, 0.0], [0.0, 0.0, 1.0]]
    >>> found = ns.contact_solutions(G, [0.5, -1.0, 0.0], mu=2.0)
    >>> found.modes, found.P[:, 0].round(4).tolist(), found.is_complete
    (('free',), [0.0], True)
    """
    G, c, mu = as_square_matrix("G", G), as_vector("c", c), as_non_negative("mu", mu)
    n = len(G)
    if n not in (2, 3) or len(c) != n:
        raise InvalidInput(f"G of one contact is (2, 2) or (3, 3), and c as long; got {G.shape} and {c.shape}")
    mu_static = mu if mu_static is None else as_non_negative("mu_static", mu_static)
    modes, P, is_complete = solutions_of_one(G, c, mu, mu_static)
    return ContactSolutions(modes, P, P @ G.T + c, is_complete)


def solutions_of_one(
    G: np.ndarray, c: np.ndarray, mu: float, mu_static: float
) -> tuple[tuple[str, ...], np.ndarray, bool]:
    """Modes, impulses (m, n), and whether none is missing, of n = 2 or 3 rows."""
    n, contact = len(G), new(OneContact)
    contact.G[0, :n, :n], contact.c[:n], contact.mu, contact.mu_static = G, c, mu, mu_static
    if n == 2:  # planar friction: a direction of its own, along which nothing moves
        contact.G[0, 2, 2] = G[1, 1]
    found = list_of_one(contact.address)
    codes = contact.modes[:found]
    is_complete = are_all_slides(contact.G[0], contact.c, mu, int((codes == SLIDE).sum()))
    return tuple(MODES[code] for code in codes.tolist()), contact.P[:found, :n].copy(), is_complete


def are_all_slides(G: np.ndarray, c: np.ndarray, mu: float, slides: int) -> bool:
    """Whether a contact with G (3, 3) has so many slides and no more, and S is regular."""
    return is_regular(G) and (mu == 0.0 or count_slides(G, c, mu) == slides)


def is_regular(G: np.ndarray) -> bool:
    """Whether S is positive definite beyond rounding."""
    if not G[0, 0] > 0.0:
        return False
    S = G[1:, 1:] - np.outer(G[1:, 0], G[0, 1:]) / G[0, 0]
    return bool(np.linalg.eigvalsh(0.5 * (S + S.T))[0] > rounding_of_sum(SINGULAR_ROUNDINGS, np.abs(G).max()))
