"""Networks made by hand: boxes and round bodies as rows, and the same problem with its Delassus matrix."""

from types import SimpleNamespace

import numpy as np

from nonsmooth.contact.network.problem import Network, judge_network, prepare_network
from nonsmooth.jit.blocks import new

GRAVITY, STEP, DENSITY = 9.81, 2e-3, 1000.0


def planar_rows(normal, arm):
    """Rows (N, T) of the velocity of a point at ``arm`` from the centre of its body."""
    tangent = np.array([-normal[1], normal[0]])
    return np.array([[*axis, arm[0] * axis[1] - arm[1] * axis[0]] for axis in (normal, tangent)])


def spatial_rows(normal, arm):
    """Rows (N, T1, T2) of the velocity of a point at ``arm`` from the centre of its body."""
    first = np.zeros(3)
    first[0 if abs(normal[0]) < 0.6 else 1] = 1.0
    first -= (first @ normal) * normal
    first /= np.linalg.norm(first)
    return np.array([[*axis, *np.cross(arm, axis)] for axis in (normal, first, np.cross(normal, first))])


def network_of(x, M, v_free, contacts, mu=0.5, fixed=()):
    """A prepared network of bodies at x (n_b, 2|3) with contacts (i, j, normal, point, b_N)."""
    x, d = np.asarray(x, float), np.shape(x)[1]
    n = 3 if d == 2 else 6
    network = new(Network, d=d, n=n, m=len(contacts), n_b=len(x))
    network.n_c = len(contacts)
    network.M[:], network.v_free[:], network.mu[:] = M, v_free, mu
    for body in range(len(x)):
        network.M_inv[body] = 0.0 if body in fixed else np.linalg.inv(M[body])
    rows = planar_rows if d == 2 else spatial_rows
    for c, (i, j, normal, point, b_N) in enumerate(contacts):
        normal, point = np.asarray(normal, float), np.asarray(point, float)
        network.i[c], network.j[c] = i, j
        network.J_i[c], network.J_j[c] = -rows(normal, point - x[i]), rows(normal, point - x[j])
        network.b[c, 0] = b_N
    prepare_network(network.address, d)
    return network


def judge(network):
    """The residual in all, from the impulses alone."""
    return judge_network(network.address, network.b.shape[1])


def copy_of(network):
    """A network of the same words."""
    return type(network)(network.words.copy())


def assembled(network):
    """(G, c, mu, dim) of the same problem as dense arrays."""
    n_c, d, n = network.n_c, network.b.shape[1], network.v.shape[1]
    J = np.zeros((n_c * d, len(network.v), n))
    for c in range(n_c):
        J[c * d : (c + 1) * d, network.i[c]] += network.J_i[c]
        J[c * d : (c + 1) * d, network.j[c]] += network.J_j[c]
    G = np.einsum("abx,bxy,cby->ac", J, network.M_inv, J)
    c = np.einsum("abx,bx->a", J, network.v_free) + network.b[:n_c].ravel()
    return SimpleNamespace(G=G, c=c, mu=network.mu[:n_c].copy(), dim=d, J=J)


def box_mass(half, dimensions, ratio=1.0):
    """Mass matrix of a square or a cube."""
    side = 2.0 * half
    if dimensions == 2:
        mass = ratio * DENSITY * side**2
        return np.diag([mass, mass, mass * side**2 / 6])
    mass = ratio * DENSITY * side**3
    return np.diag([mass] * 3 + [mass * side**2 / 6] * 3)


def falling(n_b, dimensions, fixed):
    """v_free after a step of gravity."""
    v = np.zeros((n_b, 3 if dimensions == 2 else 6))
    v[:, dimensions - 1] = -GRAVITY * STEP
    v[list(fixed)] = 0.0
    return v


def stack(n=10, ratio=1.0, half=0.1, mu=0.5):
    """Cubes one on the other, four points between two; the top one is heavier. Body 0 is the floor."""
    x = [(0.0, 0.0, -half)] + [(0.0, 0.0, half * (2 * k + 1)) for k in range(n)]
    M = [box_mass(half, 3)] * n + [box_mass(half, 3, ratio)]
    corners = [(-half, -half), (half, -half), (half, half), (-half, half)]
    contacts = [(k, k + 1, (0, 0, 1), (*corner, 2 * half * k), 0.0) for k in range(n) for corner in corners]
    return network_of(x, M, falling(n + 1, 3, (0,)), contacts, mu, (0,))


def pyramid(rows=10, half=0.1, pitch=0.22, mu=0.5):
    """Squares in a pyramid, two points between two; the last body is the floor."""
    x = [((2 * j + i - rows + 1) * pitch / 2, half * (2 * i + 1)) for i in range(rows) for j in range(rows - i)]
    number = {(i, j): k for k, (i, j) in enumerate((i, j) for i in range(rows) for j in range(rows - i))}
    floor = len(x)
    contacts = []
    for (i, j), k in number.items():
        if i == 0:
            contacts += [(k, floor, (0, -1), (x[k][0] + side * half, 0.0), 0.0) for side in (-1, 1)]
        else:
            for below, side in ((number[i - 1, j], -1), (number[i - 1, j + 1], 1)):
                ends = (x[k][0] + side * half, x[below][0] - side * half)
                contacts += [(k, below, (0, -1), (end, 2 * half * i), 0.0) for end in ends]
    M = [box_mass(half, 2)] * (floor + 1)
    return network_of([*x, (0.0, -1.0)], M, falling(floor + 1, 2, (floor,)), contacts, mu, (floor,))


def heap(n, dimensions, seed=0, radius=0.05, mu=0.5, speed=0.05):
    """Round bodies at random in a narrow shaft with a floor, moving at random; the last body is the shaft."""
    rng = np.random.default_rng(seed)
    wide = max(2, int(np.ceil(n ** (1 / dimensions))))
    grid = np.array([[k // wide**a % wide for a in range(dimensions - 1)] + [k // wide ** (dimensions - 1)]
                     for k in range(n)])  # fmt: skip
    x = 2 * radius * (grid + 0.5) + rng.uniform(-0.02, 0.02, (n, dimensions)) * radius
    contacts = []
    for i in range(n):
        for j in range(i + 1, n):
            away = x[j] - x[i]
            gap = np.linalg.norm(away) - 2 * radius
            if gap < 0.05 * radius:
                normal = away / np.linalg.norm(away)
                contacts.append((i, j, normal, x[i] + normal * (radius + gap / 2), max(gap, 0.0) / STEP))
        for axis in range(dimensions):
            for side in (-1, 1):
                gap = x[i, axis] - radius if side < 0 else 2 * radius * wide - radius - x[i, axis]
                if gap < 0.05 * radius and (axis < dimensions - 1 or side < 0):
                    normal = side * np.eye(dimensions)[axis]
                    contacts.append((i, n, normal, x[i] + normal * (radius + gap / 2), max(gap, 0.0) / STEP))
    mass = DENSITY * (np.pi * radius**2 if dimensions == 2 else 4 / 3 * np.pi * radius**3)
    inertia = mass * radius**2 * (0.5 if dimensions == 2 else 0.4)
    M = np.array([np.diag([mass] * dimensions + [inertia] * (1 if dimensions == 2 else 3))] * (n + 1))
    v_free = falling(n + 1, dimensions, (n,))
    v_free[:n] += rng.normal(size=v_free[:n].shape) * speed
    return network_of([*x, np.zeros(dimensions)], M, v_free, contacts, mu, (n,))


def chosen(network, contacts):
    """The network of some of its contacts."""
    return joined([network], kept=set(contacts))


def joined(networks, rng=None, kept=None):
    """Several networks as one, whose bodies do not touch; bodies and contacts in another order with ``rng``."""
    rows, first = [], 0
    d = networks[0].b.shape[1]
    for part in networks:
        for c in kept or range(part.n_c):
            rows.append((part, c, first + part.i[c], first + part.j[c]))
        first += len(part.v)
    bodies = np.arange(first) if rng is None else rng.permutation(first)  # new number of each
    if rng is not None:
        rows = [rows[c] for c in rng.permutation(len(rows))]
    joint = new(Network, d=d, n=networks[0].v.shape[1], m=len(rows), n_b=first)
    joint.n_c = len(rows)
    for name in ("M", "M_inv", "v_free"):
        getattr(joint, name)[bodies] = np.concatenate([getattr(part, name) for part in networks])
    for at, (part, c, i, j) in enumerate(rows):
        joint.i[at], joint.j[at] = bodies[i], bodies[j]
        for name in ("J_i", "J_j", "b", "mu", "P"):
            getattr(joint, name)[at] = getattr(part, name)[c]
    prepare_network(joint.address, d)
    return joint
