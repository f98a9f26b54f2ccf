"""Arrays as text of a page: numbers of one kind, their bytes sorted by significance, gzip, base64.

Neighbours in time differ in their low bytes only: with all high bytes first (a shuffle, as in HDF5) gzip finds them
alike. What is quantised is stored as whole numbers of 16 bits, low + q (high - low)/65535, column by column, as
differences from frame to frame.
"""

from __future__ import annotations

import base64
import gzip
from typing import Any

import numpy as np

LEVELS = 65535  # defined: steps of a whole number of 16 bits
COMPRESSION = 6  # chosen: gzip's level; 9 takes three times as long for 1 % less


def packed(values: np.ndarray, dtype: str = "<f4") -> dict[str, Any]:
    """An array with its shape, in the given kind of numbers."""
    array = np.ascontiguousarray(values, dtype=dtype)
    return {"dtype": dtype[1:], "shape": array.shape, "data": text_of(array)}


def quantised(values: np.ndarray) -> dict[str, Any]:
    """An array (n_t, ...) in 16 bits for each number; its last axis is of like quantities.

    The error is half a step, (high - low)/131070 of a quantity, in float32.
    """
    flat = np.asarray(values, float).reshape(len(values), -1, values.shape[-1])
    low, high = flat.min(axis=(0, 1)), flat.max(axis=(0, 1))
    step = np.where(high > low, (high - low) / LEVELS, 1.0)
    whole = np.rint((flat - low) / step).astype(np.uint16)
    jumps = np.diff(whole, axis=0, prepend=np.uint16(0))  # modulo 65536, as the page adds them up
    return {"dtype": "d2", "shape": values.shape, "low": low.tolist(), "step": step.tolist(),
            "data": text_of(jumps.astype("<u2"))}  # fmt: skip


def rounded(values: np.ndarray) -> np.ndarray:
    """In float32 with the last 13 bits of the 23 zero: to 2^-11 of each value, at half the size."""
    bits = np.ascontiguousarray(values, np.float32).view(np.uint32)
    return ((bits + np.uint32(1 << 12)) & np.uint32(0xFFFFE000)).view(np.float32)


def text_of(array: np.ndarray) -> str:
    """The bytes of an array, the first ones of all numbers first."""
    planes = np.frombuffer(array.tobytes(), np.uint8).reshape(-1, array.itemsize).T
    return base64.b64encode(gzip.compress(planes.tobytes(), COMPRESSION, mtime=0)).decode()
