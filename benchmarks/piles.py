"""``python -m benchmarks piles FOLDER``: piles and shaken packings of spheres, solved to 1e-8, as a page.

    python -m benchmarks piles FOLDER > docs/benchmarks/piles.md

FOLDER has the piles of Kleinert (2015), particles2048pile.vtu and particles5040pile.vtu of
https://github.com/joergbrech/nonsmooth-granular-benchmarks; what is not there is left out. Each scene takes the same
steps by default and with interior points of no more than 200 bodies. Times are those of the processor.
"""

from __future__ import annotations

import re
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np

import nonsmooth as ns
from benchmarks.solvers import table
from models.scenes import SphereBox
from nonsmooth.errors import InvalidInput

STEPS = {2048: 10, 5040: 3}  # of the piles
FEW = 200  # bodies of an island that interior points solve in the second column


def main(words: list[str]) -> int:
    """Print the page; returns the exit code."""
    if len(words) != 1:
        raise InvalidInput("piles takes the folder of Kleinert's piles")
    warnings.simplefilter("ignore", ns.ResidualWarning)
    print("# Piles\n")
    print("Made by `python -m benchmarks piles FOLDER` on one thread: spheres, friction 0.4, steps that are")
    print("asked for $10^{-8}$. Processor time a step in the mean, the worst residual and the steps")
    print("that miss, by default and with `ContactSolver(interior=200)`: sweeps, and Newton's method")
    print("where factors are cheap. Kleinert's piles are those of his thesis (2015), 10 and 3 steps of 1 ms;")
    print("*falling* is `SphereBox`, which lands from 0.1 s on; *shaken* are layers, each sphere in the middle")
    print("of four, thrown at random with 0.5 m/s, 10 steps of 2 ms.\n")
    print("\n".join(page(Path(words[0]))), flush=True)
    return 0


def page(folder: Path) -> Iterator[str]:
    """The table."""
    files = {n: folder / f"particles{n}pile.vtu" for n in STEPS}
    scenes: dict[str, tuple[Callable[[], ns.Scene], float, int]] = {
        f"Kleinert, {n} spheres": (partial(pile, path), 1e-3, STEPS[n]) for n, path in files.items() if path.exists()
    }
    scenes |= {f"shaken, {wide**3} spheres": (partial(shaken, wide), 2e-3, 10) for wide in (7, 8, 10)}
    scenes["falling, 300 spheres"] = SphereBox(n=300).scene, 2e-3, 350
    measured(shaken(7), 2e-3, 2, FEW)  # compiled before it is timed
    measured(shaken(7), 2e-3, 2, ns.ContactSolver().interior)
    columns: dict[str, list[str]] = {"by default": [], "interior=200": []}
    for build, dt, steps in scenes.values():
        columns["by default"].append(measured(build(), dt, steps, ns.ContactSolver().interior))
        columns["interior=200"].append(measured(build(), dt, steps, FEW))
        print(columns["by default"][-1], "|", columns["interior=200"][-1], file=sys.stderr, flush=True)
    yield from table("scene", list(scenes), columns)


def measured(scene: ns.Scene, dt: float, steps: int, interior: int) -> str:
    """A cell: what the steps of a scene take, and leave."""
    method = ns.MoreauJean(dt=dt, contacts=ns.ContactSolver(interior=interior))
    began = time.process_time()
    stats = ns.simulate(scene, (0, steps * dt), integrator=method, every=steps, project=True).stats
    cost = 1e3 * (time.process_time() - began) / steps
    return f"{cost:.0f} ms; {stats.worst_residual:.0e}; {stats.missed} of {steps}"


def pile(path: Path) -> ns.Scene:
    """A pile of Kleinert."""
    text = path.read_text()
    columns = dict(re.findall(r'<DataArray Name="(\w+)"[^>]*>([^<]*)<', text))
    radius, mass = (np.array(columns[name].split(), float) for name in ("radius", "mass"))
    x = np.array(columns["Points"].split(), float).reshape(-1, 3)
    scene = ns.Scene(gravity=(0, 0, -10), material=ns.Material(mu=0.4))
    scene.fixed(ns.HalfSpace((0, 0, 1)))
    for k, place in enumerate(x):
        scene.body(ns.Sphere(radius[k]), mass=mass[k], position=place)
    return scene


def shaken(wide: int) -> ns.Scene:
    """A packing of wide^3 spheres, thrown at random."""
    rng = np.random.default_rng(1)
    scene = ns.Scene(gravity=(0, 0, -9.81), material=ns.Material(mu=0.4))
    scene.fixed(ns.HalfSpace((0, 0, 1)))
    for layer, x, y in np.ndindex(wide, wide, wide):
        shift = 0.05 * (layer % 2)
        place = (0.1 * x + shift, 0.1 * y + shift, 0.05 + 0.0708 * layer)
        scene.body(ns.Sphere(0.05), density=1000, position=place, velocity=0.5 * rng.normal(size=3))
    return scene
