"""Impacts of a scene by another law than Newton's: Poisson's, the energetic one, one blow after the other.

A step lands first: its contacts take impulses P_l without restitution, and the bodies move on (impact.py). In place of
Newton's rebound the impact is solved there from the velocities before it, by the solver of a system's step, of all
contacts of an island that are closed:

    gamma_- = J v - G P_l,    P = P(gamma_-; law),    v_+ = v + M^-1 J^T (P - P_l)

with v the velocities after the landing. A contact that lands approaches by gamma_minus of impact.py; of one that did
not, an approach is what forces gave within the step, and none. Joints are eliminated, as they hold in an impact too.

The laws are those of contact/planar/impacts.py, friction in one direction. In space they are had without friction.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.contact.network.eliminated import without_joints
from nonsmooth.contact.network.joint import JOINED
from nonsmooth.contact.network.rescue import dense_problem
from nonsmooth.errors import Status
from nonsmooth.integrators.assembly.accelerations import SceneInStep
from nonsmooth.integrators.assembly.friction import law_of
from nonsmooth.integrators.moreau_jean.rows import StepRows
from nonsmooth.jit import interpreted
from nonsmooth.mechanics.laws import LAW_C, LAW_E_N, LAW_IMPACT, LAW_WIDTH
from nonsmooth.mechanics.system import UNILATERAL

MOST_STRUCK = 40  # chosen: closed contacts of an island: the dense core takes some 10 ms for them
law_of_contact = interpreted(law_of)


def strike_by_law(assembly: SceneInStep) -> bool:
    """Give the islands in which a contact rebounds the impulses of their law, beyond those of the landing; False where
    one of them has too many contacts."""
    network, n_c = assembly.network, int(assembly.network.n_c)
    network.P[:n_c] = 0.0
    network.v[:] = network.v_free
    islands = network.islands
    for k in range(int(islands.count)):
        listed = islands.contacts[islands.contact_start[k] : islands.contact_start[k + 1]]
        if not (assembly.contacts.impact[listed] == 1).any():
            continue
        closed = listed[is_closed(assembly, listed)]
        if (network.mu[closed] != JOINED).sum() > MOST_STRUCK:
            assembly.progress.wanted = int(closed[0])
            return False
        strike_island(assembly, closed)
    return True


def is_closed(assembly: SceneInStep, listed: np.ndarray) -> np.ndarray:
    """Which contacts landed, or were closed; joints are, and springs have no impulse."""
    network = assembly.network
    touches = (assembly.contacts.P[listed, 0] > 0.0) | (assembly.found.gap[listed] <= 0.0)
    return (network.mu[listed] == JOINED) | (touches & (network.sprung[listed] == 0))


def strike_island(assembly: SceneInStep, closed: np.ndarray) -> None:
    """The impulses of an impact of these contacts, to network.P, and the velocities after it."""
    network, d = assembly.network, assembly.dim
    landing = assembly.contacts.P[closed]
    G, c = dense_problem(network, closed)
    is_joint = network.mu[closed] == JOINED
    left = without_joints(G, c - G @ landing.ravel(), np.repeat(is_joint, d))
    P = np.zeros((len(closed), d))
    P[~is_joint] = impulses_by_law(assembly, closed[~is_joint], left.G, left.c)
    P[is_joint] = left.joints(P[~is_joint].ravel()).reshape(-1, d)
    network.P[closed] = P - landing
    for side, J in ((network.i, network.J_i), (network.j, network.J_j)):
        change = np.einsum("cxy,cay,ca->cx", network.M_inv[side[closed]], J[closed], network.P[closed])
        np.add.at(network.v, side[closed], change)


def impulses_by_law(assembly: SceneInStep, closed: np.ndarray, G: np.ndarray, gamma: np.ndarray) -> np.ndarray:
    """Impulses (m, d) of contacts whose velocities (m d,) before the impact are given, with what forces gave them."""
    network, contacts, m, d = assembly.network, assembly.contacts, len(closed), assembly.dim
    has_friction = network.mu[closed] > 0.0
    gamma, before = gamma.reshape(m, d), gamma.reshape(m, d).copy()
    before[:, 0] = np.where(contacts.impact[closed] == 1, contacts.gamma_minus[closed], np.maximum(gamma[:, 0], 0.0))
    free = gamma.copy()
    free[:, 0] += contacts.e[closed] * before[:, 0]
    used = np.zeros((m, d), bool)
    used[:, 0], used[:, 1] = True, has_friction
    rows = np.flatnonzero(used)
    answer = StepRows(
        G[np.ix_(rows, rows)], free.ravel()[rows], before.ravel()[rows], np.append(0, np.cumsum(used.sum(axis=1))),
        np.stack((np.full(m, UNILATERAL), has_friction.astype(int)), axis=1), laws_of(assembly, closed), np.zeros(m),
        np.zeros((m, 2)), np.zeros(m, int), np.zeros(m, int), float(assembly.progress.dt), int(assembly.selection),
    ).solve()  # fmt: skip
    P = np.zeros((m, d))
    P[used] = answer.P
    if answer.status != Status.FINISHED or not answer.residual <= network.tol:
        note_missed(assembly, int(closed[0]), answer.residual)
    return P if answer.status == Status.FINISHED else assembly.contacts.P[closed]


def laws_of(assembly: SceneInStep, closed: np.ndarray) -> np.ndarray:
    """Restitution, law of impact and friction of contacts, as the kernels of a system read them."""
    surfaces, laws = assembly.surfaces, np.zeros((len(closed), LAW_WIDTH))
    for row, c in zip(laws, closed, strict=True):
        if surfaces.has_laws:
            row[:] = surfaces.laws[law_of_contact(assembly.shapes, surfaces, assembly.found, c)]
        else:
            row[LAW_C] = assembly.network.mu[c]
    laws[:, LAW_E_N], laws[:, LAW_IMPACT] = assembly.contacts.e[closed], surfaces.impact
    return laws


def note_missed(assembly: SceneInStep, c: int, residual: float) -> None:
    """Count an impact whose law has no end, or was not solved to the tolerance: its island does not rebound."""
    progress, network = assembly.progress, assembly.network
    figures, worst = progress.figures, progress.worst
    progress.is_missed = 1
    residual = min(residual, 1.0)
    figures.last_residual = max(figures.last_residual, residual)
    figures.since_residual = max(figures.since_residual, residual)
    if residual > figures.residual:
        figures.residual = residual
        worst.row, worst.i, worst.j = c, network.i[c], network.j[c]
        worst.step = progress.counts.steps - (progress.left == 0.0)
