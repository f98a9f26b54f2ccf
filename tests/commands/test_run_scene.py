"""`nonsmooth run` and `nonsmooth list` with ready scenes."""

import json

import pytest

import nonsmooth as ns
from models.scenes import BoxStack
from nonsmooth.commands.cli import main


def test_a_scene_runs_and_tells_its_bodies(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    pytest.importorskip("matplotlib")
    words = "run box-stack --set n=3 dim=2 --dt 1e-3 --t-end 0.05 --picture p.png --no-plot --out run.npz --json"
    assert main(words.split()) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["status"] == "FINISHED" and told["t"] == pytest.approx(0.05)
    assert told["bodies"]["box 2"]["position"] == pytest.approx([0.0, 0.5], abs=1e-9)
    assert told["stats"]["steps"] == 50 and set(told["ledger"]) >= {"kinetic", "potential", "friction"}
    assert (tmp_path / "p.png").stat().st_size > 0
    assert ns.SceneSolution.load(tmp_path / "run.npz").stats.steps == 50


def test_the_player_of_a_scene_is_written(tmp_path, capsys):
    path = tmp_path / "stack.html"
    assert main(f"run box-stack --set n=2 dim=2 --t-end 0.02 --no-plot --view {path}".split()) == 0
    assert f"player: {path}" in capsys.readouterr().out and "box 1" in path.read_text()


def test_list_names_models_and_scenes(capsys):
    assert main(["list"]) == 0
    said = capsys.readouterr().out
    assert "bouncing-ball" in said and "masonry-arch" in said and "ratio=0.12" in said


@pytest.mark.parametrize(
    "words, message",
    [
        (
            "--integrator event-driven",
            "may touch along faces, which has no smooth gap; leave the pair out",
        ),
        ("--state x=1", "--state is no option for box-stack, a scene of bodies; leave it out"),
        ("--q0 1 --u0 1", "--q0 is no option for box-stack"),
        ("--selection none", "no selection rule 'none'"),
        ("--projection", "bodies of a scene are pushed apart in every step; leave out"),
        ("--dump-failure f.pdf", "must end in one of .npz"),
        ("--view a.pdf", "must end in one of .html"),
        ("--animate a.pdf", "must end in one of .gif"),
        ("--set m=3", "there is no parameter 'm'"),
        ("--set n=0", "n must be a whole number of at least 1; got 0"),
    ],
)
def test_options_that_a_scene_does_not_take_are_refused_by_name(words, message, capsys):
    assert main(["run", "box-stack", "--no-plot", *words.split()]) == 2
    said = capsys.readouterr().err
    assert message in said and said.count("\n") == 1


@pytest.mark.upkeep
@pytest.mark.parametrize("name, taken", [("auto", "MoreauJean"), ("event-driven", "EventDriven")])
def test_a_scene_of_a_file_is_integrated_as_its_system_where_it_has_one(name, taken, tmp_path, capsys):
    path = tmp_path / f"by_{taken}.py"
    shape = "ns.Box(0.1, 0.1)" if taken == "MoreauJean" else "ns.Disc(0.1)"
    path.write_text(
        "import nonsmooth as ns\n"
        "scene = ns.Scene(gravity=(0, -9.81), t_end=0.01, dt=1e-3)\n"
        f"for k in range(2): scene.body({shape}, mass=1.0, position=(k, 0.5), name=f'body {{k}}')\n"
    )
    assert main(["run", f"{path}:scene", "--integrator", name, "--no-plot", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["about"]["integrator"].startswith(taken) and told["t"] == 0.01
    assert told["bodies"]["body 1"]["position"] == pytest.approx([1.0, 0.5 - 9.81 * 0.01**2 / 2], rel=1e-12)


def test_a_scene_is_moved_apart_on_request(tmp_path, capsys):
    path = tmp_path / "sunk.py"
    path.write_text(
        "from dataclasses import dataclass\n"
        "import nonsmooth as ns\n"
        "@dataclass(frozen=True)\n"
        "class Sunk:\n"
        "    name, t_end, dt = 'sunk', 0.01, 1e-3\n"
        "    def scene(self):\n"
        "        scene = ns.Scene(gravity=(0, -9.81))\n"
        "        scene.fixed(ns.HalfPlane((0, 1)), name='ground')\n"
        "        scene.body(ns.Disc(0.1), mass=1.0, position=(0, 0.06), name='ball')\n"
        "        return scene\n"
    )
    assert main(f"run {path} --no-plot".split()) == 2
    assert "ground and ball overlap at the start by 0.04 m" in capsys.readouterr().err
    assert main(f"run {path} --no-plot --project --json".split()) == 0
    assert json.loads(capsys.readouterr().out)["bodies"]["ball"]["position"][1] == pytest.approx(0.1, abs=1e-12)


def test_a_budget_ends_a_scene_with_what_was_computed(capsys):
    assert main("run box-stack --set n=2 dim=2 --t-end 0.1 --max-steps 5 --no-plot --json".split()) == 3
    assert json.loads(capsys.readouterr().out)["stats"]["steps"] == 5


def test_commands_that_need_a_system_say_why_a_scene_has_none(capsys):
    assert main("classify box-stack --set n=2 dim=2".split()) == 2
    said = capsys.readouterr().err
    assert "may touch along faces" in said and "MoreauJean(dt)) takes it" in said
    assert main(["run", "box-stak"]) == 2
    assert "there is no model 'box-stak'; did you mean 'box-stack'?" in capsys.readouterr().err


SCENE_FILE = """
import nonsmooth as ns

def discs():
    scene = ns.Scene(gravity=(0, -9.81))
    scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    scene.body(ns.Disc(0.1), density=1000, position=(0, 0.1), name="disc")
    return scene

rod = ns.System(n_q=1, mass=lambda t, q, p, M: None, force=lambda t, q, u, p, h: None)
"""


@pytest.fixture
def scene_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my_discs.py").write_text(SCENE_FILE)
    return tmp_path


def test_a_scene_of_a_file_is_run_shown_and_shown_again_from_what_was_saved(scene_file, capsys):
    words = "scene my_discs.py:discs --t-end 0.02 --dt 1e-3 --no-plot"
    assert main([*words.split(), "--out", "run.npz", "--view"]) == 0
    assert "player: discs.html" in capsys.readouterr().out
    first = (scene_file / "discs.html").read_text()
    assert main("scene my_discs.py:discs --saved run.npz --no-plot --view again.html --json".split()) == 0
    assert json.loads(capsys.readouterr().out)["t"] == pytest.approx(0.02)
    assert "disc" in first and len((scene_file / "again.html").read_text()) == pytest.approx(len(first), rel=0.01)


def test_an_interrupted_run_that_was_saved_is_shown(scene_file, capsys):
    ready = ns.simulate(BoxStack(n=2, dim=2), (0, 0.02), integrator=ns.MoreauJean(dt=1e-3))
    object.__setattr__(ready, "status", ns.Status.INTERRUPTED)
    ready.save("cut.npz")
    words = "scene box-stack --set n=2 dim=2 --saved cut.npz --no-plot --view cut.html"
    assert main(words.split()) == 0 and (scene_file / "cut.html").exists()
    assert "player: cut.html" in capsys.readouterr().out


@pytest.mark.parametrize(
    "words, message",
    [
        ("my_discs.py:rod", "rod is a model with a system, which `nonsmooth run` sets in motion"),
        ("my_discs.py:discs --saved no.npz --t-end 1", "--saved runs nothing, and takes no --t-end; leave it out"),
        ("my_discs.py:discs --saved no.npz --live", "--saved runs nothing, and takes no --live; leave it out"),
        ("my_discs.py:discs --saved no.npz", "no.npz"),
        ("my_discs.py:discs --dt 1e-3", "the model discs has no t_end of its own; give --t-end"),
        ("bouncing-ball", "bouncing-ball is a model with a system"),
    ],
)
def test_what_is_no_scene_to_show_is_refused_in_a_sentence(words, message, scene_file, capsys):
    assert main(["scene", *words.split(), "--no-plot"]) == 2
    said = capsys.readouterr().err
    assert message in said and said.count("\n") == 1
