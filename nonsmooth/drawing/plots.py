"""Figures of a run: time histories, contact forces, modes, energy, and the phase plane where a model has one.

Matplotlib is imported inside the functions. A model may give ``coordinates`` (names and units), and ``phase_axes`` with
``phase_map(x, y) -> (numbers of solutions, {label: field})`` whose zeros are drawn as curves.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.checks.files import FIGURE_ENDINGS, as_place, whole_file
from nonsmooth.errors import MissingExtra
from nonsmooth.mechanics.system import ContactMode
from nonsmooth.results.solution import mode_name

if TYPE_CHECKING:
    from nonsmooth.results.solution import Solution

STRIPS = {  # (mode, sign of sliding): colour
    (ContactMode.OPEN, 0): "#d9d9d9",
    (ContactMode.STICK, 0): "#1b7837",
    (ContactMode.SLIDE, 1): "#fdb863",
    (ContactMode.SLIDE, 0): "#f1a340",
    (ContactMode.SLIDE, -1): "#b35806",
    (ContactMode.LOCKED, 0): "#542788",
}
REGIONS = (("no solution", "#f4a6a0", "//"), ("one solution", "#ffffff", ""), ("two solutions", "#d3e3f3", ".."))
BLUE, RED = "#08306b", "#b2182b"
PHASE_PLANE_MARGIN = 0.2  # chosen: of the orbit's extent, around it in the phase plane
GRID = 400  # chosen: points of the phase map along each axis
MOST_DRAWN = 20_000  # chosen: drawn of one curve
MAX_NAMES = 8  # chosen: coordinates drawn; a chain has hundreds
FLAT = 1e-6  # chosen: of its size: a curve that varies less is drawn as the constant it is
HAIR = 2e-3  # chosen: of the run: a mode that lasts less would be thinner than a dot
LETTERS = 11.5  # chosen: of a title, per inch of the figure's width
MAX_STRIPS = 4000  # chosen: rectangles of a mode strip: an accumulation of impacts has more than a screen can show
BESIDE: dict[str, Any] = {"loc": "center left", "bbox_to_anchor": (1.01, 0.5), "fontsize": 8, "frameon": False}
UNDER_LABELS = 4.5  # chosen: of a legend below an axis, in its letters: under the numbers and the label of the axis
BELOW: dict[str, Any] = {"loc": "upper center", "fontsize": 8, "frameon": False}


def new_figure(width: float, height: float) -> Any:
    """A Matplotlib figure without pyplot's global state, which a notebook shows."""
    try:
        from nonsmooth.drawing.notebook_figure import NotebookFigure
    except ImportError:
        raise MissingExtra('figures need Matplotlib; install it with pip install "nonsmooth[plot]"') from None
    return NotebookFigure(figsize=(width, height), layout="constrained")


def save_figure(figure: Any, path: str | Path | None) -> Any:
    """The figure, written to ``path`` where one is given; its ending names the format."""
    if path is not None:
        path = as_place("path", path, FIGURE_ENDINGS)
        with whole_file(path) as part:
            figure.savefig(part, dpi=150, format=path.suffix[1:])
    return figure


def plot_solution(solution: Solution, path: str | Path | None = None) -> Any:
    """Draw a run: states, energy, contact forces and modes against time, and the phase plane where the model has one.

    Parameters
    ----------
    solution : Solution
    path : path-like, optional
        Where to save; the ending names the format.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    MissingExtra
        When Matplotlib is not installed.
    """
    model = solution.system.parameters if solution.system else None
    has_phase_plane = hasattr(model, "phase_map")
    figure = new_figure(14 if has_phase_plane else 8.5, 8.5)
    histories = figure
    if has_phase_plane:
        left, histories = figure.subfigures(1, 2, width_ratios=(1.1, 1))
        draw_phase_plane(left.subplots(), solution, model)
    n_c = solution.mode.shape[1]
    strips = 0.4 + 0.2 * n_c if n_c <= 4 else 2.0
    rows = histories.subplots(5 if n_c else 3, 1, sharex=True, height_ratios=(3, 3, 3, 3, strips) if n_c else None)
    draw_states(rows[0], rows[1], solution)
    draw_energy(rows[2], solution)
    if n_c:
        draw_forces(rows[3], solution)
        draw_modes(rows[4], solution)
    for axes in rows[:4]:
        axes.grid(alpha=0.25)
        show_no_rounding(axes)
    rows[-1].set_xlabel("t [s]")
    if solution.t[-1] > solution.t[0]:
        rows[-1].set_xlim(solution.t[0], solution.t[-1])
    letters = int(LETTERS * figure.get_figwidth())
    figure.suptitle(title_of(solution, letters), fontsize=10, family="monospace")  # tells l from I
    return save_figure(figure, path)


def title_of(solution: Solution, letters: int) -> str:
    """The system, its parameters in lines of so many letters, the integrator, and where an unfinished run stopped."""
    about, lines = solution.about, [""]
    for name, value in about.items():
        if isinstance(value, int | float):
            text = f"{name} = {value:.4g}"
            if len(lines[-1]) + len(text) + 2 > letters:
                lines.append("")
            lines[-1] += f"  {text}" if lines[-1] else text
    values = "\n".join(lines)
    title = f"{about.get('system', '')}   {about.get('integrator', '')}\n{values}"
    return title if solution.success else f"{title}\n{solution.status.name} at t = {solution.t[-1]:.6g} s"


def draw_states(above: Any, below: Any, solution: Solution) -> None:
    """Coordinates and velocities, eight of them at most."""
    n, names = solution.q.shape[1], solution.described
    k = thinning(solution)
    for i in some_of(n):
        above.plot(solution.t[k], solution.q[k, i], label=names.label(i), lw=1.2)
        below.plot(solution.t[k], solution.u[k, i], label=names.rate_label(i), lw=1.2)
    more = f"\n({MAX_NAMES} of {n})" if n > MAX_NAMES else ""
    above.set_ylabel(f"coordinates{more}")
    below.set_ylabel(f"velocities{more}")
    for axes in (above, below):
        axes.legend(**BESIDE)


def draw_energy(axes: Any, solution: Solution) -> None:
    """Energies and works, all since the start; of a changing mass and its gyroscopic force, which cancel, the sum."""
    k = thinning(solution)
    ledger = dict(solution.ledger)
    if "mass" in ledger:
        ledger["force, changing mass"] = ledger.pop("force") + ledger.pop("mass")
    for name, column in sorted(ledger.items(), key=lambda item: item[0] not in ("kinetic", "potential")):
        if np.ptp(column) > 0:
            is_state = name in ("kinetic", "potential")
            label = f"{name} energy" if is_state else f"work: {name}"
            values = column[k] - column[0]
            axes.plot(solution.t[k], values, label=label, lw=1.6 if is_state else 1.0, ls="-" if is_state else "--")
    axes.set_ylabel("change [J]")
    if axes.lines:
        axes.legend(**BESIDE)
    else:
        axes.plot(solution.t[[0, -1]], [0.0, 0.0], color="grey", lw=1.0)
        axes.text(0.5, 0.6, "no energy changes and no work is done", transform=axes.transAxes, ha="center", fontsize=9)


def index_of(solution: Solution, i: int) -> str:
    """What tells the forces of a contact from those of others: its name, or its number."""
    name = own_name(solution.described.contacts[i], i)
    return f", {name}" if name else f"$_{{{i}}}$" if solution.mode.shape[1] > 1 else ""


def own_name(name: str, i: int) -> str:
    """The name that the user gave a contact, or nothing."""
    return "" if name == f"contact {i}" else name


def draw_forces(axes: Any, solution: Solution) -> None:
    """Mean contact forces between records; where impacts would hide the rest, the axis is cut and says so.

    The impulse of an impact between two records of one instant is no force: it is left out.
    """
    span = np.diff(solution.t)[:, None]
    lasts = span > 0
    normal, friction = (
        np.divide(P[1:].reshape(len(span), P[0].size), span, out=np.zeros((len(span), P[0].size)), where=lasts)
        for P in (solution.P_N, solution.P_F)
    )
    k = thinning(solution)[1:] - 1
    k = k[lasts[k, 0]]
    n_c = normal.shape[1]
    for i in some_of(n_c):
        which = index_of(solution, i)
        axes.step(solution.t[1:][k], normal[k, i], where="pre", label=f"normal{which}", lw=1.0)
        if friction.shape[1] == n_c and n_c <= 3 and friction[:, i].any():
            axes.step(solution.t[1:][k], friction[k, i], where="pre", label=f"friction{which}", lw=1.0, ls="--")
    force = np.concatenate((normal, friction), axis=1)
    size = np.abs(force).max(axis=1)
    limit = float(np.quantile(size, 0.99)) if len(size) else 0.0
    if limit > 0 and size.max() > 4 * limit:
        axes.set_ylim(-1.2 * limit if force.min() < 0 else -0.05 * limit, 1.2 * limit)
        axes.set_title(f"impulsive peaks leave the axis: up to {size.max():.3g} N over a step", fontsize=8, loc="right")
    more = f"\n({MAX_NAMES} of {n_c})" if n_c > MAX_NAMES else ""
    axes.set_ylabel(f"force, $P/\\Delta t$ [N]{more}")
    axes.legend(**BESIDE)


def draw_modes(axes: Any, solution: Solution) -> None:
    """A strip for each contact, coloured by its mode, with a mark above it at each paradox."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    n_c = solution.mode.shape[1]
    code = 3 * solution.mode + np.sign(solution.slip) + 1
    met = {divmod(int(value), 3) for value in np.unique(code[1:])}
    for i in range(n_c):
        draw_strip(axes, solution.t, code[1:, i], i, n_c)
    axes.set_ylim(-0.5, n_c - 0.5 + 0.35 * bool(solution.paradoxes))
    names = solution.described.contacts
    axes.set_yticks(
        range(n_c) if 1 < n_c <= 4 else [], [own_name(names[i], i) or str(i) for i in range(n_c)][: 4 * (1 < n_c <= 4)]
    )
    axes.set_ylabel("mode" if n_c <= 4 else f"modes of\n{n_c} contacts")
    handles: list[Any] = [
        Patch(color=colour, label=mode_name(mode, sign))
        for (mode, sign), colour in STRIPS.items()
        if (mode, sign + 1) in met
    ]
    for has_none, marker, label in ((True, "v", "inconsistent"), (False, "|", "indeterminate from")):
        times = [event.t for event in solution.paradoxes if (event.n_solutions == 0) == has_none]
        if times:
            style: dict[str, Any] = {"marker": marker, "color": RED, "ls": "", "ms": 6}
            axes.plot(times, np.full(len(times), n_c - 0.3), clip_on=False, zorder=5, **style)
            handles.append(Line2D([], [], label=label, **style))
    axes.legend(handles=handles, bbox_to_anchor=(0.5, 0.0), borderaxespad=UNDER_LABELS, ncols=4, **BELOW)


def draw_strip(axes: Any, t: np.ndarray, code: np.ndarray, i: int, n_c: int) -> None:
    """The intervals of equal mode of one contact."""
    if not len(code):
        return
    first = np.concatenate(([0], np.flatnonzero(np.diff(code)) + 1))
    last = np.append(first[1:], len(code))
    k = np.unique(np.linspace(0, len(first) - 1, min(len(first), MAX_STRIPS)).astype(int))
    lasting = t[last[k]] - t[first[k]]
    is_hair = lasting < HAIR * (t[-1] - t[0])
    order = np.argsort(is_hair, kind="stable")  # hairs are drawn last, with an edge that makes them visible
    colours = [STRIPS[(ContactMode(int(c) // 3), int(c) % 3 - 1)] for c in code[first[k[order]]]]
    axes.broken_barh(
        np.column_stack((t[first[k]], lasting))[order], (i - 0.45, 0.9) if n_c <= 20 else (i - 0.5, 1.0),
        facecolors=colours, edgecolors=colours, linewidths=0.7 * is_hair[order] * (n_c <= 20),
    )  # fmt: skip


def draw_phase_plane(axes: Any, solution: Solution, model: Any) -> None:
    """The orbit over the map of the numbers of solutions, with the curves that bound its regions."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    i, j = model.phase_axes
    x, y = solution.q[:, i], solution.u[:, j]
    grid_x, grid_y = (np.linspace(*extent(values), GRID) for values in (x, y))
    counts, fields = model.phase_map(*np.meshgrid(grid_x, grid_y))
    handles: list[Any] = []
    for n, (label, colour, hatch) in enumerate(REGIONS):
        if (counts == n).any():
            area = axes.contourf(grid_x, grid_y, counts == n, levels=[0.5, 1.5], colors=[colour], hatches=[hatch])
            area.set_edgecolor("#a0a0a0")
            area.set_linewidth(0)
            handles.append(Patch(facecolor=colour, hatch=hatch, edgecolor="#a0a0a0", label=f"{label} while it slides"))
    for (label, field), style in zip(fields.items(), ("-", "--", ":"), strict=False):
        if field.min() < 0 < field.max():
            axes.contour(grid_x, grid_y, field, levels=[0.0], colors="black", linestyles=style, linewidths=1.4)
            handles.append(Line2D([], [], color="black", ls=style, label=label))
    axes.plot(x, y, color=BLUE, lw=1.8)
    axes.plot(x[0], y[0], "o", color=BLUE, ms=6)
    handles.append(Line2D([], [], color=BLUE, marker="o", ms=6, label="motion from its start"))
    jumps = [np.searchsorted(solution.t, event.t, "right") - 1 for event in solution.paradoxes if not event.n_solutions]
    if jumps:
        axes.plot(x[jumps], y[jumps], "v", color=RED, ms=7, mec="white", zorder=5)
        handles.append(Line2D([], [], color=RED, marker="v", ls="", ms=7, label="impact without collision from here"))
    axes.set_xlabel(solution.described.label(i))
    axes.set_ylabel(solution.described.rate_label(j))
    axes.legend(handles=handles, bbox_to_anchor=(0.5, -0.08), ncols=3, **(BELOW | {"fontsize": 9}))


def some_of(n: int) -> np.ndarray:
    """All of n numbers, or eight that are equally spaced."""
    return np.unique(np.linspace(0, n - 1, min(n, MAX_NAMES)).astype(int))


def show_no_rounding(axes: Any) -> None:
    """Widen an axis whose curves are constant to rounding, which would fill it otherwise."""
    low, high = axes.get_ylim()
    size = max(abs(low), abs(high))
    if high - low < FLAT * size:
        axes.set_ylim(min(0.0, 1.2 * low), max(0.0, 1.2 * high))


def extent(values: np.ndarray) -> tuple[float, float]:
    """The range of the values with a margin on both sides."""
    low, high = float(values.min()), float(values.max())
    margin = PHASE_PLANE_MARGIN * (high - low) or 1.0
    return low - margin, high + margin


def thinning(solution: Solution) -> np.ndarray:
    """Indices of the records that are drawn."""
    n = len(solution.t)
    return np.unique(np.linspace(0, n - 1, min(n, MOST_DRAWN)).astype(int))


def is_geometric(values: np.ndarray) -> bool:
    """Whether equal ratios, and not equal steps, lie between the values."""
    if values.dtype.kind not in "fi" or len(values) < 3 or not (values > 0).all():
        return False
    return bool(np.ptp(np.diff(np.log(values))) < 1e-6 < np.ptp(np.diff(values)) / np.abs(values).max())
