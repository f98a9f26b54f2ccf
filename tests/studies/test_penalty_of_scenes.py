"""The penalty limit of scenes: orders and constants, and what is told."""

import numpy as np
import pytest

import nonsmooth as ns
from models.scenes import BoxStack
from nonsmooth.commands.cli import main


def test_a_stack_on_springs_is_wrong_by_the_sum_of_its_depths():
    """e(k) = sum of load/(2 k) over the joints: order 1, and the constant in closed form, to 1e-4."""
    stack = BoxStack(n=4, dim=2)
    study = ns.penalty_study(stack, (0, 0.5), stiffness=[1e7, 1e8, 1e9], beside=[], progress=False)
    constant = stack.loads().sum() / 2
    assert np.abs(study.errors("error_q") * study.x / constant - 1).max() < 1e-4
    assert np.abs(study.orders("error_q") - 1).max() < 1e-4
    assert np.diff(np.log10(study.data.penetration.values)).max() < -0.9
    assert study.notes() == []


def test_a_scene_without_a_name_is_called_a_scene():
    scene = ns.Scene(gravity=(0, -9.81))
    scene.fixed(ns.HalfPlane((0, 1)))
    scene.body(ns.Disc(0.1), mass=1.0, position=(0, 0.1))
    study = ns.penalty_study(scene, (0, 0.1), stiffness=[1e5, 1e6], beside=[], progress=False)
    assert study.title == "a scene: the penalty limit"


def test_soft_springs_are_a_note_of_the_study():
    """At 1e4 N/m four boxes of 40 kg stand in one another."""
    study = ns.penalty_study(BoxStack(n=4, dim=2), (0, 0.1), stiffness=[1e4, 1e8], beside=[], progress=False)
    assert any("soft: up to k = 1e+04 N/m" in note for note in study.notes())


def test_a_disc_that_slides_is_wrong_by_its_springs():
    """It begins without depth: its springs need some time, k^-1/2, to bear it and to slide, and its friction lacks a
    part of that; what is left of it falls at least like k^-1/2."""
    scene = ns.Scene(gravity=(0, -9.81), material=ns.Material(mu=0.3))
    scene.fixed(ns.HalfPlane((0, 1)))
    scene.body(ns.Disc(0.1), mass=2.0, position=(0, 0.1), velocity=(1.0, 0), name="disc")
    study = ns.penalty_study(scene, (0, 0.1), stiffness=[1e6, 1e8, 1e10], beside=[], progress=False)
    assert (study.orders("error_q") > 0.4).all()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"q0": [0.0], "u0": [0.0]}, "the bodies of a scene have their start; leave out q0 and u0"),
        ({"contact": 1}, "contact= of a penalty study looks at a contact of a system"),
        ({"limit": 1.0}, "limit= of a penalty study looks at a contact of a system"),
        ({"delay": 1.0}, "delay= of a penalty study looks at a contact of a system"),
    ],
)
def test_what_only_systems_have_is_refused(options, said):
    """One sentence each."""
    with pytest.raises(ns.InvalidInput, match=said):
        ns.penalty_study(BoxStack(n=2, dim=2), (0, 0.1), stiffness=[1e7], progress=False, **options)


def test_command_line_draws_the_study_of_a_scene(tmp_path, capsys):
    """One line: its table and its figure."""
    figure = tmp_path / "stack.png"
    line = ["study", "penalty", "box-stack", "--set", "dim=2", "n=2", "--t-end", "0.1", "--stiffness", "1e7", "1e8"]
    assert main([*line, "--plot", str(figure)]) == 0
    assert "box-stack: the penalty limit" in capsys.readouterr().out
    assert figure.stat().st_size > 10_000
