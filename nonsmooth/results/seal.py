"""The seal: the last line of every file that is written here, a checksum of all the bytes before it.

    nonsmooth KIND seal 1 crc32 CRC

A reader looks at it before any other program code touches the file: a library that a damaged file would crash (HDF5,
netCDF) only ever sees the bytes that were written. CRC-32 finds every damage within 32 bits, and any other but one in
4e9; it is no signature, whoever wants to forge a file can. The readers of .npz, HDF5 and netCDF look for nothing behind
their own end, so that the line is in nobody's way; in a zip archive it is the comment. When HDF5 opens a file to change
it, it takes the line off: what it leaves is a file of others.
"""

from __future__ import annotations

import os
import re
import zlib
from collections.abc import Iterator
from typing import BinaryIO

VERSION = 1  # code: of the form of a seal
SEAL = re.compile(rb"\nnonsmooth ([a-z]+) seal (\d{1,4}) crc32 ([0-9a-f]{8})\n\Z")
LONGEST_SEAL = 80  # chosen: bytes of a seal
READ_BYTES = 2**18  # chosen: bytes that are read at a time: what the processor's cache holds
ZIP = b"PK\x03\x04"


def seal(file: BinaryIO, kind: str) -> None:
    """Append the seal to a file that is open for reading and writing; ``kind`` is one word that says what it is."""
    size = file.seek(0, os.SEEK_END)
    words = f"\nnonsmooth {kind} seal {VERSION} crc32 ".encode()
    _declare_comment(file, len(words) + 9)
    file.write(words + f"{crc_of(file, size, words):08x}\n".encode())


def sealed_kind(file: BinaryIO) -> str:
    """The kind of a sealed file, or "" where there is no seal; the file is read from its beginning afterwards.

    Raises
    ------
    ValueError
        When the content is not the one that was sealed.
    """
    end = file.seek(0, os.SEEK_END)
    file.seek(max(0, end - LONGEST_SEAL))
    found = SEAL.search(file.read(LONGEST_SEAL))
    if found is None:
        file.seek(0)
        return ""
    kind, version, crc = found.groups()
    if int(version) != VERSION:
        raise ValueError(f"its seal has version {int(version)}; this version reads {VERSION}")
    if crc_of(file, end - len(found.group()), found.group()[:-9]) != int(crc, 16):
        raise ValueError("its content is not what was written: the checksum in its last line says so")
    file.seek(0)
    return kind.decode()


def require_kind(found: str, kind: str) -> None:
    """Raise `ValueError` unless a file was sealed as one of this kind."""
    if not found:
        raise ValueError("it has no seal: it was cut short, or another program wrote it")
    if found != kind:
        raise ValueError(f"it is sealed as a {found}")


def crc_of(file: BinaryIO, size: int, words: bytes) -> int:
    """CRC-32 of the first bytes of a file and of some words behind them; the file is left at their end."""
    crc = 0
    for piece in pieces(file, 0, size):
        crc = zlib.crc32(piece, crc)
    return zlib.crc32(words, crc)


def pieces(file: BinaryIO, start: int, end: int) -> Iterator[memoryview]:
    """The bytes of a file from one place to another, a piece at a time; fewer where the file is shorter."""
    buffer = memoryview(bytearray(READ_BYTES))
    file.seek(start)
    while start < end and (count := file.readinto(buffer[: min(READ_BYTES, end - start)])):  # type: ignore[attr-defined]
        yield buffer[:count]
        start += count


def _declare_comment(file: BinaryIO, length: int) -> None:
    """Say in the last record of a zip archive, which ends with the length of its comment, how long the seal is."""
    file.seek(0)
    if file.read(len(ZIP)) == ZIP:
        file.seek(-2, os.SEEK_END)
        file.write(length.to_bytes(2, "little"))
