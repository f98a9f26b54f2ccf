"""Archives of arrays, .npz: written with a seal, read by NumPy once the headers of all arrays were looked at.

Headers come first: names, dtypes, shapes, and whether each array has exactly the bytes that its header claims, which
NumPy reserves before it reads. What they claim together must have room; then `numpy.load` reads each array to its end,
where its checksum is verified. Nothing is unpickled.
Source: the .npy format, ``numpy.lib.format``; .zip, PKWARE APPNOTE 6.3.
"""

from __future__ import annotations

import json
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np
from numpy.lib import format as npy

from nonsmooth.checks.files import open_to_read, whole_file
from nonsmooth.checks.memory import require_room
from nonsmooth.results.forms import Form
from nonsmooth.results.seal import seal, sealed_kind

READERS_OF_HEADERS = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}

Check = Callable[[Mapping[str, Form]], object]


class Archive(NamedTuple):
    """What was read: the kind that the file was sealed as ("" for a file of others), and its arrays."""

    kind: str
    arrays: dict[str, np.ndarray]

    def about(self) -> dict[str, Any]:
        """The text ``about``, which leaves the arrays."""
        about = json.loads(str(self.arrays.pop("about")))
        if not isinstance(about, dict):
            raise ValueError("its text 'about' is none of ours")
        return about


def write_npz(path: Path, kind: str, arrays: Mapping[str, Any], is_compressed: bool) -> None:
    """Write arrays by their names, with a seal; an existing file is replaced once the new one is whole.

    Raises
    ------
    FileFailure
    """
    with whole_file(path) as part, part.open("w+b") as file:
        fill_npz(file, kind, arrays, is_compressed)


def fill_npz(file: BinaryIO, kind: str, arrays: Mapping[str, Any], is_compressed: bool) -> None:
    """Write arrays and the seal into an open, empty file."""
    (np.savez_compressed if is_compressed else np.savez)(file, **arrays)
    seal(file, kind)


def read_npz(path: Path, check: Check = lambda forms: None) -> Archive:
    """Read an archive of plain arrays.

    Parameters
    ----------
    path : Path
    check : callable
        Is shown the `Form` of every array by its name before one of them is read; raises where they are not the ones.

    Raises
    ------
    OSError, ValueError, zipfile.BadZipFile
        And whatever else a damaged archive makes its reader raise.
    """
    with open_to_read(path) as file:
        kind = sealed_kind(file)
        return Archive(kind, read_arrays(file, path.stat().st_size, check, is_trusted=bool(kind)))


def read_arrays(file: BinaryIO, size: int, check: Check, is_trusted: bool) -> dict[str, np.ndarray]:
    """The arrays of an archive of so many bytes; of one that is not trusted the claims are weighed against them."""
    with zipfile.ZipFile(file) as archive:
        members = archive.infolist()
        forms = {member.filename.removesuffix(".npy"): _form(archive, member) for member in members}
        if len(forms) < len(members):
            raise ValueError("it holds two arrays of one name")
        require_room(sum(member.file_size for member in members), None if is_trusted else size)
        check(forms)
    file.seek(0)
    with np.load(file, allow_pickle=False) as arrays:
        return dict(arrays)


def _form(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> Form:
    """What the header of an array claims; raises unless it is what the archive has."""
    if not member.filename.endswith(".npy"):
        raise ValueError(f"it holds {member.filename!r}, which is no array")
    with archive.open(member) as stream:
        try:
            shape, _, dtype = READERS_OF_HEADERS[npy.read_magic(stream)](stream)
        except (ValueError, KeyError) as error:
            raise ValueError(f"{member.filename!r} is no plain array: {error}") from None
        form, start = Form(dtype.str, shape), stream.tell()
    if dtype.hasobject:
        raise ValueError(f"{member.filename!r} is no plain array: it holds pickled objects")
    if dtype.str[0] == ">":
        raise ValueError(f"{member.filename!r} is no plain array: big-endian numbers are not read")
    if member.file_size != start + form.size:
        raise ValueError(
            f"{member.filename!r} claims {form.size} bytes in its header; it has {member.file_size - start}"
        )
    return form
