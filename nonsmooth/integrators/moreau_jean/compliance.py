"""A spring and damper at every contact, implicit in the step of Moreau–Jean: penalty at the cost of a rigid contact.

With theta = 1 the gap at the end is g_1 = g_0 + dt gamma_1, and the impulse of the force there is

    P_N = -dt (k g_1 + c gamma_1)    or    0 <= P_N  _|_  gamma_1 + R P_N + dt k R g_0 >= 0,    R = 1/(k dt^2 + c dt)

a contact problem with R on the diagonal of G. It is stable for every k and dt where p > 0; where p < 0 the sign of p
+ R decides: a soft contact, or a short step, has one solution, a stiff one the paradox of rigid contact. As k -> inf
it becomes the rigid step without restitution, with the whole gap fed back. Closed are the contacts whose gap would be
lost by the end of the step. Source: Acary, Brogliato, *Numerical Methods for Nonsmooth Dynamical Systems* (2008),
section 10.1; docs/penalty.md, (6).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from nonsmooth.checks.arrays import as_non_negative, as_positive
from nonsmooth.jit import kernel
from nonsmooth.mechanics.laws import LAW_E_F
from nonsmooth.mechanics.system import GIVEN_FORCE


@dataclass(frozen=True)
class Compliance:
    """A compliant contact law of `MoreauJean`, in place of the restitution e_N.

    Parameters
    ----------
    stiffness : float
        k [N/m] of every contact; inf is the rigid limit.
    damping : float
        c [N s/m].

    Raises
    ------
    InvalidInput
        Unless k > 0 and c >= 0.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> ns.MoreauJean(dt=1e-3, theta=1.0, compliance=ns.Compliance(stiffness=1e6))
    MoreauJean(dt=0.001, theta=1.0, projection=False, compliance=Compliance(stiffness=1000000.0, damping=0.0))
    """

    stiffness: float
    damping: float = 0.0

    def __post_init__(self) -> None:
        if not (isinstance(self.stiffness, float) and self.stiffness == math.inf):
            object.__setattr__(self, "stiffness", as_positive("stiffness", self.stiffness, "N/m"))
        object.__setattr__(self, "damping", as_non_negative("damping", self.damping, "N s/m"))


@kernel
def add_compliance(sys, n_k, k, c, dt, work):
    """G_NN + R and the term of the gap on the right; work.g_N holds the gap that free flight would end with."""
    closed, start, gamma_0 = work.closed, work.start, work.gamma_0
    R = 1.0 / (k * dt * dt + c * dt)
    for m in range(n_k):
        i = closed[m]
        r = start[m]
        if sys.kinds[i, 0] != GIVEN_FORCE:
            work.G[r, r] += R
            work.c[r] += (work.g_N[i] - dt * gamma_0[r]) / (dt + c / k)
            r += 1
        for axis in range(sys.kinds[i, 1]):
            work.c[r + axis] += sys.laws[i, LAW_E_F] * gamma_0[r + axis]


@kernel
def find_end_gaps(sys, n_k, dt, work):
    """Replace the gaps of the closed contacts by g_0 + dt gamma_1: their indentation at the end."""
    n = sys.n
    for m in range(n_k):
        i = work.closed[m]
        if sys.kinds[i, 0] == GIVEN_FORCE:
            continue
        r = work.start[m]
        gamma_1 = work.w[r]
        for j in range(n):
            gamma_1 += work.W[r, j] * work.u_1[j]
        work.g_N[i] += dt * (gamma_1 - work.gamma_0[r])
