"""Units of parameters are read where a model says them: in the docstring of its class, or beside the field."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.mechanics.units import meaning_of_parameter, unit_of_parameter


class Spring(NamedTuple):
    k: float = 40.0  # stiffness [N/m]
    c: float = 0.3


class Cart(NamedTuple):
    m: np.ndarray = np.ones(2)  # masses [kg], of cart and box
    spring: Spring = Spring()
    mu: float = 0.5  # friction coefficient [-]
    F: float = 1.0  # of the drive
    w: "float" = 2.0  # [rad/s]


@dataclass
class Described:
    """Both.

    Parameters
    ----------
    a, b : float
        Lengths [m].
    c : float
        A ratio.
    e, f, g : float
        Three of which two have a unit: a force [N] and its arm [m].
    """

    a: float = 1.0  # [mm]: the docstring comes first
    b: float = 2.0
    c: float = 3.0
    d: float = 4.0  # speed [m/s]
    e: float = 5.0
    f: float = 6.0
    g: float = 7.0


@pytest.mark.parametrize(("model", "name", "unit"), [
    (Cart(), "m[0]", "kg"), (Cart(), "m", "kg"), (Cart(), "spring.k", "N/m"), (Cart(), "spring.c", ""),
    (Cart(), "mu", "-"), (Cart(), "F", ""), (Cart(), "w", "rad/s"), (Cart(), "absent", ""), (Cart(), "absent.k", ""),
    (Described(), "a", "m"), (Described(), "b", "m"), (Described(), "c", "-"), (Described(), "d", "m/s"),
    (Described(), "e", ""), (Described(), "g", ""), (None, "a", ""),
])  # fmt: skip
def test_a_unit_is_read_from_the_docstring_or_from_the_comment(model, name, unit):
    assert unit_of_parameter(model, name) == unit


@pytest.mark.parametrize(("model", "name", "meaning"), [
    (Cart(), "m", "masses, of cart and box"), (Cart(), "mu", "friction coefficient"),
    (Cart(), "w", ""), (Cart(), "absent", ""), (Described(), "a", "Lengths"), (Described(), "c", "A ratio"),
    (Described(), "f", "Three of which two have a unit: a force and its arm"),
])  # fmt: skip
def test_a_meaning_is_what_is_said_without_the_unit(model, name, meaning):
    assert meaning_of_parameter(model, name) == meaning


def test_a_class_without_a_source_has_no_units_but_those_of_its_docstring():
    made = type("Made", (), {"__doc__": "Text.\n\nParameters\n----------\nx : float\n    Way [m].\n"})
    assert unit_of_parameter(made(), "x") == "m" and unit_of_parameter(made(), "y") == ""


def test_the_unit_beside_a_field_reaches_the_axis_of_a_sweep():
    def mass(t, q, p, M):
        M[0, 0] = p.m[0]

    def force(t, q, u, p, h):
        h[0] = -p.spring.k * q[0]

    cart = ns.System(coordinates=[("x", "m")], mass=mass, force=force, parameters=Cart())
    task = ns.RunTask(cart, t_span=(0, 0.1), integrator=ns.MoreauJean(1e-2), state={"x": 1.0})
    found = ns.sweep(task, {"spring.k": [10.0, 20.0], "m[0]": [1.0, 2.0]}, progress=False)
    assert found["spring.k"].units == "N/m" and found["m[0]"].units == "kg"
