"""Sweeps over scenes: a closed form at every cell, and what journals and workers promise."""

import signal

import numpy as np
import pytest

import nonsmooth as ns
from models.scenes import BlockOnIncline

g, SPEED = 9.81, 1.0
STEP = ns.MoreauJean(dt=1e-3)


def pushed(mu, speed=SPEED):
    """A box that slides until friction has taken its energy."""
    scene = ns.Scene(gravity=(0, -g), material=ns.Material(mu=mu))
    scene.fixed(ns.HalfPlane((0, 1)))
    scene.body(ns.Box(0.2, 0.02), mass=1.0, position=(0, 0.01), velocity=(speed, 0), name="box")
    return scene


def way(sol):
    """How far it went [m]."""
    return sol["box"].position[-1, 0]


def energies(sol):
    """Energy at the start, and what friction took [J]."""
    return {"start": sol.ledger["kinetic"][0], "lost": -sol.ledger["friction"][-1]}


def task(**options):
    return ns.SceneTask(pushed, [way, energies], **{"t_span": (0, 0.6), "integrator": STEP, **options})


def test_a_box_slides_as_far_as_friction_lets_it_at_every_coefficient():
    """v^2/(2 mu g); the step in which it stops has a way of mu g dt^2/2 at most that is not known."""
    mu, speed = np.array([0.25, 0.3, 0.5, 0.7]), np.array([0.5, 1.0])
    found = ns.sweep(task(), {"mu": mu, "speed": speed})
    exact = speed[None, :] ** 2 / (2 * mu[:, None] * g)
    assert (np.abs(found.way.values - exact) < 0.5 * mu[:, None] * g * STEP.dt**2 + 1e-12).all()
    np.testing.assert_allclose(found.lost, found.start, rtol=1e-12)
    assert (found.status == int(ns.Status.FINISHED)).all()


@pytest.mark.upkeep
def test_workers_and_a_resumed_journal_give_the_same_values(tmp_path):
    axes = {"mu": [0.3, 0.4, 0.5, 0.6]}
    alone = ns.sweep(task(), axes)
    first = ns.sweep(task(), axes, workers=2, journal=tmp_path / "sweep.jsonl", progress=False)
    again = ns.sweep(task(), axes, journal=tmp_path / "sweep.jsonl", progress=False)
    for found in (first, again):
        np.testing.assert_array_equal(found.way, alone.way)
    with pytest.raises(ns.InvalidInput, match="journal"):
        ns.sweep(task(t_span=(0, 0.5)), axes, journal=tmp_path / "sweep.jsonl", progress=False)


def test_a_cell_that_builds_no_scene_or_whose_run_fails_has_its_status_and_no_value():
    def built(mu):
        return pushed(mu) if mu < 0.5 else None

    found = ns.sweep(ns.SceneTask(built, way, t_span=(0, 0.1), integrator=STEP), {"mu": [0.4, 0.6]})
    assert np.isfinite(found.way[0]) and np.isnan(found.way[1])
    assert "must return an ns.Scene, or a ready scene" in str(found.message.values[1])


def test_a_run_that_ctrl_c_cut_is_no_cell_of_the_result():
    def measured(sol):
        return sol.t[-1]

    def interrupted(mu):
        if mu > 0.5:
            signal.raise_signal(signal.SIGINT)
        return pushed(mu)

    found = ns.sweep(ns.SceneTask(interrupted, measured, t_span=(0, 0.1), integrator=STEP), {"mu": [0.4, 0.6]})
    assert found.measured.values[0] == pytest.approx(0.1) and np.isnan(found.measured.values[1])

    calls = []

    def moved(t):
        calls.append(t)
        if len(calls) == 30:
            signal.raise_signal(signal.SIGINT)
        return (0.0, 0.0)

    def guided(mu):
        scene = pushed(mu)
        scene.kinematic(ns.Disc(0.01), motion=lambda t: moved(t), name="guide")
        return scene

    found = ns.sweep(ns.SceneTask(guided, measured, t_span=(0, 0.1), integrator=STEP), {"mu": [0.4, 0.6]})
    assert "measured" not in found or np.isnan(found.measured.values).all()


def test_ready_scenes_are_swept_by_their_parameters():
    def rests(sol):
        return float(np.abs(sol.velocity[-1]).max() == 0.0)

    found = ns.sweep(
        ns.SceneTask(BlockOnIncline, rests, t_span=(0, 0.05), integrator=STEP, record=("bodies",)),
        {"share": [0.5, 0.9]},
    )
    assert found.rests.values.tolist() == [1.0, 1.0]
