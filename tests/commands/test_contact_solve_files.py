"""Files in, table and performance profile out."""

import numpy as np
import pytest

from benchmarks.problems import packing
from nonsmooth.commands.cli import main
from nonsmooth.commands.solve_files import format_table, load_problem, performance_profile, solve_files, time_ratios
from nonsmooth.errors import InvalidInput
from nonsmooth.lcp.mixed import solve_mlcp


@pytest.fixture
def files(tmp_path):
    contact = {"data": np.ones(2), "indices": np.arange(2), "indptr": np.arange(3), "shape": np.array([2, 2])}
    np.savez(tmp_path / "block.npz", **contact, q=np.array([-1.0, 2.0]), mu=np.array([0.5]), dim=np.array(2))
    np.savez(tmp_path / "lcp.npz", M=np.array([[2.0, 1.0], [1.0, 2.0]]), q=np.array([-5.0, -6.0]))
    np.savez(tmp_path / "strange.npz", x=np.ones(2))
    return [tmp_path / name for name in ("block.npz", "lcp.npz", "strange.npz", "missing.npz")]


def test_every_file_gets_a_row_and_a_bad_one_its_reason(files):
    rows = solve_files(files)
    assert [row["kind"] for row in rows] == ["fc2d", "lcp", None, None]
    assert [row["status"] for row in rows] == ["SOLVED", "SOLVED", "ERROR", "ERROR"]
    assert [row["rank"] for row in rows[:2]] == [2, 2]
    assert rows[0]["n"] == 2 and rows[0]["contacts"] == 1 and rows[0]["error"] <= 1e-8 and rows[0]["time"] > 0
    table = format_table(rows)
    assert "2 of 4 solved" in table and "strange.npz: strange.npz must hold M and q" in table


def test_a_friction_problem_that_takes_too_long_says_so_and_an_lcp_refuses_a_budget(tmp_path, files, capsys):
    """101 redundant contacts of spheres at rest: every solver takes more than a millisecond."""
    case = packing(np.random.default_rng([7, 200, 3]), 200, 3, noise=0.0)
    rows = {"data": case.G.data, "indices": case.G.indices, "indptr": case.G.indptr, "shape": np.array(case.G.shape)}
    np.savez(tmp_path / "pile.npz", **rows, q=case.c, mu=case.mu, dim=np.array(3))
    assert main(["solve", str(tmp_path / "pile.npz"), "--max-time", "0.001"]) == 3
    assert "BUDGET_SPENT" in capsys.readouterr().out
    spent, solved, refused = solve_files([tmp_path / "pile.npz", *files[:2]], max_time=1e-3)
    assert spent["status"] == "BUDGET_SPENT" and "max_time = 0.001 s is used up" in spent["message"]
    assert solved["status"] == "SOLVED" and refused["status"] == "ERROR"
    assert "leave it out for complementarity problems" in refused["message"]
    with pytest.raises(InvalidInput, match="max_time must be positive"):
        solve_files(files, max_time=-1.0)


def test_rows_without_complementarity_are_equations(tmp_path):
    """z_0 = 1 from the equation, although w_0 = z_0 - 1; z_1 = 0 as w_1 = z_1 + z_0 > 0. Swapped, z_1 would be -1."""
    matrix = np.array([[1.0, 0.0], [1.0, 1.0]])
    np.savez(tmp_path / "mixed.npz", M=matrix, q=np.array([-1.0, 0.0]), is_comp=np.array([0, 1]))
    kind, A, (_, b, free) = load_problem(tmp_path / "mixed.npz")
    assert kind == "mlcp" and free.tolist() == [True, False]
    assert solve_files([tmp_path / "mixed.npz"])[0]["status"] == "SOLVED"
    np.testing.assert_allclose(A @ solve_mlcp(A, b, free).z + b, [0.0, 1.0], atol=1e-15)


LCP = {"M": np.array([[2.0, 1.0], [1.0, 2.0]]), "q": np.array([-5.0, -6.0])}
MIXED = LCP | {"is_comp": np.array([True, False])}
FRICTION = {
    "data": np.ones(4), "indices": np.arange(4), "indptr": np.arange(5), "shape": np.array([4, 4]), "q": np.ones(4),
    "mu": np.ones(2), "dim": np.array(2),
}  # fmt: skip


@pytest.mark.parametrize(("problem", "change", "words"), [
    (LCP, {"M": np.array([[2, 1], [1, 2]])}, r"M must be float64; it is int64 \(<i8\)"),
    (LCP, {"M": LCP["M"].astype(np.float32)}, "M must be float64; it is float32"),
    (LCP, {"q": LCP["q"].astype(complex)}, "(M|q) must be float64; it is complex128"),
    (LCP, {"q": LCP["q"].astype(">f8")}, "is no plain array: big-endian numbers are not read"),
    (LCP, {"q": LCP["q"][:1]}, r"q must have the shape \(n = 2\); it has \(1,\)"),
    (LCP, {"M": LCP["M"][:, :1]}, r"M must have the shape \(n = 2, n = 2\); it has \(2, 1\)"),
    (LCP, {"M": LCP["M"].ravel()}, r"M must have the shape \(n, n\); it has \(4,\)"),
    (LCP, {"q": np.array([np.nan, 1.0])}, "q must be finite"),
    (LCP, {"A": np.eye(2), "n": np.array(2)}, "is a mixed problem without is_comp"),
    (MIXED, {"is_comp": np.array([1.0, 0.0])}, "is_comp must be bool, int32 or int64; it is float64"),
    (MIXED, {"is_comp": np.array([0, 2])}, "is_comp must be 0 or 1 in each row"),
    (MIXED, {"is_comp": np.array([True])}, r"is_comp must have the shape \(n = 2\)"),
    (FRICTION, {"indices": np.array([0, 1, 2, 4])}, "an index of a matrix must lie in 0 ... 3; one is 4"),
    (FRICTION, {"indices": np.array([0, 1, 2, -1])}, "one is -1"),
    (FRICTION, {"indptr": np.array([0, 1, 2, 3, 5])}, "the starts of 4 rows must be 5 numbers that grow from 0 to at"),
    (FRICTION, {"indptr": np.array([0, 2, 1, 3, 4])}, "the starts of 4 rows"),
    (FRICTION, {"indices": np.arange(4.0)}, "indices must be int32 or int64; it is float64"),
    (FRICTION, {"shape": np.array([4, 10**12])}, "and W the shape"),
    (FRICTION, {"mu": np.ones(3)}, "mu has 3 contacts of dim 2"), (FRICTION, {"dim": np.array(7)}, "of dim 7"),
    (FRICTION, {"data": np.array([1, 2, 3, np.inf])}, "data must be finite"),
])  # fmt: skip
def test_problems_whose_arrays_do_not_fit_are_refused_by_name_and_nothing_is_cast(tmp_path, problem, change, words):
    np.savez(tmp_path / "a.npz", **problem | change)
    with pytest.raises(InvalidInput, match=f"a.npz.*{words}"):
        load_problem(tmp_path / "a.npz")
    (row,) = solve_files([tmp_path / "a.npz"])
    assert row["status"] == "ERROR" and row["message"].startswith("a.npz")


@pytest.mark.parametrize(("problem", "kind"), [(LCP, "lcp"), (MIXED, "mlcp"), (FRICTION, "fc2d")])
def test_indices_of_either_length_and_columns_first_are_the_same_problem(tmp_path, problem, kind):
    np.savez(tmp_path / "a.npz", **{
        name: np.asfortranarray(array) if array.dtype == float else array.astype(np.int32)
        for name, array in problem.items()
    })  # fmt: skip
    found, matrix, _ = load_problem(tmp_path / "a.npz")
    assert found == kind
    np.testing.assert_array_equal(matrix.toarray() if kind == "fc2d" else matrix, problem.get("M", np.eye(4)))


def test_fclib_files_are_solved_too(tmp_path):
    pytest.importorskip("h5py")
    from nonsmooth.results.fclib import ContactProblem, write_fclib

    write_fclib(tmp_path / "a.h5", ContactProblem(np.eye(3), np.array([-1.0, 3.0, 4.0]), np.array([0.5]), 3))
    (row,) = solve_files([tmp_path / "a.h5"])
    assert row["kind"] == "fc3d" and row["status"] == "SOLVED"


def test_a_single_path_is_refused(tmp_path):
    with pytest.raises(InvalidInput, match="must be a list"):
        solve_files(tmp_path / "a.npz")


def test_time_ratios_are_those_of_the_fastest_solver_and_infinite_for_failures():
    def rows(*times):
        return [{"file": str(k), "time": t, "status": "SOLVED" if t else "STALLED"} for k, t in enumerate(times)]

    ratios = time_ratios({"a": rows(1.0, 4.0, None), "b": rows(2.0, 1.0, None)})
    np.testing.assert_array_equal(ratios["a"], [1.0, 4.0, np.inf])
    np.testing.assert_array_equal(ratios["b"], [2.0, 1.0, np.inf])
    with pytest.raises(InvalidInput, match="same files"):
        time_ratios({"a": rows(1.0), "b": rows(1.0, 2.0)})


def test_profile_is_drawn(files, tmp_path):
    pytest.importorskip("matplotlib")
    runs = {name: solve_files(files[:1], solver=name) for name in ("auto", "nsgs")}
    performance_profile(runs, tmp_path / "profile.png")
    assert (tmp_path / "profile.png").read_bytes()[:4] == b"\x89PNG"
