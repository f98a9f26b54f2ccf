"""Figures of sweeps: what is drawn are the numbers of the result."""

from __future__ import annotations

import numpy as np
import pytest

import nonsmooth as ns
from models.belt_oscillator import BeltOscillator
from models.painleve_rod import PainleveRod
from nonsmooth.drawing.sweep_plot import is_geometric, plot_sweep
from tests.drawing.looks import faults

pytest.importorskip("matplotlib")


@pytest.mark.filterwarnings("ignore::nonsmooth.UnsettledWarning")
def test_one_axis_is_a_curve(tmp_path):
    task = ns.RunTask(BeltOscillator(), ["amplitude", "period"], t_span=(0, 5), integrator=ns.MoreauJean(1e-2))
    found = ns.sweep(task, {"vb": np.linspace(0.05, 0.4, 8)}, progress=False)
    figure = plot_sweep(found, tmp_path / "curve.png")
    (axes,) = figure.axes
    x, y = axes.lines[0].get_data()
    np.testing.assert_array_equal(x, found.vb)
    np.testing.assert_array_equal(y, found.amplitude[:, 0])
    assert (
        axes.get_xlabel() == "vb [m/s]"
        and axes.get_ylabel() == "amplitude [m]"
        and (tmp_path / "curve.png").stat().st_size
    )
    assert plot_sweep(found, name="period").axes[0].get_ylabel() == "period [s]"


def test_two_axes_are_a_map_with_missing_cells_left_out_and_counted():
    task = ns.RunTask(PainleveRod(), "paradoxes", t_span=(0, 0.1), integrator=ns.MoreauJean(1e-3))
    found = ns.sweep(task, {"mu": np.linspace(-0.5, 2, 6), "th": np.linspace(0.2, 1.5, 7)}, progress=False)
    figure = plot_sweep(found)
    mesh = figure.axes[0].collections[0]
    drawn = mesh.get_array().reshape(7, 6)
    np.testing.assert_array_equal(drawn.filled(np.nan), found.paradoxes.values.T)
    assert drawn.mask[:, 0].all() and not drawn.mask[:, 1:].any()
    assert "no result in 7 of 42 cells" in figure.get_suptitle()
    assert figure.axes[0].get_xlabel() == "μ [-]" and figure.axes[0].get_ylabel() == "θ [rad]"


@pytest.mark.filterwarnings("ignore::nonsmooth.UnsettledWarning")
def test_cells_that_have_not_settled_are_hatched_in_a_map_and_ringed_on_a_curve(tmp_path):
    task = ns.RunTask(BeltOscillator(), "amplitude", t_span=(0, 40), integrator=ns.MoreauJean(1e-2))
    found = ns.sweep(task, {"vb": np.linspace(0.05, 0.5, 10), "k": np.linspace(0.5, 2.0, 5)}, progress=False)
    n = int((found.settled == 0).sum())
    assert 0 < n < found.settled.size
    figure = plot_sweep(found, tmp_path / "map.png")
    assert f"not settled in {n} of 50 cells (hatched)" in figure.get_suptitle() and faults(figure) == []
    (hatched,) = [one for one in figure.axes[0].collections if one.get_gid() == "unsettled"]
    assert len(hatched.get_paths()) == n
    one = found.isel(k=2)
    curve = plot_sweep(one)
    rings = curve.axes[0].lines[1].get_xdata()
    np.testing.assert_array_equal(rings, one.vb.values[one.settled.values == 0])


def test_each_coordinate_has_its_panel_and_its_unit():
    task = ns.RunTask(PainleveRod(), "final_state", t_span=(0, 0.05))
    found = ns.sweep(task, {"mu": [0.1, 0.2, 0.5]}, progress=False)
    labels = [axes.get_ylabel() for axes in plot_sweep(found, name="u").axes]
    assert labels == ["u of x [m/s]", "u of y [m/s]", "u of θ [rad/s]"]


def test_steps_of_equal_ratio_get_a_logarithmic_axis():
    assert is_geometric(np.geomspace(1e-5, 1e-2, 7)) and not is_geometric(np.linspace(1, 2, 7))
    assert not is_geometric(np.array([-1.0, 1.0, 3.0]))


def test_what_cannot_be_drawn_is_said():
    task = ns.RunTask(BeltOscillator(), "modes", t_span=(0, 0.1))
    found = ns.sweep(task, {"vb": [0.1, 0.2]}, progress=False)
    with pytest.raises(ns.InvalidInput, match="none of the results is a number"):
        plot_sweep(found)
    with pytest.raises(ns.UnknownName, match="no result 'mode'"):
        plot_sweep(found, name="mode")
    for axes in ({"vb": [0.1]}, [{"vb": 0.1}, {"vb": 0.2}]):
        with pytest.raises(ns.InvalidInput, match="a figure needs one or two axes"):
            plot_sweep(ns.sweep(BeltOscillator(), axes, progress=False))
