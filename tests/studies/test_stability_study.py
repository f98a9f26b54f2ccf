"""`nonsmooth study stability`: table, boundaries, figures, refusals; and every figure of vibration is drawn."""

from __future__ import annotations

import json

import numpy as np
import pytest

import nonsmooth as ns
from models import BeltOscillator, FollowerForceArm, ModeCoupling, SpragSlip
from nonsmooth.commands.cli import main
from nonsmooth.drawing.stability_plots import (
    plot_amplitudes,
    plot_averaged,
    plot_eigen_path,
    plot_friction_laws,
    plot_snapshots,
    plot_stability_map,
    with_meetings,
)
from nonsmooth.studies.stability import study_stability
from tests.drawing.looks import faults


def test_study_of_one_point_gives_the_equilibrium_its_forces_and_eigenvalues():
    study = study_stability(SpragSlip(), {})
    assert "th = 0.84962671" in study.text and "la_N = 38.5516994 N" in study.text
    assert "negative inertia" in study.text and "10.362024806" in study.text
    assert study.draw is None


def test_study_along_a_parameter_refines_the_boundary_and_draws(tmp_path):
    study = study_stability(ModeCoupling(), {"mu": np.linspace(0.3, 0.8, 6)})
    assert "mu = 0.5225270174" in study.text and "stable -> flutter" in study.text
    study.draw(tmp_path / "path.png")
    assert (tmp_path / "path.png").stat().st_size > 10_000


def test_study_along_a_parameter_without_a_change_says_so():
    assert "stable throughout mu = 0.1 ... 0.2" in study_stability(ModeCoupling(), {"mu": [0.1, 0.2]}).text


def test_study_over_two_parameters_counts_the_verdicts_and_draws(tmp_path):
    study = study_stability(ModeCoupling(), {"mu": [0.4, 0.6], "cz": [0.5, 1.0, 1.5]})
    assert "3 points stable" in study.text and "3 points flutter" in study.text
    study.draw(tmp_path / "map.png")
    assert (tmp_path / "map.png").stat().st_size > 10_000


def test_three_parameters_are_refused():
    with pytest.raises(ns.InvalidInput, match="one or two"):
        study_stability(ModeCoupling(), {"mu": [0.4], "cz": [0.5], "cx": [1.0]})


def test_command_prints_the_speed_at_which_the_belt_loses_its_stability(capsys, tmp_path):
    figure = tmp_path / "belt.png"
    assert main(["study", "stability", "belt-oscillator", "--axis", "vb=0.05:0.6:12", "--plot", str(figure)]) == 0
    assert "vb = 0.4409585518" in capsys.readouterr().out
    assert figure.stat().st_size > 10_000


@pytest.mark.parametrize("arguments, message", [
    (["sliding-block"], "does not slide"),
    (["belt-oscillator", "--axis", "vb"], "START:STOP"),
    (["belt-oscillator", "--axis", "vb=0:x:3"], "no number"),
    (["belt-oscillator", "--axis", "vbb=0.1:1:5"], "did you mean"),
    (["belt-oscillator", "--axis", "vb=0.1:1:3", "vb=1:2:3"], "twice"),
    (["belt-oscillator", "--axis", "vb=0.3:0.3:2"], "order"),
])  # fmt: skip
def test_command_refuses_in_one_line(capsys, arguments, message):
    assert main(["study", "stability", *arguments, "--no-plot"]) == 2
    error = capsys.readouterr().err
    assert message in error and error.count("\n") == 1


def test_what_a_refusal_asks_for_the_command_has_a_word_for(capsys):
    """The belt oscillator on a belt that stands still, about to be moved either way: rests at +-m0 N/k."""
    words = ["study", "stability", "belt-oscillator", "--set", "vb=0", "--no-plot"]
    assert main(words) == 2
    assert "give --sliding, the signs of gamma_F" in capsys.readouterr().err
    places = []
    for sign in (-1, 1):
        assert main([*words, "--json", "--sliding", str(sign)]) == 0
        places.append(json.loads(capsys.readouterr().out)["sliding"]["q"][0])
    belt = BeltOscillator()
    assert places == pytest.approx([belt.m0 * belt.N / belt.k, -belt.m0 * belt.N / belt.k], rel=1e-12)


def test_steady_sliding_is_looked_for_near_the_state_and_with_the_signs_that_are_typed(capsys):
    assert main(["study", "stability", "sprag-slip", "--json", "--state", "th=0.57", "--normal", "-1"]) == 0
    found = json.loads(capsys.readouterr().out)["sliding"]
    rod = SpragSlip()
    other = ns.equilibrium(rod, rod.state(th=0.57)[0], normal=[-1])
    assert found["q"] == pytest.approx(other.q, rel=1e-12)
    assert found["q"] != pytest.approx(ns.equilibrium(rod).q, rel=1e-3)


def test_friction_laws_are_drawn_with_sticking_as_a_vertical_line(tmp_path):
    figure = plot_friction_laws({"cubic": BeltOscillator().system()}, 0.8, tmp_path / "laws.png")
    x, y = figure.axes[0].lines[0].get_data()
    assert y[x == 0].tolist() == [-0.4, 0.4]
    np.testing.assert_allclose(y, -y[::-1], atol=1e-15)


def test_dots_of_the_amplitude_equation_stand_at_its_equilibria(tmp_path):
    motion = ns.averaged_amplitude(BeltOscillator(vb=0.42))
    figure = motion.plot(tmp_path / "rate.png")
    dots = [line.get_xdata()[0] for line in figure.axes[0].lines if line.get_marker() == "o"]
    np.testing.assert_allclose(dots, motion.amplitudes)
    assert plot_averaged([("a", motion), ("b", motion)]).axes[0].get_legend() is not None


def test_eigenvalues_of_two_systems_are_drawn_together_with_the_upper_half_of_their_loci():
    paths = {
        name: ns.eigen_path(ModeCoupling(cx=c, cz=c), "mu", np.linspace(0, 1, 11)) for name, c in (("a", 0), ("b", 1))
    }
    figure = plot_eigen_path(paths)
    assert len(figure.axes) == 3
    assert (
        min(np.nanmin(line.get_ydata(), initial=0.0) for line in figure.axes[2].lines if line.get_color() != "0.5") >= 0
    )


def test_amplitudes_are_drawn_against_the_speed_and_end_where_sliding_is_stable():
    speeds = [0.40, 0.42, 0.46]
    motions = [ns.averaged_amplitude(BeltOscillator(vb=vb)) for vb in speeds]
    stable = plot_amplitudes({"cubic": (speeds, motions)}, points={"x": ([0.4], [0.117])}).axes[0].lines[0].get_ydata()
    np.testing.assert_allclose(stable[:2], [0.1173788, 0.0849575], atol=6e-8)
    assert np.isnan(stable[2])


def test_snapshots_show_the_arm_at_the_records_nearest_to_the_times():
    arm = FollowerForceArm(P=1000.0)
    run = ns.simulate(arm, (0, 0.1), *arm.state(), integrator=ns.MoreauJean(dt=1e-3))
    axes = plot_snapshots(run, [0.0, 0.0504]).axes[1]
    np.testing.assert_allclose(axes.lines[-1].get_xydata(), arm.shape(run.q[50])[-1])
    assert axes.get_title() == "t = 0.05 s"


def test_map_is_drawn_with_its_boundary():
    chart = ns.stability_map(ModeCoupling(), {"mu": [0.4, 0.6], "cz": [0.5, 1.0]}, sensitivities=False)
    assert plot_stability_map(chart, units=("", "N s/m")).axes[0].get_xlabel() == "cz [N s/m]"


def test_points_of_a_map_without_an_equilibrium_are_grey_and_counted():
    chart = ns.stability_map(ModeCoupling(), {"mu": [0.4, 0.6], "cz": [0.5, 1.0]}, sensitivities=False)
    chart.growth[0, 1] = chart.verdict[0, 1] = np.nan
    figure = ns.plot_stability_map(chart)
    assert "no equilibrium found in 1 of 4 points (grey)" in figure.get_suptitle()
    assert np.ma.getmaskarray(figure.axes[0].collections[0].get_array()).sum() == 1
    with pytest.raises(ns.InvalidInput, match="no point of this map has an equilibrium"):
        ns.plot_stability_map(chart * np.nan)


def test_no_letter_stands_over_another_in_figures_of_stability():
    models = {"undamped": ModeCoupling(cx=0.0, cz=0.0), "damped": ModeCoupling()}
    paths = {label: ns.eigen_path(model, "mu", np.linspace(0.0, 1.0, 21)) for label, model in models.items()}
    chart = ns.stability_map(ModeCoupling(), {"mu": [0.4, 0.6], "cz": [0.5, 1.0]}, sensitivities=False)
    for figure in (plot_eigen_path(paths), plot_stability_map(chart)):
        assert faults(figure) == []


def test_no_line_joins_eigenvalues_that_go_through_infinity():
    """Of the sprag-slip rod, where the inertia changes its sign: the boundary to the resolution of the path squared."""
    rod, values = SpragSlip(), np.linspace(0.5, 2.0, 61)
    path = ns.eigen_path(rod, "mu", values)
    x, s = with_meetings(path)
    (k,) = np.flatnonzero(np.isnan(s.real).all(axis=1))
    edge = ns.flutter_boundary(rod, "mu", (x[k - 1], x[k + 1])).value
    assert x[k - 1] < edge < x[k + 1] and abs(x[k] - edge) < 0.1 * (values[1] - values[0])
    title = path.plot().get_suptitle()
    assert title.startswith("sprag-slip\n") and "μ = " not in title and faults(path.plot()) == []


@pytest.mark.upkeep
def test_colours_of_a_stability_map_resolve_what_lies_beside_a_pole():
    chart = ns.stability_map(SpragSlip(), {"mu": np.linspace(0.5, 2, 20), "kth": np.linspace(500, 2000, 20)})
    figure = plot_stability_map(chart)
    (mesh,) = figure.axes[0].collections[:1]
    assert mesh.norm.vmax < 0.5 * np.abs(chart.growth.values).max()
    title = figure.get_suptitle()
    assert title.startswith("sprag-slip\n") and "R = 1" in title and "kth" not in title and faults(figure) == []


def test_curves_of_two_eigenvalues_that_meet_go_through_the_point_where_they_do():
    """x'' + K x = 0 of the coupled modes: undamped, both frequencies are equal where flutter begins."""
    curve = ns.eigen_path(ModeCoupling(cx=0.0, cz=0.0), "mu", np.linspace(0.0, 1.0, 20))
    values, eigenvalues = with_meetings(curve)
    (met,) = np.flatnonzero(~np.isin(values, curve.values))
    upper = np.sort_complex(eigenvalues[met])[-2:]
    assert upper[0] == upper[1] and values[met] == pytest.approx(0.5, abs=5e-4)


@pytest.mark.parametrize(
    "model, where", [("follower-force-arm", "equilibrium: "), ("belt-oscillator", "steady sliding: ")]
)
def test_a_state_in_which_nothing_slides_is_not_called_sliding(model, where, capsys):
    assert main(["study", "stability", model, "--no-plot"]) == 0
    assert capsys.readouterr().out.startswith(where)
