"""Models are found by name whatever the user's files are called; models of a file need no package."""

import json
import re
import subprocess
import sys

import pytest

import models
import nonsmooth as ns
from nonsmooth import catalogue
from nonsmooth.catalogue import entries
from nonsmooth.commands.cli import main

OWN = '''
from dataclasses import dataclass
from typing import NamedTuple
import nonsmooth as ns
from helper import mass

def force(t, q, u, p, h):
    h[0] = -p.m * p.g

def gap(t, q, p, g_N):
    g_N[0] = q[0]

@dataclass(frozen=True)
class Ball:
    """A ball of a user's own."""
    m: float = 1.0
    g: float = 10.0
    t_end = 0.2
    dt = 1e-3

    def system(self):
        return ns.System(coordinates=[("y", "m")], mass=mass, force=force, gap=gap, contacts=[ns.Contact(e_N=0.5)],
                         parameters=self, name="own ball")

    def state(self, height=1.0):
        return [height], [0.0]

class Parameters(NamedTuple):
    m: float = 1.0
    g: float = 10.0

ball = Ball(g=5.0)
bare = ns.System(coordinates=[("y", "m")], mass=mass, force=force, gap=gap, contacts=[ns.Contact()],
                 parameters=Parameters(), name="bare ball")
'''
MAKERS = """
def make():
    return Ball(g=20.0)

def heavy(g, factor=1.0):
    return Ball(g=factor * g)

def worded(place, times="1", g=10.0):
    return Ball(g={"earth": g, "moon": 1.6}[place] * {"1": 1.0, "2": 2.0}[times])

def scene():
    made = ns.Scene(gravity=(0, -9.81))
    made.fixed(ns.HalfPlane((0, 1)))
    made.body(ns.Disc(0.1), density=1000, position=(0, 0.5), name="disc")
    return made
"""


@pytest.fixture
def own(tmp_path, monkeypatch):
    (tmp_path / "helper.py").write_text("def mass(t, q, p, M):\n    M[0, 0] = p.m\n")
    (tmp_path / "own.py").write_text(OWN + MAKERS)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    yield tmp_path
    for name in ("own", "helper"):
        sys.modules.pop(name, None)


def result_of(capsys, *words):
    assert main([*words]) == 0
    return json.loads(capsys.readouterr().out)


def test_catalogue_has_the_objects_of_models():
    assert catalogue.load("sprag-slip") is catalogue.SpragSlip is models.SpragSlip
    assert {"sprag-slip", "box-stack"} <= set(catalogue.names()) and "BoxStack" in dir(catalogue)
    with pytest.raises(ns.UnknownName, match="did you mean 'sprag-slip'"):
        catalogue.load("spragslip")
    with pytest.raises(AttributeError, match="did you mean 'SpragSlip'"):
        _ = catalogue.SpragSlipp


@pytest.mark.upkeep
@pytest.mark.parametrize("is_package", [False, True])
def test_models_are_found_where_a_file_of_the_user_has_their_name(tmp_path, is_package):
    hider = tmp_path / ("models/__init__.py" if is_package else "models.py")
    hider.parent.mkdir(exist_ok=True)
    hider.write_text("mine = 1\n")
    code = (
        "import sys, pickle; sys.path.insert(0, sys.argv[1])\n"
        "import models; assert models.mine == 1\n"
        "from nonsmooth.catalogue import PainleveRod, BoxStack, load\n"
        "rod = PainleveRod(mu=2.0); assert load('painleve-rod') is PainleveRod\n"
        "assert pickle.loads(pickle.dumps(rod)) == rod and rod.system().n_c == 1\n"
        "from nonsmooth.commands.cli import main\n"
        "assert main(['list']) == 0\n"
    )
    ended = subprocess.run([sys.executable, "-c", code, tmp_path], capture_output=True, text=True, timeout=120)
    assert ended.returncode == 0 and ended.stderr == "" and "painleve-rod" in ended.stdout, ended.stderr


def test_class_instance_system_and_function_of_a_file_run(own, capsys):
    def end(*words):
        return result_of(capsys, "run", *words, "--t-end", "0.1", "--json")["u"][0]

    assert end("own.py:Ball") == pytest.approx(-1.0) and end("own.py:ball") == pytest.approx(-0.5)
    assert end("own.py:make") == pytest.approx(-2.0) == end("own.py:make", "--set", "m=3")
    assert end("own.py:make", "--set", "g=4") == pytest.approx(-0.4)
    assert end("own.py:heavy", "--set", "g=4", "factor=3", "m=2") == pytest.approx(-1.2)
    assert end("own.py:worded", "--set", "place=moon") == pytest.approx(-0.16)
    assert end("own.py:worded", "--set", "place=earth", "times=2", "g=3") == pytest.approx(-0.6)
    assert end("own.py:ball", "--set", "g=3", "--state", "height=4") == pytest.approx(-0.3)
    assert end("own.py:bare", "--state", "y=2", "ydot=1", "--dt", "1e-3") == pytest.approx(0.0, abs=1e-12)


def test_other_commands_take_models_of_a_file(own, capsys):
    assert result_of(capsys, "classify", "own.py:Ball", "--state", "height=0", "--json")["kind"] == "REGULAR"
    swept = result_of(capsys, "sweep", "own.py:bare", "--axis", "ydot=0,1", "--t-end", "0.1", "--dt", "1e-3", "--state",
                      "y=2", "--json", "--progress", "none")  # fmt: skip
    assert swept["results"]["u"]["values"] == [[pytest.approx(-1.0)], [pytest.approx(0.0, abs=1e-12)]]
    assert main(["map", "own.py:bare", "--axis", "y=0:1:3"]) == 0
    assert (own / "bare-map.png").exists() and "y (3)" in capsys.readouterr().out


def test_models_of_a_file_are_listed(own, capsys):
    assert main(["list", "own.py"]) == 0
    out = capsys.readouterr().out
    assert "own.py:Ball        A ball of a user's own." in out and "--state  y  ydot" in out and "bouncing" not in out


def test_one_model_is_listed_with_units_and_meanings(own, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    assert main(["list", "belt-oscillator"]) == 0
    out = capsys.readouterr().out
    assert (
        re.search(r"^  vb +0\.2 +m/s +Belt speed$", out, re.MULTILINE) and max(map(len, out.splitlines()[2:16])) <= 80
    )
    assert re.search(r"^  law +cubic +- +Law of friction", out, re.MULTILINE)
    assert re.search(r"^  velocity +0$", out, re.MULTILINE) and "by default t_end = 20 s, dt = 0.001 s" in out


def test_every_parameter_of_our_models_has_a_unit_and_a_meaning(capsys):
    """So that `nonsmooth list NAME` and the axes of figures have something to say."""
    assert main(["list", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["models"]
    assert {model["is"] for model in found} == {"model", "scene"}
    mute = [(model["name"], name) for model in found for name in model["parameters"]
            if not (model["units"][name] and model["meanings"][name])]  # fmt: skip
    assert not mute


def test_models_and_scenes_stand_under_headings(capsys):
    assert main(["list"]) == 0
    models, scenes = capsys.readouterr().out.split("Scenes of bodies")
    assert (
        models.startswith("Models, systems of coordinates") and "\nsprag-slip " in models and "\nbox-stack " in scenes
    )
    assert "m=2 kg  I=4 kg m^2" in models


@pytest.mark.upkeep
def test_a_scene_of_a_file_is_classified_as_its_system(own, capsys):
    assert main(["classify", "own.py:scene"]) == 0
    assert capsys.readouterr().out.startswith("REGULAR: one solution")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["run", "missing.py:Ball"], "there is no file missing.py"),
        (["run", "own.py"], "own.py has Ball, ball, bare: say which, as own.py:Ball"),
        (["run", "own.py:Bal"], "own.py has no Bal; did you mean 'Ball'?"),
        (["run", "own.py:MAKER"], "own.py:MAKER is no model: a System, a Scene, a class or an instance with system()"),
        (["run", "own.py:bare", "--dt", "1e-3", "--t-end", "1"], "give --state y=... ydot=..., or --q0 and --u0"),
        (["run", "own.py:scene", "--set", "m=1"], "there is no parameter 'm'; a Scene has none"),
        (["run", "broken.py:Ball"], "broken.py cannot be run: NameError: name 'nowhere' is not defined (line 2)"),
    ],
)
def test_what_is_no_model_of_a_file_is_told_in_one_line(own, capsys, words, said):
    (own / "broken.py").write_text("x = 1\ny = nowhere\n")
    (own / "own.py").write_text((own / "own.py").read_text() + "MAKER = 1\n")
    assert main(words) == 2
    told = capsys.readouterr().err
    assert said in told and told.count("\n") == 1


def test_a_package_whose_models_fail_is_told_in_one_line(monkeypatch, capsys):
    from importlib.metadata import EntryPoint

    broken = {name: EntryPoint(name, "no_such_package.models:Rod", entries.GROUP) for name in ("a", "b", "c")}
    monkeypatch.setattr("nonsmooth.catalogue.entries.model_entries", lambda: broken)
    monkeypatch.setattr("nonsmooth.catalogue.entries.scene_entries", dict)
    assert main(["list"]) == 0
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and "a could not be loaded" in said and "2 more of the package no_such_package" in said
