"""``python -m benchmarks precision [FILE] [NAME ...]``: run time against error of ten scenes of bodies.

Each method over its steps or tolerances, in one process: the least processor time of ROUNDS runs, and the largest
distance of a centre from where it should be at the end. Ours are timed with all that `simulate` does, other programs
over their steps alone. FILE is that of the picture.
"""

from __future__ import annotations

import os
import platform
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

import nonsmooth as ns
from benchmarks.peers import adapter, imports
from benchmarks.precision_scenes import CASES, Case, ends
from nonsmooth.drawing.colours import WASHED, cycled
from nonsmooth.drawing.labels import LETTER
from nonsmooth.drawing.plots import new_figure, save_figure

ROUNDS = 3  # chosen
LONGEST = 1.0  # s, chosen: a method that took longer is not asked for a smaller error
STEPS = tuple(1e-2 / 4**k for k in range(8))  # s: to 6e-7
TOLERANCES = tuple(10.0**-k for k in range(2, 11))
LEAST = 1e-17  # m: what is nothing is drawn here
Run = Callable[[Case, float], tuple[float, np.ndarray]]  # seconds of a case with a setting, and places


def main(words: list[str]) -> int:
    """Print the table and write the picture."""
    picture = next((word for word in words if word.endswith((".png", ".svg", ".pdf"))), None)
    names = [word for word in words if word != picture]
    if unknown := [name for name in names if name not in CASES]:
        print(f"there is no scene {unknown[0]!r}; known: {', '.join(CASES)}", file=sys.stderr)
        return 2
    warnings.simplefilter("ignore")
    print(f"{platform.platform()}, Python {platform.python_version()}, load {os.getloadavg()[0]:.1f}\n")
    print("| scene | method | setting | error [m] | ms |\n|---|---|---|---|---|")
    curves = {}
    for name in names or CASES:
        curves[name] = dict(curves_of(CASES[name]))
        for line in rows(name, curves[name]):
            print(line, flush=True)
    if picture is not None:
        draw(curves, Path(picture))
    return 0


def curves_of(case: Case) -> Iterator[tuple[str, np.ndarray]]:
    """Of each method its settings, errors and seconds (3, n), from the cheap ones on."""
    exact = case.exact(case.scene(), case.t_end)
    for label, run, settings in methods(case):
        run(case, settings[0])  # compiled before it is timed
        found: list[tuple[float, float, float]] = []
        for setting in settings:
            seconds, places = zip(*(run(case, setting) for _ in range(ROUNDS)), strict=True)
            found.append((setting, float(np.abs(places[0] - exact).max()), min(seconds)))
            if sum(seconds) > LONGEST:
                break
        yield label, np.array(found).T


def methods(case: Case) -> Iterator[tuple[str, Run, tuple[float, ...]]]:
    """Those that take a case, each with its settings."""
    yield "MoreauJean", lambda case, dt: ours(case, ns.MoreauJean(dt=dt)), STEPS
    yield "Adaptive", lambda case, rtol: ours(case, ns.Adaptive(rtol=rtol, atol=1e-2 * rtol)), TOLERANCES
    if case.has_system:
        yield "EventDriven", lambda case, rtol: ours(case, ns.EventDriven(rtol=rtol, atol=1e-2 * rtol)), TOLERANCES
    scene = case.scene()
    if scene.joints:
        return
    if scene.dim == 3:
        if imports("mujoco"):
            yield "MuJoCo", lambda case, dt: mujoco(case.scene(), case.t_end, dt), STEPS
        if imports("pybullet") and not any(body.kind.name == "KINEMATIC" for body in scene.bodies):
            yield "PyBullet", lambda case, dt: other(case, dt, "pybullet_scenes"), STEPS
    elif imports("pymunk"):
        yield "pymunk", lambda case, dt: other(case, dt, "pymunk_scenes"), STEPS


def ours(case: Case, integrator: Any) -> tuple[float, np.ndarray]:
    """A run of `simulate`."""
    scene = case.scene()
    began = time.process_time()
    sol = ns.simulate(scene, (0, case.t_end), integrator=integrator, every=10**9)
    return time.process_time() - began, ends(sol)


def mujoco(scene: ns.Scene, t_end: float, dt: float) -> tuple[float, np.ndarray]:
    """MuJoCo, tuned as its documentation says (adapters/mujoco_exact.py)."""
    motion = adapter("mujoco_exact").Motion(scene, dt)
    began = time.process_time()
    for k in range(round(t_end / dt)):
        motion.step(k * dt)
    return time.process_time() - began, motion.centres()


def other(case: Case, dt: float, name: str) -> tuple[float, np.ndarray]:
    """PyBullet or pymunk."""
    motion = adapter(name).Motion(case.scene(), dt)
    began = time.process_time()
    motion.step(round(case.t_end / dt))
    return time.process_time() - began, motion.places()[0]


def rows(name: str, curves: dict[str, np.ndarray]) -> Iterator[str]:
    """Of a scene."""
    for label, (settings, errors, seconds) in curves.items():
        for setting, error, second in zip(settings, errors, seconds, strict=True):
            yield f"| {name} | {label} | {setting:.3g} | {error:.2g} | {1e3 * second:.3g} |"


def draw(curves: dict[str, dict[str, np.ndarray]], path: Path) -> None:
    """A panel a scene: error over processor time."""
    labels = list(dict.fromkeys(label for found in curves.values() for label in found))
    figure = new_figure(10.0, 2.3 * ((len(curves) + 2) // 3))
    axes = figure.subplots((len(curves) + 2) // 3, 3, squeeze=False).ravel()
    for panel, (name, found) in zip(axes, curves.items(), strict=False):
        for label, (_, errors, seconds) in found.items():
            colour, line, marker = cycled(labels.index(label))
            panel.loglog(
                1e3 * seconds, np.maximum(errors, LEAST), line, marker=marker, ms=3, lw=1, color=colour, label=label
            )
        panel.set_title(name, fontsize=LETTER)
        panel.grid(True, which="major", color=WASHED)
        panel.set_xlabel("processor time [ms]", fontsize=LETTER)
        panel.set_ylabel("error [m]", fontsize=LETTER)
    for panel in axes[len(curves) :]:
        panel.axis("off")
    handles = {h.get_label(): h for panel in axes for h in panel.get_legend_handles_labels()[0]}
    figure.legend(handles.values(), handles, loc="outside upper center", ncols=len(handles), fontsize=LETTER)
    save_figure(figure, path)
