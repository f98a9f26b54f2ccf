"""Archives of arrays, .npz: written with a seal, and read without trust in anything that stands in them.

The headers of all arrays are read first: names, dtypes, shapes, and whether each array has exactly the bytes that its
header claims. What they claim together must have room; then each array is read to its end, which is where its own
checksum is verified. Nothing is unpickled, and no header is evaluated.
Source: the .npy format, ``numpy.lib.format``; .zip, PKWARE APPNOTE 6.3.
"""

from __future__ import annotations

import json
import math
import re
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np

from nonsmooth.checks.files import open_to_read, whole_file
from nonsmooth.checks.memory import require_room
from nonsmooth.results.forms import Form
from nonsmooth.results.seal import ZIP, seal, sealed_kind

MAGIC = b"\x93NUMPY"
HEADER = re.compile(
    rb"\{'descr': *'([<>=|][a-zA-Z]\d{0,9})', *'fortran_order': *(True|False), *"
    rb"'shape': *\(((?:\d{1,19})?(?:, *\d{1,19})*),?\),? *\} *\n?"
)
LONGEST_HEADER = 10_000  # defined: bytes; NumPy reads no longer one either
INFLATED_BYTES = 2**20  # chosen: bytes that are inflated at a time
PLAIN = "biufU"  # kinds of dtype: flags, whole and real numbers, texts

Check = Callable[[Mapping[str, Form]], object]


class Member(NamedTuple):
    """An array in an archive: its form, where its data begin, whether its first index runs fastest."""

    form: Form
    start: int
    is_fortran: bool


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
    if file.read(len(ZIP)) != ZIP:
        raise ValueError("it is no archive of arrays")
    with zipfile.ZipFile(file) as archive:
        infos = {_name(info): info for info in archive.infolist()}
        if len(infos) < len(archive.infolist()):
            raise ValueError("it holds two arrays of one name")
        require_room(sum(info.file_size for info in infos.values()), None if is_trusted else size)
        members = {name: _member(archive, info) for name, info in infos.items()}
        check({name: member.form for name, member in members.items()})
        return {name: _array(archive, infos[name], member) for name, member in members.items()}


def _name(info: zipfile.ZipInfo) -> str:
    if not info.filename.endswith(".npy"):
        raise ValueError(f"it holds {info.filename!r}, which is no array")
    if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise ValueError(f"{info.filename!r} is compressed by another method than deflate")
    return info.filename.removesuffix(".npy")


def _member(archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> Member:
    with archive.open(info) as stream:
        prefix = stream.read(8)
        width = {b"\x01\x00": 2, b"\x02\x00": 4}.get(prefix[6:], 0)
        length = int.from_bytes(stream.read(width), "little")
        found = HEADER.fullmatch(stream.read(min(length, LONGEST_HEADER)))
    if prefix[:6] != MAGIC or width == 0 or length > LONGEST_HEADER or found is None:
        raise ValueError(f"{info.filename!r} is no plain array")
    descr, order, sizes = (group.decode() for group in found.groups())
    shape = tuple(int(size) for size in sizes.replace(",", " ").split())
    if descr[1] not in PLAIN or descr[0] not in "<|":
        raise ValueError(f"{info.filename!r} is no plain array: its dtype is {descr}, objects and big-endian numbers "
                         "are not read")  # fmt: skip
    form, start = Form(np.dtype(descr).str, shape), len(prefix) + width + length
    if info.file_size != start + form.size:
        raise ValueError(f"{info.filename!r} claims {form.size} bytes in its header; it has {info.file_size - start}")
    return Member(form, start, order == "True")


def _array(archive: zipfile.ZipFile, info: zipfile.ZipInfo, member: Member) -> np.ndarray:
    array = np.empty(math.prod(member.form.shape), member.form.dtype)
    room, filled = array.view(np.uint8), 0
    with archive.open(info) as stream:
        stream.read(member.start)
        while piece := stream.read(INFLATED_BYTES):  # to the end: there the checksum of the member is verified
            room[filled : filled + len(piece)] = np.frombuffer(piece, np.uint8)
            filled += len(piece)
    if filled != member.form.size:
        raise ValueError(f"{info.filename!r} ends after {filled} of {member.form.size} bytes")
    shape = member.form.shape
    return array.reshape(shape[::-1]).T if member.is_fortran else array.reshape(shape)
