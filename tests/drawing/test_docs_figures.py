"""Figures of the pages, drawn from made-up measurements: what is shown, and how it looks."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from benchmarks.stress_figures import Outcome
from benchmarks.stress_plots import LEAST, METHODS, NAMES, REASONS, plot_agreement, plot_margins
from benchmarks.stress_random import Verdict
from tests.drawing.looks import faults

DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture(scope="module")
def rng():
    return np.random.default_rng(18)


def test_every_figure_over_its_bound_is_a_point_of_its_integrator(rng):
    def outcome(method):
        return Outcome("fall", f"{method} 1e-3", 10, *10.0 ** rng.uniform(-17, 0, 5), (1.0,) * 5, "")

    outcomes = [outcome(method) for method in METHODS for _ in range(40)]
    outcomes.append(Outcome("rest", "Penalty k = 1e6", 1, 0.0, *[np.nan] * 4, (1.0, *[np.nan] * 4), ""))
    figure = plot_margins(outcomes)
    drawn = {line.get_label(): line.get_ydata() for line in figure.axes[0].lines if line.get_label() in METHODS}
    assert [len(drawn[method]) for method in METHODS] == [200, 200, 200, 201] and min(drawn["Penalty"]) == LEAST
    places = figure.axes[0].lines[0].get_xdata()
    assert set(np.rint(places)) == set(range(len(NAMES))) and np.abs(places - np.rint(places)).max() < 0.5
    assert faults(figure) == []


def test_distances_to_located_events_are_told_apart_by_their_reasons(rng):
    verdicts = [
        Verdict(k, method, 10.0 ** rng.uniform(-12, 0), 10.0 ** rng.uniform(-6, 0), REASONS[k % 5] if k % 5 else "")
        for method in ("MoreauJean", "Adaptive", "Penalty")
        for k in range(60)
    ]  # fmt: skip
    figure = plot_agreement(verdicts)
    for axes in figure.axes:
        drawn = [line for line in axes.lines if line.get_label() in REASONS]
        assert [len(line.get_xdata()) for line in drawn] == [12] * 5
        assert len({(line.get_marker(), line.get_color()) for line in drawn}) == 5
    assert [axes.get_title() for axes in figure.axes] == [
        "MoreauJean\ndt = 0.0001 s", "Adaptive\nrtol = 1e-07", "Penalty\nk = 1e+10 N/m",
    ]  # fmt: skip
    assert faults(figure) == []


def test_error_of_each_scene_stands_beside_its_tolerance():
    source = importlib.util.spec_from_file_location("adaptive", DOCS / "figures" / "adaptive.py")
    page = importlib.util.module_from_spec(source)
    source.loader.exec_module(page)
    found = [page.Row(name, rtol, 0.3 * rtol, 10, 10, "FINISHED") for name in page.SCENES for rtol in page.TOLERANCES]
    figure = page.draw(found)
    titles = [axes.get_title().replace("\n", " ") for axes in figure.axes]
    assert titles == list(page.SCENES)
    for axes in figure.axes:
        (measured,) = (line for line in axes.lines if line.get_label() == "measured")
        np.testing.assert_allclose(measured.get_ydata(), 0.3 * np.array(page.TOLERANCES), rtol=1e-15)
    assert faults(figure) == []
