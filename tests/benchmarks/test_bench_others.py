"""The page of problems of others judges everybody alike."""

import numpy as np
import pytest

from benchmarks import others, siconos
from nonsmooth.contact.blocks.solve import solve_contact
from nonsmooth.errors import InvalidInput


@pytest.mark.parametrize("dim", [2, 3])
def test_the_common_measure_is_the_natural_map_with_rho_1(dim):
    """Written a second time, without the library's kernels; away from a solution, on and off the cones."""
    rng = np.random.default_rng(dim)
    root = rng.normal(size=(4 * dim, 4 * dim))
    G, c, mu = root @ root.T, rng.normal(size=4 * dim), rng.uniform(0, 1, 4)
    result = solve_contact(G, c, mu, dim)
    assert others.error_of((G, c, mu, dim), result.P) == pytest.approx(result.error_rho_1, abs=1e-14)
    start = solve_contact(G, c, mu, dim, solver="nsgs", tol=1e-1)
    assert others.error_of((G, c, mu, dim), start.P) == pytest.approx(start.error_rho_1, rel=1e-10)


def test_complementarity_is_judged_by_the_smaller_of_both():
    A, b = np.array([[2.0, 1.0], [1.0, 2.0]]), np.array([-3.0, 1.0])
    assert others.error_of((A, b), np.array([1.5, 0.0])) == 0.0
    assert others.error_of((A, b), np.array([1.5, 0.1])) == pytest.approx(0.1 / 3)
    free = np.array([True, False])
    assert others.error_of((A, b, free), np.array([1.4, 0.0])) == pytest.approx(0.2 / 3)
    assert others.error_of((A, b), np.array([np.nan, 0.0])) == np.inf


def test_the_mean_is_geometric_and_over_what_both_solve():
    def row(ours, theirs, error=0.0):
        best = None if theirs is None else others.Answer("NSGS, dense", theirs, 0.0)
        return others.Row("a problem", 9, others.Answer("auto", ours, error), best)

    page = "\n".join(
        others.section("Friction", [row(4e-6, 1e-6), row(1e-6, 1e-6), row(1e-3, None), row(1.0, 1.0, 1e-3)])
    )
    assert "2 problems that both solve: geometric mean of the ratios 2." in page
    assert "We solve 3 of 4, some solver of Siconos 3." in page
    assert "1000 ms (1e-03)" in page or "1e+03 ms (1e-03)" in page


def test_a_folder_of_problems_makes_a_page(capsys, monkeypatch):
    monkeypatch.setattr(siconos, "interpreter", lambda: None)
    monkeypatch.setattr(others, "SOLVERS", {"mlcp": ()})
    assert others.main(["tests/data"]) == 0
    page = capsys.readouterr().out
    assert "We solve 6 of 6" in page and "| Buck2_mlcp | 32 |" in page


def test_a_folder_without_problems_is_refused(tmp_path):
    with pytest.raises(InvalidInput, match="needs folders of problems"):
        others.main([str(tmp_path)])


@pytest.mark.skipif(siconos.interpreter() is None, reason="no Siconos (Debian: apt-get install python3-siconos)")
def test_a_solver_of_siconos_is_timed_and_judged_and_one_that_dies_is_none():
    from pathlib import Path

    from nonsmooth.commands.solve_files import load_problem

    file = Path("tests/data/fc3d/FrictionContact3D_1c.npz")
    arguments = load_problem(file)[2]
    answer = others.answer_of(siconos.interpreter(), file, arguments, "NSGS", "dense")
    assert answer.error <= others.SOLVED and 0 < answer.seconds < 1
    assert others.answer_of(siconos.interpreter(), file, arguments, "NO_SUCH_SOLVER", "dense") is None
