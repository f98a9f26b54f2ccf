"""Islands that the ladder of ``solve`` did not bring to the tolerance: solvers that are dearer, and rarely in vain.

    few bodies      interior points on the graph of all contacts, from many starts (``from_inside``)
    more bodies     and what these leave, on the graph of the contacts that press (``pressed``)
    some bodies     what that leaves, on the graph of all contacts
    few contacts    what these leave, by `solve_contact`, with the Delassus matrix G = J M^-1 J^T of the island

Some bodies of very unlike masses, that are met but not solved to rounding, come here too. That costs milliseconds, and
other islands that are met never come here. Where interior points led nowhere they are left out for a while; where
those of all starts came nearer and missed the tolerance, all starts but the first one wait, unless masses are very
unlike. Measured: of a wall of 100 bricks that a ball knocks over 80 steps take 12 s in place of 41, and 46 of them miss
1e-8 in place of 43, by 1e-6 in the median in place of 5e-7, at worst by 5e-5 in place of 3e-6.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from nonsmooth.contact.blocks.solve import solve_contact
from nonsmooth.contact.network.eliminated import without_joints
from nonsmooth.contact.network.from_inside import STARTS, STARTS_OF_FEW
from nonsmooth.contact.network.joint import JOINED
from nonsmooth.contact.network.matrices import softness
from nonsmooth.contact.network.patience import INTERIOR, OTHER_STARTS, note_outcome
from nonsmooth.contact.network.pressed import PRESSED_STARTS, contacts_of, solve_pressed, solve_whole
from nonsmooth.contact.network.problem import Network, judge_network
from nonsmooth.contact.network.solve import (
    BY_INTERIOR,
    EXACT_BODIES,
    FEW_BODIES,
    FINE,
    SOLVED_TO_ROUNDING,
    Solver,
    has_very_unlike_masses,
)
from nonsmooth.contact.network.solve import bodies_of as bodies_of_island
from nonsmooth.jit import interpreted

are_very_unlike, bodies_of = interpreted(has_very_unlike_masses), interpreted(bodies_of_island)
DENSE_CONTACTS = 40  # chosen: of an island: G has then 120 rows in space, and is solved in some milliseconds
# measured: of an island at rest of very unlike masses: stacks of prisms and cylinders, eight points between two, one of
# them 1e4 to 1e6 times heavier, factors leave at 1e-4; here they take 0.2 to 1.3 s, one to four times in a run
DENSE_RESTING_CONTACTS = 100
ALIKE = 0.1  # chosen: part of a velocity by which others differ from it at rest, for what the step before has left
DENSE_TOL = 1e-13  # chosen: of `solve_contact`, relative to |c|: the residual that counts is measured afterwards
FINE_OF_MANY = 1e-5  # chosen: a tolerance above it is one for speed where there are many bodies
WORTH_IT = 0.1  # chosen: part of the residual above which it was in vain


def rescue(network: Network, solver: Solver, tol: float) -> None:
    """Try the islands that are not met; what is no better is put back."""
    islands = network.islands
    unmet = [int(k) for k in np.flatnonzero(islands.is_met[: islands.count] == 0)]
    few = {k for k in unmet if len(contacts_of(network, k)) <= most_contacts(network, k)}
    for k in unmet:
        if may_go_inside(network, solver, k, tol):
            go_inside(network, solver, k, tol)
    for k in sorted(few):
        if not islands.residual[k] <= tol:
            solve_dense(network, k, tol)
    islands.is_met[unmet] = islands.residual[unmet] <= tol


def may_go_inside(network: Network, solver: Solver, k: int, tol: float) -> bool:
    """Whether island k is small enough, and the last ones were not in vain: of very unlike masses those may have been
    that were met, and few bodies are worth it."""
    most = solver.most_inside if tol <= FINE_OF_MANY else min(solver.most_inside, FEW_BODIES)
    if solver.most_factors == 0 or bodies_of(network, k) > most:
        return False
    if bodies_of(network, k) <= EXACT_BODIES:
        return True
    is_pressing = not network.islands.residual[k] <= tol and are_very_unlike(network, k)
    return bool(is_pressing or solver.patience.left[INTERIOR] == 0)


def go_inside(network: Network, solver: Solver, k: int, tol: float) -> None:
    """Interior points for island k; few bodies by all contacts first: measured, 27 boxes that fall take 1.7 s so, and
    4.8 s the other way round."""
    islands, patience, before = network.islands, solver.patience, float(network.islands.residual[k])
    goal = min(tol, SOLVED_TO_ROUNDING) if tol <= FINE and are_very_unlike(network, k) else tol
    bodies = bodies_of(network, k)
    if bodies <= EXACT_BODIES:
        islands.factors[k] += solve_whole(network, k, goal, STARTS_OF_FEW)
    may_wait = bodies > EXACT_BODIES and not are_very_unlike(network, k)
    is_wide = not may_wait or patience.left[OTHER_STARTS] == 0
    if not islands.residual[k] <= goal:
        starts = PRESSED_STARTS[network.b.shape[1]]
        islands.factors[k] += solve_pressed(network, k, goal, starts if is_wide else starts[:1])
    if not islands.residual[k] <= goal and is_wide and EXACT_BODIES < bodies <= FEW_BODIES:
        islands.factors[k] += solve_whole(network, k, goal, STARTS)
    islands.rung[k] = BY_INTERIOR
    is_met = bool(islands.residual[k] <= goal)
    interpreted(note_outcome)(patience, INTERIOR, is_met or islands.residual[k] <= WORTH_IT * before, 0, 1)
    if is_wide and may_wait:
        interpreted(note_outcome)(patience, OTHER_STARTS, is_met, 0, 1)


def solve_dense(network: Network, k: int, tol: float) -> None:
    """`solve_contact` of island k: of what is not open first, since |c| of open contacts hides the errors of others."""
    judge(network, k, tol)  # gamma says which are open
    contacts = contacts_of(network, k)
    for left, guess in tries(network, contacts):
        error, before = float(network.islands.residual[k]), network.P[contacts].copy()
        network.P[left] = dense_impulses(network, left, guess)
        judge(network, k, tol)
        if not network.islands.residual[k] < error:
            network.P[contacts] = before
            judge(network, k, tol)
        if network.islands.residual[k] <= tol:
            return


def tries(network: Network, contacts: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Contacts that are solved together, and where their solution starts."""
    P = network.P[contacts]
    is_open = (P[:, 0] == 0.0) & (network.gamma[contacts, 0] > 0.0) & (network.mu[contacts] != JOINED)
    left = contacts[~is_open]
    yield left, P[~is_open]
    yield left, np.zeros_like(P[~is_open])
    yield contacts, P


def judge(network: Network, k: int, tol: float) -> None:
    """The residual of the impulses of island k, and whether it is within the tolerance."""
    judge_network(network.address, network.b.shape[1])
    network.islands.is_met[k] = network.islands.residual[k] <= tol


def most_contacts(network: Network, k: int) -> int:
    """Up to how many island k is tried: more where masses are very unlike and the bodies begin at rest, so that forces
    alone give them velocities that are alike: what moves would be tried in every step."""
    islands, d = network.islands, network.b.shape[1]
    bodies = islands.bodies[islands.body_start[k] : islands.body_start[k + 1]]
    v = network.v_free[bodies, :d]
    is_resting = np.abs(v - v[0]).max() <= ALIKE * np.abs(v[0]).max()
    return DENSE_RESTING_CONTACTS if is_resting and are_very_unlike(network, k) else DENSE_CONTACTS


def dense_impulses(network: Network, contacts: np.ndarray, guess: np.ndarray) -> np.ndarray:
    """Impulses (m, d) of some contacts, of which joints are eliminated."""
    (G, c), mu, P, d = dense_problem(network, contacts), network.mu[contacts], guess.copy(), guess.shape[1]
    is_joint = mu == JOINED
    if not is_joint.any():
        return solve_contact(G, c, mu, d, tol=DENSE_TOL, guess=guess.ravel()).P.reshape(-1, d)
    left, free = without_joints(G, c, np.repeat(is_joint, d)), ~is_joint
    if free.any():
        P[free] = solve_contact(left.G, left.c, mu[free], d, tol=DENSE_TOL, guess=P[free].ravel()).P.reshape(-1, d)
    P[is_joint] = left.joints(P[free].ravel()).reshape(-1, d)
    return P


def dense_problem(network: Network, contacts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """G (m d, m d) and c (m d,) of some contacts."""
    bodies = np.unique(np.concatenate((network.i[contacts], network.j[contacts])))
    n = network.v.shape[1]
    J = np.zeros((len(contacts), network.b.shape[1], len(bodies), n))
    rows = np.arange(len(contacts))
    J[rows, :, np.searchsorted(bodies, network.i[contacts])] += network.J_i[contacts]
    J[rows, :, np.searchsorted(bodies, network.j[contacts])] += network.J_j[contacts]
    flat = J.reshape(-1, len(bodies) * n)
    image = np.einsum("cabx,bxy->caby", J, network.M_inv[bodies]).reshape(flat.shape)
    G = image @ flat.T
    G[np.diag_indices(len(G))] += softness(network, contacts).ravel()
    return G, flat @ network.v_free[bodies].ravel() + network.b[contacts].ravel()
