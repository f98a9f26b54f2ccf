"""``nonsmooth new``: what it writes runs as it is, draws, and does what it says of itself."""

import json
import re
import tomllib

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.catalogue.files import found_in, load_file
from nonsmooth.commands.cli import main
from nonsmooth.commands.new import BEGINNINGS


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.upkeep
@pytest.mark.parametrize("kind", BEGINNINGS)
def test_the_file_runs_as_it_is_and_every_command_that_it_names_does(kind, folder, capsys):
    if kind == "energies":
        pytest.importorskip("sympy", reason="energies need SymPy, the extra [symbolic]")
    assert main(["new", f"my_{kind}.py", "--of", kind]) == 0
    printed = capsys.readouterr().out
    assert f"    nonsmooth run my_{kind}.py --view" in printed and BEGINNINGS[kind] in printed
    text = (folder / f"my_{kind}.py").read_text()
    commands = re.findall(rf"^    nonsmooth (\w+ my_{kind}\.py.*?)(?:   .*)?$", text, re.MULTILINE)
    assert len(commands) >= 2 and commands[0].endswith("--view") and "FILE" not in text
    for words in commands:
        assert main([*words.split(), "--quiet"]) == 0, words
    assert any(folder.glob("*.html")) and max(map(len, text.splitlines())) <= 120
    (name,) = found_in(load_file(f"my_{kind}.py"))
    assert main(["list", f"my_{kind}.py:{name}"]) == 0


@pytest.mark.upkeep
def test_a_scene_in_toml_runs_as_it_is_and_fits_the_schema_beside_it(folder, capsys):
    """It is the scene of the Python file, to rounding."""
    jsonschema = pytest.importorskip("jsonschema")
    assert main(["new", "ramp.toml"]) == main(["new", "ramp.py", "--of", "scene"]) == 0
    assert "    nonsmooth run ramp.toml --view" in capsys.readouterr().out
    text = (folder / "ramp.toml").read_text()
    commands = re.findall(r"^#     nonsmooth (\w+ ramp\.toml.*?)(?:   .*)?$", text, re.MULTILINE)
    assert len(commands) == 2
    for words in commands:
        assert main([*words.split(), "--quiet"]) == 0, words
    scene, twin = ns.Scene.load("ramp.toml"), load_file("ramp.py").scene
    assert [body.name for body in scene] == [body.name for body in twin]
    for body, other in zip(scene, twin, strict=True):
        np.testing.assert_allclose([*body.position, body.turn], [*other.position, other.turn], rtol=1e-14)
    schema = json.loads((folder / "scene.schema.json").read_text())
    jsonschema.validate(tomllib.loads(text), schema)
    assert main(["new", "model.toml", "--of", "energies"]) == 2


def test_the_block_sticks_to_its_belt(folder):
    """One that sticks moves as the belt does, to rounding."""
    assert main(["new", "belt.py"]) == 0
    block = load_file("belt.py").Block(vb=0.05)
    sol = ns.simulate(block, (0, 3), *block.state(), integrator=ns.MoreauJean(dt=block.dt))
    sticks = sol.mode[:, 0] == ns.ContactMode.STICK
    assert sticks.any() and np.abs(sol.u[sticks, 0] - 0.05).max() < 1e-14


@pytest.mark.parametrize(("words", "said"), [
    ("there.py", "there is a file there.py already"), ("model.txt", "must end in one of .py, .toml"),
    ("nowhere/model.py", "there is no folder 'nowhere'"), ("model.py --of energy", "did you mean 'energies'?"),
])  # fmt: skip
def test_nothing_is_overwritten_and_refusals_are_one_line(words, said, folder, capsys):
    (folder / "there.py").write_text("mine = 1\n")
    try:
        code = main(["new", *words.split()])
    except SystemExit as ended:
        code = ended.code
    told = capsys.readouterr().err
    assert code == 2 and said in told and told.count("\n") == 1
    assert (folder / "there.py").read_text() == "mine = 1\n" and [*folder.iterdir()] == [folder / "there.py"]
