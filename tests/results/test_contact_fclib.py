"""FCLIB files: written and read back in every matrix format, and files laid out as the C library does."""

import numpy as np
import pytest
from scipy import sparse

from nonsmooth.contact.blocks.solve import solve_contact
from nonsmooth.errors import InvalidInput, UnknownName
from nonsmooth.results.fclib import ContactProblem, GlobalContactProblem, read_fclib, write_fclib

h5py = pytest.importorskip("h5py")
FORMATS = ["csr", "csc", "triplet"]


def global_problem(with_bilateral=False):
    rng = np.random.default_rng(4)
    H, f, w = rng.normal(size=(8, 6)), rng.normal(size=8), rng.normal(size=6)
    M = sparse.csr_array(np.diag(rng.uniform(1, 3, 8)) + np.triu(np.full((8, 8), 0.01)))
    extra = {"G": sparse.csr_array(rng.normal(size=(8, 2))), "b": rng.normal(size=2)} if with_bilateral else {}
    return GlobalContactProblem(M=M, H=sparse.csr_array(H), f=f, w=w, mu=np.array([0.3, 0.7]), dim=3, **extra)


@pytest.mark.parametrize("matrix_format", FORMATS)
def test_local_problem_survives_a_round_trip_with_its_unsymmetric_matrix(tmp_path, matrix_format):
    problem = global_problem().local()
    G = problem.G.toarray() + np.triu(np.ones((6, 6)))
    solution = solve_contact(G, problem.c, problem.mu, 3).P
    written = ContactProblem(sparse.coo_array(G), problem.c, problem.mu, 3, solution)
    write_fclib(tmp_path / "a.hdf5", written, matrix_format)
    read = read_fclib(tmp_path / "a.hdf5")
    np.testing.assert_array_equal(read.G.toarray(), G)
    np.testing.assert_array_equal(read.c, problem.c)
    np.testing.assert_array_equal(read.mu, problem.mu)
    np.testing.assert_array_equal(read.P, solution)
    assert read.dim == 3 and read.note.startswith("stored impulses")


@pytest.mark.parametrize("matrix_format", FORMATS)
@pytest.mark.parametrize("with_bilateral", [False, True])
def test_global_problem_survives_a_round_trip(tmp_path, matrix_format, with_bilateral):
    written = global_problem(with_bilateral)
    write_fclib(tmp_path / "a.hdf5", written, matrix_format)
    read = read_fclib(tmp_path / "a.hdf5")
    for name in ("M", "H") + (("G",) if with_bilateral else ()):
        np.testing.assert_array_equal(getattr(read, name).toarray(), getattr(written, name).toarray())
    for name in ("f", "w", "mu") + (("b",) if with_bilateral else ()):
        np.testing.assert_array_equal(getattr(read, name), getattr(written, name))
    assert read.note == "" and read.P is None


def test_local_form_of_a_global_problem_obeys_its_equations():
    """M v = H P + f + G l, G^T v + b = 0: v from the local answer moves the contacts with gamma."""
    problem = global_problem(with_bilateral=True)
    local = problem.local()
    result = solve_contact(local.G, local.c, local.mu, local.dim)
    M, H, B = problem.M.toarray(), problem.H.toarray(), problem.G.toarray()
    saddle = np.block([[M, -B], [B.T, np.zeros((2, 2))]])
    v = np.linalg.solve(saddle, np.concatenate([H @ result.P + problem.f, -problem.b]))[:8]
    np.testing.assert_allclose(H.T @ v + problem.w, result.gamma, atol=1e-12 * np.linalg.norm(local.c))


def test_triplets_hold_columns_in_p_and_rows_in_i(tmp_path):
    with h5py.File(tmp_path / "a.hdf5", "w") as file:
        file["fclib_local/spacedim"] = [2]
        for key, value in {"nzmax": [3], "m": [2], "n": [2], "nz": [3]}.items():
            file[f"fclib_local/W/{key}"] = value
        file["fclib_local/W/p"], file["fclib_local/W/i"] = [0, 1, 1], [0, 0, 1]
        file["fclib_local/W/x"] = [2.0, 7.0, 3.0]
        file["fclib_local/vectors/q"], file["fclib_local/vectors/mu"] = [-1.0, 0.0], [0.3]
        file["solution/r"] = [0.0, 0.0]
    problem = read_fclib(tmp_path / "a.hdf5")
    np.testing.assert_array_equal(problem.G.toarray(), [[2.0, 7.0], [0.0, 3.0]])
    assert "placeholder (r = 0)" in problem.note


def test_bilateral_constraints_of_a_local_problem_are_eliminated(tmp_path):
    """W = diag(2, 2), V = e_T, R = -1, s = 3: l = V^T r + s, so that G_TT = 2 + 1 and c_T = q_T + 3."""
    write_fclib(
        tmp_path / "a.hdf5", ContactProblem(sparse.csr_array(2 * np.eye(2)), np.array([-1.0, 0.5]), np.ones(1), 2)
    )
    with h5py.File(tmp_path / "a.hdf5", "a") as file:
        blocks = {"V": (2, [0.0, 1.0], [0, 1], [0, 2]), "R": (1, [-1.0], [0], [0, 1])}
        for name, (m, x, i, p) in blocks.items():
            for key, value in {"m": [m], "n": [1], "nz": [-1], "nzmax": [len(x)], "x": x, "i": i, "p": p}.items():
                file[f"fclib_local/{name}/{key}"] = value
        file["fclib_local/vectors/s"] = [3.0]
    problem = read_fclib(tmp_path / "a.hdf5")
    np.testing.assert_allclose(problem.G.toarray(), [[2.0, 0.0], [0.0, 3.0]])
    np.testing.assert_allclose(problem.c, [-1.0, 3.5])


def test_what_cannot_be_read_or_written_is_named(tmp_path):
    with pytest.raises(InvalidInput, match="there is none"):
        read_fclib(tmp_path / "none.hdf5")
    (tmp_path / "text.hdf5").write_text("no HDF5")
    with pytest.raises(InvalidInput, match="must be an HDF5 file"):
        read_fclib(tmp_path / "text.hdf5")
    with h5py.File(tmp_path / "other.hdf5", "w") as file:
        file["x"] = [1]
    with pytest.raises(InvalidInput, match="must hold /fclib_local or /fclib_global"):
        read_fclib(tmp_path / "other.hdf5")
    with pytest.raises(UnknownName, match="did you mean 'csr'"):
        write_fclib(tmp_path / "a.hdf5", global_problem(), "csrr")
    with pytest.raises(InvalidInput, match=r"got \{\}"):
        write_fclib(tmp_path / "a.hdf5", {})
    assert not list(tmp_path.glob("*.part"))
