"""Random complementarity and friction problems of rigid and elastic bodies, each of which has a solution.

    G = H M^-1 H^T,    c = H v,    gamma = G P + c

with v the velocities of the bodies after a step without contacts and all surfaces at rest. At rest v = 0 is admissible
for every sliding speed, and Brouwer's theorem then gives a solution whatever the friction and the rank of G (Acary,
Cadoux, Lemarechal, Malick, Z. Angew. Math. Mech. 91 (2011) 155; in space up to the closure of a cone).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.results.fclib import GlobalContactProblem

GRAVITY = 9.81  # m/s^2
DT = 1e-3  # s


class Case(NamedTuple):
    """The arguments of `solve_contact`."""

    G: Any
    c: np.ndarray
    mu: np.ndarray
    dim: int


class RigidCase(Case):
    """The same, and the masses, directions and momenta that it was made from."""

    given: Any  # a `GlobalContactProblem`


class Contacts(NamedTuple):
    """Touching points: which bodies (first pushed along the normal; -1 is the ground), where, and the normals."""

    bodies: np.ndarray  # (n_c, 2)
    points: np.ndarray  # (n_c, dim)
    normals: np.ndarray  # (n_c, dim)


def frames(normals: np.ndarray) -> np.ndarray:
    """Orthonormal frames (N, T1[, T2]), shape (n_c, dim, dim), one row a direction."""
    if normals.shape[1] == 2:
        return np.stack([normals, np.column_stack([-normals[:, 1], normals[:, 0]])], axis=1)
    helper = np.eye(3)[np.abs(normals).argmin(axis=1)]
    first = np.cross(normals, helper)
    first /= np.linalg.norm(first, axis=1)[:, None]
    return np.stack([normals, first, np.cross(normals, first)], axis=1)


def directions(contacts: Contacts, centres: np.ndarray) -> Any:
    """H of rigid bodies with three coordinates in the plane and six in space, in compressed rows."""
    from scipy.sparse import csr_array

    dim = contacts.points.shape[1]
    dof = 3 * (dim - 1)
    frame = frames(contacts.normals)
    rows, columns, values = [], [], []
    for side, sign in ((0, 1.0), (1, -1.0)):
        moving = np.flatnonzero(contacts.bodies[:, side] >= 0)
        body = contacts.bodies[moving, side]
        arm = (contacts.points[moving] - centres[body])[:, None, :]
        d = frame[moving]
        turn = (arm[..., 0] * d[..., 1] - arm[..., 1] * d[..., 0])[..., None] if dim == 2 else np.cross(arm, d)
        block = sign * np.concatenate([d, turn], axis=2)  # (n, dim, dof)
        rows.append(np.repeat((moving[:, None] * dim + np.arange(dim)).ravel(), dof))
        columns.append(np.tile((body[:, None] * dof + np.arange(dof))[:, None, :], (1, dim, 1)).ravel())
        values.append(block.ravel())
    shape = (len(contacts.bodies) * dim, len(centres) * dof)
    return csr_array((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=shape)


def rigid(contacts: Contacts, centres: np.ndarray, mass: np.ndarray, spin: np.ndarray, mu: Any, v: np.ndarray) -> Case:
    """The problem of rigid bodies with inertia mass * spin^2; v (n_bodies, dof)."""
    from scipy.sparse import diags_array

    dim = centres.shape[1]
    turns = 1 if dim == 2 else 3
    H = directions(contacts, centres)
    inertia = np.hstack([np.tile(mass[:, None], dim), np.tile((mass * spin**2)[:, None], turns)])
    G = (H @ diags_array(1.0 / inertia.ravel()) @ H.T).tocsr()
    coefficients = np.broadcast_to(mu, len(contacts.bodies)).astype(float)
    case = RigidCase(G, H @ v.ravel(), coefficients, dim)
    M, f = diags_array(inertia.ravel()), (inertia * v).ravel()
    case.given = GlobalContactProblem(M, H.T, f, np.zeros(H.shape[0]), coefficients, dim)
    return case


def falling(rng: np.random.Generator, n: int, dim: int, noise: float = 0.1) -> np.ndarray:
    """Velocities of n bodies after a step of gravity, disturbed by a part of it."""
    v = noise * GRAVITY * DT * rng.normal(size=(n, 3 * (dim - 1)))
    v[:, dim - 1] -= GRAVITY * DT
    return v


# ---------------------------------------------------------------------------------------------------------------
# Linear complementarity: rng, number of unknowns or contacts -> A, b


def frictionless_lcp(rng: np.random.Generator, n: int) -> tuple[np.ndarray, np.ndarray]:
    """n contacts without friction on a system of n + 3 coordinates: A symmetric positive definite."""
    G, c = _random_contacts(rng, n)
    return 0.5 * (G + G.T), c


def frictional_lcp(rng: np.random.Generator, n_c: int) -> tuple[np.ndarray, np.ndarray]:
    """n_c planar contacts with friction, 0 <= mu <= 1: unknowns P_N, P_F + mu P_N, and the positive part of the slip.

    Source: Glocker, Pfeiffer, Nonlinear Dyn. 7 (1995) 471-497.
    """
    G, c = _random_contacts(rng, 2 * n_c)
    mu, eye, zero = np.diag(rng.uniform(0, 1, n_c)), np.eye(n_c), np.zeros((n_c, n_c))
    N, F = slice(0, None, 2), slice(1, None, 2)
    A = np.block(
        [[G[N, N] - G[N, F] @ mu, G[N, F], zero], [G[F, N] - G[F, F] @ mu, G[F, F], eye], [2 * mu, -eye, zero]]
    )
    return A, np.concatenate([c[N], c[F], np.zeros(n_c)])


def _random_contacts(rng: np.random.Generator, n: int) -> tuple[np.ndarray, np.ndarray]:
    """G = W M^-1 W^T and c = W u with n random rows W and a full random mass matrix."""
    n_u = n + 3
    W, B = rng.standard_normal((n, n_u)), rng.standard_normal((n_u, n_u))
    return W @ np.linalg.solve(B @ B.T + 0.1 * n_u * np.eye(n_u), W.T), W @ rng.standard_normal(n_u)


# ---------------------------------------------------------------------------------------------------------------
# Friction: rng, size (roughly the number of contacts), dim -> Case


def assembly(rng: np.random.Generator, size: int, dim: int, decades: float = 2.0, mu: float = 0.9) -> Case:
    """Bodies that touch each other and the ground at random points with random normals; masses over some decades."""
    n = max(1, size // 2)
    pairs = np.array([rng.choice(n + 1, 2, replace=False) for _ in range(size)])
    pairs[pairs == n] = -1
    points, normals = rng.normal(size=(2, size, dim))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    centres = 0.3 * rng.normal(size=(n, dim))
    mass = 10.0 ** rng.uniform(-decades / 2, decades / 2, n)
    v = rng.normal(size=(n, 3 * (dim - 1)))
    return rigid(Contacts(pairs, points, normals), centres, mass, np.ones(n), rng.uniform(0.1, mu, size), v)


def uneven(rng: np.random.Generator, size: int, dim: int) -> Case:
    """`assembly` with masses over six decades and friction coefficients up to two."""
    return assembly(rng, size, dim, decades=6.0, mu=2.0)


def one_body(rng: np.random.Generator, size: int, dim: int) -> Case:
    """One body on many points of an uneven ground: rank 3 or 6 however many contacts."""
    points = rng.uniform(-1, 1, (size, dim))
    points[:, -1] = 0.05 * rng.normal(size=size) - 0.5
    normals = 0.2 * rng.normal(size=(size, dim))
    normals[:, -1] = 1.0
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    bodies = np.column_stack([np.zeros(size, int), np.full(size, -1)])
    v = rng.normal(size=(1, 3 * (dim - 1)))
    v[0, dim - 1] -= 1.0
    return rigid(Contacts(bodies, points, normals), np.zeros((1, dim)), np.ones(1), 0.6 * np.ones(1),
                 rng.uniform(0.2, 1.0, size), v)  # fmt: skip


def packing(rng: np.random.Generator, size: int, dim: int, noise: float = 0.1, disorder: float = 0.03) -> Case:
    """Discs or spheres in a disturbed close packing between a floor and two walls, all near neighbours touching."""
    side = max(2, round((size / 3) ** 0.5 if dim == 2 else (size / 5) ** (1 / 3)))
    grid = np.stack(np.meshgrid(*[np.arange(side)] * dim, indexing="ij"), axis=-1).reshape(-1, dim).astype(float)
    layer = grid[:, -1:] % 2
    grid[:, :-1] += 0.5 * layer
    grid[:, -1] *= 3**0.5 / 2 if dim == 2 else 0.5**0.5
    centres = grid + disorder * rng.normal(size=grid.shape)
    sides = [(dim - 1, 1.0), (0, 1.0), (0, -1.0)]
    near = [(axis, sign, (sign * centres[:, axis]).min() + 0.2) for axis, sign in sides]
    n = len(centres)
    return rigid(in_a_box(centres, 1.06, near), centres, rng.uniform(0.5, 2, n), np.full(n, 0.35),
                 rng.uniform(0.2, 0.6), falling(rng, n, dim, noise))  # fmt: skip


def in_a_box(centres: np.ndarray, reach: float, walls: list[tuple[int, float, float]]) -> Contacts:
    """Spheres of diameter 1 that touch one another, centres within reach, and walls (axis, sign, end), sign x < end."""
    from scipy.spatial import cKDTree

    pairs = cKDTree(centres).query_pairs(reach, output_type="ndarray")
    gaps = centres[pairs[:, 0]] - centres[pairs[:, 1]]
    parts = [(pairs, 0.5 * (centres[pairs[:, 0]] + centres[pairs[:, 1]]), gaps)]
    for axis, sign, end in walls:
        near = np.flatnonzero(sign * centres[:, axis] < end)
        normal = np.zeros((len(near), centres.shape[1]))
        normal[:, axis] = sign
        parts.append((np.column_stack([near, np.full(len(near), -1)]), centres[near] - 0.5 * normal, normal))
    bodies, points, normals = (np.concatenate(part) for part in zip(*parts, strict=True))
    return Contacts(bodies, points, normals / np.linalg.norm(normals, axis=1)[:, None])


def heap(rng: np.random.Generator, size: int, noise: float = 0.1) -> Case:
    """Spheres of one size that were let fall into a box as soft ones without friction, until they hardly moved."""
    from scipy.spatial import cKDTree

    n = max(2, round(size / 2.5))
    width = (n / 3) ** (1 / 3)
    walls = [(2, 1.0, 0.5), *((axis, sign, end) for axis in (0, 1) for sign, end in ((1.0, 0.5), (-1.0, 0.5 - width)))]
    x, v = width * rng.uniform(0, 1, (n, 3)) * [1, 1, 3], np.zeros((n, 3))
    for _ in range(4000):
        pairs = cKDTree(x).query_pairs(1.0, output_type="ndarray")
        gaps = x[pairs[:, 0]] - x[pairs[:, 1]]
        push = (1.0 / np.maximum(np.linalg.norm(gaps, axis=1), 1e-12) - 1.0)[:, None] * gaps
        force = np.zeros((n, 3))
        np.add.at(force, pairs[:, 0], push)
        np.add.at(force, pairs[:, 1], -push)
        force[:, 2] -= 2e-4
        for axis, sign, end in walls:
            force[:, axis] += sign * np.maximum(0.0, end - sign * x[:, axis])
        v = 0.9 * v + 0.3 * force
        x += 0.6 * v
    return rigid(in_a_box(x, 1.0, walls), x, np.ones(n), np.full(n, 0.1**0.5), 0.5, falling(rng, n, 3, noise))


def wall(rng: np.random.Generator, size: int, dim: int, noise: float = 0.3) -> Case:
    """Bricks in running bond, touching their neighbours above and below at the ends of the common faces."""
    depth = [0.0] if dim == 2 else [-0.25, 0.25]
    axes = [0, 2] if dim == 2 else [0, 1, 2]
    levels, height = max(2, round((size / (4 * len(depth))) ** 0.5)), 0.4
    number = np.arange(levels * levels).reshape(levels, levels)
    x = np.arange(levels) + 0.5 * (np.arange(levels)[:, None] % 2)
    bodies, points = [], []
    for level, k in np.ndindex(levels, levels):
        below = zip(number[level - 1], x[level - 1], strict=True) if level else [(-1, x[0, k])]
        for other, centre in below:
            left, right = max(x[level, k], centre) - 0.5, min(x[level, k], centre) + 0.5
            if left < right:
                bodies += [(number[level, k], other)] * 2 * len(depth)
                points += [(end, y, level * height) for end in (left, right) for y in depth]
    centres = np.column_stack([x.ravel(), np.zeros(x.size), np.repeat(np.arange(levels) + 0.5, levels) * height])
    normals = np.tile(np.eye(dim)[-1], (len(points), 1))
    contacts = Contacts(np.array(bodies), np.array(points)[:, axes], normals)
    n = len(centres)
    return rigid(contacts, centres[:, axes], rng.uniform(0.5, 2, n), np.full(n, 0.3), rng.uniform(0.3, 0.8),
                 falling(rng, n, dim, noise))  # fmt: skip


def tower(rng: np.random.Generator, size: int, dim: int) -> Case:
    """Blocks one on the other, heavier ones anywhere: masses over six decades."""
    corners = np.array([[-0.5], [0.5]]) if dim == 2 else 0.5 * np.array([[a, b] for a in (-1, 1) for b in (-1, 1)])
    n = max(1, size // len(corners))
    height = 0.5
    shift = np.cumsum(0.05 * rng.normal(size=(n, dim - 1)), axis=0)
    points = np.concatenate(
        [np.column_stack([corners + shift[k], np.full(len(corners), k * height)]) for k in range(n)]
    )
    bodies = np.repeat(np.column_stack([np.arange(n), np.arange(n) - 1]), len(corners), axis=0)
    normals = np.zeros((len(points), dim))
    normals[:, -1] = 1.0
    centres = np.column_stack([shift, (np.arange(n) + 0.5) * height])
    return rigid(Contacts(bodies, points, normals), centres, 10.0 ** rng.uniform(-3, 3, n), np.full(n, 0.4),
                 rng.uniform(0.3, 0.8), falling(rng, n, dim))  # fmt: skip


def arch(rng: np.random.Generator, size: int, dim: int) -> Case:
    """Voussoirs between two abutments: thrust lines inside the joints, every joint hyperstatic."""
    depth = [0.0] if dim == 2 else [-0.3, 0.3]
    axes = [0, 2] if dim == 2 else [0, 1, 2]
    corners = [(radius, y) for radius in (0.8, 1.2) for y in depth]
    n = max(3, size // len(corners) - 1)
    angle = np.pi * np.arange(n + 1) / n
    joints = np.column_stack([np.arange(n + 1), np.arange(n + 1) - 1])  # joint k presses stone k off stone k - 1
    joints[-1] = n - 1, -1
    normal = np.column_stack([np.sin(angle), np.zeros(n + 1), np.cos(angle)])
    normal[-1] *= -1.0
    points = np.array([(-r * np.cos(a), y, r * np.sin(a)) for a in angle for r, y in corners])
    contacts = Contacts(np.repeat(joints, len(corners), axis=0), points[:, axes],
                        np.repeat(normal[:, axes], len(corners), axis=0))  # fmt: skip
    middle = 0.5 * (angle[1:] + angle[:-1])
    centres = np.column_stack([-np.cos(middle), np.zeros(n), np.sin(middle)])[:, axes]
    return rigid(contacts, centres, rng.uniform(0.5, 2, n), np.full(n, 0.2), rng.uniform(0.3, 0.9),
                 falling(rng, n, dim, noise=0.3))  # fmt: skip


def elastic(rng: np.random.Generator, size: int, dim: int) -> Case:
    """The nodes of an elastic strip on a floor, one implicit step: G full and regular, with a wide spectrum."""
    layers = 4
    n = layers * size
    node = np.arange(n).reshape(layers, size)
    upright, level = (node[:-1].ravel(), node[1:].ravel()), (node[:, :-1].ravel(), node[:, 1:].ravel())
    K = np.zeros((n, dim, n, dim))
    for a, b in np.hstack([upright, level]).T:
        stiffness = 10.0 ** rng.uniform(4, 6) * np.diag(0.3 + rng.uniform(0, 1, dim))  # N/m
        K[a, :, a] += stiffness
        K[b, :, b] += stiffness
        K[a, :, b] -= stiffness
        K[b, :, a] -= stiffness
    inverse = np.linalg.inv(np.eye(n * dim) + DT**2 * K.reshape(n * dim, n * dim))  # every node has 1 kg
    rows = (node[0][:, None] * dim + np.roll(np.arange(dim), 1)).ravel()  # the normal, which is the last axis, first
    v = rng.normal(size=(n, dim))
    v[:, -1] -= 1.0
    return Case(inverse[np.ix_(rows, rows)], inverse[rows] @ v.ravel(), np.full(size, rng.uniform(0.2, 0.8)), dim)


FAMILIES: dict[str, Callable[..., Case]] = {
    family.__name__: family for family in (assembly, uneven, one_body, packing, wall, tower, arch, elastic)
}


def normals(case: Case) -> tuple[Any, np.ndarray]:
    """A, b of the same contacts without friction."""
    return case.G.tocsr()[:: case.dim, :: case.dim].tocsr(), case.c[:: case.dim]
