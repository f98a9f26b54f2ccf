"""Random edits of a model's sources: a literal, an operator or a name anywhere, in any of its files.

After each edit the force is computed by Python alone (numba's decorators do nothing then) at some states. Where it
differs, the key under which machine code is kept must differ; where only the text was written anew, it must not; and
the same text has the same key in another folder. Some edited models are compiled and compared with the interpreter.
"""

import ast
import importlib
import random
import sys
from contextlib import contextmanager

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.jit import survey_of
from nonsmooth.mechanics.system import FORCE

SOURCES = {
    "scene": '''
"""A force made of all that is read in some way."""
import math
from enum import IntEnum
from typing import NamedTuple
import numba
import numpy as np
import hh
import pk.c
import pk.c as alias
from hh import imported


class Side(IntEnum):
    """Of the spring."""
    LEFT = 1
    RIGHT = 2


class Spring(NamedTuple):
    """Its numbers."""
    stiffness: float
    length: float


SPRING = Spring(2.5, 0.75)
TABLE = np.array([0.5, 1.25, 2.0, 0.125])
PAIR = (1.5, (0.25, 3))
GAIN, LEVEL, SIDE = 1.75, 0.375, 2
FINE = np.linspace(0.0, 1.0, 50)


def plain(x, scale=1.25):
    """A helper that calls another."""
    return scale * x + other(x) - GAIN


def other(x):
    if x > LEVEL:
        return 0.5 * x
    return x - 0.25


@numba.njit
def jitted(x):
    return 1.5 * x + LEVEL * other_jitted(x)


@numba.njit
def other_jitted(x):
    return x - 2.0 * GAIN


@numba.vectorize
def vectorised(x):
    return 0.75 * x + GAIN


def around(a, b):
    weights = np.array([0.5, 0.25, a])

    def inside(x):
        return a * x - b + weights[2] * weights[0]

    return inside


closed = around(1.125, 0.625)


def force(t, q, u, p, h):
    """The sum of all."""
    bent = lambda x: 0.875 * x + GAIN
    def inner(x, slope=0.5):
        return slope * x + hh.K
    values = [TABLE[i] * q[0] for i in range(3)]
    total = plain(q[0]) + jitted(q[1]) - vectorised(q[0])
    total += bent(q[1]) + inner(q[0]) + closed(q[1])
    total += values[0] + values[2] + len([i for i in range(9) if i > 4])
    total += SPRING.stiffness * (q[0] - SPRING.length) + PAIR[1][0] * PAIR[0]
    total += hh.k(q[0]) + hh.L * pk.c.M - alias.c(q[1]) + imported(q[0])
    total += hh.TABLE[1] * FINE[17] + pk.c.NUMBERS.b
    if SIDE == Side.RIGHT and q[1] < 1.5:
        total -= math.sin(q[1]) * 0.125
    for i in range(3):
        total += u[0] * TABLE[i] * 0.0625
    h[0] = total
''',
    "hh": '''
"""Constants and helpers."""
import numpy as np
K, L = 0.875, 1.25
TABLE = np.array([1.0, 0.5, 0.25])


def k(x):
    return K * x + [L * j for j in range(3)][2]


def imported(x):
    return (lambda y: y * 0.375 - L)(x)
''',
    "pk/__init__": "",
    "pk/c": """
from typing import NamedTuple
import numba


class Numbers(NamedTuple):
    a: float
    b: float


M = 0.625
NUMBERS = Numbers(0.5, 1.75)


@numba.njit
def c(x):
    return x * M - NUMBERS.a
""",
}
NUMBERS_OF = {  # names that may stand for each other
    "scene": [("GAIN", "LEVEL"), ("plain", "other", "closed", "imported"), ("jitted", "other_jitted"), ("q", "u")],
    "hh": [("K", "L")],
    "pk/c": [],
}
ATTRIBUTES = [("K", "L"), ("stiffness", "length"), ("a", "b"), ("LEFT", "RIGHT"), ("sin", "cos")]
OPERATORS = [ast.Add, ast.Sub, ast.Mult]
COMPARISONS = [ast.Gt, ast.Lt, ast.GtE, ast.LtE]
STATES = [((0.7, 1.3), (0.9, -0.2)), ((-0.4, 2.1), (0.3, 0.8)), ((0.2, -0.6), (-1.1, 0.5))]


class Edit(ast.NodeTransformer):
    """Change the node of a number; count the nodes that can be changed."""

    def __init__(self, rng, groups, chosen=-1):
        self.rng, self.groups, self.chosen, self.count = rng, groups, chosen, 0

    def generic_visit(self, node):
        super().generic_visit(node)
        change = self.change_of(node)
        if change is None:
            return node
        self.count += 1
        if self.count - 1 == self.chosen:
            change()
        return node

    def change_of(self, node):
        """What can be done to a node, or None."""
        if isinstance(node, ast.Constant) and type(node.value) in (int, float):
            return lambda: setattr(node, "value", self.other_number(node.value))
        if isinstance(node, ast.BinOp) and type(node.op) in OPERATORS:
            return lambda: setattr(node, "op", self.other(type(node.op), OPERATORS)())
        if isinstance(node, ast.Compare) and type(node.ops[0]) in COMPARISONS:
            return lambda: setattr(node, "ops", [self.other(type(node.ops[0]), COMPARISONS)()])
        for label, groups in (("id", self.groups), ("attr", ATTRIBUTES)):
            name = getattr(node, label, None)
            for group in groups:
                if name in group and isinstance(node.ctx, ast.Load):
                    return lambda label=label, name=name, group=group: setattr(node, label, self.other(name, group))
        return None

    def other(self, one, group):
        return self.rng.choice([each for each in group if each != one])

    def other_number(self, value):
        if type(value) is int:
            return self.rng.choice([value + 1, max(value - 1, 0) if value else 2])
        return self.rng.choice([value + 1e-9, -value, 2.0 * value, value + 0.25])


def edited(rng):
    """The sources with one change."""
    name = rng.choice([name for name in SOURCES for _ in range(len(SOURCES[name]) // 100)])
    tree = ast.parse(SOURCES[name])
    counting = Edit(rng, NUMBERS_OF[name])
    counting.visit(tree)
    Edit(rng, NUMBERS_OF[name], rng.randrange(counting.count)).visit(tree)
    return {**SOURCES, name: ast.unparse(tree)}


def undecorated(target=None, **options):
    """In place of numba's decorators."""
    return target if callable(target) else undecorated


@contextmanager
def imported(sources, folder):
    """The scene, whose modules are forgotten afterwards."""
    for name, text in sources.items():
        path = folder / f"{name}.py"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(folder))
        patch.setattr(sys, "dont_write_bytecode", True)
        try:
            yield importlib.import_module("scene")
        finally:
            for name in [name for name in sys.modules if name.partition(".")[0] in ("scene", "hh", "pk")]:
                del sys.modules[name]


def by_python(sources, folder):
    """The force at some states; None where Python refuses the edited text."""
    found = []
    try:
        with pytest.MonkeyPatch.context() as patch:
            for name in ("njit", "vectorize"):
                patch.setattr(f"numba.{name}", undecorated)
            with imported(sources, folder) as scene:
                for q, u in STATES:
                    h = np.zeros(1)
                    scene.force(0.0, np.array(q), np.array(u), (), h)
                    found.append(h[0])
    except Exception:
        return None
    return found


def mass(t, q, p, M):
    M[0, 0] = M[1, 1] = 1.0


def key(sources, folder):
    with imported(sources, folder) as scene:
        system = ns.System(n_q=2, mass=mass, force=scene.force)
        return survey_of({FORCE: (scene.force, True, (2,))}, 2, 2, system.unpack, 0).digest()


def velocity(system):
    run = {"t_span": (0, 1), "q0": STATES[0][0], "u0": STATES[0][1], "integrator": ns.MoreauJean(dt=1.0)}
    return ns.simulate(system, **run).u[-1, 0]


@pytest.mark.upkeep
@pytest.mark.parametrize(("edits", "compiled"), [(60, 3), pytest.param(500, 40, marks=pytest.mark.slow)])
def test_a_random_edit_changes_the_key_and_the_same_text_keeps_it(edits, compiled, tmp_path):
    rng = random.Random(edits)
    before = by_python(SOURCES, tmp_path / "0"), key(SOURCES, tmp_path / "0")
    rewritten = {name: ast.unparse(ast.parse(text)) for name, text in SOURCES.items()}  # without comments and blanks
    assert key(rewritten, tmp_path / "rewritten") == before[1]
    done = changed = 0
    while done < edits:
        sources, folder = edited(rng), tmp_path / str(done)
        value = by_python(sources, folder)
        if value is None:
            continue
        done += 1
        found = key(sources, folder)
        assert found == key(sources, tmp_path / "again"), sources
        assert value == before[0] or found != before[1], sources
        changed += value != before[0]
        if done % (edits // compiled) == 0:
            compare_with_the_interpreter(sources, folder)
    assert changed > 0.8 * edits


def compare_with_the_interpreter(sources, folder):
    with imported(sources, folder) as scene:
        system = ns.System(n_q=2, mass=mass, force=scene.force)
        found = velocity(system)
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv("NONSMOOTH_INTERPRET", "1")
            assert found == pytest.approx(velocity(system), rel=1e-13), sources
