"""What a model function reads changes within a process: the next run is of the new value; nothing is compiled twice."""

import math
import subprocess
import sys
import types
from typing import NamedTuple

import numba
import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.jit import models
from nonsmooth.mechanics import shelf
from nonsmooth.mechanics.model_system import as_system
from nonsmooth.numerics.complex_step import complexified, jacobian

pytestmark = pytest.mark.upkeep


class P(NamedTuple):
    c: float = 1.0


def mass(t, q, p, M):
    M[0, 0] = 1.0


def model(text, **scope):
    """A system whose force is written as text, and the globals that it reads."""
    scope = {"__name__": "scene", "numba": numba, "np": np, "math": math, **scope}
    exec(text, scope)
    return ns.System(n_q=1, mass=mass, force=scope["force"], parameters=P()), scope


def force(expression):
    return f"def force(t, q, u, p, h):\n    h[0] = {expression}"


def speed(system):
    """From q = 1 and rest, after a second."""
    return ns.simulate(system, (0, 1), [1.0], [0.0], integrator=ns.MoreauJean(dt=1.0)).u[-1, 0]


@pytest.fixture
def compilings(monkeypatch):
    """The number of models compiled, or read from disk."""
    counted = []

    def count(*arguments):
        counted.append(arguments)
        return models.compile_model(*arguments)

    monkeypatch.setattr(shelf, "compile_model", count)
    return counted


def test_a_global_that_is_given_another_value_is_read_anew(compilings):
    system, scope = model(force("K * q[0]"), K=2.0)
    assert [speed(system), speed(system)] == [2.0, 2.0] and len(compilings) == 1
    scope["K"] = 3.0
    assert [speed(system), speed(system)] == [3.0, 3.0] and len(compilings) == 2


def test_an_equal_value_in_another_object_is_no_reason_to_compile(compilings):
    system, scope = model(force("K * T[1] * A[0] * q[0]"), K=2.0, T=(1.0, 2.0), A=np.array([1.0]))
    assert speed(system) == 4.0
    scope.update(K=float("2"), T=(1.0, float("2")), A=np.array([1.0]))
    assert speed(system) == 4.0 and len(compilings) == 1
    scope["K"] = 2  # an integer is another thing to machine code
    assert speed(system) == 4.0 and len(compilings) == 2


def test_systems_of_the_same_functions_share_what_was_compiled(compilings):
    system, scope = model(force("K * p.c * q[0]"), K=2.0)
    assert speed(system) == 2.0 and speed(system.with_parameters(c=5.0)) == 10.0 and len(compilings) == 1
    scope["K"] = 3.0
    assert speed(system.with_parameters(c=5.0)) == 15.0 and speed(system) == 3.0 and len(compilings) == 2


def test_the_constant_of_a_module_is_read_anew():
    hh, pk = types.ModuleType("hh"), types.ModuleType("pk")
    pk.c = types.ModuleType("pk.c")
    hh.K = pk.c.K = 2.0
    system, _ = model(force("hh.K * pk.c.K * q[0]"), hh=hh, pk=pk)
    assert speed(system) == 4.0
    hh.K = 3.0
    assert speed(system) == 6.0
    pk.c.K = 5.0
    assert speed(system) == 15.0
    pk.c = hh
    assert speed(system) == 9.0


def test_a_module_that_is_given_a_class_makes_what_is_read_from_it():
    class Made(types.ModuleType):
        K = property(lambda self: 3.0)

    hh = types.ModuleType("hh")
    hh.K = 2.0
    system, _ = model(force("hh.K * q[0]"), hh=hh)
    assert speed(system) == 2.0
    hh.__class__ = Made
    with pytest.warns(ns.InterpretedWarning, match="force reads hh.K, which its module may make when it is read"):
        assert speed(system) == hh.K == 3.0
    hh.__class__ = types.ModuleType
    assert speed(system) == 2.0


def test_a_helper_that_is_replaced_is_called_anew():
    hh = types.ModuleType("hh")
    hh.k = numba.njit(lambda x: 2.0 * x)
    system, scope = model(force("hh.k(q[0]) + j(q[0])"), hh=hh, j=lambda x: x)
    assert speed(system) == 3.0
    hh.k = numba.njit(lambda x: 3.0 * x)
    assert speed(system) == 4.0
    scope["j"] = lambda x: 7.0 * x
    assert speed(system) == 10.0
    scope["j"].__code__ = (lambda x: 9.0 * x).__code__
    assert speed(system) == 12.0
    scope["j"].__defaults__ = (0.5,)
    scope["j"].__code__ = (lambda x, a=1.0: a * x).__code__
    assert speed(system) == 3.5


COMPILED = {
    "njit": "@numba.njit\ndef k(x):\n    return K * x\n",
    "njit with a signature": "@numba.njit('float64(float64)')\ndef k(x):\n    return K * x\n",
    "njit of an njit": "@numba.njit\ndef j(x):\n    return K * x\n@numba.njit\ndef k(x):\n    return j(x)\n",
    "vectorize": "@numba.vectorize\ndef k(x):\n    return K * x\n",
    "vectorize with a signature": "@numba.vectorize(['float64(float64)'])\ndef k(x):\n    return K * x\n",
    "cfunc": "@numba.cfunc('float64(float64)')\ndef k(x):\n    return K * x\n",
}


@pytest.mark.parametrize("name", COMPILED)
def test_a_helper_that_numba_compiled_before_the_change_is_compiled_again(name):
    """Numba itself keeps the value of then."""
    system, scope = model(COMPILED[name] + force("k(q[0])"), K=2.0)
    assert scope["k"](1.0) == 2.0 and speed(system) == 2.0
    scope["K"] = 3.0
    assert speed(system) == 3.0


def test_a_generalised_helper_and_one_of_a_module_are_compiled_again():
    hh = types.ModuleType("hh")
    exec("import numba\nK = 2.0\n@numba.njit\ndef k(x):\n    return K * x", vars(hh))
    text = """
@numba.guvectorize(["void(float64[:], float64[:])"], "(n)->(n)")
def each(x, y):
    for i in range(x.shape[0]):
        y[i] = K * x[i]
def force(t, q, u, p, h):
    each(q, h)
    h[0] += hh.k(q[0])
"""
    system, scope = model(text, K=2.0, hh=hh)
    assert hh.k(1.0) == 2.0 and speed(system) == 4.0
    hh.K = 3.0
    assert speed(system) == 5.0
    scope["K"] = 7.0
    assert speed(system) == 10.0


@pytest.mark.parametrize("size", [3, 200_000])
def test_an_array_that_is_written_to_is_read_anew(size):
    """A large one is read in place."""
    table = np.ones(size)
    system, _ = model(force("K[1] * K[-1] * q[0]"), K=table)
    assert speed(system) == 1.0
    table[1] = 3.0
    assert speed(system) == 3.0
    table[-1] = 5.0
    assert speed(system) == 15.0


def test_an_array_with_gaps_is_read_in_place_and_anew_where_it_moves():
    whole = np.array([1.0, 0.0, 2.0, 0.0, 3.0, 0.0])
    system, scope = model(force("K[1] * q[0]"), K=whole[::2])
    assert speed(system) == 2.0
    whole[2] = 5.0
    assert speed(system) == 5.0
    scope["K"] = whole[::4]
    assert speed(system) == 3.0


def test_an_array_within_a_tuple_and_one_that_is_closed_over_are_read_anew():
    class T(NamedTuple):
        a: np.ndarray

    inner, table = np.ones(2), np.ones(2)

    def k(x):
        return table[1] * x

    system, _ = model(force("K[0].a[1] * k(q[0])"), K=(T(inner),), k=k)
    assert speed(system) == 1.0
    inner[1] = 3.0
    assert speed(system) == 3.0
    table[1] = 2.0
    assert speed(system) == 6.0


def test_a_variable_of_the_function_around_is_read_anew():
    def around():
        gain = 2.0

        def force(t, q, u, p, h):
            h[0] = gain * q[0]

        def change(value):
            nonlocal gain
            gain = value

        return force, change

    function, change = around()
    system = ns.System(n_q=1, mass=mass, force=function)
    assert speed(system) == 2.0
    change(3.0)
    assert speed(system) == 3.0


def test_a_global_that_hides_a_builtin_is_seen():
    system, scope = model(force("abs(-2.0) * q[0]"))
    assert speed(system) == 2.0
    scope["abs"] = lambda x: x
    assert speed(system) == -2.0
    del scope["abs"]
    assert speed(system) == 2.0


def test_what_cannot_be_compiled_is_tried_again_after_a_change_only(compilings):
    system, scope = model(force("k(q[0])"), k=lambda x: float(str(x)[:3]))
    for _ in range(2):
        with pytest.warns(ns.InterpretedWarning, match="numba cannot compile the model function force"):
            assert speed(system) == 1.0
    assert len(compilings) == 1
    scope["k"] = lambda x: 2.0 * x
    assert speed(system) == 2.0 and len(compilings) == 2


def test_what_loses_its_identity_runs_interpreted_and_comes_back():
    system, scope = model(force("K[0] * q[0]"), K=(2.0,))
    assert speed(system) == 2.0
    scope["K"] = [3.0]
    with pytest.warns(ns.InterpretedWarning, match="force reads K, a list: whether that changed cannot be known"):
        assert speed(system) == 3.0
    scope["K"] = (4.0,)
    assert speed(system) == 4.0


def test_a_mass_that_begins_to_read_its_coordinate_is_constant_no_more():
    """An editor that loads a changed file into its process gives a function other code."""
    text = "def mass(t, q, p, M):\n    M[0, 0] = MASS\n" + force("1.0")
    fixed, moving = ({**globals()} for _ in range(2))
    exec(text.replace("MASS", "2.0"), fixed)
    exec(text.replace("MASS", "1.0 + q[0]"), moving)

    def velocity(functions):
        system = ns.System(n_q=1, mass=functions["mass"], force=functions["force"])
        return system, lambda: ns.simulate(system, (0, 1), [1.0], [0.0], integrator=ns.MoreauJean(dt=0.01)).u[-1, 0]

    system, run = velocity(fixed)
    _, truth = velocity(moving)
    assert run() == pytest.approx(0.5)
    system.mass.__code__ = moving["mass"].__code__
    assert run() == truth() != pytest.approx(0.5)


def test_an_index_that_leaves_its_array_after_a_change_is_refused_before_machine_code_would_write_there():
    system, scope = model("def force(t, q, u, p, h):\n    for i in range(N):\n        h[i] = q[0]", N=1)
    assert speed(system) == 1.0
    for _ in range(3):  # looked at in the second and fourth run, tried in each
        assert speed(system) == 1.0
    scope["N"] = 2
    with pytest.raises(ns.InvalidInput, match="the model function force raised IndexError"):
        speed(system)


SLOPE = 0.5


def above_a_slope(t, q, p, g_N):
    g_N[0] = q[1] - SLOPE * q[0]


def two_masses(t, q, p, M):
    M[0, 0] = M[1, 1] = 1.0


def weight(t, q, u, p, h):
    h[1] = -10.0


def test_rows_that_are_derived_from_a_gap_follow_what_it_reads(monkeypatch):
    """A bead that rests on a slope slides down it: its velocity has the direction of the slope of now."""
    system = ns.System(n_q=2, mass=two_masses, force=weight, gap=above_a_slope, contacts=[ns.Contact()])

    def direction():
        u = ns.simulate(system, (0, 1), [0, 0], [0, 0], integrator=ns.MoreauJean(dt=0.1)).u[-1]
        return u[1] / u[0]

    assert direction() == pytest.approx(0.5)
    functions = system.functions
    assert system.functions is functions
    monkeypatch.setitem(globals(), "SLOPE", 2.0)
    assert direction() == pytest.approx(2.0)
    monkeypatch.setenv("NONSMOOTH_INTERPRET", "1")
    assert direction() == pytest.approx(2.0)


def test_a_model_builds_its_system_anew_where_what_it_reads_has_changed():
    scope = {"ns": ns, "mass": mass, "E": 0.5}
    exec(
        """
def force(t, q, u, p, h): h[0] = -10.0
def gap(t, q, p, g): g[0] = q[0]
def normal(t, q, p, W): W[0, 0] = 1.0
def system(self):
    return ns.System(n_q=1, mass=mass, force=force, gap=gap, normal=normal, contacts=[ns.Contact(e_N=E)])
""",
        scope,
    )
    model = type("Ball", (), {"system": scope["system"]})()
    assert as_system(model) is as_system(model) and as_system(model).contacts[0].e_N == 0.5
    scope["E"] = 0.75
    assert as_system(model).contacts[0].e_N == 0.75
    type(model).system = lambda self: ns.System(n_q=1, mass=mass, force=scope["force"])
    assert as_system(model).n_c == 0


TAUGHT = """
import sys, warnings
import numba
import nonsmooth as ns

K = 2.0

def mass(t, q, p, M):
    M[0, 0] = 1.0

def force(t, q, u, p, h):
    h[0] = q[0]

class Weight(numba.types.Type):
    pass

def key(force):
    from nonsmooth.jit import survey_of
    system = ns.System(n_q=1, mass=mass, force=force)
    return survey_of({1: (force, True, (1,))}, 1, 1, system.unpack, 0).digest()

before = key(force)

@numba.extending.overload_method(Weight, "grams")
def grams(x):
    return lambda x: K

assert key(force) == key(force) != before
K = 3.0
warnings.simplefilter("error")
try:
    ns.simulate(ns.System(n_q=1, mass=mass, force=force), (0, 1), [1.0], [0.0], integrator=ns.MoreauJean(dt=1.0))
except ns.InterpretedWarning as refusal:
    print(refusal)
"""


def test_what_numba_was_taught_belongs_to_the_key_and_is_refused_once_it_changes():
    """Numba does not ask the extension again. In a process of its own: numba forgets nothing that it was taught."""
    done = subprocess.run([sys.executable, "-c", TAUGHT], capture_output=True, text=True, timeout=120)
    assert done.stdout.startswith("what grams taught numba has changed; a new process sees it; "), done.stderr


def test_a_sweep_sees_the_change_too():
    text = """
def force(t, q, u, p, h):
    h[0] = K
"""
    system, scope = model(text, K=2.0)
    start = {"q0": [0.0], "u0": [0.0]}
    task = ns.RunTask(system, "final_state", t_span=(0, 1), state=start, integrator=ns.MoreauJean(dt=1.0))
    for gain in (2.0, 3.0):
        scope["K"] = gain
        found = ns.sweep(task, {"c": [1.0, 2.0]}, progress=False)
        assert (found.u.values == gain).all()


def test_derivatives_by_complex_steps_see_the_change_too():
    def around():
        gain = 1.0

        def slope(x):
            return gain * K(x)  # noqa: F821

        def change(value):
            nonlocal gain
            gain = value

        return slope, change

    slope, change = around()
    slope = types.FunctionType(slope.__code__, scope := {"K": lambda x: 2.0 * x * x}, "slope", None, slope.__closure__)
    at = np.array([3.0])
    assert jacobian(complexified(slope), at)[1] == pytest.approx(12.0)
    scope["K"] = lambda x: 5.0 * x * x
    assert jacobian(complexified(slope), at)[1] == pytest.approx(30.0)
    change(2.0)
    assert jacobian(complexified(slope), at)[1] == pytest.approx(60.0)
    assert complexified(slope) is complexified(slope)
