"""The figures of docs/paradoxes.md and docs/theory/painleve.md: ``python docs/figures/paradoxes.py [FOLDER]``."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import PainleveRod, SpragSlip


def four_cases(folder: Path) -> None:
    """The graphical problem for the four signs of p and b, at states of the slender rod."""
    cases = []
    for mu, thdot, title in [(0.5, 0.0, "$p > 0$, $b < 0$: it slides"), (0.5, 6.0, "$p > 0$, $b > 0$: it lifts off"),
                             (2.0, 6.0, "$p < 0$, $b > 0$: indeterminate"),
                             (2.0, 0.0, "$p < 0$, $b < 0$: inconsistent")]:  # fmt: skip
        rod = PainleveRod(mu=mu)
        cases.append((title, ns.classify(rod, 0.0, *rod.state(th=math.pi / 3, thdot=thdot))))
    ns.plot_graphical_problem(cases, folder / "graphical_lcp.png")


def sprag_slip(folder: Path) -> None:
    """Regions A0 .. A4 of set 2, and two motions over them."""
    rod = SpragSlip()
    axes = {"th": np.linspace(0.65, 1.25, 601), "thdot": np.linspace(-4.5, 4.5, 601)}
    chart = ns.paradox_map(rod, **axes)
    coarse = {name: values[::10] for name, values in axes.items()}
    code = rod.region(*np.meshgrid(*axes.values(), indexing="ij"))
    motions = []
    for th, thdot, t_end in [(0.78, 1.0, 0.46), (0.90, 2.0, 0.40)]:
        sol = ns.simulate(rod, (0.0, t_end), *rod.state(th=th, thdot=thdot), integrator=ns.MoreauJean(dt=2e-5))
        motions.append(np.column_stack([sol.q[:, 1], sol.u[:, 1]]))
    ns.plot_map(
        chart, folder / "sprag_slip_regions.png", boundaries=ns.paradox_boundaries(rod, **coarse), motions=motions,
        regions=(code, lambda k: f"$A_{k}$: {chart.n_solutions.values[code == k].max()}"),
        title="sprag-slip rod, set 2: regions and their numbers of solutions",
    )  # fmt: skip


def rod_in_angle_and_friction(folder: Path) -> None:
    """The slender rod sliding against its lean: p < 0 above the critical friction, b changes its sign at one angle."""
    axes = {"th": np.linspace(0.02, math.pi / 2 - 0.02, 601), "mu": np.linspace(0.0, 3.0, 601)}
    fixed = {"thdot": 5.0, "slip": -1.0}
    chart = ns.paradox_map(PainleveRod(), **axes, **fixed)
    coarse = {name: values[::10] for name, values in axes.items()}
    figure = ns.plot_map(
        chart, boundaries=ns.paradox_boundaries(PainleveRod(), **coarse, **fixed),
        title="Painlevé's rod, $\\kappa = 3$, $\\dot\\theta = 5$ rad/s, tip pushed ahead: numbers of solutions",
    )  # fmt: skip
    least = ns.least_critical_friction(PainleveRod(), PainleveRod().state()[0], "th", (0.0, math.pi / 2))
    figure.axes[0].annotate(
        f"least critical friction\n{least.mu:.4f} at {math.degrees(least.at):.2f}°", (least.at, least.mu), (14, -50),
        textcoords="offset points", ha="center", fontsize=9, arrowprops={"arrowstyle": "->"},
    )  # fmt: skip
    figure.savefig(folder / "rod_th_mu.png", dpi=150)


def rod_in_its_phase_plane(folder: Path) -> None:
    """Sliding motions of the rod drawn towards the Génot–Brogliato point."""
    rod = PainleveRod(mu=1.4)
    axes = {"th": np.linspace(0.3, 1.5, 601), "thdot": np.linspace(0.0, 8.0, 601)}
    chart = ns.paradox_map(rod, **axes, slip=-1.0)
    coarse = {name: values[::10] for name, values in axes.items()}
    motions = []
    for th, thdot in [(0.4, 2.0), (0.4, 3.0), (0.4, 4.0), (0.4, 5.0), (0.4, 6.0), (1.45, 2.0), (1.4, 4.0)]:
        start = rod.state(th=th, thdot=thdot, slip=-30.0)
        sol = ns.simulate(rod, (0.0, 0.4), *start, integrator=ns.MoreauJean(dt=1e-5), on_failure="return")
        slides = np.cumsum(np.diff(sol.mode[:, 0], prepend=sol.mode[1, 0]) != 0)[: len(sol.t)] == 0
        last = int(np.argmin(slides)) if not slides.all() else len(slides)
        motions.append(np.column_stack([sol.q[:last, 2], sol.u[:last, 2]]))
    ns.plot_map(
        chart, folder / "rod_phase_plane.png", boundaries=ns.paradox_boundaries(rod, **coarse, slip=-1.0),
        motions=motions, title="Painlevé's rod, $\\mu = 1.4$: sliding motions until the contact opens, sticks or jumps",
    )  # fmt: skip


def main() -> None:
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent
    folder.mkdir(parents=True, exist_ok=True)
    for figure in (four_cases, sprag_slip, rod_in_angle_and_friction, rod_in_its_phase_plane):
        figure(folder)


if __name__ == "__main__":
    main()
