"""``python -m benchmarks space``: the exact ends of its motions, and its rows and picture."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks import space
from benchmarks.space import MOTIONS


@pytest.mark.upkeep
@pytest.mark.parametrize("name", MOTIONS)
def test_steps_end_where_the_reference_says_as_a_system_and_as_a_scene(name):
    """Of second order as a system; of first where the contact of a scene wanders on a body that tilts."""
    motion, exact = MOTIONS[name], MOTIONS[name].exact()
    runs = dict(space.methods(motion))
    for label, part in (("MoreauJean", 0.1), ("MoreauJean, scene", 0.3)) if motion.scene else (("MoreauJean", 0.1),):
        errors = [np.abs(runs[label][0](dt)[1] - exact).max() for dt in (4e-4, 1e-4)]
        assert errors[1] < max(1e-7, part * errors[0]) and errors[1] < 5e-5


@pytest.mark.parametrize("name", ["tippe-top", "rod in space", "rod on a point"])
def test_the_tops_slide_all_the_time(name):
    motion = MOTIONS[name]
    assert space.sliding(motion.system, *motion.start, motion.t_end)[1] > 0.05


def test_in_mujoco_the_same_bodies_move():
    """A soft contact and steps of first order: within a few millimetres at 0.2 ms."""
    pytest.importorskip("mujoco")
    for motion in filter(lambda motion: motion.scene, MOTIONS.values()):
        place = dict(space.methods(motion))["MuJoCo"][0](2e-4)[1]
        assert np.abs(place - motion.exact()).max() < 1e-2


def test_a_motion_has_rows_and_a_panel(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(space, "STEPS", (1e-2, 2.5e-3))
    monkeypatch.setattr(space, "TOLERANCES", (1e-2,))
    monkeypatch.setattr(space, "imports", lambda package: False)
    picture = tmp_path / "space.png"
    assert space.main([str(picture), "slip to roll"]) == 0
    rows = [line for line in capsys.readouterr().out.splitlines() if line.startswith("| slip to roll")]
    assert [row.split(" | ")[1] for row in rows[:3]] == ["MoreauJean", "Adaptive", "EventDriven"]
    assert [row.split(" | ")[1:3] for row in rows[4:]] == [
        ["MoreauJean", "0.01"], ["MoreauJean", "0.0025"], ["Adaptive", "0.01"], ["EventDriven", "0.01"],
        ["MoreauJean, scene", "0.01"], ["MoreauJean, scene", "0.0025"],
    ]  # fmt: skip
    errors = [float(row.split(" | ")[3]) for row in rows[4:]]
    assert errors[1] < 0.1 * errors[0] and errors[3] < 1e-12
    assert picture.stat().st_size > 10_000
    assert space.main(["no such motion"]) == 2


def test_the_least_time_is_that_of_the_settings_that_reach_an_error():
    curve = np.array([[1.0, 2.0, 3.0], [1e-3, 1e-5, 5e-5], [1e-3, 4e-3, 2e-3]])
    assert [space.reached(curve, error) for error in (1e-4, 1e-5, 1e-6)] == ["2", "4", "-"]
