"""FCLIB files (HDF5): frictional contact problems as other laboratories exchange them.

    local     u = W r + V l + q,   0 = V^T r + R l + s                                   /fclib_local
    global    M v = H r + G l + f,   0 = G^T v + b,   u = H^T v + w                      /fclib_global

V, R, s and G, b, the bilateral constraints with multipliers l, may be absent. u and r are our gamma and P. A matrix is
a group {nzmax, m, n, nz, p, i, x}: nz = -1 compressed columns, -2 compressed rows, nz >= 0 triplets. In triplet files
p holds column and i row indices, although the header of the C library says the opposite.

Source: Acary, Bremond, Koziara and Perignon, FCLIB: a collection of discrete 3D Frictional Contact problems, INRIA
RT-0444 (2014).
Equations: docs/theory/contact_solvers.md, (7).
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.checks.arrays import as_array, as_instance, as_name, as_vector
from nonsmooth.checks.files import as_path, as_place
from nonsmooth.checks.memory import require_memory
from nonsmooth.errors import InvalidInput, shown
from nonsmooth.results.fclib_group import FORMATS, GLOBAL, LOCAL, NAMES, Datasets, Group, read_checked
from nonsmooth.results.foreign_hdf5 import ROOT, is_hdf5, read_datasets, read_foreign
from nonsmooth.results.forms import REAL
from nonsmooth.results.hdf5 import put_array, require_h5py, seal_of, write_hdf5
from nonsmooth.views import Worded

if TYPE_CHECKING:
    from nonsmooth.contact.blocks.result import ContactResult

FCLIB_ENDINGS = (".hdf5", ".h5")
KIND = "fclib"


@dataclass(frozen=True, repr=False)
class ContactProblem(Worded):
    """A contact problem gamma = G P + c with friction coefficients mu.

    Attributes
    ----------
    G : scipy.sparse matrix, shape (n, n)
        Delassus matrix [1/kg], interleaved per contact (N, T1[, T2]).
    c : ndarray, shape (n,)
        Velocity without contact impulses [m/s].
    mu : ndarray, shape (n_c,)
        Friction coefficients [-].
    dim : int
        2 (planar) or 3 (spatial).
    P : ndarray, shape (n,), optional
        Impulses stored with the problem [N s]; see ``note``.
    note : str
        What is known of the stored impulses.
    about : str
        What the problem is: the description in FCLIB's ``info``.
    """

    G: Any
    c: np.ndarray
    mu: np.ndarray
    dim: int
    P: np.ndarray | None = None
    note: str = ""
    about: str = ""

    def __post_init__(self) -> None:
        from nonsmooth.contact.blocks.problem import check_problem

        n = check_problem(self.G, self.c, self.mu, self.dim).n
        if self.P is not None:
            as_vector("P", self.P, n)
        as_instance("note", self.note, str, "a text")
        as_instance("about", self.about, str, "a text")

    def local(self) -> ContactProblem:
        """This problem itself."""
        return self


@dataclass(frozen=True, repr=False)
class GlobalContactProblem(Worded):
    """M v = H P + f (+ G l), gamma = H^T v + w, with optional bilateral constraints 0 = G^T v + b.

    Attributes
    ----------
    M, H : scipy.sparse matrices, shapes (n_u, n_u) and (n_u, n)
        Mass matrix [kg] and transposed directions of the contacts [-].
    f, w, mu : ndarray, shapes (n_u,), (n,), (n_c,)
        Momentum without contacts [N s], velocity of the surfaces [m/s], friction coefficients [-].
    dim : int
        2 (planar) or 3 (spatial).
    G, b : scipy.sparse matrix (n_u, n_b) and ndarray (n_b,), optional
        Bilateral constraints.
    P, note
        As for `ContactProblem`.

    Examples
    --------
    A mass of 2 kg falls at 1 m/s and slides at 3 m/s onto a floor with mu = 0.5 (f = M v):

    >>> import numpy as np
    >>> from nonsmooth.contact.blocks.solve import solve_contact
    >>> from nonsmooth.results.fclib import GlobalContactProblem
    >>> problem = GlobalContactProblem(2 * np.eye(2), np.eye(2), np.array([-2.0, 6.0]), np.zeros(2), np.array([0.5]), 2)
    >>> local = problem.local()
    >>> solve_contact(local.G, local.c, local.mu, local.dim).P.tolist()
    [2.0, -1.0]
    >>> problem.solve().P.tolist()
    [2.0, -1.0]
    """

    M: Any
    H: Any
    f: np.ndarray
    w: np.ndarray
    mu: np.ndarray
    dim: int
    G: Any = None
    b: np.ndarray | None = None
    P: np.ndarray | None = None
    note: str = ""

    def __post_init__(self) -> None:
        if isinstance(self.dim, bool) or not isinstance(self.dim, int | np.integer) or self.dim not in (2, 3):
            raise InvalidInput(f"dim must be 2 (planar) or 3 (spatial); got {shown(self.dim)}")
        n_u, n = len(as_vector("f", self.f)), len(as_vector("w", self.w))
        if n % self.dim:
            raise InvalidInput(f"w must have {self.dim} entries for each contact; got {n}")
        mu = as_vector("mu", self.mu, n // self.dim)
        if (mu < 0).any():
            raise InvalidInput(f"mu must not be negative; its least entry is {mu.min():g}")
        require_matrix("M", self.M, (n_u, n_u))
        require_matrix("H", self.H, (n_u, n))
        if self.G is not None:
            require_matrix("G", self.G, (n_u, None))
        if self.b is not None:
            as_vector("b", self.b, 0 if self.G is None else np.shape(self.G)[1])
        if self.P is not None:
            as_vector("P", self.P, n)
        as_instance("note", self.note, str, "a text")

    def solve(self, tol: float = 1e-8, max_time: float | None = None) -> ContactResult:
        """Solve it in the form that suits it: rigid bodies on the graph of the bodies, all else as ``local()``.

        Where M has a block of 3 x 3 (plane) or 6 x 6 (space) a body, and each contact touches one body or two, G is
        not made: interior points, conjugate sweeps and sparse factors of the bodies in turn. What they leave above
        the tolerance is handed on to `solve_contact`, of up to 1000 contacts.

        Parameters
        ----------
        tol : float
            Largest accepted natural-map error, relative to the norm of c [-].
        max_time : float, optional
            Wall time after which the best iterate is returned with the status BUDGET_SPENT [s]; unlimited by default.
            The clock is looked at between the parts of a round, of which the longest take some seconds.

        Returns
        -------
        ContactResult
            As of `solve_contact`.

        Raises
        ------
        InvalidInput
            When tol does not lie in (0, 1), max_time is not positive, or M with its constraints is singular.
        """
        from nonsmooth.results.global_solve import solve_global

        return solve_global(self, tol, max_time)

    def local(self) -> ContactProblem:
        """The contact problem with velocities and multipliers eliminated: G = H^T M^-1 H, c = H^T M^-1 f + w."""
        from scipy.sparse import block_array, csc_array, csr_array, vstack

        K, H, f = csc_array(self.M), csc_array(self.H), self.f
        if self.G is not None and self.G.shape[1]:
            G = csc_array(self.G)
            b = np.zeros(G.shape[1]) if self.b is None else self.b
            K = block_array([[K, -G], [G.T, None]], format="csc")
            H = csc_array(vstack([H, csc_array((G.shape[1], H.shape[1]))]))
            f = np.concatenate([f, -b])
        solve = _inverse(K, "M", H.shape[1])
        delassus = csr_array(H.T @ csc_array(solve(H.toarray())))
        return ContactProblem(delassus, H.T @ solve(f) + self.w, self.mu, self.dim, self.P, self.note)


def require_matrix(name: str, matrix: Any, shape: tuple[int, int | None]) -> None:
    """Raise `InvalidInput` unless a matrix, dense or sparse, has this shape (None: any) and finite entries."""
    entries = matrix.data if hasattr(matrix, "tocsr") else as_array(name, matrix)
    own = np.shape(matrix)
    if len(own) != 2 or any(wanted not in (None, size) for wanted, size in zip(shape, own, strict=True)):
        wanted = ", ".join("any" if size is None else str(size) for size in shape)
        raise InvalidInput(f"{name} must be a matrix of shape ({wanted}); got {own}")
    if not np.isfinite(entries).all():
        raise InvalidInput(f"{name} must be finite; one of its entries is not")


def _inverse(K: Any, name: str, columns: int) -> Any:
    """The solution with a matrix, for so many columns, which are dense."""
    from scipy.sparse.linalg import splu

    needed = 16.0 * K.shape[0] * columns  # bytes of the columns and of what they become
    require_memory(needed, "the dense columns of the elimination", "solve the problem in its global form")
    try:
        return splu(K).solve
    except RuntimeError:
        raise InvalidInput(f"{name} with its constraints must be regular; its factorisation met a zero pivot") from None


def read_fclib(path: str | os.PathLike[str]) -> ContactProblem | GlobalContactProblem:
    """Read an FCLIB file, local or global.

    Parameters
    ----------
    path : path-like
        The HDF5 file.

    Returns
    -------
    ContactProblem or GlobalContactProblem
        ``.local()`` gives G, c, mu, dim for `solve_contact` in both cases. Bilateral constraints of a local problem are
        eliminated while reading. ``note`` says whether the stored solution solves the problem.

    Raises
    ------
    InvalidInput
        When the file holds no contact problem.
    MissingExtra
        When h5py is not installed.

    Source: FCLIB, INRIA RT-0444 (2014).
    """
    require_h5py()
    path = as_path("path", path)
    if not os.path.isfile(path):
        raise InvalidInput(f"path must name a file; there is none at {shown(str(path))[1:-1]}")
    try:
        if not is_hdf5(path):
            raise InvalidInput(f"{path.name} must be an HDF5 file; it cannot be opened as one")
        return _problem(_datasets(path), path.name)
    except KeyError as error:
        raise InvalidInput(f"{path.name} is incomplete: it has no {error.args[0]}") from None
    except InvalidInput as error:
        raise InvalidInput(f"{path.name} holds no contact problem: {error}") from None
    except Exception as error:  # a damaged file may make its reader raise anything
        raise InvalidInput(f"{path.name} is damaged: {' '.join(str(error).split())}") from error


def _datasets(path: Path) -> Datasets:
    """What stands in the file under the names of FCLIB: one of ours is read here, others in a process of their own."""
    if not seal_of(path):
        return read_foreign(path, NAMES)
    with require_h5py().File(path, "r") as file:
        return read_datasets(file, NAMES, None)


def _problem(data: Datasets, file_name: str) -> ContactProblem | GlobalContactProblem:
    for group, read in ((LOCAL, _read_local), (GLOBAL, _read_global)):
        if any(name.startswith(f"{group}/") for name in data):
            return read(Group(data, group))
    raise InvalidInput(f"{file_name} must hold /{LOCAL} or /{GLOBAL}; it holds {data[ROOT].tolist()}")


def _read_local(group: Group) -> ContactProblem:
    dim, c, mu = group.count("spacedim"), group.vector("q"), group.vector("mu")
    n = len(c)
    G = group.matrix("W", (n, n))
    if group.has_matrix("V") and group.has_matrix("R"):
        from scipy.sparse import csc_array, csr_array

        V = csc_array(group.matrix("V", (n, None)))
        if V.shape[1]:
            solve = _inverse(csc_array(group.matrix("R", (V.shape[1], V.shape[1]))), "R", n)
            s = group.vector("s") if group.has_vector("s") else np.zeros(V.shape[1])
            G = csr_array(G - V @ csc_array(solve(V.T.toarray())))
            c = c - V @ solve(s)
    P, note = _read_solution(group.data, G, c, mu, dim)
    return ContactProblem(G, c, mu, dim, P, note, str(group.data.get(f"{LOCAL}/info/description", "")))


def _read_global(group: Group) -> GlobalContactProblem:
    f, w = group.vector("f"), group.vector("w")
    problem = GlobalContactProblem(
        M=group.matrix("M", (len(f), len(f))),
        H=group.matrix("H", (len(f), len(w))),
        f=f,
        w=w,
        mu=group.vector("mu"),
        dim=group.count("spacedim"),
        G=group.matrix("G", (len(f), None)) if group.has_matrix("G") else None,
        b=group.vector("b") if group.has_vector("b") else None,
    )
    if "solution/r" not in group.data:
        return problem
    local = problem.local()
    P, note = _read_solution(group.data, local.G, local.c, local.mu, local.dim)
    return GlobalContactProblem(**{**vars(problem), "P": P, "note": note})


def _read_solution(data: Datasets, G: Any, c: np.ndarray, mu: np.ndarray, dim: int) -> tuple[np.ndarray | None, str]:
    """The stored impulses and what they are worth: many files hold r = 0 as a placeholder."""
    from nonsmooth.contact.blocks.problem import check_problem

    if "solution/r" not in data:
        return None, "no stored solution"
    P = read_checked(data, "solution/r", (REAL, ("n",)))
    if P.shape != c.shape or not np.isfinite(P).all():
        return None, f"the stored solution has {P.size} entries instead of {c.size}, or not finite ones: left out"
    error = check_problem(G, c, mu, dim).error(P)
    kind = "a placeholder (r = 0)" if not P.any() and error > 1e-6 else "stored impulses"
    return P, f"{kind} with a natural-map error of {error:.1e}"


def write_fclib(
    path: str | os.PathLike[str], problem: ContactProblem | GlobalContactProblem, matrix_format: str = "csr"
) -> None:
    """Write an FCLIB file; an existing one is replaced only once the new one is complete.

    Parameters
    ----------
    path : path-like
        The HDF5 file.
    problem : ContactProblem or GlobalContactProblem
        Its ``P``, where present, is stored as the solution.
    matrix_format : {"csr", "csc", "triplet"}
        How matrices are stored.

    Raises
    ------
    InvalidInput
        When ``problem`` is neither kind of problem.
    UnknownName
        When there is no such matrix format.
    MissingExtra
        When h5py is not installed.

    Source: FCLIB, INRIA RT-0444 (2014).
    """
    as_name("matrix format", matrix_format, FORMATS)
    as_instance("problem", problem, ContactProblem | GlobalContactProblem, "a ContactProblem or GlobalContactProblem")
    path = as_place("path", path, FCLIB_ENDINGS)
    write_hdf5(path, KIND, lambda file: _fill(file, problem, matrix_format))


def _fill(file: Any, problem: ContactProblem | GlobalContactProblem, matrix_format: str) -> None:
    matrices: dict[str, Any]
    vectors: dict[str, Any]
    if isinstance(problem, ContactProblem):
        group = file.create_group("fclib_local")
        matrices = {"W": problem.G}
        vectors = {"q": problem.c, "mu": problem.mu}
        if problem.about:
            group["info/description"] = np.bytes_(problem.about.encode())  # of fixed length, as the C library reads it
    else:
        group = file.create_group("fclib_global")
        matrices = {"M": problem.M, "H": problem.H, "G": problem.G}
        vectors = {"f": problem.f, "w": problem.w, "mu": problem.mu, "b": problem.b}
    put_array(group, "spacedim", np.array([problem.dim], dtype=np.int32))
    for name, matrix in matrices.items():
        if matrix is not None:
            _write_matrix(group.create_group(name), matrix, matrix_format)
    for name, vector in vectors.items():
        if vector is not None:
            put_array(group, f"vectors/{name}", np.asarray(vector, dtype=float))
    if problem.P is not None:
        local = problem.local()
        put_array(file, "solution/r", np.asarray(problem.P, dtype=float))
        put_array(file, "solution/u", local.G @ problem.P + local.c)


def _write_matrix(group: Any, matrix: Any, matrix_format: str) -> None:
    from scipy.sparse import coo_array, csc_array, csr_array

    if matrix_format == "triplet":
        triplets = coo_array(matrix)
        p, i, x, nz = triplets.col, triplets.row, triplets.data, triplets.nnz
    else:
        compressed = (csr_array if matrix_format == "csr" else csc_array)(matrix)
        p, i, x, nz = compressed.indptr, compressed.indices, compressed.data, FORMATS[matrix_format]
    for key, value in {"nzmax": len(x), "m": matrix.shape[0], "n": matrix.shape[1], "nz": nz}.items():
        put_array(group, key, np.array([value], dtype=np.int32))
    for key, value in {"p": p.astype(np.int32), "i": i.astype(np.int32), "x": x.astype(float)}.items():
        put_array(group, key, value)
