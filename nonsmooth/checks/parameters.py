"""Parameters: the fields of a NamedTuple or dataclass that are numbers, and the same object with some of them changed.

What is a number is passed to the model functions as ``p``: a float, an array of floats, or a NamedTuple or dataclass of
such. Each number has a name, ``k``, ``k[2]``, ``K[0,1]`` or ``spring.k``, and a place in the vector that a compiled
model reads. What is declared int counts parts, and is no quantity.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from nonsmooth.checks.arrays import as_array, as_number
from nonsmooth.errors import InvalidInput, UnknownName, nearest, shown


def numeric_fields(parameters: Any, without: tuple[str, ...] = ()) -> dict[str, float]:
    """The numbers among the fields of a NamedTuple or dataclass, by name, in the order of the vector; without those of
    some fields.

    Raises
    ------
    InvalidInput
        For what is neither; for a number that no float holds, is complex or not finite.
    """
    return dict(_numbers("", parameters, without))


def constant_fields(parameters: Any) -> tuple[str, ...]:
    """The last fields of a class of parameters that it names as ``constants``: read as p, no parameters, and frozen."""
    return tuple(getattr(type(parameters), "constants", ()))


def layout_of(parameters: Any) -> tuple:
    """What ``p`` is made of, (name, kind) by field: None for a float, the shape of an array, the layout of a part."""
    return tuple((name, _kind(value)) for name, value in _fields(parameters).items() if _is_numeric(value))


def _kind(value: Any) -> tuple | None:
    if isinstance(value, np.ndarray) and value.ndim:
        return value.shape
    return layout_of(value) if _is_part(value) else None


def _numbers(path: str, parameters: Any, without: tuple[str, ...] = ()) -> Iterator[tuple[str, float]]:
    for field, value in _fields(parameters).items():
        name = path + field
        if field in without:
            continue
        if type(value) is float and math.isfinite(value):
            yield name, value
        elif _is_part(value):
            yield from _numbers(f"{name}.", value)
        elif isinstance(value, np.ndarray) and value.ndim:
            entries = as_array(f"the parameter {name}", value)
            for place in np.ndindex(entries.shape):
                yield f"{name}[{','.join(map(str, place))}]", float(entries[place])
        elif _is_numeric(value):
            yield name, as_number(f"the parameter {name}", value)


def _is_numeric(value: Any) -> bool:
    is_array = isinstance(value, np.ndarray) and value.dtype.kind in "biufcO"
    return isinstance(value, int | float | np.number) or is_array or _is_part(value)


def _is_part(value: Any) -> bool:
    """Whether a value is a NamedTuple or dataclass with numbers in it."""
    if isinstance(value, type) or not (hasattr(value, "_asdict") or hasattr(value, "__dataclass_fields__")):
        return False
    return any(_is_numeric(entry) for entry in _fields(value).values())


def _fields(parameters: Any) -> dict[str, Any]:
    """The fields of a NamedTuple or dataclass, or `InvalidInput`."""
    if isinstance(parameters, type):
        raise InvalidInput(
            f"parameters must be a NamedTuple or a dataclass; got the class {parameters.__name__}: call it first"
        )
    if hasattr(parameters, "_asdict"):
        return dict(parameters._asdict())
    if hasattr(parameters, "__dataclass_fields__"):
        return {name: getattr(parameters, name) for name in parameters.__dataclass_fields__}
    if isinstance(parameters, tuple) and not parameters:
        return {}
    raise InvalidInput(f"parameters must be a NamedTuple or a dataclass; got {type(parameters).__name__}")


def with_changes(parameters: Any, changes: dict[str, Any]) -> Any:
    """A NamedTuple or dataclass with some fields replaced, or numbers within them; what is int takes whole numbers.

    Raises
    ------
    UnknownName
        For a name that is no field; the message suggests the nearest.
    InvalidInput
        For a part of a whole, and for an array of another shape.
    """
    if not changes:
        return parameters
    is_tuple = hasattr(parameters, "_fields")
    known = parameters._fields if is_tuple else tuple(getattr(parameters, "__dataclass_fields__", ()))
    values: dict[str, Any] = {}
    for name, value in changes.items():
        if name in known:
            values[name] = _checked(name, getattr(parameters, name), value)
        else:
            field, inner = _split(parameters, name)
            values[field] = _changed_within(values.get(field, getattr(parameters, field)), inner, name, value)
    for name in whole_fields(parameters) & values.keys():
        if values[name] != int(values[name]):
            raise InvalidInput(f"the parameter {name} must be a whole number; got {values[name]:g}")
        values[name] = int(values[name])
    return parameters._replace(**values) if is_tuple else replace(parameters, **values)


def _checked(name: str, before: Any, value: Any) -> Any:
    """A new value of a field: a number for a number, an array of the same shape for an array."""
    if isinstance(before, np.ndarray) and before.ndim:
        array = as_array(f"the parameter {name}", value)
        if array.shape != before.shape:
            raise InvalidInput(f"the parameter {name} must have the shape {before.shape}; got {array.shape}")
        return array
    if _is_part(before):
        if not _is_part(value) or layout_of(value) != layout_of(before):
            raise InvalidInput(f"the parameter {name} must be a {type(before).__name__}; got {shown(value)}")
    elif _is_numeric(before):
        as_number(f"the parameter {name}", value)
    return value


def _split(parameters: Any, name: str) -> tuple[str, str]:
    """The field that the name of a number begins with, and what follows: ("spring", "k"), ("k", "2]")."""
    numbers = numeric_fields(parameters)
    if name not in numbers:
        known = {*numbers, *_fields(parameters)}
        raise UnknownName(f"there is no parameter {name!r}; {nearest(name, known)}")
    end = min(place for place in (name.find("."), name.find("[")) if place > 0)
    return name[:end], name[end + 1 :]


def _changed_within(value: Any, inner: str, name: str, number: Any) -> Any:
    """A part, or an array, with one of its numbers changed."""
    number = as_number(f"the parameter {name}", number)
    if not isinstance(value, np.ndarray):
        return with_changes(value, {inner: number})
    array = np.array(value, dtype=np.float64)
    array[tuple(int(index) for index in inner.rstrip("]").split(","))] = number
    return array


def whole_fields(parameters: Any) -> set[str]:
    """The fields of a dataclass that are declared int: numbers of parts, not quantities."""
    fields = getattr(parameters, "__dataclass_fields__", {})
    return {name for name, field in fields.items() if field.type in (int, "int")}
