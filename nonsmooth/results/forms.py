"""Forms: which arrays a file must hold, said in a table of dtypes, and of shapes in letters that all arrays share.

    {"M": (REAL, ("n", "n")), "q": (REAL, ("n",)), "is_comp": (FLAG, ("n",))}

Nothing is cast but whole numbers to longer ones: a matrix that stands in a file as integers or with 7 digits may be
what was meant, or what a program lost on its way; who wrote it knows, and can write it as float64.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

REAL = ("<f8",)
WHOLE = ("<i4", "<i8")
FLAG = ("|b1", *WHOLE)
NAMES = {REAL: "float64", WHOLE: "int32 or int64", FLAG: "bool, int32 or int64"}

Size = str | int
Rule = tuple[tuple[str, ...], tuple[Size, ...]]


class Form(NamedTuple):
    """What the header of an array says: dtype as NumPy writes it ("<f8"), and shape."""

    dtype: str
    shape: tuple[int, ...]

    @property
    def size(self) -> int:
        """Bytes; a Python integer, which does not overflow."""
        return np.dtype(self.dtype).itemsize * math.prod(self.shape)


def require_forms(forms: Mapping[str, Form], rules: Mapping[str, Rule]) -> dict[str, int]:
    """Raise `ValueError` unless the arrays of the rules are there with their dtypes and shapes; the sizes by letter."""
    missing = sorted(rules.keys() - forms.keys())
    if missing:
        raise ValueError(f"it has no {missing[0]}")
    sizes: dict[str, int] = {}
    for name, (dtypes, shape) in rules.items():
        form = forms[name]
        if form.dtype not in dtypes:
            raise ValueError(f"{name} must be {NAMES[dtypes]}; it is {np.dtype(form.dtype).name} ({form.dtype})")
        if len(form.shape) != len(shape):
            raise ValueError(f"{name} must have the shape ({_shown(shape, sizes)}); it has {form.shape}")
        for wanted, size in zip(shape, form.shape, strict=True):
            if size != (sizes.setdefault(wanted, size) if isinstance(wanted, str) else wanted):
                raise ValueError(f"{name} must have the shape ({_shown(shape, sizes)}); it has {form.shape}")
    for symbol, size in sizes.items():
        parts = [int(part) if part.isdigit() else sizes.get(part, -1) for part in symbol.split(" + ")]
        if min(parts) >= 0 and size != sum(parts):
            name = next(name for name, (_, shape) in rules.items() if symbol in shape)
            raise ValueError(f"{name} must have {symbol} = {sum(parts)} entries; it has {size}")
    return sizes


def _shown(shape: tuple[Size, ...], sizes: Mapping[str, int]) -> str:
    return ", ".join(f"{size} = {sizes[size]}" if size in sizes else str(size) for size in shape)  # type: ignore[index]
