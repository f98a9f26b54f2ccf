"""An array on disk that grows by blocks of rows, and a checksum of each block.

    records.npy       the rows
    records.crc.npy   (end, crc32) of each block: its rows are those from the end of the block before to its own end

The checksum of a block is written before its rows, and the rows before their number (growing_array.py): at whatever
moment the writer dies, the number of rows is the end of a block. Rows that a power failure took, or damage, do not fit
their checksum; `verified_rows` counts those before them.
"""

from __future__ import annotations

import functools
import zlib
from contextlib import ExitStack, closing
from pathlib import Path

import numpy as np

from nonsmooth.checks.files import open_to_read
from nonsmooth.results.growing_array import GrowingArray, map_rows, rows_at
from nonsmooth.results.seal import pieces

BLOCK = np.dtype([("end", "<i8"), ("crc32", "<i8")])


def checksums_of(path: Path) -> Path:
    """Where the checksums of an array stand."""
    return path.with_suffix(".crc.npy")


class CheckedArray:
    """An open array of rows with its checksums.

    Parameters
    ----------
    path : Path
        Made if it is not there.
    dtype : numpy.dtype
        Of a row.
    rows : int
        What the array holds: whole blocks. Rows behind them are forgotten.

    Attributes
    ----------
    rows : int
    """

    def __init__(self, path: Path, dtype: np.dtype, rows: int) -> None:
        self.rows, self._n_blocks = rows, 0
        if rows:
            self._n_blocks = 1 + int(np.searchsorted(map_rows(checksums_of(path), BLOCK)["end"], rows))
        with ExitStack() as files:
            self._rows = files.enter_context(closing(GrowingArray(path, dtype)))
            self._blocks = files.enter_context(closing(GrowingArray(checksums_of(path), BLOCK)))
            if len(map_rows(path, dtype)) > rows:
                self._rows.cut(rows)
            self._files = files.pop_all()

    def append(self, rows: np.ndarray) -> None:
        """Write a block."""
        self.show(rows)
        self.rows += len(rows)
        self._n_blocks += 1

    def show(self, rows: np.ndarray) -> None:
        """Write a block in whose place the next one will stand."""
        data = np.ascontiguousarray(rows, self._rows.dtype)
        self._blocks.write(self._n_blocks, np.array([(self.rows + len(rows), zlib.crc32(data.data))], BLOCK))
        self._rows.write(self.rows, data)

    def sync(self) -> None:
        """Have the operating system put on the disk what was written."""
        self._rows.sync()
        self._blocks.sync()

    def close(self) -> None:
        """Close both files."""
        self._files.close()


def verified_rows(path: Path, dtype: np.dtype) -> int:
    """How many rows of an array fit their checksums, to the first block that does not; each byte is read.

    Raises
    ------
    OSError, ValueError
        When a file is not there, or its header is not that of its rows.
    """
    count, place, start = len(map_rows(path, dtype)), 0, rows_at(dtype)
    with open_to_read(path) as file:
        for end, crc in map_rows(checksums_of(path), BLOCK).tolist():
            block = [start + row * dtype.itemsize for row in (place, end)]
            if not place < end <= count or functools.reduce(_add, pieces(file, *block), 0) != crc:
                break
            place = end
    return place


def _add(crc: int, piece: memoryview) -> int:
    return zlib.crc32(piece, crc)
