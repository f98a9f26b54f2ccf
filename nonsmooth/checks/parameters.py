"""Parameters: the fields of a NamedTuple or dataclass that are numbers, and the same object with some of them changed.

What is a number is passed to the model functions as ``p``; what is declared int counts parts, and is no quantity.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.checks.arrays import as_number
from nonsmooth.errors import InvalidInput, UnknownName, nearest


def numeric_fields(parameters: Any) -> dict[str, float]:
    """The fields of a NamedTuple or dataclass whose values are numbers.

    Raises
    ------
    InvalidInput
        For what is neither; for a number that no float holds, is complex or not finite.
    """
    if isinstance(parameters, type):
        raise InvalidInput(
            f"parameters must be a NamedTuple or a dataclass; got the class {parameters.__name__}: call it first"
        )
    if hasattr(parameters, "_asdict"):
        values = parameters._asdict()
    elif hasattr(parameters, "__dataclass_fields__"):
        values = {name: getattr(parameters, name) for name in parameters.__dataclass_fields__}
    elif isinstance(parameters, tuple) and not parameters:
        values = {}
    else:
        raise InvalidInput(f"parameters must be a NamedTuple or a dataclass; got {type(parameters).__name__}")
    numbers = {name: value for name, value in values.items() if isinstance(value, int | float | np.number)}
    return {
        name: value if type(value) is float and math.isfinite(value) else as_number(f"the parameter {name}", value)
        for name, value in numbers.items()
    }


def with_changes(parameters: Any, changes: dict[str, Any]) -> Any:
    """A NamedTuple or dataclass with some fields replaced; a field declared int takes whole numbers only.

    Raises
    ------
    UnknownName
        For a name that is no field; the message suggests the nearest.
    InvalidInput
        For a part of a whole.
    """
    is_tuple = hasattr(parameters, "_fields")
    known = parameters._fields if is_tuple else tuple(getattr(parameters, "__dataclass_fields__", ()))
    for name in changes:
        if name not in known:
            raise UnknownName(f"there is no parameter {name!r}; {nearest(name, known)}")
        if name in numeric_fields(parameters):
            as_number(f"the parameter {name}", changes[name])
    values = dict(changes)
    for name in whole_fields(parameters) & values.keys():
        if values[name] != int(values[name]):
            raise InvalidInput(f"the parameter {name} must be a whole number; got {values[name]:g}")
        values[name] = int(values[name])
    return parameters._replace(**values) if is_tuple else replace(parameters, **values)


def whole_fields(parameters: Any) -> set[str]:
    """The fields of a dataclass that are declared int: numbers of parts, not quantities."""
    fields = getattr(parameters, "__dataclass_fields__", {})
    return {name for name, field in fields.items() if field.type in (int, "int")}


@functools.cache
def parameter_tuple(names: tuple[str, ...]) -> Callable:
    """The NamedTuple class with these fields, one for each set of names."""
    return NamedTuple("Parameters", [(name, float) for name in names])  # type: ignore[misc,return-value]
