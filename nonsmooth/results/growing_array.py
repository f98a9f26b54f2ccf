"""An array on disk that grows: a plain ``.npy`` file in which the number of rows is written over.

    magic, version, length | {'descr': ..., 'fortran_order': False, 'shape': (m,), } and blanks | m rows

New rows go behind the old ones, and only then m is written over, 28 bytes in one call: whoever opens the file with
`numpy.load`, at whatever moment the writer died, finds m whole rows. What stands behind them is not looked at.
Source: the .npy format, ``numpy.lib.format``.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

import numpy as np

from nonsmooth.checks.files import open_to_read

ALIGNMENT = 64  # defined: bytes: the rows begin at a multiple of it
SHAPE_BYTES = 28  # derived: bytes of "(m,), }" and its blanks: a count of up to 20 digits fits


class GrowingArray:
    """An open file of rows.

    Parameters
    ----------
    path : Path
        Made if it is not there.
    dtype : numpy.dtype
        Of a row.
    """

    def __init__(self, path: Path, dtype: np.dtype) -> None:
        self.dtype = dtype
        header = _header(dtype)
        self._rows_at, self._count_at = len(header), len(header) - 1 - SHAPE_BYTES
        self._file = open(path, "r+b" if path.exists() else "x+b", buffering=0)
        try:
            if os.fstat(self._file.fileno()).st_size < len(header):
                self._put(0, header)
        except OSError:
            self._file.close()
            raise

    def write(self, first: int, rows: np.ndarray) -> None:
        """Write rows at the place ``first``; the last of them is the last of the file."""
        data = np.ascontiguousarray(rows, self.dtype).view(np.uint8).data
        self._put(self._rows_at + first * self.dtype.itemsize, data)
        self._put(self._count_at, _count(first + len(rows)))

    def cut(self, rows: int) -> None:
        """Forget the rows behind so many."""
        self._put(self._count_at, _count(rows))

    def sync(self) -> None:
        """Have the operating system put on the disk what was written."""
        os.fsync(self._file.fileno())

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def _put(self, place: int, data: bytes | memoryview) -> None:
        self._file.seek(place)
        rest = memoryview(data)
        while rest:
            rest = rest[self._file.write(rest) :]


def map_rows(path: Path, dtype: np.dtype) -> np.ndarray:
    """The rows of a file, mapped: read where they are looked at.

    Raises
    ------
    OSError, ValueError
        When the file is not there, has other rows than those of this type, or fewer than it says.
    """
    header = _header(dtype)
    with open_to_read(path) as file:
        start, size = file.read(len(header)), os.fstat(file.fileno()).st_size
    count = re.fullmatch(rb"\((\d{1,20}),\), \} *", start[-1 - SHAPE_BYTES : -1])
    if count is None or start != header[: -1 - SHAPE_BYTES] + start[-1 - SHAPE_BYTES : -1] + b"\n":
        raise ValueError("its header is not that of its rows")
    rows = int(count[1])
    if len(header) + rows * dtype.itemsize > size:
        raise ValueError(f"it says that it has {rows} rows, which is more than its {size} bytes hold")
    if rows == 0:
        return np.empty(0, dtype)
    return np.memmap(path, dtype, "r", offset=len(header), shape=(rows,))


def rows_at(dtype: np.dtype) -> int:
    """The place of the first row in a file [bytes]."""
    return len(_header(dtype))


def _header(dtype: np.dtype) -> bytes:
    """The bytes before the first row, of an array without rows."""
    text = f"{{'descr': {np.lib.format.dtype_to_descr(dtype)!r}, 'fortran_order': False, 'shape': ".encode()
    prefix = len(np.lib.format.magic(1, 0)) + 2
    blanks = -(prefix + len(text) + SHAPE_BYTES + 1) % ALIGNMENT
    text += b" " * blanks + _count(0) + b"\n"
    return bytes(np.lib.format.magic(1, 0)) + len(text).to_bytes(2, "little") + text


def _count(rows: int) -> bytes:
    return f"({rows},), }}".encode().ljust(SHAPE_BYTES)
