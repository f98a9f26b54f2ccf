"""Maps of paradoxes on disk: NetCDF 3, which xarray, MATLAB and ncview read, or .npz; moved into place when whole."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.files import as_place, whole_file

if TYPE_CHECKING:
    import xarray

MAP_ENDINGS = (".nc", ".npz")


def save_map(chart: xarray.Dataset, path: str | Path) -> Path:
    """Write a map of `paradox_map`; the ending names the format.

    An .npz holds the axes and variables by name, and the attributes as one JSON text ``about``.

    Raises
    ------
    InvalidInput
        For another ending.
    """
    path = as_place("path", path, MAP_ENDINGS)
    with whole_file(path) as part:
        _write(chart, part, path.suffix)
    return path


def _write(chart: xarray.Dataset, part: Path, suffix: str) -> None:
    if suffix == ".nc":
        chart.to_netcdf(part, engine="scipy")
    else:
        meanings = {str(name): variable.attrs.get("flag_meanings", "") for name, variable in chart.data_vars.items()}
        dims = {str(name): list(variable.dims) for name, variable in chart.data_vars.items()}
        about = json.dumps({"attrs": dict(chart.attrs), "dims": dims, "flag_meanings": meanings})
        arrays = {str(name): variable.values for name, variable in chart.variables.items()}
        with part.open("wb") as file:
            np.savez_compressed(file, allow_pickle=False, about=np.array(about), **arrays)
