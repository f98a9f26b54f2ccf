"""Figures of convergence studies: errors with slope triangles, errors over cost, orders, and what the contact did.

Matplotlib is imported inside the functions.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.drawing.colours import CYCLE, GREY, MARKERS, STYLES, WASHED
from nonsmooth.drawing.labels import legend_above, with_spelt_names
from nonsmooth.drawing.plots import TITLE_LETTERS, WIDTH, broken, new_figure, save_figure, set_title

if TYPE_CHECKING:
    from nonsmooth.studies.study import Study

NAMES = {  # label, colour
    "error_q": ("coordinates", CYCLE[0]),
    "error_u": ("velocities", CYCLE[1]),
    "error_gamma_N": ("$\\gamma_N$ after the impact", CYCLE[2]),
}
EVENT_NAMES = {
    "error_event_t": ("time of the event [s]", CYCLE[2]),
    "error_after_q": ("coordinates", CYCLE[0]),
    "error_after_u": ("velocities", CYCLE[1]),
}
SYMBOLS = {"stiffness": "k", "dt": "\\Delta t", "rtol": "\\mathrm{rtol}"}
SLOPES = {  # and places of the triangles
    "stiffness": ((-0.5, 0.06), (-1.0, 0.32)), "dt": ((1.0, 0.45), (2.0, 0.73)), "rtol": ((1.0, 0.45),),
}  # fmt: skip
X_LABELS = {"stiffness": "stiffness $k$ [N/m]", "dt": "step $\\Delta t$ [s]", "rtol": "relative tolerance [-]"}
MOST_TICKS = 6  # chosen: numbers under an axis of values that were run
FAR_BELOW = 1e-2  # chosen: of the least error that was measured: lower marks would take the space of the others


def plot_study(study: Study, path: str | Path | None = None) -> Any:
    """Draw a study: errors with the slopes of the orders, what the contact did over its stiffness, errors after events,
    and the cost beside that of rigid contact.

    Parameters
    ----------
    study : Study
    path : path-like, optional
        Where to save; the ending names the format.

    Returns
    -------
    matplotlib.figure.Figure
    """
    panels = [draw_errors]
    panels += [draw_contact] if has_contact(study) else []
    panels += [draw_after] if "event_mode" in study.data.coords else []
    panels += [draw_cost] if "beside_wall_time" in study.data else []
    figure = new_figure(WIDTH, 0.4 + 3.0 * len(panels))
    about = study.data.attrs
    held = with_spelt_names(str(about.get("parameters", ""))).replace(" = ", "\N{NO-BREAK SPACE}=\N{NO-BREAK SPACE}")
    lines = [study.title, held, with_spelt_names(str(about.get("restitution", "")))]
    set_title(figure, "\n".join(part for line in lines for part in broken(line, TITLE_LETTERS)))
    for panel, place in zip(panels, figure.subplots(len(panels), 1, squeeze=False)[:, 0], strict=True):
        panel(place, study)
        if panel is not draw_cost:
            show_values(place, study.x)
    return save_figure(figure, path)


def has_contact(study: Study) -> bool:
    """Whether it is known what the contact did, over the stiffness."""
    known = [name for name in ("restitution", "peak_force", "penetration") if name in study.data]
    return study.of == "stiffness" and any(np.isfinite(study.data[name].values).any() for name in known)


def units_of(study: Study) -> str:
    """Those of the coordinates; of the velocities; where nobody named them they may be any."""
    of_q, of_u = (study.data[name].attrs.get("units", "") for name in ("error_q", "error_u"))
    return f"{of_q}; {of_u}" if of_q and of_u else "units of the coordinates; of their rates"


def draw_errors(axes: Any, study: Study) -> None:
    """Errors at the first and the last time."""
    t = study.data.time.values
    draw_kinds(axes, study, NAMES, {j: f", $t={t[j]:.3g}$ s" for j in sorted({0, len(t) - 1})})
    axes.set(xlabel=X_LABELS[study.of], ylabel=f"distance to the reference\n[{units_of(study)}]")


def draw_after(axes: Any, study: Study) -> None:
    """Errors of the first and the last of the matched events, and after them."""
    events = study.data.event_mode.values
    chosen = sorted({0, len(events) - 1})
    labels = {j: f', "{events[j]}" at {float(study.data.event_time[j]):.3g} s' for j in chosen}
    draw_kinds(axes, study, EVENT_NAMES, labels)
    axes.set(xlabel=X_LABELS[study.of], ylabel=f"after matched events\n[s; {units_of(study)}]")


def draw_kinds(axes: Any, study: Study, names: dict[str, tuple[str, str]], rows: dict[int, str]) -> None:
    """Errors at some times or events, and triangles of the slopes that occur. Those below the floor are crosses, which
    say no more than that: none is drawn far below the others."""
    is_hidden = False
    known = [np.zeros(0)]
    measured = [study.errors(name, j) for name in kinds(study, names) for j in rows if study.data[name].ndim > 1]
    least = FAR_BELOW * min((float(np.nanmin(x)) for x in measured if np.isfinite(x).any()), default=0.0)
    for k, (name, (label, colour)) in enumerate(kinds(study, names).items()):
        has_rows = study.data[name].ndim > 1
        for style, (j, at) in enumerate(rows.items() if has_rows else [(-1, "")]):
            errors = study.errors(name, j)
            known.append(errors)
            if np.isfinite(errors).any():
                axes.loglog(
                    study.x, errors, MARKERS[style % len(MARKERS)], color=colour, ls=STYLES[k], ms=4.5, lw=1,
                    label=label + at, mfc="white" if style else colour,
                )  # fmt: skip
            if has_rows:
                hidden = np.where(np.isfinite(errors), np.nan, study.data[name].values[:, j])
                hidden[hidden <= 0] = np.nan  # no error at all has no place on the axis
                is_hidden |= bool(np.isfinite(hidden).any())
                axes.loglog(study.x, np.maximum(hidden, least), "x", color=colour, ms=5, alpha=0.5)
    if is_hidden:
        axes.plot([], [], "x", color=GREY, label="below the floor of the reference")
    for slope, place in SLOPES[study.of]:
        slope_triangle(axes, study.x, np.concatenate(known), slope, place)
    legend_above(axes)
    axes.grid(True, which="major", color=WASHED)


def show_values(axes: Any, x: np.ndarray) -> None:
    """Ticks at some of the values that were run: of less than a decade Matplotlib's stand on one another."""
    from matplotlib.ticker import NullFormatter, NullLocator

    shown = x[:: -(-len(x) // MOST_TICKS)]
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xticks(shown, [tick_of(value) for value in shown])


def show_times(axes: Any) -> None:
    """Ticks at the powers of ten of the horizontal axis; of less than two decades at 1, 2 and 5 of each."""
    low, high = np.log10(axes.get_xlim())
    powers = 10.0 ** np.arange(np.floor(low), np.ceil(high) + 1.0)
    steps = powers if high - low > 2.0 else np.outer(powers, (1.0, 2.0, 5.0)).ravel()
    if len(shown := steps[(steps >= 10.0**low) & (steps <= 10.0**high)]):
        show_values(axes, shown)


def tick_of(value: float) -> str:
    """A number under an axis: a power of ten as such, a large or a small one with its power."""
    if 1e-4 < value < 1e4:
        return f"{value:.3g}"
    power = int(np.floor(np.log10(value) + 1e-12))
    lead = f"{value / 10.0**power:.3g}"
    return f"$10^{{{power}}}$" if lead == "1" else f"${lead}\\cdot10^{{{power}}}$"


def slope_triangle(axes: Any, x: np.ndarray, values: np.ndarray, slope: float, place: float) -> None:
    """A triangle of about a decade below the errors; its corner stands at a part of the width."""
    values = values[np.isfinite(values) & (values > 0)]
    if len(values) == 0:
        return
    left, right = np.log10(x.min()), np.log10(x.max())
    width = min(1.0, 0.22 * (right - left))
    x_0 = left + place * (right - left)
    top = np.log10(values.min()) + (0.0 if slope < 0 else 1.2 * abs(slope) * width)
    x = 10.0 ** np.array([x_0, x_0 + width, x_0 + width if slope > 0 else x_0, x_0])
    if slope > 0:
        y = 10.0 ** (top - slope * width * np.array([1.0, 0.0, 1.0, 1.0]))
    else:
        y = 10.0 ** (top + slope * width * np.array([0.0, 1.0, 1.0, 0.0]))
    axes.plot(x, y, color=GREY, lw=1)
    axes.annotate(
        f"{abs(slope):g}", (x[2], np.sqrt(y[0] * y[1])), xytext=(4 if slope > 0 else -4, 0),
        textcoords="offset points", ha="left" if slope > 0 else "right", va="center", fontsize=8, color=GREY,
    )  # fmt: skip


def draw_cost(axes: Any, study: Study) -> None:
    """Errors at the last time that stand above the floor over the wall time, the rigid runs beside."""
    wall = 1e3 * study.data.wall_time.values
    for k, (name, (label, colour)) in enumerate(kinds(study, NAMES).items()):
        if not has_times(study, name):
            continue
        errors = study.errors(name)
        axes.loglog(wall, errors, MARKERS[k] + "-", color=colour, ms=4.5, lw=1, label=label)
        if f"beside_{name}" in study.data:
            rigid = 1e3 * study.data.beside_wall_time.values
            beside = study.data[f"beside_{name}"].values
            axes.loglog(
                rigid, np.where(beside > 0, beside, np.nan), MARKERS[k] + "--", color=colour, mfc="white", ms=4.5, lw=1,
                label=f"{label}, rigid contact",
            )  # fmt: skip
        known = np.flatnonzero(np.isfinite(errors))
        if name == "error_u" and len(known):
            for i in {int(known[0]), int(known[-1])}:
                value = tick_of(study.x[i]).strip("$")
                axes.annotate(
                    f"${SYMBOLS[study.of]}={value}$", (wall[i], errors[i]),
                    xytext=(6, 5) if i == known[0] else (4, -13), textcoords="offset points", fontsize=8,
                    ha="left" if i == known[0] else "right",
                    bbox={"fc": "white", "ec": "none", "alpha": 0.85, "pad": 0.5},
                )  # fmt: skip
    axes.margins(x=0.14, y=0.1)
    show_times(axes)
    at = study.data.time.values[-1]
    axes.set(xlabel="wall time [ms]", ylabel=f"distance at $t={at:.3g}$ s\n[{units_of(study)}]")
    legend_above(axes)
    axes.grid(True, which="major", color=WASHED)


def draw_contact(axes: Any, study: Study) -> None:
    """Effective restitution where the contact opens, else peak force and time to the end of slip."""
    data = study.data
    if "restitution" in data and np.isfinite(data.restitution.values).any():
        draw_restitution(axes, study)
        return
    if "penetration" in data:
        draw_positive(axes, study.x, data.penetration.values, "o-", CYCLE[0])
        axes.set(xlabel=X_LABELS["stiffness"], ylabel="deepest penetration [m]", xscale="log")
        return
    draw_positive(axes, study.x, np.abs(data.peak_force.values), "o-", CYCLE[0])
    axes.set(xlabel=X_LABELS["stiffness"])
    axes.set_ylabel("peak normal force [N]", color=CYCLE[0])
    if np.isfinite(data.stop_time.values).any():
        right = axes.twinx()
        draw_positive(right, study.x, data.stop_time.values, "s-", CYCLE[1])
        right.set_ylabel("end of the slip [s]", color=CYCLE[1])


def draw_restitution(axes: Any, study: Study) -> None:
    """What the springs give back, as it was and by the closed form, and what the rigid contact does."""
    data = study.data
    axes.semilogx(study.x, data.restitution.values, "o", color=CYCLE[0], ms=4.5, label="springs, energetic")
    if "e_springs" in data:
        axes.semilogx(study.x, data.e_springs.values, "-", color=CYCLE[0], lw=1, label="springs, closed form")
        axes.axhline(data.attrs["e_N"], color=CYCLE[1], ls="--", lw=1, label="rigid contact, $e_N$")
    axes.set(xlabel=X_LABELS["stiffness"], ylabel="restitution $e$ [-]", ylim=(-0.05, 1.1))
    legend_above(axes)


def draw_positive(axes: Any, x: np.ndarray, y: np.ndarray, style: str, colour: str) -> None:
    """A curve on a logarithmic scale where it spans decades, on a linear one otherwise."""
    axes.semilogx(x, y, style, color=colour, mfc="white" if style == "s-" else colour, ms=4.5, lw=1)
    known = y[np.isfinite(y) & (y > 0)]
    if len(known) and known.max() > 10 * known.min():
        axes.set_yscale("log")
    else:
        axes.set_ylim(0.0, 1.15 * known.max() if len(known) else None)


def kinds(study: Study, names: dict[str, tuple[str, str]]) -> dict[str, tuple[str, str]]:
    """Those of some kinds of error that the study has."""
    return {name: entry for name, entry in names.items() if name in study.data}


def has_times(study: Study, name: str) -> bool:
    """Whether an error is measured at times."""
    return "time" in study.data[name].dims
