"""A start is said in one way everywhere: a pair, or a dictionary; other words are answered by the right form."""

import re

import numpy as np
import pytest

import nonsmooth as ns
from models import BouncingBall
from tests.mechanics.wall_pendulum import system

STEP = ns.MoreauJean(dt=1e-3)
PAIR = ([-0.8, 0.1], [0.0, 0.2])
FORMS = [
    PAIR,
    {"q0": PAIR[0], "u0": PAIR[1]},
    {"th": -0.8, "x": 0.1, "xdot": 0.2},
    {"q0[0]": -0.8, "q0[1]": 0.1, "u0[1]": 0.2},
    {"q[0]": -0.8, "q[1]": 0.1, "u[1]": 0.2},
    {"th": -0.8, "q0[1]": 0.1, "u0[1]": 0.2},
]


@pytest.mark.parametrize("start", FORMS, ids=map(str, range(len(FORMS))))
def test_every_form_of_a_start_is_the_same_motion(start):
    bare = system()
    asked = ns.simulate(bare, (0, 0.1), *PAIR, integrator=STEP)
    assert np.array_equal(ns.simulate(bare, (0, 0.1), state=start, integrator=STEP).q, asked.q)
    task = ns.RunTask(bare, "final_state", t_span=(0, 0.1), integrator=STEP, state=start)
    swept = ns.sweep(task, {"spring.c": [0.5]}, progress=False)
    assert np.array_equal(swept.q.values[0], asked.q[-1])


def test_axes_of_a_system_without_state_are_its_coordinates():
    task = ns.RunTask(system(), "final_state", t_span=(0, 0.1), integrator=STEP, state=PAIR)
    swept = ns.sweep(task, {"th": [-0.5], "xdot": [0.3]}, progress=False)
    asked = ns.simulate(system(), (0, 0.1), [-0.5, 0.1], [0.0, 0.3], integrator=STEP)
    assert np.array_equal(swept.q.values[0, 0], asked.q[-1]) and swept.th.attrs["units"] == "rad"


def test_maps_take_a_state_to_start_from():
    chart = ns.paradox_map(system(), state={"th": 0.1}, x=[0.0, 0.1], progress=False)
    pair = ns.paradox_map(system(), state=([0.1, 0.0], [0.0, 0.0]), x=[0.0, 0.1], progress=False)
    assert np.array_equal(chart.kind, pair.kind) and chart.attrs["th"] == 0.1


CALLS = {
    "simulate": lambda **start: ns.simulate(system(), (0, 1), integrator=STEP, **start),
    "RunTask": lambda **start: ns.RunTask(system(), t_span=(0, 1), integrator=STEP, **start),
    "limit_cycle": lambda **start: ns.limit_cycle(system(), duration=1.0, **start),
    "bifurcation_diagram": lambda **start: ns.bifurcation_diagram(system(), "l", [0.5], duration=1.0, dt=1e-3, **start),
    "paradox_map": lambda **start: ns.paradox_map(system(), th=[0.0], **start),
    "penalty_study": lambda **start: ns.penalty_study(system(), (0, 1), **start),
    "convergence_study": lambda **start: ns.convergence_study(system(), (0, 1), **start),
}


@pytest.mark.parametrize("name", CALLS)
def test_another_word_for_the_start_is_answered_by_the_right_one(name):
    with pytest.raises(
        ns.InvalidInput, match=rf"{name} takes no x0=; its start is state=\(q0, u0\) or dict\(th=..., x"
    ):
        CALLS[name](x0=[0, 0])


@pytest.mark.parametrize("name", CALLS)
def test_unknown_variable_of_the_start_is_named(name):
    with pytest.raises(ns.UnknownName, match="'thet'"):
        CALLS[name](state={"thet": 1.0})


@pytest.mark.parametrize("name", [name for name in CALLS if name != "paradox_map"])
def test_without_a_start_the_forms_are_named(name):
    with pytest.raises(ns.InvalidInput, match=r"state=\(q0, u0\) or dict\(th=..., x=...\)"):
        CALLS[name]()


def test_start_of_a_model_within_a_system_follows_the_swept_parameter():
    from models import SpragSlip

    rod = SpragSlip()
    task = ns.RunTask(rod.system(), "final_state", t_span=(0, 0.01), integrator=ns.MoreauJean(1e-4), state={"th": 0.9})
    swept = ns.sweep(task, {"l": [4.0, 5.0]}, progress=False)
    asked = ns.simulate(SpragSlip(l=4.0), (0, 0.01), state={"th": 0.9}, integrator=ns.MoreauJean(1e-4))
    assert np.array_equal(swept.q.values[0], asked.q[-1])


@pytest.mark.parametrize(("given", "missing"), [("q0", "u0"), ("u0", "q0")])
def test_half_a_start_is_answered_by_the_whole_one(given, missing):
    ball = BouncingBall()
    with pytest.raises(ns.InvalidInput, match=f"the start has {given} and no {missing}; give both, or state="):
        ns.simulate(ball, (0, 0.1), integrator=ns.MoreauJean(dt=1e-3), **{given: [0.5]})


def test_a_variable_of_the_state_beside_it_is_answered_by_the_form():
    with pytest.raises(ns.InvalidInput, match=r"simulate takes no th=; its start is state=dict\(th=...\)"):
        ns.simulate(system(), (0, 1), integrator=STEP, th=0.1)
    with pytest.raises(TypeError, match="unexpected keyword argument 'speed'"):
        ns.simulate(system(), (0, 1), integrator=STEP, speed=0.1)


def test_a_wrong_start_is_named_as_it_was_given():
    with pytest.raises(ns.InvalidInput, match=r"state\[0\] must have 2 entries; got 1"):
        ns.limit_cycle(system(), state=([0.1], [0.0]), duration=1.0)
    with pytest.raises(ns.InvalidInput, match=r"guess\[0\] must have 2 entries; got 1"):
        ns.limit_cycle(system(), ([0.1], [0.0]), duration=1.0)


@pytest.mark.parametrize(("word", "integrator"), [("dt", "ns.MoreauJean(dt=...)"), ("rtol", "ns.Adaptive(rtol=...)")])
def test_an_option_of_an_integrator_is_answered_by_the_integrator_that_has_it(word, integrator):
    for call in (ns.simulate, lambda model, _, **options: ns.RunTask(model, **options)):
        with pytest.raises(ns.InvalidInput, match=re.escape(f"takes no {word}=; give integrator={integrator}")):
            call(BouncingBall(), (0, 1), **{word: 1e-3})
