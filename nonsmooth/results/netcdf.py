"""The run itself within a netCDF file for other programs: our archive of arrays, as the bytes of one variable.

nonsmooth/run (bytes)    what an .npz holds, in a group that ``xarray.open_dataset`` does not look into
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from nonsmooth.errors import MissingExtra
from nonsmooth.results.hdf5 import seal_of
from nonsmooth.results.npz import Check, fill_npz, read_arrays
from nonsmooth.results.seal import require_kind

NETCDF_KIND = "netcdf"
GROUP, VARIABLE, BYTES = "nonsmooth", "run", "bytes"


def require_netcdf4() -> Any:
    """The module netCDF4, or `MissingExtra`."""
    try:
        import netCDF4
    except ImportError:
        raise MissingExtra('.nc files need netCDF4; pip install "nonsmooth[data]" brings it, or use .npz') from None
    return netCDF4


def put_run(kind: str, arrays: Mapping[str, Any], path: Path) -> None:
    """Add the run to a netCDF file that is not sealed yet."""
    archive = io.BytesIO()
    fill_npz(archive, kind, arrays, is_compressed=True)
    content = np.frombuffer(archive.getbuffer(), np.uint8)
    with require_netcdf4().Dataset(str(path), "a") as file:
        group = file.createGroup(GROUP)
        group.createDimension(BYTES, len(content))
        group.createVariable(VARIABLE, "u1", (BYTES,))[:] = content


def read_run_within(path: Path, check: Check) -> dict[str, np.ndarray]:
    """The arrays of the run in a sealed netCDF file; `ValueError` where there is none."""
    require_kind(seal_of(path), NETCDF_KIND)
    with require_netcdf4().Dataset(str(path)) as file:
        if GROUP not in file.groups:
            raise ValueError("it holds what other programs want and not the whole run: it was written by an earlier "
                             "version; xarray.open_dataset reads it")  # fmt: skip
        content = np.asarray(file[GROUP][VARIABLE][:], np.uint8).tobytes()
    return read_arrays(io.BytesIO(content), len(content), check, is_trusted=True)
