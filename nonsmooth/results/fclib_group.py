"""The datasets of an FCLIB file, each checked when it is asked for: dtype, shape, and that no index leaves its matrix.

A matrix is a group {m, n, nz, p, i, x}; fclib.py has the formats.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from nonsmooth.checks.memory import LEAST_CLAIM
from nonsmooth.errors import InvalidInput
from nonsmooth.results.forms import REAL, WHOLE, Form, Rule, require_forms
from nonsmooth.results.sparse_rows import compressed_rows, require_within

FORMATS = {"csc": -1, "csr": -2, "triplet": 0}  # 0 stands for the number of entries

LOCAL, GLOBAL = "fclib_local", "fclib_global"
MATRICES = {LOCAL: ("W", "V", "R"), GLOBAL: ("M", "H", "G")}
VECTORS = {LOCAL: ("q", "mu", "s"), GLOBAL: ("f", "w", "mu", "b")}
MATRIX = ("m", "n", "nz", "p", "i", "x")
NAMES = [
    "solution/r", f"{LOCAL}/info/description",
    *(f"{group}/spacedim" for group in MATRICES),
    *(f"{group}/{name}/{part}" for group, names in MATRICES.items() for name in names for part in MATRIX),
    *(f"{group}/vectors/{name}" for group, names in VECTORS.items() for name in names),
]  # fmt: skip
# derived: unknowns that no vector of the file counts: multipliers of bilateral constraints
MOST_MULTIPLIERS = LEAST_CLAIM // 8

Datasets = dict[str, np.ndarray]


def read_checked(data: Datasets, name: str, rule: Rule) -> np.ndarray:
    """A dataset with the dtype and the shape of a rule; KeyError where it is not there."""
    array = data[name]
    require_forms({name: Form(array.dtype.str, array.shape)}, {name: rule})
    return array


@dataclass(frozen=True)
class Group:
    """/fclib_local or /fclib_global."""

    data: Datasets
    name: str

    def has_matrix(self, name: str) -> bool:
        """Whether some part of a matrix is there."""
        return any(f"{self.name}/{name}/{part}" in self.data for part in MATRIX)

    def has_vector(self, name: str) -> bool:
        """Whether a vector is there."""
        return f"{self.name}/vectors/{name}" in self.data

    def vector(self, name: str) -> np.ndarray:
        """A vector of any length."""
        return read_checked(self.data, f"{self.name}/vectors/{name}", (REAL, ("n",)))

    def count(self, name: str) -> int:
        """A whole number, alone or as a vector of one."""
        ndim = self.data[f"{self.name}/{name}"].ndim
        return int(read_checked(self.data, f"{self.name}/{name}", (WHOLE, (1,) * ndim)).reshape(-1)[0])

    def matrix(self, name: str, shape: tuple[int | None, int | None]) -> Any:
        """A sparse matrix of this shape; None: of any size."""
        from scipy.sparse import coo_array, csr_array

        m, n = self._shape(name, shape)
        nz = self.count(f"{name}/nz")
        p, i, x = (read_checked(self.data, f"{self.name}/{name}/{part}", (dtypes, (part,)))
                   for part, dtypes in (("p", WHOLE), ("i", WHOLE), ("x", REAL)))  # fmt: skip
        if nz == FORMATS["csc"]:
            return csr_array(compressed_rows(x, i, p, (n, m)).T)
        if nz == FORMATS["csr"]:
            return compressed_rows(x, i, p, (m, n))
        if not 0 <= nz <= min(len(p), len(i), len(x)):
            raise InvalidInput(f"nz of an FCLIB matrix must be -2, -1 or a number of its triplets; got {nz}")
        require_within(i[:nz], m)
        require_within(p[:nz], n)
        return csr_array(coo_array((x[:nz], (i[:nz], p[:nz])), shape=(m, n)))  # i rows, p columns

    def _shape(self, name: str, wanted: tuple[int | None, int | None]) -> tuple[int, int]:
        m, n = self.count(f"{name}/m"), self.count(f"{name}/n")
        if not all(
            0 <= size <= MOST_MULTIPLIERS and rule in (None, size) for rule, size in zip(wanted, (m, n), strict=True)
        ):
            shown = ", ".join("any" if size is None else str(size) for size in wanted)
            raise InvalidInput(f"{name} must be a matrix of shape ({shown}); the file says ({m}, {n})")
        return m, n
