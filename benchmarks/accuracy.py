"""``python -m benchmarks accuracy [--peers] [--out FILE]``: error against run time on the scenes of the field.

Every integrator of this package at a row of steps or tolerances on eleven scenes; with ``--peers`` also other programs
on the scenes that they can express (Siconos, SciPy with events written by hand, MuJoCo), each where it is installed.
References are closed forms where there are any, else `EventDriven` beside `Adaptive`, which are two methods of their
own; of slider-crank and woodpecker `EventDriven` at two tolerances, since time steps meet their impacts too slowly (the
tests of these models compare them). What references differ by is in the tables. With ``--out`` the page
docs/benchmarks/accuracy.md is written, its figure beside it.
"""

from __future__ import annotations

import argparse
import os
import platform
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.accuracy_page import page
from benchmarks.motions import motions
from nonsmooth.errors import InvalidInput
from nonsmooth.integrators.adaptive.options import Adaptive
from nonsmooth.integrators.event_driven.options import EventDriven
from nonsmooth.integrators.moreau_jean.options import MoreauJean
from nonsmooth.studies.work_precision import TIMES, WORK_TOLERANCES, OwnMethod, TimedMotion, work_precision
from nonsmooth.studies.work_precision_result import joined

REPEATS = 5
CROWDED = (EventDriven(rtol=1e-12, atol=1e-14), EventDriven(rtol=1e-10, atol=1e-12))  # where impacts crowd
FINEST_ADAPTIVE = 10  # of the tolerances: below 1e-10 its steps are as small as rounding


def scenes() -> dict[str, TimedMotion]:
    """The motions, each with its reference."""
    found = motions()
    ball, block, beads = (found[name].model for name in ("ball through Zeno", "sliding block", "bead chain"))
    references = {
        "ball through Zeno": lambda t: [ball.height(t)],
        "sliding block": lambda t: [block.position(t), 0.0],
        "bead chain": lambda t: beads.exact(t)[0],
        "slider-crank": CROWDED,
        "woodpecker": CROWDED,
    }
    scenes = {}
    for name, motion in found.items():
        times = np.linspace(0.0, motion.t_end, TIMES + 1)[1:]
        scenes[name] = TimedMotion(motion.model, (0.0, motion.t_end), *motion.state, times, references.get(name))
    return scenes


def methods() -> dict[str, Any]:
    """The integrators of this package."""
    return {
        "MoreauJean": MoreauJean,
        "Adaptive": OwnMethod(Adaptive, tuple(rtol for rtol in WORK_TOLERANCES if rtol >= 10.0**-FINEST_ADAPTIVE)),
        "EventDriven": EventDriven,
    }


def main(argv: list[str] | None = None) -> int:
    """Measure, print, write the page; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks accuracy", description="error against run time")
    parser.add_argument("--peers", action="store_true", help="other programs too, where they are installed")
    parser.add_argument("--out", type=Path, metavar="FILE", help="write the page and its figure")
    parser.add_argument("scenes", nargs="*", metavar="WORD", help="only the scenes whose names contain one of these")
    parser.add_argument("--repeats", type=int, default=REPEATS, help=f"{REPEATS} by default")
    options = parser.parse_args(argv)
    measured = methods()
    if options.peers:
        from benchmarks.peers import peers

        measured |= peers()
    chosen = {
        name: scene for name, scene in scenes().items()
        if not options.scenes or any(word in name for word in options.scenes)
    }  # fmt: skip
    if not chosen:
        raise InvalidInput(
            f"no scene's name contains {' or '.join(map(repr, options.scenes))}; there are {', '.join(scenes())}"
        )
    studies = []
    try:
        for name, scene in chosen.items():
            studies.append(work_precision({name: scene}, measured, repeats=options.repeats))  # whole, or not at all
            print(studies[-1].table(), flush=True)
    finally:
        for method in measured.values():
            getattr(method, "close", int)()
    study = joined(studies)
    if options.out:
        figure = options.out.with_suffix(".png")
        study.plot(figure)
        study.plot(figure.with_stem(f"{figure.stem}_evaluations"), cost="evaluations")
        options.out.write_text(page(study, machine(), figure.name, options.repeats))
        print(f"page: {options.out}")
    return 0


def machine() -> str:
    """The machine in a line."""
    model = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.is_file():
        names = [
            line.split(":", 1)[1].strip() for line in info.read_text().splitlines() if line.startswith("model name")
        ]
        model = names[0] if names else model
    return f"{os.cpu_count()} x {model}, {platform.system()}, Python {platform.python_version()}"
