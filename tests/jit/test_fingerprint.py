"""What a function reads, found in its instructions; and what stands for the values."""

import copy
import dis
import functools
import importlib
import inspect
import math
import pkgutil
import subprocess
import sys
import types
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

import models
import nonsmooth
import nonsmooth as ns
from nonsmooth.jit import Kernel, bytecode, identity
from nonsmooth.jit.bytecode import constant, reading, scalar
from nonsmooth.jit.fingerprint import Survey, Unidentified, digest


def of(text, name="f", **scope):
    """A function written as text."""
    scope = {"__name__": "scene", **scope}
    exec(text, scope)
    return scope[name]


# instructions


def code_objects(module):
    """All code in the file of a module."""
    found = [compile(Path(module.__file__).read_text(), module.__file__, "exec")]
    for code in found:
        found += [inner for inner in code.co_consts if isinstance(inner, types.CodeType)]
    return found


def by_dis(code):
    """Names, free variables and constants as the documented module of Python finds them."""
    names, free, constants, chain = {}, {}, [], None
    for step in dis.get_instructions(code):
        if step.opname in ("EXTENDED_ARG", "CACHE"):
            continue
        if step.opname in ("LOAD_ATTR", "LOAD_METHOD") and chain:
            chain[1].append(step.argval)
            continue
        if chain:
            chain[0][tuple(chain[1])] = None
        chain = None
        if step.opname == "LOAD_GLOBAL":
            chain = names, [step.argval]
        elif step.opname == "LOAD_DEREF" and step.argval in code.co_freevars:
            chain = free, [step.argval]
        elif step.opcode in dis.hasconst:
            constants.append(code.co_consts[step.arg])
    return list(names), list(free), constants


@pytest.mark.parametrize("module", [bytecode, functools, dis, inspect, np.ma.core], ids=lambda m: m.__name__)
def test_instructions_are_read_as_python_documents_them(module):
    """Files of some thousand names, among them ones with more than 255."""
    read = 0
    for code in code_objects(module):
        walk = bytecode._Walk(code)
        names, free, constants = by_dis(code)
        assert (list(walk.names), list(walk.free)) == (names, free)
        assert len(constants) == len(walk.constants)
        assert all(one is other for one, other in zip(constants, walk.constants, strict=True))
        read += len(names)
    assert read > 30


def test_an_attribute_belongs_to_a_name_only_where_it_follows_it():
    f = of("def f(run):\n    y = hh.K + run.K + pk.c.L(hh)\n    return (lambda z: kk.M * z + run.N)(y)")
    assert set(reading(f.__code__).names) == {("hh", "K"), ("pk", "c", "L"), ("hh",), ("kk", "M")}


def test_a_python_whose_instructions_are_others_is_refused(monkeypatch):
    monkeypatch.setitem(bytecode.FLAG_BITS, "LOAD_ATTR", 3)
    monkeypatch.setattr(bytecode, "SHIFTS", dict.fromkeys(range(256), 3))
    bytecode._require_known_instructions.cache_clear()
    try:
        with pytest.raises(ns.UnsupportedVersion, match=r"the instructions of Python 3\.\d+ are not known here; use"):
            reading(of("def f():\n    return K").__code__)
    finally:
        bytecode._require_known_instructions.cache_clear()


def test_an_instruction_that_names_something_in_an_unknown_way_is_refused():
    assert bytecode._act("LOAD_SOMETHING_NEW", dis.opmap["LOAD_NAME"]) == bytecode.IS_REFUSED
    assert bytecode._act("LOAD_SOMETHING_NEW", dis.opmap["LOAD_DEREF"]) == bytecode.IS_REFUSED
    assert bytecode._act("DO_SOMETHING_NEW", dis.opmap["POP_TOP"]) == bytecode.IS_OTHER


@pytest.mark.parametrize(("text", "words"), [
    ("def f():\n    import os\n    return os.sep", "imports a module as it runs"),
    ("def f():\n    global K\n    K = 1", "assigns to a global"),
    ("def f():\n    class C:\n        K = 1\n    return C", "holds the instruction LOAD_NAME"),
])  # fmt: skip
def test_what_cannot_be_followed_is_named(text, words):
    with pytest.raises(Unidentified, match=words):
        digest(of(text))


# values

DISTINCT = [
    0, 0.0, -0.0, False, None, ..., 0j, complex(0.0, -0.0), "", b"", (), frozenset(), "0", 1, 1.0, True, 10**400,
    -(10**400), float("nan"), float("inf"), np.frombuffer(b"\x01\0\0\0\0\0\xf8\x7f")[0].item(), (0,), (0.0,), (0, 0),
    ((0,), 0), (0, (0,)), frozenset({1, 2}), frozenset({(1, 2)}), "a\0b", ("a", "b"), slice(0, 1), slice(0, 1, None),
    slice(0, 1, 1),
]  # fmt: skip


def test_constants_that_differ_in_value_or_type_have_other_bytes():
    """``slice(0, 1)`` stands there twice: it is the same."""
    assert len({constant(value) for value in DISTINCT}) == len(DISTINCT) - 1
    with pytest.raises(KeyError):
        scalar([])


def fingerprint(value):
    survey = Survey()
    survey.value(value, "K")
    return survey.digest()


ARRAYS = [
    np.zeros(4), np.zeros((2, 2)), np.zeros((2, 2), order="F"), np.zeros(4, dtype="f4"), np.zeros(8, dtype="f4"),
    -np.zeros(4), np.zeros(4, dtype="i8"), np.zeros(4, dtype=">f8"), np.zeros((4, 1)), np.zeros((1, 4)), np.zeros(0),
    np.zeros((0, 3)), np.float64(0.0), np.float32(0.0), np.int64(0), np.array(0.0),
    np.zeros(2, dtype=[("a", "f8"), ("b", "f8")]), np.zeros(2, dtype=[("b", "f8"), ("a", "f8")]), np.arange(4.0),
    np.arange(4.0).reshape(2, 2), np.arange(4.0).reshape(2, 2).T,
]  # fmt: skip


def test_arrays_that_differ_in_content_type_shape_or_order_differ():
    assert len({fingerprint(array) for array in ARRAYS}) == len(ARRAYS)
    assert all(fingerprint(array) == fingerprint(copy.copy(array)) for array in ARRAYS)


def test_an_array_that_may_not_be_written_to_is_another_one():
    """Machine code that is compiled for the one cannot take the other."""
    array = np.zeros(3)
    before = fingerprint(array)
    array.flags.writeable = False
    assert fingerprint(array) != before


@pytest.mark.parametrize("value", [
    [], {}, set(), object(), Fraction(1, 2), np.array([None]), np.ma.zeros(2), sys, functools.partial(abs), iter(()),
    ns.System, (1, [2]), slice([], None),
], ids=lambda value: f"{type(value).__name__} {value}"[:20])  # fmt: skip
def test_what_is_no_plain_value_has_no_identity(value):
    with pytest.raises(Unidentified, match="^K"):
        fingerprint(value)


def test_functions_of_libraries_are_known_by_their_names():
    names = [abs, math.sin, np.sin, np.linalg.norm, np.float64, float, np.random.rand, ValueError, Fraction]
    assert len({fingerprint(value) for value in names}) == len(names)
    ours = of("def sin(x):\n    return x", "sin")
    assert fingerprint(ours) not in {fingerprint(math.sin), fingerprint(np.sin)}


def test_a_function_that_was_put_into_a_library_is_known_by_its_code(monkeypatch):
    f = of("def f(x):\n    return np.sin(x)", np=np)
    before = digest_of(f)
    monkeypatch.setattr(np, "sin", np.cos)
    assert digest_of(f) != before
    found = set()
    for number in (2, 3):
        monkeypatch.setattr(np, "sin", of(f"def sin(x):\n    return {number} * x", "sin"))
        found.add(digest_of(f))
    assert len(found) == 2


def digest_of(function):
    survey = Survey()
    survey.function(function)
    return survey.digest()


def test_a_function_met_again_stands_for_itself():
    """f calls g twice, or g and h of the same text: the same machine code is made of another number of functions."""
    text = "def f(x):\n    return g(x) + h(x)"
    g, h = (of("def k(x):\n    return x", "k") for _ in range(2))
    assert digest_of(of(text, g=g, h=h)) != digest_of(of(text, g=g, h=g))
    assert digest_of(of(text, g=g, h=h)) == digest_of(of(text, g=h, h=g))


# the package's own


def kernels():
    for module in pkgutil.walk_packages(nonsmooth.__path__, "nonsmooth."):
        if not module.name.endswith("__main__"):
            for value in vars(importlib.import_module(module.name)).values():
                if isinstance(value, Kernel):
                    yield value


def test_every_kernel_of_the_package_has_an_identity():
    found = {kernel.call_identity() for kernel in kernels()}
    assert len(found) > 300


def test_every_function_of_a_model_has_an_identity():
    for name in models.__all__:
        system = getattr(models, name)().system()
        for function in system.functions.values():
            assert digest_of(function)


STAMPS = """
import importlib
from nonsmooth.jit.kernels import kernel_stamp
for name in ("integrators.adaptive.loop.run", "integrators.moreau_jean.step.step", "lcp.lemke.lemke_entry"):
    module, name = name.rsplit(".", 1)
    print(kernel_stamp(getattr(importlib.import_module(f"nonsmooth.{module}"), name)))
"""


def test_the_key_of_a_loop_is_the_same_in_every_process():
    """An attribute of a block may bear the name of a function of the module whose printed form is an address."""
    said = {
        subprocess.run([sys.executable, "-c", STAMPS], capture_output=True, text=True, check=True, timeout=120).stdout
        for _ in range(2)
    }
    assert len(said) == 1 and len(set(said.pop().split())) == 3


# whatever can be called, in later processes


def test_the_identity_of_a_task_follows_what_it_carries_along():
    text = "def f(x, k):\n    return k * x * K + hh.L"
    hh = types.SimpleNamespace(L=1.0)
    f = of(text, K=2.0, hh=hh)
    partials = [functools.partial(f, k=number) for number in (2.0, 3.0)]
    assert len({identity(each) for each in (f, *partials)}) == 3
    assert identity(functools.partial(f, k=2.0)) == identity(partials[0])
    before = identity(partials[0])
    f.__globals__["K"] = 3.0
    assert identity(partials[0]) != before
    form = "class C:\n    def __init__(self, k):\n        self.k = k\n    def __call__(self, x):\n        x {} self.k"
    objects = [of(form.format(sign), "C")(k) for sign, k in (("*", 2), ("*", 3), ("+", 2))]
    assert len({identity(each) for each in objects}) == 3
    assert identity(objects[0].__call__) != identity(objects[1].__call__)
