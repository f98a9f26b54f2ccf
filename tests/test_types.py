"""What a type checker sees: every public name, a user's script that passes, and mistakes that do not."""

import inspect
import re
import subprocess
import sys
import tomllib
import typing
from pathlib import Path

import jedi
import pytest

import nonsmooth as ns
from nonsmooth.catalogue import SpragSlip

pytestmark = pytest.mark.upkeep

STUB = Path(ns.__file__).with_name("__init__.pyi")
OF_CATALOGUE = (STUB.parent / "catalogue" / "__init__.pyi").read_text()
NAMES_OF_OURS = re.findall(r"^from (models\.\S+) import (\w+) as (\w+)$", OF_CATALOGUE, re.M)
ROOT = Path(__file__).parents[1]
SCRIPT = """
from typing import Any, NamedTuple

import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import PainleveRod, SpragSlip


class P(NamedTuple):
    m: float = 1.0
    g: float = 9.81


def mass(t: float, q: np.ndarray, p: Any, M: np.ndarray) -> None:
    M[0, 0] = p.m


def force(t: float, q: np.ndarray, u: np.ndarray, p: Any, h: np.ndarray) -> None:
    h[0] = -p.m * p.g


def gap(t: float, q: np.ndarray, p: Any, g_N: np.ndarray) -> None:
    g_N[0] = q[0]


ball = ns.System(
    coordinates=[("y", "m")], mass=mass, force=force, gap=gap, contacts=[ns.Contact(e_N=0.5, name="floor")],
    parameters=P(), name="ball",
)
sol = ns.simulate(ball, (0, 1), state=dict(y=1.0), integrator=ns.MoreauJean(dt=1e-3))
other = ns.simulate(ball, (0, 1), [1.0], [0.0], integrator="auto")
height: np.ndarray = sol["y"]
worst: float = sol.stats.worst_penetration
kinds = [event.kind for event in sol.events]
found = ns.classify(ball, 0.0, [0.0], [0.0])
number: int = found.n_solutions
scene = ns.Scene(gravity=(0, -9.81))
scene.body(ns.Disc(0.1), density=1000, position=(0, 0.5), name="disc")
rod = SpragSlip(mu=0.5)
falls = ns.simulate(rod, (0, 0.1), *rod.state(), integrator="auto")
forces: tuple[float, ...] = PainleveRod().normal_forces(0.8, 0.0, 1.0)
"""
SCENE_SCRIPT = """
import numpy as np

import nonsmooth as ns


class Tower:
    def scene(self) -> ns.Scene:
        made = ns.Scene(gravity=(0, -9.81))
        made.fixed(ns.HalfPlane((0, 1)))
        made.body(ns.Box(0.2, 0.2), density=1000, position=(0, 0.1), name="box")
        return made


scene = Tower().scene()
sol = ns.simulate(scene, (0, 1), integrator=ns.MoreauJean(dt=1e-3), record=["bodies"])
low: np.ndarray = sol["box"].position[:, 1]
names: list[str] = sol.names
between = sol.contacts().of("box")
table = sol.to_dataframe("contacts")
sol.save("run.npz")
later = ns.SceneSolution.load("run.npz", scene)
built = ns.simulate(Tower(), (0, 1), integrator="auto", t_eval=np.linspace(0, 1, 5))
deep: float = built.stats.worst_penetration
print(len(built.contacts()), later.names, [event for event in sol.events])
"""
WRONG_OF_SCENES = {
    "sol.g_N": "attr-defined",
    "built.contact()": "attr-defined",
    'sol["box"].positions': "attr-defined",
}
WRONG = {
    'ns.simulate(ball, (0, 1), [1.0], [0.0], integrator="autoo")': "call-overload",
    "sol.plott()": "attr-defined",
    "ns.simulat(ball)": "attr-defined",
    "ns.Contact(e_n=0.5)": "call-arg",
    "ns.simulate(ball, (0, 1), integrator=ns.MoreauJean(dt=1e-3), ever=2)": "call-overload",
    "sol.stats.step": "attr-defined",
    "SpragSlip(thh=1.0)": "call-arg",
    "PainleveRod().staet()": "attr-defined",
}


@pytest.fixture(scope="module")
def complaints(tmp_path_factory):
    """Of mypy --strict, (line, code), each once, about both scripts with their mistakes."""
    pytest.importorskip("mypy")
    folder = tmp_path_factory.mktemp("scripts")
    (folder / "script.py").write_text(SCRIPT + "\n".join(WRONG) + "\n")
    (folder / "of_scenes.py").write_text(SCENE_SCRIPT + "\n".join(WRONG_OF_SCENES) + "\n")
    words = [sys.executable, "-m", "mypy", "--strict", "--ignore-missing-imports", "--config-file", ""]
    ended = subprocess.run(
        [*words, "script.py", "of_scenes.py"], cwd=folder, capture_output=True, text=True, timeout=500
    )

    def about(name):
        found = re.findall(rf"^{name}.py:(\d+): error: .*\[(.*)\]$", ended.stdout, re.M)
        return [(int(line), code) for line, code in dict.fromkeys(found)]

    return about


def test_the_stub_has_every_public_name_from_where_it_is_loaded():
    rows = re.findall(r"^from nonsmooth\.(\S+) import (\w+) as (\w+)$", STUB.read_text(), re.M)
    assert all(name == as_name for _, name, as_name in rows) and len(rows) == len(ns._HOME)
    assert {name: home for home, name, _ in rows} == ns._HOME


def test_no_public_type_is_without_its_parameters():
    """A bare Callable or dict is of unknown type for pyright's strict mode, and so is every call of its function."""
    bare = re.compile(r"\b(Callable|Sequence|Mapping|Iterator|Iterable|Future|dict|list|tuple|set)\b(?!\[)")
    found = []
    for name in ns._HOME:
        public = getattr(ns, name)
        members = inspect.getmembers(public, inspect.isfunction)
        own = [function for word, function in members if not word.startswith("_") or word == "__init__"]
        for function in [public] if inspect.isfunction(public) else own:
            types = {word: str(written) for word, written in function.__annotations__.items()}
            found += [
                f"{name}.{function.__name__}({word}: {types[word]})" for word in types if bare.search(types[word])
            ]
    assert found == []


def test_types_come_with_the_package():
    assert STUB.with_name("py.typed").is_file() and (ROOT / "models" / "py.typed").is_file()


def test_the_stub_of_the_catalogue_has_every_class_of_ours():
    rows = NAMES_OF_OURS
    groups = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["entry-points"]
    ours = {*groups["nonsmooth.models"].values(), *groups["nonsmooth.scenes"].values()}
    assert all(name == as_name for _, name, as_name in rows)
    assert {f"{module}:{name}" for module, name, _ in rows} == ours


def test_what_a_checker_sees_of_simulate_is_what_it_takes():
    """Its arguments of a scene are those of a system without the ones that a scene refuses."""
    own = inspect.signature(ns.simulate).parameters
    of_scene, of_system = (inspect.signature(form).parameters for form in typing.get_overloads(ns.simulate))
    assert list(of_system) == list(own) and {**of_scene}.keys() == own.keys() - {"q0", "u0", "state", "selection"}
    for seen in (of_scene, of_system):
        assert all(seen[name].default == own[name].default and seen[name].kind == own[name].kind for name in seen)


def test_a_script_of_scenes_passes_and_its_mistakes_do_not(complaints):
    lines = len(SCENE_SCRIPT.splitlines())
    assert complaints("of_scenes") == [(lines + 1 + k, code) for k, code in enumerate(WRONG_OF_SCENES.values())]


def test_a_users_script_passes_and_its_mistakes_do_not(complaints):
    lines = len(SCRIPT.splitlines())
    assert complaints("script") == [(lines + 1 + k, code) for k, code in enumerate(WRONG.values())]


ENDS = [
    ("ns.", {*ns._HOME, "catalogue"}),
    ("ns.MoreauJean(", {f"{option}=" for option in inspect.signature(ns.MoreauJean).parameters}),
    ("ns.simulate(ball, (0, 1), ", {"integrator=", "t_eval=", "selection=", "record="}),
    ("ns.simulate(ball, (0, 1), [1.0], [0.0], integrator=ns.MoreauJean(dt=1e-3)).", {"g_N", "mode", "to_xarray"}),
    ("ns.simulate(scene, (0, 1), integrator=ns.MoreauJean(dt=1e-3)).", {"contacts", "to_dataframe"}),
    ("ns.Solution.load('run.npz').stats.", {"steps", "worst_penetration"}),
    ("scene.", {"body", "fixed", "joint", "kinematic", "pair"}),
    ("catalogue.", {name for _, _, name in NAMES_OF_OURS} | {"load"}),
    ("catalogue.SpragSlip().", {"critical_friction", "state", "mu", "cth"}),
    ("catalogue.SpragSlip(", {f"{name}=" for name in inspect.signature(SpragSlip).parameters}),
    ("ns.limit_cycle(catalogue.SpragSlip()).", {"period", "multipliers", "plot"}),
    ("ns.classify(ball, 0.0, [0.0], [0.0]).", {"n_solutions", "kind", "solutions"}),
]  # fmt: skip
DECLARED = """
import nonsmooth as ns
from nonsmooth import catalogue

ball: ns.System
scene = ns.Scene(gravity=(0, -9.81))
"""


@pytest.mark.parametrize(("typed", "expected"), ENDS, ids=lambda one: one if isinstance(one, str) else "")
def test_an_editor_completes_without_running_anything(typed, expected, tmp_path):
    """Jedi, as in IPython, Jupyter and many editors, on a script that is not executed."""
    script = jedi.Script(DECLARED + typed, path=tmp_path / "script.py", environment=jedi.InterpreterEnvironment())
    assert not expected - {found.name for found in script.complete()}
