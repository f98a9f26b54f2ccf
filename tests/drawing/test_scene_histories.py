"""The figure of a run of a scene answers what was run, how it moved and how well its contacts were solved."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.catalogue.entries import load, scene_entries
from nonsmooth.checks.parameters import numeric_fields
from nonsmooth.drawing.colours import ENERGIES
from nonsmooth.drawing.labels import spelt
from tests.drawing.looks import faults, labels

STEPS = 10


def short_run(name):
    made = load(name)()
    return ns.simulate(made, (0.0, STEPS * made.dt), integrator=ns.MoreauJean(made.dt), progress=False)


def panel(figure, words):
    """The axes whose label has these words."""
    parts = [figure, *figure.subfigs]
    (axes,) = {a for part in parts for a in part.axes if words in a.get_ylabel()}
    return axes


def curves(axes):
    return {line.get_label(): line for line in axes.lines}


@pytest.fixture(scope="module")
def thrown():
    """A disc that flies, falls for 0.2 s and slides."""
    scene = ns.Scene(gravity=(0, -9.81))
    scene.fixed(ns.HalfPlane((0, 1)), material=ns.Material(mu=0.3))
    scene.body(ns.Disc(0.1), density=100, position=(0, 0.3), velocity=(1, 0), name="disc")
    return ns.simulate(scene, (0, 0.4), integrator=ns.MoreauJean(dt=1e-3))


@pytest.mark.upkeep
@pytest.mark.parametrize("name", sorted(scene_entries()))
def test_no_letter_of_a_run_stands_outside_or_over_another_and_every_axis_has_a_unit(name):
    assert faults(short_run(name).plot()) == []


def test_the_figure_names_the_scene_and_shows_its_start_and_its_end(thrown):
    figure = thrown.plot()
    assert figure.get_suptitle() == "planar, 2 bodies, 1 of them dynamic\nMoreauJean(dt=0.001, theta=0.5)\ng = 9.81"
    assert [axes.get_title() for axes in figure.subfigs[0].axes] == ["t = 0 s", "t = 0.4 s"]


def test_the_title_has_the_parameters_of_what_built_the_scene_and_so_has_its_file(tmp_path):
    run = short_run("rolling-wheel")
    held = numeric_fields(load("rolling-wheel")())
    assert held
    for solution in (run, ns.SceneSolution.load(run.save(tmp_path / "run.npz"))):
        title = solution.plot().get_suptitle()
        assert all(f"{spelt(name)} = {value:.4g}" in title for name, value in held.items())


def test_a_scene_of_one_material_says_its_friction_and_one_of_several_does_not(thrown):
    floor = ns.Scene(gravity=(0, -9.81), material=ns.Material(mu=0.25, e=0.5))
    floor.fixed(ns.HalfPlane((0, 1)))
    assert floor.parameter_values == {"g": 9.81, "mu": 0.25, "e": 0.5}
    assert thrown.scene.parameter_values == {"g": 9.81}


@pytest.mark.upkeep
def test_a_curve_is_the_speed_of_the_body_and_a_colour_means_what_it_means_of_models(thrown):
    figure = thrown.plot()
    (line,) = panel(figure, "speed").lines
    assert line.get_label() == "disc"
    np.testing.assert_allclose(line.get_ydata(), np.hypot(*thrown["disc"].velocity.T), rtol=1e-14)
    energies = curves(panel(figure, "energy"))
    assert energies["kinetic energy"].get_color() == ENERGIES["kinetic"][0]
    assert energies["work: friction"].get_color() == ENERGIES["friction"][0]


def test_contacts_are_counted_where_they_carry_and_where_they_are_near(thrown):
    """None before the ground is reached after sqrt(2 h/g) = 0.2 s, one since then; the record before the first step,
    which looked for none, is left out."""
    lines = curves(panel(thrown.plot(), "contacts"))
    t, loaded = lines["loaded"].get_data()
    assert t[0] == thrown.t[1]
    landed = np.sqrt(2 * 0.2 / 9.81)
    assert loaded[t < landed - 2e-3].max() == 0 and loaded[t > landed + 2e-3].min() == 1
    assert (lines["near"].get_ydata() >= loaded).all()


def test_a_stack_at_rest_is_drawn_at_rest():
    """Energies change by 1e-29 J of 785 J, speeds by 1e-16 m/s: rounding, and no motion to zoom into."""
    figure = short_run("box-stack").plot()
    assert "no energy changes" in {text.get_text() for text in panel(figure, "energy").texts}.pop()
    for words, least in (("speed", 0.1), ("rotation", 0.1)):
        low, high = panel(figure, words).get_ylim()
        assert high - low > least


def test_of_many_bodies_the_fastest_and_the_middle_one_are_drawn():
    sol = short_run("domino-row")
    lines = curves(panel(sol.plot(), "speed"))
    speeds = np.linalg.norm(sol.velocity[:, 1:], axis=2)
    np.testing.assert_array_equal(lines["fastest of 40"].get_ydata(), speeds.max(axis=1))
    np.testing.assert_allclose(lines["middle of 40"].get_ydata(), np.median(speeds, axis=1), atol=1e-15)


def test_compliant_contacts_have_energies_of_springs_and_no_residual(thrown):
    sol = ns.simulate(thrown.scene, (0, 0.3), integrator=ns.Penalty(stiffness=1e7, damping_ratio=0.1))
    figure = sol.plot()
    assert {"elastic energy", "work: damping"} <= set(curves(panel(figure, "energy")))
    assert not any("residual" in label for label in labels(figure)) and faults(figure) == []


def test_a_run_that_was_loaded_without_its_scene_or_recorded_in_part_is_drawn(thrown, tmp_path):
    thrown.save(tmp_path / "run.npz")
    loaded = ns.SceneSolution.load(tmp_path / "run.npz").plot()
    assert loaded.subfigs == [] and panel(loaded, "speed")
    for record in ("bodies", "ledger"):
        part = ns.simulate(thrown.scene, (0, 0.01), integrator=ns.MoreauJean(1e-3), record=record)
        assert faults(part.plot()) == []
    nothing = ns.simulate(thrown.scene, (0, 0.01), integrator=ns.MoreauJean(1e-3), record="contacts")
    with pytest.raises(ns.InvalidInput, match="record"):
        nothing.plot()
