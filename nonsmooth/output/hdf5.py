"""HDF5 files, written whole.

The HDF5 library ends the process when a disk fills up under an open file; so a file is made in memory, and written to
disk at once, where a refusal is an ordinary error.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

from nonsmooth.errors import MissingExtra
from nonsmooth.files import whole_file


def require_h5py() -> Any:
    """The module h5py, or `MissingExtra`."""
    try:
        import h5py
    except ImportError:
        raise MissingExtra('.h5 files need h5py; pip install "nonsmooth[io]" brings it, or use .npz') from None
    return h5py


def write_hdf5(path: Path, fill: Callable[[Any], None]) -> None:
    """Write the file that ``fill(file)`` fills.

    Raises
    ------
    FileFailure, MissingExtra
    """
    memory = io.BytesIO()
    with require_h5py().File(memory, "w") as file:
        fill(file)
    with whole_file(path) as part:
        part.write_bytes(memory.getbuffer())
