"""Figures of docs/stability.md and the theory pages on vibration: ``python docs/figures/vibration.py [NAME ...]``.

Each is drawn beside this file; without a name all of them, in a few minutes.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import BeltOscillator, FollowerForceArm, ModeCoupling, SpragSlip
from nonsmooth.drawing.cycle_plots import plot_branch, plot_cycle, plot_waterfall
from nonsmooth.drawing.plots import draw_phase_plane, new_figure
from nonsmooth.drawing.stability_plots import (
    plot_amplitudes,
    plot_averaged,
    plot_eigen_path,
    plot_friction_laws,
    plot_snapshots,
    plot_stability_map,
)

HERE = Path(__file__).parent
SMOOTHED = BeltOscillator(law="smoothed", r=20.0)


def friction_laws(path: Path) -> None:
    """The laws of the mass on a conveyor."""
    laws = {
        "cubic": BeltOscillator(),
        "smoothed, r = 20 s/m": SMOOTHED, "smoothed, r = 200 s/m": replace(SMOOTHED, r=200.0),
        "two coefficients": BeltOscillator(law="two-coefficient"), "Stribeck": BeltOscillator(law="stribeck"),
    }  # fmt: skip
    plot_friction_laws({label: belt.system() for label, belt in laws.items()}, 0.8, path)


def amplitude_equation(path: Path) -> None:
    """a'(a) for both signs of its linear coefficient."""
    speeds = (0.42, 0.46)
    motions = [(f"vb = {vb:g} m/s", ns.averaged_amplitude(BeltOscillator(vb=vb))) for vb in speeds]
    plot_averaged(motions, path)


def amplitude_equation_smoothed(path: Path) -> None:
    """a'(a) of the smoothed law, overtaking included."""
    motions = [(f"vb = {vb:g} m/s", ns.averaged_amplitude(replace(SMOOTHED, vb=vb))) for vb in (0.1, 0.2, 0.3, 0.4)]
    plot_averaged(motions, path)


def amplitude_against_speed(path: Path) -> None:
    """Averaged amplitudes against the belt's speed, with simulated cycles."""
    values = np.linspace(0.02, 0.46, 89)
    belts = {"discontinuous": BeltOscillator(), "r = 200 s/m": replace(SMOOTHED, r=200.0), "r = 20 s/m": SMOOTHED}
    curves = {
        f"averaged, {label}": (values, [ns.averaged_amplitude(replace(belt, vb=vb)) for vb in values])
        for label, belt in belts.items()
    }
    speeds = (0.05, 0.1, 0.2, 0.25, 0.3, 0.35, 0.4)
    points = {
        f"simulated, {label}": (speeds, [half_swing(replace(belt, vb=vb)) for vb in speeds])
        for label, belt in belts.items()
    }
    plot_amplitudes(curves, path, points)


def half_swing(belt: BeltOscillator) -> float:
    """(max x - min x)/2 of the motion that steady sliding grows into [m]."""
    start = belt.state(x=belt.equilibrium() + 0.02, velocity=0.0)
    run = ns.simulate(belt, (0.0, 300.0), *start, integrator=ns.MoreauJean(dt=1e-3), every=5)
    x = run.q[run.t > 280.0, 0]
    return float(np.ptp(x)) / 2


def eigenvalues(path: Path) -> None:
    """Mode coupling with and without damping."""
    values = np.linspace(0.0, 1.0, 401)
    models = {"undamped": ModeCoupling(cx=0.0, cz=0.0), "damped": ModeCoupling()}
    plot_eigen_path({label: ns.eigen_path(model, "mu", values) for label, model in models.items()}, path)


def arm_eigenvalues(path: Path) -> None:
    """The arm from no load to beyond the second critical load."""
    plot_eigen_path(ns.eigen_path(FollowerForceArm(), "P", np.linspace(0.0, 2900.0, 581)), path, "N")


def unequal_damping(path: Path) -> None:
    """Growth over friction and vertical damping: unequal damping destabilises."""
    axes = {"mu": np.linspace(0.2, 0.8, 61), "cz": np.linspace(0.0, 6.0, 61)}
    chart = ns.stability_map(ModeCoupling(cx=1.0), axes, sensitivities=False)
    plot_stability_map(chart, path, ("", "N s/m"))


def phase_planes(path: Path) -> None:
    """Sprag-slip rod, set 1: a stable equilibrium and a stick-slip cycle, with the curves v_t = 0 and N = 0."""
    figure = new_figure(13, 6.5)
    for axes, cth in zip(figure.subplots(1, 2), (5.0, 0.5), strict=True):
        rod = SpragSlip.set_1(cth=cth)
        start = rod.state(th=rod.equilibrium() - 0.05, thdot=0.0)
        run = ns.simulate(rod, (0.0, 3.0), *start, integrator=ns.MoreauJean(dt=1e-5), every=20)
        draw_phase_plane(axes, run, rod)
        axes.set_title(f"$c_\\theta$ = {cth:g} N m s/rad", fontsize=11)
    figure.savefig(path, dpi=120)


def limit_cycles(path: Path) -> None:
    """Phase planes of the mass on a conveyor, smoothed against discontinuous."""
    figure = new_figure(11, 4.6)
    for axes, vb in zip(figure.subplots(1, 3), (0.1, 0.2, 0.4), strict=True):
        for belt, style in ((BeltOscillator(vb=vb), "-"), (replace(SMOOTHED, vb=vb, r=200.0), "--")):
            start = belt.state(x=belt.equilibrium() + 0.02, velocity=0.0)
            run = ns.simulate(belt, (0.0, 200.0), *start, integrator=ns.MoreauJean(dt=5e-4), every=4)
            late = run.t > 190.0
            label = "discontinuous" if style == "-" else "smoothed, r = 200 s/m"
            axes.plot(run.q[late, 0] - belt.equilibrium(), run.u[late, 0], style, lw=1.5, label=label)
        axes.axhline(vb, color="0.4", ls=":", lw=1.2, label="x' = vb")
        axes.set_title(f"vb = {vb:g} m/s", fontsize=10)
        axes.set_xlabel("$x - x_{eq}$ [m]")
        axes.grid(alpha=0.25)
        axes.margins(y=0.12)
        axes.locator_params(axis="x", nbins=5)
    figure.axes[0].set_ylabel("$\\dot x$ [m/s]")
    figure.axes[0].legend(frameon=False, fontsize=8, loc="center")
    figure.savefig(path, dpi=150)


def projections(path: Path) -> None:
    """Mode coupling at mu = 0.6: the cycle in three planes."""
    model = ModeCoupling(mu=0.6)
    run = ns.simulate(model, (0.0, 60.0), *model.state(y1=0.1), integrator=ns.MoreauJean(dt=2e-4), every=5)
    late = run.t > 58.0
    y, u = run.q[late] - model.equilibrium(), run.u[late]
    figure = new_figure(12, 4.2)
    pairs = ((y[:, 0], u[:, 0], "$y_1$ [m]", "$\\dot y_1$ [m/s]"), (y[:, 1], u[:, 1], "$y_2$ [m]", "$\\dot y_2$ [m/s]"),
             (y[:, 0], y[:, 1], "$y_1$ [m]", "$y_2$ [m]"))  # fmt: skip
    for axes, (a, b, xlabel, ylabel) in zip(figure.subplots(1, 3), pairs, strict=True):
        axes.plot(a, b, lw=1.4)
        axes.set_xlabel(xlabel)
        axes.set_ylabel(ylabel)
        axes.grid(alpha=0.25)
    figure.axes[0].axhline(model.vb, color="0.4", ls=":", lw=1.2)
    figure.axes[0].set_title("stick: y1' = vb", fontsize=9, loc="right")
    figure.savefig(path, dpi=150)


def snapshots(path: Path) -> None:
    """The arm in flutter, P = 1000 N."""
    arm = FollowerForceArm(P=1000.0)
    run = ns.simulate(arm, (0.0, 1.0), *arm.state(phi1=0.01), integrator=ns.MoreauJean(dt=1e-4))
    plot_snapshots(run, np.linspace(0.75, 0.95, 9), path)


def cycle(path: Path) -> None:
    """The cycle of the sprag-slip rod, set 1, c_theta = 0.5."""
    rod = SpragSlip.set_1(cth=0.5)
    plot_cycle(ns.limit_cycle(rod, rod.state(th=0.78, thdot=0.0), duration=6.0), path)


def branch(path: Path) -> None:
    """The cycle of the belt along its speed."""
    plot_branch(belt_branch(), path, "belt speed vb [m/s]")


def waterfall(path: Path) -> None:
    """Cycles of the belt in the phase plane, by its speed."""
    plot_waterfall(belt_branch(), path, "belt speed vb [m/s]")


def belt_branch() -> ns.CycleBranch:
    """Cycles from 0.05 m/s to just below the loss of instability."""
    start = ns.limit_cycle(BeltOscillator(vb=0.05), duration=60.0)
    return ns.continue_cycle(BeltOscillator(), "vb", np.linspace(0.05, 0.44, 79), start)


def bifurcations(path: Path) -> None:
    """Maxima of the belt's motion upwards and downwards."""
    diagram = ns.bifurcation_diagram(BeltOscillator(), "vb", np.linspace(0.05, 0.5, 31), duration=800.0, dt=2e-3)
    diagram.plot(path, "belt speed vb [m/s]")


FIGURES = {
    f.__name__: f for f in (
        friction_laws, amplitude_equation, amplitude_equation_smoothed, amplitude_against_speed, eigenvalues,
        arm_eigenvalues, unequal_damping, phase_planes, limit_cycles, projections, snapshots, cycle, branch, waterfall,
        bifurcations,
    )
}  # fmt: skip


def main() -> None:
    """Draw the figures named on the command line, or all."""
    for name in sys.argv[1:] or FIGURES:
        FIGURES[name](HERE / f"{name}.png")
        print(HERE / f"{name}.png")


if __name__ == "__main__":
    main()
