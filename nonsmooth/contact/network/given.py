"""Contact problems given by masses and directions, as the network of bodies that they come from.

    M v = H P + f,    gamma = H^T v + w

is a network where M is block diagonal with a block of 3 x 3 (plane) or 6 x 6 (space) a body, and each contact touches
one body or two. Then G = H^T M^-1 H is never made: a sweep costs a few products a contact however many contacts a body
has, and factors have the graph of the bodies.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from nonsmooth.contact.network.problem import Network, prepare_network
from nonsmooth.jit.blocks import new
from nonsmooth.numerics.rounding import EPS


def network_of(M: Any, H: Any, f: np.ndarray, w: np.ndarray, mu: np.ndarray) -> Network | None:
    """The prepared network of a problem; None where it is not one of rigid bodies. The last body is the surroundings.

    Parameters
    ----------
    M, H : sparse or dense matrices (n_u, n_u), (n_u, n)
    f, w, mu : (n_u,), (n,), (n_c,)
    """
    if len(mu) == 0:
        return None
    d = len(w) // len(mu)
    n = 3 * (d - 1)  # velocities of a body
    if len(f) % n:
        return None
    mass = masses_of(M, n)
    contacts = rows_of_contacts(H, d, n)
    if mass is None or contacts is None:
        return None
    bodies, J = contacts
    n_b = len(mass)
    network = new(Network, d=d, n=n, m=len(mu), n_b=n_b + 1)
    network.n_c = len(mu)
    network.M[:n_b], network.M[n_b] = mass, np.eye(n)
    network.M_inv[:n_b] = np.linalg.inv(mass)
    network.v_free[:n_b] = np.linalg.solve(mass, f.reshape(n_b, n, 1))[:, :, 0]
    network.i[:], network.j[:], network.J_i[:], network.J_j[:] = bodies[:, 0], bodies[:, 1], J[:, 0], J[:, 1]
    network.b[:], network.mu[:] = w.reshape(-1, d), mu
    prepare_network(network.address, d)
    return network


def masses_of(M: Any, n: int) -> np.ndarray | None:
    """The blocks (n_b, n, n) of a block diagonal, symmetric and positive definite matrix; None of another."""
    from scipy.sparse import coo_array

    entries = coo_array(M)
    if (entries.row // n != entries.col // n).any():
        return None
    mass = np.zeros((M.shape[0] // n, n, n))
    np.add.at(mass, (entries.row // n, entries.row % n, entries.col % n), entries.data)
    if not np.allclose(mass, mass.transpose(0, 2, 1), rtol=n * EPS, atol=0.0):
        return None
    try:
        np.linalg.cholesky(mass)
    except np.linalg.LinAlgError:
        return None
    return mass


def rows_of_contacts(H: Any, d: int, n: int) -> tuple[np.ndarray, np.ndarray] | None:
    """Bodies (n_c, 2) of the contacts and their rows (n_c, 2, d, n); None where a contact touches more than two.

    The first body of a contact that touches one is the surroundings, number n_b, whose rows are zero.
    """
    from scipy.sparse import csr_array

    rows = csr_array(H.T)
    rows.eliminate_zeros()
    blocks = rows.tobsr(blocksize=(d, n))
    count = np.diff(blocks.indptr)
    n_b, n_c = H.shape[0] // n, len(count)
    if (count > 2).any():
        return None
    bodies, J = np.full((n_c, 2), n_b), np.zeros((n_c, 2, d, n))
    for side, contacts in ((1, count > 0), (0, count > 1)):
        at = blocks.indptr[:-1][contacts] + (1 - side)
        bodies[contacts, side], J[contacts, side] = blocks.indices[at], blocks.data[at]
    if d == 3:  # sweeps of spheres want right-handed frames in J_j
        turned = (count == 2) & (np.linalg.det(J[:, 1, :, :3]) < 0.0)
        bodies[turned], J[turned] = bodies[turned, ::-1], J[turned, ::-1]
    return bodies, J
