"""Scenes in TOML files: what is saved is read to the last bit, formulas and repetition mean what they say, and each bad
entry has one sentence with its file, table and line."""

from __future__ import annotations

import itertools
import json
import math
import tomllib
from pathlib import Path

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.catalogue.entries import load_entry, scene_entries
from nonsmooth.commands.cli import main
from nonsmooth.scenes.file_schema import schema
from nonsmooth.scenes.formulas import value_of
from nonsmooth.scenes.given import as_scene

TOWER = """\
name = "tower"
gravity = [0, -9.81]
material = {name = "stone", mu = "mu", e = 0}
t_end = 0.05
dt = 1e-3

[values]
n = 4
mu = 0.5
side = "0.1 * 2"

[[materials]]
name = "steel"
mu = {Stribeck = {mu_s = 0.3, mu_k = 0.2, v_s = 0.1}}
e = 0.6

[[bodies]]
kind = "fixed"
name = "ground"
shape = {HalfPlane = [[0, 1]]}

[[bodies]]
repeat = {k = "n"}
name = "box {k}"
shape = {Box = ["side", "side"]}
mass = 1
position = [0, "side * (k + 1/2)"]

[[bodies]]
name = "ball"
shape = {Disc = 0.1}
density = 1000
position = [0.02, "side * n + 0.5"]
material = "steel"

[[pairs]]
a = "steel"
b = "stone"
mu = 0.25
"""


def written(tmp_path, text, name="tower.toml"):
    (tmp_path / name).write_text(text)
    return tmp_path / name


def as_said(value):
    """A description of an element, with the bits of its numbers."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, tuple | list):
        return [as_said(one) for one in value]
    if isinstance(value, ns.Shape if hasattr(ns, "Shape") else ()):
        return [type(value).__name__, as_said(list(vars(value).values()))]
    if hasattr(value, "__dict__") and not isinstance(value, type):
        return {name: as_said(one) for name, one in vars(value).items()}
    return value if isinstance(value, int | float | str | bool) or value is None else repr(value)


def elements(scene):
    """All that a scene is made of."""
    joints = [
        {
            **vars(joint),
            "a": joint.a.name,
            "b": joint.b.name,
            "motors": [vars(motor) for motor in joint.motors],
            "springs": [vars(spring) for spring in joint.springs],
        }  # fmt: skip
        for joint in scene.joints
    ]
    springs = [{**vars(spring), "a": spring.a.name, "b": spring.b.name} for spring in scene.springs]
    forces = [{"body": force.body.name, "value": force.value, "at": force.at} for force in scene.forces]
    pairs = sorted((sorted(names), *values) for names, values in scene.pairs.items())
    facts = [scene.name, scene.gravity, scene.t_end, scene.dt, scene.material]
    ignored = sorted(sorted((a.name, b.name)) for a, b in scene.ignored)
    return json.dumps(as_said([*facts, scene.bodies, joints, springs, forces, pairs, ignored]))


@pytest.mark.parametrize("name", list(scene_entries()))
def test_every_ready_scene_is_read_as_it_was_saved(name, tmp_path):
    scene = as_scene(load_entry(scene_entries()[name])())
    scene.save(tmp_path / "scene.toml")
    back = ns.Scene.load(tmp_path / "scene.toml")
    assert elements(back) == elements(scene)


def machine():
    """One of each kind of shape, joint, spring and force."""
    scene = ns.Scene(gravity=(0, 0, -9.81), material=ns.Material(mu=0.4), name="machine", dt=1e-3)
    steel = ns.Material(mu=ns.Stribeck(mu_s=0.3, mu_k=0.2, v_s=0.1), e=0.25, name="steel")
    rubber = ns.Material(mu=1.0, name="rubber")
    scene.fixed(ns.HalfSpace((0, 0, 1), -2.0), name="ground")
    shapes = [
        ns.Sphere(0.1), ns.Box(0.1, 0.2, 0.3), ns.Capsule(0.2, 0.1), ns.Cylinder(0.1, 0.3), ns.Ellipsoid(0.1, 0.2, 0.3),
        ns.Polyhedron(np.array(list(itertools.product((0, 0.1), repeat=3)))),
        ns.Compound((ns.Sphere(0.1), (-0.2, 0, 0)), (ns.Box(0.1, 0.1, 0.2), (0.2, 0, 0), (0.8, 0.6, 0, 0))),
        ns.Sphere(0.05),
    ]  # fmt: skip
    for k, shape in enumerate(shapes):
        scene.body(
            shape, density=1000 + k / 3, position=(k, 0.1, 1 / 3), turn=(0.6, 0, 0.8, 0), velocity=(1, k, 0),
            spin=(0, 0, 0.1), material=[None, steel, rubber][k % 3], name=f"body {k}",
        )  # fmt: skip
    scene.body(ns.Sphere(0.1), mass=2.0, inertia=(1, 1 / 3, 1), centre=(0.1, 0, 1 / 3), position=(0, 5, 0), name="odd")
    scene.kinematic(ns.Box(1, 1, 0.1), position=(0, 9, 0), velocity=(0, 0.1, 0), spin=(0, 0, 1), name="table")
    axes = {"axis": (1, 2, 5)}
    scene.joint("body 0", "body 1", at=(0.5, 0, 0))
    for k, add in enumerate((scene.hinge, scene.slider, scene.cylindrical, scene.slot, scene.planar), start=1):
        limits = {} if add == scene.planar else {"limits": (-0.1 * k, math.inf)}
        limits |= {"angle_limits": (-1 / 3, 2.0)} if add == scene.cylindrical else {}
        joint = add(f"body {k}", f"body {k + 1}", at=(k, 0, 0), **axes, **limits)
        if add == scene.hinge:
            joint.motor(torque=0.25)
            joint.motor(speed=1 / 3, limit=2.0)
            joint.spring(stiffness=1 / 3, damping=0.1, rest=-0.2, inertia=0.7)
        if add == scene.cylindrical:
            joint.spring(damping=1 / 7, along="travel")
    scene.slider("table", "body 0", axis=(0, 1, 0)).motor(force=-1.5)
    scene.universal("body 0", "body 7", at=(0, 0, 0), axis=(1, 0, 0), axis_b=(0, 1, 0))
    scene.fix("body 6", "body 7", at=(6, 0, 0))
    scene.spring("body 2", "body 5", at_a=(2, 0, 0), stiffness=10.0, damping=0.5)
    scene.spring("body 2", "body 4", stiffness=10.0, length=0.5, name="coil")
    scene.force("body 3", (1.0, 2.0, 1 / 3), at=(3, 0, 0))
    scene.ignore("body 0", "table", "body 3")
    scene.pair("steel", "rubber", mu=0.7)
    scene.pair("steel", "steel", e=0.1)
    return scene


def test_a_scene_with_one_of_each_is_read_as_it_was_saved(tmp_path):
    machine().save(tmp_path / "machine.toml")
    assert elements(ns.Scene.load(tmp_path / "machine.toml")) == elements(machine())


def test_axes_and_turns_are_read_to_the_last_bit(tmp_path):
    rng = np.random.default_rng(5)
    scene = ns.Scene(gravity=(0, 0, 0))
    for k in range(100):
        turn = rng.normal(size=4)
        turn /= np.linalg.norm(turn)
        scene.body(ns.Sphere(0.1), mass=1.0, position=(k, 0, 0), turn=turn, name=f"b{k}")
        if k:
            scene.hinge(f"b{k - 1}", f"b{k}", at=(k, 0, 0), axis=rng.normal(size=3) * 10.0 ** rng.uniform(-9, 9))
    scene.save(tmp_path / "chain.toml")
    assert elements(ns.Scene.load(tmp_path / "chain.toml")) == elements(scene)


def test_a_scene_of_the_plane_with_its_springs_moves_by_the_same_bits(tmp_path):
    scene = ns.Scene(gravity=(0, -9.81), material=ns.Material(mu=0.4, e=0.3))
    scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    scene.fixed(ns.Segment((-3, 0), (-2, 1)), name="ramp")
    a = scene.body(ns.Polygon([(0, 0), (0.2, 0), (0.1, 0.2)], 0.01), mass=1.0, position=(0, 0.4), name="a")
    b = scene.body(ns.Box(0.1, 0.2), mass=2.0, position=(0.3, 0.5), turn=0.1, name="b")
    scene.hinge(a, b, at=(0.2, 0.5))
    scene.torsion_spring(a, b, stiffness=3.0, damping=0.1, angle=0.2)
    scene.save(tmp_path / "plane.toml")
    runs = [
        ns.simulate(one, (0, 0.5), integrator=ns.MoreauJean(1e-3))
        for one in (scene, ns.Scene.load(tmp_path / "plane.toml"))
    ]
    np.testing.assert_array_equal(runs[0].position, runs[1].position)


def test_formulas_values_and_repetition_mean_what_they_say(tmp_path):
    scene = ns.Scene.load(written(tmp_path, TOWER), n=3)
    assert [body.name for body in scene.bodies] == ["ground", "box 0", "box 1", "box 2", "ball"]
    np.testing.assert_array_equal([body.position[1] for body in scene.bodies[1:]], [0.1, 0.2 * 1.5, 0.5, 0.2 * 3 + 0.5])
    assert scene.parameter_values == {"n": 3.0, "mu": 0.5, "side": 0.2} and scene.dt == 1e-3
    assert scene["ball"].material.mu == ns.Stribeck(mu_s=0.3, mu_k=0.2, v_s=0.1)
    assert scene.material.mu == 0.5


def test_the_file_of_the_page_is_a_scene(tmp_path):
    page = (Path(__file__).parents[2] / "docs" / "scenes.md").read_text()
    scene = ns.Scene.load(written(tmp_path, page.split("```toml")[1].split("```")[0]), n=5)
    assert len(scene) == 6 and len(scene.joints) == len(scene.springs) == 1
    assert scene["block 4"].position.tolist() == [0.02 * 0.6 * 4, 0.1 + 0.2 * 4]


def test_a_table_is_repeated_over_every_pair_of_counts(tmp_path):
    text = TOWER + '\n[[bodies]]\nrepeat = {i = 2, j = 3}\nname = "{i}{j}"\nshape = {Disc = 0.1}\nmass = 1\n'
    text += 'position = ["10 + i", "j"]\n'
    scene = ns.Scene.load(written(tmp_path, text))
    places = {body.name: body.position.tolist() for body in scene.bodies[6:]}
    assert places == {f"{i}{j}": [10 + i, j] for i in range(2) for j in range(3)}


def test_files_are_included_with_their_values(tmp_path):
    written(tmp_path, "[values]\ndepth = 0.1\nmu = 0.9\n[[bodies]]\nkind = 'fixed'\nname = 'deep'\n"
            "shape = {HalfPlane = [[0, 1], '-depth']}\n", "deep.toml")  # fmt: skip
    scene = ns.Scene.load(written(tmp_path, 'include = ["deep.toml"]\n' + TOWER), depth=0.3)
    assert scene.bodies[0].name == "deep" and scene.bodies[0].shape.offset == -0.3
    assert scene.parameter_values["mu"] == 0.5  # of the file that includes
    written(tmp_path, 'include = ["a.toml"]\n', "b.toml")
    with pytest.raises(ns.InvalidInput, match=r"a\.toml includes itself, by .*a\.toml, .*b\.toml"):
        ns.Scene.load(written(tmp_path, 'include = ["b.toml"]\n', "a.toml"))


DISC = '[[bodies]]\nname = "d"\nshape = {Disc = 0.1}\n'
BAD = {
    DISC + "mass = -1": r"bodies\[3\] \(line 41\): mass of d must be positive",
    DISC + "mass = 1\ncolour = 2": r"bodies\[3\] \(line 41\): there is no colour here",
    DISC + 'mass = "2 * sid"': r"'2 \* sid' has the name sid, which is not known; did you mean 'side'",
    DISC + 'mass = "1/0"': r"'1/0' has no value: division by zero",
    DISC + 'mass = "(1"': r"'\(1' is no formula",
    DISC + 'mass = "open(1)"': r"has more than numbers, names",
    DISC + 'mass = "n.real"': r"has more than numbers, names",
    DISC + 'mass = 1\nkind = "bodi"': r"kind 'bodi' is unknown; did you mean 'body'",
    DISC + 'mass = 1\nmaterial = "stel"': r"there is no material 'stel'; did you mean 'steel'",
    DISC + "mass = 1\nrepeat = {k = 1.5}": r"k is repeated a whole number of times; got 1.5",
    DISC + "mass = 1\nrepeat = 3": r"repeat must be a table of counts",
    DISC + "mass = inf": r"mass of d",
    '[[bodies]]\nname = "{j}"\nmass = 1\nshape = {Disc = 0.1}': r"braces about what is no number",
    '[[bodies]]\nname = "d"\nmass = 1': r"bodies\[3\] \(line 41\): shape is missing",
    "[[bodies]]\nmass = 1\nshape = {Disk = 0.1}": r"shape Disk is unknown; did you mean 'Disc'",
    "[[bodies]]\nmass = 1\nshape = {Disc = [1, 2]}": r"shape Disc takes radius",
    "[[bodies]]\nmass = 1\nshape = {Disc = {radios = 1}}": r"there is no radios here; did you mean 'radius'",
    "[[joints]]\nkind = 'joint'\na = 'ball'\nb = 'box 9'\nat = [0, 0]": r"joints\[0\] \(line 41\): .*'box 9'",
    "[[forces]]\nbody = 'ball'": r"forces\[0\] \(line 41\): value is missing",
    "[[pairs]]\na = 'steel'\nb = 'steel'\nmu = -0.1": r"pairs\[1\] \(line 41\): mu",
    "[bodis]\nx = 1": r"bodis is unknown; did you mean 'bodies'",
    "x = 1": r"there is no x here",
}  # fmt: skip


@pytest.mark.parametrize("more", BAD)
def test_a_bad_entry_has_one_sentence_with_its_file_table_and_line(more, tmp_path):
    with pytest.raises(ns.InvalidInput, match=BAD[more]) as refusal:
        ns.Scene.load(written(tmp_path, TOWER + "\n" + more + "\n"))
    assert str(refusal.value).startswith(str(tmp_path / "tower.toml")) and "\n" not in str(refusal.value)


NAMES_THAT_ARE_NONE = [more for more in BAD if any(word in more for word in ("colour", '"bodi"', "Disk", "[bodis]"))]


@pytest.mark.parametrize("more", NAMES_THAT_ARE_NONE)
def test_the_schema_marks_names_that_are_none(more):
    jsonschema = pytest.importorskip("jsonschema")
    assert not jsonschema.Draft202012Validator(schema()).is_valid(tomllib.loads(TOWER + "\n" + more))


def test_the_schema_takes_what_is_read(tmp_path):
    jsonschema = pytest.importorskip("jsonschema")
    machine().save(tmp_path / "machine.toml")
    for text in (TOWER, (tmp_path / "machine.toml").read_text()):
        jsonschema.validate(tomllib.loads(text), schema())


def test_what_is_no_file_or_no_value_of_it_is_refused(tmp_path):
    with pytest.raises(ns.InvalidInput, match="cannot be read"):
        ns.Scene.load(tmp_path / "none.toml")
    with pytest.raises(ns.InvalidInput, match="has no value nn; did you mean 'n'"):
        ns.Scene.load(written(tmp_path, TOWER), nn=3)
    with pytest.raises(ns.InvalidInput, match="is no TOML: .*line 2"):
        ns.Scene.load(written(tmp_path, "dt = 1e-3\ngravity = 0, 1\n"))


def test_functions_are_not_written(tmp_path):
    path = tmp_path / "scene.toml"
    for add in (
        lambda scene: scene.force("d", lambda t, bodies: (0.0, 0.0)),
        lambda scene: scene.kinematic(ns.Disc(0.1), motion=lambda t: (t, 0.0)),
        lambda scene: scene.body(ns.Disc(0.1), mass=1.0, material=ns.Material(mu=ns.Friction(lambda v: 0.3))),
    ):
        scene = ns.Scene(gravity=(0, -9.81))
        scene.body(ns.Disc(0.1), mass=1.0, name="d")
        add(scene)
        with pytest.raises(ns.InvalidInput, match="function"):
            scene.save(path)
        assert not path.exists()


def test_formulas_are_those_of_python():
    rng = np.random.default_rng(1)
    names = {"a": 1.5, "b": -2.0, "k": 3}
    for _ in range(300):
        text = "k"
        for _ in range(5):
            act = rng.choice(["+ {}", "- {}", "* {}", "/ {}", "** 2 - {}", "% {}", "// {}"])
            text = f"({text} {act.format(rng.choice(['a', 'b', '0.7', 'sqrt(2)', 'sin(a)', '-pi', 'max(a, b)']))})"
        allowed = {**names, "sqrt": math.sqrt, "sin": math.sin, "pi": math.pi, "max": max}
        assert value_of(text, names) == pytest.approx(eval(text, {"__builtins__": {}}, allowed), rel=1e-13)


def test_a_file_is_run_by_its_name_with_other_values(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    written(tmp_path, TOWER)
    assert main(["run", "tower.toml", "--set", "n=2", "--no-plot", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert "4 bodies, 3 of them dynamic" in json.dumps(said)
    assert main(["run", "tower.toml", "--set", "nn=2", "--no-plot"]) == 2
    assert "nn" in capsys.readouterr().err
