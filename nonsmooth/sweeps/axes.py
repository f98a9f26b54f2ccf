"""The cells of a study: every combination of the values of its axes, or the rows of a table.

Cell number i stands at ``np.unravel_index(i, shape)``, the last axis running fastest.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from nonsmooth.checks.arrays import as_instance
from nonsmooth.errors import InvalidInput


@dataclass(frozen=True, eq=False)
class Axis:
    """One quantity that varies.

    Parameters
    ----------
    name : str
    values : array_like (k,)
        Finite numbers; or texts, for tasks that take them.
    unit : str
        What stands on figures; "": the task may know it.

    Raises
    ------
    InvalidInput
        For an axis that is empty, not a vector, or holds NaN or inf.
    """

    name: str
    values: np.ndarray
    unit: str = ""

    def __post_init__(self) -> None:
        as_instance("the name of an axis", self.name, str, "a text")
        as_instance(f"the unit of the axis {self.name}", self.unit, str, "a text")
        values = as_column(self.name, self.values)
        if values.size == 0:
            raise InvalidInput(f"the axis {self.name} must have at least one value; it is empty")
        object.__setattr__(self, "values", values)


@dataclass(frozen=True, eq=False)
class Plan:
    """Which cells a study has.

    Attributes
    ----------
    axes : tuple of Axis
        Their values differ; or the columns of a table, all of the same length, whose values may repeat.
    is_table : bool

    Raises
    ------
    InvalidInput
        For an axis that is given twice, or that holds a value twice.
    """

    axes: tuple[Axis, ...]
    is_table: bool = False

    def __post_init__(self) -> None:
        for name in self.names:
            if self.names.count(name) > 1:
                raise InvalidInput(f"the axis {name} is given twice; give it once")
        for axis in () if self.is_table else self.axes:
            unique, counts = np.unique(axis.values, return_counts=True)
            if (counts > 1).any():
                raise InvalidInput(
                    f"the values of the axis {axis.name} must differ; {unique[counts > 1][0]} stands there twice"
                )

    @property
    def names(self) -> tuple[str, ...]:
        """Those of the axes, in order."""
        return tuple(axis.name for axis in self.axes)

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the axes; of a table, its number of rows."""
        lengths = tuple(len(axis.values) for axis in self.axes)
        return lengths[:1] if self.is_table else lengths

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of the dimensions of the result."""
        return ("cell",) if self.is_table else self.names

    def __len__(self) -> int:
        return math.prod(self.shape)

    def columns(self, cells: np.ndarray) -> dict[str, np.ndarray]:
        """The value of every axis at the cells with these numbers."""
        places = np.unravel_index(cells, self.shape)
        if self.is_table:
            places = places * len(self.axes)
        return {axis.name: axis.values[place] for axis, place in zip(self.axes, places, strict=True)}


def as_column(name: str, values: Any) -> np.ndarray:
    """A vector of finite numbers or of texts, or `InvalidInput`."""
    try:
        array = np.array(values)
    except Exception:  # or whatever an object raises that is asked for its entries
        raise InvalidInput(f"the axis {name} must be a vector of values; its entries differ in length") from None
    if array.ndim != 1:
        raise InvalidInput(f"the axis {name} must be a vector of values; got shape {array.shape}")
    if array.dtype.kind in "US":
        return array
    if array.dtype.kind not in "bif":
        raise InvalidInput(f"the axis {name} must hold numbers or texts; got values of type {array.dtype}")
    wrong = np.flatnonzero(~np.isfinite(array))
    if wrong.size:
        raise InvalidInput(f"the axis {name} must be finite; {name}[{wrong[0]}] is {array[wrong[0]]}")
    return array


def as_plan(axes: Any) -> Plan:
    """The cells that the caller asked for.

    Parameters
    ----------
    axes : mapping, sequence of Axis, or table
        ``{name: values}`` or ``{name: (values, unit)}`` or a sequence of `Axis`: a grid. A pandas DataFrame, a
        structured array or a sequence of dicts: a table, one cell a row.
    """
    if isinstance(axes, Plan):
        return axes
    if isinstance(axes, Mapping):
        return as_plan([_axis(name, values) for name, values in axes.items()])
    if hasattr(axes, "columns") and hasattr(axes, "to_numpy"):
        return _table([(str(name), axes.iloc[:, k].to_numpy()) for k, name in enumerate(axes.columns)])
    if isinstance(axes, np.ndarray) and axes.dtype.names:
        return _table([(name, axes[name]) for name in axes.dtype.names])
    if not isinstance(axes, list | tuple) or not axes:
        raise InvalidInput(
            f"axes must be a mapping name -> values, a sequence of Axis or a table of rows; got {type(axes).__name__}"
            + (" without an entry" if isinstance(axes, list | tuple | Mapping) else "")
        )
    if all(isinstance(axis, Axis) for axis in axes):
        return Plan(tuple(axes))
    if all(isinstance(row, Mapping) for row in axes):
        return _table_of_rows(axes)
    raise InvalidInput("axes must be all Axis, or all rows {name: value} of a table; got a mixture")


def _axis(name: str, values: Any) -> Axis:
    if isinstance(values, Axis):
        return values
    if isinstance(values, tuple) and len(values) == 2 and isinstance(values[1], str) and not isinstance(values[0], str):
        return Axis(name, *values)
    return Axis(name, values)


def _table_of_rows(rows: Any) -> Plan:
    names = list(rows[0])
    for k, row in enumerate(rows):
        if list(row) != names:
            raise InvalidInput(f"every row of a table must have the columns {names}; row {k} has {list(row)}")
    return _table([(name, [row[name] for row in rows]) for name in names])


def _table(columns: list[tuple[str, Any]]) -> Plan:
    if not columns or not len(columns[0][1]):
        raise InvalidInput("a table must have at least one column and one row; it is empty")
    return Plan(tuple(Axis(name, values) for name, values in columns), is_table=True)
