"""Figures of a run: time histories, contact forces, modes, energy, and the phase plane where a model has one.

Matplotlib is imported inside the functions. A model may give ``coordinates`` (names and units), and ``phase_axes`` with
``phase_map(x, y) -> (numbers of solutions, {label: field})`` whose zeros are drawn as curves.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.errors import MissingExtra
from nonsmooth.system import ContactMode

if TYPE_CHECKING:
    from nonsmooth.solution import Solution

MODE_COLOURS = {
    ContactMode.OPEN: "#d9d9d9",
    ContactMode.STICK: "#1b7837",
    ContactMode.SLIDE: "#f1a340",
    ContactMode.LOCKED: "#542788",
}
MARGIN = 0.15  # of the orbit's extent, around it in the phase plane
GRID = 400
BESIDE: dict[str, Any] = {"loc": "center left", "bbox_to_anchor": (1.01, 0.5), "fontsize": 8, "frameon": False}
MAX_POINTS = 20_000  # drawn of one curve


def new_figure(width: float, height: float) -> Any:
    """A Matplotlib figure without pyplot's global state."""
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise MissingExtra('figures need Matplotlib; install it with pip install "nonsmooth[plot]"') from None
    return Figure(figsize=(width, height), layout="constrained")


def plot_solution(solution: Solution, path: str | Path | None = None) -> Any:
    """Draw a run; returns the figure, saved to ``path`` if given."""
    model = solution.system.parameters if solution.system else None
    has_phase_plane = hasattr(model, "phase_map")
    figure = new_figure(13 if has_phase_plane else 8, 8)
    histories = figure
    if has_phase_plane:
        left, histories = figure.subfigures(1, 2, width_ratios=(1.15, 1))
        draw_phase_plane(left.subplots(), solution, model)
    n_c = solution.mode.shape[1]
    rows = histories.subplots(5 if n_c else 3, 1, sharex=True, height_ratios=(3, 3, 3, 3, 1) if n_c else None)
    draw_states(rows[0], rows[1], solution, model)
    draw_energy(rows[2], solution)
    if n_c:
        draw_forces(rows[3], solution)
        draw_modes(rows[4], solution)
    rows[-1].set_xlabel("t [s]")
    figure.suptitle(str(solution.about.get("system", "")))
    if path is not None:
        figure.savefig(path, dpi=150)
    return figure


def draw_states(above: Any, below: Any, solution: Solution, model: Any) -> None:
    """Coordinates and velocities; at most eight of them by name."""
    names = getattr(model, "coordinates", None) or [(f"q{k}", "") for k in range(solution.q.shape[1])]
    k = thinning(solution)
    for i, (name, unit) in list(enumerate(names))[:8]:
        above.plot(solution.t[k], solution.q[k, i], label=f"{name} [{unit}]" if unit else name)
        below.plot(solution.t[k], solution.u[k, i], label=f"{name}' [{unit}/s]" if unit else f"{name}'")
    above.set_ylabel("coordinates")
    below.set_ylabel("velocities")
    for axes in (above, below):
        axes.legend(**BESIDE)


def draw_energy(axes: Any, solution: Solution) -> None:
    """Energies and works, all since the start."""
    k = thinning(solution)
    for name, column in solution.ledger.items():
        if np.ptp(column) > 0:
            label = f"{name} energy" if name in ("kinetic", "potential") else f"work of {name}"
            axes.plot(solution.t[k], column[k] - column[0], label=label)
    axes.set_ylabel("change [J]")
    axes.legend(**BESIDE)


def draw_forces(axes: Any, solution: Solution) -> None:
    """Mean normal force between records, clipped at the 99.5th percentile so that impacts do not hide the rest."""
    force = solution.P_N[1:] / np.diff(solution.t)[:, None]
    k = thinning(solution)[1:] - 1
    for i in range(min(force.shape[1], 6)):
        axes.step(solution.t[1:][k], force[k, i], where="post", label=f"contact {i}", lw=0.9)
    limit = np.quantile(np.abs(force), 0.995) if force.size else 0.0
    if limit > 0 and np.abs(force).max() > 2 * limit:
        axes.set_ylim(-1.1 * limit if force.min() < 0 else -0.05 * limit, 1.1 * limit)
        axes.set_title("impulsive peaks beyond the axis are cut", fontsize=8, loc="right")
    axes.set_ylabel("$P_N/\\Delta t$ [N]")
    if force.shape[1] > 1:
        axes.legend(**BESIDE)


def draw_modes(axes: Any, solution: Solution) -> None:
    """A strip for each contact, coloured by its mode."""
    from matplotlib.patches import Patch

    n_c = solution.mode.shape[1]
    for i in range(n_c):
        mode = solution.mode[1:, i]
        change = np.flatnonzero(np.diff(mode)) + 1
        first = np.concatenate(([0], change))
        last = np.concatenate((change, [len(mode)]))
        for a, b in zip(first, last, strict=True):
            if b > a:
                axes.axvspan(
                    solution.t[a], solution.t[b], i / n_c, (i + 1) / n_c, color=MODE_COLOURS[ContactMode(mode[a])], lw=0
                )
    axes.set_yticks([])
    axes.set_ylabel("mode")
    handles = [
        Patch(color=MODE_COLOURS[mode], label=mode.name.lower())
        for mode in ContactMode
        if (solution.mode == mode).any()
    ]
    axes.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, -0.9), ncols=4, fontsize=8, frameon=False)


def draw_phase_plane(axes: Any, solution: Solution, model: Any) -> None:
    """The orbit over the map of the numbers of solutions, with the curves that bound its regions."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    i, j = model.phase_axes
    x, y = solution.q[:, i], solution.u[:, j]
    grid_x, grid_y = (np.linspace(*extent(values), GRID) for values in (x, y))
    counts, fields = model.phase_map(*np.meshgrid(grid_x, grid_y))
    colours, hatches = ["#f4a6a0", "#ffffff", "#bcd7ee"], ["///", None, "..."]
    axes.contourf(grid_x, grid_y, counts, levels=[-0.5, 0.5, 1.5, 2.5], colors=colours, hatches=hatches,
                  )  # fmt: skip
    handles: list[Any] = [
        Patch(facecolor=colours[n], hatch=hatches[n], edgecolor="grey", label=label)
        for n, label in enumerate(("no solution", "one solution", "two solutions"))
    ]
    for (label, field), style in zip(fields.items(), ("-", "--", ":"), strict=False):
        if field.min() < 0 < field.max():
            axes.contour(grid_x, grid_y, field, levels=[0.0], colors="black", linestyles=style, linewidths=1.2)
            handles.append(Line2D([], [], color="black", ls=style, label=label))
    axes.plot(x, y, color="#08306b", lw=1.3)
    axes.plot(x[0], y[0], "o", color="#08306b", ms=5)
    handles.append(Line2D([], [], color="#08306b", marker="o", ms=5, label="motion from its start"))
    names = model.coordinates
    axes.set_xlabel(f"{names[i][0]} [{names[i][1]}]")
    axes.set_ylabel(f"{names[j][0]}' [{names[j][1]}/s]")
    axes.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, -0.08), ncols=3, fontsize=9, frameon=False)


def extent(values: np.ndarray) -> tuple[float, float]:
    """The range of the values with a margin on both sides."""
    low, high = float(values.min()), float(values.max())
    margin = MARGIN * (high - low) or 1.0
    return low - margin, high + margin


def thinning(solution: Solution) -> np.ndarray:
    """Indices of the records that are drawn."""
    n = len(solution.t)
    return np.unique(np.linspace(0, n - 1, min(n, MAX_POINTS)).astype(int))
