"""Maps of paradoxes on disk: NetCDF 3, which xarray, MATLAB and ncview read, or .npz; sealed, moved into place when
whole."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.checks.files import as_place, whole_file
from nonsmooth.results.npz import write_npz
from nonsmooth.results.seal import seal

if TYPE_CHECKING:
    import xarray

MAP_ENDINGS = (".nc", ".npz")
KIND = "map"


def save_map(chart: xarray.Dataset, path: str | Path) -> Path:
    """Write a map of `paradox_map`; the ending names the format.

    An .npz holds the axes and variables by name, and the attributes as one JSON text ``about``.

    Raises
    ------
    InvalidInput
        For another ending.
    """
    path = as_place("path", path, MAP_ENDINGS)
    if path.suffix == ".npz":
        write_npz(path, KIND, _as_arrays(chart), is_compressed=True)
        return path
    with whole_file(path) as part:
        chart.to_netcdf(part, engine="scipy")
        with part.open("r+b") as file:
            seal(file, KIND)
    return path


def _as_arrays(chart: xarray.Dataset) -> dict[str, np.ndarray]:
    meanings = {str(name): variable.attrs.get("flag_meanings", "") for name, variable in chart.data_vars.items()}
    dims = {str(name): list(variable.dims) for name, variable in chart.data_vars.items()}
    about = json.dumps({"attrs": dict(chart.attrs), "dims": dims, "flag_meanings": meanings})
    return {"about": np.array(about), **{str(name): variable.values for name, variable in chart.variables.items()}}
