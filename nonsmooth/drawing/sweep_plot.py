"""Figures of sweeps: curves over one axis, maps over two. Cells without a result stay grey, and are counted."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.checks.arrays import as_instance, as_name
from nonsmooth.drawing.colours import BLUE, PALE, RED
from nonsmooth.drawing.labels import LETTER, parameter_label, spelt
from nonsmooth.drawing.plots import TITLE_LETTERS, WIDTH, broken, is_geometric, new_figure, save_figure, set_title
from nonsmooth.errors import InvalidInput
from nonsmooth.sweeps.task import OF_COORDINATE

if TYPE_CHECKING:
    import xarray

PANEL_HEIGHT = 2.6  # chosen [in]
MAX_PANELS = 6  # chosen: of one figure
MAX_LEVELS = 12  # chosen: whole numbers that are drawn as steps of colour
CODES = {"status", "message", "settled"}  # not results
OF_WINDOW = {"amplitude", "period", "amplitude_change", "period_change"}  # results that ask for a settled motion


def plot_sweep(found: xarray.Dataset, path: str | Path | None = None, name: str | None = None) -> Any:
    """Draw a result of a sweep over one or two axes.

    Parameters
    ----------
    found : xarray.Dataset
        What `sweep` gave.
    path : path-like, optional
        Where to save; the ending names the format.
    name : str, optional
        The result to draw; the first that is a number when left out.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InvalidInput
        For a sweep over a table or over more than two axes longer than one, a result that is a text, or none.
    MissingExtra
        When Matplotlib is not installed.
    """
    import xarray

    as_instance("found", found, xarray.Dataset, "the Dataset of a sweep")
    axes = drawn_axes(found)
    name = drawable(found, name)
    panels = panels_of(found, name, axes)
    figure = new_figure(WIDTH, PANEL_HEIGHT * len(panels) + 1.0)
    grid = figure.subplots(len(panels), 1, squeeze=False)[:, 0]
    open_ = unsettled(found, name, axes)
    for place, (label, values) in zip(grid, panels.items(), strict=False):
        draw = draw_map if len(axes) == 2 else draw_curve
        draw(figure, place, [found[axis] for axis in axes], values, label)
        if open_.any():
            mark = mark_map if len(axes) == 2 else mark_curve
            mark(place, [found[axis].values for axis in axes], values, open_)
        place.set_title(found[name].attrs.get("long_name", ""), fontsize=LETTER)
    values = next(iter(panels.values()))
    missing = int(np.isnan(values).sum())
    rows = what_was_run(found, axes)
    rows += [f"no result in {missing} of {values.size} cells (grey)"] if missing else []
    how = "hatched" if len(axes) == 2 else "rings"
    rows += [f"not settled in {int(open_.sum())} of {open_.size} cells ({how})"] if open_.any() else []
    set_title(figure, "\n".join(rows))
    return save_figure(figure, path)


def unsettled(found: xarray.Dataset, name: str, axes: list[str]) -> np.ndarray:
    """Which cells over the axes hold a result of a motion that has not settled: none of a result that does not ask."""
    whole = found.status.squeeze([dim for dim in found.status.dims if dim not in axes]).transpose(*axes)
    if "settled" not in found or name not in OF_WINDOW:
        return np.zeros(whole.shape, dtype=bool)
    column = found.settled.squeeze([dim for dim in found.settled.dims if dim not in axes])
    return np.asarray(column.transpose(*axes).values == 0.0)


def mark_curve(place: Any, axes: list[np.ndarray], values: np.ndarray, where: np.ndarray) -> None:
    """Rings around values of motions that have not settled."""
    place.plot(axes[0][where], values[where], "o", mfc="none", mec=RED, ms=7, mew=1)


def mark_map(place: Any, axes: list[np.ndarray], values: np.ndarray, where: np.ndarray) -> None:
    """Hatching over cells of motions that have not settled."""
    from matplotlib.colors import ListedColormap

    cells = np.ma.masked_where(~where.T, np.zeros(where.T.shape))
    place.pcolor(*axes, cells, shading="nearest", cmap=ListedColormap(["none"]), hatch="////", edgecolor=RED,
                 linewidth=0.0, zorder=2, gid="unsettled")  # fmt: skip


def what_was_run(found: xarray.Dataset, axes: list[str]) -> list[str]:
    """The system, and the parameters that were held fixed."""
    about = found.attrs
    values = str(about.get("parameters", "")).split("  ")
    fixed = [value.replace(" ", "\N{NO-BREAK SPACE}") for value in values if value.split(" = ")[0] not in axes]
    return [row for row in (str(about.get("system", "")), *broken("  ".join(fixed), TITLE_LETTERS)) if row]


def drawn_axes(found: xarray.Dataset) -> list[str]:
    """The one or two axes that are longer than one."""
    if "cell" in found.status.dims:
        raise InvalidInput("a figure needs one or two axes; this sweep ran over the rows of a table")
    longer = [str(dim) for dim in found.status.dims if found.sizes[dim] > 1]
    if not 1 <= len(longer) <= 2:
        raise InvalidInput(f"a figure needs one or two axes longer than one; this sweep has {longer or 'none'}")
    return longer


def drawable(found: xarray.Dataset, name: str | None) -> str:
    """The result to draw."""
    numbers = [str(key) for key, column in found.data_vars.items() if key not in CODES and column.dtype.kind in "fi"]
    if name is not None:
        as_name("result", name, [str(key) for key in found.data_vars])
    if not numbers or (name is not None and name not in numbers):
        what = f"{name} is a text" if name else "none of the results is a number"
        raise InvalidInput(f"{what}; a figure needs a number" + (f", as {' or '.join(numbers)} is" if numbers else ""))
    return name or numbers[0]


def panels_of(found: xarray.Dataset, name: str, axes: list[str]) -> dict[str, np.ndarray]:
    """Label with unit -> values over the axes, for each entry of the result."""
    column = found[name].squeeze([dim for dim in found.status.dims if dim not in axes])
    further = [str(dim) for dim in column.dims if dim not in axes]
    unit = column.attrs.get("units", "")
    panels = {}
    for place in np.ndindex(*(found.sizes[dim] for dim in further)):
        where = dict(zip(further, place, strict=True))
        entry = column.isel(where)
        labels = [spelt(str(entry[dim].values)) if dim in entry.coords else f"{dim} {k}" for dim, k in where.items()]
        own = str(entry.coords["coordinate_unit"].values) if "coordinate_unit" in entry.coords else ""
        of = f" of {', '.join(labels)}" if labels and max(found.sizes[dim] for dim in further) > 1 else ""
        panels[f"{name}{of} [{unit.replace(OF_COORDINATE, own) or '-'}]"] = entry.transpose(*axes).values
        if len(panels) == MAX_PANELS:
            break
    return panels


def with_unit(axis: xarray.DataArray) -> str:
    """The axis as a label."""
    return parameter_label(str(axis.name), unit=axis.attrs.get("units", ""))


def draw_curve(figure: Any, place: Any, axes: list[xarray.DataArray], values: np.ndarray, label: str) -> None:
    """Values over one axis; grey where there are none."""
    x = axes[0].values
    place.plot(x, values, marker="." if len(x) <= 100 else None, color=BLUE, linewidth=1)
    for missing in x[np.isnan(values)] if x.dtype.kind in "fi" else ():
        place.axvline(missing, color=PALE, linewidth=1, zorder=0)
    if is_geometric(x):
        place.set_xscale("log")
    place.set(xlabel=with_unit(axes[0]), ylabel=label)
    place.grid(alpha=0.3)


def draw_map(figure: Any, place: Any, axes: list[xarray.DataArray], values: np.ndarray, label: str) -> None:
    """Values over two axes; whole numbers as steps of colour."""
    from matplotlib import colormaps
    from matplotlib.colors import BoundaryNorm

    x, y = axes[0].values, axes[1].values
    levels = np.unique(values[np.isfinite(values)])
    options: dict[str, Any] = {}
    is_counted = 0 < len(levels) and (levels == levels.round()).all() and np.ptp(levels) < MAX_LEVELS
    colours = colormaps["cividis"].copy()
    if is_counted:
        whole = np.arange(levels[0], levels[-1] + 2)
        options["norm"] = BoundaryNorm(whole - 0.5, colours.N)
    place.set_facecolor(PALE)
    mesh = place.pcolormesh(
        x, y, np.ma.masked_invalid(values.T), cmap=colours, shading="nearest", rasterized=True, **options
    )
    bar = figure.colorbar(mesh, ax=place, label=label)
    if is_counted:
        bar.set_ticks(whole[:-1], labels=[f"{level:g}" for level in whole[:-1]])
    for axis, set_scale in ((x, place.set_xscale), (y, place.set_yscale)):
        if is_geometric(axis):
            set_scale("log")
    place.set(xlabel=with_unit(axes[0]), ylabel=with_unit(axes[1]))
