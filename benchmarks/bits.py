"""Hashes of what runs give, to show that a change of the code changed no bit.

    python -m benchmarks bits before.json                  # before the change
    python -m benchmarks bits after.json before.json       # after it: what differs is named, and the exit code is 1

Every model under every integrator and selection rule, and random systems; compiled, and for a few steps interpreted. A
case is hashed over its times, states, impulses, modes, events and energy ledger, byte by byte. Who changes arithmetic
on purpose says so in the commit. The hashes hold for one machine, and are kept by nobody.
"""

from __future__ import annotations

import hashlib
import json
import os
import sys
import time
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import models
import nonsmooth as ns
from benchmarks.stress_random import sample
from nonsmooth.errors import InvalidInput

SELECTIONS = ("compliant-limit", "lift-off", "impact")
SEEDS = 80  # random systems
PART = {"compiled": 0.2, "interpreted": 0.01}  # of the time that a model is shown for
MOST_STEPS = {"compiled": 20_000, "interpreted": 60}


def main(words: list[str]) -> int:
    """Write the hashes of all cases to words[0], and compare them with those of words[1]."""
    if not 1 <= len(words) <= 2:
        raise InvalidInput("bits takes the file to write, and the file to compare with if there is one")
    found: dict[str, str] = {}
    warnings.simplefilter("ignore")
    for twin in PART:
        began = time.perf_counter()
        os.environ["NONSMOOTH_INTERPRET"] = str(int(twin == "interpreted"))
        found |= {f"{twin} | {name}": digest_of(case, MOST_STEPS[twin]) for name, case in cases(twin)}
        print(f"{twin}: {time.perf_counter() - began:.0f} s", file=sys.stderr)
    Path(words[0]).write_text(json.dumps(found, indent=0))
    return compare(json.loads(Path(words[1]).read_text()), found) if len(words) == 2 else 0


def compare(before: dict[str, str], after: dict[str, str]) -> int:
    """Name what differs; 1 if anything does."""
    different = [name for name in before if after.get(name) != before[name]]
    print(f"{len(before) - len(different)} of {len(before)} cases have the same bits")
    for name in different:
        print(f"differs: {name}: {before[name]} before, {after.get(name)} now")
    return int(bool(different))


def integrators(dt: float) -> dict[str, Any]:
    """One of each kind."""
    return {
        "moreau-jean": ns.MoreauJean(dt),
        "moreau-jean theta 1": ns.MoreauJean(dt, theta=1.0),
        "moreau-jean projection": ns.MoreauJean(dt, projection=True),
        "moreau-jean compliance": ns.MoreauJean(dt, theta=1.0, compliance=ns.Compliance(1e6)),
        "adaptive": ns.Adaptive(1e-6, 1e-8),
        "event-driven": ns.EventDriven(1e-8, 1e-10),
        "penalty": ns.Penalty(1e6, damping_ratio=0.3),
    }


def cases(twin: str) -> Iterator[tuple[str, tuple[Any, ...]]]:
    """Names, and (system, time span, start, integrator, selection)."""
    for name in models.__all__:
        model = getattr(models, name)()
        for label, integrator in integrators(model.dt).items():
            for selection in SELECTIONS:
                span = (0.0, PART[twin] * model.t_end)
                yield f"{name} | {label} | {selection}", (model, span, model.state(), integrator, selection)
    for seed in range(SEEDS if twin == "compiled" else 6):
        drawn = sample(seed)
        start, span = (drawn.q0, drawn.u0), (0.0, 0.3 if twin == "compiled" else 0.01)
        for label in ("moreau-jean", "adaptive", "event-driven"):
            yield f"random {seed} | {label}", (drawn.system, span, start, integrators(1e-3)[label], drawn.selection)
        stiff = ns.Penalty(1e8, damping_ratio=1.0)
        yield f"random {seed} | penalty", (drawn.system, span, start, stiff, drawn.selection)


def digest_of(case: tuple[Any, ...], max_steps: int) -> str:
    """The hash of a run, or why there is none."""
    system, span, start, integrator, selection = case
    try:
        solution = ns.simulate(
            system, span, *start, integrator=integrator, selection=selection, on_failure="return", max_steps=max_steps
        )
    except ns.NonsmoothError as error:
        return f"{type(error).__name__}: {error}"
    return digest(solution)


def digest(solution: ns.Solution) -> str:
    """A hash of all that a solution holds of the motion."""
    total = hashlib.sha256(f"{solution.status.name} {solution.stats.steps}".encode())
    columns = (
        solution.t, solution.q, solution.u, solution.g_N, solution.P_N, solution.P_F, solution.mode, solution.slip,
        solution.event_rows,
    )  # fmt: skip
    for column in (*columns, *(solution.ledger[name] for name in sorted(solution.ledger))):
        total.update(np.ascontiguousarray(column).tobytes())
    return total.hexdigest()[:16]
