"""Figures of one state: the line that meets a corner where one contact decides, the friction cones of all elsewhere.

    |la_F| <= mu la_N        a set of forces that fits the state is one point (la_F, la_N) in the cone of each contact

With friction in two directions the abscissa is the size of la_T. Matplotlib is imported inside the functions.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from nonsmooth.drawing.colours import BLACK, GREY, PALE, cycled
from nonsmooth.drawing.labels import LETTER, columns_for
from nonsmooth.drawing.paradox_plots import plot_graphical_problem, why_no_line
from nonsmooth.drawing.plots import WIDTH, new_figure, save_figure

if TYPE_CHECKING:
    from nonsmooth.paradox.classify import Classification
    from nonsmooth.paradox.in_space import SpatialClassification

MOST_CONES = 6  # chosen: contacts of a figure, those that may carry most
MOST_COLOURED = 8  # chosen: solutions with a colour and an entry in the legend, one of each colour
# chosen: points, of the first solution: each is smaller than the one before, so that both are seen
LARGEST_MARKER = 12
ROOM_IN_CONE = 1.25  # chosen: of the largest force
LEAST_CONE_WIDTH = 0.25  # chosen: a cone, or a force, is given at least this part of the height as half a width


class Forces(NamedTuple):
    """What is drawn of one closed contact."""

    contact: int
    name: str
    mu: float
    is_bilateral: bool
    is_sized: bool  # the abscissa is a size, as in space
    friction: np.ndarray  # of each solution [N]
    normal: np.ndarray


def plot_classification(c: Classification, path: str | Path | None = None, title: str = "") -> Any:
    """Draw a state as a line and a corner where one contact decides, or as forces in the cones of all its contacts."""
    closed = [i for i, mode in enumerate(c.mode) if mode != "open"]
    if len(closed) == 1 and not why_no_line(c, closed[0]):
        return plot_graphical_problem([(title, c)], path, closed[0])
    rows = [
        Forces(i, c.contacts[i], float(c.mu[i]), bool(c.is_bilateral[i]), False,
               np.array([s.la_F[i] for s in c.solutions]), np.array([s.la_N[i] for s in c.solutions]))
        for i in closed
    ]  # fmt: skip
    return draw_cones(c, rows, path, title)


def plot_spatial_classification(c: SpatialClassification, path: str | Path | None = None, title: str = "") -> Any:
    """Draw the forces that are known of a state with friction in two directions, in the cones of its contacts."""
    rows = [
        Forces(i, c.contacts[i], float(c.mu[i]), False, True,
               np.array([np.hypot(*s.la[i, 1:]) for s in c.solutions]), np.array([s.la[i, 0] for s in c.solutions]))
        for i, mode in enumerate(c.mode) if mode != "open"
    ]  # fmt: skip
    return draw_cones(c, rows, path, title)


def draw_cones(c: Any, rows: list[Forces], path: str | Path | None, title: str) -> Any:
    """A panel for each closed contact: its cone, and the force of each solution."""
    shown = sorted(sorted(rows, key=lambda row: -np.abs(row.normal).max(initial=0.0))[:MOST_CONES], key=rows.index) \
        if len(rows) > MOST_CONES else rows  # fmt: skip
    columns = min(2 if len(shown) < 5 else 3, max(len(shown), 1))
    lines = -(-len(shown) // columns) if shown else 1
    figure = new_figure(WIDTH, 2.9 * lines + 1.1)
    grid = figure.subplots(lines, columns, squeeze=False).ravel()
    for axes, row in zip(grid, shown, strict=False):
        draw_cone(axes, row, [", ".join(s.modes[one.contact] for one in shown) for s in c.solutions])
    for axes in grid[len(shown) :]:
        axes.set_axis_off()
    if not shown:
        grid[0].text(0.5, 0.5, "no contact is closed: there is no force", ha="center", fontsize=LETTER)
    said = [title, f"{c.kind.name.lower().replace('_', ' ')}: {counted(c.n_solutions)}"]
    said += [f"{len(shown)} of {len(rows)} closed contacts, those that carry most"] if len(shown) < len(rows) else []
    said += ["some solutions may be missing"] if not c.is_complete else []
    said += ["these forces are one choice of many"] * any(not getattr(s, "is_unique_force", True) for s in c.solutions)
    figure.suptitle("\n".join(row for row in said if row), fontsize=LETTER + 1)
    keys = {label: handle for axes in grid for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)}
    figure.legend(
        keys.values(),
        keys,
        loc="outside lower center",
        ncols=columns_for(list(keys.values())),
        fontsize=LETTER,
        frameon=False,
    )
    return save_figure(figure, path)


def counted(n: int) -> str:
    """So many solutions, in words."""
    return "no forces fit" if n == 0 else "one set of forces" if n == 1 else f"{n} sets of forces"


def draw_cone(axes: Any, row: Forces, modes: list[str]) -> None:
    """One contact, and the modes of all that are drawn in each solution."""
    height = ROOM_IN_CONE * (np.abs(row.normal).max(initial=0.0) or np.abs(row.friction).max(initial=0.0) or 1.0)
    mu = row.mu if np.isfinite(row.mu) else 0.0
    wide = max(
        ROOM_IN_CONE * np.abs(row.friction).max(initial=0.0), ROOM_IN_CONE * mu * height, LEAST_CONE_WIDTH * height
    )
    low = -height if row.is_bilateral else -0.12 * height
    left = -0.08 * wide if row.is_sized else -wide
    for top in (height, low) if row.is_bilateral else (height,):
        first = 0.0 if row.is_sized else -mu * abs(top)
        axes.fill([0.0, first, mu * abs(top)], [0.0, top, top], facecolor=PALE, edgecolor=GREY, lw=1.2, alpha=0.45,
                  label="friction cone" if top == height else None)  # fmt: skip
    axes.axhline(0, color=GREY, lw=0.6)
    axes.axvline(0, color=GREY, lw=0.6)
    for k, (x, y, mode) in enumerate(zip(row.friction, row.normal, modes, strict=True)):
        colour, _, marker = cycled(k)
        is_named = k < MOST_COLOURED
        label = f"{k + 1}: {mode}" if is_named else f"{len(modes) - MOST_COLOURED} others"
        axes.plot(x, y, marker if is_named else ".", color=colour if is_named else BLACK, mfc="none", mew=1.6,
                  ms=LARGEST_MARKER - min(k, MOST_COLOURED), ls="", label=label, clip_on=False, zorder=5)  # fmt: skip
    axes.set_xlim(left, wide)
    axes.set_ylim(low, height)
    axes.set_title(f"{row.name}, " + (f"$\\mu = {mu:.3g}$" if mu else "no friction"), fontsize=LETTER + 1)
    axes.set_xlabel("$|\\lambda_T|$ [N]" if row.is_sized else "$\\lambda_F$ [N]")
    axes.set_ylabel("$\\lambda_N$ [N]")
    axes.locator_params(nbins=5)
    axes.grid(alpha=0.25)
