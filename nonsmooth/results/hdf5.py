"""HDF5 files: written whole, with a seal and a checksum of each dataset; read where the seal says that they are whole.

The HDF5 library ends the process when a disk fills up under an open file; so a file is made in memory, and written to
disk at once, where a refusal is an ordinary error. It also ends the process, or never comes back, on some damaged
files: it is shown sealed files only, and those of others in a process of its own (foreign_hdf5.py).

Each dataset carries HDF5's own checksum (fletcher32), which any program that reads it verifies. Where the seal was
verified it says nothing new, and the stored bytes are taken as they are.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from nonsmooth.checks.files import open_to_read, whole_file
from nonsmooth.checks.memory import require_room
from nonsmooth.errors import MissingExtra
from nonsmooth.results.forms import Form
from nonsmooth.results.npz import Check
from nonsmooth.results.seal import seal, sealed_kind

CHUNK_BYTES = 2**20  # chosen: bytes of a chunk, which has one checksum: as much as the library keeps of a dataset
FLETCHER32 = 4  # defined: bytes of the checksum behind a chunk


def require_h5py() -> Any:
    """The module h5py, or `MissingExtra`."""
    try:
        import h5py
    except ImportError:
        raise MissingExtra('.h5 files need h5py; pip install "nonsmooth[io]" brings it, or use .npz') from None
    return h5py


def write_hdf5(path: Path, kind: str, fill: Callable[[Any], None]) -> None:
    """Write the file that ``fill(file)`` fills, sealed.

    Raises
    ------
    FileFailure, MissingExtra
    """
    memory = io.BytesIO()
    with require_h5py().File(memory, "w") as file:
        fill(file)
    seal(memory, kind)
    with whole_file(path) as part:
        part.write_bytes(memory.getbuffer())


def put_array(group: Any, name: str, array: np.ndarray) -> None:
    """Store an array in chunks with a checksum each; without entries there is nothing to sum."""
    if array.size == 0 or array.ndim == 0:
        group[name] = array
        return
    rows = max(1, CHUNK_BYTES * len(array) // array.nbytes)
    group.create_dataset(name, data=array, chunks=(min(rows, len(array)), *array.shape[1:]), fletcher32=True)


def seal_of(path: Path) -> str:
    """The kind that a file was sealed as, or ""; raises `ValueError` where its content is not what was sealed."""
    with open_to_read(path) as file:
        return sealed_kind(file)


def read_sealed(path: Path, check: Check) -> tuple[str, dict[str, np.ndarray]]:
    """The text ``about`` and all datasets of a file whose seal was verified.

    Parameters
    ----------
    path : Path
    check : callable
        Is shown the `Form` of every dataset by its name before one of them is read.
    """
    with require_h5py().File(path, "r") as file:
        datasets = dict(_datasets(file, ""))
        forms = {name: Form(dataset.dtype.str, dataset.shape) for name, dataset in datasets.items()}
        require_room(sum(form.size for form in forms.values()), None)
        check(forms)
        return str(file.attrs["about"]), {name: take(dataset) for name, dataset in datasets.items()}


def _datasets(group: Any, path: str) -> Iterator[tuple[str, Any]]:
    for name, entry in group.items():
        if hasattr(entry, "dtype"):
            yield path + name, entry
        else:
            yield from _datasets(entry, f"{path}{name}/")


def take(dataset: Any) -> np.ndarray:
    """The array of a dataset that ``put_array`` stored; the bytes of its chunks, their checksums not computed again."""
    if not dataset.fletcher32 or dataset.compression is not None:
        return dataset[()]
    array = np.empty(dataset.shape, dataset.dtype)
    rows = dataset.chunks[0]
    for first in range(0, len(array), rows):
        block = array[first : first + rows]
        _, stored = dataset.id.read_direct_chunk((first, *[0] * (array.ndim - 1)))
        block[...] = np.frombuffer(stored, array.dtype, block.size).reshape(block.shape)
    return array
