"""What stands in the figures of paradoxes."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest

import nonsmooth as ns
from models import BeltOscillator, BilateralRod, BilliardBall, FollowerForceArm, PainleveRod, SpragSlip, WallPendulum
from nonsmooth.drawing.paradox_plots import plot_graphical_problem, plot_map
from tests.drawing.looks import faults


def texts(figure):
    """All texts of the first axes and of its legend."""
    axes = figure.axes[0]
    legend = [text.get_text() for text in axes.get_legend().get_texts()] if axes.get_legend() else []
    return [text.get_text() for text in axes.texts], legend


def test_map_hatches_and_names_its_regions_and_draws_curves_and_motions():
    rod = SpragSlip()
    axes = {"th": np.linspace(0.65, 1.25, 61), "thdot": np.linspace(-4.5, 4.5, 61)}
    chart = ns.paradox_map(rod, **axes)
    motion = np.array([[0.8, 0.0], [0.9, 1.0], [1.0, 0.5]])
    figure = plot_map(chart, boundaries=ns.paradox_boundaries(rod, **axes), motions=[motion])
    labels, legend = texts(figure)
    assert sorted(labels) == ["0", "0", "1", "2", "2"]  # A0 is one piece here
    for entry in ("inconsistent", "regular", "indeterminate", "$p = 0$", "$b = 0$", "\\gamma_F", "Génot", "motion"):
        assert any(entry in text for text in legend), entry
    drawn = [line.get_xydata() for line in figure.axes[0].lines]
    assert any(line.shape == motion.shape and np.array_equal(line, motion) for line in drawn)
    hatches = {hatch for area in figure.axes[0].collections for hatch in (getattr(area, "hatches", None) or [])}
    assert {"//", ".."} <= hatches
    assert figure.axes[0].get_xlabel() == "θ [rad]" and "rad/s" in figure.axes[0].get_ylabel()


def test_the_data_of_a_sweep_are_no_map_of_paradoxes():
    task = ns.RunTask(PainleveRod(), "paradoxes", t_span=(0, 0.01), integrator=ns.MoreauJean(1e-3))
    found = ns.sweep(task, {"mu": [0.1, 0.2], "th": [0.5, 0.6]}, progress=False)
    with pytest.raises(ns.InvalidInput, match=r"Dataset of ns.paradox_map.*'paradoxes'.*ns.plot_sweep draws a sweep"):
        plot_map(found)


def test_named_regions_take_the_names_given():
    rod = SpragSlip()
    axes = {"th": np.linspace(0.65, 1.25, 61), "thdot": np.linspace(-4.5, 4.5, 61)}
    code = rod.region(*np.meshgrid(*axes.values(), indexing="ij"))
    labels, _ = texts(plot_map(ns.paradox_map(rod, **axes), regions=(code, lambda k: f"A{k}")))
    assert sorted(labels) == ["A0", "A1", "A2", "A3", "A4"]


def test_states_without_a_problem_of_forces_get_no_number_of_solutions():
    """A pendulum at a wall is free at angles above 0, and in the wall below, where no force is looked for."""
    chart = ns.paradox_map(WallPendulum(), th=np.linspace(-1.0, 1.0, 21), m=np.linspace(1.0, 2.0, 5))
    labels, legend = texts(plot_map(chart))
    assert labels == ["1"] and legend == ["regular: one solution", "inadmissible: penetrates or lands"]


def test_one_axis_shows_the_force_of_every_solution():
    chart = ns.paradox_map(PainleveRod(mu=2.0), th=np.linspace(0.0, 1.57, 50), thdot=5.0)
    axes = plot_map(chart).axes[0]
    shown = np.concatenate([line.get_ydata() for line in axes.lines])
    expected = chart.la_N.values
    assert np.isfinite(shown).sum() == np.isfinite(expected).sum() == int(chart.n_solutions.sum())


def test_more_than_two_axes_are_refused_with_the_cure():
    chart = ns.paradox_map(PainleveRod(), th=[0.1, 0.2], mu=[0.5, 1.0], thdot=[0.0, 1.0])
    with pytest.raises(ns.InvalidInput, match="isel"):
        plot_map(chart)
    assert plot_map(chart.isel(mu=0)) is not None


def test_solutions_lie_where_the_line_meets_the_corner():
    for mu, thdot, number in [(0.5, 0.0, 1), (0.5, 6.0, 1), (2.0, 6.0, 2), (2.0, 0.0, 0)]:
        rod = PainleveRod(mu=mu)
        figure = plot_graphical_problem(ns.classify(rod, 0.0, *rod.state(th=math.pi / 3, thdot=thdot)))
        lines = {line.get_label(): line.get_xydata() for line in figure.axes[0].lines}
        points = lines["solutions"]
        assert len(points) == number
        (x_0, y_0), (x_1, y_1) = next(xy for label, xy in lines.items() if "p\\," in label)
        for x, y in points:
            assert x * y == 0 and x >= 0 and y >= 0  # on the corner
            assert y_0 + (y_1 - y_0) * (x - x_0) / (x_1 - x_0) == pytest.approx(y, abs=1e-12 * 100)  # and on the line


def test_solutions_of_a_bilateral_contact_lie_on_the_axis_at_forces_of_either_sign():
    rod = BilateralRod()
    case = ns.classify(rod, 0.0, *rod.state())
    figure = plot_graphical_problem(case)
    lines = {line.get_label(): line.get_xydata() for line in figure.axes[0].lines}
    points = lines["solutions"]
    assert points[:, 1].tolist() == [0.0, 0.0] and points[:, 0].min() < 0 < points[:, 0].max()
    assert sorted(points[:, 0]) == sorted(solution.la_N[0] for solution in case.solutions)
    bent = next(xy for label, xy in lines.items() if "p\\," in label)
    for x, _ in points:  # the force of friction changes its sign with la_N, and so the slope of the line
        assert np.interp(x, *bent.T) == pytest.approx(0.0, abs=1e-9)
    assert not any("perp" in str(label) for label in lines)


def test_a_closed_contact_without_friction_is_drawn_with_its_one_line():
    beads = WallPendulum()
    figure = plot_graphical_problem(ns.classify(beads, 0.0, *beads.state(th=0.0, thdot=0.0)))
    (point,) = {line.get_label(): line.get_xydata() for line in figure.axes[0].lines}["solutions"]
    assert point.tolist() == [0.0, 0.0]


def test_states_without_a_graphical_problem_are_refused_with_the_reason():
    for model, words in ((FollowerForceArm(), "needs a contact"), (BeltOscillator(), "is given")):
        with pytest.raises(ns.InvalidInput, match=words):
            plot_graphical_problem(ns.classify(model, 0.0, *model.state()))


def rods_on_the_ground(turning):
    """Rods that slide at -1 m/s under 60 degrees with mu = 2, one for each rate of turning: each two solutions or none.

    p = (1 + 3 cos th (cos th - mu sin th))/m < 0 of a thin rod (Génot, Brogliato 1999), and b = l/2 thdot^2 sin th - g.
    """
    made = ns.Scene(gravity=(0, -9.81))
    made.fixed(ns.HalfPlane((0, 1)), name="ground", material=ns.Material(mu=2.0))
    th, half = math.pi / 3, 0.5
    centre = half * np.array([math.cos(th), math.sin(th)])
    for k, spin in enumerate(turning):
        made.body(ns.Polygon([(-half, 0), (0, -1e-3), (half, 0), (0, 1e-3)]), mass=1.0, material=ns.Material(mu=2.0),
                  position=(2 * k + centre[0], centre[1]), turn=th, spin=spin,
                  velocity=(-1 - spin * centre[1], spin * centre[0]), name=f"rod {k}")  # fmt: skip
    system = made.system(pairs=[(f"rod {k}", "ground") for k in range(len(turning))])
    return ns.classify(system, 0.0, *made.state())


def drawn_points(axes):
    """Forces of the solutions on an axis of a cone, in their order."""
    lines = [line for line in axes.lines if line.get_marker() not in ("None", "")]
    return np.array([line.get_xydata()[0] for line in lines]).reshape(-1, 2)


@pytest.mark.upkeep
def test_a_state_of_several_contacts_is_drawn_as_forces_in_their_cones():
    case = rods_on_the_ground([6.0, 6.0])
    figure = case.plot(title="two rods")
    first, second = figure.axes
    assert case.n_solutions == 4 and "two rods\nindeterminate: 4 sets of forces" in figure.get_suptitle()
    for axes, i in ((first, 0), (second, 4)):
        np.testing.assert_array_equal(drawn_points(axes), [(s.la_F[i], s.la_N[i]) for s in case.solutions])
        (cone,) = axes.patches
        (x_0, y_0), *_ = cone.get_xy()[1:2]
        assert x_0 == pytest.approx(-2.0 * y_0) and axes.get_xlabel() == "$\\lambda_F$ [N]"
    named = [text.get_text() for text in figure.legends[0].get_texts()]
    assert {"1: free, free", "4: slide -, slide -"} <= set(named) and faults(figure) == []


def test_a_state_without_forces_shows_its_cones_and_says_so():
    figure = rods_on_the_ground([6.0, 0.0]).plot()
    assert "inconsistent: no forces fit" in figure.get_suptitle() and not len(drawn_points(figure.axes[0]))


@pytest.mark.upkeep
def test_of_many_contacts_and_solutions_the_first_have_names():
    figure = rods_on_the_ground([6.0] * 7).plot()
    assert "6 of 7 closed contacts" in figure.get_suptitle() and "128 sets" in figure.get_suptitle()
    assert len(drawn_points(figure.axes[0])) == 128
    assert figure.legends[0].get_texts()[-1].get_text() == "120 others"


def test_a_contact_that_rests_lies_within_its_cone_and_one_that_slides_in_space_on_it():
    rod = PainleveRod(mu=2.0)
    (axes,) = ns.classify(rod, state=dict(slip=0.0, thdot=0.0)).plot().axes
    ((x, y),) = drawn_points(axes)
    assert abs(x) < 2.0 * y
    ball = BilliardBall()
    (axes,) = ns.classify(ball, 0.0, *ball.state()).plot().axes
    ((x, y),) = drawn_points(axes)
    assert x == pytest.approx(ball.mu * y, rel=1e-12) and "lambda_T|" in axes.get_xlabel()


def test_a_contact_alone_that_slides_is_drawn_as_a_line_and_a_corner(tmp_path):
    rod = PainleveRod(mu=2.0)
    figure = ns.classify(rod, state=dict(thdot=6.0)).plot(tmp_path / "rod.png", "a rod")
    assert figure.axes[0].get_title() == "a rod" and "gamma" in figure.axes[0].get_ylabel()
    assert (tmp_path / "rod.png").stat().st_size > 0
    arm = FollowerForceArm()
    assert "no contact is closed" in ns.classify(arm, 0.0, *arm.state()).plot().axes[0].texts[0].get_text()


@pytest.mark.upkeep
def test_a_copy_of_a_classification_in_another_process_is_drawn_too():
    case = pickle.loads(pickle.dumps(rods_on_the_ground([6.0])))
    assert case.plot().axes[0].get_xlabel() == "$\\lambda_N$ [N]"


def test_no_letter_stands_over_another_in_figures_of_paradoxes():
    rod = SpragSlip()
    axes = {"th": np.linspace(0.65, 1.25, 41), "thdot": np.linspace(-4.5, 4.5, 41)}
    assert faults(plot_map(ns.paradox_map(rod, **axes), boundaries=ns.paradox_boundaries(rod, **axes))) == []
    assert faults(plot_map(ns.paradox_map(PainleveRod(mu=2.0), th=np.linspace(0.0, 1.57, 50), thdot=5.0))) == []
    rod = BilateralRod()
    case = ns.classify(rod, 0.0, *rod.state())
    assert faults(plot_graphical_problem(case)) == [] == faults(plot_graphical_problem([("", case)] * 3))


def test_a_title_that_is_longer_than_the_figure_is_broken_and_no_formula_with_it():
    chart = ns.paradox_map(PainleveRod(mu=2.0), th=np.linspace(0.0, 1.57, 20), thdot=np.linspace(0.0, 8.0, 20))
    formula = "$\\mu = 1.4$"
    figure = plot_map(
        chart,
        title=f"Painlev\u00e9's rod, sliding motions of a slender rod whose friction is {formula}: until\nit sticks",
    )
    assert faults(figure) == []
    rows = figure.get_suptitle().split("\n")
    assert len(rows) == 3 and rows[-1] == "it sticks" and any(formula in row for row in rows)
