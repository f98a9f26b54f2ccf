"""Figures of paradoxes: region maps with their boundary curves and motions over them, and the graphical problem.

Matplotlib is imported inside the functions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.checks.arrays import as_array, as_index, as_instance, as_listed
from nonsmooth.drawing.colours import BLUE, RED, REGIONS
from nonsmooth.drawing.labels import LETTER, legend_above, parameter_label
from nonsmooth.drawing.plots import (
    BELOW,
    UNDER_LABELS,
    WIDTH,
    held_fixed,
    is_geometric,
    new_figure,
    save_figure,
    set_title,
    title_rows,
)
from nonsmooth.errors import InvalidInput, shown
from nonsmooth.paradox.kinds import ParadoxKind

if TYPE_CHECKING:
    import xarray

    from nonsmooth.paradox.boundaries import Boundaries
    from nonsmooth.paradox.classify import Classification

KINDS = {  # label, colour, hatching
    ParadoxKind.INCONSISTENT: ("inconsistent: no solution", *REGIONS[0][1:]),
    ParadoxKind.REGULAR: ("regular: one solution", *REGIONS[1][1:]),
    ParadoxKind.INDETERMINATE: ("indeterminate: several solutions", *REGIONS[2][1:]),
    ParadoxKind.NOT_ENUMERATED: ("not enumerated", "#e8e8e8", "xx"),
    ParadoxKind.INADMISSIBLE: ("inadmissible: penetrates or lands", "#bdbdbd", ""),
    ParadoxKind.NOT_REACHED: ("not reached", "#ffffff", ".."),
}
COUNTED = (ParadoxKind.INCONSISTENT, ParadoxKind.REGULAR, ParadoxKind.INDETERMINATE)
UNCOUNTED = -1  # code: of a region that gets no number, for its kind says that there is none
CURVES = {"p": ("$p = 0$", "-"), "b": ("$b = 0$", "--"), "gamma_F": ("$\\gamma_F = 0$", ":")}
HATCHES = "#8f8f8f"
SMALLEST_LABEL = 2e-3  # chosen: of the map's area: a smaller region gets no label
# chosen: of the map's width: a label stands beside a region that is no wider, ``BESIDE_NARROW`` points away
NARROW_REGION = 0.03
BESIDE_NARROW = -30  # chosen: points, to the left
MAP_LETTERS = 64  # chosen: of a line of the title of a map


def plot_map(
    chart: xarray.Dataset,
    path: str | Path | None = None,
    *,
    boundaries: Boundaries | None = None,
    motions: Iterable[np.ndarray] = (),
    regions: tuple[np.ndarray, Callable[[int], str]] | None = None,
    title: str | None = None,
) -> Any:
    """Draw a map of paradoxes over two axes, or the normal forces over one.

    Parameters
    ----------
    chart : xarray.Dataset
        From `paradox_map`; take a slice of one with more than two axes, as in ``chart.isel(mu=0)``.
    path : path-like, optional
        Where to save; the ending names the format.
    boundaries : Boundaries, optional
        From `paradox_boundaries` over the same axes.
    motions : sequence of ndarray (n, 2)
        Motions drawn over the map, each from its start, which gets a dot.
    regions : (ndarray, callable), optional
        Code of the region of each point, and a function that names a code; each connected region is labelled.
        Without it regions are labelled by their numbers of solutions.
    title : str, optional

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InvalidInput
        For more than two axes.
    """
    import xarray

    from nonsmooth.paradox.boundaries import Boundaries

    as_instance("chart", chart, xarray.Dataset, "the Dataset of ns.paradox_map(...)")
    if "kind" not in chart or "n_solutions" not in chart:
        raise InvalidInput(
            "chart must be the Dataset of ns.paradox_map(...), with the kind of each state; got one with "
            f"{shown(list(map(str, chart.data_vars)))}: ns.plot_sweep draws a sweep, ns.plot_stability_map a map of "
            "stability"
        )
    if boundaries is not None:
        as_instance("boundaries", boundaries, Boundaries, "what ns.paradox_boundaries(...) gives")
    moved = [as_motion(motion) for motion in as_listed("motions", motions, "a list of arrays (n, 2)")]
    if regions is not None and not (isinstance(regions, tuple) and len(regions) == 2 and callable(regions[1])):
        raise InvalidInput(f"regions must be a pair (codes, function that names a code); got {shown(regions)}")
    if title is not None:
        as_instance("title", title, str, "a text")
    axes_names = [str(name) for name in chart.kind.dims]
    if len(axes_names) > 2:
        raise InvalidInput(f"a figure has two axes; this map has {', '.join(axes_names)}: take a slice with isel")
    figure = new_figure(WIDTH, 4.9)
    axes = figure.subplots()
    if len(axes_names) == 1:
        draw_forces_along(axes, chart, axes_names[0])
    else:
        handles = draw_regions(axes, chart, axes_names)
        label_regions(axes, chart, axes_names, regions)
        handles += draw_curves(axes, boundaries) + draw_motions(axes, moved)
        axes.legend(handles=handles, bbox_to_anchor=(0.5, 0.0), borderaxespad=UNDER_LABELS, ncols=2, **BELOW)
    for name, set_scale in zip(axes_names, (axes.set_xscale, axes.set_yscale), strict=False):
        if is_geometric(chart[name].values):
            set_scale("log")
    axes.set_xlabel(axis_label(chart, axes_names[0]))
    set_title(figure, held_fixed(chart, MAP_LETTERS) if title is None else "\n".join(title_rows(title, MAP_LETTERS)))
    return save_figure(figure, path)


def draw_regions(axes: Any, chart: xarray.Dataset, names: list[str]) -> list[Any]:
    """Colour and hatch the regions; returns their legend."""
    from matplotlib.patches import Patch

    x, y = (chart[name].values for name in names)
    kind = chart.kind.transpose(names[1], names[0]).values
    handles = []
    for code, (label, colour, hatch) in KINDS.items():
        is_there = kind == code
        if not is_there.any():
            continue
        area = axes.contourf(x, y, is_there, levels=[0.5, 1.5], colors=[colour], hatches=[hatch])
        area.set_edgecolor(HATCHES)
        area.set_linewidth(0)
        handles.append(Patch(facecolor=colour, hatch=hatch, edgecolor=HATCHES, label=label))
    axes.set_xlim(x.min(), x.max())
    axes.set_ylim(y.min(), y.max())
    axes.set_ylabel(axis_label(chart, names[1]))
    return handles


def label_regions(axes: Any, chart: xarray.Dataset, names: list[str],
                  regions: tuple[np.ndarray, Callable[[int], str]] | None) -> None:  # fmt: skip
    """Write the name of each connected region where it is widest."""
    from scipy.ndimage import distance_transform_edt, label

    x, y = (chart[name].values for name in names)
    counts = chart.n_solutions.where(chart.kind.isin(COUNTED), UNCOUNTED).transpose(*names).values
    codes, name_of = regions or (counts, str)
    for code in np.unique(codes if regions else counts[counts != UNCOUNTED]):
        parts, count = label(codes == code)
        for part in range(1, count + 1):
            inside = parts == part
            if inside.mean() < SMALLEST_LABEL:
                continue
            depth = distance_transform_edt(np.pad(inside, 1))[1:-1, 1:-1]
            i, j = np.unravel_index(depth.argmax(), depth.shape)
            is_narrow = depth.max() < NARROW_REGION * min(depth.shape)
            aside = BESIDE_NARROW if i > 0.5 * len(x) else -BESIDE_NARROW  # into the map
            axes.annotate(
                name_of(int(code)), (x[i], y[j]), (aside if is_narrow else 0, 0), textcoords="offset points",
                ha="center", va="center", fontsize=10, zorder=7,
                arrowprops={"arrowstyle": "-", "lw": 0.8} if is_narrow else None,
                bbox={"boxstyle": "round,pad=0.2", "fc": "white", "ec": "none", "alpha": 0.85},
            )  # fmt: skip


def draw_curves(axes: Any, boundaries: Boundaries | None) -> list[Any]:
    """The zero curves and their crossings; returns their legend."""
    from matplotlib.lines import Line2D

    if boundaries is None:
        return []
    handles = []
    for field, (label, style) in CURVES.items():
        lines = getattr(boundaries, field)
        for line in lines:
            axes.plot(*line.T, color="black", ls=style, lw=1.4)
        if lines:
            handles.append(Line2D([], [], color="black", ls=style, label=label))
    points = boundaries.crossings["p", "b"]
    if len(points):
        dot: dict[str, Any] = {"marker": "o", "ls": "", "mfc": "white", "mec": "black", "ms": 6, "zorder": 6}
        axes.plot(*points.T, **dot)
        handles.append(Line2D([], [], label="Génot–Brogliato point, $p = b = 0$", **dot))
    return handles


def as_motion(motion: Any) -> np.ndarray:
    """A motion in the plane of a map, (n, 2)."""
    points = as_array("motions", motion)
    if points.ndim != 2 or points.shape[1] != 2 or len(points) == 0:
        raise InvalidInput(f"motions must be a list of arrays (n, 2); got one of shape {points.shape}")
    return points


def draw_motions(axes: Any, motions: Iterable[np.ndarray]) -> list[Any]:
    """Motions as curves from a dot; returns their legend."""
    from matplotlib.lines import Line2D

    is_any = False
    for motion in motions:
        axes.plot(*motion.T, color=BLUE, lw=1.4, zorder=4)
        axes.plot(*motion[0], "o", color=BLUE, ms=5, zorder=5)
        is_any = True
    return [Line2D([], [], color=BLUE, marker="o", ms=5, label="motion from its start")] if is_any else []


def draw_forces_along(axes: Any, chart: xarray.Dataset, name: str) -> None:
    """The normal forces of every solution over one axis, the kinds as a background."""
    x, kind = chart[name].values, chart.kind.values
    for code, (label, colour, hatch) in KINDS.items():
        if (kind == code).any() and code != ParadoxKind.REGULAR:
            axes.fill_between(x, 0, 1, where=kind == code, transform=axes.get_xaxis_transform(), step="mid",
                              facecolor=colour, hatch=hatch, edgecolor=HATCHES, lw=0, label=label)  # fmt: skip
    la_N = chart.la_N.transpose(name, ...).values.reshape(len(x), -1)
    for column in la_N.T:
        if np.isfinite(column).any():
            axes.plot(x, column, ".", color=BLUE, ms=3)
    size = np.nanquantile(np.abs(la_N), 0.95) if np.isfinite(la_N).any() else 0.0
    if size > 0 and np.nanmax(np.abs(la_N)) > 4 * size:
        axes.set_ylim(-4 * size if np.nanmin(la_N) < 0 else -0.2 * size, 4 * size)
        axes.text(0.99, 0.985, f"up to {np.nanmax(np.abs(la_N)):.3g} N beyond the axis", transform=axes.transAxes,
                  ha="right", va="top", fontsize=LETTER)  # fmt: skip
    axes.set_xlim(x.min(), x.max())
    axes.set_ylabel("$\\lambda_N$ of each solution [N]")
    axes.grid(alpha=0.25)
    legend_above(axes)


def axis_label(chart: xarray.Dataset, name: str) -> str:
    """Symbol and unit of an axis."""
    return parameter_label(name, unit=chart[name].attrs.get("units", ""))


def plot_graphical_problem(cases: Classification | Sequence[tuple[str, Classification]],
                           path: str | Path | None = None, contact: int = 0) -> Any:  # fmt: skip
    """Draw gamma_N' = p la_N + b against la_N: where it meets the corner of Signorini's law, or the axis gamma_N' = 0
    of a bilateral contact, is a solution.

    Parameters
    ----------
    cases : Classification, or sequence of (title, Classification)
        States in which one contact is closed, and slides or has no friction; each gets a panel.
    path : path-like, optional
        Where to save.
    contact : int

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InvalidInput
        Where the contact rests, is not alone, or has a given normal force.
    """
    panels = as_cases(cases)
    if not all(c.mode for _, c in panels):
        raise InvalidInput("the graphical problem needs a contact; this system has none")
    contact = min(as_index("contact", contact, len(c.mode)) for _, c in panels)
    columns = min(2, len(panels))
    rows = -(-len(panels) // columns)
    figure = new_figure(WIDTH, (2.6 if columns == 2 else 3.4) * rows + 0.7)
    grid = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes, (title, c) in zip(grid, panels, strict=False):
        draw_graphical_problem(axes, c, contact)
        axes.set_title(title or c.kind.name.lower(), fontsize=10)
    for axes in grid[len(panels) :]:
        axes.set_visible(False)
    keys = {label: handle for axes in grid for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)}
    figure.legend(keys.values(), keys, loc="outside lower center", ncols=2, fontsize=LETTER, frameon=False)
    return save_figure(figure, path)


def as_cases(cases: Any) -> list[tuple[str, Classification]]:
    """Titles and states, or `InvalidInput`."""
    from nonsmooth.paradox.classify import Classification

    panels = list(cases) if isinstance(cases, list | tuple) else [("", cases)]
    if not panels or not all(isinstance(p, tuple) and len(p) == 2 and isinstance(p[1], Classification) for p in panels):
        raise InvalidInput(f"cases must be a Classification or pairs (title, Classification); got {shown(cases)}")
    return panels


def draw_graphical_problem(axes: Any, c: Classification, contact: int) -> None:
    """One state: the line of the contact, the pairs that its law admits, the solutions."""
    has_friction = require_drawable(c, contact)
    s = 0 if not has_friction or c.gamma_F[contact] > 0 else 1
    p, b, is_bilateral = c.p[contact, s], c.b[contact], bool(c.is_bilateral[contact])
    slopes = (c.p[contact, 1 - s], p) if is_bilateral else (p, p)  # where it pulls, and where it pushes
    forces = [s.la_N[contact] for s in c.solutions]
    reach = (
        1.7 * max([*(abs(b / slope) if slope else 1.0 for slope in slopes[not is_bilateral :]), *np.abs(forces)]) or 1.0
    )
    left = -reach if is_bilateral else -0.35 * reach
    la = np.array([left, 0.0, reach] if is_bilateral else [left, reach])
    line = np.where(la < 0, slopes[0], slopes[1]) * la + b
    height = 1.25 * max(abs(b), np.abs(line).max() / 2) or 1.0
    axes.axhline(0, color="#b0b0b0", lw=0.8)
    axes.axvline(0, color="#b0b0b0", lw=0.8)
    law: dict[str, Any] = {"color": "#636363", "lw": 4, "alpha": 0.45, "solid_joinstyle": "miter"}
    if is_bilateral:
        axes.plot([left, reach], [0, 0], label="$\\dot\\gamma_N = 0$, $\\lambda_N$ of either sign", **law)
    else:
        axes.plot([0, 0, reach], [height, 0, 0], label="$0 \\leq \\lambda_N \\perp \\dot\\gamma_N \\geq 0$", **law)
    axes.plot(la, line, color=BLUE, lw=1.8, label="$\\dot\\gamma_N = p\\,\\lambda_N + b$")
    points = [(s.la_N[contact], s.dgamma_N[contact]) for s in c.solutions]
    axes.plot(*np.array(points).reshape(-1, 2).T, "o", color=RED, ms=7, zorder=5, label="solutions")
    axes.set_xlim(left, reach)
    axes.set_ylim(-height, height)
    axes.set_xlabel("$\\lambda_N$ [N]")
    axes.set_ylabel("$\\dot\\gamma_N$ [m/s²]")
    places = (" ($\\lambda_N > 0$)", " ($\\lambda_N < 0$)") if is_bilateral and has_friction else ("",)
    rows = [f"$p = {slope:.3g}$ {compared(slope)} 0{place}" for slope, place in zip(slopes[::-1], places, strict=False)]
    rows += [f"$b = {b:.3g}$ {compared(b)} 0", f"{c.n_solutions} solution" + ("" if c.n_solutions == 1 else "s")]
    is_taken = 0.75 * slopes[1] * reach + b > 0.3 * height  # the upper corner, by the line
    axes.text(0.97, 0.05 if is_taken else 0.95, "\n".join(rows), transform=axes.transAxes, ha="right", fontsize=LETTER,
              va="bottom" if is_taken else "top", bbox={"fc": "white", "ec": "none", "alpha": 0.8})  # fmt: skip


def compared(x: float) -> str:
    """How a number compares with zero."""
    return "<" if x < 0 else ">" if x > 0 else "="


def require_drawable(c: Classification, contact: int) -> bool:
    """Whether the contact has friction; InvalidInput where its problem is no line over its own force alone."""
    if reason := why_no_line(c, contact):
        raise InvalidInput(f"the graphical problem needs {reason}")
    return bool(np.isfinite(c.k[contact]).all())


def why_no_line(c: Classification, contact: int) -> str:
    """What is missing where the problem of a contact is no line over its own force alone; nothing where it is one."""
    if sum(mode != "open" for mode in c.mode) != 1 or c.mode[contact] == "open":
        n = sum(mode != "open" for mode in c.mode)
        return f"one closed contact, whose force alone matters; here are {n}"
    if not np.isfinite(c.p[contact]).all():
        return "a normal force to be found; that of this contact is given"
    if np.isfinite(c.k[contact]).all() and not c.mode[contact].startswith("sliding"):
        return (
            "a contact without friction, or one that must slide; this one rests, and may "
            "stick or slide either way, each with another line: give it a sliding velocity"
        )
    return ""
