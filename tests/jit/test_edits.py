"""Edits of what a model function is made from: machine code of the text before the edit is never run after it.

Each kind of edit is a small model whose text has one place ``⟨before|after⟩``. The truth is the same model run by the
interpreter, whose bits the compiled one gives. Compiled are:

- in two new processes after each other, before and after the edit, with one disk cache: every fourth kind (all with
  ``-m slow``);
- in one process, before and after the edited modules were executed again in their place: likewise.

For all kinds the keys are compared, under which machine code is kept and found: they differ after the edit, and are the
same for the same text in another folder and process.
"""

import importlib
import json
import os
import re
import subprocess
import sys
import textwrap
import warnings
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import pytest

import nonsmooth as ns
from nonsmooth.jit import survey_of
from nonsmooth.mechanics.system import FORCE

pytestmark = pytest.mark.upkeep

HEAD = """
import math
from enum import Enum, IntEnum
from typing import NamedTuple
import numba
import numpy as np
"""
FORCE_IS = "def force(t, q, u, p, h):\n    h[0] = "


def is_(expression, **around):
    """A force of one line, after what it needs."""
    files = {name: text for name, text in around.items() if name != "before"}
    return {"scene": HEAD + textwrap.dedent(around.get("before", "")) + "\n" + FORCE_IS + expression + "\n", **files}


def body(text, **files):
    return {"scene": HEAD + textwrap.dedent(text), **files}


EDITS = {
    # the function itself
    "number": is_("⟨2.0|3.0⟩ * q[0]"),
    "ninth digit": is_("⟨2.000000001|2.000000002⟩ * q[0]"),
    "integer": is_("q[0] * ⟨2|3⟩"),
    "sign of zero": is_("math.copysign(1.0, ⟨0.0|-0.0⟩) * q[0]"),
    "comparison": is_("1.0 if q[0] ⟨<|>=⟩ 0.5 else 2.0"),
    "unary": is_("⟨-|+⟩q[0]"),
    "boolean operator": is_("1.0 if (q[0] > 0.5 ⟨and|or⟩ u[0] > 0.5) else 2.0"),
    "name of a function of math": is_("math.⟨sin|cos⟩(q[0])"),
    "name of an argument": is_("⟨q|u⟩[0]"),
    "name of a parameter": is_("p.⟨k|c⟩"),
    "index": is_("A[⟨0|1⟩] * q[0]", before="A = (1.0, 2.0)"),
    "branches changed about": body("""
        def force(t, q, u, p, h):
            if q[0] > 0.5:
                h[0] = ⟨1.0|2.0⟩
            else:
                h[0] = ⟨2.0|1.0⟩
        """),
    "bound of a loop": body("""
        def force(t, q, u, p, h):
            for i in range(⟨3|4⟩):
                h[0] += q[0] * i
        """),
    "text that is compared": is_("1.0 if NAME == '⟨a|b⟩' else 2.0", before="NAME = 'a'"),
    "boolean": is_("1.0 if ⟨True|False⟩ else q[0]"),
    "complex number": is_("(⟨2.0j|3.0j⟩ * 1j).real"),
    "keyword of a call": is_("k(⟨a|b⟩=q[0])", before="def k(a=1.0, b=2.0):\n    return a - b"),
    "entry of a tuple": is_("(1.0, ⟨2.0|3.0⟩)[1] * q[0]"),
    "exponent": is_("q[0] ** ⟨2|3⟩"),
    "augmented assignment": body("""
        def force(t, q, u, p, h):
            h[0] = 1.0
            h[0] ⟨+=|*=⟩ 3.0
        """),
    # functions that it calls
    "helper": is_("k(q[0])", before="def k(x):\n    return ⟨2.0|3.0⟩ * x"),
    "helper of a helper": is_("k(q[0])", before="def j(x):\n    return ⟨2.0|3.0⟩ * x\ndef k(x):\n    return j(x)"),
    "default of a helper": is_("k(q[0])", before="def k(x, a=⟨2.0|3.0⟩):\n    return a * x"),
    "array as a default": is_("k(q[0])", before="def k(x, a=np.array([1.0, ⟨2.0|3.0⟩])):\n    return a[1] * x"),
    "which helper": is_("k(q[0])", before="def i(x):\n    return x\ndef j(x):\n    return 2 * x\nk = ⟨i|j⟩"),
    "helper that calls itself": is_("k(3, q[0])", before="""
        def k(n, x):
            if n < 1:
                return x
            return ⟨2.0|3.0⟩ * k(n - 1, x)
        """),
    "helpers that call each other": is_("even(4, q[0])", before="""
        def even(n, x):
            if n == 0:
                return x
            return odd(n - 1, x)
        def odd(n, x):
            if n == 0:
                return -x
            return ⟨2.0|3.0⟩ * even(n - 1, x)
        """),
    "helper compiled by numba": is_("k(q[0])", before="@numba.njit\ndef k(x):\n    return ⟨2.0|3.0⟩ * x"),
    "helper of one compiled by numba": is_("k(q[0])", before="""
        @numba.njit
        def j(x):
            return ⟨2.0|3.0⟩ * x
        @numba.njit
        def k(x):
            return j(x)
        """),
    "global of a helper compiled by numba": is_("k(q[0])", before="""
        K = ⟨2.0|3.0⟩
        @numba.njit
        def k(x):
            return K * x
        """),
    "signature of a helper": is_("k(0.1 + q[0])", before="""
        @numba.njit("⟨float64(float64)|float32(float32)⟩")
        def k(x):
            return x
        """),
    "vectorised helper": is_("k(q[0])", before="@numba.vectorize\ndef k(x):\n    return ⟨2.0|3.0⟩ * x"),
    "vectorised helper with a signature": is_("k(q[0])", before="""
        @numba.vectorize(["float64(float64)"])
        def k(x):
            return ⟨2.0|3.0⟩ * x
        """),
    "helper of a vectorised one": is_("k(q[0])", before="""
        @numba.njit
        def j(x):
            return ⟨2.0|3.0⟩ * x
        @numba.vectorize
        def k(x):
            return j(x)
        """),
    "generalised vectorised helper": body("""
        @numba.guvectorize(["void(float64[:], float64[:])"], "(n)->(n)")
        def k(x, y):
            for i in range(x.shape[0]):
                y[i] = ⟨2.0|3.0⟩ * x[i]
        def force(t, q, u, p, h):
            k(q, h)
        """),
    "callback for C": is_("k(q[0])", before="""
        @numba.cfunc("float64(float64)")
        def k(x):
            return ⟨2.0|3.0⟩ * x
        """),
    "wrapped helper": is_("k(q[0])", before="""
        import functools
        def doubled(f):
            @functools.wraps(f)
            def g(x):
                return ⟨2.0|3.0⟩ * x
            return g
        @doubled
        def k(x):
            return x
        """),
    # functions within functions
    "lambda": is_("(lambda x: ⟨2.0|3.0⟩ * x)(q[0])"),
    "operator in a lambda": is_("(lambda x: 2.0 ⟨*|+⟩ x)(q[0])"),
    "global of a lambda": is_("(lambda x: K * x)(q[0])", before="K = ⟨2.0|3.0⟩"),
    "lambda as a helper": is_("k(q[0])", before="k = lambda x: ⟨2.0|3.0⟩ * x"),
    "inner function": body("""
        def force(t, q, u, p, h):
            def k(x):
                return ⟨2.0|3.0⟩ * x
            h[0] = k(q[0])
        """),
    "inner function of a helper": body("""
        def outer(x):
            def k(y):
                return ⟨2.0|3.0⟩ * y
            return k(x)
        def force(t, q, u, p, h):
            h[0] = outer(q[0])
        """),
    "lambda in an inner function": body("""
        def force(t, q, u, p, h):
            def k(x):
                return (lambda y: ⟨2.0|3.0⟩ * y)(x)
            h[0] = k(q[0])
        """),
    "default of an inner function": body("""
        def force(t, q, u, p, h):
            def k(x, a=⟨2.0|3.0⟩):
                return a * x
            h[0] = k(q[0])
        """),
    "comprehension": is_("[⟨2.0|3.0⟩ * i * q[0] for i in range(3)][2]"),
    "condition of a comprehension": is_("len([i for i in range(9) if i > ⟨2|3⟩]) * q[0]"),
    "comprehension in a helper": is_("k(q[0])", before="def k(x):\n    return [⟨2.0|3.0⟩ * x for i in range(2)][1]"),
    "comprehension in a comprehension": is_("[[⟨2.0|3.0⟩ * j for j in range(3)][i] for i in range(3)][2] * q[0]"),
    # values that it reads
    "global number": is_("K * q[0]", before="K = ⟨2.0|3.0⟩"),
    "global integer": is_("K * q[0]", before="K = ⟨2|3⟩"),
    "global boolean": is_("1.0 if K else 2.0", before="K = ⟨True|False⟩"),
    "global text": is_("1.0 if K == 'a' else 2.0", before="K = '⟨a|b⟩'"),
    "global complex number": is_("(K * 1j).real", before="K = ⟨2j|3j⟩"),
    "type of a global": is_("K * q[0]", before="K = np.⟨float32|float64⟩(0.1)"),
    "global of numpy": is_("K * q[0]", before="K = np.float64(⟨2.0|3.0⟩)"),
    "global tuple": is_("K[1] * q[0]", before="K = (1.0, ⟨2.0|3.0⟩)"),
    "tuple in a tuple": is_("K[1][0] * q[0]", before="K = (1.0, (⟨2.0|3.0⟩, 4.0))"),
    "NamedTuple": is_("K.b * q[0]", before="class T(NamedTuple):\n    a: float\n    b: float\nK = T(1.0, ⟨2.0|3.0⟩)"),
    "NamedTuple in a NamedTuple": is_("K.b.a * q[0]", before="""
        class T(NamedTuple):
            a: float
        class S(NamedTuple):
            a: float
            b: T
        K = S(1.0, T(⟨2.0|3.0⟩))
        """),
    "order of the fields of a NamedTuple": is_(
        "T(1.0, 2.0).a * q[0]",
        before="class T(NamedTuple):\n    ⟨a|b⟩: float\n    ⟨b|a⟩: float"),
    "member of an enumeration": is_("E.B.value * q[0]", before="class E(Enum):\n    A = 1\n    B = ⟨2|3⟩"),
    "member of integers": is_("(1.0 if K == E.A else 2.0) * q[0]", before="class E(IntEnum):\n    A = ⟨1|2⟩\nK = 1"),
    "member as a global": is_("1.0 if K is E.A else 2.0", before="class E(Enum):\n    A = 1\n    B = 2\nK = E.⟨A|B⟩"),
    "array": is_("K[1] * q[0]", before="K = np.array([1.0, ⟨2.0|3.0⟩])"),
    "ninth digit in an array": is_("K[1] * q[0]", before="K = np.array([1.0, ⟨2.000000001|2.000000002⟩])"),
    "inner entry of a long array": is_("K[777] * q[0]", before="K = np.ones(2000)\nK[777] = ⟨2.0|3.0⟩"),
    "shape of an array": is_("K.shape[0] * q[0]", before="K = np.ones(⟨(2, 3)|(3, 2)⟩)"),
    "type of an array": is_("K[1] * q[0]", before="K = np.array([1.0, 0.1], dtype='⟨f4|f8⟩')"),
    "order of an array": is_("K[0, 1] * q[0]", before="K = np.array([[1.0, 2.0], [3.0, 4.0]])⟨|.T⟩"),
    "large array": is_("K[777] * q[0]", before="K = np.ones(200_000)\nK[777] = ⟨2.0|3.0⟩"),
    "array with gaps": is_("K[1] * q[0]", before="K = np.array([1.0, 5.0, ⟨2.0|3.0⟩, 5.0])[::2]"),
    "array of records": is_(
        "K[0]['b'] * q[0]",
        before="K = np.array([(1.0, ⟨2.0|3.0⟩)], dtype=[('a', 'f8'), ('b', 'f8')])"),
    "names in records": is_(
        "K[0]['b'] * q[0]",
        before="K = np.array([(1.0, 2.0)], dtype=[('⟨a|b⟩', 'f8'), ('⟨b|a⟩', 'f8')])"),
    "array in a tuple": is_("K[1][1] * q[0]", before="K = (1.0, np.array([1.0, ⟨2.0|3.0⟩]))"),
    "array in a NamedTuple": is_(
        "K.a[1] * q[0]",
        before="class T(NamedTuple):\n    a: np.ndarray\nK = T(np.array([1.0, ⟨2.0|3.0⟩]))"),
    "bytes": is_("K[0] * q[0]", before="K = b'⟨a|b⟩'"),
    "slice": is_("np.array([1.0, 2.0, 3.0])[K][0] * q[0]", before="K = slice(⟨0|1⟩, 3)"),
    "type that is called": is_("K(q[0] * 1.1)", before="K = np.⟨float32|float64⟩"),
    "type of numba that is called": is_("K(q[0] * 1.1)", before="K = numba.⟨float32|float64⟩"),
    # modules
    "constant of a module": is_("hh.K * q[0]", before="import hh", hh="K = ⟨2.0|3.0⟩"),
    "constant that is imported": is_("K * q[0]", before="from hh import K", hh="K = ⟨2.0|3.0⟩"),
    "constant under another name": is_("L * q[0]", before="from hh import K as L", hh="K = ⟨2.0|3.0⟩"),
    "all that a module has": is_("K * q[0]", before="from hh import *", hh="K = ⟨2.0|3.0⟩"),
    "constant of a submodule": is_(
        "pk.c.K * q[0]",
        before="import pk.c",
        **{"pk/__init__": "", "pk/c": "K = ⟨2.0|3.0⟩"}),
    "constant of a submodule by an alias": is_(
        "c.K * q[0]",
        before="import pk.c as c",
        **{"pk/__init__": "", "pk/c": "K = ⟨2.0|3.0⟩"}),
    "another module under the same alias": is_("m.K * q[0]", before="import ⟨hh|kk⟩ as m", hh="K = 2.0", kk="K = 3.0"),
    "another module for a while": is_("m.K * q[0]", before="import hh, kk\nm = ⟨hh|kk⟩", hh="K = 2.0", kk="K = 3.0"),
    "module of a module": is_("hh.kk.K * q[0]", before="import hh", hh="import kk", kk="K = ⟨2.0|3.0⟩"),
    "constant made of another": is_(
        "hh.K * q[0]",
        before="import hh",
        hh="import kk\nK = 2 * kk.L",
        kk="L = ⟨2.0|3.0⟩"),
    "array of a module": is_(
        "hh.K[1] * q[0]",
        before="import hh",
        hh="import numpy as np\nK = np.array([1.0, ⟨2.0|3.0⟩])"),
    "NamedTuple of a module": is_(
        "hh.K.a * q[0]",
        before="import hh",
        hh="from typing import NamedTuple\nclass T(NamedTuple):\n    a: float\nK = T(⟨2.0|3.0⟩)"),
    "enumeration of a module": is_(
        "hh.E.A.value * q[0]",
        before="import hh",
        hh="from enum import Enum\nclass E(Enum):\n    A = ⟨2|3⟩"),
    "compiled helper of a module": is_(
        "hh.k(q[0])",
        before="import hh",
        hh="import numba\n@numba.njit\ndef k(x):\n    return ⟨2.0|3.0⟩ * x"),
    "global of a compiled helper of a module": is_(
        "hh.k(q[0])",
        before="import hh",
        hh="import numba\nK = ⟨2.0|3.0⟩\n@numba.njit\ndef k(x):\n    return K * x"),
    "helper of a module": is_("hh.k(q[0])", before="import hh", hh="def k(x):\n    return ⟨2.0|3.0⟩ * x"),
    "helper of a submodule": is_(
        "pk.c.k(q[0])",
        before="import pk.c",
        **{"pk/__init__": "", "pk/c": "K = ⟨2.0|3.0⟩\ndef k(x):\n    return K * x"}),
    "helper that is imported": is_("k(q[0])", before="from hh import k", hh="def k(x):\n    return ⟨2.0|3.0⟩ * x"),
    "vectorised helper of a module": is_(
        "hh.k(q[0])",
        before="import hh",
        hh="import numba\n@numba.vectorize\ndef k(x):\n    return ⟨2.0|3.0⟩ * x"),
    "module in a lambda": is_("(lambda x: hh.K * x)(q[0])", before="import hh", hh="K = ⟨2.0|3.0⟩"),
    "module in a comprehension": is_("[hh.K * i for i in range(3)][2] * q[0]", before="import hh", hh="K = ⟨2.0|3.0⟩"),
    "module of a helper": is_("k(q[0])", before="import hh\ndef k(x):\n    return hh.K * x", hh="K = ⟨2.0|3.0⟩"),
    "module of the name of another in Python": is_(
        "profile.K * q[0]",
        before="import profile",
        profile="K = ⟨2.0|3.0⟩"),
    # variables of the function around it
    "closed-over number": body("""
        def around(k):
            def force(t, q, u, p, h):
                h[0] = k * q[0]
            return force
        force = around(⟨2.0|3.0⟩)
        """),
    "closed-over array": body("""
        def around():
            k = np.ones(2000)
            k[777] = ⟨2.0|3.0⟩
            def force(t, q, u, p, h):
                h[0] = k[777] * q[0]
            return force
        force = around()
        """),
    "closed-over NamedTuple": body("""
        class T(NamedTuple):
            a: np.ndarray
            b: float
        def around(k):
            def force(t, q, u, p, h):
                h[0] = k.a[1] * q[0]
            return force
        force = around(T(np.array([1.0, ⟨2.000000001|2.000000002⟩]), 3.0))
        """),
    "closed-over helper": body("""
        def around():
            def k(x):
                return ⟨2.0|3.0⟩ * x
            def force(t, q, u, p, h):
                h[0] = k(q[0])
            return force
        force = around()
        """),
    "closed-over compiled helper": body("""
        def around(c):
            @numba.njit
            def k(x):
                return c * x
            def force(t, q, u, p, h):
                h[0] = k(q[0])
            return force
        force = around(⟨2.0|3.0⟩)
        """),
    "closed over by a lambda": body("""
        def around(k):
            def force(t, q, u, p, h):
                h[0] = (lambda x: k * x)(q[0])
            return force
        force = around(⟨2.0|3.0⟩)
        """),
    "closed-over module": body("""
        def around():
            import hh
            def force(t, q, u, p, h):
                h[0] = hh.K * q[0]
            return force
        force = around()
        """, hh="K = ⟨2.0|3.0⟩"),
    "closed over by a helper": is_("k(q[0])", before="""
        def around(c):
            def k(x):
                return c * x
            return k
        k = around(⟨2.0|3.0⟩)
        """),
}  # fmt: skip

REFUSED_BY_NUMBA = {  # or said to be experimental: compared by their keys only
    "tuple of helpers": is_("KS[1](q[0])", before="""
        @numba.njit
        def i(x):
            return x
        @numba.njit
        def k(x):
            return ⟨2.0|3.0⟩ * x
        KS = (i, k)
        """),
    "default of a NamedTuple": is_(
        "T(1.0).b * q[0]",
        before="class T(NamedTuple):\n    a: float\n    b: float = ⟨2.0|3.0⟩"),
    "keyword default of a helper": is_("k(q[0])", before="def k(x, *, a=⟨2.0|3.0⟩):\n    return a * x"),
}  # fmt: skip

REFUSED = {  # what has no identity, and what the warning says of it
    "dict": (is_("K['a'] * q[0]", before="K = {'a': ⟨2.0|3.0⟩}"), "K, a dict"),
    "list": (is_("K[0] * q[0]", before="K = [⟨2.0|3.0⟩]"), "K, a list"),
    "class": (is_("K.a * q[0]", before="class K:\n    a = ⟨2.0|3.0⟩"), "K, the class K"),
    "object": (is_("K.a * q[0]", before="class C:\n    a = ⟨2.0|3.0⟩\nK = C()"), "K, a C"),
    "object of a module": (is_(
        "hh.K.a * q[0]",
        before="import hh",
        hh="class C:\n    a = ⟨2.0|3.0⟩\nK = C()"), "hh.K, a C"),
    "module in a variable": (body("""
        import hh
        def force(t, q, u, p, h):
            m = hh
            h[0] = m.K * q[0]
        """, hh="K = ⟨2.0|3.0⟩"), "hh, a module that is handed on"),
    "module as an argument": (is_(
        "k(hh, q[0])",
        before="import hh\ndef k(m, x):\n    return m.K * x",
        hh="K = ⟨2.0|3.0⟩"), "hh, a module that is handed on"),
    "module as a default": (is_(
        "k(q[0])",
        before="import hh\ndef k(x, m=hh):\n    return m.K * x",
        hh="K = ⟨2.0|3.0⟩"), r"a default of k\[0\], a module that is handed on"),
    "module in a tuple": (is_(
        "M[0].K * q[0]",
        before="import hh\nM = (hh,)",
        hh="K = ⟨2.0|3.0⟩"), r"M\[0\], a module that is handed on"),
    "attribute by its name": (is_(
        "getattr(hh, 'K') * q[0]",
        before="import hh",
        hh="K = ⟨2.0|3.0⟩"), "hh, a module that is handed on"),
    "import as it runs": (body("""
        def force(t, q, u, p, h):
            import hh
            h[0] = hh.K * q[0]
        """, hh="K = ⟨2.0|3.0⟩"), "force, which imports a module as it runs"),
    "attribute that a module makes": (is_(
        "hh.K * q[0]",
        before="import hh",
        hh="def __getattr__(name):\n    return ⟨2.0|3.0⟩"), "hh.K, which its module may make when it is read"),
    **{f"attribute that the class of a module makes by {how}": (is_(
        "hh.K * q[0]",
        before="import hh",
        hh="import sys, types\nclass M(types.ModuleType):\n    " + text.replace("\n", "\n    ")
        + "\nsys.modules[__name__].__class__ = M"), "hh.K, which its module may make when it is read")
        for how, text in {
            "a property": "@property\ndef K(self):\n    return ⟨2.0|3.0⟩",
            "__getattribute__": "def __getattribute__(self, name):\n    return (⟨2.0|3.0⟩ if name == 'K' else "
            "super().__getattribute__(name))",
            "__getattr__": "def __getattr__(self, name):\n    return ⟨2.0|3.0⟩",
        }.items()},
    "attribute that the class of a submodule makes": (is_(
        "pk.c.K * q[0]",
        before="import types\nclass M(types.ModuleType):\n    K = property(lambda self: ⟨2.0|3.0⟩)\n"
        "pk = types.ModuleType('pk')\npk.c = M('pk.c')"), "pk.c.K, which its module may make when it is read"),
    "partial function": (body("""
        import functools
        def general(k, t, q, u, p, h):
            h[0] = k * q[0]
        force = functools.partial(general, ⟨2.0|3.0⟩)
        """), "is no function but a partial"),
    "object that is called": (body("""
        class Force:
            def __call__(self, t, q, u, p, h):
                h[0] = ⟨2.0|3.0⟩ * q[0]
        force = Force()
        """), "is no function but a Force"),
    "ufunc of Python": (is_("k(q[0])", before="k = np.frompyfunc(lambda x: ⟨2.0|3.0⟩ * x, 1, 1)"), "k, a ufunc"),
    "callback of another library": (is_(
        "k(q[0])",
        before="import ctypes\nk = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double)(lambda x: ⟨2.0|3.0⟩ * x)"),
        "k, a CFunctionType"),
}  # fmt: skip

SAME = {  # edits that change nothing of what the code is made from
    "docstring": body("""
        def force(t, q, u, p, h):
            ⟨|'What it does.'⟩
            h[0] = 2.0 * q[0]
        """),
    "text of a docstring": body("""
        def force(t, q, u, p, h):
            'What it ⟨does|did⟩.'
            h[0] = 2.0 * q[0]
        """),
    "docstring of a helper": is_("k(q[0])", before="def k(x):\n    ⟨|'Twice.'⟩\n    return 2.0 * x"),
    "docstring of an inner function": body("""
        def force(t, q, u, p, h):
            def k(x):
                '⟨Two|Three⟩.'
                return 2.0 * x
            h[0] = k(q[0])
        """),
    "comment": is_("2.0 * q[0]  # ⟨one|two⟩"),
    "lines before": is_("2.0 * q[0]", before="⟨|\n\n\nK = 3.0\n⟩"),
    "blanks": is_("2.0 ⟨*|  *   ⟩ q[0]"),
    "brackets": is_("⟨2.0 * q[0]|(2.0 * (q[0]))⟩"),
    "annotation": body("def force(t, q, u, p, h⟨|: np.ndarray⟩):\n    h[0] = 2.0 * q[0]"),
    "function that is not called": is_("2.0 * q[0]", before="def k(x):\n    return ⟨2.0|3.0⟩ * x"),
    "global that is not read": is_("2.0 * q[0]", before="K = ⟨2.0|3.0⟩"),
    "attribute that has the name of a global": is_("p.k * q[0]", before="k = ⟨2.0|3.0⟩"),
    "attribute that has the name of an object": is_("p.k * q[0]", before="k = object()⟨|\nk = object()⟩"),
    "another attribute of a module": is_("hh.K * q[0]", before="import hh", hh="K = 2.0\nL = ⟨2.0|3.0⟩"),
    "place of a constant": is_("hh.K * q[0]", before="import ⟨hh|kk as hh⟩", hh="K = 2.0", kk="K = 2.0"),
    "way to a constant": is_("K * q[0]", before="⟨K = 2.0|K = 1.0 + 1.0⟩"),
    "way to an array": is_("K[1] * q[0]", before="K = ⟨np.array([1.0, 2.0])|np.linspace(1.0, 2.0, 2)⟩"),
    "name of a class": is_("K.a * q[0]", before="class ⟨T|S⟩(NamedTuple):\n    a: float\nK = ⟨T|S⟩(2.0)"),
    "name of a module": is_(
        "profile.K * q[0]",
        before="import ⟨hh as profile|profile⟩",
        hh="K = 2.0",
        profile="K = 2.0"),
}  # fmt: skip

BEFORE, AFTER = 1, 2
SOME = list(EDITS)[::6]
THOROUGH = [name if name in SOME else pytest.param(name, marks=pytest.mark.slow) for name in EDITS]


class P(NamedTuple):
    k: float = 2.0
    c: float = 3.0


def mass(t, q, p, M):
    M[0, 0] = 1.0


def written(files, which, folder):
    """A folder with the files as they are before or after the edit."""
    for name, text in files.items():
        path = folder / f"{name}.py"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(re.sub(r"⟨(.*?)\|(.*?)⟩", lambda found: found[which], text, flags=re.DOTALL))
    return folder


@contextmanager
def imported(folder):
    """The scene in a folder, whose modules are forgotten afterwards."""
    known = dict(sys.modules)
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(folder))
        patch.setattr(sys, "dont_write_bytecode", True)
        patch.delitem(sys.modules, "profile", raising=False)
        try:
            yield importlib.import_module("scene")
        finally:
            for name in set(sys.modules) - set(known):
                if name.partition(".")[0] in ("scene", "hh", "kk", "pk", "profile"):
                    del sys.modules[name]


def system_of(force):
    return ns.System(n_q=1, mass=mass, force=force, parameters=P())


def speed(system):
    """After one second from q = 0.75 and rest."""
    sol = ns.simulate(system, (0, 1), [0.75], [0.0], integrator=ns.MoreauJean(dt=1.0))
    return float(sol.u[-1, 0]), sol.stats.is_compiled


def truth(system):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("NONSMOOTH_INTERPRET", "1")
        return speed(system)[0]


def key(force):
    """What machine code of a force is kept under, on one machine."""
    return survey_of({FORCE: (force, True, (1,))}, 1, 1, system_of(force).unpack, 2).digest().hex()


def facts(files, which, folder):
    """Speed by machine code and by the interpreter, and the key."""
    with imported(written(files, which, folder)) as scene:
        system = system_of(scene.force)
        found, is_compiled = speed(system)
        return {"compiled": found, "is_compiled": is_compiled, "truth": truth(system), "key": key(scene.force)}


def in_new_process(which, names, folder):
    """The same of several kinds of edit."""
    command = [sys.executable, __file__, str(which), str(folder), *names]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def is_close(a, b):
    """To rounding: powers are rounded otherwise by Python."""
    return a == pytest.approx(b, rel=1e-13, abs=0)


def compare_processes(names, tmp_path):
    before, after = (in_new_process(which, names, tmp_path / str(which)) for which in (BEFORE, AFTER))
    for name in names:
        one, other = before[name], after[name]
        assert one["is_compiled"] and other["is_compiled"], name
        assert is_close(one["compiled"], one["truth"]), name
        assert is_close(other["compiled"], other["truth"]), name
        assert not is_close(one["truth"], other["truth"]) and one["key"] != other["key"], name


def test_a_new_process_runs_what_the_text_says_after_the_edit(tmp_path):
    compare_processes(SOME, tmp_path)


@pytest.mark.slow
def test_a_new_process_runs_what_the_text_says_after_each_kind_of_edit(tmp_path):
    compare_processes(list(EDITS), tmp_path)


@pytest.mark.parametrize("name", THOROUGH)
def test_a_module_that_is_executed_again_in_its_place_is_compiled_again(name, tmp_path):
    files = EDITS[name]
    with imported(written(files, BEFORE, tmp_path)) as scene:
        system = system_of(scene.force)
        assert is_close(speed(system)[0], truth(system))
        written(files, AFTER, tmp_path)
        for module in [m for m in reversed(list(sys.modules.values())) if is_below(m, tmp_path)]:
            importlib.reload(module)
        for again in (system, system_of(scene.force)):  # the function of before, which may read new values; the new one
            found, is_compiled = speed(again)
            assert is_compiled and is_close(found, truth(again))


def is_below(module, folder):
    return Path(getattr(module, "__file__", None) or "/").is_relative_to(folder)


@pytest.mark.parametrize("name", [*EDITS, *REFUSED_BY_NUMBA])
def test_the_key_follows_each_kind_of_edit(name, tmp_path):
    keys, files = [], {**EDITS, **REFUSED_BY_NUMBA}[name]
    for place, which in (("one", BEFORE), ("two", BEFORE), ("three", AFTER)):
        with imported(written(files, which, tmp_path / place)) as scene:
            keys.append(key(scene.force))
    assert (keys[0] == keys[1]) == (name not in IN_PLACE) and keys[0] != keys[2]


IN_PLACE = ("large array", "array with gaps")  # machine code holds their address, and is not kept


@pytest.mark.parametrize("name", SAME)
def test_the_key_stays_where_the_code_is_made_from_the_same(name, tmp_path):
    keys = []
    for which in (BEFORE, AFTER):
        with imported(written(SAME[name], which, tmp_path / str(which))) as scene:
            keys.append(key(scene.force))
    assert keys[0] == keys[1]


@pytest.mark.parametrize("name", REFUSED)
def test_what_has_no_identity_is_named_and_runs_interpreted(name, tmp_path):
    files, words = REFUSED[name]
    with imported(written(files, BEFORE, tmp_path)) as scene, pytest.warns(ns.InterpretedWarning, match=words):
        system = system_of(scene.force)
        found, is_compiled = speed(system)
        assert not is_compiled and found == truth(system)


def test_keys_are_the_same_in_every_process(tmp_path):
    """With other seeds of Python's hashes and other addresses."""
    names = [name for name in SOME if name not in IN_PLACE]
    for name in names:
        written(EDITS[name], BEFORE, tmp_path / name)
    seen = set()
    for seed in ("1", "2"):
        command = [sys.executable, __file__, "keys", str(tmp_path), *names]
        done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True,
                              env={**os.environ, "PYTHONHASHSEED": seed})  # fmt: skip
        seen.add(done.stdout)
    assert len(seen) == 1


FACTORY = """
import sys
import nonsmooth as ns

def mass(t, q, p, M):
    M[0, 0] = 1.0

def system_of(c):
    def helper(x):
        return [c * x for _ in range(2)][1]
    scene = {"helper": helper, "__name__": "scene"}
    exec("def force(t, q, u, p, h): h[0] = helper(q[0])", scene)
    return ns.System(n_q=1, mass=mass, force=scene["force"])

for c in map(float, sys.argv[1:]):
    print(ns.simulate(system_of(c), (0, 1), [1.0], [0.0], integrator=ns.MoreauJean(dt=1.0)).u[-1, 0])
"""


def test_two_kept_models_whose_helpers_have_the_same_name_keep_apart():
    """Compiled in a process each, and read by one."""
    speeds = []
    for constants in (["2"], ["3"], ["2", "3"]):
        done = subprocess.run([sys.executable, "-c", FACTORY, *constants], capture_output=True, text=True, timeout=120)
        assert done.returncode == 0, done.stderr
        speeds.append([float(line) for line in done.stdout.split()])
    assert speeds == [[2.0], [3.0], [2.0, 3.0]]


if __name__ == "__main__":
    kind, root, *names = sys.argv[1:]
    warnings.simplefilter("error")
    if kind == "keys":
        found = []
        for name in names:
            with imported(Path(root) / name) as scene:
                found.append(key(scene.force))
    else:
        found = {name: facts(EDITS[name], int(kind), Path(root) / name) for name in names}
    print(json.dumps(found))
