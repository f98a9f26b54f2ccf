"""A contact problem as the solvers see it: blocks of compressed rows, checked, and scaled to order one.

With s_i^2 the power of four nearest to the mean diagonal of G_ii, sigma the power of two nearest to max |c_i| / s_i,

    P_i = (sigma / s_i) P~_i,    gamma_i = sigma s_i gamma~_i,    G~_ij = G_ij / (s_i s_j),    c~_i = c_i / (sigma s_i).

One factor a contact keeps the friction cones; powers of two keep every digit. Solvers work on the tilded problem, where
every G~_ii has a mean diagonal in [1/2, 2) and absolute tolerances have a meaning. The error they aim at is that of the
problem as it was given, through ``weight``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from nonsmooth.checks.arrays import as_number, as_vector
from nonsmooth.contact.blocks.natural_map import natural_map_entry, velocity_entry
from nonsmooth.errors import InvalidInput, shown
from nonsmooth.jit import kernel


@dataclass(frozen=True)
class Blocks:
    """A block matrix of compressed rows: G (n_blocks, dim, dim), indices (n_blocks,), indptr (n_c + 1,).

    Every diagonal block is stored.
    """

    G: np.ndarray
    indices: np.ndarray
    indptr: np.ndarray

    @property
    def n(self) -> int:
        """Number of unknowns."""
        return (self.indptr.shape[0] - 1) * self.G.shape[1]

    @property
    def is_full(self) -> bool:
        """Whether dense linear algebra is the cheaper one."""
        density = self.G.size / max(self.n**2, 1)
        return self.n <= 60 or (self.n <= 400 and density > 0.2)


@dataclass(frozen=True)
class Problem:
    """gamma = G P + c with friction coefficients mu (n_c,), and how its error is weighed.

    Attributes
    ----------
    rho, weight : ndarray, shape (n_c,)
        The error of P is the norm of (weight_i |F_i|)_i, F the natural map with rho_i.
    """

    blocks: Blocks
    c: np.ndarray
    mu: np.ndarray
    rho: np.ndarray
    weight: np.ndarray

    @property
    def dim(self) -> int:
        """2 in the plane, 3 in space."""
        return self.blocks.G.shape[1]

    @property
    def n_c(self) -> int:
        """Number of contacts."""
        return self.mu.shape[0]

    @property
    def n(self) -> int:
        """Number of unknowns."""
        return self.c.shape[0]

    def error(self, P: np.ndarray) -> float:
        """Natural-map error relative to the norm of c as it was given; inf for an iterate that is not finite."""
        error = natural_map_entry(self.mu, self.rho, self.weight, P, self.velocity(P), self.dim)
        return error if np.isfinite(error) else np.inf

    def velocity(self, P: np.ndarray) -> np.ndarray:
        """gamma = G P + c."""
        gamma, blocks = np.empty(self.n), self.blocks
        velocity_entry(blocks.G, blocks.indices, blocks.indptr, self.c, P, gamma)
        return gamma

    def with_error_of(self, rho: np.ndarray) -> Problem:
        """The same problem with the natural map of another rho."""
        return Problem(self.blocks, self.c, self.mu, rho, self.weight)


def check_problem(G: Any, c: Any, mu: Any, dim: Any) -> Problem:
    """Check a problem at the public border and measure its error relative to the norm of c."""
    c, mu, dim = check_vectors(c, mu, dim)
    return weighed_problem(as_blocks("G", G, dim, len(mu)), c, mu)


def check_vectors(c: Any, mu: Any, dim: Any) -> tuple[np.ndarray, np.ndarray, int]:
    """c (n,), mu (n_c,) and dim of a problem, checked."""
    if isinstance(dim, bool) or not isinstance(dim, int | np.integer) or dim not in (2, 3):
        raise InvalidInput(f"dim must be 2 (planar) or 3 (spatial); got {shown(dim)}")
    dim = int(dim)
    c = as_vector("c", c)
    if c.shape[0] % dim:
        raise InvalidInput(f"c must have {dim} entries for each contact (N, T1{', T2' * (dim - 2)}); got {c.shape[0]}")
    n_c = c.shape[0] // dim
    mu = as_vector("mu", np.full(n_c, as_number("mu", mu)) if np.isscalar(mu) or mu is None else mu, n_c)
    if 1 in (mu < 0).tobytes():
        i = int(np.argmax(mu < 0))
        raise InvalidInput(f"mu must not be negative; mu[{i}] is {mu[i]:g}")
    return c, mu, dim


def weighed_problem(blocks: Blocks, c: np.ndarray, mu: np.ndarray) -> Problem:
    """A checked problem, whose error is relative to the norm of c."""
    norm = float(np.linalg.norm(c / (peak := np.abs(c).max(initial=0.0) or 1.0)) * peak)
    weight = np.full(len(mu), 1.0 / norm if norm > 0 else 1.0)
    return Problem(blocks, c, mu, contact_scale(blocks), weight)


def as_blocks(name: str, value: Any, dim: int, n_c: int) -> Blocks:
    """A dense or scipy.sparse square matrix as blocks of compressed rows, with finite entries, or `InvalidInput`."""
    n = dim * n_c
    sparse = hasattr(value, "tocsr")
    try:
        matrix: Any = value.tocsr() if sparse else np.asarray(value)
    except ValueError:
        raise InvalidInput(f"{name} must be a square matrix of numbers; its rows differ in length") from None
    except Exception:  # whatever an object raises that is asked for its array
        raise InvalidInput(f"{name} must be a square matrix of numbers; got {shown(value)}") from None
    if matrix.shape != (n, n) and not (n == 0 and matrix.size == 0):
        rule = "square" if len(matrix.shape) != 2 or matrix.shape[0] != matrix.shape[1] else f"({n}, {n}) to fit c"
        raise InvalidInput(f"{name} must be {rule}; got shape {matrix.shape}")
    try:
        data = np.array(matrix.data if sparse else matrix, dtype=np.float64, order="C")
    except (TypeError, ValueError):
        raise InvalidInput(f"{name} must hold numbers; got dtype {matrix.dtype}") from None
    if 0 in np.isfinite(data).tobytes():
        raise InvalidInput(f"{name} must be finite; {int((~np.isfinite(data)).sum())} of its entries are not")
    if not sparse and n_c == 1:
        return Blocks(data.reshape(1, dim, dim), np.zeros(1, dtype=np.int32), np.array([0, 1], dtype=np.int32))
    if not sparse:
        cut = data.reshape(n_c, dim, n_c, dim).transpose(0, 2, 1, 3).reshape(n_c * n_c, dim, dim)
        columns = np.tile(np.arange(n_c, dtype=np.int32), n_c)
        return Blocks(np.ascontiguousarray(cut), columns, np.arange(n_c + 1, dtype=np.int32) * np.int32(n_c))
    columns, starts = matrix.indices.astype(np.int32, copy=False), matrix.indptr.astype(np.int32, copy=False)
    return _blocks_from_rows(data, columns, starts, dim)


def _blocks_from_rows(data: np.ndarray, indices: np.ndarray, indptr: np.ndarray, dim: int) -> Blocks:
    n_c = (indptr.shape[0] - 1) // dim
    starts = np.empty(n_c + 1, dtype=np.int32)
    columns = np.empty(indices.shape[0] + n_c, dtype=np.int32)
    cut = np.empty((indices.shape[0] + n_c, dim, dim))  # pages that are never written take no memory
    count = cut_rows(data, indices, indptr, cut, columns, starts, np.empty(n_c, dtype=np.int32))
    return Blocks(cut[:count], columns[:count], starts)


@kernel
def begin_block(G, columns, slot, j, count):
    """A block of zeros in column j of the row at hand; returns how many there are."""
    slot[j] = count
    columns[count] = j
    for a in range(G.shape[1]):
        for b in range(G.shape[1]):
            G[count, a, b] = 0.0
    return count + 1


@kernel(
    "int64(float64[::1], int32[::1], int32[::1], float64[:, :, ::1], int32[::1], int32[::1], int32[::1])",
    takes_arrays=True,
)
def cut_rows(data, indices, indptr, G, columns, starts, slot):
    """Cut scalar compressed rows into blocks, the diagonal ones always present; returns their number.

    slot (n_c,) is where the block of a column was put last.
    """
    dim = G.shape[1]
    n_c = starts.shape[0] - 1
    count = 0
    for j in range(n_c):
        slot[j] = -1
    for i in range(n_c):
        starts[i] = count
        count = begin_block(G, columns, slot, i, count)
        for a in range(dim):
            for k in range(indptr[i * dim + a], indptr[i * dim + a + 1]):
                j = indices[k] // dim
                if slot[j] < starts[i]:
                    count = begin_block(G, columns, slot, j, count)
                G[slot[j], a, indices[k] - j * dim] += data[k]
    starts[n_c] = count
    return count


def diagonal_blocks(blocks: Blocks) -> np.ndarray:
    """The blocks G_ii, shape (n_c, dim, dim)."""
    rows = np.repeat(np.arange(blocks.indptr.shape[0] - 1), np.diff(blocks.indptr))
    return np.ascontiguousarray(blocks.G[blocks.indices == rows])


def contact_scale(blocks: Blocks) -> np.ndarray:
    """rho_i: mean diagonal of G_ii; where that is not positive the largest entry of its rows, where those are 0 one."""
    rho = np.trace(diagonal_blocks(blocks), axis1=1, axis2=2) / blocks.G.shape[1]
    for i in np.flatnonzero(~(rho > 0)):
        row = blocks.G[blocks.indptr[i] : blocks.indptr[i + 1]]
        rho[i] = np.abs(row).max(initial=0.0) or 1.0
    return rho


def scale_problem(problem: Problem) -> tuple[Problem, np.ndarray]:
    """The scaled problem and the factor (n,) with P = factor * P~."""
    blocks, dim = problem.blocks, problem.dim
    s = np.exp2(np.round(np.log2(problem.rho) / 2))
    peak = np.abs(problem.c / np.repeat(s, dim)).max(initial=0.0)
    sigma = np.exp2(np.round(np.log2(peak))) if peak > 0 else 1.0
    rows = np.repeat(np.arange(problem.n_c), np.diff(blocks.indptr))
    G = blocks.G / s[rows][:, None, None] / s[blocks.indices][:, None, None]
    c = problem.c / np.repeat(s, dim) / sigma
    unit = Problem(
        Blocks(G, blocks.indices, blocks.indptr), c, problem.mu, problem.rho / s**2, problem.weight * (s * sigma)
    )
    return unit, np.repeat(sigma / s, dim)


def as_matrix(blocks: Blocks) -> np.ndarray:
    """The full matrix (n, n)."""
    n_c, dim = blocks.indptr.shape[0] - 1, blocks.G.shape[1]
    full = np.zeros((n_c, n_c, dim, dim))
    full[np.repeat(np.arange(n_c), np.diff(blocks.indptr)), blocks.indices] = blocks.G
    return full.transpose(0, 2, 1, 3).reshape(n_c * dim, n_c * dim)
