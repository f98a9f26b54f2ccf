"""Runs as labelled data: datasets of xarray and tables of pandas, with names and units, and netCDF files of them.

A dataset of a scene has the dimensions t, body, axis (x, y, z) and component (w, x, y, z of a unit quaternion); its
contacts are as many as there are in each record, one behind the other along ``contact``: those of record k are
contact_offset[k] to contact_offset[k + 1] - 1. Of a System the dimensions are t, coordinate, velocity, contact,
direction and event.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.checks.arrays import as_name
from nonsmooth.checks.files import whole_file
from nonsmooth.errors import MissingExtra
from nonsmooth.integrators.records import EVENT_KIND
from nonsmooth.mechanics.system import ContactMode
from nonsmooth.results.events import EventKind, SceneEventKind
from nonsmooth.results.forms import WHOLE
from nonsmooth.results.ledger import ELASTIC, ENERGIES
from nonsmooth.results.netcdf import NETCDF_KIND
from nonsmooth.results.recorded import CONTACTS, EVENTS, KINDS, LEDGER, PAIRS
from nonsmooth.results.scene_contacts import ContactColumns, modes_of, normal_and_friction
from nonsmooth.results.seal import seal
from nonsmooth.results.table import EVENT, SCENE, SYSTEM, Column, columns_along, record_of, word_of

if TYPE_CHECKING:
    import pandas
    import xarray

    from nonsmooth.results.scene_solution import SceneSolution
    from nonsmooth.results.solution import Solution

SYSTEM_TABLES, SCENE_TABLES = ("records", "events"), ("bodies", "contacts", "records", "events", "pairs")
AXES = ("x", "y", "z")
# the dimension of each symbol of a shape
DIMENSIONS = {
    "n_t": "t", "n_q": "coordinate", "n_u": "velocity", "n_c": "contact", "d": "direction", "n_events": "event",
    "found *": "found_*", "n_b": "body", "n_j": "joint", "m": "contact", "n_t + 1": "edge", "n_e": "event",
    "n_p": "pair", 2: "axis", 3: "axis", 4: "component",
}  # fmt: skip
COMPONENTS = {2: AXES[:2], 3: AXES, 4: ("w", *AXES)}
# how a data set calls what does not follow from its name in files: contacts/gap is contact_gap
LABELS = {"contacts/offsets": "contact_offset", "joint_impulses": "joint_P", "joint_torques": "joint_torque"}
UNLABELLED = ("centres", "paradox_rows")  # chosen: arrays of files that a data set leaves out
FIRST = ("t", "record", "i", "j", "gap", "P_N", "P_F", "mu", "mode")  # chosen: columns of a table of contacts
BY_NAME = {column.name: column for column in SYSTEM}
Variable = tuple[tuple[str, ...], Any, dict[str, Any]]


def require_data(module: str) -> Any:
    """xarray or pandas, or `MissingExtra`."""
    import importlib

    try:
        return importlib.import_module(module)
    except ImportError:
        raise MissingExtra(f'labelled data need {module}; pip install "nonsmooth[data]" brings it') from None


def column(dims: str, values: Any, units: str, meaning: str) -> Variable:
    """A variable of a dataset; its dimensions by spaces."""
    return tuple(dims.split()), np.asarray(values), {"units": units, "long_name": meaning}


def variable(column: Column, values: Any, word: str = "") -> Variable:
    """A column of a table as a variable of a dataset; ``word`` stands where its name has a ``*``."""
    dims = tuple(DIMENSIONS[size].replace("*", word) for size in column.shape)  # type: ignore[index]
    told = {"units": column.unit, "long_name": column.meaning.replace("*", word)}
    return dims, np.asarray(values), told


def with_flags(variable: Variable) -> Variable:
    """A variable of modes, with what its numbers mean, as the CF conventions tell flags."""
    flags = {
        "flag_values": np.array([int(mode) for mode in ContactMode]),
        "flag_meanings": " ".join(mode.name.lower() for mode in ContactMode),
    }
    return variable[0], variable[1], variable[2] | flags


def about_of(solution: Solution | SceneSolution) -> dict[str, str]:
    """How a run ended, and what was run, as attributes of a dataset."""
    return {"status": solution.status.name, "message": solution.message} | {
        name: str(value) for name, value in solution.about.items()
    }


def ledger_of(solution: Solution | SceneSolution) -> dict[str, Variable]:
    """Energies and works."""
    energies = (*ENERGIES, ELASTIC)
    return {
        name: column("t", values, "J", f"{name} energy" if name in energies else f"work since the start by {name}")
        for name, values in solution.ledger.items()
    }


# of velocities that have the names of coordinates
COORDINATE_OF_RATE = "coordinate whose rate it is"


def system_dataset(solution: Solution) -> xarray.Dataset:
    """A run of a `System` as an ``xarray.Dataset``."""
    xarray = require_data("xarray")
    found = {each.name: (each, values) for each, values in recorded_of(solution)}
    _, la = found.pop("la", (None, None))
    data = {name: variable(*of_name) for name, of_name in found.items()}
    data |= {"mode": with_flags(data["mode"])} if "mode" in data else {}
    data |= ledger_of(solution) if LEDGER in solution.recorded else {}
    if la is not None:
        data["la_N"] = column("t contact", la[:, :, 0], "N", "normal forces")
        data["la_F"] = column("t contact direction", la[:, :, 1:], "N", "friction forces")
    for name in {"q", "u"} & data.keys():
        data[name][2]["units"] = unit_of_all(solution, name)
    if EVENTS in solution.recorded:
        data |= {f"event_{each.name}": variable(each, solution.event_rows[:, k]) for k, each in enumerate(EVENT)}
    for k in range(len(solution.t_events)):
        data |= {
            f"{name}_{k}": variable(BY_NAME[f"{name}/*"], getattr(solution, name)[k], str(k))
            for name in ("t_events", "q_events", "u_events")
        }
    coordinates: dict[str, Any] = {"t": data.pop("t")} | names_of_coordinates(solution)
    return xarray.Dataset(data, coordinates, about_of(solution))


def recorded_of(solution: Solution) -> list[tuple[Column, np.ndarray]]:
    """The columns of the records that a run has."""
    own = solution.__getstate__()
    return [(each, own[each.name]) for each in columns_along(SYSTEM, "n_t", KINDS) if own[each.name] is not None]


def names_of_coordinates(solution: Solution) -> dict[str, Any]:
    """Names of the contacts, and names and units of the coordinates where the model has them."""
    contacts = np.array(solution.described.contacts, dtype=object)
    found: dict[str, Any] = {"contact": ("contact", contacts)} if len(contacts) else {}
    if not solution.described.has_names:
        return found
    names, units = (np.array(column, dtype=object) for column in zip(*solution.described.coordinates, strict=True))
    rates = np.array([unit for _, unit in solution.described.rates], dtype=object)
    own = np.array([name for name, _ in solution.described.velocities], dtype=object)
    return found | {
        "coordinate": ("coordinate", names),
        "coordinate_units": ("coordinate", units),
        "velocity": ("velocity", own) if len(own) else ("velocity", names.copy(), {"long_name": COORDINATE_OF_RATE}),
        "velocity_units": ("velocity", rates),
    }


def unit_of_all(solution: Solution, name: str) -> str:
    """The unit of every coordinate, or of every velocity; nothing where they differ."""
    pairs = solution.described.coordinates if name == "q" else solution.described.rates
    units = {unit for _, unit in pairs}
    return units.pop() if len(units) == 1 else ""


def system_table(solution: Solution, what: str = "records") -> pandas.DataFrame:
    """A run of a `System` as a table: a row a record, or a row an event; ``attrs["units"]`` has the units of columns.

    Columns have the names of coordinates, velocities and contacts where the model has them: x, xdot, g_N[tip]; where it
    has none they are counted.
    """
    as_name("table", what, SYSTEM_TABLES)
    pandas = require_data("pandas")
    if what == "events":
        table = pandas.DataFrame({each.name: rows for each, rows in zip(EVENT, solution.event_rows.T, strict=True)})
        whole = {each.name: np.int64 for each in EVENT if each.dtype == WHOLE}
        kinds = [EventKind(int(kind)).name for kind in solution.event_rows[:, EVENT_KIND]]
        names = [solution.described.contacts[k] if k >= 0 else "" for k in table.contact.astype(int)]
        told = {"kind": np.array(kinds, dtype=object), "contact_name": np.array(names, dtype=object)}
        return with_units(table.astype(whole).assign(**told), {each.name: each.unit for each in EVENT})
    columns, units = {}, {}
    for each, values in recorded_of(solution):
        for name, unit, part in parts_of(solution, each, values):
            columns[name], units[name] = part, unit
    works = solution.ledger if LEDGER in solution.recorded else {}
    columns |= {f"{name} [J]": values for name, values in works.items()}
    return with_units(pandas.DataFrame(columns), units | {f"{name} [J]": "J" for name in works})


def parts_of(solution: Solution, each: Column, values: np.ndarray) -> Iterator[tuple[str, str, np.ndarray]]:
    """The columns (n_t,) of one column of the records, with names and units."""
    described = solution.described
    if each.name == "t":
        yield "t", each.unit, values
    elif each.name in ("q", "u"):
        pairs = described.coordinates if each.name == "q" else described.rates
        yield from ((name, unit, part) for (name, unit), part in zip(pairs, values.T, strict=True))
    elif each.name not in ("slip", "la"):
        for k, name in enumerate(described.contacts):
            place = str(k) if name == f"contact {k}" else name
            if each.name == "mode":
                yield f"mode[{place}]", "", named_modes(values[:, k])
            elif values.ndim == 2:
                yield f"{each.name}[{place}]", each.unit, values[:, k]
            else:
                d = values.shape[2]
                named = [f"{each.name}[{place},{a}]" if d > 1 else f"{each.name}[{place}]" for a in range(d)]
                yield from zip(named, [each.unit] * d, values[:, k].T, strict=True)


def with_units(table: pandas.DataFrame, units: dict[str, str]) -> pandas.DataFrame:
    """A table that knows the units of its columns, where they have one."""
    table.attrs["units"] = {name: unit for name, unit in units.items() if unit and name in table}
    return table


def named_modes(modes: np.ndarray) -> np.ndarray:
    """Modes by name."""
    names = np.array([mode.name for mode in ContactMode], dtype=object)
    return names[np.asarray(modes, np.int64)]  # type: ignore[no-any-return]


def scene_dataset(solution: SceneSolution) -> xarray.Dataset:
    """A run of a scene as an ``xarray.Dataset``, with what was recorded."""
    xarray = require_data("xarray")
    table = {each.name: each for each in SCENE[solution.dim]}
    data = {LABELS.get(name, name.replace("s/", "_")): variable(each, solution.columns[name])
            for name, each in table.items() if name in solution.columns and name not in UNLABELLED}  # fmt: skip
    if CONTACTS in solution.recorded:
        found = solution.all_contacts
        data["contact_record"] = column("contact", record_of(found.offsets), "1", "record of a contact")
        data["contact_mode"] = with_flags(column("contact", modes_in(found), "1", "mode of the last step"))
        if solution.stats.springs is not None:
            data["contact_P"][2].update({"units": "N", "long_name": "force on body j"})
    if EVENTS in solution.recorded and solution.stats.springs is not None:
        data["event_P"][2].update({"units": "N", "long_name": "force on body j at the end of the step"})
        data["event_P_N"][2].update({"units": "N", "long_name": "normal forces at the end of the step, summed"})
    coordinates: dict[str, Any] = {
        "t": data.pop("t"),
        "body": ("body", np.array(solution.names, dtype=object)),
        "axis": ("axis", list(AXES[: solution.dim])),
    }
    if solution.joint_names and "joint_P" in data:
        coordinates["joint"] = ("joint", np.array(solution.joint_names, dtype=object))
    else:
        data = {name: column for name, column in data.items() if name not in ("joint_P", "joint_torque")}
    if solution.dim == 3:
        coordinates["component"] = ("component", ["w", *AXES])
    data |= ledger_of(solution) if LEDGER in solution.recorded else {}
    data |= {f"t_events_{k}": variable(table["t_events/*"], t, str(k)) for k, t in enumerate(solution.t_events)}
    return xarray.Dataset(data, coordinates, about_of(solution))


def scene_table(solution: SceneSolution, what: str = "bodies") -> pandas.DataFrame:
    """A run of a scene as a table: a row a body of a record, a contact of a record, a record, an event, or a pair."""
    as_name("table", what, SCENE_TABLES)
    pandas = require_data("pandas")
    if what == "records":
        works = solution.ledger if LEDGER in solution.recorded else {}
        columns = {each.name: solution.columns[each.name] for each in SCENE[solution.dim]
                   if each.shape == ("n_t",) and each.name in solution.columns}  # fmt: skip
        return pandas.DataFrame(columns | {f"{name} [J]": values for name, values in works.items()})
    if what == "bodies":
        n_t, n_b = solution.position.shape[:2]
        columns = {"t": np.repeat(solution.t, n_b), "body": np.tile(np.array(solution.names, dtype=object), n_t)}
        for each in SCENE[solution.dim]:
            if each.shape[:2] == ("n_t", "n_b"):
                columns |= split(each, each.name, getattr(solution, each.name))
        return pandas.DataFrame(columns)
    found = {CONTACTS: lambda: solution.all_contacts.columns, EVENTS: lambda: solution.events.columns,
             PAIRS: lambda: solution.pairs.columns}[what]()  # fmt: skip
    columns = {}
    for each in SCENE[solution.dim]:
        if each.name.startswith(f"{what}/") and each.shape != ("n_t + 1",):
            columns |= cells(solution, each, found[word_of(each.name)])
    if what == CONTACTS:
        record, modes = record_of(found["offsets"]), modes_in(solution.all_contacts)
        P_N, P_F = normal_and_friction(found["P"], found["normal"])
        columns |= {"t": solution.t[record], "record": record, "P_N": P_N, "P_F": P_F, "mode": named_modes(modes)}
        columns = {name: columns[name] for name in (*FIRST, *columns)}
    return pandas.DataFrame(columns)


def cells(solution: SceneSolution, each: Column, values: np.ndarray) -> dict[str, np.ndarray]:
    """A column of contacts, events or pairs as those of a table: indices as names, vectors by components."""
    name = word_of(each.name)
    named = {"i": solution.names, "j": solution.names, "joint": [*solution.joint_names, ""],  # the last is that of none
             "kind": [kind.name for kind in SceneEventKind]}  # fmt: skip
    if name in named:
        return {name: np.array(named[name], dtype=object)[values]}
    return split(each, f"{name} [J]" if each.unit == "J" else name, np.asarray(values))


def split(each: Column, name: str, values: np.ndarray) -> dict[str, np.ndarray]:
    """The components of a column (..., k) as columns."""
    size = each.shape[-1]
    if isinstance(size, str):
        return {name: values.ravel()}
    return {f"{name}_{part}": values[..., k].ravel() for k, part in enumerate(COMPONENTS[size])}


def modes_in(found: ContactColumns) -> np.ndarray:
    """The modes of all contacts."""
    return modes_of(*normal_and_friction(found.P, found.normal), found.mu)


def write_netcdf(
    solution: Solution | SceneSolution, path: str | Path, add: Callable[[Path], object] = lambda part: None
) -> Path:
    """Write a run to netCDF 4, which any reader of it and ``xarray.open_dataset`` opens, and what ``add`` adds; sealed.

    Raises
    ------
    MissingExtra, InvalidInput, FileFailure
    """
    path, dataset = Path(path), solution.to_xarray()
    require_data("netCDF4")
    with whole_file(path) as part:
        try:
            dataset.to_netcdf(str(part), engine="netcdf4")
        except RuntimeError as error:  # so says the library of netCDF when the disk is full
            raise OSError(str(error)) from error
        add(part)
        with part.open("r+b") as file:
            seal(file, NETCDF_KIND)
    return path
