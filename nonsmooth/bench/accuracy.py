"""``nonsmooth bench accuracy [--peers] [--out FILE]``: error against run time on the scenes of the field.

Every integrator of this package at a row of steps or tolerances on eleven scenes; with ``--peers`` also other programs
on the scenes that they can express (Siconos, SciPy with events written by hand, MuJoCo), each where it is installed.
References are closed forms where there are any, else `EventDriven` beside `Adaptive`, which are two methods of their
own; of slider-crank and woodpecker `EventDriven` at two tolerances, since time steps meet their impacts too slowly (the
tests of these models compare them). What references differ by is in the tables. With ``--out`` the page
docs/benchmarks/accuracy.md is written, its figure beside it.
"""

from __future__ import annotations

import argparse
import math
import os
import platform
from pathlib import Path
from typing import Any

import numpy as np

from nonsmooth.bench.accuracy_page import page
from nonsmooth.catalogue import load_model
from nonsmooth.integrators.adaptive import Adaptive
from nonsmooth.integrators.event_driven import EventDriven
from nonsmooth.integrators.moreau_jean import MoreauJean
from nonsmooth.studies.work_precision import TIMES, TOLERANCES, OwnMethod, Scene, work_precision
from nonsmooth.studies.work_precision_result import joined

BEADS = 20  # the dense Jacobian of an implicit method is not made for a hundred
REPEATS = 5
CROWDED = (EventDriven(rtol=1e-12, atol=1e-14), EventDriven(rtol=1e-10, atol=1e-12))  # where impacts crowd
FINEST_ADAPTIVE = 10  # of the tolerances: below 1e-10 its steps are as small as rounding


def scenes() -> dict[str, Scene]:
    """The motions."""
    ball = load_model("bouncing-ball")(e=0.5)
    block = load_model("sliding-block")(mu=0.3)
    beads = load_model("bead-chain")(n=BEADS)
    belt = load_model("belt-oscillator")(k=10.0, c=0.1, m0=0.4, m1=0.45, m3=0.6, vb=0.2, N=1.0)
    rod = load_model("painleve-rod")(mu=0.5)
    sprag_slip = load_model("sprag-slip")
    set_1 = sprag_slip.set_1(cth=0.5)
    return {
        "ball through Zeno": motion(ball, 2.0, reference=lambda t: [ball.height(t)], height=1.0),
        "sliding block": motion(block, 1.0, reference=lambda t: [block.position(t), 0.0], speed=2.0),
        "rod, slip and stick": motion(rod, 0.3, th=math.pi / 3, thdot=0.0, slip=1.0),
        "belt, stick-slip": motion(belt, 20.0),
        "rocking block": motion(load_model("rocking-block")(), 3.0),
        "pendulum against a wall": motion(load_model("wall-pendulum")(), 5.0),
        "sprag-slip, limit cycle": motion(set_1, 3.0, th=0.8, thdot=0.0),
        "sprag-slip, seizures": motion(sprag_slip(), 3.0, th=0.8, thdot=0.0),
        "bead chain": motion(beads, 2.0, reference=lambda t: beads.exact(t)[0]),
        "slider-crank": motion(load_model("slider-crank")(), 0.2, reference=CROWDED),
        "woodpecker": motion(load_model("woodpecker")(), 0.6, reference=CROWDED),
    }


def motion(model: Any, t_end: float, reference: Any = None, **state: float) -> Scene:
    """A motion from natural variables."""
    times = np.linspace(0.0, t_end, TIMES + 1)[1:]
    q0, u0 = model.state(**state)
    return Scene(model, (0.0, t_end), q0, u0, times, reference)


def methods() -> dict[str, Any]:
    """The integrators of this package."""
    return {
        "MoreauJean": MoreauJean,
        "Adaptive": OwnMethod(Adaptive, tuple(rtol for rtol in TOLERANCES if rtol >= 10.0**-FINEST_ADAPTIVE)),
        "EventDriven": EventDriven,
    }


def main(argv: list[str] | None = None) -> int:
    """Measure, print, write the page; returns the exit code."""
    parser = argparse.ArgumentParser(prog="nonsmooth bench accuracy", description="error against run time")
    parser.add_argument("--peers", action="store_true", help="other programs too, where they are installed")
    parser.add_argument("--out", type=Path, metavar="FILE", help="write the page and its figure")
    parser.add_argument("scenes", nargs="*", metavar="WORD", help="only the scenes whose names contain one of these")
    parser.add_argument("--repeats", type=int, default=REPEATS, help=f"{REPEATS} by default")
    options = parser.parse_args(argv)
    measured = methods()
    if options.peers:
        from nonsmooth.bench.peers import peers

        measured |= peers()
    chosen = {
        name: scene for name, scene in scenes().items()
        if not options.scenes or any(word in name for word in options.scenes)
    }  # fmt: skip
    studies = []
    try:
        for name, scene in chosen.items():
            studies.append(work_precision({name: scene}, measured, repeats=options.repeats))
            print(studies[-1].table(), flush=True)
    finally:
        for method in measured.values():
            getattr(method, "close", int)()
    study = joined(studies)
    if options.out:
        figure = options.out.with_suffix(".png")
        study.plot(figure)
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
