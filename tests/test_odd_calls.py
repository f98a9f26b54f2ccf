"""Random calls of every public function with arguments that nobody would give: each works, or is refused in a sentence.

A few hundred stand here; `pytest -m slow tests/test_odd_calls.py` makes three thousand. An argument is replaced by a
value of the list below, or by one hidden in a list, a tuple, a dict or an array. What is given instead of a function
may raise anything, and objects may raise wherever they are asked what they are.
"""

from __future__ import annotations

import contextlib
import datetime
import decimal
import fractions
import importlib.util
import io
import math
import signal
import warnings
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns
from models import BouncingBall

SPEC = importlib.util.spec_from_file_location("bad_input_of_odd_calls", Path(__file__).with_name("test_bad_input.py"))
BAD_INPUT = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(BAD_INPUT)
COSTLY = {"sweep": {"timeout", "workers"}}  # arguments that start processes, of a second each
PATIENCE = 20  # s for one call; the calls below take milliseconds
BALL = BouncingBall(e=0.5)


class Stop(BaseException):
    """What is no Exception, as SystemExit is none."""


def raising(error):
    """A function that raises, whatever it is called with."""

    def function(*arguments, **more):
        raise error

    return function


class Hostile:
    """Raises wherever it is asked what it is."""

    def __init__(self, error):
        self.error = error

    def _raise(self, *_):
        raise self.error

    __array__ = __len__ = __float__ = __int__ = __index__ = __iter__ = __bool__ = __getitem__ = __repr__ = _raise
    __str__ = __eq__ = __lt__ = __gt__ = __le__ = __ge__ = __call__ = __fspath__ = __contains__ = _raise
    __array_interface__ = property(_raise)
    __hash__ = None


class Liar:
    """Says that it is long, and is not; that it is an array, and is none."""

    shape, ndim, dtype, size = (2,), 1, np.dtype(float), 2

    def __len__(self):
        return 2

    def __getitem__(self, key):
        raise IndexError("nothing there")

    def __array__(self, dtype=None, copy=None):
        return "no array"


class Unhashable(list):
    """A sequence that cannot be a key."""


class Half(NamedTuple):
    m: object = None
    n: int = 10**400


def odd_values():
    """Fresh values: some are used up when they are looked at."""
    return [
        None, True, False, 0, 1, -1, 2, 7, 10**400, -(10**400), 0.0, -0.0, 0.5, -0.5, 1.5, math.nan, math.inf,
        -math.inf, 5e-324, 1e300, -1e300, 1e-300, 1j, 1 + 2j, complex(math.nan, 0), "", " ", "x", "auto", "nan", "1e-3",
        "\0", "é" * 300, "a/b\nc", b"", b"\0\xff", bytearray(b"x"), [], (), {}, set(), {1.5}, frozenset(), [[]], [None],
        [math.nan], [1.0, [2.0]], [[1.0, 2.0], [3.0]], ["a"], [1j], {"e": None}, {"e": [0.1]}, {1: 2}, {"": []},
        range(0), range(3), iter([1.0]), (value for value in [1.0, 2.0]), map(float, ["x"]), np.float64(math.nan),
        np.float32(0.5), np.int8(1), np.bool_(True), np.array(1.0), np.array("x"), np.array(None), np.zeros(0),
        np.zeros((0, 3)), np.zeros((2, 2)), np.full((2, 2, 2), math.nan), np.array([1 + 1j]), np.complex128(1 + 2j),
        np.array([None, {}], dtype=object), np.array(["a", "b"]), np.datetime64("2020-01-01"),
        np.ma.masked_array([1.0, 2.0], [True, False]), np.zeros(2, dtype=[("a", float)]), decimal.Decimal("NaN"),
        fractions.Fraction(1, 3), datetime.date(2020, 1, 1), object(), type, BouncingBall, ns.System, ns, Ellipsis,
        NotImplemented, slice(None), lambda: None, lambda *a: None, lambda *a: "x", raising(ValueError("odd")),
        raising(KeyError("odd")), raising(StopIteration()), raising(Stop("odd")), raising(SystemExit(3)), print,
        Hostile(TypeError("odd")), Hostile(ZeroDivisionError("odd")), Hostile(RuntimeError("odd\ntwo lines")), Liar(),
        Unhashable([1.0]), Half(), BALL, BALL.system(), ns.MoreauJean(1e-3), ns.MoreauJean, ns.EventDriven(),
        ns.Contact(), Path("nowhere/at/all"), Path("."), io.StringIO("x"), ns.Status.FINISHED, ValueError("an error"),
        ns.Coulomb(0.3),
    ]  # fmt: skip


WRAPPINGS = [lambda x: [x], lambda x: (x, x), lambda x: [1.0, x], lambda x: {"e": x}, lambda x: [[x]], lambda x: {x: x},
             lambda x: np.array([x], dtype=object)]  # fmt: skip


def targets(solution):
    """The calls that work, by name: those of the table, and the methods of what comes back."""
    calls = {name: call for name, call in BAD_INPUT.CALLS.items() if name not in BAD_INPUT.SLOW}
    ball = calls["simulate"][1] | {"max_steps": 50, "checkpoint": None, "resume": None, "checkpoint_every": 1.0}
    system = BALL.system()
    return calls | {
        "simulate": (ns.simulate, ball),
        "simulate, located": (ns.simulate, ball | {"integrator": ns.EventDriven()}),
        "simulate, refined": (ns.simulate, ball | {"integrator": ns.Adaptive()}),
        "simulate, compliant": (ns.simulate, ball | {"integrator": ns.Penalty(1e5, damping_ratio=0.1)}),
        "System.with_parameters": (system.with_parameters, {"e": 0.5, "g": 9.81}),
        "Solution()": (solution, {"t": 0.1, "side": "right"}),
        "Solution.save": (solution.save, {"path": "kept.npz"}),
        "Solution.plot": (solution.plot, {"path": None}),
        "Solution.picture": (solution.picture, {"path": None, "n": 2}),
        "Solution.view": (solution.view, {"path": None}),
        "BouncingBall": (BouncingBall, {"m": 1.0, "g": 9.81, "e": 0.5}),
        "BouncingBall.state": (BALL.state, {"height": 1.0, "velocity": 0.0}),
    }


def described(arguments):
    """The arguments in a message; a repr may raise."""
    texts = []
    for name, value in arguments.items():
        try:
            texts.append(f"{name}={value!r}"[:100])
        except BaseException:
            texts.append(f"{name}=<{type(value).__name__}>")
    return ", ".join(texts)


@contextlib.contextmanager
def at_most(seconds):
    """Raise in a call that takes longer."""

    def late(number, frame):
        raise TimeoutError(f"more than {seconds} s")

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def odd_call(rng, calls):
    """One random call: its name, its arguments, and what came of it that should not, or nothing."""
    name = str(rng.choice(sorted(calls)))
    function, good = calls[name]
    if name in BAD_INPUT.FILES:
        BAD_INPUT.FILES[name]()
    chosen = rng.choice(sorted(good.keys() - COSTLY.get(name, set())), size=int(rng.choice([1, 1, 1, 2, 3])))
    changes = {}
    for argument in chosen.tolist():
        values = odd_values()
        value = values[int(rng.integers(len(values)))]
        if rng.random() < 0.3:
            with contextlib.suppress(BaseException):  # an unhashable key
                value = WRAPPINGS[int(rng.integers(len(WRAPPINGS)))](value)
        changes[argument] = value
    said = f"{name}({described(changes)})"
    try:
        with warnings.catch_warnings(), at_most(PATIENCE), contextlib.redirect_stdout(io.StringIO()):
            warnings.simplefilter("ignore")
            function(**good | changes)
    except ns.NonsmoothError as refusal:
        text = str(refusal)
        return "" if "\n" not in text and 15 < len(text) < 1500 else f"{said} said {text[:300]!r}"
    except BaseException as error:
        return f"{said} raised {type(error).__name__}: {str(error)[:200]}"
    return ""


def close_figures():
    from matplotlib import pyplot

    pyplot.close("all")


@pytest.fixture(scope="module")
def calls(tmp_path_factory):
    """Each is made once as it should be: what it compiles is not counted against it."""
    with pytest.MonkeyPatch.context() as patch, contextlib.redirect_stdout(io.StringIO()):
        patch.chdir(tmp_path_factory.mktemp("odd"))
        patch.setenv("MPLBACKEND", "Agg")
        calls = targets(ns.simulate(BALL, (0, 0.5), [1.0], [0.0], integrator=ns.EventDriven()))
        for name, (function, good) in calls.items():
            if name in BAD_INPUT.FILES:
                BAD_INPUT.FILES[name]()
            function(**good)
        close_figures()
    return calls


def make_calls(n, seed, calls):
    rng = np.random.default_rng(seed)
    found = []
    for _ in range(n):
        found.append(odd_call(rng, calls))
        close_figures()
    return [fault for fault in found if fault]


@pytest.fixture(autouse=True)
def in_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")


def test_odd_calls_work_or_are_refused_in_a_sentence(calls):
    faults = make_calls(300, 1, calls)
    assert not faults, "\n".join(faults)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10))
def test_three_thousand_odd_calls_work_or_are_refused_in_a_sentence(seed, calls):
    faults = make_calls(300, 100 + seed, calls)
    assert not faults, "\n".join(faults)
