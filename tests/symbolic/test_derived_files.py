"""The sources that are written: kept by content, read, edited and saved; and what SymPy is needed for."""

from __future__ import annotations

import importlib.util
import math
import os
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

sp = pytest.importorskip("sympy", reason="energies need SymPy, the extra [symbolic]")

import nonsmooth as ns  # noqa: E402
from nonsmooth.jit import call_model, compile_model, kernel  # noqa: E402
from nonsmooth.mechanics.system import FORCE, MASS, TAKES_U  # noqa: E402
from nonsmooth.symbolic import generated, model_file  # noqa: E402

SCRIPT = """
import sympy as sp, nonsmooth as ns
l = ns.lagrangian("pendulum at a wall")
th1, th2 = l.coordinates("th1 th2", unit="rad")
m, a, g, mu = l.parameters(m=(1.0, "kg", "mass of a bob"), a=(0.5, "m"), g=(9.81, "m/s^2"), mu=0.3)
knee = (a * sp.sin(th1), -a * sp.cos(th1))
tip = (knee[0] + a * sp.sin(th2), knee[1] - a * sp.cos(th2))
l.point_mass(m, at=knee)
l.point_mass(m, at=tip)
l.gravity(g)
l.contact(point=tip, normal=(-1, 0), offset=0.6, mu=mu, e=0.5)
l.line((0, 0), knee, tip)
l.line((0.6, -1), (0.6, 0))
"""
QUIET = {"PYTHONDONTWRITEBYTECODE": "1"}


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("NONSMOOTH_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache" / "models"


def pendulum(**changes):
    scope: dict = {}
    exec(SCRIPT, scope)
    return scope["l"]


def in_a_process(code, **environment):
    ended = subprocess.run(
        [sys.executable, "-c", code], env=os.environ | QUIET | environment, capture_output=True, text=True, timeout=120
    )
    assert ended.returncode == 0, ended.stderr
    return ended.stdout


def imported(file):
    spec = importlib.util.spec_from_file_location(file.stem, file)
    module = importlib.util.module_from_spec(spec)
    sys.modules[file.stem] = module
    spec.loader.exec_module(module)
    return module


def test_a_rerun_derives_nothing(cache, monkeypatch):
    first = pendulum().model()
    monkeypatch.setattr(model_file, "Writer", lambda *_: pytest.fail("derived again"))
    again = pendulum().model()
    assert type(again) is type(first) and len(list(cache.glob("*.py"))) == 1


def test_another_declaration_is_another_file(cache):
    first = pendulum().model()
    other = pendulum()
    other.contact(point=(0.3 * sp.sin(other.declared.q[0]), 0), normal=(1, 0))
    assert "contact" in first.source() and len({type(first), type(other.model())}) == 2
    assert len(list(cache.glob("*.py"))) == 2


def test_a_kept_file_that_was_edited_or_damaged_is_written_anew(cache):
    pendulum().model()
    (file,) = cache.glob("*.py")
    good = file.read_text()
    for bad in (good.replace("math.sin", "math.cos"), good[: len(good) // 2], "", "raise SystemExit"):
        file.write_text(bad)
        pendulum().model()
        assert file.read_text() == good


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="rights of files are kept elsewhere")
def test_a_file_that_others_may_write_is_not_run(cache):
    pendulum().model()
    (file,) = cache.glob("*.py")
    file.chmod(0o666)
    pendulum().model()
    assert not file.stat().st_mode & 0o022


@pytest.mark.upkeep
def test_the_source_is_the_same_in_every_process(cache):
    code = SCRIPT + "print(l.model().source())"
    sources = [in_a_process(code, PYTHONHASHSEED=seed, NONSMOOTH_CACHE_DIR=str(cache / seed)) for seed in "12"]
    assert sources[0] == sources[1] and "def mass(t, q, p, M):" in sources[0]


def test_the_source_says_its_equation_and_units():
    source = pendulum().model().source()
    for words in ("M u' = h + W_N^T la_N", "q = (th1 [rad], th2 [rad])", "m: float = 1.0  # mass of a bob [kg]",
                  "g_N[0] = ", "# K = -dh/dq", "V += g*m*r"):  # fmt: skip
        assert words in source, words
    assert max(map(len, source.splitlines())) <= 120


@pytest.mark.parametrize("drawn", ["moves", "stands", "both"])
def test_a_model_is_drawn_with_the_lines_that_it_has(drawn):
    """A spring and a wall: what has no such line has no such method, so that nothing is asked for lines."""
    l = ns.lagrangian(f"spring that {drawn}")  # noqa: E741 - the letter of Lagrange, as users write it
    x = l.coordinates("x", unit="m")
    l.point_mass(1.0, at=(x, 0))
    (k,) = l.parameters(k=(1.0, "N/m"))
    l.potential(k * x**2 / 2)
    if drawn != "stands":
        l.line((x, 0), (x, 1))
    if drawn != "moves":
        l.line((-1, 0), (-1, 1))
    model = l.model()
    sol = ns.simulate(model, (0, 1), state={"x": 1.0}, integrator=ns.MoreauJean(dt=1e-2))
    assert (hasattr(model, "shape"), hasattr(model, "outline")) == (drawn != "stands", drawn != "moves")
    if drawn == "stands":
        with pytest.raises(ns.InvalidInput, match=r"no shape\(q\)"):
            sol.picture()
    else:
        assert len(sol.picture(n=2).axes[0].lines) == 2 + (drawn == "both")


@pytest.mark.upkeep
def test_a_saved_model_needs_no_sympy_and_an_edit_of_it_counts(tmp_path):
    model = pendulum().model()
    file = model.save(tmp_path / "my_pendulum.py")
    run = (
        f"import sys; sys.modules['sympy'] = None; sys.path.insert(0, {str(tmp_path)!r})\n"
        "import nonsmooth as ns; from my_pendulum import PendulumAtAWall\n"
        "model = PendulumAtAWall()\n"
        "sol = ns.simulate(model, (0, 0.3), *model.state(th1=0.3, th1dot=3.0), integrator=ns.MoreauJean(dt=1e-3))\n"
        "print(repr(float(sol.q[-1, 0])))"
    )
    here = ns.simulate(model, (0, 0.3), *model.state(th1=0.3, th1dot=3.0), integrator=ns.MoreauJean(dt=1e-3)).q[-1, 0]
    assert float(in_a_process(run)) == here
    file.write_text(file.read_text().replace("0.6", "0.25"))  # the wall is nearer: it is struck
    assert float(in_a_process(run)) != here


def test_a_saved_model_edited_in_this_process_is_compiled_anew(tmp_path):
    model = pendulum().model()
    for k, wall in enumerate(("0.6", "0.25")):
        file = model.save(tmp_path / f"pendulum_{k}.py")
        file.write_text(file.read_text().replace("0.6", wall))
        edited = imported(file).PendulumAtAWall()
        sol = ns.simulate(edited, (0, 0.3), *edited.state(th1=0.3, th1dot=2.0), integrator=ns.MoreauJean(dt=1e-3))
        assert sol.g_N.min() > -0.01 and (sol.P_N.any() == (wall == "0.25"))


@pytest.mark.parametrize(
    ("path", "words"), [("model.txt", "must end in .py"), ("my model.py", "can be imported"), (3, "name of a file")]
)
def test_a_name_that_cannot_be_imported_is_refused(path, words):
    with pytest.raises(ns.InvalidInput, match=words):
        pendulum().model().save(path)


def test_a_folder_that_is_not_there_is_a_file_failure(tmp_path):
    with pytest.raises(ns.FileFailure, match="cannot be written"):
        pendulum().model().save(tmp_path / "nowhere" / "model.py")


def test_another_process_finds_a_model_that_is_sent_to_it(cache, tmp_path):
    (tmp_path / "model.pickle").write_bytes(pickle.dumps(pendulum().model()))
    code = f"import pickle; print(pickle.load(open({str(tmp_path / 'model.pickle')!r}, 'rb')).state(th1=1.0)[0])"
    assert in_a_process(code, NONSMOOTH_CACHE_DIR=str(cache.parent)).strip() == "[1. 0.]"


def test_a_cache_that_cannot_be_written_still_gives_a_model(tmp_path, monkeypatch):
    monkeypatch.setattr(generated, "usable", lambda folder: False)
    assert pendulum().model(t_end=2.0).t_end == 2.0


@kernel
def evaluate(model, which, t, q, u, p, out):
    return call_model(model, which, t, q, u, p, out)


def test_compiled_and_interpreted_functions_of_a_derived_model_agree():
    system = pendulum().model().system()
    functions = {which: (f, which in TAKES_U, system.shape_of(which)) for which, f in system.functions.items()}
    compiled = compile_model(functions, system.n_q, system.n_u, system.unpack, system.p.size)
    q, u = np.array([0.3, -0.8]), np.array([1.0, 2.0])
    for which in functions:
        out = np.zeros(system.shape_of(which))
        assert evaluate(compiled.address, which, 0.0, q, u, system.p, out.reshape(-1))
        np.testing.assert_allclose(out, system.evaluate(which, 0.0, q, u), rtol=1e-14, atol=1e-14)


def test_every_tool_takes_a_derived_model(tmp_path):
    model = pendulum().model()
    with pytest.warns(ns.FrictionGainWarning):  # Newton's law: the slide of its impact is reversed on the way
        sol = ns.simulate(model, (0, 1), *model.state(th1=0.3, th1dot=4.0), integrator=ns.EventDriven())
    assert sol.success and len(sol.events) > 0
    q = [0.6435011087932844, 0.6435011087932844]  # both links at arcsin 0.6: the tip touches
    assert ns.classify(model, 0.0, q, [0.0, 0.0]).n_solutions >= 1
    kept = ns.classify(model, 0.0, q, [0.0, 0.0]).solutions[0]
    assert np.isfinite(kept.la_N).all()
    chart = ns.paradox_map(model, th1=[0.2, 0.6], mu=[0.1, 2.0])
    assert chart.sizes["th1"] == 2
    assert [line.shape for line in model.shape(sol.q[0])] == [(3, 2)] and model.outline()[0].shape == (2, 2)
    task = ns.RunTask(model, t_span=(0, 0.1), integrator=ns.MoreauJean(dt=1e-3), state={"th1": 0.5})
    swept = ns.sweep(task, {"m": [1.0, 2.0]}, progress=False)
    assert swept.sizes["m"] == 2


def test_jacobians_can_be_left_out():
    system = pendulum().model(jacobians=False).system()
    assert system.stiffness is None and system.damping is None and system.reads(FORCE, "u") and system.reads(MASS, "q")


def test_nothing_but_energies_imports_sympy():
    in_a_process(
        "import sys, nonsmooth as ns\nfor name in ns.__all__: getattr(ns, name)\n"
        "import nonsmooth.symbolic.derived_model\nassert 'sympy' not in sys.modules"
    )
    root = Path(ns.__file__).parent
    importing = [f for f in root.rglob("*.py") if "import sympy" in f.read_text() or "from sympy" in f.read_text()]
    assert {f.relative_to(root).parts[0] for f in importing} == {"symbolic"}


def test_without_sympy_energies_say_which_extra_they_need():
    in_a_process(
        "import sys; sys.modules['sympy'] = None\nimport nonsmooth as ns\n"
        "try: ns.lagrangian('a')\nexcept ns.MissingExtra as error: assert 'nonsmooth[symbolic]' in str(error)\n"
        "else: raise AssertionError"
    )


def leine(v, p):
    """Leine's law, with numbers that are parameters of the model."""
    return p.mu / (1.0 + p.slope * v)


def slider(law, **contact):
    l = ns.lagrangian("slider")
    x, y = l.coordinates("x y", unit="m")
    m, g, *_ = l.parameters(m=(2.0, "kg"), g=(10.0, "m/s^2"), mu=0.3, slope=(3.0, "s/m"))
    l.point_mass(m, at=(x, y))
    l.gravity(g)
    l.contact(point=(x, y), normal=(0, 1), mu=law, **contact)
    return l.model()


LAWS = {
    "def": ns.Friction(leine),
    "lambda": ns.Friction(lambda v, p: p.mu / (1.0 + p.slope * v)),
    "speed alone": ns.Friction(lambda v: 0.3 * math.exp(-math.log(1.0 + 3.0 * v))),
}


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_a_friction_law_of_the_users_is_a_part_of_the_source(law, tmp_path):
    """v' = -g mu/(1 + 3 v): v + 3/2 v^2 falls by g mu t."""
    model = slider(law, name="sole")
    model.save(tmp_path / "saved_slider.py")
    for made in (model, imported(tmp_path / "saved_slider.py").Slider()):
        sol = ns.simulate(made, (0, 0.2), state={"xdot": 1.0}, integrator=ns.Adaptive(rtol=1e-9, atol=1e-9))
        v = sol.u[-1, 0]
        assert v + 1.5 * v * v == pytest.approx(2.5 - 10.0 * 0.3 * 0.2, rel=1e-8)
        assert sol.described.contacts == ("sole",)


def test_a_law_that_reads_what_the_source_has_not_is_refused():
    outside = 0.4
    with pytest.raises(ns.InvalidInput, match=r"law Friction\(<lambda>\) reads outside, .* make it a parameter"):
        slider(ns.Friction(lambda v: outside / (1 + v)))
    scope: dict = {}
    exec("def mute(v):\n    return 0.3", scope)
    with pytest.raises(ns.InvalidInput, match=r"source of the friction law Friction\(mute\) cannot be read; write it"):
        slider(ns.Friction(scope["mute"]))


def test_a_line_that_moves_with_time_is_drawn_at_its_beginning_and_a_warning_says_so():
    l = ns.lagrangian("mass at a shaken wall")  # noqa: E741 - the letter of Lagrange, as users write it
    x = l.coordinates("x", unit="m")
    l.point_mass(1.0, at=(x, 0))
    a, rate = l.parameters(a=(0.25, "m"), rate=(3.0, "1/s"))
    wall = a * (1 + sp.sin(rate * l.t))
    with pytest.warns(ns.NonsmoothWarning, match="move with time: pictures draw them where they are at t = 0"):
        l.line((wall, 0), (wall, 1))
    assert l.model().outline()[0].tolist() == [[0.25, 0.0], [0.25, 1.0]]
