"""The page of the stress cases says what failed, and has its two pictures."""

import pytest

from benchmarks import stress, stress_motions, stress_random
from benchmarks.stress_figures import run

pytest.importorskip("matplotlib")


def test_the_page_marks_a_figure_beyond_its_bound_and_counts_the_systems_that_agree(tmp_path):
    case = next(stress_motions.cases(False))
    good = [run(case, method) for method in case.methods]
    bad = good[0]._replace(bounds=(*good[0].bounds[:-1], 0.1 * good[0].figures[-1]))
    verdicts = [
        stress_random.Verdict(seed, "MoreauJean", error, 1e-3, reason)
        for seed, error, reason in ((1, 1e-4, ""), (2, 1e-5, ""), (3, 1.0, "paradox"), (4, 1.0, ""))
    ]
    stress.write_page(tmp_path / "page.md", tmp_path, {"Bounces": [*good, bad]}, verdicts)
    page = (tmp_path / "page.md").read_text()
    assert f"{len(good) + 1} runs, 1 beyond a bound or not finished" in page
    (failing,) = (line for line in page.splitlines() if line.endswith("| *fails* |"))
    assert f"**{bad.figures[-1]:.0e}** > {bad.bounds[-1]:.0e}" in failing and case.name in failing
    assert "| MoreauJean | agrees | 2 |" in page and "| MoreauJean | paradox | 1 |" in page
    assert "Open: MoreauJean 4." in page
    for name in ("stress_margins.png", "stress_random.png"):
        assert name in page and (tmp_path / name).read_bytes().startswith(b"\x89PNG")
