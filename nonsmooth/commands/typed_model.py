"""The model that a user names: one of `nonsmooth list`, or of a file, ``my.py:Rod``; with changed parameters."""

from __future__ import annotations

import argparse
from inspect import Parameter
from typing import TYPE_CHECKING, Any

from nonsmooth.catalogue.entries import load
from nonsmooth.catalogue.files import from_file, is_file
from nonsmooth.commands.typed_input import is_number, number_of, pairs
from nonsmooth.errors import InvalidInput, UnknownName
from nonsmooth.scenes.given import as_model

if TYPE_CHECKING:
    from nonsmooth.sweeps.axes import Axis

MODEL = (
    "a name of `nonsmooth list`, the FILE.toml, FILE.xml (MJCF) or FILE.urdf of a scene, or FILE.py:NAME, a class, an "
    "instance, a System, a Scene or a function"
)


def typed_model(arguments: argparse.Namespace, takes_scenes: bool = False) -> Any:
    """The model with its parameters changed; ``arguments.model`` is its plain name from then on. A scene is its system
    unless ``takes_scenes``.

    Raises
    ------
    UnknownName, InvalidInput
        For a name that is none, parameters that it does not have, and a scene without a system where one is needed.
    """
    changes = pairs("--set", arguments.set)
    if is_file(arguments.model):
        name, found = from_file(arguments.model, changes, parameter_of)
        arguments.model = name
    else:
        found = load(arguments.model)
    model = with_set(found, changes)
    return model if takes_scenes else as_model(model)


def require_units(model: Any, axes: list[Axis]) -> None:
    """Raise for an axis with another unit than the model's."""
    from nonsmooth.mechanics.model_system import as_system
    from nonsmooth.sweeps.axis_names import require_unit, unit_of

    system = as_system(model)
    for axis in axes:
        require_unit(axis.name, axis.unit, unit_of(system, axis.name))


def with_set(found: Any, changes: dict[str, str]) -> Any:
    """A class with its defaults, or an instance, with some parameters changed to what is typed."""
    from nonsmooth.mechanics.model_system import with_values
    from nonsmooth.mechanics.system import System
    from nonsmooth.scenes.given import is_scene_object

    model = made(found) if isinstance(found, type) else found
    if is_scene_object(model):
        if changes:
            name = next(iter(changes))
            raise UnknownName(f"there is no parameter {name!r}; a Scene has none, a class that builds it may have them")
        return model
    parameters = model.parameters if isinstance(model, System) else model
    values = {name: parameter_of(name, text, getattr(parameters, name, None)) for name, text in changes.items()}
    return with_values(model, values)


def parameter_of(name: str, text: str, before: Any) -> Any:
    """A parameter as it is typed: a text in place of a text, a number in place of a number.

    Where nothing is known of it, neither a value nor a default, it is a number where it can be read as one.
    """
    is_unknown = before is None or before is Parameter.empty
    if isinstance(before, str) or (is_unknown and not is_number(text)):
        return text
    return number_of("--set", name, text)


def made(cls: type) -> Any:
    """An instance of a class of models with its defaults."""
    try:
        return cls()
    except TypeError as error:
        raise InvalidInput(f"{cls.__name__} cannot be made without arguments: {error}; give its fields defaults, or "
                           "name an instance") from error  # fmt: skip


def is_scene(model: Any) -> bool:
    """Whether it is a scene of bodies, or what builds one."""
    from nonsmooth.mechanics.system import System
    from nonsmooth.scenes.given import is_scene_object

    return is_scene_object(model) or not (isinstance(model, System) or callable(getattr(model, "system", None)))
