"""No run takes the numbers of another one: what a force reads is told by its content, or nothing is taken from before.

Each way to hold a number, 2 or 3, is tried at each door through which something of an earlier run may come in: machine
code, the system of a model, checkpoints and journals. The force is that number, so that a body of 1 kg that begins at
rest has it as its speed after 1 s.
"""

import os
import types

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.jit.content import identity
from nonsmooth.jit.fingerprint import Unidentified

pytestmark = pytest.mark.upkeep

ONE, OTHER = 2.0, 3.0


def force_is(expression, before=""):
    return f"{before}\ndef force(t, q, u, p, h):\n    h[0] = {expression}\n"


C = "class C:\n    def __init__(self):\n        self.k = NUMBER\n"
TOLD = {
    "number": force_is("NUMBER"),
    "global": force_is("K", "K = NUMBER"),
    "default": "def force(t, q, u, p, h, k=NUMBER):\n    h[0] = k",
    "keyword default": "def force(t, q, u, p, h, *, k=NUMBER):\n    h[0] = k",
    "variable of the function around": "def around(k):\n    def force(t, q, u, p, h):\n        h[0] = k\n"
    "    return force\nforce = around(NUMBER)",
    "helper": force_is("k()", "def k():\n    return NUMBER"),
    "lambda in a list": force_is("K[1]()", "K = [abs, lambda: NUMBER]"),
    "attribute of a function": force_is("k.of", "def k():\n    pass\nk.of = NUMBER"),
    "attribute of itself": "def force(t, q, u, p, h):\n    h[0] = force.k\nforce.k = NUMBER",
    "helper that remembers": force_is("k()", "import functools\n@functools.lru_cache\ndef k():\n    return NUMBER"),
    "decorated helper": force_is("k()", "import functools\ndef twice(f):\n    @functools.wraps(f)\n    def g():\n"
                                 "        return NUMBER * f()\n    return g\n@twice\ndef k():\n    return 1.0"),
    "partial": "import functools\ndef general(k, t, q, u, p, h):\n    h[0] = k\n"
    "force = functools.partial(general, NUMBER)",
    "partial by name": "import functools\ndef general(t, q, u, p, h, k):\n    h[0] = k\n"
    "force = functools.partial(general, k=NUMBER)",
    "partial of a method": f"import functools\n{C}    def general(self, a, t, q, u, p, h):\n        h[0] = self.k\n"
    "force = functools.partial(C().general, 1)",
    "method": f"{C}    def general(self, t, q, u, p, h):\n        h[0] = self.k\nforce = C().general",
    "method of a class": "class C:\n    k = NUMBER\n    @classmethod\n    def general(cls, t, q, u, p, h):\n"
    "        h[0] = cls.k\nforce = C.general",
    "method of a list": force_is("k(0)", "k = [NUMBER].__getitem__"),
    "object that is called": f"{C}    def __call__(self, t, q, u, p, h):\n        h[0] = self.k\nforce = C()",
    "code of an object that is called": "class C:\n    def __call__(self, t, q, u, p, h):\n        h[0] = NUMBER\n"
    "force = C()",
    "object": force_is("c.k", C + "c = C()"),
    "object in an object": force_is("d.c.k", C + "class D:\n    pass\nd = D()\nd.c = C()"),
    "object that holds itself": force_is("c.me.k", C + "c = C()\nc.me = c"),
    "slot": force_is("c.k", "class C:\n    __slots__ = ('k',)\nc = C()\nc.k = NUMBER"),
    "attribute of a class": force_is("c.k", "class C:\n    k = NUMBER\nc = C()"),
    "attribute of a class below": force_is("D.k", "class C:\n    k = NUMBER\nclass D(C):\n    pass"),
    "attribute of a metaclass": force_is("C.k", "class M(type):\n    k = NUMBER\nclass C(metaclass=M):\n    pass"),
    "property": force_is("c.k", "class C:\n    @property\n    def k(self):\n        return NUMBER\nc = C()"),
    "property that remembers": force_is("c.k", "import functools\nclass C:\n    @functools.cached_property\n"
                                        "    def k(self):\n        return NUMBER\nc = C()"),
    "attribute that an object makes": force_is("c.k", "class C:\n    def __getattr__(self, name):\n"
                                               "        return NUMBER\nc = C()"),
    "attribute by its name": force_is("getattr(c, 'k')", C + "c = C()"),
    "descriptor": force_is("c.k", "class D:\n    def __get__(self, of, cls):\n        return NUMBER\nclass C:\n"
                           "    k = D()\nc = C()"),
    "operator of a class": force_is("c * 1", "class C:\n    def __mul__(self, x):\n        return NUMBER\nc = C()"),
    "dataclass": force_is("c.k", "import dataclasses\n@dataclasses.dataclass\nclass C:\n    k: float\nc = C(NUMBER)"),
    "NamedTuple": force_is("c.k", "from typing import NamedTuple\nclass C(NamedTuple):\n    k: float\nc = C(NUMBER)"),
    "method of a NamedTuple": force_is("c.k()", "from typing import NamedTuple\nclass C(NamedTuple):\n    j: float\n"
                                       "    def k(self):\n        return NUMBER\nc = C(1.0)"),
    "enumeration": force_is("C.A.value", "import enum\nclass C(enum.Enum):\n    A = NUMBER"),
    "method of an enumeration": force_is("C.A.k()", "import enum\nclass C(enum.Enum):\n    A = 1\n    def k(self):\n"
                                         "        return NUMBER"),
    "list": force_is("K[0]", "K = [NUMBER]"),
    "long list": force_is("K[5000]", "K = [0.0] * 10000\nK[5000] = NUMBER"),
    "dict": force_is("K['k']", "K = {'k': NUMBER}"),
    "set": force_is("max(K)", "K = {1.0, 'a' and NUMBER}"),
    "list in a dict": force_is("K['k'][1]", "K = {'k': (0.0, [0.0, NUMBER][0:], [0.0])[1]}"),
    "dict of its own kind": force_is("K['k']", "class D(dict):\n    pass\nK = D(k=NUMBER)"),
    "number of its own kind": force_is("float(K)", "class F(float):\n    pass\nK = F(NUMBER)"),
    "array": force_is("K[0]", "import numpy as np\nK = np.array([NUMBER])"),
    "long array": force_is("K[50000]", "import numpy as np\nK = np.zeros(100000)\nK[50000] = NUMBER"),
    "array with gaps": force_is("K[25000]", "import numpy as np\nK = np.zeros(100000)[::2]\nK[25000] = NUMBER"),
    "array of objects": force_is("K[0]", "import numpy as np\nK = np.array([NUMBER, None])"),
    "long array in a list": force_is("K[0][5000]", "import numpy as np\nK = [np.zeros(10000)]\nK[0][5000] = NUMBER"),
    "long array of an object": force_is("c.a[5000]", "import numpy as np\nclass C:\n    pass\nc = C()\n"
                                        "c.a = np.zeros(10000)\nc.a[5000] = NUMBER"),
    "long array in a partial": "import functools\nimport numpy as np\ndef general(a, t, q, u, p, h):\n"
    "    h[0] = a[5000]\na = np.zeros(10000)\na[5000] = NUMBER\nforce = functools.partial(general, a)",
    "object of Python": force_is("K.numerator", "from fractions import Fraction\nK = Fraction(int(NUMBER), 7)"),
    "queue": force_is("K[0]", "from collections import deque\nK = deque([NUMBER])"),
    "polynomial of numpy": force_is("K(1.0)", "import numpy as np\nK = np.polynomial.Polynomial([NUMBER])"),
    "generator of numpy": force_is("K.bit_generator.state['state']['state'] % 1000 % 7 + 0.0 * NUMBER",
                                   "import numpy as np\n"
                                   "K = np.random.default_rng(int(NUMBER))"),
    "object of scipy": force_is("K(0.5)", "from scipy.interpolate import CubicSpline\n"
                                "K = CubicSpline([0.0, 1.0, 2.0, 3.0], [NUMBER] * 4)"),
    "import of a library as it runs": "def force(t, q, u, p, h):\n    import math\n    h[0] = math.fabs(NUMBER)",
    "numbers of the machine": force_is("NUMBER + 0.0 * sys.float_info.min * len(os.sep)", "import os, sys"),
    "version": "import os\ndef force(t, q, u, p, h):\n    h[0] = float(os.environ['VARIABLE'])\n"
    "force.nonsmooth_version = 'NUMBER'",
    "version of an object that is called": "import os\nclass C:\n    nonsmooth_version = 'with NUMBER'\n"
    "    def __call__(self, t, q, u, p, h):\n        h[0] = float(os.environ['VARIABLE'])\nforce = C()",
    "file that is written": "from pathlib import Path\ndef write():\n    with open(Path('a') / 'b', 'a') as file:\n"
    "        file.write('c')\ndef force(t, q, u, p, h):\n    h[0] = NUMBER\n    if t < 0.0:\n        write()",
    "private method of an enumeration": force_is("C.A._k()", "import enum\nclass C(enum.Enum):\n    A = 1\n"
                                                 "    def _k(self):\n        return NUMBER"),
    "what nobody asks for": force_is("c.k", "import threading\n" + C + "        self.lock = threading.Lock()\n"
                                     "    def told(self):\n        return open('a').read()\nc = C()"),
}  # fmt: skip

UNTOLD = {
    "file": "def force(t, q, u, p, h):\n    with open('NUMBER') as file:\n        h[0] = float(file.read())",
    "file by its path": force_is("float(path.read_text())", "import pathlib\npath = pathlib.Path('NUMBER')"),
    "file by numpy": force_is("np.loadtxt('NUMBER')", "import numpy as np"),
    "file by numpy as it runs": "def force(t, q, u, p, h):\n    import numpy\n    h[0] = numpy.loadtxt('NUMBER')",
    "file by a class of this package": force_is("ns.Solution.load('NUMBER').t[0]", "import nonsmooth as ns"),
    "file by an imported class": force_is("Solution.load('NUMBER').t[0]", "from nonsmooth import Solution"),
    "file by a path that is handed on": force_is("k(path)", "from pathlib import Path\npath = Path('NUMBER')\n"
                                                 "def k(path):\n    return float(path.read_text())"),
    "file beside one that is written": "def force(t, q, u, p, h):\n    with open('a', 'a'), open('NUMBER') as f:\n"
    "        h[0] = float(f.read())",
    "member by a name that stands elsewhere": "import os\nNAME = 'k'\nclass C:\n    @property\n    def k(self):\n"
    "        return float(os.environ['VARIABLE'])\nc = C()" + force_is("getattr(c, NAME)"),
    "day": force_is("datetime.now().day", "from datetime import datetime"),
    "environment": force_is("float(os.environ['VARIABLE'])", "import os"),
    "environment by a function": force_is("float(getenv('VARIABLE'))", "from os import getenv"),
    "environment by a helper": force_is("k()", "import os\ndef k():\n    return float(os.environ['VARIABLE'])"),
    "environment by a property": force_is("c.k", "import os\nclass C:\n    @property\n    def k(self):\n"
                                          "        return float(os.environ['VARIABLE'])\nc = C()"),
    "numpy's one generator": force_is("np.random.rand()", "import numpy as np"),
    "Python's one generator": force_is("random.random()", "import random"),
    "time of the day": force_is("time.time()", "import time"),
    "generator": force_is("next(K)", "K = (x for x in (NUMBER,))"),
    "function of another language": force_is("k(1.0)", "import ctypes\nk = ctypes.CFUNCTYPE(ctypes.c_double, "
                                             "ctypes.c_double)(lambda x: NUMBER)"),
    "lock": force_is("c.lock.locked()", "import threading\nclass C:\n    lock = threading.Lock()\nc = C()"),
    "module by an argument": "import types\nm = types.ModuleType('m')\nm.k = NUMBER\n"
    + force_is("k(m)", "def k(m):\n    return m.k"),
    "attribute that a module makes": "import types\nclass M(types.ModuleType):\n    k = property(lambda self: NUMBER)\n"
    "m = M('m')\n" + force_is("m.k"),
    "global that it writes": "K = NUMBER\ndef force(t, q, u, p, h):\n    global K\n    h[0] = K\n    K = K + 0.0",
    "text from text": force_is("eval('NUMBER')"),
}  # fmt: skip


def made(text, number, monkeypatch):
    """The force of a module of this text."""
    monkeypatch.setenv("VARIABLE", repr(number))
    module = types.ModuleType("module_of_the_user")
    exec(compile(text.replace("NUMBER", repr(number)), "module_of_the_user.py", "exec"), vars(module))
    return module.force


def mass(t, q, p, M):
    M[0, 0] = 1.0


def system_of(force):
    return ns.System(n_q=1, mass=mass, force=force)


def speed(system, **files):
    """After 1 s, from rest."""
    run = ns.simulate(system, (0, 1), [1.0], [0.0], integrator=ns.MoreauJean(dt=0.5), progress=False, **files)
    return run.u[-1, 0]


def expected(force):
    h = np.zeros(1)
    force(0.0, np.ones(1), np.zeros(1), (), h)
    return h[0]


class Model:
    def __init__(self, force):
        self.force = force

    def system(self):
        return system_of(self.force)


# machine code and the systems of models


@pytest.mark.parametrize("name", TOLD)
@pytest.mark.filterwarnings("ignore::nonsmooth.InterpretedWarning")
def test_a_run_and_a_model_have_the_number_of_now(name, monkeypatch):
    model = Model(None)
    for number in (ONE, OTHER, ONE):
        model.force = made(TOLD[name], number, monkeypatch)
        truth = expected(model.force)
        assert speed(model) == speed(system_of(model.force)) == pytest.approx(truth, rel=1e-15)


# checkpoints


@pytest.fixture
def interpreted(monkeypatch):
    monkeypatch.setenv("NONSMOOTH_INTERPRET", "1")


@pytest.mark.parametrize("name", TOLD)
def test_a_checkpoint_is_of_one_content(name, tmp_path, monkeypatch, interpreted):
    path = tmp_path / "run"
    one, again, other = (made(TOLD[name], number, monkeypatch) for number in (ONE, ONE, OTHER))
    monkeypatch.setenv("VARIABLE", repr(ONE))
    assert speed(system_of(one), checkpoint=path) == expected(one)
    assert speed(system_of(again), resume=path) == expected(one)
    with pytest.raises(ns.InvalidInput, match="is of another run: its code of force differs"):
        speed(system_of(other), resume=path)


REFUSED_ANYWAY = {  # by the look at a start, which finds another number at each call
    "numpy's one generator", "Python's one generator", "time of the day", "generator", "file by an imported class",
    "file by a class of this package",
}  # fmt: skip


@pytest.mark.parametrize("name", sorted(UNTOLD.keys() - REFUSED_ANYWAY))
def test_what_cannot_be_told_has_no_checkpoint_but_by_a_version(name, tmp_path, monkeypatch, interpreted):
    monkeypatch.chdir(tmp_path)
    (tmp_path / repr(ONE)).write_text(repr(ONE))
    force = made(UNTOLD[name], ONE, monkeypatch)
    with pytest.raises(ns.InvalidInput, match="a checkpoint cannot tell this run from others: force reads .* give what "
                       'reads it a text that you change with it: f.nonsmooth_version = "1"'):  # fmt: skip
        speed(system_of(force), checkpoint=tmp_path / "run")
    assert not (tmp_path / "run" / "state.npz").exists()
    force.nonsmooth_version = "1"
    before = identity(force)
    force.nonsmooth_version = "2"
    assert identity(force) != before


# journals


class Task:
    """The force as a task of a sweep, and a run with it as another."""

    def __init__(self, force):
        self.force = force

    def __call__(self, x):
        return x * expected(self.force)


def task_of_runs(force):
    state = {"q0": [1.0], "u0": [0.0]}
    return ns.RunTask(system_of(force), "final_state", t_span=(0, 1), state=state, integrator=ns.MoreauJean(dt=0.5))


@pytest.mark.parametrize(("make", "axis"), [(Task, "x"), (task_of_runs, "dt")], ids=["function", "runs"])
@pytest.mark.parametrize("name", TOLD)
def test_a_journal_is_of_one_content(name, make, axis, tmp_path, monkeypatch, interpreted):
    path, axes = tmp_path / "journal", {axis: [0.25, 0.5]}
    one, again, other = (made(TOLD[name], number, monkeypatch) for number in (ONE, ONE, OTHER))
    monkeypatch.setenv("VARIABLE", repr(ONE))
    first, second = (ns.sweep(make(f), axes, journal=path, progress=False) for f in (one, again))
    assert second.attrs["cells_from_journal"] == 2 and second.equals(first)
    with pytest.raises(ns.InvalidInput, match="belongs to another study"):
        ns.sweep(make(other), axes, journal=path, progress=False)


@pytest.mark.parametrize("make", [Task, task_of_runs])
@pytest.mark.parametrize("name", UNTOLD)
def test_what_cannot_be_told_has_no_journal(name, make, tmp_path, monkeypatch, interpreted):
    task, axis = make(made(UNTOLD[name], ONE, monkeypatch)), {"x" if make is Task else "dt": [0.5]}
    with pytest.raises(ns.InvalidInput, match="a journal cannot tell this study from others: .* reads "):
        ns.sweep(task, axis, journal=tmp_path / "journal", progress=False)
    assert not (tmp_path / "journal").exists()


def test_every_number_of_the_table_is_told_from_the_other(monkeypatch):
    """And no way to hold it is another's: each content is its own."""
    found = {identity(made(text, number, monkeypatch)) for text in TOLD.values() for number in (ONE, OTHER)}
    assert len(found) == 2 * len(TOLD)
    for text in UNTOLD.values():
        with pytest.raises(Unidentified):
            identity(made(text, ONE, monkeypatch))


KEYS = "import sys; from tests.test_old_results import keys; print(keys())"


def keys():
    with pytest.MonkeyPatch.context() as patch:
        return [identity(made(text, ONE, patch)).hex() for text in TOLD.values()]


def test_contents_are_the_same_in_every_process():
    """With other seeds of Python's hashes and other addresses."""
    import subprocess
    import sys
    from pathlib import Path

    said = {
        subprocess.run([sys.executable, "-c", KEYS], cwd=Path(__file__).parents[1], capture_output=True, text=True,
                       check=True, timeout=120, env={**os.environ, "PYTHONHASHSEED": seed}).stdout
        for seed in ("1", "2")
    }  # fmt: skip
    assert len(said) == 1
