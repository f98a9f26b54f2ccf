"""Figures of vibration: friction laws, amplitude equations, eigenvalues along a parameter, amplitudes, snapshots.

Matplotlib is imported inside the functions. Every function returns the figure, and saves it where a path is given.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.checks.arrays import as_instance, as_listed
from nonsmooth.drawing.colours import BLACK, BLUE, CYCLE, GREY, PALE, STYLES, cycled
from nonsmooth.drawing.labels import LETTER, legend_above, parameter_label, spelt
from nonsmooth.drawing.plots import TITLE_LETTERS, WIDTH, heading, held_fixed, new_figure, save_figure, set_title
from nonsmooth.drawing.scene import scene_model
from nonsmooth.equilibria.linearise import Verdict
from nonsmooth.errors import InvalidInput, shown

if TYPE_CHECKING:
    import xarray

    from nonsmooth.equilibria.averaging import AveragedMotion
    from nonsmooth.equilibria.eigen_path import EigenPath
    from nonsmooth.mechanics.system import System
    from nonsmooth.results.solution import Solution

NEARLY_REAL = 1e-6  # chosen: of a number's size: a smaller imaginary part is rounding
SHOWN_GROWTH = 0.95  # chosen: part of a map whose growth rates the colours resolve: near a pole there is no largest one
SNAPSHOT_COLUMNS = 3  # chosen
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
    figure = new_figure(WIDTH, 3.6)
    axes = figure.subplots()
    v = np.linspace(0, fastest, DRAWN_POINTS)[1:]
    for k, (label, system) in enumerate(systems.items()):
        i = system.described.contact(contact)
        slides, sticks = np.array([mu(system.laws, i, x) for x in v]), mu_static(system.laws, i)
        x = np.concatenate([-v[::-1], [0.0, 0.0], v])
        y = np.concatenate([-slides[::-1], [-sticks, sticks], slides])
        axes.plot(x, y, color=CYCLE[k % len(CYCLE)], ls=STYLES[k % len(STYLES)], lw=1.6, label=label)
    axes.axhline(0, color="0.6", lw=0.6)
    axes.set_xlabel("sliding velocity $v = -\\gamma_F$ [m/s]")
    axes.set_ylabel("friction / normal force\n$\\mu(|v|)\\,\\mathrm{sgn}\\,v$ [-]")
    axes.grid(alpha=0.25)
    legend_above(axes)
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
    figure = new_figure(WIDTH, 3.6)
    axes = figure.subplots()
    top = max(float(motion.amplitudes.max()) for _, motion in motions)
    touching = [a for a in (touching_amplitude(motion) for _, motion in motions) if a > 0]
    top = 1.35 * (top if top > 0 else max(touching, default=1.0))
    for k, (label, motion) in enumerate(motions):
        colour = CYCLE[k % len(CYCLE)]
        a = np.linspace(0, top, DRAWN_POINTS // 4)
        axes.plot(a, [motion.rate(x) for x in a], color=colour, lw=1.6, label=label)
        for x, is_stable in zip(motion.amplitudes, motion.is_stable, strict=True):
            fill, size = (colour, 6) if is_stable else ("none", 10)
            axes.plot(x, 0, "o", color=colour, mfc=fill, ms=size, mew=1.6, zorder=5, clip_on=False)
    axes.axhline(0, color="0.5", lw=0.8)
    axes.set_xlim(0, top)
    axes.set_xlabel(f"amplitude $a$ [{unit}]")
    axes.set_ylabel(f"averaged rate $\\dot a$ [{unit}/s]")
    axes.text(0.98, 0.03, "filled: stable, open: unstable", transform=axes.transAxes, fontsize=LETTER, ha="right")
    axes.grid(alpha=0.25)
    if any(label for label, _ in motions):
        legend_above(axes)
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
    family = paths if isinstance(paths, Mapping) else {"": paths}
    figure = new_figure(WIDTH, 7.4)
    above, below, locus = figure.subplots(3, 1, height_ratios=(1.0, 1.0, 1.7))
    below.sharex(above)
    said = []
    for k, (label, curve) in enumerate(family.items()):
        style, colour = STYLES[k % len(STYLES)], CYCLE[k % len(CYCLE)]
        values, eigenvalues = with_meetings(curve)
        for mode, s in enumerate(eigenvalues.T):
            line: dict[str, Any] = {"color": colour, "ls": style, "lw": 1.4}
            above.plot(values, s.real, label=label if mode == 0 and label else None, **line)
            shown = s.imag >= -NEARLY_REAL * np.abs(s)
            upper = np.where(shown, np.abs(s.imag), np.nan)
            below.plot(values, upper, **line)
            locus.plot(s.real, upper, **line)
            for end, marker, fill in ((0, "o", "white"), (-1, "s", colour)):
                if shown[end]:
                    locus.plot(s.real[end], s.imag[end], marker, color=colour, mfc=fill, ms=5)
        for before, after, _, verdict in curve.changes:
            edge = curve.boundary(before, after)
            for axes in (above, below):
                if edge is not None:
                    axes.axvline(edge.value, color=colour, ls=":", lw=1)
                else:
                    axes.axvspan(*sorted((before, after)), color=colour, alpha=0.15, lw=0)
            text = verdict.name.lower().replace("_", " ")
            where = f"from {spelt(curve.parameter)} = {edge.value:.9g}" if edge is not None else \
                f"from between {spelt(curve.parameter)} = {before:.5g} and {after:.5g}"  # fmt: skip
            said.append(f"{label + ': ' if label else ''}{text} {where}")
    first = next(iter(family.values()))
    above.set_ylabel("growth Re $s$\n[1/s]")
    below.set_ylabel("frequency Im $s$\n[rad/s]")
    below.set_xlabel(parameter_label(first.parameter, first.points[0].equilibrium.mode.system.parameters, unit))
    below.set_title("\n".join(said), fontsize=LETTER, loc="left")
    locus.set_xlabel("Re $s$ [1/s]")
    locus.set_ylabel("Im $s$, upper half\n[rad/s]")
    above.axhline(0, color=GREY, lw=0.8)
    locus.axvline(0, color=GREY, lw=0.8)
    for end, marker, fill in ((0, "o", "white"), (-1, "s", BLACK)):
        label = f"{spelt(first.parameter)} = {first.values[end]:g}"
        locus.plot([], [], color=BLACK, marker=marker, mfc=fill, ls="", label=label)
    legend_above(locus)
    legend_above(above)
    for axes in (above, below, locus):
        axes.grid(alpha=0.25)
        axes.yaxis.set_major_formatter("{x:.6g}")
    figure.align_ylabels([above, below, locus])
    systems = [curve.points[0].equilibrium.mode.system for curve in family.values()]
    set_title(figure, heading(systems, first.parameter))
    return save_figure(figure, path)


def with_meetings(curve: EigenPath) -> tuple[np.ndarray, np.ndarray]:
    """Values (m,) and eigenvalues (m, 2 n_r) with a row more wherever two of them meet and part at a right angle.

    Near a double eigenvalue the square of the difference, d = (s_i - s_j)^2, is linear in the parameter while s itself
    is a square root: where a real d changes its sign between two values, both are their mean where d vanishes. Where
    the inertia changes its sign the eigenvalues go through infinity, and no line joins what is before it and after it:
    a row of NaN.
    """
    values, rows = [curve.values[0]], [curve.eigenvalues[0]]
    for k in range(1, len(curve.values)):
        before, after = curve.eigenvalues[k - 1], curve.eigenvalues[k]
        if (curve.verdicts[k - 1] == Verdict.NEGATIVE_INERTIA) != (curve.verdicts[k] == Verdict.NEGATIVE_INERTIA):
            values += [where_inertia_vanishes(curve, curve.values[k - 1], curve.values[k]), curve.values[k]]
            rows += [np.full_like(before, np.nan), after]
            continue
        met = [(meeting(before[[i, j]], after[[i, j]]), i, j) for i in range(len(after)) for j in range(i)]
        for part in sorted({part for part, _, _ in met if 0 < part < 1}):
            row = before + part * (after - before)
            for at, i, j in met:
                if at == part:
                    row[[i, j]] = row[[i, j]].mean()
            values.append(curve.values[k - 1] + part * (curve.values[k] - curve.values[k - 1]))
            rows.append(row)
        values.append(curve.values[k])
        rows.append(after)
    return np.array(values), np.array(rows)


def meeting(before: np.ndarray, after: np.ndarray) -> float:
    """Where between two values (0 to 1) two eigenvalues meet; NaN where they do not."""
    d_0, d_1 = (before[0] - before[1]) ** 2, (after[0] - after[1]) ** 2
    is_real = all(abs(d.imag) < NEARLY_REAL * abs(d) for d in (d_0, d_1))
    return round(float(d_0.real / (d_0 - d_1).real), 9) if is_real and d_0.real * d_1.real < 0 else np.nan


def where_inertia_vanishes(curve: EigenPath, before: float, after: float) -> float:
    """Between two values of the parameter where it is of either sign: det M_r is linear there."""
    d_0, d_1 = (float(np.linalg.det(curve.points[np.abs(curve.values - x).argmin()].M)) for x in (before, after))
    return before + (after - before) * (d_0 / (d_0 - d_1) if d_0 * d_1 < 0 else 0.5)


def plot_amplitudes(
    curves: Mapping[str, tuple[Any, Sequence[AveragedMotion]]],
    path: str | Path | None = None,
    points: Mapping[str, tuple[Any, Any]] | None = None,
    xlabel: str = "belt speed vb [m/s]",
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
    figure = new_figure(WIDTH, 3.8)
    axes = figure.subplots()
    for k, (label, (values, motions)) in enumerate(curves.items()):
        colour = CYCLE[k % len(CYCLE)]
        for is_stable, style in ((True, "-"), (False, "--")):
            a = [largest(motion, is_stable) for motion in motions]
            axes.plot(values, a, color=colour, ls=style, lw=1.6, label=label if is_stable else None)
    for k, (label, (values, amplitudes)) in enumerate((points or {}).items()):
        colour, _, marker = cycled(k)
        axes.plot(values, amplitudes, marker, color=colour, ms=5, mfc="white", label=label)
    axes.set_ylim(bottom=0)
    axes.set_xlabel(xlabel)
    axes.set_ylabel(f"amplitude [{unit}]")
    axes.grid(alpha=0.25)
    legend_above(axes)
    return save_figure(figure, path)


def largest(motion: AveragedMotion, is_stable: bool) -> float:
    """The largest equilibrium of the amplitude equation of one kind, steady sliding left out; NaN if there is none."""
    cycles = motion.amplitudes[1:][motion.is_stable[1:] == is_stable]
    return float(cycles[-1]) if cycles.size else np.nan


def plot_snapshots(solution: Solution, times: Sequence[float], path: str | Path | None = None) -> Any:
    """The moving bodies at some times, a panel each, those before pale behind them.

    Parameters
    ----------
    solution : Solution
        Of a model with ``shape(q)``; ``outline()`` is drawn where it has one.
    times : sequence of float
        The records nearest to these times are drawn [s].
    path : path-like, optional
    """
    model = scene_model(solution)
    fixed = model.outline() if model.outline else []
    records = [int(np.abs(solution.t - t).argmin()) for t in times]
    bodies = [model.shape(solution.q[i]) for i in records]
    extent = np.ptp(np.concatenate([*fixed, *(line for lines in bodies for line in lines)]), axis=0)
    columns = min(SNAPSHOT_COLUMNS, len(records))
    rows = -(-len(records) // columns)
    tall = rows * (WIDTH / columns * extent[1] / extent[0] + 0.25) + 0.6
    figure = new_figure(WIDTH, float(np.clip(tall, 2.5, 9.0)))
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    for axes, k in zip(panels.flat, range(len(records)), strict=False):
        for line in fixed:
            axes.plot(*line.T, color=GREY, lw=2.0)
        for line in bodies[k - 1] if k else []:
            axes.plot(*line.T, "-", color=PALE, lw=1.2)
        for line in bodies[k]:
            axes.plot(*line.T, "-o", color=BLUE, lw=1.6, ms=3)
        axes.set_title(f"t = {solution.t[records[k]]:.4g} s", fontsize=LETTER)
        axes.set_aspect("equal")
        axes.tick_params(labelsize=LETTER)
        axes.locator_params(nbins=4)
        axes.grid(alpha=0.25)
    for axes in panels.flat[len(records) :]:
        axes.remove()
    figure.supxlabel("x [m]", fontsize=9)
    figure.supylabel("y [m]", fontsize=9)
    return save_figure(figure, path)


def plot_stability_map(chart: xarray.Dataset, path: str | Path | None = None, units: Sequence[str] = ("", "")) -> Any:
    """Draw the growth rate of steady sliding over two parameters, with the boundary of stability.

    Parameters
    ----------
    chart : xarray.Dataset
        From `stability_map`; its first parameter is drawn upwards.
    path : path-like, optional
        Where to save; the ending names the format.
    units : (str, str)
        Of the two parameters; those of the model when left out.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InvalidInput
        For another Dataset, for one value of a parameter, and where no point has an equilibrium.
    MissingExtra
        When Matplotlib is not installed.
    """
    import xarray

    as_instance("chart", chart, xarray.Dataset, "the Dataset of ns.stability_map(...)")
    if not {"growth", "verdict"} <= {str(name) for name in chart.data_vars} or chart.growth.ndim != 2:
        raise InvalidInput(
            "chart must be the Dataset of ns.stability_map(...), with the growth over two parameters; got one with "
            f"{shown(list(map(str, chart.data_vars)))}"
        )
    units = as_listed("units", units, "two texts")
    if len(units) != 2 or not all(isinstance(unit, str) for unit in units):
        raise InvalidInput(f"units must be two texts, one for each parameter; got {shown(units)}")
    if min(chart.growth.shape) < 2:
        raise InvalidInput(
            f"a map needs two values of each parameter; this one has {chart.growth.shape}: eigen_path draws along one"
        )
    if np.isnan(chart.growth.values).all():
        raise InvalidInput("there is nothing to draw: no point of this map has an equilibrium")
    from matplotlib.patches import Patch

    (y_name, y_unit), (x_name, x_unit) = zip(chart.growth.dims, units, strict=True)
    figure = new_figure(WIDTH, 3.8)
    axes = figure.subplots()
    x, y = chart[x_name].values, chart[y_name].values
    sizes = np.abs(chart.growth.values)
    most, size = float(np.nanmax(sizes)), float(np.nanquantile(sizes, SHOWN_GROWTH))
    colours = axes.pcolormesh(
        x, y, chart.growth.values, cmap="RdBu_r", vmin=-size, vmax=size, shading="nearest", rasterized=True
    )
    unstable = np.where(np.isnan(chart.verdict.values), 0.0, chart.verdict.values > 1)
    axes.set_facecolor(PALE)  # seen where there is no growth rate
    if unstable.min() < unstable.max():
        axes.contour(x, y, chart.growth.values, levels=[0.0], colors="black", linewidths=1.4)
        area = axes.contourf(x, y, chart.growth.values, levels=[0.0, 2 * most], colors="none", hatches=["//"])
        area.set_edgecolor(GREY)
        area.set_linewidth(0)
        axes.legend(handles=[Patch(facecolor="none", hatch="//", edgecolor=GREY, label="unstable")], fontsize=LETTER,
                    loc="lower left", bbox_to_anchor=(0.0, 1.0), frameon=False, borderaxespad=0.1)  # fmt: skip
    figure.colorbar(colours, label="growth max Re $s$ [1/s]", extend="both" if most > size else "neither")
    missing = int(np.isnan(chart.growth.values).sum())
    rows = [f"no equilibrium found in {missing} of {chart.growth.size} points (grey)"] if missing else []
    set_title(figure, "\n".join([held_fixed(chart, TITLE_LETTERS), *rows]))
    axes.set_xlabel(parameter_label(str(x_name), unit=x_unit or chart[x_name].attrs.get("units", "")))
    axes.set_ylabel(parameter_label(str(y_name), unit=y_unit or chart[y_name].attrs.get("units", "")))
    return save_figure(figure, path)
