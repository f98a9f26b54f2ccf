"""Figures of vibration: friction laws, amplitude equations, eigenvalues along a parameter, amplitudes, snapshots.

Matplotlib is imported inside the functions. Every function returns the figure, and saves it where a path is given.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.drawing.plots import BLUE, new_figure, save_figure
from nonsmooth.drawing.scene import scene_model

if TYPE_CHECKING:
    import xarray

    from nonsmooth.equilibria.averaging import AveragedMotion
    from nonsmooth.equilibria.eigen_path import EigenPath
    from nonsmooth.mechanics.system import System
    from nonsmooth.results.solution import Solution

COLOURS = (BLUE, "#d95f02", "#1b9e77", "#7570b3", "#a6761d", "#e7298a", "#66a61e", "#666666")
STYLES = ("-", "--", ":", "-.")
DRAWN_POINTS = 801  # chosen: of a curve; odd, so that v = 0 is one of them


def plot_friction_laws(
    systems: Mapping[str, System], fastest: float = 1.0, path: str | Path | None = None, contact: int | str = 0
) -> Any:
    """The friction coefficient against the sliding velocity, sticking as a vertical line.

    Parameters
    ----------
    systems : mapping of str to System
        Label and system whose contact has the law.
    fastest : float
        Largest sliding speed shown [m/s].
    path : path-like, optional
    contact : int or str
    """
    from nonsmooth.jit import interpreted
    from nonsmooth.mechanics.laws import friction_coefficient, static_coefficient

    mu, mu_static = interpreted(friction_coefficient), interpreted(static_coefficient)
    figure = new_figure(7, 4.5)
    axes = figure.subplots()
    v = np.linspace(0, fastest, DRAWN_POINTS)[1:]
    for k, (label, system) in enumerate(systems.items()):
        i = system.described.contact(contact)
        slides, sticks = np.array([mu(system.laws, i, x) for x in v]), mu_static(system.laws, i)
        x = np.concatenate([-v[::-1], [0.0, 0.0], v])
        y = np.concatenate([-slides[::-1], [-sticks, sticks], slides])
        axes.plot(x, y, color=COLOURS[k % len(COLOURS)], ls=STYLES[k % len(STYLES)], lw=1.6, label=label)
    axes.axhline(0, color="0.6", lw=0.6)
    axes.set_xlabel("sliding velocity $v = -\\gamma_F$ [m/s]")
    axes.set_ylabel("friction force / normal force, $\\mu(|v|)\\,\\mathrm{sgn}\\,v$")
    axes.grid(alpha=0.25)
    axes.legend(frameon=False, fontsize=9)
    return save_figure(figure, path)


def plot_averaged_motion(motion: AveragedMotion, path: str | Path | None = None) -> Any:
    """The amplitude equation of one motion: see `plot_averaged`."""
    return plot_averaged([("", motion)], path)


def plot_averaged(
    motions: Sequence[tuple[str, AveragedMotion]], path: str | Path | None = None, unit: str = "m"
) -> Any:
    """The amplitude equation a'(a), with filled dots at its stable equilibria and open ones at the unstable.

    Parameters
    ----------
    motions : sequence of (label, AveragedMotion)
    path : path-like, optional
    unit : str
        Of the coordinate.
    """
    figure = new_figure(7, 4.5)
    axes = figure.subplots()
    top = max(float(motion.amplitudes.max()) for _, motion in motions)
    touching = [a for a in (touching_amplitude(motion) for _, motion in motions) if a > 0]
    top = 1.35 * (top if top > 0 else max(touching, default=1.0))
    for k, (label, motion) in enumerate(motions):
        colour = COLOURS[k % len(COLOURS)]
        a = np.linspace(0, top, DRAWN_POINTS // 4)
        axes.plot(a, [motion.rate(x) for x in a], color=colour, lw=1.6, label=label)
        for x, is_stable in zip(motion.amplitudes, motion.is_stable, strict=True):
            fill, size = (colour, 6) if is_stable else ("none", 10)
            axes.plot(x, 0, "o", color=colour, mfc=fill, ms=size, mew=1.6, zorder=5, clip_on=False)
    axes.axhline(0, color="0.5", lw=0.8)
    axes.set_xlim(0, top)
    axes.set_xlabel(f"amplitude $a$ [{unit}]")
    axes.set_ylabel(f"averaged rate $\\dot a$ [{unit}/s]")
    axes.set_title("filled: stable, open: unstable", fontsize=9, loc="right")
    axes.grid(alpha=0.25)
    if any(label for label, _ in motions):
        axes.legend(frameon=False, fontsize=9)
    return save_figure(figure, path)


def touching_amplitude(motion: AveragedMotion) -> float:
    """Amplitude at which the mass keeps up with the surface it slides on; zero where nothing slides."""
    speeds = np.abs(motion.equation.at.gamma_F)
    return float(speeds.min() / motion.omega) if speeds.size else 0.0


def plot_eigen_path(paths: EigenPath | Mapping[str, EigenPath], path: str | Path | None = None, unit: str = "") -> Any:
    """Growth rates and frequencies against the parameter, and the locus of the eigenvalues.

    Parameters
    ----------
    paths : EigenPath or mapping of str to EigenPath
        Several are drawn in the same axes, as with and without damping.
    path : path-like, optional
    unit : str
        Of the parameter.
    """
    from matplotlib.lines import Line2D

    family = paths if isinstance(paths, Mapping) else {"": paths}
    figure = new_figure(11, 5.5)
    grid = figure.add_gridspec(2, 2)
    above = figure.add_subplot(grid[0, 0])
    below = figure.add_subplot(grid[1, 0], sharex=above)
    locus = figure.add_subplot(grid[:, 1])
    for k, (label, curve) in enumerate(family.items()):
        style, colour = STYLES[k % len(STYLES)], COLOURS[k % len(COLOURS)]
        for mode, s in enumerate(curve.eigenvalues.T):
            line: dict[str, Any] = {"color": colour, "ls": style, "lw": 1.4}
            above.plot(curve.values, s.real, label=label if mode == 0 else None, **line)
            shown = s.imag >= 0
            upper = np.where(joined(shown), np.abs(s.imag), np.nan)
            below.plot(curve.values, upper, **line)
            locus.plot(s.real, upper, **line)
            for end, marker, fill in ((0, "o", "white"), (-1, "s", colour)):
                if shown[end]:
                    locus.plot(s.real[end], s.imag[end], marker, color=colour, mfc=fill, ms=5)
        for before, after, _, verdict in curve.changes:
            x = where_growth_vanishes(curve, before, after)
            for axes in (above, below):
                axes.axvline(x, color=colour, ls=":", lw=1)
            text = verdict.name.lower().replace("_", " ")
            place = x, 0.04 + 0.2 * k
            below.annotate(text, place, (3, 0), ("data", "axes fraction"), "offset points", rotation=90, fontsize=8,
                           va="bottom", ha="left", color=colour)  # fmt: skip
    first = next(iter(family.values()))
    name = {"mu": "$\\mu$", "vb": "$v_b$"}.get(first.parameter, first.parameter)
    axis_label = f"{name} [{unit}]" if unit else name
    above.set_ylabel("growth Re $s$ [1/s]")
    below.set_ylabel("frequency Im $s$ [rad/s]")
    below.set_xlabel(axis_label)
    locus.set_xlabel("Re $s$ [1/s]")
    locus.set_ylabel("Im $s$ [rad/s]")
    locus.set_title("upper half of the plane", fontsize=9, loc="right")
    above.axhline(0, color="0.5", lw=0.8)
    locus.axvline(0, color="0.5", lw=0.8)
    ends = f"{first.parameter} = {first.values[0]:g}", f"{first.parameter} = {first.values[-1]:g}"
    handles: list[Any] = [
        Line2D([], [], color="0.3", marker="o", mfc="white", ls="", label=ends[0]),
        Line2D([], [], color="0.3", marker="s", ls="", label=ends[1]),
    ]
    locus.legend(handles=handles, frameon=False, fontsize=9)
    if len(family) > 1:
        above.legend(frameon=False, fontsize=9)
    for axes in (above, below, locus):
        axes.grid(alpha=0.25)
    return save_figure(figure, path)


def joined(shown: np.ndarray) -> np.ndarray:
    """The points that are shown, and those before and after them: of a pair that becomes real both curves go on from
    it, the lower one's from its conjugate."""
    padded = np.pad(shown, 1)
    return shown | padded[:-2] | padded[2:]


def where_growth_vanishes(curve: EigenPath, before: float, after: float) -> float:
    """Between two values of the parameter, linear; the middle where the growth keeps its sign."""
    g_0, g_1 = (float(curve.growth[np.abs(curve.values - value).argmin()]) for value in (before, after))
    return before + (after - before) * (g_0 / (g_0 - g_1) if g_0 * g_1 < 0 else 0.5)


def plot_amplitudes(
    curves: Mapping[str, tuple[Any, Sequence[AveragedMotion]]],
    path: str | Path | None = None,
    points: Mapping[str, tuple[Any, Any]] | None = None,
    xlabel: str = "belt speed $v_b$ [m/s]",
    unit: str = "m",
) -> Any:
    """Averaged amplitudes against a parameter, stable ones solid and unstable ones dashed, with measured ones as dots.

    Parameters
    ----------
    curves : mapping of str to (values (n,), n AveragedMotion)
    path : path-like, optional
    points : mapping of str to (values, amplitudes), optional
        Amplitudes from elsewhere, as of simulated motions.
    xlabel, unit : str
    """
    figure = new_figure(7, 4.8)
    axes = figure.subplots()
    for k, (label, (values, motions)) in enumerate(curves.items()):
        colour = COLOURS[k % len(COLOURS)]
        for is_stable, style in ((True, "-"), (False, "--")):
            a = [largest(motion, is_stable) for motion in motions]
            axes.plot(values, a, color=colour, ls=style, lw=1.6, label=label if is_stable else None)
    for k, (label, (values, amplitudes)) in enumerate((points or {}).items()):
        axes.plot(values, amplitudes, "os^D"[k % 4], color=COLOURS[k % len(COLOURS)], ms=5, mfc="white", label=label)
    axes.set_ylim(bottom=0)
    axes.set_xlabel(xlabel)
    axes.set_ylabel(f"amplitude [{unit}]")
    axes.grid(alpha=0.25)
    axes.legend(frameon=False, fontsize=9)
    return save_figure(figure, path)


def largest(motion: AveragedMotion, is_stable: bool) -> float:
    """The largest equilibrium of the amplitude equation of one kind, steady sliding left out; NaN if there is none."""
    cycles = motion.amplitudes[1:][motion.is_stable[1:] == is_stable]
    return float(cycles[-1]) if cycles.size else np.nan


def plot_snapshots(solution: Solution, times: Sequence[float], path: str | Path | None = None) -> Any:
    """The moving bodies at some times, the first pale and the last dark.

    Parameters
    ----------
    solution : Solution
        Of a model with ``shape(q)``; ``outline()`` is drawn where it has one.
    times : sequence of float
        The records nearest to these times are drawn [s].
    path : path-like, optional
    """
    from matplotlib import colormaps

    model = scene_model(solution)
    fixed = model.outline() if model.outline else []
    records = [int(np.abs(solution.t - t).argmin()) for t in times]
    bodies = [model.shape(solution.q[i]) for i in records]
    extent = np.ptp(np.concatenate([*fixed, *(line for lines in bodies for line in lines)]), axis=0)
    figure = new_figure(7.5, float(np.clip(5.2 * extent[1] / extent[0] + 1.2, 3.0, 9.0)))
    axes = figure.subplots()
    for line in fixed:
        axes.plot(*line.T, color="0.4", lw=2.5)
    for k, (i, lines) in enumerate(zip(records, bodies, strict=True)):
        colour = colormaps["viridis_r"](0.1 + 0.9 * k / max(len(times) - 1, 1))
        for j, line in enumerate(lines):
            label = f"{solution.t[i]:.3g} s" if j == 0 else None
            axes.plot(*line.T, "-o", color=colour, lw=1.8, ms=4, label=label)
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.grid(alpha=0.25)
    axes.legend(title="t", frameon=False, fontsize=9, loc="center left", bbox_to_anchor=(1.01, 0.5))
    return save_figure(figure, path)


def plot_stability_map(chart: xarray.Dataset, path: str | Path | None = None, units: Sequence[str] = ("", "")) -> Any:
    """Growth rate over two parameters with the boundary of stability.

    Parameters
    ----------
    chart : xarray.Dataset
        From `stability_map`; its first parameter is drawn upwards.
    path : path-like, optional
    units : (str, str)
        Of the two parameters.
    """
    (y_name, y_unit), (x_name, x_unit) = zip(chart.growth.dims, units, strict=True)
    figure = new_figure(7, 5)
    axes = figure.subplots()
    x, y = chart[x_name].values, chart[y_name].values
    size = float(np.nanmax(np.abs(chart.growth.values)))
    colours = axes.pcolormesh(
        x, y, chart.growth.values, cmap="RdBu_r", vmin=-size, vmax=size, shading="nearest", rasterized=True
    )
    unstable = np.where(np.isnan(chart.verdict.values), 0.0, chart.verdict.values > 1)
    if unstable.min() < unstable.max():
        axes.contour(x, y, chart.growth.values, levels=[0.0], colors="black", linewidths=1.4)
    figure.colorbar(colours, label="growth max Re $s$ [1/s]")
    axes.set_xlabel(f"{x_name} [{x_unit}]" if x_unit else str(x_name))
    axes.set_ylabel(f"{y_name} [{y_unit}]" if y_unit else str(y_name))
    return save_figure(figure, path)
