"""``python -m benchmarks symbolic``: what a model from energies costs, to derive, to compile, and to evaluate.

Chains of equal planar links with two contacts, in absolute angles (each link from below) and in relative ones (each
from the link before). Deriving and compiling are measured in processes of their own, in processor time, with an empty
cache and again with what the first one kept; what a process pays for its first model whatever it is, is taken off by a
small one that is compiled before. Functions are measured in pairs with those of `hand_written_chain`, in turn.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import hand_written_chain
from nonsmooth.jit import call_model, compile_model, kernel
from nonsmooth.mechanics.system import FUNCTION_NAMES, TAKES_U, System

REPEATS, CALLS = 15, 20_000
ROOT = Path(__file__).parents[1]
CHAINS = ((2, False), (5, False), (5, True), (10, False), (10, True))
SCRIPT = "from benchmarks.symbolic import print_cost; print_cost({n}, {relative}, {jacobians})"


def main(argv: list[str] | None = None) -> int:
    """Print the tables; returns the exit code."""
    print("| chain | Jacobians | derive [s] | compile [s] | both, from the cache [s] |\n|---|---|---|---|---|")
    for n, relative in CHAINS:
        for jacobians in (True, False):
            cost = costs(n, relative, jacobians)
            print(
                f"| {n} links, {'relative' if relative else 'absolute'} | {'yes' if jacobians else 'no'} | {cost} |",
                flush=True,
            )
    print(
        "\n| 5 links | derived [ns] | by hand, loops [ns] | by hand, written out [ns] | ratio to the faster, in pairs |"
        "\n|---|---|---|---|---|"
    )
    for name in hand_written_chain.WITH_LOOPS:
        print(speeds(name), flush=True)
    return 0


def chain(n: int, relative: bool = False) -> Any:
    """The declaration of a chain of n links with a wall at its tip and a ground below its middle."""
    import sympy as sp

    import nonsmooth as ns

    l = ns.lagrangian(f"{'relative ' if relative else ''}chain of {n} links")
    named = l.coordinates(" ".join(f"th{k + 1}" for k in range(n)), unit="rad")
    th = named if n > 1 else (named,)
    m, a, I, g, mu, e = l.parameters(m=(1.0, "kg"), a=(0.5, "m"), I=(0.02, "kg m^2"), g=(9.81, "m/s^2"), mu=0.3, e=0.4)
    joints, angle = [(sp.S.Zero, sp.S.Zero)], sp.S.Zero
    for k in range(n):
        angle = angle + th[k] if relative else th[k]
        (x, y), along = joints[-1], (a * sp.sin(angle), -a * sp.cos(angle))
        l.rigid_body(m, I, at=(x + along[0] / 2, y + along[1] / 2), angle=angle)
        joints.append((x + along[0], y + along[1]))
    l.gravity(g)
    l.contact(point=joints[-1], normal=(-1, 0), offset=n / 4, mu=mu, e=e)
    l.contact(point=joints[n // 2 + 1], normal=(0, 1), offset=n / 2, mu=mu, e=e)
    return l


def costs(n: int, relative: bool, jacobians: bool) -> str:
    """Processor seconds: deriving and compiling with an empty cache, and both with what was kept."""
    with tempfile.TemporaryDirectory() as folder:
        environment = os.environ | {"NONSMOOTH_CACHE_DIR": folder, "PYTHONPATH": str(ROOT)}
        rows = []
        for _ in range(2):
            command = [sys.executable, "-c", SCRIPT.format(n=n, relative=relative, jacobians=jacobians)]
            run = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
            rows.append([float(word) for word in run.stdout.split()])
    return f"{rows[0][0]:.2f} | {rows[0][1]:.2f} | {sum(rows[1]):.2f}"


def print_cost(n: int, relative: bool, jacobians: bool) -> None:
    """Processor seconds of deriving, and of compiling."""
    from nonsmooth.mechanics.compiled import model_of

    model_of(chain(1).model().system())  # what any first model pays
    declaration = chain(n, relative)
    start = time.process_time()
    system = declaration.model(jacobians=jacobians).system()
    derived = time.process_time()
    model_of(system)
    print(derived - start, time.process_time() - derived)


@kernel("float64(int64, int64, int64, float64[::1], float64[::1], float64[::1], float64[::1])")
def call_often(model, which, calls, q, u, p, out):
    total = 0.0
    for _ in range(calls):
        q[0] += 1e-9
        call_model(model, which, 0.0, q, u, p, out)
        total += out[0]
    return total


def speeds(name: str) -> str:
    """A row of the table: nanoseconds a call, medians of paired repeats."""
    system = chain(5).model().system()
    which = FUNCTION_NAMES[name]
    forms = [system.functions[which], hand_written_chain.WITH_LOOPS[name], hand_written_chain.OF_FIVE[name]]
    agree(system, which, forms)
    models = [compiled(system, which, form) for form in forms]
    times: list[list[float]] = [[], [], []]
    for _ in range(REPEATS):
        for k, model in enumerate(models):
            times[k].append(nanoseconds(model.address, which, system))
    faster = min((1, 2), key=lambda k: statistics.median(times[k]))
    ratio = statistics.median(a / b for a, b in zip(times[0], times[faster], strict=True))
    medians = [f"{statistics.median(row):.0f}" for row in times]
    medians[2] = medians[2] if forms[2] is not forms[1] else ""
    return f"| `{name}` | {' | '.join(medians)} | {ratio:.2f} |"


def compiled(system: System, which: int, function: Any) -> Any:
    """Machine code of one function."""
    functions = {which: (function, which in TAKES_U, system.shape_of(which))}
    return compile_model(functions, system.n_q, system.n_u, system.unpack, system.p.size)


def nanoseconds(address: int, which: int, system: System) -> float:
    """Of one call."""
    q, u = np.linspace(0.1, 0.7, system.n_q), np.linspace(-1.0, 2.0, system.n_u)
    out = np.zeros(system.shape_of(which)).reshape(-1)
    start = time.process_time()
    call_often(address, which, CALLS, q, u, system.p, out)
    return (time.process_time() - start) / CALLS * 1e9


def agree(system: System, which: int, forms: list[Any]) -> None:
    """Refuse to time what does not compute the same."""
    rng = np.random.default_rng(5)
    for _ in range(10):
        q, u = rng.uniform(-1, 1, system.n_q), rng.uniform(-2, 2, system.n_u)
        arrays = []
        for form in forms:
            out = np.zeros(system.shape_of(which))
            form(0.0, q, u, system.unpacked, out) if which in TAKES_U else form(0.0, q, system.unpacked, out)
            arrays.append(out)
        for other in arrays[1:]:
            np.testing.assert_allclose(arrays[0], other, rtol=0, atol=1e-13 * np.abs(other).max())
