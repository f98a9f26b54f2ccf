"""``nonsmooth show``: a saved run is printed, drawn and converted as it was when it ran."""

import json
from pathlib import Path

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.commands.cli import main

SCENE = "run box-stack --set n=2 dim=2 a=0.3 --t-end 0.02 --no-plot --out".split()
BALL = "run bouncing-ball --set e=0.8 --t-end 0.3 --no-plot --out".split()


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(("words", "file"), [(BALL, "ball.npz"), (SCENE, "stack.npz")])
def test_a_saved_run_says_what_it_said(words, file, capsys):
    assert main([*words, file]) == 0
    said = capsys.readouterr().out.replace(f"solution: {file}\n", "")
    assert main(["show", file]) == 0
    assert capsys.readouterr().out == said


def test_a_checkpoint_and_a_file_of_another_form_are_shown(capsys, folder):
    assert main([*BALL, "ball.h5", "--checkpoint", "kept", "--quiet"]) == 0
    told = {}
    for path in ("ball.h5", "kept"):
        assert main(["show", path, "--json"]) == 0
        told[path] = json.loads(capsys.readouterr().out)
    assert told["ball.h5"]["q"] == told["kept"]["q"]
    assert main(["show", "ball.h5", "--out", "ball.npz", "--quiet"]) == 0
    np.testing.assert_array_equal(ns.Solution.load("ball.npz").q, ns.Solution.load("ball.h5").q)


def test_bodies_are_drawn_of_the_model_that_the_file_names(folder, capsys):
    assert main([*BALL, "ball.npz", "--quiet"]) == 0
    assert main("show ball.npz --picture ball.png --plot run.png --view".split()) == 0
    assert (folder / "ball.html").exists() and (folder / "run.png").read_bytes()[:4] == b"\x89PNG"
    assert "player: ball.html" in capsys.readouterr().out


def test_a_scene_is_drawn_with_the_parameters_of_its_file(folder):
    """The boxes are drawn as large as they were, 0.3 m, and not as by default, 0.2 m."""
    from nonsmooth.commands.show import saved_run

    assert main([*SCENE, "stack.npz", "--quiet"]) == 0
    solution, is_scene = saved_run(folder / "stack.npz", "box-stack")
    assert is_scene and solution.scene.bodies[1].shape == ns.Box(0.3, 0.3)
    assert main("show stack.npz --model box-stack --picture stack.png --quiet".split()) == 0


@pytest.mark.parametrize(("words", "said"), [
    ("stack.npz --view", "stack.npz holds the motion of a scene and not its shapes: give --model NAME"),
    ("stack.npz --model sprag-slip --view", "sprag-slip is a model with a system; the file is the run of a scene"),
    ("ball.npz --model sprag-slip", "SpragSlip cannot be made of the parameters in the file"),
    ("noise.npz", "noise.npz is not a saved solution, or is damaged"),
    ("missing.npz", "there is no file 'missing.npz'"),
    ("ball.npz --plot run.txt", "must end in one of .png"), ("ball.npz --out run.csv", "must end in one of .npz"),
])  # fmt: skip
def test_what_cannot_be_shown_is_told_in_one_line(words, said, folder, capsys):
    (folder / "noise.npz").write_bytes(b"noise")
    for model, file in ((SCENE, "stack.npz"), (BALL, "ball.npz")):
        assert main([*model, file, "--quiet"]) == 0
    assert main(["show", *words.split()]) == 2
    told = capsys.readouterr().err
    assert said in told and told.count("\n") == 1


BALL_FOR = "run bouncing-ball --set e=0.8 --t-end 0.3 --out ball.npz".split()


@pytest.mark.upkeep
@pytest.mark.parametrize(("words", "what", "panels", "load"), [
    (BALL_FOR, "ball", ["energy", "modes"], ns.Solution.load),
    ([*SCENE[:-2], "--out", "stack.npz"], "stack", ["bodies", "accuracy"], lambda file: saved_scene(file)),
])  # fmt: skip
def test_the_figure_shows_the_panels_that_were_asked_for(words, what, panels, load, folder):
    """A run, and the saved run, draw what ``plot(panels=)`` draws of it."""
    assert main([*words, "--plot", "run.png", "--panels", *panels, "--quiet"]) == 0
    load(f"{what}.npz").plot("python.png", panels=panels)
    assert (folder / "run.png").read_bytes() == (folder / "python.png").read_bytes()
    model = ["--model", "box-stack"] if what == "stack" else []
    assert main(["show", f"{what}.npz", *model, "--plot", "shown.png", "--panels", *panels, "--quiet"]) == 0
    assert (folder / "shown.png").read_bytes() == (folder / "python.png").read_bytes()


def saved_scene(file):
    from nonsmooth.commands.show import saved_run

    return saved_run(Path(file), "box-stack")[0]


@pytest.mark.parametrize(("words", "said"), [
    ("run bouncing-ball --panels enrgy", "there is no panel 'enrgy'; did you mean 'energy'"),
    ("run box-stack --panels modes", "there is no panel 'modes'"),
    ("run bouncing-ball --panels energy --no-plot", "--panels chooses what --plot draws; give --plot FILE"),
    ("run bouncing-ball --panels energy --json", "give --plot FILE"),
    ("show ball.npz --panels energy", "give --plot FILE"),
    ("show ball.npz --panels speeds --plot ball.png", "there is no panel 'speeds'"),
])  # fmt: skip
def test_panels_that_there_cannot_be_are_refused_before_the_run(words, said, folder, capsys):
    assert main([*BALL_FOR, "--no-plot", "--quiet"]) == 0
    assert main(words.split()) == 2
    told = capsys.readouterr().err
    assert said in told and told.count("\n") == 1 and [path.name for path in folder.iterdir()] == ["ball.npz"]
