"""Draw the strip of the first page: ``python docs/figures/strip.py [FOLDER]``.

The sprag-slip rod over its paradox regions, a tower that is hit, and run time against error of the woodpecker toy.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import SpragSlip, Woodpecker
from nonsmooth.drawing.paradox_plots import draw_curves, draw_motions, draw_regions
from nonsmooth.drawing.plots import new_figure
from nonsmooth.drawing.scene_figures import draw_bodies
from nonsmooth.drawing.work_precision_plots import draw_scene

SIZE = (12.6, 3.7)  # chosen: of the strip [in]
METHODS = {"MoreauJean": ns.MoreauJean, "Adaptive": ns.Adaptive, "EventDriven": ns.EventDriven}


def regions(axes: Any) -> None:
    """Draw the numbers of solutions in the phase plane of the rod, and a motion that is seized."""
    rod = SpragSlip()
    ranges = {"th": np.linspace(0.65, 1.25, 601), "thdot": np.linspace(-4.5, 4.5, 601)}
    chart = ns.paradox_map(rod, **ranges)
    draw_regions(axes, chart, list(ranges))
    draw_curves(axes, ns.paradox_boundaries(rod, **{name: values[::10] for name, values in ranges.items()}))
    motions = []
    for th, thdot, t_end in [(0.78, 1.0, 0.46), (0.90, 2.0, 0.40)]:
        sol = ns.simulate(rod, (0.0, t_end), *rod.state(th=th, thdot=thdot), integrator=ns.MoreauJean(dt=2e-5))
        motions.append(np.column_stack([sol.q[:, 1], sol.u[:, 1]]))
    draw_motions(axes, motions)
    for place, text in {(0.69, -3.6): "1", (0.742, -2.2): "0", (1.0, -3.2): "2 solutions", (1.08, 3.3): "0"}.items():
        axes.text(*place, text, ha="center", va="center", bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.5})
    axes.set_xlabel("θ [rad]")
    axes.set_ylabel("θ' [rad/s]")
    axes.set_title("a rod seized by its belt, over its paradox regions", fontsize=10)


def tower(axes: Any) -> None:
    """Draw ten layers of bricks 0.45 s after a disc has hit them."""
    scene = ns.Scene(gravity=(0, -9.81), material=ns.Material(mu=0.6))
    scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    for row in range(10):
        for k in range(4):
            place = (0.42 * (k - 1.5 + 0.5 * (row % 2)), 0.1 + 0.2 * row)
            scene.body(ns.Box(0.4, 0.2), density=2000, position=place, name=f"brick {row} {k}")
    scene.body(ns.Disc(0.3), density=4000, position=(-2.2, 1.1), velocity=(9.0, 1.0), name="ball")
    sol = ns.simulate(scene, (0, 0.45), integrator=ns.MoreauJean(dt=1e-3))
    extent = np.array([-1.6, -0.05]), np.array([2.3, 2.5])
    draw_bodies(axes, sol, -1, extent)
    axes.set(xlim=(-1.6, 2.3), ylim=(-0.05, 2.5), aspect="equal")
    axes.set_axis_off()
    axes.set_title("41 bodies with friction, after a blow", fontsize=10)


def work(axes: Any) -> None:
    """Draw the error of a woodpecker toy that each integrator reaches in a time."""
    study = ns.work_precision([Woodpecker()], METHODS)
    draw_scene(axes, study, study.scenes[0], "wall_time")
    axes.set_ylabel("error of the positions [-]")
    axes.legend(fontsize=8, frameon=False)
    axes.set_title("woodpecker toy: run time against error", fontsize=10)


def main(folder: Path) -> None:
    figure = new_figure(*SIZE)
    places = figure.subplots(1, 3, width_ratios=(1.15, 1.2, 1.0))
    for draw, axes in zip((regions, tower, work), places, strict=True):
        draw(axes)
    figure.savefig(folder / "strip.png", dpi=130)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
