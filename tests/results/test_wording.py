"""What a result says of itself fits a screen, names every field, and leaves nothing out in silence."""

from dataclasses import dataclass, fields

import numpy as np
import pytest

import nonsmooth as ns
from models import BeltOscillator, BouncingBall
from nonsmooth.results.wording import LINE, MOST_FIELDS, as_html, as_text, word
from nonsmooth.views import Worded

SCREEN = 20  # lines


@dataclass(frozen=True, repr=False)
class Many(Worded):
    values: np.ndarray
    parts: tuple
    name: str = "x"


def motion():
    ball = BouncingBall(e=0.5)
    return ns.simulate(ball, (0, 1), *ball.state(), integrator=ns.EventDriven())(np.linspace(0, 1, 300))


RESULTS = {
    "StateAt": motion,
    "LimitCycle": lambda: ns.limit_cycle(BeltOscillator()),
    "Linearisation": lambda: ns.linearise(BeltOscillator()),
    "Equilibrium": lambda: ns.equilibrium(BeltOscillator()),
    "LCPResult": lambda: ns.solve_lcp(3.0 * np.eye(300), -np.ones(300)),
    "ContactResult": lambda: ns.solve_contact(np.eye(300), -np.ones(300), 0.3 * np.ones(100), dim=3),
}


@pytest.mark.parametrize("kind", RESULTS)
def test_a_result_fits_a_screen_and_names_its_fields(kind):
    result = RESULTS[kind]()
    assert type(result).__name__ == kind
    text = repr(result)
    assert len(text.splitlines()) <= SCREEN and max(map(len, text.splitlines())) <= LINE
    names = result._fields if isinstance(result, tuple) else [f.name for f in fields(result) if f.repr]
    assert all(f"{name}=" in text for name in names)
    assert result._repr_html_().startswith("<table>") and text.count("=") >= len(names)


def test_a_bifurcation_diagram_of_many_maxima_fits_a_screen():
    maxima = tuple(np.arange(100.0) for _ in range(200))
    diagram = ns.BifurcationDiagram("vb", 0, np.linspace(0, 1, 200), maxima, maxima, np.zeros((2, 200), bool))
    assert len(repr(diagram).splitlines()) <= SCREEN and "upwards=200 of ndarray" in repr(diagram)


def test_an_array_says_its_range_and_how_much_of_it_is_not_finite():
    values = np.array([[np.nan, 2.0, -3.5, 4.0], [0.0, 1.0, np.inf, 1.0]])
    assert word(values) == "array 2 x 4 in [-3.5, 4], 2 not finite"
    assert word(np.array([[1.0, 2.0], [3.0, 4.5]])) == "[[1. , 2. ], [3. , 4.5]]"


def test_a_result_of_many_fields_counts_what_it_does_not_write():
    kind = type("Wide", (), {"_fields": tuple(f"field_{k}" for k in range(40)), "__getattr__": lambda *_: 1.0})
    lines = as_text(kind()).splitlines()
    assert len(lines) == MOST_FIELDS + 2 and "... and 25 more" in lines[-2]


def test_what_a_result_holds_is_no_markup_of_the_notebook():
    assert "<script>" not in as_html(Many(np.zeros(3), (), "<script>"))


def test_what_the_works_of_a_scene_leave_is_called_rounding_only_where_it_is():
    """A cube that is thrown and slides, and a plate that rolls on its rim: its moments are unlike, and steps err."""
    for shape, is_rounding in ((ns.Box(0.2, 0.2, 0.2), True), (ns.Box(0.4, 0.3, 0.02), False)):
        scene = ns.Scene(gravity=(0, 0, -9.81), material=ns.Material(mu=0.5))
        scene.fixed(ns.HalfSpace((0, 0, 1)))
        scene.body(shape, mass=1.0, position=(0, 0, 0.35), velocity=(1, 0, 0), spin=(3, 2, 1), name="thrown")
        solution = ns.simulate(scene, (0, 0.5), integrator=ns.MoreauJean(dt=1e-3))
        works = sum(solution.ledger[name][-1] for name in ("force", "friction", "normal", "surface"))
        kinetic = solution.ledger["kinetic"]
        rest = abs(kinetic[-1] - kinetic[0] - works)
        assert (rest < 1e-12) == is_rounding
        assert ("is rounding)" in solution.summary()) == is_rounding
        assert ("is the error of the steps, less with a smaller dt)" in solution.summary()) != is_rounding
