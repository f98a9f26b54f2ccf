"""The jump of the velocities between two phases of a motion, as a smooth function of the state before.

    u_+ = u_- + M^-1 (W_N^T P_N + W_F^T P_F)

With the outcome at every struck contact known, the impulses are the solution of linear equations:

    gamma_N+ = -e_N gamma_N-    (0 of a contact that stays closed, as after an impact without collision)
    gamma_F+ = -e_F gamma_F-    where it sticks,    P_F = -s mu P_N    where it slides with the sign s

mu is that of the mean sliding velocity of the impact. The only contact of a system may follow the impulse map of its
own law of impact instead. Complex states are taken, so that the jump can be differentiated exactly. The impacts are
those of integrators/event_driven/impact.py. Source: Leine, Nijmeijer, *Dynamics and Bifurcations of Non-Smooth
Mechanical Systems* (2004), section 7.4.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nonsmooth.cycles.mode_flow import ModeFlow, mu_of
from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.impact import first_phase, follows_own_law, impulse_map
from nonsmooth.mechanics.laws import LAW_E_F, LAW_E_N, LAW_IMPACT
from nonsmooth.mechanics.system import GIVEN_FORCE, MASS, NORMAL, TANGENT
from nonsmooth.numerics.complex_step import complexified
from nonsmooth.results.events import Event

impulses_of_law, slide_of = complexified(impulse_map), complexified(first_phase)
STOPPED_VELOCITY = 1e-7  # chosen: of the velocity before: what is left of one that the impact brings to zero
SAME_IMPULSES = 1e-5  # chosen: of the jump: so far the impulses found here may lie from those of the simulation
SOLVED_MU = 1e-14  # chosen: change of mu at which the friction law has its velocity
IMPULSE_SWEEPS = 200  # chosen: of Gauss–Seidel on the contacts that an impact joins


class Blow(NamedTuple):
    """What one struck contact does: whether it rebounds with its restitution; whether it sticks, or slides with the
    sign ``slip`` (0: it has no friction)."""

    contact: int
    rebounds: bool
    sticks: bool
    slip: int


class Jump(NamedTuple):
    """What the contacts that are struck at one instant do; ``closing`` are those that were open before."""

    blows: tuple[Blow, ...]
    closing: tuple[int, ...]
    has_own_law: bool  # the impulse map of the contact's law of impact instead of the blows


def read_jump(flow: ModeFlow, before: np.ndarray, after: np.ndarray, events: list[Event]) -> Jump:
    """The jump between two recorded states of an instant, of which the events tell.

    Raises
    ------
    InvalidInput
        When it is no single impact.
    """
    system = flow.system
    if system.d > 1:
        raise InvalidInput(
            f"the motion passes an impact with friction in two directions at t = {flow.t:.6g} s; cycles through these "
            "are not computed"
        )
    gamma_minus = flow.row_velocities(*flow.parts(before)).real
    gamma_plus = flow.row_velocities(*flow.parts(after)).real
    blows = []
    for event in events:
        i = event.contact
        if event.P_N == 0 or system.kinds[i, 0] == GIVEN_FORCE:
            continue
        fastest = STOPPED_VELOCITY * max(np.abs(gamma_minus[i]).max(), np.abs(gamma_plus[i]).max())
        rebounds = abs(gamma_plus[i, 0]) > fastest
        xi = gamma_plus[i, 1] + system.laws[i, LAW_E_F] * gamma_minus[i, 1] if system.kinds[i, 1] else 0.0
        sticks = bool(system.kinds[i, 1]) and abs(xi) <= fastest
        blows.append(Blow(i, rebounds, sticks, 0 if sticks else int(np.sign(xi))))
    struck = [blow.contact for blow in blows]
    closing = tuple(i for i in struck if (i, "gap") in flow.margins(before))
    own = bool(closing) and system.n_c == 1 and follows_own_law.function(0, system.kinds, system.laws)
    jump = Jump(tuple(blows), closing, bool(own))
    missed = np.abs(apply_jump(jump, flow, before).real - after).max()
    if not blows or missed > SAME_IMPULSES * np.abs(after - before).max():
        raise InvalidInput(
            f"at t = {events[0].t if events else flow.t:.6g} s several impacts follow one another in one instant; "
            "cycles through them are not computed"
        )
    return jump


def apply_jump(jump: Jump, flow: ModeFlow, x: np.ndarray) -> np.ndarray:
    """The state after a jump; ``flow`` is any of the system."""
    q, u, t = flow.parts(x)
    M = flow.call(MASS, q, u, t)
    W = _rows(jump, flow, q, u, t)
    inverse = np.linalg.solve(M, W.T)
    G, gamma = W @ inverse, flow.row_velocities(q, u, t)[[blow.contact for blow in jump.blows]].ravel()
    P = _own(flow, G, gamma) if jump.has_own_law else _impulses(jump, flow, G, gamma)
    return np.concatenate([q, u + inverse @ P, x[q.size + u.size :]])


def _rows(jump: Jump, flow: ModeFlow, q: np.ndarray, u: np.ndarray, t: float) -> np.ndarray:
    """W_N and W_F of the struck contacts in turn, (k (1 + d), n)."""
    struck = [blow.contact for blow in jump.blows]
    W = [flow.call(NORMAL, q, u, t)[struck]]
    if flow.system.d:
        W.append(flow.call(TANGENT, q, u, t)[struck, 0])
    return np.stack(W, axis=1).reshape(-1, u.size)


def _impulses(jump: Jump, flow: ModeFlow, G: np.ndarray, gamma: np.ndarray) -> np.ndarray:
    """The impulses of contacts that follow Newton's law, (k (1 + d),)."""
    laws, width = flow.system.laws, 1 + flow.system.d
    A, b = G.copy(), np.zeros(gamma.size, complex)
    slides = [(k * width, blow) for k, blow in enumerate(jump.blows) if width == 2 and not blow.sticks]
    for k, blow in enumerate(jump.blows):
        a, i = k * width, blow.contact
        b[a] = -(1 + blow.rebounds * laws[i, LAW_E_N]) * gamma[a]
        if blow.sticks:
            b[a + 1] = -(1 + laws[i, LAW_E_F]) * gamma[a + 1]
    for a, _ in slides:
        A[a + 1] = 0
        A[a + 1, a + 1] = 1
    P = np.zeros_like(b)
    for _ in range(IMPULSE_SWEEPS):
        change = 0.0
        for a, blow in slides:
            mean = gamma[a + 1] + 0.5 * (G[a + 1] @ P)
            mu = mu_of(laws, blow.contact, blow.slip * mean if (blow.slip * mean).real > 0 else -blow.slip * mean)
            change = max(change, abs(A[a + 1, a] - blow.slip * mu))
            A[a + 1, a] = blow.slip * mu
        if change <= SOLVED_MU and P.any():
            break
        P = np.linalg.solve(A, b)
    return P


def _own(flow: ModeFlow, G: np.ndarray, gamma: np.ndarray) -> np.ndarray:
    """The impulses of the only contact by its own law of impact, (2,). Where no impulse stops its sliding, f = P_F/P_N
    and p = G_NN + f G_NF are constant, and all laws say P_N = -(1 + e) gamma_N/p."""
    laws = flow.system.laws
    mu = mu_of(laws, 0, gamma[1] if gamma[1].real > 0 else -gamma[1])
    law, e = int(laws[0, LAW_IMPACT]), laws[0, LAW_E_N]
    f, P_1 = slide_of(mu, G[0, 1], G[1, 1], gamma[1])
    if P_1 == np.inf:
        P_N = -(1 + e) * gamma[0] / (G[0, 0] + f * G[0, 1])
        return np.array([P_N, f * P_N])
    P_N, P_F, _, _ = impulses_of_law(law, e, mu, G[0, 0], G[0, 1], G[1, 1], gamma[0], gamma[1])
    return np.array([P_N, P_F])
