"""The commands ``nonsmooth classify`` and ``nonsmooth map``."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nonsmooth.checks.files import FIGURE_ENDINGS
from nonsmooth.commands.outputs import (
    add_drawn,
    add_printed,
    add_progress,
    add_resumed,
    add_saved,
    add_workers,
    attrs_as_json,
    dataset_as_json,
    progress_of,
    save_json,
    tell,
    tell_file,
    units_of_state,
)
from nonsmooth.commands.terminal import complain, require_one
from nonsmooth.commands.typed_input import (
    assignments,
    initial_state,
    number,
    read_axis,
    require_module,
    require_writable,
)
from nonsmooth.commands.typed_model import MODEL, require_units, typed_model
from nonsmooth.errors import INTERRUPTED, InvalidInput

if TYPE_CHECKING:
    from nonsmooth.sweeps.axes import Axis

JSON_ENDINGS = (".json",)
UNITS = {  # of what `classify --json` prints, without those of coordinates; a and k are per contact, b of the one slide
    "gamma_N": "m/s", "gamma_F": "m/s", "la_N": "N", "la_F": "N", "dgamma_N": "m/s^2", "dgamma_F": "m/s^2",
    "p": "1/kg", "b": "m/s^2",
}  # fmt: skip
MAP_AXIS = "NAME=LOW:HIGH[:COUNT][:log][:UNIT] or NAME=V,V,...[:UNIT]"
MAP_POINTS = 400  # chosen: along each axis of a map that was given by its ends
CURVE_POINTS = 80  # chosen: of the coarser grid that boundary curves are sought on


def add_classify(command: argparse.ArgumentParser) -> None:
    """The options of ``nonsmooth classify``."""
    command.set_defaults(act=act_classify)
    add_model(command)
    command.add_argument("--q", "--q0", dest="q0", nargs="+", type=number, metavar="Q", help="coordinates (with --u)")
    command.add_argument("--u", "--u0", dest="u0", nargs="+", type=number, metavar="U", help="velocities (with --q)")
    command.add_argument("--t", type=number, default=0.0, metavar="T", help="time [s]; 0 by default")
    command.add_argument(
        "--restitution", type=number, metavar="E", help="of the impacts listed; the model's by default"
    )
    add_drawn(
        command, "draw gamma_N' against la_N of one contact, or the forces in the cones of several; nothing by default"
    )
    add_saved(command, "save what --json prints (.json)")
    add_printed(command)


def add_map(command: argparse.ArgumentParser) -> None:
    """The options of ``nonsmooth map``."""
    command.set_defaults(act=act_map, suffix="-map")
    add_model(command)
    command.add_argument(
        "--axis", nargs="+", action="extend", default=[], metavar="AXIS",
        help=f"{MAP_AXIS}: {MAP_POINTS} values of a variable of the state or a parameter by default; at most two axes "
        "are drawn; the model's own axes by default",
    )  # fmt: skip
    add_saved(command, "where to save, .nc or .npz; MODEL-map.nc by default")
    add_drawn(command, "where to draw; MODEL-map.png by default")
    add_workers(command, "threads; one a processor by default", None)
    add_resumed(command)
    add_progress(command)
    add_printed(command)


def add_model(command: argparse.ArgumentParser) -> None:
    """The model and what is changed in it."""
    command.add_argument("model", metavar="MODEL", help=MODEL)
    for option, what in (("--set", "parameters, e.g. mu=2 l=1/2"), ("--state", "state, e.g. th=pi/4 thdot=0")):
        command.add_argument(option, nargs="+", action="extend", default=[], metavar="NAME=VALUE", help=what)


def act_classify(arguments: argparse.Namespace) -> int:
    """``nonsmooth classify``."""
    model = typed_model(arguments)
    require_one(arguments)
    require_writable(arguments.out, JSON_ENDINGS)
    require_writable(arguments.plot, FIGURE_ENDINGS)
    if arguments.plot:
        require_module("matplotlib", "plot", "figures")
    q, u = initial_state(model, arguments)
    from nonsmooth.paradox.classify import classify

    classification = classify(model, arguments.t, q, u, restitution=arguments.restitution)

    def results() -> dict[str, Any]:
        return classification.to_dict() | {"units": units_of_state(model) | UNITS}

    save_json(arguments.out, results)
    tell(arguments, lambda: classification, results)
    tell_file(arguments, "result", arguments.out)
    if arguments.plot:
        classification.plot(arguments.plot, f"{arguments.model}: {classification.kind.name.lower()}")
        tell_file(arguments, "figure", arguments.plot)
    return 0


def act_map(arguments: argparse.Namespace) -> int:
    """``nonsmooth map``."""
    from nonsmooth.sweeps.maps import MAP_ENDINGS, save_map

    model = typed_model(arguments)
    require_one(arguments)
    unasked = None if arguments.json else Path(f"{arguments.model}-map.nc")
    out = arguments.out or unasked
    figure = None if arguments.no_plot else arguments.plot or (unasked and unasked.with_suffix(".png"))
    require_writable(out, MAP_ENDINGS)
    require_writable(figure, FIGURE_ENDINGS)
    require_module("xarray", "map", "maps")
    if figure:
        require_module("matplotlib", "map", "maps")
    typed = [typed_axis(text) for text in arguments.axis]
    axes = {axis.name: axis.values for axis in typed} or own_axes(model, arguments.model)
    if len(axes) < len(arguments.axis):
        raise InvalidInput("--axis gives a name twice; give it once")
    require_units(model, typed)
    fixed: dict[str, Any] = dict(assignments("--state", arguments.state))
    for name in fixed.keys() & axes.keys():
        raise InvalidInput(f"{name} is an axis of the map and fixed by --state; give it once")
    from nonsmooth.studies.paradox_map import paradox_map

    chart = paradox_map(
        model, workers=arguments.workers, progress=progress_of(arguments), journal=arguments.journal, **axes, **fixed
    )
    for axis in typed:
        chart[axis.name].attrs |= {"units": axis.unit} if axis.unit else {}
    if out:
        save_map(chart, out)
    tell(arguments, lambda: summary(chart), lambda: map_as_json(chart))
    tell_file(arguments, "map", out)
    if chart.attrs["interrupted"]:
        complain(f"interrupted: the states that were not reached are marked{f' in {out}' if out else ''}; nothing is "
                 "drawn")  # fmt: skip
        return INTERRUPTED
    if figure and draw(model, chart, axes, fixed, figure):
        tell_file(arguments, "figure", figure)
    return 0


def map_as_json(chart: Any) -> dict[str, Any]:
    """Every result over the axes, what codes mean, and what was held fixed."""
    import numpy as np

    from nonsmooth.paradox.classify import ParadoxKind

    kinds, counts = np.unique(chart.kind.values, return_counts=True)
    named = {ParadoxKind(int(kind)).name: int(n) for kind, n in zip(kinds, counts, strict=True)}
    codes = {name: codes_of(column.attrs) for name, column in chart.data_vars.items() if "flag_values" in column.attrs}
    return {"about": attrs_as_json(chart.attrs), "kinds": named, "codes": codes, **dataset_as_json(chart)}


def codes_of(attrs: Any) -> dict[str, int]:
    """What the codes of a result mean."""
    return dict(zip(attrs["flag_meanings"].split(), attrs["flag_values"].tolist(), strict=True))


def draw(model: Any, chart: Any, axes: dict[str, Any], fixed: dict[str, Any], figure: Path) -> bool:
    """Draw a map of one or two axes, with its boundary curves; False for more."""
    import numpy as np

    from nonsmooth.drawing.paradox_plots import plot_map
    from nonsmooth.paradox.boundaries import paradox_boundaries

    if len(axes) > 2:
        return False
    boundaries = None
    is_increasing = all(len(values) > 1 and (np.diff(values) > 0).all() for values in axes.values())
    if len(axes) == 2 and is_increasing and chart.p.ndim == 2:
        coarse = {name: np.interp(np.linspace(0, 1, CURVE_POINTS), np.linspace(0, 1, len(values)), values)
                  for name, values in axes.items()}  # fmt: skip
        boundaries = paradox_boundaries(model, **coarse, **fixed)
    plot_map(chart, figure, boundaries=boundaries)
    return True


def summary(chart: Any) -> str:
    """How many states there are of each kind."""
    import numpy as np

    from nonsmooth.paradox.kinds import ParadoxKind

    kinds, counts = np.unique(chart.kind.values, return_counts=True)
    shape = " x ".join(f"{name} ({length})" for name, length in zip(chart.kind.dims, chart.kind.shape, strict=True))
    lines = [f"{chart.attrs['system'] or 'map'}: {chart.kind.size} states, {shape}"]
    lines += [
        f"  {ParadoxKind(int(kind)).name.lower():14} {count:9d}  {count / chart.kind.size:7.2%}"
        for kind, count in zip(kinds, counts, strict=True)
    ]
    if kinds.tolist() == [ParadoxKind.INADMISSIBLE]:
        lines.append("  every state penetrates, or lands: give coordinates and rates of a contact by --state, or the "
                     "model a state(...) that touches")  # fmt: skip
    return "\n".join(lines)


def own_axes(model: Any, name: str) -> dict[str, Any]:
    """The axes that a model proposes for its map."""
    import numpy as np

    from nonsmooth.mechanics.start import describing

    proposed = getattr(describing(model), "map_axes", None)
    if proposed is None:
        raise InvalidInput(f"the model {name} has no map of its own; give axes, as in --axis th=0:pi/2 --axis mu=0:3")
    return {axis: np.linspace(low, high, MAP_POINTS) for axis, low, high in proposed}


def typed_axis(text: str) -> Axis:
    """An axis of a map as it is typed: that of a sweep, whose count may be left out."""
    axis = read_axis(text, MAP_AXIS, MAP_POINTS)
    if ":" in text and "," not in text and len(axis.values) > 1 and axis.values[0] > axis.values[-1]:
        raise InvalidInput(f"--axis {axis.name} needs LOW < HIGH; got {text!r}")
    return axis
