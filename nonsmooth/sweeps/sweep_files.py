"""Results of sweeps on disk: npz without any extra, NetCDF with one; sealed, written to a temporary name and moved into
place.

What the netCDF library is given to read is sealed: it may crash on a damaged file. docs/files.md
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from nonsmooth.checks.arrays import as_instance
from nonsmooth.checks.files import as_path, as_place, refusals, whole_file
from nonsmooth.errors import MissingExtra
from nonsmooth.results.hdf5 import seal_of
from nonsmooth.results.npz import read_npz, write_npz
from nonsmooth.results.seal import require_kind, seal

if TYPE_CHECKING:
    import xarray

ENDINGS = (".npz", ".nc")
KIND = "sweep"


def check_path(path: str | os.PathLike[str]) -> Path:
    """Raise where a result could not be written at the end."""
    path = as_place("path", path, ENDINGS)
    if path.suffix == ".nc":
        _engine()
    return path


def save_sweep(found: xarray.Dataset, path: str | os.PathLike[str]) -> Path:
    """Write the result of `sweep`.

    Parameters
    ----------
    found : xarray.Dataset
    path : path-like
        .npz, or .nc (NetCDF; needs the extra [netcdf]).

    Returns
    -------
    Path

    Raises
    ------
    InvalidInput, MissingExtra
        For another ending, a folder that cannot be written, a library that is not installed.
    """
    import xarray

    as_instance("found", found, xarray.Dataset, "the Dataset of a sweep")
    path = check_path(path)
    if path.suffix == ".nc":
        with whole_file(path) as part:
            _write_nc(found, part)
            with part.open("r+b") as file:
                seal(file, KIND)
    else:
        write_npz(path, KIND, _as_arrays(found), is_compressed=True)
    return path


def load_sweep(path: str | os.PathLike[str]) -> xarray.Dataset:
    """Read what `save_sweep` wrote.

    Raises
    ------
    InvalidInput
        When the file is not there, or is none of ours, or damaged.
    """
    path = as_path("path", path)
    if path.suffix == ".nc":
        _engine()
    with refusals(path, "is no result of a sweep"):
        return _read_nc(path) if path.suffix == ".nc" else _read_npz(path)


def _read_nc(path: Path) -> xarray.Dataset:
    import xarray

    require_kind(seal_of(path), KIND)
    with xarray.open_dataset(path, engine=_engine()) as found:
        return found.load()


def _read_npz(path: Path) -> xarray.Dataset:
    import xarray

    found = read_npz(path)
    require_kind(found.kind, KIND)
    about = found.about()
    columns = {name: _column(found.arrays, name, entry) for name, entry in about["variables"].items()}
    coordinates = {name: columns.pop(name) for name in about["coordinates"]}
    return xarray.Dataset(columns, coordinates, about["attrs"])


def _as_arrays(found: xarray.Dataset) -> dict[str, Any]:
    """The Dataset as plain arrays: texts as numbers of a list of the different ones."""
    arrays: dict[str, Any] = {}
    variables = {}
    for name, variable in found.variables.items():
        values = variable.values
        is_text = values.dtype.kind in "OUT"
        if is_text:
            texts, values = np.unique(values.astype(str).reshape(-1), return_inverse=True)
            arrays[f"{name}/texts"], values = texts, values.astype(np.int32).reshape(variable.shape)
        arrays[str(name)] = values
        attrs = {key: value.tolist() if hasattr(value, "tolist") else value for key, value in variable.attrs.items()}
        variables[str(name)] = {"dims": variable.dims, "attrs": attrs, "is_text": is_text}
    about = {"variables": variables, "coordinates": list(found.coords), "attrs": dict(found.attrs)}
    return arrays | {"about": np.array(json.dumps(about))}


def _column(file: Any, name: str, entry: dict[str, Any]) -> tuple[Any, ...]:
    values = file[name]
    if entry["is_text"]:
        values = file[f"{name}/texts"].astype(object)[values]
    return entry["dims"], values, entry["attrs"]


def _write_nc(found: xarray.Dataset, part: Path) -> None:
    try:
        found.to_netcdf(str(part), engine=_engine())
    except RuntimeError as error:  # so says the library of netCDF when the disk is full
        raise OSError(str(error)) from error


def _engine() -> Literal["netcdf4", "h5netcdf"]:
    """What xarray writes NetCDF 4 with."""
    from importlib.util import find_spec

    if find_spec("netCDF4"):
        return "netcdf4"
    if find_spec("h5netcdf"):
        return "h5netcdf"
    raise MissingExtra('.nc files need netCDF4; pip install "nonsmooth[netcdf]" brings it; .npz needs nothing')
