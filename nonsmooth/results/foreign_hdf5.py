"""HDF5 files of others, read in a process of its own.

A damaged file can end the HDF5 library's process, or keep it for ever. So another Python reads the datasets that are
wanted, within bounds of memory and time, and hands them on as an archive of plain arrays (npz.py) through a pipe:

    python -P -m nonsmooth.results.foreign_hdf5 FILE NAME...

Before a dataset is read: it must stand in the file itself (no links to elsewhere), have been written whole, and claim
no more bytes than the file has room for (checks/memory.py).
"""

from __future__ import annotations

import io
import os
import subprocess
import sys
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from nonsmooth.checks.files import open_to_read
from nonsmooth.checks.memory import INFLATION, LEAST_CLAIM, require_room
from nonsmooth.results.hdf5 import require_h5py
from nonsmooth.results.npz import read_arrays

ROOT = "/"  # under this name: what the file holds at its top
SIGNATURE = b"\x89HDF\r\n\x1a\n"
ANSWER, REFUSAL = 0, 3  # code: exit codes
READER_START_TIME = 20.0  # chosen: s: a Python with h5py starts in 0.2 s, on a busy machine in some seconds
RATE = 5e6  # measured: bytes/s of a file, a tenth of what inflating takes
PROCESS = 2**30  # chosen: bytes of address space: a Python with h5py takes a tenth of it
NAMES_SHOWN = 5  # chosen: names in a message


def read_foreign(path: Path, names: Sequence[str]) -> dict[str, np.ndarray]:
    """The datasets of these names that are there, and under ``ROOT`` what the file holds at its top.

    Raises
    ------
    ValueError
        When the file is damaged, or claims more than there is room for; the words tell.
    """
    require_h5py()
    size = path.stat().st_size
    _require_whole(path, size)
    command = [sys.executable, "-P", "-m", __name__, str(path.absolute()), *names]
    try:
        ended = subprocess.run(
            command,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=READER_START_TIME + size / RATE,
            env=_environment(),
        )
    except subprocess.TimeoutExpired as error:
        raise ValueError(f"the HDF5 library was still at work on it after {error.timeout:.0f} s") from None
    if ended.returncode == REFUSAL:
        raise ValueError(ended.stderr.decode(errors="replace").strip())
    if ended.returncode != ANSWER:
        raise ValueError(f"the HDF5 library ended its process on it (exit code {ended.returncode})")
    try:
        return read_arrays(io.BytesIO(ended.stdout), size, lambda forms: None, is_trusted=False)
    except zipfile.BadZipFile:
        raise ValueError("the HDF5 library ended well, and it is no archive of arrays that it handed on") from None


def is_hdf5(path: Path) -> bool:
    """Whether a file begins as one of HDF5, at its start or behind a block of the user's."""
    with open_to_read(path) as file:
        starts = [0, *(512 << k for k in range(20))]
        return any(file.seek(start) == start and file.read(len(SIGNATURE)) == SIGNATURE for start in starts)


def _require_whole(path: Path, size: int) -> None:
    """Raise where the file goes on behind the end that HDF5 states: a seal that is damaged, or something else."""
    with open_to_read(path) as file:
        superblock = file.read(64)
    version, places = superblock[8], {0: (13, 24), 1: (13, 28), 2: (9, 12), 3: (9, 12)}
    if superblock[:8] != SIGNATURE or version not in places:
        return
    width_at, addresses_at = places[version]
    width = superblock[width_at]
    place = addresses_at + 2 * width
    end = int.from_bytes(superblock[place : place + width], "little")
    if end < size:
        raise ValueError(f"{size - end} bytes stand behind its end, as h5repack leaves them away")


def _environment() -> dict[str, str]:
    """That of this process, for one that finds the same packages, starts one thread and loads no plugins of HDF5."""
    places = os.pathsep.join(place for place in sys.path if place)
    return {**os.environ, "PYTHONPATH": places, "OPENBLAS_NUM_THREADS": "1", "HDF5_PLUGIN_PRELOAD": "::"}


def main(path: str, *names: str) -> int:
    """Read in this process, and write the archive to the standard output."""
    h5py = require_h5py()
    size = os.path.getsize(path)
    _bound_memory(PROCESS + 3 * max(LEAST_CLAIM, INFLATION * size))
    archive = io.BytesIO()
    try:
        with h5py.File(path, "r") as file:
            arrays: dict[str, Any] = read_datasets(file, names, size)
            np.savez(archive, **arrays)
    except Exception as error:  # whatever a damaged file makes the library say
        print(" ".join(str(error).split()), file=sys.stderr)
        return REFUSAL
    sys.stdout.buffer.write(archive.getbuffer())
    return ANSWER


def read_datasets(file: Any, names: Sequence[str], size: int | None) -> dict[str, np.ndarray]:
    """The datasets of an open file; ``size`` is that of a file of others, None of one whose seal was verified."""
    datasets = {name: file[name] for name in names if _is_there(file, name)}
    for name, dataset in datasets.items():
        _require_dataset(name, dataset)
    require_room(sum(dataset.nbytes for dataset in datasets.values()), size)
    top = np.array(sorted(file)[:NAMES_SHOWN], dtype=str)
    return {ROOT: top, **{name: _array(dataset) for name, dataset in datasets.items()}}


def _is_there(file: Any, name: str) -> bool:
    """Whether a name leads through groups of this very file to something."""
    h5py, group = require_h5py(), file
    for part in name.split("/"):
        if not isinstance(group, h5py.Group) or part not in group:
            return False
        if not isinstance(group.get(part, getlink=True), h5py.HardLink):
            raise ValueError(f"{name} is a link to elsewhere")
        group = group[part]
    return True


def _require_dataset(name: str, dataset: Any) -> None:
    """Raise unless this is an array that the file holds itself, every byte of it."""
    if not isinstance(dataset, require_h5py().Dataset) or dataset.shape is None:
        raise ValueError(f"{name} is no array")
    if dataset.is_virtual or dataset.external:
        raise ValueError(f"{name} stands in other files")
    stored = dataset.id.get_storage_size()
    if dataset.nbytes and (stored < dataset.nbytes if dataset.chunks is None else stored == 0):
        raise ValueError(f"{name} claims {dataset.nbytes} bytes, of which {stored} are in the file")


def _array(dataset: Any) -> np.ndarray:
    if require_h5py().check_string_dtype(dataset.dtype) is not None:
        return np.array(dataset.asstr(errors="replace")[()], dtype=str)
    return np.asarray(dataset[()])


def _bound_memory(size: int) -> None:
    try:
        import resource
    except ImportError:  # not a Unix
        return
    resource.setrlimit(resource.RLIMIT_AS, (size, size))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
