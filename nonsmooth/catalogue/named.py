"""Models by the names that files of runs have: where a model is, and its parameters.

A model is called by its entry point, or by the file and the name of its class or its `System`, ``my.py:Rod``. A name
in a file of numbers is no reason to run code: found are registered models, and those of modules that were imported.
"""

from __future__ import annotations

import dataclasses
import sys
import typing
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from nonsmooth.catalogue.entries import load, load_entry, model_entries
from nonsmooth.catalogue.files import from_file, is_file, split
from nonsmooth.errors import InvalidInput, said_by, shown
from nonsmooth.mechanics.model_system import as_system
from nonsmooth.mechanics.system import System

Named = dict[str, Any]  # "place": text; "fields" of a class of models, or "parameters" of a System, by name


def name_model(system: System) -> Named | None:
    """What the model of a system is called, with its parameters; None where nothing leads to it."""
    model = system.parameters
    if callable(getattr(type(model), "system", None)):
        place, fields = _place_of_class(type(model)), _plain_fields(model)
        if place is None or fields is None or not _is_same(as_system(model), system):
            return None
        return {"place": place, "fields": fields}
    place = _place_of_system(system)
    return None if place is None else {"place": place, "parameters": dict(system.parameter_values)}


def find_model(named: Named, given: Any = None) -> System:
    """The system that a file names, or the one that was given in its place, with the parameters of the file.

    Raises
    ------
    InvalidInput
        Where it is not found, or cannot be made; the message says what is the matter.
    """
    value = _value_of(named["place"]) if given is None else _as_value(given)
    if isinstance(value, type):
        return as_system(_made(value, named.get("fields") or {}))
    if given is not None and not isinstance(given, str):
        return as_system(value)
    if isinstance(value, System):
        return value.with_parameters(**named.get("parameters") or {})
    return as_system(_made(type(value), named.get("fields") or {}))


def _as_value(given: Any) -> Any:
    if not isinstance(given, str):
        return given
    return from_file(given)[1] if is_file(given) else load(given)


def _value_of(place: str) -> Any:
    """What a file of a run names, without running anything for it."""
    if not is_file(place):
        return load(place)
    path, name = split(place)
    for module in [*sys.modules.values()]:
        if _file_of(module) == path and hasattr(module, name):
            return getattr(module, name)
    raise InvalidInput(
        f"its model is {place}, and no file is run for the name that stands in another: import it before, or give "
        f"load(..., model={place!r})"
    )


def _file_of(module: Any) -> str | None:
    file = getattr(module, "__file__", None) if isinstance(module, ModuleType) else None
    return str(Path(file).resolve()) if isinstance(file, str) else None


def _place_of_class(cls: type) -> str | None:
    for entry in model_entries().values():
        if entry.attr == cls.__name__ and load_entry(entry) is cls:
            return entry.name
    module = sys.modules.get(cls.__module__)
    file = _file_of(module)
    return f"{file}:{cls.__name__}" if file and getattr(module, cls.__name__, None) is cls else None


def _place_of_system(system: System) -> str | None:
    """The file and the name of a System, or of one that differs from it in its parameters alone."""
    systems = [
        (module, name, value)
        for where, module in [*sys.modules.items()]
        if isinstance(module, ModuleType) and not where.startswith(("nonsmooth.", "numpy"))
        for name, value in [*vars(module).items()]
        if isinstance(value, System)
    ]
    for is_it in (lambda value: value is system, lambda value: _is_same(value, system)):
        for module, name, value in systems:
            if is_it(value) and (file := _file_of(module)):
                return f"{file}:{name}"
    return None


def _is_same(one: System, other: System) -> bool:
    """Whether two systems have the same functions, contacts and names."""
    names = [field.name for field in dataclasses.fields(System) if field.init and field.name != "parameters"]
    if any(getattr(one, name) is not getattr(other, name) and getattr(one, name) != getattr(other, name)
           for name in names):  # fmt: skip
        return False
    return list(one.numbers) == list(other.numbers)


def _plain_fields(model: Any) -> Named | None:
    """The fields of a model as JSON holds them; None where one is no number, text, array or part of such."""
    try:
        return {name: _plain(getattr(model, name)) for name in _field_names(model)}
    except TypeError:
        return None


def _field_names(model: Any) -> tuple[str, ...]:
    if hasattr(model, "_fields"):
        return tuple(model._fields)
    return tuple(field.name for field in dataclasses.fields(model) if field.init)


def _plain(value: Any) -> Any:
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return {"array": value.tolist()}
    if hasattr(value, "_fields") or dataclasses.is_dataclass(value):
        return {"part": {name: _plain(getattr(value, name)) for name in _field_names(value)}}
    if isinstance(value, tuple | list):
        return [_plain(entry) for entry in value]
    raise TypeError(shown(value))


def _made(cls: type, fields: Named) -> Any:
    """A model of a class with these fields."""
    try:
        hints = typing.get_type_hints(cls)
        return cls(**{name: _value(value, hints.get(name)) for name, value in fields.items()})
    except Exception as error:  # whatever the user's class raises
        raise InvalidInput(f"{cls.__name__} cannot be made of the parameters in the file: {said_by(error)}") from error


def _value(value: Any, hint: Any) -> Any:
    if isinstance(value, dict):
        return np.array(value["array"]) if "array" in value else _made(hint, value["part"])
    return tuple(_value(entry, None) for entry in value) if isinstance(value, list) else value
