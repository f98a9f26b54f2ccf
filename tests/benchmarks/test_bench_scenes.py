"""Scenes of many bodies: every program is handed the same one, and figures are what they say."""

import importlib.util
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from benchmarks import scenes
from benchmarks.adapters import nonsmooth_scenes
from benchmarks.core import script
from benchmarks.scene_stages import make_stepper
from models.scenes import BoxStack, SphereBox

ROOT = Path(__file__).parents[2]
STACK = BoxStack(n=3)
# in an interpreter of its own: other programs may end theirs
FALL = """
import numpy as np
from benchmarks.scenes import DT, SphereBox, adapter, discs
scene = {scene}
motions = [adapter(name).Motion(scene(), DT) for name in ("nonsmooth_scenes", "{module}")]
for motion in motions:
    motion.step(5)
ours, theirs = (motion.places()[0][-8:] for motion in motions)  # those that the skin of Box2D's floor does not hold
print(np.abs(ours - theirs).max())
"""


@pytest.mark.upkeep
def test_small_scenes_run_side_by_side():
    words = ["scenes", "quick", "S2tilt", "S7", "pyramid", "discs", "growth", "stages", "threads"]
    ended = subprocess.run(
        [sys.executable, "-m", "benchmarks", *words], cwd=ROOT, capture_output=True, text=True, timeout=300
    )
    assert ended.returncode == 0, ended.stderr
    rows = [line for line in ended.stdout.splitlines() if line.startswith("|")]
    assert sum("| nonsmooth |" in row for row in rows) == 4
    for name, program in (("S2tilt", "MuJoCo"), ("S7", "PyBullet"), ("pyramid", "pymunk"), ("discs", "Box2D 2.3")):
        assert any(row.startswith(f"| {name} | {program} |") for row in rows)
    assert len({row.count("|") for row in rows if row.startswith("| S7 ")}) == 1


def test_a_name_that_is_none_is_refused(capsys):
    assert scenes.main(["S99"]) == 2
    assert "'S99'" in capsys.readouterr().err


def test_a_block_that_friction_holds_is_told_to_stay():
    course = scenes.started(scenes.OURS, scenes.cases(True)["S2tilt"].scene)
    judge = nonsmooth_scenes.Judge(scenes.cases(True)["S2tilt"].scene(), scenes.DT)
    for _ in range(2):
        course.take(5, judge)
    assert scenes.row(course, stays=True).endswith("| 0.0e+00 m")


@pytest.mark.parametrize("depth", [0.0, 1e-3])
def test_penetration_is_what_the_upper_cubes_were_lowered_by(depth):
    places = np.zeros((3, 3))
    places[:, 2] = STACK.heights()
    places[1:, 2] -= depth
    upright = np.tile([1.0, 0.0, 0.0, 0.0], (3, 1))
    found = nonsmooth_scenes.Judge(STACK.scene(), STACK.dt).penetration(places, upright)
    assert abs(found - depth) < 1e-15


@pytest.mark.upkeep
@pytest.mark.parametrize("package, module, scene", [
    ("mujoco", "mujoco_scenes", "SphereBox(n=8).scene"), ("pybullet", "pybullet_scenes", "SphereBox(n=8).scene"),
    ("pymunk", "pymunk_scenes", "lambda: discs(33)"), ("Box2D", "box2d_scenes", "lambda: discs(33)"),
])  # fmt: skip
def test_bodies_fall_alike_in_other_programs(package, module, scene):
    """To what two rules of stepping differ by in n steps, n g dt^2/2 or less, and to single precision."""
    if importlib.util.find_spec(package) is None:
        pytest.skip(f"{package} is not installed")
    assert script(FALL.format(module=module, scene=scene), read=True) < 5 * 9.81 * scenes.DT**2 / 2 + 1e-6


def test_stages_one_by_one_are_the_step_to_the_last_bit():
    spheres = SphereBox(n=12)  # steps of ten bodies and more are not divided
    stepper, motion = make_stepper(spheres, {}), nonsmooth_scenes.Motion(spheres.scene(), spheres.dt)
    for _ in range(60):  # of 0.12 s: the lowest have landed
        stepper.step()
        motion.step(1)
    assert motion.run.stats().contacts > 0
    assert (stepper.motion.places()[0] == motion.places()[0]).all()
