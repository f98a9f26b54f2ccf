"""The systems of ``python -m benchmarks stress``: constant mass, constant forces, plane contacts.

    M u' = h + W_N^T la_N + W_F^T la_F,    g_N = g_0 + W_N q,    gamma_F = W_F u

`PlaneContacts` has all of these as parameters, so that any number of such systems compiles once; towers and stacks of
boxes have their own few parameters. Small rotations: the rows are those of the upright boxes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nonsmooth.mechanics.system import Contact, System

N_Q, N_C = 4, 8  # coordinates and contacts of every `PlaneContacts`; those it does not need stay free and open
OPEN = 1e6  # gap of a contact that is not needed [m]
SHAPES = {"M": (N_Q, N_Q), "h": (N_Q,), "g_0": (N_C,), "W_N": (N_C, N_Q), "W_F": (N_C, N_Q), "mu": (N_C,), "e": (N_C,)}
STARTS = dict(zip(SHAPES, np.cumsum([0, *(int(np.prod(s)) for s in SHAPES.values())]).tolist(), strict=False))
H, G_0, NORMALS, TANGENTS = (STARTS[name] for name in ("h", "g_0", "W_N", "W_F"))
FIELDS = [f"{name}_{k}" for name, shape in SHAPES.items() for k in range(int(np.prod(shape)))]
Numbers = NamedTuple("Numbers", [(name, float) for name in FIELDS])  # type: ignore[misc]


def plane_mass(t, q, p, M):
    for i in range(N_Q):
        for j in range(N_Q):
            M[i, j] = p[i * N_Q + j]


def plane_force(t, q, u, p, h):
    for i in range(N_Q):
        h[i] = p[H + i]


def plane_gap(t, q, p, g_N):
    for i in range(N_C):
        g_N[i] = p[G_0 + i]
        for j in range(N_Q):
            g_N[i] += p[NORMALS + i * N_Q + j] * q[j]


def plane_normal(t, q, p, W_N):
    for i in range(N_C):
        for j in range(N_Q):
            W_N[i, j] = p[NORMALS + i * N_Q + j]


def plane_tangent(t, q, p, W_F):
    for i in range(N_C):
        for j in range(N_Q):
            W_F[i, 0, j] = p[TANGENTS + i * N_Q + j]


def plane_contacts(M, h, W_N, W_F, g_0=0.0, mu=0.0, e=0.0, name="plane contacts") -> System:
    """A system with n <= 4 coordinates and c <= 8 plane contacts: M (n, n), h (n,), W_N and W_F (c, n), others (c,)."""
    n, c = len(h), len(W_N)
    arrays = {key: np.zeros(shape) for key, shape in SHAPES.items()}
    arrays["M"] = np.eye(N_Q) * np.abs(M).max()
    arrays["M"][:n, :n] = M
    arrays["h"][:n] = h
    arrays["g_0"][:] = OPEN
    arrays["g_0"][:c] = g_0
    arrays["W_N"][:, N_Q - 1] = 1.0
    arrays["W_N"][:c] = 0.0
    arrays["W_N"][:c, :n], arrays["W_F"][:c, :n] = W_N, W_F
    arrays["mu"][:c], arrays["e"][:c] = mu, e
    numbers = Numbers(*np.concatenate([array.ravel() for array in arrays.values()]).tolist())
    contacts = [Contact(mu=f"mu_{i}", e_N=f"e_{i}") for i in range(N_C)]
    return System(n_q=N_Q, mass=plane_mass, force=plane_force, gap=plane_gap, normal=plane_normal,
                  tangent=plane_tangent, contacts=contacts, parameters=numbers, name=name)  # fmt: skip


def box_on(points, mu=0.3, e=0.0, m=1.0, height=0.1, g=9.81, name="box") -> System:
    """A box q = (x, y, th) that stands on the points (c,) [m] of its bottom, its centre ``height`` above them."""
    points = np.asarray(points, dtype=float)
    one, zero = np.ones_like(points), np.zeros_like(points)
    M = np.diag([m, m, m * (np.ptp(points) ** 2 + 4 * height**2) / 12])
    W_N, W_F = np.column_stack([zero, one, points]), np.column_stack([one, zero, height * one])
    return plane_contacts(M, [0.0, -m * g, 0.0], W_N, W_F, mu=mu, e=e, name=name)


def groove(angle, mu=0.0, m=1.0, g=9.81) -> System:
    """A particle q = (x, y) between two planes that are inclined by +-angle [rad]: normals (-+sin, cos)."""
    s, c = np.sin(angle), np.cos(angle)
    return plane_contacts(np.eye(2) * m, [0.0, -m * g], [[-s, c], [s, c]], [[c, s], [c, -s]], mu=mu, name="groove")


def box_in_corner(mu, push=0.0, m=1.0, a=0.1, g=9.81) -> System:
    """A square box of side 2 a pushed into a corner: floor under both bottom corners, wall at both left ones."""
    M = np.diag([m, m, m * 2 * a * a / 3])
    W_N = [[0, 1, -a], [0, 1, a], [1, 0, a], [1, 0, -a]]  # floor left, floor right, wall bottom, wall top
    W_F = [[1, 0, a], [1, 0, a], [0, 1, -a], [0, 1, -a]]
    return plane_contacts(M, [-push, -m * g, 0.0], W_N, W_F, mu=mu, name="box in a corner")


class Tower(NamedTuple):
    m: float = 1.0  # mass of the lowest block [kg]
    ratio: float = 1.0  # mass of a block over that of the block below
    g: float = 9.81  # gravity [m/s^2]
    mu: float = 0.3  # friction coefficient
    e: float = 0.0  # restitution
    half: float = 0.1  # half width of a box [m]
    height: float = 0.1  # half height of a box [m]


def tower_mass(t, q, p, M):
    m = p.m
    for i in range(M.shape[0] // 2):
        M[2 * i, 2 * i] = m
        M[2 * i + 1, 2 * i + 1] = m
        m *= p.ratio


def tower_force(t, q, u, p, h):
    m = p.m
    for i in range(h.shape[0] // 2):
        h[2 * i + 1] = -m * p.g
        m *= p.ratio


def tower_gap(t, q, p, g_N):
    g_N[0] = q[1]
    for i in range(1, g_N.shape[0]):
        g_N[i] = q[2 * i + 1] - q[2 * i - 1]


def tower_normal(t, q, p, W_N):
    W_N[0, 1] = 1.0
    for i in range(1, W_N.shape[0]):
        W_N[i, 2 * i + 1] = 1.0
        W_N[i, 2 * i - 1] = -1.0


def tower_tangent(t, q, p, W_F):
    W_F[0, 0, 0] = 1.0
    for i in range(1, W_F.shape[0]):
        W_F[i, 0, 2 * i] = 1.0
        W_F[i, 0, 2 * i - 2] = -1.0


def tower(n: int, parameters: Tower) -> System:
    """n blocks upon each other that do not turn: q = (x_1, y_1, ...), displacements; one contact below each."""
    return System(n_q=2 * n, mass=tower_mass, force=tower_force, gap=tower_gap, normal=tower_normal,
                  tangent=tower_tangent, contacts=[Contact(mu="mu", e_N="e")] * n, parameters=parameters,
                  name=f"tower of {n}")  # fmt: skip


def stack_mass(t, q, p, M):
    m = p.m
    for i in range(M.shape[0] // 3):
        M[3 * i, 3 * i] = m
        M[3 * i + 1, 3 * i + 1] = m
        M[3 * i + 2, 3 * i + 2] = m * (p.half * p.half + p.height * p.height) / 3.0
        m *= p.ratio


def stack_force(t, q, u, p, h):
    m = p.m
    for i in range(h.shape[0] // 3):
        h[3 * i + 1] = -m * p.g
        m *= p.ratio


def stack_gap(t, q, p, g_N):
    for k in range(g_N.shape[0]):
        i, a = k // 2, p.half * (2 * (k % 2) - 1)
        g_N[k] = q[3 * i + 1] + a * q[3 * i + 2]
        if i > 0:
            g_N[k] -= q[3 * i - 2] + a * q[3 * i - 1]


def stack_normal(t, q, p, W_N):
    for k in range(W_N.shape[0]):
        i, a = k // 2, p.half * (2 * (k % 2) - 1)
        W_N[k, 3 * i + 1] = 1.0
        W_N[k, 3 * i + 2] = a
        if i > 0:
            W_N[k, 3 * i - 2] = -1.0
            W_N[k, 3 * i - 1] = -a


def stack_tangent(t, q, p, W_F):
    for k in range(W_F.shape[0]):
        i = k // 2
        W_F[k, 0, 3 * i] = 1.0
        W_F[k, 0, 3 * i + 2] = p.height
        if i > 0:
            W_F[k, 0, 3 * i - 3] = -1.0
            W_F[k, 0, 3 * i - 1] = p.height


def stack(n: int, parameters: Tower) -> System:
    """n boxes upon each other, each on the two corners of its bottom: q = (x_1, y_1, th_1, ...), displacements."""
    return System(n_q=3 * n, mass=stack_mass, force=stack_force, gap=stack_gap, normal=stack_normal,
                  tangent=stack_tangent, contacts=[Contact(mu="mu", e_N="e")] * (2 * n), parameters=parameters,
                  name=f"stack of {n}")  # fmt: skip
