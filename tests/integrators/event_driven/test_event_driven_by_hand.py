"""Scenes without closed form: events end at the positions of DOP853 (order 8) with events written by hand, to 1e-11.

The adapters in benchmarks/adapters share nothing with the package: reduced equations (Housner's block, the rod on its
constraint, one coordinate on the belt), forces from a linear system of the modes that are written down, event location
on the dense output of SciPy, Newton's impacts by hand. Their tolerance of 3e-14 a step leaves some 1e-12 at the end.
"""

import numpy as np
import pytest

import nonsmooth as ns
from benchmarks import accuracy, peers
from nonsmooth.studies.comparison import as_problem

SCENES = accuracy.scenes()
BY_HAND = peers.adapter("scipy_motions").SCENES
RTOL, FINEST = 1e-11, 3e-14
SPANS = {  # s; events in it
    "rod, slip and stick": 0.3,  # 2
    "belt, stick-slip": 14.0,  # 8
    "rocking block": 3.0,  # 22
    "pendulum against a wall": 5.0,  # 5
    "sprag-slip, limit cycle": 3.0,  # 10
    "sprag-slip, seizures": 3.0,  # 14, of them 7 impacts without collision
    "slider-crank": 0.036,  # 49: two corners in turn until both rest, then both together, a reversal, lift-off
    "woodpecker": 0.3,  # 18
}


@pytest.mark.filterwarnings("ignore::nonsmooth.SimultaneousImpactWarning")  # what is asked holds for it too
@pytest.mark.parametrize("name", SPANS)
def test_events_end_where_the_pieces_by_hand_end(name):
    """To the tolerance, relative to the largest position: the largest measured is 4e-12, of the belt."""
    scene = SCENES[name]
    t = np.linspace(0.0, SPANS[name], 17)[1:]
    problem = as_problem(scene.system, (0.0, SPANS[name]), scene.q0, scene.u0, t)
    by_hand, *_ = BY_HAND[name](problem, problem.model, FINEST)
    q = problem.run(ns.EventDriven(RTOL, 1e-2 * RTOL), t).q[-len(t) :]
    error = np.linalg.norm(q - by_hand, axis=1).max() / np.linalg.norm(by_hand, axis=1).max()
    assert error < RTOL


def test_every_scene_has_a_closed_form_or_pieces_by_hand():
    assert {name for name, scene in SCENES.items() if not callable(scene.reference)} == set(SPANS)


def test_bead_chain_ends_where_its_impacts_one_by_one_end():
    """Impacts only: every error is rounding, which 200 impacts of the scene add up."""
    scene = SCENES["bead chain"]
    problem = as_problem(scene.system, scene.t_span, scene.q0, scene.u0, scene.times)
    q = problem.run(ns.EventDriven(RTOL, 1e-2 * RTOL), problem.times).q[-len(problem.times) :]
    exact = np.array([scene.reference(t) for t in problem.times])
    assert np.abs(q - exact).max() < 1e-12 * np.abs(exact).max()
