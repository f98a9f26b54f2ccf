"""Models and ready scenes by name, found through entry-point groups so that users can register their own."""

from __future__ import annotations

import functools
import importlib
import importlib.util
import sys
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any

from nonsmooth.errors import InvalidInput, UnknownName, nearest, said_by

GROUP, SCENES = "nonsmooth.models", "nonsmooth.scenes"
OURS, SHIPPED = "models", "nonsmooth.catalogue.shipped"  # the two names of the folder of our models


def model_entries() -> dict[str, EntryPoint]:
    """The registered models by name."""
    return {entry.name: entry for entry in sorted(entry_points(group=GROUP), key=lambda entry: entry.name)}


def scene_entries() -> dict[str, EntryPoint]:
    """The registered scenes by name."""
    return {entry.name: entry for entry in sorted(entry_points(group=SCENES), key=lambda entry: entry.name)}


def entries_by_class() -> dict[str, EntryPoint]:
    """Models and scenes by the name of their class."""
    return {entry.attr: entry for entry in (*model_entries().values(), *scene_entries().values())}


def names() -> list[str]:
    """The names of the registered models and scenes, as `load` takes them.

    Examples
    --------
    >>> from nonsmooth.catalogue import names
    >>> "sprag-slip" in names()
    True
    """
    return [*model_entries(), *scene_entries()]


def load(name: str) -> Any:
    """The class of a registered model or scene.

    Parameters
    ----------
    name : str
        As `names` and ``nonsmooth list`` have it.

    Returns
    -------
    type
        The same class as in the package ``models``.

    Raises
    ------
    UnknownName
        When nothing of this name is registered; the message suggests the nearest.
    InvalidInput
        When it cannot be loaded.

    Examples
    --------
    >>> from nonsmooth.catalogue import SpragSlip, load
    >>> load("sprag-slip") is SpragSlip
    True
    """
    known = model_entries() | scene_entries()
    if not isinstance(name, str) or name not in known:
        raise UnknownName(f"there is no model {name!r}; {nearest(name, known)}")
    return load_entry(known[name])


def load_entry(entry: EntryPoint) -> Any:
    """What an entry point names."""
    method = "scene" if entry.group == SCENES else "system"
    try:
        model = getattr(importlib.import_module(module_of(entry)), entry.attr)
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # whatever the module of another package raises, sys.exit() included
        raise InvalidInput(f"{entry.name} could not be loaded from {entry.value}: {said_by(error)}") from error
    if not callable(getattr(model, method, None)):
        word = "model" if method == "system" else "scene"
        raise InvalidInput(f"{entry.name} could not be loaded: {entry.value} is no {word}, it has no {method}() method")
    return model


def module_of(entry: EntryPoint) -> str:
    """The module of an entry; of ours under the name by which it can be found."""
    package, _, rest = entry.module.partition(".")
    is_ours = entry.dist is not None and entry.dist.name == "nonsmooth" and package == OURS
    return f"{SHIPPED}.{rest}" if is_ours and not is_ours_in_sight() else entry.module


def is_ours_in_sight() -> bool:
    """Whether the name ``models`` leads to our folder, and to no file of the user's."""
    found = sys.modules.get(OURS)
    where = getattr(found, "__file__", None) if found is not None else _origin()
    return where is not None and Path(where).parent.resolve() == _folder()


def _origin() -> str | None:
    try:
        spec = importlib.util.find_spec(OURS)
    except ValueError:  # of a module that says nothing of itself
        return None
    return spec.origin if spec else None


@functools.cache
def _folder() -> Path:
    return (Path(__file__).parents[2] / "models").resolve()
