"""The contact problem of some contacts of a network as sparse matrices, for other programs.

gamma = G P + c,     G = J M^-1 J^T + R,     c = J v_free + b

R, on the diagonal of the normal rows, is that of compliant contacts. Joints are eliminated.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from nonsmooth.contact.network.eliminated import without_joints
from nonsmooth.contact.network.joint import JOINED
from nonsmooth.contact.network.problem import Network


class Matrices(NamedTuple):
    """A problem, and impulses of it."""

    G: Any  # scipy.sparse (m d, m d) [1/kg]
    c: np.ndarray  # (m d,) [m/s]
    mu: np.ndarray  # (m,)
    P: np.ndarray  # (m d,) [N s]
    d: int


def unsolved_problem(network: Network) -> Matrices | None:
    """That of the islands which are not met, with the best impulses that were found; None where all are, or have joints
    alone."""
    islands = network.islands
    missed = np.flatnonzero(islands.is_met[: islands.count] == 0)
    if len(missed) == 0:
        return None
    ranges = [islands.contacts[islands.contact_start[k] : islands.contact_start[k + 1]] for k in missed]
    contacts = np.concatenate(ranges)
    return matrices_of(network, contacts) if (network.mu[contacts] != JOINED).any() else None


def softness(network: Network, contacts: np.ndarray) -> np.ndarray:
    """R (m, d) on the diagonal of G: of the normals of compliant contacts, and of all rows of soft joints."""
    R = np.tile(network.soft[contacts, None], (1, network.b.shape[1]))
    R[network.mu[contacts] != JOINED, 1:] = 0.0
    return R


def matrices_of(network: Network, contacts: np.ndarray) -> Matrices:
    """That of some contacts."""
    import scipy.sparse as sparse

    m, (n_b, n), d = len(contacts), network.v.shape, network.b.shape[1]
    first = np.arange(m + 1) * 2
    bodies = np.stack((network.i[contacts], network.j[contacts]), axis=1).ravel()
    parts = np.stack((network.J_i[contacts], network.J_j[contacts]), axis=1).reshape(-1, d, n)
    J = sparse.bsr_matrix((parts, bodies, first), shape=(m * d, n_b * n)).tocsr()
    M_inv = sparse.bsr_matrix((network.M_inv, np.arange(n_b), np.arange(n_b + 1)), shape=(n_b * n, n_b * n))
    c = J @ network.v_free.ravel() + network.b[contacts].ravel()
    R = softness(network, contacts)
    G = (J @ M_inv @ J.T + sparse.diags(R.ravel())).tocsr()
    mu, P, is_joint = network.mu[contacts], network.P[contacts], network.mu[contacts] == JOINED
    if is_joint.any():
        left = without_joints(G.toarray(), c, np.repeat(is_joint, d))
        G, c, mu, P = sparse.csr_matrix(left.G), left.c, mu[~is_joint], P[~is_joint]
    return Matrices(G, c, mu, P.ravel(), d)
