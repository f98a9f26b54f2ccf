"""A user's own system: its names and units reach results, messages and figures; p has arrays and parts."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from tests.mechanics import wall_pendulum
from tests.mechanics.wall_pendulum import P, Spring, system

STEP = ns.MoreauJean(dt=1e-3)


@pytest.fixture(scope="module")
def swing():
    return ns.simulate(system(), (0, 1), state={"th": -0.8, "x": 0.1}, integrator=STEP)


def test_columns_have_the_names_of_coordinates_and_rates(swing):
    assert np.array_equal(swing["th"], swing.q[:, 0]) and np.array_equal(swing["xdot"], swing.u[:, 1])
    with pytest.raises(ns.UnknownName, match="known: th, thdot, x, xdot"):
        swing["phi"]


def test_contact_is_called_by_its_name(swing):
    assert "  wall  open     -> closed    impact" in swing.summary()
    assert ns.simulate(system(), (0, 1), state={"th": -0.8}, integrator=STEP).described.contact("wall") == 0


def test_system_without_names_counts_its_coordinates():
    bare = ns.simulate(system(coordinates=(), n_q=2), (0, 0.01), [0.1, 0], [0, 0], integrator=STEP)
    assert np.array_equal(bare["q[1]"], bare.q[:, 1]) and bare.system.described.rates[0] == ("u[0]", "")


def test_figures_have_names_and_units(swing):
    figure = swing.plot()
    labels = [axes.get_ylabel().replace("\n", " ") for axes in figure.axes]
    assert {"θ [rad]", "x [m]", "θ' [rad/s]", "x' [m/s]", "mode of wall"} <= set(labels)


def test_picture_is_drawn_from_the_shape_that_was_given(swing):
    lines = swing.picture(n=2).axes[0].lines
    assert any(np.allclose(line.get_xdata(), [0.2, 0.2]) for line in lines)
    tip = [0.0, 0.5 * math.sin(swing["th"][-1])]
    assert any(np.allclose(line.get_xdata(), tip) for line in lines)


def test_picture_follows_changed_parameters():
    longer = system().with_parameters(l=1.0)
    assert longer.described.shape(np.array([math.pi / 2, 0.0]))[0][1, 0] == pytest.approx(1.0)


def test_numbers_within_parameters_have_names_and_reach_the_functions():
    changed = system().with_parameters(**{"m[1]": 5.0, "spring.k": 7.0, "l": 2.0})
    values = {"m[0]": 1.0, "m[1]": 5.0, "l": 2.0, "wall": 0.2, "spring.k": 7.0, "spring.c": 0.5}
    assert changed.parameter_values == values
    assert changed.evaluate(0, 0.0, np.zeros(2), np.zeros(2))[1, 1] == 5.0
    assert changed.evaluate(1, 0.0, np.ones(2), np.zeros(2))[1] == -7.0
    whole = system().with_parameters(m=[3.0, 4.0], spring=Spring(1.0, 2.0)).parameter_values
    assert (whole["m[0]"], whole["spring.c"]) == (3.0, 2.0)


@pytest.mark.parametrize(
    "changes, words",
    [
        ({"m": [1.0]}, "the parameter m must have the shape"),
        ({"m[2]": 1.0}, r"there is no parameter 'm\[2\]'"),
        ({"spring.q": 1.0}, "there is no parameter 'spring.q'"),
        ({"spring": 3.0}, "the parameter spring must be a Spring"),
        ({"spring.k": "stiff"}, "the parameter spring.k must be a number"),
    ],
)
def test_what_is_no_number_of_the_parameters_is_refused(changes, words):
    with pytest.raises(ns.InvalidInput, match=words):
        system().with_parameters(**changes)


def test_machine_code_and_interpreter_see_the_same_parameters(swing, monkeypatch):
    monkeypatch.setenv("NONSMOOTH_INTERPRET", "1")
    slow = ns.simulate(system(), (0, 1), state={"th": -0.8, "x": 0.1}, integrator=STEP)
    assert np.array_equal(slow.q, swing.q) and np.array_equal(slow.u, swing.u)


def test_functions_cannot_write_into_parameters(monkeypatch):
    monkeypatch.setenv("NONSMOOTH_INTERPRET", "1")

    def writes(t, q, u, p, h):
        p.m[0] = 2.0

    spoilt = ns.System(n_q=2, mass=mass_of, force=writes, parameters=P())
    with pytest.raises(ns.InvalidInput, match="force"):
        ns.simulate(spoilt, (0, 0.1), [0, 0], [0, 0], integrator=STEP)


def force_of(t, q, u, p, h):
    h[0] = 1.0


def mass_of(t, q, p, M):
    M[0, 0] = M[1, 1] = 1.0


@pytest.mark.parametrize(
    "options, words",
    [
        ({"coordinates": []}, "a system needs its coordinates"),
        ({"coordinates": "th"}, "coordinates must be a list"),
        ({"coordinates": [("th", "rad")], "n_q": 2}, "coordinates must have 2 entries"),
        ({"coordinates": [("th", "rad"), ("th", "rad")]}, "named twice"),
        ({"coordinates": [("th", 1), "x"]}, "a coordinate is a name with its unit"),
        ({"shape": lambda: 0}, r"shape must be a function shape\(q, p\) or shape\(q\)"),
        ({"outline": lambda a, b: 0}, r"outline must be a function outline\(p\) or outline\(\)"),
    ],
)
def test_descriptions_that_cannot_be_are_refused(options, words):
    given: dict = {
        "coordinates": [("th", "rad"), ("x", "m")],
        "parameters": P(),
        "mass": mass_of,
        "force": force_of,
    } | options
    with pytest.raises(ns.InvalidInput, match=words):
        ns.System(**given)


def test_names_of_contacts_stand_in_what_classify_says_and_refuses():
    from tests.systems import block

    named = block(ns.Contact(mu=0.3, name="tip"))
    said = str(ns.classify(named, 0.0, [0.0, 0.0], [1.0, 0.0]))
    assert "  tip: sliding +" in said and "contact 0" not in said
    with pytest.raises(ns.InvalidInput, match="tip approaches with gamma_N = -1 m/s"):
        ns.classify(named, 0.0, [0.0, 0.0], [0.0, -1.0])
    with pytest.raises(ns.InvalidInput, match="tip penetrates by 0.1 m"):
        ns.classify(named, 0.0, [0.0, -0.1], [0.0, 0.0])
    assert "  contact 0: sliding +" in str(ns.classify(block(), 0.0, [0.0, 0.0], [1.0, 0.0]))


def test_a_system_without_a_name_is_called_as_its_variable_or_not_at_all(monkeypatch):
    """That of the module of its functions; where there is none, or several, nothing is said."""
    unnamed = system(name="")
    start = {"state": {"th": -0.8}, "integrator": STEP}
    assert ns.simulate(unnamed, (0, 0.01), **start).plot().get_suptitle().startswith("MoreauJean(")
    assert ns.simulate(unnamed, (0, 0.01), **start).summary().startswith("system: ")
    monkeypatch.setattr(wall_pendulum, "swinging", unnamed, raising=False)
    longer = ns.simulate(unnamed.with_parameters(l=0.7), (0, 0.01), **start)
    assert longer.plot().get_suptitle().startswith("swinging\n") and longer.summary().startswith("swinging: ")
    monkeypatch.setattr(wall_pendulum, "other", unnamed.with_parameters(l=0.7), raising=False)
    assert ns.simulate(unnamed, (0, 0.01), **start).summary().startswith("system: ")


def test_a_class_of_models_without_a_name_has_that_of_the_class():
    class Whole(P):
        def system(self):
            return system(name="", parameters=self)

    assert ns.simulate(Whole(), (0, 0.01), state={"th": -0.8}, integrator=STEP).summary().startswith("Whole: ")
